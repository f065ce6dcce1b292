"""Random worlds: things in the cells of a grid, a room about them or none, lamps, meters, media, clocks, and a way to run it."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from hypothesis import strategies as st

import transport as tp
from tests.fuzz import contacts, lamps, looks, shapes, stuff
from transport.compile.methods import methods_for
from transport.geometry.mesh import Mesh
from transport.scene.phase_functions import Phase, PiecewiseLinear
from transport.statistics.any_estimate import AnyEstimate
from transport.vectors import Vector

PITCH, WITHIN = 1.0, 0.45  # of the grid [m]; the ball that holds what is in a cell
ROOM = 2.0 * PITCH  # inner size [m]
OFFSETS = (0.0, 0.0, 0.0, 0.1, -17.0, 1e3, 1e6)  # of the grid from the origin [m]
MIDDLES = st.tuples(*[st.sampled_from(OFFSETS)] * 3)
SLOW = 500.0  # m/s, of particles
MOST_RETURNED = 0.9  # by the walls of a room, so that every history ends soon


@dataclass(frozen=True)
class World:
    """What a scene is made of, and how it is run.

    parts: parameters of tp.Scene;  options: of tp.simulate;  way: which of the ways that the scene allows;
    unit: powers of two by which lengths and powers are multiplied [m, W];  free: a place [m] where no body is;
    views: what looks at it in a run of their own, that goes backwards.
    """

    parts: dict[str, Any]
    options: dict[str, Any] = field(default_factory=dict)
    way: int = 0
    particles: int = 2000
    unit: tuple[int, int] = (0, 0)
    free: Vector | None = None
    views: tuple = ()

    def scene(self) -> tp.Scene:
        """The scene.  Raises SceneError where it is refused."""
        return tp.Scene(**scaled_parameters("Scene", self.parts, 2.0 ** self.unit[0], 2.0 ** self.unit[1]))

    def said(self, scene: tp.Scene) -> dict[str, Any]:
        """What simulate is told beside the scene, the number of threads aside."""
        methods = methods_for(scene)
        options = {name: scaled(value, 2.0 ** self.unit[0], 1.0) for name, value in self.options.items()}
        how = {}  # that the run is refused for, where there is no way
        if methods:
            method = methods[self.way % len(methods)]
            how = {"estimator": method.estimator, "sampling": method.sampling}
        return how | options | {"particles": self.particles, "seed": 1, "batches": 8, "progress": False}

    def in_units(self, length: int, power: int) -> World:
        """The same with lengths and powers multiplied by these powers of two."""
        return dataclasses.replace(self, unit=(self.unit[0] + length, self.unit[1] + power))

    def with_detectors(self, *detectors) -> World:
        """The same, looked at by these alone."""
        return dataclasses.replace(self, parts=self.parts | {"detectors": detectors})

    def __repr__(self) -> str:
        try:
            scene = self.scene()
            said = ", ".join(f"{name}={written(value)}" for name, value in self.said(scene).items())
            return f"scene = {written(scene)}\nresult = tp.simulate(scene, {said})"
        except tp.SceneError as refusal:
            parts = ", ".join(f"{name}={written(part)}" for name, part in self.parts.items())
            return f"tp.Scene({parts})  # in units of 2**{self.unit}: {refusal}"


@st.composite
def worlds(draw) -> World:
    """A world of light or, in one of five, of particles; in one of four, and with particles, a clock runs."""
    light = draw(st.sampled_from([True] * 4 + [False]))
    clock = draw(st.sampled_from([False] * 3 + [True])) or not light
    duration = draw(st.sampled_from([0.01, 1.0, 8.0])) * ROOM / tp.speed_of_light if clock else None
    middle = draw(MIDDLES)
    cells, medium, surfaces = draw(matter(middle, light))
    lamp = lamps.lamps(surfaces, cells.pop(), middle, light, duration)
    sources = draw(st.lists(lamp, min_size=1, max_size=2))
    detectors = draw(looks.looks(surfaces, cells, middle, duration, light))
    options = {} if clock else draw(_tracking(middle))
    return draw(assembled(sources, surfaces, detectors, medium, duration, options))


@st.composite
def clocked_worlds(draw) -> World:
    """A world in which a clock runs, of light or particles, without detectors."""
    light = draw(st.booleans())
    middle = draw(MIDDLES)
    duration = draw(st.sampled_from([0.5, 1.0, 8.0])) * ROOM / (tp.speed_of_light if light else SLOW)
    cells, medium, surfaces = draw(matter(middle, light))
    lamp = lamps.lamps(surfaces, cells.pop(), middle, light, duration)
    sources = draw(st.lists(lamp, min_size=1, max_size=2))
    return draw(assembled(sources, surfaces, (), medium, duration))


@st.composite
def bright_worlds(draw) -> World:
    """A steady world of light, lit widely and metered plainly, so that several ways lead to good estimates."""
    middle = (0.1, 0.0, -17.0)
    cells, medium, surfaces = draw(matter(middle, light=True))
    sources = draw(st.lists(lamps.wide_lamps(cells.pop()), min_size=1, max_size=2))
    detectors = draw(looks.plain_looks(surfaces, cells, middle))
    world = draw(assembled(sources, surfaces, detectors, medium))
    return dataclasses.replace(world, free=cells[0])


@st.composite
def matter(draw, middle: Vector, light: bool) -> tuple[list[Vector], tp.Medium | None, list[tp.Surface]]:
    """The cells that are left, what fills the space between, and the room and the things in it."""
    cells = draw(st.permutations(cells_about(middle)))
    things = [draw(_thing(cells.pop(), light, k)) for k in range(draw(st.integers(0, 3)))]
    if draw(st.integers(0, 2)) == 0:
        things += draw(contacts.pairs(cells.pop()))
    medium = draw(st.one_of(st.none(), st.none(), stuff.media(ROOM))) if light else None
    return cells, medium, _filled([*draw(_room(middle)), *things], medium)


@st.composite
def assembled(draw, sources, surfaces, detectors, medium, duration=None, options=None) -> World:
    """These parts in some units, and some way to run them."""
    parts = {"sources": tuple(sources), "surfaces": tuple(surfaces), "detectors": tuple(detectors)}
    parts |= {"medium": medium, "duration": duration}
    unit = draw(st.tuples(st.integers(-30, 30), st.integers(-40, 40)))
    return World(parts, options or {}, draw(st.integers(0, 11)), draw(st.sampled_from([500, 2000])), unit)


def cells_about(middle: Vector) -> list[Vector]:
    """The middles [m] of the eight cells."""
    halves = (-PITCH / 2, PITCH / 2)
    shifts = [(x, y, z) for x in halves for y in halves for z in halves]
    return [tuple(m + s for m, s in zip(middle, shift, strict=True)) for shift in shifts]


@st.composite
def _room(draw, middle: Vector) -> list[tp.Surface]:
    """No walls, a box, a ball, a floor without end, or a floor and a ceiling."""
    kind = draw(st.sampled_from(["none", "none", "box", "ball", "floor", "gap", "mesh"]))
    walls = stuff.opaque(MOST_RETURNED)
    x, y, z = middle
    match kind:
        case "none":
            return []
        case "box":
            size = ROOM * draw(st.sampled_from([1.0, 1.0, 3.0]))
            return [tp.Surface(tp.Box(center=middle, size=size), draw(walls), "room")]
        case "ball":
            return [tp.Surface(tp.Sphere(center=middle, radius=ROOM), draw(walls), "room")]
        case "mesh":
            return [tp.Surface(tp.Mesh.box(center=middle, size=ROOM), draw(walls), "room")]
    floor = tp.Surface(tp.Plane(center=(x, y, z - ROOM / 2)), draw(walls), "floor")
    if kind == "floor":
        return [floor]
    return [floor, tp.Surface(tp.Plane(center=(x, y, z + ROOM / 2)), draw(walls), "ceiling")]


@st.composite
def _thing(draw, place: Vector, light: bool, number: int) -> tp.Surface:
    """A surface in a cell: an opaque one, a sheet, a body of glass, of fog or of voxels."""
    name = f"thing {number}"
    kind = draw(st.sampled_from(["sheet", "sheet", "closed", "fog", "glass", "voxels"]))
    if kind == "sheet" or (not light and kind == "glass"):
        shape = draw(shapes.sheets(place, WITHIN))
        return tp.Surface(shape, draw(stuff.of_shape(shape, light)), name)
    if kind == "voxels":
        grid = draw(stuff.grids(draw(shapes.boxes(place, WITHIN))))
        return tp.Surface(grid.box, tp.Transparent(), name, inside=grid)
    shape = draw(shapes.closed(place, WITHIN))
    if kind == "closed":
        return tp.Surface(shape, draw(stuff.opaque()), name)
    if kind == "fog":
        return tp.Surface(shape, tp.Transparent(), name, inside=draw(stuff.media(2 * WITHIN)))
    index = draw(stuff.indices())
    filling = draw(st.sampled_from([None, "clear", "turbid"]))
    if filling is None:
        return tp.Surface(shape, tp.Dielectric(index), name)
    turbid = draw(stuff.turbid(2 * WITHIN, index)) if filling == "turbid" else tp.Medium(index=index)
    return tp.Surface(shape, tp.Dielectric(index), name, inside=turbid)


def _filled(surfaces: list[tp.Surface], medium: tp.Medium | None) -> list[tp.Surface]:
    """Glass says what it is of where any medium is named."""
    if medium is None and all(surface.back is None for surface in surfaces):
        return surfaces
    return [_of_glass(surface) if surface.back is None else surface for surface in surfaces]


def _of_glass(surface: tp.Surface) -> tp.Surface:
    if not isinstance(surface.material, tp.Dielectric):
        return surface
    glass = tp.Medium(index=surface.material.index_inside)
    return tp.Surface(surface.shape, surface.material, surface.name, back=glass)


@st.composite
def _tracking(draw, middle: Vector) -> dict[str, Any]:
    """How histories go through media, mostly left out."""
    splitting = tp.Splitting(start=middle, end=tuple(x + PITCH for x in middle), gain=4.0)
    said = [None, None, "analog", "weighted", tp.Tracking(forced=True), tp.Tracking(splitting=splitting)]
    tracking = draw(st.sampled_from([*said, tp.Tracking(roulette=1.0)]))
    return {} if tracking is None else {"tracking": tracking}


# ---- a scene in another unit of length and of power: factors of each parameter and of each quantity ----

# Powers of the factors of length and of power.  Light keeps its speed, so that times go as lengths.
POWERS = {
    **dict.fromkeys(
        ("center", "position", "radius", "inner_radius", "top_radius", "width", "height"), (1, 0)
    ),
    **dict.fromkeys(
        ("size", "thickness", "focal_length", "aperture", "focus", "vertices", "sigma", "start", "end"),
        (1, 0),
    ),
    **dict.fromkeys(("duration", "time", "stop"), (1, 0)),
    **dict.fromkeys(("absorption", "scattering"), (-1, 0)),
    **dict.fromkeys(("power", "intensity", "number"), (0, 1)),
    **dict.fromkeys(("radiance", "irradiance"), (-2, 1)),
    **dict.fromkeys(("emission", "density"), (-3, 1)),
    "exitance": (-2, 1),
    "energy": (1, 1),
    ("Effusive", "exitance"): (-3, 1),  # a number over area and time
    ("Maxwellian", "sigma"): (0, 0),  # a speed
    "look_at": (1, 0),
    **{("PhaseSpace", axis): (1, 0) for axis in "xyz"},
}
OF_SYMBOLS = {"m": 1, "s": 1}
WITHOUT_AMOUNT = ("counts", "mean_", "variance_", "temperature")  # what does not grow with what is emitted


def scaled(value: object, length: float, power: float) -> object:
    """A part of a scene, with all that has a unit multiplied."""
    if isinstance(value, tuple):
        return tuple(scaled(each, length, power) for each in value)
    if not dataclasses.is_dataclass(value) or (isinstance(value, Phase) and getattr(value, "is_phase", True)):
        return value
    given = {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.init}
    return dataclasses.replace(value, **scaled_parameters(type(value).__name__, given, length, power))


def scaled_parameters(kind: str, given: dict[str, object], length: float, power: float) -> dict[str, object]:
    """Parameters of an object of that kind by their names, with all that has a unit multiplied."""
    found = {}
    for name, value in given.items():
        powers = POWERS.get((kind, name)) or POWERS.get(name)
        if value is None or not powers or dataclasses.is_dataclass(value):
            found[name] = scaled(value, length, power)
        else:
            found[name] = _multiplied(value, length ** powers[0] * power ** powers[1])
    return found


def _multiplied(given: object, factor: float) -> object:
    if isinstance(given, tuple):
        return tuple(_multiplied(each, factor) for each in given)
    if isinstance(given, str):
        return given
    return np.multiply(given, factor) if isinstance(given, np.ndarray) else given * factor


def factor_of(name: str, quantity: AnyEstimate, length: float, power: float, is_light: bool) -> float:
    """By what a quantity of that name should have grown."""
    powers = dict(quantity.unit.powers)
    grows = sum(float(powers.get(symbol, 0)) * by for symbol, by in OF_SYMBOLS.items())
    of_energy = 1 if is_light else 0  # a power over a time; a mass and its speed keep their energy
    grows += float(powers.get("J", 0)) * of_energy + float(powers.get("Pa", 0)) * (of_energy - 3)
    return length**grows * (1.0 if name.startswith(WITHOUT_AMOUNT) else power)


# ---- a scene as the lines of Python that make it ----

ALIASES = ("outside", "inside")  # of front and back


def written(value: object) -> str:
    """An expression in `tp`, `np` and `math` that makes the value again."""
    if isinstance(value, Mesh):
        arrays = f"vertices={written(value.vertices)}, faces={written(value.faces)}"
        return f"tp.Mesh({arrays})"
    if isinstance(value, PiecewiseLinear):
        return written(value.values)
    if dataclasses.is_dataclass(value):
        return f"tp.{getattr(type(value), 'written', type(value).__name__)}({', '.join(_parameters(value))})"
    if isinstance(value, np.ndarray):
        return f"np.array({value.tolist()!r})"
    if isinstance(value, tuple | list):
        return f"({', '.join(map(written, value))}{',' * (len(value) == 1)})"
    if isinstance(value, float) and not math.isfinite(value):
        return f"float({str(value)!r})"
    return repr(value)


def _parameters(value: object) -> list[str]:
    """Parameters that are not what they would be anyway, by their names."""
    found = []
    for each in dataclasses.fields(value):
        if not each.init or each.name in ALIASES:
            continue
        given = getattr(value, each.name)
        if not _is_default(each, given):
            found.append(f"{each.name}={written(given)}")
    return found


def _is_default(field: dataclasses.Field, given: object) -> bool:
    if field.default_factory is not dataclasses.MISSING:
        return given == field.default_factory()
    return (
        field.default is not dataclasses.MISSING
        and type(given) is type(field.default)
        and given == field.default
    )
