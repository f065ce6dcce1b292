"""Free flight, phase mixing and pressure: the closed forms against references, quadrature and one another.

A comment such as `J.free_shear` names the entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from scipy.special import ndtri

from transport.theory import effusion, phase_mixing
from transport.theory import free_flight as free
from transport.theory.phase_mixing import Normal, Uniform

CLOUD = 0.5, 1.2  # sigma_x, sigma_v


def close(value, exact, relative=1e-13, absolute=0.0):
    np.testing.assert_allclose(value, exact, rtol=relative, atol=absolute)


# ---- free flight ----


@pytest.mark.parametrize(
    ("time", "x", "n", "u", "variance"),
    [  # J.gaussian_expansion_1d
        (0, 2, 0.00026766045152977074, 0.0, 1.44),
        (0.3, 0, 0.6475107216054682, 0.0, 0.9483667017913592),
        (5, 0.7, 0.06581438519600433, 0.13903448275862068, 0.00993103448275862),
        (5, 2, 0.06270396236988261, 0.3972413793103448, 0.00993103448275862),
    ],
)
def test_a_gaussian_cloud_expands_cools_and_sorts_its_velocities(time, x, n, u, variance):
    close(free.density(x, time, *CLOUD), n)
    close(free.mean_velocity(x, time, *CLOUD), u)
    close(free.velocity_variance(time, *CLOUD), variance)


@pytest.mark.parametrize(("elapsed", "exact"), [(0.5, (0.4, 0.15, 0.2)), (2.0, (1.3, 0.45, 0.2))])
def test_free_flight_shears_the_covariance_and_keeps_its_determinant(elapsed, exact):  # J.free_shear
    xx, xv, vv = free.sheared_covariance(elapsed, 0.3, 0.05, 0.2)
    close((xx, xv, vv), exact)
    close(xx * vv - xv**2, 0.0575)
    begun = 0.25 + elapsed  # the cloud that was uncorrelated a quarter of a second before
    close(free.sheared_covariance(begun, 0.2875, 0.0, 0.2), exact)
    close(free.width(begun, math.sqrt(0.2875), math.sqrt(0.2)) ** 2, exact[0])


def test_the_density_goes_along_with_a_particle():
    start = free.phase_density(0.4, -0.9, 0.0, *CLOUD)
    for t in (0.0, 0.7, 40.0):
        close(free.phase_density(0.4 - 0.9 * t, -0.9, t, *CLOUD), start, 1e-12)
    # a density that thins out with the cloud's width is another law
    assert free.width(0.7, *CLOUD) > 1.9 * free.width(0.0, *CLOUD)


@pytest.mark.parametrize(
    ("time", "x"), [(0.0, 0.0), (0.0, 0.7), *((t, x) for t in (0.3, 5.0) for x in (0.0, 0.7, -2.0))]
)
def test_density_velocity_and_variance_are_moments_of_the_phase_density(time, x):
    limits = [-12, 12] if time == 0 else [(x - 5) / time, x / time, (x + 5) / time]

    def moment(p):
        return float(
            mp.quad(lambda v: v**p * mp.mpf(float(free.phase_density(x, float(v), time, *CLOUD))), limits)
        )

    n = moment(0)
    u = moment(1) / n
    close(free.density(x, time, *CLOUD), n, 1e-9)
    close(free.mean_velocity(x, time, *CLOUD), u, 1e-8, 1e-12)
    close(free.velocity_variance(time, *CLOUD), moment(2) / n - u**2, 1e-7)


def truncated(low, high, sigma):
    """Share, mean and variance of normal numbers between two bounds, in 60 digits."""
    with mp.workdps(60):
        a, b = mp.mpf(low) / mp.mpf(sigma), mp.mpf(high) / mp.mpf(sigma)
        share = mp.ncdf(b) - mp.ncdf(a) if a < 0 else mp.ncdf(-a) - mp.ncdf(-b)
        mean = (mp.npdf(a) - mp.npdf(b)) / share
        ends = [0 if mp.isinf(e) else e * mp.npdf(e) for e in (a, b)]
        return [
            float(x) for x in (share, mean * sigma, (1 + (ends[0] - ends[1]) / share - mean**2) * sigma**2)
        ]


@pytest.mark.parametrize(
    ("low", "high"),
    [(-0.1, 0.2), (-1, 3), (0, 1e-6), (7, 7.5), (-40, -20), (30, 30.001), (1.5, math.inf), (-math.inf, 0.3), (25, math.inf)],
)  # fmt: skip
def test_bins_hold_their_averages_also_in_a_tail(low, high):
    """Even 40 standard deviations out: nothing cancels or underflows but the share itself."""
    t, sigma = 2.0, free.width(2.0, *CLOUD)
    edges = np.array([low, high]) * sigma
    share, mean, variance = truncated(low * sigma, high * sigma, sigma)
    slope = 1.44 * t / sigma**2
    close(free.bin_shares(edges, t, *CLOUD), share, 1e-12)
    close(free.bin_mean_velocities(edges, t, *CLOUD), mean * slope, 1e-12)
    whole = free.velocity_variance(t, *CLOUD) + slope**2 * variance
    close(free.bin_velocity_variances(edges, t, *CLOUD), whole, 1e-11)


@pytest.mark.parametrize("time", [0.0, 0.3, 5.0])
def test_cells_of_phase_space_add_up_and_are_the_integrals_of_the_density(time):
    x = np.linspace(-5, 5, 6)
    whole = free.cell_shares(x, [-math.inf, math.inf], time, *CLOUD)[:, 0]
    close(whole, free.bin_shares(x, time, *CLOUD), 1e-12)
    cells = free.cell_shares([0.2, 0.5], [-0.3, 0.1, 0.4], time, *CLOUD)[0]
    nodes, weights = np.polynomial.legendre.leggauss(80)
    for (low, high), found in zip([(-0.3, 0.1), (0.1, 0.4)], cells, strict=True):
        places, speeds = 0.35 + 0.15 * nodes, (low + high) / 2 + (high - low) / 2 * nodes
        density = free.phase_density(places[:, None], speeds, time, *CLOUD)
        close(found, 0.15 * (high - low) / 2 * (weights @ density @ weights), 1e-12)


# ---- between mirrors ----


@pytest.mark.parametrize(
    ("t", "x", "exact"),
    [  # J.box_phase_mixing_delta
        (0.1, 0.9, 2.6695574313864246e-09),
        (0.3, 0.1, 1.846880407410486),
        (0.3, 0.5, 0.9983598506738753),
        (0.3, 0.9, 0.15210592455732128),
        (0.6, 0.1, 1.2276064114114158),
        (0.6, 0.5, 0.9999999999990956),
        (0.6, 0.9, 0.7723935885880253),
        (1.0, 0.9, 0.9903269382899769),
    ],
)
def test_images_and_theta_series_are_one_density(t, x, exact):
    close(phase_mixing.image_density(x, t, 0.25, 1.0), exact)
    close(phase_mixing.series_density(x, t, 0.25, Normal(1.0)), exact, 1e-13, 1e-15)
    close(phase_mixing.image_density(3 * x, t * 3 / 20, 0.75, 20.0, length=3.0), exact / 3, 1e-12)


EDGES = np.linspace(0, 1, 11)
starts = pytest.mark.parametrize("start", [0.25, (0.0, 0.5), (0.3, 0.45)])
laws = pytest.mark.parametrize("law", [Normal(1.0), Uniform(1.0)], ids=["normal", "uniform"])


@pytest.mark.slow
@starts
@laws
@pytest.mark.parametrize("time", [0.0, 0.1, 1.0, 2.5, 30.0])
def test_bins_between_mirrors_add_up_and_agree_with_the_fourier_series(start, law, time):
    shares = phase_mixing.bin_shares(EDGES, time, start, law)
    close(shares.sum(), 1.0, 1e-10)
    by_velocity = phase_mixing.bin_shares(EDGES, time, start, law, v_edges=np.linspace(-9.5, 9.5, 40))
    close(by_velocity.sum(axis=1), shares, 0, 1e-10)
    assert (by_velocity >= 0).all()
    if time > 0:
        series = np.diff(EDGES)
        for m in range(1, 3000):
            waves = np.diff(np.sin(m * math.pi * EDGES)) / (m * math.pi)
            series = series + 2 * phase_mixing.mode(m, time, start, law) * waves
        close(shares, series, 0, 1e-10 if isinstance(law, Normal) else 1e-6)  # of a bag it converges slowly


@pytest.mark.slow
@starts
@laws
def test_cells_between_mirrors_hold_particles_followed_one_by_one(start, law):
    """4 million starts on a grid of equal probabilities, each flown and folded."""
    quantiles = (np.arange(2000) + 0.5) / 2000
    places = start[0] + (start[1] - start[0]) * quantiles if isinstance(start, tuple) else np.array([start])
    speeds = np.linspace(-law.reach, law.reach, 4001)[1::2] if isinstance(law, Uniform) else ndtri(quantiles)
    phase = np.mod(np.add.outer(places, speeds * 1.7), 2.0)
    x, v = np.where(phase > 1, 2 - phase, phase), np.where(phase > 1, -speeds, speeds)
    v_edges = np.linspace(-2, 2, 9)
    turned, straight = (
        np.histogram2d(x.ravel(), np.broadcast_to(each, x.shape).ravel(), [EDGES, v_edges])[0] / x.size
        for each in (v, speeds)
    )
    cells = phase_mixing.bin_shares(EDGES, 1.7, start, law, v_edges=v_edges)
    close(cells, turned, 0, 2e-3)
    assert np.abs(cells - straight).max() > 0.01


def test_a_water_bag_is_full_or_empty_and_evens_out_now_and_then():
    x, v, bag = np.linspace(0, 1, 51), np.linspace(-1, 1, 41), ((0.0, 0.5), Uniform(1.0))
    for t in (0.0, 0.25, 2.5, 41.0):
        density = phase_mixing.bin_shares(x, t, *bag, v_edges=v) / 0.02 / 0.05
        assert density.max() < 1 + 1e-9
        close(density.mean() * 2, 1.0, 1e-11)
        assert (density == 0).any() == (t < 41)
    for t in (1.0, 2.0, 7.0):  # it has been drawn over whole periods
        close(phase_mixing.bin_shares(EDGES, t, *bag), 0.1, 1e-12)
    assert np.ptp(phase_mixing.bin_shares(EDGES, 2.5, *bag)) > 0.02


# ---- pressure ----


def test_light_presses_with_a_third_of_its_energy_density_and_half_of_that_on_black():
    close(effusion.light_pressure(1.0, "mirror"), 0.3333333333333333)  # A.photon_pressure
    close(effusion.light_pressure(1.0, "black"), 0.16666666666666666)
    close([effusion.stream_pressure(1.0, 1.0, wall) for wall in ("black", "mirror")], [1.0, 2.0])


@pytest.mark.parametrize("wall", ["mirror", "diffuse", "black"])
def test_isotropic_pressure_is_the_mean_of_streams_over_all_directions(wall):
    nodes, weights = np.polynomial.legendre.leggauss(8)
    mu = (1 + nodes) / 2
    streams = np.array([effusion.stream_pressure(1.0, each, wall) for each in mu])
    close(effusion.light_pressure(1.0, wall), weights @ streams / 4)
    assert weights @ (streams / mu) / 4 > 1.4 * effusion.light_pressure(1.0, wall)  # without its cosine


def test_n_k_t_is_a_third_of_the_mean_square_and_not_of_the_mean_squared():
    n, mass, temperature = 2.5e25, 4.65e-26, 300.0
    mean_square = 3 * effusion.BOLTZMANN * temperature / mass
    exact = effusion.gas_pressure(n, temperature)
    close(effusion.kinetic_pressure(n, mass, mean_square), exact)
    close(exact, 2.5e25 * 1.380649e-23 * 300)
    assert effusion.kinetic_pressure(n, mass, mean_square * 8 / (3 * math.pi)) < 0.85 * exact
