"""The judge of samplers itself, and the physics that the engine's samplers are made of, against theory.

Each judgement fails right code in one of 10^6 seeds.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from numba import njit

from tests.sampling import (
    assert_reciprocal,
    assert_samples,
    cell_probabilities,
    cells_about,
    cosine_law,
    even_cells,
    glossy,
    lambert,
    rejects,
)
from transport.physics import interfaces, sight
from transport.physics import microfacets as engine_microfacets
from transport.physics.device import ARITHMETIC
from transport.theory import fresnel, microfacets, phases

DRAWS = 100_000


def test_the_judge_integrates_densities_exactly():
    cells = even_cells()
    exact = np.abs(np.diff(np.sign(cells.mu) * cells.mu**2)) / 2
    assert cell_probabilities(lambert(0.5, 0.5), cells).reshape(cells.shape).sum(axis=1) == pytest.approx(
        exact, abs=1e-14
    )
    narrow = cells_about(0.5, math.pi, 1e-3)
    assert cell_probabilities(glossy(0.5, 1e-3), narrow).sum() == pytest.approx(1, abs=1e-9)
    with pytest.raises(ValueError, match="kinks"):
        cell_probabilities(lambda mu, phi: np.where(mu > 0.123, 1.0, 0.0), even_cells(1, 1))


def test_the_judge_takes_right_draws_and_rejects_wrong_ones():
    draws, cells = cosine_law(DRAWS, 3, side=1.0), even_cells()
    assert_samples(draws, lambert(), cells)
    assert rejects(draws, lambda mu, phi: np.where(mu > 0, 1 / (2 * math.pi), 0.0), cells)  # a dropped cosine
    assert rejects(draws, lambda mu, phi: lambert()(mu, phi) * (1 + 0.05 * np.cos(phi)), cells)
    with pytest.raises(ValueError, match="add up to 1"):  # a hundredth lost
        assert_samples(draws, lambert(0.99), cells)
    beams = [((0.0, 0.6, 0.8), 0.25)]
    mixed = np.where(np.arange(DRAWS)[:, None] % 4 == 0, beams[0][0], draws)
    assert_samples(mixed, lambert(0.75), cells, beams)
    assert rejects(mixed, lambert(0.77), cells, [(beams[0][0], 0.23)])
    assert rejects(mixed, lambert(0.75), cells, [((0.0, 0.6, -0.8), 0.25)])


def test_the_judge_of_reciprocity_sees_what_is_not_reciprocal():
    into, cells = cosine_law(DRAWS, 4), even_cells(4, 4)
    assert_reciprocal(into, cosine_law(DRAWS, 5, side=1.0), cells)
    assert_reciprocal(into, into * [1, 1, -1], even_cells(4, 5))  # mirrors, through other cells
    lifted = cosine_law(DRAWS, 5, side=1.0)
    lifted[into[:, 2] < -0.5] *= [-1, -1, 1]
    lifted[:, 0] = np.where(
        into[:, 2] < -0.7, np.abs(lifted[:, 0]), lifted[:, 0]
    )  # steep light goes to one side
    assert rejects(into, lifted, cells, judge=assert_reciprocal)


@njit(**ARITHMETIC)
def reflectances(cosines, ratio, excess):
    found = np.empty((len(cosines), 2))
    for k in range(len(cosines)):
        found[k, 0], found[k, 1] = interfaces.fresnel(cosines[k], ratio, excess)
    return found


@pytest.mark.parametrize("indices", [(1.5, 1.0), (1.0, 1.5), (1 + 1e-12, 1.0), (1.0, 1 + 1e-12), (2.4, 1.3)])
def test_fresnel_in_the_engine_is_that_of_theory(indices):
    """To rounding; near the critical angle as well as a rounded index knows it, and 1 beyond."""
    inside, outside = indices
    ratio, excess = inside / outside, (inside - outside) * (inside + outside) / outside**2
    cosines = np.r_[np.geomspace(1e-12, 1, 300), np.linspace(0.01, 1, 200)]
    found = reflectances(cosines, ratio, excess)
    q2 = (ratio - 1) * (ratio + 1) + cosines**2
    known = 1e-15 * (1 + cosines**2 / np.abs(np.where(q2 == 0, 1, q2))) + 2e-4 * (abs(ratio - 1) < 1e-9)
    exact = fresnel.reflectance(cosines, ratio)
    assert (np.abs(found[:, 0] - exact) <= known * 8).all()
    beyond = cosines < np.cos(fresnel.critical_angle(ratio)) * (1 - 1e-3)
    assert (found[beyond, 0] == 1).all() if ratio < 1 else (found[:, 0] < 1).all()
    passing = exact < 1
    assert found[passing, 1] == pytest.approx(ratio * fresnel.snell_cosine(cosines[passing], ratio), rel=1e-3)


@pytest.mark.parametrize("g", [0.9, 0.3, 1e-9, -0.5, -0.99, 0.0])
def test_densities_of_phase_functions_in_the_engine_are_those_of_theory(g):
    """To rounding, compiled and as plain Python, against the formulas in 50 digits."""
    for mu in (-1.0, -0.7, -1e-9, 0.0, 0.2, 1 - 1e-9, 1.0):
        with mp.workdps(50):
            a, m = mp.mpf(g), mp.mpf(mu)
            exact = float((1 - a * a) / (4 * mp.pi * (1 + a * a - 2 * a * m) ** 1.5))
            small = float(3 * (1 + m * m) / (16 * mp.pi))
        plain = getattr(sight.henyey_greenstein_density, "py_func", sight.henyey_greenstein_density)
        found = sight.henyey_greenstein_density(g, mu), plain(g, mu), phases.henyey_greenstein(mu, g)
        assert found == pytest.approx([exact] * 3, rel=1e-13)
        plain = getattr(sight.rayleigh_density, "py_func", sight.rayleigh_density)
        assert (sight.rayleigh_density(mu), plain(mu), phases.rayleigh(mu)) == pytest.approx(
            [small] * 3, rel=1e-14
        )


@njit(**ARITHMETIC)
def unshadowed(mus, others, alpha):
    found = np.empty(len(mus))
    for k in range(len(mus)):
        found[k] = engine_microfacets.unshadowed_share(mus[k], others[k], alpha)
    return found


@pytest.mark.parametrize("roughness", [1.0, 0.1, 1e-3])
def test_microfacets_in_the_engine_are_those_of_theory(roughness):
    mu, other = np.random.default_rng(9).random((2, 500))
    share = microfacets.joint_shadowing(mu, other, roughness) / microfacets.shadowing(mu, roughness)
    assert unshadowed(mu, other, roughness) == pytest.approx(share, rel=1e-12)
    assert (unshadowed(mu, -other, roughness) == 0).all()
