"""A scene in a notebook: its sources, surfaces and detectors, one row each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from transport.html.descriptions import described
from transport.html.elements import code, folded, framed, heading, muted, table
from transport.html.typesetting import escaped, typeset

if TYPE_CHECKING:
    from transport.scene import Scene

MOST_ROWS = 12  # per kind; the others are counted


def scene_html(scene: Scene) -> str:
    """The scene; parameters are shown if they differ from the defaults."""
    facts = [f"in {scene.measured_in}", "lengths in m"]
    if scene.duration is not None:
        facts.append(f"clock from 0 to {scene.duration:g} s")
    filled = [["", code(described(scene.medium))]] if scene.medium is not None else []
    return framed(
        heading("Scene", typeset(", ".join(facts))),
        _part("source", scene.sources, _source),
        _part("surface", scene.surfaces, _surface),
        _part("detector", scene.detectors, _detector),
        f"<b>surrounding medium</b>{table(filled)}" if filled else "",
    )


def _part(kind: str, things: Sequence, row: Callable[[object], list[str]]) -> str:
    if not things:
        return ""
    rows = [row(thing) for thing in things[:MOST_ROWS]]
    left = len(things) - len(rows)
    more = f"<div>{muted(f'and {left} more')}</div>" if left else ""
    return folded(f"<b>{len(things)} {kind}{'s' if len(things) > 1 else ''}</b>", table(rows) + more, True)


def _source(source) -> list[str]:
    return [_where(source.shape), code(described(source.emission)), _rest(source, ("shape", "emission"))]


def _surface(surface) -> list[str]:
    rest = _rest(surface, ("name", "shape", "material"))
    return [_name(surface.name), _where(surface.shape), code(described(surface.material)), rest]


def _detector(detector) -> list[str]:
    has_shape = "shape" in type(detector).__dataclass_fields__
    if not has_shape:
        return [_name(detector.name), code(described(detector, ("name",))), ""]
    told = "" if type(detector).__name__ == "Detector" else muted(escaped(type(detector).__name__))
    return [_name(detector.name), f"{told} {_where(detector.shape)}", _rest(detector, ("name", "shape"))]


def _name(name: str | None) -> str:
    return f"<b>{escaped(name)}</b>" if name is not None else muted("no name")


def _where(shape: object) -> str:
    """A shape, or the name of a surface."""
    return f"on <b>{escaped(shape)}</b>" if isinstance(shape, str) else code(described(shape))


def _rest(thing: object, told: tuple[str, ...]) -> str:
    """The other parameters, without the parentheses."""
    _, _, inner = described(thing, told).partition("(")
    return code(inner.removesuffix(")"))
