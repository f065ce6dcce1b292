"""What must agree within errors: a furnace's radiance everywhere, and one number by every way to estimate it.

A score beyond LIMIT is asked again with new random numbers and sixteen times the histories, and is a failure if it is
beyond LIMIT once more: right code fails in one of 2.5e8 scores, of which a scene has a hundred at most.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

import transport as tp
from tests.fuzz.properties import OF_ONE_RUN, ROUNDING
from tests.fuzz.worlds import World
from transport.estimators.methods import ESTIMATORS, why_not
from transport.results import Result

LIMIT = 4.0  # normal scores
PARTICLES = 20_000  # of a run
MORE = 16  # times the histories, when asked again
ENOUGH = 1000  # counts, below which scores are not normal that far out
Scores = dict[str, float]


def check_furnace(world: World) -> list[str]:
    """Radiance is 1 on all meters, nothing escapes, nothing is lost.  Raises AssertionError."""
    return _checked(lambda seed, more: _levels(world, seed, more))


def check_ways(world: World) -> list[str]:
    """Every estimator and tracking that the scene allows gives the same.  Raises AssertionError."""
    return _checked(lambda seed, more: _differences(world, seed, more))


def _checked(score: Callable[[int, int], Scores]) -> list[str]:
    first = score(1, 1)
    if far := _beyond(first):
        second = _beyond({name: z for name, z in score(2, MORE).items() if name in far})
        assert not second, f"z, and with {MORE} times the histories: " + ", ".join(
            f"{name} {far[name]:.2f}, {z:.2f}" for name, z in second.items()
        )
    return list(first)


def _beyond(scores: Scores) -> Scores:
    return {name: z for name, z in scores.items() if not abs(z) <= LIMIT}


def _run(scene: tp.Scene, seed: int, more: int, **how) -> Result:
    result = tp.simulate(
        scene, particles=more * PARTICLES, seed=seed, batches=32, threads=1, progress=False, **how
    )
    for holds in OF_ONE_RUN:
        holds(result)
    return result


def _levels(world: World, seed: int, more: int) -> Scores:
    """Scores of each meter's irradiance and of its radiance by direction, of 1 W m^-2 sr^-1 in the world's units."""
    result = _run(world.scene(), seed, more)
    level = 2.0 ** (world.unit[1] - 2 * world.unit[0])
    assert result.ledger["escaped"].value == 0, "something escapes"
    assert not any(batch.lost or batch.unseen or batch.astray for batch in result.batches), result.warnings
    found = {}
    for name in result:
        reading = result[name]
        counts = np.asarray(reading.counts.value)
        if counts.sum() >= ENOUGH:
            found[f"{name}.irradiance"] = _score(reading.irradiance, math.pi * level)
        for key in ("radiance", "radiance_out"):
            z = np.asarray(getattr(reading, key).z(level))
            good = (counts >= ENOUGH) & np.isfinite(z)
            found |= {
                f"{name}.{key}{[int(k) for k in place]}": float(z[tuple(place)])
                for place in np.argwhere(good)
            }
    return found


def _score(estimate: tp.Estimate, exact: float) -> float:
    """Its z, and 0 where every batch gave what is exact."""
    is_it = math.isnan(estimate.error) and abs(estimate.value / exact - 1) <= ROUNDING
    return 0.0 if is_it else float(estimate.z(exact))


def _differences(world: World, seed: int, more: int) -> Scores:
    """Scores of the differences of each way from the plain one, of totals whose error bars are sound in both."""
    scene = world.scene()
    plain = _run(scene, seed, more, tracking="analog")
    ways = [{"estimator": name} for name in ESTIMATORS[1:] if why_not(scene, name) is None]
    ways += [{"tracking": tracking} for tracking in _trackings(scene)]
    found = {}
    for number, way in enumerate(ways, 1):
        other = _run(scene, seed + 100 * number, more, **way)
        for name in _totals(scene):
            both = [_sound(result, name) for result in (plain, other)]
            if None not in both:
                label = ", ".join(map(str, way.values()))
                found[f"{name} by {label}"] = float((both[0] - both[1]).z(0.0))
    return found


def _trackings(scene: tp.Scene) -> list:
    """Other ways through media, where there are any."""
    media = [scene.medium, *(surface.back for surface in scene.surfaces)]
    if media == [None] * len(media):
        return []
    forced = [] if any(isinstance(medium, tp.Grid) for medium in media) else [tp.Tracking(forced=True)]
    return ["weighted", *forced]


def _totals(scene: tp.Scene) -> list[str]:
    rates = [f"{look.name}.fluence_rate" for look in (*scene.volumes, *scene.points)]
    fluxes = [f"{meter.name}.{side}" for meter in scene.meters for side in ("flux_in", "flux_out")]
    return fluxes + rates


def _sound(result: Result, name: str):
    """The quantity, where there is one number with an error that nothing speaks against."""
    detector = name.partition(".")[0]
    try:
        estimate = result.quantity(name)
    except tp.SceneError:
        return None
    if not isinstance(estimate, tp.Estimate) or not 0 < estimate.relative_error < 0.1:
        return None
    is_told = any(detector in told for told in result.warnings)
    return estimate if result.quality(name).is_sound and not is_told else None
