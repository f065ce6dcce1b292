"""Bodies of finite size: whoever is in one has a surface ahead, and what has none went astray by rounding."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.listing import bits_at
from transport.compile import layout

if TYPE_CHECKING:
    from transport.compile.plan import Plan

MARGIN = 2.0**-20  # of the size of the box about the bodies: what ends that far beyond it is outside
FAR = 1e3  # sizes of a body: surely outside of what its surfaces enclose


def bounded_row(plan: Plan) -> np.ndarray | None:
    """The finite bodies of a plan, and a box about them all; None where there are none."""
    boxes = {number: _box_about(plan, body) for number, body in enumerate(plan.bodies)}
    boxes = {number: box for number, box in boxes.items() if box is not None}
    if not boxes:
        return None
    corners = np.concatenate([_in_scene_lengths(plan, box) for box in boxes.values()])
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = MARGIN * float((high - low).max())
    columns = {f"low_{axis}": value for axis, value in zip("xyz", low - margin, strict=True)}
    columns |= {f"high_{axis}": value for axis, value in zip("xyz", high + margin, strict=True)}
    return layout.row(layout.BOUNDED, **columns, bits=sum(1 << number for number in boxes))


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


def _in_scene_lengths(plan: Plan, corners: np.ndarray) -> np.ndarray:
    return np.array([plan.space.place(corner) for corner in corners.tolist()])
