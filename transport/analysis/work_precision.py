"""Work-precision points, fits and prices of each method from its runs: true errors beside claimed errors."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from transport.statistics.convergence import PowerLaw, TimeModel, fit_power_law, fit_time

if TYPE_CHECKING:
    from transport.statistics.estimates import Estimate, EstimateArray


# ---- Runs of growing size by one method: value, claimed error and duration of each.
#
# Sizes grow by factors of four, so that runs are spread evenly over the logarithm of time. Small runs are
# repeated more often than large ones, so that their root mean square errors are well known at little cost.

MIN_HISTORIES, GROWTH_FACTOR, MAX_HISTORIES = (
    1 << 12,
    4,
    1 << 34,
)  # histories of the first runs, growth factor, most histories
MIN_REPEATS, MAX_REPEATS = 8, 32  # number of runs of the largest size, and most of the small ones
SEEDS_PER_METHOD = 1 << 20  # number of seeds reserved for one method


@dataclass(frozen=True)
class Trial:
    """One run.

    value, error: of all bins, (n,) [unit];  seconds: CPU time of all threads [s];  wall: elapsed time [s].
    """

    particles: int
    value: np.ndarray
    error: np.ndarray
    seconds: float
    wall: float


@dataclass(frozen=True)
class Trials:
    """All runs of one method, by rising size. preparation: time [s] to compile or load its kernels."""

    levels: tuple[tuple[Trial, ...], ...]
    preparation: float

    @property
    def all(self) -> list[Trial]:
        """All runs."""
        return [trial for rung in self.levels for trial in rung]


Run = Callable[[int, int], tuple[int, "Estimate | EstimateArray", float]]


def run_trials(
    run: Run,
    seconds: float,
    seed: int = 0,
    cpu: Callable = time.process_time,
    clock: Callable = time.perf_counter,
) -> Trials:
    """Run trials that take about `seconds` of CPU time in total, without preparation and a first run.

    run: (particles, seed) -> (particles done, estimate, seconds of preparation).
    """
    keys = iter(range(seed, seed + SEEDS_PER_METHOD))

    def trial(particles: int) -> Trial:
        begun, shown = cpu(), clock()
        done, estimate, _ = run(particles, next(keys))
        spent, passed = cpu() - begun, clock() - shown
        value, error = (np.ravel(np.asarray(part, float)) for part in (estimate.value, estimate.error))
        return Trial(done, value, error, spent, passed)

    # Compile with a first run that is not timed.
    preparation = run(MIN_HISTORIES, next(keys))[2]
    # Grow the runs as long as the time allows, then repeat the small ones more often.
    rungs = [[trial(MIN_HISTORIES)]]
    while _has_time_for_more(rungs, seconds):
        rungs.append([trial(GROWTH_FACTOR * rungs[-1][0].particles)])
    for place, rung in enumerate(reversed(rungs)):
        rung += [trial(rung[0].particles) for _ in range(_repeats(place) - 1)]
    return Trials(tuple(map(tuple, rungs)), preparation)


def _has_time_for_more(rungs: Sequence[Sequence[Trial]], seconds: float) -> bool:
    """Return whether runs of the next size and all repeats fit into the time.

    A run's time is foretold from the last two sizes: learning a guide takes as long for a small run.
    """
    spent = [rung[0].seconds for rung in rungs]
    before = spent[-2] if len(spent) > 1 else spent[-1] / GROWTH_FACTOR
    foretold = spent[-1] + GROWTH_FACTOR * max(spent[-1] - before, 0.0)
    total = sum(_repeats(place) * each for place, each in enumerate((foretold, *reversed(spent))))
    return total <= seconds and rungs[-1][0].particles < MAX_HISTORIES


def _repeats(place: int) -> int:
    """Number of runs of a size, by its place from the largest one down."""
    return min(MAX_REPEATS, MIN_REPEATS << place)


# ---- Points, fits and prices from these runs.

MAX_FITTED_ERROR = 0.5  # largest relative error of points used in a fit


@dataclass(frozen=True)
class Truth:
    """Value (n,) [unit] from which deviations are measured.

    variance: of the best estimate, summed over bins, 0 if exact;  shares: weight of each method in the best
    estimate.
    """

    value: np.ndarray
    variance: float
    shares: Mapping[str, float]

    @property
    def size(self) -> float:
        """Norm of the value [unit]."""
        return float(np.linalg.norm(self.value))

    @property
    def words(self) -> str:
        """Description: "exact", or the relative error of the best estimate."""
        if not self.shares:
            return "exact"
        return (
            f"best estimate, ± {math.sqrt(self.variance) / self.size:.1e} of it" if self.size else "nothing"
        )


@dataclass(frozen=True)
class Point:
    """Runs of one size.

    Parameters
    ----------
    particles : int
        Particles per run.
    runs : int
        Number of runs.
    seconds : float
        Median CPU time of all threads [s].
    wall : float
        Median elapsed time [s].
    true : float
        Root mean square deviation from the truth, relative to its size.
    true_error : float
        Standard error of `true`.
    claimed : float
        Root mean square of the errors that the runs reported; nan if most reported none.
    """

    particles: int
    runs: int
    seconds: float
    wall: float
    true: float
    true_error: float
    claimed: float


@dataclass(frozen=True)
class Price:
    """Price of a relative error.

    Parameters
    ----------
    seconds : float
        CPU time [s].
    is_extrapolated : bool
        Whether the error lies below all measured errors.
    """

    seconds: float
    is_extrapolated: bool


@dataclass(frozen=True)
class MethodCost:
    """Measured cost of one method.

    Parameters
    ----------
    name : str
        Name of the method, such as "analog, sobol".
    points : tuple of Point
        Runs of each size.
    line : Line or None
        Fit of the true errors; None if they are unknown.
    claimed_line : Line or None
        Fit of the claimed errors.
    pace : Pace
        Duration of runs.
    preparation : float
        Time to compile or load the kernels [s].
    z : float
        Deviation of the mean of all runs from the truth, in standard errors; nan if unknown.
    estimator : str, optional
        Estimator of the runs; None if the name implies it.
    """

    name: str
    points: tuple[Point, ...]
    line: PowerLaw | None
    claimed_line: PowerLaw | None
    pace: TimeModel
    preparation: float
    z: float
    estimator: str | None = None

    @property
    def known_points(self) -> tuple[Point, ...]:
        """Points with known errors: a fit needs two."""
        return _fitted_points(self.points)

    def price(self, error: float) -> Price:
        """Return the price of a relative error by the fit.

        Parameters
        ----------
        error : float
            Relative error.

        Returns
        -------
        Price
            CPU seconds, infinite if there is no fit, and whether they are extrapolated.
        """
        if self.line is None:
            return Price(math.inf, True)
        measured = [point.true for point in self.points if point.true > 0]
        return Price(self.pace.latency + self.line.seconds_to(error), error < min(measured, default=math.inf))


def best_estimate(found: Mapping[str, Trials], exact: np.ndarray | None = None) -> Truth:
    """The exact value, or without one the mean of all runs, weighted by the variance of each method."""
    if exact is not None:
        return Truth(exact, 0.0, {})
    means = {name: _mean_and_variance(trials) for name, trials in found.items()}
    known = {name: mean for name, mean in means.items() if 0 < mean[1] < math.inf} or means
    variances = {name: variance for name, (_, variance) in known.items()}
    weights = {name: 1 / each if 0 < each < math.inf else 1.0 for name, each in variances.items()}
    total = math.fsum(weights.values())
    shares = {name: weight / total for name, weight in weights.items()}
    value = sum(share * known[name][0] for name, share in shares.items())
    return Truth(value, math.fsum(share**2 * known[name][1] for name, share in shares.items()), shares)


def cost_of_method(name: str, trials: Trials, truth: Truth, estimator: str | None = None) -> MethodCost:
    """Points, fits and z of a method."""
    particles = sum(trial.particles for trial in trials.all)
    share = truth.shares.get(name, 0.0) / particles
    points = tuple(_point(rung, truth, share * rung[0].particles) for rung in trials.levels)
    pace = fit_time([p.particles for p in points], [p.seconds for p in points])
    fitted = _fitted_points(points)
    seconds = [pace.per_particle * p.particles for p in fitted]
    runs = [p.runs for p in fitted]
    line = fit_power_law(seconds, [p.true for p in fitted], runs)
    claimed = fit_power_law(seconds, [p.claimed for p in fitted], runs)
    z = _z(trials, truth, name)
    return MethodCost(name, points, line, claimed, pace, trials.preparation, z, estimator)


def _fitted_points(points: tuple[Point, ...]) -> tuple[Point, ...]:
    """Points with a known error small enough to fit."""
    return tuple(p for p in points if 0 < p.true < MAX_FITTED_ERROR and p.claimed < MAX_FITTED_ERROR)


def _point(rung: tuple[Trial, ...], truth: Truth, share: float) -> Point:
    """One point. share: weight of one run in the best estimate, which it biases towards itself."""
    # Correct the deviations for the variance of the best estimate and for each run's share in it.
    squares = np.array([_square(trial.value - truth.value, truth) for trial in rung])
    mean = (
        (float(squares.mean()) - truth.variance / truth.size**2) / (1 - 2 * share) if truth.size else math.nan
    )
    true = math.sqrt(mean) if mean > 0 else math.nan if truth.variance else 0.0
    claims = [_square(trial.error, truth) for trial in rung if np.isfinite(trial.error).any()]
    return Point(
        particles=rung[0].particles,
        runs=len(rung),
        seconds=float(np.median([trial.seconds for trial in rung])),
        wall=float(np.median([trial.wall for trial in rung])),
        true=true,
        true_error=true / math.sqrt(2 * len(rung)),
        claimed=math.sqrt(np.mean(claims)) if 2 * len(claims) > len(rung) else math.nan,
    )


def _square(part: np.ndarray, truth: Truth) -> float:
    """Square of a deviation or error relative to that of the truth; 1 if no element is defined."""
    part = np.where(np.isfinite(part), part, 0.0 if np.isfinite(part).any() else truth.value)
    return float(np.sum(part**2)) / truth.size**2 if truth.size else math.nan


def _mean_and_variance(trials: Trials) -> tuple[np.ndarray, float]:
    """Mean over all histories of a method, and its variance, summed over bins; infinite if unknown."""
    runs = trials.all
    weights = np.array([trial.particles for trial in runs], dtype=float)
    weights /= weights.sum()
    value = sum(w * np.nan_to_num(trial.value) for w, trial in zip(weights, runs, strict=True))
    known = [(w, trial) for w, trial in zip(weights, runs, strict=True) if np.isfinite(trial.error).any()]
    total_weight = math.fsum(w for w, _ in known)
    if total_weight < 0.5:
        return value, math.inf
    return value, math.fsum(w**2 * float(np.nansum(trial.error**2)) for w, trial in known) / total_weight


def _z(trials: Trials, truth: Truth, name: str) -> float:
    """z of the mean of all runs; nan for arrays, or if the truth is that mean itself."""
    value, variance = _mean_and_variance(trials)
    if value.size > 1 or truth.shares.get(name, 0.0) > 0.999:
        return math.nan
    spread = variance + (-truth.variance if name in truth.shares else truth.variance)
    return float((value - truth.value)[0]) / math.sqrt(spread) if 0 < spread < math.inf else math.nan
