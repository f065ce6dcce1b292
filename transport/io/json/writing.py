"""Writer of scene objects as JSON data: {"type": "Disk", "radius": 0.5}, without fields at their default."""

from __future__ import annotations

from collections import Counter

import numpy as np

from transport.io.json.differences import are_alike
from transport.io.json.kinds import HEAVY, KINDS, UNWRITTEN, default_of, fields_of, following
from transport.io.json.numbers import array_written, number_written
from transport.io.json.text import check_characters
from transport.scene.phase_functions import PiecewiseLinear
from transport.validation import SceneError, shown


def written(part: object, shared: dict[object, str] | None = None, path: str = "") -> object:
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
            return number_written(part)
        case tuple() | list():
            return [written(item, shared, f"{path}[{place}]") for place, item in enumerate(part)]
        case np.ndarray():
            return array_written(part)
    if shared and isinstance(part, HEAVY) and part in shared:
        return {"shared": shared[part]}
    return fields_written(part, shared, path)


def fields_written(
    part: object, shared: dict[object, str] | None = None, path: str = ""
) -> dict[str, object]:
    """Return an object as {"type": ..., fields not at their default}, even if it is shared."""
    kind = type(part).__name__
    if KINDS.get(kind) is not type(part):
        why = UNWRITTEN.get(kind, "cannot be stored in a file; use the package's own types")
        raise SceneError(f"{path or kind}: {kind} {why}, got {shown(part)}")
    data: dict[str, object] = {"type": kind}
    left_out = following(part)
    # Write the name first.
    for field in sorted(fields_of(type(part)), key=lambda field: field.name != "name"):
        value = stored(part, field.name)
        if field.name not in left_out and not are_alike(value, default_of(field)):
            data[field.name] = written(value, shared, f"{path}.{field.name}".lstrip("."))
    return data


def stored(part: object, name: str) -> object:
    """Return a field as a file stores it: for a Tabulated the table instead of the function made from it."""
    value = getattr(part, name)
    return value.values if isinstance(value, PiecewiseLinear) else value


def shared_parts(part: object) -> dict[object, str]:
    """Return the heavy objects that are used several times, with names for the file, inner ones first."""
    counts: Counter = Counter()
    _count(part, counts)
    numbers: Counter = Counter()
    names = {}
    for heavy, count in counts.items():
        if count > 1:
            kind = type(heavy).__name__.lower()
            numbers[kind] += 1
            names[heavy] = f"{kind}_{numbers[kind]}"
    return names


def _count(part: object, counts: Counter) -> None:
    if isinstance(part, tuple | list):
        for item in part:
            _count(item, counts)
    elif type(part).__name__ in KINDS and part not in counts:
        left_out = following(part)
        for field in fields_of(type(part)):
            if field.name not in left_out:
                _count(getattr(part, field.name), counts)
    if isinstance(part, HEAVY):
        counts[part] += 1
