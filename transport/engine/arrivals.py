"""Steps at the end of a flight: land on the sheet, score at detectors, mark visits, change bodies."""

from transport.compile.sizes import is_dense, size_row
from transport.engine import bodies, histories, landings, meshes, meters, quadrics, refinements, sizes
from transport.engine.expectations import given_back, held_back
from transport.engine.registry import layer_of, named, rows_of, step

# Bins of time and speed are the outer blocks of rows, so they come first.
REFINEMENTS = ("time", "speed", "cosine", "azimuth", "place", "cell")


def stood(plan):
    """Yield the steps that set the sheet, its normal and the cosine of incidence."""
    yield step(landings.stand_on_sheet, rows_of(plan.sheets))
    if plan.is_curved:
        yield step(landings.put_back_on_sphere, rows_of(plan.sheets))
    if plan.has_quadrics:
        yield step(quadrics.put_back_on_quadric, rows_of(plan.curved_sheets))
    if plan.meshes:
        yield step(meshes.stand_on_facet, rows_of(plan.meshed_sheets))
    yield step(landings.take_cosine)


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
            yield step(meters.look_up_meter, table)
        if not is_born:
            yield from held_back(plan, layer, passing=binning is meters.bin_departures)
        yield step(binning, table)
        yield from refined(plan, table)
        yield scored(plan, is_dense(plan, rows))
        if plan.moments is not None:
            yield step(meters.score_moments, plan.moments)
        if not is_born:
            yield from given_back(plan, layer)


def scored(plan, by_nearly_all=False):
    """Return the step that adds scores to their rows and, where they differ, counts their sizes.

    by_nearly_all: nearly every lane has a bin.
    """
    if plan.size_cells:
        return step(sizes.score_all_and_size if by_nearly_all else sizes.score_and_size, size_row(plan))
    return step(meters.score_all if by_nearly_all else meters.score)


def refined(plan, table):
    """Yield the steps of further bin axes and of `via` and `events` of a layer's detectors."""
    if plan.axes | plan.filters:
        yield step(refinements.know_meter, table)
    for what in sorted(plan.filters):
        yield named((f"require_{what}", table))
    for axis in REFINEMENTS:
        if axis in plan.axes:
            yield named((f"refine_by_{axis}", table))


def visits(plan):
    """Yield the steps that mark visits for `via`, after all detectors of this crossing."""
    for layer, rows in enumerate(plan.layers):
        if (rows["mark"] != 0).any():
            yield step(histories.mark_visit, layer_of(plan, layer))


def boundaries(plan):
    """Yield the steps that update the set of bodies for the side that lanes leave to."""
    if plan.bounds_bodies:
        for layer, rows in enumerate(plan.layers):
            if (rows["front"] != rows["back"]).any():
                yield step(bodies.cross_boundary, layer_of(plan, layer))
