"""A ball of fog that scatters and absorbs: what gets out of the light that is made in its middle.

Lengths are in mean free paths, scattering is isotropic: albedo ϖ.  Light is emitted evenly and isotropically
within the radius a of a ball of the radius R ≥ a, q = 3/(4π a³) there.  What was emitted or scattered at one
place comes to another one dimmed, so that for the fluence rate φ, with u = r φ made odd, u(-r) = -u(r),

    u(r) = (1/2) ∫ E₁(|r - t|) (ϖ u(t) + t q(t)) dt  from -R to R:

a sphere is a slab of twice its radius with odd sources (Davison 1957, Neutron Transport Theory, ch. 9; Case,
de Hoffmann and Placzek 1953).  The share that escapes is what each place sends out uncollided, P = ∫ 4π r (ϖ
u + r q) p₀(r) dr; what is absorbed is (1 - ϖ) ∫ 4π r u dr, and both add up to 1.

Solution.  E₁ has a logarithm at t = r, u has one in its slope at a and R: by Legendre nodes on panels that
are halved towards these two radii (Nyström).  Integrals over the panels about the singular point are Gauss's
in the fifth root of the distance from it.  The balance closes to 1e-9 and better.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from transport.theory.glow import ball_fluence_share
from transport.theory.nodes import legendre_nodes

NODES, PANEL = 12, 1.0  # of a panel; longest panel [mean free paths]
HALVINGS = 12  # panels halved towards a and R
NEAR, ROOT = 40, 5  # nodes over a panel about the singular point, and the root that they are even in
LARGEST = 50.0  # optical radius


def exp1(x: np.ndarray) -> np.ndarray:
    """E₁(x), from SciPy, which is loaded when it is needed."""
    from scipy.special import exp1 as integral

    return integral(x)


@dataclass(frozen=True)
class FogBall:
    """The solution.  places, weights: of the quadrature;  sources: r (ϖ φ + q) there;  fluence: r φ there."""

    radius: float
    albedo: float
    places: np.ndarray
    weights: np.ndarray
    sources: np.ndarray
    fluence: np.ndarray

    @property
    def escaping(self) -> float:
        """Share of the light that leaves the ball [1]."""
        uncollided = 1 - ball_fluence_share(self.radius, self.places / self.radius)
        return float(4 * math.pi * (self.weights * self.places * self.sources) @ uncollided)

    @property
    def absorbed(self) -> float:
        """Share of the light that the fog keeps [1]."""
        return float((1 - self.albedo) * 4 * math.pi * (self.weights * self.places) @ self.fluence)

    @property
    def collisions(self) -> float:
        """Mean number of collisions of a particle [1], where it is scattered on until it is absorbed or escapes."""
        return float(4 * math.pi * (self.weights * self.places) @ self.fluence)


def escape(radius: float, albedo: float, lamp: float | None = None) -> float:
    """Share of the light that escapes a ball of fog [1]; of a lamp within the radius `lamp`, or of all the ball.

    Lengths in mean free paths.  exp(-R) for a small lamp in fog that only absorbs; 1 in fog that absorbs nothing.
    """
    return solved_ball(radius, albedo, radius if lamp is None else lamp).escaping


@lru_cache(maxsize=32)
def solved_ball(radius: float, albedo: float, lamp: float) -> FogBall:
    """The integral equation solved.  Raises ValueError for a radius not in (0, 50], or a lamp not within it."""
    if not (0 < lamp <= radius <= LARGEST and 0 <= albedo <= 1):
        given = f"{radius=}, {albedo=}, {lamp=}"
        raise ValueError(
            f"solved_ball: 0 < lamp <= radius <= {LARGEST:g} and albedo from 0 to 1, got {given}"
        )
    places, weights, kernel = operator_of(radius, lamp)
    emitted = np.where(places < lamp, 3 * places / (4 * math.pi * lamp**3), 0.0)
    fluence = np.linalg.solve(np.eye(len(places)) - albedo * kernel, kernel @ emitted)
    return FogBall(radius, albedo, places, weights, albedo * fluence + emitted, fluence)


@lru_cache(maxsize=8)
def operator_of(radius: float, lamp: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places, weights, and the matrix that turns r times what leaves each place into r times the fluence rate."""
    edges = _edges(radius, lamp)
    x, w = legendre_nodes(NODES)
    half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
    places, weights = (middle + half * x).ravel(), (half * w).ravel()
    kernel = np.empty((len(places), len(places)))
    for k, place in enumerate(places):
        row = (exp1(np.maximum(np.abs(place - places), 1e-300)) - exp1(place + places)) * weights
        own = k // NODES
        for panel in range(max(own - 1, 0), min(own + 2, len(edges) - 1)):
            there = slice(panel * NODES, (panel + 1) * NODES)
            ends = edges[panel], edges[panel + 1]
            row[there] = _near(place, *ends) - _near(-place, *ends)
        kernel[k] = row / 2
    return places, weights, kernel


def _edges(radius: float, lamp: float) -> np.ndarray:
    """Edges of panels, halved towards the lamp's and the ball's radius."""
    steps = 2.0 ** -np.arange(HALVINGS + 1)
    edges = [0.0, lamp, radius]
    for low, high, ends in ((0.0, lamp, (1,)), (lamp, radius, (0, 1))):
        if low == high:
            continue
        reach = min(PANEL, (high - low) / 2)
        even = np.linspace(low, high, math.ceil((high - low) / reach) + 1)
        edges += [*even, *(low + reach * steps if 0 in ends else ()), *(high - reach * steps)]
    edges = np.sort(edges)
    return edges[np.append(True, np.diff(edges) > 1e-9 * radius)]


def _near(point: float, low: float, high: float) -> np.ndarray:
    """Weights of the values at a panel's nodes in ∫ E₁(|point - t|) f(t) dt over it, whether it holds the point or not."""
    split = min(max(point, low), high)
    v, w = _even_in_the_root()
    total = np.zeros(NODES)
    for end in (low, high):
        away, weight = abs(end - split) * v, abs(end - split) * w
        distance = np.maximum(abs(split - point) + away, 1e-300)
        scaled = (2 * (split + np.sign(end - split) * away) - low - high) / (high - low)
        total += (weight * exp1(distance)) @ legendre.legvander(scaled, NODES - 1) @ _to_coefficients()
    return total


@lru_cache(maxsize=1)
def _even_in_the_root() -> tuple[np.ndarray, np.ndarray]:
    """Places in (0, 1) and weights, dense at 0: Gauss's in the root."""
    x, w = legendre_nodes(NEAR)
    root = (1 + x) / 2
    return root**ROOT, ROOT * root ** (ROOT - 1) * w / 2


@lru_cache(maxsize=1)
def _to_coefficients() -> np.ndarray:
    """From values at the nodes of a panel to coefficients of Legendre polynomials."""
    x, w = legendre_nodes(NODES)
    return (legendre.legvander(x, NODES - 1) * w[:, None]).T * (np.arange(NODES) + 0.5)[:, None]
