"""Adding and doubling: what a layer does to diffuse light, by way of one so thin that this is plain.

Light is taken without its azimuth, at ordinates of cosine mu with weights w; I is its mean radiance over
azimuth.  A layer is two kernels, which are symmetric, and what passes straight on, e = exp(-tau/mu):

    reflected I_i = sum_j R_ij w_j mu_j I_j,    transmitted I_i = e_i I_i + sum_j T_ij w_j mu_j I_j.

An ordinate of weight 0 is seen but sees nothing: a beam of flux E at mu_j gives the radiance R_ij E/2 pi.
Two equal layers on each other are, with w for w mu,

    S = (1 - Q)^-1 Q,  Q = R w R,    D = T + S e + S w T,  U = R e + R w D,
    R' = R + e U + T w U,    T' = e D + T e + T w D

(van de Hulst 1963; Hansen and Travis 1974, Space Sci. Rev. 16, 527): sums of positive terms, so that nothing
cancels at a depth of 1e-12 or of 1e4.  Through the first layer, `start` deep, out - in = start/mu (a P - 1)
(in + out)/2, P the mean over directions: it keeps the books exactly, is good to (start/mu)^2/12, and goes
with a direct part of (2 mu - start)/(2 mu + start).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

THIN = 0.1  # depth over mu of the first layer, for what the quadrature holds next to grazing
THINNER = 2e-6  # for a beam, whose direct part it then is to 1e-12
DARK = 1e-20  # transmitted share, below which a layer counts as without end
MOST = 200  # doublings


class Layer(NamedTuple):
    """A layer's kernels and its direct transmission.  reflection, transmission: (n, n); direct: (n,) [1]."""

    reflection: np.ndarray
    transmission: np.ndarray
    direct: np.ndarray


def layer(
    depth: float,
    albedo: float,
    forward: np.ndarray,
    backward: np.ndarray,
    mu: np.ndarray,
    weight: np.ndarray,
) -> Layer:
    """A homogeneous layer of that optical depth; math.inf: as deep as light goes, for an albedo below 1.

    forward, backward: (n, n) phase function between ordinates of one hemisphere, and of both, mean 1 over the
    sphere.
    """
    if math.isinf(depth):
        return _without_end(_thin(mu, weight), albedo, forward, backward, mu, weight)
    *_, last = layers(depth, albedo, forward, backward, mu, weight)
    return last


def layers(
    depth: float, albedo: float, forward: np.ndarray, backward: np.ndarray, mu: np.ndarray, weight: np.ndarray
) -> Iterator[Layer]:
    """The same by way of all halves of it: ..., of depth/4, depth/2 and depth."""
    times = max(0, math.ceil(math.log2(depth / _thin(mu, weight))))
    start = math.ldexp(depth, -times)
    one = thin_layer(start, albedo, forward, backward, mu, weight)
    yield one
    for k in range(times):
        with np.errstate(under="ignore"):
            one = doubled(one, mu * weight, direct(start, k + 1, mu))
        yield one


def _thin(mu: np.ndarray, weight: np.ndarray) -> float:
    """Depth of the first layer, at most."""
    return min(THIN * mu[weight > 0].min(), THINNER * mu[weight == 0].min(initial=math.inf))


def thin_layer(
    depth: float, albedo: float, forward: np.ndarray, backward: np.ndarray, mu: np.ndarray, weight: np.ndarray
) -> Layer:
    """A layer so thin that what it scatters is the mean of what enters and leaves: without cancellation."""
    n, reach = len(mu), 2 * mu + depth
    phase, reaches = np.block([[forward, backward], [backward, forward]]), np.tile(reach, 2)[:, None]
    again = (albedo * depth / 2) * phase * np.tile(weight, 2) / reaches
    once = (2 * albedo * depth) * phase[:, :n] / reaches / reach
    kernels = np.linalg.solve(np.eye(2 * n) - again, once)
    return Layer(kernels[n:], kernels[:n], direct(depth, 0, mu))


def direct(start: float, times: int, mu: np.ndarray) -> np.ndarray:
    """What passes straight on after so many doublings of the first layer [1]."""
    return np.exp(-np.ldexp(np.arctanh(start / (2 * mu)), times + 1))


def doubled(one: Layer, flux: np.ndarray, straight: np.ndarray) -> Layer:
    """The layer upon itself.  flux: w mu of the ordinates; straight: the direct transmission of both."""
    r, t, e = one
    between = (r * flux) @ r
    echo = np.linalg.solve(np.eye(len(e)) - between * flux, between)
    down = t + echo * e + (echo * flux) @ t
    up = r * e + (r * flux) @ down
    through = t * flux
    return Layer(r + e[:, None] * up + through @ up, e[:, None] * down + t * e + through @ down, straight)


def _without_end(thin, albedo, forward, backward, mu, weight) -> Layer:
    one, flux = thin_layer(thin, albedo, forward, backward, mu, weight), mu * weight
    with np.errstate(under="ignore"):
        for k in range(MOST):
            one = doubled(one, flux, direct(thin, k + 1, mu))
            if 2 * flux @ (one.transmission @ flux) + flux @ one.direct < DARK:
                return one
    raise ValueError(f"layer: a medium without end needs an albedo below 1, got {albedo!r}")
