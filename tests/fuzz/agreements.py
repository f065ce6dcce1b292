"""What must agree within errors: a furnace's radiance everywhere, one number by every way to estimate it, all that is seen from a
place, and what is alive at an instant.

A score beyond LIMIT is judged again with new random numbers and sixteen times the histories, and is a failure if it is
beyond LIMIT once more: right code fails in one of 2.5e8 scores, of which a scene has a hundred at most.
"""

from __future__ import annotations

import dataclasses
import math
import random
from collections.abc import Callable

import numpy as np
from scipy.special import ndtri, stdtr

import transport as tp
from tests.fuzz.properties import OF_ONE_RUN, ROUNDING
from tests.fuzz.views import cube
from tests.fuzz.worlds import World
from transport.compile.methods import ESTIMATORS, refusal
from transport.results.result import Result
from transport.scene.parts import named_media
from transport.scene.sources import Source
from transport.vectors import Vector

PARTICLES = 20_000  # of a run
ENOUGH = 1000  # counts, below which scores are not normal that far out
Scores = dict[str, float]


def run_of(world: World | tp.Scene, seed: int, more: float, **how) -> Result:
    """A run of so many times the usual histories, of which all holds that must hold of any."""
    scene = world.scene() if isinstance(world, World) else world
    result = tp.simulate(
        scene, particles=int(more * PARTICLES), seed=seed, batches=32, threads=1, progress=False, **how
    )
    for holds in OF_ONE_RUN:
        holds(result)
    return result


def sound(result: Result, name: str) -> tp.Estimate | None:
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


# ---- seen from a place: a map, six cameras that look all round, a point, and flights through a ball ----
#
# All but the flights is of histories that run backwards.  Flights forwards through a ball are the mean over all places in it: maps
# at random places have that for their expectation, each bin of direction by itself.

BALL = 0.2  # m, in which places are
PLACES = 16
SHARED = 2  # times the usual histories, which seven sensors share
FEW_COUNTS = 150  # in an octant, below which its mean is not asked
FEW = 6  # places of these that something is seen from, below which their spread tells little


def sightings(world: World, seed: int, more: int) -> Scores:
    """Scores of all that is seen in the world's free cell; none where it cannot be run backwards."""
    if world.free is None:
        return {}
    place = tuple(x + shift for x, shift in zip(world.free, (0.013, -0.007, 0.004), strict=True))
    if refusal(world.with_detectors(octants("map", place)).scene(), "backward"):
        return {}
    return _around(world, place, seed, more) | _within(world, seed, more)


def octants(name: str, place: Vector) -> tp.EnvironmentMap:
    """A map of eight bins, one an octant."""
    return tp.EnvironmentMap(name=name, position=place, theta=2, phi=4)


def _around(world: World, place: Vector, seed: int, more: int) -> Scores:
    """Six cameras against a map in each octant, and a map against points, which are lit forwards and backwards."""
    seen = run_of(world.with_detectors(octants("map", place), *cube(place)), seed, SHARED * more)
    flux = seen["map"].radiance * seen["map"].detector.solid_angles()
    found = {}
    for octant, pixels in pixels_of_octants(seen).items():
        if seen["map"].counts.value[octant] >= FEW_COUNTS:
            parts = sum(pixels[1:], pixels[0])
            found[f"octant {octant} by cameras"] = float((parts - flux[octant]).z(0.0))
    return found | _points(world, place, seen["map"].fluence_rate, seed, more)


def pixels_of_octants(seen: tp.Result) -> dict[tuple[int, int], list[tp.Estimate]]:
    """Radiance times solid angle [W m^-2] of the pixels that look into each octant (theta, phi) of the map."""
    found: dict[tuple[int, int], list[tp.Estimate]] = {}
    for look in seen.scene.detectors:
        if isinstance(look, tp.Camera):
            flux = seen[look.name].radiance * look.solid_angles()
            for v, u in np.ndindex(2, 2):
                found.setdefault(_octant_of(look, v, u), []).append(flux[v, u])
    return found


def _octant_of(look: tp.Camera, v: int, u: int) -> tuple[int, int]:
    """Bins (theta, phi) that the middle of a pixel is in; u runs to the right, v upwards."""
    left, up, forward = (np.array(axis) for axis in look.frame)
    x, y, z = forward + (v - 0.5) * up - (u - 0.5) * left
    return int(z < 0), int(math.atan2(y, x) % (2 * math.pi) // (math.pi / 2))


def _points(world: World, place: Vector, whole: tp.Estimate, seed: int, more: int) -> Scores:
    """A point lit backwards and, where it may be, forwards, against the fluence rate of a map."""
    point = world.with_detectors(tp.PointDetector(place, "point"))
    try:
        point.scene()
    except tp.SceneError:
        return {}
    found = {}
    for number, way in enumerate(("backward", "analog")):
        result = run_of(point, seed + 10 + number, more, estimator=way)
        rate = sound(result, "point.fluence_rate")
        if rate is not None and whole.relative_error < 0.1:
            found[f"point, {way}, by a map"] = float((rate - whole).z(0.0))
    return found


def _within(world: World, seed: int, more: int) -> Scores:
    """Maps at random places in a ball against a volume detector that fills it, forwards: the radiance in each octant."""
    ball = tp.Sphere(center=world.free, radius=BALL)
    eight = tp.Directions.sphere(mu=2, phi=4)
    volume = run_of(
        world.with_detectors(tp.VolumeDetector(ball, "ball", directions=eight)),
        seed,
        more,
        estimator="analog",
    )["ball"]
    draws = random.Random(f"{world.way} {seed}")
    seen = np.concatenate([_maps(world, draws, seed + 100 * k, more) for k in range(more)])
    found = {}
    for mu, phi in np.ndindex(2, 4):
        # What flies downwards, in the first bin of mu, comes from above, the map's first one of theta; and from across.
        at_places, flights = seen[:, mu, (phi + 2) % 4], volume.radiance[mu, phi]
        if (
            np.sum(volume.counts.value) >= ENOUGH
            and flights.relative_error < 0.3
            and np.count_nonzero(at_places) >= FEW
        ):
            found[f"octant {(mu, phi)} by flights"] = _score(at_places, flights)
    return found


def _maps(world: World, draws: random.Random, seed: int, more: int) -> np.ndarray:
    """The radiance in octants that maps at random places see, (places, theta, phi)."""
    maps = [octants(f"map {k}", _in_ball(world.free, draws)) for k in range(PLACES)]
    result = run_of(world.with_detectors(*maps), seed, more / 4)
    return np.array([result[each.name].radiance.value for each in maps])


def _in_ball(center: Vector, draws: random.Random) -> Vector:
    """A place uniform in the ball."""
    while True:
        shift = [draws.uniform(-BALL, BALL) for _ in range(3)]
        if math.hypot(*shift) < BALL:
            return tuple(c + s for c, s in zip(center, shift, strict=True))


def _score(at_places: np.ndarray, flights: tp.Estimate) -> float:
    """z of the difference of a mean over places, whose spread is its error, and a run's estimate."""
    error = math.hypot(at_places.std(ddof=1) / math.sqrt(len(at_places)), flights.error)
    return float(ndtri(stdtr(len(at_places) - 1, (at_places.mean() - flights.value) / error)))


# ---- alive at an instant: what a run that ends there has left, all that was emitted but for what has gone by then ----

SHARE = 0.8  # of the clock's time, after all pulses


def check_left(world: World) -> list[str]:
    """A look at an instant, and a sample then, against a run whose clock ends there.  Raises AssertionError."""
    return checked(lambda seed, more: _left_differences(world, seed, more))


def _left_differences(world: World, seed: int, more: int) -> Scores:
    """Scores of what is alive, and of what its sample says, less what the ledger of a shorter run has in flight."""
    instant = SHARE * world.parts["duration"]
    looks = [
        tp.PhaseSpace(mu=2, time=instant, name="alive"),
        tp.Snapshot(instant, 10_000_000, "all"),
        tp.Snapshot(instant, 5_000, "few"),
    ]
    result = run_of(world.with_detectors(*looks), seed, more)
    shorter = run_of(_cut(world, instant), seed + 100, more).ledger
    alive, emitted = result["alive"].alive, result.ledger["emitted"].value
    summed = result["all"].weights.sum()
    assert abs(summed - alive.value) <= 1e-12 * emitted, f"a sample of all has {summed}, alive are {alive}"
    gone = ("absorbed", "escaped", "roulette", "unsampled", "lost")
    rest = shorter["emitted"] - sum((shorter[name] for name in gone[1:]), shorter[gone[0]])
    found = {}
    if sound(result, "alive.alive") is not None and 0 < rest.relative_error < 0.1:
        found["alive less emitted and not gone"] = float((alive - rest).z(0.0))
    return found


def _cut(world: World, instant: float) -> World:
    """The same until the instant, with nothing that looks at it."""
    sources = tuple(_until(source) for source in world.parts["sources"])
    parts = world.parts | {"sources": sources, "detectors": (), "duration": instant}
    return dataclasses.replace(world, parts=parts)


def _until(source: Source) -> Source:
    """A source that sends out its number over the whole clock sends out its share until then."""
    emission = source.emission
    if isinstance(emission, tp.Effusive) and emission.number is not None and source.pulse is None:
        return dataclasses.replace(
            source, emission=dataclasses.replace(emission, number=SHARE * emission.number)
        )
    return source
