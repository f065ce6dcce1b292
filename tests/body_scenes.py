"""Bodies of media to test with: boxes, cans, a lens, stacks of layers; a lamp among them and one afar."""

from __future__ import annotations

import math

import numpy as np

import transport as tp
from transport.geometry.shape import Shape

T, M, V = tp.Transparent(), tp.Medium, tp.Vacuum()
LAMP = tp.Source(tp.Point(position=(1, 1.1, 1.2)), tp.Isotropic(power=1))
AFAR = tp.Source(tp.Point(position=(1, 1.1, 500)), tp.Isotropic(power=1))
GRID = tp.Grid(box=tp.Box(size=2), scattering=np.arange(24.0).reshape(2, 3, 4))


def filled(shape: Shape, medium, material=T, **named):
    return tp.Surface(shape, material, inside=medium, **named)


def corner(size):
    """A cube with a corner in the origin."""
    return tp.Box(center=(size / 2,) * 3, size=size)


def can(medium, material=T, center=(0, 0, 0), radius=1.0, outside=None):
    """A cylinder with two lids, of which the lower one looks down."""
    x, y, z = center
    rim = tp.Cylinder(center=center, radius=radius, height=2 * radius)
    lids = [tp.Disk(center=(x, y, z + s * radius), normal=(0, 0, s), radius=radius) for s in (1, -1)]
    return [tp.Surface(shape, material, inside=medium, outside=outside) for shape in (rim, *lids)]


def lens(medium, material):
    """Half a ball and its flat side, on z = 0.9 of the unit sphere."""
    flat = tp.Disk(center=(0, 0, 0.9), normal=(0, 0, -1), radius=math.sqrt(1 - 0.81))
    return [tp.Surface(s, material, inside=medium) for s in (tp.Sphere(radius=1, mu_min=0.9), flat)]


def stack(thicknesses, unit=1.0, shift=0.0):
    """Slabs on one another, each of its own medium, from z = shift downwards."""
    z, surfaces = shift, []
    for k, thickness in enumerate(np.array(thicknesses) * unit):
        shape = tp.Slab(center=(0, 0, z - thickness / 2), thickness=thickness)
        surfaces.append(filled(shape, M((k + 1) / unit)))
        z -= thickness
    return surfaces
