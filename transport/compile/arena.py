"""The arena of a plan: one buffer with all arrays that tables refer to, each by its offset from the start."""

from __future__ import annotations

import threading
import weakref
from collections import deque

import numpy as np

from transport.compile import layout

LINE = 64  # [bytes] of a cache line; every array begins on one
LOCK = threading.Lock()  # threads that build or run programs of one plan share its arena


class Arena:
    """Arrays at fixed offsets in one buffer, so that tables stay valid wherever the buffer lies.

    An array must not change once it is placed: it is copied when the buffer is next needed, then released.
    """

    def __init__(self) -> None:
        self._memory = np.zeros(0, np.uint8)
        self._size = LINE  # offset 0 stands for no array
        self._waiting: deque[tuple[int, np.ndarray]] = deque()  # offsets and arrays that are not copied yet
        self._places: dict[int, tuple[weakref.ref, int]] = {}  # by id: array, offset

    def place(self, array: np.ndarray) -> int:
        """Give a contiguous array its place; return its offset [bytes], the same for the same array."""
        if not array.flags.c_contiguous:
            raise ValueError(f"an arena holds contiguous arrays, got strides {array.strides}")
        with LOCK:
            known, offset = self._places.get(id(array), (None, 0))
            if known is None or known() is not array:
                offset = self._size
                self._size += -(-max(1, array.nbytes) // LINE) * LINE
                self._waiting.append((offset, array))
                self._places[id(array)] = weakref.ref(array), offset
        return offset

    def table(self, *arrays: np.ndarray) -> np.ndarray:
        """Return a table that refers to one array of rows (layout.ROWS), or to two (layout.TWO_ROWS)."""
        kind = layout.ROWS if len(arrays) == 1 else layout.TWO_ROWS
        words = [word for array in arrays for word in (self.place(array), len(array))]
        return layout.row(kind, **dict(zip(kind.names, words, strict=True)))

    @property
    def memory(self) -> np.ndarray:
        """The buffer [bytes]; it is another one after more arrays have been placed."""
        with LOCK:
            if self._waiting:
                memory = _aligned(self._size)
                memory[: len(self._memory)] = self._memory
                while self._waiting:
                    offset, array = self._waiting.popleft()
                    memory[offset : offset + array.nbytes] = array.reshape(-1).view(np.uint8)
                self._memory = memory
            return self._memory

    def copy(self) -> Arena:
        """Return an arena with the same arrays at the same places, to which others are added apart."""
        other = Arena()
        other.__setstate__(self.memory)
        other._places = dict(self._places)
        return other

    def __getstate__(self) -> np.ndarray:
        return self.memory

    def __setstate__(self, memory: np.ndarray) -> None:
        self.__init__()
        self._memory = _aligned(len(memory))
        self._memory[:] = memory
        self._size = max(LINE, len(memory))


def _aligned(size: int) -> np.ndarray:
    """Return so many bytes that begin on a cache line, all 0."""
    memory = np.zeros(size + LINE, np.uint8)
    return memory[-memory.ctypes.data % LINE :][:size]
