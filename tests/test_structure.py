"""The rules of the design that no result shows: who imports whom."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

from transport import renderers

ROOT = Path(__file__).resolve().parents[1]
LIBRARY = ROOT / "transport"
# The rooms of the package in order; each imports only rooms that come before its own.
LAYERS = (
    ("renderers",), ("units", "vectors"), ("validation",), ("physics",), ("statistics",), ("geometry",),
    ("theory", "scene"), ("compile",), ("engine", "results"), ("run",), ("io",), ("simulate",), ("analysis",),
    ("__init__",), ("verification",), ("viz",), ("sims",), ("cli",), ("__main__",),
)  # fmt: skip
LEVEL = {room: level for level, layer in enumerate(LAYERS) for room in layer}
COMPUTED = "(a computed name)"
IMPORTERS_OF_COMPUTED_NAMES = (
    "transport.renderers",
    "transport.verification.experiment",
)  # tables, users' files
READERS_OF_THEORY = ("theory", "verification", "viz", "sims")  # theory judges results, and computes none
FOLDERS = {"transport": LIBRARY, "transport.sims": ROOT / "sims", "transport.viz": ROOT / "viz"}
HEAVY = ("numba", "llvmlite", "scipy.stats", "matplotlib", "pyvista", "xarray", "rich", "typer")
COMPILED = ("engine/", "physics/", "analysis/replay")  # the only places that know Numba
FOLDERS_OF_MACHINES = [
    "home", "root", "tmp", "usr", "opt", "work", "workspace", "mnt", "media", "srv", "var", "Users", "Volumes",
]  # fmt: skip


def sources(*folders):
    return [
        path for folder in folders for path in sorted(folder.rglob("*.py")) if "__kernels__" not in path.parts
    ]


def module_of(path):
    """The dotted name by which a file of transport, sims or viz is imported."""
    for package, folder in reversed(FOLDERS.items()):
        if folder in path.parents:
            parts = [package, *path.relative_to(folder).with_suffix("").parts]
            return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
    raise LookupError(path)


def imports(tree, at_once=False):
    """(line, name) of all imports, also those in functions, for type checkers, or by importlib.

    at_once: only those that run when the file is imported.
    """
    for node in _at_once(tree) if at_once else ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = "." * node.level + (node.module or "")
            yield node.lineno, base
            yield from ((node.lineno, f"{base}.{alias.name}") for alias in node.names)
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "__import__")):
            yield from ((node.lineno, _literal_start(name) or COMPUTED) for name in node.args[:1])


def _literal_start(name):
    """The module that a literal names, or the part of an f-string before its first value."""
    first = name.values[0] if isinstance(name, ast.JoinedStr) else name
    return first.value if isinstance(first, ast.Constant) else None


def _at_once(node):
    for child in ast.iter_child_nodes(node):
        is_later = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        if is_later or (isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test)):
            continue
        yield child
        yield from _at_once(child)


def room_of(name):
    """The room of a module, None outside the package."""
    package, _, rest = name.partition(".")
    return None if package != "transport" else rest.partition(".")[0] or "__init__"


def wrong_imports(module, text):
    """The imports of later rooms by a module, those of theory by rooms that must not know it, and those by computed names."""
    own, found = room_of(module), []
    for line, name in imports(ast.parse(text)):
        if name == COMPUTED and module not in IMPORTERS_OF_COMPUTED_NAMES:
            found.append(f"{module}:{line} imports {name}")
        if name.startswith("."):
            found.append(f"{module}:{line} imports {name}, relatively")
        room = room_of(name)
        if room == "__init__" and name != "transport":
            continue
        if room is None or room == own or room not in LEVEL:
            continue
        if LEVEL[room] >= LEVEL[own] or (room == "theory" and own not in READERS_OF_THEORY):
            found.append(f"{module}:{line} ({own}) imports {name} ({room})")
    return found


def cycles(graph):
    """The files that import one another: what is left when files without imports, or without importers, are taken out."""
    graph = {name: set(others) & graph.keys() - {name} for name, others in graph.items()}
    while True:
        imported = set().union(*graph.values()) if graph else set()
        loose = {name for name, others in graph.items() if not others or name not in imported}
        if not loose:
            return sorted(graph)
        graph = {name: others - loose for name, others in graph.items() if name not in loose}


def within(name, *packages):
    return any(name == package or name.startswith(package + ".") for package in packages)


def short(path):
    return path.relative_to(ROOT).as_posix()


def offences(paths, is_wrong, at_once=False):
    return sorted(
        {
            f"{short(path)} imports {name}"
            for path in paths
            for _, name in imports(ast.parse(path.read_text()), at_once)
            if is_wrong(name)
        }
    )


def user_files():
    return [p for p in sources(LIBRARY) if not p.relative_to(LIBRARY).as_posix().startswith(COMPILED)]


def test_every_import_is_of_an_earlier_room():
    files = {module_of(path): path for path in sources(*FOLDERS.values())}
    assert {room_of(module) for module in files} == LEVEL.keys()
    assert [
        fault for module, path in files.items() for fault in wrong_imports(module, path.read_text())
    ] == []


def test_no_files_import_one_another():
    files = {module_of(path): path for path in sources(*FOLDERS.values())}
    names = {
        module: {name for _, name in imports(ast.parse(path.read_text()))} for module, path in files.items()
    }
    # "from transport.io import merging" asks for the module, not for its package.
    graph = {
        module: {
            name for name in of if not any(other in files and other.startswith(f"{name}.") for other in of)
        }
        for module, of in names.items()
    }
    assert cycles({module: graph[module] & files.keys() for module in files}) == []
    assert cycles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}, "e": set()}) == ["b", "c"]


@pytest.mark.parametrize(
    "text",
    [
        "from transport.scene.scene import Scene",
        "def f():\n    from transport.simulate import simulate",
        "if TYPE_CHECKING:\n    from transport.io.runs import save",
        "import importlib\nimportlib.import_module('transport.viz.costs')",
        "import_module(f'transport.engine.{name}')",
        "name = 'transport.simulate'\nimportlib.import_module(name)",
        "__import__('transport.simulate')",
        "from transport.theory.fresnel import reflectance",
        "from transport.theory import fresnel",
        "import transport",
        "from transport import tracks",
        "from . import flat",
    ],
    ids=["at the top", "in a function", "for type checkers", "importlib", "f-string", "computed", "__import__", "theory", "theory's module", "package", "name", "relative"],
)  # fmt: skip
def test_an_import_of_a_later_room_is_seen(text):
    assert wrong_imports("transport.geometry.shape", text)
    assert not wrong_imports("transport.geometry.shape", "from transport.units import mm\nimport numpy")


def test_a_room_that_may_import_theory_is_known():
    text = "from transport.theory import fresnel"
    assert wrong_imports("transport.results.result", text)
    assert not wrong_imports("transport.verification.experiment", text)


def test_every_registered_function_exists_and_its_class_does():
    classes = {
        cls.__name__
        for module in list(sys.modules.values())
        if room_of(module.__name__)
        for cls in vars(module).values()
        if isinstance(cls, type)
    }
    for (kind, verb), function in renderers._FUNCTIONS.items():
        module, _, name = function.partition(":")
        assert kind in classes and callable(getattr(import_module(module), name)), (kind, verb)
    with pytest.raises(LookupError, match="no function is registered for int and 'html'"):
        renderers.function_for(int, "html")


def test_importing_transport_loads_nothing_heavy():
    """No Numba, no statistics package, no plots, no tables, neither sims nor viz: in a new interpreter."""
    heavy = (*HEAVY, "transport.sims", "transport.viz")
    code = f"import sys, transport; print([name for name in {heavy!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr


def test_importing_a_user_object_or_a_theory_loads_no_numba():
    """Each module of the library by itself, but the few that are compiled."""
    names = [module_of(p) for p in user_files() if p.name != "__main__.py"]
    code = "import importlib, sys\nfor name in sys.argv[1:]:\n    importlib.import_module(name)\n"
    code += "    assert 'numba' not in sys.modules and 'scipy.stats' not in sys.modules, name"
    done = subprocess.run(
        [sys.executable, "-c", code, *names], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_user_objects_do_not_import_numba_nor_at_once_the_engine():
    assert offences(user_files(), lambda name: within(name, "numba", "llvmlite")) == []
    inner = ("transport.engine", "transport.physics", "transport.analysis.replay")
    assert offences(user_files(), lambda name: within(name, *inner), at_once=True) == []


def test_physics_imports_no_user_objects():
    """Nothing but Numba, mathematics and physics: the same laws serve every target."""
    allowed = ("math", "numba", "numpy", "llvmlite", "transport.physics", "__future__")
    assert offences(sources(LIBRARY / "physics"), lambda name: not within(name, *allowed)) == []


def test_nobody_imports_the_statistics_package():
    """scipy.special has all that is needed and loads in a fraction of the time."""
    assert offences(sources(*FOLDERS.values()), lambda name: within(name, "scipy.stats")) == []


def test_imports_are_seen_wherever_they_stand():
    tree = ast.parse(
        "import math\ntry:\n    import numba.core as n\nexcept ImportError:\n    pass\n"
        "from transport import engine\nif TYPE_CHECKING:\n    import xarray\n"
        "def f():\n    from transport.viz import charts\nclass C:\n    import rich\n"
    )
    everywhere = {name for _, name in imports(tree)}
    assert {"math", "numba.core", "transport.engine", "xarray", "transport.viz", "rich"} <= everywhere
    at_once = {name for _, name in imports(tree, at_once=True)}
    assert {"math", "numba.core", "transport.engine", "rich"} <= at_once
    assert not at_once & {"transport.viz", "xarray"}


def test_every_package_is_installed():
    packages = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    found = [module_of(path) for path in sources(*FOLDERS.values()) if path.name == "__init__.py"]
    assert sorted(packages) == sorted(found)


@pytest.mark.parametrize("name", ["sims", "viz"])
@pytest.mark.parametrize("folder", [ROOT, ROOT / "tests"], ids=["in the clone", "elsewhere"])
def test_the_former_name_of_a_package_names_the_new_one(name, folder):
    code = f"import transport\nimport {name}"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False
    )
    assert re.search(
        rf"Error: '{name}' is a part of transport now: import transport\.{name}$", done.stderr.strip()
    )


def test_a_package_of_the_user_with_a_former_name_is_found(tmp_path):
    (tmp_path / "viz.py").write_text("OWN = 1\n")
    code = "import transport\nimport viz\nprint(viz.OWN)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.stdout.strip() == "1", done.stderr


def test_no_source_knows_a_path_of_a_machine():
    folders = [LIBRARY, ROOT / "sims", ROOT / "viz", ROOT / "tests"]
    pattern = re.compile(rf"(?<![\w./:~-])(/({'|'.join(FOLDERS_OF_MACHINES)})/\w|[A-Z]:[\\/]+Users)")
    assert pattern.search(f"open('/{FOLDERS_OF_MACHINES[0]}/me/file')")
    found = [
        f"{short(path)}: {hit[0]}" for path in sources(*folders) for hit in pattern.finditer(path.read_text())
    ]
    assert found == []
