"""Bounding boxes of finite bodies, which reveal lost particles.

A particle in a finite body has a surface ahead; one that has none was lost by rounding.
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.listing import bits_at
from transport.compile import layout

if TYPE_CHECKING:
    from transport.compile.plan import Plan

MARGIN = 2.0**-20  # of the size of a body's box: a path that ends that far beyond the box is outside
FAR = 1e3  # sizes of a body: a distance surely outside its surfaces


def bounded_rows(plan: Plan) -> list[np.ndarray]:
    """Return a row (layout.BOUNDED) of the surroundings and of each body; 0 where unbounded."""
    return [layout.row(layout.BOUNDED), *(_row(plan, number) for number in range(len(plan.bodies)))]


def _row(plan: Plan, number: int) -> np.ndarray:
    box = _box_about(plan, plan.bodies[number])
    if box is None:
        return layout.row(layout.BOUNDED)
    low, high = (np.array(plan.space.place(corner)) for corner in box.tolist())
    margin = MARGIN * float((high - low).max())
    columns = {f"low_{axis}": value for axis, value in zip("xyz", low - margin, strict=True)}
    columns |= {f"high_{axis}": value for axis, value in zip("xyz", high + margin, strict=True)}
    return layout.row(layout.BOUNDED, **columns, bit=1 << number)


def _box_about(plan: Plan, body) -> np.ndarray | None:
    """Return the lower and upper corner [m] of a finite body; None for an unbounded one."""
    shapes = [plan.scene.surfaces[number].shape for number in body.surfaces]
    if any(shape.is_infinite for shape in shapes):
        return None
    bounds = np.array([shape.bounds for shape in shapes])
    box = np.array([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])
    far = box.mean(axis=0) + FAR * float(np.ptp(box, axis=0).max()) * np.array(
        list(product((-1, 1), repeat=3))
    )
    is_endless = bits_at(plan.scene, far, [plan.bodies.index(body)]).any()
    return None if is_endless else box
