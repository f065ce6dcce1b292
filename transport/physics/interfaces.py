"""Smooth surfaces: mirror reflection, Fresnel reflectance, refraction, thin lens.

Diffuse reflection is `directions.sample_cosine_law`.
"""

import math

from transport.physics.device import device


@device
def renormalized(vx, vy, vz):
    """Return a direction renormalised to unit length by one Newton step.

    Its length is 1 to rounding; the step keeps long chains of events unit to the last digit.
    """
    s = 1.5 - 0.5 * (vx * vx + vy * vy + vz * vz)
    return vx * s, vy * s, vz * s


@device
def reflected(ux, uy, uz, nx, ny, nz, mu):
    """Return the direction after specular reflection at normal n; mu = u·n."""
    return renormalized(ux - 2.0 * mu * nx, uy - 2.0 * mu * ny, uz - 2.0 * mu * nz)


@device
def fresnel(cosine, ratio, excess):
    """Return the reflectance for unpolarised light, and ratio * cosine of refraction.

    The latter is 0 under total internal reflection. cosine > 0: of incidence. ratio: index behind over index
    before. excess: (ratio - 1)(ratio + 1), computed from the indices without cancellation. The differences in
    Fresnel's formulas (Born and Wolf 1999, 1.5.2) are written as products with `excess`, so nothing cancels
    for nearly equal indices.
    """
    g2 = excess + cosine * cosine
    g = math.sqrt(g2 if g2 > 0.0 else 0.0)
    total = cosine + g
    s = excess / (total * total)
    p = excess * (cosine * total - 1.0) / (total * (ratio * ratio * cosine + g))
    return 0.5 * (s * s + p * p) if g2 > 0.0 else 1.0, g


@device
def metallic_reflectance(cosine, excess, loss):
    """Return the reflectance of a metal for unpolarised light.

    cosine > 0: of incidence. excess + 1 + i loss: square of the index relative to the medium in front, loss
    > 0. With the root p + iq of excess + cosine^2 + i loss, both reflectances are ratios of sums of squares
    (Born and Wolf 1999, 14.2). The difference p - cosine, which cancels for an index near 1, is then a
    quotient.
    """
    real = excess + cosine * cosine
    larger = math.sqrt(0.5 * (math.sqrt(real * real + loss * loss) + abs(real)))
    smaller = 0.5 * loss / larger
    p, q = larger if real > 0.0 else smaller, smaller if real > 0.0 else larger
    total = cosine + p
    gap = (excess + q * q) / total if real > 0.0 else p - cosine
    s = (gap * gap + q * q) / (total * total + q * q)
    sine2 = (1.0 - cosine) * (1.0 + cosine)
    minus, plus, turned = cosine * p - sine2, cosine * p + sine2, cosine * q
    reflectance = 0.5 * s * (1.0 + (minus * minus + turned * turned) / (plus * plus + turned * turned))
    return min(reflectance, 1.0)


@device
def refracted(ux, uy, uz, nx, ny, nz, cosine, ratio, excess, g):
    """Return the direction behind the surface by Snell's law.

    N opposes u, u·n = -cosine; g from `fresnel`.
    """
    along = -excess / (cosine + g)  # cosine - g
    inverse = 1.0 / ratio
    return renormalized((ux + along * nx) * inverse, (uy + along * ny) * inverse, (uz + along * nz) * inverse)


@device
def bent_by_lens(ux, uy, uz, nx, ny, nz, mu, kx, ky, kz):
    """Return the direction behind an ideal thin lens, and its cosine.

    The components along the lens change by -k, where k = x/f lies in the plane of the lens; if no such
    direction exists, the ray goes back along its path. The Jacobian of the change of direction cosines is 1:
    étendue is conserved.
    """
    px, py, pz = ux - mu * nx - kx, uy - mu * ny - ky, uz - mu * nz - kz
    left = 1.0 - (px * px + py * py + pz * pz)
    cosine = math.copysign(math.sqrt(left if left > 0.0 else 0.0), mu)
    vx, vy, vz = renormalized(px + cosine * nx, py + cosine * ny, pz + cosine * nz)
    passes = left > 0.0
    return vx if passes else -ux, vy if passes else -uy, vz if passes else -uz, cosine if passes else -mu
