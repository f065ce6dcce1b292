"""The stream that a battery of tests reads is made of the words that the engine draws, none of them twice."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from tests.bench.random_stream import ORDERS, chunks
from tests.test_streams import reference


@pytest.mark.parametrize(
    ("order", "second"),
    [
        ("lives", (0, 0, 0, 1, 7)),
        ("histories", (1, 0, 0, 0, 7)),
        ("batches", (0, 1, 0, 0, 7)),
        ("seeds", (0, 0, 0, 0, 8)),
    ],
)
def test_what_comes_next_is_what_the_order_says(order, second):
    """The first two blocks are Philox's of (history, batch, event, purpose; seed)."""
    words = next(chunks(order, 7, 2))
    for found, (*counter, seed) in zip(words.tolist(), [(0, 0, 0, 0, 7), second], strict=True):
        assert found == list(reference(*counter, seed, 0))


@pytest.mark.parametrize("order", ORDERS)
def test_no_block_comes_twice_and_chunks_go_on_where_the_last_ended(order):
    parts = np.concatenate(list(islice(chunks(order, 1, 5000), 8)))
    assert (parts == next(chunks(order, 1, 40_000))).all()
    assert len(np.unique(parts, axis=0)) == 40_000
