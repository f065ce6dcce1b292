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

from transport.statistics.quadrature import legendre_nodes

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
    >>> from transport.geometry.solid_angles import projected_solid_angles
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
    breaks = _breakpoints(n[2], across, phi - math.atan2(n[1], n[0]))
    tilt = n[2] / length, across / length
    return np.array([_row(low, high, tilt, bins, breaks) for low, high in zip(mu[:-1], mu[1:], strict=True)])


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise ValueError(message)


def _breakpoints(along: float, across: float, psi: np.ndarray) -> np.ndarray:
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


# ---- Projected solid angle of a cone about an oblique axis, cut at the receiver's horizon.
#
# The projected solid angle of the visible part of the cone is the area of its projection onto the unit
# disk: a piece of an ellipse, and a segment of the unit circle where the horizon cuts (Nusselt 1928).
# With the segment function seg(x) = x - sin x cos x it is
#
#     P = seg(psi) + g s^2 seg(chi),   cos psi = c / q,   cos chi = -c g / (s q)
#
# with s, c the sine and cosine of the half angle; g, q the cosine and sine of the angle between axis and
# normal; psi half the arc of the horizon inside the cone, chi half the arc of the cone's rim above the
# horizon, sin psi = s sin chi.

TERMS = 48  # terms of the series below: their ratio is at most 1/2, which leaves 2^-48


def cone_projected_solid_angle(half_angle: float, mu: float) -> float:
    """Projected solid angle of a cone of directions, cut at the receiver's horizon.

    Parameters
    ----------
    half_angle : float or ndarray
        Half angle of the cone, 0 to pi [rad].
    mu : float or ndarray
        Cosine between the cone's axis and the receiver's normal [1].

    Returns
    -------
    float or ndarray
        Projected solid angle [sr].

    Notes
    -----
    ``pi sin^2(half_angle) mu`` while the cone is above the horizon, 0 below it. Source: unit-sphere
    method (Nusselt 1928), formula in the module's docstring.

    Examples
    --------
    >>> from transport.geometry.solid_angles import cone_projected_solid_angle
    >>> print(f"{cone_projected_solid_angle(0.5, 0.3):.4g}")
    0.2253
    """
    wide = np.greater(half_angle, math.pi / 2)
    small = np.where(wide, math.pi - np.asarray(half_angle), half_angle)
    part = projected_cone(np.sin(small), np.cos(small), np.where(wide, -np.asarray(mu), mu))
    return np.where(wide, math.pi - part, part)[()]


def projected_cone(sine: float, cosine: float, mu: float) -> float:
    """Projected solid angle of a cone of directions, given by the sine and cosine of its half angle.

    Parameters
    ----------
    sine : float or ndarray
        Sine of the half angle, which is at most pi/2 [1].
    cosine : float or ndarray
        Cosine of the half angle [1].
    mu : float or ndarray
        Cosine between the cone's axis and the receiver's normal [1].

    Returns
    -------
    float or ndarray
        Projected solid angle [sr].

    Examples
    --------
    >>> from transport.geometry.solid_angles import projected_cone
    >>> print(f"{projected_cone(0.6, 0.8, 0.3):.4g}")
    0.3767
    """
    s, c, g = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (sine, cosine, mu)))
    above, below = g >= s, -g >= s
    # Where the cone is not cut, put harmless values of a cut cone into the formulas.
    s, c, g = (
        np.where(above | below, dummy, x) for x, dummy in ((s, math.sqrt(0.5)), (c, math.sqrt(0.5)), (g, 0.0))
    )
    q = np.sqrt((1 - g) * (1 + g))
    sin_psi = np.minimum(np.sqrt((s - g) * (s + g)) / q, 1.0)
    sin_chi = np.minimum(sin_psi / s, 1.0)
    cut = np.where(
        (g < 0) & (sin_chi**2 < 0.5),
        _grazing(s, c, g, sin_chi),
        _cut_at_horizon(s, c, g, q, sin_psi, sin_chi),
    )
    return np.where(above, math.pi * np.square(sine) * mu, np.where(below, 0.0, cut))[()]


def _cut_at_horizon(s, c, g, q, sin_psi, sin_chi):
    """Return seg(psi) + g s^2 seg(chi), accurate unless both terms are small and of opposite sign."""
    cos_psi, cos_chi = c / q, -c * g / (s * q)
    small = 2 / 3 * sin_psi**3 * _series(np.minimum(sin_psi**2, 0.5), lambda m: 1.0)
    segment_psi = np.where(sin_psi**2 < 0.5, small, np.arctan2(sin_psi, cos_psi) - sin_psi * cos_psi)
    segment_chi = np.arctan2(sin_chi, cos_chi) - sin_chi * cos_chi
    return segment_psi + g * s**2 * segment_chi


def _grazing(s, c, g, sin_chi):
    """Projected solid angle of a cone whose axis is below the horizon and of which a small part shows.

    With seg(x) = (2/3) sin^3 x k(sin^2 x) and y = sin^2 chi it is (2/3) s^2 sin^3 chi [(s + g) k(s^2
    y) + g (k(y) - k(s^2 y))]. Both differences are formed first: s + g from the input, k(y) - k(s^2 y)
    term by term with 1 - s^(2m) = -expm1(m log s^2).
    """
    y = np.minimum(sin_chi**2, 0.5)
    log_s2 = np.where(s * s < 0.5, 2 * np.log(s), np.log1p(-np.minimum(c * c, 0.75)))
    first = (s + g) * _series(s * s * y, lambda m: 1.0)
    second = g * _series(y, lambda m: -np.expm1(m * log_s2))
    return 2 / 3 * s**2 * sin_chi**3 * (first + second)


def _series(y, factor):
    """Sum over m of 3/(2m + 3) (1/2)_m / m! y^m factor(m); k(y) if the factor is 1."""
    total, coefficient = 0.0, np.ones_like(y)
    for m in range(TERMS):
        total = total + 3 / (2 * m + 3) * coefficient * factor(m)
        coefficient = coefficient * y * (m + 0.5) / (m + 1)
    return total
