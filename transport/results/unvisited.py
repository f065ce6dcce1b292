"""Whether a small wall close to what looks by rays has been visited at all: the classic trap of next-event estimation.

A detector to which every event tells what it sends there is sure of its light from afar after a few histories.  What a
small wall close to it sends comes by the few histories that come to that wall, each with a score that is larger by
the inverse square of the distance: until the first of these the mean is too low, and nothing in the scores tells.  The ledger does:
it knows how much each surface has absorbed, and so how many histories have come to it; geometry knows what one of them would add.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from transport.estimators.expected import expects
from transport.materials import Diffuse, simple_parts
from transport.materials.surface import titled
from transport.shapes.distances import least_distance

if TYPE_CHECKING:
    from transport.compile.plan import Plan
    from transport.materials import Surface
    from transport.results.batches import Batch
    from transport.results.meter_sums import MeterSums
    from transport.results.quantities import Quantity
    from transport.vectors import Vector

FEW = 5.0  # histories that have come to a wall, below which it counts as not visited
MANY = 3.0  # standard errors that one more may add


def doubt_of_rays(sums: MeterSums, flux: Quantity) -> str | None:
    """A warning for a detector that events tell what they send there; flux: all that arrived at it."""
    plan, detector, shape = sums.plan, sums.detector, sums.shape
    if not (plan.expects and plan.turned is None and expects(plan.scene, detector)):
        return None
    light = float(np.max(flux.value)) / shape.area
    error = float(np.max(np.nan_to_num(flux.error))) / shape.area
    title = f"detector {detector.name!r}"
    return unvisited_wall(plan, sums.batches, title, shape.middle, shape.extent, light, error)


def unvisited_wall(
    plan: Plan, batches: list[Batch], title: str, place: Vector, size: float, light: float, error: float
) -> str | None:
    """A warning of the wall of which one visit would add most; None where none matters.

    place: of the middle of what looks [m];  size: its extent [m], closer than which a wall is not taken to be;
    light: its irradiance, or a quarter of its fluence rate;  error: one standard error of either, not divided [W m^-2].
    """
    if not error > 0:
        return None
    histories = sum(batch.histories for batch in batches)
    found = []
    for number, surface in enumerate(plan.scene.surfaces):
        share = _sent(surface)
        if share > 0 and _visits(plan, batches, number, share, light) < FEW:
            distance = max(least_distance(surface.shape, place), size)
            if distance > 0:
                added = plan.unit / histories * share / (math.pi * distance**2)
                found.append((added / error, distance, titled(surface, number)))
    most, distance, wall = max(found, default=(0.0, 0.0, ""))
    if most <= MANY:
        return None
    return (
        f"hardly any history has come to {wall}, {distance:.3g} m from {title}, and one that does would add {most:.2g}"
        " standard errors: if it is lit at all, the mean is too low; use more particles, or estimator='backward'"
    )


def _sent(surface: Surface) -> float:
    """The largest share of what comes to a surface that leaves it diffusely."""
    parts = [part for part in simple_parts(surface.material) if isinstance(part, Diffuse)]
    return max((part.albedo + part.transmission for part in parts), default=0.0)


def _visits(plan: Plan, batches: list[Batch], number: int, share: float, light: float) -> float:
    """About how many histories of full weight have come to a surface, going by what it absorbed.

    One that absorbs nothing is taken to be lit as the detector is.
    """
    shape, histories = plan.scene.surfaces[number].shape, sum(batch.histories for batch in batches)
    if share >= 1:
        return math.inf if shape.is_infinite else shape.area * light * histories / plan.unit
    rows = [row for row, owner in enumerate(plan.owners) if owner == number]
    return sum(float(batch.absorbed[rows].sum()) for batch in batches) / (1 - share)
