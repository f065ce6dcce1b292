"""What must hold of a furnished room: the ledger, the furnace, and no difference by gaps and estimators.

A score beyond LIMIT is judged again with other random numbers and sixteen times the histories
(agreements.checked): right code fails in one of 2.5e8 scores. 200 rooms have 5600 scores: right code
fails in one of them once in 40 000 times.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

import transport as tp
from tests.fuzz.agreements import Scores, checked, score_of, sound
from tests.fuzz.furnished import GAP, Furnished, furnished
from tests.tracking_scenes import assert_closed
from transport.compile.methods import refusal
from transport.results.result import Result

PARTICLES = 20_000  # of a run
FORWARDS = ("flux_in", "flux_out")  # of which backward runs know the first
BACKWARD_EVERY = 3  # rooms, of which one is also run backwards
SEEDS = 10  # from one room to the next, and from the first to the second look at it
ENOUGH = 300  # counts, below which nothing is scored
LEAKS = 1e-3  # the most of all light that may come between what stands a gap apart
LEAST = 1e-9  # of the room's area, of a side that is not covered all over


def check_room(number: int) -> list[str]:
    """The names of the scores of a room, all of them small.  Raises AssertionError."""
    room, is_backward = furnished(number), number % BACKWARD_EVERY == BACKWARD_EVERY - 1

    def judged(is_backward: bool) -> list[str]:
        return checked(lambda seed, more: scores(room, SEEDS * (2 * number + seed), more, is_backward))

    return judged(is_backward) or judged(True)  # in some rooms nothing scores often enough forwards


def scores(room: Furnished, seed: int, more: int, is_backward: bool) -> Scores:
    """All normal scores of a room; those of backward runs take most of the time."""
    parts = [_furnace(room, seed, more), _gapped(room, seed, more), _expected(room, seed, more)]
    if is_backward:
        parts.append(_seen_furnace(room, seed, more))
    return {name: z for part in parts for name, z in part}


def run_of(scene: tp.Scene, seed: int, more: int, **how) -> Result:
    """A run whose ledger closes and that loses nothing."""
    result = tp.simulate(scene, more * PARTICLES, seed=seed, batches=32, threads=1, progress=False, **how)
    if "backward" not in how.values():
        assert_closed(result)
    assert not any(batch.lost or batch.unseen or batch.astray for batch in result.batches), result.warnings
    return result


def is_sound(result: Result, name: str, key: str) -> bool:
    """Whether the library trusts the error; it does not where only few histories differ from 1."""
    return result.quality(f"{name}.{key}").is_sound


def _furnace(room: Furnished, seed: int, more: int) -> Iterator[tuple[str, float]]:
    """Scores of what comes to and leaves each side, of pi times what is uncovered of it, forwards."""
    result = run_of(room.furnace(room.meters(with_plane=False)), seed, more, estimator="analog")
    assert result.ledger["escaped"].value == 0, "something escapes"
    yield from _levels(room, result, "furnace")


def _levels(room: Furnished, result: Result, title: str) -> Iterator[tuple[str, float]]:
    uncovered = room.uncovered()
    for meter in result.scene.meters:
        area, reading = uncovered[meter.shape, meter.side], result[meter.name]
        for key in FORWARDS if "backward" not in title else FORWARDS[:1]:
            flux = getattr(reading, key)
            if area < LEAST * room.scale**2:
                assert flux.value == 0, f"{title}: {meter.name} is covered and has {key} {flux}"
            elif (
                reading.counts.value >= ENOUGH
                and flux.relative_error < 0.1
                and is_sound(result, meter.name, key)
            ):
                yield f"{title}: {meter.name} {key}", score_of(flux, math.pi * area)


def _seen_furnace(room: Furnished, seed: int, more: int) -> Iterator[tuple[str, float]]:
    """Scores of the radiance of maps, of 1, and of what comes to each side, backwards."""
    scene = room.furnace([*room.maps(), *room.meters(with_plane=False)])
    if refusal(scene, "backward"):
        return
    result = run_of(scene, seed + 1, more, estimator="backward")
    yield from _levels(room, result, "furnace backward")
    for look in room.maps():
        seen = result[look.name]
        if not is_sound(result, look.name, "radiance"):
            continue
        for place in np.ndindex(seen.radiance.shape):
            if seen.counts.value[place] >= ENOUGH:
                yield f"furnace backward: {look.name} {list(place)}", score_of(seen.radiance[place], 1.0)


def _gapped(room: Furnished, seed: int, more: int) -> Iterator[tuple[str, float]]:
    """Scores of the differences from the same room with gaps, of what comes to and leaves each side."""
    meters = room.meters()
    plain, apart = (
        run_of(room.lit(meters, gap), seed + k, more, estimator="analog") for k, gap in ((2, 0.0), (3, GAP))
    )
    for meter in meters:
        for key in FORWARDS:
            both = [getattr(result[meter.name], key) for result in (plain, apart)]
            if min(each.value for each in both) == 0:  # where one has nothing, the other has hardly anything
                most = LEAKS * plain.ledger["emitted"].value
                assert max(each.value for each in both) <= most, f"gap: {meter.name} {key} {both}"
            counts = [result[meter.name].counts.value for result in (plain, apart)]
            if min(counts) >= ENOUGH and all(0 < each.relative_error < 0.1 for each in both):
                yield f"gap: {meter.name} {key}", float((both[0] - both[1]).z(0.0))


def _expected(room: Furnished, seed: int, more: int) -> Iterator[tuple[str, float]]:
    """Scores of the differences of "expected" from "analog": on faces, on floors, and beside them.

    Backward runs are judged by furnaces: small lamps leave few of their errors sound.
    """
    probes = room.probes()
    plain, other = (
        run_of(room.lit(probes), seed + k, more, estimator=estimator)
        for k, estimator in ((4, "analog"), (5, "expected"))
    )
    for probe in probes:
        name = f"{probe.name}.flux_in"
        both = [sound(result, name) for result in (plain, other)]
        if None not in both:
            yield f"expected: {name}", float((both[0] - both[1]).z(0.0))
        if probe.positions is not None:
            yield from _binned("expected", probe.name, plain, other)


def _binned(title: str, name: str, plain: Result, other: Result) -> Iterator[tuple[str, float]]:
    """Scores of the differences by position."""
    maps = [result[name].irradiance for result in (plain, other)]
    for place in np.ndindex(maps[0].shape):
        counts = [result[name].counts.value[place] for result in (plain, other)]
        both = [each[place] for each in maps]
        if min(counts) >= ENOUGH and all(0 < each.relative_error < 0.1 for each in both):
            yield f"{title}: {name} {list(place)}", float((both[0] - both[1]).z(0.0))
