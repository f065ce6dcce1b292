"""Path lengths by medium: each lane keeps the length of its path so far in each medium that a detector names.

The lengths stand in the carried fields `path_0`, `path_1` ..., which passes address by number: a program
moves as many of them with its lanes as its detectors name media.
"""

import numpy as np

from transport.compile.detectors import PATH_UNIT, PATHS
from transport.engine.bodies import LANE_FIELDS, lane_pass, lane_value, set_lane_value
from transport.engine.bundle import view
from transport.engine.passes.detectors import has_bin
from transport.engine.tally import add_long
from transport.physics.device import device

FIRST = LANE_FIELDS.index("path_0")


@device
def path(lane, number):
    """Return the path length of that number."""
    return lane_value(lane, FIRST + number)


@device
def set_path(lane, number, length):
    """Set the path length of that number."""
    set_lane_value(lane, FIRST + number, length)


@lane_pass(PATHS)
def reset_path(lane, table):
    """Begin the path of one number at length 0."""
    set_path(lane, table.number, 0.0)


@lane_pass(PATHS)
def follow_paths(lane, table):
    """Add the length of the flight to the path in its medium; ended lanes have none."""
    numbers = view(lane.arena + table.rows, table.count, np.int64)
    length, number = lane.flight_end - lane.start, numbers[lane.medium]
    if (length > 0.0) & (number >= 0):
        set_path(lane, number, path(lane, number) + length)


@lane_pass(PATHS, when=has_bin)
def score_paths_by_medium(lane, table):
    """Add the weight, and weight times path length in each medium, to the long sums of the lanes with a bin.

    Only a ray along an infinite plane is longer than PATH_UNIT; its path is cut there.
    """
    row = lane.moments + 32 * (table.each * lane.bin + table.place)
    add_long(row, lane.weight)
    for number in range(table.media):
        add_long(row + 32 * (1 + number), lane.weight * min(path(lane, number) / PATH_UNIT, 1.0))
