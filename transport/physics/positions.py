"""Points uniform on flat shapes, from two uniforms, in coordinates (u, v) of the shape."""

import math

from transport.physics.device import device
from transport.physics.elementary import cos_sin_turn


@device
def sample_rectangle(half_u, half_v, p, q):
    """Return a point uniform on a rectangle of these half sides about the origin."""
    return (2.0 * p - 1.0) * half_u, (2.0 * q - 1.0) * half_v


@device
def sample_disk(inner2, outer2, p, turn):
    """Return a point uniform on a disk or annulus of these squared radii about the origin."""
    r = math.sqrt(inner2 + p * (outer2 - inner2))
    c, s = cos_sin_turn(turn)
    return r * c, r * s


@device
def sample_triangle(p, q):
    """Return the weights of the second and third vertex, for a point uniform on a triangle."""
    s = math.sqrt(p)
    return s * (1.0 - q), s * q


@device
def place_in_frame(table, u, v):
    """Return the point (u, v) of a local frame: c + u e_u + v e_v of the table."""
    x = table.cx + u * table.eux + v * table.evx
    y = table.cy + u * table.euy + v * table.evy
    return x, y, table.cz + u * table.euz + v * table.evz
