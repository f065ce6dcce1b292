"""Diagnostic "forward peak": whether next-event estimation has sampled sharply forward scattering.

Each collision scores at a detector by the density of its phase function, which for g near 1 is next to
nothing outside a narrow cone.  The scattered light comes from the few collisions whose cone contains the
detector, each with a score as large as the cone is narrow.  Until some have come the mean is too low, and
nothing in the scores shows it.  The score of one is known: the largest density of the phase function over the
square of a free path.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.expected import nearest_collision, peak_of
from transport.estimators import backward
from transport.estimators.expected import expects
from transport.results.findings import DOUBTFUL, Finding, unseen_scores
from transport.shapes import Point

if TYPE_CHECKING:
    from transport.compile.plan import Plan
    from transport.media import Medium
    from transport.results.estimates import Estimate
    from transport.results.meter_sums import MeterSums
    from transport.vectors import Vector


def forward_peaks_of_detector(sums: MeterSums, total: Estimate) -> Iterator[Finding]:
    """Findings for a detector with next-event estimation; total: mean weight of arrivals per history."""
    plan, detector, shape = sums.plan, sums.detector, sums.shape
    told = plan.expects and plan.turned is None and expects(plan.scene, detector)
    if not (told and plan.scatters and total.error > 0):
        return
    gap, histories = nearest_collision(plan, shape), int(sums.run.sizes.sum())
    worst = _worst(plan, gap, lambda density: min(1.0, density * shape.area))
    yield from _finding(
        worst, 1 / histories, f"detector {detector.name!r}", backward.more_or_backward(plan.scene)
    )


def forward_peaks_of_point(plan: Plan, name: str, place: Vector, histories: int) -> Iterator[Finding]:
    """Findings for a point, with bounds as fluence rates [W m^-2]."""
    if plan.scatters:
        worst = _worst(plan, nearest_collision(plan, Point(position=place)), float)
        cure = "use more particles, or a small VolumeDetector"
        yield from _finding(worst, plan.unit / histories, f"point detector {name!r}", cure)


def _worst(plan: Plan, gap: float, score) -> tuple[float, Medium | None]:
    """The largest score of one collision, and the medium of it; gap: least distance of collisions [m]."""
    found = []
    for medium in plan.distinct_media:
        scattering = float(np.max(getattr(medium, "scattering", 0.0)))
        if scattering > 0:
            path = max(1.0 / float(np.max(medium.extinction)), gap)
            found.append((score(peak_of(medium.phase) / path**2), medium))
    return max(found, key=lambda one: one[0], default=(0.0, None))


def _finding(worst: tuple[float, Medium | None], each: float, title: str, cure: str) -> Iterator[Finding]:
    """The finding; each: weight of a history.

    The bound assumes no such score, since the error would show one.
    """
    score, medium = worst
    if score > 0:
        angle = math.sqrt(1 / (math.pi * peak_of(medium.phase)))
        what = (
            f"light scattered by the {type(medium).__name__} within {angle:.2g} rad of the forward direction"
            " hardly sampled"
        )
        yield Finding(DOUBTFUL, title, "", what, unseen_scores(0) * score * each, cure, name="forward peak")
