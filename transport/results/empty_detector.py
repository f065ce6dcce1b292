"""Explain a detector that counted nothing, where geometry proves that no light can reach it.

The commonest slip is a normal the wrong way round.  Each proof below holds for every path of light, reflected and scattered
paths included, so its warning names the cause for certain; a detector that was only missed by chance gets none of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.listing import surrounding_of
from transport.bodies.solids import holds, is_within
from transport.compile.media import glowing_sources
from transport.materials import Black, Surface, Transparent, lets_through, simple_parts
from transport.materials.surface import titled
from transport.shapes import Box, FlatShape, Mesh, Shape, Sphere
from transport.shapes.distances import is_behind, least_distance
from transport.shapes.supports import are_on_one_support, rounding_of
from transport.sheets import pieces
from transport.sides import IS_BACK
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.detectors import Detector
    from transport.scene import Scene
    from transport.sources import Source

Place = Shape | Vector
STEP = 1e-6  # of a flat shape's extent, by which its side is followed off the wall on which it may lie
OTHER_SIDE = {"front": "back", "back": "front", "outside": "inside", "inside": "outside"}


def why_dark(scene: Scene, title: str, place: Place, detector: Detector | None = None) -> str | None:
    """Return why no light can reach a detector, and the cure; None where geometry does not prove it.

    Parameters
    ----------
    scene : Scene
        The scene as the user wrote it, for forward and backward runs alike.
    title : str
        What the warning calls the detector.
    place : Shape or (x, y, z)
        The surface of a Detector, the volume of a VolumeDetector, or a point [m].
    detector : Detector, optional
        The detector, if it counts at one side of a surface.
    """
    side = None if detector is None else detector.side
    why = _emitted_outwards(scene, place, side)
    why = why or _enclosed(scene, place, side) or _sources_enclosed(scene, place, side)
    if detector is not None:
        why = why or _behind_sources(scene, place)
        why = why or (_faces_away(scene, place, side) if _is_opaque(scene, detector) else None)
    return why and f"{title} counted nothing: {why}"


def why_wrong_side(scene: Scene, shape: Shape, detector: Detector, is_blind: bool) -> str | None:
    """Return a note on a detector at which nothing arrived, where all light comes, or may come, to its other side.

    None where departures are what one reads: of a surface by its name, and of a source.
    """
    title, side, other = f"detector {detector.name!r}", detector.side, OTHER_SIDE[detector.side]
    if is_blind:
        if shape.is_closed and not detector.is_back:
            return (
                f"{title} counted nothing on the outside of its shape. Write side='inside' to count inside it"
            )
        why = _faces_away(scene, shape, side)
        return why and f"{title} counted nothing: {why}"
    if isinstance(detector.shape, str) or _has_source_on(scene, shape):
        return None
    return (
        f"nothing arrives at the {side} of {title}, so its flux_in and irradiance are 0: all light comes from its {other}."
        f" Write side={other!r}, reverse its normal, or read flux_out and exitance"
    )


def _is_opaque(scene: Scene, detector: Detector) -> bool:
    """Whether a detector is a surface that lets nothing through, so that nothing departs where nothing arrives."""
    return any(s.name == detector.shape and not lets_through(s.material) for s in scene.surfaces)


def _has_source_on(scene: Scene, shape: Shape) -> bool:
    """Whether a source lies on a shape, so that particles depart from the shape as they are born."""
    return any(
        source.emission.has_side and are_on_one_support(one, other)
        for source, origin in _sources(scene)
        for one, other in product(pieces(shape), pieces(origin))
    )


# ---- opaque closed surfaces ----


def _emitted_outwards(scene: Scene, place: Place, side: str | None) -> str | None:
    """Every source emits from the outside of a room's walls, and the detector is in the room."""
    for name, shell in _shells(scene):
        if _is_in(shell, place, side) and all(
            origin == shell and source.emission.has_side and not source.is_back
            for source, origin in _sources(scene)
        ):
            return f"every source emits from the outside of {name}. Write side='inside' in the source"
    return None


def _enclosed(scene: Scene, place: Place, side: str | None) -> str | None:
    """An opaque surface encloses the detector and no source."""
    for name, shell in _shells(scene):
        if _is_in(shell, place, side) and all(_is_out(shell, *where) for where in _emitting(scene)):
            return (
                f"{name} encloses it, lets no light through, and no source is inside. Make the surface Transparent(), or"
                " move the detector or a source"
            )
    return None


def _sources_enclosed(scene: Scene, place: Place, side: str | None) -> str | None:
    """An opaque surface encloses every source and not the detector."""
    for name, shell in _shells(scene):
        if _is_out(shell, place, side) and all(_is_in(shell, *where) for where in _emitting(scene)):
            cure = "Write side='inside'" if place == shell and side else "Move the detector inside"
            return f"{name} encloses every source and lets no light through. {cure}, or move a source outside"
    return None


def _emitting(scene: Scene) -> Iterator[tuple[Shape, str | None]]:
    """The shape of every source, and the side that emits; None where all of a volume does."""
    return ((origin, source.side if source.emission.has_side else None) for source, origin in _sources(scene))


def _shells(scene: Scene) -> Iterator[tuple[str, Shape]]:
    """Closed surfaces of finite size that let no light through: name and shape."""
    for number, surface in enumerate(scene.surfaces):
        shape = surface.shape
        if shape.is_closed and not shape.is_infinite and not lets_through(surface.material):
            yield titled(surface, number), shape


def _is_in(shell: Shape, place: Place, side: str | None) -> bool:
    """Whether a place surely lies in a closed shape, and its side, if it has one, faces the inside."""
    if not isinstance(place, Shape) or side is None:
        return _holds(shell, place)
    if are_on_one_support(shell, place):
        return IS_BACK[side]
    if not _holds(shell, place) or not isinstance(place, FlatShape):
        return _holds(shell, place)
    step = STEP * place.extent * (-1 if IS_BACK[side] else 1)  # a flat shape on the wall may face outwards
    return _holds(shell, tuple(p + step * n for p, n in zip(place.middle, place.normal, strict=True)))


def _holds(shell: Shape, place: Place) -> bool:
    """Whether all of a place surely lies in a closed shape, its surface included."""
    if not isinstance(place, Shape):
        return shell.holds(place) if isinstance(shell, Mesh) else bool(holds(shell, np.array([place]))[0])
    if place.is_infinite:
        return False
    if isinstance(shell, Mesh):
        return shell.holds(place.middle) and least_distance(shell, place.middle) >= place.extent
    if isinstance(place, Box | Sphere) and place.is_closed:
        return is_within(place, shell)
    corners = np.array(list(product(*zip(*place.bounds, strict=True))))
    margin = rounding_of(shell, place)  # towards the middle, so that a shape in the wall counts as inside
    return bool(holds(shell, corners + np.clip(np.array(place.middle) - corners, -margin, margin)).all())


def _is_out(shell: Shape, place: Place, side: str | None) -> bool:
    """Whether a place surely lies outside of a closed shape, or its side, if it has one, faces away from the shape."""
    if not isinstance(place, Shape):
        return least_distance(shell, place, filled=True) > 0
    if side is not None and are_on_one_support(shell, place):
        return not IS_BACK[side]
    if side is not None and isinstance(place, FlatShape) and is_behind(shell, place, side):
        return True
    if place.is_infinite:
        return False
    is_round = place.is_closed and least_distance(place, shell.middle) > shell.extent
    return is_round or least_distance(shell, place.middle, filled=True) > place.extent


# ---- planes ----


def _behind_sources(scene: Scene, shape: Shape) -> str | None:
    """The detector lies behind every source, all of them flat, and nothing redirects light."""
    emitting = list(_emitting(scene))
    if not emitting or any(True for _ in _redirecting(scene)):
        return None
    for origin, side in emitting:
        is_flat = side is not None and isinstance(origin, FlatShape)
        if not is_flat or are_on_one_support(shape, origin) or not is_behind(shape, origin, side):
            return None
    return (
        "it lies behind every source, and nothing reflects light to it. Reverse the normals of the sources, or write"
        " side='back' in them"
    )


def _faces_away(scene: Scene, shape: Shape, side: str) -> str | None:
    """The detector is flat, and everything that emits or redirects light lies behind its plane."""
    shapes = [*(origin for _, origin in _sources(scene)), *_redirecting(scene)]
    if not isinstance(shape, FlatShape) or not all(
        other is not None and is_behind(other, shape, side) for other in shapes
    ):
        return None
    return (
        f"its {side} faces away from every source, and nothing in front of it reflects or scatters light. Reverse its"
        f" normal, or write side={OTHER_SIDE[side]!r}"
    )


# ---- what emits light, and what redirects it ----


def _sources(scene: Scene) -> Iterator[tuple[Source, Shape]]:
    """Every source, emitting media included, with its shape."""
    return ((source, scene.shape_of(source)) for source in (*scene.sources, *glowing_sources(scene)))


def _redirecting(scene: Scene) -> Iterator[Shape | None]:
    """Shapes at or in which light may take another direction; None for a medium without known bounds."""
    if np.max(surrounding_of(scene).scattering) > 0:
        yield None
    for surface in scene.surfaces:
        if any(not isinstance(part, Black | Transparent) for part in simple_parts(surface.material)):
            yield surface.shape
        yield from _scattering(surface)


def _scattering(surface: Surface) -> Iterator[Shape | None]:
    """The region beside a surface in which a medium scatters; None where the surface alone does not bound it."""
    for medium, is_bounded in ((surface.front, False), (surface.back, surface.shape.is_closed)):
        if medium is not None and np.max(medium.scattering) > 0:
            yield surface.shape if is_bounded else None
