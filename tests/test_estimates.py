"""Estimates: what they print and refuse; arithmetic keeps correlations and coverage."""

import math

import numpy as np
import pytest

from tests.agreement import assert_z_spread
from tests.synthetic import EVEN_RUN, OTHER_RUN, RUN, noisy, with_error
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.replicates import Batches
from transport.units import UnitError

# What an estimate says


@pytest.mark.parametrize(
    ("value", "error", "printed"),
    [
        (18.4391, 0.0096, "(18.439 ± 0.010) W"),
        (18.4391, 0.0101, "(18.439 ± 0.010) W"),
        (18.4391, 0.0149, "(18.439 ± 0.015) W"),
        (18.4391, 0.0294, "(18.439 ± 0.029) W"),
        (18.4391, 0.0296, "(18.44 ± 0.03) W"),
        (18.4391, 0.0996, "(18.44 ± 0.10) W"),
        (18.5, 0.4, "(18.5 ± 0.4) W"),
        (12345.0, 300.0, "(12300 ± 300) W"),
        (2.0502e7, 3e3, "(2.0502 ± 0.0003)e+07 W"),
        (3.2e-6, 1.7e-7, "(3.20 ± 0.17)e-06 W"),
        (0.01, 5.0, "(0 ± 5) W"),
        (-0.01, 5.0, "(0 ± 5) W"),
        (-999999.97, 0.6, "(-1.0000000 ± 0.0000006)e+06 W"),
    ],
)
def test_the_error_decides_how_many_digits_are_printed(value, error, printed):
    assert str(with_error(value, error)) == printed


def test_what_is_exact_or_unknown_is_said():
    exact = Estimate(np.full(32, 2 * np.pi), RUN, "W", exact=True)
    assert str(exact) == "6.283185 W (exact)"
    assert (exact.error, exact.exact, exact.reason) == (0.0, True, None)
    unknown = {
        "no score": Estimate(np.zeros(32), RUN, "W"),
        "every batch gave the same": Estimate(np.full(32, 0.1), RUN, "W"),
        "fewer than 2 batches": Estimate([3.0], Batches([5]), "W"),
        "undefined: not finite": Estimate(np.full(32, np.nan), RUN, "W"),
    }
    for reason, estimate in unknown.items():
        assert estimate.reason == reason
        assert math.isnan(estimate.error)
        assert math.isnan(estimate.z(1.0))
        assert not estimate.exact
        alike = reason == "every batch gave the same"
        assert str(estimate).endswith(f"({reason})" if alike else f"(error unknown: {reason})")
    few = Estimate(np.full(8, 0.1), Batches(np.full(8, 100)), "W")  # chance may have made them alike
    assert str(few) == "0.1 W (error unknown: every batch gave the same)"
    assert np.isnan(few.interval()).all() and few.verdict == "doubtful"
    varied = noisy(5, 1, 1)
    assert (varied + unknown["every batch gave the same"]).error == varied.error
    assert str(unknown["no score"]) == "0 W (error unknown: no score)"


@pytest.mark.parametrize(
    ("spec", "printed"),
    [
        (".3f", "(18.439 ± 0.010) W"),
        (".4g", "(18.44 ± 0.0096) W"),
        ("+.1e", "(+1.8e+01 ± 9.6e-03) W"),
        ("", "(18.439 ± 0.010) W"),
        (">22", "    (18.439 ± 0.010) W"),
        ("*^22s", "**(18.439 ± 0.010) W**"),
        ("<22.2f", "(18.44 ± 0.01) W      "),
    ],
)
def test_a_format_holds_for_value_and_error_its_width_for_the_whole(spec, printed):
    assert format(with_error(18.4391, 0.0096), spec) == printed


def test_a_format_holds_for_what_is_exact_or_unknown_too():
    assert f"{Estimate(np.full(32, 2 * np.pi), RUN, 'W', exact=True):.2f}" == "6.28 W (exact)"
    assert f"{Estimate(np.zeros(32), RUN, '1'):.2f}" == "0.00 (error unknown: no score)"
    for bad in ("d", ".3x", "three"):
        with pytest.raises(ValueError, match="write it like"):
            format(with_error(1.0, 0.1), bad)


def test_what_is_uncertain_has_no_order():
    E = noisy(5, 1, 1)
    for compare in (
        lambda: E > 3,
        lambda: 3 < E,
        lambda: E <= E,
        lambda: sorted([E, E]),
        lambda: min(E, 3.0),
        lambda: np.float64(3) < E,
    ):
        with pytest.raises(TypeError, match=r"compare E.value, or use .*z\("):
            compare()
    with pytest.raises(TypeError, match=r"E\.z\(3\)"):
        E >= 3  # noqa: B015


def test_a_size_keeps_its_deviations():
    E = noisy(-5, 1, 1)
    assert (abs(E).value, abs(E).error, str(abs(E).unit)) == (-E.value, E.error, "W")
    assert (abs(E) + E).value == 0
    assert abs(-E).value == -E.value


def test_counts_decide_whether_there_was_a_score():
    """Where all that was counted is too faint for the digits of a sum, nothing has scored."""
    assert Estimate(np.full(32, 1e-18), RUN, "W", counts=7).reason == "every batch gave the same"
    assert Estimate(np.full(32, 1e-18), RUN, "W", counts=0).reason == "no score"
    assert Estimate(np.zeros(32), RUN, "W", counts=7).reason == "no score"


def test_an_estimate_tells_value_error_interval_and_score():
    estimate = with_error(10.0, 2.0)
    assert (estimate.value, estimate.batches, str(estimate.unit)) == (10.0, 2, "W")
    assert estimate.error == pytest.approx(2.0)
    assert estimate.relative_error == pytest.approx(0.2)
    assert float(estimate) == 10.0
    low, high = estimate.interval(0.95)
    assert (high - low) / 2 == pytest.approx(2 * 12.7062047, rel=1e-8)
    assert estimate.z(low) == pytest.approx(1.959964, rel=1e-6)
    assert estimate.z(high) == -estimate.z(low)
    with pytest.raises(ValueError, match="confidence"):
        estimate.interval(95)


def test_an_exact_estimate_agrees_or_does_not():
    exact = Estimate(np.full(32, 0.1), RUN, "W", exact=True)
    assert exact.z(0.1 * (1 + 1e-13)) == 0
    assert exact.z(0.2) == -math.inf
    assert exact.interval() == (0.1, 0.1)


# Arithmetic within a run


def test_linear_steps_keep_correlations():
    a, b = noisy(5, 1, 1), noisy(3, 2, 2)
    direct = Estimate(2 * a.values - b.values, RUN, "W")
    combined = 2 * a - b
    assert combined.value == pytest.approx(direct.value, rel=1e-14)
    assert combined.error == pytest.approx(direct.error, rel=1e-12)
    assert combined.run is RUN
    assert sum([a, b, a]).value == pytest.approx(13, abs=2)


def test_a_thing_less_or_over_itself_is_exact():
    a = noisy(5, 1, 1)
    assert ((a - a).value, (a - a).error, (a - a).exact) == (0.0, 0.0, True)
    assert ((a / a).value, (a / a).error, str((a / a).unit)) == (1.0, 0.0, "1")
    twin = a + a
    assert (twin / a).value == pytest.approx(2, rel=1e-14)
    assert (twin / a).reason == "every batch gave the same"


@pytest.mark.parametrize("rho", [0.1, 0.3, 0.7])
def test_a_difference_that_cancels_to_rounding_has_no_spread(rho):
    """Also beside larger terms, in shares and over bins; a spread of a thousand roundings is one."""
    E = noisy(5, 1, 1)
    M = Estimate(E.values * rho * (1 + 1e-16) * 3 / 3, RUN, "W")
    for nothing in (M - rho * E, E - M / rho, (M - rho * E) / E, M / E - rho, (E + M) - (1 + rho) * E):
        assert nothing.reason == "every batch gave the same"
        assert math.isnan(nothing.z(0.0))
    ripple = Estimate(E.values + 1e-12 * noisy(0, 1, 2).values, RUN, "W")
    assert 0 < (ripple - E).error < 1e-12
    third, three = (Estimate(np.full(32, value), RUN, "W", exact=True) for value in (0.1, 0.3))
    assert (third * 3 - three).value != 0
    assert ((third * 3 - three).exact, (third * 3 - three).z(0)) == (True, 0.0)
    assert (third * 3 - three).z(1e-9) == -math.inf


def test_a_ratio_in_one_run_profits_from_correlation():
    """x and x + noise: the ratio's error is that of the noise; quadrature would be seventy times larger."""
    x, noise = noisy(5, 1, 1), noisy(0, 0.02, 2)
    ratio = (x + noise) / x
    assert ratio.error == pytest.approx(noise.error / x.value, rel=0.05)


def test_the_bias_of_a_ratio_of_skewed_batches_is_taken_off():
    """E[x]/E[y] = 1 with y of 8 lognormal batches: the naive ratio is off by var(y)/8."""
    run, runs = Batches(np.full(8, 10)), 40_000
    rng = np.random.default_rng(11)
    y = np.exp(rng.normal(-0.18, 0.6, size=(8, runs)))
    x = rng.exponential(size=(8, runs))
    many = {"seed": np.arange(runs + 1.0)}
    ratios = (EstimateArray(x, run, "W", ("seed",), many) / EstimateArray(y, run, "W", ("seed",), many)).value
    naive = x.mean(axis=0) / y.mean(axis=0)
    bias, naive_bias = ratios.mean() - 1, naive.mean() - 1
    assert naive_bias > 15 * naive.std() / math.sqrt(runs)
    assert abs(bias) < naive_bias / 5


def test_intervals_of_a_ratio_cover_as_stated_over_2000_runs():
    """And an error bar a tenth too small is found out."""
    runs = 2000
    rng = np.random.default_rng(12)
    y = rng.normal(10, 1, size=(32, runs))
    x = 2 * y + rng.normal(0, 1, size=(32, runs))
    many = {"seed": np.arange(runs + 1.0)}
    ratio = EstimateArray(x, EVEN_RUN, "W", ("seed",), many) / EstimateArray(
        y, EVEN_RUN, "m^2", ("seed",), many
    )
    low, high = ratio.interval(0.95)
    assert abs(np.mean((low < 2) & (2 < high)) - 0.95) < 5 * math.sqrt(0.95 * 0.05 / runs)
    assert_z_spread((ratio.value - 2) / ratio.error, 31)
    assert_z_spread(ratio.z(2.0), math.inf)
    with pytest.raises(AssertionError):
        assert_z_spread((ratio.value - 2) / (0.9 * ratio.error), 31)


def test_products_and_powers_agree_with_first_order_errors():
    a, b = noisy(500, 1, 1), noisy(300, 2, 2)
    assert (a * b).error == pytest.approx((300 * a + 500 * b).error, rel=1e-2)
    assert (a**2).error == pytest.approx((2 * 500 * a).error, rel=1e-2)
    assert (a**0.5).value == pytest.approx(math.sqrt(500), rel=1e-3)
    assert (1 / a).error == pytest.approx((a * (1 / 500**2)).error, rel=1e-2)
    assert str((a * b).unit) == "W^2"
    assert str((1 / a).unit) == "W^-1"
    assert (a / b * b / a).value == pytest.approx(1, rel=1e-5)


def test_what_is_exact_stays_a_plain_factor():
    a, two = noisy(5, 1, 1), Estimate(np.full(32, 2.0), RUN, "m^2", exact=True)
    assert (a / two).error == pytest.approx(a.error / 2, rel=1e-14)
    assert (two * two).exact
    assert (two * two).batches == 32
    assert ((two - 3 * two).value, (two - 3 * two).error) == (-4.0, 0.0)
    elsewhere = Estimate(np.full(16, 2.0), OTHER_RUN, "m^2", exact=True)
    assert (a * elsewhere).run is RUN
    assert (a * elsewhere).error == pytest.approx(2 * a.error, rel=1e-14)


def test_a_mean_of_a_billion_keeps_its_error_and_its_differences():
    a, b = noisy(1e9, 1, 1), noisy(1e9, 1, 2)
    shift = Estimate(a.values - 1e9, RUN, "W")
    assert a.error == pytest.approx(shift.error, rel=1e-6)
    assert (a - b).error == pytest.approx(Estimate(a.values - b.values, RUN, "W").error, rel=1e-6)
    assert (a / b).error == pytest.approx((a - b).error / 1e9, rel=1e-5)


def test_a_ratio_that_hangs_on_one_batch_has_no_known_error():
    rare = Estimate(np.r_[1.0, np.zeros(31)], RUN, "W")
    ratio = noisy(5, 1, 1) / rare
    assert math.isfinite(ratio.value)
    assert ratio.reason == "too few scores or digits"
    assert (noisy(5, 1, 1) / Estimate(np.zeros(32), RUN, "W")).reason == "undefined: not finite"


@pytest.mark.filterwarnings("error")
def test_what_is_over_nothing_is_undefined_without_a_warning():
    a, nothing = noisy(5, 1, 1), Estimate(np.zeros(32), RUN, "W")
    none_exactly = Estimate(np.zeros(32), RUN, "W", exact=True)
    for zero in (nothing, none_exactly, a - a, 0.0):
        for undefined in (a / zero, (a / zero) * 2, a / zero - a / zero, -(a / zero)):
            assert math.isnan(undefined.error) and (undefined - undefined).reason == undefined.reason
            assert undefined.reason == "undefined: not finite"
            assert math.isnan(undefined.z(math.inf)) and math.isnan(undefined.interval()[0])
            assert "undefined" in f"{undefined} {undefined:.3f}" and len(undefined.values) == 32
    assert (
        (1 / nothing).reason == (nothing / nothing).reason == (nothing**-1).reason == "undefined: not finite"
    )


def test_unlike_units_and_bare_numbers_are_refused():
    a, area = noisy(5, 1, 1), noisy(3, 1, 2, unit="m^2")
    with pytest.raises(UnitError, match=r"\[W\] and \[m\^2\]"):
        a + area
    with pytest.raises(UnitError, match="subtract"):
        a - 1.0
    with pytest.raises(TypeError):
        a + "1 W"
    with pytest.raises(ValueError, match="does not fit"):
        a * np.ones(3)
    share = a / noisy(7, 1, 3)
    assert (1 - share).value == pytest.approx(1 - share.value)
    assert (a + 0) is a


def test_a_difference_that_happens_to_be_zero_keeps_its_error_in_products_and_ratios():
    """Two noisy totals that are equal by chance: what is made of their difference is no better known."""
    random, run = np.random.default_rng(1), Batches(np.full(32, 1000))
    a, b, c = (random.poisson(1000, 32).astype(float) for _ in "abc")
    b[0] += a.sum() - b.sum()
    first, second, third = (
        Estimate(counts / 1000, run, "1", counts=int(counts.sum())) for counts in (a, b, c)
    )
    np.testing.assert_allclose(((first - second) / third).error, (first - second).error, rtol=0.02)
    np.testing.assert_allclose(((first - second) * third).error, (first - second).error, rtol=0.02)
