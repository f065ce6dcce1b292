"""Acting surfaces: absorb, choose the part of a mixture, reflect; limit of events."""

from numba import uint64

from transport.compile import layout
from transport.engine.bundle import add_to_row, view
from transport.engine.registry import lane_pass
from transport.engine.tally import add_lost, limbs_of_loss
from transport.engine.words import material_of, surface_of
from transport.physics.directions import sample_cosine_law, select
from transport.physics.interfaces import reflected
from transport.physics.streams import EVENT, WALL, event_words, short_uniform, uniform

MAX_EVENTS = 1 << 24  # after which a history ends as lost
# bits of a hit: surface and material
ACTING_BITS = (layout.SURFACE_MASK << layout.SURFACE_SHIFT) | (layout.MATERIAL_MASK << layout.MATERIAL_SHIFT)


@lane_pass(layout.ROWS)
def look_up_surface(b, table, first, live):
    """Set the albedo of the acting surface; row 0 transmits everything.

    Fields: reads `hit`; writes `albedo`.
    """
    surfaces = view(table.rows, table.count, layout.SURFACE)
    for k in range(first, live):
        b.albedo[k] = surfaces[uint64(surface_of(b.hit[k]))].albedo
    return live


@lane_pass(layout.NO_TABLE)
def draw_second_block(b, table, first, live):
    """Draw a second random block (u3, u4), for mixtures and thermal walls.

    Fields: reads `history`, `event`; writes `u3`, `u4`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = event_words(b.history[k], batch, b.event[k], WALL, seed_low, seed_high)
        b.u3[k], b.u4[k] = uniform(w0, w1), uniform(w2, w3)
    return live


@lane_pass(layout.TWO_ROWS)
def choose_material(b, table, first, live):
    """Choose the material of the side that was hit.

    Of a mixture, one part with the probability of its share.

    The hit becomes that of the chosen row. The uniform u3 is rescaled within the part's share and reused.

    Fields: reads `mu`; updates `hit`, `u3`.
    """
    surfaces = view(table.rows, table.count, layout.SURFACE)
    optics = view(table.others, table.other_count, layout.OPTICS)
    for k in range(first, live):
        before = surface_of(b.hit[k])
        is_back = optics[before].side * b.mu[k] > 0.0
        chosen = before + (surfaces[before].back if is_back else 0)
        low, last, u = 0.0, chosen + surfaces[chosen].parts - 1, b.u3[k]
        while chosen < last and u >= surfaces[chosen].share:
            low = surfaces[chosen].share
            chosen += 1
        if surfaces[chosen].parts > 1:
            b.u3[k] = min((u - low) / (surfaces[chosen].share - low), 1.0 - 2.0**-53)
        if before != 0:
            bits = (chosen << layout.SURFACE_SHIFT) | (surfaces[chosen].material << layout.MATERIAL_SHIFT)
            b.hit[k] = (b.hit[k] & ~ACTING_BITS) | bits
    return live


@lane_pass(layout.NO_TABLE)
def absorb(b, table, first, live):
    """Multiply the weight by the albedo.

    `high`, `low` receive the absorbed weight as a difference of exact sums.

    Fields: reads `albedo`; updates `weight`; writes `high`, `low`.
    """
    for k in range(first, live):
        before = b.weight[k]
        after = before * b.albedo[k]
        b.high[k], b.low[k] = limbs_of_loss(before, after)
        b.weight[k] = after
    return live


@lane_pass(layout.NO_TABLE)
def account_absorbed(b, table, first, live):
    """Add the absorbed weight to the ledger row of each surface.

    Fields: reads `hit`, `high`, `low`.
    """
    rows = b.ledger + 32 * layout.ABSORBED
    for k in range(first, live):
        surface = surface_of(b.hit[k])
        add_to_row(rows + 32 * surface, b.high[k], b.low[k], 0, 0)
    return live


@lane_pass(layout.NO_TABLE)
def draw_uniforms(b, table, first, live):
    """Draw one random block (u0, u1, u2) for all samples of this event.

    Fields: reads `history`, `hit`; updates `event`; writes `u0`, `u1`, `u2`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = event_words(b.history[k], batch, b.event[k], EVENT, seed_low, seed_high)
        b.u0[k], b.u1[k], b.u2[k] = uniform(w0, w1), short_uniform(w2), uniform(w3, w2)
        b.event[k] += 1 if b.hit[k] != 0 else 0
    return live


@lane_pass(layout.NO_TABLE)
def reflect_diffusely(b, table, first, live):
    """Sample a direction by the cosine law about the normal on the side of arrival (material DIFFUSE).

    Fields: reads `hit`, `nx, ny, nz`, `u0`, `u1`; updates `ux, uy, uz`, `mu`.
    """
    for k in range(first, live):
        flip = -1.0 if b.mu[k] > 0.0 else 1.0
        nx, ny, nz = flip * b.nx[k], flip * b.ny[k], flip * b.nz[k]
        ux, uy, uz, mu = sample_cosine_law(nx, ny, nz, b.u0[k], b.u1[k])
        here = material_of(b.hit[k]) == layout.DIFFUSE
        b.ux[k], b.uy[k], b.uz[k] = select(here, ux, uy, uz, b.ux[k], b.uy[k], b.uz[k])
        b.mu[k] = flip * mu if here else b.mu[k]
    return live


@lane_pass(layout.NO_TABLE)
def reflect_specularly(b, table, first, live):
    """Reflect the direction at the normal (material MIRROR).

    Fields: reads `hit`, `nx, ny, nz`; updates `ux, uy, uz`, `event`, `mu`.
    """
    for k in range(first, live):
        ux, uy, uz = reflected(b.ux[k], b.uy[k], b.uz[k], b.nx[k], b.ny[k], b.nz[k], b.mu[k])
        here = material_of(b.hit[k]) == layout.MIRROR
        b.ux[k], b.uy[k], b.uz[k] = select(here, ux, uy, uz, b.ux[k], b.uy[k], b.uz[k])
        b.mu[k] = -b.mu[k] if here else b.mu[k]
        b.event[k] += 1 if here else 0
    return live


@lane_pass(layout.NO_TABLE)
def count_reflections(b, table, first, live):
    """Count the reflection of lanes at an acting surface.

    Fields: reads `hit`; updates `reflections`.
    """
    for k in range(first, live):
        acts = material_of(b.hit[k]) != layout.TRANSPARENT
        b.reflections[k] += 1 if acts else 0
    return live


@lane_pass(layout.NO_TABLE)
def kill_endless(b, table, first, live):
    """End a history of MAX_EVENTS events as lost: the scene confines light and absorbs none.

    Fields: reads `event`; updates `weight`, `killed`.
    """
    any_endless = 0
    for k in range(first, live):
        any_endless |= 1 if (b.event[k] >= MAX_EVENTS) & (b.weight[k] != 0.0) else 0
    if any_endless != 0:
        for k in range(first, live):
            if b.event[k] >= MAX_EVENTS and b.weight[k] != 0.0:
                add_lost(b, b.weight[k])
                b.weight[k] = 0.0
                b.killed += 1
    return live
