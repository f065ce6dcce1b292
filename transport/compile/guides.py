"""Guides: densities of births, learnt from the scores of short runs.

Place and direction of a birth follow from four uniform numbers. A guide draws these from a density that is
constant on boxes of the unit cube, and gives each birth the weight of one over the density (importance
sampling in primary samples; Guo, Bauszat, Bikker and Eisemann 2018). What a history brings to the detectors
is then found where it is large: a lamp seen in a mirror, the way through a glass ball, a small window.

The best density is the square root of the mean squared score of births there. It is estimated from recorded
scores: boxes are halved where that makes the predicted error smaller (Jadach 2003). A share LEAST of all
births stays uniform, so that no weight exceeds 1/LEAST and what the short runs did not see is still found:
the estimate is unbiased whatever was learnt.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout

if TYPE_CHECKING:
    from transport.compile.arena import Arena
    from transport.compile.plan import Plan

# Share of births that stays uniform: a guide never costs more than twice the histories. While learning it is
# less, as bolder guides find more.
LEAST, BOLD = 1 / 2, 1 / 8
MAX_BOXES = 2048
MAX_HISTORIES = 1 << 17  # histories that a guide is learnt from, one in so many of those that scored
MAX_SHARE = 1 / 50  # of the sum of squares that one history counts at most: rare high scores say little
# share of the mean square of a history that scored that each half of a box is given on suspicion
UNSEEN = 0.02
MIN_SCORES = 12  # histories with a score in a box that may be halved
# slices of a box along an axis, by which the gain from dividing it there is foretold
SLICES = 16
# gain over one over the number of histories that is more than noise, about SLICES / 8
MIN_GAIN = 8.0


@dataclass(frozen=True)
class Guide:
    """A density of births: boxes with their probabilities.

    Attributes
    ----------
    lows, widths : numpy.ndarray
        Low end and width of each box along the four numbers, (boxes, 4).
    learnt : numpy.ndarray
        Probability of each box for the births that do not stay uniform, (boxes,).
    least : float
        Share of births that stays uniform, which is one over the largest weight.
    """

    lows: np.ndarray
    widths: np.ndarray
    learnt: np.ndarray
    least: float = LEAST

    @property
    def volumes(self) -> np.ndarray:
        """Volume of each box: its probability among uniform births."""
        return np.prod(self.widths, axis=1)

    @property
    def shares(self) -> np.ndarray:
        """Probability of each box among all births."""
        return self.least * self.volumes + (1 - self.least) * self.learnt

    @property
    def weights(self) -> np.ndarray:
        """Birth weight in each box, over the largest possible one."""
        return self.least * self.volumes / self.shares

    def row(self, arena: Arena, origin: int) -> np.ndarray:
        """Return the table (layout.GUIDE) of the emitter of this number, with its arrays in an arena."""
        shares = np.cumsum(self.shares)
        shares /= shares[-1]
        boxes = np.column_stack([self.lows, self.widths, self.weights])
        places = {"shares": arena.place(shares), "boxes": arena.place(boxes)}
        return layout.row(layout.GUIDE, **places, count=len(shares), origin=origin)


UNIFORM = Guide(np.zeros((1, 4)), np.ones((1, 4)), np.ones(1))


def learn_guide(numbers: np.ndarray, squares: np.ndarray, before: Guide = UNIFORM) -> Guide:
    """Return the guide that histories with these scores suggest; the one before if there are too few.

    Parameters
    ----------
    numbers : numpy.ndarray
        The four uniform numbers of each history that scored, (n, 4).
    squares : numpy.ndarray
        Its part of the integral of the squared score over the cube: square of the score without the birth
        weight, times that weight, (n,).
    before : Guide, optional
        The guide so far.
    """
    if len(numbers) < MIN_SCORES:
        return before
    some = slice(None, None, -(-len(numbers) // MAX_HISTORIES))
    numbers, squares = numbers[some], _without_outliers(squares[some])
    boxes = [(np.zeros(4), np.ones(4), np.arange(len(numbers)), 0.0)]
    heap: list = []
    _offer(heap, 0, boxes[0], numbers, squares)
    while heap and len(boxes) < MAX_BOXES:
        _, number, axis = heapq.heappop(heap)
        low, width, held, unseen = boxes[number]
        # Each half may hold what one more history would have shown.
        unseen = 0.5 * (unseen + UNSEEN * squares[held].sum() / len(held))
        half = width.copy()
        half[axis] /= 2
        middle = low.copy()
        middle[axis] += half[axis]
        is_above = numbers[held, axis] >= middle[axis]
        boxes[number] = (low, half, held[~is_above], unseen)
        boxes.append((middle, half, held[is_above], unseen))
        for each in (number, len(boxes) - 1):
            _offer(heap, each, boxes[each], numbers, squares)
    lows, widths = np.array([box[0] for box in boxes]), np.array([box[1] for box in boxes])
    sums = np.array([squares[held].sum() + unseen for *_, held, unseen in boxes])
    wanted = np.sqrt(np.prod(widths, axis=1) * sums)
    return Guide(lows, widths, wanted / wanted.sum(), before.least)


def _without_outliers(squares: np.ndarray) -> np.ndarray:
    """Return the squares, none larger than MAX_SHARE of their sum: equal ones where there are too few."""
    cut = squares
    for _ in range(32):
        cut = np.minimum(cut, MAX_SHARE * cut.sum())
    return cut if cut.max() > 0 else np.ones(len(squares))


def _offer(heap: list, number: int, box: tuple, numbers: np.ndarray, squares: np.ndarray) -> None:
    """Put a box on the heap, by the gain of the best axis to divide it along, if that is more than noise.

    Halving may gain nothing where quartering does, as with two bright spots: slices foretell the gain.
    """
    low, width, held, _ = box
    if len(held) < MIN_SCORES:
        return
    inside, sums = numbers[held], squares[held]
    whole = sums.sum()
    slices = np.minimum(((inside - low) / width * SLICES).astype(np.intp), SLICES - 1)
    held_by = np.stack([np.bincount(slices[:, k], sums, SLICES) for k in range(4)]) / whole
    # the box's part of the error, sqrt(volume times sum of squares), less the parts of the slices
    gains = 1.0 - np.sqrt(held_by / SLICES).sum(axis=1)
    axis = int(np.argmax(gains))
    effective = whole * whole / np.sum(sums * sums)
    if gains[axis] > MIN_GAIN / effective:
        heapq.heappush(heap, (-gains[axis] * np.sqrt(np.prod(width) * whole), number, axis))


def guide_births(plan: Plan) -> None:
    """Let a learnt density guide the births of all emitters, where the method asks for it."""
    if not plan.method.guide:
        return
    plan.emitters = [
        replace(emitter, weight=emitter.weight / LEAST, is_guided=True) for emitter in plan.emitters
    ]
    if plan.adjoint is not None:
        parts = tuple(replace(part, gains=part.gains / LEAST) for part in plan.adjoint.parts)
        plan.adjoint = replace(plan.adjoint, parts=parts)
