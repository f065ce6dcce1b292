"""The clock: what sources emit and when, pulses, arrival times, energies by bin of time, aimed flashes on their way.

All runs have seed 1.  Each judgement fails right code in one of 10^6 seeds; what is a law of every history is asked
of integers, or of numbers without noise.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest
from scipy.special import ndtr

import transport as tp
from tests.agreement import assert_agrees, assert_follows
from transport.geometry.shape import Shape
from transport.results.detectors import BINS
from transport.results.tally import ARRIVALS, DEPARTURES, SIDES
from transport.statistics.quantiles import LARGEST_U
from transport.theory import emitters
from transport.validation import SceneError

FALSE_ALARM = 1e-6
PARTICLES = 1_000_000
PI = math.pi


def run(scene, particles=PARTICLES):
    return tp.simulate(scene, particles=particles, seed=1, progress=False)


def counts(reading, side=ARRIVALS):
    """Histories by bin of time and speed, over all that was binned within."""
    return reading.counts_of(f"weight {SIDES[side]}").sum(axis=0)


# ---- what a source emits in all ----

DISK, BALL, CUBE = tp.Disk(radius=1), tp.Sphere(radius=2), tp.Box(size=(1, 2, 3))
SHEET, POINT = tp.Rectangle(width=2, height=4), tp.Point()
WARM = tp.Maxwellian(temperature=300, mass=4.65e-26)
TABLE = tp.SpeedTable((0, 2), (1, 1))
RATES = [
    (CUBE, tp.Lambertian(exitance=3), 66),
    (SHEET, tp.Beam((0, 3, 4), irradiance=5), 32),
    (DISK, tp.Effusive(2.5e19, 400), 2.5e19 * 100 * PI),
    (BALL, tp.Effusive(2.5e19, WARM), 2.5e19 * WARM.mean_speed / 4 * 16 * PI),
    (CUBE, tp.Effusive(exitance=7, speed=TABLE), 154),
    (SHEET, tp.Effusive(1.0, TABLE), 1 / 4 * 8),
]


@pytest.mark.parametrize("shape, emission, rate", RATES, ids=lambda value: type(value).__name__)
def test_a_rate_holds_for_the_duration_or_while_a_box_pulse_is_on(shape, emission, rate):
    source = tp.Source(shape, emission)
    assert source.amount(shape, None) == pytest.approx(rate, rel=1e-14)
    assert source.amount(shape, 0.25) == pytest.approx(rate / 4, rel=1e-14)
    pulsed = tp.Source(shape, emission, pulse=tp.BoxPulse(0.1, 0.15))
    assert pulsed.amount(shape, 0.25) == pytest.approx(rate * 0.05, rel=1e-14)


WHOLES = [
    (DISK, tp.Lambertian(energy=3)),
    (POINT, tp.Isotropic(energy=3)),
    (DISK, tp.Beam((0, 0, 1), energy=3)),
    (SHEET, tp.Effusive(number=3, speed=500)),
]


@pytest.mark.parametrize("pulse", [None, tp.Instant(0.1), tp.BoxPulse(0.1, 0.2), tp.GaussianPulse(1, 0.1)])
def test_an_energy_or_number_is_the_whole_amount_whenever_it_is_emitted(pulse):
    for shape, emission in WHOLES:
        source = tp.Source(shape, emission, pulse=pulse)
        source.check_clock(duration=2)
        assert source.amount(shape, 2) == 3 and emission.is_whole


@pytest.mark.parametrize(
    ("shape", "gas", "number"),
    [
        (CUBE, tp.Gas(1e20, 500), 6e20),
        (BALL, tp.Gas(3, WARM), 32 * PI),
        (POINT, tp.Gas(number=10, speed=0), 10),
        (tp.Cloud(sigma=(1, 2, 3)), tp.Gas(2, WARM), 12 * (2 * PI) ** 1.5),
        (tp.Cloud(sigma=(0, 0, 1)), tp.Gas(number=7, speed=1), 7),
    ],
    ids=lambda value: type(value).__name__,
)
def test_the_particles_of_a_gas_fill_their_shape_at_time_0(shape, gas, number):
    source = tp.Source(shape, gas)
    source.check_clock(duration=5)
    assert source.amount(shape, 5) == pytest.approx(number, rel=1e-15)


def test_a_drift_towards_the_surface_raises_what_effuses_and_one_away_lowers_it():
    """references.json, A.drifting_maxwellian_flux, n = 2.5; s = 0.5 and -0.5 along the normal."""
    tilted = tp.Disk(radius=1, normal=(0, 3, 4))
    gas = tp.Maxwellian(sigma=1, drift=tuple(math.sqrt(0.5) * n for n in tilted.normal))
    front = tp.Source(tilted, tp.Effusive(2.5, gas))
    back = tp.Source(tilted, tp.Effusive(2.5, gas), side="back")
    assert front.amount(tilted, None) == pytest.approx(2.1206861189359723 * PI, rel=1e-14)
    assert back.amount(tilted, None) == pytest.approx(0.35291916596960327 * PI, rel=1e-14)
    along = tp.Maxwellian(sigma=1, drift=(5, 0, 0))
    still = tp.Maxwellian(sigma=1)
    rates = [tp.Source(tilted, tp.Effusive(2.5, speed)).amount(tilted, None) for speed in (along, still)]
    assert rates[0] == pytest.approx(rates[1], rel=1e-15)


def test_mass_and_speed_of_particles_are_numbers_or_those_of_their_distribution():
    still = tp.Maxwellian(sigma=3)
    masses = {
        tp.Gas(1, WARM): 4.65e-26, tp.Effusive(1, WARM): 4.65e-26, tp.Gas(1, WARM, mass=4.65e-26): 4.65e-26,
        tp.Gas(1, 500): None, tp.Gas(1, 500, mass=1): 1.0, tp.Gas(1, still): None, tp.Gas(1, still, mass=2): 2,
        tp.Lambertian(power=1): None,
    }  # fmt: skip
    assert all(emission.mass == mass for emission, mass in masses.items())
    assert isinstance(tp.Gas(1, 0).speed, float) and isinstance(tp.Effusive(1, np.int64(5)).speed, float)
    assert tp.Gas(1, WARM).speed is WARM
    assert tp.Gas(1, tp.SpeedTable((-1, 1), (1, 1)), direction=(0, 0, 2)).direction == (0, 0, 1)
    assert tp.Diffuse(1, speed=5).speed == 5.0 and tp.Diffuse(1).speed is None


def test_pulses_emit_within_their_reach():
    u = np.array([0.0, 0.25, 0.5, LARGEST_U])
    assert tp.Instant().quantile(u).tolist() == [0] * 4 and tp.Instant(3).first == tp.Instant(3).last == 3
    box, bell = tp.BoxPulse(1, 3), tp.GaussianPulse(10, 1)
    assert box.quantile(u).tolist() == pytest.approx([1, 1.5, 2, 3], rel=1e-15)
    assert (box.first, box.last, box.length) == (1, 3, 2)
    assert bell.quantile(u)[2] == 10 and bell.first == pytest.approx(1.5) and bell.last == pytest.approx(18.5)
    for pulse in (box, bell):
        times = pulse.quantile(u)
        assert (times >= pulse.first).all() and (times <= pulse.last).all()
    counts = np.histogram(
        bell.quantile(np.random.default_rng(1).random(100_000)), [0, 9, 9.5, 10, 10.5, 11, 20]
    )[0]
    assert_follows(counts, np.diff(ndtr([-np.inf, -1, -0.5, 0, 0.5, 1, np.inf])))


def test_a_gaussian_pulse_that_starts_at_0_is_not_refused_by_rounding():
    for sigma in np.random.default_rng(2).uniform(1e-9, 1, 1000):
        pulse = tp.GaussianPulse(8.5 * sigma, sigma)
        tp.Source(POINT, tp.Isotropic(energy=1), pulse=pulse).check_clock(17 * sigma)
    with pytest.raises(SceneError):
        tp.GaussianPulse(8.5 * sigma * (1 - 1e-9), sigma)


def test_a_cloud_is_a_shape_with_bounds_beyond_every_draw():
    cloud = tp.Cloud(center=(1, 2, 3), sigma=(0, 1, 2))
    assert cloud.bounds == ((1, -6.5, -14), (1, 10.5, 20))
    assert cloud.extent == pytest.approx(8.5 * math.sqrt(5)) and cloud.middle == (1, 2, 3)
    assert tp.Cloud(sigma=2) == tp.Cloud(sigma=[2, 2, 2]) and isinstance(cloud, Shape) and not cloud.is_closed


MIRROR, WALL = tp.Mirror(), tp.Diffuse(1.0, speed=WARM)


def test_a_mixture_is_the_same_in_any_order_and_its_shares_add_up_to_1():
    """Up to rounding; none is kept at 0."""
    mixture = tp.Mixture({MIRROR: 0.3, WALL: 0.7})
    assert mixture == tp.Mixture({WALL: 0.7, MIRROR: 0.3}) == tp.Mixture(((MIRROR, 0.3), (WALL, 0.7)))
    assert hash(mixture) == hash(tp.Mixture({WALL: 0.7, MIRROR: 0.3}))
    assert mixture != tp.Mixture({MIRROR: 0.7, WALL: 0.3}) and dict(mixture.parts) == {MIRROR: 0.3, WALL: 0.7}
    for a in np.linspace(0, 1, 11):
        mixture = tp.Mixture({MIRROR: 1 - a, WALL: a})
        assert math.fsum(share for _, share in mixture.parts) == pytest.approx(1, abs=1e-15)
    assert mixture.parts == ((WALL, 1.0),)


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
    """Half a bin off is seen."""
    pulse, law = PULSES[name]
    result = flash(pulse)
    reading = result["sphere"]
    arrived = counts(reading)
    judged = np.append(arrived, PARTICLES - arrived.sum())
    assert result.ledger["in_flight"].value == pytest.approx(1.0)  # then or later, all fly on outside
    assert_follows_or_is_certain(judged, shares(law, TIMES))
    half = np.diff(TIMES).max() / 2 if name != "gaussian" else 0.05
    for off in (-half, half):
        with pytest.raises(AssertionError):
            assert_follows_or_is_certain(judged, shares(lambda t, off=off: law(t - off), TIMES))
    np.testing.assert_allclose(reading.energy_in.value, arrived / PARTICLES, rtol=1e-12)
    np.testing.assert_allclose(reading.flux_in.value, reading.energy_in.value / np.diff(TIMES), rtol=1e-12)
    np.testing.assert_allclose(reading.irradiance.value * 4 * PI, reading.flux_in.value, rtol=1e-12)
    np.testing.assert_allclose(reading.fluence.value * 4 * PI, reading.energy_in.value, rtol=1e-6)
    assert (str(reading.energy_in.unit), str(reading.flux_in.unit)) == ("J", "W")


def assert_follows_or_is_certain(judged, expected):
    """Chi-square; or, where all lies in one bin, that all does."""
    if expected.max() == 1:
        assert (judged == PARTICLES * expected).all()
    else:
        assert_follows(judged, expected, FALSE_ALARM)


# ---- times of flight ----


def test_particles_between_two_mirrors_meet_them_at_every_odd_flight():
    """All of 1000 histories in one bin of each second of eleven, to the last."""
    places = {"upper": 0.5, "lower": -0.5}
    mirrors = [
        tp.Surface(tp.Disk(center=(0, 0, z), normal=(0, 0, -z), radius=1.0), tp.Mirror(), name)
        for name, z in places.items()
    ]
    looks = [tp.Detector(name, times=np.arange(0.25, 11, 0.5)) for name in places]
    gas = tp.Gas(number=1.0, speed=1.0, direction=(0, 0, 1))
    result = run(tp.Scene(tp.Source(tp.Point(), gas), mirrors, looks, duration=11.0), 1000)
    for name, first in (("upper", 0.5), ("lower", 1.5)):
        met = 1000 * np.isin(np.arange(0.5, 10.6, 0.5), np.arange(first, 11, 2.0))
        np.testing.assert_array_equal(counts(result[name]), met)
        np.testing.assert_array_equal(counts(result[name], DEPARTURES), met)


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
    binned, untimed, whole, full = (
        result[f"{place} {name}"] for name in ("binned", "untimed", "all", "full")
    )
    for side in (ARRIVALS, DEPARTURES):
        timed = binned.counts_of(f"weight {SIDES[side]}", BINS).sum(axis=(0, 1))
        ever = untimed.counts_of(f"weight {SIDES[side]}", BINS).sum(axis=0)
        assert timed.shape == ever.shape == (2, 3)
        assert (timed <= ever).all() and timed.sum() > 1000
    assert binned.radiance.dims == ("time", "u", "mu") and binned.irradiance.dims == ("time", "u")
    assert binned.fluence.shape == (2, 2) and binned.radiance.shape == (2, 2, 3)
    assert full.fluence.sum().value == pytest.approx(whole.fluence.value, rel=1e-12)
    np.testing.assert_allclose(full.fluence_rate.value * 9 / 7, full.fluence.value, rtol=1e-12)


def test_the_ledger_closes_with_what_is_in_flight_at_the_end():
    ledger = room().ledger
    parts = sum(ledger[name].value for name in ("absorbed", "in_flight", "roulette"))
    assert ledger["in_flight"].value > 1e-3
    assert parts == pytest.approx(4.0, rel=1e-12)
    assert ledger["escaped"].value == ledger["lost"].value == 0


# ---- an aimed particle is kept at its target while it flies there: every count on the way must find where it is ----
#
# A flash is aimed at a target so small that all rays are one, from the origin along +z.  It has flown a known way when the clock
# stops, and every part of that way gets the same energy times length.

SMALL, FAR = 1e-3, 3.0  # m: of the targets, and how far away they are; cosines are 1 within 6e-8
PLACE = {"center": (0, 0, FAR)}
TARGETS = {
    "disk": tp.Disk(**PLACE, normal=(0, 0, -1), radius=SMALL),
    "rectangle": tp.Rectangle(**PLACE, normal=(0.2, 0, -1), width=SMALL, height=SMALL),
    "triangle": tp.Triangle(vertices=[(0, 0, FAR), (SMALL, 0, FAR), (0, SMALL, FAR)]),
    "sphere": tp.Sphere(**PLACE, radius=SMALL),
    "box": tp.Box(**PLACE, size=SMALL),
}
ENERGY, BORN, SPEED = 2.0, 0.25, 2.0  # J, s, m/s
WITHIN = 1e-6  # relative: of the cosines, and of the energy as what is not unsampled
SKY = tp.Detector(tp.Sphere(radius=20.0), "sky", side="inside", speeds=(0.0, 3.0))
PACES = {  # what tells how far a flight comes: what else is looked at, and the index of refraction
    "one speed": ((), 1.0),
    "each its own speed": ((SKY,), 1.0),
    "slower in a medium": ((), 1.5),
}
FLOWN = {"before the target": 1.3, "beyond the target": 4.3}  # m when the clock stops
LAYERS = np.linspace(-0.7, 4.9, 9)
SHELLS = np.array([0.0, 0.5, 1.0, 2.0, 4.0, 5.0])


def aimed_flash(target, looks, way, pace):
    """A aimed_flash that has flown so far when the clock stops, and what of its energy goes to the target [J]."""
    others, index = PACES[pace]
    law, pulse = tp.Isotropic(energy=ENERGY, speed=SPEED), tp.Instant(BORN)
    scene = tp.Scene(
        tp.Source(tp.Point(), law, aim=TARGETS[target], pulse=pulse),
        detectors=[*looks, *others],
        medium=tp.Vacuum() if index == 1 else tp.Medium(index=index),
        duration=BORN + way * index / SPEED,
    )
    result = tp.simulate(scene, particles=500, seed=1, progress=False)
    return result, ENERGY - result.ledger["unsampled"].value


AIMED = [pytest.param(t, marks=() if t == "disk" else pytest.mark.slow) for t in TARGETS]


@pytest.mark.parametrize("when", FLOWN)
@pytest.mark.parametrize("pace", PACES)
@pytest.mark.parametrize("target", AIMED)
def test_the_fluence_of_an_aimed_flash_is_on_the_way_that_it_has_flown(target, pace, when):
    """In volumes of one cell, in layers, in shells about the source, and not where it has not come yet."""
    way, middle, height = FLOWN[when], (LAYERS[0] + LAYERS[-1]) / 2, LAYERS[-1] - LAYERS[0]
    box, ball = tp.Box(center=(0, 0, middle), size=(1, 1, height)), tp.Sphere(radius=SHELLS[-1])
    looks = {
        tp.VolumeDetector(box, "box"): LAYERS[[0, -1]],
        tp.VolumeDetector(box, "layers", (1, 1, len(LAYERS) - 1)): LAYERS,
        tp.VolumeDetector(ball, "ball"): SHELLS[[0, -1]],
        tp.VolumeDetector(ball, "shells", tuple(SHELLS)): SHELLS,
        tp.VolumeDetector(tp.Sphere(center=(0, 0, 4), radius=0.5), "far"): np.array([3.5, 4.5]),
    }
    result, energy = aimed_flash(target, looks, way, pace)
    for look, edges in looks.items():
        found = (result[look.name].fluence * result[look.name].volumes).value
        exact = energy * np.diff(np.clip(edges, 0.0, way))
        assert np.ravel(found) == pytest.approx(exact, rel=WITHIN, abs=WITHIN * energy), look.name


@pytest.mark.parametrize("target", AIMED)
def test_phase_space_finds_an_aimed_flash_as_far_as_it_has_flown(target):
    """In the one bin of a centimetre of z that holds it, at every instant."""
    ways, edges = np.array([0.005, 0.605, 1.805, 2.985, 4.195]), np.linspace(-1.0, 5.0, 601)
    looks = tp.PhaseSpace(z=edges, time=tuple(BORN + ways / SPEED), name="z")
    result, energy = aimed_flash(target, [looks], 4.3, "each its own speed")
    exact = np.zeros((len(ways), len(edges) - 1))
    exact[np.arange(len(ways)), np.searchsorted(edges, ways) - 1] = energy
    np.testing.assert_allclose(result["z"].number.value, exact, rtol=WITHIN)


@pytest.mark.parametrize("pace", PACES)
@pytest.mark.parametrize("target", AIMED)
def test_an_aimed_flash_crosses_each_pane_when_it_has_flown_there(target, pace):
    """In the one bin of time in which it flies the centimetre there; it has passed other panes on the way."""
    places, edges = (0.605, 1.405, 2.205, 3.405, 3.905), np.linspace(0.0, 4.2, 421)
    times = BORN + edges * PACES[pace][1] / SPEED
    panes = {f"pane {k}": tp.Disk(center=(0, 0, z), radius=0.1) for k, z in enumerate(places)}
    looks = [tp.Detector(pane, name, side="back", times=times) for name, pane in panes.items()]
    result, energy = aimed_flash(target, looks, 4.3, pace)
    for name, z in zip(panes, places, strict=True):
        exact = np.where(np.arange(len(edges) - 1) == np.searchsorted(edges, z) - 1, energy, 0.0)
        np.testing.assert_allclose(result[name].energy_in.value, exact, rtol=WITHIN, err_msg=name)
