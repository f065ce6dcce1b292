"""Readings of a goniometer with bins and lamps of finite size: averages of a reflection law.

f = dL_out/dE_in [sr^-1] is the radiance reflected per irradiance from one direction (Nicodemus et al.
1977, NBS Monograph 160). A law is a vectorised function f(mu_in, mu_out, phi): the cosines of the
directions *to* the lamp and *to* the eye, and the difference of their azimuths [rad]. A bin of
directions holds the mean of L_out weighted by cosθ dω, and a lamp of radiance L gives L_out = L ∫ f
cosθ dω over its cone (Kajiya 1986); both integrals are Gauss-Legendre.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from transport.statistics.quadrature import legendre_nodes

Law = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]

NODES = 24  # nodes per polar angle; bins of the sims are at most as wide as the laws' lobes
SHARED, AZIMUTHAL = legendre_nodes(NODES), legendre_nodes(2 * NODES)


def bin_means(law: Law, angle: float, theta_edges: np.ndarray, phi_edges: np.ndarray) -> np.ndarray:
    """Means of f over bins of the eye's directions, for a beam.

    Parameters
    ----------
    law : callable
        Reflection law f(mu_in, mu_out, phi) [sr^-1].
    angle : float
        Angle between the direction to the lamp and the normal [rad].
    theta_edges : ndarray
        Edges of the bins of the eye's polar angle, shape (theta bins + 1,) [rad].
    phi_edges : ndarray
        Edges of the bins of azimuth, counted from the lamp's, shape (phi bins + 1,) [rad].

    Returns
    -------
    ndarray
        Means of f, shape (theta bins, phi bins) [sr^-1].

    Examples
    --------
    >>> from transport.theory.goniometry import bin_means
    >>> law = lambda mu_in, mu_out, phi: 0.3 + 0 * mu_out * phi
    >>> print(bin_means(law, 0.5, [0.0, 0.5], [0.0, 1.0]).round(4))
    [[0.3]]
    """
    return _over_bins(lambda mu, phi: law(np.cos(angle), mu, phi), theta_edges, phi_edges)


def reflected_radiance(
    law: Law, angle: float, half_angle: float, theta_edges: np.ndarray, phi_edges: np.ndarray
) -> np.ndarray:
    """Radiance reflected from a lamp of radiance 1, averaged over bins of the eye's directions.

    Parameters
    ----------
    law : callable
        Reflection law f(mu_in, mu_out, phi) [sr^-1].
    angle : float
        Angle between the lamp's cone axis and the normal [rad].
    half_angle : float
        Half angle of the cone, which must be above the horizon [rad].
    theta_edges : ndarray
        Edges of the bins of the eye's polar angle, shape (theta bins + 1,) [rad].
    phi_edges : ndarray
        Edges of the bins of azimuth, counted from the lamp's, shape (phi bins + 1,) [rad].

    Returns
    -------
    ndarray
        ``∫ f cosθ dω`` over the cone, shape (theta bins, phi bins) [1].

    Raises
    ------
    ValueError
        If the cone reaches below the horizon.

    Examples
    --------
    >>> from transport.theory.goniometry import reflected_radiance
    >>> law = lambda mu_in, mu_out, phi: 0.3 + 0 * mu_out * phi
    >>> print(reflected_radiance(law, 0.5, 0.1, [0.0, 0.5], [0.0, 1.0]).round(4))
    [[0.0082]]
    """
    lamp, weights = cone(angle, 0.0, half_angle)
    mu_in, phi_in = lamp[:, 2], np.arctan2(lamp[:, 1], lamp[:, 0])

    def seen(mu: np.ndarray, phi: np.ndarray) -> np.ndarray:
        """Reflected radiance of a lamp of radiance 1 in the directions (mu, phi) [1]."""
        mu, phi = np.broadcast_arrays(mu, phi)
        return law(mu_in, mu[..., None], phi[..., None] - phi_in) @ weights

    return _over_bins(seen, theta_edges, phi_edges)


def mean_between_cones(law: Law, lamp: tuple[float, float], eye: tuple[float, float], half_angle: float):
    """Mean of f from a lamp's cone to an eye's cone, weighted by cosθ dω of both.

    Parameters
    ----------
    law : callable
        Reflection law f(mu_in, mu_out, phi) [sr^-1].
    lamp : tuple of 2 float
        Polar angle and azimuth of the lamp's cone axis [rad].
    eye : tuple of 2 float
        Polar angle and azimuth of the eye's cone axis [rad].
    half_angle : float
        Half angle of both cones [rad].

    Returns
    -------
    float
        Mean of f [sr^-1]; unchanged by an exchange of lamp and eye if f is reciprocal.

    Raises
    ------
    ValueError
        If a cone reaches below the horizon.

    Examples
    --------
    >>> from transport.theory.goniometry import mean_between_cones
    >>> law = lambda mu_in, mu_out, phi: 0.3 + 0 * phi
    >>> print(f"{mean_between_cones(law, (0.5, 0.0), (0.5, 1.0), 0.1):.4g}")
    0.3
    """
    to_lamp, at_lamp = cone(*lamp, half_angle)
    to_eye, at_eye = cone(*eye, half_angle)
    azimuths = [np.arctan2(directions[:, 1], directions[:, 0]) for directions in (to_lamp, to_eye)]
    values = law(to_lamp[:, 2, None], to_eye[:, 2], azimuths[1] - azimuths[0][:, None])
    return float(at_lamp @ values @ at_eye / at_lamp.sum() / at_eye.sum())


def cone(angle: float, azimuth: float, half_angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Directions in a cone and their quadrature weights of projected solid angle.

    Parameters
    ----------
    angle : float
        Polar angle of the cone's axis [rad].
    azimuth : float
        Azimuth of the cone's axis [rad].
    half_angle : float
        Half angle of the cone [rad].

    Returns
    -------
    tuple of ndarray
        Unit vectors, shape (n, 3), and their shares of the projected solid angle, shape (n,) [sr].

    Raises
    ------
    ValueError
        If the cone reaches below the horizon, where the weights would not be smooth.

    Examples
    --------
    >>> from transport.theory.goniometry import cone
    >>> print(f"{cone(0.5, 0.0, 0.1)[1].sum():.4g}")
    0.02748
    """
    if angle + half_angle > math.pi / 2 * (1 + 1e-15):
        raise ValueError(f"the cone must stay above the horizon, got {angle} + {half_angle} rad")
    x, w = SHARED
    versed = (1 + x) * math.sin(half_angle / 2) ** 2  # 1 - cos of the angle to the axis
    sine = np.sqrt(versed * (2 - versed))
    turn = 2 * math.pi * (np.arange(2 * NODES) + 0.5) / (2 * NODES)
    along, across, up = (
        np.outer(1 - versed, np.ones_like(turn)),
        np.outer(sine, np.cos(turn)),
        np.outer(sine, np.sin(turn)),
    )
    level = along * math.sin(angle) + across * math.cos(angle)
    directions = np.stack(
        [
            level * math.cos(azimuth) - up * math.sin(azimuth),
            level * math.sin(azimuth) + up * math.cos(azimuth),
            along * math.cos(angle) - across * math.sin(angle),
        ],
        axis=-1,
    ).reshape(-1, 3)
    step = math.sin(half_angle / 2) ** 2 * math.pi / NODES
    return directions, np.repeat(w * step, len(turn)) * directions[:, 2]


def _over_bins(field: Law, theta_edges: np.ndarray, phi_edges: np.ndarray) -> np.ndarray:
    """Means of a field of (mu, phi) over bins, weighted by mu dmu dphi."""
    (x, w), (y, v) = SHARED, AZIMUTHAL
    theta_edges, phi_edges = np.asarray(theta_edges, dtype=float), np.asarray(phi_edges, dtype=float)
    theta = theta_edges[:-1, None] + np.diff(theta_edges)[:, None] * (1 + x) / 2
    phi = phi_edges[:-1, None] + np.diff(phi_edges)[:, None] * (1 + y) / 2
    values = field(np.cos(theta)[:, :, None, None], phi)
    weight = w * np.sin(theta) * np.cos(theta)
    means = np.einsum("ti,tipj,j->tp", weight, np.broadcast_to(values, theta.shape + phi.shape), v / 2)
    return means / weight.sum(axis=1)[:, None]
