"""A whole file: {"format": "transport scene", "version": 1, "scene": {...}}, and what is shared in it."""

from __future__ import annotations

import json
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, NoReturn

from transport.saved.whole import written_whole
from transport.validation import SceneError, shown, suggestion
from transport.written.printing import printed
from transport.written.reading import Reader, refuse_at
from transport.written.writing import fields_written, shared_parts

if TYPE_CHECKING:
    from transport.scene import Scene

FORMAT = "transport scene"
VERSION = 1  # rises where a file would mean something else, as by another default
HEAD = ("$schema", "format", "version", "about", "shared", "scene")


class Document(NamedTuple):
    """A scene, and what its file says of it to people."""

    scene: Scene
    about: str


def scene_text(scene: Scene, path: str | PathLike | None = None) -> str:
    """The scene as JSON text, written into the file as well where one is named.

    Raises SceneError for what is not declarative, and for a file that cannot be written: an old one stays as it was.
    """
    shared = shared_parts(scene)
    data = {"format": FORMAT, "version": VERSION}
    if shared:
        data["shared"] = {name: fields_written(part, shared, name) for part, name in shared.items()}
    text = printed(data | {"scene": fields_written(scene, shared)}) + "\n"
    if path is not None:
        with written_whole(Path(path)) as file:
            file.write(text.encode())
    return text


def scene_of(source: str | PathLike) -> Scene:
    """The scene of a file, or of a text that begins with "{".  Raises SceneError with the path of what is wrong."""
    return document_of(source).scene


def document_of(source: str | PathLike) -> Document:
    """The scene of a file or text, and what the file says of it to people; as `scene_of`."""
    text, title = _text_and_title(source)
    try:
        data = checked_head(parsed(text))
        if _type_of(data["scene"]) != "Scene":
            refuse_at("scene.type", f'must be "Scene", got {shown(_type_of(data["scene"]))}')
        reader = Reader(data.get("shared", {}))
        scene = reader.value(data["scene"], "")
        reader.check_shared()
    except RecursionError:
        raise SceneError(f"{title}: too deeply nested; a scene needs some ten levels") from None
    except SceneError as error:
        raise SceneError(f"{title}: {error}") from None
    return Document(scene, data.get("about", ""))


def parsed(text: str) -> object:
    """The data of a JSON text.  Raises SceneError with the line where it is none."""
    try:
        return json.loads(text, object_pairs_hook=_unrepeated, parse_constant=_refuse_constant)
    except json.JSONDecodeError as error:
        raise SceneError(f"line {error.lineno}, column {error.colno}: not JSON, {error.msg}") from None
    except SceneError:
        raise
    except ValueError as error:  # a whole number of thousands of digits
        raise SceneError(f"not JSON that can be read, {error}") from None


def checked_head(data: object) -> dict:
    """The whole of a file, if it says that it is one and of a version that is known.  Raises SceneError otherwise."""
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        got = shown(data.get("format")) if isinstance(data, dict) else shown(data)
        refuse_at(
            "format",
            f'must be "{FORMAT}", got {got}; begin with {{"format": "{FORMAT}", "version": {VERSION}}}',
        )
    version = data.get("version")
    if type(version) is not int or version < 1:
        refuse_at("version", f"must be a whole number such as {VERSION}, got {shown(version)}")
    if version > VERSION:
        refuse_at(
            "version",
            f"{version} is newer than {VERSION}, the newest known here; update transport to read it",
        )
    for name in data:
        if name not in HEAD:
            refuse_at(name, f"nothing of that name belongs beside the scene; {suggestion(name, HEAD)}")
    if "scene" not in data:
        refuse_at("scene", 'missing; write "scene": {"type": "Scene", "sources": [...]}')
    if not isinstance(data.get("shared", {}), dict):
        refuse_at("shared", f"must be objects by their names, got {shown(data['shared'])}")
    if not isinstance(data.get("about", ""), str):
        refuse_at("about", f"must be a text, got {shown(data['about'])}")
    return data


def _type_of(data: object) -> object:
    return data.get("type") if isinstance(data, dict) else None


def _text_and_title(source: str | PathLike) -> tuple[str, str]:
    """The text, and what messages call it."""
    if isinstance(source, str) and source.lstrip().startswith("{"):
        return source, "Scene.from_json"
    if not isinstance(source, str | PathLike):
        raise SceneError(
            f"Scene.from_json: must be a path or a text, got {shown(source)}; write 'scene.json'"
        )
    try:
        return Path(source).read_text(encoding="utf-8-sig"), str(source)
    except (OSError, UnicodeDecodeError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise SceneError(f"{source}: cannot be read: {why}; name a file of JSON") from None


def _unrepeated(pairs: list[tuple[str, object]]) -> dict[str, object]:
    data = dict(pairs)
    if len(data) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise SceneError(f"{twice!r} is said twice in {shown(data)}; drop one")
    return data


def _refuse_constant(word: str) -> NoReturn:
    said = {"NaN": "nan", "Infinity": "inf", "-Infinity": "-inf"}[word]
    raise SceneError(f'{word} is no JSON; write {{"float": "{said}"}}')
