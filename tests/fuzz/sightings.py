"""What is seen from a place agrees: a map with six cameras that look all round, with a point, and with flights through a ball.

All but the flights is of histories that run backwards.  Flights forwards through a ball are the mean over all places in it: maps at
random places have that for their expectation, each bin of direction by itself.
"""

from __future__ import annotations

import math
import random

import numpy as np
from scipy.special import ndtri, stdtr

import transport as tp
from tests.fuzz.runs import ENOUGH, Scores, run_of, sound
from tests.fuzz.views import cube
from tests.fuzz.worlds import World
from transport.compile.methods import refusal
from transport.vectors import Vector

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
