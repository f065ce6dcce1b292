"""Phase mixing: particles of one dimension fly to and fro between mirrors at x = 0 and x = length, and forget.

A mirror takes x to -x and v to -v.  Unfolded, a particle flies straight on through images of the box, so that the
density in the box is the sum over images at 2 m length + x and 2 m length - x of that of free flight (method of images;
Carslaw and Jaeger 1959, ch. 10, for heat).  By Poisson's summation it is a Fourier series as well,

    n(x, t) = 1/length + (2/length) sum over m of  a_m chi(k_m t) cos(k_m x),   k_m = m pi / length,

a_m the mean of cos(k_m x) at the start and chi the characteristic function of the velocities (theta series where they
are normal).  Where it decays the density becomes uniform, although nothing is forgotten in phase space: n(x, v, t) only
winds into ever thinner filaments (Binney and Tremaine 2008, 4.10).

The start is at a place, or uniform over an interval; the velocities are independent of it: `Normal` or `Uniform`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from transport.theory.free_flight import normal_shares

Start = float | tuple[float, float]  # a place, or the interval (low, high) [m]


@dataclass(frozen=True)
class Normal:
    """Velocities N(0, sigma) [m/s]: one component of a Maxwellian."""

    sigma: float

    @property
    def reach(self) -> float:
        """The largest speed that matters [m/s]: 1 in 1e18 is faster."""
        return 9 * self.sigma

    def share(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Share of the velocities between low and high >= low [m/s]."""
        return normal_shares(np.asarray(low) / self.sigma, np.asarray(high) / self.sigma)

    def part(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Integral of v over the velocities between low and high [m/s]; their share times their mean."""
        bells = [np.exp(-((np.asarray(v) / self.sigma) ** 2) / 2) for v in (low, high)]
        return self.sigma * (bells[0] - bells[1]) / math.sqrt(2 * math.pi)

    def characteristic(self, k: np.ndarray) -> np.ndarray:
        """Mean of cos(k v);  k [s/m]."""
        return np.exp(-((k * self.sigma) ** 2) / 2)


@dataclass(frozen=True)
class Uniform:
    """Velocities uniform between -reach and reach [m/s]: a water bag."""

    reach: float

    def share(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        low, high = np.clip(low, -self.reach, self.reach), np.clip(high, -self.reach, self.reach)
        return (high - low) / (2 * self.reach)

    def part(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        low, high = np.clip(low, -self.reach, self.reach), np.clip(high, -self.reach, self.reach)
        return (high - low) * (high + low) / (4 * self.reach)

    def characteristic(self, k: np.ndarray) -> np.ndarray:
        return np.sinc(k * self.reach / math.pi)


Law = Normal | Uniform


def image_density(x: np.ndarray, time: float, start: float, sigma: float, length: float = 1.0) -> np.ndarray:
    """Density at x of normal velocities from one place, as a sum over images [m^-1]; time > 0.  Vectorised over x."""
    s = sigma * time
    total = np.zeros(np.shape(x))
    for middle in _image_middles(Normal(sigma).reach * time, length):
        for place in (middle + np.asarray(x), middle - np.asarray(x)):
            total += np.exp(-(((place - start) / s) ** 2) / 2)
    return total / (s * math.sqrt(2 * math.pi))


def series_density(
    x: np.ndarray, time: float, start: Start, law: Law, length: float = 1.0, terms: int = 1000
) -> np.ndarray:
    """Density at x as a Fourier series [m^-1]: the same as by images, summed the other way.  Vectorised over x.

    Converges like exp(-(m pi sigma t / length)^2 / 2) where velocities are normal, and only like 1/m, or 1/m^2 from an
    interval, where they are uniform.  Few terms do late, few images early.
    """
    k = np.arange(1, terms + 1) * (math.pi / length)
    amplitudes = _mean_cosine(k, start) * law.characteristic(k * time)
    return (1 + 2 * np.cos(np.multiply.outer(x, k)) @ amplitudes) / length


def mode(number: int, time: float, start: Start, law: Law, length: float = 1.0) -> float:
    """Mean of cos(number pi x / length) over the particles: how far they are from uniform in this wave [1]."""
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
    """Share of the particles in each of X bins of position, (X,), or with v_edges of position and velocity, (X, V).

    edges: increasing [m], within the box;  v_edges: increasing [m/s].  Sums over images, each in closed form: share of
    the velocities that lead from the start into a bin; over an interval of starts, of the overlap of the moved interval
    with the bin, which is piecewise linear in v.  A cell that nothing reaches holds exactly 0.
    """
    edges = np.asarray(edges, dtype=float)
    velocities = np.array([-np.inf, np.inf]) if v_edges is None else np.asarray(v_edges, dtype=float)
    low, high = edges[:-1, None], edges[1:, None]
    slow, fast = velocities[:-1], velocities[1:]
    shares = np.zeros((len(edges) - 1, len(velocities) - 1))
    for middle in _image_middles(law.reach * time, length):
        shares += _straight(middle + low, middle + high, slow, fast, time, start, law)
        shares += _straight(middle - high, middle - low, -fast, -slow, time, start, law)
    return shares if v_edges is not None else shares[:, 0]


def _image_middles(reach: float, length: float) -> Iterator[float]:
    """Places of the images of x = 0 [m] from which a particle that flies no further than `reach` can have come."""
    count = math.ceil(reach / (2 * length)) + 1
    return (2 * length * m for m in range(-count, count + 1))


def _mean_cosine(k: np.ndarray, start: Start) -> np.ndarray:
    """Mean of cos(k x) over the start."""
    if isinstance(start, tuple):
        low, high = start
        return np.cos(k * (low + high) / 2) * np.sinc(k * (high - low) / (2 * math.pi))
    return np.cos(k * start)


def _straight(low, high, slow, fast, time: float, start: Start, law: Law) -> np.ndarray:
    """Share of free particles between the places low and high whose velocities lie between slow and fast, (X, V)."""
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
    """Share of the start that lies between low and high; a place belongs to the bin that begins there."""
    if first == last:
        return ((low <= first) & (first < high)).astype(float)
    return np.maximum(np.minimum(high, last) - np.maximum(low, first), 0.0) / (last - first)
