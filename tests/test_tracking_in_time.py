"""Light in fog on a clock: absorbed in time, slower where the index is higher, spreading as random flights do.

All runs have seed 1; each judgement fails right code in one of 10^5 seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.tracking_scenes import FALSE_ALARM, TRACKINGS, assert_rejects, run
from transport.theory import random_flights

LIGHT_SPEED = 299792458.0


def flash(index, duration, tracking="analog", walls=(), **looks):
    fog = tp.Medium(absorption=0.4, scattering=1.6, phase=tp.HenyeyGreenstein(0.5), index=index)
    lamp = tp.Source(tp.Point(), tp.Isotropic(energy=1.0), pulse=tp.Instant(0.0))
    return run(
        tp.Scene(lamp, walls, **looks, medium=fog, duration=duration * index / LIGHT_SPEED), tracking, 20_000
    )


@pytest.mark.parametrize("index", [1.0, 1.5])
@pytest.mark.parametrize("name", ["analog", "analog, forced", "analog, split"])
def test_light_in_fog_is_absorbed_in_time_at_its_speed_there(index, name):
    """After a flight of 2 m exp(-0.8) is left, in fog of any index; in a room of mirrors as well."""
    for walls in ((), tp.Surface(tp.Box(size=1.0), tp.Mirror(), "walls")):
        ledger = flash(index, 2.0, TRACKINGS[name], walls).ledger
        assert_agrees(ledger["in_flight"], math.exp(-0.8), FALSE_ALARM)
        assert_agrees(ledger["absorbed"], -math.expm1(-0.8), FALSE_ALARM)
        assert_rejects(ledger["in_flight"], math.exp(-0.8 * 1.1))


def test_steady_light_in_fog_is_in_flight_for_a_lifetime():
    """A lamp that burns from 0 to the end: (1 - exp(-s))/s of its energy is still under way, s = 0.8."""
    fog = tp.Medium(absorption=0.4, scattering=1.6)
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=LIGHT_SPEED / 2.0))
    result = run(tp.Scene(lamp, medium=fog, duration=2.0 / LIGHT_SPEED))
    assert_agrees(result.ledger["in_flight"], -math.expm1(-0.8) / 0.8, FALSE_ALARM)


@pytest.mark.parametrize("index", [1.0, 1.5])
def test_light_that_met_nothing_in_fog_arrives_all_at_once(index):
    """A lane that has come to the wall waits while others still collide, and its clock with it."""
    sigma, way = 1.6, 0.26
    fog = tp.Medium(scattering=sigma, phase=tp.HenyeyGreenstein(0.9), index=index)
    times = np.linspace(0.0, 2.0, 81) * index / LIGHT_SPEED  # bins of 25 mm of way
    wall = tp.Surface(tp.Plane(center=(0, 0, way), normal=(0, 0, -1)), tp.Mirror(), "wall")
    lamp = tp.Source(tp.Point(), tp.Beam((0, 0, 1), energy=1.0), pulse=tp.Instant(0.0))
    looks = tp.Detector("wall", "straight", events=0, times=times)
    scene = tp.Scene(lamp, wall, looks, medium=fog, duration=times[-1])
    arrived = run(scene, "analog", 20_000)["straight"].energy_in
    assert np.flatnonzero(arrived.value).tolist() == [math.floor(way / 0.025)]
    assert_agrees(arrived.sum(), math.exp(-sigma * way), FALSE_ALARM)


def test_light_spreads_by_the_law_of_random_flights():
    """The mean square displacement of a snapshot, and of phase space at once; g forgotten would be seen."""
    fog = tp.Medium(scattering=2.0, phase=tp.HenyeyGreenstein(0.5))
    lamp = tp.Source(tp.Point(), tp.Isotropic(energy=1.0), pulse=tp.Instant(0.0))
    duration = 3.0 / LIGHT_SPEED
    looks = [tp.Snapshot(duration, particles=20_000, name="there")]
    result = run(tp.Scene(lamp, (), looks, medium=fog, duration=duration), None, 20_000)
    seen = result["there"]
    squares = (seen.positions**2).sum(axis=1)
    exact = random_flights.mean_square_displacement(6.0, 0.5) / 4  # 6 mean free paths of 0.5 m
    error = squares.std() / math.sqrt(len(squares))
    assert len(squares) == 20_000
    assert abs(squares.mean() - exact) < 4.42 * error
    assert abs(squares.mean() - random_flights.mean_square_displacement(6.0, 0.0) / 4) > 10 * error
    assert squares.max() <= 9.0 * (1 + 1e-12)


def test_snapshots_do_not_go_with_slower_light():
    lamp = tp.Source(tp.Point(), tp.Isotropic(energy=1.0), pulse=tp.Instant(0.0))
    scene = tp.Scene(lamp, (), tp.Snapshot(1e-9), medium=tp.Medium(scattering=2.0, index=1.5), duration=1e-8)
    with pytest.raises(tp.SceneError, match="need media of index=1"):
        run(scene, None, 1000)


def test_weights_do_not_go_with_a_clock():
    with pytest.raises(tp.SceneError, match="analog in a scene with a duration"):
        flash(1.0, 2.0, "weighted")
