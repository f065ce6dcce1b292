"""Smooth boundaries of clear media: Snell's law, Fresnel's formulas, refracted radiance.

`cosine` is the cosine of incidence, in [0, 1], and `index_ratio` n = (index beyond the
boundary) / (index on the side of incidence): 1.5 for glass seen from air, 1/1.5 for air seen from
glass. With c the cosine of incidence and q = n cos(refraction) = sqrt(n^2 - 1 + c^2), Fresnel's
amplitudes (1823; Born and Wolf 1999, 1.5.2) are

    r_s = -(n^2 - 1)/(c + q)^2,    r_p = (n^2 - 1) (c q - s^2)/((c + q)(n^2 c + q)),    s^2 = (1 - c)(1 + c)

in which no two nearly equal numbers are subtracted, except at Brewster's angle, where r_p is 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from transport.statistics.quadrature import legendre_nodes

SPLITTER = 2.0**27 + 1  # splits a double into halves (Veltkamp 1968)
NODES, WEIGHTS = legendre_nodes(32)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2  # on [0, 1]
# Panels for t: R_p varies within 1/n^2 of grazing, and beyond t = 40 R is negligible (e^-160).
EDGES = np.concatenate([[0.0], 2.0 ** np.arange(-64, 0), np.arange(1.0, 41.0)])


class Polarised(NamedTuple):
    """Share of the light for each polarisation.

    Parameters
    ----------
    s : ndarray
        Share with the electric field perpendicular to the plane of incidence [1].
    p : ndarray
        Share with the electric field in the plane of incidence [1].
    """

    s: np.ndarray
    p: np.ndarray


def reflectances(cosine: np.ndarray, index_ratio: np.ndarray) -> Polarised:
    """Reflected shares of s- and p-polarised light.

    Parameters
    ----------
    cosine : float or ndarray
        Cosine of incidence, in [0, 1] [1].
    index_ratio : float or ndarray
        Index beyond the boundary over that on the side of incidence [1].

    Returns
    -------
    Polarised
        Reflectances [1]; 1 beyond the critical angle.

    Notes
    -----
    Source: Fresnel 1823, formulas in the module's docstring.

    Examples
    --------
    >>> from transport.theory.fresnel import reflectances
    >>> print(f"{reflectances(0.5, 1.5).s:.4g}")
    0.1766
    """
    c, n, q, is_total = _angles(cosine, index_ratio)
    rise, both, weighted = (n - 1) * (n + 1), _divisor(c + q, is_total), _divisor(n * n * c + q, is_total)
    s = rise / both / both
    p = rise / both * ((c * q - (1 - c) * (1 + c)) / weighted)
    return Polarised(*(np.where(is_total, 1.0, r * r)[()] for r in (s, p)))


def transmittances(cosine: np.ndarray, index_ratio: np.ndarray) -> Polarised:
    """Refracted shares of s- and p-polarised light.

    Parameters
    ----------
    cosine : float or ndarray
        Cosine of incidence, in [0, 1] [1].
    index_ratio : float or ndarray
        Index beyond the boundary over that on the side of incidence [1].

    Returns
    -------
    Polarised
        Transmittances [1], with full relative accuracy at grazing incidence; 0 beyond the critical
        angle.

    Notes
    -----
    Source: Fresnel 1823, formulas in the module's docstring.

    Examples
    --------
    >>> from transport.theory.fresnel import transmittances
    >>> print(f"{transmittances(0.5, 1.5).p:.4g}")
    0.9982
    """
    c, n, q, is_total = _angles(cosine, index_ratio)
    both, weighted = _divisor(c + q, is_total), _divisor(n * n * c + q, is_total)
    s = 4 * (c / both) * (q / both)
    p = 4 * (n * n * c / weighted) * (q / weighted)
    return Polarised(*(np.where(n == 1, 1.0, np.where(is_total, 0.0, t))[()] for t in (s, p)))


def reflectance(cosine: np.ndarray, index_ratio: np.ndarray) -> np.ndarray:
    """Reflected share of unpolarised light.

    Parameters
    ----------
    cosine : float or ndarray
        Cosine of incidence, in [0, 1] [1].
    index_ratio : float or ndarray
        Index beyond the boundary over that on the side of incidence [1].

    Returns
    -------
    float or ndarray
        Mean of both polarisations [1].

    Examples
    --------
    >>> from transport.theory.fresnel import reflectance
    >>> print(f"{reflectance(1.0, 1.5):.4g}")
    0.04
    """
    s, p = reflectances(cosine, index_ratio)
    return (s + p) / 2


def transmittance(cosine: np.ndarray, index_ratio: np.ndarray) -> np.ndarray:
    """Refracted share of unpolarised light.

    Parameters
    ----------
    cosine : float or ndarray
        Cosine of incidence, in [0, 1] [1].
    index_ratio : float or ndarray
        Index beyond the boundary over that on the side of incidence [1].

    Returns
    -------
    float or ndarray
        Mean of both polarisations [1].

    Examples
    --------
    >>> from transport.theory.fresnel import transmittance
    >>> print(f"{transmittance(1.0, 1.5):.4g}")
    0.96
    """
    s, p = transmittances(cosine, index_ratio)
    return (s + p) / 2


def snell_cosine(cosine: np.ndarray, index_ratio: np.ndarray) -> np.ndarray:
    """Cosine of the angle of refraction.

    Parameters
    ----------
    cosine : float or ndarray
        Cosine of incidence, in [0, 1] [1].
    index_ratio : float or ndarray
        Index beyond the boundary over that on the side of incidence [1].

    Returns
    -------
    float or ndarray
        Cosine [1]; nan beyond the critical angle.

    Notes
    -----
    Source: Snell 1621.

    Examples
    --------
    >>> from transport.theory.fresnel import snell_cosine
    >>> print(f"{snell_cosine(0.5, 1.5):.4g}")
    0.8165
    """
    _, n, q, is_total = _angles(cosine, index_ratio)
    return np.where(is_total, math.nan, np.minimum(q / n, 1.0))[()]


def brewster_angle(index_ratio: float) -> float:
    """Angle of incidence at which p-polarised light is not reflected.

    Parameters
    ----------
    index_ratio : float or ndarray
        Index beyond the boundary over that on the side of incidence [1].

    Returns
    -------
    float or ndarray
        ``atan n`` [rad].

    Notes
    -----
    Source: Brewster 1815.

    Examples
    --------
    >>> from transport.theory.fresnel import brewster_angle
    >>> print(f"{brewster_angle(1.5):.4g}")
    0.9828
    """
    return np.arctan(index_ratio)


def critical_angle(index_ratio: float) -> float:
    """Angle of incidence beyond which all light is reflected.

    Parameters
    ----------
    index_ratio : float or ndarray
        Index beyond the boundary over that on the side of incidence [1].

    Returns
    -------
    float or ndarray
        ``asin n`` [rad], at most pi/2.

    Examples
    --------
    >>> from transport.theory.fresnel import critical_angle
    >>> print(f"{critical_angle(1 / 1.5):.4g}")
    0.7297
    """
    return np.arcsin(np.minimum(index_ratio, 1.0))


def plate_transmittance(cosine: np.ndarray, index_ratio: np.ndarray, keeps_polarisation: bool = False):
    """Share of unpolarised light that passes a clear plate, including all internal reflections.

    Parameters
    ----------
    cosine : float or ndarray
        Cosine of incidence, in [0, 1] [1].
    index_ratio : float or ndarray
        Index beyond the boundary over that on the side of incidence [1].
    keeps_polarisation : bool, default False
        If False, each face meets unpolarised light, as in the simulator. If True, the mean of the s and
        p results, as for a real plate, which is larger.

    Returns
    -------
    float or ndarray
        Transmittance [1].

    Notes
    -----
    Incoherent sum ``T^2 (1 + R^2 + R^4 + ...) = (1 - R)/(1 + R)`` (Stokes 1862).

    Examples
    --------
    >>> from transport.theory.fresnel import plate_transmittance
    >>> print(f"{plate_transmittance(1.0, 1.5):.4g}")
    0.9231
    """
    if not keeps_polarisation:
        return transmittance(cosine, index_ratio) / (1 + reflectance(cosine, index_ratio))
    passed, back = transmittances(cosine, index_ratio), reflectances(cosine, index_ratio)
    return (passed.s / (1 + back.s) + passed.p / (1 + back.p)) / 2


def diffuse_reflectance(index_ratio: np.ndarray) -> np.ndarray:
    """Reflected share of diffuse unpolarised light (equal radiance from all directions).

    Parameters
    ----------
    index_ratio : float or ndarray
        Index beyond the boundary over that on the side of incidence [1].

    Returns
    -------
    float or ndarray
        Reflectance [1].

    Notes
    -----
    From the side of lower index it is ``2 int_0^1 R c dc``, for which Walsh (1926) and Duntley (1942,
    J. Opt. Soc. Am. 32, 61) have a closed form. That form cancels near n = 1, so that the integral is
    computed by quadrature in t, with ``c = sqrt(n^2 - 1) sinh t`` and R_s = exp(-4 t). From the side of
    higher index, n < 1, including total reflection, reciprocity gives ``1 - (1 - R(1/n)) n^2``.

    Examples
    --------
    >>> from transport.theory.fresnel import diffuse_reflectance
    >>> print(f"{diffuse_reflectance(1.5):.4g}")
    0.09178
    """
    ratio = np.asarray(index_ratio, float)
    n = np.where(ratio < 1, 1 / ratio, ratio)
    rise = np.asarray((n - 1) * (n + 1))
    external = np.where(n == 1, 0.0, _integrated(np.where(n == 1, 2.0, n)))
    return np.where(ratio < 1, (rise + external) / (n * n), external)[()]


def escape_share(index_ratio: np.ndarray) -> np.ndarray:
    """Share of diffuse light that leaves a medium through its smooth boundary at the first incidence.

    Parameters
    ----------
    index_ratio : float or ndarray
        Index beyond the boundary over that on the side of incidence [1].

    Returns
    -------
    float or ndarray
        ``1 - diffuse_reflectance(n)`` [1]; from the side of higher index ``(1 - R(1/n)) n^2``.

    Examples
    --------
    >>> from transport.theory.fresnel import escape_share
    >>> print(f"{escape_share(1 / 1.5):.4g}")
    0.4037
    """
    return 1 - diffuse_reflectance(index_ratio)


def escape_cone_share(index_ratio: np.ndarray) -> np.ndarray:
    """Share of the hemisphere's solid angle within the critical angle.

    Parameters
    ----------
    index_ratio : float or ndarray
        Index beyond the boundary over that on the side of incidence [1].

    Returns
    -------
    float or ndarray
        ``1 - sqrt(1 - n^2)`` [1]; 1 for n above 1.

    Examples
    --------
    >>> from transport.theory.fresnel import escape_cone_share
    >>> print(f"{escape_cone_share(1 / 1.5):.4g}")
    0.2546
    """
    n = np.minimum(index_ratio, 1.0)
    return n * n / (1 + np.sqrt((1 - n) * (1 + n)))


def refracted_radiance(radiance: float, cosine: np.ndarray, index_ratio: np.ndarray) -> np.ndarray:
    """Radiance beyond the boundary.

    Parameters
    ----------
    radiance : float or ndarray
        Incident radiance, in any unit.
    cosine : float or ndarray
        Cosine of incidence, in [0, 1] [1].
    index_ratio : float or ndarray
        Index beyond the boundary over that on the side of incidence [1].

    Returns
    -------
    float or ndarray
        ``T n^2 L``, unit of `radiance`.

    Notes
    -----
    Apart from the reflected share, L/n^2 is the same on both sides (Kirchhoff 1860; Clausius 1864),
    because the étendue ``n^2 cos dA dw`` is.

    Examples
    --------
    >>> from transport.theory.fresnel import refracted_radiance
    >>> print(f"{refracted_radiance(1.0, 1.0, 1.5):.4g}")
    2.16
    """
    return transmittance(cosine, index_ratio) * np.square(index_ratio) * radiance


def _angles(cosine, index_ratio) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """c, n, q, and whether reflection is total.

    q^2 is computed from exact products, so that q is accurate at the critical angle too.
    """
    c, n = np.broadcast_arrays(np.asarray(cosine, float), np.asarray(index_ratio, float))
    (n2, n2_rest), (c2, c2_rest) = _square(n), _square(c)
    # Both sums are exact where they cancel: n^2 against 1, and the difference against c^2 (Sterbenz 1974).
    first = np.where(n2 < 0.5, c2 - 1, n2 - 1)
    q2 = (first + np.where(n2 < 0.5, n2, c2)) + (n2_rest + c2_rest)
    return c, n, np.sqrt(np.maximum(q2, 0.0)), q2 < 0


def _divisor(x: np.ndarray, is_total: np.ndarray) -> np.ndarray:
    """x, or 1 where no division is needed: beyond the critical angle, or at grazing without a boundary."""
    return np.where(is_total | (x == 0), 1.0, x)


def _square(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Square of doubles as a rounded number and the remainder (Dekker 1971)."""
    high = x * SPLITTER - (x * SPLITTER - x)
    low, square = x - high, x * x
    return square, ((high * high - square) + 2 * high * low) + low * low


def _integrated(n: np.ndarray) -> np.ndarray:
    """2 int_0^1 R c dc for n > 1, over panels of t."""
    rise = ((n - 1) * (n + 1))[..., None, None]
    root, n2 = np.sqrt(rise), np.square(n)[..., None, None]
    edges = np.minimum(EDGES[:, None], np.arcsinh(1 / root))
    width = np.diff(edges, axis=-2)
    t = edges[..., :-1, :] + width * NODES
    c, q = root * np.sinh(t), root * np.cosh(t)
    p = rise * (c * q - (1 - c) * (1 + c)) / ((c + q) * (n2 * c + q))
    return ((np.exp(-4 * t) + p * p) * c * q * width @ WEIGHTS).sum(axis=-1)


# ---- Radiance at a smooth boundary and at a plate, and escape from a point source in glass.
#
# A ray from air at the angle theta continues at theta' in glass of index n, n sin theta' = sin theta
# (Snell), with the share 1 - R of its power. Since n^2 cos theta' dω' = cos theta dω, L' = (1 - R) n^2 L
# (Straubel 1902; Nicodemus 1963). Means over a bin are integrals over cosines in *air*, in which R has no
# square-root singularity, by Gauss-Legendre: NODES nodes reach rounding error for indices from 1.01 to
# 10.
#
# R is Fresnel's reflectance averaged over both polarisations, as for light that is unpolarised at every
# crossing.

REFRACTION_NODES = 96

Share = Callable[[np.ndarray], np.ndarray]  # a function of Fresnel's reflectance R


def through(share: np.ndarray) -> np.ndarray:
    """Transmittance of one boundary.

    Parameters
    ----------
    share : float or ndarray
        Fresnel reflectance R of one boundary [1].

    Returns
    -------
    float or ndarray
        ``1 - R`` [1].

    Examples
    --------
    >>> from transport.theory.fresnel import through
    >>> print(f"{through(0.04):.4g}")
    0.96
    """
    return 1 - share


def through_plate(share: np.ndarray) -> np.ndarray:
    """Transmittance of a plate, with all internal reflections added incoherently.

    Parameters
    ----------
    share : float or ndarray
        Fresnel reflectance R of one boundary [1].

    Returns
    -------
    float or ndarray
        ``(1 - R)/(1 + R)`` [1].

    Notes
    -----
    Source: Stokes 1862.

    Examples
    --------
    >>> from transport.theory.fresnel import through_plate
    >>> print(f"{through_plate(0.04):.4g}")
    0.9231
    """
    return (1 - share) / (1 + share)


def by_plate(share: np.ndarray) -> np.ndarray:
    """Reflectance of a plate, with all internal reflections added incoherently.

    Parameters
    ----------
    share : float or ndarray
        Fresnel reflectance R of one boundary [1].

    Returns
    -------
    float or ndarray
        ``2 R/(1 + R)`` [1].

    Notes
    -----
    Source: Stokes 1862.

    Examples
    --------
    >>> from transport.theory.fresnel import by_plate
    >>> print(f"{by_plate(0.04):.4g}")
    0.07692
    """
    return 2 * share / (1 + share)


def means_in_air(share: Share, theta_edges: np.ndarray, index: float) -> np.ndarray:
    """Means of a function of R over bins of polar angle in air, weighted by cosθ dω.

    Parameters
    ----------
    share : callable
        Function of R, for example `through` [1].
    theta_edges : ndarray
        Edges of the bins of polar angle, increasing from 0 to pi/2, shape (n + 1,) [rad].
    index : float
        Refractive index n of the glass, above 1 [1].

    Returns
    -------
    ndarray
        Means, shape (n,) [1].

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.fresnel import means_in_air, through
    >>> print(means_in_air(through, np.array([0.0, 0.5, 1.0]), 1.5).round(4))
    [0.9596 0.9483]
    """
    return _means(share, np.cos(theta_edges), index)


def means_in_glass(share: Share, theta_edges: np.ndarray, index: float) -> np.ndarray:
    """Means of a function of R over bins of polar angle in glass, weighted by cosθ dω.

    Parameters
    ----------
    share : callable
        Function of R, for example `through` [1].
    theta_edges : ndarray
        Edges of the bins of polar angle, increasing from 0 to pi/2, shape (n + 1,) [rad].
    index : float
        Refractive index n of the glass, above 1 [1].

    Returns
    -------
    ndarray
        Means, shape (n,) [1]; R is 1 beyond the critical angle.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.fresnel import means_in_glass, through
    >>> print(means_in_glass(through, np.array([0.0, 0.5, 1.0]), 1.5).round(4))
    [0.9571 0.3841]
    """
    squares = np.sin(theta_edges) ** 2
    within = np.minimum(squares, 1 / index**2)
    cosines = np.sqrt(np.maximum(1 - within * index**2, 0.0))  # in air
    inside = np.diff(within) * _means(share, cosines, index)
    return (inside + (np.diff(squares) - np.diff(within)) * share(1.0)) / np.diff(squares)


def escape_from_point(index: float) -> float:
    """Share of an isotropic source's power that leaves glass through a plane boundary at the first incidence.

    Parameters
    ----------
    index : float
        Refractive index n of the glass, above 1 [1].

    Returns
    -------
    float
        Escaping share [1].

    Notes
    -----
    Half of ``∫ (1 - R) dmu'`` over the escape cone, with ``dmu' = mu dmu/(n^2 mu')`` from cosines mu'
    in glass to mu in air.

    Examples
    --------
    >>> from transport.theory.fresnel import escape_from_point
    >>> print(f"{escape_from_point(1.5):.4g}")
    0.1148
    """
    mu, weight = _nodes(np.zeros(1), np.ones(1))
    within = np.sqrt(1 - (1 - mu**2) / index**2)
    return float((weight * through(reflectance(mu, index)) * mu / within).sum() / (2 * index**2))


def _means(share: Share, cosines: np.ndarray, index: float) -> np.ndarray:
    """Means between decreasing cosines in air, weighted by mu dmu; 0 for a bin of no width."""
    mu, weight = _nodes(cosines[1:, None], cosines[:-1, None])
    area = (weight * mu).sum(axis=1)
    total = (weight * mu * share(reflectance(mu, index))).sum(axis=1)
    return np.divide(total, area, out=np.zeros_like(total), where=area > 0)


def _nodes(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of an integral from low to high."""
    x, w = legendre_nodes(REFRACTION_NODES)
    return low + (high - low) * (1 + x) / 2, (high - low) * w / 2
