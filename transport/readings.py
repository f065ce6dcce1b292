"""What one detector read: counts turned into radiometric quantities, each with its standard error.

`_in`: what arrived at the detector's side; `_out`: what left from it.  Whole-shape quantities include what fell outside
the detector's bins.  Quantities by position have the dims (u, v), those by direction (mu or theta, phi) as well.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from transport.detectors import Detector
from transport.estimates import Estimate, EstimateArray
from transport.looks import bin_counts
from transport.solid_angles import solid_angles_of
from transport.units import Unit
from transport.validation import SceneError, suggestion

QUANTITIES = (
    "flux_in", "flux_out", "irradiance", "exitance", "net_flux_density", "flux_density", "radiance", "radiance_out",
    "intensity", "intensity_out", "fluence_rate", "counts", "energy_in", "energy_out", "fluence", "phase_density",
)  # fmt: skip

BY_DIRECTION = ("flux_density", "radiance", "radiance_out", "intensity", "intensity_out", "phase_density")
CLOCKED = ("energy_in", "energy_out", "fluence")


class Reading:
    """One detector's quantities; see QUANTITIES.  Raises SceneError for one that it was not set up for."""

    def __init__(self, result, detector: Detector) -> None:
        plan = result.plan
        self.detector, self.name = detector, detector.name
        self._scene, self._run = plan.scene, result.run
        self._shape = plan.scene.shape_of(detector)
        self._is_gas = plan.scene.measured_in == "particles"
        self._scale = plan.unit / (plan.scene.duration if self._is_gas else 1.0)
        self._unit = Unit.parse("s^-1" if self._is_gas else "W")
        self._cells = bin_counts(detector, self._shape)
        self._batches, self._first, self._half = result.batches, plan.bases[detector.name], plan.half
        self._is_exact_out = _leaves_once(plan, detector)

    @cached_property
    def area(self) -> float:
        """Area of the shape [m^2]."""
        return self._shape.area

    @cached_property
    def flux_in(self) -> Estimate:
        """Power [W], or particles per second, arriving at the whole shape: Φ."""
        return self._whole("weights", 0)

    @cached_property
    def flux_out(self) -> Estimate:
        """Power [W], or particles per second, leaving from the whole shape."""
        return self._whole("weights", 1, exact=self._is_exact_out)

    @cached_property
    def irradiance(self) -> Estimate | EstimateArray:
        """Flux arriving per area, E [W m^-2 or s^-1 m^-2]; by position where the detector has positions."""
        return self._per_area("weights", 0)

    @cached_property
    def exitance(self) -> Estimate | EstimateArray:
        """Flux leaving per area, M [W m^-2 or s^-1 m^-2]; of a wall its radiosity, emitted and reflected."""
        return self._per_area("weights", 1)

    @cached_property
    def net_flux_density(self) -> Estimate | EstimateArray:
        """Exitance − irradiance, J [W m^-2 or s^-1 m^-2]: positive along the normal of the detector's side."""
        return self.exitance - self.irradiance

    @cached_property
    def radiance(self) -> Estimate | EstimateArray:
        """Arriving radiance by direction bin, L [W m^-2 sr^-1 or s^-1 m^-2 sr^-1].

        Flux over area and over the bin's exact projected solid angle ∫cosθ dω, never over cosθ of single particles.
        """
        return self._by_direction(0, projected=True)

    @cached_property
    def radiance_out(self) -> Estimate | EstimateArray:
        """Leaving radiance by direction bin [W m^-2 sr^-1 or s^-1 m^-2 sr^-1]."""
        return self._by_direction(1, projected=True)

    @cached_property
    def flux_density(self) -> Estimate | EstimateArray:
        """Arriving flux per area and solid angle by direction bin: n v |cosθ| = L |cosθ| [W m^-2 sr^-1 ...]."""
        return self._by_direction(0, projected=False)

    @cached_property
    def intensity(self) -> Estimate | EstimateArray:
        """Arriving flux per solid angle through the whole shape, I [W sr^-1 or s^-1 sr^-1]: ∫ L |cosθ| dA."""
        return self._by_direction(0, projected=False, per_area=False)

    @cached_property
    def intensity_out(self) -> Estimate | EstimateArray:
        """Leaving flux per solid angle of the whole shape [W sr^-1 or s^-1 sr^-1]: a source's intensity."""
        return self._by_direction(1, projected=False, per_area=False)

    @cached_property
    def fluence_rate(self) -> Estimate | EstimateArray:
        """Radiance over all directions, φ = ∫ L dω [W m^-2 or s^-1 m^-2]: what both directions of crossing bring.

        Scores weight/|μ|.  Below the grazing cut |μ| = 1e-3 a crossing scores its expectation for a constant
        radiance, 2/cut, so that the variance stays finite (MacMillan, Doster 1971); a beam closer to grazing than
        that is underestimated.
        """
        return self._per_area("slants", 0) + self._per_area("slants", 1)

    @cached_property
    def counts(self) -> Estimate | EstimateArray:
        """Number of arrivals scored in the whole run, by bin."""
        values = self._binned("counts", 0) if self._axes else self._total("counts", 0)
        return self._estimate(values * self._run.sizes.sum(), Unit.parse("1"), self._axes)

    @cached_property
    def energy_in(self) -> Estimate:
        """Energy [J], or particles, that arrived within the duration."""
        return self.flux_in * self._duration("energy_in")

    @cached_property
    def energy_out(self) -> Estimate:
        """Energy [J], or particles, that left within the duration."""
        return self.flux_out * self._duration("energy_out")

    @cached_property
    def fluence(self) -> Estimate | EstimateArray:
        """Fluence rate over the duration, H [J m^-2 or m^-2]."""
        return self.fluence_rate * self._duration("fluence")

    @cached_property
    def phase_density(self) -> Estimate | EstimateArray:
        """Radiance over speed: density in space and direction, L/v [m^-3 sr^-1 for particles], where all fly alike."""
        speeds = {source.emission.speed for source in self._scene.sources}
        if len(speeds) > 1:
            self._refuse("phase_density", f"one speed of all sources, got {sorted(speeds)}", "take radiance")
        per_speed = Estimate(np.full(len(self._run), 1 / speeds.pop()), self._run, "s m^-1", exact=True)
        return self.radiance * per_speed

    def __getattr__(self, name: str):
        if name.startswith("_"):
            raise AttributeError(name)
        raise AttributeError(
            f"detector {self.name!r} has no quantity {name!r}; {suggestion(name, QUANTITIES)}"
        )

    @property
    def quantities(self) -> dict[str, Estimate | EstimateArray]:
        """All quantities that this detector was set up for."""
        found = {}
        for name in QUANTITIES:
            try:
                found[name] = getattr(self, name)
            except SceneError:
                continue
        return found

    def __repr__(self) -> str:
        return f"<{self.name}: flux_in {self.flux_in}, flux_out {self.flux_out}>"

    # ---- from sums to estimates ----

    def _rows(self, kind: str, side: int) -> np.ndarray:
        """Sums of the batches, (B, 1 + bins); the first column fell outside all bins."""
        first = self._first + side * self._half
        return np.array(
            [getattr(b, kind)[first : first + 1 + math.prod(self._cells.values())] for b in self._batches]
        )

    def _total(self, kind: str, side: int) -> np.ndarray:
        return self._rows(kind, side).sum(axis=1)

    def _binned(self, kind: str, side: int) -> np.ndarray:
        """Sums (B, *dims) in the public order: u, v, mu or theta, phi, without axes that are not binned."""
        values = self._rows(kind, side)[:, 1:].reshape(len(self._batches), *self._cells.values())
        values = values.swapaxes(3, 4)  # stored (u, v, azimuth, cosine)
        if "theta" in self._direction_edges and self._cells["mu"] > 1:
            values = values[:, :, :, ::-1]  # stored by rising cosine
        return values.reshape(len(values), *(len(edges) - 1 for edges in self._axes.values()))

    def _per_history(self, values: np.ndarray) -> np.ndarray:
        return self._run.sizes.reshape(-1, *(1,) * (values.ndim - 1))

    def _estimate(self, values, unit, axes, counts=None, exact=False):
        values = values / self._per_history(values)
        if not axes:
            return Estimate(values.reshape(len(self._run)), self._run, unit, exact=exact, counts=counts)
        return EstimateArray(values, self._run, unit, tuple(axes), axes, counts=counts)

    def _whole(self, kind: str, side: int, exact: bool = False) -> Estimate:
        counts = int(self._total("counts", side).sum())
        return self._estimate(self._total(kind, side) * self._scale, self._unit, {}, counts, exact)

    def _per_area(self, kind: str, side: int) -> Estimate | EstimateArray:
        unit = self._unit / Unit.parse("m^2")
        if self.detector.positions is None:
            counts = int(self._total("counts", side).sum())
            exact = self._is_exact_out and side == 1 and kind == "weights"
            return self._estimate(self._total(kind, side) * self._scale / self.area, unit, {}, counts, exact)
        axes = self._position_edges
        values, counts = (self._binned(k, side) for k in (kind, "counts"))
        over = tuple(range(1 + len(axes), values.ndim))
        values = values.sum(axis=over) * self._scale / self._areas
        return self._estimate(values, unit, axes, counts.sum(axis=(0, *over)))

    def _by_direction(self, side: int, projected: bool, per_area: bool = True) -> Estimate | EstimateArray:
        if self.detector.directions is None:
            wanted = "radiance" if projected else "a quantity by direction"
            self._refuse(wanted, "directions=..., got None", "write directions=Directions(mu=16) or similar")
        plain, cosines = solid_angles_of(self.detector, self._shape)
        angles = cosines if projected else plain
        with np.errstate(divide="ignore", invalid="ignore"):
            values = self._binned("weights", side) * self._scale / np.where(angles > 0, angles, np.nan)
        counts = self._binned("counts", side).sum(axis=0)
        unit = self._unit / Unit.parse("sr")
        if per_area:
            areas = self.area if self.detector.positions is None else self._areas
            areas = np.reshape(areas, np.shape(areas) + (1,) * len(self._direction_axes))
            values, unit = values / areas, unit / Unit.parse("m^2")
        return self._estimate(values, unit, self._axes, counts)

    @cached_property
    def _position_edges(self) -> dict[str, np.ndarray]:
        positions = self.detector.positions
        return {} if positions is None else positions.edges(self._shape)

    @cached_property
    def _direction_edges(self) -> dict[str, np.ndarray]:
        directions = self.detector.directions
        return {} if directions is None else directions.edges()

    @property
    def _direction_axes(self) -> dict[str, np.ndarray]:
        order = ("mu", "theta", "phi")
        return {name: self._direction_edges[name] for name in order if name in self._direction_edges}

    @property
    def _axes(self) -> dict[str, np.ndarray]:
        return self._position_edges | self._direction_axes

    @cached_property
    def _areas(self) -> np.ndarray:
        return self.detector.positions.areas(self._shape)

    def _duration(self, quantity: str) -> Estimate:
        if self._scene.duration is None:
            self._refuse(quantity, "a clock", "write Scene(..., duration=...)")
        return Estimate(np.full(len(self._run), self._scene.duration), self._run, "s", exact=True)

    def _refuse(self, quantity: str, need: str, cure: str) -> None:
        raise SceneError(f"Detector {self.name!r}: {quantity} needs {need}; {cure}")


def _leaves_once(plan, detector: Detector) -> bool:
    """Whether by construction every history leaves once from the detector's side, and never more."""
    scene, shape = plan.scene, plan.scene.shape_of(detector)
    return not plan.acts and all(
        scene.shape_of(source) == shape
        and source.emission.has_side
        and source.is_back == detector.is_back
        and source.aim is None
        and (not shape.is_closed or not source.is_back)
        for source in scene.sources
    )
