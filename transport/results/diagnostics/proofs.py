"""Bounds on light without a score: proofs that it is absent, and probes that bound it.

A class of paths is empty if its mirrors or sources lie behind the detector, in another room, or hidden from
all lines of sight.

Otherwise a probe bounds it.  The estimator "expected" finds light whose last vertex is specular only by
chance.  Traced backwards, such a path leaves the detector towards a specular surface.  A probe sends
histories from the detector towards each of these surfaces, scores at the sources by flights and by rays
(transport/compile/methods.py), and takes the upper confidence limit.  The limit exceeds the class,
because it includes light that a surface reflects diffusely and light that passes beside it.  For "backward",
which finds light whose first vertex is specular by chance, histories start at the source towards the
surfaces.

Where a mirror, glass or a lamp may be in a picture is proven pixel by pixel, as a glint may fill one of them.

The result of a probe is never added to an estimate.  A probe has at least 65 536 histories, and hardly more
than the run concerned.  If its histories are long (mirrors that trap light), it has fewer, so that its
crossings and collisions hardly exceed those of the run, or there is none.  It depends on scene, detector and
these counts alone, so the same run always has the same findings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from transport.compile.adjoint import adjoint_scene, gains_of
from transport.compile.caustics import may_show
from transport.compile.gloss import glossy_parts
from transport.compile.images import may_be_seen, outlines_of_images
from transport.compile.lamps import strongest_ray
from transport.compile.limits_exceeded import OverrunError
from transport.compile.methods import refusal
from transport.geometry.flat import Slab
from transport.geometry.line_crossings import crossings
from transport.geometry.relations import gap_lower_bound, is_behind
from transport.geometry.shape import ROUNDING, Point, Shape
from transport.geometry.solid import Box, Sphere
from transport.renderers import function_for
from transport.results.diagnostics.empty_detector import are_separated, proven
from transport.scene.bodies import nested_bodies, surrounding_medium
from transport.scene.cameras import CUBE, FACE_FRAMES, IMAGE_FRAMES, Camera
from transport.scene.detectors import Detector
from transport.scene.emissions import Lambertian
from transport.scene.materials import (
    Material,
)
from transport.scene.media import Medium
from transport.scene.parts import surface_name
from transport.scene.points import PointDetector
from transport.scene.projections import EQUAL_AREA, PINHOLE, polar_angles, radial_rays
from transport.scene.sides import IS_BACK
from transport.scene.sources import Source
from transport.statistics.batches import student_quantile
from transport.statistics.findings import unseen_scores
from transport.validation import SceneError, join_names
from transport.vectors import Vector, dot

if TYPE_CHECKING:
    from transport.compile.adjoint import SensorPart
    from transport.compile.plan import Plan
    from transport.results.batches import Batch
    from transport.results.record import Record
    from transport.scene.cameras import Instrument
    from transport.scene.scene import Scene

MIN_LINES, MAX_LINES = 1 << 13, 1 << 17  # lines of sight between a sensor and a lamp
LARGE_LINE_SCORE = 0.25  # of the largest score of a line
END_TOLERANCE = 1e-9  # of a line, at its ends: the surfaces at its ends do not block it
MIN_PROBE_HISTORIES, GROWTH = 1 << 16, 4  # histories of a probe, and their growth
MAX_PROBE_HISTORIES, MAX_SHARE_OF_RUN = 1 << 22, 1.25  # of the longest probe, and relative to the run
# Crossings and collisions allowed to any probe; else MAX_SHARE_OF_RUN of those of the run, in which a history
# counts as having at least MIN_EVENTS_PER_HISTORY.
MIN_EVENT_BUDGET, MIN_EVENTS_PER_HISTORY = MIN_PROBE_HISTORIES * 128, 32
PILOT_HISTORIES = 8, 128  # histories of the pilots that measure the events per history
SHORT_PROBE_BATCH = 128  # histories per batch of a short probe: with fewer a crossing costs more time
SHORT_PROBE_HISTORIES = 256  # histories of the shortest probe
MIN_SHORT_PROBE_BATCHES, MAX_SHORT_PROBE_BATCHES = 8, 32  # batches of a short probe
MAX_PROBE_SURFACES = 16  # surfaces of one probe, each of which needs passes of its own
CLOSE_BOUND_RATIO = 1.15  # times the measured value: a bound so near to it needs no improvement
OUTLINE_TOLERANCE = 1e-9  # relative tolerance of an outline's corners
MIN_PROBE_REFLECTANCE = 0.5  # reflectance that replaces that of darker mirrors
PROBE_SEED = 0x9E3779B9


# ---- empty classes ----


def specular_surfaces_of(scene: Scene, shape: Shape, side: str | None) -> list[int]:
    """Indices of the surfaces whose specular light may come straight to a side of a shape.

    side: None for all.
    """
    return _surfaces_facing(scene, shape, side, attrgetter("is_specular"), "mirrors")


def glossy_surfaces_of(scene: Scene, shape: Shape, side: str | None) -> list[int]:
    """Indices of the surfaces that may send glossy reflections straight to a side of a shape.

    Next-event rays connect them, but leave the middle of a narrow lobe to flights.
    """
    return _surfaces_facing(scene, shape, side, glossy_parts, "gloss")


def sees_mirrors(scene: Scene, view: Instrument) -> bool:
    """Return whether a specular or glossy surface may be in the picture of a view; False is proven."""
    return any(may_show(view, shape) for shape in mirrors_and_gloss(scene))


def mirrors_and_gloss(scene: Scene) -> list[Shape]:
    """Return the shapes of all specular and glossy surfaces."""
    surfaces = [each for each in scene.surfaces if each.material.is_specular or glossy_parts(each.material)]
    return [each.shape for each in surfaces]


Cones = tuple[np.ndarray, np.ndarray, np.ndarray]  # axes, and of each pixel the middle ray and the reach


def pixels_of(view: Instrument, shapes: Sequence[Shape], cones: Cones | None = None) -> np.ndarray:
    """Return whether each pixel or bin, (cells,) as stored, may show one of the shapes; False is proven.

    By bounding spheres, and in a pinhole's image by the outlines of bounding boxes.  cones: of the pixels, if
    known.
    """
    from scipy.spatial import ConvexHull

    if not view.sees_from_point:
        return np.ones(math.prod(len(edges) - 1 for edges in view.edges().values()), bool)
    axes, rays, reach = cones or cones_of(view)
    shown = np.zeros(len(rays), bool)
    for shape in shapes:
        if not may_show(view, shape):
            continue
        if shape.is_infinite or math.dist(shape.middle, view.position) <= shape.extent:
            return np.ones(len(rays), bool)
        # The cone of the bounding sphere.
        center = np.subtract(shape.middle, view.position)
        distance = float(np.linalg.norm(center))
        inside = _angles(rays @ center / distance) <= math.asin(shape.extent / distance) + reach
        # The outline of the bounding box, in the plane of the picture.
        left, height, depth = ((np.array(shape.bounds_corners()) - view.position) @ axes.T).T
        if isinstance(view, Camera) and view.lens == PINHOLE and (depth > 0).all():
            corners = np.stack([-left / depth, height / depth], axis=1)
            outline = ConvexHull(corners, qhull_options="QJ")  # joggled, as corners may lie on a line
            middles = np.stack([-(rays @ axes[0]), rays @ axes[1]]) / (rays @ axes[2])
            beyond = outline.equations[:, :2] @ middles + outline.equations[:, 2:]
            inside &= beyond.max(axis=0) <= reach + OUTLINE_TOLERANCE * np.abs(corners).max()
        shown |= inside
    return shown


def nearest_rays(view: Instrument, shapes: Sequence[Shape]) -> np.ndarray:
    """Return a bound of cosine / (pi r^2) [m^-2] of rays from shapes to each pixel, (cells,) as stored."""
    cones = cones_of(view)
    _, rays, reach = cones
    place, bound, reach = view.position, np.zeros(len(rays)), np.broadcast_to(reach, len(rays))
    for shape in shapes:
        largest = strongest_ray(shape, place, place)
        if largest == 0 or not may_show(view, shape):
            continue
        (here,) = np.nonzero((bound < largest) & pixels_of(view, [shape], cones))
        found = np.full(len(here), largest)
        if shape.is_flat:  # along a ray at the cosine mu to the normal, from the height h: mu^3/(pi h^2)
            height = shape.height_of(place)
            angles = _angles(-math.copysign(1.0, height) * (rays[here] @ np.array(shape.frame[2])))
            cosines = np.maximum(np.cos(np.maximum(angles - reach[here], 0.0)), 0.0)
            with np.errstate(divide="ignore", invalid="ignore"):
                found = np.fmin(cosines**3 / (math.pi * height**2), found)
        bound[here] = np.maximum(bound[here], found)
    return bound


def cones_of(view: Instrument) -> Cones:
    """Return axes, and of each pixel or bin, as stored, the middle ray (cells, 3) and the reach [rad]."""
    edges = view.edges()
    middles = {name: (each[1:] + each[:-1]) / 2 for name, each in edges.items()}
    if view.projection_of_image is not None:
        up, right = np.meshgrid(middles["v"], middles["u"], indexing="ij")
        v, u = edges["v"], edges["u"]
        half = math.hypot(u[1] - u[0], v[1] - v[0]) / 2
        if isinstance(view, Camera):
            axes = np.array(view.frame)
            frames = [(-axes[0], axes[1], axes[2])]
        else:
            axes = np.eye(3)
            frames = FACE_FRAMES if view.projection == CUBE else [IMAGE_FRAMES[view.projection]]
        rays = radial_rays(view.projection_of_image, right, up).reshape(-1, 3)
        reach = np.array(half)  # no map but that of equal areas makes anything smaller
        if view.projection_of_image == EQUAL_AREA:  # along the radius, and across it
            radius = np.hypot(right, up).ravel()
            reach = half + polar_angles(EQUAL_AREA, radius + half) - polar_angles(EQUAL_AREA, radius)
        return axes, np.concatenate([rays @ np.array(frame) for frame in frames]), reach
    # Cosines rise within azimuths; reach: along the parallel and the meridian of the middle.
    phi, theta = np.meshgrid(middles["phi"], middles["theta"][::-1], indexing="ij")
    rays = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    widths = np.meshgrid(np.diff(edges["phi"]), np.diff(edges["theta"])[::-1], indexing="ij")
    reach = (widths[0] * np.sin(theta) + widths[1]) / 2
    return np.eye(3), rays.reshape(-1, 3), reach.ravel()


def _angles(cosines: np.ndarray) -> np.ndarray:
    """Return angles [rad] of cosines that rounding may have made too large."""
    return np.arccos(np.clip(cosines, -1.0, 1.0))


def _surfaces_facing(
    scene: Scene, shape: Shape, side: str | None, is_sending: Callable[[Material], object], name: str
) -> list[int]:
    """Indices of the surfaces of such a material that may send light straight to a side of a shape."""
    # Keep the shape, so that no other object takes its id.
    find = partial(_find_surfaces_facing, scene, shape, side, is_sending)
    return proven(scene, (name, id(shape), side), lambda: (shape, find()))[1]


def _find_surfaces_facing(
    scene: Scene, shape: Shape, side: str | None, is_sending: Callable[[Material], object]
) -> list[int]:
    found = []
    for number, surface in enumerate(scene.surfaces):
        if not is_sending(surface.material) or is_behind(surface.shape, shape, side):
            continue
        is_away = _faces_away(surface.shape, surface.material, shape, is_sending)
        if not is_away and not are_separated(scene, (shape, side), (surface.shape, None), number):
            found.append(number)
    return found


def surface_names(scene: Scene, numbers: Iterable[int]) -> list[str]:
    """Names of the surfaces with these indices."""
    return [surface_name(scene, number).removeprefix("Surface ") for number in numbers]


def _faces_away(
    mirror: Shape, material: Material, shape: Shape, is_sending: Callable[[Material], object]
) -> bool:
    """Return whether a flat surface with one such side turns that side away from all of a shape."""
    if not mirror.is_flat:
        return False
    sides = zip(("front", "back"), material.sides, strict=True)
    sending = [side for side, each in sides if is_sending(each)]
    return not material.is_transmissive and len(sending) == 1 and is_behind(shape, mirror, sending[0])


def unconnected_sources(plan: Plan, shape: Shape, side: str) -> Iterator[str]:
    """The sources whose births no ray connects and that may send light straight to a side of a shape."""
    for emitter in plan.emitters:
        emission = emitter.source.emission
        if (emitter.target is not None or emitter.beside) and plan.adjoint is None:
            yield source_title(plan.scene, emitter.source)
            continue
        if emission.law != "beam" or miss_distance(emitter.shape, emission.direction, shape) > 0:
            continue
        along = dot(emission.direction, shape.normal) if shape.is_flat else 0.0
        if not shape.is_flat or ((along > 0) == IS_BACK[side] and along != 0):
            yield source_title(plan.scene, emitter.source)


def miss_distance(origin: Shape, direction: Vector, shape: Shape) -> float:
    """Least distance at which parallel rays from one shape pass another, by bounding balls [m].

    0 if they may meet.
    """
    if origin.is_infinite or shape.is_infinite:
        return 0.0
    offset, reach = np.subtract(shape.middle, origin.middle), origin.extent + shape.extent
    along = float(np.dot(offset, direction))
    miss = math.sqrt(max(float(np.dot(offset, offset)) - along * along, 0.0))
    return max(math.hypot(miss, min(along, 0.0)) - reach, 0.0)


def source_title(scene: Scene, source: Source) -> str:
    """Return how a message names a source: by its surface, by its number, or as an emitting medium."""
    number = next((number for number, each in enumerate(scene.sources) if each is source), None)
    if number is None:
        return "an emitting medium"
    return f"the source on {source.shape!r}" if isinstance(source.shape, str) else f"sources[{number}]"


@dataclass(frozen=True, eq=False)
class DirectView:
    """A lamp as seen from a detector at which histories start.

    number: index of the lamp;  parts: of the detector, to which lines of sight lead;  side: on which the lamp
    emits, None for all.
    """

    scene: Scene
    sensor: Detector | PointDetector | Instrument
    parts: Sequence[SensorPart]
    number: int
    lamp: Shape
    side: str | None

    @property
    def is_hidden(self) -> bool:
        """Whether geometry proves that no direct light of the lamp reaches the detector."""
        lamp, side = self.lamp, self.side
        if isinstance(self.sensor, Camera) and not (
            self.sensor.may_see(lamp) and may_show(self.sensor, lamp)
        ):
            return True
        facing = getattr(self.sensor, "side", None)
        for part in self.parts:
            if is_behind(lamp, part.shape, facing) or is_behind(part.shape, lamp, side):
                continue
            if not are_separated(self.scene, (part.shape, facing), (lamp, side)):
                return False
        return True

    @property
    def is_mirrored(self) -> bool:
        """Whether a camera may see the lamp in mirrors, or another sensor may."""
        camera = self.sensor
        if not isinstance(camera, Camera):
            return True

        def find() -> bool:
            images = outlines_of_images(self.scene, self.lamp)
            return images is None or any(
                camera.may_see_hull(each[-1]) and may_be_seen(each, camera.position) for each in images
            )

        return proven(self.scene, ("mirrored", camera.name, self.number), find)

    def bound(self, enough: float) -> tuple[float, bool]:
        """Bound (95 % confidence) of the lamp's share of the view, and whether any line of sight is clear.

        Lines connect even points on both, with as many lines as it takes to get below `enough` or close to
        the measured share.  Returns (infinite, True) for shapes without points.
        """
        bound, is_shown, lines = math.inf, True, MIN_LINES
        while lines <= MAX_LINES:
            # A run with a requested error asks often.
            key = self.sensor.name, self.number, lines
            bound, found, is_shown = proven(self.scene, key, partial(self._visible_share, lines))
            if bound <= max(enough, CLOSE_BOUND_RATIO * found) or math.isinf(bound):
                break
            lines *= GROWTH
        return bound, is_shown

    def _visible_share(self, lines: int) -> tuple[float, float, bool]:
        """Bound and estimate of the share of the view that the lamp fills, and whether any line is clear."""
        rng, bound, found, is_shown = np.random.default_rng(0), 0.0, 0.0, False
        sensor, lamp, unknown = self.sensor, self.lamp, (math.inf, 0.0, True)
        is_directed = isinstance(sensor, Detector)
        if not (is_directed or isinstance(sensor, PointDetector)) or self.side is None:
            return unknown
        full = 1 / math.pi if is_directed else 0.25 / math.pi
        for part in self.parts:
            # Draw the ends of the lines, and compute the score of each line.
            ends = [even_points_on(shape, rng.random((lines, 2))) for shape in (part.shape, lamp)]
            if any(end is None for end in ends):
                return unknown
            (start, facing), (end, emitting) = ends
            rays = end - start
            distances = np.linalg.norm(rays, axis=1)
            with np.errstate(divide="ignore", invalid="ignore"):
                rays = rays / distances[:, None]
                there, here = (rays * emitting).sum(axis=1), (rays * facing).sum(axis=1)
                there = np.maximum(there if IS_BACK[self.side] else -there, 0.0)
                here = np.maximum(-here if is_directed and IS_BACK[sensor.side] else here, 0.0)
                kernel = there * lamp.area / distances**2 * (here / math.pi if is_directed else full)
            # Keep the lines that no opaque surface blocks.
            free = np.flatnonzero(kernel > 0)
            free = free[~_are_blocked(self.scene, start[free], rays[free], distances[free])]
            shown = kernel[free]
            mean = float(shown.sum()) / lines
            spread = 2 * math.sqrt(max(float((shown**2).sum()) / lines - mean**2, 0.0) / lines)
            # The shortest lines score most, and none of them may have been drawn.
            gap = gap_lower_bound(part.shape, lamp)
            limit = lamp.area * full / gap**2 if gap > 0 else math.inf
            strong = int((shown >= LARGE_LINE_SCORE * limit).sum())
            unseen = unseen_scores(strong) * limit / lines
            bound = max(bound, min(mean + spread + unseen, 1.0))
            found, is_shown = max(found, mean), is_shown or len(free) > 0
        return bound, found, is_shown


def even_points_on(shape: Shape, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Points even over the area of a shape from numbers (n, 2) in [0, 1), and normals, each (n, 3).

    None for other kinds of shapes.
    """
    is_known = shape.is_flat or isinstance(shape, Point) or (shape.is_convex and len(shape.pieces()) == 1)
    if not is_known or shape.hole is not None or shape.is_infinite:
        return None
    return shape.sample_area(numbers)


def _are_blocked(scene: Scene, start: np.ndarray, rays: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """Return whether an opaque surface lies between the ends of each line."""
    blocked = np.zeros(len(start), bool)
    for surface in scene.surfaces:
        if not surface.material.is_transmissive:
            met = crossings(surface.shape, start, rays).distances / distances[:, None]
            blocked |= ((met > END_TOLERANCE) & (met < 1 - END_TOLERANCE)).any(axis=1)
    return blocked


# ---- transmission of media ----


def max_transmitted_weight(plan: Plan, shape: Shape) -> float:
    """Largest possible weight of a history at a shape, relative to its birth weight; 1 unless proven less.

    Absorption along a path reduces weights by exp(-absorption * length).  The length is proven if a single
    body of one medium separates a source from the shape, or contains one of them.
    """

    def find() -> float:
        if plan.plays_roulette or not plan.attenuates:  # survivors of roulette are heavier
            return 1.0
        return max(math.exp(-_least_depth(plan, emitter.shape, shape)) for emitter in plan.emitters)

    # Keep both, so that no other objects take their ids.
    return proven(plan.scene, ("passes", id(plan), id(shape)), lambda: (plan, shape, find()))[2]


def _least_depth(plan: Plan, origin: Shape, shape: Shape) -> float:
    """Least number of mean free paths to absorption on any path between two shapes, as far as proven."""
    scene, depth = plan.scene, 0.0
    bodies, holders = nested_bodies(scene)
    is_straight = not (
        plan.reflects or plan.scatters or any(each.material.is_specular for each in scene.surfaces)
    )
    outside = surrounding_medium(scene)
    if not bodies and isinstance(outside, Medium):
        depth += outside.absorption * gap_lower_bound(origin, shape)
    for number, body in enumerate(bodies):
        is_whole = len(body.surfaces) == 1 and not any(number in each for each in holders)
        if is_whole and isinstance(body.medium, Medium):
            within = scene.surfaces[body.surfaces[0]].shape
            depth += body.medium.absorption * _least_length_in_body(within, origin, shape, is_straight)
    return depth


def _least_length_in_body(body: Shape, origin: Shape, shape: Shape, is_straight: bool) -> float:
    """Least length inside a body of any path between two shapes [m], as far as proven.

    is_straight: whether all paths are straight.
    """
    if body.is_convex and body.is_infinite:
        (low, high), (least, most) = (_heights_above_slab(body, each) for each in (origin, shape))
        half = body.thickness / 2 * (1 - ROUNDING)
        return body.thickness if (high <= -half and least >= half) or (most <= -half and low >= half) else 0.0
    if origin.is_infinite or shape.is_infinite or not body.is_convex:
        return 0.0
    for inner, outer in ((origin, shape), (shape, origin)):
        height = _height_above_surface(body, inner)[1]
        if height < 0 <= _height_above_surface(body, outer)[0]:
            return -height
    if not (isinstance(body, Box) and is_straight):
        return 0.0
    (low, high), (first_low, first_high), (last_low, last_high) = body.bounds, origin.bounds, shape.bounds
    for axis in range(3):
        is_across = (first_high[axis] <= low[axis] and last_low[axis] >= high[axis]) or (
            last_high[axis] <= low[axis] and first_low[axis] >= high[axis]
        )
        is_beside = all(
            min(first_low[k], last_low[k]) >= low[k] and max(first_high[k], last_high[k]) <= high[k]
            for k in range(3)
            if k != axis
        )
        if is_across and is_beside:
            return high[axis] - low[axis]
    return 0.0


def _heights_above_slab(body: Slab, shape: Shape) -> tuple[float, float]:
    """Range of heights of a shape above the middle of a slab [m]; infinite if unknown."""
    middle = dot(tuple(p - q for p, q in zip(shape.middle, body.middle, strict=True)), body.normal)
    is_level = shape.is_flat and abs(dot(shape.normal, body.normal)) >= 1 - ROUNDING
    reach = 0.0 if is_level else shape.extent
    return middle - reach, middle + reach


def _height_above_surface(body: Box | Sphere, shape: Shape) -> tuple[float, float]:
    """Bounds of the height of a shape above the surface of a body [m]; negative inside it."""
    if isinstance(body, Sphere):
        apart, reach = math.dist(shape.middle, body.center) - body.radius, shape.extent
        return apart - reach, apart + reach
    (low, high), (least, most) = body.bounds, shape.bounds
    lowest = np.max([np.subtract(low, most), np.subtract(least, high)])
    highest = np.max([np.subtract(low, least), np.subtract(most, high)])
    return float(lowest), float(highest)


# ---- bounded classes ----


def events_of(batches: Iterable[Batch]) -> int:
    """Number of crossings and collisions of a run."""
    return sum(batch.crossings + batch.collisions for batch in batches)


@dataclass(frozen=True, eq=False)
class Probe:
    """Light at a detector that comes last from some surfaces, measured by histories towards each of them.

    With a lamp it is the light that the lamp sends first to these surfaces.  surfaces: indices.
    """

    scene: Scene
    detector: Detector
    surfaces: Sequence[int]
    lamp: Source | None = None

    def bound(self, histories: float, enough: float, events: float = 0.0) -> tuple[float, float]:
        """Bound (95 % confidence) and estimate of the light [W]; infinite if unknown.

        histories, events: of the run concerned;  enough: a bound [W] that needs no improvement.
        """
        bound, value = math.inf, 0.0
        for length in self._sizes(histories, events):
            bound, value = self._measured((), length, self._measure, (math.inf, 0.0))
            if bound <= max(enough, CLOSE_BOUND_RATIO * value) or math.isinf(bound):
                break  # a longer probe would not improve it
        return bound, value

    @property
    def refusal(self) -> str:
        """Reason why no probe can bound this light, if known without running one; else ""."""
        if len(self.surfaces) > MAX_PROBE_SURFACES:
            return f"more than {MAX_PROBE_SURFACES} surfaces"
        if endless := self._infinite_surfaces:
            return f"{join_names(surface_names(self.scene, endless))} is infinite"
        try:
            if self.lamp is None:
                _ = self._adjoint
        except SceneError as error:
            return str(error).partition(";")[0]  # the cure is that of another run
        return ""

    @property
    def _infinite_surfaces(self) -> list[int]:
        return [number for number in self.surfaces if self.scene.surfaces[number].shape.is_infinite]

    def _measured(self, kind: tuple[str, ...], length: int, measure: Callable, unknown: Any) -> Any:
        """The result of a probe of so many histories, run once per scene; `unknown` if it cannot be run."""
        lamp = self.lamp and self.scene.sources.index(self.lamp)
        place = self.detector.name, self.detector.side, lamp, tuple(self.surfaces)

        def find() -> Any:
            try:
                return measure(length)
            except (SceneError, MemoryError):
                return unknown

        return proven(self.scene, (*kind, place, length), find)

    def _sizes(self, histories: float, events: float) -> list[int]:
        """Numbers of histories of the probes for a run, to be tried one after the other."""
        # Measure the events per history by pilots.
        most = max(MIN_EVENT_BUDGET, MAX_SHARE_OF_RUN * max(events, MIN_EVENTS_PER_HISTORY * histories))
        each = 1.0
        for length in PILOT_HISTORIES:
            if each * length <= most:
                each = self._measured(("events",), length, self._events_per_history, math.inf)
        # Choose the numbers of histories within the limits of histories and events.
        longest = max(MIN_PROBE_HISTORIES, MAX_SHARE_OF_RUN * histories)
        longest = min(longest, MAX_PROBE_HISTORIES, most / each)
        if longest < MIN_PROBE_HISTORIES:
            # Take one that fits, out of a few lengths, so that similar runs share it.
            lengths = [MIN_PROBE_HISTORIES // GROWTH**k for k in range(1, 5)]
            return [length for length in lengths if SHORT_PROBE_HISTORIES <= length <= longest][:1]
        lengths = [MIN_PROBE_HISTORIES]
        while GROWTH * lengths[-1] <= longest:
            lengths.append(GROWTH * lengths[-1])
        return lengths

    def _events_per_history(self, length: int) -> float:
        """Crossings and collisions per history, at least 1."""
        return max(events_of(self.run(length).batches) / length, 1.0)

    def _measure(self, length: int) -> tuple[float, float]:
        """Bound and estimate of the light [W]."""
        scene, detector = self.scene, self.detector
        result = self.run(length)
        unit = result.plan.unit
        if self.lamp is None:
            _, lamps = self._adjoint
            gains = gains_of(result.plan, scene, lamps, result.plan.emitters[0])
            found = [_bound_of_total(result, lamp.detector) for lamp in lamps]
            scale = math.pi * scene.shape_of(detector).area * unit
            return tuple(
                scale * math.fsum(gain * each[k] for gain, each in zip(gains, found, strict=True))
                for k in (0, 1)
            )
        mirrors = specular_surfaces_of(scene, scene.shape_of(detector), detector.side)
        last = Probe(scene, detector, mirrors)
        straight = last.bound(length, 0.0, events_of(result.batches))[0] if mirrors else 0.0
        return tuple(unit * each for each in _bound_of_total(result, detector, straight / unit))

    @property
    def _adjoint(self) -> tuple:
        """The scene for backward histories, and its sources.  Raises SceneError if there is none."""
        if (why := refusal(self.scene, "backward")) is not None:
            raise SceneError(str(why))
        turned, lamps = adjoint_scene(self.scene)
        if not all(isinstance(lamp.detector, Detector) for lamp in lamps):
            raise SceneError("a source is a volume, a Point or a Beam")
        return turned, lamps

    def run(self, length: int) -> Record:
        """Run histories from the detector, or from the lamp, towards each of the surfaces."""
        scene, lamp = self.scene, self.lamp
        if lamp is None:
            detectors = self._adjoint[0].detectors
            start = Source(self.detector.shape, Lambertian(power=1.0), side=self.detector.side)
        else:
            detectors = [self.detector]
            start = replace(lamp, emission=Lambertian(power=lamp.amount(scene.shape_of(lamp), None)))
        if len(self.surfaces) > MAX_PROBE_SURFACES or self._infinite_surfaces:
            raise SceneError("cannot aim histories at an infinite surface, or at so many surfaces")
        # Aim one source at each surface, and brighten dark mirrors.
        born, there = [], list(scene.surfaces)
        for number in self.surfaces:
            surface = scene.surfaces[number]
            material, share = surface.material.brightened(MIN_PROBE_REFLECTANCE)
            there[number] = replace(surface, material=material)
            power = Lambertian(power=share * start.emission.power)
            born.append(replace(start, emission=power, aim=surface.shape))
        # Use next-event estimation if the scene allows it.
        probe = type(scene)(born, there, detectors, scene.medium)
        simulate = partial(function_for(type(scene), "simulate"), probe, length)
        how = {"seed": PROBE_SEED, "threads": 1, "progress": False}
        if length < SHORT_PROBE_HISTORIES:
            how["batches"] = 2
        elif length < MIN_PROBE_HISTORIES:
            batches = max(length // SHORT_PROBE_BATCH, MIN_SHORT_PROBE_BATCHES)
            how["batches"] = min(batches, MAX_SHORT_PROBE_BATCHES)
        try:
            result = simulate(estimator="expected", **how)
        except OverrunError:
            raise
        except SceneError:  # the scene has no lamp or detector for rays
            result = simulate(estimator="analog", **how)
        if not result.is_complete:
            raise KeyboardInterrupt
        return result


def _bound_of_total(result: Record, detector: Detector, straight: float = math.inf) -> tuple[float, float]:
    """Bound and estimate of the mean weight per history that arrives at a detector.

    straight: bound of the part whose last vertex was not a diffuse wall.
    """
    total = result[detector.name].diagnosis.total("weight in")
    value, findings = float(total.value), total._raw_findings
    if any(math.isnan(each.bound) for each in findings) or (math.isnan(total.error) and value > 0):
        return math.inf, value
    unseen = [
        min(float(each.bound), straight if each.name == "path class" else math.inf)
        for each in findings
        if each.bound > 0
    ]
    spread = float(student_quantile(0.975, total.dof) * total.error) if total.error > 0 else 0.0
    return value + spread + math.fsum(unseen), value
