"""Turn each source into emitters: one place of birth, one law of directions, and a target or none."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from transport.compile import layout, speeds
from transport.compile.media import POINT_OFFSET, body_row, boundary_rows, emitting_media, runs_along_boundary
from transport.compile.plan import Emitter, Plan, Step
from transport.compile.shapes import pass_name, point_to_mesh, primitive_of, shape_columns
from transport.compile.space import Space
from transport.geometry.flat import FlatShape
from transport.geometry.mesh import Mesh
from transport.geometry.relations import gap_lower_bound, least_height
from transport.geometry.revolved import Paraboloid, Revolved
from transport.geometry.shape import Point, Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.checks.refractive_indices import index_around
from transport.scene.emissions import DIRECTION_DENSITIES
from transport.scene.scene import Scene
from transport.scene.sheets import Sheet, source_sheets
from transport.scene.sources import Source
from transport.validation import SceneError, join_names, refuse, short_repr
from transport.vectors import dot

# [W or particles] bounds of the power of all sources, so that sums of scores stay normal numbers
MIN_POWER, MAX_POWER = 1e-300, 1e300
# [scene lengths] distance at which births start from a point where three detectors or more meet
POINT_START_OFFSET = 2.0**-47
MIN_SOLID_ANGLE = 1e-200  # [sr] least solid angle of a target
ENCLOSING_FACTOR = 1.0 + 2.0**-40  # of the radius of a sphere that encloses a shape
# Largest weight of a direction towards a target that may be near: half of the directions follow the source's
# own law.
MAX_NEAR_WEIGHT = 2.0


def lower_sources(plan: Plan, sheets: list[Sheet]) -> None:
    """Fill the emitters of all sources, media that emit included."""
    for source in (*plan.scene.sources, *emitting_media(plan.scene)):
        plan.emitters += emitters_of(plan, source, sheets)
    power = sum(emitter.bound for emitter in plan.emitters)  # may overflow to infinity
    if not MIN_POWER <= power <= MAX_POWER:
        must = f"must be between {MIN_POWER:g} and {MAX_POWER:g}"
        raise SceneError(
            f"Scene: the power of all sources together {must}, got {power:.3g}; use another unit"
        )


def emitters_of(plan: Plan, source: Source, sheets: list[Sheet]) -> Iterator[Emitter]:
    """Yield an emitter for each piece of a source."""
    scene, shape = plan.scene, plan.scene.shape_of(source)
    acting = {number for number, sheet in enumerate(sheets, 1) if sheet.members[0].surface is not None}
    for piece, share in _pieces_with_shares(source, shape):
        place = _place(plan, source, piece)
        law = speeds.drifting_law(plan, source, piece) or _law(source, piece)
        weight, target = _target(source, piece, plan.space)
        volume = source.emission.fills_volume and not isinstance(piece, Point)
        birth = _birth(source, piece, [] if volume else source_sheets(piece, sheets), acting)
        amount = source.amount(shape, scene.duration) * share
        moment, speed = speeds.birth_time_pass(source, scene.duration), speeds.speed_passes(plan, source)
        facing, medium = _normal_row(source, piece), medium_row(scene, source, piece)
        inside, beside = _birth_bodies(plan, source, piece)
        passes = birth, place, facing, law, moment, speed, target
        yield Emitter(source, piece, amount, weight, *passes, medium, inside, beside)


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
        # From some of its places the source itself may hide all glass.
        around = (index_around(scene, tuple(place)) for place in birth_points(source, piece, 1.0))
        known = (each for each in around if not math.isnan(each))
        is_apart = all(gap_lower_bound(piece, shape) > 0 for shape in glass)
        known = set(islice(known, 1)) if is_apart else set(known)
        if len(known) > 1:
            several = f"which lies in media of the indices {join_names(sorted(map(str, known)))}"
            refuse(source, f"shape must lie in one medium, got {short_repr(piece)}, {several}; divide it")
        index = known.pop() if known else math.nan
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


def _place(plan: Plan, source: Source, shape: Shape) -> Step:
    """Return the pass and the row by which places of birth are sampled."""
    births, columns = primitive_of(shape).births, shape_columns(shape, plan.space)
    side = -1.0 if source.is_back else 1.0
    if isinstance(shape, Mesh):
        return births, point_to_mesh(plan, shape, layout.row(layout.FACET_AREAS, side=side))
    if shape.hole is not None:
        return births, layout.row(layout.HOLED, columns)
    if isinstance(shape, Revolved) and not shape.is_closed:
        return _band(shape, columns, plan.space.size, side)
    if isinstance(shape, Sphere) and source.emission.fills_volume:
        births = "born_in_sphere"
    elif isinstance(shape, Sphere) and source.emission.law == "beam":
        births = "born_on_sphere_cross_section"
        columns |= layout.vector_columns("n", source.emission.direction)
    return births, layout.row(layout.PATCH, columns, side=side)


def _band(shape: Revolved, columns: dict[str, float], size: float, side: float) -> Step:
    """Return the pass and the row of a surface of revolution, by its area per height at both ends."""
    profile = shape.profile
    columns |= {"low": profile.low / size, "high": profile.high / size}
    if isinstance(shape, Paraboloid):
        heights = (4 * w / profile.beta for w in (profile.low, profile.high))  # in units of the focal length
        first, last = (math.expm1(1.5 * math.log1p(w)) for w in heights)
        return "born_on_paraboloid", layout.row(layout.BAND, columns, first=first, last=last, side=side)
    ends = [profile.area_per_height(w, w) for w in (profile.low, profile.high)]
    first, last = (end / max(ends) for end in ends)
    return "born_on_band", layout.row(layout.BAND, columns, first=first, last=last, side=side)


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
    is_volume = shape.is_closed and law == "isotropic"
    distance = shape.distance(aim.middle, filled=is_volume) / space.size
    parts = aim.primitives()
    if not (aim.is_flat or isinstance(aim, Box)) or len(parts) > 1:
        # Aim at the sphere itself, or at the sphere that encloses another shape.
        radius = aim.extent / space.size * (1.0 if aim.is_convex else ENCLOSING_FACTOR)
        weight = _checked_weight(source, peak * 2.0 * math.pi * one_minus_cosine(radius, distance))
        values = layout.center_columns(space.place(aim.middle)) | {law: peak, "unit": 1.0 / weight}
        row = layout.row(layout.TARGET, **values, half_u=radius)
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
    values = {law: peak, "area": area, "natural": 0.0 if far else 1.0 / MAX_NEAR_WEIGHT, "unit": 1.0 / weight}
    row = layout.row(layout.TARGET, shape_columns(whole, space), **values)
    if isinstance(aim, Box):
        return weight, (("aim_at_box", row),)
    return weight, ((f"sample_target_{pass_name(whole)}", row), ("aim_at_sampled_point", row))


def _checked_weight(source: Source, weight: float) -> float:
    """Return the largest weight; refuse one too small to scale sums by."""
    if not weight > MIN_SOLID_ANGLE:
        refuse(
            source,
            f"aim must subtend more than {MIN_SOLID_ANGLE:g} sr, got {short_repr(source.aim)}; come closer",
        )
    return weight


def one_minus_cosine(radius: float, distance: float) -> float:
    """Return 1 − cos of the half angle of a sphere at a distance, without cancellation; 2 inside."""
    if distance <= radius:
        return 2.0
    sine2 = (radius / distance) ** 2
    return sine2 / (1.0 + math.sqrt(1.0 - sine2))


# ---- Points just off the emitting side of a source, which decide its particles' medium of birth.

SURFACE_OFFSET = 1e-9  # of a source's extent: distance of the points from an emitting surface
POINTS_PER_SOURCE = 64  # number of points per source
# strides of a sequence that fills the unit cube evenly (Kronecker)
KRONECKER_STRIDES = 2.0 ** -(np.arange(1, 4) / 4)


def birth_points(source: Source, piece: Shape, size: float) -> np.ndarray:
    """Return points of one piece of a source [m], shape (n, 3). size: size of the scene [m]."""
    if isinstance(piece, Point):
        direction = np.array(source.emission.direction) if source.emission.law == "beam" else np.zeros(3)
        return np.array(piece.position)[None] + POINT_OFFSET * size * direction
    u = np.modf((np.arange(1, POINTS_PER_SOURCE + 1)[:, None]) * KRONECKER_STRIDES)[0]
    if not source.emission.has_side:
        return _points_in_volume(piece, u)
    places, normals = piece.sample_area(u)
    side = -1.0 if source.is_back else 1.0
    return places + side * max(SURFACE_OFFSET * piece.extent, POINT_OFFSET * size) * normals


def _points_in_volume(piece: Shape, u: np.ndarray) -> np.ndarray:
    """Return points evenly spread over a volume, shape (n, 3)."""
    middle = np.array(piece.middle)
    match piece:
        case Box(size=size):
            return middle + (u - 0.5) * np.array(size)
        case Sphere(radius=radius):
            return middle + radius * np.cbrt(u[:, 2:]) * _directions(u)
    return middle[None]


def _directions(u: np.ndarray) -> np.ndarray:
    mu, turn = 2 * u[:, 0] - 1, 2 * math.pi * u[:, 1]
    sine = np.sqrt((1 - mu) * (1 + mu))
    return np.stack([sine * np.cos(turn), sine * np.sin(turn), mu], axis=1)
