"""Steps of a flight: prepare lanes, find the next surface, apply the medium and the clock along the path.

In media these steps repeat for lanes that collide, before those at a surface go on (driver._fly_on).
"""

import numpy as np

from transport.compile import layout
from transport.compile.media import bounded_rows, importance_row, roulette_row
from transport.engine.passes import (
    backward,
    collisions,
    flats,
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
from transport.engine.registry import named, rows_of, step
from transport.engine.stages.next_event import (
    casts_of_flights,
    detours_of_collisions,
    expected_of_collisions,
    guards,
)

# ---- Steps of volume detectors and tracks in a flight.
#
# Paths are scored before their absorption, collisions before their effects.


def ways(plan):
    """Yield the steps that score path lengths in volumes, before the clock and absorption act."""
    counting = [volume for volume in plan.volumes if not volume.counts_collisions]
    if not (counting or plan.ways_room):
        return
    yield step(volumes.reach_next_in_media if plan.has_media else volumes.reach_next)
    if plan.has_clock:
        yield _end_of_clock(plan)
    if plan.ways_room:
        yield step(snapshots.write_ways)
    for volume in counting:
        yield step(volumes.clip_to_box if volume.is_box else volumes.clip_to_ball, volume.row)
        yield from _directions(volume)
        for row in volume.grids:
            yield step(volume_cells.walk_through_grid, row)
        if plan.turned is not None:
            by_cell = backward.score_way_by_cell_in_media if volume.absorbs else backward.score_way_by_cell
            yield step(by_cell, volume.row)
        elif volume.has_cells:
            yield step(volume_cells.walk_through_cells, volume.row)
        else:
            yield step(volumes.score_way_in_media if volume.absorbs else volumes.score_way, volume.row)


def _end_of_clock(plan):
    """Return the step that limits a flight to the end of the clock."""
    if plan.has_media:
        rows = {"rows": plan.media.ctypes.data, "count": len(plan.media)}
        law = layout.row(layout.MEDIA_CLOCK, slowness=plan.slowness, has_speeds=plan.has_speeds, **rows)
        return step(volumes.reach_until_end_in_media, law)
    if plan.has_speeds:
        return step(volumes.reach_until_end_by_speed)
    return step(volumes.reach_until_end, layout.row(layout.CLOCK, duration=1.0, slowness=plan.slowness))


def _directions(volume):
    """Yield the step that bins directions, where all bins are of equal width."""
    if volume.row["is_even"]:
        yield step(volume_cells.find_even_bins, volume.row)


def collided(plan):
    """Yield the steps that score collisions in volumes."""
    counting = [volume for volume in plan.volumes if volume.counts_collisions]
    if not counting:
        return
    yield step(volume_cells.know_collisions)
    for row in plan.grids:
        yield step(volume_cells.know_collisions_in_grid, row)
    for volume in counting:
        yield from _directions(volume)
        in_box, in_ball = volume_cells.score_collisions_in_box, volume_cells.score_collisions_in_ball
        yield step(in_box if volume.is_box else in_ball, volume.row)


# ---- Steps of a flight: prepare lanes, find the next surface, apply the medium and the clock along the path.

PARALLEL = 1.0 - 2.0**-52  # cosine between the normals of parallel planes
FEW_MEDIA = 4  # up to this many media are found, and their absorption summed, by one pass each


def ready_to_fly(plan):
    """Yield the steps before a flight: reset the hit and find the current medium."""
    if not plan.has_media:
        return
    if plan.scatters:
        yield step(collisions.set_out)
    yield from known_media(plan)


def known_media(plan):
    """Yield the steps that find the medium of each lane."""
    if not plan.has_media:
        return
    if len(plan.media) > FEW_MEDIA:
        yield step(regions.know_bodies, rows_of(plan.media))
        return
    yield step(regions.know_surroundings, _body(plan, 0))
    for medium in range(len(plan.media) - 1, 0, -1):
        yield step(regions.know_body, _body(plan, medium))


def _body(plan, medium):
    """Return the table of one medium."""
    values = {name: plan.media[name][medium] for name in ("mfp", "sigma_a", "survival")}
    return layout.row(layout.BODY, **values, medium=medium, bit=1 << medium >> 1)


def rounds_of(plan, moved):
    """Yield the steps of a flight up to a surface or a collision."""
    importance = importance_row(plan) if plan.splits else None
    # Sample a free path, or fly to the next surface.
    if plan.forces:
        yield step(variance_reduction.fly_or_be_forced)
    elif plan.scatters:
        yield step(voxels.fly_in_grids if plan.grids else collisions.fly)
    else:
        yield step(collisions.fly_straight if plan.has_media else intersections.look_ahead)
    if plan.splits:
        yield step(variance_reduction.cut_flight, importance)
    # Find the nearest surface ahead; end lanes that rounding carried out of a finite body.
    yield from members_of(plan)
    yield from _strays(plan)
    # Force first collisions; track through voxels.
    if plan.forces:
        yield step(variance_reduction.force_collision)
        yield step(variance_reduction.deposit_forced, moved)
    if plan.grids and not plan.splits:
        yield step(voxels.cut_nothing)
    for row in plan.grids:
        yield step(voxels.collide_in_grid, row)
    # Next-event estimation from flights, volume detectors, and the clock.
    yield from casts_of_flights(plan)
    yield from ways(plan)
    yield from guards(plan)
    if plan.has_clock:
        yield from _clock(plan)
    # Absorb along the path.
    if plan.attenuates:
        yield step(collisions.attenuate)
        yield from _absorbed(plan)
    yield from _thinned(plan)
    if plan.scatters:
        # Collide: score, absorb, play roulette, scatter, split.
        yield step(collisions.collide)
        if plan.splits:
            yield step(variance_reduction.pause_at_station)
        elif plan.grids:
            yield step(voxels.pause)
        yield from collided(plan)
        if plan.absorbs_by_share:
            yield step(voxels.absorb_share)
            yield from _absorbed(plan)
        if plan.absorbs_by_chance:
            yield step(collisions.absorb_by_chance)
            yield from _absorbed(plan)
        if plan.has_roulette_in_flight:
            yield step(variance_reduction.play_roulette_in_flight, roulette_row(plan))
        yield from _scattering(plan)
        if plan.splits:
            yield step(variance_reduction.weigh_by_importance, importance)
            yield step(variance_reduction.deposit, moved)
        yield step(surfaces.give_up)


def _strays(plan):
    """Yield the steps that end lanes in a finite body without a surface ahead.

    There is one pass per body if there are few.
    """
    if not plan.has_bodies:
        return
    rows = bounded_rows(plan)
    finite = [row for row in rows if row["bit"] != 0]
    if len(finite) > FEW_MEDIA:
        plan.kept.append(np.array(rows, layout.BOUNDED))
        yield step(regions.lose_strays_of_many, rows_of(plan.kept[-1]))
        return
    for row in finite:
        yield step(regions.lose_strays, row)


def members_of(plan):
    """Yield the steps that intersect rays with each surface and detector; parallel planes in pairs."""
    waiting = None
    for name, row, _ in plan.members:
        if name != "cover_plane":
            yield named((name, row))
        elif waiting is None:
            waiting = row
        elif abs(sum(waiting[axis] * row[axis] for axis in ("nx", "ny", "nz"))) >= PARALLEL:
            pair = layout.row(layout.PLANES)
            pair["one"], pair["other"] = waiting, row
            yield step(flats.cover_planes, pair)
            waiting = None
        else:
            yield named((name, waiting))
            waiting = row
    if waiting is not None:
        yield named(("cover_plane", waiting))


def _clock(plan):
    """Yield the steps of the clock: arrival times, phase-space detectors, snapshots, end of time."""
    clock = layout.row(layout.CLOCK, duration=1.0, slowness=plan.slowness)
    if plan.has_media:
        rows = {"rows": plan.media.ctypes.data, "count": len(plan.media)}
        law = layout.row(layout.MEDIA_CLOCK, slowness=plan.slowness, has_speeds=plan.has_speeds, **rows)
        yield step(velocities.time_arrival_in_media, law)
    else:
        yield (
            step(velocities.time_arrival_by_speed)
            if plan.has_speeds
            else step(velocities.time_arrival, clock)
        )
    for row in plan.phase_spaces:
        yield step(snapshots.count_phase_space, row)
    for row in plan.snapshots:
        yield step(snapshots.record_snapshot, row)
    yield step(velocities.stop_clock, clock)


def _thinned(plan):
    """Yield the steps of grids that only absorb."""
    for row in plan.thinning_grids:
        row["ledger"] = layout.ABSORBED + len(plan.surfaces) + row["medium"]
        yield step(voxels.attenuate_in_grid, row)


def _absorbed(plan):
    """Yield the steps that add the media's absorption to the ledger: a pass per medium if there are few."""
    first = layout.ABSORBED + len(plan.surfaces)
    if len(plan.absorbing_media) > FEW_MEDIA:
        yield step(collisions.account_absorbed_everywhere, layout.row(layout.WEIGHED, ledger=first))
        return
    for medium in plan.absorbing_media:
        row = layout.row(layout.WEIGHED, medium=medium, ledger=first + medium)
        yield step(collisions.account_absorbed_in, row)


def _scattering(plan):
    """Yield the steps of scattering: next-event estimation, phase function, new direction."""
    yield from detours_of_collisions(plan)
    if len(plan.phase_laws) > 1:
        laws = np.array([row for _, row in plan.phase_laws], layout.PHASE_LAW)
        plan.kept.append(laws)
        both = {"rows": plan.media.ctypes.data, "count": len(plan.media)}
        both |= {"others": laws.ctypes.data, "other_count": len(laws)}
        yield step(collisions.choose_phase, layout.row(layout.TWO_ROWS, **both))
    if plan.counts_reflections:
        yield step(collisions.count_scatterings)
    yield from expected_of_collisions(plan)
    for name, law in plan.phase_laws:
        if name == "scatter_by_table":
            yield step(collisions.choose_segment_of_table, law)
        yield named((name, law))
