"""What a run has done so far: all that it takes to go on with it, bit for bit.

Batches are pure functions of their numbers, so it is the batches that were taken, where among the others they stand, and
what the run knew when it last looked.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from transport.results.batches import Batch
from transport.runs.limits import Limits
from transport.runs.origins import Origin
from transport.runs.schedules import Leg, Schedule, batches_in
from transport.runs.stopping import Look


@dataclass(frozen=True)
class State:
    """A run between two of its batches.

    kind: of its schedule, whose numbers are `remembered`;  leg, done: the leg under way, and how many of its batches are
    taken;  next: the number of the next batch;  ahead: batches that were done before their turn came;  particles, crossings,
    collisions: all that were followed, with those of rounds that a later one has replaced;  seconds: of wall clock;
    origins: who did them, where that was not this very process alone.
    """

    limits: Limits
    kind: str
    remembered: dict[str, int]
    batches: list[Batch]
    current: list[Batch]
    leg: Leg
    done: int
    next: int
    ahead: dict[int, Batch] = field(default_factory=dict)
    looks: list[Look] = field(default_factory=list)
    particles: int = 0
    crossings: int = 0
    collisions: int = 0
    seconds: float = 0.0
    origins: tuple[Origin, ...] = ()

    @property
    def is_under_way(self) -> bool:
        """Whether batches of the last leg are missing."""
        return self.done < batches_in(self.leg)


def put_back(state: State, schedule: Schedule) -> bool:
    """Let a new schedule go on where the saved one stood.

    Exactly there where it is of the same kind, and so returns; else with the batches that the run would have kept: so too
    where fewer particles are asked for now than the leg under way would come to.
    """
    schedule.batches, schedule.current = list(state.batches), list(state.current)
    is_alike = type(schedule).__name__ == state.kind and not _goes_too_far(state, schedule.limits)
    if is_alike:
        for name, number in state.remembered.items():
            setattr(schedule, name, number)
    else:
        schedule.batches, schedule.current = schedule.batches or schedule.current, []
        schedule.adopt()
    return is_alike


def _goes_too_far(state: State, limits: Limits) -> bool:
    """Whether the leg under way goes beyond the particles that are asked for now."""
    asked, was = limits.particles, state.limits.particles
    is_less = asked is not None and (was is None or asked < was)
    return is_less and state.is_under_way and state.remembered["issued"] > asked


def looks_at(state: State, limits: Limits) -> list[Look]:
    """The looks of a saved run, as they would have been with these errors asked for; none where none is."""
    looks = []
    for look in state.looks if limits.error else ():
        known = {standing.name: standing for standing in look.standings}
        if limits.error.keys() <= known.keys():
            standings = [replace(known[name], target=target) for name, target in limits.error.items()]
            looks.append(replace(look, standings=tuple(standings)))
    return looks
