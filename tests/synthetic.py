"""Synthetic estimates with known truth, for the tests of statistics and of the judge."""

import math

import numpy as np

from transport.statistics.batches import standard_error, weighted_mean
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.replicates import Batches

RUN = Batches(np.r_[np.full(10, 4), np.full(22, 3)])
OTHER_RUN = Batches(np.full(16, 100))
EVEN_RUN = Batches(np.full(32, 1000))
EDGES = {"mu": np.linspace(0, 1, 5), "phi": np.linspace(0, 2 * np.pi, 4)}


def noisy(mean, spread, seed, run=RUN, unit="W"):
    """An estimate of a mean from histories of this spread."""
    values = mean + spread * np.random.default_rng(seed).normal(size=len(run)) / np.sqrt(run.sizes)
    return Estimate(values, run, unit)


def grid(seed, mean=5.0, run=RUN, unit="W m^-2 sr^-1", **options):
    """An array of estimates over 4 polar and 3 azimuthal bins."""
    values = np.random.default_rng(seed).normal(mean, 1, size=(len(run), 4, 3))
    return EstimateArray(values, run, unit, ("mu", "phi"), EDGES, **options)


def estimates(values, dims, edges, unit="W m^-2 sr^-1", relative=0.1, counts=None):
    """An array of these values with these relative standard errors; nothing was counted where it is 0."""
    values = np.asarray(values, dtype=float)
    signs = math.sqrt(31) * np.tile([-1.0, 1.0], 16).reshape(-1, *(1,) * values.ndim)
    coords = dict(zip(dims, map(np.asarray, edges), strict=True))
    counts = values != 0 if counts is None else counts
    return EstimateArray(values * (1 + relative * signs), EVEN_RUN, unit, dims, coords, counts=counts)


def with_error(value, error, batches=2):
    """An estimate of an even number of batches with this very value and error."""
    signs = np.tile([-1.0, 1.0], batches // 2)
    return Estimate(value + error * math.sqrt(batches - 1) * signs, Batches(np.full(batches, 5)), "W")


def t_scores(seed, batches=32, factor=1.0, offset=0.0, seeds=2000):
    """t-scores of means of normal batches, with error bars divided by a factor and means off by errors."""
    values = np.random.default_rng(seed).normal(size=(batches, seeds))
    sizes = np.full(batches, 3)
    error = standard_error(values, sizes)
    return factor * (weighted_mean(values, sizes) / error + offset)
