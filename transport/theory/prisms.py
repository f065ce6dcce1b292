"""The oblique prism before a patch: who starts in it crosses the patch (Hanrahan 2001, Stanford CS 348B, lecture 4)."""

from __future__ import annotations

import numpy as np


def in_oblique_prism(center, frame, sides, path, places) -> np.ndarray:
    """Which places lie in the oblique prism on a rectangle, on either side of it: bool, (N,).

    center: of the rectangle;  frame: its unit vectors e_u, e_v and n;  sides: its lengths along e_u and e_v;
    path: v dt, the prism's edge, one for all or one a place, (N, 3);  places: (N, 3), all in one unit of length.
    A place is x = p - s path with p on the rectangle and 0 < s <= 1: the particle is at p after s dt.  Along the
    rectangle the prism has no volume, and nobody is in it.
    """
    e_u, e_v, normal = np.asarray(frame, dtype=float)
    offset, path = np.subtract(places, center), np.asarray(path, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = -(offset @ normal) / (path @ normal)
        foot = offset + s[:, None] * path
        u, v = np.abs(foot @ e_u), np.abs(foot @ e_v)
    return (u <= sides[0] / 2) & (v <= sides[1] / 2) & (0 < s) & (s <= 1)
