"""Tracks in a notebook.

Numbers of flights, and the paths of some particles as lines projected along one axis.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from transport.html.bars import FILL
from transport.html.elements import beside, framed, heading, table
from transport.html.typesetting import escaped, plain_typeset, typeset

if TYPE_CHECKING:
    from transport.tracks import Tracks

MOST_FLIGHTS = 400  # in the picture
SIZE, LEFT = 200, 6  # pixels
FLAT = 0.02  # of the largest extent, below which an axis is not shown
FRINGE = 0.01  # share of the points at either end that may lie outside the picture
STEPS = 4  # of opacity, by weight


def tracks_html(tracks: Tracks) -> str:
    """Numbers of flights, and a picture of the first ones."""
    if not len(tracks):
        return framed(heading("Tracks", "of no particle"))
    particles = len(np.unique(tracks.histories))
    flies_off = int(np.count_nonzero(~np.isfinite(tracks.lengths)))
    ways = tracks.lengths[np.isfinite(tracks.lengths)]
    rows = [
        ["particles", f">{particles}"],
        ["flights", f">{len(tracks)}"],
        ["end at a surface", f">{int(np.count_nonzero(tracks.meets))}"],
        ["leave the scene", f">{flies_off}"],
        *([["median length", f">{typeset(f'{np.median(ways):.3g} m')}"]] if ways.size else []),
    ]
    return framed(
        heading("Tracks", escaped(repr(tracks).strip("<>").removeprefix("Tracks "))),
        beside(_picture(tracks), table(rows)),
    )


def _picture(tracks: Tracks) -> str:
    """The first flights, projected along one axis."""
    count = min(len(tracks), MOST_FLIGHTS)
    starts = tracks.starts[:count]
    finite = np.isfinite(tracks.lengths[:count])
    within = np.concatenate([starts, tracks.ends(0.0)[:count][finite]])
    low, high = np.quantile(within, [FRINGE, 1 - FRINGE], axis=0)
    span = float((high - low).max()) or 1.0
    ends = tracks.ends(0.25 * span)[:count]
    across, up = _plane(high - low)
    middle, scale = 0.5 * (low + high)[[across, up]], SIZE / (1.25 * span)
    here, there = (_place(points[:, [across, up]], middle, scale) for points in (starts, ends))
    shares = np.clip(tracks.weights[:count] / max(tracks.weights[:count].max(), 1e-300), 0, 1)
    steps = np.ceil(shares * STEPS).astype(int)
    paths = [
        f'<path d="{_lines(here[steps == step], there[steps == step])}"'
        f' opacity="{0.15 + 0.5 * step / STEPS:.2f}"/>'
        for step in range(1, STEPS + 1)
        if (steps == step).any()
    ]
    axes = "xyz"[across], "xyz"[up]
    label = plain_typeset(f"{axes[0]} to the right, {axes[1]} up, {1.25 * span:.3g} m across")
    return (
        f'<svg width="{SIZE + 2 * LEFT}" height="{SIZE + 20}" role="img" fill="currentColor" font-size="11"'
        f' viewBox="0 0 {SIZE + 2 * LEFT} {SIZE + 20}"><title>the first {count} flights, paler for smaller'
        f' weight</title><svg x="{LEFT}" y="0" width="{SIZE}" height="{SIZE}" viewBox="0 0 {SIZE} {SIZE}"'
        f' style="overflow:hidden"><g fill="none" stroke="{FILL}" stroke-width="0.8">{"".join(paths)}</g>'
        "</svg>"
        f'<rect x="{LEFT}" y="0" width="{SIZE}" height="{SIZE}" fill="none" stroke="currentColor"'
        ' opacity=".35"/>'
        f'<text x="{LEFT}" y="{SIZE + 14}">{label}</text></svg>'
    )


def _plane(extents: np.ndarray) -> tuple[int, int]:
    """The two axes across and up: z is up, unless flights hardly extend along it."""
    if extents[2] < FLAT * extents.max():
        return 0, 1
    return (0 if extents[0] >= extents[1] else 1), 2


def _place(points: np.ndarray, middle: np.ndarray, scale: float) -> np.ndarray:
    """Positions in pixels, with the second axis upwards."""
    return SIZE / 2 + (points - middle) * scale * np.array([1.0, -1.0])


def _lines(here: np.ndarray, there: np.ndarray) -> str:
    return "".join(
        f"M{a:.1f} {b:.1f}L{c:.1f} {d:.1f}"
        for (a, b), (c, d) in zip(here.tolist(), there.tolist(), strict=True)
    )
