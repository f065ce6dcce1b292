"""Direct light through voxels: optical depths along lines, and exact means of exp(-τ) in the shadow.

A line crosses the planes between voxels at known positions, and within a voxel τ grows linearly
(Amanatides and Woo 1987, Eurographics 87, 3), so that τ is a finite sum. If parallel light is tilted
along x only, τ as a function of the position x on the ground is linear between the shadows of the
voxels' edges, and the mean of exp(-τ) over each piece is elementary.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

RAYS = 20_000  # rays per chunk


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
    >>> from transport.theory.voxels import optical_depths
    >>> voxels = np.ones((2, 2, 2))
    >>> print(optical_depths(voxels, (0, 0, 0), (1, 1, 1), [(0.5, 0.5, -1.0)], (0, 0, 1)).round(4))
    [1.]
    """
    starts, direction = np.atleast_2d(np.asarray(starts, float)), np.asarray(direction, float)
    direction = direction / np.linalg.norm(direction)
    found = [
        _depths(extinction, low, high, starts[k : k + RAYS], direction) for k in range(0, len(starts), RAYS)
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
    >>> from transport.theory.voxels import shadow_means
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
