"""What a ray from an event to a detector brings, over the density with which the event sends it there.

A point drawn evenly on a flat detector of area A is seen under the cosine c from the distance r: the density of its direction
is p = r^2/(A c), and a ray brings 1/p.  Near the detector that has no bound.  There the two ways that an event's light comes, by
such a ray and by the flight itself, share it: with the greatest density `peak` of the event's directions, the ray counts r^2/(r^2 +
peak A), the flight the rest (multiple importance sampling, Veach 1997; weights in which no angle enters).  Of a ball of
which A is the cross section r is the distance of its centre, and directions are even over the solid angle that it fills.
"""

from transport.physics.device import device
from transport.physics.elementary import TWO_PI
from transport.physics.emission import cone_about


@device
def flat_connection(r2, area, cosine, sharing):
    """What a ray brings to a flat detector [sr]; sharing: `peak` where flights bring the rest, 0 where rays bring all."""
    return area * cosine / (r2 + sharing * area) if r2 > 0.0 else 0.0


@device
def ball_connection(d2, radius, area, sharing):
    """The same of a ball at the squared distance d2 of its centre; from the centre itself flights bring all that is shared."""
    share = d2 / (d2 + sharing * area) if d2 > 0.0 else (0.0 if sharing > 0.0 else 1.0)
    return TWO_PI * cone_about(d2, radius) * share


@device
def flights_share(r2, area, peak):
    """What of its own crossing a flight brings where it is shared."""
    seen = peak * area
    return seen / (r2 + seen)
