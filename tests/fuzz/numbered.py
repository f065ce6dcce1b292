"""Random scenes by number: (seed, number) always makes the same one, and what is checked of it."""

from __future__ import annotations

import random
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass

from hypothesis import given, settings

from tests.fuzz.agreements import check_furnace, check_ways
from tests.fuzz.gases import check_gas, gases
from tests.fuzz.lefts import check_left
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
