"""Reader of scene objects from JSON data, checked as in Python; errors name the path in the file."""

from __future__ import annotations

import re

from transport.io.json.kinds import KINDS, UNWRITTEN, arrays_of, fields_of
from transport.io.json.numbers import array_read, number_read
from transport.io.json.text import joined, refuse_at, said
from transport.validation import SceneError, suggestion

WORDS = {  # keys that mark the meaning of a JSON object, with the keys allowed beside them
    "type": set(),
    "shared": {"shared"},
    "float": {"float"},
    "base64": {"base64", "dtype", "shape"},
    "constant": {"constant", "shape"},
}
ARRAYS = ("base64", "constant")
TITLED = re.compile(r"^(\w+) '([^']+)': ")  # the part that an error message names
NAMED = re.compile(r"^[^:]*: (?:unknown parameter )?(\w+)")  # the field that an error message starts with


class Reader:
    """Makes objects from data; `shared` holds the data of objects that are written once and used by name."""

    def __init__(self, shared: dict[str, object]) -> None:
        self._shared = shared
        self._made: dict[str, object] = {}
        self._under_way: list[str] = []

    def value(self, data: object, path: str, may_be_array: bool = False) -> object:
        """Return the value of the data: lists become tuples, {"type": ...} an object.

        Raises SceneError with the path.
        """
        if isinstance(data, list):
            if not any(isinstance(item, dict | list) for item in data):
                return _plain(data, path)
            return tuple(self.value(item, f"{path}[{place}]") for place, item in enumerate(data))
        return self._of_words(data, path, may_be_array) if isinstance(data, dict) else data

    def check_shared(self) -> None:
        """Raise SceneError for wrong shared objects, including unused ones."""
        for name in self._shared:
            self._reference(name, "")

    def _of_words(self, data: dict, path: str, may_be_array: bool = False) -> object:
        """Return the value of a JSON object, by the key that marks its meaning."""
        word = next((word for word in WORDS if word in data), None)
        if word is None:
            refuse_at(path, f'it has no "type", got {said(data)}; write {{"type": "...", ...}}')
        if word == "type":
            return self._object(data, path)
        for name in sorted(data.keys() - WORDS[word]):
            refuse_at(joined(path, name), f"{said(name)} does not go with {word!r}; leave it out")
        if word == "shared":
            return self._reference(data["shared"], path)
        if word in ARRAYS and not may_be_array:
            refuse_at(path, f"takes no array, got {said(data)}; write numbers or lists of them")
        try:
            return number_read(data) if word == "float" else array_read(data)
        except ValueError as error:
            refuse_at(path, str(error))

    def _object(self, data: dict, path: str) -> object:
        name = data["type"]
        if not isinstance(name, str) or name not in KINDS:
            if isinstance(name, str) and name in UNWRITTEN:
                refuse_at(joined(path, "type"), f"{name} {UNWRITTEN[name]}")
            refuse_at(joined(path, "type"), f"unknown type {said(name)}; {suggestion(name, KINDS)}")
        if "self" in data:  # would clash with the first argument of Python's methods
            refuse_at(joined(path, "self"), f"{name}: unknown parameter self; leave it out")
        arrays = arrays_of(KINDS[name])
        values = {
            field: self.value(inner, joined(path, field), field in arrays)
            for field, inner in data.items()
            if field != "type"
        }
        try:
            return KINDS[name](**values)
        except SceneError as error:
            refuse_at(_blamed(KINDS[name], values, str(error), path), str(error))

    def _reference(self, name: object, path: str) -> object:
        """Return the shared object of that name; makes it at the first use."""
        if not isinstance(name, str) or name not in self._shared:
            refuse_at(path, f"no shared object {said(name)}; {suggestion(name, self._shared)}")
        if name in self._under_way:
            refuse_at(joined("shared", name), f"contains itself, through {', '.join(self._under_way[-5:])}")
        if name not in self._made:
            self._under_way.append(name)
            self._made[name] = self._shared_object(name)
            self._under_way.pop()
        return self._made[name]

    def _shared_object(self, name: str) -> object:
        data, path = self._shared[name], joined("shared", name)
        if not isinstance(data, dict):
            refuse_at(path, f'must be an object, got {said(data)}; write {{"type": "...", ...}}')
        return self._of_words(data, path)


def _plain(data: list[object], path: str) -> tuple[object, ...]:
    """Return a list of numbers, strings and null as a tuple; booleans, 1 and 0 to NumPy, are errors."""
    if bool in set(map(type, data)):
        place = next(place for place, item in enumerate(data) if isinstance(item, bool))
        refuse_at(f"{path}[{place}]", f"must be a number, got {data[place]}; write {data[place]:d}")
    return tuple(data)


def _blamed(kind: type, values: dict, problem: str, path: str) -> str:
    """Return the path of the field that an error message names first, or else of the whole object.

    The message of a scene may be about one of its parts, which it calls by type and name.
    """
    if titled := TITLED.match(problem):
        for name, parts in values.items():
            for place, part in enumerate(parts if isinstance(parts, tuple) else ()):
                if (type(part).__name__, getattr(part, "name", None)) == titled.groups():
                    return _blamed(type(part), {}, problem, joined(path, f"{name}[{place}]"))
    names = {field.name for field in fields_of(kind)} | values.keys()
    found = NAMED.match(problem)
    return joined(path, found[1]) if found and found[1] in names else path
