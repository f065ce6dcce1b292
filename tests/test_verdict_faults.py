"""Each test fails for a fault planted in the code of findings and verdicts that the rest of the suite let pass."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

import transport as tp
from tests.detectors.test_surface_detectors import METER, flat_beam
from tests.test_choosing import AIMED, ANALOG, fake_run, one, pilots_of, scene
from tests.test_findings import EYE, PANEL, disk_lamp, estimate, lamp_before_a_reflector, mirror, run
from tests.test_quality import quality_of_draws
from transport.compile.methods import Method
from transport.results.choice import Pilot
from transport.results.diagnostics.proofs import Probe
from transport.results.diagnostics.run_findings import warnings_of
from transport.run.auto import cheapest, choose_method, select_method
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.findings import (
    Finding,
    even_scores_findings,
    particle_factors_needed,
    unseen_scores,
)
from transport.statistics.replicates import Batches

UNSEEN = Finding("doubtful", "detector 'm'", "", "light via 'mirror' not sampled", 1.0)


def grazing(reading):
    return any(finding.name == "grazing" for finding in reading.fluence_rate.findings)


# ---- grazing.py ----


def test_each_detector_is_told_of_the_light_that_grazes_it_and_no_other():
    """The first of two is crossed by nothing; the second by a beam beyond the cut."""
    away = tp.Detector(tp.Disk(center=(0, 0, 5), radius=0.1), "away")
    result = tp.simulate(tp.Scene(flat_beam(5e-4), (), [away, METER]), 20_000, seed=1, progress=False)
    assert grazing(result["meter"])


def test_a_beam_beyond_the_cut_is_told_where_weights_differ():
    """Estimators that weigh what they score have no count by which to tell: the mean of 1/|mu| does."""
    for mu, is_told in ((5e-4, True), (0.5, False)):
        result = tp.simulate(
            tp.Scene(flat_beam(mu), (), METER), 20_000, seed=1, estimator="expected", progress=False
        )
        assert grazing(result["meter"]) == is_told


# ---- the chooser ----


def test_of_two_limits_the_one_that_ends_the_run_settles_what_is_doubtful():
    """Pilots of 1000 histories and 1 s; a hundred times as many settle it, which the seconds do not allow."""
    pilots = pilots_of((one(0.001, findings=(UNSEEN,)), 1.0), (one(0.01), 10.0))
    assert select_method(pilots, has_error=False, particles=110_000, seconds=110.0).method == ANALOG
    assert select_method(pilots, has_error=False, particles=110_000, seconds=10.0).method == AIMED


def test_a_way_that_misses_light_is_not_taken_though_the_other_is_doubtful():
    pilots = pilots_of((one(0.1, 2.61, findings=(UNSEEN,)), 10.0), (one(1e-9, 1.785), 1e-9))
    choice = select_method(pilots, has_error=False, particles=1000)
    assert choice.method == ANALOG and not choice.is_trusted


# ---- quality.py ----


def test_a_number_with_a_batch_far_above_all_others_is_doubtful():
    values = (np.random.default_rng(1).random((32, 100)) < 0.1).astype(float)
    values[7] = 1.0
    _, quality = quality_of_draws(values.ravel())
    assert any("one batch is far above all others" in doubt for doubt in quality.doubts)


def test_few_scores_in_many_batches_are_no_batch_that_stands_alone():
    """About 33 scores in 4096 batches: each batch with one is far above all others."""
    meter = tp.Detector(tp.Disk(center=(0, 0, 11), normal=(0, 0, -1), radius=1.0), "meter")
    lamp = tp.Source(tp.Disk(radius=0.1), tp.Lambertian(power=1.0))
    result = tp.simulate(tp.Scene(lamp, (), meter), 4096, batches=4096, seed=1, threads=1, progress=False)
    assert 25 <= result["meter"].counts.value < 80
    assert not any("far above" in finding.what for finding in result["meter"].flux_in.findings)


def test_small_batches_among_large_ones_are_no_trend():
    """Of a merged run whose second part has a hundredth of the histories, ten times as far apart."""
    meter = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0), "meter")
    scene = tp.Scene(tp.Source(tp.Disk(radius=1.0), tp.Lambertian(power=1.0)), (), meter)
    parts = [
        tp.simulate(scene, particles, seed=seed, threads=1, progress=False)
        for seed, particles in ((1, 320_000), (2, 3200))
    ]
    merged = tp.merge(*parts)["meter"].flux_in
    assert merged.verdict == "sound" and not any(finding.name == "batches" for finding in merged.findings)


# ---- trust.py ----


def test_a_warning_about_two_detectors_names_the_particles_of_the_one_that_takes_most():
    for pair in ((100.0, 2.0), (2.0, 100.0)):
        findings = [
            Finding(
                "doubtful", f"detector {name!r}", "flux_in", "light", 1.0, "use more particles", times=times
            )
            for name, times in zip("ab", pair, strict=True)
        ]
        (warning,) = warnings_of(findings, 1000)
        assert "Use about 1e5 particles" in warning


def test_a_warning_says_how_many_smaller_findings_a_number_has_and_where_they_are():
    """Next-event rays miss the light of a mirror, of near walls, and of a small wall just above the meter."""
    lamp = tp.Source(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.05), tp.Lambertian(radiance=1.0))
    walls = {
        "mirror": (tp.Mirror(0.9), {"center": (1, 0, 1), "normal": (-1, 0, 0)}, 2.0),
        "wall": (tp.Diffuse(0.5), {"center": (0, 0, 0), "normal": (0, 0, 1)}, 4.0),
        "near": (tp.Diffuse(0.9), {"center": (0, 0, 0.3), "normal": (0, 0, -1)}, 0.05),
    }
    surfaces = [
        tp.Surface(tp.Rectangle(**place, width=size, height=size), material, name)
        for name, (material, place, size) in walls.items()
    ]
    meter = tp.Detector(tp.Disk(center=(0.3, 0.2, 0.01), normal=(0, 0, 1), radius=0.02), "meter")
    scene = tp.Scene(lamp, surfaces, meter)
    result = tp.simulate(scene, 300, seed=1, estimator="expected", progress=False)
    (warning,) = [each for each in result.warnings if each.startswith("flux_in")]
    doubts = [each for each in result.quality("meter.flux_in").findings if each.severity == "doubtful"]
    assert len(doubts) >= 3 and doubts[0].what in warning
    assert "; result.quality('meter.flux_in') lists 2 more doubtful findings. " in warning


def test_a_detector_that_one_of_two_aims_leaves_out_is_told_of():
    there, here = (
        tp.Disk(center=(3, 0, 2), normal=(0, 0, -1), radius=1.0),
        tp.Disk(center=(0, 0, 2), radius=1.0),
    )
    lamps = [tp.Source(tp.Disk(radius=0.1), tp.Lambertian(power=1.0), aim=aim) for aim in (here, there)]
    result = tp.simulate(tp.Scene(lamps, (), tp.Detector(here, "m")), 1000, seed=1, progress=False)
    assert "detector 'm' sees an aimed source only in the directions of its aim" in result.warnings


# ---- run/run.py ----


def test_a_doubt_about_a_class_without_a_score_ends_no_run_before_2_to_the_18_histories():
    result = tp.simulate(mirror(), error={"m.irradiance": 1e-2}, seed=1, estimator="expected", progress=False)
    assert result["m"].irradiance.is_doubtful and result.particles >= 1 << 18


def test_a_doubt_that_the_nearer_of_two_limits_leaves_ends_a_run():
    """The particles would not settle it, though the seconds would: running on to the particles is for nothing."""
    limits = {"error": {"m.irradiance": 1e-6}, "particles": 1_000_000, "seconds": 1e20}
    result = tp.simulate(mirror(), **limits, seed=1, estimator="expected", progress=False)
    assert result["m"].irradiance.is_doubtful and result.particles < 1_000_000


# ---- path_classes.py ----


def test_a_probe_of_a_dim_mirror_does_not_bound_what_comes_straight():
    """A speck of a lamp that none of 1000 backward histories meets: P / (pi d^2) = 0.0796 W m^-2; its mirror sends 1e-4 of that."""
    lamp = disk_lamp((0, 0, 2), (0, 0, -1), 1e-3, 1.0)
    panel = tp.Surface(PANEL, tp.Mirror(1e-4), "mirror")
    found = run([lamp], [panel], tp.Detector(tp.Disk(radius=1e-3), "m"), 1000, "backward").irradiance
    assert found.interval()[1] > 1 / (math.pi * 4)


def test_a_wide_bin_among_narrow_ones_has_fewer_histories_to_find_strong_rays():
    """100 bins of which one has nearly all of the light and a hundredth of the histories: the bound is about 100 times that without bins."""
    lamps, walls, (plain,) = lamp_before_a_reflector(1e-3)
    bins = tp.Directions(mu=np.concatenate([[0.0], np.linspace(0.9999999, 1, 100)]))
    binned = tp.Detector(plain.shape, "m", directions=bins)
    bounds = []
    for detector in (plain, binned):
        found = run(lamps, walls, detector, 1e4, "backward").irradiance
        bounds.append(next(each.bound for each in found.findings if each.name == "strong rays"))
    assert bounds[1] > 20 * bounds[0]


# ---- proofs.py ----


def test_a_probe_of_a_dark_gloss_finds_its_share_of_a_bright_one():
    """Probes brighten what is dark, and count the less."""
    bright, dark = (
        Probe(mirror(tp.Glossy(0.05, albedo)), EYE, [0]).bound(1e6, 0.0)[1] for albedo in (1.0, 0.01)
    )
    assert 0.7 < dark / (0.01 * bright) < 1.4


# ---- findings.py ----


def test_a_difference_of_two_numbers_may_be_off_both_ways():
    """Both may be 1 more, of the same light by name: the difference may be 1 more or 1 less, and is not sure."""
    difference = estimate(10.0, 0.01, 1.0) - estimate(4.0, 0.01, 1.0)
    low, high = difference.interval()
    assert difference.is_doubtful and low < 5.0 and high > 7.0


def test_what_scores_foretell_counts_for_batches_that_look_odd_as_well():
    few = Finding("doubtful", "", "", "only 5 scores", 0.5, times=5.0)
    odd = Finding("doubtful", "", "", "one batch is far above all others")
    assert particle_factors_needed([few, odd], 1.0, 0.01, 0.01) == (5.0, 1.0, "only 5 scores")


def test_batches_with_as_many_scores_may_have_one_too_many_as_well_as_one_too_few():
    found = even_scores_findings(np.array(1.0), np.array(0.0), np.array(30.0), 1000)
    assert sorted(np.sign(each.bound) for each in found) == [-1.0, 1.0]


# ---- the chooser ----


def test_the_cost_of_a_way_has_the_histories_until_it_is_no_doubt():
    seldom = Pilot(AIMED, 1.0, 32.0, 1000, "", 1.0, foretold=100.0)
    assert cheapest([Pilot(ANALOG, 10.0, 32.0, 1000, "", 1.0), seldom]).method == ANALOG


def test_nets_of_a_run_for_a_time_must_save_their_earlier_rounds_as_well(monkeypatch):
    sobol, errors = Method("analog", "sobol"), {}
    errors |= {ANALOG: 1.0, sobol: 0.7}
    monkeypatch.setattr("transport.run.auto.methods_for", lambda scene: list(errors))
    for seconds, taken in ((None, sobol), (1.0, ANALOG)):
        calls = []
        choice = choose_method(
            scene(),
            None,
            None,
            fake_run(errors, calls),
            lambda calls=calls: sum(n * 1e-6 for _, n in calls),
            seconds=seconds,
        )
        assert choice.method == taken


# ---- shields ----


def shield(shape, detector, absorption=20.0, source=None):
    """A beam (or another source) before an absorbing body, and a detector behind it."""
    beam = tp.Source(tp.Disk(radius=0.1), tp.Beam(power=1.0, direction=(0, 0, 1)))
    medium = tp.Medium(absorption=absorption)
    return tp.Scene(
        source or beam,
        tp.Surface(shape, tp.Transparent(), "shield", inside=medium),
        tp.Detector(detector, "m"),
    )


BEHIND = tp.Disk(center=(0, 0, 3), normal=(0, 0, -1), radius=0.2)


def test_a_shield_with_a_gap_that_no_history_met_is_doubtful():
    """A slit of 1e-3 of the beam in front of which the shield ends; 1000 histories of weight e^-10 do not show that it is closed."""
    rectangle = tp.Rectangle(width=1.0, height=1.0)
    beam = tp.Source(rectangle, tp.Beam(power=1.0, direction=(0, 0, 1)))
    box = tp.Box(center=(-0.5005, 0, 1), size=(1.999, 2, 0.5))
    far = tp.Rectangle(center=(0, 0, 3), normal=(0, 0, -1), width=3.0, height=3.0)
    scene, truth = shield(box, far, source=beam), 1e-3 + (1 - 1e-3) * math.exp(-10)
    for seed in range(8):
        found = tp.simulate(scene, 1000, seed=seed, progress=False)["m"].flux_in
        low, high = found.interval(0.999)
        assert found.is_doubtful and low <= truth <= high


def test_a_shield_that_geometry_proves_to_be_closed_is_no_doubt():
    """Behind a slab, behind a box that is wide enough, and around a source; not behind a box that is too narrow."""
    slab, inner = tp.Slab(center=(0, 0, 1), thickness=0.5), tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    for shape, source, is_proven in (
        (slab, None, True),
        (tp.Box(center=(0, 0, 1), size=(1, 1, 0.5)), None, True),
        (tp.Box(center=(0.35, 0, 1), size=(1, 1, 0.5)), None, False),
        (tp.Sphere(radius=0.5), inner, True),
        (tp.Box(size=(1, 1, 1)), inner, True),
    ):
        found = tp.simulate(shield(shape, BEHIND, source=source), 100_000, seed=1, progress=False)[
            "m"
        ].flux_in
        assert found.is_doubtful != is_proven, shape


# ---- few histories ----


def test_a_ratio_with_a_weak_denominator_is_doubtful():
    """A big plate over a small one that few histories meet: a denominator of 4 scores, or of 100."""
    lamp = tp.Source(tp.Disk(radius=0.1), tp.Lambertian(power=1.0))
    ratios = {}
    for radius in (0.02, 0.1):
        small = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=radius), "small")
        big = tp.Detector(tp.Disk(center=(0, 0, 1.1), normal=(0, 0, -1), radius=1.0), "big")
        result = tp.simulate(tp.Scene(lamp, (), [small, big]), 10_000, seed=1, progress=False)
        ratios[radius] = result["big"].flux_in / result["small"].flux_in
    assert ratios[0.02].is_doubtful and "denominator" in "".join(each.what for each in ratios[0.02].findings)
    assert not ratios[0.1].is_doubtful


def test_scores_of_one_history_are_not_as_many_independent_ones():
    """All 20 scores in one batch, as of one history in a white sphere, or one in each of 20 batches."""
    values = np.zeros((32, 1))
    values[3] = 0.02
    batches = Batches(np.full(32, 1000))
    few = Estimate(values[:, 0], batches, "W", counts=20)._with_findings(tuple)
    even = Estimate(np.r_[np.full(20, 1e-3), np.zeros(12)], batches, "W", counts=20)._with_findings(tuple)
    assert few.is_doubtful and few.findings[0].bound > 5 * few.error
    assert even.is_doubtful and math.isclose(even.findings[0].bound, unseen_scores(20) / 20 * even.value)


def test_scores_that_spread_as_few_independent_ones_do_are_too_few_though_many():
    """200 scores, nearly all of them of one batch: as of an integrating sphere of which one history met the port; and their sum by bins."""
    batches, values = Batches(np.full(32, 1000)), np.full((32, 2), 1e-5)
    values[3] = 0.01
    many = Estimate(values[:, 0], batches, "W", counts=200)._with_findings(tuple)
    bins = EstimateArray(values, batches, "W", ("mu",), {"mu": [0, 0.5, 1.0]}, np.array([100, 100]))
    for found in (many, bins._with_findings(tuple).sum()):
        assert found.is_doubtful and "200 scores spread as 1.1 independent ones do" in found.findings[0].what
        assert found.findings[0].bound > 5 * found.error
    level = Estimate(values[:, 0] + 1e-3, batches, "W", counts=200)._with_findings(tuple)
    assert not level.is_doubtful


def test_ways_of_light_weight_through_a_volume_show_no_gap():
    """As for a detector behind a shield with a slit of 1e-3; a shield that is closed by proof is no doubt."""
    beam = tp.Source(tp.Rectangle(width=1.0, height=1.0), tp.Beam(power=1.0, direction=(0, 0, 1)))
    volume = tp.VolumeDetector(tp.Box(center=(0, 0, 3), size=(1.2, 1.2, 0.5)), "m")
    truth = (1e-3 + (1 - 1e-3) * math.exp(-10)) * 0.5 / volume.shape.volume
    for shape, is_proven in (
        (tp.Box(center=(-0.5005, 0, 1), size=(1.999, 2, 0.5)), False),
        (tp.Slab(center=(0, 0, 1), thickness=0.5), True),
    ):
        body = tp.Surface(shape, tp.Transparent(), "shield", inside=tp.Medium(absorption=20.0))
        for seed in range(4):
            result = tp.simulate(tp.Scene(beam, body, volume), 1000, seed=seed, progress=False)
            found = result["m"].fluence_rate
            assert found.is_doubtful != is_proven
            assert is_proven or found.interval(0.999)[0] <= truth <= found.interval(0.999)[1]


def test_a_small_faint_lamp_beside_a_point_that_no_history_was_born_on_is_doubtful():
    big = tp.Source(tp.Sphere(center=(0, 0, 3), radius=0.5), tp.Lambertian(power=1.0))
    for emission in (tp.Lambertian(power=1e-4), tp.Isotropic(power=1e-4)):
        small = tp.Source(tp.Sphere(center=(0.05, 0, 0), radius=0.002), emission)
        scene = tp.Scene([big, small], (), tp.PointDetector((0, 0, 0), "p"))
        few, many = (
            tp.simulate(scene, n, seed=2, progress=False)["p"].fluence_rate for n in (10_000, 1_000_000)
        )
        low, high = few.interval()
        assert few.is_doubtful and low <= many.value <= high and "to be born there" in few.findings[0].what
        assert not many.is_doubtful


def test_a_mean_speed_is_as_doubtful_as_the_light_that_it_is_the_mean_of():
    """A slow beam behind an absorbing slab with a slit, and a fast faint one through the slit, of which few or no histories are."""
    slow, fast = (
        tp.Source(
            tp.Rectangle(center=(x, 0, 0), width=width, height=0.1),
            tp.Beam(power=power, direction=(0, 0, 1), speed=speed),
        )
        for x, width, power, speed in ((-0.5, 0.9, 1.0, 1.0), (0.005, 0.005, 1e-3, 2.0))
    )
    box = tp.Box(center=(-1, 0, 1), size=(2, 2, 0.5))
    body = tp.Surface(box, tp.Transparent(), "shield", inside=tp.Medium(absorption=20.0))
    far = tp.Rectangle(center=(0, 0, 3), normal=(0, 0, -1), width=3.0, height=3.0)
    truth = (2e-3 + math.exp(-10)) / (1e-3 + math.exp(-10))
    for seed in range(4):
        scene = tp.Scene([slow, fast], body, tp.Detector(far, "m", moments=True))
        reading = tp.simulate(scene, 1000, seed=seed, progress=False)["m"]
        low, high = reading.mean_speed_in.interval()
        assert reading.flux_in.is_doubtful and reading.mean_speed_in.is_doubtful
        assert math.isnan(low) or low <= truth <= high
    alike = [replace(slow, emission=replace(slow.emission, speed=2.0)), fast]
    scene = replace(scene, sources=alike)
    assert not tp.simulate(scene, 1000, seed=1, progress=False)["m"].mean_speed_in.is_doubtful
