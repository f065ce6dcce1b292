"""A rough mirror of microfacets: density of its normals, shadowing, albedo and reflectance distribution.

Normals follow Trowbridge and Reitz (1975), "GGX" (Walter et al. 2007, EGSR, eq. 33), with the roughness alpha
in (0, 1]; shadowing is Smith's with correlated heights (Heitz 2014, JCGT 3(2), 48); what one reflection does
not return, a second lobe does (Kulla and Conty 2017).  Cosines mu are measured from the surface's normal and
are positive on the side of the light; the azimuth phi between arrival and departure is that between the
direction *towards* the light and the direction of departure: phi = pi is the specular side, phi = 0 straight
back.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.compensation import lobe

LEAST_ROUGHNESS = 1e-8  # below it the surface is a mirror to rounding, and the lobe is that of this roughness


def normal_density(mu: np.ndarray, roughness: float) -> np.ndarray:
    """Area of microfacets per solid angle of their normals and per area of the surface [sr^-1]: D.  Vectorised.

    D = alpha^2 / (pi (1 - (1 - alpha^2) mu^2)^2), whose integral of D mu over the hemisphere is 1.
    """
    mu = np.asarray(mu, float)
    flat = (1 - mu) * (1 + mu) + np.square(roughness * mu)
    return (roughness * roughness / (math.pi * flat * flat))[()]


def shadowing(mu: np.ndarray, roughness: float) -> np.ndarray:
    """Share of the microfacets' shadow that is seen from a direction [1]: G1 = 2 mu / (mu + h).  Vectorised."""
    mu, h = _lifted(mu, roughness)
    return (2 * mu / (mu + h))[()]


def joint_shadowing(mu_in: np.ndarray, mu_out: np.ndarray, roughness: float) -> np.ndarray:
    """Share that is both lit and seen [1]: G2 = 1/(1 + Lambda_i + Lambda_o).  Vectorised; cosines above 0."""
    (one, h_one), (other, h_other) = _lifted(mu_in, roughness), _lifted(mu_out, roughness)
    return (2 * one * other / (h_one * other + h_other * one))[()]


def visible_density(
    mu: np.ndarray, mu_normal: np.ndarray, cosine: np.ndarray, roughness: float
) -> np.ndarray:
    """Density of normals that are seen from a direction [sr^-1]: G1 max(cosine, 0) D / mu.  Vectorised.

    mu, mu_normal: cosines of the direction and the microfacet's normal;  cosine: between the two.  Its
    integral is 1.
    """
    mu, h = _lifted(mu, roughness)
    return (2 / (mu + h) * np.maximum(cosine, 0.0) * normal_density(mu_normal, roughness))[()]


def single_reflection(mu_in, mu_out, phi, roughness: float) -> np.ndarray:
    """Reflectance distribution of one reflection without loss [sr^-1]: D G2 / (4 mu_i mu_o).  Vectorised.

    Symmetric in the cosines to the last bit, and nothing in it cancels.
    """
    one, other = (np.arcsin(np.asarray(mu, float)) for mu in (mu_in, mu_out))
    (mu_in, h_in), (mu_out, h_out) = _lifted(mu_in, roughness), _lifted(mu_out, roughness)
    c2, d2 = np.sin((one + other) / 2) ** 2, np.cos((other - one) / 2) ** 2
    alpha2, rest = roughness * roughness, (1 - roughness) * (1 + roughness)
    turned = np.cos(one) * np.cos(other) * np.cos(np.asarray(phi, float) / 2) ** 2
    apart = c2 * (np.sin((other - one) / 2) ** 2 + alpha2 * d2) + turned
    density = alpha2 / math.pi * np.square(1 + rest * c2 * d2 / apart)
    return (density / (2 * (h_in * mu_out + h_out * mu_in)))[()]


def brdf(mu_in, mu_out, phi, roughness: float, albedo: float = 1.0) -> np.ndarray:
    """Bidirectional reflectance distribution of `Glossy(roughness, albedo)` [sr^-1].  Vectorised.

    mu_in, mu_out: cosines in (0, 1], towards the light and of departure;  phi: azimuth between them [rad], pi
    on the specular side.  Its integral with mu_out over the hemisphere is the albedo at every angle.
    """
    table = _lobe(roughness)
    lost = table.lost(mu_in) * table.lost(mu_out)
    again = lost / (math.pi * table.mean_lost)
    return (albedo * (single_reflection(mu_in, mu_out, phi, roughness) + again))[()]


def single_albedo(mu: np.ndarray, roughness: float) -> np.ndarray:
    """Share of the light at that cosine that a single reflection returns [1]: E(mu).  Vectorised."""
    return (1 - _lobe(roughness).lost(mu))[()]


def lost_albedo(mu: np.ndarray, roughness: float) -> np.ndarray:
    """1 - E(mu) [1], good relatively however little it is.  Vectorised."""
    return _lobe(roughness).lost(mu)[()]


def mean_albedo(roughness: float) -> float:
    """Share of diffuse light that a single reflection returns [1]: E_mean = 2 int_0^1 E mu dmu."""
    return 1 - _lobe(roughness).mean_lost


def lobe_density(mu: np.ndarray, roughness: float) -> np.ndarray:
    """Density of the cosine with which the second lobe leaves [1]: 2 (1 - E) mu / (1 - E_mean).  Vectorised."""
    return (2 * _lobe(roughness).lost(mu) * np.asarray(mu, float) / _lobe(roughness).mean_lost)[()]


def lobe_quantile(u: np.ndarray, roughness: float) -> np.ndarray:
    """The cosine below which a share u in [0, 1] of the second lobe leaves [1].  Vectorised."""
    return _lobe(roughness).quantile(u)[()]


def _lobe(roughness: float):
    return lobe(max(float(roughness), LEAST_ROUGHNESS))


def _lifted(mu, roughness: float) -> tuple[np.ndarray, np.ndarray]:
    mu = np.asarray(mu, float)
    return mu, np.hypot(mu, roughness * np.sqrt((1 - mu) * (1 + mu)))
