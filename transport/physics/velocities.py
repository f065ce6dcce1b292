"""Velocities: normal components, and speed and direction from components."""

import math

from transport.physics.device import device
from transport.physics.elementary import cos_sin_turn, log_positive


@device
def sample_normal_pair(u, turn):
    """Return two independent standard normal numbers from two uniforms (Box, Muller 1958)."""
    r = math.sqrt(-2.0 * log_positive(1.0 - u))
    c, s = cos_sin_turn(turn)
    return r * c, r * s


@device
def speed_and_direction(vx, vy, vz, ux, uy, uz):
    """Return the magnitude of a velocity and its unit direction; at rest the direction is u.

    Computed in units of its largest component, so that squares of very slow or fast velocities stay in range.
    """
    largest = max(abs(vx), max(abs(vy), abs(vz)))
    moves = largest > 0.0
    scale = 1.0 / largest if moves else 0.0
    sx, sy, sz = vx * scale, vy * scale, vz * scale
    length = math.sqrt(sx * sx + sy * sy + sz * sz)
    inverse = 1.0 / length if moves else 0.0
    return (
        largest * length,
        sx * inverse if moves else ux,
        sy * inverse if moves else uy,
        sz * inverse if moves else uz,
    )


@device
def state_at(x, y, z, ux, uy, uz, length, speed):
    """Return position and velocity after a free flight of this length along the direction."""
    return x + length * ux, y + length * uy, z + length * uz, speed * ux, speed * uy, speed * uz
