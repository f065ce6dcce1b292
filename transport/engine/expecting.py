"""Expected crossings: each emission, diffuse reflection and collision tells a detector what it would send there.

A ray goes from the event to a point drawn on the detector, with the density p of its direction; it brings f/p, f
the density with which the event sends it there (next-event estimation; Kalos 1963).  Where the detector may be close,
f/p has no bound: then a ray brings f/(p + peak), and a flight that crosses by itself brings the rest, peak/(p + peak), with the greatest density `peak` of events of its kind: both add up to what is right (multiple importance
sampling, Veach 1997, with weights that no angle at the event enters).  No ray then brings more than its event's weight.
"""

import math

from numba import uint64

from transport.compile.layout import (
    DIFFUSE,
    EXPECTATION,
    HELD,
    LAYERS,
    LOOK_BASE,
    MATERIAL_MASK,
    MATERIAL_SHIFT,
    NO_TABLE,
    SHEET_SHIFT,
    STANDING,
    SURFACE_MASK,
    SURFACE_SHIFT,
    TOLD,
)
from transport.engine.casting import INVERSE_PI, NUMBER
from transport.engine.passes import lane_pass
from transport.engine.shadows import A_SCORE
from transport.physics.device import device
from transport.physics.directions import either, turned_by
from transport.physics.elementary import TWO_PI, cos_sin_turn
from transport.physics.emission import cone_about
from transport.physics.streams import EXPECT, event_words, random_words, uniform

# ---- a point of the detector ----


@lane_pass(NO_TABLE)
def draw_first_at_birth(b, table, first, live):
    """Two numbers for a point of the first detector: those that quasi-random points pair with the birthplace's."""
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, EXPECT, seed_low, seed_high)
        b.p0[k], b.p1[k] = uniform(w0, w1), uniform(w2, w3)
    return live


@lane_pass(EXPECTATION)
def draw_at_birth(b, table, first, live):
    """The same for the other detectors."""
    seed_low, seed_high, batch, number = b.seed_low, b.seed_high, b.batch, uint64(table.number) << NUMBER
    for k in range(first, live):
        w0, w1, w2, w3 = event_words(b.history[k], batch, number, EXPECT, seed_low, seed_high)
        b.p0[k], b.p1[k] = uniform(w0, w1), uniform(w2, w3)
    return live


@lane_pass(EXPECTATION)
def draw_at_event(b, table, first, live):
    """The same for later events."""
    seed_low, seed_high, batch, number = b.seed_low, b.seed_high, b.batch, uint64(table.number) << NUMBER
    for k in range(first, live):
        event = uint64(b.event[k]) | number
        w0, w1, w2, w3 = event_words(b.history[k], batch, event, EXPECT, seed_low, seed_high)
        b.p0[k], b.p1[k] = uniform(w0, w1), uniform(w2, w3)
    return live


@device
def way_to(x, y, z, px, py, pz, nx, ny, nz, area, sharing):
    """Direction and distance to a point of a flat detector, and one over (the direction's density + sharing)."""
    dx, dy, dz = px - x, py - y, pz - z
    r2 = dx * dx + dy * dy + dz * dz
    r = math.sqrt(r2)
    s = 1.0 / r if r > 0.0 else 0.0
    vx, vy, vz = dx * s, dy * s, dz * s
    seen = area * abs(vx * nx + vy * ny + vz * nz)
    return vx, vy, vz, r, seen / (r2 + sharing * area) if r > 0.0 else 0.0


@lane_pass(EXPECTATION)
def expect_on_rectangle(b, table, first, live):
    """A point uniform over a rectangle."""
    cx, cy, cz, nx, ny, nz, sheet = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz, table.sheet
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    half_u, half_v, area, sharing = table.half_u, table.half_v, table.area, table.sharing
    for k in range(first, live):
        u, v = (2.0 * b.p0[k] - 1.0) * half_u, (2.0 * b.p1[k] - 1.0) * half_v
        px, py, pz = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz
        vx, vy, vz, r, brings = way_to(b.x[k], b.y[k], b.z[k], px, py, pz, nx, ny, nz, area, sharing)
        b.sx[k], b.sy[k], b.sz[k], b.vx[k], b.vy[k], b.vz[k] = px, py, pz, vx, vy, vz
        b.onset[k], b.score[k] = b.start[k] - r, brings if (b.sheet[k] & STANDING) != sheet else 0.0
    return live


@lane_pass(EXPECTATION)
def expect_on_disk(b, table, first, live):
    """A point uniform over a disk or annulus."""
    cx, cy, cz, nx, ny, nz, sheet = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz, table.sheet
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    inner2, outer2, area, sharing = table.inner2, table.outer2, table.area, table.sharing
    for k in range(first, live):
        r = math.sqrt(inner2 + b.p0[k] * (outer2 - inner2))
        c, s = cos_sin_turn(b.p1[k])
        u, v = r * c, r * s
        px, py, pz = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz
        vx, vy, vz, r, brings = way_to(b.x[k], b.y[k], b.z[k], px, py, pz, nx, ny, nz, area, sharing)
        b.sx[k], b.sy[k], b.sz[k], b.vx[k], b.vy[k], b.vz[k] = px, py, pz, vx, vy, vz
        b.onset[k], b.score[k] = b.start[k] - r, brings if (b.sheet[k] & STANDING) != sheet else 0.0
    return live


@lane_pass(EXPECTATION)
def expect_on_triangle(b, table, first, live):
    """A point uniform over a triangle of a corner c and edges e_u, e_v."""
    cx, cy, cz, nx, ny, nz, sheet = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz, table.sheet
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    area, sharing = table.area, table.sharing
    for k in range(first, live):
        s, share = math.sqrt(b.p0[k]), b.p1[k]
        u, v = s * (1.0 - share), s * share
        px, py, pz = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz
        vx, vy, vz, r, brings = way_to(b.x[k], b.y[k], b.z[k], px, py, pz, nx, ny, nz, area, sharing)
        b.sx[k], b.sy[k], b.sz[k], b.vx[k], b.vy[k], b.vz[k] = px, py, pz, vx, vy, vz
        b.onset[k], b.score[k] = b.start[k] - r, brings if (b.sheet[k] & STANDING) != sheet else 0.0
    return live


@lane_pass(EXPECTATION)
def expect_on_sphere(b, table, first, live):
    """A direction uniform over the solid angle of a ball; told from the ray's closest point to its centre, where that is ahead."""
    cx, cy, cz, radius, sharing = table.cx, table.cy, table.cz, table.half_w, table.sharing
    area = table.area
    for k in range(first, live):
        rx, ry, rz = cx - b.x[k], cy - b.y[k], cz - b.z[k]
        d2 = rx * rx + ry * ry + rz * rz
        d = math.sqrt(d2)
        inverse = 1.0 / d if d2 > 0.0 else 0.0
        axis_x, axis_y, axis_z = rx * inverse, ry * inverse, rz * inverse if d2 > 0.0 else 1.0
        cone = cone_about(d2, radius)
        gap = cone * b.p0[k]  # 1 - cos of the angle from the axis
        cosine, sine = 1.0 - gap, math.sqrt(gap * (2.0 - gap))
        c, s = cos_sin_turn(b.p1[k])
        ex, ey, ez = turned_by(axis_x, axis_y, axis_z, 0.0, c, s)
        depth, ahead = d * sine, (cosine > 0.0) & (d2 > radius * radius)
        b.sx[k] = cx + depth * (cosine * ex - sine * axis_x) if ahead else b.x[k]
        b.sy[k] = cy + depth * (cosine * ey - sine * axis_y) if ahead else b.y[k]
        b.sz[k] = cz + depth * (cosine * ez - sine * axis_z) if ahead else b.z[k]
        b.onset[k] = b.start[k] - (d * cosine if ahead else 0.0)
        b.vx[k] = cosine * axis_x + sine * ex
        b.vy[k] = cosine * axis_y + sine * ey
        b.vz[k] = cosine * axis_z + sine * ez
        b.score[k] = (
            TWO_PI * cone * (d2 / (d2 + sharing * area) if d2 > 0.0 else (0.0 if sharing > 0.0 else 1.0))
        )
    return live


# ---- what an event sends there ----


@lane_pass(EXPECTATION)
def expect_from_births(b, table, first, live):
    """A share of the birth's weight per steradian."""
    isotropic, lambertian, scale, tally = table.isotropic, table.lambertian, table.scale, table.first
    for k in range(first, live):
        cosine = b.vx[k] * b.nx[k] + b.vy[k] * b.ny[k] + b.vz[k] * b.nz[k] if lambertian > 0.0 else 0.0
        b.score[k] *= scale * b.weight[k]
        b.density[k] = isotropic + lambertian * (cosine if cosine > 0.0 else 0.0)
        b.gap[k], b.stands[k], b.tally[k] = math.inf, b.sheet[k], tally
    return live


@lane_pass(EXPECTATION)
def expect_from_walls(b, table, first, live):
    """Of what a diffuse wall has just reflected or let through."""
    scale, tally = table.scale, table.first
    for k in range(first, live):
        side = 1.0 if b.mu[k] > 0.0 else -1.0
        cosine = side * (b.vx[k] * b.nx[k] + b.vy[k] * b.ny[k] + b.vz[k] * b.nz[k])
        here = ((b.hit[k] >> MATERIAL_SHIFT) & MATERIAL_MASK) == DIFFUSE
        b.score[k] *= scale * b.weight[k] if here & (cosine > 0.0) else 0.0
        b.density[k] = INVERSE_PI * cosine
        b.gap[k], b.stands[k], b.tally[k] = math.inf, b.sheet[k] & STANDING, tally
    return live


@lane_pass(EXPECTATION)
def expect_from_collisions(b, table, first, live):
    """Of what a collision scatters; the densities of phase functions are added up next."""
    scale, tally = table.scale, table.first
    for k in range(first, live):
        b.bent[k] = b.ux[k] * b.vx[k] + b.uy[k] * b.vy[k] + b.uz[k] * b.vz[k]
        b.score[k] *= scale * b.weight[k] if b.law[k] != 0 else 0.0
        b.density[k] = 0.0
        b.gap[k], b.stands[k], b.tally[k] = math.inf, 0, tally
    return live


# ---- flights: what of their crossings is told already ----


@lane_pass(TOLD)
def tell_births(b, table, first, live):
    """Where a flight took its direction, and the greatest density of that; 0 for what no ray has told of."""
    peak = table.peak
    for k in range(first, live):
        b.told[k], b.ex[k], b.ey[k], b.ez[k] = peak, b.x[k], b.y[k], b.z[k]
    return live


@lane_pass(TOLD)
def tell_walls(b, table, first, live):
    """The same where something acts; mirrors, glass and lenses send into directions that no ray could tell of."""
    peak = table.peak
    for k in range(first, live):
        acts = ((b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK) != 0
        is_diffuse = ((b.hit[k] >> MATERIAL_SHIFT) & MATERIAL_MASK) == DIFFUSE
        now, before = peak if is_diffuse else 0.0, b.told[k]
        b.told[k] = now if acts else before
        b.ex[k], b.ey[k], b.ez[k] = either(acts, b.x[k], b.y[k], b.z[k], b.ex[k], b.ey[k], b.ez[k])
    return live


@lane_pass(TOLD)
def tell_collisions(b, table, first, live):
    """The same at collisions."""
    peak = table.peak
    for k in range(first, live):
        here, before = b.collides[k] != 0, b.told[k]
        b.told[k] = peak if here else before
        b.ex[k], b.ey[k], b.ez[k] = either(here, b.x[k], b.y[k], b.z[k], b.ex[k], b.ey[k], b.ez[k])
    return live


@lane_pass(NO_TABLE)
def keep_weight(b, table, first, live):
    """Remembered while meters count less of it."""
    for k in range(first, live):
        b.kept[k] = b.weight[k]
    return live


@lane_pass(HELD)
def hold_back(b, table, first, live):
    """Of what one meter is about to count, only the share that no ray has told."""
    cx, cy, cz, area, sheet = table.cx, table.cy, table.cz, table.area, table.sheet
    is_pure, is_ball, passing = table.how == 1, table.how == 3, table.passing != 0
    for k in range(first, live):
        acts, peak, weight = ((b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK) != 0, b.told[k], b.weight[k]
        px, py, pz = either(is_ball, cx, cy, cz, b.x[k], b.y[k], b.z[k])
        rx, ry, rz, seen = px - b.ex[k], py - b.ey[k], pz - b.ez[k], peak * area
        share = 0.0 if is_pure else seen / (rx * rx + ry * ry + rz * rz + seen)
        here = ((b.hit[k] >> SHEET_SHIFT) == sheet) & (peak > 0.0) & (not (passing & acts))
        b.weight[k] = weight * share if here else weight
    return live


@lane_pass(NO_TABLE)
def give_back(b, table, first, live):
    """The whole weight flies on."""
    for k in range(first, live):
        b.weight[k] = b.kept[k]
    return live


# ---- the rays ----


@lane_pass(NO_TABLE)
def end_unmet(b, table, first, live):
    """Rays that meet nothing more have ended; idle lanes stay where they are."""
    for k in range(first, live):
        met = (b.hit[k] != 0) & (b.weight[k] != 0.0)
        b.weight[k] = b.weight[k] if met else 0.0
        b.distance[k] = b.distance[k] if met else 0.0
        b.start[k] = b.start[k] if met else 0.0
        b.hit[k] = b.hit[k] if met else 0
    return live


@lane_pass(NO_TABLE)
def look_at_target_alone(b, table, first, live):
    """Of the meters that a ray crosses only the one counts that it was cast to."""
    for k in range(first, live):
        b.look[k] = b.look[k] if (b.look[k] & LOOK_BASE) == b.tally[k] else 0
    return live


@lane_pass(NO_TABLE)
def look_through(b, table, first, live):
    """What crosses departs as well; what arrives at a wall does not."""
    for k in range(first, live):
        passes = ((b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK) == 0
        b.look[k] = b.look[k] if passes else 0
    return live


@lane_pass(LAYERS)
def pass_target(b, table, first, live):
    """A ray has one crossing of its target less to come."""
    layer, passed = table.layer, 0
    for k in range(first, live):
        there = (b.look[k] != 0) & (((b.hit[k] >> layer) & 1) != 0) & (b.weight[k] != 0.0)
        passed += 1 if there else 0
        b.leg[k] -= 1 if there else 0
    b.scored += passed * A_SCORE
    return live


@lane_pass(NO_TABLE)
def end_expected(b, table, first, live):
    """Rays end where something acts, and behind their target."""
    for k in range(first, live):
        acts = ((b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK) != 0
        b.weight[k] = 0.0 if acts | (b.leg[k] <= 0) else b.weight[k]
    return live
