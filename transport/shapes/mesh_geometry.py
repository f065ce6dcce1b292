"""Normals, areas and volume of many triangles at once, accurate for thin triangles.

Twice the area is the cross product of two edges. Edges are kept as exact sums of two doubles, and products
with their rounding errors (Dekker 1971; Shewchuk 1997, Adaptive precision floating-point arithmetic), so that
the error is 2^-104 of the squared edge lengths: as small as the height that rounded coordinates can still
represent.
"""

import math
from typing import NamedTuple

import numpy as np

ROUNDING = 2.0**-51  # relative to coordinates: triangles of smaller height count as lines
SPLITTER = 2.0**27 + 1
EPSILON = 2.0**-52


class Facets(NamedTuple):
    """Per triangle: unit normals (m, 3), areas (m,) [m^2], and whether its vertices are collinear."""

    normals: np.ndarray
    areas: np.ndarray
    on_a_line: np.ndarray


def facets(vertices: np.ndarray, faces: np.ndarray) -> Facets:
    """Unit normals (right-hand rule over the vertex order) and areas [m^2], accurate to a few roundings."""
    a, b, c = (np.ascontiguousarray(vertices[faces[:, i]].T) for i in range(3))
    (u, u_low), (v, v_low) = _difference(b, a), _difference(c, a)
    # Scale each triangle by a power of two, so that squares neither overflow nor underflow.
    _, exponent = np.frexp(np.maximum(np.abs(u), np.abs(v)).max(axis=0))
    u, u_low, v, v_low = (np.ldexp(part, -exponent) for part in (u, u_low, v, v_low))
    twice = np.stack([_minor(u, u_low, v, v_low, i, j) for i, j in ((1, 2), (2, 0), (0, 1))])
    # Compare the height with the rounding of the coordinates.
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
    """Volume [m^3] of a closed mesh (negative if normals point inwards), and a bound on its rounding error.

    Divergence theorem: a third of the sum of area times signed distance of the triangle's plane from the
    middle.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    way = vertices[faces[:, 0]] - (low + (high - low) / 2)
    terms = way * normals * areas[:, None]
    return math.fsum(terms.ravel()) / 3, 4 * EPSILON * float(np.abs(terms).sum())


def winding_number(vertices: np.ndarray, faces: np.ndarray, point: np.ndarray) -> float:
    """Winding number of the mesh around a point: solid angle over 4π (Van Oosterom and Strackee 1983, eq. 8).

    A facet that contains the point counts as 0, so that a point in a facet of a closed mesh has winding
    number 1/2.
    """
    a, b, c = ((vertices - point)[faces[:, i]] for i in range(3))
    p, q, r = (np.sqrt((way * way).sum(axis=1)) for way in (a, b, c))
    above = (a * np.cross(b, c)).sum(axis=1)
    below = p * q * r + (a * b).sum(axis=1) * r + (b * c).sum(axis=1) * p + (c * a).sum(axis=1) * q
    return math.fsum(2 * np.arctan2(above, below)[above != 0]) / (4 * math.pi)


def _minor(u, u_low, v, v_low, i: int, j: int) -> np.ndarray:
    """u_i v_j - u_j v_i of vectors given as sums of two doubles."""
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
    """Split a double into the sum of two 26-bit numbers (Dekker)."""
    spread = SPLITTER * a
    high = spread - (spread - a)
    return high, a - high
