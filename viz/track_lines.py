"""Flights of particles as lines, cut to what a picture shows, with the weight and the age that each has."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from transport.analysis.tracks import Tracks
from transport.viz.facets import Bounds
from transport.viz.solids import segments

if TYPE_CHECKING:
    import pyvista

EVEN = 1.01  # a range of weights or ages below it is one colour


def track_lines(tracks: Tracks, bounds: Bounds) -> pyvista.PolyData:
    """Each flight's part in the box, a line [m]; cell arrays "weight", "age" [m] (half-way) and "history"."""
    first, last = clipped(tracks, bounds)
    inside = np.flatnonzero(first < last)
    starts, ways = tracks.starts[inside], tracks.directions[inside]
    lines = segments(starts + first[inside, None] * ways, starts + last[inside, None] * ways)
    lines.cell_data["weight"] = tracks.weights[inside]
    lines.cell_data["age"] = tracks.ages[inside] + (first[inside] + last[inside]) / 2
    lines.field_data["unit of age"] = ["m"]
    lines.cell_data["history"] = tracks.histories[inside].astype(np.int64)
    return lines


def clipped(tracks: Tracks, bounds: Bounds) -> tuple[np.ndarray, np.ndarray]:
    """From where to where along each flight [m] it is in the box; the first is not below the last where it is not."""
    first, last = np.zeros(len(tracks)), tracks.lengths.copy()
    for axis, (low, high) in enumerate(zip(*bounds, strict=True)):
        here, way = tracks.starts[:, axis], tracks.directions[:, axis]
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = (low - here) / way, (high - here) / way
        is_across = way == 0
        is_out = is_across & ((here < low) | (here > high))
        first = np.where(is_across, first, np.fmax(first, np.fmin(one, other)))
        last = np.where(is_across, last, np.fmin(last, np.fmax(one, other)))
        last = np.where(is_out, -1.0, last)
    return first, last


def told_by(lines: pyvista.PolyData) -> str | None:
    """What colours the lines best: "weight" where it differs, else "age" where it does, else None."""
    for name in ("weight", "age"):
        values = lines.cell_data[name]
        known = values[values > 0]
        if len(known) and known.max() > EVEN * known.min():
            return name
    return None
