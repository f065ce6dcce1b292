"""Rows of the benchmark, and rates of several functions timed alternately."""

import time
from collections.abc import Callable

import numpy as np


def row(name: str, values: np.ndarray | float, unit: str, ratios: np.ndarray | None = None) -> dict:
    """Return {name, value, unit, ratio} with medians; ratio is None without a reference."""
    ratio = None if ratios is None else float(np.median(ratios))
    return {"name": name, "value": float(np.median(values)), "unit": unit, "ratio": ratio}


def rates(repeats: int, *works: Callable[[], int]) -> np.ndarray:
    """Call the functions in turn and return their rates [count/s], shape (works, repeats).

    Each function returns its count.  The first turn compiles and is dropped.
    """
    found = np.zeros((len(works), repeats + 1))
    for turn in range(repeats + 1):
        for number, work in enumerate(works):
            begun = time.perf_counter()
            done = work()
            found[number, turn] = done / (time.perf_counter() - begun)
    return found[:, 1:]
