"""Clocks at their edges: too short for a flight, edge-on, many events at once, and in any unit of time and length.

All runs have seed 1.  Most of it is asked of integers; statistical judgements fail right code in one of 10^6 seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.hard.clocked_runs import DEPARTURES, counts, histories, run

FALSE_ALARM = 1e-6


# ---- too short, edge-on ----


@pytest.mark.parametrize("share", [1e-12, 0.5, 1 - 1e-12])
def test_a_clock_that_stops_before_the_first_arrival_has_all_in_flight(share):
    """The nearest of the meter is 1 m away, at 2 m/s half a second."""
    lamp = tp.Source(tp.Disk(radius=0.5), tp.Lambertian(energy=3.0, speed=2.0))
    wall = tp.Surface(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=9.0), tp.Diffuse(0.5), "wall")
    duration = 0.5 * share
    looks = [tp.Detector("wall", times=2), tp.PhaseSpace(z=(0, 0.5, 1.0), time=(duration / 2, duration))]
    result = run(tp.Scene(lamp, wall, looks, duration=duration))
    assert (counts(result["wall"]) == 0).all() and (result["wall"].energy_in.value == 0).all()
    assert set(result["wall"].energy_in.reason) == {"no score"}
    assert result.ledger["in_flight"].value == pytest.approx(3.0, rel=1e-14)
    assert result.ledger["absorbed"].value == 0
    assert histories(result, result["phase_space"].alive.value)[1] == 10_000
    assert 0.4 < histories(result, result["phase_space"].alive.value)[0] / 10_000 < 0.6


def test_a_clock_that_stops_at_the_very_arrival_has_it_counted():
    beam = tp.Gas(number=1.0, speed=2.0, direction=(0, 0, 1))
    wall = tp.Surface(tp.Disk(center=(0, 0, 1), radius=1.0), tp.Black(), "wall")
    looks = [tp.Detector("wall", side="back", times=(0.25, 0.5)), tp.PhaseSpace(z=(0, 1), time=(0.49, 0.5))]
    result = run(tp.Scene(tp.Source(tp.Point(), beam), wall, looks, duration=0.5))
    assert counts(result["wall"]) == 10_000
    assert result.ledger["absorbed"].value == pytest.approx(1.0) and result.ledger["in_flight"].value == 0
    np.testing.assert_array_equal(histories(result, result["phase_space"].alive.value), [10_000, 0])


DIRECTIONS = [(1.0, 0.0, 0.0), (0.6, 0.8, 0.0), (1.0, -2.0, 2.0), (0.123, 0.456, -0.789)]


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("shape", ["disk", "rectangle", "triangle"])
def test_a_detector_edge_on_to_a_beam_meets_next_to_none_of_it(direction, shape):
    """What it counts is crossed within the rounding of its normal; whatever it is, fluxes and fluence are finite."""
    d = np.array(direction) / np.linalg.norm(direction)
    normal = np.cross(d, (0.3, -0.4, 0.5))
    normal /= np.linalg.norm(normal)
    across = np.cross(normal, d)
    meter = {
        "disk": tp.Disk(radius=0.4, normal=tuple(normal)),
        "rectangle": tp.Rectangle(width=0.8, height=0.8, normal=tuple(normal), up=tuple(across)),
        "triangle": tp.Triangle(vertices=tuple(map(tuple, (0.4 * d, -0.4 * d, 0.4 * across)))),
    }[shape]
    beam = tp.Gas(number=1.0, speed=1.0, direction=direction, mass=1.0)
    for source in (tp.Box(size=2.0), tp.Disk(radius=0.3, center=tuple(-2 * d), normal=tuple(d))):
        emission = beam if isinstance(source, tp.Box) else tp.Beam(direction=direction, power=1.0, speed=1.0)
        looks = tp.Detector(meter, "meter", times=4, moments=True)
        result = run(tp.Scene(tp.Source(source, emission), [], looks, duration=5.0))
        reading = result["meter"]
        assert counts(reading).sum() + counts(reading, DEPARTURES).sum() <= 2
        assert np.isfinite(reading.fluence_rate.value).all() and np.isfinite(reading.pressure.value).all()
        assert result.ledger["lost"].value == 0
        assert result.ledger["in_flight"].value == pytest.approx(result.ledger["emitted"].value, rel=1e-12)


def test_a_beam_along_the_plane_of_its_own_walls_goes_on():
    """Particles that were born within the plane of a mirror and fly along it: they meet the far wall, on time."""
    faces = tp.Box(size=2.0).faces()
    walls = [tp.Surface(f, tp.Mirror() if n != "+x" else tp.Black(), n) for n, f in faces.items()]
    for z in (1.0, 1 - 2.0**-53, 1 - 1e-12):
        point = tp.Source(tp.Point(position=(0, 0, z)), tp.Gas(number=1.0, speed=1.0, direction=(1, 0, 0)))
        looks = tp.Detector("+x", side="back", times=(0.9, 1.1))
        result = run(tp.Scene(point, walls, looks, duration=3.0), 100)
        assert counts(result["+x"]) + result.ledger["in_flight"].value * 100 == pytest.approx(100)
        assert result.ledger["lost"].value == 0
        assert counts(result["+x"]) == 100


# ---- at once ----


def test_two_meters_on_one_sheet_count_the_same_crossings_at_the_same_instant():
    """One within the other, one upside down; in bins of time that end at the crossing's very instant."""
    beam = tp.Gas(number=1.0, speed=1.0, direction=(0, 0, 1))
    big, small = tp.Disk(center=(0, 0, 1), radius=1.0), tp.Rectangle(
        center=(0.1, 0, 1), normal=(0, 0, -1), width=0.5, height=0.5
    )  # fmt: skip
    looks = [
        tp.Detector(big, "big", side="back", times=(0, 1, 2)),
        tp.Detector(small, "small", times=(0, 1, 2)),
    ]
    looks += [
        tp.Detector(big, "from above", times=(0, 1, 2)),
        tp.Detector(big, "by small", side="back", via="small"),
    ]
    result = run(tp.Scene(tp.Source(tp.Point(), beam), [], looks, duration=2.0), 1000)
    for name in ("big", "small"):
        np.testing.assert_array_equal(counts(result[name]), [0, 1000])
    np.testing.assert_array_equal(counts(result["from above"], DEPARTURES), [0, 1000])
    assert counts(result["by small"]) == 0
    assert result.cost.crossings == 1000


def test_meters_that_cross_each_other_are_both_crossed_on_their_common_line():
    """Two panes, one leaning; the beam goes through the line on which they meet."""
    beam = tp.Gas(number=1.0, speed=1.0, direction=(0, 0, 1))
    panes = [tp.Disk(center=(0, 0, 1), radius=1.0), tp.Disk(center=(0, 0, 1), radius=1.0, normal=(1, 0, 1))]
    looks = [tp.Detector(p, str(k), side="back", times=(0, 1, 2)) for k, p in enumerate(panes)]
    result = run(tp.Scene(tp.Source(tp.Point(), beam), [], looks, duration=2.0), 1000)
    assert [counts(result[name]).sum() for name in "01"] == [1000, 1000]


def test_nothing_slips_out_where_a_meter_cuts_a_wall():
    """Turned boxes, each with a meter through one wall and beams at points of the line that they have in common."""
    random = np.random.default_rng(3)
    for kind in (tp.Mirror(), tp.Diffuse(1.0)) * 3:
        turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
        offset, angle = random.normal(size=3), random.uniform(0.2, 1.4)
        along = turn @ (math.cos(0.3), math.sin(0.3), 0)
        normal = math.cos(angle) * turn[:, 2] + math.sin(angle) * np.cross(along, turn[:, 2])
        meter = tp.Disk(center=tuple(offset + turn[:, 2]), normal=tuple(normal), radius=0.8)
        sources = []
        for reach in random.uniform(-0.7, 0.7, 40):
            start = offset + turn @ random.uniform(-0.6, 0.6, 3)
            way = offset + turn[:, 2] + reach * along - start
            sources.append(tp.Source(tp.Point(position=start), tp.Gas(number=1.0, speed=1.0, direction=way)))
        walls = [turned_wall(turn, offset, axis, sign, kind) for axis in range(3) for sign in (-1, 1)]
        looks = [tp.Detector(meter, "meter"), tp.Snapshot(5.0)]
        result = run(tp.Scene(sources, walls, looks, duration=5.0), 400)
        places = (result["snapshot"].positions - offset) @ turn
        assert len(places) == 400 and np.abs(places).max() <= 1 + 1e-12


def turned_wall(turn, offset, axis, sign, kind):
    """A wall of a box of 2 m, turned and shifted."""
    _, up = (i for i in range(3) if i != axis)
    shape = tp.Rectangle(
        center=offset + sign * turn[:, axis],
        normal=sign * turn[:, axis],
        up=turn[:, up],
        width=2.0,
        height=2.0,
    )
    return tp.Surface(shape, kind)


@pytest.mark.parametrize("target", [(1, 1, 0), (1, 1, 1), (1, 1, 0.3)])
@pytest.mark.parametrize(
    "kind", [tp.Mirror(), tp.Diffuse(1.0), tp.Mixture({tp.Mirror(): 0.5, tp.Diffuse(1.0): 0.5})]
)
def test_a_ray_into_a_common_edge_stays_in_the_box_and_in_phase_space(target, kind):
    """All meet two or three walls at one instant; none is lost, and each is alive once at it and after it."""
    walls = [tp.Surface(f, kind, n) for n, f in tp.Box(size=2.0).faces().items()]
    speed = math.sqrt(sum(t * t for t in target))
    gas = tp.Source(tp.Point(), tp.Gas(number=1.0, speed=speed, direction=target))
    edges = (-1 - 1e-9, 0, 1 + 1e-9)
    looks = [tp.PhaseSpace(x=edges, z=edges, time=(0.0, 0.5, 1.0, 1.5, 7.25, 8.0))]
    result = run(tp.Scene(gas, walls, looks, duration=8.0), 1000)
    number = histories(result, result["phase_space"].number.value)
    assert (number.sum(axis=(1, 2)) == 1000).all()
    assert result.ledger["in_flight"].value == pytest.approx(1.0, rel=1e-14)


def test_what_happens_at_an_edge_of_time_belongs_to_what_begins_there():
    """Crossings at 1, 2, 3 and 4 s; bins of time are closed at their lower edge, the last one at both."""
    beam = tp.Gas(number=1.0, speed=1.0, direction=(0, 0, 1))
    disks = [
        tp.Detector(tp.Disk(center=(0, 0, z), radius=1.0), f"{z}", side="back", times=4) for z in (1, 2, 3, 4)
    ]
    end = tp.Surface(tp.Disk(center=(0, 0, 3.5), radius=0.1), tp.Transparent(), "end")
    result = run(tp.Scene(tp.Source(tp.Point(), beam), end, disks, duration=4.0), 1000)
    found = np.array([counts(result[d.name]) for d in disks])
    np.testing.assert_array_equal(
        found, 1000 * np.array([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 0, 1]])
    )


@pytest.mark.parametrize("tenths", range(1, 10))
def test_what_comes_after_some_tenths_of_a_second_is_in_the_bin_that_begins_then(tenths):
    """Steps of 0.1 add up to 0.7000000000000001 s, later than an arrival at 0.7 s."""
    beam = tp.Gas(number=1.0, speed=1.0, direction=(0, 0, 1))
    wall = tp.Detector(tp.Disk(center=(0, 0, tenths / 10), radius=1.0), "wall", side="back", times=10)
    result = run(tp.Scene(tp.Source(tp.Point(), beam), [], wall, duration=1.0), 100)
    np.testing.assert_array_equal(counts(result["wall"]), 100 * (np.arange(10) == tenths))


def test_at_the_instant_of_an_event_a_particle_is_after_it():
    """Born, reflected and absorbed at the very times of a look: there at birth, turned round, gone."""
    mirror = tp.Surface(tp.Disk(center=(0, 0, 1), radius=1.0), tp.Mirror())
    black = tp.Surface(tp.Disk(center=(0, 0, -1), radius=1.0), tp.Black())
    source = tp.Source(
        tp.Disk(radius=0.1), tp.Beam(direction=(0, 0, 1), energy=1.0, speed=1.0), pulse=tp.Instant(1.0)
    )
    times = (0.5, 1.0, 2.0, 3.0, 4.0, 5.0)
    looks = [tp.PhaseSpace(vz=(-2, 0, 2), time=times), tp.Snapshot(2.0, particles=1000)]
    result = run(tp.Scene(source, [mirror, black], looks, duration=8.0), 1000)
    number = histories(result, result["phase_space"].number.value)
    np.testing.assert_array_equal(number[:, 1], [0, 1000, 0, 0, 0, 0])
    np.testing.assert_array_equal(number[:, 0], [0, 0, 1000, 1000, 0, 0])
    assert (result["snapshot"].velocities == (0, 0, -1)).all()
    np.testing.assert_allclose(result["snapshot"].positions[:, 2], 1.0, rtol=1e-15)


@pytest.mark.parametrize("duration", [0.1, 0.3, 0.7, 1e-3, 3e-5, 1e9, 1.0])
@pytest.mark.parametrize("speed", [3.0, 0.7, 343.0])
def test_a_speed_on_an_edge_is_in_the_bin_above_it_in_any_unit_of_time(duration, speed):
    gas = tp.Gas(number=1.0, speed=speed, direction=(0, 0, 1))
    reach = speed * duration
    meter = tp.Disk(center=(0, 0, 0.5 * reach), radius=1.3 * reach)
    looks = [tp.Detector(meter, "meter", side="back", speeds=(0, speed, 2 * speed))]
    looks += [tp.PhaseSpace(speed=(0, speed, 2 * speed), time=duration / 3)]
    result = run(tp.Scene(tp.Source(tp.Point(), gas), [], looks, duration=duration), 100)
    np.testing.assert_array_equal(counts(result["meter"]), [0, 100])
    np.testing.assert_array_equal(histories(result, result["phase_space"].number.value), [0, 100])


# ---- any unit ----


def furnace(length, second):
    """A gas and a steady source in a box of thermal and black walls, in such units of length and time."""
    speed = length / second
    faces = tp.Box(size=2 * length).faces()
    hot = tp.Maxwellian(sigma=1.5 * speed, mass=1.0)
    kinds = [tp.Diffuse(0.9), tp.Mirror(), tp.Diffuse(1.0, speed=hot), tp.Black(), tp.Diffuse(0.5)]
    kinds.append(tp.Mixture({tp.Mirror(): 0.5, tp.Diffuse(1.0): 0.5}))
    walls = [tp.Surface(f, kind, n) for (n, f), kind in zip(faces.items(), kinds, strict=True)]
    cool = tp.Maxwellian(sigma=0.8 * speed, mass=1.0, drift=(0.2 * speed, 0.0, -0.1 * speed))
    sources = [
        tp.Source(tp.Box(size=length), tp.Gas(number=3.0, speed=cool)),
        tp.Source(
            "-z", tp.Effusive(number=2.0, speed=hot), side="back", pulse=tp.BoxPulse(second, 2 * second)
        ),
    ]
    edges = (-length, -0.2 * length, length)
    looks = [
        tp.Detector("-x", side="back", times=5, speeds=(0, speed, 3 * speed), moments=True),
        tp.Detector(tp.Disk(radius=0.5 * length), "pane", via="-x", events=(1, 5)),
        tp.PhaseSpace(
            x=edges, vx=(-3 * speed, 0.1 * speed, 3 * speed), time=(0.0, second, 4 * second), moments=True
        ),
    ]
    return run(tp.Scene(sources, walls, looks, duration=4 * second), 20_000)


def digits(length, second):
    """Everything that was measured, freed of its units."""
    result, speed = furnace(length, second), length / second
    wall, picture = result["-x"], result["phase_space"]
    measured = [
        *counts(wall).ravel(),
        *counts(result["pane"]).ravel(),
        *(wall.flux_in.value * second).ravel(),
        *(wall.mean_speed_out.value / speed).ravel(),
        *(wall.pressure.value * length * second**2).ravel(),
        *picture.number.value.ravel(),
        *picture.outside.value.ravel(),
        *(picture.density.value * length * speed).ravel(),
        *(picture.mean_vx.value / speed).ravel(),
        *(picture.variance_vz.value / speed**2).ravel(),
        *[result.ledger[name].value for name in ("absorbed", "in_flight", "roulette")],
    ]
    return np.array(measured, float)


@pytest.mark.parametrize(
    ("length", "second"),
    [(1.0, 1e17), (1.0, 1e-18), (1e-9, 1.0), (1e9, 1.0), (1e-9, 1e-18), (1e9, 1e17), (1e-9, 1e17)],
)
def test_digits_do_not_know_the_units_of_length_and_time(length, second):
    """Not a history goes another way; numbers agree to their rounding."""
    one, other = digits(1.0, 1.0), digits(length, second)
    np.testing.assert_allclose(other, one, rtol=2e-11, atol=1e-13)
    assert len(one) > 60 and np.isfinite(one).all()
