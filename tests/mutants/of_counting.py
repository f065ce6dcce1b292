"""Faults in what is counted: by meters, volumes, points and rays, into which bin."""

from tests.mutants.fault import Fault

SUMS = "engine/tally.py"
FURNACE = "experiments/test_planted_faults::test_a_furnace_that_forgets_what_is_reflected_is_rejected"

FAULTS = (
    Fault(
        "engine/passes/detectors.py",
        "return 1 + min(whole(abs(mu) * real(cells)), cells - 1)",
        "return min(whole(abs(mu) * real(cells)), cells - 1)",
        "bins of cosine that are one off",
        (
            "detectors/test_surface_detectors::test_a_ray_straight_along_the_normal_is_in_the_outermost_bin_of_cosine",
        ),
    ),
    Fault(
        "engine/passes/detectors.py",
        "return 1 + min(whole(abs(mu) * real(cells)), cells - 1)",
        "return 1 + whole(abs(mu) * real(cells))",
        "no clamp for a ray straight along the normal",
        (
            "detectors/test_surface_detectors::test_a_ray_straight_along_the_normal_is_in_the_outermost_bin_of_cosine",
        ),
    ),
    Fault(
        "engine/passes/detectors.py",
        "return (-mu if word & layout.DETECTOR_BACK else mu) if is_seen else 0.0",
        "return mu if is_seen else 0.0",
        "a meter's front for its back",
        (
            "detectors/test_surface_detectors::test_crossings_arrive_at_the_side_looked_at_and_depart_from_behind",
        ),
    ),
    Fault(
        "engine/passes/detectors.py",
        "base = (word & layout.DETECTOR_BASE_MASK) + (table.half if departs else 0)\n",
        "base = word & layout.DETECTOR_BASE_MASK\n",
        "what leaves counted with what arrives",
        (FURNACE,),
    ),
    Fault(
        "engine/passes/detectors.py",
        "add_long(row, weight * abs(lane.mu) * momentum)",
        "add_long(row, weight * momentum)",
        "the momentum of a particle for its part along the normal",
        (
            "detectors/test_surface_detectors::test_light_from_all_sides_has_its_fluence_and_presses_with_a_third_of_its_energy_density",
        ),
    ),
    Fault(
        "engine/passes/paths.py",
        "set_path(lane, table.number, 0.0)",
        "set_path(lane, table.number, path(lane, table.number))",
        "paths that begin where the lane's last particle ended",
        ("detectors/test_path_lengths::test_the_mean_path_through_a_body_is_four_volumes_over_its_surface",),
    ),
    Fault(
        "engine/passes/paths.py",
        "length, number = lane.flight_end - lane.start, numbers[lane.medium]",
        "length, number = lane.flight_end - lane.start, numbers[0]",
        "every path in the surrounding medium",
        ("detectors/test_path_lengths::test_paths_of_a_pencil_through_layers_are_their_lengths",),
    ),
    Fault(
        "engine/stages/births.py",
        "        for called in score.at_birth:\n            yield step_by_name(called)\n",
        "        pass\n",
        "paths that are never begun",
        ("detectors/test_path_lengths::test_every_way_of_tracking_has_the_same_mean_paths",),
    ),
    Fault(
        SUMS,
        "    return high, whole((scaled - real(high)) * 2147483648.0)\n\n\n@device\ndef limbs_of_loss",
        "    return high, int64(0)\n\n\n@device\ndef limbs_of_loss",
        "sums of weights rounded to 2^-32",
        ("hard/test_hard_media::test_the_energy_balance_keeps_every_unit_of_a_weight",),
    ),
    Fault(
        SUMS,
        "whole(rest + (chance if weight < FAINT else 0.0))",
        "whole(rest)",
        "faint weights cut off, which biases their sum",
        ("hard/test_hard_media::test_chance_rounds_up_only_what_is_less_than_a_unit",),
    ),
    Fault(
        SUMS,
        "else 2.0 / GRAZING_CUT",
        "else 1.0 / GRAZING_CUT",
        "half of the fluence that grazing light brings",
        (
            "detectors/test_surface_detectors::test_a_crossing_brings_one_over_its_cosine_and_beyond_the_grazing_cut_its_mean",
        ),
    ),
    Fault(
        SUMS,
        "4194304.0 + chance)",
        "4194304.0)",
        "fluence rates always rounded down",
        ("hard/test_hard_numbers::test_fluence_of_a_steady_grazing_beam_is_not_rounded_away",),
    ),
    Fault(
        "engine/passes/mis.py",
        "now, before = peak if is_diffuse else 0.0, lane.mis_pdf",
        "now, before = peak, lane.mis_pdf",
        "mirrored light taken for told by rays",
        ("detectors/test_estimators::test_expected_crossings_agree_with_counted_ones",),
    ),
    Fault(
        "engine/passes/next_event.py",
        "lane.pdf = INVERSE_PI * cosine",
        "lane.pdf = INVERSE_PI",
        "rays from diffuse walls without the cosine",
        ("detectors/test_estimators::test_expected_crossings_agree_with_counted_ones",),
    ),
    Fault(
        "engine/passes/next_event.py",
        "lane.score = 1.0 / (r * r) if r > 0.0 else 0.0",
        "lane.score = 1.0 / r if r > 0.0 else 0.0",
        "light that falls as 1/r",
        (
            "detectors/test_point_detectors::test_a_point_source_in_vacuum_falls_with_the_square_of_the_distance",
        ),
    ),
    Fault(
        "engine/passes/next_event.py",
        "side = 1.0 if lane.mu > 0.0 else -1.0",
        "side = 1.0",
        "walls that light points only from their front",
        ("detectors/test_point_detectors::test_in_a_diffuse_ball_the_walls_radiosity_adds_up",),
    ),
    Fault(
        "engine/passes/next_event.py",
        "sigma_s = lane.survival / mfp if mfp < math.inf else -1.0",
        "sigma_s = 1.0 / mfp if mfp < math.inf else -1.0",
        "extinction for scattering where flights light a point",
        (
            "detectors/test_point_detectors::test_light_scattered_elsewhere_comes_from_flights_and_the_rest_by_detours",
        ),
    ),
    Fault(
        "engine/passes/once_more_collided.py",
        "PI_CUBED / r if r > 0.0 else 0.0",
        "PI_CUBED if r > 0.0 else 0.0",
        "detours without their density's factor",
        ("detectors/test_point_detectors::test_a_point_source_in_fog_against_its_transform",),
    ),
    Fault(
        "engine/passes/shadow_rays.py",
        "depth = (lane.sigma_a + 1.0 / lane.mfp) * (lane.distance - lane.start)",
        "depth = lane.sigma_a * (lane.distance - lane.start)",
        "shadow rays that scattering does not dim",
        ("detectors/test_point_detectors::test_a_point_source_in_fog_against_its_transform",),
    ),
    Fault(
        "engine/passes/backward.py",
        "lane.weight *= mu * mu * mu",
        "lane.weight *= mu * mu * mu * mu",
        "a pixel's cosine to the fourth power",
        ("detectors/test_estimators::test_pixels_on_a_lamp_show_its_radiance_and_shares_of_it_at_its_edge",),
    ),
    Fault(
        "engine/passes/backward.py",
        "lane.u2 = coordinate_in_bin(lane.arena + table.mu_edges, table.mu_cells, number % table.mu_cells, lane.u2)",
        "lane.u2 = coordinate_in_bin(lane.arena + table.mu_edges, table.mu_cells, 0, lane.u2)",
        "one stratum drawn again and again",
        ("detectors/test_estimators::test_a_map_shows_where_light_comes_from",),
    ),
    Fault(
        "engine/passes/volumes.py",
        "near = start if start > -half else -half",
        "near = -half",
        "ways in a ball counted from before the flight's start",
        ("detectors/test_volume_detectors::test_a_flight_that_begins_within_counts_from_where_it_begins",),
    ),
    Fault(
        "engine/passes/volumes.py",
        "return -less / depth if depth > 0.0 else 1.0, less",
        "return 1.0 + less, less",
        "the weight at the end of a way for its mean along it",
        ("detectors/test_volume_detectors::test_a_beam_fades_in_each_cell_by_the_exact_integral",),
    ),
    Fault(
        "engine/passes/volume_cells.py",
        "score_part(lane, table, cell[0], bin, length, weight, fade, keep)\n            t = face\n",
        "score_part(lane, table, cell[0], bin, length, weight, fade, keep)\n",
        "ways through cells counted twice",
        (
            "detectors/test_volume_detectors::test_in_a_uniform_field_the_fluence_rate_is_4_pi_radiance_in_each_cell",
        ),
    ),
    Fault(
        "physics/cells.py",
        "if face != last else math.inf",
        "if face <= last else math.inf",
        "walks that leave their cells by the lower faces",
        ("physics/test_cells::test_a_ray_ends_in_the_last_cell_however_far_its_end_lies_beyond",),
    ),
    Fault(
        "engine/passes/voxels.py",
        "depth += here * (stop - t) if stop > t else 0.0",
        "depth += here * (face - t) if stop > t else 0.0",
        "optical depth beyond the end of a flight",
        ("detectors/test_point_detectors::test_a_grid_dims_voxel_by_voxel",),
    ),
    Fault(
        "engine/passes/snapshots.py",
        "add_long(sums + 160, weight * vz * vz)",
        "add_long(sums + 160, weight * vy * vz)",
        "swapped components in a second moment",
        ("physics/test_phase_moments",),
    ),
    Fault(
        "engine/passes/detector_bins.py",
        "value = toward * lane.uz",
        "value = lane.uz",
        "arrivals binned by where they fly to instead of where they come from",
        (
            "detectors/test_surface_detectors::test_a_ray_straight_along_the_normal_is_in_the_outermost_bin_of_cosine",
            "detectors/test_surface_detectors::test_light_from_below_is_in_the_worlds_lower_bins_of_a_ball",
        ),
    ),
    Fault(
        "engine/passes/detector_bins.py",
        "found += half if value >= bounds[found + half] else 0",
        "found += half if value > bounds[found + half] else 0",
        "an edge that belongs to the bin below it",
        (
            "detectors/test_surface_detectors::test_a_ray_on_the_edge_between_two_bins_of_place_is_in_the_upper_one",
        ),
    ),
    Fault(
        "engine/passes/detector_bins.py",
        "u, v = math.sqrt(u * u + v * v), azimuth_turn(u, v) * TWO_PI",
        "u, v = math.sqrt(u * u + v * v), azimuth_turn(v, u) * TWO_PI",
        "azimuths on a disk from the wrong axis",
        ("detectors/test_surface_detectors::test_a_place_on_a_flat_shape_has_the_same_bin_from_either_side",),
    ),
)
