"""Merging of runs of the same scene: their batches, which must be distinct, in order of seed and number.

Merged parts of a run equal that run bit for bit.
"""

from __future__ import annotations

from dataclasses import replace
from os import PathLike

from transport.io.json.differences import differences
from transport.io.runs import load, original_scene, state_of
from transport.results.batches import Batch
from transport.results.record import total_cost
from transport.results.result import Result
from transport.run.provenance import distinct_origins, origin_warnings
from transport.run.run import MISSING_BATCHES
from transport.run.schedules import batches_in, merge_to_at_most, schedule_for
from transport.run.settings import Limits
from transport.run.state import State
from transport.validation import SceneError, short_repr

SUMMED = ("particles", "crossings", "collisions", "seconds")  # of the states of the merged runs
MERGED_SCHEDULE = "Merged"  # a schedule kind that no run has: the merged run continues from its batches alone


def merge(*runs: Result | str | PathLike) -> Result:
    """Merge results, or files of saved runs, into one result.

    Raises SceneError for fewer than two runs, for different scenes, methods or tracking, and for common
    batches.
    """
    results = [run if isinstance(run, Result) else load(run) for run in runs]
    titles = [f"run {n}" if isinstance(run, Result) else str(run) for n, run in enumerate(runs, 1)]
    if len(results) < 2:
        raise SceneError(f"merge: needs two runs or more, got {len(results)}; write merge('a.nc', 'b.nc')")
    for title, result in zip(titles[1:], results[1:], strict=True):
        _check_same_setup(titles[0], results[0], title, result)
    _check_disjoint(titles, results)
    batches = sorted((batch for result in results for batch in result.batches), key=_batch_key)
    seed = batches[0].seed
    first, limits = results[0], _merged_limits(results)
    # Combine batches to the number that a resumed run keeps; a single run has no more than that.
    schedule = schedule_for(limits, first.plan)
    schedule.make_room()
    batches = merge_to_at_most(schedule.max_stored, batches, schedule.max_records(2))
    state = _merged_state(results, batches, seed, limits)
    warnings = _inconsistent_parts(titles, results) or _missing_batches(results, batches)
    warnings += origin_warnings(state.origins)
    is_complete = all(result.is_complete for result in results)
    costs = [result.cost for result in results if result.cost is not None]
    cost = total_cost(costs) if costs else None
    return Result(first.plan, batches, seed, cost, is_complete, warnings, first.asked, None, state)


def _batch_key(batch: Batch) -> tuple[int, int]:
    return batch.seed, batch.first


def _check_same_setup(first: str, one: Result, title: str, other: Result) -> None:
    """Raise SceneError for a different scene, method or tracking."""
    if unlike := differences(original_scene(other), original_scene(one)):
        raise SceneError(f"merge: the scene of {title} differs from that of {first}: {'; '.join(unlike)}")
    same = "name the same estimator and sampling for both, and a guide for both or none"
    cures = {"method": same, "tracking": "use the same tracking"}
    for name, cure in cures.items():
        ours, others = getattr(one.plan, name), getattr(other.plan, name)
        if name == "method" and ours.guide and others.guide:
            others = replace(others, guide=ours.guide)  # what each has learnt differs between seeds, too
        if ours != others:
            raise SceneError(
                f"merge: the {name} of {title} is {short_repr(others)}, that of {first} is"
                f" {short_repr(ours)}; {cure}"
            )


def _check_disjoint(titles: list[str], results: list[Result]) -> None:
    """Raise SceneError for batches that share random numbers."""
    owned = sorted(
        (*_batch_key(batch), batch.past, title)
        for title, result in zip(titles, results, strict=True)
        for batch in result.batches
    )
    common, before = [], owned[0]
    for batch in owned[1:]:
        if batch[0] == before[0] and batch[1] < before[2]:
            common.append((batch[0], range(batch[1], min(batch[2], before[2])), {batch[3], before[3]}))
        before = max(before, batch, key=lambda one: (one[0], one[2]))
    if common:
        seed, first, owners = common[0]
        last = max(numbers[-1] for other, numbers, _ in common if other == seed)
        overlap = f"batches {first[0]} to {last} of seed {seed} are"
        if last == first[0]:
            overlap = f"batch {last} of seed {seed} is"
        cure = "merge each batch once; use another seed, or continue one of the runs with resume"
        raise SceneError(f"merge: {overlap} in {' and in '.join(sorted(owners))}; {cure}")


def _missing_batches(results: list[Result], batches: list[Batch]) -> list[str]:
    """Return a warning that names missing batches of runs in parts, so that a failed job is noticed."""
    missing = []
    for seed in dict.fromkeys(result.seed for result in results if state_of(result).limits.part != (1, 1)):
        own = [batch for batch in batches if batch.seed == seed]
        for past, batch in zip([0, *(batch.past for batch in own)], own, strict=False):
            if batch.first > past:
                missing.append(f"batches {past} to {batch.first - 1} of seed {seed}")
        last = max(
            results, key=lambda result: max((b.past for b in result.batches if b.seed == seed), default=0)
        )
        one, of = state_of(last).limits.part
        if one < of:
            missing.append(f"the batches of seed {seed} after part {one} of {of}")
    cure = "merge these parts too, or the result has fewer particles than planned"
    return [f"{', '.join(missing)} {MISSING_BATCHES}: {cure}"] if missing else []


def _inconsistent_parts(titles: list[str], results: list[Result]) -> list[str]:
    """Return a warning for parts of one seed with different numbers of particles, batches or parts."""
    known: dict[int, tuple] = {}
    for title, result in zip(titles, results, strict=True):
        limits = state_of(result).limits
        if limits.part == (1, 1):
            continue
        plan = limits.particles, limits.batches, limits.part[1]
        first, planned = known.setdefault(result.seed, (title, plan))
        if plan != planned:
            one, other = (
                f"{particles:_} particles in {batches} batches and {parts} parts"
                for particles, batches, parts in (plan, planned)
            )
            return [
                f"{title} is of a run of {one}, {first} of one of {other}: the merged result is neither run,"
                " and missing batches are not known"
            ]
    return []


def _merged_limits(results: list[Result]) -> Limits:
    """Return the limits of the merged run: all particles together."""
    limits = [state_of(result).limits for result in results]
    batch_counts = {each.batches for each in limits}
    is_free = len(batch_counts) > 1 or any(each.is_free for each in limits)
    particles = sum(batch.histories for result in results for batch in result.batches)
    return Limits(particles, {}, None, max(batch_counts), is_free)


def _merged_state(results: list[Result], batches: list[Batch], seed: int, limits: Limits) -> State:
    """Return the state of the merged run; it continues with batches of the first seed that no run owns."""
    states = [state_of(result) for result in results]
    return State(
        limits,
        MERGED_SCHEDULE,
        {"issued": limits.particles},
        batches,
        _next_batch(results, batches, seed),
        **{name: sum(getattr(state, name) for state in states) for name in SUMMED},
        origins=distinct_origins(*(state.origins for state in states)),
    )


def _next_batch(results: list[Result], batches: list[Batch], seed: int) -> int:
    """Return the first batch number of this seed that is neither run nor reserved by a missing part."""
    done = max(batch.past for batch in batches if batch.seed == seed)
    return max(done, *(_planned_batches(result) for result in results if result.seed == seed))


def _planned_batches(result: Result) -> int:
    """Return the number of batches of the whole run that a result is part of."""
    state = state_of(result)
    if state.limits.part == (1, 1):
        return state.next
    return batches_in(schedule_for(state.limits, result.plan).next_leg([]))
