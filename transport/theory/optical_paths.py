"""Exact ray tracing through optics about the z axis, one element after the other.

No small-angle approximation is made. A ray is a point, a unit vector and the share of its power that
remains. Elements: spheres that refract by Snell's law, with Fresnel losses for light that is
unpolarised at every crossing; mirrors that are spheres or paraboloids; an ideal lens that maps
direction cosines, p' = p - x/f; and a lens that maps tangents, t' = t - x/f, as textbooks draw it.
Paths of light are reversible, so that a trace back from a detector gives the directions from which it
receives light.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from transport.theory.fresnel import transmittance

Heights = Callable[[np.ndarray], np.ndarray]


class Rays(NamedTuple):
    """Rays with the share of power that they carry.

    Parameters
    ----------
    points : ndarray
        Points on the rays, shape (..., 3) [m].
    directions : ndarray
        Unit directions, shape (..., 3) [1].
    carried : ndarray
        Share of the initial power that remains, shape (...) [1].
    """

    points: np.ndarray
    directions: np.ndarray
    carried: np.ndarray


def from_to(points: np.ndarray, targets: np.ndarray) -> Rays:
    """Rays from points through targets; shapes broadcast.

    Parameters
    ----------
    points : array_like
        Starting points, shape (..., 3) [m].
    targets : array_like
        Points that the rays pass, shape (..., 3) [m].

    Returns
    -------
    Rays
        Rays that carry their full power.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.optical_paths import from_to
    >>> print(from_to(np.zeros(3), np.array([0.0, 3.0, 4.0])).directions.round(4))
    [0.  0.6 0.8]
    """
    points, directions = np.broadcast_arrays(np.asarray(points, float), np.subtract(targets, points))
    lengths = np.linalg.norm(directions, axis=-1)
    return Rays(points, directions / lengths[..., None], np.ones(lengths.shape))


def between_disks(
    radius_1: float, height_1: float, radius_2: float, height_2: float | Heights, steps: int = 24
) -> Rays:
    """Rays from a coaxial disk to another: a grid over both disks, rims included.

    Parameters
    ----------
    radius_1 : float
        Radius of the first disk [m].
    height_1 : float
        Height z of the first disk [m].
    radius_2 : float
        Radius of the second disk [m].
    height_2 : float or callable
        Height z of the second disk; for a curved one, a function of the distance from the axis [m].
    steps : int, default 24
        Number of intervals of the grid over the second disk's radius.

    Returns
    -------
    Rays
        Rays, flat, shape (n, 3). By symmetry the points of the first disk on the +x axis are
        sufficient.

    Examples
    --------
    >>> from transport.theory.optical_paths import between_disks
    >>> between_disks(1.0, 0.0, 1.0, 2.0, steps=4).points.shape
    (50, 3)
    """
    r, rho = radius_1 * np.linspace(0, 1, steps // 4 + 1), radius_2 * np.linspace(0, 1, steps + 1)
    phi = np.pi * np.linspace(0, 1, steps + 1)
    r, rho, phi = (part.ravel() for part in np.meshgrid(r, rho, phi, indexing="ij"))
    above = height_2(rho) if callable(height_2) else np.full_like(rho, height_2)
    points = np.stack([r, 0 * r, np.full_like(r, height_1)], axis=-1)
    return from_to(points, np.stack([rho * np.cos(phi), rho * np.sin(phi), above], axis=-1))


def to_plane(rays: Rays, height: float) -> Rays:
    """Move rays to the plane z = height, forwards or backwards.

    Parameters
    ----------
    rays : Rays
        Incident rays.
    height : float
        Height z of the plane [m].

    Returns
    -------
    Rays
        Rays with points in the plane.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.optical_paths import from_to, to_plane
    >>> print(to_plane(from_to(np.zeros(3), np.array([0.0, 3.0, 4.0])), 2.0).points.round(4))
    [0.  1.5 2. ]
    """
    lengths = (height - rays.points[..., 2]) / rays.directions[..., 2]
    return rays._replace(points=rays.points + lengths[..., None] * rays.directions)


def reach_at(rays: Rays, height: float) -> float:
    """Largest distance of the rays from the axis in the plane z = height.

    Parameters
    ----------
    rays : Rays
        Incident rays.
    height : float
        Height z of the plane [m].

    Returns
    -------
    float
        Distance [m]; nan if a ray is nan.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.optical_paths import from_to, reach_at
    >>> print(f"{reach_at(from_to(np.zeros(3), np.array([0.0, 3.0, 4.0])), 2.0):.4g}")
    1.5
    """
    points = to_plane(rays, height).points
    return float(np.hypot(points[..., 0], points[..., 1]).max())


def refract(rays: Rays, center: float, radius: float, index: float, far: bool = False) -> Rays:
    """Refract rays at a sphere about (0, 0, center) by Snell's law, with Fresnel losses.

    Parameters
    ----------
    rays : Rays
        Incident rays.
    center : float
        Height z of the sphere's center [m].
    radius : float
        Radius of the sphere [m].
    index : float
        Index behind the surface over the index in front of it [1].
    far : bool, default False
        Whether the rays meet the sphere at the second intersection of the line.

    Returns
    -------
    Rays
        Refracted rays; nan where a ray misses the sphere or is totally reflected.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.optical_paths import from_to, refract
    >>> rays = from_to(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    >>> print(refract(rays, 2.0, 1.0, 1.5).carried.round(4))
    0.96
    """
    points, normals = _meet_sphere(rays, center, radius, far)
    cosines = np.einsum("...i,...i", rays.directions, normals)
    mu = np.abs(cosines)
    with np.errstate(invalid="ignore"):
        behind = np.sqrt(1 - (1 - mu) * (1 + mu) / index**2)
    along = np.sign(cosines) * (behind - mu / index)
    directions = rays.directions / index + along[..., None] * normals
    carried = rays.carried * transmittance(mu, index)
    return Rays(points, directions, np.where(np.isfinite(behind), carried, np.nan))


def reflect_in_sphere(rays: Rays, center: float, radius: float, far: bool = True) -> Rays:
    """Reflect rays at a perfect mirror on a sphere about (0, 0, center).

    Parameters
    ----------
    rays : Rays
        Incident rays.
    center : float
        Height z of the sphere's center [m].
    radius : float
        Radius of the sphere [m].
    far : bool, default True
        Whether the rays meet the sphere at the second intersection of the line, from inside.

    Returns
    -------
    Rays
        Reflected rays; nan where a ray misses the sphere.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.optical_paths import from_to, reflect_in_sphere
    >>> rays = from_to(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    >>> print(reflect_in_sphere(rays, 0.0, 1.0).directions.round(4))
    [ 0.  0. -1.]
    """
    return _reflect(rays, *_meet_sphere(rays, center, radius, far))


def reflect_in_paraboloid(rays: Rays, vertex: float, focal_length: float) -> Rays:
    """Reflect rays from inside at a perfect mirror on the paraboloid ``rho^2 = 4 f (z - vertex)``.

    Parameters
    ----------
    rays : Rays
        Incident rays.
    vertex : float
        Height z of the vertex [m].
    focal_length : float
        Focal length f [m].

    Returns
    -------
    Rays
        Reflected rays, at the intersection ahead.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.optical_paths import from_to, reflect_in_paraboloid
    >>> rays = from_to(np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 1.0]))
    >>> print(reflect_in_paraboloid(rays, 0.0, 1.0).directions.round(4))
    [0. 0. 1.]
    """
    start, directions = rays.points - [0, 0, vertex], rays.directions
    a = directions[..., 0] ** 2 + directions[..., 1] ** 2
    b = np.einsum("...i,...i", start[..., :2], directions[..., :2]) - 2 * focal_length * directions[..., 2]
    c = start[..., 0] ** 2 + start[..., 1] ** 2 - 4 * focal_length * start[..., 2]
    root = np.sqrt(b * b - a * c)  # c < 0 within
    with np.errstate(divide="ignore", invalid="ignore"):
        lengths = np.where(b > 0, -c / (b + root), (root - b) / a)
    points = rays.points + lengths[..., None] * directions
    slopes = np.stack(
        [points[..., 0], points[..., 1], np.full(points.shape[:-1], -2.0 * focal_length)], axis=-1
    )
    return _reflect(rays, points, slopes / np.linalg.norm(slopes, axis=-1, keepdims=True))


def bend(rays: Rays, height: float, focal_length: float) -> Rays:
    """Refract rays in an ideal thin lens in the plane z = height that changes direction cosines by -x/f.

    Parameters
    ----------
    rays : Rays
        Incident rays.
    height : float
        Height z of the lens [m].
    focal_length : float
        Focal length f [m].

    Returns
    -------
    Rays
        Rays behind the lens; nan where the new direction cosines would exceed 1.

    Notes
    -----
    Abbe's sine condition. The map's Jacobian in (p_x, p_y) is 1, so that étendue and radiance are
    conserved.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.optical_paths import bend, from_to
    >>> rays = from_to(np.array([0.1, 0.0, 0.0]), np.array([0.1, 0.0, 1.0]))
    >>> print(bend(rays, 1.0, 1.0).directions.round(4))
    [-0.1    0.     0.995]
    """
    points = to_plane(rays, height).points
    cosines = rays.directions[..., :2] - points[..., :2] / focal_length
    with np.errstate(invalid="ignore"):
        ahead = np.sqrt(1 - (cosines**2).sum(axis=-1)) * np.sign(rays.directions[..., 2])
    return rays._replace(points=points, directions=np.concatenate([cosines, ahead[..., None]], axis=-1))


def bend_tangents(rays: Rays, height: float, focal_length: float) -> Rays:
    """Refract rays in a thin lens that changes tangents by -x/f, which does not conserve étendue.

    Parameters
    ----------
    rays : Rays
        Incident rays.
    height : float
        Height z of the lens [m].
    focal_length : float
        Focal length f [m].

    Returns
    -------
    Rays
        Rays behind the lens; images are sharp at any angle.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.optical_paths import bend_tangents, from_to
    >>> rays = from_to(np.array([0.1, 0.0, 0.0]), np.array([0.1, 0.0, 1.0]))
    >>> print(bend_tangents(rays, 1.0, 1.0).directions.round(4))
    [-0.0995  0.      0.995 ]
    """
    points = to_plane(rays, height).points
    sign = np.sign(rays.directions[..., 2:])
    tangents = rays.directions[..., :2] / np.abs(rays.directions[..., 2:]) - points[..., :2] / focal_length
    directions = np.concatenate([tangents, sign], axis=-1)
    return rays._replace(
        points=points, directions=directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    )


def seen_through(
    back: Callable[[Rays], Rays],
    detector: float,
    window: float,
    height: float,
    theta: np.ndarray,
    steps: int = 16,
) -> np.ndarray:
    """Share of a uniform sky's radiance that a detector receives through an optic, by polar angle.

    Parameters
    ----------
    back : callable
        Function that traces Rays back through the optic.
    detector : float
        Radius of the detector, a disk about the origin [m].
    window : float
        Radius of the window, a coaxial disk in front of the optic [m].
    height : float
        Height z of the window [m].
    theta : ndarray
        Polar angles, shape (n,) [rad].
    steps : int, default 16
        Number of radii of the grid over the detector.

    Returns
    -------
    ndarray
        Mean share over the detector and azimuth, shape (n,) [1].

    Notes
    -----
    A sum over a grid, accurate enough for a picture: the rim is resolved to 1/steps.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.optical_paths import seen_through
    >>> print(seen_through(lambda rays: rays, 0.01, 0.1, 1.0, np.array([0.0, 0.2])).round(4))
    [1. 0.]
    """
    r = (detector * np.sqrt((np.arange(steps) + 0.5) / steps))[:, None]
    phi = np.pi * (np.arange(2 * steps) + 0.5) / (2 * steps)
    across = height * np.tan(np.reshape(theta, (-1, 1, 1)))
    x, y, zero = np.broadcast_arrays(r + across * np.cos(phi), across * np.sin(phi), 0.0)
    points = np.stack(np.broadcast_arrays(r, zero, zero), axis=-1)
    carried = back(from_to(points, np.stack([x, y, zero + height], axis=-1))).carried
    return np.where(np.hypot(x, y) < window, carried, 0.0).mean(axis=(1, 2))


def _meet_sphere(rays: Rays, center: float, radius: float, far: bool) -> tuple[np.ndarray, np.ndarray]:
    """Intersection of the line with the sphere, and the outward normal there."""
    start = rays.points - [0, 0, center]
    b = np.einsum("...i,...i", start, rays.directions)
    nearest = start - b[..., None] * rays.directions
    with np.errstate(invalid="ignore"):
        half = np.sqrt(radius**2 - (nearest**2).sum(axis=-1))
    from_center = nearest + (half if far else -half)[..., None] * rays.directions
    return from_center + [0, 0, center], from_center / radius


def _reflect(rays: Rays, points: np.ndarray, normals: np.ndarray) -> Rays:
    cosines = np.einsum("...i,...i", rays.directions, normals)
    return rays._replace(points=points, directions=rays.directions - 2 * cosines[..., None] * normals)
