"""What a picture of a scene is made of: the part of space it shows, and surfaces, media, sources and detectors as parts.

Picture, page, movie and ParaView files all draw this list. A wall of a closed room shows only the side that the room sees,
and a wall with a detector only the detector's side, so that the wall between the camera and the inside is left out.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from transport.analysis.tracks import Tracks
from transport.geometry.flat import Plane
from transport.geometry.shape import Cloud, Point, Shape
from transport.geometry.solid import Box
from transport.results.result import Result
from transport.scene.detectors import Detector
from transport.scene.media import Grid
from transport.scene.scene import Scene
from transport.statistics.axes import POSITION, SPEED, TIME, axis_unit
from transport.statistics.chunked import over_batches
from transport.statistics.estimates import Estimate, EstimateArray
from transport.validation import SceneError
from transport.viz.facets import (
    CLOUD_SIGMAS,
    Bounds,
    Facets,
    as_polydata,
    cell_cuts,
    facets_of,
    half_box,
    outline,
)
from transport.viz.wording import raised

if TYPE_CHECKING:
    import pyvista

FRONT, BACK, NOWHERE = "front", "back", "nowhere"
SYMBOLS = {"irradiance": "E", "exitance": "M", "fluence_rate": "φ"}  # of the quantities that are painted
MIN_HITS = 4  # of a cell that has a colour; below, it is grey
SPANS = (TIME, SPEED)  # axes that a detector may cover in part
INNER_SHARE = 0.97  # of a wall's facets that must have the whole scene on one side
FLATNESS = 1e-6  # of the scene's size: distance up to which a point is on a plane
SAMPLED_FACETS = 300  # of a wall, to find its inner side
DOT = 25.0  # ratio of all to a source far away, above which it would be a dot
ENDLESS = 300.0  # ratio to the rest above which a body is cut, and a distant source left out
MARGIN = 0.3  # of the frame's diagonal: how far outside it tracks are drawn
BROAD = 0.8  # of the frame's longest side: least width of an infinite plane
MEAN_PATHS = 4.0  # size of the picture of a point alone in a medium


# ---- What was read.


@dataclass(frozen=True)
class Paint:
    """What a detector read of one quantity, by bin of place (flat, u before v) or cell.

    `words` is the value with its error if there is one bin; `only` names a limit such as "events=0", or None.
    """

    quantity: str
    unit: str
    words: str | None
    only: str | None
    values: np.ndarray
    errors: np.ndarray
    hits: np.ndarray

    @property
    def is_known(self) -> np.ndarray:
        """Whether each bin has enough hits to be shown."""
        return self.hits >= MIN_HITS

    def on(self, bins: np.ndarray) -> dict[str, np.ndarray]:
        """Cell arrays for facets of these bins; nan and no hits in no bin (-1)."""
        columns = {self.quantity: self.values, f"{self.quantity} error": self.errors}
        found = {name: np.append(column, np.nan)[bins] for name, column in columns.items()}
        return found | {"hits": np.append(self.hits, 0)[bins]}


def paint_of(reading: object, quantity: str = "irradiance", duration: float | None = None) -> Paint:
    """Return what a detector read: means over bins of time, sums over bins of speed.

    `duration` of the scene [s]: bins of time that cover it are no limit.
    """
    estimate = getattr(reading, quantity)
    by_bin = by_place(estimate)
    values, errors = (np.ravel(getattr(by_bin, name)).astype(float) for name in ("value", "error"))
    hits = np.broadcast_to(np.ravel(_hits(reading, quantity)), values.shape)
    words = str(by_bin) if isinstance(by_bin, Estimate) else None
    only = _limits(reading.detector, estimate, duration)
    return Paint(quantity, str(by_bin.unit), words, only, values, errors, hits)


def by_place(estimate: Estimate | EstimateArray) -> Estimate | EstimateArray:
    """Average an estimate over time, weighted by the widths of the bins, and sum it over speed."""
    if "time" in estimate.coords:
        widths = np.diff(estimate.coords["time"])
        later = len(estimate.dims) - 1 - estimate.dims.index("time")
        estimate = (estimate * (widths / widths.sum()).reshape(-1, *(1,) * later)).sum("time")
    return estimate.sum("speed") if "speed" in estimate.coords else estimate


def _limits(detector: object, estimate: Estimate | EstimateArray, duration: float | None) -> str | None:
    """What a detector counts, if it is not everything."""
    limits = {name: getattr(detector, name, None) for name in ("via", "events")}
    found = [f"{name}={limit!r}" for name, limit in limits.items() if limit not in (None, (0, math.inf))]
    for name, edges in estimate.coords.items():
        is_whole = name == "time" and edges[0] == 0 and edges[-1] == duration
        if name in SPANS and not is_whole:
            unit = raised(axis_unit(name, estimate.axis_units))
            found.append(f"{name} {edges[0]:.3g} to {edges[-1]:.3g} {unit}")
    return ", ".join(found) or None


def _hits(reading: object, quantity: str) -> np.ndarray:
    """Number of scores in each bin of place."""
    score = {"irradiance": "weight in", "exitance": "weight out"}.get(quantity)
    if score in reading.scores:
        groups = [axis.group for axis in reading.axes_of(score, (POSITION,))]
        others = tuple(k for k, group in enumerate(groups) if group != POSITION)
        return over_batches(reading.counts_of(score, (POSITION,))).sum(axis=others)
    counts = reading.counts
    if score is None or not isinstance(counts, EstimateArray):
        return np.array(counts.value)
    return counts.value.sum(axis=tuple(k for k, name in enumerate(counts.dims) if name not in ("u", "v")))


def _paints(scene: Scene, result: Result | None, quantity: str | None) -> dict[str, Paint]:
    """What each detector read, by its name."""
    if quantity is not None and quantity not in SYMBOLS:
        raise ValueError(f"scene: quantity must be one of {', '.join(SYMBOLS)}, got {quantity!r}")
    if result is None:
        return {}

    def read(detectors: Iterable[object], name: str) -> dict[str, Paint]:
        found = {}
        for detector in detectors:
            try:
                found[detector.name] = paint_of(result[detector.name], name, scene.duration)
            except SceneError:  # unknown on an infinite shape, or backwards
                continue
        return found

    walls: dict[str, Paint] = {}
    for name in ("irradiance", "exitance"):
        if quantity in (None, name) and not any((paint.values > 0).any() for paint in walls.values()):
            walls = read(scene.meters, name)
    return walls | (read(scene.volumes, "fluence_rate") if quantity in (None, "fluence_rate") else {})


# ---- The part of space that is shown.


@dataclass(frozen=True)
class Frame:
    """The box between two corners [m] that a picture shows; `distant`: places [m] of sources outside, by their number."""

    low: np.ndarray
    high: np.ndarray
    distant: dict[int, np.ndarray]

    @property
    def middle(self) -> np.ndarray:
        """Its centre [m]."""
        return (self.low + self.high) / 2

    @property
    def size(self) -> float:
        """Its diagonal [m]."""
        return float(np.linalg.norm(self.high - self.low))

    @property
    def bounds(self) -> Bounds:
        """Where infinite shapes are cut [m]."""
        return self.low, self.high

    @property
    def margins(self) -> Bounds:
        """Where tracks are cut [m]."""
        return self.low - MARGIN * self.size, self.high + MARGIN * self.size

    def cut(self, shape: Shape) -> Shape | None:
        """Return the shape, or of a far too large box what lies in the frame; None for other far too large shapes."""
        low, high = (np.array(corner) for corner in shape.bounds)
        if shape.is_infinite or (high - low).max() <= ENDLESS * (self.high - self.low).max():
            return shape
        low, high = np.maximum(low, self.low), np.minimum(high, self.high)
        if not isinstance(shape, Box) or not (low < high).all():
            return None
        return Box(center=(low + high) / 2, size=high - low)


def frame_of(scene: Scene, tracks: Tracks | None = None, whole: bool = False) -> Frame:
    """Return what a picture of the scene shows.

    Sources so far away that the rest, or they themselves, would be dots are left out unless `whole`.
    """
    shapes = [surface.shape for surface in scene.surfaces]
    shapes += [shape for each in scene.detectors if (shape := shape_of(scene, each)) is not None]
    lit = [_corners(scene.shape_of(source)) for source in scene.sources]
    near = _without_bodies([_corners(shape) for shape in shapes], lit)
    every, distant = _union(near + lit), {}
    if near and not whole and every is not None:
        small = _union(near)
        are_dots = all(_diagonal(each) * DOT < _diagonal(every) for each in lit)
        if 0 < _diagonal(small) * ENDLESS < _diagonal(every) and (scene.surfaces or are_dots):
            margin = 0.5 * _diagonal(small)
            is_out = [((each[0] < small[0] - margin) | (each[1] > small[1] + margin)).any() for each in lit]
            distant = {k: lit[k].mean(axis=0) for k in np.flatnonzero(is_out)}
            every = _union(near + [each for k, each in enumerate(lit) if k not in distant])
    low, high = _with_size(scene, None if distant else tracks, every)
    # Make infinite shapes broad enough to look infinite.
    endless = np.zeros(3, dtype=bool)
    for shape in shapes:
        endless |= np.isinf(np.array(shape.bounds)).all(axis=0)
    if endless.any():
        more = np.where(endless, np.maximum(BROAD * (high - low).max() - (high - low), 0.0) / 2, 0.0)
        low, high = low - more, high + more
    return Frame(low, high, distant)


def shape_of(scene: Scene, detector: object) -> Shape | None:
    """The shape of a detector, a point for a camera; None for what covers all of space, as a snapshot does."""
    if hasattr(detector, "position"):
        return Point(position=detector.position)
    return scene.shape_of(detector) if hasattr(detector, "shape") else getattr(detector, "within", None)


def _corners(shape: Shape) -> np.ndarray:
    """Lower and upper corner (2, 3) [m], nan where infinite; of a tilted plane its centre, of a cloud most of it."""
    corners = np.array(shape.bounds, dtype=float)
    if isinstance(shape, Cloud):
        reach = CLOUD_SIGMAS * np.array(shape.sigma)
        corners = np.array([shape.center - reach, shape.center + reach])
    if not np.isfinite(corners).any():
        corners = np.tile(shape.middle, (2, 1))
    return np.where(np.isfinite(corners), corners, np.nan)


def _union(corners: list[np.ndarray]) -> np.ndarray | None:
    known = [each for each in corners if np.isfinite(each).any()]
    if not known:
        return None
    every = np.concatenate(known)
    return np.array([np.fmin.reduce(every), np.fmax.reduce(every)])


def _diagonal(corners: np.ndarray) -> float:
    return float(np.linalg.norm(np.nan_to_num(corners[1] - corners[0])))


def _without_bodies(corners: list[np.ndarray], lit: list[np.ndarray]) -> list[np.ndarray]:
    """Leave out those that are ENDLESS times larger than all the rest within or near them, with the sources there.

    A planet is left out beside a detector on its ground, a room with a lamp and a small detector is not.
    """
    left = sorted(corners, key=_diagonal)
    while len(left) > 1:
        (low, high), middles = left[-1], [each.mean(axis=0) for each in lit]
        within = [
            each
            for each, middle in zip(lit, middles, strict=True)
            if not ((middle < low) | (middle > high)).any()
        ]
        rest = _union(left[:-1] + within)
        if rest is None or not 0 < ENDLESS * _diagonal(rest) < _diagonal(left[-1]):
            break
        left.pop()
    return left


def _with_size(scene: Scene, tracks: Tracks | None, corners: np.ndarray | None) -> Bounds:
    """Corners of a box that is not a point."""
    corners = np.full((2, 3), np.nan) if corners is None else corners
    known = np.nan_to_num(corners).mean(axis=0)
    low, high = (np.where(np.isnan(corner), known, corner) for corner in corners)
    size = np.linalg.norm(high - low)
    reach = _reach(scene, tracks, known)
    if size == 0:
        return low - reach, high + reach
    if tracks is not None and size < 0.1 * reach < np.inf:
        low, high = np.minimum(low, known - reach / 4), np.maximum(high, known + reach / 4)
    return low, high


def _reach(scene: Scene, tracks: Tracks | None, middle: np.ndarray) -> float:
    """Distance [m] within which most happens: by tracks, else by mean free paths, else 1 m."""
    if tracks is not None and np.isfinite(tracks.lengths).any():
        is_met = np.isfinite(tracks.lengths)
        ends = tracks.starts[is_met] + tracks.lengths[is_met, None] * tracks.directions[is_met]
        if (reach := np.quantile(np.linalg.norm(ends - middle, axis=1), 0.9)) > 0:
            return float(reach)
    media = [scene.medium, *(side for s in scene.surfaces for side in (s.inside, s.outside))]
    largest = max((float(np.max(medium.extinction)) for medium in media if medium is not None), default=0.0)
    return MEAN_PATHS / largest if largest > 0 else 1.0


# ---- The parts.


@dataclass(frozen=True)
class Part:
    """One thing in a picture.

    `kind`: "surface", "medium", "source", "detector" or "cells" of a volume; `what`: its object; `side`: of its shape that
    emits or has the detector; `seen_from`: the one side from which it is shown, None for both, NOWHERE for neither;
    `is_other_side`: the bare side of a painted wall; `is_on_surface`: a detector or source on a surface that is drawn and
    painted; `number`: the value in words of a detector without bins of place.
    """

    kind: str
    what: object
    shape: Shape
    name: str
    facets: Facets
    frame: Frame
    paint: Paint | None = None
    side: str | None = None
    seen_from: str | None = None
    is_other_side: bool = False
    is_on_surface: bool = False
    number: str | None = None

    @property
    def is_clear(self) -> bool:
        """Whether light passes through it."""
        return any(each.is_clear for each in self._elements)

    @property
    def is_mirror(self) -> bool:
        """Whether it reflects specularly."""
        return any(each.row().interaction == "mirror" for each in self._elements)

    @property
    def is_bare(self) -> bool:
        """Whether it only bounds a medium and does not act on particles."""
        return not getattr(getattr(self.what, "material", None), "acts", True)

    @property
    def has_bins(self) -> bool:
        """Whether it is painted by place, not in one colour."""
        return self.paint is not None and self.paint.words is None

    @property
    def opacity(self) -> float:
        """Of its paint: below 1 for transparent things of one colour, whose value is written as well."""
        if self.has_bins:
            return 1.0
        return 0.35 if self.kind == "detector" else 0.6 if self.is_clear else 1.0

    @property
    def _elements(self) -> tuple:
        return getattr(getattr(self.what, "material", None), "elements", ())

    def drawn(self) -> pyvista.PolyData:
        """Its facets [m] with what was read on each as cell arrays."""
        found = as_polydata(self.facets)
        if self.paint:
            for name, column in self.paint.on(self.facets.bins).items():
                found.cell_data[name] = column
            found.field_data["unit"] = [self.paint.unit]
        return found

    @cached_property
    def outline(self) -> pyvista.PolyData:
        """Its rims and edges [m]."""
        return outline(self.shape, self.frame.bounds)

    def grid(self) -> pyvista.RectilinearGrid:
        """All cells of a volume detector in a box with what they read [m]."""
        import pyvista

        edges = self.what.edges(self.shape)
        grid = pyvista.RectilinearGrid(*(edges[name] for name in "xyz"))
        counts = [len(each) - 1 for each in edges.values()]
        for name, column in self.paint.on(np.arange(len(self.paint.values))).items():
            grid.cell_data[name] = column.reshape(counts).ravel(order="F")
        grid.field_data["unit"] = [self.paint.unit]
        return grid


def parts_of(
    scene: Scene, frame: Frame, result: Result | None = None, quantity: str | None = None
) -> list[Part]:
    """Return all parts of a scene in a frame, painted with what detectors of the result read.

    `quantity` is "irradiance", "exitance" or "fluence_rate"; None: irradiance, or exitance if nothing arrives
    anywhere, and the fluence rate of volumes.
    """
    read = _paints(scene, result, quantity)
    parts = [
        *_surfaces(scene, frame, read),
        *_media(scene, frame),
        *_detectors(scene, frame, read),
        *_cells(scene, frame, read),
        *_sources(scene, frame, read),
    ]
    return [replace(part, seen_from=_seen_from(part, parts)) for part in parts]


def large_surfaces(scene: Scene, frame: Frame) -> list[str]:
    """Names of surfaces that are too large for the frame to be drawn."""
    return [name for name, surface in _named_surfaces(scene) if frame.cut(surface.shape) is None]


def is_hazed(part: Part, parts: list[Part]) -> bool:
    """Whether a medium is drawn as a haze: not over paint on its boundary, nor voxels over cuts."""
    painted = [each for each in parts if each.paint is not None]
    if part.kind != "medium" or any(each.shape == part.shape for each in painted):
        return False
    return not (isinstance(part.what, Grid) and any(each.kind == "cells" for each in painted))


def block_names(parts: list[Part]) -> list[str]:
    """Return a unique name for each part."""
    names: list[str] = []
    for part in parts:
        title = f"{part.kind} {part.name}" + (f" {part.side}" if part.paint and part.side else "")
        numbered = itertools.chain([title], (f"{title} {k}" for k in itertools.count(2)))
        names.append(next(name for name in numbered if name not in names))
    return names


def _named_surfaces(scene: Scene) -> Iterator[tuple[str, object]]:
    for number, surface in enumerate(scene.surfaces):
        yield surface.name or f"surfaces[{number}]", surface


def _surfaces(scene: Scene, frame: Frame, read: dict[str, Paint]) -> Iterator[Part]:
    for name, surface in _named_surfaces(scene):
        shape = frame.cut(surface.shape)
        if shape is None:
            continue
        plain = Part("surface", surface, shape, name, facets_of(shape, None, frame.bounds), frame)
        best = _best(
            each for each in scene.meters if scene.shape_of(each) == surface.shape and each.name in read
        )
        if not best or shape is not surface.shape:
            yield plain
            continue
        for side, detector in best.items():
            facets = facets_of(shape, detector.positions)
            yield replace(plain, facets=facets, paint=read[detector.name], side=side)
        if len(best) == 1 and not plain.is_clear:
            yield replace(plain, side=BACK if FRONT in best else FRONT, is_other_side=True)


def _best(detectors: Iterable[Detector]) -> dict[str, Detector]:
    """The most informative detector on each side: by place, then without limits, then the first."""

    def rank(detector: Detector) -> tuple[bool, bool]:
        return detector.positions is None, detector.via is not None or detector.events is not None

    found: dict[str, Detector] = {}
    for detector in sorted(detectors, key=rank):
        found.setdefault(_side_of(detector), detector)
    return found


def _side_of(detector: object) -> str | None:
    if not isinstance(detector, Detector):
        return None
    return BACK if detector.is_back else FRONT


def _media(scene: Scene, frame: Frame) -> Iterator[Part]:
    """Media in closed shapes and half-spaces that scatter, absorb or emit."""
    for name, surface in _named_surfaces(scene):
        medium, shape = surface.inside, frame.cut(surface.shape)
        is_seen = medium is not None and (
            isinstance(medium, Grid) or medium.extinction > 0 or medium.emission > 0
        )
        if shape is None or not is_seen:
            continue
        if shape.is_closed or isinstance(shape, Plane):
            facets = facets_of if shape.is_closed else half_box
            drawn = facets(shape, bounds=frame.bounds)
            yield Part("medium", medium, shape, f"inside {name}", drawn, frame)


def _detectors(scene: Scene, frame: Frame, read: dict[str, Paint]) -> Iterator[Part]:
    """One part for all detectors at one place; those on surfaces are outlines only."""
    placed: dict[Shape, list[object]] = {}
    for detector in scene.detectors:
        if (shape := shape_of(scene, detector)) is not None:
            placed.setdefault(shape, []).append(detector)
    solid = {surface.shape for surface in scene.surfaces}
    for shape, several in placed.items():
        first, cut = several[0], frame.cut(shape)
        if cut is None:
            continue
        name = first.name + (f" + {len(several) - 1}" if len(several) > 1 else "")
        paint = read.get(first.name) if len(several) == 1 else None
        plain = Part(
            "detector",
            first,
            cut,
            name,
            facets_of(cut, None, frame.bounds),
            frame,
            side=_side_of(first),
            is_on_surface=shape in solid,
            number=f"{SYMBOLS[paint.quantity]} = {paint.words}" if paint and paint.words else None,
        )
        best = _best(each for each in several if isinstance(each, Detector) and each.name in read)
        if shape in solid or not best or cut is not shape:
            yield plain
            continue
        for side, detector in best.items():
            seen_from = side if len(best) == 2 or shape.is_closed else None
            facets = facets_of(shape, detector.positions)
            yield replace(plain, facets=facets, paint=read[detector.name], side=side, seen_from=seen_from)


def _cells(scene: Scene, frame: Frame, read: dict[str, Paint]) -> Iterator[Part]:
    """Cuts through volume detectors with cells: they show each cell in the very colour of the bar."""
    for volume in scene.volumes:
        paint, shape = read.get(volume.name), scene.shape_of(volume)
        if paint is not None and paint.words is None and frame.cut(shape) is shape:
            surely = np.where(paint.is_known, paint.values - 2 * np.nan_to_num(paint.errors), 0.0)
            facets = cell_cuts(shape, volume.edges(shape), int(np.argmax(surely)))
            yield Part("cells", volume, shape, volume.name, facets, frame, paint=paint)


def _sources(scene: Scene, frame: Frame, read: dict[str, Paint]) -> Iterator[Part]:
    painted = {scene.shape_of(meter) for meter in scene.meters if meter.name in read}
    painted &= {surface.shape for surface in scene.surfaces}
    for number, source in enumerate(scene.sources):
        whole = scene.shape_of(source)
        shape = None if number in frame.distant else frame.cut(whole)
        if shape is None:
            continue
        name = source.shape if isinstance(source.shape, str) else f"source {number}"
        side, facets = BACK if source.is_back else FRONT, facets_of(shape, None, frame.bounds)
        yield Part("source", source, shape, name, facets, frame, side=side, is_on_surface=whole in painted)


# ---- The side of a part that is shown.


def _seen_from(part: Part, parts: list[Part]) -> str | None:
    """The side from which a wall is shown: the painted one, else the one on which all the rest of the scene is."""
    if part.kind != "surface" or part.is_clear:
        return part.seen_from
    if part.side is None:
        return _inner_side(part, parts)
    if part.is_other_side and _inner_side(part, parts) not in (None, part.side):
        return NOWHERE
    return part.side


def _inner_side(part: Part, parts: list[Part]) -> str | None:
    """The side of a shape on which all the others are, if there is one."""
    if len(part.facets.faces) == 0:
        return None
    finite = [each for each in parts if len(each.facets.points) and not each.shape.is_infinite]
    others = [each for each in finite if each.shape != part.shape]
    if not others:
        return _own_side(part, parts)
    points = np.concatenate([_some(each.facets.points, 40) for each in others])
    normals, centres = (
        _some(each, SAMPLED_FACETS) for each in (part.facets.vector_areas, part.facets.centres)
    )
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    heights = normals @ points.T - (normals * centres).sum(axis=1)[:, None]
    flat = FLATNESS * part.frame.size
    if len(part.facets.faces) > 12 and np.isfinite(part.shape.extent):
        flat += 0.002 * part.shape.extent  # flat facets lie within a round shape
    if (np.abs(heights) <= flat).all():
        return None
    if (heights <= flat).all(axis=1).mean() >= INNER_SHARE:
        return BACK
    return FRONT if (heights >= -flat).all(axis=1).mean() >= INNER_SHARE else None


def _own_side(part: Part, parts: list[Part]) -> str | None:
    """The one side of a shape alone in its scene that emits, or has a detector."""
    sides = {
        BACK if each.kind == "source" and not each.what.emission.has_side else each.side
        for each in parts
        if (each.kind == "source" and each.shape == part.shape) or (each.kind == "detector" and each.side)
    }
    return sides.pop() if len(sides) == 1 else None


def _some(array: np.ndarray, most: int) -> np.ndarray:
    return array[:: max(1, -(-len(array) // most))]
