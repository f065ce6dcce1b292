"""What must hold of looks at an instant: bins add up to what is alive, and a sample is of that."""

from __future__ import annotations

import numpy as np

import transport as tp
from transport.results.result import Result
from transport.scene.phase_space import COORDINATES

ROUNDING = 1e-12


def instants_add_up(result: Result) -> None:
    """Bins and what is outside of them are all that is alive, at the clock's end what the ledger has in flight."""
    for look in result.scene.phase_spaces:
        found = result[look.name]
        alive = np.ravel(found.alive.value)
        parts = np.reshape(found.number.value, (len(look.times), -1)).sum(axis=1) + found.outside.value
        assert np.allclose(parts, alive, rtol=ROUNDING, atol=0), f"{look.name}: {parts} in parts of {alive}"
        if look.times[-1] == result.scene.duration:
            is_left(result, alive[-1], look.name)
    for look in result.scene.snapshots:
        is_sample(result, look)
        if look.time == result.scene.duration and look.particles >= result.particles:
            is_left(result, result[look.name].weights.sum(), look.name)


def is_left(result: Result, alive: float, name: str) -> None:
    """The ledger's in_flight is what a look at the end has seen."""
    left, emitted = (result.ledger[entry].value for entry in ("in_flight", "emitted"))
    assert abs(alive - left) <= ROUNDING * emitted, f"{name}: {alive} at the end, in flight {left}"


def is_sample(result: Result, look: tp.Snapshot) -> None:
    """Each particle once, at a place, of a weight; no more than were asked for."""
    sample = result[look.name]
    assert len(sample) <= look.particles + len(result.batches), f"{look.name}: {len(sample)} particles"
    assert np.isfinite(sample.positions).all() and np.isfinite(sample.velocities).all(), look.name
    assert (sample.weights > 0).all(), f"{look.name}: weights {sample.weights.min()}"
    assert len(np.unique(sample.histories)) == len(sample), f"{look.name}: a particle is there twice"


def whole_samples_are_binned(result: Result) -> None:
    """Where a sample is of all particles, its sums over the bins of a look at the same instant are what that says."""
    wholes = [shot for shot in result.scene.snapshots if shot.particles >= result.particles]
    for look in result.scene.phase_spaces:
        for shot in wholes:
            if shot.time in look.times:
                number = np.asarray(result[look.name].number.value)
                number = number[look.times.index(shot.time)] if look.is_series else number
                _agree(number, _binned(result[shot.name], look), f"{look.name} and {shot.name}")


def _agree(number: np.ndarray, summed: tuple[np.ndarray, np.ndarray], title: str) -> None:
    """Each bin is the sum of its own, to rounding, with those left open that a rounding may put into the next one."""
    sure, doubtful = summed
    slack = doubtful + ROUNDING * max(number.sum(), sure.sum())
    assert (np.abs(number - sure) <= slack).all(), f"{title}: {number} in bins, {sure} of a sample of all"


def _binned(sample, look: tp.PhaseSpace) -> tuple[np.ndarray, np.ndarray]:
    """Weights of the sample in each bin of a look; and the most by which particles on edges may change any."""
    inside, on_edge = np.ones(len(sample), bool), np.zeros(len(sample), bool)
    places = dict(zip("xyz", sample.positions.T, strict=True))
    if look.within is not None:
        for axis, low, high in zip("xyz", *look.within.bounds, strict=True):
            inside &= (places[axis] >= low) & (places[axis] <= high)
            on_edge |= _near(places[axis], np.array([low, high]))
    values = [_coordinate(sample, name) for name in look.axes]
    for value, edges in zip(values, look.axes.values(), strict=True):
        on_edge |= _near(value, edges)
    weights = np.where(inside, sample.weights, 0.0)
    return _summed(values, list(look.axes.values()), weights), sample.weights[on_edge].sum()


def _summed(values: list[np.ndarray], edges: list[np.ndarray], weights: np.ndarray) -> np.ndarray:
    """Sums of weights by bin; in pairs, for a running sum of so many is off by more than the rounding that is asked for."""
    places = [np.searchsorted(e, v, side="right") - 1 for e, v in zip(edges, values, strict=True)]
    shape = [len(e) - 1 for e in edges]
    sums = np.zeros(shape)
    for cell in np.ndindex(*shape):
        sums[cell] = weights[np.all([p == k for p, k in zip(places, cell, strict=True)], axis=0)].sum()
    return sums


def _near(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Which are so close to an edge that rounding decides."""
    size = np.abs(values).max(initial=0.0) + np.abs(edges).max()
    return (np.abs(values[:, None] - edges) <= ROUNDING * size).any(axis=1)


def _coordinate(sample, name: str) -> np.ndarray:
    """One coordinate of phase space of each particle."""
    assert name in COORDINATES
    if name in ("x", "y", "z"):
        return sample.positions[:, "xyz".index(name)]
    if name in ("vx", "vy", "vz"):
        return sample.velocities[:, ("vx", "vy", "vz").index(name)]
    speeds = np.linalg.norm(sample.velocities, axis=1)
    if name == "speed":
        return speeds
    with np.errstate(invalid="ignore"):
        return np.where(speeds > 0, sample.velocities[:, 2] / speeds, 0.0)


def samples_grow(one: Result, other: Result, length: float, power: float) -> None:
    """The second run, of the same scene in other units, has the same particles in its samples."""
    amount = power * length if one.scene.measured_in == "watts" else power  # energies, or numbers
    for shot in one.scene.snapshots:
        first, second = one[shot.name], other[shot.name]
        assert np.array_equal(first.histories, second.histories), f"{shot.name}: other particles"
        for part, factor in (("positions", length), ("velocities", 1.0), ("weights", amount)):
            a, b = getattr(first, part) * factor, getattr(second, part)
            most = np.abs(a).max(initial=0.0)
            off = np.abs(a - b).max(initial=0.0)
            assert off <= ROUNDING * most, f"{part} of {shot.name} off by {off / most:.3g}"
