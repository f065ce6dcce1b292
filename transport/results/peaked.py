"""Whether what is scattered sharply forward has come to what looks by rays: the other trap of next-event estimation.

Each collision tells what it sends towards a detector by the density of its phase function, which for g near 1 is next to nothing but
within a narrow cone.  The light that is scattered comes by the few collisions in whose cone the detector happens to lie, each with a
score as large as the cone is narrow: until some have come the mean is too low, and nothing in the scores tells.  What one of
them adds is known: the greatest density of the phase function over the square of a free path.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.expected import nearest_collision, peak_of
from transport.estimators.expected import expects
from transport.results.unvisited import MANY
from transport.shapes import Point

if TYPE_CHECKING:
    from transport.compile.plan import Plan
    from transport.media import Medium
    from transport.results.meter_sums import MeterSums
    from transport.results.quantities import Quantity
    from transport.vectors import Vector


def doubt_of_forward_rays(sums: MeterSums, flux: Quantity) -> str | None:
    """A warning for a detector that events tell what they send there; flux: all that arrived at it."""
    plan, detector, shape = sums.plan, sums.detector, sums.shape
    told = plan.expects and plan.turned is None and expects(plan.scene, detector)
    if not (told and plan.scatters):
        return None
    error = float(np.max(np.nan_to_num(flux.error)))
    gap, histories = nearest_collision(plan, shape), int(sums.run.sizes.sum())
    cure = "use more particles, or estimator='backward'"
    worst = _worst(plan, gap, lambda density: min(1.0, density * shape.area))
    return _said(worst, plan.unit / histories, error, f"detector {detector.name!r}", cure)


def doubt_of_forward_point(plan: Plan, name: str, place: Vector, error: float, histories: int) -> str | None:
    """The same of a point; error: that of its fluence rate [W m^-2]."""
    if not plan.scatters:
        return None
    worst = _worst(plan, nearest_collision(plan, Point(position=place)), float)
    return _said(
        worst,
        plan.unit / histories,
        error,
        f"point detector {name!r}",
        "use more particles, or a small VolumeDetector",
    )


def _worst(plan: Plan, gap: float, score) -> tuple[float, Medium | None]:
    """The most that one collision tells, and the medium that it is in.  gap: how near collisions can be [m]."""
    found = []
    for medium in plan.distinct_media:
        scattering = float(np.max(getattr(medium, "scattering", 0.0)))
        if scattering > 0:
            path = max(1.0 / float(np.max(medium.extinction)), gap)
            found.append((score(peak_of(medium.phase) / path**2), medium))
    return max(found, key=lambda one: one[0], default=(0.0, None))


def _said(worst: tuple[float, Medium | None], each: float, error: float, title: str, cure: str) -> str | None:
    """each: the power that a history stands for [W]."""
    score, medium = worst
    if not error > 0 or score * each <= MANY * error:
        return None
    angle = math.sqrt(1 / (math.pi * peak_of(medium.phase)))
    return (
        f"the {type(medium).__name__} scatters within about {angle:.2g} rad of straight on, and one collision that happens to point at"
        f" {title} would add {score * each / error:.2g} standard errors: hardly any has, so what is scattered may be missing; {cure}"
    )
