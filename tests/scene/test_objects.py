"""The user's objects: what they accept, what they store and what they answer; and what a scene makes of them."""

import dataclasses
import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import transport as tp
from tests.refusals import assert_refused
from transport.geometry.flat import Disk, Plane, Rectangle, Slab, Triangle
from transport.geometry.revolved import Cone, Cylinder, Paraboloid
from transport.geometry.shape import Cloud, Point
from transport.geometry.solid import Box, Sphere
from transport.scene.bins import DirectionCone, Directions, Positions
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Gas, Isotropic, Lambertian
from transport.scene.materials import Black, Diffuse, Mirror, Mixture, Surface, Transparent
from transport.scene.phase_space import COORDINATES, PhaseSpace, Snapshot
from transport.scene.scene import Scene
from transport.scene.sources import Source

PI = math.pi
DISK, BALL, CUBE = Disk(radius=1), Sphere(radius=2), Box(size=(1, 2, 3))
SHEET, RING = Rectangle(width=2, height=4), Disk(radius=2, inner_radius=1)
LAMP, GAS = Source(DISK, Lambertian(power=1)), Source(CUBE, Gas(1e20, 500))
WALL = Surface(DISK, Black(), name="floor")
MAXWELLIAN, TABLE = tp.Maxwellian(temperature=300, mass=4.65e-26), tp.SpeedTable((0, 2), (1, 1))
X, VX = (-1.0, 0.0, 2.0), (-5.0, 5.0)
EVERY_OBJECT = [
    DISK, BALL, CUBE, SHEET, Point(), Cloud(sigma=1), Triangle(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 0.5))),
    Cylinder(radius=1, height=2), Cone(radius=1, top_radius=0.25, height=2), Sphere(radius=2, mu_min=0.5),
    Paraboloid(focal_length=0.5, radius=1, inner_radius=0.25), Plane(center=(1, 2, 3)), Slab(thickness=0.5),
    Rectangle(width=2, height=1, hole=Disk(center=(0.4, 0, 0), radius=0.25)),
    Black(), Diffuse(0.5), Mirror(), Transparent(), WALL, LAMP, GAS,
    Source("floor", Beam((1, 2, 3), irradiance=2), side="back"),
    MAXWELLIAN, TABLE, tp.Instant(1), tp.BoxPulse(0, 1), tp.GaussianPulse(9, 1), Cloud(sigma=(0, 1, 2)),
    tp.Effusive(1e20, tp.Maxwellian(sigma=3, drift=(1, 2, 3))), Diffuse(1.0, speed=MAXWELLIAN),
    Gas(number=5, speed=TABLE, direction=(1, 1, 1), mass=1e-26),
    Surface(DISK, Mixture({Mirror(): 0.25, Diffuse(1.0, speed=MAXWELLIAN): 0.75}), name="wall"),
    Mixture({Mirror(): 0.25, Diffuse(0.5): 0.5, Black(): 0.125, Transparent(): 0.125}),
    Source(Point(), Isotropic(energy=1), pulse=tp.Instant()),
    Detector(DISK, name="meter", directions=Directions(mu=[0, 0.5, 1], phi=4), positions=Positions(u=3)),
    Detector("floor", directions=Directions.cone((0, 1, 1), 0.1)),
    Detector(DISK, name="gate", times=3, speeds=(0, 1, 10), via=("lid", "gate"), events=(1, 2), moments=True),
    PhaseSpace(x=(-1, 0, 1), mu=4, time=(0, 0.5), within=CUBE, moments=True), Snapshot(1, particles=10),
    Scene(LAMP, WALL, Detector("floor"), duration=2),
    Scene(LAMP, WALL, [Snapshot(1), Detector("floor"), PhaseSpace(vz=(0, 1), time=2)], duration=2),
]  # fmt: skip


@pytest.mark.parametrize("thing", EVERY_OBJECT, ids=lambda thing: type(thing).__name__)
def test_objects_are_frozen_hashable_and_survive_copies(thing):
    for twin in (
        dataclasses.replace(thing),
        pickle.loads(pickle.dumps(thing)),
        eval(repr(thing), vars(tp) | globals()),
    ):
        assert twin == thing and hash(twin) == hash(thing)
    with pytest.raises(dataclasses.FrozenInstanceError):
        thing.colour = "red"


def meter(**how):
    return Detector(DISK, name="meter", **how)


def test_lists_arrays_and_integers_give_the_same_object():
    plain = Disk(center=(1.0, 2.0, 3.0), normal=(0.0, 0.0, 1.0), radius=2.0)
    for kind in (float, np.float32, np.int8, None):
        array = list if kind is None else lambda v, kind=kind: np.array(v, dtype=kind)
        same = Disk(center=array([1, 2, 3]), normal=array([0, 0, 7]), radius=np.array(2), up=None)
        assert same == plain and hash(same) == hash(plain)
        assert all(type(number) is float for number in (*same.center, *same.normal, same.radius))
    assert Box(size=np.int64(2)) == Box(size=[2, 2, 2])
    assert Directions(mu=np.int32(3)) == Directions(mu=3)
    assert Directions(mu=np.array([0, 1])) == Directions(mu=(0.0, 1.0))
    assert repr(Disk(center=(-0.0, 0, 0), radius=1)) == repr(DISK)
    plain = meter(times=(0.0, 1.0), speeds=(0.0, 2.0), via=("a",), events=(1, 2))
    same = meter(times=[0, 1], speeds=np.array([0, 2], dtype=np.int8), via="a", events=[1, np.int32(2)])
    assert same == plain and hash(same) == hash(plain)


# ---- frames, bounds, sizes ----

components = st.floats(-1, 1)
directions = st.tuples(components, components, components).filter(lambda v: math.hypot(*v) > 1e-3)


@given(directions, st.floats(-290, 290))
def test_directions_are_unit_vectors_at_any_scale(vector, exponent):
    scale, length = 10.0**exponent, math.hypot(*vector)
    normal = Disk(radius=1, normal=tuple(scale * c for c in vector)).normal
    assert math.hypot(*normal) == pytest.approx(1, abs=4.5e-16)
    assert normal == pytest.approx([c / length for c in vector], abs=1e-15)
    assert Disk(radius=1, normal=normal).normal == normal


@pytest.mark.parametrize("scale", [5e-324, 1e-300, 1e300])
def test_directions_at_the_ends_of_the_range(scale):
    assert Disk(radius=1, normal=(scale, 0, 0)).normal == (1.0, 0.0, 0.0)
    slanted = Disk(radius=1, normal=(scale, -scale, 0)).normal
    assert slanted == pytest.approx((0.5**0.5, -(0.5**0.5), 0), abs=2e-16)


def assert_right_handed(frame):
    assert np.array(frame) @ np.array(frame).T == pytest.approx(np.eye(3), abs=1e-15)
    assert np.cross(frame[0], frame[1]) == pytest.approx(np.array(frame[2]), abs=1e-15)


@given(directions, directions)
def test_frames_are_orthonormal_and_right_handed(normal, up):
    assert_right_handed(Sphere(radius=1, axis=normal).frame)
    try:
        disk = Disk(radius=1, normal=normal, up=up)
    except tp.SceneError:
        return
    assert_right_handed(disk.frame)
    across = np.cross(disk.up, disk.normal)  # no component along e_v, and e_u on the right side
    assert np.dot(across, disk.frame[1]) == pytest.approx(0, abs=1e-15)
    assert np.dot(across, disk.frame[0]) > 0


def test_default_frames_and_an_up_that_is_almost_along_the_normal():
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    assert Disk(radius=1).frame == (x, y, z)
    assert Rectangle(width=1, height=1, normal=y).frame == ((-1.0, 0.0, 0.0), z, y)
    assert Rectangle(width=1, height=1, normal=x, up=z).frame == (y, z, x)
    assert_right_handed(Disk(radius=1, normal=(1, 2, 3), up=(1, 2, 3 + 1e-4)).frame)


@pytest.mark.parametrize("noise", [1e-16, -6e-8, 1e-300])
@pytest.mark.parametrize("sign", [1, -1])
def test_rounding_of_a_normal_along_y_does_not_turn_its_frame(noise, sign):
    clean, noisy = (np.array(Disk(radius=1, normal=(n, sign, n)).frame) for n in (0, noise))
    assert noisy == pytest.approx(clean, abs=2e-7)


def rim_points(shape, count=2000):
    """Points of a flat shape's rim, for its bounds."""
    e_u, e_v, _ = np.array(shape.frame)
    angle = np.linspace(0, 2 * np.pi, count)
    if isinstance(shape, Rectangle):
        u, v = np.multiply.outer((shape.width / 2, shape.height / 2), (-1, 1))
        u, v = (each.ravel() for each in np.meshgrid(u, v))
    else:
        u, v = shape.radius * np.cos(angle), shape.radius * np.sin(angle)
    return np.array(shape.center) + np.outer(u, e_u) + np.outer(v, e_v)


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, -1, 0), (1, 2, -3), (1, 0, 1)])
def test_bounds_are_tight(normal):
    disk = Disk(center=(1, 2, 3), normal=normal, radius=2, inner_radius=1)
    rectangle = Rectangle(center=(1, 2, 3), normal=normal, width=2, height=5, up=(1, 1, 0))
    for shape in (disk, rectangle):
        points, (lower, upper) = rim_points(shape), shape.bounds
        assert lower == pytest.approx(points.min(axis=0), abs=1e-5)
        assert upper == pytest.approx(points.max(axis=0), abs=1e-5)
        assert np.linalg.norm(points - shape.middle, axis=1).max() == pytest.approx(shape.extent)


def test_sizes():
    assert SHEET.area == 8 and SHEET.extent == math.hypot(1, 2) and not SHEET.is_closed
    ring = Disk(radius=1, inner_radius=1 - 2**-40)
    assert ring.area == pytest.approx(PI * (2**-39 - 2**-80), rel=1e-15)
    assert BALL.area == pytest.approx(16 * PI) and BALL.volume == pytest.approx(32 * PI / 3)
    assert BALL.bounds == ((-2, -2, -2), (2, 2, 2)) and BALL.is_closed
    assert (CUBE.area, CUBE.volume, CUBE.extent, CUBE.is_closed) == (22, 6, math.hypot(0.5, 1, 1.5), True)
    point = Point(position=(1, 2, 3))
    assert point.middle == (1, 2, 3) and point.bounds == ((1, 2, 3), (1, 2, 3)) and not hasattr(point, "area")


def test_faces_of_a_box_look_outwards_and_cover_it():
    box = Box(center=(1, 1, 1), size=(1, 2, 3))
    faces = box.faces()
    assert list(faces) == ["-x", "+x", "-y", "+y", "-z", "+z"]
    assert sum(face.area for face in faces.values()) == box.area
    for name, face in faces.items():
        axis, outwards = "xyz".index(name[1]), 1 if name[0] == "+" else -1
        assert face.normal == tuple(float(outwards) if k == axis else 0.0 for k in range(3))
        lower, upper = map(list, box.bounds)
        (lower if outwards > 0 else upper)[axis] = box.bounds[outwards > 0][axis]
        assert face.bounds == (tuple(lower), tuple(upper))


# ---- sources ----

POWERS = [
    (DISK, Lambertian(radiance=3), "front", 3 * PI * PI),
    (CUBE, Lambertian(exitance=3), "inside", 66),
    (BALL, Lambertian(power=3), "outside", 3),
    (Point(), Isotropic(power=3), "front", 3),
    (Point(), Isotropic(intensity=3), "front", 12 * PI),
    (BALL, Isotropic(intensity=3), "front", 12 * PI),
    (Point(), Beam((1, 1, 1), power=3), "front", 3),
    (SHEET, Beam((0, 3, 4), irradiance=5), "front", 5 * 8 * 0.8),
    (SHEET, Beam((0, 3, -4), irradiance=5), "back", 5 * 8 * 0.8),
    (BALL, Beam((1, 2, 3), irradiance=5), "front", 5 * PI * 4),
    (CUBE, Beam((0, -3, 4), irradiance=5), "inside", 5 * (3 * 0.6 + 2 * 0.8)),
    (CUBE, Gas(1e20, 500), "front", 6e20),
]


@pytest.mark.parametrize(("shape", "emission", "side", "power"), POWERS)
def test_power_of_a_source(shape, emission, side, power):
    source = Source(shape, emission, side=side)
    assert source.amount(shape, None) == pytest.approx(power, rel=1e-14)
    assert source.is_back == (side in ("back", "inside"))


def test_a_speed_left_out_is_that_of_light():
    assert Lambertian(power=1).speed == 299_792_458.0
    assert Isotropic(power=1, speed=5).speed == 5.0


# ---- bins of detectors ----


@pytest.mark.parametrize(
    ("bins", "name", "edges"),
    [
        (Directions(mu=2, phi=4), "mu", [0, 0.5, 1]),
        (Directions(mu=2, phi=4), "phi", [0, PI / 2, PI, 3 * PI / 2, 2 * PI]),
        (Directions(theta=3), "theta", pytest.approx([0, PI / 6, PI / 3, PI / 2], rel=1e-15)),
        (Directions(mu=2, frame="world"), "mu", [-1, 0, 1]),
        (Directions(theta=2, frame="world"), "theta", [0, PI / 2, PI]),
        (Directions(phi=(0, math.nextafter(2 * PI, 7))), "phi", [0, 2 * PI]),  # rounding is forgiven
        (Directions(phi=(-PI / 4, PI / 4)), "phi", [-PI / 4, PI / 4]),  # across phi = 0
        (Directions(phi=(-2 * PI, 0), frame="world"), "phi", [-2 * PI, 0]),
        (
            Directions(phi=np.linspace(-PI / 4, 7 * PI / 4, 33)),
            "phi",
            np.linspace(-PI / 4, 7 * PI / 4, 33).tolist(),
        ),
        (Directions.cone((0, 0, 5), PI / 2), "theta", [0, PI / 2]),
    ],
)
def test_direction_edges(bins, name, edges):
    assert bins.edges()[name].tolist() == edges


def test_axes_of_directions_come_in_one_order_and_a_cone_has_a_unit_axis():
    assert list(Directions(phi=4, mu=2).edges()) == ["mu", "phi"]
    assert Directions.cone(half_angle=1, axis=(0, 0, 2)) == Directions.cone((0, 0, 1), 1)
    cone = Directions.cone((0, 0, 5), PI / 2)
    assert isinstance(cone, DirectionCone) and cone.axis == (0, 0, 1)


@pytest.mark.parametrize("shape", [SHEET, RING, BALL], ids=["rectangle", "disk", "sphere"])
@pytest.mark.parametrize("bins", [{"u": 3}, {"v": 4}, {"u": 3, "v": 4}], ids=["u", "v", "uv"])
def test_position_bins_share_out_the_area(shape, bins):
    positions = Positions(**bins)
    edges, areas = positions.edges(shape), positions.areas(shape)
    assert {name: len(values) - 1 for name, values in edges.items()} == bins
    assert areas.shape == tuple(bins.values())
    assert areas.sum() == pytest.approx(shape.area, rel=1e-14)
    if "v" in bins:  # bins of equal azimuth or height are alike
        assert areas == pytest.approx(areas[..., :1] * np.ones(4), rel=1e-14)


def test_areas_of_position_bins_are_exact_and_those_of_tiny_ones_do_not_cancel():
    assert Positions(u=(-0.5, 0, 1), v=(1, 2)).areas(SHEET).tolist() == [[0.5], [1.0]]
    assert Positions(u=2, v=(0, 1)).areas(RING)[:, 0] == pytest.approx([0.625, 0.875], rel=1e-15)
    assert Positions(u=2).areas(BALL) == pytest.approx([8 * PI, 8 * PI], rel=1e-15)
    step = 2.0**-40
    cap, belt = Positions(u=(0, step, 1, 1 + step)).areas(Sphere(radius=1))[[0, 2]]
    assert cap == pytest.approx(PI * step**2, rel=1e-14)
    assert belt == pytest.approx(2 * PI * step * math.sin(1 + step / 2), rel=1e-14)
    [rim] = Positions(u=(1, 1 + step)).areas(RING)
    assert rim == pytest.approx(2 * PI * step * (1 + step / 2), rel=1e-15)


def test_edges_of_time_and_speed_are_kept_and_the_last_rounding_is_forgiven():
    assert meter(times=4).time_edges(2.0).tolist() == [0, 0.5, 1, 1.5, 2]
    assert meter(times=1).time_edges(3e-9).tolist() == [0, 3e-9]
    assert meter().time_edges(2.0) is None and meter().time_edges(None) is None
    assert meter(times=(0.5, 1, 1.75)).time_edges(2.0).tolist() == [0.5, 1, 1.75]
    assert 3 * 0.1 > 0.3
    assert meter(times=[0, 0.1, 3 * 0.1]).time_edges(0.3).tolist() == [0, 0.1, 0.3]
    assert_refused(lambda: meter(times=[0, 0.3001]).time_edges(0.3), "times edges must be within [0.0, 0.3]")
    assert meter(speeds=np.array([0, 1e-6, 1e6])).speed_edges().tolist() == [0, 1e-6, 1e6]
    assert meter().speed_edges() is None


@pytest.mark.parametrize(
    ("given", "stored"),
    [(None, None), (0, (0, 0)), (np.int64(3), (3, 3)), ([1, 4], (1, 4)), ((2, math.inf), (2, math.inf))],
)
def test_events_are_stored_as_least_and_most(given, stored):
    events = meter(events=given).events
    assert events == stored
    assert events is None or all(type(n) is int or n == math.inf for n in events)


def test_via_is_stored_as_a_tuple_of_names():
    for asked, stored in (
        (None, None),
        ("pinhole", ("pinhole",)),
        (["lens", "pinhole"], ("lens", "pinhole")),
    ):
        assert meter(via=asked).via == stored


def test_bins_are_counted_over_all_axes_and_moments_take_more_memory():
    """Ten million in all."""
    axes = {"times": 10, "speeds": range(11), "positions": Positions(u=10, v=10)}
    directions, edges, x = Directions(mu=100, phi=10), np.arange(1001), tuple(range(2001))
    assert meter(**axes, directions=directions).times == 10
    assert len(PhaseSpace(x=edges, vx=edges, time=np.arange(10)).times) == 10
    PhaseSpace(x=x, vx=x, time=0)
    for words, make in {
        "times x speeds x u x v x mu x phi ... got 11000000,": lambda: meter(
            **axes | {"times": 11}, directions=directions
        ),
        "x x vx x time ... got 11000000,": lambda: PhaseSpace(x=edges, vx=edges, time=np.arange(11)),
        "must be 1250000 bins with moments or path lengths at most, got 4000000": lambda: PhaseSpace(
            x=x, vx=x, time=0, moments=True
        ),
    }.items():
        assert_refused(make, words)


# ---- phase spaces and snapshots ----


def test_axes_of_phase_space_come_in_one_order():
    looks = PhaseSpace(vx=VX, x=X, time=1)
    assert list(looks.axes) == ["x", "vx"]
    assert [edges.tolist() for edges in looks.axes.values()] == [list(X), list(VX)]
    for name in COORDINATES:
        assert PhaseSpace(**{name: (0, 0.25, 1)}, time=0).axes[name].tolist() == [0, 0.25, 1]
    assert list(PhaseSpace(mu=2, speed=(0, 1), time=0).axes) == ["speed", "mu"]
    assert list(COORDINATES) == ["x", "y", "z", "vx", "vy", "vz", "speed", "mu"]
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
def test_one_time_differs_from_a_series_of_one_time(time, times, is_series):
    looks = PhaseSpace(x=X, time=time)
    assert (looks.times, looks.is_series) == (times, is_series)
    assert all(type(t) is float for t in looks.times) and hash(looks) is not None


def test_a_snapshot_takes_floats_that_are_whole():
    looks = Snapshot(1, particles=1e5)
    assert (looks.time, looks.times, looks.particles, looks.name) == (1.0, (1.0,), 100_000, "snapshot")
    assert type(looks.particles) is int and looks == Snapshot(time=1.0)


# ---- scenes ----


def test_a_scene_takes_single_objects_lists_and_generators():
    look = Detector("floor")
    scene = Scene(LAMP, WALL, look)
    assert scene == Scene([LAMP], [WALL], [look]) == Scene(iter([LAMP]), (WALL,), (m for m in [look]))
    assert (scene.sources, scene.surfaces, scene.detectors) == ((LAMP,), (WALL,), (look,))
    assert Scene(LAMP).surfaces == () and Scene(LAMP).duration is None


def test_a_scene_resolves_names():
    look, own = Detector("floor"), Detector(BALL, name="ball")
    lamp = Source("floor", Lambertian(radiance=2), side="back")
    scene = Scene(lamp, WALL, [look, own])
    assert look.name == "floor"
    assert [scene.shape_of(user) for user in (lamp, look, own)] == [DISK, DISK, BALL]
    assert scene.surface("floor") is WALL
    assert lamp.amount(scene.shape_of(lamp), None) == pytest.approx(2 * PI**2)
    assert scene.measured_in == "watts" and Scene(GAS, duration=1).measured_in == "particles"


def test_a_scene_sorts_its_detectors():
    parts = [Snapshot(0.5), meter(), PhaseSpace(x=X, time=(0, 1)), Detector("floor"), Snapshot(1, name="end")]
    scene = Scene(LAMP, WALL, parts, duration=1)
    assert scene.detectors == tuple(parts)
    assert scene.meters == (parts[1], parts[3])
    assert scene.phase_spaces == (parts[2],)
    assert scene.snapshots == (parts[0], parts[4])
    assert Scene(LAMP, detectors=parts[2], duration=1).detectors == (parts[2],)
    assert Scene(LAMP).meters == Scene(LAMP).phase_spaces == Scene(LAMP).snapshots == ()


def test_a_snapshot_may_be_taken_at_both_ends_of_the_clock_but_for_rounding():
    Scene(LAMP, detectors=[Snapshot(0), PhaseSpace(x=X, time=(0, 3))], duration=3)
    Scene(LAMP, detectors=Snapshot(3 * 0.1), duration=0.3)
    assert Scene(GAS, duration=1).duration == 1
    assert Scene(Source(DISK, Beam((0, 0, 1), power=1))).duration is None
    words = "Snapshot 'snapshot': time must be within ... 3.0 s, got 3.00"
    assert_refused(lambda: Scene(LAMP, detectors=Snapshot(3 * (1 + 1e-15)), duration=3), words)


def test_particles_may_come_via_a_surface_another_detector_or_the_detector_itself():
    ring = Detector(BALL, name="ring", via=("floor", "meter", "ring"))
    assert Scene(LAMP, WALL, [meter(via="ring"), ring]).visited == ("ring", "floor", "meter")
    assert Scene(LAMP, WALL, Detector("floor", via="floor")).visited == ("floor",)
    assert Scene(LAMP, WALL, Detector("floor")).visited == ()
    for look in (PhaseSpace(x=X, time=0, name="cloud"), Snapshot(0, name="cloud")):
        words = "Detector 'meter': via must name ... got 'cloud'"
        assert_refused(lambda look=look: Scene(LAMP, WALL, [meter(via="cloud"), look], duration=1), words)


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
    lamp, wall = Source(Box(size=2), Isotropic(power=1)), Surface(BALL, material)
    Scene(lamp, wall, duration=1)
    if is_endless:
        assert_refused(lambda: Scene(lamp, wall), "nothing absorbs inside")
    else:
        Scene(lamp, wall)


@pytest.mark.parametrize("pane", [GLASS, Mixture({GLASS: 0.5, THERMAL: 0.5})])
def test_a_pane_that_absorbs_nothing_does_not_end_light_within_mirrors(pane):
    lamp, mirrors = Source(Point(), Isotropic(power=1)), Surface(BALL, Mirror())
    Scene(lamp, [mirrors, Surface(Box(size=1), Diffuse(0.9))])
    assert_refused(lambda: Scene(lamp, [mirrors, Surface(Box(size=1), pane)]), "nothing absorbs inside")
