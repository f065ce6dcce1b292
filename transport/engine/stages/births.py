"""Steps of birth: place, direction, time and speed, and the state that later steps need."""

from transport.compile import layout
from transport.compile.media import importance_row
from transport.compile.surfaces import name_of
from transport.engine.passes import aims, detectors, emission, regions, variance_reduction
from transport.engine.registry import named, step
from transport.engine.stages.next_event import casts_of_births, expected_of_births
from transport.engine.stages.surfaces import metering, stood, visits

METERS = (1 << layout.METERS_A_SHEET) - 1


def newborn_of(plan, emitter):
    """Yield all steps of a particle born at one emitter."""
    # Place, direction, time, speed; aim at a target.
    yield step(emission.begin, emitter.birth)
    for each in (*emitter.cells, emitter.place):
        yield named(each)
    yield named(emitter.law)
    yield from _moment_and_speed(plan, emitter)
    if emitter.target is not None:
        if emitter.facing is not None:
            yield step(emission.take_normal, emitter.facing)
        for each in emitter.target:
            yield named(each)
        yield step(aims.account_born)
    # State that other passes need.
    if plan.reflects or plan.scatters:
        yield step(emission.begin_events)
    if emitter.inside is not None:
        yield step(regions.begin_inside, emitter.inside)
    for row in emitter.beside:
        yield step(regions.begin_beside, row)
    if emitter.medium is not None:
        yield step(emission.begin_in_medium, emitter.medium)
    if plan.plays_roulette:
        yield step(emission.remember_birth_weight)
    if plan.splits:
        yield step(variance_reduction.begin_where_important, importance_row(plan))
    if plan.forces:
        yield step(variance_reduction.begin_fresh)
    if plan.marks:
        yield step(emission.begin_visits)
    if plan.counts_reflections:
        yield step(emission.begin_reflections)
    # Next-event estimation, and detectors on the emitting sheet.
    yield from casts_of_births(plan, emitter)
    yield from expected_of_births(plan, emitter)
    sheet = emitter.birth["sheet"]
    metered = [
        (row, shape) for _, row, shape in plan.members if row["sheet"] == sheet and row["code"] & METERS
    ]
    if metered and emitter.place[0] != "born_at_point" and plan.turned is None:
        yield from _birth_counted(plan, emitter, metered)


def _moment_and_speed(plan, emitter):
    """Yield the steps of time and speed of birth; one random block serves both where possible."""
    moment, steps = emitter.moment, emitter.speed if plan.has_speeds else ()
    draws = steps and steps[0][0] == "draw_speed"
    if plan.has_clock and moment[0] == "start_within" and draws:
        moment, steps = ("start_within_and_draw", moment[1]), steps[1:]
    if plan.has_clock:
        yield named(moment)
    for each in steps:
        yield named(each)


def _birth_counted(plan, emitter, metered):
    """Yield the steps that score a birth as a departure at the detectors of its sheet."""
    if emitter.target is not None:
        yield step(emission.visit_birthplace)
    yield step(emission.stand_at_birth, emitter.birth)
    for row, shape in metered:
        if shape == emitter.shape or shape.is_closed or shape.is_infinite:
            yield step(emission.born_all_over, layout.row(layout.CODE, code=row["code"]))
        else:
            yield named((f"born_over_{name_of(shape)}", row))
    yield from stood(plan)
    yield from metering(plan, detectors.bin_departures, is_born=True)
    yield from visits(plan)
    if emitter.target is not None:
        yield step(emission.return_to_target)
