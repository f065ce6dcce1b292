"""Normals, areas and volume of many triangles at once, with the digits that slivers lose in plain arithmetic.

Twice the area is a vector product of two edges.  Edges are kept as the exact sum of two doubles, and products are
taken with their rounding errors (Dekker 1971; Shewchuk 1997, Adaptive precision floating-point arithmetic), so that
the error is 2^-104 of the edges' squares: as small as the rounding of the coordinates lets a sliver's height be.
"""

import math
from typing import NamedTuple

import numpy as np

ROUNDING = 2.0**-51  # of coordinates: a height below it is a line's
SPLITTER = 2.0**27 + 1
EPSILON = 2.0**-52


class Facets(NamedTuple):
    """Per triangle: unit normals (m, 3), areas (m,) [m^2], and whether its vertices lie on a line up to rounding."""

    normals: np.ndarray
    areas: np.ndarray
    on_a_line: np.ndarray


def facets(vertices: np.ndarray, faces: np.ndarray) -> Facets:
    """Unit normals by the right hand over the vertices' order, and areas [m^2], exact to a few roundings."""
    a, b, c = (np.ascontiguousarray(vertices[faces[:, i]].T) for i in range(3))
    (u, u_low), (v, v_low) = _difference(b, a), _difference(c, a)
    _, exponent = np.frexp(np.maximum(np.abs(u), np.abs(v)).max(axis=0))
    u, u_low, v, v_low = (np.ldexp(part, -exponent) for part in (u, u_low, v, v_low))
    twice = np.stack([_minor(u, u_low, v, v_low, i, j) for i, j in ((1, 2), (2, 0), (0, 1))])
    length = np.sqrt((twice * twice).sum(axis=0))
    longest = np.sqrt(np.maximum.reduce([(way * way).sum(axis=0) for way in (u, v, v - u)]))
    magnitude = np.abs(np.concatenate([a, b, c])).max(axis=0)
    with np.errstate(over="ignore", under="ignore", invalid="ignore", divide="ignore"):
        on_a_line = ~(length > ROUNDING * np.ldexp(magnitude, -exponent) * longest)
        normals = np.ascontiguousarray((twice / length).T) + 0.0
        areas = np.ldexp(length / 2, 2 * exponent)
    return Facets(normals, areas, on_a_line)


def signed_volume(
    vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray, areas: np.ndarray
) -> tuple[float, float]:
    """Volume [m^3] inside a closed mesh (negative where normals point inwards), and a bound on its rounding.

    By the divergence theorem, a third of the sum of area times distance of the triangle's plane from the middle.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    way = vertices[faces[:, 0]] - (low + (high - low) / 2)
    terms = way * normals * areas[:, None]
    return math.fsum(terms.ravel()) / 3, 4 * EPSILON * float(np.abs(terms).sum())


def winding_number(vertices: np.ndarray, faces: np.ndarray, point: np.ndarray) -> float:
    """How often the mesh surrounds a point: its solid angle over 4π (Van Oosterom and Strackee 1983, eq. 8).

    Of a point in a facet the angle of that facet counts as 0, so that half of the rest is left.
    """
    a, b, c = ((vertices - point)[faces[:, i]] for i in range(3))
    p, q, r = (np.sqrt((way * way).sum(axis=1)) for way in (a, b, c))
    above = (a * np.cross(b, c)).sum(axis=1)
    below = p * q * r + (a * b).sum(axis=1) * r + (b * c).sum(axis=1) * p + (c * a).sum(axis=1) * q
    return math.fsum(2 * np.arctan2(above, below)[above != 0]) / (4 * math.pi)


def _minor(u, u_low, v, v_low, i: int, j: int) -> np.ndarray:
    """u_i v_j - u_j v_i of vectors in two parts each."""
    (plus, plus_low), (minus, minus_low) = _product(u[i], v[j]), _product(u[j], v[i])
    high, low = _difference(plus, minus)
    mixed = (u[i] * v_low[j] - u[j] * v_low[i]) + (u_low[i] * v[j] - u_low[j] * v[i])
    return high + (low + ((plus_low - minus_low) + mixed))


def _difference(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """a - b as a double and its rounding error."""
    high = a - b
    b_seen = a - high
    return high, (a - (high + b_seen)) + (b_seen - b)


def _product(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """a b as a double and its rounding error."""
    high = a * b
    (a_high, a_low), (b_high, b_low) = _halves(a), _halves(b)
    return high, ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low


def _halves(a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A double as the sum of two of 26 bits."""
    spread = SPLITTER * a
    high = spread - (spread - a)
    return high, a - high
