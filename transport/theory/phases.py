"""Phase functions: densities, distribution functions, inverses and moments of the scattering cosine.

mu is the cosine of the scattering angle. Densities are per solid angle [sr^-1] and integrate to 1 over
the sphere. A distribution function is the probability of a cosine below mu. Rational functions accept
any number type: floats, arrays, fractions, mpmath numbers.
"""

from __future__ import annotations

import math

import numpy as np

from transport.statistics.quadrature import legendre_nodes


def henyey_greenstein(mu: np.ndarray, g: float) -> np.ndarray:
    """Henyey-Greenstein phase function.

    Parameters
    ----------
    mu : float or ndarray
        Cosine of the scattering angle, in [-1, 1] [1].
    g : float
        Mean cosine, in (-1, 1) [1].

    Returns
    -------
    float or ndarray
        ``(1 - g^2) / (4 pi (1 + g^2 - 2 g mu)^(3/2))`` [sr^-1].

    Notes
    -----
    Source: Henyey and Greenstein 1941.

    Examples
    --------
    >>> from transport.theory.phases import henyey_greenstein
    >>> print(f"{henyey_greenstein(1.0, 0.5):.4g}")
    0.4775
    """
    return (1 - g) * (1 + g) / (4 * math.pi * _chord(mu, g) ** 1.5)


def henyey_greenstein_share(mu: np.ndarray, g: float) -> np.ndarray:
    """Distribution function of the Henyey-Greenstein phase function.

    Parameters
    ----------
    mu : float or ndarray
        Cosine of the scattering angle, in [-1, 1] [1].
    g : float
        Mean cosine, in (-1, 1) [1].

    Returns
    -------
    float or ndarray
        Probability of a cosine below mu [1].

    Notes
    -----
    ``((1 - g^2) / sqrt(1 + g^2 - 2 g mu) - (1 - g)) / (2 g)``, with the numerator's difference of
    squares divided out, so that it holds for g = 0 too.

    Examples
    --------
    >>> from transport.theory.phases import henyey_greenstein_share
    >>> print(f"{henyey_greenstein_share(0.0, 0.5):.4g}")
    0.1708
    """
    root = _chord(mu, g) ** 0.5
    return (1 - g) * (1 + np.asarray(mu, float)) / (root * (1 + g + root))


def henyey_greenstein_cosine(u, g):
    """Inverse distribution function of the Henyey-Greenstein phase function.

    Parameters
    ----------
    u : float or ndarray
        Probability, in [0, 1] [1].
    g : float
        Mean cosine, in (-1, 1) [1].

    Returns
    -------
    float or ndarray
        Cosine below which the probability is u [1].

    Notes
    -----
    ``(1 + g^2 - ((1 - g^2)/(1 + g s))^2) / (2 g)`` with s = 2u - 1 (Witt 1977, ApJS 35, 1), with g
    divided out: a rational function of u and g.

    Examples
    --------
    >>> from transport.theory.phases import henyey_greenstein_cosine
    >>> print(f"{henyey_greenstein_cosine(0.5, 0.5):.4g}")
    0.6875
    """
    s = 2 * u - 1
    return (2 * s + g * (s * s + 3) + 2 * g * g * s + g * g * g * (s * s - 1)) / (
        2 * (1 + g * s) * (1 + g * s)
    )


def henyey_greenstein_departure(u, g):
    """1 - mu of the inverse distribution function, with full relative accuracy near mu = 1.

    Parameters
    ----------
    u : number
        Probability, as a fraction or a number of many digits [1].
    g : number
        Mean cosine, in (-1, 1) [1].

    Returns
    -------
    number
        ``2 (1 - u) (1 - g)^2 (1 + g u) / (1 - g + 2 g u)^2`` [1].

    Examples
    --------
    >>> from transport.theory.phases import henyey_greenstein_departure
    >>> print(f"{henyey_greenstein_departure(0.5, 0.5):.4g}")
    0.3125
    """
    return 2 * (1 - u) * (1 - g) * (1 - g) * (1 + g * u) / (1 - g + 2 * g * u) ** 2


def henyey_greenstein_means(g: float) -> tuple[float, float, float]:
    """Means of mu, mu^2 and mu^3 of the Henyey-Greenstein phase function.

    Parameters
    ----------
    g : float
        Mean cosine, in (-1, 1) [1].

    Returns
    -------
    tuple of 3 float
        ``g``, ``(1 + 2 g^2)/3``, ``(3 g + 2 g^3)/5``, from the Legendre moments g^l [1].

    Examples
    --------
    >>> from transport.theory.phases import henyey_greenstein_means
    >>> henyey_greenstein_means(0.5)
    (0.5, 0.5, 0.35)
    """
    return g, (1 + 2 * g * g) / 3, (3 * g + 2 * g * g * g) / 5


def henyey_greenstein_ring(mu: np.ndarray, mu_before: np.ndarray, g: float) -> np.ndarray:
    """Density of the cosine to an axis after one Henyey-Greenstein scattering.

    Parameters
    ----------
    mu : float or ndarray
        Cosine to the axis after the scattering [1].
    mu_before : float or ndarray
        Cosine to the axis before the scattering [1].
    g : float
        Mean cosine, in (-1, 1) [1].

    Returns
    -------
    float or ndarray
        Azimuthal mean of the phase function [sr^-1].

    Notes
    -----
    A complete elliptic integral of the second kind: ``int_0^pi (a - b cos)^(-3/2)`` is
    ``2 E(2b/(a + b)) / ((a - b) sqrt(a + b))`` (Gradshteyn and Ryzhik 2.57).

    Examples
    --------
    >>> from transport.theory.phases import henyey_greenstein_ring
    >>> print(f"{henyey_greenstein_ring(0.5, 0.5, 0.5):.4g}")
    0.1308
    """
    from scipy.special import ellipe

    mu, mu_before = np.asarray(mu, float), np.asarray(mu_before, float)
    across = 2 * abs(g) * np.sqrt((1 - mu) * (1 + mu) * (1 - mu_before) * (1 + mu_before))
    middle = 1 + g * g - 2 * g * mu * mu_before
    whole = 2 * ellipe(2 * across / (middle + across)) / ((middle - across) * np.sqrt(middle + across))
    return (1 - g) * (1 + g) / (4 * math.pi**2) * whole


def rayleigh(mu: np.ndarray) -> np.ndarray:
    """Rayleigh phase function of unpolarised light.

    Parameters
    ----------
    mu : float or ndarray
        Cosine of the scattering angle, in [-1, 1] [1].

    Returns
    -------
    float or ndarray
        ``3 (1 + mu^2) / (16 pi)`` [sr^-1].

    Notes
    -----
    Source: Rayleigh 1871.

    Examples
    --------
    >>> from transport.theory.phases import rayleigh
    >>> print(f"{rayleigh(1.0):.4g}")
    0.1194
    """
    return 3 / (16 * math.pi) * (1 + mu * mu)


def rayleigh_share(mu):
    """Distribution function of the Rayleigh phase function.

    Parameters
    ----------
    mu : float or ndarray
        Cosine of the scattering angle [1].

    Returns
    -------
    float or ndarray
        ``(mu^3 + 3 mu + 4)/8`` [1].

    Examples
    --------
    >>> from transport.theory.phases import rayleigh_share
    >>> print(f"{rayleigh_share(0.5):.4g}")
    0.7031
    """
    return (mu * (mu * mu + 3) + 4) / 8


def rayleigh_cosine(u: np.ndarray) -> np.ndarray:
    """Inverse distribution function of the Rayleigh phase function.

    Parameters
    ----------
    u : float or ndarray
        Probability, in [0, 1] [1].

    Returns
    -------
    float or ndarray
        ``2 sinh(arsinh(4u - 2)/3)`` [1], the real root by Cardano's formula.

    Examples
    --------
    >>> from transport.theory.phases import rayleigh_cosine
    >>> print(f"{rayleigh_cosine(0.75):.4g}")
    0.5961
    """
    return 2 * np.sinh(np.arcsinh(4 * np.asarray(u, float) - 2) / 3)


RAYLEIGH_MEANS = (0.0, 2 / 5, 0.0)  # means of mu, mu^2, mu^3


def linear_shares(mu: np.ndarray, density: np.ndarray) -> np.ndarray:
    """Distribution function of a tabulated phase function at the table's cosines.

    Parameters
    ----------
    mu : ndarray
        Cosines of the table, increasing, shape (n,) [1].
    density : ndarray
        Relative density at the table's cosines, linear between them, shape (n,).

    Returns
    -------
    ndarray
        Probabilities of a cosine below each of them, shape (n,) [1].

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.phases import linear_shares
    >>> print(linear_shares(np.array([-1.0, 0.0, 1.0]), np.array([1.0, 1.0, 3.0])).round(4))
    [0.     0.3333 1.    ]
    """
    masses = np.diff(mu) * (np.asarray(density)[1:] + np.asarray(density)[:-1])
    return np.concatenate([[0.0], np.cumsum(masses)]) / masses.sum()


def linear_share(at: np.ndarray, mu: np.ndarray, density: np.ndarray) -> np.ndarray:
    """Distribution function of a tabulated phase function.

    Parameters
    ----------
    at : ndarray
        Cosines [1].
    mu : ndarray
        Cosines of the table, increasing, shape (n,) [1].
    density : ndarray
        Relative density at the table's cosines, linear between them, shape (n,).

    Returns
    -------
    ndarray
        Probability of a cosine below `at`, shape of `at` [1].

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.phases import linear_share
    >>> print(f"{linear_share(0.5, np.array([-1.0, 0.0, 1.0]), np.array([1.0, 1.0, 3.0])):.4g}")
    0.5833
    """
    mu, density = np.asarray(mu, float), np.asarray(density, float)
    k = np.clip(np.searchsorted(mu, at, side="right") - 1, 0, len(mu) - 2)
    t = (at - mu[k]) / (mu[k + 1] - mu[k])
    shares = linear_shares(mu, density)
    both = density[k] + density[k + 1]
    within = t * (2 * density[k] + t * (density[k + 1] - density[k])) / np.where(both > 0, both, 1.0)
    return shares[k] + (shares[k + 1] - shares[k]) * within


def linear_means(mu: np.ndarray, density: np.ndarray) -> tuple[float, float, float]:
    """Means of mu, mu^2 and mu^3 of a tabulated phase function.

    Parameters
    ----------
    mu : ndarray
        Cosines of the table, increasing, shape (n,) [1].
    density : ndarray
        Relative density at the table's cosines, linear between them, shape (n,).

    Returns
    -------
    tuple of 3 float
        The means [1]. Gauss-Legendre with 3 nodes per segment, exact up to degree 5.

    Examples
    --------
    >>> from transport.theory.phases import linear_means
    >>> [round(each, 4) for each in linear_means([-1.0, 1.0], [1.0, 1.0])]
    [0.0, 0.3333, 0.0]
    """
    nodes, weights = legendre_nodes(3)
    mu, density = np.asarray(mu, float), np.asarray(density, float)
    half, middle = np.diff(mu)[:, None] / 2, (mu[1:] + mu[:-1])[:, None] / 2
    x = middle + half * nodes
    w = half * weights * (density[:-1, None] * (1 - nodes) + density[1:, None] * (1 + nodes)) / 2
    return tuple(float((w * x**power).sum() / w.sum()) for power in (1, 2, 3))


def _chord(mu, g):
    """1 + g^2 - 2 g mu as a sum of positive terms."""
    return (1 - abs(g)) ** 2 + 2 * abs(g) * (1 - mu if g >= 0 else 1 + mu)
