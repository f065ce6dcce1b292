"""Optical surfaces: transmission, refraction, glossy reflection, lenses."""

import numpy as np
from numba import uint64

from transport.compile import layout
from transport.compile.layout import EDGE
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.passes.velocities import quantile, quantile_table
from transport.engine.tally import to_spare_word
from transport.physics.device import choose
from transport.physics.directions import select, turned_by
from transport.physics.elementary import cos_sin_turn
from transport.physics.interfaces import (
    bent_by_lens,
    fresnel,
    metallic_reflectance,
    reflected,
    refracted,
    renormalized,
)
from transport.physics.microfacets import sample_visible_normal, unshadowed_share

NO_LOBE = 2.0


@lane_pass(layout.ROWS)
def look_up_optics(lane, table):
    """Set the refractive indices as seen from the side of arrival, roughness and transmitted share.

    The gather is a pass of its own because it would slow down a longer loop.
    """
    rows = view(lane.arena + table.rows, table.count, layout.OPTICS)
    row = rows[lane.surface]
    enters = row.side * lane.mu < 0.0
    lane.index_before = row.outside if enters else row.inside
    lane.index_behind = row.inside if enters else row.outside
    lane.ratio = row.ratio if enters else 1.0 / row.ratio
    lane.excess = row.excess if enters else -row.excess / (row.ratio * row.ratio)
    lane.roughness = row.roughness
    lane.transmitted = row.through


@lane_pass(layout.ROWS)
def look_up_metal(lane, table):
    """Set `excess` and, in `ratio`, the loss of metals; 0 for other materials.

    Their own values come later.
    """
    rows = view(lane.arena + table.rows, table.count, layout.OPTICS)
    row = rows[uint64(lane.surface)]
    lane.excess, lane.ratio = row.excess, row.loss


@lane_pass(layout.NO_TABLE)
def reflect_by_metal(lane, table):
    """Set the albedo of metals: Fresnel's reflectance for the cosine of arrival.

    A lane without a particle may have no cosine, and keeps its albedo.
    """
    loss = lane.ratio
    reflectance = metallic_reflectance(abs(lane.mu), lane.excess, loss)
    lane.albedo = choose((loss > 0.0) & (reflectance <= 1.0), reflectance, lane.albedo)


@lane_pass(layout.NO_TABLE)
def sample_transmission(lane, table):
    """Sample transmission with probability `through`.

    The uniform u0 is rescaled within its subinterval and reused.
    """
    u, share = lane.u0, lane.transmitted
    passes = u < share
    fresh = u / share if passes else (u - share) / (1.0 - share)
    lane.u0 = fresh if fresh < 1.0 else 0.0
    lane.transmitted = 1.0 if passes else 0.0


@lane_pass(layout.NO_TABLE)
def transmit(lane, table):
    """Transmit: mirror the reflected direction at the surface's plane, for lanes whose `through` is 1."""
    ux, uy, uz = reflected(lane.ux, lane.uy, lane.uz, lane.nx, lane.ny, lane.nz, lane.mu)
    passes = lane.transmitted == 1.0
    lane.ux, lane.uy, lane.uz = select(passes, ux, uy, uz, lane.ux, lane.uy, lane.uz)
    lane.mu = choose(passes, -lane.mu, lane.mu)


@lane_pass(layout.NO_TABLE, sums=to_spare_word(layout.LOST))
def refract(lane, table):
    """Reflect with probability of Fresnel's reflectance, else refract by Snell's law (material DIELECTRIC).

    At an edge, rounding may bring a ray to the wrong side of a surface that ends there, from a medium that it
    is not in. It then goes straight on, so that no medium is mistaken for another. Elsewhere such a
    contradiction is a fault of the scene, and is counted in the ledger.
    """
    ux, uy, uz, mu, ratio, excess = lane.ux, lane.uy, lane.uz, lane.mu, lane.ratio, lane.excess
    flip = -1.0 if mu > 0.0 else 1.0
    nx, ny, nz, cosine = flip * lane.nx, flip * lane.ny, flip * lane.nz, abs(mu)
    reflectance, g = fresnel(cosine, ratio, excess)
    vx, vy, vz = refracted(ux, uy, uz, nx, ny, nz, cosine, ratio, excess, g)
    wx, wy, wz = reflected(ux, uy, uz, nx, ny, nz, -cosine)
    # Choose, and detect lanes that arrive from a medium other than theirs.
    back = lane.u0 < reflectance
    here = lane.material == layout.DIELECTRIC
    is_wrong = here & (lane.index != 0.0) & (lane.index != lane.index_before)
    is_edge = (lane.covered & EDGE) != 0
    here &= not (is_wrong & is_edge)
    astray = is_wrong & (not is_edge) & (lane.weight != 0.0)
    vx, vy, vz = select(back, wx, wy, wz, vx, vy, vz)
    lane.ux, lane.uy, lane.uz = select(here, vx, vy, vz, ux, uy, uz)
    lane.mu = choose(here, choose(back, flip * cosine, -flip * g / ratio), mu)
    lane.index = choose(here, choose(back, lane.index_before, lane.index_behind), lane.index)
    return 1 if astray else 0


@lane_pass(layout.NO_TABLE)
def reflect_glossily(lane, table):
    """Reflect at a sampled visible microfacet (GGX); masked rays are left to the lobe of `scatter_into_lobe`.

    With probability G2/G1 the ray leaves; else `lobe` receives a rescaled uniform.
    """
    ux, uy, uz, mu, alpha = lane.ux, lane.uy, lane.uz, lane.mu, lane.roughness
    here, flip = lane.material == layout.GLOSSY, -1.0 if mu > 0.0 else 1.0
    nx, ny, nz, cosine = flip * lane.nx, flip * lane.ny, flip * lane.nz, choose(here, abs(mu), 1.0)
    # Direction of arrival in the frame of the normal; sample a visible normal; reflect at it.
    px, py, pz = turned_by(nx, ny, nz, 0.0, 1.0, 0.0)
    qx, qy, qz = turned_by(nx, ny, nz, 0.0, 0.0, 1.0)
    x, y = -(ux * px + uy * py + uz * pz), -(ux * qx + uy * qy + uz * qz)
    hx, hy, hz = sample_visible_normal(x, y, cosine, alpha, lane.u0, lane.u1)
    seen = hx * x + hy * y + hz * cosine
    out = 2.0 * seen * hz - cosine
    share = unshadowed_share(cosine, out, alpha)
    vx, vy, vz = turned_by(nx, ny, nz, out, 2.0 * seen * hx - x, 2.0 * seen * hy - y)
    vx, vy, vz = renormalized(vx, vy, vz)
    u = lane.u3
    leaves = u < share
    lane.lobe = NO_LOBE if leaves | (not here) else (u - share) / (1.0 - share)
    leaves &= here
    lane.ux, lane.uy, lane.uz = select(leaves, vx, vy, vz, ux, uy, uz)
    lane.mu = flip * out if leaves else mu


@lane_pass(layout.ROWS)
def scatter_into_lobe(lane, table):
    """Sample the direction of masked rays from the lobe of multiple scattering (Kulla and Conty 2017)."""
    rows = view(lane.arena + table.rows, table.count, layout.OPTICS)
    turn = lane.lobe
    if (turn != NO_LOBE) & (lane.weight != 0.0):
        octaves, cells = quantile_table(
            lane, view(lane.arena + rows[lane.surface].lobe, 1, layout.QUANTILES)[0]
        )
        mu = quantile(octaves, cells, lane.u4)
        mu = min(max(mu, 2.0**-40), 1.0)
        flip = -1.0 if lane.mu > 0.0 else 1.0
        sine = np.sqrt((1.0 - mu) * (1.0 + mu))
        c, s = cos_sin_turn(turn if turn < 1.0 else 0.0)
        nx, ny, nz = flip * lane.nx, flip * lane.ny, flip * lane.nz
        vx, vy, vz = turned_by(nx, ny, nz, mu, sine * c, sine * s)
        lane.ux, lane.uy, lane.uz = renormalized(vx, vy, vz)
        lane.mu = flip * mu


@lane_pass(layout.ROWS)
def deflect_by_lens(lane, table):
    """Deflect by an ideal thin lens (material LENS): subtract x/f from the direction's components along it.

    Rays for which no direction remains go back along their path.
    """
    rows = view(lane.arena + table.rows, table.count, layout.OPTICS)
    if lane.material == layout.LENS:
        row = rows[lane.surface]
        rx, ry, rz = lane.x - row.cx, lane.y - row.cy, lane.z - row.cz
        lane.ux, lane.uy, lane.uz, lane.mu = bent_by_lens(
            lane.ux, lane.uy, lane.uz, lane.nx, lane.ny, lane.nz, lane.mu,
            rx * row.power, ry * row.power, rz * row.power,
        )  # fmt: skip
        lane.event += 1
