"""Error bars are right: over 3000 seeds z follows Student's t of batches - 1, for estimates of every kind.

Spread, mean and 95 % coverage are judged; limits follow from the numbers of seeds and tests, so that all together fail
right code in one of a thousand choices of seeds.  Error bars that are 10 % wrong are rejected in all but 1 of 400; of
2000 seeds it would be 1 in 25.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import transport as tp
from sims import diffuse_box, sun
from tests.agreement import assert_z_spread
from transport.theory import emitters, gas

SEEDS, PARTICLES, BATCHES = 3000, 10_000, 32
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


def _gas():
    """A square metre in all the gas that can reach it while particles fly 5 cm."""
    patch, reach = tp.Rectangle(width=1, height=1), 0.05
    box = tp.Box(size=(1 + 2 * reach, 1 + 2 * reach, 2 * reach))
    detectors = [tp.Detector(patch, name=side, side=side) for side in ("front", "back")]
    return tp.Scene(sources=tp.Source(box, tp.Gas(1.0, 1.0)), detectors=detectors, duration=reach)


def _of_gas(result):
    front, back = result["front"].irradiance, result["back"].irradiance
    return {"gas, one way": front, "gas, ratio of both ways": front / back}


def _of_box(result):
    floor, left = result["floor"].irradiance, result["left"].irradiance
    return {"wall's irradiance": floor, "ratio of walls": floor / left}


FACTOR = emitters.mean_disk_irradiance(1 / math.pi, RADIUS, RADIUS, RADIUS)
RUNS = {  # scene, what is estimated in it, exact values
    "disks": (_facing_disks(), _of_disks, (math.pi * RADIANCE * FACTOR, RADIANCE, FACTOR)),
    "sun": (sun.scene(), lambda result: {"aimed flux": result["meter"].flux_in}, (sun.exact()[sun.POWER],)),
    "gas": (_gas(), _of_gas, (gas.one_way_flux_density(1.0, 1.0), 1.0)),
    "box": (diffuse_box.scene(0.5, 1.0, "all walls"), _of_box, (2.0, 1.0)),
}
TESTS = sum(len(exact) for _, _, exact in RUNS.values())
FALSE_ALARM = 1e-3 / TESTS


def t_scores(scene, estimates_in, exact):
    """Name -> (value - exact) / error of each seed."""

    def of_seed(seed):
        run = tp.simulate(scene, PARTICLES, seed=seed, batches=BATCHES, threads=1, progress=False)
        estimates = estimates_in(run)
        return {n: (e.value - x) / e.error for (n, e), x in zip(estimates.items(), exact, strict=True)}

    first = of_seed(0)  # compiles what is not compiled yet
    with ThreadPoolExecutor(2) as pool:
        scores = [first, *pool.map(of_seed, range(1, SEEDS))]
    return {name: np.array([score[name] for score in scores]) for name in first}


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
