"""Flat polygon, not necessarily convex; it is intersected and sampled as triangles.

Tests of its sides are exact: each sign is that of a determinant of doubles, rounded if its error bound allows
it, else in whole numbers.
"""

import math
from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from transport.geometry.flat import (
    FlatPolygon,
    Triangle,
    Vertices,
    distance_to_side,
    even_facets,
    is_collinear,
    points_in_triangles,
    twice_area,
    whole_numbers,
)
from transport.geometry.shape import ROUNDING
from transport.validation import Converted, as_floats, refuse, scene_object, set_fields, short_repr
from transport.vectors import Vector, dot, unit_vector

MAX_VERTICES = 1000  # the time to divide a polygon grows with the square of their number
SIGN_ERROR = 8 * 2.0**-53  # relative error of a rounded determinant, with a margin
SMALLEST_PRODUCT = 2.0**-960  # of lengths: smaller ones may have lost digits

Points = np.ndarray  # (n, 2) coordinates of vertices along two axes, exactly as given


@scene_object(kw_only=True)
class Polygon(FlatPolygon):
    """Flat polygon with straight sides that do not cross; convex or not.

    Parameters
    ----------
    vertices : three or more points of three floats
        Vertices [m] in order along the outline, in one plane. Seen from the side that the normal points to,
        they run counterclockwise.

    Raises
    ------
    SceneError
        If there are fewer than 3 or more than 1000 vertices, if two of them coincide, or if they lie on one
        line, are not in one plane within rounding, or describe an outline that crosses or touches itself.

    Notes
    -----
    It lies on sheets like a `Rectangle`: detectors may be patches of a wall, and polygons on one plane may
    share sides. Inside the engine it is a set of triangles that share their sides, so that nothing leaks
    between them.

    Examples
    --------
    >>> import transport as tp
    >>> corner = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)]
    >>> tp.Polygon(vertices=corner).area
    3.0
    """

    vertices: Converted[Iterable[Iterable[float]], tuple[Vector, ...]]

    def __post_init__(self) -> None:
        given = self.vertices if isinstance(self.vertices, Iterable) else ()
        vertices = tuple(as_floats(vertex) for vertex in given)
        if not 3 <= len(vertices) <= MAX_VERTICES or any(v is None or len(v) != 3 for v in vertices):
            must = f"vertices must be 3 to {MAX_VERTICES} points of three finite numbers"
            cure = "write vertices=[(x, y, z), ...]; for more use a Mesh"
            refuse(self, f"{must}, got {len(vertices)} in {short_repr(self.vertices)}; {cure}")
        set_fields(self, vertices=vertices)
        self._check_vertices()
        self._check_outline()
        self._check_size("vertices")

    @property
    def normal(self) -> Vector:
        """Unit normal."""
        return _normal(self.vertices)

    @property
    def center(self) -> Vector:
        """Centroid of the area [m]."""
        return _center_and_area(self.vertices)[0]

    @property
    def area(self) -> float:
        """Area of one side [m^2]."""
        return _center_and_area(self.vertices)[1]

    @property
    def least_width(self) -> float:
        """Twice the area over the length of the outline [m], as its share near the sides decides."""
        return 2 * self.area / sum(math.dist(p, q) for p, q in pairwise((*self.vertices, self.vertices[0])))

    def inner_sides(self, part: Triangle) -> tuple[bool, bool, bool]:
        """Return which sides of a triangle, opposite to its second, third and first vertex, are inside."""
        outline = set(map(frozenset, pairwise((*self.vertices, self.vertices[0]))))
        first, second, third = part.vertices
        sides = (first, third), (first, second), (second, third)
        return tuple(frozenset(side) not in outline for side in sides)

    def primitives(self) -> tuple[Triangle, ...]:
        """Return the triangles that it is divided into."""
        return _triangles(self.vertices)

    def _check_vertices(self) -> None:
        """Raise for vertices that coincide, lie on one line, or are not in one plane."""
        vertices = self.vertices
        if len(set(vertices)) < len(vertices):
            twice = next(k for k, vertex in enumerate(vertices) if vertex in vertices[:k])
            must = f"vertices must differ, got {vertices[twice]} as number {vertices.index(vertices[twice])}"
            refuse(self, f"{must} and {twice}, counted from 0; leave the second out, the last side closes it")
        largest = _largest_corner(vertices)
        if is_collinear(largest):
            got = f"{short_repr(vertices)}, which has no area"
            refuse(self, f"vertices must not lie on one line, got {got}; move one of them")
        # Compare the heights over the plane with the rounding of coordinates.
        normal = unit_vector(_scaled(twice_area(largest)[0]))
        sizes = [sum(map(abs, vertex)) for vertex in vertices]
        heights = [
            abs(dot(tuple(p - q for p, q in zip(vertex, largest[0], strict=True)), normal))
            for vertex in vertices
        ]
        worst = max(range(len(vertices)), key=lambda k: heights[k])
        if heights[worst] > ROUNDING * (max(sizes) + math.dist(vertices[worst], largest[0])):
            got = f"number {worst}, {vertices[worst]}, {heights[worst]:.3g} m off"
            refuse(
                self,
                f"vertices must lie in one plane, got {got} the plane of others;"
                " move it there, or make it a Mesh of triangles",
            )

    def _check_outline(self) -> None:
        """Raise if two sides cross or touch, other than neighbours at their common vertex."""
        points, count = _in_plane(self.vertices), len(self.vertices)
        ends = np.roll(points, -1, axis=0)
        # Select the pairs of sides whose boxes meet; neighbours must not fold, and others must not touch.
        low, high = np.minimum(points, ends), np.maximum(points, ends)
        i, j = np.nonzero(np.triu(((low[:, None] <= high) & (low <= high[:, None])).all(axis=2), 1))
        is_next, is_last = j == i + 1, (j + 1) % count == i
        first, shared, beside = np.where(is_next, i, j), np.where(is_next, j, i), is_next | is_last
        meets = np.zeros(len(i), bool)
        a, b = first[beside], shared[beside]
        meets[beside] = _fold(points[a], points[b], ends[b])
        a, b = i[~beside], j[~beside]
        meets[~beside] = _meet(points[a], ends[a], points[b], ends[b])
        if meets.any():
            one, other = int(i[meets][0]), int(j[meets][0])
            got = f"sides {one} and {other}, from {self.vertices[one]} and from {self.vertices[other]}"
            refuse(
                self,
                f"vertices must describe an outline that does not cross or touch itself, got {got};"
                " put the vertices in order along the outline, or divide it",
            )

    def _covers(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        inside = np.zeros(np.shape(u), bool)
        for (p, s), (q, t) in pairwise((*self.corners, self.corners[0])):
            # Count the sides that a line along +u crosses; each contains its lower end only.
            is_up = t > s
            turn = (q - p) * (v - s) - (t - s) * (u - p)
            inside ^= ((s <= v) != (t <= v)) & ((turn > 0) == is_up) & (turn != 0)
        return inside

    def _gap(self, u: float, v: float) -> tuple[float, ...]:
        if self._covers(np.float64(u), np.float64(v)):
            return (0.0,)
        sides = pairwise((*self.corners, self.corners[0]))
        return (min(distance_to_side(one, other, (u, v)) for one, other in sides),)

    def _sample(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        triangles = self.primitives()
        facets, left = even_facets(np.array([triangle.area for triangle in triangles]), one[:, 0])
        corners = np.array([triangle.vertices for triangle in triangles])[facets]
        return points_in_triangles(corners, left, other)


# ---- Plane of the vertices.


@lru_cache(maxsize=1024)
def _edges(vertices: tuple[Vector, ...]) -> np.ndarray:
    """Vectors (n, 3) from the first vertex to each, exact, as whole numbers of one unit."""
    whole, _ = whole_numbers(x for vertex in vertices for x in vertex)
    places = np.array(whole, object).reshape(-1, 3)
    return places - places[0]


@lru_cache(maxsize=1024)
def _largest_corner(vertices: tuple[Vector, ...]) -> Vertices:
    """Three vertices that define the plane well: the first, the farthest from it, the largest triangle."""
    first, edges = vertices[0], _edges(vertices)
    second = max(vertices, key=lambda vertex: math.dist(first, vertex))
    areas2 = (np.cross(edges[vertices.index(second)], edges) ** 2).sum(axis=1)
    return first, second, max(zip(areas2, vertices, strict=True))[1]


def _vector_area(vertices: tuple[Vector, ...]) -> list[int]:
    """Vector area, in whole numbers (Newell)."""
    edges = _edges(vertices)
    return np.cross(edges[1:-1], edges[2:]).sum(axis=0).tolist()


@lru_cache(maxsize=1024)
def _normal(vertices: tuple[Vector, ...]) -> Vector:
    """Unit normal: direction of the vector area."""
    return unit_vector(_scaled(_vector_area(vertices)))


def _scaled(vector: Sequence[int]) -> Vector:
    """Vector of the same direction, of length about 1."""
    largest = max(map(abs, vector))
    return tuple(component / largest for component in vector)


def _in_plane(vertices: tuple[Vector, ...]) -> Points:
    """Coordinates along the two axes that are best seen from the normal, counterclockwise: exact."""
    normal = _scaled(twice_area(_largest_corner(vertices))[0])
    dropped = max(range(3), key=lambda axis: abs(normal[axis]))
    axes = [(dropped + 1) % 3, (dropped + 2) % 3]
    return np.array(vertices)[:, axes if _vector_area(vertices)[dropped] >= 0 else axes[::-1]]


# ---- Signs of determinants: which way three points turn.


def _turns(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Sign of the area of triangles (a, b, c), each (2,) or (n, 2): +1 counterclockwise; exact."""
    with np.errstate(over="ignore", invalid="ignore"):
        left = (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1])
        right = (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
        twice = np.atleast_1d(left - right)
        bound = SIGN_ERROR * (np.abs(left) + np.abs(right)) + SMALLEST_PRODUCT
        doubtful = ~(np.abs(twice) > bound)  # also products that underflow or overflow
    signs = np.sign(twice)
    if doubtful.any():
        a, b, c = (np.broadcast_to(points, (len(signs), 2)) for points in (a, b, c))
        for k in np.flatnonzero(doubtful):
            p, q, r, s, t, u = whole_numbers([*a[k].tolist(), *b[k].tolist(), *c[k].tolist()])[0]
            area = (r - p) * (u - q) - (s - q) * (t - p)
            signs[k] = (area > 0) - (area < 0)
    return signs


def _are_between(a: Points, b: Points, c: Points) -> np.ndarray:
    """Return which points c, on lines through a and b, lie on the segments."""
    return ((np.minimum(a, b) <= c) & (c <= np.maximum(a, b))).all(axis=1)


def _fold(a: Points, b: Points, c: Points) -> np.ndarray:
    """Return which sides from a to b and from b to c overlap."""
    return (_turns(a, b, c) == 0) & (_are_between(a, b, c) | _are_between(b, c, a))


def _meet(a: Points, b: Points, c: Points, d: Points) -> np.ndarray:
    """Return which segments from a to b and from c to d have a point in common."""
    ends = (a, b, c), (a, b, d), (c, d, a), (c, d, b)
    turns = [_turns(*each) for each in ends]
    meets = (turns[0] * turns[1] < 0) & (turns[2] * turns[3] < 0)
    for turn, each in zip(turns, ends, strict=True):
        meets |= (turn == 0) & _are_between(*each)
    return meets


# ---- Division into triangles.


@lru_cache(maxsize=1024)
def _triangles(vertices: tuple[Vector, ...]) -> tuple[Triangle, ...]:
    """Triangles of a polygon by cutting off ears (Meisters 1975), the best shaped first.

    A vertex that lies on a line with its neighbours within rounding is left out: the ear has no area.
    """
    points, count, found = _in_plane(vertices), len(vertices), []
    # Rate the triangle at each vertex: its quality where it may be an ear, else -inf.
    before, after = np.arange(count) - 1, (np.arange(count) + 1) % count
    is_left, blocker = np.ones(count, bool), np.full(count, -1)
    quality, rating = np.empty(count), np.empty(count)
    changed = np.arange(count)
    for _ in range(count - 3):
        corners = points[before[changed]], points[changed], points[after[changed]]
        quality[changed] = _quality(*corners)
        rating[changed] = np.where(_turns(*corners) > 0, quality[changed], -np.inf)
        # Cut off the best ear; a triangle that holds another vertex waits until that one is cut off.
        while rating[tip := int(rating.argmax())] > -np.inf:
            blocker[tip] = _vertex_within(points, is_left, (before[tip], tip, after[tip]))
            if blocker[tip] < 0:
                break
            rating[tip] = -np.inf
        else:
            tip = int(np.where(is_left, np.abs(quality), np.inf).argmin())
        corner = int(before[tip]), tip, int(after[tip])
        if not _is_line(vertices, corner):
            found.append(corner)
        # Join its neighbours, and rate them and the triangles that it blocked again.
        is_left[tip], rating[tip], blocker[tip] = False, -np.inf, -1
        before[corner[2]], after[corner[0]] = corner[0], corner[2]
        blocker[[corner[0], corner[2]]] = tip
        changed = np.flatnonzero(blocker == tip)
        blocker[changed] = -1
    left = np.flatnonzero(is_left).tolist()
    if not _is_line(vertices, tuple(left)):
        found.append(tuple(left))
    return tuple(Triangle(vertices=[vertices[k] for k in corner]) for corner in found)


@lru_cache(maxsize=1024)
def _center_and_area(vertices: tuple[Vector, ...]) -> tuple[Vector, float]:
    """Centroid [m] and area [m^2] of a polygon, from its triangles."""
    triangles = _triangles(vertices)
    areas = [triangle.area for triangle in triangles]
    area, places = math.fsum(areas), zip(*(triangle.center for triangle in triangles), strict=True)
    return tuple(math.fsum(a / area * x for a, x in zip(areas, axis, strict=True)) for axis in places), area


def _is_line(vertices: tuple[Vector, ...], corner: tuple[int, ...]) -> bool:
    """Return whether three vertices lie on one line within rounding."""
    return is_collinear(tuple(vertices[k] for k in corner))


def _quality(before: Points, tip: Points, after: Points) -> np.ndarray:
    """Area over squared longest side of triangles (n, 2): the largest are best shaped."""
    one, other = tip - before, after - before
    longest = np.maximum.reduce([(side * side).sum(axis=1) for side in (one, other, other - one)])
    return (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]) / longest


def _vertex_within(points: Points, is_left: np.ndarray, corner: tuple[int, int, int]) -> int:
    """Return another vertex in the triangle that cuts off a convex vertex; -1 if there is none."""
    a, b, c = (points[k] for k in corner)
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    near = is_left & (points >= low).all(axis=1) & (points <= high).all(axis=1)
    near[list(corner)] = False
    others = np.flatnonzero(near)
    for p, q in ((a, b), (b, c), (c, a)):
        others = others[_turns(p, q, points[others]) >= 0] if others.size else others
    return int(others[0]) if others.size else -1
