"""The steps of arriving somewhere: stand on the sheet, count at its meters, know the bodies on its other side."""

from transport.compile.sizes import is_dense, size_row
from transport.engine import bodies, histories, landings, meshes, meters, quadrics, refinements, sizes
from transport.engine.expectations import given_back, held_back
from transport.engine.registry import layer_of, named, rows_of, step

# Times and speeds lie in blocks, so they come first.
REFINEMENTS = ("time", "speed", "cosine", "azimuth", "place", "cell")


def stood(plan):
    """On the sheet, with its normal and the cosine of incidence."""
    yield step(landings.stand_on_sheet, rows_of(plan.sheets))
    if plan.is_curved:
        yield step(landings.put_back_on_sphere, rows_of(plan.sheets))
    if plan.has_quadrics:
        yield step(quadrics.put_back_on_quadric, rows_of(plan.curved_sheets))
    if plan.meshes:
        yield step(meshes.stand_on_facet, rows_of(plan.meshed_sheets))
    yield step(landings.take_cosine)


def metering(plan, binning, is_known=False, is_born=False):
    """Count at every layer's meters; is_known: the lanes have looked up their only meter at this crossing already.

    is_born: they leave their birthplace.
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
    """Enter the scores into their rows, and count their sizes where these differ."""
    if plan.size_cells:
        return step(sizes.score_all_and_size if by_nearly_all else sizes.score_and_size, size_row(plan))
    return step(meters.score_all if by_nearly_all else meters.score)


def refined(plan, table):
    """The finer bins of a layer's meters, and what they ask of a history."""
    if plan.axes | plan.filters:
        yield step(refinements.know_meter, table)
    for what in sorted(plan.filters):
        yield named((f"require_{what}", table))
    for axis in REFINEMENTS:
        if axis in plan.axes:
            yield named((f"refine_by_{axis}", table))


def visits(plan):
    """Mark what detectors ask for in `via`, after all meters of this crossing."""
    for layer, rows in enumerate(plan.layers):
        if (rows["mark"] != 0).any():
            yield step(histories.mark_visit, layer_of(plan, layer))


def boundaries(plan):
    """Know the bodies on the side that lanes leave to."""
    if plan.bounds_bodies:
        for layer, rows in enumerate(plan.layers):
            if (rows["front"] != rows["back"]).any():
                yield step(bodies.cross_boundary, layer_of(plan, layer))
