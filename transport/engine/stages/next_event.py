"""Steps of next-event estimation for point and surface detectors: cast rays, trace them, weight by MIS."""

import numpy as np

from transport.compile import layout
from transport.compile.next_event import LAMBERTIAN_DENSITY
from transport.compile.points import attenuates_anywhere, phase_densities
from transport.engine.bundle import Bundle
from transport.engine.passes import emission, mis, next_event, once_more_collided, shadow_rays
from transport.engine.registry import step, step_by_name
from transport.geometry.flat import Disk, Rectangle, Triangle

# ---- Steps of point detectors: where shadow rays are cast, and how they are traced.

# Fields moved from the casting lane into the ray's lane; the set of bodies and the facet of a mesh are added
# where needed.
RAY_FIELDS = (
    ("sx", "x"), ("sy", "y"), ("sz", "z"), ("vx", "ux"), ("vy", "uy"), ("vz", "uz"),
    ("point_distance", "point_distance"), ("score", "weight"), ("shadow_sheet", "sheet"), ("tally", "tally"),
    (None, "start"),
)  # fmt: skip
DIRECT = 0  # `leg` of rays that go straight to their point


def shadow_rays_from_births(plan, emitter):
    """Yield the steps that cast rays from births to every point: direct, and once more collided."""
    number = next(k for k, each in enumerate(plan.emitters) if each is emitter)
    casts = [(point.births[number], DIRECT) for point in plan.points]
    casts += [(point.detours[number], point.leg) for point in plan.points]
    casts = [(cast, leg) for cast, leg in casts if cast is not None]
    if casts and emitter.facing is not None and emitter.law[0] == "emit_lambertian_from_plane":
        yield step(emission.set_emission_normal, emitter.facing)
    for cast, leg in casts:
        yield step_by_name(cast)
        yield _list_step(leg)


def shadow_rays_from_flights(plan):
    """Yield the steps that cast rays from flights: scattering outside the medium around a point."""
    points = [point for point in plan.points if point.has_other_scatterers]
    if points:
        yield step(shadow_rays.find_phase_of_flights, plan.arena.table(plan.media))
    for point in points:
        yield step(shadow_rays.cast_from_flights, point.row)
        for row in plan.grids:
            yield step(shadow_rays.scale_by_grid_scattering, row)
        yield from map(step_by_name, phase_densities(plan))
        yield _list_step(DIRECT)


def once_more_collided_rays(plan):
    """Yield the steps that cast once-more-collided rays from collisions."""
    points = [point for point in plan.points if point.row["medium"] >= 0]
    if points:
        yield step(once_more_collided.find_phase_at_collisions, plan.arena.table(plan.media))
    for point in points:
        yield step(once_more_collided.first_leg_from_collisions, point.row)
        yield from map(step_by_name, phase_densities(plan))
        yield _list_step(point.leg)


def shadow_rays_from_walls(plan):
    """Yield the steps that cast rays from diffuse walls: direct, and once more collided."""
    if layout.DIFFUSE not in plan.materials:
        return
    for point in plan.points:
        yield step(shadow_rays.cast_from_walls, point.row)
        yield _list_step(DIRECT)
        if point.row["medium"] >= 0:
            yield step(once_more_collided.first_leg_from_walls, point.row)
            yield _list_step(point.leg)


def _list_step(leg):
    """Return the step that lists contributing rays with this leg."""
    return step(shadow_rays.list_shadow_rays, layout.row(layout.LEG, leg=leg))


def point_ray_steps(plan, nearest, crossing):
    """Yield the steps of shadow rays: the first gets the handle of the casting bundle, the others their own.

    nearest: steps that set each lane's medium and find the next surface. crossing: steps of a ray through
    transparent surfaces.
    """
    yield step(shadow_rays.load_shadow_rays, plan.arena.table(_point_ray_fields(plan)))
    yield step(shadow_rays.reset_shadow_hit)
    yield from nearest
    yield from _attenuate(plan)
    yield step(shadow_rays.score_at_points)
    yield step(shadow_rays.end_rays_at_points)
    if _has_once_more_collided(plan):
        yield from _second_leg(plan)
    yield from crossing


def _attenuate(plan):
    """Yield the steps that attenuate shadow rays up to the next surface."""
    if plan.has_media and attenuates_anywhere(plan):
        yield step(shadow_rays.attenuate_shadow_rays)
    for row in (*plan.grids, *plan.absorbing_grids):
        yield step(shadow_rays.attenuate_shadow_rays_in_grid, row)


def _second_leg(plan):
    """Yield the steps from the first leg of a once-more-collided ray to the second."""
    points = np.array([point.row for point in plan.points], layout.POINT)
    yield step(once_more_collided.reset_phase_number)
    yield step(once_more_collided.turn_into_second_leg, plan.arena.table(points, plan.media))
    for row in plan.grids:
        yield step(shadow_rays.scale_by_grid_scattering, row)
    yield from map(step_by_name, phase_densities(plan))
    yield step(once_more_collided.start_second_leg)


def _has_once_more_collided(plan) -> bool:
    """Return whether any point lies in a scattering medium."""
    return any(point.row["medium"] >= 0 for point in plan.points)


def _point_ray_fields(plan) -> np.ndarray:
    """Return the moves of fields from the casting lane into the ray's lane."""
    moves = list(RAY_FIELDS)
    if plan.has_bodies:
        moves.append(("inside", "inside"))
    if plan.meshes:
        moves.append(("own_facet", "own_facet"))
    if _has_once_more_collided(plan):
        moves.append(("leg", "leg"))
    return field_moves(moves)


def field_moves(moves) -> np.ndarray:
    """Return rows of layout.WORD: per move, source field of a lane (None: 0) and target field of a ray."""
    words = {name: offset // 8 for name, (_, offset) in Bundle.fields.items()}
    return np.array([(words.get(source, -1), words[target]) for source, target in moves], layout.WORD)


# ---- Steps for surface detectors: cast rays, trace them, weight flights by MIS.

POINT_PASSES = {Rectangle: "point_on_rectangle", Disk: "point_on_disk", Triangle: "point_on_triangle"}


def next_event_from_births(plan, emitter):
    """Yield the steps that cast rays from births to every detector, and record the pdf for MIS."""
    number = next(k for k, each in enumerate(plan.emitters) if each is emitter)
    rows = [(each, each.births[number]) for each in plan.expectations if each.births[number] is not None]
    if rows and emitter.facing is not None and emitter.law[0] == "emit_lambertian_from_plane":
        yield step(emission.set_emission_normal, emitter.facing)
    for each, row in rows:
        if row["number"]:
            yield step(next_event.draw_point_at_birth, row)
        else:
            yield step(next_event.draw_joint_point_at_birth)
        yield from _connect(plan, each, row, next_event.contribute_from_births)
    if plan.expectations:
        yield step(mis.record_pdf_at_births, _pdf_table(float(rows[0][1]["peak"]) if rows else 0.0))


def next_event_from_walls(plan):
    """Yield the steps that cast rays from diffuse walls, and record the pdf for MIS."""
    for each in plan.expectations:
        if each.walls is not None:
            yield step(next_event.draw_point_at_event, each.walls)
            yield from _connect(plan, each, each.walls, next_event.contribute_from_walls)
    if plan.expectations and plan.reflects:
        yield step(mis.record_pdf_at_walls, _pdf_table(LAMBERTIAN_DENSITY))


def next_event_from_collisions(plan):
    """Yield the steps that cast rays from collisions, and record the pdf for MIS."""
    rows = [(each, each.collisions) for each in plan.expectations if each.collisions is not None]
    if not rows:
        return
    yield step(once_more_collided.find_phase_at_collisions, plan.arena.table(plan.media))
    for each, row in rows:
        yield step(next_event.draw_point_at_event, row)
        yield from _connect(plan, each, row, next_event.contribute_from_collisions, phase_densities(plan))
    yield step(mis.record_pdf_at_collisions, _pdf_table(float(rows[0][1]["peak"])))


def count_guarded_flights(plan):
    """Yield the steps that count flights without a next-event ray near a detector.

    The counts identify the surfaces that send such light.
    """
    for guard in plan.guards:
        yield step(mis.count_in_guard, guard.row)


def _connect(plan, each, row, send, densities=()):
    """Yield the steps of a ray from each lane's event to the sampled point, and of its contribution."""
    shape = plan.scene.shape_of(each.detector)
    if shape.is_flat:
        parts = shape.primitives()
        name = "point_on_polygon" if len(parts) > 1 else POINT_PASSES[type(parts[0])]
        yield step_by_name((name, row))
        yield step(next_event.connect_to_flat, row)
    else:
        yield step(next_event.connect_to_ball, row)
    yield step(send, row)
    yield from map(step_by_name, densities)
    yield step(shadow_rays.list_shadow_rays, layout.row(layout.LEG, leg=row["legs"]))


def mis_steps_before(plan, layer, passing):
    """Yield the steps that apply MIS weights before a layer's detectors score flights.

    There are none without next-event estimation.
    """
    if uses_next_event(plan, layer):
        yield step(mis.save_weight)
    for each in plan.expectations:
        if each.layer == layer:
            yield step(mis.apply_mis_weight, layout.row(layout.MIS_SHARE, **each.held, passing=passing))


def mis_steps_after(plan, layer):
    """Yield the step that restores the full weights afterwards."""
    if uses_next_event(plan, layer):
        yield step(mis.restore_weight)


def uses_next_event(plan, layer):
    """Return whether next-event estimation applies to a detector of the layer."""
    return any(each.layer == layer for each in plan.expectations)


def next_event_ray_steps(plan, nearest, crossing):
    """Yield the steps of next-event rays; the first has the handle of the bundle that casts them.

    nearest: steps that set each lane's medium and find the next surface. crossing: from arrival at a surface
    to its other side.
    """
    yield step(shadow_rays.load_shadow_rays, plan.arena.table(_next_event_ray_fields(plan)))
    yield step(shadow_rays.reset_shadow_hit)
    yield from nearest
    yield step(next_event.end_missed_rays)
    yield from _attenuate(plan)
    yield from crossing


def _next_event_ray_fields(plan):
    """Return the moves of fields from the casting lane into the ray's lane."""
    moves = [("ray_start" if name == "start" else source, name) for source, name in RAY_FIELDS]
    moves += [("leg", "leg"), ("history", "history")]
    moves += [("inside", "inside")] * plan.has_bodies + [("own_facet", "own_facet")] * bool(plan.meshes)
    moves += [("visited", "visited")] * bool(plan.marks)
    moves += [("reflections", "reflections")] * plan.counts_reflections
    moves += [("cell", "cell")] * (plan.adjoint is not None)
    return field_moves(moves)


def _pdf_table(peak):
    """Return the table with the largest pdf of sampled directions."""
    return layout.row(layout.MIS_PEAK, peak=peak)
