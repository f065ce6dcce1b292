"""Distributions of speeds, as objects and as the engine draws them: every law by chi-square, its tails by mpmath.

All runs have seed 1 and a million particles, which show an error of 1 % in the width of a law.  Each judgement fails right
code in one of 10^6 seeds.
"""

from __future__ import annotations

import ctypes
import math
import pickle
import subprocess
import sys
from functools import lru_cache
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
from scipy.special import betainc, gammainc, gammaincinv, ndtr, ndtri

import transport as tp
from tests.agreement import assert_agrees, assert_follows
from transport.compile import layout
from transport.compile.speeds import has_split_cells, quantile_table
from transport.engine.bundle import LANES, empty_bundle
from transport.engine.passes.velocities import set_speed_by_quantile, set_speed_by_stepped_quantile
from transport.geometry.shape import Shape
from transport.results.detectors import BINS
from transport.statistics import normal as normal_law
from transport.statistics.quantiles import LARGEST_U
from transport.theory import effusion
from transport.theory.view_factors import coaxial_disks
from transport.units import BOLTZMANN

ROOT = Path(__file__).resolve().parents[2]
US = np.concatenate(
    [2.0 ** np.arange(-53, 0, 4), [0.1, 0.3, 0.45, 0.55, 0.7, 0.9], 1 - 2.0 ** np.arange(-53, -1, 4)]
)
MIDDLE = (np.arange(20_000) + 0.5) / 20_000
UNIT_GAS = tp.Maxwellian(sigma=1.0)
FALSE_ALARM = 1e-6
MANY = 1_000_000
SIGMA = 2.0
GAS = tp.Maxwellian(sigma=SIGMA)
CUBE = tp.Box(size=1.0)
DISK = tp.Disk(radius=0.5)
SHARES = np.concatenate(
    [[1e-4, 1e-3], np.linspace(0.0125, 0.9875, 40), [0.999, 0.9999]]
)  # of equal bins, and tails
COSINES = np.linspace(0, 1, 7)
RARE = MANY * 2.0**-18  # draws that may fall into a gap: the cell of a table that holds its jump is rarer

# ---- laws as objects ----


def exact_crossing_above(w, d):
    """The part of a drifting gas that crosses faster than w, not normalised."""
    x = w - d
    return mp.npdf(x) + d * mp.erfc(x / mp.sqrt(2)) / 2


def worst_error(speeds, below, above, density, us=US, digits=60):
    """Largest relative error of quantiles: one step of Newton's from each in high precision."""
    worst = 0
    with mp.workdps(digits):
        for speed, u in zip(map(float, speeds), map(float, us), strict=True):
            x = mp.mpf(speed)
            part, share, sign = (above(x), 1 - mp.mpf(u), -1) if u > 0.5 else (below(x), mp.mpf(u), 1)
            step = sign * part * mp.log(part / share) / density(x)
            worst = max(worst, abs(float(step / x)))
    return worst


def chi(degrees):
    """Below and above by series that do not cancel, and density of chi; of one degree the normal law with its sign."""
    if degrees == 1:
        return mp.ncdf, lambda x: mp.ncdf(-x), mp.npdf
    a = mp.mpf(degrees) / 2

    def below(x):
        return (t := x * x / 2) ** a * mp.exp(-t) * mp.hyp1f1(1, a + 1, t) / mp.gamma(a + 1)

    def above(x):
        t = x * x / 2
        return (
            (1 + t) * mp.exp(-t)
            if degrees == 4
            else mp.erfc(mp.sqrt(t)) + 2 * mp.sqrt(t / mp.pi) * mp.exp(-t)
        )

    def density(x):
        return 2 ** (1 - a) / mp.gamma(a) * x ** (degrees - 1) * mp.exp(-x * x / 2)

    return below, above, density


TAILS_OF = {
    "quantile": 3,
    "flux_quantile": 4,
    "line_quantile": 1,
}  # degrees of freedom of speeds, crossers, one component


@pytest.mark.parametrize("name", TAILS_OF)
def test_maxwellian_speeds_follow_chi_in_both_tails(name):
    us, law = US[US != 0.5], chi(TAILS_OF[name])
    speeds = getattr(UNIT_GAS, name)(us)
    assert worst_error(speeds, *law, us) < 1e-14 < worst_error(speeds * (1 + 3e-14), *law, us)


def test_the_ends_of_the_normal_law_are_finite():
    ends = UNIT_GAS.line_quantile(np.array([0.0, LARGEST_U]))
    assert ends[0] == ndtri(2.0**-54) and (np.abs(ends) < normal_law.MAX_DEVIATION).all()


def test_sigma_follows_from_temperature_and_mass():
    nitrogen = tp.Maxwellian(temperature=300, mass=4.65e-26)
    assert nitrogen.sigma == math.sqrt(BOLTZMANN * 300 / 4.65e-26)
    assert nitrogen.mean_speed == pytest.approx(
        math.sqrt(8 * BOLTZMANN * 300 / (math.pi * 4.65e-26)), rel=1e-15
    )
    assert tp.Maxwellian(sigma=2).mass is None and not nitrogen.has_drift and not nitrogen.is_signed
    assert tp.Maxwellian(sigma=2, drift=(0, 0, 1)).has_drift
    disk = tp.Disk(radius=1, normal=(0, 1, 0))
    assert tp.Maxwellian(sigma=2, drift=(5, 3, 1)).drift_through(disk, is_back=True) == -3


@pytest.mark.parametrize("d", [-30, -12.25, -5, -2.0001, -2, -1.5, -1, 0, 0.5, 3, 30])
def test_the_rate_does_not_cancel_for_a_drift_away_from_the_plane(d):
    with mp.workdps(300):
        exact = exact_crossing_above(mp.mpf(0), mp.mpf(d))
        rate = UNIT_GAS.one_way_flux(d)
        assert abs(rate / exact - 1) < 1e-14
        naive = math.exp(-d * d / 2) / math.sqrt(2 * math.pi) + d / 2 * math.erfc(-d / math.sqrt(2))
        assert d > -5 or abs(naive / exact - 1) > 1e-14
    assert UNIT_GAS.one_way_flux(d) - UNIT_GAS.one_way_flux(-d) == pytest.approx(d, rel=1e-13, abs=1e-300)


@pytest.mark.parametrize(
    "d, limit", [(-30, 2e-13), (-7.3, 1e-14), (-1, 1e-14), (0, 1e-14), (4, 1e-14), (30, 1e-14)]
)
def test_normal_speeds_of_a_drifting_gas_follow_their_law_in_both_tails(d, limit):
    with mp.workdps(300):
        drift, whole = mp.mpf(d), exact_crossing_above(mp.mpf(0), mp.mpf(d))
        error = worst_error(
            tp.Maxwellian(sigma=300.0).normal_quantile(US, 300.0 * d) / 300.0,
            lambda w: 1 - exact_crossing_above(w, drift) / whole,
            lambda w: exact_crossing_above(w, drift) / whole,
            lambda w: w * mp.npdf(w - drift) / whole,
            digits=300,
        )
    assert error < limit


def test_tables_of_straight_lines_have_closed_forms():
    u = np.concatenate([US, MIDDLE[::20]])
    flat, falling = tp.SpeedTable((0, 2), (3, 3)), tp.SpeedTable((0, 1), (1, 0))
    assert flat.quantile(u) == pytest.approx(2 * u, rel=1e-14)
    assert flat.flux_quantile(u) == pytest.approx(2 * np.sqrt(u), rel=1e-14)
    assert falling.quantile(u) == pytest.approx(-np.expm1(np.log1p(-u) / 2), rel=1e-14)
    assert 1 - falling.quantile(u) == pytest.approx(np.sqrt(1 - u), rel=1e-13, abs=2e-16)
    assert betainc(2, 2, falling.flux_quantile(u)) == pytest.approx(u, rel=1e-14)
    assert (flat.mean_speed, falling.mean_speed) == pytest.approx((1, 1 / 3), rel=1e-15)
    rising = tp.SpeedTable((0, 1), (0, 5))
    assert rising.flux_quantile(u) == pytest.approx(u ** (1 / 3), rel=1e-14)


def test_the_scale_of_a_table_does_not_matter():
    v, f = np.linspace(0, 5, 40), np.linspace(0, 5, 40) ** 2 * np.exp(-np.linspace(0, 5, 40))
    plain = tp.SpeedTable(v, f)
    for scale, height in ((2.0**-60, 2.0**200), (2.0**60, 2.0**-900)):
        scaled = tp.SpeedTable(scale * v, height * f)
        assert scaled.flux_quantile(US) == pytest.approx(scale * plain.flux_quantile(US), rel=1e-14)
        assert scaled.mean_speed == pytest.approx(scale * plain.mean_speed, rel=1e-14)


def test_speeds_over_twelve_decades_keep_their_digits():
    """Density 1/v between 1e-3 and 1e9: logarithms uniform, crossers uniform."""
    v = np.geomspace(1e-3, 1e9, 40_001)
    table, law = tp.SpeedTable(v, 1 / v), tp.InverseCDF(decades)
    assert np.log10(table.quantile(US)) == pytest.approx(12 * US - 3, abs=1e-6)
    assert table.flux_quantile(US) == pytest.approx(1e-3 + US * (1e9 - 1e-3), rel=1e-6)
    assert law.flux_quantile(US) == pytest.approx(1e-3 + US * (1e9 - 1e-3), rel=1e-12)
    assert law.mean_speed == pytest.approx((1e9 - 1e-3) / math.log(1e12), rel=1e-13)


def decades(u):
    return 10 ** (12 * u - 3)


def test_an_inverse_cdf_gives_the_same_crossers_as_the_maxwellian_that_it_is():
    law = tp.InverseCDF(UNIT_GAS.quantile)
    assert law.mean_speed == pytest.approx(UNIT_GAS.mean_speed, rel=1e-14)
    u = np.concatenate([US[:-1], MIDDLE[::50]])
    error = np.abs(law.flux_quantile(u) / UNIT_GAS.flux_quantile(u) - 1)
    assert (error < 1e-14 + 2 * 2.0**-53 / (1 - u)).all()  # a function of u cannot know 1 - u any better
    assert (np.abs(law.quantile(u) / UNIT_GAS.flux_quantile(u) - 1) > 0.01).all()


def exponential(u):
    return -np.log1p(-u)


def steps_of_speed(u):
    return np.where(u < 0.3, 100.0, 200.0)


def broken_line(u):
    return np.interp(u, np.linspace(0, 1, 11), np.arange(11.0) ** 2)


def test_an_inverse_cdf_weighs_smooth_and_stepped_functions_by_the_speed():
    u = MIDDLE[::20]
    assert tp.InverseCDF(exponential).flux_quantile(u) == pytest.approx(gammaincinv(2, u), rel=1e-13)
    steps = tp.InverseCDF(steps_of_speed)
    share = 30 / 170  # of the crossers that are slow
    assert steps.mean_speed == pytest.approx(170, rel=1e-14)
    assert steps.flux_quantile(np.array([share - 1e-12, share + 1e-12])).tolist() == [100, 200]
    knots = np.arange(11.0) ** 2
    table = tp.SpeedTable(*histogram(knots))
    assert tp.InverseCDF(broken_line).mean_speed == pytest.approx(
        (knots[1:] + knots[:-1]).mean() / 2, rel=1e-14
    )
    assert tp.InverseCDF(broken_line).flux_quantile(u) == pytest.approx(table.flux_quantile(u), rel=1e-6)


def histogram(knots):
    """A table of the density 1/(10 step) between knots, its jumps made steep."""
    speeds = np.concatenate([(a, b * (1 - 1e-9)) for a, b in zip(knots, knots[1:], strict=False)])
    return speeds, np.repeat(1 / np.diff(knots), 2)


def line(u):
    return 2 * u - 1


def test_negative_speeds_count_by_their_size():
    for law in (tp.SpeedTable((-1, 1), (1, 1)), tp.InverseCDF(line)):
        assert (
            law.is_signed
            and law.mean_speed == pytest.approx(0.5, rel=1e-14)
            and law.fastest == pytest.approx(1)
        )
        assert law.line_quantile(np.array([0.0, 0.75])) == pytest.approx([-1, 0.5], rel=1e-14)
        assert law.flux_quantile(np.array([0, 0.125, 0.875])) == pytest.approx([-1, -(0.75**0.5), 0.75**0.5])
    assert not tp.InverseCDF(exponential).is_signed and not tp.SpeedTable((0, 1), (1, 1)).is_signed


EVERY = [
    UNIT_GAS,
    tp.Maxwellian(temperature=300, mass=4.65e-26, drift=(1, 2, 3)),
    tp.SpeedTable((0, 1, 2), (0, 1, 0)),
    tp.SpeedTable([-5, 1, 2], np.array([3, 1, 0])),
    tp.InverseCDF(exponential),
    tp.InverseCDF(steps_of_speed),
    tp.InverseCDF(line),
]


@pytest.mark.parametrize("law", EVERY, ids=repr)
def test_quantiles_rise_and_stay_below_the_fastest_for_any_u_and_laws_survive_copies(law):
    before = hash(law), law.mean_speed
    u = np.unique(np.concatenate([[0.0, 2.0**-54, LARGEST_U], US, MIDDLE[::10]]))
    for quantile in (law.quantile, law.line_quantile, law.flux_quantile):
        speeds = quantile(u)
        assert speeds.shape == u.shape and np.isfinite(speeds).all()
        assert (np.diff(speeds) >= -1e-12 * np.abs(speeds[1:])).all()
        assert (np.abs(speeds) <= law.fastest).all()
        assert quantile(u.reshape(-1, 1))[:, 0].tolist() == speeds.tolist()
        assert quantile(0.25) == pytest.approx(quantile(np.array([0.25]))[0], rel=1e-15)
    twin = pickle.loads(pickle.dumps(law))
    assert twin == law and (hash(twin), twin.mean_speed) == before == (hash(law), law.mean_speed)
    assert len(set(EVERY)) == len(EVERY)


@pytest.mark.slow
def test_making_distributions_and_meshes_loads_no_special_functions_nor_pictures():
    code = (
        "import sys, transport as tp; tp.Gas(1.0, tp.Maxwellian(temperature=300, mass=1e-26)); tp.SpeedTable((0, 1), (1, 0));"
        " tp.Mesh.sphere(radius=1); names = 'scipy.special', 'scipy.stats', 'numba', 'pyvista';"
        " print([name for name in names if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr


# ---- what the engine draws in a gas ----


def assert_rejected(counts, shares):
    with pytest.raises(AssertionError):
        assert_follows(counts, shares, FALSE_ALARM)


def histories(value):
    """Whole numbers of histories from shares of the one particle that they all stand for."""
    counts = np.asarray(value) * MANY
    np.testing.assert_allclose(counts, np.rint(counts), rtol=0, atol=1e-3)
    return np.rint(counts)


def between(below, edges):
    """Shares of the bins between edges of a law that is given by what lies below."""
    return np.diff(below(np.asarray(edges, float)))


def speeds_below(v, sigma=SIGMA):
    """chi with 3 degrees of freedom: the speeds of a gas."""
    return gammainc(1.5, (v / sigma) ** 2 / 2)


def crossers_below(v, sigma=SIGMA):
    """chi with 4 degrees of freedom: the speeds of what crosses a surface."""
    return gammainc(2.0, (v / sigma) ** 2 / 2)


def edges_of(half_degrees, sigma=SIGMA):
    """Edges of speeds from 0 to beyond the fastest."""
    return np.concatenate([[0.0], sigma * np.sqrt(2 * gammaincinv(half_degrees, SHARES)), [12 * sigma]])


@lru_cache(maxsize=4)
def gas_counts(law, direction=None, shape: Shape = CUBE, **axes):
    """Histories by bins of phase space at time 0, and outside of them as the last."""
    emission = tp.Gas(number=1.0, speed=law, direction=direction)
    found = tp.PhaseSpace(time=0.0, **axes)
    scene = tp.Scene([tp.Source(shape, emission)], [], [found], duration=1.0)
    result = tp.simulate(scene, particles=MANY, seed=1, progress=False)["phase_space"]
    return np.append(histories(result.number.value).ravel(), histories(result.outside.value))


def normal_shares(edges, sigma=SIGMA, mean=0.0):
    """Of a normal component between edges, and beyond them as the last."""
    inside = between(ndtr, (np.asarray(edges) - mean) / sigma)
    return np.append(inside, 1 - inside.sum())


def test_speeds_of_a_gas_are_maxwellian():
    edges = edges_of(1.5)
    counts = gas_counts(GAS, speed=tuple(edges))
    assert_follows(counts, np.append(between(speeds_below, edges), 0.0), FALSE_ALARM)
    for wrong in (
        between(crossers_below, edges),
        between(lambda v: speeds_below(v, 0.99 * SIGMA), edges),
        between(lambda v: speeds_below(v, 1.01 * SIGMA), edges),
    ):
        assert_rejected(counts, np.append(wrong, 1 - wrong.sum()))


@pytest.mark.slow
@pytest.mark.parametrize("drift", [(0.0, 0.0, 0.0), (1.0, -3.0, 0.5)])
def test_velocity_components_are_normal_about_the_drift_and_independent(drift):
    """All three at once, and beyond the edges of any as the last."""
    edges = np.array([-7, -4, -2, -1, 0, 1, 2, 4, 7.0])
    gas = tp.Source(CUBE, tp.Gas(number=1.0, speed=tp.Maxwellian(sigma=SIGMA, drift=drift)))
    shot = tp.Snapshot(0.0, particles=MANY, name="shot")
    run = tp.simulate(tp.Scene(gas, [], shot, duration=1.0), particles=MANY, seed=1, progress=False)
    inside, _ = np.histogramdd(run["shot"].velocities, [edges] * 3)
    counts = np.append(inside.ravel(), MANY - inside.sum())

    def shares(means, sigmas=(SIGMA,) * 3):
        each = [between(ndtr, (edges - mean) / sigma) for mean, sigma in zip(means, sigmas, strict=True)]
        inside = np.einsum("i,j,k->ijk", *each)
        return np.append(inside.ravel(), 1 - inside.sum())

    assert_follows(counts, shares(drift), FALSE_ALARM)
    for axis in np.eye(3):
        assert_rejected(counts, shares(drift + 0.05 * axis))
        assert_rejected(counts, shares(drift, SIGMA * (1 + 0.02 * axis)))


def test_a_fast_stream_keeps_its_width():
    """A drift of a thousand standard deviations: the spread is what is left of a small difference."""
    edges = 1000.0 + np.linspace(-3, 3, 25)
    counts = gas_counts(tp.Maxwellian(sigma=1.0, drift=(0, 0, 1000.0)), vz=tuple(edges))
    assert_follows(counts, normal_shares(edges, 1.0, 1000.0), FALSE_ALARM)


def test_along_a_direction_a_maxwellian_is_one_signed_component():
    direction = np.array([1.0, -2.0, 2.0]) / 3
    edges = np.linspace(-2.5, 2.5, 41)
    counts = gas_counts(GAS, tuple(direction), vx=tuple(edges))
    assert_follows(counts, normal_shares(edges, SIGMA * direction[0]), FALSE_ALARM)
    flipped = gas_counts(GAS, (0.0, 0.0, 1.0), mu=(-1.0, 0.0, 1.0))
    assert_follows(flipped, [0.5, 0.5, 0.0], FALSE_ALARM)
    half = between(lambda v: 2 * ndtr(v / SIGMA) - 1, edges_of(1.5))
    assert_follows(
        gas_counts(GAS, (0.0, 0.0, 1.0), speed=tuple(edges_of(1.5))), np.append(half, 0), FALSE_ALARM
    )
    assert_rejected(counts, normal_shares(edges, 1.01 * SIGMA * direction[0]))


STEPS = tp.SpeedTable((0.0, 1.0, 1.0 + 1e-12, 2.0, 3.0, 3.0 + 1e-12, 3.5), (1, 2, 0, 0, 4, 1, 1))
STEPPED = np.array([0.0, 1.5, 1.5, 3.5, 4.0]) / 4.0  # below 0, 1, 2, 3 and 3.5


def steps_below(v):
    """The integral of the density of STEPS: 1 + v, a gap, 4 (v - 2), 1."""
    v = np.asarray(v, float)
    parts = (v + v**2 / 2, np.full(v.shape, 1.5), 1.5 + 2 * (v - 2) ** 2, 3.5 + (v - 3))
    return np.select([v <= 1, v <= 2, v <= 3], parts[:3], parts[3]) / 4.0


def test_a_table_of_speeds_has_its_slopes_jumps_and_gaps():
    assert np.array_equal(steps_below([0, 1, 2, 3, 3.5]), STEPPED)
    edges = np.concatenate(
        [np.linspace(0, 1, 11)[:-1], [1 + 1e-9], np.linspace(2, 3, 11)[:-1], [3, 3.25, 3.5]]
    )
    counts = gas_counts(STEPS, speed=tuple(edges))
    shares = between(steps_below, edges)
    assert_follows_but_for_gaps(counts, np.append(shares, 0))
    shares[0] += 2e-3
    shares[9] -= 2e-3
    with pytest.raises(AssertionError):
        assert_follows_but_for_gaps(counts, np.append(shares, 0))


def assert_follows_but_for_gaps(counts, shares):
    """Where the share is 0 next to nothing is drawn."""
    there = np.asarray(shares) > 1e-9
    assert counts[~there].sum() <= RARE, "draws within gaps"
    assert_follows(counts[there], shares[there] / shares[there].sum(), FALSE_ALARM)


def test_a_table_with_negative_speeds_flies_the_other_way():
    table = tp.SpeedTable((-2.0, -1.0, 0.0, 1.0), (0, 1, 1, 3))
    edges = np.linspace(-2, 1, 31)
    density = np.interp(edges, table.speeds, table.density)
    shares = np.diff(edges) * (density[1:] + density[:-1]) / 2 / 3.5
    counts = gas_counts(table, (0.0, 0.0, 1.0), vz=tuple(edges))
    assert_follows(counts, np.append(shares, 0), FALSE_ALARM)
    assert_rejected(counts, np.append(shares[::-1], 0))


def twelve_decades(u):
    return 10.0 ** (12 * u - 6)


def two_speeds(u):
    return np.where(u < 0.3, 0.5, 1.0)


def rest_or_fly(u):
    return np.where(u < 0.7, 0.0, 1.0)


@pytest.mark.parametrize(
    ("quantile", "low", "share"), [(two_speeds, 0.5, 0.3), (rest_or_fly, 0.0, 0.7)], ids=["two", "rest"]
)
def test_an_inverse_cdf_with_a_jump_gives_its_two_speeds_and_nothing_else(quantile, low, share):
    speed = tp.InverseCDF(quantile)
    counts = gas_counts(speed, speed=(0.0, low + 1e-9, 1 - 1e-9, 1 + 1e-9, 9.0))
    assert counts[1] <= RARE and counts[3:].sum() == 0
    assert_follows([counts[0], counts[2]], [share, 1 - share], FALSE_ALARM)
    alive = tp.PhaseSpace(x=(-9, 9), time=(0.0, 1.0))
    scene = tp.Scene([tp.Source(CUBE, tp.Gas(number=1.0, speed=speed))], [], [alive], duration=1.0)
    assert (tp.simulate(scene, particles=MANY, seed=1)["phase_space"].alive.value == 1).all()


# ---- through a surface, and from a wall ----


@lru_cache(maxsize=8)
def emitted(emission, shape, edges, side="front"):
    """What leaves a source by speed and cosine, (speeds, cosines) histories, and its reading."""
    looks = tp.Detector(shape, "own", side=side, speeds=edges, directions=tp.Directions(mu=6))
    scene = tp.Scene([tp.Source(shape, emission, side=side)], [], [looks])
    reading = tp.simulate(scene, particles=MANY, seed=1, progress=False)["own"]
    return leaving(reading), reading


def leaving(reading):
    """Histories that leave by speed and cosine; what is outside of the bins of speed leaves none."""
    sums = reading.counts_of("weight out", BINS).sum(axis=0)
    return sums.astype(float)


def with_cosines(shares):
    """Shares of speeds times the cosine law: independent."""
    return np.outer(shares, np.diff(COSINES**2))


def table_crossers(v):
    """The integral of v times the density of STEPS."""
    v = np.asarray(v, float)
    parts = (
        v**2 / 2 + v**3 / 3,
        np.full(v.shape, 5 / 6),
        5 / 6 + 4 * (v**3 / 3 - v**2) + 16 / 3,
        5 / 6 + 16 / 3 + (v**2 - 9) / 2,
    )
    return np.select([v <= 1, v <= 2, v <= 3], parts[:3], parts[3]) / (5 / 6 + 16 / 3 + 13 / 8)


def decade_crossers(v):
    """Of log-uniform speeds from 1e-6 to 1e6, weighted by themselves: uniform."""
    return np.asarray(v) / 1e6


LAWS = {
    "maxwellian": (GAS, edges_of(2.0), crossers_below, speeds_below),
    "table": (STEPS, np.array([0, 0.25, 0.5, 0.75, 1 + 1e-9, 2, 2.25, 2.5, 2.75, 3, 3.5]), table_crossers, steps_below),
    "decades": (
        tp.InverseCDF(twelve_decades),
        np.append(1e-6, np.linspace(0.05, 1, 20) * 1e6),
        decade_crossers,
        lambda v: (np.log10(v) + 6) / 12,
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    ("law", "shape"),
    [
        ("maxwellian", DISK),
        pytest.param(
            "maxwellian", tp.Rectangle(width=1, height=0.5, normal=(1, 2, 2)), marks=pytest.mark.slow
        ),
        ("maxwellian", tp.Sphere(radius=1)),
        ("table", DISK),
        ("decades", DISK),
    ],
)
def test_gas_that_effuses_is_weighted_by_its_speed_on_every_shape(law, shape):
    speed, edges, right, _ = LAWS[law]
    counts, _ = emitted(tp.Effusive(density=3.0, speed=speed), shape, tuple(edges))
    assert_crossers(counts, law)
    shares = between(right, edges)
    assert_rejected(counts, np.outer(shares / shares.sum(), np.diff(COSINES)))


def assert_crossers(counts, law):
    """Speeds by their law and directions by the cosine law; the law without its weight is rejected."""
    _, edges, right, forgotten = LAWS[law]
    assert counts.sum() == MANY
    shares, wrong = between(right, edges), between(forgotten, edges)
    assert_follows_but_for_gaps(counts, with_cosines(shares / shares.sum()))
    assert_rejected(counts.sum(axis=1), wrong / wrong.sum())


def test_a_quarter_of_n_times_the_mean_speed_effuses_not_of_n_times_the_rms_speed():
    _, reading = emitted(tp.Effusive(density=3.0, speed=GAS), DISK, tuple(edges_of(2.0)))
    flux = reading.exitance.sum("speed")
    assert flux.value == pytest.approx(3.0 * effusion.mean_speed(SIGMA) / 4, rel=1e-12)
    mirrors = tp.Surface(tp.Box(size=1.0), tp.Mirror())
    patch = tp.Detector(tp.Disk(radius=0.4), "patch")
    scene = tp.Scene([tp.Source(CUBE, tp.Gas(density=3.0, speed=GAS))], [mirrors], [patch], duration=1.0)
    crossed = tp.simulate(scene, particles=100_000, seed=1)["patch"]
    for one_way in (crossed.irradiance, crossed.exitance):
        assert_agrees(one_way, 3.0 * effusion.mean_speed(SIGMA) / 4, FALSE_ALARM)
        with pytest.raises(AssertionError):
            assert_agrees(one_way, 3.0 * math.sqrt(3) * SIGMA / 4, FALSE_ALARM)
    assert_agrees(crossed.net_flux_density, 0.0, FALSE_ALARM)


def test_a_moving_plane_of_a_maxwellian_sends_out_its_crossers():
    """Through a tilted plane: the normal component weighted by itself, both tangential ones normal about the drift."""
    normal, drift = np.array([2.0, 1.0, 2.0]) / 3, np.array([1.5, -1.0, 0.5])
    for side, sign in (("front", 1.0), ("back", -1.0)):
        disk = tp.Disk(radius=0.5, normal=tuple(normal))
        through = sign * float(drift @ normal)
        emission = tp.Effusive(number=1.0, speed=tp.Maxwellian(sigma=1.0, drift=tuple(drift)))
        shot = tp.Snapshot(0.0, particles=MANY)
        source = tp.Source(disk, emission, side=side, pulse=tp.Instant())
        v = tp.simulate(tp.Scene(source, [], shot, duration=1.0), particles=300_000, seed=1)[
            "snapshot"
        ].velocities
        e_u, e_v, _ = disk.frame
        w = sign * v @ normal
        assert (w > 0).all()
        edges = np.append(normal_law.crossing_quantile(np.linspace(0, 0.95, 20), through), 20.0)
        shares = 1 - crossing_above(edges, through) / normal_law.crossing_rate(through)
        tangential = [(v @ e - drift @ e) for e in (e_u, e_v)]
        t_edges = np.array([-9, -1.5, -0.5, 0, 0.5, 1.5, 9])
        counts, _ = np.histogramdd([w, *tangential], bins=[edges, t_edges, t_edges])
        parts = [np.diff(shares), np.diff(ndtr(t_edges)), np.diff(ndtr(t_edges))]
        assert counts.sum() == 300_000
        assert_follows(counts, np.einsum("i,j,k->ijk", *parts), FALSE_ALARM)
        still = np.diff(1 - crossing_above(edges, 0.0) / normal_law.crossing_rate(0.0))
        assert_rejected(counts.sum(axis=(1, 2)), still / still.sum())
        parts[1] = np.diff(ndtr(t_edges + 0.05))
        assert_rejected(counts, np.einsum("i,j,k->ijk", *parts))


def crossing_above(w, drift):
    """The part of a gas with this drift through a plane that crosses faster than w, in standard deviations."""
    density = np.exp(-0.5 * (w - drift) ** 2) / math.sqrt(2 * math.pi)
    return density + drift * ndtr(drift - w)


def reflected(material, edges):
    """What a wall sends back of a beam of 3 m/s, by speed and cosine."""
    wall = tp.Rectangle(width=1.0, height=1.0, center=(0, 0, 1), normal=(0, 0, -1))
    beam = tp.Gas(number=1.0, speed=3.0, direction=(0.3, 0, 0.8))
    look = tp.Detector("wall", speeds=edges, directions=tp.Directions(mu=6))
    surface = tp.Surface(wall, material, "wall")
    scene = tp.Scene([tp.Source(tp.Point(), beam)], [surface], [look], duration=1.0)
    return tp.simulate(scene, particles=MANY, seed=1, progress=False)["wall"]


@pytest.mark.parametrize("law", LAWS)
def test_a_thermal_wall_gives_off_speeds_weighted_by_themselves_by_the_cosine_law(law):
    speed, edges, *_ = LAWS[law]
    assert_crossers(leaving(reflected(tp.Diffuse(1.0, speed=speed), tuple(edges))), law)


def test_a_wall_with_a_number_for_its_speed_gives_off_that_and_one_without_keeps_it():
    edges = (0.0, 1.9, 2.1, 2.9, 3.1)
    for material, speeds in ((tp.Diffuse(0.6, speed=2.0), [0, 0.6, 0, 0]), (tp.Diffuse(0.6), [0, 0, 0, 0.6])):
        reading = reflected(material, edges)
        np.testing.assert_allclose(reading.energy_out.value, speeds, rtol=1e-12)
        np.testing.assert_allclose(reading.energy_in.value, [0, 0, 0, 1], rtol=1e-12)


# ---- tables of quantiles ----


def drawn_at(quantile, us):
    """What the engine makes of uniform numbers, by the pass that a scene with this law calls for."""
    octaves, cells = quantile_table(quantile)
    drawing = set_speed_by_stepped_quantile if has_split_cells(quantile) else set_speed_by_quantile
    table = layout.row(
        layout.QUANTILES,
        octaves=octaves.ctypes.data,
        octave_count=len(octaves),
        cells=cells.ctypes.data,
        cell_count=len(cells),
    )
    step = ctypes.CFUNCTYPE(ctypes.c_int64, *[ctypes.c_void_p] * 2, *[ctypes.c_uint64] * 2)(drawing.entry)
    bundle, speeds = empty_bundle(), []
    for begin in range(0, len(us), LANES):
        some = us[begin : begin + LANES]
        bundle["u0"][0, : len(some)] = some
        assert step(int(bundle["address"][0]), table.ctypes.data, 0, len(some)) == len(some)
        speeds.append(bundle["speed"][0, : len(some)].copy())
    return np.concatenate(speeds)


@pytest.mark.parametrize("name", TAILS_OF)
def test_tables_of_speeds_are_those_of_mpmath_to_a_trillionth_in_both_tails(name):
    tails = 2.0 ** -np.arange(2.0, 53.0)
    us = np.concatenate(
        [tails, 1.37 * tails, 1 - tails, 1 - 1.37 * tails[:-3], np.random.default_rng(1).random(60)]
    )
    us = us[np.abs(us - 0.5) > 1e-3]  # where a component is 0, its relative error means nothing
    speeds = drawn_at(getattr(GAS, name), us) / SIGMA
    limits = 1e-12 + np.where(us > 0.5, 2.0**-51 / (1 - us), 0.0)  # u itself is no finer
    law = chi(TAILS_OF[name])
    for speed, u, limit in zip(speeds, us, limits, strict=True):
        assert worst_error([speed], *law, [u], digits=40) < limit
        assert worst_error([speed * (1 + 2e-12)], *law, [u], digits=40) > 1e-12


@pytest.mark.parametrize(
    "quantile", [GAS.quantile, GAS.flux_quantile, GAS.line_quantile, STEPS.quantile, twelve_decades, two_speeds, rest_or_fly]
)  # fmt: skip
def test_draws_never_fall_with_u_nor_leave_the_range_of_their_law(quantile):
    """At the ends, and at a hundred thousand places between."""
    us = np.unique(
        np.concatenate([[0.0, 2.0**-52, 0.5, 1 - 2.0**-52], np.random.default_rng(1).random(100_000)])
    )
    speeds = drawn_at(quantile, us)
    lowest, highest = quantile(np.array([2.0**-54, 1 - 2.0**-53]))
    assert np.isfinite(speeds).all()
    slack = 1e-12 * max(abs(lowest), abs(highest))
    assert lowest - slack <= speeds.min() and speeds.max() <= highest + slack
    assert (np.diff(speeds) >= -slack).all()


V_SHAPED = tp.SpeedTable((1, 2, 3.1), (1, 0, 1))
BUMPS = tp.SpeedTable((0, 1, 2, 3, 4, 5), (0, 2, 0, 0, 1, 0))
ZEROS = {  # law, share below the zero, how its share grows from there: by speed above it (negative: below), by its power
    "above a touch": (V_SHAPED, 0.5 / 1.05, lambda d: d**2 / 2.2 / 1.05),
    "below a touch": (V_SHAPED, 0.5 / 1.05, lambda d: -(d**2) / 2 / 1.05),
    "above a gap": (BUMPS, 2 / 3, lambda d: d**2 / 6),
    "below a gap": (BUMPS, 2 / 3, lambda d: -(d**2) / 3),
    "above the lowest": (BUMPS, 0.0, lambda d: d**2 / 3),
    "above a jump": (STEPS, 3.5 / 4, lambda d: d / 4),
    "below a jump": (STEPS, 3.5 / 4, lambda d: ((1 + d) ** 2 - 1) / 2),
}
PLACES = {name: 2.0 for name in ZEROS} | {
    "above a gap": 3.0, "above the lowest": 0.0, "above a jump": 3.0, "below a jump": 3.0,
}  # fmt: skip


@pytest.mark.parametrize("name", ZEROS)
@pytest.mark.parametrize("reach", [0.1, 0.01, 0.002])
def test_speeds_next_to_a_zero_a_gap_or_a_jump_of_the_density_follow_it(name, reach):
    """Their quantile goes as a root of u - u0 there, which no polynomial does: within 2^-12 of all draws the density was a
    constant.  Of a million draws a few hundred fall there; so u is drawn next to u0 alone.
    """
    law, start, grown = ZEROS[name]
    sign = -1.0 if name.startswith("below") else 1.0
    ends = sign * reach * np.linspace(0, 1, 11)
    shares = np.array([grown(d) for d in ends])
    us = start + shares[-1] * np.random.default_rng(1).random(40_000)
    off = sign * (drawn_at(law.quantile, us) - PLACES[name])
    counts = np.histogram(off, np.append(-1e-9, np.abs(ends[1:])))[
        0
    ]  # at the zero itself roundings are of both signs
    assert counts.sum() >= 0.999 * len(us)
    assert_follows(counts, np.diff(shares) / shares[-1], FALSE_ALARM)


# ---- aimed ----


def test_gas_that_effuses_towards_an_aim_is_what_reaches_it_unaimed_at_two_kT_each():
    """The aim picks directions; speeds stay those of crossers, and flux that of the cosine law and the exact share."""
    here, there = tp.Disk(radius=0.5), tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.6)
    share = coaxial_disks(0.5, 0.6, 1.0)
    found = []
    for aim in (None, there):
        source = tp.Source(here, tp.Effusive(density=3.0, speed=GAS), aim=aim)
        meter = tp.Detector(there, "there", moments=True)
        reading = tp.simulate(tp.Scene(source, [], meter), particles=200_000, seed=1, progress=False)["there"]
        exact = share * 3.0 * effusion.mean_speed(SIGMA) / 4 * math.pi * 0.25
        assert_agrees(reading.flux_in, exact, FALSE_ALARM)
        assert_agrees(reading.mean_square_speed_in, 4 * SIGMA**2, FALSE_ALARM)
        assert_agrees(reading.mean_speed_in, effusion.mean_speed_of_crossers(SIGMA), FALSE_ALARM)
        with pytest.raises(AssertionError):
            assert_agrees(reading.mean_square_speed_in, 3 * SIGMA**2, FALSE_ALARM)
        found.append(reading.flux_in)
    assert found[1].error < 0.5 * found[0].error
    assert abs(found[1].value - found[0].value) < 5 * math.hypot(found[0].error, found[1].error)
