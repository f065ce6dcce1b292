"""Estimates and arrays of estimates: what they print and refuse; arithmetic keeps units, correlations and coverage."""

import copy
import math
import pickle
import sys

import numpy as np
import pytest

from tests.agreement import assert_z_spread
from tests.synthetic import EDGES, EVEN_RUN, OTHER_RUN, RUN, grid, noisy, with_error
from transport import SceneError, bins_against_noise
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.replicates import Batches
from transport.units import Unit, UnitError, deg, nm, speed_of_light
from transport.validation import optional_packages

# ---- units ----


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("W m^-2 sr^-1", "W m^-2 sr^-1"),
        ("sr^-1 W/m^2", "W m^-2 sr^-1"),
        ("J/s", "W"),
        ("W s m^-2", "J m^-2"),
        ("m^-1 m", "1"),
        ("1", "1"),
        ("s^-1 m^-2 sr^-1", "s^-1 m^-2 sr^-1"),
        ("m^(1/2)", "m^(1/2)"),
    ],
)
def test_units_print_in_one_order_whatever_was_written(text, printed):
    assert str(Unit.parse(text)) == printed
    assert Unit.parse(printed) == Unit.parse(text)
    assert hash(Unit.parse(printed)) == hash(Unit.parse(text))


def test_units_multiply_and_a_joule_is_a_watt_second():
    W, J, s, m = map(Unit.parse, ("W", "J", "s", "m"))
    assert W * s == J
    assert J / s == W
    assert J / W == s
    assert W / m**2 * s == Unit.parse("J m^-2")
    assert (W**2) ** 0.5 == W
    assert W / W == Unit()
    assert W != J
    assert 1 / 550 * nm * speed_of_light > 0
    assert 180 * deg == pytest.approx(math.pi, rel=1e-15)


@pytest.mark.parametrize("text", ["", "W m-2", "W^", "W ** 2"])
def test_an_unreadable_unit_is_refused(text):
    with pytest.raises(UnitError, match="Cannot parse"):
        Unit.parse(text)


# ---- printed estimates ----


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


def test_exact_and_unknown_errors_are_printed():
    exact = Estimate(np.full(32, 2 * np.pi), RUN, "W", exact=True)
    assert (str(exact), f"{exact:.2f}") == ("6.283185 W (exact)", "6.28 W (exact)")
    assert (exact.error, exact.exact, exact.reason) == (0.0, True, None)
    unknown = {
        "no score": Estimate(np.zeros(32), RUN, "W"),
        "every batch gave the same": Estimate(np.full(32, 0.1), RUN, "W"),
        "fewer than 2 batches": Estimate([3.0], Batches([5]), "W"),
        "undefined: not finite": Estimate(np.full(32, np.nan), RUN, "W"),
    }
    for reason, estimate in unknown.items():
        assert estimate.reason == reason and not estimate.exact
        assert math.isnan(estimate.error) and math.isnan(estimate.z(1.0))
        alike = reason == "every batch gave the same"
        assert str(estimate).endswith(f"({reason})" if alike else f"(error unknown: {reason})")
    few = Estimate(np.full(8, 0.1), Batches(np.full(8, 100)), "W")  # chance may have made them alike
    assert str(few) == "0.1 W (error unknown: every batch gave the same)"
    assert np.isnan(few.interval()).all() and few.verdict == "doubtful"
    varied = noisy(5, 1, 1)
    assert (varied + unknown["every batch gave the same"]).error == varied.error
    assert str(unknown["no score"]) == "0 W (error unknown: no score)"
    assert f"{Estimate(np.zeros(32), RUN, '1'):.2f}" == "0.00 (error unknown: no score)"


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


@pytest.mark.parametrize("bad", ["d", ".3x", "three"])
def test_an_unknown_format_is_refused(bad):
    with pytest.raises(ValueError, match="write it like"):
        format(with_error(1.0, 0.1), bad)


def test_uncertain_numbers_have_no_order():
    E = noisy(5, 1, 1)
    for compare in (
        lambda: E > 3, lambda: 3 < E, lambda: E <= E, lambda: sorted([E, E]), lambda: min(E, 3.0), lambda: np.float64(3) < E,
    ):  # fmt: skip
        with pytest.raises(TypeError, match=r"compare E.value, or use .*z\("):
            compare()
    with pytest.raises(TypeError, match=r"E\.z\(3\)"):
        E >= 3  # noqa: B015


@pytest.mark.parametrize(
    ("value", "counts", "reason"),
    [(1e-18, 7, "every batch gave the same"), (1e-18, 0, "no score"), (0.0, 7, "no score")],
)
def test_counts_decide_whether_there_was_a_score(value, counts, reason):
    """Where all that was counted is too faint for the digits of a sum, nothing has scored."""
    assert Estimate(np.full(32, value), RUN, "W", counts=counts).reason == reason


def test_an_estimate_has_value_error_interval_and_score():
    estimate = with_error(10.0, 2.0)
    assert (estimate.value, estimate.batches, str(estimate.unit)) == (10.0, 2, "W")
    assert estimate.error == pytest.approx(2.0) and estimate.relative_error == pytest.approx(0.2)
    assert float(estimate) == 10.0
    low, high = estimate.interval(0.95)
    assert (high - low) / 2 == pytest.approx(2 * 12.7062047, rel=1e-8)
    assert estimate.z(low) == pytest.approx(1.959964, rel=1e-6)
    assert estimate.z(high) == -estimate.z(low)
    with pytest.raises(ValueError, match="confidence"):
        estimate.interval(95)
    exact = Estimate(np.full(32, 0.1), RUN, "W", exact=True)
    assert (exact.z(0.1 * (1 + 1e-13)), exact.z(0.2), exact.interval()) == (0, -math.inf, (0.1, 0.1))


# ---- arithmetic within a run ----


def test_linear_steps_keep_correlations():
    a, b, E = noisy(5, 1, 1), noisy(3, 2, 2), noisy(-5, 1, 1)
    direct, combined = Estimate(2 * a.values - b.values, RUN, "W"), 2 * a - b
    assert combined.value == pytest.approx(direct.value, rel=1e-14)
    assert combined.error == pytest.approx(direct.error, rel=1e-12)
    assert combined.run is RUN
    assert sum([a, b, a]).value == pytest.approx(13, abs=2)
    assert (abs(E).value, abs(E).error, str(abs(E).unit)) == (-E.value, E.error, "W")
    assert (abs(E) + E).value == 0 and abs(-E).value == -E.value


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


def over_seeds(values, run, unit="W"):
    """Many runs as the bins of an array."""
    return EstimateArray(values, run, unit, ("seed",), {"seed": np.arange(values.shape[1] + 1.0)})


def test_the_bias_of_a_ratio_of_skewed_batches_is_taken_off():
    """E[x]/E[y] = 1 with y of 8 lognormal batches: the naive ratio is off by var(y)/8."""
    run, runs = Batches(np.full(8, 10)), 40_000
    rng = np.random.default_rng(11)
    y = np.exp(rng.normal(-0.18, 0.6, size=(8, runs)))
    x = rng.exponential(size=(8, runs))
    ratios = (over_seeds(x, run) / over_seeds(y, run)).value
    naive = x.mean(axis=0) / y.mean(axis=0)
    bias, naive_bias = ratios.mean() - 1, naive.mean() - 1
    assert naive_bias > 15 * naive.std() / math.sqrt(runs)
    assert abs(bias) < naive_bias / 5


def test_intervals_of_a_ratio_cover_as_stated_over_2000_runs():
    """And an error bar a tenth too small is found out."""
    runs, rng = 2000, np.random.default_rng(12)
    y = rng.normal(10, 1, size=(32, runs))
    x = 2 * y + rng.normal(0, 1, size=(32, runs))
    ratio = over_seeds(x, EVEN_RUN) / over_seeds(y, EVEN_RUN, "m^2")
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


def test_an_exact_number_stays_a_plain_factor():
    a, two = noisy(5, 1, 1), Estimate(np.full(32, 2.0), RUN, "m^2", exact=True)
    assert (a / two).error == pytest.approx(a.error / 2, rel=1e-14)
    assert (two * two).exact and (two * two).batches == 32
    assert ((two - 3 * two).value, (two - 3 * two).error) == (-4.0, 0.0)
    elsewhere = Estimate(np.full(16, 2.0), OTHER_RUN, "m^2", exact=True)
    assert (a * elsewhere).run is RUN
    assert (a * elsewhere).error == pytest.approx(2 * a.error, rel=1e-14)


def test_a_ratio_over_nothing_or_one_batch_has_no_known_error():
    rare, zero = Estimate(np.r_[1.0, np.zeros(31)], RUN, "W"), Estimate(np.zeros(32), RUN, "W")
    ratio = noisy(5, 1, 1) / rare
    assert math.isfinite(ratio.value) and ratio.reason == "too few scores or digits"
    for nothing in (noisy(5, 1, 1) / zero, 1 / zero, zero / zero, zero**-1):
        assert nothing.reason == "undefined: not finite"


@pytest.mark.filterwarnings("error")
def test_a_quotient_over_zero_is_undefined_without_a_warning():
    a, exact = noisy(5, 1, 1), Estimate(np.zeros(32), RUN, "W", exact=True)
    for zero in (Estimate(np.zeros(32), RUN, "W"), exact, a - a, 0.0):
        for undefined in (a / zero, (a / zero) * 2, a / zero - a / zero, -(a / zero)):
            assert math.isnan(undefined.error) and (undefined - undefined).reason == undefined.reason
            assert undefined.reason == "undefined: not finite"
            assert math.isnan(undefined.z(math.inf)) and math.isnan(undefined.interval()[0])
            assert "undefined" in f"{undefined} {undefined:.3f}" and len(undefined.values) == 32


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
    first, second, third = (Estimate(n / 1000, run, "1", counts=int(n.sum())) for n in (a, b, c))
    for found in ((first - second) / third, (first - second) * third):
        np.testing.assert_allclose(found.error, (first - second).error, rtol=0.02)


# ---- independent runs ----


def test_errors_of_independent_runs_add_in_quadrature():
    a, b = noisy(5, 1, 1), noisy(3, 2, 2, run=OTHER_RUN)
    total = a + b
    assert total.error == pytest.approx(math.hypot(a.error, b.error), rel=1e-14)
    assert (a * b).value == pytest.approx(a.value * b.value, rel=1e-12)
    assert (a / b).error == pytest.approx(
        a.value / b.value * math.hypot(a.relative_error, b.relative_error), rel=1e-2
    )
    assert 15 <= total.dof <= 31 + 15
    assert total.run is None
    unscored = a + Estimate(np.zeros(16), OTHER_RUN, "W")
    assert unscored.error == a.error and unscored.verdict == "doubtful"
    with pytest.raises(ValueError, match="several"):
        _ = total.values


def test_a_correlation_survives_a_detour_through_another_run():
    a, b = noisy(5, 1, 1), noisy(3, 2, 2, run=OTHER_RUN)
    assert ((a + b) - 2 * a).error == pytest.approx((a + b).error, rel=1e-12)
    assert (a + b + a).error == pytest.approx(math.hypot(2 * a.error, b.error), rel=1e-12)


def test_z_of_two_runs_of_few_batches_follows_its_law_with_effective_freedom():
    runs, many = 3000, {"seed": np.arange(3001.0)}
    rng = np.random.default_rng(13)
    first, second = Batches(np.full(16, 9)), Batches(np.full(16, 9))
    a = EstimateArray(rng.normal(size=(16, runs)), first, "W", ("seed",), many)
    b = EstimateArray(rng.normal(size=(16, runs)), second, "W", ("seed",), many)
    assert_z_spread((a - b).z(0.0), math.inf)


# ---- arrays ----


def test_elements_and_slices_keep_names_and_edges():
    L = grid(1)
    assert (L.dims, L.shape, len(L)) == (("mu", "phi"), (4, 3), 4)
    assert isinstance(L[1, 2], Estimate)
    assert L[1, 2].value == L.value[1, 2]
    assert L[-1, 0].error == L.error[3, 0]
    assert (L[1].dims, L[..., 1].dims, L[:, 1:].shape) == (("phi",), ("mu",), (4, 2))
    np.testing.assert_array_equal(L[1:3].coords["mu"], EDGES["mu"][1:4])
    assert [row.dims for row in L] == [("phi",)] * 4
    with pytest.raises(IndexError, match="index 7 is out of bounds for axis 0 with 4 bins"):
        L[7]
    with pytest.raises(IndexError, match="index -4 is out of bounds for axis 1 with 3 bins"):
        L[..., -4]
    for bad in (4, (0, 0, 0), [0, 1], slice(None, None, 2), None, True):
        with pytest.raises(IndexError):
            L[bad]


def test_sums_and_means_over_bins_keep_correlations():
    values = np.random.default_rng(2).multinomial(1000, [0.25] * 4, size=32) / 1000.0
    shares = EstimateArray(values, EVEN_RUN, "1", ("mu",), {"mu": EDGES["mu"]})
    assert shares.sum().value == pytest.approx(1.0, rel=1e-14)
    assert shares.sum().error < 1e-15 or math.isnan(shares.sum().error)
    L = grid(1)
    assert L.sum("mu").dims == ("phi",) and (L.sum(("phi",)).dims, L.sum(()).dims) == (("mu",), ("mu", "phi"))
    assert L.sum().error == pytest.approx(Estimate(L.values.sum(axis=(1, 2)), RUN, L.unit).error, rel=1e-12)
    for total in (sum(L.sum("phi")), L.sum(("phi", "mu"))):
        assert total.value == pytest.approx(L.sum().value, rel=1e-14)
    assert L.mean().value == pytest.approx(L.value.mean(), rel=1e-14)
    assert L.mean().error == pytest.approx(Estimate(L.values.mean(axis=(1, 2)), RUN, L.unit).error, rel=1e-12)
    np.testing.assert_allclose(L.mean("phi").value, L.value.mean(axis=1), rtol=1e-14)
    assert L.mean(("mu", "phi")).value == L.mean().value
    for function, words in ((L.sum, "no axis 'theta'"), (L.mean, "mean: no axis 'theta'")):
        with pytest.raises(ValueError, match=words):
            function("theta")


def test_numpy_takes_the_values_but_where_errors_would_be_lost():
    L = grid(1)
    for function, cure in ((np.sum, r"\.sum\(\)"), (np.mean, r"\.mean\(\)"), (np.average, r"\.mean\(\)")):
        with pytest.raises(TypeError, match=cure):
            function(L)
    for function, cure in ((np.min, "argmin"), (np.nanmax, "argmax"), (lambda e: e.max(), "argmax")):
        with pytest.raises(TypeError, match=rf"E\[E\.{cure}\(\)\] is the bin .* biased"):
            function(L)
    assert L[L.argmin()].value == L.value.min() and L[L.argmax()].value == L.value.max()
    np.testing.assert_array_equal(np.concatenate([L, L]), np.concatenate([L.value, L.value]))
    np.testing.assert_array_equal(np.atleast_2d(L), L.value)
    assert np.allclose(a=L, b=L.value)


def test_an_array_can_be_plotted():
    figure = pytest.importorskip("matplotlib.figure")
    L = grid(1)
    axes = figure.Figure().subplots()
    for given, drawn in ((L[:, 0], L.value[:, 0]), (L[1, 1], L.value[1, 1]), (list(L[0]), L.value[0])):
        (line,) = axes.plot(given, "o")
        np.testing.assert_array_equal(line.get_ydata(orig=False), np.atleast_1d(drawn))
    axes.errorbar(range(4), L[:, 1], yerr=L[:, 1].error)
    axes.stairs(L[:, 1], L.coords["mu"])
    axes.imshow(L)
    axes.bar(range(4), L[:, 2])


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("plot", r"one number has no bins: print it, or give its detector bins, Detector\("),
        ("mean", "one number has no bins"),
        ("val", "did you mean 'value'"),
        ("err", "did you mean 'error'"),
        ("stderr", "did you mean 'error'"),
        ("std", "did you mean 'error'"),
        ("units", "did you mean 'unit'"),
    ],
)
def test_an_unknown_name_of_a_number_is_answered(name, words):
    number = grid(1)[0, 0]
    with pytest.raises(AttributeError, match=f"Estimate has no attribute '{name}'; {words}"):
        getattr(number, name)
    assert not hasattr(number, name) and not hasattr(number, "_private")
    for again in (copy.deepcopy(number), pickle.loads(pickle.dumps(number))):
        assert (again.value, again.error) == (number.value, number.error)


def test_an_array_of_one_bin_is_a_number():
    L = grid(1)
    assert float(L[1:2, 1:2]) == L.value[1, 1]
    with pytest.raises(TypeError, match=r"one bin.*\(4, 3\)"):
        float(L)


def test_arithmetic_of_arrays_broadcasts_by_name_and_by_shape():
    L, solid_angle = grid(1), np.linspace(0.1, 0.3, 3)
    for product in (L * solid_angle, solid_angle * L):
        np.testing.assert_allclose(product.value, L.value * solid_angle, rtol=1e-14)
        np.testing.assert_allclose(product.error, L.error * solid_angle, rtol=1e-12)
    assert (np.float64(2) * L).value[0, 0] == 2 * L.value[0, 0]
    by_name = L / L.sum("mu")
    assert by_name.dims == ("mu", "phi")
    np.testing.assert_allclose(by_name.sum("mu").value, 1, rtol=1e-3)
    across = L.sum("phi") * L.sum("mu")
    assert across.dims == ("mu", "phi")
    assert (noisy(2, 0.1, 5) * L)[1, 1].error > L[1, 1].error
    with pytest.raises(ValueError, match="does not fit"):
        L * np.ones(4)
    with pytest.raises(ValueError, match="bins along 'mu'"):
        L[1:] + L[:-1]


def test_an_element_has_the_numbers_that_it_had_in_the_array():
    L, flux = grid(1), noisy(2, 0.1, 5)
    ratio, alone = L / flux, L[2, 1] / flux
    assert ratio[2, 1].value == pytest.approx(alone.value, rel=1e-14)
    # Of two uncertain numbers the error is that of the batches; of bins their neighbours are asked as well.
    assert ratio._replicates.error[2, 1] == pytest.approx(alone.error, rel=1e-12)


def test_bins_without_a_score_give_the_reason():
    values = np.random.default_rng(1).poisson(0.05, size=(32, 4, 3)).astype(float)
    values[:, 2, 1] = 0
    L = EstimateArray(values, RUN, "W", ("mu", "phi"), EDGES, counts=values.sum(axis=0))
    assert np.isnan(L.error[2, 1]) and L.reason[2, 1] == L[2, 1].reason == "no score"
    assert L.sum("phi")[2].reason is None
    assert "error unknown in" in repr(L)


def test_arrays_convert_to_numpy_and_xarray(monkeypatch):
    L = grid(1)
    np.testing.assert_array_equal(np.asarray(L), L.value)
    data = L.to_xarray()
    assert data["value"].dims == ("mu", "phi") and data.attrs["units"] == "W m^-2 sr^-1"
    np.testing.assert_allclose(data["mu"], [0.125, 0.375, 0.625, 0.875])
    np.testing.assert_array_equal(data["phi_low"], EDGES["phi"][:-1])
    np.testing.assert_array_equal(data["phi_high"], EDGES["phi"][1:])
    assert (data["phi"].attrs, data["mu_low"].attrs) == ({"units": "rad"}, {"units": "1"})
    np.testing.assert_array_equal(data["error"], L.error)
    table, names = (
        data.to_dataframe(),
        {"value", "error", "doubtful", "mu_low", "mu_high", "phi_low", "phi_high"},
    )
    assert (len(table), set(table.columns)) == (12, names)
    assert len(repr(L)) < 120
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(SceneError, match=r"to_xarray: xarray is not installed; pip install '\.\[files\]'"):
        L.to_xarray()
    with pytest.raises(ModuleNotFoundError), optional_packages("here"):
        import no_such_module  # noqa: F401


def test_a_repr_shows_the_range_of_known_values():
    shares = grid(1, unit="1")
    assert "inf" not in repr(shares) and " 1," not in repr(shares)
    values = np.array(shares.values)
    values[:, 2, 1] = np.nan
    partly = EstimateArray(values, RUN, "W", ("mu", "phi"), EDGES)
    assert f"{np.nanmin(partly.value):.4g} to {np.nanmax(partly.value):.4g} W, median" in repr(partly)
    assert "error unknown in 1 of 12" in repr(partly)
    assert partly.reason[2, 1] == "undefined: not finite"
    nowhere = EstimateArray(np.full_like(values, np.nan), RUN, "W", ("mu", "phi"), EDGES)
    assert "error unknown in 12 of 12" in repr(nowhere)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: EstimateArray(np.ones((32, 4)), RUN, "W", ("mu",), {"mu": np.arange(4)}), "5 edges"),
        (lambda: EstimateArray(np.ones((32, 4)), RUN, "W", ("mu", "phi"), EDGES), "must match"),
        (lambda: Estimate(np.ones(31), RUN, "W"), "31 batch values"),
        (lambda: Batches([3, 0]), "positive whole"),
    ],
)
def test_malformed_arrays_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()


# ---- what bins lose to blur and to noise, from one run, against exact means of known curves ----

BATCHES, NOISE = 32, 0.02  # of one batch in one of FINE bins
FINE = 48
PLACES = (np.arange(FINE * 256) + 0.5) / (FINE * 256)
CURVES = {"slope": lambda x: 1 + x, "wave": lambda x: 2 + np.sin(6 * x), "flat": lambda x: np.ones_like(x)}


def measured(name, seed=1, noise=NOISE):
    """An array of a run in which each bin has the curve's mean, and in each batch noise of its own."""
    means = CURVES[name](PLACES).reshape(FINE, -1).mean(axis=1)
    values = means + np.random.default_rng(seed).normal(scale=noise, size=(BATCHES, FINE))
    run, edges = Batches(np.full(BATCHES, 1000)), np.linspace(0, 1, FINE + 1)
    return EstimateArray(values, run, "1", ("u",), {"u": edges})


def exact_blur(name, bins):
    values = CURVES[name](PLACES)
    means = values.reshape(bins, -1).mean(axis=1).repeat(len(values) // bins)
    return math.sqrt(np.mean((values - means) ** 2) / np.mean(values**2))


@pytest.mark.parametrize("name", ["slope", "wave"])
def test_blur_is_what_the_exact_curve_loses_and_noise_is_that_of_a_mean(name):
    """Within 3 % where blur is above noise; not to subtract the noise that blur is measured with is 20 % off."""
    found = bins_against_noise(measured(name), "u")
    assert found.bins == (1, 2, 3, 4, 6, 8, 12, 16, 24, 48)
    for bins, blur, noise in zip(found.bins, found.blur, found.noise, strict=True):
        scale = math.sqrt(np.mean(CURVES[name](PLACES) ** 2))
        expected = NOISE / math.sqrt(BATCHES * FINE / bins) / scale
        assert abs(noise / expected - 1) < 5 / math.sqrt(2 * (BATCHES - 1) * bins)
        if bins <= 8:
            assert blur == pytest.approx(exact_blur(name, bins), rel=0.03)


def test_the_blur_of_the_finest_bins_is_extrapolated():
    """As for a slope a quarter of what halving them adds, within 10 %; taken for 0 it would be all of it off."""
    found = bins_against_noise(measured("wave", noise=1e-4), "u")
    assert found.blur[-1] == pytest.approx(exact_blur("wave", FINE), rel=0.1)


def test_a_flat_curve_has_no_blur_and_one_bin_is_the_best():
    """In the mean of many runs blur² is 0 within five of its standard errors; with its noise left in it is not."""
    squares = []
    for seed in range(40):
        found = bins_against_noise(measured("flat", seed), "u")
        squares.append(found.blur[4] ** 2)
        assert found.noise[0] < found.noise[-1]
    assert np.median(squares) < 0.2 * NOISE**2 / BATCHES
    assert bins_against_noise(measured("flat", 3), "u").best() <= 4


def test_more_particles_pay_for_more_bins():
    found = bins_against_noise(measured("wave", noise=0.3), "u")
    assert 1 < found.best() < found.best(100) <= FINE
    assert found.total()[-1] == pytest.approx(math.hypot(found.noise[-1], found.blur[-1]))
    assert found.total(100)[-1] == pytest.approx(math.hypot(found.noise[-1] / 10, found.blur[-1]))


def test_other_axes_are_kept_and_their_squares_averaged():
    one, other = (measured(name, noise=1e-4) for name in ("slope", "flat"))
    both = np.stack([one.values, other.values], axis=1)
    coords = {"v": np.array([0.0, 1.0, 2.0]), "u": one.coords["u"]}
    found = bins_against_noise(EstimateArray(both, one.run, "1", ("v", "u"), coords), "u")
    size = [np.mean(CURVES[name](PLACES) ** 2) for name in ("slope", "flat")]
    share = math.sqrt(size[0] / sum(size))
    assert found.blur[0] == pytest.approx(exact_blur("slope", 1) * share, rel=1e-2)


def test_bins_that_cannot_be_divided_are_refused():
    prime = EstimateArray(np.ones((4, 7)), Batches(np.full(4, 9)), "1", ("u",), {"u": np.arange(8.0)})
    for array, axis, words in ((measured("flat"), "mu", "no axis 'mu'"), (prime, "u", "divided, got 7")):
        with pytest.raises(SceneError, match=words):
            bins_against_noise(array, axis)
