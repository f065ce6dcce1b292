"""Estimates along one axis as a small SVG: a bar per bin, with a whisker of two standard errors."""

from __future__ import annotations

import math

import numpy as np

from transport.html.gathering import gathered, gathered_edges
from transport.html.scales import Scale, scale_of
from transport.html.typesetting import plain_typeset
from transport.html.words import axis_words, place_text

FILL = "#3b8ec2"  # of equal contrast to white and to black
PALE = ' opacity=".4"'
MOST_BARS = 128
WIDTH, HEIGHT, LEFT, TOP, BELOW = 400, 110, 8, 18, 18


def bars(value: np.ndarray, error: np.ndarray, name: str, edges: np.ndarray, unit: str) -> str:
    """The bar chart as SVG; a bar with unknown error is pale and has no whisker.

    value, error: (n,);  edges: (n + 1,), or n instants.
    """
    means, (size,) = gathered(value, (MOST_BARS,))
    errors, _ = gathered(np.where(np.isfinite(value), error, np.nan), (MOST_BARS,))
    scale = scale_of(
        np.concatenate([means - 2 * np.nan_to_num(errors), means + 2 * np.nan_to_num(errors)]), means
    )
    places = _places(gathered_edges(edges, len(value), size), len(means))
    drawn = [
        _bar(scale, *places[k : k + 2], means[k], errors[k])
        for k in range(len(means))
        if np.isfinite(means[k])
    ]
    ends = [(LEFT, "start", place_text(name, edges[0])), (LEFT + WIDTH, "end", place_text(name, edges[-1]))]
    middle = (LEFT + WIDTH / 2, "middle", axis_words(name))
    top = f"{plain_typeset(f'{scale.high:.4g}')}{f' {plain_typeset(unit)}' if unit != '1' else ''}"
    note = plain_typeset(f", by decades from {scale.low:.0e}") if scale.is_log else ""
    blocks = f"; each bar is the mean of {size} bins, its whisker that of single bins" if size > 1 else ""
    lines = [
        f'<svg width="{WIDTH + 2 * LEFT}" height="{TOP + HEIGHT + BELOW}" role="img" fill="currentColor"'
        ' font-size="11"'
        f' viewBox="0 0 {WIDTH + 2 * LEFT} {TOP + HEIGHT + BELOW}">',
        f"<title>bars: estimates; whiskers: ± 2 standard errors{blocks}</title>",
        _text(LEFT, 12, "start", f"{top}{note}"),
        *drawn,
        _base(scale),
        *(_text(x, TOP + HEIGHT + 14, anchor, words) for x, anchor, words in (*ends, middle)),
        "</svg>",
    ]
    return "".join(lines)


def thumbnail(value: np.ndarray, edges: np.ndarray) -> str:
    """The bars alone, as high as a line of text."""
    means, (size,) = gathered(value, (MOST_BARS,))
    scale = scale_of(means, means)
    places = _places(gathered_edges(edges, len(value), size), len(means)) / WIDTH
    base = scale.place(0.0)
    drawn = []
    for k in np.flatnonzero(np.isfinite(means)):
        y = scale.place(means[k])
        x, width = 110 * (places[k] - LEFT / WIDTH), 110 * (places[k + 1] - places[k])
        drawn.append(
            f'<rect x="{x:.1f}" y="{20 * (1 - max(y, base)):.1f}" width="{max(width - 0.3, 0.3):.1f}"'
            f' height="{20 * abs(y - base):.1f}"/>'
        )
    return f'<svg width="110" height="20" role="img" fill="{FILL}">{"".join(drawn)}</svg>'


def _bar(scale: Scale, left: float, right: float, value: float, error: float) -> str:
    base, top = (TOP + HEIGHT * (1 - scale.place(y)) for y in (0.0, value))
    is_known = np.isfinite(error)
    bar = (
        f'<rect x="{left:.1f}" y="{min(base, top):.1f}" width="{max(right - left - 0.6, 0.4):.1f}"'
        f' height="{abs(base - top):.1f}" fill="{FILL}"{"" if is_known else PALE}/>'
    )
    if not is_known or error == 0:
        return bar
    x, low, high = (
        0.5 * (left + right),
        *(TOP + HEIGHT * (1 - scale.place(value + k * error)) for k in (-2, 2)),
    )
    return bar + f'<path d="M{x:.1f} {low:.1f}V{high:.1f}" stroke="currentColor" stroke-width="1.2"/>'


def _base(scale: Scale) -> str:
    y = TOP + HEIGHT * (1 - scale.place(0.0))
    return f'<path d="M{LEFT} {y:.1f}H{LEFT + WIDTH}" stroke="currentColor" stroke-width="1" opacity=".5"/>'


def _places(edges: np.ndarray, bars: int) -> np.ndarray:
    """Left and right ends of the bars.

    Those of the bins, or even ones if bins have no width or are infinite.
    """
    edges = edges if len(edges) == bars + 1 and np.isfinite(edges).all() else np.arange(bars + 1.0)
    span = edges[-1] - edges[0]
    return LEFT + WIDTH * (edges - edges[0]) / (span if span > 0 and math.isfinite(span) else 1.0)


def _text(x: float, y: float, anchor: str, words: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{words}</text>'
