"""The result of a run: readings of the detectors, the energy balance (ledger), the cost.

All numbers are Estimates.
"""

import math
from collections.abc import Collection, Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.plan import Plan
from transport.renderers import function_for
from transport.results.backward import ViewReading, backward_reading
from transport.results.detectors import Reading
from transport.results.diagnostics.diagnoses import DIAGNOSES, Diagnosis
from transport.results.diagnostics.run_findings import findings_of, quality_of_result, warnings_of
from transport.results.phase_space import PhaseReading, SnapshotReading
from transport.results.points import PointReading
from transport.results.record import RANDOM_SLOPE, Cost, Record
from transport.results.report import ledger_lines, part_text, price_of, report_of
from transport.results.tally import Tally
from transport.results.volumes import VolumeReading
from transport.scene.bodies import surrounding_medium
from transport.scene.cameras import Camera, EnvironmentMap, LightField
from transport.scene.detectors import Detector
from transport.scene.phase_space import PhaseSpace, Snapshot
from transport.scene.points import PointDetector
from transport.scene.sides import AnyDetector
from transport.scene.volumes import VolumeDetector
from transport.statistics.batches import rounding_error
from transport.statistics.estimates import Estimate
from transport.statistics.findings import Finding, note
from transport.statistics.quality import Quality
from transport.units import Unit
from transport.validation import NamedEntries, SceneError, name_hint, optional_packages

if TYPE_CHECKING:
    from os import PathLike

    from matplotlib.axes import Axes

    from transport.results.any_reading import AnyReading
    from transport.statistics.estimates import EstimateOrArray

# The tally of each kind of detector, in forward runs.
TALLIES: dict[type, type[Tally]] = {
    Detector: Reading,
    VolumeDetector: VolumeReading,
    PointDetector: PointReading,
    PhaseSpace: PhaseReading,
    Camera: ViewReading,
    EnvironmentMap: ViewReading,
    LightField: ViewReading,
}
__all__ = ["Cost", "Ledger", "Result"]


class Result(Record):
    """The result of a run; `result["name"]` is the reading of the detector of that name.

    `simulate`, `load` and `merge` make it.

    Attributes
    ----------
    scene : Scene
        The simulated scene.
    seed : int
        Seed of the random numbers.
    cost : Cost or None
        Cost of the run; None for a result that no run made.
    is_complete : bool
        False if the run was interrupted.
    run : Batches
        The batches and their numbers of histories.

    Raises
    ------
    SceneError
        For a detector name that the scene does not have.

    Examples
    --------
    >>> import transport as tp
    >>> disk = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0)
    >>> scene = tp.Scene(
    ...     sources=[tp.Source(tp.Point(), tp.Isotropic(power=1.0))],
    ...     surfaces=[tp.Surface(disk, tp.Black(), "disk")],
    ...     detectors=[tp.Detector("disk")],
    ... )
    >>> result = tp.simulate(scene, particles=10_000, seed=1, progress=False)
    >>> result
    <Result of 10000 particles in 32 batches>
    >>> list(result)
    ['disk']
    >>> print(result["disk"].flux_in)
    (0.151 ± 0.003) W
    >>> print(result.ledger)
    emitted    1 W (exact)
    absorbed   (0.151 ± 0.003) W
    escaped    (0.849 ± 0.003) W
    lost       0 W (exact)
    >>> result.quality("disk.flux_in").verdict
    'sound'
    """

    def __getitem__(self, name: str) -> "AnyReading":
        names = list(self)
        if name not in names:
            raise SceneError(f"result has no detector {name!r}; {name_hint(str(name), names)}")
        if name not in self._readings:
            self._readings[name] = self._read(self.scene.detectors[names.index(name)])
        return self._readings[name]

    def _read(self, detector: AnyDetector) -> Tally:
        if self.plan.adjoint is not None:
            return backward_reading(self, detector)
        if isinstance(detector, Snapshot):
            return SnapshotReading(self, detector, self.scene.snapshots.index(detector))
        return TALLIES[type(detector)](self, detector)

    def diagnosis_of(self, tally: Tally) -> Diagnosis:
        """Return what the run may have missed of a tally, for the scores of which it is."""
        return DIAGNOSES[type(tally)](self, tally)

    if not TYPE_CHECKING:  # type checkers would accept any name

        def __getattr__(self, name: str):
            """Raise an AttributeError that explains how to read a detector."""
            if hasattr(type(self), name):  # a property failed: raise its own error
                return object.__getattribute__(self, name)
            is_detector = "scene" in vars(self) and name in self
            cure = f"; a detector is read as result[{name!r}]" if is_detector else ""
            raise AttributeError(f"Result has no attribute {name!r}{cure}")

    def __contains__(self, name: object) -> bool:
        return name in list(self)

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the detectors."""
        return iter([detector.name for detector in self.scene.detectors])

    def quantity(self, name: str) -> "EstimateOrArray":
        """Return the quantity named "detector.quantity".

        Parameters
        ----------
        name : str
            Name of the detector, a point, and name of the quantity, such as "disk.flux_in".

        Returns
        -------
        Estimate or EstimateArray

        Raises
        ------
        SceneError
            If there is no such detector or quantity.
        """
        detector, _, quantity = name.partition(".")
        known = self[detector].known
        if quantity not in known:
            raise SceneError(f"result has no quantity {quantity!r}; {name_hint(quantity, known)}")
        return getattr(self[detector], quantity)

    def quality(self, name: "str | EstimateOrArray") -> Quality:
        """Return the quality of the error bar of a quantity.

        Parameters
        ----------
        name : str, Estimate or EstimateArray
            "detector.quantity", or an estimate of this run.

        Returns
        -------
        Quality
            Its verdict, its findings, and the tests of its scores and batches.
        """
        return quality_of_result(self, name)

    @property
    def ledger(self) -> "Ledger":
        """The energy balance, where all emitted power went (of a backward run, where its histories went).

        Returns
        -------
        Ledger
            [W, s^-1, J or 1]; for a backward run fractions of the histories.

        Raises
        ------
        SceneError
            If pilots chose a backward run: the user did not request it and could take the fractions for
            watts.
        """
        if self.plan.adjoint is not None and self.choice is not None and len(self.choice.pilots) > 1:
            raise SceneError(
                "result.ledger: the pilots chose backward histories, which start at the detectors, so the"
                " energy balance of the sources is unknown; pass estimator='analog' for it, or"
                " estimator='backward' for fractions of these histories"
            )
        return self._own_ledger

    @cached_property
    def _own_ledger(self) -> "Ledger":
        """The energy balance of its own histories, forward or backward."""
        return Ledger(self)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings of the run, then on the totals of each detector (what may be missing, and notes).

        Returns
        -------
        tuple of Finding
        """
        return *(note("run", what) for what in self._warnings), *self._diagnosed

    @cached_property
    def _diagnosed(self) -> tuple[Finding, ...]:
        return findings_of(self)

    def _read_scores(self) -> dict[str, frozenset[str]]:
        """The scores of which numbers were read so far, by detector."""
        return {name: scores for name, tally in self._readings.items() if (scores := tally.read_scores)}

    def _findings_about(self, read: Mapping[str, Collection[str]]) -> tuple[Finding, ...]:
        """The findings about numbers made of these scores (`_read_scores`), and of detectors without any."""
        return *(note("run", what) for what in self._warnings), *findings_of(self, read)

    @property
    def warnings(self) -> list[str]:
        """Warnings to read before the numbers are used.

        Returns
        -------
        list of str
            Each says what may be wrong, by how much, and what to do.
        """
        return warnings_of(self.findings)

    def price(self, name: str, error: float) -> float:
        """Predict the time that a whole run takes to reach a relative error of a quantity.

        Parameters
        ----------
        name : str
            "detector.quantity".
        error : float
            Relative standard error to reach, positive; for an array in its worst bin that is not doubtful.

        Returns
        -------
        float
            Wall-clock time [s] of the whole run, predicted from the cost of this one on the same machine; nan
            if no error is known or all are doubtful.

        Raises
        ------
        SceneError
            If `error` is not positive and finite, or if the result has no cost.
        """
        if self.cost is None or not 0 < error < math.inf:
            raise SceneError(f"result.price: error must be relative, positive and finite, got {error!r}")
        return price_of(self.quantity(name), self.cost, error, self.cost.slopes.get(name, RANDOM_SLOPE))

    def plot(self, *, path: "str | PathLike | None" = None) -> "list[Axes]":
        """Draw an overview: each detector's bins, and where the power went (needs matplotlib).

        Parameters
        ----------
        path : path, optional
            File to write the picture to, such as "run.png" [default: none].

        Returns
        -------
        list of matplotlib.axes.Axes
            A panel for each of up to eight detectors that have bins along one or two axes, then one of the
            energy balance with two standard errors.

        Notes
        -----
        ``result["name"].plot()`` draws one detector with its errors, ``result.scene.plot()`` the scene.
        """
        with optional_packages("plot"):
            return function_for(type(self), "plot")(self, path)

    def save(self, path: "str | PathLike") -> None:
        """Write the result to a file; `tp.load` reads it.

        Parameters
        ----------
        path : str or PathLike
            File name ending in .nc (NetCDF-4; needs the extra `files`) or .npz.  The file is written
            completely or not at all.

        Raises
        ------
        SceneError
            If the scene cannot be stored in a file.
        FileError
            If the file cannot be written.
        """
        function_for(type(self), "save")(self, path)

    def report(self) -> str:
        """Return the result as text: energy balance, detectors, cost, warnings.

        Returns
        -------
        str
        """
        return report_of(self)

    def __repr__(self) -> str:
        state = part_text(self) + ("" if self.is_complete else ", incomplete")
        return f"<Result of {self.particles} particles in {len(self.run)} batches{state}>"

    def _repr_html_(self) -> str:
        return function_for(type(self), "html")(self)


def media_names(plan: Plan) -> dict[int, str]:
    """Names of the absorbing media by row: their own, or that of the surface whose inside they fill."""
    names: dict[int, str] = {}
    walls = [surface.name or f"surfaces[{k}]" for k, surface in enumerate(plan.scene.surfaces)]
    taken = {"medium", *walls, *(f"inside {wall}" for wall in walls)}
    for row in plan.absorbing_media:
        medium = surrounding_medium(plan.scene) if row == 0 else plan.bodies[row - 1].medium
        if (own := getattr(medium, "name", None)) is not None:
            names[row] = f"medium {own}" if own in taken else own
            continue
        if row == 0:
            names[row] = "medium"
            continue
        names[row] = f"inside {walls[plan.bodies[row - 1].surfaces[0]]}"
    return names


class Ledger(Mapping[str, Estimate]):
    """The energy balance of a run: `emitted` equals the sum of all other entries exactly.

    A mapping from the entries' names to Estimates.

    Parameters
    ----------
    result : Result
        The run.

    Attributes
    ----------
    absorbed_by : dict of str to Estimate
        Absorbed power of each surface and of each absorbing medium, by name.

    Notes
    -----
    The unit is W, or s^-1 for sources of particles; with a clock J, or 1; for a backward run fractions of its
    histories.

    emitted : all births.
    absorbed, escaped : ends at surfaces and in media, and ends outside the scene.
    in_flight : particles alive at the end of the clock.
    roulette : killed minus gained weight of Russian roulette; its expectation is 0.
    unsampled : directions that an `aim` leaves out.
    lost : particles lost by errors of the geometry.
    """

    def __init__(self, result: Result) -> None:
        plan, batches, run = result.plan, result.batches, result.run
        scene = plan.scene
        unit, scale = Unit(), plan.unit
        if plan.adjoint is None:
            rate = "s^-1" if scene.measured_in == "particles" else "W"
            unit = Unit.parse(rate) * Unit.parse("s") ** plan.has_clock

        def entry(values: list[float], exact: bool = False) -> Estimate:
            return Estimate(np.array(values) * scale / run.sizes, run, unit, exact=exact)

        emitted = math.fsum(emitter.amount for emitter in plan.emitters)
        share = emitted / plan.unit
        # Collect the absorbed weight of each surface and of each absorbing medium.
        self.absorbed_by: dict[str, Estimate] = NamedEntries("ledger.absorbed_by has no entry")
        for index, rows in sorted(plan.rows_of_surfaces.items()):
            surface = scene.surfaces[index]
            absorbed = [b.absorbed[rows].sum() for b in batches]
            is_never = not surface.material.absorbs and not any(absorbed)
            self.absorbed_by[surface.name or f"surfaces[{index}]"] = entry(absorbed, is_never)
        names = media_names(plan)
        for name in dict.fromkeys(names.values()):  # bodies of one named medium count together
            columns = [len(plan.surface_numbers) + row for row, other in names.items() if other == name]
            self.absorbed_by[name] = entry([b.absorbed[columns].sum() for b in batches])
        # Collect the entries; one is exact if nothing in the scene can change it.
        aimed = any(emitter.weighs_births for emitter in plan.emitters)
        is_sure = not (plan.has_acting_surfaces or aimed or plan.has_media)
        # Histories may be killed or split by chance; forced copies only share a weight.
        has_kills = plan.has_roulette or plan.has_roulette_in_flight or plan.splits
        roulette = [b.ledger["roulette"] for b in batches]
        if all(abs(gain) <= rounding_error(b.born) for gain, b in zip(roulette, batches, strict=True)):
            roulette = [0.0] * len(batches)  # only rounding of a weight shared by forced copies
        self._entries = {
            "emitted": Estimate(np.full(len(run), emitted), run, unit, exact=True),
            "absorbed": entry(
                [b.absorbed.sum() for b in batches], not (plan.absorbs or plan.absorbing_media)
            ),
            "escaped": entry([b.ledger["escaped"] for b in batches], plan.has_clock or is_sure),
            "in_flight": entry([b.ledger["in_flight"] for b in batches], not plan.has_clock or is_sure),
            "roulette": entry(roulette, not any(roulette) and not has_kills),
            "unsampled": entry(
                [b.histories * share - b.born for b in batches] if aimed else [0.0] * len(batches), not aimed
            ),
            "lost": entry([b.ledger["lost"] for b in batches], not any(b.lost for b in batches)),
        }

    def __getitem__(self, name: str) -> Estimate:
        if name not in self._entries:
            raise SceneError(f"ledger has no entry {name!r}; {name_hint(str(name), self._entries)}")
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
