"""Known failures of programs like this one that are not a number of a run: vanished guards, packages that are not declared."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from numba import njit

from transport.physics.device import ARITHMETIC, EXACT

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def _count_finite(values):
    count = 0
    for x in values:
        count += 1 if np.isfinite(x) else 0
    return count


@pytest.mark.parametrize("arithmetic", [ARITHMETIC, EXACT])
def test_guards_see_what_is_no_number(arithmetic):
    """A whole fastmath takes nan and inf for finite, and with it every guard; the engine's arithmetic does not."""
    values = np.array([np.nan, np.inf, -np.inf, 1.0])
    assert njit(**arithmetic)(_count_finite)(values) == 1
    assert njit(fastmath=True)(_count_finite)(values) == 4  # the planted fault


def declared(*extras: str) -> set[str]:
    """Packages that a set-up with these extras installs by name."""
    lines = [
        *PROJECT["dependencies"],
        *(line for e in extras for line in PROJECT["optional-dependencies"][e]),
    ]
    return {re.match(r"[A-Za-z0-9_.-]+", line)[0].lower() for line in lines}


def imported(path: Path) -> set[str]:
    """Packages that a file imports, not those of the project or of Python."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found.add(node.module)
    names = {name.partition(".")[0] for name in found}
    names = {PACKAGES.get(name, name) for name in names}
    return names - set(sys.stdlib_module_names) - {"transport", "sims", "viz", "tests"}


# numba brings its own llvmlite, typer its own click; xarray is for who asks for `to_xarray`
NOT_NAMED = {"llvmlite", "click", "xarray"}
PACKAGES = {"vtkmodules": "vtk", "PIL": "pillow"}  # that are imported by another name


@pytest.mark.parametrize(
    ("folder", "extras"),
    [("transport", ("plot", "viz", "docs", "files", "cluster")), ("sims", ("plot",)), ("viz", ("viz",))],
)
def test_every_package_that_is_imported_is_declared(folder, extras):
    undeclared = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in (ROOT / folder).rglob("*.py")
        if "__kernels__" not in path.parts
        for name in imported(path) - declared(*extras) - NOT_NAMED
    }
    assert undeclared == set()


def test_an_undeclared_package_is_seen(tmp_path):
    file = tmp_path / "planted.py"
    file.write_text("import numpy\ndef f():\n    from mpi4py import MPI\n")
    assert imported(file) - declared() == {"mpi4py"}
