"""The yardstick: two benchmark problems solved one particle at a time, as a plain kernel without bundles.

It uses float64, libm's sine and cosine, branches and plain float64 sums.  Random numbers and the rule of the
roulette are the engine's, so both do the same work for the same answer.
"""

import math

import numpy as np
from numba import njit

from transport.engine.cache import cached_kernels
from transport.physics.directions import turned_by
from transport.physics.streams import DIRECTION, EVENT, POSITION, random_words, short_uniform, uniform

CELLS = 16  # cosine bins of each tally
COLUMNS = "cx", "cy", "cz", "ax", "ay", "az", "bx", "by", "bz", "nx", "ny", "nz", "half_a", "half_b", "albedo"
WALL = np.dtype([(name, "f8") for name in COLUMNS])  # centre, two axes, inward normal, half sides, albedo


def box_walls(side: float, albedo: float) -> np.ndarray:
    """Return the six walls -x, +x, -y, +y, -z, +z of a cube around the origin: records of WALL, (6,)."""
    walls = np.zeros(6, WALL)
    for q in range(6):
        axis, sign = q // 2, 1.0 if q % 2 else -1.0
        n, a, b = np.roll(np.eye(3), -axis, axis=0)
        for name, vector in (("c", 0.5 * side * sign * n), ("a", a), ("b", b), ("n", -sign * n)):
            for x, value in zip("xyz", vector, strict=True):
                walls[name + x][q] = value
    walls["half_a"] = walls["half_b"] = 0.5 * side
    walls["albedo"] = albedo
    return walls


def run_box(
    histories: int, seed: int, side: float = 2.0, albedo: float = 0.5
) -> tuple[int, np.ndarray, np.ndarray]:
    """Run a closed cube of diffuse walls, lit by its ceiling +z; return crossings, arrivals, departures.

    Arrivals and departures are summed weights by wall and cosine, shape (6, 16), in units of the weight at
    birth.  Departures include reflection by the walls and emission by the ceiling.
    """
    arrivals, departures = np.zeros((6, CELLS)), np.zeros((6, CELLS))
    crossings = _box(histories, seed, box_walls(side, albedo), 5, arrivals, departures)
    return crossings, arrivals, departures


def run_disks(
    histories: int, seed: int, radius: float = 0.5, detector_radius: float = 0.1, distance: float = 2.0
) -> tuple[int, np.ndarray]:
    """Run a Lambertian disk that faces a coaxial detector; return hits, and hits by cosine, shape (16,)."""
    arrivals = np.zeros(CELLS)
    return _disks(histories, seed, radius, detector_radius, distance, arrivals), arrivals


with cached_kernels():
    plain_njit = njit(cache=True, nogil=True, error_model="numpy")

    @plain_njit
    def _cosine_law(nx, ny, nz, u, turn):
        """Return a unit direction about n with density cosθ/π, from two uniforms."""
        s, phi = math.sqrt(u), 2.0 * math.pi * turn
        return turned_by(nx, ny, nz, math.sqrt(1.0 - u), s * math.cos(phi), s * math.sin(phi))

    @plain_njit
    def _cell(mu):
        return min(int(mu * CELLS), CELLS - 1)

    @plain_njit
    def _nearest_wall(walls, last, x, y, z, ux, uy, uz):
        """Return distance and number of the next wall, without the wall `last` that the particle is on."""
        nearest, wall = math.inf, -1
        for q in range(walls.shape[0]):
            if q == last:
                continue
            w = walls[q]
            rx, ry, rz = w.cx - x, w.cy - y, w.cz - z
            t = (rx * w.nx + ry * w.ny + rz * w.nz) / (ux * w.nx + uy * w.ny + uz * w.nz)
            if 0.0 < t < nearest:
                px, py, pz = t * ux - rx, t * uy - ry, t * uz - rz
                along_a, along_b = px * w.ax + py * w.ay + pz * w.az, px * w.bx + py * w.by + pz * w.bz
                if abs(along_a) <= w.half_a and abs(along_b) <= w.half_b:
                    nearest, wall = t, q
        return nearest, wall

    @plain_njit
    def _box(histories, seed, walls, ceiling, arrivals, departures):
        seed_low, seed_high = seed & 0xFFFFFFFF, seed >> 32
        crossings = 0
        for history in range(histories):
            w = walls[ceiling]
            r0, r1, r2, r3 = random_words(history, 0, 0, POSITION, seed_low, seed_high)
            a, b = (2.0 * uniform(r0, r1) - 1.0) * w.half_a, (2.0 * uniform(r2, r3) - 1.0) * w.half_b
            x, y, z = w.cx + a * w.ax + b * w.bx, w.cy + a * w.ay + b * w.by, w.cz + a * w.az + b * w.bz
            r0, r1, r2, r3 = random_words(history, 0, 0, DIRECTION, seed_low, seed_high)
            u = uniform(r0, r1)
            ux, uy, uz = _cosine_law(w.nx, w.ny, w.nz, u, uniform(r2, r3))
            departures[ceiling, _cell(math.sqrt(1.0 - u))] += 1.0
            weight, event, last = 1.0, 0, ceiling
            while weight > 0.0:
                distance, wall = _nearest_wall(walls, last, x, y, z, ux, uy, uz)
                if wall < 0:  # lost through an edge by rounding
                    break
                x, y, z, last = x + distance * ux, y + distance * uy, z + distance * uz, wall
                crossings += 1
                w = walls[wall]
                arrivals[wall, _cell(-(ux * w.nx + uy * w.ny + uz * w.nz))] += weight
                r0, r1, r2, r3 = random_words(history, 0, event, EVENT, seed_low, seed_high)
                event += 1
                u = uniform(r0, r1)
                ux, uy, uz = _cosine_law(w.nx, w.ny, w.nz, u, short_uniform(r2))
                weight *= w.albedo
                departures[wall, _cell(math.sqrt(1.0 - u))] += weight
                if weight < 0.5:
                    weight = 1.0 if short_uniform(r3) < weight else 0.0
        return crossings

    @plain_njit
    def _disks(histories, seed, radius, detector_radius, distance, arrivals):
        seed_low, seed_high = seed & 0xFFFFFFFF, seed >> 32
        hits = 0
        for history in range(histories):
            r0, r1, r2, r3 = random_words(history, 0, 0, POSITION, seed_low, seed_high)
            r, phi = radius * math.sqrt(uniform(r0, r1)), 2.0 * math.pi * uniform(r2, r3)
            x, y = r * math.cos(phi), r * math.sin(phi)
            r0, r1, r2, r3 = random_words(history, 0, 0, DIRECTION, seed_low, seed_high)
            ux, uy, uz = _cosine_law(0.0, 0.0, 1.0, uniform(r0, r1), uniform(r2, r3))
            t = distance / uz
            x, y = x + t * ux, y + t * uy
            if x * x + y * y <= detector_radius * detector_radius:
                arrivals[_cell(uz)] += 1.0
                hits += 1
        return hits


# ---- The yardstick in media: a slab or half space, one photon at a time, as a plain kernel.
#
# It uses float64, libm's logarithm, sine and cosine, survival weights and roulette as in MCML (Wang, Jacques,
# Zheng 1995), branches and plain float64 sums.  Random numbers are the engine's.

# MCML's roulette: threshold weight, and survival probability
ROULETTE_THRESHOLD, SURVIVAL_PROBABILITY = 1e-4, 0.1


def run_fog(
    histories: int, seed: int, depth: float, albedo: float, g: float, index: float = 1.0
) -> tuple[float, float, float, int]:
    """Run a normal beam; return reflected, transmitted and absorbed fractions, and the number of collisions.

    `depth` is the optical depth, inf for a half space; `g` the mean cosine of Henyey and Greenstein; `index`
    the refractive index inside.
    """
    return _fog(histories, seed, depth, albedo, g, index)


with cached_kernels():
    media_njit = njit(cache=True, nogil=True, error_model="numpy")

    @media_njit
    def _reflectance(cosine, index):
        """Return the Fresnel reflectance from inside for unpolarised light."""
        sine2 = index * index * (1.0 - cosine * cosine)
        if sine2 >= 1.0:
            return 1.0
        other = math.sqrt(1.0 - sine2)
        s = (index * cosine - other) / (index * cosine + other)
        p = (cosine - index * other) / (cosine + index * other)
        return 0.5 * (s * s + p * p)

    @media_njit
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
                if weight < ROULETTE_THRESHOLD:
                    if short_uniform(w1) >= SURVIVAL_PROBABILITY:
                        break
                    weight /= SURVIVAL_PROBABILITY
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
