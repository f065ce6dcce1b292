"""The steps of a flight: how lanes get ready, what they look for, what a medium and the clock do on the way.

In media these are done again and again for what collides, before those that met a surface go on (driver.fly_on).
"""

import numpy as np

from transport.compile import layout
from transport.engine import clocks, collisions, flights, snapshots, surfaces
from transport.engine.registry import named, step

FEW_MEDIA = 4  # whose absorption is summed up one by one


def rounds_of(plan):
    """How lanes get ready to fly, and then the steps of a flight as far as a surface or a collision."""
    if plan.scatters:
        yield step(collisions.set_out)
        yield step(collisions.fly)
    else:
        yield step(collisions.fly_straight if plan.has_media else flights.look_ahead)
    for name, row, _ in plan.members:
        yield named((name, row))
    if plan.has_clock:
        yield from _clock(plan)
    if plan.attenuates:
        yield step(collisions.attenuate)
        yield from _absorbed(plan)
    if plan.scatters:
        yield step(collisions.collide)
        if plan.absorbs_by_chance:
            yield step(collisions.absorb_by_chance)
            yield from _absorbed(plan)
        if plan.has_roulette_in_flight:
            law = layout.row(layout.ROULETTE_LAW, threshold=plan.tracking.roulette)
            yield step(collisions.play_roulette_in_flight, law)
        yield from _scattering(plan)
        yield step(surfaces.give_up)


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
    if len(plan.phase_laws) > 1:
        laws = np.array([row for _, row in plan.phase_laws], layout.PHASE_LAW)
        plan.kept.append(laws)
        both = {"rows": plan.media.ctypes.data, "count": len(plan.media)}
        both |= {"others": laws.ctypes.data, "other_count": len(laws)}
        yield step(collisions.choose_phase, layout.row(layout.TWO_ROWS, **both))
    for law in plan.phase_laws:
        yield named(law)
