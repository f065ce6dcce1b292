"""Shadow rays of next-event estimation (next_event.py): pdfs of phase functions, listing, tracing, scores.

`list_shadow_rays` selects the rays that contribute; the driver traces them before the next pass.
"""

import math

import numpy as np
from numba import uint64

from transport.compile import layout
from transport.engine.bodies import bundle_pass, lane_at, lane_pass
from transport.engine.bundle import LANES, Bundle, add_to_row, view
from transport.engine.passes.detector_bins import find_cell
from transport.engine.passes.voxels import grid_depth, scattering_at, voxel_at
from transport.engine.tally import limbs, to_scored
from transport.engine.words import is_covered
from transport.physics.bits import bits_of, float_of
from transport.physics.device import choose, device
from transport.physics.directions import unit_and_length
from transport.physics.elementary import exp_negative
from transport.physics.interfaces import reflected
from transport.physics.sight import henyey_greenstein_density, rayleigh_density


@device
def direction_to(x, y, z, px, py, pz):
    """Return unit direction and distance from one point to another; direction 0 if they coincide."""
    return unit_and_length(px - x, py - y, pz - z)


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
    if (lane.score < 0.0) & (lane.medium == table.medium):
        voxel = voxel_at(table, lane.sx, lane.sy, lane.sz)
        lane.score *= -scattering_at(lane, table, voxel) * table.length


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
MIRROR_MASK, FIRST_ROW_MASK = (1 << layout.MIRROR_BITS) - 1, (1 << layout.MIRROR_SHIFT) - 1


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
                there[moves[m].target + free] = here[moves[m].source + k]
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
    if (lane.weight != 0.0) & (lane.medium == table.medium):
        lane.weight *= exp_negative(-grid_depth(lane, table))


@device
def reaches_point(lane, table):
    """Return whether a ray has reached its point."""
    return (lane.hit == 0) & (lane.weight != 0.0) & (lane.leg == layout.STRAIGHT_LEG)


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
    """End rays to points at their point."""
    reached = (lane.hit == 0) & (lane.leg == layout.STRAIGHT_LEG)
    lane.weight = choose(reached, 0.0, lane.weight)


# ---- Rays to surface detectors score at their own detector only.
#
# They pass other transparent detectors without a score, and end behind their own or at an acting surface.


@lane_pass(layout.NO_TABLE)
def end_missed_rays(lane, table):
    """End rays that hit nothing more and reach no point; idle lanes stay in place."""
    met = (lane.distance < math.inf) & (lane.weight != 0.0)
    lane.weight = choose(met, lane.weight, 0.0)
    lane.distance = choose(met, lane.distance, 0.0)
    lane.start = choose(met, lane.start, 0.0)
    lane.hit = choose(met, lane.hit, 0)
    lane.covered = choose(met, lane.covered, 0)


@lane_pass(layout.NO_TABLE)
def ignore_other_detectors(lane, table):
    """Ignore detectors other than the one that the ray was cast to."""
    is_target = (lane.detector_word & layout.DETECTOR_BASE_MASK) == lane.tally
    lane.detector_word = choose(is_target, lane.detector_word, 0)


@lane_pass(layout.NO_TABLE)
def keep_transmitted(lane, table):
    """Score departures only for rays that pass through; a ray at a wall does not depart."""
    passes = lane.surface == 0
    lane.detector_word = choose(passes, lane.detector_word, 0)


@lane_pass(layout.LAYERS, sums=to_scored)
def count_target_crossings(lane, table):
    """Count one crossing of its target off the `leg` of each ray."""
    there = (lane.detector_word != 0) & is_covered(lane.covered, table.layer) & (lane.weight != 0.0)
    lane.leg -= 1 if there else 0
    return SCORE_BOUND if there else 0


@lane_pass(layout.NO_TABLE)
def end_next_event_rays(lane, table):
    """End rays at acting surfaces, and behind their target."""
    acts = lane.surface != 0
    lane.weight = choose(acts | (lane.leg == 0), 0.0, lane.weight)


@lane_pass(layout.ROWS)
def redirect_next_event_rays(lane, table):
    """Let rays pass straight through acting surfaces, or be reflected by the mirrors of their image in turn.

    They keep the share of the weight that does so, and end behind their target. A ray to a point has the rest
    of its path ahead.
    """
    rows = view(lane.arena + table.rows, table.count, layout.LINK)
    if lane.surface != 0:
        row = rows[uint64(lane.surface)]
        is_back = row.side * lane.mu > 0.0
        reflects = row.back_reflects if is_back else row.front_reflects
        passes = row.back_passes if is_back else row.front_passes
        waiting = lane.tally >> layout.MIRROR_SHIFT
        turns = (waiting != 0) & (row.mirror == waiting & MIRROR_MASK)
        lane.weight *= reflects if turns else passes
        lane.point_distance -= lane.distance
        if turns:
            lane.ux, lane.uy, lane.uz = reflected(
                lane.ux, lane.uy, lane.uz, lane.nx, lane.ny, lane.nz, lane.mu
            )
            lane.mu = -lane.mu
            left = waiting >> layout.MIRROR_BITS << layout.MIRROR_SHIFT
            lane.tally = (lane.tally & FIRST_ROW_MASK) | left
    lane.weight = choose(lane.leg == 0, 0.0, lane.weight)
