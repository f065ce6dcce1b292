"""What must agree within errors: a furnace's radiance everywhere, and one number by every way to estimate it.

A score beyond LIMIT is asked again with new random numbers and sixteen times the histories, and is a failure if it is
beyond LIMIT once more: right code fails in one of 2.5e8 scores, of which a scene has a hundred at most.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

import transport as tp
from tests.fuzz.properties import ROUNDING
from tests.fuzz.runs import ENOUGH, Scores, run_of, sound
from tests.fuzz.sightings import sightings
from tests.fuzz.worlds import World
from transport.compile.methods import ESTIMATORS, refusal
from transport.scene.parts import named_media

LIMIT = 4.0  # normal scores
MORE = 16  # times the histories, when asked again


def check_furnace(world: World) -> list[str]:
    """Radiance is 1 on all meters and in all that is seen from anywhere, nothing escapes, nothing is lost.  Raises AssertionError."""
    return checked(lambda seed, more: _levels(world, seed, more) | _seen_levels(world, seed, more))


def check_ways(world: World) -> list[str]:
    """Every estimator and tracking that the scene allows gives the same, and so does what is seen.  Raises AssertionError."""
    return checked(lambda seed, more: _differences(world, seed, more) | sightings(world, seed, more))


def checked(score: Callable[[int, int], Scores]) -> list[str]:
    """The names of the scores that a seed gives, which are all small, or were with other and more histories."""
    first = score(1, 1)
    if far := _beyond(first):
        second = _beyond({name: z for name, z in score(2, MORE).items() if name in far})
        assert not second, f"z, and with {MORE} times the histories: " + ", ".join(
            f"{name} {far[name]:.2f}, {z:.2f}" for name, z in second.items()
        )
    return list(first)


def _beyond(scores: Scores) -> Scores:
    return {name: z for name, z in scores.items() if not abs(z) <= LIMIT}


def _levels(world: World, seed: int, more: int) -> Scores:
    """Scores of each meter's irradiance and of its radiance by direction, of 1 W m^-2 sr^-1 in the world's units."""
    result = run_of(world, seed, more)
    level = 2.0 ** (world.unit[1] - 2 * world.unit[0])
    assert result.ledger["escaped"].value == 0, "something escapes"
    assert not any(batch.lost or batch.unseen or batch.astray for batch in result.batches), result.warnings
    found = {}
    for name in result:
        reading = result[name]
        counts = np.asarray(reading.counts.value)
        if counts.sum() >= ENOUGH:
            found[f"{name}.irradiance"] = score_of(reading.irradiance, math.pi * level)
        for key in ("radiance", "radiance_out"):
            z = np.asarray(getattr(reading, key).z(level))
            good = (counts >= ENOUGH) & np.isfinite(z)
            found |= {
                f"{name}.{key}{[int(k) for k in place]}": float(z[tuple(place)])
                for place in np.argwhere(good)
            }
    return found


def _seen_levels(world: World, seed: int, more: int) -> Scores:
    """Scores of radiance and fluence rate at the places of the world's views: there they are as the square of the index."""
    found: Scores = {}
    plain = world.with_detectors(*world.views) if world.views else None
    if plain is None or refusal(scene := plain.scene(), "backward"):
        return found
    result = run_of(scene, seed + 1, more, estimator="backward")
    for look in scene.detectors:
        index = getattr(scene.medium_at(look.position), "index", 1.0) if named_media(scene) else 1.0
        level = index**2 * 2.0 ** (world.unit[1] - 2 * world.unit[0])
        seen = result[look.name]
        if isinstance(look, tp.PointDetector):
            found[f"{look.name}.fluence_rate"] = score_of(seen.fluence_rate, 4 * math.pi * level)
            continue
        for place in np.ndindex(seen.radiance.shape):
            if seen.counts.value[place] >= ENOUGH:
                found[f"{look.name}.radiance{list(place)}"] = score_of(seen.radiance[place], level)
    return found


def score_of(estimate: tp.Estimate, exact: float) -> float:
    """Its z, and 0 where every batch gave what is exact."""
    is_it = math.isnan(estimate.error) and abs(estimate.value / exact - 1) <= ROUNDING
    return 0.0 if is_it else float(estimate.z(exact))


def _differences(world: World, seed: int, more: int) -> Scores:
    """Scores of the differences of each way from the plain one, of totals whose error bars are sound in both."""
    scene = world.scene()
    plain = run_of(scene, seed, more, tracking="analog")
    ways = [{"estimator": name} for name in ESTIMATORS[1:] if refusal(scene, name) is None]
    ways += [{"tracking": tracking} for tracking in _trackings(scene)]
    found = {}
    for number, way in enumerate(ways, 1):
        other = run_of(scene, seed + 100 * number, more, **way)
        for name in _totals(scene):
            both = [sound(result, name) for result in (plain, other)]
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
