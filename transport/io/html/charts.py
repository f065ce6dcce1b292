"""Estimates along one axis as a small SVG: a bar per bin, with a whisker of two standard errors."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from transport.io.html.elements import plain_typeset
from transport.statistics.axes import axis_symbol, axis_unit

# ---- Reduce many bins to the few that fit into a small picture: each block of whole bins is their mean.


def block_means(numbers: np.ndarray, most: tuple[int, ...]) -> tuple[np.ndarray, tuple[int, ...]]:
    """Means over blocks of bins, at most `most` blocks along each axis, and the bins per block along each.

    Values that are not finite are left out; a block of only such values is nan.  The last block may be
    smaller.
    """
    sizes = tuple(math.ceil(n / m) for n, m in zip(numbers.shape, most, strict=True))
    if all(size == 1 for size in sizes):
        return numbers, sizes
    known = np.isfinite(numbers)
    total, count = np.where(known, numbers, 0.0), known.astype(float)
    for axis, size in enumerate(sizes):
        starts = np.arange(0, numbers.shape[axis], size)
        total, count = np.add.reduceat(total, starts, axis), np.add.reduceat(count, starts, axis)
    with np.errstate(invalid="ignore", divide="ignore"):
        return total / count, sizes


def block_edges(edges: np.ndarray, bins: int, size: int) -> np.ndarray:
    """Edges of the blocks; for instants, of which there are as many as bins, the first one of each block."""
    return np.append(edges[:bins:size], edges[bins:])


# ---- From values to positions in a small picture: linear from zero, or logarithmic over decades.

LOGARITHMIC_RATIO = 1e3  # ratio of the largest to the smallest value, above which the scale is logarithmic
MAX_DECADES = 15  # shown at most


@dataclass(frozen=True)
class Scale:
    """A scale from `low` to `high` [unit]; if `is_log` it is logarithmic, and values up to 0 are at `low`."""

    low: float
    high: float
    is_log: bool

    def place(self, value: float) -> float:
        """Position of the value, 0 to 1."""
        if not self.is_log:
            return min(max((value - self.low) / (self.high - self.low), 0.0), 1.0)
        return min(max(math.log(max(value, self.low) / self.low) / math.log(self.high / self.low), 0.0), 1.0)


def scale_of(reached: np.ndarray, values: np.ndarray) -> Scale:
    """A scale that covers `reached` and zero, or the decades of the values if none is negative."""
    known, values = reached[np.isfinite(reached)], values[np.isfinite(values)]
    low, high = (min(known.min(), 0.0), max(known.max(), 0.0)) if known.size else (0.0, 0.0)
    positive = values[values > 0]
    if positive.size and not (values < 0).any() and positive.min() * LOGARITHMIC_RATIO < positive.max():
        top = 10.0 ** math.ceil(math.log10(high) - 1e-9)
        bottom = 10.0 ** math.floor(math.log10(positive.min()) + 1e-9)
        return Scale(max(bottom, top * 10.0**-MAX_DECADES), top, True)
    if values.size and not (values < 0).any():
        low = 0.0
    return Scale(float(low), float(high), False) if high > low else Scale(0.0, 1.0, False)


# ---- Labels of axes and positions of bins, in a few words.


def axis_label(name: str) -> str:
    """The label of an axis, with its unit if it has one: "φ [°]", "time [s]"."""
    unit = "°" if _is_angle(name) else axis_unit(name, {}) or "1"
    return plain_typeset(axis_symbol(name)) + (f" [{plain_typeset(unit)}]" if unit != "1" else "")


def position_text(name: str, place: float) -> str:
    """A position on the axis as a number; angles in degrees."""
    number = math.degrees(place) if _is_angle(name) else float(place)
    return plain_typeset(f"{number + 0.0:.4g}")


def _is_angle(name: str) -> bool:
    return axis_unit(name, {}) == "rad"


def bin_range_text(name: str, edges: np.ndarray, number: int, bins: int) -> str:
    """The range of a bin, "0.5 … 0.6", or its instant."""
    if len(edges) == bins:
        return position_text(name, edges[number])
    return f"{position_text(name, edges[number])} … {position_text(name, edges[number + 1])}"


# ---- The chart: a bar per bin, with a whisker of two standard errors.

BAR_COLOUR = "#3b8ec2"  # of equal contrast to white and to black
UNKNOWN_OPACITY = ' opacity=".4"'
MAX_BARS = 128
WIDTH, HEIGHT, LEFT, TOP, BELOW = 400, 110, 8, 18, 18


def bar_chart(value: np.ndarray, error: np.ndarray, name: str, edges: np.ndarray, unit: str) -> str:
    """The bar chart as SVG; a bar with unknown error is pale and has no whisker.

    value, error: (n,);  edges: (n + 1,), or n instants.
    """
    means, (size,) = block_means(value, (MAX_BARS,))
    errors, _ = block_means(np.where(np.isfinite(value), error, np.nan), (MAX_BARS,))
    reach = 2 * np.nan_to_num(errors)
    scale = scale_of(np.concatenate([means - reach, means + reach]), means)
    places = _bar_edges(block_edges(edges, len(value), size), len(means))
    known = np.flatnonzero(np.isfinite(means))
    drawn = [_bar(scale, *places[k : k + 2], means[k], errors[k]) for k in known]
    low, high = (position_text(name, edge) for edge in (edges[0], edges[-1]))
    ends = (LEFT, "start", low), (LEFT + WIDTH, "end", high)
    middle = (LEFT + WIDTH / 2, "middle", axis_label(name))
    top = f"{plain_typeset(f'{scale.high:.4g}')}{f' {plain_typeset(unit)}' if unit != '1' else ''}"
    note = plain_typeset(f", by decades from {scale.low:.0e}") if scale.is_log else ""
    blocks = f"; each bar is the mean of {size} bins, its whisker that of single bins" if size > 1 else ""
    lines = [
        f'<svg width="{WIDTH + 2 * LEFT}" height="{TOP + HEIGHT + BELOW}" role="img" fill="currentColor"'
        ' font-size="11"'
        f' viewBox="0 0 {WIDTH + 2 * LEFT} {TOP + HEIGHT + BELOW}">',
        f"<title>bars: estimates; whiskers: ± 2 standard errors{blocks}</title>",
        svg_text(LEFT, 12, "start", f"{top}{note}"),
        *drawn,
        _base(scale),
        *(svg_text(x, TOP + HEIGHT + 14, anchor, words) for x, anchor, words in (*ends, middle)),
        "</svg>",
    ]
    return "".join(lines)


def bar_thumbnail(value: np.ndarray, edges: np.ndarray) -> str:
    """The bars alone, as high as a line of text."""
    means, (size,) = block_means(value, (MAX_BARS,))
    scale = scale_of(means, means)
    places = _bar_edges(block_edges(edges, len(value), size), len(means)) / WIDTH
    base = scale.place(0.0)
    drawn = []
    for k in np.flatnonzero(np.isfinite(means)):
        y = scale.place(means[k])
        x, width = 110 * (places[k] - LEFT / WIDTH), 110 * (places[k + 1] - places[k])
        drawn.append(
            f'<rect x="{x:.1f}" y="{20 * (1 - max(y, base)):.1f}" width="{max(width - 0.3, 0.3):.1f}"'
            f' height="{20 * abs(y - base):.1f}"/>'
        )
    return f'<svg width="110" height="20" role="img" fill="{BAR_COLOUR}">{"".join(drawn)}</svg>'


def _bar(scale: Scale, left: float, right: float, value: float, error: float) -> str:
    base, top = (TOP + HEIGHT * (1 - scale.place(y)) for y in (0.0, value))
    is_known = np.isfinite(error)
    bar = (
        f'<rect x="{left:.1f}" y="{min(base, top):.1f}" width="{max(right - left - 0.6, 0.4):.1f}"'
        f' height="{abs(base - top):.1f}" fill="{BAR_COLOUR}"{"" if is_known else UNKNOWN_OPACITY}/>'
    )
    if not is_known or error == 0:
        return bar
    x = 0.5 * (left + right)
    low, high = (TOP + HEIGHT * (1 - scale.place(value + k * error)) for k in (-2, 2))
    return bar + f'<path d="M{x:.1f} {low:.1f}V{high:.1f}" stroke="currentColor" stroke-width="1.2"/>'


def _base(scale: Scale) -> str:
    y = TOP + HEIGHT * (1 - scale.place(0.0))
    return f'<path d="M{LEFT} {y:.1f}H{LEFT + WIDTH}" stroke="currentColor" stroke-width="1" opacity=".5"/>'


def _bar_edges(edges: np.ndarray, bars: int) -> np.ndarray:
    """Left and right ends of the bars.

    Those of the bins, or even ones if bins have no width or are infinite.
    """
    edges = edges if len(edges) == bars + 1 and np.isfinite(edges).all() else np.arange(bars + 1.0)
    span = edges[-1] - edges[0]
    return LEFT + WIDTH * (edges - edges[0]) / (span if span > 0 and math.isfinite(span) else 1.0)


def svg_text(x: float, y: float, anchor: str, words: str) -> str:
    """A text in an SVG; anchor: "start", "middle" or "end"."""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{words}</text>'
