"""What is alive at an instant is what a run that ends there has left: all that was emitted, but for what has gone by then."""

from __future__ import annotations

import dataclasses

import transport as tp
from tests.fuzz.agreements import checked
from tests.fuzz.runs import Scores, run_of, sound
from tests.fuzz.worlds import World
from transport.scene.sources import Source

SHARE = 0.8  # of the clock's time, after all pulses


def check_left(world: World) -> list[str]:
    """A look at an instant, and a sample then, against a run whose clock ends there.  Raises AssertionError."""
    return checked(lambda seed, more: _differences(world, seed, more))


def _differences(world: World, seed: int, more: int) -> Scores:
    """Scores of what is alive, and of what its sample says, less what the ledger of a shorter run has in flight."""
    instant = SHARE * world.parts["duration"]
    looks = [
        tp.PhaseSpace(mu=2, time=instant, name="alive"),
        tp.Snapshot(instant, 10_000_000, "all"),
        tp.Snapshot(instant, 5_000, "few"),
    ]
    result = run_of(world.with_detectors(*looks), seed, more)
    shorter = run_of(_cut(world, instant), seed + 100, more).ledger
    alive, emitted = result["alive"].alive, result.ledger["emitted"].value
    summed = result["all"].weights.sum()
    assert abs(summed - alive.value) <= 1e-12 * emitted, f"a sample of all has {summed}, alive are {alive}"
    gone = ("absorbed", "escaped", "roulette", "unsampled", "lost")
    rest = shorter["emitted"] - sum((shorter[name] for name in gone[1:]), shorter[gone[0]])
    found = {}
    if sound(result, "alive.alive") is not None and 0 < rest.relative_error < 0.1:
        found["alive less emitted and not gone"] = float((alive - rest).z(0.0))
    return found


def _cut(world: World, instant: float) -> World:
    """The same until the instant, with nothing that looks at it."""
    sources = tuple(_until(source) for source in world.parts["sources"])
    parts = world.parts | {"sources": sources, "detectors": (), "duration": instant}
    return dataclasses.replace(world, parts=parts)


def _until(source: Source) -> Source:
    """A source that sends out its number over the whole clock sends out its share until then."""
    emission = source.emission
    if isinstance(emission, tp.Effusive) and emission.number is not None and source.pulse is None:
        return dataclasses.replace(
            source, emission=dataclasses.replace(emission, number=SHARE * emission.number)
        )
    return source
