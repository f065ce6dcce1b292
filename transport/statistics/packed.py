"""A long column of sums, mostly zero or small, compressed without loss to a few bytes per row.

Pages of rows without a score are omitted.  In other pages a bit per row marks scored rows; their numbers have
the narrowest integer type that nearly all of them fit, in units of the column, and the few others are kept
beside.  Very many numbers are memory-mapped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from transport.statistics.chunked import empty_memmap, release_pages, to_memmap

PAGE = 1 << 12  # rows
CHUNK_ROWS = 1 << 17  # rows that are processed together, whole pages
MAX_UNPACKED_ROWS = 1 << 18  # rows of a column that stays uncompressed
NARROW_TYPES = (np.uint8, np.uint16, np.uint32)
OUTLIER_BYTES = 16  # of a number kept beside, with its index
MAPPED_FIELDS = ("numbers", "places", "values")  # arrays that may be memory-mapped


@dataclass(frozen=True, eq=False)
class Packed:
    """A compressed column of `length` rows; its slices, sums and so on are those of the plain array.

    pages: numbers of the pages with scores, ascending, (P,);  marks: (P, PAGE / 8), a bit per row;  numbers:
    of the scored rows, in units of `unit` if they are integers, else the values;  places, values: indices in
    `numbers`, and values, of those that do not fit.
    """

    length: int
    unit: float
    pages: np.ndarray
    marks: np.ndarray
    numbers: np.ndarray
    places: np.ndarray
    values: np.ndarray

    def __post_init__(self) -> None:
        for name in MAPPED_FIELDS:
            object.__setattr__(self, name, to_memmap(getattr(self, name)))

    def __reduce__(self) -> tuple:
        """Pickle with plain arrays: another process cannot open the file."""
        parts = (np.asarray(getattr(self, name)) for name in MAPPED_FIELDS)
        return Packed, (self.length, self.unit, self.pages, self.marks, *parts)

    @property
    def dtype(self) -> np.dtype:
        """Type of the numbers."""
        return self.values.dtype

    @property
    def shape(self) -> tuple[int]:
        """Length of the unpacked array, as a tuple."""
        return (self.length,)

    @property
    def nbytes(self) -> int:
        """Size in memory and in files [bytes]."""
        return sum(part.nbytes for part in (self.pages, self.marks, self.numbers, self.places, self.values))

    @cached_property
    def page_starts(self) -> np.ndarray:
        """Index in `numbers` of each page's first number, and their count at the end, (P + 1,)."""
        return np.append(0, np.cumsum(np.unpackbits(self.marks, axis=1).sum(axis=1, dtype=np.int64)))

    def __len__(self) -> int:
        return self.length

    def __getitem__(self, rows: slice) -> np.ndarray:
        """The rows of a slice without a step, as an array."""
        first, past, _ = rows.indices(self.length)
        low, high = first // PAGE, -(-past // PAGE)
        one, other = np.searchsorted(self.pages, (low, high))
        found = np.zeros((max(0, high - low), PAGE), self.dtype)
        if one < other:
            pages = np.zeros((other - one, PAGE), self.dtype)
            pages[np.unpackbits(self.marks[one:other], axis=1).view(bool)] = self._scored_values(one, other)
            found[self.pages[one:other] - low] = pages
        return found.ravel()[first - low * PAGE : max(first, past) - low * PAGE]

    def _scored_values(self, one: int, other: int) -> np.ndarray:
        """Values of the scored rows in a range of pages."""
        first, past = self.page_starts[[one, other]]
        values = np.array(self.numbers[first:past], self.dtype)
        if self.numbers.dtype != self.dtype:
            if self.unit != 1:
                values *= self.unit
            low, high = np.searchsorted(self.places, (first, past))
            values[self.places[low:high] - first] = self.values[low:high]
        for name in MAPPED_FIELDS:
            release_pages(getattr(self, name))
        return values

    def __array__(self, dtype: object = None, copy: bool | None = None) -> np.ndarray:
        return np.asarray(self[:], dtype)

    def __add__(self, other: Packed) -> Packed:
        pages = np.concatenate([self.pages, other.pages]).astype(np.int64)
        firsts = (np.unique(pages * PAGE // CHUNK_ROWS) * CHUNK_ROWS).tolist()
        among = [(first, min(first + CHUNK_ROWS, self.length)) for first in firsts]
        return pack(lambda first, past: self[first:past] + other[first:past], self.length, self.unit, among)

    def sum(self) -> float | int:
        """Sum of all rows."""
        return sum(stretch.sum() for stretch in self._chunks())

    def max(self) -> float | int:
        """Largest row."""
        return max(stretch.max() for stretch in self._chunks())

    def _chunks(self) -> Iterator[np.ndarray]:
        return (self[first:past] for first, past in _row_ranges(self.length))


Rows = Callable[[int, int], np.ndarray]  # the rows of a column in a range
RowRanges = list[tuple[int, int]]  # ranges of rows, of whole pages except the last


def make_columns(all_rows: list[Rows], units: list[float], raw: np.ndarray) -> list[np.ndarray | Packed]:
    """Make columns from raw rows: plain arrays, or packed if they are long.

    units: powers of two, of which most numbers are integer multiples;  raw: all zero where there is no score.
    """
    if len(raw) <= MAX_UNPACKED_ROWS:
        return [rows(0, len(raw)) for rows in all_rows]
    scored = [(first, past) for first, past in _row_ranges(len(raw)) if raw[first:past].any()]
    return [pack(rows, len(raw), unit, scored) for rows, unit in zip(all_rows, units, strict=True)]


def pack(rows: Rows, length: int, unit: float = 1, among: RowRanges | None = None) -> Packed:
    """Pack a column in two passes: the first finds the type of its numbers, the second writes them.

    among: ranges that may have scores; None for all.
    """
    pages, marks, fits, scored, kind = [], [], np.zeros(len(NARROW_TYPES), np.int64), 0, rows(0, 0).dtype
    # First pass: find the ranges with scores, and how many numbers fit each type.
    busy = []  # ranges with scores
    for first, past in _row_ranges(length) if among is None else among:
        stretch = rows(first, past)
        if not stretch.any():
            continue
        busy.append((first, past))
        has_scored = _padded_pages(stretch != 0)
        some = np.flatnonzero(has_scored.any(axis=1))
        pages.append((first // PAGE + some).astype(np.int32))
        marks.append(np.packbits(has_scored[some], axis=1))
        units = stretch[stretch != 0] / unit
        scored += len(units)
        is_whole = (units == np.floor(units)) & (units >= 0)
        fits += [np.count_nonzero(is_whole & (units <= np.iinfo(narrow).max)) for narrow in NARROW_TYPES]
    # Second pass: write the numbers in the type that takes least memory.
    narrow = _smallest_type(fits, scored, kind)
    beside = scored - int(fits[NARROW_TYPES.index(narrow.type)]) if narrow.type in NARROW_TYPES else 0
    parts = empty_memmap(scored, narrow), empty_memmap(beside, np.int64), empty_memmap(beside, kind)
    _write(rows, busy, unit, *parts)
    return Packed(
        length,
        unit,
        np.concatenate([np.zeros(0, np.int32), *pages]),
        np.concatenate([np.zeros((0, PAGE // 8), np.uint8), *marks]),
        *parts,
    )


def _write(
    rows: Rows, among: RowRanges, unit: float, numbers: np.ndarray, places: np.ndarray, values: np.ndarray
) -> None:
    """Fill in the numbers of the scored rows; places and values of those that do not fit."""
    done, put = 0, 0
    for first, past in among:
        stretch = rows(first, past)
        scored = stretch[stretch != 0]
        into = numbers[done : done + len(scored)]
        if numbers.dtype == stretch.dtype:
            into[:] = scored
        else:
            units = scored / unit
            is_beside = (units != np.floor(units)) | (units < 0) | (units > np.iinfo(numbers.dtype).max)
            into[:] = np.where(is_beside, 0, units).astype(numbers.dtype)
            beside = np.flatnonzero(is_beside)
            places[put : put + len(beside)] = beside + done
            values[put : put + len(beside)] = scored[beside]
            put += len(beside)
        done += len(scored)
        for part in (numbers, places, values):
            release_pages(part)


def _smallest_type(fits: np.ndarray, scored: int, kind: np.dtype) -> np.dtype:
    """The type that takes least memory for `scored` numbers, of which `fits` fit each of the narrow types."""
    widths = np.array([np.dtype(narrow).itemsize for narrow in NARROW_TYPES])
    sizes = scored * widths + (scored - fits) * OUTLIER_BYTES
    return kind if sizes.min() >= scored * kind.itemsize else np.dtype(NARROW_TYPES[int(sizes.argmin())])


def _padded_pages(has_scored: np.ndarray) -> np.ndarray:
    """(pages, PAGE); the last page is padded."""
    missing = -len(has_scored) % PAGE
    return np.pad(has_scored, (0, missing)).reshape(-1, PAGE)


def _row_ranges(length: int) -> Iterator[tuple[int, int]]:
    return ((first, min(first + CHUNK_ROWS, length)) for first in range(0, length, CHUNK_ROWS))
