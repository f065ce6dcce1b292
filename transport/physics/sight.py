"""Where to look at a point from: on a flight so that 1/r^2 becomes 1/D, anywhere so that 1/(a b)^2 becomes 1/r."""

import math

from transport.physics.device import device
from transport.physics.elementary import TWO_PI, azimuth_turn, sin_quarter

FOUR_PI_CUBED = 124.02510672119926
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
    s = sine(part)
    c = sin_quarter(0.25 - part)
    place = d * (start * c + d * s) / (d * c - start * s)
    place = place if place > start else start
    return place if place < end else end, TWO_PI * turn / d


@device
def sample_equiangular_beyond(least, start, u):
    """The same for a line without end, for u in [0, 1): how far from its start, and the angle over `least`."""
    d = least if least > LEAST else LEAST
    turn = azimuth_turn(start, d)
    ahead, rest = u * turn, (1.0 - u) * turn
    return math.sqrt(d * d + start * start) * sine(ahead) / sine(rest), TWO_PI * turn / d


@device
def sine(turn):
    """sin(2 pi turn) for turn in [0, 1/2], with all its digits near 0."""
    return sin_quarter(turn if turn < 0.25 else 0.5 - turn)


@device
def sample_detour(r, u, v):
    """A detour to a point at the distance r, for u, v in [0, 1): its density is r / (pi^3 a^2 b^2), a and b its two legs.

    Uniform are the angle at the start and, of what that leaves, the angle at the point (Kalos 1963; Steinberg and Kalos 1971).
    Returns cosine and sine of the angle at the start, the first leg a, and one over (density times a^2 b^2) for the azimuth
    uniform as well: 2 pi^2 (pi - angle) / r.  b follows from the law of sines.
    """
    turn, other = 0.5 * u, 0.5 * (1.0 - u)
    return sin_quarter(0.25 - turn), sine(turn), r * sine(v * other) / sine((1.0 - v) * other), FOUR_PI_CUBED * other / r


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
