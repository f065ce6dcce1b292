"""A program: the list of just the passes that a scene calls for, each with its table.  The order is on one screen."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from transport.compile import layout
from transport.compile.pieces import name_of
from transport.compile.plan import Plan
from transport.engine import (
    aims,
    birthplaces,
    births,
    clocks,
    flats,
    flights,
    hierarchies,
    histories,
    landings,
    lanes,
    meshes,
    meters,
    optics,
    quadrics,
    refinements,
    rims,
    snapshots,
    speeds,
    surfaces,
)
from transport.engine.bundle import CARRIED
from transport.engine.passes import Pass

Step = tuple[Pass, np.ndarray]
FAMILIES = (
    aims, birthplaces, births, clocks, flats, flights, histories, landings, lanes, meshes, meters, optics, quadrics,
    refinements, rims, snapshots, speeds, surfaces,
)  # fmt: skip
PASSES = {each.name: each for family in FAMILIES for each in vars(family).values() if isinstance(each, Pass)}
NOTHING = layout.row(layout.NO_TABLE)
METERS = (1 << layout.METERS_A_SHEET) - 1
# Times and speeds lie in blocks, so they come first.
REFINEMENTS = ("time", "speed", "cosine", "azimuth", "place")


@dataclass
class Program:
    """Steps of every particle, and for each emitter the steps of its newborn; holds the tables that they point to."""

    plan: Plan
    steps: list[Step] = field(default_factory=list)
    births: list[list[Step]] = field(default_factory=list)
    moved: np.ndarray = field(default_factory=lambda: np.zeros((), layout.MOVED))
    machine: object = None  # driver.machine_of it, once it is made

    @property
    def passes(self) -> list[Pass]:
        """Every pass once, in order of first use."""
        return list(dict.fromkeys(p for part in (*self.births, self.steps) for p, _ in part))

    @cached_property
    def carried(self) -> tuple[str, ...]:
        """The fields that a particle takes along: those that a pass names."""
        named = {name for lane_pass in self.passes for name in lane_pass.fields}
        return tuple(name for name, _ in CARRIED if name in named)

    @cached_property
    def carried_numbers(self) -> np.ndarray:
        """Their numbers among CARRIED; the table of `fill_gaps` points here."""
        return np.array([k for k, (name, _) in enumerate(CARRIED) if name in self.carried], np.int64)


def program_of(plan: Plan) -> Program:
    """The program of a scene's plan."""
    for table in plan.meshes.values():
        hierarchies.complete(table)
    program = Program(plan)
    program.births = [list(_births(plan, emitter)) for emitter in plan.emitters]
    program.steps = [*_flight(plan, program.moved), *_landing(plan), *_crossing(plan, program.moved)]
    numbers = program.carried_numbers
    program.moved["fields"], program.moved["count"] = numbers.ctypes.data, len(numbers)
    return program


def _births(plan, emitter):
    yield _step(births.begin, emitter.birth)
    yield _named(emitter.place)
    yield _named(emitter.law)
    yield from _moment_and_speed(plan, emitter)
    if emitter.target is not None:
        if emitter.facing is not None:
            yield _step(births.take_normal, emitter.facing)
        for step in emitter.target:
            yield _named(step)
        yield _step(aims.account_born)
    if plan.reflects:
        yield _step(births.begin_events)
    if emitter.medium is not None:
        yield _step(births.begin_in_medium, emitter.medium)
    if plan.has_roulette:
        yield _step(births.remember_birth_weight)
    if plan.marks:
        yield _step(births.begin_visits)
    if plan.counts_reflections:
        yield _step(births.begin_reflections)
    sheet = emitter.birth["sheet"]
    metered = [
        (row, shape) for _, row, shape in plan.members if row["sheet"] == sheet and row["code"] & METERS
    ]
    if metered and emitter.place[0] != "born_at_point":
        yield from _birth_counted(plan, emitter, metered)


def _moment_and_speed(plan, emitter):
    """When and how fast; one random block serves both where it can."""
    moment, steps = emitter.moment, emitter.speed if plan.has_speeds else ()
    draws = steps and steps[0][0] == "draw_speed"
    if plan.has_clock and moment[0] == "start_within" and draws:
        moment, steps = ("start_within_and_draw", moment[1]), steps[1:]
    if plan.has_clock:
        yield _named(moment)
    for step in steps:
        yield _named(step)


def _birth_counted(plan, emitter, metered):
    if emitter.target is not None:
        yield _step(birthplaces.visit_birthplace)
    yield _step(birthplaces.stand_at_birth, emitter.birth)
    for row, shape in metered:
        if shape == emitter.shape or shape.is_closed or shape.is_infinite:
            yield _step(birthplaces.born_all_over, layout.row(layout.CODE, code=row["code"]))
        else:
            yield _named((f"born_over_{name_of(shape)}", row))
    yield from _stand(plan)
    yield from _metering(plan, meters.bin_departures)
    yield from _visits(plan)
    if emitter.target is not None:
        yield _step(birthplaces.return_to_target)


def _flight(plan, moved):
    yield _step(flights.look_ahead)
    for name, row, _ in plan.members:
        yield _named((name, row))
    if plan.has_clock:
        clock = layout.row(layout.CLOCK, duration=1.0, slowness=plan.slowness)
        yield _step(clocks.time_arrival_by_speed) if plan.has_speeds else _step(clocks.time_arrival, clock)
        for row in plan.phase_spaces:
            yield _step(snapshots.count_phase_space, row)
        for row in plan.snapshots:
            yield _step(snapshots.record_snapshot, row)
        yield _step(clocks.stop_clock, clock)
    yield _step(flights.leave)
    yield _step(lanes.fill_gaps, moved)
    if plan.contacts:
        yield _step(landings.remember_origin)
    if plan.passes_meters:
        yield _step(flights.remember_ray)
    yield _step(flights.move)


def _landing(plan):
    if plan.members:
        yield from _stand(plan)
        if plan.passes_meters and (plan.sheets["outward"] != 0).any():
            yield _step(landings.tell_leaving, _rows(plan.sheets))
        if plan.has_rims:
            yield _step(rims.draw_back_from_edge, _rows(plan.rims))
        for row in plan.contacts:
            yield _step(landings.keep_to_side, row)


def _stand(plan):
    yield _step(landings.stand_on_sheet, _rows(plan.sheets))
    if plan.is_curved:
        yield _step(landings.put_back_on_sphere, _rows(plan.sheets))
    if plan.has_quadrics:
        yield _step(quadrics.put_back_on_quadric, _rows(plan.curved_sheets))
    if plan.meshes:
        yield _step(meshes.stand_on_facet, _rows(plan.meshed_sheets))
    yield _step(landings.take_cosine)


def _crossing(plan, moved):
    if not plan.acts:
        yield from _metering(plan, meters.bin_crossings)
        yield from _visits(plan)
        if plan.passes_meters:
            yield _step(flights.resume_ray)
        return
    yield from _metering(plan, meters.bin_arrivals)
    if plan.draws_again:
        yield _step(surfaces.draw_again)
    if plan.chooses:
        both = {
            "rows": plan.surfaces.ctypes.data,
            "count": len(plan.surfaces),
            "others": plan.optics.ctypes.data,
        }
        yield _step(surfaces.choose_part, layout.row(layout.TWO_ROWS, **both))
    yield _step(surfaces.look_up_surface, _rows(plan.surfaces))
    if plan.has_optics:
        yield _step(optics.look_up_optics, _rows(plan.optics))
    if plan.absorbs:
        yield _step(surfaces.absorb)
        yield _step(surfaces.account_absorbed)
    if plan.draws:
        yield _step(surfaces.draw)
    yield from _new_directions(plan)
    if plan.has_thermal_walls:
        yield _step(speeds.take_wall_speed, _rows(plan.surfaces))
    if plan.counts_reflections:
        yield _step(surfaces.count_reflections)
    yield from _metering(plan, meters.bin_departures, is_known=len(plan.layers) == 1)
    yield from _visits(plan)
    if plan.passes_meters:
        yield _step(flights.resume_ray)
    if plan.has_roulette:
        yield _step(surfaces.play_roulette)
    if plan.reflects:
        yield _step(surfaces.give_up)
    if plan.absorbs or plan.reflects:
        yield _step(lanes.fill_gaps, moved)


def _new_directions(plan):
    """What each material does; lanes of the others are left as they are."""
    if plan.transmits:
        yield _step(optics.choose_to_pass)
    if layout.DIFFUSE in plan.materials:
        yield _step(surfaces.reflect_diffusely)
    if layout.MIRROR in plan.materials:
        yield _step(surfaces.reflect_specularly)
    if plan.transmits:
        yield _step(optics.let_pass)
    if layout.DIELECTRIC in plan.materials:
        yield _step(optics.refract)
    if layout.GLOSSY in plan.materials:
        yield _step(optics.reflect_glossily)
        yield _step(optics.spread_lobe, _rows(plan.optics))
    if layout.LENS in plan.materials:
        yield _step(optics.bend_by_lens, _rows(plan.optics))


def _metering(plan, binning, is_known=False):
    """Count at every layer's meters; is_known: the lanes have looked up their only meter at this crossing already."""
    for layer, rows in enumerate(plan.layers):
        table = _layer(plan, layer)
        if not (rows["look"] != 0).any():
            continue
        if not is_known:
            yield _step(meters.look_up_meter, table)
        yield _step(binning, table)
        asked = plan.axes | plan.filters
        if asked:
            yield _step(refinements.know_meter, table)
        for what in sorted(plan.filters):
            yield _named((f"require_{what}", table))
        for axis in REFINEMENTS:
            if axis in plan.axes:
                yield _named((f"refine_by_{axis}", table))
        is_dense = bool((rows[1:]["look"] != 0).all())
        yield _step(meters.score_all if is_dense and plan.acts else meters.score)
        if plan.moments is not None:
            yield _step(meters.score_moments, plan.moments)


def _visits(plan):
    """Mark what detectors ask for in `via`, after all meters of this crossing."""
    for layer, rows in enumerate(plan.layers):
        if (rows["mark"] != 0).any():
            yield _step(histories.mark_visit, _layer(plan, layer))


def _layer(plan: Plan, layer: int) -> np.ndarray:
    return layout.row(
        layout.LAYERS,
        rows=plan.layers[layer].ctypes.data,
        count=len(plan.layers[layer]),
        layer=layer,
        half=plan.half,
        meters=plan.meters.ctypes.data,
        meter_count=len(plan.meters),
    )


def _step(lane_pass: Pass, table: np.ndarray = NOTHING) -> Step:
    if table.dtype != lane_pass.table:
        raise TypeError(f"pass {lane_pass.name} reads a {lane_pass.table}, got {table.dtype}")
    return lane_pass, table


def _named(step: tuple[str, np.ndarray]) -> Step:
    name, table = step
    return _step(PASSES[name], table)


def _rows(array: np.ndarray) -> np.ndarray:
    """A table that points to an array, which the plan keeps alive."""
    return layout.row(layout.ROWS, rows=array.ctypes.data, count=len(array))
