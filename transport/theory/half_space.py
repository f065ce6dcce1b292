"""Half spaces: diffuse reflection by Chandrasekhar's H function; Milne's problem and thick slabs.

Isotropic scattering of albedo a below a plane that does not reflect. A beam of irradiance E at the
cosine mu0 is reflected with the radiance

    L(mu) = a/(4 pi) H(mu) H(mu0)/(mu + mu0) E    (law of diffuse reflection; Chandrasekhar 1960, ch. 4)

so that the share 1 - sqrt(1 - a) H(mu0) of it is reflected, and of Lambertian light 1 - 2 sqrt(1 - a)
alpha_1, alpha_n the moments of H. H solves H = 1 + (a/2) mu H int_0^1 H(mu')/(mu + mu') dmu'; in closed
form (ch. 5)

    ln H(mu) = -(1/pi) int_0^inf ln[1 - a atan(t)/t]/(1 + x^2) dx,    t = x/mu.

Milne's problem: a medium without absorption with the flux F from a source at infinite depth. The
emerging radiance is L(mu) = sqrt(3)/(4 pi) H(mu) F, and far below the surface the mean radiance rises
as tau + q, with q(inf) = alpha_2/alpha_1 = 0.710446 (Hopf 1934). Two such surfaces make a thick slab,
which transmits

    T = (4/3)/((1 - g) tau + 2 q)    of Lambertian light,
    T(mu0) = H(mu0)/(sqrt(3) (tau + 2 q))    of a beam, if scattering is isotropic,

up to terms of exp(-tau) (van de Hulst 1980), so that T determines q.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from transport.theory import ordinates

STEP, REACH = 0.25, 42.0  # trapezoidal rule in log x; its errors are exp(-pi^2/STEP) and exp(-REACH)
SERIES_BELOW = 0.1  # t below which 1 - atan(t)/t is computed by a series
HEMISPHERE = ordinates.gauss(ordinates.graded_edges(1.0, 0.5))  # quadrature for mu log mu
THICK_DEPTH = 40.0  # (1 - g) tau of the slab whose transmission determines q


def h_function(mu: np.ndarray, albedo: float) -> np.ndarray:
    """Chandrasekhar's H function for isotropic scattering.

    Parameters
    ----------
    mu : ndarray
        Cosines, from 0 to 1 [1].
    albedo : float
        Single-scattering albedo a, from 0 to 1 [1].

    Returns
    -------
    ndarray
        H(mu), shape of `mu` [1]; H(0) = 1.

    Raises
    ------
    ValueError
        If the albedo is not in [0, 1].

    Notes
    -----
    Good to 1e-14: in log x the integrand is analytic within pi/2 of the real line and falls as
    ``exp(-|log x|)``, so that the trapezoidal rule is exact up to rounding (Chandrasekhar 1960, ch. 5).

    Examples
    --------
    >>> from transport.theory.half_space import h_function
    >>> print(f"{h_function(1.0, 1.0):.4g}")
    2.908
    """
    if not 0 <= albedo <= 1:
        raise ValueError(f"h_function: albedo must be from 0 to 1, got {albedo}")
    x = np.exp(np.arange(-REACH, REACH + STEP / 2, STEP))
    u = np.asarray(mu, dtype=float)[..., None] / x
    depth = np.log((1 - albedo) + albedo * _one_minus_atan_ratio(u))
    return np.exp(-STEP / math.pi * (depth @ (x / (1 + x * x))))


def _one_minus_atan_ratio(u: np.ndarray) -> np.ndarray:
    """Return 1 - atan(t)/t with t = 1/u, by its series for small t."""
    t = 1 / np.maximum(u, 1 / SERIES_BELOW)
    series = -sum((-t * t) ** k / (2 * k + 1) for k in range(1, 10))
    return np.where(u > 1 / SERIES_BELOW, series, 1 - u * np.arctan2(1.0, u))


def h_moment(power: int, albedo: float) -> float:
    """Moment of the H function.

    Parameters
    ----------
    power : int
        n, at least 0.
    albedo : float
        Single-scattering albedo a, from 0 to 1 [1].

    Returns
    -------
    float
        ``alpha_n = int_0^1 H mu^n dmu`` [1].

    Examples
    --------
    >>> from transport.theory.half_space import h_moment
    >>> print(f"{h_moment(1, 1.0):.4g}")
    1.155
    """
    mu, weight = HEMISPHERE
    return float(weight @ (h_function(mu, albedo) * mu**power))


def plane_albedo(mu0: np.ndarray, albedo: float) -> np.ndarray:
    """Share of a beam that a half space reflects.

    Parameters
    ----------
    mu0 : ndarray
        Cosines of incidence [1].
    albedo : float
        Single-scattering albedo a, from 0 to 1 [1].

    Returns
    -------
    ndarray
        ``1 - sqrt(1 - a) H(mu0)``, shape of `mu0` [1].

    Notes
    -----
    Source: Chandrasekhar 1960, ch. 5.

    Examples
    --------
    >>> from transport.theory.half_space import plane_albedo
    >>> print(f"{plane_albedo(1.0, 0.9):.4g}")
    0.4149
    """
    return 1 - math.sqrt(1 - albedo) * h_function(mu0, albedo)


def spherical_albedo(albedo: float) -> float:
    """Share of Lambertian light that a half space reflects: mean of the plane albedo, as for a planet.

    Parameters
    ----------
    albedo : float
        Single-scattering albedo a, from 0 to 1 [1].

    Returns
    -------
    float
        ``1 - 2 sqrt(1 - a) alpha_1`` [1].

    Examples
    --------
    >>> from transport.theory.half_space import spherical_albedo
    >>> print(f"{spherical_albedo(0.9):.4g}")
    0.478
    """
    return 1 - 2 * math.sqrt(1 - albedo) * h_moment(1, albedo)


def darkening(mu: np.ndarray, mu0: float | None, albedo: float) -> np.ndarray:
    """Radiance reflected by a half space per incident irradiance.

    Parameters
    ----------
    mu : ndarray
        Cosines of reflection [1].
    mu0 : float or None
        Cosine of incidence [1]; None: Lambertian light.
    albedo : float
        Single-scattering albedo a, from 0 to 1 [1].

    Returns
    -------
    ndarray
        Radiance per irradiance, shape of `mu` [sr^-1].

    Notes
    -----
    Law of diffuse reflection. For Lambertian light it is ``(1 - sqrt(1 - a) H(mu))/pi``, the plane
    albedo over pi by reciprocity.

    Examples
    --------
    >>> from transport.theory.half_space import darkening
    >>> print(f"{darkening(1.0, 0.5, 0.9):.4g}")
    0.1375
    """
    if mu0 is None:
        return plane_albedo(mu, albedo) / math.pi
    mu = np.asarray(mu, dtype=float)
    return albedo / (4 * math.pi) * h_function(mu, albedo) * h_function(mu0, albedo) / (mu + mu0)


def darkening_in(edges: np.ndarray, mu0: float | None, albedo: float) -> np.ndarray:
    """Shares of the incident flux that are reflected into bins of cosine.

    Parameters
    ----------
    edges : ndarray
        Edges of the bins of cosine, increasing in [0, 1], shape (bins + 1,) [1].
    mu0 : float or None
        Cosine of incidence [1]; None: Lambertian light.
    albedo : float
        Single-scattering albedo a, from 0 to 1 [1].

    Returns
    -------
    ndarray
        ``2 pi int L mu dmu`` per bin, shape (bins,) [1].

    Examples
    --------
    >>> from transport.theory.half_space import darkening_in
    >>> print(darkening_in([0.0, 0.5, 1.0], 1.0, 0.9).round(4))
    [0.1103 0.3046]
    """
    return _in_bins(lambda mu: darkening(mu, mu0, albedo), edges)


def milne_radiance(mu: np.ndarray) -> np.ndarray:
    """Emerging radiance in Milne's problem per net flux density.

    Parameters
    ----------
    mu : ndarray
        Cosines of emission [1].

    Returns
    -------
    ndarray
        ``sqrt(3)/(4 pi) H(mu)``, shape of `mu` [sr^-1].

    Examples
    --------
    >>> from transport.theory.half_space import milne_radiance
    >>> print(f"{milne_radiance(1.0):.4g}")
    0.4008
    """
    return math.sqrt(3) / (4 * math.pi) * h_function(mu, 1.0)


def milne_in(edges: np.ndarray) -> np.ndarray:
    """Shares of the flux that emerge in bins of cosine in Milne's problem.

    Parameters
    ----------
    edges : ndarray
        Edges of the bins of cosine, increasing in [0, 1], shape (bins + 1,) [1].

    Returns
    -------
    ndarray
        Shares, shape (bins,) [1].

    Examples
    --------
    >>> from transport.theory.half_space import milne_in
    >>> print(milne_in([0.0, 0.5, 1.0]).round(4))
    [0.1842 0.8158]
    """
    return _in_bins(milne_radiance, edges)


def _in_bins(radiance, edges: np.ndarray) -> np.ndarray:
    edges = np.asarray(edges, dtype=float)
    cuts = np.union1d(edges, [cut for cut in ordinates.graded_edges(1.0, 0.5) if edges[0] < cut < edges[-1]])
    mu, weight = ordinates.gauss(cuts)
    parts = (2 * math.pi * weight * mu * radiance(mu)).reshape(len(cuts) - 1, -1).sum(axis=1)
    return np.add.reduceat(parts, np.searchsorted(cuts, edges[:-1]))


@lru_cache(maxsize=1)
def hopf_constant() -> float:
    """Extrapolation distance q(inf) of Milne's problem.

    Returns
    -------
    float
        ``alpha_2/alpha_1`` of H for a = 1 [mean free paths].

    Notes
    -----
    Source: Hopf 1934.

    Examples
    --------
    >>> from transport.theory.half_space import hopf_constant
    >>> print(f"{hopf_constant():.4g}")
    0.7104
    """
    return h_moment(2, 1.0) / h_moment(1, 1.0)


@lru_cache(maxsize=32)
def extrapolation(moments: tuple[float, ...] = ordinates.ISOTROPIC) -> float:
    """Extrapolation distance q for any phase function without absorption.

    Parameters
    ----------
    moments : tuple of float, default ordinates.ISOTROPIC
        Legendre moments of the phase function, from 1 on [1].

    Returns
    -------
    float
        q in units of 1/(1 - g) mean free paths [1].

    Notes
    -----
    Determined from the transmission of a slab with (1 - g) tau = THICK_DEPTH. It is 0.710446 for isotropic
    scattering, 0.7114 for Rayleigh scattering, 0.7143 for Henyey and Greenstein's with g = 0.9.

    Examples
    --------
    >>> from transport.theory.half_space import extrapolation
    >>> print(f"{extrapolation():.4g}")
    0.7104
    """
    if moments == ordinates.ISOTROPIC:
        return hopf_constant()
    depth = THICK_DEPTH / (1 - moments[1])
    return measured_extrapolation(ordinates.slab(depth, 1.0, moments, None).transmitted, THICK_DEPTH)


def measured_extrapolation(transmission: float, depth: float) -> float:
    """Extrapolation distance q from the Lambertian transmission of a thick slab.

    Parameters
    ----------
    transmission : float
        Transmitted share [1].
    depth : float
        ``(1 - g) tau`` [1].

    Returns
    -------
    float
        ``(4/(3 T) - depth)/2`` [1].

    Examples
    --------
    >>> from transport.theory.half_space import measured_extrapolation
    >>> print(f"{measured_extrapolation(0.032, 40.0):.4g}")
    0.8333
    """
    return (4 / 3 / transmission - depth) / 2


def thick_slab(depth: float, moments: tuple[float, ...] = ordinates.ISOTROPIC) -> float:
    """Share of Lambertian light that a thick slab without absorption transmits.

    Parameters
    ----------
    depth : float
        Optical depth tau [1].
    moments : tuple of float, default ordinates.ISOTROPIC
        Legendre moments of the phase function, from 1 on [1].

    Returns
    -------
    float
        ``(4/3)/((1 - g) tau + 2 q)`` [1], with a relative error of about exp(-tau); T + R = 1.

    Notes
    -----
    Source: van de Hulst 1980.

    Examples
    --------
    >>> from transport.theory.half_space import thick_slab
    >>> print(f"{thick_slab(40.0):.4g}")
    0.03219
    """
    g = moments[1] if len(moments) > 1 else 0.0
    return 4 / 3 / ((1 - g) * depth + 2 * extrapolation(moments))


def thick_slab_beam(depth: float, mu0: float) -> float:
    """Share of a beam that a thick slab transmits, for isotropic scattering without absorption.

    Parameters
    ----------
    depth : float
        Optical depth tau [1].
    mu0 : float
        Cosine of incidence [1].

    Returns
    -------
    float
        ``H(mu0)/(sqrt(3) (tau + 2 q))`` [1].

    Notes
    -----
    The Lambertian share times ``(sqrt(3)/4) H(mu0)`` of Milne's problem, by reciprocity.

    Examples
    --------
    >>> from transport.theory.half_space import thick_slab_beam
    >>> print(f"{thick_slab_beam(40.0, 1.0):.4g}")
    0.04053
    """
    return float(h_function(mu0, 1.0)) / (math.sqrt(3) * (depth + 2 * hopf_constant()))
