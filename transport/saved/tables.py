"""Results as tables for other programs: a group per detector, variables with dims, coordinates and units.

xarray.open_dataset("run.nc", engine="h5netcdf", group="meter")      its quantities, and <quantity>_error
xarray.open_dataset("run.nc", engine="h5netcdf")                     the ledger xarray.open_dataset("run.nc",
engine="h5netcdf", group="run")        batches, and the scene as the text of its JSON
"""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Container, Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from transport.phase_space import Snapshot
from transport.results.estimates import AXIS_UNITS
from transport.results.report import head_of, title_of
from transport.results.result import Result
from transport.validation import SceneError

OWN = "run"  # group of the state of the run
COMPLETE, INTERRUPTED = "complete", "incomplete: interrupted"
GOES_ON = (
    "incomplete: a checkpoint, for transport.load and resume=; ledger and detectors are written at the end"
)
BOUNDS = ("_low", "_high")


@dataclass(frozen=True)
class Variable:
    """An array with the names of its axes and its attributes."""

    dims: tuple[str, ...]
    values: np.ndarray
    attributes: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Table:
    """Variables by name, made on demand; coordinates come before the variables that use them."""

    group: str
    attributes: dict[str, object]
    variables: Iterator[tuple[str, Variable]]


def tables_of(result: Result, is_over: bool) -> Iterator[Table]:
    """Yield the ledger, then each detector; for a checkpoint (not `is_over`) only attributes."""
    written = datetime.now(UTC).isoformat(timespec="seconds")
    told = {"title": head_of(result), "seed": str(result.seed), "method": result.plan.method.title}
    told["history"] = f"{written} {shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]])}"  # NetCDF convention
    if not is_over:
        yield Table("", told | {"completeness": GOES_ON}, iter(()))
        return
    told["completeness"] = COMPLETE if result.is_complete else INTERRUPTED
    told["warnings"] = "\n".join(result.warnings)
    ledger = list(_ledger(result))
    yield Table("", told, iter(ledger))
    taken = {OWN, *dict(ledger)}  # a group must not have the name of a variable
    for detector in result.scene.detectors:
        group = detector.name.replace("/", "|")  # HDF5 names have no slash
        while group in taken:
            group += "_"
        taken.add(group)
        title = (
            title_of(detector, result[detector.name]) if not isinstance(detector, Snapshot) else "snapshot"
        )
        told = {"title": title, "name": detector.name}
        made = _sample if isinstance(detector, Snapshot) else _quantities
        yield Table(group, told, made(result, detector))


def _ledger(result: Result) -> Iterator[tuple[str, Variable]]:
    ledger = result._own_ledger
    for name, estimate in ledger.items():
        yield from _with_error(name, (), estimate)
    names = np.array(list(ledger.absorbed_by), dtype=object)
    if len(names):
        yield "by", Variable(("by",), names)
        shares = ledger.absorbed_by.values()
        units = {"units": str(ledger["absorbed"].unit)}
        for end, what in (("", "value"), ("_error", "error")):
            values = np.array([getattr(share, what) for share in shares])
            yield f"absorbed_by{end}", Variable(("by",), values, units)


def _quantities(result: Result, detector: object) -> Iterator[tuple[str, Variable]]:
    """Yield all quantities of a detector from a new reading; each is freed before the next is made."""
    reading = result._read(detector)
    axes: dict[str, np.ndarray] = {}
    bounded = set()
    for name in reading.known:
        try:
            quantity = getattr(reading, name)
        except SceneError:
            continue
        dims = []
        for axis, edges in quantity.coords.items():
            named = _named(axis, edges, axes)
            if named not in axes:
                axes[named] = edges
                places = _places(edges, quantity.shape[quantity.dims.index(axis)])
                bounded |= {named} if len(places) > 1 else set()
                known = AXIS_UNITS | dict(quantity.axis_units)
                units = {"units": known[axis]} if axis in known else {}
                for end, place in places.items():
                    yield named + end, Variable((named,), place, units)
            dims.append(named)
        yield from _with_error(name, tuple(dims), quantity, bounded)
        vars(reading).pop(name, None)


def _named(axis: str, edges: np.ndarray, axes: dict[str, np.ndarray]) -> str:
    """Return the name of an axis; a new one if the name is taken by an axis with other bins."""
    while axis in axes and not np.array_equal(axes[axis], edges):
        axis += "_"
    return axis


def _places(edges: np.ndarray, bins: int) -> dict[str, np.ndarray]:
    """Return instants unchanged, and bins as centres and bounds."""
    if len(edges) == bins:
        return {"": edges}
    return {"": 0.5 * (edges[1:] + edges[:-1]), **dict(zip(BOUNDS, (edges[:-1], edges[1:]), strict=True))}


def _with_error(
    name: str, dims: tuple[str, ...], quantity: object, bounded: Container[str] = ()
) -> Iterator[tuple[str, Variable]]:
    """Yield a quantity and its error; `bounded` names axes with bins: their bounds become coordinates."""
    units = {"units": str(quantity.unit) or "1", "long_name": name.replace("_", " ")}
    bounds = [dim + end for dim in dims if dim in bounded for end in BOUNDS]
    units |= {"coordinates": " ".join(bounds)} if bounds else {}
    # judging very many bins would need all of their errors at once
    is_judged = not quantity._replicates.is_in_parts
    judged = {}
    if not dims:
        judged = {
            "verdict": quantity.verdict,
            "findings": json.dumps([each.record() for each in quantity.findings]),
        }
    yield name, Variable(dims, np.asarray(quantity.value), units | judged)
    if is_judged and np.any(doubtful := quantity.is_doubtful):
        words = {"units": "1", "long_name": f"whether the error of {units['long_name']} is doubtful"}
        yield f"{name}_doubtful", Variable(dims, np.asarray(doubtful, dtype=np.int8), words)
    units = units | {"long_name": f"standard error of {units['long_name']}"}
    yield f"{name}_error", Variable(dims, np.asarray(quantity.error), units)


def _sample(result: Result, snapshot: Snapshot) -> Iterator[tuple[str, Variable]]:
    """Yield the particles of a snapshot."""
    reading = result[snapshot.name]
    unit = "1" if result.scene.measured_in == "particles" else "J"
    yield "axis", Variable(("axis",), np.array(["x", "y", "z"], dtype=object))
    if len(reading):
        yield "positions", Variable(("particle", "axis"), reading.positions, {"units": "m"})
        yield "velocities", Variable(("particle", "axis"), reading.velocities, {"units": "m s^-1"})
        yield "weights", Variable(("particle",), reading.weights, {"units": unit})
        yield "histories", Variable(("particle",), reading.histories)
        yield "batches", Variable(("particle",), reading.batches)
