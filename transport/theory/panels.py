"""A square panel on the axis: change of irradiance and solid angle when the distance doubles.

A panel of radiance L and side a gives the irradiance E = L P and the fluence rate L Ω, with P the
projected solid angle and Ω the solid angle (solid_angles.py). Far away both tend to (a/d)²:

    P (d/a)² = 1 - (a/d)²/3 + ...,   Ω (d/a)² = 1 - (a/d)²/4 + ...,

because cos⁴θ and cos³θ fall by 2 and 3/2 times r²/d², whose mean is a²/6. At twice the distance a
detector has E/4 (1 + (a/2d)²) and Ω/4 (1 + 3/4 (a/2d)²), while L is the same at any distance.
"""

from __future__ import annotations

import numpy as np

from transport.theory.nodes import legendre_nodes
from transport.theory.solid_angles import rectangle_projected_solid_angle, rectangle_solid_angle

NODES = 8  # Gauss-Legendre nodes along each side of a detector that is small compared with its distance


def mean_rectangle_solid_angle(width: float, height: float, distance: float, side: float) -> float:
    """Solid angle of a rectangle, averaged over a parallel square detector on its axis.

    Parameters
    ----------
    width : float
        Width of the rectangle [m].
    height : float
        Height of the rectangle [m].
    distance : float
        Distance d between the planes [m].
    side : float
        Side of the detector, at most `width` and `height` [m].

    Returns
    -------
    float
        Mean solid angle [sr].

    Notes
    -----
    At a point it is a sum over the four corners of ``atan(x y / (d sqrt(d² + x² + y²)))``, with x and y
    from the point's projection (Van Oosterom and Strackee 1983).

    Examples
    --------
    >>> from transport.theory.panels import mean_rectangle_solid_angle
    >>> print(f"{mean_rectangle_solid_angle(1.0, 1.0, 2.0, 0.1):.4g}")
    0.2353
    """
    t, weight = legendre_nodes(NODES)
    x, y = (long / 2 + np.outer([1, -1], side / 2 * t) for long in (width, height))
    product = np.multiply.outer(x, y)
    slant = np.sqrt(np.add.outer(x**2, y**2) + distance**2)
    corners = np.arctan2(product, distance * slant).sum(axis=(0, 2))
    return float(weight @ corners @ weight) / 4


def doubled_irradiance(side: float, distance: float) -> float:
    """Ratio E(2d) / E(d) on the axis of a square panel.

    Parameters
    ----------
    side : float or ndarray
        Side a of the panel [m].
    distance : float or ndarray
        Distance d on the axis [m].

    Returns
    -------
    float or ndarray
        Ratio [1]; it tends to 1/4.

    Examples
    --------
    >>> from transport.theory.panels import doubled_irradiance
    >>> print(f"{doubled_irradiance(1.0, 2.0):.4g}")
    0.2652
    """
    near, far = (rectangle_projected_solid_angle(side, side, np.multiply(k, distance)) for k in (1, 2))
    return far / near


def doubled_solid_angle(side: float, distance: float) -> float:
    """Ratio Ω(2d) / Ω(d) on the axis of a square panel.

    Parameters
    ----------
    side : float or ndarray
        Side a of the panel [m].
    distance : float or ndarray
        Distance d on the axis [m].

    Returns
    -------
    float or ndarray
        Ratio [1]; it tends to 1/4.

    Examples
    --------
    >>> from transport.theory.panels import doubled_solid_angle
    >>> print(f"{doubled_solid_angle(1.0, 2.0):.4g}")
    0.2614
    """
    near, far = (rectangle_solid_angle(side, side, np.multiply(k, distance)) for k in (1, 2))
    return far / near


def far_irradiance_excess(side: float, distance: float) -> float:
    """Relative excess of E(2d) / E(d) over 1/4, far away.

    Parameters
    ----------
    side : float or ndarray
        Side a of the panel [m].
    distance : float or ndarray
        Distance d on the axis [m].

    Returns
    -------
    float or ndarray
        ``(a/2d)²`` [1].

    Examples
    --------
    >>> from transport.theory.panels import far_irradiance_excess
    >>> print(f"{far_irradiance_excess(1.0, 2.0):.4g}")
    0.0625
    """
    return np.square(side / np.multiply(2, distance))


def far_solid_angle_excess(side: float, distance: float) -> float:
    """Relative excess of Ω(2d) / Ω(d) over 1/4, far away.

    Parameters
    ----------
    side : float or ndarray
        Side a of the panel [m].
    distance : float or ndarray
        Distance d on the axis [m].

    Returns
    -------
    float or ndarray
        ``3/4 (a/2d)²`` [1].

    Examples
    --------
    >>> from transport.theory.panels import far_solid_angle_excess
    >>> print(f"{far_solid_angle_excess(1.0, 2.0):.4g}")
    0.04688
    """
    return 0.75 * far_irradiance_excess(side, distance)
