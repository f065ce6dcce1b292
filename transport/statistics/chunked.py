"""Chunked arrays: batch values in very many bins, computed box by box to limit memory.

The batches are kept for every bin, packed (packed.py): measured, 18 bytes per bin with one score in it and 63
with ten, less than the means and variances of its six scores would take.  So ratios, sums over bins, pooled
errors, merged and resumed runs are the same as for few bins.

The cost of a box of bins is that of its rows if these are adjacent, so boxes are cut along the axis whose
bins are farthest apart in memory.
"""

from __future__ import annotations

import contextlib
import math
import mmap
import os
from collections.abc import Callable, Iterator
from functools import cached_property
from pathlib import Path

import numpy as np

from transport.statistics.replicates import Batches, Replicates

MAX_ARRAY_SIZE = 1 << 24  # numbers of batches in one array
MAX_CHUNK_SIZE = 1 << 20  # numbers of batches in a box
Box = tuple[slice, ...]  # of bins, one slice per axis


class ChunkedArray:
    """A virtual array (B, *dims) with the arithmetic that readings need before they make estimates.

    part: function that computes a box, (B, *its lengths);  order: axes of the bins, those farthest apart in
    memory first.
    """

    __array_ufunc__ = None  # NumPy defers to the operators of this class

    def __init__(self, shape: tuple[int, ...], order: tuple[int, ...], part: Callable[[Box], np.ndarray]):
        self.shape, self.order, self.part = shape, order, part

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)

    def __len__(self) -> int:
        return self.shape[0]

    def __mul__(self, other: object) -> ChunkedArray:
        return self._elementwise(other, np.multiply)

    def __truediv__(self, other: object) -> ChunkedArray:
        return self._elementwise(other, np.divide)

    def __add__(self, other: object) -> ChunkedArray:
        return self._elementwise(other, np.add)

    __radd__ = __add__  # for sum(), which starts with 0

    def boxes(self) -> list[Box]:
        """Boxes of limited size that together contain every bin once."""
        return boxes_of(self.shape[1:], self.order, MAX_CHUNK_SIZE // len(self))

    def any(self) -> bool:
        """Return whether any number is nonzero."""
        return any(self.part(box).any() for box in self.boxes())

    def all(self) -> bool:
        """Return whether all numbers are nonzero."""
        return all(self.part(box).all() for box in self.boxes())

    def _elementwise(self, other: object, function: Callable) -> ChunkedArray:
        return ChunkedArray(
            self.shape, self.order, lambda box: function(self.part(box), _cut_operand(other, box, self.ndim))
        )


def is_large(shape: tuple[int, ...]) -> bool:
    """Return whether numbers of this shape, (B, *dims), are too many for one array, but not of one batch."""
    return shape[0] > 1 and math.prod(shape) > MAX_ARRAY_SIZE


def batch_totals(values: np.ndarray | ChunkedArray) -> np.ndarray:
    """Sums of each batch over all bins, (B,)."""
    if isinstance(values, ChunkedArray):
        return sum(batch_totals(values.part(box)) for box in values.boxes())
    return values.reshape(len(values), -1).sum(axis=1)


def summed_counts(counts: np.ndarray | ChunkedArray) -> np.ndarray | ChunkedArray:
    """Counts (B, *dims) as an argument of EstimateArray: summed over batches, or chunked counts unchanged."""
    return counts if isinstance(counts, ChunkedArray) else counts.sum(axis=0)


def over_batches(values: np.ndarray | ChunkedArray) -> np.ndarray:
    """Sums over the batches, (*dims)."""
    if not isinstance(values, ChunkedArray):
        return values.sum(axis=0)
    found = np.zeros(values.shape[1:])
    for box in values.boxes():
        found[box] = values.part(box).sum(axis=0)
    return found


def independent_scores(values: np.ndarray | ChunkedArray) -> np.ndarray:
    """Number of independent scores of 1 that spread as much from batch to batch, at most their sum, (*dims).

    One history may score very often: then its scores count as one.

    Parameters
    ----------
    values : (B, *dims)
        Sums of scores of at most 1 each.

    Examples
    --------
    Of 32 batches one has 100 scores, or each has about three:

    >>> one, each = np.zeros(32), np.tile([2.0, 3.0, 4.0, 3.0], 8)
    >>> one[3] = 100
    >>> independent_scores(one).round(1).item(), independent_scores(each).round(1).item()
    (1.0, 96.0)
    """
    if isinstance(values, ChunkedArray):
        found = np.zeros(values.shape[1:])
        for box in values.boxes():
            found[box] = independent_scores(values.part(box))
        return found
    many, total = len(values), values.sum(axis=0)
    if many == 1:
        return np.minimum(total, 1.0)
    variance = ((values - total / many) ** 2).sum(axis=0) * many / (many - 1)  # of the sum
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(variance > 0, np.minimum(total, total**2 / variance), total)


def boxes_of(bins: tuple[int, ...], order: tuple[int, ...], most: int) -> list[Box]:
    """Boxes of at most `most` bins each, or of one, that together are all bins."""
    boxes, left = [[slice(0, count) for count in bins]], math.prod(bins)
    for axis in order:
        if left <= most:
            break
        left //= max(1, bins[axis])  # bins per step along this axis
        step = max(1, most // max(1, left))
        cuts = [slice(k, min(k + step, bins[axis])) for k in range(0, bins[axis], step)]
        boxes = [[*box[:axis], cut, *box[axis + 1 :]] for box in boxes for cut in cuts]
        left *= step
    return [tuple(box) for box in boxes]


def box_lengths(box: Box, bins: tuple[int, ...]) -> tuple[int, ...]:
    """Lengths of a box along the axes."""
    return tuple(len(range(*along.indices(count))) for along, count in zip(box, bins, strict=True))


def cut_to_box(array: np.ndarray, box: Box) -> np.ndarray:
    """The part in a box of an array whose last axes are those of the bins, or have length 1."""
    along = [
        slice(None) if length == 1 else one for one, length in zip(box[::-1], array.shape[::-1], strict=False)
    ]
    return array[(..., *along[::-1])]


def _cut_operand(other: object, box: Box, ndim: int) -> object:
    """The part in a box of the other operand."""
    if isinstance(other, ChunkedArray):
        return other.part(box)
    return cut_to_box(other, box) if isinstance(other, np.ndarray) else other


# ---- Memory-mapped arrays: an anonymous temporary file holds the numbers, and only pages in use take memory.
#
# The file disappears with the array.  Arrays stay in memory if temporary files lie in memory, the disk is
# full or no file can be mapped.

MIN_MAPPED_BYTES = 1 << 24  # bytes, from which on arrays are memory-mapped
MOUNTS = Path("/proc/mounts")
MEMORY_FILE_SYSTEMS = ("tmpfs", "ramfs")  # file systems in memory


def empty_memmap(shape: int | tuple[int, ...], kind: np.dtype | type) -> np.ndarray:
    """Allocate an uninitialised array, memory-mapped if it is large."""
    kind = np.dtype(kind)
    size = math.prod(shape if isinstance(shape, tuple) else (shape,)) * kind.itemsize
    if size >= MIN_MAPPED_BYTES and can_map_files():
        import tempfile  # not at the top: it imports `random`, which a user's file may shadow

        with contextlib.suppress(OSError), tempfile.TemporaryFile() as file:
            # Allocate the disk space here, where a full disk raises an error; a later write would kill the
            # process.
            os.posix_fallocate(file.fileno(), 0, size)
            return np.memmap(file, kind, "r+", shape=shape)
    return np.empty(shape, kind)


def to_memmap(numbers: np.ndarray) -> np.ndarray:
    """Move an array to a memory-mapped file if it is large; otherwise return it unchanged."""
    if numbers.nbytes < MIN_MAPPED_BYTES or isinstance(numbers, np.memmap):
        return numbers
    room = empty_memmap(numbers.shape, numbers.dtype)
    if not isinstance(room, np.memmap):
        return numbers
    room[...] = numbers
    release_pages(room)
    return room


def release_pages(numbers: np.ndarray) -> None:
    """Release the resident pages of a memory-mapped array (madvise DONTNEED); its file keeps the numbers."""
    if isinstance(numbers, np.memmap) and numbers._mmap is not None:
        numbers._mmap.madvise(mmap.MADV_DONTNEED)


def can_map_files() -> bool:
    """Return whether temporary files can be mapped and do not lie in memory themselves."""
    if not (hasattr(os, "posix_fallocate") and hasattr(mmap, "MADV_DONTNEED")):
        return False
    import tempfile

    folder, kinds = Path(tempfile.gettempdir()).resolve(), {}
    with contextlib.suppress(OSError):
        lines = (line.split() for line in MOUNTS.read_text().splitlines())
        kinds = {Path(line[1]): line[2] for line in lines}  # the last file system mounted at each place
    on = next((place for place in (folder, *folder.parents) if place in kinds), None)
    return on is not None and kinds[on] not in MEMORY_FILE_SYSTEMS


def free_disk_bytes() -> int:
    """Free disk space for temporary files [bytes]; 0 if they cannot be used."""
    import shutil
    import tempfile

    return shutil.disk_usage(tempfile.gettempdir()).free if can_map_files() else 0


# ---- Chunked replicates of very many bins: values and errors are memory-mapped, deviations are recomputed.
#
# Arithmetic is also done by chunk, when its values are read, with the functions for plain replicates.


class ChunkedReplicates(Replicates):
    """Replicates of `bins`, computed in boxes.

    part: function that computes those of a box;  order: axes, in the order in which boxes are cut.  An
    operation on the deviations of all bins at once gets them, and takes their memory.
    """

    is_chunked = True

    def __init__(
        self,
        bins: tuple[int, ...],
        order: tuple[int, ...],
        runs: tuple[Batches, ...],
        is_exact: bool,
        part: Callable[[Box], Replicates],
    ) -> None:
        batches = max(len(run) for run in runs)
        boxes = boxes_of(bins, order, max(1, MAX_CHUNK_SIZE // batches))
        known = {"bins": bins, "order": order, "runs": runs, "part": part, "boxes": boxes, "exact": is_exact}
        vars(self).update(known)  # the dataclass is frozen, and its other fields are computed below

    @classmethod
    def of_batches(
        cls, values: ChunkedArray, run: Batches, exact: bool, counts: ChunkedArray | None
    ) -> ChunkedReplicates:
        """Make chunked replicates from batch means, (B, *dims), and counts of scores by batch, if known."""

        def part(box: Box) -> Replicates:
            scores = None if counts is None else counts.part(box).sum(axis=0)
            return Replicates.of_batches(values.part(box), run, exact, scores)

        return cls(values.shape[1:], values.order, (run,), exact, part)

    @property
    def is_exact(self) -> bool:
        """Whether the value is the same for every history by construction."""
        return self.exact

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of bins along the axes."""
        return self.bins

    @cached_property
    def value(self) -> np.ndarray:
        """Mean values, (*dims), memory-mapped."""
        return np.asarray(self._known[0])

    @cached_property
    def error(self) -> np.ndarray:
        """One standard error, (*dims), memory-mapped; nan where it cannot be known, see `reason`."""
        return np.asarray(self._known[1])

    @cached_property
    def _known(self) -> tuple[np.ndarray, np.ndarray]:
        """Values and errors, from one pass over the batches."""
        known = empty_memmap(self.bins, float), empty_memmap(self.bins, float)
        for box in self.boxes:
            part = self.part(box)
            for room, numbers in zip(known, (part.value, part.error), strict=True):
                room[box] = numbers
                release_pages(room)
        for room in known:
            room.flags.writeable = False
        return known

    def release_pages(self) -> None:
        """Release the memory-mapped pages of values and errors until the next access."""
        for room in self._known:
            release_pages(room)

    @property
    def reason(self) -> np.ndarray:
        """Reason why the error is unknown, (*dims) of str; None where it is known."""
        return self._gathered(lambda part: part.reason, object)

    @property
    def dof(self) -> np.ndarray:
        """Degrees of freedom of the error, (*dims)."""
        return self._gathered(lambda part: part.dof, float)

    @property
    def scores(self) -> np.ndarray:
        """Numbers of scores, (*dims)."""
        return self._gathered(lambda part: part.scores, float)

    @property
    def scale(self) -> np.ndarray:
        """Scale of the values for judging rounding, (*dims)."""
        return self._gathered(lambda part: part.scale, float)

    @property
    def deviations(self) -> dict[Batches, np.ndarray]:
        """Deviations of the batches from the value by run, (B, *dims), gathered in memory; none if exact."""
        whole = {} if self.exact else {run: np.empty((len(run), *self.bins)) for run in self.runs}
        for box in self.boxes if whole else ():
            for run, of_run in self.part(box).deviations.items():
                whole[run][(slice(None), *box)] = of_run
        return whole

    def unless(self, too_few: np.ndarray) -> ChunkedReplicates:
        """Return these replicates with unknown error where `too_few`, (*dims) of bool, is true."""
        return self._made(lambda box: self.part(box).unless(cut_to_box(np.asarray(too_few), box)))

    def indexed(self, index: tuple[int | slice, ...]) -> Replicates:
        """Replicates of the bins of an index; in memory if they fit into one chunk."""
        starts = [along if isinstance(along, slice) else slice(along, along + 1 or None) for along in index]
        box = tuple(slice(*along.indices(count)[:2]) for along, count in zip(starts, self.bins, strict=True))
        if np.prod(box_lengths(box, self.bins)) * max(map(len, self.runs)) > MAX_CHUNK_SIZE:
            return super().indexed(index)
        inner = tuple(slice(None) if isinstance(along, slice) else 0 for along in index)
        return self.part(box).indexed(inner)

    def along(self, own: tuple[str, ...], dims: tuple[str, ...]) -> Replicates:
        """Rearrange axes `own` into the order of `dims`; missing axes get length 1."""
        return self if own == dims else super().along(own, dims)

    def summed(self, axis: int) -> Replicates:
        """Replicates of the sum over a bin axis, in memory, summed chunk by chunk."""
        axis %= len(self.bins)
        left = self.bins[:axis] + self.bins[axis + 1 :]
        value, scale, scores = np.zeros(left), np.zeros(left), np.zeros(left)
        deviations = {} if self.exact else {run: np.zeros((len(run), *left)) for run in self.runs}
        for box in self.boxes:
            part, into = self.part(box).summed(axis - len(self.bins)), box[:axis] + box[axis + 1 :]
            value[into] += part.value
            scale[into] += part.scale
            scores[into] += part.scores
            for run, of_run in part.deviations.items():
                deviations[run][(slice(None), *into)] += of_run
        return Replicates(value, deviations, scores, self.runs, scale)

    def mapped(
        self, function: Callable[..., Replicates], operands: tuple[Replicates, ...]
    ) -> ChunkedReplicates:
        """A function of replicates with these bins, or one along an axis; this object is one of them."""
        uncertain = [run for each in operands if not each.is_exact for run in each.runs]
        runs = tuple(dict.fromkeys(uncertain or [run for each in operands for run in each.runs]))

        def part(box: Box) -> Replicates:
            return function(*(_in_box(each, box) for each in operands))

        return ChunkedReplicates(self.bins, self.order, runs, not uncertain, part)

    def _made(self, part: Callable[[Box], Replicates]) -> ChunkedReplicates:
        return ChunkedReplicates(self.bins, self.order, self.runs, self.exact, part)

    def _gathered(self, read: Callable[[Replicates], np.ndarray], kind: type) -> np.ndarray:
        found = np.empty(self.bins, kind)
        for box in self.boxes:
            found[box] = read(self.part(box))
        return found


def replicates_of(
    values: np.ndarray | ChunkedArray, run: Batches, exact: bool, counts: np.ndarray | ChunkedArray | None
) -> Replicates:
    """Make replicates from the means of the batches, (B, *dims); counts: (*dims), or by batch if chunked."""
    kind = ChunkedReplicates if isinstance(values, ChunkedArray) else Replicates
    return kind.of_batches(values, run, exact, counts)


def _in_box(replicates: Replicates, box: Box) -> Replicates:
    if replicates.is_chunked:
        return replicates.part(box)
    return replicates.rearranged(lambda array: cut_to_box(array, box))


# ---- Memory that this process may still use, from the system and its control groups.

MIN_FREE = 1 << 28  # bytes assumed to be available
PROC_FOLDER, CGROUP_FOLDER = Path("/proc"), Path("/sys/fs/cgroup")


def available_memory() -> int | None:
    """Bytes that this process may still use, from the system and its control groups; None if unknown."""
    return min(_limits(), default=None)


def _limits() -> Iterator[int]:
    """Limits on further memory [bytes]."""
    with contextlib.suppress(OSError, ValueError, KeyError):
        yield _fields(PROC_FOLDER / "meminfo")["MemAvailable"] * 1024
    groups = []
    with contextlib.suppress(OSError):
        groups = [line.split(":", 2) for line in (PROC_FOLDER / "self/cgroup").read_text().splitlines()]
    for _, controllers, path in groups:
        if controllers == "":  # version 2
            yield from _cgroup_limits(CGROUP_FOLDER, path, "memory.max", "memory.current", "inactive_file")
        elif "memory" in controllers.split(","):
            names = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
            yield from _cgroup_limits(CGROUP_FOLDER / "memory", path, *names)


def _cgroup_limits(root: Path, path: str, most: str, used: str, cache: str) -> Iterator[int]:
    """Memory left by a control group and its ancestors; page cache counts as free."""
    here = Path(path.lstrip("/"))
    for group in (here, *here.parents):
        with contextlib.suppress(OSError, ValueError):
            limit = int((root / group / most).read_text())  # "max" (ValueError) if there is no limit
            remembered = _fields(root / group / "memory.stat").get(cache, 0)
            yield max(0, limit - int((root / group / used).read_text()) + remembered)


def _fields(path: Path) -> dict[str, int]:
    """Numbers of a file with lines of name and number."""
    lines = (line.replace(":", " ").split() for line in path.read_text().splitlines())
    return {line[0]: int(line[1]) for line in lines if len(line) > 1}


def size_text(number: float) -> str:
    """Number of bytes in MB, GB or TB."""
    if number >= 1e12:
        return f"{number / 1e12:.3g} TB"
    return f"{number / 1e9:.3g} GB" if number >= 1e9 else f"{number / 1e6:.3g} MB"
