"""A pass: one physical step as a loop over lanes [first, live), with one signature and its own table.

    @lane_pass(Table)
    def step(bundle, table, first, live): ...; return live

The docstring of a pass lists the bundle's fields that it reads, updates and writes (random counter omitted).

It is compiled as a C callback when a program first needs it and cached on disk separately, so a new kind of
scene compiles only its new passes. With NUMBA_DISABLE_JIT=1 the same function runs as plain Python on
records.
"""

import dis
import itertools
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numba import cfunc, config, from_dtype, types

from transport.engine.bundle import CARRIED, SCRATCH, Bundle
from transport.engine.cache import cached_kernels
from transport.physics.device import ARITHMETIC

LANE_FIELDS = tuple(name for name, _ in CARRIED + SCRATCH)


@dataclass(frozen=True)
class Pass:
    """A lane loop, the record type of its table and its floating-point options."""

    function: object
    table: np.dtype
    arithmetic: dict = field(default_factory=lambda: ARITHMETIC, compare=False)

    @property
    def name(self) -> str:
        """Name of the function."""
        return self.function.__name__

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the lane fields that the loop uses, read from its bytecode as attributes of its first
        parameter.
        """
        bundle = self.function.__code__.co_varnames[0]
        steps = list(dis.get_instructions(self.function))
        named = {after.argval for step, after in itertools.pairwise(steps) if step.argval == bundle}
        return tuple(name for name in LANE_FIELDS if name in named)

    @cached_property
    def compiled(self):
        """The C callback, compiled now or loaded from disk."""
        signature = types.int64(from_dtype(Bundle), from_dtype(self.table), types.uint64, types.uint64)
        with cached_kernels():
            return cfunc(signature, cache=True, **self.arithmetic)(self.function)

    @property
    def entry(self):
        """What the driver calls: the address of the callback, or the Python function without compilation."""
        return self.function if config.DISABLE_JIT else self.compiled.address


def lane_pass(table: np.dtype, arithmetic: dict = ARITHMETIC):
    """Return a decorator that makes a function a pass whose table has this record type."""
    return lambda function: Pass(function, table, arithmetic)
