"""Solid angles and projected solid angles of caps, shapes on the axis and bins of directions.

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
    """Solid angle of a spherical cap.

    Parameters
    ----------
    half_angle : float or ndarray
        Half angle of the cap [rad].

    Returns
    -------
    float or ndarray
        ``2 pi (1 - cos) = 4 pi sin^2(half_angle / 2)`` [sr].

    Examples
    --------
    >>> from transport.theory.solid_angles import cap_solid_angle
    >>> print(f"{cap_solid_angle(0.5):.4g}")
    0.7692
    """
    return 4 * math.pi * np.sin(np.divide(half_angle, 2)) ** 2


def cap_projected_solid_angle(half_angle: float) -> float:
    """Projected solid angle of a cap about the normal.

    Parameters
    ----------
    half_angle : float or ndarray
        Half angle of the cap [rad].

    Returns
    -------
    float or ndarray
        ``pi sin^2(half_angle)`` [sr]; pi for a cap that reaches beyond the horizon.

    Examples
    --------
    >>> from transport.theory.solid_angles import cap_projected_solid_angle
    >>> print(f"{cap_projected_solid_angle(0.5):.4g}")
    0.7221
    """
    return math.pi * np.sin(np.minimum(half_angle, math.pi / 2)) ** 2


def disk_solid_angle(radius: float, distance: float) -> float:
    """Solid angle of a disk from a point on its axis.

    Parameters
    ----------
    radius : float or ndarray
        Radius R of the disk [m].
    distance : float or ndarray
        Distance d of the point from the plane [m].

    Returns
    -------
    float or ndarray
        ``2 pi (1 - d/h)`` with ``h^2 = R^2 + d^2``, computed as ``2 pi R^2 / (h (h + d))`` [sr].

    Examples
    --------
    >>> from transport.theory.solid_angles import disk_solid_angle
    >>> print(f"{disk_solid_angle(1.0, 2.0):.4g}")
    0.6633
    """
    slant = np.hypot(distance, radius)
    return 2 * math.pi * (radius / slant) * (radius / (slant + distance))


def disk_projected_solid_angle(radius: float, distance: float) -> float:
    """Projected solid angle of a disk on the axis of a parallel receiver.

    Parameters
    ----------
    radius : float or ndarray
        Radius R of the disk [m].
    distance : float or ndarray
        Distance d of the point from the plane [m].

    Returns
    -------
    float or ndarray
        ``pi R^2 / (R^2 + d^2)`` [sr].

    Examples
    --------
    >>> from transport.theory.solid_angles import disk_projected_solid_angle
    >>> print(f"{disk_projected_solid_angle(1.0, 2.0):.4g}")
    0.6283
    """
    return math.pi * (radius / np.hypot(distance, radius)) ** 2


def rectangle_solid_angle(width: float, height: float, distance: float) -> float:
    """Solid angle of a rectangle from a point on its axis.

    Parameters
    ----------
    width : float or ndarray
        Width of the rectangle, 2 a [m].
    height : float or ndarray
        Height of the rectangle, 2 b [m].
    distance : float or ndarray
        Distance d of the point from the plane [m].

    Returns
    -------
    float or ndarray
        ``4 atan(a b / (d sqrt(d^2 + a^2 + b^2)))``, a and b half the sides [sr].

    Notes
    -----
    Source: Van Oosterom and Strackee 1983 for its two triangles.

    Examples
    --------
    >>> from transport.theory.solid_angles import rectangle_solid_angle
    >>> print(f"{rectangle_solid_angle(1.0, 1.0, 2.0):.4g}")
    0.2354
    """
    a, b = np.divide(width, 2), np.divide(height, 2)
    slant = np.hypot(distance, np.hypot(a, b))
    return 4 * np.arctan2(np.minimum(a, b), distance * (slant / np.maximum(a, b)))


def rectangle_projected_solid_angle(width: float, height: float, distance: float) -> float:
    """Projected solid angle of a rectangle on the axis of a parallel receiver.

    Parameters
    ----------
    width : float or ndarray
        Width of the rectangle, 2 a [m].
    height : float or ndarray
        Height of the rectangle, 2 b [m].
    distance : float or ndarray
        Distance d of the point from the plane [m].

    Returns
    -------
    float or ndarray
        ``2 [a/p atan(b/p) + b/r atan(a/r)]`` [sr], a and b half the sides, ``p^2 = a^2 + d^2``,
        ``r^2 = b^2 + d^2``.

    Notes
    -----
    Source: Lambert 1760, by contour integration.

    Examples
    --------
    >>> from transport.theory.solid_angles import rectangle_projected_solid_angle
    >>> print(f"{rectangle_projected_solid_angle(1.0, 1.0, 2.0):.4g}")
    0.2308
    """
    a, b = np.divide(width, 2), np.divide(height, 2)
    p, r = np.hypot(a, distance), np.hypot(b, distance)
    return 2 * (a / p * np.arctan(b / p) + b / r * np.arctan(a / r))


def bin_solid_angles(mu_edges, phi_edges) -> np.ndarray:
    """Solid angles of bins of directions in any frame.

    Parameters
    ----------
    mu_edges : array_like
        Edges of the cosine to the polar axis, increasing, shape (n + 1,) [1].
    phi_edges : array_like
        Edges of the azimuth, increasing, shape (m + 1,) [rad].

    Returns
    -------
    ndarray
        ``(mu2 - mu1) (phi2 - phi1)``, shape (mu bins, phi bins) [sr].

    Examples
    --------
    >>> from transport.theory.solid_angles import bin_solid_angles
    >>> print(bin_solid_angles([0.0, 0.5, 1.0], [0.0, 1.0]).round(4))
    [[0.5]
     [0.5]]
    """
    return np.multiply.outer(np.diff(mu_edges), np.diff(phi_edges))


def bin_projected_solid_angles(mu_edges, phi_edges) -> np.ndarray:
    """Projected solid angles of bins of directions in the receiver's own frame.

    Parameters
    ----------
    mu_edges : array_like
        Edges of the cosine to the polar axis, increasing, shape (n + 1,) [1].
    phi_edges : array_like
        Edges of the azimuth, increasing, shape (m + 1,) [rad].

    Returns
    -------
    ndarray
        ``(mu2^2 - mu1^2) / 2 * (phi2 - phi1)``, shape (mu bins, phi bins) [sr]; 0 below the horizon,
        mu < 0.

    Examples
    --------
    >>> from transport.theory.solid_angles import bin_projected_solid_angles
    >>> print(bin_projected_solid_angles([0.0, 0.5, 1.0], [0.0, 1.0]).round(4))
    [[0.125]
     [0.375]]
    """
    above = np.maximum(mu_edges, 0.0)
    return np.multiply.outer(np.diff(above) * (above[1:] + above[:-1]) / 2, np.diff(phi_edges))
