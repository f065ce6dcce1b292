"""The part of space that a picture of a scene shows: what holds its shapes, and which of its sources lie beyond."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from transport.analysis.tracks import Tracks
from transport.geometry.shape import Shape
from transport.geometry.solid import Box
from transport.scene.scene import Scene
from transport.viz.facets import Bounds

FAR = 25.0  # of sources against all else: so many times the size of it away, they are left out of the picture
ENDLESS = 300.0  # a body so many times larger than all that it holds is cut like one without end
AROUND = 0.3  # of the frame's diagonal: so far beyond it tracks are drawn
BROAD = 0.8  # of the longest side of the frame: how wide at least a plane without end is drawn
PATH = 4.0  # mean free paths that a scene of a point alone shows


@dataclass(frozen=True)
class Frame:
    """low, high: corners [m] of what is shown;  distant: places [m] of sources that lie beyond it, by their number."""

    low: np.ndarray
    high: np.ndarray
    distant: dict[int, np.ndarray]

    @property
    def middle(self) -> np.ndarray:
        return (self.low + self.high) / 2

    @property
    def size(self) -> float:
        """Its diagonal [m]."""
        return float(np.linalg.norm(self.high - self.low))

    @property
    def bounds(self) -> Bounds:
        """Where shapes without end are cut [m]."""
        return self.low, self.high

    def grown(self, share: float = AROUND) -> Bounds:
        """Corners [m] that lie this share of the diagonal farther out."""
        return self.low - share * self.size, self.high + share * self.size

    def cut(self, shape: Shape) -> Shape | None:
        """The shape, or what of an over-large box lies in the frame; None where nothing does."""
        low, high = (np.array(corner) for corner in shape.bounds)
        is_larger = not shape.is_infinite and (high - low).max() > ENDLESS * (self.high - self.low).max()
        if not is_larger:
            return shape
        low, high = np.maximum(low, self.low), np.minimum(high, self.high)
        if not isinstance(shape, Box) or not (low < high).all():
            return None
        return Box(center=(low + high) / 2, size=high - low)


def frame_of(scene: Scene, tracks: Tracks | None = None, whole: bool = False) -> Frame:
    """What a picture of the scene shows.

    whole: with all sources, however far; else those that lie so far away that surfaces, or they themselves, would be dots
    are left out.
    """
    fixed = [surface.shape for surface in scene.surfaces] + [_of_detector(scene, d) for d in scene.detectors]
    sources = [scene.shape_of(source) for source in scene.sources]
    near = _without_bodies([_corners(shape) for shape in fixed if shape is not None])
    lit = [_corners(shape) for shape in sources]
    every = _union(near + lit)
    distant = {}
    if near and not whole and every is not None:
        small = _union(near)
        are_dots = all(_diagonal(each) * FAR < _diagonal(every) for each in lit)
        if 0 < _diagonal(small) * FAR < _diagonal(every) and (scene.surfaces or are_dots):
            distant = {k: np.mean(each, axis=0) for k, each in enumerate(lit) if not _holds(small, each)}
            every = _union(near + [each for k, each in enumerate(lit) if k not in distant])
    low, high = _with_size(scene, None if distant else tracks, every)
    return Frame(*_widened(fixed, low, high), distant)


def _of_detector(scene: Scene, detector: object) -> Shape | None:
    from transport.geometry.shape import Point

    if hasattr(detector, "position"):
        return Point(position=detector.position)
    return scene.shape_of(detector) if hasattr(detector, "shape") else None


def _corners(shape: Shape) -> np.ndarray:
    """Lower and upper corner (2, 3) [m]; of what has no end only the finite ones, others nan."""
    corners = np.array(shape.bounds, dtype=float)
    return np.where(np.isfinite(corners), corners, np.nan)


def _union(corners: list[np.ndarray]) -> np.ndarray | None:
    known = [each for each in corners if np.isfinite(each).any()]
    if not known:
        return None
    every = np.concatenate(known)
    with np.errstate(all="ignore"):
        return np.array([_least(every, np.fmin), _least(every, np.fmax)])


def _least(corners: np.ndarray, pick: np.ufunc) -> np.ndarray:
    return pick.reduce(corners, axis=0)


def _diagonal(corners: np.ndarray) -> float:
    return float(np.linalg.norm(np.nan_to_num(corners[1] - corners[0])))


def _holds(outer: np.ndarray, inner: np.ndarray) -> bool:
    margin = 0.5 * _diagonal(outer)
    return bool((inner[0] >= outer[0] - margin).all() and (inner[1] <= outer[1] + margin).all())


def _without_bodies(corners: list[np.ndarray]) -> list[np.ndarray]:
    """Without those that are ENDLESS times larger than the rest, which they hold."""
    left = sorted(corners, key=_diagonal)
    while len(left) > 1:
        rest = _union(left[:-1])
        if rest is None or not 0 < ENDLESS * _diagonal(rest) < _diagonal(left[-1]):
            break
        left.pop()
    return left


def _with_size(scene: Scene, tracks: Tracks | None, corners: np.ndarray | None) -> Bounds:
    """Corners of a box that has some size along every axis."""
    corners = np.zeros((2, 3)) if corners is None else corners
    corners = np.where(np.isfinite(corners), corners, np.nan)
    known = np.nan_to_num(np.nanmean(np.where(np.isnan(corners), 0.0, corners), axis=0))
    low, high = (np.where(np.isnan(corner), known, corner) for corner in corners)
    size = np.linalg.norm(high - low)
    if size == 0:
        reach = _reach_of(scene, tracks, known)
        return low - reach, high + reach
    if tracks is not None and size < 0.1 * (wide := _reach_of(scene, tracks, known)) < np.inf:
        low, high = np.minimum(low, known - wide / 4), np.maximum(high, known + wide / 4)
    return low, high


def _widened(fixed: list[Shape | None], low: np.ndarray, high: np.ndarray) -> Bounds:
    """Wide enough along the ways in which something has no end, for it to be seen as such."""
    shapes = [np.array(shape.bounds) for shape in fixed if shape is not None and shape.is_infinite]
    endless = np.zeros(3, dtype=bool)
    for bounds in shapes:
        endless |= np.isinf(bounds).all(axis=0)
    if not endless.any() or endless.all():
        return low, high
    least = BROAD * (high - low).max()
    more = np.where(endless, np.maximum(least - (high - low), 0.0) / 2, 0.0)
    return low - more, high + more


def _reach_of(scene: Scene, tracks: Tracks | None, middle: np.ndarray) -> float:
    """How far most of what happens is from a place [m]: by tracks, else by mean free paths, else 1 m."""
    if tracks is not None and np.isfinite(tracks.lengths).any():
        is_met = np.isfinite(tracks.lengths)
        ends = tracks.starts[is_met] + tracks.lengths[is_met, None] * tracks.directions[is_met]
        reach = np.quantile(np.linalg.norm(ends - middle, axis=1), 0.9)
        if reach > 0:
            return float(reach)
    media = [scene.medium, *(side for s in scene.surfaces for side in (s.inside, s.outside))]
    extinctions = [float(np.max(medium.extinction)) for medium in media if medium is not None]
    largest = max(extinctions, default=0.0)
    return PATH / largest if largest > 0 else 1.0
