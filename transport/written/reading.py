"""JSON data as objects of a scene, each checked as if Python had made it; what is wrong is told with its path in the file."""

from __future__ import annotations

import re

from transport.validation import SceneError, suggestion
from transport.written.kinds import KINDS, UNWRITTEN, arrays_of, fields_of
from transport.written.numbers import array_read, number_read
from transport.written.parsing import joined, refuse_at, said

WORDS = {  # by which an object of JSON says what it stands for, and what goes with them
    "type": set(),
    "shared": {"shared"},
    "float": {"float"},
    "base64": {"base64", "dtype", "shape"},
    "constant": {"constant", "shape"},
}
ARRAYS = ("base64", "constant")
TITLED = re.compile(r"^(\w+) '([^']+)': ")  # the part that a refusal is about
NAMED = re.compile(r"^[^:]*: (?:unknown parameter )?(\w+)")  # the field that a refusal begins with


class Reader:
    """Makes objects of data; `shared` holds the data of those that are written once and used under a name."""

    def __init__(self, shared: dict[str, object]) -> None:
        self._shared = shared
        self._made: dict[str, object] = {}
        self._under_way: list[str] = []

    def value(self, data: object, path: str, may_be_array: bool = False) -> object:
        """What the data stands for: lists become tuples, {"type": ...} an object.  Raises SceneError with the path."""
        if isinstance(data, list):
            if not any(isinstance(item, dict | list) for item in data):
                return _plain(data, path)
            return tuple(self.value(item, f"{path}[{place}]") for place, item in enumerate(data))
        return self._of_words(data, path, may_be_array) if isinstance(data, dict) else data

    def check_shared(self) -> None:
        """Refuse what is wrong with shared objects that nothing uses."""
        for name in self._shared:
            self._reference(name, "")

    def _of_words(self, data: dict, path: str, may_be_array: bool = False) -> object:
        """What an object of JSON stands for, by the word that says which."""
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
            refuse_at(joined(path, "type"), f"no such type, {said(name)}; {suggestion(name, KINDS)}")
        if "self" in data:  # what Python's methods call their object
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
        """The object that is shared under that name, made when it is first asked for."""
        if not isinstance(name, str) or name not in self._shared:
            refuse_at(path, f"nothing is shared as {said(name)}; {suggestion(name, self._shared)}")
        if name in self._under_way:
            refuse_at(
                joined("shared", name), f"is made of itself, by way of {', '.join(self._under_way[-5:])}"
            )
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
    """A list of numbers, texts and null; true and false, which NumPy would take for 1 and 0, stand in none."""
    if bool in set(map(type, data)):
        place = next(place for place, item in enumerate(data) if isinstance(item, bool))
        refuse_at(f"{path}[{place}]", f"must be a number, got {data[place]}; write {data[place]:d}")
    return tuple(data)


def _blamed(kind: type, values: dict, problem: str, path: str) -> str:
    """The path of the field that a refusal names first, or of the whole object where it names none of its own.

    What a scene refuses may be a part of it, which the refusal calls by its name.
    """
    if titled := TITLED.match(problem):
        for name, parts in values.items():
            for place, part in enumerate(parts if isinstance(parts, tuple) else ()):
                if (type(part).__name__, getattr(part, "name", None)) == titled.groups():
                    return _blamed(type(part), {}, problem, joined(path, f"{name}[{place}]"))
    names = {field.name for field in fields_of(kind)} | values.keys()
    found = NAMED.match(problem)
    return joined(path, found[1]) if found and found[1] in names else path
