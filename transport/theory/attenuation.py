"""Attenuation: the light that has been neither absorbed nor scattered along its path through a medium.

Along a ray radiance falls as exp(-tau), tau the integral of the extinction along it (Bouguer 1729; Beer
1852): the rest is light that never collided. All functions here integrate exp(-tau) over directions.
tau is the optical depth along the normal and mu the cosine to the normal, so that the optical depth of
a slanted ray is tau/mu. Integrals over directions are exponential integrals, E_n(tau) = ∫ mu^(n-2)
exp(-tau/mu) dmu over mu from 0 to 1 (Chandrasekhar 1960, appendix I).

Radiance L in W m^-2 sr^-1, lengths in m, extinction in m^-1. In a purely absorbing medium the values
hold for all light; in a scattering medium, for the uncollided part.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from transport.statistics.quadrature import legendre_nodes

_NODES, _WEIGHTS = legendre_nodes(64)
_SERIES = 40  # terms of the series: the last is below 1e-40 of the first


def transmittance(tau: float) -> float:
    """Share of a beam that passes an optical depth without collision.

    Parameters
    ----------
    tau : float or ndarray
        Optical depth along the normal, at least 0 [1].

    Returns
    -------
    float or ndarray
        ``exp(-tau)`` [1].

    Notes
    -----
    Source: Bouguer 1729; Beer 1852.

    Examples
    --------
    >>> from transport.theory.attenuation import transmittance
    >>> print(f"{transmittance(1.0):.4g}")
    0.3679
    """
    return np.exp(-np.asarray(tau, dtype=float))[()]


def exponential_integral(order: int, tau: float) -> float:
    """Exponential integral E_n(tau).

    Parameters
    ----------
    order : int
        n, at least 0.
    tau : float or ndarray
        Optical depth along the normal, at least 0 [1].

    Returns
    -------
    float or ndarray
        ``∫ exp(-tau t) / t^n dt`` over t from 1 to infinity [1].

    Notes
    -----
    Source: DLMF 8.19.3.

    Examples
    --------
    >>> from transport.theory.attenuation import exponential_integral
    >>> print(f"{exponential_integral(3, 1.0):.4g}")
    0.1097
    """
    from scipy.special import expn

    return expn(order, tau)


def lambertian_transmission(tau: float) -> float:
    """Share of Lambertian light that passes a slab without collision.

    Parameters
    ----------
    tau : float or ndarray
        Optical depth along the normal, at least 0 [1].

    Returns
    -------
    float or ndarray
        ``2 E3(tau)`` [1].

    Examples
    --------
    >>> from transport.theory.attenuation import lambertian_transmission
    >>> print(f"{lambertian_transmission(1.0):.4g}")
    0.2194
    """
    return 2 * exponential_integral(3, tau)


def slab_escape(tau: float) -> float:
    """Share of a slab's uniform isotropic emission that leaves it uncollided through either face.

    Parameters
    ----------
    tau : float or ndarray
        Optical thickness of the slab, above 0 [1].

    Returns
    -------
    float or ndarray
        Escape probability [1].

    Notes
    -----
    ``(1 - 2 E3(tau)) / (2 tau)``, computed as ``(E2(tau) + (1 - exp(-tau))/tau) / 2``, which does not
    cancel: the integral of E2 over the depth (Case, de Hoffmann, Placzek 1953, 10).

    Examples
    --------
    >>> from transport.theory.attenuation import slab_escape
    >>> print(f"{slab_escape(1.0):.4g}")
    0.3903
    """
    tau = np.asarray(tau, dtype=float)
    return ((exponential_integral(2, tau) - np.expm1(-tau) / tau) / 2)[()]


def sphere_escape(radii: float) -> float:
    """Share of a ball's uniform isotropic emission that leaves it uncollided.

    Parameters
    ----------
    radii : float or ndarray
        Optical radius x of the ball, radius times extinction, above 0 [1].

    Returns
    -------
    float or ndarray
        Escape probability [1].

    Notes
    -----
    ``3/(8 x^3) [2 x^2 - 1 + (1 + 2 x) exp(-2 x)]`` (Case, de Hoffmann, Placzek 1953, 10); a power
    series below x = 1.

    Examples
    --------
    >>> from transport.theory.attenuation import sphere_escape
    >>> print(f"{sphere_escape(1.0):.4g}")
    0.5273
    """
    x = np.asarray(radii, dtype=float)
    y = 2 * np.maximum(x, 1.0)
    closed = 3 / y**3 * (y * y / 2 - 1 + (1 + y) * np.exp(-y))
    y, terms = 2 * np.minimum(x, 1.0), np.zeros_like(x)
    for k in range(_SERIES, 2, -1):
        terms = (-1) ** (k + 1) * (k - 1) / math.factorial(k) + y * terms
    return np.where(x < 1, 3 * terms, closed)[()]


def mean_slant_transmittance(tau: float, low: float, high: float) -> float:
    """Mean of ``exp(-tau/mu)`` over a bin of cosines, weighted by mu: the transmittance of a radiance bin.

    Parameters
    ----------
    tau : float or ndarray
        Optical depth along the normal, at least 0 [1].
    low : float or ndarray
        Lower cosine of the bin, at least 0 [1].
    high : float or ndarray
        Upper cosine of the bin, above `low`, at most 1 [1].

    Returns
    -------
    float or ndarray
        ``2 ∫ mu exp(-tau/mu) dmu / (high^2 - low^2)`` [1].

    Examples
    --------
    >>> from transport.theory.attenuation import mean_slant_transmittance
    >>> print(f"{mean_slant_transmittance(1.0, 0.5, 1.0):.4g}")
    0.2724
    """
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    return (2 * slant_integral(tau, low, high) / ((high - low) * (high + low)))[()]


def slant_integral(tau: float, low: float, high: float) -> float:
    """Integral ``∫ mu exp(-tau/mu) dmu`` from low to high.

    Parameters
    ----------
    tau : float or ndarray
        Optical depth along the normal, at least 0 [1].
    low : float or ndarray
        Lower cosine, at least 0 [1].
    high : float or ndarray
        Upper cosine, at least `low`, at most 1 [1].

    Returns
    -------
    float or ndarray
        The integral [1]; E3(tau) over all cosines.

    Notes
    -----
    ``high^2 E3(tau/high) - low^2 E3(tau/low)``, or quadrature where this difference would cancel.

    Examples
    --------
    >>> from transport.theory.attenuation import slant_integral
    >>> print(f"{slant_integral(1.0, 0.0, 1.0):.4g}")
    0.1097
    """
    tau, low, high = (np.asarray(x, dtype=float) for x in (tau, low, high))
    wide = low < high / 2
    bottom = np.where(low > 0, low, 1.0)
    far = np.where(low > 0, low**2 * exponential_integral(3, tau / bottom), 0.0)
    closed = high**2 * exponential_integral(3, tau / high) - far
    start = np.where(wide, high / 2, low)
    mu = start[..., None] + (high - start)[..., None] * (1 + _NODES) / 2
    summed = (mu * np.exp(-tau[..., None] / mu)) @ _WEIGHTS * (high - start) / 2
    return np.where(wide, closed, summed)[()]


def disk_irradiance(
    radiance: float, radius: float, distance: float, tau: float, detector_radius: float = 0.0
) -> float:
    """Mean irradiance by a Lambert disk on a coaxial parallel detector through an absorbing layer.

    Parameters
    ----------
    radiance : float
        Radiance of the disk [W m^-2 sr^-1].
    radius : float
        Radius of the emitting disk [m].
    distance : float
        Distance between the planes of disk and detector [m].
    tau : float
        Optical depth of the layer between the two planes along the normal [1].
    meter : float, default 0.0
        Radius of the detector [m]; 0: the point on the axis.

    Returns
    -------
    float
        Irradiance, averaged over the detector [W m^-2].

    Notes
    -----
    On the axis ``2 pi L ∫ mu exp(-tau/mu) dmu`` over the disk. Over a detector, the number of pairs of
    points with the lateral offset s is proportional to the overlap area of two disks shifted by s
    (autocorrelation), which leaves one integral.

    Examples
    --------
    >>> from transport.theory.attenuation import disk_irradiance
    >>> print(f"{disk_irradiance(1.0, 1.0, 2.0, 0.5):.4g}")
    0.3707
    """
    small, large = sorted((radius, detector_radius))
    if small == 0:
        return 2 * math.pi * radiance * slant_integral(tau, distance / math.hypot(distance, large), 1.0)
    whole = slant_integral(tau, distance / math.hypot(distance, large - small), 1.0)
    angle = math.pi * (1 + _NODES) / 2
    shift = large - small * np.cos(angle)
    slant = np.hypot(distance, shift)
    parts = _overlap(large, small, shift) / (math.pi * small**2) * shift * small * np.sin(angle)
    rim = parts * (distance / slant**2) ** 2 * np.exp(-tau * slant / distance) @ _WEIGHTS * math.pi / 2
    return 2 * math.pi * radiance * float(whole + rim) * (small / detector_radius) ** 2


def disk_radiance(
    theta: float, radiance: float, radius: float, distance: float, tau: float, detector_radius: float
) -> np.ndarray:
    """Mean radiance from a Lambert disk, through an absorbing layer, over a coaxial detector.

    Parameters
    ----------
    theta : float or ndarray
        Polar angles, from 0 to below pi/2 [rad].
    radiance : float
        Radiance of the disk [W m^-2 sr^-1].
    radius : float
        Radius of the emitting disk [m].
    distance : float
        Distance between the planes of disk and detector [m].
    tau : float
        Optical depth of the layer along the normal [1].
    meter : float
        Radius of the detector, above 0 [m].

    Returns
    -------
    float or ndarray
        Mean radiance, shape of `theta` [W m^-2 sr^-1].

    Notes
    -----
    ``L exp(-tau/cosθ)`` as long as all of the detector sees the disk at this angle; then it falls to 0
    with the overlap of disk and detector, projected along the ray.

    Examples
    --------
    >>> from transport.theory.attenuation import disk_radiance
    >>> print(f"{disk_radiance(0.1, 1.0, 1.0, 1.0, 0.5, 0.5):.4g}")
    0.605
    """
    theta = np.asarray(theta, dtype=float)
    shift, (small, large) = distance * np.tan(theta), sorted((radius, detector_radius))
    partly = (shift > large - small) & (shift < large + small)
    rim = _overlap(large, small, np.where(partly, shift, large))
    area = np.where(partly, rim, np.where(shift < large, math.pi * small**2, 0.0))
    return radiance * np.exp(-tau / np.cos(theta)) * area / (math.pi * detector_radius**2)


def _overlap(large: float, small: float, shift: np.ndarray) -> np.ndarray:
    """Overlap area of two disks whose centers are `shift` apart: two segments on the common chord."""
    sides = (shift + large + small, small + shift - large, shift - small + large, large + small - shift)
    chord = np.sqrt(np.maximum(math.prod(sides), 0.0)) / (2 * shift)  # half the chord, by Heron's formula
    area = 0.0
    for own, other in ((large, small), (small, large)):
        # Distance of the chord from the center; negative if the center lies inside the segment.
        foot = (shift * shift + (own - other) * (own + other)) / (2 * shift)
        area = area + own**2 * np.arctan2(chord, foot) - chord * foot
    return area


def cone_transmittance(tau: float, zenith_angle: float, half_angle: float) -> float:
    """Mean of ``exp(-tau/cosθ)`` over a narrow cone of directions, weighted by the cosine to the cone's axis.

    Parameters
    ----------
    tau : float
        Optical depth from the ground to the zenith [1].
    zenith_angle : float
        Zenith angle of the cone's axis [rad].
    half_angle : float
        Half angle of the cone, below pi/2 [rad].

    Returns
    -------
    float
        Mean transmittance [1].

    Notes
    -----
    For the sun through a flat atmosphere: ``exp(-tau secθ)`` (Bouguer 1729), averaged over the sun's
    disk.

    Examples
    --------
    >>> from transport.theory.attenuation import cone_transmittance
    >>> print(f"{cone_transmittance(0.3, 1.0, 0.00465):.4g}")
    0.5739
    """
    inner = np.cos(half_angle) + (1 - np.cos(half_angle)) * (1 + _NODES) / 2
    azimuth = (np.arange(32) + 0.5) * math.pi / 32
    across = np.sqrt((1 - inner) * (1 + inner))[:, None] * np.cos(azimuth)
    cosine = inner[:, None] * math.cos(zenith_angle) + across * math.sin(zenith_angle)
    weights = inner * _WEIGHTS
    return float(weights @ np.exp(-tau / cosine).mean(axis=1) / weights.sum())


def ball_transmittance(diameters: float, low: float = 0.0, high: float = 1.0) -> float:
    """Transmittance across a ball from its wall: mean of ``exp(-x mu)`` over cosines, weighted by mu.

    Parameters
    ----------
    diameters : float
        Optical diameter x of the ball, diameter times extinction [1].
    low : float or ndarray, default 0.0
        Lower cosine of the bin to the wall's normal [1].
    high : float or ndarray, default 1.0
        Upper cosine of the bin [1].

    Returns
    -------
    float or ndarray
        Mean transmittance [1].

    Notes
    -----
    A chord at the cosine mu to the normal is mu diameters long. Over all cosines the mean is
    ``2 (1 - (1 + x) exp(-x)) / x^2``.

    Examples
    --------
    >>> from transport.theory.attenuation import ball_transmittance
    >>> print(f"{ball_transmittance(1.0):.4g}")
    0.5285
    """
    low, high = (np.asarray(x, dtype=float)[..., None] for x in (low, high))
    mu = low + (high - low) * (1 + _NODES) / 2
    weights = mu * _WEIGHTS
    return ((weights * np.exp(-diameters * mu)).sum(axis=-1) / weights.sum(axis=-1))[()]


# ---- Direct light through voxels: optical depths along lines, and exact means of exp(-τ) in the shadow.
#
# A line crosses the planes between voxels at known positions, and within a voxel τ grows linearly
# (Amanatides and Woo 1987, Eurographics 87, 3), so that τ is a finite sum. If parallel light is tilted
# along x only, τ as a function of the position x on the ground is linear between the shadows of the
# voxels' edges, and the mean of exp(-τ) over each piece is elementary.

RAYS_PER_CHUNK = 20_000  # rays per chunk


def optical_depths(
    extinction: np.ndarray,
    low: Sequence[float],
    high: Sequence[float],
    starts: np.ndarray,
    direction: Sequence[float],
) -> np.ndarray:
    """Optical depths from points to infinity along one direction, through voxels that fill a box.

    Parameters
    ----------
    extinction : ndarray
        Extinction coefficients of the voxels, shape (nx, ny, nz) [m^-1].
    low : sequence of float
        Lower corner of the box of voxels, shape (3,) [m].
    high : sequence of float
        Upper corner of the box of voxels, shape (3,) [m].
    starts : array_like
        Starting points, shape (n, 3) [m].
    direction : sequence of float
        Direction, of any length, shape (3,).

    Returns
    -------
    ndarray
        ``∫ σ ds``, shape (n,) [1].

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.attenuation import optical_depths
    >>> voxels = np.ones((2, 2, 2))
    >>> print(optical_depths(voxels, (0, 0, 0), (1, 1, 1), [(0.5, 0.5, -1.0)], (0, 0, 1)).round(4))
    [1.]
    """
    starts, direction = np.atleast_2d(np.asarray(starts, float)), np.asarray(direction, float)
    direction = direction / np.linalg.norm(direction)
    found = [
        _depths(extinction, low, high, starts[k : k + RAYS_PER_CHUNK], direction)
        for k in range(0, len(starts), RAYS_PER_CHUNK)
    ]
    return np.concatenate(found)


def shadow_means(
    extinction: np.ndarray,
    low: Sequence[float],
    high: Sequence[float],
    tangent: float,
    edges: np.ndarray,
) -> np.ndarray:
    """Means of exp(-τ) over bins on the plane z = 0 below voxels in parallel light.

    Parameters
    ----------
    extinction : ndarray
        Extinction coefficients of the voxels, shape (nx, ny, nz) [m^-1].
    low : sequence of float
        Lower corner of the box of voxels, shape (3,) [m].
    high : sequence of float
        Upper corner of the box of voxels, shape (3,) [m].
    tangent : float
        Shift of the light along +x per unit of descent [1].
    edges : ndarray
        Edges of the bins along x, increasing, shape (bins + 1,) [m]; along y a bin is as wide as a
        voxel.

    Returns
    -------
    ndarray
        Means, shape (bins, ny) [1]. The box must lie above the plane.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.attenuation import shadow_means
    >>> print(shadow_means(np.ones((2, 2, 2)), (0, 0, 1), (1, 1, 2), 0.0, np.array([0.0, 1.0])).round(4))
    [[0.3679 0.3679]]
    """
    nx, _, nz = extinction.shape
    x, z = np.linspace(low[0], high[0], nx + 1), np.linspace(low[2], high[2], nz + 1)
    corners = (x[:, None] + tangent * z).ravel()
    cuts = np.union1d(edges, corners[(corners > edges[0]) & (corners < edges[-1])])
    widths = np.diff(cuts)
    quarter, rest = (
        _columns(extinction, x, z, tangent, cuts[:-1] + share * widths) for share in (0.25, 0.75)
    )
    first, last = 1.5 * quarter - 0.5 * rest, 1.5 * rest - 0.5 * quarter  # extrapolated
    sums = np.add.reduceat(
        _mean_exponential(first, last) * widths[:, None], np.searchsorted(cuts, edges[:-1])
    )
    return sums / np.diff(edges)[:, None]


def _depths(extinction, low, high, starts, direction) -> np.ndarray:
    """Sum over the pieces between crossed planes: length times extinction of the voxel at its middle."""
    low, high, counts = np.asarray(low, float), np.asarray(high, float), np.array(extinction.shape)
    crossings = [np.zeros((len(starts), 1))]
    for axis in range(3):
        if direction[axis] != 0:
            planes = np.linspace(low[axis], high[axis], counts[axis] + 1)
            crossings.append((planes - starts[:, axis, None]) / direction[axis])
    t = np.sort(np.maximum(np.concatenate(crossings, axis=1), 0.0), axis=1)
    lengths, total = np.diff(t, axis=1), np.zeros(len(starts))
    for k in range(lengths.shape[1]):
        middle = starts + ((t[:, k] + t[:, k + 1]) / 2)[:, None] * direction
        place = (middle - low) / (high - low)
        held = ((place > 0) & (place < 1)).all(axis=1)
        index = np.minimum((place[held] * counts).astype(int), counts - 1)
        total[held] += lengths[held, k] * extinction[tuple(index.T)]
    return total


def _columns(extinction, x, z, tangent, places) -> np.ndarray:
    """τ of the lines that end at these positions (n,) on the ground, for each row of voxels, (n, ny)."""
    heights = [np.broadcast_to(z, (len(places), len(z)))]
    if tangent != 0:
        heights.append(((places[:, None] - x) / tangent).clip(z[0], z[-1]))
    heights = np.sort(np.concatenate(heights, axis=1), axis=1)
    lengths = np.diff(heights, axis=1) * np.hypot(1, tangent)
    middles = (heights[:, 1:] + heights[:, :-1]) / 2
    across = (places[:, None] - tangent * middles - x[0]) / (x[-1] - x[0])
    held = (across > 0) & (across < 1) & (lengths > 0)
    i = np.minimum((across.clip(0, 1) * (len(x) - 1)).astype(int), len(x) - 2)
    k = np.minimum(((middles - z[0]) / (z[-1] - z[0]) * (len(z) - 1)).astype(int), len(z) - 2)
    total = np.zeros((len(places), extinction.shape[1]))
    for step in range(lengths.shape[1]):
        rows = np.flatnonzero(held[:, step])
        total[rows] += lengths[rows, step, None] * extinction[i[rows, step], :, k[rows, step]]
    return total


def _mean_exponential(first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Mean of exp(-τ) where τ varies linearly from first to last: exp(-first) (1 - exp(-d))/d."""
    change = last - first
    safe = np.where(change == 0, 1.0, change)
    return np.exp(-first) * np.where(change == 0, 1.0, -np.expm1(-safe) / safe)
