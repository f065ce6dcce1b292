"""Étendue (throughput) of a beam, T = n^2 ∬ cosθ dω dA; every lossless optic conserves it.

In the coordinates x, y and p = n times the direction cosines it is a volume, ∬ dx dy dp_x dp_y, as cosθ
dω = dp_x dp_y; straight flight, mirrors, refraction and an ideal lens conserve it (Liouville; Straubel
1902; Hanrahan 2001, Stanford CS 348B, lecture 4, "Throughput"). In the plane of the axis rays conserve
the area ∬ dx dp. The throughput between two apertures is `etendue.disks_throughput`, that through
glass is in lenses.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from transport.statistics.quadrature import legendre_nodes
from transport.theory.optical_paths import Rays, from_to
from transport.theory.view_factors import coaxial_disks


def cone_etendue(area: float, half_angle: float = math.pi / 2, index: float = 1.0) -> float:
    """Throughput of an area with a cone of directions about its normal.

    Parameters
    ----------
    area : float or ndarray
        Area A [m^2].
    half_angle : float or ndarray, default math.pi / 2
        Half angle theta of the cone, up to pi/2 [rad].
    index : float or ndarray, default 1.0
        Refractive index n [1].

    Returns
    -------
    float or ndarray
        ``n^2 pi A sin^2 theta`` [m^2 sr].

    Examples
    --------
    >>> from transport.theory.etendue import cone_etendue
    >>> print(f"{cone_etendue(1.0, 0.5):.4g}")
    0.7221
    """
    return np.square(index * np.sin(half_angle)) * math.pi * area


def meridional_etendue(half_1: float, half_2: float, distance: float) -> float:
    """Throughput ``∬ dx dp`` of the rays in one plane between two facing slits.

    Parameters
    ----------
    half_1 : float or ndarray
        Half width of the first slit [m].
    half_2 : float or ndarray
        Half width of the second slit [m].
    distance : float or ndarray
        Distance between the slits [m].

    Returns
    -------
    float or ndarray
        ``2 (crossed - uncrossed)`` [m].

    Notes
    -----
    Crossed and uncrossed strings are the straight lines between the slits' ends (Hottel 1954). Their
    squares differ by ``4 half_1 half_2``, so that nothing cancels.

    Examples
    --------
    >>> from transport.theory.etendue import meridional_etendue
    >>> print(f"{meridional_etendue(1.0, 1.0, 2.0):.4g}")
    1.657
    """
    crossed = np.hypot(distance, np.add(half_1, half_2))
    uncrossed = np.hypot(distance, np.subtract(half_1, half_2))
    return 8 * np.multiply(half_1, half_2) / (crossed + uncrossed)


def meridional_outline(
    half_1: float, height_1: float, half_2: float, height_2: float, points: int = 200
) -> Rays:
    """Outermost rays in the plane y = 0 from one slit about the z axis to another, as a closed outline.

    Parameters
    ----------
    half_1 : float
        Half width of the first slit [m].
    height_1 : float
        Height z of the first slit [m].
    half_2 : float
        Half width of the second slit [m].
    height_2 : float
        Height z of the second slit [m].
    points : int, default 200
        Number of rays per side of the outline.

    Returns
    -------
    Rays
        Rays, shape (4 points, 3) [m]. Traced on, they bound the beam in x and p at every height.

    Examples
    --------
    >>> from transport.theory.etendue import meridional_outline
    >>> meridional_outline(1.0, 0.0, 1.0, 2.0, points=5).points.shape
    (20, 3)
    """
    run, still = np.linspace(-1, 1, points, endpoint=False), np.ones(points)
    one = half_1 * np.concatenate([run, still, -run, -still])
    two = half_2 * np.concatenate([-still, run, still, -run])
    start, end = (
        np.stack([x, 0 * x, np.full_like(x, z)], axis=-1) for x, z in ((one, height_1), (two, height_2))
    )
    return from_to(start, end)


def outlined_area(x: np.ndarray, p: np.ndarray) -> float:
    """Area within a closed outline in x and p.

    Parameters
    ----------
    x : ndarray
        Positions, shape (n,) [m].
    p : ndarray
        Direction cosines times the index, shape (n,) [1].

    Returns
    -------
    float
        Area, for either sense of rotation [m].

    Notes
    -----
    Gauss's shoelace formula.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.etendue import outlined_area
    >>> print(f"{outlined_area(np.array([0.0, 1.0, 1.0, 0.0]), np.array([0.0, 0.0, 2.0, 2.0])):.4g}")
    2
    """
    return float(abs(np.sum(x * np.roll(p, -1) - p * np.roll(x, -1))) / 2)


# ---- Throughput of rays through three coaxial disks: a retina cell, a pupil and a wall.
#
# A ray from y on the cell meets the pupil at y + u and the wall at y + s u, with s = (f + d)/f, f the
# distance from the cell to the pupil and d from the pupil to the wall. With A(u) the area of the points y
# for which the ray meets all three disks,
#
#     T = ∫ cosθ² / r² A(u) d²u = ∫ f² / (f² + u²)² A(u) 2 pi u du.
#
# A(u) is the area common to three disks with collinear centers, a sum of segments of circles.

NODES = 32  # Gauss-Legendre nodes per interval between two changes of the common area's outline


def three_disks_throughput(
    radius_1: float, radius_2: float, radius_3: float, distance_12: float, distance_23: float
) -> float:
    """Throughput of the rays that meet three parallel coaxial disks in sequence.

    Parameters
    ----------
    radius_1 : float
        Radius of the first disk [m].
    radius_2 : float
        Radius of the second disk [m].
    radius_3 : float
        Radius of the third disk [m].
    distance_12 : float
        Distance from the first to the second disk [m].
    distance_23 : float
        Distance from the second to the third disk [m].

    Returns
    -------
    float
        Throughput [m^2 sr].

    Notes
    -----
    The integral in the module's docstring, by Gauss-Legendre quadrature between the values of u where
    circles touch. If all rays through the first two disks meet the third, it equals ``pi A1 F12``
    (Howell, C-41).

    Examples
    --------
    >>> from transport.theory.etendue import three_disks_throughput
    >>> print(f"{three_disks_throughput(1.0, 1.0, 1.0, 2.0, 2.0):.4g}")
    0.55
    """
    stretch = (distance_12 + distance_23) / distance_12
    cuts = _breakpoints(np.array([radius_1, radius_2, radius_3]), stretch)
    t, weight = legendre_nodes(NODES)
    t, weight = np.pi / 4 * (t + 1), np.pi / 4 * weight
    start, width = cuts[:-1, None], np.diff(cuts)[:, None]
    u = start + width * np.sin(t) ** 2  # substitution for half-odd powers at the ends
    area = common_area(u, (radius_1, radius_2, radius_3), (0.0, -u, -stretch * u))
    density = 2 * math.pi * u / distance_12**2 / (1 + (u / distance_12) ** 2) ** 2
    return float((area * density * width * np.sin(2 * t) @ weight).sum())


def _breakpoints(radii: np.ndarray, stretch: float) -> np.ndarray:
    """Values of u where two circles touch or all three pass through one point, from 0 to the last one."""
    one, two, three = radii
    apart = np.array([1.0, stretch - 1, stretch])  # distances between the centers, over u
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
    """Area common to three disks with collinear centers.

    Parameters
    ----------
    u : ndarray
        Offsets of the ray between the first two planes, shape (n,) or (n, m) [m].
    radii : tuple of 3 float
        Radii of the disks [m].
    middles : tuple of 3 float or ndarray
        Positions of the centers along the line, in decreasing order [m].

    Returns
    -------
    ndarray
        Common area, shape of `u` [m^2].

    Notes
    -----
    The half width at the position t on the line is the least of ``sqrt(r^2 - (t - m)^2)``; the squares
    of two such half widths differ by a linear function of t. From left to right the outline is the
    first, the second and the third circle, or the first and the third alone.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.etendue import common_area
    >>> u = np.array([0.5, 1.0])
    >>> print(common_area(u, (1.0, 1.0, 1.0), (0.0, -u, -2 * u)).round(4))
    [1.2284 0.    ]
    """
    first = _crossing(radii, middles, 0, 1)
    second = _crossing(radii, middles, 1, 2)
    alone = _crossing(radii, middles, 0, 2)
    first, second = (np.where(first < second, each, alone) for each in (first, second))
    low, high = np.full_like(u, -np.inf), np.full_like(u, np.inf)
    spans = ((low, first), (first, second), (second, high))
    return sum(
        _area_between_chords(r, left - m, right - m)
        for r, m, (left, right) in zip(radii, middles, spans, strict=True)
    )


def _crossing(radii, middles, i, j):
    """Position at which the squared half widths of two disks are equal."""
    gap = middles[i] - middles[j]
    return (middles[i] + middles[j]) / 2 - (radii[i] - radii[j]) * (radii[i] + radii[j]) / (2 * gap)


def _area_between_chords(radius, left, right):
    """Area of a disk between two chords at these distances from its center."""
    a, b = (np.clip(each / radius, -1.0, 1.0) for each in (left, right))
    return radius**2 * (_half_segment(b) - _half_segment(a))


def _half_segment(x):
    return np.arcsin(x) + x * np.sqrt((1 - x) * (1 + x))


def reach_through_lens(
    radius: float, lens: float, focal_length: float, before: float, beyond: float
) -> float:
    """Largest distance from the axis at which rays from a disk arrive behind a coaxial thin lens.

    Parameters
    ----------
    radius : float
        Radius of the disk [m].
    lens : float
        Radius of the lens [m].
    focal_length : float
        Focal length [m]; inf for no lens.
    before : float
        Distance from the disk to the lens [m].
    beyond : float
        Distance from the lens to the plane of arrival [m].

    Returns
    -------
    float
        Largest distance from the axis [m].

    Raises
    ------
    ValueError
        If the lens reverses a ray, that is, if a direction cosine would exceed 1.

    Notes
    -----
    The lens keeps the position x and changes the direction cosines p by ``-x/f``, which conserves
    throughput (Abbe's sine condition). The result is the maximum over rays from 17 radii of the disk
    through 17 radii and 64 azimuths of the lens, rims included. The maximum over all rays is larger by
    less than 1 part in 1000.

    Examples
    --------
    >>> from transport.theory.etendue import reach_through_lens
    >>> print(f"{reach_through_lens(0.01, 0.1, 1.0, 2.0, 2.0):.4g}")
    0.01026
    """
    t, azimuth = np.linspace(0, 1, 17), np.linspace(0, np.pi, 64)[:, None, None]
    start, x, y = radius * t[:, None], lens * t * np.cos(azimuth), lens * t * np.sin(azimuth)
    length = np.sqrt((x - start) ** 2 + y**2 + before**2)
    p, q = (x - start) / length - x / focal_length, y / length - y / focal_length
    if (p**2 + q**2).max() >= 1:
        raise ValueError(
            f"reach_through_lens: a lens of focal length {focal_length} m reverses rays; use a longer one"
        )
    along = beyond / np.sqrt(1 - p**2 - q**2)
    return float(np.hypot(x + p * along, y + q * along).max())


# ---- Throughput between two facing elements of area, and the bias of radiance due to their size.
#
# A ray that joins dA1 and dA2 at the distance r has the same measure at both ends: dω1 = dA2 cosθ2 / r²
# and dω2 = dA1 cosθ1 / r², so that dω1 dA1 cosθ1 = dω2 dA2 cosθ2 = d²T (Hanrahan 2001, Stanford CS 348B,
# lecture 4, "1st law" and "Throughput"). Elements of finite size have the throughput T = ∬ cosθ1
# cosθ2 / r² dA1 dA2, and a radiance Φ / (dω1 dA1 cosθ1), computed with r and the cosines of their
# centers, is biased by the factor T / d²T.

Vector = Sequence[float]

# Gauss-Legendre along each side: error 1e-12 for sides as long as the distance, 1e-6 for four times that
ELEMENT_NODES = 16


def disks_throughput(radius_1: float, radius_2: float, distance: float) -> float:
    """Throughput between coaxial parallel disks.

    Parameters
    ----------
    radius_1 : float or ndarray
        Radius of the first disk [m].
    radius_2 : float or ndarray
        Radius of the second disk [m].
    distance : float or ndarray
        Distance between the disks [m].

    Returns
    -------
    float or ndarray
        ``pi A1 F12`` [m^2 sr].

    Notes
    -----
    Source: Howell, C-41.

    Examples
    --------
    >>> from transport.theory.etendue import disks_throughput
    >>> print(f"{disks_throughput(1.0, 1.0, 2.0):.4g}")
    1.693
    """
    return (math.pi * np.asarray(radius_1)) ** 2 * coaxial_disks(radius_1, radius_2, distance)


def element_throughput(area_1: float, mu_1: float, area_2: float, mu_2: float, distance: float) -> float:
    """Throughput between two small elements, computed from their centers.

    Parameters
    ----------
    area_1 : float
        Area dA1 [m^2].
    mu_1 : float
        Cosine at the first element, between its normal and the ray [1].
    area_2 : float
        Area dA2 [m^2].
    mu_2 : float
        Cosine at the second element [1].
    distance : float
        Distance r between the centers [m].

    Returns
    -------
    float
        ``dA1 cosθ1 dA2 cosθ2 / r²`` [m^2 sr].

    Examples
    --------
    >>> from transport.theory.etendue import element_throughput
    >>> print(f"{element_throughput(0.01, 1.0, 0.02, 0.5, 2.0):.4g}")
    2.5e-05
    """
    return area_1 * mu_1 * (area_2 * mu_2 / distance**2)


def disks_bias(ratio_1: float, ratio_2: float) -> float:
    """Relative error of treating coaxial disks as small elements.

    Parameters
    ----------
    ratio_1 : float or ndarray
        Radius of the first disk over the distance [1].
    ratio_2 : float or ndarray
        Radius of the second disk over the distance [1].

    Returns
    -------
    float or ndarray
        ``T r² / (A1 A2) - 1`` [1], about -(ratio_1² + ratio_2²).

    Notes
    -----
    With ``s = (p + m) / 2r``, p and m the longest and the shortest line between the rims, it is
    ``-(s - 1)(s + 1) / s²``, which does not cancel.

    Examples
    --------
    >>> from transport.theory.etendue import disks_bias
    >>> print(f"{disks_bias(0.1, 0.1):.4g}")
    -0.01951
    """
    total, difference = np.add(ratio_1, ratio_2), np.subtract(ratio_1, ratio_2)
    longest, shortest = np.hypot(1, total), np.hypot(1, difference)
    excess = (total**2 / (1 + longest) + difference**2 / (1 + shortest)) / 2
    return -excess * (2 + excess) / (1 + excess) ** 2


def tilted_throughput(center_1: Vector, sides_1: Sequence[Vector], center_2: Vector, sides_2) -> float:
    """Throughput between two parallelograms.

    Parameters
    ----------
    center_1 : array_like
        Center of the first parallelogram, shape (3,) [m].
    sides_1 : array_like
        Its two side vectors, shape (2, 3) [m].
    center_2 : array_like
        Center of the second parallelogram, shape (3,) [m].
    sides_2 : array_like
        Its two side vectors, shape (2, 3) [m].

    Returns
    -------
    float
        ``∬ |cosθ1 cosθ2| / r² dA1 dA2`` [m^2 sr].

    Raises
    ------
    ValueError
        If one parallelogram crosses the plane of the other.

    Notes
    -----
    Gauss-Legendre quadrature along all four sides.

    Examples
    --------
    >>> from transport.theory.etendue import tilted_throughput
    >>> sides = [(0.1, 0.0, 0.0), (0.0, 0.1, 0.0)]
    >>> print(f"{tilted_throughput((0.0, 0.0, 0.0), sides, (0.0, 0.0, 1.0), sides):.4g}")
    9.934e-05
    """
    x, weight = legendre_nodes(ELEMENT_NODES)
    ends = np.array([[s, t] for s in (-0.5, 0.5) for t in (-0.5, 0.5)])
    inner = np.array([[s, t] for s in x / 2 for t in x / 2])
    weights = np.outer(weight, weight).ravel() / 4
    one, two = (np.asarray(sides, dtype=float) for sides in (sides_1, sides_2))
    normal_1, normal_2 = np.cross(*one), np.cross(*two)  # lengths equal the areas
    gap = np.subtract(center_2, center_1)

    def between(of_1: np.ndarray, of_2: np.ndarray) -> np.ndarray:
        """Vectors from points of the first parallelogram to points of the second [m]."""
        return gap + (of_2 @ two)[None, :, :] - (of_1 @ one)[:, None, :]

    corners = between(ends, ends)
    for normal in (normal_1, normal_2):
        if np.ptp(np.sign(corners @ normal)) != 0:
            raise ValueError(
                "tilted_throughput: an element reaches behind the plane of the other; tilt it less"
            )
    ray = between(inner, inner)
    rays = np.abs(ray @ normal_1) * np.abs(ray @ normal_2) / (ray**2).sum(axis=-1) ** 2
    return float(weights @ rays @ weights)


# ---- An eye in front of a round wall: the reading R = L T of a cell of its retina, and its limits.
#
# The eye has its pupil 17 mm in front of the retina (the reduced eye: Listing 1853). T is the throughput
# between the pupil and the cell. R = L T requires that the ray from the cell through every point of the
# pupil ends on the wall. With an ideal lens in the pupil, which conserves throughput, these rays end on
# the cell's image; with a bare pupil, on a patch that is wider by the pupil.

DEPTH = 0.017  # m, from the pupil to the retina
INSIDE_SHARE = 0.98  # share of a radius up to which traced rays count as inside


@dataclass(frozen=True)
class Eye:
    """A round wall and an eye on its axis.

    Parameters
    ----------
    wall : float
        Radius of the wall [m].
    distance : float
        Distance from the wall to the pupil [m].
    pupil : float
        Radius of the pupil [m].
    cell : float
        Radius of the retina's central cell [m].
    has_lens : bool, default False
        Whether an ideal lens in the pupil focuses the wall on the retina.

    Examples
    --------
    >>> from transport.theory.etendue import Eye
    >>> print(f"{Eye(wall=1.0, distance=2.0, pupil=0.002, cell=0.001).furthest:.4g}")
    5.655
    """

    wall: float
    distance: float
    pupil: float
    cell: float
    has_lens: bool = False

    @property
    def focal_length(self) -> float:
        """Focal length of the lens [m], from 1/f = 1/depth + 1/distance; inf without a lens."""
        return 1 / (1 / DEPTH + 1 / self.distance) if self.has_lens else math.inf

    @property
    def furthest(self) -> float:
        """Distance at which the wall just fills the central cell's view [m]; the lens's blur is neglected."""
        if self.has_lens:
            return self.wall * DEPTH / self.cell
        return (self.wall - self.pupil) * DEPTH / (self.pupil + self.cell)

    def throughput(self, inner: float, outer: float) -> float:
        """Throughput between the pupil and a ring of the retina.

        Parameters
        ----------
        inner : float
            Inner radius of the ring [m].
        outer : float
            Outer radius of the ring [m].

        Returns
        -------
        float
            T [m^2 sr].

        Notes
        -----
        Source: Howell, C-41.
        """
        whole, middle = (disks_throughput(self.pupil, radius, DEPTH) for radius in (outer, inner))
        return float(whole - middle)

    def brightness(self, inner: float, outer: float) -> float | None:
        """Reading of a ring of the retina over L T.

        Parameters
        ----------
        inner : float
            Inner radius of the ring [m].
        outer : float
            Outer radius of the ring [m].

        Returns
        -------
        float or None
            R / L T [1]; None if the lens puts an edge of the wall's image on the ring.

        Notes
        -----
        It is 1 where the wall fills the ring's view, 0 where the ring does not see the wall, and T'/T
        for a central cell that holds the whole image, T' the throughput between wall and pupil. With a
        bare pupil all values between follow from the throughput of ring, pupil and wall.
        """
        reach = reach_through_lens(outer, self.pupil, self.focal_length, DEPTH, self.distance)
        image = reach_through_lens(self.wall, self.pupil, self.focal_length, self.distance, DEPTH)
        whole = self.throughput(inner, outer)
        if reach < INSIDE_SHARE * self.wall:
            return 1.0
        if image < INSIDE_SHARE * inner:
            return 0.0
        if inner == 0 and image < INSIDE_SHARE * outer:
            return float(disks_throughput(self.wall, self.pupil, self.distance)) / whole
        if self.has_lens:
            return None
        return (self._through(outer) - (self._through(inner) if inner > 0 else 0.0)) / whole

    def _through(self, radius: float) -> float:
        return three_disks_throughput(radius, self.pupil, self.wall, DEPTH, self.distance)
