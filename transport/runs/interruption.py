"""Ctrl-C between two batches: never while one is being taken, or a file is being written.

A KeyboardInterrupt may come anywhere, also after a batch has left the crew and before the run has it: then the run that is
saved would lack it, and its numbers say that it is there.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 2  # times Ctrl-C, of which the last is not put off


class Interruption:
    """What `Run` asks between batches, once it has begun; before, Ctrl-C comes at once."""

    has_begun, times = False, 0

    def begin(self) -> None:
        """Put Ctrl-C off from now on."""
        self.has_begun = True

    def check(self) -> None:
        """Raise KeyboardInterrupt where Ctrl-C was pressed since."""
        if self.times:
            raise KeyboardInterrupt

    def _remember(self, *_: object) -> None:
        self.times += 1
        if not self.has_begun or self.times > PATIENCE:
            raise KeyboardInterrupt


@contextmanager
def put_off() -> Iterator[Interruption]:
    """From where it begins Ctrl-C is remembered, where it would raise KeyboardInterrupt in this thread; else nothing is changed."""
    interruption = Interruption()
    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield interruption
        return
    signal.signal(signal.SIGINT, interruption._remember)
    try:
        yield interruption
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
