"""Steps of point detectors: where shadow rays are cast, and how they are traced."""

import numpy as np

from transport.compile import layout
from transport.compile.points import dims_anywhere, phase_densities
from transport.engine import births, casting, densities, detours, shadows
from transport.engine.bundle import Bundle
from transport.engine.registry import named, rows_of, step

# Fields moved from the casting lane into the ray's lane; the set of bodies and the facet of a mesh are added
# where needed.
MOVES = (
    ("sx", "x"), ("sy", "y"), ("sz", "z"), ("vx", "ux"), ("vy", "uy"), ("vz", "uz"), ("gap", "gap"),
    ("score", "weight"), ("stands", "sheet"), ("tally", "tally"), (None, "start"),
)  # fmt: skip
STRAIGHT = 0  # `leg` of rays that go straight to their point


def casts_of_births(plan, emitter):
    """Yield the steps that cast rays from births to every point: direct, and once more collided."""
    number = next(k for k, each in enumerate(plan.emitters) if each is emitter)
    casts = [(point.births[number], STRAIGHT) for point in plan.points]
    casts += [(point.detours[number], point.leg) for point in plan.points]
    casts = [(cast, leg) for cast, leg in casts if cast is not None]
    if casts and emitter.facing is not None and emitter.law[0] == "emit_lambertian_from_plane":
        yield step(births.take_normal, emitter.facing)
    for cast, leg in casts:
        yield named(cast)
        yield _listed(leg)


def casts_of_flights(plan):
    """Yield the steps that cast rays from flights: scattering outside the medium around a point."""
    points = [point for point in plan.points if point.by_flights]
    if points:
        yield step(casting.know_phase, rows_of(plan.media))
    for point in points:
        yield step(casting.cast_from_flights, point.row)
        for row in plan.grids:
            yield step(densities.weigh_in_grid, row)
        yield from map(named, phase_densities(plan))
        yield _listed(STRAIGHT)


def detours_of_collisions(plan):
    """Yield the steps that cast once-more-collided rays from collisions."""
    points = [point for point in plan.points if point.row["medium"] >= 0]
    if points:
        yield step(detours.know_phase_at_collisions, rows_of(plan.media))
    for point in points:
        yield step(detours.detour_from_collisions, point.row)
        yield from map(named, phase_densities(plan))
        yield _listed(point.leg)


def casts_of_walls(plan):
    """Yield the steps that cast rays from diffuse walls: direct, and once more collided."""
    if layout.DIFFUSE not in plan.materials:
        return
    for point in plan.points:
        yield step(casting.cast_from_walls, point.row)
        yield _listed(STRAIGHT)
        if point.row["medium"] >= 0:
            yield step(detours.detour_from_walls, point.row)
            yield _listed(point.leg)


def _listed(leg):
    """Return the step that lists contributing rays with this leg."""
    return step(casting.list_shadows, layout.row(layout.CODE, code=leg))


def sight_of(plan, media, members, crossing):
    """Yield the steps of shadow rays: the first gets the handle of the casting bundle, the others their own.

    media: steps that set each lane's medium. members: steps that find the next surface. crossing: steps of a
    ray through transparent surfaces.
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
    if _has_detours(plan):
        yield from _turn(plan)
    yield from crossing


def _turn(plan):
    """Yield the steps from the first leg of a once-more-collided ray to the second."""
    points = np.array([point.row for point in plan.points], layout.POINT)
    plan.kept.append(points)
    both = {"rows": points.ctypes.data, "count": len(points)}
    both |= {"others": plan.media.ctypes.data, "other_count": len(plan.media)}
    yield step(detours.turn_to_point, layout.row(layout.TWO_ROWS, **both))
    for row in plan.grids:
        yield step(densities.weigh_in_grid, row)
    yield from map(named, phase_densities(plan))
    yield step(detours.set_off_again)


def _has_detours(plan) -> bool:
    """Return whether any point lies in a scattering medium."""
    return any(point.row["medium"] >= 0 for point in plan.points)


def _moves(plan) -> np.ndarray:
    """Return the moves of fields from the casting lane into the ray's lane."""
    moves = list(MOVES)
    if plan.has_bodies:
        moves.append(("inside", "inside"))
    if plan.meshes:
        moves.append(("footing", "footing"))
    if _has_detours(plan):
        moves.append(("leg", "leg"))
    return word_moves(plan, moves)


def word_moves(plan, moves) -> np.ndarray:
    """Return rows of layout.WORD: for each move, source field of a lane (None: 0) and target field of a ray.

    The plan keeps the rows alive.
    """
    words = {name: offset // 8 for name, (_, offset) in Bundle.fields.items()}
    rows = np.array([(words.get(source, -1), words[target]) for source, target in moves], layout.WORD)
    plan.kept.append(rows)
    return rows
