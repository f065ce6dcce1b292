"""The sun as a uniform Lambert sphere: radiance, solid angle, distance, irradiance.

The numbers of Cornell CS 6620, lecture 2: P = 3.91e26 W from A = 6.07e18 m^2 give L = 2.05e7 W m^-2
sr^-1, and with 6.7e-5 sr and 2.92e-5 sr the irradiances 1373.5 and 598.6 W m^-2. The lecture defines
the solid angle as projected area over squared distance; the sun's actual cap is larger by (R/d)^2 / 4,
5e-6 at the earth. Its 6.7e-5 sr corresponds to the distance 1.505e11 m; one astronomical unit gives
6.78e-5 sr and 1390 W m^-2.
"""

from __future__ import annotations

import math

import numpy as np

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
    >>> from transport.theory.sun import AREA, sphere_radius
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
    >>> from transport.theory.sun import AREA, POWER, surface_radiance
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
    >>> from transport.theory.sun import ASTRONOMICAL_UNIT, sphere_solid_angle
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
    >>> from transport.theory.sun import SOLID_ANGLE_EARTH, distance_of_solid_angle
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
    >>> from transport.theory.sun import SOLID_ANGLE_EARTH, distance_of_projected_area
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
    >>> from transport.theory.sun import AREA, POWER, SOLID_ANGLE_EARTH, irradiance_of_solid_angle
    >>> print(f"{irradiance_of_solid_angle(POWER, AREA, SOLID_ANGLE_EARTH):.4g}")
    1374
    """
    return surface_radiance(power, area) * solid_angle * np.maximum(mu, 0.0)
