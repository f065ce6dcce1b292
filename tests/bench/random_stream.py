"""The random words as the engine draws them, as raw bits without end, for a battery of tests to read.

    python -m tests.bench.random_stream [ORDER] [--seed 1] | dieharder -a -g 200

ORDER says what comes next to what: `lives` one history after another, of each its events with all their purposes;
`histories` the same draw of one history after another, `batches` of one batch after another, `seeds` of one seed after
another.  No block of four words comes twice before 2^60 of them.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator

import numpy as np
import typer
from numba import njit

from transport.physics.device import ARITHMETIC
from transport.physics.streams import EXPECT, random_words

COORDINATES = "history", "batch", "event", "purpose", "seed"
# How many of each coordinate go by before the next one moves on, the fastest first.
ORDERS = {
    "lives": {"purpose": EXPECT, "event": 8, "history": 1 << 20, "batch": 32, "seed": 1 << 32},
    "histories": {"history": 1 << 20, "batch": 32, "event": 8, "purpose": EXPECT, "seed": 1 << 32},
    "batches": {"batch": 1 << 10, "history": 1 << 20, "event": 8, "purpose": EXPECT, "seed": 1 << 30},
    "seeds": {"seed": 1 << 32, "history": 1 << 20, "batch": 1 << 10, "event": 8, "purpose": EXPECT},
}
BLOCKS = 1 << 16  # written at once


@njit(**ARITHMETIC)
def _words(first, count, seed, which, lengths):
    """The words of blocks `first` to `first` + count; which: the coordinate that each digit of a number counts."""
    words, place = np.empty((count, 4), np.uint32), np.zeros(5, np.int64)
    for k in range(count):
        number = first + k
        for digit in range(5):
            place[which[digit]] = number % lengths[digit]
            number //= lengths[digit]
        key = seed + place[4]
        drawn = random_words(place[0], place[1], place[2], place[3], key & 0xFFFFFFFF, key >> 32)
        words[k, 0], words[k, 1], words[k, 2], words[k, 3] = drawn
    return words


def chunks(order: str, seed: int, blocks: int = BLOCKS) -> Iterator[np.ndarray]:
    """Words (blocks, 4) of 32 bits, again and again."""
    which = np.array([COORDINATES.index(name) for name in ORDERS[order]])
    lengths = np.array(list(ORDERS[order].values()))
    first = 0
    while True:
        yield _words(first, blocks, seed, which, lengths)
        first += blocks


def main(order: str = typer.Argument("lives", help=", ".join(ORDERS)), seed: int = 1) -> None:
    """Write until the reader has had enough."""
    if order not in ORDERS:
        raise typer.BadParameter(f"no order {order!r}; there are {', '.join(ORDERS)}")
    try:
        for words in chunks(order, seed):
            sys.stdout.buffer.write(words)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for what is still to be flushed


if __name__ == "__main__":
    typer.run(main)
