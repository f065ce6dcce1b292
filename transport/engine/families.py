"""Files of passes are read when a scene first calls for one of theirs: a scene pays for no source that it does not need.

Every file is known by what stands in it, and stands in sys.modules from the start, so that `from transport.engine import
meters` and an editor's jump work as ever; Python reads it at the first look into it.
"""

import sys
from importlib.util import LazyLoader, module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

FOLDER = Path(__file__).parent
MARK = "\n@lane_pass("


def _passes_in(path: Path) -> list[str]:
    """Names of the functions that are marked as passes, by the text alone."""
    after = path.read_text(encoding="utf-8").split(MARK)[1:]
    return [text.partition("\ndef ")[2].partition("(")[0] for text in after]


def _unread(path: Path) -> ModuleType:
    """The module of a file, which is run when an attribute of it is asked for."""
    name = f"transport.engine.{path.stem}"
    spec = spec_from_file_location(name, path)
    spec.loader = LazyLoader(spec.loader)
    module = sys.modules[name] = module_from_spec(spec)
    spec.loader.exec_module(module)
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
