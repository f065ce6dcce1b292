"""Results as tables for other programs: a group per detector, variables with dims, coordinates and units.

A file of a run holds them, and `to_dataset` gives those of one tally to xarray:

xarray.open_dataset("run.nc", engine="h5netcdf", group="meter")      its quantities, and <quantity>_error
xarray.open_dataset("run.nc", engine="h5netcdf")                     the ledger
"""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from transport.results.phase_space import SnapshotReading
from transport.results.report import run_line
from transport.results.result import Result
from transport.results.tally import Tally
from transport.statistics.axes import axis_places
from transport.statistics.estimates import EstimateOrArray
from transport.validation import optional_packages

if TYPE_CHECKING:
    import xarray

RUN_GROUP = "run"  # group of the state of the run
COMPLETE, INTERRUPTED = "complete", "incomplete: interrupted"
CHECKPOINT_NOTE = (
    "incomplete: a checkpoint, for transport.load and resume=; ledger and detectors are written at the end"
)


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


def result_tables(result: Result, is_over: bool) -> Iterator[Table]:
    """Yield the ledger, then each detector; for a checkpoint (not `is_over`) only attributes."""
    written = datetime.now(UTC).isoformat(timespec="seconds")
    command = shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]])
    attributes = {"title": run_line(result), "seed": str(result.seed), "method": result.plan.method.title}
    attributes["history"] = f"{written} {command}"  # NetCDF convention
    if not is_over:
        yield Table("", attributes | {"completeness": CHECKPOINT_NOTE}, iter(()))
        return
    attributes["completeness"] = COMPLETE if result.is_complete else INTERRUPTED
    attributes["warnings"] = "\n".join(result.warnings)
    ledger = list(_ledger_variables(result))
    yield Table("", attributes, iter(ledger))
    taken = {RUN_GROUP, *dict(ledger)}  # a group must not have the name of a variable
    for detector in result.scene.detectors:
        group = detector.name.replace("/", "|")  # HDF5 names have no slash
        while group in taken:
            group += "_"
        taken.add(group)
        tally = result._read(detector)
        yield Table(group, _tally_attributes(tally), _tally_variables(tally))


def to_dataset(tally: Tally, *names: str) -> xarray.Dataset:
    """Return the quantities of a tally as one Dataset, with the sizes of its bins as coordinates."""
    with optional_packages("to_dataset"):
        import xarray

    variables, places = {}, set()
    for name, variable in _tally_variables(tally, names):
        places |= set(variable.attributes.pop("coordinates", "").split())
        variables[name] = (variable.dims, variable.values, variable.attributes)
    data = xarray.Dataset(variables, attrs=_tally_attributes(tally)).set_coords(list(places))
    for name, (dims, values, unit) in tally.bin_sizes.items():
        if set(dims) <= set(data.dims):
            about = {"units": unit, "long_name": f"{name} of each bin"}
            data.coords[f"bin_{name.replace(' ', '_')}"] = (dims, values, about)
    return data


def _ledger_variables(result: Result) -> Iterator[tuple[str, Variable]]:
    ledger = result._own_ledger
    for name, estimate in ledger.items():
        yield from _with_error(name, estimate, {})
    names = np.array(list(ledger.absorbed_by), dtype=object)
    if len(names):
        yield "by", Variable(("by",), names)
        shares = ledger.absorbed_by.values()
        units = {"units": str(ledger["absorbed"].unit)}
        for end, what in (("", "value"), ("_error", "error")):
            values = np.array([getattr(share, what) for share in shares])
            yield f"absorbed_by{end}", Variable(("by",), values, units)


def _tally_attributes(tally: Tally) -> dict[str, object]:
    is_sample = isinstance(tally, SnapshotReading)
    return {"title": tally.kind if is_sample else tally.heading, "name": tally.name}


def _tally_variables(tally: Tally, names: Sequence[str] = ()) -> Iterator[tuple[str, Variable]]:
    """Yield these quantities of a tally, or all; new ones are freed before the next is made."""
    if isinstance(tally, SnapshotReading):
        for name in names:
            tally.named(name)  # raises: a sample has no quantities
        yield from _sample_variables(tally)
        return
    done, kept = set(), set(vars(tally))
    for name in names or tally.available:
        quantity = tally.named(name)
        own = [axis for axis in tally.axes if axis.name in quantity.coords]
        for axis in own:
            if axis.name not in done:
                done.add(axis.name)
                units = {"units": axis.unit} if axis.unit else {}
                for end, places in axis_places(axis.edges, len(axis)).items():
                    yield axis.name + end, Variable((axis.name,), places, units)
        bounds = " ".join(f"{axis.name}_low {axis.name}_high" for axis in own if not axis.is_instants)
        yield from _with_error(name, quantity, {"coordinates": bounds} if bounds else {})
        for new in (vars(tally).keys() & set(tally.known)) - kept:
            del vars(tally)[new]


def _with_error(
    name: str, quantity: EstimateOrArray, about: dict[str, str]
) -> Iterator[tuple[str, Variable]]:
    """Yield a quantity and its error; about: further attributes."""
    dims = tuple(quantity.coords)
    units = {"units": str(quantity.unit) or "1", "long_name": name.replace("_", " "), **about}
    # judging very many bins would need all of their errors at once
    is_judged = not quantity._replicates.is_chunked
    judged = {}
    if not dims:
        findings = json.dumps([each.record() for each in quantity.findings])
        judged = {"verdict": quantity.verdict, "findings": findings}
    yield name, Variable(dims, np.asarray(quantity.value), units | judged)
    if is_judged:
        words = {"units": "1", "long_name": f"whether the error of {units['long_name']} is doubtful"}
        yield f"{name}_doubtful", Variable(dims, np.asarray(quantity.is_doubtful, dtype=np.int8), words)
    units = units | {"long_name": f"standard error of {units['long_name']}"}
    yield f"{name}_error", Variable(dims, np.asarray(quantity.error), units)


def _sample_variables(sample: SnapshotReading) -> Iterator[tuple[str, Variable]]:
    """Yield the particles of a snapshot."""
    unit = "1" if sample.scene.measured_in == "particles" else "J"
    yield "axis", Variable(("axis",), np.array(["x", "y", "z"], dtype=object))
    if len(sample):
        yield "positions", Variable(("particle", "axis"), sample.positions, {"units": "m"})
        yield "velocities", Variable(("particle", "axis"), sample.velocities, {"units": "m s^-1"})
        yield "weights", Variable(("particle",), sample.weights, {"units": unit})
        yield "histories", Variable(("particle",), sample.histories)
        yield "batches", Variable(("particle",), sample.batches)
