"""Integrating sphere: irradiance and radiosity of its diffuse wall for light sent in.

The chord between two points of a sphere makes the same angle with both normals, so that cosθ cosθ'/π
r² = 1/A: light that leaves any point of the inside with the cosine law irradiates all of it uniformly
(Ulbricht 1900; Sumpner 1892). Only the shares of the area matter, not the positions of the ports. With
the albedos a_i on the shares f_i of the sphere's area A (an open port has albedo 0), reflected light is
reflected again with the probability

    a = Σ a_i f_i,

and series of reflections are geometric (Jacquez, Kuppenheim 1955; Goebel 1967). "Lamp": a point source
at the center irradiates the whole sphere uniformly, open ports included. "Beam": all of the flux first
strikes one point of the wall.
"""

from __future__ import annotations

import numpy as np


def mean_albedo(albedos, shares) -> float:
    """Mean albedo of the whole inside of the sphere.

    Parameters
    ----------
    albedos : array_like
        Albedos a_i of the parts, 0 for open ports, shape (parts,) [1].
    shares : array_like
        Shares f_i of the sphere's area, shape (parts,) [1].

    Returns
    -------
    float
        ``Σ a_i f_i`` [1].

    Examples
    --------
    >>> from transport.theory.integrating_sphere import mean_albedo
    >>> print(f"{mean_albedo([0.95, 0.0], [0.96, 0.04]):.4g}")
    0.912
    """
    return float(np.dot(albedos, shares))


def multiplier(albedo: float, port_share: float) -> float:
    """Sphere multiplier of a wall of one albedo and an open port.

    Parameters
    ----------
    albedo : float or ndarray
        Albedo a of the wall [1].
    port_share : float or ndarray
        Share f of the sphere's area that is open [1].

    Returns
    -------
    float or ndarray
        ``M = a / (1 - a (1 - f))`` [1].

    Notes
    -----
    The radiosity of the wall for a lamp is M Phi/A and its radiance M Phi/(pi A). For a beam that
    strikes the wall, the reflected flux adds up to M Phi and gives the irradiance M Phi/A at any other
    point.

    Examples
    --------
    >>> from transport.theory.integrating_sphere import multiplier
    >>> print(f"{multiplier(0.95, 0.04):.4g}")
    10.8
    """
    return albedo / (1 - albedo * (1 - np.asarray(port_share, dtype=float)))


def lamp_irradiance(flux: float, mean_albedo: float, area: float) -> float:
    """Irradiance of a lamp at any point of the sphere, direct and reflected.

    Parameters
    ----------
    flux : float or ndarray
        Incident flux Phi [W].
    mean_albedo : float or ndarray
        Mean albedo a of the whole inside, below 1 [1].
    area : float or ndarray
        Area A of the whole sphere [m^2].

    Returns
    -------
    float or ndarray
        ``Phi / (A (1 - a))`` [W m^-2].

    Examples
    --------
    >>> from transport.theory.integrating_sphere import lamp_irradiance
    >>> print(f"{lamp_irradiance(1.0, 0.9, 1.0):.4g}")
    10
    """
    return flux / area / (1 - np.asarray(mean_albedo, dtype=float))


def lamp_hits(wall_share: float, mean_albedo: float) -> float:
    """Mean number of times that a lamp's particle strikes parts of the sphere.

    Parameters
    ----------
    wall_share : float or ndarray
        Share of the sphere's area of these parts [1].
    mean_albedo : float or ndarray
        Mean albedo a of the whole inside, below 1 [1].

    Returns
    -------
    float or ndarray
        ``f / (1 - a)`` [1].

    Examples
    --------
    >>> from transport.theory.integrating_sphere import lamp_hits
    >>> print(f"{lamp_hits(0.96, 0.9):.4g}")
    9.6
    """
    return wall_share / (1 - np.asarray(mean_albedo, dtype=float))


def beam_irradiance(flux: float, albedo: float, mean_albedo: float, area: float) -> float:
    """Irradiance by the reflected light of a beam at any point.

    Parameters
    ----------
    flux : float or ndarray
        Incident flux Phi [W].
    albedo : float or ndarray
        Albedo a_1 of the part that the beam strikes [1].
    mean_albedo : float or ndarray
        Mean albedo a of the whole inside, below 1 [1].
    area : float or ndarray
        Area A of the whole sphere [m^2].

    Returns
    -------
    float or ndarray
        ``a_1 Phi / (A (1 - a))`` [W m^-2]; M Phi/A for one wall and an open port.

    Examples
    --------
    >>> from transport.theory.integrating_sphere import beam_irradiance
    >>> print(f"{beam_irradiance(1.0, 0.95, 0.9, 1.0):.4g}")
    9.5
    """
    return lamp_irradiance(albedo * flux, mean_albedo, area)


def beam_hits(albedo: float, wall_share: float, mean_albedo: float) -> float:
    """Mean number of times that a beam's particle strikes the wall, including the first.

    Parameters
    ----------
    albedo : float
        Albedo a_1 of the part that the beam strikes [1].
    wall_share : float
        Share f_1 of the sphere's area of this part [1].
    mean_albedo : float
        Mean albedo a of the whole inside, below 1 [1].

    Returns
    -------
    float
        ``1 + a_1 f_1 / (1 - a)`` [1]; 1 / (1 - a (1 - f)) for one wall and an open port.

    Examples
    --------
    >>> from transport.theory.integrating_sphere import beam_hits
    >>> print(f"{beam_hits(0.95, 0.96, 0.912):.4g}")
    11.36
    """
    return 1 + albedo * wall_share / (1 - mean_albedo)
