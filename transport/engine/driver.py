"""Run a program bundle by bundle: fill free lanes with newborn particles, take every step, repeat.

`run_batch(compiled, seed, batch, histories)` is a pure function and the only unit of work.
"""

import math
from dataclasses import dataclass
from itertools import chain
from operator import itemgetter

import numpy as np
from numba import config, int64, njit

from transport.compile import layout, limits_exceeded
from transport.compile.plan import Plan
from transport.engine.bundle import HEADER, LANES, PlainRecord, call_pass, empty_bundle, header_of
from transport.engine.cache import cached_kernels
from transport.engine.passes.bank import BANK_CAPACITY
from transport.engine.passes.lanes import FIELDS
from transport.engine.program import Program
from transport.physics.bits import bits_of
from transport.physics.streams import SHARES, random_words, uniform

MAX_COPIES_PER_HISTORY = 20_000  # copies per history on average, and as many per lane
MAX_CROSSINGS = 1 << 30  # per batch: below it no sum can overflow its 64 bits (engine/tally.py)
# A bundle in which no history ends and no weight is lost for so many crossings or collisions never ends: 1e6
# crossings per lane of a full bundle. Fewer than 16 histories end before as lost (surfaces.MAX_EVENTS).
PATIENCE, PATIENCE_IN_MEDIA, UNLIMITED = 256 * 10**6, 1 << 30, 1 << 62
ROUNDING = 2.0**-40  # relative: a number of histories this close to an integer is that integer
# Golden section: its multiples modulo 1 are as evenly spread as possible (Knuth, TAOCP, 6.4).
GOLDEN = 0.6180339887498949
# least share of its due histories that the brightest emitter keeps when the others are rounded up
MIN_BRIGHTEST_SHARE = 0.95
PLACE_IN_HEADER = {name: place for place, name in enumerate(HEADER)}
# counts that are read at the end of a batch; they and some others begin at 0
COUNTED = [
    "crossings",
    "collisions",
    "started",
    "bank_overflow",
    "trapped",
    "killed",
    "scored",
    "record_count",
    "flight_count",
]
CLEARED = np.array([PLACE_IN_HEADER[name] for name in (*COUNTED, "banked", "rays_cast", "rays_taken")])
read_counts = itemgetter(*map(PLACE_IN_HEADER.get, COUNTED))
MAX_SCORED = 1 << 60  # largest sum of a volume detector [2^-32], to which each score adds up to 2^28


@dataclass(frozen=True)
class RawSums:
    """Integer sums of one batch: rows (high, low, count, slant) of detectors and of the energy balance."""

    histories: int
    birth_weight: int  # total birth weight [2^-63] of emitters without an aim
    detectors: np.ndarray  # (rows, 4) int64: detectors, then phase-space detectors
    ledger: np.ndarray  # (rows, 4) int64
    moments: np.ndarray  # (rows, 4) int64: long sums, such as of velocities, four limbs each
    sizes: np.ndarray  # (cells,) int64: histogram of score sizes
    records: np.ndarray  # layout.RECORD rows: one in `stride` histories at each snapshot
    stride: int
    tracks: np.ndarray  # layout.PATH_SEGMENT rows: flight segments, if tracks were requested
    flight_count: int  # number of segments flown, recorded or not
    births: np.ndarray  # (histories,) layout.BIRTH_RECORD, where the program has sums per history ...
    brought: np.ndarray  # ... and these, (histories, sums)
    seed: int
    crossings: int
    collisions: int


class Sums:
    """Memory for the sums of one batch, beside the arena of the plan."""

    def __init__(self, plan: Plan, histories: int, batches: int = 1, own: int = 0) -> None:
        self.tally_copies = layout.SCORE_COPIES if plan.rows <= layout.MAX_COPIED_ROWS else 1
        # The energy balance follows the tallies in one block, so that both have one address to find.
        counted, balanced = (
            self.tally_copies * plan.rows,
            layout.ABSORBED + len(plan.surfaces) + plan.media_rows,
        )
        rows = np.zeros((counted + balanced, 4), np.int64)
        self.tallies, self.ledger = rows[:counted].reshape(self.tally_copies, -1, 4), rows[counted:]
        self.moments = np.zeros((plan.long_rows, 4), np.int64)
        self.sizes = np.zeros(plan.size_cells, np.int64)
        wanted = max((snapshot.particles for snapshot in plan.scene.snapshots), default=histories)
        self.stride = max(1, histories * batches // max(1, wanted))
        has_bank = plan.splits or plan.forces_collisions
        self.bank = np.empty((BANK_CAPACITY if has_bank else 0, FIELDS), np.int64)  # read where written
        self.tracks = np.zeros(plan.max_path_segments, layout.PATH_SEGMENT)
        self.births = np.zeros(histories if own else 0, layout.BIRTH_RECORD)
        self.brought = np.zeros((histories if own else 0, own))
        self.records = np.zeros(len(plan.snapshots) * (histories // self.stride + 1), layout.RECORD)
        self.arena = plan.arena.memory

    @property
    def detectors(self) -> np.ndarray:
        """Return the sums of all copies, (rows, 4)."""
        return self.tallies.sum(axis=0) if self.tally_copies > 1 else self.tallies[0]

    def enter(self, bundle: np.ndarray, **words: int) -> None:
        """Write the addresses and sizes of this memory and the arena, and other words, into a header."""
        address = self.tallies.ctypes.data
        words |= {
            "arena": self.arena.ctypes.data,
            "tallies": address,
            "ledger": address + self.tallies.nbytes,
            "ledger_words": self.ledger.size,
        }
        words |= {"stride": self.stride, "tracks_capacity": len(self.tracks)}
        words["copy_rows"] = self.tallies.shape[1] if self.tally_copies > 1 else 0
        for name in ("moments", "sizes", "records", "tracks", "bank", "births", "brought"):
            if len(part := getattr(self, name)):
                words[name] = part.ctypes.data
        header = header_of(bundle)
        for name, word in words.items():
            header[PLACE_IN_HEADER[name]] = word


class Stopped(Exception):
    """The batch was stopped before it was complete; its sums are void."""


def _drive(bundle, handle, step_table, birth_table, shadow_table, split_table, histories):
    """Run `histories` histories to their ends.

    step_table: entries of the steps and offsets of their tables, the number of steps of lanes that begin to
    fly, and the number after these of steps of all lanes in flight; lanes at a surface take the others.
    birth_table: the same of birth steps, the first of these per emitter, the emitters' cumulative shares of
    the histories, and the two arrays of `_deal_histories`. shadow_table: bundle of shadow rays, its handle,
    entries and offsets of its steps. split_table: those of the pass that takes copies from the bank.

    Histories are dealt to emitters in proportion to their power, as one run of numbers each: as
    `_deal_histories` gives, else by systematic sampling, whose random offset makes the probability of each
    history exact. The offset advances by the golden section from batch to batch, so all batches together give
    each emitter its share to within about one history, and batches differ where shares are not integers.
    """
    entries, tables, ready, inner = step_table
    birth_entries, birth_tables, emitters, shares, dealt, worths = birth_table
    take_entry, take_table = split_table
    b = bundle[0]
    offset, phase = _batch_offsets(b.seed_low, b.seed_high, b.batch)
    b.record_phase = int64(phase * b.stride)
    count = emitters.shape[0] - 1
    copied, history, emitter, fresh = 0, 0, 0, 0
    end = dealt[0] if len(dealt) > 0 else _end_of_emitter(histories, shares[0], offset, count == 1)
    calm = (int64(0), int64(0), -1.0)
    b.flying = b.waiting = 0
    while True:
        # Fill free lanes: with copies from the bank first, then with newborn particles.
        before, begun, killed = b.flying + b.waiting, history + copied, b.killed
        flying, free = _pad_lanes(b, b.flying), LANES - b.waiting
        while b.banked > 0 and flying < free:
            taken = min(free - flying, b.banked)
            call_pass(take_entry[0], handle, take_table[0], flying, flying + taken)
            copied += taken
            flying = _pad_lanes(b, flying + taken)
        while flying < free and emitter < count:
            born = min(free - flying, end - history)
            if born > 0:
                b.next_history, b.birth_factor = history - flying, bits_of(worths[emitter])
                for p in range(emitters[emitter], emitters[emitter + 1]):
                    call_pass(birth_entries[p], handle, birth_tables[p], flying, flying + born)
                    _trace_shadow_rays(b, handle, shadow_table)
            flying, history = _pad_lanes(b, flying + born), history + born
            if history == end:
                emitter += 1
                if emitter < count and len(dealt) > 0:
                    end = dealt[emitter]
                elif emitter < count:
                    end = _end_of_emitter(histories, shares[emitter], offset, emitter == count - 1)
        b.started = history
        if copied > MAX_COPIES_PER_HISTORY * (history + LANES):
            b.bank_overflow = copied
        if flying + b.waiting == 0:
            _trace_waiting_rays(b, handle, shadow_table)
            return
        # Lanes that begin to fly are prepared; all fly.
        for p in range(ready):
            call_pass(entries[p], handle, tables[p], fresh, flying)
        for p in range(ready, ready + inner):
            flying = call_pass(entries[p], handle, tables[p], 0, flying)
            _trace_shadow_rays(b, handle, shadow_table)
            if flying == 0:
                break
        fresh = b.flying = flying
        # Once as many lanes wait at a surface as fly, they act there and fly on.
        if b.waiting > 0 and b.waiting >= flying:
            last = _pad_lanes(b, LANES + b.waiting)
            for p in range(ready + inner, len(entries)):
                call_pass(entries[p], handle, tables[p], LANES, last)
                _trace_shadow_rays(b, handle, shadow_table)
        # Detect endless histories; stop on request or before a sum overflows.
        new, live = history + copied - begun, b.flying + b.waiting
        calm = _detect_endless(b, calm, live, before + new - live - (b.killed - killed), new)
        if b.stop != 0 or b.trapped != 0 or b.bank_overflow != 0 or b.crossings >= MAX_CROSSINGS:
            return
        if max(b.scored, shadow_table[0][0].scored) >= MAX_SCORED:
            return


@njit(inline="always")
def _batch_offsets(seed_low, seed_high, batch):
    """Return the random offsets [1] of systematic sampling and of the histories recorded in snapshots."""
    _, _, w2, w3 = random_words(0, batch, 0, SHARES, seed_low, seed_high)
    o0, o1, _, _ = random_words(0, 0, 0, SHARES, seed_low, seed_high)
    return (uniform(o0, o1) + batch * GOLDEN) % 1.0, uniform(w2, w3)


@njit(inline="always")
def _trace_shadow_rays(b, handle, shadow_table):
    """Trace shadow rays of the last pass while they fill their bundle; the rest wait there."""
    _, shadow, entries, tables = shadow_table
    while b.rays_cast > 0:
        if call_pass(entries[0], handle, tables[0], 0, LANES) == LANES:
            for p in range(1, len(entries)):
                call_pass(entries[p], shadow, tables[p], 0, LANES)


@njit(inline="always")
def _trace_waiting_rays(b, handle, shadow_table):
    """Trace the waiting shadow rays at the end of a batch."""
    _, shadow, entries, tables = shadow_table
    while len(entries) > 0 and call_pass(entries[0], handle, tables[0], 0, LANES) > 0:
        for p in range(1, len(entries)):
            call_pass(entries[p], shadow, tables[p], 0, LANES)


@njit(inline="always")
def _detect_endless(b, calm, live, ended, new):
    """Set `trapped` if no history ended and no weight was lost within the bundle's patience.

    calm: crossings and collisions at the last end or birth, and the total weight halfway from there (-1: not
    yet reached). ended, new: histories of this turn. Returns the new value of calm.
    """
    since, since_in_media, weight = calm
    crossed, collided = b.crossings - since, b.collisions - since_in_media
    if ended != 0 or new != 0:
        return b.crossings, b.collisions, -1.0
    if weight < 0.0 and (2 * crossed >= b.patience or 2 * collided >= b.patience_in_media):
        return since, since_in_media, _total_weight(b)
    if crossed >= b.patience or collided >= b.patience_in_media:
        b.trapped = live if _total_weight(b) == weight else 0
        return b.crossings, b.collisions, -1.0
    return calm


@njit(inline="always")
def _total_weight(b):
    """Return the total weight of the lanes."""
    total = 0.0
    for k in range(b.flying):
        total += b.weight[k]
    for k in range(b.waiting):
        total += b.weight[LANES + k]
    return total


@njit(inline="always")
def _pad_lanes(b, live):
    """Pad the live lanes to whole vectors of eight with idle lanes (weight 0); returns their number."""
    full = (live + 7) // 8 * 8
    for k in range(live, full):
        b.weight[k] = 0.0
    return full


@njit(inline="always")
def _end_of_emitter(histories, share, offset, is_last):
    """Return one past the last history of an emitter with cumulative share `share` (systematic sampling)."""
    return histories if is_last else min(histories, max(0, int(math.ceil(histories * share - offset))))


with cached_kernels():
    drive = njit(cache=True, nogil=True, error_model="numpy")(_drive)


@dataclass(frozen=True)
class CompiledProgram:
    """A compiled program: entries, and offsets of tables, in the form of `_drive`. Threads share it."""

    program: Program
    step_table: tuple
    birth_table: tuple
    shadow_table: tuple
    split_table: tuple
    # power of each emitter's histories if all were born at the largest weight
    emitter_powers: np.ndarray
    by_chance: tuple[np.ndarray, np.ndarray]  # `_deal_histories` where systematic sampling deals

    def __reduce__(self) -> tuple:
        return compile_program, (self.program,)


def compile_program(program: Program, progress=None) -> CompiledProgram:
    """Compile the passes that are not compiled yet, and return the program ready to run.

    progress: called as progress(done, of, name) before each pass and before the driver.
    """
    passes = program.passes
    for done, lane_pass in enumerate(passes):
        if progress is not None:
            progress(done, len(passes), lane_pass.name)
        _ = lane_pass.entry
    bounds = np.array([e.bound for e in program.plan.emitters])
    starts = np.cumsum([0, *map(len, program.births)])
    compiled = CompiledProgram(
        program,
        step_table=(*_entry_table(program.steps), program.setup_count, program.round_count),
        birth_table=(*_entry_table(chain(*program.births)), starts, np.cumsum(bounds) / bounds.sum()),
        shadow_table=_entry_table(program.shadow_steps),
        split_table=_entry_table(program.bank_steps),
        emitter_powers=bounds,
        by_chance=(np.empty(0, np.int64), np.ones(len(bounds))),
    )
    if not (config.DISABLE_JIT or drive.signatures):
        if progress is not None:
            progress(len(passes), len(passes), drive.__name__)
        # Compile the driver now; otherwise the time of the first run would include it.
        run_batch(compiled, seed=0, batch=0, histories=0)
    return compiled


def _deal_histories(compiled: CompiledProgram, histories: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (one past the last history of each emitter, factors of the birth weights).

    The first array is empty where systematic sampling deals. That would deal the points of a net so evenly
    that all batches could have the same surplus history, an error that no standard error shows. For
    quasi-random sampling the numbers are therefore fixed and the birth weights compensate their rounding; the
    brightest emitter has the remaining histories.
    """
    bounds = compiled.emitter_powers
    if len(bounds) == 1 or compiled.program.plan.method.sampling == "random":
        return compiled.by_chance
    due = histories * (bounds / bounds.sum())
    numbers = np.ceil(due * (1.0 - ROUNDING)).astype(np.int64)
    brightest = int(np.argmax(due))
    numbers[brightest] += histories - numbers.sum()
    if numbers[brightest] < MIN_BRIGHTEST_SHARE * due[brightest]:
        return compiled.by_chance
    is_whole = np.abs(due - numbers) <= ROUNDING * due
    return np.cumsum(numbers), np.where(is_whole, 1.0, due / np.maximum(numbers, 1))


def _total_birth_weight(plan: Plan, without_aim: int, dealt: np.ndarray, worths: np.ndarray) -> int:
    """Return the total birth weight [2^-63] of histories without an aim."""
    if not len(dealt):
        return without_aim << 63
    numbers = np.diff(dealt, prepend=0)
    return sum(
        int(number) * int(math.ldexp(worth, 63))
        for emitter, number, worth in zip(plan.emitters, numbers, worths, strict=True)
        if not emitter.weighs_births
    )


def _entry_table(steps):
    """Return entries of steps, functions without compilation, and offsets of their tables in the arena."""
    steps = list(steps)
    entries = [lane_pass.entry for lane_pass, _ in steps]
    entries = entries if config.DISABLE_JIT else np.array(entries, np.int64)
    return entries, np.array([offset for _, offset in steps], np.int64)


def run_batch(
    compiled: CompiledProgram,
    seed: int,
    batch: int,
    histories: int,
    bundle: np.ndarray | None = None,
    batches: int = 1,
) -> RawSums:
    """Return the sums of one batch, a pure function of program, seed, and the batch's number and size.

    bundle: memory to work in; another thread may read its `started` and set its `stop`. batches: number of
    batches of the run, over which the sample of a Snapshot is divided.

    Raises Stopped after a stop, and OverrunError before a sum could overflow and if histories never end.
    """
    plan = compiled.program.plan
    bundle = empty_bundle() if bundle is None else bundle
    sums = Sums(plan, histories, batches, compiled.program.sums_per_history)
    # Prepare the bundle of shadow rays; without point or expected detectors the bundle itself stands for it.
    key = {"seed_low": seed & 0xFFFFFFFF, "seed_high": (seed >> 32) & 0xFFFFFFFF, "batch": batch}
    shadows = bundle
    if compiled.program.shadow_steps:
        shadows = empty_bundle()
        sums.enter(shadows, **key)
    # Reset the header of the bundle.
    header = header_of(bundle)
    header[CLEARED] = 0
    key["shadow"] = header_of(shadows)[PLACE_IN_HEADER["address"]]
    key["bank_capacity"] = BANK_CAPACITY
    key["patience"] = UNLIMITED if plan.has_clock else PATIENCE
    key["patience_in_media"] = UNLIMITED if plan.has_clock else PATIENCE_IN_MEDIA
    sums.enter(bundle, **key)
    lanes, handle = _handle(bundle)
    shadow_table = (*_handle(shadows), *compiled.shadow_table)
    dealt, worths = _deal_histories(compiled, histories)
    birth_table = (*compiled.birth_table, dealt, worths)
    split_table = compiled.split_table
    drive(lanes, handle, compiled.step_table, birth_table, shadow_table, split_table, histories)
    # Raise if the batch was stopped, cannot end, or exceeds a limit.
    if header[PLACE_IN_HEADER["stop"]]:
        raise Stopped
    counts = read_counts(header.tolist())
    crossings, collisions, started, overflow, trapped, killed, scored, recorded, flights = counts
    are_all_killed = 0 < killed == histories and not sums.ledger[layout.ABSORBED :, :2].any()
    if trapped or are_all_killed:
        particles = trapped or killed
        flying, waiting = (int(bundle[name][0]) if trapped else killed for name in ("flying", "waiting"))
        last = _last_surfaces(plan, bundle, flying, waiting)
        raise limits_exceeded.endless_particles_error(plan, last, particles)
    if overflow > 1:
        raise limits_exceeded.too_many_copies_error(plan, overflow, started)
    if overflow:
        raise limits_exceeded.full_bank_error(plan, BANK_CAPACITY)
    if crossings >= MAX_CROSSINGS:
        raise limits_exceeded.too_many_crossings_error(plan, crossings, started)
    if max(scored, int(header_of(shadows)[PLACE_IN_HEADER["scored"]])) >= MAX_SCORED:
        raise limits_exceeded.too_many_scores_error(histories)
    records = sums.records[:recorded]
    if len(records):
        records = np.sort(records, order=("snapshot", "history"))
    return RawSums(
        histories,
        _total_birth_weight(plan, histories - int(sums.ledger[layout.BORN, 2]), dealt, worths),
        sums.detectors,
        sums.ledger,
        sums.moments,
        sums.sizes,
        records,
        sums.stride,
        sums.tracks[:flights],
        flights,
        sums.births,
        sums.brought,
        seed,
        crossings,
        collisions,
    )


def _last_surfaces(plan: Plan, bundle: np.ndarray, flying: int, waiting: int) -> list[int]:
    """Return the sorted numbers of the surfaces that lanes in flight and those in the queue hit last."""
    _, shift, length = layout.PARTS["surface"]
    hits = bundle["hit"][0]
    rows = (np.r_[hits[:flying], hits[LANES : LANES + waiting]] >> shift) & ((1 << length) - 1)
    return sorted({plan.surface_numbers[row - 1] for row in rows.tolist() if row > 0})


def _handle(bundle: np.ndarray):
    """Return a bundle in the form of the driver, and its handle for passes.

    The handle is the bundle's address, or its record without compilation.
    """
    if config.DISABLE_JIT:
        record = PlainRecord(bundle)
        return [record], record
    return bundle, int(bundle["address"][0])
