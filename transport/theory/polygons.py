"""Solid angles of triangles and polygons from any point; the dodecahedron, whose face is close to 1 sr.

A triangle with the vertices a, b, c subtends at the origin (Van Oosterom and Strackee 1983, eq. 8)

    tan(Omega / 2) = a.(b x c) / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|)

The numerator cancels for a sliver or a distant triangle, the denominator for a point close to an edge.
Products are therefore formed in exact fractions, and in the denominator, where two terms have opposite
signs, x + y = (x^2 - y^2) / (x - y) with an exact difference. The result has rounding error only,
unless the triangle's lengths differ by more than 1e50.
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
    """Solid angle of a triangle.

    Parameters
    ----------
    vertices : sequence of 3 points
        Vertices [m].
    position : Point, default ORIGIN
        Point of observation [m].

    Returns
    -------
    float
        Solid angle [sr]; 2 pi from inside the triangle, nan from its edge.

    Notes
    -----
    Source: Van Oosterom and Strackee 1983, eq. 8, as in the module's docstring.

    Examples
    --------
    >>> from transport.theory.polygons import triangle_solid_angle
    >>> print(f"{triangle_solid_angle([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]):.4g}")
    1.571
    """
    return abs(_signed(_seen_from(position, vertices)))


def polygon_solid_angle(vertices: Sequence[Point], position: Point = ORIGIN) -> float:
    """Solid angle of a flat polygon, convex or not.

    Parameters
    ----------
    vertices : sequence of points
        Three vertices or more, in order [m].
    position : Point, default ORIGIN
        Point of observation [m].

    Returns
    -------
    float
        Solid angle [sr]; 2 pi from inside the polygon, nan from its edge.

    Notes
    -----
    The signed solid angles of the triangles of the fan about the first vertex add up.

    Examples
    --------
    >>> from transport.theory.polygons import polygon_solid_angle
    >>> square = [(1.0, 1.0, 1.0), (-1.0, 1.0, 1.0), (-1.0, -1.0, 1.0), (1.0, -1.0, 1.0)]
    >>> print(f"{polygon_solid_angle(square):.4g}")
    2.094
    """
    first, *others = _seen_from(position, vertices)
    return abs(math.fsum(_signed((first, *pair)) for pair in zip(others, others[1:], strict=False)))


def regular_polygon_solid_angle(sides: int, radius: float, distance: float) -> float:
    """Solid angle of a regular polygon from a point on its axis.

    Parameters
    ----------
    sides : int
        Number n of sides.
    radius : float
        Distance R from the center to the vertices [m].
    distance : float
        Distance d from the polygon's plane [m].

    Returns
    -------
    float
        ``2 pi - 2 n atan(tan(pi/n) d/h)`` with ``h^2 = R^2 + d^2`` [sr].

    Notes
    -----
    Computed as ``2 n atan((1 - k) t / (1 + k t^2))``, t = tan(pi/n), k = d/h, with
    ``1 - k = R^2 / (h (h + d))``. A sum of right-angled triangles (Van Oosterom and Strackee 1983).

    Examples
    --------
    >>> from transport.theory.polygons import regular_polygon_solid_angle
    >>> print(f"{regular_polygon_solid_angle(6, 1.0, 1.0):.4g}")
    1.632
    """
    slant, t = math.hypot(radius, distance), math.tan(math.pi / sides)
    k, short = distance / slant, radius / slant * (radius / (slant + distance))
    return 2 * sides * math.atan2(short * t, 1 + k * t * t)


def dodecahedron_faces(radius: float = 1.0) -> np.ndarray:
    """Vertices of the twelve faces of a dodecahedron about the origin.

    Parameters
    ----------
    radius : float, default 1.0
        Distance of the vertices from the origin [m].

    Returns
    -------
    ndarray
        Vertices, shape (12, 5, 3), each face counterclockwise as seen from outside [m].

    Notes
    -----
    The vertices are those of a cube and of three rectangles in the golden ratio (Coxeter 1973, Regular
    Polytopes, 3.7).

    Examples
    --------
    >>> from transport.theory.polygons import dodecahedron_faces
    >>> dodecahedron_faces().shape
    (12, 5, 3)
    """
    golden = (1 + math.sqrt(5)) / 2
    signs = [(p, q) for p in (1.0, -1.0) for q in (1.0, -1.0)]
    corners = [(p, q, r) for p, q in signs for r in (1.0, -1.0)]
    corners += [np.roll((0, p / golden, q * golden), turn) for turn in range(3) for p, q in signs]
    corners = np.array(corners) * (radius / math.sqrt(3))
    normals = [np.roll((0, p * golden, q), turn) for turn in range(3) for p, q in signs]
    return np.array([_face(corners, np.array(normal)) for normal in normals])


def _face(corners: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """The five vertices furthest along a normal, in their order around it."""
    five = corners[np.argsort(corners @ normal)[-5:]]
    across = five[0] - five.mean(axis=0)
    along = np.cross(normal / np.linalg.norm(normal), across)
    return five[np.argsort(np.arctan2(five @ along, five @ across))]


def _seen_from(position: Point, vertices: Sequence[Point]) -> list[list[Fraction]]:
    """Vertices relative to the position, exactly, in units of their largest coordinate."""
    origin = [Fraction(float(p)) for p in position]
    offsets = [[Fraction(float(x)) - p for x, p in zip(vertex, origin, strict=True)] for vertex in vertices]
    largest = max(abs(x) for offset in offsets for x in offset) or Fraction(1)
    return [[x / largest for x in offset] for offset in offsets]


def _signed(triangle: Sequence[Sequence[Fraction]]) -> float:
    """Solid angle, positive if the vertices run clockwise as seen from the origin."""
    a, b, c = _widest_first(triangle)
    length_a, length_b, length_c = (_root(_dot(v, v)) for v in (a, b, c))
    above = float(_dot(a, _cross(b, c)))
    ab, ac, bc = _dot(a, b), _dot(a, c), _dot(b, c)
    below = length_c * _sum(length_a * length_b, 1.0, Fraction(1), ab, _dot(a, a) * _dot(b, b) - ab * ab)
    below += _sum(length_b, length_a, ac, bc, ac * ac * _dot(b, b) - bc * bc * _dot(a, a))
    return 2 * math.atan2(above, below) if above or below else math.nan


def _widest_first(triangle: Sequence[Sequence[Fraction]]) -> Sequence[Sequence[Fraction]]:
    """Vertices rotated so that the first two are those furthest apart in direction."""
    turned = [(*triangle[k:], *triangle[:k]) for k in range(3)]

    def cosine(turn: Sequence[Sequence[Fraction]]) -> float:
        """Cosine between the first two vertices."""
        a, b, _ = turn
        lengths = _root(_dot(a, a)) * _root(_dot(b, b))
        return float(_dot(a, b)) / lengths if lengths else 1.0

    return min(turned, key=cosine)


def _sum(first: float, second: float, p: Fraction, q: Fraction, squares: Fraction) -> float:
    """p first + q second; squares: the exact difference of their squares, for terms of opposite signs."""
    x, y = float(p) * first, float(q) * second
    return x + y if x * y >= 0 else float(squares) / (x - y)


def _root(square: Fraction) -> float:
    return math.sqrt(float(square))


def _dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((p * q for p, q in zip(a, b, strict=True)), Fraction(0))


def _cross(a: Sequence[Fraction], b: Sequence[Fraction]) -> list[Fraction]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
