"""The steps of shadow rays where they come to a surface: through what lets them pass, and what they bring on the way."""

from transport.engine import expected_rays, flights, landings, meters
from transport.engine.arrivals import boundaries, refined, scored, stood, visits
from transport.engine.expectations import expects_on
from transport.engine.registry import layer_of, rows_of, step


def through(plan):
    """Steps of a shadow ray through what lets it pass, to the other side of the same ray."""
    if _lets_pass(plan):
        yield from _landed(plan, ())


def expected_crossing(plan):
    """Steps of an expected ray from arriving at a surface to leaving it, through what lets it pass."""
    counted = [each for layer in range(len(plan.layers)) for each in _expected_metering(plan, layer)]
    yield from _landed(plan, [*counted, *visits(plan), step(expected_rays.end_expected)])


def _lets_pass(plan):
    """Whether rays go on beyond anything."""
    return any(name.startswith(("cover", "bound")) for name, *_ in plan.members)


def _landed(plan, counted):
    """To the surface, what is counted there, and on beyond it."""
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
    """Count what rays bring to the meters of a layer that they were cast to, on both sides of what lets them pass."""
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
