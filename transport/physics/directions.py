"""Directions on the unit sphere: sampling about an axis, rotation into the frame of a normal."""

import math

from transport.physics.device import choose, device
from transport.physics.elementary import cos_sin_turn


@device
def unit_and_length(x, y, z):
    """Return the unit vector along a vector, 0 for a vector of length 0, and its length."""
    r = math.sqrt(x * x + y * y + z * z)
    inverse = 1.0 / r if r > 0.0 else 0.0
    return x * inverse, y * inverse, z * inverse, r


@device
def from_frame(u, v, w, eux, euy, euz, evx, evy, evz, nx, ny, nz):
    """Return the vector with components (u, v, w) in a frame (e_u, e_v, n)."""
    return u * eux + v * evx + w * nx, u * euy + v * evy + w * ny, u * euz + v * evz + w * nz


@device
def turned_by(nx, ny, nz, mu, sine_cos, sine_sin):
    """Return the unit direction with components (sine_cos, sine_sin, mu) in a frame at n.

    Orthonormal frame without a branch or a singularity: Duff et al. (2017), "Building an orthonormal basis,
    revisited".
    """
    sign = 1.0 if nz >= 0.0 else -1.0
    a = -1.0 / (sign + nz)
    b = nx * ny * a
    return (
        (1.0 + sign * nx * nx * a) * sine_cos + b * sine_sin + nx * mu,
        sign * b * sine_cos + (sign + ny * ny * a) * sine_sin + ny * mu,
        -sign * nx * sine_cos - ny * sine_sin + nz * mu,
    )


@device
def sample_isotropic(u, turn):
    """Return a unit direction uniform over the sphere: dω / 4π, from two uniforms."""
    mu = 2.0 * u - 1.0
    s = 2.0 * math.sqrt(u * (1.0 - u))
    c, d = cos_sin_turn(turn)
    return s * c, s * d, mu


@device
def sample_cosine_law(nx, ny, nz, u, turn):
    """Return a unit direction about n with pdf cosθ/π (Lambert), and its cosine; never exactly grazing."""
    mu = math.sqrt(1.0 - u)
    s = math.sqrt(u)
    c, d = cos_sin_turn(turn)
    ux, uy, uz = turned_by(nx, ny, nz, mu, s * c, s * d)
    return ux, uy, uz, mu


@device
def select(this, ax, ay, az, bx, by, bz):
    """Return the first direction if `this`, else the second."""
    return choose(this, ax, bx), choose(this, ay, by), choose(this, az, bz)
