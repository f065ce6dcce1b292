"""Pretty-printed JSON: data that fit are on one line, other data have one line per part."""

import json

WIDTH = 110  # characters
STEP = 2  # spaces


def printed(data: object, depth: int = 0, taken: int = 0) -> str:
    """Return the data as JSON text; `taken` characters of the first line are in use."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False) if _may_fit(data) else ""
    if (text and len(text) + depth * STEP + taken <= WIDTH) or not (isinstance(data, dict | list) and data):
        return text
    inner = "\n" + " " * STEP * (depth + 1)
    if isinstance(data, list):
        if not any(isinstance(item, dict | list) for item in data):
            return _filled(data, depth)
        opened, closed = "[]"
        parts = [printed(item, depth + 1, 1) for item in data]
    else:
        opened, closed = "{}"
        parts = []
        for name, value in data.items():
            label = f"{json.dumps(name, ensure_ascii=False)}: "
            parts.append(label + printed(value, depth + 1, len(label) + 1))
    return opened + inner + f",{inner}".join(parts) + "\n" + " " * STEP * depth + closed


def _may_fit(data: object) -> bool:
    """Return whether one line may hold the data; data with too many parts are not tried."""
    return not isinstance(data, dict | list) or 2 * _parts(data, WIDTH) <= WIDTH


def _parts(data: object, most: int) -> int:
    """Count the parts of the data, up to `most`."""
    count = 1
    for item in data.values() if isinstance(data, dict) else data if isinstance(data, list) else ():
        count += _parts(item, most - count)
        if count > most:
            break
    return count


def _filled(numbers: list, depth: int) -> str:
    """Return a long list of numbers and strings, filled into lines."""
    lines, line = [], ""
    for number in numbers:
        word = json.dumps(number, ensure_ascii=False, allow_nan=False)
        if line and len(line) + len(word) + 3 + (depth + 1) * STEP > WIDTH:
            lines.append(line)
            line = ""
        line += f" {word}," if line else f"{word},"
    inner = "\n" + " " * STEP * (depth + 1)
    return "[" + inner + inner.join([*lines, line.rstrip(",")]) + "\n" + " " * STEP * depth + "]"
