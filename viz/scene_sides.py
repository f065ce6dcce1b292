"""From which side a part of a scene is to be seen, so that the wall between the camera and what it shows is looked through."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from viz.scene_parts import Part

FRONT, BACK, NOWHERE = "front", "back", "nowhere"
ALL_BUT = 0.97  # of a shape's facets that have the whole scene on one side, for it to be a wall of it
FLAT = 1e-6  # of the scene's size: as far off a plane is on it
SAMPLES = 300  # facets of a shape that are asked


def seen_from(part: Part, parts: list[Part]) -> str | None:
    """The side from which a wall is shown: the painted one, else the one that all the rest of the scene is on."""
    if part.kind == "surface" and part.side is not None and not part.is_clear:
        if not part.is_other_side:
            return part.side
        inner = _inner_side(part, parts)
        return NOWHERE if inner not in (None, part.side) else part.side
    if part.kind == "surface" and not part.is_clear:
        return _inner_side(part, parts)
    return part.seen_from


def _inner_side(part: Part, parts: list[Part]) -> str | None:
    """The side of a shape on which all the others are, if there is one."""
    finite = [each for each in parts if len(each.facets.points) and not each.shape.is_infinite]
    others = [each for each in finite if each.shape != part.shape]
    if len(part.facets.faces) == 0:
        return None
    if not others:
        return _own_side(part, parts)
    points = np.concatenate([_some(each.facets.points, 40) for each in others])
    areas = part.facets.vector_areas
    chosen = _some(np.arange(len(areas)), SAMPLES)
    heights = np.einsum("pk,ck->cp", points, areas[chosen])
    heights -= np.einsum("ck,ck->c", part.facets.centres[chosen], areas[chosen])[:, None]
    heights /= np.maximum(np.linalg.norm(areas[chosen], axis=1), 1e-300)[:, None]
    flat = FLAT * part.frame.size + _sagitta(part)
    is_behind, is_before = (heights <= flat).all(axis=1).mean(), (heights >= -flat).all(axis=1).mean()
    if (np.abs(heights) <= flat).all():
        return None
    if is_behind >= ALL_BUT:
        return BACK
    return FRONT if is_before >= ALL_BUT else None


def _own_side(part: Part, parts: list[Part]) -> str | None:
    """The one side of a shape alone in its scene that something emits from, or looks at."""
    sides = set()
    for each in parts:
        if each.kind == "source" and each.shape == part.shape:
            sides.add(each.side if each.what.emission.has_side else BACK)
        elif each.kind == "detector" and each.side:
            sides.add(each.side)
    return sides.pop() if len(sides) == 1 else None


def _sagitta(part: Part) -> float:
    """How far flat facets lie within what is round [m]."""
    shape = part.shape
    return 0.002 * shape.extent if len(part.facets.faces) > 12 and np.isfinite(shape.extent) else 0.0


def _some(array: np.ndarray, most: int) -> np.ndarray:
    return array[:: max(1, -(-len(array) // most))]
