"""Lower surfaces: sheets, shapes that rays are intersected with, materials, and edges that clamp points."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.gloss import lobe_peak
from transport.compile.shapes import (
    aligned_axis,
    point_to_mesh,
    primitive_of,
    revolved_columns,
    rounding_of_crossings,
    shape_columns,
)
from transport.compile.space import Space
from transport.compile.speeds import Quantile, constant_quantile, quantile_row
from transport.geometry.contacts import contact_pairs
from transport.geometry.flat import FlatShape
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Revolved
from transport.geometry.shape import Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.materials import OPTICAL_COLUMNS, Material
from transport.scene.sheets import Sheet, SheetMember, members_by_side
from transport.scene.speeds import SpeedDistribution
from transport.statistics.microfacet_lobe import lobe_quantile
from transport.validation import SceneError, refuse
from transport.vectors import dot

if TYPE_CHECKING:
    from transport.compile.plan import Plan

# [scene lengths] distance that a point keeps from a surface that cuts or touches its own surface
CLEARANCE = 2.0**-48

SurfaceRow = tuple[np.ndarray, np.ndarray]  # of layout.SURFACE and layout.OPTICS


def lower_surfaces(plan: Plan, sheets: list[Sheet], layer_bits: list[list[int]]) -> None:
    """Fill the tables of sheets, of the acting surfaces on them, and of all shapes that rays may meet.

    layer_bits: by sheet and member, the bits of its layers in `covered` (detectors.lower_detectors).
    """
    _fill_sheets(plan, sheets)
    rows, rims, acting = [_transparent_row()], [layout.row(layout.RIM)], []
    first_of_box, exterior_bits = _ties(sheets), _exterior_bits(plan, sheets)
    surface_numbers = {surface: number for number, surface in enumerate(plan.scene.surfaces)}
    for number, (sheet, bits_of_members) in enumerate(zip(sheets, layer_bits, strict=True), start=1):
        covered: list[tuple[SheetMember, np.ndarray]] = []
        acting_rows: dict[tuple[int, Shape], int] = {}
        exterior, finest = exterior_bits[number - 1], min((m.shape for m in sheet.members), key=_extent)
        sides = members_by_side(sheet)
        shares_plane = any(side != 0 for _, side in sides)
        for which, side in sides:
            member, bits = sheet.members[which], bits_of_members[which]
            for shape in member.shape.primitives():
                part, hit = replace(member, shape=shape), layout.hit_word(number)
                # Give an acting surface its rows, and write the first and its material into the word of hits.
                if part.surface is not None:
                    if (which, shape) not in acting_rows:
                        acting_rows[which, shape] = len(rows)
                        new = surface_rows(plan, part)
                        acting.append((number, len(rows), part))
                        rows += new
                        rims += [_rim_row(part, plan.space)] * len(new)
                        plan.surface_numbers += [surface_numbers[part.surface]] * len(new)
                    first = acting_rows[which, shape]
                    hit = layout.hit_word(number, first, int(rows[first][0]["material"]))
                # Add the bits to the row of a part that covers the same points, or make a new shape row.
                others = covered if part.surface is None and not shares_plane else ()
                twin = next((row for other, row in others if covers_same_points(other, part)), None)
                if twin is not None:
                    twin["hit"] |= hit
                    twin["covers"] |= exterior | bits
                    continue
                name, row = _shape_row(plan, part, member.shape, finest, number)
                if part.surface is not None and shares_plane:
                    name, row["side"] = f"meet_{primitive_of(shape).name}_on_side", side
                row["hit"], row["covers"] = hit, exterior | bits
                covered.append((part, row))
                if "tie" in row.dtype.names:
                    row["tie"] = first_of_box[number]
                plan.members.append((name, row, shape))
    # Turn the lists into arrays.
    if len(rows) - 1 > layout.MAX_SURFACES:
        raise SceneError(f"Scene: at most {layout.MAX_SURFACES} acting surfaces, got {len(rows) - 1}")
    plan.surfaces = np.array([surface for surface, _ in rows], layout.SURFACE)
    plan.optics = np.array([optics for _, optics in rows], layout.OPTICS)
    plan.rims = np.array(rims, layout.RIM)
    _fill_contacts(plan, acting)


# ---- Sheets, and the rows of the shapes on them.


def _fill_sheets(plan: Plan, sheets: list[Sheet]) -> None:
    """Fill the tables of sheets: planes and spheres, quadrics, meshes. Row 0 stands for no sheet."""
    if len(sheets) > layout.MAX_SHEETS:
        what = "supports (planes, spheres, cylinders, meshes ...)"
        raise SceneError(f"Scene: at most {layout.MAX_SHEETS} {what}, got {len(sheets)}")
    plan.sheets = np.zeros(len(sheets) + 1, layout.SHEET)
    plan.curved_sheets = np.zeros(len(sheets) + 1, layout.CURVED_SHEET)
    plan.meshed_sheets = [layout.row(layout.MESHED_SHEET)] * (len(sheets) + 1)
    for number, sheet in enumerate(sheets, start=1):
        support, space = sheet.support, plan.space
        if isinstance(support, Mesh):
            row = layout.row(layout.MESHED_SHEET)
            plan.meshed_sheets[number] = point_to_mesh(plan, support, row)
            continue
        center = layout.center_columns(space.place(support.center))
        if isinstance(support, Sphere):
            curve = {"radius": support.radius / space.size, "curvature": space.size / support.radius}
        elif isinstance(support, Revolved):
            columns, narrows = revolved_columns(support, space), support.profile.taper_sign()
            row = layout.row(layout.CURVED_SHEET, columns, narrows=narrows, is_curved=1)
            plan.curved_sheets[number], curve = row, {}
        else:
            outward = next(filter(None, (outward_sign(member, support) for member in sheet.members)), 0.0)
            curve = layout.vector_columns("n", support.normal) | {"outward": outward}
        plan.sheets[number] = layout.row(layout.SHEET, center | curve)


def _shape_row(
    plan: Plan, part: SheetMember, whole: Shape, finest: Shape, number: int
) -> tuple[str, np.ndarray]:
    """Return the pass and the row by which rays are intersected with a part of a member's whole shape.

    finest: smallest shape of the sheet, with this number.
    """
    shape, space, name = part.shape, plan.space, primitive_of(part.shape).name
    columns = shape_columns(shape, space, edge_slack(part, space))
    row = layout.row(getattr(layout, name.upper()), columns, sheet=number)
    if isinstance(shape, Mesh):
        point_to_mesh(plan, shape, row)
    _share_plane(row, part, finest, space)
    along = ""
    if name == "rectangle" and (axis := aligned_axis(shape)) is not None:
        along = "_" + "xyz"[axis]
    if part.surface is not None:
        return f"meet_{name}{along}", row
    if name == "triangle":
        row["slack"] = rounding_of_crossings(shape, space)
        for side, is_inner in zip("abc", whole.inner_sides(shape), strict=True):
            row[f"reach_{side}"] *= is_inner
    is_boundary = name == "rectangle" and bounds_bodies(part)
    return f"bound_{name}" if is_boundary else f"cover_{name}{along}", row


def _share_plane(row: np.ndarray, member: SheetMember, finest: Shape, space: Space) -> None:
    """Set all flat members of a sheet to the point of the smallest one, and detectors to its normal.

    With planes of their own they would lie a rounding apart, and a particle that crosses there could miss
    both or hit one twice.
    """
    if "sx" in row.dtype.names:
        row["sx"], row["sy"], row["sz"] = space.place(finest.center)
        if "outward" in row.dtype.names:
            row["outward"] = outward_sign(member, finest)
        if member.surface is None:
            row["nx"], row["ny"], row["nz"] = finest.normal


def outward_sign(member: SheetMember, flat: Shape) -> float:
    """Return +1 (-1) where a box's face points along (against) a normal; 0 for other members."""
    if not isinstance(member.whole, Box) or member.surface is not None:
        return 0.0
    return math.copysign(1.0, dot(member.shape.normal, flat.normal))


def covers_same_points(one: SheetMember, other: SheetMember) -> bool:
    """Return whether a member of a sheet and another, which does not act, cover the same points.

    One pass then finds both.
    """
    if one.shape.is_plane and other.shape.is_plane:
        return True
    same = one.shape == other.shape and one.whole == other.whole
    return same and one.surface is None and bounds_bodies(one) == bounds_bodies(other)


def _extent(shape: Shape) -> float:
    return shape.extent


def bounds_bodies(member: SheetMember) -> bool:
    """Return whether the member is a boundary of media."""
    return member.bodies[0] != member.bodies[1]


def edge_slack(member: SheetMember, space: Space) -> float:
    """Return how far a member reaches over its edges [scene lengths], so that closed boxes do not leak.

    It bounds the rounding of a crossing's coordinates and of the coordinates given by the user; 0 for members
    that neither act nor bound a body.
    """
    shape = member.shape
    if shape.is_infinite or (member.surface is None and not bounds_bodies(member)):
        return 0.0
    return rounding_of_crossings(shape, space)


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


def _rim_row(part: SheetMember, space: Space) -> np.ndarray:
    """Return the row of a member's edges, which clamp points that landed within rounding of them."""
    form = primitive_of(part.shape).rim
    if form == 0:
        return layout.row(layout.RIM)
    columns = shape_columns(part.shape, space, edge_slack(part, space))
    if form == layout.QUADRIC_RIM:
        columns |= {"low": columns["inner_low"], "high": columns["inner_high"]}
    return layout.row(layout.RIM, columns, form=form)


def _fill_contacts(plan: Plan, acting: list[tuple[int, int, SheetMember]]) -> None:
    """Add rows of the surfaces that cut or touch the interior of another surface.

    acting: sheet number, first surface row and member of each acting surface.
    """
    for hit, other in contact_pairs([member.shape for _, _, member in acting]):
        (sheet_hit, first, _), (sheet, _, member) = acting[hit], acting[other]
        if sheet_hit == sheet:
            continue
        shape, space = member.shape, plan.space
        reach, is_plane = CLEARANCE + 2.0**-50 * sum(map(abs, shape.center)) / space.size, False
        if isinstance(shape, Revolved):
            columns = revolved_columns(shape, space)
        else:
            center, is_plane = space.place(shape.center), True
            columns = layout.center_columns(center) | layout.vector_columns("n", shape.normal)
        values = {"reach": reach, "surface": first, "sheet": sheet, "is_plane": is_plane}
        plan.contacts.append(layout.row(layout.CONTACT, columns, **values))


# ---- Find the empty sides of sheets: a particle that leaves there has escaped without another flight.

PARALLEL_TOLERANCE = 1e-15
FEW_SHAPES = 64  # looked at first: in most scenes some lie on either side of a plane


def _exterior_bits(plan: Plan, sheets: list[Sheet]) -> list[int]:
    """Return the hit bits of each sheet's empty sides; 0 where the plan cannot use them."""
    if not plan.can_escape_at_once:
        return [0] * len(sheets)
    return [
        (layout.EMPTY_FRONT if before else 0) | (layout.EMPTY_BACK if behind else 0)
        for before, behind in exterior_sides(sheets)
    ]


def exterior_sides(sheets: list[Sheet]) -> Iterator[tuple[bool, bool]]:
    """Yield whether the front and the back side of each sheet are empty (exact, without tolerance)."""
    shapes = [(number, member.shape) for number, sheet in enumerate(sheets) for member in sheet.members]
    finite = [(number, shape.bounds_corners()) for number, shape in shapes if not shape.is_infinite]
    random.Random(0).shuffle(finite)  # neighbours often lie on the same side of a plane
    owners = np.array([number for number, _ in finite], int)
    corners = np.array([corners for _, corners in finite]).reshape(-1, 8, 3)
    infinite = [(number, shape) for number, shape in shapes if shape.is_infinite]
    for number, sheet in enumerate(sheets):
        support = sheet.support
        if support.is_flat:
            endless = [shape for owner, shape in infinite if owner != number]
            yield _empty_sides(support, endless, corners, owners != number)
        else:
            others = (shape for owner, shape in shapes if owner != number)
            yield support.is_convex and all(_is_within(support, shape) for shape in others), False


def _empty_sides(
    flat: FlatShape, endless: list[Shape], corners: np.ndarray, is_other: np.ndarray
) -> tuple[bool, bool]:
    """Return whether nothing reaches beyond a plane on its front and its back side.

    endless: infinite shapes; corners: those (n, 8, 3) [m] of finite ones, of which those of the plane itself
    do not count.
    """
    normal, center = np.array(flat.normal), np.array(flat.center)
    highest, lowest = 0.0, 0.0
    for shape in endless:
        is_parallel = shape.is_plane and abs(dot(shape.normal, flat.normal)) >= 1 - PARALLEL_TOLERANCE
        height = (np.array(shape.center) - center) @ normal if is_parallel else math.inf
        highest, lowest = max(highest, height), min(lowest, height if is_parallel else -math.inf)
    # Look at more and more shapes until some lie on either side.
    seen, past = 0, FEW_SHAPES
    while seen < len(corners) and (highest <= 0.0 or lowest >= 0.0):
        heights = (corners[seen:past][is_other[seen:past]] - center) @ normal
        highest, lowest = heights.max(initial=highest), heights.min(initial=lowest)
        seen, past = past, 8 * past
    return bool(highest <= 0.0), bool(lowest >= 0.0)


def _is_within(ball: Sphere, shape: Shape) -> bool:
    if shape.is_infinite:
        return False
    if isinstance(shape, Sphere):
        apart = float(np.linalg.norm(np.array(shape.center) - np.array(ball.center)))
        return apart + shape.radius <= ball.radius
    reach = np.linalg.norm(np.array(shape.bounds_corners()) - np.array(ball.center), axis=1)
    return bool((reach <= ball.radius).all())


# ---- Rows of acting surfaces: the material of each part and each side, with its optical properties.


def _transparent_row() -> SurfaceRow:
    """Return the row of a transparent surface."""
    surface = layout.row(layout.SURFACE, material=layout.TRANSPARENT, albedo=1.0)
    return surface, layout.row(layout.OPTICS, side=1.0, ratio=1.0)


def surface_rows(plan: Plan, member: SheetMember) -> list[SurfaceRow]:
    """Return the rows of an acting member: front, then back where the two differ."""
    front, back = member.surface.material.sides
    rows = _side_rows(plan, front, member)
    if back is not front:
        rows[0][0]["back"] = len(rows)
        rows += _side_rows(plan, back, member)
    return rows


def _side_rows(plan: Plan, material: Material, member: SheetMember) -> list[SurfaceRow]:
    """Return one row per elementary material of a side, with cumulative shares."""
    parts, total, rows = material.weighted_parts, 0.0, []
    for part, share in parts:
        total += share
        surface, optics = _material_row(plan, part, member)
        surface["share"], surface["parts"] = total, len(parts)
        rows.append((surface, optics))
    return rows


def _material_row(plan: Plan, material: Material, member: SheetMember) -> SurfaceRow:
    """Return the row of an elementary material."""
    row = material.row()
    code = layout.INTERACTIONS.index(row.interaction)
    surface = layout.row(layout.SURFACE, material=code, albedo=row.albedo)
    named = {name: getattr(row, name) for name in OPTICAL_COLUMNS}
    optics = layout.row(layout.OPTICS, side=member.orientation, **named)
    if row.albedo_law is not None:
        plan.albedo_laws.add(row.albedo_law)
    if row.focal_length < math.inf:
        optics["cx"], optics["cy"], optics["cz"] = plan.space.place(member.shape.center)
        optics["power"] = plan.space.size / row.focal_length
    if row.roughness > 0:
        lobe = quantile_row(plan, _microfacet_quantile(row.roughness), unit=1.0)
        optics["lobe"] = plan.arena.place(lobe)
        optics["lobe_peak"] = lobe_peak(row.roughness) if material.shares.glossy > 0 else 0.0
    if material.speed is not None and row.albedo > 0 and plan.has_speeds:
        surface["quantiles"] = _wall_speed_table(plan, material.speed)
    return surface, optics


def _wall_speed_table(plan: Plan, speed: float | SpeedDistribution) -> int:
    """Return the offset of the quantile table of speeds leaving a wall (weighted by the speed)."""
    quantile = constant_quantile(speed) if isinstance(speed, float) else speed.flux_quantile
    return plan.arena.place(quantile_row(plan, quantile))


@lru_cache(maxsize=64)
def _microfacet_quantile(roughness: float) -> Quantile:
    """Return the quantile function of the microfacet lobe's cosine; one object per roughness."""
    return lambda u: lobe_quantile(u, roughness)


# ---- Refuse surfaces so thin that rounding would distort them.
#
# An acting surface reaches over its edges by the rounding of what lands there, so that closed boxes do not
# leak (surfaces.edge_slack).
# For a flat surface of aspect ratio 1e8 that is 1e-7 of its width; for 1e14 it would be one half, unnoticed.
# Light along a thin fibre meets its sides at an angle of radius over length, which magnifies the rounding of
# a position along the fibre. Once that reaches the fibre's length, chance decides whether light is in the
# glass.

MAX_WIDENING = 2.0**-11  # of the width on each side: a flux that is 0.1 % off


def check_thin_shapes(sheets: list[Sheet], space: Space) -> None:
    """Raise SceneError for a surface too narrow for its position.

    Faces of a box bound one another and need no check.
    """
    for sheet in sheets:
        for member in sheet.members:
            if member.surface is not None and member.whole in (None, member.shape):
                _check_width(member, space)


def _check_width(member: SheetMember, space: Space) -> None:
    is_tube = isinstance(member.shape, Revolved) and not isinstance(member.shape, Sphere)
    if is_tube and member.surface.material.bounds_media:
        _check_fibre(member, space)
    width, slack = member.shape.least_width, edge_slack(member, space) * space.size
    if slack > MAX_WIDENING * width:
        cure = "make it wider, cut it into shorter ones, or bring far objects nearer"
        must = f"a flat surface here must be wider than {slack / MAX_WIDENING:.2g} m because of rounding"
        refuse(member.surface, f"{must}, got {width:.3g} m; {cure}")


def _check_fibre(member: SheetMember, space: Space) -> None:
    """Refuse a dielectric tube so thin that rounding along it reaches its length."""
    profile, length = member.shape.profile, member.shape.extent
    radius = max(map(profile.radius_at, (profile.low, profile.high)))
    least = math.sqrt(edge_slack(member, space) * space.size * length)
    if radius < least:
        cure = "make it thicker or shorter, or bring far objects nearer"
        must = f"glass {length:.3g} m long must have a radius above {least:.2g} m here because of rounding"
        refuse(member.surface, f"{must}, got {radius:.3g} m; {cure}")
