"""Why a detector counted nothing, where that is sure: an opaque surface closed about it, and all sources outside."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.solids import holds, is_within
from transport.materials import lets_through
from transport.materials.surface import titled
from transport.shapes import Box, Mesh, Shape, Sphere
from transport.shapes.distances import least_distance
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.compile.plan import Plan


def shut_in(plan: Plan, title: str, place: Box | Sphere | Vector) -> str | None:
    """What to know of a detector in a volume, or at a point [m], that counted nothing; None where that is not sure."""
    for number, surface in enumerate(plan.scene.surfaces):
        shape = surface.shape
        is_shell = shape.is_closed and not shape.is_infinite and not lets_through(surface.material)
        if (
            is_shell
            and holds_all(shape, place)
            and all(is_outside(shape, emitter.shape) for emitter in plan.emitters)
        ):
            name = titled(surface, number)
            return (
                f"{title} counted nothing: {name} shuts it in, lets nothing through, and no source is in there; make it"
                " Transparent(), or move the detector or a source"
            )
    return None


def holds_all(shape: Shape, place: Box | Sphere | Vector) -> bool:
    """Whether all of a place lies in a closed shape."""
    is_point = not isinstance(place, Shape)
    if isinstance(shape, Mesh):
        middle, reach = (place, 0.0) if is_point else (place.middle, place.extent)
        return shape.holds(middle) and least_distance(shape, middle) >= reach
    return bool(holds(shape, np.array([place]))[0]) if is_point else is_within(place, shape)


def is_outside(shape: Shape, other: Shape) -> bool:
    """Whether a shape surely lies outside of a closed one, and does not touch it."""
    return least_distance(shape, other.middle, filled=True) > other.extent
