"""What the effects that a scene does not have cost it: the whole engine against one without their source, same digits asked for.

python -m tests.bench.stripped [--pairs 9] [--particles 4e7]

Two copies of the library: the sources as they are, and the same from which every pass that the closed diffuse box does not
call for is removed, with the files of which nothing is left, the fields of bundles that only they name, and the driver's
branches for copies, shadow rays and flights in media.  Whole processes, both at a time on one core, CPU time of each, medians of the ratios.
"""

import argparse
import ast
import os
import shutil
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path

import numpy as np

import transport
from tests.bench.prices import base_room
from transport.compile.compiler import compile_scene
from transport.engine.program import build_program
from transport.engine.registry import LANE_FIELDS, MODULES, Pass

LIBRARY = Path(transport.__file__).parent
CHILD = """
import sys, time
import transport as tp
walls = [tp.Surface(face, tp.Diffuse(0.5), name) for name, face in tp.Box(size=2.0).faces().items()]
lamp = tp.Source("+z", tp.Lambertian(exitance=1.0), side="back")
scene = tp.Scene([lamp], walls, [tp.Detector("-z", "floor", side="back")])
tp.simulate(scene, 1000, seed=2, threads=1, progress=False)  # loads what there is to load
begun = time.process_time()
result = tp.simulate(scene, int(float(sys.argv[1])), seed=1, threads=1, progress=False)
print(time.process_time() - begun, repr(result["floor"].irradiance.value), tp.__file__)
"""
FOR_OTHERS = {
    "_trace_shadow_rays",
    "_trace_waiting_rays",
    "_fly_until_few",
}  # what the driver calls for effects that the box does not have


def main() -> None:
    """Make both copies, run them in turns, print medians and the ratio."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--pairs", type=int, default=9)
    options.add_argument("--particles", default="4e7")
    asked = options.parse_args()
    with tempfile.TemporaryDirectory(prefix="transport-stripped-") as folder:
        whole, stripped = Path(folder, "whole"), Path(folder, "stripped")
        for copy in (whole, stripped):
            leave = shutil.ignore_patterns("__kernels__", "__pycache__")
            shutil.copytree(LIBRARY, copy / LIBRARY.name, ignore=leave)
        print(strip(stripped / LIBRARY.name / "engine"), flush=True)
        spent([whole, stripped], "1e5")  # compiles
        pairs, order = [], [whole, stripped]
        for _ in range(asked.pairs):  # each in turn goes first
            found = dict(zip(order, spent(order, asked.particles), strict=True))
            pairs.append([found[copy][:2] for copy in (whole, stripped)])
            assert found[whole][2] == found[stripped][2], "other digits: not the same work"
            print(*(f"{copy.name} {found[copy][0]:.3f} s" for copy in order), flush=True)
            order.reverse()
    report(np.array(pairs))


def report(pairs: np.ndarray) -> None:
    """pairs: CPU seconds (pairs, whole or stripped, process or run)."""
    for k, title in enumerate(("whole process", "the run alone")):
        whole, stripped = pairs[:, 0, k], pairs[:, 1, k]
        ratios = np.sort(whole / stripped)
        print(
            f"{title:14} as it is {np.median(whole):.3f} s, stripped {np.median(stripped):.3f} s, "
            f"ratio {np.median(ratios):.4f} (of {len(ratios)} pairs from {ratios[0]:.3f} to {ratios[-1]:.3f}), "
            f"of the least of each {whole.min() / stripped.min():.4f}"
        )


def spent(copies: list[Path], particles: str) -> list[tuple[float, float, str]]:
    """For each copy the CPU seconds of a process that runs the box with it, and of the run in it; and its digits.

    They go at the same time and on the same core, so that whatever else the machine does slows them alike.
    """
    core = {min(os.sched_getaffinity(0))}
    children = []
    for copy in copies:
        environment = {**os.environ, "PYTHONPATH": str(copy), "PYTHONSAFEPATH": "1"}
        started = subprocess.Popen(
            [sys.executable, "-c", CHILD, particles], env=environment, stdout=subprocess.PIPE, text=True
        )
        os.sched_setaffinity(started.pid, core)
        children.append(started)
    return [_spent_by(child, copy) for child, copy in zip(children, copies, strict=True)]


def _spent_by(child: subprocess.Popen, copy: Path) -> tuple[float, float, str]:
    told = child.stdout.read().split()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode or not told[2].startswith(str(copy)):
        raise RuntimeError(f"{copy.name}: status {child.returncode}, {told}")
    return usage.ru_utime + usage.ru_stime, float(told[0]), told[1]


def strip(engine: Path) -> str:
    """Remove what the box does not call for from the engine in that folder; what was removed, in words."""
    program = build_program(compile_scene(base_room().scene))
    kept = {lane_pass.name for lane_pass in program.passes}
    fields = {name for lane_pass in program.passes for name in lane_pass.fields}
    lines = sum(_lines(path) for path in engine.glob("*.py"))
    gone, empty = 0, 0
    for family in MODULES.values():
        names = {each.name for each in vars(family).values() if isinstance(each, Pass)}
        path = engine / Path(family.__file__).name
        gone += len(names - kept)
        empty += not names & kept
        path.write_text(
            _without(path.read_text(), names - kept) if names & kept else _bare(engine, path.stem)
        )
    _rewrite(engine / "driver.py", _PlainDriver())
    _rewrite(engine / "bundle.py", _FewFields(fields))
    left = sum(_lines(path) for path in engine.glob("*.py"))
    return (
        f"stripped: {gone} of {gone + len(kept)} passes, {empty} of {len(MODULES)} files of passes emptied, "
        f"{len(LANE_FIELDS) - len(fields)} of {len(LANE_FIELDS)} fields, {lines} lines of engine/ to {left}"
    )


def _without(source: str, names: set[str]) -> str:
    """A file without these functions, and without those that then nothing in it names."""
    tree = ast.parse(source)
    while names:
        tree.body = [part for part in tree.body if getattr(part, "name", None) not in names]
        used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        names = {
            part.name
            for part in tree.body
            if isinstance(part, ast.FunctionDef) and part.name not in used and not _is_pass(part)
        } - OFFERED
    return ast.unparse(tree)


def _is_pass(part: ast.FunctionDef) -> bool:
    return any("lane_pass" in ast.unparse(decorator) for decorator in part.decorator_list)


def _offered() -> set[str]:
    """Names that one file of the engine takes from another."""
    nodes = [
        node for path in (LIBRARY / "engine").glob("*.py") for node in ast.walk(ast.parse(path.read_text()))
    ]
    imported = {alias.name for node in nodes if isinstance(node, ast.ImportFrom) for alias in node.names}
    return imported | {node.attr for node in nodes if isinstance(node, ast.Attribute)}


OFFERED = _offered()


def _bare(engine: Path, module: str) -> str:
    """A file in which only the numbers are left that other files take from it."""
    wanted = {
        alias.name
        for path in engine.glob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ImportFrom) and node.module == f"transport.engine.{module}"
        for alias in node.names
    }
    values = vars(import_module(f"transport.engine.{module}"))
    numbers = {name: values[name] if isinstance(values[name], int) else None for name in sorted(wanted)}
    return "".join(f"{name} = {value!r}\n" for name, value in numbers.items())


def _rewrite(path: Path, change: ast.NodeTransformer) -> None:
    path.write_text(ast.unparse(change.visit(ast.parse(path.read_text()))))


def _lines(path: Path) -> int:
    return len(path.read_text().splitlines())


class _PlainDriver(ast.NodeTransformer):
    """The driver for steps that all lanes take: no copies, no shadow rays, no rounds of flights in a medium."""

    def visit_FunctionDef(self, node):
        return None if node.name in FOR_OTHERS else self.generic_visit(node)

    def visit_Expr(self, node):
        calls = isinstance(node.value, ast.Call) and getattr(node.value.func, "id", "") in FOR_OTHERS
        return None if calls else self.generic_visit(node)

    def visit_While(self, node):
        return None if "b.banked" in ast.unparse(node.test) else self.generic_visit(node)

    def visit_If(self, node):
        if ast.unparse(node.test) == "inner > 0":
            return None
        if "b.bank_overflow" in ast.unparse(
            node.test
        ):  # of these only being stopped is left, and too many crossings
            node.test = ast.parse("b.stop != 0 or b.crossings >= MOST_CROSSINGS", mode="eval").body
        return None if "copied >" in ast.unparse(node.test) else self.generic_visit(node)

    def visit_IfExp(self, node):
        return ast.Constant(0) if ast.unparse(node.test) == "inner > 0" else self.generic_visit(node)


class _FewFields(ast.NodeTransformer):
    """Bundles of these fields only."""

    def __init__(self, fields: set[str]) -> None:
        self.fields = fields

    def visit_Assign(self, node):
        if getattr(node.targets[0], "id", "") in ("CARRIED", "SCRATCH"):
            node.value.elts = [pair for pair in node.value.elts if pair.elts[0].value in self.fields]
        return node


if __name__ == "__main__":
    main()
