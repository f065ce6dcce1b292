"""Rays through optics about the z axis, one element after the other: exact traces, no small angles.

A ray is a point, a unit vector and the share of its power that has come so far.  Snell at spheres, with what Fresnel lets
through where light is unpolarised at every crossing; mirrors that are spheres or paraboloids; an ideal lens that maps
direction cosines, p' = p - x/f, and one that maps tangents, t' = t - x/f, as textbooks draw it.  Light's paths may be
followed either way, so that a trace back from a detector tells what it sees.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from transport.theory.fresnel import transmittance

Heights = Callable[[np.ndarray], np.ndarray]


class Rays(NamedTuple):
    """points [m] and unit directions (..., 3);  carried: share of the power that is left [1], (...)."""

    points: np.ndarray
    directions: np.ndarray
    carried: np.ndarray


def from_to(points: np.ndarray, targets: np.ndarray) -> Rays:
    """Rays from points through targets [m]; shapes broadcast."""
    points, way = np.broadcast_arrays(np.asarray(points, float), np.subtract(targets, points))
    lengths = np.linalg.norm(way, axis=-1)
    return Rays(points, way / lengths[..., None], np.ones(lengths.shape))


def between_disks(
    radius_1: float, height_1: float, radius_2: float, height_2: float | Heights, steps: int = 24
) -> Rays:
    """Rays from a coaxial disk to another, at these heights z [m]: a grid over both, rims included; flat (n, 3).

    By symmetry those from the first disk's points along +x are enough.  height_2: a number, or a function of the
    distance from the axis where the second is curved.
    """
    r, rho = radius_1 * np.linspace(0, 1, steps // 4 + 1), radius_2 * np.linspace(0, 1, steps + 1)
    phi = np.pi * np.linspace(0, 1, steps + 1)
    r, rho, phi = (part.ravel() for part in np.meshgrid(r, rho, phi, indexing="ij"))
    above = height_2(rho) if callable(height_2) else np.full_like(rho, height_2)
    points = np.stack([r, 0 * r, np.full_like(r, height_1)], axis=-1)
    return from_to(points, np.stack([rho * np.cos(phi), rho * np.sin(phi), above], axis=-1))


def to_plane(rays: Rays, height: float) -> Rays:
    """On to the plane z = height [m], wherever it is along the line."""
    lengths = (height - rays.points[..., 2]) / rays.directions[..., 2]
    return rays._replace(points=rays.points + lengths[..., None] * rays.directions)


def reach_at(rays: Rays, height: float) -> float:
    """How far from the axis the outermost of them are in the plane z = height [m]; nan where one is nowhere."""
    points = to_plane(rays, height).points
    return float(np.hypot(points[..., 0], points[..., 1]).max())


def refract(rays: Rays, center: float, radius: float, index: float, far: bool = False) -> Rays:
    """Through a sphere about (0, 0, center) [m] by Snell's law; nan where the ray misses it or is totally reflected.

    index: of what lies behind the surface over what lies before it;  far: at the second point of the line.
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
    """Off a sphere about (0, 0, center) [m], a perfect mirror; by default at the line's second point, from within."""
    return _reflect(rays, *_meet_sphere(rays, center, radius, far))


def reflect_in_paraboloid(rays: Rays, vertex: float, focal_length: float) -> Rays:
    """Off the paraboloid rho^2 = 4 f (z - vertex) [m] from within, a perfect mirror, at the point further on."""
    start, way = rays.points - [0, 0, vertex], rays.directions
    a = way[..., 0] ** 2 + way[..., 1] ** 2
    b = np.einsum("...i,...i", start[..., :2], way[..., :2]) - 2 * focal_length * way[..., 2]
    c = start[..., 0] ** 2 + start[..., 1] ** 2 - 4 * focal_length * start[..., 2]
    root = np.sqrt(b * b - a * c)  # c < 0 within
    with np.errstate(divide="ignore", invalid="ignore"):
        lengths = np.where(b > 0, -c / (b + root), (root - b) / a)
    points = rays.points + lengths[..., None] * way
    slopes = np.stack(
        [points[..., 0], points[..., 1], np.full(points.shape[:-1], -2.0 * focal_length)], axis=-1
    )
    return _reflect(rays, points, slopes / np.linalg.norm(slopes, axis=-1, keepdims=True))


def bend(rays: Rays, height: float, focal_length: float) -> Rays:
    """Through an ideal lens in the plane z = height [m]: direction cosines change by -x/f (Abbe's sine condition).

    The map's Jacobian in (p_x, p_y) is 1, so that étendue and radiance are conserved; nan where |p'| > 1.
    """
    points = to_plane(rays, height).points
    cosines = rays.directions[..., :2] - points[..., :2] / focal_length
    with np.errstate(invalid="ignore"):
        ahead = np.sqrt(1 - (cosines**2).sum(axis=-1)) * np.sign(rays.directions[..., 2])
    return rays._replace(points=points, directions=np.concatenate([cosines, ahead[..., None]], axis=-1))


def bend_tangents(rays: Rays, height: float, focal_length: float) -> Rays:
    """Through a lens that changes tangents by -x/f: sharp images from any angle, but étendue is not conserved."""
    points = to_plane(rays, height).points
    sign = np.sign(rays.directions[..., 2:])
    tangents = rays.directions[..., :2] / np.abs(rays.directions[..., 2:]) - points[..., :2] / focal_length
    ways = np.concatenate([tangents, sign], axis=-1)
    return rays._replace(points=points, directions=ways / np.linalg.norm(ways, axis=-1, keepdims=True))


def seen_through(
    back: Callable[[Rays], Rays],
    detector: float,
    window: float,
    height: float,
    theta: np.ndarray,
    steps: int = 16,
) -> np.ndarray:
    """Share of a wide sky's radiance that a detector receives from polar angles theta [rad] by an optic, (n,); its mean.

    back: traces rays through the optic;  detector, window, height: radii of a disk about the origin and of the one that it
    looks through, and that one's distance [m].  A sum over a grid, good for a picture: a rim is met to 1/steps.
    """
    r = (detector * np.sqrt((np.arange(steps) + 0.5) / steps))[:, None]
    phi = np.pi * (np.arange(2 * steps) + 0.5) / (2 * steps)
    across = height * np.tan(np.reshape(theta, (-1, 1, 1)))
    x, y, zero = np.broadcast_arrays(r + across * np.cos(phi), across * np.sin(phi), 0.0)
    points = np.stack(np.broadcast_arrays(r, zero, zero), axis=-1)
    carried = back(from_to(points, np.stack([x, y, zero + height], axis=-1))).carried
    return np.where(np.hypot(x, y) < window, carried, 0.0).mean(axis=(1, 2))


def _meet_sphere(rays: Rays, center: float, radius: float, far: bool) -> tuple[np.ndarray, np.ndarray]:
    """The point where the line meets the sphere, and its outward normal."""
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
