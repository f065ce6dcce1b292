"""Whether the surfaces that name a medium close a body: gaps, turned normals, faces back to back.

What crosses a surface is from then on in the bodies that this surface names on that side.  So along any straight
line a body's own surfaces must take turns: nothing of it before the first, in it behind one that leads in, out of
it behind the next, nothing left at the end.  Whatever else lies in a gap, a surface without media above all,
changes nothing of this, and it does not matter which way the line goes.  Each body is looked at along some hundred
lines through its surfaces: a gap smaller than their spacing may be missed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.bodies.frontiers import title_of
from transport.bodies.lines import FACETS, LINES, crossed_in_turn, lines_through, size_of
from transport.bodies.listing import is_whole
from transport.bodies.regions import Body
from transport.media.medium import plain
from transport.shapes import Mesh
from transport.shapes.crossings import crossings
from transport.validation import SceneError, shown

if TYPE_CHECKING:
    from transport.parts import SceneParts

A_SURFACE = 16  # lines at least through each
SHARE = 0.9  # of gaps in which a surface lies, to be named
TURNS, SIDES = 16, 4  # faces that are tried turned round, and sides with a medium, to find what is wrong

Faces = tuple[tuple[int, bool], ...]  # surface, and whether the body is in front of it


class Taken(NamedTuple):
    """What lines cross of some faces, in turn, and where they do not take turns."""

    origins: np.ndarray
    ways: np.ndarray
    surfaces: np.ndarray  # (lines, most); -1 where there is none
    sides: np.ndarray  # +1 where a line goes along the normal, else -1
    places: np.ndarray  # [m]
    is_in: np.ndarray  # (lines, most + 1): whether the last one crossed leaves a line in the body
    is_gap: np.ndarray  # (lines, most + 1): before each, and behind the last one
    is_double: np.ndarray  # (lines, most - 1): it and the next lie in one place and do not say the same

    @property
    def share(self) -> float:
        """Of the lines, those that find something wrong."""
        return float((self.is_gap.any(axis=1) | self.is_double.any(axis=1)).mean())


def check_closed(scene: SceneParts, bodies: tuple[Body, ...]) -> None:
    """Refuse a body of open surfaces that do not close it.  Raises SceneError; its limits are said above."""
    for body in bodies:
        if not is_whole(scene.surfaces[body.surfaces[0]].shape):
            taken = _taken(scene, body.faces)
            if taken.is_double.any():
                _refuse_double(scene, body, taken)
            if taken.is_gap.any():
                _refuse_gap(scene, body, taken)


def _taken(scene: SceneParts, faces: Faces) -> Taken:
    """What lines through some faces come to."""
    numbers = np.array(list(dict.fromkeys(number for number, _ in faces)))
    shapes = [scene.surfaces[number].shape for number in numbers]
    facets = sum(shape.triangles for shape in shapes if isinstance(shape, Mesh))
    count = max(4, min(max(LINES, A_SURFACE * len(shapes)), FACETS // max(4 * facets, 1)))
    size = size_of(shapes)
    origins, ways = lines_through(shapes, count, size)
    places, keys = crossed_in_turn(shapes, origins, ways, size)
    group, code = np.divmod(keys, 2 * len(shapes))
    code[keys < 0] = 2 * len(shapes)
    held = np.array([[(number, is_front) in faces for is_front in (True, False)] for number in numbers])
    # A line against the normal comes from the front, one along it from the back.
    before = np.append(held.reshape(-1), False)[code]
    behind = np.append(held[:, ::-1].reshape(-1), False)[code]
    outside = np.zeros((count, 1), bool)
    is_in, must = np.hstack([outside, behind]), np.hstack([before, outside])
    is_gap = is_in != must
    flush = (group[:, 1:] == group[:, :-1]) & (keys[:, 1:] >= 0)
    is_double = flush & ((before[:, 1:] != before[:, :-1]) | (behind[:, 1:] != behind[:, :-1]))
    is_gap[:, 1:-1] &= ~flush
    surfaces = np.append(np.repeat(numbers, 2), -1)[code]
    return Taken(origins, ways, surfaces, np.where(code % 2, 1, -1), places, is_in, is_gap, is_double)


def _refuse_double(scene: SceneParts, body: Body, taken: Taken) -> None:
    line, k = np.argwhere(taken.is_double)[0]
    one, other = (title_of(scene, number) for number in taken.surfaces[line, k : k + 2])
    where = _where(taken, line, taken.places[line, k])
    must = f"must not lie back to back at {where}, got {shown(body.medium)} on both sides"
    cure = "leave both out, so that what is about them bounds one body; give one larger than the other a hole"
    raise SceneError(f"Scene: {one} and {other} {must}; {cure}")


def _refuse_gap(scene: SceneParts, body: Body, taken: Taken) -> None:
    """Name what would close a body, turned round or naming its medium, as far as trying tells; else where a gap is."""
    turned = _turned(scene, body)
    if turned is None and (side := _missing(scene, body, taken)) is not None:
        _refuse_bare(scene, body, taken, *side)
    at_turned = taken.is_gap & _ends_at(taken, turned)
    line, k = np.argwhere(at_turned if at_turned.any() else taken.is_gap)[0]
    here, there = (k - 1, k) if taken.is_in[line, k] else (k, k - 1)
    number, side = int(taken.surfaces[line, here]), taken.sides[line, here]
    word = "front" if (side > 0) == (here < k) else "back"
    ends = "nothing"
    if 0 <= there < taken.surfaces.shape[1] and taken.surfaces[line, there] >= 0:
        end = _where(taken, line, taken.places[line, there])
        ends = f"{title_of(scene, taken.surfaces[line, there])} at {end}"
    start = _where(taken, line, taken.places[line, here])
    must = f"{word} must bound a closed body, got {shown(body.medium)} from {start} to {ends}"
    cure = f"close the gaps of what bounds it by surfaces that name it, turn round its normal, or leave {word} out"
    if ends != "nothing":
        cure += "; where two bodies of it overlap or lie in one another, make them one"
    if turned is not None:
        cure = f"turn round its normal, or write {'back' if word == 'front' else 'front'} instead of {word}"
    elif (across := _whole_across(scene, body, taken)) is not None:
        cure = (
            f"close the gap by a surface of its own: {title_of(scene, across)} ends no body there; lay a Disk or"
            f" Rectangle into it, Transparent(), that names {shown(body.medium)} too"
        )
    raise SceneError(f"Scene: {title_of(scene, number)}: {must}; {cure}")


def _refuse_bare(scene: SceneParts, body: Body, taken: Taken, number: int, is_front: bool) -> None:
    word, surface = "front" if is_front else "back", scene.surfaces[number]
    line, k, place = _across(scene, taken, number)[0][:3]
    here = taken.surfaces[line, k - 1 if taken.is_in[line, k] else k]
    got = shown(surface.front if is_front else surface.back)
    bounds = f"of the body that {title_of(scene, here)} bounds and that is open without it"
    must = f"{word} must be {shown(body.medium)}, {bounds}"
    where = _where(taken, line, place)
    cure = f"give {title_of(scene, number)} {word}={shown(body.medium)}, or close the gap by another that names it"
    raise SceneError(f"Scene: {title_of(scene, number)}: {must}, at {where}, got {got}; {cure}")


def _where(taken: Taken, line: int, place: float) -> str:
    return f"({', '.join(f'{x:.6g}' for x in taken.origins[line] + place * taken.ways[line])})"


# ---- what is wrong ----


def _turned(scene: SceneParts, body: Body) -> tuple[int, bool] | None:
    """The face that, turned round, leaves no gap at all."""
    for number, is_front in body.faces[:TURNS]:
        others = tuple(face for face in body.faces if face != (number, is_front))
        if _taken(scene, ((number, not is_front), *others)).share == 0:
            return number, is_front
    return None


def _missing(scene: SceneParts, body: Body, taken: Taken) -> tuple[int, bool] | None:
    """The side that, if it named the body's medium, would leave the fewest lines with a gap; None where none helps."""
    sides = _bare(scene, body, taken)[:SIDES]
    shares = [_taken(scene, (*body.faces, side)).share for side in sides]
    best = min(range(len(sides)), key=lambda k: shares[k], default=None)
    return sides[best] if best is not None and shares[best] < taken.share else None


def _bare(scene: SceneParts, body: Body, taken: Taken) -> list[tuple[int, bool]]:
    """Sides of open surfaces that look to a body through its gaps and do not name it, in most gaps first."""
    sides: dict[tuple[int, bool], int] = {}
    for number, surface in enumerate(scene.surfaces):
        if not is_whole(surface.shape) and number not in body.surfaces:
            for *_, is_front in _across(scene, taken, number):
                named = surface.front if is_front else surface.back
                if named is None or plain(named) != body.medium:
                    sides[number, is_front] = sides.get((number, is_front), 0) + 1
    return sorted(sides, key=lambda side: -sides[side])


def _whole_across(scene: SceneParts, body: Body, taken: Taken) -> int | None:
    """The plane or closed surface that lies across all but a few of the gaps."""
    gaps = int(taken.is_gap.sum())
    for number, surface in enumerate(scene.surfaces):
        gaps_of_it = {found[:2] for found in _across(scene, taken, number)} if is_whole(surface.shape) else ()
        if len(gaps_of_it) >= SHARE * gaps:
            return number
    return None


def _across(scene: SceneParts, taken: Taken, number: int) -> list[tuple[int, int, float, bool]]:
    """Where a surface lies across gaps: line, gap, place [m], and whether its front looks to the body."""
    lines, gaps = np.nonzero(taken.is_gap)
    found = crossings(scene.surfaces[number].shape, taken.origins[lines], taken.ways[lines])
    ends = np.where(taken.surfaces >= 0, taken.places, np.inf)
    edge = np.full((len(ends), 1), np.inf)
    low, high = np.hstack([-edge, ends])[lines, gaps], np.hstack([ends, edge])[lines, gaps]
    is_in = taken.is_in[lines, gaps]
    return [
        (int(lines[n]), int(gaps[n]), found.distances[n, m], bool((found.sides[n, m] < 0) == is_in[n]))
        for n, m in np.argwhere((found.distances > low[:, None]) & (found.distances < high[:, None]))
    ]


def _ends_at(taken: Taken, face: tuple[int, bool] | None) -> np.ndarray:
    """Which gaps, of (lines, most + 1), begin or end at a face; all of them for None."""
    if face is None:
        return np.ones(taken.is_gap.shape, bool)
    none = np.full((len(taken.surfaces), 1), -1)
    last, next_ = np.hstack([none, taken.surfaces]), np.hstack([taken.surfaces, none])
    return np.where(taken.is_in, last, next_) == face[0]
