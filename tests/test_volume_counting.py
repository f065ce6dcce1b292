"""How volume detectors count: against a clock, aimed births, within the guard of the sums.

All runs have seed 1; each judgement fails right code in one of 10^5 seeds.
"""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.volume_scenes import (
    ALL_ROUND,
    BALL,
    BOX,
    DEEP,
    FALSE_ALARM,
    FOG,
    SIGMA,
    body,
    faded,
    foggy,
    rejects,
    run,
    sphere,
)
from transport.compile.compiler import compile_scene
from transport.engine.bundle import empty_bundle
from transport.engine.driver import compile_program, run_batch
from transport.engine.passes.volumes import SCORE_BOUND
from transport.engine.program import build_program


@pytest.mark.parametrize("speeds", [(2.0,), (2.0, 0.5, 0.0)])
def test_a_gas_at_rest_as_a_whole_has_the_fluence_rate_n_v(speeds):
    sources = [tp.Source(tp.Box(size=4.4), tp.Gas(10.0, speed)) for speed in speeds]
    looks = [tp.VolumeDetector(tp.Box(size=2.4), "box"), tp.VolumeDetector(BALL, "ball", (3,))]
    result = run(tp.Scene(sources, [], looks, duration=0.5), particles=400_000)
    flow = 10.0 * sum(speeds)
    assert_agrees(result["box"].fluence_rate, flow, FALSE_ALARM)
    assert_agrees(result["box"].fluence, flow * 0.5, FALSE_ALARM)
    assert_agrees(result["ball"].fluence_rate, flow, FALSE_ALARM)
    assert str(result["box"].fluence_rate.unit) == "m^-2 s^-1" or "s^-1" in str(
        result["box"].fluence_rate.unit
    )
    rejects(result["box"].fluence_rate, flow * 1.05)


def test_a_flash_is_counted_as_far_as_it_comes_before_the_clock_stops():
    """Light of 2 J on 1 m^2, slower in the medium by its index, from its face on."""
    index, way = 1.5, 0.8
    face = tp.Rectangle(width=1.0, height=1.0, center=(0, 0, -1.0))
    flash = tp.Source(face, tp.Beam((0, 0, 1), energy=2.0), pulse=tp.Instant())
    medium = tp.Medium(absorption=SIGMA, index=index)
    looks = [tp.VolumeDetector(DEEP, "all"), tp.VolumeDetector(DEEP, "cells", (1, 1, 5))]
    scene = tp.Scene(flash, [], looks, medium=medium, duration=way * index / tp.speed_of_light)
    result = run(scene)
    exact = 2.0 * faded([0, 0.4, 0.8]) * 0.4
    energy = result["all"].absorbed_energy
    assert_agrees(energy, exact.sum() * SIGMA, FALSE_ALARM)
    assert_agrees(result["cells"].fluence[0, 0, :2], exact / 0.4, FALSE_ALARM)
    rejects(energy, 2.0 * faded([0, 2])[0] * 2 * SIGMA)  # the clock left out
    assert (result["cells"].fluence.value[0, 0, 2:] < 1e-12).all()
    assert result["all"].absorbed_power.value == pytest.approx(energy.value / scene.duration, rel=1e-12)


def test_aimed_births_count_from_their_source_to_their_target_and_beyond():
    meter = tp.Disk(center=(0, 0, 3), radius=0.2, normal=(0, 0, -1))
    looks = [
        tp.VolumeDetector(tp.Box(center=(0, 0, z), size=(9, 9, 0.5)), f"at {round(100 * z)} cm")
        for z in (0.25, 2.75, 3.25)
    ]
    source = tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=1.0), aim=meter)
    result = run(tp.Scene(source, [], [*looks, tp.Detector(meter, "meter")]))
    ways = [result[look.name].fluence_rate for look in looks]
    for way in ways[1:]:  # straight on: the same way in each layer
        assert way.value == pytest.approx(ways[0].value, rel=1e-12)
    flux = result["meter"].flux_in.value
    assert flux < ways[0].value * 81 < 1.05 * flux  # 1/cos of a few degrees
    assert any("volume detector" in warning and "aim" in warning for warning in result.warnings)


def test_a_score_is_within_what_the_guard_of_the_sums_has_counted():
    result = foggy("weighted")
    machine, bundle = (
        compile_program(build_program(compile_scene(result.scene, result.plan.tracking))),
        empty_bundle(),
    )
    raw = run_batch(machine, seed=1, batch=0, histories=5000, bundle=bundle)
    high, scores = raw.detectors[1:, 0].sum(), raw.detectors[1:, 2].sum()
    assert bundle["scored"][0] >= high > 0 and bundle["scored"][0] - high >= SCORE_BOUND * scores // 2 > 0
    each = raw.detectors[1:, 0] / np.maximum(raw.detectors[1:, 2], 1)
    assert each.max() <= 2.0**32  # one at most, of weight 1


def test_results_are_the_same_for_any_number_of_threads():
    scene = tp.Scene(ALL_ROUND, [body(BALL, FOG)], foggy("weighted").scene.detectors)
    one, two = (tp.simulate(scene, particles=20_000, seed=3, threads=n, progress=False) for n in (1, 2))
    for name in one:
        assert np.array_equal(one[name].fluence_rate.value, two[name].fluence_rate.value)
        assert np.array_equal(one[name].absorbed_power.value, two[name].absorbed_power.value)


def test_nothing_else_changes_where_a_volume_is_looked_at():
    """Other than the origin that all is told from: so the same within rounding."""
    bare = tp.simulate(
        tp.Scene(ALL_ROUND, [body(BALL, FOG)], []), particles=20_000, seed=3, tracking="weighted"
    )
    with_it = tp.simulate(foggy("weighted").scene, particles=20_000, seed=3, tracking="weighted")
    for name in ("absorbed", "escaped"):
        assert with_it.ledger[name].value == pytest.approx(bare.ledger[name].value, rel=0.02)
    assert with_it.cost.collisions == pytest.approx(bare.cost.collisions, rel=0.02)


def test_light_that_leaves_into_the_open_is_counted_outside_as_well():
    """In a scene whose surroundings are empty: what leaves the body flies on."""
    about = tp.Sphere(radius=1.9, center=BALL.center)
    looks = [tp.VolumeDetector(about, "about", (0.8, 1.9))]
    lamp = tp.Source(tp.Point(position=BALL.center), tp.Isotropic(power=1.0))
    result = run(tp.Scene(lamp, [body(BALL, tp.Medium(scattering=1.0))], looks))
    flux_through = result["about"].fluence_rate * result["about"].volumes
    assert 1.1 <= flux_through.value[0] < 1.9  # nothing is absorbed: 1.1 m on the straightest way out


def test_an_error_can_be_asked_for_and_the_report_tells_all():
    looks = [tp.VolumeDetector(BOX, "box"), tp.VolumeDetector(BALL, "ball", (2,), sphere(2, 2))]
    result = tp.simulate(
        tp.Scene(ALL_ROUND, [], looks), error={"box.fluence_rate": 0.05}, seed=1, progress=False
    )
    assert result["box"].fluence_rate.relative_error <= 0.05
    text = result.report()
    assert "volume detector 'box'" in text and "radiance" in text and "absorbed_power" not in text
    assert result.quantity("ball.radiance").dims == ("r", "mu", "phi")
    assert result["ball"].fluence_rate.to_xarray()["r"].attrs == {"units": "m"}
