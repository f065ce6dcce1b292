"""Faults where seldom-combined features meet: aims with clocks and volumes, hollows, waiting lanes."""

from tests.mutants.fault import Fault

AIMED = "physics/test_clocks::test_the_fluence_of_an_aimed_flash_is_on_the_way_that_it_has_flown"
FADES = "detectors/test_volume_detectors::test_a_beam_fades_on_its_way_to_a_volume_and_in_the_hollow_of_one"
SEEN = "detectors/test_surface_detectors::test_a_lamp_is_seen_at_its_own_azimuth"
SHARP = "physics/test_sharp_laws::test_every_row_agrees_with_its_closed_form"
DENSITY = "physics/test_samplers::test_densities_of_phase_functions_in_the_engine_are_those_of_theory"
CLOCKS, VOLUMES, CELLS = (
    "engine/passes/velocities.py",
    "engine/passes/volumes.py",
    "engine/passes/volume_cells.py",
)
REFINED = "engine/passes/detector_bins.py"
ROTATED = "e_u, e_v = ux * eux + uy * euy + uz * euz, ux * evx + uy * evy + uz * evz"

FAULTS = (
    Fault(
        VOLUMES,
        "last = lane.start + (1.0 - lane.time) / slowness",
        "last = (1.0 - lane.time) / slowness",
        "an aimed pulse that flies on in volumes for as long as its clock runs beyond its target",
        (AIMED,),
    ),
    Fault(
        VOLUMES,
        "last = lane.start + (1.0 - lane.time) * lane.speed",
        "last = (1.0 - lane.time) * lane.speed",
        "the same where each flies at its own speed",
        (AIMED,),
    ),
    Fault(
        VOLUMES,
        "last = lane.start + (1.0 - lane.time) / pace",
        "last = (1.0 - lane.time) / pace",
        "the same in media",
        (AIMED,),
    ),
    Fault(
        "engine/passes/snapshots.py",
        "length = lane.start + (table.time - lane.time) * speed\n"
        "    x, y, z, vx, vy, vz = state_at(lane.x, lane.y, lane.z, ux, uy, uz, length, speed)\n"
        "    inside",
        "length = (table.time - lane.time) * speed\n"
        "    x, y, z, vx, vy, vz = state_at(lane.x, lane.y, lane.z, ux, uy, uz, length, speed)\n"
        "    inside",
        "aimed particles that phase space finds beyond their target",
        ("physics/test_clocks::test_phase_space_finds_an_aimed_flash_as_far_as_it_has_flown",),
    ),
    Fault(
        CLOCKS,
        "lane.arrival = lane.time + (lane.distance - lane.start) * pace",
        "lane.arrival = lane.time + lane.distance * pace",
        "an aimed flight in a medium that takes no time as far as its target",
        ("physics/test_clocks::test_an_aimed_flash_crosses_each_pane_when_it_has_flown_there",),
    ),
    Fault(
        "engine/driver.py",
        "last = _pad_lanes(b, LANES + b.waiting)",
        "last = LANES + (b.waiting + 7) // 8 * 8",
        "particles behind the end of the queue that act at a surface once more",
        ("media/test_tracking::test_light_that_met_nothing_in_fog_arrives_all_at_once",),
    ),
    Fault(
        CLOCKS,
        "lane.u0 = start + uniform(w0, w1) * width, uniform(w2, w3)",
        "lane.u0 = start + uniform(w0, w1) * width, uniform(w0, w1)",
        "a number used twice: for the time of birth and the speed",
        ("physics/test_clocks::test_when_a_particle_is_born_does_not_tell_how_fast_it_is",),
    ),
    Fault(
        REFINED,
        ROTATED,
        "e_u, e_v = ux * eux + uy * euy + uz * euz, -(ux * evx + uy * evy + uz * evz)",
        "azimuths that turn the wrong way",
        (SEEN,),
    ),
    Fault(
        "compile/detectors.py",
        'values |= {"eux": -e_u[0], "euy": -e_u[1], "euz": -e_u[2], "handed": -1.0}',
        'values |= {"handed": -1.0}',
        "a frame of directions that is left-handed from behind",
        (SEEN,),
    ),
    Fault(
        "vectors.py",
        "return unit_vector(_cross(e_v, normal)), e_v, normal",
        "return unit_vector(_cross(normal, e_v)), e_v, normal",
        "left-handed frames of all shapes",
        (SEEN,),
    ),
    Fault(
        REFINED,
        "nx, ny, nz = m.side * lane.nx, m.side * lane.ny, m.side * lane.nz",
        "nx, ny, nz = lane.nx, lane.ny, lane.nz",
        "directions seen from within a curved shape in the frame of its outside",
        (
            "detectors/test_surface_detectors::test_on_curved_shapes_e_v_is_along_the_axis_and_e_u_on_its_right",
        ),
    ),
    Fault(
        REFINED,
        "                u = m.handed * u\n                u, v = math.sqrt",
        "                u, v = math.sqrt",
        "places on a disk that are mirrored from behind",
        ("detectors/test_surface_detectors::test_a_place_on_a_flat_shape_has_the_same_bin_from_either_side",),
    ),
    Fault(
        CELLS,
        "            elif table.kept != 0:\n                weight *= exp_negative(-fade * length)\n",
        "",
        "light that does not fade in the hollow of a volume",
        (FADES,),
    ),
    Fault(
        "scene/volumes.py",
        "math.pi * (b - a) * (a + b), np",
        "math.pi * (b - a) * (b + b), np",
        "rings whose area is that of their outer edge",
        ("detectors/test_volume_detectors::test_the_rings_add_up_to_the_whole",),
    ),
    Fault(
        CELLS,
        "(-half_chord(radii[ring], q) - across)",
        "(-half_chord(radii[ring - 1], q) - across)",
        "rays that go on to the wrong ring on their way to the axis",
        ("detectors/test_volume_detectors::test_paths_through_rings_are_exact",),
    ),
    Fault(
        CELLS,
        "    leaves = leaves if q <= radius else -math.inf\n",
        "",
        "rays beside a cylinder, along its axis, that count as inside",
        ("detectors/test_volume_detectors::test_a_ray_along_the_axis_stays_in_its_ring",),
    ),
    Fault(
        CELLS,
        "            weight *= exp_negative(-fade * before)\n",
        "",
        "light that does not fade in voxels before a volume begins",
        (FADES,),
    ),
    Fault(
        "engine/passes/voxels.py",
        "number_along(z - table.cz, table.per_z, table.nz)",
        "number_along(z - table.cz, table.per_z, table.ny)",
        "the number of voxels along y for that along z, where collisions are counted",
        ("detectors/test_volume_detectors::test_collisions_in_layers_of_voxels_absorb_as_much_as_tracks",),
    ),
    Fault(
        "engine/passes/variance_reduction.py",
        "start = lane.start if lane.start < 0.0 else 0.0",
        "start = 0.0",
        "aimed histories weighed by the importance of their target where they are born",
        (
            "media/test_tracking::test_what_is_born_is_heavy_as_its_own_birthplace_wants_and_light_as_the_end_does",
        ),
    ),
    Fault(
        "engine/passes/bank.py",
        "row[WEIGHT], row[BIRTH], row[AHEAD] = bits_of(caught), bits_of(birth), bits_of(lane.copy_path)",
        "row[WEIGHT], row[AHEAD] = bits_of(caught), bits_of(lane.copy_path)",
        "forced copies that roulette compares with the whole history",
        ("engine/test_flight_passes::test_forced_copies_are_not_killed_by_roulette_for_their_small_weight",),
    ),
    Fault(
        "engine/passes/emission.py",
        "    lane.z += lane.start * lane.uz\n",
        "",
        "aimed births that are counted beside their source",
        ("detectors/test_aimed_births::test_an_aim_changes_where_particles_fly_but_not_where_they_are_born",),
    ),
    Fault(
        "engine/passes/next_event.py",
        "clip_to_slab(0.0, math.inf, ox, ux, table.hx)",
        "clip_to_slab(-math.inf, math.inf, ox, ux, table.hx)",
        "what glows behind a point seen before it",
        (
            "detectors/test_point_detectors::test_a_glowing_box_is_seen_from_inside_from_close_by_and_from_afar",
        ),
    ),
    Fault(
        "engine/passes/backward.py",
        "track = lane.weight * exp_negative(-fade * lane.length_before) * mean * length",
        "track = lane.weight * mean * length",
        "a glow whose light does not fade on the way to a camera",
        ("detectors/test_estimators::test_a_glow_behind_fog_is_as_bright_as_what_fades_on_the_way_leaves",),
    ),
    Fault(
        "engine/passes/detectors.py",
        "momentum = table.slowest / lane.speed if table.is_light != 0 else v",
        "momentum = v",
        "the momentum of matter for that of light",
        (
            "detectors/test_surface_detectors::test_light_of_each_speed_presses_by_its_energy_over_its_own_speed",
        ),
    ),
    Fault(
        "engine/passes/collisions.py",
        "lane.u0 = min((u - low) / (laws[chosen - 1].share - low), 1.0 - 2.0**-53)",
        "lane.u0 = 0.0 * low + u",
        "an experiment of verify in which a mixture uses its number twice",
        (SHARP,),
    ),
    Fault(
        "physics/sight.py",
        "return 0.05968310365946075 * (1.0 + mu * mu)",
        "return 0.0599815191 * (1.0 + mu * mu)",
        "half a percent too much of Rayleigh's density",
        (DENSITY,),
    ),
    Fault(
        "physics/sight.py",
        "return 0.05968310365946075 * (1.0 + mu * mu)",
        "return 0.05998151917775764 * (1.0 + mu * mu)",
        "the same, in an experiment of verify",
        (SHARP,),
    ),
    Fault(
        "physics/interfaces.py",
        "return 0.5 * (s * s + p * p) if",
        "return 0.5 * (s * s + 1.0007 * p * p) if",
        "0.07 % too much of R_p",
        ("physics/test_samplers::test_fresnel_in_the_engine_is_that_of_theory",),
    ),
    Fault(
        "physics/interfaces.py",
        "return 0.5 * (s * s + p * p) if",
        "return 0.5 * (s * s + 1.00070 * p * p) if",
        "the same R_p, in an experiment of verify",
        (SHARP,),
    ),
    Fault(
        "engine/passes/guides.py",
        "lane.weight *= boxes[i + 8]",
        "lane.weight *= 0.5",
        "guided births of equal weights",
        ("run/test_guided_births::test_every_source_gives_the_same_with_a_guide",),
    ),
    Fault(
        "compile/guides.py",
        "return self.least * self.volumes / self.shares",
        "return self.least * np.prod(self.widths[:, 2:], axis=1) / self.shares",
        "weights of guided births without the boxes' extent in place",
        ("run/test_guided_births::test_a_guide_is_a_density_with_weights_of_its_inverse",),
    ),
    Fault(
        "engine/passes/guides.py",
        "lane.block_0, lane.block_1 = bits_of_uniform(lane.u2), bits_of_uniform(lane.u3)",
        "lane.block_0, lane.block_1 = bits_of_uniform(lane.u0), bits_of_uniform(lane.u1)",
        "guided directions from the numbers of the place",
        ("run/test_guided_births::test_where_nothing_is_learnt_all_numbers_are_those_without_a_guide",),
    ),
    Fault(
        "run/guiding.py",
        "count = max(1, len(plan.scene.meters)) * (4 if scales else 2)",
        "count = max(1, len(plan.scene.meters) * (4 if scales else 2))",
        "a guide of lamps that are volumes only",
        ("run/test_guided_births::test_backward_runs_with_lamps_that_are_volumes_only",),
    ),
    Fault(
        "engine/passes/mis.py",
        "height = 2.0 * height if reflects else 0.0",
        "height = 0.0",
        "flights by a mirror share light as if from where they were reflected to",
        ("detectors/test_mirror_images::test_a_room_with_a_mirror_is_the_same_to_all_estimators",),
    ),
    Fault(
        "engine/passes/shadow_rays.py",
        "lane.weight *= reflects if turns else passes",
        "lane.weight *= reflects",
        "shadow rays that pass a screen keep what a mirror reflects",
        ("detectors/test_mirror_images::test_a_sieve_that_light_passes_straight_is_no_obstacle",),
    ),
    Fault(
        "scene/cameras.py",
        "meets = origins - self.position + ((far - depth) / along)[:, None] * rays",
        "meets = origins - self.position + ((far + depth) / along)[:, None] * rays",
        "pictures out of a light field by a camera as far in front of the near plane as it stands behind",
        ("experiments/test_pictures_of_lenses::test_a_picture_out_of_a_light_field_is_the_cameras",),
    ),
    Fault(
        "scene/cameras.py",
        "total += weight_x * weight_y / (1 + x[:, None, :, None] + y[None, :, None, :]) ** 2",
        "total += weight_x * weight_y / (1 + x[:, None, :, None] + y[None, :, None, :]) ** 1.5",
        "throughput of a light field's cells with one cosine too few",
        ("experiments/test_pictures_of_lenses::test_flux_through_both_planes_is_radiance_times_throughput",),
    ),
    Fault(
        "scene/resampling.py",
        "@ found + no_value)",
        "@ found)",
        "pixels without a ray in the light field that are black",
        ("scene/test_views_of_light_fields::test_pixels_of_which_rays_miss_have_no_value",),
    ),
    Fault(
        "engine/passes/backward.py",
        "u, v = lane.u2 - nearness * a, lane.u3 - nearness * b",
        "u, v = lane.u2 + nearness * a, lane.u3 - nearness * b",
        "rays of a thin lens that do not meet in the plane of focus",
        ("experiments/test_pictures_of_lenses::test_an_edge_is_smeared_over_the_circle_of_confusion",),
    ),
    Fault(
        "engine/passes/backward.py",
        "u, v = lane.u2 + (power - nearness) * a, lane.u3 + (power - nearness) * b",
        "u, v = lane.u2 + power * a, lane.u3 + power * b",
        "cos^4 of a lens as if its film were in the focus",
        ("experiments/test_pictures_of_lenses::test_an_edge_is_smeared_over_the_circle_of_confusion",),
    ),
)
