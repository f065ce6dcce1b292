"""The readings of a Detector: scores turned into radiometric quantities, each with its standard error.

A quantity with `_in` in its name counts arrivals at the detector's side, one with `_out` departures from it.
Quantities of the whole shape include scores outside the detector's bins of direction and position.  With
`times` every quantity has an axis of time, and rates are means over its bins; with `speeds` it has an axis of
speed, and each bin has the part of those speeds; then follow the axes of position (u, v) and, for quantities
by direction, (mu or theta, phi).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np

from transport.geometry.mesh import Mesh
from transport.results.choice import more_particles_cure
from transport.results.diagnostics.depth import detector_survivor_findings, optical_depth_message
from transport.results.diagnostics.empty_detector import (
    cannot_arrive,
    is_on_surface,
    no_light_departs,
    no_light_message,
)
from transport.results.diagnostics.path_classes import detector_path_findings
from transport.results.diagnostics.rays import (
    detector_forward_peaks,
    detector_unvisited_findings,
    grazing_findings,
)
from transport.results.reading import Note, ReadingBase, empty_note
from transport.results.score_sizes import detector_scores
from transport.results.solid_angles import solid_angles_of
from transport.results.tally import ARRIVALS, DEPARTURES, DetectorSums
from transport.scene.detectors import Detector
from transport.scene.scene_speeds import has_several_speeds, missing_mass_message, scene_mass, scene_speeds
from transport.statistics.batches import MIN_SCORES_FOR_ERROR
from transport.statistics.estimates import Estimate, EstimateOrArray
from transport.statistics.findings import Finding
from transport.statistics.quality import Scores, findings_of_error, with_cure
from transport.units import Unit
from transport.validation import SceneError, refuse

QUANTITIES = (
    "flux_in", "flux_out", "irradiance", "exitance", "net_flux_density",
    "flux_density", "radiance", "radiance_out", "intensity", "intensity_out",
    "fluence_rate", "counts", "energy_in", "energy_out", "fluence", "phase_density",
    "pressure", "mean_speed_in", "mean_speed_out", "mean_square_speed_in", "mean_square_speed_out",
    "mean_energy_in", "mean_energy_out",
)  # fmt: skip

BY_DIRECTION = ("flux_density", "radiance", "radiance_out", "intensity", "intensity_out", "phase_density")
TIME_INTEGRATED = ("energy_in", "energy_out", "fluence")
# Score of a crossing in a fluence rate, relative to its weight: the mean of 1/|mu| for constant radiance.
MEAN_INVERSE_COSINE = 2.0
MOMENT_QUANTITIES = QUANTITIES[QUANTITIES.index("pressure") :]


class Reading(ReadingBase):
    """The quantities of one Detector, from `result["name"]`.

    Parameters
    ----------
    result : Result
        The run.
    detector : Detector
        The detector of the scene.

    Raises
    ------
    SceneError
        When a quantity is read for which the detector has not the options, such as `radiance` without
        `directions`.

    Notes
    -----
    Each quantity is an Estimate, or an EstimateArray over the detector's bins.  Sources with a power in watts
    give radiometric units; sources of particles give the same units with s^-1 in place of W, and 1 in place
    of J.

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
    >>> print(result["disk"].flux_in)
    (0.151 ± 0.003) W
    >>> print(result["disk"].irradiance)
    (0.0479 ± 0.0011) W m^-2
    """

    known, title = QUANTITIES, "detector "

    def __init__(self, result, detector: Detector) -> None:
        plan = result.plan
        self.detector, self.name = detector, detector.name
        self._scene, self._plan = plan.scene, plan
        self.sums = DetectorSums(plan, result.batches, result.run, detector)
        self._is_light = plan.scene.measured_in == "watts"
        self._rate = Unit.parse("W" if self._is_light else "s^-1")
        self._is_exact_out = _departs_exactly_once(plan, detector)
        self._allowed, self._more = result.allowed_of(detector.name), more_particles_cure(result.choice)
        self._found: dict[int, tuple[list[Finding], list[Finding]]] = {}
        self._dark: dict[int, bool] = {}

    @cached_property
    def area(self) -> float:
        """Area of the shape [m^2].

        Returns
        -------
        float

        Raises
        ------
        SceneError
            If the shape is infinite.
        """
        shape = self.sums.shape
        if shape.is_infinite:
            kind, cure = (
                type(shape).__name__,
                "read flux_in, flux_out or intensity, or use a Disk in its plane as the detector's shape",
            )
            refuse(self.sums.detector, f"quantities per area need a finite area, got a {kind}; {cure}")
        return shape.area

    @property
    def is_blind(self) -> bool:
        """Whether the detector has no score.

        Returns
        -------
        bool
        """
        return not any(self.sums.whole("counts", side).any() for side in (ARRIVALS, DEPARTURES))

    def is_sure(self, side: int) -> bool:
        """Return whether arrivals (side 0) or departures (1) are equal for all histories or surely absent."""
        return (self._is_exact_out and side == DEPARTURES) or self.is_dark(side)

    @cached_property
    def note(self) -> Note | None:
        """The reason why the detector has no score: (name of the diagnostic, text).

        Returns
        -------
        tuple of str or None
            None if it has scores or no reason is known.
        """
        sums, title = self.sums, self._title
        if any(sums.whole("weights", side).any() for side in (ARRIVALS, DEPARTURES)):
            return None
        deep = optical_depth_message(self._plan, title, sums.shape, int(sums.run.sizes.sum()))
        return empty_note(self._dark_reason, deep)

    @cached_property
    def cannot_arrive(self) -> bool:
        """Whether geometry proves that no light arrives at this side, while some may depart.

        Returns
        -------
        bool
        """
        if self.sums.whole("counts", ARRIVALS).any() or (self.is_blind and self._dark_reason):
            return False
        return cannot_arrive(self._scene, self.sums.shape, self.detector, self.is_blind)

    @cached_property
    def may_arrive(self) -> bool:
        """Whether light may arrive and arrivals are what a user reads.

        On a surface or on a source a user may read departures alone.
        """
        is_on = is_on_surface(self._scene, self.sums.shape, self.detector)
        return not is_on and not self.is_dark(ARRIVALS)

    @cached_property
    def _dark_reason(self) -> str | None:
        return no_light_message(self._scene, f"detector {self.name!r}", self.sums.shape, self.detector)

    @cached_property
    def flux_in(self) -> EstimateOrArray:
        """Power [W], or particles per second, arriving at the whole shape: flux Φ.

        Returns
        -------
        Estimate or EstimateArray
            [W or s^-1]
        """
        return self._whole(ARRIVALS)

    @cached_property
    def flux_out(self) -> EstimateOrArray:
        """Power [W], or particles per second, leaving the whole shape.

        Returns
        -------
        Estimate or EstimateArray
            [W or s^-1]
        """
        return self._whole(DEPARTURES)

    @cached_property
    def irradiance(self) -> EstimateOrArray:
        """Flux arriving per area, E [W m^-2 or s^-1 m^-2]; by position if the detector has `positions`.

        Returns
        -------
        Estimate or EstimateArray
            [W m^-2 or s^-1 m^-2]
        """
        return self._per_area("weights", ARRIVALS)

    @cached_property
    def exitance(self) -> EstimateOrArray:
        """Flux leaving per area, M [W m^-2 or s^-1 m^-2]; of a wall its radiosity (emitted plus reflected).

        Returns
        -------
        Estimate or EstimateArray
            [W m^-2 or s^-1 m^-2]
        """
        return self._per_area("weights", DEPARTURES)

    @cached_property
    def net_flux_density(self) -> EstimateOrArray:
        """Exitance minus irradiance, J [W m^-2 or s^-1 m^-2]: positive along the normal of its side.

        Returns
        -------
        Estimate or EstimateArray
            [W m^-2 or s^-1 m^-2]
        """
        return self.exitance - self.irradiance

    @cached_property
    def radiance(self) -> EstimateOrArray:
        """Arriving radiance by direction bin, L [W m^-2 sr^-1 or s^-1 m^-2 sr^-1].

        Returns
        -------
        EstimateArray
            [W m^-2 sr^-1 or s^-1 m^-2 sr^-1]

        Raises
        ------
        SceneError
            If the detector has no `directions`.

        Notes
        -----
        Flux divided by the area and by the bin's exact projected solid angle ∫cosθ dω, never by cosθ of
        single particles.
        """
        return self._by_direction(ARRIVALS, projected=True)

    @cached_property
    def radiance_out(self) -> EstimateOrArray:
        """Leaving radiance by direction bin [W m^-2 sr^-1 or s^-1 m^-2 sr^-1].

        Returns
        -------
        EstimateArray
            [W m^-2 sr^-1 or s^-1 m^-2 sr^-1]
        """
        return self._by_direction(DEPARTURES, projected=True)

    @cached_property
    def flux_density(self) -> EstimateOrArray:
        """Arriving flux per area and solid angle by direction bin: ``n v |cosθ| = L |cosθ|`` [W m^-2 sr^-1].

        Returns
        -------
        EstimateArray
            [W m^-2 sr^-1 or s^-1 m^-2 sr^-1]
        """
        return self._by_direction(ARRIVALS, projected=False)

    @cached_property
    def intensity(self) -> EstimateOrArray:
        """Arriving flux per solid angle through the shape, I = ``∫ L |cosθ| dA`` [W sr^-1 or s^-1 sr^-1].

        Returns
        -------
        EstimateArray
            [W sr^-1 or s^-1 sr^-1]
        """
        return self._by_direction(ARRIVALS, projected=False, per_area=False)

    @cached_property
    def intensity_out(self) -> EstimateOrArray:
        """Leaving flux per solid angle of the whole shape [W sr^-1 or s^-1 sr^-1]: a source's intensity.

        Returns
        -------
        EstimateArray
            [W sr^-1 or s^-1 sr^-1]
        """
        return self._by_direction(DEPARTURES, projected=False, per_area=False)

    @cached_property
    def fluence_rate(self) -> EstimateOrArray:
        """Radiance over all directions, φ = ∫ L dω [W m^-2 or s^-1 m^-2], of arrivals and departures.

        Returns
        -------
        Estimate or EstimateArray
            [W m^-2 or s^-1 m^-2]

        Notes
        -----
        Each crossing scores weight/``|μ|``.  Below the grazing cut ``|μ|`` = 1e-3 it scores its expectation
        for constant radiance, 2/cut, so that the variance stays finite (MacMillan, Doster 1971).  This is
        wrong for a beam closer to grazing than the cut, and the number is doubtful if such light matters.
        """
        return self._per_area("slants", ARRIVALS) + self._per_area("slants", DEPARTURES)

    @cached_property
    def counts(self) -> EstimateOrArray:
        """Number of scored arrivals in the whole run, by bin.

        Returns
        -------
        Estimate or EstimateArray
            [1]
        """
        sums, inner = self.sums, self.sums.position_axes | self.sums.direction_axes
        values = sums.by_direction("counts", ARRIVALS) if inner else sums.whole("counts", ARRIVALS)
        return sums.estimate(values * float(sums.run.sizes.sum()), Unit.parse("1"), inner, values)

    @cached_property
    def energy_in(self) -> EstimateOrArray:
        """Energy [J], or particles, arriving within the duration, or within each bin of time.

        Returns
        -------
        Estimate or EstimateArray
            [J or 1]

        Raises
        ------
        SceneError
            If the scene has no `duration`.
        """
        self._need_clock("energy_in")
        return self._whole(ARRIVALS, per_second=False)

    @cached_property
    def energy_out(self) -> EstimateOrArray:
        """Energy [J], or particles, leaving within the duration, or within each bin of time.

        Returns
        -------
        Estimate or EstimateArray
            [J or 1]

        Raises
        ------
        SceneError
            If the scene has no `duration`.
        """
        self._need_clock("energy_out")
        return self._whole(DEPARTURES, per_second=False)

    @cached_property
    def fluence(self) -> EstimateOrArray:
        """Fluence rate integrated over the duration, or over each bin of time, H [J m^-2 or m^-2].

        Returns
        -------
        Estimate or EstimateArray
            [J m^-2 or m^-2]

        Raises
        ------
        SceneError
            If the scene has no `duration`.
        """
        self._need_clock("fluence")
        return self._per_area("slants", ARRIVALS, False) + self._per_area("slants", DEPARTURES, False)

    @cached_property
    def phase_density(self) -> EstimateOrArray:
        """Density in phase space by direction bin, n(x, v).

        Returns
        -------
        EstimateArray
            [m^-6 s^3] for particles with bins of speed: flux over area, ∫cosθ dω and ∫v³ dv, exact for each
            bin.  [m^-3 sr^-1] without bins of speed, if all particles have one speed: radiance over speed, a
            density in space and direction.  Light has J in place of 1.

        Raises
        ------
        SceneError
            If speeds differ and the detector has no `speeds`.
        """
        edges = self.detector.speed_edges()
        if edges is not None:
            volumes = np.diff(edges**4) / 4.0
            return self._by_direction(ARRIVALS, projected=True, volumes=volumes, per="m^4 s^-4 sr^-1")
        speeds = scene_speeds(self._scene)
        if has_several_speeds(speeds):
            self._refuse("phase_density", "bins of speed where speeds differ", "write speeds=edges in m/s")
        return self._by_direction(ARRIVALS, projected=True, volumes=np.array([speeds.pop()]), per="m s^-1")

    @cached_property
    def pressure(self) -> EstimateOrArray:
        """Momentum along the normal that arrives and leaves, per area and time [Pa]; the pressure on a wall.

        Returns
        -------
        Estimate or EstimateArray
            [Pa]

        Raises
        ------
        SceneError
            Without `moments=True`, or for particles of unknown mass.

        Notes
        -----
        The momentum is energy over speed for sources in watts, and mass times speed for particles.
        """
        return self._momentum(ARRIVALS) + self._momentum(DEPARTURES)

    @cached_property
    def mean_speed_in(self) -> EstimateOrArray:
        """Mean speed of arrivals [m s^-1], each crossing counted once.

        Returns
        -------
        Estimate or EstimateArray
            [m s^-1]
        """
        return self._mean("speeds", ARRIVALS)

    @cached_property
    def mean_speed_out(self) -> EstimateOrArray:
        """Mean speed of departures [m s^-1].

        Returns
        -------
        Estimate or EstimateArray
            [m s^-1]
        """
        return self._mean("speeds", DEPARTURES)

    @cached_property
    def mean_square_speed_in(self) -> EstimateOrArray:
        """Mean square speed of arrivals [m^2 s^-2].

        Returns
        -------
        Estimate or EstimateArray
            [m^2 s^-2]
        """
        return self._mean("squares", ARRIVALS)

    @cached_property
    def mean_square_speed_out(self) -> EstimateOrArray:
        """Mean square speed of departures [m^2 s^-2].

        Returns
        -------
        Estimate or EstimateArray
            [m^2 s^-2]
        """
        return self._mean("squares", DEPARTURES)

    @cached_property
    def mean_energy_in(self) -> EstimateOrArray:
        """Mean kinetic energy of arrivals [J]: m v²/2 for particles of known mass.

        Returns
        -------
        Estimate or EstimateArray
            [J]
        """
        return self._kinetic("mean_energy_in", self.mean_square_speed_in)

    @cached_property
    def mean_energy_out(self) -> EstimateOrArray:
        """Mean kinetic energy of departures [J].

        Returns
        -------
        Estimate or EstimateArray
            [J]
        """
        return self._kinetic("mean_energy_out", self.mean_square_speed_out)

    def __repr__(self) -> str:
        return f"<{self.name}: flux_in {self.flux_in}, flux_out {self.flux_out}>"

    # ---- findings ----

    def _with_findings(
        self,
        made: EstimateOrArray,
        side: int,
        factor: float | np.ndarray,
        shape: tuple[int, ...],
        more: Callable[[], Iterable[Finding]] = tuple,
    ) -> EstimateOrArray:
        """Attach the findings of a side, and `more`, to a quantity.

        factor: the quantity for a mean weight of 1, (*shape) as the sums.
        """
        bins = made._replicates.shape

        def findings() -> Iterator[Finding]:
            each = np.broadcast_to(factor, shape).reshape(bins) if bins else float(np.ravel(factor)[0])
            for finding in self._missing(side, is_whole=not bins):
                yield replace(finding, bound=np.abs(finding.bound * each))
            yield from more()

        return made._with_findings(findings, self._allowed)

    def _missing(self, side: int, is_whole: bool = True) -> list[Finding]:
        """Findings on a side, with bounds as mean weights of a history; is_whole: for all bins together."""
        if side not in self._found:
            found = self._path_findings(side), self._score_findings(side)
            self._found[side] = tuple([*with_cure(each, self._more)] for each in found)
        classes, of_scores = self._found[side]
        return classes + of_scores if is_whole else classes

    def _path_findings(self, side: int) -> Iterator[Finding]:
        """Findings about classes of paths found by chance, and from geometry and the energy balance."""
        sums = self.sums
        if self.is_sure(side):
            return
        scores = int(sums.whole("counts", side).sum())
        total = self._total(side)
        yield from detector_path_findings(
            self._plan, sums.batches, self._title, self.name, side, scores, total.value, total.error
        )
        yield from detector_survivor_findings(sums, side, total)
        if side == ARRIVALS:
            yield from detector_unvisited_findings(sums, total)
            yield from detector_forward_peaks(sums, total)

    def _score_findings(self, side: int) -> Iterator[Finding]:
        """Findings from the sizes of the scores and from the batches."""
        total = self._total(side)
        if not self.is_sure(side) and total.error > 0:
            particles = int(self.sums.run.sizes.sum())
            yield from findings_of_error(self._title, total, self.scores_on(side), particles)

    def grazing_findings(self) -> Iterator[Finding]:
        """Findings about the fluence rate alone."""
        return grazing_findings(self.sums, self._title)

    def total(self, side: int) -> Estimate:
        """Mean weight that arrives (side 0) or departs (1) per history, over all bins, with findings."""
        return self._total(side)._with_findings(lambda: self._missing(side), self._allowed)

    def _total(self, side: int) -> Estimate:
        weights = self.sums.whole("weights", side).sum(axis=(1, 2))
        scores = int(self.sums.whole("counts", side).sum())
        return Estimate(weights / self.sums.run.sizes, self.sums.run, Unit(), self.is_sure(side), scores)

    def is_dark(self, side: int) -> bool:
        """Return whether geometry proves that nothing arrives (side 0) or departs (1)."""
        if side not in self._dark:
            self._dark[side] = self._is_dark(side)
        return self._dark[side]

    def _is_dark(self, side: int) -> bool:
        if self.sums.whole("counts", side).any():
            return False
        if side == DEPARTURES and no_light_departs(self._scene, self.sums.shape, self.detector):
            return True
        return (self.is_blind and bool(self._dark_reason)) or (side == ARRIVALS and self.cannot_arrive)

    def why_unscored(self) -> Iterator[Finding]:
        """Findings that explain why the detector has no score."""
        return (finding for side in (ARRIVALS, DEPARTURES) for finding in self._missing(side))

    def binned(self) -> Iterator[tuple[str, EstimateOrArray]]:
        """Yield radiance by direction, or irradiance and exitance by position, or flux by time or speed."""
        sums = self.sums
        for side, names in (
            (ARRIVALS, ("radiance", "irradiance", "flux_in")),
            (DEPARTURES, ("radiance_out", "exitance", "flux_out")),
        ):
            axes = sums.direction_axes, sums.position_axes, sums.outer_axes
            name = next((name for name, of_it in zip(names, axes, strict=True) if of_it), None)
            is_of_area = bool(sums.direction_axes or sums.position_axes)
            if name not in self.known or (is_of_area and sums.shape.is_infinite):
                continue
            if sums.whole("weights", side).any():
                yield name, getattr(self, name)

    def scores_on(self, side: int) -> Scores | None:
        """Scores of one side by size; None if their sizes are not known."""
        found = detector_scores(self.sums, side)
        # Sobol points leave no gaps: the error is far below the spacing of single scores; no larger score is
        # due.
        is_even = self._plan.method.sampling == "sobol"
        return replace(found, most=0.0) if found is not None and is_even else found

    @property
    def _title(self) -> str:
        return f"{self.title}{self.name!r}"

    # ---- from sums to estimates ----

    def _scale(self, per_second: bool, ndim: int) -> np.ndarray:
        """The value of a sum of 1, as a rate or in total, shaped for sums with `ndim` axes."""
        scale = self._plan.unit / (self.sums.seconds if per_second else 1.0)
        return np.reshape(scale, (*np.shape(scale), *(1,) * (ndim - 3))) if np.ndim(scale) else scale

    def _unit(self, per_second: bool) -> Unit:
        return self._rate if per_second else self._rate * Unit.parse("s")

    def _whole(self, side: int, per_second: bool = True) -> EstimateOrArray:
        values, counts = (self.sums.whole(kind, side) for kind in ("weights", "counts"))
        exact, scale = self.is_sure(side), self._scale(per_second, 3)
        made = self.sums.estimate(values * scale, self._unit(per_second), {}, counts, exact)
        return self._with_findings(made, side, scale, values.shape[1:])

    def _per_area(self, kind: str, side: int, per_second: bool = True) -> EstimateOrArray:
        values, counts = (self.sums.by_position(k, side) for k in (kind, "counts"))
        exact = (self.is_sure(side) and kind == "weights" and not self.sums.position_axes) or self.is_dark(
            side
        )
        values = values * self._scale(per_second, values.ndim) / self._areas
        unit = self._unit(per_second) / Unit.parse("m^2")
        made = self.sums.estimate(values, unit, self.sums.position_axes, counts, exact)
        factor = self._scale(per_second, values.ndim) / self._areas
        if kind != "slants":
            return self._with_findings(made, side, factor, values.shape[1:])
        return self._with_findings(
            made, side, MEAN_INVERSE_COSINE * factor, values.shape[1:], self.grazing_findings
        )

    def _by_direction(
        self,
        side: int,
        projected: bool,
        per_area: bool = True,
        volumes: np.ndarray | None = None,
        per: str = "1",
    ) -> EstimateOrArray:
        """Flux over solid angle, plain or projected, over area, and over `volumes` of the speed bins."""
        if self.detector.directions is None:
            wanted = "radiance" if projected else "a quantity by direction"
            self._refuse(wanted, "directions=..., got None", "write directions=Directions(mu=16) or similar")
        plain, cosines = solid_angles_of(self.detector, self.sums.shape)
        angles = cosines if projected else plain
        sums = self.sums
        values, counts = (sums.by_direction(kind, side) for kind in ("weights", "counts"))
        with np.errstate(divide="ignore", invalid="ignore"):
            values = values * self._scale(True, values.ndim) / np.where(angles > 0, angles, np.nan)
        unit, sizes = self._rate / Unit.parse("sr"), np.where(angles > 0, angles, np.nan)
        if per_area:
            areas = np.reshape(self._areas, np.shape(self._areas) + (1,) * len(sums.direction_axes))
            values, unit, sizes = values / areas, unit / Unit.parse("m^2"), sizes * areas
        if volumes is not None:
            volumes = np.reshape(volumes, (-1, *(1,) * (values.ndim - 3)))
            values, unit, sizes = values / volumes, unit / Unit.parse(per), sizes * volumes
        made = sums.estimate(
            values, unit, sums.position_axes | sums.direction_axes, counts, self.is_dark(side)
        )
        return self._with_findings(made, side, self._scale(True, values.ndim) / sizes, values.shape[1:])

    def _momentum(self, side: int) -> EstimateOrArray:
        self._need_moments("pressure")
        values, counts = (self.sums.by_position(kind, side) for kind in ("momentum", "counts"))
        if self._is_light:
            one = 1.0 / (float(self._plan.moments["slowest"]) * self._plan.speed_unit)
        else:
            one = self._mass("pressure") * self._plan.fastest
        scale = self._scale(True, values.ndim) * one
        made = self.sums.estimate(
            values * scale / self._areas,
            Unit.parse("Pa"),
            self.sums.position_axes,
            counts,
            self.is_dark(side),
        )
        return self._with_findings(made, side, scale / self._areas, values.shape[1:])

    def _mean(self, kind: str, side: int) -> EstimateOrArray:
        self._need_moments("a mean speed")
        power = {"speeds": 1, "squares": 2}[kind]
        counts = self.sums.whole("counts", side)
        total, weight = (self.sums.whole(k, side) for k in (kind, "weights"))
        unit, fastest = Unit.parse("m s^-1") ** power, self._plan.fastest**power
        brought = self.sums.estimate(total * fastest, unit, {}, counts)
        came = self.sums.estimate(weight, Unit(), {}, counts)
        # Missing particles may have the highest speed, which adds to the sum of speeds, or be at rest, which
        # adds to
        # the weight.
        brought = self._with_findings(brought, side, fastest, total.shape[1:])
        came = self._with_findings(came, side, 1.0, weight.shape[1:])
        mean = brought / came
        indices = {medium.index for medium in self._plan.distinct_media}
        if not has_several_speeds(scene_speeds(self._scene)) and len(indices) == 1:
            mean = mean._with_findings(())  # all have one speed, so missing particles do not matter
        return mean.unless(counts.sum(axis=0).reshape(np.shape(mean.value)) < MIN_SCORES_FOR_ERROR)

    def _kinetic(self, quantity: str, square: EstimateOrArray) -> EstimateOrArray:
        mass = self._mass(quantity)
        joules = Estimate(np.full(len(self.sums.run), mass / 2), self.sums.run, "J m^-2 s^2", exact=True)
        return square * joules

    @cached_property
    def _areas(self) -> float | np.ndarray:
        """Area of each bin of position [m^2], or of the whole shape."""
        positions = self.detector.positions
        return self.area if positions is None else positions.areas(self.sums.shape)

    def _mass(self, quantity: str) -> float:
        mass = None if self._is_light else scene_mass(self._scene)
        if mass is None:
            self._refuse(quantity, *missing_mass_message(self._scene))
        return mass

    def _need_moments(self, quantity: str) -> None:
        if not self.detector.moments:
            self._refuse(quantity, "moments", "write Detector(..., moments=True)")

    def _need_clock(self, quantity: str) -> None:
        if self._scene.duration is None:
            self._refuse(quantity, "a clock", "write Scene(..., duration=...)")

    def _refuse(self, quantity: str, need: str, cure: str) -> None:
        raise SceneError(f"Detector {self.name!r}: {quantity} needs {need}; {cure}")


def _departs_exactly_once(plan, detector: Detector) -> bool:
    """Return whether by construction every history leaves the detector's side exactly once."""
    scene, shape = plan.scene, plan.scene.shape_of(detector)
    is_picky = any(getattr(detector, name) is not None for name in ("times", "speeds", "via", "events"))
    return (
        not is_picky
        and not plan.has_acting_surfaces
        and not plan.has_media
        and not isinstance(shape, Mesh)
        and all(
            scene.shape_of(source) == shape
            and source.emission.has_side
            and source.is_back == detector.is_back
            and source.aim is None
            and (not shape.is_closed or not source.is_back)
            for source in scene.sources
        )
    )
