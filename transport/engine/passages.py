"""Steps of shadow rays at surfaces: passage through transparent ones, and scores along the path."""

from transport.engine import expected_rays, flights, landings, meters
from transport.engine.arrivals import boundaries, refined, scored, stood, visits
from transport.engine.expectations import expects_on
from transport.engine.registry import layer_of, rows_of, step


def through(plan):
    """Yield the steps of a shadow ray through transparent surfaces, on along the same ray."""
    if _lets_pass(plan):
        yield from _landed(plan, ())


def expected_crossing(plan):
    """Yield the steps of a next-event ray from arrival at a surface to its other side."""
    counted = [each for layer in range(len(plan.layers)) for each in _expected_metering(plan, layer)]
    yield from _landed(plan, [*counted, *visits(plan), step(expected_rays.end_expected)])


def _lets_pass(plan):
    """Return whether the scene has transparent detectors or boundaries of media."""
    return any(name.startswith(("cover", "bound")) for name, *_ in plan.members)


def _landed(plan, counted):
    """Yield the steps of a ray at a surface: move there, score, change bodies, resume the ray."""
    passes = _lets_pass(plan)
    if passes:
        yield step(flights.remember_ray)
    yield step(flights.move)
    yield from stood(plan)
    if passes and (plan.sheets["outward"] != 0).any():
        yield step(landings.tell_leaving, rows_of(plan.sheets))
    yield from counted
    yield from boundaries(plan)
    if passes:
        yield step(flights.resume_ray)


def _expected_metering(plan, layer):
    """Yield the steps that score rays at the detectors of a layer that they were cast to.

    A transparent detector is scored on both sides.
    """
    if not expects_on(plan, layer):
        return
    table = layer_of(plan, layer, plan.expected_layers[layer])
    yield step(meters.look_up_meter, table)
    yield step(expected_rays.look_at_target_alone)
    for binning in (meters.bin_arrivals, meters.bin_departures) if plan.acts else (meters.bin_crossings,):
        if binning is meters.bin_departures:
            yield step(expected_rays.look_through)
        yield step(binning, table)
        yield from refined(plan, table)
        yield scored(plan)
    yield step(expected_rays.pass_target, table)
