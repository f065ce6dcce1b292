"""What a run found out: detectors, the ledger, the cost; every number an Estimate."""

import math
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.plan import Plan
from transport.detectors import Detector
from transport.phase_space import PhaseSpace, Snapshot
from transport.points import PointDetector
from transport.renderers import function_for
from transport.results.backward_readings import backward_reading
from transport.results.estimates import Estimate
from transport.results.findings import Finding
from transport.results.phase_readings import PhaseReading, SnapshotReading
from transport.results.point_readings import PointReading
from transport.results.prices import price_of
from transport.results.quality import Quality
from transport.results.readings import QUANTITIES, Reading
from transport.results.record import BY_CHANCE, Cost, Record
from transport.results.report import ledger_lines, report_of, share_of
from transport.results.statistics import rounding_of
from transport.results.trust import findings_of, in_words, quality_in
from transport.results.volume_readings import VolumeReading
from transport.units import Unit
from transport.validation import SceneError, suggestion
from transport.volumes import VolumeDetector

if TYPE_CHECKING:
    from os import PathLike

    from transport.results.any_reading import AnyReading
    from transport.results.estimates import EstimateOrArray

__all__ = ["QUANTITIES", "Cost", "Ledger", "Result"]


class Result(Record):
    """A finished run: `result["meter"]` is a detector's reading, `ledger` where all that was emitted went."""

    def __getitem__(self, name: str) -> "AnyReading":
        names = [detector.name for detector in self.scene.detectors]
        if name not in names:
            raise SceneError(f"result has no detector {name!r}; {suggestion(str(name), names)}")
        if name not in self._readings:
            self._readings[name] = self._read(self.scene.detectors[names.index(name)])
        return self._readings[name]

    def _read(self, detector: Detector | PhaseSpace | Snapshot) -> Reading | PhaseReading | SnapshotReading:
        if self.plan.turned is not None:
            return backward_reading(self, detector)
        if isinstance(detector, PhaseSpace):
            return PhaseReading(self, detector)
        if isinstance(detector, Snapshot):
            return SnapshotReading(self, detector, self.scene.snapshots.index(detector))
        if isinstance(detector, VolumeDetector):
            return VolumeReading(self, detector)
        if isinstance(detector, PointDetector):
            return PointReading(self, detector)
        return Reading(self, detector)

    if not TYPE_CHECKING:  # to type checkers it would give every name a meaning

        def __getattr__(self, name: str):
            """Say how a detector is read."""
            if hasattr(type(self), name):  # a property that failed: its own words
                return object.__getattribute__(self, name)
            is_detector = "scene" in vars(self) and name in self
            cure = f"; a detector is read as result[{name!r}]" if is_detector else ""
            raise AttributeError(f"Result has no attribute {name!r}{cure}")

    def __contains__(self, name: object) -> bool:
        return name in [detector.name for detector in self.scene.detectors]

    def __iter__(self) -> Iterator[str]:
        """The names of the detectors."""
        return iter([detector.name for detector in self.scene.detectors])

    def quantity(self, name: str) -> "EstimateOrArray":
        """The Estimate or EstimateArray called "detector.quantity"."""
        detector, _, quantity = name.partition(".")
        known = self[detector].known
        if quantity not in known:
            raise SceneError(f"result has no quantity {quantity!r}; {suggestion(quantity, known)}")
        return getattr(self[detector], quantity)

    def quality(self, name: "str | EstimateOrArray") -> Quality:
        """How far the error bar of the quantity called "detector.quantity" is to be trusted, with bins or without, or of an Estimate."""
        return quality_in(self, name)

    @property
    def ledger(self) -> "Ledger":
        """Where all that was emitted went; of a run backwards where its histories went, as shares of them.

        Raises SceneError where pilots chose to run backwards: who did not name that estimator takes its shares for watts.
        """
        if self.plan.turned is not None and self.choice is not None and len(self.choice.pilots) > 1:
            raise SceneError(
                "result.ledger: histories of this run began at the detectors, as pilots chose, so where the sources' power went is"
                " not known; write estimator='analog' for that, or estimator='backward' for shares of these histories"
            )
        return self._own_ledger

    @cached_property
    def _own_ledger(self) -> "Ledger":
        """The ledger of its histories, wherever these began."""
        return Ledger(self)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """What the run may have missed of each detector's totals, the worst first, and what else to know."""
        return findings_of(self)

    @property
    def warnings(self) -> list[str]:
        """What a reader should know before trusting the numbers."""
        return [*self._warnings, *in_words(self.findings, self.particles)]

    def price(self, name: str, error: float) -> float:
        """Seconds that a run takes, in all, to this relative error of "detector.quantity" [s].

        Going by what this run cost; of an array to that error in its worst bin that is not doubtful; nan where no error is
        known, or all are doubtful.
        """
        if self.cost is None or not 0 < error < math.inf:
            raise SceneError(f"result.price: error must be relative, positive and finite, got {error!r}")
        return price_of(self.quantity(name), self.cost, error, self.cost.slopes.get(name, BY_CHANCE))

    def save(self, path: "str | PathLike") -> None:
        """Write all of it into a file, whole or not at all: .nc, NetCDF-4 (extra `files`), or .npz; `tp.load` reads it.

        Raises SceneError for a scene that no file can hold, FileError for a file that cannot be written.
        """
        function_for(type(self), "save")(self, path)

    def report(self) -> str:
        """The ledger, each detector, the cost and what the next digit costs, as text."""
        return report_of(self)

    def __repr__(self) -> str:
        state = share_of(self) + ("" if self.is_complete else ", incomplete")
        return f"<Result of {self.particles} particles in {len(self.run)} batches{state}>"

    def _repr_html_(self) -> str:
        return function_for(type(self), "html")(self)


def media_names(plan: Plan) -> dict[int, str]:
    """What to call the media that absorb, by their rows: after the surface whose inside they fill."""
    names = {}
    for row in plan.absorbing_media:
        if row == 0:
            names[row] = "medium"
            continue
        number = plan.bodies[row - 1].surfaces[0]
        name = plan.scene.surfaces[number].name
        names[row] = f"inside {name or f'surfaces[{number}]'}"
    return names


def _may_kill(plan: Plan) -> bool:
    """Whether histories may be killed, or split, by chance; forced copies only share a weight."""
    return plan.has_roulette or plan.has_roulette_in_flight or plan.splits


class Ledger(Mapping[str, Estimate]):
    """Where all that was emitted went: `emitted` = the sum of all the others, exactly.

    In watts or particles per second; with a clock in joules, or particles; of a run backwards shares of its histories.  `roulette` is what was killed less what was gained, of expectation
    zero; `unsampled` what an `aim` left out.  `absorbed_by` has the share of each surface and of each medium that absorbs.
    """

    def __init__(self, result: Result) -> None:
        plan, batches, run = result.plan, result.batches, result.run
        scene = plan.scene
        is_gas = scene.measured_in == "particles"
        unit = Unit.parse("s^-1" if is_gas else "W") * Unit.parse("s") ** plan.has_clock
        unit = unit if plan.turned is None else Unit()
        scale = plan.unit

        def entry(values: list[float], exact: bool = False) -> Estimate:
            return Estimate(np.array(values) * scale / run.sizes, run, unit, exact=exact)

        emitted = math.fsum(emitter.amount for emitter in plan.emitters)
        share = emitted / plan.unit
        self.absorbed_by: dict[str, Estimate] = {}
        for index, surface in enumerate(scene.surfaces):
            rows = [row for row, owner in enumerate(plan.owners) if owner == index]
            if rows:
                name = surface.name or f"surfaces[{index}]"
                self.absorbed_by[name] = entry([b.absorbed[rows].sum() for b in batches], not plan.absorbs)
        for row, name in media_names(plan).items():
            column = len(plan.owners) + row
            self.absorbed_by[name] = entry([b.absorbed[column] for b in batches])
        aimed = any(emitter.target is not None for emitter in plan.emitters)
        is_sure = not (plan.acts or aimed or plan.has_media)
        roulette = [b.ledger["roulette"] for b in batches]
        if all(abs(gain) <= rounding_of(b.born) for gain, b in zip(roulette, batches, strict=True)):
            roulette = [0.0] * len(batches)  # a weight shared by forced copies, to rounding
        self._entries = {
            "emitted": Estimate(np.full(len(run), emitted), run, unit, exact=True),
            "absorbed": entry(
                [b.absorbed.sum() for b in batches], not (plan.absorbs or plan.absorbing_media)
            ),
            "escaped": entry([b.ledger["escaped"] for b in batches], plan.has_clock or is_sure),
            "in_flight": entry([b.ledger["in_flight"] for b in batches], not plan.has_clock or is_sure),
            "roulette": entry(roulette, not any(roulette) and not _may_kill(plan)),
            "unsampled": entry(
                [b.histories * share - b.born for b in batches] if aimed else [0.0] * len(batches), not aimed
            ),
            "lost": entry([b.ledger["lost"] for b in batches], not any(b.lost for b in batches)),
        }

    def __getitem__(self, name: str) -> Estimate:
        if name not in self._entries:
            raise SceneError(f"ledger has no entry {name!r}; {suggestion(str(name), self._entries)}")
        return self._entries[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __str__(self) -> str:
        return "\n".join(ledger_lines(self))

    __repr__ = __str__

    def _repr_html_(self) -> str:
        return function_for(type(self), "html")(self)

    def __len__(self) -> int:
        return len(self._entries)
