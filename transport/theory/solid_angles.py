"""Solid angles and projected solid angles of caps, shapes on the axis and bins of directions.

The projected solid angle is the integral of max(cos theta, 0) d omega [sr]; over a hemisphere it is pi.
Cones about an oblique axis and bins of a world frame are in geometry/solid_angles.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from transport.statistics.quadrature import legendre_nodes
from transport.theory.counting import Moments


def cap_solid_angle(half_angle: float) -> float:
    """Solid angle of a spherical cap.

    Parameters
    ----------
    half_angle : float or ndarray
        Half angle of the cap [rad].

    Returns
    -------
    float or ndarray
        ``2 pi (1 - cos) = 4 pi sin^2(half_angle / 2)`` [sr].

    Examples
    --------
    >>> from transport.theory.solid_angles import cap_solid_angle
    >>> print(f"{cap_solid_angle(0.5):.4g}")
    0.7692
    """
    return 4 * math.pi * np.sin(np.divide(half_angle, 2)) ** 2


def cap_projected_solid_angle(half_angle: float) -> float:
    """Projected solid angle of a cap about the normal.

    Parameters
    ----------
    half_angle : float or ndarray
        Half angle of the cap [rad].

    Returns
    -------
    float or ndarray
        ``pi sin^2(half_angle)`` [sr]; pi for a cap that reaches beyond the horizon.

    Examples
    --------
    >>> from transport.theory.solid_angles import cap_projected_solid_angle
    >>> print(f"{cap_projected_solid_angle(0.5):.4g}")
    0.7221
    """
    return math.pi * np.sin(np.minimum(half_angle, math.pi / 2)) ** 2


def disk_solid_angle(radius: float, distance: float) -> float:
    """Solid angle of a disk from a point on its axis.

    Parameters
    ----------
    radius : float or ndarray
        Radius R of the disk [m].
    distance : float or ndarray
        Distance d of the point from the plane [m].

    Returns
    -------
    float or ndarray
        ``2 pi (1 - d/h)`` with ``h^2 = R^2 + d^2``, computed as ``2 pi R^2 / (h (h + d))`` [sr].

    Examples
    --------
    >>> from transport.theory.solid_angles import disk_solid_angle
    >>> print(f"{disk_solid_angle(1.0, 2.0):.4g}")
    0.6633
    """
    slant = np.hypot(distance, radius)
    return 2 * math.pi * (radius / slant) * (radius / (slant + distance))


def disk_projected_solid_angle(radius: float, distance: float) -> float:
    """Projected solid angle of a disk on the axis of a parallel receiver.

    Parameters
    ----------
    radius : float or ndarray
        Radius R of the disk [m].
    distance : float or ndarray
        Distance d of the point from the plane [m].

    Returns
    -------
    float or ndarray
        ``pi R^2 / (R^2 + d^2)`` [sr].

    Examples
    --------
    >>> from transport.theory.solid_angles import disk_projected_solid_angle
    >>> print(f"{disk_projected_solid_angle(1.0, 2.0):.4g}")
    0.6283
    """
    return math.pi * (radius / np.hypot(distance, radius)) ** 2


def rectangle_solid_angle(width: float, height: float, distance: float) -> float:
    """Solid angle of a rectangle from a point on its axis.

    Parameters
    ----------
    width : float or ndarray
        Width of the rectangle, 2 a [m].
    height : float or ndarray
        Height of the rectangle, 2 b [m].
    distance : float or ndarray
        Distance d of the point from the plane [m].

    Returns
    -------
    float or ndarray
        ``4 atan(a b / (d sqrt(d^2 + a^2 + b^2)))``, a and b half the sides [sr].

    Notes
    -----
    Source: Van Oosterom and Strackee 1983 for its two triangles.

    Examples
    --------
    >>> from transport.theory.solid_angles import rectangle_solid_angle
    >>> print(f"{rectangle_solid_angle(1.0, 1.0, 2.0):.4g}")
    0.2354
    """
    a, b = np.divide(width, 2), np.divide(height, 2)
    slant = np.hypot(distance, np.hypot(a, b))
    return 4 * np.arctan2(np.minimum(a, b), distance * (slant / np.maximum(a, b)))


def rectangle_projected_solid_angle(width: float, height: float, distance: float) -> float:
    """Projected solid angle of a rectangle on the axis of a parallel receiver.

    Parameters
    ----------
    width : float or ndarray
        Width of the rectangle, 2 a [m].
    height : float or ndarray
        Height of the rectangle, 2 b [m].
    distance : float or ndarray
        Distance d of the point from the plane [m].

    Returns
    -------
    float or ndarray
        ``2 [a/p atan(b/p) + b/r atan(a/r)]`` [sr], a and b half the sides, ``p^2 = a^2 + d^2``,
        ``r^2 = b^2 + d^2``.

    Notes
    -----
    Source: Lambert 1760, by contour integration.

    Examples
    --------
    >>> from transport.theory.solid_angles import rectangle_projected_solid_angle
    >>> print(f"{rectangle_projected_solid_angle(1.0, 1.0, 2.0):.4g}")
    0.2308
    """
    a, b = np.divide(width, 2), np.divide(height, 2)
    p, r = np.hypot(a, distance), np.hypot(b, distance)
    return 2 * (a / p * np.arctan(b / p) + b / r * np.arctan(a / r))


def bin_solid_angles(mu_edges, phi_edges) -> np.ndarray:
    """Solid angles of bins of directions in any frame.

    Parameters
    ----------
    mu_edges : array_like
        Edges of the cosine to the polar axis, increasing, shape (n + 1,) [1].
    phi_edges : array_like
        Edges of the azimuth, increasing, shape (m + 1,) [rad].

    Returns
    -------
    ndarray
        ``(mu2 - mu1) (phi2 - phi1)``, shape (mu bins, phi bins) [sr].

    Examples
    --------
    >>> from transport.theory.solid_angles import bin_solid_angles
    >>> print(bin_solid_angles([0.0, 0.5, 1.0], [0.0, 1.0]).round(4))
    [[0.5]
     [0.5]]
    """
    return np.multiply.outer(np.diff(mu_edges), np.diff(phi_edges))


def bin_projected_solid_angles(mu_edges, phi_edges) -> np.ndarray:
    """Projected solid angles of bins of directions in the receiver's own frame.

    Parameters
    ----------
    mu_edges : array_like
        Edges of the cosine to the polar axis, increasing, shape (n + 1,) [1].
    phi_edges : array_like
        Edges of the azimuth, increasing, shape (m + 1,) [rad].

    Returns
    -------
    ndarray
        ``(mu2^2 - mu1^2) / 2 * (phi2 - phi1)``, shape (mu bins, phi bins) [sr]; 0 below the horizon,
        mu < 0.

    Examples
    --------
    >>> from transport.theory.solid_angles import bin_projected_solid_angles
    >>> print(bin_projected_solid_angles([0.0, 0.5, 1.0], [0.0, 1.0]).round(4))
    [[0.125]
     [0.375]]
    """
    above = np.maximum(mu_edges, 0.0)
    return np.multiply.outer(np.diff(above) * (above[1:] + above[:-1]) / 2, np.diff(phi_edges))


# ---- Solid angles of triangles and polygons from any point; the dodecahedron, whose face is close to 1 sr.
#
# A triangle with the vertices a, b, c subtends at the origin (Van Oosterom and Strackee 1983, eq. 8)
#
#     tan(Omega / 2) = a.(b x c) / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|)
#
# The numerator cancels for a sliver or a distant triangle, the denominator for a point close to an edge.
# Products are therefore formed in exact fractions, and in the denominator, where two terms have opposite
# signs, x + y = (x^2 - y^2) / (x - y) with an exact difference. The result has rounding error only,
# unless the triangle's lengths differ by more than 1e50.

Point = Sequence[float]

DODECAHEDRON_FACE = math.pi / 3  # sr, 4 pi / 12; "1 sr" in Bala 2009 (Cornell CS 6620, lecture 2) is rounded
ORIGIN = (0.0, 0.0, 0.0)


def triangle_solid_angle(vertices: Sequence[Point], position: Point = ORIGIN) -> float:
    """Solid angle of a triangle.

    Parameters
    ----------
    vertices : sequence of 3 points
        Vertices [m].
    position : Point, default ORIGIN
        Point of observation [m].

    Returns
    -------
    float
        Solid angle [sr]; 2 pi from inside the triangle, nan from its edge.

    Notes
    -----
    Source: Van Oosterom and Strackee 1983, eq. 8, as in the module's docstring.

    Examples
    --------
    >>> from transport.theory.solid_angles import triangle_solid_angle
    >>> print(f"{triangle_solid_angle([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]):.4g}")
    1.571
    """
    return abs(_signed(_seen_from(position, vertices)))


def polygon_solid_angle(vertices: Sequence[Point], position: Point = ORIGIN) -> float:
    """Solid angle of a flat polygon, convex or not.

    Parameters
    ----------
    vertices : sequence of points
        Three vertices or more, in order [m].
    position : Point, default ORIGIN
        Point of observation [m].

    Returns
    -------
    float
        Solid angle [sr]; 2 pi from inside the polygon, nan from its edge.

    Notes
    -----
    The signed solid angles of the triangles of the fan about the first vertex add up.

    Examples
    --------
    >>> from transport.theory.solid_angles import polygon_solid_angle
    >>> square = [(1.0, 1.0, 1.0), (-1.0, 1.0, 1.0), (-1.0, -1.0, 1.0), (1.0, -1.0, 1.0)]
    >>> print(f"{polygon_solid_angle(square):.4g}")
    2.094
    """
    first, *others = _seen_from(position, vertices)
    return abs(math.fsum(_signed((first, *pair)) for pair in zip(others, others[1:], strict=False)))


def polygon_projected_solid_angle(
    vertices: Sequence[Point], normal: Point, position: Point = ORIGIN
) -> float:
    """Projected solid angle of a flat convex polygon on a plane in any position.

    Parameters
    ----------
    vertices : sequence of points
        Three vertices or more, in order [m].
    normal : vector
        Normal of the receiving plane, of any length except 0.
    position : Point, default ORIGIN
        Point of the receiving plane [m], not on the outline.

    Returns
    -------
    float
        Integral of max(cos, 0) over the polygon's solid angle [sr]; what lies behind the plane counts
        nothing.

    Notes
    -----
    The part before the plane is a polygon again; of that it is half the sum over the edges of the angle that
    the edge subtends times the cosine between the normal and that of the edge's plane through the point
    (Lambert 1760; the boundary integral of Sparrow 1963).

    Examples
    --------
    >>> from transport.theory.solid_angles import polygon_projected_solid_angle
    >>> square = [(1.0, 1.0, 1.0), (-1.0, 1.0, 1.0), (-1.0, -1.0, 1.0), (1.0, -1.0, 1.0)]
    >>> print(f"{polygon_projected_solid_angle(square, (0, 0, 1)):.4g}")
    1.741
    >>> print(f"{polygon_projected_solid_angle(square, (1, 0, 0)):.4g}")  # half of it is behind the plane
    0.3502
    """
    across = np.array(normal, float) / np.linalg.norm(normal)
    corners = np.subtract(np.array(vertices, float), position)
    total, before = 0.0, _before_plane(corners, across)
    for start, end in zip(before, np.roll(before, -1, axis=0), strict=True):
        side = np.cross(start, end)
        if (length := np.linalg.norm(side)) > 0:
            total += math.atan2(length, start @ end) * float(side @ across) / length
    return abs(total) / 2


def _before_plane(corners: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Corners of the part of a convex polygon that lies before a plane through the origin."""
    heights, kept = corners @ normal, []
    for here, there, low, high in zip(
        corners, np.roll(corners, -1, axis=0), heights, np.roll(heights, -1), strict=True
    ):
        if low >= 0:
            kept.append(here)
        if (low < 0) != (high < 0):
            kept.append(here + (there - here) * (low / (low - high)))
    return np.array(kept).reshape(-1, 3)


def regular_polygon_solid_angle(sides: int, radius: float, distance: float) -> float:
    """Solid angle of a regular polygon from a point on its axis.

    Parameters
    ----------
    sides : int
        Number n of sides.
    radius : float
        Distance R from the center to the vertices [m].
    distance : float
        Distance d from the polygon's plane [m].

    Returns
    -------
    float
        ``2 pi - 2 n atan(tan(pi/n) d/h)`` with ``h^2 = R^2 + d^2`` [sr].

    Notes
    -----
    Computed as ``2 n atan((1 - k) t / (1 + k t^2))``, t = tan(pi/n), k = d/h, with
    ``1 - k = R^2 / (h (h + d))``. A sum of right-angled triangles (Van Oosterom and Strackee 1983).

    Examples
    --------
    >>> from transport.theory.solid_angles import regular_polygon_solid_angle
    >>> print(f"{regular_polygon_solid_angle(6, 1.0, 1.0):.4g}")
    1.632
    """
    slant, t = math.hypot(radius, distance), math.tan(math.pi / sides)
    k, short = distance / slant, radius / slant * (radius / (slant + distance))
    return 2 * sides * math.atan2(short * t, 1 + k * t * t)


def dodecahedron_faces(radius: float = 1.0) -> np.ndarray:
    """Vertices of the twelve faces of a dodecahedron about the origin.

    Parameters
    ----------
    radius : float, default 1.0
        Distance of the vertices from the origin [m].

    Returns
    -------
    ndarray
        Vertices, shape (12, 5, 3), each face counterclockwise as seen from outside [m].

    Notes
    -----
    The vertices are those of a cube and of three rectangles in the golden ratio (Coxeter 1973, Regular
    Polytopes, 3.7).

    Examples
    --------
    >>> from transport.theory.solid_angles import dodecahedron_faces
    >>> dodecahedron_faces().shape
    (12, 5, 3)
    """
    golden = (1 + math.sqrt(5)) / 2
    signs = [(p, q) for p in (1.0, -1.0) for q in (1.0, -1.0)]
    corners = [(p, q, r) for p, q in signs for r in (1.0, -1.0)]
    corners += [np.roll((0, p / golden, q * golden), turn) for turn in range(3) for p, q in signs]
    corners = np.array(corners) * (radius / math.sqrt(3))
    normals = [np.roll((0, p * golden, q), turn) for turn in range(3) for p, q in signs]
    return np.array([_face(corners, np.array(normal)) for normal in normals])


def _face(corners: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """The five vertices furthest along a normal, in their order around it."""
    five = corners[np.argsort(corners @ normal)[-5:]]
    across = five[0] - five.mean(axis=0)
    along = np.cross(normal / np.linalg.norm(normal), across)
    return five[np.argsort(np.arctan2(five @ along, five @ across))]


def _seen_from(position: Point, vertices: Sequence[Point]) -> list[list[Fraction]]:
    """Vertices relative to the position, exactly, in units of their largest coordinate."""
    origin = [Fraction(float(p)) for p in position]
    offsets = [[Fraction(float(x)) - p for x, p in zip(vertex, origin, strict=True)] for vertex in vertices]
    largest = max(abs(x) for offset in offsets for x in offset) or Fraction(1)
    return [[x / largest for x in offset] for offset in offsets]


def _signed(triangle: Sequence[Sequence[Fraction]]) -> float:
    """Solid angle, positive if the vertices run clockwise as seen from the origin."""
    a, b, c = _widest_first(triangle)
    length_a, length_b, length_c = (_root(_dot(v, v)) for v in (a, b, c))
    above = float(_dot(a, _cross(b, c)))
    ab, ac, bc = _dot(a, b), _dot(a, c), _dot(b, c)
    below = length_c * _sum(length_a * length_b, 1.0, Fraction(1), ab, _dot(a, a) * _dot(b, b) - ab * ab)
    below += _sum(length_b, length_a, ac, bc, ac * ac * _dot(b, b) - bc * bc * _dot(a, a))
    return 2 * math.atan2(above, below) if above or below else math.nan


def _widest_first(triangle: Sequence[Sequence[Fraction]]) -> Sequence[Sequence[Fraction]]:
    """Vertices rotated so that the first two are those furthest apart in direction."""
    turned = [(*triangle[k:], *triangle[:k]) for k in range(3)]

    def cosine(turn: Sequence[Sequence[Fraction]]) -> float:
        """Cosine between the first two vertices."""
        a, b, _ = turn
        lengths = _root(_dot(a, a)) * _root(_dot(b, b))
        return float(_dot(a, b)) / lengths if lengths else 1.0

    return min(turned, key=cosine)


def _sum(first: float, second: float, p: Fraction, q: Fraction, squares: Fraction) -> float:
    """p first + q second; squares: the exact difference of their squares, for terms of opposite signs."""
    x, y = float(p) * first, float(q) * second
    return x + y if x * y >= 0 else float(squares) / (x - y)


def _root(square: Fraction) -> float:
    return math.sqrt(float(square))


def _dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((p * q for p, q in zip(a, b, strict=True)), Fraction(0))


def _cross(a: Sequence[Fraction], b: Sequence[Fraction]) -> list[Fraction]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


# ---- The oblique prism in front of a patch, which holds the particles that will cross it.
#
# Source: Hanrahan 2001, Stanford CS 348B, lecture 4.


def in_oblique_prism(center, frame, sides, path, places) -> np.ndarray:
    """Return whether points lie in the oblique prism on a rectangle, on either side of it.

    Parameters
    ----------
    center : array_like
        Center of the rectangle, shape (3,).
    frame : array_like
        Its unit vectors e_u, e_v and n, shape (3, 3).
    sides : sequence of 2 float
        Its side lengths along e_u and e_v.
    path : array_like
        v dt, the edge of the prism, shape (3,), or one per point, shape (N, 3).
    places : array_like
        Points, shape (N, 3). All lengths are in the same unit.

    Returns
    -------
    ndarray
        Booleans, shape (N,).

    Notes
    -----
    A point is x = p - s path with p on the rectangle and 0 < s <= 1: the particle is at p after s dt.
    If the path is parallel to the rectangle the prism has no volume and holds no point.

    Examples
    --------
    >>> from transport.theory.solid_angles import in_oblique_prism
    >>> frame = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    >>> points = [(0.0, 0.0, -0.5), (2.0, 0.0, -0.5)]
    >>> in_oblique_prism((0.0, 0.0, 0.0), frame, (1.0, 1.0), (0.0, 0.0, 1.0), points).tolist()
    [True, False]
    """
    e_u, e_v, normal = np.asarray(frame, dtype=float)
    offset, path = np.subtract(places, center), np.asarray(path, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = -(offset @ normal) / (path @ normal)
        foot = offset + s[:, None] * path
        u, v = np.abs(foot @ e_u), np.abs(foot @ e_v)
    return (u <= sides[0] / 2) & (v <= sides[1] / 2) & (0 < s) & (s <= 1)


# ---- A diffuse disk seen from a point in sectors of azimuth: distribution of its light over directions.
#
# The disk, of radius R, is parallel to the receiver at the distance d; its center is at the distance
# s > R from the receiver's axis and at the azimuth 0. For ``|φ| < asin(R/s)`` the half plane of azimuth φ
# cuts it from ρ₁ to ρ₂ = s cosφ ± √(R² − s² sin²φ), and ∫ L cosθ dω = (L/2) ∫ (sin²θ₂ − sin²θ₁) dφ with
# sin²θ = ρ² / (ρ² + d²).

NODES = 24


def projected_solid_angle_in(
    phi_edges: np.ndarray, radius: float, offset: float, distance: float
) -> np.ndarray:
    """Projected solid angle of the part of the disk in each bin of azimuth.

    Parameters
    ----------
    phi_edges : ndarray
        Edges of the bins of azimuth from the disk's center, within −π to π, shape (bins + 1,) [rad].
    radius : float
        Radius R of the disk [m].
    offset : float
        Distance s of the disk's center from the receiver's axis, above R [m].
    distance : float
        Distance d between the planes [m].

    Returns
    -------
    ndarray
        Projected solid angles, shape (bins,) [sr].

    Raises
    ------
    ValueError
        If the offset does not exceed the radius.

    Notes
    -----
    Gauss-Legendre over ψ with ``φ = asin(R/s sin ψ)``, in which the integrand is smooth up to the rim.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.solid_angles import projected_solid_angle_in
    >>> print(projected_solid_angle_in(np.array([-0.5, 0.0, 0.5]), 1.0, 2.0, 2.0).round(4))
    [0.1022 0.1022]
    """
    return _over_sectors(phi_edges, radius, offset, distance, 1)


def squared_weights_in(phi_edges: np.ndarray, radius: float, offset: float, distance: float) -> np.ndarray:
    """Integral of G² over the part of the disk in each bin of azimuth, G = cosθ cosθ' / r².

    Parameters
    ----------
    phi_edges : ndarray
        Edges of the bins of azimuth from the disk's center, within −π to π, shape (bins + 1,) [rad].
    radius : float
        Radius R of the disk [m].
    offset : float
        Distance s of the disk's center from the receiver's axis, above R [m].
    distance : float
        Distance d between the planes [m].

    Returns
    -------
    ndarray
        ``∫ G² dA``, shape (bins,) [sr^2 m^-2].

    Raises
    ------
    ValueError
        If the offset does not exceed the radius.

    Notes
    -----
    It determines the variance of the weights of particles that are born uniformly over the disk and
    aimed at the receiver.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.solid_angles import squared_weights_in
    >>> print(squared_weights_in(np.array([-0.5, 0.0, 0.5]), 1.0, 2.0, 2.0).round(4))
    [0.0084 0.0084]
    """
    return _over_sectors(phi_edges, radius, offset, distance, 2)


def projected_solid_angle_a_radian(phi: float, radius: float, offset: float, distance: float) -> float:
    """Projected solid angle of the disk per radian of azimuth.

    Parameters
    ----------
    phi : float or ndarray
        Azimuth φ from the disk's center [rad].
    radius : float
        Radius R of the disk [m].
    offset : float
        Distance s of the disk's center from the receiver's axis, above R [m].
    distance : float
        Distance d between the planes [m].

    Returns
    -------
    float or ndarray
        Projected solid angle per azimuth [sr/rad].

    Examples
    --------
    >>> from transport.theory.solid_angles import projected_solid_angle_a_radian
    >>> print(f"{projected_solid_angle_a_radian(0.1, 1.0, 2.0, 2.0):.4g}")
    0.2424
    """
    sine = np.minimum(offset / radius * np.abs(np.sin(phi)), 1.0)
    near, far = _cuts(np.cos(phi), np.sqrt(1 - sine**2), radius, offset)
    return _along_ray(near, far, distance, 1)


def sector_moments(
    low: np.ndarray,
    high: np.ndarray,
    mu_range: tuple[float, float],
    middles: Sequence[float],
    radiance: float,
    radius: float,
    offset: float,
    distance: float,
) -> Moments:
    """Moments of the mean radiance over sectors of azimuth, counted by rays aimed at the receiver.

    Parameters
    ----------
    low : ndarray
        Lower azimuth of each sector, shape (n,) [rad].
    high : ndarray
        Upper azimuth of each sector, shape (n,) [rad].
    mu_range : tuple of 2 float
        Range of cosines of the sectors, which contains all disks [1].
    middles : sequence of float
        Azimuths of the disks' centers; each disk has an equal number of histories, born uniformly over
        it [rad].
    radiance : float
        Radiance L of the disks [W m^-2 sr^-1].
    radius : float
        Radius R of the disk [m].
    offset : float
        Distance s of the disk's center from the receiver's axis, above R [m].
    distance : float
        Distance d between the planes [m].

    Returns
    -------
    Moments
        Means [W m^-2 sr^-1] and the terms of their variances, shape (n,).

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.solid_angles import sector_moments
    >>> disk = (1.0, 2.0, 2.0)
    >>> print(sector_moments(np.array([-0.5]), np.array([0.5]), (0.0, 1.0), [0.0], 1.0, *disk).mean.round(4))
    [0.4089]
    """
    disk, area = (radius, offset, distance), math.pi * radius**2
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    solid_angle = (high - low) * (mu_range[1] ** 2 - mu_range[0] ** 2) / 2
    parts = np.zeros((3, len(low)))
    for middle in middles:
        edges = list(zip(low - middle, high - middle, strict=True))
        first = (
            np.array([projected_solid_angle_in(pair, *disk)[0] for pair in edges]) * radiance / solid_angle
        )
        second = np.array([squared_weights_in(pair, *disk)[0] for pair in edges])
        second *= (radiance / solid_angle) ** 2 * area
        parts += np.array([first, len(middles) * second, len(middles) * first**2])
    return Moments(*parts)


def _over_sectors(phi_edges, radius, offset, distance, power):
    if not offset > radius:
        raise ValueError(f"offset must exceed the disk's radius {radius}, got {offset}")
    slope = radius / offset
    sines = np.sin(np.clip(phi_edges, -math.asin(slope), math.asin(slope))) / slope
    psi = np.arcsin(np.clip(sines, -1.0, 1.0))
    x, weight = legendre_nodes(NODES)
    half = np.diff(psi)[:, None] / 2
    nodes = (psi[1:] + psi[:-1])[:, None] / 2 + half * x
    cosine = np.sqrt(1 - (slope * np.sin(nodes)) ** 2)  # of φ
    near, far = _cuts(cosine, np.cos(nodes), radius, offset)
    return (_along_ray(near, far, distance, power) * slope * np.cos(nodes) / cosine * half) @ weight


def _cuts(cosine, half_chord, radius, offset):
    """Distances from the axis at which the half plane enters and leaves the disk [m]; half_chord in radii."""
    return offset * cosine - radius * half_chord, offset * cosine + radius * half_chord


def _along_ray(near, far, distance, power):
    """∫ G^power ρ dρ from near to far: with q = cos²θ, (q₁ − q₂)/2 or (q₁³ − q₂³) / 6d²."""
    q1, q2 = (distance**2 / (rho**2 + distance**2) for rho in (near, far))
    if power == 1:
        return (q1 - q2) / 2
    return (q1 - q2) * (q1 * q1 + q1 * q2 + q2 * q2) / (6 * distance**2)
