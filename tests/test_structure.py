"""The rules of the design that no result shows: who imports whom."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LIBRARY = ROOT / "transport"
HEAVY = (
    "numba",
    "llvmlite",
    "scipy.stats",
    "matplotlib",
    "pyvista",
    "xarray",
    "rich",
    "typer",
    "sims",
    "viz",
)
COMPILED = ("engine/", "physics/", "cli/bench/yardstick")  # the only places that know Numba
ROOTS = [
    "home",
    "root",
    "tmp",
    "usr",
    "opt",
    "work",
    "workspace",
    "mnt",
    "media",
    "srv",
    "var",
    "Users",
    "Volumes",
]


def sources(*folders):
    return [
        path for folder in folders for path in sorted(folder.rglob("*.py")) if "__kernels__" not in path.parts
    ]


def imports(path, everywhere=True):
    """Names that a file imports: also those within functions, or only those that importing it imports."""
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree) if everywhere else _at_once(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield "." * node.level + (node.module or "")
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _at_once(node):
    """Statements that run when a module is imported; not those for type checkers only."""
    for child in ast.iter_child_nodes(node):
        is_later = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        if is_later or (isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test)):
            continue
        yield child
        yield from _at_once(child)


def within(name, *packages):
    return any(name == package or name.startswith(package + ".") for package in packages)


def short(path):
    return path.relative_to(ROOT).as_posix()


def offences(paths, is_wrong, everywhere=True):
    return sorted(
        {
            f"{short(path)} imports {name}"
            for path in paths
            for name in imports(path, everywhere)
            if is_wrong(name)
        }
    )


def user_files():
    return [p for p in sources(LIBRARY) if not p.relative_to(LIBRARY).as_posix().startswith(COMPILED)]


def test_importing_transport_loads_nothing_heavy():
    """No Numba, no statistics package, no plots, no tables, neither sims nor viz: in a new interpreter."""
    code = f"import sys, transport; print([name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr


def test_importing_a_user_object_or_a_theory_loads_no_numba():
    """Each module of the library by itself, but the few that are compiled."""
    names = [
        ".".join(p.relative_to(ROOT).with_suffix("").parts) for p in user_files() if p.name != "__main__.py"
    ]
    code = "import importlib, sys\nfor name in sys.argv[1:]:\n    importlib.import_module(name)\n"
    code += "    assert 'numba' not in sys.modules and 'scipy.stats' not in sys.modules, name"
    done = subprocess.run(
        [sys.executable, "-c", code, *names], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_user_objects_do_not_import_numba_nor_at_once_the_engine():
    assert offences(user_files(), lambda name: within(name, "numba", "llvmlite")) == []
    inner = ("transport.engine", "transport.physics", "transport.cli.bench.yardstick")
    assert offences(user_files(), lambda name: within(name, *inner), everywhere=False) == []


def test_physics_imports_no_user_objects():
    """Nothing but Numba, mathematics and physics: the same laws serve every target."""
    allowed = ("math", "numba", "numpy", "llvmlite", "transport.physics", "__future__")
    assert offences(sources(LIBRARY / "physics"), lambda name: not within(name, *allowed)) == []


def test_the_library_imports_neither_sims_nor_viz():
    assert offences(sources(LIBRARY), lambda name: within(name, "sims", "viz") or name.startswith(".")) == []


def test_nobody_imports_the_statistics_package():
    """scipy.special has all that is needed and loads in a fraction of the time."""
    assert (
        offences(sources(LIBRARY, ROOT / "sims", ROOT / "viz"), lambda name: within(name, "scipy.stats"))
        == []
    )


def test_the_rules_are_seen_where_they_are_broken(tmp_path):
    """Planted: imports in a function, in a branch, under another name, for type checkers."""
    file = tmp_path / "planted.py"
    file.write_text(
        "import math\ntry:\n    import numba.core as n\nexcept ImportError:\n    pass\n"
        "from transport import engine\nif TYPE_CHECKING:\n    import xarray\n"
        "def f():\n    from viz import charts\nclass C:\n    import rich\n"
    )
    assert {"math", "numba.core", "transport.engine", "xarray", "viz", "rich"} <= set(imports(file))
    at_once = set(imports(file, everywhere=False))
    assert {"math", "numba.core", "transport.engine", "rich"} <= at_once
    assert not at_once & {"viz", "xarray"}


def test_no_source_knows_a_path_of_a_machine():
    folders = [LIBRARY, ROOT / "sims", ROOT / "viz", ROOT / "tests"]
    pattern = re.compile(rf"(?<![\w./:~-])(/({'|'.join(ROOTS)})/\w|[A-Z]:[\\/]+Users)")
    assert pattern.search(f"open('/{ROOTS[0]}/me/file')")
    found = [
        f"{short(path)}: {hit[0]}" for path in sources(*folders) for hit in pattern.finditer(path.read_text())
    ]
    assert found == []
