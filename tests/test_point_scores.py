"""How sure a point detector is: its error falls as N^(-1/2) and is right; scores that stand out are told."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_z_spread
from tests.point_scenes import FOG, LAMP, M, filled, seen
from transport.theory import point_source


def test_the_error_falls_with_the_root_of_the_number_of_particles():
    """2048 batches of 200 histories each, one by one and together in groups: N^(-1/2) but for a logarithm."""
    scene = tp.Scene(LAMP, detectors=tp.PointDetector((1, 0, 0), "p"), medium=FOG)
    result = tp.simulate(scene, particles=200 * 2048, batches=2048, seed=3, threads=1, progress=False)
    exact = 2 * point_source.fluence_rate(1.0, 1.0, 0.9)
    values = result["p"].batch_values / exact - 1
    sizes = 4 ** np.arange(5)
    errors = [float(np.sqrt((values.reshape(-1, n).mean(axis=1) ** 2).mean())) for n in sizes]
    slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert -0.56 < slope < -0.44, (slope, errors)
    assert abs(values.mean()) < 5 * values.std() / math.sqrt(len(values))


def test_its_error_bars_are_right():
    """z over 300 short runs has mean 0 and spread 1: the variance is finite, and known from 32 batches."""
    scene = tp.Scene(LAMP, detectors=tp.PointDetector((1, 0, 0), "p"), medium=FOG)
    exact = 2 * point_source.fluence_rate(1.0, 1.0, 0.9)
    runs = (tp.simulate(scene, particles=4000, seed=seed, threads=1, progress=False) for seed in range(300))
    assert_z_spread(np.array([run["p"].fluence_rate.z(exact) for run in runs]), math.inf, 1e-6)


def test_scores_that_stand_out_are_told():
    """Behind a thick shield the few histories that got through it carry all."""
    slab = filled(tp.Slab(center=(0, 0, 8), thickness=12.0), M(0.7, 0.3))
    _, result = seen(LAMP, [(0, 0, 15)], [slab], particles=2000)
    assert any("'p0'" in warning and "doubtful" in warning for warning in result.warnings)
    assert "doubtful" in result.report()
    *_, result = seen(LAMP, [(0, 0, 1), (3, 0, 0)], [slab], particles=20_000)
    assert not result.warnings


def test_a_score_of_any_size_is_counted():
    """Within 1e-35 m of a lamp of 2 W, and 600 mean free paths from a pencil beam in a fog."""
    huge, _ = seen(LAMP, [(1e-35, 0, 0)], particles=1000)
    assert huge.value == pytest.approx(2e70 / (4 * math.pi))
    pencil = tp.Source(tp.Point(position=(0, 0, -1)), tp.Beam((0, 0, 1), power=1.0))
    faint, _ = seen(pencil, [(0, 600, 0)], particles=1000, medium=FOG)
    assert 0 < faint.value < 1e-100


def test_what_it_scores_does_not_depend_on_threads_batches_or_other_detectors():
    places, surfaces = [(1, 0, 0), (0, 0.5, 0)], [filled(tp.Box(size=3.0), M(0.1, 1.0, tp.Rayleigh()))]
    scene = tp.Scene(LAMP, surfaces, [tp.PointDetector(place, f"p{k}") for k, place in enumerate(places)])
    options = {"particles": 20_000, "seed": 7, "batches": 8, "progress": False}
    one, two = (tp.simulate(scene, threads=threads, **options) for threads in (1, 2))
    alone = tp.simulate(tp.Scene(LAMP, surfaces, tp.PointDetector(places[0], "p0")), threads=1, **options)
    for name in ("p0", "p1"):
        assert (one[name].batch_values == two[name].batch_values).all()
    assert (one["p0"].batch_values == alone["p0"].batch_values).all()
    assert (one["p0"].counts.value, one["p1"].counts.value) == (
        two["p0"].counts.value,
        two["p1"].counts.value,
    )


def test_it_leaves_everything_else_as_it_is():
    """Flights draw what they draw without it."""
    surfaces = [
        filled(tp.Box(size=3.0), M(0.1, 1.0)),
        tp.Surface(tp.Plane(center=(0, 0, -2)), tp.Diffuse(0.5)),
    ]
    meter = tp.Detector(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=1.0), name="meter")
    options = {"particles": 20_000, "seed": 7, "threads": 1, "progress": False}
    without = tp.simulate(tp.Scene(LAMP, surfaces, [meter]), **options)
    with_it = tp.simulate(tp.Scene(LAMP, surfaces, [meter, tp.PointDetector((1, 0, 0.2), "p")]), **options)
    assert without["meter"].flux_in.value == with_it["meter"].flux_in.value
    assert without.cost.collisions == with_it.cost.collisions
    for name, entry in without.ledger.items():
        assert entry.value == with_it.ledger[name].value


def test_errors_can_be_asked_for_and_unknown_quantities_are_told():
    scene = tp.Scene(LAMP, detectors=tp.PointDetector((1, 0, 0), "p"), medium=FOG)
    result = tp.simulate(
        scene, error={"p.fluence_rate": 0.05}, particles=100_000, seed=1, threads=1, progress=False
    )
    assert result["p"].fluence_rate.relative_error < 0.05
    with pytest.raises(tp.SceneError, match="fluence_rate"):
        tp.simulate(scene, error={"p.fluence": 0.1}, particles=1000)
    with pytest.raises(AttributeError, match="fluence_rate"):
        _ = result["p"].fluence
    assert "point detector 'p'" in result.report()
