"""However histories are followed through media, the same comes out where nothing is exact, and nothing is left over.

All runs have seed 1; each judgement fails right code in one of 10^5 seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import chdtrc

import transport as tp
from tests.agreement import assert_agrees
from tests.tracking_scenes import CLEAR, FALSE_ALARM, TRACKINGS, run, slab
from transport.theory import ordinates


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


def _pipe():
    """A pipe of mirrors between a black and a white lid, full of haze."""
    pipe = tp.Surface(tp.Cylinder(radius=0.5, height=3.0), tp.Mirror(0.95), "pipe")
    lids = [
        tp.Surface(tp.Disk(center=(0, 0, z), radius=0.5), kind, name)
        for z, kind, name in ((1.5, tp.Black(), "top"), (-1.5, tp.Diffuse(0.5), "bottom"))
    ]
    haze = tp.Medium(absorption=0.1, scattering=0.4, phase=tp.HenyeyGreenstein(0.7))
    lamp = tp.Source(tp.Point(position=(0, 0, 0.1)), tp.Isotropic(power=1.0))
    looks = [
        tp.Detector("top", side="back"),
        tp.Detector("bottom"),
        tp.VolumeDetector(tp.Sphere(radius=0.4), "within"),
    ]
    return tp.Scene(lamp, [pipe, *lids], looks, medium=haze), ("top", "bottom"), "within"


@pytest.mark.parametrize("make", [_ball_of_glass, _shells, _pipe])
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


def test_a_conservative_slab_returns_or_passes_all():
    """tau 100: R + T = 1 in every batch, to the last unit."""
    exact = ordinates.slab(100.0, 1.0)
    for tracking in ("weighted", "analog"):
        result = run(slab(100.0, 1.0), tracking, 10_000)
        returned, passed = result["top"].flux_out, result["bottom"].flux_out
        assert_agrees(passed, exact.transmitted, FALSE_ALARM)
        assert result.ledger["absorbed"].value == 0
        assert (returned + passed).value == 1


@pytest.mark.parametrize("material", [tp.Mirror(), tp.Diffuse(1.0)], ids=["mirrors", "white"])
@pytest.mark.parametrize("name", ["analog", "weighted", "roulette 0.05", "forced", "analog, forced", "split"])
def test_what_is_shut_in_with_fog_is_absorbed_by_it(material, name):
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
