"""Smith's shadowing of a rough surface of microfacets, and the light that single reflection loses.

Normals follow Trowbridge and Reitz (1975, J. Opt. Soc. Am. 65, 531), "GGX", with the roughness alpha;
heights are correlated (Heitz 2014, JCGT 3(2), 48, eq. 99). With m = mu and h = sqrt(mu^2 + alpha^2
(1 - mu^2)) of each direction

    Lambda = (h - m)/(2 m),    G1 = 1/(1 + Lambda),    G2 = 1/(1 + Lambda_i + Lambda_o)

written so that no shadowing function divides by zero. Directions are given by their elevation above the
surface [rad], which is exact near grazing, where 1 - mu is not.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from transport.theory.nodes import legendre_nodes

TERMS, STEP = 24, 3.0  # nodes per panel, and its length in t, where poles are pi/2 away
LEAST = 2.0**-60  # rad, lowest elevation: clipping lower ones changes no share by a rounding


def lifted(elevation: np.ndarray, roughness: float) -> tuple[np.ndarray, np.ndarray]:
    """Cosine mu of directions and h of Smith's functions.

    Parameters
    ----------
    elevation : ndarray
        Elevation of the direction above the surface [rad].
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    tuple of ndarray
        mu = sin(elevation) and ``h = sqrt(mu^2 + alpha^2 (1 - mu^2))`` [1].

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.shadowing import lifted
    >>> print(lifted(np.array([0.5]), 0.5)[1].round(4))
    [0.6499]
    """
    mu = np.sin(elevation)
    return mu, np.hypot(mu, roughness * np.cos(elevation))


def turned_normals(elevation_in: np.ndarray, elevation_out: np.ndarray, roughness: float) -> np.ndarray:
    """Density D of facets that reflect one direction into another, integrated over the azimuth between them.

    Parameters
    ----------
    elevation_in : ndarray
        Elevation of the incident direction [rad].
    elevation_out : ndarray
        Elevation of the reflected direction; may be below the surface, down to -elevation_in [rad].
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    ndarray
        Density [sr^-1 rad].

    Notes
    -----
    ``D = alpha^2/pi (1 + K/(P + B cos phi))^2`` is integrated in closed form, with
    ``K = (1 - alpha^2)(mu_i + mu_o)^2``. P^2 - B^2 is a product of two sums of squares in half the sum
    and half the difference of the elevations, so that nothing cancels.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.shadowing import turned_normals
    >>> print(turned_normals(np.array([0.5]), np.array([0.5]), 0.5).round(4))
    [1.9245]
    """
    half_sum, half_way = (elevation_in + elevation_out) / 2, (elevation_out - elevation_in) / 2
    c, d = np.sin(half_sum), np.cos(half_way)
    alpha2, rest = roughness * roughness, (1 - roughness) * (1 + roughness)
    a = np.sin(half_way) ** 2 + alpha2 * d * d
    b = np.cos(half_sum) ** 2 + alpha2 * c * c
    first = rest * c * d / np.sqrt(a * b)
    second = rest * first * (c * c * a + d * d * b) / (2 * a * b)
    return 2 * alpha2 * (1 + 2 * first + second)


def lost_share(elevation: np.ndarray, roughness: float) -> np.ndarray:
    """Share 1 - E of light that a single reflection loses.

    Parameters
    ----------
    elevation : float or ndarray
        Elevation of the direction above the surface [rad].
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    float or ndarray
        Share [1], accurate to rounding however small.

    Notes
    -----
    The mean over visible normals of ``1 - G2/G1 = Lambda_o/(1 + Lambda_i + Lambda_o)``, which is 1
    below the horizon: an integral of positive terms over the outgoing elevation.

    Examples
    --------
    >>> from transport.theory.shadowing import lost_share
    >>> print(f"{lost_share(0.5, 0.5):.4g}")
    0.2987
    """
    e = np.maximum(np.asarray(elevation, float), LEAST)[..., None]
    mu, h = lifted(e, roughness)

    def shadowed(out: np.ndarray) -> np.ndarray:
        """1 - G2/G1 for an outgoing elevation above the horizon, up to the factor h + mu."""
        mu_out, h_out = lifted(out, roughness)
        fall = (roughness * np.cos(out)) ** 2 / (h_out + mu_out)  # h - mu
        return fall * mu / (h * mu_out + h_out * mu)

    scale = np.minimum(roughness, e)
    parts = (
        _integral(lambda out: turned_normals(e, out, roughness), -e, 0 * e, e, scale),
        _integral(lambda out: turned_normals(e, out, roughness) * shadowed(out), 0 * e, e / 2, 0 * e, scale),
        _integral(
            lambda out: turned_normals(e, out, roughness) * shadowed(out), e / 2, math.pi / 2, e, scale
        ),
    )
    return (sum(parts) / (2 * (mu + h)[..., 0]))[()]


def _integral(
    density, low: np.ndarray, high: np.ndarray, middle: np.ndarray, scale: np.ndarray
) -> np.ndarray:
    """Integral of density cos(x) over elevations x, Gauss-Legendre in t with x = middle + scale sinh t.

    Functions that vary within `scale` of the middle, and on ever longer lengths away from it, are
    smooth in t.
    """
    start, end = np.arcsinh((low - middle) / scale), np.arcsinh((high - middle) / scale)
    panels = max(1, math.ceil(float(np.max(end - start)) / STEP))
    places, weights = gauss(TERMS)
    share = (np.arange(panels)[:, None] + places).ravel() / panels
    t = start + (end - start) * share
    x = middle + scale * np.sinh(t)
    values = density(x) * np.cos(x) * scale * np.cosh(t) * (end - start)
    return values @ np.tile(weights / panels, panels)


@lru_cache(maxsize=64)
def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes and weights on [0, 1]; the result is cached.

    Parameters
    ----------
    count : int
        Number of nodes n.

    Returns
    -------
    tuple of ndarray
        Nodes and weights, shape (n,) each.

    Examples
    --------
    >>> from transport.theory.shadowing import gauss
    >>> print(gauss(2)[0].round(4))
    [0.2113 0.7887]
    """
    nodes, weights = legendre_nodes(count)
    return (nodes + 1) / 2, weights / 2
