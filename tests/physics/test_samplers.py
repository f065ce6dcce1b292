"""Each material's sampler against its density, by one chi-square; reciprocity and energy of each; and the judge itself.

What is tested are the engine's passes with the engine's random numbers, in a frame that is tilted to all
axes.  Each judgement fails right code in one of 10^6 seeds; faults are planted as densities that are not those
of the sampler.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_follows
from tests.sampling import (
    assert_reciprocal,
    assert_samples,
    cell_probabilities,
    cells_about,
    cosine_law,
    even_cells,
    glossy,
    lambert,
    met_by,
    rejects,
)
from transport.compile.gloss import single_peak
from transport.physics import interfaces, sight
from transport.physics import microfacets as engine_microfacets
from transport.theory import fresnel, microfacets, phases

DRAWS = 100_000
GLASS = tp.Dielectric(1.5)


def beam(mu, count=DRAWS, side=-1.0, turn=math.pi):
    """Directions of flight at a cosine of incidence, towards the front (-1) or the back, at azimuth `turn`."""
    sine = math.sqrt((1 - mu) * (1 + mu))
    return np.tile([sine * math.cos(turn), sine * math.sin(turn), side * mu], (count, 1))


def nothing(mu, phi):
    return 0.0 * mu


# ---- the judge ----


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


# ---- the physics that samplers are made of ----


@pytest.mark.parametrize("indices", [(1.5, 1.0), (1.0, 1.5), (1 + 1e-12, 1.0), (1.0, 1 + 1e-12), (2.4, 1.3)])
def test_fresnel_in_the_engine_is_that_of_theory(indices):
    """To rounding; near the critical angle as well as a rounded index knows it, and 1 beyond."""
    inside, outside = indices
    ratio, excess = inside / outside, (inside - outside) * (inside + outside) / outside**2
    cosines = np.r_[np.geomspace(1e-12, 1, 300), np.linspace(0.01, 1, 200)]
    with np.errstate(invalid="ignore"):  # beyond the critical angle
        share, snell = np.vectorize(interfaces.fresnel, otypes=[float, float])(cosines, ratio, excess)
    q2 = (ratio - 1) * (ratio + 1) + cosines**2
    known = 1e-15 * (1 + cosines**2 / np.abs(np.where(q2 == 0, 1, q2))) + 2e-4 * (abs(ratio - 1) < 1e-9)
    exact = fresnel.reflectance(cosines, ratio)
    assert (np.abs(share - exact) <= known * 8).all()
    beyond = cosines < np.cos(fresnel.critical_angle(ratio)) * (1 - 1e-3)
    assert (share[beyond] == 1).all() if ratio < 1 else (share < 1).all()
    passing = exact < 1
    assert snell[passing] == pytest.approx(ratio * fresnel.snell_cosine(cosines[passing], ratio), rel=1e-3)


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


@pytest.mark.parametrize("roughness", [1.0, 0.1, 1e-3])
def test_microfacets_in_the_engine_are_those_of_theory(roughness):
    mu, other = np.random.default_rng(9).random((2, 500))
    unshadowed = np.vectorize(engine_microfacets.unshadowed_share, otypes=[float])
    share = microfacets.joint_shadowing(mu, other, roughness) / microfacets.shadowing(mu, roughness)
    assert unshadowed(mu, other, roughness) == pytest.approx(share, rel=1e-12)
    assert (unshadowed(mu, -other, roughness) == 0).all()
    shadowed = np.vectorize(engine_microfacets.shadowed_share, otypes=[float])
    # Where nearly nothing is shadowed, it has more digits than 1 - share.
    assert shadowed(mu, other, roughness) == pytest.approx(1 - share, rel=1e-12, abs=1e-15)
    assert (shadowed(mu, -other, roughness) == 1).all()


@pytest.mark.parametrize("roughness", [1.0, 0.2, 1e-3])
def test_pdf_of_a_single_reflection_is_that_of_theory_and_below_its_bound(roughness):
    """In any frame, and at grazing angles; 0 below the horizon; nowhere nan."""
    rng = np.random.default_rng(3)
    density = np.vectorize(engine_microfacets.single_reflection_density, otypes=[float])
    normal = np.array([0.48, -0.64, 0.6])
    u, v = np.array([0.8, 0.6, 0.0]), np.array([-0.36, 0.48, 0.8])
    mu_in, mu_out = np.sin(rng.uniform(1e-3, math.pi / 2, (2, 500)))
    # Half of the directions lie near that of a mirror, as far as the roughness.
    near = np.arcsin(mu_in) + roughness * rng.normal(size=500)
    is_near = (rng.random(500) < 0.5) & (near > 1e-3) & (near < math.pi / 2)
    mu_out = np.where(is_near, np.sin(near), mu_out)
    phi = np.where(is_near, math.pi + roughness * rng.normal(size=500), rng.uniform(0, 2 * math.pi, 500))

    def direction(mu, turn):
        sine = np.sqrt((1 - mu) * (1 + mu))
        return (sine * np.cos(turn) * u[:, None] + sine * np.sin(turn) * v[:, None]) + mu * normal[:, None]

    to_light, out = direction(mu_in, 0 * phi), direction(mu_out, phi)
    found = density(*-to_light, *out, *normal, roughness)
    exact = microfacets.single_reflection(mu_in, mu_out, phi, roughness) * mu_out
    assert found == pytest.approx(exact, rel=1e-12 / roughness)
    assert (found <= single_peak(roughness, mu_out)).all()
    assert found.max() > 0.3 * single_peak(roughness, mu_out[found.argmax()])
    assert (density(*-to_light, *-out, *normal, roughness) == 0).all()
    assert density(*u, *u, *normal, roughness) == 0  # straight on, along the surface
    assert math.isfinite(density(*-normal, *normal, *normal, roughness))


@pytest.mark.parametrize("roughness", [1.0, 0.2, 1e-2])
def test_shadowed_share_of_one_microfacet_estimates_the_lost_albedo(roughness):
    sample = np.vectorize(engine_microfacets.sample_shadowed_share, otypes=[float])
    for mu in (1e-3, 0.1, 0.5, 1.0):
        drawn = sample(mu, roughness, *np.random.default_rng(8).random((2, 20_000)))
        error = drawn.std() / math.sqrt(len(drawn))
        assert abs(drawn.mean() - microfacets.lost_albedo(mu, roughness)) < 4.5 * error


# ---- each material ----


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_diffuse_light_leaves_either_side_by_the_cosine_law(side):
    out, weights = met_by(tp.Diffuse(0.5, 0.3), beam(0.4, side=side))
    back, through = 0.5 / 0.8, 0.3 / 0.8
    shares = (back, through) if side < 0 else (through, back)
    assert (weights == 0.8).all()
    assert_samples(out, lambert(*shares), even_cells())
    assert rejects(out, lambert(*shares[::-1]), even_cells())
    assert rejects(out, lambert(shares[0] + 0.02, shares[1] - 0.02), even_cells())
    assert_samples(met_by(tp.Diffuse(0.0, 0.3), beam(1.0))[0], lambert(0, 1), even_cells())


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_partial_mirror_has_two_beams(side):
    into = beam(0.3, side=side, turn=1.0)
    out, weights = met_by(tp.Mirror(0.6, 0.3), into)
    beams = [(into[0] * [1, 1, -1], 2 / 3), (into[0], 1 / 3)]
    np.testing.assert_allclose(weights, 0.9, rtol=1e-15)
    assert_samples(out, nothing, even_cells(), beams)
    assert rejects(out, nothing, even_cells(), [(beams[0][0], 0.68), (beams[1][0], 0.32)])


@pytest.mark.parametrize("mu", [0.02, 0.5, 1.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("glass", [GLASS, tp.Dielectric(1.0, 2.4), tp.Dielectric(1.3, 1.3)])
def test_glass_reflects_by_fresnel_and_refracts_by_snell(glass, side, mu):
    """From outside (-1) and inside, below and beyond the critical angle."""
    ratio = (glass.index_inside / glass.index_outside) ** -side
    into = beam(mu, side=side, turn=2.0)
    out, weights = met_by(glass, into)
    share = fresnel.reflectance(mu, ratio)
    beams = [(into[0] * [1, 1, -1], share)]
    if share < 1:
        cosine = fresnel.snell_cosine(mu, ratio)
        refracted = np.array([*into[0, :2] / ratio, side * cosine])
        beams.append((refracted, 1 - share))
        assert rejects(
            out,
            nothing,
            even_cells(),
            [(beams[0][0], 1 - 0.5 * (1 - share) + 1e-3), (refracted, 0.5 * (1 - share) - 1e-3)],
        )
    assert (weights == 1).all()
    assert_samples(out, nothing, even_cells(), beams)


OFTEN = {(0.5, 0.05), (0.5, 0.95), (1e-2, 0.05), (1e-2, 1.0)}  # roughness and cosine in the default run
GLOSSY = [
    pytest.param(roughness, mu, 1.0, marks=() if (roughness, mu) in OFTEN else pytest.mark.slow)
    for roughness, mu in sorted(
        OFTEN | {(1.0, 0.5), (1.0, 1.0), (0.5, 0.5), (0.1, 0.05), (0.1, 0.95), (1e-3, 0.05), (1e-3, 1.0)}
    )
]


@pytest.mark.parametrize(("roughness", "mu", "side"), [*GLOSSY, (0.2, 0.6, -1.0)])
def test_a_glossy_surface_reflects_by_its_brdf_from_either_side(roughness, mu, side):
    out, weights = met_by(tp.Glossy(roughness, 0.7), beam(mu, side=-side))
    assert (weights == 0.7).all() and (side * out[:, 2] > 0).all()
    assert_samples(out, glossy(mu, roughness, side), cells_about(side * mu, math.pi, roughness))


@pytest.mark.slow
def test_wrong_laws_of_rough_surfaces_are_rejected():
    """Planted: a roughness off by 3 %, no second lobe but Lambert's, heights that are not correlated."""
    mu, cells = 0.5, cells_about(0.5, math.pi, 0.5)
    out, _ = met_by(tp.Glossy(0.5), beam(mu, 4 * DRAWS))
    assert_samples(out, glossy(mu, 0.5), cells)
    assert rejects(out, glossy(mu, 0.515), cells)
    lost = microfacets.lost_albedo(mu, 0.5)

    def single(m, p):
        return np.where(m > 0, microfacets.single_reflection(mu, np.abs(m), p, 0.5) * np.abs(m), 0.0)

    assert rejects(out, lambda m, p: single(m, p) + lost * lambert()(m, p), cells)

    def apart(m, p):
        both = microfacets.shadowing(mu, 0.5) * microfacets.shadowing(np.abs(m), 0.5)
        return single(m, p) * both / microfacets.joint_shadowing(mu, np.abs(m), 0.5)

    rest = 1 - cell_probabilities(apart, cells).sum()
    assert rejects(out, lambda m, p: apart(m, p) + rest * lambert()(m, p), cells)


LENS_PLACE = np.array([0.3, -0.2])


@pytest.mark.parametrize("focal_length", [0.8, -0.8, 0.25, 0.1])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_lens_shifts_direction_cosines_and_loses_nothing(focal_length, side):
    into = cosine_law(DRAWS, 6, side)
    out, weights = met_by(tp.ThinLens(focal_length), into, place=LENS_PLACE)
    shifted = into[:, :2] - LENS_PLACE / focal_length
    passes = (shifted**2).sum(axis=1) < 1
    assert (weights == 1).all() and (np.sign(out[:, 2]) == np.where(passes, side, -side)).all()
    np.testing.assert_allclose(out[passes, :2], shifted[passes], atol=1e-14)
    np.testing.assert_allclose(out[~passes], -into[~passes], atol=1e-15)


def test_diffuse_light_on_both_sides_of_a_lens_stays_diffuse_light():
    """Equilibrium; and a lens that maps tangents brings some of it out of balance."""
    into = np.concatenate([cosine_law(DRAWS, 7, side) for side in (-1.0, 1.0)])
    out, _ = met_by(tp.ThinLens(0.8), into, place=LENS_PLACE)
    assert_samples(out, lambert(0.5, 0.5), even_cells())
    assert_reciprocal(into, out, even_cells(4, 4))
    slopes = into[:, :2] / np.abs(into[:, 2:]) - LENS_PLACE / 0.8
    tangents = np.concatenate([slopes, np.sign(into[:, 2:])], axis=1)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    assert rejects(tangents, lambert(0.5, 0.5), even_cells())


def test_a_mixture_is_the_sum_of_its_parts():
    """Glass, a partial mirror, paint and gloss at once: no part knows of another's random numbers."""
    parts = {GLASS: 0.3, tp.Mirror(0.9): 0.2, tp.Diffuse(0.9): 0.2, tp.Glossy(0.3, 0.9): 0.2, tp.Black(): 0.1}
    into, mu = beam(0.5), 0.5
    out, weights = met_by(tp.Mixture(parts), into)
    share = fresnel.reflectance(mu, 1.5)
    assert_follows([np.count_nonzero(weights == 0), np.count_nonzero(weights)], [0.1, 0.9], 1e-6)
    assert set(weights) == {0.0, 0.9, 1.0}
    refracted = np.array([*into[0, :2] / 1.5, -float(fresnel.snell_cosine(mu, 1.5))])
    beams = [(into[0] * [1, 1, -1], (0.3 * share + 0.2) / 0.9), (refracted, 0.3 * (1 - share) / 0.9)]

    def spread(m, p):
        return (0.2 * lambert()(m, p) + 0.2 * glossy(mu, 0.3)(m, p)) / 0.9

    def wrong(m, p):
        return (0.23 * lambert()(m, p) + 0.17 * glossy(mu, 0.3)(m, p)) / 0.9

    cells = cells_about(mu, math.pi, 0.3)
    assert_samples(out[weights > 0], spread, cells, beams)
    assert rejects(out[weights > 0], wrong, cells, beams)


def test_all_that_may_pass_a_mixture_passes_by_its_share():
    milk = tp.Mixture({tp.Diffuse(0.2, 0.6): 0.5, tp.Mirror(0.3, 0.5): 0.3, tp.Transparent(): 0.2})
    into = beam(0.5)
    out, weights = met_by(milk, into)
    assert set(weights) == {0.8, 1.0}
    beams = [(into[0] * [1, 1, -1], 0.3 * 3 / 8), (into[0], 0.3 * 5 / 8 + 0.2)]
    assert_samples(out, lambert(0.125, 0.375), even_cells(), beams)
    assert rejects(out, lambert(0.25, 0.25), even_cells(), beams)


@pytest.mark.slow
def test_each_side_has_its_own_material():
    """Gloss in front, half mirrored milk behind: by the side of arrival."""
    half = tp.Mixture({tp.Mirror(): 0.5, tp.Diffuse(0.6, 0.2): 0.5})
    coat = tp.TwoSided(front=tp.Glossy(0.4), back=half)
    out, weights = met_by(coat, beam(0.6))
    assert (weights == 1).all()
    assert_samples(out, glossy(0.6, 0.4), cells_about(0.6, math.pi, 0.4))
    into = beam(0.6, side=1.0)
    out, weights = met_by(coat, into)
    assert set(weights) == {0.8, 1.0}
    beams = [(into[0] * [1, 1, -1], 0.5)]
    assert_samples(out, lambert(front=0.125, back=0.375), even_cells(), beams)
    assert rejects(out, lambert(front=0.375, back=0.125), even_cells(), beams)


# ---- reciprocity and energy ----

LOSSLESS = {
    "diffuse": (tp.Diffuse(1.0), 1.0),
    "milk": (tp.Diffuse(0.6, 0.4), 1.0),
    "half mirror": (tp.Mirror(0.5, 0.5), 1.0),
    "glass": (GLASS, 1.5),
    "bubble": (tp.Dielectric(1.0, 1.33), 1 / 1.33),
    "gloss": (tp.Glossy(0.1), 1.0),
    "rough": (tp.Glossy(1.0), 1.0),
    "lens": (tp.ThinLens(0.8), 1.0),
    "mixture": (tp.Mixture({GLASS: 0.4, tp.Glossy(0.5): 0.3, tp.Diffuse(1.0): 0.2, tp.Mirror(): 0.1}), 1.5),
    "two sides": (tp.TwoSided(tp.Glossy(0.3), tp.Diffuse(1.0)), 1.0),
}


def in_equilibrium(ratio, seed):
    """Light from both sides, from the back as much more as the square of the index there over that in front."""
    front = round(2 * DRAWS / (1 + ratio**2))
    return np.concatenate([cosine_law(front, seed, -1.0), cosine_law(2 * DRAWS - front, seed + 1, 1.0)])


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=() if n in ("milk", "glass", "rough", "mixture") else pytest.mark.slow)
        for n in LOSSLESS
    ],
)
def test_light_in_equilibrium_stays_so(name):
    """All goes on; diffuse light of radiance n^2 leaves as such; as much from cell to cell as back."""
    material, ratio = LOSSLESS[name]
    into = in_equilibrium(ratio, 8)
    out, weights = met_by(material, into, place=LENS_PLACE)
    assert (weights == 1).all()
    behind = ratio**2 / (1 + ratio**2)
    assert_samples(out, lambert(1 - behind, behind), even_cells())
    assert_reciprocal(into, out, even_cells(4, 5))


def test_a_lost_square_of_the_index_is_seen():
    """Planted: as much light from inside as from outside is no equilibrium, nor is it balanced."""
    into = in_equilibrium(1.0, 8)
    out, _ = met_by(GLASS, into)
    assert rejects(out, lambert(0.5, 0.5), even_cells())
    assert rejects(into, out, even_cells(4, 5), judge=assert_reciprocal)
