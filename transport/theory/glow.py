"""Thermal emission of an absorbing medium of uniform temperature: rays, balls and slabs.

A medium that absorbs σ_a per length and emits j = σ_a n² L (Kirchhoff 1860; L the radiance of a black
body, n the medium's index) adds dI/ds = σ_a (n² L - I) to a ray. Without scattering and incident light,

    I = n² L (1 - e^(-σ_a s)),

with s the length of the ray in the medium: a thin medium emits in proportion to its depth, a thick one
like a black body. The emissivity ε of an isolated body, its exitance over π L, is the mean of
1 - e^(-σ_a s) over its chords. The share P = ε S/(4 σ_a V) of its emission 4 π j V escapes. Scattering
changes these results, but not equilibrium: between walls of the same temperature the radiance is n² L
everywhere.

Lengths are optical: x = σ_a R of a ball, τ = σ_a d of a slab. No difference of nearly equal numbers is
taken, so that results for thin media keep their relative accuracy.
"""

from __future__ import annotations

import numpy as np

from transport.statistics.quadrature import legendre_nodes

NODES = 128  # Gauss-Legendre nodes over the directions at a point of a ball
ROUNDING, TINY = 1e-16, 1e-300  # lower bounds of sqrt(1 - ρ²) at the rim and of ρ at the center
TERMS = 18  # terms of the series for thin balls, x up to 1/2: the next is 1e-17


def emission(absorption: float, radiance: float, index: float = 1.0) -> float:
    """Emission of a medium in equilibrium with black walls.

    Parameters
    ----------
    absorption : float
        Absorption coefficient σ_a [m^-1].
    radiance : float
        Radiance L of a black body [W m^-2 sr^-1].
    index : float, default 1.0
        Refractive index n [1].

    Returns
    -------
    float
        ``σ_a n² L`` [W m^-3 sr^-1].

    Notes
    -----
    Source: Kirchhoff 1860.

    Examples
    --------
    >>> from transport.theory.glow import emission
    >>> print(f"{emission(2.0, 1.0, 1.5):.4g}")
    4.5
    """
    return absorption * index**2 * radiance


def ray_share(depth: np.ndarray) -> np.ndarray:
    """Radiance of a ray through a glowing medium, over that of a black body.

    Parameters
    ----------
    depth : float or ndarray
        Optical length τ of the ray [1].

    Returns
    -------
    float or ndarray
        ``1 - e^(-τ)`` [1].

    Examples
    --------
    >>> from transport.theory.glow import ray_share
    >>> print(f"{ray_share(1.0):.4g}")
    0.6321
    """
    return -np.expm1(np.negative(depth))


def ball_emissivity(x: np.ndarray) -> np.ndarray:
    """Emissivity of a ball: emitted power over π L S.

    Parameters
    ----------
    x : float or ndarray
        Optical radius σ_a R of the ball [1].

    Returns
    -------
    float or ndarray
        ``1 - (1 - (1 + 2x) e^(-2x))/(2 x²)`` [1]; 4x/3 for a thin ball, 4 V/S times σ_a.

    Examples
    --------
    >>> from transport.theory.glow import ball_emissivity
    >>> print(f"{ball_emissivity(1.0):.4g}")
    0.703
    """
    y = 2 * np.asarray(x, dtype=float)
    order = np.arange(1, TERMS + 1)
    coefficients = np.append(0.0, -2 * (-1.0) ** order / ((order + 2) * _factorials(order)))
    thin, thick = np.polynomial.polynomial.polyval(np.minimum(y, 1), coefficients), np.maximum(y, 1)
    closed = 1 - 2 * (1 - (1 + thick) * np.exp(-thick)) / thick**2
    return np.where(y < 1, thin, closed)[()]


def ball_escape(x: np.ndarray) -> np.ndarray:
    """Share of a ball's own emission that escapes it.

    Parameters
    ----------
    x : float or ndarray
        Optical radius σ_a R of the ball [1].

    Returns
    -------
    float or ndarray
        ``3 ε/(4 x)`` [1].

    Notes
    -----
    Source: Case, de Hoffmann and Placzek 1953.

    Examples
    --------
    >>> from transport.theory.glow import ball_escape
    >>> print(f"{ball_escape(1.0):.4g}")
    0.5273
    """
    return 3 * ball_emissivity(x) / (4 * np.asarray(x, dtype=float))


def slab_emissivity(tau: np.ndarray) -> np.ndarray:
    """Emissivity of each face of a slab: exitance over π L.

    Parameters
    ----------
    tau : float or ndarray
        Optical thickness σ_a d of the slab [1].

    Returns
    -------
    float or ndarray
        ``1 - 2 E₃(τ)``, computed as ``1 - e^(-τ) + τ E₂(τ)`` [1].

    Examples
    --------
    >>> from transport.theory.glow import slab_emissivity
    >>> print(f"{slab_emissivity(1.0):.4g}")
    0.7806
    """
    from scipy.special import expn

    return ray_share(tau) + tau * expn(2, tau)


def slab_escape(tau: np.ndarray) -> np.ndarray:
    """Share of a slab's own emission that escapes through its two faces.

    Parameters
    ----------
    tau : float or ndarray
        Optical thickness σ_a d of the slab [1].

    Returns
    -------
    float or ndarray
        ``(1 - 2 E₃(τ))/(2 τ)`` [1].

    Examples
    --------
    >>> from transport.theory.glow import slab_escape
    >>> print(f"{slab_escape(1.0):.4g}")
    0.3903
    """
    return slab_emissivity(tau) / (2 * np.asarray(tau, dtype=float))


def mean_beam_length(emissivity: np.ndarray, absorption: float) -> np.ndarray:
    """Mean beam length: length of the single ray whose emissivity equals that of the body.

    Parameters
    ----------
    emissivity : float or ndarray
        Emissivity ε of the body [1].
    absorption : float or ndarray
        Absorption coefficient σ_a [m^-1].

    Returns
    -------
    float or ndarray
        ``-ln(1 - ε)/σ_a`` [m]; 4 V/S for a thin body (4 R/3 for a ball, 2 d for a slab), less for a
        thick one.

    Notes
    -----
    Source: Hottel 1954.

    Examples
    --------
    >>> from transport.theory.glow import mean_beam_length
    >>> print(f"{mean_beam_length(0.5, 1.0):.4g}")
    0.6931
    """
    return -np.log1p(np.negative(emissivity)) / absorption


def ball_rim_share(x: float, edges: np.ndarray) -> np.ndarray:
    """Radiance that leaves a ball over L, averaged over bins of the cosine to its normal.

    Parameters
    ----------
    x : float
        Optical radius σ_a R of the ball [1].
    edges : ndarray
        Edges of the bins of cosine, increasing, shape (bins + 1,) [1].

    Returns
    -------
    ndarray
        Means weighted by mu, shape (bins,) [1].

    Notes
    -----
    A chord at the cosine μ is 2 R μ long: ``1 - e^(-2 x μ)``.

    Examples
    --------
    >>> from transport.theory.glow import ball_rim_share
    >>> print(ball_rim_share(1.0, [0.0, 0.5, 1.0]).round(4))
    [0.4715 0.7802]
    """
    low, high = np.asarray(edges[:-1], float), np.asarray(edges[1:], float)
    nodes, weights = legendre_nodes(24)
    mu = (low + high)[:, None] / 2 + (high - low)[:, None] / 2 * nodes
    return (ray_share(2 * x * mu) * mu) @ weights / (mu @ weights)


def slab_face_share(tau: float, edges: np.ndarray) -> np.ndarray:
    """Radiance that leaves a slab over L, averaged over bins of the cosine to its normal.

    Parameters
    ----------
    tau : float
        Optical thickness σ_a d of the slab [1].
    edges : ndarray
        Edges of the bins of cosine, increasing, shape (bins + 1,) [1].

    Returns
    -------
    ndarray
        Means weighted by mu, shape (bins,) [1].

    Notes
    -----
    The mean of ``1 - e^(-τ/μ)``; its integral from 0 to m is ``m² ε(τ/m)/2``.

    Examples
    --------
    >>> from transport.theory.glow import slab_face_share
    >>> print(slab_face_share(1.0, [0.0, 0.5, 1.0]).round(4))
    [0.9397 0.7276]
    """
    edges = np.asarray(edges, dtype=float)
    whole = edges**2 * slab_emissivity(tau / np.maximum(edges, TINY))
    return np.diff(whole) / np.diff(edges**2)


def ball_fluence_share(x: float, place: np.ndarray) -> np.ndarray:
    """Fluence rate within an isolated glowing ball over 4 π L.

    Parameters
    ----------
    x : float
        Optical radius σ_a R of the ball [1].
    place : ndarray
        Distances from the center over the ball's radius, in [0, 1] [1].

    Returns
    -------
    ndarray
        Fluence rate over 4 π L, shape of `place` [1].

    Notes
    -----
    The mean of ``1 - e^(-σ_a s)`` over directions, with ``s = ρ μ + sqrt(ρ² μ² + q²)`` radii back to
    the rim and ``q² = 1 - ρ²``. With ``ρ μ = q sinh t`` that is ``s = q e^t``, which is smooth up to
    the rim.

    Examples
    --------
    >>> from transport.theory.glow import ball_fluence_share
    >>> print(f"{ball_fluence_share(1.0, 0.5):.4g}")
    0.5816
    """
    nodes, weights = legendre_nodes(NODES)
    rho = np.maximum(np.asarray(place, dtype=float), TINY)[..., None]
    q = np.maximum(np.sqrt(np.maximum((1 - rho) * (1 + rho), 0.0)), ROUNDING)
    reach = np.arcsinh(rho / q)
    t = reach * nodes
    return (ray_share(x * q * np.exp(t)) * q * np.cosh(t) * reach / rho) @ weights / 2


def ball_shell_shares(x: float, edges: np.ndarray) -> np.ndarray:
    """Means by volume of `ball_fluence_share` over spherical shells.

    Parameters
    ----------
    x : float
        Optical radius σ_a R of the ball [1].
    edges : ndarray
        Radii between the shells over the ball's radius, increasing, shape (shells + 1,) [1].

    Returns
    -------
    ndarray
        Means, shape (shells,) [1].

    Notes
    -----
    Integrated over θ with ``ρ = sin θ``, in which the fluence is smooth at the center and up to the
    rim.

    Examples
    --------
    >>> from transport.theory.glow import ball_shell_shares
    >>> print(ball_shell_shares(1.0, [0.0, 0.5, 1.0]).round(4))
    [0.6026 0.4542]
    """
    nodes, weights = legendre_nodes(48)
    ends = np.arcsin(np.asarray(edges, dtype=float))[:, None]
    theta = (ends[1:] + ends[:-1]) / 2 + np.diff(ends, axis=0) / 2 * nodes
    measure = weights * np.sin(theta) ** 2 * np.cos(theta)
    return (ball_fluence_share(x, np.sin(theta)) * measure).sum(axis=1) / measure.sum(axis=1)


def _factorials(order: np.ndarray) -> np.ndarray:
    return np.cumprod(order.astype(float))
