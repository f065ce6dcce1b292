"""The classic trap: rare large scores are missed, an answer is four times too low and claims 2 %.  Warnings must say so."""

import math
from functools import reduce

import numpy as np
import pytest

import transport as tp
from transport.statistics.batches import outlier_probability
from transport.statistics.quality import Scores

SEEDS = 8  # of 200 each run that fell into a trap was told of: 193 of the mask's, 152 of the hidden lamp's


def run(scene: tp.Scene, particles: int, seed: int, **options):
    return tp.simulate(scene, particles=particles, seed=seed, threads=1, progress=False, **options)


def doubts(result) -> list[str]:
    """The warnings that speak against an error."""
    return [told for told in result.warnings if "doubtful" in told]


def masked(height: float = 0.05, ring: float = 0.8, spot: float = 3.24e-3) -> tuple[tp.Scene, float]:
    """A wide lamp, seen through a mask: a narrow ring far out, and a pinhole right below the meter.

    With its irradiance [W m^-2], of the meter as a point; three quarters are the pinhole's, where few are born.
    """
    meter = tp.Disk(center=(0, 0, height), radius=3e-4, normal=(0, 0, -1))
    stop = tp.Disk(center=(0, 0, height / 2), radius=ring / 2, inner_radius=spot / 2)
    lamp = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(radiance=1.0), aim=meter)

    def within(radius: float) -> float:
        return math.pi * radius**2 / (radius**2 + height**2)

    truth = within(1.0) - within(ring) + within(spot)
    return tp.Scene([lamp], [tp.Surface(stop, tp.Black())], [tp.Detector(meter, "meter")]), truth


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


@pytest.mark.parametrize(
    ("trap", "particles", "estimator"), [(masked, 4400, "analog"), (hidden, 5000, "backward")]
)
def test_four_times_too_low_with_two_percent_claimed_is_told(trap, particles, estimator):
    """Most runs fall into the trap, and each of them says so, before the mean is right."""
    (scene, truth), fallen = trap(), 0
    for seed in range(SEEDS):
        result = run(scene, particles, seed, estimator=estimator)
        found = result["meter"].irradiance
        if found.value < 0.3 * truth and found.relative_error < 0.03:
            fallen += 1
            assert doubts(result)
    assert fallen >= SEEDS // 2


@pytest.mark.slow
def test_traps_give_the_right_mean_with_more_particles():
    """With more particles the means are right, within their errors: 4.5 sigma, and 2 % of what is left out above."""
    for (scene, truth), particles, estimator in (
        (masked(spot=0.05), 400_000, "analog"),
        (hidden(2e-3), 100_000, "backward"),
    ):
        result = run(scene, particles, 1, estimator=estimator)
        found = result["meter"].irradiance
        assert abs(found.value - truth) < 4.5 * found.error + 0.02 * truth
        assert not doubts(result)


def test_an_aim_seen_edge_on_has_no_heavy_births_and_is_not_doubted():
    """Its largest weight is a bound that none comes up to; what counts is the heaviest that was born."""
    meter = tp.Disk(center=(1.5, 0, 0.1), normal=(0, 0, -1), radius=0.1)
    lamp = tp.Source(tp.Disk(radius=0.3), tp.Lambertian(radiance=1.0), aim=meter)
    result = run(tp.Scene([lamp], (), [tp.Detector(meter, "meter")]), 5000, 1)
    heaviest = max(batch.heaviest for batch in result.batches)
    assert 0 < heaviest < 0.25 and sum(batch.born for batch in result.batches) < 100
    assert result.warnings == []


def test_the_heaviest_birth_is_the_same_however_it_is_run():
    scene = masked()[0]
    one, two = (tp.simulate(scene, particles=20_000, threads=n, progress=False) for n in (1, 2))
    assert [batch.heaviest for batch in one.batches] == [batch.heaviest for batch in two.batches]
    heaviest = max(batch.heaviest for batch in one.batches)
    assert 0.5 < heaviest <= 1.0
    whole = reduce(lambda batch, other: batch.merged(other, 0), one.batches)
    assert whole.heaviest == heaviest


def test_batches_that_stand_alone_together_do_not_hide_one_another():
    """The largest of three is hardly above the rest: it is they that are above all others."""
    rows = np.random.default_rng(8).normal(size=(300, 32))
    rows[:, 3:6] += 50
    assert max(outlier_probability(row) for row in rows) < 1e-8


def test_a_share_that_was_counted_tells_of_all():
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


def test_histories_that_run_backwards_are_counted_by_size():
    """Of one cell: as many as met a source, and what they brought lies between the cells' edges."""
    scene, _ = hidden(0.01)
    result = run(scene, 20_000, 1, estimator="backward")
    scores = result["meter"].diagnosis.score_sizes("weight in")
    brought = result["meter"].irradiance.value / math.pi * result.particles
    assert scores.number == round(result["meter"].counts.value) == scores.counts.sum()
    least, most = (scores.counts @ edges for edges in (scores.low, scores.high))
    assert least < brought < most < 1.26 * least  # a quarter of an octave
    bins = tp.Detector(scene.detectors[0].shape, "meter", directions=tp.Directions(mu=2))
    result = run(tp.Scene(scene.sources, scene.surfaces, [bins]), 20_000, 1, estimator="backward")
    assert len(result["meter"].diagnosis.score_sizes("weight in").counts) == 1


def test_quasi_random_points_leave_nothing_to_come():
    """Their error is far below single scores: no law of these tells it."""
    meter = tp.Disk(center=(0.4, 0.3, 0.9), normal=(-0.3, 0.2, -1), radius=0.15)
    lamp = tp.Source(tp.Disk(radius=0.7), tp.Lambertian(radiance=1.0))
    scene = tp.Scene([lamp], (), [tp.Detector(meter, "meter")])
    assert run(scene, 1 << 14, 1, estimator="expected", sampling="sobol").warnings == []


def test_few_ways_through_a_volume_are_told():
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    ball = tp.VolumeDetector(tp.Sphere(center=(0, 0, 1), radius=0.02), name="ball")
    result = run(tp.Scene([lamp], (), [ball]), 20_000, 1)
    assert 0 < result["ball"].counts.value < 5
    assert "score" in result.warnings[0] and "'ball'" in result.warnings[0]
    assert not result.quality("ball.fluence_rate").is_sound
