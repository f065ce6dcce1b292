"""Fill the tables of a plan for the steps that a scene needs, in scene lengths. No Numba here."""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np

from transport.compile import layout
from transport.compile.adjoint import adjoint_scene, fill_adjoint
from transport.compile.detectors import (
    detector_row,
    fill_long_scores,
    fill_phase_spaces,
    fill_snapshots,
    layer_row,
)
from transport.compile.media import default_tracking, fill_media
from transport.compile.meshes import mesh_table
from transport.compile.methods import ANALOG, Method
from transport.compile.next_event import fill_expected, fill_guards
from transport.compile.plan import Plan
from transport.compile.points import fill_points
from transport.compile.rows import Rows, phase_space_rows, side_rows, volume_rows
from transport.compile.sources import make_emitters
from transport.compile.space import make_space
from transport.compile.surfaces import (
    bounds_bodies,
    check_thin_shapes,
    covers_same_points,
    exterior_sides,
    outward_sign,
    quadric_columns,
    rim_row,
    rounding_of_crossings,
    shape_row,
    surface_rows,
    transparent_rows,
)
from transport.compile.volumes import fill_sizes, fill_volumes
from transport.geometry.contacts import contact_pairs
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Revolved
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.scene.scene import Scene
from transport.scene.sheets import Sheet, SheetMember, scene_sheets, source_sheets
from transport.scene.tracking import Tracking
from transport.validation import SceneError, short_repr

# [scene lengths] distance that a point keeps from a surface that cuts or touches its own surface
CLEARANCE = 2.0**-48
# [W or particles] bounds of the power of all sources, so that sums of scores stay normal numbers
MIN_POWER, MAX_POWER = 1e-300, 1e300
MAX_MARKS = 62  # bits of the word in which a lane records its visits


@lru_cache(maxsize=32)
def compile_scene(scene: Scene, tracking: Tracking | None = None, method: Method = ANALOG) -> Plan:
    """Return the plan of a scene.

    tracking: how absorption is treated, None for the default of the scene; method: the estimator and the
    sampling.
    Raise SceneError where the scene, or for estimator "backward" the adjoint scene, cannot be simulated.
    """
    if method.estimator != "backward":
        plan = _make_plan(scene, tracking, method)
    else:
        turned, lamps = adjoint_scene(scene)
        try:
            plan = _make_plan(turned, tracking, method)
        except SceneError as refusal:
            turning = "simulate: estimator 'backward' exchanges detectors and sources"
            raise SceneError(f"{turning}, and the exchanged scene is invalid: {refusal}") from refusal
        fill_adjoint(plan, scene, lamps)
    plan.freeze()
    return plan


def _make_plan(scene: Scene, tracking: Tracking | None, method: Method) -> Plan:
    """Return the plan of a scene as it stands, without exchanging sources and detectors."""
    # Find the sheets and the scene's own coordinates, and refuse shapes that rounding would distort.
    sheets = scene_sheets(scene)
    space = make_space(scene)
    check_thin_shapes(sheets, space)
    plan = Plan(scene, space, tracking or default_tracking(scene), method)
    # Fill media and emitters, which the tables of surfaces and detectors depend on.
    fill_media(plan)
    acting = {number for number, sheet in enumerate(sheets, 1) if sheet.members[0].surface is not None}
    plan.emitters = make_emitters(plan, lambda shape: source_sheets(shape, sheets), acting)
    power = sum(emitter.bound for emitter in plan.emitters)
    if not MIN_POWER <= power <= MAX_POWER:
        must = f"must be between {MIN_POWER:g} and {MAX_POWER:g}"
        raise SceneError(
            f"Scene: the power of all sources together {must}, got {power:.3g}; use another unit"
        )
    if len(sheets) >= 1 << 15:
        raise SceneError(
            f"Scene: at most 32767 supports (planes, spheres, cylinders, meshes ...), got {len(sheets)}"
        )
    # Fill sheets, surfaces and detectors.
    _fill_sheets(plan, sheets)
    if len(scene.visited) > MAX_MARKS:
        raise SceneError(f"Scene: via may name at most {MAX_MARKS} places, got {len(scene.visited)}")
    plan.marks = {name: 1 << bit for bit, name in enumerate(scene.visited)}
    _deal_out_rows(plan)
    _fill_members(plan, sheets)
    # Fill the tables of the other tallies; sizes of scores and guards come last.
    fill_expected(plan)
    fill_phase_spaces(plan)
    fill_snapshots(plan)
    fill_volumes(plan)
    fill_points(plan)
    fill_sizes(plan)
    fill_guards(plan, sheets)
    return plan


def _fill_sheets(plan: Plan, sheets: list[Sheet]) -> None:
    """Fill the tables of sheets: planes and spheres, quadrics, meshes. Row 0 stands for no sheet."""
    plan.sheets = np.zeros(len(sheets) + 1, layout.SHEET)
    plan.curved_sheets = np.zeros(len(sheets) + 1, layout.CURVED_SHEET)
    plan.meshed_sheets = np.zeros(len(sheets) + 1, layout.MESHED_SHEET)
    for number, sheet in enumerate(sheets, start=1):
        _fill_sheet(plan, number, sheet)


def _fill_sheet(plan: Plan, number: int, sheet: Sheet) -> None:
    """Fill the row of one sheet by its support."""
    support, space, row = sheet.support, plan.space, plan.sheets[number]
    if isinstance(support, Mesh):
        mesh_table(plan, support).rows.append(plan.meshed_sheets[number])
        return
    row["cx"], row["cy"], row["cz"] = space.place(support.center)
    if isinstance(support, Sphere):
        row["radius"] = support.radius / space.size
        row["curvature"] = space.size / support.radius
    elif isinstance(support, Revolved):
        columns = quadric_columns(support, space)
        kept = layout.known_columns(layout.CURVED_SHEET, columns)
        plan.curved_sheets[number] = layout.row(
            layout.CURVED_SHEET, **kept, narrows=support.profile.taper_sign(), is_curved=1
        )
    else:
        row["nx"], row["ny"], row["nz"] = support.normal
        row["outward"] = next(filter(None, (outward_sign(member, support) for member in sheet.members)), 0.0)


def _deal_out_rows(plan: Plan) -> None:
    """Give each tally its rows, one tally after the other; row 0 belongs to no detector.

    Arrivals at detectors come first, then departures, and then both again for shadow rays. Phase spaces,
    volumes and points follow.
    """
    scene, row = plan.scene, 1
    for detector in scene.meters:
        rows = side_rows(detector, scene.shape_of(detector), scene.duration, row)
        plan.rows_of[detector.name], row = rows, rows.past
    plan.half, row = row, row * (4 if plan.sends_shadow_rays else 2)
    fill_long_scores(plan)
    for phase_space in scene.phase_spaces:
        rows = phase_space_rows(phase_space, row)
        plan.rows_of[phase_space.name], row = rows, rows.past
        if phase_space.moments:
            plan.first_long_rows[phase_space.name] = plan.long_rows
            plan.long_rows += len(layout.VELOCITY_SUMS) * rows.count
    for volume in scene.volumes:
        rows = volume_rows(volume, scene.shape_of(volume), row)
        plan.rows_of[volume.name], row = rows, rows.past
        if plan.absorbing_media:
            plan.absorbed_rows_of[volume.name] = Rows(row, rows.outer, (), 1)
            row = plan.absorbed_rows_of[volume.name].past
    for point in scene.points:
        plan.rows_of[point.name] = Rows(row, (), (), layout.POINT_ROWS)
        row += layout.POINT_ROWS
    plan.rows = row


def _fill_members(plan: Plan, sheets: list[Sheet]) -> None:
    """Fill surfaces, rims, detectors and shape rows, member by member of each sheet."""
    rows, rims, detector_rows, layers = [transparent_rows()], [np.zeros((), layout.RIM)], [], []
    first_of_box, acting_members = _ties(sheets), []
    for number, sheet in enumerate(sheets, start=1):
        layer, covered = 0, []
        empty_sides = _exterior_bits(plan, sheet, sheets)
        for member in sheet.members:
            # Give each detector of the member a layer of the sheet, one bit of the hit word each.
            bits = empty_sides
            for entry in _member_layers(plan, member, detector_rows):
                if layer == layout.DETECTORS_PER_SHEET:
                    raise SceneError(
                        f"Scene: at most {layer} detectors may share one plane or sphere, got one more on"
                        f" {short_repr(member.shape)}; use one detector with positions=Positions(...) instead"
                    )
                if layer == len(layers):
                    layers.append(np.zeros(len(sheets) + 1, layout.LAYER))
                bits |= 1 << layer
                layers[layer][number] = entry
                layer += 1
            for shape in member.shape.primitives():
                part = replace(member, shape=shape)
                code = number << layout.SHEET_SHIFT | bits
                first = len(rows)
                # Give an acting surface its rows, and write the first and its material into the hit word.
                if part.surface is not None:
                    acting_members.append((number, first, part))
                    rows += surface_rows(plan, part)
                    plan.surface_numbers += [plan.scene.surfaces.index(part.surface)] * (len(rows) - first)
                    code |= first << layout.SURFACE_SHIFT
                    code |= int(rows[first][0]["material"]) << layout.MATERIAL_SHIFT
                    rims += [rim_row(plan, part)] * (len(rows) - first)
                # Add the bits to the row of a part that covers the same points, or make a new shape row.
                twin = next((row for other, row in covered if covers_same_points(other, part)), None)
                if twin is not None:
                    twin["code"] |= code
                    continue
                name, row = shape_row(plan, part, sheet, code, number)
                covered.append((part, row))
                if "tie" in row.dtype.names:
                    row["tie"] = first_of_box[number]
                verb = "cover" if part.surface is None else "meet"
                if verb == "cover" and name == "triangle":
                    row["slack"] = rounding_of_crossings(shape, plan.space)
                    for side, is_inner in zip("abc", member.shape.inner_sides(shape), strict=True):
                        row[f"reach_{side}"] *= is_inner
                if part.surface is None and name == "rectangle" and bounds_bodies(part):
                    verb = "bound"
                plan.members.append((f"{verb}_{name}", row, shape))
    # Turn the lists into arrays.
    if len(rows) - 1 > layout.SURFACE_MASK:
        raise SceneError(f"Scene: at most {layout.SURFACE_MASK} acting surfaces, got {len(rows) - 1}")
    plan.surfaces = np.array([surface for surface, _ in rows], layout.SURFACE)
    plan.optics = np.array([optics for _, optics in rows], layout.OPTICS)
    plan.rims = np.array(rims, layout.RIM)
    _fill_contacts(plan, acting_members)
    plan.layers, plan.detectors = layers, np.array(detector_rows, layout.DETECTOR)


def _exterior_bits(plan: Plan, sheet: Sheet, sheets: list[Sheet]) -> int:
    """Return the hit bits of a sheet's empty sides; 0 where the plan cannot use them."""
    if not plan.can_escape_at_once:
        return 0
    before, behind = exterior_sides(sheet, sheets)
    return (layout.EMPTY_FRONT if before else 0) | (layout.EMPTY_BACK if behind else 0)


def _ties(sheets: list[Sheet]) -> dict[int, int]:
    """Map each sheet to its number, or to the first sheet of a box that has a face on it.

    A ray that crosses an edge of a box thereby meets the box once.
    """
    first: dict[Shape, int] = {}
    for number, sheet in enumerate(sheets, start=1):
        for member in sheet.members:
            first.setdefault(member.whole, number)
    return {
        number: min(first[member.whole] for member in sheet.members if member.whole is not None)
        for number, sheet in enumerate(sheets, start=1)
    }


def _member_layers(plan: Plan, member: SheetMember, detectors: list[np.ndarray]) -> Iterator[np.ndarray]:
    """Yield the layers of a member: its detectors, a visit mark alone, the bodies that it bounds.

    Rows of its detectors are appended to `detectors`.
    """
    for detector in member.detectors:
        yield layer_row(plan, member, detector, len(detectors))
        detectors.append(detector_row(plan, member, detector))
        plan.detector_names.append(detector.name)
    if member.mark in plan.marks and member.mark not in [detector.name for detector in member.detectors]:
        yield layout.row(layout.LAYER, mark=plan.marks[member.mark])
    if member.bodies[0] != member.bodies[1]:
        front, back = member.bodies if member.orientation > 0 else member.bodies[::-1]
        yield layout.row(layout.LAYER, front=front, back=back)


def _fill_contacts(plan: Plan, acting: list[tuple[int, int, SheetMember]]) -> None:
    """Add rows of the surfaces that cut or touch the interior of another surface.

    acting: sheet number, first surface row and member of each acting surface.
    """
    for hit, other in contact_pairs([member.shape for _, _, member in acting]):
        (sheet_hit, first, _), (sheet, _, member) = acting[hit], acting[other]
        if sheet_hit == sheet:
            continue
        shape, size = member.shape, plan.space.size
        reach = CLEARANCE + 2.0**-50 * sum(map(abs, shape.center)) / size
        values = layout.center_columns(plan.space.place(shape.center)) | {
            "reach": reach,
            "surface": first,
            "sheet": sheet,
        }
        if isinstance(shape, Revolved):
            columns = quadric_columns(shape, plan.space)
            values |= {name: columns[name] for name in ("cx", "cy", "cz", "alpha", "beta", "gamma")}
            values |= layout.vector_columns("n", shape.axis)
        else:
            values |= layout.vector_columns("n", shape.normal) | {"is_plane": 1}
        plan.contacts.append(layout.row(layout.CONTACT, **values))
