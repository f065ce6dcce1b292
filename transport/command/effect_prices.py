"""What each effect more costs: a treatment as it is and with each addition, run in turns, medians of CPU time.

Differences and ratios are taken within a turn, so that what else the machine does falls on both sides.
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

AS_IT_IS = "as it is"
TURNS, SECONDS = 7, 0.05  # of the price list: how often each is run, and about how long [s]
MOST = 1 << 22  # histories of a run


@dataclass(frozen=True)
class Price:
    """What a treatment costs a history, and what the addition adds to that of the treatment `over` which it was put.

    ns, added: CPU nanoseconds a history, medians;  ratio: of both;  events: crossings and collisions of a history;
    passes: of its program.
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
        """Nanoseconds of a crossing or collision."""
        return self.ns / self.events if self.events else math.nan

    @property
    def record(self) -> dict[str, object]:
        """All of it for machines."""
        return asdict(self) | {"ns_an_event": self.ns_an_event}


@dataclass(frozen=True)
class PriceList:
    """Prices, the treatment as it is first; why others cannot be, by name; and what is there already or has nothing to do."""

    prices: tuple[Price, ...]
    refused: Mapping[str, str]
    idle: tuple[str, ...]


def base_prices(turns: int = TURNS, seconds: float = SECONDS) -> PriceList:
    """The price list of every effect over the base room."""
    return prices_of(base_room(), ADDITIONS.values(), turns, seconds)


def price_rows(turns: int = TURNS, share: int = 1) -> list[dict]:
    """The price list as rows {name, value, unit, ratio} of the benchmark; ratio: over what the effect was added to.

    share: by how much shorter the runs are.
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
    """What each effect that goes with any scene would cost in this one."""
    return prices_of(scene, IN_ANY_SCENE, turns, seconds)


def prices_of(treatment: Treatment, additions: Iterable[Addition], turns: int, seconds: float) -> PriceList:
    """Measure a treatment and what each addition adds.  A bar names what is compiled meanwhile."""
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
    """What an addition is told over: what it needs, or the scene as it is where that is in it already."""
    if before is None:
        return None
    return AS_IT_IS if before == treatment else ADDITIONS[name].over


class _Work:
    """A treatment made ready, and so many histories that a run takes about so long [s].  Raises OverrunError."""

    def __init__(self, treatment: Treatment, seconds: float, compiling) -> None:
        from transport.engine.driver import machine_of
        from transport.engine.program import program_of

        self.program = program_of(treatment.plan)
        self.machine = machine_of(self.program, compiling)
        self.histories, self.events = 1 << 10, 0.0
        self.run(0)  # loads what is still to be loaded
        while (spent := self.run(0)) < 0.7 * seconds and self.histories < MOST:
            wanted = self.histories * seconds / max(spent, 1e-6)
            self.histories = min(MOST, max(2 * self.histories, 1 << round(math.log2(wanted))))

    def run(self, batch: int) -> float:
        """CPU nanoseconds a history of one batch, as seconds of it where histories are still being chosen."""
        from transport.engine.driver import run_batch

        begun = time.process_time()
        sums = run_batch(self.machine, 1, batch, self.histories)
        spent = time.process_time() - begun
        self.events = (sums.crossings + sums.collisions) / self.histories
        return spent


def _works(treatments: Iterable[Treatment], seconds: float) -> tuple[dict, dict]:
    """Each treatment made ready, and for those that cannot be run the reason."""
    works, overruns = {}, {}
    with progress_on(None) as bar:
        for treatment in treatments:
            try:
                works[treatment] = _Work(treatment, seconds, bar.compiling)
            except OverrunError as reason:
                overruns[treatment] = str(reason)
    return works, overruns


def _spent(works: Mapping[Treatment, _Work], turns: int) -> dict[Treatment, np.ndarray]:
    """CPU nanoseconds a history of each, (turns,); each turn in another order, lest one always come after the dearest."""
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
