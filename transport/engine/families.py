"""Lazy loading of the modules of passes: a module is executed when a scene first needs one of its passes.

Each module is listed by the passes found in its text and stands in sys.modules from the start, so that `from
transport.engine import meters` and an editor's jump to a definition work as usual.
"""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from threading import RLock
from types import ModuleType

FOLDER = Path(__file__).parent
MARK = "\n@lane_pass("
KNOWN = ("__name__", "__spec__")  # attributes that the import system reads before a module is executed
BEING_READ = []
READING = RLock()


def _passes_in(path: Path) -> list[str]:
    """Return the names of the passes of a file, from its text alone."""
    after = path.read_text(encoding="utf-8").split(MARK)[1:]
    return [text.partition("\ndef ")[2].partition("(")[0] for text in after]


class Unread(ModuleType):
    """A module that is executed at the first attribute access, by one thread, while other threads wait.

    (importlib's LazyLoader of Python 3.11 exposes half-executed modules to other threads.)
    """

    def __getattribute__(self, name: str) -> object:
        if name not in KNOWN:
            with READING:
                _read(self)
        return ModuleType.__getattribute__(self, name)

    def __setattr__(self, name: str, value: object) -> None:
        with READING:
            _read(self)  # so that executing it later does not undo this
        ModuleType.__setattr__(self, name, value)


def _read(module: ModuleType) -> None:
    """Execute a module that has not been executed yet; it may access itself meanwhile."""
    if object.__getattribute__(module, "__class__") is Unread and module.__spec__ not in BEING_READ:
        BEING_READ.append(module.__spec__)
        try:
            module.__spec__.loader.exec_module(module)
            module.__class__ = ModuleType
        finally:
            BEING_READ.remove(module.__spec__)


def _unread(path: Path) -> ModuleType:
    """Return the module of a file, executed at the first access of an attribute."""
    name = f"transport.engine.{path.stem}"
    spec = spec_from_file_location(name, path)
    module = sys.modules[name] = module_from_spec(spec)
    module.__class__ = Unread
    return module


def _families() -> tuple[dict[str, ModuleType], dict[str, str]]:
    """Return {module name: module} and {pass name: module name}."""
    modules, homes = {}, {}
    for path in sorted(FOLDER.glob("*.py")):
        names = _passes_in(path)
        if names:
            modules[path.stem] = _unread(path)
            homes |= dict.fromkeys(names, path.stem)
    return modules, homes


FAMILIES, HOMES = _families()
