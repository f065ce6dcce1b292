"""Whether a fluence rate from crossings rests on light that grazes the meter other than a constant radiance would.

Beyond the grazing cut a crossing counts its mean under constant radiance, 2/cut, instead of 1/|mu|.  Light of all directions
comes so, and brings a thousandth of its fluence there; a beam that flat does not.  From a constant radiance as many crossings
are nearer to grazing than cut/sqrt(2) as are farther, which batches count (engine/grazing.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.layout import GRAZING_CUT
from transport.compile.sizes import weights_vary
from transport.results.findings import DOUBTFUL, MIN_SCORES, Finding
from transport.results.meter_sums import ARRIVALS, DEPARTURES
from transport.results.statistics import student_quantile

if TYPE_CHECKING:
    from transport.results.meter_sums import MeterSums

CHANCE = 1e-6  # of even light that so many batches agree about it


def grazing_of_detector(sums: MeterSums, title: str) -> Iterator[Finding]:
    """The finding about the fluence rate of a detector that rests on such light; nothing tells by how much it is too low."""
    share = grazing_share(sums)
    if share > 0:
        what = (
            f"{share:.2g} or more of it is crossings of |mu| < {GRAZING_CUT:g}, each counted as {2 / GRAZING_CUT:g} instead of"
            " 1/|mu|, as if radiance were constant there, which it is not"
        )
        cure = "use a VolumeDetector, or turn the detector towards the light"
        yield Finding(DOUBTFUL, title, "", what, cure=cure, name="grazing")


def grazing_share(sums: MeterSums) -> float:
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
    number = [meter.name for meter in sums.scene.meters].index(sums.detector.name)
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
