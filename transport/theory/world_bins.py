"""Exact projected solid angles of direction bins of a world frame, for a receiver of any orientation.

The integral over azimuth has a closed form: with psi = phi - phi_n, cos theta to the normal is a + b
cos psi, positive for ``|psi| < psi_0`` (the horizon). The integral over the polar angle is
Gauss-Legendre on panels between the angles where the horizon touches a parallel (psi_0 = 0 or pi, where
the integrand has a 3/2 power) or crosses a phi edge. On a panel the variable t of theta = middle - half
cos t makes such powers at its ends analytic, so that NODES nodes reach rounding error.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.nodes import legendre_nodes

NODES = 48


def projected_solid_angles(mu_edges, phi_edges, normal) -> np.ndarray:
    """Integrals of max(0, omega . n) d omega over the bins.

    Parameters
    ----------
    mu_edges : array_like
        Cosines to the polar axis z, increasing within -1 to 1, shape (n + 1,) [1].
    phi_edges : array_like
        Azimuths from x, increasing over at most 2 pi, shape (m + 1,) [rad].
    normal : array_like
        Normal of the receiver's side, of any length, shape (3,).

    Returns
    -------
    ndarray
        Projected solid angles, shape (mu bins, phi bins) [sr].

    Raises
    ------
    ValueError
        If edges are out of order or range, or the normal is zero or not finite.

    Notes
    -----
    Error: 1e-13 of the result for a bin above the horizon, 1e-13 of the bin's solid angle for a cut
    one.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.world_bins import projected_solid_angles
    >>> print(projected_solid_angles([0.0, 0.5, 1.0], [0.0, np.pi], (0.0, 0.0, 1.0)).round(4))
    [[0.3927]
     [1.1781]]
    """
    mu, phi = np.asarray(mu_edges, dtype=float), np.asarray(phi_edges, dtype=float)
    _require(mu.ndim == 1 and mu.size > 1 and np.all(np.diff(mu) > 0), f"mu_edges must increase, got {mu}")
    _require(
        phi.ndim == 1 and phi.size > 1 and np.all(np.diff(phi) > 0), f"phi_edges must increase, got {phi}"
    )
    _require(-1 <= mu[0] and mu[-1] <= 1, f"mu_edges must lie in -1 to 1, got {mu}")
    _require(phi[-1] - phi[0] <= 2 * math.pi * (1 + 1e-15), f"phi_edges must span at most 2 pi, got {phi}")
    n = np.asarray(normal, dtype=float)
    largest = np.max(np.abs(n), initial=0.0)
    _require(
        n.shape == (3,) and 0 < largest < math.inf,
        f"normal must be 3 finite numbers, not all 0, got {normal}",
    )
    n = n / largest
    across = math.hypot(n[0], n[1])
    length = math.hypot(across, n[2])
    start = np.remainder(phi[:-1] - math.atan2(n[1], n[0]) + math.pi, 2 * math.pi) - math.pi
    bins = start, np.diff(phi)
    breaks = _breaks(n[2], across, phi - math.atan2(n[1], n[0]))
    tilt = n[2] / length, across / length
    return np.array([_row(low, high, tilt, bins, breaks) for low, high in zip(mu[:-1], mu[1:], strict=True)])


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise ValueError(message)


def _breaks(along: float, across: float, psi: np.ndarray) -> np.ndarray:
    """Polar angles at which the horizon touches a parallel or crosses an edge of azimuth."""
    touch = math.atan2(abs(along), across)
    cross = np.arctan2(abs(along), -math.copysign(1.0, along) * across * np.cos(psi))
    return np.concatenate(([touch, math.pi - touch], cross))


def _row(low: float, high: float, tilt: tuple, bins: tuple, breaks: np.ndarray) -> np.ndarray:
    """One row of bins, between the cosines low and high."""
    theta, width = _polar_range(low, high)
    inside = np.unique(np.clip((breaks - theta) / width, 0.0, 1.0))
    cuts = np.unique(np.concatenate(([0.0, 1.0], inside))) * width
    nodes, weights = _nodes()
    offset = cuts[:-1, None] + np.diff(cuts)[:, None] * nodes
    angle, weight = theta + offset.ravel(), (np.diff(cuts)[:, None] * weights).ravel()
    return (weight * np.sin(angle)) @ _over_azimuth(angle[:, None], tilt, bins)


def _polar_range(low: float, high: float) -> tuple[float, float]:
    """Polar angle of the upper edge and the bin's angular width, exact for arbitrarily narrow bins."""
    first = math.atan2(math.sqrt((1 - high) * (1 + high)), high)
    last = math.atan2(math.sqrt((1 - low) * (1 + low)), low)
    # cos first - cos last = 2 sin(half the sum) sin(half the difference)
    sine = (high - low) / (2 * math.sin((first + last) / 2))
    return first, 2 * math.asin(sine) if sine < 0.5 else last - first


def _nodes() -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on 0 to 1 for functions with half-odd powers at both ends."""
    x, w = legendre_nodes(NODES)
    quarter = math.pi / 4 * (1 + x)  # t / 2
    return np.sin(quarter) ** 2, math.pi / 4 * w * np.sin(2 * quarter)


def _over_azimuth(theta: np.ndarray, tilt: tuple, bins: tuple) -> np.ndarray:
    """Integral of max(0, a + b cos psi) over the azimuths of each bin, shape (angles, bins)."""
    along, across = tilt
    mu, a, b = np.cos(theta), along * np.cos(theta), across * np.sin(theta)
    # b^2 - a^2 = across^2 - mu^2
    horizon = np.arctan2(np.sqrt(np.maximum((across - mu) * (across + mu), 0.0)), -a)
    total = 0.0
    for centre in (0.0, 2 * math.pi):
        start = bins[0] - centre
        before, after = np.maximum(-horizon - start, 0.0), np.maximum(start + bins[1] - horizon, 0.0)
        width = np.maximum(bins[1] - before - after, 0.0)
        total = total + a * width + 2 * b * np.cos(start + before + width / 2) * np.sin(width / 2)
    return np.maximum(total, 0.0)
