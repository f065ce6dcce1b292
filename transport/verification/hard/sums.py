"""Sums: long, of unequal terms, tiny or huge; errors beside large means; merges in any order."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache, reduce

import numpy as np

import transport as tp
from transport.results.batches import Batch
from transport.results.result import Result
from transport.statistics.batches import merge, standard_error
from transport.theory import emitters
from transport.verification.hard.cases import CaseResult, case


def _run(tau: float, depths: tuple[float, ...], particles: int, **options) -> tp.Result:
    """One watt straight down into an absorber of mean free path 1 m; detectors are named by depth."""
    ink = tp.Medium(absorption=1.0)
    slab = tp.Surface(tp.Slab(center=(0, 0, -tau / 2), thickness=tau), tp.Transparent(), inside=ink)
    lamp = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
    detectors = [tp.Detector(tp.Plane(center=(0, 0, -depth)), f"{depth:g}") for depth in depths]
    return tp.simulate(tp.Scene(lamp, slab, detectors), particles, seed=1, progress=False, **options)


@lru_cache(maxsize=1)
def _long_run() -> Result:
    """A run whose 16 batches are each merged with themselves 23 times: 1.3e12 histories, all scoring."""
    short = _run(1.0, (1.0,), 160_000, batches=16)

    def doubled(batch: Batch) -> Batch:
        """The batch merged with itself 23 times."""
        return reduce(lambda whole, _: whole.merged(whole, 0), range(23), batch)

    return Result(short.plan, [doubled(batch) for batch in short.batches], 1, None, True, [])


@lru_cache(maxsize=1)
def _thousand_batches() -> list[Batch]:
    """The batches of a run with 1000 batches, whose scores span a factor of ten."""
    room = tp.Surface(tp.Sphere(radius=1.0), tp.Black(), "room", inside=tp.Medium(absorption=1.0))
    lamp = tp.Source(tp.Point(position=(0, 0, 0.8)), tp.Isotropic(power=1.0))
    scene = tp.Scene(lamp, room, tp.Detector("room", side="inside"))
    return tp.simulate(scene, 16_000, seed=1, batches=1000, progress=False).batches


# ---- many terms ----


@case("the mean of 1.3e12 scores", naive="a float32, which stops growing at 2^24 scores")
def very_many_scores() -> CaseResult:
    """Integers add up without rounding within a batch, and batches in float64."""
    found = _long_run()["1"].flux_in.value
    return CaseResult(found, math.exp(-1), naive=math.exp(-1) * 2**24 / _long_run().particles)


@case("their number", naive="an int32 that overflows at 2^31")
def counts_beyond_int32() -> CaseResult:
    """Counts are int64 throughout."""
    found, exact = _long_run()["1"].counts.value, 160_000 << 23
    return CaseResult(float(found), exact, naive=float(np.int64(exact).astype(np.int32)), within=0.0)


@case("the number of one batch's scores, above 2^32", naive="a uint32 that overflows")
def counts_beyond_uint32() -> CaseResult:
    """A run towards a target error merges batches until each holds billions of scores."""
    found, exact = _long_run().batches[0].counts.max(), 10_000 << 23
    return CaseResult(float(found), exact, naive=float(np.int64(exact).astype(np.uint32)), within=0.0)


# ---- terms of different sizes ----


@case(
    "meters 10, 20, 30 and 40 mean free paths deep, each over its exact flux",
    naive="weights below 1e-12 are dropped",
)
def seventeen_decades() -> CaseResult:
    """Weights from 1 to 4e-18 in the same sums: the mean of the faintest, below half a unit of the
    sums, is right.
    """
    depths = (10.0, 20.0, 30.0, 40.0)
    result = _run(41.0, depths, 50_000)
    found = sum(result[f"{depth:g}"].flux_in * math.exp(depth) for depth in depths)
    return CaseResult(found, 4.0, naive=sum(math.exp(-depth) > 1e-12 for depth in depths))


@case("what is left after 45 mean free paths", naive="truncation at the sums' unit of 2^-63")
def below_the_last_digit() -> CaseResult:
    """Each score is a quarter of the unit: rounded up one time in four its mean is right; truncated it
    is 0 without an error.
    """
    found = _run(45.0, (45.0,), 100_000)["45"].flux_in
    return CaseResult(found, math.exp(-45), naive=math.floor(math.exp(-45) * 2.0**63) / 2.0**63)


@case("whether an error is known of thirty decades less", naive="no score: 0 with an error of 0")
def thirty_decades() -> CaseResult:
    """69 mean free paths leave 1e-30. Without a score the error is unknown; 0 ± 0 would be wrong."""
    flux = _run(69.0, (69.0,), 10_000)["69"].flux_in
    return CaseResult(float(math.isnan(flux.error)), 1.0, naive=0.0)


@case("the error of batches from 1e-200 to 1e200", naive="sqrt(Σ(x - m)²/n), whose squares overflow")
def decades_between_batches() -> CaseResult:
    """Deviations are divided by the largest before they are squared."""
    values = 10.0 ** np.linspace(-200, 200, 33)
    with np.errstate(over="ignore"):
        naive = math.sqrt(((values - values.mean()) ** 2).mean() / 32)
    return CaseResult(float(standard_error(values, np.full(33, 7))), _exact_error(values), naive)


# ---- beside a large mean ----


@case("the error of batches of mean 1e9 and variance 1", naive="sqrt(Σx²/n - (Σx/n)²)")
def billion_and_one() -> CaseResult:
    """The variance is in the nineteenth digit of the sum of squares."""
    values = 1e9 + np.random.default_rng(1).integers(-8, 9, 64) / 4
    naive = math.sqrt(abs((values**2).mean() - values.mean() ** 2) / 63)
    return CaseResult(float(standard_error(values, np.full(64, 7))), _exact_error(values), naive, within=1e-7)


@case(
    "the difference of two fluxes of a gigawatt, 4 % apart",
    naive="the second flux from a run with another seed",
)
def small_difference() -> CaseResult:
    """Detectors of one run score the same histories: the noise of each is as large as the difference,
    but cancels in it.
    """
    heights, lamp = {"near": 5.0, "far": 5.1}, tp.Source(tp.Disk(radius=1.0), tp.Lambertian(power=1e11))
    detectors = [
        tp.Detector(tp.Disk(center=(0, 0, z), normal=(0, 0, -1), radius=0.5), name)
        for name, z in heights.items()
    ]
    scene = tp.Scene(lamp, detectors=detectors)
    one, other = (tp.simulate(scene, 100_000, seed=seed, progress=False) for seed in (1, 2))
    flux = [0.25 * emitters.mean_disk_irradiance(1e11 / math.pi, 1.0, 0.5, z) for z in heights.values()]
    found = one["near"].flux_in - one["far"].flux_in
    naive = one["near"].flux_in.value - other["far"].flux_in.value
    return CaseResult(found, flux[0] - flux[1], naive)


@case("the spread of a thousand parts of mean 1e9, merged in any order", naive="sums of x and x² are merged")
def thousand_merged() -> CaseResult:
    """Counts, means and sums of squared deviations are merged (Chan): nothing cancels in any order."""
    rng = np.random.default_rng(1)
    values = 1e9 + rng.integers(-8, 9, (1000, 4)) / 8
    parts = [(4, x.mean(), ((x - x.mean()) ** 2).sum()) for x in values]
    merged = [reduce(merge, [parts[k] for k in rng.permutation(1000)])[2] for _ in range(5)]
    exact = float(_exact_squares(values.ravel()))
    worst = max(merged, key=lambda squares: abs(squares - exact))
    return CaseResult(float(worst), exact, naive=(values**2).sum() - values.sum() ** 2 / 4000, within=1e-6)


@case("a thousand batches merged forwards, backwards and shuffled: how far apart", naive="in float32")
def batches_in_any_order() -> CaseResult:
    """In any order of merging the sums agree to the sixteenth digit."""
    batches = _thousand_batches()
    weights = np.array([batch.weights.max() for batch in batches])
    shuffled = np.random.default_rng(1).permutation(1000)
    orders = (range(1000), range(999, -1, -1), shuffled)
    whole = [
        reduce(lambda a, b: a.merged(b, 0), [batches[k] for k in order]).weights.max() for order in orders
    ]
    single = [np.cumsum(weights[list(order)], dtype=np.float32)[-1] for order in orders]
    return CaseResult(
        float(np.ptp(whole) / whole[0]), 0.0, naive=float(np.ptp(single) / single[0]), within=1e-14
    )


# ---- bins ----


@case(
    "what is in 10 000 bins of direction, most of them with one score or none",
    naive="bins with a single score are omitted as noise",
)
def one_score_a_bin() -> CaseResult:
    """A bin with one score has an error as large as its value, but the score counts."""
    dome = tp.Detector(
        tp.Sphere(radius=1.0), "dome", side="inside", directions=tp.Directions(mu=100, phi=100)
    )
    lamp = tp.Source(tp.Sphere(radius=0.9), tp.Lambertian(power=1.0))
    counts = tp.simulate(tp.Scene(lamp, detectors=dome), 3000, seed=1, progress=False)["dome"].counts.value
    return CaseResult(float(counts.sum()), 3000, naive=float(counts[counts > 1].sum()), within=0.0)


@case(
    "a beam straight down onto bins of cosine: what is in the last",
    naive="floor(100 μ) is 100, and the last bin is 99",
)
def all_in_one_bin() -> CaseResult:
    """μ = 1 is the upper edge of the last bin and belongs to it."""
    meter = tp.Detector(tp.Disk(radius=1.0), "meter", directions=tp.Directions(mu=100))
    sun = tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.5), tp.Beam((0, 0, -1), power=1.0))
    counts = tp.simulate(tp.Scene(sun, detectors=meter), 3000, seed=1, progress=False)["meter"].counts.value
    naive = np.bincount(np.floor(100 * np.ones(3000)).astype(int))[99]
    return CaseResult(float(counts[99]), 3000, naive=float(naive), within=0.0)


def _exact_squares(values: np.ndarray) -> Fraction:
    """Sum of squared deviations from the mean, in exact fractions."""
    exact = [Fraction(float(x)) for x in values]
    mean = sum(exact) / len(exact)
    return sum((x - mean) ** 2 for x in exact)


def _exact_error(values: np.ndarray) -> float:
    """Standard error of the mean, in exact fractions up to the square root."""
    return _root(_exact_squares(values) / (len(values) * (len(values) - 1)))


def _root(square: Fraction) -> float:
    """Square root of a fraction that may exceed the range of a float."""
    digits = 10**20 if square < 1 else 1
    return math.isqrt(square.numerator * digits**2 // square.denominator) / digits
