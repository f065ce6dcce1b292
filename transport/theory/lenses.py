"""Lenses: they conserve radiance at best and fill a wider cone with it, E = n^2 pi L sin^2 theta'.

A lossless optic conserves étendue, and so radiance over n^2 (Straubel 1902; Hanrahan 2001, Stanford CS
348B, lecture 4, "Throughput"). A detector that receives L within a cone of half angle theta' about its
normal, in a medium of index n, has the irradiance n^2 pi L sin^2 theta'. That is sin^2 theta'/sin^2
theta_s times its irradiance by a source of half angle theta_s alone, at most 1/sin^2 theta_s in air
(Winston, Miñano, Benítez 2005, "Nonimaging Optics", 1.2).

The planted fault of the tests: a lens that adds to tangents what a lens that conserves étendue adds to
direction cosines. In tangents t the measure of rays is cosθ dω = cos^4 θ d²t; the map conserves d²t, so
that radiance changes by cos^4 θ / cos^4 θ'.
"""

from __future__ import annotations

import math

import numpy as np


def cone_of(f_number: float) -> float:
    """Half angle of the light at the focus of a flat thin lens.

    Parameters
    ----------
    f_number : float or ndarray
        f-number N [1].

    Returns
    -------
    float or ndarray
        ``atan(1/2N)`` [rad].

    Examples
    --------
    >>> from transport.theory.lenses import cone_of
    >>> print(f"{cone_of(2.0):.4g}")
    0.245
    """
    return np.arctan(np.divide(0.5, f_number))


def focus_irradiance(radiance: float, half_angle: float, index: float = 1.0) -> float:
    """Irradiance at a focus from a cone of directions with the source's radiance.

    Parameters
    ----------
    radiance : float or ndarray
        Radiance L of the source [W m^-2 sr^-1].
    half_angle : float or ndarray
        Half angle theta' of the cone of light at the focus [rad].
    index : float or ndarray, default 1.0
        Refractive index n at the detector [1].

    Returns
    -------
    float or ndarray
        ``n^2 pi L sin^2 theta'`` [W m^-2].

    Examples
    --------
    >>> from transport.theory.lenses import focus_irradiance
    >>> print(f"{focus_irradiance(1.0, 0.5):.4g}")
    0.7221
    """
    return index**2 * math.pi * radiance * np.sin(half_angle) ** 2


def image_irradiance(radiance: float, f_number: float) -> float:
    """Irradiance in the image of an aplanatic lens, for a distant source.

    Parameters
    ----------
    radiance : float or ndarray
        Radiance L of the source [W m^-2 sr^-1].
    f_number : float or ndarray
        f-number N; sin theta' = 1/2N [1].

    Returns
    -------
    float or ndarray
        ``pi L/(4 N^2)`` [W m^-2].

    Examples
    --------
    >>> from transport.theory.lenses import image_irradiance
    >>> print(f"{image_irradiance(1.0, 2.0):.4g}")
    0.1963
    """
    return math.pi * radiance / (4 * np.square(f_number))


def concentration(half_angle: float, of_source: float, index: float = 1.0) -> float:
    """Irradiance at the focus over that by the source alone.

    Parameters
    ----------
    half_angle : float or ndarray
        Half angle theta' of the cone of light at the focus [rad].
    of_source : float or ndarray
        Half angle theta_s of the source [rad].
    index : float or ndarray, default 1.0
        Refractive index n at the detector [1].

    Returns
    -------
    float or ndarray
        ``n^2 sin^2 theta'/sin^2 theta_s`` [1].

    Examples
    --------
    >>> from transport.theory.lenses import concentration
    >>> print(f"{concentration(0.5, 0.00465):.4g}")
    1.063e+04
    """
    return np.square(index * np.sin(half_angle) / np.sin(of_source))


def highest_concentration(of_source: float, index: float = 1.0) -> float:
    """Upper limit of the concentration by any optic.

    Parameters
    ----------
    of_source : float or ndarray
        Half angle theta_s of the source [rad].
    index : float or ndarray, default 1.0
        Refractive index n at the detector [1].

    Returns
    -------
    float or ndarray
        ``n^2/sin^2 theta_s`` [1], for a whole hemisphere of the source's radiance.

    Notes
    -----
    Source: Winston, Miñano, Benítez 2005, 1.2.

    Examples
    --------
    >>> from transport.theory.lenses import highest_concentration
    >>> print(f"{highest_concentration(0.00465):.4g}")
    4.625e+04
    """
    return concentration(math.pi / 2, of_source, index)


def ball_focal_length(radius: float, index: float) -> float:
    """Paraxial focal length of a ball lens, from its center.

    Parameters
    ----------
    radius : float
        Radius R [m].
    index : float
        Refractive index n [1].

    Returns
    -------
    float
        ``n R/(2 (n - 1))`` [m].

    Examples
    --------
    >>> from transport.theory.lenses import ball_focal_length
    >>> print(f"{ball_focal_length(1.0, 1.5):.4g}")
    1.5
    """
    return index * radius / (2 * (index - 1))


def ball_back_focal_length(radius: float, index: float) -> float:
    """Paraxial back focal length of a ball lens, from its rear surface.

    Parameters
    ----------
    radius : float
        Radius R [m].
    index : float
        Refractive index n [1].

    Returns
    -------
    float
        ``R (2 - n)/(2 (n - 1))`` [m].

    Examples
    --------
    >>> from transport.theory.lenses import ball_back_focal_length
    >>> print(f"{ball_back_focal_length(1.0, 1.5):.4g}")
    0.5
    """
    return radius * (2 - index) / (2 * (index - 1))


def ball_axis_crossing(height: float, radius: float, index: float) -> float:
    """Distance from a ball lens's center at which a ray parallel to the axis crosses the axis.

    Parameters
    ----------
    height : float or ndarray
        Distance h of the ray from the axis, above 0, at most R [m].
    radius : float or ndarray
        Radius R of the ball [m].
    index : float or ndarray
        Refractive index n [1].

    Returns
    -------
    float or ndarray
        ``h/sin(2 (i - r))`` [m].

    Notes
    -----
    The ray meets the ball at the angle i, ``sin i = h/R``, is deflected by ``2 (i - r)``,
    ``sin r = sin i/n``, and leaves at the same distance h from the center. Exact for any height.

    Examples
    --------
    >>> from transport.theory.lenses import ball_axis_crossing
    >>> print(f"{ball_axis_crossing(0.5, 1.0, 1.5):.4g}")
    1.392
    """
    sine = np.divide(height, radius)
    return height / np.sin(2 * (np.arcsin(sine) - np.arcsin(sine / index)))


def lens_focal_length(curvature_radius: float, thickness: float, index: float) -> float:
    """Focal length of a biconvex lens of two equal spherical faces (lensmaker's formula).

    Parameters
    ----------
    curvature_radius : float
        Radius of curvature R of both faces [m].
    thickness : float
        Thickness d on the axis [m].
    index : float
        Refractive index n [1].

    Returns
    -------
    float
        f [m], with ``1/f = (n - 1) [2/R - (n - 1) d/(n R^2)]``.

    Examples
    --------
    >>> from transport.theory.lenses import lens_focal_length
    >>> print(f"{lens_focal_length(1.0, 0.2, 1.5):.4g}")
    1.034
    """
    power = (index - 1) * (2 - (index - 1) * thickness / (index * curvature_radius)) / curvature_radius
    return 1 / power


def tangent_lens_radiance(radiance: float, before: float, behind: float) -> float:
    """Radiance behind a lens that maps tangents, which violates conservation of étendue.

    Parameters
    ----------
    radiance : float or ndarray
        Radiance L of the source [W m^-2 sr^-1].
    before : float or ndarray
        Angle theta in front of the lens [rad].
    behind : float or ndarray
        Angle theta' behind the lens [rad].

    Returns
    -------
    float or ndarray
        ``L cos^4 theta/cos^4 theta'`` [W m^-2 sr^-1].

    Examples
    --------
    >>> from transport.theory.lenses import tangent_lens_radiance
    >>> print(f"{tangent_lens_radiance(1.0, 0.0, 0.5):.4g}")
    1.686
    """
    return radiance * (np.cos(before) / np.cos(behind)) ** 4


def tangent_lens_irradiance(radiance: float, half_angle: float) -> float:
    """Irradiance at the focus of a lens that maps tangents, for a distant source, at a point on the axis.

    Parameters
    ----------
    radiance : float or ndarray
        Radiance L of the source [W m^-2 sr^-1].
    half_angle : float or ndarray
        Half angle theta' of the cone of light at the focus [rad].

    Returns
    -------
    float or ndarray
        ``pi L tan^2 theta'`` [W m^-2].

    Notes
    -----
    The integral of ``L/cos^4 theta' cos theta' dω'``. Beyond 45 degrees it exceeds the source's own
    exitance pi L.

    Examples
    --------
    >>> from transport.theory.lenses import tangent_lens_irradiance
    >>> print(f"{tangent_lens_irradiance(1.0, 0.5):.4g}")
    0.9376
    """
    return math.pi * radiance * np.tan(half_angle) ** 2
