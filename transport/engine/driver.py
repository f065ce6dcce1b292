"""Runs a program bundle after bundle: fill up with newborn, take every step, until no particle is left.

`run_batch(machine, seed, batch, histories)` is a pure function and the only unit of work.
"""

import math
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numba import config, float64, int64, njit

from transport.compile.layout import ABSORBED, BORN, RECORD, SURFACE_MASK, SURFACE_SHIFT, WAY
from transport.compile.limits_exceeded import (
    endless,
    too_many_copies,
    too_many_crossings,
    too_many_scores,
    too_many_waiting,
)
from transport.compile.plan import Plan
from transport.engine.addresses import call_pass
from transport.engine.bank import FIELDS, ROOM
from transport.engine.bundle import LANES, empty_bundle
from transport.engine.cache import cached_kernels
from transport.engine.plain import PlainRecord
from transport.engine.program import Program
from transport.physics.bits import bits_of
from transport.physics.streams import SHARES, random_words, uniform

REST = 0.5  # of the cost of a pass in flight, that of one of the rest, which serves a part of the lanes
MOST_ROUNDS = 64  # of flights from collision to collision, before those that met a surface go on
MOST_COPIES_EACH = 20_000  # of a history in the mean, and as many for each lane
MOST_CROSSINGS = 1 << 30  # of a batch: below it no sum can leave its 64 bits (engine/sums.py)
# Crossings and collisions of a bundle in which some history must end or some weight be lost: else none ever will.  1e6 crossings
# per lane of a full bundle; fewer than 16 histories are given up before (surfaces.MOST_EVENTS), and counted as lost.
PATIENCE, PATIENCE_IN_MEDIA, FOR_EVER = 256 * 10**6, 1 << 30, 1 << 62
ROUNDING = 2.0**-40  # of an emitter's number of histories: above a whole number by less it is that
# The golden section: multiples of it fill a circle as evenly as can be (Knuth, The Art of Computer Programming, 6.4).
GOLDEN = 0.6180339887498949
LEFT = 0.95  # of the brightest emitter's histories: less is not left to it by the others
MOST_SCORED = 1 << 60  # the same for volume detectors: units of 2^-32 that they add up, and 2^28 a score


@dataclass(frozen=True)
class RawSums:
    """What a batch counted: integer rows (high, low, count, slant) of the meters and of the ledger."""

    histories: int
    sent: int  # weight [2^-63] with which all were born that no aim weighs
    meters: np.ndarray  # (rows, 4) int64; phase space behind the meters
    ledger: np.ndarray  # (rows, 4) int64
    moments: np.ndarray  # (rows, 4) int64: four limbs of velocity sums
    sizes: np.ndarray  # (cells,) int64: how often scores of each size came
    records: np.ndarray  # of layout.RECORD: one history in `stride` at each snapshot
    stride: int
    ways: np.ndarray  # of layout.WAY, where a picture asks for them
    walked: int  # how many there were, written down or not
    seed: int
    crossings: int
    collisions: int


class Sums:
    """The memory that a batch counts into."""

    def __init__(self, plan: Plan, histories: int, batches: int = 1) -> None:
        self.tallies = np.zeros((plan.rows, 4), np.int64)
        self.ledger = np.zeros((ABSORBED + len(plan.surfaces) + plan.media_rows, 4), np.int64)
        self.moments = np.zeros((plan.long_rows, 4), np.int64)
        self.sizes = np.zeros(plan.size_cells, np.int64)
        wanted = max((snapshot.particles for snapshot in plan.scene.snapshots), default=histories)
        self.stride = max(1, histories * batches // max(1, wanted))
        self.bank = np.zeros((ROOM, FIELDS) if plan.splits or plan.forces else (1, 1), np.int64)
        self.ways = np.zeros(plan.ways_room, WAY)
        self.records = np.zeros(len(plan.snapshots) * (histories // self.stride + 1), RECORD)

    def enter(self, bundle: np.ndarray) -> None:
        """Tell a bundle where to count."""
        for name in ("tallies", "ledger", "moments", "sizes", "records", "ways", "bank"):
            bundle[name] = getattr(self, name).ctypes.data
        bundle["ledger_words"], bundle["stride"], bundle["recorded"] = self.ledger.size, self.stride, 0
        bundle["ways_room"], bundle["walked"] = len(self.ways), 0


class Stopped(Exception):
    """The batch was told to stop before it was complete; its sums are void."""


def _drive(bundle, handle, flow, births, sight, copies, histories):
    """Run `histories` to their ends.

    flow: entries and tables of the steps, how many of them come before a flight, and how many after these are done again for
    what collides in a medium;  births: entries and tables of the newborn's steps, where among these each emitter's begin, and
    the emitters' cumulative shares, and what `_dealt` gives;  sight: of shadow rays the bundle, its handle, entries and tables of
    their steps;  copies: entries and tables of what takes copies from the bank.

    Histories are dealt to the emitters in proportion, in one run of numbers each: as `_dealt` says, else by systematic sampling,
    whose random offset makes every history's chance right.  From batch to batch it goes on by the golden section, so that all batches
    together have as many of each emitter as they should, but for about one history, and differ from one another where these are not whole.
    """
    entries, tables, ready, inner = flow
    birth_entries, birth_tables, emitters, shares, dealt, worths = births
    withdrawal, withdrawn = copies
    b = bundle[0]
    _, _, w2, w3 = random_words(0, b.batch, 0, SHARES, b.seed_low, b.seed_high)
    o0, o1, _, _ = random_words(0, 0, 0, SHARES, b.seed_low, b.seed_high)
    offset = (uniform(o0, o1) + b.batch * GOLDEN) % 1.0
    b.phase = int64(uniform(w2, w3) * b.stride)
    count = emitters.shape[0] - 1
    copied, live, history, emitter = 0, 0, 0, 0
    end = dealt[0] if len(dealt) > 0 else _last_of(histories, shares[0], offset, count == 1)
    calm = (int64(0), int64(0), -1.0)
    while True:
        before, begun, given_up = live, history + copied, b.given_up
        live = _fill_line(b, live)
        while b.banked > 0 and live < LANES:
            taken = min(LANES - live, b.banked)
            call_pass(withdrawal[0], handle, withdrawn[0], live, live + taken)
            copied += taken
            live = _fill_line(b, live + taken)
        while live < LANES and emitter < count:
            born = min(LANES - live, end - history)
            if born > 0:
                b.next_history, b.worth = history, bits_of(worths[emitter])
                for p in range(emitters[emitter], emitters[emitter + 1]):
                    call_pass(birth_entries[p], handle, birth_tables[p], live, live + born)
                    _trace(b, handle, sight)
            live, history = _fill_line(b, live + born), history + born
            if history == end:
                emitter += 1
                if emitter < count and len(dealt) > 0:
                    end = dealt[emitter]
                elif emitter < count:
                    end = _last_of(histories, shares[emitter], offset, emitter == count - 1)
        b.started = history
        if copied > MOST_COPIES_EACH * (history + LANES):
            b.overfull = copied
        if live == 0:
            _trace_last(b, handle, sight)
            return
        b.first = 0
        if inner > 0:
            _fly_on(b, handle, flow, sight, live)
        for p in range(ready + inner if inner > 0 else 0, len(entries)):
            live = call_pass(entries[p], handle, tables[p], b.first, live)
            _trace(b, handle, sight)
            if live == 0:
                break
        new = history + copied - begun
        calm = _watch(b, calm, live, before + new - live - (b.given_up - given_up), new)
        if (
            b.stop != 0
            or b.trapped != 0
            or b.overfull != 0
            or b.crossings >= MOST_CROSSINGS
            or max(b.scored, sight[0][0].scored) >= MOST_SCORED
        ):
            return


@njit(inline="always")
def _fly_on(b, handle, flow, sight, live):
    """Fly and collide, again and again, while the lanes that met a surface wait.

    A round costs the same however many lanes still fly; the rest of the program, which costs as much as `others` rounds,
    serves those that wait.  Flights are cheapest when the next round would make fewer than the mean for its cost so far
    (the marginal value theorem of Charnov 1976): then it is time to stop.
    """
    entries, tables, ready, inner = flow
    for p in range(ready):
        call_pass(entries[p], handle, tables[p], 0, live)
    others = REST * float64(len(entries) - inner) / float64(inner)
    flights, rounds = float64(live), 1.0
    while True:
        for p in range(ready, ready + inner):
            call_pass(entries[p], handle, tables[p], 0, live)
            _trace(b, handle, sight)
        if b.colliding * (rounds + others) <= flights or rounds >= MOST_ROUNDS:
            return
        flights += float64(b.colliding)
        rounds += 1.0


@njit(inline="always")
def _trace(b, handle, sight):
    """Of the shadow rays that the last pass has cast, trace as many as fill their bundle; the others wait there for more."""
    _, shadow, entries, tables = sight
    while b.cast > 0:
        if call_pass(entries[0], handle, tables[0], 0, LANES) == LANES:
            for p in range(1, len(entries)):
                call_pass(entries[p], shadow, tables[p], 0, LANES)


@njit(inline="always")
def _trace_last(b, handle, sight):
    """Trace those that wait, at the end of a batch."""
    _, shadow, entries, tables = sight
    while len(entries) > 0 and call_pass(entries[0], handle, tables[0], 0, LANES) > 0:
        for p in range(1, len(entries)):
            call_pass(entries[p], shadow, tables[p], 0, LANES)


@njit(inline="always")
def _watch(b, calm, live, ended, new):
    """Tell the bundle where no history ends any more: none has, and no weight was lost, for as long as its patience.

    calm: crossings and collisions since which none has ended or begun, and what the lanes carried halfway from there (-1:
    not yet there);  ended, new: histories of this turn.
    """
    since, since_in_media, weight = calm
    crossed, collided = b.crossings - since, b.collisions - since_in_media
    if ended != 0 or new != 0:
        return b.crossings, b.collisions, -1.0
    if weight < 0.0 and (2 * crossed >= b.patience or 2 * collided >= b.patience_in_media):
        return since, since_in_media, _weight(b, live)
    if crossed >= b.patience or collided >= b.patience_in_media:
        b.trapped = live if _weight(b, live) == weight else 0
        return b.crossings, b.collisions, -1.0
    return calm


@njit(inline="always")
def _weight(b, live):
    """What the lanes carry, in all."""
    total = 0.0
    for k in range(live):
        total += b.weight[k]
    return total


@njit(inline="always")
def _fill_line(b, live):
    """Lanes come in full vectors of eight: the rest of the last one idles at weight 0."""
    full = (live + 7) // 8 * 8
    for k in range(live, full):
        b.weight[k] = 0.0
    return full


@njit(inline="always")
def _last_of(histories, share, offset, is_last):
    """One past the last history of an emitter whose shares so far add up to `share`."""
    return histories if is_last else min(histories, max(0, int(math.ceil(histories * share - offset))))


with cached_kernels():
    drive = njit(cache=True, nogil=True, error_model="numpy")(_drive)


@dataclass(frozen=True)
class Machine:
    """A program made ready to run: entries and tables as `_drive` wants them.  Threads share it."""

    program: Program
    flow: tuple
    births: tuple
    sight: tuple
    copies: tuple
    # what each emitter's histories would stand for, if all were born at the largest weight
    bounds: np.ndarray


def machine_of(program: Program, progress=None) -> Machine:
    """Compile what is not compiled yet.  `progress(done, of, name)` is called before each pass, and before the driver."""
    passes = program.passes
    for done, lane_pass in enumerate(passes):
        if progress is not None:
            progress(done, len(passes), lane_pass.name)
        _ = lane_pass.entry
    bounds = np.array([e.bound for e in program.plan.emitters])
    starts = np.cumsum([0, *map(len, program.births)])
    machine = Machine(
        program,
        flow=(*_wired(program.steps), program.ready, program.inner),
        births=(*_wired(chain(*program.births)), starts, np.cumsum(bounds) / bounds.sum()),
        sight=_wired(program.sight),
        copies=_wired(program.withdrawal),
        bounds=bounds,
    )
    if not (config.DISABLE_JIT or drive.signatures):
        if progress is not None:
            progress(len(passes), len(passes), drive.__name__)
        # A first run would count its compilation as its own.
        run_batch(machine, seed=0, batch=0, histories=0)
    return machine


def _dealt(machine: Machine, histories: int) -> tuple[np.ndarray, np.ndarray]:
    """One past the last history of each emitter, none where chance deals them, and the weights at which histories are born.

    Chance would deal points that know of one another so evenly that all batches might have the same one more or less, of which no error
    would tell.  So their numbers are fixed, and weights make up for what is rounded; the brightest emitter has what is left.
    """
    bounds, count = machine.bounds, len(machine.bounds)
    by_chance = np.empty(0, np.int64), np.ones(count)
    if count == 1 or machine.program.plan.method.sampling == "random":
        return by_chance
    due = histories * (bounds / bounds.sum())
    numbers = np.ceil(due * (1.0 - ROUNDING)).astype(np.int64)
    brightest = int(np.argmax(due))
    numbers[brightest] += histories - numbers.sum()
    if numbers[brightest] < LEFT * due[brightest]:
        return by_chance
    is_whole = np.abs(due - numbers) <= ROUNDING * due
    return np.cumsum(numbers), np.where(is_whole, 1.0, due / np.maximum(numbers, 1))


def _sent(plan: Plan, without_aim: int, dealt: np.ndarray, worths: np.ndarray) -> int:
    """The weight [2^-63] of so many histories that no aim weighs."""
    if not len(dealt):
        return without_aim << 63
    numbers = np.diff(dealt, prepend=0)
    return sum(
        int(number) * int(math.ldexp(worth, 63))
        for emitter, number, worth in zip(plan.emitters, numbers, worths, strict=True)
        if emitter.target is None
    )


def _wired(steps):
    """Entries and tables of steps: addresses, or functions and records without compilation."""
    steps = list(steps)
    entries = [lane_pass.entry for lane_pass, _ in steps]
    if config.DISABLE_JIT:
        return entries, [table.reshape(1).view(np.recarray)[0] for _, table in steps]
    return np.array(entries, np.int64), np.array([table.ctypes.data for _, table in steps], np.int64)


def run_batch(
    machine: Machine,
    seed: int,
    batch: int,
    histories: int,
    bundle: np.ndarray | None = None,
    batches: int = 1,
) -> RawSums:
    """The sums of one batch: a pure function of the program, the seed, the batch's number and its size.

    bundle: memory to work in; another thread may read its `started` and set its `stop`.  batches: how many of them
    the run has, among which the sample of a Snapshot is divided.
    Raises Stopped if it was, and OverrunError before a sum could leave its range and where no history ends.
    """
    plan = machine.program.plan
    bundle = empty_bundle() if bundle is None else bundle
    sums = Sums(plan, histories, batches)
    sums.enter(bundle)
    header = {
        "seed_low": seed & 0xFFFFFFFF,
        "seed_high": (seed >> 32) & 0xFFFFFFFF,
        "batch": batch,
        "started": 0,
        "crossings": 0,
        "collisions": 0,
        "scored": 0,
        "banked": 0,
        "bank_room": ROOM,
        "overfull": 0,
        "given_up": 0,
        "patience": FOR_EVER if plan.has_clock else PATIENCE,
        "patience_in_media": FOR_EVER if plan.has_clock else PATIENCE_IN_MEDIA,
        "trapped": 0,
    }
    for name, value in header.items():
        bundle[name] = value
    lanes, handle = _handled(bundle)
    shadows = empty_bundle() if machine.program.sight else bundle
    sums.enter(shadows)
    for name in ("seed_low", "seed_high", "batch"):
        shadows[name] = bundle[name]
    bundle["shadow"], bundle["cast"], bundle["taken"] = shadows["address"], 0, 0
    sight = (*_handled(shadows), *machine.sight)
    dealt, worths = _dealt(machine, histories)
    drive(lanes, handle, machine.flow, (*machine.births, dealt, worths), sight, machine.copies, histories)
    if bundle["stop"][0]:
        raise Stopped
    counted = ("crossings", "started", "overfull", "trapped", "given_up")
    crossings, started, copies, trapped, given_up = (int(bundle[name][0]) for name in counted)
    is_all_given_up = 0 < given_up == histories and not sums.ledger[ABSORBED:, :2].any()
    if trapped or is_all_given_up:
        particles = trapped or given_up
        raise endless(plan, _surfaces_met(plan, bundle, particles), particles)
    if copies > 1:
        raise too_many_copies(plan, copies, started)
    if copies:
        raise too_many_waiting(plan, ROOM)
    if crossings >= MOST_CROSSINGS:
        raise too_many_crossings(plan, crossings, started)
    if max(int(bundle["scored"][0]), int(shadows["scored"][0])) >= MOST_SCORED:
        raise too_many_scores(histories)
    records = np.sort(sums.records[: int(bundle["recorded"][0])], order=("snapshot", "history"))
    return RawSums(
        histories,
        _sent(plan, histories - int(sums.ledger[BORN, 2]), dealt, worths),
        sums.tallies,
        sums.ledger,
        sums.moments,
        sums.sizes,
        records,
        sums.stride,
        sums.ways[: int(bundle["walked"][0])],
        int(bundle["walked"][0]),
        seed,
        crossings,
        int(bundle["collisions"][0]),
    )


def _surfaces_met(plan: Plan, bundle: np.ndarray, lanes: int) -> list[int]:
    """The numbers of the surfaces that lanes met last."""
    rows = (bundle["hit"][0][:lanes] >> SURFACE_SHIFT) & SURFACE_MASK
    return sorted({plan.owners[row - 1] for row in rows.tolist() if row > 0})


def _handled(bundle: np.ndarray):
    """A bundle as the driver wants it, and what passes are called with: its address, or its record without compilation."""
    if config.DISABLE_JIT:
        record = PlainRecord(bundle)
        return [record], record
    return bundle, int(bundle["address"][0])
