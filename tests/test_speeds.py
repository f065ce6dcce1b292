"""Distributions of speeds against their laws: in the tails by mpmath, in the middle by chi-square."""

import math
import pickle
import subprocess
import sys
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
from scipy.special import betainc, gammaincinv, ndtri

from tests.agreement import assert_follows
from transport.geometry.flat import Disk
from transport.scene.speeds import InverseCDF, Maxwellian, SpeedTable
from transport.statistics import normal
from transport.statistics.quantiles import LARGEST_U
from transport.units import BOLTZMANN

ROOT = Path(__file__).resolve().parents[1]
TAILS = np.concatenate(
    [2.0 ** np.arange(-53, 0, 4), [0.1, 0.3, 0.45, 0.55, 0.7, 0.9], 1 - 2.0 ** np.arange(-53, -1, 4)]
)
MIDDLE = (np.arange(20_000) + 0.5) / 20_000
GAS = Maxwellian(sigma=1.0)


def chi_below(x, degrees):
    """P(chi <= x) by its series, which does not cancel."""
    a, t = mp.mpf(degrees) / 2, x * x / 2
    return t**a * mp.exp(-t) * mp.hyp1f1(1, a + 1, t) / mp.gamma(a + 1)


def chi_above(x, degrees):
    t = x * x / 2
    return (1 + t) * mp.exp(-t) if degrees == 4 else mp.erfc(mp.sqrt(t)) + 2 * mp.sqrt(t / mp.pi) * mp.exp(-t)


def normal_below(x):
    return mp.erfc(-x / mp.sqrt(2)) / 2


def crossing_above(w, d):
    """The part of a drifting gas that crosses faster than w, not normalised."""
    x = w - d
    return mp.npdf(x) + d * mp.erfc(x / mp.sqrt(2)) / 2


def worst_error(speeds, below, above, density, us=TAILS, digits=60):
    """Largest relative error of quantiles: one step of Newton's from each in high precision."""
    worst = 0
    with mp.workdps(digits):
        for speed, u in zip(map(float, speeds), map(float, us), strict=True):
            x = mp.mpf(speed)
            part, share, sign = (above(x), 1 - mp.mpf(u), -1) if u > 0.5 else (below(x), mp.mpf(u), 1)
            step = sign * part * mp.log(part / share) / density(x)
            worst = max(worst, abs(float(step / x)))
    return worst


@pytest.mark.parametrize("degrees, name", [(3, "quantile"), (4, "flux_quantile")])
def test_maxwellian_speeds_follow_chi_in_both_tails(degrees, name):
    norm = mp.mpf(2) ** (1 - mp.mpf(degrees) / 2) / mp.gamma(mp.mpf(degrees) / 2)

    def error(speeds):
        return worst_error(
            speeds,
            lambda x: chi_below(x, degrees),
            lambda x: chi_above(x, degrees),
            lambda x: norm * x ** (degrees - 1) * mp.exp(-x * x / 2),
        )

    speeds = getattr(GAS, name)(TAILS)
    assert error(speeds) < 1e-14
    assert error(speeds * (1 + 3e-14)) > 1e-14
    naive = np.sqrt(2 * gammaincinv(degrees / 2, np.minimum(TAILS.astype(np.float32), 1 - 2e-7)))
    assert error(naive) > 1e-9  # what a single-precision u would give


def test_a_component_of_a_maxwellian_is_normal_in_both_tails():
    places = TAILS[TAILS != 0.5]
    error = worst_error(
        GAS.line_quantile(places), normal_below, lambda x: normal_below(-x), mp.npdf, us=places
    )
    assert error < 1e-14
    ends = GAS.line_quantile(np.array([0.0, LARGEST_U]))
    assert ends[0] == ndtri(2.0**-54) and np.isfinite(ends).all()
    assert (np.abs(ends) < normal.MAX_DEVIATION).all()


def test_sigma_follows_from_temperature_and_mass():
    nitrogen = Maxwellian(temperature=300, mass=4.65e-26)
    assert nitrogen.sigma == math.sqrt(BOLTZMANN * 300 / 4.65e-26)
    assert nitrogen.mean_speed == pytest.approx(
        math.sqrt(8 * BOLTZMANN * 300 / (math.pi * 4.65e-26)), rel=1e-15
    )
    assert Maxwellian(sigma=2).mass is None and not nitrogen.has_drift and not nitrogen.is_signed
    assert Maxwellian(sigma=2, drift=(0, 0, 1)).has_drift
    disk = Disk(radius=1, normal=(0, 1, 0))
    assert Maxwellian(sigma=2, drift=(5, 3, 1)).drift_through(disk, is_back=True) == -3


def test_moments_of_a_maxwellian_and_of_what_effuses_from_it():
    """references.json, A.maxwellian_effusion_moments: crossers' mean speed 3 sqrt(2 pi)/4, energy 2 kT."""
    speeds, crossers = GAS.quantile(MIDDLE), GAS.flux_quantile(MIDDLE)
    assert speeds.mean() == pytest.approx(GAS.mean_speed, rel=1e-5)
    assert (speeds**2).mean() == pytest.approx(3, rel=1e-3)
    assert crossers.mean() == pytest.approx(1.8799712059732503, rel=1e-5)
    assert (crossers**2).mean() / 2 == pytest.approx(2, rel=1e-3)
    assert (speeds**2).mean() / 2 != pytest.approx(2, rel=0.2)  # the flux-weighting forgotten


ONE_WAY = {
    -0.5: 0.35291916596960327,
    0.0: 0.9973557010035817,
    0.5: 2.1206861189359723,
    2.0: 7.072796728100218,
}


@pytest.mark.parametrize("s, flux", ONE_WAY.items())
def test_a_drifting_maxwellian_crosses_a_plane_at_the_reference_rate(s, flux):
    """references.json, A.drifting_maxwellian_flux, n = 2.5."""
    assert 2.5 * GAS.one_way_flux(math.sqrt(2) * s) == pytest.approx(flux, rel=1e-14)
    fast = Maxwellian(sigma=300, drift=(1, 2, 3))
    assert 2.5 / 300 * fast.one_way_flux(300 * math.sqrt(2) * s) == pytest.approx(flux, rel=1e-14)


@pytest.mark.parametrize("d", [-30, -12.25, -5, -2.0001, -2, -1.5, -1, 0, 0.5, 3, 30])
def test_the_rate_does_not_cancel_for_a_drift_away_from_the_plane(d):
    with mp.workdps(300):
        exact = crossing_above(mp.mpf(0), mp.mpf(d))
        rate = GAS.one_way_flux(d)
        assert abs(rate / exact - 1) < 1e-14
        naive = math.exp(-d * d / 2) / math.sqrt(2 * math.pi) + d / 2 * math.erfc(-d / math.sqrt(2))
        assert d > -5 or abs(naive / exact - 1) > 1e-14
    assert GAS.one_way_flux(d) - GAS.one_way_flux(-d) == pytest.approx(d, rel=1e-13, abs=1e-300)


@pytest.mark.parametrize(
    "d, limit", [(-30, 2e-13), (-7.3, 1e-14), (-1, 1e-14), (0, 1e-14), (4, 1e-14), (30, 1e-14)]
)
def test_normal_speeds_of_a_drifting_gas_follow_their_law_in_both_tails(d, limit):
    with mp.workdps(300):
        drift, whole = mp.mpf(d), crossing_above(mp.mpf(0), mp.mpf(d))
        error = worst_error(
            Maxwellian(sigma=300.0).normal_quantile(TAILS, 300.0 * d) / 300.0,
            lambda w: 1 - crossing_above(w, drift) / whole,
            lambda w: crossing_above(w, drift) / whole,
            lambda w: w * mp.npdf(w - drift) / whole,
            digits=300,
        )
    assert error < limit


def test_normal_speeds_at_rest_and_in_a_fast_stream_have_closed_forms():
    u = TAILS
    assert GAS.normal_quantile(u, 0.0) == pytest.approx(np.sqrt(-2 * np.log1p(-u)), rel=1e-13)
    stream = GAS.normal_quantile(MIDDLE, 30.0)
    assert stream.mean() == pytest.approx(30 + 1 / 30, rel=1e-6)  # <w²>/<w>
    assert GAS.normal_quantile(0.0, 5.0) == 0
    away = GAS.normal_quantile(MIDDLE, -30.0)
    assert away.mean() == pytest.approx(2 / 30, rel=0.01)  # a Gamma law, as the density goes as w exp(-30 w)


def test_tables_of_straight_lines_have_closed_forms():
    u = np.concatenate([TAILS, MIDDLE])
    flat, falling = SpeedTable((0, 2), (3, 3)), SpeedTable((0, 1), (1, 0))
    assert flat.quantile(u) == pytest.approx(2 * u, rel=1e-14)
    assert flat.flux_quantile(u) == pytest.approx(2 * np.sqrt(u), rel=1e-14)
    assert falling.quantile(u) == pytest.approx(-np.expm1(np.log1p(-u) / 2), rel=1e-14)
    assert 1 - falling.quantile(u) == pytest.approx(np.sqrt(1 - u), rel=1e-13, abs=2e-16)
    assert betainc(2, 2, falling.flux_quantile(u)) == pytest.approx(u, rel=1e-14)
    assert (flat.mean_speed, falling.mean_speed) == pytest.approx((1, 1 / 3), rel=1e-15)
    rising = SpeedTable((0, 1), (0, 5))
    assert rising.flux_quantile(u) == pytest.approx(u ** (1 / 3), rel=1e-14)


BROKEN = SpeedTable((0, 1, 1.5, 2, 3, 4), (0, 2, 0, 0, 1, 0.5))


@pytest.mark.parametrize("weighted", [False, True], ids=["gas", "crossers"])
def test_table_speeds_follow_the_tabulated_density(weighted):
    draws = np.random.default_rng(1).random(200_000)
    speeds = BROKEN.flux_quantile(draws) if weighted else BROKEN.quantile(draws)
    edges = np.linspace(0, 4, 41)
    fine = np.linspace(0, 4, 400_001)
    density = np.interp(fine, BROKEN.speeds, BROKEN.density)
    other = density * (1 if weighted else fine)
    density = density * (fine if weighted else 1)
    counts = np.histogram(speeds, edges)[0]
    assert counts.sum() == len(draws)
    for law, is_right in ((density, True), (other, False)):
        below = np.concatenate([[0], np.cumsum((law[1:] + law[:-1]) / 2)])
        probabilities = np.diff(np.interp(edges, fine, below / below[-1]))
        probabilities[15:20] = 0  # the gap
        probabilities /= probabilities.sum()
        if is_right:
            assert_follows(counts, probabilities)
        else:
            with pytest.raises(AssertionError):
                assert_follows(counts, probabilities)


def test_no_speed_falls_into_a_gap_of_a_table():
    speeds = BROKEN.quantile(np.concatenate([TAILS, MIDDLE]))
    assert not ((speeds > 1.5 + 1e-12) & (speeds < 2 - 1e-12)).any()


def test_the_scale_of_a_table_does_not_matter():
    v, f = np.linspace(0, 5, 40), np.linspace(0, 5, 40) ** 2 * np.exp(-np.linspace(0, 5, 40))
    plain = SpeedTable(v, f)
    for scale, height in ((2.0**-60, 2.0**200), (2.0**60, 2.0**-900)):
        scaled = SpeedTable(scale * v, height * f)
        assert scaled.flux_quantile(TAILS) == pytest.approx(scale * plain.flux_quantile(TAILS), rel=1e-14)
        assert scaled.mean_speed == pytest.approx(scale * plain.mean_speed, rel=1e-14)


def test_speeds_over_twelve_decades_keep_their_digits():
    """Density 1/v between 1e-3 and 1e9: logarithms uniform, crossers uniform."""
    v = np.geomspace(1e-3, 1e9, 40_001)
    table, law = SpeedTable(v, 1 / v), InverseCDF(decades)
    assert np.log10(table.quantile(TAILS)) == pytest.approx(12 * TAILS - 3, abs=1e-6)
    assert table.flux_quantile(TAILS) == pytest.approx(1e-3 + TAILS * (1e9 - 1e-3), rel=1e-6)
    assert law.flux_quantile(TAILS) == pytest.approx(1e-3 + TAILS * (1e9 - 1e-3), rel=1e-12)
    assert law.mean_speed == pytest.approx((1e9 - 1e-3) / math.log(1e12), rel=1e-13)


def decades(u):
    return 10 ** (12 * u - 3)


def test_an_inverse_cdf_gives_the_same_crossers_as_the_maxwellian_that_it_is():
    law = InverseCDF(GAS.quantile)
    assert law.mean_speed == pytest.approx(GAS.mean_speed, rel=1e-14)
    u = np.concatenate([TAILS[:-1], MIDDLE[::50]])
    error = np.abs(law.flux_quantile(u) / GAS.flux_quantile(u) - 1)
    assert (error < 1e-14 + 2 * 2.0**-53 / (1 - u)).all()  # a function of u cannot know 1 - u any better
    assert (np.abs(law.quantile(u) / GAS.flux_quantile(u) - 1) > 0.01).all()


def exponential(u):
    return -np.log1p(-u)


def two_speeds(u):
    return np.where(u < 0.3, 100.0, 200.0)


def broken_line(u):
    return np.interp(u, np.linspace(0, 1, 11), np.arange(11.0) ** 2)


def test_an_inverse_cdf_weighs_smooth_and_stepped_functions_by_the_speed():
    u = MIDDLE[::20]
    assert InverseCDF(exponential).flux_quantile(u) == pytest.approx(gammaincinv(2, u), rel=1e-13)
    steps = InverseCDF(two_speeds)
    share = 30 / 170  # of the crossers that are slow
    assert steps.mean_speed == pytest.approx(170, rel=1e-14)
    assert steps.flux_quantile(np.array([share - 1e-12, share + 1e-12])).tolist() == [100, 200]
    knots = np.arange(11.0) ** 2
    table = SpeedTable(*histogram(knots))
    assert InverseCDF(broken_line).mean_speed == pytest.approx((knots[1:] + knots[:-1]).mean() / 2, rel=1e-14)
    assert InverseCDF(broken_line).flux_quantile(u) == pytest.approx(table.flux_quantile(u), rel=1e-6)


def histogram(knots):
    """A table of the density 1/(10 step) between knots, its jumps made steep."""
    speeds = np.concatenate([(a, b * (1 - 1e-9)) for a, b in zip(knots, knots[1:], strict=False)])
    return speeds, np.repeat(1 / np.diff(knots), 2)


def line(u):
    return 2 * u - 1


def test_negative_speeds_count_by_their_size():
    for law in (SpeedTable((-1, 1), (1, 1)), InverseCDF(line)):
        assert (
            law.is_signed
            and law.mean_speed == pytest.approx(0.5, rel=1e-14)
            and law.fastest == pytest.approx(1)
        )
        assert law.line_quantile(np.array([0.0, 0.75])) == pytest.approx([-1, 0.5], rel=1e-14)
        assert law.flux_quantile(np.array([0, 0.125, 0.875])) == pytest.approx([-1, -(0.75**0.5), 0.75**0.5])
    assert not InverseCDF(exponential).is_signed and not SpeedTable((0, 1), (1, 1)).is_signed


EVERY = [
    GAS,
    Maxwellian(temperature=300, mass=4.65e-26, drift=(1, 2, 3)),
    SpeedTable((0, 1, 2), (0, 1, 0)),
    SpeedTable([-5, 1, 2], np.array([3, 1, 0])),
    InverseCDF(exponential),
    InverseCDF(two_speeds),
    InverseCDF(line),
]


@pytest.mark.parametrize("law", EVERY, ids=repr)
def test_quantiles_rise_and_stay_below_the_fastest_for_any_u(law):
    u = np.unique(np.concatenate([[0.0, 2.0**-54, LARGEST_U], TAILS, MIDDLE[::10]]))
    for quantile in (law.quantile, law.line_quantile, law.flux_quantile):
        speeds = quantile(u)
        assert speeds.shape == u.shape and np.isfinite(speeds).all()
        assert (np.diff(speeds) >= -1e-12 * np.abs(speeds[1:])).all()
        assert (np.abs(speeds) <= law.fastest).all()
        assert quantile(u.reshape(-1, 1))[:, 0].tolist() == speeds.tolist()
        assert quantile(0.25) == pytest.approx(quantile(np.array([0.25]))[0], rel=1e-15)


@pytest.mark.parametrize("law", EVERY, ids=repr)
def test_distributions_are_values_that_survive_copies(law):
    before = hash(law), law.mean_speed
    twin = pickle.loads(pickle.dumps(law))
    assert twin == law and hash(twin) == hash(law) and twin.mean_speed == law.mean_speed
    assert before == (hash(law), law.mean_speed)
    assert len(set(EVERY)) == len(EVERY)


def test_making_a_distribution_loads_no_special_functions():
    code = (
        "import sys, transport as tp; tp.Gas(1.0, tp.Maxwellian(temperature=300, mass=1e-26));"
        " tp.SpeedTable((0, 1), (1, 0)); print([name for name in ('scipy.special', 'scipy.stats', 'numba') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr
