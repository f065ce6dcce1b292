"""Error bars are right: over 2000 seeds z follows Student's t of batches - 1, for estimates of every kind.

Spread, mean and 95 % coverage are judged; limits follow from the numbers of seeds and tests, so that all together fail
right code in one of a thousand choices of seeds.  An error bar that is 10 % wrong is rejected in 9 of 10.
"""

from __future__ import annotations

import math
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_z_spread
from transport.sims import diffuse_box, sun
from transport.theory import effusion, emitters

SEEDS, PARTICLES, BATCHES = 2000, 10_000, 16
RADIANCE, RADIUS = 100.0, 0.5
FACTOR = emitters.mean_disk_irradiance(1 / math.pi, RADIUS, RADIUS, RADIUS)  # a view factor


def _disks():
    """A disk as large as its distance is wide, and what leaves the source in two bins."""
    meter = tp.Disk(center=(0, 0, RADIUS), normal=(0, 0, -1), radius=RADIUS)
    leaving = tp.Detector(tp.Disk(radius=RADIUS), name="source", directions=tp.Directions(mu=2))
    source = tp.Source(tp.Disk(radius=RADIUS), tp.Lambertian(radiance=RADIANCE))
    return tp.Scene(sources=source, detectors=[tp.Detector(meter, name="meter"), leaving])


def _gas():
    """A square metre in all the gas that can reach it while particles fly 5 cm."""
    patch, reach = tp.Rectangle(width=1, height=1), 0.05
    box = tp.Box(size=(1 + 2 * reach, 1 + 2 * reach, 2 * reach))
    source, detector = tp.Source(box, tp.Gas(1.0, 1.0)), tp.Detector(patch, name="patch")
    return tp.Scene(sources=source, detectors=detector, duration=reach)


def _floors_share(result):
    return result["floor"].flux_in / sum(result[name].flux_in for name in diffuse_box.WALLS)


RUNS = {  # scene; name -> (estimate in its result, exact value)
    "disks": (
        _disks(),
        {
            "irradiance": (lambda r: r["meter"].irradiance, math.pi * RADIANCE * FACTOR),
            "radiance in a bin": (lambda r: r["source"].radiance_out[0], RADIANCE),
        },
    ),
    "sun": (sun.scene(), {"aimed flux": (lambda r: r["meter"].flux_in, sun.exact()[sun.POWER])}),
    "gas": (
        _gas(),
        {
            "flux of a gas": (lambda r: r["patch"].flux_in, effusion.one_way_flux_density(1.0, 1.0)),
            "net flux of a gas": (lambda r: r["patch"].net_flux_density, 0.0),
        },
    ),
    "box": (
        diffuse_box.scene(0.25, 0.75, "all walls"),
        {
            "irradiance of a wall": (lambda r: r["floor"].irradiance, 1.0),
            "ratio of fluxes": (_floors_share, 12 / 59),  # as the areas
        },
    ),
}
QUANTITIES = [(run, name) for run, (_, quantities) in RUNS.items() for name in quantities]
FALSE_ALARM = 1e-3 / len(QUANTITIES)


def t_scores(run):
    """Name -> (value - exact) / error of each seed."""
    scene, quantities = RUNS[run]
    scores = []
    for seed in range(SEEDS):
        result = tp.simulate(scene, PARTICLES, seed=seed, batches=BATCHES, threads=1, progress=False)
        estimates = [(estimate_in(result), exact) for estimate_in, exact in quantities.values()]
        scores.append([(estimate.value - exact) / estimate.error for estimate, exact in estimates])
    return dict(zip(quantities, np.transpose(scores), strict=True))


@pytest.fixture(scope="module")
def scores():
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        return dict(zip(RUNS, pool.map(t_scores, RUNS), strict=True))


@pytest.mark.parametrize(("run", "name"), QUANTITIES)
def test_scores_over_seeds_follow_students_t(run, name, scores):
    assert_z_spread(scores[run][name], BATCHES - 1, FALSE_ALARM)


@pytest.mark.parametrize("factor", [1.1, 1 / 1.1])
def test_error_bars_that_are_ten_percent_wrong_are_rejected(factor, scores):
    """Each quantity with a probability of 90 %, so four of the seven in all but 1 of 350 choices of seeds."""
    rejected = []
    for run, name in QUANTITIES:
        try:
            assert_z_spread(factor * scores[run][name], BATCHES - 1, FALSE_ALARM)
        except AssertionError:
            rejected.append(name)
    assert len(QUANTITIES) == 7
    assert len(rejected) >= 4


def test_a_bias_of_a_fifth_of_the_error_is_rejected(scores):
    for run, name in QUANTITIES:
        shifted = scores[run][name] + 0.2
        with pytest.raises(AssertionError, match="mean"):
            assert_z_spread(shifted, BATCHES - 1, FALSE_ALARM)
