"""A ball of fog: published critical radii, balance, light that only fades, and diffusion where it is thick."""

from __future__ import annotations

import math

import numpy as np
import pytest

from transport.theory import fog_balls, glow


@pytest.mark.slow
@pytest.mark.parametrize(("albedo", "radius"), [(1.40, 1.9853434324), (1.30, 2.4248249802)])
def test_balls_of_fissile_stuff_are_critical_at_the_radius_of_the_benchmarks(albedo, radius):
    """Sood, Forster and Parsons (2003), PUb-1-0-SP and Ua-1-0-SP: with so many a collision the fluence sustains itself."""
    _, _, kernel = fog_balls.operator_of(radius, radius)
    assert 1 / np.linalg.eigvals(kernel).real.max() == pytest.approx(albedo, rel=1e-9, abs=0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radius", "albedo", "lamp"),
    [
        (0.1, 0.5, 0.1),
        (1.0, 0.9, 0.3),
        (10.0, 1.0, 1.0),
        (10.0, 0.9, 1.0),
        (20.0, 0.99, 2.0),
        (5.0, 0.5, 5.0),
    ],
)
def test_what_does_not_escape_a_ball_of_fog_is_absorbed(radius, albedo, lamp):
    """By what each place sends out, and by what it takes: two integrals of the solution that know nothing of each other."""
    ball = fog_balls.solved_ball(radius, albedo, lamp)
    assert ball.escaping + ball.absorbed == pytest.approx(1, abs=1e-11)


@pytest.mark.slow
def test_without_scattering_a_ball_dims_its_light_by_the_length_of_the_way_out():
    for radius in (0.01, 1.0, 10.0):
        assert fog_balls.escape(radius, 0.0) == pytest.approx(glow.ball_escape(radius), rel=1e-11, abs=0)
    assert fog_balls.escape(3.0, 0.0, 1e-3) == pytest.approx(math.exp(-3), rel=1e-6, abs=0)

    x, w = np.polynomial.legendre.leggauss(40)  # over the lamp's radius, from 0 to 1, and over the cosine
    r, mu = (1 + x[:, None]) / 2, x
    way_out = np.sqrt(9 - r**2 * (1 - mu**2)) - r * mu
    passes = (w / 2) @ (1.5 * r**2 * np.exp(-way_out)) @ w
    assert fog_balls.escape(3.0, 0.0, 1.0) == pytest.approx(passes, rel=1e-11, abs=0)


@pytest.mark.slow
def test_thick_white_fog_is_left_by_diffusion():
    """Of a lamp in the middle φ = 3 (1/r - 1/(R + q))/4π, q = 0.7104: 3 (R²/2 - R³/3(R + q)) collisions, to about q."""
    collisions = fog_balls.solved_ball(10.0, 1.0, 0.1).collisions
    assert collisions == pytest.approx(3 * (50 - 1000 / (3 * 10.7104)), abs=0.7104)
    assert fog_balls.solved_ball(10.0, 1.0, 1.0).collisions == pytest.approx(57.007, abs=1e-3)


def test_balls_without_a_solution_are_refused():
    for wrong in ((0.0, 0.5, 0.1), (51.0, 0.5, 0.1), (1.0, 1.1, 0.1), (1.0, 0.5, 2.0)):
        with pytest.raises(ValueError, match="solved_ball"):
            fog_balls.solved_ball(*wrong)
