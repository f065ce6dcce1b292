"""Whether histories that survive roulette, of which none has come, may be missing from a figure and from its error.

Roulette ends light histories and makes a few of them heavier.  Where all that reaches a detector is far
lighter, a run may be over before the first of these is there: its mean is then too low, and its error tells the spread
of the light ones alone.  Such a run betrays itself: a single survivor would add more than errors allow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from transport.compile.plan import Plan
from transport.results.batches import Batch
from transport.results.in_parts import replicates_of
from transport.results.meter_sums import ARRIVALS, DEPARTURES, MeterSums
from transport.results.replicates import Batches
from transport.vectors import Vector

NOISELESS = 1e-6  # relative error below which what is scored has not been through a medium by chance
MANY = 3.0  # standard errors that one more history may add


@dataclass(frozen=True)
class Doubt:
    """Of the sum that is in most doubt: how many of its standard errors one survivor adds, and a roulette that would do.

    share: of its mean that all weight for which roulette was played could be at most;  place: its index among the sums, ()
    of a single one;  others: how many more are in doubt.  ratio is infinite where nothing has scored at all.
    """

    ratio: float
    roulette: float
    share: float = math.inf
    place: tuple[int, ...] = ()
    others: int = 0


def doubt_of_meter(sums: MeterSums, is_blind: bool) -> str | None:
    """What to know before trusting a detector's totals, and where these are sound its bins of position and direction."""
    detector, plan = sums.detector, sums.plan
    if detector.events is not None and detector.events[1] == 0:
        return None
    title, place = f"detector {detector.name!r}", sums.shape.middle

    def found_in(values: np.ndarray) -> Doubt | None:
        return missing_survivors(plan, sums.batches, sums.run, values, place)

    for side, quantity in ((ARRIVALS, "flux_in of "), (DEPARTURES, "flux_out of ")):
        totals = sums.whole("weights", side).sum(axis=(1, 2))
        found = found_in(totals)
        if found is not None and (totals.any() or is_blind):
            return doubt(plan, f"{quantity if totals.any() else ''}{title}", found)
    if not (_thins_out(plan) and (sums.place_axes or sums.direction_axes)):
        return None
    for side, way in ((ARRIVALS, "arrives at"), (DEPARTURES, "leaves from")):
        bins = sums.by_direction("weights", side).sum(axis=(1, 2))
        found = found_in(bins) if bins.any() else None
        if found is not None:
            return doubt(plan, f"what {way} {title}", found, "bin")
    return None


def missing_survivors(
    plan: Plan, batches: list[Batch], run: Batches, sums: np.ndarray, place: Vector, most: float = 1.0
) -> Doubt | None:
    """Whether survivors of roulette may be missing from sums of the batches, (B, *dims), that scored about a place [m].

    most: what a history of the largest birth weight adds to one of them.  None where roulette has not been played in a
    medium, where all that it could have ended weighs less than the errors, or where the heaviest survivor adds no more
    than MANY errors to any sum.  Where none has scored but roulette has ended histories, they are in doubt as well.
    """
    if not _thins_out(plan):
        return None
    histories = run.sizes.sum()
    born = sum(batch.born for batch in batches) / histories
    if born == 0:  # an aim behind its source: nothing could be missing
        return None
    heaviest = born * _heaviest_share(plan, place)
    played = math.inf if plan.splits or plan.absorbs_by_share else _played(batches, run, heaviest)
    if not sums.any():
        return Doubt(math.inf, heaviest / histories / born) if played > 0 else None
    means = sums / run.sizes.reshape(-1, *[1] * (sums.ndim - 1))
    found = replicates_of(means, run, exact=False, counts=None)
    errors, is_noisy = found.error / most, found.error > NOISELESS * found.value
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.where(is_noisy & (played > errors), heaviest / histories / errors, 0.0)
    doubtful = int((ratios > MANY).sum())
    if not doubtful:
        return None
    worst = tuple(int(k) for k in np.unravel_index(ratios.argmax(), ratios.shape))
    share = played * most / float(found.value[worst])
    return Doubt(float(ratios[worst]), float(errors[worst] / born), share, worst, doubtful - 1)


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


def _played(batches: list[Batch], run: Batches, heaviest: float) -> float:
    """About what weight roulette was played for, a history.

    What it kills is w with chance 1 - w/h, what it gains h - w with chance w/h, h being the heaviest: as long as none
    has survived the sum of what was killed tells; later the variance of the balance does, h times the sum of w.
    """
    balance = np.array([batch.ledger["roulette"] for batch in batches])
    return max(abs(balance.sum()), (balance**2).sum() / heaviest) / run.sizes.sum()


def doubt(plan: Plan, title: str, found: Doubt | None, part: str = "cell") -> str | None:
    """What to know before trusting the figure called `title`, in words; part: what a place among its sums is."""
    if found is None:
        return None
    if plan.absorbs_by_share and not plan.splits:
        return _doubt_in_voxels(title, found)
    roulette = f"the roulette (at {plan.tracking.roulette:g} of the birth weight)"
    cure = f"lower it, as Tracking(roulette={_rounded(found.roulette)}), or use a Splitting"
    what = f"survivor of {roulette}"
    why = f"{roulette} ends nearly all that is as light as what would"
    if plan.splits:
        what, why = "history that is not thinned out further", "the Splitting brings too little there"
        gain = plan.tracking.splitting.gain
        cure = (
            f"let the Splitting rise towards it, and raise its gain, got {gain:g}, to about 1 / transmission"
        )
    if found.ratio == math.inf:
        return f"nothing has come to {title}: {why}; {cure}"
    where = f", {part} {found.place}" if found.place else ""
    where += f" and {found.others} more" if found.others else ""
    missing = "rare heavy ones may be missing"
    missing += f", worth {found.share:.1g} of its mean at most" if found.share < 0.1 else ""
    return (
        f"one {what} would add {found.ratio:.2g} standard errors to {title}{where}, so that its mean and its error are not"
        f" to be trusted: {missing}; {cure}"
    )


def _doubt_in_voxels(title: str, found: Doubt) -> str:
    cure = "use more particles, or a Splitting"
    if found.ratio == math.inf:
        return f"nothing has come to {title}: what flies through voxels without a collision is rare; {cure}"
    return (
        f"one history that flies through voxels without a collision would add {found.ratio:.2g} standard errors to {title},"
        f" so that its mean and its error are not to be trusted; {cure}"
    )


def _rounded(share: float) -> str:
    """Down to a power of ten."""
    return f"1e{math.floor(math.log10(share)):03d}"
