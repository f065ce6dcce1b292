"""Turn each source into emitters: one place of birth, one law of directions, and a target or none."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from transport.compile import layout, speeds
from transport.compile.birthplaces import birth_points
from transport.compile.media import body_row, boundary_rows, emitting_media, runs_along_boundary
from transport.compile.meshes import areas_row
from transport.compile.plan import Emitter, Plan, Step
from transport.compile.space import Space
from transport.compile.surfaces import hole_columns, triangle_columns
from transport.geometry.flat import Disk, FlatShape, Rectangle, Triangle
from transport.geometry.mesh import Mesh
from transport.geometry.relations import least_height
from transport.geometry.revolved import Paraboloid, Revolved
from transport.geometry.shape import Cloud, Point, Shape
from transport.geometry.solid import Box
from transport.scene.checks.refractive_indices import index_around
from transport.scene.emissions import DIRECTION_DENSITIES
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.validation import refuse, short_repr
from transport.vectors import dot

# [scene lengths] distance at which births start from a point where three detectors or more meet
POINT_START_OFFSET = 2.0**-47
MIN_SOLID_ANGLE = 1e-200  # [sr] least solid angle of a target
ENCLOSING_FACTOR = 1.0 + 2.0**-40  # of the radius of a sphere that encloses a shape
# Largest weight of a direction towards a target that may be near: half of the directions follow the source's
# own law.
MAX_NEAR_WEIGHT = 2.0


def make_emitters(plan: Plan, sheets_of: Callable[[Shape], list[int]], acting: set[int]) -> list[Emitter]:
    """Return the emitters of all sources, media that emit included.

    sheets_of: gives the numbers of the sheets on which a piece lies; acting: numbers of sheets with acting
    surfaces.
    """
    scene, space, emitters = plan.scene, plan.space, []
    for source in (*scene.sources, *emitting_media(scene)):
        shape = scene.shape_of(source)
        for piece, share in _pieces_with_shares(source, shape):
            place = _place(plan, source, piece)
            law = speeds.drifting_law(plan, source, piece) or _law(source, piece)
            weight, target = _target(source, piece, space)
            volume = source.emission.fills_volume and not isinstance(piece, Point)
            birth = _birth(source, piece, [] if volume else sheets_of(piece), acting)
            amount = source.amount(shape, scene.duration) * share
            moment, speed = speeds.birth_time_pass(source, scene.duration), speeds.speed_passes(plan, source)
            facing = _normal_row(source, piece)
            medium, (inside, beside) = medium_row(scene, source, piece), _birth_bodies(plan, source, piece)
            emitters.append(
                Emitter(
                    source,
                    piece,
                    amount,
                    weight,
                    birth,
                    place,
                    facing,
                    law,
                    moment,
                    speed,
                    target,
                    medium,
                    inside,
                    beside,
                )
            )
    return emitters


def medium_row(scene: Scene, source: Source, piece: Shape) -> np.ndarray | None:
    """Return the row of the refractive index that a source emits into; None without a Dielectric.

    The index is that of the boundary's side, or of the medium around a place of the source; 0 where it is
    unknown.
    """
    glass = {
        surface.shape: glass for surface in scene.surfaces if (glass := surface.material.boundary) is not None
    }
    if not glass:
        return None
    boundary, index = glass.get(scene.shape_of(source)), math.nan
    if boundary is not None and source.emission.has_side:
        index = boundary.index_inside if source.is_back else boundary.index_outside
    else:
        index = index_around(scene, tuple(birth_points(source, piece, 1.0)[0]))
    return layout.row(layout.MEDIUM, index=0.0 if math.isnan(index) else index)


def _birth_bodies(plan: Plan, source: Source, piece: Shape) -> tuple[np.ndarray | None, list[np.ndarray]]:
    """Return the row of bodies that a source emits into, and rows of boundaries that it lies on.

    Refuse sources whose medium is ambiguous.
    """
    if not plan.has_bodies:
        return None, []
    if isinstance(piece, Point) and source.emission.law != "beam":
        found = boundary_rows(plan, piece.position)
        if found is None:
            refuse(
                source,
                f"position must not lie on the boundary of a body, got {short_repr(piece)}; move it off",
            )
        return found
    if isinstance(piece, Point) and runs_along_boundary(plan, piece.position, source.emission.direction):
        must = "direction must not lead along the boundary of a body from a point on it"
        refuse(
            source, f"{must}, got {source.emission.direction} from {short_repr(piece)}; move it to one side"
        )
    row = body_row(plan, birth_points(source, piece, plan.space.size))
    if row is None:
        refuse(
            source, f"shape must lie in one medium, got {short_repr(piece)}, which lies in several; divide it"
        )
    return row, []


def _birth(source: Source, shape: Shape, sheets: list[int], acting: set[int]) -> np.ndarray:
    """Return the row of births on these sheets.

    A particle stands on the first sheet, and counts as having crossed the second. Where three detectors or
    more meet in a point source, particles start a few roundings away from it.
    """
    if not isinstance(shape, Point):
        sheets = sheets[:1]
    if len(acting.intersection(sheets)) > 1:
        refuse(
            source, f"position must not lie where walls meet, got {short_repr(shape)}; move it to one side"
        )
    sheet, other = (*sheets, 0, 0)[:2]
    start = POINT_START_OFFSET if len(sheets) > 2 else 0.0
    return layout.row(layout.BIRTH, weight=1.0, start=start, sheet=sheet | other << layout.PASSED_SHIFT)


def _pieces_with_shares(source: Source, shape: Shape) -> Iterator[tuple[Shape, float]]:
    """Yield the pieces of a source with their shares of its amount."""
    faces = [part for piece in shape.pieces() for part in piece.primitives()]
    if source.emission.fills_volume and not shape.is_flat:
        faces = [shape]
    if len(faces) == 1:
        yield faces[0], 1.0
        return
    sizes = [face.area for face in faces]
    if source.emission.law == "beam":
        side = -1.0 if source.is_back else 1.0
        sizes = [face.area * max(0.0, side * dot(face.normal, source.emission.direction)) for face in faces]
    for face, size in zip(faces, sizes, strict=True):
        if size > 0:
            yield face, size / math.fsum(sizes)


def _place(plan: Plan, source: Source, shape: Shape) -> tuple[str, np.ndarray]:
    """Return the pass and the row by which places of birth are sampled."""
    space = plan.space
    side = -1.0 if source.is_back else 1.0
    values = layout.center_columns(space.place(shape.middle)) | {"side": side}
    size = space.size
    match shape:
        case Point():
            return "born_at_point", layout.row(layout.PATCH, **values)
        case Rectangle() if shape.hole is not None:
            return "born_beside_hole", _holed(shape, space)
        case Rectangle():
            values |= layout.frame_columns(shape.frame)
            values |= {"half_u": 0.5 * shape.width / size, "half_v": 0.5 * shape.height / size}
            return "born_on_rectangle", layout.row(layout.PATCH, **values)
        case Disk():
            values |= layout.frame_columns(shape.frame)
            inner, outer = shape.inner_radius / size, shape.radius / size
            return "born_on_disk", layout.row(
                layout.PATCH, **values, inner2=inner * inner, outer2=outer * outer
            )
        case Mesh():
            return "born_on_mesh", areas_row(plan, shape, side)
        case Triangle():
            return "born_on_triangle", layout.row(layout.PATCH, **_triangle(shape, space), side=side)
        case Revolved() if not shape.is_closed:
            return _band(shape, space, side)
        case Cloud():
            half_u, half_v, half_w = (sigma / size for sigma in shape.sigma)
            return "born_in_cloud", layout.row(
                layout.PATCH, **values, half_u=half_u, half_v=half_v, half_w=half_w
            )
        case Box():
            half_u, half_v, half_w = (0.5 * length / size for length in shape.size)
            return "born_in_box", layout.row(
                layout.PATCH, **values, half_u=half_u, half_v=half_v, half_w=half_w
            )
    values |= {"half_u": shape.radius / size}
    if source.emission.fills_volume:
        return "born_in_sphere", layout.row(layout.PATCH, **values)
    if source.emission.law == "beam":
        values |= layout.vector_columns("n", source.emission.direction)
        return "born_on_sphere_cross_section", layout.row(layout.PATCH, **values)
    return "born_on_sphere", layout.row(layout.PATCH, **values)


def _band(shape: Revolved, space: Space, side: float) -> tuple[str, np.ndarray]:
    """Return the pass and the row of a surface of revolution, by its area per height at both ends."""
    profile, size = shape.profile, space.size
    values = layout.center_columns(space.place(profile.origin)) | layout.frame_columns(shape.frame)
    values |= {"alpha": profile.alpha / size / size, "beta": profile.beta / size, "gamma": profile.gamma}
    values |= {"low": profile.low / size, "high": profile.high / size, "side": side}
    if isinstance(shape, Paraboloid):
        heights = (4 * w / profile.beta for w in (profile.low, profile.high))  # in units of the focal length
        first, last = (math.expm1(1.5 * math.log1p(w)) for w in heights)
        return "born_on_paraboloid", layout.row(layout.BAND, **values, first=first, last=last)
    ends = [profile.area_per_height(w, w) for w in (profile.low, profile.high)]
    first, last = (end / max(ends) for end in ends)
    return "born_on_band", layout.row(layout.BAND, **values, first=first, last=last)


def _triangle(shape: Triangle, space: Space) -> dict[str, float]:
    return layout.known_columns(layout.PATCH, triangle_columns(shape, space))


def _holed(shape: Rectangle, space: Space) -> np.ndarray:
    values = layout.center_columns(space.place(shape.center)) | layout.frame_columns(shape.frame)
    values |= {"half_u": 0.5 * shape.width / space.size, "half_v": 0.5 * shape.height / space.size}
    return layout.row(layout.HOLED, **values | hole_columns(shape, space, 0.0))


def _normal_row(source: Source, shape: Shape) -> np.ndarray | None:
    """Return the row of the normal by which a target weighs directions; all 0 for isotropic emission."""
    if shape.is_flat:
        return _plane_patch(source, shape)
    return None if source.emission.law == "lambertian" else layout.row(layout.PATCH)


def _plane_patch(source: Source, shape: FlatShape) -> np.ndarray:
    """Return the frame of a flat shape, and the side that emits."""
    return layout.row(layout.PATCH, **layout.frame_columns(shape.frame), side=-1.0 if source.is_back else 1.0)


def _law(source: Source, shape: Shape) -> tuple[str, np.ndarray]:
    """Return the pass and the row by which directions are sampled."""
    law = source.emission.law
    if law == "lambertian" and shape.is_flat:
        return "emit_lambertian_from_plane", _plane_patch(source, shape)
    if law == "beam":
        return "emit_beam", layout.row(layout.BEAM, **layout.vector_columns("u", source.emission.direction))
    return f"emit_{law}", layout.row(layout.NO_TABLE)


def _target(source: Source, shape: Shape, space: Space) -> tuple[float, tuple[Step, ...] | None]:
    """Return the largest weight of a direction, and the passes that sample towards the target."""
    aim = source.aim
    if aim is None:
        return 1.0, None
    law = source.emission.law
    peak = DIRECTION_DENSITIES[law]  # [sr^-1] largest density of directions
    values = {law: peak}
    is_volume = shape.is_closed and law == "isotropic"
    distance = shape.distance(aim.middle, filled=is_volume) / space.size
    values |= layout.center_columns(space.place(aim.middle))
    parts = aim.primitives()
    if not (aim.is_flat or isinstance(aim, Box)) or len(parts) > 1:
        # Aim at the sphere itself, or at the sphere that encloses another shape.
        radius = aim.extent / space.size * (1.0 if aim.is_convex else ENCLOSING_FACTOR)
        weight = _checked_weight(source, peak * 2.0 * math.pi * one_minus_cosine(radius, distance))
        row = layout.row(layout.TARGET, **values, half_u=radius, unit=1.0 / weight)
        return weight, (("aim_at_sphere", row),)
    # Directions towards the hole count as well: aim at the whole rectangle.
    (aim,) = parts
    whole = aim if aim.hole is None else replace(aim, hole=None)
    area, gap = whole.area / space.size / space.size, distance - aim.extent / space.size
    if aim.is_flat:
        gap = max(gap, least_height(shape, aim) / space.size)
    weight = peak * (math.sqrt(area) / gap) ** 2 if gap > 0 else math.inf
    # Sample near targets from a mixture of the target's density and the source's own law.
    far = weight < MAX_NEAR_WEIGHT
    weight = _checked_weight(source, weight if far else MAX_NEAR_WEIGHT)
    values |= {"area": area, "natural": 0.0 if far else 1.0 / MAX_NEAR_WEIGHT, "unit": 1.0 / weight}
    row = layout.row(layout.TARGET, **(values | aim_columns(aim, space)))
    if isinstance(aim, Box):
        return weight, (("aim_at_box", row),)
    return weight, ((f"sample_target_{type(aim).__name__.lower()}", row), ("aim_at_sampled_point", row))


def _checked_weight(source: Source, weight: float) -> float:
    """Return the largest weight; refuse one too small to scale sums by."""
    if not weight > MIN_SOLID_ANGLE:
        refuse(
            source,
            f"aim must subtend more than {MIN_SOLID_ANGLE:g} sr, got {short_repr(source.aim)}; come closer",
        )
    return weight


def aim_columns(aim: Shape, space: Space) -> dict[str, float]:
    """Return the columns of a target's shape, in scene lengths."""
    size = space.size
    if isinstance(aim, Box):
        return {f"half_{axis}": 0.5 * length / size for axis, length in zip("uvw", aim.size, strict=True)}
    if isinstance(aim, Triangle):
        return triangle_columns(aim, space)
    frame = layout.frame_columns(aim.frame)
    if isinstance(aim, Rectangle):
        return frame | {"half_u": 0.5 * aim.width / size, "half_v": 0.5 * aim.height / size}
    return frame | {"inner2": (aim.inner_radius / size) ** 2, "outer2": (aim.radius / size) ** 2}


def one_minus_cosine(radius: float, distance: float) -> float:
    """Return 1 − cos of the half angle of a sphere at a distance, without cancellation; 2 inside."""
    if distance <= radius:
        return 2.0
    sine2 = (radius / distance) ** 2
    return sine2 / (1.0 + math.sqrt(1.0 - sine2))
