"""Which batches become one where too many would be kept: neighbours, the smallest first, so that all are about as large."""

from __future__ import annotations

import math
from functools import reduce

from transport.results.batches import Batch


def unbroken(batches: list[Batch]) -> list[list[Batch]]:
    """Batches of one seed that follow one another without a gap, together: what is in the gap may be in another run."""
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
    """The batches, neighbours put together, and how many of the leg's are to become one: all about as large, no more than `most`.

    Never of two seeds or over a gap: where these are many, more are kept.  records: that two as one may keep.
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
    """The batches, where they are more than that, neighbours put together: the same where no others are to follow."""
    most, aim = max(most, len(unbroken(batches))), min(batch.histories for batch in batches)
    while len(groups := _groups(batches, aim)) > most:
        aim *= 2
    return _as_one(groups, records)


def gathered(batches: list[Batch], size: int, records: int) -> list[Batch]:
    """Neighbours put together as far as they have no more histories than that."""
    return _as_one(_groups(batches, size), records)


def _as_one(groups: list[list[Batch]], records: int) -> list[Batch]:
    return [reduce(lambda one, other: one.merged(other, records), group) for group in groups]


def net_of(batch: Batch) -> int:
    """Points of each of the nets that are together in a batch; where they are not alike, of one of average size."""
    each = max(1, batch.histories // (batch.past - batch.first))
    return 1 << (each.bit_length() - 1)


def _groups(batches: list[Batch], size: int) -> list[list[Batch]]:
    """Neighbours, as many together as have no more histories than that."""
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
