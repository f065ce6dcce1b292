"""An integrating sphere: what its diffuse wall makes of the light that is sent in.

The chord between two places of a sphere makes the same angle with both normals, so that cosθ cosθ'/π r² =
1/A: what leaves any place of the inside by the cosine law falls evenly on all of it (Ulbricht 1900; Sumpner
1892).  So nothing but the shares of the area counts, wherever the ports are: with the albedos a_i on the
shares f_i of the sphere's area A (an open port has albedo 0), what falls on it anew after a reflection is
reflected with the probability

    a = Σ a_i f_i,

and series of reflections are geometric (Jacquez, Kuppenheim 1955; Goebel 1967).  "Lamp": a point source at
the centre lights all places alike, open ports too.  "Beam": all of the flux first strikes one place of the
wall.
"""

from __future__ import annotations

import numpy as np


def mean_albedo(albedos, shares) -> float:
    """Albedo of the whole inside [1]: sum of a_i f_i over its parts; open ports add nothing."""
    return float(np.dot(albedos, shares))


def multiplier(albedo: float, port_share: float) -> float:
    """Sphere multiplier M = a / (1 - a (1 - f)) [1], of one wall of that albedo and an open port of that
    share.

    A lamp makes the radiosity of the wall M Phi/A and its radiance M Phi/(pi A); of a beam that strikes the
    wall, reflections add up to M Phi, and give the irradiance M Phi/A at any other place.  Vectorised.
    """
    return albedo / (1 - albedo * (1 - np.asarray(port_share, dtype=float)))


def lamp_irradiance(flux: float, mean_albedo: float, area: float) -> float:
    """Irradiance by a lamp's light at any place of the sphere, direct and reflected [W m^-2]: Phi / (A (1 -
    a)).  Vectorised.
    """
    return flux / area / (1 - np.asarray(mean_albedo, dtype=float))


def lamp_hits(wall_share: float, mean_albedo: float) -> float:
    """Mean number of times that a lamp's particle strikes parts of this share [1].  Vectorised."""
    return wall_share / (1 - np.asarray(mean_albedo, dtype=float))


def beam_irradiance(flux: float, albedo: float, mean_albedo: float, area: float) -> float:
    """Irradiance by the reflected light of a beam at any place [W m^-2]: a_1 Phi / (A (1 - a)).

    albedo: of the part that the beam strikes.  With one wall and an open port it is M Phi/A.  Vectorised.
    """
    return lamp_irradiance(albedo * flux, mean_albedo, area)


def beam_hits(albedo: float, wall_share: float, mean_albedo: float) -> float:
    """Mean number of times that a beam's particle strikes the wall, the first included [1]: 1 + a_1 f_1 / (1
    - a).

    albedo, wall_share: of the part that the beam strikes; 1 / (1 - a (1 - f)) for one wall and an open port.
    """
    return 1 + albedo * wall_share / (1 - mean_albedo)
