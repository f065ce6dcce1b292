"""Scenes in a process of their own, so that one that kills it is a failure like others, and one without an end is told as too slow."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterator
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

from tests.fuzz.numbered import TURNS, Outcome, outcome_of

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
            outcome = received(here, number, worker, PATIENCE * limit)
            yield outcome
            numbers = range(number + 1, numbers.stop)
            if not worker.is_alive():
                break
        worker.kill()
        worker.join()


def _work(there: Connection, numbers: range, seed: int, limit: float) -> None:
    """Send the outcomes.  A timer of processor time ends the process, compiled loops and all."""
    for number in numbers:
        signal.setitimer(signal.ITIMER_PROF, limit)
        there.send(outcome_of(number, seed))


def received(here: Connection, number: int, worker: BaseProcess, patience: float) -> Outcome:
    """What the worker sends of a scene within so many seconds; the worker is dead if it was nothing."""
    family = TURNS[number % len(TURNS)]
    if not here.poll(patience):
        worker.kill()
        worker.join()
        return Outcome(number, family, slow=f"no end within {patience:g} s", seconds=patience)
    try:
        return here.recv()
    except EOFError:
        worker.join()
    if worker.exitcode == -signal.SIGPROF:
        return Outcome(number, family, slow="no end within its seconds of processor time")
    return Outcome(number, family, failed=f"its process died, exit code {worker.exitcode}")
