"""Adding and doubling: reflection and transmission of a plane layer, built up from a very thin one.

Light is averaged over azimuth and given at ordinates of cosine mu with weights w; I is its mean
radiance over azimuth. A layer is two symmetric kernels R and T, and the direct transmission
e = exp(-tau/mu):

    reflected I_i = sum_j R_ij w_j mu_j I_j,    transmitted I_i = e_i I_i + sum_j T_ij w_j mu_j I_j.

An ordinate of weight 0 receives light but contributes none to integrals: a beam of flux E at mu_j gives
the radiance R_ij E/2 pi. Two equal layers on top of each other are, with w for w mu,

    S = (1 - Q)^-1 Q,  Q = R w R,    D = T + S e + S w T,  U = R e + R w D,
    R' = R + e U + T w U,    T' = e D + T e + T w D

(van de Hulst 1963; Hansen and Travis 1974, Space Sci. Rev. 16, 527): sums of positive terms, so that
nothing cancels at a depth of 1e-12 or of 1e4. The first layer, of depth `start`, obeys
out - in = start/mu (a P - 1) (in + out)/2, P the mean over directions: it conserves energy exactly, is
accurate to (start/mu)^2/12, and has the direct part (2 mu - start)/(2 mu + start).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

THIN = 0.1  # depth over mu of the first layer, at the quadrature's lowest cosine
THINNER = 2e-6  # the same for a beam, whose direct part is then accurate to 1e-12
DARK = 1e-20  # transmitted share below which a layer counts as semi-infinite
MOST = 200  # largest number of doublings


class Layer(NamedTuple):
    """Kernels of a layer and its direct transmission.

    Parameters
    ----------
    reflection : ndarray
        Reflection kernel R, shape (n, n) [1].
    transmission : ndarray
        Kernel T of diffuse transmission, shape (n, n) [1].
    direct : ndarray
        Direct transmission of each ordinate, shape (n,) [1].
    """

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
    """Return the kernels of a homogeneous layer.

    Parameters
    ----------
    depth : float
        Optical depth, above 0; math.inf for a half space of albedo below 1 [1].
    albedo : float
        Single-scattering albedo, 0 to 1 [1].
    forward : ndarray
        Phase function between ordinates of one hemisphere, mean 1 over the sphere, shape (n, n) [1].
    backward : ndarray
        Phase function between ordinates of opposite hemispheres, shape (n, n) [1].
    mu : ndarray
        Cosines of the ordinates, shape (n,) [1].
    weight : ndarray
        Quadrature weights, 0 for beams, shape (n,) [1].

    Returns
    -------
    Layer
        Kernels of the layer.

    Raises
    ------
    ValueError
        If the layer is semi-infinite and the albedo is 1.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.doubling import layer
    >>> one = np.ones((1, 1))
    >>> print(layer(1.0, 1.0, one, one, np.array([0.5]), np.array([1.0])).direct.round(4))
    [0.1352]
    """
    if math.isinf(depth):
        return _without_end(_thin(mu, weight), albedo, forward, backward, mu, weight)
    *_, last = layers(depth, albedo, forward, backward, mu, weight)
    return last


def layers(
    depth: float, albedo: float, forward: np.ndarray, backward: np.ndarray, mu: np.ndarray, weight: np.ndarray
) -> Iterator[Layer]:
    """Yield the layers of depth/2^k, ..., depth/2 and depth, as doubling computes them.

    Parameters
    ----------
    depth : float
        Optical depth of the layer, above 0 [1].
    albedo : float
        Single-scattering albedo, 0 to 1 [1].
    forward : ndarray
        Phase function between ordinates of one hemisphere, mean 1 over the sphere, shape (n, n) [1].
    backward : ndarray
        Phase function between ordinates of opposite hemispheres, shape (n, n) [1].
    mu : ndarray
        Cosines of the ordinates, shape (n,) [1].
    weight : ndarray
        Quadrature weights, 0 for beams, shape (n,) [1].

    Returns
    -------
    iterator of Layer
        Layers in increasing depth; the last has the depth `depth`.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.doubling import layers
    >>> one = np.ones((1, 1))
    >>> len(list(layers(1.0, 1.0, one, one, np.array([0.5]), np.array([1.0]))))
    6
    """
    times = max(0, math.ceil(math.log2(depth / _thin(mu, weight))))
    start = math.ldexp(depth, -times)
    one = thin_layer(start, albedo, forward, backward, mu, weight)
    yield one
    for k in range(times):
        with np.errstate(under="ignore"):
            one = doubled(one, mu * weight, direct(start, k + 1, mu))
        yield one


def _thin(mu: np.ndarray, weight: np.ndarray) -> float:
    """Largest permitted optical depth of the first layer."""
    return min(THIN * mu[weight > 0].min(), THINNER * mu[weight == 0].min(initial=math.inf))


def thin_layer(
    depth: float, albedo: float, forward: np.ndarray, backward: np.ndarray, mu: np.ndarray, weight: np.ndarray
) -> Layer:
    """Return the kernels of a layer so thin that its source is the mean of the entering and leaving light.

    Parameters
    ----------
    depth : float
        Optical depth of the layer, above 0 [1].
    albedo : float
        Single-scattering albedo, 0 to 1 [1].
    forward : ndarray
        Phase function between ordinates of one hemisphere, mean 1 over the sphere, shape (n, n) [1].
    backward : ndarray
        Phase function between ordinates of opposite hemispheres, shape (n, n) [1].
    mu : ndarray
        Cosines of the ordinates, shape (n,) [1].
    weight : ndarray
        Quadrature weights, 0 for beams, shape (n,) [1].

    Returns
    -------
    Layer
        Kernels, computed without cancellation.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.doubling import thin_layer
    >>> one = np.ones((1, 1))
    >>> print(thin_layer(0.01, 1.0, one, one, np.array([0.5]), np.array([1.0])).direct.round(4))
    [0.9802]
    """
    n, reach = len(mu), 2 * mu + depth
    phase, reaches = np.block([[forward, backward], [backward, forward]]), np.tile(reach, 2)[:, None]
    again = (albedo * depth / 2) * phase * np.tile(weight, 2) / reaches
    once = (2 * albedo * depth) * phase[:, :n] / reaches / reach
    kernels = np.linalg.solve(np.eye(2 * n) - again, once)
    return Layer(kernels[n:], kernels[:n], direct(depth, 0, mu))


def direct(start: float, times: int, mu: np.ndarray) -> np.ndarray:
    """Direct transmission after a number of doublings of the first layer.

    Parameters
    ----------
    start : float
        Optical depth of the first layer [1].
    times : int
        Number of doublings.
    mu : ndarray
        Cosines of the ordinates, shape (n,) [1].

    Returns
    -------
    ndarray
        Direct transmission, shape (n,) [1].

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.doubling import direct
    >>> print(direct(0.01, 3, np.array([0.5])).round(4))
    [0.8521]
    """
    return np.exp(-np.ldexp(np.arctanh(start / (2 * mu)), times + 1))


def doubled(one: Layer, flux: np.ndarray, straight: np.ndarray) -> Layer:
    """Return the kernels of a layer on top of an equal one.

    Parameters
    ----------
    one : Layer
        The single layer.
    flux : ndarray
        w mu of the ordinates, shape (n,) [1].
    straight : ndarray
        Direct transmission of both layers together, shape (n,) [1].

    Returns
    -------
    Layer
        Kernels of the double layer.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.doubling import doubled, thin_layer
    >>> one = thin_layer(0.01, 1.0, *[np.ones((1, 1))] * 2, np.array([0.5]), np.array([1.0]))
    >>> print(doubled(one, np.array([0.5]), one.direct**2).direct.round(4))
    [0.9608]
    """
    r, t, e = one
    between = (r * flux) @ r
    echo = np.linalg.solve(np.eye(len(e)) - between * flux, between)
    down = t + echo * e + (echo * flux) @ t
    up = r * e + (r * flux) @ down
    through = t * flux
    return Layer(r + e[:, None] * up + through @ up, e[:, None] * down + t * e + through @ down, straight)


def _without_end(thin, albedo, forward, backward, mu, weight) -> Layer:
    """Double a layer until it transmits less than DARK."""
    one, flux = thin_layer(thin, albedo, forward, backward, mu, weight), mu * weight
    with np.errstate(under="ignore"):
        for k in range(MOST):
            one = doubled(one, flux, direct(thin, k + 1, mu))
            if 2 * flux @ (one.transmission @ flux) + flux @ one.direct < DARK:
                return one
    raise ValueError(f"layer: a semi-infinite medium needs an albedo below 1, got {albedo!r}")
