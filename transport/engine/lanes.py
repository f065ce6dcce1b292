"""Keep the living together: the last lanes move into the gaps that the ended ones left."""

import numpy as np
from numba import int64

from transport.engine.addresses import view
from transport.engine.bundle import CARRIED_WORDS, LANES
from transport.engine.passes import lane_pass
from transport.layout import MOVED


@lane_pass(MOVED)
def fill_gaps(b, table, first, live):
    """Returns the number of lanes that live on.  Every carried field moves: a new one cannot be forgotten."""
    ended = 0
    for k in range(live):  # no branch, so nothing to mispredict
        b.listed[ended] = k
        ended += 1 if b.weight[k] == 0.0 else 0
    alive = int64(live) - ended
    words = view(b.address, CARRIED_WORDS + table.fields * LANES, np.int64)
    gap = 0
    for k in range(alive, int64(live)):
        if b.weight[k] != 0.0:
            to = b.listed[gap]
            gap += 1
            for field in range(table.fields):
                row = CARRIED_WORDS + field * LANES
                words[row + to] = words[row + k]
    return alive
