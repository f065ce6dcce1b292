"""Means, errors, pseudo-values and scores over batches, with the hard cases."""

import math

import mpmath
import numpy as np
import pytest

from transport.statistics.batches import (
    merge,
    normal_score,
    pseudo_shifts,
    standard_error,
    student_quantile,
    weighted_mean,
    welch_dof,
)

SIZES = np.array([4, 4, 3, 3, 3])


def test_mean_and_error_of_equal_batches_are_the_textbook_ones():
    values = np.random.default_rng(1).normal(size=(32, 3))
    sizes = np.full(32, 10)
    np.testing.assert_allclose(weighted_mean(values, sizes), values.mean(axis=0), rtol=1e-13)
    np.testing.assert_allclose(
        standard_error(values, sizes), values.std(axis=0, ddof=1) / 32**0.5, rtol=1e-13
    )


def test_error_of_unlike_batches_is_free_of_bias():
    """The mean of error^2 is sigma^2 / N, within 5 of its errors; equal weights for all batches miss it."""
    sizes = np.array([1, 1, 1, 9])
    values = np.random.default_rng(2).normal(size=(4, 40_000)) / np.sqrt(sizes)[:, None]
    squares = standard_error(values, sizes) ** 2 * sizes.sum()
    assert abs(squares.mean() - 1) < 5 * squares.std() / 200
    wrong = standard_error(values, np.ones(4)) ** 2 * sizes.sum()
    assert abs(wrong.mean() - 1) > 5 * wrong.std() / 200


def test_a_mean_of_a_billion_does_not_swallow_a_variance_of_one():
    noise = np.random.default_rng(3).integers(-4, 5, size=64) / 4  # exact beside 1e9
    sizes = np.arange(64) % 2 + 10
    far, near = standard_error(1e9 + noise, sizes), standard_error(noise, sizes)
    assert far == pytest.approx(near, rel=1e-6)
    one_pass = ((1e9 + noise) ** 2).mean() - (1e9 + noise).mean() ** 2
    assert (
        abs(one_pass / noise.var() - 1) > 0.1
    )  # the sum of squares less the square of the sum: the wrong way


@pytest.mark.parametrize("scale", [1e-200, 1.0, 1e200])
def test_errors_scale_with_the_unit(scale):
    values = np.array([1.0, 2.0, 4.0, 3.0, 5.0])
    assert standard_error(scale * values, SIZES) == pytest.approx(
        scale * standard_error(values, SIZES), rel=1e-13
    )


def test_equal_batches_give_their_very_value_and_no_spread():
    values = np.full(5, 0.1)
    assert weighted_mean(values, SIZES) == 0.1
    assert standard_error(values, SIZES) == 0
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


def test_pseudo_values_of_a_mean_are_the_batches_themselves():
    values = np.array([1.0, 2.0, 4.0, 3.0, 5.0])
    np.testing.assert_allclose(pseudo_values(lambda x: x, [values], SIZES), values, rtol=1e-13)


def test_jackknife_takes_the_bias_off_a_square_exactly():
    """E[mean^2] = mu^2 + error^2; equal batches' pseudo-values have the mean mean^2 - error^2."""
    values, sizes = np.array([1.0, 2.0, 4.0, 3.0]), np.full(4, 7)
    pseudo = pseudo_values(np.square, [values], sizes)
    expected = values.mean() ** 2 - standard_error(values, sizes) ** 2
    assert weighted_mean(pseudo, sizes) == pytest.approx(expected, rel=1e-13)


def test_pseudo_values_of_a_constant_have_no_spread_by_rounding():
    values = np.random.default_rng(5).normal(1.0, 0.1, size=5)
    pseudo = pseudo_values(lambda a, b: 3 * a / b, [values, values], SIZES)
    assert (pseudo == pseudo[0]).all()


def test_student_quantile_agrees_with_tables():
    assert student_quantile(0.975, 31) == pytest.approx(
        2.0395134, rel=1e-7
    )  # Abramowitz & Stegun, table 26.10
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
