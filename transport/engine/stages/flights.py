"""Steps of a flight: prepare lanes, find the next surface, apply the medium and the clock along the path.

In media these steps repeat for lanes that collide, while those at a surface wait (passes/lanes.py).
"""

import math

import numpy as np

from transport.compile import layout
from transport.compile.media import bounded_rows, importance_row, roulette_row
from transport.engine.passes import (
    backward,
    bank,
    collisions,
    intersections,
    regions,
    snapshots,
    surfaces,
    variance_reduction,
    velocities,
    volume_cells,
    volumes,
    voxels,
)
from transport.engine.registry import step, step_by_name
from transport.engine.stages.next_event import (
    count_guarded_flights,
    rays_from_collisions,
    rays_from_flights,
)

# ---- Steps of volume detectors and tracks in a flight.
#
# Paths are scored before their absorption, collisions before their effects.


def score_paths(plan):
    """Yield the steps that score path lengths in volumes, or follow them, before clock and absorption act."""
    counting = [volume for volume in plan.volumes if not volume.counts_collisions]
    following = [score for score in plan.long_scores if score.in_flight is not None]
    if not (counting or following or plan.max_path_segments):
        return
    yield step(volumes.set_flight_end_in_media if plan.has_media else volumes.set_flight_end)
    if plan.has_clock:
        yield _limit_by_clock(plan)
    if plan.max_path_segments:
        yield step(snapshots.record_tracks)
    for score in following:
        yield step_by_name((score.in_flight, score.table))
    for volume in counting:
        yield step_by_name((volume.passes[0], volume.row))
        yield from _bin_directions(volume)
        for row in volume.grids:
            yield step(volume_cells.walk_through_grid, row)
        if plan.adjoint is not None:
            by_cell = backward.score_path_by_cell_in_media if volume.absorbs else backward.score_path_by_cell
            yield step(by_cell, volume.row)
        elif volume.has_cells:
            yield step(volume_cells.walk_through_cells, volume.row)
        else:
            yield step(volumes.score_path_in_media if volume.absorbs else volumes.score_path, volume.row)


def _limit_by_clock(plan):
    """Return the step that limits a flight to the end of the clock."""
    if plan.has_media:
        return step(volumes.limit_by_clock_in_media, _media_clock(plan))
    if plan.has_speeds:
        return step(volumes.limit_by_clock_and_speed)
    return step(volumes.limit_by_clock, _clock_row(plan))


def _clock_row(plan):
    """Return the table of the clock."""
    return layout.row(layout.CLOCK, duration=1.0, slowness=plan.slowness)


def _media_clock(plan):
    """Return the table of the clock in media."""
    rows = {"rows": plan.arena.place(plan.media), "count": len(plan.media)}
    return layout.row(layout.MEDIA_CLOCK, slowness=plan.slowness, has_speeds=plan.has_speeds, **rows)


def _bin_directions(volume):
    """Yield the step that bins directions, where all bins are of equal width."""
    if volume.row["is_even"]:
        yield step(volume_cells.find_equal_bins, volume.row)


def score_collisions(plan):
    """Yield the steps that score collisions in volumes."""
    counting = [volume for volume in plan.volumes if volume.counts_collisions]
    if not counting:
        return
    yield step(volume_cells.set_collision_paths)
    for row in plan.grids:
        yield step(volume_cells.set_collision_paths_in_grid, row)
    for volume in counting:
        yield from _bin_directions(volume)
        yield step_by_name((volume.passes[1], volume.row))


# ---- The steps of a flight.

PARALLEL = 2.0**-51  # distance between normals, to either side, that rounding leaves
# up to this many media are found, and their absorption summed, by one pass each
MAX_MEDIA_BY_SINGLE_PASSES = 4


def find_media(plan):
    """Yield the steps that find the medium of each lane."""
    if not plan.has_media:
        return
    if len(plan.media) > MAX_MEDIA_BY_SINGLE_PASSES:
        yield step(regions.find_medium_of_many, plan.arena.table(plan.media))
        return
    yield step(regions.set_outer_medium, _medium_table(plan, 0))
    for medium in range(len(plan.media) - 1, 0, -1):
        yield step(regions.find_medium, _medium_table(plan, medium))


def _medium_table(plan, medium):
    """Return the table of one medium."""
    values = {name: plan.media[name][medium] for name in ("mfp", "sigma_a", "survival")}
    return layout.row(layout.BODY, **values, medium=medium, bit=1 << medium >> 1)


def flight_steps(plan, moved):
    """Yield the steps of a flight up to a surface or a collision."""
    importance = importance_row(plan) if plan.splits else None
    # Sample a free path, or fly to the next surface.
    if plan.scatters:
        yield step(collisions.draw_flight)
    if plan.forces_collisions:
        yield step(variance_reduction.sample_free_or_forced_path)
    elif plan.scatters:
        yield step(voxels.sample_path_in_grids if plan.grids else collisions.sample_free_path)
    else:
        yield step(collisions.fly_uncollided if plan.has_media else intersections.reset_hit)
    if plan.splits:
        yield step(variance_reduction.cut_flight, importance)
    # Find the nearest surface ahead; end lanes that rounding carried out of a finite body.
    yield from intersect_surfaces(plan)
    yield from _end_lost_particles(plan)
    # Force first collisions; track through voxels.
    if plan.forces_collisions:
        yield step(variance_reduction.force_collision)
        yield step(bank.bank_forced_copies, moved)
    if plan.grids and not plan.splits:
        yield step(voxels.reset_cuts)
    for row in plan.grids:
        yield step(voxels.delta_track_in_grid, row)
    # Next-event estimation from flights, volume detectors, and the clock.
    yield from rays_from_flights(plan)
    yield from score_paths(plan)
    yield from count_guarded_flights(plan)
    if plan.has_clock:
        yield from _clock(plan)
    # Absorb along the path.
    if plan.attenuates:
        yield step(collisions.attenuate)
        yield from _account_absorption(plan)
    yield from _absorb_in_grids(plan)
    if plan.scatters:
        # Collide: score, absorb, play roulette, scatter, split.
        yield step(collisions.collide)
        if plan.splits:
            yield step(variance_reduction.revoke_station_collisions)
        elif plan.grids:
            yield step(voxels.revoke_cut_collisions)
        yield from score_collisions(plan)
        if plan.absorbs_weighted:
            yield step(voxels.absorb_by_albedo)
            yield from _account_absorption(plan)
        if plan.absorbs_analog:
            yield step(collisions.absorb_at_collisions)
            yield from _account_absorption(plan)
        if plan.has_roulette_in_flight:
            yield step(variance_reduction.play_roulette_in_flight, roulette_row(plan))
        yield from _scatter(plan)
        if plan.splits:
            yield step(variance_reduction.split_or_roulette, importance)
            yield step(bank.bank_copies, moved)
        yield step(surfaces.kill_endless)


def _end_lost_particles(plan):
    """Yield the steps that end lanes in a finite body without a surface ahead.

    There is one pass per body if there are few.
    """
    if not plan.has_bodies:
        return
    rows = bounded_rows(plan)
    finite = [row for row in rows if row["bit"] != 0]
    if len(finite) > MAX_MEDIA_BY_SINGLE_PASSES:
        table = plan.arena.table(np.array(rows, layout.BODY_BOUNDS))
        yield step(regions.end_lost_particles_of_many, table)
        return
    for row in finite:
        yield step(regions.end_lost_particles, row)


def _are_parallel(one, other):
    """Return whether two planes have one normal, or opposite ones, within rounding."""
    normals = [[float(row[axis]) for axis in ("nx", "ny", "nz")] for row in (one, other)]
    return min(math.dist(normals[0], [sign * x for x in normals[1]]) for sign in (1, -1)) <= PARALLEL


def intersect_surfaces(plan):
    """Yield the steps that intersect rays with each surface and detector; parallel planes in pairs."""
    waiting = None
    for name, row, _ in plan.members:
        if name != "cover_plane":
            yield step_by_name((name, row))
        elif waiting is None:
            waiting = row
        elif _are_parallel(waiting, row):
            pair = layout.row(layout.PLANES)
            pair["one"], pair["other"] = waiting, row
            across = [f"_{axis}" for axis in "xyz" if abs(waiting[f"n{axis}"]) == 1.0]
            yield step_by_name(("cover_planes" + "".join(across), pair))
            waiting = None
        else:
            yield step_by_name((name, waiting))
            waiting = row
    if waiting is not None:
        yield step_by_name(("cover_plane", waiting))


def _clock(plan):
    """Yield the steps of the clock: arrival times, phase-space detectors, snapshots, end of time."""
    if plan.has_media:
        yield step(velocities.time_arrival_in_media, _media_clock(plan))
    elif plan.has_speeds:
        yield step(velocities.time_arrival_by_speed)
    else:
        yield step(velocities.time_arrival, _clock_row(plan))
    for row in plan.phase_spaces:
        yield step(snapshots.count_phase_space, row)
    for row in plan.snapshots:
        yield step(snapshots.record_snapshot, row)
    yield step(velocities.stop_clock, _clock_row(plan))


def _absorb_in_grids(plan):
    """Yield the steps of grids that only absorb."""
    for row in plan.absorbing_grids:
        row["ledger"] = layout.ABSORBED + len(plan.surfaces) + row["medium"]
        yield step(voxels.attenuate_in_grid, row)


def _account_absorption(plan):
    """Yield the steps that add the media's absorption to the ledger: a pass per medium if there are few."""
    first = layout.ABSORBED + len(plan.surfaces)
    if len(plan.absorbing_media) > MAX_MEDIA_BY_SINGLE_PASSES:
        yield step(collisions.account_absorbed_in_all, layout.row(layout.ABSORBING_MEDIUM, ledger=first))
        return
    for medium in plan.absorbing_media:
        row = layout.row(layout.ABSORBING_MEDIUM, medium=medium, ledger=first + medium)
        yield step(collisions.account_absorbed_in, row)


def _scatter(plan):
    """Yield the steps of scattering: next-event estimation, phase function, new direction."""
    if len(plan.phase_laws) > 1:
        laws = np.array([row for _, row in plan.phase_laws], layout.PHASE_LAW)
        yield step(collisions.choose_phase, plan.arena.table(plan.media, laws))
    if plan.counts_reflections:
        yield step(collisions.count_scatterings)
    yield from rays_from_collisions(plan)
    for name, law in plan.phase_laws:
        if name == "scatter_tabulated":
            yield step(collisions.choose_segment_of_table, law)
        yield step_by_name((name, law))
