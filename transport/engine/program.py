"""A program: the list of just the passes that a scene calls for, each with its table.  The order is on one screen."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from transport.compile import layout
from transport.compile.media import box_rows, importance_row, roulette_row
from transport.compile.plan import Plan
from transport.engine import (
    bank,
    bodies,
    flights,
    hierarchies,
    landings,
    lanes,
    meters,
    optics,
    rims,
    roulette,
    speeds,
    surfaces,
)
from transport.engine.arrivals import boundaries, metering, stood, visits
from transport.engine.bundle import CARRIED
from transport.engine.expectations import (
    expected_of_walls,
    expected_sight,
)
from transport.engine.lookouts import casts_of_walls, sight_of
from transport.engine.newborn import newborn_of
from transport.engine.passages import expected_crossing, through
from transport.engine.passes import Pass
from transport.engine.registry import Step, rows_of, step
from transport.engine.rounds import known_media, members_of, ready_to_fly, rounds_of
from transport.engine.sampled import sampled_steps

BEYOND = layout.NOTHING_BEFORE | layout.NOTHING_BEHIND


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
    program.births = [list(newborn_of(plan, emitter)) for emitter in plan.emitters]
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
        program.sight = list(sight_of(plan, known_media(plan), members_of(plan), through(plan)))
    if plan.expectations:
        crossing = expected_crossing(plan)
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


def _flight(plan, moved):
    yield step(flights.leave)
    yield step(lanes.part if plan.scatters else lanes.fill_gaps, moved)
    if plan.contacts:
        yield step(landings.remember_origin)
    if plan.passes_meters:
        yield step(flights.remember_ray)
    yield step(flights.move)


def _landing(plan):
    if plan.members:
        yield from stood(plan)
        if plan.passes_meters and (plan.sheets["outward"] != 0).any():
            yield step(landings.tell_leaving, rows_of(plan.sheets))
        if plan.has_rims:
            yield step(rims.draw_back_from_edge, rows_of(plan.rims))
        for row in plan.contacts:
            yield step(landings.keep_to_side, row)


def _crossing(plan, moved):
    if not plan.acts:
        yield from metering(plan, meters.bin_crossings)
        yield from visits(plan)
        yield from boundaries(plan)
        yield from _onwards(plan)
        yield from _end(plan, moved)
        return
    yield from metering(plan, meters.bin_arrivals)
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
    yield from metering(plan, meters.bin_departures, is_known=len(plan.layers) == 1)
    yield from visits(plan)
    yield from boundaries(plan)
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
