"""A program: the ordered list of the passes that a scene needs, each with its table."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from transport.compile import layout
from transport.compile.guides import Guide
from transport.compile.media import box_rows, importance_row, roulette_row
from transport.compile.plan import Plan
from transport.engine.bundle import CARRIED
from transport.engine.passes import (
    bank,
    bvh,
    detectors,
    gloss,
    guides,
    intersections,
    landing,
    lanes,
    optics,
    regions,
    score_sizes,
    surfaces,
    variance_reduction,
    velocities,
)
from transport.engine.registry import Pass, step, step_by_name
from transport.engine.stages.births import birth_steps
from transport.engine.stages.flights import find_media, flight_steps, intersect_surfaces
from transport.engine.stages.next_event import load_rays, ray_steps, rays_from_walls
from transport.engine.stages.quasi_random import quasi_random_steps
from transport.engine.stages.surfaces import (
    cross_media,
    cross_shadow_rays,
    land_on_surface,
    mark_visits,
    score_detectors,
)

EMPTY_SIDES = layout.EMPTY_FRONT | layout.EMPTY_BACK
# fields of the current medium, found anew after a surface, and of the next hit, found anew after a collision
MEDIUM, NEXT_HIT = ("medium", "mfp", "sigma_a", "survival"), ("distance", "hit", "covered", "facet")


@dataclass
class Program:
    """Passes, each with the offset of its table in the arena of the plan: one list for all particles, one per
    emitter for births.

    Passes are pickled by name, and compiled or loaded again elsewhere.
    """

    plan: Plan
    steps: list[tuple[Pass, int]] = field(default_factory=list)
    # number of steps of lanes that begin to fly, in media that scatter, and number of those after these of
    # all lanes in flight; lanes at a surface take the others
    setup_count: int = 0
    round_count: int = 0
    births: list[list[tuple[Pass, int]]] = field(default_factory=list)
    # steps of shadow rays, where point or expected detectors exist
    shadow_steps: list[tuple[Pass, int]] = field(default_factory=list)
    # step by which banked copies take free lanes
    bank_steps: list[tuple[Pass, int]] = field(default_factory=list)
    moved_fields: np.ndarray = field(default_factory=lambda: np.zeros((), layout.FIELD_MOVES))
    queue: np.ndarray = field(default_factory=lambda: np.zeros((), layout.QUEUE))
    sums_per_history: int = 0  # sums of its own that each history has
    compiled: object = None  # the compiled program (driver.compile_program), once made

    def __getstate__(self) -> dict:
        return vars(self) | {"compiled": None}

    @property
    def passes(self) -> list[Pass]:
        """Every pass once, in order of first use."""
        parts = (*self.births, self.steps, self.shadow_steps, self.bank_steps)
        return list(dict.fromkeys(lane_pass for part in parts for lane_pass, _ in part))

    @cached_property
    def carried(self) -> tuple[str, ...]:
        """Names of the fields that move with a particle: those that a pass or a long score reads.

        Passes that find the medium read what they write, for other lanes.
        """
        named = {
            name
            for lane_pass in self.passes
            for name in lane_pass.reads
            if not (name in MEDIUM and name in lane_pass.writes)
        }
        named |= {name for score in self.plan.long_scores for name in score.fields}
        if not self.plan.scatters:
            named -= set(MEDIUM)  # found anew for each flight
        return tuple(name for name, _ in CARRIED if name in named)

    def moves_without(self, unused: tuple[str, ...]) -> np.ndarray:
        """Return a row of layout.FIELD_MOVES: the carried fields, by their positions in CARRIED."""
        names = [name for name in self.carried if name not in unused]
        numbers = lanes.pad_group([k for k, (name, _) in enumerate(CARRIED) if name in names])
        place = self.plan.arena.place(np.array(numbers, np.int64))
        return layout.row(layout.FIELD_MOVES, fields=place, count=len(numbers))


def build_program(plan: Plan, densities: list[Guide] = (), sums: np.ndarray | None = None) -> Program:
    """Return the program of a scene's plan.

    densities: of each emitter's births, where they are guided. sums: table of the sums that each history has
    of its own (layout.HISTORY_SUMS), where guides are learnt.
    """
    # Complete the bounding volume hierarchies of meshes.
    for table in plan.meshes.values():
        bvh.build_mesh(table)
        table.place(plan.arena)
    program = Program(plan)
    rows = [guide.row(plan.arena, number) for number, guide in enumerate(densities)] or [None] * len(
        plan.emitters
    )
    program.births = [
        list(birth_steps(plan, emitter, row, sums is not None))
        for emitter, row in zip(plan.emitters, rows, strict=True)
    ]
    # Steps of flight: preparation, rounds through media, then move, land and act at a surface.
    moved = program.moved_fields
    ready, rounds = list(find_media(plan)), list(flight_steps(plan, moved))
    arrived = [*_flight(plan, moved), *_landing(plan), *_crossing(plan, moved)]
    if sums is not None:
        program.sums_per_history = int(sums["count"])
        program.births = [_add_to_history(steps, sums) for steps in program.births]
        rounds, arrived = _add_to_history(rounds, sums), _add_to_history(arrived, sums)
    if plan.scatters:
        rounds.append(step(lanes.queue_arrivals, program.queue))
        arrived.append(step(lanes.resume_flights, program.queue["arriving"]))
    else:
        ready, rounds, arrived = [], [*ready, *rounds, *arrived], []
    program.setup_count, program.round_count = len(ready), len(rounds)
    program.steps = [*ready, *rounds, *arrived]
    # Steps of shadow rays: to point detectors, or to detectors scored by next-event estimation.
    if plan.targets:
        nearest = [*find_media(plan), *intersect_surfaces(plan)]
        program.shadow_steps = ray_steps(plan, nearest, cross_shadow_rays(plan))
        if sums is not None:
            program.shadow_steps = _add_to_history(program.shadow_steps, sums)
        program.shadow_steps.insert(0, load_rays(plan, program.shadow_steps))
    if plan.splits or plan.forces_collisions:
        program.bank_steps = [step(bank.take_copies, program.moved_fields)]
    # Replace pseudo-random draws by quasi-random ones.
    if plan.method.sampling != "random":
        change_steps(program, partial(quasi_random_steps, sampling=plan.method.sampling))
    program.moved_fields[...] = program.moves_without(())
    program.queue["arriving"] = program.moves_without(MEDIUM)
    program.queue["flying"] = program.moves_without(NEXT_HIT)
    place = plan.arena.place
    change_steps(program, lambda steps: [(lane_pass, place(table)) for lane_pass, table in steps])
    return program


def change_steps(program: Program, change: Callable[[list], list]) -> None:
    """Replace each list of steps by what a function makes of it."""
    program.births = [change(steps) for steps in program.births]
    for part in ("steps", "shadow_steps", "bank_steps"):
        setattr(program, part, change(getattr(program, part)))


def _add_to_history(steps, sums):
    """Return the steps with each score added to the sums of its history, too."""
    scores = detectors.score, detectors.score_all, score_sizes.score_and_size, score_sizes.score_all_and_size
    return [
        each
        for lane_pass, table in steps
        for each in [(lane_pass, table)] + [step(guides.add_to_history, sums)] * (lane_pass in scores)
    ]


def _flight(plan, moved):
    """Yield the steps from the end of a round to the surface: count escapes, compact lanes, move."""
    yield step(intersections.end_not_finite)
    yield step(intersections.end_escaped)
    if not plan.scatters:
        yield step(lanes.compact_lanes, moved)
    if plan.contacts:
        yield step(landing.save_origin)
    if plan.crosses_detectors:
        yield step(intersections.save_ray)
    yield step(intersections.move)


def _landing(plan):
    """Yield the steps that place a lane on its sheet: normal, cosine, corrections near edges and contacts."""
    if plan.members:
        yield from land_on_surface(plan)
        if plan.crosses_detectors and (plan.sheets["outward"] != 0).any():
            yield step(landing.mark_box_exit, plan.arena.table(plan.sheets))
        if plan.has_rims:
            yield step(landing.clamp_inside_edge, plan.arena.table(plan.rims))
        for row in plan.contacts:
            yield step(landing.keep_to_side, row)


def _crossing(plan, moved):
    """Yield the steps at a surface: score arrivals, absorb, sample a new direction, score departures."""
    # Without an acting surface, a crossing is scored once and the lane flies on.
    if not plan.has_acting_surfaces:
        yield from score_detectors(plan, detectors.bin_crossings)
        yield from mark_visits(plan)
        yield from cross_media(plan)
        yield from _resume_rays(plan)
        yield from _end_lanes(plan, moved)
        return
    # Score arrivals at detectors.
    yield from score_detectors(plan, detectors.bin_arrivals)
    # Choose the material, absorb, and sample the new direction.
    if plan.needs_more_random_numbers:
        yield step(surfaces.draw_second_block)
    if plan.selects_material:
        yield step(surfaces.choose_material, plan.arena.table(plan.surfaces, plan.optics))
    yield step(surfaces.look_up_surface, plan.arena.table(plan.surfaces))
    for law in sorted(plan.albedo_laws):
        yield step_by_name((f"look_up_{law}", plan.arena.table(plan.optics)))
        yield step_by_name((f"reflect_by_{law}", layout.row(layout.NO_TABLE)))
    if plan.has_optics:
        yield step(optics.look_up_optics, plan.arena.table(plan.optics))
    if plan.absorbs:
        yield step(surfaces.absorb)
        yield step(surfaces.account_absorbed)
    if plan.needs_random_numbers:
        yield step(surfaces.draw_uniforms)
    if plan.connects_gloss:
        yield step(gloss.save_arrival)
    yield from _new_directions(plan)
    if plan.has_thermal_walls:
        yield step(velocities.sample_wall_speed, plan.arena.table(plan.surfaces))
    if plan.counts_reflections:
        yield step(surfaces.count_reflections)
    # Score departures; then visits, bodies beyond, shadow rays and next-event rays.
    yield from score_detectors(plan, detectors.bin_departures, is_known=len(plan.layers) == 1)
    yield from mark_visits(plan)
    yield from cross_media(plan)
    yield from rays_from_walls(plan)
    yield from _resume_rays(plan)
    # Russian roulette, and the limit of events.
    if plan.has_roulette:
        yield step(variance_reduction.play_roulette, roulette_row(plan))
    elif plan.splits and plan.reflects:
        yield step(variance_reduction.play_roulette_by_importance, importance_row(plan))
    if plan.reflects:
        yield step(surfaces.kill_endless)
    yield from _end_lanes(plan, moved)


def _resume_rays(plan):
    """Yield the steps that resume the ray of a lane that passed through, except at the edges of a box of
    medium.
    """
    if plan.crosses_detectors:
        yield step(intersections.restore_ray)
        if plan.bounds_bodies:
            for row in box_rows(plan):
                yield step(regions.resolve_box_edges, row)


def _end_lanes(plan, moved):
    """Yield the steps that end lanes that left to empty space, and drop ended lanes."""
    escapes = plan.can_escape_at_once and any(row["covers"] & EMPTY_SIDES for _, row, _ in plan.members)
    if escapes:
        yield step(regions.escape_to_empty_space)
    if not plan.scatters and plan.has_acting_surfaces and (plan.absorbs or plan.reflects):
        yield step(lanes.compact_lanes, moved)


# The passes that sample new directions, by interaction; lanes of other materials stay unchanged. Functions
# give them, so that the file of a pass is not read before a scene needs it.
NEW_DIRECTIONS = {
    layout.DIFFUSE: lambda: [surfaces.reflect_diffusely],
    layout.MIRROR: lambda: [surfaces.reflect_specularly],
    layout.DIELECTRIC: lambda: [optics.refract],
    layout.GLOSSY: lambda: [optics.reflect_glossily, optics.scatter_into_lobe],
    layout.LENS: lambda: [optics.deflect_by_lens],
}


def _new_directions(plan):
    """Yield the passes of the scene's materials, and transmission of a share of what they reflect."""
    if plan.transmits:
        yield step(optics.sample_transmission)
    for interaction, passes in NEW_DIRECTIONS.items():
        for each in passes() if interaction in plan.materials else ():
            yield step(each, *[plan.arena.table(plan.optics)] * (each.table == layout.ROWS))
    if plan.transmits:
        yield step(optics.transmit)
