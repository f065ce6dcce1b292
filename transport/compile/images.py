"""Images of detectors and lamps in flat mirrors, by which shadow rays connect specular paths.

A ray to the image of a detector is reflected where it meets each mirror, within its outline, and so comes to
the detector; in a backward run lamps take the place of detectors. Flights share the light of such a path as
that of a straight one, by its whole length (engine/passes/mis.py). So all chains of mirrors that may lead to
a detector must have an image, or none has: scenes are connected whose chains end, as those of a periscope or
a corner do, and of two facing mirrors do not. Unfolded, a path by way of mirrors is a straight line through
their images, and a chain is impossible where some image does not meet the convex hull of one before and one
behind it.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.gloss import glossy_parts
from transport.geometry.relations import are_on_one_support
from transport.geometry.shape import Shape

if TYPE_CHECKING:
    from transport.scene.materials import Surface
    from transport.scene.scene import Scene
    from transport.vectors import Vector

Chain = tuple[tuple[int, Shape], ...]  # numbers and shapes of mirrors, in the order in which a ray meets them

LINKED = "mirror", "transparent", "diffuse", "black"  # interactions at surfaces that shadow rays pass
MAX_MIRRORS, MAX_LENGTH, MAX_CHAINS = 8, 3, 16
# of a mirror's size: mirrors that touch at an edge have no line through both there
SHRINKAGE, TOLERANCE = 1e-8, 1e-10


@lru_cache(maxsize=32)
def chains_of_mirrors(scene: Scene, shapes: tuple[Shape, ...]) -> list[list[Chain]] | None:
    """Return the chains of mirrors that may lead to each of these detectors.

    None where shadow rays do not connect all specular paths of the scene, or there are none: where something
    else than flat mirrors is specular, gloss sends rays, or chains are too many or too long. Mirrors may
    transmit and be parts of mixtures, and light may pass other surfaces straight.
    """
    specular = [surface for surface in scene.surfaces if surface.material.is_specular]
    parts = [part for surface in specular for part in surface.material.elements]
    are_plain = all(part.row().interaction in LINKED and part.row().albedo_law is None for part in parts)
    mirrors = mirrors_of(scene)
    if not specular or not are_plain or any(glossy_parts(surface.material) for surface in scene.surfaces):
        return None
    if len(mirrors) > MAX_MIRRORS or not all(mirror.shape.is_flat for mirror in mirrors):
        return None
    if len(mirrors) > 1 and any(shape.is_infinite for shape in (*shapes, *(m.shape for m in mirrors))):
        return None
    numbered = [(number, mirror.shape) for number, mirror in enumerate(mirrors, start=1)]
    found = []
    for shape in shapes:
        chains = _chains(numbered, shape)
        if chains is None:
            return None
        found.append(chains)
    return found


def mirrors_of(scene: Scene) -> list[Surface]:
    """Return the surfaces that reflect specularly."""
    return [s for s in scene.surfaces if any(side.shares.specular > 0 for side in s.material.sides)]


def _chains(mirrors: list[tuple[int, Shape]], shape: Shape) -> list[Chain] | None:
    """Return the chains that may lead to a detector; None where they are too many or too long."""
    one_by_one = [m for m in mirrors if not (shape.is_flat and are_on_one_support(m[1], shape))]
    if len(mirrors) == 1:
        return [(each,) for each in one_by_one]
    own, found = _outline(shape), []
    # A chain, last mirror first, with the outlines of detector and mirrors, unfolded.
    waiting = [((each,), [own, _outline(each[1])]) for each in one_by_one]
    while waiting:
        chain, outlines = waiting.pop()
        found.append(chain[::-1])
        for each in mirrors:
            if each[0] == chain[-1][0]:
                continue
            points = _unfolded(_outline(each[1]), chain[::-1])
            if all(_may_pass(*pair, points) for pair in combinations(outlines, 2)):
                waiting.append(((*chain, each), [*outlines, points]))
                if len(chain) == MAX_LENGTH or len(found) + len(waiting) > MAX_CHAINS:
                    return None
    return found


def outlines_of_images(scene: Scene, shape: Shape) -> list[list[np.ndarray]] | None:
    """Return what a ray to each image of a shape passes: points whose hulls hold the mirrors, and the image.

    None where chains do not end, or shapes have no outline.
    """
    chains = chains_of_mirrors(scene, (shape,))
    if chains is None or any(each.is_infinite for each in (shape, *(m.shape for m in mirrors_of(scene)))):
        return None
    return [
        [
            _unfolded(_outline(each), chain[:place][::-1])
            for place, each in enumerate([*(mirror for _, mirror in chain), shape])
        ]
        for chain in chains[0]
    ]


def may_be_seen(outlines: list[np.ndarray], position: Vector) -> bool:
    """Return whether an image, the last of the outlines, may be seen from a place through all before it."""
    *mirrors, image = outlines
    return all(_may_pass(np.array([position]), mirror, image) for mirror in mirrors)


def image_of(position: Vector, chain: Chain) -> Vector:
    """Return the image of a position by a chain of mirrors."""
    return tuple(_unfolded(np.array(position), chain[::-1]).tolist())


def mark_of(chain: Chain) -> int:
    """Return what is added to the first row of a target for rays to its image by a chain."""
    shifts = (layout.MIRROR_SHIFT + layout.MIRROR_BITS * place for place in range(len(chain)))
    return sum(number << shift for (number, _), shift in zip(chain, shifts, strict=True))


def _unfolded(points: np.ndarray, chain: Chain) -> np.ndarray:
    """Return points as the mirrors of a chain show them, the first of it first."""
    for _, mirror in chain:
        center = np.array(mirror.center)
        points = center + turned(points - center, np.array(mirror.normal))
    return points


def _outline(shape: Shape) -> np.ndarray:
    """Return points whose convex hull holds a shape but for what is within rounding of its edge, (n, 3)."""
    points = np.array(shape.bounds_corners(), float).reshape(-1, 3)
    if shape.is_flat:
        corners = shape.corners
        if not corners:  # a disk
            corners = [(u * shape.extent, v * shape.extent) for u in (-1, 1) for v in (-1, 1)]
        e_u, e_v = np.array(shape.frame[0]), np.array(shape.frame[1])
        points = np.array(shape.center) + np.array(corners) @ np.stack([e_u, e_v])
    middle = points.mean(axis=0)
    return middle + (1 - SHRINKAGE) * (points - middle)


def turned(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return vectors, (3,) or (n, 3), as a mirror with this normal turns them."""
    return vectors - 2 * np.multiply.outer(vectors @ normal, normal)


def _may_pass(one: np.ndarray, between: np.ndarray, other: np.ndarray) -> bool:
    """Return whether a line from one convex hull to another may pass one between.

    It may where that one meets the convex hull of both.
    """
    from scipy.optimize import linprog

    ends = np.concatenate([one, other])
    middle = ends.mean(axis=0)
    size = np.abs(ends - middle).max()
    ends, between = (ends - middle) / size, (between - middle) / size
    columns = np.concatenate([ends, -between]).T
    ones, zeros = np.ones(len(ends)), np.zeros(len(between))
    sums = np.stack([np.concatenate([ones, zeros]), np.concatenate([0 * ones, zeros + 1])])
    equal = np.concatenate([columns, sums])
    exact = {"primal_feasibility_tolerance": TOLERANCE, "presolve": False}
    costs, wanted = np.zeros(equal.shape[1]), [0, 0, 0, 1, 1]
    return linprog(costs, A_eq=equal, b_eq=wanted, method="highs-ds", options=exact).status != 2
