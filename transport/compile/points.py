"""Lower point detectors: positions, sums, rays from births, and densities of phase functions.

The score of a point detector is not bounded. It is added to one of POINT_ROWS rows by its exponent, four
octaves per row, scaled to between 1/16 and 1. So no sum overflows or loses digits, and the rows give the
distribution of scores.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.layout import POINT_MIDDLE, POINT_OCTAVES, POINT_ROWS
from transport.compile.rows import Rows
from transport.geometry.solid import Box, Sphere
from transport.scene.bodies import body_bits_at
from transport.scene.media import Medium
from transport.scene.phase_functions import Tabulated
from transport.scene.points import PointDetector
from transport.validation import SceneError, refuse

if TYPE_CHECKING:
    from transport.compile.plan import Emitter, Plan

# Value of a sum of 1 in each row.
SCALES = np.ldexp(1.0, POINT_OCTAVES * (np.arange(POINT_ROWS) - POINT_MIDDLE + 1))
# [extents] Within this distance of a volume source's center, lines are sampled from the point instead.
NEAR_EXTENTS = 1.5


MAX_POINTS = 255  # values of a detector's number in the random number counter

RayPass = tuple[str, np.ndarray]  # name of a pass, and its row


@dataclass(frozen=True)
class PointPlan:
    """A point detector ready to run: its row of layout.POINT, and by emitter how births reach it."""

    detector: PointDetector
    row: np.ndarray
    births: list[RayPass | None]  # direct rays; None for beams
    # rays scattered once more; None where the medium around the point does not scatter
    detours: list[RayPass | None]
    has_other_scatterers: bool  # whether any other medium scatters

    @property
    def leg(self) -> int:
        """Return the lane's mark of rays to this detector that are to be scattered once more."""
        return 1 + int(self.row["number"])


def lower_points(plan: Plan) -> None:
    """Give each PointDetector its rows of sums, and fill its table."""
    if len(plan.scene.points) > MAX_POINTS:
        raise SceneError(f"Scene: at most {MAX_POINTS} PointDetectors, got {len(plan.scene.points)}")
    for number, detector in enumerate(plan.scene.points):
        rows = plan.add_rows(detector.name, Rows(plan.rows, (), (), POINT_ROWS))
        place = layout.vector_columns("", plan.space.place(detector.position))
        places = place | {"first": rows.first, "number": number}
        scatterers = _scatterers(plan)
        medium = _medium_row_at(plan, detector)
        medium = medium if medium in scatterers else -1
        by_flights = bool(scatterers - {medium})
        if by_flights and plan.tracking.forced:
            must = (
                "is not supported with Tracking(forced=True) where other media than the one around it scatter"
            )
            refuse(detector, f"{must}; omit forced=True")
        births = [_births(plan, emitter, detector, places) for emitter in plan.emitters]
        detours = [_scattered_births(emitter, places) if medium >= 0 else None for emitter in plan.emitters]
        row = layout.row(layout.POINT, **places, medium=medium)
        plan.points.append(PointPlan(detector, row, births, detours, by_flights))


def _scatterers(plan: Plan) -> set[int]:
    """Return the rows of media that scatter."""
    return set(np.flatnonzero(plan.media["phase"] != 0).tolist()) if scatters_anywhere(plan) else set()


def _medium_row_at(plan: Plan, detector: PointDetector) -> int:
    """Return the row of the medium around a point."""
    bits = int(body_bits_at(plan.scene, np.array([detector.position]))[0])
    return (bits & -bits).bit_length()


def _births(
    plan: Plan, emitter: Emitter, detector: PointDetector, places: dict[str, float]
) -> RayPass | None:
    """Return the pass and row of direct rays from births to the point; None for beams."""
    shape, emission = emitter.shape, emitter.source.emission
    is_near = math.dist(detector.position, shape.middle) < NEAR_EXTENTS * shape.extent
    if emission.fills_volume and is_near and isinstance(shape, Box | Sphere):
        return _volume_births(plan, shape, dict(places))
    if not (density := emitter.source.emission.ray_densities):
        return None
    return "cast_from_births", layout.row(layout.POINT_EMISSION, **places, **density)


def _scattered_births(emitter: Emitter, places: dict[str, float]) -> RayPass:
    """Return the pass and row of rays from births that are scattered once before the point."""
    density = emitter.source.emission.ray_densities
    name = "first_leg_from_births" if density else "first_leg_along_beams"
    return name, layout.row(layout.POINT_EMISSION, **places, **density)


def _volume_births(plan: Plan, shape, values: dict[str, float]) -> RayPass:
    """Return the pass and row of a uniformly emitting volume, sampled along lines through the point."""
    size = plan.space.size
    halves = [side / 2 for side in shape.size] if isinstance(shape, Box) else [shape.radius] * 3
    values |= {f"h{x}": half / size for x, half in zip("xyz", halves, strict=True)}
    values |= layout.center_columns(plan.space.place(shape.middle)) | {"scale": size**3 / shape.volume}
    return f"cast_from_{type(shape).__name__.lower()}", layout.row(layout.POINT_GLOW, **values)


def phase_densities(plan: Plan) -> list[RayPass]:
    """Return the pass that adds the density of each phase function, or part of one, and its row."""
    found = []
    for phase, number in plan.phase_numbers.items():
        for part, share in phase.weighted_parts:
            values = {"g": part.parameter, "share": share, "number": number}
            if isinstance(part, Tabulated):
                cosines, densities = (np.ascontiguousarray(array) for array in (part.mu, part.values))
                values |= {"cosines": plan.arena.place(cosines), "values": plan.arena.place(densities)}
                values |= {"cells": len(cosines) - 1}
            found.append((f"add_{part.law}_pdf", layout.row(layout.POINT_PHASE, **values)))
    return found


def scatters_anywhere(plan: Plan) -> bool:
    """Return whether any medium scatters, homogeneous or made of voxels."""
    return plan.scatters and bool(plan.phase_numbers)


def attenuates_anywhere(plan: Plan) -> bool:
    """Return whether any homogeneous medium attenuates."""
    return any(isinstance(medium, Medium) and medium.extinction > 0 for medium in plan.distinct_media)
