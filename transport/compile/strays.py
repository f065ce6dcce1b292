"""Bodies of finite size: whoever is in one has a surface ahead, and what has none went astray by rounding."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.listing import bits_at
from transport.compile import layout

if TYPE_CHECKING:
    from transport.compile.plan import Plan

MARGIN = 2.0**-20  # of the size of the box about a body: what ends that far beyond it is outside
FAR = 1e3  # sizes of a body: surely outside of what its surfaces enclose


def bounded_rows(plan: Plan) -> list[np.ndarray]:
    """Of the surroundings and of each body of a plan (layout.BOUNDED): the box about it, or 0 for what has no end."""
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
    """Lower and upper corner [m] of a finite body; None for one that reaches to infinity."""
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
