"""Clocks and speeds at their ends: too short for a flight, edge-on, events at once, any unit, at rest, sixteen decades, fast drifts.

Seed 1 unless stated.  Most results are whole numbers; statistical judgements fail right code in one of 10^6 seeds.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_follows, assert_z_spread
from tests.slow import quick
from transport.units import BOLTZMANN

FALSE_ALARM = 1e-6
UPWARDS = tp.Source(tp.Point(), tp.Gas(number=1.0, speed=1.0, direction=(0, 0, 1)))
HALF_MIRROR = tp.Mixture({tp.Mirror(): 0.5, tp.Diffuse(1.0): 0.5})


def run(scene, particles=10_000, **options):
    return tp.simulate(scene, particles=particles, seed=1, progress=False, **options)


def counts(reading, way="in"):
    return reading.counts_of(f"weight {way}").sum(axis=0)


def histories(result, value):
    """Numbers of histories from numbers of particles."""
    found = np.asarray(value) * result.particles / result.ledger["emitted"].value
    np.testing.assert_allclose(found, np.rint(found), rtol=0, atol=1e-5)
    return np.rint(found).astype(int)


def pane(z, radius=1.0, normal=(0, 0, 1)):
    return tp.Disk(center=(0, 0, z), radius=radius, normal=normal)


def walls_of(box, kinds):
    """The faces of a box, with a material each."""
    return [tp.Surface(f, kind, n) for (n, f), kind in zip(box.faces().items(), kinds, strict=True)]


# ---- too short, edge-on ----


def test_a_clock_that_stops_at_the_very_arrival_has_it_counted():
    beam = tp.Gas(number=1.0, speed=2.0, direction=(0, 0, 1))
    wall = tp.Surface(pane(1), tp.Black(), "wall")
    looks = [tp.Detector("wall", side="back", times=(0.25, 0.5)), tp.PhaseSpace(z=(0, 1), time=(0.49, 0.5))]
    result = run(tp.Scene(tp.Source(tp.Point(), beam), wall, looks, duration=0.5))
    assert counts(result["wall"]) == 10_000
    assert result.ledger["absorbed"].value == pytest.approx(1.0) and result.ledger["in_flight"].value == 0
    np.testing.assert_array_equal(histories(result, result["phase_space"].alive.value), [10_000, 0])


DIRECTIONS = [(1.0, 0.0, 0.0), (0.6, 0.8, 0.0), (1.0, -2.0, 2.0), (0.123, 0.456, -0.789)]


@pytest.mark.parametrize("direction", quick(DIRECTIONS, DIRECTIONS[0], DIRECTIONS[3]))
@pytest.mark.parametrize("shape", ["disk", "rectangle", "triangle"])
def test_a_detector_edge_on_to_a_beam_meets_next_to_none_of_it(direction, shape):
    """What it counts is crossed within the rounding of its normal; whatever it is, fluxes and fluence are finite."""
    d = np.array(direction) / np.linalg.norm(direction)
    normal = np.cross(d, (0.3, -0.4, 0.5))
    normal /= np.linalg.norm(normal)
    across = np.cross(normal, d)
    flat = {
        "disk": tp.Disk(radius=0.4, normal=tuple(normal)),
        "rectangle": tp.Rectangle(width=0.8, height=0.8, normal=tuple(normal), up=tuple(across)),
        "triangle": tp.Triangle(vertices=tuple(map(tuple, (0.4 * d, -0.4 * d, 0.4 * across)))),
    }[shape]
    gas = tp.Gas(number=1.0, speed=1.0, direction=direction, mass=1.0)
    light = tp.Beam(direction=direction, power=1.0, speed=1.0)
    lid = tp.Disk(radius=0.3, center=tuple(-2 * d), normal=tuple(d))
    for source in (tp.Source(tp.Box(size=2.0), gas), tp.Source(lid, light)):
        look = tp.Detector(flat, "detector", times=4, moments=True)
        result = run(tp.Scene(source, [], look, duration=5.0))
        reading = result["detector"]
        assert counts(reading).sum() + counts(reading, "out").sum() <= 2
        assert np.isfinite(reading.fluence_rate.value).all() and np.isfinite(reading.pressure.value).all()
        assert result.ledger["lost"].value == 0
        assert result.ledger["in_flight"].value == pytest.approx(result.ledger["emitted"].value, rel=1e-12)


@pytest.mark.parametrize("z", [1.0, 1 - 2.0**-53, 1 - 1e-12])
def test_a_beam_along_the_plane_of_its_own_walls_goes_on(z):
    """Particles that were born within the plane of a mirror and fly along it meet the far wall, on time."""
    faces = tp.Box(size=2.0).faces().items()
    walls = [tp.Surface(f, tp.Mirror() if n != "+x" else tp.Black(), n) for n, f in faces]
    point = tp.Source(tp.Point(position=(0, 0, z)), tp.Gas(number=1.0, speed=1.0, direction=(1, 0, 0)))
    result = run(tp.Scene(point, walls, tp.Detector("+x", side="back", times=(0.9, 1.1)), duration=3.0), 100)
    assert counts(result["+x"]) == 100
    assert result.ledger["lost"].value == result.ledger["in_flight"].value == 0


# ---- at once ----


@pytest.mark.parametrize("target", [(1, 1, 0), (1, 1, 1), (1, 1, 0.3)])
@pytest.mark.parametrize(
    "kind", [tp.Mirror(), tp.Diffuse(1.0), HALF_MIRROR], ids=["mirror", "diffuse", "mixture"]
)
def test_a_ray_into_a_common_edge_stays_in_the_box_and_in_phase_space(target, kind):
    """All meet two or three walls at one instant; none is lost, and each is alive once at it and after it."""
    gas = tp.Gas(number=1.0, speed=math.hypot(*target), direction=target)
    edges = (-1 - 1e-9, 0, 1 + 1e-9)
    look = tp.PhaseSpace(x=edges, z=edges, time=(0.0, 0.5, 1.0, 1.5, 7.25, 8.0))
    walls = walls_of(tp.Box(size=2.0), [kind] * 6)
    result = run(tp.Scene(tp.Source(tp.Point(), gas), walls, look, duration=8.0), 1000)
    number = histories(result, result["phase_space"].number.value)
    assert (number.sum(axis=(1, 2)) == 1000).all()
    assert result.ledger["in_flight"].value == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("tenths", range(1, 10))
def test_an_arrival_after_some_tenths_of_a_second_is_in_the_bin_that_begins_then(tenths):
    """Steps of 0.1 add up to 0.7000000000000001 s, later than an arrival at 0.7 s."""
    wall = tp.Detector(pane(tenths / 10), "wall", side="back", times=10)
    result = run(tp.Scene(UPWARDS, [], wall, duration=1.0), 100)
    np.testing.assert_array_equal(counts(result["wall"]), 100 * (np.arange(10) == tenths))


@pytest.mark.parametrize("duration", quick([0.1, 0.3, 0.7, 1e-3, 3e-5, 1e9, 1.0], 0.1, 0.7, 3e-5))
@pytest.mark.parametrize("speed", [3.0, 0.7, 343.0])
def test_a_speed_on_an_edge_is_in_the_bin_above_it_in_any_unit_of_time(duration, speed):
    gas = tp.Gas(number=1.0, speed=speed, direction=(0, 0, 1))
    reach, bins = speed * duration, (0, speed, 2 * speed)
    looks = [tp.Detector(pane(0.5 * reach, 1.3 * reach), "detector", side="back", speeds=bins)]
    looks += [tp.PhaseSpace(speed=bins, time=duration / 3)]
    result = run(tp.Scene(tp.Source(tp.Point(), gas), [], looks, duration=duration), 100)
    np.testing.assert_array_equal(counts(result["detector"]), [0, 100])
    np.testing.assert_array_equal(histories(result, result["phase_space"].number.value), [0, 100])


# ---- any unit ----


@lru_cache
def digits(length, second):
    """All that is measured of a gas and a steady source between thermal and black walls, freed of its units."""
    speed = length / second
    hot = tp.Maxwellian(sigma=1.5 * speed, mass=1.0)
    kinds = [
        tp.Diffuse(0.9),
        tp.Mirror(),
        tp.Diffuse(1.0, speed=hot),
        tp.Black(),
        tp.Diffuse(0.5),
        HALF_MIRROR,
    ]
    cool = tp.Maxwellian(sigma=0.8 * speed, mass=1.0, drift=(0.2 * speed, 0.0, -0.1 * speed))
    pulse = tp.BoxPulse(second, 2 * second)
    sources = [
        tp.Source(tp.Box(size=length), tp.Gas(number=3.0, speed=cool)),
        tp.Source("-z", tp.Effusive(number=2.0, speed=hot), side="back", pulse=pulse),
    ]
    edges, speeds = (-length, -0.2 * length, length), (-3 * speed, 0.1 * speed, 3 * speed)
    looks = [
        tp.Detector("-x", side="back", times=5, speeds=(0, speed, 3 * speed), moments=True),
        tp.Detector(tp.Disk(radius=0.5 * length), "pane", via="-x", events=(1, 5)),
        tp.PhaseSpace(x=edges, vx=speeds, time=(0.0, second, 4 * second), moments=True),
    ]
    walls = walls_of(tp.Box(size=2 * length), kinds)
    result = run(tp.Scene(sources, walls, looks, duration=4 * second), 20_000)
    wall, picture = result["-x"], result["phase_space"]
    measured = [
        counts(wall),
        counts(result["pane"]),
        wall.flux_in.value * second,
        wall.mean_speed_out.value / speed,
        wall.pressure.value * length * second**2,
        picture.number.value,
        picture.outside.value,
        picture.density.value * length * speed,
        picture.mean_vx.value / speed,
        picture.variance_vz.value / speed**2,
        *(result.ledger[name].value for name in ("absorbed", "in_flight", "roulette")),
    ]
    return np.concatenate([np.ravel(each).astype(float) for each in measured])


UNITS = [(1.0, 1e17), (1.0, 1e-18), (1e-9, 1.0), (1e9, 1.0), (1e-9, 1e-18), (1e9, 1e17), (1e-9, 1e17)]


@pytest.mark.parametrize("units", quick(UNITS, (1e-9, 1e17)))
def test_digits_do_not_depend_on_the_units_of_length_and_time(units):
    """Not a history goes another way; numbers agree to their rounding."""
    one, other = digits(1.0, 1.0), digits(*units)
    np.testing.assert_allclose(other, one, rtol=2e-11, atol=1e-13)
    assert len(one) > 60 and np.isfinite(one).all()


# ---- at rest ----


@pytest.mark.parametrize(
    "walls", [(), tp.Surface(tp.Box(size=2.0), tp.Mirror(), "walls")], ids=["open", "mirrored"]
)
@pytest.mark.parametrize("direction", [None, (0.3, 0.2, 1.0)])
@pytest.mark.parametrize("has_more", [False, True], ids=["a detector", "phase space and snapshots"])
def test_particles_at_rest_stay_where_they_are_and_meet_nothing(walls, direction, has_more):
    """With and without something that reads speeds."""
    times = (0.0, 1.0, 5.0)
    looks = [tp.Detector(tp.Sphere(radius=0.4), "detector", times=3)]
    if has_more:
        looks += [
            tp.PhaseSpace(x=(-1.0, -0.2, 0.3, 1.0), time=times, moments=True),
            tp.PhaseSpace(speed=(0, 1), time=5.0, name="v"),
            *(tp.Snapshot(t, particles=10_000, name=f"at {t:g}") for t in times),
        ]
    gas = tp.Source(tp.Box(size=1.5), tp.Gas(number=7.0, speed=0.0, direction=direction))
    result = run(tp.Scene(gas, walls, looks, duration=5.0))
    assert (counts(result["detector"]) == 0).all() and result.cost.crossings == 0
    assert result.ledger["in_flight"].value == pytest.approx(7.0, rel=1e-14)
    if has_more:
        number = histories(result, result["phase_space"].number.value)
        assert (number == number[0]).all() and (number.sum(axis=1) == 10_000).all()
        assert histories(result, result["v"].number.value) == 10_000
        assert (result["phase_space"].mean_speed.value == 0).all()
        first, last = (result[f"at {t:g}"] for t in (0.0, 5.0))
        assert (first.velocities == 0).all() and len(first) == 10_000
        np.testing.assert_array_equal(first.positions, last.positions)


def rest_or_fly(u):
    return np.where(u < 0.5, 0.0, 1.0)


def places_at_rest(shot):
    """Of the particles that do not move, by history."""
    rows = zip(shot.batches, shot.histories, shot.positions, shot.velocities, strict=True)
    return {(b, h): tuple(x) for b, h, x, v in rows if not v.any()}


def test_particles_at_rest_among_others_are_neither_moved_nor_lost():
    gas = tp.Source(tp.Sphere(radius=0.2), tp.Gas(number=2.0, speed=tp.InverseCDF(rest_or_fly)))
    looks = [tp.Snapshot(t, particles=10_000, name=f"at {t:g}") for t in (0.0, 4.0)]
    looks += [tp.PhaseSpace(speed=(0, 0.5, 2), time=(0.0, 4.0))]
    ball = tp.Surface(tp.Sphere(radius=0.5), tp.Diffuse(1.0))
    result = run(tp.Scene(gas, ball, looks, duration=4.0))
    number = histories(result, result["phase_space"].number.value)
    assert (number[0] == number[1]).all() and number[0].sum() == 10_000
    assert_follows(number[0], [0.5, 0.5], FALSE_ALARM)
    shots = [result["at 0"], result["at 4"]]
    for shot in shots:
        assert np.isin(np.round(np.linalg.norm(shot.velocities, axis=1), 12), (0.0, 1.0)).all()
    first, last = map(places_at_rest, shots)
    assert first == last and len(first) == number[0][0]
    assert result.ledger["in_flight"].value == pytest.approx(2.0, rel=1e-14)


# ---- twelve decades of speed in one run ----

DECADES = 10.0 ** np.arange(-12, 1)


def twelve_decades(u):
    return 10.0 ** (12 * u - 12)


@lru_cache(maxsize=1)
def spread():
    """Log-uniform speeds from 1e-12 to 1 m/s in a box of one thermal, one half-mirroring and four mirroring walls."""
    kinds = [tp.Diffuse(1.0, speed=tp.InverseCDF(twelve_decades)), HALF_MIRROR, *[tp.Mirror()] * 4]
    gas = tp.Source(tp.Box(size=1.0), tp.Gas(number=1.0, speed=tp.InverseCDF(twelve_decades)))
    looks = [
        tp.PhaseSpace(speed=DECADES, time=(0.0, 20.0), moments=True),
        tp.PhaseSpace(x=(-0.5, 0.0, 0.5), speed=DECADES, time=20.0, name="by place"),
        *[tp.Snapshot(t, particles=100_000, name=f"at {t:g}") for t in (0.0, 20.0)],
    ]
    return run(tp.Scene(gas, walls_of(tp.Box(size=1.0), kinds), looks, duration=20.0), 48_000)


def test_every_decade_has_its_share_and_none_of_its_particles_is_lost():
    result = spread()
    number = histories(result, result["phase_space"].number.value)
    assert number.shape == (2, 12) and (number.sum(axis=1) == 48_000).all()
    assert_follows(number[0], np.full(12, 1 / 12), FALSE_ALARM)
    assert histories(result, result["by place"].number.value).sum() == 48_000
    # The slow have not met a wall; of those that have, some were given another speed.
    assert abs(number[1, :9].sum() - number[0, :9].sum()) < 0.2 * number[0, :9].sum()
    assert number[1, 11] != number[0, 11]
    for name in ("in_flight", "emitted"):
        assert result.ledger[name].value == pytest.approx(1.0, rel=1e-14)
    assert result.ledger["lost"].value == result.ledger["escaped"].value == 0
    assert result.cost.crossings > 50_000


@pytest.mark.parametrize("decade", range(12))
def test_moments_of_a_decade_are_those_of_its_particles(decade):
    """Sums of v down to 1e-12 and of v² to 1e-24 of the fastest, beside those of the fastest themselves."""
    result = spread()
    found = result["phase_space"]
    low, high = DECADES[decade : decade + 2]
    for k, time in enumerate((0.0, 20.0)):
        v = result[f"at {time:g}"].velocities
        speeds = np.linalg.norm(v, axis=1)
        is_in = (speeds >= low) & (speeds < high)
        v, speeds, n = v[is_in], speeds[is_in], is_in.sum()
        flux = speeds.sum() * result.ledger["emitted"].value / result.particles / (high - low)
        assert found.fluence_rate.value[k, decade] == pytest.approx(flux, rel=1e-9, abs=0)
        assert found.mean_speed.value[k, decade] == pytest.approx(speeds.mean(), rel=20 / n, abs=0)
        for j, axis in enumerate("xyz"):
            of_axis, error = v[:, j], np.sqrt(v[:, j].var() / n)
            mean, variance = (getattr(found, f"{q}_v{axis}").value[k, decade] for q in ("mean", "variance"))
            assert mean == pytest.approx(of_axis.mean(), rel=0, abs=0.1 * error)
            assert variance == pytest.approx(of_axis.var(), rel=40 / n, abs=0)
            assert variance != pytest.approx(1.02 * of_axis.var(), rel=40 / n, abs=0)


def test_slow_particles_beside_fast_ones_have_moved_by_v_t():
    """Those below 1e-4 m/s: at the far end of the box after 20 s only if a wall was within 2 mm."""
    shots = [spread()[f"at {t:g}"] for t in (0, 20)]
    order = [np.lexsort((s.histories, s.batches)) for s in shots]
    (x, v), (y, w) = ((s.positions[o], s.velocities[o]) for s, o in zip(shots, order, strict=True))
    slow = (np.abs(x) < 0.497).all(axis=1) & (np.linalg.norm(v, axis=1) < 1e-4)
    assert slow.sum() > 20_000
    np.testing.assert_array_equal(w[slow], v[slow])
    np.testing.assert_allclose(y[slow], x[slow] + 20 * v[slow], rtol=0, atol=1e-15)


# ---- moments of numbers of very different size: neither sums of squares nor their difference lose digits unnoticed ----


def moments_of(sources, seed=1, particles=4000, **bins):
    scene = tp.Scene(sources, [], tp.PhaseSpace(**bins, time=0.0, moments=True), duration=1e-9)
    return tp.simulate(scene, particles=particles, seed=seed, progress=False, threads=1)["phase_space"]


def gas(speed, **options):
    return tp.Source(tp.Point(), tp.Gas(number=1.0, speed=speed, **options))


def sixteen_decades(u):
    """Density 1/v^2: the slowest are the most, and the fastest that can be drawn flies at 9e15."""
    return 1 / (1 - u)


def test_variances_of_slow_particles_among_very_fast_ones_are_theirs():
    """(1 / 9e15)^2 is less than the last bit of a sum that has room for the fastest: cut off, its squares were 0."""
    edges = (1, 2, 4, 8, 16)
    found = moments_of(
        gas(tp.InverseCDF(sixteen_decades), direction=(0, 0, 1)), particles=200_000, speed=edges
    )
    low = np.array(edges[:-1])
    exact = low**2 * (2 - (2 * math.log(2)) ** 2)
    assert_agrees(found.number, 1 / (2 * low), FALSE_ALARM)
    assert_agrees(found.mean_vz, low * 2 * math.log(2), FALSE_ALARM)
    assert_agrees(found.variance_vz, exact, FALSE_ALARM)
    with pytest.raises(AssertionError):
        assert_agrees(found.variance_vz, 1.1 * exact, FALSE_ALARM)


@pytest.mark.parametrize("drift", quick([1e2, 1e5, 1e8], 1e8))
def test_the_variance_of_a_stream_is_right_however_fast_it_drifts(drift):
    """<v^2> - <v>^2 of 1e16 each would leave a difference of 1 to rounding, of which no spread over batches knows."""
    way = drift * np.array([2.0, -1.0, 2.0]) / 3
    z = []
    for seed in range(12):
        found = moments_of(gas(tp.Maxwellian(sigma=1.0, drift=way)), seed, x=(-9e9, 9e9))
        z += [variance.z(1.0)[0] for variance in (found.variance_vx, found.variance_vy, found.variance_vz)]
        np.testing.assert_allclose(found.mean_vx.value, way[0], rtol=1e-15, atol=0.1)
    assert_z_spread(z, math.inf, FALSE_ALARM)


@pytest.mark.parametrize("drift", quick([1e4, 1e7, 1e9], 1e7))
def test_a_variance_that_rounding_has_taken_is_not_reported_as_known(drift):
    """A slow gas beside a fast stream: no velocity is near to both.  Right within its error, or the error is unknown."""
    sources = [gas(tp.Maxwellian(sigma=1.0)), gas(drift, direction=(0, 0, 1))]
    z = np.array([moments_of(sources, s, speed=(0, 100, 2 * drift)).variance_vz.z(1.0)[0] for s in range(12)])
    if drift < 1e6:
        assert_z_spread(z, math.inf, FALSE_ALARM)
    assert (np.isnan(z) | (np.abs(z) < 5.0)).all()


# ---- walls that keep a gas at their temperature ----

MASS, SIGMA, DENSITY = 4.65e-26, 300.0, 1e12  # nitrogen at room temperature
TEMPERATURE = MASS * SIGMA**2 / BOLTZMANN
ROOM = tp.Box(size=(0.5, 0.8, 1.0))
FLIGHT = 4 * 0.4 / 3.4 / (math.sqrt(8 / math.pi) * SIGMA)  # the mean chord 4 V/S, at the mean speed


def assert_stays_in_equilibrium_through_twenty_flights(wall):
    """A gas between walls that take three of five particles to their own temperature, and mirror the others."""
    walls = tp.Surface(ROOM, tp.Mixture({tp.Diffuse(1.0, speed=wall): 0.6, tp.Mirror(): 0.4}), "walls")
    inside = tp.Gas(density=DENSITY, speed=tp.Maxwellian(sigma=SIGMA, mass=MASS))
    times = (0.0, 20 * FLIGHT)
    looks = [
        tp.PhaseSpace(z=(-0.5, -0.2, 0.5), time=times, within=ROOM, moments=True, name="gas"),
        tp.Detector("walls", "pressure", side="back", moments=True),
    ]
    result = run(tp.Scene(tp.Source(ROOM, inside), walls, looks, duration=times[1]), 40_000)
    found, pressure = result["gas"], DENSITY * BOLTZMANN * TEMPERATURE
    assert result.ledger["in_flight"].value == pytest.approx(DENSITY * 0.4, rel=1e-12)
    assert str(found.density.unit) == "m^-3"
    assert_agrees(found.density, DENSITY, FALSE_ALARM)
    assert_agrees(found.temperature, TEMPERATURE, FALSE_ALARM)
    assert_agrees(found.pressure, pressure, FALSE_ALARM)
    assert_agrees(result["pressure"].pressure, pressure, FALSE_ALARM)
    for mean in (found.mean_vx, found.mean_vy, found.mean_vz):
        assert_agrees(mean, 0.0, FALSE_ALARM)


def as_in_the_gas(u):
    """Rayleigh's law: weighted by speed it is that of the gas itself, which a wall must not give off."""
    return SIGMA * np.sqrt(-2 * np.log1p(-u))


@pytest.mark.slow
def test_walls_of_the_temperature_of_a_gas_keep_it_there_and_others_are_seen():
    """What leaves a wall is weighted by its speed, 2 kT each in the mean; what is in the gas has 3/2 kT."""
    assert_stays_in_equilibrium_through_twenty_flights(tp.Maxwellian(sigma=SIGMA, mass=MASS))
    for wrong in (tp.Maxwellian(sigma=math.sqrt(1.02) * SIGMA, mass=MASS), tp.InverseCDF(as_in_the_gas)):
        with pytest.raises(AssertionError, match="z = "):
            assert_stays_in_equilibrium_through_twenty_flights(wrong)
