"""What comes straight through real glass to a detector behind it: sky of radiance L, Fresnel at every surface.

A detector of radius a lies about the origin and looks along +z through a window, a coaxial disk, at a lens of spherical
surfaces.  Traced back, each of its rays ends on the sky; the forward ray brings (1 - R1)(1 - R2) L, and so

    E = L/A ∬ (1 - R1)(1 - R2) cos²θ/r² dA dA_window,

and the mean over a bin of directions of what the detector sees is the mean of (1 - R1)(1 - R2), weighted by cosθ dω.
Light that was reflected inside and came later is left out; it comes by other ways, and brings at most what is missing.
The integrals are smooth and taken by Gauss-Legendre, over azimuth by the trapezoidal rule.

R is Fresnel's reflectance averaged over both polarisations at each surface, as for light that is unpolarised at every
crossing; light that keeps its polarisation passes two surfaces with a share that is greater by ((R_s - R_p)/2)².
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from transport.theory.nodes import legendre_nodes
from transport.theory.optical_paths import Rays, from_to, refract

NODES, TURNS = 20, 48  # along radii, and round half a turn


class Face(NamedTuple):
    """A sphere that a ray traced back meets: its center's height and radius [m], and whether at its second point."""

    center: float
    radius: float
    far: bool


def ball(height: float, radius: float) -> tuple[Face, Face]:
    """A ball about (0, 0, height) [m]."""
    return Face(height, radius, False), Face(height, radius, True)


def biconvex(height: float, rim: float, curvature_radius: float) -> tuple[Face, Face]:
    """Two caps of one curvature radius [m] on a rim of this radius at this height [m]."""
    depth = math.sqrt((curvature_radius - rim) * (curvature_radius + rim))
    return Face(height + depth, curvature_radius, False), Face(height - depth, curvature_radius, True)


def steps(faces: tuple[Face, Face], index: float) -> tuple[Callable[[Rays], Rays], Callable[[Rays], Rays]]:
    """The way back through both faces of a lens of glass of this index, a function of rays each."""
    into, out_of = faces
    return partial(refract, **into._asdict(), index=index), partial(
        refract, **out_of._asdict(), index=1 / index
    )


def trace(rays: Rays, faces: tuple[Face, Face], index: float) -> Rays:
    """Back through both faces."""
    enter, leave = steps(faces, index)
    return leave(enter(rays))


def projected_solid_angle(
    faces: tuple[Face, Face], index: float, detector: float, window: float, height: float
) -> float:
    """Mean of ∫ (1 - R1)(1 - R2) cosθ dω over a detector [sr]: its irradiance over the sky's radiance.

    detector, window: radii [m];  height: of the window.  Times the detector's area it is the étendue of what comes
    through, each ray counted by the share that does.
    """
    r, area_weights = _over_disk(detector)
    rho, window_weights = _over_disk(window)
    phi, turns = _half_turn()
    r, rho, phi = r[:, None, None], rho[None, :, None], phi[None, None, :]
    squares = height**2 + r**2 + rho**2 - 2 * r * rho * np.cos(phi)
    carried = _carried(faces, index, r, _stack(rho * np.cos(phi), rho * np.sin(phi), height))
    weights = area_weights[:, None, None] * window_weights[None, :, None] * turns
    return float(math.pi * window**2 * (weights * carried * (height / squares) ** 2).sum())


def mean_transmittances(
    faces: tuple[Face, Face], index: float, detector: float, theta_edges: Sequence[float]
) -> np.ndarray:
    """Means of (1 - R1)(1 - R2) over a detector [m] and bins of directions from its normal [1], one a bin."""
    r, area_weights = _over_disk(detector)
    phi, turns = _half_turn()
    means = []
    for low, high in np.square(np.sin(np.stack([theta_edges[:-1], theta_edges[1:]], axis=1))):
        nodes, weights = _unit_nodes()
        sine = np.sqrt(low + (high - low) * nodes)[None, :, None]
        x, y = r[:, None, None] + sine * np.cos(phi), sine * np.sin(phi)
        carried = _carried(faces, index, r[:, None, None], _stack(x, y, np.sqrt(1 - sine**2)))
        means.append((area_weights[:, None, None] * weights[None, :, None] * turns * carried).sum())
    return np.array(means)


def axial_transmittance(faces: tuple[Face, Face], index: float) -> Callable[[np.ndarray], np.ndarray]:
    """(1 - R1)(1 - R2) of the ray that reaches the origin at an angle theta to the axis, as a function of theta [rad]."""

    def share(theta: np.ndarray) -> np.ndarray:
        targets = _stack(np.sin(theta), 0.0, np.cos(theta))
        return trace(from_to(np.zeros(3), targets), faces, index).carried

    return share


def _carried(faces, index, r, targets) -> np.ndarray:
    return trace(from_to(_stack(r, 0.0, 0.0), targets), faces, index).carried


def _stack(*parts) -> np.ndarray:
    return np.stack(np.broadcast_arrays(*(np.asarray(part, float) for part in parts)), axis=-1)


def _unit_nodes() -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre on 0 to 1."""
    x, w = legendre_nodes(NODES)
    return (1 + x) / 2, w / 2


def _over_disk(radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Radii and weights of a mean over a disk's area."""
    x, w = _unit_nodes()
    return radius * x, 2 * x * w


def _half_turn() -> tuple[np.ndarray, np.ndarray]:
    """Azimuths from 0 to pi and weights of a mean over them, both ends included."""
    weights = np.full(TURNS + 1, 1 / TURNS)
    weights[[0, -1]] /= 2
    return np.linspace(0, np.pi, TURNS + 1), weights
