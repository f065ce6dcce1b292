"""Random scenes by number: (seed, number) always makes the same one, and what is checked of it."""

from __future__ import annotations

import multiprocessing
import random
import signal
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

from hypothesis import given, settings

from tests.fuzz.agreements import check_furnace, check_left, check_ways
from tests.fuzz.gases import check_gas, gases
from tests.fuzz.properties import check, check_or_refused
from tests.fuzz.rooms import furnaces
from tests.fuzz.views import seen_worlds
from tests.fuzz.worlds import World, bright_worlds, clocked_worlds, worlds

BYTES = 8192  # of random numbers, of which a scene is drawn
FAMILIES = {
    "views": (seen_worlds(), check),
    "worlds": (worlds(), check),
    "furnaces": (furnaces(), check_furnace),
    "gases": (gases(), check_gas),
    "clocks": (clocked_worlds(), check_left),
    "ways": (bright_worlds(), check_ways),
}
TURNS = (  # which family a number belongs to, in turn
    *("worlds", "views", "worlds", "furnaces", "worlds", "gases", "worlds", "views", "worlds", "ways"),
    *("worlds", "furnaces", "worlds", "clocks", "worlds", "views", "worlds", "furnaces", "worlds", "ways"),
)


@dataclass(frozen=True)
class Outcome:
    """What came of one scene.

    refused: its message, if it was;  failed: what did not hold, if anything;  slow: how long it was waited for in vain, in
    words, of a scene that is neither right nor wrong then;  snippet: the scene as Python, of a failure.
    """

    number: int
    family: str
    checks: int = 0
    refused: str = ""
    failed: str = ""
    slow: str = ""
    snippet: str = ""
    seconds: float = 0.0


def world_of(number: int, seed: int, family: str) -> World:
    """The world of that number: drawn from random bytes of its own."""
    found = []

    @settings(database=None, deadline=None)
    @given(FAMILIES[family][0])
    def keep(world: World) -> None:
        found.append(world)

    keep.hypothesis.fuzz_one_input(random.Random(f"{seed} {number}").randbytes(BYTES))
    return found[-1]


def outcome_of(number: int, seed: int) -> Outcome:
    """Make the scene of that number, run it and check it."""
    family = TURNS[number % len(TURNS)]
    begun = time.perf_counter()
    found = _looked_at(world_of(number, seed, family), FAMILIES[family][1])
    return Outcome(number, family, **found, seconds=time.perf_counter() - begun)


def _looked_at(world: World, look: Callable[[World], list[str]]) -> dict[str, object]:
    """What the checks say of a world, as parameters of an Outcome."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)  # numbers that are no numbers, on the way
            names, refused = check_or_refused(world, look)
    except Exception as error:
        return {"failed": f"{type(error).__name__}: {error}", "snippet": str(world)}
    return {"checks": 0 if refused else len(names), "refused": refused}


# ---- each in a process that may die or never end: a failure like others, or too slow ----

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
