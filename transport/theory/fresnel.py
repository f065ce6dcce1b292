"""Smooth boundaries of clear media: Snell's law, Fresnel's formulas, and radiance over the square of the index.

Everywhere `cosine` is that of incidence, in [0, 1], and `index_ratio` n = (index beyond the boundary) /
(index on the side of arrival): glass seen from air is 1.5, air seen from glass 1/1.5.  With c the cosine of
incidence and q = n cos(refraction) = sqrt(n^2 - 1 + c^2), Fresnel's amplitudes (1823; Born and Wolf 1999,
1.5.2) are written

    r_s = -(n^2 - 1)/(c + q)^2,    r_p = (n^2 - 1) (c q - s^2)/((c + q)(n^2 c + q)),    s^2 = (1 - c)(1 + c)

in which no two nearly equal numbers are subtracted, but at Brewster's angle, where r_p is 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from transport.theory.nodes import legendre_nodes

SPLITTER = 2.0**27 + 1  # of a double into halves (Veltkamp 1968)
NODES, WEIGHTS = legendre_nodes(32)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2  # on [0, 1]
# Panels for t: R_p varies within 1/n^2 of grazing, and beyond t = 40 R is nothing (e^-160).
EDGES = np.concatenate([[0.0], 2.0 ** np.arange(-64, 0), np.arange(1.0, 41.0)])


class Polarised(NamedTuple):
    """A share of light for each polarisation: s with its field across the plane of incidence, p within it."""

    s: np.ndarray
    p: np.ndarray


def reflectances(cosine: np.ndarray, index_ratio: np.ndarray) -> Polarised:
    """Shares of s- and p-polarised light that are reflected [1]; 1 beyond the critical angle.  Vectorised."""
    c, n, q, is_total = _angles(cosine, index_ratio)
    rise, both, weighted = (n - 1) * (n + 1), _divisor(c + q, is_total), _divisor(n * n * c + q, is_total)
    s = rise / both / both
    p = rise / both * ((c * q - (1 - c) * (1 + c)) / weighted)
    return Polarised(*(np.where(is_total, 1.0, r * r)[()] for r in (s, p)))


def transmittances(cosine: np.ndarray, index_ratio: np.ndarray) -> Polarised:
    """Shares of s- and p-polarised light that are refracted [1], good relatively at grazing too.  Vectorised."""
    c, n, q, is_total = _angles(cosine, index_ratio)
    both, weighted = _divisor(c + q, is_total), _divisor(n * n * c + q, is_total)
    s = 4 * (c / both) * (q / both)
    p = 4 * (n * n * c / weighted) * (q / weighted)
    return Polarised(*(np.where(n == 1, 1.0, np.where(is_total, 0.0, t))[()] for t in (s, p)))


def reflectance(cosine: np.ndarray, index_ratio: np.ndarray) -> np.ndarray:
    """Share of unpolarised light that is reflected [1]: the mean of both polarisations.  Vectorised."""
    s, p = reflectances(cosine, index_ratio)
    return (s + p) / 2


def transmittance(cosine: np.ndarray, index_ratio: np.ndarray) -> np.ndarray:
    """Share of unpolarised light that is refracted [1]: the mean of both polarisations.  Vectorised."""
    s, p = transmittances(cosine, index_ratio)
    return (s + p) / 2


def snell_cosine(cosine: np.ndarray, index_ratio: np.ndarray) -> np.ndarray:
    """Cosine of the angle of refraction [1] (Snell 1621); nan beyond the critical angle.  Vectorised."""
    _, n, q, is_total = _angles(cosine, index_ratio)
    return np.where(is_total, math.nan, np.minimum(q / n, 1.0))[()]


def brewster_angle(index_ratio: float) -> float:
    """Angle of incidence at which no p-polarised light is reflected [rad]: atan n (Brewster 1815).  Vectorised."""
    return np.arctan(index_ratio)


def critical_angle(index_ratio: float) -> float:
    """Angle of incidence beyond which all light is reflected [rad]: asin n, at most pi/2.  Vectorised."""
    return np.arcsin(np.minimum(index_ratio, 1.0))


def plate_transmittance(cosine: np.ndarray, index_ratio: np.ndarray, keeps_polarisation: bool = False):
    """Share of unpolarised light that passes a clear plate, all reflections between its faces added up [1].

    Incoherent: T^2 (1 + R^2 + R^4 + ...) = (1 - R)/(1 + R) (Stokes 1862).  As it stands each face meets
    unpolarised light, as the simulator's do; with `keeps_polarisation` the mean of that of s and that of p,
    as of a real plate, which is larger.  Vectorised.
    """
    if not keeps_polarisation:
        return transmittance(cosine, index_ratio) / (1 + reflectance(cosine, index_ratio))
    passed, back = transmittances(cosine, index_ratio), reflectances(cosine, index_ratio)
    return (passed.s / (1 + back.s) + passed.p / (1 + back.p)) / 2


def diffuse_reflectance(index_ratio: np.ndarray) -> np.ndarray:
    """Share of diffuse unpolarised light (equal radiance from all directions) that is reflected [1].  Vectorised.

    From the thinner side 2 int_0^1 R c dc, for which Walsh (1926) and Duntley (1942, J. Opt. Soc. Am. 32, 61)
    have a closed form; it cancels near n = 1, so that it is integrated here, in t of c = sqrt(n^2 - 1) sinh
    t, where R_s is exp(-4 t).  From the denser side, n < 1, total reflection included, by reciprocity 1 - (1 -
    R(1/n)) n^2.
    """
    ratio = np.asarray(index_ratio, float)
    n = np.where(ratio < 1, 1 / ratio, ratio)
    rise = np.asarray((n - 1) * (n + 1))
    external = np.where(n == 1, 0.0, _integrated(np.where(n == 1, 2.0, n)))
    return np.where(ratio < 1, (rise + external) / (n * n), external)[()]


def escape_share(index_ratio: np.ndarray) -> np.ndarray:
    """Share of diffuse light that leaves a medium through its smooth boundary at one go [1].  Vectorised.

    1 - diffuse_reflectance; from the denser side, n < 1, (1 - R(1/n)) n^2: what is left of the escape cone.
    """
    return 1 - diffuse_reflectance(index_ratio)


def escape_cone_share(index_ratio: np.ndarray) -> np.ndarray:
    """Share of the hemisphere's solid angle within the critical angle [1]: 1 - sqrt(1 - n^2).  Vectorised."""
    n = np.minimum(index_ratio, 1.0)
    return n * n / (1 + np.sqrt((1 - n) * (1 + n)))


def refracted_radiance(radiance: float, cosine: np.ndarray, index_ratio: np.ndarray) -> np.ndarray:
    """Radiance beyond the boundary [unit of `radiance`] of light that arrives at that cosine: T n^2 L.  Vectorised.

    L/n^2 is the same on both sides but for what is reflected (Kirchhoff 1860; Clausius 1864): etendue n^2 cos
    dA dw is.
    """
    return transmittance(cosine, index_ratio) * np.square(index_ratio) * radiance


def _angles(cosine, index_ratio) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """c, n, q and whether all is reflected; q^2 from exact products, so that q is good at the critical angle too."""
    c, n = np.broadcast_arrays(np.asarray(cosine, float), np.asarray(index_ratio, float))
    (n2, n2_rest), (c2, c2_rest) = _square(n), _square(c)
    # Both sums are exact where they cancel: n^2 against 1, and the difference against c^2 (Sterbenz 1974).
    first = np.where(n2 < 0.5, c2 - 1, n2 - 1)
    q2 = (first + np.where(n2 < 0.5, n2, c2)) + (n2_rest + c2_rest)
    return c, n, np.sqrt(np.maximum(q2, 0.0)), q2 < 0


def _divisor(x: np.ndarray, is_total: np.ndarray) -> np.ndarray:
    """x, and 1 where nothing is to be divided: beyond the critical angle, or at grazing without a boundary."""
    return np.where(is_total | (x == 0), 1.0, x)


def _square(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The square of doubles as a rounded number and what is left (Dekker 1971)."""
    high = x * SPLITTER - (x * SPLITTER - x)
    low, square = x - high, x * x
    return square, ((high * high - square) + 2 * high * low) + low * low


def _integrated(n: np.ndarray) -> np.ndarray:
    """2 int_0^1 R c dc for n > 1, by panels of t."""
    rise = ((n - 1) * (n + 1))[..., None, None]
    root, n2 = np.sqrt(rise), np.square(n)[..., None, None]
    edges = np.minimum(EDGES[:, None], np.arcsinh(1 / root))
    width = np.diff(edges, axis=-2)
    t = edges[..., :-1, :] + width * NODES
    c, q = root * np.sinh(t), root * np.cosh(t)
    p = rise * (c * q - (1 - c) * (1 + c)) / ((c + q) * (n2 * c + q))
    return ((np.exp(-4 * t) + p * p) * c * q * width @ WEIGHTS).sum(axis=-1)
