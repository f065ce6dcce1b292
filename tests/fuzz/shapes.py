"""Random shapes: every kind, in any position, thin ones and plump ones, each within a ball of its own."""

from __future__ import annotations

import math

from hypothesis import strategies as st

import transport as tp
from transport.geometry.shape import Shape
from transport.vectors import Vector, local_frame, unit_vector

AXES = [tuple(sign * float(k == axis) for k in range(3)) for axis in range(3) for sign in (1, -1)]


def directions() -> st.SearchStrategy[Vector]:
    """Unit vectors: along the axes, along diagonals, anywhere, and a hair off an axis."""
    whole = st.tuples(*[st.integers(-3, 3)] * 3).filter(any)
    free = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: math.hypot(*v) > 0.1)
    tilted = st.builds(
        lambda axis, tilt: tuple(a + t for a, t in zip(axis, tilt, strict=True)),
        st.sampled_from(AXES),
        st.permutations([1e-9, -1e-13, 0.0]),
    )
    return st.one_of(st.sampled_from(AXES), whole, free, tilted).map(
        lambda v: unit_vector(tuple(map(float, v)))
    )


def lengths(most: float) -> st.SearchStrategy[float]:
    """Lengths up to `most`: mostly of its size, some ten thousand times smaller."""
    return st.one_of(st.floats(0.2, 1.0), st.floats(0.2, 1.0), st.floats(1e-4, 1.0)).map(lambda x: x * most)


def flat(center: Vector, radius: float) -> st.SearchStrategy[Shape]:
    """Rectangles, disks and rings in the ball; those of plain outline on which points can be placed."""
    side = lengths(math.sqrt(2) * radius)
    rectangle = st.builds(tp.Rectangle, center=st.just(center), normal=directions(), width=side, height=side)
    return st.one_of(rectangle, disks(center, radius))


@st.composite
def disks(draw, center: Vector, radius: float) -> tp.Disk:
    """A disk, or a ring."""
    outer = draw(lengths(radius))
    inner = draw(st.sampled_from([0.0, 0.0, 0.5, 0.999])) * outer
    return tp.Disk(center=center, normal=draw(directions()), radius=outer, inner_radius=inner)


@st.composite
def framed(draw, center: Vector, radius: float) -> tp.Rectangle:
    """A rectangle with a hole."""
    width, height = draw(lengths(1.4 * radius)), draw(lengths(1.4 * radius))
    place, share = {"center": center, "normal": draw(directions())}, draw(st.floats(0.1, 0.95))
    if draw(st.booleans()):
        hole = tp.Disk(**place, radius=share * min(width, height) / 2)
    else:
        hole = tp.Rectangle(**place, width=share * width, height=share * height)
    return tp.Rectangle(**place, width=width, height=height, hole=hole)


@st.composite
def triangles(draw, center: Vector, radius: float) -> tp.Triangle:
    """A triangle about the place, some of them slivers."""
    e_u, e_v, _ = local_frame(draw(directions()), None)
    flatness = draw(st.sampled_from([1.0, 1.0, 1e-3]))
    angles = [turn * 2 * math.pi / 3 + draw(st.floats(-0.9, 0.9)) for turn in range(3)]
    corners = [(radius * math.cos(a), flatness * radius * math.sin(a)) for a in angles]
    vertices = [
        tuple(c + x * u + y * v for c, u, v in zip(center, e_u, e_v, strict=True)) for x, y in corners
    ]
    return tp.Triangle(vertices=vertices)


@st.composite
def zones(draw, center: Vector, radius: float) -> tp.Sphere:
    """A zone or a cap of a sphere."""
    low, high = draw(
        st.sampled_from([(-1, 0.0), (-0.5, 0.5), (0.2, 1), (-0.99, 1), (-1, -0.9), (0.3, 0.301)])
    )
    return tp.Sphere(
        center=center, radius=draw(lengths(radius)), axis=draw(directions()), mu_min=low, mu_max=high
    )


@st.composite
def revolved(draw, center: Vector, radius: float) -> Shape:
    """A cylinder, a cone or a paraboloid."""
    place = {"center": center, "axis": draw(directions())}
    wide, tall = draw(lengths(0.7 * radius)), draw(lengths(1.4 * radius))
    kind = draw(st.sampled_from(["cylinder", "cone", "paraboloid"]))
    if kind == "cylinder":
        return tp.Cylinder(**place, radius=wide, height=tall)
    top = draw(st.sampled_from([0.0, 0.5, 0.999, 1.0 + 2.0**-20])) * wide
    if kind == "cone":
        return tp.Cone(**place, radius=wide, top_radius=top, height=tall)
    inner = draw(st.sampled_from([0.0, 0.0, 0.5])) * wide
    return tp.Paraboloid(
        **place, focal_length=wide * draw(st.floats(0.4, 20)), radius=wide, inner_radius=inner
    )


def balls(center: Vector, radius: float) -> st.SearchStrategy[tp.Sphere]:
    """Whole spheres."""
    return st.builds(tp.Sphere, center=st.just(center), radius=lengths(radius), axis=directions())


def boxes(center: Vector, radius: float) -> st.SearchStrategy[tp.Box]:
    """Boxes along the axes."""
    size = st.tuples(*[lengths(1.15 * radius)] * 3)
    return st.builds(tp.Box, center=st.just(center), size=size)


@st.composite
def meshes(draw, center: Vector, radius: float) -> tp.Mesh:
    """A closed mesh: a box, or an icosahedron and finer ones."""
    if draw(st.booleans()):
        return tp.Mesh.box(center=center, size=draw(st.tuples(*[lengths(1.15 * radius)] * 3)))
    count = draw(st.sampled_from([20, 80]))
    return tp.Mesh.sphere(center=center, radius=draw(lengths(radius)), triangles=count)


def closed(center: Vector, radius: float) -> st.SearchStrategy[Shape]:
    """Shapes with an inside."""
    return st.one_of(balls(center, radius), boxes(center, radius), meshes(center, radius))


def sheets(center: Vector, radius: float) -> st.SearchStrategy[Shape]:
    """Shapes without an inside."""
    kinds = (flat, flat, framed, triangles, zones, revolved)
    return st.one_of([kind(center, radius) for kind in kinds])
