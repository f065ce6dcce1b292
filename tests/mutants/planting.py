"""Plants a fault in a copy of the project, and runs the tests there that are to see it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.mutants import kernels
from tests.mutants.fault import ROOT, Fault

# Of the project, and where a copy has it: sims and viz as parts of the package, so that they are the copy's own.
COPIED = {
    "transport": "transport", "sims": "transport/sims", "viz": "transport/viz", "tests": "tests",
    "pyproject.toml": "pyproject.toml", "README.md": "README.md",
}  # fmt: skip
LEFT_OUT = shutil.ignore_patterns("__kernels__", "__pycache__", ".*")
PATIENCE = 300.0  # seconds, after which a run is taken for endless
SHOWN = ("FAILED ", "ERROR ")
ENDLESS = "endless"
LAST_WORDS = 20  # lines of a run that failed without a test's name


@dataclass(frozen=True)
class Outcome:
    """What the tests made of a fault."""

    fault: Fault
    caught_by: str | None  # the first test that failed, or how the run ended; None where all passed
    seconds: float


class Copy:
    """A copy of the working tree in a folder of its own, with machine code of its own."""

    def __init__(self, folder: Path) -> None:
        self.root = folder
        for name, place in COPIED.items():
            source, copy = ROOT / name, folder / place
            if source.is_dir():
                shutil.copytree(source, copy, ignore=LEFT_OUT)
            else:
                shutil.copy2(source, copy)
        kernels.take_over(folder)
        self.sound = kernels.name_of(folder)

    def with_fault(self, fault: Fault) -> Outcome:
        """What the fault's tests say while it is planted; the copy is as before afterwards."""
        path = self.root / fault.path
        text, times = path.read_text(), (path.stat().st_atime_ns, path.stat().st_mtime_ns)
        path.write_text(fault.planted(text))
        own = kernels.keep_untouched(self.root, self.sound, fault.file) if fault.is_compiled else None
        begun = time.perf_counter()
        try:
            failed = self.failed(fault.nodes)
        finally:
            path.write_text(text)
            os.utime(path, ns=times)  # the byte code of the sound text is the right one again
            if own is not None:
                shutil.rmtree(own)
        return Outcome(fault, failed, time.perf_counter() - begun)

    def failed(self, nodes: Iterable[str], patience: float | None = PATIENCE) -> str | None:
        """The first of these tests of the default suite that fails; None where all pass, or where all are slow.

        Raises RuntimeError where they do not even run.
        """
        command = [sys.executable, "-m", "pytest", "-x", "-q", "--tb=no", "-rfE"]
        surroundings = os.environ | {"PYTHONPATH": str(self.root)}
        try:
            run = subprocess.run(
                [*command, *nodes], cwd=self.root, env=surroundings, capture_output=True, text=True,
                timeout=patience, check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return ENDLESS
        if run.returncode in (0, pytest.ExitCode.NO_TESTS_COLLECTED):
            return None
        names = [
            line.split(" - ")[0].split(" ", 1)[1]
            for line in run.stdout.splitlines()
            if line.startswith(SHOWN)
        ]
        if not names and run.returncode > 0:
            raise RuntimeError("\n".join((run.stdout + run.stderr).splitlines()[-LAST_WORDS:]))
        return names[0].removeprefix("tests/") if names else f"ended by signal {-run.returncode}"
