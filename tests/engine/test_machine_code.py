"""Machine code of the passes: which lane loops are vectorised, why the others are not, and where the code is kept.

The speed of the engine is that of its lane loops.  Kept code lies in a folder named by a digest of all sources; where the
package is read-only, elsewhere.
"""

from __future__ import annotations

import os
import platform
import re
import time
from pathlib import Path

import llvmlite.binding as llvm
import numba
import pytest
from numba import cfunc, config

from tests.same_batches import scene
from transport.compile.compiler import compile_scene
from transport.engine import cache
from transport.engine.bodies import SIGNATURE, Pass
from transport.engine.program import build_program
from transport.engine.registry import PASSES
from transport.engine.stages.quasi_random import quasi_random_twin
from transport.physics.device import EXACT

# Passes whose loops are not vectorised, and why.
SCALAR_REASONS = {
    "gathers from tables: of sheets, surfaces, bodies, media, voxels, bins or cells of quantiles": (
        "set_sheet", "project_onto_sphere", "mark_box_exit", "project_onto_quadric", "find_detector",
        "find_detector_row", "mark_visit", "cross_boundary", "look_up_surface", "choose_material",
        "look_up_optics", "look_up_lobe", "deflect_by_lens", "look_up_metal", "refine_by_cell", "require_visits",
        "require_reflections", "place_in_cell", "direction_in_cell", "direction_in_round_image", "hemisphere_direction_in_cell",
        "clamp_inside_edge", "set_speed_by_quantile", "set_speed_by_stepped_quantile",
        "emit_from_drifting_gas", "sample_wall_speed", "land_on_facet", "scatter_into_lobe",
        "end_lost_particles_of_many", "find_medium_of_many", "choose_phase", "choose_segment_of_table",
        "limit_by_clock_in_media", "redirect_next_event_rays", "find_phase_of_flights", "find_phase_at_collisions",
        "set_collision_paths_in_grid", "scale_by_grid_scattering", "turn_into_second_leg",
        "note_first_interaction", "note_first_wall", "weigh_flights_to_lamps",
    ),
    "searches among edges, segments, parts or facets": (
        "refine_by_cosine", "refine_by_azimuth", "refine_by_place", "refine_by_time", "refine_by_speed",
        "count_phase_space", "point_on_polygon", "born_on_mesh", "score_collisions_in_ball",
        "score_collisions_in_cylinder", "add_tabulated_pdf", "draw_guided_birth", "weigh_rays_to_view",
    ),
    "scatters to rows of tallies": (
        "score_path_by_cell", "score_path_by_cell_in_media", "score_collisions_in_box", "score",
        "score_all", "score_moments", "score_paths_by_medium", "score_and_size", "score_all_and_size",
        "account_absorbed", "add_to_history",
    ),
    "works on a list of lanes, or copies lanes between bundle and bank": (
        "compact_lanes", "list_shadow_rays", "bank_copies", "bank_forced_copies", "take_copies",
        "load_shadow_rays",
    ),
    "writes down states or flights": (
        "record_snapshot", "record_tracks", "record_birth",
    ),
    "adds to the path of the lane's medium, one of several fields": (
        "follow_paths",
    ),
    "draws again where a place lies in the hole": (
        "born_beside_hole",
    ),
    "a logarithm and an exponential that keep the digits of shallow ones": (
        "born_on_paraboloid",
    ),
    "moves a few lanes": (
        "resume_flights",
    ),
    "descends a hierarchy of boxes, ray by ray": (
        "meet_mesh", "cover_mesh",
    ),
    "walks from voxel to voxel or cell to cell, ray by ray": (
        "attenuate_in_grid", "walk_through_grid", "attenuate_shadow_rays_in_grid", "walk_through_cells",
    ),
}  # fmt: skip
SCALAR_PASSES = set().union(*SCALAR_REASONS.values())
# Passes with gathers that LLVM vectorises for other processors, but by its costs not for these.
SCALAR_ON = {"znver5": {"time_arrival_in_media", "resolve_box_edges"}}
TWINS = [  # in which quasi-random numbers take the place of random ones
    ("born_on_disk", "sobol"), ("born_on_disk", "stratified"), ("sample_target_disk", "sobol"), ("draw_flight", "sobol"),
]  # fmt: skip
NOWHERE = Path("/proc/transport")  # where nobody can make a folder


# ---- what machine code shows ----


def assembly(lane_pass):
    """Machine code as text; what was loaded from the cache has none and is compiled once more."""
    compiled = lane_pass.compiled
    if compiled.cache_hits:
        compiled = cfunc(SIGNATURE, **lane_pass.arithmetic)(lane_pass.loop)
    return compiled._library.get_asm_str()


def innermost_loops(text):
    """Instructions between a jump back and its target, for loops that hold no other."""
    labels, jumps, instructions = {}, [], []
    for line in (line.split("#")[0].strip() for line in text.splitlines()):
        if line.endswith(":"):
            labels[line[:-1]] = len(instructions)
        elif line and not line.startswith("."):
            jump = re.match(r"j\w+\s+(\S+)", line)
            if jump and jump[1] in labels:
                jumps.append((labels[jump[1]], len(instructions)))
            instructions.append(line)
    inner = [a for a in jumps if not any(a != b and a[0] <= b[0] and b[1] <= a[1] for b in jumps)]
    return [instructions[first : last + 1] for first, last in inner]


def wide(loop):
    """Instructions on registers of four or eight lanes."""
    return sum("%ymm" in line or "%zmm" in line for line in loop)


def scalar(loop):
    """Arithmetic on one number at a time."""
    arithmetic = re.compile(r"v(?!mov)\w+sd\b|vcvtt?sd2\w+|vcvtsi2sd\w*")
    return sum(bool(arithmetic.match(line)) and not wide([line]) for line in loop)


def is_vectorised(text, scalar_share):
    """Whether one loop does the work in wide registers; the loop over the last lanes may be scalar.

    Without a loop the pass is a plain fill, for which LLVM calls memset.
    """
    loops = innermost_loops(text)
    if not loops:
        return True
    rest = max(map(scalar, loops), default=0)
    return any(
        wide(loop) > 0 and scalar(loop) <= scalar_share * wide(loop) and 2 * wide(loop) >= rest
        for loop in loops
    )


def has_fused(text):
    """Whether a product and a sum are rounded together anywhere."""
    return re.search(r"\bvfn?m(add|sub)", text) is not None


def host_has(feature):
    return platform.machine() in ("x86_64", "AMD64") and llvm.get_host_cpu_features().get(feature, False)


def needs(feature):
    return pytest.mark.skipif(
        config.DISABLE_JIT or not host_has(feature), reason=f"looks for instructions of CPUs with {feature}"
    )


def assert_vectorised(names):
    """One branch, table look-up or libm call in a loop over lanes makes it five times slower, and nothing else shows."""
    share = 0.05 if host_has("avx512dq") else 1.5
    judged = set(names) - SCALAR_PASSES - SCALAR_ON.get(llvm.get_host_cpu_name(), set())
    assert [name for name in sorted(judged) if not is_vectorised(assembly(PASSES[name]), share)] == []


@needs("avx2")
def test_some_lane_loops_of_a_closed_room_are_vectorised():
    """One in ten of those whose loops must be: machine code that was loaded is compiled again to be seen."""
    names = {each.name for each in build_program(compile_scene(scene())).passes} - SCALAR_PASSES
    assert len(names) > 20
    assert_vectorised(sorted(names)[::10])


@needs("avx2")
@pytest.mark.skipif(
    host_has("avx512f"), reason="with AVX-512 a store under a mask costs no more than another"
)
@pytest.mark.parametrize("name", ["collide", "meet_rectangle_x", "refract"])
def test_a_field_that_keeps_its_value_in_some_lanes_is_stored_without_a_mask(name):
    """Where that is slow; planted: bodies.MASKS_STORES set."""
    assert not re.search(r"maskmov\w+\s+%ymm\d+, %ymm\d+, ", assembly(PASSES[name]))


@pytest.mark.slow
@needs("avx2")
def test_every_lane_loop_is_vectorised():
    assert set(PASSES) >= SCALAR_PASSES
    assert_vectorised(PASSES)


@pytest.mark.slow
@needs("avx512dq")
@pytest.mark.parametrize(("name", "sampling"), TWINS)
def test_quasi_random_twins_are_vectorised(name, sampling):
    assert is_vectorised(assembly(quasi_random_twin(PASSES[name], sampling)), 0.05)


def branching(lane, table):
    """A body as it must not be: a sum in memory, and a branch that divides."""
    lane.scored += 1
    if lane.weight < 0.5:
        lane.x = lane.y / lane.scored


@needs("avx2")
def test_a_loop_that_is_not_vectorised_is_seen():
    assert not is_vectorised(assembly(Pass(branching, PASSES["move"].table)), 1.5)


def test_passes_of_meshes_alone_round_exactly():
    assert {each.name for each in PASSES.values() if each.arithmetic is EXACT} == {"meet_mesh", "cover_mesh"}


@needs("fma")
@pytest.mark.parametrize(
    ("name", "fuses"),
    [("move", True), *(pytest.param(n, False, marks=pytest.mark.slow) for n in ("meet_mesh", "cover_mesh"))],
)
def test_passes_of_meshes_fuse_no_product_with_a_sum(name, fuses):
    """Nor does what they call: the two sides of an edge would differ.  Other passes do."""
    assert has_fused(assembly(PASSES[name])) == fuses


# ---- where it is kept ----


@pytest.fixture(autouse=True)
def unremembered():
    """The folder is chosen once in a process."""
    cache.kernel_folder.cache_clear()
    yield
    cache.kernel_folder.cache_clear()


@pytest.mark.parametrize(
    ("package", "cache_home", "home"),
    [
        ("transport/__kernels__", "cache", "package"),
        ("site-packages/transport/__kernels__", "cache", "cache"),
        ("dist-packages/transport/__kernels__", "cache", "cache"),
        (NOWHERE, "cache", "cache"),
        (NOWHERE, NOWHERE, None),
        (NOWHERE, None, None),
    ],
    ids=["a clone", "site-packages", "dist-packages", "read-only package", "read-only home", "no home"],
)
def test_kernels_lie_in_the_package_the_users_cache_or_a_temporary_folder(
    package, cache_home, home, tmp_path, monkeypatch
):
    """An installed package leaves nothing in its folder: else that hides an editable installation later."""

    def no_home():
        raise RuntimeError(
            "Could not determine home directory."
        )  # of a user of a container that no list of users has

    kernels = tmp_path / package
    monkeypatch.setattr(cache, "KERNELS", kernels)
    if cache_home is None:
        monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
        monkeypatch.setattr(Path, "home", no_home)
    else:
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / cache_home))
    folder = cache.kernel_folder()
    if home == "package":
        assert folder.is_relative_to(kernels)
    else:
        assert not kernels.parent.exists() or package == NOWHERE
        assert folder.is_relative_to(tmp_path / "cache") if home else folder.is_dir()


@pytest.mark.parametrize(
    "file", ["physics/rays.py", "engine/tally.py", "engine/passes/optics.py", "compile/layout.py"]
)
def test_the_digest_follows_every_source(file, tmp_path, monkeypatch):
    """A changed device function in another file: what Numba's own check does not see."""
    for name in ("compile/layout.py", file):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("a = 1\n")
    monkeypatch.setattr(cache, "PACKAGE", tmp_path)
    before = cache.source_digest()
    assert cache.source_digest() == before
    (tmp_path / file).write_text("a = 2\n")
    assert cache.source_digest() != before


def test_code_of_other_sources_is_forgotten_after_a_week(tmp_path, monkeypatch):
    kernels = tmp_path / "__kernels__"
    monkeypatch.setattr(cache, "KERNELS", kernels)
    for name, age in (("0123456789abcdef-256", 8), ("fedcba9876543210-256", 1)):
        (kernels / name).mkdir(parents=True)
        os.utime(kernels / name, (time.time() - age * 86400,) * 2)
    folder = cache.kernel_folder()
    assert {path.name for path in kernels.iterdir()} == {folder.name, "fedcba9876543210-256"}


def test_numbas_own_setting_is_left_alone(tmp_path, monkeypatch):
    assert cache.KERNELS.parent == Path(cache.__file__).parents[1]
    monkeypatch.setattr(cache, "KERNELS", tmp_path)
    before = numba.config.CACHE_DIR
    with cache.cached_kernels():
        assert str(tmp_path) in numba.config.CACHE_DIR
    assert before == numba.config.CACHE_DIR
