"""Directions in the multiple-scattering lobe of a rough mirror: lost share, density and quantile.

The engine samples the lobe by its quantile, and theory.microfacets builds the exact BRDF on it.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from transport.statistics.quadrature import legendre_nodes
from transport.statistics.quantiles import increasing_root, log_ratio

# ---- Smith's shadowing of a rough surface of microfacets, and the light that single reflection loses.
#
# Normals follow Trowbridge and Reitz (1975, J. Opt. Soc. Am. 65, 531), "GGX", with the roughness alpha;
# heights are correlated (Heitz 2014, JCGT 3(2), 48, eq. 99). With m = mu and h = sqrt(mu^2 + alpha^2
# (1 - mu^2)) of each direction
#
#     Lambda = (h - m)/(2 m),    G1 = 1/(1 + Lambda),    G2 = 1/(1 + Lambda_i + Lambda_o)
#
# written so that no shadowing function divides by zero. Directions are given by their elevation above the
# surface [rad], which is exact near grazing, where 1 - mu is not.

TERMS, STEP = 24, 3.0  # nodes per panel, and its length in t, where poles are pi/2 away
MIN_ELEVATION = 2.0**-60  # rad, lowest elevation: clipping lower ones changes no share by a rounding


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
    >>> from transport.statistics.microfacet_lobe import lifted
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
    >>> from transport.statistics.microfacet_lobe import turned_normals
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
    >>> from transport.statistics.microfacet_lobe import lost_share
    >>> print(f"{lost_share(0.5, 0.5):.4g}")
    0.2987
    """
    e = np.maximum(np.asarray(elevation, float), MIN_ELEVATION)[..., None]
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
    >>> from transport.statistics.microfacet_lobe import gauss
    >>> print(gauss(2)[0].round(4))
    [0.2113 0.7887]
    """
    nodes, weights = legendre_nodes(count)
    return (nodes + 1) / 2, weights / 2


# ---- Multiple-scattering lobe of a rough mirror: the light that single reflection from microfacets loses.
#
# After Kulla and Conty (2017, SIGGRAPH course). The share 1 - E(mu) that is lost at the angle of
# incidence returns with a density of cosines that does not depend on that angle,
#
#     p(mu) = 2 (1 - E(mu)) mu / (1 - E_mean),    E_mean = 2 int_0^1 E mu dmu
#
# so that the total is reciprocal and loses nothing. It is stored as polynomials over panels that halve
# towards grazing, where 1 - E vanishes as x log x, and towards the normal down to the roughness: relative
# errors of 1e-13 in both tails.

COMPENSATION_TERMS = 24  # terms of the polynomials
GRAZING_OCTAVES = 50  # octaves of elevation: the density falls with the square of the angle


LEAST_ROUGHNESS = 1e-8  # below it the surface is a mirror up to rounding; the lobe of this roughness is used


@lru_cache(maxsize=64)
def lobe(roughness: float) -> Lobe:
    """Return the lobe of one roughness; the result is cached.

    Parameters
    ----------
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    Lobe
        The lobe.

    Examples
    --------
    >>> from transport.statistics.microfacet_lobe import lobe
    >>> print(f"{lobe(0.5).mean_lost:.4g}")
    0.2998
    """
    return Lobe(max(float(roughness), LEAST_ROUGHNESS))


class Lobe:
    """Multiple-scattering lobe of one roughness: lost share, its mean, and the quantile of the cosine.

    Parameters
    ----------
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Notes
    -----
    The attribute `mean_lost` is ``1 - E_mean`` [1].
    """

    def __init__(self, roughness: float) -> None:
        normal_octaves = math.ceil(math.log2(1 / roughness)) + 4
        self._low = _Tail(lambda x: lost_share(x, roughness), GRAZING_OCTAVES)
        self._high = _Tail(lambda x: lost_share(math.pi / 2 - x, roughness), normal_octaves)
        self.mean_lost = self._low.mass + self._high.mass  # 1 - E_mean

    def lost(self, mu: np.ndarray) -> np.ndarray:
        """Return 1 - E, the share that a single reflection loses [1].

        Parameters
        ----------
        mu : ndarray
            Cosines to the normal, in [0, 1] [1].

        Returns
        -------
        ndarray
            ``1 - E(mu)``, shape of `mu` [1].
        """
        mu = np.asarray(mu, float)
        upper, lost = mu > math.sqrt(0.5), np.empty(mu.shape)
        lost[~upper] = self._low.lost(np.arcsin(mu[~upper]))
        lost[upper] = self._high.lost(np.arccos(mu[upper]))
        return lost

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Return the cosine below which a share `u` of the lobe leaves.

        Parameters
        ----------
        u : ndarray
            Shares, in [0, 1] [1].

        Returns
        -------
        ndarray
            Cosines to the normal, shape of `u` [1].
        """
        u = np.asarray(u, float)
        upper, mu = u * self.mean_lost > self._low.mass, np.empty(u.shape)
        mu[~upper] = np.sin(self._low.angle_of_mass(u[~upper] * self.mean_lost))
        mu[upper] = np.cos(self._high.angle_of_mass((1 - u[upper]) * self.mean_lost))
        return mu


class _Tail:
    """One half of the lobe: angles x in [0, pi/4] from the surface or its normal, and their mass.

    Each panel holds the polynomial of the lost share and g(x), where mass(x) = mass(a) + (x - a) x g(x)
    from the panel's lower end a.
    """

    def __init__(self, lost, octaves: int) -> None:
        self._edges = np.concatenate([[0.0], math.pi / 4 * 2.0 ** np.arange(-octaves, 1)])
        start, width = self._edges[:-1, None], np.diff(self._edges)[:, None]
        fit = np.linalg.inv(chebvander(_PLACES, COMPENSATION_TERMS - 1)).T
        self._lost = lost(start + width * (_PLACES + 1) / 2) @ fit
        nodes, weights = gauss(COMPENSATION_TERMS)
        inner = (_PLACES[:, None] + 1) * nodes - 1  # Gauss nodes between the panel's start and each place
        values = np.einsum("pk,ijk->pij", self._lost, chebvander(inner, COMPENSATION_TERMS - 1))
        x = start[..., None] + width[..., None] * (inner + 1) / 2
        means = (values * np.sin(2 * x)) @ weights
        self._steep = means / (start + width * (_PLACES + 1) / 2) @ fit
        ends = np.diff(self._edges) * self._edges[1:] * self._steep.sum(axis=1)  # all T_k(1) = 1
        self._below = np.concatenate([[0.0], np.cumsum(ends)])
        self.mass = float(self._below[-1])

    def lost(self, x: np.ndarray) -> np.ndarray:
        """Lost share at the angle x [1]."""
        panel = self._panel(self._edges, x)
        return self._chebyshev_sum(self._lost, panel, x)

    def angle_of_mass(self, mass: np.ndarray) -> np.ndarray:
        """Angle up to which the cumulative mass equals `mass` [rad]."""
        panel = self._panel(self._below, mass)
        low, high, below = self._edges[panel], self._edges[panel + 1], self._below[panel]
        target = np.where(mass > 0, mass, self.mass)

        def misfit(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            """Log ratio of the mass at x to the target, and its derivative."""
            value = below + (x - low) * x * self._chebyshev_sum(self._steep, panel, x)
            return log_ratio(value, target), x * self._chebyshev_sum(self._lost, panel, x) * np.sin(
                2 * x
            ) / value

        return np.where(mass > 0, increasing_root(misfit, low, high), 0.0)

    @staticmethod
    def _panel(edges: np.ndarray, x: np.ndarray) -> np.ndarray:
        return np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(edges) - 2)

    def _chebyshev_sum(self, coefficients: np.ndarray, panel: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Chebyshev sums (Clenshaw 1955) at angles x in their panels."""
        start, end = self._edges[panel], self._edges[panel + 1]
        s = ((x - start) - (end - x)) / (end - start)
        one, other = np.zeros(x.shape), np.zeros(x.shape)
        for k in range(COMPENSATION_TERMS - 1, 0, -1):
            one, other = coefficients[panel, k] + 2 * s * one - other, one
        return coefficients[panel, 0] + s * one - other


_PLACES = np.cos(np.pi * (np.arange(COMPENSATION_TERMS) + 0.5) / COMPENSATION_TERMS)


def lobe_quantile(u: np.ndarray, roughness: float) -> np.ndarray:
    """Cosine below which a share of the second lobe leaves.

    Parameters
    ----------
    u : float or ndarray
        Share, in [0, 1] [1].
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    float or ndarray
        Cosine to the normal [1].

    Examples
    --------
    >>> from transport.statistics.microfacet_lobe import lobe_quantile
    >>> print(f"{lobe_quantile(0.5, 0.5):.4g}")
    0.7252
    """
    return lobe(roughness).quantile(u)[()]
