"""The user's objects: what they accept, what they store and what they answer."""

import dataclasses
import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from transport.geometry.flat import Disk, Rectangle, Triangle
from transport.geometry.shape import Point
from transport.geometry.solid import Box, Sphere
from transport.scene.bins import DirectionCone, Directions, Positions
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Gas, Isotropic, Lambertian
from transport.scene.materials import Black, Diffuse, Mirror, Surface, Transparent
from transport.scene.phase_space import PhaseSpace, Snapshot
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.validation import SceneError

DISK, BALL, CUBE = Disk(radius=1), Sphere(radius=2), Box(size=(1, 2, 3))
SHEET = Rectangle(width=2, height=4)
LAMP = Source(DISK, Lambertian(power=1))
GAS = Source(CUBE, Gas(1e20, 500))
WALL = Surface(DISK, Black(), name="floor")

EVERY_OBJECT = [
    DISK,
    BALL,
    CUBE,
    SHEET,
    Point(),
    Black(),
    Diffuse(0.5),
    Mirror(),
    Transparent(),
    WALL,
    LAMP,
    GAS,
    Source("floor", Beam((1, 2, 3), irradiance=2), side="back"),
    Detector(DISK, name="meter", directions=Directions(mu=[0, 0.5, 1], phi=4), positions=Positions(u=3)),
    Detector("floor", directions=Directions.cone((0, 1, 1), 0.1)),
    Scene(LAMP, WALL, Detector("floor"), duration=2),
    Triangle(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 0.5))),
    Detector(DISK, name="gate", times=3, speeds=(0, 1, 10), via=("lid", "gate"), events=(1, 2), moments=True),
    PhaseSpace(x=(-1, 0, 1), mu=4, time=(0, 0.5), within=CUBE, moments=True),
    Snapshot(1, particles=10),
    Scene(LAMP, WALL, [Snapshot(1), Detector("floor"), PhaseSpace(vz=(0, 1), time=2)], duration=2),
]


@pytest.mark.parametrize("thing", EVERY_OBJECT, ids=lambda thing: type(thing).__name__)
def test_objects_are_frozen_hashable_and_survive_copies(thing):
    for twin in (
        dataclasses.replace(thing),
        pickle.loads(pickle.dumps(thing)),
        eval(repr(thing)),
    ):
        assert twin == thing and hash(twin) == hash(thing)
    with pytest.raises(dataclasses.FrozenInstanceError):
        thing.colour = "red"


def test_lists_arrays_and_integers_give_the_same_object():
    plain = Disk(center=(1.0, 2.0, 3.0), normal=(0.0, 0.0, 1.0), radius=2.0)
    for array in (
        np.array,
        list,
        lambda v: np.array(v, dtype=np.float32),
        lambda v: np.array(v, dtype=np.int8),
    ):
        same = Disk(center=array([1, 2, 3]), normal=array([0, 0, 7]), radius=np.array(2), up=None)
        assert same == plain and hash(same) == hash(plain)
        assert all(type(number) is float for number in (*same.center, *same.normal, same.radius))
    assert Box(size=np.int64(2)) == Box(size=[2, 2, 2])
    assert Directions(mu=np.int32(3)) == Directions(mu=3)
    assert Directions(mu=np.array([0, 1])) == Directions(mu=(0.0, 1.0))
    assert repr(Disk(center=(-0.0, 0, 0), radius=1)) == repr(DISK)


components = st.floats(-1, 1)
directions = st.tuples(components, components, components).filter(lambda v: math.hypot(*v) > 1e-3)


@given(directions, st.floats(-290, 290))
def test_directions_are_unit_vectors_at_any_scale(vector, exponent):
    scale = 10.0**exponent
    normal = Disk(radius=1, normal=tuple(scale * c for c in vector)).normal
    length = math.hypot(*vector)
    assert math.hypot(*normal) == pytest.approx(1, abs=4.5e-16)
    assert normal == pytest.approx([c / length for c in vector], abs=1e-15)
    assert Disk(radius=1, normal=normal).normal == normal


@pytest.mark.parametrize("scale", [5e-324, 1e-300, 1e300])
def test_directions_at_the_ends_of_the_range(scale):
    assert Disk(radius=1, normal=(scale, 0, 0)).normal == (1.0, 0.0, 0.0)
    assert Disk(radius=1, normal=(scale, -scale, 0)).normal == pytest.approx(
        (0.5**0.5, -(0.5**0.5), 0), abs=2e-16
    )


def assert_right_handed(frame):
    assert np.array(frame) @ np.array(frame).T == pytest.approx(np.eye(3), abs=1e-15)
    assert np.cross(frame[0], frame[1]) == pytest.approx(np.array(frame[2]), abs=1e-15)


@given(directions, directions)
def test_frames_are_orthonormal_and_right_handed(normal, up):
    assert_right_handed(Sphere(radius=1, axis=normal).frame)
    try:
        disk = Disk(radius=1, normal=normal, up=up)
    except SceneError:
        return
    assert_right_handed(disk.frame)
    across = np.cross(disk.up, disk.normal)  # no component along e_v, and e_u on the right side
    assert np.dot(across, disk.frame[1]) == pytest.approx(0, abs=1e-15)
    assert np.dot(across, disk.frame[0]) > 0


def test_an_up_that_is_almost_along_the_normal_still_gives_an_orthonormal_frame():
    assert_right_handed(Disk(radius=1, normal=(1, 2, 3), up=(1, 2, 3 + 1e-4)).frame)


def test_default_frames():
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    assert Disk(radius=1).frame == (x, y, z)
    assert Rectangle(width=1, height=1, normal=y).frame == ((-1.0, 0.0, 0.0), z, y)
    assert Rectangle(width=1, height=1, normal=x, up=z).frame == (y, z, x)


@pytest.mark.parametrize("noise", [1e-16, -6e-8, 1e-300])
def test_rounding_of_a_normal_along_y_does_not_turn_its_frame(noise):
    for sign in (1, -1):
        clean = np.array(Disk(radius=1, normal=(0, sign, 0)).frame)
        noisy = np.array(Disk(radius=1, normal=(noise, sign, noise)).frame)
        assert noisy == pytest.approx(clean, abs=2e-7)


def sampled_points(shape, count=2000):
    """Points of a flat shape's rim, for its bounds."""
    e_u, e_v, _ = np.array(shape.frame)
    if isinstance(shape, Rectangle):
        u, v = np.array([(i, j) for i in (-1, 1) for j in (-1, 1)]).T * [
            [shape.width / 2],
            [shape.height / 2],
        ]
    else:
        angle = np.linspace(0, 2 * np.pi, count)
        u, v = shape.radius * np.cos(angle), shape.radius * np.sin(angle)
    return np.array(shape.center) + np.outer(u, e_u) + np.outer(v, e_v)


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, -1, 0), (1, 2, -3), (1, 0, 1)])
def test_bounds_are_tight(normal):
    disk = Disk(center=(1, 2, 3), normal=normal, radius=2, inner_radius=1)
    rectangle = Rectangle(center=(1, 2, 3), normal=normal, width=2, height=5, up=(1, 1, 0))
    for shape in (disk, rectangle):
        points = sampled_points(shape)
        lower, upper = shape.bounds
        assert lower == pytest.approx(points.min(axis=0), abs=1e-5)
        assert upper == pytest.approx(points.max(axis=0), abs=1e-5)
        assert np.linalg.norm(points - shape.middle, axis=1).max() == pytest.approx(shape.extent)


def test_sizes():
    assert SHEET.area == 8 and SHEET.extent == math.hypot(1, 2) and not SHEET.is_closed
    ring = Disk(radius=1, inner_radius=1 - 2**-40)
    assert ring.area == pytest.approx(math.pi * (2**-39 - 2**-80), rel=1e-15)
    assert BALL.area == pytest.approx(16 * math.pi) and BALL.volume == pytest.approx(32 * math.pi / 3)
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


PI = math.pi
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


@pytest.mark.parametrize("shape, emission, side, power", POWERS)
def test_power_of_a_source(shape, emission, side, power):
    source = Source(shape, emission, side=side)
    assert source.amount(shape, None) == pytest.approx(power, rel=1e-14)
    assert source.is_back == (side in ("back", "inside"))


def test_a_speed_left_out_is_that_of_light():
    assert Lambertian(power=1).speed == 299_792_458.0
    assert Isotropic(power=1, speed=5).speed == 5.0


def test_direction_edges():
    edges = Directions(mu=2, phi=4).edges()
    assert list(edges) == ["mu", "phi"]
    assert edges["mu"].tolist() == [0, 0.5, 1] and edges["phi"].tolist() == [
        0,
        PI / 2,
        PI,
        3 * PI / 2,
        2 * PI,
    ]
    assert Directions(theta=3).edges()["theta"] == pytest.approx([0, PI / 6, PI / 3, PI / 2], rel=1e-15)
    assert Directions(mu=2, frame="world").edges()["mu"].tolist() == [-1, 0, 1]
    assert Directions(theta=2, frame="world").edges()["theta"].tolist() == [0, PI / 2, PI]
    assert Directions(phi=(0, math.nextafter(2 * PI, 7))).edges()["phi"][-1] == 2 * PI  # rounding is forgiven
    assert Directions(phi=(-PI / 4, PI / 4)).edges()["phi"].tolist() == [-PI / 4, PI / 4]  # across phi = 0
    assert Directions(phi=(-2 * PI, 0), frame="world").edges()["phi"].tolist() == [-2 * PI, 0]
    turned = np.linspace(-PI / 4, 7 * PI / 4, 33)
    assert Directions(phi=turned).edges()["phi"].tolist() == turned.tolist()
    assert Directions.cone(half_angle=1, axis=(0, 0, 2)) == Directions.cone((0, 0, 1), 1)
    cone = Directions.cone((0, 0, 5), PI / 2)
    assert isinstance(cone, DirectionCone)
    assert cone.axis == (0, 0, 1) and cone.edges()["theta"].tolist() == [0, PI / 2]


RING = Disk(radius=2, inner_radius=1)


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


def test_areas_of_position_bins_are_exact():
    assert Positions(u=(-0.5, 0, 1), v=(1, 2)).areas(SHEET).tolist() == [[0.5], [1.0]]
    assert Positions(u=2, v=(0, 1)).areas(RING)[:, 0] == pytest.approx([0.625, 0.875], rel=1e-15)
    assert Positions(u=2).areas(BALL) == pytest.approx([8 * PI, 8 * PI], rel=1e-15)


def test_areas_of_tiny_position_bins_do_not_cancel():
    step = 2.0**-40
    cap, belt = Positions(u=(0, step, 1, 1 + step)).areas(Sphere(radius=1))[[0, 2]]
    assert cap == pytest.approx(PI * step**2, rel=1e-14)
    assert belt == pytest.approx(2 * PI * step * math.sin(1 + step / 2), rel=1e-14)
    assert Positions(u=(1, 1 + step)).areas(RING)[0] == pytest.approx(
        2 * PI * step * (1 + step / 2), rel=1e-15
    )


def test_a_scene_takes_single_objects_lists_and_generators():
    meter = Detector("floor")
    scene = Scene(LAMP, WALL, meter)
    assert scene == Scene([LAMP], [WALL], [meter]) == Scene(iter([LAMP]), (WALL,), (m for m in [meter]))
    assert (scene.sources, scene.surfaces, scene.detectors) == ((LAMP,), (WALL,), (meter,))
    assert Scene(LAMP).surfaces == () and Scene(LAMP).duration is None


def test_a_scene_resolves_names():
    meter, own = Detector("floor"), Detector(BALL, name="ball")
    lamp = Source("floor", Lambertian(radiance=2), side="back")
    scene = Scene(lamp, WALL, [meter, own])
    assert meter.name == "floor"
    assert [scene.shape_of(user) for user in (lamp, meter, own)] == [DISK, DISK, BALL]
    assert scene.surface("floor") is WALL
    assert lamp.amount(scene.shape_of(lamp), None) == pytest.approx(2 * PI**2)
    assert scene.measured_in == "watts" and Scene(GAS, duration=1).measured_in == "particles"
