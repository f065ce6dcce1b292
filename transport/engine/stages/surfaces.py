"""Steps at the end of a flight: land on the sheet, score at detectors, mark visits, change bodies."""

from transport.compile.volumes import is_dense, size_row
from transport.engine import tally
from transport.engine.passes import (
    detector_bins,
    detectors,
    intersections,
    landing,
    meshes,
    next_event,
    quadrics,
    regions,
)
from transport.engine.registry import layer_of, named, rows_of, step
from transport.engine.stages.next_event import expects_on, given_back, held_back

# Bins of time and speed are the outer blocks of rows, so they come first.
REFINEMENTS = ("time", "speed", "cosine", "azimuth", "place", "cell")


def stood(plan):
    """Yield the steps that set the sheet, its normal and the cosine of incidence."""
    yield step(landing.stand_on_sheet, rows_of(plan.sheets))
    if plan.is_curved:
        yield step(landing.put_back_on_sphere, rows_of(plan.sheets))
    if plan.has_quadrics:
        yield step(quadrics.put_back_on_quadric, rows_of(plan.curved_sheets))
    if plan.meshes:
        yield step(meshes.stand_on_facet, rows_of(plan.meshed_sheets))
    yield step(landing.take_cosine)


def metering(plan, binning, is_known=False, is_born=False):
    """Yield the steps that score at the detectors of every layer.

    binning: pass that finds the bin. is_known: lanes have already looked up their only detector at this
    crossing. is_born: they leave their birthplace.
    """
    for layer, rows in enumerate(plan.layers):
        table = layer_of(plan, layer)
        if not (rows["look"] != 0).any():
            continue
        if not is_known:
            yield step(detectors.look_up_meter, table)
        if not is_born:
            yield from held_back(plan, layer, passing=binning is detectors.bin_departures)
        yield step(binning, table)
        yield from refined(plan, table)
        yield scored(plan, is_dense(plan, rows))
        if plan.moments is not None:
            yield step(detectors.score_moments, plan.moments)
        if not is_born:
            yield from given_back(plan, layer)


def scored(plan, by_nearly_all=False):
    """Return the step that adds scores to their rows and, where they differ, counts their sizes.

    by_nearly_all: nearly every lane has a bin.
    """
    if plan.size_cells:
        return step(tally.score_all_and_size if by_nearly_all else tally.score_and_size, size_row(plan))
    return step(detectors.score_all if by_nearly_all else detectors.score)


def refined(plan, table):
    """Yield the steps of further bin axes and of `via` and `events` of a layer's detectors."""
    if plan.axes | plan.filters:
        yield step(detector_bins.know_meter, table)
    for what in sorted(plan.filters):
        yield named((f"require_{what}", table))
    for axis in REFINEMENTS:
        if axis in plan.axes:
            yield named((f"refine_by_{axis}", table))


def visits(plan):
    """Yield the steps that mark visits for `via`, after all detectors of this crossing."""
    for layer, rows in enumerate(plan.layers):
        if (rows["mark"] != 0).any():
            yield step(detectors.mark_visit, layer_of(plan, layer))


def boundaries(plan):
    """Yield the steps that update the set of bodies for the side that lanes leave to."""
    if plan.bounds_bodies:
        for layer, rows in enumerate(plan.layers):
            if (rows["front"] != rows["back"]).any():
                yield step(regions.cross_boundary, layer_of(plan, layer))


# ---- Steps of shadow rays at surfaces: passage through transparent ones, and scores along the path.


def through(plan):
    """Yield the steps of a shadow ray through transparent surfaces, on along the same ray."""
    if _lets_pass(plan):
        yield from _landed(plan, ())


def expected_crossing(plan):
    """Yield the steps of a next-event ray from arrival at a surface to its other side."""
    counted = [each for layer in range(len(plan.layers)) for each in _expected_metering(plan, layer)]
    yield from _landed(plan, [*counted, *visits(plan), step(next_event.end_expected)])


def _lets_pass(plan):
    """Return whether the scene has transparent detectors or boundaries of media."""
    return any(name.startswith(("cover", "bound")) for name, *_ in plan.members)


def _landed(plan, counted):
    """Yield the steps of a ray at a surface: move there, score, change bodies, resume the ray."""
    passes = _lets_pass(plan)
    if passes:
        yield step(intersections.remember_ray)
    yield step(intersections.move)
    yield from stood(plan)
    if passes and (plan.sheets["outward"] != 0).any():
        yield step(landing.tell_leaving, rows_of(plan.sheets))
    yield from counted
    yield from boundaries(plan)
    if passes:
        yield step(intersections.resume_ray)


def _expected_metering(plan, layer):
    """Yield the steps that score rays at the detectors of a layer that they were cast to.

    A transparent detector is scored on both sides.
    """
    if not expects_on(plan, layer):
        return
    table = layer_of(plan, layer, plan.expected_layers[layer])
    yield step(detectors.look_up_meter, table)
    yield step(next_event.look_at_target_alone)
    for binning in (
        (detectors.bin_arrivals, detectors.bin_departures) if plan.acts else (detectors.bin_crossings,)
    ):
        if binning is detectors.bin_departures:
            yield step(next_event.look_through)
        yield step(binning, table)
        yield from refined(plan, table)
        yield scored(plan)
    yield step(next_event.pass_target, table)
