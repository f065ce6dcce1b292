"""A scene becomes a plan: tables in scene lengths for just the steps that it calls for.  No Numba here."""

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from transport import layout
from transport.bins import DirectionCone
from transport.detectors import Detector
from transport.emitters import Emitter, emitters_of
from transport.materials import Black, Diffuse, Mirror
from transport.scene import Scene
from transport.shapes import Disk, Rectangle, Shape, Sphere
from transport.sheets import Member, Sheet, sheet_of_source, sheets_of
from transport.space import Space, space_of
from transport.validation import SceneError

SETBACK = (
    2.0**-48
)  # [scene lengths] from an edge within which a point is drawn back: 32 roundings of a coordinate


@dataclass
class Plan:
    """All that the engine needs to know of a scene."""

    scene: Scene
    space: Space
    emitters: list[Emitter]
    members: list[tuple[str, np.ndarray]] = field(default_factory=list)  # e.g. ("meet_rectangle", its row)
    sheets: np.ndarray = None
    surfaces: np.ndarray = None
    walls: np.ndarray = None
    layers: list[np.ndarray] = field(default_factory=list)
    meters: np.ndarray = None
    bases: dict[str, int] = field(default_factory=dict)  # first row of each detector
    half: int = 1  # rows from a detector's arrivals to its departures
    owners: list[int] = field(default_factory=list)  # index in scene.surfaces of each row of `surfaces`
    axes: set[str] = field(default_factory=set)  # of "cosine", "azimuth", "place": the finer bins called for
    edges: list[np.ndarray] = field(default_factory=list)  # kept alive: the meters' rows hold their addresses

    @property
    def has_clock(self) -> bool:
        return self.scene.duration is not None

    @property
    def is_curved(self) -> bool:
        return bool((self.sheets["curvature"] != 0).any())

    @property
    def acts(self) -> bool:
        return len(self.surfaces) > 1

    @property
    def has_walls(self) -> bool:
        return any(name == "meet_rectangle" for name, _ in self.members)

    @property
    def materials(self) -> set[int]:
        return set(self.surfaces["material"].tolist())

    @property
    def absorbs(self) -> bool:
        return bool((self.surfaces["albedo"] < 1).any())

    @property
    def reflects(self) -> bool:
        return bool((self.surfaces["albedo"][1:] > 0).any())

    @property
    def has_roulette(self) -> bool:
        """Whether a particle can go on at a fraction of its weight."""
        return bool(((self.surfaces["albedo"] > 0) & (self.surfaces["albedo"] < 1)).any())

    @property
    def draws(self) -> bool:
        """Whether crossings need random numbers."""
        return self.has_roulette or layout.DIFFUSE in self.materials

    @property
    def rows(self) -> int:
        return 2 * self.half

    @property
    def unit(self) -> float:
        """What all histories of a run stand for at the weight 1: [W], or particles."""
        return math.fsum(emitter.bound for emitter in self.emitters)


@lru_cache(maxsize=32)
def compile_scene(scene: Scene) -> Plan:
    """The plan of a scene."""
    sheets = sheets_of(scene)
    space = space_of(scene)
    plan = Plan(scene, space, emitters_of(scene, space, lambda shape: sheet_of_source(shape, sheets)))
    if len(sheets) >= 1 << 15:
        raise SceneError(f"Scene: at most 32767 planes and spheres, got {len(sheets)}")
    plan.sheets = np.zeros(len(sheets) + 1, layout.SHEET)
    for number, sheet in enumerate(sheets, start=1):
        _fill_sheet(plan.sheets[number], sheet, space)
    _number_rows(plan)
    _fill_members(plan, sheets)
    return plan


def _fill_sheet(row: np.void, sheet: Sheet, space: Space) -> None:
    support = sheet.support
    row["cx"], row["cy"], row["cz"] = space.place(support.center)
    if isinstance(support, Sphere):
        row["radius"] = support.radius / space.size
        row["curvature"] = space.size / support.radius
    else:
        row["nx"], row["ny"], row["nz"] = support.normal


def _number_rows(plan: Plan) -> None:
    """Each detector has one row for the outside of its bins, then its bins; row 0 of all is nobody's."""
    row = 1
    for detector in plan.scene.detectors:
        plan.bases[detector.name] = row
        row += 1 + math.prod(bin_counts(detector, plan.scene.shape_of(detector)).values())
    plan.half = row


def bin_counts(detector: Detector, shape: Shape) -> dict[str, int]:
    """Number of bins of each axis, in the order in which they lie: u, v, azimuth, cosine (the last one fastest)."""
    edges = {} if detector.positions is None else detector.positions.edges(shape)
    directions = {} if detector.directions is None else detector.directions.edges()
    cosine = directions.get("mu", directions.get("theta"))
    axes = {"u": edges.get("u"), "v": edges.get("v"), "turn": directions.get("phi"), "mu": cosine}
    return {name: 1 if e is None else len(e) - 1 for name, e in axes.items()}


def _fill_members(plan: Plan, sheets: list[Sheet]) -> None:
    surfaces, walls, meters, layers = [np.zeros((), layout.SURFACE)], [np.zeros((), layout.RECTANGLE)], [], []
    surfaces[0]["albedo"] = 1.0
    for number, sheet in enumerate(sheets, start=1):
        layer = 0
        for member in sheet.members:
            code = number << layout.SHEET_SHIFT
            if member.surface is not None:
                surfaces.append(_surface_row(member))
                plan.owners.append(plan.scene.surfaces.index(member.surface))
                code |= (len(surfaces) - 1) << layout.SURFACE_SHIFT
                code |= int(surfaces[-1]["material"]) << layout.MATERIAL_SHIFT
            for detector in member.detectors:
                if layer == layout.METERS_A_SHEET:
                    raise SceneError(
                        f"Detector {detector.name!r}: at most {layer} detectors lie on one plane or sphere; bin one"
                        " detector by positions=Positions(...) instead"
                    )
                if layer == len(layers):
                    layers.append(np.zeros(len(sheets) + 1, layout.LAYER))
                code |= 1 << layer
                layers[layer][number] = _layer_row(plan, member, detector, len(meters))
                meters.append(_meter_row(plan, member, detector))
                layer += 1
            row = _member_row(member, plan.space, code, number)
            verb = "cover" if member.surface is None else "meet"
            plan.members.append((f"{verb}_{type(member.shape).__name__.lower()}", row))
            if member.surface is not None:
                walls.append(row if isinstance(member.shape, Rectangle) else walls[0])
    if len(surfaces) > layout.SURFACE_MASK:
        raise SceneError(f"Scene: at most {layout.SURFACE_MASK} acting surfaces, got {len(surfaces) - 1}")
    plan.surfaces, plan.walls = np.array(surfaces, layout.SURFACE), np.array(walls, layout.RECTANGLE)
    plan.layers, plan.meters = layers, np.array(meters, layout.METER)


def _surface_row(member: Member) -> np.ndarray:
    match member.surface.material:
        case Diffuse(albedo=albedo):
            return layout.row(layout.SURFACE, material=layout.DIFFUSE, albedo=albedo)
        case Mirror(reflectance=reflectance):
            return layout.row(layout.SURFACE, material=layout.MIRROR, albedo=reflectance)
        case Black():
            return layout.row(layout.SURFACE, material=layout.BLACK, albedo=0.0)
    raise SceneError(f"Surface {member.surface.name!r}: no engine for {member.surface.material}")


def _member_row(member: Member, space: Space, code: int, sheet: int) -> np.ndarray:
    shape = member.shape
    values = layout.center_columns(space.place(shape.center)) | {"code": code, "sheet": sheet}
    if isinstance(shape, Sphere):
        return layout.row(layout.SPHERE, **values, radius=shape.radius / space.size)
    acts = member.surface is not None
    # What acts takes what rounding carried past its edge: of the point's coordinates and of those that were given.
    rounding = layout.ROUNDING * (sum(map(abs, space.place(shape.center))) + shape.extent / space.size)
    slack = rounding + 2.0**-52 * sum(map(abs, shape.center)) / space.size if acts else 0.0
    if isinstance(shape, Disk):
        inner, outer = shape.inner_radius / space.size, shape.radius / space.size
        inner, outer = max(inner - slack, 0.0), outer + slack
        values |= dict(zip(("nx", "ny", "nz"), shape.normal, strict=True))
        return layout.row(
            layout.DISK, **values, inner2=inner * inner, outer2=outer * outer, breadth=2 * outer
        )
    values |= layout.frame_columns(shape.frame)
    for axis, length in (("u", shape.width), ("v", shape.height)):
        half = 0.5 * length / space.size
        values |= {f"half_{axis}": half + slack, f"inner_{axis}": half - min(SETBACK + slack, half / 1024)}
    return layout.row(layout.RECTANGLE, **values)


def _layer_row(plan: Plan, member: Member, detector: Detector, meter: int) -> np.ndarray:
    look = layout.LOOK | plan.bases[detector.name] | (plain_cosines(detector) or 1) << layout.LOOK_CELLS_SHIFT
    if (member.orientation < 0) != detector.is_back:
        look |= layout.LOOK_BACK
    return layout.row(layout.LAYER, look=look, meter=meter)


def plain_cosines(detector: Detector) -> int | None:
    """The number of equal cosine bins over the hemisphere; None where the bins are others or none."""
    directions = detector.directions
    if directions is None or isinstance(directions, DirectionCone) or directions.frame != "local":
        return None
    return directions.mu if isinstance(directions.mu, int) else None


def _meter_row(plan: Plan, member: Member, detector: Detector) -> np.ndarray:
    """The meter's finer axes; `plan.axes` learns which kinds there are."""
    shape, scene_shape = member.shape, plan.scene.shape_of(detector)
    back = -1.0 if detector.is_back else 1.0
    e_u, e_v, normal = shape.frame
    values = layout.center_columns(plan.space.place(shape.center)) | layout.frame_columns((e_u, e_v, normal))
    values |= {"side": member.orientation * back, "handed": 1.0}
    if isinstance(shape, Sphere):
        values |= dict(zip(("axis_x", "axis_y", "axis_z"), normal, strict=True))
    elif detector.is_back:  # seen from behind e_u changes its sign, and with it the frame stays right-handed
        values |= {"eux": -e_u[0], "euy": -e_u[1], "euz": -e_u[2], "handed": -1.0}
    counts = bin_counts(detector, scene_shape)
    strides = dict(
        zip(("mu", "turn", "v", "u"), np.cumprod([1, counts["mu"], counts["turn"], counts["v"]]), strict=True)
    )
    values |= _direction_axes(plan, detector, shape, strides)
    if detector.positions is not None:
        values |= _position_axes(plan, detector, shape, strides)
    return layout.row(layout.METER, **values)


def _direction_axes(
    plan: Plan, detector: Detector, shape: Shape, strides: dict[str, int]
) -> dict[str, float]:
    directions, values = detector.directions, {}
    if directions is None:
        return values
    if isinstance(directions, DirectionCone):
        plan.axes.add("cosine")
        values |= dict(zip(("axis_x", "axis_y", "axis_z"), directions.axis, strict=True))
        edges = np.array([-(math.sin(directions.half_angle) ** 2), 1.0])
        return values | {"mu_kind": layout.CONE} | _axis(plan, "mu", edges, strides["mu"])
    edges = directions.edges()
    is_world = directions.frame == "world"
    if plain_cosines(detector) is None and ("mu" in edges or "theta" in edges):
        plan.axes.add("cosine")
        bounds = edges["mu"] if "mu" in edges else np.cos(edges["theta"])[::-1]
        if "theta" in edges:
            bounds = np.where(np.abs(bounds) < 1e-16, 0.0, bounds)
        values |= {"mu_kind": layout.WORLD_COSINE if is_world else layout.LOCAL_COSINE}
        values |= _axis(plan, "mu", bounds, strides["mu"])
    if "phi" in edges:
        plan.axes.add("azimuth")
        local = layout.SPHERE_AZIMUTH if isinstance(shape, Sphere) else layout.FLAT_AZIMUTH
        values |= {"turn_kind": layout.WORLD_AZIMUTH if is_world else local}
        values |= _axis(plan, "turn", edges["phi"], strides["turn"])
    return values


def _position_axes(plan: Plan, detector: Detector, shape: Shape, strides: dict[str, int]) -> dict[str, float]:
    plan.axes.add("place")
    places = {Rectangle: layout.RECTANGLE_PLACE, Disk: layout.DISK_PLACE, Sphere: layout.SPHERE_PLACE}
    values, size = {"place": places[type(shape)]}, plan.space.size
    lengths = {Rectangle: ("u", "v"), Disk: ("u",), Sphere: ()}[type(shape)]
    for name in ("u", "v"):
        bounds = detector.positions.edges(shape).get(name)
        if bounds is None:
            bounds = np.array([-math.inf, math.inf])
        values |= _axis(plan, name, bounds / size if name in lengths else bounds, strides[name])
    return values


def _axis(plan: Plan, name: str, edges: np.ndarray, stride: int) -> dict[str, float]:
    """Columns of one axis; its edges are kept alive by the plan."""
    edges = np.ascontiguousarray(edges, np.float64)
    plan.edges.append(edges)
    return {f"{name}_cells": len(edges) - 1, f"{name}_edges": edges.ctypes.data, f"{name}_stride": stride}
