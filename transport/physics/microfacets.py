"""Rough reflection by microfacets: GGX normals, Smith's height-correlated shadowing.

Walter et al. (2007), "Microfacet models for refraction through rough surfaces"; Heitz (2014), "Understanding
the masking-shadowing function"; sampling of visible normals as a spherical cap: Dupuy and Benyoub (2023).
"""

import math

from transport.physics.device import device
from transport.physics.elementary import cos_sin_turn


@device
def sample_visible_normal(x, y, z, alpha, u, turn):
    """Return a microfacet normal sampled as seen from (x, y, z) in the frame of the surface.

    Z > 0 is the cosine.
    """
    sx, sy = alpha * x, alpha * y
    inverse = 1.0 / math.sqrt(sx * sx + sy * sy + z * z)
    sx, sy, sz = sx * inverse, sy * inverse, z * inverse
    height = (1.0 - u) * (1.0 + sz) - sz
    s2 = (1.0 - height) * (1.0 + height)
    sine = math.sqrt(s2 if s2 > 0.0 else 0.0)
    c, s = cos_sin_turn(turn)
    hx, hy, hz = alpha * (sine * c + sx), alpha * (sine * s + sy), height + sz
    inverse = 1.0 / math.sqrt(hx * hx + hy * hy + hz * hz)
    return hx * inverse, hy * inverse, hz * inverse


@device
def unshadowed_share(mu_in, mu_out, alpha):
    """Return G2/G1, the share of rays reflected by visible microfacets that leave the surface.

    It is 0 for mu_out <= 0.
    """
    a2 = alpha * alpha
    s_in = math.sqrt(mu_in * mu_in + a2 * (1.0 - mu_in) * (1.0 + mu_in))
    s_out = math.sqrt(mu_out * mu_out + a2 * (1.0 - mu_out) * (1.0 + mu_out))
    lit = (s_in + mu_in) * mu_out
    return lit / (lit + (s_out - mu_out) * mu_in) if mu_out > 0.0 else 0.0
