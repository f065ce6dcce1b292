"""A program: the list of just the passes that a scene calls for, each with its table.  The order is on one screen."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from transport.compile import layout
from transport.compile.media import box_rows, importance_row, roulette_row
from transport.compile.pieces import name_of
from transport.compile.plan import Plan
from transport.compile.sizes import size_row
from transport.engine import (
    aims,
    bank,
    birthplaces,
    births,
    bodies,
    expecting,
    flights,
    forcing,
    hierarchies,
    histories,
    importances,
    landings,
    lanes,
    meshes,
    meters,
    optics,
    quadrics,
    refinements,
    rims,
    roulette,
    sizes,
    speeds,
    surfaces,
)
from transport.engine.bundle import CARRIED
from transport.engine.expectations import (
    expected_of_births,
    expected_of_walls,
    expected_sight,
    expects_on,
    given_back,
    held_back,
)
from transport.engine.lookouts import casts_of_births, casts_of_walls, sight_of
from transport.engine.passes import Pass
from transport.engine.registry import Step, layer_of, named, rows_of, step
from transport.engine.rounds import known_media, members_of, ready_to_fly, rounds_of
from transport.engine.sampled import sampled_steps

BEYOND = layout.NOTHING_BEFORE | layout.NOTHING_BEHIND
METERS = (1 << layout.METERS_A_SHEET) - 1
# Times and speeds lie in blocks, so they come first.
REFINEMENTS = ("time", "speed", "cosine", "azimuth", "place", "cell")


@dataclass
class Program:
    """Steps of every particle, and for each emitter the steps of its newborn; holds the tables that they point to."""

    plan: Plan
    steps: list[Step] = field(default_factory=list)
    ready: int = 0  # how many steps come before a flight
    inner: int = 0  # how many steps after these are done again for what collides in a medium
    births: list[list[Step]] = field(default_factory=list)
    sight: list[Step] = field(default_factory=list)  # of shadow rays, where there are point detectors
    withdrawal: list[Step] = field(default_factory=list)  # by which copies that wait take lanes
    moved: np.ndarray = field(default_factory=lambda: np.zeros((), layout.MOVED))
    machine: object = None  # driver.machine_of it, once it is made

    @property
    def passes(self) -> list[Pass]:
        """Every pass once, in order of first use."""
        return list(
            dict.fromkeys(
                p for part in (*self.births, self.steps, self.sight, self.withdrawal) for p, _ in part
            )
        )

    @cached_property
    def carried(self) -> tuple[str, ...]:
        """The fields that a particle takes along: those that a pass names."""
        named = {name for lane_pass in self.passes for name in lane_pass.fields}
        return tuple(name for name, _ in CARRIED if name in named)

    @cached_property
    def carried_numbers(self) -> np.ndarray:
        """Their numbers among CARRIED; the table of `fill_gaps` points here."""
        numbers = [k for k, (name, _) in enumerate(CARRIED) if name in self.carried]
        return np.array(lanes.padded(numbers), np.int64)


def program_of(plan: Plan) -> Program:
    """The program of a scene's plan."""
    for table in plan.meshes.values():
        hierarchies.complete(table)
    program = Program(plan)
    program.births = [list(_births(plan, emitter)) for emitter in plan.emitters]
    ready, rounds = list(ready_to_fly(plan)), list(rounds_of(plan, program.moved))
    program.ready, program.inner = len(ready), len(rounds) if plan.scatters else 0
    program.steps = [
        *ready,
        *rounds,
        *_flight(plan, program.moved),
        *_landing(plan),
        *_crossing(plan, program.moved),
    ]
    if plan.points:
        program.sight = list(sight_of(plan, known_media(plan), members_of(plan), _through(plan)))
    if plan.expectations:
        crossing = _expected_crossing(plan)
        program.sight = list(expected_sight(plan, known_media(plan), members_of(plan), crossing))
    program.withdrawal = [step(bank.withdraw, program.moved)] if plan.splits or plan.forces else []
    if plan.method.sampling != "random":
        _sample(program, plan.method.sampling)
    numbers = program.carried_numbers
    program.moved["fields"], program.moved["count"] = numbers.ctypes.data, len(numbers)
    return program


def _sample(program, sampling):
    """Every draw as a sampling makes it."""
    program.births = [sampled_steps(steps, sampling) for steps in program.births]
    for part in ("steps", "sight", "withdrawal"):
        setattr(program, part, sampled_steps(getattr(program, part), sampling))


def _births(plan, emitter):
    yield step(births.begin, emitter.birth)
    for each in (*emitter.cells, emitter.place):
        yield named(each)
    yield named(emitter.law)
    yield from _moment_and_speed(plan, emitter)
    if emitter.target is not None:
        if emitter.facing is not None:
            yield step(births.take_normal, emitter.facing)
        for each in emitter.target:
            yield named(each)
        yield step(aims.account_born)
    if plan.reflects or plan.scatters:
        yield step(births.begin_events)
    if emitter.inside is not None:
        yield step(bodies.begin_inside, emitter.inside)
    for row in emitter.beside:
        yield step(bodies.begin_beside, row)
    if emitter.medium is not None:
        yield step(births.begin_in_medium, emitter.medium)
    if plan.plays_roulette:
        yield step(births.remember_birth_weight)
    if plan.splits:
        yield step(importances.begin_where_important, importance_row(plan))
    if plan.forces:
        yield step(forcing.begin_fresh)
    if plan.marks:
        yield step(births.begin_visits)
    if plan.counts_reflections:
        yield step(births.begin_reflections)
    yield from casts_of_births(plan, emitter)
    yield from expected_of_births(plan, emitter)
    sheet = emitter.birth["sheet"]
    metered = [
        (row, shape) for _, row, shape in plan.members if row["sheet"] == sheet and row["code"] & METERS
    ]
    if metered and emitter.place[0] != "born_at_point" and plan.turned is None:
        yield from _birth_counted(plan, emitter, metered)


def _moment_and_speed(plan, emitter):
    """When and how fast; one random block serves both where it can."""
    moment, steps = emitter.moment, emitter.speed if plan.has_speeds else ()
    draws = steps and steps[0][0] == "draw_speed"
    if plan.has_clock and moment[0] == "start_within" and draws:
        moment, steps = ("start_within_and_draw", moment[1]), steps[1:]
    if plan.has_clock:
        yield named(moment)
    for each in steps:
        yield named(each)


def _birth_counted(plan, emitter, metered):
    if emitter.target is not None:
        yield step(birthplaces.visit_birthplace)
    yield step(birthplaces.stand_at_birth, emitter.birth)
    for row, shape in metered:
        if shape == emitter.shape or shape.is_closed or shape.is_infinite:
            yield step(birthplaces.born_all_over, layout.row(layout.CODE, code=row["code"]))
        else:
            yield named((f"born_over_{name_of(shape)}", row))
    yield from _stand(plan)
    yield from _metering(plan, meters.bin_departures, is_born=True)
    yield from _visits(plan)
    if emitter.target is not None:
        yield step(birthplaces.return_to_target)


def _flight(plan, moved):
    yield step(flights.leave)
    yield step(lanes.part if plan.scatters else lanes.fill_gaps, moved)
    if plan.contacts:
        yield step(landings.remember_origin)
    if plan.passes_meters:
        yield step(flights.remember_ray)
    yield step(flights.move)


def _through(plan):
    """Steps of a shadow ray through what lets it pass, to the other side of the same ray."""
    if any(name.startswith(("cover", "bound")) for name, *_ in plan.members):
        yield step(flights.remember_ray)
        yield step(flights.move)
        yield from _stand(plan)
        if (plan.sheets["outward"] != 0).any():
            yield step(landings.tell_leaving, rows_of(plan.sheets))
        yield from _boundaries(plan)
        yield step(flights.resume_ray)


def _expected_crossing(plan):
    """Steps of an expected ray from arriving at a surface to leaving it, through what lets it pass."""
    passes = any(name.startswith(("cover", "bound")) for name, *_ in plan.members)
    if passes:
        yield step(flights.remember_ray)
    yield step(flights.move)
    yield from _stand(plan)
    if passes and (plan.sheets["outward"] != 0).any():
        yield step(landings.tell_leaving, rows_of(plan.sheets))
    for layer in range(len(plan.layers)):
        yield from _expected_metering(plan, layer)
    yield from _visits(plan)
    yield step(expecting.end_expected)
    yield from _boundaries(plan)
    if passes:
        yield step(flights.resume_ray)


def _expected_metering(plan, layer):
    """Count what rays bring to the meters of a layer that they were cast to, on both sides of what lets them pass."""
    if not expects_on(plan, layer):
        return
    table = layer_of(plan, layer, plan.expected_layers[layer])
    yield step(meters.look_up_meter, table)
    yield step(expecting.look_at_target_alone)
    for binning in (meters.bin_arrivals, meters.bin_departures) if plan.acts else (meters.bin_crossings,):
        if binning is meters.bin_departures:
            yield step(expecting.look_through)
        yield step(binning, table)
        yield from _refined(plan, table)
        yield _scored(plan)
    yield step(expecting.pass_target, table)


def _landing(plan):
    if plan.members:
        yield from _stand(plan)
        if plan.passes_meters and (plan.sheets["outward"] != 0).any():
            yield step(landings.tell_leaving, rows_of(plan.sheets))
        if plan.has_rims:
            yield step(rims.draw_back_from_edge, rows_of(plan.rims))
        for row in plan.contacts:
            yield step(landings.keep_to_side, row)


def _stand(plan):
    yield step(landings.stand_on_sheet, rows_of(plan.sheets))
    if plan.is_curved:
        yield step(landings.put_back_on_sphere, rows_of(plan.sheets))
    if plan.has_quadrics:
        yield step(quadrics.put_back_on_quadric, rows_of(plan.curved_sheets))
    if plan.meshes:
        yield step(meshes.stand_on_facet, rows_of(plan.meshed_sheets))
    yield step(landings.take_cosine)


def _crossing(plan, moved):
    if not plan.acts:
        yield from _metering(plan, meters.bin_crossings)
        yield from _visits(plan)
        yield from _boundaries(plan)
        yield from _onwards(plan)
        yield from _end(plan, moved)
        return
    yield from _metering(plan, meters.bin_arrivals)
    if plan.draws_again:
        yield step(surfaces.draw_again)
    if plan.chooses:
        both = {
            "rows": plan.surfaces.ctypes.data,
            "count": len(plan.surfaces),
            "others": plan.optics.ctypes.data,
            "other_count": len(plan.optics),
        }
        yield step(surfaces.choose_part, layout.row(layout.TWO_ROWS, **both))
    yield step(surfaces.look_up_surface, rows_of(plan.surfaces))
    if plan.has_optics:
        yield step(optics.look_up_optics, rows_of(plan.optics))
    if plan.absorbs:
        yield step(surfaces.absorb)
        yield step(surfaces.account_absorbed)
    if plan.draws:
        yield step(surfaces.draw)
    yield from _new_directions(plan)
    if plan.has_thermal_walls:
        yield step(speeds.take_wall_speed, rows_of(plan.surfaces))
    if plan.counts_reflections:
        yield step(surfaces.count_reflections)
    yield from _metering(plan, meters.bin_departures, is_known=len(plan.layers) == 1)
    yield from _visits(plan)
    yield from _boundaries(plan)
    yield from casts_of_walls(plan)
    yield from expected_of_walls(plan)
    yield from _onwards(plan)
    if plan.has_roulette:
        yield step(roulette.play_roulette, roulette_row(plan))
    elif plan.splits and plan.reflects:
        yield step(roulette.play_roulette_by_importance, importance_row(plan))
    if plan.reflects:
        yield step(surfaces.give_up)
    yield from _end(plan, moved)


def _onwards(plan):
    """What passes flies on along its old ray, but for what came to the edges of a box of fog."""
    if plan.passes_meters:
        yield step(flights.resume_ray)
        if plan.bounds_bodies:
            for row in box_rows(plan):
                yield step(bodies.settle_at_edges, row)


def _end(plan, moved):
    """What left to where nothing is has escaped; the ended lanes are dropped."""
    escapes = plan.can_escape_at_once and any(row["code"] & BEYOND for _, row, _ in plan.members)
    if escapes:
        yield step(bodies.escape_at_once)
    if escapes or (plan.acts and (plan.absorbs or plan.reflects)):
        yield step(lanes.fill_gaps, moved)


def _new_directions(plan):
    """What each material does; lanes of the others are left as they are."""
    if plan.transmits:
        yield step(optics.choose_to_pass)
    if layout.DIFFUSE in plan.materials:
        yield step(surfaces.reflect_diffusely)
    if layout.MIRROR in plan.materials:
        yield step(surfaces.reflect_specularly)
    if plan.transmits:
        yield step(optics.let_pass)
    if layout.DIELECTRIC in plan.materials:
        yield step(optics.refract)
    if layout.GLOSSY in plan.materials:
        yield step(optics.reflect_glossily)
        yield step(optics.spread_lobe, rows_of(plan.optics))
    if layout.LENS in plan.materials:
        yield step(optics.bend_by_lens, rows_of(plan.optics))


def _metering(plan, binning, is_known=False, is_born=False):
    """Count at every layer's meters; is_known: the lanes have looked up their only meter at this crossing already.

    is_born: they leave their birthplace.
    """
    for layer, rows in enumerate(plan.layers):
        table = layer_of(plan, layer)
        if not (rows["look"] != 0).any():
            continue
        if not is_known:
            yield step(meters.look_up_meter, table)
        if not is_born:
            yield from held_back(plan, layer, passing=binning is meters.bin_departures)
        yield step(binning, table)
        yield from _refined(plan, table)
        is_dense = bool((rows[1:]["look"] != 0).all())
        yield _scored(plan, is_dense and plan.acts)
        if plan.moments is not None:
            yield step(meters.score_moments, plan.moments)
        if not is_born:
            yield from given_back(plan, layer)


def _scored(plan, is_dense=False):
    """Enter the scores into their rows, and count their sizes where these differ."""
    if plan.size_cells:
        return step(sizes.score_all_and_size if is_dense else sizes.score_and_size, size_row(plan))
    return step(meters.score_all if is_dense else meters.score)


def _refined(plan, table):
    """The finer bins of a layer's meters, and what they ask of a history."""
    if plan.axes | plan.filters:
        yield step(refinements.know_meter, table)
    for what in sorted(plan.filters):
        yield named((f"require_{what}", table))
    for axis in REFINEMENTS:
        if axis in plan.axes:
            yield named((f"refine_by_{axis}", table))


def _visits(plan):
    """Mark what detectors ask for in `via`, after all meters of this crossing."""
    for layer, rows in enumerate(plan.layers):
        if (rows["mark"] != 0).any():
            yield step(histories.mark_visit, layer_of(plan, layer))


def _boundaries(plan):
    """Know the bodies on the side that lanes leave to."""
    if plan.bounds_bodies:
        for layer, rows in enumerate(plan.layers):
            if (rows["front"] != rows["back"]).any():
                yield step(bodies.cross_boundary, layer_of(plan, layer))
