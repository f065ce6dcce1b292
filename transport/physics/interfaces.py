"""What a surface does to a direction: mirror reflection (diffuse reflection is `sample_cosine_law`)."""

from transport.physics.device import device


@device
def mirrored(ux, uy, uz, nx, ny, nz, mu):
    """Direction after specular reflection at normal n, mu = u·n; one Newton step keeps long chains unit."""
    vx, vy, vz = ux - 2.0 * mu * nx, uy - 2.0 * mu * ny, uz - 2.0 * mu * nz
    s = 1.5 - 0.5 * (vx * vx + vy * vy + vz * vz)
    return vx * s, vy * s, vz * s
