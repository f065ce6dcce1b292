"""Explain a detector without a score if geometry proves that no light can reach it.

The most common mistake is a reversed normal.  Each proof holds for every path of light, reflected and
scattered paths included, so the warning names the cause with certainty.  A detector that light missed by
chance gets no such warning.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from itertools import product, starmap
from typing import TYPE_CHECKING, Any

import numpy as np

from transport.compile.media import emitting_media
from transport.geometry.relations import are_on_one_support, is_behind, point_beside
from transport.geometry.shape import ROUNDING, Shape
from transport.scene.bodies import surrounding_medium
from transport.scene.checks.enclosures import ClosedPatches, ClosedShape, finite_enclosures
from transport.scene.detectors import Detector
from transport.scene.materials import (
    Surface,
)
from transport.scene.parts import join_surface_names
from transport.scene.sides import IS_BACK, OTHER_SIDE
from transport.validation import join_names
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.scene.scene import Scene
    from transport.scene.sides import AnyDetector
    from transport.scene.sources import Source

Room = ClosedShape | ClosedPatches
# A shape, and the side at which it counts or emits; None for a volume or a point.
Sided = tuple[Shape, str | None]


def proven(scene: Scene, key: Hashable, find: Callable[[], Any]) -> Any:
    """Return what `find` returns, computed once per scene and key (`Scene.proofs`)."""
    if key not in scene.proofs:
        scene.proofs[key] = find()
    return scene.proofs[key]


def no_light_message(
    scene: Scene, title: str, shape: Shape, detector: AnyDetector | None = None
) -> str | None:
    """Explain why no light can reach a detector; None if geometry does not prove it.

    Parameters
    ----------
    scene : Scene
        The scene as the user defined it, for forward and backward runs alike.
    title : str
        Name of the detector in the warning.
    shape : Shape
        The surface of a Detector, the volume of a VolumeDetector, or a Point.
    detector : AnyDetector, optional
        The detector; one of class Detector counts at one side of its surface.

    Returns
    -------
    str or None
        The cause and what to do.
    """
    is_sided = isinstance(detector, Detector)
    target = (shape, detector.side if is_sided else None)
    why = _enclosure_reason(scene, target) or _behind_sources_reason(scene, shape)
    if why is None and is_sided and _is_opaque(scene, detector) and _faces_away(scene, target):
        why = (
            f"its {target[1]} faces away from every source, and nothing in front of it reflects or scatters"
            f" light. Reverse its normal, or write side={_other_side(target)!r}"
        )
    return why and f"{title} counted nothing: {why}"


def cannot_arrive(scene: Scene, shape: Shape, detector: Detector, is_blind: bool) -> bool:
    """Return whether geometry proves that no light arrives at a detector, though light may depart from it.

    False if the user reads departures: on a surface by its name, and on a source.
    """
    if not is_blind and is_on_surface(scene, shape, detector):
        return False
    return _faces_away(scene, (shape, detector.side))


def is_on_surface(scene: Scene, shape: Shape, detector: Detector) -> bool:
    """Return whether a detector is on a named surface or on a source."""
    return isinstance(detector.shape, str) or _has_source_on(scene, shape)


def no_light_departs(scene: Scene, shape: Shape, detector: Detector) -> bool:
    """Return whether geometry proves that no light leaves the detector's side.

    No light reaches its other side, and it is no surface.
    """
    if is_on_surface(scene, shape, detector) or any(_share_support(shape, s.shape) for s in scene.surfaces):
        return False  # such a surface reflects arrivals
    return _faces_away(scene, (shape, OTHER_SIDE[detector.side]))


def no_arrival_warning(detectors: list[Detector]) -> str:
    """The warning about detectors at which no light can arrive."""
    names = join_names([repr(detector.name) for detector in detectors])
    why = "every source, and nothing in front of {} reflects or scatters light. Reverse {}, write side={},"
    why += " or read flux_out and exitance, which count light from {}"
    if len(detectors) > 1:
        why = why.format("them", "their normals", "'back' or 'front'", "behind")
        return f"no light can arrive at detectors {names}: they face away from {why}"
    side = detectors[0].side
    why = why.format("it", "its normal", repr(OTHER_SIDE[side]), f"its {OTHER_SIDE[side]}")
    return f"no light can arrive at detector {names}: its {side} faces away from {why}"


def are_separated(scene: Scene, one: Sided, other: Sided, number: int | None = None) -> bool:
    """Return whether an opaque room encloses one of two shapes and not the other: it blocks all light.

    number: index of the surface that the other shape is, if any; a room of which it is a wall separates it
    from nothing.
    """
    return any(
        (_is_certainly_inside(room, one) and _is_certainly_outside(room, other))
        or (_is_certainly_outside(room, one) and _is_certainly_inside(room, other))
        for room in _rooms_near(scene, one[0], other[0])
        if number not in room.numbers
    )


def _is_opaque(scene: Scene, detector: Detector) -> bool:
    """Return whether a detector is an opaque surface, so that nothing departs where nothing arrives."""
    return any(s.name == detector.shape and not s.material.is_transmissive for s in scene.surfaces)


def _has_source_on(scene: Scene, shape: Shape) -> bool:
    """Return whether a source lies on a shape, so that particles depart from the shape at birth."""
    return any(
        source.emission.has_side and _share_support(shape, origin)
        for source, origin in _sources_with_shapes(scene)
    )


def _share_support(shape: Shape, other: Shape) -> bool:
    """Return whether any pieces of two shapes lie on one plane or quadric."""
    return any(starmap(are_on_one_support, product(shape.pieces(), other.pieces())))


# ---- opaque rooms ----


def _enclosure_reason(scene: Scene, target: Sided) -> str | None:
    """Explain that opaque surfaces separate the detector from every source, by enclosing one of the two."""
    rooms = [
        room
        for room in _opaque_rooms(scene)
        if _is_certainly_inside(room, target) or _is_certainly_outside(room, target)
    ]
    sources = list(_emitting_sides(scene))
    for room in rooms:
        if all(_room_separates(room, target, source) for source in sources):
            return _enclosure_message(scene, room, target, sources)
    parting = [
        next((room for room in rooms if _room_separates(room, target, source)), None) for source in sources
    ]
    if None in parting:
        return None
    names = join_names([_room_name(scene, room)[0] for room in dict.fromkeys(parting)])
    return f"{names} separate it from every source, and let no light through. Move the detector or a source"


def _room_separates(room: Room, target: Sided, source: Sided) -> bool:
    """Return whether the walls of a room lie between the detector and a source."""
    if _is_certainly_inside(room, target):
        return _is_certainly_outside(room, source)
    return _is_certainly_inside(room, source)


def _enclosure_message(scene: Scene, room: Room, target: Sided, sources: list[Sided]) -> str:
    """Return which walls enclose the detector or the sources, and the cure.

    Change the side of the detector or the sources, or move one.
    """
    (name, encloses), is_within = _room_name(scene, room), _is_certainly_inside(room, target)
    if is_within and all(
        side is not None and _is_certainly_inside(room, (o, _other_side((o, side)))) for o, side in sources
    ):
        cure = f"Write side={_other_side(sources[0])!r} in the source"
        return f"every source emits from the outside of {name}. {cure}"
    if target[1] is not None and (_is_certainly_outside if is_within else _is_certainly_inside)(
        room, (target[0], _other_side(target))
    ):
        cure = f"Write side={_other_side(target)!r}"
    else:
        cure = "Move the detector inside"
        if is_within:
            cure = "Make it Transparent(), or move the detector or a source"
    if is_within:
        return f"{name} {encloses} it, lets no light through, and no source is inside. {cure}"
    return f"{name} {encloses} every source and lets no light through. {cure}, or move a source outside"


def _room_name(scene: Scene, room: Room) -> tuple[str, str]:
    """The names of a room's walls, and the verb that follows them."""
    verb = "encloses" if len(room.numbers) == 1 else "together encloses"
    return join_surface_names(scene, room.numbers), verb


def _is_certainly_inside(room: Room, sided: Sided) -> bool:
    """Return whether a shape is certainly in a room, and its side, if it has one, faces the inside."""
    shape, side = sided
    if side is None:
        return room.holds(shape)
    if isinstance(room, ClosedShape) and are_on_one_support(room.shapes[0], shape):
        return IS_BACK[side]
    if not shape.is_flat:
        return room.holds(shape)
    is_wall = isinstance(room, ClosedPatches) and shape in room.shapes
    return (is_wall or room.holds(shape)) and room.holds(point_beside(shape, IS_BACK[side], room.shapes))


def _is_certainly_outside(room: Room, sided: Sided) -> bool:
    """Return whether a shape is certainly outside a room, or its side, if any, faces away from the room."""
    shape, side = sided
    if side is None:
        return room.excludes(shape)
    if isinstance(room, ClosedShape) and are_on_one_support(room.shapes[0], shape):
        return not IS_BACK[side]
    if isinstance(room, ClosedPatches) and shape in room.shapes:
        return shape.is_flat and not room.holds(point_beside(shape, IS_BACK[side], room.shapes))
    if all(is_behind(wall, shape, side) for wall in room.shapes):
        return True
    is_round = shape.is_closed and not shape.is_infinite
    if is_round and all(shape.distance(wall.middle) > wall.extent for wall in room.shapes):
        [place], _ = shape.pieces()[0].sample_area(np.array([[0.5, 0.5]]))
        return not room.holds(tuple(place.tolist()))  # a surface around the room, or beside it
    return room.excludes(shape)


def _rooms_near(scene: Scene, *shapes: Shape) -> list[Room]:
    """The opaque rooms whose bounding balls meet those of any of the shapes."""
    rooms = _opaque_rooms(scene)

    def find_balls() -> tuple[np.ndarray, np.ndarray]:
        balls = [_bounding_ball(room.shapes) for room in rooms]
        return np.reshape([middle for middle, _ in balls], (-1, 3)), np.array([reach for _, reach in balls])

    middles, reaches = proven(scene, "balls about opaque rooms", find_balls)
    near = np.zeros(len(rooms), bool)
    for shape in shapes:
        if shape.is_infinite:
            return rooms
        near |= np.linalg.norm(middles - shape.middle, axis=1) <= (reaches + shape.extent) * (1 + ROUNDING)
    return [rooms[k] for k in np.flatnonzero(near)]


def _bounding_ball(shapes: Sequence[Shape]) -> tuple[Vector, float]:
    """Centre and radius of a ball that contains all of the shapes."""
    if any(shape.is_infinite for shape in shapes):
        return (0.0, 0.0, 0.0), math.inf
    bounds = np.array([shape.bounds for shape in shapes])
    middle = (bounds[:, 0].min(axis=0) + bounds[:, 1].max(axis=0)) / 2
    reach = max(float(np.linalg.norm(middle - shape.middle)) + shape.extent for shape in shapes)
    return tuple(map(float, middle)), reach


def _opaque_rooms(scene: Scene) -> list[Room]:
    """The rooms that opaque surfaces enclose; computed once per scene."""

    def find() -> list[Room]:
        surfaces = enumerate(scene.surfaces)
        return finite_enclosures({k: each for k, each in surfaces if not each.material.is_transmissive})

    return proven(scene, "opaque rooms", find)


# ---- planes ----


def _behind_sources_reason(scene: Scene, shape: Shape) -> str | None:
    """Explain that the detector lies behind every source, all of them flat, and nothing redirects light."""
    emitting = list(_emitting_sides(scene))
    if not emitting or any(True for _ in _redirecting_shapes(scene)):
        return None
    for origin, side in emitting:
        if _share_support(shape, origin) or not is_behind(shape, origin, side):
            return None
    return (
        "it lies behind every source, and nothing reflects light to it. Reverse the normals of the sources,"
        " or write side='back' in them"
    )


def _faces_away(scene: Scene, target: Sided) -> bool:
    """Return whether the detector is flat, and all that emits or redirects light lies behind its plane."""
    shape, side = target
    shapes = [*(origin for _, origin in _sources_with_shapes(scene)), *_redirecting_shapes(scene)]
    return shape.is_flat and all(other is not None and is_behind(other, shape, side) for other in shapes)


def _other_side(sided: Sided) -> str:
    """The other side; "inside" or "outside" for a closed shape."""
    shape, side = sided
    return OTHER_SIDE[side] if not shape.is_closed else "outside" if IS_BACK[side] else "inside"


# ---- emitting and redirecting shapes ----


def _sources_with_shapes(scene: Scene) -> Iterator[tuple[Source, Shape]]:
    """Every source with its shape, emitting media included."""
    return ((source, scene.shape_of(source)) for source in (*scene.sources, *emitting_media(scene)))


def _emitting_sides(scene: Scene) -> Iterator[Sided]:
    """The shape of every source, and its emitting side; None if a whole volume emits."""
    return (
        (origin, source.side if source.emission.has_side else None)
        for source, origin in _sources_with_shapes(scene)
    )


def _redirecting_shapes(scene: Scene) -> Iterator[Shape | None]:
    """Shapes at or in which light may change direction; None for a medium without known bounds."""
    if np.max(surrounding_medium(scene).scattering) > 0:
        yield None
    for surface in scene.surfaces:
        if surface.material.redirects:
            yield surface.shape
        yield from _scattering_regions(surface)


def _scattering_regions(surface: Surface) -> Iterator[Shape | None]:
    """The region beside a surface in which a medium scatters; None if the surface alone does not bound it."""
    for medium, is_bounded in ((surface.front, False), (surface.back, surface.shape.is_closed)):
        if medium is not None and np.max(medium.scattering) > 0:
            yield surface.shape if is_bounded else None
