"""Scene files: {"format": "transport scene", "version": 1, "scene": {...}}, with optional shared objects."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from transport.io.atomic import atomic_write
from transport.io.json.codec import Reader, fields_to_json, shared_objects
from transport.io.json.text import field_path, parse_json, pretty_print, raise_at, value_text
from transport.validation import SceneError, name_hint

if TYPE_CHECKING:
    from transport.scene.scene import Scene

FORMAT = "transport scene"
BYTE_ORDER = "\ufeff"  # byte-order mark that some editors write
LONGEST_PATH = 400  # characters; anything longer is a broken text rather than a path
VERSION = 1  # rises if the meaning of a file changes, e.g. by a new default
HEAD_ENTRIES = ("$schema", "format", "version", "about", "shared", "scene")


class Document(NamedTuple):
    """A scene, and the description in its file."""

    scene: Scene
    about: str


def scene_text(scene: Scene, path: str | PathLike | None = None) -> str:
    """Return the scene as JSON text, and write it to `path` if given.

    Raises SceneError for an object that JSON cannot hold, and for a file that cannot be written; an old file
    stays.
    """
    shared = shared_objects(scene)
    data = {"format": FORMAT, "version": VERSION}
    if shared:
        data["shared"] = {name: fields_to_json(part, shared, name) for part, name in shared.items()}
    text = pretty_print(data | {"scene": fields_to_json(scene, shared)}) + "\n"
    if path is not None:
        with atomic_write(Path(path)) as file:
            file.write(text.encode())
    return text


def read_scene(source: str | PathLike) -> Scene:
    """Return the scene of a file, or of a text that starts with "{".

    Raises SceneError with the place of the error.
    """
    return read_document(source).scene


def read_document(source: str | PathLike) -> Document:
    """Return the scene of a file or text with its description; raises like `read_scene`."""
    text, title = _text_and_title(source)
    try:
        data = checked_head(parse_json(text))
        if _type_of(data["scene"]) != "Scene":
            raise_at("scene.type", f'must be "Scene", got {value_text(_type_of(data["scene"]))}')
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
        got = value_text(data.get("format")) if isinstance(data, dict) else value_text(data)
        raise_at(
            "format",
            f'must be "{FORMAT}", got {got}; begin with {{"format": "{FORMAT}", "version": {VERSION}}}',
        )
    version = data.get("version")
    if type(version) is not int or version < 1:
        raise_at("version", f"must be a whole number such as {VERSION}, got {value_text(version)}")
    if version > VERSION:
        raise_at(
            "version",
            f"{value_text(version)} is newer than {VERSION}, the newest known here;"
            " update transport to read it",
        )
    for name in data:
        if name not in HEAD_ENTRIES:
            place = field_path("", name)
            raise_at(place, f"unknown entry beside the scene; {name_hint(name, HEAD_ENTRIES)}")
    if "scene" not in data:
        raise_at("scene", 'missing; write "scene": {"type": "Scene", "sources": [...]}')
    if not isinstance(data.get("shared", {}), dict):
        raise_at("shared", f"must be a JSON object of named objects, got {value_text(data['shared'])}")
    if not isinstance(data.get("about", ""), str):
        raise_at("about", f"must be a text, got {value_text(data['about'])}")
    return data


def _type_of(data: object) -> object:
    return data.get("type") if isinstance(data, dict) else None


def _text_and_title(source: str | PathLike) -> tuple[str, str]:
    """Return the text and its title in messages."""
    if isinstance(source, str) and source.removeprefix(BYTE_ORDER).lstrip().startswith("{"):
        return source.removeprefix(BYTE_ORDER), "Scene.from_json"
    if not isinstance(source, str | PathLike):
        raise SceneError(
            f"Scene.from_json: must be a path or a text, got {value_text(source)}; write 'scene.json'"
        )
    title = str(source) if len(str(source)) <= LONGEST_PATH else f"Scene.from_json: {value_text(str(source))}"
    try:
        return Path(source).read_text(encoding="utf-8-sig"), title
    except UnicodeDecodeError as error:
        why, cure = f"byte {error.start} is not UTF-8", "save it as UTF-8"
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        cure = "name a JSON file" + (', or start a text with "{"' if isinstance(source, str) else "")
    raise SceneError(f"{title}: cannot be read: {why}; {cure}") from None
