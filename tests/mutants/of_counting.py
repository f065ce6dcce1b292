"""Faults in what is counted: by meters, volumes, points and rays, into which bin."""

from tests.mutants.fault import Fault

SUMS = "engine/tally.py"
FURNACE = "sims/test_planted_faults::test_a_furnace_that_forgets_what_is_reflected_is_rejected"

FAULTS = (
    Fault(
        "engine/passes/detectors.py",
        "return 1 + min(int64(abs(mu) * float64(cells)), cells - 1)",
        "return min(int64(abs(mu) * float64(cells)), cells - 1)",
        "bins of cosine that are one off",
        (
            "detectors/test_surface_detectors::test_a_ray_straight_along_the_normal_is_in_the_outermost_bin_of_cosine",
        ),
    ),
    Fault(
        "engine/passes/detectors.py",
        "return 1 + min(int64(abs(mu) * float64(cells)), cells - 1)",
        "return 1 + int64(abs(mu) * float64(cells))",
        "no clamp for a ray straight along the normal",
        (
            "detectors/test_surface_detectors::test_a_ray_straight_along_the_normal_is_in_the_outermost_bin_of_cosine",
        ),
    ),
    Fault(
        "engine/passes/detectors.py",
        "return (-mu if word & layout.DETECTOR_BACK else mu) if covered else 0.0",
        "return mu if covered else 0.0",
        "a meter's front for its back",
        (
            "detectors/test_surface_detectors::test_what_meets_the_side_looked_at_arrives_and_what_comes_from_behind_leaves",
        ),
    ),
    Fault(
        "engine/passes/detectors.py",
        "base = (word & layout.DETECTOR_BASE_MASK) + (half if departs else 0)\n",
        "base = word & layout.DETECTOR_BASE_MASK\n",
        "what leaves counted with what arrives",
        (FURNACE,),
    ),
    Fault(
        "engine/passes/detectors.py",
        "add_long(row, weight * abs(b.mu[k]) * momentum)",
        "add_long(row, weight * momentum)",
        "the momentum of a particle for its part along the normal",
        (
            "detectors/test_surface_detectors::test_light_from_all_sides_has_its_fluence_and_presses_with_a_third_of_its_energy_density",
        ),
    ),
    Fault(
        "engine/passes/paths.py",
        "words[word + k] = 0.0",
        "words[word + k] += 0.0",
        "paths that begin where the lane's last particle ended",
        ("detectors/test_path_lengths::test_the_mean_path_through_a_body_is_four_volumes_over_its_surface",),
    ),
    Fault(
        "engine/passes/paths.py",
        "length, number = b.flight_end[k] - b.start[k], numbers[b.medium[k]]",
        "length, number = b.flight_end[k] - b.start[k], numbers[0]",
        "every path in the surrounding medium",
        ("detectors/test_path_lengths::test_paths_of_a_pencil_through_layers_are_their_lengths",),
    ),
    Fault(
        "engine/stages/births.py",
        "        if score.at_birth is not None:\n            yield step_by_name((score.at_birth, score.table))\n",
        "        pass\n",
        "paths that are never begun",
        ("detectors/test_path_lengths::test_every_way_of_tracking_has_the_same_mean_paths",),
    ),
    Fault(
        SUMS,
        "    return high, int64((scaled - float64(high)) * 2147483648.0)\n\n\n@device\ndef limbs_of_loss",
        "    return high, int64(0)\n\n\n@device\ndef limbs_of_loss",
        "sums of weights rounded to 2^-32",
        ("hard/test_hard_media::test_the_energy_balance_keeps_every_unit_of_a_weight",),
    ),
    Fault(
        SUMS,
        "int64(rest + (chance if weight < FAINT else 0.0))",
        "int64(rest)",
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
        "4194304.0 + chance))",
        "4194304.0))",
        "fluence rates always rounded down",
        ("hard/test_hard_numbers::test_fluence_of_a_steady_grazing_beam_is_not_rounded_away",),
    ),
    Fault(
        "engine/passes/mis.py",
        "now, before = peak if is_diffuse else 0.0, b.mis_pdf[k]",
        "now, before = peak, b.mis_pdf[k]",
        "mirrored light taken for told by rays",
        ("detectors/test_expected::test_events_tell_what_flights_count",),
    ),
    Fault(
        "engine/passes/next_event.py",
        "b.pdf[k] = INVERSE_PI * cosine",
        "b.pdf[k] = INVERSE_PI",
        "rays from diffuse walls without the cosine",
        ("detectors/test_expected::test_events_tell_what_flights_count",),
    ),
    Fault(
        "engine/passes/shadow_rays.py",
        "b.score[k] = b.weight[k] * density / (r * r) if r > 0.0 else 0.0",
        "b.score[k] = b.weight[k] * density / r if r > 0.0 else 0.0",
        "light that falls as 1/r",
        (
            "detectors/test_point_detectors::test_a_point_source_in_vacuum_falls_with_the_square_of_the_distance",
        ),
    ),
    Fault(
        "engine/passes/shadow_rays.py",
        "side = 1.0 if b.mu[k] > 0.0 else -1.0",
        "side = 1.0",
        "walls that light points only from their front",
        ("detectors/test_point_detectors::test_in_a_diffuse_ball_the_walls_radiosity_adds_up",),
    ),
    Fault(
        "engine/passes/shadow_rays.py",
        "sigma_s = b.survival[k] / mfp if mfp < math.inf else -1.0",
        "sigma_s = 1.0 / mfp if mfp < math.inf else -1.0",
        "extinction for scattering where flights light a point",
        (
            "detectors/test_point_detectors::test_what_scatters_elsewhere_is_told_from_flights_the_rest_by_detours",
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
        "depth = (b.sigma_a[k] + 1.0 / b.mfp[k]) * (b.distance[k] - b.start[k])",
        "depth = b.sigma_a[k] * (b.distance[k] - b.start[k])",
        "shadow rays that scattering does not dim",
        ("detectors/test_point_detectors::test_a_point_source_in_fog_against_its_transform",),
    ),
    Fault(
        "engine/passes/backward.py",
        "b.weight[k] *= mu * mu * mu",
        "b.weight[k] *= mu * mu * mu * mu",
        "a pixel's cosine to the fourth power",
        ("detectors/test_cameras",),
    ),
    Fault(
        "engine/passes/backward.py",
        "b.u2[k] = coordinate_in_bin(table.mu_edges, table.mu_cells, number % table.mu_cells, b.u2[k])\n"
        "        b.u3[k]",
        "b.u2[k] = coordinate_in_bin(table.mu_edges, table.mu_cells, 0, b.u2[k])\n        b.u3[k]",
        "one stratum drawn again and again",
        ("detectors/test_cameras",),
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
        "score_part(b, table, k, number, bin, length, weight, fade, keep)\n            t = face\n",
        "score_part(b, table, k, number, bin, length, weight, fade, keep)\n",
        "ways through cells counted twice",
        (
            "detectors/test_volume_detectors::test_in_a_uniform_field_the_fluence_rate_is_4_pi_radiance_in_each_cell",
        ),
    ),
    Fault(
        "engine/passes/voxels.py",
        "depth += here * (stop - t) if stop > t else 0.0",
        "depth += here * (leaves - t) if stop > t else 0.0",
        "optical depth beyond the end of a flight",
        ("detectors/test_point_detectors::test_a_grid_dims_voxel_by_voxel",),
    ),
    Fault(
        "engine/passes/snapshots.py",
        "add_long(sums + 160, weight * vz * vz)",
        "add_long(sums + 160, weight * vy * vz)",
        "swapped components in a second moment",
        ("test_phase_moments",),
    ),
    Fault(
        "engine/passes/detector_bins.py",
        "value = toward * b.uz[k]",
        "value = b.uz[k]",
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
        ("detectors/test_surface_detectors::test_azimuths_on_a_disk_run_from_its_own_e_u_to_e_v",),
    ),
)
