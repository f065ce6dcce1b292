"""Which acting surfaces come inside of one another, and which share an edge only or are apart."""

import itertools
import math

import pytest

import transport as tp
from transport.geometry.contacts import contact_pairs
from transport.vectors import unit_vector

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
APART = {
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
INSIDE = {
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


@pytest.mark.parametrize("shapes", [*EDGES_ONLY.values(), *APART.values()], ids=[*EDGES_ONLY, *APART])
def test_edges_alone_are_no_contact(shapes):
    assert contacts(shapes) == contacts(shapes[::-1]) == set()


@pytest.mark.parametrize("shapes", INSIDE.values(), ids=INSIDE)
def test_what_comes_inside_of_another_is_a_contact(shapes):
    assert contacts(shapes) == contacts(shapes[::-1]) == {(0, 1), (1, 0)}


def test_a_place_far_off_and_another_unit_do_not_matter():
    for scale, shift in ((1e-9, 0.0), (1e9, 0.0), (1.0, 1e4)):

        def moved(height, shift=shift, scale=scale):
            return tuple(scale * x + shift for x in at(height))

        side = tp.Cylinder(center=moved(0), axis=AXIS, radius=0.7 * scale, height=2 * scale)
        lid = tp.Disk(center=moved(1), normal=AXIS, radius=0.7 * scale)
        assert contacts([side, lid]) == set()
        assert contacts([side, tp.Disk(center=moved(1), normal=AXIS, radius=0.8 * scale)]) == {(0, 1), (1, 0)}
