"""A run as .npz: a zip of .npy arrays for numpy.load, with run.json, which describes them, and scene.json."""

from __future__ import annotations

import json
import math
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import numpy as np

from transport.io.columns import Columns, Pieces, StoredColumn
from transport.io.tables import RUN_GROUP, Table, Variable

COMPRESSION_LEVEL = 1  # of compression; higher levels save little and take long


def write_run(file: BinaryIO, texts: dict[str, str], columns: Columns, tables: Iterable[Table]) -> None:
    """Write a run: JSON texts by name, columns, and tables of results."""
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=COMPRESSION_LEVEL) as archive:
        for name, text in texts.items():
            archive.writestr(f"{name}.json", text)
        for name, column in columns.items():
            _write_column(archive, f"{RUN_GROUP}/{name}", column)
        contents = {}
        for table in tables:
            variables = {}
            for name, variable in table.variables:
                variables[name] = {"dims": variable.dims, **variable.attributes}
                _write_variable(archive, f"{table.group}/{name}".lstrip("/"), variable)
            contents[table.group] = {**table.attributes, "variables": variables}
        if contents:
            archive.writestr("tables.json", json.dumps(contents, indent=1, ensure_ascii=False))


@contextmanager
def open_run(path: Path) -> Iterator[tuple[Callable[[str], str], Pieces]]:
    """Yield functions that read the texts and the columns of a file.

    Raises the errors of zipfile if damaged.
    """
    with zipfile.ZipFile(path) as archive:
        yield (
            lambda name: archive.read(f"{name}.json").decode(),
            lambda name, lengths: _read_pieces(archive, f"{RUN_GROUP}/{name}", lengths),
        )


def _write_variable(archive: zipfile.ZipFile, name: str, variable: Variable) -> None:
    values = variable.values
    values = values.astype(str) if values.dtype == object else values
    _write_column(archive, name, StoredColumn(values.dtype, values.shape, [values]))


def _write_column(archive: zipfile.ZipFile, name: str, column: StoredColumn) -> None:
    kind = np.lib.format.dtype_to_descr(column.dtype)
    header = {"descr": kind, "fortran_order": False, "shape": column.shape}
    with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
        np.lib.format.write_array_header_2_0(entry, header)
        for piece in column.pieces:
            entry.write(np.ascontiguousarray(piece).reshape(-1).view(np.uint8).data)


def _read_pieces(archive: zipfile.ZipFile, name: str, lengths: Sequence[int]) -> Iterator[np.ndarray]:
    with archive.open(f"{name}.npy") as entry:
        np.lib.format.read_magic(entry)
        shape, _, dtype = np.lib.format.read_array_header_2_0(entry)
        for length in lengths:
            piece = np.empty((length, *shape[1:]), dtype)
            content = entry.read(math.prod(piece.shape) * dtype.itemsize)
            piece.reshape(-1).view(np.uint8)[:] = np.frombuffer(content, np.uint8)
            yield piece
        if entry.read(1):  # reading to the end checks the checksum
            raise ValueError(f"{name} is longer than expected")
