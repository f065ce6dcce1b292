"""Which media a volume may hold, and whether any of them absorbs there: surely not, or perhaps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.listing import bodies_of, surrounding_of
from transport.bodies.regions import box_of, solid_of
from transport.bodies.solids import do_meet, is_within
from transport.materials.surface import AnyMedium
from transport.media import Grid
from transport.shapes import Box, Sphere
from transport.shapes.base import ROUNDING

if TYPE_CHECKING:
    from transport.parts import SceneParts


def may_absorb(scene: SceneParts, volume: Box | Sphere, hollow: Sphere | None = None) -> bool:
    """Whether anything that a volume may hold absorbs; what only touches it from outside does not count.

    hollow: a ball in it that is no part of it.
    """
    return any(_absorbs_in(medium, volume) for medium in _media_within(scene, volume, hollow))


def most_absorption(scene: SceneParts, volume: Box | Sphere) -> float:
    """The largest absorption coefficient [1/m] that a volume may hold."""
    return max(float(np.max(medium.absorption)) for medium in _media_within(scene, volume))


def _media_within(scene: SceneParts, volume: Box | Sphere, hollow: Sphere | None = None) -> list[AnyMedium]:
    """The media of which a part may lie in a volume.

    The innermost first: beyond a body that holds all of it there is nothing more.
    """
    found = []
    for body in bodies_of(scene):
        solid = solid_of(scene, body)
        if solid is None:
            if _boxes_meet(volume, box_of(scene, body)):
                found.append(body.medium)
        elif is_within(volume, solid):
            return [*found, body.medium]
        elif do_meet(volume, solid) and not (hollow is not None and is_within(solid, hollow)):
            found.append(body.medium)
    return [*found, surrounding_of(scene)]


def _boxes_meet(volume: Box | Sphere, corners: np.ndarray) -> bool:
    (low, high), (least, most) = volume.bounds, corners
    return bool(((np.array(low) < most) & (least < np.array(high))).all())


def _absorbs_in(medium: AnyMedium, volume: Box | Sphere) -> bool:
    if not isinstance(medium, Grid):
        return medium.absorption > 0
    return bool(medium.absorption[_voxels_in(medium, volume)].any())


def _voxels_in(grid: Grid, volume: Box | Sphere) -> tuple[slice, ...]:
    """The voxels of a grid that may have a part in a volume."""
    found = []
    sides = zip(*grid.box.bounds, *volume.bounds, grid.absorption.shape, strict=True)
    for start, end, low, high, count in sides:
        width = (end - start) / count
        slack = ROUNDING * (abs(start) + abs(end) + abs(low) + abs(high))
        first, last = np.clip([(low + slack - start) / width, (high - slack - start) / width], 0, count)
        found.append(slice(int(np.floor(first)), int(np.ceil(last))))
    return tuple(found)
