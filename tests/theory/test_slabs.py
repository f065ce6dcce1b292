"""Slabs and half spaces: discrete ordinates, normal modes, H functions and glowing media against references and one another.

A comment such as `E.slab_HG` names the entry of the project's reference collection that numbers come from.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.special import expn

from tests.slow import quick
from transport.theory import fresnel, glow, half_space, ordinates, turbid
from transport.theory.enclosures import mean_chord
from transport.theory.ordinates import ISOTROPIC, RAYLEIGH, henyey_greenstein, slab
from transport.theory.turbid import Diffusion, boundary_factor, solved

FORWARD = henyey_greenstein(0.75)
EDGES = np.linspace(0, 1, 31)


def close(value, exact, relative=1e-9, absolute=0.0):
    exact = np.asarray(exact, dtype=float)
    return np.allclose(np.asarray(value, dtype=float), exact, rtol=relative, atol=absolute)


def gauss(count, low=0.0, high=1.0):
    nodes, weights = legendre.leggauss(count)
    return low + (nodes + 1) * (high - low) / 2, weights * (high - low) / 2


# ---- references: optical thickness, albedo, g, cosine (None: Lambertian light); R, T with what is unscattered ----

SLABS = [
    (0.1, 0.5, 0.0, 0.5, 0.04149825402865099, 0.8598280231690119),  # E.slab_isotropic
    (0.1, 0.9, 0.0, 0.01, 0.4911182797406901, 0.3928483950723313),
    (1.0, 0.99, 0.0, None, 0.4359615977698839, 0.5443523892030422),
    (2.0, 0.9, 0.0, 0.5, 0.4739410915196685, 0.2172358881219712),
    (2.0, 1.0, 0.0, 0.01, 0.8249881368706198, 0.17501186299363508),
    (10.0, 0.5, 0.0, 0.5, 0.16014443336035003, 1.597315395060293e-05),
    (10.0, 0.99, 0.0, 0.1, 0.8725955710805922, 0.03535304571346936),
    (0.1, 0.5, 0.9, 0.5, 0.0043891478189455515, 0.8989421691322985),  # E.slab_HG
    (2.0, 0.9, 0.9, 1.0, 0.03221529690693779, 0.7595763410251009),
    (10.0, 0.99, 0.9, 1.0, 0.24762764934429707, 0.5890815105839808),
    (2.0, 0.9, 0.75, None, 0.19109022660045846, 0.5018160583986766),
    (1.0, 1.0, 0.75, 0.1, 0.5814799285560952, 0.418520071442993),
    (10.0, 0.99, 0.75, 0.1, 0.7717960062606302, 0.12380436500095036),
    (2.0, 0.9, 0.75, 1.0, 0.0973946386719247, 0.6609577001638116),  # E.vandehulst_hg
    (2.0, 0.9, -0.5, 0.1, 0.6528806886527894, 0.08113610764574092),
    (10.0, 0.99, -0.5, 0.5, 0.8426138403458997, 0.03235635976978046),
]


@pytest.mark.parametrize("case", quick(SLABS, SLABS[0], SLABS[8]))
def test_discrete_ordinates_of_slabs_agree_with_references(case):
    depth, albedo, g, mu0, *exact = case
    light = slab(depth, albedo, henyey_greenstein(g) if g else ISOTROPIC, mu0)
    assert close([light.reflected, light.transmitted], exact, 1e-8 if g == 0 else 1e-9)


@pytest.mark.parametrize("case", [case for case in SLABS if case[1] < 1 and case[3] not in (None, 0.01)])
def test_normal_modes_of_slabs_agree_with_references(case):
    depth, albedo, g, mu0, *exact = case
    light = solved(albedo, g, 1.0, mu0, depth)
    assert close([light.reflectance, light.transmittance], exact, 1e-8 if g == 0 and mu0 < 1 else 2e-10)
    assert light.specular == 0


GIOVANELLI = {  # E.giovanelli: index, albedo; reflected diffusely of a normal beam, of Lambertian light
    (1.5, 0.9): (0.2199185699177473, 0.3078900405765885),
    (1.5, 0.99): (0.5619807856719933, 0.6319609387949664),
    (1.33, 0.99): (0.63289859711793, 0.6822246875503498),
    (1.4, 0.999): (0.8301157019580623, 0.8702490264590612),
}


@pytest.mark.parametrize(("index", "albedo"), GIOVANELLI)
def test_half_spaces_behind_fresnel_s_boundary_agree_with_references(index, albedo):
    milk, specular = solved(albedo, 0.0, index), ((index - 1) / (index + 1)) ** 2
    assert close(milk.reflectance + milk.specular, GIOVANELLI[index, albedo][0] + specular)
    assert milk.transmittance == 0


@pytest.mark.slow
@pytest.mark.parametrize(("index", "albedo"), GIOVANELLI)
def test_discrete_ordinates_behind_fresnel_s_boundary_agree_with_references(index, albedo):
    light, (diffuse, lambertian) = ordinates.half_space(albedo, index=index), GIOVANELLI[index, albedo]
    assert close(light.unscattered_back, ((index - 1) / (index + 1)) ** 2, 1e-14)
    assert close(light.reflected_diffuse, diffuse)
    assert close(ordinates.half_space(albedo, mu0=None, index=index).reflected, lambertian)


ALBEDOS = {  # E.semi_infinite_albedo: at cosines 1, 0.5, 0.1, and of Lambertian light
    0.5: [0.1152258777072045, 0.16014443343523477, 0.24172077643602807, 0.14654438069971842],
    0.99: [0.7527207171602972, 0.8151398983552154, 0.8775124709582844, 0.7945636529020276],
}


@pytest.mark.parametrize(("albedo", "exact"), ALBEDOS.items())
def test_albedos_of_half_spaces_agree_with_references(albedo, exact):
    assert close(half_space.plane_albedo(np.array([1, 0.5, 0.1]), albedo), exact[:3], 1e-12)
    assert close(half_space.spherical_albedo(albedo), exact[3], 1e-12)
    assert close(solved(albedo, 0.0).reflectance, exact[0])


RADIANCES = [  # function of mu, mu, exact, relative tolerance
    (
        lambda mu: half_space.h_function(mu, 0.9),
        [0, 0.01, 0.1, 0.3, 0.5, 0.7, 1],
        [1.0, 1.0266037646743182, 1.172143053516453, 1.3913503206325721, 1.5560338020213627, 1.6893476003306453, 1.8500985167698123],
        1e-12,
    ),  # E.H_function
    (
        lambda mu: half_space.h_function(mu, 0.999),
        [0, 0.01, 0.1, 0.3, 0.5, 0.7, 1],
        [1.0, 1.0336742337530118, 1.2404247728560973, 1.6156710550408053, 1.9586874743593254, 2.285750378701103, 2.7560725072687355],
        1e-12,
    ),
    (
        half_space.milne_radiance,
        [0, 0.1, 0.3, 0.5, 0.7, 0.9, 1],
        [0.13783222385544802, 0.17192508541608523, 0.22639249644386067, 0.2774257739977447, 0.3272102415720116, 0.3763629702806441, 0.40078999177319113],
        1e-12,
    ),  # E.milne_emergent
    pytest.param(
        lambda mu: slab(2.0, 0.9, ISOTROPIC, 0.1).reflected_radiance(mu),
        [0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0],
        [0.6128369692978717, 0.4891410295498392, 0.2881460268044603, 0.2126389862993059, 0.17091517677906365, 0.14369467472120148, 0.13324565104949662],
        3e-8,
        marks=pytest.mark.slow,
    ),  # E.slab_isotropic_radiance
    pytest.param(
        lambda mu: slab(2.0, 0.9, ISOTROPIC, 0.1).transmitted_radiance(mu),
        [0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0],
        [0.017090798569973475, 0.018769688811355167, 0.025939452351440042, 0.03486634211989341, 0.0420813403781328, 0.04638209127630759, 0.04762045410155816],
        3e-8,
        marks=pytest.mark.slow,
    ),
    pytest.param(
        lambda mu: [math.pi * slab(2.0, 0.8, ISOTROPIC, each).reflected_radiance(0.5) for each in mu],
        [1.0, 0.9, 0.7, 0.3, 0.1],
        [0.28616183950158336, 0.30277007555728763, 0.34188319617792345, 0.453533583804399, 0.5321439640781754],
        1e-9,
        marks=pytest.mark.slow,
    ),  # E.vandehulst_table12
    pytest.param(
        lambda mu: [math.pi * slab(2.0, 0.8, ISOTROPIC, each).transmitted_radiance(0.5) for each in mu],
        [1.0, 0.9, 0.7, 0.3, 0.1],
        [0.14864384649787957, 0.14731230281103289, 0.1396289899961939, 0.09424683697922924, 0.06601238388289248],
        1e-9,
        marks=pytest.mark.slow,
    ),
]  # fmt: skip


@pytest.mark.parametrize(("function", "mu", "exact", "relative"), RADIANCES)
def test_radiances_and_h_functions_agree_with_references(function, mu, exact, relative):
    assert close(function(np.array(mu)), exact, relative)


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
    assert close(found, [x, y])


def test_the_phase_function_s_mean_over_azimuth_agrees_with_references():
    found = [ordinates.azimuthal_phase(henyey_greenstein(g), np.array([0.3, 0.8])) for g in (0.75, 0.9, -0.5)]
    assert close(found[0][0][0, 1], 0.6517969828537737)  # E.HG_azimuth_average
    assert close(found[1][1][0, 1], 0.0707498098558913)
    assert close([phase[0, 1] for phase in found[2]], [0.4791207000816786, 1.0646598109698588])


def test_the_slowest_mode_is_that_of_infinite_media():
    """c atanh(κ) = κ of isotropic scattering (F.diffusion_length)."""
    for albedo, rate in {0.7: 0.8286347986408346, 0.9: 0.5254295126580086, 0.95: 0.37948520667809}.items():
        assert close(solved(albedo, 0.0).slowest_rate, rate, 1e-12)


# ---- H functions, Milne's problem, thick slabs ----


@pytest.mark.parametrize("case", [(1e-6, 0.9), (0.4, 1.0), (1.0, 1.0), (0.7, 1 - 1e-9), (1.0, 0.01)])
def test_h_agrees_with_mpmath(case):
    with mp.workdps(80):
        m, a = map(mp.mpf, case)

        def integrand(t):
            return mp.log(1 - a * mp.atan(t) / t) / (1 + m * m * t * t)

        powers = (-20, -12, -9, -6, -4, -2, 0, 1, 2, 4, 6, 8)  # below, 1e-18
        exact = mp.exp(-m / mp.pi * mp.quad(integrand, [*(mp.mpf(10) ** power for power in powers), mp.inf]))
    assert close(half_space.h_function(*case), float(exact), 1e-12)


@pytest.mark.parametrize("albedo", [0.0, 0.3, 0.9, 1.0])
def test_h_solves_chandrasekhar_s_equation(albedo):
    nodes, weights = half_space.HEMISPHERE
    h = half_space.h_function(nodes, albedo)
    for mu in (0.01, 0.5, 1.0):
        value = half_space.h_function(mu, albedo)
        assert close(value, 1 + albedo / 2 * mu * value * (weights @ (h / (mu + nodes))), 1e-12)
    assert close(half_space.h_moment(0, albedo), 2 / (1 + math.sqrt(1 - albedo)), 1e-12)


@pytest.mark.parametrize("albedo", quick([0.1, 0.9, 0.999], 0.9))
@pytest.mark.parametrize("mu0", quick([1.0, 0.05, None], 0.05))
def test_discrete_ordinates_obey_the_law_of_darkening(albedo, mu0):
    light = ordinates.half_space(albedo, mu0=mu0)
    whole = half_space.spherical_albedo(albedo) if mu0 is None else half_space.plane_albedo(mu0, albedo)
    assert close(light.reflected, whole, 1e-10)
    assert light.transmitted < 1e-15
    assert close(light.reflected_in(EDGES), half_space.darkening_in(EDGES, mu0, albedo))
    mu = np.array([0.02, 0.4, 1.0])
    assert close(light.reflected_radiance(mu), half_space.darkening(mu, mu0, albedo), 1e-8)
    assert close(half_space.darkening_in(EDGES, mu0, albedo).sum(), whole, 1e-12)
    assert not close(light.reflected_in(EDGES), np.diff(EDGES**2) * whole, 1e-2)  # Lambert's law


def test_hopf_s_constant_agrees_with_its_integral_and_milne_s_flux_is_one():
    assert close(half_space.milne_in(EDGES).sum(), 1.0, 1e-12)  # E.milne_flux_check
    assert close(half_space.hopf_constant(), 0.7104460895987631, 1e-12)  # E.hopf_constant
    with mp.workdps(25):
        rest = mp.quad(lambda x: 3 / x**2 - 1 / (1 - x * mp.cot(x)), [1e-4, 0.1, 1, mp.pi / 2])
        rest += mp.mpf("1e-4") / 5  # of its series, 1/5 + O(x^2) at 0
    assert close(half_space.hopf_constant(), float(6 / mp.pi**2 + rest / mp.pi), 1e-11)


THICK = {
    10: 0.11674511171391949,
    50: 0.02592979773059389,
    200: 0.006619637709414444,
}  # E.conservative_thick_slab


@pytest.mark.slow
@pytest.mark.parametrize("depth", THICK)
def test_thick_slabs_obey_the_law(depth):
    assert close(half_space.thick_slab(depth), THICK[depth], 1e-12)
    light = slab(float(depth), 1.0, mu0=None)
    assert close(light.transmitted, half_space.thick_slab(depth), max(1e-10, math.exp(-depth)))
    assert close(half_space.measured_extrapolation(light.transmitted, depth), 0.7104460895987631, 2e-7)
    for mu0 in (1.0, 0.1):
        beam = slab(float(depth), 1.0, mu0=mu0).transmitted
        assert close(beam, half_space.thick_slab_beam(depth, mu0), max(1e-10, 10 * math.exp(-depth)))


@pytest.mark.slow
def test_the_thickest_slabs_obey_the_law_and_thin_ones_do_not():
    assert close(slab(1e4, 1.0, mu0=None).transmitted, half_space.thick_slab(1e4), 3e-8)
    assert not close(slab(1.0, 1.0, mu0=None).transmitted, half_space.thick_slab(1.0), 1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("g", [-0.5, 0.9])
def test_thick_slabs_of_any_phase_function_obey_it_with_their_own_q(g):
    moments, depth = henyey_greenstein(g), 100 / (1 - g)
    assert close(slab(depth, 1.0, moments, None).transmitted, half_space.thick_slab(depth, moments))
    assert 0.7104 < half_space.extrapolation(moments) < 0.7151


@pytest.mark.slow
@pytest.mark.parametrize(("index", "albedo", "mu0"), [(1.5, 0.9, 1.0), (1.2, 0.99, 0.2), (2.4, 0.5, 0.2)])
def test_fresnel_s_boundary_agrees_with_the_h_function(index, albedo, mu0):
    """Light within follows from the law of darkening, reflection after reflection; the nodes are others."""
    x, w = gauss(60)
    critical = math.sqrt(1 - 1 / index**2)
    mu = np.append(critical * x**2, critical + (1 - critical) * x**2)
    weight = np.append(2 * critical * x * w, 2 * (1 - critical) * x * w)
    within = math.sqrt(1 - (1 - mu0**2) / index**2)
    passed = 1 - fresnel.reflectance(mu0, index)
    h = half_space.h_function(mu, albedo)
    kernel = albedo / 2 * np.outer(h, h) / (mu[:, None] + mu) * weight * mu
    first = passed * albedo / (4 * math.pi) * h * half_space.h_function(within, albedo) / (mu + within)
    r, up = fresnel.reflectance(mu, 1 / index), first
    for _ in range(2000):
        up = first + kernel @ (r * up)
    light = ordinates.half_space(albedo, mu0=mu0, index=index)
    assert close(light.reflected_diffuse, 2 * math.pi * (weight * mu) @ ((1 - r) * up), 1e-7)


# ---- discrete ordinates against plain Gauss nodes, exact in depth by the singular values of one matrix ----


def by_depth(depth, albedo, moments, mu, weight):
    """What goes back and on, as matrices from radiance to radiance.

    With s = d + u, y = d - u: mu y' = -A s, mu s' = -B y; s = cosh, sinh of k tau, whose k are singular values.
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
    mu, weight = gauss(nodes)
    back, on = by_depth(depth, albedo, moments, mu, weight)
    return 2 * weight * mu @ back @ np.ones(nodes), 2 * weight * mu @ on @ np.ones(nodes)


TABLE = ordinates.moments_of(np.array([-1, 0, 0.8, 1]), np.array([1.0, 0.2, 0.5, 6.0]), 60)
PHASES = {
    "Rayleigh": (RAYLEIGH, 0.5, 1.0),
    "Rayleigh, thick": (RAYLEIGH, 8.0, 0.95),
    "a table": (TABLE, 3.0, 0.99),
    "g 0.3, thin": (henyey_greenstein(0.3), 0.02, 0.7),
    "g -0.8": (henyey_greenstein(-0.8), 4.0, 0.9),
    "g 0.9, thick": (henyey_greenstein(0.9), 30.0, 0.999),
}


@pytest.mark.parametrize("name", quick(PHASES, "a table"))
def test_any_phase_function_agrees_with_a_solution_exact_in_depth(name):
    moments, depth, albedo = PHASES[name]
    light = slab(depth, albedo, moments, None)
    assert close([light.reflected, light.transmitted], shares(depth, albedo, moments), 2e-6)
    assert not close([light.reflected, light.transmitted], shares(depth, albedo, moments[:2]), 1e-5)


def test_faces_with_reflection_agree_with_a_solution_exact_in_depth():
    """Nodes on both sides of the critical angle; reflections to and fro one after the other."""
    depth, albedo, index = 3.0, 0.95, 1.4
    x, w = gauss(40)
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


# ---- discrete ordinates against closed forms ----


@pytest.mark.parametrize("mu0", quick([1.0, 0.1, None], None))
def test_an_absorber_transmits_by_beer_s_law(mu0):
    light = slab(0.7, 0.0, FORWARD, mu0)
    assert light.reflected == 0
    assert close(light.transmitted, 2 * expn(3, 0.7) if mu0 is None else math.exp(-0.7 / mu0), 1e-11)


@pytest.mark.parametrize("mu0", quick([1.0, 0.3], 0.3))
def test_a_clear_plate_is_stokes_s(mu0):
    light = slab(1e-15, 0.0, ISOTROPIC, mu0, 1.5)
    assert close(light.transmitted, fresnel.plate_transmittance(mu0, 1.5), 1e-12)
    assert close(light.reflected + light.transmitted, 1.0, 1e-12)
    r, inside = fresnel.reflectance(mu0, 1.5), math.sqrt(1 - (1 - mu0**2) / 2.25)
    e, tinted = math.exp(-0.7 / inside), slab(0.7, 0.0, ISOTROPIC, mu0, 1.5)
    assert close(tinted.transmitted, (1 - r) ** 2 * e / (1 - (r * e) ** 2), 1e-11)
    assert close(tinted.reflected, r + (1 - r) ** 2 * r * e * e / (1 - (r * e) ** 2), 1e-11)


@pytest.mark.parametrize("depth", quick([1e-12, 1e-9], 1e-12))
def test_a_thin_layer_scatters_once(depth):
    light = slab(depth, 0.9, ISOTROPIC, 0.5)
    half = 0.9 * depth / 0.5 / 2
    assert close([light.reflected_diffuse, light.transmitted_diffuse], half, 1e-7)
    assert close(light.reflected_in(EDGES), half / 30, 3e-6)
    assert close(light.reflected_in(EDGES)[1:], half / 30, 1e-7)


@pytest.mark.slow
def test_faint_transmission_keeps_its_digits():
    """Nothing is the difference of nearly equal numbers."""
    assert close(slab(20.0, 0.2).transmitted, 2.936186100938e-09, 1e-11)
    assert slab(600.0, 0.2).transmitted < 1e-250


@pytest.mark.slow
@pytest.mark.parametrize(
    ("depth", "moments", "index"),
    [(1e-9, FORWARD, 1.37), (2.0, FORWARD, 1.0), (100.0, ISOTROPIC, 1.37), (1e4, FORWARD, 1.0)],
)
def test_without_absorption_nothing_is_lost(depth, moments, index):
    for mu0 in (0.03, None):
        assert abs(slab(depth, 1.0, moments, mu0, index).absorbed) < 3e-11


@pytest.mark.slow
def test_a_little_absorption_is_kept():
    """1e-9 of 2 tau crossings of Lambertian light, whose mean path is twice the thickness (Cauchy)."""
    assert close(slab(5.0, 1 - 1e-9, FORWARD, None).absorbed, 1e-8, 2e-6)
    assert close(slab(5.0, 1 - 1e-9, FORWARD, None, 1.4).absorbed, 1.4**2 * 1e-8, 2e-6)


@pytest.mark.parametrize("index", quick([1.0, 1.5], 1.5))
@pytest.mark.parametrize("moments", quick([ISOTROPIC, FORWARD], ISOTROPIC), ids=["isotropic", "forward"])
@pytest.mark.parametrize("cosines", [(0.2, 0.9)])
def test_light_takes_the_same_way_back(cosines, moments, index):
    """Radiance at mu of a beam at mu0, per irradiance, is that at mu0 of a beam at mu."""
    one, other = cosines
    lights = [slab(1.5, 0.95, moments, mu0, index) for mu0 in cosines]
    for way in ("reflected_radiance", "transmitted_radiance"):
        assert close(getattr(lights[0], way)(other), getattr(lights[1], way)(one), 2e-8)
    lambertian = slab(1.5, 0.95, moments, None, index)
    assert close(math.pi * lambertian.reflected_radiance(one), lights[0].reflected_diffuse, 2e-8)


@pytest.mark.slow
def test_bins_are_integrals_of_the_radiance_and_hold_all():
    light = slab(2.0, 0.9, FORWARD, 0.5)
    mu, weights = gauss(20, *EDGES[20:22])
    for bins, radiance, whole in (
        (light.reflected_in(EDGES), light.reflected_radiance, light.reflected_diffuse),
        (light.transmitted_in(EDGES), light.transmitted_radiance, light.transmitted_diffuse),
    ):
        assert close(bins.sum(), whole, 1e-13)
        assert close(bins[20], 2 * math.pi * weights @ (mu * radiance(mu)))


@pytest.mark.parametrize("index", quick([1.0, 1.5], 1.5))
def test_bins_of_lambertian_light_hold_the_unscattered_light_too(index):
    light = slab(0.5, 0.8, ISOTROPIC, None, index)
    assert close(light.transmitted_in(EDGES, straight=True).sum(), light.transmitted, 1e-12)
    assert close(light.transmitted_in(EDGES).sum(), light.transmitted_diffuse, 1e-12)
    assert close(light.reflected_in(EDGES, straight=True).sum(), light.reflected, 1e-12)
    assert close(light.reflected_in(EDGES).sum(), light.reflected_diffuse, 1e-12)
    if index == 1:
        straight = light.transmitted_in(EDGES, straight=True) - light.transmitted_in(EDGES)
        mu, weights = gauss(20, *EDGES[12:14])
        assert close(straight[12], 2 * weights @ (mu * np.exp(-0.5 / mu)))


@pytest.mark.slow
def test_halves_on_the_way_are_slabs():
    lights = ordinates.halved_slabs(3.0, 4, 0.9, FORWARD, 0.4, 1.2)
    for light, depth in zip(lights, (0.1875, 0.375, 0.75, 1.5, 3.0), strict=True):
        alone = slab(depth, 0.9, FORWARD, 0.4, 1.2)
        assert close([light.reflected, light.transmitted], [alone.reflected, alone.transmitted], 1e-10)


@pytest.mark.slow
def test_no_digit_depends_on_the_quadrature(monkeypatch):
    """Planted: narrower and lower panels, and a first layer a hundred times thinner."""
    media = (ISOTROPIC, 0.1, 1.5), (FORWARD, 1.0, 1.0), (FORWARD, None, 1.5)
    before = [slab(2.0, 0.9, *medium) for medium in media]
    changes = {"GRAZING": 1e-7, "WIDTH_FACTOR": 0.8, "MAX_WIDTH": 0.3, "MAX_START_DEPTH": 1e-3}
    for name, value in changes.items():
        monkeypatch.setattr(ordinates, name, value)
    slab.cache_clear()
    after = [slab(2.0, 0.9, *medium) for medium in media]
    slab.cache_clear()
    for old, new in zip(before, after, strict=True):
        assert close([old.reflected, old.transmitted], [new.reflected, new.transmitted])
        assert close(old.reflected_in(EDGES), new.reflected_in(EDGES), 1e-8)
        assert close(old.transmitted_in(EDGES), new.transmitted_in(EDGES), 1e-8)


def test_moments_of_a_table_are_its_integrals():
    found = ordinates.moments_of(np.array([-1.0, 1.0]), np.array([0.5, 1.5]), 3)
    assert close(found, [1, 1 / 6, 0], 1e-13, 1e-15)
    mu = np.linspace(-1, 1, 4001)
    density = (1 - 0.75**2) / (1 + 0.75**2 - 1.5 * mu) ** 1.5
    assert close(ordinates.moments_of(mu, density, 12), FORWARD[:12], 1e-4)


# ---- normal modes of turbid media behind Fresnel's boundaries, and diffusion ----

MILK = {"albedo": 1000 / 1001, "g": 0.9, "index": 1.37}
CASES = [
    MILK,
    MILK | {"cosine": 0.3},
    MILK | {"thickness": 20.0},
    {"albedo": 0.99, "g": 0.9, "index": 1.5, "cosine": 0.7, "thickness": 0.5},
    {"albedo": 0.9, "g": -0.7, "index": 1.1, "thickness": 3.0},
    {"albedo": 1 - 1e-6, "g": 0.8, "index": 1.33},
]
cases = pytest.mark.parametrize("case", CASES)


@cases
def test_incident_light_is_reflected_transmitted_or_absorbed(case):
    """The absorbed is given by the fluence, the rest by the radiance at the boundaries."""
    medium = solved(**case)
    whole = medium.specular + medium.reflectance + medium.transmittance + medium.absorbed
    assert whole == pytest.approx(1, rel=1e-10)


@cases
def test_more_nodes_change_nothing(case, monkeypatch):
    depths, medium = np.array([0.0, 0.1, 0.5]), solved(**case)
    monkeypatch.setattr(turbid, "NODES", 128)
    finer = solved.__wrapped__(**case)
    assert len(finer.rates) > len(medium.rates)
    assert close([medium.reflectance, medium.absorbed], [finer.reflectance, finer.absorbed])
    assert close(medium.fluence(depths), finer.fluence(depths))
    monkeypatch.setattr(turbid, "NODES", 24)  # too few are seen
    rough = solved.__wrapped__(**case)
    assert abs(case["g"]) < 0.85 or not close(rough.reflectance, finer.reflectance, 1e-6)


@cases
def test_means_over_cells_are_means_of_the_fluence(case):
    medium, edges = solved(**case), np.array([0.0, 1e-3, 0.1, 0.4])
    nodes, weights = legendre.leggauss(30)
    places = (edges[1:] + edges[:-1])[:, None] / 2 + np.diff(edges)[:, None] / 2 * nodes
    means = medium.fluence(places) @ weights / 2
    assert close(medium.mean_fluence(edges), means, 1e-5)  # Gauss's error at the top
    assert close(medium.mean_fluence(edges)[1:], means[1:])


@pytest.mark.slow
def test_normal_modes_agree_with_discrete_ordinates():
    """Other nodes, other phase matrices, depth by doubling.  Of milk as well, in 5 s."""
    modes = solved(0.99, 0.6, 1.5, thickness=2.0)
    doubled = slab(2.0, 0.99, henyey_greenstein(0.6), index=1.5)
    assert close(modes.reflectance + modes.specular, doubled.reflected, 1e-11)
    assert close(modes.transmittance, doubled.transmitted, 1e-11)


@pytest.mark.parametrize("thickness", quick([1.0, math.inf], math.inf))
@pytest.mark.parametrize("cosines", quick([(1.0, 0.3), (0.9, 0.05)], (1.0, 0.3)))
def test_a_path_is_as_likely_as_its_reverse(cosines, thickness):
    """Radiance at one cosine over irradiance at another is the same the other way round (Helmholtz 1867)."""
    one, other = cosines
    there, back = (solved(0.99, 0.9, 1.37, mu, thickness) for mu in cosines)
    assert close(there.radiance(other), back.radiance(one), 1e-7)
    assert not close(there.radiance(other), there.radiance(one), 0.01)


def test_bins_of_leaving_light_add_up_to_the_whole():
    milk, edges = solved(**MILK), np.array([0, 0.1, 0.35, 1.0])
    assert milk.leaving(edges).sum() == pytest.approx(milk.reflectance, rel=1e-12)
    for low, high, share in zip(edges[:-1], edges[1:], milk.leaving(edges), strict=True):
        mu, weights = gauss(60, low, high)
        assert close(2 * math.pi * (milk.radiance(mu) * mu) @ weights, share, 1e-10)


def test_hardly_scattering_plates_are_stokes_s():
    """(1 - R)/(1 + R) of a plate that takes nothing, less where it absorbs."""
    assert close(solved(1e-12, 0.0, 1.5, thickness=1e-9).transmittance, 0.96 / 1.04, 1e-8)
    dark, passed = solved(1e-12, 0.0, 1.5, thickness=0.7), math.exp(-0.7)
    assert close(dark.transmittance, 0.96**2 * passed / (1 - (0.04 * passed) ** 2))
    both_ways = 0.96 * (math.exp(-0.2) + 0.04 * math.exp(-1.2)) / (1 - 0.0016 * passed**2)
    assert close(dark.fluence(0.2), both_ways)


def test_a_boundary_forgotten_shows():
    """Planted: no internal reflection, no specular share, isotropic scattering of σ_s for that of σ_s (1 - g)."""
    milk = solved(**MILK)
    assert close(milk.reflectance, 0.61643411023, 1e-10)
    for wrong in (
        (1 - milk.specular) * solved(MILK["albedo"], 0.9).reflectance,
        milk.reflectance + milk.specular,
        solved(MILK["albedo"], 0.0, 1.37).reflectance,
    ):
        assert not close(wrong, milk.reflectance, 0.03)


@pytest.mark.parametrize(("case", "far"), [(MILK, 0.02), (MILK | {"albedo": 1 - 1e-5}, 1e-3)])
def test_diffusion_is_near_where_scattering_is_strong(case, far):
    exact, near = solved(**case), Diffusion(**case)
    assert close(near.reflectance, exact.reflectance, far)
    assert close(near.rate, exact.slowest_rate, 3e-3)
    assert close(near.fluence(100.0), exact.fluence(100.0), 0.02)
    assert not close(near.fluence(1.0), exact.fluence(1.0), 0.1)  # near the boundary it is 15 % too low


def test_diffusion_keeps_its_own_balance():
    milk = Diffusion(**MILK)
    depths, weights = gauss(200, 0, 2000)
    absorbed = (1 - milk.albedo) * milk.fluence(depths) @ weights
    assert absorbed + milk.reflectance == pytest.approx(1 - solved(**MILK).specular, rel=1e-9)
    assert boundary_factor(1.0) == 1
    assert boundary_factor(1.4) == pytest.approx(2.945, abs=0.005)  # Haskell 1994: R_eff 0.493


# ---- glowing media ----

GLOWING = [
    (glow.ball_escape, 0.01, 0.9925398339030994),  # F.sphere_escape_probability
    (glow.ball_escape, 1.0, 0.5272521936411892),
    (glow.ball_escape, 5.0, 0.14700149819768216),
    (glow.slab_escape, 0.1, 0.8370854209172118),  # F.slab_escape_probability
    (glow.slab_escape, 1.0, 0.3903080328022398),
    (glow.slab_escape, 5.0, 0.09982443982144587),
]


def test_escape_agrees_with_references_and_functions_take_arrays():
    for function, x, exact in GLOWING:
        assert close(function(x), exact, 1e-14)
    x = np.array([0.1, 0.5, 3.0])
    for name in ("ball_emissivity", "ball_escape", "slab_emissivity", "slab_escape", "ray_share"):
        function = getattr(glow, name)
        assert close(function(x), [function(each) for each in x], 1e-14)


@pytest.mark.parametrize("x", [1e-12, 1e-3, 0.3, 0.4999999, 0.5, 0.7, 20.0, 1e5])
def test_escape_keeps_its_digits_where_the_textbook_form_does_not(x):
    with mp.workdps(60):
        m = mp.mpf(x)
        ball = 3 / (8 * m**3) * (2 * m**2 - 1 + (1 + 2 * m) * mp.exp(-2 * m))
        plate = (1 - 2 * mp.expint(3, m)) / (2 * m)
    assert close(glow.ball_escape(x), float(ball), 4e-15)
    assert close(glow.slab_escape(x), float(plate), 4e-15)
    textbook = 3 / (8 * x**3) * (2 * x**2 - 1 + (1 + 2 * x) * math.exp(-2 * x))
    assert x > 1e-2 or not close(textbook, float(ball), 1e-11)


RIMS = np.array([0.0, 0.2, 0.7, 0.95, 1.0])


def test_emissivity_is_the_mean_over_chords():
    """Of a ball: ∫ (1 - e^(-2xμ)) 2 μ dμ; of a slab, with chords d/μ."""
    mu, weights = gauss(80)
    assert close(glow.ball_emissivity(1.7), weights * 2 * mu @ glow.ray_share(2 * 1.7 * mu), 1e-14)
    assert close(glow.slab_emissivity(1.7), weights * 2 * mu @ glow.ray_share(1.7 / mu))
    found = glow.ball_rim_share(1.7, RIMS)
    assert close(found @ np.diff(RIMS**2), glow.ball_emissivity(1.7), 1e-14)
    assert not close(found, glow.ray_share(1.7 * (RIMS[1:] + RIMS[:-1])), 1e-3)


def test_a_mean_beam_is_four_volumes_over_surface_where_thin():
    thin = 1e-9
    ball = glow.mean_beam_length(glow.ball_emissivity(thin), thin)
    assert close(ball, mean_chord(4 / 3, 4), 1e-8)
    assert close(glow.mean_beam_length(glow.slab_emissivity(thin), thin), 2.0, 1e-7)
    thick = glow.ball_emissivity(3.0)
    assert glow.mean_beam_length(thick, 3.0) < ball  # Hottel: some 5 % less, and falling
    assert close(glow.ray_share(3.0 * glow.mean_beam_length(thick, 3.0)), thick, 1e-14)


@pytest.mark.parametrize("x", [1e-3, 1.0, 30.0])
def test_fluence_within_a_ball_agrees_with_quadrature_and_the_rest_escapes(x):
    for place in (0.0, 0.4, 0.99, 1 - 1e-9, 1.0):
        rho = mp.mpf(place)

        def ray(mu, rho=rho):
            return -mp.expm1(-x * (rho * mu + mp.sqrt(1 - rho**2 * (1 - mu**2)))) / 2

        ends = [-1, 0, 1] if place < 0.99 else [-1, -0.01, -1e-4, 0, 1e-4, 0.01, 1]
        with mp.workdps(30):
            assert close(glow.ball_fluence_share(x, place), float(mp.quad(ray, ends)), 1e-11)
    found = glow.ball_shell_shares(x, RIMS)  # σ_a 4π L V times the mean fluence share stays
    assert close(found @ np.diff(RIMS**3), 1 - glow.ball_escape(x), 1e-8 if x < 0.1 else 1e-11)
    assert (np.diff(found) < 0).all()


def test_emission_in_equilibrium_is_absorption_times_radiance_and_the_index_squared():
    assert glow.emission(0.3, 2.0) == pytest.approx(0.6)
    assert glow.emission(0.3, 2.0, 1.5) == pytest.approx(1.35)


# ---- refusals ----

H = half_space.h_function
REFUSED = [
    *((slab, parameters, words) for parameters, words in (
        ((0.0, 0.5), "depth must be above 0"),
        ((math.nan, 0.5), "depth must be above 0"),
        ((1.0, 1.1), "albedo must be from 0 to 1"),
        ((math.inf, 1.0), "below 1 in a half space"),
        ((1.0, 0.5, (0.9,)), "must begin with 1"),
        ((1.0, 0.5, (1.0, 1.2)), "from -1 to 1"),
        ((1.0, 0.5, ISOTROPIC, 0.0), "mu0 must be above 0"),
        ((1.0, 0.5, ISOTROPIC, 1.0, 0.9), "index must be 1 or more"),
    )),
    (henyey_greenstein, (0.999,), r"between -0\.99 and"),
    (lambda: slab(0.1, 0.5, ISOTROPIC, 0.5).reflected_in([0.5, 0.2]), (), "edges must increase"),
    *((H, (0.5, albedo), "albedo must be from 0 to 1") for albedo in (-0.1, 1.1, math.nan)),
    *((lambda change=change: solved(**MILK | change), (), r"albedo in \(0, 1 - 1e-6\]") for change in (
        {"albedo": 1.0}, {"albedo": 0.0}, {"g": 0.96}, {"index": 0.9}, {"cosine": 0.0}, {"thickness": -1.0},
    )),
    *((lambda depth=depth: solved(**MILK, thickness=3.0).fluence(depth), (), r"depths must be from 0 to 3\.0")
      for depth in (-0.1, 3.1, math.nan)),
    *((lambda depth=depth: solved(**MILK, thickness=3.0).mean_fluence([0.0, depth]), (), "depths must be")
      for depth in (-0.1, 3.1, math.nan)),
]  # fmt: skip


@pytest.mark.parametrize(("function", "parameters", "words"), REFUSED)
def test_impossible_media_are_refused(function, parameters, words):
    with pytest.raises(ValueError, match=words):
        function(*parameters)
