"""Only the effects of media that a scene calls for: each adds its own passes and no others.

A room of diffuse walls with a box in it; what is in the box, how it is followed and who looks are added one
by one.
"""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp
from transport.analysis.effects import effects_of
from transport.compile.compiler import compile_scene
from transport.engine.passes import (
    bank,
    collisions,
    once_more_collided,
    regions,
    shadow_rays,
    variance_reduction,
    volume_cells,
    volumes,
    voxels,
)
from transport.engine.program import build_program
from transport.engine.registry import Pass

LAMP = tp.Source(tp.Point(position=(0.1, 0.2, 0.3)), tp.Isotropic(power=1.0))
WALLS = tp.Surface(tp.Box(size=4.0), tp.Diffuse(0.5), "walls")
BOX, BALL, ROD = tp.Box(size=1.0), tp.Sphere(radius=0.4), tp.Cylinder(radius=0.4, height=1.0)
SMOKE, WHITE, FOG = tp.Medium(absorption=1.0), tp.Medium(scattering=1.0), tp.Medium(0.1, 1.0)
VOXELS = 1.0 + np.arange(8.0).reshape(2, 2, 2)
CLOUD, SOOT = (
    tp.Grid(box=BOX, absorption=0.1 * VOXELS, scattering=VOXELS),
    tp.Grid(box=BOX, absorption=VOXELS),
)
TABLE = tp.Tabulated(mu=(-1, 0, 1), density=(1.0, 2.0, 3.0))
ANALOG = tp.Tracking(absorption="analog")
SPLIT = tp.Tracking(splitting=tp.Splitting(start=(0, 0, -1), end=(0, 0, 1), gain=10.0))


def room(filling=None, looks=()):
    box = [] if filling is None else [tp.Surface(BOX, tp.Transparent(), "box", inside=filling)]
    return tp.Scene(LAMP, [WALLS, *box], [tp.Detector("walls", side="inside"), *looks])


def passes(filling=None, tracking=None, looks=()) -> set[str]:
    return {each.name for each in build_program(compile_scene(room(filling, looks), tracking)).passes}


def of(*modules) -> set[str]:
    """Names of all passes of these families."""
    return {each.name for module in modules for each in vars(module).values() if isinstance(each, Pass)}


def assert_adds(more, less, added, dropped=()):
    assert (more - less, less - more) == (set(added), set(dropped))


ROULETTE = {"play_roulette", "play_roulette_in_flight"}  # at walls as well
OF_MEDIA = of(regions, collisions, voxels, bank, variance_reduction) - ROULETTE
OF_LOOKS = of(volumes, volume_cells, shadow_rays, once_more_collided)
BORDERS = {"bound_rectangle", "set_birth_bodies", "cross_boundary", "set_outer_medium", "find_medium"}
BORDERS |= {"save_ray", "restore_ray", "resolve_box_edges", "mark_box_exit", "end_lost_particles"}
FLIGHTS = {"start_flight", "sample_free_path", "collide", "compact_and_sort", "escape_to_empty_space"}
WAS_VACUUM = {"reset_hit", "score_all"}


def test_without_media_no_pass_of_media_is_named():
    """Not by vacuum that is said either; nor is any field that only media use."""
    assert not passes() & (OF_MEDIA | OF_LOOKS | BORDERS | {"compact_and_sort"})
    assert passes(tp.Vacuum()) == passes()
    plain, foggy = effects_of(room()), effects_of(room(FOG))
    of_media = {"inside", "medium", "mfp", "sigma_a", "survival", "flies", "collides"}
    assert of_media <= set(foggy.fields)
    assert of_media <= set(plain.absent) and not of_media & set(plain.fields)
    assert {name for name, kind in plain.absent.items() if kind == "pass"} >= OF_MEDIA | OF_LOOKS


def test_what_only_absorbs_draws_no_path_and_no_direction():
    """Weights fall along straight flights; no lane waits; no free path, collision, roulette or angle."""
    known = BORDERS | {"score_and_size", "attenuate", "account_absorbed_in", "fly_uncollided"}
    assert_adds(passes(SMOKE), passes(), known, WAS_VACUUM)
    assert build_program(compile_scene(room(SMOKE))).round_count == 0
    assert_adds(passes(SOOT), passes(SMOKE), {"attenuate_in_grid"}, {"attenuate", "account_absorbed_in"})


def test_absorption_by_chance_draws_paths_but_no_direction():
    known = BORDERS | FLIGHTS | {"score", "absorb_at_collisions", "account_absorbed_in"}
    assert_adds(passes(SMOKE, ANALOG), passes(), known, WAS_VACUUM)
    with_voxels = {"delta_track_in_grid", "reset_cuts", "sample_path_in_grids", "revoke_cut_collisions"}
    assert_adds(passes(SOOT, ANALOG), passes(SMOKE, ANALOG), with_voxels, {"sample_free_path"})


def test_what_only_scatters_absorbs_nothing_and_plays_no_roulette_in_flight():
    known = BORDERS | FLIGHTS | {"score", "scatter_isotropic"}
    assert_adds(passes(WHITE), passes(), known, WAS_VACUUM)
    assert passes(WHITE, ANALOG) == passes(WHITE)
    added = {"attenuate", "account_absorbed_in", "play_roulette_in_flight", "score_and_size"}
    assert_adds(passes(FOG), passes(WHITE), added, {"score"})
    assert_adds(passes(FOG, ANALOG), passes(WHITE), {"absorb_at_collisions", "account_absorbed_in"})


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
    asked = passes(tp.Medium(0.1, 1.0, phase=phase))
    assert asked - scatters == passes(FOG) - {"scatter_isotropic"}
    assert scatters <= asked


def test_grids_add_walks_through_voxels():
    walks = {"delta_track_in_grid", "reset_cuts", "sample_path_in_grids", "revoke_cut_collisions"}
    assert_adds(passes(CLOUD), passes(FOG), walks | {"absorb_by_albedo"}, {"attenuate", "sample_free_path"})
    assert_adds(passes(CLOUD, ANALOG), passes(FOG, ANALOG), walks, {"sample_free_path"})


def test_forcing_and_splitting_are_there_only_where_asked_for():
    copies = of(bank, variance_reduction) - ROULETTE
    for filling in (None, SMOKE, WHITE, FOG, CLOUD):
        assert not passes(filling) & copies
    force = {
        "mark_uncollided",
        "sample_free_or_forced_path",
        "force_collision",
        "bank_forced_copies",
        "take_copies",
    }
    assert_adds(passes(FOG, tp.Tracking(forced=True)), passes(FOG), force, {"sample_free_path"})
    split = {
        "set_reference_weight",
        "cut_flight",
        "revoke_station_collisions",
        "split_or_roulette",
        "bank_copies",
    }
    split |= {"play_roulette_by_importance", "take_copies"}
    assert_adds(passes(FOG, SPLIT), passes(FOG), split, {"play_roulette", "play_roulette_in_flight"})


VOLUMES = {  # what looks -> what clips, and what scores
    tp.VolumeDetector(BOX, "it"): ({"clip_to_box"}, False),
    tp.VolumeDetector(BALL, "it"): ({"clip_to_ball"}, False),
    tp.VolumeDetector(ROD, "it"): ({"clip_to_cylinder"}, False),
    tp.VolumeDetector(ROD, "it", (2, 3)): ({"clip_to_cylinder"}, True),
    tp.VolumeDetector(BOX, "it", (2, 2, 2)): ({"clip_to_box"}, True),
    tp.VolumeDetector(BALL, "it", 3, tp.Directions.sphere(2, 2)): ({"clip_to_ball", "find_equal_bins"}, True),
}


@pytest.mark.parametrize("look", VOLUMES)
@pytest.mark.parametrize("filling", [None, SMOKE, FOG, CLOUD], ids=["vacuum", "smoke", "fog", "cloud"])
def test_a_volume_detector_adds_its_own_walk(filling, look):
    assert not passes(filling) & OF_LOOKS
    clips, has_cells = VOLUMES[look]
    in_media = "" if filling is None else "_in_media"
    scores = {"walk_through_cells"} if has_cells else {f"score_path{in_media}"}
    scores |= {"walk_through_grid"} if filling is CLOUD else set()
    added = passes(filling, None, [look]) - passes(filling)
    assert added == clips | scores | {f"set_flight_end{in_media}"}


def test_a_volume_that_counts_collisions_follows_no_ways():
    look = tp.VolumeDetector(BOX, "it", estimator="collision")
    counts = {"set_collision_paths", "score_collisions_in_box"}
    assert passes(FOG, None, [look]) - passes(FOG) == counts
    assert passes(CLOUD, None, [look]) - passes(CLOUD) == counts | {"set_collision_paths_in_grid"}


SIGHT = {
    "load_shadow_rays",
    "reset_shadow_hit",
    "score_at_points",
    "list_shadow_rays",
    "cast_from_births",
    "cast_from_walls",
}
FLOWN = {"find_phase_of_flights", "cast_from_flights", "add_isotropic_pdf"}
DETOURS = {
    "find_phase_at_collisions",
    "first_leg_from_births",
    "first_leg_from_collisions",
    "first_leg_from_walls",
}
DETOURS |= {"turn_into_second_leg", "start_second_leg", "add_isotropic_pdf"}


@pytest.mark.parametrize(
    ("filling", "outside", "within"),
    [
        (None, SIGHT, SIGHT),
        (SMOKE, SIGHT | {"attenuate_shadow_rays"}, SIGHT | {"attenuate_shadow_rays"}),
        (FOG, SIGHT | {"attenuate_shadow_rays"} | FLOWN, SIGHT | {"attenuate_shadow_rays"} | DETOURS),
        (SOOT, SIGHT | {"attenuate_shadow_rays_in_grid"}, SIGHT | {"attenuate_shadow_rays_in_grid"}),
        (
            CLOUD,
            SIGHT | {"attenuate_shadow_rays_in_grid", "scale_by_grid_scattering"} | FLOWN,
            SIGHT | {"attenuate_shadow_rays_in_grid", "scale_by_grid_scattering"} | DETOURS,
        ),
    ],
    ids=["vacuum", "smoke", "fog", "soot", "cloud"],
)
def test_a_point_detector_adds_shadow_rays_of_the_kinds_that_it_needs(filling, outside, within):
    """From within fog detours, from without flights that are scattered; neither where nothing scatters."""
    for place, added in (((1.3, 0.1, 0.2), outside), ((0.3, 0.1, 0.2), within)):
        assert_adds(passes(filling, None, [tp.PointDetector(place, "it")]), passes(filling), added)
