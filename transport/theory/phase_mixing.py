"""Phase mixing: particles in one dimension between mirrors at x = 0 and x = length become uniform.

A mirror maps x to -x and v to -v. Unfolded, a particle flies straight on through images of the box, so
that the density in the box is the sum over images at 2 m length + x and 2 m length - x of that of free
flight (method of images; Carslaw and Jaeger 1959, ch. 10, for heat). By Poisson's summation it is also
a Fourier series,

    n(x, t) = 1/length + (2/length) sum over m of  a_m chi(k_m t) cos(k_m x),   k_m = m pi / length,

a_m the mean of cos(k_m x) at the start and chi the characteristic function of the velocities (theta
series for normal velocities). Where it decays the density becomes uniform, although no information is
lost in phase space: n(x, v, t) winds into ever thinner filaments (Binney and Tremaine 2008, 4.10).

Particles start at one position or uniformly over an interval. Velocities are independent of it:
`Normal` or `Uniform`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from transport.theory.free_flight import normal_shares

Start = float | tuple[float, float]  # position, or interval (low, high) [m]


@dataclass(frozen=True)
class Normal:
    """Velocities N(0, sigma): one component of a Maxwellian.

    Parameters
    ----------
    sigma : float
        Standard deviation [m/s].
    """

    sigma: float

    @property
    def reach(self) -> float:
        """Largest relevant speed [m/s]: 1 particle in 1e18 is faster."""
        return 9 * self.sigma

    def share(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return the share of the velocities between two limits.

        Parameters
        ----------
        low : ndarray
            Lower velocities [m/s].
        high : ndarray
            Upper velocities, at least `low` [m/s].

        Returns
        -------
        ndarray
            Shares [1].
        """
        return normal_shares(np.asarray(low) / self.sigma, np.asarray(high) / self.sigma)

    def part(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return the integral of v over the velocities between two limits: their share times their mean.

        Parameters
        ----------
        low : ndarray
            Lower velocities [m/s].
        high : ndarray
            Upper velocities, at least `low` [m/s].

        Returns
        -------
        ndarray
            Integrals [m/s].
        """
        bells = [np.exp(-((np.asarray(v) / self.sigma) ** 2) / 2) for v in (low, high)]
        return self.sigma * (bells[0] - bells[1]) / math.sqrt(2 * math.pi)

    def characteristic(self, k: np.ndarray) -> np.ndarray:
        """Return the characteristic function, the mean of cos(k v).

        Parameters
        ----------
        k : ndarray
            Wave numbers times time [s/m].

        Returns
        -------
        ndarray
            Means [1].
        """
        return np.exp(-((k * self.sigma) ** 2) / 2)


@dataclass(frozen=True)
class Uniform:
    """Velocities uniform between -reach and reach (water-bag distribution).

    Parameters
    ----------
    reach : float
        Largest speed [m/s].
    """

    reach: float

    def share(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return the share of the velocities between two limits.

        Parameters
        ----------
        low : ndarray
            Lower velocities [m/s].
        high : ndarray
            Upper velocities, at least `low` [m/s].

        Returns
        -------
        ndarray
            Shares [1].
        """
        low, high = np.clip(low, -self.reach, self.reach), np.clip(high, -self.reach, self.reach)
        return (high - low) / (2 * self.reach)

    def part(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return the integral of v over the velocities between two limits: their share times their mean.

        Parameters
        ----------
        low : ndarray
            Lower velocities [m/s].
        high : ndarray
            Upper velocities, at least `low` [m/s].

        Returns
        -------
        ndarray
            Integrals [m/s].
        """
        low, high = np.clip(low, -self.reach, self.reach), np.clip(high, -self.reach, self.reach)
        return (high - low) * (high + low) / (4 * self.reach)

    def characteristic(self, k: np.ndarray) -> np.ndarray:
        """Return the characteristic function, the mean of cos(k v).

        Parameters
        ----------
        k : ndarray
            Wave numbers times time [s/m].

        Returns
        -------
        ndarray
            Means [1].
        """
        return np.sinc(k * self.reach / math.pi)


Law = Normal | Uniform


def image_density(x: np.ndarray, time: float, start: float, sigma: float, length: float = 1.0) -> np.ndarray:
    """Density of particles with normal velocities from one position, as a sum over images.

    Parameters
    ----------
    x : ndarray
        Positions, in [0, length] [m].
    time : float
        Time t, above 0 [s].
    start : float
        Starting position [m].
    sigma : float
        Standard deviation of the velocities [m/s].
    length : float, default 1.0
        Length of the box [m].

    Returns
    -------
    ndarray
        Density, shape of `x` [m^-1].

    Examples
    --------
    >>> from transport.theory.phase_mixing import image_density
    >>> print(f"{image_density(0.5, 1.0, 0.25, 1.0):.4g}")
    1
    """
    s = sigma * time
    total = np.zeros(np.shape(x))
    for middle in _image_positions(Normal(sigma).reach * time, length):
        for place in (middle + np.asarray(x), middle - np.asarray(x)):
            total += np.exp(-(((place - start) / s) ** 2) / 2)
    return total / (s * math.sqrt(2 * math.pi))


def series_density(
    x: np.ndarray, time: float, start: Start, law: Law, length: float = 1.0, terms: int = 1000
) -> np.ndarray:
    """Density as a Fourier series.

    Parameters
    ----------
    x : ndarray
        Positions, in [0, length] [m].
    time : float
        Time t [s].
    start : float or tuple of 2 float
        Starting position, or interval (low, high) [m].
    law : Normal or Uniform
        Distribution of the velocities.
    length : float, default 1.0
        Length of the box [m].
    terms : int, default 1000
        Number of terms.

    Returns
    -------
    ndarray
        Density, shape of `x` [m^-1].

    Notes
    -----
    Converges as ``exp(-(m pi sigma t / length)^2 / 2)`` for normal velocities, and as 1/m for uniform
    ones, 1/m^2 from an interval. The series needs few terms at late times, the images are few at early
    times.

    Examples
    --------
    >>> from transport.theory.phase_mixing import Normal, series_density
    >>> print(f"{series_density(0.5, 1.0, 0.25, Normal(1.0)):.4g}")
    1
    """
    k = np.arange(1, terms + 1) * (math.pi / length)
    amplitudes = _mean_cosine(k, start) * law.characteristic(k * time)
    return (1 + 2 * np.cos(np.multiply.outer(x, k)) @ amplitudes) / length


def mode(number: int, time: float, start: Start, law: Law, length: float = 1.0) -> float:
    """Mean of cos(number pi x / length) over the particles: amplitude of this wave, 0 for uniform density.

    Parameters
    ----------
    number : int
        Number of half waves in the box.
    time : float
        Time t [s].
    start : float or tuple of 2 float
        Starting position, or interval (low, high) [m].
    law : Normal or Uniform
        Distribution of the velocities.
    length : float, default 1.0
        Length of the box [m].

    Returns
    -------
    float
        Mean [1].

    Examples
    --------
    >>> from transport.theory.phase_mixing import Normal, mode
    >>> print(f"{mode(1, 0.5, 0.25, Normal(1.0)):.4g}")
    0.2059
    """
    k = np.array([number * math.pi / length])
    return float((_mean_cosine(k, start) * law.characteristic(k * time))[0])


def bin_shares(
    edges: np.ndarray,
    time: float,
    start: Start,
    law: Law,
    length: float = 1.0,
    v_edges: np.ndarray | None = None,
) -> np.ndarray:
    """Share of the particles in each bin of position, or in each cell of position and velocity.

    Parameters
    ----------
    edges : ndarray
        Edges of the position bins, increasing within the box, shape (X + 1,) [m].
    time : float
        Time t [s].
    start : float or tuple of 2 float
        Starting position, or interval (low, high) [m].
    law : Normal or Uniform
        Distribution of the velocities.
    length : float, default 1.0
        Length of the box [m].
    v_edges : ndarray or None, default None
        Edges of the velocity bins, increasing, shape (V + 1,) [m/s]; None: all velocities.

    Returns
    -------
    ndarray
        Shares, shape (X,), or (X, V) with `v_edges` [1].

    Notes
    -----
    Sums over images in closed form: the share of the velocities that lead from the start into a bin.
    For an interval of starts, the overlap of the moved interval with the bin, which is piecewise linear
    in v. A cell that no particle reaches holds exactly 0.

    Examples
    --------
    >>> from transport.theory.phase_mixing import Normal, bin_shares
    >>> print(bin_shares([0.0, 0.5, 1.0], 1.0, 0.25, Normal(1.0)).round(4))
    [0.5032 0.4968]
    """
    edges = np.asarray(edges, dtype=float)
    velocities = np.array([-np.inf, np.inf]) if v_edges is None else np.asarray(v_edges, dtype=float)
    low, high = edges[:-1, None], edges[1:, None]
    slow, fast = velocities[:-1], velocities[1:]
    shares = np.zeros((len(edges) - 1, len(velocities) - 1))
    for middle in _image_positions(law.reach * time, length):
        shares += _free_flight_shares(middle + low, middle + high, slow, fast, time, start, law)
        shares += _free_flight_shares(middle - high, middle - low, -fast, -slow, time, start, law)
    return shares if v_edges is not None else shares[:, 0]


def _image_positions(reach: float, length: float) -> Iterator[float]:
    """Positions of the images of x = 0 from which a flight of at most `reach` can come [m]."""
    count = math.ceil(reach / (2 * length)) + 1
    return (2 * length * m for m in range(-count, count + 1))


def _mean_cosine(k: np.ndarray, start: Start) -> np.ndarray:
    """Mean of cos(k x) over the starting positions."""
    if isinstance(start, tuple):
        low, high = start
        return np.cos(k * (low + high) / 2) * np.sinc(k * (high - low) / (2 * math.pi))
    return np.cos(k * start)


def _free_flight_shares(low, high, slow, fast, time: float, start: Start, law: Law) -> np.ndarray:
    """Share of free particles between low and high with velocities between slow and fast, (X, V)."""
    first, last = start if isinstance(start, tuple) else (start, start)
    if time == 0:
        shares = _overlap(low, high, first, last) * law.share(slow, fast)
        return shares + np.zeros(np.broadcast_shapes(np.shape(low), np.shape(slow)))
    slow, fast = np.maximum(slow, -law.reach), np.minimum(fast, law.reach)
    entering, leaving = np.maximum(slow, (low - last) / time), np.minimum(fast, (high - first) / time)
    if first == last:
        return np.where(leaving > entering, law.share(entering, np.maximum(entering, leaving)), 0.0)

    def ramp(reach):
        """Mean of max(reach - v t, 0) over the velocities from slow to fast."""
        end = np.maximum(slow, np.minimum(fast, reach / time))
        return reach * law.share(slow, end) - time * law.part(slow, end)

    overlap = ramp(high - first) - ramp(high - last) - ramp(low - first) + ramp(low - last)
    return np.where(leaving > entering, np.maximum(overlap, 0.0), 0.0) / (last - first)


def _overlap(low, high, first: float, last: float) -> np.ndarray:
    """Share of the starting positions between low and high; one on an edge belongs to the bin above."""
    if first == last:
        return ((low <= first) & (first < high)).astype(float)
    return np.maximum(np.minimum(high, last) - np.maximum(low, first), 0.0) / (last - first)
