"""Directions on the unit sphere: sampling about an axis, rotation into the frame of a normal."""

import math

from transport.physics.device import device
from transport.physics.elementary import cos_sin_turn


@device
def turned(nx, ny, nz, mu, turn):
    """Return the unit direction at cosine mu and azimuth 2 pi turn about the unit vector n.

    Orthonormal frame without a branch or a singularity: Duff et al. (2017), "Building an orthonormal basis,
    revisited".
    """
    s2 = 1.0 - mu * mu
    s = math.sqrt(s2 if s2 > 0.0 else 0.0)
    c, d = cos_sin_turn(turn)
    return turned_by(nx, ny, nz, mu, s * c, s * d)


@device
def turned_by(nx, ny, nz, mu, sine_cos, sine_sin):
    """Return the unit direction with components (sine_cos, sine_sin, mu) in the frame of Duff et al. at n."""
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
    return ax if this else bx, ay if this else by, az if this else bz
