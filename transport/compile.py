"""A scene becomes a plan: tables in scene lengths for just the steps that it calls for.  No Numba here."""

import math
from functools import lru_cache

import numpy as np

from transport import layout
from transport.crossings import crossings_of
from transport.emitters import emitters_of
from transport.looks import bin_counts, layer_row, meter_row
from transport.materials import Black, Diffuse, Mirror
from transport.plan import Plan
from transport.scene import Scene
from transport.shapes import Disk, Rectangle, Sphere
from transport.sheets import Member, Sheet, sheet_of_source, sheets_of
from transport.space import Space, space_of
from transport.validation import SceneError

# Within 32 roundings of a coordinate from an edge [scene lengths] a point is drawn back.
SETBACK = 2.0**-48


@lru_cache(maxsize=32)
def compile_scene(scene: Scene) -> Plan:
    """The plan of a scene."""
    sheets = sheets_of(scene)
    space = space_of(scene)
    plan = Plan(scene, space, emitters_of(scene, space, lambda shape: sheet_of_source(shape, sheets)))
    if not 0 < sum(emitter.bound for emitter in plan.emitters) < math.inf:
        raise SceneError(
            "Scene: the power of all sources together must be a finite number; use a larger unit"
        )
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
                layers[layer][number] = layer_row(plan, member, detector, len(meters))
                meters.append(meter_row(plan, member, detector))
                layer += 1
            row = _member_row(member, plan.space, code, number)
            verb = "cover" if member.surface is None else "meet"
            plan.members.append((f"{verb}_{type(member.shape).__name__.lower()}", row, member.shape))
            if member.surface is not None:
                walls.append(row if isinstance(member.shape, Rectangle) else walls[0])
    if len(surfaces) - 1 > layout.SURFACE_MASK:
        raise SceneError(f"Scene: at most {layout.SURFACE_MASK} acting surfaces, got {len(surfaces) - 1}")
    _fill_crossings(plan, sheets)
    plan.surfaces, plan.walls = np.array(surfaces, layout.SURFACE), np.array(walls, layout.RECTANGLE)
    plan.layers, plan.meters = layers, np.array(meters, layout.METER)


def _fill_crossings(plan: Plan, sheets: list[Sheet]) -> None:
    """Rows of the surfaces that cut or touch the inside of another one; acting members are numbered as `surfaces` are."""
    acting = [
        (number, m) for number, sheet in enumerate(sheets, 1) for m in sheet.members if m.surface is not None
    ]
    for hit, other in crossings_of([member for _, member in acting]):
        (sheet_hit, _), (sheet, member) = acting[hit], acting[other]
        if sheet_hit == sheet:
            continue
        shape, size = member.shape, plan.space.size
        reach = SETBACK + 2.0**-50 * sum(map(abs, shape.center)) / size
        values = layout.center_columns(plan.space.place(shape.center)) | {
            "reach": reach,
            "surface": hit + 1,
            "sheet": sheet,
        }
        if isinstance(shape, Sphere):
            values["radius"] = shape.radius / size
        else:
            values |= dict(zip(("nx", "ny", "nz"), shape.normal, strict=True))
        plan.crossings.append(layout.row(layout.CROSSING, **values))


def _surface_row(member: Member) -> np.ndarray:
    match member.surface.material:
        case Black() | Diffuse(albedo=0.0) | Mirror(reflectance=0.0):
            return layout.row(layout.SURFACE, material=layout.BLACK, albedo=0.0)
        case Diffuse(albedo=albedo):
            return layout.row(layout.SURFACE, material=layout.DIFFUSE, albedo=albedo)
        case Mirror(reflectance=reflectance):
            return layout.row(layout.SURFACE, material=layout.MIRROR, albedo=reflectance)
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
