"""The inverse of a cumulative distribution as polynomials in cells, for the engine to draw speeds from.

Each tail is cut into octaves of probability, each octave into 2^level cells with a polynomial of degree 5: as few as
keep it within 1e-13 of the function.  Where that cannot be (a kink, a jump, a gap) the cell holds 2^-12 of all draws at most
and is split at its steepest place, with a polynomial of degree 2 in the root of the way from there on either side: so it
is where a density comes down to 0.  A jump keeps its probability, and nothing is drawn beyond the function.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from transport.compile import layout

TOLERANCE = 1e-13  # of the largest value in a cell
ROUGH = 1e-6  # relative error from which a polynomial gives way to a split cell
MOST_LEVELS = 10
SPLIT, NEVER, HALVINGS = 6, 2.0, 45  # the column of a cell's split, beyond 1 where there is none
TERMS = 6
NODES = np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
CHECKS = np.linspace(-1.0, 1.0, 9)[:-1]
POWERS = np.arange(TERMS)
TO_COEFFICIENTS = np.linalg.inv(NODES[:, None] ** POWERS)

Quantile = Callable[[np.ndarray], np.ndarray]


@lru_cache(maxsize=64)
def quantile_table(quantile: Quantile) -> tuple[np.ndarray, np.ndarray]:
    """(octaves, cells) of a function of u in [0, 1): layout.OCTAVE of lower then upper tail, and (cells, CELL_TERMS)."""
    halves = {
        0: _constant(quantile),
        layout.OCTAVES: _constant(quantile),
    }  # octave 0: the probability 1/2 alone
    fitted, open_octaves = halves, [n for n in range(2 * layout.OCTAVES) if n not in halves]
    for level in range(MOST_LEVELS + 1):
        rows, errors = _fitted(quantile, open_octaves, level)
        for number, of_octave, error in zip(open_octaves, rows, errors, strict=True):
            is_upper, k = divmod(number, layout.OCTAVES)
            known = 2.0 ** (k - 51) if is_upper else 0.0  # as well as 1 - u knows its octave
            if (error <= max(TOLERANCE, known)).all() or level == MOST_LEVELS:
                rough = np.flatnonzero(error > max(ROUGH, known))
                of_octave[rough] = _split(quantile, number, level, rough)
                fitted[number] = level, of_octave
        open_octaves = [number for number in open_octaves if number not in fitted]
        if not open_octaves:
            break
    octaves, first = np.zeros(2 * layout.OCTAVES, layout.OCTAVE), 0
    for number in range(2 * layout.OCTAVES):
        level, rows = fitted[number]
        octaves[number]["cells"] = first | level << 32
        first += len(rows)
    return octaves, np.concatenate([fitted[number][1] for number in range(2 * layout.OCTAVES)])


def _constant(quantile: Quantile) -> tuple[int, np.ndarray]:
    return 0, _smooth(np.array([[float(quantile(np.array([0.5]))[0]), 0, 0, 0, 0, 0]]))


def _fitted(quantile: Quantile, numbers: list[int], level: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the octaves' 2^level cells, (octaves, cells, CELL_TERMS), and their relative errors, (octaves, cells)."""
    places = np.concatenate([NODES, CHECKS])
    octaves, cells = np.array(numbers)[:, None, None], np.arange(1 << level)[:, None]
    values = _values(quantile, octaves, level, cells, places)
    coefficients = values[..., :TERMS] @ TO_COEFFICIENTS.T
    wanted, found = values[..., TERMS:], coefficients @ (CHECKS[:, None] ** POWERS).T
    errors, sizes = np.abs(found - wanted).max(axis=-1), np.abs(wanted).max(axis=-1)
    return _smooth(coefficients), errors / np.where(sizes > 0, sizes, 1.0)


def _split(quantile: Quantile, number: int, level: int, cells: np.ndarray) -> np.ndarray:
    """Rows of cells with two pieces each, which meet where the function is steepest (found by halving)."""

    def at(place: np.ndarray) -> np.ndarray:
        return _values(quantile, np.array(number), level, cells, place)

    left, right = np.full(len(cells), -1.0), np.full(len(cells), 1.0)
    start, at_end = at(left), at(right)
    low, high = start, at_end
    for _ in range(HALVINGS if len(cells) else 0):
        middle = 0.5 * (left + right)
        value = at(middle)
        steeper_left = np.abs(value - low) > np.abs(high - value)
        left, low = np.where(steeper_left, left, middle), np.where(steeper_left, low, value)
        right, high = np.where(steeper_left, middle, right), np.where(steeper_left, value, high)
    rows = np.zeros((len(cells), layout.CELL_TERMS))
    for first, end, value, steep in ((0, -1.0, start, low), (3, 1.0, at_end, high)):
        way = np.abs(end - right)
        half = at(right + 0.25 * (end - right))  # half of the root of the way
        rows[:, first : first + 3] = _in_roots(np.sqrt(way), steep, half, value)
    rows[:, SPLIT] = right
    return rows


def _in_roots(root: np.ndarray, steep: np.ndarray, half: np.ndarray, value: np.ndarray) -> np.ndarray:
    """c0 + c1 s + c2 s² through values at s = 0, root/2 and root; straight in s² where that would not be monotone."""
    rise, safe = value - steep, np.where(root > 0, root, 1.0)
    bend = 2.0 * (rise - 2.0 * (half - steep))  # c2 root²
    slope = rise - bend  # c1 root
    monotone = (slope * rise >= 0) & ((slope + 2.0 * bend) * rise >= 0)
    slope, bend = np.where(monotone, slope, 0.0), np.where(monotone, bend, rise)
    return np.stack([steep, slope / safe, bend / safe**2], axis=1)


def _values(
    quantile: Quantile, numbers: np.ndarray, level: int, cells: np.ndarray, places: np.ndarray
) -> np.ndarray:
    """The function at places in [-1, 1] of cells of octaves, all broadcast, in a single call."""
    is_upper, k = np.divmod(numbers, layout.OCTAVES)
    x = np.ldexp(1.0 + (cells + 0.5 * (places + 1.0)) / (1 << level), -k - 1)
    u = np.where(is_upper == 1, np.minimum(1.0 - x, np.nextafter(1.0, 0.0)), x)
    return np.asarray(quantile(u.ravel()), float).reshape(u.shape)


def _smooth(coefficients: np.ndarray) -> np.ndarray:
    """Rows of polynomials, which are not split."""
    rows = np.zeros((*coefficients.shape[:-1], layout.CELL_TERMS))
    rows[..., :TERMS], rows[..., SPLIT] = coefficients, NEVER
    return rows


@lru_cache(maxsize=64)
def constant_quantile(speed: float) -> Quantile:
    """The quantile function of one speed."""
    return lambda u: np.full(np.shape(u), speed)


def has_steps(quantile: Quantile) -> bool:
    """Whether the function has jumps or kinks, so that some of its cells are split."""
    return bool((quantile_table(quantile)[1][:, SPLIT] <= 1.0).any())


def quantile_columns(plan, quantile: Quantile, unit: float | None = None) -> dict[str, int]:
    """Columns of layout.QUANTILES in a unit, the plan's of speeds [m/s] if none is given; the plan keeps the tables alive."""
    octaves, cells = quantile_table(quantile)
    cells = cells.copy()
    cells[:, :SPLIT] /= plan.speed_unit if unit is None else unit
    plan.kept += [octaves, cells]
    return {
        "octaves": octaves.ctypes.data,
        "octave_count": len(octaves),
        "cells": cells.ctypes.data,
        "cell_count": len(cells),
    }


def quantile_row(plan, quantile: Quantile, unit: float | None = None) -> np.ndarray:
    """The same as a row; in another unit than that of the plan's speeds."""
    return layout.row(layout.QUANTILES, **quantile_columns(plan, quantile, unit))
