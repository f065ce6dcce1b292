"""Compaction of lanes: fill gaps of ended lanes; in media, sort flying lanes before those at surfaces."""

import numpy as np
from numba import int64, uint64

from transport.compile import layout
from transport.engine.bodies import bundle_pass, lane_at
from transport.engine.bundle import CARRIED, CARRIED_WORDS, PITCH, view
from transport.physics.device import device

FIELDS_PER_GROUP = 4  # fields moved at once, so that both lane numbers are fetched once per group
# numbers of scratch fields that fill up a group
PADDING = [len(CARRIED) + k for k in range(FIELDS_PER_GROUP - 1)]
FIELDS = len(CARRIED) + len(PADDING)


@device
def field_offsets(fields, f):
    """Return the offsets in words of four carried fields, unsigned so that no index is tested for sign."""
    return (
        uint64(CARRIED_WORDS + fields[f] * PITCH),
        uint64(CARRIED_WORDS + fields[f + 1] * PITCH),
        uint64(CARRIED_WORDS + fields[f + 2] * PITCH),
        uint64(CARRIED_WORDS + fields[f + 3] * PITCH),
    )


def pad_group(numbers: list[int]) -> list[int]:
    """Return the numbers of the fields to move, filled up to whole groups of FIELDS_PER_GROUP."""
    return numbers + PADDING[: -len(numbers) % FIELDS_PER_GROUP]


@device
def fill_gaps(lanes, table, gaps):
    """Move all carried fields of the lanes in `movers` to those in `listed`, four fields at a time."""
    fields = view(lanes.arena + table.fields, table.count, np.int64)
    words = view(lanes.address, CARRIED_WORDS + FIELDS * PITCH, np.int64)
    for f in range(0, table.count, FIELDS_PER_GROUP):
        r0, r1, r2, r3 = field_offsets(fields, f)
        for j in range(uint64(gaps)):
            here, there = uint64(lane_at(lanes, j).listed), uint64(lane_at(lanes, j).movers)
            words[r0 + here], words[r1 + here] = words[r0 + there], words[r1 + there]
            words[r2 + here], words[r3 + here] = words[r2 + there], words[r3 + there]


@device
def list_gaps(lanes, first, last):
    """List lanes without a particle; returns their number."""
    gaps = uint64(0)
    for k in range(uint64(first), uint64(last)):  # no branch, so no misprediction
        lane_at(lanes, gaps).listed = k
        gaps += uint64(1) if lane_at(lanes, k).weight == 0.0 else uint64(0)
    return gaps


@device
def list_movers(lanes, first, last):
    """List lanes with a particle, to fill gaps."""
    movers = uint64(0)
    for k in range(uint64(first), uint64(last)):
        lane_at(lanes, movers).movers = k
        movers += uint64(1) if lane_at(lanes, k).weight != 0.0 else uint64(0)


@device
def stay(lane, table):
    """Do nothing: one particle alone has no other lanes."""


@bundle_pass(layout.FIELD_MOVES, alone=stay)
def compact_lanes(lanes, table, first, live):
    """Drop ended lanes (weight 0): move the last live lanes into their gaps.

    Returns the number of lanes kept. Every carried field that the program uses moves, so a new field cannot
    be forgotten. While less than 1/16 of the lanes have ended, they stay as idle lanes: at weight 0 they
    score nothing, and moving costs more.
    """
    ended = 0
    for k in range(uint64(live)):
        ended += 1 if lane_at(lanes, k).weight == 0.0 else 0
    alive = int64(live) - ended
    if ended * 16 < int64(live) or alive == 0:
        return alive + ended if alive > 0 else 0
    gaps = list_gaps(lanes, 0, alive)
    list_movers(lanes, alive, live)
    fill_gaps(lanes, table, gaps)
    return alive


@device
def count_reaching_surfaces(lane, table):
    """Take a particle that flies on in a medium off the crossings, where end_escaped has counted it."""
    lane.crossings -= 1 if (lane.weight != 0.0) & (lane.hit == 0) else 0


@bundle_pass(layout.FIELD_MOVES, alone=count_reaching_surfaces)
def compact_and_sort(lanes, table, first, live):
    """Sort lanes: first those that fly on in a medium (hit 0), then those at a surface; drop ended lanes.

    Sets `first` to the first lane at a surface (rounded down to a multiple of 8): the rest of the program
    runs from there on. Returns the number of lanes kept.
    """
    going, met = 0, 0
    for k in range(uint64(live)):
        lane = lane_at(lanes, k)
        going += 1 if (lane.weight != 0.0) & (lane.hit == 0) else 0
        met += 1 if (lane.weight != 0.0) & (lane.hit != 0) else 0
    lanes.first = going // 8 * 8
    lanes.crossings -= going  # intersections.end_escaped has counted these
    if going + met == 0:
        return 0
    # Swap lanes at a surface among the first `going` with flying lanes beyond them.
    gaps = uint64(0)
    for k in range(uint64(going)):  # no branch, so no misprediction
        lane = lane_at(lanes, k)
        lane_at(lanes, gaps).listed = k
        gaps += uint64(1) if (lane.weight == 0.0) | (lane.hit != 0) else uint64(0)
    movers = uint64(0)
    for k in range(uint64(going), uint64(live)):
        lane = lane_at(lanes, k)
        lane_at(lanes, movers).movers = k
        movers += uint64(1) if (lane.weight != 0.0) & (lane.hit == 0) else uint64(0)
    fields = view(lanes.arena + table.fields, table.count, np.int64)
    words = view(lanes.address, CARRIED_WORDS + FIELDS * PITCH, np.int64)
    for f in range(0, table.count, FIELDS_PER_GROUP):
        r0, r1, r2, r3 = field_offsets(fields, f)
        for j in range(gaps):
            here, there = uint64(lane_at(lanes, j).listed), uint64(lane_at(lanes, j).movers)
            k0, k1, k2, k3 = words[r0 + here], words[r1 + here], words[r2 + here], words[r3 + here]
            words[r0 + here], words[r1 + here] = words[r0 + there], words[r1 + there]
            words[r2 + here], words[r3 + here] = words[r2 + there], words[r3 + there]
            words[r0 + there], words[r1 + there], words[r2 + there], words[r3 + there] = k0, k1, k2, k3
    # Move lanes at a surface into the gaps of ended lanes.
    end = going + met
    gaps = list_gaps(lanes, going, end)
    list_movers(lanes, end, live)
    fill_gaps(lanes, table, gaps)
    return end
