"""Random furnished rooms: boxes on a floor, against walls, on, beside and within one another.

Each room is a pure function of its number. Its faces lie on a lattice of integers, so that contacts and
uncovered areas are exact; lengths, offsets and roundings of the coordinates come afterwards.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass, field

from scipy.integrate import quad

import transport as tp
from tests.fuzz.rooms import kept
from transport.geometry.shape import Shape
from transport.scene.materials import Material
from transport.scene.sources import Source
from transport.vectors import Vector

N = 10_000  # lattice steps across a room
OPEN = N // 4  # steps that furniture may stand beyond the edge of a floor without walls
GAP = 1e-7  # of the room, between boxes that would touch
SCALES = (-6.0, 6.0)  # decades of the size of a room [m]
OFFSETS = (0.0, 0.0, 0.3, -17.0, 1e3, -1e5)  # of a room from the origin, in its sizes
MOST_RETURNED = 0.9
MOST_BOXES, ATTEMPTS = 8, 60
SIDES = ("front", "back")
SKY = 5.0  # radius of what closes an open scene, in sizes of the room

Steps = tuple[int, int, int]
Patch = tuple[
    int, int, int, int
]  # a rectangle of a plane: low and high along the first, then along the second axis
REACH = 0.95  # of a lamp, of the distance to what is nearest
EVERYWHERE = (-3 * N, 4 * N, -3 * N, 4 * N)


@dataclass(frozen=True)
class Block:
    """A box on the lattice, and the number of the block that it is in, if any."""

    low: Steps
    high: Steps
    parent: int | None = None

    def face(self, axis: int) -> Patch:
        """The face across an axis."""
        a, b = (k for k in range(3) if k != axis)
        return self.low[a], self.high[a], self.low[b], self.high[b]

    def is_apart(self, other: Block) -> bool:
        """Whether two blocks have no volume in common."""
        return any(
            h <= low or high <= o
            for low, high, o, h in zip(self.low, self.high, other.low, other.high, strict=True)
        )

    def is_in(self, other: Block) -> bool:
        """Whether it lies in another block; faces may touch."""
        return all(a >= b for a, b in zip(self.low, other.low, strict=True)) and all(
            a <= b for a, b in zip(self.high, other.high, strict=True)
        )

    def distance(self, place: Vector) -> float:
        """Distance [steps] of a place from the solid."""
        return math.hypot(
            *(max(a - x, x - b, 0.0) for a, x, b in zip(self.low, place, self.high, strict=True))
        )

    def depth(self, place: Vector) -> float:
        """Distance [steps] of a place within from the nearest face; negative for one outside."""
        return min(min(x - a, b - x) for a, x, b in zip(self.low, place, self.high, strict=True))


@dataclass(frozen=True)
class Slate:
    """An open surface of the lattice, across an axis: rectangles, less others, or a disk."""

    name: str
    axis: int = 2
    at: int = 0
    parts: tuple[Patch, ...] = ()
    holes: tuple[Patch, ...] = ()
    disk: tuple[int, int, int] | None = None  # middle, radius
    round_hole: tuple[int, int, int] | None = None

    def area_in(self, patch: Patch) -> float:
        """Area [steps^2] of what lies within a rectangle of its plane."""
        found = sum(common(patch, part) for part in self.parts)
        found -= sum(common(patch, hole) for hole in self.holes)
        if self.disk is not None:
            found += area_of_disk(self.disk, patch)
        return found - (0.0 if self.round_hole is None else area_of_disk(self.round_hole, patch))


@dataclass(frozen=True)
class Furnished:
    """A furnished room: blocks and slates of the lattice, and how the lattice lies in the world.

    room: whether block 0 is a room that holds all others; else the floor is a slate or a plane.
    """

    number: int
    room: bool
    blocks: tuple[Block, ...]
    slates: tuple[Slate, ...]
    materials: tuple[Material, ...]  # of the blocks, then of the slates or of the plane
    scale: float  # m, of N steps
    offset: Vector  # m
    roundings: tuple[int, ...]  # ways to write the coordinates, by block
    floor: str = "room"
    places: dict[int | str, list[tuple[Vector, float]]] = field(
        default_factory=dict
    )  # of a lamp, of a map: by region

    def name(self, block: int) -> str:
        """The name of the surface of a block."""
        return "room" if self.room and block == 0 else f"box {block}"

    @property
    def step(self) -> float:
        """Length [m] of a step."""
        return self.scale / N

    def at(self, place: Vector) -> Vector:
        """A place of the lattice in the world [m]."""
        return tuple(o + self.step * x for o, x in zip(self.offset, place, strict=True))

    # ---- shapes

    def box(self, number: int, gap: float = 0.0) -> tp.Box:
        """The box of a block, smaller on each side by a gap [m] per block that holds it; top ones by one."""
        block = self.blocks[number]
        inset = gap * self._depth(number)
        way = self.roundings[number]
        center, size = [], []
        for axis, (low, high, o) in enumerate(zip(block.low, block.high, self.offset, strict=True)):
            first, last = o + self.step * low, o + self.step * high
            if (way >> axis) & 1:
                center.append(o + self.step * ((low + high) / 2))
                size.append(self.step * (high - low) - 2 * inset)
            else:
                center.append((first + last) / 2)
                size.append((last - first) - 2 * inset)
        if way & 8:
            center[2] = math.nextafter(center[2], math.inf if way & 16 else -math.inf)
        return tp.Box(center=center, size=size)

    def _depth(self, number: int) -> int:
        parent = self.blocks[number].parent
        if self.room and number == 0:
            return 0
        return 1 if parent is None else 1 + self._depth(parent)

    def slate(self, slate: Slate) -> Shape:
        """The shape of an open surface."""
        normal = tuple(float(k == slate.axis) for k in range(3))
        if slate.disk is not None:
            x, y, r = slate.disk
            return tp.Disk(center=self.at((x, y, slate.at)), normal=normal, radius=self.step * r)
        if len(slate.parts) > 1:  # an L
            (x0, x1, y0, y1), (_, x2, _, y2) = slate.parts
            corners = [(x0, y0), (x1, y0), (x1, y1), (x2, y1), (x2, y2), (x0, y2)]
            return tp.Polygon(vertices=[self.at((x, y, slate.at)) for x, y in corners])
        hole = None
        if slate.round_hole is not None:
            x, y, r = slate.round_hole
            hole = tp.Disk(center=self.at((x, y, slate.at)), normal=normal, radius=self.step * r)
        elif slate.holes:
            hole = self._rectangle(slate, slate.holes[0], None)
        return self._rectangle(slate, slate.parts[0], hole)

    def _rectangle(self, slate: Slate, patch: Patch, hole: Shape | None) -> tp.Rectangle:
        (a0, a1, b0, b1), normal = patch, [0.0, 0.0, 0.0]
        normal[slate.axis] = 1.0
        middle = [(a0 + a1) / 2, (b0 + b1) / 2]
        middle.insert(slate.axis, slate.at)
        first, second = (a1 - a0) * self.step, (b1 - b0) * self.step
        # Width lies along y of a surface across x, along z of one across y (its default frame), else along x.
        made = tp.Rectangle(
            center=self.at(tuple(middle)), normal=normal, width=first, height=second, hole=hole
        )
        low, high = made.bounds
        axes = [k for k in range(3) if k != slate.axis]
        if not math.isclose(high[axes[0]] - low[axes[0]], first, rel_tol=1e-3):
            made = tp.Rectangle(center=made.center, normal=normal, width=second, height=first, hole=hole)
        return made

    def surfaces(self, gap: float = 0.0) -> list[tp.Surface]:
        """All surfaces; gap: between boxes, as a share of the room."""
        found = [
            tp.Surface(self.box(number, gap * self.scale), self.materials[number], self.name(number))
            for number in range(len(self.blocks))
        ]
        rest = self.materials[len(self.blocks) :]
        found += [
            tp.Surface(self.slate(each), m, each.name) for each, m in zip(self.slates, rest, strict=False)
        ]
        if self.floor == "plane":
            found.append(tp.Surface(tp.Plane(center=self.at((0, 0, 0))), rest[0], "floor"))
        return found

    # ---- what is left uncovered

    def uncovered(self) -> dict[tuple[str, str], float]:
        """Area [m^2] of each side of each surface on which it acts."""
        found = {}
        for number in range(len(self.blocks)):
            whole = sum(patch_area(self.blocks[number].face(axis)) * 2 for axis in range(3))
            if not (self.room and number == 0):
                found[self.name(number), "front"] = whole - self._covered_outside(number)
            found[self.name(number), "back"] = whole - self._covered_within(number)
        for slate in self.slates:
            for side, lies in (("front", 0), ("back", 1)):
                touching = [
                    block.face(slate.axis)
                    for block in self.blocks
                    if block.parent is None and (block.low, block.high)[lies][slate.axis] == slate.at
                ]
                covered = sum(map(slate.area_in, touching))
                found[slate.name, side] = slate.area_in(EVERYWHERE) - covered
        return {name: area * self.step**2 for name, area in found.items()}

    def _covered_within(self, number: int) -> float:
        """Area [steps^2] of the inner side of a block that the faces of blocks in it cover."""
        block = self.blocks[number]
        return sum(
            patch_area(child.face(axis))
            * ((child.low[axis] == block.low[axis]) + (child.high[axis] == block.high[axis]))
            for child in self.blocks
            if child.parent == number
            for axis in range(3)
        )

    def _covered_outside(self, number: int) -> float:
        """Area [steps^2] of the outer side that the block about it, neighbours and open surfaces cover."""
        return sum(self._covered_face(number, axis, end) for axis in range(3) for end in (0, 1))

    def _covered_face(self, number: int, axis: int, end: int) -> float:
        block = self.blocks[number]
        level, face = (block.low, block.high)[end][axis], block.face(axis)
        if block.parent is not None:
            about = self.blocks[block.parent]
            if (about.low, about.high)[end][axis] == level:
                return patch_area(face)
        if self.floor == "plane" and axis == 2 and level == 0:
            return patch_area(face)
        slates = [slate for slate in self.slates if slate.axis == axis and slate.at == level]
        covered = sum(slate.area_in(face) for slate in slates) if block.parent is None else 0.0
        for other, neighbour in enumerate(self.blocks):
            if other == number or neighbour.parent != block.parent or (self.room and other == 0):
                continue
            if (neighbour.high, neighbour.low)[end][axis] == level:
                both = intersection(face, neighbour.face(axis))
                if both is not None:
                    covered += patch_area(both) - sum(slate.area_in(both) for slate in slates)
        return covered

    # ---- light

    def glow(self, surface: tp.Surface) -> Iterator[Source]:
        """What the sides of a surface emit where radiance is 1 everywhere: as much as they absorb."""
        for side in SIDES:
            share = kept(surface.material.sides[side == "back"])
            if share > 1e-6 and not (surface.name in ("room", "sky") and side == "front"):
                yield Source(surface.name, tp.Lambertian(radiance=share), side=side)

    def furnace(self, detectors) -> tp.Scene:
        """The room with surfaces that emit what they absorb; an open one in a large ball that does so too."""
        surfaces = self.surfaces()
        if not self.room:
            ball = tp.Sphere(center=self.at((N / 2, N / 2, 0)), radius=SKY * self.scale)
            surfaces.append(tp.Surface(ball, tp.Diffuse(0.5), "sky"))
        return tp.Scene([lamp for each in surfaces for lamp in self.glow(each)], surfaces, detectors)

    def lamps(self) -> list[Source]:
        """Lamps in the room and within blocks, and below an open floor."""
        draws = random.Random(f"lamps {self.number}")
        found = []
        for place, reach in (of_region[0] for of_region in self.places.values()):
            size = self.step * reach * draws.uniform(0.3, 0.9)
            center, normal = self.at(place), [draws.uniform(-1, 1) for _ in range(3)]
            flat = {"center": center, "normal": normal}
            shape = draws.choice(
                [
                    tp.Sphere(center=center, radius=size),
                    tp.Disk(**flat, radius=size),
                    tp.Rectangle(**flat, width=size, height=1.2 * size),
                    tp.Box(center=center, size=(size, 0.7 * size, 0.9 * size)),
                ]
            )
            found.append(Source(shape, tp.Lambertian(power=1.0)))
        return found

    def lit(self, detectors, gap: float = 0.0) -> tp.Scene:
        """The room lit by lamps."""
        return tp.Scene(self.lamps(), self.surfaces(gap), detectors)

    def meters(self, with_plane: bool = True) -> list[tp.Detector]:
        """Detectors of both sides of all surfaces; the outer side of a room made of a Box left out."""
        return [
            tp.Detector(each.name, f"{each.name} {side}", side)
            for each in self.surfaces()
            for side in SIDES
            if not (each.name == "room" and side == "front")
            if with_plane or not each.shape.is_infinite
        ]

    def probes(self) -> list[tp.Detector]:
        """Detectors to which rays can be sampled: free ones, open surfaces, faces not wholly covered."""
        draws = random.Random(f"probes {self.number}")
        found = []
        for key, (_, (place, reach)) in self.places.items():
            normal = [draws.uniform(-1, 1) for _ in range(3)]
            disk = tp.Disk(center=self.at(place), normal=normal, radius=0.5 * self.step * reach)
            found += [tp.Detector(disk, f"free {key} {side}", side) for side in SIDES]
        for slate in self.slates:
            found += [tp.Detector(slate.name, f"{slate.name} {side}", side) for side in SIDES]
            if slate.disk is None and len(slate.parts) == 1 and not slate.holes and slate.round_hole is None:
                by_place = tp.Positions(u=3, v=4)
                found.append(tp.Detector(slate.name, f"{slate.name} by place", positions=by_place))
        for number in draws.sample(range(len(self.blocks)), min(len(self.blocks), 3)):
            axis, end = draws.choice(range(3)), draws.choice([0, 1])
            if not self._is_between(number, axis, end):
                name = f"face {'xyz'[axis]}{end} of {self.name(number)}"
                face = self.box(number).faces()["-+"[end] + "xyz"[axis]]
                found += [tp.Detector(face, f"{name} {side}", side) for side in SIDES]
        return found

    def _is_between(self, number: int, axis: int, end: int) -> bool:
        """Whether a face is covered all over, on its outer or its inner side: detectors there are refused."""
        block = self.blocks[number]
        area, level = patch_area(block.face(axis)), (block.low, block.high)[end][axis]
        inner = sum(
            patch_area(child.face(axis))
            for child in self.blocks
            if child.parent == number and (child.low, child.high)[end][axis] == level
        )
        outer = 0 if self.room and number == 0 else self._covered_face(number, axis, end)
        return max(inner, outer) >= 0.999 * area

    def maps(self) -> list[tp.EnvironmentMap]:
        """What is seen from free places in the room and in blocks."""
        return [
            tp.EnvironmentMap(name=f"map {key}", position=self.at(self.places[key][-1][0]), theta=2, phi=2)
            for key in self.places
        ]


# ---- areas on the lattice


def intersection(one: Patch, other: Patch) -> Patch | None:
    """The rectangle that two have in common, if there is one."""
    a0, a1 = max(one[0], other[0]), min(one[1], other[1])
    b0, b1 = max(one[2], other[2]), min(one[3], other[3])
    return (a0, a1, b0, b1) if a0 < a1 and b0 < b1 else None


def patch_area(patch: Patch) -> int:
    """Area [steps^2]."""
    return (patch[1] - patch[0]) * (patch[3] - patch[2])


def common(one: Patch, other: Patch) -> int:
    """Area [steps^2] that two rectangles have in common."""
    both = intersection(one, other)
    return 0 if both is None else patch_area(both)


def area_of_disk(disk: tuple[int, int, int], patch: Patch) -> float:
    """Area [steps^2] of the part of a disk within a rectangle."""
    x, y, r = disk
    a0, a1, b0, b1 = patch[0] - x, patch[1] - x, patch[2] - y, patch[3] - y
    first, last = max(a0, -r), min(a1, r)
    if first >= last:
        return 0.0
    kinks = {s * math.sqrt(r * r - b * b) for b in (b0, b1) if abs(b) < r for s in (-1, 1)}
    marks = [first, *sorted(k for k in kinks if first < k < last), last]

    def chord(t: float) -> float:
        half = math.sqrt(max(r * r - t * t, 0.0))
        return max(min(b1, half) - max(b0, -half), 0.0)

    return sum(quad(chord, *ends)[0] for ends in zip(marks, marks[1:], strict=False))


# ---- a room by its number


def furnished(number: int) -> Furnished:
    """The furnished room of that number."""
    draws = random.Random(f"furnished {number}")
    floor = draws.choice(
        ["room", "room", "room", "rectangle", "disk", "holed", "ell", "plane", "walls", "walls"]
    )
    room = floor == "room"
    slates = _slates(draws, floor)
    blocks = [Block((0, 0, 0), (N, N, draws.choice([N, N // 2, 3 * N])))] if room else []
    first = len(blocks)
    for _ in range(ATTEMPTS * (count := draws.choice(range(1, MOST_BOXES + 1)))):
        if len(blocks) - first == count:
            break
        block = _proposed(draws, blocks, room, floor)
        if _fits(block, blocks) and not _hides(block, slates):
            blocks.append(block)
    materials = [_material(draws) for _ in (*blocks, *slates)]
    if floor == "plane":
        materials.append(draws.choice([tp.Diffuse(1.0), tp.Mirror(1.0), tp.Glossy(0.3, 1.0)]))
    scale = 10 ** draws.uniform(*SCALES)
    found = Furnished(
        number,
        room,
        tuple(blocks),
        slates,
        tuple(materials),
        scale,
        tuple(scale * draws.choice(OFFSETS) for _ in range(3)),
        tuple(draws.randrange(32) for _ in blocks),
        floor,
    )
    places = {key: _free_places(draws, found, key) for key in _regions(draws, found)}
    found.places.update({key: some for key, some in places.items() if some})
    return found


def _slates(draws: random.Random, floor: str) -> tuple[Slate, ...]:
    """The floor and walls of an open scene."""
    half, whole = N // 2, (0, N, 0, N)
    middle = (draws.randrange(N // 4, 3 * N // 4), draws.randrange(N // 4, 3 * N // 4))
    match floor:
        case "rectangle":
            return (Slate("floor", parts=((0, N, 0, draws.choice([N, N // 2])),)),)
        case "disk":
            return (Slate("floor", disk=(half, half, draws.choice([half, N // 4, N]))),)
        case "holed" if draws.random() < 0.5:
            return (Slate("floor", parts=(whole,), round_hole=(*middle, N // 10)),)
        case "holed":
            x, y = middle
            return (Slate("floor", parts=(whole,), holes=((x - 900, x + 900, y - 1500, y + 1500),)),)
        case "ell":
            x, y = middle
            return (Slate("floor", parts=((0, N, 0, y), (0, x, y, N))),)
        case "walls":
            height = draws.choice([N // 2, N])
            walls = [Slate("wall x", 0, 0, ((0, N, 0, height),)), Slate("wall y", 1, 0, ((0, N, 0, height),))]
            return (Slate("floor", parts=(whole,)), *walls[: draws.choice([1, 2])])
    return ()


def _proposed(draws: random.Random, blocks: list[Block], room: bool, floor: str) -> Block:
    """A block that touches something, in the room or in another block; it may be in the way of others."""
    parent = 0 if room else None
    movable = range(1 if room else 0, len(blocks))
    if movable and draws.random() < 0.25:
        parent = draws.choice(movable)
    if parent is not None:
        region, is_closed = blocks[parent], True
    else:
        least = (0 if floor == "walls" else -OPEN,) * 2
        region, is_closed = Block((*least, 0), (N + OPEN, N + OPEN, N)), False
    beside = [k for k in movable if blocks[k].parent == parent]
    kinds = ["stand", "stand", "wall", "corner", "tall", "hang", "mount"]
    kinds += ["on", "on", "same on", "across", "beside", "beside", "twin"] if beside else []
    kind = draws.choice(kinds)
    spans = [h - low for low, h in zip(region.low, region.high, strict=True)]
    size = [max(2, int(span * 10 ** draws.uniform(-2.0, -0.1))) for span in spans]
    low = [draws.randint(a, a + span - s) for a, span, s in zip(region.low, spans, size, strict=True)]
    axis = draws.choice([0, 1])
    if kind in ("stand", "wall", "corner", "tall"):
        low[2] = region.low[2]
    against = {"wall": [axis], "mount": [axis], "corner": [0, 1]}.get(kind, [])
    for k in against:
        low[k] = region.low[k]
        if is_closed and draws.random() < 0.5:
            low[k] = region.high[k] - size[k]
    if kind == "tall":
        size[2] = spans[2]
    if kind == "hang":  # from the ceiling, or below an open floor
        low[2] = region.high[2] - size[2] if is_closed else -size[2]
    if kind in ("on", "same on", "across", "beside", "twin"):
        other = blocks[draws.choice(beside)]
        extent = [h - a for a, h in zip(other.low, other.high, strict=True)]
        if kind in ("on", "same on", "across"):
            low[2] = other.high[2]
            if kind == "same on":
                low[:2], size[:2] = other.low[:2], extent[:2]
            elif kind == "across":  # beyond the edges on all sides
                more = draws.randint(1, N // 10)
                low[:2], size[:2] = [a - more for a in other.low[:2]], [e + 2 * more for e in extent[:2]]
            else:
                low[:2] = [
                    draws.randint(a - s + 1, a + e - 1)
                    for a, s, e in zip(other.low, size, extent[:2], strict=False)
                ]
        else:
            if kind == "twin":
                size = extent
                low = list(other.low)
            else:
                across = 1 - axis
                low[across] = draws.randint(other.low[across] - size[across] + 1, other.high[across] - 1)
                low[2] = other.low[2]
            low[axis] = draws.choice([other.low[axis] - size[axis], other.high[axis]])
    return Block(tuple(low), tuple(a + s for a, s in zip(low, size, strict=True)), parent)


def _fits(block: Block, blocks: list[Block]) -> bool:
    """Whether a block is within the one that it belongs to, unlike it, and apart from those beside it."""
    if block.parent is None:
        within = block.low[2] >= 0 or block.high[2] <= 0  # not through the floor
    else:
        about = blocks[block.parent]
        within = block.is_in(about) and (block.low, block.high) != (about.low, about.high)
    return within and all(block.is_apart(other) for other in blocks if other.parent == block.parent)


def _hides(block: Block, slates: tuple[Slate, ...]) -> bool:
    """Whether a face of a block covers all of an open surface, which is refused where anything is within."""
    return block.parent is None and any(
        slate.at in (block.low[slate.axis], block.high[slate.axis])
        and slate.area_in(block.face(slate.axis)) >= 0.999 * slate.area_in(EVERYWHERE)
        for slate in slates
    )


def _material(draws: random.Random) -> Material:
    """An opaque material, in one of five unlike on its two sides."""
    if draws.random() < 0.2:
        return tp.TwoSided(front=_plain(draws), back=_plain(draws))
    return _plain(draws)


def _plain(draws: random.Random) -> Material:
    share = draws.uniform(0.0, MOST_RETURNED)
    return draws.choice(
        [
            tp.Black(),
            tp.Diffuse(share),
            tp.Diffuse(share),
            tp.Mirror(share),
            tp.Glossy(draws.choice([0.1, 0.3, 1.0]), share),
            tp.Mixture({tp.Diffuse(share): 0.5, tp.Mirror(0.8): 0.25, tp.Black(): 0.25}),
        ]
    )


def _regions(draws: random.Random, made: Furnished) -> list[int | str]:
    """Where lamps are: in the room, below its floor, in up to two blocks."""
    movable = list(range(1 if made.room else 0, len(made.blocks)))
    chosen = draws.sample(movable, min(len(movable), draws.choice([0, 1, 2])))
    return ["room", *([] if made.room or draws.random() < 0.5 else ["below"]), *sorted(chosen)]


def _free_places(draws: random.Random, made: Furnished, region: int | str) -> list[tuple[Vector, float]]:
    """Places [steps] of a lamp and of a map in a region, each with its distance to the nearest solid."""
    if isinstance(region, int) or made.room:
        parent = 0 if region == "room" else region
        low, high = made.blocks[parent].low, made.blocks[parent].high
    else:
        parent, (first, last) = None, (0, N) if region == "room" else (-N, 0)
        low, high = (0, 0, first), (N, N, last)
    about = Block(low, high)
    others = [block for block in made.blocks if block.parent == parent and not (made.room and parent is None)]

    def clearance(place: Vector) -> float:
        return min([about.depth(place), *(other.distance(place) for other in others)])

    found = [tuple(draws.uniform(a, b) for a, b in zip(low, high, strict=True)) for _ in range(40)]
    lamp = max(found, key=clearance)
    reach = clearance(lamp)
    view = max(found, key=lambda place: min(clearance(place), math.dist(place, lamp) - REACH * reach))
    if reach <= 0 or clearance(view) <= 0 or math.dist(view, lamp) < REACH * reach:
        return []
    return [(lamp, reach), (view, clearance(view))]
