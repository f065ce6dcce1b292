"""What accuracy costs: runs with known errors at a known pace give back slopes, prices and biases; then real runs."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

import transport as tp
from transport.analysis.cost import cost_of_accuracy, methods_of_scene
from transport.analysis.work_precision import (
    MAX_REPEATS,
    MIN_REPEATS,
    Trial,
    Trials,
    best_estimate,
    cost_of_method,
    run_trials,
)
from transport.statistics.convergence import fit_power_law, fit_time
from transport.statistics.notation import duration, percent
from transport.theory.emitters import mean_disk_irradiance

TRUTH, LATENCY, PACE = 2.0, 1e-3, 1e-8  # s, s a particle
METER = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.3)
LAMP = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(radiance=100.0))
SCENE = tp.Scene([LAMP], detectors=[tp.Detector(METER, "meter")])


def stand_in_trials(error=0.5, slope=-0.5, bias=0.0, honesty=1.0, seed=0, seconds=4.0, noise=0.0):
    """Runs with a relative error of `error` × particles^slope on a machine of known pace.  honesty: claimed over true."""
    draws, now = np.random.default_rng(seed), [0.0]

    def run(particles, key):
        now[0] += (LATENCY + PACE * particles) * math.exp(noise * draws.normal())
        sigma = TRUTH * error * particles**slope
        value = TRUTH * (1 + bias) + sigma * draws.normal()
        return particles, SimpleNamespace(value=value, error=honesty * sigma), 0.25

    return run_trials(run, seconds, cpu=lambda: now[0], clock=lambda: now[0])


EXACT = best_estimate({}, np.array([TRUTH]))


@pytest.mark.parametrize("slope", [-0.5, -1.0])
def test_slopes_and_prices_come_back(slope):
    """The slope within four of its standard errors, of 0.02, and the price within 30 %; the other slope would be 25 off."""
    way = cost_of_method("way", stand_in_trials(0.5, slope, noise=0.05), EXACT)
    assert way.line.slope_error < 0.03
    assert abs(way.line.slope - slope) < 4 * way.line.slope_error
    assert (way.line.used == -0.5) == (slope == -0.5)
    assert way.pace.per_particle == pytest.approx(PACE, rel=0.1)
    assert way.pace.latency == pytest.approx(LATENCY, rel=0.1)
    for target in (1e-2, 1e-3, 1e-7):
        price = way.price(target)
        expected = PACE * (target / 0.5) ** (1 / slope)
        assert abs(price.seconds - LATENCY - expected) < 0.3 * expected + 0.1 * LATENCY
        assert price.is_extrapolated == (target < min(point.true for point in way.points))


def test_sizes_grow_by_fours_small_ones_are_repeated_and_the_time_is_kept():
    trials = stand_in_trials(seconds=4.0)
    sizes = [rung[0].particles for rung in trials.levels]
    assert np.all(np.diff(np.log2(sizes)) == 2)
    assert len(trials.levels[-1]) == MIN_REPEATS and len(trials.levels[0]) == MAX_REPEATS
    assert 1.0 < sum(trial.seconds for trial in trials.all) < 4.0
    assert trials.preparation == 0.25


def test_true_and_claimed_errors_differ_where_a_method_claims_too_little():
    honest, vain = (cost_of_method("way", stand_in_trials(honesty=h), EXACT) for h in (1.0, 0.5))
    for way, ratio in ((honest, 1.0), (vain, 2.0)):
        found = math.exp(np.mean([math.log(p.true / p.claimed) for p in way.points]))
        assert found == pytest.approx(ratio, rel=0.15)


def test_a_biased_method_is_seen_by_its_z_and_by_a_line_that_stops_to_fall():
    right, biased, wrong = (
        cost_of_method("way", stand_in_trials(seed=3, bias=bias), EXACT) for bias in (0.0, 1e-3, 0.02)
    )
    assert abs(right.z) < 4 and abs(biased.z) > 8
    assert wrong.points[-1].true == pytest.approx(0.02, rel=0.1)


@pytest.mark.slow
def test_without_an_exact_value_errors_are_measured_from_the_best_estimate_and_are_not_too_small():
    """Mean squares over many repetitions within 4 standard errors of the true ones, though the runs make up the truth.

    Not to put back what a run shares with the best estimate would be an eighth off where all runs have one size, five standard errors.
    """
    squares, plain, repeats = [], [], 500
    for seed in range(repeats):
        trials = stand_in_trials(seed=seed, seconds=0.01)
        truth = best_estimate({"way": trials})
        last = cost_of_method("way", trials, truth).points[-1]
        sigma = 0.5 * last.particles**-0.5
        squares.append((np.nan_to_num(last.true) / sigma) ** 2)
        plain.append(np.mean([(t.value[0] / truth.value[0] - 1) ** 2 for t in trials.levels[-1]]) / sigma**2)
    spread = math.sqrt(2 / MIN_REPEATS / repeats)
    assert abs(np.mean(squares) - 1) < 4 * spread
    assert abs(np.mean(plain) - 1) > 4 * spread
    assert truth.words.startswith("best estimate")


def test_the_best_estimate_weighs_methods_by_their_errors():
    fine, coarse = stand_in_trials(0.01, seed=1), stand_in_trials(1.0, seed=2)
    truth = best_estimate({"fine": fine, "coarse": coarse})
    assert truth.shares["fine"] > 0.99
    assert abs(truth.value[0] / TRUTH - 1) < 4 * math.sqrt(truth.variance) / TRUTH
    assert abs(cost_of_method("coarse", coarse, truth).z) < 4


def test_a_method_without_a_known_error_or_a_score_does_not_spoil_the_truth():
    """As of a flux of which every batch gave the same: no method has a variance, so that the plain mean is taken."""

    def trials(value):
        return Trials(
            (tuple(Trial(n, np.full(1, value), np.full(1, np.nan), 1e-3, 1e-3) for n in (4096, 4096)),), 0.0
        )

    truth = best_estimate({"one": trials(1.0), "other": trials(1.0)})
    assert truth.shares == {"one": 0.5, "other": 0.5} and truth.value[0] == 1.0
    truth = best_estimate({"blind": trials(0.0), "sees": stand_in_trials()})
    assert "blind" not in truth.shares
    way = cost_of_method("blind", trials(0.0), truth)
    assert way.line is None and way.price(0.1).seconds == math.inf
    assert way.points[0].true == pytest.approx(1.0, rel=1e-6) and math.isnan(way.points[0].claimed)


def test_lines_need_two_points_and_paces_are_positive():
    assert fit_power_law([1.0], [0.1], [8]) is None
    assert fit_power_law([1.0, 2.0], [0.1, math.nan], [8, 8]) is None
    assert fit_time([1e3, 1e4], [1.0, 0.9]).per_particle > 0  # a machine that was disturbed


@pytest.fixture(scope="module")
def cost():
    exact, methods = METER.area * mean_disk_irradiance(100.0, 1.0, 0.3, 1.0), ("analog", "aimed")
    return cost_of_accuracy(SCENE, "meter.flux_in", exact=exact, methods=methods, seconds=3.0, seed=1)


@pytest.mark.slow
def test_random_sampling_has_a_slope_of_minus_a_half_and_honest_errors(cost):
    """And to a small detector aimed is the cheapest method."""
    for way in cost.ways:
        assert abs(way.line.slope + 0.5) < 4 * way.line.slope_error < 0.4
        assert abs(way.z) < 4
        ratios = [p.claimed / p.true for p in way.points if p.runs > MIN_REPEATS]
        assert 0.7 < math.exp(np.mean(np.log(ratios))) < 1.4
    assert cost.cheapest.name == "aimed"
    assert cost["aimed"].price(1e-4).seconds < 0.3 * cost["analog"].price(1e-4).seconds


@pytest.mark.slow
def test_a_cost_is_a_table_and_data(cost):
    text = str(cost)
    assert all(word in text for word in ("method", "1 %", "0.1 %", "0.01 %", "aimed", "exact", cost.machine))
    data = json.loads(cost.to_json())
    assert data["threads"] == 1 and data["machine"] == cost.machine
    (analog, _) = data["ways"]
    assert [price["error"] for price in analog["prices"]] == [1e-2, 1e-3, 1e-4]
    assert analog["points"][-1]["seconds"] > 0


def test_a_function_of_a_result_and_arrays_are_priced_too():
    bins = tp.Scene([LAMP], detectors=[tp.Detector(METER, "meter", positions=tp.Positions(u=4))])
    mine = {"mine": {"estimator": "aimed"}}
    found = cost_of_accuracy(bins, lambda result: result["meter"].irradiance, methods=mine, seconds=0.5)
    assert len(found.truth) == 4 and found["mine"].points[-1].claimed > 0
    assert found["mine"].estimator == "aimed"
    assert found.truth_is.startswith("best estimate")


def test_the_methods_of_a_scene_include_its_trackings_where_there_are_media():
    assert {"analog", "aimed"} <= set(methods_of_scene(SCENE))
    box, fog = tp.Box(center=(0, 0, 0.5), size=(4, 4, 0.5)), tp.Medium(1.0, 1.0)
    foggy = tp.Scene([LAMP], tp.Surface(box, tp.Transparent(), inside=fog), SCENE.detectors)
    found = set(methods_of_scene(foggy))
    assert "aimed" not in found and {"analog", "analog absorption", "forced collisions"} <= found


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"quantity": "metre.flux_in"}, "no detector 'metre'"),
        ({"quantity": 3}, "quantity must be a name"),
        ({"methods": ("analogue",)}, "no method 'analogue'"),
        ({"targets": (2.0,)}, "targets must be relative"),
        ({"threads": 0}, "threads must be a whole number"),
    ],
)
def test_wrong_input_of_a_cost_is_refused(wrong, words):
    with pytest.raises(tp.SceneError, match=words):
        cost_of_accuracy(**({"scene": SCENE, "quantity": "meter.flux_in", "seconds": 0.1} | wrong))


def test_durations_and_errors_are_written_in_units_that_suit():
    found = [duration(s) for s in (3e-6, 3e-3, 0.3, 30, 300, 1e4, 1e6, 1e9)]
    assert found == ["3 µs", "3 ms", "300 ms", "30 s", "5 min", "2.8 h", "12 days", "32 years"]
    found = [percent(e) for e in (0.1, 1e-2, 1e-4, 1e-6, 1e-9)]
    assert found == ["10 %", "1 %", "0.01 %", "0.0001 %", "1e-09"]
