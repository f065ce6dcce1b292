"""Checks that the surfaces which name a medium close a body: gaps, reversed normals, faces back to back.

A particle that crosses a surface is from then on in the bodies that this surface names on that side. Along
any straight line a body's surfaces must therefore alternate: outside before the first, inside behind an
entry, outside behind the next, outside at the end. Other objects in a gap, such as a surface without media,
do not matter, nor does the direction of the line. Each body is probed along some hundred lines through its
surfaces: a gap smaller than their spacing may be missed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.geometry.line_crossings import (
    DEFAULT_LINES,
    MAX_LINE_FACETS,
    crossings,
    lines_through,
    scene_size,
    sorted_crossings,
)
from transport.scene.bodies import Body, bounds_alone
from transport.scene.media import canonical_medium
from transport.scene.parts import surface_name
from transport.validation import SceneError, short_repr

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts

LINES_PER_SURFACE = 16  # least number of lines per surface
MIN_GAP_SHARE = 0.9  # a surface in this share of the gaps is named
# most faces tried reversed, and most sides tried with the medium, to find the cause
MAX_REVERSED, MAX_SIDES = 16, 4

Faces = tuple[tuple[int, bool], ...]  # index of the surface, and whether the body is in front of it


class FaceCrossings(NamedTuple):
    """Crossings of lines with some faces, in order, and the places where they do not alternate."""

    origins: np.ndarray
    directions: np.ndarray
    surfaces: np.ndarray  # (lines, most); -1 for none
    sides: np.ndarray  # +1 where a line runs along the normal, else -1
    places: np.ndarray  # [m]
    is_inside: np.ndarray  # (lines, most + 1): whether the line is in the body by the crossing before
    is_gap: np.ndarray  # (lines, most + 1): whether there is a gap before each crossing, and behind the last
    is_double: np.ndarray  # (lines, most - 1): whether a crossing and the next coincide and disagree

    @property
    def share(self) -> float:
        """Share of the lines that find an error."""
        return float((self.is_gap.any(axis=1) | self.is_double.any(axis=1)).mean())


def check_closed(scene: SceneParts, bodies: tuple[Body, ...]) -> None:
    """Raise SceneError for open surfaces that do not close their body, within the limits stated above."""
    for body in bodies:
        if not bounds_alone(scene.surfaces[body.surfaces[0]].shape):
            taken = _face_crossings(scene, body.faces)
            if taken.is_double.any():
                _raise_back_to_back(scene, body, taken)
            if taken.is_gap.any():
                _raise_gap(scene, body, taken)


def _face_crossings(scene: SceneParts, faces: Faces) -> FaceCrossings:
    """Crossings of lines through some faces, with gaps and contradictions."""
    numbers = np.array(list(dict.fromkeys(number for number, _ in faces)))
    shapes = [scene.surfaces[number].shape for number in numbers]
    facets = sum(shape.triangles for shape in shapes)
    count = max(
        4, min(max(DEFAULT_LINES, LINES_PER_SURFACE * len(shapes)), MAX_LINE_FACETS // max(4 * facets, 1))
    )
    size = scene_size(shapes)
    origins, directions = lines_through(shapes, count, size)
    places, keys = sorted_crossings(shapes, origins, directions, size)
    group, code = np.divmod(keys, 2 * len(shapes))
    code[keys < 0] = 2 * len(shapes)
    held = np.array([[(number, is_front) in faces for is_front in (True, False)] for number in numbers])
    # Decide whether the body is before and behind each crossing: against the normal the front is before.
    before = np.append(held.reshape(-1), False)[code]
    behind = np.append(held[:, ::-1].reshape(-1), False)[code]
    outside = np.zeros((count, 1), bool)
    is_in, must = np.hstack([outside, behind]), np.hstack([before, outside])
    is_gap = is_in != must
    # Find crossings at one place whose faces disagree; crossings at one place leave no gap between them.
    flush = (group[:, 1:] == group[:, :-1]) & (keys[:, 1:] >= 0)
    is_double = flush & ((before[:, 1:] != before[:, :-1]) | (behind[:, 1:] != behind[:, :-1]))
    is_gap[:, 1:-1] &= ~flush
    surfaces = np.append(np.repeat(numbers, 2), -1)[code]
    return FaceCrossings(
        origins, directions, surfaces, np.where(code % 2, 1, -1), places, is_in, is_gap, is_double
    )


def _raise_back_to_back(scene: SceneParts, body: Body, taken: FaceCrossings) -> None:
    """Raise the SceneError for two faces back to back."""
    line, k = np.argwhere(taken.is_double)[0]
    one, other = (surface_name(scene, number) for number in taken.surfaces[line, k : k + 2])
    where = _format_place(taken, line, taken.places[line, k])
    must = f"must not lie back to back at {where}, got {short_repr(body.medium)} on both sides"
    cure = "leave both out, so that the other surfaces bound one body; if one is larger, give it a hole"
    raise SceneError(f"Scene: {one} and {other} {must}; {cure}")


def _raise_gap(scene: SceneParts, body: Body, taken: FaceCrossings) -> None:
    """Raise the SceneError for a gap, naming the face to reverse or to give the medium, or else the place."""
    # Try to find the cause: one reversed face, or one face that does not name the medium.
    turned = _find_reversed(scene, body)
    if turned is None and (side := _find_unnamed(scene, body, taken)) is not None:
        _raise_unnamed_side(scene, body, taken, *side)
    at_turned = taken.is_gap & _gaps_at_face(taken, turned)
    # Otherwise describe the gap by its two ends.
    line, k = np.argwhere(at_turned if at_turned.any() else taken.is_gap)[0]
    here, there = (k - 1, k) if taken.is_inside[line, k] else (k, k - 1)
    number, side = int(taken.surfaces[line, here]), taken.sides[line, here]
    word = "front" if (side > 0) == (here < k) else "back"
    ends = "nothing"
    if 0 <= there < taken.surfaces.shape[1] and taken.surfaces[line, there] >= 0:
        end = _format_place(taken, line, taken.places[line, there])
        ends = f"{surface_name(scene, taken.surfaces[line, there])} at {end}"
    start = _format_place(taken, line, taken.places[line, here])
    must = f"{word} must bound a closed body, got {short_repr(body.medium)} from {start} to {ends}"
    cure = f"close the gaps by surfaces that name it, reverse its normal, or leave {word} out"
    if ends != "nothing":
        cure += "; if two bodies of it overlap or are nested, make them one"
    if turned is not None:
        cure = f"reverse its normal, or write {'back' if word == 'front' else 'front'} instead of {word}"
    elif (across := _closing_surface(scene, body, taken)) is not None:
        cure = (
            f"close the gap by a separate surface: {surface_name(scene, across)} does not bound the body"
            f" there; put a Transparent() Disk or Rectangle into it that names {short_repr(body.medium)} too"
        )
    raise SceneError(f"Scene: {surface_name(scene, number)}: {must}; {cure}")


def _raise_unnamed_side(
    scene: SceneParts, body: Body, taken: FaceCrossings, number: int, is_front: bool
) -> None:
    """Raise the SceneError for a side that should name the body's medium."""
    word, surface = "front" if is_front else "back", scene.surfaces[number]
    line, k, place = _crossings_in_gaps(scene, taken, number)[0][:3]
    here = taken.surfaces[line, k - 1 if taken.is_inside[line, k] else k]
    got = short_repr(surface.front if is_front else surface.back)
    bounds = f"the medium of the body bounded by {surface_name(scene, here)}, which is open without it"
    must = f"{word} must be {short_repr(body.medium)}, {bounds}"
    where = _format_place(taken, line, place)
    cure = f"give {surface_name(scene, number)} {word}={short_repr(body.medium)}, or close the gap otherwise"
    raise SceneError(f"Scene: {surface_name(scene, number)}: {must}, at {where}, got {got}; {cure}")


def _format_place(taken: FaceCrossings, line: int, place: float) -> str:
    """Coordinates of a place on a line, as text."""
    return f"({', '.join(f'{x:.6g}' for x in taken.origins[line] + place * taken.directions[line])})"


# ---- search for the cause ----


def _find_reversed(scene: SceneParts, body: Body) -> tuple[int, bool] | None:
    """The face whose reversal leaves no gap at all."""
    for number, is_front in body.faces[:MAX_REVERSED]:
        others = tuple(face for face in body.faces if face != (number, is_front))
        if _face_crossings(scene, ((number, not is_front), *others)).share == 0:
            return number, is_front
    return None


def _find_unnamed(scene: SceneParts, body: Body, taken: FaceCrossings) -> tuple[int, bool] | None:
    """The side that would leave the fewest lines with a gap if it named the medium; None if none helps."""
    sides = _unnamed_sides(scene, body, taken)[:MAX_SIDES]
    shares = [_face_crossings(scene, (*body.faces, side)).share for side in sides]
    best = min(range(len(sides)), key=lambda k: shares[k], default=None)
    return sides[best] if best is not None and shares[best] < taken.share else None


def _unnamed_sides(scene: SceneParts, body: Body, taken: FaceCrossings) -> list[tuple[int, bool]]:
    """Sides of open surfaces that face the body through gaps without naming it, the most frequent first."""
    sides: dict[tuple[int, bool], int] = {}
    for number, surface in enumerate(scene.surfaces):
        if not bounds_alone(surface.shape) and number not in body.surfaces:
            for *_, is_front in _crossings_in_gaps(scene, taken, number):
                named = surface.front if is_front else surface.back
                if named is None or canonical_medium(named) != body.medium:
                    sides[number, is_front] = sides.get((number, is_front), 0) + 1
    return sorted(sides, key=lambda side: -sides[side])


def _closing_surface(scene: SceneParts, body: Body, taken: FaceCrossings) -> int | None:
    """The plane or closed surface that lies across nearly all gaps; None if there is none."""
    gaps = int(taken.is_gap.sum())
    for number, surface in enumerate(scene.surfaces):
        gaps_of_it = (
            {found[:2] for found in _crossings_in_gaps(scene, taken, number)}
            if bounds_alone(surface.shape)
            else ()
        )
        if len(gaps_of_it) >= MIN_GAP_SHARE * gaps:
            return number
    return None


def _crossings_in_gaps(
    scene: SceneParts, taken: FaceCrossings, number: int
) -> list[tuple[int, int, float, bool]]:
    """Crossings of a surface in gaps: line, gap, place [m], and whether its front faces the body."""
    lines, gaps = np.nonzero(taken.is_gap)
    found = crossings(scene.surfaces[number].shape, taken.origins[lines], taken.directions[lines])
    ends = np.where(taken.surfaces >= 0, taken.places, np.inf)
    edge = np.full((len(ends), 1), np.inf)
    low, high = np.hstack([-edge, ends])[lines, gaps], np.hstack([ends, edge])[lines, gaps]
    is_in = taken.is_inside[lines, gaps]
    return [
        (int(lines[n]), int(gaps[n]), found.distances[n, m], bool((found.sides[n, m] < 0) == is_in[n]))
        for n, m in np.argwhere((found.distances > low[:, None]) & (found.distances < high[:, None]))
    ]


def _gaps_at_face(taken: FaceCrossings, face: tuple[int, bool] | None) -> np.ndarray:
    """Mask of the gaps, (lines, most + 1), that begin or end at a face; all of them for None."""
    if face is None:
        return np.ones(taken.is_gap.shape, bool)
    none = np.full((len(taken.surfaces), 1), -1)
    last, next_ = np.hstack([none, taken.surfaces]), np.hstack([taken.surfaces, none])
    return np.where(taken.is_inside, last, next_) == face[0]
