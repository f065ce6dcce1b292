"""The tallies of a PhaseSpace (densities and moments by bin) and of a Snapshot (a sample of particles)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from transport.compile.layout import VELOCITY_SUMS
from transport.compile.phase_space import max_relative_speed, reference_velocity
from transport.results.batches import chosen_records, common_probability, distinct_identities
from transport.results.tally import (
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
)
from transport.scene.parts import SceneParts
from transport.scene.phase_space import PhaseSpace, Snapshot
from transport.scene.scene_speeds import missing_mass_message, scene_mass
from transport.statistics.axes import COORDINATES, PHASE
from transport.statistics.chunked import release_pages
from transport.statistics.estimates import EstimateArray, EstimateOrArray
from transport.units import BOLTZMANN

ROUNDING = 8 * 2.0**-52  # relative rounding error of a difference of sums
MOMENTS, BINS = ("moments",), (PHASE,)


def _mean_velocity(axis: str) -> Formula:
    """Mean of a component of the velocity; its moments are taken about a reference velocity."""
    mean = MeanPerWeight("", f"v{axis}", "weight", BINS)
    return Formula(
        f"Mean {axis} component of the velocity [m s^-1].",
        lambda tally: mean.of(tally) + tally.constant(f"reference v{axis}"),
        MOMENTS,
    )


def _variance(axis: str) -> Formula:
    """Variance of a component of the velocity."""
    means = [MeanPerWeight("", name, "weight", BINS) for name in (f"v{axis}", f"v{axis}2")]

    def variance(tally: Tally) -> EstimateArray:
        mean, square = (each.of(tally) for each in means)
        variance = square - mean * mean
        with np.errstate(invalid="ignore"):  # a difference from rounding of the squares is no variance
            return variance.unless(ROUNDING * np.abs(square.value) > variance.error)

    return Formula(
        f"Variance of the velocity's {axis} component within each bin [m^2 s^-2].", variance, MOMENTS
    )


class PhaseReading(Tally):
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

    kind = "phase space"

    number = Quantity("Number of particles [1], or their energy [J], in each bin.", "weight", BINS)
    density = Quantity(
        "Particles (or J) per product of the bin widths; with `within` also per extent on other axes.",
        "weight",
        BINS,
        ("extent",),
    )
    alive = Quantity("All particles (or J) that were born and had not ended: in the bins and outside.", "all")
    outside = Quantity("Particles (or J) outside all bins or outside `within`.", "outside")
    mean_vx, mean_vy, mean_vz = map(_mean_velocity, "xyz")
    variance_vx, variance_vy, variance_vz = map(_variance, "xyz")
    mean_speed = MeanPerWeight("Mean speed [m s^-1].", "speed", "weight", BINS, MOMENTS)
    fluence_rate = Quantity(
        "n v: density times mean speed; φ = ∫ L dω [m^-2 s^-1] if `within` makes it a density in space.",
        "speed",
        BINS,
        ("extent",),
        MOMENTS,
    )
    temperature = Formula(
        "Kinetic temperature [K]: mass times the velocity's variance over 3 k.",
        lambda tally: tally._all_variances * tally.constant("kelvin"),
        ("mass", "moments"),
    )
    pressure = Formula(
        "n k T: mass times density times the velocity's variance over 3 [Pa if `within` is given].",
        lambda tally: tally.density * tally._all_variances * tally.constant("third of mass"),
        ("mass", "moments"),
    )

    def __init__(self, result, phase_space: PhaseSpace) -> None:
        super().__init__(result, phase_space)
        self.phase_space = phase_space
        self.axes = self.plan.rows_of[self.name].axes

    @cached_property
    def scores(self) -> Mapping[str, Score]:
        """Weights at each time, and their velocity moments."""
        plan, energy = self.plan, energy_unit(self.plan)
        rows, unit = plan.rows_of[self.name], plan.unit
        weights, counts = plain_column("weights"), plain_column("counts")
        weight = Score(rows, weights, counts, energy, unit)
        found = {
            "weight": weight,
            # Scaled before it is summed: an empty phase space has exactly the sum of its bins.
            "all": replace(
                weight,
                column=lambda batch, a, b: weights(batch, a, b) * unit,
                scale=1.0,
                is_sure=partial(_are_all_alive_always, plan),
            ),
            "outside": replace(weight, rows=replace(rows, inner=(), span=1)),
        }
        if self.detector.moments:
            first, each = plan.first_long_rows[self.name], len(VELOCITY_SUMS)
            for place, name in enumerate(VELOCITY_SUMS):
                power = 2 if name.endswith("2") else 1
                found[name] = replace(
                    weight,
                    column=moment_column(place, each, rows.first, first),
                    unit=f"{energy} m^{power} s^-{power}",
                    scale=unit * max_relative_speed(plan) ** power,
                )
        return found

    @cached_property
    def measures(self) -> Mapping[str, Callable[[], Measure]]:
        """Extent of the bins, the reference velocity, and constants of the mass."""
        reference, mass = reference_velocity(self.plan), scene_mass(self.scene)
        return {
            "extent": partial(_extent, self.detector),
            **{
                f"reference v{axis}": partial(Measure, v, "m s^-1")
                for axis, v in zip("xyz", reference, strict=True)
            },
            "kelvin": lambda: Measure(mass / (3 * BOLTZMANN), "K m^-2 s^2"),
            "third of mass": lambda: Measure(mass / 3, "Pa m s^2"),
        }

    @staticmethod
    def lacks_of(scene: SceneParts, detector: PhaseSpace) -> Lacks:
        """Return what the scene or the phase space was not set up for; known before a run."""
        has_mass = scene.measured_in != "watts" and scene_mass(scene) is not None
        lacks = {
            "moments": not detector.moments and ("moments", "write PhaseSpace(..., moments=True)"),
            "mass": not has_mass and missing_mass_message(scene),
        }
        return {need: why for need, why in lacks.items() if why}

    def binned(self) -> Iterator[tuple[str, EstimateOrArray]]:
        """Yield the number of particles in each bin."""
        yield "number", self.number

    @cached_property
    def _all_variances(self) -> EstimateArray:
        return self.variance_vx + self.variance_vy + self.variance_vz

    def __repr__(self) -> str:
        return f"<{self.name}: number {self.number!r}, outside {self.outside!r}>"


def _extent(phase_space: PhaseSpace) -> Measure:
    """Product of the bin widths inside `within`, times its extent on the other axes of space."""
    box, widths = phase_space.within, []
    for name, edges in phase_space.axes.items():
        if box is not None and name in ("x", "y", "z"):
            low, high = (corner["xyz".index(name)] for corner in box.bounds)
            edges = edges.clip(low, high)
        widths.append(np.diff(edges))
    lengths = () if box is None else zip("xyz", box.size, strict=True)
    others = [length for name, length in lengths if name not in phase_space.axes]
    extent = widths[0] if len(widths) == 1 else np.multiply.outer(*widths)
    unit = " ".join([*(COORDINATES[name].unit for name in phase_space.axes), *["m"] * len(others)])
    return Measure(np.where(extent > 0, extent, np.nan) * np.prod(others), unit, tuple(phase_space.axes))


def _are_all_alive_always(plan) -> bool:
    """Return whether by construction every history exists at all times: born at 0 and never ended."""
    moments = [emitter.moment for emitter in plan.emitters]
    born_at_once = all(name == "set_birth_time" and row["start"] == 0 for name, row in moments)
    stays = not plan.has_acting_surfaces and not plan.absorbing_media
    return born_at_once and stays and not any(emitter.weighs_births for emitter in plan.emitters)


class SnapshotReading(Tally):
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

    kind = "snapshot"

    def __init__(self, result, snapshot: Snapshot, number: int) -> None:
        self.snapshot = self.detector = snapshot
        self.name = snapshot.name
        plan, batches = result.plan, result.batches
        self.scene = plan.scene
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

    @property
    def heading(self) -> str:
        """Title in a report."""
        return f"{self.title}, {len(self)} particles at {self.time:g} s"

    def __len__(self) -> int:
        return len(self.weights)

    def __repr__(self) -> str:
        return f"<{self.name}: {len(self)} particles at {self.time:g} s>"
