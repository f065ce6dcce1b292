"""Solid angles and projected solid angles: caps, shapes on the axis, bins of directions in a local frame.

The projected solid angle is the integral of max(cos theta, 0) d omega [sr]; over a hemisphere it is pi.
Cones about an oblique axis are in cones.py, bins of a world frame in world_bins.py.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.cones import cone_projected_solid_angle
from transport.theory.world_bins import projected_solid_angles

__all__ = [
    "bin_projected_solid_angles",
    "bin_solid_angles",
    "cap_projected_solid_angle",
    "cap_solid_angle",
    "cone_projected_solid_angle",
    "disk_projected_solid_angle",
    "disk_solid_angle",
    "projected_solid_angles",
    "rectangle_projected_solid_angle",
    "rectangle_solid_angle",
]


def cap_solid_angle(half_angle: float) -> float:
    """Solid angle of a spherical cap [sr]: 2 pi (1 - cos) = 4 pi sin^2(half_angle / 2)."""
    return 4 * math.pi * np.sin(np.divide(half_angle, 2)) ** 2


def cap_projected_solid_angle(half_angle: float) -> float:
    """Projected solid angle of a cap round the normal [sr]: pi sin^2(half_angle); pi beyond the horizon."""
    return math.pi * np.sin(np.minimum(half_angle, math.pi / 2)) ** 2


def disk_solid_angle(radius: float, distance: float) -> float:
    """Solid angle of a disk seen from a point on its axis [sr]: 2 pi (1 - d/h), h^2 = R^2 + d^2.

    Computed as 2 pi R^2 / (h (h + d)).
    """
    slant = np.hypot(distance, radius)
    return 2 * math.pi * (radius / slant) * (radius / (slant + distance))


def disk_projected_solid_angle(radius: float, distance: float) -> float:
    """Projected solid angle of a disk on the axis, parallel to the receiver [sr]: pi R^2 / (R^2 + d^2)."""
    return math.pi * (radius / np.hypot(distance, radius)) ** 2


def rectangle_solid_angle(width: float, height: float, distance: float) -> float:
    """Solid angle of a rectangle seen from a point on its axis [sr]: 4 atan(a b / (d sqrt(d^2 + a^2 + b^2))).

    a, b: half its sides.  Source: Van Oosterom and Strackee 1983 for its two triangles.
    """
    a, b = np.divide(width, 2), np.divide(height, 2)
    slant = np.hypot(distance, np.hypot(a, b))
    return 4 * np.arctan2(np.minimum(a, b), distance * (slant / np.maximum(a, b)))


def rectangle_projected_solid_angle(width: float, height: float, distance: float) -> float:
    """Projected solid angle of a rectangle seen from its axis by a parallel receiver [sr].

    2 [a/p atan(b/p) + b/r atan(a/r)], a, b half its sides, p^2 = a^2 + d^2, r^2 = b^2 + d^2 (Lambert 1760,
    by contour).
    """
    a, b = np.divide(width, 2), np.divide(height, 2)
    p, r = np.hypot(a, distance), np.hypot(b, distance)
    return 2 * (a / p * np.arctan(b / p) + b / r * np.arctan(a / r))


def bin_solid_angles(mu_edges, phi_edges) -> np.ndarray:
    """Solid angles of the bins of any frame [sr], shape (mu bins, phi bins): (mu2 - mu1) (phi2 - phi1)."""
    return np.multiply.outer(np.diff(mu_edges), np.diff(phi_edges))


def bin_projected_solid_angles(mu_edges, phi_edges) -> np.ndarray:
    """Projected solid angles of bins of the receiver's own frame [sr], shape (mu bins, phi bins).

    (mu2^2 - mu1^2) / 2 * (phi2 - phi1), mu = cos theta to the normal; below the horizon, mu < 0, is nothing.
    """
    above = np.maximum(mu_edges, 0.0)
    return np.multiply.outer(np.diff(above) * (above[1:] + above[:-1]) / 2, np.diff(phi_edges))
