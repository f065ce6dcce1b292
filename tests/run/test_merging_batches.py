"""Which batches become one: neighbours of one seed, the smallest first, and no more than it takes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest

from transport.run.schedules import contiguous_groups, merge_to_at_most, merge_to_fit, merge_up_to

pytestmark = pytest.mark.timeout(20)  # of which a loop without an end would never come to one


@dataclass(frozen=True)
class Piece:
    """What is looked at of a batch."""

    histories: int
    first: int
    seed: int = 0
    past: int = 0

    def merged(self, other, records):
        assert (other.seed, other.first, records) == (self.seed, self.past, 7)
        return replace(self, histories=self.histories + other.histories, past=other.past)


def pieces(*histories, seed=0, first=0):
    return [Piece(each, first + k, seed, first + k + 1) for k, each in enumerate(histories)]


def sizes(batches):
    return [batch.histories for batch in batches]


def test_neighbours_are_of_one_seed_and_have_no_gap():
    rows = contiguous_groups([*pieces(1, 1), *pieces(1, first=3), *pieces(1, seed=1, first=4)])
    assert [len(row) for row in rows] == [2, 1, 1]


def test_the_smallest_become_one_first_and_no_more_than_it_takes():
    batches, together = merge_to_fit([(8, 2)], pieces(*[1] * 8, 8, 8), 6, 7)
    assert sizes(batches) == [4, 4, 8, 8] and together == 1
    batches, together = merge_to_fit([(2, 9)], pieces(4, 4, 4, 4), 5, 7)
    assert sizes(batches) == [8, 8] and together == 4  # nine that are to come are three
    assert sizes(merge_to_at_most(3, pieces(2, 2, 2, 2, 2), 7)) == [4, 4, 2]
    assert sizes(merge_to_at_most(3, pieces(5, 1, 1), 7)) == [5, 1, 1]
    assert sizes(merge_up_to(pieces(2, 2, 3, 1), 4, 7)) == [4, 4]


def test_seeds_and_gaps_stay_apart_though_they_be_too_many():
    apart = [*pieces(1, seed=0), *pieces(1, seed=1), *pieces(1, seed=2)]
    batches, together = merge_to_fit([(1, 5)], apart, 3, 7)
    assert sizes(batches) == [1, 1, 1] and together == 8  # all that come are one
    assert merge_to_at_most(2, apart, 7) == apart
