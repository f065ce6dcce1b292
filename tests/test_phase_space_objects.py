"""Clocks, speeds and histories on detectors, phase spaces and snapshots: what they store, and what a scene makes of them."""

import math

import numpy as np
import pytest

import transport as tp
from transport.geometry.flat import Disk
from transport.geometry.shape import Point
from transport.geometry.solid import Box, Sphere
from transport.scene.bins import Directions, Positions
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Gas, Isotropic, Lambertian
from transport.scene.materials import Black, Diffuse, Mirror, Mixture, Surface, Transparent
from transport.scene.phase_space import COORDINATES, PhaseSpace, Snapshot
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.validation import SceneError

DISK, BALL, CUBE = Disk(radius=1), Sphere(radius=2), Box(size=2)
LAMP = Source(DISK, Lambertian(power=1))
WALL = Surface(DISK, Black(), name="floor")
X, VX = (-1.0, 0.0, 2.0), (-5.0, 5.0)


def meter(**how):
    return Detector(DISK, name="meter", **how)


def test_a_number_of_bins_of_time_shares_out_the_duration():
    assert meter(times=4).time_edges(2.0).tolist() == [0, 0.5, 1, 1.5, 2]
    assert meter(times=1).time_edges(3e-9).tolist() == [0, 3e-9]
    assert meter().time_edges(2.0) is None and meter().time_edges(None) is None


def test_edges_of_time_are_kept_and_the_last_rounding_is_forgiven():
    assert meter(times=(0.5, 1, 1.75)).time_edges(2.0).tolist() == [0.5, 1, 1.75]
    assert 3 * 0.1 > 0.3
    assert meter(times=[0, 0.1, 3 * 0.1]).time_edges(0.3).tolist() == [0, 0.1, 0.3]
    with pytest.raises(SceneError, match=r"times edges must be within \[0.0, 0.3\]"):
        meter(times=[0, 0.3001]).time_edges(0.3)


def test_edges_of_speed_are_kept():
    assert meter(speeds=np.array([0, 1e-6, 1e6])).speed_edges().tolist() == [0, 1e-6, 1e6]
    assert meter().speed_edges() is None


@pytest.mark.parametrize(
    ("given", "stored"),
    [
        (None, None),
        (0, (0, 0)),
        (np.int64(3), (3, 3)),
        ([1, 4], (1, 4)),
        ((2, math.inf), (2, math.inf)),
    ],
)
def test_events_are_stored_as_least_and_most(given, stored):
    events = meter(events=given).events
    assert events == stored
    assert events is None or all(type(n) is int or n == math.inf for n in events)


def test_via_is_stored_as_a_tuple_of_names():
    assert meter().via is None
    assert meter(via="pinhole").via == ("pinhole",)
    assert meter(via=["lens", "pinhole"]).via == ("lens", "pinhole")


def test_lists_arrays_and_integers_give_the_same_detector():
    plain = meter(times=(0.0, 1.0), speeds=(0.0, 2.0), via=("a",), events=(1, 2))
    same = meter(times=[0, 1], speeds=np.array([0, 2], dtype=np.int8), via="a", events=[1, np.int32(2)])
    assert same == plain and hash(same) == hash(plain)


def test_bins_of_a_detector_are_counted_over_all_its_axes():
    axes = {"times": 10, "speeds": range(11), "positions": Positions(u=10, v=10)}
    assert meter(**axes, directions=Directions(mu=100, phi=10)).times == 10  # ten million in all
    with pytest.raises(SceneError, match=r"times x speeds x u x v x mu x phi .* got 11000000,"):
        meter(**axes | {"times": 11}, directions=Directions(mu=100, phi=10))


def test_axes_of_phase_space_come_in_one_order():
    looks = PhaseSpace(vx=VX, x=X, time=1)
    assert list(looks.axes) == ["x", "vx"]
    assert [edges.tolist() for edges in looks.axes.values()] == [list(X), list(VX)]
    for name in COORDINATES:
        edges = (0, 0.25, 1)
        assert PhaseSpace(**{name: edges}, time=0).axes[name].tolist() == list(edges)
    assert list(PhaseSpace(mu=2, speed=(0, 1), time=0).axes) == ["speed", "mu"]
    assert list(COORDINATES) == ["x", "y", "z", "vx", "vy", "vz", "speed", "mu"]


def test_a_number_of_cosines_covers_all_directions():
    assert PhaseSpace(mu=4, time=0).axes["mu"].tolist() == [-1, -0.5, 0, 0.5, 1]
    assert PhaseSpace(mu=(0, math.nextafter(1, 2)), time=0).axes["mu"].tolist() == [0, 1]


@pytest.mark.parametrize(
    ("time", "times", "is_series"),
    [
        (2, (2.0,), False),
        (np.float32(0.5), (0.5,), False),
        (np.array(1), (1.0,), False),
        ([2], (2.0,), True),
        (np.linspace(0, 1, 3), (0.0, 0.5, 1.0), True),
    ],
)
def test_one_time_and_a_series_of_one_time_are_told_apart(time, times, is_series):
    looks = PhaseSpace(x=X, time=time)
    assert (looks.times, looks.is_series) == (times, is_series)
    assert all(type(t) is float for t in looks.times) and hash(looks) is not None


def test_bins_of_phase_space_are_counted_over_all_times():
    edges, times = np.arange(1001), np.arange(10)
    assert len(PhaseSpace(x=edges, vx=edges, time=times).times) == 10  # ten million in all
    with pytest.raises(SceneError, match=r"x x vx x time .* got 11000000,"):
        PhaseSpace(x=edges, vx=edges, time=np.arange(11))


def test_a_snapshot_takes_floats_that_are_whole():
    looks = Snapshot(1, particles=1e5)
    assert (looks.time, looks.times, looks.particles, looks.name) == (1.0, (1.0,), 100_000, "snapshot")
    assert type(looks.particles) is int and looks == Snapshot(time=1.0)


def test_a_scene_sorts_what_looks():
    parts = [Snapshot(0.5), meter(), PhaseSpace(x=X, time=(0, 1)), Detector("floor"), Snapshot(1, name="end")]
    scene = Scene(LAMP, WALL, parts, duration=1)
    assert scene.detectors == tuple(parts)
    assert scene.meters == (parts[1], parts[3])
    assert scene.phase_spaces == (parts[2],)
    assert scene.snapshots == (parts[0], parts[4])
    assert Scene(LAMP, detectors=parts[2], duration=1).detectors == (parts[2],)
    assert Scene(LAMP).meters == Scene(LAMP).phase_spaces == Scene(LAMP).snapshots == ()


def test_a_look_may_happen_at_both_ends_of_the_clock_but_for_rounding():
    Scene(LAMP, detectors=[Snapshot(0), PhaseSpace(x=X, time=(0, 3))], duration=3)
    Scene(LAMP, detectors=Snapshot(3 * 0.1), duration=0.3)
    with pytest.raises(SceneError, match=r"Snapshot 'snapshot': time must be within .* 3.0 s, got 3.00"):
        Scene(LAMP, detectors=Snapshot(3 * (1 + 1e-15)), duration=3)


def test_particles_may_come_via_a_surface_another_detector_or_the_detector_itself():
    ring = Detector(BALL, name="ring", via=("floor", "meter", "ring"))
    assert Scene(LAMP, WALL, [meter(via="ring"), ring]).visited == ("ring", "floor", "meter")
    assert Scene(LAMP, WALL, Detector("floor", via="floor")).visited == ("floor",)
    assert Scene(LAMP, WALL, Detector("floor")).visited == ()
    for looks in (PhaseSpace(x=X, time=0, name="cloud"), Snapshot(0, name="cloud")):
        with pytest.raises(SceneError, match=r"Detector 'meter': via must name .* got 'cloud'"):
            Scene(LAMP, WALL, [meter(via="cloud"), looks], duration=1)


GLASS, THERMAL = Transparent(), Diffuse(1.0)


@pytest.mark.parametrize(
    ("material", "is_endless"),
    [
        (Mirror(), True),
        (Mixture({Mirror(): 0.5, THERMAL: 0.5}), True),
        (Mixture({Mirror(): 1.0, Black(): 0.0}), True),
        (Mixture({Mirror(): 0.9, Black(): 0.1}), False),
        (Mixture({Mirror(0.5): 0.9, THERMAL: 0.1}), False),
        (Mixture({Mirror(): 0.9, GLASS: 0.1}), False),
        (Mixture({Mirror(): 1.0, GLASS: 0.0}), True),
    ],
)
def test_light_ends_where_any_share_of_a_wall_absorbs_it_or_lets_it_through(material, is_endless):
    lamp, wall = Source(CUBE, Isotropic(power=1)), Surface(BALL, material)
    Scene(lamp, wall, duration=1)
    if not is_endless:
        Scene(lamp, wall)
        return
    with pytest.raises(SceneError, match="nothing absorbs inside"):
        Scene(lamp, wall)


@pytest.mark.parametrize("pane", [GLASS, Mixture({GLASS: 0.5, THERMAL: 0.5})])
def test_a_pane_that_absorbs_nothing_does_not_end_light_within_mirrors(pane):
    lamp, mirrors = Source(Point(), Isotropic(power=1)), Surface(BALL, Mirror())
    Scene(lamp, [mirrors, Surface(Box(size=1), Diffuse(0.9))])
    with pytest.raises(SceneError, match="nothing absorbs inside"):
        Scene(lamp, [mirrors, Surface(Box(size=1), pane)])


def test_a_gas_needs_a_clock_and_light_does_not():
    gas = Source(CUBE, Gas(1e20, 500))
    assert Scene(gas, duration=1).duration == 1
    with pytest.raises(SceneError, match=r"duration must be given with a Gas.* write duration="):
        Scene(gas)
    assert Scene(Source(DISK, Beam((0, 0, 1), power=1))).duration is None


def test_moments_take_more_memory_so_that_fewer_bins_are_allowed():
    x = tuple(range(2001))
    PhaseSpace(x=x, vx=x, time=0)
    with pytest.raises(
        SceneError, match="must be 1250000 bins with moments or path lengths at most, got 4000000"
    ):
        PhaseSpace(x=x, vx=x, time=0, moments=True)


def test_a_thermal_wall_of_another_mass_than_the_gas_is_refused():
    air, hydrogen = (tp.Maxwellian(temperature=300, mass=mass) for mass in (4.8e-26, 3.3e-27))
    cube = tp.Box(size=1)
    wall = tp.Surface(cube, tp.Diffuse(1.0, speed=hydrogen), "wall")
    with pytest.raises(
        SceneError, match=r"'wall': its Maxwellian is of particles of 3\.3e-27 kg, got 4\.8e-26 kg"
    ):
        Scene(tp.Source(cube, tp.Gas(1e10, air)), wall, duration=1)
    with pytest.raises(SceneError, match="'wall': a wall with a speed needs a scene of particles, got watts"):
        Scene(tp.Source(cube, tp.Isotropic(power=1)), wall)
