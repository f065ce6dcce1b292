"""The judge is judged: right data pass at the stated rate, planted wrong data fail."""

import math

import numpy as np
import pytest

from tests.agreement import assert_agrees, assert_follows, assert_z_spread, smallest_bias
from tests.synthetic import EVEN_RUN, RUN, grid, noisy, t_scores, with_error
from transport.statistics.batches import normal_score
from transport.statistics.estimates import Estimate, EstimateArray


def test_agreement_is_judged_by_the_estimates_own_error():
    estimate = noisy(5, 1, 1)
    assert_agrees(estimate, 5.0)
    with pytest.raises(AssertionError, match=r"value 4\.98.*exact 5\.7.*z = -.*limit 4\.42"):
        assert_agrees(estimate, 5.0 + 8 * estimate.error)
    with pytest.raises(AssertionError, match="no score"):
        assert_agrees(Estimate(np.zeros(32), RUN, "W"), 0.0)
    L = grid(1)
    assert_agrees(L, 5.0)
    wrong = np.full((4, 3), 5.0)
    wrong[2, 1] = 8.0
    with pytest.raises(AssertionError, match=r"in bin \(2, 1\)"):
        assert_agrees(L, wrong)


def test_the_smallest_bias_is_caught_with_its_power():
    """2000 estimates off by the bias that 95 % should catch: between 92.5 and 97.5 % are (5 sigma)."""
    runs, many = 2000, {"seed": np.arange(2001.0)}
    values = np.random.default_rng(14).normal(1.0, 0.1, size=(32, runs))
    estimates = EstimateArray(values, EVEN_RUN, "W", ("seed",), many)
    bias = smallest_bias(with_error(1.0, 0.1 / math.sqrt(32), batches=32), false_alarm=1e-3)
    caught = np.abs(estimates.z(1.0 - bias)) > 3.2905
    assert 0.925 < caught.mean() < 0.975


@pytest.mark.parametrize("batches", [2, 5, 32])
def test_right_z_scores_pass(batches):
    assert_z_spread(t_scores(6, batches), batches - 1)
    assert_z_spread(normal_score(t_scores(6, batches), batches - 1), math.inf)


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_an_error_bar_wrong_by_a_tenth_fails(factor):
    with pytest.raises(AssertionError, match="spread"):
        assert_z_spread(t_scores(7, factor=1 / factor), 31)


def test_a_bias_of_a_fifth_of_an_error_bar_and_wrong_freedom_fail():
    with pytest.raises(AssertionError, match="mean"):
        assert_z_spread(t_scores(8, offset=0.2), 31)
    with pytest.raises(AssertionError, match="spread"):
        assert_z_spread(t_scores(8, batches=5), math.inf)
    with pytest.raises(AssertionError, match="not finite"):
        assert_z_spread(np.array([0.0, np.nan]), 31)


def test_false_alarms_of_the_z_judge_are_as_stated():
    """400 right samples at a rate of 0.1: 40 expected; more than 70 in 1e-6, fewer than 14 in 1e-6."""
    alarms = 0
    for seed in range(400):
        try:
            assert_z_spread(t_scores((9, seed), 8, seeds=300), 7, false_alarm=0.1)
        except AssertionError:
            alarms += 1
    assert 10 < alarms < 70


def test_counts_that_follow_pass_and_others_fail():
    rng = np.random.default_rng(10)
    probabilities = 0.5 ** np.arange(1, 21)
    probabilities[-1] *= 2
    counts = rng.multinomial(100_000, probabilities)
    assert_follows(counts, probabilities)
    with pytest.raises(AssertionError, match="chi-square"):
        assert_follows(counts[::-1], probabilities)
    with pytest.raises(AssertionError, match="chi-square"):
        assert_follows(rng.multinomial(100_000, [0.51, 0.49]), [0.5, 0.5])
    with pytest.raises(AssertionError, match="probability 0"):
        assert_follows([50, 50, 1], [0.5, 0.5, 0.0])
    with pytest.raises(ValueError, match="add up"):
        assert_follows([50, 50], [0.5, 0.4])
    with pytest.raises(ValueError, match="too few"):
        assert_follows([5, 5], [0.5, 0.5])
