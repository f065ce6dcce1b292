"""Throughput of rays through three coaxial disks: a cell, a pupil before it, and a wall that may be too small.

A ray from y on the cell meets the pupil at y + u and the wall at y + s u, s = (f + d)/f, where f is the way from the
cell to the pupil and d the way from the pupil to the wall.  With the area A(u) of the y for which all three are met,

    T = ∫ cosθ² / r² A(u) d²u = ∫ f² / (f² + u²)² A(u) 2 pi u du.

A(u) is the area common to three disks with their middles on a line, which is a sum of segments of circles.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.nodes import legendre_nodes

NODES = 32  # Gauss-Legendre over each piece between two changes of the common area's outline


def three_disks_throughput(
    radius_1: float, radius_2: float, radius_3: float, distance_12: float, distance_23: float
) -> float:
    """Throughput of the rays that meet three parallel coaxial disks, in this order [m^2 sr].

    distance_12, distance_23: between neighbours [m].  For a third disk that all rays through the first two meet it is
    pi A1 F12 (Howell, C-41).  Source: the integral above, Gauss-Legendre between the places where circles touch.
    """
    stretch = (distance_12 + distance_23) / distance_12
    cuts = _changes(np.array([radius_1, radius_2, radius_3]), stretch)
    t, weight = legendre_nodes(NODES)
    t, weight = np.pi / 4 * (t + 1), np.pi / 4 * weight
    start, width = cuts[:-1, None], np.diff(cuts)[:, None]
    u = start + width * np.sin(t) ** 2  # half-odd powers at the ends
    area = common_area(u, (radius_1, radius_2, radius_3), (0.0, -u, -stretch * u))
    density = 2 * math.pi * u / distance_12**2 / (1 + (u / distance_12) ** 2) ** 2
    return float((area * density * width * np.sin(2 * t) @ weight).sum())


def _changes(radii: np.ndarray, stretch: float) -> np.ndarray:
    """Values of u from 0 up to where nothing is common: two circles touch, or all three run through one point."""
    one, two, three = radii
    apart = np.array([1.0, stretch - 1, stretch])  # of the middles, over u
    sums, differences = (
        np.array([one + two, two + three, one + three]),
        np.array([one - two, two - three, one - three]),
    )
    square = (three**2 - two**2 - (stretch - 1) * (two**2 - one**2)) / (stretch * (stretch - 1))
    last = (sums / apart).min()
    return np.unique(
        np.clip([0.0, *np.abs(differences) / apart, math.sqrt(max(square, 0.0)), last], 0.0, last)
    )


def common_area(u: np.ndarray, radii: tuple, middles: tuple) -> np.ndarray:
    """Area common to three disks with their middles on a line, in decreasing order [m^2].

    Along the line the half width is the least of sqrt(r² - (t - m)²), whose squares differ by straight lines: from left
    to right the first, the second and the third circle is the outline, or the first and the third alone.
    """
    first = _crossing(radii, middles, 0, 1)
    second = _crossing(radii, middles, 1, 2)
    alone = _crossing(radii, middles, 0, 2)
    first, second = (np.where(first < second, each, alone) for each in (first, second))
    low, high = np.full_like(u, -np.inf), np.full_like(u, np.inf)
    spans = ((low, first), (first, second), (second, high))
    return sum(
        _slice(r, left - m, right - m) for r, m, (left, right) in zip(radii, middles, spans, strict=True)
    )


def _crossing(radii, middles, i, j):
    """Where the squared half widths of two disks are equal."""
    gap = middles[i] - middles[j]
    return (middles[i] + middles[j]) / 2 - (radii[i] - radii[j]) * (radii[i] + radii[j]) / (2 * gap)


def _slice(radius, left, right):
    """Area of a disk between two chords at these distances from its middle."""
    a, b = (np.clip(each / radius, -1.0, 1.0) for each in (left, right))
    return radius**2 * (_half(b) - _half(a))


def _half(x):
    return np.arcsin(x) + x * np.sqrt((1 - x) * (1 + x))


def reach_through_lens(
    radius: float, lens: float, focal_length: float, before: float, beyond: float
) -> float:
    """Largest distance from the axis at which rays from a disk arrive behind a thin lens on that axis [m].

    radius, lens: of disk and lens;  before, beyond: from the disk to the lens, and on from it [m].  The lens keeps the
    place x and turns the direction cosines p by -x/f, which conserves throughput (Abbe's sine condition); no lens is
    focal_length = inf.  The largest of rays from 17 radii, through 17 radii and 64 azimuths of the lens, their rims
    included; the largest of all is less than a part in 1000 more.  Raises ValueError where a ray is turned back.
    """
    t, azimuth = np.linspace(0, 1, 17), np.linspace(0, np.pi, 64)[:, None, None]
    start, x, y = radius * t[:, None], lens * t * np.cos(azimuth), lens * t * np.sin(azimuth)
    length = np.sqrt((x - start) ** 2 + y**2 + before**2)
    p, q = (x - start) / length - x / focal_length, y / length - y / focal_length
    if (p**2 + q**2).max() >= 1:
        raise ValueError(
            f"reach_through_lens: a lens of focal length {focal_length} m turns rays back; take a longer one"
        )
    along = beyond / np.sqrt(1 - p**2 - q**2)
    return float(np.hypot(x + p * along, y + q * along).max())
