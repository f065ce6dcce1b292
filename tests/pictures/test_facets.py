"""Shapes as facets: areas and normals are those of the shapes, a lit spot lies in its cell, lobes point at the light."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from transport.viz.directions import direction_bins
from transport.viz.facets import as_polydata, facets_of, half_box, level_lines, outline, places_on
from transport.viz.lobes_in_place import corner_means, hemisphere, lobe, place_and_frame
from transport.viz.scene_parts import paint_of

TILTED = (1.0, 2.0, 3.0)
ROUNDED = 1e-3  # what flat facets leave out of a round shape, at most; steps of 3 degrees leave out 6e-4
TURN = 2 * math.pi
CUBE = (np.full(3, -1.0), np.full(3, 1.0))
# fmt: off
SHAPES = {  # shape, positions, length of the outline
    "rectangle": (tp.Rectangle(width=2, height=1, normal=TILTED), tp.Positions(u=5, v=3), 6),
    "disk": (tp.Disk(radius=2, normal=TILTED, up=(1, 0, 0)), tp.Positions(u=3, v=5), 2 * TURN),
    "annulus": (tp.Disk(radius=2, inner_radius=0.5), tp.Positions(u=(0.6, 1.1, 1.2), v=(0.0, 1.0, 2.5)), 2.5 * TURN),
    "sphere": (tp.Sphere(radius=2, axis=TILTED), tp.Positions(u=4, v=6), 2 * TURN * 3),
    "zone": (tp.Sphere(radius=2, mu_min=-0.3, mu_max=0.8, axis=TILTED), tp.Positions(u=3, v=4), None),
    "cylinder": (tp.Cylinder(radius=1, height=3, axis=(1, 0, 0)), tp.Positions(u=4, v=3), 2 * TURN + 12),
    "frustum": (tp.Cone(radius=1, top_radius=0.9, height=2, axis=TILTED), tp.Positions(u=4, v=3), None),
    "cone": (tp.Cone(radius=0, top_radius=1.5, height=2), tp.Positions(u=4), 1.5 * TURN + 4 * 2.5),
    "paraboloid": (tp.Paraboloid(focal_length=0.5, radius=1, inner_radius=0.2), tp.Positions(u=4, v=2), None),
}
HOLED = {"width": 2, "height": 1}
TURNED = tp.Rectangle(center=(0.2, 0.1, 0), width=0.3, height=0.5, up=(1, 1, 0))
PLAIN = {
    "box": (tp.Box(size=(1, 2, 3)), None, 24),
    "triangle": (tp.Triangle(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 1))), None, 1 + math.sqrt(2) + math.sqrt(3)),
    "mesh": (tp.Mesh.sphere(radius=1, triangles=80), None, None),
    "round hole": (tp.Rectangle(**HOLED, hole=tp.Disk(center=(0.2, 0.1, 0), radius=0.2)), None, 6 + 0.2 * TURN),
    "turned hole": (tp.Rectangle(**HOLED, hole=TURNED), None, 6 + 1.6),
}
# fmt: on


def areas_of(facets):
    return np.linalg.norm(facets.vector_areas, axis=1)


def whole_area(facets):
    return areas_of(facets).sum()


@pytest.mark.parametrize("shape, positions, length", (SHAPES | PLAIN).values(), ids=SHAPES | PLAIN)
def test_facets_have_the_areas_the_normals_and_the_outline_of_the_shape(shape, positions, length):
    facets = facets_of(shape, positions)
    assert math.isclose(whole_area(facets), shape.area, rel_tol=ROUNDED)
    if positions is not None:
        assert whole_area(facets_of(shape)) <= shape.area * (1 + 1e-12)
        inside = facets.bins >= 0
        found = np.bincount(facets.bins[inside], areas_of(facets)[inside])
        np.testing.assert_allclose(found, positions.areas(shape).ravel(), rtol=ROUNDED)
    normals = facets.vector_areas / areas_of(facets)[:, None]
    if hasattr(shape, "normal"):
        np.testing.assert_allclose(normals, np.broadcast_to(shape.normal, normals.shape), atol=1e-10)
    else:
        away = facets.centres - np.array(getattr(shape, "center", shape.middle))
        if hasattr(shape, "axis"):  # a surface of revolution: away from the axis
            away = away - (away @ shape.axis)[:, None] * shape.axis
        assert ((normals * away).sum(axis=1) > 0).all()
    if length is not None:
        drawn = outline(shape).compute_cell_sizes()["Length"].sum()
        assert math.isclose(drawn, length, rel_tol=ROUNDED)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e11])
def test_outlines_know_no_unit_of_length(scale):
    shapes = {
        tp.Sphere(center=(3 * scale, 0, 0), radius=scale): 3 * TURN,
        tp.Box(center=(0, 9 * scale, 0), size=scale): 12,
        tp.Mesh.box(size=scale): 12,
        tp.Cone(radius=scale, top_radius=0, height=scale): TURN + 4 * math.sqrt(2),
    }
    for shape, length in shapes.items():
        drawn = outline(shape).compute_cell_sizes()["Length"].sum() / scale
        assert math.isclose(drawn, length, rel_tol=ROUNDED)


def test_a_plane_is_cut_to_the_box():
    """The plane x + y + z = 0 meets the cube in a hexagon with sides of sqrt 2; a slab leaves two squares."""
    hexagon = facets_of(tp.Plane(normal=(1, 1, 1)), bounds=CUBE)
    assert math.isclose(whole_area(hexagon), 3 * math.sqrt(3))
    assert (hexagon.vector_areas @ np.ones(3) > 0).all()
    assert len(facets_of(tp.Plane(center=(0, 0, 2)), bounds=CUBE).faces) == 0
    assert math.isclose(whole_area(facets_of(tp.Plane(center=(5, 5, 1)), bounds=CUBE)), 4.0)
    slab = facets_of(tp.Slab(thickness=1.0), bounds=CUBE)
    assert math.isclose(whole_area(slab), 8.0)
    np.testing.assert_allclose(slab.vector_areas.sum(axis=0), 0, atol=1e-12)


def test_a_half_space_is_drawn_as_its_part_of_the_box():
    """Behind x + y + z = 0 lies half of the cube's walls; behind z = 0.5 the lower ones."""
    slanted, level = half_box(tp.Plane(normal=(1, 1, 1)), CUBE), tp.Plane(center=(0, 0, 0.5))
    assert math.isclose(whole_area(slanted), 12.0)
    assert (slanted.points.sum(axis=1) <= 1e-12).all()
    assert math.isclose(whole_area(half_box(level, CUBE)), 4 + 4 * 2 * 1.5)
    below = half_box(level, CUBE)
    assert ((below.centres * below.vector_areas).sum(axis=1) > 0).all()
    assert len(half_box(tp.Plane(center=(0, 0, -2)), CUBE).faces) == 0


def test_a_ball_of_one_colour_has_level_lines_just_off_it():
    ball, disk = (
        as_polydata(facets_of(shape)) for shape in (tp.Mesh.sphere(radius=0.5), tp.Disk(radius=1.0))
    )
    radii = np.linalg.norm(level_lines(ball, 1e-3).points, axis=1)
    assert len(radii) > 200 and (np.abs(radii - 0.5) < 5e-3).all()
    assert level_lines(disk, 1e-3).n_points == 0


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
    step, height = 1e-6, u - shape.profile.lift
    rho = shape.profile.radius_at(height)
    slope = (shape.profile.radius_at(height + step) - rho) / step
    return center + rho * outwards + u * n, (outwards - slope * n) / math.hypot(1, slope)


@pytest.mark.parametrize("name, u, v, side", [
    ("rectangle", 0.55, -0.31, "front"), ("rectangle", 0.55, -0.31, "back"),
    ("disk", 1.7, 4.0, "front"), ("disk", 1.7, 4.0, "back"),
    ("sphere", 0.4, 1.3, "front"), ("zone", 1.2, 5.1, "back"), ("cylinder", -1.2, 2.9, "back"),
    ("frustum", 0.7, 3.3, "front"), ("paraboloid", 0.2, 2.0, "front"),
])  # fmt: skip
def test_a_lit_spot_is_drawn_where_it_is(name, u, v, side):
    """The engine counts a pencil of light in one bin; the facets of that bin hold the place that it meets."""
    shape = SHAPES[name][0]
    place, normal = spot_of(shape, u, v)
    np.testing.assert_allclose(places_on(shape, u, v), place, atol=1e-12)
    way = -normal if side == "front" else normal
    positions = tp.Positions(u=7, v=9)
    source = tp.Source(tp.Point(position=place - 0.05 * way), tp.Beam(tuple(way), power=1.0))
    scene = tp.Scene(source, detectors=tp.Detector(shape, "meter", side=side, positions=positions))
    paint = paint_of(tp.simulate(scene, particles=64, batches=2)["meter"])
    assert (paint.hits > 0).sum() == 1 and paint.hits.sum() == 64
    facets = facets_of(shape, positions)
    on = paint.on(facets.bins)
    distance = np.linalg.norm(facets.centres - place, axis=1)
    assert on["hits"][distance.argmin()] == 64
    assert (distance[on["hits"] > 0] < 0.7 * shape.extent).all()
    area = areas_of(facets)[on["hits"] > 0].sum()
    assert math.isclose(on["irradiance"][distance.argmin()] * area, 1.0, rel_tol=ROUNDED)


# ---- Lobes.

FINE = tp.Directions(theta=np.linspace(0, math.pi / 2, 19), phi=36)  # bins of 5 and 10 degrees
DISK = tp.Disk(normal=TILTED, radius=0.5, up=(1, 0, 0))
BALL = tp.Sphere(radius=1.0, axis=TILTED)


@pytest.mark.parametrize("shape, side, positions, at", [
    pytest.param(DISK, "front", None, (), id="tilted disk"),
    pytest.param(DISK, "back", None, (), id="from behind"),
    pytest.param(tp.Rectangle(normal=TILTED, width=2, height=1), "front", {"u": 4, "v": 3}, (3, 0), id="a corner"),
    pytest.param(BALL, "front", {"u": 12, "v": 24}, (3, 5), id="a ball"),
    pytest.param(BALL, "inside", {"u": 12, "v": 24}, (8, 17), id="in a ball"),
    pytest.param(tp.Cone(radius=1, top_radius=0.5, height=1), "front", {"u": 3, "v": 24}, (1, 9), id="a cone"),
])  # fmt: skip
def test_a_lobe_points_at_the_light(shape, side, positions, at):
    """A pencil of light from 40 degrees off the normal: the lobe's tip is in its bin, within 5 degrees and 10 / 2 sin 40."""
    positions = None if positions is None else tp.Positions(**positions)
    detector = tp.Detector(shape, "meter", side=side, positions=positions, directions=FINE)
    place, (e_u, e_v, n) = _stand(shape, detector, at)
    light = math.sin(0.7) * (math.cos(2.05) * e_u + math.sin(2.05) * e_v) + math.cos(0.7) * n
    source = tp.Source(tp.Point(position=place + 0.05 * light), tp.Beam(tuple(-light), power=1.0))
    reading = tp.simulate(tp.Scene(source, detectors=detector), particles=64, batches=2)["meter"]
    where, frame = place_and_frame(reading, at)
    np.testing.assert_allclose(where, place, atol=1e-12)
    radiance = reading.radiance[at] if at else reading.radiance
    drawn = lobe(direction_bins(radiance), where, frame, 2.0)
    colours = drawn.cell_data["radiance"]
    assert colours.max() == np.nanmax(radiance.value) > 0
    cells = np.flatnonzero(colours > 0)
    assert len(cells) == 2  # one bin of 10 degrees, in steps of 5
    tip = (drawn.points[np.unique(drawn.regular_faces[cells])] - where).mean(axis=0)
    assert tip @ light / np.linalg.norm(tip) > math.cos(math.radians(5))
    assert (np.linalg.norm(drawn.points - where, axis=1) <= 2.0 + 1e-12).all()


def _stand(shape, detector, at):
    """Place and frame of a side, found independently: from positions and the words of the design."""
    e_u, e_v, n = (np.array(axis) for axis in shape.frame)
    if detector.positions is None:
        place = np.array(shape.center)
    else:
        edges = detector.positions.edges(shape).values()
        u, v = ((e[k] + e[k + 1]) / 2 for k, e in zip(at, edges, strict=True))
        place, normal = spot_of(shape, u, v)
        if not isinstance(shape, tp.Rectangle):
            n, axis = normal, np.array(shape.axis)
            e_v = axis - (axis @ n) * n
            e_v /= np.linalg.norm(e_v)
            e_u = np.cross(e_v, n)
    return (place, (-e_u, e_v, -n)) if detector.is_back else (place, (e_u, e_v, n))


def test_an_even_glow_is_a_hemisphere():
    disk = tp.Disk(radius=1.0)
    detector = tp.Detector(disk, "leaving", directions=tp.Directions(mu=4))
    scene = tp.Scene(tp.Source(disk, tp.Lambertian(radiance=3.0)), detectors=detector)
    reading = tp.simulate(scene, particles=200_000, batches=8)["leaving"]
    place, frame = place_and_frame(reading)
    drawn = lobe(direction_bins(reading.radiance_out), place, frame, 1.0)
    radii = np.linalg.norm(drawn.points, axis=1)
    assert radii.min() > 0.97 and radii.max() <= 1 + 1e-12 and drawn.points[:, 2].min() > -1e-12
    wire = hemisphere(place, frame, 1.0)
    assert wire.points[:, 2].min() > -1e-12 and math.isclose(np.linalg.norm(wire.points, axis=1).max(), 1.15)


def test_a_shape_without_frame_and_a_missing_bin_of_place_are_refused():
    box = tp.Box(size=1.0)
    detector = tp.Detector(box, "box", directions=tp.Directions(mu=2))
    scene = tp.Scene(tp.Source(box, tp.Lambertian(radiance=1.0)), detectors=detector)
    reading = tp.simulate(scene, particles=100, batches=2)["box"]
    for at, message in (((), "Box has no frame"), ((0,), "at must name one bin")):
        with pytest.raises(ValueError, match=message):
            place_and_frame(reading, at)


def test_corners_are_means_across_the_seam_of_a_turn():
    cells = np.array([[4.0, 0.0, 0.0, 2.0]])
    np.testing.assert_allclose(corner_means(cells, True)[0], [3, 2, 0, 1, 3])
    np.testing.assert_allclose(corner_means(cells, False)[0], [4, 2, 0, 1, 2])
