"""Penumbra of a straight edge before a diffuse disk: what of the disk is seen, and means over bins across the edge.

The disk, of radius R and radiance L, lies in the plane z = 0 about the origin.  In the plane z = gap all of x < 0 is
opaque; irradiance is sought in the plane z = distance.  The ray from (X, Y, 0) to (x, y, distance) passes where
X (1 − s) + x s > 0, s = gap / distance: the visible part is X > −x s / (1 − s), cut off by a straight chord, and

    E(x, y) = L ∫ G dX dY over it,   G = cosθ cosθ' / r² = d² / ((x − X)² + (y − Y)² + d²)²,   d = distance.

The penumbra is |x| < R (1 − s) / s.  Seen under a small angle G is constant and the fraction of the disk that is
visible tells it all.
"""

from __future__ import annotations

import numpy as np

from transport.theory.counting import Moments
from transport.theory.nodes import legendre_nodes

ACROSS, ALONG = 24, 8  # nodes over the disk, across and along the edge; ALONG over a bin, too


def visible_fraction(u: float) -> float:
    """Fraction of a disk's area beyond a chord at u radii from its middle [1]: (acos u − u √(1 − u²)) / π.

    1 at u = −1 and beyond, 0 at u = 1 and beyond.  Vectorised.
    """
    u = np.clip(u, -1.0, 1.0)
    return (np.arccos(u) - u * np.sqrt((1 - u) * (1 + u))) / np.pi


def half_width(radius: float, gap: float, distance: float) -> float:
    """Half the penumbra's width [m]: R (1 − s) / s, s = gap / distance."""
    return radius * (distance - gap) / gap


def geometry_means(
    x_edges: np.ndarray,
    y_range: tuple[float, float],
    radius: float,
    gap: float,
    distance: float,
    power: int = 1,
) -> np.ndarray:
    """Means of ∫ G^power dX dY over bins across the edge, (bins,) [sr for power 1, sr^2 m^-2 for power 2].

    x_edges, y_range: of the bins in the receiver's plane [m].  Times L it is the mean irradiance; the square is what
    the spread of an aimed source's weights needs.  Bins may be cut by the penumbra's ends, where the nodes take the
    3/2 power; Gauss-Legendre over all four coordinates.
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
    """The same for power 1 on the line x, the mean over y_range [sr]: what narrowing bins tend to."""
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
    """Means of the irradiance over strips from x = low to high [W m^-2], counted by rays aimed at the meter.

    meter_area: of all that the rays are aimed at [m^2], flat in the receiver's plane: both ends of a ray are uniform
    over the disk and the meter, and its weight is in proportion to G.
    """
    geometry = y_range, radius, gap, distance
    mean, square = (
        np.array([geometry_means(edges, *geometry, power)[0] for edges in zip(low, high, strict=True)])
        for power in (1, 2)
    )
    mean, area = radiance * mean, np.subtract(high, low) * (y_range[1] - y_range[0])
    return Moments(mean, radiance**2 * np.pi * radius**2 * meter_area * square / area, mean**2)


def _over_piece(low, high, y_range, radius, gap, distance, power):
    """Integral over low < x < high of the mean over y; x = low + (high − low) sin², for half-odd powers at its ends."""
    t, weight = _nodes(0.0, np.pi / 2, ALONG)
    x, weight = low + (high - low) * np.sin(t) ** 2, weight * (high - low) * np.sin(2 * t)
    y, weight_y = _nodes(*y_range, ALONG)
    return weight @ _over_disk(x, y, radius, gap, distance, power) @ weight_y / (y_range[1] - y_range[0])


def _over_disk(x, y, radius, gap, distance, power):
    """∫ G^power over the visible part of the disk, shape (x, y).

    X = R sin a, Y = R cos a sin b: smooth up to the rim.
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
