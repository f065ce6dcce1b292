"""Points just off the emitting side of a source, which decide its particles' medium of birth."""

from __future__ import annotations

import math

import numpy as np

from transport.geometry.shape import Point, Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.sources import Source

SURFACE_OFFSET = 1e-9  # of a source's extent: distance of the points from an emitting surface
POINT_OFFSET = 2.0**-40  # [scene lengths] least distance of the points from the source
POINTS_PER_SOURCE = 64  # number of points per source
KRONECKER_STRIDES = 2.0 ** -(
    np.arange(1, 4) / 4
)  # strides of a sequence that fills the unit cube evenly (Kronecker)


def birth_points(source: Source, piece: Shape, size: float) -> np.ndarray:
    """Return points of one piece of a source [m], shape (n, 3). size: size of the scene [m]."""
    if isinstance(piece, Point):
        direction = np.array(source.emission.direction) if source.emission.law == "beam" else np.zeros(3)
        return np.array(piece.position)[None] + POINT_OFFSET * size * direction
    u = np.modf((np.arange(1, POINTS_PER_SOURCE + 1)[:, None]) * KRONECKER_STRIDES)[0]
    if not source.emission.has_side:
        return _points_in_volume(piece, u)
    places, normals = piece.sample_area(u)
    side = -1.0 if source.is_back else 1.0
    return places + side * max(SURFACE_OFFSET * piece.extent, POINT_OFFSET * size) * normals


def _points_in_volume(piece: Shape, u: np.ndarray) -> np.ndarray:
    """Return points evenly spread over a volume, shape (n, 3)."""
    middle = np.array(piece.middle)
    match piece:
        case Box(size=size):
            return middle + (u - 0.5) * np.array(size)
        case Sphere(radius=radius):
            return middle + radius * np.cbrt(u[:, 2:]) * _directions(u)
    return middle[None]


def _directions(u: np.ndarray) -> np.ndarray:
    mu, turn = 2 * u[:, 0] - 1, 2 * math.pi * u[:, 1]
    sine = np.sqrt((1 - mu) * (1 + mu))
    return np.stack([sine * np.cos(turn), sine * np.sin(turn), mu], axis=1)
