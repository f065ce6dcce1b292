"""Error bars of bins: intervals hold the truth as often as they claim, where few scores carry the values and at edges.

Seeds are fixed.  Coverages are means over thousands of bins, whose bounds fail right code in fewer than one of 10^4
choices of seeds; without pooling they are missed by far.
"""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import transport as tp
from tests.bench.interval_coverage import radiance_of, room, row_of
from transport.statistics.batches import student_quantile
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.pooling import pooled_errors, window_sums
from transport.statistics.replicates import Batches

BATCHES = 32
RUN = Batches(np.full(BATCHES, 100))


def heavy(rng, expected):
    """Sums of scores of 1, of which three in a hundred are 50 instead, by batch; and their true mean and error."""
    expected = np.asarray(expected, dtype=float)
    small = rng.poisson(0.97 * expected / BATCHES, (BATCHES, *expected.shape))
    large = rng.poisson(0.03 * expected / BATCHES, (BATCHES, *expected.shape))
    error = np.sqrt((0.97 + 0.03 * 2500) * expected) / BATCHES
    return small + 50.0 * large, (0.97 + 1.5) * expected / BATCHES, error


def like(rng, expected):
    """The same of scores that are all alike."""
    expected = np.asarray(expected, dtype=float)
    sums = rng.poisson(expected / BATCHES, (BATCHES, *expected.shape)).astype(float)
    return sums, expected / BATCHES, np.sqrt(expected) / BATCHES


def picture(values, dims=("v", "u")):
    edges = {name: np.arange(n + 1.0) for name, n in zip(dims, values.shape[1:], strict=True)}
    return EstimateArray(values, RUN, "W", dims, edges)


def coverage(arrays, truth):
    """Shares of trusted bins whose interval holds the truth, with pooled errors and with their own."""
    pooled, own = [], []
    for array in arrays:
        trusted = np.isfinite(array.error) & ~array.is_doubtful
        off = np.abs(array.value - truth)
        pooled.append((off <= student_quantile(0.975, array.dof) * array.error)[trusted])
        own.append((off <= student_quantile(0.975, BATCHES - 1) * array._replicates.error)[trusted])
    return np.concatenate(pooled).mean(), np.concatenate(own).mean()


@pytest.mark.parametrize("expected", [30, 100])
def test_intervals_hold_where_rare_scores_carry_the_error(expected):
    rng = np.random.default_rng(expected)
    found = [heavy(rng, np.full((20, 25), expected)) for _ in range(20)]
    pooled, own = coverage([picture(values) for values, _, _ in found], found[0][1])
    assert 0.93 < pooled < 0.97
    assert own < 0.925


def test_claims_do_not_follow_the_luck_of_the_value():
    rng = np.random.default_rng(1)
    values, mean, _ = heavy(rng, np.full((40, 40), 30))
    array = picture(values)
    assert abs(np.corrcoef(array.value.ravel(), array.error.ravel())[0, 1]) < 0.3
    assert np.corrcoef(array.value.ravel(), array._replicates.error.ravel())[0, 1] > 0.8
    own = array._replicates.error
    assert np.mean((array.value - mean)[own < np.median(own)]) < -0.4 * np.std(array.value)
    few = array.error < np.median(array.error)
    assert abs(np.mean((array.value - mean)[few])) < 0.2 * np.std(array.value)


def test_edges_leave_errors_as_they_are():
    """A hundred times as many scores on one side: ten times the error, from one bin to the next."""
    expected = np.full((30, 30), 100.0)
    expected[:, 15:] = 10000
    values, _, error = like(np.random.default_rng(2), expected)
    ratio = picture(values).error / error
    assert (ratio > 0.75).all() and (ratio < 1.33).all()
    assert np.std(ratio) < 0.08  # from 32 batches alone it is 1 / sqrt(62) = 0.127


def test_a_spot_among_sparse_bins_is_trusted_and_they_are_not():
    expected = np.full((30, 30), 1.0)
    expected[10:12, 10:12] = 10000
    values, _, error = like(np.random.default_rng(3), expected)
    array = picture(values)
    spot = np.s_[10:12, 10:12]
    assert not array.is_doubtful[spot].any()
    assert np.all(np.abs(np.log(array.error[spot] / error[spot])) < np.log(1.5))
    assert np.count_nonzero(~array.is_doubtful) == 4
    np.testing.assert_array_equal(np.isnan(array.error), array.value == 0)


def test_few_bins_judge_themselves():
    """Of two bins, one with nine times the variance, each has about its own error."""
    ratios = []
    for seed in range(200):
        values, _, error = like(np.random.default_rng(seed), np.array([200.0, 1800.0]))
        ratios.append(picture(values, ("u",)).error / error)
    assert np.allclose(np.sqrt(np.mean(np.square(ratios), axis=0)), 1, atol=0.04)


def test_a_batch_that_alone_moves_the_mean_makes_its_bin_doubtful():
    values = np.random.default_rng(4).normal(10.0, 1.0, (BATCHES, 20, 20))
    values[7, 5, 6] += 1000
    array = picture(values)
    assert array.is_doubtful[5, 6]
    assert array.is_doubtful.sum() < 30  # and some of its neighbours, which may get one as well
    assert array[5, 6].is_doubtful is True and array[15, 15].is_doubtful is False


def test_errors_are_free_of_scale_and_of_where_a_circle_begins():
    values, _, _ = heavy(np.random.default_rng(5), np.full((12, 16), 40))
    deviations, known = values - values.mean(axis=0), np.ones((12, 16), dtype=bool)
    sizes = np.ones(BATCHES)
    first = pooled_errors(deviations, sizes, known, (0, 1), (1,))
    for power in (-900, 900):
        scaled = pooled_errors(np.ldexp(deviations, power), sizes, known, (0, 1), (1,))
        np.testing.assert_array_equal(scaled.error, np.ldexp(first.error, power))
        np.testing.assert_array_equal(scaled.dof, first.dof)
    turned = pooled_errors(np.roll(deviations, 5, axis=2), sizes, known, (0, 1), (1,))
    np.testing.assert_allclose(turned.error, np.roll(first.error, 5, axis=1), rtol=1e-12)
    open_ended = pooled_errors(deviations, sizes, known, (0, 1))
    assert np.abs(open_ended.error / first.error - 1)[:, [0, -1]].max() > 1e-3


def test_window_sums_are_those_of_a_loop():
    terms = np.random.default_rng(6).uniform(size=(3, 7, 5))
    for reach in (1, 2, 3, 9):
        found = window_sums(terms, reach, (1, 2), (2,))
        around = min(reach, 2)  # of five bins on a circle two lie on each side
        for i, j in np.ndindex(7, 5):
            columns = [(j + step) % 5 for step in range(-around, around + 1)]
            expected = terms[:, max(0, i - reach) : i + reach + 1][:, :, columns].sum(axis=(1, 2))
            np.testing.assert_allclose(found[:, i, j], expected, rtol=1e-13)


def test_elements_slices_and_multiples_keep_their_errors_and_sums_theirs():
    values, _, _ = heavy(np.random.default_rng(7), np.full((8, 9), 60))
    array = picture(values)
    assert not np.allclose(array.error, array._replicates.error, rtol=0.05)
    element, part = array[3, 4], array[2:5, 1:7]
    assert (element.error, element.dof) == (array.error[3, 4], array.dof[3, 4])
    assert element.interval() == tuple(ends[3, 4] for ends in array.interval())
    assert element.z(0.0) == array.z(0.0)[3, 4]
    np.testing.assert_array_equal(part.error, array.error[2:5, 1:7])
    assert part[1, 3].error == element.error
    assert pickle.loads(pickle.dumps(element)).error == element.error
    assert (2 * element).error == pytest.approx(2 * element.error, rel=1e-12)
    assert (element**2).relative_error == pytest.approx(2 * element.relative_error, rel=0.1)
    factors = np.arange(1.0, 10.0)
    np.testing.assert_allclose((array * factors).error, array.error * factors, rtol=1e-12)
    total = Estimate(values.sum(axis=(1, 2)), RUN, "W")
    assert array.sum().error == pytest.approx(total.error, rel=1e-12)
    np.testing.assert_array_equal(array.to_xarray()["doubtful"], array.is_doubtful)


def test_axes_that_are_no_places_are_not_pooled():
    values, _, _ = heavy(np.random.default_rng(8), np.full(30, 60))
    array = picture(values, ("time",))
    np.testing.assert_array_equal(array.error, array._replicates.error)


def test_pixels_hold_the_truth_in_a_room_with_a_mirror_ball():
    """300 histories per pixel; from a pixel's own batches about 80 % of the intervals hold it."""
    scene = room(tp.Mirror(), pixels=(16, 12))
    truth = radiance_of(scene, 5_000_000, 10_000)
    row = row_of([radiance_of(scene, 300 * 192, seed) for seed in range(20)], truth)
    assert row.before < 0.86
    assert 0.925 < row.after < 0.975
    assert row.doubtful < 0.05
    assert np.all((row.coverages > 0.90) & (row.coverages < 0.99))
