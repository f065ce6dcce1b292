"""A scene in a notebook: its sources, surfaces and detectors, one row each."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from transport.io.html.elements import code, details, escaped, framed, heading, muted, table, typeset
from transport.units import speed_of_light
from transport.validation import short_repr

if TYPE_CHECKING:
    from transport.scene.scene import Scene


# ---- A user's object in few words: its kind and the parameters that differ from their defaults.

MAX_DEPTH = 4  # levels of nested objects that are written out


def constructor_text(thing: object, without: Collection[str] = (), depth: int = MAX_DEPTH) -> str:
    """The object as code that would make it, such as "Sphere(radius=0.5)", shortened if it is long.

    without: parameters to leave out.
    """
    if isinstance(thing, Mapping):
        pairs = ([constructor_text(part, (), depth) for part in pair] for pair in thing.items())
        return f"{{{', '.join(': '.join(pair) for pair in pairs)}}}"
    if not dataclasses.is_dataclass(thing) or _has_own_repr(thing):
        return _literal_text(thing)
    if depth == 0:
        return f"{type(thing).__name__}(...)"
    given = [
        f"{field.name}={constructor_text(getattr(thing, field.name), (), depth - 1)}"
        for field in dataclasses.fields(thing)
        if field.init
        and field.repr
        and field.name not in without
        and not _is_default(field, getattr(thing, field.name))
    ]
    return f"{type(thing).__name__}({', '.join(given)})"


def _has_own_repr(thing: object) -> bool:
    """Return whether it holds arrays or code and its class defines its own text: a mesh, for example."""
    # A dataclass's generated __repr__ is wrapped, against infinite recursion.
    is_generated = hasattr(type(thing).__repr__, "__wrapped__")
    parts = (getattr(thing, field.name) for field in dataclasses.fields(thing))
    return not is_generated and any(isinstance(part, np.ndarray) or callable(part) for part in parts)


def _literal_text(thing: object) -> str:
    """A number or text; whole numbers without a decimal point, long lists shortened."""
    if isinstance(thing, float) and thing.is_integer() and abs(thing) < 1e15:
        return str(int(thing))
    if isinstance(thing, tuple) and 0 < len(thing) <= 6:
        parts = ", ".join(constructor_text(part, (), 2) for part in thing)
        return f"({parts},)" if len(thing) == 1 else f"({parts})"
    return short_repr(thing)


def _is_default(field: dataclasses.Field, value: object) -> bool:
    if isinstance(value, np.ndarray):
        return False
    if field.name == "speed" and value == speed_of_light:  # the default speed of light sources
        return True
    if field.default is not dataclasses.MISSING:
        return value is field.default or value == field.default
    return field.default_factory is not dataclasses.MISSING and value == field.default_factory()


# ---- The scene: one row per source, surface and detector.

MAX_ROWS = 12  # per kind; the others are counted


def scene_html(scene: Scene) -> str:
    """The scene; parameters are shown if they differ from the defaults."""
    facts = [f"in {scene.measured_in}", "lengths in m"]
    if scene.duration is not None:
        facts.append(f"clock from 0 to {scene.duration:g} s")
    filled = [["", code(constructor_text(scene.medium))]] if scene.medium is not None else []
    return framed(
        heading("Scene", typeset(", ".join(facts))),
        _section("source", scene.sources, _source_row),
        _section("surface", scene.surfaces, _surface_row),
        _section("detector", scene.detectors, _detector_row),
        f"<b>surrounding medium</b>{table(filled)}" if filled else "",
    )


def _section(kind: str, things: Sequence, row: Callable[[object], list[str]]) -> str:
    if not things:
        return ""
    rows = [row(thing) for thing in things[:MAX_ROWS]]
    left = len(things) - len(rows)
    more = f"<div>{muted(f'and {left} more')}</div>" if left else ""
    return details(f"<b>{len(things)} {kind}{'s' if len(things) > 1 else ''}</b>", table(rows) + more, True)


def _source_row(source) -> list[str]:
    emission = code(constructor_text(source.emission))
    return [_shape_cell(source.shape), emission, _other_parameters(source, ("shape", "emission"))]


def _surface_row(surface) -> list[str]:
    rest = _other_parameters(surface, ("name", "shape", "material"))
    material = code(constructor_text(surface.material))
    return [_name_cell(surface.name), _shape_cell(surface.shape), material, rest]


def _detector_row(detector) -> list[str]:
    name, kind = _name_cell(detector.name), type(detector)
    if "shape" not in kind.__dataclass_fields__:
        return [name, code(constructor_text(detector, ("name",))), ""]
    title = "" if kind.__name__ == "Detector" else muted(escaped(kind.__name__))
    shape = f"{title} {_shape_cell(detector.shape)}"
    return [name, shape, _other_parameters(detector, ("name", "shape"))]


def _name_cell(name: str | None) -> str:
    return f"<b>{escaped(name)}</b>" if name is not None else muted("no name")


def _shape_cell(shape: object) -> str:
    """A shape, or the name of a surface."""
    return f"on <b>{escaped(shape)}</b>" if isinstance(shape, str) else code(constructor_text(shape))


def _other_parameters(thing: object, shown: tuple[str, ...]) -> str:
    """The other parameters, without the parentheses."""
    _, _, inner = constructor_text(thing, shown).partition("(")
    return code(inner.removesuffix(")"))
