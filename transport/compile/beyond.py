"""Find the empty sides of sheets: a particle that leaves there has escaped without another flight."""

from __future__ import annotations

import numpy as np

from transport.shapes import FlatShape, Plane, Shape, Sphere
from transport.sheets import Sheet
from transport.vectors import dot

PARALLEL = 1e-15


def empty_sides(sheet: Sheet, sheets: list[Sheet]) -> tuple[bool, bool]:
    """Return whether the front and the back side of a sheet are empty (exact, without tolerance)."""
    others = [other.support for other in sheets if other is not sheet]
    others += [member.shape for other in sheets if other is not sheet for member in other.members[1:]]
    match sheet.support:
        case FlatShape() as flat:
            return tuple(all(_is_behind(flat, shape, side) for shape in others) for side in (1.0, -1.0))
        case Sphere(is_closed=True) as ball:
            return all(_is_within(ball, shape) for shape in others), False
    return False, False


def _is_behind(flat: FlatShape, shape: Shape, side: float) -> bool:
    """Return whether a shape lies behind a plane (side 1), or on the normal's side (side -1)."""
    normal, center = np.array(flat.normal), np.array(flat.center)
    if shape.is_infinite:
        is_parallel = isinstance(shape, Plane) and abs(dot(shape.normal, flat.normal)) >= 1 - PARALLEL
        return is_parallel and side * (np.array(shape.center) - center) @ normal <= 0.0
    return bool((side * ((_corners(shape) - center) @ normal) <= 0.0).all())


def _is_within(ball: Sphere, shape: Shape) -> bool:
    if shape.is_infinite:
        return False
    if isinstance(shape, Sphere):
        apart = float(np.linalg.norm(np.array(shape.center) - np.array(ball.center)))
        return apart + shape.radius <= ball.radius
    reach = np.linalg.norm(_corners(shape) - np.array(ball.center), axis=1)
    return bool((reach <= ball.radius).all())


def _corners(shape: Shape) -> np.ndarray:
    return np.array(np.meshgrid(*zip(*shape.bounds, strict=True), indexing="ij")).reshape(3, -1).T
