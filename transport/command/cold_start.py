"""How long the first run of a kind of scene takes to compile: measured in a process of its own, with nothing on disk."""

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

from transport.command.treatment import Treatment
from transport.validation import SceneError

LIBRARY = Path(__file__).resolve().parents[1]
CHILD = "from transport.command.cold_start import compile_here; compile_here()"


@dataclass(frozen=True)
class Start:
    """passes: of the program;  on_disk: of these, those whose machine code lay on disk;  seconds: of CPU time to have them all;
    driver: CPU seconds to have what calls them, once for all scenes;  bytes: of machine code on disk then.
    """

    passes: int
    on_disk: int
    seconds: float
    driver: float
    bytes: int


def cold_start(treatment: Treatment) -> Start:
    """The first start of a treatment in a copy of the library without machine code.  Raises SceneError if it cannot be sent there."""
    with copied_library() as folder:
        return next(starts_in(folder, [treatment]))


@contextmanager
def copied_library() -> Iterator[Path]:
    """A temporary folder with the library's sources, and no machine code."""
    with tempfile.TemporaryDirectory(prefix="transport-cold-") as folder:
        leave = shutil.ignore_patterns("__kernels__", "__pycache__")
        shutil.copytree(LIBRARY, Path(folder, LIBRARY.name), ignore=leave)
        yield Path(folder)


def starts_in(folder: Path, treatments: Iterable[Treatment]) -> Iterator[Start]:
    """Starts of treatments in the copy of the library in that folder, each in a process of its own, one after another."""
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
    """In the new process: read a treatment, run it for a moment, write its Start."""
    start = start_of(pickle.load(sys.stdin.buffer))
    sys.stdout.buffer.write(pickle.dumps(start))


def start_of(treatment: Treatment, compiling=None) -> Start:
    """Compile or load all that a treatment needs, and run a history; `compiling(done, of, name)` before each pass."""
    import time

    from transport.engine.cache import kernel_folder
    from transport.engine.driver import machine_of, run_batch
    from transport.engine.program import program_of

    program = program_of(treatment.plan)
    begun = time.process_time()
    machine = machine_of(program, compiling)
    ready = time.process_time()
    run_batch(machine, 1, 0, 1)
    done = time.process_time()
    on_disk = sum(is_from_disk(lane_pass) for lane_pass in program.passes)
    size = sum(path.stat().st_size for path in kernel_folder().rglob("*") if path.is_file())
    return Start(len(program.passes), on_disk, ready - begun, done - ready, size)


def is_from_disk(lane_pass) -> bool:
    """Whether a pass was loaded, not compiled, by this process."""
    return getattr(lane_pass.compiled, "cache_hits", 0) > 0
