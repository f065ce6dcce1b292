"""Memory of a run's sums, from its plan alone, so that the number of batches is the same on every machine.

The numbers are bounds for full bins: rows without a score take nothing (statistics/packed.py).
"""

from __future__ import annotations

import math

from transport.compile.detectors import weights_vary
from transport.compile.layout import RECORD
from transport.compile.plan import Plan
from transport.results.batches import SAMPLED
from transport.scene.detectors import Detector
from transport.scene.scene import Scene
from transport.statistics.chunked import MIN_MAPPED_BYTES
from transport.statistics.packed import MAX_UNPACKED_ROWS

MAX_KEPT_BYTES = 3 << 28  # bytes of batches that a run keeps, if the user did not set their number
MIN_BATCHES = 8  # batches, whatever their size
COUNTING_BYTES = 32  # bytes per row of a batch in progress
PLAIN_ROW_BYTES = 24  # bytes of weight, count and slant
COUNT_BYTES, MARK_BYTES = 1, 0.375  # per row: its count, and marks in three columns of whether it has scored
EQUAL_WEIGHT_BYTES, VARIED_WEIGHT_BYTES = 6.5, 14.0  # per packed row, for whole-number and for any weights


def bytes_of_counting(plan: Plan) -> float:
    """Memory of a thread's batch in progress, at most [bytes]."""
    return COUNTING_BYTES * (scoring_rows(plan) + plan.long_rows)


def bytes_of_batch(plan: Plan) -> float:
    """Memory of a finished batch, at most [bytes]."""
    if plan.rows <= MAX_UNPACKED_ROWS:
        return bytes_unpacked(plan)
    each = VARIED_WEIGHT_BYTES if _score_weights_vary(plan) else EQUAL_WEIGHT_BYTES
    return each * scoring_rows(plan) + 8 * plan.long_rows


def resident_bytes(plan: Plan, batch_records: float) -> float:
    """Resident memory of a finished batch, at most, if files can hold the rest [bytes].

    batch_records: records of its snapshots.  Rows of volumes, phase spaces and the like have no slants.
    """
    return _bytes_of_parts(plan, batch_records, MIN_MAPPED_BYTES)


def total_bytes(plan: Plan, batch_records: float) -> float:
    """Size of a finished batch with its memory-mapped parts [bytes]."""
    return _bytes_of_parts(plan, batch_records, math.inf)


def bytes_of_records(batch_records: float) -> float:
    """Memory of a batch's sample in progress: recorded, sorted and kept [bytes]."""
    return batch_records * (2 * RECORD.itemsize + SAMPLED.itemsize)


def _bytes_of_parts(plan: Plan, batch_records: float, most: float) -> float:
    """Sum over the parts of a batch, each limited to `most` bytes in memory."""
    sample = min(batch_records * SAMPLED.itemsize, most)
    if plan.rows <= MAX_UNPACKED_ROWS:
        return bytes_unpacked(plan) + sample
    rows, slanted = scoring_rows(plan), 2 * plan.half * (2 if plan.sends_shadow_rays else 1)
    weight, slant = (8, 8) if _score_weights_vary(plan) else (1, 4)
    columns = (weight * rows, slant * min(rows, slanted), 8 * plan.long_rows)
    return (COUNT_BYTES + MARK_BYTES) * rows + sum(min(column, most) for column in columns) + sample


def bytes_unpacked(plan: Plan) -> int:
    """Size of a batch's sums as plain columns.

    Weights, counts and slants of its rows, and velocities [bytes].
    """
    return PLAIN_ROW_BYTES * plan.rows + 8 * plan.long_rows


def batches_that_fit(plan: Plan) -> int:
    """Number of batches that a run may keep."""
    return max(MIN_BATCHES, int(MAX_KEPT_BYTES // max(bytes_of_batch(plan), 1.0)))


def scoring_rows(plan: Plan) -> int:
    """Number of rows that can have scores: nothing leaves a black wall."""
    silent = (detector for detector in plan.scene.meters if _is_black_without_source(plan.scene, detector))
    departures = sum(plan.rows_of[detector.name].count for detector in silent)
    return plan.rows - departures * (2 if plan.sends_shadow_rays else 1)


def _is_black_without_source(scene: Scene, detector: Detector) -> bool:
    """Return whether the detector is on a black surface without a source."""
    shape = scene.shape_of(detector)
    materials = [surface.material for surface in scene.surfaces if surface.name == detector.shape]
    is_dark = bool(materials) and not any(each.redirects or each.is_transmissive for each in materials)
    return is_dark and not any(scene.shape_of(source) == shape for source in scene.sources)


def _score_weights_vary(plan: Plan) -> bool:
    """Return whether scores have other weights than births."""
    return weights_vary(plan) or plan.reduces_weights or plan.has_roulette
