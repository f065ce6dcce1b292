"""A cone of directions about an oblique axis, cut at the receiver's horizon.

The projected solid angle of what is left of the cone is the area of its shadow in the unit disk: a piece of
an ellipse, and a segment of the unit circle where the horizon cuts (Nusselt 1928).  With the segment
function seg(x) = x - sin x cos x it reads

    P = seg(psi) + g s^2 seg(chi),   cos psi = c / q,   cos chi = -c g / (s q)

s, c: sine and cosine of the half angle; g, q: cosine and sine between axis and normal; psi: half the arc of
the horizon inside the cone, chi: half the arc of the cone's rim above the horizon, sin psi = s sin chi.
"""

from __future__ import annotations

import math

import numpy as np

TERMS = 48  # of the series below: their ratio is at most 1/2, so that 2^-48 is left


def cone_projected_solid_angle(half_angle: float, mu: float) -> float:
    """Projected solid angle of a cone of directions, cut at the receiver's horizon [sr].

    half_angle: 0 to pi; mu: cosine between the cone's axis and the receiver's normal.
    It is pi sin^2(half_angle) mu while the cone is above the horizon and 0 below it.  Vectorised.
    Source: unit-sphere method (Nusselt 1928), as above.
    """
    wide = np.greater(half_angle, math.pi / 2)
    small = np.where(wide, math.pi - np.asarray(half_angle), half_angle)
    part = projected_cone(np.sin(small), np.cos(small), np.where(wide, -np.asarray(mu), mu))
    return np.where(wide, math.pi - part, part)[()]


def projected_cone(sine: float, cosine: float, mu: float) -> float:
    """The same [sr] from the sine and cosine of a half angle up to pi/2."""
    s, c, g = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (sine, cosine, mu)))
    above, below = g >= s, -g >= s
    # Uncut lanes carry a harmless cut cone through the formulas.
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
    """seg(psi) + g s^2 seg(chi): good unless both are small and of opposite sign."""
    cos_psi, cos_chi = c / q, -c * g / (s * q)
    small = 2 / 3 * sin_psi**3 * _series(np.minimum(sin_psi**2, 0.5), lambda m: 1.0)
    segment_psi = np.where(sin_psi**2 < 0.5, small, np.arctan2(sin_psi, cos_psi) - sin_psi * cos_psi)
    segment_chi = np.arctan2(sin_chi, cos_chi) - sin_chi * cos_chi
    return segment_psi + g * s**2 * segment_chi


def _grazing(s, c, g, sin_chi):
    """The same where a little of the cone shows above the horizon and its axis is below.

    With seg(x) = (2/3) sin^3 x k(sin^2 x) and y = sin^2 chi it is
    (2/3) s^2 sin^3 chi [(s + g) k(s^2 y) + g (k(y) - k(s^2 y))].  Both differences are formed first: s + g
    from the input, k(y) - k(s^2 y) term by term with 1 - s^(2m) = -expm1(m log s^2).
    """
    y = np.minimum(sin_chi**2, 0.5)
    log_s2 = np.where(s * s < 0.5, 2 * np.log(s), np.log1p(-np.minimum(c * c, 0.75)))
    first = (s + g) * _series(s * s * y, lambda m: 1.0)
    second = g * _series(y, lambda m: -np.expm1(m * log_s2))
    return 2 / 3 * s**2 * sin_chi**3 * (first + second)


def _series(y, factor):
    """Sum over m of 3/(2m + 3) (1/2)_m / m! y^m factor(m): k(y) where the factor is 1."""
    total, coefficient = 0.0, np.ones_like(y)
    for m in range(TERMS):
        total = total + 3 / (2 * m + 3) * coefficient * factor(m)
        coefficient = coefficient * y * (m + 0.5) / (m + 1)
    return total
