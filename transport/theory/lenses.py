"""Lenses: they hand radiance on, at most as it is, and fill a wider cone with it: E = n^2 pi L sin^2 theta'.

A lossless optic conserves étendue, and so radiance over n^2 (Straubel 1902; Hanrahan 2001, Stanford CS 348B, lecture 4,
"Throughput"); a detector that sees L within a cone of half angle theta' about its normal, on its side of the optic,
receives n^2 pi L sin^2 theta'.  That is sin^2 theta'/sin^2 theta_s times what it receives from a source of half angle
theta_s alone, at most 1/sin^2 theta_s in air (Winston, Miñano, Benítez 2005, "Nonimaging Optics", 1.2).

The planted fault: a lens that adds to tangents what one that conserves étendue adds to direction cosines.  In tangents t
the measure of rays is cosθ dω = cos^4 θ d²t; the map keeps d²t, so that radiance changes by cos^4 θ / cos^4 θ'.
"""

from __future__ import annotations

import math

import numpy as np


def cone_of(f_number: float) -> float:
    """Half angle of the light behind a flat thin lens, at its focus [rad]: atan(1/2N)."""
    return np.arctan(np.divide(0.5, f_number))


def focus_irradiance(radiance: float, half_angle: float, index: float = 1.0) -> float:
    """Irradiance in the focus, of a cone of that half angle full of the source's radiance [W m^-2]: n^2 pi L sin^2 theta'."""
    return index**2 * math.pi * radiance * np.sin(half_angle) ** 2


def image_irradiance(radiance: float, f_number: float) -> float:
    """Irradiance in the image of an aplanatic lens, sin theta' = 1/2N, far source [W m^-2]: pi L/(4 N^2)."""
    return math.pi * radiance / (4 * np.square(f_number))


def concentration(half_angle: float, of_source: float, index: float = 1.0) -> float:
    """Irradiance in the focus over that by the source alone [1]: n^2 sin^2 theta'/sin^2 theta_s."""
    return np.square(index * np.sin(half_angle) / np.sin(of_source))


def highest_concentration(of_source: float, index: float = 1.0) -> float:
    """What no optic surpasses [1]: n^2/sin^2 theta_s, from a whole hemisphere full of the source's radiance."""
    return concentration(math.pi / 2, of_source, index)


def ball_focal_length(radius: float, index: float) -> float:
    """Focal length of a ball from its centre, small angles [m]: n R/(2 (n - 1))."""
    return index * radius / (2 * (index - 1))


def ball_back_focal_length(radius: float, index: float) -> float:
    """From the ball's rear surface to the focus, small angles [m]: R (2 - n)/(2 (n - 1))."""
    return radius * (2 - index) / (2 * (index - 1))


def ball_axis_crossing(height: float, radius: float, index: float) -> float:
    """Where a ray parallel to the axis at that height crosses it behind the ball, from the centre [m]; any height.

    It meets the ball at the angle i, sin i = h/R, is turned by 2 (i - r), sin r = sin i/n, and leaves at the same
    distance h from the centre: h/sin(2 (i - r)).
    """
    sine = np.divide(height, radius)
    return height / np.sin(2 * (np.arcsin(sine) - np.arcsin(sine / index)))


def lens_focal_length(curvature_radius: float, thickness: float, index: float) -> float:
    """Focal length of a biconvex lens of two equal spheres [m] (lensmaker's formula):

    1/f = (n - 1) [2/R - (n - 1) d/(n R^2)].
    """
    power = (index - 1) * (2 - (index - 1) * thickness / (index * curvature_radius)) / curvature_radius
    return 1 / power


def tangent_lens_radiance(radiance: float, before: float, behind: float) -> float:
    """What a lens that maps tangents would make of a radiance [W m^-2 sr^-1]: L cos^4 theta/cos^4 theta'."""
    return radiance * (np.cos(before) / np.cos(behind)) ** 4


def tangent_lens_irradiance(radiance: float, half_angle: float) -> float:
    """What it would bring to its focus from a far source, a point on the axis [W m^-2]: pi L tan^2 theta'.

    The integral of L/cos^4 theta' cos theta' dω'; beyond 45 degrees it is more than the source itself gives off, pi L.
    """
    return math.pi * radiance * np.tan(half_angle) ** 2
