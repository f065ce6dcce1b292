"""Price list: CPU time of a treatment without and with each addition, run in turns; medians over the turns.

Differences and ratios are taken within a turn, so that other load of the machine affects both sides.
"""

import math
import time
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass

import numpy as np

from transport.command.additions import Addition
from transport.command.footprints import Footprint, footprint_of
from transport.command.price_list import ADDITIONS, IN_ANY_SCENE, base_room, with_addition
from transport.command.treatment import Treatment
from transport.compile.limits_exceeded import OverrunError
from transport.runs.progress import progress_on
from transport.validation import SceneError

AS_IT_IS = "unchanged"
TURNS, SECONDS = 7, 0.05  # turns of the price list, and approximate time of a run [s]
MOST = 1 << 22  # largest number of histories of a run


@dataclass(frozen=True)
class Price:
    """Cost of a treatment per history, and the cost that its addition adds to the treatment `over`.

    `ns` and `added` are medians of CPU nanoseconds per history, `ratio` is the ratio of the two treatments.
    `events` is the number of crossings and collisions per history, `passes` the number of passes of the
    program.
    """

    name: str
    over: str | None
    ns: float
    added: float
    ratio: float
    events: float
    passes: int
    footprint: Footprint

    @property
    def ns_an_event(self) -> float:
        """CPU nanoseconds per crossing or collision; nan without events."""
        return self.ns / self.events if self.events else math.nan

    @property
    def record(self) -> dict[str, object]:
        """All values as one dictionary for JSON."""
        return asdict(self) | {"ns_an_event": self.ns_an_event}


@dataclass(frozen=True)
class PriceList:
    """Prices of additions to a treatment.

    `prices` starts with the unchanged treatment; `refused` maps the names of impossible additions to the
    reason; `idle` names additions that change nothing.
    """

    prices: tuple[Price, ...]
    refused: Mapping[str, str]
    idle: tuple[str, ...]


def base_prices(turns: int = TURNS, seconds: float = SECONDS) -> PriceList:
    """Measure the price list of all effects, relative to the base room."""
    return prices_of(base_room(), ADDITIONS.values(), turns, seconds)


def price_rows(turns: int = TURNS, share: int = 1) -> list[dict]:
    """Return the price list as benchmark rows {name, value, unit, ratio}; ratio is relative to `over`.

    Runs are shorter by the factor `share`.
    """
    prices = base_prices(turns, SECONDS / share).prices
    return [
        {
            "name": f"base room, {price.name}",
            "value": price.ns,
            "unit": "ns/history",
            "ratio": None if price.over is None else price.ratio,
        }
        for price in prices
    ]


def prices_in(scene: Treatment, turns: int = 3, seconds: float = 0.02) -> PriceList:
    """Measure the cost in this scene of each effect that can be added to any scene."""
    return prices_of(scene, IN_ANY_SCENE, turns, seconds)


def prices_of(treatment: Treatment, additions: Iterable[Addition], turns: int, seconds: float) -> PriceList:
    """Measure a treatment and each addition to it, with a progress bar during compilation."""
    found, refused, idle = {AS_IT_IS: (None, treatment)}, {}, []
    for addition in additions:
        try:
            before, after = (with_addition(name, treatment) for name in (addition.over, addition.name))
            _ = after.plan
        except SceneError as reason:
            refused[addition.name] = str(reason)
            continue
        if after == before:
            idle.append(addition.name)
        else:
            found[addition.name] = (before, after)
    wanted = dict.fromkeys(each for pair in found.values() for each in pair if each is not None)
    works, overruns = _works(wanted, seconds)
    refused |= {name: overruns[after] for name, (_, after) in found.items() if after in overruns}
    spent = _spent(works, turns)
    prices = [
        _price(name, _over(name, before, treatment), works[after], spent[after], spent[before or after])
        for name, (before, after) in found.items()
        if after in works and (before is None or before in works)
    ]
    return PriceList(tuple(prices), refused, tuple(idle))


def _over(name: str, before: Treatment | None, treatment: Treatment) -> str | None:
    """Return the name of the treatment that a price is relative to: the needed addition, or AS_IT_IS."""
    if before is None:
        return None
    return AS_IT_IS if before == treatment else ADDITIONS[name].over


class _Work:
    """A compiled treatment, with a number of histories whose run takes about `seconds`.

    Raises OverrunError.
    """

    def __init__(self, treatment: Treatment, seconds: float, compiling) -> None:
        from transport.engine.driver import machine_of
        from transport.engine.program import program_of

        self.program = program_of(treatment.plan)
        self.machine = machine_of(self.program, compiling)
        self.histories, self.events = 1 << 10, 0.0
        self.run(0)  # load everything before timing
        while (spent := self.run(0)) < 0.7 * seconds and self.histories < MOST:
            wanted = self.histories * seconds / max(spent, 1e-6)
            self.histories = min(MOST, max(2 * self.histories, 1 << round(math.log2(wanted))))

    def run(self, batch: int) -> float:
        """Run one batch and return its CPU time [s]; store the events per history."""
        from transport.engine.driver import run_batch

        begun = time.process_time()
        sums = run_batch(self.machine, 1, batch, self.histories)
        spent = time.process_time() - begun
        self.events = (sums.crossings + sums.collisions) / self.histories
        return spent


def _works(treatments: Iterable[Treatment], seconds: float) -> tuple[dict, dict]:
    """Compile each treatment; return the works, and the reason for each treatment that cannot run."""
    works, overruns = {}, {}
    with progress_on(None) as bar:
        for treatment in treatments:
            try:
                works[treatment] = _Work(treatment, seconds, bar.compiling)
            except OverrunError as reason:
                overruns[treatment] = str(reason)
    return works, overruns


def _spent(works: Mapping[Treatment, _Work], turns: int) -> dict[Treatment, np.ndarray]:
    """Return the CPU nanoseconds per history of each treatment, shape (turns,).

    The order rotates each turn, so that no treatment always follows the most expensive one.
    """
    spent, order = {treatment: np.zeros(turns) for treatment in works}, list(works)
    for turn in range(turns):
        for treatment in order[turn % len(order) :] + order[: turn % len(order)]:
            work = works[treatment]
            spent[treatment][turn] = 1e9 * work.run(turn + 1) / work.histories
    return spent


def _price(name: str, over: str | None, work: _Work, spent: np.ndarray, before: np.ndarray) -> Price:
    return Price(
        name,
        over,
        ns=float(np.median(spent)),
        added=float(np.median(spent - before)),
        ratio=float(np.median(spent / before)),
        events=work.events,
        passes=len(work.program.passes),
        footprint=footprint_of(work.program),
    )
