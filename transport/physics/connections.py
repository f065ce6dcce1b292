"""Next-event estimation: contribution of a ray from an event to a detector, over the event's pdf.

A point uniform on a flat detector of area A is seen at the angle of cosine c from distance r: the pdf of its
direction is p = r^2/(A c), and a ray contributes 1/p, which is unbounded near the detector. There, rays and
flights share the light of an event by multiple importance sampling (Veach 1997): with `peak` the largest pdf
of the event's directions, the ray has the weight r^2/(r^2 + peak A) and the flight the rest, weights that do
not depend on an angle. For a ball, A is the area of its cross section, r the distance of its centre, and
directions are uniform in the solid angle that it fills.

At a glossy surface the pdf of the direction itself takes the place of `peak` (passes/gloss.py).
"""

from transport.physics.device import device
from transport.physics.elementary import TWO_PI
from transport.physics.emission import cone_about


@device
def flat_connection(r2, area, cosine, sharing):
    """Return the contribution of a ray to a flat detector [sr].

    sharing: `peak` if flights score the rest, 0 if rays score all.
    """
    return area * cosine / (r2 + sharing * area) if r2 > 0.0 else 0.0


@device
def ball_connection(d2, radius, area, sharing):
    """Return the contribution of a ray to a ball [sr] whose centre is at squared distance d2.

    From the centre itself flights score all that is shared.
    """
    share = d2 / (d2 + sharing * area) if d2 > 0.0 else (0.0 if sharing > 0.0 else 1.0)
    return TWO_PI * cone_about(d2, radius) * share


@device
def flights_share(r2, area, peak):
    """Return the MIS weight of a flight whose crossing is shared with next-event rays."""
    seen = peak * area
    return seen / (r2 + seen)


@device
def rays_share(r2, area, peak, sharing):
    """Return the MIS weight of a ray, relative to that of one with another `peak`, named `sharing`."""
    return (r2 + sharing * area) / (r2 + peak * area) if r2 > 0.0 else 0.0
