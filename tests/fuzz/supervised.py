"""Scenes in a process of their own, so that one that never ends, or that kills it, is a failure like others."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterator
from multiprocessing.connection import Connection

from tests.fuzz.numbered import TURNS, Outcome, outcome_of

KILLED = "process"  # how the failure of a scene begins after which another process is needed
PATIENCE = 60  # times the limit of processor time, that a scene may take on a busy machine


def outcomes_of(numbers: range, seed: int, limit: float) -> Iterator[Outcome]:
    """What comes of each scene, in order.  limit: seconds of processor time that one may take, with what it compiles."""
    context = multiprocessing.get_context("spawn")
    while numbers:
        here, there = context.Pipe(duplex=False)
        worker = context.Process(target=_work, args=(there, numbers, seed, limit), daemon=True)
        worker.start()
        there.close()
        for number in numbers:
            outcome = _received(here, number, PATIENCE * limit)
            yield outcome
            numbers = range(number + 1, numbers.stop)
            if outcome.failed.startswith(KILLED):
                break
        worker.kill()
        worker.join()


def _work(there: Connection, numbers: range, seed: int, limit: float) -> None:
    """Send the outcomes.  A timer of processor time ends the process, compiled loops and all."""
    for number in numbers:
        signal.setitimer(signal.ITIMER_PROF, limit)
        there.send(outcome_of(number, seed))


def _received(here: Connection, number: int, patience: float) -> Outcome:
    family = TURNS[number % len(TURNS)]
    if not here.poll(patience):
        return Outcome(number, family, failed=f"{KILLED}: no end within {patience:g} s", seconds=patience)
    try:
        return here.recv()
    except EOFError:
        return Outcome(number, family, failed=f"{KILLED}: it died, or took more than its limit")
