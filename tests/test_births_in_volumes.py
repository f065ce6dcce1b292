"""Particles are born evenly in boxes and balls, and normally in clouds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ndtr

import transport as tp
from tests.agreement import assert_follows
from tests.phase_scenes import FALSE_ALARM, histories, run_alone, streaming


def test_positions_of_a_gas_are_uniform_in_its_box():
    """Chi-square over cells of the box, at the start."""
    edges = tuple(np.linspace(-0.75, 0.75, 9))
    look = tp.PhaseSpace(x=edges, z=edges, time=0.0)
    result = tp.simulate(streaming(look), particles=200_000, seed=1)
    counts = histories(result, result["phase_space"].number.value)
    assert counts.sum() == 200_000
    assert_follows(counts, np.full(64, 1 / 64), FALSE_ALARM)


def test_positions_of_a_gas_are_uniform_in_its_ball():
    """The cube of the radius, the cosine and the azimuth are uniform and independent."""
    gas = tp.Source(tp.Sphere(center=(1, 2, 3), radius=2.0), tp.Gas(number=1.0, speed=1.0))
    shot = tp.Snapshot(0.0, particles=200_000)
    x, y, z = (run_alone(gas, shot).positions - (1, 2, 3)).T
    r = np.sqrt(x**2 + y**2 + z**2)
    assert r.max() <= 2 * (1 + 1e-12)
    counts, _ = np.histogramdd(
        [(r / 2) ** 3, z / r, np.arctan2(y, x)], [8] * 3, [(0, 1), (-1, 1), (-np.pi, np.pi)]
    )
    assert_follows(counts, np.full(512, 1 / 512), FALSE_ALARM)
    wrong = np.diff(np.linspace(0, 1, 9) ** 0.95)
    with pytest.raises(AssertionError):
        assert_follows(counts.sum(axis=(1, 2)), wrong, FALSE_ALARM)


def test_positions_of_a_cloud_are_normal_each_with_its_own_width():
    gas = tp.Source(tp.Cloud(center=(1, 2, 3), sigma=(0.5, 1.0, 2.0)), tp.Gas(number=1.0, speed=1.0))
    shot = tp.Snapshot(0.0, particles=200_000)
    places = (run_alone(gas, shot).positions - (1, 2, 3)) / (0.5, 1.0, 2.0)
    edges = np.concatenate([[-9], np.linspace(-2, 2, 9), [9]])
    shares = np.diff(ndtr(edges))
    counts, _ = np.histogramdd(places, [edges] * 3)
    assert counts.sum() == 200_000
    assert_follows(counts, np.einsum("i,j,k->ijk", shares, shares, shares), FALSE_ALARM)
    with pytest.raises(AssertionError):
        assert_follows(counts.sum(axis=(0, 1)), np.diff(ndtr(edges / 1.02)), FALSE_ALARM)
