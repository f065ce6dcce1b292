"""Random detectors: on surfaces and on shapes of their own, with bins of all kinds; volumes and points; looks at an instant."""

from __future__ import annotations

import math

from hypothesis import strategies as st

import transport as tp
from tests.fuzz import contacts, shapes
from transport.geometry.flat import Disk, FlatShape, Rectangle
from transport.geometry.revolved import Cone, Cylinder, Paraboloid
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.scene.bins import DirectionCone
from transport.scene.materials import Surface
from transport.vectors import Vector, local_frame

METER = 0.4  # m
ALL = 10_000  # more than the histories of any world
FAST = 1e9  # m/s, beyond all speeds
THERMAL = 500.0  # m/s
PLACED = Disk | Rectangle | Sphere | Cylinder | Cone | Paraboloid  # shapes with coordinates


@st.composite
def looks(draw, surfaces: list[Surface], cells: list[Vector], middle: Vector, duration, light: bool) -> list:
    """One to three detectors, of which the last may ask what came by the first."""
    found = []
    for number in range(draw(st.integers(1, 3))):
        name = f"meter {number}"
        kind = draw(st.sampled_from(["own", "own", "surface", "volume", "point"]))
        if kind in ("own", "point") and duration is not None and draw(st.booleans()):
            found.append(draw(pictures(middle, duration, name, light)))
            continue
        if kind == "volume":
            found.append(draw(volumes(middle, name)))
        elif kind == "point" and light and duration is None and are_seen_by(surfaces):
            found.append(tp.PointDetector(tuple(x + 0.01 for x in cells[0]), name))
        else:
            via = [each.name for each in found if isinstance(each, tp.Detector)]
            named = [surface for surface in surfaces if not surface.shape.is_infinite]
            found.append(
                draw(meters(surfaces, named * (kind == "surface"), cells, middle, duration, name, via))
            )
    return found


@st.composite
def plain_looks(draw, surfaces: list[Surface], cells: list[Vector], middle: Vector) -> list:
    """Large meters without bins, a surface's, and a volume or a point."""
    found = draw(plain_meters(surfaces, cells, middle))
    last = draw(st.sampled_from(["volume", "point", None]))
    if last == "point" and are_seen_by(surfaces):
        found.append(tp.PointDetector(tuple(x + 0.01 for x in cells[1]), "point"))
    if last == "volume":
        found.append(tp.VolumeDetector(tp.Sphere(center=middle, radius=0.75), "volume"))
    return found


@st.composite
def plain_meters(draw, surfaces: list[Surface], cells: list[Vector], middle: Vector) -> list:
    """Large meters without bins, of their own and of surfaces."""
    normal, place = draw(shapes.directions()), cells[0]
    return [
        tp.Detector(
            tp.Disk(center=place, normal=normal, radius=METER),
            "disk",
            draw(st.sampled_from(["front", "back"])),
        ),
        tp.Detector(tp.Sphere(center=middle, radius=METER), "ball"),
        *(
            tp.Detector(each.name, side="back" if each.name == "room" else "front")
            for each in surfaces[:2]
            if not each.shape.is_infinite
        ),
    ]


@st.composite
def meters(
    draw,
    surfaces: list[Surface],
    named: list[Surface],
    cells: list[Vector],
    middle: Vector,
    duration,
    name,
    via,
) -> tp.Detector:
    """A meter on a surface, or one of its own in a cell or in the middle."""
    if named:
        surface = draw(st.sampled_from(named))
        what, shape = surface.name, surface.shape
    else:
        place = draw(st.sampled_from([middle, cells[0]]))
        kinds = (shapes.flat, shapes.flat, shapes.balls, shapes.boxes, shapes.sheets, shapes.meshes)
        own = [kind(place, METER) for kind in kinds]
        what = shape = draw(st.one_of([*contacts.patches(surfaces), *own]))
    side = draw(st.sampled_from(["front", "back"]))
    bins = {"directions": draw(directions(shape)), "positions": draw(positions(shape))}
    bins["times"] = None if duration is None else draw(st.sampled_from([None, 3]))
    bins["events"] = draw(st.sampled_from([None, None, None, 0, (1, math.inf), (0, 2)]))
    bins["via"] = draw(st.sampled_from([None, None, *via])) if via else None
    moments = duration is not None and draw(st.booleans())
    return tp.Detector(what, name, side, **bins, moments=moments)


def directions(shape: Shape) -> st.SearchStrategy:
    """Bins of direction that go with the shape, or none."""
    local = [tp.Directions(mu=4), tp.Directions(mu=3, phi=4), tp.Directions(theta=(0, 1e-3, 1.0))]
    is_plain = isinstance(shape, FlatShape) or (shape.is_closed and isinstance(shape, Sphere))
    world = [tp.Directions(mu=4, phi=2, frame="world"), oblique(shape)] if is_plain else []
    return st.sampled_from([None, *local, *world])


def oblique(shape: Shape) -> DirectionCone:
    """One bin about an oblique ray; on flat shapes it is cut by the horizon of either side."""
    if not isinstance(shape, FlatShape):
        return tp.Directions.cone((0, 0.6, 0.8), 0.3)
    e_u, _, n = local_frame(shape.normal, None)
    return tp.Directions.cone(tuple(u + 0.2 * m for u, m in zip(e_u, n, strict=True)), 0.3)


def positions(shape: Shape) -> st.SearchStrategy:
    """Bins of place on shapes that have coordinates, or none."""
    if not isinstance(shape, PLACED) or getattr(shape, "hole", None) is not None:
        return st.none()
    return st.sampled_from([None, None, tp.Positions(u=2, v=3), tp.Positions(v=5)])


def are_seen_by(surfaces: list[Surface]) -> bool:
    """Whether a point detector sees by all of them."""
    parts = [part for surface in surfaces for part in surface.material.elements]
    return all(isinstance(part, tp.Black | tp.Diffuse | tp.Transparent) for part in parts)


@st.composite
def volumes(draw, middle: Vector, name: str) -> tp.VolumeDetector:
    """A box or a ball about the middle, through whatever is there."""
    how = {"directions": draw(st.sampled_from([None, None, tp.Directions.sphere(mu=2, phi=3)]))}
    if draw(st.booleans()):
        cells = draw(st.sampled_from([None, (2, 3, 1), (4, 4, 4)]))
        return tp.VolumeDetector(tp.Box(center=middle, size=(1.5, 0.9, 1.2)), name, cells, **how)
    return tp.VolumeDetector(
        tp.Sphere(center=middle, radius=0.75), name, draw(st.sampled_from([None, 3])), **how
    )


@st.composite
def pictures(draw, middle: Vector, duration: float, name: str, light: bool) -> tp.PhaseSpace | tp.Snapshot:
    """A density or a sample, at both ends of the clock or between."""
    instants = [0.0, duration / 3, 0.8 * duration, duration]
    if draw(st.booleans()):
        return tp.Snapshot(draw(st.sampled_from(instants)), draw(st.sampled_from([1, 100, ALL])), name)
    bins = draw(st.sampled_from(axes_about(middle, light)))
    within = draw(st.sampled_from([None, tp.Box(center=middle, size=(1.5, 0.9, 1.2))]))
    time = draw(st.sampled_from([*instants, tuple(instants), (duration / 3,)]))
    return tp.PhaseSpace(**bins, time=time, name=name, within=within, moments=draw(st.booleans()))


def axes_about(middle: Vector, light: bool) -> list[dict]:
    """Bins of place about the middle, of velocity, of speed and of direction, one or two of them."""
    fast = tp.speed_of_light if light else THERMAL
    x, y, z = (tuple(m + edge for edge in (-1.0, -0.3, 0.1, 1.0)) for m in middle)
    speeds = (-fast, -0.5 * fast, 0.0, fast)
    return [
        {"x": x},
        {"y": y, "mu": 4},
        {"z": z, "vx": speeds},
        {"vy": speeds, "vz": speeds},
        {"speed": (0.0, 0.9 * fast, FAST)},
        {"mu": (-1.0, -0.5, 0.9), "speed": (0.0, FAST)},
    ]
