"""Error bars are right: over 2000 seeds z follows Student's t of batches - 1, for estimates of every kind.

Spread, mean and 95 % coverage are judged; limits follow from the numbers of seeds and tests, so that all together fail
right code in one of a thousand choices of seeds, and an error bar that is 10 % wrong is rejected.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from sims import diffuse_box, photon_gas, sun
from tests.agreement import assert_z_spread
from transport.theory import emitters, gas

SEEDS, PARTICLES, BATCHES = 2000, 10_000, 16
RADIANCE, RADIUS = 100.0, 0.5


def _facing_disks():
    meter = tp.Disk(center=(0, 0, RADIUS), normal=(0, 0, -1), radius=RADIUS)
    return tp.Scene(
        sources=tp.Source(tp.Disk(radius=RADIUS), tp.Lambertian(radiance=RADIANCE)),
        detectors=[
            tp.Detector(meter, name="meter"),
            tp.Detector(tp.Disk(radius=RADIUS), name="source", directions=tp.Directions(theta=(0, math.pi / 6, 1.0))),
        ],
    )


def _of_disks(result):
    return {
        "irradiance": result["meter"].irradiance,
        "radiance bin": result["source"].radiance_out[0],
        "view factor": result["meter"].flux_in / result.ledger["emitted"],
    }


def _of_gas(result):
    front, back = (result[detector.name] for detector in result.scene.detectors)
    return {"gas, one way": front.irradiance, "gas, ratio of both": front.irradiance / back.irradiance}


def _of_box(result):
    floor, left = result["floor"].irradiance, result["left"].irradiance
    return {"wall's irradiance": floor, "ratio of walls": floor / left}


FACTOR = emitters.mean_disk_irradiance(1 / math.pi, RADIUS, RADIUS, RADIUS)
RUNS = {  # scene, what is estimated in it, exact values
    "disks": (_facing_disks(), _of_disks, (math.pi * RADIANCE * FACTOR, RADIANCE, FACTOR)),
    "sun": (sun.scene(), lambda result: {"aimed flux": result["meter"].flux_in}, (sun.exact()[sun.POWER],)),
    "gas": (photon_gas.scene(1.0, 1.0), _of_gas, (gas.one_way_flux_density(1.0, 1.0), 1.0)),
    "box": (diffuse_box.scene(0.5, 1.0, "all walls"), _of_box, (2.0, 1.0)),
}
TESTS = sum(len(exact) for _, _, exact in RUNS.values())
FALSE_ALARM = 1e-3 / TESTS


def t_scores(scene, estimates_in, exact):
    """Name -> (value - exact) / error of each seed."""
    scores = []
    for seed in range(SEEDS):
        result = tp.simulate(scene, particles=PARTICLES, seed=seed, batches=BATCHES, threads=1)
        estimates = estimates_in(result)
        scores.append([(e.value - x) / e.error for e, x in zip(estimates.values(), exact, strict=True)])
    return dict(zip(estimates, np.transpose(scores), strict=True))


@pytest.mark.parametrize("name", RUNS)
def test_scores_follow_students_t_and_a_tenth_more_or_less_does_not(name):
    for quantity, t in t_scores(*RUNS[name]).items():
        try:
            assert_z_spread(t, BATCHES - 1, FALSE_ALARM)
        except AssertionError as error:
            raise AssertionError(f"{quantity}: {error}") from None
        for factor in (1.1, 1 / 1.1):
            with pytest.raises(AssertionError, match="spread"):
                assert_z_spread(factor * t, BATCHES - 1, FALSE_ALARM)


def test_five_kinds_of_quantities_are_tested():
    assert TESTS >= 5
