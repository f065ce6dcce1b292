"""A benchmark's row, and rates of several works taken in turns."""

import time
from collections.abc import Callable

import numpy as np


def row(name: str, values: np.ndarray | float, unit: str, ratios: np.ndarray | None = None) -> dict:
    """{name, value, unit, ratio}: medians; ratio None where there is nothing to compare with."""
    ratio = None if ratios is None else float(np.median(ratios))
    return {"name": name, "value": float(np.median(values)), "unit": unit, "ratio": ratio}


def rates(repeats: int, *works: Callable[[], int]) -> np.ndarray:
    """What each of the works does a second, taken in turns: (works, repeats).  A first turn compiles and is not timed."""
    found = np.zeros((len(works), repeats + 1))
    for turn in range(repeats + 1):
        for number, work in enumerate(works):
            begun = time.perf_counter()
            done = work()
            found[number, turn] = done / (time.perf_counter() - begun)
    return found[:, 1:]
