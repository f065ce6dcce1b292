"""How much memory the sums of a run take, going by its plan: so how many batches it is made of depends on no machine.

These are bounds for full bins: rows that have not scored take nothing (results/packed.py).
"""

from __future__ import annotations

import math

from transport.compile.layout import RECORD
from transport.compile.looks import bin_counts, block_rows
from transport.compile.plan import Plan
from transport.compile.sizes import weights_vary
from transport.detectors import Detector
from transport.materials import Black, simple_parts
from transport.results.aside import LARGE
from transport.results.packed import MOST_PLAIN
from transport.results.records import SAMPLED
from transport.scene import Scene

KEPT = 3 << 28  # bytes of batches that a run keeps, where nobody said how many
FEWEST = 8  # batches, however large they are
COUNTED = 32  # bytes of a row while a batch counts
PLAIN = 24  # of weight, count and slant
FEW_SCORES, MARKS = 1, 0.375  # of a row: its count, and what tells in three columns whether it has scored
ALIKE, UNLIKE = 6.5, 14.0  # of the same packed, where weights are whole numbers, and where they are any


def bytes_of_counting(plan: Plan) -> float:
    """What a thread's batch takes while it runs, most of it."""
    return COUNTED * (scoring_rows(plan) + plan.long_rows)


def bytes_of_a_batch(plan: Plan) -> float:
    """What is kept of a batch, at most."""
    if plan.rows <= MOST_PLAIN:
        return bytes_unpacked(plan)
    return (UNLIKE if _weights_differ(plan) else ALIKE) * scoring_rows(plan) + 8 * plan.long_rows


def bytes_in_memory(plan: Plan, batch_records: float) -> float:
    """What of a batch is kept in memory, at most, where there are files for the rest; batch_records: of its snapshots.

    Rows of volumes, of phase space and the like have no slants.
    """
    return _bytes_of_parts(plan, batch_records, LARGE)


def bytes_in_all(plan: Plan, batch_records: float) -> float:
    """The same with what lies aside."""
    return _bytes_of_parts(plan, batch_records, math.inf)


def bytes_of_records(batch_records: float) -> float:
    """What the sample of a batch takes while it is made: written down, sorted, and kept."""
    return batch_records * (2 * RECORD.itemsize + SAMPLED.itemsize)


def _bytes_of_parts(plan: Plan, batch_records: float, most: float) -> float:
    """Sums over what a batch is made of, of each of which so many bytes at most lie in memory."""
    sample = min(batch_records * SAMPLED.itemsize, most)
    if plan.rows <= MOST_PLAIN:
        return bytes_unpacked(plan) + sample
    rows, slanted = scoring_rows(plan), 2 * plan.half * (2 if plan.expects else 1)
    weight, slant = (8, 8) if _weights_differ(plan) else (1, 4)
    columns = (weight * rows, slant * min(rows, slanted), 8 * plan.long_rows)
    return (FEW_SCORES + MARKS) * rows + sum(min(column, most) for column in columns) + sample


def bytes_unpacked(plan: Plan) -> int:
    """What a batch's sums take as plain columns: weights, counts and slants of its rows, and velocities."""
    return PLAIN * plan.rows + 8 * plan.long_rows


def batches_that_fit(plan: Plan) -> int:
    """How many batches a run may keep."""
    return max(FEWEST, int(KEPT // max(bytes_of_a_batch(plan), 1.0)))


def scoring_rows(plan: Plan) -> int:
    """Rows that anything can be counted in: nothing leaves from a black wall."""
    silent = (meter for meter in plan.scene.meters if _sends_nothing(plan.scene, meter))
    return plan.rows - sum(rows_of(plan.scene, meter) for meter in silent) * (2 if plan.expects else 1)


def rows_of(scene: Scene, meter: Detector) -> int:
    """Rows of one side of a detector."""
    cells = bin_counts(meter, scene.shape_of(meter), scene.duration)
    return cells["time"] * cells["speed"] * block_rows(cells)


def _sends_nothing(scene: Scene, meter: Detector) -> bool:
    """Whether it looks at a black surface without a source."""
    shape = scene.shape_of(meter)
    walls = [surface for surface in scene.surfaces if surface.name == meter.shape]
    parts = [part for wall in walls for part in simple_parts(wall.material)]
    is_dark = bool(parts) and all(isinstance(part, Black) for part in parts)
    return is_dark and not any(scene.shape_of(source) == shape for source in scene.sources)


def _weights_differ(plan: Plan) -> bool:
    """Whether scores weigh other than births do."""
    return weights_vary(plan) or plan.lessens or plan.has_roulette
