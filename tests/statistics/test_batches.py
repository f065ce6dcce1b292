"""Means, errors, pseudo-values and scores over batches, with the hard cases; and the judge of agreement is judged."""

import math

import mpmath
import numpy as np
import pytest

from tests.agreement import assert_agrees, assert_follows, assert_z_spread, smallest_bias
from tests.synthetic import EVEN_RUN, RUN, grid, noisy, t_scores, with_error
from transport.statistics.batches import (
    merge,
    normal_score,
    pseudo_shifts,
    standard_error,
    student_quantile,
    weighted_mean,
    welch_dof,
)
from transport.statistics.estimates import Estimate, EstimateArray

VALUES, SIZES = np.array([1.0, 2.0, 4.0, 3.0, 5.0]), np.array([4, 4, 3, 3, 3])


def test_mean_and_error_of_equal_batches_are_the_textbook_ones():
    values, sizes = np.random.default_rng(1).normal(size=(32, 3)), np.full(32, 10)
    np.testing.assert_allclose(weighted_mean(values, sizes), values.mean(axis=0), rtol=1e-13)
    textbook = values.std(axis=0, ddof=1) / 32**0.5
    np.testing.assert_allclose(standard_error(values, sizes), textbook, rtol=1e-13)


def test_error_of_unlike_batches_is_free_of_bias():
    """The mean of error^2 is sigma^2 / N, within 5 of its errors; equal weights for all batches miss it."""
    sizes = np.array([1, 1, 1, 9])
    values = np.random.default_rng(2).normal(size=(4, 40_000)) / np.sqrt(sizes)[:, None]
    squares = standard_error(values, sizes) ** 2 * sizes.sum()
    assert abs(squares.mean() - 1) < 5 * squares.std() / 200
    wrong = standard_error(values, np.ones(4)) ** 2 * sizes.sum()
    assert abs(wrong.mean() - 1) > 5 * wrong.std() / 200


def test_a_mean_of_a_billion_does_not_swallow_a_variance_of_one():
    """As the sum of the squares less the square of the sum would."""
    noise = np.random.default_rng(3).integers(-4, 5, size=64) / 4  # exact beside 1e9
    sizes = np.arange(64) % 2 + 10
    far, near = standard_error(1e9 + noise, sizes), standard_error(noise, sizes)
    assert far == pytest.approx(near, rel=1e-6)
    one_pass = ((1e9 + noise) ** 2).mean() - (1e9 + noise).mean() ** 2
    assert abs(one_pass / noise.var() - 1) > 0.1


def test_errors_scale_with_the_unit_and_equal_batches_have_none():
    for scale in (1e-200, 1.0, 1e200):
        expected = scale * standard_error(VALUES, SIZES)
        assert standard_error(scale * VALUES, SIZES) == pytest.approx(expected, rel=1e-13)
    values = np.full(5, 0.1)
    assert weighted_mean(values, SIZES) == 0.1 and standard_error(values, SIZES) == 0
    assert np.isnan(standard_error(values[:1], SIZES[:1]))


def test_merged_parts_are_the_whole_also_beside_a_large_mean():
    values = 1e9 + np.random.default_rng(4).integers(-8, 9, size=1000) / 8

    def partial(part):
        return len(part), part.mean(), ((part - part.mean()) ** 2).sum()

    together = (0, 0.0, 0.0)
    for part in np.split(values, [1, 10, 300, 301]):
        together = merge(together, partial(part))
    count, mean, squares = partial(values)
    assert together[0] == count
    assert together[1] == pytest.approx(mean, rel=1e-15)
    assert together[2] == pytest.approx(squares, rel=1e-6)
    assert merge((0, 0.0, 0.0), (0, 0.0, 0.0)) == (0, 0.0, 0.0)


def pseudo_values(function, values, sizes):
    """Delete-one jackknife pseudo-values of a function of several batch means."""
    means = [weighted_mean(each, sizes) for each in values]
    deviations = [each - mean for each, mean in zip(values, means, strict=True)]
    return function(*means) + pseudo_shifts(function, means, deviations, sizes)


def test_jackknife_takes_the_bias_off_a_square_exactly():
    """E[mean^2] = mu^2 + error^2; equal batches' pseudo-values have the mean mean^2 - error^2.  Of a mean they are the batches."""
    np.testing.assert_allclose(pseudo_values(lambda x: x, [VALUES], SIZES), VALUES, rtol=1e-13)
    values, sizes = np.array([1.0, 2.0, 4.0, 3.0]), np.full(4, 7)
    pseudo = pseudo_values(np.square, [values], sizes)
    expected = values.mean() ** 2 - standard_error(values, sizes) ** 2
    assert weighted_mean(pseudo, sizes) == pytest.approx(expected, rel=1e-13)
    values = np.random.default_rng(5).normal(1.0, 0.1, size=5)
    pseudo = pseudo_values(lambda a, b: 3 * a / b, [values, values], SIZES)
    assert (pseudo == pseudo[0]).all()  # a constant has no spread by rounding


def test_student_quantile_agrees_with_tables():
    """Abramowitz & Stegun, table 26.10."""
    assert student_quantile(0.975, 31) == pytest.approx(2.0395134, rel=1e-7)
    assert student_quantile(0.975, 1) == pytest.approx(12.7062047, rel=1e-8)


@pytest.mark.parametrize("dof", [1, 3, 31, 200, 1000, 100_000])
@pytest.mark.parametrize("t", [0.5, 3.0, 30.0, 40.0, 1e4])
def test_normal_score_has_the_tail_of_t(t, dof):
    """Against mpmath at 60 digits, far beyond where the tail's probability underflows."""
    z = float(normal_score(t, dof))
    with mpmath.workdps(60):
        x = mpmath.mpf(dof) / (dof + mpmath.mpf(t) ** 2)
        tail = mpmath.betainc(mpmath.mpf(dof) / 2, mpmath.mpf(1) / 2, 0, x, regularized=True) / 2
        # d log(tail) / dz is about -z: an error of 1e-11 z in z.
        difference = mpmath.log(mpmath.erfc(z / mpmath.sqrt(2)) / 2) - mpmath.log(tail)
        assert abs(difference) < 1e-11 * (1 + z * z)


def test_normal_score_is_odd_finite_and_monotonic():
    t = np.concatenate([np.linspace(0, 60, 601), np.logspace(2, 30, 57)])
    for dof in (2, 31, 500, 1e6):
        z = normal_score(t, dof)
        assert np.isfinite(z).all()
        assert (np.diff(z) > 0).all()
        np.testing.assert_array_equal(normal_score(-t, dof), -z)
    assert normal_score(40.0, math.inf) == 40.0
    assert np.isnan(normal_score(np.nan, 31))


def test_effective_freedom_lies_between_the_parts_and_their_sum():
    assert welch_dof([np.float64(1), np.float64(1)], [31, 31]) == pytest.approx(62)
    assert welch_dof([np.float64(1e-9), np.float64(1)], [31, 15]) == pytest.approx(15)


# ---- the judge: right data pass at the stated rate, planted wrong data fail ----


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


@pytest.mark.parametrize(
    ("scores", "dof", "words"),
    [
        (t_scores(7, factor=1 / 0.9), 31, "spread"),  # error bars wrong by a tenth
        (t_scores(7, factor=1 / 1.1), 31, "spread"),
        (t_scores(8, offset=0.2), 31, "mean"),  # a bias of a fifth of an error bar
        (t_scores(8, batches=5), math.inf, "spread"),
        (np.array([0.0, np.nan]), 31, "not finite"),
    ],
)
def test_wrong_z_scores_fail(scores, dof, words):
    with pytest.raises(AssertionError, match=words):
        assert_z_spread(scores, dof)


def test_false_alarms_of_the_z_judge_are_as_stated():
    """400 right samples at a rate of 0.1: 40 expected; more than 70 in 1e-6, fewer than 14 in 1e-6."""
    alarms = 0
    for seed in range(400):
        try:
            assert_z_spread(t_scores((9, seed), 8, seeds=300), 7, false_alarm=0.1)
        except AssertionError:
            alarms += 1
    assert 10 < alarms < 70


def test_counts_that_follow_the_law_pass_and_others_fail():
    rng, probabilities = np.random.default_rng(10), 0.5 ** np.arange(1, 21)
    probabilities[-1] *= 2
    counts = rng.multinomial(100_000, probabilities)
    assert_follows(counts, probabilities)
    for counted, law, words in (
        (counts[::-1], probabilities, "chi-square"),
        (rng.multinomial(100_000, [0.51, 0.49]), [0.5, 0.5], "chi-square"),
        ([50, 50, 1], [0.5, 0.5, 0.0], "probability 0"),
        ([50, 50], [0.5, 0.4], "add up"),
        ([5, 5], [0.5, 0.5], "too few"),
    ):
        with pytest.raises((AssertionError, ValueError), match=words):
            assert_follows(counted, law)
