"""The oblique prism in front of a patch, which holds the particles that will cross it.

Source: Hanrahan 2001, Stanford CS 348B, lecture 4.
"""

from __future__ import annotations

import numpy as np


def in_oblique_prism(center, frame, sides, path, places) -> np.ndarray:
    """Whether points lie in the oblique prism on a rectangle, on either side of it.

    Parameters
    ----------
    center : array_like
        Center of the rectangle, shape (3,).
    frame : array_like
        Its unit vectors e_u, e_v and n, shape (3, 3).
    sides : sequence of 2 float
        Its side lengths along e_u and e_v.
    path : array_like
        v dt, the edge of the prism, shape (3,), or one per point, shape (N, 3).
    places : array_like
        Points, shape (N, 3). All lengths are in the same unit.

    Returns
    -------
    ndarray
        Booleans, shape (N,).

    Notes
    -----
    A point is x = p - s path with p on the rectangle and 0 < s <= 1: the particle is at p after s dt.
    If the path is parallel to the rectangle the prism has no volume and holds no point.

    Examples
    --------
    >>> from transport.theory.prisms import in_oblique_prism
    >>> frame = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    >>> points = [(0.0, 0.0, -0.5), (2.0, 0.0, -0.5)]
    >>> in_oblique_prism((0.0, 0.0, 0.0), frame, (1.0, 1.0), (0.0, 0.0, 1.0), points).tolist()
    [True, False]
    """
    e_u, e_v, normal = np.asarray(frame, dtype=float)
    offset, path = np.subtract(places, center), np.asarray(path, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = -(offset @ normal) / (path @ normal)
        foot = offset + s[:, None] * path
        u, v = np.abs(foot @ e_u), np.abs(foot @ e_v)
    return (u <= sides[0] / 2) & (v <= sides[1] / 2) & (0 < s) & (s <= 1)
