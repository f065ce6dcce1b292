"""Steps of birth: place, direction, time and speed, and the state that later steps need."""

from transport.compile import layout
from transport.compile.media import importance_row
from transport.compile.shapes import pass_name
from transport.engine.passes import aims, detectors, emission, guides, regions, variance_reduction
from transport.engine.registry import step, step_by_name
from transport.engine.stages.next_event import rays_from_births
from transport.engine.stages.quasi_random import GUIDED, quasi_random_steps
from transport.engine.stages.surfaces import land_on_surface, mark_visits, score_detectors

ON_SIDE = "_on_side"  # how names of passes of surfaces that share a plane end
DETECTOR_BITS = (1 << layout.DETECTORS_PER_SHEET) - 1


def birth_steps(plan, emitter, guide=None, records=False):
    """Yield all steps of a particle born at one emitter.

    guide: table of its learnt density; records: whether to record what it is born from.
    """
    # Place, direction, time, speed; aim at a target.
    yield step(emission.start_history, emitter.birth)
    sampled = [step_by_name(each) for each in (*emitter.cells, emitter.place, emitter.law)]
    if guide is not None:
        yield step(guides.draw_guided_birth, guide)
        if records:
            yield step(guides.record_birth, guide)
        sampled = quasi_random_steps(sampled, GUIDED)
    yield from sampled
    yield from _time_and_speed(plan, emitter)
    if emitter.target is not None:
        if emitter.facing is not None:
            yield step(emission.set_emission_normal, emitter.facing)
        for each in emitter.target:
            yield step_by_name(each)
    if emitter.target is not None or guide is not None:
        yield step(aims.account_births)
        yield step(aims.note_heaviest_birth)
    yield from _end_covered_births(plan, emitter)
    # State that other passes need.
    if plan.reflects or plan.scatters or plan.expectations:
        yield step(emission.reset_events)
    if emitter.inside is not None:
        yield step(regions.set_birth_bodies, emitter.inside)
    for row in emitter.beside:
        yield step(regions.leave_birth_body, row)
    if emitter.medium is not None:
        yield step(emission.set_birth_index, emitter.medium)
    if plan.plays_roulette:
        yield step(emission.save_birth_weight)
    if plan.splits:
        yield step(variance_reduction.set_reference_weight, importance_row(plan))
    if plan.forces_collisions:
        yield step(variance_reduction.mark_uncollided)
    if plan.marks:
        yield step(emission.reset_visits)
    if plan.counts_reflections:
        yield step(emission.reset_reflections)
    for score in plan.long_scores:
        for called in score.at_birth:
            yield step_by_name(called)
    # Next-event estimation, and detectors on the emitting sheet.
    yield from rays_from_births(plan, emitter)
    if emitter.place[0] != "born_at_point" and plan.adjoint is None:
        beneath = list(_rows_beneath(plan, emitter))
        if any(row["covers"] & DETECTOR_BITS for row, _ in beneath):
            yield from _score_birth(plan, emitter, beneath)


def _end_covered_births(plan, emitter):
    """Yield the steps that end births of a surface where others cover the side that emits."""
    covering = list(_covering_rows(plan, emitter))
    if covering and emitter.target is not None:
        yield step(emission.move_to_birthplace)
    for name, row, surface in covering:
        yield step(emission.hit_birth_sheet, emitter.birth)
        if name == "plane":
            yield step(emission.born_all_over, layout.row(layout.BITS, bits=row["covers"]))
        else:
            yield step_by_name((f"born_over_{name}", row))
        ledger = layout.row(layout.LEDGER_ROW, ledger=layout.ABSORBED + surface)
        yield step(emission.absorb_covered_births, ledger)
    if covering and emitter.target is not None:
        yield step(emission.move_to_target)


def _covering_rows(plan, emitter):
    """Yield name, row and surface of what acts instead of an emitter's own surface on the side that emits.

    Only a surface that a source or detector names can be covered; what emits or counts by itself lies on top.
    """
    source = emitter.source
    if not isinstance(source.shape, str) or not emitter.shape.is_flat:
        return
    own = next(k for k, each in enumerate(plan.scene.surfaces) if each.name == source.shape)
    for name, row, _ in plan.members:
        if row["sheet"] == emitter.birth["sheet"] and _acts_where_emitted(name, row, emitter):
            surface = layout.surface_of_hit(row["hit"])
            if plan.surface_numbers[surface - 1] == own:
                return
            covering = row.copy()
            covering["covers"] = 1
            yield name.removeprefix("meet_").removesuffix(ON_SIDE), covering, surface


def _acts_where_emitted(name, row, emitter):
    """Return whether a row is of a surface on a shared plane that acts where a source emits."""
    if not name.endswith(ON_SIDE):
        return False
    normal = (float(row[axis]) for axis in ("nx", "ny", "nz"))
    along = sum(n * x for n, x in zip(normal, emitter.shape.normal, strict=True))
    return row["side"] * (-along if emitter.source.is_back else along) >= 0


def _rows_beneath(plan, emitter):
    """Yield row and shape of what a birth may lie on: surfaces in the order of precedence, and detectors.

    Of surfaces that share a plane only those on the side that emits; of these the first at a place counts.
    """
    for name, row, shape in plan.members:
        if row["sheet"] != emitter.birth["sheet"]:
            continue
        if _acts_where_emitted(name, row, emitter):
            first = row.copy()
            first["covers"] |= layout.TAKEN
            yield first, shape
        elif row["covers"] & DETECTOR_BITS and not name.endswith(ON_SIDE):
            yield row, shape


def _time_and_speed(plan, emitter):
    """Yield the steps of time and speed of birth; one random block serves both where possible."""
    moment, steps = emitter.moment, emitter.speed if plan.has_speeds else ()
    draws = steps and steps[0][0] == "draw_speed_uniform"
    if plan.has_clock and moment[0] == "sample_birth_time" and draws:
        moment, steps = ("sample_birth_time_and_speed", moment[1]), steps[1:]
    if plan.has_clock:
        yield step_by_name(moment)
    for each in steps:
        yield step_by_name(each)


def _score_birth(plan, emitter, beneath):
    """Yield the steps that score a birth as a departure at the detectors of its sheet."""
    if emitter.target is not None:
        yield step(emission.move_to_birthplace)
    yield step(emission.hit_birth_sheet, emitter.birth)
    for row, shape in beneath:
        if shape == emitter.shape or shape.is_closed or shape.is_infinite:
            yield step(emission.born_all_over, layout.row(layout.BITS, bits=row["covers"]))
        else:
            yield step_by_name((f"born_over_{pass_name(shape)}", row))
    yield from land_on_surface(plan)
    yield from score_detectors(plan, detectors.bin_departures, is_born=True)
    yield from mark_visits(plan)
    if emitter.target is not None:
        yield step(emission.move_to_target)
