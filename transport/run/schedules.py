"""Schedules of batches: legs of batches whose sizes depend on earlier batches alone, never on timing.

A leg is a stage of a sequential run: the batches between two checks of the errors. All batches of a leg are
finished before the next leg begins. A run's batches, and where it ends, are therefore the same for any number
of threads.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import reduce
from itertools import repeat

import numpy as np

from transport.compile.plan import Plan
from transport.results.batches import Batch
from transport.results.footprint import MAX_KEPT_BYTES, batches_that_fit, bytes_of_batch, bytes_unpacked
from transport.run.settings import MAX_PARTICLES, MIN_BATCHES_FOR_ERROR, Limits
from transport.run.stopping import (
    MAX_STEP_DOUBLINGS,
    MIN_ROUNDS,
    Look,
    error_slope,
    is_last_round,
    planned_doublings,
    rounds_suffice,
)

# ---- Merge consecutive batches where too many would be stored, so that all are about equally large.


def contiguous_groups(batches: list[Batch]) -> list[list[Batch]]:
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


def merge_to_fit(
    leg: list[tuple[int, int]], batches: list[Batch], most: int, records: int
) -> tuple[list[Batch], int]:
    """Return the stored batches, merged, and how many batches of the leg to merge into one.

    All are then about equally large, and no more than `most`. Batches of two seeds, or on both sides of a
    gap, are never merged; where these are many, more are stored. records: snapshot records that two merged
    batches may keep.
    """
    size, more = leg[0][0], sum(many for _, many in leg)
    most = max(most, len(contiguous_groups(batches)) + 1)
    aim = min(size, *(batch.histories for batch in batches))
    while True:
        groups, together = _group_by_size(batches, aim), max(1, aim // size)
        if len(groups) + math.ceil(more / together) <= most:
            break
        aim *= 2
    return _merge_groups(groups, records), together


def merge_to_at_most(most: int, batches: list[Batch], records: int) -> list[Batch]:
    """Return at most `most` batches, consecutive ones merged, where no further batches follow."""
    most, aim = max(most, len(contiguous_groups(batches))), min(batch.histories for batch in batches)
    while len(groups := _group_by_size(batches, aim)) > most:
        aim *= 2
    return _merge_groups(groups, records)


def merge_up_to(batches: list[Batch], size: int, records: int) -> list[Batch]:
    """Merge consecutive batches up to `size` particles each."""
    return _merge_groups(_group_by_size(batches, size), records)


def _merge_groups(groups: list[list[Batch]], records: int) -> list[Batch]:
    """Merge each group into one batch."""
    return [reduce(lambda one, other: one.merged(other, records), group) for group in groups]


def net_size(batch: Batch) -> int:
    """Return the points per quasi-random net merged into a batch.

    For nets of unequal size, the average rounded down to a power of two.
    """
    each = max(1, batch.histories // (batch.past - batch.first))
    return 1 << (each.bit_length() - 1)


def _group_by_size(batches: list[Batch], size: int) -> list[list[Batch]]:
    """Group consecutive batches up to `size` particles per group."""
    groups: list[list[Batch]] = []
    for row in contiguous_groups(batches):
        histories = math.inf
        for batch in row:
            histories += batch.histories
            if histories > size:
                groups.append([])
                histories = batch.histories
            groups[-1].append(batch)
    return groups


# ---- Schedules.

MAX_BATCH_SIZE = 1 << 24  # particles
MAX_EVENTS = 1 << 28  # crossings and collisions planned per batch: sums are exact below 2^30
# particles of the first batches where only the time is limited; doubled as the run goes on
FIRST_BATCH_SIZE = 512
PILOT_BATCH_SIZE = 128  # particles per batch of a pilot
# bytes of sums that a run for an error may store, where the number of batches is left open
MAX_STORED_BYTES = 1 << 28
MIN_BATCHES = 32  # batches, unless these are very large
MIN_BATCHES_OF_ROUND = 8  # batches with which an unfinished round is better than the one before it
# times as many batches as requested, where those would be too large; consecutive ones are then merged
MAX_BATCHES_FACTOR = 4

Leg = list[tuple[int, int]]  # particles per batch, and how many such batches follow one another


def sizes_of(leg: Leg, done: int = 0) -> Iterator[int]:
    """Yield the particles of each batch of a leg, after the first `done` batches."""
    for size, many in leg:
        yield from repeat(size, max(0, many - done))
        done = max(0, done - many)


def batches_in(leg: Leg) -> int:
    """Return the number of batches in a leg."""
    return sum(many for _, many in leg)


def slice_leg(leg: Leg, first: int, past: int) -> Leg:
    """Return the batches of a leg with numbers from `first` up to, but not including, `past`."""
    cuts, begin = [], 0
    for size, many in leg:
        within = min(begin + many, past) - max(begin, first)
        cuts += [(size, within)] * (within > 0)
        begin += many
    return cuts


class Schedule:
    """The stored batches and the rule for the next ones.

    This schedule is for `seconds`: batches double as the run continues. Between `count` and twice as many
    batches are stored; at the upper limit pairs are merged.
    """

    remembered = ("issued",)  # attributes that a saved run restores
    # largest number of stored batches in units of `count`, and the same where batches are large
    most, fewest_most = 2, 2

    def __init__(self, limits: Limits, count: int, records: int, is_large: bool = False) -> None:
        """count: batches; records: snapshot records in all; is_large: whether a batch's sums are large."""
        self.limits, self.count, self.records = limits, count, records
        self.is_large = is_large
        self.max_stored = (self.fewest_most if is_large else self.most) * count
        self.batches: list[Batch] = []
        self.current: list[Batch] = []  # batches of the present round
        self.issued = 0  # particles in all legs so far

    @property
    def left(self) -> int:
        """Return the particles that may still be run."""
        most = MAX_PARTICLES if self.limits.particles is None else self.limits.particles
        return max(0, most - self.issued)

    def next_leg(self, looks: list[Look]) -> Leg:
        """Return the batches until the next error check; none where the run is over."""
        leg = self._leg(looks)
        self.issued += sum(size * many for size, many in leg)
        return leg

    def _leg(self, looks: list[Look]) -> Leg:
        size, left, many, leg = FIRST_BATCH_SIZE, self.left, 2 * self.count, []
        if self.batches:
            size = min(MAX_BATCH_SIZE, max(batch.histories for batch in self.batches))
            many = self.count
        while left >= size:
            leg.append((size, min(many, left // size)))
            left -= size * leg[-1][1]
            if leg[-1][1] == many:
                size, many = min(2 * size, MAX_BATCH_SIZE), self.count
        return [*leg, (left, 1)] if left else leg

    def take(self, batch: Batch) -> None:
        """Store a batch; batches come in the order of their numbers."""
        self.batches.append(batch)
        if len(self.batches) >= self.max_stored:
            self._merge(2)  # in a planned run, where larger batches would not have been safe

    def end_leg(self) -> None:
        """Finish a leg, all batches of which have been taken."""

    def adopt(self) -> None:
        """Continue from batches that a schedule of another kind has taken."""
        self.issued = self.particles

    def make_room(self) -> None:
        """Allow twice the requested number of batches, however large.

        More batches follow a finished run; otherwise too few batches would be left.
        """
        self.max_stored = max(self.max_stored, 2 * self.count)

    @property
    def kept(self) -> list[Batch]:
        """Return the batches of the result, should the run end now."""
        return self.batches

    def is_enough(self, looks: list[Look]) -> bool:
        """Return whether the run may end."""
        return looks[-1].is_enough

    def to_come(self, looks: list[Look]) -> tuple[float, int]:
        """Return the particles and batches that the run will still take, as far as is known."""
        raise NotImplementedError

    def is_foreseen(self, looks: list[Look]) -> bool:
        """Return whether that forecast is reliable."""
        return True

    def slope(self, looks: list[Look], name: str) -> float | None:
        """Return the slope of a quantity's error against time; None where it is not measured."""
        return None

    @property
    def particles(self) -> int:
        """Return the particles in stored batches."""
        return sum(batch.histories for batch in self.batches)

    def _merge(self, together: int) -> None:
        """Merge groups of so many consecutive batches; never of two seeds, as a batch records one seed."""
        while together > 1:
            groups = contiguous_groups(self.batches)
            self.batches = [pair for batches in groups for pair in self._paired(batches)]
            together //= 2

    def _paired(self, batches: list[Batch]) -> list[Batch]:
        """Merge consecutive pairs; an odd last batch stays as it is."""
        firsts, seconds = batches[::2], batches[1::2]
        both = zip(firsts, seconds, strict=False)
        return [one.merged(other, self.max_records(2)) for one, other in both] + firsts[len(seconds) :]

    def _sizes(self, more: int) -> Leg:
        """Return a leg of so many more particles in batches of about equal size.

        Smaller stored batches are merged to that size.
        """
        largest = self._largest()
        size = min(largest, max((batch.histories for batch in self.batches), default=PILOT_BATCH_SIZE))
        together = 1
        while 2 * size <= largest and (self.particles + more) >= 2 * size * self.count:
            size, together = 2 * size, 2 * together
        self._merge(together)
        fewest = 0 if self.batches else self.count
        return _even_leg(more, max(fewest, math.ceil(more / size)))

    def max_records(self, together: int) -> int:
        """Return the snapshot records that so many merged batches may keep."""
        return math.ceil(together * self.records / self.count)

    def _largest(self) -> int:
        """Return the particles of the largest safe batch, by the events per particle so far."""
        events = sum(batch.crossings + batch.collisions for batch in self.batches)
        each = events / max(1, self.particles)
        return int(min(MAX_BATCH_SIZE, max(1.0, MAX_EVENTS / max(each, 1.0))))


class FixedCount(Schedule):
    """Fixed number of particles: all batches in one leg."""

    remembered = ("issued", "together", "taken")
    most, fewest_most = MAX_BATCHES_FACTOR, 1
    together = 1  # batches to merge into one, so that storage does not grow with the particles
    taken = 0  # batches taken of this leg

    def _leg(self, looks: list[Look]) -> Leg:
        if self.left == 0:
            return []
        self.taken = 0
        if self.batches:
            leg = self._sizes(self.left)
            most, records = self.max_stored, self.max_records(2)
            self.batches, self.together = merge_to_fit(leg, self.batches, most, records)
        else:
            leg = self._first()
            self.together = max(1, math.ceil(batches_in(leg) / self.max_stored))
        return leg

    def part(self, leg: Leg) -> tuple[int, Leg]:
        """Return this run's part of the first leg: the number of its first batch, and its batches."""
        one, of = self.limits.part
        groups = math.ceil(batches_in(leg) / self.together)
        first, past = (groups * k // of * self.together for k in (one - 1, one))
        return first, slice_leg(leg, first, past)

    def _first(self) -> Leg:
        least = math.ceil(self.left / MAX_BATCH_SIZE)
        if self.is_large:  # the same number merged in each stored batch
            least = self.count * math.ceil(least / self.count)
        return _even_leg(self.left, max(self.count, least))

    def take(self, batch: Batch) -> None:
        """Store a batch; every `together` consecutive batches are merged into one."""
        if self.taken % self.together:
            batch = self.batches.pop().merged(batch, self.max_records(min(self.together, MAX_BATCHES_FACTOR)))
        self.batches.append(batch)
        self.taken += 1


class QmcSchedule(FixedCount):
    """Fixed number of particles in quasi-random sampling: batches are complete nets.

    The sizes of nets are powers of two.
    """

    def _first(self) -> Leg:
        return [net_sizes(self.left, self.count)]

    def _sizes(self, more: int) -> Leg:
        """Return a leg of larger nets rather than more nets, as a run of that size has.

        Smaller stored nets are merged, as they would spoil the errors.
        """
        size = was = min(MAX_BATCH_SIZE, max(map(net_size, self.batches)))
        while size * self.count < more and 2 * size <= self._largest():
            size *= 2
        if size > was:
            self.batches = merge_up_to(self.batches, size, self.max_records(2))
        return [(size, max(self.count * (size > was), math.ceil(more / size)))]


class PilotThenRun(Schedule):
    """Schedule for `error`: a pilot of small batches, then as many particles as the last check requires."""

    most = 4

    def _leg(self, looks: list[Look]) -> Leg:
        wanted = looks[-1].next_check if looks else PILOT_BATCH_SIZE * self.count
        more = min(wanted - self.particles, self.left)
        return self._sizes(more) if more > 0 else []

    def to_come(self, looks: list[Look]) -> tuple[float, int]:
        """Return the particles missing from the number that the last check found necessary, and batches."""
        return looks[-1].particles_needed - looks[-1].particles, looks[-1].legs * self.count


class QmcRounds(Schedule):
    """Schedule for `error` or `seconds` in quasi-random sampling: rounds of ever larger batches.

    The last round alone is the result: earlier rounds are less accurate than their number of particles
    suggests, and would only make it worse. Once batches cannot grow any more, their number grows.
    """

    remembered = ("issued", "size", "adds")
    most = 4

    def __init__(self, limits: Limits, count: int, records: int, is_large: bool = False) -> None:
        super().__init__(limits, count, records, is_large)
        few = self.left // count
        self.size = min(PILOT_BATCH_SIZE, 1 << max(0, few.bit_length() - 1))
        # Grow by small steps where time is limited: an unfinished round is lost when time is up.
        self.max_doublings = MAX_STEP_DOUBLINGS if limits.seconds is None else 1
        self.adds = False  # whether the present round is added to those before it

    def _leg(self, looks: list[Look]) -> Leg:
        batches = self.count
        if self.batches:
            doublings = planned_doublings(looks, self.max_doublings)[0] if looks else 1
            growth = min(doublings, self._growth())
            self.size, self.adds = self.size << growth, growth == 0
            if self.adds:
                batches = min((self.particles << doublings) - self.particles, self.left) // self.size
        else:
            # with fewer particles than batches, one particle per batch
            batches = min(batches, self.left // self.size)
        return [(self.size, batches)] if 0 < self.size * batches <= self.left else []

    def take(self, batch: Batch) -> None:
        """Store a batch of the current round."""
        self.current.append(batch)

    def adopt(self) -> None:
        """Continue with the batch size of the batches that another schedule has taken."""
        super().adopt()
        if self.batches:  # none where the run was interrupted before its first batch was taken
            self.size = min(MAX_BATCH_SIZE, net_size(self.batches[-1]))

    def end_leg(self) -> None:
        """Finish a round: its batches replace those of the earlier ones, or join them."""
        self.batches = self.batches + self.current if self.adds else self.current
        self.current = []
        fewest = len(contiguous_groups(self.batches))
        while len(self.batches) >= max(self.max_stored, fewest + 1):
            self._merge(2)

    @property
    def kept(self) -> list[Batch]:
        """Return the batches of the current round if it has enough, otherwise those of the last round."""
        if self.adds:
            return self.batches + self.current
        is_ample = len(self.current) >= max(MIN_BATCHES_OF_ROUND, self.count // 2)
        return self.current if is_ample else self.batches or self.current

    def is_enough(self, looks: list[Look]) -> bool:
        """Return whether the rounds so far reach the target error and the run may end."""
        return rounds_suffice(looks, self.max_doublings)

    def to_come(self, looks: list[Look]) -> tuple[float, int]:
        """Return the particles and batches of the planned rounds."""
        doublings = planned_doublings(looks, self.max_doublings)
        if self._growth() == 0:
            histories = self.particles * (2.0 ** sum(doublings) - 1)
            return histories, math.ceil(histories / self.size)
        histories = self.count * self.size * float((2.0 ** np.cumsum(doublings)).sum())
        return histories, self.count * len(doublings)

    def is_foreseen(self, looks: list[Look]) -> bool:
        """Return whether the next round is planned to be the last."""
        return len(looks) >= MIN_ROUNDS and is_last_round(looks, self.max_doublings)

    def slope(self, looks: list[Look], name: str) -> float | None:
        """Return the slope of a quantity's error against the number of particles in the last rounds."""
        return error_slope(looks, name)

    def _growth(self) -> int:
        """Return by how many doublings batches may grow.

        They may grow as far as is safe, and as particles are left for a round.
        """
        largest = min(self._largest(), self.left // self.count)
        return max(0, (largest // self.size).bit_length() - 1)


def schedule_for(limits: Limits, plan: Plan) -> Schedule:
    """Return the schedule of a run within its limits."""
    count, records = limits.batches, sum(snapshot.particles for snapshot in plan.scene.snapshots)
    is_random = plan.method.sampling == "random"
    if limits.is_free:
        count = min(count, _max_batches(limits, plan))
    if limits.error or limits.seconds is not None:
        kind = QmcRounds if not is_random else PilotThenRun if limits.error else Schedule
    else:
        kind = FixedCount if is_random else QmcSchedule
    return kind(limits, count, records, kind.most * count * bytes_of_batch(plan) > MAX_KEPT_BYTES)


def _max_batches(limits: Limits, plan: Plan) -> int:
    """Return the largest number of batches, by the size of their sums."""
    fit = batches_that_fit(plan)
    if not limits.error:
        return fit
    stored = max(MIN_BATCHES, MAX_STORED_BYTES // (2 * bytes_unpacked(plan)))
    return max(MIN_BATCHES_FOR_ERROR, min(fit, stored))


def net_sizes(particles: int, batches: int) -> tuple[int, int]:
    """Return the size and number of equal batches that hold complete nets, together at least `particles`."""
    size = min(MAX_BATCH_SIZE, 1 << (math.ceil(particles / batches) - 1).bit_length())
    return size, max(batches, math.ceil(particles / size))


def _even_leg(particles: int, count: int) -> Leg:
    """Return a leg of so many batches, or one per particle, that differ by one particle at most."""
    count = min(particles, count)
    if count == 0:
        return []
    size, larger = divmod(particles, count)
    return [(each, many) for each, many in ((size + 1, larger), (size, count - larger)) if many]
