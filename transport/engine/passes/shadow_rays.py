"""Next-event estimation for point detectors: shadow rays from births, flights and diffuse walls.

Each pass computes, for every lane, the origin of its ray, its direction, and its unoccluded contribution (0:
no ray). `list_shadow_rays` selects rays with a contribution; the driver traces them before the next pass.
"""

import math

import numpy as np
from numba import int64, uint64

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE
from transport.engine.bodies import bundle_pass, lane_at, lane_pass
from transport.engine.bundle import LANES, Bundle, add_to_row, view
from transport.engine.passes.detector_bins import find_cell
from transport.engine.passes.volumes import half_chord, slab_crossings
from transport.engine.passes.voxels import cell_at, grid_depth
from transport.engine.tally import limbs, to_scored
from transport.engine.words import standing_sheet
from transport.physics.bits import bits_of, float_of
from transport.physics.device import choose, device
from transport.physics.directions import sample_isotropic, unit_and_length
from transport.physics.elementary import exp_negative
from transport.physics.sight import henyey_greenstein_density, rayleigh_density, sample_equiangular
from transport.physics.streams import SHADOW, event_words, random_words, short_uniform, uniform

DETECTOR_SHIFT = uint64(24)  # bits of an event below the number of the point detector
INVERSE_PI = 0.3183098861837907


@device
def direction_to(x, y, z, px, py, pz):
    """Return unit direction and distance from one point to another; direction 0 if they coincide."""
    return unit_and_length(px - x, py - y, pz - z)


@lane_pass(layout.POINT_EMISSION)
def cast_from_births(lane, table):
    """Cast a shadow ray from each birth: weight times intensity per weight [sr^-1] over squared distance."""
    px, py, pz, tally = table.x, table.y, table.z, table.first
    isotropic, lambertian = table.isotropic, table.lambertian
    vx, vy, vz, r = direction_to(lane.x, lane.y, lane.z, px, py, pz)
    cosine = vx * lane.nx + vy * lane.ny + vz * lane.nz if lambertian > 0.0 else 0.0
    density = isotropic + lambertian * (cosine if cosine > 0.0 else 0.0)
    lane.sx, lane.sy, lane.sz = lane.x, lane.y, lane.z
    lane.vx, lane.vy, lane.vz, lane.point_distance = vx, vy, vz, r
    lane.score = lane.weight * density / (r * r) if r > 0.0 else 0.0
    lane.pdf, lane.shadow_sheet, lane.tally = 1.0, lane.sheet, tally


@lane_pass(layout.POINT_GLOW)
def cast_from_box(lane, table):
    """Cast a shadow ray from a uniformly emitting box.

    Samples an isotropic line through the point and a uniform place in the box on it: the factor 1/r^2 is
    sampled rather than weighted.
    """
    px, py, pz = table.x, table.y, table.z
    hx, hy, hz, scale, tally = table.hx, table.hy, table.hz, table.scale, table.first
    ox, oy, oz = px - table.cx, py - table.cy, pz - table.cz
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    event = uint64(table.number) << DETECTOR_SHIFT
    w0, w1, w2, w3 = random_words(lane.history, batch, event, SHADOW, seed_low, seed_high)
    ux, uy, uz = sample_isotropic(uniform(w0, w1), short_uniform(w2))
    near_x, far_x = slab_crossings(ox, ux, hx)
    near_y, far_y = slab_crossings(oy, uy, hy)
    near_z, far_z = slab_crossings(oz, uz, hz)
    # Chord of the box on this line, and a place on it.
    near = max(0.0, max(near_x, max(near_y, near_z)))
    far = min(far_x, min(far_y, far_z))
    length = far - near if near < far else 0.0
    s = near + short_uniform(w3) * length if near < far else 1.0
    lane.sx, lane.sy, lane.sz = px + s * ux, py + s * uy, pz + s * uz
    lane.vx, lane.vy, lane.vz, lane.point_distance = -ux, -uy, -uz, s
    lane.score = lane.weight * length * scale
    lane.pdf, lane.shadow_sheet, lane.tally = 1.0, 0, tally


@lane_pass(layout.POINT_GLOW)
def cast_from_sphere(lane, table):
    """Cast a shadow ray from a uniformly emitting ball.

    The chord follows from its point nearest the centre.
    """
    px, py, pz, radius, scale, tally = table.x, table.y, table.z, table.hx, table.scale, table.first
    ox, oy, oz = px - table.cx, py - table.cy, pz - table.cz
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    event = uint64(table.number) << DETECTOR_SHIFT
    w0, w1, w2, w3 = random_words(lane.history, batch, event, SHADOW, seed_low, seed_high)
    ux, uy, uz = sample_isotropic(uniform(w0, w1), short_uniform(w2))
    h = ox * ux + oy * uy + oz * uz
    qx, qy, qz = ox - h * ux, oy - h * uy, oz - h * uz
    q = math.sqrt(qx * qx + qy * qy + qz * qz)
    half = half_chord(radius, q)
    near, far = max(0.0, -h - half), half - h
    length = far - near if near < far else 0.0
    s = near + short_uniform(w3) * length if near < far else 1.0
    lane.sx, lane.sy, lane.sz = px + s * ux, py + s * uy, pz + s * uz
    lane.vx, lane.vy, lane.vz, lane.point_distance = -ux, -uy, -uz, s
    lane.score = lane.weight * length * scale
    lane.pdf, lane.shadow_sheet, lane.tally = 1.0, 0, tally


@lane_pass(layout.ROWS)
def find_phase_of_flights(lane, table):
    """Set the number of the phase function of the medium that a lane flies in."""
    rows = view(lane.arena + table.rows, table.count, layout.MEDIA)
    lane.phase_number = rows[lane.medium].phase


@lane_pass(layout.POINT)
def cast_from_flights(lane, table):
    """Cast a ray from a scattering point sampled equiangularly on each flight (Kulla and Fajardo 2012).

    No factor for survival to that point: the flight's length is itself sampled; only absorption along it is
    weighted. In voxels the coefficient is not known yet: the score stays negative until
    `scale_by_grid_scattering`.
    """
    px, py, pz, tally, medium = table.x, table.y, table.z, table.first, table.medium
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    number = uint64(table.number) << DETECTOR_SHIFT
    event = uint64(lane.event) | number
    w0, w1, _, _ = event_words(lane.history, batch, event, SHADOW, seed_low, seed_high)
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    rx, ry, rz = px - x, py - y, pz - z
    # Foot of the perpendicular from the point on the ray, and its length.
    foot = rx * ux + ry * uy + rz * uz
    qx, qy, qz = rx - foot * ux, ry - foot * uy, rz - foot * uz
    least = math.sqrt(qx * qx + qy * qy + qz * qz)
    start, end, mfp = lane.start + COLLISION_CLEARANCE, lane.distance - COLLISION_CLEARANCE, lane.mfp
    flies = (lane.weight != 0.0) & (lane.phase_number != 0) & (lane.medium != medium)
    flies &= (start < end) & (end < math.inf)
    # Sample the place; `inverse` is one over (pdf times r^2).
    end = end if flies else start
    place, inverse = sample_equiangular(least, start - foot, end - foot, uniform(w0, w1))
    t = foot + place
    sx, sy, sz = x + t * ux, y + t * uy, z + t * uz
    vx, vy, vz, r = direction_to(sx, sy, sz, px, py, pz)
    sigma_s = lane.survival / mfp if mfp < math.inf else -1.0
    score = lane.weight * exp_negative(-lane.sigma_a * (t - lane.start)) * sigma_s * inverse
    lane.sx, lane.sy, lane.sz = sx, sy, sz
    lane.vx, lane.vy, lane.vz, lane.point_distance = vx, vy, vz, r
    lane.scatter_cosine = ux * vx + uy * vy + uz * vz
    lane.score = score if flies else 0.0
    lane.pdf, lane.shadow_sheet, lane.tally = 0.0, 0, tally


@lane_pass(layout.POINT)
def cast_from_walls(lane, table):
    """Cast a shadow ray from diffuse walls: weight reflected or transmitted times cosine/(pi r^2)."""
    px, py, pz, tally = table.x, table.y, table.z, table.first
    vx, vy, vz, r = direction_to(lane.x, lane.y, lane.z, px, py, pz)
    side = 1.0 if lane.mu > 0.0 else -1.0
    cosine = side * (vx * lane.nx + vy * lane.ny + vz * lane.nz)
    here = lane.material == layout.DIFFUSE
    lane.sx, lane.sy, lane.sz = lane.x, lane.y, lane.z
    lane.vx, lane.vy, lane.vz, lane.point_distance = vx, vy, vz, r
    lane.score = lane.weight * INVERSE_PI * cosine / (r * r) if here & (cosine > 0.0) & (r > 0.0) else 0.0
    lane.pdf, lane.shadow_sheet, lane.tally = 1.0, standing_sheet(lane.sheet), tally


@bundle_pass(layout.LEG)
def list_shadow_rays(lanes, table, first, live):
    """List the lanes whose rays contribute, and set their `leg` to the table's code.

    The score becomes score times pdf.
    """
    cast, leg = uint64(0), table.leg
    for k in range(first, live):  # no branch, so no misprediction
        lane = lane_at(lanes, k)
        score = lane.score * lane.pdf
        lane.score, lane.leg = score, leg
        lane_at(lanes, cast).listed = k
        cast += uint64(1) if score > 0.0 else uint64(0)
    lanes.rays_cast, lanes.rays_taken = cast, 0
    return live


# ---- Scattering towards a point: coefficients in voxels, and pdfs of phase functions.
#
# `phase_number` is that of a lane's phase function, `scatter_cosine` the cosine of its scattering angle; the
# pdfs of a mixture's parts add up in `pdf`.

ISOTROPIC_PDF = 0.07957747154594767  # 1 / 4 pi


@lane_pass(layout.GRID)
def scale_by_grid_scattering(lane, table):
    """Multiply the score by the scattering coefficient of the voxel where a shadow ray begins.

    Only scores that still lack it, which are negative.
    """
    scattering = view(lane.arena + table.scattering, table.scattering_count, np.float64)
    if (lane.score < 0.0) & (lane.medium == table.medium):
        i = cell_at((lane.sx - table.cx) * table.per_x, table.nx)
        j = cell_at((lane.sy - table.cy) * table.per_y, table.ny)
        m = cell_at((lane.sz - table.cz) * table.per_z, table.nz)
        voxel = int64(i * table.scattering_x + j * table.scattering_y + m * table.scattering_z)
        lane.score *= -scattering[voxel] * table.length


@lane_pass(layout.POINT_PHASE)
def add_isotropic_pdf(lane, table):
    """Add the pdf of isotropic scattering, share/(4 pi) [sr^-1]."""
    number, density = table.number, table.share * ISOTROPIC_PDF
    lane.pdf += density if lane.phase_number == number else 0.0


@lane_pass(layout.POINT_PHASE)
def add_henyey_greenstein_pdf(lane, table):
    """Add the pdf of the phase function of Henyey and Greenstein [sr^-1]."""
    number, share, g = table.number, table.share, table.g
    density = share * henyey_greenstein_density(g, lane.scatter_cosine)
    lane.pdf += density if lane.phase_number == number else 0.0


@lane_pass(layout.POINT_PHASE)
def add_rayleigh_pdf(lane, table):
    """Add the pdf of Rayleigh's phase function [sr^-1]."""
    number, share = table.number, table.share
    density = share * rayleigh_density(lane.scatter_cosine)
    lane.pdf += density if lane.phase_number == number else 0.0


@lane_pass(layout.POINT_PHASE)
def add_tabulated_pdf(lane, table):
    """Add the pdf of a tabulated phase function, linear in the cosine between its points [sr^-1]."""
    count = table.cells + 1
    cosines = view(lane.arena + table.cosines, count, np.float64)
    values = view(lane.arena + table.values, count, np.float64)
    if (lane.phase_number == table.number) & (lane.score != 0.0):
        mu = min(1.0, max(-1.0, lane.scatter_cosine))
        j = find_cell(mu, table.cells, lane.arena + table.cosines)
        part = (mu - cosines[j]) / (cosines[j + 1] - cosines[j])
        lane.pdf += table.share * (values[j] + part * (values[j + 1] - values[j]))


# ---- Tracing of shadow rays, in a bundle of their own: attenuated in media, ended by acting surfaces.
#
# They use the passes of flights for all shapes and media. Rays wait until the bundle is full, so its passes
# work on full vectors; their order does not matter, because sums are of integers.

WORDS = Bundle.itemsize // 8
WEIGHT = Bundle.fields["weight"][1] // 8
MAX_SCORE = 2.0**250  # bound of a score; only a beam through the very point exceeds it
# Contribution to driver.MAX_SCORED: bounds what one score adds to a row, like 2^28 for a volume score.
SCORE_BOUND = 1 << 30


@bundle_pass(layout.ROWS)
def load_shadow_rays(lanes, table, first, live):
    """Move listed rays into idle lanes of the shadow bundle; returns the number of rays under way there.

    Called with the bundle that casts; `table` maps words of its lanes to words of the shadow bundle.
    """
    moves = view(lanes.arena + table.rows, table.count, layout.WORD)
    here, there = view(lanes.address, WORDS, np.int64), view(lanes.shadow, WORDS, np.int64)
    taken, cast, flying = lanes.rays_taken, lanes.rays_cast, 0
    for free in range(LANES):
        if there[WEIGHT + free] != 0:
            flying += 1
        elif taken < cast:
            k = lane_at(lanes, uint64(taken)).listed
            for m in range(table.count):
                source = moves[m].source
                there[moves[m].target + free] = here[source + k] if source >= 0 else 0
            taken += 1
            flying += 1
    lanes.rays_taken = taken
    lanes.rays_cast = cast if taken < cast else 0
    return flying


@lane_pass(layout.NO_TABLE)
def reset_shadow_hit(lane, table):
    """Set the distance of each ray to that of its point, with no hit; 0 in idle lanes."""
    lane.distance = lane.point_distance if lane.weight != 0.0 else 0.0
    lane.hit, lane.covered = 0, 0


@lane_pass(layout.NO_TABLE)
def attenuate_shadow_rays(lane, table):
    """Multiply by the transmittance of the medium, exp(-(absorption + scattering) path)."""
    depth = (lane.sigma_a + 1.0 / lane.mfp) * (lane.distance - lane.start)
    lane.weight *= exp_negative(-depth)


@lane_pass(layout.GRID)
def attenuate_shadow_rays_in_grid(lane, table):
    """Multiply by the transmittance of voxels, from the exact optical depth."""
    absorption = view(lane.arena + table.absorption, table.absorption_count, np.float64)
    scattering = view(lane.arena + table.scattering, table.scattering_count, np.float64)
    if (lane.weight != 0.0) & (lane.medium == table.medium):
        x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
        start, end = lane.start, lane.distance
        depth = grid_depth(table, absorption, scattering, x, y, z, ux, uy, uz, start, end)
        lane.weight *= exp_negative(-depth)


@device
def reaches_point(lane, table):
    """Return whether a ray has reached its point."""
    return (lane.hit == 0) & (lane.weight != 0.0) & (lane.leg == 0)


@lane_pass(layout.NO_TABLE, sums=to_scored, when=reaches_point)
def score_at_points(lane, table):
    """Score rays that reached their point unoccluded.

    Rows hold scores by octaves (POINT_OCTAVES), each scaled to its row.
    """
    score = min(lane.weight, MAX_SCORE)
    row = ((bits_of(score) >> 52) - 1023) // layout.POINT_OCTAVES
    scale = float_of((1023 - layout.POINT_OCTAVES * (row + 1)) << 52)
    high, low = limbs(score * scale)
    add_to_row(lane.tallies + 32 * (lane.tally + layout.POINT_MIDDLE + row), high, low, 1, 0)
    return SCORE_BOUND


@lane_pass(layout.NO_TABLE)
def end_rays_at_points(lane, table):
    """End rays at their point, and at acting surfaces."""
    stopped = ((lane.hit == 0) & (lane.leg == 0)) | (lane.surface != 0)
    lane.weight = choose(stopped, 0.0, lane.weight)
