"""Uncollided fluence from a glowing box through absorbing boxes, without scattering.

A point P receives, along each direction, the emission of the chord of length l in the source,
attenuated on the way to P:

    φ(P) = Q/(4π) ∫ dω exp(-τ) (1 - exp(-σ l))/σ,    τ = ∫ σ ds from P to where the ray enters the source

which is the volume integral of Q exp(-τ)/(4π r²) with the radial integral done (Kobayashi, Sugimura and
Nagaya 2001, Prog. Nucl. Energy 39, 119). The directions are integrated over the faces of the source
visible from P, dω = h dA/r³, with h the distance of P from the face's plane; from inside, over the
faces through which the rays leave.

Path lengths in boxes are analytic except for rays through an edge of a box, and edges project from P as
straight lines onto the face. Gauss-Legendre quadrature between those lines converges exponentially, in
panels graded about the projection of P.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from transport.statistics.quadrature import legendre_nodes

ORDER = 10  # nodes per panel
FINEST_EXPONENT = -2  # power of 2 of the finest panel about the projection of P: a quarter of the height
RAYS_PER_CHUNK = 400_000  # rays per chunk
UNBOUNDED = 1e9  # scale factor at which a projected edge counts as unbounded


class Region(NamedTuple):
    """An axis-parallel box of uniform extinction.

    Parameters
    ----------
    low : tuple of 3 float
        Lower corner [m].
    high : tuple of 3 float
        Upper corner [m].
    extinction : float
        Extinction coefficient [m^-1].
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    extinction: float


class Space:
    """Regions that are nested, touch or are disjoint; the innermost applies, outside all is vacuum.

    Parameters
    ----------
    regions : Iterable[Region]
        The regions.

    Raises
    ------
    ValueError
        If two regions overlap without one containing the other.
    """

    def __init__(self, regions: Iterable[Region]) -> None:
        self.regions = [
            Region(tuple(map(float, r.low)), tuple(map(float, r.high)), r.extinction) for r in regions
        ]
        self.low, self.high = (np.array([corners[k] for corners in self.regions]) for k in (0, 1))
        for one, other in ((i, j) for j in range(len(self.regions)) for i in range(j)):
            self._check(one, other)
        # Weight the length in a region by the excess of its extinction over that of the enclosing region.
        self.surplus = np.array(
            [r.extinction - self._enclosing_extinction(k) for k, r in enumerate(self.regions)]
        )

    def extinction_in(self, low: Sequence[float], high: Sequence[float]) -> float:
        """Return the extinction of the smallest region that contains a box.

        Parameters
        ----------
        low : sequence of float
            Lower corner of the box [m].
        high : sequence of float
            Upper corner of the box [m].

        Returns
        -------
        float
            Extinction [m^-1]; 0 outside all regions.
        """
        holds = (self.low <= low).all(axis=1) & (self.high >= high).all(axis=1)
        return self._smallest(np.flatnonzero(holds))

    def optical_depths(self, start: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """Return the optical depths ∫ σ ds from one point to other points, exactly.

        Parameters
        ----------
        start : ndarray
            Starting point, shape (3,) [m].
        ends : ndarray
            End points, shape (..., 3) [m].

        Returns
        -------
        ndarray
            Optical depths, shape (...) [1].
        """
        offset = ends - start
        total, length = np.zeros(offset.shape[:-1]), np.sqrt((offset * offset).sum(axis=-1))
        with np.errstate(divide="ignore"):
            inverse = 1 / np.where(offset == 0, 1e-300, offset)
        reach = (np.minimum(start, ends.min(axis=tuple(range(ends.ndim - 1)))),
                 np.maximum(start, ends.max(axis=tuple(range(ends.ndim - 1)))))  # fmt: skip
        for low, high, surplus in zip(self.low, self.high, self.surplus, strict=True):
            if surplus and (low < reach[1]).all() and (high > reach[0]).all():
                total += surplus * _share_in_box(low - start, high - start, inverse) * length
        return total

    def _enclosing_extinction(self, k: int) -> float:
        holds = self._holds(k)
        return self._smallest(holds[holds != k])

    def _holds(self, k: int) -> np.ndarray:
        return np.flatnonzero((self.low <= self.low[k]).all(axis=1) & (self.high >= self.high[k]).all(axis=1))

    def _smallest(self, which: np.ndarray) -> float:
        volumes = np.prod(self.high - self.low, axis=1)
        return self.regions[min(which, key=volumes.__getitem__)].extinction if len(which) else 0.0

    def _check(self, one: int, other: int) -> None:
        low, high = np.maximum(self.low[one], self.low[other]), np.minimum(self.high[one], self.high[other])
        apart = (low >= high).any()
        nested = one in self._holds(other) or other in self._holds(one)
        same = (self.low[one] == self.low[other]).all() and (self.high[one] == self.high[other]).all()
        if same or not (apart or nested):
            raise ValueError(
                f"Space: {self.regions[one]} and {self.regions[other]} overlap; split or nest them"
            )


def uncollided_fluence(
    point: Sequence[float], low: Sequence[float], high: Sequence[float], space: Space, order: int = ORDER
) -> float:
    """Uncollided fluence rate at a point from a box of uniform isotropic emission.

    Parameters
    ----------
    point : sequence of float
        The point P, shape (3,) [m].
    low : sequence of float
        Lower corner of the source, shape (3,) [m].
    high : sequence of float
        Upper corner of the source, shape (3,) [m].
    space : Space
        The absorbing regions.
    order : int, default ORDER
        Number of Gauss-Legendre nodes per panel.

    Returns
    -------
    float
        Fluence rate per emission density Q [m].

    Notes
    -----
    The source must lie in one region and contain no other. At order 10 the relative error is about
    1e-10 or less (tested against 16). Kobayashi, Sugimura and Nagaya 2001.

    Examples
    --------
    >>> from transport.theory.ray_integrals import Region, Space, uncollided_fluence
    >>> space = Space([Region((0.0, 0.0, 0.0), (2.0, 2.0, 2.0), 0.1)])
    >>> print(f"{uncollided_fluence((1.5, 1.5, 1.5), (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), space):.4g}")
    0.02322
    """
    point, low, high = (np.asarray(each, float) for each in (point, low, high))
    inside = bool(((point >= low) & (point <= high)).all())
    total = 0.0
    for axis in range(3):
        for end in (low, high):
            height = (point[axis] - end[axis]) * (1 if end is high else -1)  # positive outwards
            if (height < 0) if inside else (height > 0):
                total += _Face(axis, float(end[axis]), point, low, high, space).integral(order, inside)
    return total / (4 * math.pi)


def mean_uncollided_fluence(
    cell: tuple[Sequence[float], Sequence[float]],
    low: Sequence[float],
    high: Sequence[float],
    space: Space,
    across: int = 3,
    order: int = ORDER,
) -> float:
    """Uncollided fluence rate averaged over a box-shaped cell.

    Parameters
    ----------
    cell : tuple of 2 sequences
        Lower and upper corner of the cell [m].
    low : sequence of float
        Lower corner of the source, shape (3,) [m].
    high : sequence of float
        Upper corner of the source, shape (3,) [m].
    space : Space
        The absorbing regions.
    across : int, default 3
        Number of Gauss points per axis of the cell.
    order : int, default ORDER
        Number of Gauss-Legendre nodes per panel.

    Returns
    -------
    float
        Mean fluence rate per emission density Q [m].

    Notes
    -----
    Accurate if the cell is small compared with the scale of variation; increase `across` to check.

    Examples
    --------
    >>> from transport.theory.ray_integrals import Region, Space, mean_uncollided_fluence
    >>> space = Space([Region((0.0, 0.0, 0.0), (2.0, 2.0, 2.0), 0.1)])
    >>> cell, source = ((1.4, 1.4, 1.4), (1.6, 1.6, 1.6)), ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    >>> print(f"{mean_uncollided_fluence(cell, *source, space, across=1):.4g}")
    0.02322
    """
    nodes, weights = _gauss(across)
    first, last = np.asarray(cell[0], float), np.asarray(cell[1], float)
    total = 0.0
    for index in np.ndindex(across, across, across):
        place = first + (last - first) * nodes[list(index)]
        total += math.prod(weights[list(index)]) * uncollided_fluence(place, low, high, space, order)
    return total


class _Face:
    """A face of the source, normal to `axis` at `level`, seen from a point; u, v are the other axes."""

    def __init__(self, axis, level, point, low, high, space) -> None:
        self.axis, self.level, self.point, self.low, self.high, self.space = (
            axis,
            level,
            point,
            low,
            high,
            space,
        )
        self.uv = [(axis + 1) % 3, (axis + 2) % 3]
        self.height = abs(level - point[axis])
        self.extinction = space.extinction_in(low, high)

    def integral(self, order: int, inside: bool) -> float:
        """∫ dω exp(-τ) (1 - exp(-σ l))/σ over the face."""
        segments = self._segments()
        u_breaks = self._graded(0, self._vertices(segments))
        u, u_weights = _panels(u_breaks[None, :], order)
        u, u_weights = u[0], u_weights[0]
        graded = self._graded(1, [])
        step = max(1, RAYS_PER_CHUNK // (order * (len(graded) + len(segments))))
        return math.fsum(
            self._strip(u[k : k + step], u_weights[k : k + step], segments, graded, order, inside)
            for k in range(0, len(u), step)
        )

    def _strip(self, u, u_weights, segments, graded, order, inside) -> float:
        """Contribution of some values of u: all v, between the segments that cross there."""
        breaks = np.broadcast_to(graded, (len(u), len(graded)))
        if len(segments):
            a, b = segments[:, 0], segments[:, 1]
            with np.errstate(divide="ignore", invalid="ignore"):
                share = (u[:, None] - a[:, 0]) / (b - a)[:, 0]
                crossing = np.where((share >= 0) & (share <= 1), a[:, 1] + share * (b - a)[:, 1], graded[0])
            breaks = np.sort(np.concatenate([breaks, crossing.clip(graded[0], graded[-1])], axis=1), axis=1)
        v, weights = _panels(breaks, order)
        places = np.empty((*v.shape, 3))
        places[..., self.axis] = self.level
        places[..., self.uv[0]] = u[:, None]
        places[..., self.uv[1]] = v
        return float(((self._received(places, inside) * weights).sum(axis=1) * u_weights).sum())

    def _received(self, places: np.ndarray, inside: bool) -> np.ndarray:
        """exp(-τ) (1 - exp(-σ l))/σ · h/r³ at points of the face."""
        offset = places - self.point
        distance = np.sqrt((offset * offset).sum(axis=-1))
        if inside:
            chord, passed = distance, 1.0
        else:
            with np.errstate(divide="ignore"):
                leaves = np.where(offset > 0, self.high - places, self.low - places) / np.where(
                    offset == 0, 1e-300, offset
                )
            chord = np.where(offset == 0, np.inf, leaves).min(axis=-1) * distance
            passed = np.exp(-self.space.optical_depths(self.point, places))
        gain = -np.expm1(-self.extinction * chord) / self.extinction if self.extinction else chord
        return passed * gain * self.height / distance**3

    def _graded(self, which: int, more: Sequence[float]) -> np.ndarray:
        """Breaks along u or v: the face's ends, the given ones, and geometric steps from P's projection."""
        low, high = (corner[self.uv[which]] for corner in (self.low, self.high))
        foot, size = self.point[self.uv[which]], high - low
        steps = self.height * 2.0 ** np.arange(
            FINEST_EXPONENT, max(0, math.ceil(math.log2(2 * size / self.height))) + 1
        )
        breaks = np.concatenate([[low, high, foot], foot + steps, foot - steps, more])
        breaks = np.unique(breaks[(breaks >= low) & (breaks <= high)])
        return breaks[np.append(True, np.diff(breaks) > 1e-13 * size)]

    def _segments(self) -> np.ndarray:
        """Projections onto the face of all box edges before it and the source's edges behind, (n, 2, 2)."""
        found = [
            _projected_edge(edge, self, 0.0, 1.0)
            for region in self.space.regions
            for edge in _edges(*region[:2])
        ]
        found += [_projected_edge(edge, self, 1.0, math.inf) for edge in _edges(self.low, self.high)]
        rounded = {
            tuple(np.round(s / (self.high - self.low)[self.uv], 12).ravel()): s
            for s in found
            if s is not None
        }
        return np.array(list(rounded.values())).reshape(-1, 2, 2)

    def _vertices(self, segments: np.ndarray) -> np.ndarray:
        """u of the ends and crossings of segments."""
        if not len(segments):
            return np.zeros(0)
        a, d = segments[:, 0], segments[:, 1] - segments[:, 0]
        cross = d[:, None, 0] * d[None, :, 1] - d[:, None, 1] * d[None, :, 0]
        gap = a[None] - a[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (gap[..., 0] * d[None, :, 1] - gap[..., 1] * d[None, :, 0]) / cross
            t = (gap[..., 0] * d[:, None, 1] - gap[..., 1] * d[:, None, 0]) / cross
        meets = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
        crossings = (a[:, None, 0] + np.where(meets, s, 0) * d[:, None, 0])[meets]
        return np.concatenate([segments[..., 0].ravel(), crossings])


def _projected_edge(edge: np.ndarray, face: _Face, nearest: float, furthest: float) -> np.ndarray | None:
    """Projection of an edge (2, 3) from P onto the face, clipped to it, (2, 2); None if it misses it.

    nearest, furthest: range of the edge's distance, over that of the face's plane, in which it counts.
    """
    depth = (edge[:, face.axis] - face.point[face.axis]) / (face.level - face.point[face.axis])
    least, most = max(nearest, depth.min()), min(furthest, depth.max())
    if least > most or most <= 0:
        return None
    along = edge[:, face.uv] - face.point[face.uv]
    if depth[0] == depth[1]:
        ends = along / depth[0]
    else:  # an edge parallel to the axis projects radially from P's foot
        ends = along * np.array([[1 / most], [min(1 / least, UNBOUNDED) if least > 0 else UNBOUNDED]])
    ends = ends + face.point[face.uv]
    return _clip_segment(ends, face.low[face.uv], face.high[face.uv])


def _clip_segment(ends: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray | None:
    """Part of a segment (2, 2) within a rectangle (Liang and Barsky 1984); None if it has no length there."""
    offset, first, last = ends[1] - ends[0], 0.0, 1.0
    for k in range(2):
        if offset[k] == 0:
            if not low[k] < ends[0, k] < high[k]:
                return None
        else:
            s, t = sorted(((low[k] - ends[0, k]) / offset[k], (high[k] - ends[0, k]) / offset[k]))
            first, last = max(first, s), min(last, t)
    return np.array([ends[0] + first * offset, ends[0] + last * offset]) if first < last else None


def _edges(low: Sequence[float], high: Sequence[float]) -> list[np.ndarray]:
    """The twelve edges of a box, (2, 3) each."""
    found = []
    for axis in range(3):
        for index in np.ndindex(2, 2):
            ends = np.empty((2, 3))
            ends[:, axis] = low[axis], high[axis]
            for k, which in zip(((axis + 1) % 3, (axis + 2) % 3), index, strict=True):
                ends[:, k] = (low, high)[which][k]
            found.append(ends)
    return found


def _share_in_box(low: np.ndarray, high: np.ndarray, inverse: np.ndarray) -> np.ndarray:
    """Share of the paths from the origin that lies in a box, (...,).

    inverse: 1 over the path vectors, (..., 3).
    """
    near, far = low * inverse, high * inverse
    first = np.minimum(near, far).max(axis=-1)
    last = np.maximum(near, far).min(axis=-1)
    return np.maximum(np.minimum(last, 1.0) - np.maximum(first, 0.0), 0.0)


def _panels(breaks: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights between the breaks (n, panels + 1), (n, panels * order) each."""
    nodes, weights = _gauss(order)
    widths = np.diff(breaks, axis=1)[..., None]
    places = breaks[:, :-1, None] + widths * nodes
    return places.reshape(len(breaks), -1), (widths * weights).reshape(len(breaks), -1)


@lru_cache(maxsize=16)
def _gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes and weights on [0, 1]."""
    nodes, weights = legendre_nodes(count)
    return (nodes + 1) / 2, weights / 2
