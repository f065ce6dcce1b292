"""The tally of a Detector: scores turned into radiometric quantities, each with its standard error.

A quantity with `_in` in its name counts arrivals at the detector's side, one with `_out` departures from it.
Quantities of the whole shape include scores outside the detector's bins of direction and position.  With
`times` every quantity has an axis of time, and rates are means over its bins; with `speeds` it has an axis of
speed, and each bin has the part of those speeds; then follow the axes of position (u, v) and, for quantities
by direction, (mu or theta, phi).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from transport.compile.rows import Rows
from transport.geometry.shape import Shape
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
from transport.results.score_sizes import detector_scores
from transport.results.solid_angles import solid_angles_of
from transport.results.tally import (
    ARRIVALS,
    DEPARTURES,
    NO_CLOCK,
    SIDES,
    Column,
    Formula,
    Lacks,
    Mean,
    Measure,
    Note,
    Quantity,
    Score,
    Tally,
    empty_note,
    energy_unit,
    moment_column,
    plain_column,
    seconds_of,
)
from transport.scene.detectors import Detector
from transport.scene.parts import SceneParts
from transport.scene.scene_speeds import has_several_speeds, missing_mass_message, scene_mass, scene_speeds
from transport.statistics.axes import COORDINATES, DIRECTION, POSITION, Axis
from transport.statistics.chunked import batch_totals
from transport.statistics.estimates import Estimate, EstimateOrArray
from transport.statistics.findings import Finding
from transport.statistics.quality import Scores, findings_of_error, with_cure
from transport.units import Unit

BINS = (POSITION, DIRECTION)
MOMENTS = ("momentum", "speed", "square")  # the three rows of velocity sums behind each row of scores
# Score of a crossing in a fluence rate, relative to its weight: the mean of 1/|mu| for constant radiance.
MEAN_INVERSE_COSINE = 2.0
CLOCK, OF_MOMENTS, BOTH = ("clock",), ("moments",), ("slant in", "slant out")


class Reading(Tally):
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

    title = "detector "

    # ---- through the whole shape, and per area ----

    flux_in = Quantity(
        "Power [W], or particles per second, arriving at the whole shape: flux Φ.",
        "weight in",
        per=("time",),
        needs=("all directions", "whole shape"),
    )
    flux_out = Quantity(
        "Power [W], or particles per second, leaving the whole shape.", "weight out", per=("time",)
    )
    irradiance = Quantity(
        "Flux arriving per area, E [W m^-2 or s^-1 m^-2]; by position if the detector has `positions`.",
        "weight in",
        (POSITION,),
        ("time", "area"),
        ("area", "all directions"),
    )
    exitance = Quantity(
        "Flux leaving per area, M [W m^-2 or s^-1 m^-2]; of a wall its radiosity (emitted plus reflected).",
        "weight out",
        (POSITION,),
        ("time", "area"),
        ("area",),
    )
    net_flux_density = Formula(
        "Exitance minus irradiance, J [W m^-2 or s^-1 m^-2]: positive along the normal of its side.",
        lambda tally: tally.exitance - tally.irradiance,
        ("area",),
    )

    # ---- by direction ----

    flux_density = Quantity(
        "Arriving flux per area and solid angle by direction bin: ``n v |cosθ| = L |cosθ|`` [W m^-2 sr^-1].",
        "weight in",
        BINS,
        ("time", "solid angle", "area"),
        ("directions", "area"),
    )
    radiance = Quantity(
        """Arriving radiance by direction bin, L [W m^-2 sr^-1 or s^-1 m^-2 sr^-1].

        Flux divided by the area and by the bin's exact projected solid angle ∫cosθ dω, never by cosθ of
        single particles.
        """,
        "weight in",
        BINS,
        ("time", "projected solid angle", "area"),
        ("directions", "area"),
    )
    radiance_out = Quantity(
        "Leaving radiance by direction bin [W m^-2 sr^-1 or s^-1 m^-2 sr^-1].",
        "weight out",
        BINS,
        ("time", "projected solid angle", "area"),
        ("directions", "area"),
    )
    intensity = Quantity(
        "Arriving flux per solid angle through the shape, I = ``∫ L |cosθ| dA`` [W sr^-1 or s^-1 sr^-1].",
        "weight in",
        BINS,
        ("time", "solid angle"),
        ("directions",),
    )
    intensity_out = Quantity(
        "Leaving flux per solid angle of the whole shape [W sr^-1 or s^-1 sr^-1]: a source's intensity.",
        "weight out",
        BINS,
        ("time", "solid angle"),
        ("directions",),
    )

    # ---- other scores ----

    fluence_rate = Quantity(
        """Radiance over all directions, φ = ∫ L dω [W m^-2 or s^-1 m^-2], of arrivals and departures.

        Each crossing scores weight/``|μ|``.  Below the grazing cut ``|μ|`` = 1e-3 it scores its expectation
        for constant radiance, 2/cut, so that the variance stays finite (MacMillan, Doster 1971).  This is
        wrong for a beam closer to grazing than the cut, and the number is doubtful if such light matters.
        """,
        BOTH,
        (POSITION,),
        ("time", "area"),
        ("area",),
    )
    counts = Quantity("Number of scored arrivals in the whole run, by bin [1].", "count in", BINS)
    energy_in = Quantity(
        "Energy [J], or particles, arriving within the duration, or within each bin of time.",
        "weight in",
        needs=CLOCK,
    )
    energy_out = Quantity(
        "Energy [J], or particles, leaving within the duration, or within each bin of time.",
        "weight out",
        needs=CLOCK,
    )
    fluence = Quantity(
        "Fluence rate integrated over the duration, or over each bin of time, H [J m^-2 or m^-2].",
        BOTH,
        (POSITION,),
        ("area",),
        ("clock", "area"),
    )
    phase_density = Quantity(
        """Density in phase space by direction bin, n(x, v).

        [m^-6 s^3] for particles with bins of speed: flux over area, ∫cosθ dω and ∫v³ dv, exact for each bin.
        [m^-3 sr^-1] without bins of speed, if all particles have one speed: radiance over speed, a density in
        space and direction.  Light has J in place of 1.
        """,
        "weight in",
        BINS,
        ("time", "projected solid angle", "area", "cubed speed"),
        ("directions", "area", "speeds"),
    )
    pressure = Quantity(
        """Momentum along the normal that arrives and leaves, per area and time [Pa]; the pressure on a wall.

        The momentum is energy over speed for sources in watts, and mass times speed for particles.
        """,
        ("momentum in", "momentum out"),
        (POSITION,),
        ("time", "area"),
        ("moments", "mass of momentum", "area"),
    )
    mean_speed_in = Mean(
        "Mean speed of arrivals [m s^-1], each crossing counted once.", "speed in", "share in", (), OF_MOMENTS
    )
    mean_speed_out = Mean("Mean speed of departures [m s^-1].", "speed out", "share out", (), OF_MOMENTS)
    mean_square_speed_in = Mean(
        "Mean square speed of arrivals [m^2 s^-2].", "square in", "share in", (), OF_MOMENTS
    )
    mean_square_speed_out = Mean(
        "Mean square speed of departures [m^2 s^-2].", "square out", "share out", (), OF_MOMENTS
    )
    mean_energy_in = Formula(
        "Mean kinetic energy of arrivals [J]: m v²/2 for particles of known mass.",
        lambda tally: tally.mean_square_speed_in * tally.constant("half mass"),
        ("moments", "mass"),
    )
    mean_energy_out = Formula(
        "Mean kinetic energy of departures [J].",
        lambda tally: tally.mean_square_speed_out * tally.constant("half mass"),
        ("moments", "mass"),
    )

    def __init__(self, result, detector: Detector) -> None:
        super().__init__(result, detector)
        self.shape = self.scene.shape_of(detector)
        self.rows = self._arrival_rows()
        self.axes = tuple(axis for name in COORDINATES for axis in self.rows.axes if axis.name == name)
        self._is_exact_out = _departs_exactly_once(self.plan, detector)
        self._found: dict[int, tuple[list[Finding], list[Finding]]] = {}
        self._dark: dict[int, bool] = {}

    def _arrival_rows(self) -> Rows:
        """Return the rows of arrivals; those of departures follow after plan.half."""
        return self.plan.rows_of[self.name]

    # ---- scores, measures, and what is lacking ----

    @cached_property
    def scores(self) -> Mapping[str, Score]:
        """The scores of both sides; rows of shadow rays are added to those of flights."""
        plan, number, energy = self.plan, float(self.run.sizes.sum()), energy_unit(self.plan)
        found, counts = {}, self._column("counts")
        for side, of_side in enumerate(SIDES):
            rows = replace(self.rows, first=self.rows.first + side * plan.half)
            sure, dark, missing = (
                partial(each, side) for each in (self.is_sure, self.is_dark, self._missing)
            )
            weight = Score(
                rows, self._column("weights"), counts, energy, plan.unit, 1.0, dark, sure, findings=missing
            )
            share = replace(weight, unit="1", scale=1.0, is_dark=_never, is_sure=_never)
            found |= {
                f"weight {of_side}": weight,
                f"slant {of_side}": replace(
                    weight,
                    column=self._column("slants"),
                    is_sure=_never,
                    largest=MEAN_INVERSE_COSINE,
                    notes=self.grazing_findings,
                ),
                f"count {of_side}": Score(rows, counts, counts, "1", number),
                f"share {of_side}": share,
            }
            if self.detector.moments:
                v = plan.fastest
                momentum = self._column("momentum")
                found |= {
                    f"momentum {of_side}": replace(
                        weight, column=momentum, unit="Pa s m^2", factor=self._momentum, is_sure=_never
                    ),
                    # Missing particles may have the highest speed, which adds to the sum of speeds, or be at
                    # rest, which adds to the weight.
                    f"speed {of_side}": replace(share, column=self._column("speed"), unit="m s^-1", scale=v),
                    f"square {of_side}": replace(
                        share, column=self._column("square"), unit="m^2 s^-2", scale=v**2
                    ),
                }
        return found

    def _column(self, name: str) -> Column:
        """A column of flights, plus that of shadow rays, whose sums are too large by a factor."""
        read = moment_column(MOMENTS.index(name), len(MOMENTS)) if name in MOMENTS else plain_column(name)
        scale = next((each.scale for each in self.plan.expectations if each.detector.name == self.name), None)
        if scale is None:
            return read
        shift, much = 2 * self.plan.half, 1 if name == "counts" else scale
        return lambda batch, a, b: read(batch, a, b) + read(batch, a + shift, b + shift) / much

    @cached_property
    def measures(self) -> Mapping[str, Callable[[], Measure]]:
        """Sizes of the bins, by name."""
        return {
            "time": lambda: seconds_of(self.plan, self.axes),
            "area": lambda: _areas(self.detector, self.shape),
            "solid angle": lambda: _solid_angles(self.detector, self.shape, 0),
            "projected solid angle": lambda: _solid_angles(self.detector, self.shape, 1),
            "cubed speed": lambda: _speeds(self.scene, self.axes),
            "half mass": lambda: Measure(scene_mass(self.scene) / 2, "J m^-2 s^2"),
        }

    @staticmethod
    def lacks_of(scene: SceneParts, detector: Detector) -> Lacks:
        """Return what the scene or the detector was not set up for; known before a run."""
        return _surface_lacks(scene, detector, scene.shape_of(detector))

    @cached_property
    def has_equal_means(self) -> bool:
        """Whether all particles have one speed."""
        indices = {medium.index for medium in self.plan.distinct_media}
        return not has_several_speeds(scene_speeds(self.scene)) and len(indices) == 1

    @property
    def _momentum(self) -> float:
        """Momentum per weight [per unit of the run]: energy over speed for light, else mass times speed."""
        if self.scene.measured_in == "watts":
            return 1.0 / (float(self.plan.moments["slowest"]) * self.plan.speed_unit)
        return (scene_mass(self.scene) or 0.0) * self.plan.fastest

    @property
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
        self.require("the area", ("area",))
        return self.shape.area

    # ---- what has scored, and what may be missing ----

    @property
    def is_blind(self) -> bool:
        """Whether the detector has no score.

        Returns
        -------
        bool
        """
        return not any(self.has_scores(side) for side in (ARRIVALS, DEPARTURES))

    def has_scores(self, side: int) -> bool:
        """Return whether anything arrived (side 0) or departed (1)."""
        return bool(self.counts_of(f"weight {SIDES[side]}").any())

    def has_weight(self, side: int) -> bool:
        """Return whether any weight arrived (side 0) or departed (1)."""
        return bool(self.sums(f"weight {SIDES[side]}").any())

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
        if any(self.has_weight(side) for side in (ARRIVALS, DEPARTURES)):
            return None
        deep = optical_depth_message(self.plan, self._title, self.shape, int(self.run.sizes.sum()))
        return empty_note(self._dark_reason, deep)

    @cached_property
    def cannot_arrive(self) -> bool:
        """Whether geometry proves that no light arrives at this side, while some may depart.

        Returns
        -------
        bool
        """
        if self.has_scores(ARRIVALS) or (self.is_blind and self._dark_reason):
            return False
        return cannot_arrive(self.scene, self.shape, self.detector, self.is_blind)

    @cached_property
    def may_arrive(self) -> bool:
        """Whether light may arrive and arrivals are what a user reads.

        On a surface or on a source a user may read departures alone.
        """
        is_on = is_on_surface(self.scene, self.shape, self.detector)
        return not is_on and not self.is_dark(ARRIVALS)

    @cached_property
    def _dark_reason(self) -> str | None:
        return no_light_message(self.scene, f"detector {self.name!r}", self.shape, self.detector)

    def __repr__(self) -> str:
        return f"<{self.name}: flux_in {self.flux_in}, flux_out {self.flux_out}>"

    # ---- findings ----

    def _missing(self, side: int, is_whole: bool = True) -> list[Finding]:
        """Findings on a side, with bounds as mean weights of a history; is_whole: for all bins together."""
        if side not in self._found:
            found = self._path_findings(side), self._score_findings(side)
            self._found[side] = tuple([*with_cure(each, self._more)] for each in found)
        classes, of_scores = self._found[side]
        return classes + of_scores if is_whole else classes

    def _path_findings(self, side: int) -> Iterator[Finding]:
        """Findings about classes of paths found by chance, and from geometry and the energy balance."""
        if self.is_sure(side):
            return
        total, scores = self._total(side), self.number_of(f"weight {SIDES[side]}")
        yield from detector_path_findings(
            self.plan, self.batches, self._title, self.name, side, scores, total.value, total.error
        )
        yield from detector_survivor_findings(self, f"weight {SIDES[side]}", total)
        if side == ARRIVALS:
            yield from detector_unvisited_findings(self, total)
            yield from detector_forward_peaks(self, total)

    def _score_findings(self, side: int) -> Iterator[Finding]:
        """Findings from the sizes of the scores and from the batches."""
        total = self._total(side)
        if not self.is_sure(side) and total.error > 0:
            particles = int(self.run.sizes.sum())
            yield from findings_of_error(self._title, total, self.scores_on(side), particles)

    def grazing_findings(self) -> Iterator[Finding]:
        """Findings about the fluence rate alone."""
        return grazing_findings(self, self._title)

    def total(self, side: int) -> Estimate:
        """Mean weight that arrives (side 0) or departs (1) per history, over all bins, with findings."""
        return self._total(side)._with_findings(lambda: self._missing(side), self._allowed)

    def _total(self, side: int) -> Estimate:
        name = f"weight {SIDES[side]}"
        weights = batch_totals(self.sums(name))
        return Estimate(weights / self.run.sizes, self.run, Unit(), self.is_sure(side), self.number_of(name))

    def is_dark(self, side: int) -> bool:
        """Return whether geometry proves that nothing arrives (side 0) or departs (1)."""
        if side not in self._dark:
            self._dark[side] = self._is_dark(side)
        return self._dark[side]

    def _is_dark(self, side: int) -> bool:
        if self.has_scores(side):
            return False
        if side == DEPARTURES and no_light_departs(self.scene, self.shape, self.detector):
            return True
        return (self.is_blind and bool(self._dark_reason)) or (side == ARRIVALS and self.cannot_arrive)

    def why_unscored(self) -> Iterator[Finding]:
        """Findings that explain why the detector has no score."""
        return (finding for side in (ARRIVALS, DEPARTURES) for finding in self._missing(side))

    def binned(self) -> Iterator[tuple[str, EstimateOrArray]]:
        """Yield radiance by direction, or irradiance and exitance by position, or flux by time or speed."""
        groups = [axis.group for axis in self.axes]
        for side, names in (
            (ARRIVALS, ("radiance", "irradiance", "flux_in")),
            (DEPARTURES, ("radiance_out", "exitance", "flux_out")),
        ):
            has = DIRECTION in groups, POSITION in groups, bool(groups)
            name = next((name for name, of_it in zip(names, has, strict=True) if of_it), None)
            is_of_area = DIRECTION in groups or POSITION in groups
            if name not in self.known or (is_of_area and self.shape.is_infinite):
                continue
            if self.has_weight(side):
                yield name, getattr(self, name)

    def scores_on(self, side: int) -> Scores | None:
        """Scores of one side by size; None if their sizes are not known."""
        found = detector_scores(self, side)
        # Sobol points leave no gaps: the error is far below the spacing of single scores; no larger score is
        # due.
        is_even = self.plan.method.sampling == "sobol"
        return replace(found, most=0.0) if found is not None and is_even else found

    @property
    def _title(self) -> str:
        return f"{self.title}{self.name!r}"


# ---- Axes, rows, measures and needs of a detector on a surface.


def _surface_lacks(scene: SceneParts, detector: Detector, shape: Shape) -> Lacks:
    """Return what the scene or the detector was not set up for, by need; known before a run."""
    is_light, speeds, mass = scene.measured_in == "watts", scene_speeds(scene), missing_mass_message(scene)
    has_mass = not is_light and scene_mass(scene) is not None
    infinite = f"a finite area, got a {type(shape).__name__}"
    lacks = {
        "clock": scene.duration is None and NO_CLOCK,
        "area": shape.is_infinite
        and (
            infinite,
            "read flux_in, flux_out or intensity, or use a Disk in its plane as the detector's shape",
        ),
        "directions": detector.directions is None
        and ("directions=..., got None", "write directions=Directions(mu=16) or similar"),
        "speeds": detector.speeds is None
        and has_several_speeds(speeds)
        and ("bins of speed where speeds differ", "write speeds=edges in m/s"),
        "moments": not detector.moments and ("moments", "write Detector(..., moments=True)"),
        "mass": not has_mass and mass,
        "mass of momentum": not has_mass and not is_light and mass,
    }
    return {need: why for need, why in lacks.items() if why}


def _areas(detector: Detector, shape: Shape) -> Measure:
    if detector.positions is None:
        return Measure(shape.area, "m^2")
    return Measure(detector.positions.areas(shape), "m^2", ("u", "v"))


def _solid_angles(detector: Detector, shape: Shape, which: int) -> Measure:
    """Solid angles (0) or projected ones (1); nan for an empty bin."""
    angles = solid_angles_of(detector, shape)[which]
    return Measure(np.where(angles > 0, angles, np.nan), "sr", ("mu", "theta", "phi"))


def _speeds(scene: SceneParts, axes: tuple[Axis, ...]) -> Measure:
    """∫v³ dv of each bin of speed; the speed of all particles where it is one."""
    binned = [axis for axis in axes if axis.name == "speed"]
    if binned:
        return Measure(np.diff(binned[0].edges ** 4) / 4.0, "m^4 s^-4 sr^-1", ("speed",))
    return Measure(scene_speeds(scene).pop(), "m s^-1")


def _never() -> bool:
    return False


def _departs_exactly_once(plan, detector: Detector) -> bool:
    """Return whether by construction every history leaves the detector's side exactly once."""
    scene, shape = plan.scene, plan.scene.shape_of(detector)
    is_picky = any(getattr(detector, name) is not None for name in ("times", "speeds", "via", "events"))
    return (
        not is_picky
        and not plan.has_acting_surfaces
        and not plan.has_media
        and not shape.triangles
        and all(
            scene.shape_of(source) == shape
            and source.emission.has_side
            and source.is_back == detector.is_back
            and source.aim is None
            and (not shape.is_closed or not source.is_back)
            for source in scene.sources
        )
    )
