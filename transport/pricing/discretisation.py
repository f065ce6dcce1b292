"""What bins cost: few are blurred, many are noisy, and for a number of particles one number of bins is the best.

A quantity is taken as constant over a bin.  With K bins the mean square of its deviation is

    mean square of (mean over the bin − the value at a place)  +  mean variance of a bin's mean,

the first of which falls with K and knows nothing of particles, while the second rises with K and falls as 1/N.  Both
are told from one run with fine bins, of which coarser ones are made.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from transport.results.estimates import EstimateArray
from transport.results.statistics import standard_error
from transport.validation import SceneError, suggestion

SLOPE, STEP = 2.0, 1.0  # powers of the number of bins with which blur² falls
SURE = 10.0  # standard deviations of its own noise, below which a ratio of two blurs says nothing


@dataclass(frozen=True)
class BinsAgainstNoise:
    """Errors of a quantity taken as constant over each of `bins` bins along `dim`, over its root mean square.

    noise: claimed, of the run that was looked at;  blur: what the bins take away, 0 where it is lost in noise.
    """

    dim: str
    particles: int
    bins: tuple[int, ...]
    noise: tuple[float, ...]
    blur: tuple[float, ...]

    def total(self, times: float = 1.0) -> tuple[float, ...]:
        """Both together, with so many times the particles."""
        return tuple(math.hypot(n / math.sqrt(times), b) for n, b in zip(self.noise, self.blur, strict=True))

    def best(self, times: float = 1.0) -> int:
        """The number of bins of least total error, with so many times the particles."""
        total = self.total(times)
        return self.bins[total.index(min(total))]


def bins_against_noise(array: EstimateArray, dim: str) -> BinsAgainstNoise:
    """What fewer bins along an axis would lose to blur and to noise, from the fine bins of one run.

    array: of one run, with a number of bins along dim that has divisors;  its other axes are kept, and squares averaged over them.
    Means over bins are weighted by the bins' widths.  The noise that blur is measured with is subtracted, and what is
    finer than the finest bins is extrapolated.  Raises SceneError for an axis that cannot be divided.
    """
    if not isinstance(array, EstimateArray) or dim not in array.dims:
        dims = array.dims if isinstance(array, EstimateArray) else ()
        raise SceneError(f"bins_against_noise: no axis {dim!r}; {suggestion(str(dim), dims)}")
    edges = array.coords[dim]
    values = np.moveaxis(array.values, 1 + array.dims.index(dim), -1)
    if len(edges) != values.shape[-1] + 1 or len(_divisors(values.shape[-1])) < 3:
        must = f"{dim!r} must have a number of bins with edges that can be divided"
        raise SceneError(f"bins_against_noise: {must}, got {values.shape[-1]}; write a power of two")
    values = np.nan_to_num(values)
    sizes, widths = array.run.sizes, np.diff(edges)
    size2 = _mean(np.average(values, axis=0, weights=sizes) ** 2, widths)
    size2 -= _mean(standard_error(values, sizes) ** 2, widths)
    numbers = _divisors(len(widths))
    rows = [_errors(values, sizes, widths, number) for number in numbers]
    _, apart2, subtracted = np.array(rows).T
    blur2 = _extrapolated(np.array(numbers), apart2, subtracted)
    scale = math.sqrt(size2) if size2 > 0 else math.nan
    noise = tuple(math.sqrt(row[0]) / scale for row in rows)
    blur = tuple(math.sqrt(max(0.0, square)) / scale for square in blur2.tolist())
    return BinsAgainstNoise(dim, int(sizes.sum()), numbers, noise, blur)


def _divisors(bins: int) -> tuple[int, ...]:
    """Numbers of bins that equally many fine ones each make up, from one to all."""
    return tuple(number for number in range(1, bins + 1) if bins % number == 0)


def _errors(
    values: np.ndarray, sizes: np.ndarray, widths: np.ndarray, bins: int
) -> tuple[float, float, float]:
    """(noise², blur² from the finest bins on, the noise² that was subtracted from it) of that many bins."""
    grouped = widths.reshape(bins, -1)
    shape = (*values.shape[:-1], *grouped.shape)
    means = np.sum(values.reshape(shape) * grouped, axis=-1) / grouped.sum(axis=1)
    coarse = np.repeat(means, grouped.shape[1], axis=-1)
    apart = coarse - values
    noise2 = _mean(standard_error(coarse, sizes) ** 2, widths)
    apart2 = _mean(standard_error(apart, sizes) ** 2, widths)
    return noise2, _mean(np.average(apart, axis=0, weights=sizes) ** 2, widths) - apart2, apart2


def _mean(squares: np.ndarray, widths: np.ndarray) -> float:
    """Over the axis by the bins' widths, and over all others."""
    return float(np.average(squares, axis=-1, weights=widths).mean())


def _extrapolated(numbers: np.ndarray, blur2: np.ndarray, subtracted: np.ndarray) -> np.ndarray:
    """With the blur of the finest bins themselves, by a power law of the number of bins.

    blur² falls with the square of the number for a slope, with the number itself for a step; the exponent in between is
    that of the two finest that are known, or a slope's where noise hides them.
    """
    ratios = numbers[-1] / numbers[:-1]

    def seen(power: float) -> np.ndarray:
        return ratios**power - 1  # in units of the blur² of the finest

    power = SLOPE
    if len(ratios) > 1 and blur2[-2] > SURE * subtracted[-2] / math.sqrt(numbers[-2]):
        powers = np.linspace(STEP, SLOPE, 21)
        expected = np.array([seen(p)[-2] / seen(p)[-1] for p in powers])
        power = float(powers[np.argmin(np.abs(expected - blur2[-3] / blur2[-2]))])
    return blur2 + max(0.0, blur2[-2]) / seen(power)[-1]
