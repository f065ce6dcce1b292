"""Cost of each pass of a scene's program in nanoseconds per lane, measured on bundles from real steps."""

import itertools
import math
import statistics
import time
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from transport.cli.effects.treatment import Treatment, treatment_of
from transport.scene.scene import Scene

# steps before states are recorded, limit of steps, states kept per pass
WARM_UP, MAX_STEPS, STATES_PER_PASS = 32, 400, 8
# time of one timing of a pass [s], and number of timings; short timings avoid disturbances
TIMING_SECONDS, TIMINGS = 1e-3, 15


def pass_costs(scene: Scene | Treatment) -> dict[str, float]:
    """Measure the ns per lane of one call of each pass of the scene's program; births come first.

    Each pass is timed on states of a bundle recorded before that pass in real steps.  The fields that it
    changes are restored before every repetition, and the time to restore is subtracted.  Calls of one pass
    with several tables are averaged.  Lanes are those that reach the pass: with few lanes the overhead of the
    call dominates; without lanes the cost is nan.
    """
    from transport.engine.bundle import LANES
    from transport.engine.driver import Sums, compile_program

    program = compile_program(treatment_of(scene).program).program
    sums = Sums(program.plan, MAX_STEPS * LANES)
    costs = defaultdict(list)
    for (name, entry, table), visits in _record_states(program, sums).items():
        costs[name] += [_time_pass(entry, table, visits)] if visits else []
    return {name: statistics.fmean(of_calls) if of_calls else math.nan for name, of_calls in costs.items()}


def lanes_per_history(scene: Scene | Treatment) -> dict[str, float]:
    """Count the lanes per history that reach each pass of the scene's program, summed over its calls.

    The count runs over steps with full bundles, after the warm-up, when as many histories end as are born.
    """
    from transport.engine.bundle import LANES
    from transport.engine.driver import Sums, compile_program

    program, lanes, ready = compile_program(treatment_of(scene).program).program, Counter(), 0

    def count(key, first, live, before, after):
        lanes[key[0]] += max(0, live - first)

    for turn, born in enumerate(_run_steps(program, Sums(program.plan, MAX_STEPS * LANES), count)):
        if turn == WARM_UP:
            ready = born
            lanes.clear()
    return {name: number / max(1, born - ready) for name, number in lanes.items()}


def _record_states(program, sums) -> dict[tuple, deque]:
    """Return for each (name, entry, table) of a program the last (first, live, bundle before, after)."""
    visits = defaultdict(lambda: deque(maxlen=STATES_PER_PASS))

    def keep(key, first, live, before, after):
        seen = visits[key]
        if first < live:
            seen.append((first, live, before, after.copy()))

    for turn, _ in enumerate(_run_steps(program, sums, keep)):
        if turn >= WARM_UP and all(len(seen) == STATES_PER_PASS for seen in visits.values()):
            break
    return visits


def _run_steps(program, sums, tell: Callable) -> Iterator[int]:
    """Run real steps of one bundle, refilled from each emitter in turn; yield the histories born so far.

    `tell` is called with (name, entry, table) of each pass, its first and live lane, and the bundle before
    and after.
    """
    from transport.cli.bench.yardstick import replay_pass
    from transport.engine.bundle import LANES, empty_bundle

    bundle, nothing = empty_bundle(), np.zeros(0, np.int64)
    sums.enter(bundle)
    words = bundle.view(np.int64)

    def visit(step, first, live):
        lane_pass, table = step
        entry, place, before = lane_pass.entry, table.ctypes.data, words.copy()
        left = replay_pass(
            entry, place, bundle["address"], np.array([[first, live]]), words[None], nothing, 1
        )
        tell((lane_pass.name, entry, place), first, live, before, words)
        return left

    emitters, live, history = itertools.cycle(program.births), 0, 0
    for _ in range(MAX_STEPS):
        if live < LANES:
            bundle["next_history"] = history
            for step in next(emitters):
                visit(step, live, LANES)
        live, history = LANES, history + LANES - live
        for step in program.steps:
            live = visit(step, 0, live)
        yield history


def _time_pass(entry: int, table: int, visits: deque) -> float:
    """Time a pass on these recorded states and return ns per lane."""
    from transport.cli.bench.yardstick import replay_pass
    from transport.engine.bundle import HEADER, LANES, Bundle, empty_bundle
    from transport.engine.registry import LANE_FIELDS

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
        replay_pass(which, table, handles, spans, before, rows, repeats)
        return time.perf_counter() - begun

    repeats = max(1, int(TIMING_SECONDS / min(seconds(entry, 1) for _ in range(TIMINGS))))
    turns = [(seconds(entry, repeats), seconds(0, repeats)) for _ in range(TIMINGS)]
    # Take the least disturbed timings.
    with_pass, without = (min(column) for column in zip(*turns, strict=True))
    return max(0.0, with_pass - without) / repeats / int((live - first).sum()) * 1e9


# ---- Cost of each effect of a scene: sum over its passes [ns per history], and share of the total.
#
# Measured on the program of random analog histories; shadow rays to detectors are not included.

# Files of passes by effect, and single passes of files that serve several; the name of an effect that
# every scene needs ends in a full stop.
EFFECTS = {
    "births.": ("emission", "aims"),
    "flight and shapes.": ("intersections", "landing", "lanes", "flats", "quadrics", "meshes"),
    "counting.": ("detectors", "score_sizes"),
    "finer bins": ("detector_bins",),
    "surfaces": ("surfaces", "optics"),
    "roulette": ("play_roulette", "play_roulette_by_importance", "play_roulette_in_flight"),
    "media": ("collisions", "regions", "voxels"),
    "forced collisions and splitting": ("variance_reduction", "bank"),
    "volume detectors": ("volumes", "volume_cells"),
    "the clock": (
        "set_birth_time", "sample_birth_time", "sample_birth_time_and_speed", "sample_pulse_time",
        "time_arrival", "time_arrival_by_speed", "time_arrival_in_media", "stop_clock",
    ),
    "speeds": ("velocities",),
    "history filters (via, events)": ("mark_visit", "require_visits", "require_reflections"),
    "snapshots": ("snapshots",),
    "tracks": ("record_tracks",),
    "path lengths": ("paths",),
    "point detectors": ("shadow_rays", "once_more_collided"),
    "next-event estimation": ("next_event", "mis"),
    "backward histories": ("backward",),
}  # fmt: skip
_EFFECT_OF = {member: name for name, members in EFFECTS.items() for member in members}


@dataclass(frozen=True)
class EffectCost:
    """Cost of one effect: ns per history, share of all passes, and whether a scene can do without it."""

    name: str
    ns: float
    share: float
    can_go: bool
    passes: tuple[str, ...]


def effect_costs(scene: Scene | Treatment) -> list[EffectCost]:
    """Measure the cost of each effect of the scene; return them sorted, most expensive first."""
    return costs_by_effect(pass_costs(scene), lanes_per_history(scene), files_of_passes())


def costs_by_effect(
    costs: Mapping[str, float], lanes: Mapping[str, float], files: Mapping[str, str]
) -> list[EffectCost]:
    """Sum the costs of passes by effect.

    `costs` are in ns per lane, `lanes` the lanes per history, `files` the file of each pass.  A pass that no
    lane reached costs nothing.
    """
    ns, passes = defaultdict(float), defaultdict(list)
    for name, cost in costs.items():
        effect = effect_of(name, files)
        ns[effect] += 0.0 if math.isnan(cost) else cost * lanes.get(name, 0.0)
        passes[effect].append(name)
    total = math.fsum(ns.values())
    effects = [
        EffectCost(
            effect.rstrip("."),
            spent,
            spent / total if total else 0.0,
            not effect.endswith("."),
            tuple(passes[effect]),
        )
        for effect, spent in ns.items()
    ]
    return sorted(effects, key=lambda effect: -effect.ns)


def effect_of(name: str, files: Mapping[str, str]) -> str:
    """Return the effect of a pass, "other" for a pass without one; `files` are the file of each pass."""
    base = base_name(name)
    return _EFFECT_OF.get(base) or _EFFECT_OF.get(files.get(base, ""), "other")


def base_name(name: str) -> str:
    """Return the name of a pass without the name of its sampling."""
    return name.partition(" by ")[0]


def files_of_passes() -> dict[str, str]:
    """Return the engine's file of each pass, by the name of the pass."""
    from transport.engine.registry import MODULE_OF_PASS

    return MODULE_OF_PASS


# ---- Memory of a program: bytes touched per lane, bytes carried with a particle, size of the bundle.

WORD = 8  # bytes per field and lane


@dataclass(frozen=True)
class Footprint:
    """Memory of a program in bytes.

    Per lane: `touched` by the passes of a step, `carried` with the particle, `known` for all fields of the
    engine.  Per bundle: `bundle` reserved, `used` by the fields of this program.
    """

    touched: int
    carried: int
    known: int
    bundle: int
    used: int


def footprint_of(program) -> Footprint:
    """Return the footprint of a program."""
    from transport.engine.bundle import HEADER_WORDS, PITCH, empty_bundle
    from transport.engine.registry import LANE_FIELDS

    steps = (*program.steps, *program.bank_steps, *program.shadow_steps)
    touched = {name for lane_pass, _ in steps for name in lane_pass.fields} | set(program.carried)
    used = touched | {name for lane_pass in program.passes for name in lane_pass.fields}
    return Footprint(
        touched=WORD * len(touched),
        carried=WORD * len(program.carried),
        known=WORD * len(LANE_FIELDS),
        bundle=empty_bundle().nbytes,
        used=WORD * (HEADER_WORDS + PITCH * len(used)),
    )
