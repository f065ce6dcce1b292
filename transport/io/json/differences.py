"""Differences between two scenes as text: "surfaces[2].material.albedo: 0.5 instead of 0.4"."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from transport.scene.phase_functions import PiecewiseLinear
from transport.validation import short_repr

MAX_LISTED = 10  # differences listed one by one


def differences(one: object, other: object) -> list[str]:
    """Return the differences of `one` from `other`, one line each; empty if they are equal bit for bit.

    Parts with names are compared by name.  Beyond ten differences the rest is counted.
    """
    found = list(_differences(one, other, ""))
    rest = len(found) - MAX_LISTED
    return found[:MAX_LISTED] + ([f"and {rest} more"] if rest > 0 else [])


def are_identical(one: object, other: object) -> bool:
    """Return whether two values are equal bit for bit: 0.0 and -0.0 differ, nan equals nan."""
    return next(_differences(one, other, ""), None) is None


def _differences(one: object, other: object, path: str) -> Iterator[str]:
    if one is other:
        return
    if type(one) is not type(other):
        yield _difference_text(one, other, path)
    elif isinstance(one, tuple | list):
        yield from _list_differences(one, other, path)
    elif isinstance(one, np.ndarray):
        yield from _array_differences(one, other, path)
    elif isinstance(one, float):
        if one.hex() != other.hex():
            yield _difference_text(one, other, path)
    elif dataclasses.is_dataclass(one):
        for field in dataclasses.fields(one):
            if field.init:
                inner = f"{path}.{field.name}".lstrip(".")
                yield from _differences(getattr(one, field.name), getattr(other, field.name), inner)
    elif isinstance(one, PiecewiseLinear):
        yield from _array_differences(one.values, other.values, path)
    elif one != other:
        yield _difference_text(one, other, path)


def _list_differences(one: tuple, other: tuple, path: str) -> Iterator[str]:
    names, others = ([getattr(part, "name", None) for part in parts] for parts in (one, other))
    if names != others and None not in (*names, *others):
        both = (dict(zip(known, parts, strict=True)) for known, parts in ((names, one), (others, other)))
        yield from _named_differences(*both, path)
    elif len(one) != len(other):
        yield f"{path}: {len(one)} instead of {len(other)}"
    else:
        for place, pair in enumerate(zip(one, other, strict=True)):
            yield from _differences(*pair, f"{path}[{place}]")


def _named_differences(one: dict[str, object], other: dict[str, object], path: str) -> Iterator[str]:
    """Yield the names that only one of two lists has, then the differences of parts with equal names."""
    for word, only in (("also has", one.keys() - other.keys()), ("lacks", other.keys() - one.keys())):
        if only:
            yield f"{path}: {word} {', '.join(map(repr, sorted(only)))}"
    if one.keys() == other.keys():
        yield f"{path}: in another order"
    for place, (name, part) in enumerate(one.items()):
        if name in other:
            yield from _differences(part, other[name], f"{path}[{place}]")


def _array_differences(one: np.ndarray, other: np.ndarray, path: str) -> Iterator[str]:
    if one.shape != other.shape:
        yield f"{path}: an array of shape {one.shape} instead of {other.shape}"
        return
    unlike = (one != other) | (np.signbit(one) != np.signbit(other))
    unlike &= ~(np.isnan(one) & np.isnan(other))
    if unlike.any():
        place = tuple(int(k) for k in np.argwhere(unlike)[0])
        where = f"{path}{list(place)}"
        more = f", and {int(unlike.sum()) - 1} more of its numbers" if unlike.sum() > 1 else ""
        yield _difference_text(one[place].item(), other[place].item(), where) + more


def _difference_text(one: object, other: object, path: str) -> str:
    difference = f"{_value_text(one)} instead of {_value_text(other)}"
    return f"{path}: {difference}" if path else difference


def _value_text(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    return "nothing" if value is None else short_repr(value)
