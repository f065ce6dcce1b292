"""Detectors on surfaces: which side and which bin a crossing counts in, and what it adds to fluence, momentum and radiance.

Each statistical judgement fails right code in one of 10^6 seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from transport.results.diagnostics.nearby import _is_significant

FALSE_ALARM = 1e-6
UP = tp.Beam(direction=(0, 0, 1), power=2.0)


def run(sources, *detectors, particles=64, batches=2, **scene):
    """A run without surfaces."""
    scene = tp.Scene(sources, (), detectors, **scene)
    return tp.simulate(scene, particles, batches=batches, seed=1, progress=False)


def run_many(sources, *detectors, particles=200_000, **scene):
    return run(sources, *detectors, particles=particles, batches=None, **scene)


# ---- which side ----


def readings(source, *detectors):
    """What 64 histories brought, by detector: (flux_in, flux_out) [W]."""
    result = run(source, *detectors)
    return {d.name: (result[d.name].flux_in.value, result[d.name].flux_out.value) for d in detectors}


@pytest.mark.parametrize("first", [1, -1])
def test_crossings_arrive_at_the_side_looked_at_and_depart_from_behind(first):
    """Four meters on one sheet, whose normal is that of the first of them."""
    meters = [
        tp.Detector(
            tp.Disk(center=(0, 0, 1), normal=(0, 0, sign), radius=1.0 + k), f"{sign} {side}", side=side
        )
        for k, (sign, side) in enumerate((s, side) for s in (first, -first) for side in ("front", "back"))
    ]
    found = readings(tp.Source(tp.Point(), UP), *meters)
    arrives, leaves = (2.0, 0.0), (0.0, 2.0)
    assert found == {"1 front": leaves, "1 back": arrives, "-1 front": arrives, "-1 back": leaves}


@pytest.mark.parametrize("tilt", [0.0, 0.5])
def test_a_beam_leaves_a_box_by_the_faces_that_look_along_it_and_none_of_it_is_within(tilt):
    box = tp.Box(size=(1.0, 2.0, 3.0))
    beam = tp.Beam(direction=(math.sin(tilt), 0, math.cos(tilt)), power=2.0)
    middle = tp.Detector(tp.Disk(radius=0.4), "middle")
    found = readings(tp.Source(box, beam), tp.Detector(box, "box", side="outside"), middle)
    assert found == {"box": (0.0, 2.0), "middle": (0.0, 0.0)}


# ---- edges of bins ----


def beamed(**bins):
    """Counts of a pencil beam of 64 particles along the normal of a meter, through its middle."""
    meter = tp.Rectangle(center=(0, 0, 1), width=2.0, height=2.0, normal=(0, 0, -1))
    source = tp.Source(tp.Point(position=(0, 0, 0)), tp.Beam(direction=(0, 0, 1), power=1.0))
    detectors = [tp.Detector(meter, "meter", **bins), tp.Detector(meter, "next", **bins)]
    result = run(source, *detectors)
    np.testing.assert_array_equal(result["next"].counts.value, result["meter"].counts.value)
    assert result["meter"].flux_in.value == 1.0
    return result["meter"].counts.value


UPPERMOST = [{"mu": 4}, {"mu": (0, 0.3, 1)}, {"mu": 2, "phi": 3}]
LOWEST = [{"theta": 4}, {"mu": 4, "frame": "world"}]


@pytest.mark.parametrize(("directions", "last"), [*((d, -1) for d in UPPERMOST), *((d, 0) for d in LOWEST)])
def test_a_ray_straight_along_the_normal_is_in_the_outermost_bin_of_cosine(directions, last):
    """It comes from (0, 0, -1), so that the world's first bin of cosine holds it."""
    counts = beamed(directions=tp.Directions(**directions))
    assert counts[last].sum() == counts.sum() == 64


@pytest.mark.slow
@pytest.mark.parametrize("bins", [{"mu": (0, 0.25, 1)}, {"theta": 4}, {"mu": 8}])
def test_a_ray_along_any_normal_is_in_the_bin_of_cosine_1(bins):
    """The cosine of a ray and a normal that are equal may round to more than 1."""
    normals = np.random.default_rng(1).normal(size=(24, 3))
    for normal in normals / np.linalg.norm(normals, axis=1)[:, None]:
        source = tp.Source(tp.Point(position=normal), tp.Beam(direction=-normal, power=1.0))
        meter = tp.Detector(tp.Disk(normal=normal, radius=1.0), "meter", directions=tp.Directions(**bins))
        assert run(source, meter, particles=8)["meter"].counts.value.sum() == 8


def test_a_ray_on_the_edge_between_two_bins_of_place_is_in_the_upper_one():
    counts = beamed(positions=tp.Positions(u=2, v=4))
    assert counts[1, 2] == counts.sum() == 64


# ---- what one crossing brings ----


@pytest.mark.parametrize(
    ("mu", "inverse"), [(0.02, 50.0), (1.5e-3, 1 / 1.5e-3), (5e-4, 2000.0), (1e-6, 2000.0)]
)
@pytest.mark.parametrize("side", [-1, 1])
def test_a_crossing_brings_one_over_its_cosine_and_beyond_the_grazing_cut_its_mean(mu, inverse, side):
    """The cut is at 1e-3, and the mean of 1/mu below it, weighted with mu, 2000."""
    beam = tp.Beam(direction=(math.sqrt(1 - mu * mu), 0, mu), power=3.0)
    disk = tp.Disk(center=(1, 0, mu), normal=(0, 0, side), radius=0.5)
    reading = run_many(tp.Source(tp.Point(), beam), tp.Detector(disk, "meter"), particles=64)["meter"]
    assert reading.fluence_rate.value == pytest.approx(3.0 * inverse / disk.area, rel=1e-6)


def test_light_from_all_sides_has_its_fluence_and_presses_with_a_third_of_its_energy_density():
    lamp = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="inside")
    meter = run_many(lamp, tp.Detector(tp.Disk(radius=1.0), "meter", moments=True))["meter"]
    assert_agrees(meter.fluence_rate, 4 * math.pi, FALSE_ALARM)
    assert_agrees(meter.pressure, 4 * math.pi / 3 / tp.speed_of_light, FALSE_ALARM)


def test_light_of_each_speed_presses_by_its_energy_over_its_own_speed():
    """Two beams, 3 W at 0.5 m/s and 5 W at 2 m/s, press with 6 and 2.5 N; matter has v instead of 1/v."""
    at, into, meter = tp.Point(position=(0, 0, -1)), (0, 0, 1), tp.Disk(radius=0.5)
    beams = [tp.Source(at, tp.Beam(into, power=p, speed=v)) for p, v in ((3.0, 0.5), (5.0, 2.0))]
    found = run_many(beams, tp.Detector(meter, "meter", side="back", moments=True))["meter"]
    assert_agrees(found.pressure * (meter.area * 1.0), 3.0 / 0.5 + 5.0 / 2.0, FALSE_ALARM)
    assert found.pressure.relative_error < 1e-2


def test_light_from_below_is_in_the_worlds_lower_bins_of_a_ball():
    """By where it comes from; the ball's normals are met at a mean cosine of 1/4 of its surface."""
    lamp = tp.Source(tp.Sphere(radius=2.0, mu_max=0.0), tp.Lambertian(radiance=5.0), side="back")
    world = tp.Directions(mu=(-1, -0.3, 0.3, 1), frame="world")
    ball = tp.Detector(tp.Sphere(radius=0.5), "ball", side="outside", directions=world)
    sphere, below = tp.Sphere(radius=0.5), tp.Directions.cone((0, 0, -1), 0.5)
    result = run_many(lamp, ball, tp.Detector(sphere, "cone", side="outside", directions=below))
    assert_agrees(result["cone"].radiance, 5.0, FALSE_ALARM)
    radiance = result["ball"].radiance
    assert_agrees(radiance[0], 5.0, FALSE_ALARM)
    assert radiance.value[2] == 0 < radiance.value[1] < 5


def test_phase_density_is_flux_over_what_crosses_of_it():
    """Of a gas of one speed, in a bin of speeds from 1/2 to 2: n / 4 pi over the integral of v^3, times v."""
    gas = tp.Source(tp.Box(size=2.4), tp.Gas(density=7.0, speed=1.0))
    meter = tp.Detector(tp.Disk(radius=0.4), "meter", directions=tp.Directions(mu=1), speeds=(0.5, 2.0))
    density = run_many(gas, meter, particles=400_000, duration=0.8)["meter"].phase_density
    assert_agrees(density[0, 0], 7.0 / (4 * math.pi) / ((2.0**4 - 0.5**4) / 4), FALSE_ALARM)
    assert np.size(density.value) == 1


# ---- azimuths ----
#
# Every estimator sees a lamp in the east in the east, from either side of any shape.  The directions of e_u and e_v are
# written down here for each shape, not taken from it, so that a left-handed frame fails too.  No rotation or mirror image
# maps the azimuths of the lamps onto each other, and each lamp is twice as bright as the one before.

BINS, BRIGHT = 9, {1: 1.0, 4: 2.0, 6: 4.0}  # of azimuth; in which there is a lamp, and how bright
X, Y, Z = np.eye(3)
SLOPE = math.sqrt(0.5)
FRONT, BACK = "front", "back"


def disk(normal):
    return tp.Disk(radius=1e-3, normal=tuple(normal))


def pane(normal, up=None):
    return tp.Rectangle(width=2e-3, height=1e-3, normal=tuple(normal), up=up)


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


def assert_seen(values):
    """Only the bins with lamps have light, in proportion to their brightness, with noise of 5 % at most."""
    lit = {k: value for k, value in enumerate(np.ravel(values)) if value > 0}
    assert lit.keys() == BRIGHT.keys(), lit
    dim, medium, bright = lit.values()
    assert 1.5 < medium / dim < 2.5 and 1.5 < bright / medium < 2.5, lit


LEVEL = [(name, "world") for name, (_, _, e_u, e_v) in FLAT.items() if abs(np.cross(e_u, e_v)[2]) > 0.9]
QUICK = ("up, from behind", "east", "sloped, from behind", "triangle")
TURNED = [
    pytest.param(*pair, marks=() if pair[0] in QUICK or pair == ("down", "world") else pytest.mark.slow)
    for pair in (*((name, "local") for name in FLAT), *LEVEL)
]


@pytest.mark.parametrize("estimator", ["analog", "aimed", "expected", "backward"])
@pytest.mark.parametrize(("case", "frame"), TURNED)
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
    scene = tp.Scene(lamps, detectors=looks)
    result = tp.simulate(scene, particles, estimator=estimator, seed=1, progress=False)
    assert_seen(result["meter"].radiance.value)


def rays(places, flights):
    """Pencils of light along flights, which pass through places after a tenth of a metre."""
    starts = {k: tuple(np.asarray(places[k]) - 0.1 * np.asarray(flights[k])) for k in BRIGHT}
    return [
        tp.Source(tp.Point(position=starts[k]), tp.Beam(tuple(flights[k]), power=power))
        for k, power in BRIGHT.items()
    ]


def crossed(shape, side, places, flights, **bins):
    meter = tp.Detector(shape, "meter", side=side, **bins)
    return run_many(rays(places, flights), meter, particles=7 * 64)["meter"]


@pytest.mark.parametrize("case", FLAT)
def test_departures_count_at_the_azimuth_that_they_fly_to(case):
    shape, side, e_u, e_v = FLAT[case]
    flights = {k: 0.5 * np.cross(e_u, e_v) + math.sqrt(0.75) * turned(e_u, e_v, k) for k in BRIGHT}
    places = dict.fromkeys(BRIGHT, shape.middle)
    assert_seen(crossed(shape, side, places, flights, directions=tp.Directions(phi=BINS)).radiance_out.value)


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
    assert_seen((reading.irradiance * reading.detector.positions.areas(shape).ravel()).value)


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
    assert_seen(crossed(shape, sides[is_within], places, flights, directions=bins).radiance.value)


@pytest.mark.parametrize("is_within", [False, True])
@pytest.mark.parametrize("name", ["ball", "tube"])
def test_places_round_an_axis_turn_from_x_to_y_seen_from_either_side(name, is_within):
    shape, *sides = CURVED[name]
    places = {k: turned(X, Y, k) for k in BRIGHT}
    flights = {k: place if is_within else -place for k, place in places.items()}
    assert_seen(
        crossed(shape, sides[is_within], places, flights, positions=tp.Positions(v=BINS)).irradiance.value
    )


# ---- crossings beyond the grazing cut ----

DISK = tp.Disk(radius=0.5)
METER = tp.Detector(DISK, "meter")


def flat_beam(mu, power=1.0):
    """Through the middle of the disk, so flat."""
    direction = (math.sqrt((1 - mu) * (1 + mu)), 0, -mu)
    return tp.Source(tp.Point(position=(-1, 0, mu)), tp.Beam(direction=direction, power=power))


def warnings_of(*sources, particles=20_000, meter=METER):
    result = run_many(sources, meter, particles=particles)
    return [warning for warning in result.warnings if "fluence_rate" in warning], result["meter"]


@pytest.mark.parametrize("bins", [{}, {"directions": tp.Directions(mu=4, phi=4)}])
@pytest.mark.parametrize("mu", [1e-7, 5e-4, 9e-4])
def test_a_beam_beyond_the_grazing_cut_is_doubtful(mu, bins):
    (warning,), reading = warnings_of(flat_beam(mu), meter=tp.Detector(DISK, "meter", **bins))
    assert warning.startswith(
        "fluence_rate of detector 'meter' is doubtful: 1 or more of it is crossings of |mu| < 0.001"
    )
    assert ", doubtful: 1 or more of it is crossings" in str(reading.fluence_rate)
    assert reading.fluence_rate.is_doubtful and not reading.flux_in.is_doubtful
    assert np.sum(reading.counts.value) == 20_000  # what is told apart does not spoil numbers


def test_grazing_light_beside_other_light_is_doubtful_by_its_share():
    """Of 4 pi W m^-2 from all around and half as much from the beam, 122 histories in 500 000."""
    lamp = tp.Source(tp.Sphere(radius=0.6), tp.Lambertian(radiance=1.0), side="inside")
    power = 4 * math.pi * DISK.area / 2000 / 2
    (warning,), _ = warnings_of(lamp, flat_beam(5e-4, power), particles=500_000)
    assert 0.25 < float(warning.split(": ")[1].split()[0]) < 0.4
    assert not warnings_of(lamp, particles=500_000)[0]


def test_neither_one_history_that_grazes_many_times_nor_one_batch_is_significant():
    assert _is_significant(np.arange(32) % 3 + 1.0) and _is_significant(np.full(4, 7.0))
    assert _is_significant(np.array([1000.0, 1000.0]))
    assert not _is_significant(np.array([40.0] + 31 * [0.0]))
    assert not _is_significant(np.array([1000.0]))  # of an interrupted run: its spread is 0/0


@pytest.mark.parametrize(("mu", "side"), [(7.06e-4, 1), (7.08e-4, -1)])
def test_half_of_what_grazes_from_a_constant_radiance_is_below_the_root_of_one_half(mu, side):
    """Of the cut: crossings come in proportion to |mu|."""
    result = run_many(flat_beam(mu), tp.Detector(tp.Plane(center=(0, 0, -1)), "other"), METER, particles=320)
    assert [batch.grazing.tolist() for batch in result.batches] == [[10 * side, 10 * side]] * 32


@pytest.mark.parametrize("mu", [1.1e-3, 0.5])
def test_a_beam_short_of_the_cut_is_sound(mu):
    assert not warnings_of(flat_beam(mu))[0]


def test_even_light_from_the_horizon_is_sound():
    """A low wall all around: a tenth of the fluence comes beyond the cut, as the mean supposes."""
    wall = tp.Cylinder(radius=0.6, height=0.004)
    lamp = tp.Source(wall, tp.Lambertian(radiance=1.0), side="back")
    found, reading = warnings_of(lamp, particles=1_000_000)
    assert not found
    assert reading.fluence_rate.value / (reading.flux_in.value + reading.flux_out.value) * DISK.area > 200
