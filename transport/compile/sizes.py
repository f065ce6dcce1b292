"""Histograms of scores by size, where scores can differ in size (engine/sizes.py).

Scores of particles born at equal weight, which walls reduce to no less than one half, need no histogram:
their number suffices. Targets, media that reduce weights, splitting, and estimators with weighted scores make
sizes differ.

Where all walls carry detectors nearly every lane scores, and a complete histogram would cost a tenth of the
run. There one batch in EVERY is counted, as long as only media make weights differ. Rare heavy scores in the
other batches still show, since batches are compared (results/trends.py).
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

# Edges of the cells [largest birth weight]: SIZE_PARTS per octave, equally spaced within it. The first and
# the last cell include everything beyond them.
EVERY = 8  # a power of two
LARGE = 0.25  # of the largest score: larger scores show that the largest ones occur
EDGES = np.array(
    [
        math.ldexp(1 + k % SIZE_PARTS / SIZE_PARTS, SIZE_OCTAVE + k // SIZE_PARTS)
        for k in range(SIZE_CELLS + 1)
    ]
)


def sizes_differ(plan: Plan) -> bool:
    """Return whether scores of detectors differ by more than roulette at walls allows."""
    return bool(plan.meters.size) and (weights_vary(plan) or plan.lessens)


def weights_vary(plan: Plan) -> bool:
    """Return whether anything but a medium makes scores differ."""
    is_aimed = any(emitter.target is not None for emitter in plan.emitters)
    return is_aimed or plan.expects or plan.splits or plan.forces


def is_dense(plan: Plan, layer: np.ndarray) -> bool:
    """Return whether nearly every lane that lands on a surface scores in this layer."""
    return plan.acts and bool((layer[1:]["look"] != 0).all())


def fill_sizes(plan: Plan) -> None:
    """Give each side of each detector its cells; the first cells belong to no detector.

    Expected scores have rows and a unit of their own, and so cells of their own.
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
    """Return the table of the pass that counts scores by size."""
    is_costly = not weights_vary(plan) and any(is_dense(plan, layer) for layer in plan.layers)
    numbers = {"numbers": plan.size_numbers.ctypes.data, "count": len(plan.size_numbers)}
    return layout.row(SIZES, **numbers, cells=plan.size_cells, resting=EVERY - 1 if is_costly else 0)
