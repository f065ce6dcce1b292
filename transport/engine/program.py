"""A program: the ordered list of the passes that a scene needs, each with its table."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from transport.compile import layout
from transport.compile.media import box_rows, importance_row, roulette_row
from transport.compile.plan import Plan
from transport.engine.bundle import CARRIED
from transport.engine.passes import (
    bvh,
    detectors,
    intersections,
    landing,
    lanes,
    optics,
    regions,
    surfaces,
    variance_reduction,
    velocities,
)
from transport.engine.registry import Pass, Step, rows_of, step
from transport.engine.stages.births import newborn_of
from transport.engine.stages.flights import known_media, members_of, ready_to_fly, rounds_of
from transport.engine.stages.next_event import casts_of_walls, expected_of_walls, expected_sight, sight_of
from transport.engine.stages.quasi_random import sampled_steps
from transport.engine.stages.surfaces import boundaries, expected_crossing, metering, stood, through, visits

BEYOND = layout.NOTHING_BEFORE | layout.NOTHING_BEHIND


@dataclass
class Program:
    """Passes with their tables: one list for all particles, one per emitter for births.

    A program keeps the tables alive that its steps point to.
    """

    plan: Plan
    steps: list[Step] = field(default_factory=list)
    ready: int = 0  # number of steps before a flight
    inner: int = 0  # number of steps after these that are repeated for lanes that collide in a medium
    births: list[list[Step]] = field(default_factory=list)
    # steps of shadow rays, where point or expected detectors exist
    sight: list[Step] = field(default_factory=list)
    withdrawal: list[Step] = field(default_factory=list)  # step by which banked copies take free lanes
    moved: np.ndarray = field(default_factory=lambda: np.zeros((), layout.MOVED))
    machine: object = None  # the compiled program (driver.machine_of), once made

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
        """Names of the fields that move with a particle: those that a pass uses."""
        named = {name for lane_pass in self.passes for name in lane_pass.fields}
        return tuple(name for name, _ in CARRIED if name in named)

    @cached_property
    def carried_numbers(self) -> np.ndarray:
        """Positions of these fields in CARRIED, padded; the table of `fill_gaps` points here."""
        numbers = [k for k, (name, _) in enumerate(CARRIED) if name in self.carried]
        return np.array(lanes.padded(numbers), np.int64)


def program_of(plan: Plan) -> Program:
    """Return the program of a scene's plan."""
    # Complete the bounding volume hierarchies of meshes.
    for table in plan.meshes.values():
        bvh.complete(table)
    program = Program(plan)
    program.births = [list(newborn_of(plan, emitter)) for emitter in plan.emitters]
    # Steps of flight: preparation, rounds through media, then move, land and act at a surface.
    ready, rounds = list(ready_to_fly(plan)), list(rounds_of(plan, program.moved))
    program.ready, program.inner = len(ready), len(rounds) if plan.scatters else 0
    program.steps = [
        *ready,
        *rounds,
        *_flight(plan, program.moved),
        *_landing(plan),
        *_crossing(plan, program.moved),
    ]
    # Steps of shadow rays: to point detectors, or to detectors scored by next-event estimation.
    if plan.points:
        program.sight = list(sight_of(plan, known_media(plan), members_of(plan), through(plan)))
    if plan.expectations:
        crossing = expected_crossing(plan)
        program.sight = list(expected_sight(plan, known_media(plan), members_of(plan), crossing))
    program.withdrawal = (
        [step(variance_reduction.withdraw, program.moved)] if plan.splits or plan.forces else []
    )
    # Replace pseudo-random draws by quasi-random ones.
    if plan.method.sampling != "random":
        _sample(program, plan.method.sampling)
    numbers = program.carried_numbers
    program.moved["fields"], program.moved["count"] = numbers.ctypes.data, len(numbers)
    return program


def _sample(program, sampling):
    """Replace each pass that draws by its twin for this sampling."""
    program.births = [sampled_steps(steps, sampling) for steps in program.births]
    for part in ("steps", "sight", "withdrawal"):
        setattr(program, part, sampled_steps(getattr(program, part), sampling))


def _flight(plan, moved):
    """Yield the steps from the end of a round to the surface: count escapes, compact lanes, move."""
    yield step(intersections.leave)
    yield step(lanes.part if plan.scatters else lanes.fill_gaps, moved)
    if plan.contacts:
        yield step(landing.remember_origin)
    if plan.passes_meters:
        yield step(intersections.remember_ray)
    yield step(intersections.move)


def _landing(plan):
    """Yield the steps that place a lane on its sheet: normal, cosine, corrections near edges and contacts."""
    if plan.members:
        yield from stood(plan)
        if plan.passes_meters and (plan.sheets["outward"] != 0).any():
            yield step(landing.tell_leaving, rows_of(plan.sheets))
        if plan.has_rims:
            yield step(landing.draw_back_from_edge, rows_of(plan.rims))
        for row in plan.contacts:
            yield step(landing.keep_to_side, row)


def _crossing(plan, moved):
    """Yield the steps at a surface: score arrivals, absorb, sample a new direction, score departures."""
    # Without an acting surface, a crossing is scored once and the lane flies on.
    if not plan.acts:
        yield from metering(plan, detectors.bin_crossings)
        yield from visits(plan)
        yield from boundaries(plan)
        yield from _onwards(plan)
        yield from _end(plan, moved)
        return
    # Score arrivals at detectors.
    yield from metering(plan, detectors.bin_arrivals)
    # Choose the material, absorb, and sample the new direction.
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
        yield step(velocities.take_wall_speed, rows_of(plan.surfaces))
    if plan.counts_reflections:
        yield step(surfaces.count_reflections)
    # Score departures; then visits, bodies beyond, shadow rays and next-event rays.
    yield from metering(plan, detectors.bin_departures, is_known=len(plan.layers) == 1)
    yield from visits(plan)
    yield from boundaries(plan)
    yield from casts_of_walls(plan)
    yield from expected_of_walls(plan)
    yield from _onwards(plan)
    # Russian roulette, and the limit of events.
    if plan.has_roulette:
        yield step(variance_reduction.play_roulette, roulette_row(plan))
    elif plan.splits and plan.reflects:
        yield step(variance_reduction.play_roulette_by_importance, importance_row(plan))
    if plan.reflects:
        yield step(surfaces.give_up)
    yield from _end(plan, moved)


def _onwards(plan):
    """Yield the steps that resume the ray of a lane that passed through, except at the edges of a box of
    medium.
    """
    if plan.passes_meters:
        yield step(intersections.resume_ray)
        if plan.bounds_bodies:
            for row in box_rows(plan):
                yield step(regions.settle_at_edges, row)


def _end(plan, moved):
    """Yield the steps that end lanes that left to empty space, and drop ended lanes."""
    escapes = plan.can_escape_at_once and any(row["code"] & BEYOND for _, row, _ in plan.members)
    if escapes:
        yield step(regions.escape_at_once)
    if escapes or (plan.acts and (plan.absorbs or plan.reflects)):
        yield step(lanes.fill_gaps, moved)


def _new_directions(plan):
    """Yield a pass per material; lanes of other materials stay unchanged."""
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
