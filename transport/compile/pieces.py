"""Rows of the shapes on sheets: how rays intersect them, and where points are clamped inside edges."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.meshes import mesh_row
from transport.compile.space import Space
from transport.shapes import Box, Disk, Mesh, Paraboloid, Plane, Rectangle, Revolved, Shape, Sphere, Triangle
from transport.sheets import Member, Sheet
from transport.vectors import dot

if TYPE_CHECKING:
    from transport.compile.plan import Plan

# [scene lengths] A point nearer to an edge is clamped inside it. This is 2000 roundings of a coordinate,
# which clears a neighbour that meets the edge at an angle of 0.001 as well.
SETBACK = 2.0**-42
KINDS = {Rectangle: "rectangle", Disk: "disk", Triangle: "triangle", Plane: "plane", Mesh: "mesh"}


def piece_row(plan: Plan, member: Member, sheet: Sheet, code: int, number: int) -> tuple[str, np.ndarray]:
    """Return the name of the shape's passes, without their verb, and its row."""
    shape = member.shape
    row = (
        layout.row(_kind(shape), code=code, sheet=number)
        if not isinstance(shape, Mesh)
        else mesh_row(plan, shape)
    )
    row["code"], row["sheet"] = code, number
    for name, value in _columns(member, plan.space).items():
        row[name] = value
    _share_plane(row, member, sheet, plan.space)
    return name_of(shape), row


def name_of(shape: Shape) -> str:
    """Return the name of a shape's passes, without their verb."""
    if isinstance(shape, Revolved):
        return "sphere" if shape.is_closed else "quadric"
    return "holed" if isinstance(shape, Rectangle) and shape.hole is not None else KINDS[type(shape)]


def _kind(shape: Shape) -> np.dtype:
    """Return the record type of a shape's row."""
    return getattr(layout, name_of(shape).upper())


def _columns(member: Member, space: Space) -> dict[str, float]:
    """Return the columns of a member's shape, in scene lengths."""
    shape = member.shape
    slack = slack_of(member, space)
    match shape:
        case Mesh():
            return {}
        case Revolved():
            return _sphere(shape, space) if shape.is_closed else quadric_columns(shape, space, slack)
        case Triangle():
            return _triangle(shape, space, slack)
        case Disk():
            return _disk(shape, space, slack)
        case Plane():
            return layout.center_columns(space.place(shape.center)) | _vector("n", shape.normal)
    values = layout.center_columns(space.place(shape.center)) | layout.frame_columns(shape.frame)
    for axis, length in (("u", shape.width), ("v", shape.height)):
        half = 0.5 * length / space.size
        values |= {f"half_{axis}": half + slack, f"inner_{axis}": half - min(SETBACK + slack, half / 1024)}
    return values | hole_columns(shape, space, slack)


def bounds_bodies(member: Member) -> bool:
    """Return whether the member is a boundary of media."""
    return member.bodies[0] != member.bodies[1]


def slack_of(member: Member, space: Space) -> float:
    """Return how far a member reaches over its edges [scene lengths], so that closed boxes do not leak.

    It bounds the rounding of a crossing's coordinates and of the coordinates given by the user; 0 for members
    that neither act nor bound a body.
    """
    shape = member.shape
    if shape.is_infinite or (member.surface is None and not bounds_bodies(member)):
        return 0.0
    rounding = layout.ROUNDING * (sum(map(abs, space.place(shape.middle))) + shape.extent / space.size)
    return rounding + 2.0**-52 * sum(map(abs, shape.middle)) / space.size


def _sphere(shape: Sphere, space: Space) -> dict[str, float]:
    return layout.center_columns(space.place(shape.center)) | {"radius": shape.radius / space.size}


def _disk(shape: Disk, space: Space, slack: float) -> dict[str, float]:
    """Return the columns of a disk: squared radii for hits, and squared radii clear of the edges."""
    outer, inner = shape.radius / space.size, shape.inner_radius / space.size
    most, least = disk_margins(shape, space, slack)
    values = layout.center_columns(space.place(shape.center)) | _vector("n", shape.normal)
    inner, outer = max(inner - slack, 0.0), outer + slack
    values |= {"inner2": inner * inner, "outer2": outer * outer, "breadth": 2 * outer}
    return values | {"most2": most * most, "least2": least * least if least > 0 else -1.0}


def disk_margins(shape: Disk, space: Space, slack: float) -> tuple[float, float]:
    """Return the outer and the inner radius [scene lengths] between which a point is clear of the edges."""
    outer, inner = shape.radius / space.size, shape.inner_radius / space.size
    margin = min(SETBACK + slack, (outer - inner) / 1024)
    return outer - margin, inner + margin if inner > 0 else 0.0


def _triangle(shape: Triangle, space: Space, slack: float) -> dict[str, float]:
    """Return the columns of a triangle: dual vectors, and the least weights clear of the edges."""
    columns = triangle_columns(shape, space)
    values = {name: columns[name] for name in layout.TRIANGLE.names if name in columns}
    for name, reach in zip("abc", triangle_reaches(columns), strict=True):
        values |= {f"reach_{name}": reach, f"least_{name}": min((SETBACK + slack) * reach, 1 / 64)}
    return values | {"slack": slack}


def triangle_columns(triangle: Triangle, space: Space) -> dict[str, float]:
    """Return the columns of a triangle: vertex, edges as e_u and e_v, normal, dual vectors."""
    first, second, third = (space.place(vertex) for vertex in triangle.vertices)
    edges = [tuple(q - p for p, q in zip(first, other, strict=True)) for other in (second, third)]
    matrix = np.linalg.inv(np.array([*edges, triangle.normal]).T)
    duals = dict(zip(("ax", "ay", "az", "bx", "by", "bz"), matrix[:2].ravel(), strict=True))
    return layout.center_columns(first) | layout.frame_columns((*edges, triangle.normal)) | duals


def triangle_reaches(columns: dict[str, float]) -> tuple[float, float, float]:
    """Return how fast the weights of the second, third and first vertex change [per scene length]."""
    a, b = (tuple(columns[f"{e}{x}"] for x in "xyz") for e in "ab")
    return math.hypot(*a), math.hypot(*b), math.hypot(*(p + q for p, q in zip(a, b, strict=True)))


def quadric_columns(shape: Revolved, space: Space, slack: float = 0.0) -> dict[str, float]:
    """Return the columns of a surface of revolution, in scene lengths; a pole has no edge."""
    profile, size = shape.profile, space.size
    values = layout.center_columns(space.place(profile.origin)) | _vector("a", shape.axis)
    values |= {"alpha": profile.alpha / size / size, "beta": profile.beta / size, "gamma": profile.gamma}
    margin = min(SETBACK + slack, (profile.high - profile.low) / size / 1024)
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
    way = tuple(p - q for p, q in zip(hole.center, shape.center, strict=True))
    values = {"hole_u": dot(way, e_u) / size, "hole_v": dot(way, e_v) / size, "hole_cos": 1.0}
    if isinstance(hole, Disk):
        half = hole.radius / size
        return values | {"half_p": half - min(slack, half / 2), "margin": SETBACK + 2 * slack}
    p, q = hole.frame[0], (0.5 * hole.width / size, 0.5 * hole.height / size)
    values |= {"hole_cos": dot(p, e_u), "hole_sin": dot(p, e_v), "margin": SETBACK + 2 * slack}
    return values | {f"half_{name}": half - min(slack, half / 2) for name, half in zip("pq", q, strict=True)}


def rim_row(plan: Plan, member: Member) -> np.ndarray:
    """Return the row of a member's edges, which clamp points that landed within rounding of them."""
    shape, space = member.shape, plan.space
    slack = slack_of(member, space)
    match shape:
        case Rectangle():
            values = _columns(member, space)
            kept = {name: values[name] for name in layout.RIM.names if name in values}
            return layout.row(layout.RIM, **kept, form=layout.RECTANGLE_RIM)
        case Disk():
            most, least = disk_margins(shape, space, slack)
            values = layout.center_columns(space.place(shape.center)) | layout.frame_columns(shape.frame)
            return layout.row(layout.RIM, **values, inner_u=most, inner_v=least, form=layout.DISK_RIM)
        case Triangle():
            values = triangle_columns(shape, space)
            reaches = zip("abc", triangle_reaches(values), strict=True)
            values |= {f"least_{name}": min((SETBACK + slack) * reach, 1 / 64) for name, reach in reaches}
            kept = {name: values[name] for name in layout.RIM.names if name in values}
            return layout.row(layout.RIM, **kept, form=layout.TRIANGLE_RIM)
        case Revolved() if not shape.is_closed:
            values = quadric_columns(shape, space, slack)
            values |= {"low": values["inner_low"], "high": values["inner_high"]} | layout.frame_columns(
                shape.frame
            )
            kept = {name: values[name] for name in layout.RIM.names if name in values}
            return layout.row(layout.RIM, **kept, form=layout.QUADRIC_RIM)
    return np.zeros((), layout.RIM)


def outward_of(member: Member, flat: Shape) -> float:
    """Return +1 (-1) where a box's face points along (against) a normal; 0 for other members."""
    if not isinstance(member.whole, Box) or member.surface is not None:
        return 0.0
    return math.copysign(1.0, dot(member.shape.normal, flat.normal))


def covers_alike(one: Member, other: Member) -> bool:
    """Return whether two members of a sheet cover the same points, so that one pass finds both.

    Two acting members never do.
    """
    if other.surface is not None:
        return False
    if isinstance(one.shape, Plane) and isinstance(other.shape, Plane):
        return True
    same = one.shape == other.shape and one.whole == other.whole
    return same and one.surface is None and bounds_bodies(one) == bounds_bodies(other)


def _share_plane(row: np.ndarray, member: Member, sheet: Sheet, space: Space) -> None:
    """Give all flat members of a sheet the point of the smallest one, and detectors its normal.

    With planes of their own they would lie a rounding apart, and a particle that crosses there could miss
    both or hit one twice.
    """
    if "sx" in row.dtype.names:
        finest = min((member.shape for member in sheet.members), key=lambda shape: shape.extent)
        row["sx"], row["sy"], row["sz"] = space.place(finest.center)
        if "outward" in row.dtype.names:
            row["outward"] = outward_of(member, finest)
        is_meter = (int(row["code"]) >> layout.SURFACE_SHIFT) & layout.SURFACE_MASK == 0
        if is_meter:
            row["nx"], row["ny"], row["nz"] = finest.normal


def _vector(name: str, vector: tuple[float, float, float]) -> dict[str, float]:
    """Return a vector as columns."""
    return dict(zip((f"{name}x", f"{name}y", f"{name}z"), vector, strict=True))
