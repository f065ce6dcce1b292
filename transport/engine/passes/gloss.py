"""Next-event estimation from glossy walls: the pdf of a ray's direction, and the pdf that flights record.

Light leaves a glossy wall in two ways: by a single reflection at a microfacet, or by the lobe of multiple
scattering (optics.py). Each has MIS weights of its own, with a pdf p that rays and flights compute alike:
flights have the weight p A/(r^2 + p A), rays r^2/(r^2 + p A) (physics/connections.py). For a single
reflection p is the pdf of the direction: flights score most where it is large, rays elsewhere. For the
multiple-scattering lobe p is its largest pdf.

The pdf of that lobe, (1 - E(mu_in)) (1 - E(mu_out)) mu_out/(pi (1 - E_mean)), is estimated without a table
of E: the event itself has chosen the lobe with probability 1 - E(mu_in), and one more microfacet, sampled as
seen from the ray's direction, estimates 1 - E(mu_out).
"""

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.passes.optics import NO_LOBE
from transport.physics.connections import rays_share
from transport.physics.device import choose
from transport.physics.directions import select
from transport.physics.microfacets import sample_shadowed_share, single_reflection_density


@lane_pass(layout.NO_TABLE)
def save_arrival(lane, table):
    """Save the direction of arrival, which the pdf of a reflection depends on."""
    lane.ax, lane.ay, lane.az = lane.ux, lane.uy, lane.uz


@lane_pass(layout.ROWS)
def look_up_lobe(lane, table):
    """Set the largest pdf of the multiple-scattering lobe; 0 at walls that are not glossy."""
    rows = view(lane.arena + table.rows, table.count, layout.OPTICS)
    lane.lobe_peak = rows[lane.surface].lobe_peak


@lane_pass(layout.NO_TABLE)
def set_glossy_pdf(lane, table):
    """Set, for a ray from a glossy wall, its pdf by single reflection; `scatter_cosine` is its cosine."""
    vx, vy, vz, alpha = lane.vx, lane.vy, lane.vz, lane.roughness
    side = 1.0 if lane.mu > 0.0 else -1.0
    nx, ny, nz = side * lane.nx, side * lane.ny, side * lane.nz
    density = single_reflection_density(lane.ax, lane.ay, lane.az, vx, vy, vz, nx, ny, nz, alpha)
    lane.scatter_cosine = vx * nx + vy * ny + vz * nz
    lane.pdf = choose(lane.lobe_peak > 0.0, density, lane.pdf)


@lane_pass(layout.EXPECTATION)
def share_glossy_pdf(lane, table):
    """Weight the pdf of a ray from a glossy wall by MIS, and add that of the multiple-scattering lobe.

    The connection factor already has the weight of diffuse walls, which is divided out.
    """
    cx, cy, cz, area, sharing = table.cx, table.cy, table.cz, table.area, table.sharing
    is_ball, peak = table.half_w > 0.0, lane.lobe_peak
    px, py, pz = select(is_ball, cx, cy, cz, lane.sx, lane.sy, lane.sz)
    rx, ry, rz = px - lane.x, py - lane.y, pz - lane.z
    r2 = rx * rx + ry * ry + rz * rz
    is_glossy = peak > 0.0
    mu = choose(is_glossy & (lane.scatter_cosine > 0.0), min(lane.scatter_cosine, 1.0), 1.0)
    alpha, single = choose(is_glossy, lane.roughness, 1.0), lane.pdf
    again = peak * mu * sample_shadowed_share(mu, alpha, lane.u2, lane.u4)
    again = choose(lane.lobe != NO_LOBE, again, 0.0)
    shared = single * rays_share(r2, area, single, sharing) + again * rays_share(r2, area, peak, sharing)
    lane.pdf = choose(is_glossy, shared, single)


@lane_pass(layout.NO_TABLE)
def record_glossy_pdf(lane, table):
    """Record for MIS the pdf of the direction that was sampled at a glossy wall."""
    ux, uy, uz, alpha, peak = lane.ux, lane.uy, lane.uz, lane.roughness, lane.lobe_peak
    side = 1.0 if lane.mu > 0.0 else -1.0
    nx, ny, nz = side * lane.nx, side * lane.ny, side * lane.nz
    single = single_reflection_density(lane.ax, lane.ay, lane.az, ux, uy, uz, nx, ny, nz, alpha)
    lane.mis_pdf = choose(peak > 0.0, choose(lane.lobe == NO_LOBE, single, peak), lane.mis_pdf)
