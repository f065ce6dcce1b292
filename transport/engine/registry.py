"""Passes by name, and steps: a pass with its table."""

import dis
import itertools
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from threading import RLock
from types import FunctionType, ModuleType

import numpy as np
from numba import cfunc, config, from_dtype, types

from transport.compile import layout
from transport.compile.plan import Plan
from transport.engine.bundle import CARRIED, SCRATCH, Bundle
from transport.engine.cache import cached_kernels
from transport.physics.device import ARITHMETIC

# ---- Lazy loading of the modules of passes: a module is executed when a scene first needs one of its passes.
#
# Each module is listed by the passes found in its text and stands in sys.modules from the start, so that
# `from transport.engine.passes import collisions` and an editor's jump to a definition work as usual.

FOLDER = Path(__file__).parent / "passes"
PASS_MARK = "\n@lane_pass("
# attributes that the import system reads before a module is executed
IMPORT_ATTRIBUTES = "__name__", "__spec__"
EXECUTING = []
EXECUTION_LOCK = RLock()


def _passes_in(path: Path) -> list[str]:
    """Return the names of the passes of a file, from its text alone."""
    after = path.read_text(encoding="utf-8").split(PASS_MARK)[1:]
    return [text.partition("\ndef ")[2].partition("(")[0] for text in after]


class LazyModule(ModuleType):
    """A module that is executed at the first attribute access, by one thread, while other threads wait.

    (importlib's LazyLoader of Python 3.11 exposes half-executed modules to other threads.)
    """

    def __getattribute__(self, name: str) -> object:
        if name not in IMPORT_ATTRIBUTES:
            with EXECUTION_LOCK:
                _execute(self)
        return ModuleType.__getattribute__(self, name)

    def __setattr__(self, name: str, value: object) -> None:
        with EXECUTION_LOCK:
            _execute(self)  # so that executing it later does not undo this
        ModuleType.__setattr__(self, name, value)


def _execute(module: ModuleType) -> None:
    """Execute a module that has not been executed yet; it may access itself meanwhile."""
    if object.__getattribute__(module, "__class__") is LazyModule and module.__spec__ not in EXECUTING:
        EXECUTING.append(module.__spec__)
        try:
            module.__spec__.loader.exec_module(module)
            module.__class__ = ModuleType
        finally:
            EXECUTING.remove(module.__spec__)


def _lazy_module(path: Path) -> ModuleType:
    """Return the module of a file, executed at the first access of an attribute."""
    name = f"transport.engine.passes.{path.stem}"
    spec = spec_from_file_location(name, path)
    module = sys.modules[name] = module_from_spec(spec)
    module.__class__ = LazyModule
    return module


def _lazy_modules() -> tuple[dict[str, ModuleType], dict[str, str]]:
    """Return {module name: module} and {pass name: module name}."""
    modules, homes = {}, {}
    for path in sorted(FOLDER.glob("*.py")):
        names = _passes_in(path)
        if names:
            modules[path.stem] = _lazy_module(path)
            homes |= dict.fromkeys(names, path.stem)
    return modules, homes


MODULES, MODULE_OF_PASS = _lazy_modules()


# ---- A pass: one physical step as a loop over lanes [first, live), with one signature and its own table.
#
#     @lane_pass(Table)
#     def step(bundle, table, first, live): ...; return live
#
# The docstring of a pass lists the bundle's fields that it reads, updates and writes, but the random counter.
#
# It is compiled as a C callback when a program first needs it and cached on disk separately, so a new kind of
# scene compiles only its new passes. With NUMBA_DISABLE_JIT=1 the same function runs as plain Python on
# records.

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
        """Names of the lane fields that the loop uses, itself or in functions that it gives the bundle to."""
        named = _bundle_attributes(self.function)
        return tuple(name for name in LANE_FIELDS if name in named)

    @cached_property
    def compiled(self):
        """The C callback, compiled now or loaded from disk."""
        signature = types.int64(from_dtype(Bundle), from_dtype(self.table), types.uint64, types.uint64)
        with cached_kernels():
            return cfunc(signature, cache=True, **self.arithmetic)(self.function)

    @property
    def entry(self):
        """Address of the callback for the driver, or the Python function without compilation."""
        return self.function if config.DISABLE_JIT else self.compiled.address


def _bundle_attributes(function: FunctionType) -> set[str]:
    """Return the attributes of the bundle, a function's first parameter, by its bytecode and that of the
    functions that it calls with a bundle `b`.
    """
    bundle, steps = function.__code__.co_varnames[0], list(dis.get_instructions(function))
    named = {after.argval for step, after in itertools.pairwise(steps) if step.argval == bundle}
    for name in {step.argval for step in steps if step.opname == "LOAD_GLOBAL"}:
        value = function.__globals__.get(name)
        called = getattr(value, "py_func", value)
        if isinstance(called, FunctionType) and called.__code__.co_varnames[:1] == ("b",):
            named |= _bundle_attributes(called)
    return named


def lane_pass(table: np.dtype, arithmetic: dict = ARITHMETIC):
    """Return a decorator that makes a function a pass whose table has this record type."""
    return lambda function: Pass(function, table, arithmetic)


# ---- Steps.

Step = tuple[Pass, np.ndarray]


class _Passes(Mapping):
    """Mapping from a name to its pass; the module of a pass is loaded on first access."""

    def __getitem__(self, name: str) -> Pass:
        return getattr(MODULES[MODULE_OF_PASS[name]], name)

    def __iter__(self) -> Iterator[str]:
        return iter(MODULE_OF_PASS)

    def __len__(self) -> int:
        return len(MODULE_OF_PASS)


PASSES = _Passes()
EMPTY_TABLE = layout.row(layout.NO_TABLE)


def step(lane_pass: Pass, table: np.ndarray = EMPTY_TABLE) -> Step:
    """Return the pair (pass, table); raise TypeError if the table's dtype is not that of the pass."""
    if table.dtype != lane_pass.table:
        raise TypeError(f"pass {lane_pass.name} reads a {lane_pass.table}, got {table.dtype}")
    return lane_pass, table


def step_by_name(called: tuple[str, np.ndarray]) -> Step:
    """Return the step of a pass given by name: (name, table) -> (pass, table)."""
    name, table = called
    return step(PASSES[name], table)


def table_of_rows(array: np.ndarray) -> np.ndarray:
    """Return a table that points to an array, which the plan keeps alive."""
    return layout.row(layout.ROWS, rows=array.ctypes.data, count=len(array))


def table_of_two(array: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return a table that points to two arrays, which the plan keeps alive."""
    first = {"rows": array.ctypes.data, "count": len(array)}
    return layout.row(layout.TWO_ROWS, **first, others=other.ctypes.data, other_count=len(other))


def table_of_layer(plan: Plan, layer: int, rows: np.ndarray | None = None) -> np.ndarray:
    """Return the table of the detectors of one layer.

    rows: other rows of layout.LAYER than those that flights use.
    """
    rows = plan.layers[layer] if rows is None else rows
    detectors = {"detectors": plan.detectors.ctypes.data, "detector_count": len(plan.detectors)}
    arrays = {"rows": rows.ctypes.data, "count": len(rows)} | detectors
    return layout.row(layout.LAYERS, layer=layer, half=plan.half, **arrays)
