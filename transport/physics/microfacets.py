"""Rough reflection by microfacets: GGX normals, Smith's height-correlated shadowing.

Sampling, and the pdf of sampled directions, which next-event rays need.

Walter et al. (2007), "Microfacet models for refraction through rough surfaces"; Heitz (2014), "Understanding
the masking-shadowing function"; sampling of visible normals as a spherical cap: Dupuy and Benyoub (2023).
"""

import math

from transport.physics.device import device
from transport.physics.elementary import cos_sin_turn

HALF_INVERSE_PI = 0.15915494309189535


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


@device
def shadowed_share(mu_in, mu_out, alpha):
    """Return 1 - G2/G1, the share of rays reflected by visible microfacets that other facets stop."""
    a2 = alpha * alpha
    s_in = math.sqrt(mu_in * mu_in + a2 * (1.0 - mu_in) * (1.0 + mu_in))
    s_out = math.sqrt(mu_out * mu_out + a2 * (1.0 - mu_out) * (1.0 + mu_out))
    # s_out - mu_out, without cancellation.
    fall = a2 * (1.0 - mu_out) * (1.0 + mu_out) / (s_out + mu_out) if mu_out > 0.0 else 1.0
    stopped = fall * mu_in
    return stopped / ((s_in + mu_in) * mu_out + stopped) if mu_out > 0.0 else 1.0


@device
def sample_shadowed_share(mu, alpha, u, turn):
    """Return an unbiased estimate of 1 - E(mu), the share that single reflection loses, from two uniforms.

    It is the shadowed share at a sampled visible microfacet.
    """
    sine = math.sqrt((1.0 - mu) * (1.0 + mu))
    hx, _, hz = sample_visible_normal(sine, 0.0, mu, alpha, u, turn)
    return shadowed_share(mu, 2.0 * (hx * sine + hz * mu) * hz - mu, alpha)


@device
def single_reflection_density(ux, uy, uz, vx, vy, vz, nx, ny, nz, alpha):
    """Return the pdf [sr^-1] with which rays along u leave along v after a single reflection.

    n: normal to the side of arrival. The pdf is D G1/(4 mu_in) times G2/G1, and 0 below the horizon. Its
    integral over v is the share E that single reflection returns.
    """
    mu_in, mu_out = abs(ux * nx + uy * ny + uz * nz), vx * nx + vy * ny + vz * nz
    # Half vector: its square, and those of its parts along the normal and across it.
    hx, hy, hz = vx - ux, vy - uy, vz - uz
    along = hx * nx + hy * ny + hz * nz
    cx, cy, cz = hy * nz - hz * ny, hz * nx - hx * nz, hx * ny - hy * nx
    across2, a2 = cx * cx + cy * cy + cz * cz, alpha * alpha
    whole = along * along + across2
    slope = whole / (a2 * along * along + across2) if whole > 0.0 else 0.0
    s_in = math.sqrt(mu_in * mu_in + a2 * (1.0 - mu_in) * (1.0 + mu_in))
    s_out = math.sqrt(mu_out * mu_out + a2 * (1.0 - mu_out) * (1.0 + mu_out))
    lit = mu_out / (s_in * mu_out + s_out * mu_in) if mu_out > 0.0 else 0.0
    return HALF_INVERSE_PI * a2 * slope * slope * lit
