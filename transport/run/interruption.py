"""Delay Ctrl-C until the end of a batch, never within the bookkeeping of a batch or the writing of a file.

A KeyboardInterrupt may come anywhere, also after a batch has left the executor and before the run has stored
it. A saved run would then lack the batch although its counters include it.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

DELAYED_INTERRUPTS = 2  # Ctrl-C is delayed that many times; the next one interrupts at once


class Interruption:
    """The pending Ctrl-C of a run, checked between batches.

    Before the run begins, Ctrl-C is immediate.
    """

    has_begun, times = False, 0

    def begin(self) -> None:
        """Delay Ctrl-C from now on."""
        self.has_begun = True

    def check(self) -> None:
        """Raise KeyboardInterrupt if Ctrl-C was pressed since the run began."""
        if self.times:
            raise KeyboardInterrupt

    def _remember(self, *_: object) -> None:
        self.times += 1
        if not self.has_begun:
            raise KeyboardInterrupt("interrupted before the run began, so there is no result")
        if self.times > DELAYED_INTERRUPTS:
            raise KeyboardInterrupt


@contextmanager
def delay_interrupts() -> Iterator[Interruption]:
    """Delay Ctrl-C within the context.

    Change nothing where Ctrl-C would not raise KeyboardInterrupt in this thread.
    """
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
