"""A whole file: {"format": "transport scene", "version": 1, "scene": {...}}, and what is shared in it."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from transport.saved.whole import written_whole
from transport.validation import SceneError, suggestion
from transport.written.parsing import joined, parsed, refuse_at, said
from transport.written.printing import printed
from transport.written.reading import Reader
from transport.written.writing import fields_written, shared_parts

if TYPE_CHECKING:
    from transport.scene import Scene

FORMAT = "transport scene"
BYTE_ORDER = "\ufeff"  # what some editors begin a text with
LONGEST_PATH = 400  # characters; what is longer is a text gone wrong
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
            refuse_at("scene.type", f'must be "Scene", got {said(_type_of(data["scene"]))}')
        reader = Reader(data.get("shared", {}))
        scene = reader.value(data["scene"], "")
        reader.check_shared()
    except RecursionError:
        raise SceneError(f"{title}: too deeply nested; a scene needs some ten levels") from None
    except SceneError as error:
        raise SceneError(f"{title}: {error}") from None
    return Document(scene, data.get("about", ""))


def checked_head(data: object) -> dict:
    """The whole of a file, if it says that it is one and of a version that is known.  Raises SceneError otherwise."""
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
            refuse_at(place, f"nothing of that name belongs beside the scene; {suggestion(name, HEAD)}")
    if "scene" not in data:
        refuse_at("scene", 'missing; write "scene": {"type": "Scene", "sources": [...]}')
    if not isinstance(data.get("shared", {}), dict):
        refuse_at("shared", f"must be objects by their names, got {said(data['shared'])}")
    if not isinstance(data.get("about", ""), str):
        refuse_at("about", f"must be a text, got {said(data['about'])}")
    return data


def _type_of(data: object) -> object:
    return data.get("type") if isinstance(data, dict) else None


def _text_and_title(source: str | PathLike) -> tuple[str, str]:
    """The text, and what messages call it."""
    if isinstance(source, str) and source.removeprefix(BYTE_ORDER).lstrip().startswith("{"):
        return source.removeprefix(BYTE_ORDER), "Scene.from_json"
    if not isinstance(source, str | PathLike):
        raise SceneError(f"Scene.from_json: must be a path or a text, got {said(source)}; write 'scene.json'")
    title = str(source) if len(str(source)) <= LONGEST_PATH else f"Scene.from_json: {said(str(source))}"
    try:
        return Path(source).read_text(encoding="utf-8-sig"), title
    except UnicodeDecodeError as error:
        why, cure = f"byte {error.start} is none of UTF-8", "save it as UTF-8"
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        cure = "name a file of JSON" + (', or begin a text with "{"' if isinstance(source, str) else "")
    raise SceneError(f"{title}: cannot be read: {why}; {cure}") from None
