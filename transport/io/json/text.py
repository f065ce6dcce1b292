"""Strict JSON parser: no repeated names, no NaN, no half characters; errors name their place."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import NoReturn

from transport.validation import SceneError, short_repr

MAX_VALUE_LENGTH = 120  # characters of a value in a message
MAX_NAME_LENGTH = 40  # characters of a name in a path
SURROGATES = re.compile("[\ud800-\udfff]")  # surrogates of UTF-16; none alone is a character
MAY_HOLD_SURROGATES = re.compile(r"[\ud800-\udfff]|\\u[dD][89a-fA-F]")


def parse_json(text: str) -> object:
    """Return the data of a JSON text.  Raises SceneError with the line or the path of the error."""
    repeated: list[tuple[dict, str]] = []  # objects, and the name that is given twice

    def as_object(pairs: list[tuple[str, object]]) -> dict[str, object]:
        data, seen = dict(pairs), set()
        if len(data) < len(pairs):
            repeated.append((data, next(name for name, _ in pairs if name in seen or seen.add(name))))
        return data

    try:
        data = json.loads(text, object_pairs_hook=as_object, parse_constant=_raise_constant)
    except json.JSONDecodeError as error:
        raise SceneError(f"line {error.lineno}, column {error.colno}: not JSON, {error.msg}") from None
    except SceneError:
        raise
    except ValueError:  # the only other error of Python's parser
        raise SceneError("unreadable JSON: an integer of thousands of digits; write 1e30") from None
    if repeated:
        twice = {id(part): name for part, name in repeated}
        path, name = next((path, twice[id(part)]) for path, part in _walk(data, "") if id(part) in twice)
        raise_at(field_path(path, name), "is given twice in one object; drop one")
    if MAY_HOLD_SURROGATES.search(text):
        for path, part in _walk(data, ""):
            if isinstance(part, str):
                check_characters(part, path)
            for name in part if isinstance(part, dict) else ():
                check_characters(name, field_path(path, name))
    return data


def check_characters(text: str, path: str) -> None:
    """Raise SceneError if UTF-8 cannot encode the text."""
    if half := SURROGATES.search(text):
        problem = f"{half[0]!r} is half of a character, which UTF-8 cannot encode, got {value_text(text)}"
        raise_at(path, f"{problem}; leave it out")


def raise_at(path: str, problem: str) -> NoReturn:
    """Raise a SceneError that starts with the place in the file."""
    raise SceneError(f"{path}: {problem}" if path else problem)


def value_text(data: object) -> str:
    """Return data as text for a message, cut if it is long."""
    text = short_repr(data)
    return text if len(text) <= MAX_VALUE_LENGTH else f"{text[:MAX_VALUE_LENGTH]}..."


def field_path(path: str, name: str) -> str:
    """Return the path of a field; unprintable or long names are escaped."""
    if not name.isprintable() or len(name) > MAX_NAME_LENGTH:
        name = short_repr(name[: 2 * MAX_NAME_LENGTH])
    return f"{path}.{name}" if path else name


def _walk(data: object, path: str) -> Iterator[tuple[str, object]]:
    """Yield each part of the data with its path, outer parts first."""
    yield path, data
    if isinstance(data, dict):
        for name, part in data.items():
            yield from _walk(part, field_path(path, name).removeprefix("scene."))
    elif isinstance(data, list):
        for place, part in enumerate(data):
            yield from _walk(part, f"{path}[{place}]")


def _raise_constant(word: str) -> NoReturn:
    spelling = {"NaN": "nan", "Infinity": "inf", "-Infinity": "-inf"}[word]
    raise SceneError(f'{word} is not JSON; write {{"float": "{spelling}"}}')


# ---- Pretty-printed JSON: data that fit are on one line, other data have one line per part.

WIDTH = 110  # characters
INDENT = 2  # spaces


def pretty_print(data: object, depth: int = 0, taken: int = 0) -> str:
    """Return the data as JSON text; `taken` characters of the first line are in use."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False) if _may_fit(data) else ""
    if (text and len(text) + depth * INDENT + taken <= WIDTH) or not (isinstance(data, dict | list) and data):
        return text
    inner = "\n" + " " * INDENT * (depth + 1)
    if isinstance(data, list):
        if not any(isinstance(item, dict | list) for item in data):
            return _filled(data, depth)
        opened, closed = "[]"
        parts = [pretty_print(item, depth + 1, 1) for item in data]
    else:
        opened, closed = "{}"
        parts = []
        for name, value in data.items():
            label = f"{json.dumps(name, ensure_ascii=False)}: "
            parts.append(label + pretty_print(value, depth + 1, len(label) + 1))
    return opened + inner + f",{inner}".join(parts) + "\n" + " " * INDENT * depth + closed


def _may_fit(data: object) -> bool:
    """Return whether one line may hold the data; data with too many parts are not tried."""
    return not isinstance(data, dict | list) or 2 * _count_parts(data, WIDTH) <= WIDTH


def _count_parts(data: object, most: int) -> int:
    """Count the parts of the data, up to `most`."""
    count = 1
    for item in data.values() if isinstance(data, dict) else data if isinstance(data, list) else ():
        count += _count_parts(item, most - count)
        if count > most:
            break
    return count


def _filled(numbers: list, depth: int) -> str:
    """Return a long list of numbers and strings, filled into lines."""
    lines, line = [], ""
    for number in numbers:
        word = json.dumps(number, ensure_ascii=False, allow_nan=False)
        if line and len(line) + len(word) + 3 + (depth + 1) * INDENT > WIDTH:
            lines.append(line)
            line = ""
        line += f" {word}," if line else f"{word},"
    inner = "\n" + " " * INDENT * (depth + 1)
    return "[" + inner + inner.join([*lines, line.rstrip(",")]) + "\n" + " " * INDENT * depth + "]"
