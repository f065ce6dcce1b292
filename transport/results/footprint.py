"""Memory of a run's sums, from its plan alone, so that the number of batches is the same on every machine.

The numbers are bounds for full bins: rows without a score take nothing (statistics/packed.py).
"""

from __future__ import annotations

import math

from transport.compile.detectors import bin_counts, block_rows
from transport.compile.layout import RECORD
from transport.compile.plan import Plan
from transport.compile.volumes import weights_vary
from transport.results.batches import SAMPLED
from transport.scene.detectors import Detector
from transport.scene.materials import Black, simple_parts
from transport.scene.scene import Scene
from transport.statistics.chunked import LARGE
from transport.statistics.packed import MOST_PLAIN

KEPT = 3 << 28  # bytes of batches that a run keeps, if the user did not set their number
FEWEST = 8  # batches, whatever their size
COUNTED = 32  # bytes per row of a batch in progress
PLAIN = 24  # bytes of weight, count and slant
FEW_SCORES, MARKS = 1, 0.375  # bytes per row: its count, and marks in three columns of whether it has scored
ALIKE, UNLIKE = 6.5, 14.0  # bytes per packed row, for whole-number weights and for any weights


def bytes_of_counting(plan: Plan) -> float:
    """Memory of a thread's batch in progress, at most [bytes]."""
    return COUNTED * (scoring_rows(plan) + plan.long_rows)


def bytes_of_a_batch(plan: Plan) -> float:
    """Memory of a finished batch, at most [bytes]."""
    if plan.rows <= MOST_PLAIN:
        return bytes_unpacked(plan)
    return (UNLIKE if _weights_differ(plan) else ALIKE) * scoring_rows(plan) + 8 * plan.long_rows


def bytes_in_memory(plan: Plan, batch_records: float) -> float:
    """Resident memory of a finished batch, at most, if files can hold the rest [bytes].

    batch_records: records of its snapshots.  Rows of volumes, phase spaces and the like have no slants.
    """
    return _bytes_of_parts(plan, batch_records, LARGE)


def bytes_in_all(plan: Plan, batch_records: float) -> float:
    """Size of a finished batch with its memory-mapped parts [bytes]."""
    return _bytes_of_parts(plan, batch_records, math.inf)


def bytes_of_records(batch_records: float) -> float:
    """Memory of a batch's sample in progress: recorded, sorted and kept [bytes]."""
    return batch_records * (2 * RECORD.itemsize + SAMPLED.itemsize)


def _bytes_of_parts(plan: Plan, batch_records: float, most: float) -> float:
    """Sum over the parts of a batch, each limited to `most` bytes in memory."""
    sample = min(batch_records * SAMPLED.itemsize, most)
    if plan.rows <= MOST_PLAIN:
        return bytes_unpacked(plan) + sample
    rows, slanted = scoring_rows(plan), 2 * plan.half * (2 if plan.expects else 1)
    weight, slant = (8, 8) if _weights_differ(plan) else (1, 4)
    columns = (weight * rows, slant * min(rows, slanted), 8 * plan.long_rows)
    return (FEW_SCORES + MARKS) * rows + sum(min(column, most) for column in columns) + sample


def bytes_unpacked(plan: Plan) -> int:
    """Size of a batch's sums as plain columns.

    Weights, counts and slants of its rows, and velocities [bytes].
    """
    return PLAIN * plan.rows + 8 * plan.long_rows


def batches_that_fit(plan: Plan) -> int:
    """Number of batches that a run may keep."""
    return max(FEWEST, int(KEPT // max(bytes_of_a_batch(plan), 1.0)))


def scoring_rows(plan: Plan) -> int:
    """Number of rows that can have scores: nothing leaves a black wall."""
    silent = (meter for meter in plan.scene.meters if _sends_nothing(plan.scene, meter))
    return plan.rows - sum(rows_of(plan.scene, meter) for meter in silent) * (2 if plan.expects else 1)


def rows_of(scene: Scene, meter: Detector) -> int:
    """Number of rows of one side of a detector."""
    cells = bin_counts(meter, scene.shape_of(meter), scene.duration)
    return cells["time"] * cells["speed"] * block_rows(cells)


def _sends_nothing(scene: Scene, meter: Detector) -> bool:
    """Whether the detector is on a black surface without a source."""
    shape = scene.shape_of(meter)
    walls = [surface for surface in scene.surfaces if surface.name == meter.shape]
    parts = [part for wall in walls for part in simple_parts(wall.material)]
    is_dark = bool(parts) and all(isinstance(part, Black) for part in parts)
    return is_dark and not any(scene.shape_of(source) == shape for source in scene.sources)


def _weights_differ(plan: Plan) -> bool:
    """Whether scores have other weights than births."""
    return weights_vary(plan) or plan.lessens or plan.has_roulette
