"""Keep the living together: the last lanes move into the gaps that the ended ones left; in media, those of a kind."""

import numpy as np
from numba import int64, uint64

from transport.compile.layout import MOVED
from transport.engine.addresses import view
from transport.engine.bundle import CARRIED, CARRIED_WORDS, PITCH
from transport.engine.passes import lane_pass

FIELDS = len(CARRIED)


@lane_pass(MOVED)
def fill_gaps(b, table, first, live):
    """Returns the number of lanes that are kept.  All fields that the program names move: a new one cannot be forgotten.

    A few ended lanes are kept idle: at weight 0 they are never counted, and moving costs more than they do.
    """
    ended = 0
    for k in range(live):
        ended += 1 if b.weight[k] == 0.0 else 0
    alive = int64(live) - ended
    if ended * 16 < int64(live) or alive == 0:
        return alive + ended if alive > 0 else 0
    gaps = 0
    for k in range(uint64(alive)):  # no branch, so nothing to mispredict
        b.listed[gaps] = k
        gaps += 1 if b.weight[k] == 0.0 else 0
    movers = 0
    for k in range(uint64(alive), uint64(live)):
        b.movers[movers] = k
        movers += 1 if b.weight[k] != 0.0 else 0
    fields = view(table.fields, table.count, np.int64)
    words = view(b.address, CARRIED_WORDS + FIELDS * PITCH, np.int64)
    for f in range(table.count):
        row = CARRIED_WORDS + fields[f] * PITCH
        for j in range(gaps):
            words[row + b.listed[j]] = words[row + b.movers[j]]
    return alive


@lane_pass(MOVED)
def part(b, table, first, live):
    """Those that fly on in a medium come first, then those that met a surface: the rest of the program is for these alone.

    The ended ones are dropped.  Returns the number of lanes that are kept.
    """
    going, met = 0, 0
    for k in range(live):
        going += 1 if (b.weight[k] != 0.0) & (b.hit[k] == 0) else 0
        met += 1 if (b.weight[k] != 0.0) & (b.hit[k] != 0) else 0
    b.first = going // 8 * 8
    if going + met == 0:
        return 0
    gaps = 0
    for k in range(uint64(going)):  # no branch, so nothing to mispredict
        b.listed[gaps] = k
        gaps += 1 if (b.weight[k] == 0.0) | (b.hit[k] != 0) else 0
    movers = 0
    for k in range(uint64(going), uint64(live)):
        b.movers[movers] = k
        movers += 1 if (b.weight[k] != 0.0) & (b.hit[k] == 0) else 0
    fields = view(table.fields, table.count, np.int64)
    words = view(b.address, CARRIED_WORDS + FIELDS * PITCH, np.int64)
    for f in range(table.count):
        row = CARRIED_WORDS + fields[f] * PITCH
        for j in range(gaps):
            here, there = row + b.listed[j], row + b.movers[j]
            kept = words[here]
            words[here] = words[there]
            words[there] = kept
    end, gaps = going + met, 0
    for k in range(uint64(going), uint64(end)):
        b.listed[gaps] = k
        gaps += 1 if b.weight[k] == 0.0 else 0
    movers = 0
    for k in range(uint64(end), uint64(live)):
        b.movers[movers] = k
        movers += 1 if b.weight[k] != 0.0 else 0
    for f in range(table.count):
        row = CARRIED_WORDS + fields[f] * PITCH
        for j in range(gaps):
            words[row + b.listed[j]] = words[row + b.movers[j]]
    return end
