"""How surfaces meet: contacts, lines that cross them, and boundaries of media that contradict one another."""

from __future__ import annotations

import itertools
import math
import time
import warnings

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.refusals import assert_refused
from transport.geometry.contacts import contact_pairs
from transport.geometry.line_crossings import crossings
from transport.scene.checks.refractive_indices import check_media
from transport.vectors import unit_vector

# ---- which surfaces come inside of one another ----

AXIS = unit_vector((0.3, -0.2, 0.9))
BACK = tuple(-x for x in AXIS)
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]


def at(height):
    """A point of the common axis."""
    return tuple(o + height * a for o, a in zip((0.1, 0.2, 0.3), AXIS, strict=True))


def tube(radius=0.7, height=2.0, middle=0.0, axis=AXIS):
    return tp.Cylinder(center=at(middle), axis=axis, radius=radius, height=height)


def disk(height, radius, inner_radius=0.0, normal=AXIS):
    return tp.Disk(center=at(height), normal=normal, radius=radius, inner_radius=inner_radius)


def plate(height, hole=None):
    hole = None if hole is None else disk(height, hole, normal=BACK)
    return tp.Rectangle(center=at(height), normal=AXIS, up=(0, 1, 1), width=4, height=4, hole=hole)


def cone(radius, top_radius, low, high):
    return tp.Cone(
        center=at((low + high) / 2), axis=AXIS, radius=radius, top_radius=top_radius, height=high - low
    )


def dish(low=0.0, focal_length=0.2, radius=0.5):
    return tp.Paraboloid(center=at(low), axis=AXIS, focal_length=focal_length, radius=radius)


def ball(height, radius, **bounds):
    return tp.Sphere(center=at(height), axis=AXIS, radius=radius, **bounds)


def lens(radius, aperture, thickness=0.0):
    """Two caps whose rims have the radius `aperture` and are `thickness` apart."""
    mu = math.sqrt((1 - aperture / radius) * (1 + aperture / radius))
    lower = ball(radius * mu - thickness / 2, radius, mu_max=-mu)
    return ball(thickness / 2 - radius * mu, radius, mu_min=mu), lower


EDGES_ONLY = {
    "a tube and its lids": [tube(), disk(1, 0.7), disk(-1, 0.7, normal=BACK)],
    "a tube and a ring round its end": [tube(), disk(1, 2, inner_radius=0.7)],
    "a tube in the hole of a plate": [tube(), plate(1, hole=0.7)],
    "a tube end to end with another": [tube(), tube(middle=2)],
    "a tube and a smaller lid": [tube(), disk(1, 0.6)],
    "a tube in a tube, with a ring between": [tube(), tube(radius=0.2), disk(1, 0.7, inner_radius=0.2)],
    "a capsule": [tube(), ball(1, 0.7, mu_min=0), ball(-1, 0.7, mu_max=0)],
    "cones on a tube": [tube(), cone(0.7, 0, 1, 2), cone(0.1, 0.7, -2, -1)],
    "a diabolo with a waist": [cone(1, 0.3, -1, 0), cone(0.3, 1, 0, 1)],
    "an ice cream": [cone(0, 0.5, 0, 1), ball(1, 0.5, mu_min=0)],
    "a dish and its lid": [dish(), disk(0.25 / 0.8, 0.5)],
    "a dish on a tube": [dish(), tube(radius=0.5, middle=1 + 0.25 / 0.8)],
    "two dishes": [dish(), tp.Paraboloid(center=at(0.625), axis=BACK, focal_length=0.2, radius=0.5)],
    "a lens": [*lens(1.3, 0.4)],
    "a lens in its mount": [*lens(1.3, 0.4), disk(0, 1, inner_radius=0.4)],
    "a thick lens with its rim": [*lens(1.3, 0.4, 0.3), tube(radius=0.4, height=0.3)],
    "a flat lens": [*lens(1e4, 0.4)],
    "a meniscus": [lens(1.3, 0.4)[0], lens(1.1, 0.4)[0]],
    "a ball in two zones and a belt": [ball(0, 1, mu_max=-0.3), ball(0, 1, mu_min=-0.3, mu_max=0.5), ball(0, 1, mu_min=0.5)],
    "zones of one ball about unlike axes": [ball(0, 1, mu_min=0.5), tp.Sphere(center=at(0), axis=BACK[::-1], radius=1, mu_min=0.8)],
    "a tetrahedron": [tp.Triangle(vertices=corners) for corners in itertools.combinations(CORNERS, 3)],
    "planes apart": [tp.Plane(), tp.Plane(center=(0, 0, 1), normal=(0, 0, -1)), *tp.Slab(center=(0, 0, 5), thickness=1).planes()],
    "a mesh in a ball": [tp.Mesh.box(size=1), tp.Sphere(radius=0.7)],
}  # fmt: skip
DISJOINT = {
    "a tube in a tube": [tube(), tube(radius=0.5, height=3)],
    "a ball in a tube": [tube(), ball(0.2, 0.6)],
    "a tube beyond the apex of a cone": [tube(radius=0.5, height=1, middle=3), cone(1, 0, 0, 2)],
    "balls' caps whose spheres do not meet": [ball(0, 1, mu_min=0.9), ball(5, 1, mu_max=-0.9)],
    "a tube in a ball": [tube(), ball(0, 1.3)],
    "a ball and its lens": [ball(0, 2), *lens(1.3, 0.4)],
    "a plate above a tube": [tube(), plate(1.1)],
    "a plate beside a tilted tube": [tube(axis=(1, 0, 0)), tp.Rectangle(center=at(1.0), normal=AXIS, width=4, height=4)],
    "a ball over a plane": [tp.Plane(), tp.Sphere(center=(0, 0, 1.1), radius=1)],
    "triangles in two planes": [tp.Triangle(vertices=CORNERS[:3]), tp.Triangle(vertices=[(0.8, 0.8, -1), (0.8, 0.8, 1), (0.9, 0.7, 0)])],
}  # fmt: skip
CONTACTS = {
    "a tube on a plate": [tube(), plate(1)],
    "a tube through a plate": [tube(), plate(0.3)],
    "a tube on a larger disk": [tube(), disk(1, 0.8)],
    "a tube on a plane": [tube(), tp.Plane(center=at(-1), normal=BACK)],
    "a tube on a small hole": [tube(), plate(1, hole=0.6)],
    "a baffle in a tube": [tube(), disk(0.3, 0.7, inner_radius=0.2)],
    "a ball in a tube of its radius": [tube(), ball(0.2, 0.7)],
    "a ball at the end of a tube": [tube(), ball(1.0, 0.7)],
    "a ball through a tube": [tube(), ball(0.2, 0.9)],
    "a hemisphere in a tube": [tube(), ball(0.2, 0.7, mu_min=0)],
    "a cone in a tube": [tube(), cone(0.7, 0.1, -0.5, 0.5)],
    "a cone through a tube": [tube(), cone(0.5, 0.9, -0.5, 0.5)],
    "a cone with its tip on a disk": [cone(0, 0.5, 0, 1), disk(0, 0.5)],
    "two cones tip to tip": [cone(0.5, 0, -1, 0), cone(0, 0.5, 0, 1)],
    "a dish on a plane": [dish(), tp.Plane(center=at(0), normal=AXIS)],
    "a dish in a ball": [dish(), ball(0.2, 0.2)],
    "a dish through a tube": [dish(), tube(radius=0.3, middle=0.2)],
    "caps through one another": [lens(1.3, 0.4, -0.05)[0], lens(1.3, 0.4, -0.05)[1]],
    "caps back to back": [ball(-1, 1, mu_min=0.5), ball(1, 1, mu_max=-0.5)],
    "skew tubes": [tube(), tube(radius=0.2, height=5, axis=(1, 0, 0))],
    "a tube through a tilted plate": [tube(), tp.Rectangle(center=at(0), width=1, height=1)],
    "a ball on a plane": [tp.Plane(), tp.Sphere(center=(0, 0, 1), radius=1)],
    "planes": [tp.Plane(), tp.Plane(normal=(1, 1, 1))],
    "triangles": [tp.Triangle(vertices=CORNERS[:3]), tp.Triangle(vertices=[(0.2, 0.2, -1), (0.2, 0.3, 1), (0.3, 0.2, 1)])],
    "a triangle with its corner on another": [tp.Triangle(vertices=CORNERS[:3]), tp.Triangle(vertices=[(0.2, 0.2, 0), (0.2, 0.3, 1), (0.3, 0.2, 1)])],
}  # fmt: skip


def contacts(shapes):
    return set(contact_pairs(shapes))


@pytest.mark.parametrize("shapes", [*EDGES_ONLY.values(), *DISJOINT.values()], ids=[*EDGES_ONLY, *DISJOINT])
def test_edges_alone_are_no_contact(shapes):
    assert contacts(shapes) == contacts(shapes[::-1]) == set()


@pytest.mark.parametrize("shapes", CONTACTS.values(), ids=CONTACTS)
def test_a_surface_that_comes_inside_of_another_is_a_contact(shapes):
    assert contacts(shapes) == contacts(shapes[::-1]) == {(0, 1), (1, 0)}


def test_a_place_far_off_and_another_unit_do_not_matter():
    for scale, shift in ((1e-9, 0.0), (1e9, 0.0), (1.0, 1e4)):

        def moved(height, shift=shift, scale=scale):
            return tuple(scale * x + shift for x in at(height))

        side = tp.Cylinder(center=moved(0), axis=AXIS, radius=0.7 * scale, height=2 * scale)
        lid = tp.Disk(center=moved(1), normal=AXIS, radius=0.7 * scale)
        assert contacts([side, lid]) == set()
        assert contacts([side, tp.Disk(center=moved(1), normal=AXIS, radius=0.8 * scale)]) == {(0, 1), (1, 0)}


# ---- lines and media ----

LAMP = tp.Source(tp.Point(position=(0, 0, -50)), tp.Isotropic(power=1))
GLASS, WATER = tp.Dielectric(1.5), tp.Dielectric(1.33)
TILT = (1.0, 2.0, -0.5)


def lines(count, reach=2.0, center=(0.0, 0.0, 0.0)):
    """Isotropic lines through a ball."""
    rng = np.random.default_rng(11)
    u = rng.normal(size=(2, count, 3))
    directions = u[0] / np.linalg.norm(u[0], axis=1)[:, None]
    places = u[1] / np.linalg.norm(u[1], axis=1)[:, None] * reach * rng.random((count, 1)) ** (1 / 3)
    return places + np.array(center), directions


def uniform_lines(count, radius, center):
    """Isotropic lines, those of each direction uniform over a disk of that radius across it."""
    rng, directions = np.random.default_rng(12), lines(count)[1]
    e_u = np.cross(directions, np.eye(3)[np.argmin(np.abs(directions), axis=1)])
    e_u /= np.linalg.norm(e_u, axis=1)[:, None]
    rho, turn = radius * np.sqrt(rng.random(count)), 2 * math.pi * rng.random(count)
    shift = np.cos(turn)[:, None] * e_u + np.sin(turn)[:, None] * np.cross(directions, e_u)
    return rho[:, None] * shift + np.array(center), directions


# ---- crossings ----


def mesh(turned=0):
    """A ball of triangles, of which some have their normals inwards."""
    ball = tp.Mesh.sphere(radius=1, triangles=320)
    faces = ball.faces.copy()
    faces[:turned] = faces[:turned, ::-1]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tp.MeshWarning)
        return tp.Mesh(vertices=ball.vertices, faces=faces)


CENTER = (0.1, -0.2, 0.3)
SHAPES = {
    "rectangle": tp.Rectangle(center=CENTER, normal=TILT, width=2, height=1),
    "frame": tp.Rectangle(center=CENTER, normal=TILT, width=2, height=1, hole=tp.Disk(center=CENTER, normal=TILT, radius=0.3)),
    "disk": tp.Disk(center=CENTER, normal=TILT, radius=1),
    "annulus": tp.Disk(center=CENTER, normal=TILT, radius=1, inner_radius=0.7),
    "triangle": tp.Triangle(vertices=[(0, 0, 0), (1, 0.2, 0.1), (0.3, 1, -0.4)]),
    "sphere": tp.Sphere(center=CENTER, radius=1),
    "zone": tp.Sphere(center=CENTER, radius=1, axis=TILT, mu_min=-0.2, mu_max=0.6),
    "cylinder": tp.Cylinder(center=CENTER, axis=TILT, radius=0.7, height=1),
    "cone": tp.Cone(center=CENTER, axis=TILT, radius=0.7, height=1),
    "frustum": tp.Cone(center=CENTER, axis=TILT, radius=0.7, top_radius=0.6, height=1),
    "paraboloid": tp.Paraboloid(center=CENTER, axis=TILT, focal_length=0.3, radius=1, inner_radius=0.1),
    "box": tp.Box(center=CENTER, size=(1, 0.5, 0.8)),
    "mesh": mesh(),
}  # fmt: skip


@pytest.mark.quick_cases("rectangle", "frame")
@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_lines_cross_a_shape_as_often_as_its_area_says(shape):
    """Uniform isotropic lines through a ball of radius r cross an area A/(2 pi r^2) times in the mean (Cauchy, Crofton).

    5 standard errors: a false alarm in 10^6 seeds, and a fifth of the crossings lost would be seen.
    """
    r, count = 1.5, 6000 if isinstance(shape, tp.Mesh) else 60_000
    found = np.isfinite(crossings(shape, *uniform_lines(count, r, CENTER)).distances).sum(axis=1)
    exact, limit = shape.area / (2 * math.pi * r * r), 5 * found.std() / math.sqrt(count)
    assert abs(found.mean() - exact) < limit < abs(0.8 * found.mean() - exact)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_crossings_lie_on_the_shape_and_know_its_normal(shape):
    places, directions = lines(300, center=CENTER)
    found = crossings(shape, places, directions)
    assert (np.diff(found.distances, axis=1)[~np.isnan(found.distances[:, 1:])] >= 0).all()
    line, k = np.nonzero(np.isfinite(found.distances))
    points = places[line] + found.distances[line, k][:, None] * directions[line]
    assert max(shape.distance(tuple(point)) for point in points) < 1e-13
    assert set(found.sides[line, k]) == {-1.0, 1.0}
    for point, way, side in zip(points, directions[line], found.sides[line, k], strict=True):
        if shape.is_closed:
            ahead = tuple(point + 1e-6 * way)
            is_inside = (
                shape.holds(ahead) if isinstance(shape, tp.Mesh) else shape.distance(ahead, filled=True) == 0
            )
            assert is_inside == (side < 0)
        elif isinstance(shape, (tp.Rectangle, tp.Disk, tp.Triangle)):
            assert side == math.copysign(1, way @ np.array(shape.normal))
        else:
            offset = point - np.array(shape.center)
            away = offset - (offset @ np.array(shape.axis)) * np.array(shape.axis)
            normal = tilted(shape, away, offset @ np.array(shape.axis))
            assert side == math.copysign(1, way @ normal)


def tilted(shape, away, height):
    """A normal of a surface of revolution from its radius by height, by differences."""
    slopes = {
        tp.Cylinder: lambda rho: 0.0,
        tp.Cone: lambda rho: (shape.top_radius - shape.radius) / shape.height,
        tp.Paraboloid: lambda rho: 2 * shape.focal_length / rho,
        tp.Sphere: lambda rho: -height / rho,
    }
    rho = np.linalg.norm(away)
    return away / rho - slopes[type(shape)](rho) * np.array(shape.axis)


def test_endless_shapes_are_crossed_by_all_lines():
    places, directions = lines(100)
    plane = crossings(tp.Plane(center=(0, 0, 1), normal=TILT), places, directions)
    assert plane.distances.shape == (100, 1) and np.isfinite(plane.distances).all()
    slab = crossings(tp.Slab(normal=TILT, thickness=0.5), places, directions)
    thickness = np.diff(slab.distances, axis=1)[:, 0] * np.abs(directions @ TILT) / np.linalg.norm(TILT)
    assert thickness == pytest.approx(0.5) and (slab.sides == [-1, 1]).all()


def test_lines_that_miss_a_shape_have_no_crossings():
    away = np.array([[10.0, 10.0, 10.0]]), np.array([[0.0, 0.0, 1.0]])
    for shape in SHAPES.values():
        assert crossings(shape, *away).distances.shape == (1, 0)
    both = np.array([[0.0, 0.0, 0.0], [10.0, 10.0, 10.0]]), np.array([[0.0, 0.0, 1.0]] * 2)
    found = crossings(tp.Sphere(radius=1), *both)
    assert found.distances[0].tolist() == [-1, 1] and np.isnan(found.distances[1]).all()
    with pytest.raises(TypeError, match="Point"):
        crossings(tp.Point(), *away)


# ---- media ----


def glass_ball(radius, x=0.0, material=GLASS, name=None):
    return tp.Surface(tp.Sphere(center=(x, 0, 0), radius=radius), material, name)


def glass_cap(z, sign, radius=1.0, sine=0.5):
    """A cap of a ball whose rim, of radius `sine` at z, bulges to the side of the sign."""
    cosine = math.sqrt(radius**2 - sine**2)
    bounds = {"mu_min": cosine / radius} if sign > 0 else {"mu_max": -cosine / radius}
    return tp.Surface(tp.Sphere(center=(0, 0, z - sign * cosine), radius=radius, **bounds), GLASS)


def cube(size, material=GLASS, center=(0.0, 0.0, 0.0)):
    return tp.Surface(tp.Box(center=center, size=size), material)


def pane(z, sign, material=GLASS, width=1.0):
    return tp.Surface(
        tp.Rectangle(center=(0, 0, z), normal=(0, 0, sign), width=width, height=width), material
    )


OVERLAPPING = {
    "balls": [glass_ball(1, name="left"), glass_ball(1, 1.5)],
    "balls of one glass": [glass_ball(1, name="left"), glass_ball(0.5, 1.4)],
    "ball through a box": [glass_ball(1, name="left"), cube(1.5)],
    "box over a ball": [glass_ball(1, name="left"), cube((0.5, 0.5, 3))],
    "boxes": [tp.Surface(tp.Box(size=1), GLASS, "left"), cube(1, center=(0.9, 0.9, 0.9))],
    "a crossed pair": [tp.Surface(tp.Box(size=(3, 1, 1)), GLASS, "left"), cube((1, 3, 0.5))],
    "dusty balls": [
        glass_ball(1, name="left", material=tp.Mixture({GLASS: 0.5, tp.Black(): 0.5})),
        glass_ball(1, 1.5),
    ],
}


@pytest.mark.parametrize("surfaces", OVERLAPPING.values(), ids=OVERLAPPING)
def test_overlapping_media_are_refused_by_name(surfaces):
    words = "Surface 'left' and surfaces[1] are overlapping media; move them apart"
    assert_refused(lambda: tp.Scene([LAMP], surfaces), words)


CONTRADICTIONS = {
    "a ball in a ball": [glass_ball(1), glass_ball(0.5, material=WATER)],
    "a grain in a ball": [glass_ball(100), glass_ball(0.005, 20, material=WATER)],
    "a box in a ball": [glass_ball(1), cube(0.5, WATER)],
    "a ball in a box": [cube(1), glass_ball(0.3, material=WATER)],
    "a bubble inside out": [glass_ball(1), glass_ball(0.5, material=tp.Dielectric(1.5, 1.0))],
    "a dusty bubble": [glass_ball(1), glass_ball(0.5, material=tp.Mixture({WATER: 0.5, tp.Black(): 0.5}))],
    "a forgotten gap": [
        cube(1),
        glass_ball(0.501, material=tp.Dielectric(1.33, 1.5), x=1.5),
        glass_ball(0.1, 1.5),
    ],
    "a mesh with some facets turned": [tp.Surface(mesh(turned=10), GLASS)],
    "a mesh in a mesh": [tp.Surface(mesh(), GLASS), tp.Surface(mesh().scaled(0.5), WATER)],
    "a mesh through a ball": [tp.Surface(mesh(), GLASS), glass_ball(1, 0.5)],
    "two meshes that overlap": [tp.Surface(mesh(), GLASS), tp.Surface(mesh().moved((0.5, 0, 0)), GLASS)],
    "a mesh inside out beside a ball": [tp.Surface(mesh().flipped(), GLASS), glass_ball(1, 3)],
    "a plate with both faces up": [pane(0, 1), pane(-0.1, 1)],
    "water on a plate": [pane(0, 1), pane(-0.1, -1), pane(0.1, 1, WATER)],
    "planes": [tp.Surface(tp.Plane(center=(0, 0, z)), GLASS) for z in (0, -1)],
    "a slab in a slab": [tp.Surface(tp.Slab(thickness=1), GLASS), tp.Surface(tp.Slab(thickness=0.5), WATER)],
    "a lens with a face turned": [glass_cap(0, 1), tp.Surface(mesh().scaled(0.05), GLASS)],
}


@pytest.mark.quick_cases("a ball in a ball", "a grain in a ball")
@pytest.mark.parametrize("surfaces", CONTRADICTIONS.values(), ids=CONTRADICTIONS)
def test_contradicting_media_are_refused_by_name_and_indices(surfaces):
    named = [tp.Surface(s.shape, s.material, f"part {k}") for k, s in enumerate(surfaces)]
    words = ["contradicting media", "light leaves Surface 'part", "reaches Surface 'part", "index 1"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tp.MeshWarning)
        message = assert_refused(lambda: tp.Scene([LAMP], named), [*words, "reverse normals"])
    assert message.count("Surface 'part") == 2


BARE = tp.Dielectric(1.33, 1.5)
CONSISTENT = {
    "balls apart": [glass_ball(1), glass_ball(1, 3)],
    "balls that touch": [glass_ball(1), glass_ball(1, 2)],
    "a ball in a ball": [glass_ball(1), glass_ball(0.5, material=BARE), glass_ball(0.2, material=tp.Dielectric(1.0, 1.33))],
    "a ball that touches from inside": [glass_ball(1), glass_ball(0.5, 0.5, material=BARE)],
    "one index everywhere": [glass_ball(1, material=tp.Dielectric(1.5, 1.5)), glass_ball(1, 1.5, material=tp.Dielectric(1.5, 1.5))],
    "a bubble in a box": [cube(1), glass_ball(0.3, material=tp.Dielectric(1.0, 1.5))],
    "a mesh": [tp.Surface(mesh(), GLASS)],
    "a bubble in a mesh": [tp.Surface(mesh(), GLASS), glass_ball(0.5, material=tp.Dielectric(1.0, 1.5))],
    "a lens of two caps": [glass_cap(0, 1), glass_cap(0, -1)],
    "a thick lens with a black rim": [glass_cap(0.05, 1), glass_cap(-0.05, -1), tp.Surface(tp.Cylinder(radius=0.5, height=0.1), tp.Black())],
    "a doublet": [
        glass_cap(0, 1),
        tp.Surface(tp.Disk(radius=0.5), tp.Dielectric(1.7, 1.5)),
        tp.Surface(tp.Cylinder(center=(0, 0, -0.1), radius=0.5, height=0.2), tp.Dielectric(1.7)),
        tp.Surface(tp.Disk(center=(0, 0, -0.2), normal=(0, 0, -1), radius=0.5), tp.Dielectric(1.7)),
    ],
    "a plate": [pane(0, 1), pane(-0.1, -1)],
    "water on glass": [pane(0, 1, tp.Dielectric(1.5, 1.33)), pane(-0.1, -1), pane(0.1, 1, WATER)],
    "a wall between": [glass_ball(1), tp.Surface(tp.Sphere(radius=0.7), tp.Mirror(0.9)), glass_ball(0.5, material=WATER)],
    "a mesh between": [glass_ball(1), tp.Surface(mesh().scaled(0.7), tp.Black()), glass_ball(0.5, material=WATER)],
    "a lens in the way": [glass_ball(1), tp.Surface(tp.Disk(radius=0.5), tp.ThinLens(1)), glass_ball(0.1, material=tp.Dielectric(1, 1.5))],
    "planes": [tp.Surface(tp.Plane(), GLASS), tp.Surface(tp.Plane(center=(0, 0, -1), normal=(0, 0, -1)), GLASS)],
    "boxes edge to edge": [cube(1), cube(1, center=(1, 1, 0)), cube(1, center=(1, 1, 1.5))],
}  # fmt: skip


@pytest.mark.quick_cases("balls apart", "balls that touch")
@pytest.mark.parametrize("surfaces", CONSISTENT.values(), ids=CONSISTENT)
def test_media_that_agree_are_accepted(surfaces):
    tp.Scene([LAMP], surfaces)


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_nothing_depends_on_the_unit_of_length(scale):
    lamp = tp.Source(tp.Point(position=(0, 0, 5 * scale)), tp.Isotropic(power=1))
    tp.Scene([lamp], [glass_ball(scale), glass_ball(scale / 2, material=BARE)])
    for other, word in (
        (glass_ball(scale / 2, material=WATER), "contradicting"),
        (glass_ball(scale, scale), "overlapping"),
    ):
        assert_refused(lambda other=other: tp.Scene([lamp], [glass_ball(scale), other]), word)


@pytest.mark.slow
def test_the_check_takes_no_time():
    """A hundred thousand facets, three hundred balls: a fraction of a second each; 3 s on a machine that is busy."""
    many = [glass_ball(0.4, material=GLASS)] + [
        tp.Surface(tp.Sphere(center=(k % 7, k // 7 % 7, k // 49 + 1), radius=0.4), GLASS) for k in range(300)
    ]
    for surfaces in (many, [tp.Surface(tp.Mesh.sphere(radius=1, triangles=100_000), GLASS)]):
        scene = tp.Scene([LAMP], surfaces)
        start = time.process_time()
        check_media(scene)
        assert time.process_time() - start < 3


def test_a_lamp_that_hides_the_glass_from_some_of_its_places_knows_the_index_around_it():
    """By symmetry the picture's sum is that of a lamp on the other side, of which the first place sees the glass."""
    glass = tp.Surface(tp.Sphere(center=(0, 0, 0.6), radius=0.3), tp.Dielectric(1.5), "glass")
    floor = tp.Surface(tp.Rectangle(width=4, height=4), tp.Diffuse(0.7), "floor")
    camera = tp.Camera(
        name="view", position=(0, -1.6, 1.2), look_at=(0, 0, 0), field_of_view=1.0, pixels=(4, 3)
    )

    def seen(x):
        lamp = tp.Surface(tp.Sphere(center=(x, 0, 1.2), radius=0.15), tp.Diffuse(0.5), "lamp")
        source = tp.Source("lamp", tp.Lambertian(radiance=30.0))
        scene = tp.Scene(source, [floor, lamp, glass], camera)
        view = tp.simulate(scene, 2e5, seed=2 if x > 0 else 3, progress=False)["view"]
        return view.radiance.sum("u").sum("v")

    assert_agrees(seen(1.2) - seen(-1.2), 0)


@pytest.mark.parametrize("estimator", ["analog", "backward"])
def test_a_lamp_that_is_partly_in_glass_is_refused(estimator):
    """It would emit into the index of the first of its places, and lose or gain light in the other."""
    glass = tp.Surface(tp.Sphere(radius=0.5), tp.Dielectric(1.5), "glass")
    lamp = tp.Source(
        tp.Rectangle(center=(0.4, 0, 0), normal=(0, 1, 0.3), width=1, height=1), tp.Lambertian(radiance=1.0)
    )
    scene = tp.Scene(lamp, glass, tp.Detector(tp.Sphere(radius=2.0), "all", side="back"))
    with pytest.raises(
        tp.SceneError, match=r"shape must lie in one medium, .* of the indices 1\.0 and 1\.5; divide it"
    ):
        tp.simulate(scene, 1000, estimator=estimator, progress=False)
