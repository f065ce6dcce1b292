"""What must hold of every run, whatever the scene: each property is a function that raises AssertionError."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import numpy as np

import transport as tp
from tests.fuzz.worlds import World, factor_of
from transport.results.result import Result
from transport.scene.phase_space import COORDINATES
from transport.statistics.any_estimate import AnyEstimate

ROUNDING = 1e-12  # of a sum over histories, against its largest part
SIGNED = (
    "net_flux_density",
    "roulette",
    "mean_vx",
    "mean_vy",
    "mean_vz",
)  # quantities that may be below zero
MEANS = ("mean_", "variance_", "temperature", "pressure")  # of nothing, or of too few, they are not known
OBJECT = re.compile(r"(\w+)(\[\d+\]| '[^']*')?(:| )")  # what a refusal begins with
CURE = re.compile(r"; \w+|, (write|leave|give|let|take|make) ")


def run(world: World, threads: int = 1) -> Result:
    """The world's run.  Raises SceneError where it is refused."""
    scene = world.scene()
    return tp.simulate(scene, threads=threads, **world.said(scene))


def refusal_helps(message: str) -> None:
    """A refusal begins with the object that it is about, and says what to do."""
    begins = OBJECT.match(message)
    assert begins and begins[1] in (*tp.__all__, "sources", "surfaces"), f"names no object: {message}"
    assert CURE.search(message), f"tells no cure: {message}"


def ledger_closes(result: Result) -> None:
    """What was emitted is the sum of where it went, over all and in each batch."""
    parts = [entry for name, entry in result.ledger.items() if name != "emitted"]
    emitted = result.ledger["emitted"]
    gap = emitted - sum(parts[1:], parts[0])
    assert abs(gap.value) <= ROUNDING * emitted.value, f"open by {gap.value / emitted.value:.3g}"
    for batch in result.batches:
        ends = math.fsum(batch.ledger[name] for name in ("escaped", "in_flight", "roulette", "lost"))
        rest = batch.born - ends - float(batch.absorbed.sum())
        assert abs(rest) <= ROUNDING * max(batch.born, 1e-300), f"a batch is open by {rest / batch.born:.3g}"
    owned = math.fsum(entry.value for entry in result.ledger.absorbed_by.values())
    absorbed = result.ledger["absorbed"].value
    assert abs(owned - absorbed) <= ROUNDING * emitted.value, f"absorbed {absorbed}, by its owners {owned}"


def nothing_is_lost_in_silence(result: Result) -> None:
    """Histories are lost by none, or a warning says so."""
    if any(batch.lost for batch in result.batches):
        assert any("lost" in told for told in result.warnings), "histories were lost, and no warning says so"


def numbers_are_sound(result: Result) -> None:
    """No value is nan or infinite but where it is said why, no error is either, and no flux is negative."""
    for name, quantity in quantities_of(result).items():
        value, error = np.asarray(quantity.value), np.asarray(quantity.error)
        reason = np.asarray(quantity.reason, dtype=object)
        unexplained = np.equal(reason, None)
        assert np.isfinite(value[unexplained]).all(), f"{name} is {value[unexplained]}"
        assert np.isfinite(error[unexplained]).all(), f"the error of {name} is {error[unexplained]}"
        assert not (error[unexplained] < 0).any(), f"the error of {name} is negative"
        assert _may_be_undefined(result, name) or np.isfinite(value).all(), f"{name} is {value}: {reason}"
        assert not np.isinf(value).any(), f"{name} is {value}"
        if not name.endswith(SIGNED):
            least = -ROUNDING * float(np.max(np.abs(value), initial=0.0))
            assert not (value < least).any(), f"{name} is negative: {value.min()}"


def _may_be_undefined(result: Result, name: str) -> bool:
    """Means of nothing, and the radiance in bins of the world's directions that lie behind the meter."""
    detector, _, key = name.partition(".")
    look = next((look for look in result.scene.detectors if look.name == detector), None)
    bins = getattr(look, "directions", None)
    is_world = (isinstance(bins, tp.Directions) and bins.frame == "world") or hasattr(bins, "half_angle")
    return key.startswith(MEANS) or (is_world and key.startswith(("radiance", "phase_density")))


def is_told(result: Result) -> None:
    """The report can be made."""
    assert "ledger" in result.report()


def quantities_of(result: Result) -> dict[str, AnyEstimate]:
    """All that a run has found, by name, the ledger first."""
    found = {f"ledger.{name}": entry for name, entry in result.ledger.items()}
    for name in result:
        found |= {f"{name}.{key}": value for key, value in result[name].quantities.items()}
    return found


def are_the_same(one: Result, other: Result) -> None:
    """All values and errors of two runs, bit by bit."""
    first, second = quantities_of(one), quantities_of(other)
    assert first.keys() == second.keys()
    for name in first:
        for part in ("value", "error"):
            a, b = (np.asarray(getattr(found[name], part)) for found in (first, second))
            assert np.array_equal(a, b, equal_nan=True), f"{part} of {name}: {a} and {b}"


def grows_as_its_unit(one: Result, other: Result, length: float, power: float) -> None:
    """The second run, of the same scene in other units, has the same digits in each quantity."""
    is_light = one.scene.measured_in == "watts"
    second = quantities_of(other)
    is_share = one.plan.adjoint is not None  # the ledger of histories that run backwards is of shares
    for name, quantity in quantities_of(one).items():
        key = name.split(".", 1)[1]
        factor = factor_of(key, quantity, length, power, is_light)
        if is_share and name.startswith("ledger."):
            factor = 1.0
        a, b = np.asarray(quantity.value) * factor, np.asarray(second[name].value)
        assert np.array_equal(np.isfinite(a), np.isfinite(b)), f"{name}: {a} and {b}"
        most = np.nanmax(np.abs(np.where(np.isfinite(a), a, 0.0)), initial=0.0)
        off = np.where(np.isfinite(a) & (a != b), np.abs(a - b), 0.0).max(initial=0.0)
        assert off <= ROUNDING * most, f"{name} in other units is off by {off / most:.3g}: {a} and {b}"


# ---- looks at an instant: bins add up to what is alive, and a sample is of that ----


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


# ---- all of them ----

OF_ONE_RUN = (
    ledger_closes,
    nothing_is_lost_in_silence,
    numbers_are_sound,
    is_told,
    instants_add_up,
    whole_samples_are_binned,
)


def check(world: World) -> list[str]:
    """The names of the properties that hold.  Raises AssertionError where one does not, SceneError where it is refused."""
    result = run(world)
    for holds in OF_ONE_RUN:
        holds(result)
    again = run(world, threads=2)
    length, power = (7, -9) if world.way % 2 else (-20, 30)
    other = run(world.in_units(length, power))
    are_the_same(result, again)
    samples_grow(result, again, 1.0, 1.0)
    grows_as_its_unit(result, other, 2.0**length, 2.0**power)
    samples_grow(result, other, 2.0**length, 2.0**power)
    return [holds.__name__ for holds in (*OF_ONE_RUN, are_the_same, grows_as_its_unit, samples_grow)]


def check_or_refused(world: World, look: Callable[[World], list[str]] = check) -> tuple[list[str], str]:
    """What a check found, or what the refusal says, which must help.  Raises AssertionError."""
    try:
        return look(world), ""
    except tp.SceneError as refusal:
        refusal_helps(str(refusal))
        return ["refusal_helps"], str(refusal)
