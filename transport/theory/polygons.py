"""Solid angles of triangles and polygons, seen from any point; the dodecahedron, whose face is nearly a steradian.

A triangle with the vertices a, b, c fills, seen from the origin (Van Oosterom and Strackee 1983, eq. 8),

    tan(Omega / 2) = a.(b x c) / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|)

Above it all terms cancel for a sliver or a distant triangle, below it for a point close to an edge.  Here products
are formed in exact fractions, and below, where two terms have opposite signs, x + y = (x^2 - y^2) / (x - y) with an
exact difference; so the result has rounding error only, unless the triangle's lengths differ by more than 1e50.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

Point = Sequence[float]

DODECAHEDRON_FACE = math.pi / 3  # sr, 4 pi / 12; "1 sr" in Bala 2009 (Cornell CS 6620, lecture 2) is rounded
ORIGIN = (0.0, 0.0, 0.0)


def triangle_solid_angle(vertices: Sequence[Point], position: Point = ORIGIN) -> float:
    """Solid angle of a triangle seen from a position [sr]; 2 pi from within it, nan from its edge.

    vertices: three points.  Source: Van Oosterom and Strackee 1983, eq. 8, as above.
    """
    return abs(_signed(_seen_from(position, vertices)))


def polygon_solid_angle(vertices: Sequence[Point], position: Point = ORIGIN) -> float:
    """Solid angle of a flat polygon seen from a position [sr]; 2 pi from within it, nan from its edge.

    vertices: three points or more, in order.  The triangles of the fan about the first add up with their signs, so
    that the polygon need not be convex.
    """
    first, *others = _seen_from(position, vertices)
    return abs(math.fsum(_signed((first, *pair)) for pair in zip(others, others[1:], strict=False)))


def regular_polygon_solid_angle(sides: int, radius: float, distance: float) -> float:
    """Solid angle of a regular polygon seen from its axis [sr]: 2 pi - 2 n atan(tan(pi/n) d/h), h^2 = R^2 + d^2.

    radius: R, to the vertices.  Written as 2 n atan((1 - k) t / (1 + k t^2)), t = tan(pi/n), k = d/h, with
    1 - k = R^2 / (h (h + d)).  It is a sum of right-angled triangles (Van Oosterom and Strackee 1983).
    """
    slant, t = math.hypot(radius, distance), math.tan(math.pi / sides)
    k, short = distance / slant, radius / slant * (radius / (slant + distance))
    return 2 * sides * math.atan2(short * t, 1 + k * t * t)


def dodecahedron_faces(radius: float = 1.0) -> np.ndarray:
    """The twelve faces of a dodecahedron round the origin as vertices [unit of radius], shape (12, 5, 3).

    radius: to its vertices.  Each face counterclockwise seen from outside.  The vertices are those of a cube and of
    three rectangles in the golden ratio (Coxeter 1973, Regular Polytopes, 3.7).
    """
    golden = (1 + math.sqrt(5)) / 2
    signs = [(p, q) for p in (1.0, -1.0) for q in (1.0, -1.0)]
    corners = [(p, q, r) for p, q in signs for r in (1.0, -1.0)]
    corners += [np.roll((0, p / golden, q * golden), turn) for turn in range(3) for p, q in signs]
    corners = np.array(corners) * (radius / math.sqrt(3))
    normals = [np.roll((0, p * golden, q), turn) for turn in range(3) for p, q in signs]
    return np.array([_face(corners, np.array(normal)) for normal in normals])


def _face(corners: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """The five corners furthest along a normal, in their order round it."""
    five = corners[np.argsort(corners @ normal)[-5:]]
    across = five[0] - five.mean(axis=0)
    along = np.cross(normal / np.linalg.norm(normal), across)
    return five[np.argsort(np.arctan2(five @ along, five @ across))]


def _seen_from(position: Point, vertices: Sequence[Point]) -> list[list[Fraction]]:
    """The vertices relative to the position, exactly, in units of their largest coordinate."""
    origin = [Fraction(float(p)) for p in position]
    offsets = [[Fraction(float(x)) - p for x, p in zip(vertex, origin, strict=True)] for vertex in vertices]
    largest = max(abs(x) for offset in offsets for x in offset) or Fraction(1)
    return [[x / largest for x in offset] for offset in offsets]


def _signed(triangle: Sequence[Sequence[Fraction]]) -> float:
    """The solid angle, positive where the vertices run clockwise seen from the origin."""
    a, b, c = _widest_first(triangle)
    length_a, length_b, length_c = (_root(_dot(v, v)) for v in (a, b, c))
    above = float(_dot(a, _cross(b, c)))
    ab, ac, bc = _dot(a, b), _dot(a, c), _dot(b, c)
    below = length_c * _sum(length_a * length_b, 1.0, Fraction(1), ab, _dot(a, a) * _dot(b, b) - ab * ab)
    below += _sum(length_b, length_a, ac, bc, ac * ac * _dot(b, b) - bc * bc * _dot(a, a))
    return 2 * math.atan2(above, below) if above or below else math.nan


def _widest_first(triangle: Sequence[Sequence[Fraction]]) -> Sequence[Sequence[Fraction]]:
    """The vertices turned so that the first two are those furthest apart in direction."""
    turned = [(*triangle[k:], *triangle[:k]) for k in range(3)]

    def cosine(turn: Sequence[Sequence[Fraction]]) -> float:
        a, b, _ = turn
        lengths = _root(_dot(a, a)) * _root(_dot(b, b))
        return float(_dot(a, b)) / lengths if lengths else 1.0

    return min(turned, key=cosine)


def _sum(first: float, second: float, p: Fraction, q: Fraction, squares: Fraction) -> float:
    """p first + q second; squares: their squares' exact difference, for terms of opposite signs."""
    x, y = float(p) * first, float(q) * second
    return x + y if x * y >= 0 else float(squares) / (x - y)


def _root(square: Fraction) -> float:
    return math.sqrt(float(square))


def _dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((p * q for p, q in zip(a, b, strict=True)), Fraction(0))


def _cross(a: Sequence[Fraction], b: Sequence[Fraction]) -> list[Fraction]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
