"""Phase functions: densities over the cosine mu of the scattering angle, their distributions, inverses and moments.

Densities are per solid angle [sr^-1], their integral over the sphere is 1; a distribution is the probability of a cosine
below mu.  What is rational in its arguments takes any numbers: floats, arrays, fractions, mpmath's.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.nodes import legendre_nodes


def henyey_greenstein(mu: np.ndarray, g: float) -> np.ndarray:
    """Density [sr^-1] of the mean cosine g, (1 - g^2) / (4 pi (1 + g^2 - 2 g mu)^(3/2)) (Henyey and Greenstein 1941)."""
    return (1 - g) * (1 + g) / (4 * math.pi * _chord(mu, g) ** 1.5)


def henyey_greenstein_share(mu: np.ndarray, g: float) -> np.ndarray:
    """Probability of a cosine below mu [1].  Vectorised.

    ((1 - g^2) / sqrt(1 + g^2 - 2 g mu) - (1 - g)) / (2 g), with its numerator's difference of squares divided out, so that it
    holds for g = 0 too.
    """
    root = _chord(mu, g) ** 0.5
    return (1 - g) * (1 + np.asarray(mu, float)) / (root * (1 + g + root))


def henyey_greenstein_cosine(u, g):
    """The cosine below which the share u lies [1]: the inverse, a rational function of u and g.

    (1 + g^2 - ((1 - g^2)/(1 + g s))^2) / (2 g), s = 2u - 1 (Witt 1977, ApJS 35, 1), with g divided out.
    """
    s = 2 * u - 1
    return (2 * s + g * (s * s + 3) + 2 * g * g * s + g * g * g * (s * s - 1)) / (
        2 * (1 + g * s) * (1 + g * s)
    )


def henyey_greenstein_departure(u, g):
    """1 - mu of the same, for u given as a fraction or in many digits: a factor of its own, (1 - u) times a ratio."""
    return 2 * (1 - u) * (1 - g) * (1 - g) * (1 + g * u) / (1 - g + 2 * g * u) ** 2


def henyey_greenstein_means(g: float) -> tuple[float, float, float]:
    """Means of mu, mu^2 and mu^3 [1], from the Legendre moments g^l: g, (1 + 2 g^2)/3, (3 g + 2 g^3)/5."""
    return g, (1 + 2 * g * g) / 3, (3 * g + 2 * g * g * g) / 5


def henyey_greenstein_ring(mu: np.ndarray, mu_before: np.ndarray, g: float) -> np.ndarray:
    """Density [sr^-1] of the cosine mu to an axis after one scattering, of what flew at mu_before to it.  Vectorised.

    The mean over azimuths: a complete elliptic integral of the second kind, for int_0^pi (a - b cos)^(-3/2) is
    2 E(2b/(a + b)) / ((a - b) sqrt(a + b)) (Gradshteyn and Ryzhik 2.57).
    """
    from scipy.special import ellipe

    mu, mu_before = np.asarray(mu, float), np.asarray(mu_before, float)
    across = 2 * abs(g) * np.sqrt((1 - mu) * (1 + mu) * (1 - mu_before) * (1 + mu_before))
    middle = 1 + g * g - 2 * g * mu * mu_before
    whole = 2 * ellipe(2 * across / (middle + across)) / ((middle - across) * np.sqrt(middle + across))
    return (1 - g) * (1 + g) / (4 * math.pi**2) * whole


def rayleigh(mu: np.ndarray) -> np.ndarray:
    """Density [sr^-1] of scattering by what is small, of unpolarised light: 3 (1 + mu^2) / (16 pi) (Rayleigh 1871)."""
    return 3 / (16 * math.pi) * (1 + mu * mu)


def rayleigh_share(mu):
    """Probability of a cosine below mu [1]: (mu^3 + 3 mu + 4)/8."""
    return (mu * (mu * mu + 3) + 4) / 8


def rayleigh_cosine(u: np.ndarray) -> np.ndarray:
    """The cosine below which the share u lies [1]: 2 sinh(arsinh(4u - 2)/3), the real root by Cardano.  Vectorised."""
    return 2 * np.sinh(np.arcsinh(4 * np.asarray(u, float) - 2) / 3)


RAYLEIGH_MEANS = (0.0, 2 / 5, 0.0)  # of mu, mu^2, mu^3


def linear_shares(mu: np.ndarray, density: np.ndarray) -> np.ndarray:
    """Probabilities of cosines below the points of a table [1]; its density, relative, is linear between them."""
    masses = np.diff(mu) * (np.asarray(density)[1:] + np.asarray(density)[:-1])
    return np.concatenate([[0.0], np.cumsum(masses)]) / masses.sum()


def linear_share(at: np.ndarray, mu: np.ndarray, density: np.ndarray) -> np.ndarray:
    """Probability of a cosine below `at` [1], of that table.  Vectorised."""
    mu, density = np.asarray(mu, float), np.asarray(density, float)
    k = np.clip(np.searchsorted(mu, at, side="right") - 1, 0, len(mu) - 2)
    t = (at - mu[k]) / (mu[k + 1] - mu[k])
    shares = linear_shares(mu, density)
    both = density[k] + density[k + 1]
    within = t * (2 * density[k] + t * (density[k + 1] - density[k])) / np.where(both > 0, both, 1.0)
    return shares[k] + (shares[k + 1] - shares[k]) * within


def linear_means(mu: np.ndarray, density: np.ndarray) -> tuple[float, float, float]:
    """Means of mu, mu^2 and mu^3 [1] of that table: Gauss-Legendre of 3 points a segment, exact to degree 5."""
    nodes, weights = legendre_nodes(3)
    mu, density = np.asarray(mu, float), np.asarray(density, float)
    half, middle = np.diff(mu)[:, None] / 2, (mu[1:] + mu[:-1])[:, None] / 2
    x = middle + half * nodes
    w = half * weights * (density[:-1, None] * (1 - nodes) + density[1:, None] * (1 + nodes)) / 2
    return tuple(float((w * x**power).sum() / w.sum()) for power in (1, 2, 3))


def _chord(mu, g):
    """1 + g^2 - 2 g mu as a sum of positive numbers, from the end that g leans to."""
    return (1 - abs(g)) ** 2 + 2 * abs(g) * (1 - mu if g >= 0 else 1 + mu)
