"""A square panel seen from its axis, near and far: what doubling the distance does to irradiance and to solid angle.

A panel of radiance L, of side a, gives E = L P and the fluence rate L Ω, P the projected solid angle and Ω the solid
angle (solid_angles.py).  Far away both are (a/d)² but for

    P (d/a)² = 1 - (a/d)²/3 + ...,   Ω (d/a)² = 1 - (a/d)²/4 + ...,

as cos⁴θ and cos³θ fall by twice and by 3/2 of r²/d², of which the mean is a²/6.  So a meter twice as far away has
E/4 (1 + (a/2d)²) and Ω/4 (1 + 3/4 (a/2d)²), while L is the same at any distance.
"""

from __future__ import annotations

import numpy as np

from transport.theory.nodes import legendre_nodes
from transport.theory.solid_angles import rectangle_projected_solid_angle, rectangle_solid_angle

NODES = 8  # Gauss-Legendre along each side of a meter that is small against its distance


def mean_rectangle_solid_angle(width: float, height: float, distance: float, side: float) -> float:
    """Mean over a square meter on the axis of the solid angle that a parallel rectangle fills [sr].

    side: of the meter [m], no longer than width and height.  At a point it is a sum over the four corners of
    atan(x y / (d sqrt(d² + x² + y²))), x and y from the point's foot (Van Oosterom and Strackee 1983).
    """
    t, weight = legendre_nodes(NODES)
    x, y = (long / 2 + np.outer([1, -1], side / 2 * t) for long in (width, height))
    product = np.multiply.outer(x, y)
    slant = np.sqrt(np.add.outer(x**2, y**2) + distance**2)
    corners = np.arctan2(product, distance * slant).sum(axis=(0, 2))
    return float(weight @ corners @ weight) / 4


def doubled_irradiance(side: float, distance: float) -> float:
    """E(2d) / E(d) on the axis of a square panel [1], tending to 1/4.  Vectorised."""
    near, far = (rectangle_projected_solid_angle(side, side, np.multiply(k, distance)) for k in (1, 2))
    return far / near


def doubled_solid_angle(side: float, distance: float) -> float:
    """Ω(2d) / Ω(d) on the axis of a square panel [1], tending to 1/4.  Vectorised."""
    near, far = (rectangle_solid_angle(side, side, np.multiply(k, distance)) for k in (1, 2))
    return far / near


def far_irradiance_excess(side: float, distance: float) -> float:
    """By which E(2d) / E(d) is more than 1/4, relative to it, far away [1]: (a/2d)²."""
    return np.square(side / np.multiply(2, distance))


def far_solid_angle_excess(side: float, distance: float) -> float:
    """By which Ω(2d) / Ω(d) is more than 1/4, relative to it, far away [1]: 3/4 (a/2d)²."""
    return 0.75 * far_irradiance_excess(side, distance)
