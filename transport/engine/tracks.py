"""Tracks for pictures: each flight is recorded by the engine that flies it."""

from transport.compile.layout import NO_TABLE, SURFACE_MASK, SURFACE_SHIFT, WAY
from transport.engine.addresses import view
from transport.engine.passes import lane_pass

WAY_BYTES = WAY.itemsize


@lane_pass(NO_TABLE)
def write_ways(b, table, first, live):
    """Record each flight of this round, after volumes.reach_next; without room it is only counted.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `history`, `start`, `distance`, `hit`, `reach`; updates
    `walked`.
    """
    for k in range(first, live):
        if b.weight[k] != 0.0 and b.reach[k] > b.start[k]:
            if b.walked < b.ways_room:
                row = view(b.ways + WAY_BYTES * b.walked, 1, WAY)[0]
                row.x, row.y, row.z = b.x[k], b.y[k], b.z[k]
                row.ux, row.uy, row.uz = b.ux[k], b.uy[k], b.uz[k]
                row.start, row.reach, row.weight = b.start[k], b.reach[k], b.weight[k]
                row.history = b.history[k]
                is_end = b.reach[k] == b.distance[k]
                row.met = 1 if is_end and ((b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK) != 0 else 0
            b.walked += 1
    return live
