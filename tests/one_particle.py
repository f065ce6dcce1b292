"""A second builder: a whole program as one function of one particle, made of the same bodies as the passes.

No bundle, no compaction, no list of shadow rays: a history runs from its birth to its end, its rays are traced where they are cast,
and its copies follow it.  Sums are of integers, so they must agree with the engine's to the last bit.

    python -m tests.one_particle [WORLDS]     compares one case of every sim in each estimator, and so many random scenes (50)
"""

from __future__ import annotations

import linecache
import sys
from types import FunctionType

import numpy as np
from numba import njit

import transport as tp
from tests.fuzz.numbered import TURNS, world_of
from transport.compile import layout
from transport.compile.compiler import compile_scene
from transport.compile.methods import coerce_method
from transport.engine.bodies import Pass, added, lanes_of, no_sums, table_at
from transport.engine.bundle import Bundle, _pointer, empty_bundle, view
from transport.engine.driver import (
    CompiledProgram,
    Sums,
    _batch_offsets,
    _deal_histories,
    _end_of_emitter,
    compile_program,
    run_batch,
)
from transport.engine.passes.lanes import flies_on
from transport.engine.program import build_program
from transport.verification.experiment import cases_of, experiment, experiment_names

WORDS = Bundle.itemsize // 8
NAMES = "ledger", "moments", "sizes"  # of the arrays of sums


# ---- one pass for one lane ----

body = before = when = other = None
sums, NONE, TABLE, FIELDS = no_sums, (), np.dtype([("unused", "f8")]), layout.ROWS


def _always(lane, offset):
    table = table_at(lane, offset, TABLE)
    before(lane, table)
    sums(lane, table, *added(NONE, body(lane, table)))


def _sometimes(lane, offset):
    table = table_at(lane, offset, TABLE)
    if when(lane, table):
        sums(lane, table, *added(NONE, body(lane, table)))


def _either(lane, offset):
    table = table_at(lane, offset, TABLE)
    if when(lane, table):
        other(lane, table)
    else:
        body(lane, table)


def _cast(lane, offset, shadow, moves):
    """In the place of listing rays: true if one is to be traced."""
    table, fields = table_at(lane, offset, TABLE), table_at(lane, moves, FIELDS)
    lane.score, lane.leg = lane.score * lane.pdf, table.leg
    if lane.score > 0.0:
        here, there = view(lane.address, WORDS, np.int64), view(shadow.address, WORDS, np.int64)
        rows = view(lane.arena + fields.rows, fields.count, layout.WORD)
        for m in range(fields.count):
            there[rows[m].target] = here[rows[m].source]
        return True
    return False


def alone(lane_pass: Pass):
    """The pass for one lane: a function of a lane and of the offset of its table."""
    template, own = _always, {"when": lane_pass.when, "other": None, "body": lane_pass.inlined}
    if lane_pass.name == "list_shadow_rays":
        template = _cast
    elif lane_pass.is_loop:
        own["body"] = lane_pass.alone
    elif lane_pass.when is not None:
        template = _sometimes
    elif lane_pass.unless is not None:
        template, own["when"], own["other"] = _either, lane_pass.unless[0], lane_pass.unless[1].inlined
    own |= {"before": lane_pass.before, "sums": lane_pass.sums, "TABLE": lane_pass.table}
    own["NONE"] = (0,) * lane_pass.amount_count
    return njit(**lane_pass.arithmetic)(FunctionType(template.__code__, globals() | own, lane_pass.name))


# ---- the program ----


def one_particle(compiled: CompiledProgram):
    """A function of (bundle, shadow bundle, emitter) that runs one history and its copies to their ends."""
    program, names, lines = compiled.program, {}, []

    def calls(steps, indent, lane="lane"):
        for lane_pass, offset in steps:
            name = lane_pass.name.replace(" ", "_")
            if name not in names:
                names[name] = alone(lane_pass)
            call, pad = f"{name}({lane}, {offset}", "    " * indent
            if lane_pass.name != "list_shadow_rays":
                lines.append(f"{pad}{call})")
                continue
            lines.append(f"{pad}if {call}, shadow, {program.shadow_steps[0][1]}):")
            lines.append(f"{pad}    trace(shadow)")

    lines += ["def trace(shadow):", "    while shadow.weight != 0.0:"]
    calls(program.shadow_steps[1:], 2, "shadow")
    lines += ["        pass", "", "def follow(lane, shadow):", "    while lane.weight != 0.0:"]
    ready, inner = program.setup_count, program.round_count
    calls(program.steps[:ready], 2)
    lines += ["        flies = True", "        while flies:"]
    calls(program.steps[ready : ready + inner], 3)
    lines += [
        "            flies = flies_on(lane)"
        if ready + inner < len(program.steps)
        else "            flies = False"
    ]
    calls(program.steps[ready + inner :], 2)
    lines += ["", "def history(bundle, others, emitter):"]
    lines += ["    lane, shadow = lanes_of(pointer(bundle)), lanes_of(pointer(others))"]
    for number, steps in enumerate(program.births):
        lines += [f"    if emitter == {number}:"]
        calls(steps, 2)
    lines += ["    follow(lane, shadow)", "    while lane.banked > 0:"]
    calls(program.bank_steps, 2)
    lines += ["        follow(lane, shadow)"]
    text, file = "\n".join(lines) + "\n", f"<one particle {id(compiled)}>"
    linecache.cache[file] = (len(text), None, text.splitlines(True), file)
    space = names | {"pointer": _pointer, "lanes_of": lanes_of, "flies_on": flies_on}
    exec(compile(text, file, "exec"), space)
    for name in ("trace", "follow", "history"):
        space[name] = njit(error_model="numpy", fastmath={"nsz"})(space[name])
    return space["history"]


def sums_of_single_particles(compiled: CompiledProgram, seed: int, batch: int, histories: int) -> dict:
    """The sums of a batch, history by history."""
    plan, history = compiled.program.plan, one_particle(compiled)
    bundle, shadows, sums = empty_bundle(), empty_bundle(), Sums(plan, histories)
    for each in (bundle, shadows):
        sums.enter(each)
        each["seed_low"], each["seed_high"], each["batch"] = seed & 0xFFFFFFFF, seed >> 32, batch
        each["bank_capacity"] = 1 << 16
    offset, phase = _offsets(seed & 0xFFFFFFFF, seed >> 32, batch)
    bundle["record_phase"] = int(phase * int(bundle["stride"][0]))
    dealt, worths = _deal_histories(compiled, histories)
    shares, first = compiled.birth_table[3], 0
    last = len(compiled.program.births) - 1
    for emitter in range(last + 1):
        end = dealt[emitter] if len(dealt) else _end(histories, shares[emitter], offset, emitter == last)
        bundle["birth_factor"] = np.float64(worths[emitter]).view(np.int64)
        for number in range(first, int(end)):
            bundle["next_history"] = number
            history(int(bundle["address"][0]), int(shadows["address"][0]), emitter)
        first = int(end)
    found = {name: getattr(sums, name) for name in NAMES} | {"tallies": sums.detectors}
    found["counts"] = np.array([int(bundle[name][0]) for name in ("crossings", "collisions")])
    return found


@njit
def _end(histories, share, offset, is_last):
    return _end_of_emitter(histories, share, offset, is_last)


@njit
def _offsets(seed_low, seed_high, batch):
    return _batch_offsets(seed_low, seed_high, batch)


# ---- comparison ----


def differences(compiled: CompiledProgram, seed: int = 3, histories: int = 300) -> dict[str, int]:
    """How many sums of a batch differ between the two forms, by array; what takes lanes without a score is never read."""
    found = sums_of_single_particles(compiled, seed, 0, histories)
    raw = run_batch(compiled, seed, 0, histories)
    counts = np.array([raw.crossings, raw.collisions])
    pairs = {
        "tallies": raw.detectors,
        "ledger": raw.ledger,
        "moments": raw.moments,
        "sizes": raw.sizes,
        "counts": counts,
    }
    differ = {}
    for name, expected in pairs.items():
        unlike = np.asarray(expected != found[name])
        if name in ("tallies", "sizes") and len(unlike):
            unlike[0] = False
        if unlike.any():
            differ[name] = int(unlike.sum())
    return differ


def program_of(
    scene: tp.Scene, estimator: str, tracking: tp.Tracking | None = None, sampling: str = "random"
) -> CompiledProgram:
    """The compiled program of a scene."""
    method = coerce_method(scene, estimator, sampling)
    return compile_program(build_program(compile_scene(scene, tracking, method)))


def program_of_sim(name: str, estimator: str = "analog", sampling: str = "random") -> CompiledProgram:
    """The compiled program of the first case of a sim."""
    module = experiment(name)
    return program_of(module.scene(**cases_of(module, {})[0]), estimator, sampling=sampling)


def program_of_world(number: int, estimator: str = "analog") -> CompiledProgram | None:
    """The compiled program of a random scene; None where it is refused."""
    world = world_of(number, 1, TURNS[number % len(TURNS)])
    try:
        scene = world.scene()
        tracking = world.options.get("tracking")
        return program_of(scene, estimator, tracking if isinstance(tracking, tp.Tracking) else None)
    except tp.SceneError:
        return None


def main(worlds: int = 50) -> None:
    """Compare both forms for one case of every sim in each estimator, and for random scenes."""
    cases = {f"sim {name}": lambda e, n=name: program_of_sim(n, e) for name in experiment_names()}
    cases |= {f"world {number}": lambda e, n=number: program_of_world(n, e) for number in range(worlds)}
    compared = 0
    for title, make in cases.items():
        for estimator in ("analog", "expected", "backward") if title.startswith("sim") else ("analog",):
            try:
                compiled = make(estimator)
            except tp.SceneError:
                continue
            if compiled is not None:
                compared += 1
                print(f"{title}, {estimator}: {differences(compiled) or 'equal'}", flush=True)
    print(f"{compared} programs compared")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
