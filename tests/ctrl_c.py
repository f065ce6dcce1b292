"""Ctrl-C in a test, also where the suite ignores it: under nohup, or in the background of a shell script.

A process that is started there inherits that SIGINT is ignored, and Python then installs no handler that raises
KeyboardInterrupt.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def pressing_ctrl_c(handler: object = signal.default_int_handler) -> Iterator[Callable[..., None]]:
    """Yield a function that sends SIGINT to this process, now or after=seconds; none is sent once the context has ended.

    handler: what SIGINT calls within the context; by default it raises KeyboardInterrupt, as in a terminal.
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
