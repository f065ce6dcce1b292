"""Machine code of a copy of the project: what a fault does not touch is taken over, the rest is compiled anew.

Passes are kept on disk in a folder named by a digest of their sources, in it by the path of these (Numba), and each under the
name of its own module.  A fault may change those of its module, and of all modules that import it.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import shutil
from pathlib import Path

from tests.mutants.fault import LIBRARY, ROOT

FOLDERS = ("engine", "physics")
SOURCES = ("engine", "engine/passes")  # of what Numba keeps on disk
MARKS = (
    "@lane_pass",
    "@bundle_pass",
    "@device",
    "@exact_device",
    "njit",
)  # of modules that hold code to compile; others only hand it on
VARIANTS = " by "  # in names of passes that draw in another way: they depend on more than they import


def take_over(copy: Path) -> None:
    """What the project itself has compiled of just these sources."""
    name = name_of(copy)
    for source in SOURCES:
        theirs, ours = (
            root / LIBRARY / "__kernels__" / name / _folder_of(root, source) for root in (ROOT, copy)
        )
        if theirs.is_dir():
            shutil.copytree(theirs, ours, dirs_exist_ok=True)


def keep_untouched(copy: Path, sound: str, file: str) -> Path:
    """A folder of machine code for the copy with a fault in one file, with all from the folder `sound` that stays as it was."""
    folders = copy / LIBRARY / "__kernels__"
    touched = importers_of(Path(file).with_suffix("").as_posix().replace("/", "."), imports(copy))
    name = name_of(copy)
    for source in SOURCES:
        old, new = (folders / each / _folder_of(copy, source) for each in (sound, name))
        new.mkdir(parents=True)
        for kernel in old.glob("*") if file.startswith(FOLDERS) else ():
            if kernel.name.split(".")[0] not in touched and VARIANTS not in kernel.name:
                shutil.copy2(kernel, new / kernel.name)
    return folders / name


def name_of(copy: Path) -> str:
    """The name of the folder of a copy's machine code, as its sources are now (transport/engine/cache.py)."""
    path = copy / LIBRARY / "engine" / "cache.py"
    spec = importlib.util.spec_from_file_location("cache_of_copy", path)
    cache = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(cache)
    return f"{cache.source_digest()}-{cache.LANES}"


def importers_of(module: str, imported: dict[str, set[str]]) -> set[str]:
    """Stems of a module and all that import it, directly or not; modules as "engine.sums"."""
    found, left = set(), {module}
    while left:
        found |= left
        left = {name for name, its in imported.items() if its & left} - found
    return {name.rpartition(".")[2] for name in found}


def imports(copy: Path) -> dict[str, set[str]]:
    """What each module that is compiled imports of them."""
    found = {}
    for folder in FOLDERS:
        for path in (copy / LIBRARY / folder).rglob("*.py"):
            text = path.read_text()
            nodes = ast.walk(ast.parse(text)) if any(mark in text for mark in MARKS) else ()
            froms = [node for node in nodes if isinstance(node, ast.ImportFrom) and node.module]
            names = {f"{node.module}.{alias.name}" for node in froms for alias in node.names}
            names = {
                name.partition(".")[2].rpartition(".")[0] for name in names
            }  # without "transport." and the name itself
            found[".".join(path.relative_to(copy / LIBRARY).with_suffix("").parts)] = {
                name for name in names if name.startswith(FOLDERS)
            }
    return found


def _folder_of(root: Path, source: str) -> str:
    """As Numba names the folder of what comes from one folder of sources."""
    path = root / LIBRARY / source
    return f"{path.name}_{hashlib.sha1(str(path).encode()).hexdigest()}"
