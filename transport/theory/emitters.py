"""Irradiance by the simplest emitters: a Lambert disk, a Lambert sphere, an isotropic point.

Radiance L in W m^-2 sr^-1 (or particles), lengths in m. mu is the cosine of the receiver's tilt. All
functions are vectorised.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.cones import projected_cone
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
    Source: Lambert 1760; Howell's catalogue, element to sphere; cut spheres by `cones.projected_cone`.

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
