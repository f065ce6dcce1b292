"""Irradiance by the simplest emitters: a Lambert disk, a Lambert sphere, an isotropic point.

Radiance L in W m^-2 sr^-1 (or particles), lengths in m. mu is the cosine of the receiver's tilt. All
functions are vectorised.
"""

from __future__ import annotations

import math

import numpy as np

from transport.geometry.solid_angles import projected_cone
from transport.statistics.quadrature import legendre_nodes
from transport.theory.solid_angles import rectangle_projected_solid_angle, rectangle_solid_angle
from transport.theory.view_factors import coaxial_disks


def lambert_power(radiance: float, area: float) -> float:
    """Power emitted by one side of a diffuse emitter.

    Parameters
    ----------
    radiance : float or ndarray
        Radiance L of the emitter [W m^-2 sr^-1].
    area : float or ndarray
        Area A [m^2].

    Returns
    -------
    float or ndarray
        ``P = pi L A`` [W].

    Notes
    -----
    Source: Cornell CS 6620, lecture 2.

    Examples
    --------
    >>> from transport.theory.emitters import lambert_power
    >>> print(f"{lambert_power(1.0, 2.0):.4g}")
    6.283
    """
    return math.pi * radiance * area


def disk_irradiance(radiance: float, radius: float, distance: float, offset: float = 0.0) -> float:
    """Irradiance by a Lambert disk on a small patch parallel to it.

    Parameters
    ----------
    radiance : float or ndarray
        Radiance L of the emitter [W m^-2 sr^-1].
    radius : float or ndarray
        Radius R of the disk [m].
    distance : float or ndarray
        Distance d > 0 of the patch from the disk's plane [m].
    offset : float or ndarray, default 0.0
        Distance x >= 0 of the patch from the disk's axis [m].

    Returns
    -------
    float or ndarray
        Irradiance [W m^-2]; ``pi L R^2 / (R^2 + d^2)`` on the axis.

    Notes
    -----
    ``E = (pi/2) L [1 - T/S]`` with ``T = x^2 + d^2 - R^2`` and
    ``S^2 = (x^2 + d^2 + R^2)^2 - 4 x^2 R^2`` (Foote 1915, Bull. Bur. Stand. 12, 583; Walsh 1958). S is
    the product of the distances to the nearest and the farthest point of the rim, and
    ``S^2 - T^2 = 4 R^2 d^2``, so that nothing cancels, neither far away nor near the rim.

    Examples
    --------
    >>> from transport.theory.emitters import disk_irradiance
    >>> print(f"{disk_irradiance(1.0, 1.0, 2.0):.4g}")
    0.6283
    """
    near = np.hypot(distance, offset - radius)
    far = np.hypot(distance, offset + radius)
    t = (offset - radius) / near * ((offset + radius) / far) + distance / near * (distance / far)
    outside = 2 * math.pi * (radius / far * (distance / near)) ** 2 / (1 + np.maximum(t, 0.0))
    return radiance * np.where(t > 0, outside, math.pi / 2 * (1 - t))[()]


def mean_disk_irradiance(
    radiance: float, source_radius: float, receiver_radius: float, distance: float
) -> float:
    """Mean irradiance by a Lambert disk over a coaxial disk that faces it.

    Parameters
    ----------
    radiance : float or ndarray
        Radiance L of the emitter [W m^-2 sr^-1].
    source_radius : float or ndarray
        Radius of the emitting disk [m].
    receiver_radius : float or ndarray
        Radius of the receiving disk [m].
    distance : float or ndarray
        Distance between the disks [m].

    Returns
    -------
    float or ndarray
        ``pi L F(receiver -> source)`` [W m^-2].

    Notes
    -----
    Source: reciprocity and `view_factors.coaxial_disks` (Howell, C-41).

    Examples
    --------
    >>> from transport.theory.emitters import mean_disk_irradiance
    >>> print(f"{mean_disk_irradiance(1.0, 1.0, 0.5, 2.0):.4g}")
    0.6039
    """
    return math.pi * radiance * coaxial_disks(receiver_radius, source_radius, distance)


def sphere_irradiance(radiance: float, radius: float, distance: float, mu: float = 1.0) -> float:
    """Irradiance by a Lambert sphere.

    Parameters
    ----------
    radiance : float or ndarray
        Radiance L of the emitter [W m^-2 sr^-1].
    radius : float or ndarray
        Radius R of the sphere [m].
    distance : float or ndarray
        Distance d of the receiver from the center, at least R [m].
    mu : float or ndarray, default 1.0
        Cosine between the receiver's normal and the direction of the center [1].

    Returns
    -------
    float or ndarray
        Irradiance [W m^-2]; ``pi L (R/d)^2 mu`` while the whole sphere is above the receiver's horizon
        (mu >= R/d), else that of the part above the horizon.

    Raises
    ------
    ValueError
        If the distance is less than the radius.

    Notes
    -----
    Source: Lambert 1760; Howell's catalogue, element to sphere; cut spheres by `solid_angles.projected_cone`.

    Examples
    --------
    >>> from transport.theory.emitters import sphere_irradiance
    >>> print(f"{sphere_irradiance(1.0, 1.0, 2.0):.4g}")
    0.7854
    """
    if np.any(np.less(distance, radius)):
        raise ValueError(f"distance must be at least the sphere's radius {radius}, got {distance}")
    cosine = np.sqrt(np.subtract(distance, radius) / distance * (np.add(distance, radius) / distance))
    return radiance * projected_cone(np.divide(radius, distance), cosine, mu)


def point_irradiance(power: float, distance: float, mu: float = 1.0) -> float:
    """Irradiance by an isotropic point source.

    Parameters
    ----------
    power : float or ndarray
        Power P of the source [W].
    distance : float or ndarray
        Distance d from the source [m].
    mu : float or ndarray, default 1.0
        Cosine between the receiver's normal and the direction to the source [1].

    Returns
    -------
    float or ndarray
        ``P max(mu, 0) / (4 pi d^2)`` [W m^-2].

    Notes
    -----
    Source: Lambert 1760. Also exact for a uniform Lambert sphere, with d from its center, while all of
    it is above the horizon.

    Examples
    --------
    >>> from transport.theory.emitters import point_irradiance
    >>> print(f"{point_irradiance(1.0, 2.0):.4g}")
    0.01989
    """
    return power * np.maximum(mu, 0.0) / (4 * math.pi) / distance / distance


def point_flux_through_disk(power: float, radius: float, distance: float) -> float:
    """Power of an isotropic point source through a coaxial disk.

    Parameters
    ----------
    power : float or ndarray
        Power P of the source [W].
    radius : float or ndarray
        Radius a of the disk [m].
    distance : float or ndarray
        Distance d of the disk from the source [m].

    Returns
    -------
    float or ndarray
        ``(P/2) (1 - d / sqrt(d^2 + a^2))`` [W].

    Notes
    -----
    Computed as ``(P/2) a^2 / (h (h + d))`` with ``h = sqrt(d^2 + a^2)``. Also the power of a Lambert
    sphere centered on the point, provided that the sphere does not reach the disk's plane (Howell,
    C-136).

    Examples
    --------
    >>> from transport.theory.emitters import point_flux_through_disk
    >>> print(f"{point_flux_through_disk(1.0, 1.0, 2.0):.4g}")
    0.05279
    """
    slant = np.hypot(distance, radius)
    return power / 2 * (radius / slant) * (radius / (slant + distance))


def mean_point_irradiance(power: float, radius: float, distance: float) -> float:
    """Mean irradiance by an isotropic point source over a coaxial disk that faces it.

    Parameters
    ----------
    power : float or ndarray
        Power P of the source [W].
    radius : float or ndarray
        Radius a of the disk [m].
    distance : float or ndarray
        Distance d of the disk from the source [m].

    Returns
    -------
    float or ndarray
        Flux through the disk over ``pi a^2`` [W m^-2].

    Examples
    --------
    >>> from transport.theory.emitters import mean_point_irradiance
    >>> print(f"{mean_point_irradiance(1.0, 1.0, 2.0):.4g}")
    0.0168
    """
    slant = np.hypot(distance, radius)
    return power / (2 * math.pi) / slant / (slant + distance)


def disk_over_inverse_square(widths: float) -> float:
    """Irradiance on the axis of a Lambert disk over its inverse-square law ``pi L R^2/d^2``.

    Parameters
    ----------
    widths : float or ndarray
        Distance over the disk's diameter [1].

    Returns
    -------
    float or ndarray
        ``1 / (1 + (R/d)^2)`` [1].

    Notes
    -----
    At 5 diameters it is 1/1.01: the five-times rule (Lambert 1760, cited by Akenine-Moeller et al.
    2008, 7.1). For a sphere the ratio is exactly 1, with distances from its center.

    Examples
    --------
    >>> from transport.theory.emitters import disk_over_inverse_square
    >>> print(f"{disk_over_inverse_square(5.0):.4g}")
    0.9901
    """
    return 1 / (1 + np.square(0.5 / widths))


def disk_inverse_square_error(widths: float) -> float:
    """Relative error of the inverse-square law on the axis of a Lambert disk.

    Parameters
    ----------
    widths : float or ndarray
        Distance over the disk's diameter [1].

    Returns
    -------
    float or ndarray
        ``(R/d)^2 = 1 / (2 widths)^2`` [1]; the law is too large by exactly 1 % at 5 diameters.

    Examples
    --------
    >>> from transport.theory.emitters import disk_inverse_square_error
    >>> print(f"{disk_inverse_square_error(5.0):.4g}")
    0.01
    """
    return np.square(0.5 / widths)


def strip_over_inverse_square(widths: float) -> float:
    """Irradiance on the axis of a thin Lambert strip over its inverse-square law.

    Parameters
    ----------
    widths : float or ndarray
        Distance over the strip's length [1].

    Returns
    -------
    float or ndarray
        ``(1/(1 + t^2) + atan(t)/t) / 2`` with ``t = 0.5/widths`` [1].

    Notes
    -----
    Source: the integral of cos^4 / d^2 along the strip, with the cosines at source and receiver.

    Examples
    --------
    >>> from transport.theory.emitters import strip_over_inverse_square
    >>> print(f"{strip_over_inverse_square(5.0):.4g}")
    0.9934
    """
    t = 0.5 / widths
    return (1 / (1 + t * t) + np.arctan(t) / t) / 2


# ---- A square panel on the axis: change of irradiance and solid angle when the distance doubles.
#
# A panel of radiance L and side a gives the irradiance E = L P and the fluence rate L Ω, with P the
# projected solid angle and Ω the solid angle (solid_angles.py). Far away both tend to (a/d)²:
#
#     P (d/a)² = 1 - (a/d)²/3 + ...,   Ω (d/a)² = 1 - (a/d)²/4 + ...,
#
# because cos⁴θ and cos³θ fall by 2 and 3/2 times r²/d², whose mean is a²/6. At twice the distance a
# detector has E/4 (1 + (a/2d)²) and Ω/4 (1 + 3/4 (a/2d)²), while L is the same at any distance.

NODES = 8  # Gauss-Legendre nodes along each side of a detector that is small compared with its distance


def mean_rectangle_solid_angle(width: float, height: float, distance: float, side: float) -> float:
    """Solid angle of a rectangle, averaged over a parallel square detector on its axis.

    Parameters
    ----------
    width : float
        Width of the rectangle [m].
    height : float
        Height of the rectangle [m].
    distance : float
        Distance d between the planes [m].
    side : float
        Side of the detector, at most `width` and `height` [m].

    Returns
    -------
    float
        Mean solid angle [sr].

    Notes
    -----
    At a point it is a sum over the four corners of ``atan(x y / (d sqrt(d² + x² + y²)))``, with x and y
    from the point's projection (Van Oosterom and Strackee 1983).

    Examples
    --------
    >>> from transport.theory.emitters import mean_rectangle_solid_angle
    >>> print(f"{mean_rectangle_solid_angle(1.0, 1.0, 2.0, 0.1):.4g}")
    0.2353
    """
    t, weight = legendre_nodes(NODES)
    x, y = (long / 2 + np.outer([1, -1], side / 2 * t) for long in (width, height))
    product = np.multiply.outer(x, y)
    slant = np.sqrt(np.add.outer(x**2, y**2) + distance**2)
    corners = np.arctan2(product, distance * slant).sum(axis=(0, 2))
    return float(weight @ corners @ weight) / 4


def doubled_irradiance(side: float, distance: float) -> float:
    """Ratio E(2d) / E(d) on the axis of a square panel.

    Parameters
    ----------
    side : float or ndarray
        Side a of the panel [m].
    distance : float or ndarray
        Distance d on the axis [m].

    Returns
    -------
    float or ndarray
        Ratio [1]; it tends to 1/4.

    Examples
    --------
    >>> from transport.theory.emitters import doubled_irradiance
    >>> print(f"{doubled_irradiance(1.0, 2.0):.4g}")
    0.2652
    """
    near, far = (rectangle_projected_solid_angle(side, side, np.multiply(k, distance)) for k in (1, 2))
    return far / near


def doubled_solid_angle(side: float, distance: float) -> float:
    """Ratio Ω(2d) / Ω(d) on the axis of a square panel.

    Parameters
    ----------
    side : float or ndarray
        Side a of the panel [m].
    distance : float or ndarray
        Distance d on the axis [m].

    Returns
    -------
    float or ndarray
        Ratio [1]; it tends to 1/4.

    Examples
    --------
    >>> from transport.theory.emitters import doubled_solid_angle
    >>> print(f"{doubled_solid_angle(1.0, 2.0):.4g}")
    0.2614
    """
    near, far = (rectangle_solid_angle(side, side, np.multiply(k, distance)) for k in (1, 2))
    return far / near


def far_irradiance_excess(side: float, distance: float) -> float:
    """Relative excess of E(2d) / E(d) over 1/4, far away.

    Parameters
    ----------
    side : float or ndarray
        Side a of the panel [m].
    distance : float or ndarray
        Distance d on the axis [m].

    Returns
    -------
    float or ndarray
        ``(a/2d)²`` [1].

    Examples
    --------
    >>> from transport.theory.emitters import far_irradiance_excess
    >>> print(f"{far_irradiance_excess(1.0, 2.0):.4g}")
    0.0625
    """
    return np.square(side / np.multiply(2, distance))


def far_solid_angle_excess(side: float, distance: float) -> float:
    """Relative excess of Ω(2d) / Ω(d) over 1/4, far away.

    Parameters
    ----------
    side : float or ndarray
        Side a of the panel [m].
    distance : float or ndarray
        Distance d on the axis [m].

    Returns
    -------
    float or ndarray
        ``3/4 (a/2d)²`` [1].

    Examples
    --------
    >>> from transport.theory.emitters import far_solid_angle_excess
    >>> print(f"{far_solid_angle_excess(1.0, 2.0):.4g}")
    0.04688
    """
    return 0.75 * far_irradiance_excess(side, distance)


# ---- The sun as a uniform Lambert sphere: radiance, solid angle, distance, irradiance.
#
# The numbers of Cornell CS 6620, lecture 2: P = 3.91e26 W from A = 6.07e18 m^2 give L = 2.05e7 W m^-2
# sr^-1, and with 6.7e-5 sr and 2.92e-5 sr the irradiances 1373.5 and 598.6 W m^-2. The lecture defines
# the solid angle as projected area over squared distance; the sun's actual cap is larger by (R/d)^2 / 4,
# 5e-6 at the earth. Its 6.7e-5 sr corresponds to the distance 1.505e11 m; one astronomical unit gives
# 6.78e-5 sr and 1390 W m^-2.

POWER = 3.91e26  # W, Cornell CS 6620, lecture 2
AREA = 6.07e18  # m^2, same source
SOLID_ANGLE_EARTH = 6.7e-5  # sr, same source
SOLID_ANGLE_MARS = 2.92e-5  # sr, same source
ASTRONOMICAL_UNIT = 149_597_870_700.0  # m, exact (IAU 2012, resolution B2)


def sphere_radius(area: float) -> float:
    """Radius of a sphere of a given surface area.

    Parameters
    ----------
    area : float or ndarray
        Surface area A [m^2].

    Returns
    -------
    float or ndarray
        ``sqrt(A / (4 pi))`` [m]; 6.950e8 m for AREA.

    Examples
    --------
    >>> from transport.theory.emitters import AREA, sphere_radius
    >>> print(f"{sphere_radius(AREA):.4g}")
    6.95e+08
    """
    return np.sqrt(np.divide(area, 4 * math.pi))


def surface_radiance(power: float, area: float) -> float:
    """Radiance of a diffuse emitter of given power and area.

    Parameters
    ----------
    power : float
        Emitted power P [W].
    area : float
        Surface area A [m^2].

    Returns
    -------
    float
        ``P / (pi A)`` [W m^-2 sr^-1].

    Examples
    --------
    >>> from transport.theory.emitters import AREA, POWER, surface_radiance
    >>> print(f"{surface_radiance(POWER, AREA):.4g}")
    2.05e+07
    """
    return power / (math.pi * area)


def sphere_solid_angle(radius: float, distance: float) -> float:
    """Solid angle of a sphere.

    Parameters
    ----------
    radius : float or ndarray
        Radius R of the sphere [m].
    distance : float or ndarray
        Distance d from the center, at least R [m].

    Returns
    -------
    float or ndarray
        ``2 pi (1 - sqrt(1 - (R/d)^2))`` [sr].

    Notes
    -----
    Computed as ``2 pi s^2 / (1 + sqrt(1 - s^2))`` with s = R/d.

    Examples
    --------
    >>> from transport.theory.emitters import ASTRONOMICAL_UNIT, sphere_solid_angle
    >>> print(f"{sphere_solid_angle(6.95e8, ASTRONOMICAL_UNIT):.4g}")
    6.781e-05
    """
    cosine = np.sqrt(np.subtract(distance, radius) / distance * (np.add(distance, radius) / distance))
    return 2 * math.pi * np.divide(radius, distance) ** 2 / (1 + cosine)


def distance_of_solid_angle(radius: float, solid_angle: float) -> float:
    """Distance of the center at which a sphere has a given solid angle: inverse of `sphere_solid_angle`.

    Parameters
    ----------
    radius : float or ndarray
        Radius R of the sphere [m].
    solid_angle : float or ndarray
        Solid angle Omega of the cap, at most 2 pi [sr].

    Returns
    -------
    float or ndarray
        ``R / (2 sqrt(x (1 - x)))`` with ``x = Omega / (4 pi)`` [m].

    Examples
    --------
    >>> from transport.theory.emitters import SOLID_ANGLE_EARTH, distance_of_solid_angle
    >>> print(f"{distance_of_solid_angle(6.95e8, SOLID_ANGLE_EARTH):.4g}")
    1.505e+11
    """
    x = np.divide(solid_angle, 4 * math.pi)
    return radius / (2 * np.sqrt(x * (1 - x)))


def distance_of_projected_area(radius: float, solid_angle: float) -> float:
    """Distance at which the projected area over the squared distance, pi R^2 / d^2, equals a solid angle.

    Parameters
    ----------
    radius : float or ndarray
        Radius R of the sphere [m].
    solid_angle : float or ndarray
        Projected area over squared distance Omega [sr].

    Returns
    -------
    float or ndarray
        ``R sqrt(pi / Omega)`` [m]: 1.505e11 m for 6.7e-5 sr, 2.280e11 m for 2.92e-5 sr.

    Notes
    -----
    The lecture's definition of solid angle, with which E = L Omega is exact for a receiver that faces
    the sun.

    Examples
    --------
    >>> from transport.theory.emitters import SOLID_ANGLE_EARTH, distance_of_projected_area
    >>> print(f"{distance_of_projected_area(6.95e8, SOLID_ANGLE_EARTH):.4g}")
    1.505e+11
    """
    return radius * np.sqrt(np.divide(math.pi, solid_angle))


def irradiance_of_solid_angle(power: float, area: float, solid_angle: float, mu: float = 1.0) -> float:
    """Irradiance by a source that is small or faces the receiver.

    Parameters
    ----------
    power : float
        Emitted power P [W].
    area : float
        Surface area A of the source [m^2].
    solid_angle : float or ndarray
        Solid angle Omega [sr].
    mu : float or ndarray, default 1.0
        Cosine of the zenith angle [1].

    Returns
    -------
    float or ndarray
        ``L Omega max(mu, 0)`` [W m^-2].

    Notes
    -----
    Exact with the projected solid angle pi (R/d)^2 and the whole sphere above the horizon; with the
    cap's solid angle it is too large by (R/d)^2 / 4. Source: Cornell CS 6620, lecture 2.

    Examples
    --------
    >>> from transport.theory.emitters import AREA, POWER, SOLID_ANGLE_EARTH, irradiance_of_solid_angle
    >>> print(f"{irradiance_of_solid_angle(POWER, AREA, SOLID_ANGLE_EARTH):.4g}")
    1374
    """
    return surface_radiance(power, area) * solid_angle * np.maximum(mu, 0.0)
