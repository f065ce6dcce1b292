"""Enclosures with diffuse walls, mean chords, equilibrium of radiation, integrating spheres.

The relations of closed enclosures do not require the radiosity equation.

Irradiance E falls on a wall; exitance M, emitted plus reflected, is its radiosity; rho is the albedo.
All reflected light falls on a wall again, so that sums over all walls are exact for any shape.
Pointwise relations are exact only for a uniform enclosure and for a sphere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np


def absorbed_power(albedos, fluxes_in) -> float:
    """Power absorbed by the walls of an enclosure.

    Parameters
    ----------
    albedos : array_like
        Albedo of each wall, shape (walls,) [1].
    fluxes_in : array_like
        Flux onto each wall, shape (walls,) [W].

    Returns
    -------
    float
        Sum of ``(1 - rho_i) Phi_i`` [W]; in a closed enclosure it equals the emitted power.

    Examples
    --------
    >>> from transport.theory.enclosures import absorbed_power
    >>> print(f"{absorbed_power([0.5, 0.8], [1.0, 2.0]):.4g}")
    0.9
    """
    return float(np.sum((1 - np.asarray(albedos, dtype=float)) * np.asarray(fluxes_in, dtype=float)))


def total_flux_in(power: float, albedo: float) -> float:
    """Flux onto all walls together, for walls of one albedo.

    Parameters
    ----------
    power : float
        Emitted power P [W].
    albedo : float
        Albedo rho of all walls, below 1 [1].

    Returns
    -------
    float
        ``P / (1 - rho)`` [W], for any shape and any emission.

    Notes
    -----
    The geometric series of reflections. Over P it is the mean number of wall hits per particle.

    Examples
    --------
    >>> from transport.theory.enclosures import total_flux_in
    >>> print(f"{total_flux_in(1.0, 0.9):.4g}")
    10
    """
    return power / (1 - albedo)


def mean_irradiance(power: float, albedo: float, area: float) -> float:
    """Irradiance averaged over all walls, for walls of one albedo.

    Parameters
    ----------
    power : float
        Emitted power P [W].
    albedo : float
        Albedo rho of all walls, below 1 [1].
    area : float
        Area A of all walls [m^2].

    Returns
    -------
    float
        ``P / ((1 - rho) A)`` [W m^-2].

    Examples
    --------
    >>> from transport.theory.enclosures import mean_irradiance
    >>> print(f"{mean_irradiance(1.0, 0.9, 6.0):.4g}")
    1.667
    """
    return total_flux_in(power, albedo) / area


def emitted_exitance(exitance: float, irradiance: float, albedo: float) -> float:
    """Exitance that a diffuse wall emits by itself.

    Parameters
    ----------
    exitance : float
        Exitance M, emitted plus reflected [W m^-2].
    irradiance : float
        Irradiance E [W m^-2].
    albedo : float
        Albedo rho of the wall [1].

    Returns
    -------
    float
        ``M - rho E`` [W m^-2].

    Notes
    -----
    Source: the radiosity equation (Goral et al. 1984).

    Examples
    --------
    >>> from transport.theory.enclosures import emitted_exitance
    >>> print(f"{emitted_exitance(2.0, 3.0, 0.5):.4g}")
    0.5
    """
    return exitance - albedo * irradiance


def furnace_irradiance(emitted: float, albedo: float) -> float:
    """Irradiance in a furnace: all walls emit the same exitance and have the same albedo.

    Parameters
    ----------
    emitted : float
        Exitance M0 that every wall emits by itself [W m^-2].
    albedo : float
        Albedo rho of all walls, below 1 [1].

    Returns
    -------
    float
        ``M0 / (1 - rho)`` [W m^-2], uniform.

    Notes
    -----
    The exitance is the same, so that the shape is invisible from inside (Kirchhoff 1860).

    Examples
    --------
    >>> from transport.theory.enclosures import furnace_irradiance
    >>> print(f"{furnace_irradiance(1.0, 0.5):.4g}")
    2
    """
    return emitted / (1 - albedo)


def furnace_radiance(emitted: float, albedo: float) -> float:
    """Radiance at every point and in every direction of a furnace.

    Parameters
    ----------
    emitted : float
        Exitance M0 that every wall emits by itself [W m^-2].
    albedo : float
        Albedo rho of all walls, below 1 [1].

    Returns
    -------
    float
        ``M0 / (pi (1 - rho))`` [W m^-2 sr^-1].

    Examples
    --------
    >>> from transport.theory.enclosures import furnace_radiance
    >>> print(f"{furnace_radiance(1.0, 0.5):.4g}")
    0.6366
    """
    return furnace_irradiance(emitted, albedo) / math.pi


def sphere_wall_exitance(power: float, albedo: float, area: float, port_share: float = 0.0) -> float:
    """Exitance by reflection of an integrating sphere's wall.

    Parameters
    ----------
    power : float
        Power P that first strikes the wall [W].
    albedo : float
        Albedo rho of the wall [1].
    area : float
        Area A of the whole sphere [m^2].
    port_share : float, default 0.0
        Share f of the sphere's area that only absorbs [1].

    Returns
    -------
    float
        ``rho / (1 - rho (1 - f)) * P / A`` [W m^-2].

    Notes
    -----
    Uniform, because a patch of a sphere irradiates all others equally (Ulbricht 1900; Goebel 1967).

    Examples
    --------
    >>> from transport.theory.enclosures import sphere_wall_exitance
    >>> print(f"{sphere_wall_exitance(1.0, 0.9, 1.0, 0.05):.4g}")
    6.207
    """
    return albedo / (1 - albedo * (1 - port_share)) * power / area


def sphere_irradiance_of_wall_patch(power: float, albedo: float, area: float) -> float:
    """Irradiance in a closed diffuse sphere lit by a Lambertian patch of its wall.

    Parameters
    ----------
    power : float
        Emitted power P [W].
    albedo : float
        Albedo rho of all walls, below 1 [1].
    area : float
        Area A of the sphere [m^2].

    Returns
    -------
    float
        ``P / ((1 - rho) A)`` [W m^-2], at every point.

    Notes
    -----
    The mean is the value at each point because the direct light is uniform too (Ulbricht 1900).

    Examples
    --------
    >>> from transport.theory.enclosures import sphere_irradiance_of_wall_patch
    >>> print(f"{sphere_irradiance_of_wall_patch(1.0, 0.9, 1.0):.4g}")
    10
    """
    return mean_irradiance(power, albedo, area)


# ---- Mean chords of convex bodies along uniform, isotropic straight lines.
#
# Such lines leave a diffuse inner wall: the same number per area, with the cosine law. Their mean chord
# is 4 V/S for every convex body (Cauchy 1850; Dirac 1943; Coleman 1969, J. Appl. Prob. 6, 430).


def mean_chord(volume: float, surface: float) -> float:
    """Mean chord of a convex body.

    Parameters
    ----------
    volume : float or ndarray
        Volume V [m^3].
    surface : float or ndarray
        Surface area S [m^2].

    Returns
    -------
    float or ndarray
        ``4 V/S`` [m].

    Notes
    -----
    Source: Cauchy 1850.

    Examples
    --------
    >>> from transport.theory.enclosures import mean_chord
    >>> print(f"{mean_chord(1.0, 6.0):.4g}")
    0.6667
    """
    return 4 * np.divide(volume, surface)


def sphere_mean_chord(radius: float) -> float:
    """Mean chord of a sphere.

    Parameters
    ----------
    radius : float
        Radius R [m].

    Returns
    -------
    float
        ``4 R/3`` [m].

    Examples
    --------
    >>> from transport.theory.enclosures import sphere_mean_chord
    >>> print(f"{sphere_mean_chord(1.0):.4g}")
    1.333
    """
    return 4 / 3 * radius


def box_mean_chord(size: Sequence[float]) -> float:
    """Mean chord of a box.

    Parameters
    ----------
    size : sequence of float
        The three side lengths a, b, c [m].

    Returns
    -------
    float
        ``2 / (1/a + 1/b + 1/c)`` [m].

    Examples
    --------
    >>> from transport.theory.enclosures import box_mean_chord
    >>> print(f"{box_mean_chord((1.0, 2.0, 3.0)):.4g}")
    1.091
    """
    return 2 / math.fsum(1 / length for length in size)


# ---- Equilibrium of radiation: the escape cone, and a chi-square test of many correlated bins at once.


def escape_cosine(index: float) -> float:
    """Cosine of the critical angle within a body.

    Parameters
    ----------
    index : float
        Index n of the body over that of its surroundings, at least 1 [1].

    Returns
    -------
    float
        ``sqrt(1 - 1/n^2)`` [1]. Light that entered by refraction is within this cone about the normal.

    Raises
    ------
    ValueError
        If the index is below 1.

    Examples
    --------
    >>> from transport.theory.enclosures import escape_cosine
    >>> print(f"{escape_cosine(1.5):.4g}")
    0.7454
    """
    if not index >= 1:
        raise ValueError(f"escape_cosine: index must be 1 or more, got {index!r}")
    return math.sqrt((index - 1) * (index + 1)) / index


def chi_square_values(deviations: np.ndarray, weights: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Batch values whose mean is X^2 over its expectation and whose standard error is that of X^2.

    Parameters
    ----------
    deviations : ndarray
        Deviation of each batch from the expectation in K bins, shape (B, K).
    weights : ndarray
        Weights of the bins, best proportional to the inverse variances, shape (K,).
    sizes : ndarray
        Histories per batch, shape (B,).

    Returns
    -------
    ndarray
        Batch values, shape (B,) [1]; nan for fewer than three batches.

    Notes
    -----
    ``X^2 = sum w (mean of d)^2``. Let ``G_ab = sum w d_a d_b``. For two different batches G has the
    expectation ``sum w bias^2``, for any distributions and correlations of the bins (Chen, Qin 2010,
    Ann. Stat. 38, 808). So X^2 exceeds its expectation by U/V, with U the mean of G over such pairs and
    V = ``sum w variance of the means``, from the spread of the batches.

    Without bias all G_ab are uncorrelated with one variance T. The variance of U is
    ``2 T/(B (B - 1))``, and the means S_b of G_ab over a have the variance ``T (B - 2)/(B - 1)^2``. The
    batch values are 1 + U/V, with the spread ``sqrt(2 (B - 1)/(B - 2)) S_b/V``. If many bins
    contribute, X^2 is normally distributed, and its excess divided by its error follows Student's t
    with B - 1 degrees of freedom.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.enclosures import chi_square_values
    >>> d = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, -1.0]])
    >>> print(chi_square_values(d, np.ones(2), np.ones(3)).round(4))
    [ 0.5  0.5 -1. ]
    """
    scaled = np.asarray(deviations, float) * np.sqrt(weights)
    batches, shares = len(scaled), np.asarray(sizes, float)
    if batches < 3:
        return np.full(batches, math.nan)
    gram = (scaled @ scaled.T) * np.sqrt(np.outer(shares, shares)) / shares.mean()
    rows = (gram.sum(axis=1) - np.diag(gram)) / (batches - 1)
    excess = rows.mean()
    noise = (np.trace(gram) / batches - excess) / batches
    spread = math.sqrt(2 * (batches - 1) / (batches - 2))
    with np.errstate(divide="ignore", invalid="ignore"):  # if nothing was counted, the noise is 0
        return 1 + (excess + spread * (rows - excess)) / noise


# ---- Integrating sphere: irradiance and radiosity of its diffuse wall for light sent in.
#
# The chord between two points of a sphere makes the same angle with both normals, so that cosθ cosθ'/π
# r² = 1/A: light that leaves any point of the inside with the cosine law irradiates all of it uniformly
# (Ulbricht 1900; Sumpner 1892). Only the shares of the area matter, not the positions of the ports. With
# the albedos a_i on the shares f_i of the sphere's area A (an open port has albedo 0), reflected light is
# reflected again with the probability
#
#     a = Σ a_i f_i,
#
# and series of reflections are geometric (Jacquez, Kuppenheim 1955; Goebel 1967). "Lamp": a point source
# at the center irradiates the whole sphere uniformly, open ports included. "Beam": all of the flux first
# strikes one point of the wall.


def mean_albedo(albedos, shares) -> float:
    """Mean albedo of the whole inside of the sphere.

    Parameters
    ----------
    albedos : array_like
        Albedos a_i of the parts, 0 for open ports, shape (parts,) [1].
    shares : array_like
        Shares f_i of the sphere's area, shape (parts,) [1].

    Returns
    -------
    float
        ``Σ a_i f_i`` [1].

    Examples
    --------
    >>> from transport.theory.enclosures import mean_albedo
    >>> print(f"{mean_albedo([0.95, 0.0], [0.96, 0.04]):.4g}")
    0.912
    """
    return float(np.dot(albedos, shares))


def multiplier(albedo: float, port_share: float) -> float:
    """Sphere multiplier of a wall of one albedo and an open port.

    Parameters
    ----------
    albedo : float or ndarray
        Albedo a of the wall [1].
    port_share : float or ndarray
        Share f of the sphere's area that is open [1].

    Returns
    -------
    float or ndarray
        ``M = a / (1 - a (1 - f))`` [1].

    Notes
    -----
    The radiosity of the wall for a lamp is M Phi/A and its radiance M Phi/(pi A). For a beam that
    strikes the wall, the reflected flux adds up to M Phi and gives the irradiance M Phi/A at any other
    point.

    Examples
    --------
    >>> from transport.theory.enclosures import multiplier
    >>> print(f"{multiplier(0.95, 0.04):.4g}")
    10.8
    """
    return albedo / (1 - albedo * (1 - np.asarray(port_share, dtype=float)))


def lamp_irradiance(flux: float, mean_albedo: float, area: float) -> float:
    """Irradiance of a lamp at any point of the sphere, direct and reflected.

    Parameters
    ----------
    flux : float or ndarray
        Incident flux Phi [W].
    mean_albedo : float or ndarray
        Mean albedo a of the whole inside, below 1 [1].
    area : float or ndarray
        Area A of the whole sphere [m^2].

    Returns
    -------
    float or ndarray
        ``Phi / (A (1 - a))`` [W m^-2].

    Examples
    --------
    >>> from transport.theory.enclosures import lamp_irradiance
    >>> print(f"{lamp_irradiance(1.0, 0.9, 1.0):.4g}")
    10
    """
    return flux / area / (1 - np.asarray(mean_albedo, dtype=float))


def lamp_hits(wall_share: float, mean_albedo: float) -> float:
    """Mean number of times that a lamp's particle strikes parts of the sphere.

    Parameters
    ----------
    wall_share : float or ndarray
        Share of the sphere's area of these parts [1].
    mean_albedo : float or ndarray
        Mean albedo a of the whole inside, below 1 [1].

    Returns
    -------
    float or ndarray
        ``f / (1 - a)`` [1].

    Examples
    --------
    >>> from transport.theory.enclosures import lamp_hits
    >>> print(f"{lamp_hits(0.96, 0.9):.4g}")
    9.6
    """
    return wall_share / (1 - np.asarray(mean_albedo, dtype=float))


def beam_irradiance(flux: float, albedo: float, mean_albedo: float, area: float) -> float:
    """Irradiance by the reflected light of a beam at any point.

    Parameters
    ----------
    flux : float or ndarray
        Incident flux Phi [W].
    albedo : float or ndarray
        Albedo a_1 of the part that the beam strikes [1].
    mean_albedo : float or ndarray
        Mean albedo a of the whole inside, below 1 [1].
    area : float or ndarray
        Area A of the whole sphere [m^2].

    Returns
    -------
    float or ndarray
        ``a_1 Phi / (A (1 - a))`` [W m^-2]; M Phi/A for one wall and an open port.

    Examples
    --------
    >>> from transport.theory.enclosures import beam_irradiance
    >>> print(f"{beam_irradiance(1.0, 0.95, 0.9, 1.0):.4g}")
    9.5
    """
    return lamp_irradiance(albedo * flux, mean_albedo, area)


def beam_hits(albedo: float, wall_share: float, mean_albedo: float) -> float:
    """Mean number of times that a beam's particle strikes the wall, including the first.

    Parameters
    ----------
    albedo : float
        Albedo a_1 of the part that the beam strikes [1].
    wall_share : float
        Share f_1 of the sphere's area of this part [1].
    mean_albedo : float
        Mean albedo a of the whole inside, below 1 [1].

    Returns
    -------
    float
        ``1 + a_1 f_1 / (1 - a)`` [1]; 1 / (1 - a (1 - f)) for one wall and an open port.

    Examples
    --------
    >>> from transport.theory.enclosures import beam_hits
    >>> print(f"{beam_hits(0.95, 0.96, 0.912):.4g}")
    11.36
    """
    return 1 + albedo * wall_share / (1 - mean_albedo)
