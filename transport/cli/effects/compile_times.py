"""Compilation time of a scene's program, measured in a new process with an empty cache."""

import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from transport.cli.effects.treatment import Treatment
from transport.validation import SceneError

LIBRARY = Path(__file__).resolve().parents[2]
CHILD = "from transport.cli.effects.compile_times import compile_here; compile_here()"


@dataclass(frozen=True)
class CompileTime:
    """Cost of the first run of a program in a process.

    `passes` is the number of passes, `on_disk` the number of those loaded from the cache.  `seconds` is the
    CPU time that compiled or loaded them, `driver` the CPU time [s] for the driver that calls them (the same
    for all scenes).  `bytes` is the size of the machine code on disk afterwards.
    """

    passes: int
    on_disk: int
    seconds: float
    driver: float
    bytes: int


def cold_compile_time(treatment: Treatment) -> CompileTime:
    """Start a treatment in a copy of the library without machine code.

    Raises SceneError if the treatment cannot be pickled.
    """
    with library_copy() as folder:
        return next(compile_times_in(folder, [treatment]))


@contextmanager
def library_copy() -> Iterator[Path]:
    """Yield a temporary folder with a copy of the library's sources, without machine code."""
    with tempfile.TemporaryDirectory(prefix="transport-cold-") as folder:
        leave = shutil.ignore_patterns("__kernels__", "__pycache__")
        shutil.copytree(LIBRARY, Path(folder, LIBRARY.name), ignore=leave)
        yield Path(folder)


def compile_times_in(folder: Path, treatments: Iterable[Treatment]) -> Iterator[CompileTime]:
    """Yield the Start of each treatment, in a new process each, with the library of `folder`."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONSAFEPATH": "1"}
    for treatment in treatments:
        try:
            sent = pickle.dumps(treatment)
        except (pickle.PicklingError, AttributeError, TypeError) as reason:
            raise SceneError(f"cold start: this scene cannot be sent to a new process: {reason}") from reason
        done = subprocess.run(
            [sys.executable, "-c", CHILD], input=sent, env=environment, capture_output=True, check=False
        )
        if done.returncode:
            raise RuntimeError(f"cold start: {done.stderr.decode(errors='replace')[-2000:]}")
        yield pickle.loads(done.stdout)


def compile_here() -> None:
    """Read a treatment from standard input, start it, and write its Start; runs in the new process."""
    start = compile_time_of(pickle.load(sys.stdin.buffer))
    sys.stdout.buffer.write(pickle.dumps(start))


def compile_time_of(treatment: Treatment, compiling=None) -> CompileTime:
    """Compile or load the program of a treatment, and run one history.

    Calls `compiling(done, of, name)` before each pass.
    """
    import time

    from transport.engine.cache import kernel_folder
    from transport.engine.driver import compile_program, run_batch

    program = treatment.program
    begun = time.process_time()
    machine = compile_program(program, compiling)
    ready = time.process_time()
    run_batch(machine, 1, 0, 1)
    done = time.process_time()
    on_disk = sum(is_cached(lane_pass) for lane_pass in program.passes)
    size = sum(path.stat().st_size for path in kernel_folder().rglob("*") if path.is_file())
    return CompileTime(len(program.passes), on_disk, ready - begun, done - ready, size)


def is_cached(lane_pass) -> bool:
    """Return whether this process loaded the pass from the cache instead of compiling it."""
    return getattr(lane_pass.compiled, "cache_hits", 0) > 0
