"""A run as NetCDF-4 (HDF5): one group per detector, for xarray, and one group with the state of the run.

Written by h5netcdf.  HDF5 does not survive a failed write: the interpreter crashes at exit.  Therefore
failures are hidden from HDF5: it writes to a file object that stores the first error, which is raised after
HDF5 has closed.
"""

from __future__ import annotations

import io
import json
import math
import shlex
import sys
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import BinaryIO

import numpy as np

from transport.io.atomic import FileError, append_checksum, verify_checksum
from transport.io.columns import Column, Columns, Pieces, join_small_pieces
from transport.results.report import run_line, title_of
from transport.results.result import Result
from transport.scene.phase_space import Snapshot
from transport.statistics.quantities import AXIS_UNITS
from transport.validation import SceneError, pip_install

# ---- Results as tables for other programs: a group per detector, variables with dims, coordinates and units.
#
# xarray.open_dataset("run.nc", engine="h5netcdf", group="meter")      its quantities, and <quantity>_error
# xarray.open_dataset("run.nc", engine="h5netcdf")                     the ledger
# xarray.open_dataset("run.nc", engine="h5netcdf", group="run")        batches, and the scene as the text of
# its JSON

RUN_GROUP = "run"  # group of the state of the run
COMPLETE, INTERRUPTED = "complete", "incomplete: interrupted"
CHECKPOINT_NOTE = (
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


def result_tables(result: Result, is_over: bool) -> Iterator[Table]:
    """Yield the ledger, then each detector; for a checkpoint (not `is_over`) only attributes."""
    written = datetime.now(UTC).isoformat(timespec="seconds")
    attributes = {"title": run_line(result), "seed": str(result.seed), "method": result.plan.method.title}
    attributes["history"] = (
        f"{written} {shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]])}"  # NetCDF convention
    )
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
        title = (
            title_of(detector, result[detector.name]) if not isinstance(detector, Snapshot) else "snapshot"
        )
        attributes = {"title": title, "name": detector.name}
        made = _snapshot_variables if isinstance(detector, Snapshot) else _detector_variables
        yield Table(group, attributes, made(result, detector))


def _ledger_variables(result: Result) -> Iterator[tuple[str, Variable]]:
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


def _detector_variables(result: Result, detector: object) -> Iterator[tuple[str, Variable]]:
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
            named = _axis_name(axis, edges, axes)
            if named not in axes:
                axes[named] = edges
                places = _axis_values(edges, quantity.shape[quantity.dims.index(axis)])
                bounded |= {named} if len(places) > 1 else set()
                known = AXIS_UNITS | dict(quantity.axis_units)
                units = {"units": known[axis]} if axis in known else {}
                for end, place in places.items():
                    yield named + end, Variable((named,), place, units)
            dims.append(named)
        yield from _with_error(name, tuple(dims), quantity, bounded)
        vars(reading).pop(name, None)


def _axis_name(axis: str, edges: np.ndarray, axes: dict[str, np.ndarray]) -> str:
    """Return the name of an axis; a new one if the name is taken by an axis with other bins."""
    while axis in axes and not np.array_equal(axes[axis], edges):
        axis += "_"
    return axis


def _axis_values(edges: np.ndarray, bins: int) -> dict[str, np.ndarray]:
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
    is_judged = not quantity._replicates.is_chunked
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


def _snapshot_variables(result: Result, snapshot: Snapshot) -> Iterator[tuple[str, Variable]]:
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


# ---- The whole file: these tables, and one group with the state of the run.

CHUNK_SIZE = 1 << 16  # numbers per compressed chunk


def require_h5netcdf(path: Path):
    """Return the package h5netcdf.  Raises FileError if it is not installed."""
    try:
        import h5netcdf
    except ImportError:
        cure = f"{pip_install('files')}, or write {path.with_suffix('.npz').name}, which needs none"
        raise FileError(f"{path.name}: NetCDF needs h5netcdf, which is not installed; {cure}") from None
    return h5netcdf


def write_run(
    file: BinaryIO, path: Path, texts: dict[str, str], columns: Columns, tables: Iterable[Table], batches: int
) -> None:
    """Write a run: JSON texts by name, columns, and tables of results.

    Raises OSError if the disk is full.
    """
    patient = _ErrorStoringFile(file)
    written = require_h5netcdf(path).File(patient, "w")
    try:
        group = written.create_group(RUN_GROUP)
        group.dimensions["batch"] = batches
        for name, text in texts.items():
            _write_variable(patient, group, name, Variable((), np.array(text, dtype=object)))
        for name, column in columns.items():
            axes = [f"{name}.{axis}" for axis in range(len(column.shape))]
            axes[:1] = ["batch"] if column.shape[0] == batches else axes[:1]
            _write_pieces(patient, group, name, axes, column)
        for table in tables:
            _write_table(patient, written, table)
    finally:
        written.close()
    patient.check()
    append_checksum(file)


@contextmanager
def open_run(path: Path) -> Iterator[tuple[Callable[[str], str], Pieces]]:
    """Yield functions that read the texts and the columns of a file.  Raises ValueError if it is damaged."""
    require_h5netcdf(path)
    import h5py  # h5netcdf reads through it; of a damaged file only h5py closes without a warning

    with path.open("rb") as file:
        verify_checksum(file)
        with h5py.File(file, "r") as written:
            group = written[RUN_GROUP]
            yield (
                lambda name: group[name].asstr()[()],
                lambda name, lengths: _read_pieces(group[name], lengths),
            )


class _ErrorStoringFile(io.RawIOBase):
    """A file object whose writes always succeed; it stores the first error and then drops all writes."""

    def __init__(self, file: BinaryIO) -> None:
        self.file, self.error = file, None

    def check(self) -> None:
        """Raise the stored OSError, if any."""
        if self.error is not None:
            raise self.error

    def write(self, content: bytes) -> int:
        """Write the bytes, unless an error is stored; return their number in any case."""
        if self.error is None:
            try:
                self.file.write(content)
            except OSError as error:
                self.error = error
        return len(content)

    def truncate(self, size: int | None = None) -> int:
        """Flush the file and cut it to `size` bytes, unless an error is stored; return `size`."""
        if self.error is None:
            try:
                self.file.flush()
                self.file.truncate(size)
            except OSError as error:
                self.error = error
        return size

    def readinto(self, buffer: bytearray) -> int:
        """Read bytes into the buffer; return their number."""
        return self.file.readinto(buffer)

    def seek(self, offset: int, whence: int = 0) -> int:
        """Move to `offset` bytes; return the new position, or `offset` after an error."""
        try:
            return self.file.seek(offset, whence)
        except OSError as error:  # from an earlier buffered write
            self.error = self.error or error
            return offset

    def tell(self) -> int:
        """Return the position in the file [bytes]."""
        return self.file.tell()

    def seekable(self) -> bool:
        """Return True: HDF5 needs to move in the file."""
        return True

    readable = writable = seekable


def _write_table(patient: _ErrorStoringFile, written, table: Table) -> None:
    group = written.create_group(table.group) if table.group else written
    group.attrs.update(table.attributes)
    for name, variable in table.variables:
        _write_variable(patient, group, name, variable)


def _write_variable(patient: _ErrorStoringFile, group, name: str, variable: Variable) -> None:
    values = variable.values
    if values.dtype == object or values.size < CHUNK_SIZE:
        import h5py

        _create_dimensions(group, variable.dims, values.shape)
        dtype = h5py.string_dtype() if values.dtype == object else values.dtype
        made = group.create_variable(name, variable.dims, dtype)
        made[...] = values
    else:
        made = _write_pieces(
            patient, group, name, variable.dims, Column(values.dtype, values.shape, [values])
        )
    made.attrs.update(variable.attributes)
    patient.check()


def _write_pieces(patient: _ErrorStoringFile, group, name: str, axes: Sequence[str], column: Column):
    """Write a compressed variable piece by piece."""
    _create_dimensions(group, axes, column.shape)
    made = group.create_variable(
        name,
        tuple(axes),
        column.dtype,
        chunks=_chunk_shape(column.shape),
        compression="gzip",
        compression_opts=1,
        shuffle=True,
    )
    begin = 0
    for piece in join_small_pieces(column.pieces, CHUNK_SIZE):
        made[begin : begin + len(piece)] = piece
        begin += len(piece)
        patient.check()
    return made


def _create_dimensions(group, axes: Sequence[str], shape: tuple[int, ...]) -> None:
    for axis, size in zip(axes, shape, strict=True):
        if axis not in group.dimensions:
            group.dimensions[axis] = size


def _chunk_shape(shape: tuple[int, ...]) -> tuple[int, ...]:
    """Return the shape of a chunk: as much of the last axes as CHUNK_SIZE numbers hold."""
    chunks, left = [], CHUNK_SIZE
    for size in reversed(shape):
        chunks.insert(0, max(1, min(size, left)))
        left //= chunks[0]
    return tuple(chunks)


def _read_pieces(variable, lengths: Sequence[int]) -> Iterator[np.ndarray]:
    """Yield the pieces of these lengths; small ones are read together."""
    each, begin, place = max(1, math.prod(variable.shape[1:])), 0, 0
    while place < len(lengths):
        past, size = place, 0
        while past < len(lengths) and (past == place or size * each < CHUNK_SIZE):
            past, size = past + 1, size + lengths[past]
        read = np.asarray(variable[begin : begin + size])
        yield from np.split(read, np.cumsum(lengths[place:past])[:-1])
        begin, place = begin + size, past
