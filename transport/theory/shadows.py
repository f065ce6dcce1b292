"""Shadows under a diffuse disk: irradiance behind a straight edge and behind a cylinder.

The disk, of radius R, lies in the plane z = 0 about the origin; irradiance is computed in the plane
z = distance. The obstacle extends along y beyond all lines of sight, so that from (x, y, distance) a
strip low < X < high of the disk is hidden, whatever y. For an edge, x < 0 opaque in the plane z = gap,
the strip is all of X < -x s/(1 - s), with s = gap/distance; for a cylinder along y it lies between the
two tangent planes through the point. The two segments X > high and X < low of the disk remain visible.
The projected solid angle of a patch in a plane parallel to the receiver is a contour integral (Lambert
1760; Sparrow 1963, J. Heat Transfer 85, 81),

    P = ½ ∮ (ρ × dρ)_z / (ρ² + d²),   ρ: from the projection of the receiver's point to the contour,

which has a closed form for the arc of the disk's rim and for the chord; E = L P. For the whole disk it
is Foote's (pi/2)(1 - T/S). Means over bins are Gauss-Legendre sums of it, split where the strip's sides
pass the disk's rim: there P varies with the power 3/2. Rounding is 1e-16 of a hemisphere's pi.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from transport.statistics.quadrature import legendre_nodes
from transport.theory.counting import Moments

ACROSS, ALONG = 16, 12  # nodes per piece of a bin, across and along the shadow

Strip = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def segment_projected_solid_angle(cut: float, x: float, y: float, radius: float, distance: float) -> float:
    """Projected solid angle of the part X > cut of the disk at a parallel receiver at (x, y, distance).

    Parameters
    ----------
    cut : float or ndarray
        Position of the chord [m]: the whole disk for cut <= -R, nothing for cut >= R.
    x : float or ndarray
        Position of the receiver across the shadow [m].
    y : float or ndarray
        Position of the receiver along the shadow [m].
    radius : float or ndarray
        Radius R of the disk [m].
    distance : float or ndarray
        Distance of the receiver's plane from the disk [m].

    Returns
    -------
    float or ndarray
        Projected solid angle [sr].

    Notes
    -----
    Source: the contour integral in the module's docstring (Lambert 1760; Sparrow 1963).

    Examples
    --------
    >>> from transport.theory.shadows import segment_projected_solid_angle
    >>> print(f"{segment_projected_solid_angle(0.0, 0.0, 0.0, 1.0, 2.0):.4g}")
    0.3142
    """
    half = np.arccos(np.clip(np.divide(cut, radius), -1.0, 1.0))  # half angle of the rim's arc
    chord = radius * np.sin(half)
    offset, turn = np.hypot(x, y), np.arctan2(y, x)
    near, far = np.hypot(offset - radius, distance), np.hypot(offset + radius, distance)
    swept = _rim_integral(half, turn, near, far) - _rim_integral(-half, turn, near, far)
    arc = half - ((offset - radius) * (offset + radius) + distance**2) / (near * far) * swept
    across = np.clip(cut, -radius, radius) - x
    slant = np.hypot(across, distance)
    straight = across / slant * (np.arctan2(chord - y, slant) + np.arctan2(chord + y, slant))
    return np.where(np.less(cut, radius), (arc - straight) / 2, 0.0)[()]


def _rim_integral(angle, turn, near, far):
    """Integral of near far / 2 over the squared distance to the rim, up to an angle in (-2 pi, 2 pi)."""
    half = (angle - turn) / 2
    return np.arctan2(far * np.sin(half), near * np.cos(half))


def lit_projected_solid_angle(strip: Strip, x: float, y: float, radius: float, distance: float) -> float:
    """Projected solid angle of the visible part of the disk beside a hidden strip.

    Parameters
    ----------
    strip : callable
        Function of x that returns the hidden strip (low, high) [m], from `behind_edge` or
        `behind_cylinder`.
    x : float or ndarray
        Position of the receiver across the shadow [m].
    y : float or ndarray
        Position of the receiver along the shadow [m].
    radius : float or ndarray
        Radius R of the disk [m].
    distance : float or ndarray
        Distance of the receiver's plane from the disk [m].

    Returns
    -------
    float or ndarray
        Projected solid angle [sr].

    Examples
    --------
    >>> from transport.theory.shadows import behind_edge, lit_projected_solid_angle
    >>> print(f"{lit_projected_solid_angle(behind_edge(1.0, 2.0), 0.0, 0.0, 1.0, 2.0):.4g}")
    0.3142
    """
    low, high = strip(np.asarray(x, dtype=float))
    right = segment_projected_solid_angle(high, x, y, radius, distance)
    return right + segment_projected_solid_angle(np.negative(low), np.negative(x), y, radius, distance)


def behind_edge(gap: float, distance: float) -> Strip:
    """Return the function that gives the strip hidden by an edge.

    Parameters
    ----------
    gap : float
        Distance of the obstacle from the disk [m].
    distance : float
        Distance of the receiver's plane from the disk [m].

    Returns
    -------
    callable
        Function of x [m] that returns (low, high) [m]: all of ``X < -x s/(1 - s)``, s = gap/distance.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.shadows import behind_edge
    >>> behind_edge(1.0, 3.0)(np.array([1.0]))
    (array([-inf]), array([-0.5]))
    """
    return lambda x: (np.full_like(x, -np.inf), -x * (gap / (distance - gap)))


def behind_cylinder(thickness: float, gap: float, distance: float) -> Strip:
    """Return the function that gives the strip hidden by a cylinder along y with its axis through (0, gap).

    Parameters
    ----------
    thickness : float
        Radius of the cylinder [m].
    gap : float
        Distance of the obstacle from the disk [m].
    distance : float
        Distance of the receiver's plane from the disk [m].

    Returns
    -------
    callable
        Function of x [m] that returns (low, high) [m].

    Notes
    -----
    The tangent planes make the angle ``asin(thickness/D)`` with the plane through the axis,
    D = hypot(x, distance - gap).

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.shadows import behind_cylinder
    >>> print(behind_cylinder(0.1, 1.0, 3.0)(np.array([0.0]))[1].round(4))
    [0.1502]
    """
    return lambda x: tuple(x + distance * tangent for tangent in _tangents(x, thickness, distance - gap))


def edge_borders(radius: float, gap: float, distance: float) -> np.ndarray:
    """Borders of an edge's shadow: umbra below the first, full light above the second, penumbra between.

    Parameters
    ----------
    radius : float
        Radius R of the disk [m].
    gap : float
        Distance of the obstacle from the disk [m].
    distance : float
        Distance of the receiver's plane from the disk [m].

    Returns
    -------
    ndarray
        ``-+ R (1 - s)/s`` with s = gap/distance, shape (2,) [m].

    Examples
    --------
    >>> from transport.theory.shadows import edge_borders
    >>> print(edge_borders(0.1, 1.0, 3.0).round(4))
    [-0.2  0.2]
    """
    return np.array([-1.0, 1.0]) * radius * ((distance - gap) / gap)


def cylinder_borders(radius: float, thickness: float, gap: float, distance: float) -> np.ndarray:
    """Borders of a cylinder's shadow: penumbra between the outer two, umbra between the inner two.

    Parameters
    ----------
    radius : float
        Radius R of the disk [m].
    thickness : float
        Radius of the cylinder [m].
    gap : float
        Distance of the obstacle from the disk [m].
    distance : float
        Distance of the receiver's plane from the disk [m].

    Returns
    -------
    ndarray
        Borders, increasing, shape (4,) [m]. If the umbra does not reach the receiver, both sides of the
        disk are visible between the inner two (antumbra).

    Examples
    --------
    >>> from transport.theory.shadows import cylinder_borders
    >>> print(cylinder_borders(0.1, 0.1, 1.0, 3.0).round(4))
    [-0.5061 -0.1     0.1     0.5061]
    """
    _, right = _tangents(np.array([-radius, radius]), thickness, gap)
    beyond, within = np.array([-radius, radius]) + distance * right
    return np.sort([-beyond, -within, within, beyond])


def has_umbra(radius: float, thickness: float, gap: float, distance: float) -> bool:
    """Return whether a cylinder's umbra reaches the receiver.

    Parameters
    ----------
    radius : float
        Radius R of the disk [m].
    thickness : float
        Radius of the cylinder [m].
    gap : float
        Distance of the obstacle from the disk [m].
    distance : float
        Distance of the receiver's plane from the disk [m].

    Returns
    -------
    bool
        True if the ray from the rim past the far side of the cylinder ends beyond the center of the
        shadow.

    Examples
    --------
    >>> from transport.theory.shadows import has_umbra
    >>> has_umbra(0.1, 0.1, 1.0, 3.0)
    True
    """
    _, right = _tangents(np.array(radius), thickness, gap)
    return bool(radius + distance * right > 0)


def _tangents(x, thickness, height):
    """Tangents of the angles to the normal of the two planes from x that touch the cylinder: left, right."""
    middle, half = np.arctan2(-x, height), np.arcsin(thickness / np.hypot(x, height))
    return np.tan(middle - half), np.tan(middle + half)


def mean_lit_projected_solid_angles(
    strip: Strip,
    borders: np.ndarray,
    x_edges: np.ndarray,
    y_range: tuple[float, float],
    radius: float,
    distance: float,
) -> np.ndarray:
    """Means of the projected solid angle of the visible part of the disk, over bins across the shadow.

    Parameters
    ----------
    strip : callable
        Function of x that returns the hidden strip (low, high) [m], from `behind_edge` or
        `behind_cylinder`.
    borders : ndarray
        Positions at which the strip's sides pass the rim, from `edge_borders` or `cylinder_borders`
        [m].
    x_edges : ndarray
        Edges of the bins across the shadow, increasing, shape (bins + 1,) [m].
    y_range : tuple of 2 float
        Range of the bins along the shadow [m].
    radius : float
        Radius R of the disk [m].
    distance : float
        Distance of the receiver's plane from the disk [m].

    Returns
    -------
    ndarray
        Means, shape (bins,) [sr]; times L the mean irradiance of a bin.

    Notes
    -----
    Substitutes ``x = low + (high - low) sin²`` within a piece, because P has half-odd powers at its
    ends.

    Examples
    --------
    >>> from transport.theory.shadows import behind_edge, edge_borders, mean_lit_projected_solid_angles
    >>> strip, borders = behind_edge(1.0, 3.0), edge_borders(0.1, 1.0, 3.0)
    >>> print(mean_lit_projected_solid_angles(strip, borders, [-0.1, 0.1], (-0.1, 0.1), 0.1, 3.0).round(4))
    [0.0017]
    """
    t, weight_t = _nodes(0.0, np.pi / 2, ACROSS)
    y, weight_y = _nodes(*y_range, ALONG)
    x_edges, means = np.asarray(x_edges, dtype=float), []
    for low, high in zip(x_edges[:-1], x_edges[1:], strict=True):
        cuts = np.unique(np.clip([low, *borders, high], low, high))
        start, width = cuts[:-1, None], np.diff(cuts)[:, None]
        x, weight_x = start + width * np.sin(t) ** 2, width * (np.sin(2 * t) * weight_t)
        lit = lit_projected_solid_angle(strip, x.ravel()[:, None], y, radius, distance)
        means.append(weight_x.ravel() @ lit @ weight_y / (high - low) / (y_range[1] - y_range[0]))
    return np.array(means)


def _nodes(low: float, high: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    x, weight = legendre_nodes(count)
    return (low + high) / 2 + (high - low) / 2 * x, weight * (high - low) / 2


# ---- Penumbra of a straight edge in front of a diffuse disk, and means over bins across it.
#
# The disk, of radius R and radiance L, lies in the plane z = 0 about the origin. In the plane z = gap the
# half plane x < 0 is opaque. Irradiance is computed in the plane z = distance. The ray from (X, Y, 0) to
# (x, y, distance) passes where X (1 − s) + x s > 0, s = gap / distance: the visible part is X > −x s / (1
# − s), bounded by a straight chord, and
#
#     E(x, y) = L ∫ G dX dY over it,   G = cosθ cosθ' / r² = d² / ((x − X)² + (y − Y)² + d²)²,   d = distance.
#
# The penumbra is ``|x| < R (1 − s) / s``. If the disk subtends a small angle, G is constant and E is
# proportional to the visible fraction of the disk.

PENUMBRA_ACROSS, PENUMBRA_ALONG = (
    24,
    8,
)  # nodes over the disk, across and along the edge; ALONG also over a bin


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
    >>> from transport.theory.shadows import visible_fraction
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
    >>> from transport.theory.shadows import half_width
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
    >>> from transport.theory.shadows import geometry_means
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
    >>> from transport.theory.shadows import geometry_at
    >>> print(f"{geometry_at(0.0, (-0.1, 0.1), 0.5, 1.0, 3.0):.4g}")
    0.04242
    """
    y, weight = _nodes(*y_range, PENUMBRA_ALONG)
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
    >>> from transport.theory.shadows import penumbra_moments
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
    t, weight = _nodes(0.0, np.pi / 2, PENUMBRA_ALONG)
    x, weight = low + (high - low) * np.sin(t) ** 2, weight * (high - low) * np.sin(2 * t)
    y, weight_y = _nodes(*y_range, PENUMBRA_ALONG)
    return weight @ _over_disk(x, y, radius, gap, distance, power) @ weight_y / (y_range[1] - y_range[0])


def _over_disk(x, y, radius, gap, distance, power):
    """∫ G^power over the visible part of the disk, shape (x, y).

    With X = R sin a, Y = R cos a sin b, it is smooth up to the rim.
    """
    share = gap / distance
    first = np.arcsin(np.clip(-x * share / (1 - share) / radius, -1.0, 1.0))
    t, weight_a = _nodes(0.0, 1.0, PENUMBRA_ACROSS)
    a = first[:, None] + (np.pi / 2 - first[:, None]) * t
    weight_a = weight_a * (np.pi / 2 - first[:, None]) * (radius * np.cos(a))
    b, weight_b = _nodes(-np.pi / 2, np.pi / 2, PENUMBRA_ALONG)
    big_x = (radius * np.sin(a))[:, None, :, None]
    chord = (radius * np.cos(a))[:, None, :, None]
    big_y = chord * np.sin(b)
    square = (x[:, None, None, None] - big_x) ** 2 + (y[:, None, None] - big_y) ** 2 + distance**2
    g = (distance / square) ** (2 * power)
    inner = (g * (chord * np.cos(b) * weight_b)).sum(axis=-1)
    return (inner * weight_a[:, None, :]).sum(axis=-1)
