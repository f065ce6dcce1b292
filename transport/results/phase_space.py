"""The readings of a PhaseSpace (densities and moments by bin) and of a Snapshot (a sample of particles)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property

import numpy as np

from transport.compile.detectors import count_bins, max_relative_speed, reference_velocity
from transport.compile.layout import VELOCITY_SUMS
from transport.renderers import function_for
from transport.results.batches import Batch, chosen_records, common_probability, distinct_identities
from transport.results.reading import ReadingBase
from transport.scene.phase_space import COORDINATES, PhaseSpace, Snapshot
from transport.scene.scene_speeds import missing_mass_message, scene_mass
from transport.statistics.batches import MIN_SCORES_FOR_ERROR
from transport.statistics.chunked import (
    Box,
    ChunkedArray,
    is_large,
    over_batches,
    release_pages,
    rows_in_chunk,
    summed_counts,
)
from transport.statistics.estimates import Estimate, EstimateArray, EstimateOrArray
from transport.units import BOLTZMANN, Unit
from transport.validation import SceneError

ROUNDING = 8 * 2.0**-52  # relative rounding error of a difference of sums
PHASE_QUANTITIES = (
    "number", "density", "alive", "outside", "mean_vx", "mean_vy", "mean_vz", "variance_vx", "variance_vy",
    "variance_vz", "mean_speed", "fluence_rate", "temperature", "pressure",
)  # fmt: skip
OF_PHASE_MOMENTS = PHASE_QUANTITIES[PHASE_QUANTITIES.index("mean_vx") :]


class PhaseReading(ReadingBase):
    """The quantities of one PhaseSpace, from `result["name"]`.

    Parameters
    ----------
    result : Result
        The run.
    phase_space : PhaseSpace
        The phase space of the scene.

    Raises
    ------
    SceneError
        When a quantity is read for which the phase space has not the options.

    Notes
    -----
    Each quantity has the axes of the coordinates, and `time` in front if there are several times.  The unit 1
    is J for light.
    """

    known, title = PHASE_QUANTITIES, "phase space "

    def __init__(self, result, phase_space: PhaseSpace) -> None:
        self.phase_space, self.name = phase_space, phase_space.name
        self._plan, self._run, self._batches = result.plan, result.run, result.batches
        self._is_light = result.plan.scene.measured_in == "watts"
        self._unit = Unit.parse("J" if self._is_light else "1")
        self._times = len(phase_space.times)
        self._bins = count_bins(phase_space)

    @cached_property
    def number(self) -> EstimateArray:
        """Number of particles [1], or their energy [J], in each bin.

        Returns
        -------
        EstimateArray
            [1 or J]
        """
        return self._binned_estimate(self._in_bins("weights") * self._plan.unit, self._unit)

    @cached_property
    def density(self) -> EstimateArray:
        """Particles (or J) per product of the bin widths; with `within` also per extent on other axes.

        Returns
        -------
        EstimateArray
            [1 or J, per product of the coordinates' units]
        """
        return self._binned_estimate(
            self._in_bins("weights") * self._plan.unit / self._measure, self._unit / self._measure_unit
        )

    @cached_property
    def alive(self) -> EstimateOrArray:
        """All particles (or J) that were born and had not ended: inside and outside the bins.

        Returns
        -------
        Estimate or EstimateArray
            [1 or J]
        """
        return self._by_time(
            self._in_all("weights"), self._in_all("counts"), _are_all_alive_always(self._plan)
        )

    @cached_property
    def outside(self) -> EstimateOrArray:
        """Particles (or J) outside all bins or outside `within`.

        Returns
        -------
        Estimate or EstimateArray
            [1 or J]
        """
        return self._by_time(self._outside("weights"), self._outside("counts"))

    @cached_property
    def mean_vx(self) -> EstimateArray:
        """Mean x component of the velocity [m s^-1].

        Returns
        -------
        EstimateArray
            [m s^-1]
        """
        return self._mean("vx") + self._reference("x")

    @cached_property
    def mean_vy(self) -> EstimateArray:
        """Mean y component of the velocity [m s^-1].

        Returns
        -------
        EstimateArray
            [m s^-1]
        """
        return self._mean("vy") + self._reference("y")

    @cached_property
    def mean_vz(self) -> EstimateArray:
        """Mean z component of the velocity [m s^-1].

        Returns
        -------
        EstimateArray
            [m s^-1]
        """
        return self._mean("vz") + self._reference("z")

    @cached_property
    def variance_vx(self) -> EstimateArray:
        """Variance of the velocity's x component within each bin [m^2 s^-2].

        Returns
        -------
        EstimateArray
            [m^2 s^-2]
        """
        return self._variance("x")

    @cached_property
    def variance_vy(self) -> EstimateArray:
        """Variance of the velocity's y component within each bin [m^2 s^-2].

        Returns
        -------
        EstimateArray
            [m^2 s^-2]
        """
        return self._variance("y")

    @cached_property
    def variance_vz(self) -> EstimateArray:
        """Variance of the velocity's z component within each bin [m^2 s^-2].

        Returns
        -------
        EstimateArray
            [m^2 s^-2]
        """
        return self._variance("z")

    @cached_property
    def mean_speed(self) -> EstimateArray:
        """Mean speed [m s^-1].

        Returns
        -------
        EstimateArray
            [m s^-1]
        """
        return self._mean("speed")

    @cached_property
    def fluence_rate(self) -> EstimateArray:
        """n v: density times mean speed; φ = ∫ L dω [m^-2 s^-1] if `within` makes it a density in space.

        Returns
        -------
        EstimateArray
            [unit of `density` times m s^-1]
        """
        return self._binned_estimate(self._moment("speed") / self._measure, self._unit_of("speed"))

    @cached_property
    def temperature(self) -> EstimateArray:
        """Kinetic temperature [K]: mass times the velocity's variance over 3 k.

        Returns
        -------
        EstimateArray
            [K]

        Raises
        ------
        SceneError
            For light, or for particles of unknown mass.
        """
        return self._all_variances * self._constant(self._mass("temperature") / (3 * BOLTZMANN), "K m^-2 s^2")

    @cached_property
    def pressure(self) -> EstimateArray:
        """n k T: mass times density times the velocity's variance over 3 [Pa if `within` is given].

        Returns
        -------
        EstimateArray
            [Pa with `within`]

        Raises
        ------
        SceneError
            For light, or for particles of unknown mass.
        """
        third = self._constant(self._mass("pressure") / 3, "Pa m s^2")
        return self.density * self._all_variances * third

    def binned(self) -> Iterator[tuple[str, EstimateOrArray]]:
        """Yield the number of particles in each bin."""
        yield "number", self.number

    def __repr__(self) -> str:
        return f"<{self.name}: number {self.number!r}, outside {self.outside!r}>"

    # ---- from sums to estimates ----

    @cached_property
    def _shape(self) -> tuple[int, ...]:
        """Number of times, and of bins along each coordinate."""
        return (self._times, *(len(edges) - 1 for edges in self.phase_space.axes.values()))

    def _in_bins(self, kind: str) -> np.ndarray | ChunkedArray:
        """Weights or counts in the bins, (B, times, *bins)."""
        return self._arranged(lambda batch, first, many: self._rows(batch, kind, first, many))

    def _outside(self, kind: str) -> np.ndarray:
        """Weights (as particles or J) or counts outside all bins, (B, times): the first row of each time."""
        firsts = [time * (1 + self._bins) for time in range(self._times)]
        found = np.array([[self._rows(b, kind, first, 1)[0] for first in firsts] for b in self._batches])
        return found * self._plan.unit if kind == "weights" else found

    def _in_all(self, kind: str) -> np.ndarray:
        """Weights (as particles or J) or counts of all particles, (B, times)."""
        each, one = 1 + self._bins, self._plan.unit if kind == "weights" else 1
        rows = (self._rows(batch, kind, 0, self._times * each) * one for batch in self._batches)
        return np.array([of_batch.reshape(-1, each).sum(axis=1) for of_batch in rows])

    def _rows(self, batch: Batch, kind: str, first: int, many: int) -> np.ndarray:
        begin = self._plan.bases[self.name] + first
        return getattr(batch, kind)[begin : begin + many]

    def _moment(self, name: str) -> np.ndarray | ChunkedArray:
        """Sums of one velocity moment, (B, times, *bins), in SI units."""
        if not self.phase_space.moments:
            raise SceneError(
                f"PhaseSpace {self.name!r}: it has no moments; write PhaseSpace(..., moments=True)"
            )
        base, each = self._plan.first_long_rows[self.name], len(VELOCITY_SUMS)

        def rows(batch: Batch, first: int, many: int) -> np.ndarray:
            sums = batch.moments[base + each * first : base + each * (first + many)]
            return sums.reshape(-1, each)[:, VELOCITY_SUMS.index(name)]

        power = 2 if name.endswith("2") else 1
        return self._arranged(rows) * (self._plan.unit * max_relative_speed(self._plan) ** power)

    def _arranged(self, rows: Callable[[Batch, int, int], np.ndarray]) -> np.ndarray | ChunkedArray:
        """Arrange rows, in which each time starts with one row for outside the bins, as (B, times, *bins)."""
        shape = (len(self._batches), *self._shape)

        def part(box: Box) -> np.ndarray:
            def at(time: int) -> np.ndarray:
                begin = time * (1 + self._bins) + 1
                return rows_in_chunk(
                    lambda first, many: np.array([rows(b, begin + first, many) for b in self._batches]),
                    box[1:],
                    self._shape[1:],
                )

            return np.stack([at(time) for time in range(self._times)[box[0]]], axis=1)

        if is_large(shape):
            return ChunkedArray(shape, tuple(range(len(self._shape))), part)
        return part(tuple(slice(0, count) for count in self._shape))

    def _binned_estimate(self, values: np.ndarray | ChunkedArray, unit: Unit) -> EstimateArray:
        axes, counts = self._axes, self._in_bins("counts")
        shape = self._shape if self.phase_space.is_series else self._shape[1:]
        values = values / self._run.sizes.reshape(-1, *(1,) * len(self._shape))
        values, counts = (each.reshape(len(self._batches), *shape) for each in (values, counts))
        counts = summed_counts(counts)
        return EstimateArray(values, self._run, unit, tuple(axes), axes, counts=counts)

    def _by_time(self, values: np.ndarray, counts: np.ndarray, exact: bool = False) -> EstimateOrArray:
        values, counts = values / self._run.sizes[:, None], counts.sum(axis=0)
        if self.phase_space.is_series:
            times = {"time": np.array(self.phase_space.times)}
            return EstimateArray(values, self._run, self._unit, ("time",), times, counts, exact)
        return Estimate(values[:, 0], self._run, self._unit, exact, counts=int(counts[0]))

    @property
    def _axes(self) -> dict[str, np.ndarray]:
        times = {"time": np.array(self.phase_space.times)} if self.phase_space.is_series else {}
        return times | self.phase_space.axes

    @cached_property
    def _measure(self) -> np.ndarray:
        """Product of the bin widths inside `within`, times its extent on the other axes of space.

        Shape (*bins,), with nan for an empty bin.
        """
        widths = [self._widths(name, edges) for name, edges in self.phase_space.axes.items()]
        measure = widths[0] if len(widths) == 1 else np.multiply.outer(*widths)
        return np.where(measure > 0, measure, np.nan) * np.prod([length for _, length in self._other_lengths])

    def _widths(self, name: str, edges: np.ndarray) -> np.ndarray:
        box = self.phase_space.within
        if box is not None and name in ("x", "y", "z"):
            low, high = (corner["xyz".index(name)] for corner in box.bounds)
            edges = edges.clip(low, high)
        return np.diff(edges)

    @property
    def _measure_unit(self) -> Unit:
        unit = Unit.parse("1")
        for name in self.phase_space.axes:
            unit = unit * Unit.parse(COORDINATES[name])
        return unit * Unit.parse("m") ** len(self._other_lengths)

    @property
    def _other_lengths(self) -> list[tuple[str, float]]:
        box = self.phase_space.within
        lengths = () if box is None else zip("xyz", box.size, strict=True)
        return [(name, length) for name, length in lengths if name not in self.phase_space.axes]

    def _unit_of(self, name: str) -> Unit:
        return self._unit / self._measure_unit * Unit.parse("m s^-1")

    def _mean(self, name: str) -> EstimateArray:
        """Mean of one velocity moment: of the speed, or of a component about the reference velocity."""
        unit = Unit.parse("m s^-1") ** (2 if name.endswith("2") else 1)
        mean = self._binned_estimate(self._moment(name), self._unit * unit) / self.number
        return mean.unless(over_batches(self._in_bins("counts")).reshape(mean.shape) < MIN_SCORES_FOR_ERROR)

    def _reference(self, axis: str) -> Estimate:
        """Component of the velocity relative to which moments are taken."""
        return self._constant(reference_velocity(self._plan)["xyz".index(axis)], "m s^-1")

    def _variance(self, axis: str) -> EstimateArray:
        mean, square = self._mean(f"v{axis}"), self._mean(f"v{axis}2")
        variance = square - mean * mean
        with np.errstate(invalid="ignore"):  # a difference from rounding of the squares is no variance
            return variance.unless(ROUNDING * np.abs(square.value) > variance.error)

    @cached_property
    def _all_variances(self) -> EstimateArray:
        return self.variance_vx + self.variance_vy + self.variance_vz

    def _constant(self, value: float, unit: str) -> Estimate:
        return Estimate(np.full(len(self._run), value), self._run, unit, exact=True)

    def _mass(self, quantity: str) -> float:
        mass = None if self._is_light else scene_mass(self._plan.scene)
        if mass is None:
            need, cure = missing_mass_message(self._plan.scene)
            raise SceneError(f"PhaseSpace {self.name!r}: {quantity} needs {need}; {cure}")
        return mass


def _are_all_alive_always(plan) -> bool:
    """Return whether by construction every history exists at all times: born at 0 and never ended."""
    moments = [emitter.moment for emitter in plan.emitters]
    born_at_once = all(name == "set_birth_time" and row["start"] == 0 for name, row in moments)
    stays = not plan.has_acting_surfaces and not plan.absorbing_media
    return born_at_once and stays and all(emitter.target is None for emitter in plan.emitters)


class SnapshotReading(ReadingBase):
    """A sample of the particles alive at one instant, weighted so that sums over it are unbiased.

    Parameters
    ----------
    result : Result
        The run.
    snapshot : Snapshot
        The snapshot of the scene.
    number : int
        Index of the snapshot in the scene.

    Attributes
    ----------
    time : float
        The instant [s].
    positions, velocities : numpy.ndarray
        [m] and [m/s], shape (N, 3).
    weights : numpy.ndarray
        Particles, or J, that each sampled particle stands for, shape (N,).
    histories : numpy.ndarray
        A number per history of the run, equal at every instant, shape (N,).
    batches : numpy.ndarray
        Index of the run's batch of each particle, shape (N,).
    """

    title = "snapshot "

    def __init__(self, result, snapshot: Snapshot, number: int) -> None:
        self.snapshot, self.name = snapshot, snapshot.name
        plan, batches = result.plan, result.batches
        alike = [k for k, other in enumerate(plan.scene.snapshots) if other.particles == snapshot.particles]
        chance = common_probability([batch.records for batch in batches], alike, snapshot.particles)
        chosen = [chosen_records(batch.records, number, chance) for batch in batches]
        many = [np.count_nonzero(of_batch) for of_batch in chosen]
        self.time, self.batches = snapshot.time, np.repeat(np.arange(len(batches)), many)
        self.positions, self.velocities = np.empty((2, sum(many), 3))
        self.weights, self.histories = np.empty(sum(many)), np.empty(sum(many), np.int64)
        ends = np.cumsum(many)
        for batch, of_batch, past, length in zip(batches, chosen, ends, many, strict=True):
            self._fill(slice(past - length, past), batch.records[of_batch], batch.seed, result)
            release_pages(batch.records)
        self.weights *= plan.unit / result.particles / chance

    def _fill(self, rows: slice, records: np.ndarray, seed: int, result) -> None:
        """Write the chosen records of a batch into the arrays."""
        plan, space = result.plan, result.plan.space
        for axis, (x, origin) in enumerate(zip("xyz", space.origin, strict=True)):
            self.positions[rows, axis] = records[x] * space.size + origin
            self.velocities[rows, axis] = records[f"v{x}"] * plan.speed_unit
        self.weights[rows] = records["weight"]
        self.histories[rows] = distinct_identities(
            records["identity"], np.array([seed], np.uint64), result.seed
        )

    def _cure(self, name: str) -> str:
        return (
            "it is a sample: read positions, velocities, weights, histories or batches, or use a PhaseSpace"
            " for densities and moments"
        )

    def __len__(self) -> int:
        return len(self.weights)

    def __repr__(self) -> str:
        return f"<{self.name}: {len(self)} particles at {self.time:g} s>"

    def _repr_html_(self) -> str:
        return function_for(type(self), "html")(self)
