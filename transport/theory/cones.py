"""Projected solid angle of a cone about an oblique axis, cut at the receiver's horizon.

The projected solid angle of the visible part of the cone is the area of its projection onto the unit
disk: a piece of an ellipse, and a segment of the unit circle where the horizon cuts (Nusselt 1928).
With the segment function seg(x) = x - sin x cos x it is

    P = seg(psi) + g s^2 seg(chi),   cos psi = c / q,   cos chi = -c g / (s q)

with s, c the sine and cosine of the half angle; g, q the cosine and sine of the angle between axis and
normal; psi half the arc of the horizon inside the cone, chi half the arc of the cone's rim above the
horizon, sin psi = s sin chi.
"""

from __future__ import annotations

import math

import numpy as np

TERMS = 48  # terms of the series below: their ratio is at most 1/2, which leaves 2^-48


def cone_projected_solid_angle(half_angle: float, mu: float) -> float:
    """Projected solid angle of a cone of directions, cut at the receiver's horizon.

    Parameters
    ----------
    half_angle : float or ndarray
        Half angle of the cone, 0 to pi [rad].
    mu : float or ndarray
        Cosine between the cone's axis and the receiver's normal [1].

    Returns
    -------
    float or ndarray
        Projected solid angle [sr].

    Notes
    -----
    ``pi sin^2(half_angle) mu`` while the cone is above the horizon, 0 below it. Source: unit-sphere
    method (Nusselt 1928), formula in the module's docstring.

    Examples
    --------
    >>> from transport.theory.cones import cone_projected_solid_angle
    >>> print(f"{cone_projected_solid_angle(0.5, 0.3):.4g}")
    0.2253
    """
    wide = np.greater(half_angle, math.pi / 2)
    small = np.where(wide, math.pi - np.asarray(half_angle), half_angle)
    part = projected_cone(np.sin(small), np.cos(small), np.where(wide, -np.asarray(mu), mu))
    return np.where(wide, math.pi - part, part)[()]


def projected_cone(sine: float, cosine: float, mu: float) -> float:
    """Projected solid angle of a cone of directions, given by the sine and cosine of its half angle.

    Parameters
    ----------
    sine : float or ndarray
        Sine of the half angle, which is at most pi/2 [1].
    cosine : float or ndarray
        Cosine of the half angle [1].
    mu : float or ndarray
        Cosine between the cone's axis and the receiver's normal [1].

    Returns
    -------
    float or ndarray
        Projected solid angle [sr].

    Examples
    --------
    >>> from transport.theory.cones import projected_cone
    >>> print(f"{projected_cone(0.6, 0.8, 0.3):.4g}")
    0.3767
    """
    s, c, g = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (sine, cosine, mu)))
    above, below = g >= s, -g >= s
    # Where the cone is not cut, put harmless values of a cut cone into the formulas.
    s, c, g = (
        np.where(above | below, dummy, x) for x, dummy in ((s, math.sqrt(0.5)), (c, math.sqrt(0.5)), (g, 0.0))
    )
    q = np.sqrt((1 - g) * (1 + g))
    sin_psi = np.minimum(np.sqrt((s - g) * (s + g)) / q, 1.0)
    sin_chi = np.minimum(sin_psi / s, 1.0)
    cut = np.where(
        (g < 0) & (sin_chi**2 < 0.5), _grazing(s, c, g, sin_chi), _cut(s, c, g, q, sin_psi, sin_chi)
    )
    return np.where(above, math.pi * np.square(sine) * mu, np.where(below, 0.0, cut))[()]


def _cut(s, c, g, q, sin_psi, sin_chi):
    """Return seg(psi) + g s^2 seg(chi), accurate unless both terms are small and of opposite sign."""
    cos_psi, cos_chi = c / q, -c * g / (s * q)
    small = 2 / 3 * sin_psi**3 * _series(np.minimum(sin_psi**2, 0.5), lambda m: 1.0)
    segment_psi = np.where(sin_psi**2 < 0.5, small, np.arctan2(sin_psi, cos_psi) - sin_psi * cos_psi)
    segment_chi = np.arctan2(sin_chi, cos_chi) - sin_chi * cos_chi
    return segment_psi + g * s**2 * segment_chi


def _grazing(s, c, g, sin_chi):
    """Projected solid angle of a cone whose axis is below the horizon and of which a small part shows.

    With seg(x) = (2/3) sin^3 x k(sin^2 x) and y = sin^2 chi it is (2/3) s^2 sin^3 chi [(s + g) k(s^2
    y) + g (k(y) - k(s^2 y))]. Both differences are formed first: s + g from the input, k(y) - k(s^2 y)
    term by term with 1 - s^(2m) = -expm1(m log s^2).
    """
    y = np.minimum(sin_chi**2, 0.5)
    log_s2 = np.where(s * s < 0.5, 2 * np.log(s), np.log1p(-np.minimum(c * c, 0.75)))
    first = (s + g) * _series(s * s * y, lambda m: 1.0)
    second = g * _series(y, lambda m: -np.expm1(m * log_s2))
    return 2 / 3 * s**2 * sin_chi**3 * (first + second)


def _series(y, factor):
    """Sum over m of 3/(2m + 3) (1/2)_m / m! y^m factor(m); k(y) if the factor is 1."""
    total, coefficient = 0.0, np.ones_like(y)
    for m in range(TERMS):
        total = total + 3 / (2 * m + 3) * coefficient * factor(m)
        coefficient = coefficient * y * (m + 0.5) / (m + 1)
    return total
