"""Estimates in a notebook: their text, and for an array a picture and some bins."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from transport.io.html.elements import (
    code,
    escaped,
    framed,
    heading,
    muted,
    plain_typeset,
    side_by_side,
    table,
    typeset,
    warning_boxes,
)
from transport.io.html.pictures import array_image
from transport.results.phase_space import SnapshotReading
from transport.statistics.axes import axis_symbol, axis_unit
from transport.statistics.estimates import Estimate, EstimateArray

if TYPE_CHECKING:
    from transport.results.tally import Tally


# ---- Labels of axes and positions of bins, in a few words.


def axis_label(name: str, units: Mapping[str, str]) -> str:
    """The label of an axis, with its unit if it has one: "φ [°]", "time [s]"."""
    unit = axis_unit(name, units) or "1"
    unit = "°" if unit == "rad" else unit
    return plain_typeset(axis_symbol(name)) + (f" [{plain_typeset(unit)}]" if unit != "1" else "")


def position_text(place: float, unit: str) -> str:
    """A position on an axis as a number; angles in degrees."""
    number = math.degrees(place) if unit == "rad" else float(place)
    return plain_typeset(f"{number + 0.0:.4g}")


def bin_range_text(edges: np.ndarray, unit: str, number: int, bins: int) -> str:
    """The range of a bin, "0.5 … 0.6", or its instant."""
    if len(edges) == bins:
        return position_text(edges[number], unit)
    return f"{position_text(edges[number], unit)} … {position_text(edges[number + 1], unit)}"


# ---- Estimates and arrays.

MAX_LISTED_BINS = 8  # bins that are all listed


def estimate_html(estimate: Estimate) -> str:
    """The estimate in one line."""
    batches = "" if estimate.exact else f" {muted(f'{estimate.batches} batches')}"
    return framed(_in_line(estimate), batches)


def array_html(array: EstimateArray) -> str:
    """The range of an array, a picture of it, and some of its bins."""
    cut, where = _largest_slice(array)
    seen = f"<div>{muted(f'slice shown where {where}')}</div>" if where else ""
    return framed(
        heading(type(array).__name__, array_summary(array)),
        seen,
        side_by_side("" if cut is None else array_image(cut), _bins_table(cut)),
    )


def array_summary(array: EstimateArray) -> str:
    """The axes and the range of an array, as in its text."""
    return f"<span>{typeset(repr(array).strip('<>').partition(' ')[2])}</span>"


def _largest_slice(array: EstimateArray) -> tuple[EstimateArray | None, str]:
    """Slice of the two longest axes through the largest value, and its position in HTML."""
    if 0 in array.shape:
        return None, ""
    order = sorted(range(len(array.shape)), key=lambda axis: -array.shape[axis])
    kept = {axis for axis in order[:2] if array.shape[axis] > 1} or {0}
    left = [axis for axis in range(len(array.shape)) if axis not in kept]
    if not left:
        return array, ""
    value = array.value
    place = np.unravel_index(np.argmax(np.where(np.isfinite(value), value, -np.inf)), value.shape)
    index = tuple(slice(None) if axis in kept else int(place[axis]) for axis in range(len(array.shape)))
    where = [
        f"{axis_label(array.dims[axis], array.axis_units)} is {_bin_label(array, axis, int(place[axis]))}"
        for axis in left
        if array.shape[axis] > 1
    ]
    return array[index], " and ".join(where)


def _bins_table(cut: EstimateArray | None) -> str:
    """All bins if they are few; some along one axis; else those of the largest, median and smallest value."""
    if cut is None:
        return ""
    is_long = cut.value.size > MAX_LISTED_BINS and len(cut.dims) > 1
    chosen = _notable_bins(cut) if is_long else [("", place) for place in _evenly_spaced_bins(cut)]
    heads = [
        *([""] if chosen and chosen[0][0] else []),
        *(f">{axis_label(name, cut.axis_units)}" for name in cut.dims),
    ]
    rows = []
    for word, flat in chosen:
        place = tuple(int(k) for k in np.unravel_index(flat, cut.shape))
        bins = [f">{_bin_label(cut, axis, k)}" for axis, k in enumerate(place)]
        rows.append([*([muted(word)] if word else []), *bins, f">{typeset(cut[place])}"])
    return table(rows, [*heads, ">estimate"])


def _evenly_spaced_bins(cut: EstimateArray) -> np.ndarray:
    """Flat indices of a few bins from first to last; of many bins those with a known error."""
    flat = np.arange(cut.value.size)
    known = flat[np.isfinite(cut.error.ravel())]
    flat = known if flat.size > MAX_LISTED_BINS and known.size else flat
    return flat[np.unique(np.linspace(0, flat.size - 1, min(flat.size, MAX_LISTED_BINS)).round().astype(int))]


def _notable_bins(cut: EstimateArray) -> list[tuple[str, int]]:
    """Flat indices of the largest, median and smallest value, and of the largest relative error."""
    known = np.flatnonzero(np.isfinite(cut.value.ravel()))
    if not known.size:
        return []
    values, middle = cut.value.ravel()[known], (known.size - 1) // 2
    found = [
        ("largest", known[np.argmax(values)]),
        ("median", known[np.argpartition(values, middle)[middle]]),
        ("smallest", known[np.argmin(values)]),
    ]
    relative = cut.relative_error.ravel()
    relative = np.where(np.isfinite(relative), relative, -1.0)
    if relative.max() > 0:
        found.append(("least sure", int(np.argmax(relative))))
    return found


def _bin_label(array: EstimateArray, axis: int, number: int) -> str:
    name = array.dims[axis]
    unit = axis_unit(name, array.axis_units)
    return bin_range_text(array.coords[name], unit, number, array.shape[axis])


# ---- The reading of a detector in a notebook: a row per quantity, and a picture of the main one.

# numbers (bins times batches) of one quantity, above which other quantities are only named
MAX_NUMBERS = 1 << 22


def reading_html(reading: Tally) -> str:
    """The reading, with the reason for a missing score if it is known."""
    note = reading.diagnosis.note
    boxes = warning_boxes([note.what] if note else [])
    return framed(heading(escaped(reading.heading)), boxes, reading_parts(reading, has_picture=True))


def reading_parts(reading: Tally, has_picture: bool) -> str:
    """A picture, and a row per available quantity; with very many bins only for those already computed."""
    rows, named, arrays, is_heavy = [], [], {}, False
    for name in reading.available:
        if is_heavy and name not in vars(reading):
            named.append(name)
            continue
        quantity = getattr(reading, name)
        if isinstance(quantity, EstimateArray):
            arrays[name] = quantity
            is_heavy = is_heavy or quantity.value.size * quantity.batches > MAX_NUMBERS
        text = array_summary(quantity) if name in arrays else _in_line(quantity)
        rows.append([_name_with_tooltip(reading, name), text])
    more = f"not computed for so many bins unless read: {', '.join(map(code, named))}" if named else ""
    picture = _main_picture(reading, arrays, is_heavy) if has_picture and arrays else ""
    return picture + (table(rows) if rows else "") + (f"<div>{muted(more)}</div>" if more else "")


def _main_picture(reading: Tally, arrays: dict[str, EstimateArray], is_heavy: bool) -> str:
    """The quantity by bin that this kind of detector is made for; of very many bins the one that is known."""
    known = next(iter(arrays))
    name = known if is_heavy else next((name for name, _ in reading.binned() if name in arrays), known)
    cut, where = _largest_slice(arrays[name])
    note = f"<div>{muted(f'where {where}')}</div>" if where else ""
    return "" if cut is None else note + array_image(cut, name.replace("_", " "))


def _in_line(estimate: Estimate) -> str:
    return f"<span>{typeset(estimate)}</span>"


def _name_with_tooltip(reading: Tally, name: str) -> str:
    """The name, with its meaning as a tooltip."""
    return f'<span title="{escaped(getattr(type(reading), name).summary)}">{code(name)}</span>'


def sample_html(reading: SnapshotReading) -> str:
    """A snapshot: its number of particles, and the ranges of positions and velocities."""
    rows = [
        [code("positions"), _component_ranges(reading.positions, "m")],
        [code("velocities"), _component_ranges(reading.velocities, "m s^-1")],
    ]
    return framed(heading(escaped(reading.heading)), table(rows) if len(reading) else "")


def _component_ranges(vectors, unit: str) -> str:
    """The smallest and largest value of each component."""
    spans = zip("xyz", vectors.min(axis=0, initial=0), vectors.max(axis=0, initial=0), strict=True)
    return typeset(", ".join(f"{axis} {low:.4g} to {high:.4g}" for axis, low, high in spans) + f" {unit}")
