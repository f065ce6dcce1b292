"""What the benchmarks share: rates of functions that are called in turns, and memory of this process."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np


def rates(
    repeats: int, *works: Callable[[], int], clock: Callable[[], float] = time.perf_counter
) -> np.ndarray:
    """Call the functions in turn and return their rates [count/s], shape (works, repeats).

    Each function returns its count.  The first turn compiles and is dropped.
    """
    found = np.zeros((len(works), repeats + 1))
    for turn in range(repeats + 1):
        for number, work in enumerate(works):
            begun = clock()
            done = work()
            found[number, turn] = done / (clock() - begun)
    return found[:, 1:]


def memory(entry: str = "VmRSS") -> float:
    """Return the memory of this process [bytes]: "VmRSS" now resident, "VmHWM" at most; nan if unknown."""
    status = Path("/proc/self/status")
    if not status.exists():
        return math.nan
    return 1024.0 * float(status.read_text().partition(f"{entry}:")[2].split()[0])
