"""Random cameras and environment maps: narrow and wide, upright and tilted, of one pixel and of many."""

from __future__ import annotations

import math

from hypothesis import strategies as st

import transport as tp
from tests.fuzz import lamps, looks, shapes
from tests.fuzz.worlds import MIDDLES, World, assembled, matter
from transport.vectors import Vector

ASIDE = 0.01  # m, off the middle of a cell, where sheets may lie
ANGLES = (1e-3, 0.5, math.pi / 2, 3.0)  # rad
LENSES = (
    {},
    {"lens": "fisheye"},
    {"lens": "equal-area fisheye"},
    {"lens": "orthographic", "width": 0.02},
    {"lens": "thin lens", "aperture": 0.02, "focal_length": 0.01, "focus": 0.5},
)


@st.composite
def seen_worlds(draw) -> World:
    """A steady world of light that is seen by cameras and maps, and so is run backwards."""
    middle = draw(MIDDLES)
    cells, medium, surfaces = draw(matter(middle, light=True))
    surfaces = [reciprocal(surface) for surface in surfaces]
    lamp = lamps.lamps(surfaces, cells.pop(), middle, light=True, duration=None, is_broad=True)
    sources = draw(st.lists(lamp, min_size=1, max_size=2))
    places = [aside(cell) for cell in (middle, *cells)]
    detectors = [draw(views(places, f"view {number}")) for number in range(draw(st.integers(1, 2)))]
    detectors += draw(st.one_of(st.just([]), looks.plain_meters(surfaces, cells, middle)))
    return draw(assembled(sources, surfaces, detectors, medium))


def reciprocal(surface: tp.Surface) -> tp.Surface:
    """The same, but with its front's material on both sides where what passes might be unlike, which is refused backwards."""
    passes = any(getattr(part, "transmission", 0.0) > 0 for part in surface.material.elements)
    if not isinstance(surface.material, tp.TwoSided) or not passes:
        return surface
    return tp.Surface(
        surface.shape, surface.material.front, surface.name, front=surface.front, back=surface.back
    )


def views(places: list[Vector], name: str) -> st.SearchStrategy:
    """A camera or a map at one of the places."""
    return st.one_of(cameras(places, name), maps(places, name))


@st.composite
def cameras(draw, places: list[Vector], name: str) -> tp.Camera:
    """A camera that looks anywhere, along a direction or at a point."""
    position, forward = draw(st.sampled_from(places)), draw(shapes.directions())
    along = {"direction": forward}
    if draw(st.booleans()):
        along = {"look_at": tuple(p + 3 * f for p, f in zip(position, forward, strict=True))}
    lens = draw(st.sampled_from(LENSES))
    if lens.get("lens") != "orthographic":
        lens = lens | {"field_of_view": draw(st.sampled_from(ANGLES))}
    return tp.Camera(
        name=name,
        position=position,
        **along,
        up=across(forward),
        pixels=draw(st.sampled_from([(1, 1), (3, 2), (5, 1)])),
        **lens,
    )


@st.composite
def maps(draw, places: list[Vector], name: str) -> tp.EnvironmentMap:
    """A map of all directions, or of a part of them."""
    projection = draw(st.sampled_from(["latitude-longitude", "cylinder", "cube", "fisheye", "mirrored ball"]))
    if projection not in ("latitude-longitude", "cylinder"):
        pixels = draw(st.integers(1, 3))
        return tp.EnvironmentMap(
            name=name, position=draw(st.sampled_from(places)), projection=projection, pixels=pixels
        )
    return tp.EnvironmentMap(
        name=name,
        position=draw(st.sampled_from(places)),
        projection=projection,
        theta=draw(st.sampled_from([1, 2, (0.0, 1e-3, 1.0), (0.0, 1.0, math.pi)])),
        phi=draw(st.sampled_from([1, 3, (0.5, 0.6, 2.0)])),
    )


def aside(cell: Vector) -> Vector:
    """A place near the middle of a cell, on none of the planes that things in it may have."""
    return tuple(x + ASIDE * k for x, k in zip(cell, (1.0, 0.7, -0.4), strict=True))


def across(forward: Vector) -> Vector:
    """The axis that is furthest from the line of sight."""
    sizes = [abs(f) for f in forward]
    least = sizes.index(min(sizes))
    return tuple(float(k == least) for k in range(3))


def cube(position: Vector) -> list[tp.Camera]:
    """Six cameras of four pixels each, whose images together show all directions once, an octant a pixel of each axis."""
    right_angle = {"field_of_view": math.pi / 2, "pixels": (2, 2)}
    return [
        tp.Camera(name=f"side {k}", position=position, direction=axis, up=across(axis), **right_angle)
        for k, axis in enumerate(shapes.AXES)
    ]
