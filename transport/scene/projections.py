"""Projections of directions onto a plane: where a direction lies in an image, and the solid angles of pixels.

A radial projection draws a direction at the polar angle theta from the optical axis at the distance r(theta)
from the middle of the image; its azimuth is kept. Coordinates u to the right and v upward have no unit.

=====================  ====================  =================================================
name                   r                     solid angle per area of the image
=====================  ====================  =================================================
pinhole                tan(theta)            cos^3(theta)
fisheye                theta                 sin(theta) / theta
equal-area fisheye     2 sin(theta/2)        1 (Lambert's azimuthal projection)
=====================  ====================  =================================================

A mirrored ball, photographed from afar, is the equal-area projection of the directions from which its
mirror sends light to the lens: the normal at the distance r' from the middle of a unit ball is tilted by
asin(r'), the direction by twice that, so that r' = sin(theta/2).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

PINHOLE, FISHEYE, EQUAL_AREA = "pinhole", "fisheye", "equal-area fisheye"
QUADRATURE_POINTS = 12  # per edge of a pixel; the integrand is smooth

Law = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class RadialProjection:
    """The laws of a projection: r of the polar angle theta [rad], theta of r, and the solid angle per area.

    rise: (1 - cos theta)/r^2 of r, without cancellation;  rim: radius of the image of all directions.
    """

    radius: Law
    angle: Law
    weight: Law
    rise: Law
    rim: float


RADIAL = {
    PINHOLE: RadialProjection(
        radius=np.tan,
        angle=np.arctan,
        weight=lambda r: (1 + r * r) ** -1.5,
        rise=lambda r: 1 / (np.sqrt(1 + r * r) * (1 + np.sqrt(1 + r * r))),
        rim=math.inf,
    ),
    FISHEYE: RadialProjection(
        radius=lambda theta: theta,
        angle=lambda r: np.minimum(r, math.pi),
        weight=lambda r: np.sinc(r / math.pi),
        rise=lambda r: np.sinc(r / (2 * math.pi)) ** 2 / 2,
        rim=math.pi,
    ),
    EQUAL_AREA: RadialProjection(
        radius=lambda theta: 2 * np.sin(theta / 2),
        angle=lambda r: 2 * np.arcsin(np.minimum(r / 2, 1.0)),
        weight=np.ones_like,
        rise=lambda r: np.full_like(r, 0.5),
        rim=2.0,
    ),
}
RADIUS_OF_ALL = {name: each.rim for name, each in RADIAL.items() if each.rim < math.inf}


def image_radius(projection: str, theta: float) -> float:
    """Return the distance from the middle of the image at which a polar angle [rad] lies."""
    return float(RADIAL[projection].radius(theta))


def polar_angles(projection: str, radius: np.ndarray) -> np.ndarray:
    """Return the polar angles [rad] at distances from the middle of the image; pi beyond its rim."""
    return RADIAL[projection].angle(radius)


def radial_rays(projection: str, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return unit vectors to the right, upward and along the axis at points of the image, (..., 3)."""
    radius = np.hypot(u, v)
    theta = polar_angles(projection, radius)
    aside = np.divide(np.sin(theta), radius, out=np.ones_like(radius), where=radius > 0)
    return np.stack([aside * u, aside * v, np.cos(theta)], axis=-1)


def radial_weights(projection: str, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return the solid angle per area of the image at its points; 0 beyond its rim."""
    law, radius = RADIAL[projection], np.hypot(u, v)
    return np.where(radius < law.rim, law.weight(radius), 0.0)


def radial_places(projection: str, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return u and v of unit vectors in these axes; nan where they are not in the image."""
    across, along = np.hypot(rays[..., 0], rays[..., 1]), rays[..., 2]
    radius = RADIAL[projection].radius(np.arctan2(across, along))
    if projection == PINHOLE:
        radius = np.where(along > 0, radius, np.nan)
    aside = np.divide(radius, across, out=np.zeros_like(across), where=across > 0)
    return aside * rays[..., 0], aside * rays[..., 1]


def pixel_solid_angles(projection: str, v: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return the solid angles [sr] of the pixels between edges; 0 of those beyond the rim.

    A region of the image has the solid angle of the integral of 1 - cos(theta) over the azimuth along its
    boundary (Green); of a straight edge at the distance x from the middle that is the integral of
    x (1 - cos theta)/r^2 over its length. Beyond the rim the integrand is 2x/r^2, and adds nothing.
    """
    if projection == PINHOLE:  # the solid angle of the rectangle from the axis to each corner
        v, u = np.meshgrid(v, u, indexing="ij")
        return np.diff(np.diff(np.arctan(u * v / np.sqrt(1 + u * u + v * v)), axis=0), axis=1)
    upright = _along_edges(projection, u, v)  # of edges at u, by their part between rows, (rows, u)
    level = _along_edges(projection, v, u)  # of edges at v, by their part between columns, (columns, v)
    angles = np.diff(upright, axis=1) + np.diff(level, axis=1).T
    # Pixels beyond the rim have none, but for rounding.
    nearest = np.hypot(*np.meshgrid(_nearest_to_0(v), _nearest_to_0(u), indexing="ij"))
    return np.where(nearest < RADIUS_OF_ALL[projection], np.maximum(angles, 0.0), 0.0)


def _nearest_to_0(edges: np.ndarray) -> np.ndarray:
    """Return the distance from 0 of each interval."""
    low, high = edges[:-1], edges[1:]
    return np.maximum(0.0, np.maximum(low, -high))


def _along_edges(projection: str, at: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Integrals of x (1 - cos theta)/r^2 along the lines at x, between values y, shape (y - 1, x)."""
    law = RADIAL[projection]
    x, end = at, np.sqrt(np.maximum(law.rim**2 - at * at, 0.0))  # within the rim is |y| < end
    low, high = along[:-1, None], along[1:, None]
    first, last = np.clip(low, -end, end), np.clip(high, -end, end)
    middle, half = (last + first) / 2, (last - first) / 2
    nodes, weights = np.polynomial.legendre.leggauss(QUADRATURE_POINTS)
    inside = np.zeros_like(middle)
    for node, weight in zip(nodes, weights, strict=True):
        inside += weight * half * x * law.rise(np.hypot(x, middle + half * node))
    beyond = ((np.minimum(low, -end), np.minimum(high, -end)), (np.maximum(low, end), np.maximum(high, end)))
    outside = sum(np.arctan2(stop, np.abs(x)) - np.arctan2(start, np.abs(x)) for start, stop in beyond)
    return inside + 2 * np.sign(x) * outside
