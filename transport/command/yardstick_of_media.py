"""The yardstick in media: a slab or half space, one photon at a time, as a plain kernel.

It uses float64, libm's logarithm, sine and cosine, survival weights and roulette as in MCML (Wang, Jacques,
Zheng 1995), branches and plain float64 sums.  Random numbers are the engine's.
"""

import math

from numba import njit

from transport.engine.cache import cached_kernels
from transport.physics.streams import EVENT, random_words, short_uniform, uniform

LIGHT, CHANCE = 1e-4, 0.1  # MCML's roulette: threshold weight, and survival probability


def run_fog(
    histories: int, seed: int, depth: float, albedo: float, g: float, index: float = 1.0
) -> tuple[float, float, float, int]:
    """Run a normal beam; return reflected, transmitted and absorbed fractions, and the number of collisions.

    `depth` is the optical depth, inf for a half space; `g` the mean cosine of Henyey and Greenstein; `index`
    the refractive index inside.
    """
    return _fog(histories, seed, depth, albedo, g, index)


with cached_kernels():
    one_by_one = njit(cache=True, nogil=True, error_model="numpy")

    @one_by_one
    def _reflectance(cosine, index):
        """Return the Fresnel reflectance from inside for unpolarised light."""
        sine2 = index * index * (1.0 - cosine * cosine)
        if sine2 >= 1.0:
            return 1.0
        other = math.sqrt(1.0 - sine2)
        s = (index * cosine - other) / (index * cosine + other)
        p = (cosine - index * other) / (cosine + index * other)
        return 0.5 * (s * s + p * p)

    @one_by_one
    def _fog(histories, seed, depth, albedo, g, index):
        seed_low, seed_high = seed & 0xFFFFFFFF, seed >> 32
        specular = ((index - 1.0) / (index + 1.0)) ** 2
        back, through, kept, collisions = 0.0, 0.0, 0.0, 0
        for history in range(histories):
            z, ux, uy, uz, weight, event = 0.0, 0.0, 0.0, 1.0, 1.0 - specular, 0
            back += specular
            while weight > 0.0:
                w0, w1, w2, w3 = random_words(history, 0, event, EVENT, seed_low, seed_high)
                event += 1
                path = -math.log(1.0 - uniform(w0, w1))
                z += path * uz
                while z < 0.0 or z > depth:  # a boundary
                    if index != 1.0:
                        r0, _, _, _ = random_words(history, 0, event, EVENT, seed_low, seed_high)
                        event += 1
                        if short_uniform(r0) < _reflectance(abs(uz), index):
                            z, uz = (-z if z < 0.0 else 2.0 * depth - z), -uz
                            continue
                    back += weight if z < 0.0 else 0.0
                    through += weight if z > depth else 0.0
                    weight = 0.0
                    break
                if weight == 0.0:
                    break
                collisions += 1
                kept += weight * (1.0 - albedo)
                weight *= albedo
                if weight < LIGHT:
                    if short_uniform(w1) >= CHANCE:
                        break
                    weight /= CHANCE
                t = (1.0 - g * g) / (1.0 - g + 2.0 * g * short_uniform(w2)) if g != 0.0 else 0.0
                mu = (1.0 + g * g - t * t) / (2.0 * g) if g != 0.0 else 2.0 * short_uniform(w2) - 1.0
                sine, phi = math.sqrt(max(0.0, 1.0 - mu * mu)), 2.0 * math.pi * short_uniform(w3)
                c, s = sine * math.cos(phi), sine * math.sin(phi)
                if abs(uz) > 0.99999:
                    ux, uy, uz = c, s, mu * math.copysign(1.0, uz)
                else:
                    r = math.sqrt(1.0 - uz * uz)
                    ux, uy, uz = (
                        (ux * uz * c - uy * s) / r + ux * mu,
                        (uy * uz * c + ux * s) / r + uy * mu,
                        -r * c + uz * mu,
                    )
        return back / histories, through / histories, kept / histories, collisions
