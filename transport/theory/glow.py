"""Light of a glowing, absorbing medium of one temperature: along a ray, out of a ball or slab, and within.

A medium that absorbs σ_a per length and emits j = σ_a n² L (Kirchhoff 1860; L is a black body's radiance, n the
medium's index) adds to a ray dI/ds = σ_a (n² L - I).  Without scattering, from the dark,

    I = n² L (1 - e^(-σ_a s)),

with s the length of the ray in it: thin, a medium shines in proportion to its depth, thick, as a black body.
What leaves a body with nothing around it is 1 - e^(-σ_a s) averaged over its chords: its emissivity ε, of π L.
Its own light, 4 π j V, escapes by P = ε S/(4 σ_a V).  Scattering changes all of this, and nothing of equilibrium:
between walls of the same temperature the radiance is n² L everywhere.

Lengths are optical: x = σ_a R of a ball, τ = σ_a d of a slab.  No difference of near numbers is taken: a thin medium
keeps its digits.
"""

from __future__ import annotations

import numpy as np

from transport.theory.nodes import legendre_nodes

NODES = 128  # Gauss-Legendre, over the directions at a place in a ball
ROUNDING, TINY = 1e-16, 1e-300  # sqrt(1 - ρ²) at the rim, ρ at the centre: no nearer
TERMS = 18  # of the series for thin balls, x up to 1/2: the next is 1e-17


def emission(absorption: float, radiance: float, index: float = 1.0) -> float:
    """What a medium emits in equilibrium with black walls of this radiance, σ_a n² L [W m^-3 sr^-1]."""
    return absorption * index**2 * radiance


def ray_share(depth: np.ndarray) -> np.ndarray:
    """Radiance of a ray of this optical length through glowing matter, over L [1]: 1 - e^(-τ).  Vectorised."""
    return -np.expm1(np.negative(depth))


def ball_emissivity(x: np.ndarray) -> np.ndarray:
    """Power that leaves a ball of optical radius x over π L S [1]: 1 - (1 - (1 + 2x) e^(-2x))/(2 x²).  Vectorised.

    4x/3 where thin: 4 V/S times σ_a.
    """
    y = 2 * np.asarray(x, dtype=float)
    order = np.arange(1, TERMS + 1)
    coefficients = np.append(0.0, -2 * (-1.0) ** order / ((order + 2) * _factorials(order)))
    thin, thick = np.polynomial.polynomial.polyval(np.minimum(y, 1), coefficients), np.maximum(y, 1)
    closed = 1 - 2 * (1 - (1 + thick) * np.exp(-thick)) / thick**2
    return np.where(y < 1, thin, closed)[()]


def ball_escape(x: np.ndarray) -> np.ndarray:
    """Share of a ball's own light that escapes it [1]: 3 ε/(4 x) (Case, de Hoffmann and Placzek 1953).  Vectorised."""
    return 3 * ball_emissivity(x) / (4 * np.asarray(x, dtype=float))


def slab_emissivity(tau: np.ndarray) -> np.ndarray:
    """Power that leaves each face of a slab over π L [1]: 1 - 2 E₃(τ), as 1 - e^(-τ) + τ E₂(τ).  Vectorised."""
    from scipy.special import expn

    return ray_share(tau) + tau * expn(2, tau)


def slab_escape(tau: np.ndarray) -> np.ndarray:
    """Share of a slab's own light that escapes by its two faces [1]: (1 - 2 E₃(τ))/(2 τ).  Vectorised."""
    return slab_emissivity(tau) / (2 * np.asarray(tau, dtype=float))


def mean_beam_length(emissivity: np.ndarray, absorption: float) -> np.ndarray:
    """Length of the one ray that shines as the whole body does [m]: -ln(1 - ε)/σ_a (Hottel 1954).  Vectorised.

    4 V/S where thin (4 R/3, 2 d), less where thick.
    """
    return -np.log1p(np.negative(emissivity)) / absorption


def ball_rim_share(x: float, edges: np.ndarray) -> np.ndarray:
    """Radiance over L that leaves a ball, mean over bins of the cosine to its normal, (bins,) [1].

    At the cosine μ a chord is 2 R μ long: 1 - e^(-2 x μ), by projected solid angle ∝ μ dμ.
    """
    low, high = np.asarray(edges[:-1], float), np.asarray(edges[1:], float)
    nodes, weights = legendre_nodes(24)
    mu = (low + high)[:, None] / 2 + (high - low)[:, None] / 2 * nodes
    return (ray_share(2 * x * mu) * mu) @ weights / (mu @ weights)


def slab_face_share(tau: float, edges: np.ndarray) -> np.ndarray:
    """Radiance over L that leaves a slab, mean over bins of the cosine to its normal, (bins,) [1].

    Of 1 - e^(-τ/μ) by projected solid angle: from 0 to m it is m² ε(τ/m).
    """
    edges = np.asarray(edges, dtype=float)
    whole = edges**2 * slab_emissivity(tau / np.maximum(edges, TINY))
    return np.diff(whole) / np.diff(edges**2)


def ball_fluence_share(x: float, place: np.ndarray) -> np.ndarray:
    """Fluence rate within a ball with nothing around it over 4 π L, at these shares of its radius [1].  Vectorised.

    The mean of 1 - e^(-σ_a s) over directions, s = ρ μ + sqrt(ρ² μ² + q²) radii back to the rim, q² = 1 - ρ².  With
    ρ μ = q sinh t that is s = q e^t, which bends nowhere, at the rim neither.
    """
    nodes, weights = legendre_nodes(NODES)
    rho = np.maximum(np.asarray(place, dtype=float), TINY)[..., None]
    q = np.maximum(np.sqrt(np.maximum((1 - rho) * (1 + rho), 0.0)), ROUNDING)
    reach = np.arcsinh(rho / q)
    t = reach * nodes
    return (ray_share(x * q * np.exp(t)) * q * np.cosh(t) * reach / rho) @ weights / 2


def ball_shell_shares(x: float, edges: np.ndarray) -> np.ndarray:
    """Means by volume of `ball_fluence_share` over shells between these shares of the radius, (shells,) [1].

    With ρ = sin θ, in which the fluence is smooth at the centre and up to the rim.
    """
    nodes, weights = legendre_nodes(48)
    ends = np.arcsin(np.asarray(edges, dtype=float))[:, None]
    theta = (ends[1:] + ends[:-1]) / 2 + np.diff(ends, axis=0) / 2 * nodes
    measure = weights * np.sin(theta) ** 2 * np.cos(theta)
    return (ball_fluence_share(x, np.sin(theta)) * measure).sum(axis=1) / measure.sum(axis=1)


def _factorials(order: np.ndarray) -> np.ndarray:
    return np.cumprod(order.astype(float))
