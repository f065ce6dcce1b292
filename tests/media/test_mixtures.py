"""Mixtures: each particle that arrives meets one of the materials, and each that collides one of the phase functions, by its share.

All runs have seed 1.  Each judgement fails right code in one of 10^6 seeds; numbers of histories follow their
shares as binomial and multinomial numbers do.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from scipy.special import gammainc, gammaincinv

import transport as tp
from tests.agreement import assert_agrees, assert_follows, smallest_bias
from transport.results.detectors import BINS
from transport.results.tally import ARRIVALS, DEPARTURES, SIDES
from transport.theory import enclosures, phases
from transport.units import BOLTZMANN

FALSE_ALARM = 1e-6
PARTICLES = 200_000
WALL = tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=2.0, height=2.0)
BEHIND = tp.Rectangle(center=(0, 0, 2), normal=(0, 0, -1), width=2.0, height=2.0)


def run(scene, particles=PARTICLES):
    return tp.simulate(scene, particles=particles, seed=1, progress=False)


def counts(reading, side=ARRIVALS):
    return reading.counts_of(f"weight {SIDES[side]}").sum(axis=0)


@lru_cache(maxsize=8)
def shone_on(material, direction=(0.1, 0.2, 1.0)):
    """A wall in a beam, and a black one behind it."""
    beam = tp.Source(tp.Point(), tp.Beam(direction=direction, power=1.0))
    surfaces = [tp.Surface(WALL, material, "wall"), tp.Surface(BEHIND, tp.Black(), "behind")]
    looks = [
        tp.Detector("wall", directions=tp.Directions(mu=10)),
        tp.Detector("wall", "back of it", side="back"),
        tp.Detector("behind"),
    ]
    return run(tp.Scene(beam, surfaces, looks))


# ---- shares ----


def fates(result):
    """Numbers of histories that passed, that came back along the mirrored beam, otherwise, and that stayed."""
    beam_bin = int(10 / np.sqrt(1.05))
    back = result["wall"].counts_of("weight out", BINS).sum(axis=0)
    passed = counts(result["behind"])
    assert counts(result["back of it"], DEPARTURES) == passed
    return np.array([passed, back[beam_bin], back.sum() - back[beam_bin], PARTICLES - passed - back.sum()])


@pytest.mark.parametrize(
    "shares", [(0.2, 0.5, 0.3), (1 / 3, 1 / 3, 1 / 3), (0.9, 0.0, 0.1), (1e-3, 0.998, 1e-3)]
)
def test_each_material_is_met_by_its_share_of_the_particles(shares):
    """Binomial for each of them: passed, mirrored, absorbed."""
    clear, mirror, black = shares
    mixture = tp.Mixture({tp.Transparent(): clear, tp.Mirror(): mirror, tp.Black(): black})
    result = shone_on(mixture)
    passed, mirrored, elsewhere, stayed = fates(result)
    assert elsewhere == 0
    found, expected = np.array([passed, mirrored, stayed]), np.array(shares)
    there = expected > 0
    assert (found[~there] == 0).all()
    assert_follows(found[there], expected[there], FALSE_ALARM)
    wrong = expected[there] + np.r_[0.012, -0.012, np.zeros(there.sum() - 2)]
    with pytest.raises(AssertionError):
        assert_follows(found[there], np.abs(wrong) / np.abs(wrong).sum(), FALSE_ALARM)
    absorbed = result.ledger.absorbed_by["wall"].value * PARTICLES
    assert absorbed == pytest.approx(stayed, abs=1e-6)


def test_shares_do_not_depend_on_their_order_and_a_mixture_of_one_material_is_that_material():
    parts = {tp.Transparent(): 0.2, tp.Mirror(): 0.25, tp.Diffuse(0.5): 0.25, tp.Black(): 0.3}
    orders = [dict(parts), dict(reversed(parts.items()))]
    one, other = (fates(shone_on(tp.Mixture(order))) for order in orders)
    np.testing.assert_array_equal(one, other)
    alone = fates(shone_on(tp.Mixture({tp.Mirror(): 1.0})))
    np.testing.assert_array_equal(alone, fates(shone_on(tp.Mirror())))
    both = shone_on(tp.Mixture({tp.Mirror(0.5): 0.5, tp.Mirror(0.500001): 0.5}))["wall"].flux_out.value
    assert both == pytest.approx(0.5, rel=1e-5)


def test_choices_at_later_walls_are_new_ones():
    """Between two half mirrors a tenth of a per cent still flies after ten of them: shares multiply."""
    half = tp.Mixture({tp.Mirror(): 0.5, tp.Black(): 0.5})
    pair = [
        tp.Surface(tp.Disk(center=(0, 0, z), normal=(0, 0, -z), radius=1.0), half, n)
        for z, n in ((1.0, "up"), (-1.0, "down"))
    ]
    beam = tp.Source(tp.Point(), tp.Beam(direction=(0, 0, 1), power=1.0))
    looks = [tp.Detector(n, f"{n} {k}", events=k) for k in range(8) for n in ("up", "down")]
    result = run(tp.Scene(beam, pair, looks))
    met = np.array([counts(result[f"{'down' if k % 2 else 'up'} {k}"]) for k in range(8)])
    ended = np.append(met[:-1] - met[1:], met[-1])
    assert met[0] == PARTICLES
    assert_follows(ended, np.append(0.5 ** np.arange(1, 8), 0.5**7), FALSE_ALARM)


# ---- a share that absorbs, and an albedo ----


@pytest.mark.parametrize("absorbed", [0.2, pytest.param(0.7, marks=pytest.mark.slow)])
def test_a_share_of_black_is_what_an_albedo_below_one_is(absorbed):
    """In a closed box: what arrives everywhere is the closed form for both, and so is each wall's part for one another."""
    found = {}
    for name, material in {
        "mixture": tp.Mixture({tp.Black(): absorbed, tp.Diffuse(1.0): 1 - absorbed}),
        "albedo": tp.Diffuse(1 - absorbed),
    }.items():
        walls = [tp.Surface(f, material, n) for n, f in tp.Box(size=(1.0, 2.0, 1.5)).faces().items()]
        looks = [tp.Detector(w.name, side="back", directions=tp.Directions(mu=3)) for w in walls]
        lamp = tp.Source("-x", tp.Lambertian(power=1.0), side="back")
        result = run(tp.Scene(lamp, walls, looks))
        fluxes = [result[w.name].flux_in for w in walls]
        total = sum(fluxes[1:], fluxes[0])
        assert_agrees(total, enclosures.total_flux_in(1.0, 1 - absorbed), FALSE_ALARM)
        assert smallest_bias(total, FALSE_ALARM) < 0.02
        found[name] = [*fluxes, *(result[w.name].radiance for w in walls), result.ledger.absorbed_by["+x"]]
    for one, other in zip(found["mixture"], found["albedo"], strict=True):
        assert_agrees(one - other, 0.0, FALSE_ALARM)
        with pytest.raises(AssertionError):
            assert_agrees(one - other * 1.1, 0.0, FALSE_ALARM)


# ---- accommodation ----

COLD = tp.Maxwellian(temperature=200.0, mass=5e-26)
WARM = tp.Maxwellian(temperature=600.0, mass=5e-26)


@lru_cache(maxsize=4)
def accommodated(share):
    """Cold gas that effuses onto a warm wall, which accommodates a share of it."""
    parts = {tp.Mirror(): 1 - share, tp.Diffuse(1.0, speed=WARM): share}
    source = tp.Source(tp.Disk(radius=0.5), tp.Effusive(exitance=1.0, speed=COLD))
    edges = (0.0, *np.sqrt(2 * gammaincinv(2.0, np.arange(0.05, 1, 0.05))) * WARM.sigma, 12 * WARM.sigma)
    looks = [tp.Detector("wall", moments=True), tp.Detector("wall", "speeds", speeds=edges)]
    wide = tp.Rectangle(center=(0, 0, 0.5), normal=(0, 0, -1), width=20.0, height=20.0)
    return run(tp.Scene(source, tp.Surface(wide, tp.Mixture(parts), "wall"), looks)), np.array(edges)


@pytest.mark.parametrize("share", [0.0, 0.3, *(pytest.param(s, marks=pytest.mark.slow) for s in (0.8, 1.0))])
def test_gas_leaves_a_wall_as_the_mixture_of_what_arrived_and_what_is_thermal(share):
    """Mean energies of crossers are 2 kT (Reif 1965, 7.12); the share is the energy accommodation coefficient."""
    result, edges = accommodated(share)
    wall, arrived, thermal = result["wall"], 2 * BOLTZMANN * 200.0, 2 * BOLTZMANN * 600.0
    assert_agrees(wall.mean_energy_in, arrived, FALSE_ALARM)
    assert_agrees(wall.mean_energy_out, (1 - share) * arrived + share * thermal, FALSE_ALARM)
    if share not in (
        0.0,
        1.0,
    ):  # energies of a gas at rest, not of what crosses: the weighting by speed forgotten
        with pytest.raises(AssertionError):
            assert_agrees(wall.mean_energy_out, (1 - share) * arrived + share * 0.75 * thermal, FALSE_ALARM)
    assert abs(((wall.mean_energy_out - wall.mean_energy_in) / (thermal - arrived)).value - share) < 0.02
    assert wall.flux_out.value == pytest.approx(wall.flux_in.value, rel=1e-14)
    cold, warm = (np.diff(gammainc(2.0, (edges / gas.sigma) ** 2 / 2)) for gas in (COLD, WARM))
    left = counts(result["speeds"], DEPARTURES)
    assert_follows(left, (1 - share) * cold + share * warm, FALSE_ALARM)
    assert_follows(counts(result["speeds"]), cold, FALSE_ALARM)
    other = abs(0.97 - share)
    with pytest.raises(AssertionError):
        assert_follows(left, other * cold + (1 - other) * warm, FALSE_ALARM)


def test_a_gas_in_a_box_of_accommodating_walls_takes_their_temperature():
    """Cold at first; after many flights its energy is that of the walls, whatever they accommodate."""
    parts = {tp.Mirror(): 0.4, tp.Diffuse(1.0, speed=WARM): 0.6}
    walls = tp.Surface(tp.Box(size=1.0), tp.Mixture(parts), "wall")
    gas = tp.Source(tp.Box(size=1.0), tp.Gas(density=1e20, speed=COLD))
    look = tp.PhaseSpace(x=(-0.5, 0.0, 0.5), time=(0.0, 0.15), within=tp.Box(size=1.0), moments=True)
    scene = tp.Scene(
        gas, walls, [look, tp.Detector("wall", side="back", moments=True, times=(0.1, 0.15))], duration=0.15
    )
    result = run(scene, 50_000)
    found = result["phase_space"]
    assert_agrees(found.temperature[0], 200.0, FALSE_ALARM)
    assert_agrees(found.temperature[1], 600.0, FALSE_ALARM)
    assert_agrees(found.pressure[1], 1e20 * BOLTZMANN * 600.0, FALSE_ALARM)
    assert_agrees(result["wall"].pressure[0], 1e20 * BOLTZMANN * 600.0, FALSE_ALARM)


# ---- phase functions ----

SCATTERING = 1e-3  # of a ball of radius 1: what is scattered twice is a thousandth
MU = np.array([-1.0, -0.6, 0.0, 0.6, 1.0])
PARTS = {
    tp.HenyeyGreenstein(0.8): (0.5, lambda mu: phases.henyey_greenstein_share(mu, 0.8)),
    tp.HenyeyGreenstein(-0.7): (0.3, lambda mu: phases.henyey_greenstein_share(mu, -0.7)),
    tp.Rayleigh(): (0.2, phases.rayleigh_share),
}


def scattered_once(phase):
    """Shares of what a ball of thin fog scatters of a beam along +z, by its angle, ahead first."""
    fog = tp.Medium(scattering=SCATTERING, phase=phase)
    ball = tp.Surface(tp.Sphere(radius=1.0), tp.Transparent(), inside=fog)
    beam = tp.Source(tp.Point(position=(0, 0, -5)), tp.Beam(direction=(0, 0, 1), power=1.0))
    angles = tuple(np.arccos(MU[::-1]))
    sky = tp.Detector(
        tp.Sphere(radius=1e3), "sky", side="inside", events=(1, 1), positions=tp.Positions(u=angles)
    )
    scene = tp.Scene(beam, ball, sky)
    run = tp.simulate(scene, 100_000, seed=1, tracking=tp.Tracking(forced=True), progress=False)
    seen = run["sky"].irradiance
    return seen * sky.positions.areas(sky.shape).reshape(seen.shape) / run["sky"].flux_in


def test_each_phase_function_scatters_by_its_share():
    shares = scattered_once(tp.Mixture({phase: share for phase, (share, _) in PARTS.items()}))
    exact = sum(share * np.diff(law(MU)) for share, law in PARTS.values())[::-1]
    assert_agrees(shares, exact.reshape(shares.shape), FALSE_ALARM)
    alone = np.diff(phases.rayleigh_share(MU))[::-1]
    with pytest.raises(AssertionError):
        assert_agrees(shares, (exact + 0.05 * (alone - exact)).reshape(shares.shape), FALSE_ALARM)
