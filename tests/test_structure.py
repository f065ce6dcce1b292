"""The rules of the design that no result shows: who imports whom, how long files grow, which loops are vectorised."""

from __future__ import annotations

import ast
import importlib
import pkgutil
import platform
import re
import subprocess
import sys
from pathlib import Path

import llvmlite.binding as llvm
import pytest
from numba import cfunc, config, from_dtype, types

from transport import engine
from transport.engine.bundle import Bundle
from transport.engine.passes import Pass
from transport.physics.device import ARITHMETIC

ROOT = Path(__file__).resolve().parents[1]
LIBRARY = ROOT / "transport"
LONGEST_FILE = 350  # lines
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
COMPILED = ("engine/", "physics/", "command/yardstick")  # the only places that know Numba
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

# Passes whose loops are not vectorised, and why.
SCALAR_PASSES = {
    "stand_on_sheet": "gathers from the sheets",
    "put_back_on_sphere": "gathers from the sheets",
    "tell_leaving": "gathers from the sheets",
    "look_up_meter": "gathers from the layer's rows",
    "look_up_surface": "gathers from the surfaces",
    "know_meter": "gathers from the layer's rows",
    "refine_by_cosine": "searches among edges, for few lanes",
    "refine_by_azimuth": "searches among edges, for few lanes",
    "refine_by_place": "searches among edges, for few lanes",
    "refine_by_cell": "gathers from the meters, for few lanes",
    "find_place": "gathers from the edges of bins",
    "find_direction": "gathers from the edges of bins",
    "find_hemisphere_direction": "gathers from the edges of bins",
    "score_way_by_cell": "scatters to the cells' rows",
    "score_way_by_cell_in_media": "scatters to the cells' rows",
    "draw_back_from_edge": "gathers from the walls, for few lanes",
    "score": "scatters to the meters' rows",
    "score_all": "scatters to the meters' rows",
    "score_and_size": "scatters to the meters' rows and the cells of sizes",
    "score_all_and_size": "scatters to the meters' rows and the cells of sizes",
    "account_absorbed": "scatters to the surfaces' rows",
    "fill_gaps": "works on a list of lanes",
    "take_quantile": "gathers from the cells of the speeds",
    "take_stepped_quantile": "gathers from the cells of the speeds",
    "emit_from_drifting_gas": "gathers from the cells of the speeds",
    "take_wall_speed": "gathers from the surfaces and the cells of the speeds, for few lanes",
    "choose_part": "gathers from the surfaces, for few lanes",
    "count_phase_space": "searches among edges, for the lanes of an instant",
    "record_snapshot": "writes down the lanes of an instant",
    "mark_visit": "gathers from the layer's rows",
    "require_visits": "gathers from the meters, for few lanes",
    "require_reflections": "gathers from the meters, for few lanes",
    "refine_by_time": "searches among edges, for few lanes",
    "refine_by_speed": "searches among edges, for few lanes",
    "score_moments": "scatters to the meters' rows",
    "born_beside_hole": "draws again where a place lies in the hole",
    "born_on_paraboloid": "a logarithm and an exponential that keep the digits of shallow ones",
    "born_on_mesh": "searches for a facet by its share of the area",
    "meet_mesh": "descends a hierarchy of boxes, ray by ray",
    "cover_mesh": "descends a hierarchy of boxes, ray by ray",
    "stand_on_facet": "gathers from the facets",
    "put_back_on_quadric": "gathers from the sheets",
    "look_up_optics": "gathers from the surfaces",
    "spread_lobe": "gathers from the cells of the lobe, for few lanes",
    "bend_by_lens": "gathers from the surfaces, for few lanes",
    "cross_boundary": "gathers from the layer's rows",
    "lose_strays_of_many": "gathers from the bodies, where they are many",
    "know_bodies": "gathers from the media, where they are many",
    "choose_phase": "gathers from the media and searches among the parts of a mixture",
    "choose_segment_of_table": "gathers from the segments of a table",
    "deposit": "copies lanes into the bank, for few",
    "deposit_forced": "copies lanes into the bank, for few",
    "withdraw": "copies lanes out of the bank, for few",
    "attenuate_in_grid": "walks from voxel to voxel, ray by ray",
    "walk_through_grid": "walks from voxel to voxel, ray by ray",
    "walk_through_cells": "walks from cell to cell, ray by ray",
    "reach_until_end_in_media": "gathers from the media",
    "know_collisions_in_grid": "gathers from the voxels",
    "score_collisions_in_box": "scatters to the cells' rows",
    "score_collisions_in_ball": "searches among the shells and scatters to their rows",
    "know_phase": "gathers from the media",
    "know_phase_at_collisions": "gathers from the media",
    "weigh_in_grid": "gathers from the voxels",
    "weigh_by_table": "searches among the points of a table",
    "list_shadows": "works on a list of lanes",
    "take_shadows": "copies rays from bundle to bundle",
    "turn_to_point": "gathers from the points and the media, for few lanes",
    "dim_in_grid": "walks from voxel to voxel, ray by ray",
}
# AVX2 cannot convert packed int64 to float64 and back, nor mask as AVX-512 does.
SCALAR_WITHOUT_AVX512 = {"absorb", "born_over_rectangle", "born_over_disk"}


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
    inner = ("transport.engine", "transport.physics", "transport.command.yardstick")
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


def test_files_stay_short():
    lengths = {short(path): len(path.read_text().splitlines()) for path in sources(LIBRARY)}
    assert {path: lines for path, lines in lengths.items() if lines > LONGEST_FILE} == {}


def test_no_source_knows_a_path_of_a_machine():
    folders = [LIBRARY, ROOT / "sims", ROOT / "viz", ROOT / "tests"]
    pattern = re.compile(rf"(?<![\w./:~-])(/({'|'.join(ROOTS)})/\w|[A-Z]:[\\/]+Users)")
    assert pattern.search(f"open('/{ROOTS[0]}/me/file')")
    found = [
        f"{short(path)}: {hit[0]}" for path in sources(*folders) for hit in pattern.finditer(path.read_text())
    ]
    assert found == []


def passes():
    """Every pass of the engine by name."""
    modules = [
        importlib.import_module(f"{engine.__name__}.{m.name}") for m in pkgutil.iter_modules(engine.__path__)
    ]
    return {p.name: p for module in modules for p in vars(module).values() if isinstance(p, Pass)}


def assembly(lane_pass):
    """Machine code as text; what was loaded from the cache has none and is compiled once more."""
    compiled = lane_pass.compiled
    if compiled.cache_hits:
        signature = types.int64(from_dtype(Bundle), from_dtype(lane_pass.table), types.uint64, types.uint64)
        compiled = cfunc(signature, **ARITHMETIC)(lane_pass.function)
    return compiled._library.get_asm_str()


def innermost_loops(text):
    """Instructions between a jump back and its target, for loops that hold no other."""
    labels, jumps, instructions = {}, [], []
    for line in (line.split("#")[0].strip() for line in text.splitlines()):
        if line.endswith(":"):
            labels[line[:-1]] = len(instructions)
        elif line and not line.startswith("."):
            jump = re.match(r"j\w+\s+(\S+)", line)
            if jump and jump[1] in labels:
                jumps.append((labels[jump[1]], len(instructions)))
            instructions.append(line)
    inner = [a for a in jumps if not any(a != b and a[0] <= b[0] and b[1] <= a[1] for b in jumps)]
    return [instructions[first : last + 1] for first, last in inner]


def wide(loop):
    """Instructions on registers of four or eight lanes."""
    return sum("%ymm" in line or "%zmm" in line for line in loop)


def scalar(loop):
    """Arithmetic on one number at a time."""
    arithmetic = re.compile(r"v(?!mov)\w+sd\b|vcvtt?sd2\w+|vcvtsi2sd\w*")
    return sum(bool(arithmetic.match(line)) and not wide([line]) for line in loop)


def is_vectorised(text, scalar_share):
    """Whether one loop does the work in wide registers; the loop over the last lanes may be scalar.

    Without a loop the pass is a plain fill, for which LLVM calls memset.
    """
    loops = innermost_loops(text)
    if not loops:
        return True
    rest = max(map(scalar, loops), default=0)
    return any(
        wide(loop) > 0 and scalar(loop) <= scalar_share * wide(loop) and 2 * wide(loop) >= rest
        for loop in loops
    )


def host_has(feature):
    return platform.machine() in ("x86_64", "AMD64") and llvm.get_host_cpu_features().get(feature, False)


@pytest.mark.skipif(
    config.DISABLE_JIT or not host_has("avx2"), reason="looks for the wide registers of x86-64 CPUs"
)
def test_every_lane_loop_is_vectorised():
    """One branch, table look-up or libm call in a loop over lanes makes it five times slower, and nothing else shows."""
    share, exceptions = 0.05, set(SCALAR_PASSES)
    if not host_has("avx512dq"):
        share, exceptions = 1.5, exceptions | SCALAR_WITHOUT_AVX512
    engine_passes = passes()
    assert set(SCALAR_PASSES) <= set(engine_passes)
    slow = [
        name
        for name, p in engine_passes.items()
        if name not in exceptions and not is_vectorised(assembly(p), share)
    ]
    assert slow == []


def branching(b, table, first, live):
    """A pass as it must not be: a branch with a store in it, and a recurrence from lane to lane."""
    for k in range(first, live):
        if b.weight[k] < 0.5:
            b.x[k] = b.y[k - 1] * b.x[k - 1]
        else:
            b.bin[b.hit[k]] += 1
    return live


@pytest.mark.skipif(
    config.DISABLE_JIT or not host_has("avx2"), reason="looks for the wide registers of x86-64 CPUs"
)
def test_a_loop_that_is_not_vectorised_is_seen():
    assert not is_vectorised(assembly(Pass(branching, passes()["move"].table)), 1.5)
