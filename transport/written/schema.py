"""The format of scenes as a JSON Schema, made of the types that the objects' own fields have.

It knows which objects, fields, texts and sizes of vectors there are; what numbers may be, and what goes together, is known
to the objects alone, which `Scene.from_json` makes.
"""

from __future__ import annotations

import types
import typing
from dataclasses import MISSING
from pathlib import Path

import numpy as np

from transport.bins import DIRECTION_RANGES
from transport.emissions import Emission
from transport.materials.base import Material
from transport.media import Phase
from transport.pulses import Pulse
from transport.scene import Scene
from transport.shapes import Shape
from transport.sides import IS_BACK
from transport.speeds import SpeedDistribution
from transport.volumes import COLLISION, TRACK
from transport.written.documents import FORMAT, VERSION
from transport.written.kinds import KINDS, default_of, fields_of
from transport.written.numbers import DTYPES
from transport.written.printing import printed

DRAFT = "https://json-schema.org/draft/2020-12/schema"
FILE = Path(__file__).with_name("scene.schema.json")
FAMILIES = (Emission, Material, Phase, Pulse, Shape, SpeedDistribution)
PLAIN = {
    float: {"type": "number"},
    int: {"type": "integer"},
    str: {"type": "string"},
    bool: {"type": "boolean"},
}
TEXTS = {"side": list(IS_BACK), "frame": list(DIRECTION_RANGES), "estimator": [TRACK, COLLISION]}
NUMBERS = {"type": "array", "items": {"anyOf": [{"type": "number"}, {"$ref": "#/$defs/numbers"}]}}
ARRAY = {"$ref": "#/$defs/array"}
SPECIAL = {  # fields whose types say less than what they take
    ("Detector", "events"): {
        "anyOf": [
            {"type": "null"},
            {"type": "integer", "minimum": 0},
            {
                "type": "array",
                "prefixItems": [
                    {"type": "integer"},
                    {"anyOf": [{"type": "integer"}, {"$ref": "#/$defs/unending"}]},
                ],
                "minItems": 2,
                "maxItems": 2,
            },
        ]
    },
    ("Tabulated", "density"): ARRAY,
    ("Tracking", "absorption"): {"enum": ["analog", "weighted"]},
}


def schema() -> dict[str, object]:
    """The schema (JSON Schema, draft 2020-12) of a whole file."""
    head = {
        "$schema": {"type": "string", "description": "Where this schema is, for an editor."},
        "format": {"const": FORMAT},
        "version": {"type": "integer", "minimum": 1, "maximum": VERSION},
        "about": {"type": "string", "description": "What the scene is, for people."},
        "shared": {
            "description": "Objects that are used more than once, by their names.",
            "type": "object",
            "additionalProperties": {"$ref": "#/$defs/Part"},
        },
        "scene": {"$ref": "#/$defs/Scene"},
    }
    return {
        "$schema": DRAFT,
        "title": FORMAT,
        "description": "A scene of the Monte Carlo transport simulator `transport`; SI units, angles in radians.",
        **_strict(head, ["format", "version", "scene"]),
        "$defs": _words()
        | {"Part": _any_of(object)}
        | {family.__name__: _any_of(family) for family in FAMILIES}
        | {name: _kind(kind) for name, kind in sorted(KINDS.items())},
    }


def schema_text() -> str:
    """The schema as the text of its file."""
    return printed(schema()) + "\n"


def _words() -> dict[str, object]:
    """What stands for numbers, arrays, and objects that are written elsewhere."""
    shape = {"type": "array", "items": {"type": "integer", "minimum": 1}, "minItems": 1}
    binary = {"dtype": {"enum": list(DTYPES)}, "shape": shape, "base64": {"type": "string"}}
    constant = {"constant": {"type": "number"}, "shape": shape}
    return {
        "reference": _strict({"shared": {"type": "string"}})
        | {"description": "What `shared` has by that name."},
        "unending": _strict({"float": {"enum": ["inf", "-inf", "nan"]}}),
        "numbers": NUMBERS,
        "array": {"anyOf": [NUMBERS, _strict(binary), _strict(constant)]},
    }


def _kind(kind: type) -> dict[str, object]:
    """The schema of one kind of object."""
    hints = typing.get_type_hints(kind)
    fields = fields_of(kind)
    properties = {
        field.name: SPECIAL.get((kind.__name__, field.name)) or _typed(hints[field.name], field.name)
        for field in fields
    }
    if kind is Scene:
        properties = {name: _list_or_one(inner) for name, inner in properties.items()}
    required = [field.name for field in fields if default_of(field) is MISSING]
    told = " ".join(kind.__doc__.partition("\n")[0].split())
    return {
        "description": told,
        **_strict({"type": {"const": kind.__name__}} | properties, ["type", *required]),
    }


def _list_or_one(field: dict[str, object]) -> dict[str, object]:
    """What a scene's field takes: for a list of objects, a single one as well."""
    if field.get("type") != "array":
        return field
    return {"anyOf": [field, *field["items"].get("anyOf", [field["items"]])]}


def _typed(hint: object, name: str) -> dict[str, object]:
    """What a field of that type takes."""
    if hint in PLAIN:
        return {"enum": TEXTS[name]} if name in TEXTS and hint is str else PLAIN[hint]
    if hint is type(None):
        return {"type": "null"}
    if hint is np.ndarray:
        return ARRAY
    if isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union:
        return _either(hint, name)
    if typing.get_origin(hint) is tuple:
        return _row(typing.get_args(hint), name)
    return {"$ref": f"#/$defs/{hint.__name__}"} if hint in FAMILIES else _any_of(hint)


def _either(hint: object, name: str) -> dict[str, object]:
    """One of several types; all kinds of objects among them in one list."""
    choices: list[dict[str, object]] = []
    for inner in typing.get_args(hint):
        choice = _typed(inner, name)
        choices += [each for each in choice.get("anyOf", [choice]) if each not in choices]
    return {"anyOf": choices}


def _row(items: tuple[object, ...], name: str) -> dict[str, object]:
    """A tuple: of any length, or of these types in turn."""
    if items[-1] is Ellipsis:
        return {"type": "array", "items": _typed(items[0], name)}
    size = {"minItems": len(items), "maxItems": len(items)}
    if len(set(items)) == 1:
        return {"type": "array", "items": _typed(items[0], name), **size}
    return {"type": "array", "prefixItems": [_typed(item, name) for item in items], **size}


def _any_of(family: type) -> dict[str, object]:
    """An object of one of the kinds of a family, or where one is written that is shared."""
    names = sorted(name for name, kind in KINDS.items() if issubclass(kind, family))
    return {"anyOf": [{"$ref": f"#/$defs/{name}"} for name in (*names, "reference")]}


def _strict(properties: dict[str, object], required: list[str] | None = None) -> dict[str, object]:
    """An object of these fields and no others; all are required where it is not said which."""
    required = list(properties) if required is None else required
    return {"type": "object", "properties": properties, "required": required, "additionalProperties": False}
