"""Where scores can differ in size: there a run also counts how often each size comes (engine/sizes.py).

Histories born alike, which walls leave at half of their weight at least, need no such count: how many scores there are
tells all.  An aim, a medium that lessens weights, splitting, and estimators that weigh what they score make sizes differ.

Where all walls are metered nearly every lane scores, and to count them all would cost a tenth of the run.  There one batch
in EVERY counts for all, as long as nothing but a medium makes weights differ: rare heavy scores in the others are still
seen, for batches are compared (results/trends.py).
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.layout import SIZE_CELLS, SIZE_OCTAVE, SIZE_PARTS, SIZES

if TYPE_CHECKING:
    from transport.compile.plan import Plan

# Edges of the cells of a count [largest birth weight], SIZE_PARTS an octave, equally far apart within one; the first and the
# last cell take all that is beyond them.
EVERY = 8  # a power of two
LARGE = 0.25  # of the largest score: scores above it tell whether such large ones come
EDGES = np.array(
    [
        math.ldexp(1 + k % SIZE_PARTS / SIZE_PARTS, SIZE_OCTAVE + k // SIZE_PARTS)
        for k in range(SIZE_CELLS + 1)
    ]
)


def sizes_differ(plan: Plan) -> bool:
    """Whether scores of meters differ by more than roulette at walls makes them."""
    return bool(plan.meters.size) and (weights_vary(plan) or plan.lessens)


def weights_vary(plan: Plan) -> bool:
    """Whether anything but a medium makes them differ."""
    is_aimed = any(emitter.target is not None for emitter in plan.emitters)
    return is_aimed or plan.expects or plan.splits or plan.forces


def is_dense(plan: Plan, layer: np.ndarray) -> bool:
    """Whether nearly every lane that arrives somewhere scores in this layer."""
    return plan.acts and bool((layer[1:]["look"] != 0).all())


def fill_sizes(plan: Plan) -> None:
    """Cells for each side of each detector, and by row where they begin; the first cells are nobody's.

    What events tell a detector, in rows of its own and in a unit of its own, has cells of its own.
    """
    if not sizes_differ(plan):
        return
    halves = 4 if plan.expects else 2
    plan.size_numbers, plan.size_cells = np.zeros(halves * plan.half, np.int64), SIZE_CELLS
    firsts = [*(plan.bases[detector.name] for detector in plan.scene.meters), plan.half]
    for detector, (first, end) in zip(plan.scene.meters, itertools.pairwise(firsts), strict=True):
        for half in range(halves):
            plan.size_numbers[first + half * plan.half : end + half * plan.half] = plan.size_cells
            plan.size_blocks.setdefault((detector.name, half % 2), []).append(plan.size_cells)
            plan.size_cells += SIZE_CELLS


def size_row(plan: Plan) -> np.ndarray:
    """The table of the pass that counts."""
    is_costly = not weights_vary(plan) and any(is_dense(plan, layer) for layer in plan.layers)
    numbers = {"numbers": plan.size_numbers.ctypes.data, "count": len(plan.size_numbers)}
    return layout.row(SIZES, **numbers, cells=plan.size_cells, resting=EVERY - 1 if is_costly else 0)
