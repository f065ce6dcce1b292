"""Numbers in JSON, bit for bit: the shortest text that reads back as the same double, or {"float": "inf"}.

Small arrays are nested lists.  Large ones are the base64 of their bytes, little-endian in C order, with dtype
and shape.  A constant array is its number with a shape.
"""

import base64
import binascii
import math

import numpy as np

from transport.io.json.text import value_text
from transport.statistics.chunked import MIN_FREE, available_memory, size_text
from transport.validation import as_float

MAX_LISTED_NUMBERS = 64  # largest array written as lists
DTYPES = ("float64", "float32", "int64", "int32", "uint8")
NON_FINITE = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}
MAX_NUMBERS = 1 << 33  # largest array that a file may request by its shape
BYTES_PER_NUMBER = 16  # bytes per number while a scene is read


def number_to_json(number: float) -> float | dict[str, str]:
    """Return a float as a JSON number, or {"float": "inf"}."""
    return float(number) if math.isfinite(number) else {"float": repr(float(number))}


def array_to_json(array: np.ndarray) -> object:
    """Return an array of finite numbers as JSON data."""
    if array.size > 1 and not any(array.strides):
        return {"constant": array.flat[0].item(), "shape": list(array.shape)}
    if array.size <= MAX_LISTED_NUMBERS:
        return array.tolist()
    data = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).tobytes()
    return {"dtype": array.dtype.name, "shape": list(array.shape), "base64": base64.b64encode(data).decode()}


def number_from_json(data: dict) -> float:
    """Return the number of {"float": "inf"}.  Raises ValueError for another text."""
    word = data["float"]
    if not isinstance(word, str) or word not in NON_FINITE:
        raise ValueError(
            f'float must be "inf", "-inf" or "nan", got {value_text(word)}; write other numbers as they are'
        )
    return NON_FINITE[word]


def array_from_json(data: dict) -> np.ndarray:
    """Return the array of {"dtype", "shape", "base64"} or {"constant", "shape"}.

    Raises ValueError for wrong data.
    """
    shape = data.get("shape")
    if not isinstance(shape, list) or not shape or not all(type(n) is int and n > 0 for n in shape):
        raise ValueError(f"shape must be a list of whole numbers above 0, got {value_text(shape)}")
    _check_size(shape)
    if "constant" in data:
        return _constant(data["constant"], shape)
    if data.get("dtype") not in DTYPES:
        raise ValueError(f"dtype must be one of {', '.join(DTYPES)}, got {value_text(data.get('dtype'))}")
    dtype = np.dtype(data["dtype"])
    try:
        content = base64.b64decode(data["base64"], validate=True)
    except (TypeError, ValueError, binascii.Error):
        raise ValueError("base64 must be the base64 of an array's bytes, without blanks") from None
    if len(content) != math.prod(shape) * dtype.itemsize:
        must = f"base64 must hold {math.prod(shape) * dtype.itemsize} bytes, {dtype} of shape {shape}"
        raise ValueError(f"{must}, got {len(content)}")
    return np.frombuffer(content, dtype.newbyteorder("<")).astype(dtype).reshape(shape)


def _check_size(shape: list[int]) -> None:
    """Raise ValueError if the array does not fit into memory: a short text may request a huge array."""
    count = math.prod(shape)
    request = f"shape {value_text(shape)} requests {float(min(count, 10**300)):.3g} numbers"
    if count > MAX_NUMBERS:
        raise ValueError(f"{request}, more than any scene needs; take fewer, at most {MAX_NUMBERS:.3g}")
    need, left = BYTES_PER_NUMBER * count, available_memory() if BYTES_PER_NUMBER * count > MIN_FREE else None
    if left is not None and need > left:
        figures = f"{size_text(need)} while reading, but {size_text(left)} of memory are left"
        raise ValueError(f"{request}, {figures}; take fewer")


def _constant(number: object, shape: list[int]) -> np.ndarray:
    value = as_float(number)
    if value is None:
        raise ValueError(f"constant must be a number, got {value_text(number)}")
    return np.broadcast_to(np.float64(value), shape)
