"""Sizes of task groups: about half a second of batches per group, and less at the end of a leg.

A group costs the scheduler and the client about a millisecond each, so that many threads get larger groups.
Towards the end of a leg each group takes a share of what is left, so that all threads end together: guided
self-scheduling (Polychronopoulos and Kuck 1987, IEEE Trans. Comput. C-36, 1425).
"""

from __future__ import annotations

import heapq
import math
from collections import deque
from collections.abc import Iterable

SECONDS = 0.5  # [s] per group: long against the latency of a task, short against a person's patience
MOST_A_SECOND = 500  # groups per second that a scheduler and a client can handle
SHARE = 2  # groups per thread into which the rest of a leg is divided
GROWTH = 4  # largest factor of batches over those timed before, as the first say little about the others
MOST_BYTES = 1 << 25  # bytes of the sums of a group, which travel together

Group = list[tuple[int, int]]  # numbers and particles of batches


class Pace:
    """Cost of batches, by the last finished group: seconds per particle, bytes of sums per batch."""

    def __init__(self) -> None:
        self.seconds, self.bytes, self.batches = 0.0, 0.0, 0

    def add(self, times: list[tuple[int, float]], size: int) -> None:
        """Add a finished group: particles and seconds of its batches, and the bytes of their sums."""
        self.seconds = sum(seconds for _, seconds in times) / max(1, sum(histories for histories, _ in times))
        self.bytes = size / len(times)
        self.batches = max(self.batches, len(times))  # largest number of batches in a finished group

    @property
    def most(self) -> int:
        """Return the largest number of batches in the next group."""
        return max(1, min(GROWTH * self.batches, int(MOST_BYTES / max(1.0, self.bytes))))


class Groups:
    """The batches of a leg that no worker computes at present."""

    def __init__(
        self,
        batches: Iterable[tuple[int, int]],
        pace: Pace,
        seconds: float = SECONDS,
        ahead: float = math.inf,
        turn: int = 0,
    ) -> None:
        """Take batches as (number, particles).

        seconds: target time per group, where threads are few; ahead: bytes of sums that may be finished or in
        progress before their turn; turn: number of the batch that the run waits for.
        """
        self.waiting = deque(batches)
        # heap of groups to send again, lowest numbers first, as the run waits for these
        self.lost: list[Group] = []
        self.suspects: list[Group] = []  # heap of groups of one batch each that may kill their workers
        # the suspect in progress; one at a time, so that the cause of a death is known
        self.suspect: Group | None = None
        self.left = sum(size for _, size in self.waiting)  # particles
        self.pace, self.seconds, self.ahead, self.turn = pace, seconds, ahead, turn

    def __bool__(self) -> bool:
        """Return whether a group is available now."""
        return bool(self.lost) or self._may_try_a_suspect() or (bool(self.waiting) and self._is_near())

    def take(self, threads: int) -> Group:
        """Return the next group for one of so many threads."""
        # Try suspects first, then lost groups, as the run waits for these.
        if self._may_try_a_suspect():
            self.suspect = heapq.heappop(self.suspects)
            return self.suspect
        if self.lost:
            return heapq.heappop(self.lost)
        # Fill a new group up to its time.
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
        """Put back a group whose worker died or could not be reached."""
        heapq.heappush(self.suspects if group is self.suspect else self.lost, group)
        self.clear(group)

    def clear(self, group: Group) -> None:
        """Note that a group is finished, or waits again."""
        if group is self.suspect:
            self.suspect = None

    def accuse(self, group: Group) -> bool:
        """Suspect a group over which several workers died: try each of its batches alone, one at a time.

        Return whether the group is already known to be the cause.
        """
        if group is self.suspect:
            return True
        for batch in group:
            heapq.heappush(self.suspects, [batch])
        return False

    def _may_try_a_suspect(self) -> bool:
        return bool(self.suspects) and self.suspect is None

    def _is_near(self) -> bool:
        """Return whether the next batch is near its turn.

        Otherwise one slow worker could fill this process's memory.
        """
        number, _ = self.waiting[0]
        return (number - self.turn) * self.pace.bytes < self.ahead

    def _seconds(self, threads: int) -> float:
        """Return the time that a group may take [s]."""
        usual = max(self.seconds, threads / MOST_A_SECOND)
        return min(usual, self.left * self.pace.seconds / (SHARE * threads))
