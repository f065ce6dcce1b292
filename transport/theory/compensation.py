"""Multiple-scattering lobe of a rough mirror: the light that single reflection from microfacets loses.

After Kulla and Conty (2017, SIGGRAPH course). The share 1 - E(mu) that is lost at the angle of
incidence returns with a density of cosines that does not depend on that angle,

    p(mu) = 2 (1 - E(mu)) mu / (1 - E_mean),    E_mean = 2 int_0^1 E mu dmu

so that the total is reciprocal and loses nothing. It is stored as polynomials over panels that halve
towards grazing, where 1 - E vanishes as x log x, and towards the normal down to the roughness: relative
errors of 1e-13 in both tails.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from transport.speeds.inversion import increasing_root, log_ratio
from transport.theory.shadowing import gauss, lost_share

TERMS = 24  # terms of the polynomials
GRAZING_OCTAVES = 50  # octaves of elevation: the density falls with the square of the angle


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
    >>> from transport.theory.compensation import lobe
    >>> print(f"{lobe(0.5).mean_lost:.4g}")
    0.2998
    """
    return Lobe(roughness)


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
        mu[~upper] = np.sin(self._low.reached(u[~upper] * self.mean_lost))
        mu[upper] = np.cos(self._high.reached((1 - u[upper]) * self.mean_lost))
        return mu


class _Tail:
    """One half of the lobe: angles x in [0, pi/4] from the surface or its normal, and their mass.

    Each panel holds the polynomial of the lost share and g(x), where mass(x) = mass(a) + (x - a) x g(x)
    from the panel's lower end a.
    """

    def __init__(self, lost, octaves: int) -> None:
        self._edges = np.concatenate([[0.0], math.pi / 4 * 2.0 ** np.arange(-octaves, 1)])
        start, width = self._edges[:-1, None], np.diff(self._edges)[:, None]
        fit = np.linalg.inv(chebvander(_PLACES, TERMS - 1)).T
        self._lost = lost(start + width * (_PLACES + 1) / 2) @ fit
        nodes, weights = gauss(TERMS)
        inner = (_PLACES[:, None] + 1) * nodes - 1  # Gauss nodes between the panel's start and each place
        values = np.einsum("pk,ijk->pij", self._lost, chebvander(inner, TERMS - 1))
        x = start[..., None] + width[..., None] * (inner + 1) / 2
        means = (values * np.sin(2 * x)) @ weights
        self._steep = means / (start + width * (_PLACES + 1) / 2) @ fit
        ends = np.diff(self._edges) * self._edges[1:] * self._steep.sum(axis=1)  # all T_k(1) = 1
        self._below = np.concatenate([[0.0], np.cumsum(ends)])
        self.mass = float(self._below[-1])

    def lost(self, x: np.ndarray) -> np.ndarray:
        """Lost share at the angle x [1]."""
        panel = self._panel(self._edges, x)
        return self._at(self._lost, panel, x)

    def reached(self, mass: np.ndarray) -> np.ndarray:
        """Angle up to which the cumulative mass equals `mass` [rad]."""
        panel = self._panel(self._below, mass)
        low, high, below = self._edges[panel], self._edges[panel + 1], self._below[panel]
        target = np.where(mass > 0, mass, self.mass)

        def misfit(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            """Log ratio of the mass at x to the target, and its derivative."""
            value = below + (x - low) * x * self._at(self._steep, panel, x)
            return log_ratio(value, target), x * self._at(self._lost, panel, x) * np.sin(2 * x) / value

        return np.where(mass > 0, increasing_root(misfit, low, high), 0.0)

    @staticmethod
    def _panel(edges: np.ndarray, x: np.ndarray) -> np.ndarray:
        return np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(edges) - 2)

    def _at(self, coefficients: np.ndarray, panel: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Chebyshev sums (Clenshaw 1955) at angles x in their panels."""
        start, end = self._edges[panel], self._edges[panel + 1]
        s = ((x - start) - (end - x)) / (end - start)
        one, other = np.zeros(x.shape), np.zeros(x.shape)
        for k in range(TERMS - 1, 0, -1):
            one, other = coefficients[panel, k] + 2 * s * one - other, one
        return coefficients[panel, 0] + s * one - other


_PLACES = np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
