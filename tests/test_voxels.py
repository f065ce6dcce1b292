"""Straight light through voxels: sums along lines, and means in the shadow, each against another way."""

from __future__ import annotations

import numpy as np
import pytest

from transport.theory.attenuation import optical_depths, shadow_means

LOW, HIGH = (-3.0, -2.0, 1.0), (5.0, 2.0, 4.0)
TANGENT = 0.8


@pytest.fixture(scope="module")
def extinction():
    cells = np.random.default_rng(1).random((8, 5, 6))
    return np.where(cells > 0.4, cells, 0.0)


def test_an_even_box_has_its_extinction_times_the_chord():
    even, starts = np.full((3, 4, 5), 0.7), np.array([[0.0, 0.0, 0.0], [-4.0, 0.1, 3.0], [9.0, 9.0, 9.0]])
    assert optical_depths(even, LOW, HIGH, starts[:1], (0, 0, 1)) == pytest.approx(0.7 * 3, rel=1e-14)
    slant = optical_depths(even, LOW, HIGH, starts[1:2], (1, 0, -0.1))
    assert slant == pytest.approx(0.7 * 8 * np.hypot(1, 0.1), rel=1e-14)
    assert optical_depths(even, LOW, HIGH, starts, (0, 0, 1))[2] == 0


@pytest.mark.parametrize("direction", [(1, 2, 3), (-1, 0.3, 0.2), (0, 0, -1), (0.8, 0, -1)])
def test_lines_gather_what_is_along_them(extinction, direction):
    draws = np.random.default_rng(2)
    starts = draws.uniform(LOW, HIGH, (20, 3))
    found = optical_depths(extinction, LOW, HIGH, starts, direction)
    unit = np.array(direction) / np.linalg.norm(direction)
    steps = (np.arange(100_000) + 0.5) * 2e-4
    for start, depth in zip(starts, found, strict=True):
        share = (start + steps[:, None] * unit - LOW) / (np.array(HIGH) - LOW)
        inside = ((share > 0) & (share < 1)).all(axis=1)
        index = (share[inside] * extinction.shape).astype(int)
        assert depth == pytest.approx(extinction[tuple(index.T)].sum() * 2e-4, abs=2e-3)


@pytest.mark.parametrize("tangent", [TANGENT, 0.05, -1.3, 0.0])
def test_means_in_the_shadow_are_those_of_many_lines(extinction, tangent):
    """To the error of a midpoint rule, whose lines come from the other function."""
    edges = np.array([-5.0, -2.2, -1.0, 0.3, 4.0, 9.0])
    exact = shadow_means(extinction, LOW, HIGH, tangent, edges)
    rows = np.linspace(LOW[1], HIGH[1], 6)
    n = 4000
    for row in (0, 3):
        for bin_ in range(len(edges) - 1):
            x = edges[bin_] + (np.arange(n) + 0.5) / n * (edges[bin_ + 1] - edges[bin_])
            places = np.stack([x, np.full(n, rows[row : row + 2].mean()), np.zeros(n)], axis=1)
            depths = optical_depths(extinction, LOW, HIGH, places, (-tangent, 0, 1))
            assert exact[bin_, row] == pytest.approx(np.exp(-depths).mean(), abs=2e-4)


def test_means_over_bins_join_to_the_mean_over_all(extinction):
    fine = np.linspace(-4, 9, 301)
    parts = shadow_means(extinction, LOW, HIGH, TANGENT, fine)
    [whole] = shadow_means(extinction, LOW, HIGH, TANGENT, fine[[0, -1]])
    assert parts.mean(axis=0) == pytest.approx(whole, rel=1e-13)


def test_the_mean_of_the_exponential_is_not_that_of_the_mean(extinction):
    edges = np.linspace(-4, 9, 14)
    exact = shadow_means(extinction, LOW, HIGH, TANGENT, edges)
    depths = [
        optical_depths(extinction, LOW, HIGH, [[x, 0.0, 0.0]], (-TANGENT, 0, 1))[0]
        for x in (edges[1:] + edges[:-1]) / 2
    ]
    assert np.abs(np.exp(-np.array(depths)) - exact[:, 2]).max() > 0.02


def test_without_voxels_in_the_way_all_comes_through():
    empty = shadow_means(np.zeros((2, 2, 2)), LOW, HIGH, TANGENT, np.linspace(-9, 9, 7))
    assert (empty == 1).all()
