"""Diffusion approximation for a turbid half space, as a sum of two exponentials.

The exact solution is turbid.py. A photon loses its direction in 1/(1 - g) scatterings, so that they
count as σ_s (1 - g) isotropic ones, and the unscattered beam as one that falls with σ_t' = σ_t (1 - a
g) (similarity; van de Hulst 1980). Depths z are in mean free paths 1/σ_t, so that σ_t' = 1 - a g. With
D = 1/(3 σ_t') and T the boundary's transmittance, the diffuse fluence rate φ obeys

    D φ'' = (1 - a) φ - a (1 - g) T e^(-σ_t' z),   φ(0) = 2 A D φ'(0),   A = (1 + R_j)/(1 - R_φ),

R_φ and R_j the boundary's internal reflectances for isotropic light, weighted with 2 μ and 3 μ²
(Haskell et al. 1994, J. Opt. Soc. Am. A 11, 2727). The emerging flux density is D φ'(0).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from transport.theory.fresnel import diffuse_reflectance, reflectance, transmittance
from transport.theory.nodes import legendre_nodes

NODES = 64


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
    >>> from transport.theory.turbid_diffusion import Diffusion
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
    >>> from transport.theory.turbid_diffusion import boundary_factor
    >>> print(f"{boundary_factor(1.4):.4g}")
    2.948
    """
    x, w = legendre_nodes(NODES)
    outside, w = (x + 1) / 2, w / 2
    critical = math.sqrt((index - 1) * (index + 1)) / index
    within = np.sqrt(critical**2 + (outside / index) ** 2)
    flux = critical**3 + 3 * float(w @ (reflectance(outside, index) * within * outside)) / index**2
    return (1 + flux) / (1 - float(diffuse_reflectance(1 / index)))
