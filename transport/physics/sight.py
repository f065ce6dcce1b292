"""Sampling for point detectors: places on a line by 1/r^2 or in space by 1/(a b)^2.

Pdfs of phase functions.
"""

import math

from transport.physics.device import device
from transport.physics.elementary import TWO_PI, azimuth_turn, sin_quarter

PI_CUBED = 31.006276680299816
LEAST = 1e-150  # least distance of a line and a point [scene lengths], whose square is still a normal number


@device
def sample_equiangular(least, start, end, u):
    """Return a place on a line between `start` and `end`, uniform in the angle seen from a point.

    u in [0, 1]. Places are measured from the foot of the perpendicular from the point, of length `least`.
    Also returns the angle over `least`, which is one over (pdf times r^2), r^2 = least^2 + place^2. The angle
    between both ends is computed by one arc tangent and the place by rotating one end towards the other:
    nothing cancels, and a line through the point has its limit.
    """
    d = least if least > LEAST else LEAST
    turn = azimuth_turn(d * d + start * end, d * (end - start))
    turn = turn if turn < 0.5 else 0.5
    part = u * turn
    s = sine(part)
    c = sin_quarter(0.25 - part)
    place = d * (start * c + d * s) / (d * c - start * s)
    place = place if place > start else start
    return place if place < end else end, TWO_PI * turn / d


@device
def sample_equiangular_beyond(least, start, u):
    """Return the same on a half line, u in [0, 1): distance from its start, and angle over `least`."""
    d = least if least > LEAST else LEAST
    turn = azimuth_turn(start, d)
    turn = turn if turn < 0.5 else 0.5
    ahead, rest, length = sine(u * turn), sine((1.0 - u) * turn), math.sqrt(d * d + start * start)
    return length * (ahead / rest if rest > 0.0 else 1.0), TWO_PI * turn / d


@device
def sine(turn):
    """Return sin(2 pi turn) for turn in [0, 1/2], with all its digits near 0."""
    return sin_quarter(turn if turn < 0.25 else 0.5 - turn)


@device
def sample_detour(r, u, v):
    """Return cosine, sine and length a of the first leg of a path by one scattering point to a point.

    r: distance of that point from the start. The pdf of the scattering point is r / (pi^3 a^2 b^2) for legs a
    and b. The angle at the start has a pdf in proportion to its supplement; the angle at the point is a
    uniform share of that supplement, u and v in [0, 1) (Kalos 1963; Steinberg and Kalos 1971). a follows by
    the law of sines.
    """
    root = math.sqrt(1.0 - u)
    turn, other = 0.5 * u / (1.0 + root), 0.5 * root
    return sin_quarter(0.25 - turn), sine(turn), r * sine(v * other) / sine((1.0 - v) * other)


@device
def henyey_greenstein_density(g, mu):
    """Return the pdf [sr^-1] of Henyey and Greenstein (1941).

    The chord without cancellation on either side.
    """
    a = abs(g)
    chord = (1.0 - a) * (1.0 - a) + 2.0 * a * (1.0 - (mu if g > 0.0 else -mu))
    return 0.07957747154594767 * (1.0 - a) * (1.0 + a) / (chord * math.sqrt(chord))


@device
def rayleigh_density(mu):
    """Return the pdf [sr^-1] of Rayleigh's phase function, 3/(16 pi) (1 + mu^2)."""
    return 0.05968310365946075 * (1.0 + mu * mu)
