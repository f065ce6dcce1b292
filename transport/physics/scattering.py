"""Scattering: cosines by the inverse CDF of each phase function, and rotation by the scattering angle.

Every sampler returns cosine and sine of the scattering angle. Both are computed from 1 - mu (or 1 + mu, on
the side of the peak) without cancellation: a peak keeps the digits of its angles, and mu^2 + sine^2 is 1 to
rounding.
"""

import math

from numba import float64, int64

from transport.physics.device import device
from transport.physics.directions import turned_by
from transport.physics.elementary import cos_sin_turn


@device
def cosine_and_sine(x, sign):
    """Return mu and its sine for 1 - sign mu = x, x in [0, 2], sign +1 or -1."""
    return sign * (1.0 - x), math.sqrt(x * (2.0 - x))


@device
def sample_henyey_greenstein(g, u):
    """Return cosine and sine by Henyey and Greenstein (1941), for mean cosine g in (-1, 1) and u in [0, 1].

    mu increases with u: mu = (2s + g (s^2 + 3) + 2 g^2 s + g^3 (s^2 - 1)) / (2 (1 + g s)^2), s = 2u - 1,
    inverts the CDF. The angle is measured from the peak instead (a = |g|, t the probability within it, w = 1
    - t), as 1 - mu = 2 t (1 - a)^2 (1 + a w) / (1 - a + 2 a w)^2: nothing cancels for any g, 0 included.
    """
    is_forward = g >= 0.0
    v = 1.0 - u
    w, t = u if is_forward else v, v if is_forward else u
    a = abs(g)
    b = 1.0 - a
    aw = a * w
    d = b + 2.0 * aw
    x = 2.0 * t * (b * b) * (1.0 + aw) / (d * d)
    return cosine_and_sine(x if x < 2.0 else 2.0, 1.0 if is_forward else -1.0)


@device
def sample_rayleigh(u):
    """Return cosine and sine by Rayleigh's 3/8 (1 + mu^2), for u in [0, 1]; mu increases with u.

    x = 1 - |mu| is the root of x^3 - 3 x^2 + 6 x = 8 w, w the probability of the nearer end: a polynomial
    accurate to 1.6e-6 (Remez) and one step of Halley's method, instead of Cardano's cube root, which cancels
    at mu = 0.
    """
    is_upper = u >= 0.5
    w = 1.0 - u if is_upper else u
    p = 8.3353603221920452 + w * (
        -44.285271916027461 + w * (133.59953327358545 + w * (-218.88396225135556 + w * 132.41130343018122))
    )
    p = 1.333335450156049 + w * (
        0.88818422783406574 + w * (0.82836898514263152 + w * (-0.13009331782578277 + w * p))
    )
    x = w * p
    y = x - 1.0
    f = x * (x * (x - 3.0) + 6.0) - 8.0 * w
    slope = 3.0 + 3.0 * y * y
    x -= f * slope / (slope * slope - 3.0 * f * y)
    return cosine_and_sine(x, 1.0 if is_upper else -1.0)


@device
def turned_by_angle(ux, uy, uz, mu, sine, turn):
    """Return the unit direction at a scattering angle of this cosine and sine, at azimuth 2 pi turn about u.

    An error of the length of u is multiplied by mu^2: over 10^6 scatterings |u|^2 stays within 2e-15 of 1
    (1e-14 for g = 0.999) without renormalisation.
    """
    c, d = cos_sin_turn(turn)
    return turned_by(ux, uy, uz, mu, sine * c, sine * d)


@device
def choose_segment(rows, count, u):
    """Return a segment of a table, chosen by its probability, and a fresh uniform in [0, 1] from u in [0, 1).

    rows: `count` rows of media.SEGMENT. The pdf is linear between the points of the table; with
    `sample_segment`, mu follows it exactly and does not increase with u.

    One gather of a cache line and no search: the alias method (Walker 1977). count is a power of two, so the
    place in the row is exact.
    """
    place = u * count
    k = int64(place)
    row, fraction, kept = rows[k], place - float64(k), rows[k].kept
    keeps = fraction < kept
    r = (fraction if keeps else fraction - kept) / (kept if keeps else 1.0 - kept)
    start, width = row.start if keeps else row.other_start, row.width if keeps else row.other_width
    return start, width, row.share if keeps else row.other_share, r


@device
def sample_segment(start, width, share, r):
    """Return cosine and sine within a segment of linear pdf, for r in [0, 1].

    It extends from 1 - |mu| = start by |width|, forward or, for width < 0, backward. share: pdf at its start
    over the sum of the pdfs at both ends.
    """
    other = 1.0 - share
    root = math.sqrt((1.0 - r) * (share * share) + r * (other * other))
    t = r / (share + root if r > 0.0 else 1.0)
    return cosine_and_sine(start + abs(width) * t, 1.0 if width > 0.0 else -1.0)
