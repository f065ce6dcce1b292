"""Shapes on one support: which form a sheet, which overlap and are refused; every count right on them, to the last one."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import transport as tp
from tests.agreement import assert_agrees
from transport.geometry.relations import are_on_one_support, is_on_support, overlap, relative_orientation
from transport.results.detectors import BINS
from transport.results.tally import SIDES
from transport.scene.sheets import scene_sheets
from transport.vectors import unit_vector

BOX = tp.Box(size=2.0)
EXITANCE, ALBEDO = 3.0, 0.4
FURNACE = EXITANCE / (1 - ALBEDO)  # irradiance everywhere on the walls
FALSE_ALARM = 1e-5
AXIS = unit_vector((0.3, -0.2, 0.9))
BACK = tuple(-x for x in AXIS)
LAMP = tp.Source(tp.Point(position=(50, 60, 70)), tp.Isotropic(power=1))
angles = st.floats(0.01, math.pi - 0.01)


# ---- one support ----


def at(height):
    """A point of the axis of the shapes below."""
    return tuple(o + height * a for o, a in zip((0.1, 0.2, 0.3), AXIS, strict=True))


def frustum(low, high, slope=-0.5, middle=1.0):
    """A band of the cone rho = middle + slope w."""
    radii = {"radius": middle + slope * low, "top_radius": middle + slope * high}
    return tp.Cone(center=at((low + high) / 2), axis=AXIS, height=high - low, **radii)


def dish(inner, outer, focal_length=0.3):
    return tp.Paraboloid(center=at(0), axis=AXIS, focal_length=focal_length, inner_radius=inner, radius=outer)


def zone(low, high, axis=AXIS, **how):
    return tp.Sphere(**{"center": at(0), "radius": 0.7, "axis": axis, "mu_min": low, "mu_max": high} | how)


def tube(low, high, axis=AXIS, radius=0.7):
    return tp.Cylinder(center=at((low + high) / 2), axis=axis, radius=radius, height=high - low)


def lid(height, radius, inner_radius=0.0):
    normal = AXIS if height > 0 else BACK
    return tp.Disk(center=at(height), normal=normal, radius=radius, inner_radius=inner_radius)


E_U, E_V, _ = np.array(tube(0, 1).frame)
SAME = {  # pairs on one support
    "tubes end to end": (tube(-1, 0), tube(0, 3)),
    "tubes turned over": (tube(-1, 1), tube(0, 0.1, BACK)),
    "a band of a pointed cone": (frustum(-2, 2), frustum(0.5, 0.6)),
    "the tip of a cone": (frustum(-2, 1.9), frustum(1.9, 2)),
    "blunt and pointed": (frustum(-0.1, 0.1), frustum(0.5, 2)),
    "rings of a dish": (dish(0, 0.5), dish(0.5, 0.9)),
    "zones": (zone(-1, 0.5), zone(0.5, 1)),
    "zones of unlike axes": (zone(0.5, 1), zone(0.2, 0.4, (1, 0, 0))),
    "a zone and its ball": (zone(0.5, 1), zone(-1, 1)),
    "a plane and a disk": (tp.Plane(center=at(1), normal=AXIS), tp.Disk(center=at(1), normal=BACK, radius=2)),
    "a plane and a triangle": (tp.Plane(), tp.Triangle(vertices=((5, 6, 0), (-3, 1, 0), (0, 0, 0)))),
    "a disk and a triangle": (lid(1, 2), tp.Triangle(vertices=[np.add(at(1), c) for c in np.outer((1, -1, 0), E_U) + np.outer((0, 1, -1), E_V)])),
    "planes": (tp.Plane(), tp.Plane(center=(7, 8, 0), normal=(0, 0, -1))),
    "a mesh and itself": (tp.Mesh.box(size=2), tp.Mesh.box(size=2)),
}  # fmt: skip
UNLIKE = {
    "tubes of unlike radii": (tube(-1, 1), tube(-1, 1, radius=0.7 * (1 + 1e-13))),
    "tubes of unlike axes": (tube(-1, 1), tube(-1, 1, (0.3, -0.2, 0.9 + 1e-12))),
    "tubes beside one another": (tube(-1, 1), tp.Cylinder(center=(0.1 + 1e-13, 0.2, 0.3), axis=AXIS, radius=0.7, height=2)),
    "a tube and a ball through its rims": (tube(-1, 1), zone(-1, 1, radius=math.hypot(0.7, 1))),
    "a tube and a cone": (tube(-1, 1), frustum(-1, 1, slope=1e-12, middle=0.7)),
    "cones": (frustum(-1, 1), frustum(-1, 1, slope=-0.5 - 1e-12)),
    "the other branch of a cone": (frustum(-1, 2), tp.Cone(center=at(2.5), axis=AXIS, radius=0, top_radius=0.5, height=1)),
    "dishes": (dish(0, 0.5), dish(0, 0.5, focal_length=0.3 * (1 + 1e-13))),
    "balls": (zone(-1, 1), zone(-1, 1, radius=0.7 * (1 + 1e-13))),
    "balls apart": (zone(-1, 1), zone(-1, 1, center=(0.1 + 1e-13, 0.2, 0.3))),
    "planes apart": (tp.Plane(center=(0, 0, 1)), tp.Plane(center=(0, 0, 1 + 1e-13))),
    "planes tilted": (tp.Plane(), tp.Plane(normal=(0, 1e-13, 1))),
    "a plane and a lifted triangle": (tp.Plane(), tp.Triangle(vertices=((5, 6, 1e-13), (-3, 1, 1e-13), (0, 0, 1e-13)))),
    "a plane and a tilted disk": (tp.Plane(), tp.Disk(radius=1, normal=(0, 1e-13, 1))),
    "a plane and a ball": (tp.Plane(), zone(-1, 1)),
    "a disk and a tube": (tp.Disk(center=at(1), normal=AXIS, radius=0.7), tube(-1, 1)),
    "meshes": (tp.Mesh.box(size=2), tp.Mesh.box(size=1)),
    "a mesh and its face": (tp.Mesh.box(size=2), tp.Box(size=2).faces()["+z"]),
}  # fmt: skip


@pytest.mark.parametrize("pair", SAME.values(), ids=SAME)
def test_shapes_on_one_support_form_one_sheet(pair):
    assert all(are_on_one_support(*way) for way in (pair, pair[::-1]))
    looks = [tp.Detector(shape, name=str(k)) for k, shape in enumerate(pair)]
    assert [len(sheet.members) for sheet in scene_sheets(tp.Scene(LAMP, (), looks))] == [2]


def test_the_largest_band_gives_its_support_to_the_sheet():
    """A narrow one knows the slope of its cone less well; but what acts comes first."""
    narrow, wide = frustum(0.5, 0.5001), frustum(-2, 2)
    looks = [tp.Detector(shape, name=name) for name, shape in (("narrow", narrow), ("wide", wide))]
    [sheet] = scene_sheets(tp.Scene(LAMP, (), looks))
    assert sheet.support == wide
    [sheet] = scene_sheets(tp.Scene(LAMP, tp.Surface(narrow, tp.Black()), looks))
    assert [member.shape for member in sheet.members] == [narrow, wide, narrow]


@pytest.mark.parametrize("pair", UNLIKE.values(), ids=UNLIKE)
def test_shapes_that_differ_by_more_than_rounding_do_not(pair):
    assert not any(are_on_one_support(*way) for way in (pair, pair[::-1]))


def test_one_support_is_recognised_whatever_the_axis_and_the_place():
    """Bands given by radii that were rounded: of 300 cones, dishes and tubes none falls apart."""
    draws = np.random.default_rng(3)
    for _ in range(100):
        axis, center = (
            unit_vector(tuple(draws.normal(size=3))),
            draws.normal(size=3) * 10.0 ** draws.integers(-2, 3),
        )
        slope, size = draws.normal(), draws.uniform(0.1, 3)
        heights = np.sort(draws.uniform(0, 1, 4)) * size
        radii = size * (1.1 * abs(slope) + 0.1) + slope * heights
        on_axis = [
            center + w * np.array(axis)
            for w in ((heights[1] + heights[0]) / 2, (heights[2] + heights[3]) / 2)
        ]
        cones = [
            tp.Cone(
                center=c,
                axis=axis,
                radius=radii[k],
                top_radius=radii[k + 1],
                height=heights[k + 1] - heights[k],
            )
            for k, c in ((0, on_axis[0]), (2, on_axis[1]))
        ]
        tubes = [tp.Cylinder(center=c, axis=axis, radius=size, height=0.1 * size) for c in on_axis]
        dishes = [
            tp.Paraboloid(center=center, axis=axis, focal_length=size, inner_radius=p, radius=q)
            for p, q in itertools.pairwise(heights[:3])
        ]
        for pair in (cones, tubes, dishes):
            assert are_on_one_support(*pair)


def test_normals_on_one_support_point_alike_or_not():
    assert relative_orientation(tube(0, 1), tube(0, 1, BACK)) == 1  # outwards both
    assert relative_orientation(tp.Plane(), tp.Disk(normal=(0, 0, -1), radius=1)) == -1
    assert relative_orientation(*tp.Slab(thickness=1).planes()) == -1


def test_what_lies_on_a_support():
    """Also beyond the shape's rim, but not on the mirror image of a cone."""
    e_u, e_v, _ = tube(-1, 1).frame
    around = [math.cos(2) * u + math.sin(2) * v for u, v in zip(e_u, e_v, strict=True)]
    for shape, radius in (
        (tube(-1, 1), lambda w: 0.7),
        (frustum(-1, 1.5), lambda w: 1 - w / 2),
        (dish(0.1, 0.5), lambda w: math.sqrt(1.2 * w)),
        (zone(0.2, 0.4), lambda w: math.sqrt(0.49 - w * w)),
    ):
        for w in (0.05, 0.3, 0.65):
            for off, is_on in ((0, True), (1e-12, False), (-1e-12, False)):
                point = tuple(p + (radius(w) + off) * x for p, x in zip(at(w), around, strict=True))
                assert is_on_support(point, shape) == is_on
    mirrored = tuple(p + 0.5 * x for p, x in zip(at(3), around, strict=True))
    assert not is_on_support(mirrored, frustum(-1, 1.5)) and not is_on_support(mirrored, frustum(1, 2))
    assert is_on_support(at(2), frustum(-1, 1.5)) and is_on_support(at(2), frustum(1, 2))  # the apex
    assert is_on_support((1e3, -1e3, 0.5), tp.Plane(center=(0, 0, 0.5)))


SQUARE = tp.Rectangle(width=2, height=2)
FRAME = tp.Rectangle(width=2, height=2, hole=tp.Disk(radius=0.5))
WINDOW = tp.Rectangle(width=2, height=2, hole=tp.Rectangle(width=1, height=0.5, up=(1, 1, 0)))


def flat_triangle(*corners):
    return tp.Triangle(vertices=[(*corner, 0) for corner in corners])


RUGS = {  # shapes on one support: do they overlap
    "tubes end to end": (tube(-1, 0), tube(0, 3), False),
    "tubes that overlap": (tube(-1, 0), tube(-1e-9, 3), True),
    "tubes turned over": (tube(-1, 0), tube(0, 3, BACK), False),
    "tubes turned over that overlap": (tube(-1, 0.1), tube(0, 3, BACK), True),
    "bands of a cone": (frustum(-1, 0.5), frustum(0.5, 2), False),
    "bands of a cone that overlap": (frustum(-1, 0.6), frustum(0.5, 2), True),
    "rings of a dish": (dish(0, 0.5), dish(0.5, 0.9), False),
    "rings of a dish that overlap": (dish(0, 0.6), dish(0.5, 0.9), True),
    "zones": (zone(-1, 0.5), zone(0.5, 1), False),
    "zones that overlap": (zone(-1, 0.5), zone(0.49, 1), True),
    "zones from both poles": (zone(-1, 0.5), zone(-1, -0.5, BACK), False),
    "a ball and its zone": (zone(-1, 1), zone(0.5, 0.6, (1, 0, 0)), True),
    "planes": (tp.Plane(), tp.Plane(), True),
    "a plane and a disk": (tp.Plane(), tp.Disk(radius=1, center=(1e6, 0, 0)), True),
    "a mesh and itself": (tp.Mesh.box(size=1), tp.Mesh.box(size=1), True),
}
RUGS |= {
    "triangles of a square": (flat_triangle((0, 0), (1, 0), (1, 1)), flat_triangle((0, 0), (1, 1), (0, 1)), False),
    "triangles that overlap": (flat_triangle((0, 0), (1, 0), (1, 1)), flat_triangle((0.1, 0), (1, 1), (0, 1)), True),
    "a star": (flat_triangle((0, 0), (4, 0), (2, 3)), flat_triangle((0, 2), (4, 2), (2, -1)), True),
    "triangle beside": (flat_triangle((1, -3), (1, 3), (2, 0)), SQUARE, False),
    "triangle into a square": (flat_triangle((1 - 1e-9, -3), (1, 3), (2, 0)), SQUARE, True),
    "triangle round a corner": (flat_triangle((2.1, 0), (0, 2.1), (3, 3)), SQUARE, False),
    "triangle over a corner": (flat_triangle((1.9, 0), (0, 1.9), (3, 3)), SQUARE, True),
    "square within a triangle": (flat_triangle((-9, -9), (9, -9), (0, 9)), SQUARE, True),
    "triangle touches a disk": (flat_triangle((1, -3), (1, 3), (2, 0)), tp.Disk(radius=1), False),
    "triangle into a disk": (flat_triangle((0.999, -3), (1, 3), (2, 0)), tp.Disk(radius=1), True),
    "triangle in a ring": (flat_triangle((-0.4, 0), (0.4, 0), (0, 0.4)), tp.Disk(radius=1, inner_radius=0.4), False),
    "triangle out of a ring": (flat_triangle((-0.41, 0), (0.4, 0), (0, 0.4)), tp.Disk(radius=1, inner_radius=0.4), True),
    "disk in a hole": (FRAME, tp.Disk(radius=0.5), False),
    "disk beyond a hole": (FRAME, tp.Disk(radius=0.501), True),
    "ring about a hole": (FRAME, tp.Disk(radius=1.2, inner_radius=0.5), True),
    "triangle in a hole": (FRAME, flat_triangle((-0.5, 0), (0.5, 0), (0, 0.5)), False),
    "square in a round hole": (FRAME, tp.Rectangle(width=math.sqrt(0.5), height=math.sqrt(0.5), up=(1, 2, 0)), False),
    "square beyond a round hole": (FRAME, tp.Rectangle(width=0.8, height=0.8), True),
    "window pane": (WINDOW, tp.Rectangle(width=1, height=0.5, up=(-1, -1, 0)), False),
    "window pane the wrong way": (WINDOW, tp.Rectangle(width=1, height=0.5, up=(1, -1, 0)), True),
    "disk in a window": (WINDOW, tp.Disk(radius=0.25), False),
    "a frame in a window": (WINDOW, tp.Rectangle(width=0.5, height=0.5, up=(1, 1, 0), hole=tp.Disk(radius=0.1)), False),
    "frames": (FRAME, WINDOW, True),
}  # fmt: skip


@pytest.mark.parametrize(("one", "other", "expected"), RUGS.values(), ids=RUGS)
def test_acting_shapes_may_share_an_edge_only(one, other, expected):
    assert overlap(one, other) == overlap(other, one) == expected
    walls = [tp.Surface(shape, tp.Black(), name=name) for name, shape in (("one", one), ("other", other))]
    if expected:
        with pytest.raises(tp.SceneError, match=r"overlap on one \w+; let them share an edge"):
            tp.Scene(LAMP, walls)
    else:
        tp.Scene(LAMP, walls)


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(angles, angles, angles, angles, st.floats(0.05, math.pi - 0.05))
def test_zones_of_unlike_axes_overlap_where_a_point_lies_in_both(a, b, c, d, tilt):
    """Against a dense sample of the sphere, where the zones clearly overlap or are clearly apart."""
    bounds = [sorted(map(math.cos, pair)) for pair in ((a, b), (c, d))]
    if any(high - low < 1e-3 for low, high in bounds):
        return
    axes = ((0.0, 0.0, 1.0), (math.sin(tilt), 0.0, math.cos(tilt)))
    zones = [
        tp.Sphere(radius=2, axis=axis, mu_min=low, mu_max=high)
        for axis, (low, high) in zip(axes, bounds, strict=True)
    ]
    t, turn = np.meshgrid(np.linspace(0, math.pi, 361), np.linspace(0, math.pi, 181))
    heights = (np.cos(t), np.sin(t) * np.cos(turn) * math.sin(tilt) + np.cos(t) * math.cos(tilt))
    margin = 0.03
    found = {
        sign: all_in(heights, [(low - sign * margin, high + sign * margin) for low, high in bounds])
        for sign in (-1, 1)
    }
    if found[-1] == found[1]:
        assert overlap(*zones) == overlap(*zones[::-1]) == found[1]


def all_in(heights, bounds):
    """Whether a sample lies between all bounds."""
    return bool(
        np.logical_and.reduce(
            [(low < h) & (h < high) for h, (low, high) in zip(heights, bounds, strict=True)]
        ).any()
    )


# ---- meters on walls ----


def furnace(detectors, ceiling=None):
    """A closed box whose walls all emit and reflect alike: the irradiance is the same at every point."""
    faces = BOX.faces()
    whole = faces.pop("+z")
    patches = {"ceiling": whole} if ceiling is None else ceiling
    walls = [tp.Surface(shape, tp.Diffuse(ALBEDO), name=name) for name, shape in (faces | patches).items()]
    sources = [tp.Source(wall.name, tp.Lambertian(exitance=EXITANCE), side="back") for wall in walls]
    return tp.Scene(sources=sources, surfaces=walls, detectors=detectors)


def run(scene, particles=200_000):
    return tp.simulate(scene, particles=particles, seed=1)


def counted(reading):
    """Weights and counts of arrivals and departures of every batch."""
    return np.array(
        [[read(f"weight {side}") for read in (reading.sums, reading.counts_of)] for side in SIDES]
    )


def test_a_meter_of_the_shape_of_a_wall_counts_what_the_wall_counts():
    bins = tp.Directions(mu=8, phi=4)
    on_wall = tp.Detector("ceiling", side="back", directions=bins)
    over_wall = tp.Detector(BOX.faces()["+z"], name="meter", side="back", directions=bins)
    result = run(furnace([on_wall, over_wall]))
    one, other = result["ceiling"], result["meter"]
    for score in (f"{kind} {side}" for kind in ("weight", "count", "slant") for side in SIDES):
        for by in ((), BINS):  # with those outside all bins, and in each bin
            np.testing.assert_array_equal(one.sums(score, by), other.sums(score, by))
    assert result["ceiling"].counts.value.sum() > 10_000


@pytest.mark.parametrize("name", ["whole", "overhanging", "ring", "corner"])
def test_a_meter_on_a_wall_counts_the_part_that_lies_on_it(name):
    """The obvious way, remembering a surface and asking t > 0, counts 12 % of the arrivals on such a meter."""
    down = (0, 0, -1)
    shape, share = {
        "whole": (tp.Disk(center=(0.2, 0.1, 1), normal=down, radius=0.5), 1.0),
        "overhanging": (tp.Disk(center=(1, 0.1, 1), normal=down, radius=0.5), 0.5),
        "ring": (tp.Disk(center=(0, 0, 1), normal=down, radius=0.6, inner_radius=0.3), 1.0),
        "corner": (tp.Rectangle(center=(1, 1, 1), normal=down, width=0.8, height=1.2), 0.25),
    }[name]
    reading = run(furnace([tp.Detector(shape, name="meter")]))["meter"]
    assert_agrees(reading.flux_in, FURNACE * shape.area * share, FALSE_ALARM)
    assert_agrees(reading.flux_out, FURNACE * shape.area * share, FALSE_ALARM)  # M = M0 + rho E = E


def test_meters_side_by_side_and_within_each_other_add_up():
    """Two halves of a wall, and a disk with the ring about it: integers that are equal history by history."""
    half = {"height": 2.0, "width": 1.0, "normal": (0, 0, -1)}
    detectors = [
        tp.Detector("ceiling", side="back"),
        tp.Detector(tp.Rectangle(center=(-0.5, 0, 1), **half), name="left"),
        tp.Detector(tp.Rectangle(center=(0.5, 0, 1), **half), name="right"),
        tp.Detector(tp.Disk(center=(0.1, 0.2, 1), normal=(0, 0, -1), radius=0.7), name="disk"),
        tp.Detector(tp.Disk(center=(0.1, 0.2, 1), normal=(0, 0, 1), radius=0.3), name="core", side="back"),
        tp.Detector(
            tp.Disk(center=(0.1, 0.2, 1), normal=(0, 0, -1), radius=0.7, inner_radius=0.3), name="ring"
        ),
    ]
    result = run(furnace(detectors))
    np.testing.assert_array_equal(
        counted(result["left"])[:, 1] + counted(result["right"])[:, 1], counted(result["ceiling"])[:, 1]
    )
    np.testing.assert_array_equal(
        counted(result["core"])[:, 1] + counted(result["ring"])[:, 1], counted(result["disk"])[:, 1]
    )


def test_a_source_on_a_floor_leaves_it():
    """A patch that lies on an opaque floor: nothing that is born there is stopped by the floor at birth."""
    floor = tp.Surface(tp.Rectangle(width=4.0, height=4.0), tp.Black(), name="floor")
    patch = tp.Disk(center=(0.3, 0, 0), radius=0.5)
    detectors = [
        tp.Detector("floor"),
        tp.Detector(tp.Disk(center=(0.3, 0, 1e-9), radius=0.5), name="just above", side="back"),
    ]
    result = run(
        tp.Scene(sources=[tp.Source(patch, tp.Lambertian(power=7.0))], surfaces=[floor], detectors=detectors)
    )
    assert result["floor"].flux_in.value == 0
    np.testing.assert_allclose(result["floor"].flux_out.value, 7.0, rtol=1e-12)
    np.testing.assert_allclose(result.ledger["escaped"].value, 7.0, rtol=1e-12)
    np.testing.assert_allclose(result["just above"].flux_in.value, 7.0, rtol=1e-6)


def test_a_ray_crosses_a_sphere_meter_twice():
    """A pencil beam through a sphere: in on one side, out on the other, fluence by the chord's cosine."""
    sphere = tp.Sphere(radius=1.0)
    beam = tp.Source(tp.Point(position=(-2, 0.6, 0)), tp.Beam((1, 0, 0), power=1.0))
    detectors = [tp.Detector(sphere, name=side, side=side) for side in ("outside", "inside")]
    result = run(tp.Scene(sources=[beam], detectors=detectors), 1000)
    for name in ("outside", "inside"):
        np.testing.assert_allclose([result[name].flux_in.value, result[name].flux_out.value], 1.0, rtol=1e-12)
        np.testing.assert_allclose(result[name].fluence_rate.value, 2 / 0.8 / sphere.area, rtol=1e-6)


# ---- closed rooms of any walls ----


def cap(height, radius, **bounds):
    return tp.Sphere(center=at(height), axis=AXIS, radius=radius, **bounds)


TUBE = tp.Cylinder(center=at(0), axis=AXIS, radius=0.7, height=2)
BOWL = math.sqrt(1 - (0.4 / 1.3) ** 2)  # cosine of the half angle of a lens
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
ROOMS = {  # closed rooms, seen from within: all walls but those named "front" show their backs
    "tube": [TUBE, lid(1, 0.7), lid(-1, 0.7)],
    "tube of two": [
        tp.Cylinder(center=at(-0.6), axis=BACK, radius=0.7, height=0.8),
        tp.Cylinder(center=at(0.4), axis=AXIS, radius=0.7, height=1.2),
        lid(1, 0.7),
        lid(-1, 0.7),
    ],
    "capsule": [TUBE, cap(1, 0.7, mu_min=0), cap(-1, 0.7, mu_max=0)],
    "cone": [tp.Cone(center=at(0), axis=AXIS, radius=0.7, height=2), lid(-1, 0.7)],
    "frustum": [
        tp.Cone(center=at(0), axis=AXIS, radius=0.7, top_radius=0.5, height=2), lid(-1, 0.7), lid(1, 0.5)
    ],
    "dish": [tp.Paraboloid(center=at(0), axis=AXIS, focal_length=0.3, radius=0.6), lid(0.3, 0.6)],
    "lens": [cap(-1.3 * BOWL, 1.3, mu_min=BOWL), cap(1.3 * BOWL, 1.3, mu_max=-BOWL)],
    "zones": [cap(0, 1, mu_min=0.2), cap(0, 1, mu_max=-0.3), cap(0, 1, mu_min=-0.3, mu_max=0.2)],
    "tetrahedron": [
        tp.Triangle(vertices=[CORNERS[k] for k in order]) for order in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    ],
    "wall with a window": [
        *(face for name, face in BOX.faces().items() if name != "+z"),
        tp.Rectangle(center=(0, 0, 1), width=2, height=2, hole=tp.Disk(center=(0.3, 0.1, 1), radius=0.6)),
        tp.Disk(center=(0.3, 0.1, 1), radius=0.6),
    ],
    "tube through a tube": [
        TUBE, lid(1, 0.7, 0.2), lid(-1, 0.7, 0.2), ("front", tp.Cylinder(center=at(0), axis=AXIS, radius=0.2, height=2))
    ],
}  # fmt: skip


def room(walls, detectors=()):
    """A furnace of these walls, each a detector too."""
    sides = [wall if isinstance(wall, tuple) else ("back", wall) for wall in walls]
    surfaces = [tp.Surface(shape, tp.Diffuse(ALBEDO), name=str(k)) for k, (_, shape) in enumerate(sides)]
    lamps = [
        tp.Source(str(k), tp.Lambertian(exitance=EXITANCE), side=side) for k, (side, _) in enumerate(sides)
    ]
    looks = [tp.Detector(str(k), side=side) for k, (side, _) in enumerate(sides)]
    return tp.Scene(sources=lamps, surfaces=surfaces, detectors=[*looks, *detectors])


@pytest.mark.parametrize("walls", ROOMS.values(), ids=ROOMS)
def test_a_closed_room_of_any_walls_is_a_furnace(walls):
    result = run(room(walls))
    for name in map(str, range(len(walls))):
        assert_agrees(result[name].irradiance, FURNACE, FALSE_ALARM)
    assert result.ledger["lost"].value == result.ledger["escaped"].value == 0


@pytest.mark.quick_cases("cone", "frustum")
@pytest.mark.parametrize("name", ["tube", "cone", "frustum", "dish", "zones"])
def test_radiance_is_the_same_in_all_bins_of_place_and_direction(name):
    """On the room's first wall; planted: bins by height taken for bins of equal area."""
    [shape, *_] = ROOMS[name]
    bins = {"positions": tp.Positions(u=4, v=3), "directions": tp.Directions(mu=3, phi=4)}
    reading = run(room(ROOMS[name], [tp.Detector(shape, name="meter", side="back", **bins)]), 400_000)[
        "meter"
    ]
    assert reading.radiance.value.shape == (4, 3, 3, 4)
    assert_agrees(reading.radiance, FURNACE / math.pi, FALSE_ALARM)
    assert_agrees(reading.irradiance, FURNACE, FALSE_ALARM)
    if name in ("cone", "dish"):
        areas = bins["positions"].areas(shape)
        with pytest.raises(AssertionError):
            assert_agrees(reading.irradiance, FURNACE * areas / areas.mean(), FALSE_ALARM)


@pytest.mark.parametrize("name", ["tube", "cone", "frustum", "dish", "lens"])
def test_a_meter_on_part_of_a_curved_wall_counts_what_falls_there(name):
    """Two bands that together are the wall, of which one is turned over, and the wall as a whole."""
    [shape, *_] = ROOMS[name]
    low, high = band(shape, 0.0, 0.37), band(shape, 0.37, 1.0)
    looks = [
        tp.Detector(part, name=key, side="back")
        for key, part in (("low", low), ("high", high), ("all", shape))
    ]
    result = run(room(ROOMS[name], looks))
    np.testing.assert_array_equal(counted(result["all"]), counted(result["0"]))
    total = counted(result["low"])[:, 1] + counted(result["high"])[:, 1]
    np.testing.assert_array_equal(total, counted(result["0"])[:, 1])
    for key, part in (("low", low), ("high", high)):
        assert_agrees(result[key].flux_in, FURNACE * part.area, FALSE_ALARM)


def band(shape, first, last):
    """The part between two shares of its height."""
    lower, upper = (shape.profile.low + s * (shape.profile.high - shape.profile.low) for s in (first, last))
    middle = tuple(o + (lower + upper) / 2 * a for o, a in zip(shape.profile.origin, shape.axis, strict=True))
    radii = shape.profile.radius_at(lower), shape.profile.radius_at(upper)
    match shape:
        case tp.Cylinder():
            return tp.Cylinder(center=middle, axis=BACK, radius=shape.radius, height=upper - lower)
        case tp.Cone():
            turned = {"radius": radii[1], "top_radius": radii[0]}
            return tp.Cone(center=middle, axis=BACK, height=upper - lower, **turned)
        case tp.Paraboloid():
            return dataclasses.replace(shape, inner_radius=radii[0], radius=radii[1])
    return dataclasses.replace(shape, mu_min=lower / shape.radius, mu_max=upper / shape.radius)


@pytest.mark.parametrize(
    "shape", [TUBE, ROOMS["cone"][0], ROOMS["dish"][0], ROOMS["zones"][0]], ids=lambda s: type(s).__name__
)
def test_what_leaves_a_hollow_falls_on_itself_by_its_view_factor(shape):
    """The inside of a hollow with one mouth sees itself but for its mouth, F = 1 − A_mouth/A; the outside sees none of it."""
    mouths = {tp.Cone: math.pi * 0.49, tp.Paraboloid: math.pi * 0.36, tp.Sphere: math.pi * 0.96}
    x = 2 + (2 / 0.7) ** 2
    # of a tube's ends, but for what passes both
    seen = math.pi * 0.49 * 2 * (1 - (x - math.sqrt(x * x - 4)) / 2)
    mouth = mouths.get(type(shape), seen)
    for side, share in (("back", 1 - mouth / shape.area), ("front", 0.0)):
        lamp = tp.Source(shape, tp.Lambertian(exitance=1.0), side=side)
        result = run(tp.Scene(lamp, (), tp.Detector(shape, "own", side=side)))
        np.testing.assert_allclose(result["own"].exitance.value, 1.0, rtol=1e-12)
        if share:
            assert_agrees(result["own"].irradiance, share, FALSE_ALARM)
        else:
            assert result["own"].irradiance.value == 0


def test_a_slab_keeps_what_its_planes_absorb():
    """A point between two black planes; a beam along them would never meet them."""
    slab = tp.Slab(thickness=2.0, normal=(0, 0.6, 0.8))
    lamp = tp.Source(tp.Point(position=(7, 0.3, 0.4)), tp.Isotropic(power=1.0))
    patch = tp.Disk(center=(7, 0.6, 0.8), normal=(0, 0.6, 0.8), radius=1.0)
    looks = [tp.Detector("wall", side="inside"), tp.Detector(patch, name="patch", side="back")]
    result = run(tp.Scene(lamp, tp.Surface(slab, tp.Black(), name="wall"), looks))
    np.testing.assert_allclose(result["wall"].flux_in.value, 1.0, rtol=1e-9)
    half_angle = math.atan(1 / 0.5)
    assert_agrees(result["patch"].flux_in, (1 - math.cos(half_angle)) / 2, FALSE_ALARM)
    with pytest.raises(tp.SceneError, match="Slab"):
        print(result["wall"].irradiance)


def test_light_passes_a_hole_and_no_more():
    """A lamp above a plate: through the hole falls what would fall on a disk there."""
    hole = tp.Disk(center=(0.3, -0.1, 0), radius=0.25)
    plate = tp.Rectangle(width=2, height=1.5, up=(1, 2, 0), hole=hole)
    lamp = tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.5), tp.Lambertian(radiance=1.0))
    looks = [tp.Detector(hole, name="hole"), tp.Detector(tp.Plane(center=(0, 0, -1)), name="below")]
    result = run(tp.Scene(lamp, tp.Surface(plate, tp.Black(), name="plate"), [*looks, tp.Detector("plate")]))
    bare = run(
        tp.Scene(lamp, (), [looks[0], tp.Detector(dataclasses.replace(plate, hole=None), name="plate")])
    )
    np.testing.assert_array_equal(counted(result["hole"]), counted(bare["hole"]))
    np.testing.assert_array_equal(
        counted(result["plate"])[0, 1] + counted(result["hole"])[0, 1], counted(bare["plate"])[0, 1]
    )
    assert counted(result["below"])[0, 1].sum() >= counted(result["hole"])[0, 1].sum() > 1000


# ---- planes that only rounding tells apart ----

HIGH_LAMP = tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.3), tp.Lambertian(power=1.0))


BEAM = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0.6, 0, -0.8), power=1.0))


@pytest.mark.parametrize("lamp", [HIGH_LAMP, BEAM], ids=["disk", "point"])
@pytest.mark.parametrize("top", [0.0, 1 - 0.9 - 0.1, 0.1 + 0.2 - 0.3])
@pytest.mark.parametrize(
    "material", [tp.Dielectric(1.3), tp.Black(), tp.Diffuse(0.5)], ids=lambda each: type(each).__name__
)
def test_a_plane_that_rounding_puts_beside_a_wall_at_the_origin_counts_what_the_wall_meets(
    top, material, lamp
):
    """Coordinates near 0 have finer digits than the rays that come to them from afar."""
    for wall in (tp.Plane(center=(0, 0, top)), tp.Slab(center=(0, 0, top - 0.15), thickness=0.3)):
        result = run(tp.Scene(lamp, tp.Surface(wall, material, "wall"), tp.Detector(tp.Plane(), "plane")))
        assert result["plane"].flux_in.value == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("offset", [0.0, 2e-16, 1e-15, 1e-14, 3e-14, 1e-13, 1e-12])
@pytest.mark.parametrize("radius", [1.0, 50.0])
def test_planes_that_share_a_disk_within_rounding_all_count(radius, offset):
    """The wider the disk, the more planes are its own within rounding: then they are one."""
    low = (0, 0, -offset)
    looks = [tp.Detector(tp.Plane(), "a"), tp.Detector(tp.Plane(center=low), "b")]
    result = run(tp.Scene(HIGH_LAMP, (), [*looks, tp.Detector(tp.Disk(center=low, radius=radius), "disk")]))
    assert [result[name].flux_in.value for name in "ab"] == pytest.approx([1.0, 1.0], rel=1e-12)


def test_a_shape_on_a_sheet_that_has_become_one_with_another_is_on_both():
    """The wide disk joins two planes; the small one lies on that which was given up."""
    low = (0, 0, -1e-14)
    shapes = [
        tp.Plane(),
        tp.Plane(center=low),
        tp.Disk(center=low, radius=50.0),
        tp.Disk(center=low, radius=0.5),
    ]
    looks = [tp.Detector(shape, str(number)) for number, shape in enumerate(shapes)]
    (sheet,) = scene_sheets(tp.Scene(HIGH_LAMP, (), looks))
    assert sorted(detector.name for member in sheet.members for detector in member.detectors) == list("0123")


@pytest.mark.parametrize("tilt", [0.0, 1e-9, 1.4e-8, 2e-8, 3e-8])
def test_a_plane_tilted_by_little_is_met_where_it_is(tilt):
    """Two pencils, on whose black disks the tilted plane lies on either side: one of them crosses it."""
    edge, depth = 0.9, 8e-9
    looks = [tp.Detector(tp.Plane(center=(0, 0, 0.5)), "level")]
    looks.append(tp.Detector(tp.Plane(normal=(math.sin(tilt), 0, math.cos(tilt))), "tilted"))
    disks = [tp.Surface(tp.Disk(center=(x, 0, -depth), radius=0.05), tp.Black()) for x in (-edge, edge)]
    lamps = [tp.Source(tp.Point(position=(x, 0, 1)), tp.Beam((0, 0, -1), power=1.0)) for x in (-edge, edge)]
    result = run(tp.Scene(lamps, disks, looks))
    assert result["level"].flux_in.value == pytest.approx(2.0, rel=1e-12)
    assert result["tilted"].flux_in.value == pytest.approx(2.0 if edge * tilt < depth else 1.0, rel=1e-2)
