"""The reading of a detector in a notebook: a row per quantity."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING

from transport.html.elements import code, framed, heading, muted, table, warnings_of
from transport.html.estimates import thumbnail_of, told_of
from transport.html.typesetting import escaped, typeset
from transport.results.estimates import Estimate, EstimateArray
from transport.results.phase_readings import PhaseReading, SnapshotReading
from transport.results.report import title_of
from transport.validation import SceneError

if TYPE_CHECKING:
    from transport.results.quantified import Quantified

HEAVY = 1 << 22  # numbers (bins times batches) of one quantity, above which other quantities are only named


def reading_html(reading: Quantified) -> str:
    """The reading, with the reason for a missing score if it is known."""
    warning = reading.note and reading.note[1]
    looking = reading.phase_space if isinstance(reading, PhaseReading) else reading.detector
    title = title_of(looking, reading)
    return framed(
        heading(escaped(title)), warnings_of([warning] if warning else []), quantities_table(reading)
    )


def quantities_table(reading: Quantified) -> str:
    """A row per available quantity; with very many bins only for those that are already computed."""
    rows, named, is_heavy = [], [], False
    for name in reading.known:
        if is_heavy and name not in vars(reading):
            named.append(name)
            continue
        try:
            quantity = getattr(reading, name)
        except SceneError:
            continue
        rows.append([_explained(reading, name), *_cells(quantity)])
        is_heavy = is_heavy or _numbers(quantity) > HEAVY
    more = f"not computed for so many bins unless read: {', '.join(map(code, named))}" if named else ""
    return (table(rows) if rows else "") + (f"<div>{muted(more)}</div>" if more else "")


def _cells(quantity: Estimate | EstimateArray) -> tuple[str, str]:
    """The text of a quantity, and its picture if it is an array."""
    if isinstance(quantity, EstimateArray):
        return told_of(quantity), thumbnail_of(quantity)
    return f"<span>{typeset(quantity)}</span>", ""


def _explained(reading: Quantified, name: str) -> str:
    """The name, with its meaning as a tooltip."""
    meaning = inspect.getdoc(inspect.getattr_static(type(reading), name, None)) or ""
    line = meaning.partition("\n\n")[0].replace("\n", " ")
    return f'<span title="{escaped(line)}">{code(name)}</span>'


def _numbers(quantity: Estimate | EstimateArray) -> int:
    return quantity.value.size * quantity.batches if isinstance(quantity, EstimateArray) else 1


def sample_html(reading: SnapshotReading) -> str:
    """A snapshot: its number of particles, and the ranges of positions and velocities."""
    rows = [
        [code("positions"), _spread(reading.positions, "m")],
        [code("velocities"), _spread(reading.velocities, "m s^-1")],
    ]
    title = title_of(reading.snapshot, reading)
    return framed(heading(escaped(title)), table(rows) if len(reading) else "")


def _spread(vectors, unit: str) -> str:
    """The smallest and largest value of each component."""
    spans = zip("xyz", vectors.min(axis=0, initial=0), vectors.max(axis=0, initial=0), strict=True)
    return typeset(", ".join(f"{axis} {low:.4g} to {high:.4g}" for axis, low, high in spans) + f" {unit}")
