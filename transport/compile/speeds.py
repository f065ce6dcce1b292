"""Inverse cumulative distributions as piecewise polynomials, from which the engine samples speeds.

Each tail is cut into octaves of probability, and each octave into 2^level cells with a polynomial of degree
5: as few as keep it within 1e-13 of the function. Where that is impossible (at a kink, a jump or a gap), the
cell holds 2^-12 of all samples at most and is split at its steepest place. Each side of the split has a
polynomial of degree 2 in the square root of the distance from the split, which is the shape at a density that
falls to 0. A jump keeps its probability, and no sample lies outside the function's range.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from transport.compile import layout
from transport.compile.plan import Plan, Step
from transport.geometry.shape import Shape
from transport.scene.emissions import Effusive, Gas
from transport.scene.pulses import BoxPulse, GaussianPulse, Instant
from transport.scene.sources import Source
from transport.scene.speeds import Maxwellian
from transport.validation import refuse
from transport.vectors import dot

TOLERANCE = 1e-13  # of the largest value in a cell
MAX_SMOOTH_ERROR = 1e-6  # relative error above which a polynomial is replaced by a split cell
MAX_LEVELS = 10
# SPLIT_COLUMN: column of a cell's split; NO_SPLIT: its value without a split, outside [-1, 1].
SPLIT_COLUMN, NO_SPLIT, BISECTIONS = 6, 2.0, 45
TERMS = 6
NODES = np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
CHECKS = np.linspace(-1.0, 1.0, 9)[:-1]
POWERS = np.arange(TERMS)
TO_COEFFICIENTS = np.linalg.inv(NODES[:, None] ** POWERS)

Quantile = Callable[[np.ndarray], np.ndarray]


@lru_cache(maxsize=64)
def quantile_table(quantile: Quantile) -> tuple[np.ndarray, np.ndarray]:
    """Return (octaves, cells) of a quantile function of u in [0, 1).

    octaves: layout.OCTAVE of the lower, then the upper tail; cells: shape (cells, CELL_TERMS).
    """
    # Octave 0 holds the probability 1/2 alone.
    halves = {0: _constant(quantile), layout.OCTAVES: _constant(quantile)}
    # Refine octaves until every cell is accurate; split the cells that stay rough at the last level.
    fitted, open_octaves = halves, [n for n in range(2 * layout.OCTAVES) if n not in halves]
    for level in range(MAX_LEVELS + 1):
        rows, errors = _fitted(quantile, open_octaves, level)
        for number, of_octave, error in zip(open_octaves, rows, errors, strict=True):
            is_upper, k = divmod(number, layout.OCTAVES)
            known = 2.0 ** (k - 51) if is_upper else 0.0  # accuracy to which 1 - u resolves the octave
            if (error <= max(TOLERANCE, known)).all() or level == MAX_LEVELS:
                rough = np.flatnonzero(error > max(MAX_SMOOTH_ERROR, known))
                of_octave[rough] = _split(quantile, number, level, rough)
                fitted[number] = level, of_octave
        open_octaves = [number for number in open_octaves if number not in fitted]
        if not open_octaves:
            break
    # Number the cells: the first one of each octave, with the level from bit 32 on.
    octaves, first = np.zeros(2 * layout.OCTAVES, layout.OCTAVE), 0
    for number in range(2 * layout.OCTAVES):
        level, rows = fitted[number]
        octaves[number]["cells"] = first | level << 32
        first += len(rows)
    return octaves, np.concatenate([fitted[number][1] for number in range(2 * layout.OCTAVES)])


def _constant(quantile: Quantile) -> tuple[int, np.ndarray]:
    """Return level 0 with one constant cell: the median."""
    return 0, _unsplit_rows(np.array([[float(quantile(np.array([0.5]))[0]), 0, 0, 0, 0, 0]]))


def _fitted(quantile: Quantile, numbers: list[int], level: int) -> tuple[np.ndarray, np.ndarray]:
    """Return rows of the octaves' 2^level cells, and their relative errors.

    Shapes (octaves, cells, CELL_TERMS) and (octaves, cells).
    """
    places = np.concatenate([NODES, CHECKS])
    octaves, cells = np.array(numbers)[:, None, None], np.arange(1 << level)[:, None]
    values = _values(quantile, octaves, level, cells, places)
    coefficients = values[..., :TERMS] @ TO_COEFFICIENTS.T
    wanted, found = values[..., TERMS:], coefficients @ (CHECKS[:, None] ** POWERS).T
    errors, sizes = np.abs(found - wanted).max(axis=-1), np.abs(wanted).max(axis=-1)
    return _unsplit_rows(coefficients), errors / np.where(sizes > 0, sizes, 1.0)


def _split(quantile: Quantile, number: int, level: int, cells: np.ndarray) -> np.ndarray:
    """Return rows of cells of two polynomials, which meet at the steepest place (by bisection)."""

    def at(place: np.ndarray) -> np.ndarray:
        return _values(quantile, np.array(number), level, cells, place)

    left, right = np.full(len(cells), -1.0), np.full(len(cells), 1.0)
    start, at_end = at(left), at(right)
    low, high = start, at_end
    for _ in range(BISECTIONS if len(cells) else 0):
        middle = 0.5 * (left + right)
        value = at(middle)
        steeper_left = np.abs(value - low) > np.abs(high - value)
        left, low = np.where(steeper_left, left, middle), np.where(steeper_left, low, value)
        right, high = np.where(steeper_left, middle, right), np.where(steeper_left, value, high)
    rows = np.zeros((len(cells), layout.CELL_TERMS))
    for first, end, value, steep in ((0, -1.0, start, low), (3, 1.0, at_end, high)):
        span = np.abs(end - right)
        half = at(right + 0.25 * (end - right))  # at half the square root of the distance
        rows[:, first : first + 3] = _root_polynomial(np.sqrt(span), steep, half, value)
    rows[:, SPLIT_COLUMN] = right
    return rows


def _root_polynomial(root: np.ndarray, steep: np.ndarray, half: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Return the coefficients of c0 + c1 s + c2 s² through values at s = 0, root/2 and root.

    It is linear in s² where it would not be monotone.
    """
    rise, safe = value - steep, np.where(root > 0, root, 1.0)
    bend = 2.0 * (rise - 2.0 * (half - steep))  # c2 root²
    slope = rise - bend  # c1 root
    monotone = (slope * rise >= 0) & ((slope + 2.0 * bend) * rise >= 0)
    slope, bend = np.where(monotone, slope, 0.0), np.where(monotone, bend, rise)
    return np.stack([steep, slope / safe, bend / safe**2], axis=1)


def _values(
    quantile: Quantile, numbers: np.ndarray, level: int, cells: np.ndarray, places: np.ndarray
) -> np.ndarray:
    """Return the function at places in [-1, 1] of cells of octaves, all broadcast, by a single call."""
    is_upper, k = np.divmod(numbers, layout.OCTAVES)
    x = np.ldexp(1.0 + (cells + 0.5 * (places + 1.0)) / (1 << level), -k - 1)
    u = np.where(is_upper == 1, np.minimum(1.0 - x, np.nextafter(1.0, 0.0)), x)
    return np.asarray(quantile(u.ravel()), float).reshape(u.shape)


def _unsplit_rows(coefficients: np.ndarray) -> np.ndarray:
    """Return rows of polynomials without a split."""
    rows = np.zeros((*coefficients.shape[:-1], layout.CELL_TERMS))
    rows[..., :TERMS], rows[..., SPLIT_COLUMN] = coefficients, NO_SPLIT
    return rows


@lru_cache(maxsize=64)
def constant_quantile(speed: float) -> Quantile:
    """Return the quantile function of a single speed."""
    return lambda u: np.full(np.shape(u), speed)


def has_split_cells(quantile: Quantile) -> bool:
    """Return whether some cells are split, because the function has jumps or kinks."""
    return bool((quantile_table(quantile)[1][:, SPLIT_COLUMN] <= 1.0).any())


def quantile_columns(plan, quantile: Quantile, unit: float | None = None) -> dict[str, int]:
    """Return the columns of layout.QUANTILES; the tables are in the arena of the plan.

    unit: of the values, by default the plan's unit of speed [m/s].
    """
    # Copies: the arena of equal scenes is the same, whether they share a law of speeds or have equal ones.
    octaves, cells = (array.copy() for array in quantile_table(quantile))
    cells[:, :SPLIT_COLUMN] /= plan.speed_unit if unit is None else unit
    return {
        "octaves": plan.arena.place(octaves),
        "octave_count": len(octaves),
        "cells": plan.arena.place(cells),
        "cell_count": len(cells),
    }


def quantile_row(plan, quantile: Quantile, unit: float | None = None) -> np.ndarray:
    """Return the same as a row of layout.QUANTILES."""
    return layout.row(layout.QUANTILES, **quantile_columns(plan, quantile, unit))


# ---- Time and speed of births: the passes, with the rows of their tables.

AT_REST = (0.0, 0.0, 0.0)


def birth_time_pass(source: Source, duration: float | None) -> Step | None:
    """Return the pass and row of the time of birth [durations]; None without a clock."""
    if duration is None:
        return None
    match source.pulse:
        case Instant(time=time):
            return "set_birth_time", layout.row(layout.BIRTH_TIME, start=time / duration)
        case BoxPulse(start=start, stop=stop):
            return "sample_birth_time", layout.row(
                layout.BIRTH_TIME, start=start / duration, width=(stop - start) / duration
            )
        case GaussianPulse(time=time, sigma=sigma):
            return "sample_pulse_time", layout.row(
                layout.BIRTH_TIME, start=time / duration, width=sigma / duration
            )
    if isinstance(source.emission, Gas):
        return "set_birth_time", layout.row(layout.BIRTH_TIME, start=0.0)
    return "sample_birth_time", layout.row(layout.BIRTH_TIME, start=0.0, width=1.0)


def speed_passes(plan: Plan, source: Source) -> tuple[Step, ...]:
    """Return the passes that sample the speed and add the drift, after the direction is sampled."""
    emission, nothing = source.emission, layout.row(layout.NO_TABLE)
    unit = plan.speed_unit
    if isinstance(emission.speed, float):
        speed = emission.speed / unit
        if not math.isfinite(speed):
            refuse(source, f"speed must cross the scene in a finite part of its duration, got {speed}")
        return (("set_speed", layout.row(layout.VELOCITY, vx=speed)),)
    drift = getattr(emission.speed, "drift", AT_REST)
    if isinstance(emission, Effusive):
        if drift != AT_REST:
            return ()  # the pass of drifting_law samples speed and direction together
        quantile = emission.speed.flux_quantile
    else:
        quantile = emission.speed.quantile if emission.direction is None else emission.speed.line_quantile
    take = "set_speed_by_stepped_quantile" if has_split_cells(quantile) else "set_speed_by_quantile"
    steps = [("draw_speed_uniform", nothing), (take, quantile_row(plan, quantile))]
    if drift != AT_REST or getattr(emission, "direction", None) is not None:
        steps.append(("add_drift", layout.row(layout.VELOCITY, **_velocity(drift, unit))))
    return tuple(steps)


def drifting_law(plan: Plan, source: Source, shape: Shape) -> Step | None:
    """Return the pass that samples velocities of a drifting gas effusing through a plane.

    None for all sources but an Effusive one with a drifting Maxwellian.
    """
    emission = source.emission
    if not isinstance(emission, Effusive) or getattr(emission.speed, "drift", AT_REST) == AT_REST:
        return None
    e_u, e_v, normal = shape.frame
    side, unit = -1.0 if source.is_back else 1.0, plan.speed_unit
    drift = emission.speed.drift
    values = layout.frame_columns((e_u, e_v, normal)) | {"side": side, "sigma": emission.speed.sigma / unit}
    values |= {"drift_u": dot(drift, e_u) / unit, "drift_v": dot(drift, e_v) / unit}
    values |= quantile_columns(plan, _normal_quantile(emission.speed, side * dot(drift, normal)))
    return "emit_from_drifting_gas", layout.row(layout.DRIFTING_GAS, **values)


@lru_cache(maxsize=64)
def _normal_quantile(speed: Maxwellian, drift: float):
    return lambda u: speed.normal_quantile(u, drift)


def _velocity(drift: tuple[float, float, float], unit: float) -> dict[str, float]:
    return {name: component / unit for name, component in zip(("vx", "vy", "vz"), drift, strict=True)}
