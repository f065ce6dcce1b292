"""Tracks are what the engine flies: the same histories, whole, without gaps, by the laws of flight."""

import importlib
import json
import os
import subprocess
import sys

import numpy as np
import pytest

import transport as tp
from transport.compile.compiler import compile_scene
from transport.compile.layout import COUNT_BITS
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program

COUNT = 2  # column of a row of sums
FOG = tp.Medium(absorption=0.1, scattering=0.9, phase=tp.HenyeyGreenstein(0.75))
BEAM = tp.Source(tp.Point(position=(0, 0, 3)), tp.Beam((0, 0, -1), power=1.0))


def slab(thickness=2.0):
    layer = tp.Slab(center=(0, 0, -thickness / 2), thickness=thickness)
    top = tp.Detector(tp.Plane(), "top")
    return tp.Scene([BEAM], [tp.Surface(layer, tp.Transparent(), inside=FOG)], [top])


def room(**more):
    walls = [tp.Surface(face, tp.Diffuse(0.5), name) for name, face in tp.Box(size=2.0).faces().items()]
    return tp.Scene(
        tp.Source("+z", tp.Lambertian(exitance=1.0), side="back"),
        walls,
        tp.Detector("-z", "floor", side="back"),
        **more,
    )


@pytest.mark.parametrize("scene", [slab(), room(), room(duration=1e-8)], ids=["slab", "room", "with a clock"])
def test_each_flight_begins_where_the_one_before_it_ended(scene):
    found = tp.tracks(scene, 300, seed=1)
    goes_on = found.histories[1:] == found.histories[:-1]
    gaps = np.abs(found.ends(1.0)[:-1] - found.starts[1:]).max(axis=1)
    assert gaps[goes_on].max() < 1e-14 * 4
    older = np.diff(found.ages)
    np.testing.assert_allclose(older[goes_on], found.lengths[:-1][goes_on], rtol=0, atol=1e-12)
    assert (found.ages[1:][~goes_on] == 0).all() and found.ages[0] == 0
    assert len(np.unique(found.histories)) == 300
    assert np.allclose(np.linalg.norm(found.directions, axis=1), 1, atol=1e-14)


def test_they_are_the_histories_of_a_run_without_them():
    """As many arrivals at walls as the engine counts of the same histories, and as many on the floor."""
    plan = compile_scene(room())
    raw = run_batch(compile_program(build_program(plan)), 7, 0, 500)
    found = tp.tracks(room(), 500, seed=7)
    assert np.count_nonzero(found.meets) == raw.crossings
    arrivals = raw.detectors[plan.rows_of["floor"].base + 1, COUNT] & ((1 << COUNT_BITS) - 1)
    assert np.count_nonzero(found.meets & (np.abs(found.ends(1.0)[:, 2] + 1) < 1e-12)) == arrivals > 50


def test_flights_to_infinity_have_no_end_and_are_drawn_to_a_reach():
    scene = tp.Scene(
        tp.Source(tp.Sphere(radius=1.0), tp.Lambertian(radiance=1.0)),
        (),
        tp.Detector(tp.Sphere(radius=2.0), "shell"),
    )
    found = tp.tracks(scene, 50)
    off = np.isinf(found.lengths)
    assert off.sum() == 50
    assert np.allclose(np.linalg.norm(found.ends(7.0) - found.starts, axis=1)[off], 7.0)
    assert (found.ages[off] > 0).all() and (found.ages[~off] == 0).all()


def test_room_for_flights_grows_and_none_is_lost(monkeypatch):
    scene = room()
    whole = tp.tracks(scene, 40, seed=2)
    monkeypatch.setattr(importlib.import_module("transport.analysis.tracks"), "FLIGHTS_PER_PARTICLE", 1)
    again = tp.tracks(scene, 40, seed=2)
    assert np.array_equal(whole.starts, again.starts) and len(whole) > 40


PLAIN = """
import json, transport as tp
fog = tp.Medium(absorption=0.1, scattering=0.9)
ball = tp.Surface(tp.Sphere(radius=1.0), tp.Transparent(), inside=fog)
lamp = tp.Source(tp.Point(position=(0, 0, 2)), tp.Isotropic(power=1.0))
found = tp.tracks(tp.Scene(lamp, ball, tp.Detector(tp.Sphere(radius=3.0), "shell")), 10, seed=4)
print(json.dumps([found.starts.tolist(), found.weights.tolist(), found.histories.tolist(), found.meets.tolist()]))
"""


def recorded(disable_jit):
    environment = os.environ | {"NUMBA_DISABLE_JIT": disable_jit}
    done = subprocess.run(
        [sys.executable, "-c", PLAIN], env=environment, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


@pytest.mark.slow
def test_plain_python_records_the_same():
    compiled, plain = recorded("0"), recorded("1")
    assert compiled[2:] == plain[2:]
    assert len(plain[2]) >= 10
    assert np.allclose(compiled[0], plain[0], rtol=0, atol=1e-12)
    assert np.allclose(compiled[1], plain[1], rtol=1e-12, atol=0)


@pytest.mark.parametrize(
    "wrong, words",
    [
        (lambda: tp.tracks("room"), "scene must be a Scene"),
        (lambda: tp.tracks(room(), 0), "particles"),
        (lambda: tp.tracks(slab(), 9, tracking=tp.Tracking(forced=True)), "without splitting or forced"),
    ],
)
def test_tracks_that_cannot_be_recorded_are_refused(wrong, words):
    with pytest.raises(tp.SceneError, match=words):
        wrong()


def test_ages_keep_the_digits_of_short_flights_beside_long_ones():
    """A mirror 0.3 m away sends every particle to a sky of 1e12 m: the next one's age must not have lost its metres."""
    sky = tp.Surface(tp.Sphere(radius=1e12), tp.Black(), "sky")
    floor = tp.Surface(tp.Rectangle(center=(0, 0, -0.3), width=1, height=1), tp.Mirror(), "floor")
    scene = tp.Scene(tp.Source(tp.Point(), tp.Beam((0, 0, -1), power=1.0)), [sky, floor])
    np.testing.assert_allclose(tp.tracks(scene, 50).ages, np.tile([0.0, 0.3], 50), rtol=1e-12)
