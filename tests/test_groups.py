"""Which batches go out together over a cluster, when, and what is done with those over which workers died."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("distributed")
from distributed import KilledWorker

from transport.run.dask.executor import DaskExecutor, Groups
from transport.run.executor import WorkersLost


def test_groups_take_half_a_second_and_less_towards_the_end():
    groups = Groups(seconds=0.5)
    groups.put_back((number, 1000) for number in range(1000))
    assert len(groups.take(2)) == 1  # nothing is known yet
    groups.add([(1000, 0.01)] * 100, 1000)
    taken = []
    while groups.waiting:
        taken.append(groups.take(2))
    assert [number for group in taken for number, _ in group] == list(range(1, 1000))
    sizes = np.array([len(group) for group in taken])
    assert 49 <= sizes[0] <= 50 and sizes[-1] == 1 and (np.diff(sizes) <= 0).all()
    assert groups.left == 0
    groups.put_back(taken[3])
    assert groups.left == 1000 * len(taken[3]) and groups.waiting[0] == taken[3][0]
    groups.put_back((number, 1000) for number in range(10_000))
    groups.add([(1000, 0.01)] * 100, 100 << 25)
    assert len(groups.take(2)) == 1  # large sums travel alone


class Sent(DaskExecutor):
    """Without a cluster: what would be sent to two workers of one thread."""

    def __init__(self, batches, **state):
        self.groups, self.suspects, self.suspect = Groups(), [], None
        self.next, self.ahead, self.done, self.in_flight = 0, {}, [], {}
        self.max_ahead_bytes, self.worker_threads = float("inf"), {"a": 1, "b": 1}
        self.groups.put_back(batches)
        for name, value in state.items():
            setattr(self, name, value)

    def send(self):
        """Send all that may be sent now; return their groups."""
        sent = []
        while group := self._next_group():
            self.in_flight[len(sent), self.next] = group
            sent.append(group)
        return sent


def test_what_is_done_before_its_turn_is_bounded():
    """Where one worker is slow the others wait for it, but for what fits: so many bytes ahead."""
    sums = Sent([(number, 1000) for number in range(5, 105)], next=5, max_ahead_bytes=1000)
    sums.worker_threads = {"a": 100}
    sums.groups.batch_bytes = 100.0
    assert [group[0][0] for group in sums.send()] == list(range(5, 15))
    sums.next = 6
    assert sums.send() == [[(15, 1000)]]


def test_suspects_are_tried_one_at_a_time():
    """When nothing else is in flight: Dask blames all tasks of a dead worker."""
    killed = KilledWorker("task", SimpleNamespace(address="tcp://a"), 0)
    died = "future", (KilledWorker, killed, None)
    sums = Sent([(number, 1000) for number in range(4)])
    sums.groups.most = 2
    sums.in_flight = {died[0]: [(8, 10), (9, 10)], "another": [(7, 10)]}
    sums._take_in(*died)
    assert sums.send() == []  # another is in flight
    sums.in_flight.clear()
    assert sums.send() == [[(8, 10)]]
    sums.in_flight, sums.suspect = {}, None  # it was no cause
    assert sums.send() == [[(9, 10)]]
    sums.in_flight = {died[0]: sums.suspect}
    with pytest.raises(WorkersLost, match=r"batch 9 \(10 particles\) killed 1 workers; the last was tcp://a"):
        sums._take_in(*died)
