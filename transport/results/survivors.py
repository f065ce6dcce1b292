"""Whether histories that survive roulette, of which none has come, may be missing from a figure and from its error.

Roulette ends light histories and makes a few of them heavier.  Where all that reaches a detector is far
lighter, a run may be over before the first of these is there: its mean is then too low, and its error tells the spread
of the light ones alone.  Such a run betrays itself: a single survivor would add more than errors allow.
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

NOISELESS = 1e-6  # relative error below which what is scored has not been through a medium by chance


def roulette_survivors(sums: MeterSums, side: int, total: Estimate) -> Iterator[Finding]:
    """Of a detector's side, with the bound as a mean weight of a history; total: the mean that came."""
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
    """Survivors of roulette of which none has come, about a place [m].

    total: the mean that histories scored there;  bins: the sums of its bins, (B, *dims), if it has any;  most: what a
    history of the largest birth weight adds to one of them.  The bound, in
    the unit of `total`, is that of survivors that none has seen, or all the weight for which roulette was played if that is
    less.  Nothing where roulette has not been played in a medium.
    """
    if not _thins_out(plan) or total.error <= NOISELESS * total.value:
        return
    histories = sum(batch.histories for batch in batches)
    born = sum(batch.born for batch in batches) / histories
    if born == 0:  # an aim behind its source: nothing could be missing
        return
    heaviest = born * _heaviest_share(plan, place)
    is_by_share = plan.splits or plan.absorbs_by_share
    played = math.inf if is_by_share else _played(batches, histories, heaviest)
    bound = min(unseen_scores(0) * heaviest / histories, played) * most
    if bound > 0:
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
    """What the heaviest history about a place may weigh, as a share of its birth weight.

    Importance falls from there to where histories are born; in voxels that absorb nothing lessens what flies through.
    """
    if plan.splits:
        rise_at = plan.tracking.splitting.rise_at
        births = max(rise_at(emitter.shape.middle) for emitter in plan.emitters)
        return min(1.0, math.exp(births - rise_at(place)))
    return 1.0 if plan.absorbs_by_share else plan.tracking.survivors_weight


def _played(batches: list[Batch], histories: int, heaviest: float) -> float:
    """About what weight roulette was played for, a history.

    What it kills is w with chance 1 - w/h, what it gains h - w with chance w/h, h being the heaviest: as long as none
    has survived the sum of what was killed tells; later the variance of the balance does, h times the sum of w.
    """
    balance = np.array([batch.ledger["roulette"] for batch in batches])
    return max(abs(balance.sum()), (balance**2).sum() / heaviest) / histories


def _in_words(plan: Plan, roulette: float, bound: float) -> tuple[str, float, str]:
    """What is missing, the bound of it, and the cure; roulette: a weight at which it would do."""
    if plan.splits:
        gain = plan.tracking.splitting.gain
        cure = (
            f"let the Splitting rise towards it, and raise its gain, got {gain:g}, to about 1 / transmission"
        )
        return "rare heavy histories that the Splitting thins out not sampled", bound, cure
    if plan.absorbs_by_share:
        what = "what flies through voxels without a collision not sampled"
        return what, bound, "use more particles, or a Splitting"
    what = f"rare survivors of the roulette, at {plan.tracking.roulette:g} of the birth weight, not sampled"
    return what, bound, f"lower it, as Tracking(roulette={_rounded(roulette)}), or use a Splitting"


def _rounded(share: float) -> str:
    """Down to a power of ten."""
    return f"1e{math.floor(math.log10(share)):03d}"
