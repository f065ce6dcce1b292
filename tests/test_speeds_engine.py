"""Speeds as the engine draws them: every distribution against its own law by chi-square, its tables against mpmath.

All runs have seed 1 and a million particles, which show an error of 1 % in the width of a law.  Each judgement fails
right code in one of 10^6 seeds.
"""

from __future__ import annotations

import ctypes
import math
from functools import lru_cache

import mpmath as mp
import numpy as np
import pytest
from scipy.special import gammainc, gammaincinv, ndtr

import transport as tp
from tests.agreement import assert_agrees, assert_follows
from transport.compile import layout
from transport.compile.speeds import has_split_cells, quantile_table
from transport.engine.bundle import LANES, empty_bundle
from transport.engine.passes.velocities import set_speed_by_quantile, set_speed_by_stepped_quantile
from transport.geometry.shape import Shape
from transport.results.detectors import BINS
from transport.statistics import normal as normals
from transport.theory import effusion
from transport.theory.view_factors import coaxial_disks

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


# ---- in a gas ----


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


def pair_shares(first, second):
    """Of two independent components, and beyond the edges of either as the last."""
    inside = np.outer(first[:-1], second[:-1])
    return np.append(inside.ravel(), 1 - inside.sum())


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


@pytest.mark.parametrize("pair", [("vx", "vy"), ("vy", "vz"), ("vx", "vz")])
@pytest.mark.parametrize("drift", [(0.0, 0.0, 0.0), (1.0, -3.0, 0.5)])
def test_velocity_components_are_normal_about_the_drift_and_independent(pair, drift):
    edges = np.linspace(-7, 7, 15)
    counts = gas_counts(tp.Maxwellian(sigma=SIGMA, drift=drift), **dict.fromkeys(pair, tuple(edges)))
    means = dict(zip(("vx", "vy", "vz"), drift, strict=True))
    shares = [normal_shares(edges, mean=means[name]) for name in pair]
    assert_follows(counts, pair_shares(*shares), FALSE_ALARM)
    assert_rejected(counts, pair_shares(normal_shares(edges, mean=means[pair[0]] + 0.05), shares[1]))
    assert_rejected(counts, pair_shares(shares[0], normal_shares(edges, 1.02 * SIGMA, means[pair[1]])))


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


def test_speeds_over_twelve_decades_follow_their_inverse_cdf():
    edges = 10.0 ** np.linspace(-6, 6, 49)
    counts = gas_counts(tp.InverseCDF(twelve_decades), speed=tuple(edges))
    shares = np.full(48, 1 / 48)
    assert_follows(counts, np.append(shares, 0), FALSE_ALARM)
    shares[:24] *= 1.02
    shares[24:] *= 0.98
    assert_rejected(counts, np.append(shares, 0))


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


# ---- through a surface ----


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
    "shape", [DISK, tp.Rectangle(width=1, height=0.5, normal=(1, 2, 2)), tp.Sphere(radius=1)]
)
def test_what_effuses_from_a_gas_is_weighted_by_its_speed_on_every_shape(shape):
    assert_crossers("maxwellian", shape)


@pytest.mark.parametrize("law", ["table", "decades"])
def test_what_effuses_follows_any_law_weighted_by_its_speed(law):
    assert_crossers(law, DISK)


def assert_crossers(law, shape):
    speed, edges, right, forgotten = LAWS[law]
    counts, _ = emitted(tp.Effusive(density=3.0, speed=speed), shape, tuple(edges))
    assert counts.sum() == MANY
    shares = between(right, edges)
    assert_follows_but_for_gaps(counts, with_cosines(shares / shares.sum()))
    wrong = between(forgotten, edges)
    assert_rejected(counts.sum(axis=1), wrong / wrong.sum())
    assert_rejected(counts, np.outer(shares / shares.sum(), np.diff(COSINES)))


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
        edges = np.append(normals.crossing_quantile(np.linspace(0, 0.95, 20), through), 20.0)
        shares = 1 - crossing_above(edges, through) / normals.crossing_rate(through)
        tangential = [(v @ e - drift @ e) for e in (e_u, e_v)]
        t_edges = np.array([-9, -1.5, -0.5, 0, 0.5, 1.5, 9])
        counts, _ = np.histogramdd([w, *tangential], bins=[edges, t_edges, t_edges])
        parts = [np.diff(shares), np.diff(ndtr(t_edges)), np.diff(ndtr(t_edges))]
        assert counts.sum() == 300_000
        assert_follows(counts, np.einsum("i,j,k->ijk", *parts), FALSE_ALARM)
        still = np.diff(1 - crossing_above(edges, 0.0) / normals.crossing_rate(0.0))
        assert_rejected(counts.sum(axis=(1, 2)), still / still.sum())
        parts[1] = np.diff(ndtr(t_edges + 0.05))
        assert_rejected(counts, np.einsum("i,j,k->ijk", *parts))


def crossing_above(w, drift):
    """The part of a gas with this drift through a plane that crosses faster than w, in standard deviations."""
    density = np.exp(-0.5 * (w - drift) ** 2) / math.sqrt(2 * math.pi)
    return density + drift * ndtr(drift - w)


@pytest.mark.parametrize("drift", [-3.0, -0.7, 0.0, 0.7, 3.0])
def test_as_much_crosses_a_plane_of_a_drifting_gas_as_an_effusive_source_sends(drift):
    speed = tp.Maxwellian(sigma=1.0, drift=(0.3, 0.0, drift))
    scene = tp.Scene([tp.Source(DISK, tp.Effusive(density=2.0, speed=speed))], [], [tp.Detector(DISK, "own")])
    exact = effusion.drifting_flux_density(2.0, 1.0, drift)
    assert tp.simulate(scene, particles=1000)["own"].exitance.value == pytest.approx(exact, rel=1e-12)


# ---- from a wall ----


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
    speed, edges, right, forgotten = LAWS[law]
    counts = leaving(reflected(tp.Diffuse(1.0, speed=speed), tuple(edges)))
    shares = between(right, edges)
    assert counts.sum() == MANY
    assert_follows_but_for_gaps(counts, with_cosines(shares / shares.sum()))
    wrong = between(forgotten, edges)
    assert_rejected(counts.sum(axis=1), wrong / wrong.sum())


def test_a_wall_with_a_number_for_its_speed_gives_off_that_and_one_without_keeps_it():
    edges = (0.0, 1.9, 2.1, 2.9, 3.1)
    for material, speeds in ((tp.Diffuse(0.6, speed=2.0), [0, 0.6, 0, 0]), (tp.Diffuse(0.6), [0, 0, 0, 0.6])):
        reading = reflected(material, edges)
        np.testing.assert_allclose(reading.energy_out.value, speeds, rtol=1e-12)
        np.testing.assert_allclose(reading.energy_in.value, [0, 0, 0, 1], rtol=1e-12)


# ---- tables ----


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


def chi(degrees):
    """Below, above and density of chi in high precision."""
    a = mp.mpf(degrees) / 2

    def below(x):
        return mp.gammainc(a, 0, x * x / 2, regularized=True)

    def above(x):
        return mp.gammainc(a, x * x / 2, regularized=True)

    def density(x):
        return 2 ** (1 - a) / mp.gamma(a) * x ** (degrees - 1) * mp.exp(-x * x / 2)

    return below, above, density


NORMAL = (lambda x: mp.ncdf(x), lambda x: mp.ncdf(-x), mp.npdf)
TABLES = {
    "speeds": (GAS.quantile, chi(3)),
    "crossers": (GAS.flux_quantile, chi(4)),
    "component": (GAS.line_quantile, NORMAL),
}


def errors(speeds, us, law):
    """Relative errors, by a step of Newton's on the nearer tail in 40 digits."""
    below, above, density = law
    found = []
    with mp.workdps(40):
        for speed, u in zip(map(float, speeds), map(float, us), strict=True):
            x = mp.mpf(speed) / SIGMA
            off = mp.mpf(u) - below(x) if u < 0.5 else above(x) - (1 - mp.mpf(u))
            found.append(abs(float(off / density(x) / x)))
    return np.array(found)


@pytest.mark.parametrize("name", TABLES)
def test_tables_of_speeds_are_those_of_mpmath_to_a_trillionth_in_both_tails(name):
    quantile, law = TABLES[name]
    tails = 2.0 ** -np.arange(2.0, 53.0)
    middle = np.random.default_rng(1).random(60)
    us = np.concatenate([tails, 1.37 * tails, 1 - tails, 1 - 1.37 * tails[:-3], middle])
    us = us[np.abs(us - 0.5) > 1e-3]  # where a component is 0, its relative error means nothing
    speeds = drawn_at(quantile, us)
    limits = 1e-12 + np.where(us > 0.5, 2.0**-51 / (1 - us), 0.0)  # u itself is no finer
    assert (errors(speeds, us, law) < limits).all()
    assert (errors(speeds * (1 + 2e-12), us, law) > 1e-12).all()


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


# ---- next to where there is nothing ----

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


def test_what_effuses_towards_an_aim_is_what_reaches_it_unaimed_at_two_kT_each():
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
