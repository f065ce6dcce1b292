"""The inverse of a cumulative distribution as polynomials in cells, for the engine to draw speeds from.

Each tail is cut into octaves of probability, each octave into 2^level cells with a polynomial of degree 5: as few as
keep it within 1e-13 of the function.  Where that cannot be (a kink, a jump) a cell holds less than 2^-20 of all draws.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from transport import layout

TOLERANCE = 1e-13  # of the largest value in a cell
MOST_LEVELS, RAREST = 10, 20  # a cell's probability need not be below 2^-RAREST
TERMS = 6
NODES = np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
CHECKS = np.linspace(-1.0, 1.0, 9)[:-1]
POWERS = np.arange(TERMS)
TO_COEFFICIENTS = np.linalg.inv(NODES[:, None] ** POWERS)

Quantile = Callable[[np.ndarray], np.ndarray]


@lru_cache(maxsize=64)
def quantile_table(quantile: Quantile) -> tuple[np.ndarray, np.ndarray]:
    """(octaves, cells) of a function of u in [0, 1): layout.OCTAVE of lower then upper tail, and (cells, CELL_TERMS)."""
    fitted = {
        0: _constant(quantile),
        layout.OCTAVES: _constant(quantile),
    }  # octave 0: the probability 1/2 alone
    open_octaves = [number for number in range(2 * layout.OCTAVES) if number not in fitted]
    for level in range(MOST_LEVELS + 1):
        coefficients, is_good = _fitted(quantile, open_octaves, level)
        for number, rows, good in zip(open_octaves, coefficients, is_good, strict=True):
            if good or level >= _most_levels(number):
                fitted[number] = level, rows
        open_octaves = [number for number in open_octaves if number not in fitted]
        if not open_octaves:
            break
    octaves, first = np.zeros(2 * layout.OCTAVES, layout.OCTAVE), 0
    for number in range(2 * layout.OCTAVES):
        level, rows = fitted[number]
        octaves[number]["first"], octaves[number]["level"] = first, level
        first += len(rows)
    return octaves, _padded(np.concatenate([fitted[number][1] for number in range(2 * layout.OCTAVES)]))


def _most_levels(number: int) -> int:
    return max(0, min(MOST_LEVELS, RAREST - number % layout.OCTAVES))


def _constant(quantile: Quantile) -> tuple[int, np.ndarray]:
    return 0, np.array([[float(quantile(np.array([0.5]))[0]), 0, 0, 0, 0, 0]])


def _fitted(quantile: Quantile, numbers: list[int], level: int) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients of the octaves' 2^level cells, (octaves, cells, TERMS), and whether those of an octave are good."""
    values = _values(quantile, numbers, level, np.concatenate([NODES, CHECKS]))
    nodes, wanted = values[..., :TERMS], values[..., TERMS:]
    coefficients = nodes @ TO_COEFFICIENTS.T
    found = coefficients @ (CHECKS[:, None] ** POWERS).T
    is_good = np.abs(found - wanted) <= TOLERANCE * np.abs(wanted).max(axis=-1, keepdims=True)
    return coefficients, is_good.all(axis=(1, 2))


def _values(quantile: Quantile, numbers: list[int], level: int, places: np.ndarray) -> np.ndarray:
    """The function at places in [-1, 1] of each cell, (octaves, cells, places), in a single call."""
    is_upper, k = np.divmod(np.array(numbers)[:, None, None], layout.OCTAVES)
    cells = np.arange(1 << level)[:, None]
    x = np.ldexp(1.0 + (cells + 0.5 * (places + 1.0)) / (1 << level), -k - 1)
    u = np.where(is_upper == 1, np.minimum(1.0 - x, np.nextafter(1.0, 0.0)), x)
    return np.asarray(quantile(u.ravel()), float).reshape(u.shape)


def _padded(coefficients: np.ndarray) -> np.ndarray:
    rows = np.zeros((len(coefficients), layout.CELL_TERMS))
    rows[:, :TERMS] = coefficients
    return rows


@lru_cache(maxsize=64)
def constant_quantile(speed: float) -> Quantile:
    """The quantile function of one speed."""
    return lambda u: np.full(np.shape(u), speed)


def quantile_columns(plan, quantile: Quantile) -> dict[str, int]:
    """Columns of layout.QUANTILES for speeds [m/s] in the plan's units; the plan keeps the tables alive."""
    octaves, cells = quantile_table(quantile)
    cells = cells / plan.space.size * plan.tempo
    plan.kept += [octaves, cells]
    return {
        "octaves": octaves.ctypes.data,
        "octave_count": len(octaves),
        "cells": cells.ctypes.data,
        "cell_count": len(cells),
    }


def quantile_row(plan, quantile: Quantile) -> np.ndarray:
    """The same as a row."""
    return layout.row(layout.QUANTILES, **quantile_columns(plan, quantile))
