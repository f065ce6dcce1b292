"""The steps that point detectors call for: where shadow rays are cast, and what happens to them on their way."""

import numpy as np

from transport.compile import layout
from transport.compile.points import dims_anywhere, phase_densities, scatters_anywhere
from transport.engine import births, casting, shadows
from transport.engine.bundle import Bundle
from transport.engine.registry import named, rows_of, step

# What a ray takes along, from the lane that casts it into its own; the bodies that it is in and a mesh's facet where there are any.
MOVES = (
    ("sx", "x"), ("sy", "y"), ("sz", "z"), ("vx", "ux"), ("vy", "uy"), ("vz", "uz"), ("gap", "gap"),
    ("score", "weight"), ("stands", "sheet"), ("tally", "tally"), (None, "start"),
)  # fmt: skip


def casts_of_births(plan, emitter):
    """What each birth of an emitter sends to every point."""
    number = next(k for k, each in enumerate(plan.emitters) if each is emitter)
    seen = [point.births[number] for point in plan.points if point.births[number] is not None]
    if seen and emitter.facing is not None and emitter.law[0] != "emit_isotropic":
        yield step(births.take_normal, emitter.facing)
    for cast in seen:
        yield named(cast)
        yield step(casting.list_shadows)


def casts_of_flights(plan):
    """What scattering on a flight sends."""
    if not (plan.points and scatters_anywhere(plan)):
        return
    yield step(casting.know_phase, rows_of(plan.media))
    densities = phase_densities(plan)
    for point in plan.points:
        yield step(casting.cast_from_flights, point.row)
        for row in plan.grids:
            yield step(casting.weigh_in_grid, row)
        for density in densities:
            yield named(density)
        yield step(casting.list_shadows)


def casts_of_walls(plan):
    """What diffuse walls send of what they reflect or let through."""
    if layout.DIFFUSE in plan.materials:
        for point in plan.points:
            yield step(casting.cast_from_walls, point.row)
            yield step(casting.list_shadows)


def sight_of(plan, media, members, crossing):
    """The steps of shadow rays, the first one with the handle of the bundle that casts them, the others with their own.

    media: the steps by which lanes know their medium;  members: those that find what is next;  crossing: those that bring a
    ray through what lets it pass.
    """
    yield step(shadows.take_shadows, rows_of(_moves(plan)))
    yield step(shadows.look_for_point)
    yield from media
    yield from members
    if plan.has_media and dims_anywhere(plan):
        yield step(shadows.dim)
    for row in (*plan.grids, *plan.thinning_grids):
        yield step(shadows.dim_in_grid, row)
    yield step(shadows.arrive)
    yield from crossing


def _moves(plan) -> np.ndarray:
    moves = list(MOVES)
    if plan.has_bodies:
        moves.append(("inside", "inside"))
    if plan.meshes:
        moves.append(("footing", "footing"))
    words = {name: offset // 8 for name, (_, offset) in Bundle.fields.items()}
    rows = np.array([(words.get(source, -1), words[target]) for source, target in moves], layout.WORD)
    plan.kept.append(rows)
    return rows
