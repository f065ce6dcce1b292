"""Steps at the end of a flight: land on the sheet, score at detectors, mark visits, change bodies."""

import numpy as np

from transport.compile import layout
from transport.compile.detectors import is_dense, size_row
from transport.engine.passes import (
    detector_bins,
    detectors,
    intersections,
    landing,
    meshes,
    quadrics,
    regions,
    score_sizes,
    shadow_rays,
)
from transport.engine.registry import step, step_by_name, table_of_layer
from transport.engine.stages.next_event import mis_steps_after, mis_steps_before, uses_next_event

# Bins of time and speed are the outer blocks of rows, so they come first.
BIN_AXES = ("time", "speed", "cosine", "azimuth", "place", "cell")


def land_on_surface(plan):
    """Yield the steps that set the sheet, its normal and the cosine of incidence."""
    yield step(landing.set_sheet, plan.arena.table(plan.sheets))
    if plan.is_curved:
        yield step(landing.project_onto_sphere, plan.arena.table(plan.sheets))
    if plan.has_quadrics:
        yield step(quadrics.project_onto_quadric, plan.arena.table(plan.curved_sheets))
    if plan.meshes:
        rows = np.array([*plan.meshed_sheets], layout.MESHED_SHEET)
        yield step(meshes.land_on_facet, plan.arena.table(rows))
    yield step(landing.set_cosine)


def score_detectors(plan, binning, is_known=False, is_born=False):
    """Yield the steps that score at the detectors of every layer.

    binning: pass that finds the bin. is_known: lanes have already looked up their only detector at this
    crossing. is_born: they leave their birthplace.
    """
    for layer, rows in enumerate(plan.layers):
        table = table_of_layer(plan, layer)
        if not (rows["detector_word"] != 0).any():
            continue
        if not is_known:
            yield step(detectors.find_detector, table)
        if not is_born:
            yield from mis_steps_before(plan, layer, passing=binning is detectors.bin_departures)
        yield step(binning, table)
        yield from bin_axes(plan, table)
        yield score_step(plan, is_dense(plan, rows))
        for score in plan.long_scores:
            yield step_by_name((score.at_crossing, score.table))
        if not is_born:
            yield from mis_steps_after(plan, layer)


def score_step(plan, by_nearly_all=False):
    """Return the step that adds scores to their rows and, where they differ, counts their sizes.

    by_nearly_all: nearly every lane has a bin.
    """
    if plan.size_cells:
        scoring = score_sizes.score_all_and_size if by_nearly_all else score_sizes.score_and_size
        return step(scoring, size_row(plan))
    return step(detectors.score_all if by_nearly_all else detectors.score)


def bin_axes(plan, table):
    """Yield the steps of further bin axes and of `via` and `events` of a layer's detectors."""
    if plan.axes | plan.filters:
        yield step(detector_bins.find_detector_row, table)
    for what in sorted(plan.filters):
        yield step_by_name((f"require_{what}", table))
    for axis in BIN_AXES:
        if axis in plan.axes:
            yield step_by_name((f"refine_by_{axis}", table))


def mark_visits(plan):
    """Yield the steps that mark visits for `via`, after all detectors of this crossing."""
    for layer, rows in enumerate(plan.layers):
        if (rows["mark"] != 0).any():
            yield step(detectors.mark_visit, table_of_layer(plan, layer))


def cross_media(plan):
    """Yield the steps that update the set of bodies for the side that lanes leave to."""
    if plan.bounds_bodies:
        for layer, rows in enumerate(plan.layers):
            if (rows["front"] != rows["back"]).any():
                yield step(regions.cross_boundary, table_of_layer(plan, layer))


# ---- Steps of shadow rays at surfaces: passage through transparent ones, and scores along the path.


def cross_shadow_rays(plan):
    """Yield the steps of a ray at a surface: move there, score, change bodies, resume the ray."""
    passes = any(name.startswith(("cover", "bound")) for name, *_ in plan.members)
    if not (passes or plan.expectations or plan.links is not None):
        yield step(shadow_rays.end_next_event_rays)
        return
    if passes:
        yield step(intersections.save_ray)
    yield step(intersections.move)
    yield from land_on_surface(plan)
    if passes and (plan.sheets["outward"] != 0).any():
        yield step(landing.mark_box_exit, plan.arena.table(plan.sheets))
    if plan.expectations:
        for layer in range(len(plan.layers)):
            yield from _score_next_event(plan, layer)
        yield from mark_visits(plan)
    if plan.links is None:
        yield step(shadow_rays.end_next_event_rays)
    else:
        yield step(shadow_rays.redirect_next_event_rays, plan.arena.table(plan.links))
    yield from cross_media(plan)
    if passes:
        yield step(intersections.restore_ray)


def _score_next_event(plan, layer):
    """Yield the steps that score rays at the detectors of a layer that they were cast to.

    A transparent detector is scored on both sides.
    """
    if not uses_next_event(plan, layer):
        return
    table = table_of_layer(plan, layer, plan.expected_layers[layer])
    yield step(detectors.find_detector, table)
    yield step(shadow_rays.ignore_other_detectors)
    acting = detectors.bin_arrivals, detectors.bin_departures
    for binning in acting if plan.has_acting_surfaces else (detectors.bin_crossings,):
        if binning is detectors.bin_departures:
            yield step(shadow_rays.keep_transmitted)
        yield step(binning, table)
        yield from bin_axes(plan, table)
        yield score_step(plan)
    yield step(shadow_rays.count_target_crossings, table)
