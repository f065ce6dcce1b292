"""Radiance beside a smooth boundary and a plate: what bins of directions hold, what a lamp in glass gets out.

A ray from air at the angle theta goes on at theta' in glass of index n, n sin theta' = sin theta (Snell), and keeps
the share 1 - R of its power.  Since n^2 cos theta' dω' = cos theta dω, L' = (1 - R) n^2 L (Straubel 1902; Nicodemus
1963).  Every mean over a bin is taken as an integral over cosines in *air*, of which R has no root to integrate
across, by Gauss-Legendre: NODES of them leave rounding for indices from 1.01 to 10.

R is Fresnel's reflectance averaged over both polarisations, as for light that is unpolarised at every crossing.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from transport.theory.fresnel import reflectance
from transport.theory.nodes import legendre_nodes

NODES = 96

Share = Callable[[np.ndarray], np.ndarray]  # of Fresnel's reflectance R


def through(share: np.ndarray) -> np.ndarray:
    """1 - R: what crosses one boundary."""
    return 1 - share


def through_plate(share: np.ndarray) -> np.ndarray:
    """(1 - R)/(1 + R): what crosses a plate, all reflections inside added up incoherently (Stokes 1862)."""
    return (1 - share) / (1 + share)


def by_plate(share: np.ndarray) -> np.ndarray:
    """2 R/(1 + R): what a plate sends back, all reflections inside added up incoherently (Stokes 1862)."""
    return 2 * share / (1 + share)


def means_in_air(share: Share, theta_edges: np.ndarray, index: float) -> np.ndarray:
    """Means of a share of R over bins of polar angle in air [1], weighted by cosθ dω.

    theta_edges: (n + 1,) increasing, 0 to pi/2 [rad].  Returns (n,).
    """
    return _means(share, np.cos(theta_edges), index)


def means_in_glass(share: Share, theta_edges: np.ndarray, index: float) -> np.ndarray:
    """The same over bins of polar angle in glass; beyond the critical angle R is 1."""
    squares = np.sin(theta_edges) ** 2
    within = np.minimum(squares, 1 / index**2)
    cosines = np.sqrt(np.maximum(1 - within * index**2, 0.0))  # in air
    inside = np.diff(within) * _means(share, cosines, index)
    return (inside + (np.diff(squares) - np.diff(within)) * share(1.0)) / np.diff(squares)


def escape_from_point(index: float) -> float:
    """Share of an isotropic source's power that leaves glass by a plane boundary at one go [1].

    Half of ∫ (1 - R) dmu' over the escape cone, with dmu' = mu dmu/(n^2 mu') from cosines mu' in glass to mu in air.
    """
    mu, weight = _nodes(np.zeros(1), np.ones(1))
    within = np.sqrt(1 - (1 - mu**2) / index**2)
    return float((weight * through(reflectance(mu, index)) * mu / within).sum() / (2 * index**2))


def _means(share: Share, cosines: np.ndarray, index: float) -> np.ndarray:
    """Means between falling cosines in air, weighted by mu dmu; 0 for a bin of no width."""
    mu, weight = _nodes(cosines[1:, None], cosines[:-1, None])
    area = (weight * mu).sum(axis=1)
    total = (weight * mu * share(reflectance(mu, index))).sum(axis=1)
    return np.divide(total, area, out=np.zeros_like(total), where=area > 0)


def _nodes(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places and weights of an integral from low to high."""
    x, w = legendre_nodes(NODES)
    return low + (high - low) * (1 + x) / 2, (high - low) * w / 2
