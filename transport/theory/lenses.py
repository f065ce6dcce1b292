"""Lenses: they conserve radiance at best and fill a wider cone with it, E = n^2 pi L sin^2 theta'.

A lossless optic conserves étendue, and so radiance over n^2 (Straubel 1902; Hanrahan 2001, Stanford CS
348B, lecture 4, "Throughput"). A detector that receives L within a cone of half angle theta' about its
normal, in a medium of index n, has the irradiance n^2 pi L sin^2 theta'. That is sin^2 theta'/sin^2
theta_s times its irradiance by a source of half angle theta_s alone, at most 1/sin^2 theta_s in air
(Winston, Miñano, Benítez 2005, "Nonimaging Optics", 1.2).

The planted fault of the tests: a lens that adds to tangents what a lens that conserves étendue adds to
direction cosines. In tangents t the measure of rays is cosθ dω = cos^4 θ d²t; the map conserves d²t, so
that radiance changes by cos^4 θ / cos^4 θ'.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from transport.statistics.quadrature import legendre_nodes
from transport.theory.optical_paths import Rays, from_to, refract


def cone_of(f_number: float) -> float:
    """Half angle of the light at the focus of a flat thin lens.

    Parameters
    ----------
    f_number : float or ndarray
        f-number N [1].

    Returns
    -------
    float or ndarray
        ``atan(1/2N)`` [rad].

    Examples
    --------
    >>> from transport.theory.lenses import cone_of
    >>> print(f"{cone_of(2.0):.4g}")
    0.245
    """
    return np.arctan(np.divide(0.5, f_number))


def focus_irradiance(radiance: float, half_angle: float, index: float = 1.0) -> float:
    """Irradiance at a focus from a cone of directions with the source's radiance.

    Parameters
    ----------
    radiance : float or ndarray
        Radiance L of the source [W m^-2 sr^-1].
    half_angle : float or ndarray
        Half angle theta' of the cone of light at the focus [rad].
    index : float or ndarray, default 1.0
        Refractive index n at the detector [1].

    Returns
    -------
    float or ndarray
        ``n^2 pi L sin^2 theta'`` [W m^-2].

    Examples
    --------
    >>> from transport.theory.lenses import focus_irradiance
    >>> print(f"{focus_irradiance(1.0, 0.5):.4g}")
    0.7221
    """
    return index**2 * math.pi * radiance * np.sin(half_angle) ** 2


def image_irradiance(radiance: float, f_number: float) -> float:
    """Irradiance in the image of an aplanatic lens, for a distant source.

    Parameters
    ----------
    radiance : float or ndarray
        Radiance L of the source [W m^-2 sr^-1].
    f_number : float or ndarray
        f-number N; sin theta' = 1/2N [1].

    Returns
    -------
    float or ndarray
        ``pi L/(4 N^2)`` [W m^-2].

    Examples
    --------
    >>> from transport.theory.lenses import image_irradiance
    >>> print(f"{image_irradiance(1.0, 2.0):.4g}")
    0.1963
    """
    return math.pi * radiance / (4 * np.square(f_number))


def concentration(half_angle: float, of_source: float, index: float = 1.0) -> float:
    """Irradiance at the focus over that by the source alone.

    Parameters
    ----------
    half_angle : float or ndarray
        Half angle theta' of the cone of light at the focus [rad].
    of_source : float or ndarray
        Half angle theta_s of the source [rad].
    index : float or ndarray, default 1.0
        Refractive index n at the detector [1].

    Returns
    -------
    float or ndarray
        ``n^2 sin^2 theta'/sin^2 theta_s`` [1].

    Examples
    --------
    >>> from transport.theory.lenses import concentration
    >>> print(f"{concentration(0.5, 0.00465):.4g}")
    1.063e+04
    """
    return np.square(index * np.sin(half_angle) / np.sin(of_source))


def highest_concentration(of_source: float, index: float = 1.0) -> float:
    """Upper limit of the concentration by any optic.

    Parameters
    ----------
    of_source : float or ndarray
        Half angle theta_s of the source [rad].
    index : float or ndarray, default 1.0
        Refractive index n at the detector [1].

    Returns
    -------
    float or ndarray
        ``n^2/sin^2 theta_s`` [1], for a whole hemisphere of the source's radiance.

    Notes
    -----
    Source: Winston, Miñano, Benítez 2005, 1.2.

    Examples
    --------
    >>> from transport.theory.lenses import highest_concentration
    >>> print(f"{highest_concentration(0.00465):.4g}")
    4.625e+04
    """
    return concentration(math.pi / 2, of_source, index)


def ball_focal_length(radius: float, index: float) -> float:
    """Paraxial focal length of a ball lens, from its center.

    Parameters
    ----------
    radius : float
        Radius R [m].
    index : float
        Refractive index n [1].

    Returns
    -------
    float
        ``n R/(2 (n - 1))`` [m].

    Examples
    --------
    >>> from transport.theory.lenses import ball_focal_length
    >>> print(f"{ball_focal_length(1.0, 1.5):.4g}")
    1.5
    """
    return index * radius / (2 * (index - 1))


def ball_back_focal_length(radius: float, index: float) -> float:
    """Paraxial back focal length of a ball lens, from its rear surface.

    Parameters
    ----------
    radius : float
        Radius R [m].
    index : float
        Refractive index n [1].

    Returns
    -------
    float
        ``R (2 - n)/(2 (n - 1))`` [m].

    Examples
    --------
    >>> from transport.theory.lenses import ball_back_focal_length
    >>> print(f"{ball_back_focal_length(1.0, 1.5):.4g}")
    0.5
    """
    return radius * (2 - index) / (2 * (index - 1))


def ball_axis_crossing(height: float, radius: float, index: float) -> float:
    """Distance from a ball lens's center at which a ray parallel to the axis crosses the axis.

    Parameters
    ----------
    height : float or ndarray
        Distance h of the ray from the axis, above 0, at most R [m].
    radius : float or ndarray
        Radius R of the ball [m].
    index : float or ndarray
        Refractive index n [1].

    Returns
    -------
    float or ndarray
        ``h/sin(2 (i - r))`` [m].

    Notes
    -----
    The ray meets the ball at the angle i, ``sin i = h/R``, is deflected by ``2 (i - r)``,
    ``sin r = sin i/n``, and leaves at the same distance h from the center. Exact for any height.

    Examples
    --------
    >>> from transport.theory.lenses import ball_axis_crossing
    >>> print(f"{ball_axis_crossing(0.5, 1.0, 1.5):.4g}")
    1.392
    """
    sine = np.divide(height, radius)
    return height / np.sin(2 * (np.arcsin(sine) - np.arcsin(sine / index)))


def lens_focal_length(curvature_radius: float, thickness: float, index: float) -> float:
    """Focal length of a biconvex lens of two equal spherical faces (lensmaker's formula).

    Parameters
    ----------
    curvature_radius : float
        Radius of curvature R of both faces [m].
    thickness : float
        Thickness d on the axis [m].
    index : float
        Refractive index n [1].

    Returns
    -------
    float
        f [m], with ``1/f = (n - 1) [2/R - (n - 1) d/(n R^2)]``.

    Examples
    --------
    >>> from transport.theory.lenses import lens_focal_length
    >>> print(f"{lens_focal_length(1.0, 0.2, 1.5):.4g}")
    1.034
    """
    power = (index - 1) * (2 - (index - 1) * thickness / (index * curvature_radius)) / curvature_radius
    return 1 / power


def tangent_lens_radiance(radiance: float, before: float, behind: float) -> float:
    """Radiance behind a lens that maps tangents, which violates conservation of étendue.

    Parameters
    ----------
    radiance : float or ndarray
        Radiance L of the source [W m^-2 sr^-1].
    before : float or ndarray
        Angle theta in front of the lens [rad].
    behind : float or ndarray
        Angle theta' behind the lens [rad].

    Returns
    -------
    float or ndarray
        ``L cos^4 theta/cos^4 theta'`` [W m^-2 sr^-1].

    Examples
    --------
    >>> from transport.theory.lenses import tangent_lens_radiance
    >>> print(f"{tangent_lens_radiance(1.0, 0.0, 0.5):.4g}")
    1.686
    """
    return radiance * (np.cos(before) / np.cos(behind)) ** 4


def tangent_lens_irradiance(radiance: float, half_angle: float) -> float:
    """Irradiance at the focus of a lens that maps tangents, for a distant source, at a point on the axis.

    Parameters
    ----------
    radiance : float or ndarray
        Radiance L of the source [W m^-2 sr^-1].
    half_angle : float or ndarray
        Half angle theta' of the cone of light at the focus [rad].

    Returns
    -------
    float or ndarray
        ``pi L tan^2 theta'`` [W m^-2].

    Notes
    -----
    The integral of ``L/cos^4 theta' cos theta' dω'``. Beyond 45 degrees it exceeds the source's own
    exitance pi L.

    Examples
    --------
    >>> from transport.theory.lenses import tangent_lens_irradiance
    >>> print(f"{tangent_lens_irradiance(1.0, 0.5):.4g}")
    0.9376
    """
    return math.pi * radiance * np.tan(half_angle) ** 2


# ---- Light of a uniform sky that reaches a detector through a glass lens with Fresnel losses.
#
# A detector of radius a lies at the origin and faces +z, through a window (a coaxial disk), a lens with
# spherical surfaces. Traced back, each of its rays ends on the sky of radiance L. The forward ray has the
# radiance (1 - R1)(1 - R2) L, so that
#
#     E = L/A ∬ (1 - R1)(1 - R2) cos²θ/r² dA dA_window,
#
# and the mean over a direction bin of the detector is the mean of (1 - R1)(1 - R2), weighted by cosθ dω.
# Light reflected inside the lens is left out: it arrives along other paths and adds at most the power
# that is missing here. The integrals are smooth: Gauss-Legendre, and the trapezoidal rule over azimuth.
#
# R is Fresnel's reflectance averaged over both polarisations at each surface, as for light that is
# unpolarised at every crossing. Light that keeps its polarisation passes two surfaces with a share that
# is larger by ((R_s - R_p)/2)².

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
    >>> from transport.theory.lenses import ball
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
    >>> from transport.theory.lenses import biconvex
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
    >>> from transport.theory.lenses import ball, steps
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
    >>> from transport.theory.lenses import ball, trace
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
    >>> from transport.theory.lenses import ball, projected_solid_angle
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
    >>> from transport.theory.lenses import ball, mean_transmittances
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
    >>> from transport.theory.lenses import axial_transmittance, ball
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
