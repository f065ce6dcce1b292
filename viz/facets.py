"""Every shape as flat facets that know their bin: what is drawn of it, and where on it a detector's bins of place lie.

The corners are those of the shape's own coordinates (transport.scene.bins.Positions), finely divided where it is round; the
order of a facet's corners makes its right-hand normal that of the shape.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from transport.geometry.flat import Disk, FlatPolygon, Plane, Rectangle, Slab
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Cylinder, Revolved
from transport.geometry.shape import Cloud, Point, Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.bins import Positions

TURN = 2 * math.pi
ROUND = TURN / 120  # the finest step of an angle [rad]
RINGS = 24  # steps along a paraboloid
SIGMAS = 2.0  # at which a Gaussian cloud is drawn: it holds 74 % of the particles

Bounds = tuple[np.ndarray, np.ndarray]  # lower and upper corner [m]


class Facets(NamedTuple):
    """Flat facets.  points: (n, 3) [m];  faces: (m, 3 or 4) rows of them;  bins: (m,) the flat number of each facet's

    bin, u before v, or -1 where it is in none.  One without positions is bin 0 as a whole.
    """

    points: np.ndarray
    faces: np.ndarray
    bins: np.ndarray

    @property
    def centres(self) -> np.ndarray:
        """(m, 3) [m]."""
        return self.points[self.faces].mean(axis=1)

    @property
    def vector_areas(self) -> np.ndarray:
        """Normal times area of each facet, (m, 3) [m^2]."""
        corners = self.points[self.faces]
        return 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1])


def facets_of(
    shape: Shape, positions: Positions | None = None, bounds: Bounds | None = None, step: float = ROUND
) -> Facets:
    """The facets of a shape, cut along the edges of the bins of `positions`; a shape without end is cut to `bounds` [m].

    step: the longest of an angle [rad] where the shape is round.
    """
    match shape:
        case Rectangle() if shape.hole is not None:
            return _holed(shape)
        case Rectangle() | Disk() | Revolved():
            return _on_coordinates(shape, positions, step)
        case Box():
            return joined([facets_of(face) for face in shape.faces().values()])
        case FlatPolygon():
            corners = np.array([triangle.vertices for triangle in shape.primitives()])
            return _plain(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
        case Mesh():
            return _plain(shape.vertices, shape.faces)
        case Plane():
            return _cut_plane(shape, bounds)
        case Slab():
            return joined([_cut_plane(plane, bounds) for plane in shape.planes()])
        case Cloud():
            ball = facets_of(Sphere(radius=SIGMAS))
            return ball._replace(points=np.array(shape.center) + ball.points * np.array(shape.sigma))
        case Point():
            return _plain(np.array([shape.position]), np.zeros((0, 3), dtype=int))
    raise TypeError(f"facets_of: no facets of a {type(shape).__name__}")


def half_box(plane: Plane, bounds: Bounds, is_behind: bool = True) -> Facets:
    """What of the walls of the box lies behind a plane, or before it, as triangles."""
    low, high = (np.asarray(corner, dtype=float) for corner in bounds)
    sides = Box(center=(low + high) / 2, size=high - low).faces().values()
    found = [_fan(_half(facets_of(side).points[[0, 2, 3, 1]], plane, is_behind)) for side in sides]
    return joined([each for each in found if len(each.faces)] or [_fan(np.zeros((0, 3)))])


def joined(several: list[Facets]) -> Facets:
    """Facets of one kind, put together."""
    firsts = np.cumsum([0] + [len(each.points) for each in several])
    return Facets(
        np.concatenate([each.points for each in several]),
        np.concatenate([each.faces + first for each, first in zip(several, firsts, strict=False)]),
        np.concatenate([each.bins for each in several]),
    )


def _plain(points: np.ndarray, faces: np.ndarray) -> Facets:
    return Facets(np.asarray(points, dtype=float), faces, np.zeros(len(faces), dtype=int))


def _on_coordinates(shape: Rectangle | Disk | Revolved, positions: Positions | None, step: float) -> Facets:
    """A grid of facets along u and v."""
    ranges = ranges_of(shape)
    edges = {} if positions is None else positions.edges(shape)
    (u, of_u), (v, of_v) = (
        _steps(ranges[name], edges.get(name), finest)
        for name, finest in zip("uv", _finest(shape, ranges["u"], step), strict=True)
    )
    across = len(edges["v"]) - 1 if "v" in edges else 1
    bins = np.where((of_u[:, None] < 0) | (of_v < 0), -1, of_u[:, None] * across + of_v)
    return Facets(
        places_on(shape)(u[:, None], v[None, :]), _grid(len(u), len(v), _turns_in(shape)), bins.ravel()
    )


def ranges_of(shape: Shape) -> dict[str, tuple[float, float]]:
    """From where to where u and v go on the whole shape, as in Positions."""
    match shape:
        case Rectangle():
            return {"u": (-shape.width / 2, shape.width / 2), "v": (-shape.height / 2, shape.height / 2)}
        case Disk():
            return {"u": (shape.inner_radius, shape.radius), "v": (0.0, TURN)}
        case Sphere():
            return {"u": (math.acos(shape.mu_max), math.acos(shape.mu_min)), "v": (0.0, TURN)}
    profile = shape.profile
    return {"u": (profile.low + profile.lift, profile.high + profile.lift), "v": (0.0, TURN)}


def _finest(shape: Shape, along: tuple[float, float], step: float) -> tuple[float, float]:
    """The longest steps of u and v that look round."""
    if isinstance(shape, Rectangle):
        return math.inf, math.inf
    if isinstance(shape, Sphere):
        return step, step
    is_straight = isinstance(shape, Disk | Cylinder) or shape.profile.gamma > 0
    return math.inf if is_straight else (along[1] - along[0]) * step / ROUND / RINGS, step


def _steps(
    whole: tuple[float, float], edges: np.ndarray | None, finest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Steps over the whole range that hold all edges, none longer than `finest`; and the bin of each step, or -1."""
    marks = np.array(whole) if edges is None else np.unique([whole[0], *edges, whole[1]])
    counts = np.maximum(1, np.ceil(np.diff(marks) / finest * (1 - 1e-12))).astype(int)
    before = np.repeat(np.cumsum(counts) - counts, counts)
    share = (np.arange(counts.sum()) - before) / np.repeat(counts, counts)
    steps = np.append(np.repeat(marks[:-1], counts) + share * np.repeat(np.diff(marks), counts), marks[-1])
    if edges is None:
        return steps, np.zeros(len(steps) - 1, dtype=int)
    middles = (steps[1:] + steps[:-1]) / 2
    found = np.searchsorted(edges, middles) - 1
    return steps, np.where((middles > edges[0]) & (middles < edges[-1]), found, -1)


def places_on(shape: Shape) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """The function from u and v to places, (n, 3) [m]."""
    e_u, e_v, n = (np.array(axis) for axis in shape.frame)
    center = np.array(shape.center)

    def spread(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
        a, b, c = np.broadcast_arrays(a, b, c)
        return center + (a[..., None] * e_u + b[..., None] * e_v + c[..., None] * n).reshape(-1, 3)

    match shape:
        case Rectangle():
            return lambda u, v: spread(u, v, 0.0)
        case Disk():
            return lambda u, v: spread(u * np.cos(v), u * np.sin(v), 0.0)
        case Sphere(radius=radius):
            return lambda u, v: spread(
                radius * np.sin(u) * np.cos(v), radius * np.sin(u) * np.sin(v), radius * np.cos(u)
            )
    profile = shape.profile

    def revolved(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        rho = profile.radius_at(u - profile.lift)
        return spread(rho * np.cos(v), rho * np.sin(v), u)

    return revolved


def _turns_in(shape: Shape) -> bool:
    """Whether u, v and the normal are a left-handed frame: where u goes along an axis."""
    return isinstance(shape, Revolved) and not isinstance(shape, Sphere)


def _grid(rows: int, columns: int, is_turned: bool) -> np.ndarray:
    """Quadrilaterals of a grid of points, u before v."""
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    corners = (0, 1, columns + 1, columns) if is_turned else (0, columns, columns + 1, 1)
    return first[:, None] + np.array(corners)


def _holed(shape: Rectangle) -> Facets:
    """Between the rims of the hole and of the rectangle, both round the hole's middle: at angles that hold every corner."""
    e_u, e_v, _ = (np.array(axis) for axis in shape.frame)
    hole, middle = shape.hole, np.array(shape.hole.center) - np.array(shape.center)
    middle = np.array([middle @ e_u, middle @ e_v])
    outer = np.array([[a * shape.width, b * shape.height] for a, b in _SQUARE]) / 2 - middle
    inner = None
    if isinstance(hole, Rectangle):
        along, across = (np.array([np.dot(axis, e_u), np.dot(axis, e_v)]) for axis in hole.frame[:2])
        inner = np.array([a * hole.width * along + b * hole.height * across for a, b in _SQUARE]) / 2
    corners = outer if inner is None else np.concatenate([outer, inner])
    angles = np.unique(np.r_[np.arange(0, TURN, ROUND), np.arctan2(corners[:, 1], corners[:, 0]) % TURN])
    way = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    rims = [_ray_to(inner, way) if inner is not None else np.full(len(way), hole.radius), _ray_to(outer, way)]
    flat = np.concatenate([rim[:, None] * way + middle for rim in rims])
    here = np.arange(len(way))
    after = (here + 1) % len(way)
    faces = np.stack([here, here + len(way), after + len(way), after], axis=-1)
    return _plain(np.array(shape.center) + flat[:, :1] * e_u + flat[:, 1:] * e_v, faces)


_SQUARE = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def _ray_to(corners: np.ndarray, way: np.ndarray) -> np.ndarray:
    """How far a convex rim of these corners is from the origin within it, along each way."""
    side = np.roll(corners, -1, axis=0) - corners
    normal = np.stack([side[:, 1], -side[:, 0]], axis=-1)
    normal *= np.sign((normal * corners).sum(axis=1))[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = (normal * corners).sum(axis=1) / (way @ normal.T)
    return np.where((way @ normal.T) > 0, reach, np.inf).min(axis=1)


def _half(rim: np.ndarray, plane: Plane, is_behind: bool) -> np.ndarray:
    """The part of a convex polygon on one side of a plane (Sutherland and Hodgman 1974)."""
    height = (rim - np.array(plane.center)) @ np.array(plane.normal) * (1 if is_behind else -1)
    kept = []
    for k, here in enumerate(height):
        after = height[k - len(rim) + 1]
        if here <= 0:
            kept.append(rim[k])
        if here * after < 0:
            kept.append(rim[k] + here / (here - after) * (rim[k - len(rim) + 1] - rim[k]))
    return np.array(kept).reshape(-1, 3)


def _fan(rim: np.ndarray) -> Facets:
    """Triangles of a convex polygon."""
    if len(rim) < 3:
        return _plain(np.zeros((0, 3)), np.zeros((0, 3), dtype=int))
    return _plain(rim, np.array([[0, k, k + 1] for k in range(1, len(rim) - 1)]))


def _cut_plane(plane: Plane, bounds: Bounds | None) -> Facets:
    """The polygon in which a plane meets the box, as triangles; none where it passes by."""
    if bounds is None:
        raise ValueError("facets_of: a shape without end needs bounds")
    low, high = (np.asarray(corner, dtype=float) for corner in bounds)
    e_u, e_v, n = (np.array(axis) for axis in plane.frame)
    corners = np.array(list(itertools.product(*zip(low, high, strict=True))))
    height = (corners - np.array(plane.center)) @ n
    height[np.abs(height) < 1e-9 * np.ptp(height)] = 0.0
    found = [corners[height == 0]]
    for a, b in itertools.combinations(range(8), 2):
        if (corners[a] != corners[b]).sum() == 1 and height[a] * height[b] < 0:
            share = height[a] / (height[a] - height[b])
            found.append([corners[a] + share * (corners[b] - corners[a])])
    rim = np.concatenate(found)
    if len(rim) < 3:
        return _fan(rim)
    around = rim - rim.mean(axis=0)
    return _fan(rim[np.argsort(np.arctan2(around @ e_v, around @ e_u))])
