"""State of a run between batches: all that is needed to resume it bit for bit.

Batches are pure functions of their numbers. The state is therefore the batches taken, the position in the
schedule, and the error checks so far.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from transport.results.batches import Batch
from transport.run.provenance import Origin
from transport.run.schedules import Leg, Schedule, batches_in
from transport.run.settings import Limits
from transport.run.stopping import Look


@dataclass(frozen=True)
class State:
    """State of a run between two of its batches.

    kind: class name of its schedule, whose attributes are `remembered`; next: number of the next batch; leg,
    done: the present leg, and its number of batches taken; ahead: batches finished before their turn;
    particles, crossings, collisions: totals, including rounds that a later one has replaced; seconds: wall
    time; origins: provenance of the batches, empty where this process alone computed them.
    """

    limits: Limits
    kind: str
    remembered: dict[str, int]
    batches: list[Batch]
    next: int
    current: list[Batch] = field(default_factory=list)
    leg: Leg = field(default_factory=list)
    done: int = 0
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


# Names of schedules in the files of version 0.1.
FORMER_KINDS = {
    "InOneGo": "FixedCount",
    "Nets": "QmcSchedule",
    "Planned": "PilotThenRun",
    "Rounds": "QmcRounds",
}


def restore_schedule(state: State, schedule: Schedule) -> bool:
    """Restore a new schedule to the saved state; return whether it is restored exactly.

    It is where the schedule is of the same kind. Otherwise the new schedule continues from the batches that
    the result would have had. So it does where fewer particles are requested now than the present leg would
    reach.
    """
    schedule.batches, schedule.current = list(state.batches), list(state.current)
    kind = FORMER_KINDS.get(state.kind, state.kind)
    is_alike = type(schedule).__name__ == kind and not _exceeds_request(state, schedule.limits)
    if is_alike:
        for name, number in state.remembered.items():
            setattr(schedule, name, number)
    else:
        schedule.batches, schedule.current = schedule.batches or schedule.current, []
        schedule.adopt()
    return is_alike


def _exceeds_request(state: State, limits: Limits) -> bool:
    """Return whether the present leg exceeds the particles requested now."""
    requested, earlier = limits.particles, state.limits.particles
    is_less = requested is not None and (earlier is None or requested < earlier)
    return is_less and state.is_under_way and state.remembered["issued"] > requested


def saved_checks(state: State, limits: Limits) -> list[Look]:
    """Return the error checks of a saved run, with these target errors; none without targets."""
    looks = []
    for look in state.looks if limits.error else ():
        known = {standing.name: standing for standing in look.standings}
        if limits.error.keys() <= known.keys():
            standings = [replace(known[name], target=target) for name, target in limits.error.items()]
            looks.append(replace(look, standings=tuple(standings)))
    return looks
