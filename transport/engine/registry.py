"""Passes by name, and steps: a pass with its table."""

import re
import sys
from collections.abc import Iterator, Mapping
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from threading import RLock
from types import ModuleType

import numpy as np

from transport.compile import layout
from transport.compile.plan import Plan
from transport.engine.bodies import Pass

# ---- Lazy loading of the modules of passes: a module is executed when a scene first needs one of its passes.
#
# Each module is listed by the passes found in its text and stands in sys.modules from the start, so that
# `from transport.engine.passes import collisions` and an editor's jump to a definition work as usual.

FOLDER = Path(__file__).parent / "passes"
PASS_MARK = re.compile(r"\n@(?:lane|bundle)_pass\(")
# attributes that the import system reads before a module is executed
IMPORT_ATTRIBUTES = "__name__", "__spec__"
EXECUTING = []
EXECUTION_LOCK = RLock()


def _passes_in(path: Path) -> list[str]:
    """Return the names of the passes of a file, from its text alone."""
    after = PASS_MARK.split(path.read_text(encoding="utf-8"))[1:]
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
    if name not in MODULE_OF_PASS:
        raise LookupError(f"there is no pass {name}: write it as guides/extending.md says")
    return step(PASSES[name], table)


def table_of_layer(plan: Plan, layer: int, rows: np.ndarray | None = None) -> np.ndarray:
    """Return the table of the detectors of one layer.

    rows: other rows of layout.LAYER than those that flights use.
    """
    rows = plan.layers[layer] if rows is None else rows
    place = plan.arena.place
    detectors = {"detectors": place(plan.detectors), "detector_count": len(plan.detectors)}
    arrays = {"rows": place(rows), "count": len(rows)} | detectors
    return layout.row(layout.LAYERS, layer=layer, half=plan.half, **arrays)
