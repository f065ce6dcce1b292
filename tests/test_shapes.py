"""The shapes that are not of revolution: holes, planes, slabs; and what each shape may be used for."""

import dataclasses
import math
import pickle
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.agreement import assert_follows
from transport.analysis.solid_angle import solid_angle_scene
from transport.compile.detectors import detector_row, side_rows
from transport.compile.plan import Plan
from transport.compile.space import make_space
from transport.geometry.flat import Disk, Plane, Rectangle, Slab, Triangle
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Cone, Cylinder, Paraboloid
from transport.geometry.shape import Point
from transport.geometry.solid import Box, Sphere
from transport.results.solid_angles import solid_angles_of
from transport.scene.bins import Directions, Positions
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Effusive, Gas, Isotropic, Lambertian
from transport.scene.materials import Black, Diffuse, Mirror, Surface
from transport.scene.scene import Scene
from transport.scene.sheets import scene_sheets
from transport.scene.sources import Source
from transport.scene.tracking import Tracking
from transport.validation import SceneError

TUBE = Cylinder(radius=1, height=2)
CONE = Cone(radius=1, top_radius=0.25, height=2)
DISH = Paraboloid(focal_length=0.5, radius=1, inner_radius=0.25)
CAP = Sphere(radius=2, mu_min=0.5)
TENT = Triangle(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 0.5)))
CUBE = Mesh.box(size=2)
FLOOR, GLASS = Plane(center=(1, 2, 3)), Slab(thickness=0.5)
FRAME = Rectangle(width=2, height=1, hole=Disk(center=(0.4, 0, 0), radius=0.25))
NEW = [TUBE, CONE, DISH, CAP, TENT, FLOOR, GLASS, FRAME]
LAMP = Source(Disk(radius=1), Lambertian(power=1))
corners = st.floats(-1, 1)


def names(thing):
    return type(thing).__name__


# ---- what they are ----


@pytest.mark.parametrize("shape", NEW, ids=names)
def test_shapes_are_frozen_hashable_and_survive_copies(shape):
    for twin in (dataclasses.replace(shape), pickle.loads(pickle.dumps(shape)), eval(repr(shape))):
        assert twin == shape and hash(twin) == hash(shape)
    with pytest.raises(dataclasses.FrozenInstanceError):
        shape.radius = 3


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


@given(st.tuples(corners, corners, corners), st.floats(0.05, 0.4))
def test_distance_from_a_rectangle_with_a_hole(point, radius):
    """Against the least over points of the frame; in the hole it is the way to its edge."""
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 101), np.linspace(-0.45, 0.45, 91))
    for hole in (Disk(radius=radius), Rectangle(width=2 * radius, height=radius, up=(1, 1, 0))):
        frame = Rectangle(width=1, height=0.9, hole=hole)
        along, across = (u + v) / math.sqrt(2), (u - v) / math.sqrt(2)
        is_out = np.hypot(u, v) >= radius
        if isinstance(hole, Rectangle):
            is_out = (np.abs(along) >= radius / 2) | (np.abs(across) >= radius)
        apart = np.hypot(np.hypot(u - point[0], v - point[1]), point[2])[is_out].min()
        assert apart - 0.02 < frame.distance(point) <= apart * (1 + 1e-14)


def test_distances_from_planes_slabs_and_meshes():
    assert Plane(center=(5, 6, 1), normal=(0, 0, -1)).distance((100, -3, 4)) == 3
    slab = Slab(center=(0, 0, 1), thickness=2)
    for height, surface, filled in ((5, 3, 3), (1.5, 0.5, 0), (-1, 1, 1)):
        assert slab.distance((9, 9, height)) == surface
        assert slab.distance((9, 9, height), filled=True) == filled
    for place, surface, filled in (
        ((0, 0, 0.25), 0.75, 0),
        ((2, 0, 0.3), 1, 1),
        ((2, 3, 1.5), math.hypot(1, 2, 0.5), 1),
    ):
        assert CUBE.distance(place) == pytest.approx(surface, rel=1e-15)
        assert (CUBE.distance(place, filled=True) == 0) == (filled == 0)


# ---- what is refused ----

HOLE = Disk(radius=0.25)
REFUSED = {
    "hole beyond": (lambda: Rectangle(width=1, height=1, hole=Disk(center=(0.3, 0, 0), radius=0.25)), "within it.*0.05 m"),
    "hole too wide": (lambda: Rectangle(width=1, height=1, hole=Rectangle(width=0.8, height=0.8, up=(1, 1, 0))), "within it"),
    "hole off plane": (lambda: Rectangle(width=1, height=1, hole=Disk(center=(0, 0, 1e-9), radius=0.2)), "in its plane.*1e-09"),
    "hole tilted": (lambda: Rectangle(width=1, height=1, hole=Disk(normal=(0, 1e-6, 1), radius=0.2)), "in its plane"),
    "hole with island": (lambda: Rectangle(width=1, height=1, hole=Disk(radius=0.4, inner_radius=0.2)), "hole of its own"),
    "hole in hole": (lambda: Rectangle(width=2, height=2, hole=Rectangle(width=1, height=1, hole=HOLE)), "hole of its own"),
    "hole is all": (lambda: Rectangle(width=1, height=1, hole=Rectangle(width=1, height=1)), "be smaller"),
    "hole is a ball": (lambda: Rectangle(width=1, height=1, hole=Sphere(radius=0.1)), "a Disk or Rectangle.*got Sphere"),
    "cylinder radius": (lambda: Cylinder(radius=0, height=1), "Cylinder: radius must be positive"),
    "cylinder height": (lambda: Cylinder(radius=1, height=-1), "Cylinder: height must be positive"),
    "cylinder axis": (lambda: Cylinder(radius=1, height=1, axis=(0, 0, 0)), "Cylinder: axis"),
    "cylinder by place": (lambda: Cylinder(1, 2), "keywords only"),
    "cylinder huge": (lambda: Cylinder(radius=1e200, height=1e200), "area must be positive and finite.*change the unit"),
    "box whose faces overflow together": (lambda: Box(size=1.3e154), "area must be positive and finite.*change the unit"),
    "cone to nothing": (lambda: Cone(radius=0, height=1), "radius and top_radius must not both be 0"),
    "cone negative": (lambda: Cone(radius=1, top_radius=-1, height=1), "Cone: top_radius must be zero or positive"),
    "paraboloid flat": (lambda: Paraboloid(radius=1, focal_length=0), "focal_length must be positive"),
    "paraboloid ring": (lambda: Paraboloid(radius=1, inner_radius=1, focal_length=1), "inner_radius must be below radius"),
    "zone order": (lambda: Sphere(radius=1, mu_min=0.5, mu_max=0.5), "mu_min must be below mu_max 0.5"),
    "zone beyond": (lambda: Sphere(radius=1, mu_max=1.5), r"mu_max must be a number in \[-1, 1\], got 1.5"),
    "zone of nan": (lambda: Sphere(radius=1, mu_min=math.nan), "mu_min must be a number"),
    "zone of text": (lambda: Sphere(radius=1, mu_min="half"), "mu_min must be a number.*'half'"),
    "slab vanishes": (lambda: Slab(center=(0, 0, 1), thickness=1e-17), "thickness must not vanish"),
    "slab negative": (lambda: Slab(thickness=-1), "Slab: thickness must be positive"),
    "plane normal": (lambda: Plane(normal=(0, 0, 0)), "Plane: normal"),
    # as sources and aims
    "plane emits": (lambda: Source(FLOOR, Lambertian(power=1)), "leaves from a .* area is infinite; use a large Rect"),
    "slab emits": (lambda: Source(GLASS, Isotropic(power=1)), "Slab.*is infinite"),
    "slab of gas": (lambda: Source(GLASS, Gas(density=1, speed=1)), "Slab.*is infinite"),
    "aim at plane": (lambda: Source(Point(), Isotropic(power=1), aim=FLOOR), "aim must be finite, got Plane"),
    "aim at slab": (lambda: Source(Point(), Isotropic(power=1), aim=GLASS), "aim must be finite, got Slab"),
    "gas in zone": (lambda: Source(CAP, Gas(density=1, speed=1)), "Gas leaves from .*a zone; leave out mu_min and mu_max"),
    "glow in zone": (lambda: Source(CAP, Isotropic(power=1)), "Isotropic leaves from .*a zone"),
    "beam of zone": (lambda: Source(CAP, Beam((0, 0, 1), power=1)), "Beam leaves from .*a zone"),
    "beam of tube": (lambda: Source(TUBE, Beam((0, 0, 1), power=1)), "Beam leaves from a Point, .* got shape=Cylinder"),
    "gas in tube": (lambda: Source(TUBE, Gas(density=1, speed=1)), "Gas leaves from a Box.*; enclose it in a Box"),
    "inside of tube": (lambda: Source(TUBE, Lambertian(power=1), side="inside"), "write side='back'"),
    # as detectors
    "places on plane": (lambda: Detector(FLOOR, "m", positions=Positions(u=2)), "Plane has no coordinates.*Rectangle or Disk in it"),
    "places on slab": (lambda: Detector(GLASS, "m", positions=Positions(u=2)), r"Slab has no coord.*planes\(\)"),
    "places on mesh": (lambda: Detector(CUBE, "m", positions=Positions(u=2)), "Mesh has no coordinates"),
    "places on frame": (lambda: Detector(FRAME, "m", positions=Positions(u=2)), "a Rectangle with a hole has no bins"),
    "height beyond": (lambda: Detector(TUBE, "m", positions=Positions(u=(0, 1.5))), r"u edges must be within \[-1.0, 1.0\] for Cyl"),
    "angle beyond": (lambda: Detector(CAP, "m", positions=Positions(u=(0, 2))), r"u edges must be within \[0.0, 1.04"),
    **{
        f"{what} on {names(shape)}": (
            lambda shape=shape, directions=directions: Detector(shape, "m", directions=directions),
            r"directions must be in the local frame on a .*; write Directions\(mu=..., frame='local'\)",
        )
        for shape in (TUBE, CONE, DISH, CAP, CUBE)
        for what, directions in (
            ("world", Directions(mu=2, frame="world")),
            ("cone", Directions.cone((0, 0, 1), 0.1)),
        )
    },
}  # fmt: skip


@pytest.mark.parametrize(("make", "words"), REFUSED.values(), ids=REFUSED)
def test_what_makes_no_sense_is_refused(make, words):
    with pytest.raises(SceneError, match=words):
        make()


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


# ---- scenes ----


def test_a_zone_may_stand_where_a_closed_shape_would_shut_light_in():
    lamp = Source(Point(), Isotropic(power=1))
    Scene(lamp, Surface(Sphere(radius=1, mu_max=0.99), Mirror()))
    Scene(Source(Point(position=(0, 0, 1)), Isotropic(power=1)), Surface(GLASS, Mirror()))
    mirror_box = Mesh.box(size=2)
    for shape in (Sphere(radius=1), GLASS, mirror_box):
        with pytest.raises(SceneError, match="nothing absorbs inside"):
            Scene(lamp, Surface(shape, Mirror()))
        Scene(lamp, [Surface(shape, Mirror()), Surface(Disk(radius=0.1, center=(0.1, 0, 0)), Black())])
        Scene(lamp, Surface(shape, Diffuse(0.9)))


def test_a_source_about_a_mirror_ball_is_not_inside_of_it():
    """Its middle is; a source within is refused, wherever its middle."""
    around = [
        Sphere(radius=3), Sphere(radius=3, mu_min=-0.5), TUBE, Box(size=4), Disk(radius=3, inner_radius=2)
    ]  # fmt: skip
    for shape in around:
        Scene(Source(shape, Lambertian(power=1)), Surface(Sphere(radius=0.9), Mirror()))
    within = [
        Disk(radius=1),
        Disk(radius=9),
        Cylinder(radius=1, height=1),
        Rectangle(width=1, height=1, hole=HOLE),
    ]
    for shape in (*within, Sphere(radius=1, mu_min=0.3), Box(size=1)):
        with pytest.raises(SceneError, match="nothing absorbs inside"):
            Scene(Source(shape, Lambertian(power=1)), Surface(Sphere(radius=2), Mirror()))


def test_the_space_holds_what_ends_and_the_centers_of_what_does_not():
    lamp = Source(Disk(radius=1), Lambertian(power=1))
    walls = [Surface(FLOOR, Black()), Surface(Slab(center=(0, 0, -7), thickness=1), Black())]
    space = make_space(Scene(lamp, walls))
    assert space.origin == (0, 0, 0) and space.size == 8
    assert make_space(Scene(lamp, Surface(Cylinder(radius=1, height=33), Black()))).size == 32


def test_a_slab_is_two_sheets_and_a_plane_one():
    [upper, lower] = scene_sheets(
        Scene(LAMP, Surface(GLASS, Black()), Detector(Disk(center=(5, 5, 0.25), radius=1), "m"))
    )
    assert upper.support == GLASS.planes()[0] and len(upper.members) == 2
    assert lower.support == GLASS.planes()[1] and len(lower.members) == 1


@pytest.mark.parametrize("shape", [TUBE, CONE, DISH, CAP], ids=names)
def test_bins_of_position_are_compiled_in_scene_lengths(shape):
    """Heights are lengths from the center, polar angles are none."""
    meter = Detector(shape, "m", positions=Positions(u=2, v=3), side="back")
    scene = Scene(LAMP, (), [meter, Detector(Disk(center=(0, 0, 5), radius=1), "far")])
    plan = Plan(scene, make_space(scene), Tracking())
    plan.rows_of = {"m": side_rows(meter, shape, None, 1)}
    member = next(m for sheet in scene_sheets(scene) for m in sheet.members if m.shape == shape)
    row = detector_row(plan, member, meter)
    assert plan.space.size == 8
    edges = [kept for kept in plan.kept if kept.dtype == np.float64 and kept.shape == (3,)]
    low, high = meter.positions.edges(shape)["u"][[0, -1]]
    scale = 1 if shape is CAP else 8
    assert edges[-1] * scale == pytest.approx([low, (low + high) / 2, high], rel=1e-15)
    assert (row["nx"], row["ny"], row["nz"]) == (row["axis_x"], row["axis_y"], row["axis_z"]) == (0, 0, 1)
    assert row["side"] == -1 and row["handed"] == 1 and row["u_stride"] == 3


def test_projected_solid_angles_of_planes_are_those_of_flat_shapes():
    for directions in (Directions(mu=3, phi=2, frame="world"), Directions.cone((0, 1, 2), 0.4)):
        flat = Detector(Disk(radius=1, normal=(0, 1, 3)), "m", directions=directions)
        plane = Detector(Plane(normal=(0, 1, 3)), "m", directions=directions)
        slab = Detector(Slab(normal=(0, 1, 3), thickness=1), "m", directions=directions)
        _, projected = solid_angles_of(flat, flat.shape)
        assert solid_angles_of(plane, plane.shape)[1] == pytest.approx(projected, rel=1e-15)
        back = Directions(mu=3, phi=2, frame="world") if isinstance(directions, Directions) else None
        other = 0.0  # of a cone that lies in front
        if back is not None:
            _, other = solid_angles_of(Detector(flat.shape, "m", side="back", directions=back), flat.shape)
        assert solid_angles_of(slab, slab.shape)[1] == pytest.approx((projected + other) / 2, rel=1e-14)
    tube = Detector(TUBE, "m", directions=Directions(mu=2, phi=2))
    assert solid_angles_of(tube, TUBE)[1] == pytest.approx(
        math.pi / 4 * np.array([[0.25] * 2, [0.75] * 2]) * 2
    )


def test_solid_angles_are_counted_on_a_black_surface_where_rays_may_cross_twice():
    assert not solid_angle_scene(FRAME, (0, 0, 1)).surfaces
    for shape in (TUBE, CONE, DISH, CAP, CUBE):
        [surface] = solid_angle_scene(shape, (0, 0, 9)).surfaces
        assert surface.shape == shape and surface.material == Black()
        assert solid_angle_scene(shape, (0, 0, 9)).sources[0].aim == shape
        assert solid_angle_scene(shape, (0.1, 0, 0.2)).sources[0].aim is None
    for shape in (FLOOR, GLASS, Point()):
        with pytest.raises(SceneError, match="one that has an area"):
            solid_angle_scene(shape, (0, 0, 1))
    with pytest.raises(SceneError, match="must not lie on the Cylinder"):
        solid_angle_scene(TUBE, (0.6, 0.8, 0.3))
    with pytest.raises(SceneError, match="must not lie on the Mesh"):
        solid_angle_scene(CUBE, (0.6, 1, 0.3))
    assert solid_angle_scene(FRAME, (0.4, 0, 0)).sources  # in the hole: edge-on


# ---- points on shapes ----

EVEN_NUMBERS = np.random.default_rng(11).random((100_000, 2))
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
    assert max(shape.distance(tuple(point)) for point in points[:100]) < 1e-14 * shape.coordinate_scale
    out = points + 1e-6 * shape.extent * normals
    assert np.linalg.norm(normals, axis=1) == pytest.approx(np.ones(len(normals)), rel=1e-14)
    moved = [shape.distance(tuple(point)) for point in out[:100]]
    assert moved == pytest.approx(np.full(100, 1e-6 * shape.extent), rel=1e-6)


def test_heights_that_are_even_are_seen_on_a_cone():
    profile = ROUND["cone"].profile
    edges = np.linspace(profile.low, profile.high, 11)
    areas = np.array([profile.area_per_radian(*pair) for pair in zip(edges[:-1], edges[1:], strict=True)])
    with pytest.raises(AssertionError):
        assert_follows(np.full(10, 10_000), areas / areas.sum())


FLAT = {
    "rectangle": Rectangle(center=(1, 0, 2), normal=(1, 1, 1), width=2, height=0.5),
    "holed": Rectangle(width=2, height=2, hole=Disk(center=(0.2, 0, 0), radius=0.7)),
    "disk": Disk(center=(0, 0, 1), normal=(0, 1, 1), radius=2),
    "annulus": Disk(radius=2, inner_radius=1.9),
    "triangle": Triangle(vertices=((0, 0, 0), (3, 0, 0), (0, 1, 1))),
}


@pytest.mark.parametrize("name", FLAT)
def test_points_on_flat_shapes_are_even_over_the_area(name):
    """As many within a smaller copy of the shape as its area says."""
    shape = FLAT[name]
    points, normals = shape.sample_area(EVEN_NUMBERS)
    assert (normals == shape.normal).all() and shape.covers(points).all()
    part = {
        "rectangle": lambda: dataclasses.replace(shape, width=1, height=0.2),
        "holed": lambda: dataclasses.replace(shape, width=1.9, height=1.9),
        "disk": lambda: dataclasses.replace(shape, radius=1.0, inner_radius=0.3),
        "annulus": lambda: dataclasses.replace(shape, radius=1.95),
        "triangle": lambda: Triangle(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 1))),
    }[name]()
    inside = int(part.covers(points).sum())
    assert_follows(
        np.array([inside, len(points) - inside]), np.array([part.area, shape.area - part.area]) / shape.area
    )


@pytest.mark.parametrize(
    "shape",
    [
        Box(center=(0, 0, 1), size=(1, 2, 1)),
        Sphere(center=(0, 0, 1), radius=0.7),
        Slab(center=(0, 0, 1), normal=(0, 1, 2), thickness=0.8),
        Mesh.sphere(center=(0, 0, 1), radius=0.7, triangles=80),
    ],
    ids=lambda shape: type(shape).__name__,
)
def test_a_closed_shape_contains_what_has_no_distance_from_its_volume(shape):
    points = np.random.default_rng(5).uniform((-1, -1, 0), (1, 1, 2), (300, 3))
    held = shape.contains(points)
    assert held.any() and not held.all()
    assert held.tolist() == [shape.distance(tuple(point), filled=True) == 0 for point in points]


def test_an_open_shape_contains_nothing():
    for shape in (ROUND["zone"], ROUND["cylinder"], FLAT["disk"], Point()):
        assert not shape.contains(np.array([shape.middle, (0.0, 0.0, 0.0)])).any()
