"""Error of binned quantities: few bins blur, many are noisy, so each particle number has a best one.

A quantity is taken as constant over a bin. With K bins the mean square of its deviation is

    mean square of (mean over the bin − local value)  +  mean variance of a bin's mean.

The first term (blur) falls with K and does not depend on the particle number; the second (noise) rises with K
and falls as 1/N. Both are estimated from one run with fine bins, which are merged into coarser ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from transport.statistics.batches import standard_error
from transport.statistics.estimates import EstimateArray
from transport.validation import SceneError, checked_keywords, name_hint

SLOPE_POWER, STEP_POWER = 2.0, 1.0  # blur² falls as (number of bins)^-power, for a slope and a step
MIN_SIGNIFICANCE = 10.0  # blur² must exceed its own noise by this factor before a ratio of two is used


@dataclass(frozen=True)
class BinsAgainstNoise:
    """Relative errors of a quantity taken as constant over each of `bins` bins along `dim`.

    Parameters
    ----------
    dim : str
        Axis.
    particles : int
        Particles of the run.
    bins : tuple of ints
        Numbers of bins.
    noise : tuple of floats
        Claimed error of the run, relative to the quantity's root mean square.
    blur : tuple of floats
        Error by averaging over bins, relative to the same; 0 where it is lost in noise.

    Examples
    --------
    >>> from transport.analysis.binning import BinsAgainstNoise
    >>> found = BinsAgainstNoise("x", 1000, (1, 2, 4), noise=(0.01, 0.02, 0.04), blur=(0.3, 0.1, 0.03))
    >>> found.best(), found.best(times=0.01)
    (4, 2)
    """

    dim: str
    particles: int
    bins: tuple[int, ...]
    noise: tuple[float, ...]
    blur: tuple[float, ...]

    def total(self, times: float = 1.0) -> tuple[float, ...]:
        """Return the total error, noise and blur, for each number of bins.

        Parameters
        ----------
        times : float, default 1
            Number of particles relative to the run.

        Returns
        -------
        tuple of floats
            Relative errors, in the order of `bins`.
        """
        return tuple(math.hypot(n / math.sqrt(times), b) for n, b in zip(self.noise, self.blur, strict=True))

    def best(self, times: float = 1.0) -> int:
        """Return the number of bins with the smallest total error.

        Parameters
        ----------
        times : float, default 1
            Number of particles relative to the run.

        Returns
        -------
        int
            One of `bins`.
        """
        total = self.total(times)
        return self.bins[total.index(min(total))]


@checked_keywords
def bins_against_noise(array: EstimateArray, dim: str) -> BinsAgainstNoise:
    """Estimate the blur and noise of fewer bins along an axis from the fine bins of one run.

    Parameters
    ----------
    array : EstimateArray
        Quantity of one run, with a number of bins along `dim` that has divisors, such as a power of two.
        Squares are averaged over its other axes.
    dim : str
        Axis.

    Returns
    -------
    BinsAgainstNoise
        Noise and blur by number of bins, with `total(times)` and `best(times)`.

    Raises
    ------
    SceneError
        If the array has no such axis, or its bins cannot be merged.

    Notes
    -----
    Means over bins are weighted by bin widths. Noise in the measured blur is subtracted, and the blur within
    the finest bins is extrapolated by a power law in the number of bins.

    Examples
    --------
    >>> import transport as tp
    >>> radiance = result["meter"].radiance  # doctest: +SKIP
    >>> best = tp.bins_against_noise(radiance, "mu").best()  # doctest: +SKIP
    """
    if not isinstance(array, EstimateArray) or dim not in array.dims:
        dims = array.dims if isinstance(array, EstimateArray) else ()
        raise SceneError(f"bins_against_noise: no axis {dim!r}; {name_hint(str(dim), dims)}")
    # Move the axis to the end, and find the numbers of bins into which it can be merged.
    edges = array.coords[dim]
    values = np.moveaxis(array.values, 1 + array.dims.index(dim), -1)
    if len(edges) != values.shape[-1] + 1 or len(_divisors(values.shape[-1])) < 3:
        must = f"{dim!r} must have a number of bins with edges that can be divided"
        raise SceneError(f"bins_against_noise: {must}, got {values.shape[-1]}; write a power of two")
    values = np.nan_to_num(values)
    # Normalize by the mean square of the quantity, less its noise.
    sizes, widths = array.run.sizes, np.diff(edges)
    size2 = _weighted_mean(np.average(values, axis=0, weights=sizes) ** 2, widths)
    size2 -= _weighted_mean(standard_error(values, sizes) ** 2, widths)
    # Measure noise and blur for each number of bins.
    numbers = _divisors(len(widths))
    rows = [_errors(values, sizes, widths, number) for number in numbers]
    _, apart2, subtracted = np.array(rows).T
    blur2 = _add_unresolved_blur(np.array(numbers), apart2, subtracted)
    scale = math.sqrt(size2) if size2 > 0 else math.nan
    noise = tuple(math.sqrt(row[0]) / scale for row in rows)
    blur = tuple(math.sqrt(max(0.0, square)) / scale for square in blur2.tolist())
    return BinsAgainstNoise(dim, int(sizes.sum()), numbers, noise, blur)


def _divisors(bins: int) -> tuple[int, ...]:
    """Numbers of equal groups into which the bins can be merged, from 1 to all."""
    return tuple(number for number in range(1, bins + 1) if bins % number == 0)


def _errors(
    values: np.ndarray, sizes: np.ndarray, widths: np.ndarray, bins: int
) -> tuple[float, float, float]:
    """(noise², blur² relative to the finest bins, noise² subtracted from it) for a number of bins."""
    grouped = widths.reshape(bins, -1)
    shape = (*values.shape[:-1], *grouped.shape)
    means = np.sum(values.reshape(shape) * grouped, axis=-1) / grouped.sum(axis=1)
    coarse = np.repeat(means, grouped.shape[1], axis=-1)
    apart = coarse - values
    noise2 = _weighted_mean(standard_error(coarse, sizes) ** 2, widths)
    apart2 = _weighted_mean(standard_error(apart, sizes) ** 2, widths)
    return noise2, _weighted_mean(np.average(apart, axis=0, weights=sizes) ** 2, widths) - apart2, apart2


def _weighted_mean(squares: np.ndarray, widths: np.ndarray) -> float:
    """Mean over the axis, weighted by bin widths, and over all other axes."""
    return float(np.average(squares, axis=-1, weights=widths).mean())


def _add_unresolved_blur(numbers: np.ndarray, blur2: np.ndarray, subtracted: np.ndarray) -> np.ndarray:
    """Add the blur within the finest bins, by a power law in the number of bins.

    blur² falls with the square of the number for a slope, and in proportion to it for a step. The exponent
    between these comes from the two finest known blurs, or is that of a slope if noise hides them.
    """
    ratios = numbers[-1] / numbers[:-1]

    def seen(power: float) -> np.ndarray:
        return ratios**power - 1  # blur² relative to the finest bins, in units of blur² within them

    power = SLOPE_POWER
    if len(ratios) > 1 and blur2[-2] > MIN_SIGNIFICANCE * subtracted[-2] / math.sqrt(numbers[-2]):
        powers = np.linspace(STEP_POWER, SLOPE_POWER, 21)
        expected = np.array([seen(p)[-2] / seen(p)[-1] for p in powers])
        power = float(powers[np.argmin(np.abs(expected - blur2[-3] / blur2[-2]))])
    return blur2 + max(0.0, blur2[-2]) / seen(power)[-1]
