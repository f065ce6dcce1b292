"""The sun as a uniform Lambert sphere: radiance, solid angle, distance, irradiance.

The figures of Cornell CS 6620, lecture 2: P = 3.91e26 W from A = 6.07e18 m^2 give L = 2.05e7 W m^-2 sr^-1,
and with 6.7e-5 sr and 2.92e-5 sr 1373.5 W and 598.6 W on a square metre.  The lecture takes solid angle as
projected area over distance squared; the cap that the sun really covers is larger by (R/d)^2 / 4, 5e-6 at
the earth. Its 6.7e-5 sr is the sun from 1.505e11 m; one astronomical unit gives 6.78e-5 sr and 1390 W m^-2.
"""

from __future__ import annotations

import math

import numpy as np

POWER = 3.91e26  # W, Cornell CS 6620, lecture 2
AREA = 6.07e18  # m^2, the same
SOLID_ANGLE_EARTH = 6.7e-5  # sr, the same
SOLID_ANGLE_MARS = 2.92e-5  # sr, the same
ASTRONOMICAL_UNIT = 149_597_870_700.0  # m, exact (IAU 2012, resolution B2)


def sphere_radius(area: float) -> float:
    """Radius of a sphere of a given surface area [m]: sqrt(A / (4 pi)); 6.950e8 m for AREA."""
    return np.sqrt(np.divide(area, 4 * math.pi))


def surface_radiance(power: float, area: float) -> float:
    """Radiance of a diffuse emitter of given power and area [W m^-2 sr^-1]: P / (pi A)."""
    return power / (math.pi * area)


def sphere_solid_angle(radius: float, distance: float) -> float:
    """Solid angle of a sphere seen from a distance d >= R from its centre [sr]: 2 pi (1 - sqrt(1 - (R/d)^2)).

    Computed as 2 pi s^2 / (1 + sqrt(1 - s^2)), s = R/d.
    """
    cosine = np.sqrt(np.subtract(distance, radius) / distance * (np.add(distance, radius) / distance))
    return 2 * math.pi * np.divide(radius, distance) ** 2 / (1 + cosine)


def distance_of_solid_angle(radius: float, solid_angle: float) -> float:
    """Distance of the centre at which a sphere covers a spherical cap of solid_angle <= 2 pi sr [m].

    d = R / (2 sqrt(x (1 - x))), x = Omega / (4 pi): the inverse of sphere_solid_angle.
    """
    x = np.divide(solid_angle, 4 * math.pi)
    return radius / (2 * np.sqrt(x * (1 - x)))


def distance_of_projected_area(radius: float, solid_angle: float) -> float:
    """Distance at which pi R^2 / d^2 equals solid_angle, the lecture's way [m]: d = R sqrt(pi / Omega).

    6.7e-5 sr: 1.505e11 m; 2.92e-5 sr: 2.280e11 m.  In this way E = L Omega is exact for a receiver that
    faces the sun.
    """
    return radius * np.sqrt(np.divide(math.pi, solid_angle))


def irradiance_of_solid_angle(power: float, area: float, solid_angle: float, mu: float = 1.0) -> float:
    """Irradiance by a small or facing source, L Omega mu [W m^-2]; mu: cosine of the zenith angle.

    Exact with the projected solid angle pi (R/d)^2 and the whole sphere above the horizon; with the cap's
    solid angle it is too large by (R/d)^2 / 4.  Source: Cornell CS 6620, lecture 2.
    """
    return surface_radiance(power, area) * solid_angle * np.maximum(mu, 0.0)
