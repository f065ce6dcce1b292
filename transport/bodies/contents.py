"""Absorption in a volume: whether the media that it may hold absorb there."""

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
    """Whether any medium that a volume may hold absorbs; media that touch it from outside do not count.

    hollow: sphere in the volume that is not part of it.
    """
    return any(_absorbs_in(medium, volume) for medium in _media_within(scene, volume, hollow))


def most_absorption(scene: SceneParts, volume: Box | Sphere) -> float:
    """Largest absorption coefficient [1/m] that a volume may hold."""
    return max(float(np.max(medium.absorption)) for medium in _media_within(scene, volume))


def _media_within(scene: SceneParts, volume: Box | Sphere, hollow: Sphere | None = None) -> list[AnyMedium]:
    """Media that may fill part of a volume, the innermost first.

    The search ends at the first body that holds the whole volume.
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
    """Whether the volume's bounding box and a box (2, 3) overlap."""
    (low, high), (least, most) = volume.bounds, corners
    return bool(((np.array(low) < most) & (least < np.array(high))).all())


def _absorbs_in(medium: AnyMedium, volume: Box | Sphere) -> bool:
    """Whether a medium absorbs in a volume; of a Grid the voxels that reach into it count."""
    if not isinstance(medium, Grid):
        return medium.absorption > 0
    return bool(medium.absorption[_voxels_in(medium, volume)].any())


def _voxels_in(grid: Grid, volume: Box | Sphere) -> tuple[slice, ...]:
    """Slices of the voxels of a grid that may reach into a volume."""
    found = []
    sides = zip(*grid.box.bounds, *volume.bounds, grid.absorption.shape, strict=True)
    for start, end, low, high, count in sides:
        width = (end - start) / count
        slack = ROUNDING * (abs(start) + abs(end) + abs(low) + abs(high))
        first, last = np.clip([(low + slack - start) / width, (high - slack - start) / width], 0, count)
        found.append(slice(int(np.floor(first)), int(np.ceil(last))))
    return tuple(found)
