"""Reader of scene objects from JSON data, checked as in Python; errors name the path in the file."""

from __future__ import annotations

import re

from transport.io.json.kinds import SCENE_TYPES, UNSUPPORTED, array_fields, init_fields
from transport.io.json.numbers import array_from_json, number_from_json
from transport.io.json.text import field_path, raise_at, value_text
from transport.validation import SceneError, name_hint

MARKERS = {  # keys that mark the meaning of a JSON object, with the keys allowed beside them
    "type": set(),
    "shared": {"shared"},
    "float": {"float"},
    "base64": {"base64", "dtype", "shape"},
    "constant": {"constant", "shape"},
}
ARRAY_MARKERS = ("base64", "constant")
TITLE_PATTERN = re.compile(r"^(\w+) '([^']+)': ")  # the part that an error message names
FIELD_PATTERN = re.compile(
    r"^[^:]*: (?:unknown parameter )?(\w+)"
)  # the field that an error message starts with


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
            raise_at(
                field_path(path, "type"), f"unknown type {value_text(name)}; {name_hint(name, SCENE_TYPES)}"
            )
        if "self" in data:  # would clash with the first argument of Python's methods
            raise_at(field_path(path, "self"), f"{name}: unknown parameter self; leave it out")
        arrays = array_fields(SCENE_TYPES[name])
        values = {
            field: self.value(inner, field_path(path, field), field in arrays)
            for field, inner in data.items()
            if field != "type"
        }
        try:
            return SCENE_TYPES[name](**values)
        except SceneError as error:
            raise_at(_path_at_fault(SCENE_TYPES[name], values, str(error), path), str(error))

    def _reference(self, name: object, path: str) -> object:
        """Return the shared object of that name; makes it at the first use."""
        if not isinstance(name, str) or name not in self._shared:
            raise_at(path, f"no shared object {value_text(name)}; {name_hint(name, self._shared)}")
        if name in self._in_progress:
            raise_at(
                field_path("shared", name), f"contains itself, through {', '.join(self._in_progress[-5:])}"
            )
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
    names = {field.name for field in init_fields(kind)} | values.keys()
    found = FIELD_PATTERN.match(problem)
    return field_path(path, found[1]) if found and found[1] in names else path
