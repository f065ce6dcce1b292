"""What a run knows of the quality of its error bars: by quantity, and in words where one is not to be trusted.

What can be told: that a few scores carry an error, that the largest thin out too slowly, that batches differ, that heavy
births of an aim have not scored, that a run backwards hardly met a source, that a point is too near to a wall.  What cannot:
light of a kind of which nothing has come and that nothing foretells, as by a small plate that no history of a forward run
has found.  The largest size of rays is no help there: in sound scenes as well hardly any comes up to it.

Scores of volume detectors, and of runs backwards with more than one bin or sensor, count as if alike; how many come
together is told by the batches.  So it is with all bins, and fluence rates from crossings (weight/|mu|).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from transport.results.backward_readings import BackwardReading
from transport.results.estimates import Estimate
from transport.results.meter_sums import ARRIVALS, DEPARTURES
from transport.results.point_readings import PointReading
from transport.results.quality import Quality, quality_of
from transport.results.readings import Reading
from transport.results.scores import Scores
from transport.results.sizes import scores_of_meter
from transport.results.volume_readings import VolumeReading
from transport.units import Unit
from transport.validation import SceneError, listed

if TYPE_CHECKING:
    from transport.results.result import Result

SIDES = {
    "flux_in": ARRIVALS, "irradiance": ARRIVALS, "energy_in": ARRIVALS,
    "flux_out": DEPARTURES, "exitance": DEPARTURES, "energy_out": DEPARTURES,
}  # fmt: skip
CURE = (
    "use more particles, or aim the sources, another estimator or a Splitting, so that scores are more alike"
)


def quality_in(result: Result, name: str | Estimate) -> Quality:
    """The quality of the quantity called "detector.quantity", or of an Estimate.  Raises SceneError for an array of them."""
    if isinstance(name, Estimate):
        return quality_of(name, None, result.particles, result.cost.seconds if result.cost else math.nan)
    estimate = result.quantity(name)
    if not isinstance(estimate, Estimate):
        raise SceneError(
            f"quality: {name!r} has bins, {estimate!r}; pass one of its elements, or the name of a quantity of the"
            " whole shape such as flux_in"
        )
    detector, _, quantity = name.partition(".")
    scores = _scores_behind(result[detector], quantity)
    seconds = result.cost.seconds if result.cost else math.nan
    return quality_of(estimate, scores, result.particles, seconds)


def doubts_of(result: Result) -> list[str]:
    """A warning for each detector whose totals have an error that is not to be trusted, if it has none yet."""
    found, unscored = [], []
    for look in (*result.scene.meters, *result.scene.volumes, *result.scene.points):
        reading = result[look.name]
        if not isinstance(reading, Reading | PointReading | VolumeReading) or reading.warning is not None:
            continue
        if reading.is_blind:
            unscored += [] if reading.cannot_arrive else [f"{reading.title}{look.name!r}"]
            continue
        judged = ((title, q) for title, q in _totals(result, reading) if not math.isnan(q.relative_error))
        doubted = ((title, q.doubts[0]) for title, q in judged if not q.is_sound)
        title, doubt = next(doubted, (None, None))
        if doubt:
            found.append(f"the error of {title} is not to be trusted: {doubt}; {CURE}")
    if unscored:
        particles = f"{result.particles} particle{'s' * (result.particles > 1)}"
        have = "has no score" if len(unscored) == 1 else "have no score"
        found.append(f"{listed(unscored)} {have} in {particles}: unknown, not 0. {CURE[0].upper()}{CURE[1:]}")
    return found


def _totals(result: Result, reading: Reading | PointReading | VolumeReading) -> Iterator[tuple[str, Quality]]:
    """What a detector counted over its whole shape, all times and speeds, on each side."""
    if isinstance(reading, PointReading):
        yield (
            f"point detector {reading.name!r}",
            quality_of(reading.fluence_rate, reading.scores, result.particles),
        )
        return
    if isinstance(reading, VolumeReading):
        yield (
            f"the fluence rate in volume detector {reading.name!r}",
            quality_of(reading.whole, reading.scores, result.particles),
        )
        return
    sums = reading.sums
    for side, title in ((ARRIVALS, "flux_in"), (DEPARTURES, "flux_out")):
        weights = sums.whole("weights", side).sum(axis=(1, 2))
        if weights.any() and not reading.is_sure(side):
            total = Estimate(weights / result.run.sizes, result.run, Unit())
            scores = _scores_on(reading, side)
            yield f"{title} of detector {reading.name!r}", quality_of(total, scores, result.particles)


def _scores_behind(reading: object, quantity: str) -> Scores | None:
    """The scores that add up to a quantity; None where their sizes are not known."""
    if isinstance(reading, PointReading) and quantity == "fluence_rate":
        return reading.scores
    if isinstance(reading, Reading) and quantity in SIDES:
        return _scores_on(reading, SIDES[quantity])
    if isinstance(reading, VolumeReading) and quantity in ("fluence_rate", "fluence"):
        return reading.scores
    return None


def _scores_on(reading: Reading, side: int) -> Scores | None:
    """The scores of one side of a meter."""
    found = reading.scores if isinstance(reading, BackwardReading) else scores_of_meter(reading.sums, side)
    # Sobol's points leave no gaps: an error is then far less than single scores are apart, and no larger one is due.
    is_even = reading.sums.plan.method.sampling == "sobol"
    return replace(found, most=0.0) if found is not None and is_even else found
