"""Intensity curves of lamps: exact in every bin, a sharp cut-off, and a sum over directions that is the power.

Each statistical test fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from tests.sim_runs import judge
from transport.sims import goniophotometer as sim
from transport.verification.experiment import run_experiment

FALSE_ALARM = 1e-5


@pytest.fixture(scope="module")
def outcomes():
    found = run_experiment(sim, particles=1_000_000, seed=1, threads=2)
    return {o.given["lamp"]: o for o in found}


# ---- the exact curves ----


@pytest.mark.parametrize("lamp", sim.LAMPS)
@pytest.mark.parametrize("length", [0.02, 0.1, 0.4])
def test_the_curve_sums_to_the_power_that_leaves(lamp, length):
    """By view factors, which the curve does not know of; the bins sum to it as well."""
    ends = sim.edges(lamp, length)
    total = (sim.bin_intensities(lamp, 10.0, length) * -2 * math.pi * np.diff(np.cos(ends))).sum()
    assert total == pytest.approx(sim.power_out(lamp, 10.0, length), rel=1e-9)


def test_the_tube_cuts_off_where_its_mouth_leaves_the_disk():
    length = 0.1
    cut = sim.cut_off(length)
    assert math.tan(cut) == pytest.approx(2 * sim.RADIUS / length)
    inside, outside = sim.intensity("tube", np.array([0.999 * cut, 1.001 * cut]), 10.0, length)
    assert inside > 0 == outside
    both = sim.intensity("tube", np.array([0.3]), 10.0, length) + sim.intensity(
        "shade", np.array([0.3]), 10.0, length
    )
    assert both == pytest.approx(sim.intensity("disk", np.array([0.3]), 10.0, length))


# ---- the run ----


@pytest.mark.slow
def test_all_rows_agree(outcomes):
    assert len(judge(list(outcomes.values()))) == 28


@pytest.mark.slow
@pytest.mark.parametrize("lamp", sim.LAMPS)
def test_every_bin_agrees(lamp, outcomes):
    outcome = outcomes[lamp]
    measured = outcome.result["photometer"].intensity_out
    means = sim.bin_intensities(lamp, outcome.given["power"], outcome.given["length"])
    lit = np.flatnonzero(means > 0)
    for i in lit:
        assert_agrees(measured[int(i)], means[i], FALSE_ALARM / len(lit))


@pytest.mark.slow
def test_wrong_curves_are_rejected(outcomes):
    """Planted: a disk that shines alike to all sides, a sphere with a cosine, a tube that hides nothing, or all too early."""
    for lamp, wrong in (("disk", "sphere"), ("sphere", "disk"), ("tube", "disk"), ("shade", "disk")):
        outcome = outcomes[lamp]
        power, length = outcome.given["power"], outcome.given["length"]
        measured, ends = outcome.result["photometer"].intensity_out, sim.edges(lamp, length)
        bin_at_the_axis = measured[1]
        middle = np.array([(ends[1] + ends[2]) / 2])
        assert_rejected(bin_at_the_axis, float(sim.intensity(wrong, middle, power, length)[0]))
    tube = outcomes["tube"]
    same_bins = tube.result["photometer"].intensity_out[sim.BINS - 3]
    theta = np.array([np.mean(sim.edges("tube", tube.given["length"])[sim.BINS - 3 : sim.BINS - 1])])
    assert_rejected(
        same_bins, float(sim.intensity("tube", theta, tube.given["power"], 1.2 * tube.given["length"])[0])
    )


@pytest.mark.slow
def test_nothing_leaves_beyond_the_cut_off(outcomes):
    beyond = outcomes["tube"].result["photometer"].intensity_out[sim.BINS :]
    assert (beyond.value == 0).all()


@pytest.mark.slow
@pytest.mark.parametrize(("lamp", "share"), [("tube", 1.0), ("shade", 1.0), ("tube", 0.5)])
def test_what_the_tube_absorbs_is_missing_from_the_sum(lamp, share, outcomes):
    assert_rejected(outcomes[lamp][sim.SHARE].estimate, share)


@pytest.mark.slow
def test_a_white_tube_is_another_lamp():
    """Planted: a tube whose wall reflects a tenth sends light beyond the cut-off."""
    scene = sim.scene("tube")
    wall = scene.surfaces[0].shape
    white = tp.Scene(
        scene.sources, surfaces=tp.Surface(wall, tp.Diffuse(0.1), "tube"), detectors=scene.detectors
    )
    rows = sim.measure(tp.simulate(white, particles=400_000, seed=1))
    assert_rejected(rows[sim.TOTAL], sim.exact(lamp="tube")[sim.TOTAL])
    assert rows[sim.BEYOND].value > 0
