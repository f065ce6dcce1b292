"""Nothing absent is compiled, loaded or touched; a second process compiles nothing; what is priced covers the engine."""

import contextlib
import json
import os
import subprocess
import sys

import numpy as np
import pytest
from numba import config

from tests.bench.cold import library_copy
from tests.bench.prices import ADDITIONS, base_room, with_addition
from transport.analysis.effects import base_name, effects_of, footprint_of, treatment_of
from transport.compile.compiler import compile_scene
from transport.engine.bundle import empty_bundle
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program
from transport.engine.registry import LANE_FIELDS, MODULE_OF_PASS, MODULES, PASSES
from transport.validation import SceneError

CHILD = """
import json, sys
import transport as tp
meter = tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.5)
scene = tp.Scene(tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=1.0)), (), tp.Detector(meter, "meter"))
tp.simulate(scene, 1000, seed=1, threads=1, progress=False)
from transport.engine.cache import kernel_folder
from transport.engine.driver import drive
from transport.engine.registry import MODULES as FAMILIES
from transport.engine.registry import PASSES
read = [name for name, module in FAMILIES.items() if type(module).__name__ == "module"]
ready = {name: one.compiled.cache_hits for name, one in PASSES.items() if "compiled" in vars(one)}
index = sorted(path.name.partition("-")[0] for path in kernel_folder().rglob("*.nbi"))
print(json.dumps([ready, index, sum(drive.stats.cache_hits.values()), tp.__file__, read]))
"""
NEEDED = {  # by a disk that shines on another one, and what it sends past that
    "start_history", "born_on_disk", "emit_lambertian_from_plane", "reset_hit", "cover_disk", "end_escaped", "compact_lanes", "move",
    "set_sheet", "set_cosine", "find_detector", "bin_crossings", "score",
}  # fmt: skip
LENDERS = {"bank", "flats"}  # whose files the driver and births take numbers and functions from
ROOM = {  # a room of rectangles, diffuse walls, a lamp and a meter
    "start_history", "born_on_rectangle", "emit_lambertian_from_plane", "reset_events", "save_birth_weight", "reset_hit",
    "meet_rectangle", "end_escaped", "compact_lanes", "move", "set_sheet", "set_cosine", "clamp_inside_edge",
    "find_detector", "bin_arrivals", "score", "look_up_surface", "absorb", "account_absorbed", "draw_uniforms",
    "reflect_diffusely", "bin_departures", "play_roulette", "kill_endless",
}  # fmt: skip


def family_of(name):
    return MODULE_OF_PASS[base_name(name)]


@pytest.fixture(scope="module")
def processes():
    """What two processes compiled and loaded, one after another, of a library without machine code."""
    with library_copy() as folder:
        environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONSAFEPATH": "1"}
        environment.pop("NUMBA_DISABLE_JIT", None)
        found = []
        for _ in range(2):
            done = subprocess.run(
                [sys.executable, "-c", CHILD], env=environment, capture_output=True, text=True, check=False
            )
            assert done.returncode == 0, done.stderr
            found.append(json.loads(done.stdout))
            assert found[-1][3].startswith(str(folder)), "another library was tested"
    return found


@pytest.mark.skipif(config.DISABLE_JIT, reason="looks at what is compiled")
def test_a_process_compiles_and_keeps_just_what_its_scene_calls_for(processes):
    (ready, index, driver_hits, _, _), _ = processes
    assert set(ready) == NEEDED
    assert not any(ready.values()) and driver_hits == 0  # all of it new
    assert set(index) == {f"{family_of(name)}.{name}" for name in NEEDED} | {"driver._drive"}


@pytest.mark.skipif(config.DISABLE_JIT, reason="looks at what is compiled")
def test_a_second_process_loads_all_of_it_and_compiles_nothing(processes):
    (_, before, _, _, _), (ready, index, driver_hits, _, _) = processes
    assert set(ready) == NEEDED and all(ready.values()) and driver_hits == 1
    assert index == before


def test_source_of_passes_that_a_scene_does_not_call_for_is_not_even_read(processes):
    for *_, read in processes:
        assert set(read) == {family_of(name) for name in NEEDED} | LENDERS


def test_the_program_of_a_plain_room_names_no_other_effect():
    told = effects_of(base_room())
    assert set(told.passes) == ROOM
    assert set(told.absent) >= set(PASSES) - ROOM


@pytest.mark.parametrize("name", [None, "... a Maxwellian gas", "... of 8 x 8 x 8 voxels"])
def test_no_memory_of_an_absent_field_is_touched(name):
    """Fields that the passes do not name are as empty after a batch as before; those that they name are not."""
    treatment, bundle = with_addition(name, base_room()), empty_bundle()
    run_batch(compile_program(build_program(treatment.plan)), 1, 0, 2000, bundle)
    touched = {field for field in LANE_FIELDS if bundle[field].view(np.int64).any()}
    told = set(effects_of(treatment).fields)
    assert touched <= told
    assert len(touched) > 0.8 * len(told)  # but for what stays 0


def test_every_effect_of_the_price_list_has_passes_or_tables_of_its_own():
    """None is priced that the scene has already; what does not go with the room says so."""
    refused = []
    for addition in ADDITIONS.values():
        try:
            after, before = (with_addition(name, base_room()) for name in (addition.name, addition.over))
        except SceneError:
            refused.append(addition.name)
        else:
            assert after != before, addition.name
    assert refused == ["estimator aimed"]  # there are diffuse walls


def test_the_price_list_calls_for_every_file_of_passes():
    """What is built later adds its line: a new file of passes that nothing here calls for is not priced."""
    called = {family_of(name) for name in effects_of(base_room()).passes}
    for name in ADDITIONS:
        with contextlib.suppress(SceneError):
            called |= {family_of(one) for one in effects_of(with_addition(name, base_room())).passes}
    assert set(MODULES) == called


def test_bytes_of_a_lane_are_those_of_the_fields_that_passes_name():
    program = build_program(base_room().plan)
    footprint = footprint_of(program)
    named = {field for each, _ in program.steps for field in each.fields}
    assert footprint.touched == 8 * len(named | set(program.carried))
    assert footprint.carried == 8 * len(program.carried)
    assert footprint.touched < footprint.known / 4
    assert footprint.used < footprint.bundle


def test_effects_are_those_of_the_way_in_which_an_experiment_runs():
    """A camera is seen by histories that run backwards: its program is not that of analog ones."""
    scene = with_addition("... a camera of 16 x 16 pixels", base_room()).scene
    assert {"direction_through_pixel", "assign_cells"} <= set(effects_of(scene).passes)
    expected = effects_of(treatment_of(base_room().scene, estimator="expected"))
    assert "contribute_from_walls" in expected.passes
    assert "contribute_from_walls" in effects_of(base_room().scene).absent


def test_a_plan_is_read_only_once_it_is_assembled():
    plan = compile_scene(base_room().scene)
    with pytest.raises(AttributeError, match="read-only"):
        plan.half = 7
    with pytest.raises(ValueError, match="read-only"):
        plan.sheets["cx"] = 1.0
    with pytest.raises((AttributeError, TypeError)):
        plan.rows_of["meter"] = None
