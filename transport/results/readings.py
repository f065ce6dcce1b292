"""What one detector read: counts turned into radiometric quantities, each with its standard error.

`_in`: what arrived at the detector's side; `_out`: what left from it.  Whole-shape quantities include what fell outside
the detector's bins of direction and position.  With `times` every quantity has a dim of time, and rates are means over
its bins; with `speeds` one of speed, each bin with the part that these speeds carry; then those of position (u, v) and,
for quantities by direction, (mu or theta, phi).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from transport.detectors import Detector
from transport.results.deep_ways import why_so_deep
from transport.results.empty_detector import cannot_arrive, why_dark
from transport.results.estimates import Estimate, EstimateOrArray
from transport.results.meter_sums import ARRIVALS, DEPARTURES, MeterSums
from transport.results.peaked import doubt_of_forward_rays
from transport.results.quantified import Quantified
from transport.results.solid_angles import solid_angles_of
from transport.results.survivors import doubt_of_meter
from transport.results.unvisited import doubt_of_rays
from transport.scene_speeds import scene_mass, scene_speeds, speeds_differ, why_no_mass
from transport.shapes import Mesh
from transport.units import Unit
from transport.validation import SceneError, refuse

QUANTITIES = (
    "flux_in", "flux_out", "irradiance", "exitance", "net_flux_density", "flux_density", "radiance", "radiance_out",
    "intensity", "intensity_out", "fluence_rate", "counts", "energy_in", "energy_out", "fluence", "phase_density",
    "pressure", "mean_speed_in", "mean_speed_out", "mean_square_speed_in", "mean_square_speed_out", "mean_energy_in",
    "mean_energy_out",
)  # fmt: skip

BY_DIRECTION = ("flux_density", "radiance", "radiance_out", "intensity", "intensity_out", "phase_density")
CLOCKED = ("energy_in", "energy_out", "fluence")
FEW = 30  # scores, below which a mean does not tell its error
OF_MOMENTS = QUANTITIES[QUANTITIES.index("pressure") :]


class Reading(Quantified):
    """One detector's quantities; see QUANTITIES.  Raises SceneError for one that it was not set up for."""

    known, title = QUANTITIES, "detector "

    def __init__(self, result, detector: Detector) -> None:
        plan = result.plan
        self.detector, self.name = detector, detector.name
        self._scene, self._plan = plan.scene, plan
        self.sums = MeterSums(plan, result.batches, result.run, detector)
        self._is_light = plan.scene.measured_in == "watts"
        self._rate = Unit.parse("W" if self._is_light else "s^-1")
        self._is_exact_out = _leaves_once(plan, detector)

    @cached_property
    def area(self) -> float:
        """Area of the shape [m^2].  Raises SceneError where it has no end."""
        shape = self.sums.shape
        if shape.is_infinite:
            kind, cure = (
                type(shape).__name__,
                "read flux_in, flux_out or intensity, or meter a Disk in its plane",
            )
            refuse(self.sums.detector, f"quantities per area need a finite one, got a {kind}; {cure}")
        return shape.area

    @property
    def is_blind(self) -> bool:
        """Whether nothing was counted at all."""
        return not any(self.sums.whole("counts", side).any() for side in (ARRIVALS, DEPARTURES))

    def is_sure(self, side: int) -> bool:
        """Whether what arrives (0) or leaves (1) is the same for every history by construction."""
        return self._is_exact_out and side == DEPARTURES

    @cached_property
    def warning(self) -> str | None:
        """What to know before trusting it: why it counted nothing, or what a history that has not come would outweigh."""
        sums, title = self.sums, f"detector {self.name!r}"
        if not any(sums.whole("weights", side).any() for side in (ARRIVALS, DEPARTURES)):
            particles = int(sums.run.sizes.sum())
            if why := self._why_dark or why_so_deep(self._plan, title, sums.shape, particles):
                return why
        doubt = doubt_of_meter(sums, self.is_blind) or doubt_of_rays(sums, self.flux_in)
        return doubt or doubt_of_forward_rays(sums, self.flux_in)

    @cached_property
    def cannot_arrive(self) -> bool:
        """Whether geometry proves that no light arrives at this side, while some may depart."""
        if self.sums.whole("counts", ARRIVALS).any() or (self.is_blind and self._why_dark):
            return False
        return cannot_arrive(self._scene, self.sums.shape, self.detector, self.is_blind)

    @cached_property
    def _why_dark(self) -> str | None:
        return why_dark(self._scene, f"detector {self.name!r}", self.sums.shape, self.detector)

    @cached_property
    def flux_in(self) -> EstimateOrArray:
        """Power [W], or particles per second, arriving at the whole shape: Φ."""
        return self._whole(ARRIVALS)

    @cached_property
    def flux_out(self) -> EstimateOrArray:
        """Power [W], or particles per second, leaving from the whole shape."""
        return self._whole(DEPARTURES)

    @cached_property
    def irradiance(self) -> EstimateOrArray:
        """Flux arriving per area, E [W m^-2 or s^-1 m^-2]; by position where the detector has positions."""
        return self._per_area("weights", ARRIVALS)

    @cached_property
    def exitance(self) -> EstimateOrArray:
        """Flux leaving per area, M [W m^-2 or s^-1 m^-2]; of a wall its radiosity, emitted and reflected."""
        return self._per_area("weights", DEPARTURES)

    @cached_property
    def net_flux_density(self) -> EstimateOrArray:
        """Exitance − irradiance, J [W m^-2 or s^-1 m^-2]: positive along the normal of the detector's side."""
        return self.exitance - self.irradiance

    @cached_property
    def radiance(self) -> EstimateOrArray:
        """Arriving radiance by direction bin, L [W m^-2 sr^-1 or s^-1 m^-2 sr^-1].

        Flux over area and over the bin's exact projected solid angle ∫cosθ dω, never over cosθ of single particles.
        """
        return self._by_direction(ARRIVALS, projected=True)

    @cached_property
    def radiance_out(self) -> EstimateOrArray:
        """Leaving radiance by direction bin [W m^-2 sr^-1 or s^-1 m^-2 sr^-1]."""
        return self._by_direction(DEPARTURES, projected=True)

    @cached_property
    def flux_density(self) -> EstimateOrArray:
        """Arriving flux per area and solid angle by direction bin: n v |cosθ| = L |cosθ| [W m^-2 sr^-1 ...]."""
        return self._by_direction(ARRIVALS, projected=False)

    @cached_property
    def intensity(self) -> EstimateOrArray:
        """Arriving flux per solid angle through the whole shape, I [W sr^-1 or s^-1 sr^-1]: ∫ L |cosθ| dA."""
        return self._by_direction(ARRIVALS, projected=False, per_area=False)

    @cached_property
    def intensity_out(self) -> EstimateOrArray:
        """Leaving flux per solid angle of the whole shape [W sr^-1 or s^-1 sr^-1]: a source's intensity."""
        return self._by_direction(DEPARTURES, projected=False, per_area=False)

    @cached_property
    def fluence_rate(self) -> EstimateOrArray:
        """Radiance over all directions, φ = ∫ L dω [W m^-2 or s^-1 m^-2]: what both directions of crossing bring.

        Scores weight/|μ|.  Below the grazing cut |μ| = 1e-3 a crossing scores its expectation for a constant
        radiance, 2/cut, so that the variance stays finite (MacMillan, Doster 1971); of a beam closer to grazing than
        that it is wrong, and the result warns where such light matters.
        """
        return self._per_area("slants", ARRIVALS) + self._per_area("slants", DEPARTURES)

    @cached_property
    def counts(self) -> EstimateOrArray:
        """Number of arrivals scored in the whole run, by bin."""
        sums, inner = self.sums, self.sums.place_axes | self.sums.direction_axes
        values = sums.by_direction("counts", ARRIVALS) if inner else sums.whole("counts", ARRIVALS)
        return sums.estimate(values * float(sums.run.sizes.sum()), Unit.parse("1"), inner, values)

    @cached_property
    def energy_in(self) -> EstimateOrArray:
        """Energy [J], or particles, that arrived within the duration, or within each bin of time."""
        self._need_clock("energy_in")
        return self._whole(ARRIVALS, per_second=False)

    @cached_property
    def energy_out(self) -> EstimateOrArray:
        """Energy [J], or particles, that left within the duration, or within each bin of time."""
        self._need_clock("energy_out")
        return self._whole(DEPARTURES, per_second=False)

    @cached_property
    def fluence(self) -> EstimateOrArray:
        """Fluence rate over the duration, or over each bin of time, H [J m^-2 or m^-2]."""
        self._need_clock("fluence")
        return self._per_area("slants", ARRIVALS, False) + self._per_area("slants", DEPARTURES, False)

    @cached_property
    def phase_density(self) -> EstimateOrArray:
        """Density in phase space by direction bin, n(x, v).

        With bins of speed [m^-6 s^3 for particles]: flux over area, ∫cosθ dω and ∫v³ dv, exact for each bin.  Where all
        fly alike, without them, radiance over speed [m^-3 sr^-1]: density in space and direction.
        """
        edges = self.detector.speed_edges()
        if edges is not None:
            volumes = np.diff(edges**4) / 4.0
            return self._by_direction(ARRIVALS, projected=True, volumes=volumes, per="m^4 s^-4 sr^-1")
        speeds = scene_speeds(self._scene)
        if speeds_differ(speeds):
            self._refuse("phase_density", "bins of speed, where speeds differ", "write speeds=edges in m/s")
        return self._by_direction(ARRIVALS, projected=True, volumes=np.array([speeds.pop()]), per="m s^-1")

    @cached_property
    def pressure(self) -> EstimateOrArray:
        """Momentum along the normal that arrives and leaves, per area and time [Pa]; of a wall, its pressure.

        Energy over speed for what is emitted in watts, mass times speed for particles.
        """
        return self._momentum(ARRIVALS) + self._momentum(DEPARTURES)

    @cached_property
    def mean_speed_in(self) -> EstimateOrArray:
        """Mean speed of what arrived [m s^-1], each as often as it crossed."""
        return self._mean("speeds", ARRIVALS)

    @cached_property
    def mean_speed_out(self) -> EstimateOrArray:
        """Mean speed of what left [m s^-1]."""
        return self._mean("speeds", DEPARTURES)

    @cached_property
    def mean_square_speed_in(self) -> EstimateOrArray:
        """Mean square of the speed of what arrived [m^2 s^-2]."""
        return self._mean("squares", ARRIVALS)

    @cached_property
    def mean_square_speed_out(self) -> EstimateOrArray:
        """Mean square of the speed of what left [m^2 s^-2]."""
        return self._mean("squares", DEPARTURES)

    @cached_property
    def mean_energy_in(self) -> EstimateOrArray:
        """Mean kinetic energy of what arrived [J]: m v²/2 of particles whose mass is known."""
        return self._kinetic("mean_energy_in", self.mean_square_speed_in)

    @cached_property
    def mean_energy_out(self) -> EstimateOrArray:
        """Mean kinetic energy of what left [J]."""
        return self._kinetic("mean_energy_out", self.mean_square_speed_out)

    def __repr__(self) -> str:
        return f"<{self.name}: flux_in {self.flux_in}, flux_out {self.flux_out}>"

    # ---- from sums to estimates ----

    def _scale(self, per_second: bool, ndim: int) -> np.ndarray:
        """What a sum of 1 means: as a rate or in all, shaped to go with sums of so many axes."""
        scale = self._plan.unit / (self.sums.seconds if per_second else 1.0)
        return np.reshape(scale, (*np.shape(scale), *(1,) * (ndim - 3))) if np.ndim(scale) else scale

    def _unit(self, per_second: bool) -> Unit:
        return self._rate if per_second else self._rate * Unit.parse("s")

    def _whole(self, side: int, per_second: bool = True) -> EstimateOrArray:
        values, counts = (self.sums.whole(kind, side) for kind in ("weights", "counts"))
        exact = self._is_exact_out and side == DEPARTURES
        return self.sums.estimate(
            values * self._scale(per_second, 3), self._unit(per_second), {}, counts, exact
        )

    def _per_area(self, kind: str, side: int, per_second: bool = True) -> EstimateOrArray:
        values, counts = (self.sums.by_place(k, side) for k in (kind, "counts"))
        exact = self._is_exact_out and side == DEPARTURES and kind == "weights" and not self.sums.place_axes
        values = values * self._scale(per_second, values.ndim) / self._areas
        unit = self._unit(per_second) / Unit.parse("m^2")
        return self.sums.estimate(values, unit, self.sums.place_axes, counts, exact)

    def _by_direction(
        self,
        side: int,
        projected: bool,
        per_area: bool = True,
        volumes: np.ndarray | None = None,
        per: str = "1",
    ) -> EstimateOrArray:
        """Flux over solid angle, plain or projected, over area, and over `volumes` of the bins of speed."""
        if self.detector.directions is None:
            wanted = "radiance" if projected else "a quantity by direction"
            self._refuse(wanted, "directions=..., got None", "write directions=Directions(mu=16) or similar")
        plain, cosines = solid_angles_of(self.detector, self.sums.shape)
        angles = cosines if projected else plain
        sums = self.sums
        values, counts = (sums.by_direction(kind, side) for kind in ("weights", "counts"))
        with np.errstate(divide="ignore", invalid="ignore"):
            values = values * self._scale(True, values.ndim) / np.where(angles > 0, angles, np.nan)
        unit = self._rate / Unit.parse("sr")
        if per_area:
            areas = np.reshape(self._areas, np.shape(self._areas) + (1,) * len(sums.direction_axes))
            values, unit = values / areas, unit / Unit.parse("m^2")
        if volumes is not None:
            values = values / np.reshape(volumes, (-1, *(1,) * (values.ndim - 3)))
            unit = unit / Unit.parse(per)
        return sums.estimate(values, unit, sums.place_axes | sums.direction_axes, counts)

    def _momentum(self, side: int) -> EstimateOrArray:
        self._need_moments("pressure")
        values, counts = (self.sums.by_place(kind, side) for kind in ("momentum", "counts"))
        if self._is_light:
            one = 1.0 / (float(self._plan.moments["slowest"]) * self._plan.speed_unit)
        else:
            one = self._mass("pressure") * self._plan.fastest
        values = values * (self._scale(True, values.ndim) * one) / self._areas
        return self.sums.estimate(values, Unit.parse("Pa"), self.sums.place_axes, counts)

    def _mean(self, kind: str, side: int) -> EstimateOrArray:
        self._need_moments("a mean speed")
        power = {"speeds": 1, "squares": 2}[kind]
        counts = self.sums.whole("counts", side)
        total, weight = (self.sums.whole(k, side) for k in (kind, "weights"))
        unit = Unit.parse("m s^-1") ** power
        total = self.sums.estimate(total * self._plan.fastest**power, unit, {}, counts)
        mean = total / self.sums.estimate(weight, Unit(), {}, counts)
        return mean.unless(counts.sum(axis=0).reshape(np.shape(mean.value)) < FEW)

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
            self._refuse(quantity, *why_no_mass(self._scene))
        return mass

    def _need_moments(self, quantity: str) -> None:
        if not self.detector.moments:
            self._refuse(quantity, "moments", "write Detector(..., moments=True)")

    def _need_clock(self, quantity: str) -> None:
        if self._scene.duration is None:
            self._refuse(quantity, "a clock", "write Scene(..., duration=...)")

    def _refuse(self, quantity: str, need: str, cure: str) -> None:
        raise SceneError(f"Detector {self.name!r}: {quantity} needs {need}; {cure}")


def _leaves_once(plan, detector: Detector) -> bool:
    """Whether by construction every history leaves once from the detector's side, and never more."""
    scene, shape = plan.scene, plan.scene.shape_of(detector)
    is_picky = any(getattr(detector, name) is not None for name in ("times", "speeds", "via", "events"))
    return (
        not is_picky
        and not plan.acts
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
