"""What a particle went through before: marks of what it crossed, and detectors that count only certain histories."""

from transport.compile.layout import LAYER, LAYERS, METER, SHEET_SHIFT
from transport.engine.addresses import view
from transport.engine.passes import lane_pass


@lane_pass(LAYERS)
def mark_visit(b, table, first, live):
    """Remember that the particle was here, where a detector asks for it."""
    rows, layer = view(table.rows, table.count, LAYER), table.layer
    for k in range(first, live):
        mark = rows[b.hit[k] >> SHEET_SHIFT].mark
        b.visited[k] |= mark if ((b.hit[k] >> layer) & 1) != 0 else 0
    return live


@lane_pass(LAYERS)
def require_visits(b, table, first, live):
    """Count only what has crossed all that the meter names in `via`."""
    meters = view(table.meters, table.meter_count, METER)
    for k in range(first, live):
        if b.bin[k] != 0:
            via = meters[b.meter[k]].via
            b.bin[k] = b.bin[k] if (b.visited[k] & via) == via else 0
    return live


@lane_pass(LAYERS)
def require_reflections(b, table, first, live):
    """Count only what has reflected as often as the meter asks."""
    meters = view(table.meters, table.meter_count, METER)
    for k in range(first, live):
        if b.bin[k] != 0:
            m = meters[b.meter[k]]
            b.bin[k] = b.bin[k] if (b.reflections[k] >= m.least) & (b.reflections[k] <= m.most) else 0
    return live
