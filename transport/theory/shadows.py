"""Shadows under a diffuse disk: irradiance behind a straight edge and behind a cylinder, and means over bins across them.

The disk, of radius R, lies in the plane z = 0 about the origin; irradiance is sought in the plane z = distance.  What
casts the shadow is as long as all sight lines along y, so that from (x, y, distance) a strip low < X < high of the disk
is hidden, whatever y.  For an edge, x < 0 opaque in the plane z = gap, the strip is all of X < -x s/(1 - s), with
s = gap/distance; for a cylinder along y it lies between the two planes through the point that touch it.  Two segments
of the disk are left, X > high and X < low.  The projected solid angle of a patch in a plane parallel to the receiver is
a contour integral (Lambert 1760; Sparrow 1963, J. Heat Transfer 85, 81),

    P = ½ ∮ (ρ × dρ)_z / (ρ² + d²),   ρ: from the foot of the receiver's point to the contour,

which is a closed form for the arc of the disk's rim as for the chord; E = L P.  For the whole disk it is Foote's
(pi/2)(1 - T/S).  Means over bins are Gauss-Legendre sums of it, cut where the strip's sides pass the disk's rim: there
P takes the power 3/2.  Rounding is 1e-16 of a hemisphere's pi.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from transport.theory.nodes import legendre_nodes

ACROSS, ALONG = 16, 12  # nodes over a piece of a bin: across the shadow, along it

Strip = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def segment_projected_solid_angle(cut: float, x: float, y: float, radius: float, distance: float) -> float:
    """Projected solid angle of the disk's part X > cut, seen from a parallel receiver at (x, y, distance) [sr].

    The whole disk where cut <= -R, 0 where cut >= R.  Vectorised.  Source: the contour integral above.
    """
    half = np.arccos(np.clip(np.divide(cut, radius), -1.0, 1.0))  # of the rim's arc
    chord = radius * np.sin(half)
    offset, turn = np.hypot(x, y), np.arctan2(y, x)
    near, far = np.hypot(offset - radius, distance), np.hypot(offset + radius, distance)
    swept = _swept(half, turn, near, far) - _swept(-half, turn, near, far)
    arc = half - ((offset - radius) * (offset + radius) + distance**2) / (near * far) * swept
    aside = np.clip(cut, -radius, radius) - x
    slant = np.hypot(aside, distance)
    straight = aside / slant * (np.arctan2(chord - y, slant) + np.arctan2(chord + y, slant))
    return np.where(np.less(cut, radius), (arc - straight) / 2, 0.0)[()]


def _swept(angle, turn, near, far):
    """Integral of near far / 2 over the squared distance to the rim, up to an angle on it; continuous in (-2 pi, 2 pi)."""
    half = (angle - turn) / 2
    return np.arctan2(far * np.sin(half), near * np.cos(half))


def lit_projected_solid_angle(strip: Strip, x: float, y: float, radius: float, distance: float) -> float:
    """Projected solid angle of what is seen of the disk beside the strip that is hidden [sr].  Vectorised."""
    low, high = strip(np.asarray(x, dtype=float))
    right = segment_projected_solid_angle(high, x, y, radius, distance)
    return right + segment_projected_solid_angle(np.negative(low), np.negative(x), y, radius, distance)


def behind_edge(gap: float, distance: float) -> Strip:
    """The strip (low, high) that an edge hides from x [m]: all of X < -x s/(1 - s), s = gap/distance."""
    return lambda x: (np.full_like(x, -np.inf), -x * (gap / (distance - gap)))


def behind_cylinder(thickness: float, gap: float, distance: float) -> Strip:
    """The strip (low, high) that a cylinder along y hides from x [m]; its axis runs through (0, gap).

    thickness: its radius [m].  The planes that touch it make the angle asin(thickness/D) with the one through its
    axis, D = hypot(x, distance - gap).
    """
    return lambda x: tuple(x + distance * tangent for tangent in _tangents(x, thickness, distance - gap))


def edge_borders(radius: float, gap: float, distance: float) -> np.ndarray:
    """Where the shadow of an edge begins and where it ends [m], (2,): -+ R (1 - s)/s; umbra, penumbra, full light."""
    return np.array([-1.0, 1.0]) * radius * ((distance - gap) / gap)


def cylinder_borders(radius: float, thickness: float, gap: float, distance: float) -> np.ndarray:
    """Borders of a cylinder's shadow [m], (4,), increasing: penumbra from the first, umbra between the middle two.

    Where no umbra reaches so far both sides of the disk are seen between these two (antumbra).
    """
    _, right = _tangents(np.array([-radius, radius]), thickness, gap)
    beyond, within = np.array([-radius, radius]) + distance * right
    return np.sort([-beyond, -within, within, beyond])


def has_umbra(radius: float, thickness: float, gap: float, distance: float) -> bool:
    """Whether a cylinder's umbra reaches the receiver: past its far side a ray from the rim comes beyond the middle."""
    _, right = _tangents(np.array(radius), thickness, gap)
    return bool(radius + distance * right > 0)


def _tangents(x, thickness, height):
    """Tangents of the angles, to the normal, of the planes from x that touch the cylinder at that height: left, right."""
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
    """Means of the projected solid angle of what is seen of the disk, over bins across the shadow [sr], (bins,).

    x_edges, y_range: of the bins [m]; borders: where the strip's sides pass the rim [m].  Times L it is the mean
    irradiance of a bin.  x = low + (high - low) sin² within a piece, as P has half-odd powers at its ends.
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
