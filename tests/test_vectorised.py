"""The speed of the engine is that of its lane loops: which are vectorised, and why the others are not."""

import pytest
from numba import config

from tests.vectorisation import assembly, has_fused, host_has, is_vectorised
from transport.engine.registry import PASSES, Pass
from transport.physics.device import EXACT

# Passes whose loops are not vectorised, and why.
SCALAR_PASSES = {
    "set_sheet": "gathers from the sheets",
    "project_onto_sphere": "gathers from the sheets",
    "mark_box_exit": "gathers from the sheets",
    "find_detector": "gathers from the layer's rows",
    "look_up_surface": "gathers from the surfaces",
    "find_detector_row": "gathers from the layer's rows",
    "refine_by_cosine": "searches among edges, for few lanes",
    "refine_by_azimuth": "searches among edges, for few lanes",
    "refine_by_place": "searches among edges, for few lanes",
    "refine_by_cell": "gathers from the meters, for few lanes",
    "place_in_cell": "gathers from the edges of bins",
    "direction_in_cell": "gathers from the edges of bins",
    "hemisphere_direction_in_cell": "gathers from the edges of bins",
    "score_path_by_cell": "scatters to the cells' rows",
    "score_path_by_cell_in_media": "scatters to the cells' rows",
    "clamp_inside_edge": "gathers from the walls, for few lanes",
    "score": "scatters to the meters' rows",
    "score_all": "scatters to the meters' rows",
    "score_and_size": "scatters to the meters' rows and the cells of sizes",
    "score_all_and_size": "scatters to the meters' rows and the cells of sizes",
    "account_absorbed": "scatters to the surfaces' rows",
    "compact_lanes": "works on a list of lanes",
    "set_speed_by_quantile": "gathers from the cells of the speeds",
    "set_speed_by_stepped_quantile": "gathers from the cells of the speeds",
    "emit_from_drifting_gas": "gathers from the cells of the speeds",
    "sample_wall_speed": "gathers from the surfaces and the cells of the speeds, for few lanes",
    "choose_material": "gathers from the surfaces, for few lanes",
    "count_phase_space": "searches among edges, for the lanes of an instant",
    "record_snapshot": "writes down the lanes of an instant",
    "record_tracks": "writes down the flights of a picture",
    "mark_visit": "gathers from the layer's rows",
    "require_visits": "gathers from the meters, for few lanes",
    "require_reflections": "gathers from the meters, for few lanes",
    "refine_by_time": "searches among edges, for few lanes",
    "refine_by_speed": "searches among edges, for few lanes",
    "score_moments": "scatters to the meters' rows",
    "reset_paths": "fills fields with zeros by a call",
    "follow_paths": "adds to the path of the lane's medium, one of several fields",
    "score_paths_by_medium": "scatters to the meters' rows",
    "born_beside_hole": "draws again where a place lies in the hole",
    "born_on_paraboloid": "a logarithm and an exponential that keep the digits of shallow ones",
    "point_on_polygon": "searches for a triangle by its share of the area",
    "born_on_mesh": "searches for a facet by its share of the area",
    "meet_mesh": "descends a hierarchy of boxes, ray by ray",
    "cover_mesh": "descends a hierarchy of boxes, ray by ray",
    "land_on_facet": "gathers from the facets",
    "project_onto_quadric": "gathers from the sheets",
    "look_up_optics": "gathers from the surfaces",
    "scatter_into_lobe": "gathers from the cells of the lobe, for few lanes",
    "deflect_by_lens": "gathers from the surfaces, for few lanes",
    "cross_boundary": "gathers from the layer's rows",
    "end_lost_particles_of_many": "gathers from the bodies, where they are many",
    "find_medium_of_many": "gathers from the media, where they are many",
    "look_up_metal": "gathers from the surfaces",
    "choose_phase": "gathers from the media and searches among the parts of a mixture",
    "choose_segment_of_table": "gathers from the segments of a table",
    "bank_copies": "copies lanes into the bank, for few",
    "bank_forced_copies": "copies lanes into the bank, for few",
    "take_copies": "copies lanes out of the bank, for few",
    "attenuate_in_grid": "walks from voxel to voxel, ray by ray",
    "walk_through_grid": "walks from voxel to voxel, ray by ray",
    "walk_through_cells": "walks from cell to cell, ray by ray",
    "limit_by_clock_in_media": "gathers from the media",
    "set_collision_paths_in_grid": "gathers from the voxels",
    "score_collisions_in_box": "scatters to the cells' rows",
    "score_collisions_in_ball": "searches among the shells and scatters to their rows",
    "score_collisions_in_cylinder": "searches among the rings and scatters to their rows",
    "find_phase_of_flights": "gathers from the media",
    "find_phase_at_collisions": "gathers from the media",
    "scale_by_grid_scattering": "gathers from the voxels",
    "add_tabulated_pdf": "searches among the points of a table",
    "list_shadow_rays": "works on a list of lanes",
    "load_shadow_rays": "copies rays from bundle to bundle",
    "turn_into_second_leg": "gathers from the points and the media, for few lanes",
    "attenuate_shadow_rays_in_grid": "walks from voxel to voxel, ray by ray",
}
# AVX2 cannot convert packed int64 to float64 and back, nor mask as AVX-512 does.
SCALAR_WITHOUT_AVX512 = {
    "absorb",
    "born_over_rectangle",
    "born_over_disk",
    "born_over_triangle",
    "born_over_quadric",
    "born_over_holed",
    "find_medium",
    "stop_clock",
}


@pytest.mark.skipif(
    config.DISABLE_JIT or not host_has("avx2"), reason="looks for the wide registers of x86-64 CPUs"
)
def test_every_lane_loop_is_vectorised():
    """One branch, table look-up or libm call in a loop over lanes makes it five times slower, and nothing else shows."""
    share, exceptions = 0.05, set(SCALAR_PASSES)
    if not host_has("avx512dq"):
        share, exceptions = 1.5, exceptions | SCALAR_WITHOUT_AVX512
    assert set(SCALAR_PASSES) <= set(PASSES)
    slow = {name for name, p in PASSES.items() if not is_vectorised(assembly(p), share)}
    assert slow <= exceptions


@pytest.mark.skipif(
    config.DISABLE_JIT or not host_has("fma"), reason="looks for the fused operations of x86-64 CPUs"
)
def test_what_must_round_alike_fuses_no_product_with_a_sum():
    """Not in the passes of meshes, nor in what they call: the two sides of an edge would differ.  Other passes do."""
    exact = [lane_pass for lane_pass in PASSES.values() if lane_pass.arithmetic is EXACT]
    assert {lane_pass.name for lane_pass in exact} == {"meet_mesh", "cover_mesh"}
    assert not any(has_fused(assembly(lane_pass)) for lane_pass in exact)
    assert has_fused(assembly(PASSES["move"]))


def branching(b, table, first, live):
    """A pass as it must not be: a branch with a store in it, and a recurrence from lane to lane."""
    for k in range(first, live):
        if b.weight[k] < 0.5:
            b.x[k] = b.y[k - 1] * b.x[k - 1]
        else:
            b.bin[b.hit[k]] += 1
    return live


@pytest.mark.skipif(
    config.DISABLE_JIT or not host_has("avx2"), reason="looks for the wide registers of x86-64 CPUs"
)
def test_a_loop_that_is_not_vectorised_is_seen():
    assert not is_vectorised(assembly(Pass(branching, PASSES["move"].table)), 1.5)
