"""Acting surfaces: absorb, choose the part of a mixture, reflect; limit of events."""

from numba import uint64

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import add_to_row, view
from transport.engine.tally import add_lost, limbs_of_loss
from transport.engine.words import event_block, words_of_block
from transport.physics.device import choose, device
from transport.physics.directions import sample_cosine_law, select
from transport.physics.interfaces import reflected
from transport.physics.streams import EVENT, WALL, short_uniform, uniform

MAX_EVENTS = 1 << 24  # after which a history ends as lost


@lane_pass(layout.ROWS)
def look_up_surface(lane, table):
    """Set the albedo of the acting surface; row 0 transmits everything."""
    surfaces = view(lane.arena + table.rows, table.count, layout.SURFACE)
    lane.albedo = surfaces[uint64(lane.surface)].albedo


@lane_pass(layout.NO_TABLE, before=event_block(WALL))
def draw_second_block(lane, table):
    """Draw a second random block (u3, u4), for mixtures and thermal walls."""
    w0, w1, w2, w3 = words_of_block(lane)
    lane.u3, lane.u4 = uniform(w0, w1), uniform(w2, w3)


@lane_pass(layout.TWO_ROWS)
def choose_material(lane, table):
    """Choose the material of the side that was hit.

    Of a mixture, one part with the probability of its share.

    The hit becomes that of the chosen row. The uniform u3 is rescaled within the part's share and reused.
    """
    surfaces = view(lane.arena + table.rows, table.count, layout.SURFACE)
    optics = view(lane.arena + table.others, table.other_count, layout.OPTICS)
    before = lane.surface
    is_back = optics[before].side * lane.mu > 0.0
    chosen = before + (surfaces[before].back if is_back else 0)
    low, last, u = 0.0, chosen + surfaces[chosen].parts - 1, lane.u3
    while chosen < last and u >= surfaces[chosen].share:
        low = surfaces[chosen].share
        chosen += 1
    if surfaces[chosen].parts > 1:
        lane.u3 = min((u - low) / (surfaces[chosen].share - low), 1.0 - 2.0**-53)
    if before != 0:
        lane.surface, lane.material = chosen, surfaces[chosen].material


@lane_pass(layout.NO_TABLE)
def absorb(lane, table):
    """Multiply the weight by the albedo.

    `high`, `low` receive the absorbed weight as a difference of exact sums.
    """
    before = lane.weight
    after = before * lane.albedo
    lane.high, lane.low = limbs_of_loss(before, after)
    lane.weight = after


@lane_pass(layout.NO_TABLE)
def account_absorbed(lane, table):
    """Add the absorbed weight to the ledger row of each surface."""
    rows = lane.ledger + 32 * layout.ABSORBED
    surface = lane.surface
    add_to_row(rows + 32 * surface, lane.high, lane.low, 0, 0)


@lane_pass(layout.NO_TABLE, before=event_block(EVENT))
def draw_uniforms(lane, table):
    """Draw one random block (u0, u1, u2) for all samples of this event."""
    w0, w1, w2, w3 = words_of_block(lane)
    lane.u0, lane.u1, lane.u2 = uniform(w0, w1), short_uniform(w2), uniform(w3, w2)
    lane.event += 1 if lane.hit != 0 else 0


@lane_pass(layout.NO_TABLE)
def reflect_diffusely(lane, table):
    """Sample a direction by the cosine law about the normal on the side of arrival (material DIFFUSE)."""
    flip = -1.0 if lane.mu > 0.0 else 1.0
    nx, ny, nz = flip * lane.nx, flip * lane.ny, flip * lane.nz
    ux, uy, uz, mu = sample_cosine_law(nx, ny, nz, lane.u0, lane.u1)
    here = lane.material == layout.DIFFUSE
    lane.ux, lane.uy, lane.uz = select(here, ux, uy, uz, lane.ux, lane.uy, lane.uz)
    lane.mu = choose(here, flip * mu, lane.mu)


@lane_pass(layout.NO_TABLE)
def reflect_specularly(lane, table):
    """Reflect the direction at the normal (material MIRROR)."""
    ux, uy, uz = reflected(lane.ux, lane.uy, lane.uz, lane.nx, lane.ny, lane.nz, lane.mu)
    here = lane.material == layout.MIRROR
    lane.ux, lane.uy, lane.uz = select(here, ux, uy, uz, lane.ux, lane.uy, lane.uz)
    lane.mu = choose(here, -lane.mu, lane.mu)
    lane.event += 1 if here else 0


@lane_pass(layout.NO_TABLE)
def count_reflections(lane, table):
    """Count the reflection of lanes at an acting surface."""
    acts = lane.material != layout.TRANSPARENT
    lane.reflections += 1 if acts else 0


@device
def is_endless(lane, table):
    """Return whether a history has had too many events."""
    return (lane.event >= MAX_EVENTS) & (lane.weight != 0.0)


@lane_pass(layout.NO_TABLE, when=is_endless)
def kill_endless(lane, table):
    """End a history of MAX_EVENTS events as lost: the scene confines light and absorbs none."""
    add_lost(lane, lane.weight)
    lane.weight = 0.0
    lane.killed += 1
