"""Each property of the fuzz can fail: a fault is planted beside every one, and rejected."""

from __future__ import annotations

import multiprocessing
from dataclasses import replace

import pytest

import transport as tp
from tests.fuzz import agreements, properties
from tests.fuzz.rooms import METERED, ell
from tests.fuzz.supervised import KILLED, _received
from tests.fuzz.worlds import World


def room(brighter: float = 1.0) -> World:
    """A furnace of two materials with a grey sheet in it, whose walls may shine more than they should."""
    surfaces = (
        tp.Surface(tp.Box(size=2.0), tp.Diffuse(0.5), "wall 0"),
        tp.Surface(
            tp.Disk(center=(0.3, 0.2, 0.1), normal=(1, 2, 3), radius=0.5), tp.Glossy(0.3, 0.25), "sheet"
        ),
    )
    sources = (
        tp.Source("wall 0", tp.Lambertian(radiance=0.5 * brighter), side="inside"),
        *(tp.Source("sheet", tp.Lambertian(radiance=0.75), side=side) for side in ("front", "back")),
    )
    meters = (
        tp.Detector("wall 0", "walls", "inside", METERED),
        tp.Detector("sheet", "front", directions=METERED),
    )
    parts = {"sources": sources, "surfaces": surfaces, "detectors": meters, "medium": None, "duration": None}
    return World(parts, unit=(3, -5))


def result_with(**changes):
    """A run of the room, whose first batch is another."""
    result = properties.run(room())
    result.batches[0] = replace(result.batches[0], **changes)
    return tp.Result(result.plan, result.batches, 1, result.cost, True, [])


def test_an_open_ledger_is_seen():
    properties.ledger_closes(properties.run(room()))
    batch = properties.run(room()).batches[0]
    with pytest.raises(AssertionError, match="open"):
        properties.ledger_closes(result_with(absorbed=batch.absorbed * (1 + 1e-9)))


@pytest.mark.parametrize(("factor", "told"), [(float("nan"), "is"), (-1.0, "negative")])
def test_numbers_that_make_no_sense_are_seen(factor, told):
    batch = properties.run(room()).batches[0]
    with pytest.raises(AssertionError, match=told):
        properties.numbers_are_sound(result_with(weights=batch.weights * factor * 100))


def test_other_numbers_and_other_units_are_seen():
    one, other = properties.run(room()), properties.run(room().in_units(4, 2))
    properties.grows_as_its_unit(one, other, 16.0, 4.0)
    with pytest.raises(AssertionError, match="off by"):
        properties.grows_as_its_unit(one, other, 16.0 * (1 + 1e-9), 4.0)
    with pytest.raises(AssertionError, match="of ledger"):
        properties.are_the_same(one, other)


@pytest.mark.parametrize("message", ["Wrong input; mend it", "Detector 'lid': radius is wrong"])
def test_a_refusal_without_object_or_cure_is_seen(message):
    with pytest.raises(AssertionError):
        properties.refusal_helps(message)


def test_walls_that_shine_three_percent_too_much_are_seen():
    agreements.check_furnace(room())
    with pytest.raises(AssertionError, match="16 times the histories"):
        agreements.check_furnace(room(brighter=1.03))


def test_a_way_that_gives_five_percent_too_much_is_seen(monkeypatch):
    sound = agreements._run

    def biased(scene, *how, **way):
        factor = 1.05 if way.get("estimator") == "backward" else 1.0
        sources = [
            replace(s, emission=tp.Lambertian(radiance=factor * s.emission.radiance)) for s in scene.sources
        ]
        return sound(replace(scene, sources=sources), *how, **way)

    assert len(agreements.check_ways(room())) >= 2
    monkeypatch.setattr(agreements, "_run", biased)
    with pytest.raises(AssertionError, match="backward"):
        agreements.check_ways(room())


def test_a_scene_without_an_end_is_seen():
    here, _there = multiprocessing.Pipe(duplex=False)
    assert _received(here, 3, patience=0.01).failed.startswith(KILLED)


def test_the_room_in_the_shape_of_an_l_is_closed():
    mesh = ell((0.0, 0.0, 0.0), 2.0)
    assert mesh.is_closed and mesh.volume == pytest.approx(2 * (4 - 0.81))
