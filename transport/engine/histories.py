"""Filters by history: marks of visited objects (`via`) and numbers of reflections (`events`)."""

from transport.compile.layout import LAYER, LAYERS, METER, SHEET_SHIFT
from transport.engine.addresses import view
from transport.engine.passes import lane_pass


@lane_pass(LAYERS)
def mark_visit(b, table, first, live):
    """Set the visit bit of the object at this crossing, where a detector has it in `via`.

    Fields: reads `hit`; updates `visited`.
    """
    rows, layer = view(table.rows, table.count, LAYER), table.layer
    for k in range(first, live):
        mark = rows[b.hit[k] >> SHEET_SHIFT].mark
        b.visited[k] |= mark if ((b.hit[k] >> layer) & 1) != 0 else 0
    return live


@lane_pass(LAYERS)
def require_visits(b, table, first, live):
    """Drop the bin of lanes that have not visited all objects in the detector's `via`.

    Fields: reads `visited`, `meter`; updates `bin`.
    """
    meters = view(table.meters, table.meter_count, METER)
    for k in range(first, live):
        if b.bin[k] != 0:
            via = meters[b.meter[k]].via
            b.bin[k] = b.bin[k] if (b.visited[k] & via) == via else 0
    return live


@lane_pass(LAYERS)
def require_reflections(b, table, first, live):
    """Drop the bin of lanes whose number of reflections lies outside the detector's `events`.

    Fields: reads `reflections`, `meter`; updates `bin`.
    """
    meters = view(table.meters, table.meter_count, METER)
    for k in range(first, live):
        if b.bin[k] != 0:
            m = meters[b.meter[k]]
            b.bin[k] = b.bin[k] if (b.reflections[k] >= m.least) & (b.reflections[k] <= m.most) else 0
    return live
