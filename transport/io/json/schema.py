"""JSON Schema of scene files, made from the type hints of the objects' fields.

It checks objects, fields, strings and sizes of vectors.  Ranges of numbers, and which fields go together, are
checked only by the objects, which `Scene.from_json` makes.
"""

from __future__ import annotations

import types
import typing
from dataclasses import MISSING

import numpy as np

from transport.geometry.shape import Shape
from transport.io.json.codec import DTYPES, SCENE_TYPES, fields_of
from transport.io.json.documents import FORMAT, VERSION
from transport.io.json.text import pretty_print
from transport.scene.bins import DIRECTION_RANGES
from transport.scene.cameras import LENSES, PROJECTIONS
from transport.scene.emissions import Emission
from transport.scene.materials import Material
from transport.scene.phase_functions import Phase
from transport.scene.pulses import Pulse
from transport.scene.scene import Scene
from transport.scene.sides import IS_BACK
from transport.scene.speeds import SpeedDistribution
from transport.scene.volumes import COLLISION, TRACK

DRAFT = "https://json-schema.org/draft/2020-12/schema"
FAMILIES = (Emission, Material, Phase, Pulse, Shape, SpeedDistribution)
INTEGER = {"type": "integer"}
PLAIN_TYPES = {
    float: {"type": "number"}, int: INTEGER, str: {"type": "string"}, bool: {"type": "boolean"}
}  # fmt: skip
STRING_VALUES = {
    "side": list(IS_BACK),
    "frame": list(DIRECTION_RANGES),
    "estimator": [TRACK, COLLISION],
    "lens": list(LENSES),
    "projection": list(PROJECTIONS),
}
NUMBERS = {"type": "array", "items": {"anyOf": [{"type": "number"}, {"$ref": "#/$defs/numbers"}]}}
ARRAY = {"$ref": "#/$defs/array"}
EVENT_RANGE = {
    "type": "array",
    "prefixItems": [INTEGER, {"anyOf": [INTEGER, {"$ref": "#/$defs/unending"}]}],
    "minItems": 2,
    "maxItems": 2,
}
SPECIAL_FIELDS = {  # fields whose type hints are less specific than their values
    ("Detector", "events"): {"anyOf": [{"type": "null"}, INTEGER | {"minimum": 0}, EVENT_RANGE]},
    ("Tabulated", "density"): ARRAY,
    ("Tracking", "absorption"): {"enum": ["analog", "weighted"]},
}


def schema() -> dict[str, object]:
    """Return the schema (JSON Schema, draft 2020-12) of a file."""
    head = {
        "$schema": {"type": "string", "description": "Path of this schema, for an editor."},
        "format": {"const": FORMAT},
        "version": {"type": "integer", "minimum": 1, "maximum": VERSION},
        "about": {"type": "string", "description": "Description of the scene."},
        "shared": {
            "description": "Objects that are used several times, by name.",
            "type": "object",
            "additionalProperties": {"$ref": "#/$defs/Part"},
        },
        "scene": {"$ref": "#/$defs/Scene"},
    }
    return {
        "$schema": DRAFT,
        "title": FORMAT,
        "description": "A scene of the Monte Carlo transport library `transport`; SI units, radians.",
        **_strict_object(head, ["format", "version", "scene"]),
        "$defs": _definitions()
        | {"Part": _family_schema(object)}
        | {family.__name__: _family_schema(family) for family in FAMILIES}
        | {name: _object_schema(kind) for name, kind in sorted(SCENE_TYPES.items())},
    }


def schema_text() -> str:
    """Return the schema as the text of its file."""
    return pretty_print(schema()) + "\n"


def _definitions() -> dict[str, object]:
    """Return the definitions of numbers, arrays and references to shared objects."""
    shape = {"type": "array", "items": {"type": "integer", "minimum": 1}, "minItems": 1}
    binary = {"dtype": {"enum": list(DTYPES)}, "shape": shape, "base64": {"type": "string"}}
    constant = {"constant": {"type": "number"}, "shape": shape}
    return {
        "reference": _strict_object({"shared": {"type": "string"}})
        | {"description": "Name of an object in `shared`."},
        "unending": _strict_object({"float": {"enum": ["inf", "-inf", "nan"]}}),
        "numbers": NUMBERS,
        "array": {"anyOf": [NUMBERS, _strict_object(binary), _strict_object(constant)]},
    }


def _object_schema(kind: type) -> dict[str, object]:
    """Return the schema of one type of object."""
    fields = fields_of(kind)
    properties = {
        field.name: SPECIAL_FIELDS.get((kind.__name__, field.name)) or _type_schema(field.hint, field.name)
        for field in fields
    }
    if kind is Scene:
        properties = {name: _list_or_one(inner) for name, inner in properties.items()}
    required = [field.name for field in fields if field.default is MISSING]
    summary = " ".join(kind.__doc__.partition("\n")[0].split())
    return {
        "description": summary,
        **_strict_object({"type": {"const": kind.__name__}} | properties, ["type", *required]),
    }


def _list_or_one(field: dict[str, object]) -> dict[str, object]:
    """Return the schema of a scene's field: a list of objects, or a single object."""
    if field.get("type") != "array":
        return field
    return {"anyOf": [field, *field["items"].get("anyOf", [field["items"]])]}


def _type_schema(hint: object, name: str) -> dict[str, object]:
    """Return the schema of a field with this type hint."""
    if hint in PLAIN_TYPES:
        return {"enum": STRING_VALUES[name]} if name in STRING_VALUES and hint is str else PLAIN_TYPES[hint]
    if hint is type(None):
        return {"type": "null"}
    if hint is np.ndarray:
        return ARRAY
    if isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union:
        return _union_schema(hint, name)
    if typing.get_origin(hint) is tuple:
        return _tuple_schema(typing.get_args(hint), name)
    return {"$ref": f"#/$defs/{hint.__name__}"} if hint in FAMILIES else _family_schema(hint)


def _union_schema(hint: object, name: str) -> dict[str, object]:
    """Return the schema of a union; object types are merged into one list."""
    choices: list[dict[str, object]] = []
    for inner in typing.get_args(hint):
        choice = _type_schema(inner, name)
        choices += [each for each in choice.get("anyOf", [choice]) if each not in choices]
    return {"anyOf": choices}


def _tuple_schema(items: tuple[object, ...], name: str) -> dict[str, object]:
    """Return the schema of a tuple, of any length or of these types in turn."""
    if items[-1] is Ellipsis:
        return {"type": "array", "items": _type_schema(items[0], name)}
    size = {"minItems": len(items), "maxItems": len(items)}
    if len(set(items)) == 1:
        return {"type": "array", "items": _type_schema(items[0], name), **size}
    return {"type": "array", "prefixItems": [_type_schema(item, name) for item in items], **size}


def _family_schema(family: type) -> dict[str, object]:
    """Return the schema of an object of a family, or of a reference to a shared object."""
    names = sorted(name for name, kind in SCENE_TYPES.items() if issubclass(kind, family))
    return {"anyOf": [{"$ref": f"#/$defs/{name}"} for name in (*names, "reference")]}


def _strict_object(properties: dict[str, object], required: list[str] | None = None) -> dict[str, object]:
    """Return the schema of an object with exactly these fields; `required` None requires all."""
    required = list(properties) if required is None else required
    return {"type": "object", "properties": properties, "required": required, "additionalProperties": False}
