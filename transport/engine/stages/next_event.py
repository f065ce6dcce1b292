"""Steps of next-event estimation for point and surface detectors: cast rays, trace them, weight by MIS."""

import numpy as np

from transport.compile import layout
from transport.compile.next_event import LAMBERTIAN_DENSITY
from transport.compile.points import attenuates_anywhere, phase_densities
from transport.engine.bundle import Bundle
from transport.engine.passes import (
    backward,
    caustics,
    emission,
    gloss,
    mis,
    next_event,
    once_more_collided,
    shadow_rays,
)
from transport.engine.registry import step, step_by_name, table_of_layer

# ---- Cast rays: sample, connect, contribute, list; and record the pdf for MIS.


def rays_from_births(plan, emitter):
    """Yield the steps that cast rays from births to every detector."""
    number = next(k for k, each in enumerate(plan.emitters) if each is emitter)
    sent = [rays for each in plan.targets for rays in each.births[number]]
    if sent and emitter.facing is not None and emitter.law[0] == "emit_lambertian_from_plane":
        yield step(emission.set_emission_normal, emitter.facing)
    yield from _cast(sent, "contribute_from_births")
    if plan.expectations:
        yield step(mis.record_pdf_at_births, _pdf_table(max((rays.peak for rays in sent), default=0.0)))


def rays_from_walls(plan):
    """Yield the steps that cast rays from diffuse and glossy walls, and note what flights share."""
    if plan.connects_gloss:
        yield step(gloss.look_up_lobe, plan.arena.table(plan.optics))
    yield from _cast([rays for each in plan.targets for rays in each.walls], "contribute_from_walls")
    if plan.expectations and plan.links is not None:
        row = layout.row(layout.MIS_LINK, peak=LAMBERTIAN_DENSITY, transmits=plan.transmits)
        yield step(mis.record_pdf_across_mirrors, row)
    elif plan.expectations and plan.reflects:
        yield step(mis.record_pdf_at_walls, _pdf_table(LAMBERTIAN_DENSITY))
    if plan.connects_gloss:
        yield step(gloss.record_glossy_pdf)
    if _starts_at_lamps(plan):
        for row in plan.adjoint.caustics.rows:
            yield step(caustics.note_first_wall, row)
        yield step(caustics.note_first_interaction, plan.arena.table(plan.adjoint.caustics.surfaces))


def rays_from_collisions(plan):
    """Yield the steps that cast rays from collisions."""
    sent = [rays for each in plan.targets for rays in each.collisions]
    if not sent:
        return
    yield step(next_event.find_phase_at_collisions, plan.arena.table(plan.media))
    yield from _cast(sent, "contribute_from_scattering", map(step_by_name, phase_densities(plan)))
    if plan.expectations:
        yield step(mis.record_pdf_at_collisions, _pdf_table(max(rays.peak for rays in sent)))


def rays_from_flights(plan):
    """Yield the steps that cast rays from flights: scattering outside the medium around a point detector."""
    sent = [rays for point in plan.points for rays in point.flights]
    if sent:
        yield step(next_event.find_phase_of_flights, plan.arena.table(plan.media))
        yield from _cast(sent, "contribute_from_scattering", _scattering(plan))


def _cast(sent, contribute, densities=()):
    """Yield the steps that cast rays; contribute: name of a pass, densities: steps of phase functions."""
    densities = tuple(densities)
    for rays in sent:
        yield from map(step_by_name, rays.connect)
        yield step_by_name((contribute, rays.contribution))
        yield from densities
        yield from map(step_by_name, rays.densities)
        yield step(shadow_rays.list_shadow_rays, layout.row(layout.LEG, leg=rays.leg))


def _scattering(plan):
    """Yield the steps of scattering towards a point: coefficients in voxels, pdfs of phase functions."""
    for row in plan.grids:
        yield step(shadow_rays.scale_by_grid_scattering, row)
    yield from map(step_by_name, phase_densities(plan))


def _pdf_table(peak):
    """Return the table with the largest pdf of sampled directions."""
    return layout.row(layout.MIS_PEAK, peak=peak)


# ---- Trace rays.

# Fields of a ray, and the fields of the casting lane that they come from; those that no pass uses stay there.
RAY_FIELDS = {
    "x": "sx", "y": "sy", "z": "sz", "ux": "vx", "uy": "vy", "uz": "vz", "start": "ray_start",
    "point_distance": "point_distance", "weight": "score", "sheet": "shadow_sheet", "tally": "tally",
    "leg": "leg", "history": "history", "inside": "inside", "own_facet": "own_facet", "visited": "visited",
    "reflections": "reflections", "cell": "cell", "born": "born",
}  # fmt: skip


def ray_steps(plan, nearest, crossing):
    """Return the steps of rays under way.

    nearest: steps that set each lane's medium and find the next surface. crossing: steps of a ray through a
    surface.
    """
    traced = [step(shadow_rays.reset_shadow_hit), *nearest]
    if plan.expectations:
        traced.append(step(shadow_rays.end_missed_rays))
    traced += _attenuate(plan)
    if plan.points:
        traced += [*_score_at_points(plan), step(shadow_rays.end_rays_at_points)]
    if any(point.row["medium"] >= 0 for point in plan.points):
        traced += _second_leg(plan)
    return [*traced, *crossing]


def _score_at_points(plan):
    """Yield the steps that score rays at point detectors; in a backward run at Points, Beams and cameras."""
    if plan.adjoint is None:
        yield step(shadow_rays.score_at_points)
        return
    for row in plan.adjoint.ray_lamps:
        yield step(backward.score_at_lamp_by_cell, row)
    for row in plan.adjoint.caustics.rows if plan.adjoint.caustics else ():
        yield step(caustics.score_in_view, row)


def load_rays(plan, traced):
    """Return the step, called with the casting bundle, that loads the fields that these steps of rays use."""
    used = {name for lane_pass, _ in traced for name in lane_pass.fields}
    words = {name: offset // 8 for name, (_, offset) in Bundle.fields.items()}
    moves = [(words[source], words[target]) for target, source in RAY_FIELDS.items() if target in used]
    fields = plan.arena.table(np.array(moves, layout.WORD))
    return step(shadow_rays.load_shadow_rays, fields)


def _attenuate(plan):
    """Yield the steps that attenuate rays up to the next surface."""
    if plan.has_media and attenuates_anywhere(plan):
        yield step(shadow_rays.attenuate_shadow_rays)
    for row in (*plan.grids, *plan.absorbing_grids):
        yield step(shadow_rays.attenuate_shadow_rays_in_grid, row)


def _second_leg(plan):
    """Yield the steps from the first leg of a once-more-collided ray to the second."""
    points = np.array([point.row for point in plan.points], layout.POINT)
    yield step(once_more_collided.reset_phase_number)
    yield step(once_more_collided.turn_into_second_leg, plan.arena.table(points, plan.media))
    yield from _scattering(plan)
    yield step(once_more_collided.start_second_leg)


# ---- Weight flights by MIS.


def count_guarded_flights(plan):
    """Yield the steps that count flights without a next-event ray near a detector.

    The counts identify the surfaces that send such light.
    """
    for guard in plan.guards:
        yield step(mis.count_in_guard, guard.row)


def mis_steps_before(plan, layer, passing):
    """Yield the steps that apply MIS weights before a layer's detectors score flights.

    There are none without next-event estimation and histories from lamps.
    """
    if _weighs_flights(plan, layer):
        yield step(mis.save_weight)
    for each in plan.expectations:
        if each.layer == layer:
            yield step(mis.apply_mis_weight, layout.row(layout.MIS_SHARE, **each.held, passing=passing))
    if _starts_at_lamps(plan):
        yield step(caustics.weigh_flights_to_lamps, table_of_layer(plan, layer))


def mis_steps_after(plan, layer):
    """Yield the step that restores the full weights afterwards."""
    if _weighs_flights(plan, layer):
        yield step(mis.restore_weight)


def _weighs_flights(plan, layer):
    """Return whether flights share scores at a layer with rays, or with histories from lamps."""
    return uses_next_event(plan, layer) or _starts_at_lamps(plan)


def _starts_at_lamps(plan):
    """Return whether some histories of a backward run start at lamps."""
    return plan.adjoint is not None and plan.adjoint.caustics is not None


def uses_next_event(plan, layer):
    """Return whether next-event estimation applies to a detector of the layer."""
    return any(each.layer == layer for each in plan.expectations)
