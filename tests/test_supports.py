"""Which shapes lie on one support and which of them overlap there: what makes sheets, and what is refused on them."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import transport as tp
from transport.geometry.relations import are_on_one_support, is_on_support, overlap, relative_orientation
from transport.scene.sheets import scene_sheets
from transport.vectors import unit_vector

AXIS = unit_vector((0.3, -0.2, 0.9))
BACK = tuple(-x for x in AXIS)
LAMP = tp.Source(tp.Point(position=(50, 60, 70)), tp.Isotropic(power=1))
angles = st.floats(0.01, math.pi - 0.01)


def at(height, origin=(0.1, 0.2, 0.3)):
    """A point of the axis."""
    return tuple(o + height * a for o, a in zip(origin, AXIS, strict=True))


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
    "planes": (tp.Plane(), tp.Plane(center=(7, 8, 0), normal=(0, 0, -1))),
    "a mesh and itself": (tp.Mesh.box(size=2), tp.Mesh.box(size=2)),
}
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
SQUARE = tp.Rectangle(width=2, height=2)
FRAME = tp.Rectangle(width=2, height=2, hole=tp.Disk(radius=0.5))
WINDOW = tp.Rectangle(width=2, height=2, hole=tp.Rectangle(width=1, height=0.5, up=(1, 1, 0)))


def flat_triangle(*corners):
    return tp.Triangle(vertices=[(*corner, 0) for corner in corners])


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
