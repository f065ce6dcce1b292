"""Random contacts, where roundings decide: shells in shells, shared faces, tangent balls, gaps of a billionth, patches on walls."""

from __future__ import annotations

from hypothesis import strategies as st

import transport as tp
from tests.fuzz import stuff
from transport.scene.materials import Surface
from transport.vectors import Vector

RADIUS = 0.3  # m, of things that touch
PATCH = 0.25  # m
UP = (0.0, 0.0, 1.0)


@st.composite
def pairs(draw, place: Vector) -> list[Surface]:
    """Two surfaces about the place that touch, hold one another or nearly do."""
    kind = draw(st.sampled_from([_shells, _neighbours, _lid, _tangent, _plate, _inscribed, _cut]))
    shapes = kind(place, draw(st.sampled_from([1e-12, 1e-9, 1e-3])))
    return [
        Surface(shapes[0], tp.Transparent(), "host", inside=draw(_fogs())),
        draw(_partner(shapes[1], is_body=kind in (_shells, _neighbours, _tangent, _inscribed))),
    ]


@st.composite
def _partner(draw, shape, is_body: bool) -> Surface:
    """What touches the host: fog, or something opaque."""
    if is_body and draw(st.booleans()):
        return Surface(shape, tp.Transparent(), "guest", inside=draw(_fogs()))
    return Surface(shape, draw(stuff.opaque()), "guest")


def _fogs() -> st.SearchStrategy[tp.Medium]:
    return stuff.media(2 * RADIUS)


def moved(place: Vector, x: float = 0.0, z: float = 0.0) -> Vector:
    """A point beside the place."""
    return (place[0] + x, place[1], place[2] + z)


def _shells(place: Vector, gap: float) -> list:
    return [tp.Sphere(center=place, radius=r) for r in (RADIUS, RADIUS * (1 - gap))]


def _neighbours(place: Vector, gap: float) -> list:
    size = (RADIUS, 2 * RADIUS, RADIUS)
    return [tp.Box(center=moved(place, x), size=size) for x in (-RADIUS / 2, RADIUS / 2)]


def _lid(place: Vector, gap: float) -> list:
    face = tp.Rectangle(center=moved(place, z=RADIUS), width=RADIUS, height=2 * RADIUS)
    return [tp.Box(center=place, size=2 * RADIUS), face]


def _tangent(place: Vector, gap: float) -> list:
    return [tp.Sphere(center=moved(place, x), radius=RADIUS / 2) for x in (-RADIUS / 2, RADIUS / 2)]


def _plate(place: Vector, gap: float) -> list:
    plate = tp.Disk(center=moved(place, z=RADIUS * (1 + gap)), radius=RADIUS)
    return [tp.Box(center=place, size=2 * RADIUS), plate]


def _inscribed(place: Vector, gap: float) -> list:
    return [tp.Box(center=place, size=2 * RADIUS), tp.Sphere(center=place, radius=RADIUS)]


def _cut(place: Vector, gap: float) -> list:
    return [
        tp.Sphere(center=place, radius=RADIUS),
        tp.Disk(center=place, normal=(0.6, 0, 0.8), radius=RADIUS),
    ]


def patches(surfaces: list[Surface]) -> list[st.SearchStrategy]:
    """Disks and rectangles on the floor of the room, facing up; none where there is no flat floor."""
    for surface in surfaces:
        if surface.name == "floor":
            return [_on(surface.shape.center)]
        if surface.name == "room" and isinstance(surface.shape, tp.Box):
            return [_on(surface.shape.faces()["-z"].center)]
    return []


def _on(center: Vector) -> st.SearchStrategy:
    disk = tp.Disk(center=center, normal=UP, radius=PATCH)
    beside = tp.Rectangle(center=moved(center, PATCH), normal=UP, width=PATCH, height=2 * PATCH)
    return st.sampled_from([disk, beside])
