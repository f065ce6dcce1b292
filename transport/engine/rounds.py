"""The steps of a flight: how lanes get ready, what they look for, what a medium and the clock do on the way.

In media these are done again and again for what collides, before those that met a surface go on (driver.fly_on).
"""

import numpy as np

from transport.compile import layout
from transport.compile.media import importance_row, roulette_row
from transport.compile.strays import bounded_rows
from transport.engine import (
    bank,
    bodies,
    clocks,
    collisions,
    flats,
    flights,
    forcing,
    grids,
    importances,
    roulette,
    snapshots,
    surfaces,
    volume_steps,
)
from transport.engine.expectations import expected_of_collisions, guards
from transport.engine.lookouts import casts_of_flights, detours_of_collisions
from transport.engine.registry import named, rows_of, step

PARALLEL = 1.0 - 2.0**-52  # cosine between the normals of parallel planes
FEW_MEDIA = 4  # which are told, and whose absorption is summed up, one by one


def ready_to_fly(plan):
    """What lanes must know before they fly: that nothing is met yet, and the medium that they are in."""
    if not plan.has_media:
        return
    if plan.scatters:
        yield step(collisions.set_out)
    yield from known_media(plan)


def known_media(plan):
    """The medium that each lane is in."""
    if not plan.has_media:
        return
    if len(plan.media) > FEW_MEDIA:
        yield step(bodies.know_bodies, rows_of(plan.media))
        return
    yield step(bodies.know_surroundings, _body(plan, 0))
    for medium in range(len(plan.media) - 1, 0, -1):
        yield step(bodies.know_body, _body(plan, medium))


def _body(plan, medium):
    values = {name: plan.media[name][medium] for name in ("mfp", "sigma_a", "survival")}
    return layout.row(layout.BODY, **values, medium=medium, bit=1 << medium >> 1)


def rounds_of(plan, moved):
    """The steps of a flight as far as a surface or a collision."""
    importance = importance_row(plan) if plan.splits else None
    if plan.forces:
        yield step(forcing.fly_or_be_forced)
    elif plan.scatters:
        yield step(grids.fly_in_grids if plan.grids else collisions.fly)
    else:
        yield step(collisions.fly_straight if plan.has_media else flights.look_ahead)
    if plan.splits:
        yield step(importances.cut_flight, importance)
    yield from members_of(plan)
    yield from _strays(plan)
    if plan.forces:
        yield step(forcing.force_collision)
        yield step(bank.deposit_forced, moved)
    if plan.grids and not plan.splits:
        yield step(grids.cut_nothing)
    for row in plan.grids:
        yield step(grids.collide_in_grid, row)
    yield from casts_of_flights(plan)
    yield from volume_steps.ways(plan)
    yield from guards(plan)
    if plan.has_clock:
        yield from _clock(plan)
    if plan.attenuates:
        yield step(collisions.attenuate)
        yield from _absorbed(plan)
    yield from _thinned(plan)
    if plan.scatters:
        yield step(collisions.collide)
        if plan.splits:
            yield step(importances.pause_at_station)
        elif plan.grids:
            yield step(grids.pause)
        yield from volume_steps.collided(plan)
        if plan.absorbs_by_share:
            yield step(grids.absorb_share)
            yield from _absorbed(plan)
        if plan.absorbs_by_chance:
            yield step(collisions.absorb_by_chance)
            yield from _absorbed(plan)
        if plan.has_roulette_in_flight:
            yield step(roulette.play_roulette_in_flight, roulette_row(plan))
        yield from _scattering(plan)
        if plan.splits:
            yield step(importances.weigh_by_importance, importance)
            yield step(bank.deposit, moved)
        yield step(surfaces.give_up)


def _strays(plan):
    """Those in a finite body that have no surface ahead: one body by one where they are few."""
    if not plan.has_bodies:
        return
    rows = bounded_rows(plan)
    finite = [row for row in rows if row["bit"] != 0]
    if len(finite) > FEW_MEDIA:
        plan.kept.append(np.array(rows, layout.BOUNDED))
        yield step(bodies.lose_strays_of_many, rows_of(plan.kept[-1]))
        return
    for row in finite:
        yield step(bodies.lose_strays, row)


def members_of(plan):
    """Look for each surface and meter; parallel planes in pairs."""
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
    clock = layout.row(layout.CLOCK, duration=1.0, slowness=plan.slowness)
    if plan.has_media:
        rows = {"rows": plan.media.ctypes.data, "count": len(plan.media)}
        law = layout.row(layout.MEDIA_CLOCK, slowness=plan.slowness, has_speeds=plan.has_speeds, **rows)
        yield step(clocks.time_arrival_in_media, law)
    else:
        yield step(clocks.time_arrival_by_speed) if plan.has_speeds else step(clocks.time_arrival, clock)
    for row in plan.phase_spaces:
        yield step(snapshots.count_phase_space, row)
    for row in plan.snapshots:
        yield step(snapshots.record_snapshot, row)
    yield step(clocks.stop_clock, clock)


def _thinned(plan):
    """Grids that only absorb."""
    for row in plan.thinning_grids:
        row["ledger"] = layout.ABSORBED + len(plan.surfaces) + row["medium"]
        yield step(grids.attenuate_in_grid, row)


def _absorbed(plan):
    """Enter what media keep into the ledger: one by one where they are few."""
    first = layout.ABSORBED + len(plan.surfaces)
    if len(plan.absorbing_media) > FEW_MEDIA:
        yield step(collisions.account_absorbed_everywhere, layout.row(layout.WEIGHED, ledger=first))
        return
    for medium in plan.absorbing_media:
        row = layout.row(layout.WEIGHED, medium=medium, ledger=first + medium)
        yield step(collisions.account_absorbed_in, row)


def _scattering(plan):
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
