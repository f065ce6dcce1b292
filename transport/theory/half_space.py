"""Half spaces: what a medium without end returns, by Chandrasekhar's H function; Milne's problem, thick slabs.

For isotropic scattering of albedo a below a plane without reflection, light of irradiance E that comes at the
cosine mu0 returns with the radiance

    L(mu) = a/(4 pi) H(mu) H(mu0)/(mu + mu0) E    (law of diffuse reflection; Chandrasekhar 1960, ch. 4)

so that 1 - sqrt(1 - a) H(mu0) of it returns, and of Lambertian light 1 - 2 sqrt(1 - a) alpha_1, alpha_n the
moments of H.  H solves H = 1 + (a/2) mu H int_0^1 H(mu')/(mu + mu') dmu'; in closed form (ch. 5)

    ln H(mu) = -(1/pi) int_0^inf ln[1 - a atan(t)/t]/(1 + x^2) dx,    t = x/mu.

Milne's problem: a medium without absorption that carries the flux F from its depth.  What leaves it is L(mu)
= sqrt(3)/(4 pi) H(mu) F, and far below the surface the mean radiance rises as tau + q, q(inf) =
alpha_2/alpha_1 = 0.710446 (Hopf 1934).  Two such surfaces make a thick slab, which transmits

    T = (4/3)/((1 - g) tau + 2 q)    of Lambertian light,
    T(mu0) = H(mu0)/(sqrt(3) (tau + 2 q))    of a beam, if scattering is isotropic,

up to terms of exp(-tau) (van de Hulst 1980): so q is measured by T.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from transport.theory import ordinates

STEP, REACH = 0.25, 42.0  # of the trapezoidal rule in log x: exp(-pi^2/STEP) and exp(-REACH) are left out
SMALL = 0.1  # t, below which 1 - atan(t)/t is a series
HEMISPHERE = ordinates.gauss(ordinates.graded_edges(1.0, 0.5))  # nodes and weights for what has mu log mu
THICK = 40.0  # (1 - g) tau of a slab whose transmission tells q


def h_function(mu: np.ndarray, albedo: float) -> np.ndarray:
    """Chandrasekhar's H(mu) for isotropic scattering [1]; H(0) = 1.  Vectorised over mu, from 0 to 1.

    albedo: from 0 to 1.  Good to 1e-14: in log x the integrand is analytic within pi/2 of the real line and
    falls as exp(-|log x|), so that a trapezoidal rule is exact to rounding.
    """
    if not 0 <= albedo <= 1:
        raise ValueError(f"h_function: albedo must be from 0 to 1, got {albedo}")
    x = np.exp(np.arange(-REACH, REACH + STEP / 2, STEP))
    u = np.asarray(mu, dtype=float)[..., None] / x
    depth = np.log((1 - albedo) + albedo * _lacking(u))
    return np.exp(-STEP / math.pi * (depth @ (x / (1 + x * x))))


def _lacking(u: np.ndarray) -> np.ndarray:
    """1 - atan(t)/t with t = 1/u, by its series where t is small."""
    t = 1 / np.maximum(u, 1 / SMALL)
    series = -sum((-t * t) ** k / (2 * k + 1) for k in range(1, 10))
    return np.where(u > 1 / SMALL, series, 1 - u * np.arctan2(1.0, u))


def h_moment(power: int, albedo: float) -> float:
    """alpha_n, the moment int_0^1 H mu^n dmu [1]."""
    mu, weight = HEMISPHERE
    return float(weight @ (h_function(mu, albedo) * mu**power))


def plane_albedo(mu0: np.ndarray, albedo: float) -> np.ndarray:
    """Share of a beam at mu0 that a half space returns [1] (Chandrasekhar 1960, ch. 5).  Vectorised."""
    return 1 - math.sqrt(1 - albedo) * h_function(mu0, albedo)


def spherical_albedo(albedo: float) -> float:
    """Share of Lambertian light that a half space returns [1]: the plane albedo's mean, as of a planet."""
    return 1 - 2 * math.sqrt(1 - albedo) * h_moment(1, albedo)


def darkening(mu: np.ndarray, mu0: float | None, albedo: float) -> np.ndarray:
    """Radiance that returns at the cosines mu from a half space, per irradiance of a beam at mu0 [sr^-1].
    Vectorised.

    mu0 = None: of Lambertian light, (1 - sqrt(1 - a) H(mu))/pi, which is the plane albedo by reciprocity.
    """
    if mu0 is None:
        return plane_albedo(mu, albedo) / math.pi
    mu = np.asarray(mu, dtype=float)
    return albedo / (4 * math.pi) * h_function(mu, albedo) * h_function(mu0, albedo) / (mu + mu0)


def darkening_in(edges: np.ndarray, mu0: float | None, albedo: float) -> np.ndarray:
    """Shares of the incident flux that return in bins of cosine, (bins,) [1]: 2 pi int L mu dmu."""
    return _in_bins(lambda mu: darkening(mu, mu0, albedo), edges)


def milne_radiance(mu: np.ndarray) -> np.ndarray:
    """Radiance that leaves in Milne's problem, per net flux [sr^-1]: sqrt(3)/(4 pi) H(mu).  Vectorised."""
    return math.sqrt(3) / (4 * math.pi) * h_function(mu, 1.0)


def milne_in(edges: np.ndarray) -> np.ndarray:
    """Shares of the flux that leave in bins of cosine in Milne's problem, (bins,) [1]."""
    return _in_bins(milne_radiance, edges)


def _in_bins(radiance, edges: np.ndarray) -> np.ndarray:
    edges = np.asarray(edges, dtype=float)
    cuts = np.union1d(edges, [cut for cut in ordinates.graded_edges(1.0, 0.5) if edges[0] < cut < edges[-1]])
    mu, weight = ordinates.gauss(cuts)
    parts = (2 * math.pi * weight * mu * radiance(mu)).reshape(len(cuts) - 1, -1).sum(axis=1)
    return np.add.reduceat(parts, np.searchsorted(cuts, edges[:-1]))


@lru_cache(maxsize=1)
def hopf_constant() -> float:
    """q(inf) of Milne's problem, in mean free paths [1]: alpha_2/alpha_1 of H for a = 1 (Hopf 1934)."""
    return h_moment(2, 1.0) / h_moment(1, 1.0)


@lru_cache(maxsize=32)
def extrapolation(moments: tuple[float, ...] = ordinates.ISOTROPIC) -> float:
    """q of any phase function without absorption, in units of 1/(1 - g) mean free paths [1].

    Read off from the transmission of a slab that is THICK; 0.710446 if isotropic, 0.7114 for Rayleigh
    scattering, 0.7143 for that of Henyey and Greenstein at g = 0.9.
    """
    if moments == ordinates.ISOTROPIC:
        return hopf_constant()
    depth = THICK / (1 - moments[1])
    return measured_extrapolation(ordinates.slab(depth, 1.0, moments, None).transmitted, THICK)


def measured_extrapolation(transmission: float, depth: float) -> float:
    """q by the Lambertian transmission of a thick slab of depth (1 - g) tau [1]."""
    return (4 / 3 / transmission - depth) / 2


def thick_slab(depth: float, moments: tuple[float, ...] = ordinates.ISOTROPIC) -> float:
    """Share of Lambertian light that a thick slab without absorption transmits [1]: (4/3)/((1 - g) tau + 2
    q).

    depth: tau.  Relative error exp(-tau) or so; T + R = 1.
    """
    g = moments[1] if len(moments) > 1 else 0.0
    return 4 / 3 / ((1 - g) * depth + 2 * extrapolation(moments))


def thick_slab_beam(depth: float, mu0: float) -> float:
    """Share of a beam at the cosine mu0 that a thick slab transmits, isotropic, without absorption [1].

    H(mu0)/(sqrt(3) (tau + 2 q)): the Lambertian share times (sqrt(3)/4) H(mu0) of Milne's problem, by
    reciprocity.
    """
    return float(h_function(mu0, 1.0)) / (math.sqrt(3) * (depth + 2 * hopf_constant()))
