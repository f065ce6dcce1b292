"""A scene becomes a plan: tables in scene lengths for just the steps that it calls for.  No Numba here."""

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from transport.compile import layout
from transport.compile.contacts import contacts_of
from transport.compile.emitters import emitters_of, triangle_columns
from transport.compile.instants import fill_phase_spaces, fill_snapshots
from transport.compile.looks import bin_counts, block_rows, is_blocked, layer_row, meter_row
from transport.compile.plan import Plan
from transport.compile.quantile_tables import constant_quantile, quantile_row
from transport.compile.space import Space, space_of
from transport.materials import Black, Diffuse, Material, Mirror, Mixture, Transparent
from transport.scene import Scene
from transport.scene_speeds import parts_of, scene_speeds
from transport.shapes import Box, Disk, Rectangle, Shape, Sphere, Triangle
from transport.sheets import Member, Sheet, sheets_of, sheets_of_source
from transport.speeds import SpeedDistribution
from transport.validation import SceneError, shown
from transport.vectors import dot

# Within 32 roundings of a coordinate from an edge [scene lengths] a point is drawn back.
SETBACK = 2.0**-48
MOST_MARKS = 62  # bits of a history


@lru_cache(maxsize=32)
def compile_scene(scene: Scene) -> Plan:
    """The plan of a scene."""
    sheets = sheets_of(scene)
    space = space_of(scene)
    plan = Plan(scene, space)
    acting = {number for number, sheet in enumerate(sheets, 1) if sheet.members[0].surface is not None}
    plan.emitters = emitters_of(plan, lambda shape: sheets_of_source(shape, sheets), acting)
    if not 0 < sum(emitter.bound for emitter in plan.emitters) < math.inf:
        raise SceneError(
            "Scene: the power of all sources together must be a finite number; use a larger unit"
        )
    if len(sheets) >= 1 << 15:
        raise SceneError(f"Scene: at most 32767 planes and spheres, got {len(sheets)}")
    plan.sheets = np.zeros(len(sheets) + 1, layout.SHEET)
    for number, sheet in enumerate(sheets, start=1):
        _fill_sheet(plan.sheets[number], sheet, space)
    if len(scene.visited) > MOST_MARKS:
        raise SceneError(f"Scene: via may name at most {MOST_MARKS} places, got {len(scene.visited)}")
    plan.marks = {name: 1 << bit for bit, name in enumerate(scene.visited)}
    _number_rows(plan)
    _fill_members(plan, sheets)
    _fill_moments(plan)
    fill_phase_spaces(plan)
    fill_snapshots(plan)
    return plan


def _fill_sheet(row: np.void, sheet: Sheet, space: Space) -> None:
    support = sheet.support
    row["cx"], row["cy"], row["cz"] = space.place(support.center)
    if isinstance(support, Sphere):
        row["radius"] = support.radius / space.size
        row["curvature"] = space.size / support.radius
    else:
        row["nx"], row["ny"], row["nz"] = support.normal
        row["outward"] = next(filter(None, (outward_of(member, support) for member in sheet.members)), 0.0)


def _number_rows(plan: Plan) -> None:
    """Each detector has blocks of rows (looks.bin_counts); row 0 of all is nobody's."""
    row = 1
    for detector in plan.scene.meters:
        plan.bases[detector.name] = row
        counts = bin_counts(detector, plan.scene.shape_of(detector), plan.scene.duration)
        row += block_rows(counts) * counts["time"] * counts["speed"] + is_blocked(detector)
    plan.half = row


def _fill_moments(plan: Plan) -> None:
    """Where a detector takes moments, three rows of velocity sums for each row of the meters."""
    if not any(detector.moments for detector in plan.scene.meters):
        return
    slowest = min((v for v in scene_speeds(plan.scene) if isinstance(v, float) and v > 0), default=0.0)
    is_light = plan.scene.measured_in == "watts"
    plan.moments = layout.row(
        layout.MOMENTS,
        fastest=plan.fastest / plan.speed_unit,
        slowest=slowest / plan.speed_unit,
        is_light=is_light,
    )
    plan.long_rows = 3 * 2 * plan.half


def _fill_members(plan: Plan, sheets: list[Sheet]) -> None:
    surfaces, walls, meters, layers = (
        [_surface_row(plan, Transparent())],
        [np.zeros((), layout.RECTANGLE)],
        [],
        [],
    )
    ties = _ties(sheets)
    for number, sheet in enumerate(sheets, start=1):
        layer = 0
        for member in sheet.members:
            code = number << layout.SHEET_SHIFT
            first = len(surfaces)
            if member.surface is not None:
                surfaces += _surface_rows(plan, member.surface.material)
                plan.owners += [plan.scene.surfaces.index(member.surface)] * (len(surfaces) - first)
                code |= first << layout.SURFACE_SHIFT
                code |= int(surfaces[first]["material"]) << layout.MATERIAL_SHIFT
            for look in _looks(plan, member, meters):
                if layer == layout.METERS_A_SHEET:
                    raise SceneError(
                        f"Scene: at most {layer} detectors lie on one plane or sphere, got one more on that of"
                        f" {shown(member.shape)}; bin one detector by positions=Positions(...) instead"
                    )
                if layer == len(layers):
                    layers.append(np.zeros(len(sheets) + 1, layout.LAYER))
                code |= 1 << layer
                layers[layer][number] = look
                layer += 1
            row = _member_row(member, plan.space, code, number)
            _share_plane(row, member, sheet, plan.space)
            if "tie" in row.dtype.names:
                row["tie"] = ties[number]
            verb = "cover" if member.surface is None else "meet"
            plan.members.append((f"{verb}_{type(member.shape).__name__.lower()}", row, member.shape))
            walls += [row if isinstance(member.shape, Rectangle) else walls[0]] * (len(surfaces) - first)
    if len(surfaces) - 1 > layout.SURFACE_MASK:
        raise SceneError(f"Scene: at most {layout.SURFACE_MASK} acting surfaces, got {len(surfaces) - 1}")
    plan.surfaces, plan.walls = np.array(surfaces, layout.SURFACE), np.array(walls, layout.RECTANGLE)
    _fill_contacts(plan, sheets)
    plan.layers, plan.meters = layers, np.array(meters, layout.METER)


def outward_of(member: Member, flat: Shape) -> float:
    """Whether a box's face points the way of that flat shape's normal: +1, or -1; 0 for what is no meter's."""
    if not isinstance(member.whole, Box) or member.surface is not None:
        return 0.0
    return math.copysign(1.0, dot(member.shape.normal, flat.normal))


def _ties(sheets: list[Sheet]) -> dict[int, int]:
    """For each sheet its number, or the first one's of a box of which it holds a face: one box is met once at its edges."""
    first: dict[Shape, int] = {}
    for number, sheet in enumerate(sheets, start=1):
        for member in sheet.members:
            first.setdefault(member.whole, number)
    return {
        number: min(first[member.whole] for member in sheet.members if member.whole is not None)
        for number, sheet in enumerate(sheets, start=1)
    }


def _looks(plan: Plan, member: Member, meters: list[np.ndarray]) -> Iterator[np.ndarray]:
    """The layers that a member takes up: its detectors, whose rows `meters` learns, and a mark alone."""
    for detector in member.detectors:
        yield layer_row(plan, member, detector, len(meters))
        meters.append(meter_row(plan, member, detector))
    if member.mark in plan.marks and member.mark not in [detector.name for detector in member.detectors]:
        yield layout.row(layout.LAYER, mark=plan.marks[member.mark])


def _fill_contacts(plan: Plan, sheets: list[Sheet]) -> None:
    """Rows of the surfaces that cut or touch the inside of another one; acting members are numbered as `surfaces` are."""
    acting = [
        (number, m) for number, sheet in enumerate(sheets, 1) for m in sheet.members if m.surface is not None
    ]
    first_rows, row = [], 1
    for _, member in acting:
        first_rows.append(row)
        row += len(parts_of(member.surface.material))
    for hit, other in contacts_of([member for _, member in acting]):
        (sheet_hit, _), (sheet, member) = acting[hit], acting[other]
        if sheet_hit == sheet:
            continue
        shape, size = member.shape, plan.space.size
        reach = SETBACK + 2.0**-50 * sum(map(abs, shape.center)) / size
        values = layout.center_columns(plan.space.place(shape.center)) | {
            "reach": reach,
            "surface": first_rows[hit],
            "sheet": sheet,
        }
        if isinstance(shape, Sphere):
            values["radius"] = shape.radius / size
        else:
            values |= dict(zip(("nx", "ny", "nz"), shape.normal, strict=True))
        plan.contacts.append(layout.row(layout.CONTACT, **values))


def _surface_rows(plan: Plan, material: Material) -> list[np.ndarray]:
    """A row, or for a mixture one for each part, with the shares added up."""
    if not isinstance(material, Mixture):
        return [_surface_row(plan, material)]
    shares = np.cumsum([share for _, share in material.parts])
    rows = [_surface_row(plan, part) for part, _ in material.parts]
    for row, share in zip(rows, shares, strict=True):
        row["share"], row["parts"] = share, len(rows)
    return rows


def _surface_row(plan: Plan, material: Material) -> np.ndarray:
    match material:
        case Transparent():
            return layout.row(layout.SURFACE, material=layout.TRANSPARENT, albedo=1.0)
        case Black() | Diffuse(albedo=0.0) | Mirror(reflectance=0.0):
            return layout.row(layout.SURFACE, material=layout.BLACK, albedo=0.0)
        case Diffuse(albedo=albedo, speed=speed):
            quantiles = 0 if speed is None or not plan.has_speeds else _wall_speeds(plan, speed)
            return layout.row(layout.SURFACE, material=layout.DIFFUSE, albedo=albedo, quantiles=quantiles)
        case Mirror(reflectance=reflectance):
            return layout.row(layout.SURFACE, material=layout.MIRROR, albedo=reflectance)
    raise SceneError(f"Surface: no engine for {shown(material)}")


def _wall_speeds(plan: Plan, speed: float | SpeedDistribution) -> int:
    """Address of a row by which speeds are drawn as they leave a wall: weighted by the speed."""
    quantile = constant_quantile(speed) if isinstance(speed, float) else speed.flux_quantile
    row = quantile_row(plan, quantile)
    plan.kept.append(row)
    return row.ctypes.data


def _share_plane(row: np.ndarray, member: Member, sheet: Sheet, space: Space) -> None:
    """The one point and normal by which all flat meters of a sheet are met: those of its smallest member.

    Each by its own would put them a rounding apart, and what crosses there could pass between them, or one of them twice.
    """
    if "sx" in row.dtype.names:
        finest = min((member.shape for member in sheet.members), key=lambda shape: shape.extent)
        row["sx"], row["sy"], row["sz"] = space.place(finest.center)
        if "outward" in row.dtype.names:
            row["outward"] = outward_of(member, finest)
        is_meter = (int(row["code"]) >> layout.SURFACE_SHIFT) & layout.SURFACE_MASK == 0
        if is_meter:
            row["nx"], row["ny"], row["nz"] = finest.normal


def _member_row(member: Member, space: Space, code: int, sheet: int) -> np.ndarray:
    shape = member.shape
    values = layout.center_columns(space.place(shape.center)) | {"code": code, "sheet": sheet}
    if isinstance(shape, Sphere):
        return layout.row(layout.SPHERE, **values, radius=shape.radius / space.size)
    acts = member.surface is not None
    if isinstance(shape, Triangle):
        columns = triangle_columns(shape, space) | values
        corner = {name: columns[name] for name in layout.TRIANGLE.names if name in columns}
        return layout.row(layout.TRIANGLE, **corner | layout.center_columns(space.place(shape.vertices[0])))
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
