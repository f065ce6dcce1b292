"""The findings of a run about its detectors and sources, as objects and as warnings.

No finding covers a batch of numbers that chance made wrong, light that leaves a scene through a gap that no
finding names, and errors of the scene itself.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from transport.results.choice import more_particles_cure
from transport.results.diagnostics.empty_detector import no_arrival_warning
from transport.results.diagnostics.table import DIAGNOSTICS
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


def quality_of_result(result: Record, name: str | EstimateOrArray) -> Quality:
    """The quality of the quantity "detector.quantity", or of an Estimate or EstimateArray."""
    seconds = result.cost.seconds if result.cost else math.nan
    if not isinstance(name, str):
        return quality_of(name, None, result.particles, seconds, more_particles_cure(result.choice))
    detector, _, quantity = name.partition(".")
    estimate = result.quantity(name)
    scores = result[detector].diagnosis.sizes_behind(quantity) if isinstance(estimate, Estimate) else None
    return quality_of(estimate, scores, result.particles, seconds, more_particles_cure(result.choice))


def findings_of(
    result: Record, read: Mapping[str, Collection[str]] = MappingProxyType({})
) -> tuple[Finding, ...]:
    """All findings to read before the numbers are used: of the whole run, then of each detector.

    read: the scores of which numbers were read, by detector: of these detectors there are findings about such
    numbers alone, as of departures where arrivals were not read.
    """
    scene = result.scene
    found = [note(check.name, what) for check in DIAGNOSTICS if check.run for what in check.run(result)]
    away = [each for each in scene.meters if result[each.name].diagnosis.cannot_arrive]
    if away := [e for e in away if result[e.name].diagnosis.concerns("flux_in", read.get(e.name, ()))]:
        found.append(note("enclosed detector", no_arrival_warning(away)))
    for detector in (*scene.meters, *scene.volumes, *scene.points, *scene.instruments, *scene.phase_spaces):
        found += result[detector.name].diagnosis.findings(read.get(detector.name, ()))
    return tuple(found)


def warnings_of(findings: Iterable[Finding]) -> list[str]:
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
    return [each if isinstance(each, str) else _doubt_warning(alike[each]) for each in ordered]


def _doubt_warning(findings: list[Finding]) -> str:
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
    others = next((f"; {each.others}" for each in findings if each.others), "")
    cure = max(findings, key=lambda finding: np.nan_to_num(finding.particles)).advice
    worst = max(findings, key=lambda finding: np.nan_to_num(finding.share))
    what = f"{first.what}{worst.worth}{seen}{others}"
    return f"{names} {'are' if plural else 'is'} doubtful: {what}. {capitalized(cure)}"
