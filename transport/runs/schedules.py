"""Which batches a run is made of: legs of batches whose sizes depend on earlier ones alone, never on their timing.

A leg ends where the run looks at its errors; all batches of it are done before the next begins.  So a run's batches, and
where it stops, are the same for any number of threads.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import repeat

import numpy as np

from transport.compile.plan import Plan
from transport.results.batches import Batch
from transport.results.footprint import KEPT, batches_that_fit, bytes_of_a_batch, bytes_unpacked
from transport.runs.leaps import FARTHEST, FEWEST_ROUNDS, is_last_leap, leaps_suffice, leaps_to_come, slope_of
from transport.runs.limits import FEWEST_FOR_ERROR, MOST_PARTICLES, Limits
from transport.runs.neighbours import gathered, net_of, unbroken, with_room_for
from transport.runs.stopping import Look

LARGEST_BATCH = 1 << 24  # histories
MOST_EVENTS = 1 << 28  # crossings and collisions planned for a batch: sums are exact below 2^30
FIRST_BATCH = 512  # histories of a batch where only the time is limited; doubled as the run goes on
SMALL_BATCH = 128  # histories of a batch of a pilot
MEMORY = 1 << 28  # bytes of sums that a run for an error may keep, where nobody said how many batches
FEWEST = 32  # batches, unless they are very large
FEWEST_OF_A_ROUND = 8  # batches, by which a round that was not finished is better than the one before it
MOST_IN_ONE_GO = 4  # times as many batches as asked for, where those are too large; then neighbours merge

Leg = list[tuple[int, int]]  # histories of a batch, and how many such follow one another


def sizes_of(leg: Leg, done: int = 0) -> Iterator[int]:
    """Histories of each batch of a leg, but for the first so many."""
    for size, many in leg:
        yield from repeat(size, max(0, many - done))
        done = max(0, done - many)


def batches_in(leg: Leg) -> int:
    """How many batches a leg has."""
    return sum(many for _, many in leg)


def cut(leg: Leg, first: int, past: int) -> Leg:
    """The batches of a leg from one number to another."""
    cuts, begin = [], 0
    for size, many in leg:
        within = min(begin + many, past) - max(begin, first)
        cuts += [(size, within)] * (within > 0)
        begin += many
    return cuts


class Schedule:
    """The batches that are kept, and which come next.  This one is for `seconds`: batches double as the run goes on.

    Between `count` and twice as many are kept: then pairs become one.
    """

    remembered = ("issued",)  # the numbers by which a saved run goes on
    most, fewest_most = 2, 2  # times `count` that are kept at most, and where batches are large

    def __init__(self, limits: Limits, count: int, records: int, is_large: bool = False) -> None:
        """count: batches;  records: that snapshots may keep in all;  is_large: whether the sums of a batch are."""
        self.limits, self.count, self.records = limits, count, records
        self.is_large = is_large
        self.most_kept = (self.fewest_most if is_large else self.most) * count
        self.batches: list[Batch] = []
        self.current: list[Batch] = []  # of a round that is under way
        self.issued = 0  # histories of all legs so far

    @property
    def left(self) -> int:
        """Histories that may still be followed."""
        most = MOST_PARTICLES if self.limits.particles is None else self.limits.particles
        return max(0, most - self.issued)

    def next_leg(self, looks: list[Look]) -> Leg:
        """The batches until the next look; none where the run is over."""
        leg = self._leg(looks)
        self.issued += sum(size * many for size, many in leg)
        return leg

    def _leg(self, looks: list[Look]) -> Leg:
        size, left, many, leg = FIRST_BATCH, self.left, 2 * self.count, []
        if self.batches:
            size = min(LARGEST_BATCH, max(batch.histories for batch in self.batches))
            many = self.count
        while left >= size:
            leg.append((size, min(many, left // size)))
            left -= size * leg[-1][1]
            if leg[-1][1] == many:
                size, many = min(2 * size, LARGEST_BATCH), self.count
        return [*leg, (left, 1)] if left else leg

    def take(self, batch: Batch) -> None:
        """Keep a batch; they come in the order of their numbers."""
        self.batches.append(batch)
        if len(self.batches) >= self.most_kept:
            self._merge(2)  # of a planned run, where larger ones would not have been safe

    def end_leg(self) -> None:
        """All batches of the leg have been taken."""

    def adopt(self) -> None:
        """Go on with batches that a schedule of another kind has taken."""
        self.issued = self.particles

    def make_room(self) -> None:
        """More batches are to follow a whole run: up to twice as many as asked for are kept, however large, else too few were."""
        self.most_kept = max(self.most_kept, 2 * self.count)

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
        """Make one batch of so many that follow one another; never of two seeds, for a batch tells but one."""
        while together > 1:
            self.batches = [pair for batches in unbroken(self.batches) for pair in self._paired(batches)]
            together //= 2

    def _paired(self, batches: list[Batch]) -> list[Batch]:
        firsts, seconds = batches[::2], batches[1::2]
        both = zip(firsts, seconds, strict=False)
        return [one.merged(other, self.most_records(2)) for one, other in both] + firsts[len(seconds) :]

    def _sizes(self, more: int) -> Leg:
        """Batches for so many more histories, so that all are about as large; small ones are merged to that size."""
        largest = self._largest()
        size = min(largest, max((batch.histories for batch in self.batches), default=SMALL_BATCH))
        together = 1
        while 2 * size <= largest and (self.particles + more) >= 2 * size * self.count:
            size, together = 2 * size, 2 * together
        self._merge(together)
        fewest = 0 if self.batches else self.count
        return _evenly(more, max(fewest, math.ceil(more / size)))

    def most_records(self, together: int) -> int:
        """Of the sample of snapshots, that so many batches as one may keep."""
        return math.ceil(together * self.records / self.count)

    def _largest(self) -> int:
        """Histories of the largest batch that is safe, going by the events of those so far."""
        events = sum(batch.crossings + batch.collisions for batch in self.batches)
        each = events / max(1, self.particles)
        return int(min(LARGEST_BATCH, max(1.0, MOST_EVENTS / max(each, 1.0))))


class InOneGo(Schedule):
    """For `particles` alone: all batches at once."""

    remembered = ("issued", "together", "taken")
    most, fewest_most = MOST_IN_ONE_GO, 1
    together = 1  # batches that become one: what is kept does not grow with the histories
    taken = 0  # batches of this leg

    def _leg(self, looks: list[Look]) -> Leg:
        if self.left == 0:
            return []
        self.taken = 0
        if self.batches:
            leg = self._sizes(self.left)
            most, records = self.most_kept, self.most_records(2)
            self.batches, self.together = with_room_for(leg, self.batches, most, records)
        else:
            leg = self._first()
            self.together = max(1, math.ceil(batches_in(leg) / self.most_kept))
        return leg

    def part(self, leg: Leg) -> tuple[int, Leg]:
        """The part of the first leg that this run does, of several that share it: the number of its first batch, and the batches."""
        one, of = self.limits.part
        groups = math.ceil(batches_in(leg) / self.together)
        first, past = (groups * k // of * self.together for k in (one - 1, one))
        return first, cut(leg, first, past)

    def _first(self) -> Leg:
        least = math.ceil(self.left / LARGEST_BATCH)
        if self.is_large:  # as many together in each of those that are kept
            least = self.count * math.ceil(least / self.count)
        return _evenly(self.left, max(self.count, least))

    def take(self, batch: Batch) -> None:
        if self.taken % self.together:
            batch = self.batches.pop().merged(batch, self.most_records(min(self.together, MOST_IN_ONE_GO)))
        self.batches.append(batch)
        self.taken += 1


class Nets(InOneGo):
    """The same for points that know of one another: whole nets of them."""

    def _first(self) -> Leg:
        return [equal_powers_of_two(self.left, self.count)]

    def _sizes(self, more: int) -> Leg:
        """Larger nets, as a run of so many has, rather than more; small ones before them are put together, or they spoil errors."""
        size = was = min(LARGEST_BATCH, max(map(net_of, self.batches)))
        while size * self.count < more and 2 * size <= self._largest():
            size *= 2
        if size > was:
            self.batches = gathered(self.batches, size, self.most_records(2))
        return [(size, max(self.count * (size > was), math.ceil(more / size)))]


class Planned(Schedule):
    """For an `error`: a pilot of small batches, then as many histories as the last look asked for."""

    most = 4

    def _leg(self, looks: list[Look]) -> Leg:
        wanted = looks[-1].next_at if looks else SMALL_BATCH * self.count
        more = min(wanted - self.particles, self.left)
        return self._sizes(more) if more > 0 else []

    def to_come(self, looks: list[Look]) -> tuple[float, int]:
        return looks[-1].needed - looks[-1].particles, looks[-1].legs * self.count


class Rounds(Schedule):
    """For an `error` or `seconds` with points that know of one another: rounds of ever larger batches.

    The last round alone is the result: the earlier ones being less accurate than their number says they would only spoil
    it.  Once batches cannot grow any more, they become more.
    """

    remembered = ("issued", "size", "adds")
    most = 4

    def __init__(self, limits: Limits, count: int, records: int, is_large: bool = False) -> None:
        super().__init__(limits, count, records, is_large)
        few = self.left // count
        self.size = min(SMALL_BATCH, 1 << max(0, few.bit_length() - 1))
        self.farthest = FARTHEST if limits.seconds is None else 1  # what is not done when time is up is lost
        self.adds = False  # whether the present round joins those before it

    def _leg(self, looks: list[Look]) -> Leg:
        batches = self.count
        if self.batches:
            doublings = leaps_to_come(looks, self.farthest)[0] if looks else 1
            growth = min(doublings, self._growth())
            self.size, self.adds = self.size << growth, growth == 0
            if self.adds:
                batches = min((self.particles << doublings) - self.particles, self.left) // self.size
        else:
            batches = min(batches, self.left // self.size)  # of fewer particles than batches one each
        return [(self.size, batches)] if 0 < self.size * batches <= self.left else []

    def take(self, batch: Batch) -> None:
        self.current.append(batch)

    def adopt(self) -> None:
        super().adopt()
        if self.batches:  # none where a run was interrupted before the first one's turn came
            self.size = min(LARGEST_BATCH, net_of(self.batches[-1]))

    def end_leg(self) -> None:
        self.batches = self.batches + self.current if self.adds else self.current
        self.current = []
        fewest = len(unbroken(self.batches))
        while len(self.batches) >= max(self.most_kept, fewest + 1):
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
    if limits.is_free:
        count = min(count, _most_batches(limits, plan))
    if limits.error or limits.seconds is not None:
        kind = Rounds if not is_random else Planned if limits.error else Schedule
    else:
        kind = InOneGo if is_random else Nets
    return kind(limits, count, records, kind.most * count * bytes_of_a_batch(plan) > KEPT)


def _most_batches(limits: Limits, plan: Plan) -> int:
    """How many batches a run may have, by the size of their sums."""
    fit = batches_that_fit(plan)
    if not limits.error:
        return fit
    return max(FEWEST_FOR_ERROR, min(fit, max(FEWEST, MEMORY // (2 * bytes_unpacked(plan)))))


def equal_powers_of_two(particles: int, batches: int) -> tuple[int, int]:
    """Batches that hold whole nets, their size and how many: as asked, all equal, together no fewer than `particles`."""
    size = min(LARGEST_BATCH, 1 << (math.ceil(particles / batches) - 1).bit_length())
    return size, max(batches, math.ceil(particles / size))


def _evenly(particles: int, count: int) -> Leg:
    """So many batches, or one a particle, that differ by one at most."""
    count = min(particles, count)
    if count == 0:
        return []
    size, larger = divmod(particles, count)
    return [(each, many) for each, many in ((size + 1, larger), (size, count - larger)) if many]
