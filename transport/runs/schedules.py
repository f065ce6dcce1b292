"""Which batches a run is made of: legs of batches whose sizes depend on earlier ones alone, never on their timing.

A leg ends where the run looks at its errors; all batches of it are done before the next begins.  So a run's batches, and
where it stops, are the same for any number of threads.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from transport.compile.plan import Plan
from transport.results.batches import Batch
from transport.runs.leaps import FARTHEST, FEWEST_ROUNDS, is_last_leap, leaps_suffice, leaps_to_come, slope_of
from transport.runs.limits import MOST_PARTICLES, Limits
from transport.runs.stopping import Look

LARGEST_BATCH = 1 << 24  # histories
MOST_EVENTS = (
    1 << 28
)  # crossings and collisions of a batch planned by what earlier ones had: sums are exact below 2^30
FIRST_BATCH = 512  # histories of a batch where only the time is limited; doubled as the run goes on
SMALL_BATCH = 128  # histories of a batch of a pilot
MEMORY = 1 << 28  # bytes of sums that a run for an error may keep, where nobody said how many batches
FEWEST = 32  # batches, however large they are
FEWEST_OF_A_ROUND = 8  # batches, by which a round that was not finished is better than the one before it


class Schedule:
    """The batches that are kept, and which come next.  This one is for `seconds`: batches double as the run goes on.

    Between `count` and twice as many are kept: then pairs become one.
    """

    def __init__(self, limits: Limits, count: int, records: int) -> None:
        """count: batches;  records: that snapshots may keep in all."""
        self.limits, self.count, self.records = limits, count, records
        self.batches: list[Batch] = []
        self.left = MOST_PARTICLES if limits.particles is None else limits.particles

    def leg(self, looks: list[Look]) -> Iterator[int]:
        """Histories of the batches until the next look; none where the run is over."""
        size, left, repeat = FIRST_BATCH, self.left, 2
        self.left = 0
        while left > 0:
            for _ in range(repeat * self.count):
                if left > 0:
                    yield min(size, left)
                    left -= min(size, left)
            size, repeat = min(2 * size, LARGEST_BATCH), 1

    def take(self, batch: Batch) -> None:
        """Keep a batch; they come in the order of their numbers."""
        self.batches.append(batch)
        if len(self.batches) == 2 * self.count:
            self._merge(2)

    def end_leg(self) -> None:
        """All batches of the leg have been taken."""

    @property
    def kept(self) -> list[Batch]:
        """What the result is made of, should the run end now."""
        return self.batches

    def is_enough(self, looks: list[Look]) -> bool:
        """Whether the run may end."""
        return looks[-1].is_enough

    def to_come(self, looks: list[Look]) -> tuple[float, int]:
        """Histories and batches that the run will still take, going by what it saw."""
        raise NotImplementedError

    def is_foreseen(self, looks: list[Look]) -> bool:
        """Whether that may be relied upon."""
        return True

    def slope(self, looks: list[Look], name: str) -> float | None:
        """The slope of a quantity's error against the time, where it has been measured."""
        return None

    @property
    def particles(self) -> int:
        """Histories of the batches that are kept."""
        return sum(batch.histories for batch in self.batches)

    def _merge(self, together: int) -> None:
        """Make one batch of so many that follow one another."""
        while together > 1:
            most = math.ceil(2 * self.records / self.count)
            firsts, seconds = self.batches[::2], self.batches[1::2]
            odd = firsts[len(seconds) :]
            self.batches = [
                one.merged(other, most) for one, other in zip(firsts, seconds, strict=False)
            ] + odd
            together //= 2

    def _largest(self) -> int:
        """Histories of the largest batch that is safe, going by the events of those so far."""
        events = sum(batch.crossings + batch.collisions for batch in self.batches)
        each = events / max(1, self.particles)
        return int(min(LARGEST_BATCH, max(1.0, MOST_EVENTS / max(each, 1.0))))


class InOneGo(Schedule):
    """For `particles` alone: all batches at once."""

    def leg(self, looks: list[Look]) -> Iterator[int]:
        particles, self.left = self.left, 0
        yield from _evenly(particles, max(self.count, math.ceil(particles / LARGEST_BATCH)))

    def take(self, batch: Batch) -> None:
        self.batches.append(batch)


class Nets(InOneGo):
    """The same for points that know of one another: whole nets of them."""

    def leg(self, looks: list[Look]) -> Iterator[int]:
        particles, self.left = self.left, 0
        yield from equal_powers_of_two(particles, self.count) if particles else ()


class Planned(Schedule):
    """For an `error`: a pilot of small batches, then as many histories as the last look asked for."""

    def leg(self, looks: list[Look]) -> Iterator[int]:
        wanted = looks[-1].next_at if looks else SMALL_BATCH * self.count
        more = min(wanted - self.particles, self.left)
        if more <= 0:
            return
        self.left -= more
        yield from self._sizes(more)

    def _sizes(self, more: int) -> Iterator[int]:
        """Batches for so many more histories, so that all are about as large; small ones are merged to that size."""
        largest = self._largest()
        size = max((batch.histories for batch in self.batches), default=min(SMALL_BATCH, largest))
        together = 1
        while 2 * size <= largest and (self.particles + more) >= 2 * size * self.count:
            size, together = 2 * size, 2 * together
        self._merge(together)
        fewest = 0 if self.batches else self.count
        yield from _evenly(more, max(fewest, math.ceil(more / size)))

    def take(self, batch: Batch) -> None:
        self.batches.append(batch)
        if len(self.batches) == 4 * self.count:  # where larger batches would not have been safe
            self._merge(2)

    def to_come(self, looks: list[Look]) -> tuple[float, int]:
        last = looks[-1]
        return last.needed - last.particles, last.legs * self.count


class Rounds(Schedule):
    """For an `error` or `seconds` with points that know of one another: rounds of ever larger batches.

    The last round alone is the result: the earlier ones being less accurate than their number says they would only spoil
    it.  Once batches cannot grow any more, they become more.
    """

    def __init__(self, limits: Limits, count: int, records: int) -> None:
        super().__init__(limits, count, records)
        few = self.left // count
        self.size = min(SMALL_BATCH, 1 << max(0, few.bit_length() - 1))
        self.farthest = FARTHEST if limits.seconds is None else 1  # what is not done when time is up is lost
        self.current: list[Batch] = []
        self.adds = False  # whether the present round joins those before it

    def leg(self, looks: list[Look]) -> Iterator[int]:
        batches = self.count
        if self.batches:
            doublings = leaps_to_come(looks, self.farthest)[0] if looks else 1
            growth = min(doublings, self._growth())
            self.size, self.adds = self.size << growth, growth == 0
            if self.adds:
                batches = min((self.particles << doublings) - self.particles, self.left) // self.size
        if self.size * batches > self.left:
            return
        self.left -= self.size * batches
        for _ in range(batches):
            yield self.size

    def take(self, batch: Batch) -> None:
        self.current.append(batch)

    def end_leg(self) -> None:
        self.batches = self.batches + self.current if self.adds else self.current
        self.current = []
        while len(self.batches) >= 4 * self.count:
            self._merge(2)

    @property
    def kept(self) -> list[Batch]:
        if self.adds:
            return self.batches + self.current
        is_ample = len(self.current) >= max(FEWEST_OF_A_ROUND, self.count // 2)
        return self.current if is_ample else self.batches or self.current

    def is_enough(self, looks: list[Look]) -> bool:
        return leaps_suffice(looks, self.farthest)

    def to_come(self, looks: list[Look]) -> tuple[float, int]:
        leaps = leaps_to_come(looks, self.farthest)
        if self._growth() == 0:
            histories = self.particles * (2.0 ** sum(leaps) - 1)
            return histories, math.ceil(histories / self.size)
        return self.count * self.size * float((2.0 ** np.cumsum(leaps)).sum()), self.count * len(leaps)

    def is_foreseen(self, looks: list[Look]) -> bool:
        return len(looks) >= FEWEST_ROUNDS and is_last_leap(looks, self.farthest)

    def slope(self, looks: list[Look], name: str) -> float | None:
        return slope_of(looks, name)

    def _growth(self) -> int:
        """By how many doublings batches may grow: as far as that is safe, and as there are particles left for a round."""
        largest = min(self._largest(), self.left // self.count)
        return max(0, (largest // self.size).bit_length() - 1)


def schedule_for(limits: Limits, plan: Plan) -> Schedule:
    """How to spend what the limits allow."""
    count, records = limits.batches, sum(snapshot.particles for snapshot in plan.scene.snapshots)
    is_random = plan.method.sampling == "random"
    if limits.error and limits.is_free:
        count = min(count, max(FEWEST, MEMORY // (2 * _bytes_of(plan))))
    if limits.error or limits.seconds is not None:
        kind = Rounds if not is_random else Planned if limits.error else Schedule
    else:
        kind = InOneGo if is_random else Nets
    return kind(limits, count, records)


def equal_powers_of_two(particles: int, batches: int) -> list[int]:
    """Sizes of batches that hold whole nets: as many as asked, all equal, together no fewer than `particles`."""
    size = min(LARGEST_BATCH, 1 << (math.ceil(particles / batches) - 1).bit_length())
    return [size] * max(batches, math.ceil(particles / size))


def _evenly(particles: int, count: int) -> Iterator[int]:
    """So many batches, or one a particle, that differ by one at most."""
    count = min(particles, count)
    for k in range(count):
        yield particles // count + (k < particles % count)


def _bytes_of(plan: Plan) -> int:
    """Of the sums of a batch: weights, counts and slants of its rows, and velocities."""
    return 8 * (3 * plan.rows + plan.long_rows)
