"""Rows of media: how each body's medium attenuates and scatters, and its phase functions."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.grids import fill_grids
from transport.geometry.relations import is_on_support
from transport.geometry.solid import Box, Sphere
from transport.scene.bodies import bits_of_bodies_at, body_bits_at, has_media, scene_bodies, scene_media
from transport.scene.emissions import Isotropic
from transport.scene.media import Grid
from transport.scene.phase_functions import Tabulated
from transport.scene.sources import Source
from transport.scene.tracking import Tracking
from transport.validation import SceneError
from transport.vectors import Vector, dot

if TYPE_CHECKING:
    from transport.compile.plan import Plan
    from transport.scene.scene import Scene


# [scene lengths]: rounding would change a shorter free path by more than 2^-16 of itself
MIN_FREE_PATH = 2.0**16 * layout.COLLISION_CLEARANCE
POINT_OFFSET = 2.0**-40  # [scene lengths] distance of a point that is surely beside a surface
ANALOG, WEIGHTED = "analog", "weighted"


def default_tracking(scene: Scene) -> Tracking:
    """Return the default treatment of absorption: weighted, or analog with a clock.

    Measured by python -m tests.bench.tracking.
    """
    return Tracking(absorption=WEIGHTED if scene.duration is None else ANALOG)


def lower_media(plan: Plan) -> None:
    """Fill the plan's tables of media and phase functions, where the scene has any."""
    plan.has_media = has_media(plan.scene)
    if not plan.has_media:
        return
    plan.distinct_media = scene_media(plan.scene)
    if plan.tracking.forced and any(isinstance(medium, Grid) for medium in plan.distinct_media):
        raise SceneError(
            "simulate: tracking must not be forced in a scene with a Grid, got forced=True; omit it"
        )
    if plan.has_clock and plan.has_speeds and any(medium.index != 1 for medium in plan.distinct_media):
        raise SceneError(
            "Scene: with a clock, Snapshots, PhaseSpaces, speeds and moments need media of index=1;"
            " omit them, or give the medium index=1"
        )
    for medium in plan.distinct_media:
        _check_density(plan, medium)
    plan.phase_laws = list(_phase_laws(plan))
    plan.bodies = bodies = scene_bodies(plan.scene)
    plan.media = np.array(
        [_media_row(plan, plan.distinct_media[0])] + [_media_row(plan, body.medium) for body in bodies],
        layout.MEDIA,
    )
    fill_grids(plan, plan.tracking.absorption == ANALOG)


def _check_density(plan: Plan, medium) -> None:
    """Refuse media whose mean free path is so short that rounding matters.

    Collisions keep a distance of rounding from surfaces, next to which a free path must be long. So must it
    where a VolumeDetector sums path lengths; absorbed weight alone is exact in a medium that only absorbs.
    """
    if not (_scatters(medium) or (plan.scene.volumes and np.any(medium.absorption))):
        return
    path, size = 1.0 / float(np.max(medium.extinction)), plan.space.size
    if path < MIN_FREE_PATH * size:
        cure = "bring far objects nearer, for example replace a far lamp by an equivalent Disk source"
        if not _scatters(medium):
            cure += ", reduce the absorption (it stays opaque), or omit the VolumeDetectors"
        raise SceneError(
            f"{type(medium).__name__}: mean free paths must be above {MIN_FREE_PATH * size:.2g} m in a scene"
            f" of {size:.2g} m, got {path:.2g} m; {cure}"
        )


def _media_row(plan: Plan, medium) -> np.ndarray:
    """Return the row (layout.MEDIA) of a medium."""
    length, values = plan.space.size, {"index": medium.index}
    if isinstance(medium, Grid):  # its coefficients are in its own row (compile/grids.py)
        survival = 0.0 if plan.tracking.absorption == ANALOG and medium.absorption.any() else 1.0
        phase = plan.phase_numbers[medium.phase] if _scatters(medium) else 0
        return layout.row(layout.MEDIA, **values, mfp=math.inf, survival=survival, phase=phase)
    sigma_a, sigma_s = medium.absorption * length, medium.scattering * length
    values |= {"mfp": _free_path(sigma_s), "sigma_a": sigma_a, "survival": 1.0}
    if plan.tracking.absorption == ANALOG:
        survival = medium.albedo if medium.extinction > 0 else 1.0
        values |= {"mfp": _free_path(sigma_a + sigma_s), "sigma_a": 0.0, "survival": survival}
    if medium.scattering > 0:
        values |= {"phase": plan.phase_numbers[medium.phase]}
    return layout.row(layout.MEDIA, **values)


def _free_path(sigma: float) -> float:
    """Return the mean free path for a coefficient; infinite for 0."""
    return 1.0 / sigma if sigma > 0 else math.inf


def _phase_laws(plan: Plan):
    """Yield the pass and the row of each phase function, or part of a mixture, by number."""
    number, plan.phase_numbers = 1, {}
    for medium in plan.distinct_media:
        if _scatters(medium) and medium.phase not in plan.phase_numbers:
            plan.phase_numbers[medium.phase] = number
            parts = medium.phase.weighted_parts
            shares = np.cumsum([share for _, share in parts])
            for (phase, _), share in zip(parts, shares, strict=True):
                values = {"g": phase.parameter, "share": share, "number": number, "parts": len(parts)}
                if isinstance(phase, Tabulated):
                    rows = tabulated_rows(phase)
                    values |= {"rows": plan.arena.place(rows), "count": len(rows)}
                yield f"scatter_{phase.law}", layout.row(layout.PHASE_LAW, **values)
                number += 1


def _scatters(medium) -> bool:
    return bool(np.any(np.asarray(medium.scattering) > 0))


def emitting_media(scene: Scene) -> list[Source]:
    """Return media that emit, as sources that fill their bodies."""
    glowing = [body for body in scene_bodies(scene) if body.medium.emission > 0]
    shapes = [(scene.surfaces[body.surfaces[0]].shape, body.medium.emission) for body in glowing]
    return [Source(shape, Isotropic(power=4 * math.pi * shape.volume * glow)) for shape, glow in shapes]


def importance_row(plan: Plan) -> np.ndarray:
    """Return the row of the importance, which rises from the start of the plan's Splitting to its end."""
    law = plan.tracking.splitting
    start, end = (np.array(plan.space.place(place)) for place in (law.start, law.end))
    extent, most = end - start, math.log(law.gain)
    length = float(np.linalg.norm(extent))
    slope = layout.vector_columns("k", most * extent / length / length)
    return layout.row(
        layout.IMPORTANCE,
        **layout.center_columns(tuple(start)),
        **slope,
        most=most,
        has_grids=len(plan.grids),
    )


WALL_THRESHOLD = 0.5  # threshold where walls alone reduce weights


def roulette_row(plan: Plan) -> np.ndarray:
    """Return the row of Russian roulette: its threshold, and the weight of survivors.

    Where media reduce weights, both are those of the plan's Tracking. Survivors as heavy as at birth would be
    rare among light scores, and standard errors would not show it.
    """
    if not plan.reduces_weights:
        return layout.row(layout.ROULETTE_LAW, threshold=WALL_THRESHOLD, level=1.0)
    law = plan.tracking
    return layout.row(layout.ROULETTE_LAW, threshold=law.roulette, level=law.survivors_weight)


PARALLEL_COSINE = 1e-15  # cosine of a direction within rounding of a plane
PROBE_DIRECTIONS = np.array([direction for direction in product((-1.0, -0.37, 0.61, 1.0), repeat=3)])


def boundary_rows(plan: Plan, position: Vector) -> tuple[np.ndarray, list[np.ndarray]] | None:
    """Return the row of births at an isotropic point source, and a row per boundary that it lies on.

    None where it lies on a boundary whose normal is not known here.
    """
    # Probe the bodies around the point in 64 directions.
    directions = PROBE_DIRECTIONS / np.linalg.norm(PROBE_DIRECTIONS, axis=1)[:, None]
    bits = body_bits_at(plan.scene, np.tile(position, (len(directions), 1)), directions)
    inside, rows = int(np.bitwise_or.reduce(bits)), []
    for number, body in enumerate(plan.bodies):
        if not inside >> number & 1 or (bits >> number & 1).all():
            continue
        for surface, is_front in body.faces:
            for piece in plan.scene.surfaces[surface].shape.pieces():
                if not (piece.is_flat or isinstance(piece, Sphere)):
                    return None
                if is_on_support(position, piece):
                    out = piece.normal if piece.is_flat else np.array(position) - piece.center
                    out = np.array(out) / np.linalg.norm(out) * (-1.0 if is_front else 1.0)
                    normal = layout.vector_columns("n", out)
                    rows.append(layout.row(layout.BIRTH_BOUNDARY, **normal, bit=1 << number))
    return layout.row(layout.BIRTH_BODIES, inside=inside), rows


def runs_along_boundary(plan: Plan, position: Vector, direction: Vector) -> bool:
    """Return whether a ray from a position runs along the boundary of a body."""
    for body in plan.bodies:
        for surface, _ in body.faces:
            for piece in plan.scene.surfaces[surface].shape.pieces():
                is_along = piece.is_flat and abs(dot(piece.normal, direction)) <= PARALLEL_COSINE
                if is_along and is_on_support(position, piece):
                    across = (
                        POINT_OFFSET * plan.space.size * np.array([[1.0], [-1.0]]) * np.array(piece.normal)
                    )
                    bits = body_bits_at(plan.scene, np.array(position) + across)
                    if bits[0] != bits[1]:
                        return True
    return False


def box_rows(plan: Plan) -> list[np.ndarray]:
    """Return a row of the edges of each body that is a Box with faces that do nothing."""
    rows, size = [], plan.space.size
    for number, body in enumerate(plan.bodies):
        surface = plan.scene.surfaces[body.surfaces[0]]
        if isinstance(surface.shape, Box) and not surface.material.acts:
            half = dict(
                zip(("hx", "hy", "hz"), (0.5 * side / size for side in surface.shape.size), strict=True)
            )
            center = layout.center_columns(plan.space.place(surface.shape.center))
            rows.append(layout.row(layout.BODY_BOX, **center, **half, bit=1 << number))
    return rows


def body_row(plan: Plan, positions: np.ndarray) -> np.ndarray | None:
    """Return the row of births at these positions [m]; None where they lie in different bodies."""
    bits = np.unique(body_bits_at(plan.scene, positions))
    if len(bits) > 1:
        return None
    inside = int(bits[0])
    return layout.row(layout.BIRTH_BODIES, inside=inside)


# ---- Rows of a tabulated phase function: segments of the table, sampled by the alias method.
#
# Each row keeps its segment for part of its probability 1/rows and yields the rest to another segment (Walker
# 1977, built as in Vose 1991). A sample thus costs one row whatever the table's length, and follows the
# table's piecewise linear density exactly.

# kept: share of the row's samples that its own segment keeps; the others go to the other segment.
# start: 1 - |mu| at the end of a segment nearer to the peak (mu = 1, or mu = -1 where width < 0); |width|:
# its width in mu.
# share: the density at that end over the sum of the densities at both ends.
SEGMENT_COLUMNS = ("kept", "start", "width", "share", "other_start", "other_width", "other_share", "unused")
SEGMENT = np.dtype([(name, "f8") for name in SEGMENT_COLUMNS])
END_COLUMNS = ("start", "width", "share")


def tabulated_rows(phase: Tabulated) -> np.ndarray:
    """Return rows of SEGMENT: segments of nonzero weight, padded to a power of two."""
    segments, weights = _segments(phase.mu, phase.values)
    count = 1 << max(len(weights) - 1, 0).bit_length()
    kept, other = _alias_table(np.concatenate([weights, np.zeros(count - len(weights))]))
    rows = np.zeros(count, SEGMENT)
    rows["kept"] = kept
    for column, values in zip(END_COLUMNS, segments, strict=True):
        rows[column][: len(weights)] = values
        rows[f"other_{column}"] = values[other]
    return rows


def _segments(mu: np.ndarray, density: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (start, width, share) of the segments of nonzero weight, and their relative weights.

    A segment across mu = 0 is measured from its nearer end: 1 - |mu| continues beyond 1.
    """
    low, high, at_low, at_high = mu[:-1], mu[1:], density[:-1], density[1:]
    widths, sums = high - low, at_low + at_high
    is_forward = low + high >= 0
    start = np.where(is_forward, 1 - high, 1 + low)
    share = np.where(is_forward, at_high, at_low) / np.where(sums > 0, sums, 1.0)
    met = widths * sums > 0
    return np.stack([start, np.where(is_forward, widths, -widths), share])[:, met], (widths * sums)[met]


def _alias_table(weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (kept, other) per row: rows lighter than average stay whole, and heavier ones fill them up."""
    left = weights * (len(weights) / weights.sum())
    kept, other = np.ones(len(weights)), np.arange(len(weights))
    light = [int(k) for k in np.flatnonzero(left < 1)]
    heavy = [int(k) for k in np.flatnonzero(left >= 1)]
    while light and heavy:
        k, donor = light.pop(), heavy[-1]
        kept[k], other[k] = left[k], donor
        left[donor] -= 1 - left[k]
        if left[donor] < 1:
            light.append(heavy.pop())
    return kept, other


# ---- Bounding boxes of finite bodies, which reveal lost particles.
#
# A particle in a finite body has a surface ahead; one that has none was lost by rounding.

BOX_MARGIN = 2.0**-20  # of the size of a body's box: a path that ends that far beyond the box is outside
FAR_FACTOR = 1e3  # sizes of a body: a distance surely outside its surfaces


def bounded_rows(plan: Plan) -> list[np.ndarray]:
    """Return a row (layout.BODY_BOUNDS) of the surroundings and of each body; 0 where unbounded."""
    return [
        layout.row(layout.BODY_BOUNDS),
        *(_bounds_row(plan, number) for number in range(len(plan.bodies))),
    ]


def _bounds_row(plan: Plan, number: int) -> np.ndarray:
    box = _bounding_box(plan, plan.bodies[number])
    if box is None:
        return layout.row(layout.BODY_BOUNDS)
    low, high = (np.array(plan.space.place(corner)) for corner in box.tolist())
    margin = BOX_MARGIN * float((high - low).max())
    columns = {f"low_{axis}": value for axis, value in zip("xyz", low - margin, strict=True)}
    columns |= {f"high_{axis}": value for axis, value in zip("xyz", high + margin, strict=True)}
    return layout.row(layout.BODY_BOUNDS, **columns, bit=1 << number)


def _bounding_box(plan: Plan, body) -> np.ndarray | None:
    """Return the lower and upper corner [m] of a finite body; None for an unbounded one."""
    shapes = [plan.scene.surfaces[number].shape for number in body.surfaces]
    if any(shape.is_infinite for shape in shapes):
        return None
    bounds = np.array([shape.bounds for shape in shapes])
    box = np.array([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])
    far = box.mean(axis=0) + FAR_FACTOR * float(np.ptp(box, axis=0).max()) * np.array(
        list(product((-1, 1), repeat=3))
    )
    is_endless = bits_of_bodies_at(plan.scene, far, [plan.bodies.index(body)]).any()
    return None if is_endless else box
