"""The rules of the design that no result shows: who imports whom, which packages are declared."""

from __future__ import annotations

import ast
import functools
import re
import sys
import tomllib
from importlib import import_module

import pytest

from tests.processes import ROOT, python
from transport import renderers
from transport.engine.bodies import LANES_IN_CODE

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
HEAVY = (
    "numba", "llvmlite", "scipy", "matplotlib", "pyvista", "vtkmodules", "xarray", "dask", "rich", "typer",
)  # fmt: skip
COMPILED = ("engine/", "physics/", "analysis/replay")  # the only places that know Numba
FOLDERS_OF_MACHINES = [
    "home", "root", "tmp", "usr", "opt", "work", "workspace", "mnt", "media", "srv", "var", "Users", "Volumes",
]  # fmt: skip


def sources(*folders):
    return [
        path for folder in folders for path in sorted(folder.rglob("*.py")) if "__kernels__" not in path.parts
    ]


@functools.cache
def tree_of(path):
    return ast.parse(path.read_text(encoding="utf-8"))


@functools.cache
def imports_of(path, at_once=False):
    return list(imports(tree_of(path), at_once))


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
        elif isinstance(node, ast.Call) and _name_of(node.func) in ("import_module", "__import__"):
            yield from ((node.lineno, _literal_start(name) or COMPUTED) for name in node.args[:1])


def _name_of(function):
    """The name by which a function is called, without its module."""
    return getattr(function, "attr", getattr(function, "id", None))


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


def wrong_imports(module, imported):
    """The imports of later rooms by a module, those of theory by rooms that must not know it, and those by computed names."""
    own, found = room_of(module), []
    for line, name in imported:
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
            for _, name in imports_of(path, at_once)
            if is_wrong(name)
        }
    )


def user_files():
    return [p for p in sources(LIBRARY) if not p.relative_to(LIBRARY).as_posix().startswith(COMPILED)]


def test_every_import_is_of_an_earlier_room():
    files = {module_of(path): path for path in sources(*FOLDERS.values())}
    assert {room_of(module) for module in files} == LEVEL.keys()
    assert [
        fault for module, path in files.items() for fault in wrong_imports(module, imports_of(path))
    ] == []


def test_no_files_import_one_another():
    files = {module_of(path): path for path in sources(*FOLDERS.values())}
    names = {module: {name for _, name in imports_of(path)} for module, path in files.items()}
    # "from transport.io import merging" asks for the module, not for its package.
    graph = {
        module: {
            name for name in of if not any(other in files and other.startswith(f"{name}.") for other in of)
        }
        for module, of in names.items()
    }
    assert cycles({module: graph[module] & files.keys() for module in files}) == []
    assert cycles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}, "e": set()}) == ["b", "c"]


LATER = {  # imports that geometry must not have
    "at the top": "from transport.scene.scene import Scene",
    "in a function": "def f():\n    from transport.simulate import simulate",
    "for type checkers": "if TYPE_CHECKING:\n    from transport.io.runs import save",
    "importlib": "import importlib\nimportlib.import_module('transport.viz.costs')",
    "f-string": "import_module(f'transport.engine.{name}')",
    "computed": "name = 'transport.simulate'\nimportlib.import_module(name)",
    "__import__": "__import__('transport.simulate')",
    "theory": "from transport.theory.fresnel import reflectance",
    "theory's module": "from transport.theory import fresnel",
    "package": "import transport",
    "name": "from transport import tracks",
    "relative": "from . import flat",
}


@pytest.mark.parametrize("text", LATER.values(), ids=LATER)
def test_an_import_of_a_later_room_is_seen(text):
    right = "from transport.units import mm\nimport numpy"
    assert wrong_imports("transport.geometry.shape", imports(ast.parse(text)))
    assert not wrong_imports("transport.geometry.shape", imports(ast.parse(right)))


def test_a_room_that_may_import_theory_is_known():
    imported = list(imports(ast.parse(LATER["theory's module"])))
    assert wrong_imports("transport.results.result", imported)
    assert not wrong_imports("transport.verification.experiment", imported)


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


def test_importing_transport_loads_few_modules_and_nothing_heavy():
    """No Numba, no SciPy, no plots, no tables, neither sims nor viz: the import takes about as long as NumPy's."""
    heavy = (*HEAVY, "transport.sims", "transport.viz")
    code = f"import sys, transport; print(len(sys.modules), [n for n in {heavy!r} if n in sys.modules])"
    count, loaded = python("-c", code).stdout.split(maxsplit=1)
    assert int(count) < 450 and loaded.strip() == "[]"


def test_importing_a_user_object_or_a_theory_loads_no_numba():
    """Each module of the library by itself, but the few that are compiled."""
    names = [module_of(p) for p in user_files() if p.name != "__main__.py"]
    code = "import importlib, sys\nfor name in sys.argv[1:]:\n    importlib.import_module(name)\n"
    code += "    assert 'numba' not in sys.modules and 'scipy.stats' not in sys.modules, name"
    python("-c", code, *names)


# Of physics, whose laws serve every target.
PURE = ("math", "operator", "numba", "numpy", "llvmlite", "transport.physics", "__future__")
INNER = tuple(f"transport.{name.strip('/').replace('/', '.')}" for name in COMPILED)
FORBIDDEN = {  # files, names that they must not import, whether only when imported themselves
    "Numba in user objects": (user_files, lambda name: within(name, "numba", "llvmlite"), False),
    "the engine in user objects, at once": (user_files, lambda name: within(name, *INNER), True),
    "user objects in physics": (
        lambda: sources(LIBRARY / "physics"),
        lambda name: not within(name, *PURE),
        False,
    ),
    # scipy.special has all that is needed and loads in a fraction of the time.
    "scipy.stats": (lambda: sources(*FOLDERS.values()), lambda name: within(name, "scipy.stats"), False),
}


@pytest.mark.parametrize(("files", "is_wrong", "at_once"), FORBIDDEN.values(), ids=FORBIDDEN)
def test_no_file_imports_what_it_must_not(files, is_wrong, at_once):
    assert offences(files(), is_wrong, at_once) == []


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


def lanes_by_other_names(tree, functions):
    """Lanes that code calls by names by which the engine does not know a lane, and functions of modules that
    are given one.

    functions: arguments of each function that is called by its name, where it is known.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            called = functions.get(getattr(node.func, "id", None), ())
            for given, name in zip(node.args, called, strict=False):
                if getattr(given, "id", None) in LANES_IN_CODE and name not in LANES_IN_CODE:
                    yield f"{node.func.id}({name})"
            if isinstance(node.func, ast.Attribute) and LANES_IN_CODE & {
                getattr(given, "id", None) for given in node.args
            }:
                yield ast.unparse(node.func)
        elif isinstance(node, ast.Assign) and _name_of(getattr(node.value, "func", None)) == "lane_at":
            yield from (name for name in map(ast.unparse, node.targets) if name not in LANES_IN_CODE)


def arguments_of(trees):
    """Names of the arguments of every function by its name."""
    nodes = (node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
    return {node.name: [argument.arg for argument in node.args.args] for node in nodes}


def test_a_lane_has_one_of_the_names_by_which_fields_are_found():
    """A field that is read under another name would not travel with its particle."""
    written = [path for path in sources(LIBRARY / "engine", LIBRARY / "physics") if path.name != "bodies.py"]
    trees = {path: tree_of(path) for path in written}
    functions = arguments_of(trees.values())
    found = {short(path): list(lanes_by_other_names(tree, functions)) for path, tree in trees.items()}
    assert {path: names for path, names in found.items() if names} == {}
    planted = ast.parse(
        "def half(particle): return particle.weight\nother = lane_at(lane, 3)\nhalf(lane)\ncount(lane)"
        "\ntally.add_lost(lane, 1.0)"
    )
    assert list(lanes_by_other_names(planted, arguments_of([planted]))) == [
        *("other", "half(particle)", "tally.add_lost"),
    ]


def test_every_package_is_installed():
    packages = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    found = [module_of(path) for path in sources(*FOLDERS.values()) if path.name == "__init__.py"]
    assert sorted(packages) == sorted(found)


@pytest.mark.parametrize(("name", "folder"), [("sims", ROOT), ("viz", ROOT / "tests")])
def test_the_former_name_of_a_package_names_the_new_one(name, folder):
    error = python(
        "-c", f"import transport\nimport {name}", folder=folder, status=1, PYTHONPATH=""
    ).stderr.strip()
    assert re.search(rf"Error: '{name}' is a part of transport now: import transport\.{name}$", error)


def test_a_package_of_the_user_with_a_former_name_is_found(tmp_path):
    (tmp_path / "viz.py").write_text("OWN = 1\n")
    done = python("-c", "import transport\nimport viz\nprint(viz.OWN)", folder=tmp_path, PYTHONPATH="")
    assert done.stdout.strip() == "1"


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
# numba brings its own llvmlite, typer its own click; xarray is for who calls `to_xarray`
NOT_NAMED = {"llvmlite", "click", "xarray"}
OTHER_NAMES = {"vtkmodules": "vtk", "PIL": "pillow"}  # by which packages are imported


def declared(*extras):
    """Packages that a set-up with these extras installs by name."""
    parts = [PROJECT["dependencies"], *(PROJECT["optional-dependencies"][extra] for extra in extras)]
    return {re.match(r"[A-Za-z0-9_.-]+", line)[0].lower() for part in parts for line in part}


def undeclared(imported, *extras):
    """Packages that a source imports and a set-up with these extras lacks, not those of the project or of Python."""
    found = {name.partition(".")[0] for _, name in imported if not name.startswith((".", COMPUTED))}
    names = {OTHER_NAMES.get(name, name) for name in found}
    return (
        names
        - set(sys.stdlib_module_names)
        - {"transport", "sims", "viz", "tests"}
        - declared(*extras)
        - NOT_NAMED
    )


def unbounded(*requirements):
    """Requirements without a lower bound: the suite could not be run with the oldest versions that they allow."""
    return [line for line in requirements if not re.match(r"[A-Za-z0-9_.\[\]-]+\s*>=\s*\d", line)]


def test_every_requirement_has_a_lower_bound():
    extras = PROJECT["optional-dependencies"].values()
    assert unbounded(*PROJECT["dependencies"], *(line for extra in extras for line in extra)) == []
    assert unbounded("numpy>=2.0", "numpy", "numpy<3", "numpy!=2.1") == ["numpy", "numpy<3", "numpy!=2.1"]


def test_a_package_has_one_lower_bound():
    """Of a package in several extras: `--resolution lowest-direct` would take the highest."""
    bounds = {}
    for lines in (PROJECT["dependencies"], *PROJECT["optional-dependencies"].values()):
        for line in lines:
            bounds.setdefault(re.match(r"[A-Za-z0-9_.-]+", line)[0], set()).add(line)
    assert {name: lines for name, lines in bounds.items() if len(lines) > 1} == {}


@pytest.mark.parametrize(
    ("folder", "extras"),
    [("transport", ("plot", "viz", "docs", "files", "cluster")), ("sims", ("plot",)), ("viz", ("viz",))],
)
def test_every_package_that_is_imported_is_declared(folder, extras):
    faults = {short(path): undeclared(imports_of(path), *extras) for path in sources(ROOT / folder)}
    assert {path: names for path, names in faults.items() if names} == {}
    planted = imports(ast.parse("import numpy\ndef f():\n    from mpi4py import MPI\n"))
    assert undeclared(planted) == {"mpi4py"}


def test_no_source_knows_a_path_of_a_machine():
    folders = [LIBRARY, ROOT / "sims", ROOT / "viz", ROOT / "tests"]
    pattern = re.compile(rf"(?<![\w./:~-])(/({'|'.join(FOLDERS_OF_MACHINES)})/\w|[A-Z]:[\\/]+Users)")
    assert pattern.search(f"open('/{FOLDERS_OF_MACHINES[0]}/me/file')")
    found = [
        f"{short(path)}: {hit[0]}" for path in sources(*folders) for hit in pattern.finditer(path.read_text())
    ]
    assert found == []
