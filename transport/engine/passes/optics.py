"""Optical surfaces: transmission, refraction, glossy reflection, lenses."""

import numpy as np
from numba import uint64

from transport.compile import layout
from transport.compile.layout import EDGE
from transport.engine.bundle import view
from transport.engine.passes.velocities import quantile, quantile_table
from transport.engine.registry import lane_pass
from transport.engine.words import material_of, surface_of
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
def look_up_optics(b, table, first, live):
    """Set the refractive indices as seen from the side of arrival, roughness and transmitted share.

    The gather is a pass of its own because it would slow down a longer loop.

    Fields: reads `hit`, `mu`; writes `ratio`, `index_before`, `index_behind`, `excess`, `roughness`,
    `transmitted`.
    """
    rows = view(table.rows, table.count, layout.OPTICS)
    for k in range(first, live):
        row = rows[surface_of(b.hit[k])]
        enters = row.side * b.mu[k] < 0.0
        b.index_before[k] = row.outside if enters else row.inside
        b.index_behind[k] = row.inside if enters else row.outside
        b.ratio[k] = row.ratio if enters else 1.0 / row.ratio
        b.excess[k] = row.excess if enters else -row.excess / (row.ratio * row.ratio)
        b.roughness[k] = row.roughness
        b.transmitted[k] = row.through
    return live


@lane_pass(layout.ROWS)
def look_up_metal(b, table, first, live):
    """Set `excess` and, in `ratio`, the loss of metals; 0 for other materials, whose own values come later.

    Fields: reads `hit`; writes `ratio`, `excess`.
    """
    rows = view(table.rows, table.count, layout.OPTICS)
    for k in range(first, live):
        row = rows[uint64(surface_of(b.hit[k]))]
        b.excess[k], b.ratio[k] = row.excess, row.loss
    return live


@lane_pass(layout.NO_TABLE)
def reflect_by_metal(b, table, first, live):
    """Set the albedo of metals: Fresnel's reflectance for the cosine of arrival.

    A lane without a particle may have no cosine, and keeps its albedo.

    Fields: reads `mu`, `ratio`, `excess`; updates `albedo`.
    """
    for k in range(first, live):
        loss = b.ratio[k]
        reflectance = metallic_reflectance(abs(b.mu[k]), b.excess[k], loss)
        b.albedo[k] = reflectance if (loss > 0.0) & (reflectance <= 1.0) else b.albedo[k]
    return live


@lane_pass(layout.NO_TABLE)
def sample_transmission(b, table, first, live):
    """Sample transmission with probability `through`.

    The uniform u0 is rescaled within its subinterval and reused.

    Fields: updates `transmitted`, `u0`.
    """
    for k in range(first, live):
        u, share = b.u0[k], b.transmitted[k]
        passes = u < share
        fresh = u / share if passes else (u - share) / (1.0 - share)
        b.u0[k] = fresh if fresh < 1.0 else 0.0
        b.transmitted[k] = 1.0 if passes else 0.0
    return live


@lane_pass(layout.NO_TABLE)
def transmit(b, table, first, live):
    """Transmit: mirror the reflected direction at the surface's plane, for lanes whose `through` is 1.

    Fields: reads `nx, ny, nz`, `transmitted`; updates `ux, uy, uz`, `mu`.
    """
    for k in range(first, live):
        ux, uy, uz = reflected(b.ux[k], b.uy[k], b.uz[k], b.nx[k], b.ny[k], b.nz[k], b.mu[k])
        passes = b.transmitted[k] == 1.0
        b.ux[k] = ux if passes else b.ux[k]
        b.uy[k] = uy if passes else b.uy[k]
        b.uz[k] = uz if passes else b.uz[k]
        b.mu[k] = -b.mu[k] if passes else b.mu[k]
    return live


@lane_pass(layout.NO_TABLE)
def refract(b, table, first, live):
    """Reflect with probability of Fresnel's reflectance, else refract by Snell's law (material DIELECTRIC).

    At an edge, rounding may bring a ray to the wrong side of a surface that ends there, from a medium that it
    is not in. It then goes straight on, so that no medium is mistaken for another. Elsewhere such a
    contradiction is a fault of the scene, and is counted in the ledger.

    Fields: reads `weight`, `hit`, `nx, ny, nz`, `ratio`, `index_before`, `index_behind`, `excess`, `u0`;
    updates `ux, uy, uz`, `index`, `mu`.
    """
    astray = 0
    for k in range(first, live):
        ux, uy, uz, mu, ratio, excess = b.ux[k], b.uy[k], b.uz[k], b.mu[k], b.ratio[k], b.excess[k]
        flip = -1.0 if mu > 0.0 else 1.0
        nx, ny, nz, cosine = flip * b.nx[k], flip * b.ny[k], flip * b.nz[k], abs(mu)
        reflectance, g = fresnel(cosine, ratio, excess)
        vx, vy, vz = refracted(ux, uy, uz, nx, ny, nz, cosine, ratio, excess, g)
        wx, wy, wz = reflected(ux, uy, uz, nx, ny, nz, -cosine)
        # Choose, and detect lanes that arrive from a medium other than theirs.
        back = b.u0[k] < reflectance
        here = material_of(b.hit[k]) == layout.DIELECTRIC
        is_wrong = here & (b.index[k] != 0.0) & (b.index[k] != b.index_before[k])
        is_edge = (b.hit[k] & EDGE) != 0
        here &= not (is_wrong & is_edge)
        astray += 1 if is_wrong & (not is_edge) & (b.weight[k] != 0.0) else 0
        vx, vy, vz = select(back, wx, wy, wz, vx, vy, vz)
        b.ux[k], b.uy[k], b.uz[k] = select(here, vx, vy, vz, ux, uy, uz)
        left = flip * cosine if back else -flip * g / ratio
        b.mu[k] = left if here else mu
        b.index[k] = (b.index_before[k] if back else b.index_behind[k]) if here else b.index[k]
    view(b.ledger, b.ledger_words, np.int64)[4 * layout.LOST + 3] += astray
    return live


@lane_pass(layout.NO_TABLE)
def reflect_glossily(b, table, first, live):
    """Reflect at a sampled visible microfacet (GGX); masked rays are left to the lobe of `scatter_into_lobe`.

    With probability G2/G1 the ray leaves; else `lobe` receives a rescaled uniform.

    Fields: reads `hit`, `nx, ny, nz`, `roughness`, `u0`, `u1`, `u3`; updates `ux, uy, uz`, `mu`; writes
    `lobe`.
    """
    for k in range(first, live):
        ux, uy, uz, mu, alpha = b.ux[k], b.uy[k], b.uz[k], b.mu[k], b.roughness[k]
        flip = -1.0 if mu > 0.0 else 1.0
        nx, ny, nz, cosine = flip * b.nx[k], flip * b.ny[k], flip * b.nz[k], abs(mu)
        # Direction of arrival in the frame of the normal; sample a visible normal; reflect at it.
        px, py, pz = turned_by(nx, ny, nz, 0.0, 1.0, 0.0)
        qx, qy, qz = turned_by(nx, ny, nz, 0.0, 0.0, 1.0)
        x, y = -(ux * px + uy * py + uz * pz), -(ux * qx + uy * qy + uz * qz)
        hx, hy, hz = sample_visible_normal(x, y, cosine, alpha, b.u0[k], b.u1[k])
        seen = hx * x + hy * y + hz * cosine
        out = 2.0 * seen * hz - cosine
        share = unshadowed_share(cosine, out, alpha)
        vx, vy, vz = turned_by(nx, ny, nz, out, 2.0 * seen * hx - x, 2.0 * seen * hy - y)
        vx, vy, vz = renormalized(vx, vy, vz)
        here = material_of(b.hit[k]) == layout.GLOSSY
        u = b.u3[k]
        leaves = u < share
        b.lobe[k] = NO_LOBE if leaves | (not here) else (u - share) / (1.0 - share)
        leaves &= here
        b.ux[k], b.uy[k], b.uz[k] = select(leaves, vx, vy, vz, ux, uy, uz)
        b.mu[k] = flip * out if leaves else mu
    return live


@lane_pass(layout.ROWS)
def scatter_into_lobe(b, table, first, live):
    """Sample the direction of masked rays from the lobe of multiple scattering (Kulla and Conty 2017).

    Fields: reads `weight`, `hit`, `nx, ny, nz`, `lobe`, `u4`; updates `mu`; writes `ux, uy, uz`.
    """
    rows = view(table.rows, table.count, layout.OPTICS)
    for k in range(first, live):
        turn = b.lobe[k]
        if (turn != NO_LOBE) & (b.weight[k] != 0.0):
            octaves, cells = quantile_table(view(rows[surface_of(b.hit[k])].lobe, 1, layout.QUANTILES)[0])
            mu = quantile(octaves, cells, b.u4[k])
            mu = min(max(mu, 2.0**-40), 1.0)
            flip = -1.0 if b.mu[k] > 0.0 else 1.0
            sine = np.sqrt((1.0 - mu) * (1.0 + mu))
            c, s = cos_sin_turn(turn if turn < 1.0 else 0.0)
            nx, ny, nz = flip * b.nx[k], flip * b.ny[k], flip * b.nz[k]
            vx, vy, vz = turned_by(nx, ny, nz, mu, sine * c, sine * s)
            b.ux[k], b.uy[k], b.uz[k] = renormalized(vx, vy, vz)
            b.mu[k] = flip * mu
    return live


@lane_pass(layout.ROWS)
def deflect_by_lens(b, table, first, live):
    """Deflect by an ideal thin lens (material LENS): subtract x/f from the direction's components along it.

    Rays for which no direction remains go back along their path.

    Fields: reads `x, y, z`, `hit`, `nx, ny, nz`; updates `ux, uy, uz`, `event`, `mu`.
    """
    rows = view(table.rows, table.count, layout.OPTICS)
    for k in range(first, live):
        if material_of(b.hit[k]) == layout.LENS:
            row = rows[surface_of(b.hit[k])]
            rx, ry, rz = b.x[k] - row.cx, b.y[k] - row.cy, b.z[k] - row.cz
            b.ux[k], b.uy[k], b.uz[k], b.mu[k] = bent_by_lens(
                b.ux[k], b.uy[k], b.uz[k], b.nx[k], b.ny[k], b.nz[k], b.mu[k],
                rx * row.power, ry * row.power, rz * row.power,
            )  # fmt: skip
            b.event[k] += 1
    return live
