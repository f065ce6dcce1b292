"""Volume detectors: fluence rate, absorbed power and radiance in a box or a ball agree with exact values, cell by cell.

What holds for every flight is asked to rounding.  All runs have seed 1; statistical judgements fail right code in one of
10^5 seeds.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from transport.compile import compile_scene
from transport.engine.bundle import empty_bundle
from transport.engine.driver import machine_of, run_batch
from transport.engine.program import program_of
from transport.engine.volumes import A_SCORE

FALSE_ALARM = 1e-5
BOX, BALL = (
    tp.Box(size=(1.0, 2.0, 0.5), center=(0.1, 0.0, 0.3)),
    tp.Sphere(radius=0.8, center=(0.0, 0.2, 0.0)),
)
ALL_ROUND = tp.Source(
    tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="back"
)  # L = 1 everywhere within
FOG = tp.Medium(absorption=0.7, scattering=2.0, phase=tp.HenyeyGreenstein(0.5))
sphere = tp.Directions.sphere


def run(scene, particles=100_000, **options):
    return tp.simulate(scene, particles=particles, seed=1, threads=1, progress=False, **options)


def body(shape, medium, name="body"):
    return tp.Surface(shape, tp.Transparent(), name, inside=medium)


def whole(cells, volumes):
    """The mean over all cells."""
    return (cells * volumes).sum() / np.sum(volumes)


def rejects(estimate, wrong):
    with pytest.raises(AssertionError):
        assert_agrees(estimate, wrong, FALSE_ALARM)


# ---- in vacuum ----


@pytest.mark.parametrize("shape", [BOX, BALL], ids=["box", "ball"])
def test_the_mean_chord_of_isotropic_rays_is_four_volumes_over_the_surface(shape):
    """Cauchy (1841): so light of the power P from all of the boundary makes the fluence rate 4 P/S."""
    source = tp.Source(shape, tp.Lambertian(power=3.0), side="back")
    found = run(tp.Scene(source, [], tp.VolumeDetector(shape, "inside")))["inside"].fluence_rate
    assert_agrees(found, 12.0 / shape.area, FALSE_ALARM)
    assert found.relative_error < 0.01
    rejects(found, 12.0 / shape.area * 4 / 3)  # the mean over points instead of rays
    rejects(found, 12.0 / shape.area * 1.05)  # a volume 5 % wrong


@lru_cache
def lit():
    """Everything that looks at a field of radiance 1."""
    looks = [
        tp.VolumeDetector(BOX, "box"),
        tp.VolumeDetector(BOX, "voxels", (3, 4, 2)),
        tp.VolumeDetector(BALL, "ball"),
        tp.VolumeDetector(BALL, "shells", (4,)),
        tp.VolumeDetector(BALL, "hollow", (0.3, 0.31, 0.7)),
        tp.VolumeDetector(BOX, "ways", None, sphere(4, 3)),
        tp.VolumeDetector(
            BOX, "cells and ways", (1, 2, 1), sphere(mu=(-0.5, 0.1, 0.9), phi=(-1, 2), axis=(1, 2, 0))
        ),
        tp.VolumeDetector(BALL, "azimuth", (2,), sphere(mu=None, phi=4)),
    ]
    return run(tp.Scene(ALL_ROUND, [], looks), particles=400_000)


@pytest.mark.parametrize(
    "name", ["box", "voxels", "ball", "shells", "hollow", "ways", "cells and ways", "azimuth"]
)
def test_in_a_uniform_field_the_fluence_rate_is_4_pi_radiance_in_each_cell(name):
    reading = lit()[name]
    assert_agrees(reading.fluence_rate, 4 * math.pi, FALSE_ALARM)
    if reading.detector.directions is not None:
        assert_agrees(reading.radiance, 1.0, FALSE_ALARM)
        rejects(reading.radiance, 1.2)


def test_cells_add_up_to_the_whole():
    for part, all_of_it in (
        ("voxels", "box"),
        ("shells", "ball"),
        ("ways", "box"),
        ("cells and ways", "box"),
    ):
        reading = lit()[part]
        found = whole(reading.fluence_rate.value, reading.volumes)
        assert found == pytest.approx(lit()[all_of_it].fluence_rate.value, rel=1e-13)


def test_radiance_over_all_directions_is_the_fluence_rate():
    reading = lit()["ways"]
    angles = reading.detector.directions.solid_angles()
    assert angles.sum() == pytest.approx(4 * math.pi, rel=1e-15)
    assert (reading.radiance.value * angles).sum() == pytest.approx(reading.fluence_rate.value, rel=1e-13)
    some = lit()["cells and ways"]
    part = (some.radiance.value * some.detector.directions.solid_angles()).sum(axis=(-2, -1))
    assert (part < some.fluence_rate.value * 0.5).all()


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (0, 1, 0), (1, -2, 3)])
def test_radiance_is_told_by_the_direction_of_flight(axis):
    """A beam in known bins of cosine and azimuth."""
    flight = np.array((-0.48, 0.64, 0.6))
    beam = tp.Source(
        tp.Disk(radius=0.1, center=tuple(-3 * flight), normal=tuple(flight)), tp.Beam(flight, power=1.0)
    )
    reading = run(tp.Scene(beam, [], tp.VolumeDetector(BOX, "box", None, sphere(9, 12, axis))), 1000)["box"]
    e_w = np.array(axis) / np.linalg.norm(axis)
    up = np.array((0, 0, 1.0)) if axis == (0, 1, 0) else np.array((0, 1.0, 0))
    e_v = up - (up @ e_w) * e_w
    e_u = np.cross(e_v, e_w)
    e_v, e_u = e_v / np.linalg.norm(e_v), e_u / np.linalg.norm(e_u)
    turn = math.atan2(flight @ e_v, flight @ e_u) % (2 * math.pi)
    expected = int((flight @ e_w + 1) * 4.5), int(turn / (2 * math.pi) * 12)
    assert [tuple(map(int, place)) for place in np.argwhere(reading.radiance.value > 0)] == [expected]
    value = reading.radiance.value[expected] * (2 / 9 * math.pi / 6)
    assert value == pytest.approx(reading.fluence_rate.value, rel=1e-13)


def test_shells_have_the_volumes_between_their_spheres():
    radii = (0.0, 1e-9, 0.1, 0.1 + 1e-9, 0.7, 0.8)
    found = tp.VolumeDetector(BALL, "ball", radii).volumes(BALL)
    cubes = [Fraction(r) ** 3 for r in radii]
    exact = [4 / 3 * math.pi * float(b - a) for a, b in zip(cubes, cubes[1:], strict=False)]
    np.testing.assert_allclose(
        found, exact, rtol=1e-14
    )  # a difference of cubes has eight digits of the thin one
    assert tp.VolumeDetector(BALL, "ball", 7).volumes(BALL).sum() == pytest.approx(BALL.volume, rel=1e-15)
    assert tp.VolumeDetector(BOX, "box", (2, 3, 4)).volumes(BOX) == pytest.approx(
        np.full((2, 3, 4), 1 / 24), rel=1e-15
    )


# ---- in media ----

DEEP = tp.Box(size=(1.0, 1.0, 2.0))
FACE = tp.Rectangle(width=1.0, height=1.0, center=(0.0, 0.0, -1.5))
SIGMA = 1.3


def faded(edges):
    """Mean of exp(-SIGMA z) between depths."""
    return np.diff(-np.exp(-SIGMA * np.asarray(edges))) / SIGMA / np.diff(edges)


def test_a_beam_fades_in_each_cell_by_the_exact_integral():
    """Followed by weight no draw is made: every digit is right.  The power of 2 W falls on 1 m^2."""
    looks = [tp.VolumeDetector("body", "all"), tp.VolumeDetector(DEEP, "cells", (1, 1, 4))]
    looks += [tp.VolumeDetector(tp.Box(size=(0.5, 0.5, 1.0)), "inner", (2, 2, 5))]
    scene = tp.Scene(
        tp.Source(FACE, tp.Beam((0, 0, 1), power=2.0)), [body(DEEP, tp.Medium(absorption=SIGMA))], looks
    )
    result = run(scene, 2000, tracking="weighted")
    assert result["all"].fluence_rate.value == pytest.approx(2.0 * faded([0, 2])[0], rel=1e-13)
    np.testing.assert_allclose(
        result["cells"].fluence_rate.value[0, 0], 2.0 * faded(np.linspace(0, 2, 5)), rtol=1e-13
    )
    power = 2.0 * faded(np.linspace(0, 2, 5)) * SIGMA * 0.5
    np.testing.assert_allclose(result["cells"].absorbed_power.value[0, 0], power, rtol=1e-13)
    np.testing.assert_allclose(result["cells"].absorbed_density.value[0, 0], power / 0.5, rtol=1e-13)
    inner = result["inner"].fluence_rate.sum(("x", "y")) * 0.25
    for k, exact in enumerate(2.0 * faded(np.linspace(0.5, 1.5, 6))):  # a quarter of the beam, at random
        assert_agrees(inner[k], exact, FALSE_ALARM)


def test_the_same_by_chance():
    looks = [tp.VolumeDetector("body", "all"), tp.VolumeDetector("body", "cells", (1, 1, 4))]
    looks += [tp.VolumeDetector("body", "hits", (1, 1, 4), estimator="collision")]
    scene = tp.Scene(
        tp.Source(FACE, tp.Beam((0, 0, 1), power=2.0)), [body(DEEP, tp.Medium(absorption=SIGMA))], looks
    )
    result = run(scene, tracking="analog")
    exact = 2.0 * faded(np.linspace(0, 2, 5))
    assert_agrees(result["all"].fluence_rate, 2.0 * faded([0, 2])[0], FALSE_ALARM)
    for name in ("cells", "hits"):
        assert_agrees(result[name].fluence_rate[0, 0], exact, FALSE_ALARM)
        assert_agrees(result[name].absorbed_power[0, 0], exact * SIGMA * 0.5, FALSE_ALARM)
    rejects(result["cells"].fluence_rate[0, 0], np.full(4, 2.0))  # absorption left out
    hits = result["hits"]  # each collision is an absorption, of the ledger as well
    assert hits.absorbed_power.sum().value == pytest.approx(result.ledger["absorbed"].value, rel=1e-12)


@pytest.mark.parametrize("phase", [tp.Isotropic(), tp.HenyeyGreenstein(0.9), tp.Rayleigh()])
def test_a_ball_that_only_scatters_leaves_a_uniform_field_as_it_is(phase):
    """Radiance is conserved: 1 in all directions, inside as outside (Kirchhoff)."""
    medium = tp.Medium(scattering=3.0, phase=phase)
    looks = [
        tp.VolumeDetector("body", "ways"),
        tp.VolumeDetector("body", "hits", estimator="collision"),
        tp.VolumeDetector("body", "shells", (0.2, 0.5, 0.8)),
        tp.VolumeDetector("body", "hits in shells", (0.2, 0.5, 0.8), estimator="collision"),
        tp.VolumeDetector(tp.Box(size=0.6), "voxels", (2, 2, 2), sphere(2, 2)),
        tp.VolumeDetector(tp.Box(size=0.6), "hits in voxels", (2, 2, 2), sphere(2, 2), "collision"),
    ]
    result = run(tp.Scene(ALL_ROUND, [body(BALL, medium)], looks), particles=200_000)
    for reading in map(result.__getitem__, result):
        assert_agrees(reading.fluence_rate, 4 * math.pi, FALSE_ALARM)
        if reading.detector.directions is not None:
            assert_agrees(reading.radiance, 1.0, FALSE_ALARM)
    rejects(result["ways"].fluence_rate, 4 * math.pi * 1.06)
    for one, other in (("ways", "hits"), ("shells", "hits in shells"), ("voxels", "hits in voxels")):
        assert_agrees(result[one].fluence_rate - result[other].fluence_rate, 0.0, FALSE_ALARM)


@lru_cache
def foggy(tracking):
    looks = [
        tp.VolumeDetector("body", "ways"),
        tp.VolumeDetector("body", "hits", estimator="collision"),
        tp.VolumeDetector("body", "shells", (5,)),
        tp.VolumeDetector(tp.Box(size=2.2), "voxels about it", (3, 4, 5)),
        tp.VolumeDetector("body", "directions", (2,), sphere(2, 3)),
    ]
    return run(tp.Scene(ALL_ROUND, [body(BALL, FOG)], looks), tracking=tracking)


TRACKINGS = {
    "analog": "analog",
    "weighted": "weighted",
    "forced": tp.Tracking(forced=True),
    "split": tp.Tracking(splitting=tp.Splitting(start=(0, 0, -1), end=(0, 0, 1), gain=10.0)),
}


@pytest.mark.parametrize("tracking", TRACKINGS)
def test_what_the_volume_absorbs_is_what_the_ledger_says(tracking):
    result = foggy(TRACKINGS[tracking])
    absorbed = result.ledger["absorbed"]
    totals = {name: result[name].absorbed_power for name in result}
    totals = {name: power if name in ("ways", "hits") else power.sum() for name, power in totals.items()}
    for name, power in totals.items():
        assert_agrees(power - absorbed, 0.0, FALSE_ALARM) if tracking == "analog" or name == "hits" else None
        rejects(power - absorbed * 1.1, 0.0)
        if tracking != "analog" and name != "hits":  # flight by flight, to rounding
            assert power.value == pytest.approx(absorbed.value, rel=1e-12)
    for name in ("shells", "voxels about it", "directions"):
        assert totals[name].value == pytest.approx(totals["ways"].value, rel=1e-12)
    ways = result["ways"]
    assert ways.absorbed_power.value == pytest.approx(0.7 * ways.fluence_rate.value * BALL.volume, rel=1e-12)


def test_however_histories_are_followed_the_same_comes_out():
    for tracking in ("analog", "forced", "split"):
        for name in ("ways", "hits", "shells", "voxels about it"):
            one, other = (foggy(TRACKINGS[each])[name].fluence_rate for each in (tracking, "weighted"))
            z = (one.value - other.value) / np.hypot(one.error, other.error)
            assert np.abs(z).max() < 5


@lru_cache
def voxelled(tracking, scatters=True):
    rng = np.random.default_rng(1)
    box, shape = tp.Box(size=(1.0, 1.2, 0.9)), (3, 4, 2)
    absorption, scattering = rng.uniform(0.1, 3, shape), rng.uniform(0.2, 4, shape) * scatters
    grid = tp.Grid(box=box, absorption=absorption, scattering=scattering)
    looks = [
        tp.VolumeDetector("body", "all"),
        tp.VolumeDetector("body", "same", shape),
        tp.VolumeDetector("body", "other", (5, 3, 4)),
        tp.VolumeDetector(tp.Box(size=1.5), "about it", (2, 2, 2)),
        tp.VolumeDetector(tp.Sphere(radius=0.4), "ball", (3,)),
    ]
    if scatters:
        looks += [tp.VolumeDetector("body", "hits", (5, 3, 4), estimator="collision")]
    return absorption, run(tp.Scene(ALL_ROUND, [body(box, grid)], looks), tracking=tracking)


@pytest.mark.parametrize("scatters", [False, True], ids=["absorbing", "scattering"])
@pytest.mark.parametrize("tracking", ["analog", "weighted"])
def test_in_a_grid_each_cell_absorbs_by_the_voxels_on_the_way(tracking, scatters):
    absorption, result = voxelled(tracking, scatters)
    same = result["same"]
    np.testing.assert_allclose(
        same.absorbed_power.value, absorption * same.fluence_rate.value * same.volumes, rtol=1e-12
    )
    total = result["all"].absorbed_power
    for name in ("same", "other", "about it"):
        assert result[name].absorbed_power.sum().value == pytest.approx(total.value, rel=1e-12)
    for name in ("same", "other"):
        found = whole(result[name].fluence_rate.value, result[name].volumes)
        assert found == pytest.approx(result["all"].fluence_rate.value, rel=1e-12)
    if tracking == "weighted" and not scatters:
        assert total.value == pytest.approx(result.ledger["absorbed"].value, rel=1e-12)
    assert_agrees(
        total - result.ledger["absorbed"], 0.0, FALSE_ALARM
    ) if tracking == "analog" or scatters else None
    if scatters:
        assert_agrees(result["other"].fluence_rate - result["hits"].fluence_rate, 0.0, FALSE_ALARM)
        assert_agrees(result["other"].absorbed_power - result["hits"].absorbed_power, 0.0, FALSE_ALARM)


# ---- with a clock ----


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


# ---- how it is counted ----


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
        machine_of(program_of(compile_scene(result.scene, result.plan.tracking))),
        empty_bundle(),
    )
    raw = run_batch(machine, seed=1, batch=0, histories=5000, bundle=bundle)
    high, scores = raw.meters[1:, 0].sum(), raw.meters[1:, 2].sum()
    assert bundle["scored"][0] >= high > 0 and bundle["scored"][0] - high >= A_SCORE * scores // 2 > 0
    each = raw.meters[1:, 0] / np.maximum(raw.meters[1:, 2], 1)
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
    assert result["ball"].fluence_rate.to_xarray()["r"].attrs == {"unit": "m"}


# ---- refused ----


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ({"shape": tp.Slab(thickness=1.0)}, "from face to face"),
        ({"shape": tp.Disk(radius=1.0)}, "Box or a Sphere"),
        ({"shape": tp.Sphere(radius=1.0, mu_min=0.0)}, "whole Sphere"),
        ({"name": None}, "name must be given"),
        ({"cells": (2, 2)}, "three whole numbers"),
        ({"cells": (2, 0, 2)}, "from 1 to"),
        ({"cells": (2.5, 1, 1)}, "whole numbers"),
        ({"cells": 3}, "three whole numbers"),
        ({"cells": "many"}, "must be"),
        ({"cells": (-1, 2, 3)}, "must be"),
        ({"cells": (500, 500, 500)}, "10000000"),
        ({"shape": BALL, "cells": (0.1, 0.9)}, "radii"),
        ({"shape": BALL, "cells": (0.3, 0.2)}, "radii"),
        ({"shape": BALL, "cells": (0.5,)}, "number of shells"),
        ({"shape": BALL, "cells": (0,)}, "number of shells"),
        ({"directions": tp.Directions(mu=4)}, "Directions.sphere"),
        ({"directions": 8}, "Directions.sphere"),
        ({"estimator": "chord"}, "'track' or 'collision'"),
    ],
)
def test_a_volume_that_cannot_be_looked_at_is_refused(values, word):
    with pytest.raises(tp.SceneError, match=word):
        tp.VolumeDetector(**{"shape": BOX, "name": "box"} | values)


def test_all_directions_are_refused_where_they_make_no_sense():
    for values, word in (
        ({"mu": (-1.5, 1)}, "within"),
        ({"phi": (0, 7)}, "one turn"),
        ({"axis": (0, 0, 0)}, "axis"),
    ):
        with pytest.raises(tp.SceneError, match=word):
            sphere(**values)
    with pytest.raises(tp.SceneError, match="Directions"):
        tp.Detector(BOX, "meter", directions=sphere())


@pytest.mark.parametrize(
    ("surfaces", "tracking", "word"),
    [
        ([], None, "Vacuum"),
        ([body(BALL, tp.Medium(absorption=1.0))], "weighted", "scatter"),
        ([body(tp.Sphere(radius=0.5), FOG)], "analog", "Vacuum"),
    ],
)
def test_collisions_are_refused_where_there_are_none(surfaces, tracking, word):
    scene = tp.Scene(ALL_ROUND, surfaces, tp.VolumeDetector(BALL, "ball", estimator="collision"))
    with pytest.raises(tp.SceneError, match=word):
        run(scene, 1000, tracking=tracking)


def test_quantities_that_a_volume_was_not_set_up_for_are_refused():
    reading = lit()["box"]
    for quantity, word in (
        ("absorbed_power", "medium that absorbs"),
        ("radiance", "sphere"),
        ("fluence", "duration"),
        ("absorbed_energy", "duration"),
    ):
        with pytest.raises(tp.SceneError, match=word):
            getattr(reading, quantity)
    with pytest.raises(AttributeError, match="did you mean 'fluence_rate'"):
        _ = reading.fluence_rates
    with pytest.raises(tp.SceneError, match="must name a surface"):
        tp.Scene(ALL_ROUND, [], tp.VolumeDetector("fog"))
    with pytest.raises(tp.SceneError, match="unique"):
        tp.Scene(ALL_ROUND, [], [tp.VolumeDetector(BOX, "box"), tp.Detector(BOX, "box")])
    for target in ("box.flux_in", "box.fluence", "box"):
        with pytest.raises(tp.SceneError):
            tp.simulate(tp.Scene(ALL_ROUND, [], tp.VolumeDetector(BOX, "box")), error={target: 0.1})
