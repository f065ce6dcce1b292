"""Half spaces: H functions, Milne's problem and thick slabs against references, mpmath, and discrete
ordinates.

A comment such as `E.H_function` names the entry of the project's reference collection that a number comes
from.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from numpy.polynomial import legendre

from transport.theory import fresnel, half_space, ordinates

EDGES = np.linspace(0, 1, 31)


def close(value, exact, relative=1e-12, absolute=0.0):
    return np.allclose(value, np.array(exact, dtype=float), rtol=relative, atol=absolute)


def test_h_functions_agree_with_references():
    mu = np.array([0, 0.01, 0.1, 0.3, 0.5, 0.7, 1])  # E.H_function
    grey = [
        1.0, 1.0266037646743182, 1.172143053516453, 1.3913503206325721, 1.5560338020213627, 1.6893476003306453,
        1.8500985167698123,
    ]  # fmt: skip
    white = [
        1.0, 1.0336742337530118, 1.2404247728560973, 1.6156710550408053, 1.9586874743593254, 2.285750378701103,
        2.7560725072687355,
    ]  # fmt: skip
    assert close(half_space.h_function(mu, 0.9), grey)
    assert close(half_space.h_function(mu, 0.999), white)


@pytest.mark.parametrize(
    ("mu", "albedo"), [(1e-6, 0.9), (0.4, 1.0), (1.0, 1.0), (0.7, 1 - 1e-9), (1.0, 0.01)]
)
def test_h_agrees_with_mpmath(mu, albedo):
    with mp.workdps(80):
        m, a = mp.mpf(mu), mp.mpf(albedo)

        def integrand(t):
            return mp.log(1 - a * mp.atan(t) / t) / (1 + m * m * t * t)

        cuts = [
            *(mp.mpf(10) ** power for power in (-20, -12, -9, -6, -4, -2, 0, 1, 2, 4, 6, 8)),
            mp.inf,
        ]  # below, 1e-18
        assert close(half_space.h_function(mu, albedo), float(mp.exp(-m / mp.pi * mp.quad(integrand, cuts))))


@pytest.mark.parametrize("albedo", [0.0, 0.3, 0.9, 1.0])
def test_h_solves_chandrasekhar_s_equation(albedo):
    nodes, weights = half_space.HEMISPHERE
    h = half_space.h_function(nodes, albedo)
    for mu in (0.01, 0.5, 1.0):
        value = half_space.h_function(mu, albedo)
        assert close(value, 1 + albedo / 2 * mu * value * (weights @ (h / (mu + nodes))))
    assert close(half_space.h_moment(0, albedo), 2 / (1 + math.sqrt(1 - albedo)))


def test_albedos_agree_with_references():
    for albedo, exact in {  # E.semi_infinite_albedo
        0.5: [0.1152258777072045, 0.16014443343523477, 0.24172077643602807, 0.14654438069971842],
        0.99: [0.7527207171602972, 0.8151398983552154, 0.8775124709582844, 0.7945636529020276],
    }.items():
        assert close(half_space.plane_albedo(np.array([1, 0.5, 0.1]), albedo), exact[:3])
        assert close(half_space.spherical_albedo(albedo), exact[3])


@pytest.mark.parametrize("albedo", [0.1, 0.9, 0.999])
@pytest.mark.parametrize("mu0", [1.0, 0.05, None])
def test_discrete_ordinates_obey_the_law_of_darkening(albedo, mu0):
    light = ordinates.half_space(albedo, mu0=mu0)
    whole = half_space.spherical_albedo(albedo) if mu0 is None else half_space.plane_albedo(mu0, albedo)
    assert close(light.reflected, whole, 1e-10)
    assert light.transmitted < 1e-15
    assert close(light.reflected_in(EDGES), half_space.darkening_in(EDGES, mu0, albedo), 1e-9)
    mu = np.array([0.02, 0.4, 1.0])
    assert close(light.reflected_radiance(mu), half_space.darkening(mu, mu0, albedo), 1e-8)
    assert close(half_space.darkening_in(EDGES, mu0, albedo).sum(), whole)
    assert not close(light.reflected_in(EDGES), np.diff(EDGES**2) * whole, 1e-2)  # Lambert's law


def test_milne_s_problem_agrees_with_references():
    mu = np.array([0, 0.1, 0.3, 0.5, 0.7, 0.9, 1])  # E.milne_emergent
    exact = [
        0.13783222385544802, 0.17192508541608523, 0.22639249644386067, 0.2774257739977447, 0.3272102415720116,
        0.3763629702806441, 0.40078999177319113,
    ]  # fmt: skip
    assert close(half_space.milne_radiance(mu), exact)
    assert close(half_space.milne_in(EDGES).sum(), 1.0)  # E.milne_flux_check


def test_hopf_s_constant_agrees_with_its_integral():
    assert close(half_space.hopf_constant(), 0.7104460895987631)  # E.hopf_constant
    with mp.workdps(25):
        rest = mp.quad(lambda x: 3 / x**2 - 1 / (1 - x * mp.cot(x)), [1e-4, 0.1, 1, mp.pi / 2])
        rest += mp.mpf("1e-4") / 5  # of its series, 1/5 + O(x^2) at 0
    assert close(half_space.hopf_constant(), float(6 / mp.pi**2 + rest / mp.pi), 1e-11)


def test_thick_slabs_obey_the_law_and_thin_ones_do_not():
    for depth, exact in {10: 0.11674511171391949, 50: 0.02592979773059389, 200: 0.006619637709414444}.items():
        assert close(half_space.thick_slab(depth), exact)  # E.conservative_thick_slab
        light = ordinates.slab(float(depth), 1.0, mu0=None)
        assert close(light.transmitted, half_space.thick_slab(depth), max(1e-10, math.exp(-depth)))
        assert close(half_space.measured_extrapolation(light.transmitted, depth), 0.7104460895987631, 2e-7)
        for mu0 in (1.0, 0.1):
            beam = ordinates.slab(float(depth), 1.0, mu0=mu0).transmitted
            assert close(beam, half_space.thick_slab_beam(depth, mu0), max(1e-10, 10 * math.exp(-depth)))
    assert not close(ordinates.slab(1.0, 1.0, mu0=None).transmitted, half_space.thick_slab(1.0), 1e-4)
    assert close(ordinates.slab(1e4, 1.0, mu0=None).transmitted, half_space.thick_slab(1e4), 3e-8)


@pytest.mark.parametrize("g", [-0.5, 0.5, 0.9])
def test_thick_slabs_of_any_phase_function_obey_it_with_their_own_q(g):
    moments = ordinates.henyey_greenstein(g)
    depth = 100 / (1 - g)
    assert close(
        ordinates.slab(depth, 1.0, moments, None).transmitted, half_space.thick_slab(depth, moments), 1e-9
    )
    assert 0.7104 < half_space.extrapolation(moments) < 0.7151


def test_fresnel_s_boundary_agrees_with_references():
    for (index, albedo), (diffuse, lambertian) in {  # E.giovanelli
        (1.5, 0.9): (0.2199185699177473, 0.3078900405765885),
        (1.5, 0.99): (0.5619807856719933, 0.6319609387949664),
        (1.33, 0.99): (0.63289859711793, 0.6822246875503498),
        (1.4, 0.999): (0.8301157019580623, 0.8702490264590612),
    }.items():
        light = ordinates.half_space(albedo, index=index)
        assert close(light.unscattered_back, ((index - 1) / (index + 1)) ** 2, 1e-14)
        assert close(light.reflected_diffuse, diffuse, 1e-9)
        assert close(ordinates.half_space(albedo, mu0=None, index=index).reflected, lambertian, 1e-9)


@pytest.mark.parametrize("mu0", [1.0, 0.2])
@pytest.mark.parametrize(("index", "albedo"), [(1.5, 0.9), (1.2, 0.99), (2.4, 0.5)])
def test_fresnel_s_boundary_agrees_with_the_h_function(index, albedo, mu0):
    """Light within follows from the law of darkening, reflection after reflection; the nodes are others."""
    x, w = legendre.leggauss(60)
    x, w = (x + 1) / 2, w / 2
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


def test_impossible_albedos_are_refused():
    for albedo in (-0.1, 1.1, math.nan):
        with pytest.raises(ValueError, match="albedo must be from 0 to 1"):
            half_space.h_function(0.5, albedo)
