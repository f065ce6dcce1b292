"""The quality of an error bar: its numbers are right, and it reports when rare large scores are missing."""

import dataclasses
import math
import re
from functools import reduce

import numpy as np
import pytest
from scipy.special import stdtr

import transport as tp
from transport.compile.compiler import compile_scene
from transport.compile.detectors import COUNTED_EVERY, EDGES
from transport.results.diagnostics.score_sizes import detector_scores
from transport.results.tally import ARRIVALS, DEPARTURES, SIDES
from transport.statistics.batches import MIN_SCORES_FOR_ERROR as FEW
from transport.statistics.batches import outlier_probability, trend_probability
from transport.statistics.estimates import Estimate
from transport.statistics.quality import Scores, quality_of
from transport.statistics.replicates import Batches

SEEDS = 200
MID = 0.5 * (EDGES[1:] + EDGES[:-1])
LAMP = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(radiance=1.0))


def aimed(distance: float = 0.01, radius: float = 0.001, **bins) -> tp.Scene:
    """A disk that glows, aimed at a small one close above its middle: few births are near, and they bring most."""
    meter = tp.Disk(center=(0, 0, distance), radius=radius, normal=(0, 0, -1))
    return tp.Scene(dataclasses.replace(LAMP, aim=meter), (), tp.Detector(meter, "meter", **bins))


def exact(distance: float, radius: float) -> float:
    """What falls on it [W m^-2]: pi times the view factor of coaxial disks (Walton 1986)."""
    x = 1 + (distance**2 + 1) / radius**2
    return math.pi * 2 / radius**2 / (x + math.sqrt(x * x - 4 / radius**2))


def run(scene: tp.Scene, particles: int, seed: int = 1, **options):
    return tp.simulate(scene, particles=particles, seed=seed, progress=False, **{"threads": 1} | options)


def counted(values: np.ndarray) -> Scores:
    """Draws as a count by size."""
    edges = (np.ldexp(1.0, np.arange(-60, 61))[:, None] * (1 + np.arange(4) / 4)).ravel()
    counts = np.histogram(values[values > 0], edges)[0]
    return Scores(edges[:-1], edges[1:], 0.5 * (edges[1:] + edges[:-1]), counts)


def quality_of_draws(values: np.ndarray):
    """Of one draw a history, in 32 batches."""
    run = Batches(np.full(32, len(values) // 32))
    estimate = Estimate(values.reshape(32, -1).mean(axis=1), run, "1")
    return estimate, quality_of(estimate, counted(values), len(values), seconds=1.0)


def pareto(index: float, rng, shape: tuple[int, ...]) -> np.ndarray:
    return rng.random(shape) ** (-1 / index)


# ---- the count ----


def sizes_of(result, side: int = ARRIVALS) -> Scores:
    return detector_scores(result["meter"], side)


def test_every_score_is_counted_with_its_size_on_its_side():
    """Each once; the edges of the cells enclose the weight that came; what leaves is counted by itself."""
    result = run(aimed(0.1, 0.01), 100_000)
    arrived, left = sizes_of(result), sizes_of(result, DEPARTURES)
    weights = sum(batch.weights.sum() for batch in result.batches)
    assert arrived.number == 100_000 == round(result["meter"].counts.value) and left.number == 0
    assert arrived.counts @ arrived.low < weights < arrived.counts @ arrived.high
    assert arrived.high[np.flatnonzero(arrived.counts)[-1]] <= 1.0  # as heavy as the heaviest birth at most


def test_walls_of_fog_are_counted_side_by_side():
    """Where nearly every lane scores as well: there one batch in EVERY counts."""
    box, fog = tp.Box(size=2.0), tp.Medium(absorption=0.2)
    meter = tp.Detector("walls", "meter", side="back", directions=tp.Directions(mu=4))
    lamp = tp.Source("walls", tp.Lambertian(exitance=1.0), side="back")
    result = run(tp.Scene(lamp, tp.Surface(box, tp.Diffuse(0.5), "walls", inside=fog), meter), 20_000)
    for side in (ARRIVALS, DEPARTURES):
        scores, meter, score = sizes_of(result, side), result["meter"], f"weight {SIDES[side]}"
        counts, weights = meter.counts_of(score), meter.sums(score)
        assert scores.number == counts.sum() > 20_000
        assert scores.counts.sum() == counts[::COUNTED_EVERY].sum() == round(scores.share * counts.sum())
        assert scores.counts @ scores.low < weights[::COUNTED_EVERY].sum() < scores.counts @ scores.high


def test_the_count_does_not_depend_on_threads_and_survives_merging():
    one, two = (sizes_of(run(aimed(), 20_000, threads=threads)) for threads in (1, 2))
    np.testing.assert_array_equal(one.counts, two.counts)
    merged = run(aimed(), 70_000, seed=0, error={"meter.flux_in": 1e-9}, estimator="analog")
    assert sizes_of(merged).number == merged.particles == 70_000


def hidden(share: float = 5e-5) -> tuple[tp.Scene, float]:
    """A meter that sees a wide dim lamp, and a small white plate that a bright lamp lights, which it does not see.

    With its irradiance [W m^-2], of which the plate's is three quarters; share: of the meter's view that is the plate's.
    """
    meter, radius, away, lit = tp.Disk(radius=0.01), math.sqrt(share), 0.2, 0.02
    dim, plate = 1.4**2 / (1.4**2 + 4), share / (1 + share)  # view factors
    radiance = 3 * dim / plate * math.pi / (math.pi * lit**2 / math.sqrt(2) / (2 * away**2))
    wide = tp.Source(tp.Disk(center=(0, 0, 2), radius=1.4, normal=(0, 0, -1)), tp.Lambertian(radiance=1.0))
    bright = tp.Disk(center=(away, 0, 1 - away), normal=(-1, 0, 1), radius=lit)
    shield = tp.Disk(center=(away + 1e-3, 0, 1 - away - 1e-3), normal=(-1, 0, 1), radius=1.01 * lit)
    surfaces = [
        tp.Surface(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=radius), tp.Diffuse(1.0)),
        tp.Surface(shield, tp.Black()),
    ]
    sources = [wide, tp.Source(bright, tp.Lambertian(radiance=radiance))]
    return tp.Scene(sources, surfaces, [tp.Detector(meter, "meter")]), 4 * dim * math.pi


def test_histories_that_run_backwards_are_counted_by_size():
    """Of one cell: as many as met a source, and what they brought lies between the cells' edges."""
    scene, _ = hidden(0.01)
    result = run(scene, 20_000, estimator="backward")
    scores = result["meter"].diagnosis.score_sizes("weight in")
    brought = result["meter"].irradiance.value / math.pi * result.particles
    assert scores.number == round(result["meter"].counts.value) == scores.counts.sum()
    least, most = (scores.counts @ edges for edges in (scores.low, scores.high))
    assert least < brought < most < 1.26 * least  # a quarter of an octave
    bins = tp.Detector(scene.detectors[0].shape, "meter", directions=tp.Directions(mu=2))
    result = run(tp.Scene(scene.sources, scene.surfaces, [bins]), 20_000, estimator="backward")
    assert len(result["meter"].diagnosis.score_sizes("weight in").counts) == 1


def test_equal_scores_are_not_counted_by_size():
    """Neither beside a plain source nor in a grey box: how many there are tells all."""
    plain = tp.Scene(LAMP, (), aimed().detectors)
    assert compile_scene(plain).size_cells == 0 < compile_scene(aimed()).size_cells
    result = run(plain, 100_000)
    assert sizes_of(result).number == round(result["meter"].counts.value)


def test_an_aim_seen_edge_on_has_no_heavy_births_and_is_not_doubted():
    """Its largest weight is a bound that none comes up to; what counts is the heaviest that was born."""
    meter = tp.Disk(center=(1.5, 0, 0.1), normal=(0, 0, -1), radius=0.1)
    lamp = tp.Source(tp.Disk(radius=0.3), tp.Lambertian(radiance=1.0), aim=meter)
    result = run(tp.Scene([lamp], (), [tp.Detector(meter, "meter")]), 5000)
    heaviest = max(batch.heaviest for batch in result.batches)
    assert 0 < heaviest < 0.25 and sum(batch.born for batch in result.batches) < 100
    assert result.warnings == []


def test_the_heaviest_birth_is_the_same_however_it_is_run():
    one, two = (run(aimed(0.1, 0.01), 20_000, threads=threads) for threads in (1, 2))
    assert [batch.heaviest for batch in one.batches] == [batch.heaviest for batch in two.batches]
    heaviest = max(batch.heaviest for batch in one.batches)
    assert 0.5 < heaviest <= 1.0
    whole = reduce(lambda batch, other: batch.merged(other, 0), one.batches)
    assert whole.heaviest == heaviest


# ---- its numbers ----


def test_moments_are_those_of_the_scores():
    """VOV as its definition has it, with histories that score nothing."""
    rng = np.random.default_rng(3)
    values = np.where(rng.random(32_000) < 0.3, MID[rng.integers(150, 200, 32_000)], 0.0)
    deviations = values - values.mean()
    vov = (deviations**4).sum() / (deviations**2).sum() ** 2 - 1 / len(values)
    scores = counted(values)
    assert scores.vov(len(values)) == pytest.approx(vov, rel=1e-9)
    assert scores.carriers == pytest.approx((values**2).sum() ** 2 / (values**4).sum(), rel=1e-9)
    top = values.max()
    assert scores.variance(len(values)) * top**2 == pytest.approx((deviations**2).sum(), rel=1e-9)


@pytest.mark.parametrize("index", [0.5, 1.5, 3.0])
def test_the_tail_index_of_paretos_law_is_found(index):
    """Within 4.5 standard errors, index / sqrt(scores of the tail): 1 in 150 000."""
    scores = counted(pareto(index, np.random.default_rng(4), (50_000,)))
    assert abs(scores.tail_index / index - 1) < 4.5 / math.sqrt(scores.tail_scores)
    assert scores.slope == pytest.approx(1 + scores.tail_index)


def test_scores_of_one_batch_in_eight_stand_for_all():
    """One in eight: number and moments are those of all, the variance's within its spread."""
    sizes = np.random.default_rng(9).random(80_000)
    edges = np.linspace(0, 1, 201)
    low, high = edges[:-1], edges[1:]
    whole = Scores(low, high, 0.5 * (low + high), np.histogram(sizes, edges)[0])
    part = Scores(low, high, 0.5 * (low + high), np.histogram(sizes[::8], edges)[0], share=1 / 8)
    assert part.number == whole.number == 80_000
    for exponent in (1, 2, 4):
        assert part.power(exponent) == pytest.approx(whole.power(exponent), rel=0.05)
    assert part.vov(100_000) == pytest.approx(whole.vov(100_000), rel=0.1)


def test_equal_scores_have_no_tail_and_nothing_larger_comes_than_can():
    """Aimed, nothing is heavier than the heaviest birth."""
    scores = counted(np.ones(1000))
    assert scores.slope == 10.0 and scores.unseen < 1e-6 and scores.carriers == pytest.approx(1000)
    scores = counted(pareto(1.2, np.random.default_rng(5), (2000,)))
    top = scores.high[np.flatnonzero(scores.counts)[-1]]
    assert scores.unseen > 0 == dataclasses.replace(scores, most=top / 2).unseen
    assert 0 < dataclasses.replace(scores, most=4 * top).unseen < scores.unseen


def test_a_history_that_scores_often_counts_once():
    """Ten equal scores of each of 100 histories are 100 carriers, within the spread of the variance: 4.5 sigma."""
    rng = np.random.default_rng(6)
    values = 10.0 * (rng.random(32_000) < 100 / 32_000)
    estimate, _ = quality_of_draws(values)
    scores = Scores(*np.ones((3, 1)), np.array([int(values.sum())]))
    found = quality_of(estimate, scores, len(values)).carriers
    assert found == pytest.approx(np.count_nonzero(values), rel=4.5 * math.sqrt(2 / 31))


# ---- batches ----


def test_batches_with_a_trend_are_found_and_others_are_not():
    """Of 2000 rows without one p is below 1e-3 in 2 on average, and in 12 once in 1e6."""
    rng = np.random.default_rng(7)
    rows = rng.normal(size=(2000, 32))
    assert sum(trend_probability(row) < 1e-3 for row in rows) <= 12
    drifting, widening = np.linspace(0, 10, 32), np.repeat([0.01, 1.0], 16)
    assert all(trend_probability(row + drifting) < 1e-6 for row in rows[:50])
    assert np.median([trend_probability(row * widening) for row in rows[:50]]) < 1e-3
    assert math.isnan(trend_probability(np.ones(32))) and math.isnan(trend_probability(rows[0, :8]))


def test_a_batch_that_stands_alone_is_found():
    rng = np.random.default_rng(8)
    rows = rng.normal(size=(1000, 32))
    assert sum(outlier_probability(row) < 1e-3 for row in rows) <= 8
    for raised in (rows[:, 3:4], rows[:, 3:6]):  # of three the largest is hardly above the next
        raised += 50
        assert max(outlier_probability(row) for row in rows) < 1e-8
    values = (np.random.default_rng(1).random((32, 100)) < 0.1).astype(float)
    values[7] = 1.0
    _, quality = quality_of_draws(values.ravel())
    assert any("one batch is far above all others" in doubt for doubt in quality.doubts)


def test_the_chance_of_a_step_between_the_halves_is_that_of_students_t():
    """Three tests are made, and the oddest counts: threefold."""
    for row in np.random.default_rng(17).normal(size=(20, 32)):
        row[16:] += 8
        pooled = (row[:16].var(ddof=1) + row[16:].var(ddof=1)) / 2
        t = (row[16:].mean() - row[:16].mean()) / math.sqrt(pooled / 8)
        assert trend_probability(row) == pytest.approx(3 * 2 * stdtr(30, -t), rel=1e-9, abs=0)


def test_the_chance_of_a_batch_that_stands_alone_is_that_of_the_largest_of_all():
    """Student's t of one batch against the mean of the 31 others, for 32 that it may be, in 5 tests."""
    for row in np.random.default_rng(18).normal(size=(20, 32)):
        row[7] = 12
        others = np.delete(row, 7)
        t = (row[7] - others.mean()) / (others.std(ddof=1) * math.sqrt(1 + 1 / 31))
        assert outlier_probability(row) == pytest.approx(5 * 32 * stdtr(30, -t), rel=1e-9, abs=0)


# ---- whether it flags what it must, and nothing else ----


@pytest.mark.slow
def test_a_heavy_tail_is_flagged_where_the_answer_is_off_and_a_light_one_hardly_ever():
    """Of 3200 scores: of the runs beyond three errors at least 95 % are flagged, of those of light tails at most 2 %."""
    rng = np.random.default_rng(9)
    for index, rate in ((1.2, 0.3), (1.5, 0.03)):
        found = [quality_of_draws(pareto(index, rng, (3200,))) for _ in range(2 * SEEDS)]
        off = [quality for estimate, quality in found if abs(estimate.z(index / (index - 1))) > 3]
        assert len(off) > rate * len(found)
        assert sum(not quality.is_sound for quality in off) >= 0.95 * len(off)
    for draw in (rng.exponential, rng.random, lambda size: (rng.random(size) < 0.1) * 1.0):
        flagged = sum(not quality_of_draws(draw(size=3200))[1].is_sound for _ in range(SEEDS))
        assert flagged <= 0.02 * SEEDS


@pytest.mark.slow
def test_the_trap_of_an_aim_is_flagged_before_the_mean_is_right_and_a_sound_aim_is_not():
    """Births near the target are missed: far too little, with an error far too small.  Every such run says so."""
    truth, off, flagged, lowest = exact(0.01, 0.001), 0, 0, 1.0
    for seed in range(SEEDS):
        result = run(aimed(), 3000, seed)
        found = result["meter"].irradiance
        if abs(found.z(truth)) > 3:
            off, lowest = off + 1, min(lowest, found.value / truth)
            flagged += not result.quality("meter.irradiance").is_sound
    assert off > 0.2 * SEEDS and lowest < 0.25
    assert flagged >= 0.95 * off
    sound = [run(aimed(0.1, 0.01), 10_000, seed).quality("meter.flux_in").is_sound for seed in range(100)]
    assert sound.count(False) <= 2


def test_quasi_random_points_leave_nothing_to_come():
    """Their error is far below single scores: no law of these tells it."""
    meter = tp.Disk(center=(0.4, 0.3, 0.9), normal=(-0.3, 0.2, -1), radius=0.15)
    lamp = tp.Source(tp.Disk(radius=0.7), tp.Lambertian(radiance=1.0))
    scene = tp.Scene([lamp], (), [tp.Detector(meter, "meter")])
    assert run(scene, 1 << 14, estimator="expected", sampling="sobol").warnings == []


# ---- what a user sees ----


def test_a_result_reports_its_doubts_in_words():
    result = run(aimed(), 3000)
    (warning,) = [text for text in result.warnings if "flux_in of detector 'meter' is doubtful" in text]
    assert "scores" in warning and "Use more particles" in warning and warning in result.report()
    quality = result.quality("meter.flux_in")
    assert quality.doubts and quality.doubts[0] in warning and quality.doubts[0] in str(quality)
    bins = run(aimed(directions=tp.Directions(mu=4)), 1000).quality("meter.radiance")
    assert bins.verdict == "doubtful" and "bins" in str(bins) and bins.relative_error.shape == (4,)


def test_a_sound_result_reports_no_finding():
    result = run(aimed(1.0, 0.5), 20_000)
    quality = result.quality("meter.irradiance")
    assert quality.is_sound and "sound" in str(quality) and result.warnings == []
    assert "error bars: no finding against them" in result.report()
    merit = 1 / (result["meter"].irradiance.relative_error ** 2 * result.cost.seconds)
    assert quality.figure_of_merit == pytest.approx(merit)
    assert quality.vov < 0.1 and quality.tail_slope > 3 and quality.carriers > FEW


def test_too_few_scores_are_reported_with_the_particles_that_suffice():
    meter = tp.Disk(center=(0, 0, 50.0), radius=1.0, normal=(0, 0, -1))
    result = run(tp.Scene(LAMP, (), tp.Detector(meter, "meter")), 5000)
    scores = round(result["meter"].counts.value)
    assert 0 < scores < FEW
    assert f"only {scores} score" in result.warnings[0]
    needed = 5000 * FEW / scores
    (found,) = re.findall("Use about (.*) particles", result.warnings[0])
    assert needed <= float(found) <= 2 * needed


def test_a_run_without_a_score_is_not_sound_and_warns():
    """Of a detector and a volume that were missed by chance: at most 3.0 histories, Poisson's 95 % limit of none."""
    lamp = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(power=1.0))
    speck = tp.Detector(tp.Disk(center=(5, 0, 2), normal=(0, 0, -1), radius=1e-5), "speck")
    volume = tp.VolumeDetector(tp.Box(center=(5, 0, 2), size=1e-4), "volume")
    result = run(tp.Scene(lamp, (), [speck, volume]), 1000)
    for name in ("speck.flux_in", "volume.fluence_rate"):
        quality, found = result.quality(name), result.quantity(name)
        assert not quality.is_sound and quality.doubts == ("light not sampled",)
        assert "sound" not in str(quality)
        assert str(found).endswith(f"(no score: at most {found.interval()[1]:.2g} {found.unit})")
    assert result["speck"].flux_in.interval() == pytest.approx((0.0, -math.log(0.05) / 1000))
    (warning,) = result.warnings
    words = "detector 'speck' and volume detector 'volume' have no score in 1000 particles: unknown, not 0."
    assert warning.startswith(words)
    assert "or move the detector: it may lie outside of the room or within a solid" in warning


def test_equal_batches_are_bounded_and_an_exact_number_is_sound():
    beam = tp.Source(tp.Disk(radius=1.0), tp.Beam((0, 0, 1), power=1.0))
    target = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=2.0), "target")
    result = run(tp.Scene(beam, (), [target, tp.Detector(tp.Disk(radius=1.0), "lamp")]), 1000)
    found = result["target"].flux_in
    assert found.reason == "every batch gave the same" and str(found) == "1 W (every batch gave the same)"
    assert result.quality("target.flux_in").verdict == "bounded" and result.warnings == []
    assert found.interval() == pytest.approx((1 - 0.003, 1 + 0.003), abs=1e-5)
    quality = result.quality("lamp.flux_out")
    assert quality.is_sound and result["lamp"].flux_out.exact and quality.relative_error == 0


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_an_error_that_is_not_finite_is_not_sound(value):
    estimate = Estimate(np.full(32, value), Batches(np.full(32, 10)), "1")
    assert not quality_of(estimate).is_sound
