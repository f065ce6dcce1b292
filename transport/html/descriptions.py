"""A user's object in few words: its kind and the parameters that differ from their defaults."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping

import numpy as np

from transport.units import speed_of_light
from transport.validation import shown

DEEPEST = 4  # levels of nested objects that are written out


def described(thing: object, without: Collection[str] = (), depth: int = DEEPEST) -> str:
    """The object as code that would make it, such as "Sphere(radius=0.5)", shortened if it is long.

    without: parameters to leave out.
    """
    if isinstance(thing, Mapping):
        return (
            "{"
            + ", ".join(f"{described(k, (), depth)}: {described(v, (), depth)}" for k, v in thing.items())
            + "}"
        )
    if not dataclasses.is_dataclass(thing) or _has_words_of_its_own(thing):
        return _value(thing)
    if depth == 0:
        return f"{type(thing).__name__}(...)"
    given = [
        f"{field.name}={described(getattr(thing, field.name), (), depth - 1)}"
        for field in dataclasses.fields(thing)
        if field.init
        and field.repr
        and field.name not in without
        and not _is_default(field, getattr(thing, field.name))
    ]
    return f"{type(thing).__name__}({', '.join(given)})"


def _has_words_of_its_own(thing: object) -> bool:
    """Whether it holds arrays or code and its class defines its own text: a mesh, for example."""
    is_generated = hasattr(
        type(thing).__repr__, "__wrapped__"
    )  # a dataclass's generated __repr__ is wrapped, against infinite recursion
    parts = (getattr(thing, field.name) for field in dataclasses.fields(thing))
    return not is_generated and any(isinstance(part, np.ndarray) or callable(part) for part in parts)


def _value(thing: object) -> str:
    """A number or text; whole numbers without a decimal point, long lists shortened."""
    if isinstance(thing, float) and thing.is_integer() and abs(thing) < 1e15:
        return str(int(thing))
    if isinstance(thing, tuple) and 0 < len(thing) <= 6:
        return f"({', '.join(described(part, (), 2) for part in thing)}{',' if len(thing) == 1 else ''})"
    return shown(thing)


def _is_default(field: dataclasses.Field, value: object) -> bool:
    if isinstance(value, np.ndarray):
        return False
    if field.name == "speed" and value == speed_of_light:  # the default speed of light sources
        return True
    if field.default is not dataclasses.MISSING:
        return value is field.default or value == field.default
    return field.default_factory is not dataclasses.MISSING and value == field.default_factory()
