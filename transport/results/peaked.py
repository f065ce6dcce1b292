"""Whether what is scattered sharply forward has come to what looks by rays: the other trap of next-event estimation.

Each collision tells what it sends towards a detector by the density of its phase function, which for g near 1 is next to nothing but
within a narrow cone.  The light that is scattered comes by the few collisions in whose cone the detector happens to lie, each with a
score as large as the cone is narrow: until some have come the mean is too low, and nothing in the scores tells.  What one of
them adds is known: the greatest density of the phase function over the square of a free path.
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
    """Of a detector that events tell what they send there; total: the mean weight that arrived of a history."""
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
    """The same of a point, with the bound as a fluence rate [W m^-2]."""
    if plan.scatters:
        worst = _worst(plan, nearest_collision(plan, Point(position=place)), float)
        cure = "use more particles, or a small VolumeDetector"
        yield from _finding(worst, plan.unit / histories, f"point detector {name!r}", cure)


def _worst(plan: Plan, gap: float, score) -> tuple[float, Medium | None]:
    """The most that one collision tells, and the medium that it is in.  gap: how near collisions can be [m]."""
    found = []
    for medium in plan.distinct_media:
        scattering = float(np.max(getattr(medium, "scattering", 0.0)))
        if scattering > 0:
            path = max(1.0 / float(np.max(medium.extinction)), gap)
            found.append((score(peak_of(medium.phase) / path**2), medium))
    return max(found, key=lambda one: one[0], default=(0.0, None))


def _finding(worst: tuple[float, Medium | None], each: float, title: str, cure: str) -> Iterator[Finding]:
    """each: what a history stands for.  Had some of the collisions come, the error would tell: the bound is that of none."""
    score, medium = worst
    if score > 0:
        angle = math.sqrt(1 / (math.pi * peak_of(medium.phase)))
        what = f"light that the {type(medium).__name__} scatters within {angle:.2g} rad of straight on hardly sampled"
        yield Finding(DOUBTFUL, title, "", what, unseen_scores(0) * score * each, cure, name="forward peak")
