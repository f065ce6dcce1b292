"""The findings of a run about its detectors and sources, as objects and as warnings.

No finding covers a batch of numbers that chance made wrong, light that leaves a scene through a gap that no
finding names, and errors of the scene itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from transport.results.choice import more_particles_cure
from transport.results.detectors import Reading
from transport.results.diagnostics.empty_detector import no_arrival_warning
from transport.results.diagnostics.path_classes import ALL_LIGHT
from transport.results.diagnostics.sources import faint_sources
from transport.results.points import PointReading
from transport.results.volumes import VolumeReading
from transport.statistics.estimates import Estimate, EstimateOrArray
from transport.statistics.findings import (
    DOUBTFUL,
    FEW_CARRIERS,
    NO_SCORE,
    NOTE,
    UNKNOWN,
    Finding,
    capitalized,
    particle_factors_needed,
    severities,
)
from transport.statistics.quality import Quality, Scores, quality_of
from transport.validation import SceneError, join_names

if TYPE_CHECKING:
    from transport.results.record import Record
from transport.results.tally import ARRIVALS, DEPARTURES

MAX_ADVISED_PARTICLES = 1e12  # particles
SCORE_LIMITED = ("path class", ALL_LIGHT, "strong rays", FEW_CARRIERS)  # whose bounds fall as scores arrive
MAX_UNCERTAIN_BINS = 0.05  # share of the scored bins that may have too few scores without a warning

SIDES = {
    "flux_in": ARRIVALS, "irradiance": ARRIVALS, "energy_in": ARRIVALS,
    "flux_out": DEPARTURES, "exitance": DEPARTURES, "energy_out": DEPARTURES,
}  # fmt: skip


def quality_of_result(result: Record, name: str | EstimateOrArray) -> Quality:
    """The quality of the quantity "detector.quantity", or of an Estimate or EstimateArray."""
    seconds = result.cost.seconds if result.cost else math.nan
    if not isinstance(name, str):
        return quality_of(name, None, result.particles, seconds, more_particles_cure(result.choice))
    detector, _, quantity = name.partition(".")
    estimate = result.quantity(name)
    scores = _scores_behind(result[detector], quantity) if isinstance(estimate, Estimate) else None
    return quality_of(estimate, scores, result.particles, seconds, more_particles_cure(result.choice))


def findings_of(result: Record) -> tuple[Finding, ...]:
    """All findings to read before the numbers are used: of sources and particles, then of each detector."""
    found = [_note("lost particles", what) for what in _particle_messages(result)]
    found += [_note("faint source", what) for what in faint_sources(result.plan, result.particles)]
    detectors = (*result.scene.meters, *result.scene.volumes, *result.scene.points, *result.scene.instruments)
    for detector in detectors:
        found += _detector_findings(result, result[detector.name])
    for space in result.scene.phase_spaces:
        reading = result[space.name]
        found += _bins_findings(reading, f"{reading.title}{reading.name!r}")
    if away := [other for other in result.scene.meters if result[other.name].cannot_arrive]:
        found.append(_note("enclosed detector", no_arrival_warning(away)))
    found += [_note("aim", what) for what in _aim_messages(result)]
    return tuple(found)


def _note(name: str, what: str, title: str = "") -> Finding:
    return Finding(NOTE, title, "", what, name=name)


def warnings_of(findings: Iterable[Finding], particles: int) -> list[str]:
    """A warning per finding that is a note or doubtful; equal findings of several detectors are merged."""
    alike: dict[tuple[str, str], list[Finding]] = {}
    ordered = []
    for finding in findings:
        if finding.severity == DOUBTFUL:
            key = (finding.what, finding.cure)
            if key not in alike:
                ordered.append(key)
            alike.setdefault(key, []).append(finding)
        elif finding.severity == NOTE:
            ordered.append(finding.what)
    return [each if isinstance(each, str) else _doubt_warning(alike[each], particles) for each in ordered]


def _doubt_warning(findings: list[Finding], particles: int) -> str:
    """The warning about a doubtful number of one or several detectors."""
    titles: dict[str, list[str]] = {}
    for finding in findings:
        titles.setdefault(finding.object, []).append(finding.quantity)
    names = join_names(
        [
            f"{join_names(list(filter(None, names)))} of {title}" if any(names) else title
            for title, names in titles.items()
        ]
    )
    first = findings[0]
    if first.what.startswith(NO_SCORE):
        return f"{names} {'has' if len(titles) == 1 else 'have'} {first.what}. {capitalized(first.cure)}"
    plural = len(titles) > 1 or any(len(quantities) > 1 for quantities in titles.values())
    seen = f" ({first.seen})" if first.seen else ""
    cure = _cure_with_number(first.cure, particles * max(finding.times for finding in findings))
    worst = max(findings, key=lambda finding: np.nan_to_num(finding.share))
    return (
        f"{names} {'are' if plural else 'is'} doubtful: {first.what}{worst.worth}{seen}. {capitalized(cure)}"
    )


def _cure_with_number(cure: str, particles: float) -> str:
    """The cure, with the approximate number of particles if it is known and within reach."""
    if not particles < MAX_ADVISED_PARTICLES:
        return cure
    power = 10 ** math.floor(math.log10(particles))
    return cure.replace(
        "more particles",
        f"about {math.ceil(particles / power) * power:.0e} particles".replace("e+0", "e").replace("e+", "e"),
    )


def _detector_findings(result: Record, reading) -> Iterator[Finding]:
    """A note if the detector has no score.

    Else the worst finding per total, or about its bins, beyond a note.
    """
    title = f"{reading.title}{reading.name!r}"
    if (note := reading.note) is not None:
        yield _note(*note, title)
    elif reading.is_blind:
        found = reading.why_unscored()
        reasons = [each for each in found if each.severity != NOTE and each.name != ALL_LIGHT]
        what = f"{NO_SCORE} in {result.particles} particle{'s' * (result.particles > 1)}: unknown, not 0"
        if reasons:
            yield Finding(
                DOUBTFUL, title, "", f"{what}; {reasons[0].what}", cure=reasons[0].cure, name=reasons[0].name
            )
        elif not reading.cannot_arrive:
            yield Finding(DOUBTFUL, title, "", what, cure=more_particles_cure(result.choice), name=UNKNOWN)
    else:
        found = [
            _in_quantity_unit(
                replace(
                    worst,
                    object=title,
                    quantity=name,
                    value=float(total.value),
                    times=_particle_factor(worst, total),
                ),
                reading,
            )
            for name, total in _totals(reading)
            if (worst := _worst_finding(total)) is not None
        ]
        yield from found
        if not any(each.severity == DOUBTFUL for each in found):
            yield from _bins_findings(reading, title)
        if isinstance(reading, Reading):
            yield from (replace(finding, quantity="fluence_rate") for finding in reading.grazing_findings())


def _particle_factor(finding: Finding, total: Estimate) -> float:
    """Factor of histories after which a finding is settled, if the number of scores predicts it; else nan."""
    if finding.name not in SCORE_LIMITED:
        return math.nan
    return max(particle_factors_needed([finding], total.value, total.error, total.allowed)[:2])


def _in_quantity_unit(finding: Finding, reading) -> Finding:
    """Convert a finding about a total to the unit of the quantity, if that is one number."""
    try:
        quantity = getattr(reading, finding.quantity, None)
    except SceneError:  # the quantity exists, but not for the bins of this detector
        quantity = None
    if not isinstance(quantity, Estimate) or not finding.value:
        return finding
    unit = quantity.value / finding.value
    return replace(finding, bound=finding.bound * unit, value=quantity.value)


def _worst_finding(quantity: EstimateOrArray) -> Finding | None:
    """The worst finding about a quantity beyond a note."""
    return next((each for each in quantity.findings if each.severity != NOTE), None)


def _bins_findings(reading, title: str) -> Iterator[Finding]:
    """The worst finding about the bins, if any bin is doubtful although the total is sound."""
    for name, array in reading.binned():
        worst = next(
            (each for each in array.findings if each.severity == DOUBTFUL and each.name != UNKNOWN),
            None,
        )
        if worst is not None:
            scored = array.value > 0
            doubtful = severities(worst, array.value, array.error, array.allowed) == DOUBTFUL
            many, of = int((doubtful & scored).sum()), int(scored.sum())
            if many > (MAX_UNCERTAIN_BINS * of if worst.name == "bins" else 0):
                seen = f"which matters in {many} of {of} bins"
                yield replace(worst, object=title, quantity=name, seen=seen)


def _totals(reading) -> Iterator[tuple[str, Estimate]]:
    """The total of a detector on each side, over its whole shape, all times and speeds."""
    if isinstance(reading, PointReading):
        yield "fluence_rate", reading.fluence_rate
    elif isinstance(reading, VolumeReading):
        yield "fluence_rate", reading.total
    elif isinstance(reading, Reading):
        for side, name in ((ARRIVALS, "flux_in"), (DEPARTURES, "flux_out")):
            is_requested = reading.has_weight(side) or (side == ARRIVALS and reading.may_arrive)
            if is_requested and not reading.is_sure(side):
                yield name, reading.total(side)
    else:
        yield from reading.totals()


def _particle_messages(result: Record) -> Iterator[str]:
    """Messages about lost particles and contradictory media, and about aims without births."""
    batches = result.batches
    if lost := sum(batch.lost for batch in batches):
        yield (
            f"{lost} histories were lost, and their weight is in the ledger as `lost`: a history in a finite"
            " body of a medium had no surface ahead (the surfaces leave a gap, or a ray ran along an edge),"
            " or had more than 2^24 events"
        )
    if unseen := sum(batch.unseen for batch in batches):
        yield (
            f"{unseen} times a particle left a body of a medium without having entered it: its surfaces"
            " leave a gap, or rays ran along an edge"
        )
    if astray := sum(batch.astray for batch in batches):
        yield (
            f"{astray} times light reached a Dielectric from a medium of another index than the surface"
            " separates: close its gaps, or give adjacent media the same index"
        )
    is_aimed = result.plan.adjoint is None and any(
        emitter.target is not None for emitter in result.plan.emitters
    )
    if is_aimed and sum(batch.born for batch in batches) == 0:
        yield "nothing is emitted towards the aim: it lies behind its source"


def _aim_messages(result: Record) -> Iterator[str]:
    """The detectors for which an aim does not cover every path."""
    scene = result.scene
    aims = [source.aim for source in scene.sources if source.aim is not None and result.plan.adjoint is None]
    for detector in scene.meters if aims else ():
        on_the_way = [
            other for other in scene.meters if other is detector or other.name in (detector.via or ())
        ]
        if any(aim not in [scene.shape_of(other) for other in on_the_way] for aim in aims):
            yield f"detector {detector.name!r} sees an aimed source only in the directions of its aim"
    for volume in scene.volumes if aims else ():
        if any(aim != scene.shape_of(volume) for aim in aims):
            yield f"volume detector {volume.name!r} sees an aimed source only in the directions of its aim"


def _scores_behind(reading: object, quantity: str) -> Scores | None:
    """The scores that add up to a quantity; None if their sizes are not known."""
    if isinstance(reading, PointReading) and quantity == "fluence_rate":
        return reading.score_sizes
    if isinstance(reading, Reading) and quantity in SIDES:
        return reading.scores_on(SIDES[quantity])
    if isinstance(reading, VolumeReading) and quantity in ("fluence_rate", "fluence"):
        return reading.score_sizes
    return None
