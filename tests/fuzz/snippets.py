"""A scene as the lines of Python that make it, so that what a random one has shown can be run by itself."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from transport.geometry.mesh import Mesh
from transport.scene.phase_functions import PiecewiseLinear

ALIASES = ("outside", "inside")  # of front and back


def written(value: object) -> str:
    """An expression in `tp`, `np` and `math` that makes the value again."""
    if isinstance(value, Mesh):
        arrays = f"vertices={written(value.vertices)}, faces={written(value.faces)}"
        return f"tp.Mesh({arrays})"
    if isinstance(value, PiecewiseLinear):
        return written(value.values)
    if dataclasses.is_dataclass(value):
        return f"tp.{getattr(type(value), 'written', type(value).__name__)}({', '.join(_parameters(value))})"
    if isinstance(value, np.ndarray):
        return f"np.array({value.tolist()!r})"
    if isinstance(value, tuple | list):
        return f"({', '.join(map(written, value))}{',' * (len(value) == 1)})"
    if isinstance(value, float) and not math.isfinite(value):
        return f"float({str(value)!r})"
    return repr(value)


def _parameters(value: object) -> list[str]:
    """Parameters that are not what they would be anyway, by their names."""
    found = []
    for field in dataclasses.fields(value):
        if not field.init or field.name in ALIASES:
            continue
        given = getattr(value, field.name)
        if not _is_default(field, given):
            found.append(f"{field.name}={written(given)}")
    return found


def _is_default(field: dataclasses.Field, given: object) -> bool:
    if field.default_factory is not dataclasses.MISSING:
        return given == field.default_factory()
    return (
        field.default is not dataclasses.MISSING
        and type(given) is type(field.default)
        and given == field.default
    )
