"""Files of passes are read when a scene first calls for one of theirs: a scene pays for no source that it does not need.

Every file is known by what stands in it, and stands in sys.modules from the start, so that `from transport.engine import
meters` and an editor's jump work as ever; Python reads it at the first look into it.
"""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from threading import RLock
from types import ModuleType

FOLDER = Path(__file__).parent
MARK = "\n@lane_pass("
KNOWN = ("__name__", "__spec__")  # before a module is read: what the import system asks for
BEING_READ = []
READING = RLock()


def _passes_in(path: Path) -> list[str]:
    """Names of the functions that are marked as passes, by the text alone."""
    after = path.read_text(encoding="utf-8").split(MARK)[1:]
    return [text.partition("\ndef ")[2].partition("(")[0] for text in after]


class Unread(ModuleType):
    """A module that is run when it is first looked into, by one thread, while others that look wait for its end.

    (importlib's LazyLoader of Python 3.11 lets them see a module that is half read.)
    """

    def __getattribute__(self, name: str) -> object:
        if name not in KNOWN:
            with READING:
                _read(self)
        return ModuleType.__getattribute__(self, name)

    def __setattr__(self, name: str, value: object) -> None:
        with READING:
            _read(self)  # lest reading it later undo this
        ModuleType.__setattr__(self, name, value)


def _read(module: ModuleType) -> None:
    """Run a module that nothing has run yet; it may look into itself meanwhile."""
    if object.__getattribute__(module, "__class__") is Unread and module.__spec__ not in BEING_READ:
        BEING_READ.append(module.__spec__)
        try:
            module.__spec__.loader.exec_module(module)
            module.__class__ = ModuleType
        finally:
            BEING_READ.remove(module.__spec__)


def _unread(path: Path) -> ModuleType:
    """The module of a file, which is run when an attribute of it is asked for."""
    name = f"transport.engine.{path.stem}"
    spec = spec_from_file_location(name, path)
    module = sys.modules[name] = module_from_spec(spec)
    module.__class__ = Unread
    return module


def _families() -> tuple[dict[str, ModuleType], dict[str, str]]:
    """Modules by name of family, and families by name of pass."""
    modules, homes = {}, {}
    for path in sorted(FOLDER.glob("*.py")):
        names = _passes_in(path)
        if names:
            modules[path.stem] = _unread(path)
            homes |= dict.fromkeys(names, path.stem)
    return modules, homes


FAMILIES, HOMES = _families()
