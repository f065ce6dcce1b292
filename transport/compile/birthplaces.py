"""Points just off the emitting side of a source, which decide its particles' medium of birth."""

from __future__ import annotations

import math

import numpy as np

from transport.geometry.flat import Disk, FlatShape, Rectangle, Triangle
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Revolved
from transport.geometry.shape import Point, Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.emissions import Beam
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
        direction = np.array(source.emission.direction) if isinstance(source.emission, Beam) else np.zeros(3)
        return np.array(piece.position)[None] + POINT_OFFSET * size * direction
    u = np.modf((np.arange(1, POINTS_PER_SOURCE + 1)[:, None]) * KRONECKER_STRIDES)[0]
    if not source.emission.has_side:
        return _points_in_volume(piece, u)
    places, normals = _points_on_surface(piece, u)
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


def _points_on_surface(piece: Shape, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points on a surface and the normals there, shape (n, 3) each."""
    middle = np.array(piece.middle)
    match piece:
        case Mesh():
            facets = (u[:, 2] * len(piece.faces)).astype(int)
            return piece.vertices[piece.faces[facets]].mean(axis=1), piece.normals[facets]
        case Sphere() if piece.is_closed:
            return middle + piece.radius * _directions(u), _directions(u)
        case Revolved():
            return _points_on_revolved(piece, u)
        case FlatShape():
            places = _points_on_flat(piece, u)
            return places, np.broadcast_to(piece.normal, places.shape)
    return middle[None], np.zeros((1, 3))


def _points_on_flat(piece: FlatShape, u: np.ndarray) -> np.ndarray:
    e_u, e_v, _ = (np.array(e) for e in piece.frame)
    match piece:
        case Rectangle(width=width, height=height):
            center = np.array(piece.center)
            places = center + (u[:, :1] - 0.5) * width * e_u + (u[:, 1:2] - 0.5) * height * e_v
            return places if piece.hole is None else places[~_is_in_hole(piece.hole, places)]
        case Disk(radius=outer, inner_radius=inner):
            rho = np.sqrt(inner**2 + u[:, :1] * (outer - inner) * (outer + inner))
            turn = 2 * math.pi * u[:, 1:2]
            return np.array(piece.center) + rho * (np.cos(turn) * e_u + np.sin(turn) * e_v)
        case Triangle():
            first, second, third = (np.array(vertex) for vertex in piece.vertices)
            s = np.sqrt(u[:, :1])
            return first + s * (1 - u[:, 1:2]) * (second - first) + s * u[:, 1:2] * (third - first)
    return np.array(piece.middle)[None]


def _is_in_hole(hole: Disk | Rectangle, places: np.ndarray) -> np.ndarray:
    e_u, e_v, _ = (np.array(e) for e in hole.frame)
    u, v = (places - np.array(hole.center)) @ e_u, (places - np.array(hole.center)) @ e_v
    if isinstance(hole, Disk):
        return u * u + v * v <= hole.radius**2
    return (np.abs(u) <= hole.width / 2) & (np.abs(v) <= hole.height / 2)


def _points_on_revolved(piece: Revolved, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    profile, (e_u, e_v, axis) = piece.profile, (np.array(e) for e in piece.frame)
    w = (profile.low + u[:, 0] * (profile.high - profile.low))[:, None]
    turn = 2 * math.pi * u[:, 1:2]
    out = np.cos(turn) * e_u + np.sin(turn) * e_v
    rho = np.array([[profile.radius_at(float(h))] for h in w[:, 0]])
    slope = 0.5 * profile.beta + profile.gamma * w
    normals = (rho * out - slope * axis) / np.hypot(rho, slope)
    return np.array(profile.origin) + w * axis + rho * out, normals
