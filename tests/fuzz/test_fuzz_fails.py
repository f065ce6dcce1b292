"""Each property of the fuzz can fail: a fault is planted beside every one, and rejected."""

from __future__ import annotations

import multiprocessing
from dataclasses import replace

import pytest

import transport as tp
from tests.fuzz import agreements, gases, properties, views
from tests.fuzz.lamps import WARM
from tests.fuzz.numbered import received
from tests.fuzz.rooms import METERED, ell
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


@pytest.mark.slow
def test_a_way_that_gives_five_percent_too_much_is_seen(monkeypatch):
    sound = agreements.run_of

    def biased(world, *how, **way):
        scene = world.scene() if isinstance(world, World) else world
        factor = 1.05 if way.get("estimator") == "backward" else 1.0
        sources = [
            replace(s, emission=tp.Lambertian(radiance=factor * s.emission.radiance)) for s in scene.sources
        ]
        return sound(replace(scene, sources=sources), *how, **way)

    assert len(agreements.check_ways(room())) >= 2
    monkeypatch.setattr(agreements, "run_of", biased)
    with pytest.raises(AssertionError, match="backward"):
        agreements.check_ways(room())


@pytest.mark.parametrize(
    ("code", "slow", "failed"),
    [
        ("import time; time.sleep(100)", "no end within 0.01 s", ""),
        ("import os, signal; os.kill(os.getpid(), signal.SIGPROF)", "processor time", ""),
        ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", "", "exit code -9"),
    ],
)
def test_a_scene_that_takes_too_long_is_slow_and_one_that_kills_its_process_has_failed(code, slow, failed):
    here, there = multiprocessing.Pipe(duplex=False)
    worker = multiprocessing.get_context("fork").Process(target=exec, args=(code, {}), daemon=True)
    worker.start()
    there.close()
    outcome = received(here, 3, worker, patience=0.01 if "sleep" in code else 60.0)
    assert slow in outcome.slow and failed in outcome.failed
    assert bool(outcome.slow) != bool(outcome.failed)


def test_the_room_in_the_shape_of_an_l_is_closed():
    mesh = ell((0.0, 0.0, 0.0), 2.0)
    assert mesh.is_closed and mesh.volume == pytest.approx(2 * (4 - 0.81))


def test_pixels_of_cameras_and_octants_of_maps_show_the_same_directions():
    """A fault in either's axes: what one octant shows, from a lamp in it, others show."""
    lamp = tp.Source(tp.Sphere(center=(3.0, 2.0, 1.0), radius=0.9), tp.Lambertian(radiance=1.0))
    far = tp.Source(tp.Sphere(center=(-3.0, -1.0, -3.0), radius=0.9), tp.Lambertian(radiance=7.0))
    looks = (agreements.octants("map", (0.0, 0.0, 0.0)), *views.cube((0.0, 0.0, 0.0)))
    seen = tp.simulate(tp.Scene([lamp, far], (), looks), 200_000, seed=1, progress=False)
    flux = seen["map"].radiance * seen["map"].detector.solid_angles()
    lit = set()
    for octant, pixels in agreements.pixels_of_octants(seen).items():
        parts = sum(pixels[1:], pixels[0])
        assert len(pixels) == 3 and (flux[octant].value > 0) == (parts.value > 0), octant
        if parts.value > 0:
            lit.add(octant)
            assert abs((parts - flux[octant]).z(0.0)) < 4
            assert abs((1.5 * parts - flux[octant]).z(0.0)) > 4
    assert lit == {(0, 0), (1, 2)}


@pytest.mark.slow
def test_a_camera_that_shows_too_much_is_seen_in_a_furnace(monkeypatch):
    here = replace(
        room(), views=(tp.Camera(name="view", position=(0.1, 0, 0), direction=(1, 0, 0), pixels=(2, 2)),)
    )
    assert any(name.startswith("view.radiance") for name in agreements.check_furnace(here))
    angles = tp.Camera.solid_angles
    monkeypatch.setattr(tp.Camera, "solid_angles", lambda self: 1.03 * angles(self))
    with pytest.raises(AssertionError, match=r"view\.radiance"):
        agreements.check_furnace(here)


def gas(**changes):
    """A box of gas, and the looks of such rooms."""
    box = tp.Box(size=2.0)
    looks = tuple(gases.looks_at((0.0, 0.0, 0.0), [(0.5, 0.5, 0.5)], 4e-3))
    source = tp.Source(box, tp.Gas(density=gases.DENSITY, speed=WARM))
    parts = {"sources": (source,), "surfaces": (tp.Surface(box, tp.Diffuse(1.0, speed=WARM), "room"),)}
    return World({**parts, "medium": None, "detectors": looks, "duration": 4e-3, **changes}, unit=(3, -5))


@pytest.mark.slow
def test_walls_of_another_temperature_are_seen(monkeypatch):
    monkeypatch.setattr(agreements, "MORE", 2)
    gases.check_gas(gas())
    cold = tp.Maxwellian(temperature=150.0, mass=WARM.mass)
    walls = (tp.Surface(tp.Box(size=2.0), tp.Diffuse(1.0, speed=cold), "room"),)
    with pytest.raises(AssertionError, match="temperature"):
        gases.check_gas(gas(surfaces=walls))


def test_an_instant_that_is_another_one_is_seen(monkeypatch):
    glow = tp.Source(tp.Disk(radius=0.5), tp.Effusive(exitance=1e6, speed=500.0))
    walls = (tp.Surface(tp.Box(size=2.0), tp.Diffuse(0.8), "room"),)
    world = gas(sources=(glow,), surfaces=walls)
    assert agreements.check_left(world)
    monkeypatch.setattr(agreements, "MORE", 4)
    cut = agreements._cut
    monkeypatch.setattr(agreements, "_cut", lambda world, instant: cut(world, 0.95 * instant))
    with pytest.raises(AssertionError, match="emitted and not gone"):
        agreements.check_left(world)


def test_bins_that_lose_a_particle_or_look_elsewhere_are_seen():
    scene = gas().scene()
    result = tp.simulate(scene, particles=2000, seed=1, progress=False)
    properties.instants_add_up(result)
    properties.whole_samples_are_binned(result)
    properties.samples_grow(result, result, 1.0, 1.0)
    with pytest.raises(AssertionError, match="off by"):
        properties.samples_grow(result, result, 2.0, 1.0)
    result["sample"].positions[:7] += 0.5
    with pytest.raises(AssertionError, match="of a sample of all"):
        properties.whole_samples_are_binned(result)
    result["sample"].histories[7] = result["sample"].histories[8]
    with pytest.raises(AssertionError, match="twice"):
        properties.instants_add_up(result)
