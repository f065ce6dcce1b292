"""Only the effects that a scene calls for: each object adds its own passes and no others, and nothing absent is
compiled, loaded or touched; a second process compiles nothing; the list of prices covers the engine."""

import contextlib
import json
from pathlib import Path

import numpy as np
import pytest
from numba import config

import transport as tp
from tests.bench.cold import library_copy
from tests.bench.prices import ADDITIONS, base_room, with_addition
from tests.processes import python
from transport.analysis.effects import base_name, effects_of, footprint_of, treatment_of
from transport.compile.compiler import compile_scene
from transport.compile.methods import Method
from transport.engine.bodies import LANE_FIELDS, Pass
from transport.engine.bundle import empty_bundle
from transport.engine.driver import compile_program, run_batch
from transport.engine.passes import (
    bank,
    collisions,
    next_event,
    once_more_collided,
    regions,
    shadow_rays,
    variance_reduction,
    volume_cells,
    volumes,
    voxels,
)
from transport.engine.program import build_program
from transport.engine.registry import MODULE_OF_PASS, MODULES, PASSES


def of(*modules) -> set[str]:
    """Names of all passes of these files."""
    return {each.name for module in modules for each in vars(module).values() if isinstance(each, Pass)}


def added_by(more, less) -> tuple[set[str], set[str]]:
    """The names that `more` has and `less` lacks, and the reverse."""
    return set(more) - set(less), set(less) - set(more)


# Shapes and materials, in a room of diffuse walls


def plain_room(*surfaces):
    walls = [tp.Surface(face, tp.Diffuse(0.5), name) for name, face in tp.Box(size=4.0).faces().items()]
    return tp.Scene(tp.Source("+z", tp.Lambertian(power=1.0), side="back"), [*walls, *surfaces])


PLAIN = effects_of(plain_room())
SHAPES = {
    tp.Disk(radius=0.5): {"meet_disk"},
    tp.Triangle(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 0.5))): {"meet_triangle"},
    tp.Plane(center=(0, 0, -3)): {"meet_plane"},
    tp.Rectangle(width=1, height=1, hole=tp.Disk(radius=0.2)): {"meet_holed"},
    tp.Sphere(radius=0.5): {"meet_sphere", "project_onto_sphere"},
    tp.Sphere(radius=0.5, mu_min=0): {"meet_quadric", "project_onto_sphere"},
    tp.Cylinder(radius=0.5, height=1): {"meet_quadric", "project_onto_quadric"},
    tp.Cone(radius=0.5, height=1): {"meet_quadric", "project_onto_quadric"},
    tp.Paraboloid(focal_length=0.5, radius=1): {"meet_quadric", "project_onto_quadric"},
    tp.Mesh.box(size=0.5): {"meet_mesh", "land_on_facet"},
}
MATERIALS = {
    tp.Mirror(): {"reflect_specularly"},
    tp.Diffuse(0.3, 0.3): {"look_up_optics", "sample_transmission", "transmit"},
    tp.Mirror(0.3, 0.3): {"look_up_optics", "sample_transmission", "transmit", "reflect_specularly"},
    tp.Conductor(0.2, 3.4): {"look_up_metal", "reflect_by_metal", "reflect_specularly"},
    tp.Dielectric(1.5): {"look_up_optics", "refract", "set_birth_index"},
    tp.Glossy(0.2): {"look_up_optics", "reflect_glossily", "scatter_into_lobe", "draw_second_block"},
    tp.ThinLens(0.5): {"deflect_by_lens"},
    tp.TwoSided(tp.Diffuse(0.4), tp.Black()): {"choose_material"},
    tp.Mixture({tp.Mirror(): 0.5, tp.Black(): 0.5}): {
        "choose_material", "draw_second_block", "reflect_specularly",
    },
}  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_a_shape_adds_its_own_passes_and_no_others(shape):
    added, _ = added_by(effects_of(plain_room(tp.Surface(shape, tp.Diffuse(0.5)))).passes, PLAIN.passes)
    assert added == SHAPES[shape]


@pytest.mark.slow
@pytest.mark.parametrize("material", MATERIALS, ids=lambda material: str(material)[:30])
def test_a_material_adds_its_own_passes_and_no_others(material):
    with_disk, with_both = (
        effects_of(plain_room(tp.Surface(tp.Disk(radius=0.5), each))).passes
        for each in (tp.Diffuse(0.4), material)
    )
    assert added_by(with_both, with_disk)[0] == MATERIALS[material]


def test_gloss_casts_rays_only_where_an_estimator_has_any():
    """And only gloss wide enough for them."""
    gloss = {"save_arrival", "look_up_lobe", "set_glossy_pdf", "share_glossy_pdf", "record_glossy_pdf"}
    for material, estimator, expected in (
        (tp.Glossy(0.2), "analog", set()),
        (tp.Glossy(0.2), "expected", gloss),
        (tp.Glossy(5e-4), "expected", set()),
        (tp.Diffuse(0.5), "expected", set()),
    ):
        ball = tp.Surface(tp.Sphere(center=(0, 0, 1), radius=0.2), material)
        lamp = tp.Source(tp.Disk(radius=0.1), tp.Lambertian(power=1.0))
        scene = tp.Scene(lamp, ball, tp.Detector(tp.Disk(center=(0, 1, 0), radius=0.1), "m"))
        passes = {each.name for each in build_program(compile_scene(scene, method=Method(estimator))).passes}
        assert passes & gloss == expected


def test_a_room_of_rectangles_carries_nothing_of_glass_and_meshes():
    of_glass = set(effects_of(plain_room(tp.Surface(tp.Disk(radius=0.5), tp.Dielectric(1.5)))).fields)
    of_mesh = set(effects_of(plain_room(tp.Surface(tp.Mesh.box(size=0.5), tp.Diffuse(0.5)))).fields)
    glass = {"index", "ratio", "excess", "index_before", "index_behind"}
    mesh = {"own_facet", "facet", "passed_facet"}
    assert glass <= of_glass and mesh <= of_mesh and not (glass | mesh) & set(PLAIN.fields)
    assert {"meet_sphere", "meet_quadric", "meet_mesh", "refract", "deflect_by_lens"} <= set(PLAIN.absent)


# Media: a room of diffuse walls with a box in it; what is in the box, how it is tracked and which detectors look

LAMP = tp.Source(tp.Point(position=(0.1, 0.2, 0.3)), tp.Isotropic(power=1.0))
WALLS = tp.Surface(tp.Box(size=4.0), tp.Diffuse(0.5), "walls")
BOX, BALL, ROD = tp.Box(size=1.0), tp.Sphere(radius=0.4), tp.Cylinder(radius=0.4, height=1.0)
SMOKE, WHITE, FOG = tp.Medium(absorption=1.0), tp.Medium(scattering=1.0), tp.Medium(0.1, 1.0)
VOXELS = 1.0 + np.arange(8.0).reshape(2, 2, 2)
CLOUD = tp.Grid(box=BOX, absorption=0.1 * VOXELS, scattering=VOXELS)
SOOT = tp.Grid(box=BOX, absorption=VOXELS)
TABLE = tp.Tabulated(mu=(-1, 0, 1), density=(1.0, 2.0, 3.0))
ANALOG, FORCED = tp.Tracking(absorption="analog"), tp.Tracking(forced=True)
SPLIT = tp.Tracking(splitting=tp.Splitting(start=(0, 0, -1), end=(0, 0, 1), gain=10.0))


def room(filling=None, looks=()):
    box = [] if filling is None else [tp.Surface(BOX, tp.Transparent(), "box", inside=filling)]
    return tp.Scene(LAMP, [WALLS, *box], [tp.Detector("walls", side="inside"), *looks])


def passes(filling=None, tracking=None, looks=()) -> set[str]:
    return {each.name for each in build_program(compile_scene(room(filling, looks), tracking)).passes}


ROULETTE = {"play_roulette", "play_roulette_in_flight"}  # at walls as well
OF_MEDIA = of(regions, collisions, voxels, bank, variance_reduction) - ROULETTE
OF_DETECTORS = of(volumes, volume_cells, next_event, shadow_rays, once_more_collided)
BORDERS = {
    "bound_rectangle", "set_birth_bodies", "cross_boundary", "set_outer_medium", "find_medium", "save_ray",
    "restore_ray", "resolve_box_edges", "mark_box_exit", "end_lost_particles",
}  # fmt: skip
FLIGHTS = {
    "draw_flight",
    "sample_free_path",
    "collide",
    "queue_arrivals",
    "resume_flights",
    "escape_to_empty_space",
}
WALKS = {"delta_track_in_grid", "reset_cuts", "sample_path_in_grids", "revoke_cut_collisions"}
EMPTY = (None, None)
WITHOUT_MEDIA = {"reset_hit", "score_all"}
CHANGES = {  # (filling, tracking) after and before: the passes that are added, and those that are dropped
    "absorption draws no path and no direction": (
        (SMOKE, None), EMPTY, BORDERS | {"score_and_size", "attenuate", "account_absorbed_in", "fly_uncollided"},
        WITHOUT_MEDIA,
    ),
    "absorption in voxels": (
        (SOOT, None), (SMOKE, None), {"attenuate_in_grid"}, {"attenuate", "account_absorbed_in"},
    ),
    "absorption by chance draws paths but no direction": (
        (SMOKE, ANALOG), EMPTY, BORDERS | FLIGHTS | {"score", "absorb_at_collisions", "account_absorbed_in"},
        WITHOUT_MEDIA | {"compact_lanes"},
    ),
    "absorption by chance in voxels": ((SOOT, ANALOG), (SMOKE, ANALOG), WALKS, {"sample_free_path"}),
    "scattering absorbs nothing and plays no roulette in flight": (
        (WHITE, None), EMPTY, BORDERS | FLIGHTS | {"score", "scatter_isotropic"},
        WITHOUT_MEDIA | {"compact_lanes"},
    ),
    "scattering has no absorption to treat": ((WHITE, ANALOG), (WHITE, None), set(), set()),
    "scattering with absorption by weight": (
        (FOG, None), (WHITE, None),
        {"attenuate", "account_absorbed_in", "play_roulette_in_flight", "score_and_size"}, {"score"},
    ),
    "scattering with absorption by chance": (
        (FOG, ANALOG), (WHITE, None), {"absorb_at_collisions", "account_absorbed_in"}, set(),
    ),
    "voxels": (
        (CLOUD, None), (FOG, None), WALKS | {"absorb_by_albedo"}, {"attenuate", "sample_free_path"},
    ),
    "voxels with absorption by chance": ((CLOUD, ANALOG), (FOG, ANALOG), WALKS, {"sample_free_path"}),
    "forced collisions": (
        (FOG, FORCED), (FOG, None),
        {"mark_uncollided", "sample_free_or_forced_path", "force_collision", "bank_forced_copies", "take_copies"},
        {"sample_free_path"},
    ),
    "splitting": (
        (FOG, SPLIT), (FOG, None),
        {"set_reference_weight", "cut_flight", "revoke_station_collisions", "split_or_roulette", "bank_copies",
         "play_roulette_by_importance", "take_copies"},
        {"play_roulette", "play_roulette_in_flight"},
    ),
}  # fmt: skip


@pytest.mark.quick_cases("absorption draws no path and no direction", "absorption in voxels")
@pytest.mark.parametrize("change", CHANGES)
def test_a_medium_and_its_tracking_add_their_own_passes(change):
    after, before, added, dropped = CHANGES[change]
    assert added_by(passes(*after), passes(*before)) == (added, dropped)


def test_without_media_no_pass_and_no_field_of_media_is_named():
    assert not passes() & (OF_MEDIA | OF_DETECTORS | BORDERS | {"queue_arrivals"})
    assert passes(tp.Vacuum()) == passes()
    plain, foggy = effects_of(room()), effects_of(room(FOG))
    of_media = {"inside", "medium", "mfp", "sigma_a", "survival", "leaves", "collides"}
    assert of_media <= set(foggy.fields)
    assert of_media <= set(plain.absent) and not of_media & set(plain.fields)
    assert {name for name, kind in plain.absent.items() if kind == "pass"} >= OF_MEDIA | OF_DETECTORS


def test_absorption_alone_has_no_queue_and_only_some_trackings_have_copies():
    assert "queue_arrivals" in passes(FOG) and "queue_arrivals" not in passes(SMOKE)
    copies = of(bank, variance_reduction) - ROULETTE
    assert not any(passes(filling) & copies for filling in (None, SMOKE, WHITE, FOG, CLOUD))


@pytest.mark.quick_cases("Isotropic-set", "Rayleigh-set")
@pytest.mark.parametrize(
    ("phase", "scatters"),
    [
        (tp.Isotropic(), {"scatter_isotropic"}),
        (tp.HenyeyGreenstein(0.0), {"scatter_isotropic"}),
        (tp.HenyeyGreenstein(0.5), {"scatter_henyey_greenstein"}),
        (tp.Rayleigh(), {"scatter_rayleigh"}),
        (TABLE, {"choose_segment_of_table", "scatter_tabulated"}),
        (
            tp.Mixture({tp.HenyeyGreenstein(0.5): 0.5, tp.Rayleigh(): 0.5}),
            {"choose_phase", "scatter_henyey_greenstein", "scatter_rayleigh"},
        ),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_phase_function_adds_its_own_sampler(phase, scatters):
    found = passes(tp.Medium(0.1, 1.0, phase=phase))
    assert found - scatters == passes(FOG) - {"scatter_isotropic"} and scatters <= found


VOLUMES = {  # detector: the pass that clips a flight to it, and whether it has cells
    tp.VolumeDetector(BOX, "it"): ({"clip_to_box"}, False),
    tp.VolumeDetector(BALL, "it"): ({"clip_to_ball"}, False),
    tp.VolumeDetector(ROD, "it"): ({"clip_to_cylinder"}, False),
    tp.VolumeDetector(ROD, "it", (2, 3)): ({"clip_to_cylinder"}, True),
    tp.VolumeDetector(BOX, "it", (2, 2, 2)): ({"clip_to_box"}, True),
    tp.VolumeDetector(BALL, "it", 3, tp.Directions.sphere(2, 2)): ({"clip_to_ball", "find_equal_bins"}, True),
}


@pytest.mark.slow
@pytest.mark.parametrize("detector", VOLUMES)
@pytest.mark.parametrize("filling", [None, SMOKE, FOG, CLOUD], ids=["vacuum", "smoke", "fog", "cloud"])
def test_a_volume_detector_adds_its_own_walk(filling, detector):
    assert not passes(filling) & OF_DETECTORS
    clips, has_cells = VOLUMES[detector]
    in_media = "" if filling is None else "_in_media"
    scores = {"walk_through_cells"} if has_cells else {f"score_path{in_media}"}
    scores |= {"walk_through_grid"} if filling is CLOUD else set()
    added = passes(filling, None, [detector]) - passes(filling)
    assert added == clips | scores | {f"set_flight_end{in_media}"}


def test_a_volume_detector_of_collisions_follows_no_paths():
    detector = tp.VolumeDetector(BOX, "it", estimator="collision")
    counts = {"set_collision_paths", "score_collisions_in_box"}
    assert passes(FOG, None, [detector]) - passes(FOG) == counts
    assert passes(CLOUD, None, [detector]) - passes(CLOUD) == counts | {"set_collision_paths_in_grid"}


RAYS = {
    "load_shadow_rays", "reset_shadow_hit", "score_at_points", "end_rays_at_points", "list_shadow_rays", "connect_to_point",
    "contribute_from_births", "contribute_from_walls", "end_next_event_rays",
}  # fmt: skip
FLOWN = {"find_phase_of_flights", "connect_to_flight", "contribute_from_scattering", "add_isotropic_pdf"}
DETOURS = {
    "find_phase_at_collisions", "connect_by_detour", "contribute_from_scattering",
    "reset_phase_number", "turn_into_second_leg", "start_second_leg", "add_isotropic_pdf",
}  # fmt: skip
DIM, DIM_IN_GRID = {"attenuate_shadow_rays"}, {"attenuate_shadow_rays_in_grid"}


@pytest.mark.quick_cases("vacuum", "smoke")
@pytest.mark.parametrize(
    ("filling", "all_rays", "outside", "inside"),
    [
        (None, RAYS, set(), set()),
        (SMOKE, RAYS | DIM, set(), set()),
        (FOG, RAYS | DIM, FLOWN, DETOURS),
        (SOOT, RAYS | DIM_IN_GRID, set(), set()),
        (CLOUD, RAYS | DIM_IN_GRID | {"scale_by_grid_scattering"}, FLOWN, DETOURS),
    ],
    ids=["vacuum", "smoke", "fog", "soot", "cloud"],
)
def test_a_point_detector_adds_shadow_rays_of_the_kinds_that_it_needs(filling, all_rays, outside, inside):
    """Inside fog two-leg rays, outside rays from flights that are scattered; neither where nothing scatters."""
    for place, added in (((1.3, 0.1, 0.2), outside), ((0.3, 0.1, 0.2), inside)):
        found = added_by(passes(filling, None, [tp.PointDetector(place, "it")]), passes(filling))
        assert found == (all_rays | added, set())


# Machine code: what processes compile and load

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
    "start_history", "born_on_disk", "emit_lambertian_from_plane", "reset_hit", "cover_disk", "end_not_finite", "end_escaped", "compact_lanes", "move",
    "set_sheet", "set_cosine", "find_detector", "bin_crossings", "score",
}  # fmt: skip
LENDERS = {"bank", "flats"}  # whose files the driver and births take numbers and functions from
ROOM = {  # a room of rectangles, diffuse walls, a lamp and a meter
    "start_history", "born_on_rectangle", "emit_lambertian_from_plane", "reset_events", "save_birth_weight", "reset_hit",
    "meet_rectangle_x", "meet_rectangle_y", "meet_rectangle_z", "end_not_finite", "end_escaped", "compact_lanes", "move", "set_sheet", "set_cosine", "clamp_inside_edge",
    "find_detector", "bin_arrivals", "score", "look_up_surface", "absorb", "account_absorbed", "draw_uniforms",
    "reflect_diffusely", "bin_departures", "play_roulette", "kill_endless",
}  # fmt: skip


def family_of(name):
    return MODULE_OF_PASS[base_name(name)]


def child_in(folder):
    """What a process that runs CHILD with the library of a folder compiled, loaded and read."""
    environment = {"PYTHONPATH": str(folder), "PYTHONSAFEPATH": "1", "NUMBA_DISABLE_JIT": "0"}
    found = json.loads(python("-c", CHILD, **environment).stdout)
    assert found[3].startswith(str(folder)), "another library was tested"
    return found


@pytest.fixture(scope="module")
def processes():
    """What two processes compiled and loaded, one after another, of a library without machine code."""
    with library_copy() as folder:
        return [child_in(folder) for _ in range(2)]


@pytest.mark.slow
@pytest.mark.skipif(config.DISABLE_JIT, reason="looks at what is compiled")
def test_a_process_compiles_and_keeps_just_what_its_scene_calls_for(processes):
    (ready, index, driver_hits, _, _), _ = processes
    assert set(ready) == NEEDED
    assert not any(ready.values()) and driver_hits == 0  # all of it new
    assert set(index) == {f"{family_of(name)}.{name}" for name in NEEDED} | {"driver._drive"}


@pytest.mark.slow
@pytest.mark.skipif(config.DISABLE_JIT, reason="looks at what is compiled")
def test_a_second_process_loads_all_of_it_and_compiles_nothing(processes):
    (_, before, _, _, _), (ready, index, driver_hits, _, _) = processes
    assert set(ready) == NEEDED and all(ready.values()) and driver_hits == 1
    assert index == before


def test_source_of_passes_that_a_scene_does_not_call_for_is_not_even_read():
    *_, read = child_in(Path(tp.__file__).parents[1])
    assert set(read) == {family_of(name) for name in NEEDED} | LENDERS


def test_the_program_of_a_plain_room_names_no_other_effect():
    found = effects_of(base_room())
    assert set(found.passes) == ROOM
    assert set(found.absent) >= set(PASSES) - ROOM


@pytest.mark.parametrize(
    "name",
    [None, "... a Maxwellian gas", pytest.param("... of 8 x 8 x 8 voxels", marks=pytest.mark.slow)],
)
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
        except tp.SceneError:
            refused.append(addition.name)
        else:
            assert after != before, addition.name
    assert refused == ["estimator aimed"]  # there are diffuse walls


@pytest.mark.slow
def test_the_price_list_calls_for_every_file_of_passes():
    """What is built later adds its line: a new file of passes that nothing here calls for is not priced."""
    called = {family_of(name) for name in effects_of(base_room()).passes}
    for name in ADDITIONS:
        with contextlib.suppress(tp.SceneError):
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
