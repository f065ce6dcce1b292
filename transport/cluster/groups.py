"""Which batches go out together: so many that a group takes about half a second, and fewer where a leg ends.

A group costs the scheduler and the client about a millisecond each, so that many threads get larger groups.  Towards the
end of a leg each takes but a share of what is left, so that all threads end together: guided self-scheduling
(Polychronopoulos and Kuck 1987, IEEE Trans. Comput. C-36, 1425).
"""

from __future__ import annotations

import heapq
import math
from collections import deque
from collections.abc import Iterable

SECONDS = 0.5  # that a group takes: long against the latency of a task, short against a person's patience
MOST_A_SECOND = 500  # groups that a scheduler and a client are to handle
SHARE = 2  # groups for each thread that what is left of a leg is worth
GROWTH = 4  # most times as many batches as were timed before: the first tell little of the others
MOST_BYTES = 1 << 25  # of the sums of a group, which travel as one

Group = list[tuple[int, int]]  # numbers and histories of batches


class Pace:
    """What batches take, going by the last group that was done: seconds a history, bytes of sums a batch."""

    def __init__(self) -> None:
        self.seconds, self.bytes, self.batches = 0.0, 0.0, 0

    def add(self, times: list[tuple[int, float]], size: int) -> None:
        """A group has been done: histories and seconds of its batches, and the bytes of their sums."""
        self.seconds = sum(seconds for _, seconds in times) / max(1, sum(histories for histories, _ in times))
        self.bytes = size / len(times)
        self.batches = max(self.batches, len(times))  # most that were done at a time

    @property
    def most(self) -> int:
        """Batches that may go out together."""
        return max(1, min(GROWTH * self.batches, int(MOST_BYTES / max(1.0, self.bytes))))


class Groups:
    """The batches of a leg that nobody does at present."""

    def __init__(
        self,
        batches: Iterable[tuple[int, int]],
        pace: Pace,
        seconds: float = SECONDS,
        ahead: float = math.inf,
        turn: int = 0,
    ) -> None:
        """batches: numbers and histories;  seconds: that a group is to take, where threads are few;  ahead: bytes of sums that
        may be done or under way before their turn;  turn: the number of the batch whose turn it is.
        """
        self.waiting = deque(batches)
        self.lost: list[Group] = []  # a heap: those with the lowest numbers first, for which the others wait
        self.suspects: list[Group] = []  # of one batch each, a heap
        self.suspect: Group | None = None  # that is out: one at a time, so that it is known who kills
        self.left = sum(size for _, size in self.waiting)  # histories
        self.pace, self.seconds, self.ahead, self.turn = pace, seconds, ahead, turn

    def __bool__(self) -> bool:
        """Whether there is one to take."""
        return bool(self.lost) or self._may_try_a_suspect() or (bool(self.waiting) and self._is_near())

    def take(self, threads: int) -> Group:
        """The next batches for one of so many threads."""
        if self._may_try_a_suspect():
            self.suspect = heapq.heappop(self.suspects)
            return self.suspect
        if self.lost:
            return heapq.heappop(self.lost)
        group, seconds = [self.waiting.popleft()], self._seconds(threads)
        expected = group[0][1] * self.pace.seconds
        while self.waiting and len(group) < self.pace.most:
            expected += self.waiting[0][1] * self.pace.seconds
            if expected > seconds:
                break
            group.append(self.waiting.popleft())
        self.left -= sum(size for _, size in group)
        return group

    def put_back(self, group: Group) -> None:
        """Nobody does these any more: their worker died, or was not to be reached."""
        heapq.heappush(self.suspects if group is self.suspect else self.lost, group)
        self.clear(group)

    def clear(self, group: Group) -> None:
        """These are done, or wait again."""
        if group is self.suspect:
            self.suspect = None

    def accuse(self, group: Group) -> bool:
        """Several workers died while they had these: each batch is to be tried by itself, one at a time.

        Whether it is known already that it was this one.
        """
        if group is self.suspect:
            return True
        for batch in group:
            heapq.heappush(self.suspects, [batch])
        return False

    def _may_try_a_suspect(self) -> bool:
        return bool(self.suspects) and self.suspect is None

    def _is_near(self) -> bool:
        """Whether the next batch would not wait too long for its turn: one slow worker must not fill this process."""
        number, _ = self.waiting[0]
        return (number - self.turn) * self.pace.bytes < self.ahead

    def _seconds(self, threads: int) -> float:
        """How long a group may take."""
        usual = max(self.seconds, threads / MOST_A_SECOND)
        return min(usual, self.left * self.pace.seconds / (SHARE * threads))
