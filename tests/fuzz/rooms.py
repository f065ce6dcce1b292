"""Random furnaces: closed rooms, convex and not, of walls, things and fogs that all glow with what they fail to return."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

import transport as tp
from tests.fuzz import looks, shapes, stuff, views
from tests.fuzz.worlds import OFFSETS, ROOM, WITHIN, World, cells_about
from transport.geometry.shape import Shape
from transport.scene.materials import Material
from transport.vectors import Vector

DIM = 1e-6  # a share below which nothing needs to glow
FOGGY = 0.04  # optical depth, beyond which light gets out of glass that reflects it totally
METERED = tp.Directions(mu=2, phi=2)
OUTLINE_OF_L = [(-1, -1), (1, -1), (1, 0.1), (0.1, 0.1), (0.1, 1), (-1, 1)]  # turning left


@st.composite
def furnaces(draw) -> World:
    """A room of radiance 1 W m^-2 sr^-1 everywhere in front of the sides that its meters look at."""
    middle = tuple(draw(st.sampled_from(OFFSETS)) for _ in range(3))
    cells = draw(st.permutations(cells_about(middle)))
    shell = draw(st.one_of(boxes(middle), hollows(middle), cans(middle), cans(middle)))
    walls = [tp.Surface(shape, draw(_walls()), f"wall {k}") for k, shape in enumerate(shell)]
    glowing = draw(st.integers(0, len(walls) - 1))
    walls[glowing] = tp.Surface(walls[glowing].shape, draw(_glowing()), f"wall {glowing}")
    holds_bodies = isinstance(shell[0], tp.Box | tp.Sphere) or len(shell) > 1
    things = [draw(_thing(cells.pop(), k)) for k in range(draw(st.integers(0, 3)))] if holds_bodies else []
    surfaces = [*walls, *things]
    sources = [lamp for surface in surfaces for lamp in _lamps(surface)]
    meters = [meter for surface in surfaces for meter in _meters(surface)]
    if holds_bodies:
        meters.append(tp.Detector(draw(shapes.flat(cells.pop(), WITHIN)), "free", directions=METERED))
    parts = {"sources": tuple(sources), "surfaces": tuple(surfaces), "detectors": tuple(meters)}
    unit = draw(st.tuples(st.integers(-30, 30), st.integers(-40, 40)))
    parts |= {"medium": None, "duration": None}
    return World(parts, particles=20_000, unit=unit, views=draw(_views(middle, things, surfaces)))


@st.composite
def _views(draw, middle: Vector, things: list[tp.Surface], surfaces: list[tp.Surface]) -> tuple:
    """A camera, a map and perhaps a point: in the room, or in what fills a thing where light finds out of it."""
    places = [views.aside(middle), *(views.aside(each.shape.center) for each in things if _lets_out(each))]
    found = [draw(views.views(places, f"view {k}")) for k in range(2)]
    if looks.are_seen_by(surfaces):
        found.append(tp.PointDetector(draw(st.sampled_from(places)), "point"))
    return tuple(found)


def _lets_out(thing: tp.Surface) -> bool:
    """Whether light of the room is about the middle of a thing, and comes from there without a million reflections."""
    if not thing.shape.is_closed:
        return hasattr(thing.shape, "center")
    if isinstance(thing.material, tp.Dielectric):
        return isinstance(thing.shape, tp.Sphere) or thing.back.extinction * WITHIN > FOGGY
    return isinstance(thing.material, tp.Transparent)


def boxes(middle: Vector) -> st.SearchStrategy[list[Shape]]:
    """One box or ball that holds the whole grid."""
    ball = tp.Sphere(center=middle, radius=ROOM)
    sizes = st.sampled_from([ROOM, (ROOM, 2 * ROOM, ROOM), (ROOM, ROOM, 50 * ROOM)])
    box = st.builds(tp.Box, center=st.just(middle), size=sizes)
    return st.one_of(st.just([ball]), box.map(lambda shape: [shape]))


@st.composite
def hollows(draw, middle: Vector) -> list[Shape]:
    """An empty room of triangles: an L, whose one leg does not see the other, or an icosahedron."""
    if draw(st.booleans()):
        return [tp.Mesh.sphere(center=middle, radius=ROOM, triangles=draw(st.sampled_from([20, 80])))]
    return [ell(middle, draw(st.sampled_from([0.01, 1.0, 3.0])))]


def ell(middle: Vector, height: float) -> tp.Mesh:
    """A room in the shape of an L, of that height [m]."""
    corners = len(OUTLINE_OF_L)
    levels = [(x, y, z) for z in (-height / 2, height / 2) for x, y in OUTLINE_OF_L]
    floor = [(0, k + 1, k) for k in range(1, corners - 1)]
    # The corner that turns inwards sees all others, so that triangles from it fill the outline.
    floor = [tuple((each + 3) % corners for each in face) for face in floor]
    ceiling = [tuple(each + corners for each in reversed(face)) for face in floor]
    sides = [(k, (k + 1) % corners) for k in range(corners)]
    walls = [face for a, b in sides for face in ((a, b, b + corners), (a, b + corners, a + corners))]
    return tp.Mesh(vertices=np.add(levels, middle), faces=floor + ceiling + walls)


@st.composite
def cans(draw, middle: Vector) -> list[Shape]:
    """A cylinder or a frustum and its two lids, of which the rims close it."""
    axis = draw(shapes.directions())
    half = ROOM * draw(st.sampled_from([1.0, 1.0, 20.0]))
    wide, narrow = 1.5 * ROOM, draw(st.sampled_from([1.5, 1.2])) * ROOM
    place = {"center": middle, "axis": axis, "height": 2 * half}
    tube = tp.Cylinder(radius=wide, **place)
    if narrow != wide:
        tube = tp.Cone(radius=wide, top_radius=narrow, **place)
    ends = [tuple(m + sign * half * a for m, a in zip(middle, tube.axis, strict=True)) for sign in (-1, 1)]
    lids = [
        tp.Disk(center=end, normal=tuple(sign * a for a in tube.axis), radius=radius)
        for end, sign, radius in zip(ends, (-1, 1), (wide, narrow), strict=True)
    ]
    return [tube, *lids]


def _walls() -> st.SearchStrategy[Material]:
    """Opaque materials, alike on both sides."""
    one = [
        st.just(tp.Black()),
        st.builds(tp.Diffuse, stuff.shares(0.9)),
        st.builds(tp.Mirror, stuff.shares(0.9)),
        st.builds(tp.Glossy, st.sampled_from([0.02, 0.3, 1.0]), stuff.shares(0.9)),
        st.just(tp.Mixture({tp.Diffuse(0.7): 0.25, tp.Mirror(): 0.5, tp.Glossy(0.1): 0.25})),
    ]
    return st.one_of(one)


def _glowing() -> st.SearchStrategy[Material]:
    return st.sampled_from([tp.Black(), tp.Diffuse(0.5), tp.Glossy(0.3, 0.5), tp.Mirror(0.5)])


@st.composite
def _thing(draw, place: Vector, number: int) -> tp.Surface:
    """A sheet, an opaque body, glass, or fog that glows as much as it absorbs."""
    name = f"thing {number}"
    kind = draw(st.sampled_from(["sheet", "sheet", "body", "glass", "fog"]))
    if kind == "sheet":
        shape = draw(shapes.sheets(place, WITHIN))
        lens = isinstance(shape, tp.Disk) and draw(st.booleans())
        return tp.Surface(shape, tp.ThinLens(0.5) if lens else draw(_of_things()), name)
    shape = draw(st.one_of(shapes.balls(place, WITHIN), shapes.boxes(place, WITHIN)))
    if kind == "body":
        shape = draw(shapes.closed(place, WITHIN))
        return tp.Surface(shape, draw(_of_things()), name)
    index = draw(stuff.indices()) if kind == "glass" else 1.0
    filling = draw(stuff.media(2 * WITHIN, index, most=1.0))
    glow = filling.absorption * index**2
    filled = tp.Medium(filling.absorption, filling.scattering, filling.phase, index, glow)
    material = tp.Dielectric(index) if kind == "glass" else tp.Transparent()
    return tp.Surface(shape, material, name, inside=filled)


def _of_things() -> st.SearchStrategy[Material]:
    """Materials that let the same through both ways, as they must in equilibrium."""
    return st.one_of(stuff.plain(), stuff.mixtures())


def kept(material: Material) -> float:
    """The share of what arrives that a material absorbs, and with which it glows."""
    if isinstance(material, tp.Mixture):
        return sum(share * kept(part) for part, share in material.parts)
    match material:
        case tp.Black():
            return 1.0
        case (
            tp.Diffuse(albedo=share, transmission=passed) | tp.Mirror(reflectance=share, transmission=passed)
        ):
            return 1 - (share + passed)
        case tp.Glossy(albedo=share):
            return 1 - share
    return 0.0


def _lit_sides(surface: tp.Surface) -> list[str]:
    """The sides to which the room's light comes."""
    if surface.name.startswith("wall"):
        return ["back"]
    passes = any(getattr(part, "transmission", 0.0) > 0 for part in surface.material.elements)
    is_clear = any(isinstance(part, tp.Transparent) for part in surface.material.elements)
    return ["front", "back"] if passes or is_clear or not surface.shape.is_closed else ["front"]


def _lamps(surface: tp.Surface) -> list[tp.Source]:
    """What the lit sides of a surface glow with."""
    share = kept(surface.material)
    if share < DIM:
        return []
    glow = tp.Lambertian(radiance=share)
    return [tp.Source(surface.name, glow, side=side) for side in _lit_sides(surface)]


def _meters(surface: tp.Surface) -> list[tp.Detector]:
    return [
        tp.Detector(surface.name, f"{surface.name} {side}", side, METERED) for side in _lit_sides(surface)
    ]
