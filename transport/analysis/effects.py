"""What a scene calls for and what that costs: its passes and fields, the cost of each effect, the whole run.

An effect is priced by its passes: each pass is timed on bundles recorded in real steps, and counts as often
as lanes reach it.  The time of a whole run per history stands beside the sum, as a check of it.
"""

import importlib
import itertools
import math
import pkgutil
import statistics
import time
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from transport.compile.guides import UNIFORM
from transport.compile.methods import ANALOG, AUTO, Method, coerce_method
from transport.compile.plan import Plan
from transport.run.programs import plan_for
from transport.run.settings import coerce_tracking
from transport.scene.scene import Scene
from transport.scene.tracking import Tracking

# ---- A treatment: a scene with the tracking, estimator and sampling of its run.


@dataclass(frozen=True)
class Treatment:
    """A scene and the settings of its run; `tracking` None selects the default of the scene."""

    scene: Scene
    tracking: Tracking | None = None
    method: Method = ANALOG

    def checked(self) -> "Treatment":
        """Return this treatment.  Raises SceneError if the scene does not allow its settings."""
        coerce_method(self.scene, self.method.estimator, self.method.sampling)
        coerce_tracking(self.scene, self.tracking)
        return self

    @property
    def plan(self) -> Plan:
        """The compiled plan."""
        return plan_for(self.scene, self.tracking, self.method)

    @property
    def program(self):
        """The program of its passes, not compiled; with a guide, of one that has learnt nothing yet."""
        from transport.engine.program import build_program

        plan = self.plan
        return build_program(plan, [UNIFORM] * len(plan.emitters) if plan.is_guided else ())


def treatment_of(scene: Scene | Treatment, **settings: object) -> Treatment:
    """Return the treatment of a scene with these arguments of `simulate`; "auto" and None: defaults."""
    if isinstance(scene, Treatment):
        return scene
    estimator, sampling = settings.get("estimator"), settings.get("sampling") or "random"
    method = coerce_method(scene, None if estimator == AUTO else estimator, sampling)
    return Treatment(scene, coerce_tracking(scene, settings.get("tracking")), method)


# ---- Passes of a scene in order, fields of its bundles, and absent passes and fields, without a run.


@dataclass(frozen=True)
class Effects:
    """Passes and fields of a scene's program.

    `births` holds the pass names of a birth at each emitter (a source, or a face of a Box), `steps` those of
    a step, both in order.
    """

    births: tuple[tuple[str, ...], ...]
    steps: tuple[str, ...]
    fields: Mapping[str, str]  # name -> "carried" with the particle, or "scratch" within one step

    @property
    def passes(self) -> tuple[str, ...]:
        """Names of the passes, each once, in order of first use."""
        return tuple(dict.fromkeys(name for part in (*self.births, self.steps) for name in part))

    @cached_property
    def absent(self) -> dict[str, str]:
        """Passes and fields of the engine that the scene does not use: name -> "pass" or "field"."""
        from transport.engine.bodies import LANE_FIELDS

        passes = {name: "pass" for name in known_passes() if name not in self.passes}
        return passes | {name: "field" for name in LANE_FIELDS if name not in self.fields}


def effects_of(scene: Scene | Treatment) -> Effects:
    """Return the effects of a scene without compiling or running anything."""
    from transport.engine.bodies import LANE_FIELDS

    program = treatment_of(scene).program
    carried = program.carried
    touched = {name for lane_pass in program.passes for name in lane_pass.fields}
    fields = {
        name: "carried" if name in carried else "scratch"
        for name in LANE_FIELDS
        if name in touched | set(carried)
    }
    births = tuple(tuple(lane_pass.name for lane_pass, _ in part) for part in program.births)
    steps = (*program.steps, *program.bank_steps, *program.shadow_steps)
    return Effects(births, tuple(lane_pass.name for lane_pass, _ in steps), fields)


def known_passes() -> list[str]:
    """Return the names of all passes of the engine."""
    from transport.engine import passes
    from transport.engine.bodies import Pass

    names = {}
    for module in pkgutil.iter_modules(passes.__path__):
        family = importlib.import_module(f"transport.engine.passes.{module.name}")
        names |= {value.name: None for value in vars(family).values() if isinstance(value, Pass)}
    return list(names)


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
    from transport.engine.bodies import LANE_FIELDS
    from transport.engine.bundle import HEADER_WORDS, PITCH, empty_bundle

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


# ---- Compilation of a program.


@dataclass(frozen=True)
class CompileTime:
    """Cost of the first run of a program in a process.

    `passes` is the number of passes, `on_disk` the number of those loaded from the cache.  `seconds` is the
    CPU time that compiled or loaded them, `driver` the CPU time [s] for the driver that calls them (the same
    for all scenes).  `bytes` is the size of the machine code on disk afterwards.
    """

    passes: int
    on_disk: int
    seconds: float
    driver: float
    bytes: int


def compile_time_of(treatment: Treatment, compiling: Callable | None = None) -> CompileTime:
    """Compile or load the program of a treatment, and run one history.

    Calls `compiling(done, of, name)` before each pass.
    """
    from transport.engine.cache import kernel_folder
    from transport.engine.driver import compile_program, run_batch

    program = treatment.program
    begun = time.process_time()
    compiled = compile_program(program, compiling)
    ready = time.process_time()
    run_batch(compiled, 1, 0, 1)
    done = time.process_time()
    on_disk = sum(getattr(lane_pass.compiled, "cache_hits", 0) > 0 for lane_pass in program.passes)
    size = sum(path.stat().st_size for path in kernel_folder().rglob("*") if path.is_file())
    return CompileTime(len(program.passes), on_disk, ready - begun, done - ready, size)


# ---- Time of a whole run.

MAX_HISTORIES = 1 << 22  # largest number of histories of a timed batch


class TimedRun:
    """A compiled treatment, with a number of histories whose batch takes about `seconds` of CPU time.

    Raises OverrunError if the treatment cannot run.
    """

    def __init__(self, treatment: Treatment, seconds: float, compiling: Callable | None = None) -> None:
        from transport.engine.driver import compile_program

        self.program = treatment.program
        self._compiled = compile_program(self.program, compiling)
        self.histories, self.events = 1 << 10, 0.0
        self.ns(0)  # load everything before timing
        while self.histories < MAX_HISTORIES:
            # A run may be slow by chance: by the first use of memory, for instance.
            spent = 1e-9 * min(self.ns(0), self.ns(0)) * self.histories
            if spent >= 0.7 * seconds:
                break
            wanted = self.histories * seconds / max(spent, 1e-6)
            self.histories = min(MAX_HISTORIES, max(2 * self.histories, 1 << round(math.log2(wanted))))

    def ns(self, batch: int) -> float:
        """Run one batch on one thread and return its CPU time per history [ns].

        `events` is then the number of crossings and collisions per history.
        """
        from transport.engine.driver import run_batch

        begun = time.process_time()
        sums = run_batch(self._compiled, 1, batch, self.histories)
        spent = time.process_time() - begun
        self.events = (sums.crossings + sums.collisions) / self.histories
        return 1e9 * spent / self.histories


def run_ns(scene: Scene | Treatment, seconds: float = 0.1, turns: int = 5) -> float:
    """Return the CPU time of a whole run per history [ns], the median of several batches."""
    run = TimedRun(treatment_of(scene), seconds)
    return statistics.median(run.ns(batch + 1) for batch in range(turns))


# ---- Cost of each pass, measured on bundles recorded in real steps.

# steps before lanes are counted, steps in all, states kept per pass
WARM_UP, STEPS, STATES_PER_PASS = 32, 400, 8
# time of one timing of a pass [s], and number of timings; short timings avoid disturbances
TIMING_SECONDS, TIMINGS = 1e-3, 15


@dataclass(frozen=True)
class PassCost:
    """Cost of a pass: ns per lane and call (nan if no lane reached it), and lanes per history."""

    ns_per_lane: float
    lanes: float

    @property
    def ns(self) -> float:
        """Cost per history [ns]; 0 if no lane reached the pass."""
        return 0.0 if math.isnan(self.ns_per_lane) else self.ns_per_lane * self.lanes


def pass_costs(scene: Scene | Treatment, compiling: Callable | None = None) -> dict[str, PassCost]:
    """Measure the cost of each pass of the scene's births and steps, by name.

    Each pass is timed on states of a bundle recorded before that pass.  The fields that it changes are
    restored before every repetition, and the time to restore is subtracted.  With few lanes the overhead of
    the call dominates.  Lanes are counted over steps with full bundles, after the warm-up, when as many
    histories end as are born.  Copies of split particles and rays to detectors are not followed.
    """
    from transport.engine.bundle import LANES
    from transport.engine.driver import Sums, compile_program

    program = compile_program(treatment_of(scene).program, compiling).program
    sums = Sums(program.plan, STEPS * LANES)
    states, lanes, ready = defaultdict(lambda: deque(maxlen=STATES_PER_PASS)), Counter(), 0

    def visited(key, first, live, before, after):
        lanes[key] += max(0, live - first)
        states[key].extend([(first, live, before, after.copy())] if first < live else [])

    for step, born in enumerate(_run_steps(program, sums, visited)):
        if step == WARM_UP:
            ready = born
            lanes.clear()
    calls = defaultdict(list)
    for key, visits in states.items():
        name, entry, table = key
        cost = _time_pass(entry, table, visits) if visits else math.nan
        calls[name].append(PassCost(cost, lanes[key] / max(1, born - ready)))
    return {name: _sum_of_calls(costs) for name, costs in calls.items()}


def _sum_of_calls(costs: list[PassCost]) -> PassCost:
    """Return the cost of all calls of a pass in a step: its tables differ."""
    lanes, reached = math.fsum(c.lanes for c in costs), [c for c in costs if not math.isnan(c.ns_per_lane)]
    if not reached:
        return PassCost(math.nan, lanes)
    weights = [c.lanes for c in reached] if any(c.lanes for c in reached) else None
    return PassCost(float(np.average([c.ns_per_lane for c in reached], weights=weights)), lanes)


def _run_steps(program, sums, visited: Callable) -> Iterator[int]:
    """Run real steps of one bundle, refilled from each emitter in turn; yield the histories born so far.

    `visited` is called with (name, entry, table) of each pass, its first and live lane, and the bundle before
    and after.
    """
    from transport.analysis.replay import replay_pass
    from transport.engine.bundle import LANES, empty_bundle

    bundle, nothing = empty_bundle(), np.zeros(0, np.int64)
    sums.enter(bundle)
    words = bundle.view(np.int64)

    def visit(step, first, live):
        lane_pass, offset = step
        entry, before = lane_pass.entry, words.copy()
        left = replay_pass(
            entry, offset, bundle["address"], np.array([[first, live]]), words[None], nothing, 1
        )
        visited((lane_pass.name, entry, offset), first, live, before, words)
        return left

    emitters, flying, fresh, history = itertools.cycle(program.births), 0, 0, 0
    ready, arrival = program.setup_count, program.setup_count + program.round_count
    for _ in range(STEPS):
        waiting = int(bundle["waiting"][0])
        if flying < LANES - waiting:
            bundle["next_history"] = history - flying
            for step in next(emitters):
                visit(step, flying, LANES - waiting)
            flying, history = LANES - waiting, history + LANES - waiting - flying
        for step in program.steps[:ready]:
            visit(step, fresh, flying)
        for step in program.steps[ready:arrival]:
            flying = visit(step, 0, flying)
        bundle["flying"] = fresh = flying
        if bundle["waiting"][0] >= flying:
            for step in program.steps[arrival:]:
                visit(step, LANES, LANES + int(bundle["waiting"][0]))
            flying = int(bundle["flying"][0])
        yield history


def _time_pass(entry: int, table: int, visits: deque) -> float:
    """Time a pass on these recorded states and return ns per lane."""
    from transport.analysis.replay import replay_pass
    from transport.engine.bodies import LANE_FIELDS
    from transport.engine.bundle import HEADER, PITCH, Bundle, empty_bundle

    first, live, before, after = (np.array(column) for column in zip(*visits, strict=True))
    bundles = [empty_bundle() for _ in visits]
    before[:, HEADER.index("address")] = handles = np.array([int(bundle["address"][0]) for bundle in bundles])
    for bundle, words in zip(bundles, before, strict=True):
        bundle.view(np.int64)[:] = words
    changed, fields = (before != after).any(axis=0), [Bundle.fields[name][1] // 8 for name in LANE_FIELDS]
    rows = np.array([row for row in fields if changed[row : row + PITCH].any()], np.int64)
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

# Files of passes by effect, and single passes of files that serve several; the name of an effect that
# every scene needs ends in a full stop.
EFFECTS = {
    "births.": ("emission", "aims"),
    "flight and shapes.": (
        "intersections", "landing", "lanes", "flats", "shared_planes", "quadrics", "meshes",
    ),
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
    "next-event estimation": ("next_event", "gloss", "once_more_collided", "shadow_rays", "mis"),
    "backward histories": ("backward", "caustics"),
    "guided births": ("guides",),
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
    return costs_by_effect(pass_costs(scene), files_of_passes())


def costs_by_effect(costs: Mapping[str, PassCost], files: Mapping[str, str]) -> list[EffectCost]:
    """Sum the costs of passes by effect; `files` are the file of each pass."""
    ns, passes = defaultdict(float), defaultdict(list)
    for name, cost in costs.items():
        effect = effect_of(name, files)
        ns[effect] += cost.ns
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
