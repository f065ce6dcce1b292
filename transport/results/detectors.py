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
from typing import Any

import numpy as np

from transport.compile.detectors import PATH_UNIT
from transport.compile.rows import Rows
from transport.geometry.shape import Shape
from transport.results.solid_angles import solid_angles_of
from transport.results.tally import (
    NO_CLOCK,
    SIDES,
    Column,
    Formula,
    Lacks,
    MeanPerWeight,
    Measure,
    Quantity,
    Score,
    Tally,
    energy_unit,
    moment_column,
    plain_column,
    seconds_of,
)
from transport.scene.detectors import Detector
from transport.scene.parts import SceneParts
from transport.scene.scene_speeds import has_several_speeds, missing_mass_message, scene_mass, scene_speeds
from transport.statistics.axes import COORDINATES, DIRECTION, POSITION, Axis
from transport.statistics.chunked import batch_totals, over_batches
from transport.statistics.estimates import EstimateOrArray

BINS = (POSITION, DIRECTION)
# Score of a crossing in a fluence rate, relative to its weight: the mean of 1/|mu| for constant radiance.
MEAN_INVERSE_COSINE = 2.0
MISSING_PATH = 10.0  # mean paths: the longest path that a particle which the run has missed is taken to have
CLOCK, OF_MOMENTS, OF_PATHS = ("clock",), ("moments",), ("path lengths",)
BOTH = ("slant in", "slant out")


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

    main = ("weight in", "weight out")

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
    mean_speed_in = MeanPerWeight(
        "Mean speed of arrivals [m s^-1], each crossing counted once.", "speed in", "share in", (), OF_MOMENTS
    )
    mean_speed_out = MeanPerWeight(
        "Mean speed of departures [m s^-1].", "speed out", "share out", (), OF_MOMENTS
    )
    mean_square_speed_in = MeanPerWeight(
        "Mean square speed of arrivals [m^2 s^-2].", "square in", "share in", (), OF_MOMENTS
    )
    mean_square_speed_out = MeanPerWeight(
        "Mean square speed of departures [m^2 s^-2].", "square out", "share out", (), OF_MOMENTS
    )
    mean_path_in = MeanPerWeight(
        """Mean length of the paths of arrivals in each medium of `path_lengths` [m], from birth to arrival.

        The mean is over arriving weight, so it is the relative loss of what arrives per absorption
        coefficient: -d ln(flux_in)/d(absorption) of that medium.  A path counts as 2^24 sizes of the scene at
        most, which only a ray along an infinite plane can exceed.
        """,
        "path in",
        "path weight in",
        BINS,
        OF_PATHS,
    )
    mean_path_out = MeanPerWeight(
        "Mean length of the paths of departures in each medium of `path_lengths` [m].",
        "path out",
        "path weight out",
        BINS,
        OF_PATHS,
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
        media = np.arange(len(detector.path_lengths or ()))
        self.media = (Axis("medium", media, is_instants=True),) if len(media) else ()
        axes = (*self.media, *self.rows.axes)
        self.axes = tuple(axis for name in COORDINATES for axis in axes if axis.name == name)

    def _arrival_rows(self) -> Rows:
        """Return the rows of arrivals; those of departures follow after plan.half."""
        return self.plan.rows_of[self.name]

    # ---- scores, measures, and what is lacking ----

    @cached_property
    def scores(self) -> Mapping[str, Score]:
        """The scores of both sides; rows of shadow rays are added to those of flights."""
        plan, number, energy = self.plan, float(self.particles), energy_unit(self.plan)
        found, counts = {}, self._column("counts")
        for side, of_side in enumerate(SIDES):
            rows = replace(self.rows, first=self.rows.first + side * plan.half)
            diagnosis, name = self.diagnosis, f"weight {of_side}"
            sure, dark, missing = (
                partial(each, name) for each in (diagnosis.is_sure, diagnosis.is_dark, diagnosis.missing)
            )
            weights, known = self._column("weights"), {"is_dark": dark, "is_sure": sure, "findings": missing}
            weight = Score(rows, weights, counts, energy, plan.unit, **known)
            share = replace(weight, unit="1", scale=1.0, is_dark=_never, is_sure=_never)
            found |= {
                name: weight,
                f"slant {of_side}": replace(
                    weight,
                    column=self._column("slants"),
                    is_sure=_never,
                    largest=MEAN_INVERSE_COSINE,
                    notes=diagnosis.grazing,
                ),
                f"count {of_side}": Score(rows, counts, counts, "1", number),
                f"share {of_side}": share,
            }
            if self.detector.moments:
                v = plan.fastest
                momentum = self._column("momentum")
                found |= {
                    f"momentum {of_side}": replace(
                        weight,
                        column=momentum,
                        unit="Pa s m^2",
                        scale=plan.unit * self._momentum,
                        is_sure=_never,
                    ),
                    # Missing particles may have the highest speed, which adds to the sum of speeds, or be at
                    # rest, which adds to the weight.
                    f"speed {of_side}": replace(share, column=self._column("speed"), unit="m s^-1", scale=v),
                    f"square {of_side}": replace(
                        share, column=self._column("square"), unit="m^2 s^-2", scale=v**2
                    ),
                }
            if media := self.detector.path_lengths:
                # Weights with all their digits, however faint, below the paths that have theirs.
                weight_of_paths = replace(share, column=self._column("path weight"))
                found[f"path weight {of_side}"] = weight_of_paths
                found[f"path {of_side}"] = replace(
                    weight_of_paths,
                    column=self._path_columns(),
                    counts=lambda batch, a, b: np.broadcast_to(batch.counts[a:b], (len(media), b - a)),
                    unit="m",
                    scale=PATH_UNIT * plan.space.size,
                    largest=partial(self._longest_paths, side),
                    parts=self.media[0],
                )
        return found

    def _longest_paths(self, side: int) -> np.ndarray:
        """The longest path of missing particles in each medium, as sums: a multiple of the mean path."""
        paths = over_batches(self.sums(f"path {SIDES[side]}")).reshape(len(self.media[0]), -1).sum(axis=1)
        weight = batch_totals(self.sums(f"path weight {SIDES[side]}")).sum()
        longest = paths.max() / weight if weight > 0 else 0.0  # a missing particle may fly in any medium
        return np.full(len(paths), MISSING_PATH * longest)

    def _path_columns(self) -> Column:
        """The sums of path lengths in each medium of `path_lengths`."""
        sums, known = self.plan.long_sums, self.scene.path_media
        places = [sums.index(f"path {known.index(medium)}") for medium in self.detector.path_lengths]
        columns = [moment_column(place, len(sums)) for place in places]
        return lambda batch, a, b: np.array([column(batch, a, b) for column in columns])

    @property
    def heading(self) -> str:
        """Title in a report, with the side."""
        return f"{self.title}, {self.detector.side}"

    @property
    def expectation(self) -> Any:
        """Return what next-event estimation knows of the detector; None without it."""
        return next((each for each in self.plan.expectations if each.detector.name == self.name), None)

    def _column(self, name: str) -> Column:
        """A column of flights, plus that of shadow rays, whose sums are too large by a factor."""
        sums = self.plan.long_sums
        read = moment_column(sums.index(name), len(sums)) if name in sums else plain_column(name)
        if self.expectation is None:
            return read
        shift, much = 2 * self.plan.half, 1 if name == "counts" else self.expectation.scale
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
            (table,) = (score.table for score in self.plan.long_scores if "momentum" in score.sums)
            return 1.0 / (float(table["slowest"]) * self.plan.speed_unit)
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

    def __repr__(self) -> str:
        return f"<{self.name}: flux_in {self.flux_in}, flux_out {self.flux_out}>"

    def binned(self) -> Iterator[tuple[str, EstimateOrArray]]:
        """Yield radiance by direction, or irradiance and exitance by position, or flux by time or speed."""
        groups = [axis.group for axis in self.rows.axes]
        for score, names in zip(
            self.main,
            (("radiance", "irradiance", "flux_in"), ("radiance_out", "exitance", "flux_out")),
            strict=False,  # a backward run knows arrivals alone
        ):
            has = DIRECTION in groups, POSITION in groups, bool(groups)
            name = next((name for name, of_it in zip(names, has, strict=True) if of_it), None)
            is_of_area = DIRECTION in groups or POSITION in groups
            if name not in self.known or (is_of_area and self.shape.is_infinite):
                continue
            if self.has_weight(score):
                yield name, getattr(self, name)


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
        "path lengths": not detector.path_lengths
        and ("path_lengths=[...], got None", "write path_lengths=[medium] with a medium of the scene"),
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
