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
from transport.results.replicates import Batches, Replicates

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


def missing_survivors(
    plan: Plan, batches: list[Batch], run: Batches, sums: np.ndarray, most: float = 1.0
) -> Doubt | None:
    """Whether survivors of roulette may be missing from sums of the batches, (B, *dims).

    most: what a history of the largest birth weight adds to one of them.  None where roulette has not been played in a
    medium, where all that it could have ended weighs less than the errors, or where the heaviest survivor adds no more
    than MANY errors to any sum.  Where none has scored but roulette has ended histories, they are in doubt as well.
    """
    if not (plan.has_roulette_in_flight or plan.splits):
        return None
    histories = run.sizes.sum()
    born, tracking = sum(batch.born for batch in batches) / histories, plan.tracking
    heaviest = born / tracking.splitting.gain if plan.splits else born * tracking.survivors_weight
    played = _played(batches, run, heaviest)
    if not sums.any():
        return Doubt(math.inf, heaviest / histories / born) if played > 0 and not plan.splits else None
    means = sums / run.sizes.reshape(-1, *[1] * (sums.ndim - 1))
    found = Replicates.of_batches(means, run, exact=False, counts=None)
    errors, is_noisy = found.error / most, found.error > NOISELESS * found.value
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.where(is_noisy & (plan.splits | (played > errors)), heaviest / histories / errors, 0.0)
    doubtful = int((ratios > MANY).sum())
    if not doubtful:
        return None
    place = np.unravel_index(int(ratios.argmax()), ratios.shape)
    share = played * most / float(found.value[place])
    return Doubt(
        float(ratios[place]), float(errors[place] / born), share, tuple(map(int, place)), doubtful - 1
    )


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
    roulette = f"the roulette (at {plan.tracking.roulette:g} of the birth weight)"
    cure = f"lower it, as Tracking(roulette={_rounded(found.roulette)}), or use a Splitting"
    what = f"survivor of {roulette}"
    if found.ratio == math.inf:
        return (
            f"nothing has come to {title}: {roulette} ends nearly all that is as light as what would; {cure}"
        )
    if plan.splits:
        what = "history that is not thinned out further"
        cure = f"raise the gain of the Splitting, got {plan.tracking.splitting.gain:g}, to about 1 / transmission"
    where = f", {part} {found.place}" if found.place else ""
    missing = "rare heavy ones may be missing"
    missing += f", worth {found.share:.1g} of its mean at most" if found.share < 0.1 else ""
    where += f" and {found.others} more" if found.others else ""
    return (
        f"one {what} would add {found.ratio:.2g} standard errors to {title}{where}, so that its mean and its error are not"
        f" to be trusted: {missing}; {cure}"
    )


def _rounded(share: float) -> str:
    """Down to a power of ten."""
    return f"1e{math.floor(math.log10(share)):03d}"
