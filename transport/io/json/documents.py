"""Scene files: {"format": "transport scene", "version": 1, "scene": {...}}, with optional shared objects."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from transport.io.atomic import written_whole
from transport.io.json.reading import Reader
from transport.io.json.text import joined, parsed, printed, refuse_at, said
from transport.io.json.writing import fields_written, shared_parts
from transport.validation import SceneError, suggestion

if TYPE_CHECKING:
    from transport.scene.scene import Scene

FORMAT = "transport scene"
BYTE_ORDER = "\ufeff"  # byte-order mark that some editors write
LONGEST_PATH = 400  # characters; anything longer is a broken text rather than a path
VERSION = 1  # rises if the meaning of a file changes, e.g. by a new default
HEAD = ("$schema", "format", "version", "about", "shared", "scene")


class Document(NamedTuple):
    """A scene, and the description in its file."""

    scene: Scene
    about: str


def scene_text(scene: Scene, path: str | PathLike | None = None) -> str:
    """Return the scene as JSON text, and write it to `path` if given.

    Raises SceneError for an object that JSON cannot hold, and for a file that cannot be written; an old file
    stays.
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
    """Return the scene of a file, or of a text that starts with "{".

    Raises SceneError with the place of the error.
    """
    return document_of(source).scene


def document_of(source: str | PathLike) -> Document:
    """Return the scene of a file or text with its description; raises like `scene_of`."""
    text, title = _text_and_title(source)
    try:
        data = checked_head(parsed(text))
        if _type_of(data["scene"]) != "Scene":
            refuse_at("scene.type", f'must be "Scene", got {said(_type_of(data["scene"]))}')
        reader = Reader(data.get("shared", {}))
        scene = reader.value(data["scene"], "")
        reader.check_shared()
    except RecursionError:
        raise SceneError(f"{title}: too deeply nested; a scene needs about ten levels") from None
    except SceneError as error:
        raise SceneError(f"{title}: {error}") from None
    return Document(scene, data.get("about", ""))


def checked_head(data: object) -> dict:
    """Return the data of a file.  Raises SceneError for a wrong format, a newer version or a wrong entry."""
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        got = said(data.get("format")) if isinstance(data, dict) else said(data)
        refuse_at(
            "format",
            f'must be "{FORMAT}", got {got}; begin with {{"format": "{FORMAT}", "version": {VERSION}}}',
        )
    version = data.get("version")
    if type(version) is not int or version < 1:
        refuse_at("version", f"must be a whole number such as {VERSION}, got {said(version)}")
    if version > VERSION:
        refuse_at(
            "version",
            f"{said(version)} is newer than {VERSION}, the newest known here; update transport to read it",
        )
    for name in data:
        if name not in HEAD:
            place = joined("", name)
            refuse_at(place, f"unknown entry beside the scene; {suggestion(name, HEAD)}")
    if "scene" not in data:
        refuse_at("scene", 'missing; write "scene": {"type": "Scene", "sources": [...]}')
    if not isinstance(data.get("shared", {}), dict):
        refuse_at("shared", f"must be a JSON object of named objects, got {said(data['shared'])}")
    if not isinstance(data.get("about", ""), str):
        refuse_at("about", f"must be a text, got {said(data['about'])}")
    return data


def _type_of(data: object) -> object:
    return data.get("type") if isinstance(data, dict) else None


def _text_and_title(source: str | PathLike) -> tuple[str, str]:
    """Return the text and its title in messages."""
    if isinstance(source, str) and source.removeprefix(BYTE_ORDER).lstrip().startswith("{"):
        return source.removeprefix(BYTE_ORDER), "Scene.from_json"
    if not isinstance(source, str | PathLike):
        raise SceneError(f"Scene.from_json: must be a path or a text, got {said(source)}; write 'scene.json'")
    title = str(source) if len(str(source)) <= LONGEST_PATH else f"Scene.from_json: {said(str(source))}"
    try:
        return Path(source).read_text(encoding="utf-8-sig"), title
    except UnicodeDecodeError as error:
        why, cure = f"byte {error.start} is not UTF-8", "save it as UTF-8"
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        cure = "name a JSON file" + (', or start a text with "{"' if isinstance(source, str) else "")
    raise SceneError(f"{title}: cannot be read: {why}; {cure}") from None
