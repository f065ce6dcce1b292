"""Path lengths by medium: each lane keeps the length of its path so far in each medium that a detector names.

The lengths stand in the carried fields `path_0`, `path_1` ..., which passes address by number: a program
moves as many of them with its lanes as its detectors name media.
"""

import numpy as np
from numba import uint64

from transport.compile.detectors import PATH_UNIT, PATHS
from transport.engine.bundle import CARRIED, CARRIED_WORDS, PITCH, view
from transport.engine.registry import lane_pass
from transport.engine.tally import add_long
from transport.physics.device import device
from transport.scene.detectors import MAX_PATHS

FIRST_WORD = CARRIED_WORDS + PITCH * [name for name, _ in CARRIED].index("path_0")
PAST_WORD = FIRST_WORD + PITCH * MAX_PATHS


@device
def path_word(number):
    """Return the word of lane 0 of the path of that number; unsigned, so that no index is tested for sign."""
    return uint64(FIRST_WORD + PITCH * number)


@lane_pass(PATHS)
def reset_paths(b, table, first, live):
    """Begin all paths at length 0.

    Fields: none by name; writes `path_0` and the following.
    """
    words = view(b.address, PAST_WORD, np.float64)
    for number in range(table.media):
        word = path_word(number)
        for k in range(uint64(first), uint64(live)):
            words[word + k] = 0.0
    return live


@lane_pass(PATHS)
def follow_paths(b, table, first, live):
    """Add the length of the flight to the path in its medium; ended and waiting lanes have none.

    Fields: reads `start`, `flight_end`, `medium`; updates `path_0` and the following.
    """
    words, numbers = view(b.address, PAST_WORD, np.float64), view(table.rows, table.count, np.int64)
    for k in range(uint64(first), uint64(live)):
        length, number = b.flight_end[k] - b.start[k], numbers[b.medium[k]]
        if (length > 0.0) & (number >= 0):
            words[path_word(number) + k] += length
    return live


@lane_pass(PATHS)
def score_paths_by_medium(b, table, first, live):
    """Add the weight, and weight times path length in each medium, to the long sums of the lanes with a bin.

    Only a ray along an infinite plane is longer than PATH_UNIT; its path is cut there.

    Fields: reads `weight`, `bin`, `path_0` and the following.
    """
    words, n = view(b.address, PAST_WORD, np.float64), 0
    for k in range(first, live):
        b.listed[n] = k
        n += 1 if b.bin[k] != 0 else 0
    for j in range(n):
        k = uint64(b.listed[j])
        row = b.moments + 32 * (table.each * b.bin[k] + table.place)
        add_long(row, b.weight[k])
        for number in range(table.media):
            path = words[path_word(number) + k] / PATH_UNIT
            add_long(row + 32 * (1 + number), b.weight[k] * min(path, 1.0))
    return live
