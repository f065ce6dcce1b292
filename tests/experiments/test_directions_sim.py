"""Directions follow sinθ dθ dφ and cosθ sinθ dθ dφ, in every bin; laws without the sine or the cosine are rejected.

Each statistical test fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_follows, assert_z_spread
from transport.sims import directions
from transport.statistics.estimates import EstimateArray
from transport.statistics.replicates import Batches
from transport.theory import solid_angles
from transport.verification.experiment import run_experiment

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
PARTICLES = 2_000_000


@pytest.fixture(scope="module")
def outcomes():
    run = run_experiment(directions, particles=PARTICLES, seed=1, threads=2)
    return {outcome.parameters["subject"]: outcome for outcome in run}


@pytest.fixture(scope="module")
def sky(outcomes):
    """Number of isotropic directions in each bin."""
    return np.round(PARTICLES * directions.sky_shares(outcomes["isotropic"].result).value)


@pytest.fixture(scope="module")
def leaving(outcomes):
    """Number of directions of the cosine law in each bin."""
    return np.round(PARTICLES * directions.leaving_shares(outcomes["cosine law"].result).value)


def uniform_in_angle(reach):
    """The law without its sine: all polar angles alike."""
    rings = round(reach / 90 * directions.POLAR)
    return np.full((rings, directions.AZIMUTHS), 1 / rings / directions.AZIMUTHS)


def isotropic_hemisphere():
    """The cosine law without its cosine."""
    return 2 * directions.isotropic_probabilities()[: directions.POLAR]


def assert_rejected(counts, law):
    with pytest.raises(AssertionError, match="chi-square"):
        assert_follows(counts, law, FALSE_ALARM)


def test_probabilities_are_solid_angles_over_all_of_them():
    theta, phi = np.linspace(0, math.pi, 2 * directions.POLAR + 1), np.linspace(0, 2 * math.pi, 41)
    plain = solid_angles.bin_solid_angles(np.cos(theta)[::-1], phi)[::-1]
    assert np.allclose(directions.isotropic_probabilities(), plain / (4 * math.pi), rtol=1e-12)
    above = np.cos(np.linspace(0, math.pi / 2, directions.POLAR + 1))[::-1]
    projected = solid_angles.bin_projected_solid_angles(above, phi)[::-1]
    assert np.allclose(directions.cosine_probabilities(), projected / math.pi, rtol=1e-12)


def test_isotropic_directions_follow_sine_theta(sky):
    assert sky.sum() == PARTICLES
    assert_follows(sky, directions.isotropic_probabilities(), FALSE_ALARM)
    assert_rejected(sky, uniform_in_angle(180))


def test_the_cosine_law_follows_cosine_theta_sine_theta(leaving):
    assert leaving.sum() == PARTICLES
    assert_follows(leaving, directions.cosine_probabilities(), FALSE_ALARM)
    assert_rejected(leaving, isotropic_hemisphere())
    assert_rejected(leaving, uniform_in_angle(90))


def test_a_lopsided_law_is_rejected(sky, leaving):
    """Two percent more in one half of the azimuths, and less in the other."""
    turned = 1 + 0.02 * np.sign(np.arange(directions.AZIMUTHS) - directions.AZIMUTHS / 2 + 0.5)
    assert_rejected(sky, directions.isotropic_probabilities() * turned)
    assert_rejected(leaving, directions.cosine_probabilities() * turned)


def test_radiance_is_what_the_cosine_is_divided_out_of(outcomes):
    """Planted: a cosine that is kept where the law of directions has it already."""
    leaving = outcomes["cosine law"].result["leaving"]
    level = 1 / (math.pi * leaving.area)
    unit = tp.Unit.parse("W m^-2 sr^-1")
    rings = leaving.radiance_out.mean("phi") / level
    assert rings.unit == unit
    assert_agrees(rings, 1.0, FALSE_ALARM)
    kept = leaving.intensity_out.mean("phi") / (level * leaving.area)
    with pytest.raises(AssertionError):
        assert_agrees(kept, 1.0, FALSE_ALARM)


def test_a_hemisphere_is_two_pi_and_its_projection_pi(outcomes):
    caps, projected, dome = (outcomes[subject] for subject in ("isotropic", "cosine law", "dome"))
    assert caps["∫dω, θ ≤ 90°"].exact == pytest.approx(2 * math.pi, rel=1e-15)
    assert caps["∫dω, θ ≤ 180°"].estimate.exact
    assert projected["∫cosθ dω, θ ≤ 90°"].estimate.exact
    assert projected["∫cosθ dω, θ ≤ 90°"].exact == pytest.approx(math.pi, rel=1e-15)
    with pytest.raises(AssertionError):  # a receiver that forgets its cosine would read 2 pi
        assert_agrees(dome["∫cosθ dω, onto a disk"].estimate, 2 * math.pi, FALSE_ALARM)


def test_the_faces_of_a_dodecahedron_share_the_sphere_and_are_no_steradian(outcomes):
    outcome = outcomes["dodecahedron"]
    shares = [share.value for share in directions.face_shares(outcome.result)]
    assert sum(shares) == pytest.approx(1, abs=1e-12)
    assert_follows(np.round(PARTICLES * np.array(shares)), np.full(12, 1 / 12), FALSE_ALARM)
    with pytest.raises(AssertionError):
        assert_agrees(outcome[directions.FACE].estimate, 1.0, FALSE_ALARM)


# ---- arcs, areas, steradians, footprints ----


def test_an_arc_falls_with_the_distance_and_an_area_with_its_square(outcomes):
    """Planted: an area that falls with r, an arc that falls with r²."""
    outcome = outcomes["arc and area"]
    for radius in directions.RADII:
        arc, area = (outcome[name(radius)].estimate for name in (directions._arc, directions._cap_of_area))
        assert_agrees(arc, 1 / radius, FALSE_ALARM)
        assert_agrees(area, 1 / radius**2, FALSE_ALARM)
        if radius != 1:
            for estimate, wrong in ((arc, 1 / radius**2), (area, 1 / radius)):
                with pytest.raises(AssertionError):
                    assert_agrees(estimate, wrong, FALSE_ALARM)


def test_a_steradian_has_the_same_counts_whatever_its_shape(outcomes):
    """Planted: the unit square, and the star that the cone's circle holds."""
    outcome = outcomes["one steradian"]
    for row in outcome.rows:
        assert_agrees(row.estimate, 1.0, FALSE_ALARM)
    assert solid_angles.polygon_solid_angle(directions.steradians()["star"].vertices) == pytest.approx(
        1, abs=1e-12
    )
    in_the_circle = solid_angles.polygon_solid_angle(directions._star(directions.steradians()["cone"].radius))
    unit_square = solid_angles.rectangle_solid_angle(1.0, 1.0, 1.0)
    for name, wrong in (("square", unit_square), ("star", in_the_circle)):
        with pytest.raises(AssertionError):
            assert_agrees(outcome[name].estimate, wrong, FALSE_ALARM)


@pytest.mark.parametrize("angle", [0, 30, 60, 75])
def test_a_footprint_grows_with_one_over_the_cosine(angle):
    """Planted: a footprint that shrinks, and one that stays; the exact one tends to the ellipse."""
    tilt, alpha = math.radians(angle), directions.HALF_ANGLE
    run = run_experiment(directions, {"subject": "footprint", "tilt": tilt}, particles=400_000, seed=1)
    row = run[0][directions.GROWTH]
    assert_agrees(row.estimate, row.exact, FALSE_ALARM)
    assert row.exact == pytest.approx(1 / math.cos(tilt), rel=0.03)
    if angle:
        for wrong in (math.cos(tilt), 1.0):
            with pytest.raises(AssertionError):
                assert_agrees(row.estimate, wrong, FALSE_ALARM)
    mu, sine = math.cos(tilt), math.sin(alpha)
    ellipse = math.pi * mu**2 * sine**2 * math.cos(alpha) / (mu**2 - sine**2) ** 1.5
    assert directions.area_of(directions.footprint(tilt)) == pytest.approx(ellipse, rel=3e-3)


# ---- chi-square as an estimate ----


def drawn(law, seed, batch=2_000):
    """Shares that a run of 32 batches would find, drawn from a law."""
    counts = np.random.default_rng(seed).multinomial(batch, np.ravel(law), size=32).reshape(32, *law.shape)
    edges = {"u": np.arange(law.shape[0] + 1.0), "v": np.arange(law.shape[1] + 1.0)}
    return EstimateArray(counts / batch, Batches(np.full(32, batch)), "1", ("u", "v"), edges)


def test_chi_square_has_an_honest_error():
    """Of right laws the estimate is 1 within its error, with two directions a bin as well."""
    law = directions.isotropic_probabilities()
    z = [directions.chi_square(drawn(law, seed), law).z(1) for seed in range(300)]
    assert_z_spread(np.array(z), math.inf, FALSE_ALARM)


def test_chi_square_rejects_a_wrong_law(outcomes):
    shares = directions.leaving_shares(outcomes["cosine law"].result)
    assert_agrees(directions.chi_square(shares, directions.cosine_probabilities()), 1, FALSE_ALARM)
    with pytest.raises(AssertionError):
        assert_agrees(directions.chi_square(shares, isotropic_hemisphere()), 1, FALSE_ALARM)


# ---- the sim ----
