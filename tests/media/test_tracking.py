"""However histories are followed through media, exact values come out, and the same where nothing is exact.

All runs have seed 1; each judgement fails right code in one of 10^5 seeds. A comment such as `E.slab_HG` names the entry of
the project's reference collection that a number comes from.
"""

from __future__ import annotations

import json
import math
from functools import lru_cache

import numpy as np
import pytest
from scipy.special import chdtrc
from typer.testing import CliRunner

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from tests.slow import quick
from tests.tracking_scenes import CLEAR, FALSE_ALARM, TRACKINGS, run, slab, splitting
from transport.cli.commands import app
from transport.theory import ordinates, random_flights

R, T = 0.0973946386719247, 0.6609577001638116  # E.vandehulst_hg: tau 2, albedo 0.9, g 0.75, normal beam
OFTEN = ("analog", "weighted", "forced", "split")
LIGHT_SPEED = 299792458.0
PARTICLES = 2000


# ---- slabs ----


@pytest.mark.parametrize("name", quick(TRACKINGS, *OFTEN))
def test_van_de_hulst_s_slab(name):
    """A cosine of the wrong sign (g = -0.75) or isotropic scattering would be seen."""
    result = run(slab(2.0, 0.9, 0.75), TRACKINGS[name])
    top, bottom = result["top"].flux_out, result["bottom"].flux_out
    assert_agrees(top, R, FALSE_ALARM)
    assert_agrees(bottom, T, FALSE_ALARM)
    balance = result.ledger["absorbed"] + result.ledger["roulette"]  # what roulette kills less what it gains
    assert_agrees(balance, 1 - R - T, FALSE_ALARM)
    wrong = ordinates.slab(2.0, 0.9)
    for estimate, other, exact in ((top, wrong.reflected, R), (bottom, wrong.transmitted, T)):
        assert_rejected(estimate, other)
        assert_rejected(estimate, exact * 1.1)


def test_trackings_that_keep_weights_play_no_roulette():
    assert run(slab(2.0, 1.0, 0.75), particles=20_000).ledger["roulette"].value == 0
    assert run(slab(2.0, 0.9, 0.75), "analog", 20_000).ledger["roulette"].value == 0


@pytest.mark.parametrize(
    ("tau", "albedo", "g", "mu0"),
    [
        (0.1, 0.5, 0.0, 0.5),
        pytest.param(1.0, 0.99, -0.5, 1.0, marks=pytest.mark.slow),
        pytest.param(5.0, 0.8, 0.9, 0.7, marks=pytest.mark.slow),
        (2.0, 1.0, 0.0, 0.1),
    ],
)
@pytest.mark.parametrize("name", OFTEN)
def test_slabs_of_every_kind(tau, albedo, g, mu0, name):
    """Planted: a forced collision that keeps the whole weight would return 1/(1 - exp(-tau)) times as much."""
    exact = ordinates.slab(tau, albedo, ordinates.henyey_greenstein(g), mu0)
    result = run(slab(tau, albedo, g, mu0), TRACKINGS[name], 50_000)
    assert_agrees(result["top"].flux_out, exact.reflected, FALSE_ALARM)
    assert_agrees(result["bottom"].flux_out, exact.transmitted, FALSE_ALARM)
    if name == "forced" and tau <= 1:
        assert_rejected(result["top"].flux_out, exact.reflected / -math.expm1(-tau))


@pytest.mark.parametrize("name", OFTEN)
def test_a_half_space_behind_a_boundary(name):
    """E.giovanelli: index 1.5, albedo 0.9: 0.2599186 with the specular 0.04."""
    milk = tp.Medium(absorption=0.1, scattering=0.9, index=1.5)
    beam = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
    face = tp.Surface(tp.Plane(), tp.Dielectric(1.5), "face", inside=milk)
    above = tp.Detector(tp.Plane(center=(0, 0, 2)), "above", side="back")
    tracking = TRACKINGS[name]
    if name == "split":
        tracking = tp.Tracking(splitting=splitting(10, start=(0, 0, -5), end=(0, 0, 0)))
    result = run(tp.Scene(beam, face, [above]), tracking)
    assert_agrees(result["above"].flux_in, 0.2599185699177473, FALSE_ALARM)
    assert_rejected(result["above"].flux_in, 0.2599185699177473 - 0.04)


def test_forced_collisions_do_not_go_with_splitting():
    with pytest.raises(tp.SceneError, match="forced cannot be combined with splitting"):
        tp.Tracking(forced=True, splitting=splitting(4))


def test_a_conservative_slab_returns_or_passes_all():
    """tau 100: R + T = 1 in every batch, to the last unit."""
    exact = ordinates.slab(100.0, 1.0)
    for tracking in ("weighted", "analog"):
        result = run(slab(100.0, 1.0), tracking, 10_000)
        returned, passed = result["top"].flux_out, result["bottom"].flux_out
        assert_agrees(passed, exact.transmitted, FALSE_ALARM)
        assert result.ledger["absorbed"].value == 0
        assert (returned + passed).value == 1


# ---- splitting ----


@lru_cache
def transmitted(tau, albedo):
    return ordinates.slab(tau, albedo).transmitted


@pytest.mark.parametrize("absorption", ["weighted", pytest.param("analog", marks=pytest.mark.slow)])
@pytest.mark.parametrize("gain", [1e6, 3e8, 1e10])
def test_what_gets_through_twenty_mean_free_paths_is_found_by_splitting(absorption, gain):
    """tau 20, albedo 0.2: 2.94e-9 of the light; without splitting none of 4 10^4 particles comes through by chance."""
    tracking = tp.Tracking(absorption=absorption, splitting=splitting(gain))
    through = run(slab(20.0, 0.2), tracking, 40_000)["bottom"].flux_out
    assert_agrees(through, transmitted(20.0, 0.2), FALSE_ALARM)
    if gain == 3e8:
        assert through.relative_error < 0.1
        assert_rejected(through, 1.6 * transmitted(20.0, 0.2))
    if absorption == "analog":
        assert run(slab(20.0, 0.2), absorption, 40_000)["bottom"].flux_out.value == 0


@pytest.mark.parametrize(
    "gain",
    [2.0, 10.0, pytest.param(1e3, marks=pytest.mark.slow), 1e6, pytest.param(1e12, marks=pytest.mark.slow)],
)
@pytest.mark.parametrize("is_upwards", [False, True])
def test_no_gain_biases_a_slab_lit_from_either_end(gain, is_upwards):
    """tau 3: importance rises with depth, or the light comes from where it is largest and is thinned out."""
    depth = max(1.0, math.log(gain) / 3)  # so far that importance rises no faster than the light falls
    ends = {"start": (0, 0, -depth), "end": (0, 0, 0)} if is_upwards else {"end": (0, 0, -depth)}
    exact = ordinates.slab(3.0, 0.5)
    result = run(slab(3.0, 0.5), tp.Tracking(splitting=splitting(gain, **ends)), 20_000)
    assert_agrees(result["top"].flux_out, exact.reflected, FALSE_ALARM)
    assert_agrees(result["bottom"].flux_out, exact.transmitted, FALSE_ALARM)
    assert result.cost.collisions < 100 * 20_000  # not a copy for each unit of the gain


@pytest.mark.parametrize("is_aimed", [False, True])
def test_what_is_born_is_heavy_as_its_own_birthplace_wants_and_light_as_the_end_does(is_aimed):
    """After eight mean free paths, mostly of absorption, each weighs 1/gain of its birth weight, within 2.

    An aimed history is kept at its target, where importance is greatest, but is born where it is least.
    """
    gain, tau, radius, height = math.exp(6), 8.0, 1e-3, 3.0
    law, at = tp.Beam((0, 0, -1), power=1.0), tp.Point(position=(0, 0, height))
    if is_aimed:
        target = tp.Disk(center=(0, 0, -1), radius=radius)
        power = 2 / (1 - (height + 1) / math.hypot(height + 1, radius))  # of which 1 W goes there
        lamp = tp.Source(at, tp.Isotropic(power=power), aim=target)
    else:
        lamp = tp.Source(at, law)
    scene = slab(tau, 0.01)
    through = run(
        tp.Scene(lamp, scene.surfaces, scene.detectors), tp.Tracking(splitting=splitting(gain)), PARTICLES
    )["bottom"]
    assert through.flux_out.value == pytest.approx(math.exp(-tau), rel=0.1)
    weight = through.flux_out.value / through.number_of("weight out") * PARTICLES
    assert 0.5 / gain <= weight <= 2 / gain


# ---- where nothing is exact ----


def _ball_of_glass():
    """Fog in a glass ball, in a grey room full of other fog."""
    ball = tp.Medium(absorption=0.3, scattering=2.0, index=1.5)
    walls = tp.Surface(tp.Box(size=6.0), tp.Diffuse(0.5), "walls")
    glass = tp.Surface(tp.Sphere(radius=1.0), tp.Dielectric(1.5), "ball", inside=ball)
    lamp = tp.Source(tp.Point(position=(0.1, 0.2, -1.5)), tp.Isotropic(power=1.0))
    fog = tp.Medium(absorption=0.1, scattering=0.4, phase=tp.HenyeyGreenstein(0.6))
    looks = [tp.Detector("ball"), tp.Detector("walls", side="inside"), tp.VolumeDetector("ball", "within")]
    return tp.Scene(lamp, [glass, walls], looks, medium=fog), ("ball", "walls"), "within"


def _shells():
    """Balls in one another, more than are told one by one, of unlike phase functions."""
    phases = (
        tp.Rayleigh(),
        tp.HenyeyGreenstein(-0.3),
        tp.Mixture({tp.HenyeyGreenstein(0.8): 0.5, tp.Isotropic(): 0.5}),
    )
    shells = [
        tp.Surface(
            tp.Sphere(center=(0, 0, -0.05 * k), radius=2 - 0.3 * k),
            CLEAR,
            f"shell {k}",
            inside=tp.Medium(absorption=0.1 * k, scattering=0.5 + 0.3 * k, phase=phases[k % 3]),
        )
        for k in range(6)
    ]
    lamp = tp.Source(tp.Point(position=(0.1, 0.2, 0.3)), tp.Isotropic(power=1.0))
    looks = [
        tp.Detector("shell 0", side="inside"),
        tp.Detector("shell 3"),
        tp.VolumeDetector("shell 2", "within"),
    ]
    return tp.Scene(lamp, shells, looks), ("shell 0", "shell 3"), "within"


@pytest.mark.parametrize(
    "make",
    [
        _ball_of_glass,
        pytest.param(_shells, marks=pytest.mark.slow),
    ],
)
def test_all_ways_to_follow_histories_agree(make):
    """Chi-square of each quantity about the mean of all; one that is off by eight of its errors is seen."""
    scene, meters, volume = make()
    results = [run(scene, tracking, 20_000) for tracking in TRACKINGS.values()]
    for results_of in (
        *((lambda r, name=name: r[name].flux_in) for name in meters),
        lambda r: r[volume].fluence_rate,
        lambda r: r[volume].absorbed_power,
        lambda r: r.ledger["absorbed"] + r.ledger["roulette"],
    ):
        found = [results_of(result) for result in results]
        values, errors = (np.array([getattr(e, part) for e in found]) for part in ("value", "error"))
        known = errors > 1e-9  # where nothing can escape what stays is exact
        if known.sum() > 1:
            assert chance_of(values[known], errors[known]) > FALSE_ALARM
            assert errors.max() < 0.08 * values.mean()
            values[np.flatnonzero(known)[0]] += 8 * errors[known][0]
            assert chance_of(values[known], errors[known]) < FALSE_ALARM


def chance_of(values, errors):
    """The probability that independent estimates of one number are so far apart."""
    mean = np.average(values, weights=errors**-2.0)
    return chdtrc(len(values) - 1, (((values - mean) / errors) ** 2).sum())


@pytest.mark.parametrize("material", [tp.Mirror(), tp.Diffuse(1.0)], ids=["mirrors", "white"])
@pytest.mark.parametrize(
    "name", quick(["analog", "weighted", "roulette 0.05", "forced", "analog, forced", "split"], *OFTEN)
)
def test_light_shut_in_with_fog_is_absorbed_by_it(material, name):
    fog = tp.Medium(absorption=0.2, scattering=1.0, phase=tp.HenyeyGreenstein(0.5))
    lamp = tp.Source(tp.Point(position=(0.1, 0.2, 0.3)), tp.Isotropic(power=1.0))
    walls = tp.Surface(tp.Box(size=2.0), material, "walls", inside=fog)
    result = run(tp.Scene(lamp, walls, tp.VolumeDetector("walls", "all")), TRACKINGS[name], 5_000)
    assert result.ledger["absorbed"].value + result.ledger["roulette"].value == pytest.approx(1, abs=1e-14)
    assert_agrees(result["all"].absorbed_power, 1.0, FALSE_ALARM)


def test_collisions_are_counted_as_often_as_they_happen():
    """A conservative ball under light from all sides: mean chord 4/3 r, so 4/3 tau collisions a particle, whatever g is."""
    for g in (0.0, 0.9):
        fog = tp.Medium(scattering=1.5, phase=tp.HenyeyGreenstein(g))
        ball = tp.Sphere(radius=1.0)
        light = tp.Source(ball, tp.Lambertian(power=1.0), side="inside")
        result = run(tp.Scene(light, tp.Surface(ball, CLEAR, inside=fog)), None, 100_000)
        spread = math.sqrt(100_000 * 2.0) * 10  # of a number whose variance a particle is about 2 to 20
        assert abs(result.cost.collisions - 200_000) < spread
        assert spread < 0.1 * 200_000


# ---- with a clock ----


def flash(index, duration, tracking="analog", walls=(), **looks):
    fog = tp.Medium(absorption=0.4, scattering=1.6, phase=tp.HenyeyGreenstein(0.5), index=index)
    lamp = tp.Source(tp.Point(), tp.Isotropic(energy=1.0), pulse=tp.Instant(0.0))
    return run(
        tp.Scene(lamp, walls, **looks, medium=fog, duration=duration * index / LIGHT_SPEED), tracking, 20_000
    )


@pytest.mark.parametrize("index", [1.0, 1.5])
@pytest.mark.parametrize("name", quick(["analog", "analog, forced", "analog, split"], "analog"))
def test_light_in_fog_is_absorbed_in_time_at_its_speed_there(index, name):
    """After a flight of 2 m exp(-0.8) is left, in fog of any index; in a room of mirrors as well."""
    for walls in ((), tp.Surface(tp.Box(size=1.0), tp.Mirror(), "walls")):
        ledger = flash(index, 2.0, TRACKINGS[name], walls).ledger
        assert_agrees(ledger["in_flight"], math.exp(-0.8), FALSE_ALARM)
        assert_agrees(ledger["absorbed"], -math.expm1(-0.8), FALSE_ALARM)
        assert_rejected(ledger["in_flight"], math.exp(-0.8 * 1.1))


def test_steady_light_in_fog_is_in_flight_for_a_lifetime():
    """A lamp that burns from 0 to the end: (1 - exp(-s))/s of its energy is still under way, s = 0.8."""
    fog = tp.Medium(absorption=0.4, scattering=1.6)
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=LIGHT_SPEED / 2.0))
    result = run(tp.Scene(lamp, medium=fog, duration=2.0 / LIGHT_SPEED))
    assert_agrees(result.ledger["in_flight"], -math.expm1(-0.8) / 0.8, FALSE_ALARM)


@pytest.mark.parametrize("index", [1.0, 1.5])
def test_light_that_met_nothing_in_fog_arrives_all_at_once(index):
    """A lane that has come to the wall waits while others still collide, and its clock with it."""
    sigma, way = 1.6, 0.26
    fog = tp.Medium(scattering=sigma, phase=tp.HenyeyGreenstein(0.9), index=index)
    times = np.linspace(0.0, 2.0, 81) * index / LIGHT_SPEED  # bins of 25 mm of way
    wall = tp.Surface(tp.Plane(center=(0, 0, way), normal=(0, 0, -1)), tp.Mirror(), "wall")
    lamp = tp.Source(tp.Point(), tp.Beam((0, 0, 1), energy=1.0), pulse=tp.Instant(0.0))
    looks = tp.Detector("wall", "straight", events=0, times=times)
    scene = tp.Scene(lamp, wall, looks, medium=fog, duration=times[-1])
    arrived = run(scene, "analog", 20_000)["straight"].energy_in
    assert np.flatnonzero(arrived.value).tolist() == [math.floor(way / 0.025)]
    assert_agrees(arrived.sum(), math.exp(-sigma * way), FALSE_ALARM)


def test_light_spreads_by_the_law_of_random_flights():
    """The mean square displacement of a snapshot, and of phase space at once; g forgotten would be seen."""
    fog = tp.Medium(scattering=2.0, phase=tp.HenyeyGreenstein(0.5))
    lamp = tp.Source(tp.Point(), tp.Isotropic(energy=1.0), pulse=tp.Instant(0.0))
    duration = 3.0 / LIGHT_SPEED
    looks = [tp.Snapshot(duration, particles=20_000, name="there")]
    result = run(tp.Scene(lamp, (), looks, medium=fog, duration=duration), None, 20_000)
    seen = result["there"]
    squares = (seen.positions**2).sum(axis=1)
    exact = random_flights.mean_square_displacement(6.0, 0.5) / 4  # 6 mean free paths of 0.5 m
    error = squares.std() / math.sqrt(len(squares))
    assert len(squares) == 20_000
    assert abs(squares.mean() - exact) < 4.42 * error
    assert abs(squares.mean() - random_flights.mean_square_displacement(6.0, 0.0) / 4) > 10 * error
    assert squares.max() <= 9.0 * (1 + 1e-12)


def test_weights_need_a_scene_without_a_clock_and_snapshots_light_of_one_speed():
    with pytest.raises(tp.SceneError, match="analog in a scene with a duration"):
        flash(1.0, 2.0, "weighted")
    lamp = tp.Source(tp.Point(), tp.Isotropic(energy=1.0), pulse=tp.Instant(0.0))
    scene = tp.Scene(lamp, (), tp.Snapshot(1e-9), medium=tp.Medium(scattering=2.0, index=1.5), duration=1e-8)
    with pytest.raises(tp.SceneError, match="need media of index=1"):
        run(scene, None, 1000)


# ---- on the command line ----

DEEP = ("run", "slab", "--set", "tau=20", "--set", "albedo=0.2", "--set", "g=0", "--set", "mu0=1", "--set", "incidence=beam",
    "--set", "phase=henyey-greenstein", "--particles", "2e4",
)  # fmt: skip


def output_of(*arguments):
    answer = CliRunner().invoke(app, [*DEEP, "--no-picture", *arguments])
    assert answer.exit_code == 0, answer.output
    return answer.output


def survivor_warnings(*arguments):
    return [text for text in json.loads(output_of("--json", *arguments))["warnings"] if "survivor" in text]


def test_a_warning_is_in_the_json_and_its_cure_is_an_option():
    """Followed once for the totals, and once more for the bins of direction; then nothing is in doubt."""
    found, advised = survivor_warnings(), []
    while found and len(advised) < 3:
        advised.append(
            min((text.partition("Tracking(roulette=")[2].partition(")")[0] for text in found), key=float)
        )
        found = survivor_warnings("--tracking", f"roulette={advised[-1]}")
    assert not found and 0 < len(advised) < 3, advised


def test_trackings_are_options_of_the_command_line():
    for tracking, words in (("analog", "analog absorption"), ("weighted", "by weight"), ("forced", "forced")):
        assert words in output_of("--tracking", tracking)
    for wrong in ("analogue", "roulette=much", "roulette=2", "roulet=0.1"):
        answer = CliRunner().invoke(app, [*DEEP, "--tracking", wrong])
        assert answer.exit_code != 0 and "racking" in answer.output, answer.output
