"""Compaction of lanes: fill gaps of ended lanes; in media, a queue for lanes at a surface."""

import math

import numpy as np
from numba import int64, uint64

from transport.compile import layout
from transport.engine.bodies import bundle_pass, lane_at, nothing
from transport.engine.bundle import CARRIED, CARRIED_WORDS, LANES, PITCH, view
from transport.physics.device import device

# fields moved at once by `move_lanes`, so that both lane numbers are fetched once per group
FIELDS_PER_GROUP = 4
# numbers of scratch fields that fill up a group: nothing reads them before they are written anew
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
def move_lanes(lanes, table, count, place):
    """Move the lanes in `movers` to those from `place` on, or to those in `listed` where it is -1."""
    fields = view(lanes.arena + table.fields, table.count, np.int64)
    words = view(lanes.address, CARRIED_WORDS + FIELDS * PITCH, np.int64)
    for f in range(0, table.count, FIELDS_PER_GROUP):
        r0, r1, r2, r3 = field_offsets(fields, f)
        for j in range(uint64(count)):
            here = uint64(place) + j if place >= 0 else uint64(lane_at(lanes, j).listed)
            there = uint64(lane_at(lanes, j).movers)
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
    """List lanes with a particle; returns their number."""
    movers = uint64(0)
    for k in range(uint64(first), uint64(last)):
        lane_at(lanes, movers).movers = k
        movers += uint64(1) if lane_at(lanes, k).weight != 0.0 else uint64(0)
    return movers


@device
def is_finite(lane):
    """Return whether position, direction and weight are finite."""
    return abs(lane.x + lane.y + lane.z + lane.ux + lane.uy + lane.uz + lane.weight) < math.inf


# ---- Compaction. A particle by itself has no other lanes, and does nothing (`alone=nothing`).


@bundle_pass(layout.FIELD_MOVES, alone=nothing)
def compact_lanes(lanes, table, first, live):
    """Drop ended lanes (weight 0): move the last live lanes into their gaps; `first` is 0.

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
    move_lanes(lanes, table, gaps, -1)
    return alive


# ---- The queue of programs with collisions: lanes at a surface wait from LANES on, while the others fly on.


@device
def flies_on(lane):
    """Return whether a lane flies on in its medium: alive, without a surface ahead, and finite."""
    return (lane.weight != 0.0) & (lane.hit == 0) & (lane.distance < math.inf) & is_finite(lane)


@bundle_pass(layout.QUEUE, alone=nothing)
def queue_arrivals(lanes, table, first, live):
    """Move lanes that do not fly on to the queue, and drop ended lanes; returns the number of lanes kept.

    `first` is 0. Few ended lanes stay as in `compact_lanes`.
    """
    ended, leaving = 0, 0
    for k in range(uint64(live)):
        lane = lane_at(lanes, k)
        lane.leaves = 0 if flies_on(lane) else 1
        ended += 1 if lane.weight == 0.0 else 0
        leaving += lane.leaves
    if leaving == ended and ended * 16 < int64(live):
        return int64(live)
    # List the lanes that leave, and those of them that arrived somewhere.
    flying = int64(live) - leaving
    others, arrived, gaps = uint64(0), uint64(0), uint64(0)
    for k in range(uint64(live)):  # no branch, so no misprediction
        lane_at(lanes, others).listed = k
        others += uint64(lane_at(lanes, k).leaves)
    for j in range(others):
        k = lane_at(lanes, j).listed
        lane_at(lanes, arrived).movers = k
        arrived += uint64(1) if lane_at(lanes, uint64(k)).weight != 0.0 else uint64(0)
        gaps += uint64(1) if k < flying else uint64(0)
    move_lanes(lanes, table.arriving, arrived, int64(LANES) + lanes.waiting)
    lanes.waiting += int64(arrived)
    # The last lanes in flight fill the gaps.
    movers = uint64(0)
    for k in range(uint64(flying), uint64(live)):
        lane_at(lanes, movers).movers = k
        movers += uint64(1 - lane_at(lanes, k).leaves)
    move_lanes(lanes, table.flying, gaps, -1)
    return flying


@bundle_pass(layout.FIELD_MOVES, alone=nothing)
def resume_flights(lanes, table, first, live):
    """Move what is left of the queue to free lanes behind those in flight."""
    resumed = list_movers(lanes, first, live)
    move_lanes(lanes, table, resumed, lanes.flying)
    lanes.flying += int64(resumed)
    lanes.waiting = 0
    return int64(live)
