"""Whether histories that survive roulette, of which none has come, may be missing from a figure and from its error.

Roulette ends light histories and makes a few of them heavier.  Where all that reaches a detector is far
lighter, a run may be over before the first of these is there: its mean is then too low, and its error tells the spread
of the light ones alone.  Such a run betrays itself: a single survivor would add more than errors allow.
"""

from __future__ import annotations

import math

import numpy as np

from transport.compile.plan import Plan
from transport.results.batches import Batch
from transport.results.estimates import Batches, Estimate

MANY = 3.0  # standard errors that one more history may add


def missing_survivors(
    plan: Plan, batches: list[Batch], run: Batches, sums: np.ndarray, most: float = 1.0
) -> tuple[float, float] | None:
    """How many standard errors a single survivor adds to a mean, and a roulette that leaves less than one in doubt.

    sums: of the batches, (B,);  most: what a history of the largest birth weight adds to them.  None where roulette
    has not been played in a medium, where all that it could have ended weighs less than the error, or where the
    heaviest survivor adds no more than MANY errors.
    """
    if not (plan.has_roulette_in_flight or plan.splits):
        return None
    error = Estimate(sums / run.sizes, run, "1").error / most
    if not 0 < error < math.inf:
        return None
    born = sum(batch.born for batch in batches) / run.sizes.sum()
    tracking = plan.tracking
    heaviest = born / tracking.splitting.gain if plan.splits else born * tracking.survivors_weight
    ratio = heaviest / run.sizes.sum() / error
    is_in_doubt = ratio > MANY and (plan.splits or _played(batches, run, heaviest) > error)
    return (ratio, error / born) if is_in_doubt else None


def _played(batches: list[Batch], run: Batches, heaviest: float) -> float:
    """About what weight roulette was played for, a history.

    What it kills is w with chance 1 - w/h, what it gains h - w with chance w/h, h being the heaviest: as long as none
    has survived the sum of what was killed tells; later the variance of the balance does, h times the sum of w.
    """
    balance = np.array([batch.ledger["roulette"] for batch in batches])
    return max(abs(balance.sum()), (balance**2).sum() / heaviest) / run.sizes.sum()


def doubt(plan: Plan, title: str, found: tuple[float, float] | None) -> str | None:
    """What to know before trusting the figure called `title`, in words."""
    if found is None:
        return None
    ratio, share = found
    cure = f"lower it, as Tracking(roulette={_rounded(share)}), or use a Splitting"
    what = f"survivor of the roulette (at {plan.tracking.roulette:g} of the birth weight)"
    if plan.splits:
        what = "history that is not thinned out further"
        cure = f"raise the gain of the Splitting, got {plan.tracking.splitting.gain:g}, to about 1 / transmission"
    return (
        f"one {what} would add {ratio:.2g} standard errors to {title}, so that its mean and its error are not to be"
        f" trusted: rare heavy ones may be missing; {cure}"
    )


def _rounded(share: float) -> str:
    """Down to a power of ten."""
    return f"1e{math.floor(math.log10(share)):03d}"
