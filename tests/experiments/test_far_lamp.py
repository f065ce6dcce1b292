"""A far lamp is a beam: how far its light over a desk is from even and from parallel; falls with another power are rejected.

Each statistical test fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math

import pytest

from tests.agreement import assert_agrees, assert_rejected
from transport.sims import far_lamp as sim
from transport.verification.experiment import run_experiment

FALSE_ALARM = 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("height", [2.0, 16.0])
def test_both_deviations_from_a_beam_are_exact(height):
    """Planted: light that is a beam already, a fall with 1/d, and half of what is missing."""
    [outcome] = run_experiment(sim, {"height": height}, particles=2_000_000, seed=1)
    for name in (sim.EVEN, sim.SPREAD):
        row = outcome[name]
        assert_agrees(row.estimate, row.exact, FALSE_ALARM)
        assert_rejected(row.estimate, 1.0)
        assert_rejected(row.estimate, 1 + (row.exact - 1) * height)
        assert_rejected(row.estimate, 1 + (row.exact - 1) / 2)


def test_a_lamp_is_a_beam_to_one_percent_from_both_heights_on():
    even, parallel = sim.even_from(0.01), sim.parallel_from(0.01)
    assert even / sim.DESK == pytest.approx(12.2, abs=0.05)
    assert parallel / sim.RADIUS == pytest.approx(5.04, abs=0.01)
    assert (1 + (sim.DESK / even) ** 2) ** -1.5 == pytest.approx(0.99, rel=1e-12)
    cosine = math.sqrt(1 - (sim.RADIUS / parallel) ** 2)
    assert 2 / (1 + cosine) == pytest.approx(1.01, rel=1e-12)


@pytest.mark.parametrize("height", [1.0, 6.1, 100.0])
def test_strips_are_as_points_of_the_desk(height):
    """The means over strips beside the closed forms in the middle of each, which differ by little."""
    rows = sim.exact(height=height)
    at_a_point = (1 + (sim.DESK / height) ** 2) ** -1.5
    assert rows[sim.EVEN] - 1 == pytest.approx(at_a_point - 1, rel=0.02)
    cosine = math.sqrt(1 - (sim.RADIUS / height) ** 2)
    assert rows[sim.SPREAD] - 1 == pytest.approx(2 / (1 + cosine) - 1, rel=0.02)
