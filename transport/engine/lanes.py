"""Keep the living together: the last lanes move into the gaps that the ended ones left; in media, those of a kind."""

import numpy as np
from numba import int64, uint64

from transport.compile.layout import MOVED
from transport.engine.addresses import view
from transport.engine.bundle import CARRIED, CARRIED_WORDS, PITCH
from transport.engine.passes import lane_pass
from transport.physics.device import device

TOGETHER = 4  # fields are moved at once: the numbers of both lanes are then fetched once for all of them
PADDING = [len(CARRIED) + k for k in range(TOGETHER - 1)]  # numbers of scratch fields that may move along
FIELDS = len(CARRIED) + len(PADDING)


@device
def rows_of_fields(fields, f):
    """Where four fields begin, in words; unsigned, lest indices be looked at for being negative."""
    return (
        uint64(CARRIED_WORDS + fields[f] * PITCH),
        uint64(CARRIED_WORDS + fields[f + 1] * PITCH),
        uint64(CARRIED_WORDS + fields[f + 2] * PITCH),
        uint64(CARRIED_WORDS + fields[f + 3] * PITCH),
    )


def padded(numbers: list[int]) -> list[int]:
    """The numbers of the fields to move, filled up to whole groups."""
    return numbers + PADDING[: -len(numbers) % TOGETHER]


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
    for f in range(0, table.count, TOGETHER):
        r0, r1, r2, r3 = rows_of_fields(fields, f)
        for j in range(gaps):
            here, there = uint64(b.listed[j]), uint64(b.movers[j])
            words[r0 + here], words[r1 + here] = words[r0 + there], words[r1 + there]
            words[r2 + here], words[r3 + here] = words[r2 + there], words[r3 + there]
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
    b.crossings -= going  # which flights.leave has counted
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
    for f in range(0, table.count, TOGETHER):
        r0, r1, r2, r3 = rows_of_fields(fields, f)
        for j in range(gaps):
            here, there = uint64(b.listed[j]), uint64(b.movers[j])
            k0, k1, k2, k3 = words[r0 + here], words[r1 + here], words[r2 + here], words[r3 + here]
            words[r0 + here], words[r1 + here] = words[r0 + there], words[r1 + there]
            words[r2 + here], words[r3 + here] = words[r2 + there], words[r3 + there]
            words[r0 + there], words[r1 + there], words[r2 + there], words[r3 + there] = k0, k1, k2, k3
    end, gaps = going + met, 0
    for k in range(uint64(going), uint64(end)):
        b.listed[gaps] = k
        gaps += 1 if b.weight[k] == 0.0 else 0
    movers = 0
    for k in range(uint64(end), uint64(live)):
        b.movers[movers] = k
        movers += 1 if b.weight[k] != 0.0 else 0
    for f in range(0, table.count, TOGETHER):
        r0, r1, r2, r3 = rows_of_fields(fields, f)
        for j in range(gaps):
            here, there = uint64(b.listed[j]), uint64(b.movers[j])
            words[r0 + here], words[r1 + here] = words[r0 + there], words[r1 + there]
            words[r2 + here], words[r3 + here] = words[r2 + there], words[r3 + there]
    return end
