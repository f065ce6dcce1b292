"""Radiance at a smooth boundary and at a plate, and escape from a point source in glass.

A ray from air at the angle theta continues at theta' in glass of index n, n sin theta' = sin theta
(Snell), with the share 1 - R of its power. Since n^2 cos theta' dω' = cos theta dω, L' = (1 - R) n^2 L
(Straubel 1902; Nicodemus 1963). Means over a bin are integrals over cosines in *air*, in which R has no
square-root singularity, by Gauss-Legendre: NODES nodes reach rounding error for indices from 1.01 to
10.

R is Fresnel's reflectance averaged over both polarisations, as for light that is unpolarised at every
crossing.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from transport.theory.fresnel import reflectance
from transport.theory.nodes import legendre_nodes

NODES = 96

Share = Callable[[np.ndarray], np.ndarray]  # a function of Fresnel's reflectance R


def through(share: np.ndarray) -> np.ndarray:
    """Transmittance of one boundary.

    Parameters
    ----------
    share : float or ndarray
        Fresnel reflectance R of one boundary [1].

    Returns
    -------
    float or ndarray
        ``1 - R`` [1].

    Examples
    --------
    >>> from transport.theory.refraction import through
    >>> print(f"{through(0.04):.4g}")
    0.96
    """
    return 1 - share


def through_plate(share: np.ndarray) -> np.ndarray:
    """Transmittance of a plate, with all internal reflections added incoherently.

    Parameters
    ----------
    share : float or ndarray
        Fresnel reflectance R of one boundary [1].

    Returns
    -------
    float or ndarray
        ``(1 - R)/(1 + R)`` [1].

    Notes
    -----
    Source: Stokes 1862.

    Examples
    --------
    >>> from transport.theory.refraction import through_plate
    >>> print(f"{through_plate(0.04):.4g}")
    0.9231
    """
    return (1 - share) / (1 + share)


def by_plate(share: np.ndarray) -> np.ndarray:
    """Reflectance of a plate, with all internal reflections added incoherently.

    Parameters
    ----------
    share : float or ndarray
        Fresnel reflectance R of one boundary [1].

    Returns
    -------
    float or ndarray
        ``2 R/(1 + R)`` [1].

    Notes
    -----
    Source: Stokes 1862.

    Examples
    --------
    >>> from transport.theory.refraction import by_plate
    >>> print(f"{by_plate(0.04):.4g}")
    0.07692
    """
    return 2 * share / (1 + share)


def means_in_air(share: Share, theta_edges: np.ndarray, index: float) -> np.ndarray:
    """Means of a function of R over bins of polar angle in air, weighted by cosθ dω.

    Parameters
    ----------
    share : callable
        Function of R, for example `through` [1].
    theta_edges : ndarray
        Edges of the bins of polar angle, increasing from 0 to pi/2, shape (n + 1,) [rad].
    index : float
        Refractive index n of the glass, above 1 [1].

    Returns
    -------
    ndarray
        Means, shape (n,) [1].

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.refraction import means_in_air, through
    >>> print(means_in_air(through, np.array([0.0, 0.5, 1.0]), 1.5).round(4))
    [0.9596 0.9483]
    """
    return _means(share, np.cos(theta_edges), index)


def means_in_glass(share: Share, theta_edges: np.ndarray, index: float) -> np.ndarray:
    """Means of a function of R over bins of polar angle in glass, weighted by cosθ dω.

    Parameters
    ----------
    share : callable
        Function of R, for example `through` [1].
    theta_edges : ndarray
        Edges of the bins of polar angle, increasing from 0 to pi/2, shape (n + 1,) [rad].
    index : float
        Refractive index n of the glass, above 1 [1].

    Returns
    -------
    ndarray
        Means, shape (n,) [1]; R is 1 beyond the critical angle.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.refraction import means_in_glass, through
    >>> print(means_in_glass(through, np.array([0.0, 0.5, 1.0]), 1.5).round(4))
    [0.9571 0.3841]
    """
    squares = np.sin(theta_edges) ** 2
    within = np.minimum(squares, 1 / index**2)
    cosines = np.sqrt(np.maximum(1 - within * index**2, 0.0))  # in air
    inside = np.diff(within) * _means(share, cosines, index)
    return (inside + (np.diff(squares) - np.diff(within)) * share(1.0)) / np.diff(squares)


def escape_from_point(index: float) -> float:
    """Share of an isotropic source's power that leaves glass through a plane boundary at the first incidence.

    Parameters
    ----------
    index : float
        Refractive index n of the glass, above 1 [1].

    Returns
    -------
    float
        Escaping share [1].

    Notes
    -----
    Half of ``∫ (1 - R) dmu'`` over the escape cone, with ``dmu' = mu dmu/(n^2 mu')`` from cosines mu'
    in glass to mu in air.

    Examples
    --------
    >>> from transport.theory.refraction import escape_from_point
    >>> print(f"{escape_from_point(1.5):.4g}")
    0.1148
    """
    mu, weight = _nodes(np.zeros(1), np.ones(1))
    within = np.sqrt(1 - (1 - mu**2) / index**2)
    return float((weight * through(reflectance(mu, index)) * mu / within).sum() / (2 * index**2))


def _means(share: Share, cosines: np.ndarray, index: float) -> np.ndarray:
    """Means between decreasing cosines in air, weighted by mu dmu; 0 for a bin of no width."""
    mu, weight = _nodes(cosines[1:, None], cosines[:-1, None])
    area = (weight * mu).sum(axis=1)
    total = (weight * mu * share(reflectance(mu, index))).sum(axis=1)
    return np.divide(total, area, out=np.zeros_like(total), where=area > 0)


def _nodes(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of an integral from low to high."""
    x, w = legendre_nodes(NODES)
    return low + (high - low) * (1 + x) / 2, (high - low) * w / 2
