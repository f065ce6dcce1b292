"""Emission towards a target (`aim`): directions sampled over the target only, with the exact weight.

A source emits with f(u) = isotropic + lambertian · max(cosθ, 0) per steradian, normalised to one over the
directions into which it emits. A target point sampled by area has the pdf r²/(A cosθ') in solid angle; a
share `natural` of directions may follow f itself, which bounds the weight by 1/share however close the target
is. The weight is f divided by the pdf of the mixture (Veach 1997, ch. 9: balance heuristic).
"""

import math

from transport.physics.device import device


@device
def aimed_weight(f, area, cosine, r2, natural):
    """Return the weight of a direction that hits a target of `area` at distance² r2 and |cosθ'| `cosine`.

    Else 0.
    """
    foreshortened = f * area * cosine
    weighted = foreshortened / (natural * foreshortened + (1.0 - natural) * r2)
    return weighted if foreshortened > 0.0 else 0.0


@device
def cone_about(d2, radius):
    """Return 1 − cos of the half angle of the cone that a sphere subtends from distance² d2.

    2 (all directions) inside.
    """
    sine2 = radius * radius / d2
    outside = d2 > radius * radius
    return sine2 / (1.0 + math.sqrt(1.0 - sine2)) if outside else 2.0
