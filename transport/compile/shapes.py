"""Primitive shapes as the engine has them: names of passes, and columns of tables in scene lengths.

A shape that is made of primitives needs nothing here; a new primitive is an entry of PRIMITIVES.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.compile import layout
from transport.compile.plan import MeshTable
from transport.compile.space import Space
from transport.geometry.flat import Disk, Plane, Rectangle, Triangle
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Paraboloid, Revolved
from transport.geometry.shape import Cloud, Point, Shape
from transport.geometry.solid import Box, Sphere
from transport.vectors import dot

if TYPE_CHECKING:
    from transport.compile.plan import Plan

# [scene lengths] A point nearer to an edge is clamped inside it. This is 2000 roundings of a coordinate,
# which clears a neighbour that meets the edge at an angle of 0.001 as well.
EDGE_MARGIN = 2.0**-42

Columns = dict[str, float]


class Primitive(NamedTuple):
    """A shape that the engine knows: `columns(shape, space, slack)` describes it in scene lengths.

    slack: distance by which it reaches over its edges.
    """

    name: str  # of its passes, such as "meet_disk", and of the type of their row
    columns: Callable[[Shape, Space, float], Columns]
    births: str = ""  # pass that samples places on it, or in it
    rim: int = 0  # form of its edges in layout.RIM; 0: none


def primitive_of(shape: Shape) -> Primitive:
    """Return the primitive that a shape is."""
    if shape.hole is not None:
        return HOLED
    is_open = isinstance(shape, Revolved) and not shape.is_closed
    return PRIMITIVES[Revolved if is_open else type(shape)]


def pass_name(shape: Shape) -> str:
    """Return the name of a shape's passes, without their verb."""
    return primitive_of(shape).name


def shape_columns(shape: Shape, space: Space, slack: float = 0.0) -> Columns:
    """Return the columns of a primitive shape, in scene lengths; a row takes those that it has."""
    return primitive_of(shape).columns(shape, space, slack)


def rounding_of_crossings(shape: Shape, space: Space) -> float:
    """Return a bound of the rounding of crossings and of the coordinates of a shape [scene lengths]."""
    rounding = layout.ROUNDING * (sum(map(abs, space.place(shape.middle))) + shape.extent / space.size)
    return rounding + 2.0**-52 * sum(map(abs, shape.middle)) / space.size


def _framed(shape: Shape, space: Space, _slack: float = 0.0) -> Columns:
    return layout.center_columns(space.place(shape.center)) | layout.frame_columns(shape.frame)


def _rectangle(shape: Rectangle, space: Space, slack: float) -> Columns:
    values = _framed(shape, space)
    for axis, length in (("u", shape.width), ("v", shape.height)):
        half = 0.5 * length / space.size
        values[f"half_{axis}"] = half + slack
        values[f"inner_{axis}"] = half - min(EDGE_MARGIN + slack, half / 1024)
    if (normal := aligned_axis(shape)) is not None:
        for axis, vector in zip("uv", shape.frame[:2], strict=True):
            place = ("next", "last")[(int(np.argmax(np.abs(vector))) - normal - 1) % 3]
            values |= {f"{what}_{place}": values[f"{what}_{axis}"] for what in ("half", "inner")}
    return values | _hole(shape, space, slack)


def aligned_axis(shape: Shape) -> int | None:
    """Return the number of the axis along which a shape's normal lies, if its frame is that of the axes."""
    frame = np.abs(shape.frame)
    return int(np.argmax(frame[2])) if ((frame == 0) | (frame == 1)).all() else None


def _hole(shape: Rectangle, space: Space, slack: float) -> Columns:
    """Return the columns of the hole, reduced by the slack, in the rectangle's frame."""
    hole, size = shape.hole, space.size
    if hole is None:
        return {}
    e_u, e_v, _ = shape.frame
    offset = tuple(p - q for p, q in zip(hole.center, shape.center, strict=True))
    values = {"hole_u": dot(offset, e_u) / size, "hole_v": dot(offset, e_v) / size, "hole_cos": 1.0}
    values["margin"] = EDGE_MARGIN + 2 * slack
    if isinstance(hole, Disk):
        half = hole.radius / size
        return values | {"half_p": half - min(slack, half / 2)}
    p, q = hole.frame[0], (0.5 * hole.width / size, 0.5 * hole.height / size)
    values |= {"hole_cos": dot(p, e_u), "hole_sin": dot(p, e_v)}
    return values | {f"half_{name}": half - min(slack, half / 2) for name, half in zip("pq", q, strict=True)}


def _disk(shape: Disk, space: Space, slack: float) -> Columns:
    """Return squared radii for hits, and those between which a point is clear of the edges."""
    outer, inner = shape.radius / space.size, shape.inner_radius / space.size
    margin = min(EDGE_MARGIN + slack, (outer - inner) / 1024)
    most, least = outer - margin, inner + margin if inner > 0 else 0.0
    inner, outer = max(inner - slack, 0.0), outer + slack
    values = {"inner2": inner * inner, "outer2": outer * outer, "breadth": 2 * outer}
    values |= {"most2": most * most, "least2": least * least if least > 0 else -1.0}
    return _framed(shape, space) | values | {"inner_u": most, "inner_v": least}


def _triangle(shape: Triangle, space: Space, slack: float) -> Columns:
    """Return vertex, edges as e_u and e_v, dual vectors, and the least weights clear of the edges."""
    first, second, third = (space.place(vertex) for vertex in shape.vertices)
    edges = [tuple(q - p for p, q in zip(first, other, strict=True)) for other in (second, third)]
    a, b = np.linalg.inv(np.array([*edges, shape.normal]).T)[:2].tolist()
    values = layout.center_columns(first) | layout.frame_columns((*edges, shape.normal)) | {"slack": slack}
    values |= layout.vector_columns("a", a) | layout.vector_columns("b", b)
    # The weights of the second, third and first vertex change so fast [per scene length].
    both = tuple(p + q for p, q in zip(a, b, strict=True))
    for name, weight in zip("abc", (a, b, both), strict=True):
        reach = math.hypot(*weight)
        values |= {f"reach_{name}": reach, f"least_{name}": min((EDGE_MARGIN + slack) * reach, 1 / 64)}
    return values


def revolved_columns(shape: Revolved, space: Space, slack: float = 0.0) -> Columns:
    """Return the columns of a surface of revolution; a pole has no edge."""
    profile, size = shape.profile, space.size
    values = layout.center_columns(space.place(profile.origin)) | layout.frame_columns(shape.frame)
    values |= layout.vector_columns("a", shape.axis)
    values |= {"alpha": profile.alpha / size / size, "beta": profile.beta / size, "gamma": profile.gamma}
    margin = min(EDGE_MARGIN + slack, (profile.high - profile.low) / size / 1024)
    for name, end, outwards in (("low", profile.low, -1.0), ("high", profile.high, 1.0)):
        is_pole = isinstance(shape, Sphere | Paraboloid) and profile.radius_at(end) == 0
        values[name] = outwards * math.inf if is_pole else end / size + outwards * slack
        values[f"inner_{name}"] = outwards * math.inf if is_pole else end / size - outwards * margin
    return values


def _sphere(shape: Sphere, space: Space, _slack: float) -> Columns:
    radius = shape.radius / space.size
    return layout.center_columns(space.place(shape.center)) | {"radius": radius, "half_u": radius}


def _box(shape: Box | Cloud, space: Space, _slack: float) -> Columns:
    halves = shape.sigma if isinstance(shape, Cloud) else [0.5 * side for side in shape.size]
    sides = {f"half_{axis}": half / space.size for axis, half in zip("uvw", halves, strict=True)}
    return layout.center_columns(space.place(shape.middle)) | sides


def _point(shape: Point, space: Space, _slack: float) -> Columns:
    return layout.center_columns(space.place(shape.position))


def _mesh(*_: object) -> Columns:
    return {}


PRIMITIVES = {
    Rectangle: Primitive("rectangle", _rectangle, "born_on_rectangle", layout.RECTANGLE_RIM),
    Disk: Primitive("disk", _disk, "born_on_disk", layout.DISK_RIM),
    Triangle: Primitive("triangle", _triangle, "born_on_triangle", layout.TRIANGLE_RIM),
    Sphere: Primitive("sphere", _sphere, "born_on_sphere"),
    Revolved: Primitive("quadric", revolved_columns, "born_on_band", layout.QUADRIC_RIM),
    Plane: Primitive("plane", _framed),
    Mesh: Primitive("mesh", _mesh, "born_on_mesh"),
    Box: Primitive("box", _box, "born_in_box"),
    Cloud: Primitive("cloud", _box, "born_in_cloud"),
    Point: Primitive("point", _point, "born_at_point"),
}
HOLED = Primitive("holed", _rectangle, "born_beside_hole", layout.RECTANGLE_RIM)


# ---- Meshes in scene lengths: vertices, facets and normals, made once per mesh of a plan.


def point_to_mesh(plan: Plan, mesh: Mesh, row: np.ndarray) -> np.ndarray:
    """Let a row of a table refer to the arrays of a mesh, and return it."""
    if mesh not in plan.meshes:
        vertices = (mesh.vertices - np.array(plan.space.origin)) / plan.space.size
        center = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
        plan.meshes[mesh] = MeshTable(vertices, mesh.faces.astype(np.int32), mesh.normals, mesh.areas, center)
    table = plan.meshes[mesh]
    table.rows.append(row)
    if "cx" in row.dtype.names:
        row["cx"], row["cy"], row["cz"] = table.center
    return row
