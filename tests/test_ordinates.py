"""Discrete ordinates by doubling: against references, against a solution that is exact in depth, and against
closed forms.

A comment such as `E.slab_HG` names the entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.polynomial import legendre

from transport.theory import fresnel, ordinates
from transport.theory.ordinates import ISOTROPIC, RAYLEIGH, henyey_greenstein, slab

FORWARD = henyey_greenstein(0.75)
EDGES = np.linspace(0, 1, 31)


def close(value, exact, relative=1e-9, absolute=0.0):
    return np.allclose(value, np.array(exact, dtype=float), rtol=relative, atol=absolute)


# ---- references ----


@pytest.mark.parametrize(
    ("depth", "albedo", "mu0", "back", "on"),
    [  # E.slab_isotropic
        (0.1, 0.5, 0.5, 0.04149825402865099, 0.8598280231690119),
        (0.1, 0.9, 0.01, 0.4911182797406901, 0.3928483950723313),
        (1.0, 0.9, 0.1, 0.5689876569698994, 0.22575327796123695),
        (1.0, 0.99, None, 0.4359615977698839, 0.5443523892030422),
        (2.0, 0.5, None, 0.14508538153757, 0.10705530773072386),
        (2.0, 1.0, 0.01, 0.8249881368706198, 0.17501186299363508),
        (5.0, 1.0, 1.0, 0.7387211678848982, 0.26127883233199456),
        (10.0, 0.5, 0.5, 0.16014443336035003, 1.597315395060293e-05),
        (10.0, 0.99, 0.1, 0.8725955710805922, 0.03535304571346936),
        (10.0, 1.0, 0.1, 0.936943787801949, 0.06305621270207702),
    ],
)
def test_isotropic_slabs_agree_with_references(depth, albedo, mu0, back, on):
    light = slab(depth, albedo, ISOTROPIC, mu0)
    assert close([light.reflected, light.transmitted], [back, on], 1e-8)


@pytest.mark.parametrize(
    ("g", "depth", "albedo", "mu0", "back", "on"),
    [  # E.slab_HG
        (0.75, 2.0, 0.9, None, 0.19109022660045846, 0.5018160583986766),
        (0.75, 1.0, 1.0, 0.1, 0.5814799285560952, 0.418520071442993),
        (0.75, 10.0, 0.99, 1.0, 0.47257087597472414, 0.3400124326966979),
        (0.9, 2.0, 0.9, 1.0, 0.03221529690693779, 0.7595763410251009),
        (0.9, 10.0, 0.99, 0.5, 0.4364014292590745, 0.3825327433261788),
        (-0.5, 2.0, 0.9, 0.1, 0.6528806886527894, 0.08113610764574092),
        (0.75, 2.0, 0.9, 1.0, 0.0973946386719247, 0.6609577001638116),  # E.vandehulst_hg
    ],
)
def test_henyey_greenstein_slabs_agree_with_references(g, depth, albedo, mu0, back, on):
    light = slab(depth, albedo, henyey_greenstein(g), mu0)
    assert close([light.reflected, light.transmitted], [back, on], 1e-9)


def test_radiance_agrees_with_references():
    mu = np.array([0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0])  # E.slab_isotropic_radiance
    light = slab(2.0, 0.9, ISOTROPIC, 0.1)
    back = [
        0.6128369692978717, 0.4891410295498392, 0.2881460268044603, 0.2126389862993059, 0.17091517677906365,
        0.14369467472120148, 0.13324565104949662,
    ]  # fmt: skip
    on = [
        0.017090798569973475, 0.018769688811355167, 0.025939452351440042, 0.03486634211989341, 0.0420813403781328,
        0.04638209127630759, 0.04762045410155816,
    ]  # fmt: skip
    assert close(light.reflected_radiance(mu), back, 3e-8)
    assert close(light.transmitted_radiance(mu), on, 3e-8)
    mu0 = (1.0, 0.9, 0.7, 0.3, 0.1)  # E.vandehulst_table12, of pi times the radiance at mu = 0.5
    back = [
        0.28616183950158336,
        0.30277007555728763,
        0.34188319617792345,
        0.453533583804399,
        0.5321439640781754,
    ]
    on = [
        0.14864384649787957,
        0.14731230281103289,
        0.1396289899961939,
        0.09424683697922924,
        0.06601238388289248,
    ]
    lights = [slab(2.0, 0.8, ISOTROPIC, each) for each in mu0]
    assert close([math.pi * light.reflected_radiance(0.5) for light in lights], back)
    assert close([math.pi * light.transmitted_radiance(0.5) for light in lights], on)


def test_x_and_y_functions_agree_with_references():
    """X = 1 + mu int R(mu, mu') dmu', and Y likewise from T and the direct part."""
    mu = np.array([0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0])  # E.XY_functions, tau=2, a=0.9
    x = [
        1.0982107446592775, 1.1689243261020743, 1.3783116412500709, 1.5274676040805177, 1.639219856864722,
        1.7249691099303956, 1.7605682086986252,
    ]  # fmt: skip
    y = [
        0.009603617187009531, 0.02108659939275842, 0.08683241429582847, 0.1941438655790506, 0.3311637687171746,
        0.4743392300779862, 0.5436970190082382,
    ]  # fmt: skip
    nodes, weights = ordinates.gauss(ordinates.graded_edges(1.0, 0.5))
    nodes, weights = np.append(nodes, mu), np.append(weights, 0 * mu)
    one = ordinates.layer(2.0, 0.9, *np.ones((2, len(nodes), len(nodes))), nodes, weights)
    found = 1 + mu * (one.reflection @ weights)[-7:], one.direct[-7:] + mu * (one.transmission @ weights)[-7:]
    assert close(found, [x, y], 1e-9)


def test_the_phase_function_s_mean_over_azimuth_agrees_with_references():
    found = [ordinates.azimuthal_phase(henyey_greenstein(g), np.array([0.3, 0.8])) for g in (0.75, 0.9, -0.5)]
    assert close(found[0][0][0, 1], 0.6517969828537737)  # E.HG_azimuth_average
    assert close(found[1][1][0, 1], 0.0707498098558913)
    assert close([phase[0, 1] for phase in found[2]], [0.4791207000816786, 1.0646598109698588])


# ---- a second method: plain Gauss nodes, exact in depth by the singular values of one matrix ----


def by_depth(depth, albedo, moments, mu, weight):
    """What goes back and on, as matrices from radiance to radiance.

    With s = d + u, y = d - u: mu y' = -A s, mu s' = -B y; s = cosh, sinh of k tau, whose k are singular
    values.
    """
    forward, backward = ordinates.azimuthal_phase(moments, mu)
    root = np.sqrt(weight)
    even, odd = (
        np.eye(len(mu)) - albedo / 2 * root[:, None] * (forward + sign * backward) * root for sign in (1, -1)
    )
    values, vectors = np.linalg.eigh(even)
    lower = np.linalg.cholesky(odd)
    half = (vectors * np.sqrt(np.maximum(values, 0))).T / mu
    k, turn = np.linalg.svd(half @ lower)[1:]
    basis = np.sqrt(mu)[:, None] * np.linalg.solve(lower.T, turn.T)
    z_even, z_odd = (
        (basis * spread) @ basis.T for spread in (k * np.tanh(k * depth / 2), k / np.tanh(k * depth / 2))
    )
    unit = np.eye(len(mu))
    sums, differences = (np.linalg.solve(unit + z, unit - z) for z in (z_even, z_odd))
    scale = root * np.sqrt(mu)
    return [each / scale[:, None] * scale for each in ((sums + differences) / 2, (sums - differences) / 2)]


def shares(depth, albedo, moments, nodes=60):
    """Of Lambertian light."""
    x, w = legendre.leggauss(nodes)
    mu, weight = (x + 1) / 2, w / 2
    back, on = by_depth(depth, albedo, moments, mu, weight)
    return 2 * weight * mu @ back @ np.ones(nodes), 2 * weight * mu @ on @ np.ones(nodes)


TABLE = ordinates.moments_of(np.array([-1, 0, 0.8, 1]), np.array([1.0, 0.2, 0.5, 6.0]), 60)


@pytest.mark.parametrize(
    ("moments", "depth", "albedo"),
    [
        (RAYLEIGH, 0.5, 1.0),
        (RAYLEIGH, 8.0, 0.95),
        (TABLE, 3.0, 0.99),
        (henyey_greenstein(0.3), 0.02, 0.7),
        (henyey_greenstein(-0.8), 4.0, 0.9),
        (henyey_greenstein(0.9), 30.0, 0.999),
    ],
)
def test_any_phase_function_agrees_with_a_solution_exact_in_depth(moments, depth, albedo):
    light = slab(depth, albedo, moments, None)
    assert close([light.reflected, light.transmitted], shares(depth, albedo, moments), 2e-6)
    assert not close([light.reflected, light.transmitted], shares(depth, albedo, moments[:2]), 1e-5)


def test_faces_with_reflection_agree_with_a_solution_exact_in_depth():
    """Nodes on both sides of the critical angle; reflections to and fro one after the other."""
    depth, albedo, index = 3.0, 0.95, 1.4
    x, w = legendre.leggauss(40)
    x, w = (x + 1) / 2, w / 2
    critical = math.sqrt(1 - 1 / index**2)
    # x = 0 at the critical angle, where the reflectance has a root.
    above, widths = critical + (1 - critical) * x**2, 2 * (1 - critical) * x * w
    mu, weight = np.append(critical * x, above), np.append(critical * w, widths)
    back, on = by_depth(depth, albedo, RAYLEIGH, mu, weight)
    r = fresnel.reflectance(mu, 1 / index)
    enters = (1 - r) * index**2
    down, up = enters, 0 * mu
    for _ in range(300):
        down, up = enters + r * (back @ down + on @ up), r * (on @ down + back @ up)
    leaves = 2 * weight * mu * (1 - r)
    light = slab(depth, albedo, RAYLEIGH, None, index)
    assert close(light.transmitted, leaves @ (on @ down + back @ up), 1e-6)
    returned = fresnel.diffuse_reflectance(index) + leaves @ (back @ down + on @ up)
    assert close(light.reflected, returned, 1e-6)


# ---- closed forms ----


@pytest.mark.parametrize("mu0", [1.0, 0.1, None])
def test_an_absorber_lets_through_what_beer_says(mu0):
    from scipy.special import expn

    light = slab(0.7, 0.0, FORWARD, mu0)
    assert light.reflected == 0
    assert close(light.transmitted, 2 * expn(3, 0.7) if mu0 is None else math.exp(-0.7 / mu0), 1e-11)


@pytest.mark.parametrize("mu0", [1.0, 0.3])
def test_a_clear_plate_is_stokes_s(mu0):
    light = slab(1e-15, 0.0, ISOTROPIC, mu0, 1.5)
    assert close(light.transmitted, fresnel.plate_transmittance(mu0, 1.5), 1e-12)
    assert close(light.reflected + light.transmitted, 1.0, 1e-12)
    r, inside = fresnel.reflectance(mu0, 1.5), math.sqrt(1 - (1 - mu0**2) / 2.25)
    e, tinted = math.exp(-0.7 / inside), slab(0.7, 0.0, ISOTROPIC, mu0, 1.5)
    assert close(tinted.transmitted, (1 - r) ** 2 * e / (1 - (r * e) ** 2), 1e-11)
    assert close(tinted.reflected, r + (1 - r) ** 2 * r * e * e / (1 - (r * e) ** 2), 1e-11)


@pytest.mark.parametrize("depth", [1e-12, 1e-9])
def test_a_thin_layer_scatters_once(depth):
    light = slab(depth, 0.9, ISOTROPIC, 0.5)
    half = 0.9 * depth / 0.5 / 2
    assert close([light.reflected_diffuse, light.transmitted_diffuse], half, 1e-7)
    assert close(light.reflected_in(EDGES), half / 30, 3e-6)
    assert close(light.reflected_in(EDGES)[1:], half / 30, 1e-7)


def test_what_passes_only_just_keeps_its_digits():
    """Nothing is the difference of nearly equal numbers."""
    light = slab(20.0, 0.2)
    assert close(light.transmitted, 2.936186100938e-09, 1e-11)
    assert slab(600.0, 0.2).transmitted < 1e-250


@pytest.mark.parametrize("index", [1.0, 1.37])
@pytest.mark.parametrize(
    ("depth", "moments"), [(1e-9, FORWARD), (2.0, FORWARD), (100.0, ISOTROPIC), (1e4, FORWARD)]
)
def test_without_absorption_nothing_is_lost(depth, moments, index):
    for mu0 in (1.0, 0.03, None):
        light = slab(depth, 1.0, moments, mu0, index)
        assert abs(light.absorbed) < 3e-11


def test_a_little_absorption_is_kept():
    """1e-9 of 2 tau crossings of Lambertian light, whose mean path is twice the thickness (Cauchy)."""
    assert close(slab(5.0, 1 - 1e-9, FORWARD, None).absorbed, 1e-8, 2e-6)
    assert close(slab(5.0, 1 - 1e-9, FORWARD, None, 1.4).absorbed, 1.4**2 * 1e-8, 2e-6)


@pytest.mark.parametrize("index", [1.0, 1.5])
@pytest.mark.parametrize("moments", [ISOTROPIC, FORWARD])
def test_light_takes_the_same_way_back(moments, index):
    """Radiance at mu of a beam at mu0, per irradiance, is that at mu0 of a beam at mu."""
    for one, other in ((0.2, 0.9), (0.03, 0.5)):
        lights = [slab(1.5, 0.95, moments, one, index), slab(1.5, 0.95, moments, other, index)]
        for way in ("reflected_radiance", "transmitted_radiance"):
            assert close(getattr(lights[0], way)(other), getattr(lights[1], way)(one), 2e-8)
        lambertian = slab(1.5, 0.95, moments, None, index)
        assert close(math.pi * lambertian.reflected_radiance(one), lights[0].reflected_diffuse, 2e-8)


def test_bins_are_integrals_of_the_radiance_and_hold_all():
    light, x = slab(2.0, 0.9, FORWARD, 0.5), legendre.leggauss(20)
    for bins, radiance, whole in (
        (light.reflected_in(EDGES), light.reflected_radiance, light.reflected_diffuse),
        (light.transmitted_in(EDGES), light.transmitted_radiance, light.transmitted_diffuse),
    ):
        assert close(bins.sum(), whole, 1e-13)
        mu = (EDGES[20] + EDGES[21] + x[0] / 30) / 2
        assert close(bins[20], 2 * math.pi * (x[1] / 60) @ (mu * radiance(mu)), 1e-9)


@pytest.mark.parametrize("index", [1.0, 1.5])
def test_bins_of_lambertian_light_hold_what_passed_straight_too(index):
    light = slab(0.5, 0.8, ISOTROPIC, None, index)
    assert close(light.transmitted_in(EDGES, straight=True).sum(), light.transmitted, 1e-12)
    assert close(light.transmitted_in(EDGES).sum(), light.transmitted_diffuse, 1e-12)
    assert close(light.reflected_in(EDGES, straight=True).sum(), light.reflected, 1e-12)
    assert close(light.reflected_in(EDGES).sum(), light.reflected_diffuse, 1e-12)
    if index == 1:
        straight = light.transmitted_in(EDGES, straight=True) - light.transmitted_in(EDGES)
        mu = legendre.leggauss(20)
        places = (EDGES[12] + EDGES[13] + mu[0] / 30) / 2
        assert close(straight[12], 2 * (mu[1] / 60) @ (places * np.exp(-0.5 / places)), 1e-9)


def test_halves_on_the_way_are_slabs():
    lights = ordinates.halved_slabs(3.0, 4, 0.9, FORWARD, 0.4, 1.2)
    for light, depth in zip(lights, (0.1875, 0.375, 0.75, 1.5, 3.0), strict=True):
        alone = slab(depth, 0.9, FORWARD, 0.4, 1.2)
        assert close([light.reflected, light.transmitted], [alone.reflected, alone.transmitted], 1e-10)


@pytest.mark.parametrize("moments", [ISOTROPIC, FORWARD])
def test_no_digit_depends_on_the_quadrature(moments, monkeypatch):
    """Planted: narrower and lower panels, and a first layer a hundred times thinner."""
    before = [slab(2.0, 0.9, moments, mu0, index) for mu0 in (1.0, 0.1, None) for index in (1.0, 1.5)]
    for name, value in {"GRAZING": 1e-7, "WIDTH_FACTOR": 0.8, "MAX_WIDTH": 0.3}.items():
        monkeypatch.setattr(ordinates, name, value)
    monkeypatch.setattr(ordinates, "MAX_START_DEPTH", 1e-3)
    slab.cache_clear()
    after = [slab(2.0, 0.9, moments, mu0, index) for mu0 in (1.0, 0.1, None) for index in (1.0, 1.5)]
    slab.cache_clear()
    for old, new in zip(before, after, strict=True):
        assert close([old.reflected, old.transmitted], [new.reflected, new.transmitted], 1e-9)
        assert close(old.reflected_in(EDGES), new.reflected_in(EDGES), 1e-8)
        assert close(old.transmitted_in(EDGES), new.transmitted_in(EDGES), 1e-8)


def test_moments_of_a_table_are_its_integrals():
    assert close(
        ordinates.moments_of(np.array([-1.0, 1.0]), np.array([0.5, 1.5]), 3), [1, 1 / 6, 0], 1e-13, 1e-15
    )
    mu = np.linspace(-1, 1, 4001)
    density = (1 - 0.75**2) / (1 + 0.75**2 - 1.5 * mu) ** 1.5
    assert close(ordinates.moments_of(mu, density, 12), FORWARD[:12], 1e-4)


def test_impossible_slabs_are_refused():
    for parameters, words in (
        ((0.0, 0.5), "depth must be above 0"),
        ((math.nan, 0.5), "depth must be above 0"),
        ((1.0, 1.1), "albedo must be from 0 to 1"),
        ((math.inf, 1.0), "below 1 in a half space"),
        ((1.0, 0.5, (0.9,)), "must begin with 1"),
        ((1.0, 0.5, (1.0, 1.2)), "from -1 to 1"),
        ((1.0, 0.5, ISOTROPIC, 0.0), "mu0 must be above 0"),
        ((1.0, 0.5, ISOTROPIC, 1.0, 0.9), "index must be 1 or more"),
    ):
        with pytest.raises(ValueError, match=words):
            slab(*parameters)
    with pytest.raises(ValueError, match=r"between -0\.99 and"):
        henyey_greenstein(0.999)
    with pytest.raises(ValueError, match="edges must increase"):
        slab(1.0, 0.5).reflected_in([0.5, 0.2])
