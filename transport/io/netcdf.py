"""A run as NetCDF-4 (HDF5): one group per detector, for xarray, and one group with the state of the run.

Written by h5netcdf.  HDF5 does not survive a failed write: the interpreter crashes at exit.  Therefore
failures are hidden from HDF5: it writes to a file object that stores the first error, which is raised after
HDF5 has closed.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import numpy as np

from transport.io.atomic import FileError, append_checksum, verify_checksum
from transport.io.columns import Columns, Pieces, StoredColumn, join_small_pieces
from transport.io.tables import RUN_GROUP, Table, Variable
from transport.validation import pip_install

COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
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
        column = StoredColumn(values.dtype, values.shape, [values])
        made = _write_pieces(patient, group, name, variable.dims, column)
    made.attrs.update(variable.attributes)
    patient.check()


def _write_pieces(patient: _ErrorStoringFile, group, name: str, axes: Sequence[str], column: StoredColumn):
    """Write a compressed variable piece by piece."""
    _create_dimensions(group, axes, column.shape)
    chunks = _chunk_shape(column.shape)
    made = group.create_variable(name, tuple(axes), column.dtype, chunks=chunks, **COMPRESSION)
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
