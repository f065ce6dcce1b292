"""A long column of sums, of which many rows are zero and most others small, kept without loss in a few bytes a row.

Pages of rows without a score are left out.  In the others a bit a row tells whether it has scored, and of those that have
the numbers are kept in the narrowest kind that nearly all of them fit, in units of the column's; the few others beside.
Very many numbers lie aside, in a file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from transport.results.aside import let_go, put_aside, room_for

PAGE = 1 << 12  # rows
STRETCH = 1 << 17  # rows that are looked at together, whole pages
MOST_PLAIN = 1 << 18  # rows of a column that is kept as it is
NARROW = (np.uint8, np.uint16, np.uint32)
BYTES_BESIDE = 16  # of a number that is kept beside, with its place
ASIDE = ("numbers", "places", "values")  # what may lie aside


@dataclass(frozen=True, eq=False)
class Packed:
    """A column of `length` rows, of which slices, sums and the like are those of the array that it stands for.

    pages: numbers of those with scores, rising, (P,);  marks: (P, PAGE / 8), a bit a row;  numbers: of the rows that have
    scored, of `unit` where they are whole, else the values;  places, values: in `numbers` of those that are too large for it.
    """

    length: int
    unit: float
    pages: np.ndarray
    marks: np.ndarray
    numbers: np.ndarray
    places: np.ndarray
    values: np.ndarray

    def __post_init__(self) -> None:
        for name in ASIDE:
            object.__setattr__(self, name, put_aside(getattr(self, name)))

    def __reduce__(self) -> tuple:
        """As it is sent to another process, where its file is not."""
        parts = (np.asarray(getattr(self, name)) for name in ASIDE)
        return Packed, (self.length, self.unit, self.pages, self.marks, *parts)

    @property
    def dtype(self) -> np.dtype:
        return self.values.dtype

    @property
    def shape(self) -> tuple[int]:
        return (self.length,)

    @property
    def nbytes(self) -> int:
        """What it takes, in memory and aside."""
        return sum(part.nbytes for part in (self.pages, self.marks, self.numbers, self.places, self.values))

    @cached_property
    def firsts(self) -> np.ndarray:
        """Where in `numbers` those of each page begin, and at last how many there are, (P + 1,)."""
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
            pages[np.unpackbits(self.marks[one:other], axis=1).view(bool)] = self._scored(one, other)
            found[self.pages[one:other] - low] = pages
        return found.ravel()[first - low * PAGE : max(first, past) - low * PAGE]

    def _scored(self, one: int, other: int) -> np.ndarray:
        """The values of the rows that have scored in pages from one to another."""
        first, past = self.firsts[[one, other]]
        values = np.array(self.numbers[first:past], self.dtype)
        if self.numbers.dtype != self.dtype:
            if self.unit != 1:
                values *= self.unit
            low, high = np.searchsorted(self.places, (first, past))
            values[self.places[low:high] - first] = self.values[low:high]
        for name in ASIDE:
            let_go(getattr(self, name))
        return values

    def __array__(self, dtype: object = None, copy: bool | None = None) -> np.ndarray:
        return np.asarray(self[:], dtype)

    def __add__(self, other: Packed) -> Packed:
        pages = np.concatenate([self.pages, other.pages]).astype(np.int64)
        firsts = (np.unique(pages * PAGE // STRETCH) * STRETCH).tolist()
        among = [(first, min(first + STRETCH, self.length)) for first in firsts]
        return packed(lambda first, past: self[first:past] + other[first:past], self.length, self.unit, among)

    def sum(self) -> float | int:
        """Of all rows."""
        return sum(stretch.sum() for stretch in self._stretches())

    def max(self) -> float | int:
        """The largest."""
        return max(stretch.max() for stretch in self._stretches())

    def _stretches(self) -> Iterator[np.ndarray]:
        return (self[first:past] for first, past in _stretches(self.length))


Rows = Callable[[int, int], np.ndarray]  # of a column, from one to another
Stretches = list[tuple[int, int]]  # of rows, of whole pages but for the last


def columns(all_rows: list[Rows], units: list[float], raw: np.ndarray) -> list[np.ndarray | Packed]:
    """The columns that are made of raw rows: arrays, or packed where they are long.

    units: powers of two, of which most numbers are a whole number of times;  raw: all zero where nothing has scored.
    """
    if len(raw) <= MOST_PLAIN:
        return [rows(0, len(raw)) for rows in all_rows]
    scored = [(first, past) for first, past in _stretches(len(raw)) if raw[first:past].any()]
    return [packed(rows, len(raw), unit, scored) for rows, unit in zip(all_rows, units, strict=True)]


def packed(rows: Rows, length: int, unit: float = 1, among: Stretches | None = None) -> Packed:
    """A column, packed: what kind of numbers it holds is looked at first, then they are written down.

    among: the stretches in which there may be scores; None for all.
    """
    pages, marks, fits, scored, kind = [], [], np.zeros(len(NARROW), np.int64), 0, rows(0, 0).dtype
    busy = []  # stretches
    for first, past in _stretches(length) if among is None else among:
        stretch = rows(first, past)
        if not stretch.any():
            continue
        busy.append((first, past))
        has_scored = _paged(stretch != 0)
        some = np.flatnonzero(has_scored.any(axis=1))
        pages.append((first // PAGE + some).astype(np.int32))
        marks.append(np.packbits(has_scored[some], axis=1))
        units = stretch[stretch != 0] / unit
        scored += len(units)
        is_whole = (units == np.floor(units)) & (units >= 0)
        fits += [np.count_nonzero(is_whole & (units <= np.iinfo(narrow).max)) for narrow in NARROW]
    narrow = _narrowest(fits, scored, kind)
    beside = scored - int(fits[NARROW.index(narrow.type)]) if narrow.type in NARROW else 0
    parts = room_for(scored, narrow), room_for(beside, np.int64), room_for(beside, kind)
    _write(rows, busy, unit, *parts)
    return Packed(
        length,
        unit,
        np.concatenate([np.zeros(0, np.int32), *pages]),
        np.concatenate([np.zeros((0, PAGE // 8), np.uint8), *marks]),
        *parts,
    )


def _write(
    rows: Rows, among: Stretches, unit: float, numbers: np.ndarray, places: np.ndarray, values: np.ndarray
) -> None:
    """Fill in the numbers of rows that have scored; places and values of those that do not fit."""
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
            let_go(part)


def _narrowest(fits: np.ndarray, scored: int, kind: np.dtype) -> np.dtype:
    """In which kind of number so many, of which so many fit each of the narrow ones, take the least memory."""
    widths = np.array([np.dtype(narrow).itemsize for narrow in NARROW])
    sizes = scored * widths + (scored - fits) * BYTES_BESIDE
    return kind if sizes.min() >= scored * kind.itemsize else np.dtype(NARROW[int(sizes.argmin())])


def _paged(has_scored: np.ndarray) -> np.ndarray:
    """(pages, PAGE), the last page filled up."""
    missing = -len(has_scored) % PAGE
    return np.pad(has_scored, (0, missing)).reshape(-1, PAGE)


def _stretches(length: int) -> Iterator[tuple[int, int]]:
    return ((first, min(first + STRETCH, length)) for first in range(0, length, STRETCH))
