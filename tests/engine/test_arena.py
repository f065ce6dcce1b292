"""Tables of a program refer to arrays by offsets in one buffer, so plans and programs can be pickled and sent to another process."""

from __future__ import annotations

import hashlib
import pickle
import weakref
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from tests import media_scenes
from tests.plain_scenes import METHODS, SCENES
from tests.processes import elsewhere
from tests.slow import quick
from transport.compile.arena import LINE, Arena
from transport.compile.compiler import compile_scene
from transport.compile.methods import ANALOG, Method
from transport.engine.driver import CompiledProgram, compile_program, run_batch
from transport.engine.program import Program, build_program

pytestmark = pytest.mark.filterwarnings("ignore:.* encountered in scalar:RuntimeWarning")  # in plain Python

# Quantiles of speeds; meshes; voxels, a phase table and point detectors; a polygon; a microfacet lobe.
FEW = "vessel", "meshed", "seen", "expected plate", "optics"


def plan_of(name: str):
    how = media_scenes.TRACKINGS.get(name), METHODS.get(name, ANALOG)
    return compile_scene.__wrapped__(SCENES[name](), *how)


def digest_of(program: Program | CompiledProgram) -> str:
    """Digest of all that a batch of the program counts."""
    compiled = program if isinstance(program, CompiledProgram) else compile_program(program)
    digest = hashlib.sha256()
    raw = run_batch(compiled, seed=12345678901, batch=1, histories=200)
    for array in (raw.detectors[1:], raw.ledger, raw.moments, raw.sizes, raw.records):
        digest.update(array.tobytes())
    return f"{digest.hexdigest()} {raw.crossings} {raw.collisions}"


def digests_in(folder: str) -> dict[str, str]:
    """Digests of the pickled programs in a folder, by file."""
    return {file.name: digest_of(pickle.loads(file.read_bytes())) for file in Path(folder).iterdir()}


# ---- the buffer ----


def test_arrays_have_places_of_their_own_that_they_keep():
    arena, arrays = Arena(), [np.arange(3.0), np.zeros(0), np.full((2, 3), 7, np.int32), np.ones((), "f8,i8")]
    offsets = [arena.place(array) for array in arrays]
    assert offsets == sorted(set(offsets)) and offsets[0] > 0 and not any(each % LINE for each in offsets)
    memory = arena.memory
    assert memory.ctypes.data % LINE == 0
    later = np.arange(5)
    assert arena.place(later) == len(memory) and [arena.place(array) for array in arrays] == offsets
    for array, offset in zip([*arrays, later], [*offsets, len(memory)], strict=True):
        assert arena.memory[offset:][: array.nbytes].tobytes() == array.tobytes()
    again = pickle.loads(pickle.dumps(arena))
    assert again.memory.tobytes() == arena.memory.tobytes() and again.memory.ctypes.data % LINE == 0
    assert again.place(np.zeros(1)) == len(again.memory) - LINE


def test_an_array_that_is_no_more_leaves_its_place_to_none():
    """A later array may get its identity, but not its place; what has been copied is released."""
    arena, offsets = Arena(), set()
    for number in range(100):
        array = np.full(4, number)
        offsets.add(arena.place(array))
        assert len(arena.memory) == LINE * (len(offsets) + 1)
        released = weakref.ref(array)
        del array
        assert released() is None
    assert len(offsets) == 100
    assert arena.memory.view(np.int64)[LINE // 8 :: LINE // 8].tolist() == list(range(100))


def test_an_array_with_gaps_is_refused():
    with pytest.raises(ValueError, match="contiguous"):
        Arena().place(np.arange(6)[::2])


# ---- programs elsewhere ----


@pytest.mark.parametrize("name", quick(SCENES, *FEW))
def test_a_pickled_plan_or_program_counts_the_same_bits(name):
    plan = plan_of(name)
    before = pickle.dumps(plan)  # no program has been built from it
    program = build_program(plan)
    expected = digest_of(program)
    assert digest_of(pickle.loads(pickle.dumps(program))) == expected
    assert digest_of(build_program(pickle.loads(before))) == expected
    assert digest_of(build_program(pickle.loads(pickle.dumps(plan)))) == expected


def test_pickled_programs_count_the_same_bits_in_another_process(tmp_path):
    programs = {name: build_program(plan_of(name)) for name in FEW}
    expected = {name: digest_of(program) for name, program in programs.items()}
    for name, program in programs.items():
        (tmp_path / name).write_bytes(pickle.dumps(program))
        (tmp_path / f"{name} compiled").write_bytes(pickle.dumps(compile_program(program)))
    found = elsewhere(f"tests.engine.test_arena.digests_in({str(tmp_path)!r})")
    assert found == expected | {f"{name} compiled": digest for name, digest in expected.items()}


def test_quasi_random_twins_are_pickled():
    scene = SCENES["room"]()
    for sampling in ("sobol", "stratified"):
        program = build_program(compile_scene(scene, None, Method("analog", sampling)))
        again = pickle.loads(pickle.dumps(program))
        assert again.passes == program.passes and digest_of(again) == digest_of(program)


def test_programs_run_at_the_same_time_and_two_programs_of_one_plan_do_not_disturb_each_other():
    plans = [plan_of(name) for name in ("vessel", "meshed")]
    compiled = [compile_program(build_program(plan)) for plan in plans]
    expected = [digest_of(each) for each in compiled]
    assert expected[0] != expected[1]
    with ThreadPoolExecutor(2) as threads:
        assert list(threads.map(digest_of, compiled * 4)) == expected * 4
    again = compile_program(build_program(plans[1]))  # the arena grows
    assert digest_of(again) == digest_of(compiled[1]) == expected[1]


def test_an_offset_wrong_by_eight_bytes_is_noticed():
    program = build_program(plan_of("furnace"))
    expected = digest_of(program)
    (first, offset), *others = program.births[0]
    program.births[0] = [(first, offset + 8), *others]
    assert digest_of(program) != expected
