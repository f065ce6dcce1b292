"""The exact half space and slab behind Fresnel boundaries agree with references, and with themselves; diffusion nearly.

A comment such as `E.slab_HG` names the entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from transport.theory import ordinates, turbid
from transport.theory.turbid import Diffusion, boundary_factor, solved

MILK = {"albedo": 1000 / 1001, "g": 0.9, "index": 1.37}


def close(value, exact, relative):
    return np.allclose(value, exact, rtol=relative, atol=0)


# E.slab_HG, E.vandehulst_hg: optical thickness, albedo, g, cosine; R, T with what is unscattered
SLABS = [
    (0.1, 0.5, 0.9, 0.5, 0.0043891478189455515, 0.8989421691322985),
    (2.0, 0.9, 0.9, 1.0, 0.03221529690693779, 0.7595763410251009),
    (10.0, 0.99, 0.9, 1.0, 0.24762764934429707, 0.5890815105839808),
    (10.0, 0.99, 0.9, 0.5, 0.4364014292590745, 0.3825327433261788),
    (10.0, 0.99, 0.75, 0.1, 0.7717960062606302, 0.12380436500095036),
    (2.0, 0.9, 0.75, 1.0, 0.0973946386719247, 0.6609577001638116),
    (2.0, 0.9, -0.5, 0.1, 0.6528806886527894, 0.08113610764574092),
    (10.0, 0.99, -0.5, 0.5, 0.8426138403458997, 0.03235635976978046),
    (2.0, 0.9, 0.0, 0.5, 0.4739410915196685, 0.2172358881219712),
]


@pytest.mark.parametrize(("thickness", "albedo", "g", "cosine", "reflected", "transmitted"), SLABS)
def test_slabs_without_a_boundary_meet_references(thickness, albedo, g, cosine, reflected, transmitted):
    slab = solved(albedo, g, 1.0, cosine, thickness)
    assert close([slab.reflectance, slab.transmittance], [reflected, transmitted], 2e-10)
    assert slab.specular == 0


@pytest.mark.parametrize(  # E.giovanelli
    ("index", "albedo", "total"),
    [
        (1.5, 0.9, 0.2599185699177473),
        (1.5, 0.99, 0.6019807856719933),
        (1.33, 0.99, 0.6529579093174547),
        (1.4, 0.999, 0.8578934797358401),
    ],
)
def test_half_spaces_behind_a_boundary_meet_references(index, albedo, total):
    half_space = solved(albedo, 0.0, index)
    assert close(half_space.reflectance + half_space.specular, total, 1e-9)
    assert half_space.transmittance == 0


def test_half_spaces_without_a_boundary_meet_chandrasekhar_s_h():
    for albedo, exact in {
        0.5: 0.1152258777072045,
        0.99: 0.7527207171602972,
    }.items():  # E.semi_infinite_albedo
        assert close(solved(albedo, 0.0).reflectance, exact, 1e-9)


def test_the_slowest_mode_is_that_of_infinite_media():
    """c atanh(κ) = κ of isotropic scattering (F.diffusion_length)."""
    for albedo, rate in {0.7: 0.8286347986408346, 0.9: 0.5254295126580086, 0.95: 0.37948520667809}.items():
        assert close(solved(albedo, 0.0).slowest_rate, rate, 1e-12)


CASES = [
    MILK,
    MILK | {"cosine": 0.3},
    MILK | {"thickness": 20.0},
    {"albedo": 0.99, "g": 0.9, "index": 1.5, "cosine": 0.7, "thickness": 0.5},
    {"albedo": 0.9, "g": -0.7, "index": 1.1, "thickness": 3.0},
    {"albedo": 1 - 1e-6, "g": 0.8, "index": 1.33},
]


@pytest.mark.parametrize("case", CASES)
def test_what_comes_in_goes_out_or_is_absorbed(case):
    """The absorbed is told by the fluence, the rest by the radiance at the boundaries."""
    medium = solved(**case)
    whole = medium.specular + medium.reflectance + medium.transmittance + medium.absorbed
    assert whole == pytest.approx(1, rel=1e-10)


@pytest.mark.parametrize("case", CASES)
def test_more_nodes_change_nothing(case, monkeypatch):
    depths, medium = np.array([0.0, 0.1, 0.5]), solved(**case)
    monkeypatch.setattr(turbid, "NODES", 128)
    finer = solved.__wrapped__(**case)
    assert len(finer.rates) > len(medium.rates)
    assert close([medium.reflectance, medium.absorbed], [finer.reflectance, finer.absorbed], 1e-9)
    assert close(medium.fluence(depths), finer.fluence(depths), 1e-9)
    monkeypatch.setattr(turbid, "NODES", 24)  # too few are seen
    rough = solved.__wrapped__(**case)
    assert abs(case["g"]) < 0.85 or not close(rough.reflectance, finer.reflectance, 1e-6)


def test_doubling_says_the_same():
    """The library's other solver: other nodes, other phase matrices, depth by doubling.  Of milk as well, in 5 s."""
    modes = solved(0.99, 0.6, 1.5, thickness=2.0)
    doubled = ordinates.slab(2.0, 0.99, ordinates.henyey_greenstein(0.6), index=1.5)
    assert close(modes.reflectance + modes.specular, doubled.reflected, 1e-11)
    assert close(modes.transmittance, doubled.transmitted, 1e-11)


def test_a_way_is_as_likely_as_its_reverse():
    """Radiance at one cosine over irradiance at another is the same the other way round (Helmholtz 1867)."""
    for thickness in (1.0, math.inf):
        for one, other in ((1.0, 0.3), (0.9, 0.05)):
            there, back = (solved(0.99, 0.9, 1.37, mu, thickness) for mu in (one, other))
            assert close(there.radiance(other), back.radiance(one), 1e-7)
            assert not close(there.radiance(other), there.radiance(one), 0.01)


def test_bins_add_up_to_the_whole():
    milk = solved(**MILK)
    edges = np.array([0, 0.1, 0.35, 1.0])
    assert milk.leaving(edges).sum() == pytest.approx(milk.reflectance, rel=1e-12)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    for low, high, share in zip(edges[:-1], edges[1:], milk.leaving(edges), strict=True):
        mu = (low + high) / 2 + (high - low) / 2 * nodes
        assert close((high - low) * math.pi * (milk.radiance(mu) * mu) @ weights, share, 1e-10)


@pytest.mark.parametrize("case", CASES)
def test_means_over_cells_are_means_of_the_fluence(case):
    medium, edges = solved(**case), np.array([0.0, 1e-3, 0.1, 0.4])
    nodes, weights = np.polynomial.legendre.leggauss(30)
    places = (edges[1:] + edges[:-1])[:, None] / 2 + np.diff(edges)[:, None] / 2 * nodes
    assert close(
        medium.mean_fluence(edges), medium.fluence(places) @ weights / 2, 1e-5
    )  # Gauss's error at the top
    assert close(medium.mean_fluence(edges)[1:], medium.fluence(places[1:]) @ weights / 2, 1e-9)


def test_a_thick_slab_is_a_half_space():
    slab, half_space = solved(**MILK, thickness=2000.0), solved(**MILK)
    depths = np.array([0.0, 1.0, 50.0])
    assert close(slab.reflectance, half_space.reflectance, 1e-12)
    assert close(slab.fluence(depths), half_space.fluence(depths), 1e-12)
    assert slab.transmittance < 1e-12


def test_a_clear_plate_lets_through_what_stokes_says():
    """With hardly any scattering: (1 - R)/(1 + R) of a plate that takes nothing, less where it absorbs."""
    plate = solved(1e-12, 0.0, 1.5, thickness=1e-9)
    assert close(plate.transmittance, 0.96 / 1.04, 1e-8)
    dark = solved(1e-12, 0.0, 1.5, thickness=0.7)
    passed = math.exp(-0.7)
    assert close(dark.transmittance, 0.96**2 * passed / (1 - (0.04 * passed) ** 2), 1e-9)
    assert close(
        dark.fluence(0.2), 0.96 * (math.exp(-0.2) + 0.04 * math.exp(-1.2)) / (1 - 0.0016 * passed**2), 1e-9
    )


def test_a_boundary_forgotten_shows():
    """Planted: no internal reflection, no specular share, isotropic scattering of σ_s for that of σ_s (1 - g)."""
    milk = solved(**MILK)
    wrong = [
        (1 - milk.specular) * solved(MILK["albedo"], 0.9).reflectance,
        milk.reflectance + milk.specular,
        solved(MILK["albedo"], 0.0, 1.37).reflectance,
    ]
    assert close(milk.reflectance, 0.61643411023, 1e-10)
    for value in wrong:
        assert not close(value, milk.reflectance, 0.03)


def test_diffusion_is_near_where_scattering_is_strong():
    for case, far in ((MILK, 0.02), (MILK | {"albedo": 1 - 1e-5}, 1e-3)):
        exact, near = solved(**case), Diffusion(**case)
        assert close(near.reflectance, exact.reflectance, far)
        assert close(near.rate, exact.slowest_rate, 3e-3)
        assert close(near.fluence(100.0), exact.fluence(100.0), 0.02)
        assert not close(near.fluence(1.0), exact.fluence(1.0), 0.1)  # near the boundary it is 15 % too low


def test_diffusion_keeps_its_own_balance():
    milk = Diffusion(**MILK)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    depths = 1000 * (nodes + 1)
    absorbed = (1 - milk.albedo) * 1000 * milk.fluence(depths) @ weights
    assert absorbed + milk.reflectance == pytest.approx(1 - solved(**MILK).specular, rel=1e-9)
    assert boundary_factor(1.0) == 1
    assert boundary_factor(1.4) == pytest.approx(2.945, abs=0.005)  # Haskell 1994: R_eff 0.493


def test_what_cannot_be_solved_is_refused():
    wrong = [
        {"albedo": 1.0},
        {"albedo": 0.0},
        {"g": 0.96},
        {"index": 0.9},
        {"cosine": 0.0},
        {"thickness": -1.0},
    ]
    for change in wrong:
        with pytest.raises(ValueError, match=r"albedo in \(0, 1 - 1e-6\]"):
            solved(**MILK | change)
    for depth in (-0.1, 3.1, math.nan):
        with pytest.raises(ValueError, match=r"depths must be from 0 to 3\.0"):
            solved(**MILK, thickness=3.0).fluence(depth)
        with pytest.raises(ValueError, match="depths must be"):
            solved(**MILK, thickness=3.0).mean_fluence([0.0, depth])
