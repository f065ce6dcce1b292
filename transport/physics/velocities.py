"""Velocities: normal components, and speed and direction of what components make."""

import math

from transport.physics.device import device
from transport.physics.elementary import cos_sin_turn, log_positive


@device
def sample_normal_pair(u, turn):
    """Two independent standard normal numbers from two uniform ones (Box, Muller 1958)."""
    r = math.sqrt(-2.0 * log_positive(1.0 - u))
    c, s = cos_sin_turn(turn)
    return r * c, r * s


@device
def speed_and_direction(vx, vy, vz, ux, uy, uz):
    """The size of a velocity and its unit direction, which is u for what is at rest.

    In units of its largest component, so that squares of very slow or fast ones stay in range.
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
def state_at(x, y, z, ux, uy, uz, way, speed):
    """Place and velocity of free flight after a way along its direction."""
    return x + way * ux, y + way * uy, z + way * uz, speed * ux, speed * uy, speed * uz
