"""What bins lose to blur and to noise, from one run: against exact means of known curves."""

from __future__ import annotations

import math

import numpy as np
import pytest

from transport import SceneError, bins_against_noise
from transport.statistics.estimates import EstimateArray
from transport.statistics.replicates import Batches

BATCHES, NOISE = 32, 0.02  # of one batch in one of FINE bins
FINE = 48
PLACES = (np.arange(FINE * 256) + 0.5) / (FINE * 256)
CURVES = {"slope": lambda x: 1 + x, "wave": lambda x: 2 + np.sin(6 * x), "flat": lambda x: np.ones_like(x)}


def measured(curve, seed=1, noise=NOISE, fine=FINE):
    """An array of a run in which each bin has the curve's mean, and in each batch noise of its own."""
    means = curve(PLACES).reshape(fine, -1).mean(axis=1)
    values = means + np.random.default_rng(seed).normal(scale=noise, size=(BATCHES, fine))
    run, edges = Batches(np.full(BATCHES, 1000)), np.linspace(0, 1, fine + 1)
    return EstimateArray(values, run, "1", ("u",), {"u": edges})


def exact_blur(curve, bins):
    values = curve(PLACES)
    means = values.reshape(bins, -1).mean(axis=1).repeat(len(values) // bins)
    return math.sqrt(np.mean((values - means) ** 2) / np.mean(values**2))


@pytest.mark.parametrize("name", ["slope", "wave"])
def test_blur_is_what_the_exact_curve_loses_and_noise_is_that_of_a_mean(name):
    """Within 3 % where blur is above noise; not to subtract the noise that blur is measured with is 20 % off."""
    curve = CURVES[name]
    told = bins_against_noise(measured(curve), "u")
    assert told.bins == (1, 2, 3, 4, 6, 8, 12, 16, 24, 48)
    for bins, blur, noise in zip(told.bins, told.blur, told.noise, strict=True):
        scale = math.sqrt(np.mean(curve(PLACES) ** 2))
        expected = NOISE / math.sqrt(BATCHES * FINE / bins) / scale
        assert abs(noise / expected - 1) < 5 / math.sqrt(2 * (BATCHES - 1) * bins)
        if bins <= 8:
            assert blur == pytest.approx(exact_blur(curve, bins), rel=0.03)


def test_the_blur_of_the_finest_bins_is_extrapolated():
    """As for a slope a quarter of what halving them adds, within 10 %; taken for 0 it would be all of it off."""
    told = bins_against_noise(measured(CURVES["wave"], noise=1e-4), "u")
    assert told.blur[-1] == pytest.approx(exact_blur(CURVES["wave"], FINE), rel=0.1)


def test_what_is_flat_has_no_blur_and_one_bin_is_the_best():
    """In the mean of many runs blur² is 0 within five of its standard errors; with its noise left in it is not."""
    squares = []
    for seed in range(40):
        told = bins_against_noise(measured(CURVES["flat"], seed), "u")
        squares.append(told.blur[4] ** 2)
        assert told.noise[0] < told.noise[-1]
    assert np.median(squares) < 0.2 * NOISE**2 / BATCHES
    assert bins_against_noise(measured(CURVES["flat"], 3), "u").best() <= 4


def test_more_particles_pay_for_more_bins():
    told = bins_against_noise(measured(CURVES["wave"], noise=0.3), "u")
    assert 1 < told.best() < told.best(100) <= FINE
    assert told.total()[-1] == pytest.approx(math.hypot(told.noise[-1], told.blur[-1]))
    assert told.total(100)[-1] == pytest.approx(math.hypot(told.noise[-1] / 10, told.blur[-1]))


def test_other_axes_are_kept_and_their_squares_averaged():
    one, other = (measured(CURVES[name], noise=1e-4) for name in ("slope", "flat"))
    both = np.stack([one.values, other.values], axis=1)
    coords = {"v": np.array([0.0, 1.0, 2.0]), "u": one.coords["u"]}
    told = bins_against_noise(EstimateArray(both, one.run, "1", ("v", "u"), coords), "u")
    size = [np.mean(CURVES[name](PLACES) ** 2) for name in ("slope", "flat")]
    assert told.blur[0] == pytest.approx(
        exact_blur(CURVES["slope"], 1) * math.sqrt(size[0] / sum(size)), rel=1e-2
    )


def test_what_cannot_be_divided_is_refused():
    with pytest.raises(SceneError, match="no axis 'mu'"):
        bins_against_noise(measured(CURVES["flat"]), "mu")
    prime = EstimateArray(np.ones((4, 7)), Batches(np.full(4, 9)), "1", ("u",), {"u": np.arange(8.0)})
    with pytest.raises(SceneError, match="divided, got 7"):
        bins_against_noise(prime, "u")
