"""Shapes in pictures: their facets have the shapes' areas and normals, and a lit spot lies in the cell that counted it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from transport.viz.facets import facets_of, half_box
from transport.viz.painted import paint_of

TILTED = (1.0, 2.0, 3.0)
ROUNDED = 1e-3  # what flat facets leave out of a round shape, at most; steps of 3 degrees leave out 6e-4
SHAPES = {
    "rectangle": (tp.Rectangle(width=2, height=1, normal=TILTED), tp.Positions(u=5, v=3)),
    "disk": (tp.Disk(radius=2, normal=TILTED, up=(1, 0, 0)), tp.Positions(u=3, v=5)),
    "annulus": (tp.Disk(radius=2, inner_radius=0.5), tp.Positions(u=(0.6, 1.1, 1.2), v=(0.0, 1.0, 2.5))),
    "sphere": (tp.Sphere(radius=2, axis=TILTED), tp.Positions(u=4, v=6)),
    "zone": (tp.Sphere(radius=2, mu_min=-0.3, mu_max=0.8, axis=TILTED), tp.Positions(u=3, v=4)),
    "cylinder": (tp.Cylinder(radius=1, height=3, axis=(1, 0, 0)), tp.Positions(u=4, v=3)),
    "frustum": (tp.Cone(radius=1, top_radius=0.9, height=2, axis=TILTED), tp.Positions(u=4, v=3)),
    "cone": (tp.Cone(radius=0, top_radius=1.5, height=2), tp.Positions(u=4)),
    "paraboloid": (tp.Paraboloid(focal_length=0.5, radius=1, inner_radius=0.2), tp.Positions(u=4, v=2)),
}
PLAIN = {
    "box": tp.Box(size=(1, 2, 3)),
    "triangle": tp.Triangle(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 1))),
    "mesh": tp.Mesh.sphere(radius=1, triangles=80),
    "round hole": tp.Rectangle(width=2, height=1, hole=tp.Disk(center=(0.2, 0.1, 0), radius=0.2)),
    "turned hole": tp.Rectangle(
        width=2, height=1, hole=tp.Rectangle(center=(0.2, 0.1, 0), width=0.3, height=0.5, up=(1, 1, 0))
    ),
}


def areas_of(facets):
    return np.linalg.norm(facets.vector_areas, axis=1)


@pytest.mark.parametrize("name", SHAPES)
def test_cells_have_the_areas_of_the_bins(name):
    shape, positions = SHAPES[name]
    facets = facets_of(shape, positions)
    inside = facets.bins >= 0
    found = np.bincount(facets.bins[inside], areas_of(facets)[inside])
    np.testing.assert_allclose(found, positions.areas(shape).ravel(), rtol=ROUNDED)
    assert math.isclose(areas_of(facets).sum(), shape.area, rel_tol=ROUNDED)
    assert areas_of(facets_of(shape)).sum() <= shape.area * (1 + 1e-12)


@pytest.mark.parametrize("name", PLAIN)
def test_plain_shapes_have_their_areas(name):
    shape = PLAIN[name]
    assert math.isclose(areas_of(facets_of(shape)).sum(), shape.area, rel_tol=ROUNDED)


@pytest.mark.parametrize("name", SHAPES | PLAIN)
def test_normals_are_those_of_the_shapes(name):
    shape = (SHAPES | {key: (each, None) for key, each in PLAIN.items()})[name][0]
    facets = facets_of(shape)
    normals = facets.vector_areas / areas_of(facets)[:, None]
    if hasattr(shape, "normal"):
        np.testing.assert_allclose(normals, np.broadcast_to(shape.normal, normals.shape), atol=1e-12)
        return
    axis = np.array(getattr(shape, "axis", (0, 0, 1)))
    away = facets.centres - np.array(shape.middle)
    if hasattr(shape, "axis"):  # surfaces of revolution: away from the axis
        away = facets.centres - np.array(shape.center)
        away = away - (away @ axis)[:, None] * axis
    assert ((normals * away).sum(axis=1) > 0).all()


def test_a_plane_is_cut_to_the_box():
    """The plane x + y + z = 0 meets the cube in a hexagon with sides of sqrt 2."""
    bounds = (np.full(3, -1.0), np.full(3, 1.0))
    facets = facets_of(tp.Plane(normal=(1, 1, 1)), bounds=bounds)
    assert math.isclose(areas_of(facets).sum(), 3 * math.sqrt(3))
    assert (facets.vector_areas @ np.ones(3) > 0).all()
    assert len(facets_of(tp.Plane(center=(0, 0, 2)), bounds=bounds).faces) == 0
    faces = facets_of(tp.Slab(thickness=1.0), bounds=bounds)
    assert math.isclose(areas_of(faces).sum(), 8.0)
    np.testing.assert_allclose(faces.vector_areas.sum(axis=0), 0, atol=1e-12)


def test_a_half_space_is_drawn_as_what_the_box_has_of_it():
    """Behind x + y + z = 0 lies half of the cube's walls; behind z = 0.5 the lower ones."""
    bounds = (np.full(3, -1.0), np.full(3, 1.0))
    slanted = half_box(tp.Plane(normal=(1, 1, 1)), bounds)
    assert math.isclose(areas_of(slanted).sum(), 12.0)
    assert (slanted.points.sum(axis=1) <= 1e-12).all()
    level = tp.Plane(center=(0, 0, 0.5))
    assert math.isclose(areas_of(half_box(level, bounds)).sum(), 4 + 4 * 2 * 1.5)
    above = half_box(level, bounds, is_behind=False)
    assert math.isclose(areas_of(above).sum(), 4 + 4 * 2 * 0.5)
    assert ((above.centres * above.vector_areas).sum(axis=1) > 0).all()
    assert len(half_box(tp.Plane(center=(0, 0, -2)), bounds).faces) == 0


SPOTS = {  # of each shape a place (u, v) and the way of a thin beam that meets it there
    "rectangle": (0.55, -0.31, "front"),
    "rectangle from behind": (0.55, -0.31, "back"),
    "disk": (1.7, 4.0, "front"),
    "disk from behind": (1.7, 4.0, "back"),
    "sphere": (0.4, 1.3, "front"),
    "zone": (1.2, 5.1, "back"),
    "cylinder": (-1.2, 2.9, "back"),
    "frustum": (0.7, 3.3, "front"),
    "paraboloid": (0.2, 2.0, "front"),
}


@pytest.mark.parametrize("name", SPOTS)
def test_a_lit_spot_is_drawn_where_it_is(name):
    """The engine counts a pencil of light in one bin; the facets of that bin hold the place that it meets."""
    u, v, side = SPOTS[name]
    shape, _ = SHAPES[name.partition(" ")[0]]
    place, normal = spot_of(shape, u, v)
    way = -normal if side == "front" else normal
    positions = tp.Positions(u=7, v=9)
    source = tp.Source(tp.Point(position=place - 0.05 * way), tp.Beam(tuple(way), power=1.0))
    scene = tp.Scene(source, detectors=tp.Detector(shape, "meter", side=side, positions=positions))
    paint = paint_of(tp.simulate(scene, particles=64, batches=2)["meter"])
    assert (paint.hits > 0).sum() == 1 and paint.hits.sum() == 64
    facets = facets_of(shape, positions)
    on = paint.on(facets.bins)
    lit = facets.centres[on["hits"] > 0]
    far = np.linalg.norm(facets.centres - place, axis=1)
    assert on["hits"][far.argmin()] == 64
    assert (np.linalg.norm(lit - place, axis=1) < 0.7 * shape.extent).all()
    area = np.linalg.norm(facets.vector_areas, axis=1)[on["hits"] > 0].sum()
    assert math.isclose(on["irradiance"][far.argmin()] * area, 1.0, rel_tol=ROUNDED)


def spot_of(shape, u, v):
    """Where (u, v) is, and the normal there, by the words of Positions."""
    e_u, e_v, n = (np.array(axis) for axis in shape.frame)
    center = np.array(shape.center)
    if isinstance(shape, tp.Rectangle):
        return center + u * e_u + v * e_v, n
    outwards = math.cos(v) * e_u + math.sin(v) * e_v
    if isinstance(shape, tp.Disk):
        return center + u * outwards, n
    if isinstance(shape, tp.Sphere):
        normal = math.sin(u) * outwards + math.cos(u) * n
        return center + shape.radius * normal, normal
    rho = shape.profile.radius_at(u - shape.profile.lift)
    step = 1e-6
    slope = (shape.profile.radius_at(u + step - shape.profile.lift) - rho) / step
    return center + rho * outwards + u * n, (outwards - slope * n) / math.hypot(1, slope)
