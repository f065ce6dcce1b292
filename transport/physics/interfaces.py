"""What a smooth surface does to a direction: mirror reflection, refraction (diffuse reflection is `sample_cosine_law`)."""

import math

from transport.physics.device import device


@device
def renewed(vx, vy, vz):
    """A direction of unit length to rounding, made unit to the last digit: one Newton step keeps long chains unit."""
    s = 1.5 - 0.5 * (vx * vx + vy * vy + vz * vz)
    return vx * s, vy * s, vz * s


@device
def mirrored(ux, uy, uz, nx, ny, nz, mu):
    """Direction after specular reflection at normal n, mu = u·n."""
    return renewed(ux - 2.0 * mu * nx, uy - 2.0 * mu * ny, uz - 2.0 * mu * nz)


@device
def fresnel(cosine, ratio, excess):
    """Reflectance for unpolarised light, and ratio times the cosine of refraction (0 under total reflection).

    cosine > 0: of incidence;  ratio: index behind over index before;  excess: (ratio - 1)(ratio + 1), from indices, lest it
    cancel.  The differences of Fresnel's formulas (Born and Wolf 1999, 1.5.2) are written as products with `excess`, so that
    nothing cancels for indices that are nearly alike.
    """
    g2 = excess + cosine * cosine
    g = math.sqrt(g2 if g2 > 0.0 else 0.0)
    total = cosine + g
    s = excess / (total * total)
    p = excess * (cosine * total - 1.0) / (total * (ratio * ratio * cosine + g))
    return 0.5 * (s * s + p * p) if g2 > 0.0 else 1.0, g


@device
def refracted(ux, uy, uz, nx, ny, nz, cosine, ratio, excess, g):
    """Direction behind the surface by Snell's law; n points against u, u·n = -cosine; g as of `fresnel`."""
    along = -excess / (cosine + g)  # cosine - g
    inverse = 1.0 / ratio
    return renewed((ux + along * nx) * inverse, (uy + along * ny) * inverse, (uz + along * nz) * inverse)


@device
def bent_by_lens(ux, uy, uz, nx, ny, nz, mu, kx, ky, kz):
    """Direction behind an ideal thin lens, and its cosine: the components along the lens change by -k; where there is
    none, back along the ray.

    k = x/f lies in the plane of the lens.  The Jacobian of the change of direction cosines is 1: étendue is conserved.
    """
    px, py, pz = ux - mu * nx - kx, uy - mu * ny - ky, uz - mu * nz - kz
    left = 1.0 - (px * px + py * py + pz * pz)
    cosine = math.copysign(math.sqrt(left if left > 0.0 else 0.0), mu)
    vx, vy, vz = renewed(px + cosine * nx, py + cosine * ny, pz + cosine * nz)
    passes = left > 0.0
    return vx if passes else -ux, vy if passes else -uy, vz if passes else -uz, cosine if passes else -mu
