"""Writer of scene objects as JSON data: {"type": "Disk", "radius": 0.5}, without fields at their default."""

from __future__ import annotations

from collections import Counter

import numpy as np

from transport.io.json.differences import are_identical
from transport.io.json.kinds import (
    SCENE_TYPES,
    SHARED_TYPES,
    UNSUPPORTED,
    default_value,
    derived_fields,
    init_fields,
)
from transport.io.json.numbers import array_to_json, number_to_json
from transport.io.json.text import check_characters
from transport.scene.phase_functions import PiecewiseLinear
from transport.validation import SceneError, short_repr


def to_json(part: object, shared: dict[object, str] | None = None, path: str = "") -> object:
    """Return a value as JSON data, from which `reading.Reader` makes it again bit for bit.

    `shared` maps heavy objects that are written elsewhere to their names.  Raises SceneError with the path
    for a value that JSON cannot hold.
    """
    match part:
        case None | bool() | int():
            return part
        case str():
            check_characters(part, path)
            return part
        case float():
            return number_to_json(part)
        case tuple() | list():
            return [to_json(item, shared, f"{path}[{place}]") for place, item in enumerate(part)]
        case np.ndarray():
            return array_to_json(part)
    if shared and isinstance(part, SHARED_TYPES) and part in shared:
        return {"shared": shared[part]}
    return fields_to_json(part, shared, path)


def fields_to_json(
    part: object, shared: dict[object, str] | None = None, path: str = ""
) -> dict[str, object]:
    """Return an object as {"type": ..., fields not at their default}, even if it is shared."""
    kind = type(part).__name__
    if SCENE_TYPES.get(kind) is not type(part):
        why = UNSUPPORTED.get(kind, "cannot be stored in a file; use the package's own types")
        raise SceneError(f"{path or kind}: {kind} {why}, got {short_repr(part)}")
    data: dict[str, object] = {"type": kind}
    left_out = derived_fields(part)
    # Write the name first.
    for field in sorted(init_fields(type(part)), key=lambda field: field.name != "name"):
        value = stored_value(part, field.name)
        if field.name not in left_out and not are_identical(value, default_value(field)):
            data[field.name] = to_json(value, shared, f"{path}.{field.name}".lstrip("."))
    return data


def stored_value(part: object, name: str) -> object:
    """Return a field as a file stores it: for a Tabulated the table instead of the function made from it."""
    value = getattr(part, name)
    return value.values if isinstance(value, PiecewiseLinear) else value


def shared_objects(part: object) -> dict[object, str]:
    """Return the heavy objects that are used several times, with names for the file, inner ones first."""
    counts: Counter = Counter()
    _count_heavy(part, counts)
    numbers: Counter = Counter()
    names = {}
    for heavy, count in counts.items():
        if count > 1:
            kind = type(heavy).__name__.lower()
            numbers[kind] += 1
            names[heavy] = f"{kind}_{numbers[kind]}"
    return names


def _count_heavy(part: object, counts: Counter) -> None:
    if isinstance(part, tuple | list):
        for item in part:
            _count_heavy(item, counts)
    elif type(part).__name__ in SCENE_TYPES and part not in counts:
        left_out = derived_fields(part)
        for field in init_fields(type(part)):
            if field.name not in left_out:
                _count_heavy(getattr(part, field.name), counts)
    if isinstance(part, SHARED_TYPES):
        counts[part] += 1
