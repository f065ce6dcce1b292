"""A triangle: area, normal and frame from its vertices, also where these nearly lie on a line."""

import math
from itertools import permutations

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.agreement import assert_agrees
from transport.geometry.flat import Disk, Rectangle, Triangle
from transport.geometry.relations import are_on_one_support
from transport.geometry.shape import Point
from transport.geometry.solid import Sphere
from transport.scene.bins import Directions, Positions
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Gas, Isotropic, Lambertian
from transport.scene.materials import Black, Diffuse, Mirror, Surface, Transparent
from transport.scene.scene import Scene
from transport.scene.sheets import scene_sheets
from transport.scene.sources import Source
from transport.simulate import simulate
from transport.validation import SceneError

HALF_SQUARE = Triangle(vertices=((0, 0, 0), (2, 0, 0), (0, 2, 0)))
SLOPED = Triangle(vertices=((1, 0.2, 1.5), (-0.7, 1.1, 2.0), (0.3, -1.3, 0.8)))
LAMP = Source(Disk(radius=1), Lambertian(power=1))

numbers = st.floats(-1, 1)
points = st.tuples(numbers, numbers, numbers)


def exact_area(vertices):
    """Half the vector product, in 60 digits."""
    with mpmath.workdps(60):
        a, b, c = (mpmath.matrix(vertex) for vertex in vertices)
        u, v = b - a, c - a
        cross = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        return mpmath.sqrt(sum(x * x for x in cross)) / 2


def test_half_a_square():
    shape = HALF_SQUARE
    assert (shape.area, shape.normal) == (2.0, (0.0, 0.0, 1.0))
    assert shape.frame == ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    assert shape.center == shape.middle == pytest.approx((2 / 3, 2 / 3, 0), rel=1e-15)
    assert shape.bounds == ((0, 0, 0), (2, 2, 0)) and not shape.is_closed
    assert shape.extent == pytest.approx(math.hypot(4 / 3, 2 / 3), rel=1e-15)
    assert shape.projected_area((0, 0.6, -0.8)) == pytest.approx(1.6, rel=1e-15)
    assert np.array(shape.corners) == pytest.approx(np.array([(-2, -2), (4, -2), (-2, 4)]) / 3, rel=1e-15)


def test_the_normal_follows_the_order_of_the_vertices_by_the_right_hand():
    a, b, c = HALF_SQUARE.vertices
    for turned, sign in [((a, b, c), 1), ((b, c, a), 1), ((c, a, b), 1), ((b, a, c), -1), ((a, c, b), -1)]:
        assert Triangle(vertices=turned).normal == (0, 0, sign)


def test_e_u_runs_along_the_first_edge():
    for vertices in permutations(SLOPED.vertices):
        shape = Triangle(vertices=vertices)
        frame = np.array(shape.frame)
        edge = np.subtract(vertices[1], vertices[0])
        assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-15)
        assert frame[0] == pytest.approx(edge / np.linalg.norm(edge), abs=1e-15)
        assert frame[1] == pytest.approx(np.cross(frame[2], frame[0]), abs=1e-15)
        assert tuple(frame[2]) == shape.normal


@given(points, points, points)
def test_corners_lie_in_the_frame_and_turn_to_the_left(a, b, c):
    try:
        shape = Triangle(vertices=(a, b, c))
    except SceneError:
        assume(False)
    (p, s), (q, t), (m, n) = shape.corners
    assert [p + q + m, s + t + n] == pytest.approx([0, 0], abs=1e-15)
    e_u, e_v, _ = np.array(shape.frame)
    for vertex, (u, v) in zip(shape.vertices, shape.corners, strict=True):
        assert np.array(shape.center) + u * e_u + v * e_v == pytest.approx(np.array(vertex), abs=1e-14)
        assert math.hypot(u, v) <= shape.extent * (1 + 1e-14)
    if shape.area > 1e-9:
        assert (q - p) * (n - s) - (t - s) * (m - p) == pytest.approx(2 * shape.area, rel=1e-6, abs=0)


@given(points, points, points, st.integers(-300, 300))
def test_area_is_exact_at_any_scale_and_refused_where_it_leaves_the_range_of_doubles(a, b, c, exponent):
    vertices = [tuple(math.ldexp(x, exponent) for x in vertex) for vertex in (a, b, c)]
    try:
        shape = Triangle(vertices=vertices)
    except SceneError:
        assume(False)
    assume(shape.area > 1e-300)
    assert shape.area == pytest.approx(float(exact_area(vertices)), rel=1e-15, abs=0)


def sliver_of(height, middle):
    """An edge of length 1 across the axes, and a vertex at a height over a point of its line."""
    a, b, c = np.array([1.0, 0.1, 0.2]), np.array([0.3, 1.0, 0.7]), np.array([0.4, -0.2, 0.5])
    b /= np.linalg.norm(b)
    return Triangle(vertices=(a, a + b, a + middle * b + height * np.cross(b, c)))


@pytest.mark.parametrize("height", [1e-3, 1e-6, 1e-9, 1e-12, 3e-15])
@pytest.mark.parametrize("middle", [0.0, 0.3, 1.0])
def test_slivers_keep_all_their_digits(height, middle):
    shape = sliver_of(height, middle)
    assert shape.area == pytest.approx(float(exact_area(shape.vertices)), rel=1e-15, abs=0)
    for vertex in shape.vertices:  # the plane goes through the vertices
        assert np.dot(np.subtract(vertex, shape.vertices[0]), shape.normal) == pytest.approx(0, abs=2.5e-16)
    frame = np.array(shape.frame)
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-15)


def test_the_usual_formulas_lose_the_digits_that_slivers_keep():
    """Planted: a vector product in floating point, and Heron's formula."""
    shape = sliver_of(1e-9, 0.3)
    a, b, c = np.array(shape.vertices)
    plain = np.linalg.norm(np.cross(b - a, c - a)) / 2
    sides = [np.linalg.norm(side) for side in (b - a, c - b, a - c)]
    half = sum(sides) / 2
    heron = math.sqrt(max(half * math.prod(half - side for side in sides), 0.0))
    for wrong in (plain, heron):
        assert shape.area != pytest.approx(wrong, rel=1e-9, abs=0)


@pytest.mark.parametrize("way", [(1, 2, 3), (0.1, 0.2, 0.3), (1e-9, 1, 0), (-0.7, 0.11, 1e5)])
def test_vertices_on_a_line_are_refused_though_rounding_lifts_them_off_it(way):
    for steps in [(0, 0, 0), (0, 0, 1), (0, 1, 3), (0.1, 0.3, 0.7), (-1, 2 / 3, 5)]:
        for scale in (1e-30, 1, 1e30):
            vertices = [[scale * step * x for x in way] for step in steps]
            with pytest.raises(SceneError, match="must not lie on one line"):
                Triangle(vertices=vertices)


@pytest.mark.parametrize(
    ("point", "distance"),
    [
        ((0.5, 0.5, 0), 0),
        ((0.5, 0.5, -3), 3),
        ((1, 1, 0), 0),
        ((3, 0, 0), 1),
        ((-3, -4, 0), 5),
        ((1, -2, 0), 2),
        ((2, 2, 0), math.sqrt(2)),
        ((2, 2, 1), math.sqrt(3)),
        ((0, 5, 4), 5),
    ],
)
def test_least_distance_to_a_triangle(point, distance):
    for vertices in permutations(HALF_SQUARE.vertices):
        shape = Triangle(vertices=vertices)
        assert shape.distance(point) == pytest.approx(distance, rel=1e-15, abs=1e-15)


@given(points, points)
def test_no_point_of_a_triangle_is_nearer_than_the_least_distance(weights, place):
    shares = np.abs(weights)
    assume(shares.sum() > 1e-3)
    point = shares / shares.sum() @ np.array(SLOPED.vertices)
    assert SLOPED.distance(place) <= math.dist(point, place) + 1e-15


def test_triangles_share_the_sheet_of_the_plane_that_they_lie_on():
    floor = Rectangle(center=(0.1, 0.2, 0.3), normal=(1, 2, 3), width=3, height=3)
    e_u, e_v, normal = np.array(floor.frame)

    def lying(*corners, lifted=0.0):
        flat = [np.array(floor.center) + u * e_u + v * e_v + lifted * normal for u, v in corners]
        return Triangle(vertices=flat)

    near, far = lying((0, 0), (1, 0.1), (0.2, 0.7)), lying((-1, 0.3), (-0.4, 1), (-0.9, -0.9))
    sliver = lying((-1.1, -0.7), (1.2, 0.9), (0.3, 0.9 * (1 + 1e-12) - 0.9 * 1.6 / 2.3))
    for shape in (near, far, sliver):
        assert are_on_one_support(shape, floor) and are_on_one_support(floor, shape)
    assert are_on_one_support(near, far) and are_on_one_support(near, sliver)
    lifted = lying((0, 0), (1, 0.1), (0.2, 0.7), lifted=1e-13)
    for other in (floor, near, far, Sphere(radius=1)):
        assert not are_on_one_support(lifted, other) and not are_on_one_support(other, lifted)
    tilted = Triangle(vertices=(*near.vertices[:2], lifted.vertices[2]))
    assert not are_on_one_support(tilted, floor)


def thin_sliver(wall, height):
    """A sliver on a wall, whose own normal rounding of the vertices turns."""
    e_u, e_v, normal = np.array(wall.frame)
    corners = ((-1, -0.5), (1, 0.7), (0.1, 0.16 + height))
    sliver = Triangle(vertices=[np.array(wall.center) + u * e_u + v * e_v for u, v in corners])
    assert np.abs(np.subtract(sliver.normal, normal)).max() > 1e-6
    return sliver


@pytest.mark.parametrize("height", [1e-12, 1e-13, 3e-14])
def test_a_thin_sliver_on_a_wall_stands_on_the_wall_and_takes_its_plane(height):
    disk = Disk(center=(0.1, 0.2, 0.3), normal=(1, 2, 3), radius=2)
    sliver = thin_sliver(Rectangle(center=disk.center, normal=disk.normal, width=3, height=3), height)
    assert are_on_one_support(sliver, disk)
    meters = [Detector(sliver, name="sliver"), Detector(disk, name="disk")]
    for scene in (Scene(LAMP, (), meters), Scene(LAMP, Surface(disk, Black()), meters[0])):
        (sheet,) = scene_sheets(scene)
        assert sheet.support is disk and [m.shape for m in sheet.members] == [disk, sliver]


def test_a_detector_and_an_aim_take_a_triangle():
    meter = Detector(SLOPED, name="meter", side="back", directions=Directions(mu=4, phi=3))
    lamp = Source(Point(), Isotropic(power=1), aim=SLOPED)
    scene = Scene(lamp, Surface(Disk(radius=9, center=(0, 0, -1)), Black()), meter)
    assert scene.shape_of(meter) is SLOPED and SLOPED.pieces() == (SLOPED,)
    assert [len(sheet.members) for sheet in scene_sheets(scene)] == [1, 1]


def test_a_flat_source_does_not_aim_at_a_triangle_in_its_plane():
    with pytest.raises(SceneError, match="aim must not lie in the source's own plane"):
        Scene(Source(Disk(radius=1, center=(5, 0, 0)), Lambertian(power=1), aim=HALF_SQUARE))


@pytest.mark.parametrize("material", [Black(), Diffuse(1.0), Mirror(), Transparent()])
def test_a_surface_of_a_triangle_is_a_sheet_that_acts_and_may_emit(material):
    sail = Surface(SLOPED, material, name="sail")
    scene = Scene(Source("sail", Lambertian(power=1)), sail, Detector("sail"))
    [sheet] = scene_sheets(scene)
    assert sheet.support == SLOPED and len(sheet.members) == 1
    assert (sheet.members[0].surface is sail) == (not isinstance(material, Transparent))


def test_only_surface_emissions_leave_from_a_triangle():
    assert Source(SLOPED, Lambertian(exitance=2)).amount(SLOPED, None) == 2 * SLOPED.area
    beam = Source(SLOPED, Beam(SLOPED.normal, irradiance=2))
    assert beam.amount(SLOPED, None) == pytest.approx(2 * SLOPED.area, rel=1e-15)
    for emission in (Isotropic(power=1), Gas(density=1, speed=1)):
        with pytest.raises(SceneError, match=r"Source: .* leaves from a .* got shape=Triangle"):
            Source(SLOPED, emission)


def test_positions_on_a_triangle_are_refused():
    with pytest.raises(
        SceneError, match=r"Detector 'meter': .* Triangle has no coordinates.*; put a Detector on a Rect"
    ):
        Detector(SLOPED, name="meter", positions=Positions(u=2))


@pytest.mark.parametrize("source", [Disk(radius=0.5), Rectangle(width=1.0, height=0.7)])
@pytest.mark.parametrize("aimed", [False, True])
def test_a_triangle_on_the_plane_of_a_source_counts_its_share_of_what_is_born(source, aimed):
    """What is born on a meter leaves it: the share of the areas, counted at birth; also where only a `via` asks for it."""
    shape = Triangle(vertices=((-0.1, -0.1, 0), (0.1, -0.1, 0), (0, 0.1, 0)))
    far = Sphere(center=(0, 0, 3), radius=2.0)
    lamp = Source(source, Lambertian(power=1), aim=far if aimed else None)
    looks = [Detector(shape, name="own"), Detector(far, name="far"), Detector(far, name="of it", via="own")]
    result = simulate(Scene(lamp, (), looks), particles=100_000, seed=1, progress=False)
    share = shape.area / source.area
    assert result["own"].number_of("weight in") == 0
    if aimed:
        assert result["own"].flux_out.error < 0.05 * share
    else:
        assert_agrees(result["own"].flux_out, share, 1e-6)
        with pytest.raises(AssertionError):
            assert_agrees(result["own"].flux_out, 1.2 * share, 1e-6)
    assert 0.8 * share < result["of it"].flux_in.value / result["far"].flux_in.value < 1.25 * share
