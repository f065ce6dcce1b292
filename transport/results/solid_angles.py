"""Solid angle and exact projected solid angle of a detector's direction bins, averaged over its shape."""

import math
from functools import lru_cache

import numpy as np

from transport.geometry.shape import Shape
from transport.geometry.solid_angles import cone_projected_solid_angle, projected_solid_angles
from transport.scene.bins import DirectionCone
from transport.scene.detectors import Detector
from transport.vectors import dot

HEMISPHERE, SPHERE, CIRCLE = (0.0, 1.0), (-1.0, 1.0), (0.0, 2.0 * math.pi)


@lru_cache(maxsize=64)
def solid_angles_of(detector: Detector, shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    """∫dω and ∫|cosθ|dω [sr] of each direction bin, (mu or theta, phi) without axes that are not binned."""
    directions = detector.directions
    if isinstance(directions, DirectionCone):
        return _cone(directions, detector, shape)
    edges = directions.edges()
    cosines, swap = _cosine_edges(edges, SPHERE if directions.frame == "world" else HEMISPHERE)
    turns = edges.get("phi", np.array(CIRCLE))
    plain = np.outer(np.diff(cosines), np.diff(turns))
    if directions.frame == "local":
        middle = 0.5 * (cosines[1:] + cosines[:-1])
        projected = plain * middle[:, None]
    elif not shape.pieces()[0].is_flat:
        # The mean of max(cosθ, 0) over a sphere's surface is 1/4 for any direction.
        projected = plain / 4.0
    else:
        projected = _mean_over_pieces(detector, shape, lambda n: projected_solid_angles(cosines, turns, n))
    order = slice(None, None, -1 if swap else 1)
    has_cosine = "mu" in edges or "theta" in edges
    kept = (order if has_cosine else 0, slice(None) if "phi" in edges else 0)
    return plain[kept], projected[kept]


def _cosine_edges(edges: dict[str, np.ndarray], whole: tuple[float, float]) -> tuple[np.ndarray, bool]:
    """Ascending edges in cosθ, and whether they come from descending θ."""
    if "theta" in edges:
        return np.cos(edges["theta"])[::-1], True
    return np.asarray(edges.get("mu", whole)), False


def _cone(cone: DirectionCone, detector: Detector, shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    plain = np.array([4.0 * math.pi * math.sin(0.5 * cone.half_angle) ** 2])
    if not shape.pieces()[0].is_flat:
        return plain, plain / 4.0
    return plain, _mean_over_pieces(
        detector, shape, lambda n: np.array([cone_projected_solid_angle(cone.half_angle, dot(cone.axis, n))])
    )


def _mean_over_pieces(detector: Detector, shape: Shape, angle) -> np.ndarray:
    side = -1.0 if detector.is_back else 1.0
    parts = shape.pieces()
    shares = [1.0 if piece.is_infinite else piece.area for piece in parts]  # infinite planes count equally
    angles = [angle(tuple(side * x + 0.0 for x in piece.normal)) for piece in parts]
    return sum(share * each for share, each in zip(shares, angles, strict=True)) / math.fsum(shares)
