"""A glowing medium's light by closed forms: references, thin and thick limits, the balance of power.

A comment such as `F.sphere_escape_probability` names the entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

from transport.theory import glow
from transport.theory.enclosures import mean_chord

EDGES = np.array([0.0, 0.2, 0.7, 0.95, 1.0])


def close(value, exact, relative=1e-14):
    return np.allclose(np.asarray(value, float), np.asarray(exact, float), rtol=relative, atol=0)


def test_escape_meets_references():
    ball = {0.01: 0.9925398339030994, 1.0: 0.5272521936411892, 5.0: 0.14700149819768216}
    slab = {0.1: 0.8370854209172118, 1.0: 0.3903080328022398, 5.0: 0.09982443982144587}
    for x, exact in ball.items():  # F.sphere_escape_probability
        assert close(glow.ball_escape(x), exact)
    for tau, exact in slab.items():  # F.slab_escape_probability
        assert close(glow.slab_escape(tau), exact)


@pytest.mark.parametrize("x", [1e-12, 1e-3, 0.3, 0.4999999, 0.5, 0.7, 20.0, 1e5])
def test_escape_keeps_its_digits_where_the_textbook_form_does_not(x):
    with mp.workdps(60):
        m = mp.mpf(x)
        ball = 3 / (8 * m**3) * (2 * m**2 - 1 + (1 + 2 * m) * mp.exp(-2 * m))
        slab = (1 - 2 * mp.expint(3, m)) / (2 * m)
    assert close(glow.ball_escape(x), float(ball), 4e-15)
    assert close(glow.slab_escape(x), float(slab), 4e-15)
    textbook = 3 / (8 * x**3) * (2 * x**2 - 1 + (1 + 2 * x) * math.exp(-2 * x))
    assert x > 1e-2 or not close(textbook, float(ball), 1e-11)


def test_functions_take_arrays():
    x = np.array([0.1, 0.5, 3.0])
    for function in (
        glow.ball_emissivity,
        glow.ball_escape,
        glow.slab_emissivity,
        glow.slab_escape,
        glow.ray_share,
    ):
        assert close(function(x), [function(each) for each in x])


def test_what_leaves_is_the_mean_over_chords():
    """Emissivity of a ball: ∫ (1 - e^(-2xμ)) 2 μ dμ; of a slab, with chords d/μ."""
    nodes, weights = np.polynomial.legendre.leggauss(80)
    mu, weights = (nodes + 1) / 2, weights / 2
    assert close(glow.ball_emissivity(1.7), weights * 2 * mu @ glow.ray_share(2 * 1.7 * mu))
    assert close(glow.slab_emissivity(1.7), weights * 2 * mu @ glow.ray_share(1.7 / mu), 1e-9)
    shares, areas = glow.ball_rim_share(1.7, EDGES), np.diff(EDGES**2)
    assert close(shares @ areas, glow.ball_emissivity(1.7))
    assert not close(glow.ball_rim_share(1.7, EDGES), glow.ray_share(1.7 * (EDGES[1:] + EDGES[:-1])), 1e-3)


def test_a_mean_beam_is_four_volumes_over_surface_where_thin():
    thin = 1e-9
    ball = glow.mean_beam_length(glow.ball_emissivity(thin), thin)
    assert close(ball, mean_chord(4 / 3, 4), 1e-8)
    assert close(glow.mean_beam_length(glow.slab_emissivity(thin), thin), 2.0, 1e-7)
    assert glow.mean_beam_length(glow.ball_emissivity(3.0), 3.0) < ball  # Hottel: some 5 % less, and falling
    assert close(
        glow.ray_share(3.0 * glow.mean_beam_length(glow.ball_emissivity(3.0), 3.0)), glow.ball_emissivity(3.0)
    )


@pytest.mark.parametrize("x", [1e-3, 1.0, 30.0])
def test_fluence_within_a_ball_by_quadrature_at_thirty_digits(x):
    for place in (0.0, 0.4, 0.99, 1 - 1e-9, 1.0):
        rho = mp.mpf(place)

        def ray(mu, rho=rho):
            return -mp.expm1(-x * (rho * mu + mp.sqrt(1 - rho**2 * (1 - mu**2)))) / 2

        ends = [-1, 0, 1] if place < 0.99 else [-1, -0.01, -1e-4, 0, 1e-4, 0.01, 1]
        with mp.workdps(30):
            assert close(glow.ball_fluence_share(x, place), mp.quad(ray, ends), 1e-11)


@pytest.mark.parametrize("x", [1e-3, 1.0, 30.0])
def test_what_is_emitted_escapes_or_is_absorbed(x):
    """σ_a 4π L V times the mean fluence share is what stays."""
    shares = glow.ball_shell_shares(x, EDGES)
    assert close(shares @ np.diff(EDGES**3), 1 - glow.ball_escape(x), 1e-8 if x < 0.1 else 1e-11)
    assert (np.diff(shares) < 0).all()


def test_equilibrium_asks_for_absorption_times_radiance_and_the_index_squared():
    assert glow.emission(0.3, 2.0) == pytest.approx(0.6)
    assert glow.emission(0.3, 2.0, 1.5) == pytest.approx(1.35)
