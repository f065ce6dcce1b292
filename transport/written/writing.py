"""Objects of a scene as JSON data: {"type": "Disk", "radius": 0.5}, the fields that are not at their default."""

from __future__ import annotations

from collections import Counter

import numpy as np

from transport.media.phases import PiecewiseLinear
from transport.validation import SceneError, shown
from transport.written.differences import are_alike
from transport.written.following import following
from transport.written.kinds import HEAVY, KINDS, UNWRITTEN, default_of, fields_of
from transport.written.numbers import array_written, number_written
from transport.written.parsing import check_characters


def written(part: object, shared: dict[object, str] | None = None, path: str = "") -> object:
    """An object, tuple, array, number, text or None as JSON data, from which `reading.Reader` makes it again, bit by bit.

    shared: heavy objects that are written elsewhere under these names.  Raises SceneError, with the path, for what is not
    declarative.
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
    """An object as {"type": ..., fields that are not at their default}, though it be shared."""
    kind = type(part).__name__
    if KINDS.get(kind) is not type(part):
        why = UNWRITTEN.get(
            kind, "is no kind of object that a file holds; make it of the package's own kinds"
        )
        raise SceneError(f"{path or kind}: {kind} {why}, got {shown(part)}")
    data: dict[str, object] = {"type": kind}
    left_out = following(part)
    for field in sorted(fields_of(type(part)), key=lambda field: field.name != "name"):  # a name comes first
        value = stored(part, field.name)
        if field.name not in left_out and not are_alike(value, default_of(field)):
            data[field.name] = written(value, shared, f"{path}.{field.name}".lstrip("."))
    return data


def stored(part: object, name: str) -> object:
    """A field as a file holds it: of a Tabulated the table, where the field has become a function."""
    value = getattr(part, name)
    return value.values if isinstance(value, PiecewiseLinear) else value


def shared_parts(part: object) -> dict[object, str]:
    """The heavy objects that are used more than once, with names to write them under, inner ones first."""
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
