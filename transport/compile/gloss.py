"""Bounds of the density of directions that leave glossy surfaces."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from transport.scene.materials import Material
from transport.statistics.microfacet_lobe import lobe

GRID_SAFETY = 1.05  # safety factor over the maximum on a grid of angles
MIN_TILT, MAX_TILT, TILTS = 1e-2, 1e3, 400  # of half vectors on that grid, relative to the roughness
# of directions that leave: least cosine relative to the roughness, and number of cosines
MIN_COSINE, COSINES = 1e-3, 500


def glossy_parts(material: Material) -> list[Material]:
    """Return the elementary materials whose microfacets send next-event rays."""
    return [part for part in material.elements if part.shares.glossy > 0]


@lru_cache(maxsize=256)
def lobe_peak(roughness: float) -> float:
    """Return the largest density of the multiple-scattering lobe [sr^-1]: 1/(pi (1 - E_mean))."""
    return 1.0 / (math.pi * lobe(roughness).mean_lost)


def single_peak(roughness: float, cosine: np.ndarray | float) -> np.ndarray:
    """Return the largest density of single reflection [sr^-1] into directions of at least these cosines."""
    cosines, peaks = _single_peaks(roughness)
    return peaks[np.maximum(np.searchsorted(cosines, cosine, side="right") - 1, 0)]


@lru_cache(maxsize=256)
def _single_peaks(roughness: float) -> tuple[np.ndarray, np.ndarray]:
    """Return cosines of directions that leave, and the largest density there and nearer to the normal.

    Over all directions of arrival. With h = sqrt(mu^2 + alpha^2 (1 - mu^2)) and D the density of normals, the
    density is D mu_out/(2 (h_in mu_out + h_out mu_in)), which is largest in the plane of incidence.
    """
    alpha2 = roughness * roughness
    tilts = roughness * np.geomspace(MIN_TILT, MAX_TILT, TILTS)
    tilt = np.concatenate([-tilts, [0.0], tilts])[:, None]  # of the half vector from the normal
    mu_out = np.geomspace(MIN_COSINE * roughness, 1.0, COSINES)
    arriving = np.arccos(mu_out) + 2 * tilt
    mu_in = np.maximum(np.cos(arriving), 0.0)
    h_out, h_in = (np.sqrt(mu * mu + alpha2 * (1 - mu * mu)) for mu in (mu_out, mu_in))
    normals = alpha2 / (math.pi * (alpha2 * np.cos(tilt) ** 2 + np.sin(tilt) ** 2) ** 2)
    density = normals * mu_out / (2 * (h_in * mu_out + h_out * mu_in))
    peaks = np.max(density, axis=0, where=np.abs(arriving) <= math.pi / 2, initial=0.0)
    return mu_out, GRID_SAFETY * np.maximum.accumulate(peaks[::-1])[::-1]
