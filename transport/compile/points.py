"""Point detectors as rows: where they are, where their sums lie, what births send them and how media scatter.

A score is not bounded: it is entered into one of POINT_ROWS rows by its exponent, four octaves a row, scaled to between 1/16
and 1.  So no sum overflows, none loses digits, and the rows tell how scores are spread.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.layout import POINT_MIDDLE, POINT_OCTAVES, POINT_ROWS
from transport.emissions import Isotropic, Lambertian
from transport.media import HenyeyGreenstein, Medium, Rayleigh, Tabulated
from transport.points import PointDetector
from transport.shapes import Box, Sphere
from transport.validation import refuse

if TYPE_CHECKING:
    from transport.compile.emitters import Emitter
    from transport.compile.plan import Plan

SCALES = np.ldexp(
    1.0, POINT_OCTAVES * (np.arange(POINT_ROWS) - POINT_MIDDLE + 1)
)  # what a sum of 1 in each row is
NEAR = 1.5  # distances of a point from the middle of a volume source, over its extent, within which lines are drawn from the point


@dataclass(frozen=True)
class PointPlan:
    """A point detector made ready: its row of layout.POINT, and one of how each emitter's births reach it (None: not)."""

    detector: PointDetector
    row: np.ndarray
    births: list[tuple[str, np.ndarray] | None] = field(default_factory=list)


def fill_points(plan: Plan) -> None:
    """A row for each PointDetector; their sums lie behind those of the volumes."""
    for number, detector in enumerate(plan.scene.points):
        if plan.tracking.forced:
            refuse(
                detector,
                "does not go with Tracking(forced=True), whose flights are of another law; leave it out",
            )
        place = dict(zip("xyz", plan.space.place(detector.position), strict=True))
        plan.bases[detector.name] = plan.rows
        row = layout.row(layout.POINT, **place, first=plan.rows, number=number)
        plan.point_rows += POINT_ROWS
        births = [_births(plan, emitter, detector, row, place) for emitter in plan.emitters]
        plan.points.append(PointPlan(detector, row, births))


def _births(
    plan: Plan, emitter: Emitter, detector: PointDetector, row: np.ndarray, place: dict[str, float]
) -> tuple[str, np.ndarray] | None:
    """The pass by which births are seen from the point, and its row; None for beams."""
    shape, values = emitter.shape, place | {"first": row["first"]}
    match emitter.source.emission:
        case Lambertian():
            return "cast_from_births", layout.row(layout.POINT_EMISSION, **values, lambertian=1 / math.pi)
        case Isotropic():
            is_near = math.dist(detector.position, shape.middle) < NEAR * shape.extent
            if not (is_near and isinstance(shape, Box | Sphere)):
                return "cast_from_births", layout.row(
                    layout.POINT_EMISSION, **values, isotropic=0.25 / math.pi
                )
            return _glow(plan, shape, values | {"number": row["number"]})
    return None


def _glow(plan: Plan, shape, values: dict[str, float]) -> tuple[str, np.ndarray]:
    """A volume that emits uniformly, along lines through the point."""
    size = plan.space.size
    halves = [side / 2 for side in shape.size] if isinstance(shape, Box) else [shape.radius] * 3
    values |= {f"h{x}": half / size for x, half in zip("xyz", halves, strict=True)}
    values |= layout.center_columns(plan.space.place(shape.middle)) | {"scale": size**3 / shape.volume}
    return f"cast_from_{type(shape).__name__.lower()}", layout.row(layout.POINT_GLOW, **values)


def phase_densities(plan: Plan) -> list[tuple[str, np.ndarray]]:
    """The pass that adds up the density of each phase function, or part of one, and its row."""
    found = []
    for phase, number in plan.phase_numbers.items():
        for part, share in getattr(phase, "parts", ((phase, 1.0),)):
            name, values = _density(plan, part)
            found.append((name, layout.row(layout.POINT_PHASE, **values, share=share, number=number)))
    return found


def _density(plan: Plan, phase) -> tuple[str, dict[str, float]]:
    match phase:
        case HenyeyGreenstein(g=g) if g != 0:
            return "weigh_by_henyey_greenstein", {"g": g}
        case Rayleigh():
            return "weigh_by_rayleigh", {}
        case Tabulated():
            cosines, values = (np.ascontiguousarray(array) for array in (phase.mu, phase.values))
            plan.kept += [cosines, values]
            columns = {"cosines": cosines.ctypes.data, "values": values.ctypes.data}
            return "weigh_by_table", columns | {"cells": len(cosines) - 1}
    return "weigh_isotropically", {}


def scatters_anywhere(plan: Plan) -> bool:
    """Whether flights are scattered in any medium, homogeneous or of voxels."""
    return plan.scatters and bool(plan.phase_numbers)


def dims_anywhere(plan: Plan) -> bool:
    """Whether any homogeneous medium lessens what passes through it."""
    return any(isinstance(medium, Medium) and medium.extinction > 0 for medium in plan.distinct_media)
