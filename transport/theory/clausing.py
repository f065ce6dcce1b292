"""Clausing's tube: transmission of a round tube with a diffuse wall, and the flux on its wall.

Lengths are in radii of the tube. A uniform flux with the cosine law enters at one end; H(x) is the flux
density on the wall at the depth x over the flux density at the entrance. A ring of the wall has the
view factor f to the entrance and the view factor density K = -f' to other rings, so that with a wall of
albedo a

    H(x) = f(x) + a ∫ K(|x - y|) H(y) dy  over the tube,  0 ≤ x ≤ l,

and the transmission, the share that leaves at the far end, is W = F + 2 a ∫ H(x) f(l - x) dx, F the
view factor between the two ends (Clausing 1932, eq. 6; f and K from the view factors of coaxial disks).
If the same flux enters at both ends, a wall of albedo 1 has uniform irradiance: H(x) + H(l - x) = 1, so
that a particle hits such a wall l times on average, l = length over radius, and the reflected share is
1 - W.

Solution. K has a kink at y = x and is analytic on either side, with its nearest singularities at
x ± 2i, and H is smooth up to both ends. H is represented by Legendre nodes on panels no longer than
PANEL (Nyström). A panel's integrals use Gauss's rule; the panel that holds x is split at x, with H
interpolated there. Both errors fall geometrically: from 10 nodes on W changes by rounding only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from transport.statistics.quadrature import legendre_nodes
from transport.theory.round_view_factors import base_to_base

PANEL, NODES = 1.0, 12  # longest panel [radii], nodes per panel
MAX_LENGTH = 200.0  # largest length over radius


@dataclass(frozen=True)
class Tube:
    """Solution of Clausing's equation for one tube, from `solved_tube`.

    Parameters
    ----------
    length : float
        Length over radius [1].
    albedo : float
        Albedo of the wall [1].
    edges : ndarray
        Edges of the panels, shape (panels + 1,) [radii].
    places : ndarray
        Quadrature nodes over the length, shape (n,) [radii].
    weights : ndarray
        Quadrature weights, shape (n,) [radii].
    incident : ndarray
        H at the nodes, flux density on the wall over that at the entrance, shape (n,) [1].
    """

    length: float
    albedo: float
    edges: np.ndarray  # panel edges [radii]
    places: np.ndarray
    weights: np.ndarray
    incident: np.ndarray

    @property
    def transmission(self) -> float:
        """Share of the entering particles that leaves at the far end [1]."""
        seen = self.weights * self.incident @ to_end(self.length - self.places)
        return float(base_to_base(1.0, self.length) + 2 * self.albedo * seen)

    @property
    def reflection(self) -> float:
        """Share of the entering particles that leaves through the entrance [1]."""
        return float(2 * self.albedo * (self.weights * self.incident @ to_end(self.places)))

    @property
    def mean_hits(self) -> float:
        """Mean number of wall hits per particle [1]; length over radius for albedo 1."""
        return float(2 * (self.weights @ self.incident))

    def incident_at(self, place) -> np.ndarray:
        """Return H, flux density on the wall over that at the entrance.

        Parameters
        ----------
        place : float or array_like
            Depths in the tube [radii].

        Returns
        -------
        ndarray
            H, shape of `place` [1].
        """
        place = np.asarray(place, dtype=float)
        panel = np.clip(np.searchsorted(self.edges, place, side="right") - 1, 0, len(self.edges) - 2)
        low, high = self.edges[panel], self.edges[panel + 1]
        t = (2 * place - low - high) / (high - low)
        values = self.incident.reshape(-1, NODES)[panel] @ _legendre_transform().T
        return (values * legendre.legvander(t, NODES - 1).reshape(values.shape)).sum(axis=-1)

    def mean_incident(self, edges) -> np.ndarray:
        """Return means of H over bins of depth.

        Parameters
        ----------
        edges : array_like
            Bin edges, shape (bins + 1,) [radii].

        Returns
        -------
        ndarray
            Means of H, shape (bins,) [1].
        """
        x, w = legendre_nodes(NODES)
        means = []
        for low, high in zip(edges[:-1], edges[1:], strict=True):
            cuts = np.unique([low, high, *self.edges[(self.edges > low) & (self.edges < high)]])
            half, middle = np.diff(cuts) / 2, (cuts[1:] + cuts[:-1]) / 2
            means.append((half @ (self.incident_at(middle[:, None] + half[:, None] * x) @ w)) / (high - low))
        return np.array(means)


def transmission(length_over_radius: float, albedo: float = 1.0) -> float:
    """Clausing factor W: transmission of a diffuse-walled tube for an entering flux with the cosine law.

    Parameters
    ----------
    length_over_radius : float
        Length of the tube over its radius, above 0, at most 200 [1].
    albedo : float, default 1.0
        Albedo of the wall, from 0 to 1 [1].

    Returns
    -------
    float
        Share of the entering particles that leaves at the far end [1].

    Notes
    -----
    Clausing 1932, eq. 6, solved as in the module's docstring; good to 1e-12 (against 30 digits in the
    tests).

    Examples
    --------
    >>> from transport.theory.clausing import transmission
    >>> print(f"{transmission(2.0):.4g}")
    0.5142
    """
    return solved_tube(float(length_over_radius), float(albedo)).transmission


def long_tube(length_over_radius: float) -> float:
    """Asymptote of W for long tubes.

    Parameters
    ----------
    length_over_radius : float
        Length of the tube over its radius l/R [1].

    Returns
    -------
    float
        ``8 R / (3 l)`` [1].

    Notes
    -----
    Source: Knudsen 1909; Smoluchowski 1910. W converges slowly, as log(l)/l: the asymptote is 40 % too
    large at l = 10 R and 10 % at 50 R.

    Examples
    --------
    >>> from transport.theory.clausing import long_tube
    >>> print(f"{long_tube(50.0):.4g}")
    0.05333
    """
    return 8 / (3 * length_over_radius)


def dushman(length_over_radius: float) -> float:
    """Dushman's approximation of W: the resistances of opening and tube are added.

    Parameters
    ----------
    length_over_radius : float
        Length of the tube over its radius l/R [1].

    Returns
    -------
    float
        ``1 / (1 + 3 l / 8 R)`` [1], up to 12 % above W.

    Notes
    -----
    Source: Dushman 1922.

    Examples
    --------
    >>> from transport.theory.clausing import dushman
    >>> print(f"{dushman(2.0):.4g}")
    0.5714
    """
    return 1 / (1 + 0.375 * length_over_radius)


def ring_density(distance: float) -> float:
    """View factor from a point of the wall to a ring of the wall, per length of the ring.

    Parameters
    ----------
    distance : float or ndarray
        Distance s along the tube [radii].

    Returns
    -------
    float or ndarray
        K(s) [1 per radius].

    Notes
    -----
    ``K = (1/2) [1 - s (s^2 + 6) / (s^2 + 4)^(3/2)]``, computed as
    ``2 (3 s^2 + 16) / (r^3 (r^3 + s (s^2 + 6)))`` with ``r^2 = s^2 + 4``, which does not cancel.

    Examples
    --------
    >>> from transport.theory.clausing import ring_density
    >>> print(f"{ring_density(1.0):.4g}")
    0.187
    """
    s = np.abs(distance)
    cube = np.hypot(s, 2.0) ** 3
    return (6 * s * s + 32) / (cube * (cube + s * (s * s + 6)))


def to_end(distance: float) -> float:
    """View factor from a point of the wall to a disk that closes the tube.

    Parameters
    ----------
    distance : float or ndarray
        Distance s of the disk along the tube [radii].

    Returns
    -------
    float or ndarray
        f(s) [1].

    Notes
    -----
    ``f = (s^2 + 2) / (2 r) - s/2``, computed as ``2 / (r (s^2 + 2 + s r))`` with ``r^2 = s^2 + 4``,
    which does not cancel.

    Examples
    --------
    >>> from transport.theory.clausing import to_end
    >>> print(f"{to_end(1.0):.4g}")
    0.1708
    """
    s = np.asarray(distance, dtype=float)
    r = np.hypot(s, 2.0)
    return 2 / (r * (s * s + 2 + s * r))


@lru_cache(maxsize=512)
def solved_tube(length_over_radius: float, albedo: float = 1.0) -> Tube:
    """Solve Clausing's equation for one tube; the result is cached.

    Parameters
    ----------
    length_over_radius : float
        Length of the tube over its radius, above 0, at most 200 [1].
    albedo : float, default 1.0
        Albedo of the wall, from 0 to 1 [1].

    Returns
    -------
    Tube
        The solution.

    Raises
    ------
    ValueError
        If the length over radius is not in (0, 200].

    Examples
    --------
    >>> from transport.theory.clausing import solved_tube
    >>> print(f"{solved_tube(2.0).mean_hits:.4g}")
    2
    """
    if not 0 < length_over_radius <= MAX_LENGTH:
        raise ValueError(f"solved_tube: length over radius must be in (0, 200], got {length_over_radius}")
    edges = np.linspace(0, length_over_radius, math.ceil(length_over_radius / PANEL) + 1)
    x, w = legendre_nodes(NODES)
    half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
    places, weights = (middle + half * x).ravel(), (half * w).ravel()
    kernel = ring_density(places[:, None] - places) * weights
    for k in range(len(edges) - 1):  # Replace the rule on the panel that holds the point.
        own = slice(k * NODES, (k + 1) * NODES)
        kernel[own, own] = half[k, 0] * _kink_weights(x, w, half[k, 0])
    incident = np.linalg.solve(np.eye(len(places)) - albedo * kernel, to_end(places))
    return Tube(length_over_radius, albedo, edges, places, weights, incident)


def _kink_weights(x: np.ndarray, w: np.ndarray, half: float) -> np.ndarray:
    """Quadrature weights of H at the nodes of [-1, 1] for ∫ K(half |x_i - t|) H(t) dt, shape (i, node)."""
    rows = []
    for place in x:
        parts = [(-1.0, place), (place, 1.0)]
        t = np.concatenate([(low + high) / 2 + (high - low) / 2 * x for low, high in parts])
        weight = np.concatenate([(high - low) / 2 * w for low, high in parts])
        rows.append(
            (weight * ring_density(half * (place - t)))
            @ legendre.legvander(t, NODES - 1)
            @ _legendre_transform()
        )
    return np.array(rows)


@lru_cache(maxsize=1)
def _legendre_transform() -> np.ndarray:
    """Matrix from values at the nodes to Legendre coefficients, exact up to degree NODES - 1."""
    x, w = legendre_nodes(NODES)
    return (legendre.legvander(x, NODES - 1) * w[:, None]).T * (np.arange(NODES) + 0.5)[:, None]
