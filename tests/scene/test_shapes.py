"""Shapes that are not of revolution: holes, planes, slabs, triangles; what each shape may be used for; points on shapes."""

import dataclasses
import math
from fractions import Fraction
from itertools import permutations

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.agreement import assert_agrees, assert_follows
from tests.refusals import assert_refused
from transport.compile.space import make_space
from transport.geometry.flat import Disk, Plane, Rectangle, Slab, Triangle
from transport.geometry.mesh import Mesh
from transport.geometry.relations import are_on_one_support
from transport.geometry.revolved import Cone, Cylinder, Paraboloid
from transport.geometry.shape import Point
from transport.geometry.solid import Box, Sphere
from transport.results.solid_angles import solid_angles_of
from transport.scene.bins import Directions
from transport.scene.detectors import Detector
from transport.scene.emissions import Effusive, Isotropic, Lambertian
from transport.scene.materials import Black, Diffuse, Mirror, Surface
from transport.scene.scene import Scene
from transport.scene.sheets import scene_sheets
from transport.scene.sources import Source
from transport.simulate import simulate
from transport.validation import SceneError

TUBE = Cylinder(radius=1, height=2)
CONE = Cone(radius=1, top_radius=0.25, height=2)
DISH = Paraboloid(focal_length=0.5, radius=1, inner_radius=0.25)
CAP = Sphere(radius=2, mu_min=0.5)
TENT = Triangle(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 0.5)))
CUBE = Mesh.box(size=2)
FLOOR, GLASS = Plane(center=(1, 2, 3)), Slab(thickness=0.5)
HOLE = Disk(radius=0.25)
FRAME = Rectangle(width=2, height=1, hole=Disk(center=(0.4, 0, 0), radius=0.25))
NEW = [TUBE, CONE, DISH, CAP, TENT, FLOOR, GLASS, FRAME]
DISK, POINT = Disk(radius=1), Source(Point(), Isotropic(power=1))
LAMP = Source(DISK, Lambertian(power=1))
numbers = st.floats(-1, 1)
points = st.tuples(numbers, numbers, numbers)


def name_of(thing):
    return type(thing).__name__


# ---- what they are ----


def test_which_shapes_are_closed_and_which_end():
    assert [shape.is_closed for shape in NEW] == [False] * 6 + [True, False]
    assert [shape.is_infinite for shape in NEW] == [False] * 5 + [True, True, False]
    assert [shape.is_infinite for shape in (Box(size=1), Sphere(radius=1), CUBE, Point())] == [False] * 4


def test_frames_are_those_of_the_axis_or_normal():
    for shape in (*NEW, CUBE):
        frame = np.array(shape.frame)
        assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-15)
        assert np.linalg.det(frame) == pytest.approx(1, rel=1e-15)
        assert shape.frame[2] == getattr(shape, "axis", getattr(shape, "normal", (0, 0, 1)))


def test_a_plane_and_a_slab_have_no_end():
    tilted, slab = Plane(normal=(0, 1, 1)), Slab(center=(1, 2, 3), normal=(0, 0, -1), thickness=0.5)
    assert FLOOR.bounds == ((-math.inf, -math.inf, 3), (math.inf, math.inf, 3))
    assert tilted.bounds == ((-math.inf,) * 3, (math.inf,) * 3)
    assert slab.bounds == ((-math.inf, -math.inf, 2.75), (math.inf, math.inf, 3.25))
    for shape in (FLOOR, slab):
        assert shape.area == shape.extent == math.inf
    front, back = slab.planes()
    assert front == Plane(center=(1, 2, 2.75), normal=(0, 0, -1))
    assert back == Plane(center=(1, 2, 3.25), normal=(0, 0, 1))
    assert slab.pieces() == (front, back) and FLOOR.pieces() == (FLOOR,)


def test_distances_from_planes_slabs_and_meshes():
    assert Plane(center=(5, 6, 1), normal=(0, 0, -1)).distance((100, -3, 4)) == 3
    slab = Slab(center=(0, 0, 1), thickness=2)
    for height, surface, filled in ((5, 3, 3), (1.5, 0.5, 0), (-1, 1, 1)):
        assert slab.distance((9, 9, height)) == surface
        assert slab.distance((9, 9, height), filled=True) == filled
    for place, surface in {(0, 0, 0.25): 0.75, (2, 0, 0.3): 1, (2, 3, 1.5): math.hypot(1, 2, 0.5)}.items():
        assert CUBE.distance(place) == pytest.approx(surface, rel=1e-15)
        assert (CUBE.distance(place, filled=True) == 0) == (place == (0, 0, 0.25))


# ---- rectangles with holes ----


def test_area_without_the_hole():
    assert FRAME.area == pytest.approx(2 - math.pi / 16, rel=1e-15)
    turned = Rectangle(width=0.5, height=0.25, up=(1, 1, 0))
    assert Rectangle(width=2, height=1, hole=turned).area == 2 - 0.125
    assert FRAME.bounds == Rectangle(width=2, height=1).bounds and FRAME.extent == math.hypot(1, 0.5)
    assert FRAME.projected_area((0, 0.6, 0.8)) == pytest.approx(0.8 * FRAME.area, rel=1e-15)


@pytest.mark.parametrize("up", [(0, 1, 0), (1, 0, 0)])
def test_a_thin_frame_keeps_its_area(up):
    """A width of 1e-13 all round: the difference of the products keeps two digits."""
    sizes = (1.7 - 2e-13, 0.9 - 2e-13)
    width, height = sizes if up[1] else sizes[::-1]
    frame = Rectangle(width=1.7, height=0.9, hole=Rectangle(width=width, height=height, up=up))
    exact = float(Fraction(1.7) * Fraction(0.9) - Fraction(width) * Fraction(height))
    assert frame.area == pytest.approx(exact, rel=1e-15, abs=0)
    assert 1.7 * 0.9 - width * height != pytest.approx(exact, rel=1e-5, abs=0)


def test_a_hole_may_reach_the_edge_and_be_turned_over():
    Rectangle(width=2, height=1, hole=Disk(center=(0.5, 0, 0), normal=(0, 0, -1), radius=0.5))
    tilted = {"center": (1.1, 2.2, 3.3), "normal": (1, 2, 3)}
    for up in ((1, 0, 0), (0.3, 1, 0)):
        hole = Rectangle(**tilted, width=0.7, height=0.1, up=up)
        Rectangle(**tilted, width=0.7, height=0.1 + 1e-9, up=up, hole=hole)


@given(points, st.floats(0.05, 0.4))
def test_distance_from_a_rectangle_with_a_hole(point, radius):
    """Against the least over points of the frame; in the hole it is the way to its edge."""
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 101), np.linspace(-0.45, 0.45, 91))
    along, across = (u + v) / math.sqrt(2), (u - v) / math.sqrt(2)
    for hole, is_out in (
        (Disk(radius=radius), np.hypot(u, v) >= radius),
        (
            Rectangle(width=2 * radius, height=radius, up=(1, 1, 0)),
            (np.abs(along) >= radius / 2) | (np.abs(across) >= radius),
        ),
    ):
        frame = Rectangle(width=1, height=0.9, hole=hole)
        apart = np.hypot(np.hypot(u - point[0], v - point[1]), point[2])[is_out].min()
        assert apart - 0.02 < frame.distance(point) <= apart * (1 + 1e-14)


# ---- triangles ----

HALF_SQUARE = Triangle(vertices=((0, 0, 0), (2, 0, 0), (0, 2, 0)))
SLOPED = Triangle(vertices=((1, 0.2, 1.5), (-0.7, 1.1, 2.0), (0.3, -1.3, 0.8)))


def triangle(*vertices):
    """A triangle, where these vertices make one."""
    try:
        return Triangle(vertices=vertices)
    except SceneError:
        assume(False)


def exact_area(vertices):
    """Half the vector product, in 60 digits."""
    with mpmath.workdps(60):
        a, b, c = (mpmath.matrix(vertex) for vertex in vertices)
        u, v = b - a, c - a
        cross = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        return float(mpmath.sqrt(sum(x * x for x in cross)) / 2)


def test_half_a_square():
    shape = HALF_SQUARE
    assert (shape.area, shape.normal) == (2.0, (0.0, 0.0, 1.0))
    assert shape.frame == ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    assert shape.center == shape.middle == pytest.approx((2 / 3, 2 / 3, 0), rel=1e-15)
    assert shape.bounds == ((0, 0, 0), (2, 2, 0)) and not shape.is_closed
    assert shape.extent == pytest.approx(math.hypot(4 / 3, 2 / 3), rel=1e-15)
    assert shape.projected_area((0, 0.6, -0.8)) == pytest.approx(1.6, rel=1e-15)
    assert np.array(shape.corners) == pytest.approx(np.array([(-2, -2), (4, -2), (-2, 4)]) / 3, rel=1e-15)
    a, b, c = shape.vertices
    for turned, sign in [((a, b, c), 1), ((b, c, a), 1), ((c, a, b), 1), ((b, a, c), -1), ((a, c, b), -1)]:
        assert Triangle(vertices=turned).normal == (0, 0, sign)


def test_e_u_runs_along_the_first_edge_of_a_triangle():
    for vertices in permutations(SLOPED.vertices):
        shape = Triangle(vertices=vertices)
        frame, edge = np.array(shape.frame), np.subtract(vertices[1], vertices[0])
        assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-15)
        assert frame[0] == pytest.approx(edge / np.linalg.norm(edge), abs=1e-15)
        assert frame[1] == pytest.approx(np.cross(frame[2], frame[0]), abs=1e-15)
        assert tuple(frame[2]) == shape.normal


@given(points, points, points)
def test_corners_lie_in_the_frame_and_turn_to_the_left(a, b, c):
    shape = triangle(a, b, c)
    (p, s), (q, t), (m, n) = shape.corners
    assert [p + q + m, s + t + n] == pytest.approx([0, 0], abs=1e-15)
    e_u, e_v, _ = np.array(shape.frame)
    for vertex, (u, v) in zip(shape.vertices, shape.corners, strict=True):
        assert np.array(shape.center) + u * e_u + v * e_v == pytest.approx(np.array(vertex), abs=1e-14)
        assert math.hypot(u, v) <= shape.extent * (1 + 1e-14)
    if shape.area > 1e-9:
        assert (q - p) * (n - s) - (t - s) * (m - p) == pytest.approx(2 * shape.area, rel=1e-6, abs=0)


@given(points, points, points, st.integers(-300, 300))
def test_the_area_of_a_triangle_is_exact_at_any_scale_within_the_range_of_doubles(a, b, c, exponent):
    shape = triangle(*(tuple(math.ldexp(x, exponent) for x in vertex) for vertex in (a, b, c)))
    assume(shape.area > 1e-300)
    assert shape.area == pytest.approx(exact_area(shape.vertices), rel=1e-15, abs=0)


def sliver_of(height, middle):
    """An edge of length 1 across the axes, and a vertex at a height over a point of its line."""
    a, b, c = np.array([1.0, 0.1, 0.2]), np.array([0.3, 1.0, 0.7]), np.array([0.4, -0.2, 0.5])
    b /= np.linalg.norm(b)
    return Triangle(vertices=(a, a + b, a + middle * b + height * np.cross(b, c)))


@pytest.mark.parametrize("height", [1e-3, 1e-6, 1e-9, 1e-12, 3e-15])
@pytest.mark.parametrize("middle", [0.0, 0.3, 1.0])
def test_sliver_triangles_keep_all_their_digits(height, middle):
    shape = sliver_of(height, middle)
    assert shape.area == pytest.approx(exact_area(shape.vertices), rel=1e-15, abs=0)
    for vertex in shape.vertices:  # the plane goes through the vertices
        assert np.dot(np.subtract(vertex, shape.vertices[0]), shape.normal) == pytest.approx(0, abs=2.5e-16)
    frame = np.array(shape.frame)
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-15)


@pytest.mark.parametrize("way", [(1, 2, 3), (0.1, 0.2, 0.3), (1e-9, 1, 0), (-0.7, 0.11, 1e5)])
@pytest.mark.parametrize("scale", [1e-30, 1, 1e30])
def test_vertices_on_a_line_are_refused_though_rounding_lifts_them_off_it(way, scale):
    for steps in [(0, 0, 0), (0, 0, 1), (0, 1, 3), (0.1, 0.3, 0.7), (-1, 2 / 3, 5)]:
        vertices = [[scale * step * x for x in way] for step in steps]
        assert_refused(lambda vertices=vertices: Triangle(vertices=vertices), "must not lie on one line")


DISTANCES = {
    (0.5, 0.5, 0): 0, (0.5, 0.5, -3): 3, (1, 1, 0): 0, (3, 0, 0): 1, (-3, -4, 0): 5, (1, -2, 0): 2,
    (2, 2, 0): math.sqrt(2), (2, 2, 1): math.sqrt(3), (0, 5, 4): 5,
}  # fmt: skip


@pytest.mark.parametrize(("point", "distance"), DISTANCES.items())
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


@pytest.mark.parametrize("height", [1e-12, 1e-13, 3e-14])
def test_a_thin_sliver_on_a_wall_stands_on_the_wall_and_takes_its_plane(height):
    """Rounding of its vertices turns its own normal."""
    disk = Disk(center=(0.1, 0.2, 0.3), normal=(1, 2, 3), radius=2)
    e_u, e_v, normal = np.array(disk.frame)
    corners = ((-1, -0.5), (1, 0.7), (0.1, 0.16 + height))
    sliver = Triangle(vertices=[np.array(disk.center) + u * e_u + v * e_v for u, v in corners])
    assert np.abs(np.subtract(sliver.normal, normal)).max() > 1e-6
    assert are_on_one_support(sliver, disk)
    meters = [Detector(sliver, name="sliver"), Detector(disk, name="disk")]
    for scene in (Scene(LAMP, (), meters), Scene(LAMP, Surface(disk, Black()), meters[0])):
        (sheet,) = scene_sheets(scene)
        assert sheet.support is disk and [m.shape for m in sheet.members] == [disk, sliver]


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


# ---- scenes ----


def test_surfaces_emit_and_are_metered_whatever_their_shape():
    for shape in (TUBE, CONE, DISH, CAP, TENT, CUBE, FRAME):
        source = Source(shape, Lambertian(radiance=2), side="back")
        assert source.amount(shape, None) == pytest.approx(2 * math.pi * shape.area, rel=1e-15)
        assert Source(shape, Effusive(density=4, speed=1)).amount(shape, None) == pytest.approx(shape.area)
        Source(Point(position=(9, 9, 9)), Isotropic(power=1), aim=shape)
        Detector(shape, "meter", directions=Directions(mu=2, phi=3))
    for shape in (FLOOR, GLASS, Sphere(radius=1), FRAME):
        Detector(shape, "meter", directions=Directions(mu=2, frame="world"))
        Detector(shape, "meter", directions=Directions.cone((0, 1, 1), 0.1))


def test_a_zone_may_stand_where_a_closed_shape_would_shut_light_in():
    Scene(POINT, Surface(Sphere(radius=1, mu_max=0.99), Mirror()))
    Scene(Source(Point(position=(0, 0, 1)), Isotropic(power=1)), Surface(GLASS, Mirror()))
    for shape in (Sphere(radius=1), GLASS, CUBE):
        assert_refused(lambda shape=shape: Scene(POINT, Surface(shape, Mirror())), "nothing absorbs inside")
        Scene(POINT, [Surface(shape, Mirror()), Surface(Disk(radius=0.1, center=(0.1, 0, 0)), Black())])
        Scene(POINT, Surface(shape, Diffuse(0.9)))


def test_a_source_about_a_mirror_ball_is_not_inside_of_it():
    """Its middle is; a source within is refused, wherever its middle."""
    around = [Sphere(radius=3), Sphere(radius=3, mu_min=-0.5), TUBE, Box(size=4)]
    for shape in (*around, Disk(radius=3, inner_radius=2)):
        Scene(Source(shape, Lambertian(power=1)), Surface(Sphere(radius=0.9), Mirror()))
    within = [DISK, Disk(radius=9), Cylinder(radius=1, height=1), Rectangle(width=1, height=1, hole=HOLE)]
    for shape in (*within, Sphere(radius=1, mu_min=0.3), Box(size=1)):
        lamp = Source(shape, Lambertian(power=1))
        assert_refused(
            lambda lamp=lamp: Scene(lamp, Surface(Sphere(radius=2), Mirror())), "nothing absorbs inside"
        )


def test_the_space_holds_what_ends_and_the_centers_of_what_does_not():
    walls = [Surface(FLOOR, Black()), Surface(Slab(center=(0, 0, -7), thickness=1), Black())]
    space = make_space(Scene(LAMP, walls))
    assert space.origin == (0, 0, 0) and space.size == 8
    assert make_space(Scene(LAMP, Surface(Cylinder(radius=1, height=33), Black()))).size == 32


def test_projected_solid_angles_of_planes_are_those_of_flat_shapes():
    def projected(shape, bins, side="front"):
        return solid_angles_of(Detector(shape, "m", directions=bins, side=side), shape)[1]

    world, cone, normal = (Directions(mu=3, phi=2, frame="world"), Directions.cone((0, 1, 2), 0.4), (0, 1, 3))
    disk, plane, slab = Disk(radius=1, normal=normal), Plane(normal=normal), Slab(normal=normal, thickness=1)
    for bins in (world, cone):
        front, back = projected(disk, bins), projected(disk, world, "back") if bins is world else 0.0
        assert projected(plane, bins) == pytest.approx(front, rel=1e-15)
        assert projected(slab, bins) == pytest.approx((front + back) / 2, rel=1e-14)
    exact = math.pi / 4 * np.array([[0.25] * 2, [0.75] * 2]) * 2
    assert projected(TUBE, Directions(mu=2, phi=2)) == pytest.approx(exact)


# ---- points on shapes ----

EVEN_NUMBERS = np.random.default_rng(11).random((20_000, 2))
ROUND = {
    "cylinder": Cylinder(center=(1, 2, 3), axis=(1, 1, 0), radius=0.5, height=2),
    "cone": Cone(radius=1, height=2),
    "pointed far up": Cone(radius=0, top_radius=1, height=0.3),
    "frustum": Cone(center=(0, 1, 0), axis=(0, 1, 1), radius=1, top_radius=0.2, height=1),
    "nearly a cylinder": Cone(radius=1, top_radius=1 + 1e-9, height=1),
    "paraboloid": Paraboloid(focal_length=0.1, radius=1, inner_radius=0.2),
    "shallow paraboloid": Paraboloid(focal_length=50, radius=1),
    "sphere": Sphere(center=(0, 0, 5), radius=2),
    "zone": Sphere(radius=1, axis=(1, 0, 1), mu_min=-0.2, mu_max=0.9),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ROUND)
def test_points_on_round_shapes_are_even_over_the_area(name):
    """As many in each tenth of the height as its area says; they lie on the shape, with its normals."""
    shape = ROUND[name]
    points, normals = shape.sample_area(EVEN_NUMBERS)
    axis, profile = np.array(shape.axis), shape.profile
    heights = (points - np.array(profile.origin)) @ axis
    edges = np.linspace(profile.low, profile.high, 11)
    counts, _ = np.histogram(heights, np.concatenate([[-math.inf], edges[1:-1], [math.inf]]))
    areas = np.array([profile.area_per_radian(*pair) for pair in zip(edges[:-1], edges[1:], strict=True)])
    assert_follows(counts, areas / areas.sum())
    if name == "cone":
        with pytest.raises(AssertionError):  # heights that are even
            assert_follows(np.full(10, 2000), areas / areas.sum())
    assert max(shape.distance(tuple(point)) for point in points[:100]) < 1e-14 * shape.coordinate_scale
    out = points + 1e-6 * shape.extent * normals
    assert np.linalg.norm(normals, axis=1) == pytest.approx(np.ones(len(normals)), rel=1e-14)
    moved = [shape.distance(tuple(point)) for point in out[:100]]
    assert moved == pytest.approx(np.full(100, 1e-6 * shape.extent), rel=1e-6)


SLANTED = Rectangle(center=(1, 0, 2), normal=(1, 1, 1), width=2, height=0.5)
HOLED = Rectangle(width=2, height=2, hole=Disk(center=(0.2, 0, 0), radius=0.7))
ROUND_DISK, ANNULUS = Disk(center=(0, 0, 1), normal=(0, 1, 1), radius=2), Disk(radius=2, inner_radius=1.9)
FLAT = {  # and a part of each
    "rectangle": (SLANTED, dataclasses.replace(SLANTED, width=1, height=0.2)),
    "holed": (HOLED, dataclasses.replace(HOLED, width=1.9, height=1.9)),
    "disk": (ROUND_DISK, dataclasses.replace(ROUND_DISK, radius=1.0, inner_radius=0.3)),
    "annulus": (ANNULUS, dataclasses.replace(ANNULUS, radius=1.95)),
    "triangle": [Triangle(vertices=((0, 0, 0), (width, 0, 0), (0, 1, 1))) for width in (3, 1)],
}


@pytest.mark.parametrize("name", FLAT)
def test_points_on_flat_shapes_are_even_over_the_area(name):
    """As many within a smaller copy of the shape as its area says."""
    shape, part = FLAT[name]
    points, normals = shape.sample_area(EVEN_NUMBERS)
    assert (normals == shape.normal).all() and shape.covers(points).all()
    inside = int(part.covers(points).sum())
    shares = np.array([part.area, shape.area - part.area]) / shape.area
    assert_follows(np.array([inside, len(points) - inside]), shares)


CLOSED = [
    Box(center=(0, 0, 1), size=(1, 2, 1)),
    Sphere(center=(0, 0, 1), radius=0.7),
    Slab(center=(0, 0, 1), normal=(0, 1, 2), thickness=0.8),
    Mesh.sphere(center=(0, 0, 1), radius=0.7, triangles=80),
]


@pytest.mark.parametrize("shape", CLOSED, ids=name_of)
def test_a_closed_shape_contains_what_has_no_distance_from_its_volume(shape):
    points = np.random.default_rng(5).uniform((-1, -1, 0), (1, 1, 2), (300, 3))
    held = shape.contains(points)
    assert held.any() and not held.all()
    assert held.tolist() == [shape.distance(tuple(point), filled=True) == 0 for point in points]


def test_an_open_shape_contains_nothing():
    for shape in (ROUND["zone"], ROUND["cylinder"], ROUND_DISK, Point()):
        assert not shape.contains(np.array([shape.middle, (0.0, 0.0, 0.0)])).any()
