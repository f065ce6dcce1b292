"""A rough mirror of microfacets: density of normals, shadowing, albedo and BRDF.

Normals follow Trowbridge and Reitz (1975), "GGX" (Walter et al. 2007, EGSR, eq. 33), with the roughness
alpha in (0, 1]. Shadowing is Smith's with correlated heights (Heitz 2014, JCGT 3(2), 48). A second lobe
returns the light that single reflection loses (Kulla and Conty 2017). Cosines mu are measured from the
surface's normal and are positive on the side of the light. The azimuth phi is that between the
direction *towards* the light and the direction of reflection: phi = pi is the specular side, phi = 0 is
straight back.
"""

from __future__ import annotations

import math

import numpy as np

from transport.statistics.microfacet_lobe import lobe


def normal_density(mu: np.ndarray, roughness: float) -> np.ndarray:
    """Density of normals: area of microfacets per solid angle of their normals and per area of the surface.

    Parameters
    ----------
    mu : float or ndarray
        Cosine between a microfacet's normal and the surface's [1].
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    float or ndarray
        ``D = alpha^2 / (pi (1 - (1 - alpha^2) mu^2)^2)`` [sr^-1].

    Notes
    -----
    The integral of D mu over the hemisphere is 1 (Trowbridge and Reitz 1975).

    Examples
    --------
    >>> from transport.theory.microfacets import normal_density
    >>> print(f"{normal_density(1.0, 0.5):.4g}")
    1.273
    """
    mu = np.asarray(mu, float)
    flat = (1 - mu) * (1 + mu) + np.square(roughness * mu)
    return (roughness * roughness / (math.pi * flat * flat))[()]


def shadowing(mu: np.ndarray, roughness: float) -> np.ndarray:
    """Smith's shadowing function: visible share of the microfacets' projected area.

    Parameters
    ----------
    mu : float or ndarray
        Cosine to the surface's normal [1].
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    float or ndarray
        ``G1 = 2 mu / (mu + h)`` [1], with ``h = sqrt(mu^2 + alpha^2 (1 - mu^2))``.

    Examples
    --------
    >>> from transport.theory.microfacets import shadowing
    >>> print(f"{shadowing(0.5, 0.5):.4g}")
    0.861
    """
    mu, h = _cosine_and_h(mu, roughness)
    return (2 * mu / (mu + h))[()]


def joint_shadowing(mu_in: np.ndarray, mu_out: np.ndarray, roughness: float) -> np.ndarray:
    """Joint shadowing: share of the microfacets that is both lit and visible.

    Parameters
    ----------
    mu_in : float or ndarray
        Cosine of the direction towards the light, in (0, 1] [1].
    mu_out : float or ndarray
        Cosine of the direction of reflection, in (0, 1] [1].
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    float or ndarray
        ``G2 = 1/(1 + Lambda_i + Lambda_o)`` [1].

    Notes
    -----
    Source: Heitz 2014, eq. 99.

    Examples
    --------
    >>> from transport.theory.microfacets import joint_shadowing
    >>> print(f"{joint_shadowing(0.5, 0.5, 0.5):.4g}")
    0.7559
    """
    (one, h_one), (other, h_other) = _cosine_and_h(mu_in, roughness), _cosine_and_h(mu_out, roughness)
    return (2 * one * other / (h_one * other + h_other * one))[()]


def visible_density(
    mu: np.ndarray, mu_normal: np.ndarray, cosine: np.ndarray, roughness: float
) -> np.ndarray:
    """Density of the normals that are visible from a direction.

    Parameters
    ----------
    mu : float or ndarray
        Cosine of the direction to the surface's normal [1].
    mu_normal : float or ndarray
        Cosine of the microfacet's normal to the surface's normal [1].
    cosine : float or ndarray
        Cosine between the direction and the microfacet's normal [1].
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    float or ndarray
        ``G1 max(cosine, 0) D / mu`` [sr^-1]; its integral is 1.

    Examples
    --------
    >>> from transport.theory.microfacets import visible_density
    >>> print(f"{visible_density(0.5, 0.9, 0.8, 0.5):.4g}")
    0.7116
    """
    mu, h = _cosine_and_h(mu, roughness)
    return (2 / (mu + h) * np.maximum(cosine, 0.0) * normal_density(mu_normal, roughness))[()]


def single_reflection(mu_in, mu_out, phi, roughness: float) -> np.ndarray:
    """BRDF of a single lossless reflection.

    Parameters
    ----------
    mu_in : float or ndarray
        Cosine of the direction towards the light, in (0, 1] [1].
    mu_out : float or ndarray
        Cosine of the direction of reflection, in (0, 1] [1].
    phi : float or ndarray
        Azimuth between the two directions, pi on the specular side [rad].
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    float or ndarray
        ``D G2 / (4 mu_i mu_o)`` [sr^-1].

    Notes
    -----
    Symmetric in the cosines to the last bit; nothing in it cancels.

    Examples
    --------
    >>> import math
    >>> from transport.theory.microfacets import single_reflection
    >>> print(f"{single_reflection(0.5, 0.5, math.pi, 0.5):.4g}")
    0.9625
    """
    one, other = (np.arcsin(np.asarray(mu, float)) for mu in (mu_in, mu_out))
    (mu_in, h_in), (mu_out, h_out) = _cosine_and_h(mu_in, roughness), _cosine_and_h(mu_out, roughness)
    c2, d2 = np.sin((one + other) / 2) ** 2, np.cos((other - one) / 2) ** 2
    alpha2, rest = roughness * roughness, (1 - roughness) * (1 + roughness)
    turned = np.cos(one) * np.cos(other) * np.cos(np.asarray(phi, float) / 2) ** 2
    apart = c2 * (np.sin((other - one) / 2) ** 2 + alpha2 * d2) + turned
    density = alpha2 / math.pi * np.square(1 + rest * c2 * d2 / apart)
    return (density / (2 * (h_in * mu_out + h_out * mu_in)))[()]


def brdf(mu_in, mu_out, phi, roughness: float, albedo: float = 1.0) -> np.ndarray:
    """Bidirectional reflectance distribution function of `Glossy(roughness, albedo)`.

    Parameters
    ----------
    mu_in : float or ndarray
        Cosine of the direction towards the light, in (0, 1] [1].
    mu_out : float or ndarray
        Cosine of the direction of reflection, in (0, 1] [1].
    phi : float or ndarray
        Azimuth between the two directions, pi on the specular side [rad].
    roughness : float
        Roughness alpha, in (0, 1] [1].
    albedo : float or ndarray, default 1.0
        Reflected share at every angle of incidence [1].

    Returns
    -------
    float or ndarray
        BRDF [sr^-1]; its integral with mu_out over the hemisphere is the albedo.

    Examples
    --------
    >>> import math
    >>> from transport.theory.microfacets import brdf
    >>> print(f"{brdf(0.5, 0.5, math.pi, 0.5):.4g}")
    1.059
    """
    table = lobe(roughness)
    lost = table.lost(mu_in) * table.lost(mu_out)
    again = lost / (math.pi * table.mean_lost)
    return (albedo * (single_reflection(mu_in, mu_out, phi, roughness) + again))[()]


def single_albedo(mu: np.ndarray, roughness: float) -> np.ndarray:
    """Share of the light at a cosine that a single reflection returns.

    Parameters
    ----------
    mu : float or ndarray
        Cosine to the surface's normal [1].
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    float or ndarray
        E(mu) [1].

    Examples
    --------
    >>> from transport.theory.microfacets import single_albedo
    >>> print(f"{single_albedo(0.5, 0.5):.4g}")
    0.6983
    """
    return (1 - lobe(roughness).lost(mu))[()]


def lost_albedo(mu: np.ndarray, roughness: float) -> np.ndarray:
    """Share of the light at a cosine that a single reflection loses, with full relative accuracy.

    Parameters
    ----------
    mu : float or ndarray
        Cosine to the surface's normal [1].
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    float or ndarray
        ``1 - E(mu)`` [1].

    Examples
    --------
    >>> from transport.theory.microfacets import lost_albedo
    >>> print(f"{lost_albedo(0.5, 0.5):.4g}")
    0.3017
    """
    return lobe(roughness).lost(mu)[()]


def mean_albedo(roughness: float) -> float:
    """Share of diffuse light that a single reflection returns.

    Parameters
    ----------
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    float
        ``E_mean = 2 int_0^1 E mu dmu`` [1].

    Examples
    --------
    >>> from transport.theory.microfacets import mean_albedo
    >>> print(f"{mean_albedo(0.5):.4g}")
    0.7002
    """
    return 1 - lobe(roughness).mean_lost


def lobe_density(mu: np.ndarray, roughness: float) -> np.ndarray:
    """Density of the cosine with which the second lobe leaves.

    Parameters
    ----------
    mu : float or ndarray
        Cosine to the surface's normal [1].
    roughness : float
        Roughness alpha, in (0, 1] [1].

    Returns
    -------
    float or ndarray
        ``2 (1 - E) mu / (1 - E_mean)`` [1].

    Examples
    --------
    >>> from transport.theory.microfacets import lobe_density
    >>> print(f"{lobe_density(0.5, 0.5):.4g}")
    1.007
    """
    return (2 * lobe(roughness).lost(mu) * np.asarray(mu, float) / lobe(roughness).mean_lost)[()]


def _cosine_and_h(mu, roughness: float) -> tuple[np.ndarray, np.ndarray]:
    mu = np.asarray(mu, float)
    return mu, np.hypot(mu, roughness * np.sqrt((1 - mu) * (1 + mu)))
