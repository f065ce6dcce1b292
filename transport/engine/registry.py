"""Passes by name, and steps: a pass with its table."""

from collections.abc import Iterator, Mapping

import numpy as np

from transport.compile import layout
from transport.compile.plan import Plan
from transport.engine.families import FAMILIES, HOMES
from transport.engine.passes import Pass

Step = tuple[Pass, np.ndarray]


class _Passes(Mapping):
    """Mapping from a name to its pass; the module of a pass is loaded on first access."""

    def __getitem__(self, name: str) -> Pass:
        return getattr(FAMILIES[HOMES[name]], name)

    def __iter__(self) -> Iterator[str]:
        return iter(HOMES)

    def __len__(self) -> int:
        return len(HOMES)


PASSES = _Passes()
NOTHING = layout.row(layout.NO_TABLE)


def step(lane_pass: Pass, table: np.ndarray = NOTHING) -> Step:
    """Return the pair (pass, table); raise TypeError if the table's dtype is not that of the pass."""
    if table.dtype != lane_pass.table:
        raise TypeError(f"pass {lane_pass.name} reads a {lane_pass.table}, got {table.dtype}")
    return lane_pass, table


def named(called: tuple[str, np.ndarray]) -> Step:
    """Return the step of a pass given by name: (name, table) -> (pass, table)."""
    name, table = called
    return step(PASSES[name], table)


def rows_of(array: np.ndarray) -> np.ndarray:
    """Return a table that points to an array, which the plan keeps alive."""
    return layout.row(layout.ROWS, rows=array.ctypes.data, count=len(array))


def layer_of(plan: Plan, layer: int, rows: np.ndarray | None = None) -> np.ndarray:
    """Return the table of the detectors of one layer.

    rows: other rows of layout.LAYER than those that flights use.
    """
    rows = plan.layers[layer] if rows is None else rows
    return layout.row(
        layout.LAYERS,
        rows=rows.ctypes.data,
        count=len(rows),
        layer=layer,
        half=plan.half,
        meters=plan.meters.ctypes.data,
        meter_count=len(plan.meters),
    )
