"""Objects of a scene as JSON data and back, bit for bit.

An object is {"type": "Disk", "radius": 0.5}, without the fields at their default and those that follow from
others; `fields_of` is the table that writing, reading and the schema share.  A heavy object that is used
several times is written once, and {"shared": "mesh_1"} where it is used.
"""

from __future__ import annotations

import base64
import binascii
import dataclasses
import functools
import math
import re
import typing
from collections import Counter
from typing import NamedTuple

import numpy as np

from transport.geometry.mesh import Mesh
from transport.io.json.differences import are_identical
from transport.io.json.text import check_characters, field_path, raise_at, value_text
from transport.scene.bins import SYNONYMS, Positions
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Effusive, Gas, Isotropic, Lambertian
from transport.scene.materials import Surface
from transport.scene.media import Grid
from transport.scene.parts import SceneParts
from transport.scene.phase_functions import PiecewiseLinear, Tabulated
from transport.scene.speeds import Maxwellian, SpeedTable
from transport.scene.volumes import VolumeDetector
from transport.statistics.chunked import MIN_FREE, available_memory, size_text
from transport.units import speed_of_light
from transport.validation import SCENE_OBJECTS, SceneError, as_float, name_hint, parameters_of, short_repr

# ---- The types of objects in a scene, by their names in a file, and their fields.

UNSUPPORTED = {  # types that no file can hold: the reason, and what to write instead
    "InverseCDF": "holds a Python function, which no file can store;"
    " write SpeedTable(speeds=..., density=...) instead",
}
# types by name; SceneParts is the checks' name of a Scene
SCENE_TYPES = {
    name: kind for name, kind in SCENE_OBJECTS.items() if name not in UNSUPPORTED and kind is not SceneParts
}
SHARED_TYPES = (Grid, Mesh, SpeedTable, Tabulated)  # written once if used several times


class Field(NamedTuple):
    """A parameter of an object: its default is MISSING if it is required."""

    name: str
    hint: object
    default: object
    may_be_array: bool


@functools.cache
def fields_of(kind: type) -> tuple[Field, ...]:
    """Return the parameters of a type, without derived attributes."""
    hints = {
        name: hint.type if isinstance(hint, dataclasses.InitVar) else hint
        for name, hint in typing.get_type_hints(kind).items()
    }
    return tuple(
        Field(
            field.name,
            hints[field.name],
            field.default if field.default_factory is dataclasses.MISSING else field.default_factory(),
            np.ndarray in (hints[field.name], *typing.get_args(hints[field.name]))
            or (kind, field.name) == (Tabulated, "density"),  # stored as a function
        )
        for field in parameters_of(kind)
    )


def derived_fields(part: object) -> tuple[str, ...]:
    """Return the names of the fields that have the same value if omitted: they follow from the others."""
    match part:
        case Positions():
            return SYNONYMS
        case Surface():
            return ("front", "back") if part.shape.is_closed else ("outside", "inside")
        case Maxwellian(temperature=float()):
            return ("sigma",)
        case Gas(speed=Maxwellian(mass=mass)) | Effusive(speed=Maxwellian(mass=mass)) if part.mass == mass:
            return ("mass",)
        case Detector() | VolumeDetector() if part.name == part.shape:
            return ("name",)
        case Beam() | Isotropic() | Lambertian() if part.speed == speed_of_light:
            return ("speed",)
    return ()


# ---- Numbers: the shortest text that reads back as the same double, or {"float": "inf"}.
#
# Small arrays are nested lists.  Large ones are the base64 of their bytes, little-endian in C order, with
# dtype and shape.  A constant array is its number with a shape.

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


# ---- Writing.


def to_json(part: object, shared: dict[object, str] | None = None, path: str = "") -> object:
    """Return a value as JSON data, from which `Reader` makes it again bit for bit.

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
    for field in sorted(fields_of(type(part)), key=lambda field: field.name != "name"):
        value = getattr(part, field.name)
        value = value.values if isinstance(value, PiecewiseLinear) else value  # the table of a Tabulated
        if field.name not in left_out and not are_identical(value, field.default):
            data[field.name] = to_json(value, shared, f"{path}.{field.name}".lstrip("."))
    return data


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
        for field in fields_of(type(part)):
            if field.name not in left_out:
                _count_heavy(getattr(part, field.name), counts)
    if isinstance(part, SHARED_TYPES):
        counts[part] += 1


# ---- Reading: objects are checked as in Python, and errors name the path in the file.

MARKERS = {  # keys that mark the meaning of a JSON object, with the keys allowed beside them
    "type": set(),
    "shared": {"shared"},
    "float": {"float"},
    "base64": {"base64", "dtype", "shape"},
    "constant": {"constant", "shape"},
}
ARRAY_MARKERS = ("base64", "constant")
TITLE_PATTERN = re.compile(r"^(\w+) '([^']+)': ")  # the part that an error message names
# the field that an error message starts with
FIELD_PATTERN = re.compile(r"^[^:]*: (?:unknown parameter )?(\w+)")


class Reader:
    """Makes objects from data; `shared` holds the data of objects that are written once and used by name."""

    def __init__(self, shared: dict[str, object]) -> None:
        self._shared = shared
        self._made: dict[str, object] = {}
        self._in_progress: list[str] = []

    def value(self, data: object, path: str, may_be_array: bool = False) -> object:
        """Return the value of the data: lists become tuples, {"type": ...} an object.

        Raises SceneError with the path.
        """
        if isinstance(data, list):
            if not any(isinstance(item, dict | list) for item in data):
                return _plain_tuple(data, path)
            return tuple(self.value(item, f"{path}[{place}]") for place, item in enumerate(data))
        return self._marked_value(data, path, may_be_array) if isinstance(data, dict) else data

    def check_shared(self) -> None:
        """Raise SceneError for wrong shared objects, including unused ones."""
        for name in self._shared:
            self._reference(name, "")

    def _marked_value(self, data: dict, path: str, may_be_array: bool = False) -> object:
        """Return the value of a JSON object, by the key that marks its meaning."""
        word = next((word for word in MARKERS if word in data), None)
        if word is None:
            raise_at(path, f'it has no "type", got {value_text(data)}; write {{"type": "...", ...}}')
        if word == "type":
            return self._object(data, path)
        for name in sorted(data.keys() - MARKERS[word]):
            raise_at(field_path(path, name), f"{value_text(name)} does not go with {word!r}; leave it out")
        if word == "shared":
            return self._reference(data["shared"], path)
        if word in ARRAY_MARKERS and not may_be_array:
            raise_at(path, f"takes no array, got {value_text(data)}; write numbers or lists of them")
        try:
            return number_from_json(data) if word == "float" else array_from_json(data)
        except ValueError as error:
            raise_at(path, str(error))

    def _object(self, data: dict, path: str) -> object:
        name = data["type"]
        if not isinstance(name, str) or name not in SCENE_TYPES:
            if isinstance(name, str) and name in UNSUPPORTED:
                raise_at(field_path(path, "type"), f"{name} {UNSUPPORTED[name]}")
            hint = name_hint(name, SCENE_TYPES)
            raise_at(field_path(path, "type"), f"unknown type {value_text(name)}; {hint}")
        if "self" in data:  # would clash with the first argument of Python's methods
            raise_at(field_path(path, "self"), f"{name}: unknown parameter self; leave it out")
        kind = SCENE_TYPES[name]
        arrays = {field.name for field in fields_of(kind) if field.may_be_array}
        values = {
            field: self.value(inner, field_path(path, field), field in arrays)
            for field, inner in data.items()
            if field != "type"
        }
        try:
            return kind(**values)
        except SceneError as error:
            raise_at(_path_at_fault(kind, values, str(error), path), str(error))

    def _reference(self, name: object, path: str) -> object:
        """Return the shared object of that name; makes it at the first use."""
        if not isinstance(name, str) or name not in self._shared:
            raise_at(path, f"no shared object {value_text(name)}; {name_hint(name, self._shared)}")
        if name in self._in_progress:
            through = ", ".join(self._in_progress[-5:])
            raise_at(field_path("shared", name), f"contains itself, through {through}")
        if name not in self._made:
            self._in_progress.append(name)
            self._made[name] = self._shared_object(name)
            self._in_progress.pop()
        return self._made[name]

    def _shared_object(self, name: str) -> object:
        data, path = self._shared[name], field_path("shared", name)
        if not isinstance(data, dict):
            raise_at(path, f'must be an object, got {value_text(data)}; write {{"type": "...", ...}}')
        return self._marked_value(data, path)


def _plain_tuple(data: list[object], path: str) -> tuple[object, ...]:
    """Return a list of numbers, strings and null as a tuple; booleans, 1 and 0 to NumPy, are errors."""
    if bool in set(map(type, data)):
        place = next(place for place, item in enumerate(data) if isinstance(item, bool))
        raise_at(f"{path}[{place}]", f"must be a number, got {data[place]}; write {data[place]:d}")
    return tuple(data)


def _path_at_fault(kind: type, values: dict, problem: str, path: str) -> str:
    """Return the path of the field that an error message names first, or else of the whole object.

    The message of a scene may be about one of its parts, which it calls by type and name.
    """
    if titled := TITLE_PATTERN.match(problem):
        for name, parts in values.items():
            for place, part in enumerate(parts if isinstance(parts, tuple) else ()):
                if (type(part).__name__, getattr(part, "name", None)) == titled.groups():
                    return _path_at_fault(type(part), {}, problem, field_path(path, f"{name}[{place}]"))
    names = {field.name for field in fields_of(kind)} | values.keys()
    found = FIELD_PATTERN.match(problem)
    return field_path(path, found[1]) if found and found[1] in names else path
