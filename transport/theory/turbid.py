"""Turbid half spaces and slabs behind Fresnel boundaries: reflectance and fluence with depth.

Accurate to 1e-9. A plane medium of albedo a with the Henyey-Greenstein phase function, index n over
that of the clear media on both sides, is irradiated from above by 1 W m^-2 at one cosine. Depths z are
optical here: mean free paths 1/σ_t. The unscattered light has the fluence rate T/μ₀ e^(-z/μ₀), μ₀ the
refracted cosine. For the scattered light I(z, μ) is radiance times 2π, so that its fluence rate is ∫ I
dμ (Chandrasekhar 1950, ch. 1; Stamnes et al. 1988, Appl. Opt. 27, 2502):

    μ I' = -I + (a/2) ∫ p(μ, μ') I(μ') dμ' + (a/2) p(μ, μ₀) T/μ₀ e^(-z/μ₀),
    p = Σ (2l + 1) g^l P_l(μ) P_l(μ').

It is solved on NODES cosines per panel, exactly in z. All l are kept until g^l is below NEGLIGIBLE_MOMENT, so
that the forward peak is resolved without delta-M. Radiance inside has a kink at the critical cosine: a
panel ends there, and beyond it the nodes are Gauss's in the cosine outside, ν, in which Fresnel's R and
radiance are smooth (μ dμ = ν dν/n²).

Modes. J and K, sum and difference of I at ±μ, times the root of the nodes' weights, obey J' = -B K/μ
and K' = -A J/μ; A (even l) and B (odd l) are symmetric and positive definite. With A = C Cᵀ, B = D Dᵀ
(Cholesky) and Dᵀ C/μ = U Σ Vᵀ, the substitution Vᵀ Cᵀ J = p + m and Uᵀ Dᵀ K = p - m separates them into
p' = -Σ p + q e^(-z/μ₀) and m' = Σ m + r e^(-z/μ₀), the downward and the upward decaying modes. Singular
values, unlike the eigenvalues of B A/μ², keep the relative accuracy of the slowest mode.

Compared with 128 nodes, 96 are within 1e-10 for g = 0.9 and 1e-8 for 0.95; doubling (ordinates.py)
agrees to 1e-13. The unscattered light of a slab is reflected repeatedly between its faces: light that
starts at the bottom is treated as the mirror image of light that starts at the top.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from transport.statistics.quadrature import legendre_nodes
from transport.theory.fresnel import diffuse_reflectance, reflectance, snell_cosine, transmittance

NODES = 96  # cosines per panel
MAX_G = 0.95  # largest |g|; a sharper forward peak is not resolved by the nodes
MAX_ALBEDO = 1 - 1e-6  # largest albedo; above it the quadrature error would dominate absorption
NEGLIGIBLE_MOMENT = 1e-17  # moment g^l at which the series ends


@dataclass(frozen=True)
class Quadrature:
    """Cosines in (0, 1) inside the medium, with weights and the boundary's transmittance.

    Parameters
    ----------
    cosines : ndarray
        Cosines inside; the last ones lie in the escape cone, at Gauss's cosines outside, shape (n,)
        [1].
    weights : ndarray
        Quadrature weights, shape (n,) [1].
    passed : ndarray
        Transmittance T of the boundary, 0 beyond the critical angle, shape (n,) [1].
    outside : ndarray
        Gauss's cosines outside, shape (NODES,) [1].
    outside_weights : ndarray
        Their weights, shape (NODES,) [1].
    """

    cosines: np.ndarray
    weights: np.ndarray
    passed: np.ndarray
    outside: np.ndarray
    outside_weights: np.ndarray


@dataclass(frozen=True)
class Turbid:
    """Solution for one turbid medium, from `solved`; arrays by cosine (i) and by mode (k).

    Parameters
    ----------
    albedo : float
        Single-scattering albedo a [1].
    thickness : float
        Optical thickness, inf for a half space [1].
    cosine : float
        Refracted cosine μ₀ of the unscattered light [1].
    entered : float
        Share T that the boundary transmits at first incidence [1].
    specular : float
        Share 1 - T that the boundary reflects at first incidence [1].
    nodes : Quadrature
        Quadrature over cosines.
    rates : ndarray
        Decay rates Σ of the modes, decreasing, shape (k,) [per mean free path].
    sums : ndarray
        Matrix from p + m to J, shape (i, k).
    differences : ndarray
        Matrix from p - m to K, shape (i, k).
    driven : tuple of ndarray
        Amplitudes q and r of the source terms, shape (k,) each.
    free : tuple of ndarray
        Homogeneous parts of p at the top and of m at the bottom, shape (k,) each.
    """

    albedo: float
    thickness: float  # optical; infinite: a half space
    cosine: float  # μ₀, refracted cosine of the unscattered light
    entered: float  # T, share that the boundary transmits at first incidence
    specular: float  # 1 - T, share that the boundary reflects at first incidence
    nodes: Quadrature
    rates: np.ndarray  # Σ, decreasing
    sums: np.ndarray  # (i, k): J from p + m
    differences: np.ndarray  # (i, k): K from p - m
    driven: tuple[np.ndarray, np.ndarray]  # q and r
    free: tuple[np.ndarray, np.ndarray]  # homogeneous part of p at the top, of m at the bottom

    @property
    def reflectance(self) -> float:
        """Diffuse reflectance: share that leaves on the irradiated side, without the specular part [1]."""
        down, up = self._echoes
        return float(down * self._reflected_once + up * self._transmitted_once)

    @property
    def transmittance(self) -> float:
        """Share that leaves on the other side, unscattered light included [1]; 0 for a half space."""
        down, up = self._echoes
        return float(down * self._transmitted_once + up * self._reflected_once)

    @property
    def absorbed(self) -> float:
        """Absorbed share, from the fluence [1]; the rest is specular, reflected or transmitted."""
        return (1 - self.albedo) * self._integral(0.0, self.thickness)

    @property
    def slowest_rate(self) -> float:
        """Asymptotic decay rate [per mean free path]; sqrt(3 (1 - a)(1 - a g)) in diffusion theory."""
        return float(self.rates[-1])

    def fluence(self, depth: np.ndarray) -> np.ndarray:
        """Return the fluence rate over the irradiance.

        Parameters
        ----------
        depth : ndarray
            Optical depths, from 0 to the thickness [mean free paths].

        Returns
        -------
        ndarray
            Fluence rate over irradiance, shape of `depth` [1].

        Raises
        ------
        ValueError
            If a depth is outside the medium.
        """
        down, up = self._echoes
        depth = self._settled(depth)
        return down * self._own_fluence(depth) + (up and up * self._own_fluence(self.thickness - depth))

    def mean_fluence(self, edges: np.ndarray) -> np.ndarray:
        """Return means over depth of the fluence rate over the irradiance.

        Parameters
        ----------
        edges : ndarray
            Edges of the cells, increasing, shape (cells + 1,) [mean free paths].

        Returns
        -------
        ndarray
            Means, shape (cells,) [1].

        Raises
        ------
        ValueError
            If a depth is outside the medium.
        """
        depths = self._settled(edges).tolist()
        pairs = zip(depths[:-1], depths[1:], strict=True)
        return np.array([self._integral(low, high) / (high - low) for low, high in pairs])

    def radiance(self, cosine: np.ndarray) -> np.ndarray:
        """Return the scattered radiance outside on the irradiated side, over the irradiance.

        Parameters
        ----------
        cosine : ndarray
            Cosines outside [1].

        Returns
        -------
        ndarray
            Radiance over irradiance, shape of `cosine` [sr^-1].
        """
        return legendre.legval(2 * np.asarray(cosine, float) - 1, self._spectrum) / (2 * math.pi)

    def leaving(self, edges: np.ndarray) -> np.ndarray:
        """Return the shares that leave scattered on the irradiated side, in bins of the cosine outside.

        Parameters
        ----------
        edges : ndarray
            Edges of the bins of cosine, increasing, shape (bins + 1,) [1].

        Returns
        -------
        ndarray
            Shares, shape (bins,) [1].
        """
        rise = legendre.legint(legendre.legmul(self._spectrum, [0.25, 0.25]))  # ν I dν, ν = (t + 1)/2
        return np.diff(legendre.legval(2 * np.asarray(edges, float) - 1, rise))

    # ---- light that starts at the top only; `up` is the factor of light that starts at the bottom ----

    @property
    def _echoes(self) -> tuple[float, float]:
        transmission = math.exp(-self.thickness / self.cosine)
        down = 1 / (1 - (self.specular * transmission) ** 2)
        return down, self.specular * transmission * down

    @property
    def _reflected_once(self) -> float:
        nodes = self.nodes
        return float(nodes.outside * nodes.outside_weights @ self._escaping(0.0)[1])

    @property
    def _transmitted_once(self) -> float:
        if math.isinf(self.thickness):
            return 0.0
        nodes, straight = self.nodes, self.entered**2 * math.exp(-self.thickness / self.cosine)
        return straight + float(nodes.outside * nodes.outside_weights @ self._escaping(self.thickness)[0])

    @property
    def _spectrum(self) -> np.ndarray:
        """I outside on the irradiated side, as a sum of Legendre polynomials of t = 2 ν - 1."""
        down, up = self._echoes
        values = down * self._escaping(0.0)[1] + (up and up * self._escaping(self.thickness)[0])
        order = np.arange(len(values))
        basis = legendre.legvander(2 * self.nodes.outside - 1, len(values) - 1)
        return (2 * order + 1) * (basis.T @ (self.nodes.outside_weights * values))

    def _escaping(self, depth: float) -> tuple[np.ndarray, np.ndarray]:
        """Downward and upward I beyond a boundary, T I/n², at the cosines outside, (ν,)."""
        p, m = self._parts(depth)
        count, root = len(self.nodes.outside), np.sqrt(self.nodes.weights)
        total, difference = self.sums @ (p + m) / root, self.differences @ (p - m) / root
        within = self.nodes.cosines * self.nodes.weights / 2 * self.nodes.passed
        beyond = within[-count:] / (self.nodes.outside * self.nodes.outside_weights)
        return beyond * (total + difference)[-count:], beyond * (total - difference)[-count:]

    def _own_fluence(self, depth: np.ndarray) -> np.ndarray:
        straight = self.entered / self.cosine * np.exp(-depth / self.cosine)
        return straight + sum(self._parts(depth)) @ self._to_fluence

    def _integral(self, low: float, high: float) -> float:
        """Integral of the fluence between two depths."""
        down, up = self._echoes
        beyond = self.thickness - high, self.thickness - low
        return down * self._own_integral(low, high) + (up and up * self._own_integral(*beyond))

    def _own_integral(self, low: float, high: float) -> float:
        """Integral by p' = -Σ p + q e and m' = Σ m + r e, which avoids differences of rates."""
        steep, (q, r) = 1 / self.cosine, self.driven
        straight = math.exp(-low * steep) * -math.expm1(-(high - low) * steep) / steep
        first, last = self._parts(low), self._parts(high)
        p = (first[0] - last[0] + q * straight) / self.rates
        m = (last[1] - first[1] - r * straight) / self.rates
        return float(self.entered / self.cosine * straight + self._to_fluence @ (p + m))

    def _settled(self, depth) -> np.ndarray:
        depth = np.asarray(depth, dtype=float)
        if not ((depth >= 0) & (depth <= self.thickness)).all():
            raise ValueError(f"Turbid: depths must be from 0 to {self.thickness}, got {depth}")
        return depth

    @property
    def _to_fluence(self) -> np.ndarray:
        return np.sqrt(self.nodes.weights) @ self.sums

    def _parts(self, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """p and m at these depths, (..., k)."""
        z, up = np.asarray(depth, dtype=float)[..., None], 0.0
        if math.isfinite(self.thickness):
            up = self.free[1] * np.exp(-self.rates * (self.thickness - z))
        p, m = _particular_solution(z, self.rates, 1 / self.cosine, self.driven)
        return self.free[0] * np.exp(-self.rates * z) + p, m + up


@lru_cache(maxsize=32)
def solved(
    albedo: float, g: float, index: float = 1.0, cosine: float = 1.0, thickness: float = math.inf
) -> Turbid:
    """Solve for a turbid half space or slab; the result is cached.

    Parameters
    ----------
    albedo : float
        Single-scattering albedo, in (0, 1 - 1e-6] [1].
    g : float
        Mean scattering cosine, from -0.95 to 0.95 [1].
    index : float, default 1.0
        Index over that of the surroundings, at least 1 [1].
    cosine : float, default 1.0
        Cosine of incidence outside, in (0, 1] [1].
    thickness : float, default math.inf
        Optical thickness, above 0; inf for a half space [1].

    Returns
    -------
    Turbid
        The solution.

    Raises
    ------
    ValueError
        If an argument is out of range.

    Examples
    --------
    >>> from transport.theory.turbid import solved
    >>> print(f"{solved(0.9, 0.5).reflectance:.4g}")
    0.2778
    """
    if not (
        0 < albedo <= MAX_ALBEDO and abs(g) <= MAX_G and index >= 1 and 0 < cosine <= 1 and thickness > 0
    ):
        given = f"{albedo=}, {g=}, {index=}, {cosine=}, {thickness=}"
        raise ValueError(f"turbid.solved: albedo in (0, 1 - 1e-6], |g| <= 0.95, index >= 1, got {given}")
    nodes, within, entered = (
        _quadrature(index),
        float(snell_cosine(cosine, index)),
        float(transmittance(cosine, index)),
    )
    (a, even), (b, odd) = (_of_parity(parity, albedo, g, nodes, within) for parity in (0, 1))
    c, d, mu = np.linalg.cholesky(a), np.linalg.cholesky(b), nodes.cosines
    u, rates, vt = np.linalg.svd(d.T @ (c / mu[:, None]))
    strength = albedo * entered / within
    f, h = (
        strength * left @ (right.T @ (drive / mu)) for left, right, drive in ((vt, c, odd), (u.T, d, even))
    )
    sums, differences = np.linalg.solve(c.T, vt.T), np.linalg.solve(d.T, u)
    driven = (f + h) / 2, (f - h) / 2
    free = _homogeneous_solution(nodes.passed, sums, differences, rates, driven, 1 / within, thickness)
    specular = float(reflectance(cosine, index))
    return Turbid(albedo, thickness, within, entered, specular, nodes, rates, sums, differences, driven, free)


def _quadrature(index: float) -> Quadrature:
    x, w = legendre_nodes(NODES)
    x, w = (x + 1) / 2, w / 2
    critical = math.sqrt((index - 1) * (index + 1)) / index
    refracted = np.sqrt(critical**2 + (x / index) ** 2)
    cosines, weights, passed = refracted, w * x / (index**2 * refracted), transmittance(x, index)
    if critical > 0:
        cosines, weights = np.append(critical * x, cosines), np.append(critical * w, weights)
        passed = np.append(np.zeros(NODES), passed)
    return Quadrature(cosines, weights, passed, x, w)


def _of_parity(parity: int, albedo: float, g: float, nodes: Quadrature, within: float):
    """A or B, and the beam's contribution to it by scattering, for the l of one parity."""
    last = 1 if g == 0 else math.ceil(math.log(NEGLIGIBLE_MOMENT) / math.log(abs(g)))
    order = np.arange(parity, last + 1, 2)
    moment = (2 * order + 1) * float(g) ** order
    basis = np.sqrt(nodes.weights)[:, None] * legendre.legvander(nodes.cosines, last)[:, order]
    beam = legendre.legvander(np.array([within]), last)[0, order]
    return np.eye(len(basis)) - albedo * (basis * moment) @ basis.T, basis @ (moment * beam)


def _particular_solution(
    z: np.ndarray, rates: np.ndarray, steep: float, driven: tuple
) -> tuple[np.ndarray, np.ndarray]:
    """Particular solution: p is 0 at the top, m falls with the beam; accurate for nearly equal rates."""
    gap = np.maximum(np.abs(rates - steep), 1e-12 * steep)
    p = driven[0] * np.exp(-np.minimum(rates, steep) * z) * -np.expm1(-gap * z) / gap
    return p, -driven[1] / (rates + steep) * np.exp(-steep * z)


def _homogeneous_solution(
    passed, sums, differences, rates, driven, steep, thickness
) -> tuple[np.ndarray, np.ndarray]:
    """Homogeneous parts, from T J ± (1 + R) K = 0 at the top (+) and at the bottom (-), R = 1 - T."""
    of_sum, of_difference = passed[:, None] * sums, (2 - passed)[:, None] * differences
    near, far = (
        of_sum + of_difference,
        of_sum - of_difference,
    )  # at the top: factors of p and m; swapped at the bottom
    top = far @ _particular_solution(np.float64(0), rates, steep, driven)[1]
    if math.isinf(thickness):
        return np.linalg.solve(near, -top), np.zeros_like(rates)
    p, m = _particular_solution(np.float64(thickness), rates, steep, driven)
    across = far * np.exp(-rates * thickness)
    both = np.linalg.solve(np.block([[near, across], [across, near]]), -np.append(top, far @ p + near @ m))
    return both[: len(rates)], both[len(rates) :]


# ---- Diffusion approximation for a turbid half space, as a sum of two exponentials.
#
# The exact solution is turbid.py. A photon loses its direction in 1/(1 - g) scatterings, so that they
# count as σ_s (1 - g) isotropic ones, and the unscattered beam as one that falls with σ_t' = σ_t (1 - a
# g) (similarity; van de Hulst 1980). Depths z are in mean free paths 1/σ_t, so that σ_t' = 1 - a g. With
# D = 1/(3 σ_t') and T the boundary's transmittance, the diffuse fluence rate φ obeys
#
#     D φ'' = (1 - a) φ - a (1 - g) T e^(-σ_t' z),   φ(0) = 2 A D φ'(0),   A = (1 + R_j)/(1 - R_φ),
#
# R_φ and R_j the boundary's internal reflectances for isotropic light, weighted with 2 μ and 3 μ²
# (Haskell et al. 1994, J. Opt. Soc. Am. A 11, 2727). The emerging flux density is D φ'(0).

DIFFUSION_NODES = 64


@dataclass(frozen=True)
class Diffusion:
    """A half space irradiated from above by 1 W m^-2 at normal incidence, by diffusion theory.

    Parameters
    ----------
    albedo : float
        Single-scattering albedo a, in (0, 1) [1].
    g : float
        Mean scattering cosine [1].
    index : float, default 1.0
        Index over that of the medium above [1].

    Examples
    --------
    >>> from transport.theory.turbid import Diffusion
    >>> print(f"{Diffusion(0.99, 0.9).reflectance:.4g}")
    0.4414
    """

    albedo: float
    g: float
    index: float = 1.0

    @property
    def rate(self) -> float:
        """Asymptotic decay rate of the fluence [per mean free path]: sqrt(3 (1 - a)(1 - a g))."""
        return math.sqrt(3 * (1 - self.albedo) * (1 - self.albedo * self.g))

    @property
    def reflectance(self) -> float:
        """Diffuse reflectance: share that leaves the medium, without the specular part [1]."""
        return sum(self._diffuse) / (2 * boundary_factor(self.index))

    def fluence(self, depth: np.ndarray) -> np.ndarray:
        """Return the fluence rate over the irradiance, beam and diffuse part.

        Parameters
        ----------
        depth : ndarray
            Optical depths [mean free paths].

        Returns
        -------
        ndarray
            Fluence rate over irradiance, shape of `depth` [1].
        """
        beam, slow = self._diffuse
        steep = np.exp(np.multiply(depth, -(1 - self.albedo * self.g)))
        return (beam + self._entered) * steep + slow * np.exp(np.multiply(depth, -self.rate))

    @property
    def _entered(self) -> float:
        return float(transmittance(1.0, self.index))

    @property
    def _diffuse(self) -> tuple[float, float]:
        """Amplitudes at the top of the part that falls with the beam and of that with `rate`."""
        reduced, factor = 1 - self.albedo * self.g, boundary_factor(self.index)
        beam = self.albedo * (1 - self.g) * self._entered / (1 - self.albedo - reduced / 3)
        return beam, -beam * (1 + 2 * factor / 3) / (1 + 2 * factor * self.rate / (3 * reduced))


def boundary_factor(index: float) -> float:
    """Factor A of the boundary condition φ = 2 A D φ'.

    Parameters
    ----------
    index : float
        Index over that of the medium above, at least 1 [1].

    Returns
    -------
    float
        A [1]: 1 without a boundary, 2.95 for an index of 1.4.

    Notes
    -----
    Source: Haskell et al. 1994.

    Examples
    --------
    >>> from transport.theory.turbid import boundary_factor
    >>> print(f"{boundary_factor(1.4):.4g}")
    2.948
    """
    x, w = legendre_nodes(DIFFUSION_NODES)
    outside, w = (x + 1) / 2, w / 2
    critical = math.sqrt((index - 1) * (index + 1)) / index
    within = np.sqrt(critical**2 + (outside / index) ** 2)
    flux = critical**3 + 3 * float(w @ (reflectance(outside, index) * within * outside)) / index**2
    return (1 + flux) / (1 - float(diffuse_reflectance(1 / index)))
