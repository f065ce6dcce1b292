"""Diagnostic "grazing": whether a fluence rate depends on grazing light unlike constant radiance.

Below the grazing cut a crossing scores its mean under constant radiance, 2/cut, instead of 1/|mu|.  Diffuse
light agrees with that, and brings a thousandth of its fluence there; a beam at that angle does not.  Under
constant radiance as many crossings are nearer to grazing than cut/sqrt(2) as are farther, and batches count
the difference (engine/grazing.py).
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

CHANCE = 1e-6  # probability that so many batches agree by chance under constant radiance


def grazing_of_detector(sums: MeterSums, title: str) -> Iterator[Finding]:
    """The finding about a fluence rate that depends on such light.

    No bound is known for how much it is too low.
    """
    share = grazing_share(sums)
    if share > 0:
        what = (
            f"{share:.2g} or more of it is crossings of |mu| < {GRAZING_CUT:g}, each scored as"
            f" {2 / GRAZING_CUT:g} instead of 1/|mu|, which holds only for constant radiance"
        )
        cure = "use a VolumeDetector, or turn the detector towards the light"
        yield Finding(DOUBTFUL, title, "", what, cure=cure, name="grazing")


def grazing_share(sums: MeterSums) -> float:
    """Approximate least share of the fluence rate from asymmetric crossings beyond the cut; 0 if uncertain.

    A certain asymmetry matters: an excess above five square roots of a number of crossings is that many of
    the standard errors that they make.
    """
    weights, counts, slants = (
        sum(sums.whole(kind, side).sum(axis=(1, 2)) for side in (ARRIVALS, DEPARTURES))
        for kind in ("weights", "counts", "slants")
    )
    if not slants.any():
        return 0.0
    inverse = slants.sum() / weights.sum()  # mean of 1/|mu|
    if weights_vary(sums.plan):  # counts do not measure weights
        return 1.0 if inverse > 1 / GRAZING_CUT else 0.0
    number = [meter.name for meter in sums.scene.meters].index(sums.detector.name)
    excess = np.array([batch.grazing[number] for batch in sums.batches], float)
    if abs(excess.sum()) < MIN_SCORES or not _is_sure(excess):
        return 0.0
    return min(1.0, 2 / GRAZING_CUT / inverse * abs(excess.sum()) / counts.sum())


def _is_sure(excess: np.ndarray) -> bool:
    """Whether batches agree that the mean is not zero.

    A history may graze many times, but only in its batch.
    """
    if len(excess) < 2:  # an interrupted run: nothing to compare
        return False
    limit = student_quantile(1 - CHANCE / 2, len(excess) - 1) * excess.std(ddof=1) / math.sqrt(len(excess))
    return abs(excess.mean()) > limit
