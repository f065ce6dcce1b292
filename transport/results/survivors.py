"""Diagnostic "roulette survivors": whether survivors of roulette may be missing from a number and its error.

Roulette ends light histories and makes a few of them heavier.  If all arrivals at a detector are far lighter,
a run may end before the first survivor arrives: its mean is then too low, and its error measures the spread
of the light ones alone.  Such a run can be recognised: a single survivor would add more than the error
allows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.plan import Plan
from transport.results.batches import Batch
from transport.results.findings import DOUBTFUL, Finding, unseen_scores
from transport.results.in_parts import replicates_of
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.results.estimates import Estimate
    from transport.results.meter_sums import MeterSums

NOISELESS = 1e-6  # relative error below which scores have not passed a medium by chance


def roulette_survivors(sums: MeterSums, side: int, total: Estimate) -> Iterator[Finding]:
    """Findings for a detector's side, with bounds as mean weights of a history.

    total: the mean of arrivals.
    """
    detector, plan = sums.detector, sums.plan
    if detector.events is None or detector.events[1] > 0:
        bins = None
        if _thins_out(plan) and (sums.place_axes or sums.direction_axes) and not sums.is_large:
            bins = sums.by_direction("weights", side)
        title = f"detector {detector.name!r}"
        yield from missing_survivors(plan, sums.batches, title, total, sums.shape.middle, bins)


def missing_survivors(
    plan: Plan,
    batches: list[Batch],
    title: str,
    total: Estimate,
    place: Vector,
    bins: np.ndarray | None = None,
    most: float = 1.0,
) -> Iterator[Finding]:
    """Survivors of roulette of which none may have come, near a place [m].

    total: mean score of histories there;  bins: the sums of its bins, (B, *dims), if any;  most: score in one
    of them of a history of the largest birth weight.  The bound, in the unit of `total`, covers survivors
    that did not come, or all weight for which roulette was played if that is less.  Nothing if no medium
    played roulette.
    """
    if not _thins_out(plan) or total.error <= NOISELESS * total.value:
        return
    histories = sum(batch.histories for batch in batches)
    born = sum(batch.born for batch in batches) / histories
    if born == 0:  # an aim behind its source: nothing can be missing
        return
    # Bound the weight of missing survivors.
    heaviest = born * _heaviest_share(plan, place)
    is_by_share = plan.splits or plan.absorbs_by_share
    played = math.inf if is_by_share else _played(batches, histories, heaviest)
    bound = min(unseen_scores(0) * heaviest / histories, played) * most
    if bound > 0:
        # Suggest a threshold at which one survivor adds less than the error.
        error = total.error if total.error > 0 else math.inf
        if bins is not None:
            errors = replicates_of(
                bins / total.run.sizes.reshape(-1, *(1,) * (bins.ndim - 1)), total.run, False, None
            ).error
            error = float(np.min(errors, where=errors > 0, initial=error))
        roulette = (error / most if math.isfinite(error) else heaviest / histories) / born
        yield Finding(DOUBTFUL, title, "", *_in_words(plan, roulette, bound), name="roulette survivors")


def _thins_out(plan: Plan) -> bool:
    """Whether media end light histories by chance."""
    return plan.has_roulette_in_flight or plan.splits


def _heaviest_share(plan: Plan, place: Vector) -> float:
    """The largest possible weight of a history near a place, relative to its birth weight.

    Importance falls from there to the births; in voxels that absorb, nothing reduces the weight of an
    uncollided flight.
    """
    if plan.splits:
        rise_at = plan.tracking.splitting.rise_at
        births = max(rise_at(emitter.shape.middle) for emitter in plan.emitters)
        return min(1.0, math.exp(births - rise_at(place)))
    return 1.0 if plan.absorbs_by_share else plan.tracking.survivors_weight


def _played(batches: list[Batch], histories: int, heaviest: float) -> float:
    """Approximate weight for which roulette was played, per history.

    Roulette kills w with chance 1 - w/h and gains h - w with chance w/h, where h is the heaviest weight.
    Until one has survived, the sum of the killed weight measures it; later the variance of the balance does,
    h times the sum of w.
    """
    balance = np.array([batch.ledger["roulette"] for batch in batches])
    return max(abs(balance.sum()), (balance**2).sum() / heaviest) / histories


def _in_words(plan: Plan, roulette: float, bound: float) -> tuple[str, float, str]:
    """What is missing, its bound, and the cure; roulette: a threshold that would suffice."""
    if plan.splits:
        gain = plan.tracking.splitting.gain
        cure = (
            f"let the Splitting rise towards it, and raise its gain, got {gain:g}, to about 1 / transmission"
        )
        return "rare heavy histories that the Splitting thins out not sampled", bound, cure
    if plan.absorbs_by_share:
        what = "uncollided particles through voxels not sampled"
        return what, bound, "use more particles, or a Splitting"
    what = (
        f"rare survivors of Russian roulette, at {plan.tracking.roulette:g} of the birth weight, not sampled"
    )
    return what, bound, f"pass tracking=Tracking(roulette={_rounded(roulette)}), or use a Splitting"


def _rounded(share: float) -> str:
    """Round down to a power of ten."""
    return f"1e{math.floor(math.log10(share)):03d}"
