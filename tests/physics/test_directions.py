"""Sampled directions follow their densities about any normal and stay unit vectors; rays and flights share what they bring.

Draws come from the engine's own streams; each sampler is counted in bins of a frame of the test's own and judged by
chi-square.  Every judgement has a rate of false alarms of 1e-6, all together below 1e-4.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from numba import njit

from tests.agreement import assert_follows
from transport.physics import connections
from transport.physics.device import ARITHMETIC
from transport.physics.directions import sample_cosine_law, sample_isotropic, turned_by
from transport.physics.interfaces import reflected
from transport.physics.scattering import turned_by_angle
from transport.physics.streams import DIRECTION, random_words, uniform

FALSE_ALARM = 1e-6
DRAWS = 200_000
POLAR, ROUND = 20, 24  # bins
ULP = 2.0**-52
UNIT_LENGTH = 4 * ULP  # measured 1.5
NORMALS = {
    "+z": (0, 0, 1),
    "-z": (0, 0, -1),
    "-z + tiny": (1e-9, -2e-9, -1),
    "-z + tinier": (1e-17, 1e-300, -1),
    "+x": (1, 0, 0),
    "-y": (0, -1, 0),
    "just below the horizon": (0.6, 0.8, -1e-300),
    "tilted": (0.3, -0.5, 0.7),
    "tilted down": (-0.7, 0.1, -0.4),
}


@njit(**ARITHMETIC)
def bounced(u, normals, bounces):
    """Directions after reflections at these normals in turn."""
    for k in range(len(u)):
        for i in range(bounces):
            n = normals[(k + i) % len(normals)]
            mu = u[k, 0] * n[0] + u[k, 1] * n[1] + u[k, 2] * n[2]
            u[k, 0], u[k, 1], u[k, 2] = reflected(u[k, 0], u[k, 1], u[k, 2], n[0], n[1], n[2], mu)
    return u


@njit(**ARITHMETIC)
def uniforms(count, seed):
    u, turn = np.empty(count), np.empty(count)
    for k in range(count):
        w0, w1, w2, w3 = random_words(k, 0, 0, DIRECTION, seed, 0)
        u[k], turn[k] = uniform(w0, w1), uniform(w2, w3)
    return u, turn


def cosine_law_about(normal, u, turn):
    """Directions (n, 3) and their cosines."""
    *w, mu = over_cosine_law(*normal, u, turn)
    return np.stack(w, axis=1), mu


def isotropic(u, turn):
    return np.stack(over_sphere(u, turn), axis=1)


def turned_about(normals, mu, turn):
    sine = np.sqrt(np.maximum(1.0 - mu * mu, 0.0))
    return np.stack(turned_from(*np.transpose(normals), mu, sine, turn), axis=1)


over_cosine_law, over_sphere, turned_from = (
    np.vectorize(function, otypes=[float] * count)
    for function, count in ((sample_cosine_law, 4), (sample_isotropic, 3), (turned_by_angle, 3))
)
Z = (0.0, 0.0, 1.0)


def unit(vector):
    vector = np.array(vector, float)
    return vector / math.sqrt(vector @ vector)


def excess_length(directions):
    """How far the lengths of unit vectors are from 1, exactly."""
    return max(
        abs(float(mp.fsum(mp.mpf(float(x)) ** 2 for x in d) - 1)) / 2 for d in np.reshape(directions, (-1, 3))
    )


def polar_counts(directions, normal):
    """Counts over cosine (-1 to 1) and azimuth about a normal, in a frame by cross products."""
    helper = np.eye(3)[np.argmin(np.abs(normal))]
    e1 = unit(np.cross(helper, normal))
    e2 = np.cross(normal, e1)
    mu, phi = directions @ normal, np.arctan2(directions @ e2, directions @ e1)
    return np.histogram2d(mu, phi, (2 * POLAR, ROUND), [[-1 - ULP, 1 + 2 * ULP], [-np.pi, np.pi]])[0]


def over_azimuth(polar):
    """Bin probabilities of a law that depends on the cosine only."""
    return np.repeat(np.asarray(polar)[:, None] / ROUND, ROUND, axis=1)


EDGES = np.linspace(-1, 1, 2 * POLAR + 1)
COSINE_LAW = over_azimuth(np.diff(np.maximum(EDGES, 0) ** 2))
UNIFORM_HEMISPHERE = over_azimuth(np.diff(np.maximum(EDGES, 0)))
UNIFORM_SPHERE = over_azimuth(np.diff(EDGES) / 2)


@pytest.mark.parametrize("name", NORMALS)
def test_diffuse_directions_follow_the_cosine_law_about_any_normal(name):
    n = unit(NORMALS[name])
    directions, mu = cosine_law_about(n, *uniforms(DRAWS, seed=1))
    assert (mu > 0).all()
    assert np.abs(directions @ n - mu).max() <= UNIT_LENGTH
    counts = polar_counts(directions, n)
    assert_follows(counts, COSINE_LAW, FALSE_ALARM)
    with pytest.raises(AssertionError):
        assert_follows(counts, UNIFORM_HEMISPHERE, FALSE_ALARM)


@pytest.mark.parametrize("axis", [Z, (1, 0, 0), (0.3, -0.5, 0.7)])
def test_isotropic_directions_are_uniform_over_the_sphere(axis):
    assert_follows(polar_counts(isotropic(*uniforms(DRAWS, seed=3)), unit(axis)), UNIFORM_SPHERE, FALSE_ALARM)


def test_extreme_draws_give_unit_vectors_that_are_not_grazing():
    draws = np.meshgrid([0, 2.0**-52, 0.5, 1 - 2.0**-52], [0, 0.25, 0.5, 0.75, 1 - 2.0**-52])
    u, turn = (each.ravel() for each in draws)
    for normal in NORMALS.values():
        directions, mu = cosine_law_about(unit(normal), u, turn)
        assert excess_length(directions) <= UNIT_LENGTH
        assert (mu.min(), mu.max()) == (2.0**-26, 1)
    assert excess_length(isotropic(u, turn)) <= UNIT_LENGTH


def test_sampled_and_turned_directions_are_unit_vectors():
    """To a few ulp, whatever the normal: nothing has to be normalised again."""
    u, turn = uniforms(500, seed=4)
    assert excess_length(isotropic(u, turn)) <= UNIT_LENGTH
    normals = np.array([unit(n) for n in (*NORMALS.values(), *isotropic(*uniforms(50, seed=5)))])
    n = np.resize(normals, (500, 3))
    for mu in (2 * u - 1, 1 - 10 ** (-16 * u)):
        assert excess_length(turned_about(n, mu, turn)) <= UNIT_LENGTH


def test_the_frame_about_a_normal_is_orthonormal():
    """Also beside the pole -z, where frames by division go bad."""
    tilts = [(s * 10.0**-k, -s * 3 * 10.0**-k, z) for k in range(0, 30, 2) for s in (1, -1) for z in (1, -1)]
    for normal in (*NORMALS.values(), *tilts):
        n = unit(normal)
        frame = np.array([turned_by(*n, c, a, b) for a, b, c in np.eye(3)])
        assert np.abs(frame @ frame.T - np.eye(3)).max() <= 8 * ULP
        assert (frame[2] == n).all()


def test_long_mirror_chains_stay_unit_vectors():
    """After 10 000 reflections the length is still right to a few ulp."""
    directions = isotropic(*uniforms(50, seed=6))
    directions /= np.sqrt((directions**2).sum(axis=1, keepdims=True))
    normals = np.array([unit(n) for n in NORMALS.values()])
    assert excess_length(bounced(directions.copy(), normals, 10_000)) <= UNIT_LENGTH
    once = bounced(directions.copy(), normals[-1:], 1)
    assert np.abs(once @ normals[-1] + directions @ normals[-1]).max() <= UNIT_LENGTH
    twice = bounced(once, normals[-1:], 1)
    assert np.abs(twice - directions).max() <= 4 * UNIT_LENGTH


# ---- next-event rays and flights share a crossing ----

DISTANCES = np.geomspace(1e-12, 1e12, 49)
PEAKS = [1 / math.pi, 0.25 / math.pi, 1e4]


@pytest.mark.parametrize("peak", PEAKS)
def test_rays_and_flights_share_every_crossing_of_a_detector(peak):
    """At every distance, and no ray brings more than the weight of its event."""
    radius, cosine = 0.3, 0.7
    area = math.pi * radius**2
    for r2 in DISTANCES**2:
        whole, ray = (connections.flat_connection(r2, area, cosine, p) for p in (0.0, peak))
        ball, ball_ray = (connections.ball_connection(r2, radius, area, p) for p in (0.0, peak))
        flight = connections.flights_share(r2, area, peak)
        assert whole == pytest.approx(
            area * cosine / r2, rel=1e-14, abs=0
        )  # one over the density of the direction
        assert ray + flight * whole == pytest.approx(whole, rel=1e-12, abs=0)
        assert ball_ray + flight * ball == pytest.approx(ball, rel=1e-12, abs=0)
        assert peak * ray <= cosine * (1 + 1e-14) and peak * ball_ray <= 4 * (1 + 1e-14)


def test_a_ball_without_flights_has_its_solid_angle_and_events_on_a_detector_are_left_to_flights():
    area = math.pi * 0.3**2
    assert connections.ball_connection(1e8, 0.3, area, 0.0) == pytest.approx(area / 1e8, rel=1e-8, abs=0)
    assert connections.ball_connection(0.04, 0.3, area, 0.0) == pytest.approx(4 * math.pi, rel=1e-14, abs=0)
    assert connections.flat_connection(0.0, 1.0, 0.0, 0.3) == 0.0
    assert connections.flights_share(0.0, 1.0, 0.3) == 1.0
    assert connections.ball_connection(0.0, 1.0, math.pi, 0.3) == 0.0
    assert connections.ball_connection(0.0, 1.0, math.pi, 0.0) == pytest.approx(4 * math.pi)
