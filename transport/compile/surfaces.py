"""Rows of the shapes on sheets: how rays intersect them, and where points are clamped inside edges."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.meshes import mesh_row
from transport.compile.space import Space
from transport.compile.speeds import Quantile, constant_quantile, quantile_row
from transport.geometry.flat import Disk, FlatShape, Plane, Rectangle, Triangle
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Paraboloid, Revolved
from transport.geometry.shape import Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.materials import OPTICAL_COLUMNS, Material
from transport.scene.sheets import Sheet, SheetMember
from transport.scene.speeds import SpeedDistribution
from transport.statistics.microfacet_lobe import lobe_quantile
from transport.validation import refuse
from transport.vectors import dot

if TYPE_CHECKING:
    from transport.compile.plan import Plan


# [scene lengths] A point nearer to an edge is clamped inside it. This is 2000 roundings of a coordinate,
# which clears a neighbour that meets the edge at an angle of 0.001 as well.
EDGE_MARGIN = 2.0**-42
PASS_NAMES = {Rectangle: "rectangle", Disk: "disk", Triangle: "triangle", Plane: "plane", Mesh: "mesh"}


def shape_row(
    plan: Plan, member: SheetMember, sheet: Sheet, code: int, number: int
) -> tuple[str, np.ndarray]:
    """Return the name of the shape's passes, without their verb, and its row."""
    shape = member.shape
    row = mesh_row(plan, shape) if shape.triangles else layout.row(_row_type(shape), code=code, sheet=number)
    row["code"], row["sheet"] = code, number
    for name, value in _shape_columns(member, plan.space).items():
        row[name] = value
    _share_plane(row, member, sheet, plan.space)
    return pass_name(shape), row


def pass_name(shape: Shape) -> str:
    """Return the name of a shape's passes, without their verb."""
    if isinstance(shape, Revolved):
        return "sphere" if shape.is_closed else "quadric"
    return "holed" if shape.hole is not None else PASS_NAMES[type(shape)]


def _row_type(shape: Shape) -> np.dtype:
    """Return the record type of a shape's row."""
    return getattr(layout, pass_name(shape).upper())


def _shape_columns(member: SheetMember, space: Space) -> dict[str, float]:
    """Return the columns of a member's shape, in scene lengths."""
    shape = member.shape
    slack = edge_slack(member, space)
    match shape:
        case Mesh():
            return {}
        case Revolved():
            return _sphere_columns(shape, space) if shape.is_closed else quadric_columns(shape, space, slack)
        case Triangle():
            return _triangle_columns(shape, space, slack)
        case Disk():
            return _disk_columns(shape, space, slack)
        case Plane():
            return layout.center_columns(space.place(shape.center)) | layout.vector_columns("n", shape.normal)
    values = layout.center_columns(space.place(shape.center)) | layout.frame_columns(shape.frame)
    for axis, length in (("u", shape.width), ("v", shape.height)):
        half = 0.5 * length / space.size
        values |= {
            f"half_{axis}": half + slack,
            f"inner_{axis}": half - min(EDGE_MARGIN + slack, half / 1024),
        }
    return values | hole_columns(shape, space, slack)


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


def rounding_of_crossings(shape: Shape, space: Space) -> float:
    """Return a bound of the rounding of crossings and of the coordinates of a shape [scene lengths]."""
    rounding = layout.ROUNDING * (sum(map(abs, space.place(shape.middle))) + shape.extent / space.size)
    return rounding + 2.0**-52 * sum(map(abs, shape.middle)) / space.size


def _sphere_columns(shape: Sphere, space: Space) -> dict[str, float]:
    return layout.center_columns(space.place(shape.center)) | {"radius": shape.radius / space.size}


def _disk_columns(shape: Disk, space: Space, slack: float) -> dict[str, float]:
    """Return the columns of a disk: squared radii for hits, and squared radii clear of the edges."""
    outer, inner = shape.radius / space.size, shape.inner_radius / space.size
    most, least = disk_margins(shape, space, slack)
    values = layout.center_columns(space.place(shape.center)) | layout.vector_columns("n", shape.normal)
    inner, outer = max(inner - slack, 0.0), outer + slack
    values |= {"inner2": inner * inner, "outer2": outer * outer, "breadth": 2 * outer}
    return values | {"most2": most * most, "least2": least * least if least > 0 else -1.0}


def disk_margins(shape: Disk, space: Space, slack: float) -> tuple[float, float]:
    """Return the outer and the inner radius [scene lengths] between which a point is clear of the edges."""
    outer, inner = shape.radius / space.size, shape.inner_radius / space.size
    margin = min(EDGE_MARGIN + slack, (outer - inner) / 1024)
    return outer - margin, inner + margin if inner > 0 else 0.0


def _triangle_columns(shape: Triangle, space: Space, slack: float) -> dict[str, float]:
    """Return the columns of a triangle: dual vectors, and the least weights clear of the edges."""
    columns = triangle_columns(shape, space)
    values = layout.known_columns(layout.TRIANGLE, columns)
    for name, reach in zip("abc", triangle_reaches(columns), strict=True):
        values |= {f"reach_{name}": reach, f"least_{name}": min((EDGE_MARGIN + slack) * reach, 1 / 64)}
    return values | {"slack": slack}


def triangle_columns(triangle: Triangle, space: Space) -> dict[str, float]:
    """Return the columns of a triangle: vertex, edges as e_u and e_v, normal, dual vectors."""
    first, second, third = (space.place(vertex) for vertex in triangle.vertices)
    edges = [tuple(q - p for p, q in zip(first, other, strict=True)) for other in (second, third)]
    matrix = np.linalg.inv(np.array([*edges, triangle.normal]).T)
    duals = layout.vector_columns("a", matrix[0]) | layout.vector_columns("b", matrix[1])
    return layout.center_columns(first) | layout.frame_columns((*edges, triangle.normal)) | duals


def triangle_reaches(columns: dict[str, float]) -> tuple[float, float, float]:
    """Return how fast the weights of the second, third and first vertex change [per scene length]."""
    a, b = (tuple(columns[f"{e}{x}"] for x in "xyz") for e in "ab")
    return math.hypot(*a), math.hypot(*b), math.hypot(*(p + q for p, q in zip(a, b, strict=True)))


def quadric_columns(shape: Revolved, space: Space, slack: float = 0.0) -> dict[str, float]:
    """Return the columns of a surface of revolution, in scene lengths; a pole has no edge."""
    profile, size = shape.profile, space.size
    values = layout.center_columns(space.place(profile.origin)) | layout.vector_columns("a", shape.axis)
    values |= {"alpha": profile.alpha / size / size, "beta": profile.beta / size, "gamma": profile.gamma}
    margin = min(EDGE_MARGIN + slack, (profile.high - profile.low) / size / 1024)
    for name, end, outwards in (("low", profile.low, -1.0), ("high", profile.high, 1.0)):
        is_pole = isinstance(shape, Sphere | Paraboloid) and profile.radius_at(end) == 0
        values[name] = outwards * math.inf if is_pole else end / size + outwards * slack
        values[f"inner_{name}"] = outwards * math.inf if is_pole else end / size - outwards * margin
    return values


def hole_columns(shape: Rectangle, space: Space, slack: float) -> dict[str, float]:
    """Return the columns of the hole, reduced by the slack, in the rectangle's frame."""
    hole, size = shape.hole, space.size
    if hole is None:
        return {}
    e_u, e_v, _ = shape.frame
    offset = tuple(p - q for p, q in zip(hole.center, shape.center, strict=True))
    values = {"hole_u": dot(offset, e_u) / size, "hole_v": dot(offset, e_v) / size, "hole_cos": 1.0}
    if isinstance(hole, Disk):
        half = hole.radius / size
        return values | {"half_p": half - min(slack, half / 2), "margin": EDGE_MARGIN + 2 * slack}
    p, q = hole.frame[0], (0.5 * hole.width / size, 0.5 * hole.height / size)
    values |= {"hole_cos": dot(p, e_u), "hole_sin": dot(p, e_v), "margin": EDGE_MARGIN + 2 * slack}
    return values | {f"half_{name}": half - min(slack, half / 2) for name, half in zip("pq", q, strict=True)}


def rim_row(plan: Plan, member: SheetMember) -> np.ndarray:
    """Return the row of a member's edges, which clamp points that landed within rounding of them."""
    shape, space = member.shape, plan.space
    slack = edge_slack(member, space)
    match shape:
        case Rectangle():
            values = _shape_columns(member, space)
            return _rim(values, layout.RECTANGLE_RIM)
        case Disk():
            most, least = disk_margins(shape, space, slack)
            values = layout.center_columns(space.place(shape.center)) | layout.frame_columns(shape.frame)
            return layout.row(layout.RIM, **values, inner_u=most, inner_v=least, form=layout.DISK_RIM)
        case Triangle():
            values = triangle_columns(shape, space)
            reaches = zip("abc", triangle_reaches(values), strict=True)
            values |= {f"least_{name}": min((EDGE_MARGIN + slack) * reach, 1 / 64) for name, reach in reaches}
            return _rim(values, layout.TRIANGLE_RIM)
        case Revolved() if not shape.is_closed:
            values = quadric_columns(shape, space, slack)
            values |= {"low": values["inner_low"], "high": values["inner_high"]} | layout.frame_columns(
                shape.frame
            )
            return _rim(values, layout.QUADRIC_RIM)
    return np.zeros((), layout.RIM)


def _rim(values: dict[str, float], form: int) -> np.ndarray:
    """Return the row of an edge of this form, from the columns of its shape."""
    return layout.row(layout.RIM, **layout.known_columns(layout.RIM, values), form=form)


def outward_sign(member: SheetMember, flat: Shape) -> float:
    """Return +1 (-1) where a box's face points along (against) a normal; 0 for other members."""
    if not isinstance(member.whole, Box) or member.surface is not None:
        return 0.0
    return math.copysign(1.0, dot(member.shape.normal, flat.normal))


def covers_same_points(one: SheetMember, other: SheetMember) -> bool:
    """Return whether two members of a sheet cover the same points, so that one pass finds both.

    Two acting members never do.
    """
    if other.surface is not None:
        return False
    if one.shape.is_plane and other.shape.is_plane:
        return True
    same = one.shape == other.shape and one.whole == other.whole
    return same and one.surface is None and bounds_bodies(one) == bounds_bodies(other)


def _share_plane(row: np.ndarray, member: SheetMember, sheet: Sheet, space: Space) -> None:
    """Set all flat members of a sheet to the point of the smallest one, and detectors to its normal.

    With planes of their own they would lie a rounding apart, and a particle that crosses there could miss
    both or hit one twice.
    """
    if "sx" in row.dtype.names:
        finest = min((member.shape for member in sheet.members), key=lambda shape: shape.extent)
        row["sx"], row["sy"], row["sz"] = space.place(finest.center)
        if "outward" in row.dtype.names:
            row["outward"] = outward_sign(member, finest)
        is_detector = (int(row["code"]) >> layout.SURFACE_SHIFT) & layout.SURFACE_MASK == 0
        if is_detector:
            row["nx"], row["ny"], row["nz"] = finest.normal


# ---- Find the empty sides of sheets: a particle that leaves there has escaped without another flight.

PARALLEL_TOLERANCE = 1e-15


def exterior_sides(sheet: Sheet, sheets: list[Sheet]) -> tuple[bool, bool]:
    """Return whether the front and the back side of a sheet are empty (exact, without tolerance)."""
    others = [other.support for other in sheets if other is not sheet]
    others += [member.shape for other in sheets if other is not sheet for member in other.members[1:]]
    support = sheet.support
    if support.is_flat:
        return tuple(all(_is_behind(support, shape, side) for shape in others) for side in (1.0, -1.0))
    return support.is_convex and all(_is_within(support, shape) for shape in others), False


def _is_behind(flat: FlatShape, shape: Shape, side: float) -> bool:
    """Return whether a shape lies behind a plane (side 1), or on the normal's side (side -1)."""
    normal, center = np.array(flat.normal), np.array(flat.center)
    if shape.is_infinite:
        is_parallel = shape.is_plane and abs(dot(shape.normal, flat.normal)) >= 1 - PARALLEL_TOLERANCE
        return is_parallel and side * (np.array(shape.center) - center) @ normal <= 0.0
    return bool((side * ((np.array(shape.bounds_corners()) - center) @ normal) <= 0.0).all())


def _is_within(ball: Sphere, shape: Shape) -> bool:
    if shape.is_infinite:
        return False
    if isinstance(shape, Sphere):
        apart = float(np.linalg.norm(np.array(shape.center) - np.array(ball.center)))
        return apart + shape.radius <= ball.radius
    reach = np.linalg.norm(np.array(shape.bounds_corners()) - np.array(ball.center), axis=1)
    return bool((reach <= ball.radius).all())


# ---- Rows of acting surfaces: the material of each part and each side, with its optical properties.

Rows = list[tuple[np.ndarray, np.ndarray]]  # rows of layout.SURFACE and layout.OPTICS


def transparent_rows() -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of a transparent surface."""
    surface = layout.row(layout.SURFACE, material=layout.TRANSPARENT, albedo=1.0)
    return surface, layout.row(layout.OPTICS, side=1.0, ratio=1.0)


def surface_rows(plan: Plan, member: SheetMember) -> Rows:
    """Return the rows of an acting member: front, then back where the two differ."""
    front, back = member.surface.material.sides
    rows = _side_rows(plan, front, member)
    if back is not front:
        rows[0][0]["back"] = len(rows)
        rows += _side_rows(plan, back, member)
    return rows


def _side_rows(plan: Plan, material: Material, member: SheetMember) -> Rows:
    """Return one row per elementary material of a side, with cumulative shares."""
    parts, total, rows = material.weighted_parts, 0.0, []
    for part, share in parts:
        total += share
        surface, optics = _material_rows(plan, part, member)
        surface["share"], surface["parts"] = total, len(parts)
        rows.append((surface, optics))
    return rows


def _material_rows(plan: Plan, material: Material, member: SheetMember) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of an elementary material."""
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
        optics["lobe"] = _keep_row(plan, lobe)
    if material.speed is not None and row.albedo > 0 and plan.has_speeds:
        surface["quantiles"] = _wall_speed_table(plan, material.speed)
    return surface, optics


def _wall_speed_table(plan: Plan, speed: float | SpeedDistribution) -> int:
    """Return the address of the quantile table of speeds leaving a wall (weighted by the speed)."""
    quantile = constant_quantile(speed) if isinstance(speed, float) else speed.flux_quantile
    return _keep_row(plan, quantile_row(plan, quantile))


@lru_cache(maxsize=64)
def _microfacet_quantile(roughness: float) -> Quantile:
    """Return the quantile function of the microfacet lobe's cosine; one object per roughness."""
    return lambda u: lobe_quantile(u, roughness)


def _keep_row(plan: Plan, row: np.ndarray) -> int:
    """Keep a row alive in the plan, and return its address."""
    plan.kept.append(row)
    return row.ctypes.data


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
