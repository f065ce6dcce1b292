"""The findings of a run about its detectors and sources, as objects and as warnings.

No finding covers a batch of numbers that chance made wrong, light that leaves a scene through a gap that no
finding names, and errors of the scene itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from transport.results.choice import more_particles_cure
from transport.results.diagnostics.empty_detector import no_arrival_warning
from transport.results.diagnostics.sources import faint_sources
from transport.statistics.estimates import Estimate, EstimateOrArray
from transport.statistics.findings import (
    DOUBTFUL,
    NO_SCORE,
    NOTE,
    Finding,
    capitalized,
    note,
)
from transport.statistics.quality import Quality, quality_of
from transport.validation import join_names

if TYPE_CHECKING:
    from transport.results.record import Record

MAX_ADVISED_PARTICLES = 1e12  # particles


def quality_of_result(result: Record, name: str | EstimateOrArray) -> Quality:
    """The quality of the quantity "detector.quantity", or of an Estimate or EstimateArray."""
    seconds = result.cost.seconds if result.cost else math.nan
    if not isinstance(name, str):
        return quality_of(name, None, result.particles, seconds, more_particles_cure(result.choice))
    detector, _, quantity = name.partition(".")
    estimate = result.quantity(name)
    scores = result[detector].diagnosis.sizes_behind(quantity) if isinstance(estimate, Estimate) else None
    return quality_of(estimate, scores, result.particles, seconds, more_particles_cure(result.choice))


def findings_of(result: Record) -> tuple[Finding, ...]:
    """All findings to read before the numbers are used: of sources and particles, then of each detector."""
    scene = result.scene
    found = [note("lost particles", what) for what in _particle_messages(result)]
    found += [note("faint source", what) for what in faint_sources(result.plan, result.particles)]
    for detector in (*scene.meters, *scene.volumes, *scene.points, *scene.instruments, *scene.phase_spaces):
        found += result[detector.name].diagnosis.findings()
    if away := [other for other in scene.meters if result[other.name].diagnosis.cannot_arrive]:
        found.append(note("enclosed detector", no_arrival_warning(away)))
    found += [note("aim", what) for what in _aim_messages(result)]
    return tuple(found)


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
