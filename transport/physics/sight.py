"""Where on a flight to look at a point from: equiangularly, so that 1/r^2 becomes 1/D (Kulla and Fajardo 2012)."""

import math

from transport.physics.device import device
from transport.physics.elementary import TWO_PI, azimuth_turn, sin_quarter

LEAST = 1e-150  # least distance of a line and a point [scene lengths], whose square is still a normal number


@device
def sample_equiangular(least, start, end, u):
    """A place on a line between `start` and `end`, told from the foot of the perpendicular of length `least` from the point.

    Uniform in the angle that it is seen under, for u in [0, 1].  Returns the place and the angle over `least`, which is one
    over (density times r^2), r^2 = least^2 + place^2.  The angle between both ends comes from one arc tangent and the place
    from turning one end towards the other: nothing cancels, and a line through the point has its limit.
    """
    d = least if least > LEAST else LEAST
    turn = azimuth_turn(d * d + start * end, d * (end - start))
    turn = turn if turn < 0.5 else 0.5
    part = u * turn
    s = sin_quarter(part if part < 0.25 else 0.5 - part)
    c = sin_quarter(0.25 - part)
    place = d * (start * c + d * s) / (d * c - start * s)
    place = place if place > start else start
    return place if place < end else end, TWO_PI * turn / d


@device
def henyey_greenstein_density(g, mu):
    """Density [sr^-1] of Henyey and Greenstein's phase function (1941); the chord without cancellation on either side."""
    a = abs(g)
    chord = (1.0 - a) * (1.0 - a) + 2.0 * a * (1.0 - (mu if g > 0.0 else -mu))
    return 0.07957747154594767 * (1.0 - a) * (1.0 + a) / (chord * math.sqrt(chord))


@device
def rayleigh_density(mu):
    """Density [sr^-1] of Rayleigh's phase function, 3/(16 pi) (1 + mu^2)."""
    return 0.05968310365946075 * (1.0 + mu * mu)
