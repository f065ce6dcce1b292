"""Penumbra of a straight edge in front of a diffuse disk, and means over bins across it.

The disk, of radius R and radiance L, lies in the plane z = 0 about the origin. In the plane z = gap the
half plane x < 0 is opaque. Irradiance is computed in the plane z = distance. The ray from (X, Y, 0) to
(x, y, distance) passes where X (1 − s) + x s > 0, s = gap / distance: the visible part is X > −x s / (1
− s), bounded by a straight chord, and

    E(x, y) = L ∫ G dX dY over it,   G = cosθ cosθ' / r² = d² / ((x − X)² + (y − Y)² + d²)²,   d = distance.

The penumbra is ``|x| < R (1 − s) / s``. If the disk subtends a small angle, G is constant and E is
proportional to the visible fraction of the disk.
"""

from __future__ import annotations

import numpy as np

from transport.theory.counting import Moments
from transport.theory.nodes import legendre_nodes

ACROSS, ALONG = 24, 8  # nodes over the disk, across and along the edge; ALONG also over a bin


def visible_fraction(u: float) -> float:
    """Fraction of a disk's area beyond a chord.

    Parameters
    ----------
    u : float or ndarray
        Distance of the chord from the center over the radius; negative on the other side [1].

    Returns
    -------
    float or ndarray
        ``(acos u - u sqrt(1 - u²)) / pi`` [1]: 1 for u <= -1, 0 for u >= 1.

    Examples
    --------
    >>> from transport.theory.penumbra import visible_fraction
    >>> print(f"{visible_fraction(0.5):.4g}")
    0.1955
    """
    u = np.clip(u, -1.0, 1.0)
    return (np.arccos(u) - u * np.sqrt((1 - u) * (1 + u))) / np.pi


def half_width(radius: float, gap: float, distance: float) -> float:
    """Half width of the penumbra.

    Parameters
    ----------
    radius : float
        Radius R of the disk [m].
    gap : float
        Distance of the edge's plane from the disk [m].
    distance : float
        Distance of the receiver's plane from the disk [m].

    Returns
    -------
    float
        ``R (1 - s) / s`` with s = gap / distance [m].

    Examples
    --------
    >>> from transport.theory.penumbra import half_width
    >>> print(f"{half_width(0.1, 1.0, 3.0):.4g}")
    0.2
    """
    return radius * (distance - gap) / gap


def geometry_means(
    x_edges: np.ndarray,
    y_range: tuple[float, float],
    radius: float,
    gap: float,
    distance: float,
    power: int = 1,
) -> np.ndarray:
    """Means of ``∫ G^power dX dY`` over bins across the edge.

    Parameters
    ----------
    x_edges : array_like
        Edges of the bins across the edge, increasing, shape (bins + 1,) [m].
    y_range : tuple of 2 float
        Range of y in the receiver's plane [m].
    radius : float
        Radius R of the disk [m].
    gap : float
        Distance of the edge's plane from the disk [m].
    distance : float
        Distance of the receiver's plane from the disk [m].
    power : int, default 1
        1 for the irradiance, 2 for the variance of an aimed source's weights.

    Returns
    -------
    ndarray
        Means, shape (bins,) [sr for power 1, sr^2 m^-2 for power 2]. Times L the mean irradiance.

    Notes
    -----
    Gauss-Legendre over all four coordinates. The penumbra's ends may lie inside bins; the nodes
    integrate the 3/2 power there.

    Examples
    --------
    >>> from transport.theory.penumbra import geometry_means
    >>> print(geometry_means([-1.0, 0.0, 1.0], (-0.1, 0.1), 0.5, 1.0, 3.0).round(4))
    [0.0167 0.0627]
    """
    x_edges, reach = np.asarray(x_edges, dtype=float), half_width(radius, gap, distance)
    means = []
    for low, high in zip(x_edges[:-1], x_edges[1:], strict=True):
        cuts = np.unique(np.clip([low, -reach, reach, high], low, high))
        pieces = [
            _over_piece(a, b, y_range, radius, gap, distance, power)
            for a, b in zip(cuts[:-1], cuts[1:], strict=True)
        ]
        means.append(sum(pieces) / (high - low))
    return np.array(means)


def geometry_at(x: float, y_range: tuple[float, float], radius: float, gap: float, distance: float) -> float:
    """Mean of ``∫ G dX dY`` over a range of y on the line x: the limit of narrow bins.

    Parameters
    ----------
    x : float
        Position across the edge [m].
    y_range : tuple of 2 float
        Range of y in the receiver's plane [m].
    radius : float
        Radius R of the disk [m].
    gap : float
        Distance of the edge's plane from the disk [m].
    distance : float
        Distance of the receiver's plane from the disk [m].

    Returns
    -------
    float
        Mean [sr].

    Examples
    --------
    >>> from transport.theory.penumbra import geometry_at
    >>> print(f"{geometry_at(0.0, (-0.1, 0.1), 0.5, 1.0, 3.0):.4g}")
    0.04242
    """
    y, weight = _nodes(*y_range, ALONG)
    values = _over_disk(np.full(1, x), y, radius, gap, distance, 1)
    return float(values[0] @ weight / (y_range[1] - y_range[0]))


def penumbra_moments(
    low: np.ndarray,
    high: np.ndarray,
    meter_area: float,
    radiance: float,
    y_range: tuple[float, float],
    radius: float,
    gap: float,
    distance: float,
) -> Moments:
    """Moments of the mean irradiance over strips, counted by rays aimed at the detector.

    Parameters
    ----------
    low : ndarray
        Lower x of each strip, shape (n,) [m].
    high : ndarray
        Upper x of each strip, shape (n,) [m].
    meter_area : float
        Area of the detector at which all rays are aimed, flat in the receiver's plane [m^2].
    radiance : float
        Radiance L of the disk [W m^-2 sr^-1].
    y_range : tuple of 2 float
        Range of y in the receiver's plane [m].
    radius : float
        Radius R of the disk [m].
    gap : float
        Distance of the edge's plane from the disk [m].
    distance : float
        Distance of the receiver's plane from the disk [m].

    Returns
    -------
    Moments
        Means [W m^-2] and the terms of their variances, shape (n,).

    Notes
    -----
    Both ends of a ray are uniform, over the disk and over the detector, and its weight is proportional
    to G.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.penumbra import penumbra_moments
    >>> at = ((-0.1, 0.1), 0.5, 1.0, 3.0)
    >>> print(penumbra_moments(np.array([0.0]), np.array([0.1]), 1.0, 1.0, *at).mean.round(4))
    [0.0453]
    """
    geometry = y_range, radius, gap, distance
    mean, square = (
        np.array([geometry_means(edges, *geometry, power)[0] for edges in zip(low, high, strict=True)])
        for power in (1, 2)
    )
    mean, area = radiance * mean, np.subtract(high, low) * (y_range[1] - y_range[0])
    return Moments(mean, radiance**2 * np.pi * radius**2 * meter_area * square / area, mean**2)


def _over_piece(low, high, y_range, radius, gap, distance, power):
    """Integral over low < x < high of the mean over y.

    Substitutes x = low + (high − low) sin², for half-odd powers at the ends.
    """
    t, weight = _nodes(0.0, np.pi / 2, ALONG)
    x, weight = low + (high - low) * np.sin(t) ** 2, weight * (high - low) * np.sin(2 * t)
    y, weight_y = _nodes(*y_range, ALONG)
    return weight @ _over_disk(x, y, radius, gap, distance, power) @ weight_y / (y_range[1] - y_range[0])


def _over_disk(x, y, radius, gap, distance, power):
    """∫ G^power over the visible part of the disk, shape (x, y).

    With X = R sin a, Y = R cos a sin b, it is smooth up to the rim.
    """
    share = gap / distance
    first = np.arcsin(np.clip(-x * share / (1 - share) / radius, -1.0, 1.0))
    t, weight_a = _nodes(0.0, 1.0, ACROSS)
    a = first[:, None] + (np.pi / 2 - first[:, None]) * t
    weight_a = weight_a * (np.pi / 2 - first[:, None]) * (radius * np.cos(a))
    b, weight_b = _nodes(-np.pi / 2, np.pi / 2, ALONG)
    big_x = (radius * np.sin(a))[:, None, :, None]
    chord = (radius * np.cos(a))[:, None, :, None]
    big_y = chord * np.sin(b)
    square = (x[:, None, None, None] - big_x) ** 2 + (y[:, None, None] - big_y) ** 2 + distance**2
    g = (distance / square) ** (2 * power)
    inner = (g * (chord * np.cos(b) * weight_b)).sum(axis=-1)
    return (inner * weight_a[:, None, :]).sum(axis=-1)


def _nodes(low: float, high: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    x, weight = legendre_nodes(count)
    return (low + high) / 2 + (high - low) / 2 * x, weight * (high - low) / 2
