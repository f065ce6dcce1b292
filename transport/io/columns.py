"""Batches as columns: each field of all batches is one array, written and read one batch at a time.

A Batch may hold numbers, arrays (of equal or of different lengths, and of records), dictionaries and
dataclasses of these.  The description of the columns is plain JSON; the arrays go into a file by name.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from transport.compile.methods import Method
from transport.results.batches import Batch
from transport.results.choice import Choice, Mean, Pilot
from transport.results.record import Cost, Forecast
from transport.run.provenance import Origin
from transport.run.settings import Limits
from transport.run.state import State
from transport.run.stopping import Look, Standing
from transport.scene.tracking import Splitting, Tracking
from transport.statistics.chunked import empty_memmap, release_pages, to_memmap


@dataclass(frozen=True)
class StoredColumn:
    """An array in consecutive pieces along its first axis, so that the whole is never copied."""

    dtype: np.dtype
    shape: tuple[int, ...]
    pieces: Iterable[np.ndarray]


Columns = dict[str, StoredColumn]
Pieces = Callable[[str, Sequence[int]], Iterator[np.ndarray]]  # (name of a column, lengths) -> its pieces


def describe_columns(name: str, values: list, columns: Columns) -> dict[str, object]:
    """Return the description of the values of one field, and add their numbers to `columns`."""
    values = [value.item() if isinstance(value, np.generic) else value for value in values]
    first = values[0]

    def part(key: str, of: list) -> dict[str, object]:
        return describe_columns(f"{name}.{key}".lstrip("."), of, columns)

    if len({type(value) for value in values}) == 1:
        if isinstance(first, np.ndarray):
            return _describe_arrays(name, values, columns)
        if dataclasses.is_dataclass(first):
            fields = {key: part(key, [getattr(value, key) for value in values]) for key in init_names(first)}
            return {"kind": type(first).__name__, "fields": fields}
        if isinstance(first, dict) and len({tuple(value) for value in values}) == 1:
            return {"keys": {key: part(key, [value[key] for value in values]) for key in first}}
        if type(first) in (int, float):
            return _describe_numbers(name, values, columns)
    return _describe_each(name, values, columns)


def read_values(
    description: dict, name: str, count: int, pieces: Pieces, kinds: dict[str, type]
) -> list[object]:
    """Return the values of one field of `count` batches from their description and the columns."""

    def part(of: dict, named: str) -> list[object]:
        return read_values(of, f"{name}.{named}".lstrip("."), count, pieces, kinds)

    match description:
        case {"each": each}:
            return [read_values(of, f"{name}.{place}", 1, pieces, kinds)[0] for place, of in enumerate(each)]
        case {"fields": fields} | {"keys": fields}:
            make = kinds[description["kind"]] if "kind" in description else dict
            parts = {key: part(of, key) for key, of in fields.items()}
            rows = zip(*parts.values(), strict=True) if parts else [()] * count
            return [make(**dict(zip(parts, row, strict=True))) for row in rows]
        case {"record": fields, "lengths": lengths}:
            return _make_records(fields, lengths, {key: part(of, key) for key, (of, _) in fields.items()})
        case {"numbers": dtype}:
            return np.concatenate(list(pieces(name, [count]))).astype(dtype).tolist()
        case {"rows": dtype, "shape": shape}:
            found = pieces(name, [1] * count) if 0 not in shape else [np.zeros((1, *shape))] * count
            return [piece[0].astype(dtype, copy=False) for piece in found]
        case {"lengths": lengths, "dtype": dtype, "shape": shape}:
            is_there = sum(lengths) > 0 and 0 not in shape
            found = pieces(name, lengths) if is_there else (np.zeros((length, *shape)) for length in lengths)
            return [to_memmap(piece.astype(dtype, copy=False)) for piece in found]
    raise KeyError(f"{name}: {sorted(description)}")


def init_names(part: object) -> list[str]:
    """Return the names of the fields from which a dataclass is made."""
    return [field.name for field in dataclasses.fields(part) if field.init]


def join_small_pieces(pieces: Iterable[np.ndarray], numbers: int) -> Iterator[np.ndarray]:
    """Join small pieces, so that each has at least `numbers` numbers or is a single piece."""
    held, size = [], 0
    for piece in pieces:
        held, size = [*held, piece], size + piece.size
        if size >= numbers:
            yield held[0] if len(held) == 1 else np.concatenate(held)
            held, size = [], 0
    if held:
        yield np.concatenate(held)


def _describe_each(name: str, values: list, columns: Columns) -> dict[str, object]:
    """Describe values without a common form one by one."""
    if len(values) == 1:
        raise TypeError(f"{name} is a {type(values[0]).__name__}, which cannot be stored as a column")
    return {
        "each": [describe_columns(f"{name}.{place}", [value], columns) for place, value in enumerate(values)]
    }


def _describe_numbers(name: str, values: list, columns: Columns) -> dict[str, object]:
    kind = float if isinstance(values[0], float) else np.int64 if max(values) < 2**63 else np.uint64
    numbers = np.array(values, kind)
    columns[name] = StoredColumn(numbers.dtype, numbers.shape, [numbers])
    return {"numbers": numbers.dtype.str}


def _describe_arrays(name: str, values: list[np.ndarray], columns: Columns) -> dict[str, object]:
    first = values[0]
    if first.dtype.names is not None:
        fields = {}
        for key in first.dtype.names:
            column = describe_columns(f"{name}.{key}", [value[key] for value in values], columns)
            fields[key] = column, first.dtype[key].str
        return {"record": fields, "lengths": [len(value) for value in values]}
    if len({value.dtype for value in values}) > 1 or len({value.shape[1:] for value in values}) > 1:
        return _describe_each(name, values, columns)
    stored = np.dtype(np.uint8) if first.dtype == bool else first.dtype  # NetCDF has no booleans
    if len({value.shape for value in values}) == 1:
        if first.size:
            rows = (piece[None] for piece in _array_pieces(values, stored))
            columns[name] = StoredColumn(stored, (len(values), *first.shape), rows)
        return {"rows": first.dtype.str, "shape": list(first.shape)}
    lengths, shape = [len(value) for value in values], first.shape[1:]
    if sum(lengths) and 0 not in shape:
        columns[name] = StoredColumn(stored, (sum(lengths), *shape), _array_pieces(values, stored))
    return {"lengths": lengths, "dtype": first.dtype.str, "shape": list(shape)}


def _array_pieces(values: list[np.ndarray], stored: np.dtype) -> Iterator[np.ndarray]:
    """Yield the arrays one by one; release the pages of a memory-mapped array once it is written."""
    for value in values:
        yield value.astype(stored, copy=False)
        release_pages(value)


def _make_records(fields: dict, lengths: list[int], parts: dict[str, list]) -> list[np.ndarray]:
    """Return arrays of records from their fields."""
    dtype = np.dtype([(key, of) for key, (_, of) in fields.items()])
    found = []
    for place, length in enumerate(lengths):
        records = empty_memmap(length, dtype)
        for key, values in parts.items():
            records[key] = values[place]
        release_pages(records)
        found.append(records)
    return found


# ---- The state of a run as JSON data: dataclasses, lists, tuples, dictionaries and numbers, bit for bit.
#
# Each type is tagged, {"tuple": [...]}, {"Look": {"particles": ...}}, so that reading restores it.  Batches
# are stored as numbers only: {"batch": 3}.

_STATE_TYPES = (
    Choice, Cost, Forecast, Limits, Look, Mean, Method, Origin, Pilot, Splitting, Standing, State, Tracking,
)  # fmt: skip
STATE_TYPES = {kind.__name__: kind for kind in _STATE_TYPES}


class BatchPool:
    """Numbered batches, each stored once."""

    def __init__(self) -> None:
        self.batches: list[Batch] = []
        self._numbers: dict[int, int] = {}

    def number_of(self, batch: Batch) -> int:
        """Return the number of a batch; a new batch is added."""
        if id(batch) not in self._numbers:
            self._numbers[id(batch)] = len(self.batches)
            self.batches.append(batch)
        return self._numbers[id(batch)]


def to_json(value: object, pool: BatchPool) -> object:
    """Return the value as JSON data.  Raises TypeError for a type outside STATE_TYPES."""
    match value:
        case None | bool() | int() | str():
            return value
        case np.generic():
            return to_json(value.item(), pool)
        case float():
            return value if math.isfinite(value) else {"float": repr(value)}
        case Batch():
            return {"batch": pool.number_of(value)}
        case list():
            return [to_json(item, pool) for item in value]
        case tuple():
            return {"tuple": [to_json(item, pool) for item in value]}
        case Mapping():
            return {"table": [[to_json(key, pool), to_json(item, pool)] for key, item in value.items()]}
    kind = type(value).__name__
    if STATE_TYPES.get(kind) is not type(value):
        raise TypeError(
            f"{kind} cannot be stored in the file of a run: transport.io.columns.STATE_TYPES lists the types"
        )
    return {kind: {name: to_json(getattr(value, name), pool) for name in init_names(value)}}


def from_json(data: object, batches: list[Batch]) -> object:
    """Return the value of JSON data that `to_json` wrote.  Raises KeyError or TypeError for other data."""
    if isinstance(data, list):
        return [from_json(item, batches) for item in data]
    if not isinstance(data, dict):
        return data
    ((kind, content),) = data.items()
    match kind:
        case "float":
            return float(content)
        case "batch":
            return batches[content]
        case "tuple":
            return tuple(from_json(item, batches) for item in content)
        case "table":
            return {from_json(key, batches): from_json(item, batches) for key, item in content}
    return STATE_TYPES[kind](**{name: from_json(item, batches) for name, item in content.items()})
