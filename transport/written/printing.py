"""JSON data as text for people: what fits is on one line, what does not has a line for each of its parts."""

import json

WIDTH = 110  # characters
STEP = 2  # spaces


def printed(data: object, depth: int = 0, taken: int = 0) -> str:
    """The data as JSON; `taken` characters of the line are not free."""
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
    """Whether one line may hold it: what has more parts than a line has characters is not tried."""
    return not isinstance(data, dict | list) or 2 * _parts(data, WIDTH) <= WIDTH


def _parts(data: object, most: int) -> int:
    """How many parts it has, counted until there are more than that."""
    count = 1
    for item in data.values() if isinstance(data, dict) else data if isinstance(data, list) else ():
        count += _parts(item, most - count)
        if count > most:
            break
    return count


def _filled(numbers: list, depth: int) -> str:
    """A long list of numbers and texts in lines as long as may be."""
    lines, line = [], ""
    for number in numbers:
        word = json.dumps(number, ensure_ascii=False, allow_nan=False)
        if line and len(line) + len(word) + 3 + (depth + 1) * STEP > WIDTH:
            lines.append(line)
            line = ""
        line += f" {word}," if line else f"{word},"
    inner = "\n" + " " * STEP * (depth + 1)
    return "[" + inner + inner.join([*lines, line.rstrip(",")]) + "\n" + " " * STEP * depth + "]"
