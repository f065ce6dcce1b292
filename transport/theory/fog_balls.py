"""A ball of fog that scatters and absorbs: the share of light that escapes from a glowing core.

Lengths are in mean free paths; scattering is isotropic with the albedo ϖ. Light is emitted uniformly
and isotropically within the radius a of a ball of radius R ≥ a, with the emission density q = 3/(4π
a³). The fluence rate φ obeys, with u = r φ continued as an odd function, u(-r) = -u(r),

    u(r) = (1/2) ∫ E₁(|r - t|) (ϖ u(t) + t q(t)) dt  from -R to R:

a sphere is a slab of twice its radius with odd sources (Davison 1957, Neutron Transport Theory, ch. 9;
Case, de Hoffmann and Placzek 1953). The escaping share is P = ∫ 4π r (ϖ u + r q) p₀(r) dr, with p₀ the
uncollided escape probability from r. The absorbed share is (1 - ϖ) ∫ 4π r u dr, and the two add up to
1.

Solution. E₁ has a logarithm at t = r, and the slope of u has one at a and R. The equation is solved
with Legendre nodes on panels that are halved towards these two radii (Nyström). Integrals over the
panels about the singular point use Gauss's rule in the fifth root of the distance from it. The balance
closes to 1e-9 and better.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from transport.statistics.quadrature import legendre_nodes
from transport.theory.glow import ball_fluence_share

NODES, PANEL = 12, 1.0  # nodes per panel; longest panel [mean free paths]
HALVINGS = 12  # number of halvings of panels towards a and R
NEAR, ROOT = 40, 5  # nodes per panel next to the singular point; root in which they are regular
MAX_RADIUS = 50.0  # largest optical radius


def exp1(x: np.ndarray) -> np.ndarray:
    """Exponential integral E₁(x) from SciPy, imported at the first call.

    Parameters
    ----------
    x : ndarray
        Arguments, at least 0 [1].

    Returns
    -------
    ndarray
        E₁(x) [1].

    Examples
    --------
    >>> from transport.theory.fog_balls import exp1
    >>> print(f"{exp1(1.0):.4g}")
    0.2194
    """
    from scipy.special import exp1 as integral

    return integral(x)


@dataclass(frozen=True)
class FogBall:
    """Solution for one ball of fog, from `solved_ball`.

    Parameters
    ----------
    radius : float
        Optical radius R of the ball [mean free paths].
    albedo : float
        Single-scattering albedo ϖ [1].
    places : ndarray
        Quadrature nodes r, shape (n,) [mean free paths].
    weights : ndarray
        Quadrature weights, shape (n,) [mean free paths].
    sources : ndarray
        r (ϖ φ + q) at the nodes, shape (n,).
    fluence : ndarray
        r φ at the nodes, shape (n,).
    """

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
        """Share of the light that the fog absorbs [1]."""
        return float((1 - self.albedo) * 4 * math.pi * (self.weights * self.places) @ self.fluence)

    @property
    def collisions(self) -> float:
        """Mean number of collisions per particle until it is absorbed or escapes [1]."""
        return float(4 * math.pi * (self.weights * self.places) @ self.fluence)


def escape(radius: float, albedo: float, lamp: float | None = None) -> float:
    """Share of the light that escapes a ball of fog.

    Parameters
    ----------
    radius : float
        Optical radius R, in (0, 50] [mean free paths].
    albedo : float
        Single-scattering albedo, 0 to 1 [1].
    lamp : float or None, default None
        Optical radius of the emitting core, in (0, R]; None: the whole ball emits [mean free paths].

    Returns
    -------
    float
        Escaping share [1]: exp(-R) for a small core in purely absorbing fog, 1 without absorption.

    Raises
    ------
    ValueError
        If an argument is out of range.

    Examples
    --------
    >>> from transport.theory.fog_balls import escape
    >>> print(f"{escape(0.5, 0.0):.4g}")
    0.7073
    """
    return solved_ball(radius, albedo, radius if lamp is None else lamp).escaping


@lru_cache(maxsize=32)
def solved_ball(radius: float, albedo: float, lamp: float) -> FogBall:
    """Solve the integral equation for one ball; the result is cached.

    Parameters
    ----------
    radius : float
        Optical radius R, in (0, 50] [mean free paths].
    albedo : float
        Single-scattering albedo, 0 to 1 [1].
    lamp : float
        Optical radius of the emitting core, in (0, R] [mean free paths].

    Returns
    -------
    FogBall
        The solution.

    Raises
    ------
    ValueError
        If the radius is not in (0, 50], the core does not lie within the ball, or the albedo is not in
        [0, 1].

    Examples
    --------
    >>> from transport.theory.fog_balls import solved_ball
    >>> print(f"{solved_ball(0.5, 0.5, 0.5).escaping:.4g}")
    0.8275
    """
    if not (0 < lamp <= radius <= MAX_RADIUS and 0 <= albedo <= 1):
        given = f"{radius=}, {albedo=}, {lamp=}"
        raise ValueError(
            f"solved_ball: need 0 < lamp <= radius <= {MAX_RADIUS:g} and albedo from 0 to 1, got {given}"
        )
    places, weights, kernel = operator_of(radius, lamp)
    emitted = np.where(places < lamp, 3 * places / (4 * math.pi * lamp**3), 0.0)
    fluence = np.linalg.solve(np.eye(len(places)) - albedo * kernel, kernel @ emitted)
    return FogBall(radius, albedo, places, weights, albedo * fluence + emitted, fluence)


@lru_cache(maxsize=8)
def operator_of(radius: float, lamp: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes, weights, and the matrix from r times the emission density to r times the fluence rate.

    Parameters
    ----------
    radius : float
        Optical radius R of the ball [mean free paths].
    lamp : float
        Optical radius of the emitting core [mean free paths].

    Returns
    -------
    tuple of ndarray
        Nodes (n,), weights (n,), matrix (n, n).

    Examples
    --------
    >>> from transport.theory.fog_balls import operator_of
    >>> operator_of(0.5, 0.5)[2].shape
    (168, 168)
    """
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
            row[there] = _singular_weights(place, *ends) - _singular_weights(-place, *ends)
        kernel[k] = row / 2
    return places, weights, kernel


def _edges(radius: float, lamp: float) -> np.ndarray:
    """Edges of panels, halved towards the core's and the ball's radius."""
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


def _singular_weights(point: float, low: float, high: float) -> np.ndarray:
    """Weights of a panel's nodal values in ∫ E₁(|point - t|) f(t) dt, for a point inside or outside."""
    split = min(max(point, low), high)
    v, w = _root_quadrature()
    total = np.zeros(NODES)
    for end in (low, high):
        away, weight = abs(end - split) * v, abs(end - split) * w
        distance = np.maximum(abs(split - point) + away, 1e-300)
        scaled = (2 * (split + np.sign(end - split) * away) - low - high) / (high - low)
        total += (weight * exp1(distance)) @ legendre.legvander(scaled, NODES - 1) @ _legendre_transform()
    return total


@lru_cache(maxsize=1)
def _root_quadrature() -> tuple[np.ndarray, np.ndarray]:
    """Nodes in (0, 1) and weights of Gauss's rule in the root of the variable, dense at 0."""
    x, w = legendre_nodes(NEAR)
    root = (1 + x) / 2
    return root**ROOT, ROOT * root ** (ROOT - 1) * w / 2


@lru_cache(maxsize=1)
def _legendre_transform() -> np.ndarray:
    """Matrix from values at the nodes of a panel to Legendre coefficients."""
    x, w = legendre_nodes(NODES)
    return (legendre.legvander(x, NODES - 1) * w[:, None]).T * (np.arange(NODES) + 0.5)[:, None]
