"""Whether a fluence rate from crossings rests on light that grazes the meter other than a constant radiance would.

Beyond the grazing cut a crossing counts its mean under constant radiance, 2/cut, instead of 1/|mu|.  Light of all directions
comes so, and brings a thousandth of its fluence there; a beam that flat does not.  From a constant radiance as many crossings
are nearer to grazing than cut/sqrt(2) as are farther, which batches count (engine/grazing.py).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.layout import GRAZING_CUT
from transport.compile.sizes import weights_vary
from transport.results.findings import MIN_SCORES
from transport.results.meter_sums import ARRIVALS, DEPARTURES
from transport.results.statistics import student_quantile

if TYPE_CHECKING:
    from transport.results.meter_sums import MeterSums
    from transport.results.result import Result

CHANCE = 1e-6  # of even light that so many batches agree about it


def doubts_of_fluence(result: Result) -> list[str]:
    """A warning for each meter whose fluence rate rests on such light."""
    if result.plan.turned is not None:
        return []
    found = []
    for number, meter in enumerate(result.scene.meters):
        share = grazing_share(result[meter.name].sums, number)
        if share > 0:
            found.append(
                f"{share:.2g} or more of the fluence rate of detector {meter.name!r} is crossings of |mu| < {GRAZING_CUT:g}, each"
                f" counted as {2 / GRAZING_CUT:g} instead of 1/|mu|, as if radiance were constant there, which it is not; use"
                " a VolumeDetector, or turn the meter towards the light"
            )
    return found


def grazing_share(sums: MeterSums, number: int) -> float:
    """About the least share of a meter's fluence rate that lopsided crossings beyond the cut bring; 0 where none is sure.

    What is sure matters: by more than five roots of a number of crossings it is as many of the standard errors that these make.
    """
    weights, counts, slants = (
        sum(sums.whole(kind, side).sum(axis=(1, 2)) for side in (ARRIVALS, DEPARTURES))
        for kind in ("weights", "counts", "slants")
    )
    if not slants.any():
        return 0.0
    inverse = slants.sum() / weights.sum()  # the mean of 1/|mu|
    if weights_vary(sums.plan):  # numbers do not tell what they bring
        return 1.0 if inverse > 1 / GRAZING_CUT else 0.0
    excess = np.array([batch.grazing[number] for batch in sums.batches], float)
    if abs(excess.sum()) < MIN_SCORES or not _is_sure(excess):
        return 0.0
    return min(1.0, 2 / GRAZING_CUT / inverse * abs(excess.sum()) / counts.sum())


def _is_sure(excess: np.ndarray) -> bool:
    """Whether batches agree that the mean is not zero: a history may graze many times, and its batch alone tells then."""
    if len(excess) < 2:  # of a run that was interrupted: nothing to compare
        return False
    limit = student_quantile(1 - CHANCE / 2, len(excess) - 1) * excess.std(ddof=1) / math.sqrt(len(excess))
    return abs(excess.mean()) > limit
