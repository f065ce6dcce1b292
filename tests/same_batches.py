"""Whether the batches of two runs are the same to the last bit."""

import dataclasses

import numpy as np


def assert_same(one, other):
    """Every number of every batch, with its type; and what is said of it."""
    assert len(one) == len(other)
    for batch, like in zip(one, other, strict=True):
        for field in dataclasses.fields(batch):
            value, again = getattr(batch, field.name), getattr(like, field.name)
            assert type(value) is type(again), field.name
            if isinstance(value, np.ndarray):
                assert (value.dtype, value.shape, value.tobytes()) == (
                    again.dtype,
                    again.shape,
                    again.tobytes(),
                )
            else:
                assert value == again, field.name
