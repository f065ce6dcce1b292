"""Clausing's tube: what gets through a round tube with a diffuse wall, and what falls on the wall.

Lengths are in radii of the tube.  The entrance sends in a uniform flux by the cosine law; H(x) is what falls
on the wall at the depth x, per area, over what enters per area.  A ring of the wall sees the entrance by f
and other rings by K = -f', so that with a wall of albedo a

    H(x) = f(x) + a ∫ K(|x - y|) H(y) dy  over the tube,  0 ≤ x ≤ l,

and what leaves at the far end, over what enters, is W = F + 2 a ∫ H(x) f(l - x) dx, F the view factor of the
two ends (Clausing 1932, eq. 6; f and K by the view factors of coaxial disks).  If both ends send in the same,
a wall of albedo 1 receives the same everywhere: H(x) + H(l - x) = 1, so that a particle meets such a wall l
times in the mean, l = length over radius, and what returns is 1 - W.

Solution.  K has a kink at y = x and is analytic beside it, with its nearest singularities at x ± 2i, and H is
smooth up to both ends.  So H is taken on panels no longer than PANEL by Legendre nodes (Nyström); a panel's
integrals are Gauss's, but those of the panel that holds x, which is cut in two at x, H there being
interpolated.  Both errors fall geometrically: from 10 nodes on W changes by rounding only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from transport.theory.nodes import legendre_nodes
from transport.theory.round_view_factors import base_to_base

PANEL, NODES = 1.0, 12  # longest panel [radii], nodes of each
LONGEST = 200.0  # length over radius


@dataclass(frozen=True)
class Tube:
    """A solved tube.  places, weights: of a quadrature over its length [radii]; incident: H there [1]."""

    length: float
    albedo: float
    edges: np.ndarray  # of the panels
    places: np.ndarray
    weights: np.ndarray
    incident: np.ndarray

    @property
    def transmission(self) -> float:
        """Share of what enters that leaves at the far end [1]."""
        seen = self.weights * self.incident @ to_end(self.length - self.places)
        return float(base_to_base(1.0, self.length) + 2 * self.albedo * seen)

    @property
    def reflection(self) -> float:
        """Share that leaves by the entrance again [1]."""
        return float(2 * self.albedo * (self.weights * self.incident @ to_end(self.places)))

    @property
    def mean_hits(self) -> float:
        """Mean number of times that a particle meets the wall [1]; of albedo 1, length over radius."""
        return float(2 * (self.weights @ self.incident))

    def incident_at(self, place) -> np.ndarray:
        """H at these depths [radii], what falls on the wall over what enters, both per area [1]."""
        place = np.asarray(place, dtype=float)
        panel = np.clip(np.searchsorted(self.edges, place, side="right") - 1, 0, len(self.edges) - 2)
        low, high = self.edges[panel], self.edges[panel + 1]
        t = (2 * place - low - high) / (high - low)
        values = self.incident.reshape(-1, NODES)[panel] @ _to_coefficients().T
        return (values * legendre.legvander(t, NODES - 1).reshape(values.shape)).sum(axis=-1)

    def mean_incident(self, edges) -> np.ndarray:
        """Means of H over bins with these edges [radii], (bins,) [1]."""
        x, w = legendre_nodes(NODES)
        means = []
        for low, high in zip(edges[:-1], edges[1:], strict=True):
            cuts = np.unique([low, high, *self.edges[(self.edges > low) & (self.edges < high)]])
            half, middle = np.diff(cuts) / 2, (cuts[1:] + cuts[:-1]) / 2
            means.append((half @ (self.incident_at(middle[:, None] + half[:, None] * x) @ w)) / (high - low))
        return np.array(means)


def transmission(length_over_radius: float, albedo: float = 1.0) -> float:
    """Clausing's factor W: share of what enters a diffuse-walled tube by the cosine law that leaves at its
    far end [1].

    length_over_radius: above 0, at most 200.  Good to 1e-12 (against 30 digits in the tests).
    """
    return solved_tube(float(length_over_radius), float(albedo)).transmission


def long_tube(length_over_radius: float) -> float:
    """What W tends to in long tubes [1]: 8 R / 3 l (Knudsen 1909; Smoluchowski 1910).

    Slowly, as log(l)/l: 40 % too large at l = 10 R, 10 % at 50 R.
    """
    return 8 / (3 * length_over_radius)


def dushman(length_over_radius: float) -> float:
    """Both tubes' resistances added, 1 / (1 + 3 l / 8 R) [1] (Dushman 1922): up to 12 % above W."""
    return 1 / (1 + 0.375 * length_over_radius)


def ring_density(distance: float) -> float:
    """View factor from a point of the wall to a ring of it, per length of the ring [1 per radius]: K(s).

    K = (1/2) [1 - s (s^2 + 6) / (s^2 + 4)^(3/2)], as 2 (3 s^2 + 16) / (r^3 (r^3 + s (s^2 + 6))), r^2 = s^2 +
    4, which does not cancel.  Vectorised.
    """
    s = np.abs(distance)
    cube = np.hypot(s, 2.0) ** 3
    return (6 * s * s + 32) / (cube * (cube + s * (s * s + 6)))


def to_end(distance: float) -> float:
    """View factor from a point of the wall to a disk that closes the tube at the distance s [1]: f(s).

    f = (s^2 + 2) / (2 r) - s/2, as 2 / (r (s^2 + 2 + s r)), r^2 = s^2 + 4, which does not cancel.
    Vectorised.
    """
    s = np.asarray(distance, dtype=float)
    r = np.hypot(s, 2.0)
    return 2 / (r * (s * s + 2 + s * r))


@lru_cache(maxsize=512)
def solved_tube(length_over_radius: float, albedo: float = 1.0) -> Tube:
    """Clausing's equation solved.  Raises ValueError for a length not in (0, 200] radii."""
    if not 0 < length_over_radius <= LONGEST:
        raise ValueError(f"solved_tube: length over radius must be in (0, 200], got {length_over_radius}")
    edges = np.linspace(0, length_over_radius, math.ceil(length_over_radius / PANEL) + 1)
    x, w = legendre_nodes(NODES)
    half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
    places, weights = (middle + half * x).ravel(), (half * w).ravel()
    kernel = ring_density(places[:, None] - places) * weights
    for k in range(len(edges) - 1):  # the panel that holds the place
        own = slice(k * NODES, (k + 1) * NODES)
        kernel[own, own] = half[k, 0] * _across_kink(x, w, half[k, 0])
    incident = np.linalg.solve(np.eye(len(places)) - albedo * kernel, to_end(places))
    return Tube(length_over_radius, albedo, edges, places, weights, incident)


def _across_kink(x: np.ndarray, w: np.ndarray, half: float) -> np.ndarray:
    """Weights of H at the nodes of [-1, 1] in ∫ K(half |x_i - t|) H(t) dt, (i, node)."""
    rows = []
    for place in x:
        parts = [(-1.0, place), (place, 1.0)]
        t = np.concatenate([(low + high) / 2 + (high - low) / 2 * x for low, high in parts])
        weight = np.concatenate([(high - low) / 2 * w for low, high in parts])
        rows.append(
            (weight * ring_density(half * (place - t)))
            @ legendre.legvander(t, NODES - 1)
            @ _to_coefficients()
        )
    return np.array(rows)


@lru_cache(maxsize=1)
def _to_coefficients() -> np.ndarray:
    """From values at the Legendre nodes to coefficients of Legendre polynomials, exact for those of the
    nodes' number.
    """
    x, w = legendre_nodes(NODES)
    return (legendre.legvander(x, NODES - 1) * w[:, None]).T * (np.arange(NODES) + 0.5)[:, None]
