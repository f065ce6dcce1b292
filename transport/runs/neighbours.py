"""Merge consecutive batches where too many would be stored, so that all are about equally large."""

from __future__ import annotations

import math
from functools import reduce

from transport.results.batches import Batch


def unbroken(batches: list[Batch]) -> list[list[Batch]]:
    """Group batches of one seed that follow one another without a gap.

    Batches in a gap may belong to another run.
    """
    found: list[list[Batch]] = []
    for batch in batches:
        last = found[-1][-1] if found else None
        if last is not None and (last.seed, last.past) == (batch.seed, batch.first):
            found[-1].append(batch)
        else:
            found.append([batch])
    return found


def with_room_for(
    leg: list[tuple[int, int]], batches: list[Batch], most: int, records: int
) -> tuple[list[Batch], int]:
    """Return the stored batches, merged, and how many batches of the leg to merge into one.

    All are then about equally large, and no more than `most`. Batches of two seeds, or on both sides of a
    gap, are never merged; where these are many, more are stored. records: snapshot records that two merged
    batches may keep.
    """
    size, more = leg[0][0], sum(many for _, many in leg)
    most = max(most, len(unbroken(batches)) + 1)
    aim = min(size, *(batch.histories for batch in batches))
    while True:
        groups, together = _groups(batches, aim), max(1, aim // size)
        if len(groups) + math.ceil(more / together) <= most:
            break
        aim *= 2
    return _as_one(groups, records), together


def no_more_than(most: int, batches: list[Batch], records: int) -> list[Batch]:
    """Return at most `most` batches, consecutive ones merged, where no further batches follow."""
    most, aim = max(most, len(unbroken(batches))), min(batch.histories for batch in batches)
    while len(groups := _groups(batches, aim)) > most:
        aim *= 2
    return _as_one(groups, records)


def gathered(batches: list[Batch], size: int, records: int) -> list[Batch]:
    """Merge consecutive batches up to `size` particles each."""
    return _as_one(_groups(batches, size), records)


def _as_one(groups: list[list[Batch]], records: int) -> list[Batch]:
    """Merge each group into one batch."""
    return [reduce(lambda one, other: one.merged(other, records), group) for group in groups]


def net_of(batch: Batch) -> int:
    """Return the points per quasi-random net merged into a batch.

    For nets of unequal size, the average rounded down to a power of two.
    """
    each = max(1, batch.histories // (batch.past - batch.first))
    return 1 << (each.bit_length() - 1)


def _groups(batches: list[Batch], size: int) -> list[list[Batch]]:
    """Group consecutive batches up to `size` particles per group."""
    groups: list[list[Batch]] = []
    for row in unbroken(batches):
        histories = math.inf
        for batch in row:
            histories += batch.histories
            if histories > size:
                groups.append([])
                histories = batch.histories
            groups[-1].append(batch)
    return groups
