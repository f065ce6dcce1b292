"""Scattering angles: samplers against densities, inverses and moments; every digit of a peak; directions that stay unit.

Draws are judged by chi-square in cells that crowd towards the peak, told apart by 1 - mu of the peak's side, as the sine
keeps it.  Each judgement fails right code in one of 10^6 seeds; faults are planted as laws that are not those of the sampler.
"""

from __future__ import annotations

import math
from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest
from numba import config, njit
from scipy.integrate import quad

import transport as tp
from tests.agreement import assert_follows
from transport.compile.media import tabulated_rows
from transport.physics.device import ARITHMETIC
from transport.physics.scattering import (
    choose_segment,
    sample_henyey_greenstein,
    sample_rayleigh,
    sample_segment,
    turned_by_angle,
)
from transport.theory import phases

FALSE_ALARM = 1e-6
DRAWS = 200_000
ULP = 2.0**-52
COSINE = 6 * ULP  # how far a cosine may be from the exact one; measured 3.9
SINE = 4 * ULP  # relative, within the peak; measured 1.4
UNIT = 2 * ULP  # |mu^2 + sine^2 - 1|; measured 1.0
G = (-0.999, -0.75, -1e-12, 0.0, 1e-12, 0.3, 0.9, 0.999)
HARD_G = (*G, -0.9999, 0.9999, 1e-15, -1e-15, 1e-300, 1 - 2.0**-53, 2.0**-53 - 1)
LAST = 1 - 2.0**-53
EXTREMES = np.array(
    [0, 2.0**-53, 2.0**-52, 2.0**-33, 0.5 - 2.0**-53, 0.5, 0.5 + 2.0**-52, 1 - 2.0**-33, LAST]
)

by_henyey_greenstein, by_rayleigh, turned = (
    np.vectorize(function, otypes=[float] * count)
    for function, count in ((sample_henyey_greenstein, 2), (sample_rayleigh, 2), (turned_by_angle, 3))
)


def by_table(rows, u):
    return by_rows(rows.view(np.recarray) if config.DISABLE_JIT else rows, u)


@njit(**ARITHMETIC)
def by_rows(rows, u):
    mu, sine, count = np.empty_like(u), np.empty_like(u), len(rows)
    for k in range(u.size):
        start, width, share, r = choose_segment(rows, count, u[k])
        mu[k], sine[k] = sample_segment(start, width, share, r)
    return mu, sine


@njit(**ARITHMETIC)
def scattered(g, v, u, turn):
    """Directions (n, 3) after as many scatterings as u has columns."""
    w = v.copy()
    for k in range(len(v)):
        x, y, z = v[k, 0], v[k, 1], v[k, 2]
        for i in range(u.shape[1]):
            mu, sine = sample_henyey_greenstein(g, u[k, i])
            x, y, z = turned_by_angle(x, y, z, mu, sine, turn[k, i])
        w[k] = x, y, z
    return w


def uniforms(*shape, seed):
    """As the engine draws them: multiples of 2^-52 in [0, 1)."""
    return np.random.default_rng(seed).integers(0, 1 << 52, shape) * 2.0**-52


def hard_uniforms(seed):
    """Extremes, and others down to 2^-53 from both ends: multiples of 2^-53."""
    small = np.ldexp(np.random.default_rng(seed).integers(1, 1 << 20, 200), -(np.arange(200) % 33) - 20)
    return np.concatenate((EXTREMES, uniforms(300, seed=seed), small, 1 - small))


def departures(mu, sine, sign=1.0):
    """1 - sign mu, with the digits that the sine keeps."""
    return np.where(sign * mu > 0, sine * sine / (1 + np.abs(mu)), 1 - sign * mu)


def cells_from_peak(least):
    """Edges of 1 - |mu| of the peak's side, from 0 over `least` to 2."""
    return np.unique(np.concatenate(([0.0], np.geomspace(least, 2, 25), np.linspace(0.1, 2, 20))))


def follows(x, edges, shares, draws=DRAWS):
    """Whether departures x, counted between edges, follow the probabilities that lie between them."""
    counts, _ = np.histogram(x, edges)
    assert counts.sum() == draws, "some draws lie in no cell"
    try:
        assert_follows(counts, np.diff(shares), FALSE_ALARM)
    except AssertionError:
        return False
    return True


# ---- Henyey and Greenstein ----


def henyey_greenstein_shares(edges, g):
    """Probabilities of an angle within 1 - |mu|, from the side of the peak, in 50 digits."""

    def within(x):
        a, x = mp.mpf(abs(g)), mp.mpf(float(x))
        root = mp.sqrt((1 - a) ** 2 + 2 * a * x)
        return float((1 + a) * x / (root * (1 - a + root)))

    with mp.workdps(50):
        return np.array([within(x) for x in edges])


@pytest.mark.parametrize("g", G)
def test_henyey_greenstein_angles_follow_their_density(g):
    """A mean cosine that is 1 % of 1 - |g| wrong is seen."""
    sign = 1.0 if g >= 0 else -1.0
    x = departures(*by_henyey_greenstein(g, uniforms(DRAWS, seed=1)), sign)
    edges = cells_from_peak(1e-2 * (1 - abs(g)) ** 2)
    assert follows(x, edges, henyey_greenstein_shares(edges, g))
    wrong = sign * (1 - 1.03 * (1 - abs(g))) if g else 0.03
    assert not follows(x, edges, henyey_greenstein_shares(edges, wrong))


@pytest.mark.parametrize("g", HARD_G)
def test_henyey_greenstein_angles_are_exact_to_the_last_digits(g):
    """Against fractions.  At the far end of a peak, 1 + mu below 2^-52, only the cosine has its digits."""
    u = hard_uniforms(seed=2)
    mu, sine = by_henyey_greenstein(g, u)
    assert np.abs(mu * mu + sine * sine - 1).max() <= UNIT
    for each, m, s in zip(u, mu, sine, strict=True):
        exact = phases.henyey_greenstein_cosine(Fraction(float(each)), Fraction(g))
        assert abs(Fraction(float(m)) - exact) <= COSINE
        if g * exact >= 0:
            square = (1 - exact) * (1 + exact)
            assert abs(Fraction(float(s)) ** 2 - square) <= 2 * SINE * square


def test_the_formula_of_textbooks_would_be_seen():
    """(1 + g^2 - ((1 - g^2)/(1 + g s))^2) / (2 g) at g = 1e-12 has three digits; sqrt(1 - mu^2) at g = 0.9999 six."""
    u = uniforms(200, seed=3)
    g = 1e-12
    mu = (1 + g * g - ((1 - g * g) / (1 - g + 2 * g * u)) ** 2) / (2 * g)
    assert np.abs(mu - by_henyey_greenstein(g, u)[0]).max() > 1e6 * COSINE
    mu, sine = by_henyey_greenstein(0.9999, u)
    assert np.abs(np.sqrt(1 - mu * mu) / sine - 1).max() > 1e3 * SINE


# ---- Rayleigh, and tables ----


def test_rayleigh_angles_follow_their_density():
    x = departures(*by_rayleigh(uniforms(DRAWS, seed=4)))
    edges = np.linspace(0, 2, 41)
    shares = 1 - phases.rayleigh_share(1 - edges)
    assert follows(x, edges, shares)
    assert not follows(x, edges, 0.9 * shares + 0.1 * edges / 2)
    assert not follows(2 - x, edges, 1 - phases.henyey_greenstein_share(1 - edges, 0.01))


def test_rayleigh_angles_are_exact_to_the_last_digits():
    """mu^3 + 3 mu = 8u - 4 in 50 digits."""
    u = np.concatenate((hard_uniforms(seed=5), np.linspace(0, 1, 1001)))
    mu, sine = by_rayleigh(u)
    assert np.abs(mu * mu + sine * sine - 1).max() <= UNIT
    with mp.workdps(50):
        exact = [2 * mp.sinh(mp.asinh(4 * mp.mpf(float(each)) - 2) / 3) for each in u]
        assert max(abs(m - e) for m, e in zip(mu, exact, strict=True)) <= COSINE
        sines = [mp.sqrt((1 - e) * (1 + e)) for e in exact]
        errors = [abs(s / e - 1) for s, e in zip(sine, sines, strict=True) if e > 1e-20]
    assert max(errors) <= SINE
    np.testing.assert_allclose(mu, phases.rayleigh_cosine(u), rtol=0, atol=1e-15)


DEGREES = np.concatenate((np.geomspace(1e-3, 5, 60), np.linspace(6, 180, 175)))
HALVES = np.sin(np.radians(DEGREES[::-1]) / 2)
PEAK_MU = np.concatenate(([-1.0], (1 - 2 * HALVES * HALVES)[1:], [1.0]))
PEAK = phases.henyey_greenstein(PEAK_MU, 0.99) * (1.3 + np.sin(40 * np.arccos(PEAK_MU))) + 1e-3
TABLES = {
    "a forward peak with lobes": (PEAK_MU, PEAK),
    "a backward peak with lobes": (-PEAK_MU[::-1], PEAK[::-1]),
    "a straight rise from 0": ([-1, 1], [0, 1]),
    "a straight fall to 0": ([-1, 1], [5, 0]),
    "uniform": ([-1, 0.5, 1], [2, 2, 2]),
    "with gaps": ([-1, -0.5, -0.2, 0.1, 0.5, 1], [0, 1, 0, 0, 3, 0]),
    "only a narrow cone": ([-1, 1 - 1e-9, 1], [0, 0, 1]),
}


@pytest.mark.parametrize("name", TABLES)
def test_tabulated_angles_follow_their_density(name):
    """Between the table's points, halves and tenths of them: the slope within is followed too.

    A table whose densities are held constant between the points is seen.  The rows keep each segment's probability to rounding.
    """
    mu, density = (np.array(column, float) for column in TABLES[name])
    rows = tabulated_rows(tp.Tabulated(mu=mu, density=density))
    assert_rows_hold(rows, np.diff(mu) * (density[1:] + density[:-1]))
    sign = 1.0 if density[-1] >= density[0] else -1.0
    x = departures(*by_table(rows, uniforms(DRAWS, seed=7)), sign)
    mu, density = (mu, density) if sign > 0 else (-mu[::-1], density[::-1])
    inner = [mu[:-1] + part * np.diff(mu) for part in (0.1, 0.5)]
    edges = np.unique(np.concatenate((mu, *inner)))
    shares = phases.linear_share(edges, mu, density)
    assert follows(x, (1 - edges)[::-1], (1 - shares)[::-1])
    if name != "uniform":
        flat = np.interp(edges, mu, phases.linear_shares(mu, density))
        assert not follows(x, (1 - edges)[::-1], (1 - flat)[::-1])


def assert_rows_hold(rows, masses):
    """What the rows keep and hand on, added up segment by segment."""
    assert len(rows).bit_count() == 1 and (rows["kept"] >= 0).all() and (rows["kept"] <= 1).all()
    found: dict[tuple, float] = {}
    for row in rows.tolist():
        for segment, share in ((row[1:4], row[0]), (row[4:7], 1 - row[0])):
            if share > 0:
                found[segment] = found.get(segment, 0.0) + share / len(rows)
    exact = np.sort(masses[masses > 0] / masses.sum())
    np.testing.assert_allclose(np.sort(list(found.values())), exact, rtol=1e-12, atol=1e-15)


def test_the_place_in_a_segment_is_exact_to_the_last_digits():
    """Tables of one segment, against the inverse in 50 digits; its slope from 0 to nothing but slope."""
    u = hard_uniforms(seed=8)
    for low, high in ((0, 1), (1, 0), (1, 1), (1, 1 + 1e-9), (1e-9, 1), (3, 1), (1, 1e-300)):
        phase = tp.Tabulated(mu=[-1, 1], density=[low, high])
        found, sine = by_table(tabulated_rows(phase), u)
        assert np.abs(found * found + sine * sine - 1).max() <= UNIT
        with mp.workdps(400):
            a, b = mp.mpf(low), mp.mpf(high)
            for each, m in zip(u, found, strict=True):  # seen from mu = 1
                r = mp.mpf(float(each))
                t = r * (a + b) / (b + mp.sqrt((1 - r) * b * b + r * a * a)) if r > 0 else r
                assert abs(m - (1 - 2 * t)) <= COSINE


def test_a_narrow_peak_keeps_the_digits_of_its_angles():
    """Within 1 - mu < 1e-9, angles below 4.5e-5: the sine to all its digits, which the cosine alone has lost."""
    rows = tabulated_rows(tp.Tabulated(mu=[-1, 1 - 2.0**-30, 1], density=[0, 0, 1]))
    assert len(rows) == 1
    u = hard_uniforms(seed=9)
    mu, sine = by_table(rows, u)
    with mp.workdps(50):
        exact = [2 * (1 - mp.sqrt(1 - mp.mpf(float(each)))) / 2 / mp.mpf(2) ** 30 for each in u]
        sines = [mp.sqrt(x * (2 - x)) for x in exact]
        errors = [abs(s - e) / e for s, e in zip(sine, sines, strict=True) if e > 0]
    assert max(errors) <= SINE
    assert np.abs(np.sqrt((1 - mu[20:200]) * (1 + mu[20:200])) / sine[20:200] - 1).max() > 1e3 * SINE


# ---- the turn ----


def test_a_turn_is_by_the_angle_asked_for_about_any_direction():
    v = np.random.default_rng(10).normal(size=(1000, 3))
    v[:6] = np.concatenate((np.eye(3), -np.eye(3)))
    v[6], v[7] = (1e-9, -2e-9, -1), (1e-300, 0, -1)
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    for g in (-0.9, 0.0, 0.999):
        mu, sine = by_henyey_greenstein(g, uniforms(1000, seed=11))
        w = np.stack(turned(*v.T, mu, sine, uniforms(1000, seed=12)), axis=1)
        np.testing.assert_allclose((v * w).sum(axis=1), mu, rtol=0, atol=4 * ULP)
        np.testing.assert_allclose(np.linalg.norm(np.cross(v, w), axis=1), sine, rtol=0, atol=4 * ULP)


@pytest.mark.slow
@pytest.mark.parametrize(("g", "mu_before"), [(0.75, -0.35), (-0.5, 0.8)])
def test_scattered_light_fills_the_ring_about_where_it_flew(g, mu_before):
    """Its cosine to a fixed axis, against the mean over azimuths in closed form; turned by half the azimuths it fails."""
    v = np.tile([math.sqrt((1 - mu_before) * (1 + mu_before)), 0.0, mu_before], (DRAWS, 1))
    u, turn = uniforms(DRAWS, 1, seed=13), uniforms(DRAWS, 1, seed=14)
    edges = np.linspace(-1, 1, 31)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    fine = np.linspace(-1, 1, 30 * 4 + 1)
    half = np.diff(fine)[:, None] / 2
    ring = phases.henyey_greenstein_ring(fine[:-1, None] + half * (1 + nodes), mu_before, g)
    shares = np.cumsum(np.concatenate(([0.0], 2 * math.pi * ((half * weights) * ring).sum(axis=1))))[::4]
    assert abs(shares[-1] - 1) < 1e-9
    shares /= shares[-1]
    assert follows(scattered(g, v, u, turn)[:, 2], edges, shares)
    assert not follows(scattered(g, v, u, turn / 2 + 0.25)[:, 2], edges, shares)
    assert not follows(scattered(0.98 * g, v, u, turn)[:, 2], edges, shares)


@pytest.mark.slow
def test_the_mean_cosine_after_n_scatterings_is_g_to_the_n():
    """And the mean of the second Legendre polynomial is g^(2n): 6 scatterings, to 5 standard errors."""
    count, g = 40_000, 0.9
    v = np.tile([0.36, 0.48, 0.8], (count, 1))
    mu = scattered(g, v, uniforms(count, 6, seed=15), uniforms(count, 6, seed=16)) @ v[0]
    for values, exact in ((mu, g**6), (1.5 * mu * mu - 0.5, g**12)):
        error = values.std() / math.sqrt(count)
        assert abs(values.mean() - exact) < 5 * error
        assert abs(values.mean() - exact / g) > 5 * error


@pytest.mark.parametrize(("g", "most"), [(0.0, 1e-14), (0.75, 1e-14), (0.999, 5e-14), (-0.9, 1e-14)])
def test_directions_stay_unit_over_a_million_scatterings(g, most):
    """An error of the length comes back mu^2 as large: measured |u|^2 - 1 up to 1e-15, 1e-14 for g = 0.999."""
    v = np.array([[0.6, 0.0, 0.8], [0.0, 0.6, -0.8]])
    for _ in range(10):
        v = scattered(g, v, uniforms(2, 50_000, seed=17), uniforms(2, 50_000, seed=18))
        assert np.abs((v * v).sum(axis=1) - 1).max() <= most
    assert np.abs((scattered(g, 1.0001 * v, *uniforms(2, 2, 1, seed=19)) ** 2).sum(axis=1) - 1).max() > most


# ---- the exact references themselves ----


@pytest.mark.parametrize("g", [-0.9, -1e-9, 0.0, 0.3, 0.95])
def test_distribution_and_means_of_henyey_greenstein_are_integrals_of_its_density(g):
    def density(mu):
        return 2 * math.pi * phases.henyey_greenstein(mu, g)

    for mu in (-0.7, 0.4, 1.0):
        below = quad(density, -1, mu, epsabs=1e-13, epsrel=1e-13, limit=200)[0]
        assert math.isclose(phases.henyey_greenstein_share(mu, g), below, rel_tol=1e-11)
    for power, mean in enumerate(phases.henyey_greenstein_means(g), start=1):
        found = quad(lambda mu, n=power: mu**n * density(mu), -1, 1, epsabs=1e-13, limit=200)[0]
        assert abs(found - mean) < 1e-11
    u, h = Fraction(3, 7), Fraction(g)
    cosine = phases.henyey_greenstein_cosine(u, h)
    assert 1 - cosine == phases.henyey_greenstein_departure(u, h)
    assert math.isclose(phases.henyey_greenstein_share(float(cosine), g), u, rel_tol=1e-12)
    assert math.isclose(tp.HenyeyGreenstein(g).density(0.3), phases.henyey_greenstein(0.3, g), rel_tol=1e-14)


def test_references_of_phase_functions():
    """F.HG_sampling_moments and E.HG_azimuth_average (densities there with mean 1)."""
    moments = {0.75: (0.75, 0.7083333333333334, 0.61875), -0.5: (-0.5, 0.5, -0.35)}
    for g, exact in moments.items():
        np.testing.assert_allclose(phases.henyey_greenstein_means(g), exact, rtol=1e-15)
    rings = {
        (0.75, 0.3, 0.8): 0.6517969828537737,
        (0.75, 0.05, 0.06): 2.621518123365547,
        (0.9, 0.3, -0.8): 0.0707498098558913,
        (0.9, 0.05, 0.06): 6.3526881381903575,
        (-0.5, 0.3, -0.8): 1.0646598109698588,
        (-0.5, 1, 0.5): 0.3239695482936233,
    }
    for (g, mu, before), exact in rings.items():
        found = 4 * math.pi * phases.henyey_greenstein_ring(mu, before, g)
        assert math.isclose(found, exact, rel_tol=1e-9)


def test_distributions_of_rayleigh_and_of_a_table_are_integrals_of_their_densities():
    mu = np.linspace(-1, 1, 21)
    assert (
        abs(quad(lambda x: 2 * math.pi * phases.rayleigh(x) * x * x, -1, 1)[0] - phases.RAYLEIGH_MEANS[1])
        < 1e-14
    )
    for x in mu[1:]:
        below = quad(lambda y: 2 * math.pi * phases.rayleigh(y), -1, x)[0]
        assert math.isclose(phases.rayleigh_share(x), below, rel_tol=1e-13)
    assert math.isclose(tp.Rayleigh().density(0.3), phases.rayleigh(0.3), rel_tol=1e-15)
    nodes, density = np.array([-1, -0.5, 0.25, 1.0]), np.array([0.5, 0.0, 2.0, 1.0])
    table = tp.Tabulated(mu=nodes, density=density)
    for x in (-0.9, -0.5, 0.1, 0.6, 1.0):
        below = quad(lambda y: 2 * math.pi * table.density(y), -1, x, points=nodes[1:3])[0]
        assert math.isclose(phases.linear_share(x, nodes, density), below, rel_tol=1e-12)
    for power, mean in enumerate(phases.linear_means(nodes, density), start=1):
        found = quad(lambda y, n=power: 2 * math.pi * y**n * table.density(y), -1, 1, points=nodes[1:3])[0]
        assert math.isclose(found, mean, rel_tol=1e-12)
