"""Whether a small wall close to what looks by rays has been visited at all: the classic trap of next-event estimation.

A detector to which every event tells what it sends there is sure of its light from afar after a few histories.  What a
small wall close to it sends comes by the few histories that come to that wall, each with a score that is larger by
the inverse square of the distance: until the first of these the mean is too low, and nothing in the scores tells.  The ledger does:
it knows how much each surface has absorbed, and so how many histories have come to it; geometry knows what one of them would add.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from transport.estimators import backward
from transport.estimators.expected import expects
from transport.materials import Diffuse, simple_parts
from transport.materials.surface import titled
from transport.results.findings import DOUBTFUL, Finding, unseen_scores
from transport.shapes import FlatShape
from transport.shapes.distances import is_behind, least_distance

if TYPE_CHECKING:
    from transport.compile.plan import Plan
    from transport.detectors import Detector
    from transport.materials import Surface
    from transport.results.batches import Batch
    from transport.results.estimates import Estimate
    from transport.results.meter_sums import MeterSums
    from transport.vectors import Vector


def unvisited_walls_of_detector(sums: MeterSums, total: Estimate) -> Iterator[Finding]:
    """Of a detector that events tell what they send there; total: the mean weight that arrived of a history."""
    plan, detector, shape = sums.plan, sums.detector, sums.shape
    if not (plan.expects and plan.turned is None and expects(plan.scene, detector) and total.error > 0):
        return
    light = total.value * plan.unit / shape.area
    for finding in unvisited_walls(
        plan, sums.batches, f"detector {detector.name!r}", shape.middle, shape.extent, light, detector
    ):
        yield replace(finding, bound=finding.bound * shape.area / plan.unit)


def unvisited_walls(
    plan: Plan,
    batches: list[Batch],
    title: str,
    place: Vector,
    size: float,
    light: float,
    detector: Detector | None = None,
) -> Iterator[Finding]:
    """The wall that may add most, with a bound of the irradiance, or of the fluence rate [W m^-2]; nothing where none may.

    place: of the middle of what looks [m];  size: its extent [m], closer than which a wall is not taken to be;
    light: its irradiance, or a quarter of its fluence rate [W m^-2].
    """
    histories = sum(batch.histories for batch in batches)
    found = []
    for number, surface in enumerate(plan.scene.surfaces):
        share = 0.0 if _cannot_light(plan, surface, detector) else _sent(surface)
        unseen = unseen_scores(_visits(plan, batches, number, share, light)) if share > 0 else 0.0
        if unseen > 0:
            distance = max(least_distance(surface.shape, place), size)
            if distance > 0:
                added = plan.unit / histories * share / (math.pi * distance**2)
                found.append((unseen * added, distance, titled(surface, number)))
    most, distance, wall = max(found, default=(0.0, 0.0, ""))
    if most > 0:
        what = f"light of {wall}, {distance:.3g} m away, not sampled: hardly any history has come to it"
        yield Finding(
            DOUBTFUL,
            title,
            "",
            what,
            most,
            backward.more_or_backward(plan.scene),
            name="unvisited surface",
        )


def _cannot_light(plan: Plan, surface: Surface, detector: Detector | None) -> bool:
    """Whether a surface lies behind the side that a flat detector looks from."""
    shape = None if detector is None else plan.scene.shape_of(detector)
    return isinstance(shape, FlatShape) and is_behind(surface.shape, shape, detector.side)


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
