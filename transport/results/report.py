"""A result as text: energy balance, detectors, cost, price of the next digit, warnings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.methods import ANALOG, Method, detectors_without_next_event, methods_for
from transport.results.footprint import batches_that_fit, bytes_of_batch
from transport.results.record import RANDOM_SLOPE, Cost, Record
from transport.statistics.any_estimate import AnyEstimate
from transport.statistics.axes import POSITION, name_on_shape
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.findings import BOUNDED
from transport.statistics.notation import duration, percent
from transport.validation import join_names

if TYPE_CHECKING:
    from transport.results.choice import Choice
    from transport.scene.scene import Scene


# ---- The price of accuracy, predicted from the cost of a finished run: time ~ error^(1 / slope).

PRICED_DIGITS = 2  # below the present error, in a report


def price_of(quantity: AnyEstimate, cost: Cost, error: float, slope: float = RANDOM_SLOPE) -> float:
    """Seconds of a run for a relative error of the quantity, in its worst known bin that is not doubtful.

    nan if there is no such bin.  For the whole run, not its rest, on the same machine with as many threads.
    """
    relative = np.atleast_1d(quantity.relative_error)
    relative = relative[np.isfinite(relative) & ~np.atleast_1d(quantity._is_known_but_doubtful)]
    if not relative.size:
        return math.nan
    return float(cost.seconds * (relative.max() / error) ** (-1 / slope))


def price_lines(result: Record, name: str) -> list[str]:
    """A line with the price of the next digits of a detector's first known quantity.

    Empty if there is no such quantity.
    """
    slopes = result.cost.slopes if result.cost is not None else {}
    found = result[name].quantities if result.cost is not None else {}
    requested = [quantity for quantity in found if f"{name}.{quantity}" in slopes]
    known = (each for each in (*requested, *found) if _has_error(found[each]))
    if (quantity := next(known, None)) is None:
        return []
    present = price_of(found[quantity], result.cost, 1.0, RANDOM_SLOPE)
    if not 0 < present < math.inf:
        return []
    relative = math.sqrt(present / result.cost.seconds)
    first = math.ceil(-math.log10(relative) + 1e-9)
    errors = [10.0**-k for k in range(max(1, first), max(1, first) + PRICED_DIGITS)]
    prices = [f"{percent(e)} in {duration(result.price(f'{name}.{quantity}', e))}" for e in errors]
    sound = " that is not doubtful" if np.any(found[quantity]._is_known_but_doubtful) else ""
    worst = f" in its worst bin{sound}" if np.size(found[quantity].value) > 1 else ""
    return [f"price of {quantity}{worst}: {', '.join(prices)}"]


def _has_error(quantity: object) -> bool:
    """Return whether there is an error that a longer run would reduce."""
    if not isinstance(quantity, AnyEstimate):
        return False
    relative = np.asarray(quantity.relative_error)
    return bool(np.any((relative > 0) & np.isfinite(relative)))


# ---- The report.

MAX_LISTED_SEEDS = 6  # listed one by one
FEW_SCORES_PER_HISTORY = 0.1  # scores per history, below which another estimator may be better


def report_of(result) -> str:
    """The text of `result.report()`."""
    lines = [
        run_line(result),
        *memory_lines(result),
        *method_lines(result),
        *advice_lines(result),
        *tracking_lines(result),
        "",
        ledger_title(result),
        *(f"  {line}" for line in ledger_lines(result._own_ledger)),
    ]
    for detector in result.scene.detectors:
        reading = result[detector.name]
        lines += ["", reading.heading, *(f"  {line}" for line in bin_lines(reading))]
        for name, quantity in reading.quantities.items():
            lines.append(f"  {name:17s} {quantity if isinstance(quantity, Estimate) else repr(quantity)}")
        lines += [f"  {line}" for line in price_lines(result, detector.name)]
    lines += ["", *cost_lines(result)]
    warnings = result.warnings
    lines += [f"warning: {warning}" for warning in warnings] or [error_bar_line(result)]
    return "\n".join(lines)


def bin_lines(reading) -> list[str]:
    """The number of bins of each axis, its range and unit; bins of position by their names on the shape."""
    found = []
    for axis in getattr(reading, "axes", ()):
        name = axis.name
        if axis.group == POSITION:
            own = name_on_shape(name, reading.shape.coordinate_names)
            name += f" ({own})" if own != name else ""
        unit = "" if axis.unit == "1" else f" {axis.unit}"
        found.append(f"{name} {len(axis)}, {axis.edges[0]:.6g} to {axis.edges[-1]:.6g}{unit}")
    return [f"bins: {'; '.join(found)}"] if found else []


def error_bar_line(result) -> str:
    """The line about error bars without warnings; it makes no claim about unknown ones."""
    quantities = [q for detector in result.scene.detectors for q in result[detector.name].quantities.values()]
    unscored = any(isinstance(q, Estimate) and q.reason == "no score" for q in quantities)
    bins = [text for detector in result.scene.detectors if (text := _doubtful_bins(result[detector.name]))]
    known = [q for q in quantities if isinstance(q, Estimate) and q.reason is None]
    if not bins and any(q.verdict == BOUNDED for q in known):
        return "error bars: none is doubtful; the numbers show what may be missing"
    if not bins:
        return f"error bars: no finding against {'those that are known' if unscored else 'them'}"
    totals = f"those of the totals{' that are known' * unscored}"
    are = "is" if len(bins) == 1 and bins[0].startswith("1 ") else "are"
    return f"error bars: no finding against {totals}; {join_names(bins)} {are} doubtful"


def _doubtful_bins(reading) -> str:
    """The number of doubtful bins with known error in the quantity that has most of them, in words.

    "" for none.
    """
    arrays = dict(reading.binned()) or reading.quantities
    arrays = {name: array for name, array in arrays.items() if isinstance(array, EstimateArray)}
    many = {name: np.count_nonzero(array._is_known_but_doubtful) for name, array in arrays.items()}
    name = max(many, key=many.get, default="")
    if not many.get(name):
        return ""
    return f"{many[name]} of {np.count_nonzero(arrays[name]._is_known)} bins of '{reading.name}.{name}'"


def ledger_title(result) -> str:
    """The title of the ledger; for a backward run it names other entries."""
    if result.plan.adjoint is None:
        return "ledger"
    unsampled = "weight that the cosines of their cells leave out"
    if result.plan.adjoint.caustics is not None:
        unsampled += ", and births at lamps whose path does not begin at a specular surface"
    return f"ledger of the backward histories, as fractions of them (unsampled: {unsampled})"


def part_text(result) -> str:
    """The part of a run that a result covers, such as "; part 1 of 4 of a run of 2e8"; "" for a whole run."""
    if result.state is None or result.state.limits.particles is None:
        return ""
    limits = result.state.limits
    (one, of), requested = limits.part, f" of {limits.particles:_} requested" * (not result.is_complete)
    return f"; part {one} of {of} of a run of {limits.particles:_}" if of > 1 else requested


def ledger_lines(ledger) -> list[str]:
    """One line per entry of the energy balance; the absorption of each surface follows `absorbed`."""
    entries = [(f"  {name}" if is_part else name, each) for name, each, is_part in printed_entries(ledger)]
    width = max(10, *(len(name) for name, _ in entries)) if entries else 0
    return [f"{name:{width}s} {estimate}" for name, estimate in entries]


def printed_entries(ledger) -> Iterator[tuple[str, Estimate, bool]]:
    """The nonzero entries: name, estimate, and whether it is a part of `absorbed`."""
    for name, estimate in ledger.items():
        if _is_printed(name, estimate):
            yield name, estimate, False
            if name == "absorbed" and len(ledger.absorbed_by) > 1:
                shares = {by: share for by, share in ledger.absorbed_by.items() if _is_printed(by, share)}
                yield from ((f"by {by}", share, True) for by, share in shares.items())


def cost_lines(result) -> list[str]:
    """Lines about the cost of the run and of the next digit."""
    cost = result.cost
    if cost is None:
        return []
    threads = _number_text(cost.threads, "thread")
    threads += f" of {_number_text(cost.workers, 'worker')}" if cost.workers else ""
    collisions = f" {cost.collisions:.3g} collisions," if cost.collisions else ""
    lines = [
        f"cost: {cost.seconds:.3g} s on {threads}, {cost.particles:.3g} particles,"
        f" {cost.crossings:.3g} crossings,{collisions} {cost.particles_per_second / 1e6:.3g} M particles/s"
    ]
    # Mention particles of pilots and earlier rounds, which only chose settings, and the forecast of a pilot.
    if (earlier := cost.particles - result.particles) > 0:
        lines.append(f"pilots: {earlier:.3g} of them, which are not part of the result")
    if (plan := cost.forecast) is not None:
        after, seconds = duration(plan.after), duration(plan.seconds)
        lines.append(f"forecast: {seconds} and {plan.particles:.3g} particles, made after {after}")
    return [*lines, f"next digit: a tenth of every error costs about {duration(cost.next_digit)}"]


def _number_text(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number > 1)}"


def method_lines(result) -> list[str]:
    """The estimator, unless it is the default, why pilots chose it, and the time that a guide took."""
    method, cost = result.plan.method, result.cost
    lines = [f"estimator: {method.title}{_analog_detectors(result)}"] if method != ANALOG else []
    lines = lines if result.choice is None else [f"estimator: {method.title}", *result.choice.lines]
    if method.guide and cost is not None:
        lines.append(f"preparation: {duration(cost.preparation)}, in which the guide was learnt")
    caustics = result.plan.adjoint.caustics if result.plan.adjoint is not None else None
    if caustics is not None:
        walls = f"walls that {join_names(list(map(repr, caustics.views)))} see"
        share = f"histories: {caustics.share:.3g} of the histories start at lamps"
        lines.append(f"{share}, for light via specular surfaces and {walls}")
    return lines


def advice_lines(result) -> list[str]:
    """A line with estimators that suit the scene better, if few histories reach a detector."""
    scene = result.scene
    if result.plan.method != ANALOG or result.choice is not None:
        return []
    seldom = [
        detector.name
        for detector in scene.meters
        if not result[detector.name].is_blind
        and result[detector.name].number_of("weight in") < FEW_SCORES_PER_HISTORY * result.particles
    ]
    others = other_estimators(scene, ANALOG, None) if seldom else ""
    names = join_names(list(map(repr, seldom)))
    return [f"estimator: analog; few histories reach {names}, for which {others}"] if others else []


def other_estimators(scene: Scene, taken: Method, choice: Choice | None) -> str:
    """The other estimators that suit a scene, as a clause; "" if there are none or pilots compared them."""
    names = [each.estimator for each in methods_for(scene) if each.sampling == taken.sampling]
    others = [repr(name) for name in names if name != taken.estimator]
    if not others or choice is not None:
        return ""
    them = "them" if len(others) > 1 else "it"
    return f"{' or '.join(others)} may suit better: estimator='auto' tries {them}"


def memory_lines(result) -> list[str]:
    """A line that explains why there are fewer batches than usual, if the user did not set their number."""
    state, usual = result.state, result.plan.method.default_batches
    if state is None or not state.limits.is_free or batches_that_fit(result.plan) >= usual:
        return []
    size = bytes_of_batch(result.plan) / 1e6
    return [f"batches: fewer than the usual {usual}, because the sums of one take up to {size:.3g} MB"]


def _analog_detectors(result) -> str:
    """The detectors with analog scores in a run with next-event estimation, in words."""
    has_rays = result.plan.sends_shadow_rays and result.plan.adjoint is None
    names = detectors_without_next_event(result.scene) if has_rays else []
    return f" ({', '.join(map(repr, names))} by analog scores)" if names else ""


def tracking_lines(result) -> list[str]:
    """Lines about the tracking of histories through media, and about options without effect."""
    plan, tracking = result.plan, result.plan.tracking
    if not (plan.scatters or plan.reduces_weights):
        idle = "tracking: without effect, because no medium here absorbs or scatters"
        return [idle] if result.asked is not None else []
    how = {"analog": "analog absorption", "weighted": "absorption by weight"}[tracking.absorption]
    extras = ["first collisions forced"] * plan.forces_collisions
    if plan.splits:
        extras.append(f"split by importance, gain {tracking.splitting.gain:g}")
    if tracking.forced > plan.forces_collisions:
        extras.append("no collisions to force")
    if tracking.splitting is not None and not plan.splits:
        extras.append("nothing to split: no collisions")
    return [f"tracking: {', '.join([how, *extras])}"]


def run_line(result) -> str:
    """The size of the run, and whether it is complete."""
    state = part_text(result) + ("" if result.is_complete else ", INCOMPLETE: interrupted")
    seeds = sorted({batch.seed for batch in result.batches})
    seed_text = f"seed {result.seed}" if len(seeds) == 1 else f"seeds {', '.join(map(str, seeds))}"
    if len(seeds) > MAX_LISTED_SEEDS:
        seed_text = f"{len(seeds)} seeds from {seeds[0]} to {seeds[-1]}"
    return f"{result.particles:_} particles in {len(result.run)} batches, {seed_text}{state}"


def _is_printed(name: str, estimate: Estimate) -> bool:
    """Return whether an entry is printed: `lost` always, others unless they are zero by construction."""
    return name == "lost" or not (estimate.exact and estimate.value == 0)
