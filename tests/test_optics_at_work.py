"""Shapes and materials put to work: aims at holes, glass with gaps, what is told of them."""

import warnings

import pytest

import transport as tp
from tests.agreement import assert_agrees

SQUARE = {"width": 2.0, "height": 2.0}


def test_an_aim_at_a_rectangle_with_a_hole_weighs_directions_by_the_whole_rectangle():
    """Directions go to the hole as well; taken for the area that is left, the weights would be 38 % too small."""
    holed = tp.Rectangle(**SQUARE, hole=tp.Disk(radius=0.7))
    whole, hole = (
        tp.solid_angle(tp.Rectangle(**SQUARE), (0, 0, 1), seed=1),
        tp.solid_angle(tp.Disk(radius=0.7), (0, 0, 1), seed=2),
    )
    assert_agrees(tp.solid_angle(holed, (0, 0, 1), seed=3) - (whole - hole), 0.0)


def test_a_view_factor_to_a_rectangle_with_a_hole_is_the_difference():
    at = {"center": (0, 0, 5), "normal": (0, 0, -1)}
    disk, hole = tp.Disk(radius=0.5), tp.Disk(radius=0.3, **at)
    holed, whole = (tp.Rectangle(width=1, height=1, hole=part, **at) for part in (hole, None))
    difference = tp.view_factor(disk, whole, seed=1) - tp.view_factor(disk, hole, seed=2)
    assert_agrees(tp.view_factor(disk, holed, seed=3) - difference, 0.0)


def glass(mesh):
    far = tp.Sphere(radius=3.0)
    lamp = tp.Source(far, tp.Lambertian(radiance=1.0), side="back", aim=tp.Sphere(radius=0.5))
    scene = tp.Scene(lamp, [tp.Surface(mesh, tp.Dielectric(1.5)), tp.Surface(far, tp.Black())])
    return tp.simulate(scene, particles=100_000, seed=1)


@pytest.mark.slow
def test_glass_with_a_gap_is_warned_of():
    """Light gets in by the gap, and comes to the glass from within at the index of the air."""
    whole = tp.Mesh.sphere(radius=0.5, triangles=720)
    assert glass(whole).warnings == []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tp.MeshWarning)
        gap = tp.Mesh(vertices=whole.vertices, faces=whole.faces[5:])
    [warning] = glass(gap).warnings
    assert "times light reached a Dielectric from a medium of another index" in warning


@pytest.mark.parametrize(
    "shape",
    [
        tp.Cylinder(radius=0.2, height=0.5),
        tp.Cone(radius=0.3, height=0.5),
        tp.Paraboloid(focal_length=0.1, radius=0.2),
        tp.Sphere(radius=0.3, mu_max=0.1),
        tp.Mesh.box(size=0.3),
        tp.Disk(radius=0.2),
    ],
    ids=lambda shape: type(shape).__name__,
)
def test_a_lamp_within_glass_knows_the_index_that_it_emits_into(shape):
    from transport.compile.compiler import compile_scene

    ball = tp.Surface(tp.Sphere(radius=1.0), tp.Dielectric(1.5))
    walls = tp.Surface(tp.Box(size=4.0), tp.Black())
    for side in ("front", "back"):
        source = tp.Source("lamp", tp.Lambertian(power=1.0), side=side)
        scene = tp.Scene(source, [ball, walls, tp.Surface(shape, tp.Black(), "lamp")])
        [emitter] = compile_scene(scene).emitters
        is_shut = isinstance(shape, tp.Mesh) and side == "back"
        assert emitter.medium["index"] == (0.0 if is_shut else 1.5)


@pytest.mark.parametrize(
    "aim",
    [tp.Sphere(center=(5, 0, 0), radius=10.0), tp.Cylinder(center=(2, 0, 1), radius=6.0, height=9.0)],
    ids=["sphere", "cylinder"],
)
def test_an_aim_that_holds_its_source_changes_nothing(aim):
    """Rays born within the ball of an aim may have passed its middle: their start lies behind it."""
    ball = tp.Surface(tp.Sphere(radius=1.0), tp.Black(), "ball")
    lamp = tp.Source("ball", tp.Lambertian(power=1.0), side="back", aim=aim)
    meter = tp.Detector("ball", side="back", positions=tp.Positions(u=4, v=4), name="meter")
    result = tp.simulate(tp.Scene(lamp, ball, meter), particles=400_000, seed=1)
    assert result.ledger["escaped"].value == 0
    assert_agrees(result["meter"].irradiance, 1 / ball.shape.area)


@pytest.mark.parametrize("focal_length", [0.2, 1.0, 1e6, 1e8])
def test_births_are_uniform_over_paraboloids_however_shallow(focal_length):
    dish = tp.Paraboloid(focal_length=focal_length, radius=1.0)
    heights = tuple(dish.profile.high * k / 5 for k in range(6))
    meter = tp.Detector(dish, "meter", positions=tp.Positions(u=heights))
    lamp = tp.Source(dish, tp.Lambertian(power=1.0))
    result = tp.simulate(tp.Scene(lamp, (), meter), particles=400_000, seed=1)
    assert_agrees(result["meter"].exitance, 1 / dish.area)


@pytest.mark.parametrize("focal_length", [0.5, 10.0, 1e6])
def test_a_beam_into_the_vertex_of_a_parabolic_mirror_comes_straight_back(focal_length):
    """The vertex is no rim: what lands there stays where it landed."""
    dish = tp.Surface(tp.Paraboloid(focal_length=focal_length, radius=1.0), tp.Mirror())
    beam = tp.Source(tp.Point(position=(0, 0, 1e-3 * focal_length)), tp.Beam((0, 0, -1), power=1.0))
    meter = tp.Detector(tp.Disk(center=(0, 0, 2e-3 * focal_length), radius=1e-9), "meter")
    result = tp.simulate(tp.Scene(beam, dish, meter), particles=100, seed=1)
    assert result["meter"].flux_out.value == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("height", [1e-6, 1e-8, 1e-9])
def test_a_flat_cone_on_its_disk_holds_what_glows_inside(height):
    """Its discriminant is the small difference of two large products, unless it is told by Lagrange's identity."""
    cone = tp.Cone(center=(0, 0, height / 2), radius=1.0, height=height)
    parts = {"cone": cone, "disk": tp.Disk(normal=(0, 0, -1), radius=1.0)}
    walls = [tp.Surface(part, tp.Black(), name) for name, part in parts.items()]
    lamps = [tp.Source(name, tp.Lambertian(radiance=1.0), side="back") for name in parts]
    meters = [tp.Detector(name, side="back", directions=tp.Directions(mu=4)) for name in parts]
    result = tp.simulate(tp.Scene(lamps, walls, meters), particles=200_000, seed=1)
    assert result.ledger["escaped"].value == 0
    for name in parts:
        assert_agrees(result[name].radiance, 1.0)
