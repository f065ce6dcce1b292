"""Processes of the tests: linear algebra on one thread, Python in a new interpreter, Ctrl-C.

Imported before numpy is: two workers of the suite whose linear algebra takes all cores wait for each other, and small
systems of equations take twenty times as long.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

for library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def python(*arguments: object, folder: Path = ROOT, status: int | None = 0, **environment: str):
    """Run Python with these arguments in a folder and return the ended process, with its output as text.

    It finds the library and the tests of this clone.  Fails unless it ends with this exit status; None allows any.
    """
    done = subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT)} | environment,
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert status is None or done.returncode == status, done.stderr[-3000:]
    return done


def elsewhere(code: str, **environment: str):
    """Return the value of an expression in a new interpreter, by JSON; it imports the module that the expression names."""
    module = code.partition("(")[0].rpartition(".")[0]
    printed = python("-c", f"import json; import {module}; print(json.dumps({code}))", **environment).stdout
    return json.loads(printed.splitlines()[-1])


@contextmanager
def pressing_ctrl_c(handler: object = signal.default_int_handler) -> Iterator[Callable[..., None]]:
    """Yield a function that sends SIGINT to this process, now or after=seconds; none is sent once the context has ended.

    handler: what SIGINT calls within the context; by default it raises KeyboardInterrupt, as in a terminal, also where the
    suite inherited that SIGINT is ignored: under nohup, or in the background of a shell script.
    """
    timers: list[threading.Timer] = []

    def press(after: float = 0.0) -> None:
        if after == 0.0:
            os.kill(os.getpid(), signal.SIGINT)
        else:
            timers.append(threading.Timer(after, press))
            timers[-1].start()

    usual = signal.signal(signal.SIGINT, handler)
    try:
        yield press
    finally:
        for timer in timers:
            timer.cancel()
            timer.join()
        signal.signal(signal.SIGINT, usual)
