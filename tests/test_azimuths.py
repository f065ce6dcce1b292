"""Azimuths have a sense: every estimator sees a lamp in the east in the east, from either side of any shape.

The directions of e_u and e_v are written down here for each shape, not taken from it, so that a
left-handed frame fails too.  No rotation or mirror image maps the azimuths of the lamps onto each other,
and each lamp is twice as bright as the one before.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp

BINS, BRIGHT = 9, {1: 1.0, 4: 2.0, 6: 4.0}  # of azimuth; in which there is a lamp, and how bright
X, Y, Z = np.eye(3)
SLOPE = math.sqrt(0.5)
FRONT, BACK = "front", "back"


def disk(normal, **options):
    return tp.Disk(radius=1e-3, normal=tuple(normal), **options)


def pane(normal, **options):
    return tp.Rectangle(width=2e-3, height=1e-3, normal=tuple(normal), **options)


CORNER = tp.Triangle(vertices=[(-1e-3, 1e-3, 0), (-1e-3, -1e-3, 0), (1e-3, -1e-3, 0)])  # its normal is +z
# e_v is the part of +y (of +z across y) or of `up` in the plane; e_u, e_v, the side's normal: right-handed.
FLAT = {
    "up": (disk(Z), FRONT, X, Y),
    "up, from behind": (disk(Z), BACK, -X, Y),
    "down": (pane(-Z), FRONT, -X, Y),
    "down, from behind": (pane(-Z), BACK, X, Y),
    "east": (pane(X), FRONT, -Z, Y),
    "east, from behind": (disk(X), BACK, Z, Y),
    "north": (disk(Y), FRONT, -X, Z),
    "north, from behind": (pane(Y), BACK, X, Z),
    "sloped": (disk((1, 0, 1)), FRONT, SLOPE * (X - Z), Y),
    "sloped, from behind": (disk((1, 0, 1)), BACK, SLOPE * (Z - X), Y),
    "turned": (pane(Z, up=(1, 0, 0)), FRONT, -Y, X),
    "turned, from behind": (pane(Z, up=(1, 0, 0)), BACK, Y, X),
    "triangle": (CORNER, FRONT, -Y, X),
    "triangle, from behind": (CORNER, BACK, Y, X),
}


def turned(e_u, e_v, k, share=0.5):
    """A unit vector at a share of bin k of azimuth from e_u towards e_v."""
    phi = 2 * math.pi * (k + share) / BINS
    return math.cos(phi) * np.asarray(e_u) + math.sin(phi) * np.asarray(e_v)


def is_seen(values):
    """Only the bins with lamps have light, in proportion to their brightness, with noise of 5 % at most."""
    lit = {k: value for k, value in enumerate(np.ravel(values)) if value > 0}
    assert lit.keys() == BRIGHT.keys(), lit
    dim, medium, bright = lit.values()
    assert 1.5 < medium / dim < 2.5 and 1.5 < bright / medium < 2.5, lit


LEVEL = [(name, "world") for name, (_, _, e_u, e_v) in FLAT.items() if abs(np.cross(e_u, e_v)[2]) > 0.9]


@pytest.mark.parametrize("estimator", ["analog", "aimed", "expected", "backward"])
@pytest.mark.parametrize(("case", "frame"), [*((name, "local") for name in FLAT), *LEVEL])
def test_a_lamp_is_seen_at_its_own_azimuth(case, frame, estimator):
    """Balls of light 60 degrees from the normal of the side; the world's azimuth is about +z from +x."""
    shape, side, e_u, e_v = FLAT[case]
    normal, around = np.cross(e_u, e_v), (e_u, e_v) if frame == "local" else (X, Y)
    places = {k: 0.5 * normal + math.sqrt(0.75) * turned(*around, k) for k in BRIGHT}
    lamps = [
        tp.Source(tp.Sphere(center=tuple(places[k]), radius=0.15), tp.Lambertian(radiance=radiance))
        for k, radiance in BRIGHT.items()
    ]
    if estimator == "analog":  # few would meet the detector
        lamps = [tp.Source(lamp.shape, lamp.emission, aim=shape) for lamp in lamps]
    looks = tp.Detector(shape, "meter", side=side, directions=tp.Directions(phi=BINS, frame=frame))
    particles = 100_000 if estimator == "backward" else 5000
    result = tp.simulate(
        tp.Scene(lamps, detectors=looks), particles, estimator=estimator, seed=1, progress=False
    )
    is_seen(result["meter"].radiance.value)


def rays(places, flights):
    """Pencils of light along flights, which pass through places after a tenth of a metre."""
    starts = {k: tuple(np.asarray(places[k]) - 0.1 * np.asarray(flights[k])) for k in BRIGHT}
    return [
        tp.Source(tp.Point(position=starts[k]), tp.Beam(tuple(flights[k]), power=power))
        for k, power in BRIGHT.items()
    ]


def crossed(shape, side, places, flights, **bins):
    result = tp.simulate(
        tp.Scene(rays(places, flights), detectors=tp.Detector(shape, "meter", side=side, **bins)),
        particles=7 * 64,
        seed=1,
        progress=False,
    )
    return result["meter"]


@pytest.mark.parametrize("case", FLAT)
def test_what_leaves_a_side_leaves_at_the_azimuth_that_it_flies_to(case):
    shape, side, e_u, e_v = FLAT[case]
    flights = {k: 0.5 * np.cross(e_u, e_v) + math.sqrt(0.75) * turned(e_u, e_v, k) for k in BRIGHT}
    places = dict.fromkeys(BRIGHT, shape.middle)
    is_seen(crossed(shape, side, places, flights, directions=tp.Directions(phi=BINS)).radiance_out.value)


@pytest.mark.parametrize("axis", ["u", "v"])
@pytest.mark.parametrize("case", [name for name in FLAT if name != "triangle" and "triangle," not in name])
def test_a_place_on_a_flat_shape_has_the_same_bin_from_either_side(case, axis):
    """Bins of place are the shape's own on both sides: azimuths on a disk, lengths on a rectangle."""
    shape, side, e_u, e_v = FLAT[case]
    into, own_u = -np.cross(e_u, e_v), e_u if side == FRONT else -e_u
    if isinstance(shape, tp.Disk):
        radius = {"u": [1e-3 * (k + 0.5) / BINS for k in range(BINS)], "v": [5e-4] * BINS}[axis]
        places = {k: radius[k] * turned(own_u, e_v, k) for k in BRIGHT}
    else:
        along = {"u": shape.width * own_u, "v": shape.height * e_v}[axis]
        places = {k: ((k + 0.5) / BINS - 0.5) * along for k in BRIGHT}
    reading = crossed(
        shape, side, places, dict.fromkeys(BRIGHT, into), positions=tp.Positions(**{axis: BINS})
    )
    is_seen((reading.irradiance * reading.detector.positions.areas(shape).ravel()).value)


CURVED = {  # with its two sides
    "ball": (tp.Sphere(radius=1.0), "outside", "inside"),
    "tube": (tp.Cylinder(radius=1.0, height=1.0), FRONT, BACK),
    "facets": (tp.Mesh.box(size=2.0), "outside", "inside"),
}


@pytest.mark.parametrize("is_within", [False, True])
@pytest.mark.parametrize("name", CURVED)
@pytest.mark.parametrize("turn", [0.0, 0.25, 0.5])
def test_on_curved_shapes_e_v_is_along_the_axis_and_e_u_on_its_right(name, is_within, turn):
    """At places of the equator: e_u, e_v and the normal of the side are right-handed."""
    shape, *sides = CURVED[name]
    outward = math.cos(2 * math.pi * turn) * X + math.sin(2 * math.pi * turn) * Y
    normal = -outward if is_within else outward
    flights = {k: -0.5 * normal - math.sqrt(0.75) * turned(np.cross(Z, normal), Z, k) for k in BRIGHT}
    places, bins = dict.fromkeys(BRIGHT, outward), tp.Directions(phi=BINS)
    is_seen(crossed(shape, sides[is_within], places, flights, directions=bins).radiance.value)


@pytest.mark.parametrize("is_within", [False, True])
@pytest.mark.parametrize("name", ["ball", "tube"])
def test_places_round_an_axis_turn_from_x_to_y_seen_from_either_side(name, is_within):
    shape, *sides = CURVED[name]
    places = {k: turned(X, Y, k) for k in BRIGHT}
    flights = {k: place if is_within else -place for k, place in places.items()}
    is_seen(
        crossed(shape, sides[is_within], places, flights, positions=tp.Positions(v=BINS)).irradiance.value
    )
