"""Lower detectors on sheets: their rows of sums, and how the engine finds the bin of a crossing."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from transport.compile import layout
from transport.compile.layout import SIZE_CELLS, SIZE_OCTAVE, SIZE_PARTS, SIZES
from transport.compile.plan import Plan
from transport.compile.rows import Rows, axes_of
from transport.geometry.flat import Disk, Rectangle
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.scene.bins import DirectionCone
from transport.scene.bodies import scene_bodies, surrounding_medium
from transport.scene.detectors import Detector
from transport.scene.scene_speeds import scene_speeds
from transport.scene.sheets import Sheet, SheetMember
from transport.statistics.axes import DIRECTION, POSITION, Axis
from transport.validation import SceneError, short_repr

# Kind of coordinates of a place; on any other shape they are those of a surface of revolution.
PLACE_KINDS = {Rectangle: layout.RECTANGLE_PLACE, Disk: layout.DISK_PLACE, Sphere: layout.SPHERE_PLACE}
MAX_MARKS = 62  # bits of the word in which a lane records its visits


def lower_detectors(plan: Plan, sheets: list[Sheet]) -> list[list[int]]:
    """Give detectors their rows of sums, and fill their tables; return their bits in hit words.

    The bits are by sheet and member: one for each layer, which is a detector, a mark of visits, or a boundary
    of bodies.
    """
    scene = plan.scene
    if len(scene.visited) > MAX_MARKS:
        raise SceneError(f"Scene: via may name at most {MAX_MARKS} places, got {len(scene.visited)}")
    plan.marks = {name: 1 << bit for bit, name in enumerate(scene.visited)}
    # Arrivals at all detectors come first, then departures, and then both again for shadow rays.
    for detector in scene.meters:
        plan.add_rows(detector.name, side_rows(detector, scene.shape_of(detector), scene.duration, plan.rows))
    plan.half, plan.rows = plan.rows, plan.rows * (4 if plan.sends_shadow_rays else 2)
    fill_long_scores(plan)
    rows: list[np.ndarray] = []
    bits = [_add_layers(plan, sheets, number, rows) for number in range(1, len(sheets) + 1)]
    plan.detectors = np.array(rows, layout.DETECTOR)
    _assign_size_cells(plan)
    return bits


def _add_layers(plan: Plan, sheets: list[Sheet], number: int, rows: list[np.ndarray]) -> list[int]:
    """Add the layers of a sheet, and the rows of its detectors; return the bits of each member's layers."""
    layer, found = 0, []
    for member in sheets[number - 1].members:
        bits = 0
        for entry in _member_layers(plan, member, rows):
            if layer == layout.DETECTORS_PER_SHEET:
                raise SceneError(
                    f"Scene: at most {layer} detectors may share one plane or sphere, got one more on"
                    f" {short_repr(member.shape)}; use one detector with positions=Positions(...) instead"
                )
            if layer == len(plan.layers):
                plan.layers.append(np.zeros(len(sheets) + 1, layout.LAYER))
            bits |= 1 << layer
            plan.layers[layer][number] = entry
            layer += 1
        found.append(bits)
    return found


def _member_layers(plan: Plan, member: SheetMember, rows: list[np.ndarray]) -> Iterator[np.ndarray]:
    """Yield the layers of a member: its detectors, a visit mark alone, the bodies that it bounds."""
    for detector in member.detectors:
        yield layer_row(plan, member, detector, len(rows))
        rows.append(detector_row(plan, member, detector))
        plan.detector_names.append(detector.name)
    if member.mark in plan.marks and member.mark not in [detector.name for detector in member.detectors]:
        yield layout.row(layout.LAYER, mark=plan.marks[member.mark])
    if member.bodies[0] != member.bodies[1]:
        front, back = member.bodies if member.orientation > 0 else member.bodies[::-1]
        yield layout.row(layout.LAYER, front=front, back=back)


def side_rows(detector: Detector, shape: Shape, duration: float | None, first: int) -> Rows:
    """Return the rows of one side of a detector: a block per time and speed; in it u, v, azimuth, cosine."""
    outer = axes_of({"time": detector.time_edges(duration), "speed": detector.speed_edges()})
    positions, directions = detector.positions, detector.directions
    inner = () if positions is None else axes_of(positions.edges(shape), positions.units(shape))
    if directions is not None:  # the cosine or polar angle lies fastest
        edges = directions.edges()
        inner += axes_of({name: edges.get(name) for name in ("phi", "mu", "theta")})
    before = len(outer) > 0
    return Rows(first + before, outer, inner, 1 + math.prod(map(len, inner)), before=int(before))


def layer_row(plan: Plan, member: SheetMember, detector: Detector, number: int) -> np.ndarray:
    """Return the row by which a lane finds the detector on a sheet, at the first block of its rows."""
    first, cosines = plan.rows_of[detector.name].first, uniform_cosine_bins(detector) or 1
    word = layout.DETECTOR_PRESENT | first | cosines << layout.DETECTOR_CELLS_SHIFT
    if (member.orientation < 0) != detector.is_back:
        word |= layout.DETECTOR_BACK
    return layout.row(
        layout.LAYER, detector_word=word, detector=number, mark=plan.marks.get(detector.name, 0)
    )


def uniform_cosine_bins(detector: Detector) -> int | None:
    """Return the number of equal cosine bins over the hemisphere; None for other bins or none."""
    directions = detector.directions
    if directions is None or isinstance(directions, DirectionCone) or directions.frame != "local":
        return None
    return directions.mu if isinstance(directions.mu, int) else None


def detector_row(plan: Plan, member: SheetMember, detector: Detector) -> np.ndarray:
    """Return the row of a detector's finer axes, and record their kinds in `plan.axes`."""
    shape, rows = member.shape, plan.rows_of[detector.name]
    back = -1.0 if detector.is_back else 1.0
    e_u, e_v, normal = shape.frame
    values = layout.center_columns(
        plan.space.place(shape.middle if shape.triangles else shape.center)
    ) | layout.frame_columns((e_u, e_v, normal))
    values |= {"side": member.orientation * back, "handed": 1.0}
    if not shape.is_flat:
        values |= layout.vector_columns("axis_", normal)
    elif detector.is_back:  # Seen from behind, e_u changes sign, which keeps the frame right-handed.
        values |= {"eux": -e_u[0], "euy": -e_u[1], "euz": -e_u[2], "handed": -1.0}
    values |= {"outside": rows.base} | _filters(plan, detector)
    for axis in rows.outer:
        plan.axes.add(axis.name)
        values |= axis_columns(plan, axis, rows)
    for axis in rows.inner:
        values |= _direction_columns(plan, detector, shape, axis, rows) if axis.group == DIRECTION else {}
    if detector.positions is not None:
        values |= _position_columns(plan, shape, rows)
    return layout.row(layout.DETECTOR, **values)


def _filters(plan: Plan, detector: Detector) -> dict[str, float]:
    """Return the columns of conditions on visits and reflections, recorded in `plan.filters`."""
    values = {"most": np.iinfo(np.int64).max}
    if detector.via is not None:
        plan.filters.add("visits")
        values["via"] = sum({plan.marks[name] for name in detector.via})
    if detector.events is not None:
        plan.filters.add("reflections")
        least, most = detector.events
        values |= {"least": int(least), "most": int(min(most, np.iinfo(np.int32).max))}
    return values


def _direction_columns(
    plan: Plan, detector: Detector, shape: Shape, axis: Axis, rows: Rows
) -> dict[str, float]:
    """Return the columns of an axis of cosines or azimuths."""
    directions = detector.directions
    is_world = not isinstance(directions, DirectionCone) and directions.frame == "world"
    if axis.name == "phi":
        plan.axes.add("azimuth")
        local = layout.FLAT_AZIMUTH if shape.is_flat else layout.SPHERE_AZIMUTH
        kind = layout.WORLD_AZIMUTH if is_world else local
        return {"turn_kind": kind, "turn_low": axis.edges[0]} | axis_columns(plan, axis, rows)
    if uniform_cosine_bins(detector) is not None:
        return {}
    plan.axes.add("cosine")
    if isinstance(directions, DirectionCone):  # binned by minus the squared sine
        values = layout.vector_columns("axis_", directions.axis)
        edges = np.array([-(math.sin(directions.half_angle) ** 2), 1.0])
        return values | {"mu_kind": layout.CONE} | edge_columns(plan, "mu", edges, rows.strides[axis.name])
    kind = layout.WORLD_COSINE if is_world else layout.LOCAL_COSINE
    axis = axis if axis.coordinate.is_falling else replace(axis, edges=widened(axis.edges))
    return {"mu_kind": kind} | axis_columns(plan, axis, rows)


def _position_columns(plan: Plan, shape: Shape, rows: Rows) -> dict[str, float]:
    """Return the columns of the axes u and v; one that is not binned is one bin."""
    plan.axes.add("place")
    values = {"place": PLACE_KINDS.get(type(shape), layout.REVOLVED_PLACE)}
    binned = {axis.name: axis for axis in rows.inner}
    places = [binned.get(name, Axis(name, np.array([-math.inf, math.inf]))) for name in ("u", "v")]
    others = [axis for axis in rows.inner if axis.group != POSITION]
    for axis in places:
        values |= axis_columns(plan, axis, replace(rows, inner=(*places, *others)))
    return values


def axis_columns(
    plan: Plan, axis: Axis, rows: Rows, prefix: str | None = None, origin: float = 0.0
) -> dict[str, float]:
    """Return the columns of an axis in the units of the plan: number of bins, edges, stride.

    prefix: of the columns, None for that of the coordinate;  origin: what a position is measured from [m].
    """
    if axis.coordinate.is_falling:  # polar angles rise as cosines fall
        edges = np.cos(axis.edges)[::-1]
        edges = widened(np.where(np.abs(edges) < 1e-16, 0.0, edges))
    else:
        edges = (axis.edges - origin) / plan.units.get(axis.unit, 1.0)
    return edge_columns(plan, prefix or axis.coordinate.column, edges, rows.strides[axis.name])


def widened(cosines: np.ndarray) -> np.ndarray:
    """Return edges with -1 and 1 moved outwards: the cosine of a ray along the axis may round beyond 1."""
    return np.where(np.abs(cosines) == 1.0, 2.0 * cosines, cosines)


def edge_columns(plan: Plan, prefix: str, edges: np.ndarray, stride: int = 0) -> dict[str, float]:
    """Return the columns of bins with these edges, which are placed in the arena of the plan."""
    edges = np.ascontiguousarray(edges, np.float64)
    return {
        f"{prefix}_cells": len(edges) - 1,
        f"{prefix}_edges": plan.arena.place(edges),
        f"{prefix}_stride": stride,
    }


# ---- Long scores: what a detector sums beside weights, in rows of four limbs.


@dataclass(frozen=True, eq=False)
class LongScore:
    """A score of detectors besides weights and counts, and the passes that make it.

    sums: names of its sums, which lie next to each other for each row of a detector;  table: of all its
    passes, with columns `place` (its first sum among those of a row) and `each` (the number of all);
    at_birth: passes with their tables that prepare a lane;  in_flight, at_crossing: passes that follow a
    flight, and add to the sums;
    fields: lane fields that these passes address by number, not as attributes of the bundle.
    """

    sums: tuple[str, ...]
    table: np.ndarray
    at_crossing: str
    at_birth: tuple[tuple[str, np.ndarray], ...] = ()
    in_flight: str | None = None
    fields: tuple[str, ...] = ()


def fill_long_scores(plan: Plan) -> None:
    """Fill the long scores that detectors of the scene ask for, and their rows."""
    plan.long_scores = [score for make in (_moments, _paths) if (score := make(plan)) is not None]
    for score in plan.long_scores:
        score.table["place"] = plan.long_sums.index(score.sums[0])
        score.table["each"] = len(plan.long_sums)
    plan.long_rows = len(plan.long_sums) * 2 * plan.half


def _moments(plan: Plan) -> LongScore | None:
    """Return the velocity sums, relative to the extreme speeds of the scene."""
    if not any(detector.moments for detector in plan.scene.meters):
        return None
    slowest = min((v for v in scene_speeds(plan.scene) if isinstance(v, float) and v > 0), default=0.0)
    table = layout.row(
        layout.MOMENTS,
        fastest=plan.fastest / plan.speed_unit,
        slowest=slowest / plan.speed_unit,
        is_light=plan.scene.measured_in == "watts",
    )
    return LongScore(("momentum", "speed", "square"), table, "score_moments")


# [scene lengths] of a path whose sum is 1: far above any path, so that no sum of paths overflows its limbs
PATH_UNIT = 2.0**24
# rows: for each row of layout.MEDIA the number of its path, -1 for none;  media: how many;  number: of one
PATHS = np.dtype([(name, "i8") for name in ("rows", "count", "media", "number", "place", "each")])


def _paths(plan: Plan) -> LongScore | None:
    """Return the path lengths in each medium that a detector names."""
    media = plan.scene.path_media
    if not media:
        return None
    rows = (surrounding_medium(plan.scene), *(body.medium for body in scene_bodies(plan.scene)))
    numbers = np.array([media.index(medium) if medium in media else -1 for medium in rows], np.int64)
    table = layout.row(PATHS, rows=plan.arena.place(numbers), count=len(numbers), media=len(media))
    reset = tuple(("reset_path", layout.row(PATHS, number=number)) for number in range(len(media)))
    names = ("path weight", *(f"path {number}" for number in range(len(media))))
    fields = tuple(f"path_{number}" for number in range(len(media)))
    return LongScore(names, table, "score_paths_by_medium", reset, "follow_paths", fields)


# ---- Histograms of scores by size, where scores can differ in size (engine/passes/score_sizes.py).
#
# Scores of particles born at equal weight, which walls reduce to no less than one half, need no histogram:
# their number suffices. Targets, media that reduce weights, splitting, and estimators with weighted scores
# make sizes differ.
#
# Where all walls carry detectors nearly every lane scores, and a complete histogram would cost a tenth of the
# run. There one batch in COUNTED_EVERY is counted, as long as only media make weights differ. Rare heavy
# scores in the other batches still show, since batches are compared (statistics/batches.py).

# Edges of the cells [largest birth weight]: SIZE_PARTS per octave, equally spaced within it. The first and
# the last cell include everything beyond them.
COUNTED_EVERY = 8  # a power of two
LARGE_SHARE = 0.25  # of the largest score: larger scores show that the largest ones occur
EDGES = np.array(
    [
        math.ldexp(1 + k % SIZE_PARTS / SIZE_PARTS, SIZE_OCTAVE + k // SIZE_PARTS)
        for k in range(SIZE_CELLS + 1)
    ]
)


def sizes_differ(plan: Plan) -> bool:
    """Return whether scores of detectors differ by more than roulette at walls allows."""
    return bool(plan.detectors.size) and (weights_vary(plan) or plan.reduces_weights)


def weights_vary(plan: Plan) -> bool:
    """Return whether anything but a medium makes scores differ."""
    is_weighed = plan.method.guide > 0 or any(emitter.weighs_births for emitter in plan.emitters)
    return is_weighed or plan.sends_shadow_rays or plan.splits or plan.forces_collisions


def is_dense(plan: Plan, layer: np.ndarray) -> bool:
    """Return whether nearly every lane that lands on a surface scores in this layer."""
    return plan.has_acting_surfaces and bool((layer[1:]["detector_word"] != 0).all())


def _assign_size_cells(plan: Plan) -> None:
    """Assign cells to each side of each detector; the first cells belong to no detector.

    Expected scores have rows and a unit of their own, and so cells of their own.
    """
    if not sizes_differ(plan):
        return
    halves = 4 if plan.sends_shadow_rays else 2
    plan.size_numbers, plan.size_cells = np.zeros(halves * plan.half, np.int64), SIZE_CELLS
    for detector in plan.scene.meters:
        rows = plan.rows_of[detector.name]
        for half in range(halves):
            shift = half * plan.half
            plan.size_numbers[rows.base + shift : rows.past + shift] = plan.size_cells
            plan.size_blocks.setdefault((detector.name, half % 2), []).append(plan.size_cells)
            plan.size_cells += SIZE_CELLS


def size_row(plan: Plan) -> np.ndarray:
    """Return the table of the pass that counts scores by size."""
    is_costly = not weights_vary(plan) and any(is_dense(plan, layer) for layer in plan.layers)
    numbers = {"numbers": plan.arena.place(plan.size_numbers), "count": len(plan.size_numbers)}
    return layout.row(SIZES, **numbers, cells=plan.size_cells, resting=COUNTED_EVERY - 1 if is_costly else 0)
