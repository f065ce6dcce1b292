"""Microfacets: densities add up, shadowing is reciprocal, and with its second lobe the albedo is 1 at every angle."""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

from transport.statistics import microfacet_lobe
from transport.statistics.microfacet_lobe import lost_share, turned_normals
from transport.theory import microfacets

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
ROUGHNESSES = [1.0, 0.5, 0.1, 1e-2, 1e-3]
COSINES = [1e-6, 1e-3, 0.1, 0.5, 0.9, 1.0]


def panels(edges):
    """Gauss nodes and weights over panels."""
    edges = np.unique(edges)
    width = np.diff(edges)[:, None]
    return (edges[:-1, None] + width * (NODES + 1) / 2).ravel(), (width * WEIGHTS / 2).ravel()


def hemisphere(mu):
    """Cosines, azimuths and weights of solid angle, crowded about the mirror image of mu and about the horizon."""
    near = np.geomspace(1e-12, 2, 50)
    middle = math.asin(mu)
    elevation, weight = panels(
        np.clip([0, *near, *(middle + near), *(middle - near), middle], 0, math.pi / 2)
    )
    azimuth, weight_azimuth = panels(np.clip([0, *near, math.pi], 0, math.pi))
    out = np.sin(elevation)[:, None]
    return out, math.pi - azimuth, 2 * (weight * np.cos(elevation))[:, None] * weight_azimuth


def albedo(f, mu):
    out, azimuth, weight = hemisphere(mu)
    return (f(mu, out, azimuth) * out * weight).sum()


@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_facets_cover_their_surface_once(roughness):
    """int D mu dm = 1; what is seen of them from a direction covers just what the surface does: Smith's G1."""
    angle, weight = panels(np.concatenate([[0], np.geomspace(1e-8, math.pi / 2, 60)]))
    mu, sine, known = np.cos(angle), np.sin(angle), 2**-53 / roughness**2  # as well as mu knows the slope
    around = 2 * math.pi * sine * weight
    assert (microfacets.normal_density(mu, roughness) * mu) @ around == pytest.approx(1, rel=1e-12 + known)
    azimuth = 2 * math.pi * (np.arange(2000) + 0.5) / 2000
    for seen_from in (0.1, 0.7, 1.0):
        cosine = seen_from * mu[:, None] + math.sqrt(1 - seen_from**2) * sine[:, None] * np.cos(azimuth)
        visible = microfacets.visible_density(seen_from, mu[:, None], cosine, roughness).mean(axis=1)
        assert visible @ around == pytest.approx(1, abs=1e-6)  # between azimuths the horizon is a kink
        shown = microfacets.shadowing(seen_from, roughness) / seen_from
        seen = (
            shown * np.maximum(cosine, 0).mean(axis=1) * microfacets.normal_density(mu, roughness)
        ) @ around
        assert seen == pytest.approx(1, abs=1e-6)


def density_between(elevation_in, elevation_out, psi, roughness):
    """D of the facet between two directions, by its slope; psi: azimuth away from the mirror image [rad]."""
    half_sum, half_way = (elevation_in + elevation_out) / 2, (elevation_out - elevation_in) / 2
    across = np.cos(elevation_out)
    x = 2 * np.sin(half_sum) * np.sin(half_way) + 2 * across * np.sin(psi / 2) ** 2
    slope2 = (x**2 + (across * np.sin(psi)) ** 2) / (np.sin(elevation_in) + np.sin(elevation_out)) ** 2
    return roughness**2 * (1 + slope2) ** 2 / (math.pi * (roughness**2 + slope2) ** 2)


@pytest.mark.parametrize("roughness", [1.0, 0.3, 1e-3])
def test_azimuths_are_added_up_in_closed_form(roughness):
    psi, weight = panels(np.concatenate([[0], np.geomspace(1e-9, math.pi, 80)]))
    for pair in ((0.3, 0.31), (0.5, 1.2), (1.0, -0.7), (1.5, 1.55), (1e-3, 2e-3)):
        summed = 2 * density_between(*pair, psi, roughness) @ weight
        assert turned_normals(*pair, roughness) == pytest.approx(summed, rel=1e-11)


def test_single_reflection_is_that_of_its_factors():
    """D G2 / (4 mu_i mu_o), the facet's slope and Lambda in the forms of Walter et al. (2007) and Heitz (2014)."""
    mu_in, mu_out, phi = np.array([0.2, 0.6, 0.9]), np.array([0.3, 0.99, 0.05]), np.array([3.0, 0.5, 2.0])
    for roughness in (1.0, 0.3, 0.01):
        density = density_between(np.arcsin(mu_in), np.arcsin(mu_out), math.pi - phi, roughness)
        slopes = [(1 - mu**2) / mu**2 for mu in (mu_in, mu_out)]
        one, other = ((np.sqrt(1 + roughness**2 * slope) - 1) / 2 for slope in slopes)
        exact = density / (1 + one + other) / (4 * mu_in * mu_out)
        assert microfacets.single_reflection(mu_in, mu_out, phi, roughness) == pytest.approx(exact, rel=1e-12)
        joint = microfacets.joint_shadowing(mu_in, mu_out, roughness)
        assert joint == pytest.approx(1 / (1 + one + other), rel=1e-12)
        # uncorrelated heights, G1 G1, would be another surface
        apart = microfacets.shadowing(mu_in, roughness) * microfacets.shadowing(mu_out, roughness)
        assert (apart < joint).all()


# ---- what is lost ----


def test_the_roughest_surface_has_a_closed_form():
    """alpha = 1: all normals alike and h = 1, so that E = 1 - mu log(1 + 1/mu) and E_mean = 4/3 (1 - log 2)."""
    mu = np.array([1e-9, 1e-3, 0.1, 0.5, 1.0])
    assert microfacets.lost_albedo(mu, 1.0) == pytest.approx(mu * np.log1p(1 / mu), rel=1e-13, abs=0)
    assert microfacets.single_albedo(1.0, 1.0) == pytest.approx(1 - math.log(2), rel=1e-14)
    assert microfacets.mean_albedo(1.0) == pytest.approx(4 / 3 * (1 - math.log(2)), rel=1e-14)
    # 3 times the integral of mu^2 log(1 + 1/mu)
    below = mu**3 * np.log1p(1 / mu) + mu**2 / 2 - mu + np.log1p(mu)
    reached = microfacet_lobe.lobe_quantile(below[1:] * 2 / 3 / (1 - microfacets.mean_albedo(1.0)), 1.0)
    assert reached == pytest.approx(mu[1:], rel=1e-7)  # the closed form cancels for small mu


def _single_albedo(alpha, mu):
    def integrand(out, phi):
        cosine = mu * out + mp.sqrt((1 - mu**2) * (1 - out**2)) * mp.cos(phi)
        density = alpha**2 / (mp.pi * ((alpha**2 - 1) * (mu + out) ** 2 / (2 * (1 + cosine)) + 1) ** 2)
        one, other = ((mp.sqrt(1 + alpha**2 * (1 - m * m) / (m * m)) - 1) / 2 for m in (mu, out))
        return density / (1 + one + other) / (4 * mu)

    return 2 * mp.quad(lambda out: mp.quad(lambda phi: integrand(out, phi), [0, mp.pi]), [0, mu, 1])


@pytest.mark.slow
def test_single_albedo_agrees_with_textbook_forms_in_mpmath():
    with mp.workdps(15):
        exact = _single_albedo(mp.mpf(0.5), mp.mpf(0.3))
    assert microfacets.single_albedo(0.3, 0.5) == pytest.approx(float(exact), rel=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_single_and_lost_albedo_add_up_to_one(roughness):
    """Two integrals over different directions: D G2 over the upper ones, D G1 (1 - G2/G1) over those below too."""
    for mu in COSINES:
        single = albedo(lambda *angles: microfacets.single_reflection(*angles, roughness), mu)
        assert single + microfacets.lost_albedo(mu, roughness) == pytest.approx(1, abs=1e-10)


@pytest.mark.parametrize("roughness", [1.0, 0.1, 1e-3, 1e-8])
def test_the_table_of_lost_albedo_follows_its_integral(roughness):
    elevation = np.concatenate(
        [np.geomspace(1e-12, math.pi / 2, 200), math.pi / 2 - np.geomspace(1e-6, 0.5, 60)]
    )
    table = microfacets.lost_albedo(np.sin(elevation), roughness)
    direct = lost_share(np.arcsin(np.sin(elevation)), roughness)
    assert table == pytest.approx(direct, rel=1e-13 if roughness > 1e-4 else 1e-9, abs=0)
    assert (table > 0).all() and (table < 1).all()


# ---- the whole ----


@pytest.mark.slow
@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_albedo_is_the_same_at_every_angle(roughness):
    for mu in COSINES:
        whole = albedo(lambda *angles: microfacets.brdf(*angles, roughness, 0.7), mu)
        assert whole == pytest.approx(0.7, abs=1e-10), mu


def test_without_the_second_lobe_light_would_be_lost():
    """Planted: single reflection alone, and a lobe of Lambert's form with the right mean."""
    single = albedo(lambda *angles: microfacets.single_reflection(*angles, 0.5), 0.9)
    assert single < 0.7
    mean_lost = 1 - microfacets.mean_albedo(0.5)

    def lambert(mu, out, phi):
        return microfacets.single_reflection(mu, out, phi, 0.5) + mean_lost / math.pi

    assert abs(albedo(lambert, 0.9) - 1) > 0.01 and albedo(lambert, 0.05) > 1.01  # above 1


@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_brdf_is_reciprocal_to_the_last_bit(roughness):
    one, other, phi = np.random.default_rng(5).random((3, 2000))
    there = microfacets.brdf(one, other, math.pi * phi, roughness, 0.8)
    assert (there == microfacets.brdf(other, one, math.pi * phi, roughness, 0.8)).all()
    assert np.isfinite(there).all() and (there > 0).all()


@pytest.mark.parametrize("roughness", [1.0, 0.3, 1e-3])
def test_lobe_quantile_inverts_the_lobe(roughness):
    """The integral of the density up to the quantile, each tail from its own end."""
    u = np.array([1e-9, 1e-4, 0.1, 0.5, 0.9, 1 - 1e-4, 1 - 1e-9])
    places = microfacet_lobe.lobe_quantile(u, roughness)
    assert (np.diff(places) > 0).all() and microfacet_lobe.lobe_quantile(
        np.array([0.0, 1.0]), roughness
    ).tolist() == [0, 1]
    for share, place in zip(u, places, strict=True):
        if share <= 0.5:
            mu, weight = panels(place * np.concatenate([[0], np.geomspace(1e-10, 1, 60)]))
            mass = microfacets.lobe_density(mu, roughness) @ weight
        else:
            angle, weight = panels(math.acos(place) * np.concatenate([[0], np.geomspace(1e-10, 1, 60)]))
            mass = (microfacets.lobe_density(np.cos(angle), roughness) * np.sin(angle)) @ weight
        assert mass == pytest.approx(min(share, 1 - share), rel=1e-6 if share > 0.99 else 1e-10, abs=0)


def test_the_first_scene_does_not_wait_for_the_lobe():
    """Smooth in both tails, so that a table of it has few cells."""
    from transport.compile.speeds import has_split_cells, quantile_table

    def quantile(u):
        return microfacet_lobe.lobe_quantile(u, 0.2)

    assert len(quantile_table(quantile)[1]) < 4000 and not has_split_cells(quantile)
