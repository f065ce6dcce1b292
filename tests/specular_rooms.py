"""Random closed rooms with mirrors, gloss and glass: `random_room(k)` makes room k of 300, always the same one.

A room is a box of diffuse walls with one to three lamps; in a third of the rooms a wall with a hole or a slit parts it into two.
The detector, always called "m", is a disk or a rectangle of 0.5 cm to 20 cm that touches nothing.  In every third room (k a
multiple of 3) the specular objects are small, dark or outside of the room, so that they bring less than 0.1 % of the value.
One room in five has a point lamp; its detector is at least 8 cm wide, so that forward runs find what mirrors send there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi

import numpy as np

import transport as tp
from transport.geometry.shape import Shape
from transport.scene.materials import Material
from transport.vectors import Vector

ROOMS = 300
GAP = 0.03  # [m] between objects, at least
TRIES = 2000  # places that are drawn for an object before its size is halved
FAINT = ("small", "dark", "outside")  # ways in which specular objects bring hardly anything


@dataclass
class Space:
    """The box of a room, and the balls that hold the objects in it: what is placed touches none of them."""

    rng: np.random.Generator
    size: np.ndarray  # [m]
    parting: float | None  # x of the wall between two rooms [m]
    taken: list[tuple[np.ndarray, float]]

    def place(self, radius: float) -> tuple[Vector, float]:
        """A free ball of this radius [m], or of a smaller one where there is no room."""
        while True:
            for _ in range(TRIES):
                reach = self.size / 2 - radius - GAP
                center = self.rng.uniform(-reach, reach) if (reach > 0).all() else None
                if center is not None and self._is_free(center, radius):
                    self.taken.append((center, radius))
                    return tuple(map(float, center)), radius
            radius /= 2

    def _is_free(self, center: np.ndarray, radius: float) -> bool:
        if self.parting is not None and abs(center[0] - self.parting) < radius + GAP:
            return False
        return all(np.linalg.norm(center - other) > radius + size + GAP for other, size in self.taken)


def random_room(k: int) -> tp.Scene:
    """Room k."""
    rng = np.random.default_rng([2026, k])
    size = rng.uniform((2.0, 2.0, 2.0), (5.0, 5.0, 3.5))
    has_point = k % 5 == 4
    walls, parting = _walls(rng, size)
    space = Space(rng, size, parting, [])
    detector = _detector(space, least=0.08 if has_point else 0.005)
    lamps = _lamps(space, has_point)
    faint = FAINT[k // 3 % len(FAINT)] if k % 3 == 0 else None
    return tp.Scene(lamps, [*walls, *_objects(space, faint)], [detector])


def without_specular(scene: tp.Scene) -> tp.Scene:
    """The same room, its specular objects black."""
    names = {surface.name for surface in specular_surfaces(scene)}
    surfaces = [
        replace(surface, material=tp.Black()) if surface.name in names else surface
        for surface in scene.surfaces
    ]
    return replace(scene, surfaces=tuple(surfaces))


def specular_surfaces(scene: tp.Scene) -> list[tp.Surface]:
    """The objects that are not walls."""
    return [surface for surface in scene.surfaces if surface.name.startswith("object")]


def radiances(scene: tp.Scene) -> list[float]:
    """Of each lamp with an area [W m^-2 sr^-1]."""
    shapes = [(scene.shape_of(lamp), lamp) for lamp in scene.sources]
    return [
        lamp.amount(shape, None) / (pi * shape.area)
        for shape, lamp in shapes
        if not isinstance(shape, tp.Point)
    ]


def power_of(scene: tp.Scene) -> float:
    """Of all lamps [W]."""
    return sum(lamp.amount(scene.shape_of(lamp), None) for lamp in scene.sources)


def _walls(rng: np.random.Generator, size: np.ndarray) -> tuple[list[tp.Surface], float | None]:
    """Six faces of one albedo or of six, and perhaps a wall between two rooms, with the place of that."""
    box = tp.Box(size=tuple(map(float, size)))
    if rng.random() < 0.5:
        walls = [tp.Surface(box, tp.Diffuse(float(rng.uniform(0.1, 0.8))), "room")]
    else:
        walls = [
            tp.Surface(face, tp.Diffuse(float(rng.uniform(0.05, 0.85))), name)
            for name, face in box.faces().items()
        ]
    if rng.random() > 1 / 3:
        return walls, None
    parting = float(rng.uniform(-0.2, 0.2) * size[0])
    lengths = {"width": float(1.05 * size[1]), "height": float(1.05 * size[2])}
    place = {"center": (parting, 0.0, 0.0), "normal": (1.0, 0.0, 0.0), "up": (0.0, 0.0, 1.0)}
    middle = (parting, *(float(x) for x in rng.uniform(-0.25, 0.25, 2) * size[1:]))
    kind = rng.integers(3)
    if kind == 0:
        hole: Shape = tp.Disk(center=middle, normal=(1, 0, 0), radius=float(rng.uniform(0.15, 0.4)))
    else:  # a door, or a slit
        width, height = (
            (rng.uniform(0.3, 0.9), rng.uniform(0.4, 0.9)) if kind == 1 else (0.04, rng.uniform(0.6, 0.9))
        )
        hole = tp.Rectangle(**place | {"center": middle}, width=float(width), height=float(height))
    screen = tp.Rectangle(**place, **lengths, hole=hole)
    return [*walls, tp.Surface(screen, tp.Diffuse(float(rng.uniform(0.2, 0.8))), "parting")], parting


def _detector(space: Space, least: float) -> tp.Detector:
    """A disk or a rectangle somewhere, turned anyhow; least: its least radius [m]."""
    radius = float(np.exp(space.rng.uniform(np.log(least), np.log(0.2))))
    return tp.Detector(_flat(space.rng, *space.place(radius)), "m")


def _lamps(space: Space, has_point: bool) -> list[tp.Source]:
    """One to three of them."""
    rng = space.rng
    count = int(rng.integers(1, 4))
    found = [_lamp(space) for _ in range(count - has_point)]
    if has_point:
        place, _ = space.place(0.02)
        found.append(tp.Source(tp.Point(position=place), tp.Isotropic(power=float(rng.uniform(10, 100)))))
    return found


def _lamp(space: Space) -> tp.Source:
    """A disk or a rectangle, turned anyhow, or a ball."""
    rng = space.rng
    power = tp.Lambertian(power=float(rng.uniform(10, 100)))
    if rng.random() < 0.2:
        center, radius = space.place(float(rng.uniform(0.02, 0.08)))
        return tp.Source(tp.Sphere(center=center, radius=radius), power)
    return tp.Source(_flat(rng, *space.place(float(rng.uniform(0.04, 0.25)))), power)


def _objects(space: Space, faint: str | None) -> list[tp.Surface]:
    """One to three mirrors, glossy sheets, balls and slabs; all balls of a room are of glass, or all of metal.

    "backward" refuses glass beside a mirror ball, in a parted room or outside of the room: it does not know the index of
    refraction about the lamp then.
    """
    rng = space.rng
    has_glass = rng.random() < 0.8 and space.parting is None and faint != "outside"
    return [
        tp.Surface(*_object(space, faint, has_glass), f"object {number}")
        for number in range(int(rng.integers(1, 4)))
    ]


def _object(space: Space, faint: str | None, has_glass: bool) -> tuple[Shape, Material]:
    rng = space.rng
    kind = (
        "sheet"
        if faint == "dark"
        else rng.choice(["sheet", "sheet", "sheet", "ball", "slab" if has_glass else "ball"])
    )
    radius = float(rng.uniform(0.05, 0.4) if kind == "ball" else rng.uniform(0.1, 0.9))
    if faint == "small":
        radius = float(rng.uniform(0.001, 0.003))
    if faint == "outside":
        center = tuple(float(20 * rng.uniform(1.0, 2.0) * x) for x in _direction(rng))
    else:
        center, radius = space.place(radius)
    if kind == "sheet":
        return _flat(rng, center, radius), _sheet(rng, faint)
    if kind == "ball":
        glass, metal = tp.Dielectric(float(rng.uniform(1.3, 1.8))), tp.Mirror(float(rng.uniform(0.5, 1.0)))
        return tp.Sphere(center=center, radius=radius), glass if has_glass else metal
    size = np.array((1.0, 1.0, 0.1))[rng.permutation(3)] * 2 * radius / np.sqrt(2.01)
    return tp.Box(center=center, size=tuple(map(float, size))), tp.Dielectric(float(rng.uniform(1.3, 1.8)))


def _flat(rng: np.random.Generator, center: Vector, radius: float) -> tp.Disk | tp.Rectangle:
    """A disk, or a rectangle of that half diagonal [m], turned anyhow."""
    if rng.random() < 0.4:
        return tp.Disk(center=center, normal=_direction(rng), radius=radius)
    turn = rng.uniform(0.3, 1.2)
    lengths = {"width": float(2 * radius * np.cos(turn)), "height": float(2 * radius * np.sin(turn))}
    return tp.Rectangle(center=center, normal=_direction(rng), **lengths)


def _sheet(rng: np.random.Generator, faint: str | None) -> Material:
    """What a sheet is made of."""
    if faint == "dark":
        return tp.Mirror(float(rng.uniform(1e-5, 1e-4)))
    kind = rng.integers(4)
    if kind == 0:
        return tp.Mirror(float(rng.uniform(0.5, 1.0)))
    if kind == 1:
        share = float(rng.uniform(0.2, 0.7))
        return tp.Mirror(share, float(rng.uniform(0.5, 1.0)) * (1 - share))
    if kind == 2:
        return tp.Glossy(float(np.exp(rng.uniform(np.log(0.02), np.log(0.5)))), float(rng.uniform(0.5, 1.0)))
    share = float(rng.uniform(0.2, 0.8))
    return tp.Mixture(
        {tp.Mirror(float(rng.uniform(0.6, 1.0))): share, tp.Diffuse(float(rng.uniform(0.2, 0.8))): 1 - share}
    )


def _direction(rng: np.random.Generator) -> Vector:
    """Evenly over the sphere."""
    normal = rng.normal(size=3)
    return tuple(float(x) for x in normal / np.linalg.norm(normal))
