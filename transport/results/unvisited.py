"""Diagnostic "unvisited surface": whether any history reached a small wall close to a detector.

A detector with next-event estimation knows the light from afar after a few histories.  The light of a small
wall close to it comes from the few histories that reach that wall, each with a score larger by the inverse
square of the distance.  Before the first of them the mean is too low, and nothing in the scores shows it.
The energy balance does: it has the absorbed weight of each surface, and so the number of histories that
reached it; geometry gives the score of one of them.
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
    """Findings for a detector with next-event estimation; total: mean weight of arrivals per history."""
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
    """The wall that may add most, if any; the bound is an irradiance or fluence rate [W m^-2].

    place: centre of the detector [m];  size: its extent [m], the least distance of a wall;  light: its
    irradiance, or a quarter of its fluence rate [W m^-2].
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
        what = f"light of {wall}, {distance:.3g} m away, not sampled: hardly any history has reached it"
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
    """Whether a surface lies behind the active side of a flat detector."""
    shape = None if detector is None else plan.scene.shape_of(detector)
    return isinstance(shape, FlatShape) and is_behind(surface.shape, shape, detector.side)


def _sent(surface: Surface) -> float:
    """Largest share of the incident weight that leaves a surface diffusely."""
    parts = [part for part in simple_parts(surface.material) if isinstance(part, Diffuse)]
    return max((part.albedo + part.transmission for part in parts), default=0.0)


def _visits(plan: Plan, batches: list[Batch], number: int, share: float, light: float) -> float:
    """Approximate number of histories of full weight that reached a surface, from its absorbed weight.

    A surface that absorbs nothing is assumed to receive the irradiance of the detector.
    """
    shape, histories = plan.scene.surfaces[number].shape, sum(batch.histories for batch in batches)
    if share >= 1:
        return math.inf if shape.is_infinite else shape.area * light * histories / plan.unit
    rows = [row for row, owner in enumerate(plan.owners) if owner == number]
    return sum(float(batch.absorbed[rows].sum()) for batch in batches) / (1 - share)
