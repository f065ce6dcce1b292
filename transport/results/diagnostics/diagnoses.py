"""What a run may have missed of each detector: a diagnosis per kind of tally.

A tally's scores carry the findings of its diagnosis, so that all its quantities have them.  A diagnosis also
explains a detector without a score, and finds what is worst about the total and about the bins.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from transport.compile.layout import DIFFUSE
from transport.compile.points import scatters_anywhere
from transport.geometry.shape import Point
from transport.results.backward import BackwardReading, ViewReading
from transport.results.choice import more_particles_cure
from transport.results.detectors import BINS, Reading
from transport.results.diagnostics.depth import optical_depth_message, survivor_findings
from transport.results.diagnostics.empty_detector import (
    cannot_arrive,
    is_on_surface,
    no_light_departs,
    no_light_message,
)
from transport.results.diagnostics.nearby import (
    detector_forward_peaks,
    detector_unvisited_findings,
    grazing_findings,
    near_emitter_findings,
    point_forward_peaks,
    unvisited_surface_findings,
)
from transport.results.diagnostics.path_classes import (
    ALL_LIGHT,
    PathClass,
    cell_path_findings,
    detector_path_findings,
    pixel_path_findings,
)
from transport.results.diagnostics.proofs import max_transmitted_weight
from transport.results.diagnostics.score_sizes import (
    detector_scores,
    equal_scores,
    point_detector_scores,
    single_cell_scores,
)
from transport.results.phase_space import PhaseReading
from transport.results.points import PointReading
from transport.results.tally import Tally, scores_behind
from transport.results.volumes import VolumeReading
from transport.scene.bodies import max_absorption
from transport.scene.points import PointDetector
from transport.statistics.chunked import ChunkedArray, batch_totals
from transport.statistics.estimates import Estimate
from transport.statistics.findings import (
    DOUBTFUL,
    FEW_CARRIERS,
    MORE_PARTICLES,
    NO_SCORE,
    NOTE,
    UNKNOWN,
    Finding,
    doubtful,
    note,
    particle_factors_needed,
    severities,
)
from transport.statistics.quality import Scores, findings_of_error, with_cure
from transport.units import Unit
from transport.validation import SceneError

if TYPE_CHECKING:
    from transport.results.record import Record

SCORE_LIMITED = ("path class", ALL_LIGHT, "strong rays", FEW_CARRIERS)  # whose bounds fall as scores arrive
WEIGHT_IN, WEIGHT_OUT = Reading.main  # scores of the two sides
SLANT = "slant"  # kind of the scores of fluences
MAX_UNCERTAIN_BINS = 0.05  # share of the scored bins that may have too few scores without a warning
MOVE_IT = ", or move the detector: it may lie outside of the room or within a solid"


class Diagnosis:
    """What a run may have missed of one tally; the base class finds it of no score.

    result: the run;  tally: of which `main` scores are diagnosed.
    """

    cannot_arrive = False  # whether geometry proves that no light arrives, though some may depart

    def __init__(self, result: Record, tally: Tally) -> None:
        self.tally, self.plan, self.scene = tally, result.plan, result.scene
        self.allowed, self.more = result.allowed_of(tally.name), more_particles_cure(result.choice)
        self._found: dict[str, tuple[list[Finding], list[Finding]]] = {}

    # ---- findings of a score ----

    def judged(self, made: Any, findings: Callable[[], Iterable[Finding]]) -> Any:
        """Return an estimate with findings about this detector, judged by the requested error."""
        return made._with_findings(
            lambda: (replace(each, object=self.tally.title) for each in findings()), self.allowed
        )

    def missing(self, score: str, is_whole: bool = True) -> list[Finding]:
        """Findings about a score, with bounds as means per history; is_whole: for all bins together."""
        if score not in self._found:
            found = self._path_findings(score), self._error_findings(score)
            self._found[score] = tuple([*with_cure(each, self.more)] for each in found)
        of_paths, of_error = self._found[score]
        return of_paths + of_error if is_whole else of_paths

    def _path_findings(self, score: str) -> Iterable[Finding]:
        """Findings about classes of paths found by chance, and from geometry and the energy balance."""
        return ()

    def _error_findings(self, score: str) -> Iterable[Finding]:
        """Findings from the sizes of the scores and from the batches."""
        total = self.whole(score)
        if total.error > 0 and not self.is_sure(score):
            return findings_of_error(total, self.score_sizes(score), self.tally.particles)
        return ()

    def is_sure(self, score: str) -> bool:
        """Return whether all histories score the same in all bins together, or surely nothing."""
        return False

    def whole(self, score: str) -> Estimate:
        """Return the mean of a score per history in all bins together, without findings."""
        tally = self.tally
        means = batch_totals(tally.sums(score)) / tally.run.sizes
        return Estimate(means, tally.run, Unit(), self.is_sure(score), tally.number_of(score))

    def total(self, score: str) -> Estimate:
        """Return the same with findings."""
        return self.judged(self.whole(score), lambda: self.missing(score))

    def score_sizes(self, score: str) -> Scores | None:
        """Return how often a score had which size; None if that is not known."""
        return None

    def sizes_behind(self, quantity: str) -> Scores | None:
        """Return the same for the one score of which a quantity is made."""
        names = scores_behind(type(self.tally), quantity)
        return self.score_sizes(*names) if len(names) == 1 and names[0] in self.tally.main else None

    # ---- a detector without a score ----

    @cached_property
    def dark_reason(self) -> str | None:
        """Why no light can reach the detector, if geometry proves it."""
        return no_light_message(self.scene, self.tally.title, self.tally.shape, self.tally.detector)

    @cached_property
    def note(self) -> Finding | None:
        """The reason why the detector has no score; None if it has scores or no reason is known."""
        tally = self.tally
        has_scored = not tally.is_blind and any(map(tally.has_weight, tally.main))
        if not tally.main or has_scored:
            return None
        deep = self.dark_reason or optical_depth_message(tally)
        return note("enclosed detector" if self.dark_reason else "optical depth", deep) if deep else None

    def _unscored_findings(self) -> Iterator[Finding]:
        """The finding about a detector without a score, with the class of paths that may explain it."""
        tally, particles = self.tally, self.tally.particles
        what = f"{NO_SCORE} in {particles} particle{'s' * (particles > 1)}: unknown, not 0"
        missing = (each for score in tally.main for each in self.missing(score) if each.name != ALL_LIGHT)
        if (reason := next(missing, None)) is not None:
            yield doubtful(reason.name, f"{what}; {reason.what}", cure=reason.cure)
        elif not self.cannot_arrive:
            yield doubtful(UNKNOWN, what, cure=f"{self.more}{MOVE_IT}")

    # ---- the worst findings ----

    def totals(self) -> Iterator[tuple[str, Estimate]]:
        """Yield the quantities whose totals are judged, over the whole shape, all times and speeds."""
        return iter(())

    def findings(self, read: Collection[str] = ()) -> list[Finding]:
        """Return the findings to read before the numbers are used.

        read: names of the scores of which numbers were read, for those alone; without any for all numbers.
        """
        particles = self.tally.particles
        found = self._findings(read)
        return [replace(each, object=self.tally.title, particles=each.times * particles) for each in found]

    def _findings(self, read: Collection[str]) -> Iterator[Finding]:
        """A note if there is no score; else the worst finding per total, or about the bins, beyond a note."""
        if self.note is not None:
            yield self.note
        elif self.tally.is_blind:
            yield from self._unscored_findings()
        else:
            totals = [(name, total) for name, total in self.totals() if self.concerns(name, read)]
            found = [each for name, total in totals for each in self._worst_finding(name, total)]
            yield from found
            if not any(each.severity == DOUBTFUL for each in found):
                yield from self._bins_findings(read)
            if self.concerns("fluence_rate", read):
                yield from (replace(each, quantity="fluence_rate") for each in self.grazing())

    def concerns(self, quantity: str, read: Collection[str]) -> bool:
        """Return whether a doubt about a quantity matters to a reader of numbers made of these scores."""
        return True

    def _worst_finding(self, name: str, total: Estimate) -> Iterator[Finding]:
        """The worst finding about a total beyond a note, in the unit of its quantity if it is one number."""
        found = [each for each in total.findings if each.severity != NOTE]
        if not found:
            return
        worst, *rest = found
        # Few scores of light, and few that carry the error, are one doubt.
        known = (FEW_CARRIERS, ALL_LIGHT) if worst.name in (FEW_CARRIERS, ALL_LIGHT) else (worst.name,)
        more = sum(each.severity == DOUBTFUL and each.name not in known for each in rest)
        times = math.nan  # the number of scores predicts it for some
        if worst.name in SCORE_LIMITED:
            times = max(particle_factors_needed([worst], total.value, total.error, total.allowed)[:2])
        worst = replace(worst, quantity=name, value=float(total.value), times=times)
        try:
            quantity = getattr(self.tally, name, None)
        except SceneError:  # the quantity exists, but not for the bins of this detector
            quantity = None
        if isinstance(quantity, Estimate) and worst.value:
            unit = quantity.value / worst.value
            worst = replace(worst, bound=worst.bound * unit, value=quantity.value)
        if more and quantity is not None:
            where = f"result.quality('{self.tally.name}.{name}')"
            worst = replace(worst, others=f"{where} lists {more} more doubtful finding{'s' * (more > 1)}")
        yield worst

    def _bins_findings(self, read: Collection[str]) -> Iterator[Finding]:
        """The worst finding about the bins, if any bin is doubtful although the total is sound."""
        for name, array in self.tally.binned():
            if not self.concerns(name, read):
                continue
            doubts = (each for each in array.findings if each.severity == DOUBTFUL and each.name != UNKNOWN)
            if (worst := next(doubts, None)) is not None:
                scored = array.value > 0
                is_doubtful = severities(worst, array.value, array.error, array.allowed) == DOUBTFUL
                many, of = int((is_doubtful & scored).sum()), int(scored.sum())
                if many > (MAX_UNCERTAIN_BINS * of if worst.name == "bins" else 0):
                    seen, bound = f"which matters in {many} of {of} bins", np.abs(worst.bound)
                    # Particles after which it matters in few bins: bounds fall as 1/N, errors as 1/sqrt(N).
                    with np.errstate(all="ignore"):
                        factors = np.fmin((bound / array.error) ** 2, bound / (array.allowed * array.value))
                    times = float(np.quantile(np.where(scored, factors, 1.0), 1 - MAX_UNCERTAIN_BINS))
                    yield replace(worst, quantity=name, seen=seen, times=times)

    def grazing(self) -> Iterable[Finding]:
        """Findings about the fluence rate alone."""
        return ()


class DetectorDiagnosis(Diagnosis):
    """What a run may have missed of a Detector's arrivals and departures."""

    tally: Reading

    def __init__(self, result: Record, tally: Reading) -> None:
        super().__init__(result, tally)
        self._dark: dict[str, bool] = {}

    def is_dark(self, score: str) -> bool:
        """Return whether geometry proves that nothing arrives or departs."""
        if score not in self._dark:
            self._dark[score] = not self.tally.has_scores(score) and self._is_surely_dark(score)
        return self._dark[score]

    def _is_surely_dark(self, score: str) -> bool:
        tally = self.tally
        if score == WEIGHT_OUT and no_light_departs(self.scene, tally.shape, tally.detector):
            return True
        return (tally.is_blind and bool(self.dark_reason)) or (score == WEIGHT_IN and self.cannot_arrive)

    def is_sure(self, score: str) -> bool:
        """Return whether arrivals or departures are equal for all histories or surely absent."""
        return (score == WEIGHT_OUT and self._departs_exactly_once) or self.is_dark(score)

    @cached_property
    def _departs_exactly_once(self) -> bool:
        """Whether by construction every history leaves the detector's side exactly once."""
        plan, detector, shape = self.plan, self.tally.detector, self.tally.shape
        is_picky = any(getattr(detector, name) is not None for name in ("times", "speeds", "via", "events"))
        is_plain = not (is_picky or plan.has_acting_surfaces or plan.has_media or shape.triangles)
        return is_plain and all(
            plan.scene.shape_of(source) == shape
            and source.emission.has_side
            and source.is_back == detector.is_back
            and source.aim is None
            and (not shape.is_closed or not source.is_back)
            for source in plan.scene.sources
        )

    @cached_property
    def cannot_arrive(self) -> bool:
        """Whether geometry proves that no light arrives at this side, while some may depart."""
        tally = self.tally
        if tally.has_scores(WEIGHT_IN) or (tally.is_blind and self.dark_reason):
            return False
        return cannot_arrive(self.scene, tally.shape, tally.detector, tally.is_blind)

    def concerns(self, quantity: str, read: Collection[str]) -> bool:
        """Return whether the reader read anything of the same side; of a fluence, whether any fluence."""
        scores = scores_behind(type(self.tally), quantity)
        if not read or not scores:
            return True
        kinds = {score.rpartition(" ")[0] for score in read}
        if all(score.startswith(SLANT) for score in scores):
            return SLANT in kinds
        return not {score.rpartition(" ")[2] for score in scores}.isdisjoint(
            score.rpartition(" ")[2] for score in read
        )

    def totals(self) -> Iterator[tuple[str, Estimate]]:
        """Yield the flux on each side that the user reads: on a surface or a source departures alone."""
        tally = self.tally
        for score, name in ((WEIGHT_IN, "flux_in"), (WEIGHT_OUT, "flux_out")):
            is_requested = tally.has_weight(score) or (
                score == WEIGHT_IN
                and not is_on_surface(tally.scene, tally.shape, tally.detector)
                and not self.is_dark(score)
            )
            if is_requested and not self.is_sure(score):
                yield name, self.total(score)

    def _path_findings(self, score: str) -> Iterator[Finding]:
        if self.is_sure(score):
            return
        tally, total = self.tally, self.whole(score)
        yield from detector_path_findings(tally, tally.main.index(score), total)
        if tally.detector.events is None or tally.detector.events[1] > 0:
            by = BINS if tally.scores[score].rows.inner else None
            yield from survivor_findings(tally, total, score, by)
        if score == WEIGHT_IN:
            yield from detector_unvisited_findings(tally, total)
            yield from detector_forward_peaks(tally, total)

    def score_sizes(self, score: str) -> Scores | None:
        """Return the scores of one side by size."""
        found = detector_scores(self.tally, self.tally.main.index(score))
        # Sobol points leave no gaps: the error is far below the spacing of single scores; no larger score is
        # due.
        is_even = self.plan.method.sampling == "sobol"
        return replace(found, most=0.0) if found is not None and is_even else found

    def grazing(self) -> Iterator[Finding]:
        """Yield the finding about the fluence rate alone."""
        return grazing_findings(self.tally)


class VolumeDiagnosis(Diagnosis):
    """What a run may have missed of a VolumeDetector, with bounds as mean path length times weight.

    Lengths are in scene lengths.
    """

    tally: VolumeReading

    def missing(self, score: str, is_whole: bool = True) -> list[Finding]:
        """Findings about a score, the same for single cells as for the whole volume."""
        return super().missing(score)

    def _path_findings(self, score: str) -> Iterator[Finding]:
        tally, plan = self.tally, self.plan
        if tally.is_blind and self.note:
            return
        what, number, total = "light", tally.number_of(score), self.whole(score)
        largest = 2 * tally.shape.extent / tally.unit  # the longest chord
        if plan.attenuates and not plan.scatters:
            passes = max_transmitted_weight(plan, tally.shape)
            largest *= passes
            # Many paths of small weight do not represent those of full weight.
            weight = batch_totals(tally.sums(score)).sum()
            heavy = int(weight / (self._mean_chord_score * passes)) if passes > 0 else number
            if heavy < number:
                what, number = "light that media hardly attenuate", heavy
        yield from PathClass(what, number, largest, MORE_PARTICLES, name=ALL_LIGHT).findings(tally.particles)
        cells = () if tally.cells else None
        yield from survivor_findings(tally, total, score, cells, self._mean_cell_chord)

    def total(self, score: str) -> Estimate:
        """Return the mean path length times weight through the whole volume, with its findings."""
        uncounted = Estimate(self.whole(score).values, self.tally.run, Unit())
        return self.judged(uncounted, lambda: self.missing(score))

    def totals(self) -> Iterator[tuple[str, Estimate]]:
        """Yield the fluence rate of the whole volume."""
        yield "fluence_rate", self.total("path")

    def score_sizes(self, score: str) -> Scores:
        """Return the scores in all cells, counted as if they had one size."""
        return equal_scores(self.tally.number_of(score))

    @property
    def _mean_chord_score(self) -> float:
        """Score of full weight along a mean chord, 4 V / A (Cauchy), at most absorption [scene lengths]."""
        shape, unit = self.tally.shape, self.tally.unit
        chord, absorption = shape.mean_chord, max_absorption(self.plan.scene, shape)
        return (-math.expm1(-absorption * chord) / absorption if absorption > 0 else chord) / unit

    @property
    def _mean_cell_chord(self) -> float:
        """Approximate mean chord of a cell [scene lengths]: four times its volume over its area (Cauchy)."""
        shape, unit, counts = self.tally.shape, self.tally.unit, tuple(map(len, self.tally.cells))
        if len(counts) > 1:
            sides = shape.size if len(counts) == 3 else (shape.radius, shape.height)
            return 2 / sum(count / side for side, count in zip(sides, counts, strict=True)) / unit
        return shape.mean_chord / unit / max(math.prod(counts), 1)


class PointDiagnosis(Diagnosis):
    """What a run may have missed of a PointDetector, with bounds as fluence rates [W m^-2]."""

    tally: PointReading

    def is_sure(self, score: str) -> bool:
        """Return whether all histories start at one point, and nothing scatters or reflects them."""
        plan = self.plan
        is_one = len(plan.emitters) == 1 and isinstance(plan.emitters[0].shape, Point)
        return is_one and not scatters_anywhere(plan) and DIFFUSE not in plan.materials

    def whole(self, score: str) -> Estimate:
        """Return the fluence rate."""
        return self.tally.fluence_rate

    def _path_findings(self, score: str) -> Iterator[Finding]:
        tally, fluence = self.tally, self.tally.fluence_rate
        if tally.is_blind or fluence.exact:
            return
        yield from near_emitter_findings(tally, fluence)
        yield from unvisited_surface_findings(tally, 0.0, fluence.value / 4)
        yield from point_forward_peaks(tally)

    def totals(self) -> Iterator[tuple[str, Estimate]]:
        """Yield the fluence rate."""
        yield "fluence_rate", self.tally.fluence_rate

    def score_sizes(self, score: str) -> Scores:
        """Return the scores by size."""
        return point_detector_scores(self.tally)


class _CellDiagnosis(Diagnosis):
    """What a backward run may have missed of a detector at which its histories start."""

    tally: BackwardReading | ViewReading

    @cached_property
    def note(self) -> Finding | None:
        """A note about its histories, or the reason why none reached a source."""
        if self.tally.is_blind:
            return note("enclosed detector", self.dark_reason) if self.dark_reason else None
        sums = self.tally.cell_sums
        what = (
            f"batches are smaller than the {sum(part.cells for part in sums.parts)} bins of"
            f" {self.tally.name!r}, which adds noise; use more particles or fewer batches"
        )
        return note("thin batches", what) if sums.is_thin else None


class BackwardDiagnosis(_CellDiagnosis, DetectorDiagnosis):
    """What a backward run may have missed of a Detector's arrivals."""

    tally: BackwardReading

    def _path_findings(self, score: str) -> Iterator[Finding]:
        if self.is_dark(score):
            return
        extents = self.tally.extents
        unit = sum(float(each.sum()) for each in extents) / self.plan.unit
        for finding in cell_path_findings(self.tally, extents):
            yield replace(finding, bound=finding.bound * unit)

    def score_sizes(self, score: str) -> Scores:
        """Return the scores by size; counted as if of one size if their sizes are not known."""
        number, lamps = self.tally.number_of(score), self.tally.cell_sums.lamps
        is_whole = len(lamps) == len(self.plan.adjoint.sources)
        found = single_cell_scores(self.tally, number) if is_whole else None
        return equal_scores(number) if found is None else found

    def grazing(self) -> Iterable[Finding]:
        """Return no findings: fluence rates are not estimated."""
        return ()


class ViewDiagnosis(_CellDiagnosis):
    """What a backward run may have missed of a camera, a map or a point, with bounds as mean radiances."""

    tally: ViewReading

    def _path_findings(self, score: str) -> Iterator[Finding]:
        if not (self.tally.is_blind and self.note):
            yield from (replace(finding, adds=True) for finding in cell_path_findings(self.tally))

    def missing(self, score: str, is_whole: bool = True) -> list[Finding]:
        """Findings about a score, of single pixels or bins with those that concern each by itself."""
        found, sums = super().missing(score, is_whole), self.tally.cell_sums
        if is_whole or not sums.is_view or (self.tally.is_blind and self.note):
            return found
        # Where histories from lamps bring light to the walls, what flights may have missed is known by pixel.
        kept = found if sums.view is None else [each for each in found if each.name != "path class"]
        return [*kept, *self._of_pixels]

    @cached_property
    def _of_pixels(self) -> list[Finding]:
        """Findings about light that may fill a single pixel."""
        return [*with_cure(pixel_path_findings(self.tally), self.more)]

    def _error_findings(self, score: str) -> Iterable[Finding]:
        return ()

    def totals(self) -> Iterator[tuple[str, Estimate]]:
        """Yield the mean over all cells."""
        tally, sums = self.tally, self.tally.cell_sums
        means, counts = sums.means[0], int(batch_totals(sums.counts[0]).sum())
        mean = batch_totals(means) / means.shape[1] if isinstance(means, ChunkedArray) else means.mean(axis=1)
        name = "fluence_rate" if isinstance(tally.detector, PointDetector) else "radiance"
        total = Estimate(mean, tally.run, Unit(), counts=counts)
        yield name, self.judged(total, lambda: self.missing("radiance"))


# The diagnosis of each kind of tally.
DIAGNOSES: dict[type[Tally], type[Diagnosis]] = {
    Reading: DetectorDiagnosis,
    VolumeReading: VolumeDiagnosis,
    PointReading: PointDiagnosis,
    PhaseReading: Diagnosis,
    BackwardReading: BackwardDiagnosis,
    ViewReading: ViewDiagnosis,
}
