"""Snell, Fresnel and the n^2 law against references and mpmath, at grazing, critical and Brewster's angle too.

A comment such as `G.n2_law` names the entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

from transport.theory import fresnel
from transport.theory.fresnel import reflectance, reflectances, snell_cosine, transmittance

RATIOS = [1.5, 1 / 1.5, 2.4, 1 / 2.4, 1 + 1e-12, 1 - 1e-12, 1 + 2**-52, 1 - 2**-53, 0.9999, 0.3, 1e-3, 1e3]


@pytest.fixture(autouse=True)
def sixty_digits():
    with mp.workdps(60):
        yield


def cosines(ratio):
    """From grazing to the normal, and where there is a critical angle, on both sides of it down to the rounding."""
    places = [*np.geomspace(1e-300, 1, 60), *np.linspace(0.01, 1, 50)]
    if ratio < 1:
        critical = math.sqrt((1 - ratio) * (1 + ratio))
        places += [critical * (1 + step) for step in (*np.geomspace(1e-15, 1e-3, 25), -1e-9, -1e-15)]
    return np.minimum(places, 1.0)


def textbook(cosine, ratio):
    """R and T of s, then of p, as in Born and Wolf (1999), 1.5.2, of the doubles as they are."""
    c, n = mp.mpf(float(cosine)), mp.mpf(float(ratio))
    q2 = n * n - 1 + c * c
    if q2 < 0:
        return 1, 0, 1, 0
    q = mp.sqrt(q2)
    r_s, r_p = (c - q) / (c + q), (n * n * c - q) / (n * n * c + q)
    return r_s**2, 4 * c * q / (c + q) ** 2, r_p**2, 4 * n * n * c * q / (n * n * c + q) ** 2


@pytest.mark.parametrize("ratio", RATIOS)
def test_fresnel_is_exact_to_rounding_at_every_angle(ratio):
    """R_p in its amplitude, which vanishes at Brewster's angle; T a rounding from the critical angle to 1e-12."""
    places = cosines(ratio)
    back, passed = reflectances(places, ratio), fresnel.transmittances(places, ratio)
    for k, c in enumerate(places):
        r_s, t_s, r_p, t_p = textbook(c, ratio)
        assert abs(back.s[k] - r_s) <= 2e-15 * r_s
        assert abs(back.p[k] - r_p) <= 2e-15 * (mp.sqrt(r_p) + mp.mpf(2) ** -1000)
        near = abs(c * c + ratio * ratio - 1) < 1e-6 * c * c
        for value, exact in ((passed.s[k], t_s), (passed.p[k], t_p)):
            assert abs(value - exact) <= (1e-12 if near else 2e-15) * exact
    assert np.abs(reflectance(places, ratio) + transmittance(places, ratio) - 1).max() <= 4 * 2**-52


def test_forms_that_cancel_are_seen():
    """Planted: Fresnel's formulas as they are printed, for an index that is hardly another one."""
    c, n = 0.3, 1 + 1e-12
    q = math.sqrt(n * n - 1 + c * c)
    exact = textbook(c, n)[0]
    assert abs(((c - q) / (c + q)) ** 2 - exact) > 1e-6 * exact
    assert abs(reflectances(c, n).s - exact) < 2e-15 * exact


@pytest.mark.parametrize(
    ("index", "degrees", "exact"),
    [  # G.fresnel_external: R_s, R_p, R
        (1.33, 45, (0.05230676903471831, 0.0027359980868513663, 0.02752138356078484)),
        (1.33, 89.9, (0.9920699810972886, 0.9860153420161752, 0.9890426615567319)),
        (1.5, 0, (0.04, 0.04, 0.04)),
        (1.5, 60, (0.17657148808284054, 0.0018019375215850362, 0.08918671280221278)),
        (1.5, 89.999, (0.9999375591519071, 0.9998595135744872, 0.9998985363631971)),
        (2.4, 85, (0.8523580384417606, 0.39203579077383677, 0.6221969146077987)),
        # G.fresnel_internal
        (1 / 1.33, 20, (0.028171390119779652, 0.013275262466885044, 0.020723326293332348)),
        (1 / 1.5, 40.810314895778596, (0.4953919664317571, 0.19159855800067785, 0.34349526221621746)),
        (1 / 1.5, 60, (1.0, 1.0, 1.0)),
        (1 / 2.4, 24.624318352164078 - 0.001, (0.9841277722329086, 0.911947211273654, 0.9480374917532813)),
    ],
)
def test_reflectance_into_and_out_of_glass(index, degrees, exact):
    c = math.cos(math.radians(degrees))
    assert (*reflectances(c, index), reflectance(c, index)) == pytest.approx(exact, rel=1e-11)


def test_both_sides_of_a_boundary_reflect_alike():
    """Stokes (1849): R at an angle is R at the angle of refraction from the other side."""
    c = np.linspace(0.01, 1, 40)
    there, back = reflectances(c, 1.5), reflectances(snell_cosine(c, 1.5), 1 / 1.5)
    known = 8 * 2**-53 / c**2  # as well as a rounded cosine knows how far from the critical angle it is
    assert (np.abs(there.s - back.s) <= known).all() and (np.abs(there.p - back.p) <= known).all()


def test_snell_keeps_the_sine_times_the_index():
    c = np.linspace(0, 1, 30)
    assert 1.33**2 * (1 - snell_cosine(c, 1.33) ** 2) == pytest.approx(1 - c**2, abs=1e-15)
    assert math.isnan(snell_cosine(0.1, 1 / 1.33))
    assert snell_cosine(1.0, 1 / 1.33) == 1.0


def test_brewster_and_critical_angles():
    degrees = np.degrees(fresnel.brewster_angle([1.33, 1.5, 1 / 1.33, 1 / 2.4]))
    external, internal = [53.06123726771017, 56.309932474020215], [36.93876273228983, 22.61986494804043]
    assert degrees == pytest.approx(external + internal, rel=1e-14)  # G.brewster_critical, G.fresnel_internal
    degrees = np.degrees(fresnel.critical_angle([1 / 1.33, 1 / 1.5, 1 / 2.4, 1.5]))
    exact = [48.753466631327235, 41.810314895778596, 24.624318352164078, 90]
    assert degrees == pytest.approx(exact, rel=1e-14)
    for ratio in (1.33, 1 / 1.33):
        assert reflectances(np.cos(fresnel.brewster_angle(ratio)), ratio).p < 1e-31
    edge = math.cos(fresnel.critical_angle(1 / 1.5))
    assert reflectance(edge * (1 - 1e-12), 1 / 1.5) == 1 > reflectance(edge * (1 + 1e-12), 1 / 1.5)


def test_a_plate_transmits_the_sum_of_all_its_inner_reflections():
    c = np.array([0.05, 0.3, 1.0])
    s, p = reflectances(c, 1.5)
    for share in (reflectance(c, 1.5), s, p):
        summed = sum((1 - share) ** 2 * share ** (2 * k) for k in range(2000))
        assert summed == pytest.approx((1 - share) / (1 + share), rel=1e-12)
    assert fresnel.plate_transmittance(1.0, 1.5) == pytest.approx(0.96 / 1.04, rel=1e-15)
    kept, mixed = ((1 - s) / (1 + s) + (1 - p) / (1 + p)) / 2, fresnel.plate_transmittance(c, 1.5)
    assert fresnel.plate_transmittance(c, 1.5, keeps_polarisation=True) == pytest.approx(kept, rel=1e-14)
    assert (kept - mixed)[:2].min() > 0.002 and kept[2] == pytest.approx(mixed[2])  # differ off the normal
    assert (np.abs(transmittance(c, 1.5) - mixed) > 0.01).all()  # of one face


def walsh(index):
    """Walsh (1926), Duntley (1942): R of diffuse light from the thinner side."""
    n = mp.mpf(float(index))
    logs = n**2 * (n**2 - 1) ** 2 / (n**2 + 1) ** 3 * mp.log((n - 1) / (n + 1))
    logs += 8 * n**4 * (n**4 + 1) / ((n**2 + 1) * (n**4 - 1) ** 2) * mp.log(n)
    rest = mp.mpf(1) / 2 + (n - 1) * (3 * n + 1) / (6 * (n + 1) ** 2)
    return rest + logs - 2 * n**3 * (n**2 + 2 * n - 1) / ((n**2 + 1) * (n**4 - 1))


def test_diffuse_light_is_reflected_as_by_walsh_and_duntley():
    for index in (1 + 2**-52, 1 + 1e-9, 1.01, 1.333333333, 1.5, 2.4, 100.0, 1e8):
        exact = walsh(index)
        assert abs(fresnel.diffuse_reflectance(index) - exact) <= 2e-15 * exact, index
    indices = np.array([1.3333333333, 1.5, 2.4])  # G.fresnel_diffuse
    external = [0.06645848037639657, 0.09177795934235121, 0.21018130201044674]
    internal = [0.4748828951854672, 0.5963457597077116, 0.8628786982657025]
    assert fresnel.diffuse_reflectance(indices) == pytest.approx(external, rel=1e-13)
    assert fresnel.diffuse_reflectance(1 / indices) == pytest.approx(internal, rel=1e-13)
    # without the critical angle less would be reflected inside, without the 1/n^2 more
    assert fresnel.diffuse_reflectance(1 / 1.5) > 4 * fresnel.diffuse_reflectance(1.5)


@pytest.mark.parametrize("ratio", [1.5, 1 / 1.5])
def test_diffuse_reflectance_is_the_mean_over_angles(ratio):
    nodes, weights = np.polynomial.legendre.leggauss(60)
    x, weights = (nodes + 1) / 2, weights / 2
    edge = math.cos(fresnel.critical_angle(ratio))
    c = edge + (1 - edge) * x * x  # R rises as a root towards the critical angle
    mean = (2 * c * reflectance(c, ratio) * 2 * x * (1 - edge)) @ weights + edge**2
    assert fresnel.diffuse_reflectance(ratio) == pytest.approx(mean, rel=1e-9)


def test_radiance_over_the_square_of_the_index_is_kept():
    indices = np.array([1.33, 1.5])  # G.n2_law
    exact = 2 * np.array([1.7689, 2.25]) * (1 - ((indices - 1) / (indices + 1)) ** 2)
    assert fresnel.refracted_radiance(2.0, 1.0, indices) == pytest.approx(exact)
    there = fresnel.refracted_radiance(1.0, 0.6, 1.5)
    again = fresnel.refracted_radiance(there, snell_cosine(0.6, 1.5), 1 / 1.5)
    assert again == pytest.approx(transmittance(0.6, 1.5) ** 2, rel=1e-14)
    # a lost n^2 would be seen: equilibrium is T_out n^2 = T_in over the escape cone
    shares, cones = fresnel.escape_share(1 / indices), fresnel.escape_cone_share(1 / indices)
    assert shares == pytest.approx([0.5280508512073009, 0.40365424029228836], rel=1e-13)
    assert cones == pytest.approx([0.34069967552066516, 0.2546440075000701], rel=1e-14)
