"""Cost of each pass of a scene's program in nanoseconds per lane, measured on bundles from real steps."""

import itertools
import math
import statistics
import time
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterator

import numpy as np

from transport.command.treatment import Treatment, treatment_of
from transport.scene import Scene

# steps before states are recorded, limit of steps, states kept per pass
WARM_UP, MOST_STEPS, STATES = 32, 400, 8
# time of one timing of a pass [s], and number of timings; short timings avoid disturbances
TIMED, TIMINGS = 1e-3, 15


def pass_costs(scene: Scene | Treatment) -> dict[str, float]:
    """Measure the ns per lane of one call of each pass of the scene's program; births come first.

    Each pass is timed on states of a bundle recorded before that pass in real steps.  The fields that it
    changes are restored before every repetition, and the time to restore is subtracted.  Calls of one pass
    with several tables are averaged.  Lanes are those that reach the pass: with few lanes the overhead of the
    call dominates; without lanes the cost is nan.
    """
    from transport.engine.bundle import LANES
    from transport.engine.driver import Sums, machine_of
    from transport.engine.program import program_of

    plan = treatment_of(scene).plan
    program = machine_of(program_of(plan)).program
    sums = Sums(plan, MOST_STEPS * LANES)
    costs = defaultdict(list)
    for (name, entry, table), visits in _visits(program, sums).items():
        costs[name] += [_cost(entry, table, visits)] if visits else []
    return {name: statistics.fmean(of_calls) if of_calls else math.nan for name, of_calls in costs.items()}


def lanes_a_history(scene: Scene | Treatment) -> dict[str, float]:
    """Count the lanes per history that reach each pass of the scene's program, summed over its calls.

    The count runs over steps with full bundles, after the warm-up, when as many histories end as are born.
    """
    from transport.engine.bundle import LANES
    from transport.engine.driver import Sums, machine_of
    from transport.engine.program import program_of

    plan = treatment_of(scene).plan
    program, lanes, ready = machine_of(program_of(plan)).program, Counter(), 0

    def count(key, first, live, before, after):
        lanes[key[0]] += max(0, live - first)

    for turn, born in enumerate(_turns(program, Sums(plan, MOST_STEPS * LANES), count)):
        if turn == WARM_UP:
            ready = born
            lanes.clear()
    return {name: number / max(1, born - ready) for name, number in lanes.items()}


def _visits(program, sums) -> dict[tuple, deque]:
    """Return for each (name, entry, table) of a program the last (first, live, bundle before, after)."""
    visits = defaultdict(lambda: deque(maxlen=STATES))

    def keep(key, first, live, before, after):
        seen = visits[key]
        if first < live:
            seen.append((first, live, before, after.copy()))

    for turn, _ in enumerate(_turns(program, sums, keep)):
        if turn >= WARM_UP and all(len(seen) == STATES for seen in visits.values()):
            break
    return visits


def _turns(program, sums, tell: Callable) -> Iterator[int]:
    """Run real steps of one bundle, refilled from each emitter in turn; yield the histories born so far.

    `tell` is called with (name, entry, table) of each pass, its first and live lane, and the bundle before
    and after.
    """
    from transport.command.yardstick import replay
    from transport.engine.bundle import LANES, empty_bundle

    bundle, nothing = empty_bundle(), np.zeros(0, np.int64)
    sums.enter(bundle)
    words = bundle.view(np.int64)

    def visit(step, first, live):
        lane_pass, table = step
        entry, place, before = lane_pass.entry, table.ctypes.data, words.copy()
        left = replay(entry, place, bundle["address"], np.array([[first, live]]), words[None], nothing, 1)
        tell((lane_pass.name, entry, place), first, live, before, words)
        return left

    emitters, live, history = itertools.cycle(program.births), 0, 0
    for _ in range(MOST_STEPS):
        if live < LANES:
            bundle["next_history"] = history
            for step in next(emitters):
                visit(step, live, LANES)
        live, history = LANES, history + LANES - live
        for step in program.steps:
            live = visit(step, 0, live)
        yield history


def _cost(entry: int, table: int, visits: deque) -> float:
    """Time a pass on these recorded states and return ns per lane."""
    from transport.command.yardstick import replay
    from transport.engine.bundle import HEADER, LANES, Bundle, empty_bundle
    from transport.engine.passes import LANE_FIELDS

    first, live, before, after = (np.array(column) for column in zip(*visits, strict=True))
    bundles = [empty_bundle() for _ in visits]
    before[:, HEADER.index("address")] = handles = np.array([int(bundle["address"][0]) for bundle in bundles])
    for bundle, words in zip(bundles, before, strict=True):
        bundle.view(np.int64)[:] = words
    changed, fields = (before != after).any(axis=0), [Bundle.fields[name][1] // 8 for name in LANE_FIELDS]
    rows = np.array([row for row in fields if changed[row : row + LANES].any()], np.int64)
    spans = np.stack([first, live], axis=1)

    def seconds(which, repeats):
        begun = time.perf_counter()
        replay(which, table, handles, spans, before, rows, repeats)
        return time.perf_counter() - begun

    repeats = max(1, int(TIMED / min(seconds(entry, 1) for _ in range(TIMINGS))))
    turns = [(seconds(entry, repeats), seconds(0, repeats)) for _ in range(TIMINGS)]
    # Take the least disturbed timings.
    with_pass, without = (min(column) for column in zip(*turns, strict=True))
    return max(0.0, with_pass - without) / repeats / int((live - first).sum()) * 1e9
