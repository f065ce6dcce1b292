"""Combinations of independent runs: quadrature, correlations that survive, effective degrees of freedom."""

import math

import numpy as np
import pytest

from tests.agreement import assert_z_spread
from tests.synthetic import OTHER_RUN, noisy
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.replicates import Batches


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
