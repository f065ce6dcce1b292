"""View factors F12 of round surfaces: spheres, insides of tubes and cones, coaxial cylinders [1].

Numbers such as C-136 refer to Howell, A Catalog of Radiation Heat Transfer Configuration Factors. A1
F12 = A2 F21; the factors from a surface to a closed enclosure add up to 1.
"""

from __future__ import annotations

import math

import numpy as np

from transport.statistics.quadrature import legendre_nodes
from transport.theory.view_factors import coaxial_disks

NODES = 40  # nodes of the integral for two spheres


def sphere_to_disk(radius: float, distance: float) -> float:
    """View factor F12 from a sphere to a coaxial disk.

    Parameters
    ----------
    radius : float or ndarray
        Radius R of the disk [m].
    distance : float or ndarray
        Distance h of the disk from the sphere's center [m].

    Returns
    -------
    float or ndarray
        ``(1/2) [1 - 1/sqrt(1 + (R/h)^2)]`` [1], for any radius of the sphere.

    Notes
    -----
    Howell, C-136: a diffuse sphere has the same intensity in all directions. Computed as
    ``(R/h)^2 / (2 k (1 + k))`` with k = sqrt(1 + (R/h)^2).

    Examples
    --------
    >>> from transport.theory.round_view_factors import sphere_to_disk
    >>> print(f"{sphere_to_disk(1.0, 2.0):.4g}")
    0.05279
    """
    ratio = np.divide(radius, distance)
    k = np.hypot(1.0, ratio)
    return ratio / k * (ratio / (1 + k)) / 2


def spheres(radius_1: float, radius_2: float, distance: float) -> float:
    """View factor F12 between two spheres, which has no closed form.

    Parameters
    ----------
    radius_1 : float
        Radius of sphere 1 [m].
    radius_2 : float
        Radius of sphere 2 [m].
    distance : float
        Distance D between the centers, at least the sum of the radii [m].

    Returns
    -------
    float
        F12 [1], good to 1e-11.

    Notes
    -----
    The mean over the smaller sphere of an element's view factor to the other: (r/D)^2 cos where the
    element sees the whole sphere, less where its horizon cuts it (Juul 1976). Gauss-Legendre on both
    sides of the onset of the cut.

    Examples
    --------
    >>> from transport.theory.round_view_factors import spheres
    >>> print(f"{spheres(1.0, 1.0, 3.0):.4g}")
    0.02959
    """
    small, large = sorted((radius_1, radius_2))
    low, high = (small - large) / distance, (small + large) / distance
    ends = (max(low, -1.0), high, 1.0)
    factor = sum(
        _over_sphere(small, large, distance, *part) for part in zip(ends[:-1], ends[1:], strict=True)
    )
    return factor * (small / radius_1) ** 2


def base_to_base(radius: float, height: float) -> float:
    """View factor F12 from one end of a tube to the other.

    Parameters
    ----------
    radius : float or ndarray
        Radius R [m].
    height : float or ndarray
        Height h [m].

    Returns
    -------
    float or ndarray
        ``(2 R / (p + h))^2`` with ``p^2 = h^2 + 4 R^2`` [1].

    Notes
    -----
    Source: Howell, C-41.

    Examples
    --------
    >>> from transport.theory.round_view_factors import base_to_base
    >>> print(f"{base_to_base(1.0, 2.0):.4g}")
    0.1716
    """
    return coaxial_disks(radius, radius, height)


def base_to_side(radius: float, height: float) -> float:
    """View factor F12 from one end of a tube to its wall.

    Parameters
    ----------
    radius : float or ndarray
        Radius R [m].
    height : float or ndarray
        Height h [m].

    Returns
    -------
    float or ndarray
        ``2 h / (p + h)`` with ``p^2 = h^2 + 4 R^2`` [1]; 1 - base_to_base without the difference.

    Examples
    --------
    >>> from transport.theory.round_view_factors import base_to_side
    >>> print(f"{base_to_side(1.0, 2.0):.4g}")
    0.8284
    """
    return 2 * np.divide(height, np.hypot(height, 2 * np.asarray(radius, dtype=float)) + height)


def side_to_base(radius: float, height: float) -> float:
    """View factor F12 from the inside of a tube's wall to one end.

    Parameters
    ----------
    radius : float or ndarray
        Radius R [m].
    height : float or ndarray
        Height h [m].

    Returns
    -------
    float or ndarray
        ``R / (p + h)`` with ``p^2 = h^2 + 4 R^2`` [1].

    Examples
    --------
    >>> from transport.theory.round_view_factors import side_to_base
    >>> print(f"{side_to_base(1.0, 2.0):.4g}")
    0.2071
    """
    return np.divide(radius, np.hypot(height, 2 * np.asarray(radius, dtype=float)) + height)


def side_to_side(radius: float, height: float) -> float:
    """View factor F11 from the inside of a tube's wall to itself.

    Parameters
    ----------
    radius : float or ndarray
        Radius R [m].
    height : float or ndarray
        Height h [m].

    Returns
    -------
    float or ndarray
        ``1 - 2 side_to_base`` [1].

    Notes
    -----
    Computed as ``(h/R) (1 + h/(p + 2 R)) / ((p + h)/R)``, which does not cancel for short tubes.

    Examples
    --------
    >>> from transport.theory.round_view_factors import side_to_side
    >>> print(f"{side_to_side(1.0, 2.0):.4g}")
    0.5858
    """
    p = np.hypot(height, 2 * np.asarray(radius, dtype=float))
    return height * (1 + height / (p + 2 * radius)) / (p + height)


def cone_to_base(radius: float, height: float) -> float:
    """View factor F12 from the inside of a cone to its base.

    Parameters
    ----------
    radius : float or ndarray
        Radius R of the base [m].
    height : float or ndarray
        Height h [m].

    Returns
    -------
    float or ndarray
        R over the slant height: the sine of the half apex angle [1].

    Examples
    --------
    >>> from transport.theory.round_view_factors import cone_to_base
    >>> print(f"{cone_to_base(1.0, 2.0):.4g}")
    0.4472
    """
    return np.divide(radius, np.hypot(radius, height))


def cone_to_itself(radius: float, height: float) -> float:
    """View factor F11 from the inside of a cone to itself.

    Parameters
    ----------
    radius : float or ndarray
        Radius R of the base [m].
    height : float or ndarray
        Height h [m].

    Returns
    -------
    float or ndarray
        ``1 - cone_to_base = h^2 / (l (l + R))``, l the slant height [1].

    Examples
    --------
    >>> from transport.theory.round_view_factors import cone_to_itself
    >>> print(f"{cone_to_itself(1.0, 2.0):.4g}")
    0.5528
    """
    slant = np.hypot(radius, height)
    return height / slant * (height / (slant + radius))


def sphere_to_patch(area_share: float) -> float:
    """View factor F12 from the inside of a sphere, or any part of it, to any part of it.

    Parameters
    ----------
    area_share : float
        Share of the sphere's area of the receiving part [1].

    Returns
    -------
    float
        That share [1].

    Notes
    -----
    A hemisphere receives half of its own emission, and its base the other half.

    Examples
    --------
    >>> from transport.theory.round_view_factors import sphere_to_patch
    >>> print(f"{sphere_to_patch(0.25):.4g}")
    0.25
    """
    return area_share


def outer_sphere_to_inner(inner: float, outer: float) -> float:
    """View factor F21 from the inside of a sphere to a smaller sphere inside, concentric or not.

    Parameters
    ----------
    inner : float
        Radius of the inner surface [m].
    outer : float
        Radius of the outer surface [m].

    Returns
    -------
    float
        ``(r1/r2)^2`` [1]; the rest falls on the outer sphere itself.

    Examples
    --------
    >>> from transport.theory.round_view_factors import outer_sphere_to_inner
    >>> print(f"{outer_sphere_to_inner(1.0, 2.0):.4g}")
    0.25
    """
    return np.divide(inner, outer) ** 2


def outer_cylinder_to_inner(inner: float, outer: float, height: float) -> float:
    """View factor F21 from the inside of a cylinder to a coaxial cylinder of the same height inside.

    Parameters
    ----------
    inner : float
        Radius of the inner surface [m].
    outer : float
        Radius of the outer surface [m].
    height : float
        Height h of both [m].

    Returns
    -------
    float
        F21 [1].

    Notes
    -----
    With X = r2/r1, Y = h/r1, A = Y^2 + X^2 - 1, B = Y^2 - X^2 + 1 (Hamilton and Morgan 1952; Howell's
    catalogue). The terms cancel where h or r2 - r1 is small or large compared with r1: good to 1e-10
    for ratios from 0.1 to 10.

    Examples
    --------
    >>> from transport.theory.round_view_factors import outer_cylinder_to_inner
    >>> print(f"{outer_cylinder_to_inner(1.0, 2.0, 2.0):.4g}")
    0.3371
    """
    x, y = outer / inner, height / inner
    a, b = y * y + x * x - 1, y * y - x * x + 1
    bracket = (
        math.sqrt((a + 2) ** 2 - 4 * x * x) * math.acos(b / (x * a)) + b * math.asin(1 / x) - math.pi * a / 2
    )
    return 1 / x - (math.acos(b / a) - bracket / (2 * y)) / (math.pi * x)


def outer_cylinder_to_itself(inner: float, outer: float, height: float) -> float:
    """View factor F22 from the inside of a cylinder to itself past a coaxial cylinder of the same height.

    Parameters
    ----------
    inner : float
        Radius of the inner surface [m].
    outer : float
        Radius of the outer surface [m].
    height : float
        Height h of both [m].

    Returns
    -------
    float
        F22 [1].

    Notes
    -----
    Source: Hamilton and Morgan 1952; Howell's catalogue.

    Examples
    --------
    >>> from transport.theory.round_view_factors import outer_cylinder_to_itself
    >>> print(f"{outer_cylinder_to_itself(1.0, 2.0, 2.0):.4g}")
    0.2285
    """
    x, y = outer / inner, height / inner
    x2, y2 = x * x, y * y
    gap = 4 * (x2 - 1)
    slant = math.sqrt(4 * x2 + y2) / y
    around = slant * math.asin((gap + y2 / x2 * (x2 - 2)) / (y2 + gap)) - math.asin((x2 - 2) / x2)
    past = 2 / math.pi * math.atan(2 * math.sqrt(x2 - 1) / y)
    return 1 - 1 / x + past / x - y / (2 * math.pi * x) * (around + math.pi / 2 * (slant - 1))


def _over_sphere(radius_1: float, radius_2: float, distance: float, low: float, high: float) -> float:
    """Half the integral over mu from low to high.

    Substitutes mu = low + (high - low) sin^2, for half-odd powers at the ends.
    """
    from transport.theory.emitters import sphere_irradiance

    if not low < high:
        return 0.0
    x, w = legendre_nodes(NODES)
    t, w = math.pi / 4 * (1 + x), math.pi / 4 * w
    mu, w = low + (high - low) * np.sin(t) ** 2, w * (high - low) * np.sin(2 * t)
    away = np.sqrt((distance - radius_1) ** 2 + 2 * distance * radius_1 * (1 - mu))
    cosine = (distance * mu - radius_1) / away
    return float(w @ sphere_irradiance(1.0, radius_2, away, cosine) / math.pi / 2)
