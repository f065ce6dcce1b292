"""Light of a uniform sky that reaches a detector through a glass lens with Fresnel losses.

A detector of radius a lies at the origin and faces +z, through a window (a coaxial disk), a lens with
spherical surfaces. Traced back, each of its rays ends on the sky of radiance L. The forward ray has the
radiance (1 - R1)(1 - R2) L, so that

    E = L/A ∬ (1 - R1)(1 - R2) cos²θ/r² dA dA_window,

and the mean over a direction bin of the detector is the mean of (1 - R1)(1 - R2), weighted by cosθ dω.
Light reflected inside the lens is left out: it arrives along other paths and adds at most the power
that is missing here. The integrals are smooth: Gauss-Legendre, and the trapezoidal rule over azimuth.

R is Fresnel's reflectance averaged over both polarisations at each surface, as for light that is
unpolarised at every crossing. Light that keeps its polarisation passes two surfaces with a share that
is larger by ((R_s - R_p)/2)².
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from transport.theory.nodes import legendre_nodes
from transport.theory.optical_paths import Rays, from_to, refract

NODES, TURNS = 20, 48  # nodes along radii, intervals over half a turn of azimuth


class Face(NamedTuple):
    """A sphere that a traced-back ray meets.

    Parameters
    ----------
    center : float
        Height z of the center [m].
    radius : float
        Radius [m].
    far : bool
        Whether the ray meets the sphere at its second intersection.
    """

    center: float
    radius: float
    far: bool


def ball(height: float, radius: float) -> tuple[Face, Face]:
    """Faces of a ball lens.

    Parameters
    ----------
    height : float
        Height z of the center [m].
    radius : float
        Radius [m].

    Returns
    -------
    tuple of 2 Face
        The faces.

    Examples
    --------
    >>> from transport.theory.glass_lenses import ball
    >>> ball(1.0, 0.5)[0]
    Face(center=1.0, radius=0.5, far=False)
    """
    return Face(height, radius, False), Face(height, radius, True)


def biconvex(height: float, rim: float, curvature_radius: float) -> tuple[Face, Face]:
    """Faces of a biconvex lens: two caps of equal curvature on one rim.

    Parameters
    ----------
    height : float
        Height z of the rim [m].
    rim : float
        Radius of the rim [m].
    curvature_radius : float
        Radius of curvature of both faces [m].

    Returns
    -------
    tuple of 2 Face
        The faces.

    Examples
    --------
    >>> from transport.theory.glass_lenses import biconvex
    >>> biconvex(1.0, 0.3, 0.5)[0]
    Face(center=1.4, radius=0.5, far=False)
    """
    depth = math.sqrt((curvature_radius - rim) * (curvature_radius + rim))
    return Face(height + depth, curvature_radius, False), Face(height - depth, curvature_radius, True)


def steps(faces: tuple[Face, Face], index: float) -> tuple[Callable[[Rays], Rays], Callable[[Rays], Rays]]:
    """Return two functions that trace rays back through the first and the second face.

    Parameters
    ----------
    faces : tuple of 2 Face
        The two faces of the lens, in the order in which a traced-back ray meets them.
    index : float
        Refractive index of the glass [1].

    Returns
    -------
    tuple of 2 callable
        Functions from Rays to Rays.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.optical_paths import from_to
    >>> from transport.theory.glass_lenses import ball, steps
    >>> enter, leave = steps(ball(1.0, 0.5), 1.5)
    >>> print(leave(enter(from_to(np.zeros(3), np.array([0.0, 0.0, 1.0])))).carried.round(4))
    0.9216
    """
    into, out_of = faces
    return partial(refract, **into._asdict(), index=index), partial(
        refract, **out_of._asdict(), index=1 / index
    )


def trace(rays: Rays, faces: tuple[Face, Face], index: float) -> Rays:
    """Trace rays back through both faces.

    Parameters
    ----------
    rays : Rays
        Rays from the detector.
    faces : tuple of 2 Face
        The two faces of the lens, in the order in which a traced-back ray meets them.
    index : float
        Refractive index of the glass [1].

    Returns
    -------
    Rays
        Rays beyond the lens.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.optical_paths import from_to
    >>> from transport.theory.glass_lenses import ball, trace
    >>> rays = from_to(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    >>> print(trace(rays, ball(1.0, 0.5), 1.5).carried.round(4))
    0.9216
    """
    enter, leave = steps(faces, index)
    return leave(enter(rays))


def projected_solid_angle(
    faces: tuple[Face, Face], index: float, detector: float, window: float, height: float
) -> float:
    """Mean of ``∫ (1 - R1)(1 - R2) cosθ dω`` over a detector: its irradiance over the sky's radiance.

    Parameters
    ----------
    faces : tuple of 2 Face
        The two faces of the lens, in the order in which a traced-back ray meets them.
    index : float
        Refractive index of the glass [1].
    detector : float
        Radius of the detector [m].
    window : float
        Radius of the window [m].
    height : float
        Height of the window above the detector [m].

    Returns
    -------
    float
        Weighted projected solid angle [sr]. Times the detector's area it is the étendue of the
        transmitted beam, each ray weighted by its transmitted share.

    Examples
    --------
    >>> from transport.theory.glass_lenses import ball, projected_solid_angle
    >>> print(f"{projected_solid_angle(ball(1.0, 0.5), 1.5, 0.01, 0.1, 0.4):.4g}")
    0.1701
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
    """Means of (1 - R1)(1 - R2) over a detector and bins of polar angle.

    Parameters
    ----------
    faces : tuple of 2 Face
        The two faces of the lens, in the order in which a traced-back ray meets them.
    index : float
        Refractive index of the glass [1].
    detector : float
        Radius of the detector [m].
    theta_edges : sequence of float
        Edges of the bins of the angle to the normal, increasing, shape (bins + 1,) [rad].

    Returns
    -------
    ndarray
        Mean transmittances, shape (bins,) [1].

    Examples
    --------
    >>> from transport.theory.glass_lenses import ball, mean_transmittances
    >>> print(mean_transmittances(ball(1.0, 0.5), 1.5, 0.01, [0.0, 0.1, 0.2]).round(4))
    [0.9216 0.9212]
    """
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
    """Return the transmittance of the ray that reaches the origin, as a function of its angle to the axis.

    Parameters
    ----------
    faces : tuple of 2 Face
        The two faces of the lens, in the order in which a traced-back ray meets them.
    index : float
        Refractive index of the glass [1].

    Returns
    -------
    callable
        Function of theta [rad] that returns ``(1 - R1)(1 - R2)`` [1].

    Examples
    --------
    >>> from transport.theory.glass_lenses import axial_transmittance, ball
    >>> print(f"{axial_transmittance(ball(1.0, 0.5), 1.5)(0.1):.4g}")
    0.9215
    """

    def share(theta: np.ndarray) -> np.ndarray:
        """Transmittance at polar angles theta [1]."""
        targets = _stack(np.sin(theta), 0.0, np.cos(theta))
        return trace(from_to(np.zeros(3), targets), faces, index).carried

    return share


def _carried(faces, index, r, targets) -> np.ndarray:
    return trace(from_to(_stack(r, 0.0, 0.0), targets), faces, index).carried


def _stack(*parts) -> np.ndarray:
    return np.stack(np.broadcast_arrays(*(np.asarray(part, float) for part in parts)), axis=-1)


def _unit_nodes() -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes and weights on [0, 1]."""
    x, w = legendre_nodes(NODES)
    return (1 + x) / 2, w / 2


def _over_disk(radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Radii and weights for a mean over a disk's area."""
    x, w = _unit_nodes()
    return radius * x, 2 * x * w


def _half_turn() -> tuple[np.ndarray, np.ndarray]:
    """Azimuths from 0 to pi, both ends included, and weights for a mean over them."""
    weights = np.full(TURNS + 1, 1 / TURNS)
    weights[[0, -1]] /= 2
    return np.linspace(0, np.pi, TURNS + 1), weights
