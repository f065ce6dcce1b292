"""Which batches go out together over a cluster, when, and what is done with those over which workers died."""

from __future__ import annotations

import numpy as np

from transport.run.dask.client import BatchPace, Groups


def test_groups_take_half_a_second_and_less_towards_the_end():
    pace = BatchPace()
    groups = Groups(((number, 1000) for number in range(1000)), pace, seconds=0.5)
    assert len(groups.take(2)) == 1  # nothing is known yet
    pace.add([(1000, 0.01)] * 100, 1000)
    taken = []
    while groups:
        taken.append(groups.take(2))
    assert [number for group in taken for number, _ in group] == list(range(1, 1000))
    sizes = np.array([len(group) for group in taken])
    assert 49 <= sizes[0] <= 50 and sizes[-1] == 1 and (np.diff(sizes) <= 0).all()
    groups.put_back(taken[3])
    groups.put_back(taken[0])
    assert groups.take(2) == taken[0] and groups.take(2) == taken[3] and not groups
    assert groups.left == 0
    pace.add([(1000, 0.01)] * 100, 100 << 25)
    assert (
        len(Groups([(number, 1000) for number in range(10_000)], pace).take(2)) == 1
    )  # large sums travel alone


def test_what_is_done_before_its_turn_is_bounded():
    """Where one worker is slow the others wait for it, but for what fits: so many bytes ahead."""
    pace = BatchPace()
    pace.add([(1000, 1.0)], 100)
    groups = Groups([(number, 1000) for number in range(5, 105)], pace, seconds=0.5, ahead=1000, turn=5)
    first = []
    while groups:
        first += groups.take(2)
    assert [number for number, _ in first] == list(range(5, 15))
    groups.put_back([first[0]])
    assert groups and groups.take(2) == [first[0]]  # which the others wait for
    groups.turn = 6
    assert groups.take(2) == [(15, 1000)] and not groups


def test_suspects_are_tried_one_at_a_time():
    groups = Groups([(number, 1000) for number in range(4)], BatchPace())
    assert not groups.suspect_group([(8, 10), (9, 10)])
    suspect = groups.take(2)
    assert suspect == [(8, 10)]
    assert groups.take(2) == [(0, 1000)]  # not the other suspect
    groups.put_back(suspect)  # its worker was lost with the scheduler: nothing is known yet
    suspect = groups.take(2)
    assert suspect == [(8, 10)]
    groups.clear(suspect)
    suspect = groups.take(2)
    assert suspect == [(9, 10)] and groups.suspect_group(suspect)
