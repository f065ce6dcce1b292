"""Next-event estimation for point detectors: shadow rays from births, flights and diffuse walls.

Each pass computes, for every lane, the origin of its ray, its direction, and its unoccluded contribution (0:
no ray). `list_shadows` selects rays with a contribution; the driver traces them before the next pass.
"""

import math

from numba import uint64

from transport.compile.layout import (
    CODE,
    DIFFUSE,
    MATERIAL_MASK,
    MATERIAL_SHIFT,
    MEDIA,
    POINT,
    POINT_EMISSION,
    POINT_GLOW,
    ROWS,
    SLACK,
    STANDING,
)
from transport.engine.addresses import view
from transport.engine.passes import lane_pass
from transport.engine.volumes import slab
from transport.physics.device import device
from transport.physics.directions import sample_isotropic
from transport.physics.elementary import exp_negative
from transport.physics.sight import sample_equiangular
from transport.physics.streams import SHADOW, event_words, random_words, short_uniform, uniform

NUMBER = uint64(24)  # bits of an event below the number of the point detector
INVERSE_PI = 0.3183098861837907


@device
def towards(x, y, z, px, py, pz):
    """Return unit direction and distance from one point to another; direction 0 if they coincide."""
    dx, dy, dz = px - x, py - y, pz - z
    r = math.sqrt(dx * dx + dy * dy + dz * dz)
    s = 1.0 / r if r > 0.0 else 0.0
    return dx * s, dy * s, dz * s, r


@lane_pass(POINT_EMISSION)
def cast_from_births(b, table, first, live):
    """Cast a shadow ray from each birth: weight times intensity per weight [sr^-1] over squared distance.

    Fields: reads `x, y, z`, `weight`, `sheet`, `nx, ny, nz`; writes `sx, sy, sz`, `vx, vy, vz`, `gap`,
    `score`, `density`, `stands`, `tally`.
    """
    px, py, pz, tally = table.x, table.y, table.z, table.first
    isotropic, lambertian = table.isotropic, table.lambertian
    for k in range(first, live):
        vx, vy, vz, r = towards(b.x[k], b.y[k], b.z[k], px, py, pz)
        cosine = vx * b.nx[k] + vy * b.ny[k] + vz * b.nz[k] if lambertian > 0.0 else 0.0
        density = isotropic + lambertian * (cosine if cosine > 0.0 else 0.0)
        b.sx[k], b.sy[k], b.sz[k] = b.x[k], b.y[k], b.z[k]
        b.vx[k], b.vy[k], b.vz[k], b.gap[k] = vx, vy, vz, r
        b.score[k] = b.weight[k] * density / (r * r) if r > 0.0 else 0.0
        b.density[k], b.stands[k], b.tally[k] = 1.0, b.sheet[k], tally
    return live


@lane_pass(POINT_GLOW)
def cast_from_box(b, table, first, live):
    """Cast a shadow ray from a uniformly emitting box.

    Samples an isotropic line through the point and a uniform place in the box on it: the factor 1/r^2 is
    sampled rather than weighted.

    Fields: reads `weight`, `history`; writes `sx, sy, sz`, `vx, vy, vz`, `gap`, `score`, `density`, `stands`,
    `tally`.
    """
    px, py, pz = table.x, table.y, table.z
    hx, hy, hz, scale, tally = table.hx, table.hy, table.hz, table.scale, table.first
    ox, oy, oz = px - table.cx, py - table.cy, pz - table.cz
    seed_low, seed_high, batch, event = b.seed_low, b.seed_high, b.batch, uint64(table.number) << NUMBER
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, event, SHADOW, seed_low, seed_high)
        ux, uy, uz = sample_isotropic(uniform(w0, w1), short_uniform(w2))
        near_x, far_x = slab(ox, ux, hx)
        near_y, far_y = slab(oy, uy, hy)
        near_z, far_z = slab(oz, uz, hz)
        # Chord of the box on this line, and a place on it.
        near = max(0.0, max(near_x, max(near_y, near_z)))
        far = min(far_x, min(far_y, far_z))
        way = far - near if near < far else 0.0
        s = near + short_uniform(w3) * way if near < far else 1.0
        b.sx[k], b.sy[k], b.sz[k] = px + s * ux, py + s * uy, pz + s * uz
        b.vx[k], b.vy[k], b.vz[k], b.gap[k] = -ux, -uy, -uz, s
        b.score[k] = b.weight[k] * way * scale
        b.density[k], b.stands[k], b.tally[k] = 1.0, 0, tally
    return live


@lane_pass(POINT_GLOW)
def cast_from_sphere(b, table, first, live):
    """The same for a ball; the chord is computed from its point nearest to the centre.

    Fields: reads `weight`, `history`; writes `sx, sy, sz`, `vx, vy, vz`, `gap`, `score`, `density`, `stands`,
    `tally`.
    """
    px, py, pz, radius, scale, tally = table.x, table.y, table.z, table.hx, table.scale, table.first
    ox, oy, oz = px - table.cx, py - table.cy, pz - table.cz
    seed_low, seed_high, batch, event = b.seed_low, b.seed_high, b.batch, uint64(table.number) << NUMBER
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, event, SHADOW, seed_low, seed_high)
        ux, uy, uz = sample_isotropic(uniform(w0, w1), short_uniform(w2))
        h = ox * ux + oy * uy + oz * uz
        qx, qy, qz = ox - h * ux, oy - h * uy, oz - h * uz
        q = math.sqrt(qx * qx + qy * qy + qz * qz)
        d = (radius - q) * (radius + q)
        half = math.sqrt(d if d > 0.0 else 0.0)
        near, far = max(0.0, -h - half), half - h
        way = far - near if near < far else 0.0
        s = near + short_uniform(w3) * way if near < far else 1.0
        b.sx[k], b.sy[k], b.sz[k] = px + s * ux, py + s * uy, pz + s * uz
        b.vx[k], b.vy[k], b.vz[k], b.gap[k] = -ux, -uy, -uz, s
        b.score[k] = b.weight[k] * way * scale
        b.density[k], b.stands[k], b.tally[k] = 1.0, 0, tally
    return live


@lane_pass(ROWS)
def know_phase(b, table, first, live):
    """Set the number of the phase function of the medium that a lane flies in; 0 if it does not fly.

    Fields: reads `medium`, `flies`; writes `law`.
    """
    rows = view(table.rows, table.count, MEDIA)
    for k in range(first, live):
        b.law[k] = rows[b.medium[k]].phase if b.flies[k] != 0 else 0
    return live


@lane_pass(POINT)
def cast_from_flights(b, table, first, live):
    """Cast a ray from a scattering point sampled equiangularly on each flight (Kulla and Fajardo 2012).

    No factor for survival to that point: the flight's length is itself sampled; only absorption along it is
    weighted. In voxels the coefficient is not known yet: the score stays negative until `weigh_in_grid`.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `history`, `event`, `start`, `distance`, `medium`, `mfp`,
    `sigma_a`, `survival`, `flies`, `law`; writes `sx, sy, sz`, `vx, vy, vz`, `gap`, `score`, `bent`,
    `density`, `stands`, `tally`.
    """
    px, py, pz, tally, medium = table.x, table.y, table.z, table.first, table.medium
    seed_low, seed_high, batch, number = b.seed_low, b.seed_high, b.batch, uint64(table.number) << NUMBER
    for k in range(first, live):
        event = uint64(b.event[k]) | number
        w0, w1, _, _ = event_words(b.history[k], batch, event, SHADOW, seed_low, seed_high)
        x, y, z, ux, uy, uz = b.x[k], b.y[k], b.z[k], b.ux[k], b.uy[k], b.uz[k]
        rx, ry, rz = px - x, py - y, pz - z
        # Foot of the perpendicular from the point on the ray, and its length.
        foot = rx * ux + ry * uy + rz * uz
        qx, qy, qz = rx - foot * ux, ry - foot * uy, rz - foot * uz
        least = math.sqrt(qx * qx + qy * qy + qz * qz)
        start, end, mfp = b.start[k] + SLACK, b.distance[k] - SLACK, b.mfp[k]
        flies = (b.flies[k] != 0) & (b.weight[k] != 0.0) & (b.law[k] != 0) & (b.medium[k] != medium)
        flies &= (start < end) & (end < math.inf)
        # Sample the place; `inverse` is one over (pdf times r^2).
        place, inverse = sample_equiangular(
            least, start - foot, (end if flies else start) - foot, uniform(w0, w1)
        )
        t = foot + place
        sx, sy, sz = x + t * ux, y + t * uy, z + t * uz
        vx, vy, vz, r = towards(sx, sy, sz, px, py, pz)
        sigma_s = b.survival[k] / mfp if mfp < math.inf else -1.0
        score = b.weight[k] * exp_negative(-b.sigma_a[k] * (t - b.start[k])) * sigma_s * inverse
        b.sx[k], b.sy[k], b.sz[k] = sx, sy, sz
        b.vx[k], b.vy[k], b.vz[k], b.gap[k] = vx, vy, vz, r
        b.bent[k] = ux * vx + uy * vy + uz * vz
        b.score[k] = score if flies else 0.0
        b.density[k], b.stands[k], b.tally[k] = 0.0, 0, tally
    return live


@lane_pass(POINT)
def cast_from_walls(b, table, first, live):
    """Cast a shadow ray from diffuse walls: weight reflected or transmitted times cosine/(pi r^2).

    Fields: reads `x, y, z`, `weight`, `sheet`, `hit`, `nx, ny, nz`, `mu`; writes `sx, sy, sz`, `vx, vy, vz`,
    `gap`, `score`, `density`, `stands`, `tally`.
    """
    px, py, pz, tally = table.x, table.y, table.z, table.first
    for k in range(first, live):
        vx, vy, vz, r = towards(b.x[k], b.y[k], b.z[k], px, py, pz)
        side = 1.0 if b.mu[k] > 0.0 else -1.0
        cosine = side * (vx * b.nx[k] + vy * b.ny[k] + vz * b.nz[k])
        here = ((b.hit[k] >> MATERIAL_SHIFT) & MATERIAL_MASK) == DIFFUSE
        b.sx[k], b.sy[k], b.sz[k] = b.x[k], b.y[k], b.z[k]
        b.vx[k], b.vy[k], b.vz[k], b.gap[k] = vx, vy, vz, r
        b.score[k] = b.weight[k] * INVERSE_PI * cosine / (r * r) if here & (cosine > 0.0) & (r > 0.0) else 0.0
        b.density[k], b.stands[k], b.tally[k] = 1.0, b.sheet[k] & STANDING, tally
    return live


@lane_pass(CODE)
def list_shadows(b, table, first, live):
    """List the lanes whose rays contribute, and set their `leg` to the table's code.

    The score becomes score times pdf.

    Fields: reads `density`; updates `score`; writes `leg`, `cast`, `taken`.
    """
    cast, leg = 0, table.code
    for k in range(first, live):  # no branch, so no misprediction
        score = b.score[k] * b.density[k]
        b.score[k], b.leg[k] = score, leg
        b.listed[cast] = k
        cast += 1 if score > 0.0 else 0
    b.cast, b.taken = cast, 0
    return live
