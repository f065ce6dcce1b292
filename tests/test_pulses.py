"""What a source emits in all: with a clock energies or particles, without one rates; and when."""

import dataclasses
import math
import pickle

import numpy as np
import pytest
from scipy.special import ndtr

import transport as tp
from tests.agreement import assert_follows
from transport.geometry.shape import Shape
from transport.statistics.quantiles import LARGEST_U
from transport.validation import SceneError

DISK, BALL, CUBE = tp.Disk(radius=1), tp.Sphere(radius=2), tp.Box(size=(1, 2, 3))
SHEET, POINT = tp.Rectangle(width=2, height=4), tp.Point()
WARM = tp.Maxwellian(temperature=300, mass=4.65e-26)
TABLE = tp.SpeedTable((0, 2), (1, 1))
PI = math.pi

RATES = [
    (DISK, tp.Lambertian(radiance=3), 3 * PI * PI),
    (CUBE, tp.Lambertian(exitance=3), 66),
    (BALL, tp.Lambertian(power=3), 3),
    (POINT, tp.Isotropic(intensity=3), 12 * PI),
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
@pytest.mark.parametrize("shape, emission", WHOLES, ids=lambda value: type(value).__name__)
def test_an_energy_or_number_is_the_whole_amount_whenever_it_is_emitted(shape, emission, pulse):
    source = tp.Source(shape, emission, pulse=pulse)
    source.check_clock(duration=2)
    assert source.amount(shape, 2) == 3 and emission.is_whole


def test_the_particles_of_a_gas_fill_their_shape_at_time_0():
    def number(shape, gas):
        source = tp.Source(shape, gas)
        source.check_clock(duration=5)
        return source.amount(shape, 5)

    assert number(CUBE, tp.Gas(1e20, 500)) == pytest.approx(6e20, rel=1e-15)
    assert number(BALL, tp.Gas(3, WARM)) == pytest.approx(32 * PI, rel=1e-15)
    assert number(POINT, tp.Gas(number=10, speed=0)) == 10
    cloud = tp.Cloud(sigma=(1, 2, 3))
    assert number(cloud, tp.Gas(2, WARM)) == pytest.approx(12 * (2 * PI) ** 1.5, rel=1e-15)
    assert number(tp.Cloud(sigma=(0, 0, 1)), tp.Gas(number=7, speed=1)) == 7


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


def test_the_mass_of_particles_is_that_of_their_maxwellian_unless_said():
    assert (
        tp.Gas(1, WARM).mass == tp.Effusive(1, WARM).mass == tp.Gas(1, WARM, mass=4.65e-26).mass == 4.65e-26
    )
    assert tp.Gas(1, 500).mass is None and tp.Gas(1, 500, mass=1).mass == 1.0
    assert (
        tp.Gas(1, tp.Maxwellian(sigma=3)).mass is None and tp.Gas(1, tp.Maxwellian(sigma=3), mass=2).mass == 2
    )
    assert tp.Lambertian(power=1).mass is None


def test_speeds_of_particles_are_floats_or_distributions():
    assert isinstance(tp.Gas(1, 0).speed, float) and isinstance(tp.Effusive(1, np.int64(5)).speed, float)
    assert tp.Gas(1, WARM).speed is WARM
    signed = tp.SpeedTable((-1, 1), (1, 1))
    assert tp.Gas(1, signed, direction=(0, 0, 2)).direction == (0, 0, 1)
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


def test_a_clock_is_asked_for_only_where_something_needs_it():
    for source in (
        tp.Source(DISK, tp.Lambertian(power=1)),
        tp.Source(DISK, tp.Effusive(1, WARM)),
        tp.Source(DISK, tp.Effusive(exitance=1, speed=5)),
    ):
        source.check_clock(None)
        source.check_clock(1.0)


def test_a_cloud_is_a_shape_with_bounds_beyond_every_draw():
    cloud = tp.Cloud(center=(1, 2, 3), sigma=(0, 1, 2))
    assert cloud.bounds == ((1, -6.5, -14), (1, 10.5, 20))
    assert cloud.extent == pytest.approx(8.5 * math.sqrt(5)) and cloud.middle == (1, 2, 3)
    assert tp.Cloud(sigma=2) == tp.Cloud(sigma=[2, 2, 2]) and isinstance(cloud, Shape) and not cloud.is_closed


MIRROR, WALL = tp.Mirror(), tp.Diffuse(1.0, speed=WARM)


def test_a_mixture_is_the_same_in_any_order():
    mixture = tp.Mixture({MIRROR: 0.3, WALL: 0.7})
    assert mixture == tp.Mixture({WALL: 0.7, MIRROR: 0.3}) == tp.Mixture(((MIRROR, 0.3), (WALL, 0.7)))
    assert hash(mixture) == hash(tp.Mixture({WALL: 0.7, MIRROR: 0.3}))
    assert mixture != tp.Mixture({MIRROR: 0.7, WALL: 0.3})
    assert dict(mixture.parts) == {MIRROR: 0.3, WALL: 0.7}


def test_shares_of_a_mixture_add_up_to_1_up_to_rounding_and_none_is_kept_at_0():
    for a in np.linspace(0, 1, 11):
        mixture = tp.Mixture({MIRROR: 1 - a, WALL: a})
        assert math.fsum(share for _, share in mixture.parts) == pytest.approx(1, abs=1e-15)
    assert mixture.parts == ((WALL, 1.0),)


OBJECTS = [
    WARM,
    TABLE,
    tp.Instant(1),
    tp.BoxPulse(0, 1),
    tp.GaussianPulse(9, 1),
    tp.Cloud(sigma=(0, 1, 2)),
    tp.Effusive(1e20, tp.Maxwellian(sigma=3, drift=(1, 2, 3))),
    tp.Gas(number=5, speed=TABLE, direction=(1, 1, 1), mass=1e-26),
    WALL,
    tp.Mixture({MIRROR: 0.25, WALL: 0.5, tp.Black(): 0.125, tp.Transparent(): 0.125}),
    tp.Surface(DISK, tp.Mixture({MIRROR: 0.25, WALL: 0.75}), name="wall"),
    tp.Source(POINT, tp.Isotropic(energy=1), pulse=tp.Instant()),
]


@pytest.mark.parametrize("thing", OBJECTS, ids=lambda thing: type(thing).__name__)
def test_objects_are_frozen_hashable_and_survive_copies(thing):
    for twin in (
        dataclasses.replace(thing),
        pickle.loads(pickle.dumps(thing)),
        eval(repr(thing), vars(tp).copy()),
    ):
        assert twin == thing and hash(twin) == hash(thing)
    with pytest.raises(dataclasses.FrozenInstanceError):
        thing.colour = "red"
