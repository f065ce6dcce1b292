"""The clock: pulses, arrival times, energies by bin of time, steady sources that have just been switched on.

All runs have seed 1.  Each judgement fails right code in one of 10^6 seeds; what is a law of every history is asked
of integers.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest
from scipy.special import ndtr

import transport as tp
from tests.agreement import assert_agrees, assert_follows
from transport.results.detectors import BINS
from transport.results.tally import ARRIVALS, DEPARTURES, SIDES
from transport.theory import emitters

FALSE_ALARM = 1e-6
PARTICLES = 1_000_000


def run(scene, particles=PARTICLES):
    return tp.simulate(scene, particles=particles, seed=1, progress=False)


def counts(reading, side=ARRIVALS):
    """Histories by bin of time and speed, over all that was binned within."""
    return reading.counts_of(f"weight {SIDES[side]}").sum(axis=0)


# ---- pulses: a point amid a sphere, which all of it reaches at the distance 1 and the speed 1 ----

PULSES = {
    "instant": (tp.Instant(2.05), lambda t: np.where(t > 3.05, 1.0, 0.0)),
    "box": (tp.BoxPulse(0.5, 2.25), lambda t: np.clip((t - 1.5) / 1.75, 0, 1)),
    "gaussian": (tp.GaussianPulse(3.0, 0.35), lambda t: ndtr((t - 4.0) / 0.35)),
    "steady": (None, lambda t: np.clip((t - 1) / 6.0, 0, 1)),
}
DURATION = 6.0
TIMES = np.concatenate([[0.0, 0.9, 1.5], np.linspace(1.6, 5.6, 41), [5.75, 6.0]])


@lru_cache(maxsize=8)
def flash(pulse):
    """A point of one joule within a sphere."""
    source = tp.Source(tp.Point(), tp.Isotropic(energy=1.0, speed=1.0), pulse=pulse)
    meter = tp.Detector(tp.Sphere(radius=1.0), "sphere", side="inside", times=TIMES)
    return run(tp.Scene(source, [], meter, duration=DURATION))


def shares(law, times):
    """Of the bins of time, and of what has not arrived at the end."""
    below = law(np.append(times, math.inf))
    return np.diff(below)


@pytest.mark.parametrize("name", PULSES)
def test_pulses_arrive_a_flight_later_in_their_own_shape(name):
    pulse, law = PULSES[name]
    result = flash(pulse)
    arrived = counts(result["sphere"])
    late = PARTICLES - arrived.sum()
    assert result.ledger["in_flight"].value == pytest.approx(1.0)  # then or later, all fly on outside
    judged = np.append(arrived, late)
    assert_follows_or_is_certain(judged, shares(law, TIMES))
    half = np.diff(TIMES).max() / 2
    for wrong in (lambda t: law(t - half), lambda t: law(t + half)):
        with pytest.raises(AssertionError):
            assert_follows_or_is_certain(judged, shares(wrong, TIMES))


def assert_follows_or_is_certain(judged, expected):
    """Chi-square; or, where all lies in one bin, that all does."""
    if expected.max() == 1:
        assert (judged == PARTICLES * expected).all()
    else:
        assert_follows(judged, expected, FALSE_ALARM)


def test_a_bin_of_time_that_is_half_a_step_off_is_rejected():
    """Bins of 1/7 of the pulse: half a step is all that is wrong."""
    _, law = PULSES["gaussian"]
    arrived = np.append(counts(flash(PULSES["gaussian"][0])["sphere"]), 0)
    assert_follows(arrived, shares(law, TIMES), FALSE_ALARM)
    step = 0.1
    for off in (-step / 2, step / 2):
        with pytest.raises(AssertionError, match="chi-square"):
            assert_follows(arrived, shares(lambda t, off=off: law(t - off), TIMES), FALSE_ALARM)


@pytest.mark.parametrize("name", ["box", "gaussian", "steady"])
def test_energy_in_a_bin_is_its_share_and_the_flux_its_mean_over_the_bin(name):
    pulse, law = PULSES[name]
    reading = flash(pulse)["sphere"]
    expected = shares(law, TIMES)[:-1]
    sure = expected * PARTICLES > 100
    assert_agrees(reading.energy_in[sure.argmax() + 3], expected[sure.argmax() + 3], FALSE_ALARM)
    np.testing.assert_allclose(reading.energy_in.value, counts(reading) / PARTICLES, rtol=1e-12)
    np.testing.assert_allclose(reading.flux_in.value, reading.energy_in.value / np.diff(TIMES), rtol=1e-12)
    np.testing.assert_allclose(reading.irradiance.value * 4 * np.pi, reading.flux_in.value, rtol=1e-12)
    np.testing.assert_allclose(reading.fluence.value * 4 * np.pi, reading.energy_in.value, rtol=1e-6)
    assert (str(reading.energy_in.unit), str(reading.flux_in.unit)) == ("J", "W")


def test_a_rate_holds_while_a_box_pulse_is_on():
    emission = tp.Isotropic(power=4.0, speed=1.0)
    for pulse, energy in ((tp.BoxPulse(1.0, 1.5), 2.0), (None, 8.0)):
        meter = tp.Detector(tp.Sphere(radius=0.25), "sphere", side="inside", times=(1.25, 1.75))
        scene = tp.Scene(tp.Source(tp.Point(), emission, pulse=pulse), [], meter, duration=2.0)
        result = run(scene, 10_000)
        assert result.ledger["emitted"].value == pytest.approx(energy, rel=1e-14)
        if pulse is not None:
            assert result["sphere"].energy_in.value == pytest.approx([2.0], rel=1e-12)
            assert result["sphere"].flux_in.value == pytest.approx([4.0], rel=1e-12)
        else:
            assert_agrees(result["sphere"].flux_in[0], 4.0, FALSE_ALARM)


# ---- times of flight ----


def test_particles_between_two_mirrors_meet_them_at_every_odd_flight():
    """All of 1000 histories in one bin of each second of eleven, to the last."""
    mirrors = [
        tp.Surface(tp.Disk(center=(0, 0, z), normal=(0, 0, -z), radius=1.0), tp.Mirror(), name)
        for z, name in ((0.5, "upper"), (-0.5, "lower"))
    ]
    times = np.arange(0.25, 11, 0.5)
    looks = [tp.Detector(name, times=times) for name in ("upper", "lower")]
    gas = tp.Gas(number=1.0, speed=1.0, direction=(0, 0, 1))
    result = run(tp.Scene(tp.Source(tp.Point(), gas), mirrors, looks, duration=11.0), 1000)
    edges_met = np.isin(np.arange(0.5, 10.6, 0.5), np.arange(0.5, 11, 2.0))
    np.testing.assert_array_equal(counts(result["upper"]), 1000 * edges_met)
    np.testing.assert_array_equal(counts(result["upper"], DEPARTURES), 1000 * edges_met)
    edges_met = np.isin(np.arange(0.5, 10.6, 0.5), np.arange(1.5, 11, 2.0))
    np.testing.assert_array_equal(counts(result["lower"]), 1000 * edges_met)


def test_what_flies_faster_is_there_sooner():
    """A thermal burst along a line, L away: it arrives at L/v, v normal; in bins of time and speed at once."""
    sigma, length = 2.0, 3.0
    times = np.array([0, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0, 3.0, 5.0])
    speeds = np.array([0.6, 1.5, 2.0, 3.0, 7.5, 20.0])
    gas = tp.Gas(number=1.0, speed=tp.Maxwellian(sigma=sigma), direction=(0, 0, 1))
    meter = tp.Detector(
        tp.Disk(center=(0, 0, length), radius=1.0), "far", side="back", times=times, speeds=speeds
    )
    reading = run(tp.Scene(tp.Source(tp.Point(), gas), [], meter, duration=5.0))["far"]
    found = counts(reading)
    for i, (early, late) in enumerate(zip(times, times[1:], strict=False)):
        for j, (slow, fast) in enumerate(zip(speeds, speeds[1:], strict=False)):
            may = length / fast < late and length / slow > early
            assert may or found[i, j] == 0
    below = 1 - ndtr(length / np.maximum(times, 1e-9) / sigma)
    expected = np.append(np.diff(below), 1 - below[-1])
    judged = np.append(found.sum(axis=1), PARTICLES - found.sum())
    assert_follows(judged, expected, FALSE_ALARM)
    wrong = 1 - ndtr(length / np.maximum(times + 0.05, 1e-9) / sigma)
    wrong = np.diff(wrong)
    with pytest.raises(AssertionError):
        assert_follows(judged, np.append(wrong, 1 - wrong.sum()), FALSE_ALARM)


@pytest.mark.parametrize("pulse", [None, tp.BoxPulse(1.0, 5.0), tp.GaussianPulse(3.0, 0.35)], ids=str)
def test_when_a_particle_is_born_does_not_tell_how_fast_it_is(pulse):
    """A thermal wall effuses: in every bin of time the share 1 - (1 + x) exp(-x) has speeds below x.

    x is the squared speed over 2 sigma^2.
    """
    sigma, wall = 2.0, tp.Disk(radius=1.0)
    times, x = np.array([0.0, 1.5, 2.5, 3.5, 4.5, 6.0]), np.array([0.0, 0.5, 1.0, 1.7, 2.7, 5.0, 40.0])
    gas = tp.Effusive(number=1.0, speed=tp.Maxwellian(sigma=sigma))
    look = tp.Detector(wall, "wall", times=times, speeds=sigma * np.sqrt(2 * x))
    born = counts(
        run(tp.Scene(tp.Source(wall, gas, pulse=pulse), [], look, duration=6.0), 200_000)["wall"], DEPARTURES
    )
    law = np.outer(born.sum(axis=1) / born.sum(), np.diff(-(1 + x) * np.exp(-x)))
    law /= law.sum()
    assert_follows(born, law, FALSE_ALARM)
    with pytest.raises(AssertionError, match="chi-square"):
        assert_follows(np.sort(born, axis=0), law, FALSE_ALARM)


def test_a_lamp_switched_on_is_steady_once_its_farthest_light_has_come():
    """A disk, 2 m away: nothing before 2 s, the steady irradiance after sqrt(4.25) + 0.06 s; light flies at 1 m/s."""
    lamp = tp.Source(
        tp.Disk(radius=0.5), tp.Lambertian(radiance=100.0, speed=1.0), aim=(patch := tp.Disk(
            center=(0, 0, 2), normal=(0, 0, -1), radius=0.1
        ))
    )  # fmt: skip
    farthest = math.hypot(2, 0.6)
    looks = tp.Detector(patch, "patch", times=(0, 1.999, farthest, 3.0, 4.0))
    reading = run(tp.Scene(lamp, [], looks, duration=4.0))["patch"]
    exact = emitters.mean_disk_irradiance(100.0, 0.5, 0.1, 2.0)
    assert counts(reading)[0] == 0
    for late in (2, 3):
        assert_agrees(reading.irradiance[late], exact, FALSE_ALARM)
    assert 0.3 * exact < reading.irradiance.value[1] < 0.8 * exact
    steady = run(tp.Scene(lamp, [], tp.Detector(patch, "patch")))["patch"].irradiance
    assert_agrees(steady, exact, FALSE_ALARM)


# ---- all bins together ----


@lru_cache(maxsize=1)
def room():
    """A box of every kind of wall, lit by three kinds of pulses; one floor looked at in many ways."""
    kinds = [tp.Diffuse(0.8), tp.Mirror(), tp.Diffuse(0.5), tp.Mirror(0.9), tp.Diffuse(0.9), tp.Black()]
    faces = tp.Box(size=2.0).faces()
    walls = [tp.Surface(face, kind, n) for (n, face), kind in zip(faces.items(), kinds, strict=True)]
    sources = [
        tp.Source("+x", tp.Lambertian(energy=2.0, speed=1.0), side="back"),
        tp.Source("-z", tp.Lambertian(energy=1.0, speed=1.0), side="back", pulse=tp.GaussianPulse(3.0, 0.3)),
        tp.Source(tp.Point(), tp.Isotropic(energy=1.0, speed=1.0), pulse=tp.Instant(1.0)),
    ]
    part, bins = (
        (1.0, 2.5, 7.0),
        {"directions": tp.Directions(mu=3), "positions": tp.Positions(u=(-0.5, 0, 0.5))},
    )
    looks = {
        "all": {},
        "full": {"times": 7},
        "part": {"times": part},
        "binned": {"times": part} | bins,
        "untimed": bins,
    }
    floors = [tp.Detector("-z", f"floor {name}", side="back", **options) for name, options in looks.items()]
    pane = tp.Rectangle(width=1.0, height=1.0, normal=(1, 0, 1))
    panes = [tp.Detector(pane, f"pane {name}", **options) for name, options in looks.items()]
    return run(tp.Scene(sources, walls, [*floors, *panes], duration=9.0), 60_000)


@pytest.mark.parametrize("side", [ARRIVALS, DEPARTURES])
@pytest.mark.parametrize("place", ["floor", "pane"])
def test_bins_of_time_and_what_is_outside_of_them_are_the_whole(place, side):
    """Numbers of histories, to the last, and energies to their rounding."""
    result = room()
    whole, full, part, binned, untimed = (
        result[f"{place} {name}"] for name in ("all", "full", "part", "binned", "untimed")
    )
    total = counts(whole, side)
    assert total > 4000
    assert counts(full, side).sum() == total == counts(untimed, side)
    assert counts(part, side).sum() + outside(result, part, "counts", side) == total
    np.testing.assert_array_equal(counts(part, side), counts(binned, side))
    assert outside(result, part, "counts", side) > 0
    energy = "energy_in" if side == ARRIVALS else "energy_out"
    all_of_it = getattr(whole, energy).value
    assert getattr(full, energy).sum().value == pytest.approx(all_of_it, rel=1e-13)
    beyond = outside(result, part, "weights", side) * result.plan.unit / result.particles
    assert getattr(part, energy).sum().value + beyond == pytest.approx(all_of_it, rel=1e-13)
    assert getattr(part, energy).sum().value != pytest.approx(all_of_it, rel=1e-3)
    rate = "irradiance" if side == ARRIVALS else "exitance"
    mean = (getattr(full, rate).value * np.diff(np.linspace(0, 9, 8))).sum() / 9
    assert mean == pytest.approx(getattr(whole, rate).value, rel=1e-13)


def outside(result, reading, kind, side):
    """The row of what falls outside of all bins of time."""
    row = result.plan.rows_of[reading.name].base + side * result.plan.half
    return sum(getattr(batch, kind)[row] for batch in result.batches)


@pytest.mark.parametrize("place", ["floor", "pane"])
def test_bins_of_direction_and_position_over_time_are_those_without_it(place):
    """The bins of time of `binned` leave out what comes before 1 s and after 7 s; then no bin is fuller than untimed."""
    result = room()
    binned, untimed = (result[f"{place} {name}"] for name in ("binned", "untimed"))
    for side in (ARRIVALS, DEPARTURES):
        timed = binned.counts_of(f"weight {SIDES[side]}", BINS).sum(axis=(0, 1))
        ever = untimed.counts_of(f"weight {SIDES[side]}", BINS).sum(axis=0)
        assert timed.shape == ever.shape == (2, 3)
        assert (timed <= ever).all() and timed.sum() > 1000
    assert binned.radiance.dims == ("time", "u", "mu") and binned.irradiance.dims == ("time", "u")
    assert binned.fluence.shape == (2, 2) and binned.radiance.shape == (2, 2, 3)


def test_fluence_over_all_bins_is_that_of_the_whole():
    result = room()
    for place in ("floor", "pane"):
        whole, full = result[f"{place} all"].fluence, result[f"{place} full"].fluence
        assert full.sum().value == pytest.approx(whole.value, rel=1e-12)
        rate = result[f"{place} full"].fluence_rate
        np.testing.assert_allclose(rate.value * 9 / 7, full.value, rtol=1e-12)


def test_the_ledger_closes_with_what_still_flies_at_the_end():
    ledger = room().ledger
    parts = sum(ledger[name].value for name in ("absorbed", "in_flight", "roulette"))
    assert ledger["in_flight"].value > 1e-3
    assert parts == pytest.approx(4.0, rel=1e-12)
    assert ledger["escaped"].value == ledger["lost"].value == 0
