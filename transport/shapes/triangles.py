"""Geometry of one triangle, in rational numbers where thin triangles would cancel; rounded once."""

import math
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise

from transport.vectors import Frame, Vector, dot, local_frame, unit_vector

Vertices = tuple[Vector, Vector, Vector]
Corner = tuple[float, float]
ROUNDING = Fraction(2) ** -51  # relative to coordinates: triangles of smaller height count as lines


@lru_cache(maxsize=4096)
def normal_and_area(vertices: Vertices) -> tuple[Vector, float]:
    """Unit normal (right-hand rule over the vertex order) and area [m^2], infinite on overflow."""
    twice = _twice_area(vertices)
    largest = max(map(abs, twice))
    scaled = tuple(float(component / largest) for component in twice)
    try:
        return unit_vector(scaled), float(largest) * math.hypot(*scaled) / 2
    except OverflowError:
        return unit_vector(scaled), math.inf


def is_on_a_line(vertices: Vertices) -> bool:
    """Whether the vertices are collinear within the rounding of their coordinates."""
    twice, size = _twice_area(vertices), max(abs(Fraction(x)) for vertex in vertices for x in vertex)
    longest2 = max(_square(_way(a, b)) for a, b in pairwise((*vertices, vertices[0])))
    return _square(twice) <= (ROUNDING * size) ** 2 * longest2


def centroid(vertices: Vertices) -> Vector:
    """Mean of the vertices [m]; exact quarters avoid overflow."""
    return tuple(math.fsum(0.25 * x for x in axis) / 0.75 for axis in zip(*vertices, strict=True))


def frame_of(vertices: Vertices) -> Frame:
    """Unit vectors (e_u, e_v, n): e_u from the first vertex to the second, e_v = n x e_u."""
    normal, _ = normal_and_area(vertices)
    e_u = unit_vector(tuple(q - p for p, q in zip(*vertices[:2], strict=True)))
    return e_u, local_frame(e_u, normal)[0], normal


def corners_of(vertices: Vertices) -> tuple[Corner, ...]:
    """Coordinates (u, v) [m] of the vertices in the triangle's frame, from the centroid."""
    (e_u, e_v, _), center = frame_of(vertices), centroid(vertices)
    ways = [tuple(p - c for p, c in zip(vertex, center, strict=True)) for vertex in vertices]
    return tuple((dot(way, e_u), dot(way, e_v)) for way in ways)


def distance_beside(corners: tuple[Corner, ...], u: float, v: float) -> float:
    """Distance [m] of a point of the plane from a triangle with counterclockwise corners (u, v); 0 inside."""
    sides = list(pairwise((*corners, corners[0])))
    if all((q - p) * (v - s) >= (t - s) * (u - p) for (p, s), (q, t) in sides):
        return 0.0
    return min(_distance_to_side(one, other, (u, v)) for one, other in sides)


def _distance_to_side(one: Corner, other: Corner, point: Corner) -> float:
    """Distance [m] of a point from a side."""
    length, way = math.dist(one, other), tuple(q - p for p, q in zip(one, other, strict=True))
    along = dot([x / length for x in way], [x - p for p, x in zip(one, point, strict=True)]) / length
    within = min(max(along, 0.0), 1.0)
    return math.dist([p + within * x for p, x in zip(one, way, strict=True)], point)


def _twice_area(vertices: Vertices) -> tuple[Fraction, ...]:
    """Cross product of two edges, exact."""
    a, b, c = vertices
    (ux, uy, uz), (vx, vy, vz) = _way(a, b), _way(a, c)
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


def _way(a: Vector, b: Vector) -> tuple[Fraction, ...]:
    """Exact vector from a to b."""
    return tuple(Fraction(q) - Fraction(p) for p, q in zip(a, b, strict=True))


def _square(vector: tuple[Fraction, ...]) -> Fraction:
    """Exact squared length."""
    return sum(component * component for component in vector)
