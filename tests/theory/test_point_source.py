"""A point source in an infinite medium, and random flights: against references, Fourier inversion and conservation.

A comment such as `F.azurv1` names the entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

from transport.theory import point_source as source
from transport.theory import random_flights as flights

ALBEDOS = (1e-3, 0.1, 0.5, 0.9, 0.99, 1 - 1e-9)


def close(value, exact, relative=1e-13):
    np.testing.assert_allclose(value, exact, rtol=relative, atol=0)


# The infinite medium


def test_the_diffusion_length():
    for albedo, kappa in {  # F.diffusion_length
        0.01: 1.0,
        0.1: 0.9999999958776924,
        0.5: 0.9575040240772688,
        0.7: 0.8286347986408346,
        0.9: 0.5254295126580086,
        0.95: 0.37948520667809,
    }.items():
        close(source.relaxation(albedo)[0], kappa)
    # kappa = sqrt(3 (1 - c)) (1 - 2 (1 - c)/5 ...) and B -> 3: diffusion
    kappa, factor = source.relaxation(1 - 1e-8)
    close(kappa, math.sqrt(3e-8) * (1 - 0.4e-8), 1e-8)
    close(factor, 3.0, 1e-7)
    assert source.relaxation(1.0) == (0.0, 3.0)


@pytest.mark.parametrize("albedo", [0.0, -0.5, 1.5, math.nan])
def test_an_albedo_beyond_its_range_is_refused(albedo):
    with pytest.raises(ValueError, match="albedo must be above 0 and at most 1"):
        source.relaxation(albedo)


def test_the_fluence_rate_and_its_asymptotic_part():
    for (albedo, distance), (fluence, asymptotic) in {  # F.point_source_flux
        (0.1, 0.1): (7.3513496850872695, 1.1873017369083319e-06),
        (0.1, 0.5): (0.20832320717143252, 1.591744312509839e-07),
        (0.1, 5): (2.8352993317978075e-05, 1.7682682385459227e-10),
        (0.1, 10): (5.1923353968678384e-08, 5.957248958532384e-13),
        (0.5, 2): (0.00792762373575656, 0.004290739398054291),
        (0.9, 0.1): (8.918976939228646, 1.9044944685650196),
        (0.9, 0.5): (0.4828326918728755, 0.30869760218400843),
        (0.9, 1): (0.14328386152545275, 0.1186882404405644),
        (0.9, 10): (0.00010489717389854546, 0.00010487873722471757),
        (0.99, 0.1): (9.208049301312002, 2.3089657764346025),
        (0.99, 0.5): (0.5953856049167265, 0.4310019640301582),
        (0.99, 2): (0.08497689463712017, 0.08318372210634924),
    }.items():
        close(source.fluence_rate(distance, 1.0, albedo), fluence)
        close(source.asymptotic(distance, albedo), asymptotic, 1e-12)
        # in metres: twice the extinction at half the distance, four times the fluence rate
        close(source.fluence_rate(distance / 2, 2.0, albedo), 4 * fluence)


@pytest.mark.slow
@pytest.mark.parametrize(("albedo", "distance"), [(0.3, 1.7), (0.8, 0.2), (1.0, 3.0)])
def test_collided_light_is_the_inverse_fourier_transform(albedo, distance):
    """φ = (1/2π²r) ∫ k sin(kr) c A²/(1 - cA) dk, by a sum over half waves."""
    with mp.workdps(20):
        c, r = mp.mpf(albedo), mp.mpf(distance)

        def wave(k):
            a = mp.atan(k) / k
            return k * mp.sin(k * r) * c * a * a / (1 - c * a)

        exact = mp.quadosc(wave, [0, mp.inf], omega=r) / (2 * mp.pi**2 * r)
    close(source.collided(distance, albedo), float(exact), 1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("albedo", ALBEDOS)
def test_all_power_is_absorbed_and_its_mean_square_distance_is_known(albedo):
    """∫ φ dV = 1/(1 - c), ∫ r² φ dV = 2/(1 - c)² (F.point_source_moments)."""
    reach = 40 / source.relaxation(albedo)[0]
    edges = np.concatenate([[0.0], np.geomspace(1e-6, 1, 30) * reach])
    shells = source.shell_means(edges, 1.0, albedo) * np.diff(edges**3) * 4 * math.pi / 3
    close((1 - albedo) * shells.sum(), 1.0, 1e-12)
    x, w = np.polynomial.legendre.leggauss(24)
    r = edges[1:-1, None] + np.diff(edges[1:])[:, None] * (1 + x) / 2
    weights = np.diff(edges[1:])[:, None] / 2 * w * 4 * math.pi
    second = (weights * r**4 * source.fluence_rate(r, 1.0, albedo)).sum()
    close((1 - albedo) ** 2 * second / 2, 1.0, 1e-11)


@pytest.mark.parametrize("albedo", [0.0, *ALBEDOS, 1.0])
def test_shells_hold_the_mean_of_the_fluence_rate(albedo):
    edges = np.array([0.01, 0.02, 0.5, 0.5001, 3.0, 12.0])
    x, w = np.polynomial.legendre.leggauss(80)
    r = edges[:-1, None] * (edges[1:] / edges[:-1])[:, None] ** ((1 + x) / 2)
    weights = w * r**3
    means = (weights * source.fluence_rate(r, 1.0, albedo)).sum(axis=1) / weights.sum(axis=1)
    close(source.shell_means(edges, 1.0, albedo), means, 1e-11)
    finer = np.array([0.0, 0.1, 0.2, 0.6])
    whole = source.shell_means(finer, 1.0, albedo) @ np.diff(finer**3) / 0.6**3
    close(source.shell_means(finer[[0, -1]], 1.0, albedo)[0], whole)


@pytest.mark.parametrize("albedo", ALBEDOS)
def test_what_is_absorbed_within_and_what_flows_out_are_all(albedo):
    for radius in (1e-3, 0.7, 8.0):
        close(source.absorbed_within(radius, 2.0, albedo) + source.net_flux(radius, 2.0, albedo), 1.0)
    assert source.net_flux(8.0, 2.0, 1.0) == 1.0
    # it falls even where absorbed and emitted power agree to all digits
    assert 0 < source.net_flux(60.0, 1.0, 0.5) < 1e-20


def test_diffusion_is_right_far_out_where_almost_nothing_is_absorbed_and_wrong_elsewhere():
    close(source.diffusion(100.0, 1 - 1e-6), source.fluence_rate(100.0, 1.0, 1 - 1e-6), 1e-4)
    close(source.diffusion(50.0, 1.0), source.fluence_rate(50.0, 1.0, 1.0), 1e-9)
    assert source.diffusion(0.1, 0.9) < 0.3 * source.fluence_rate(0.1, 1.0, 0.9)
    assert source.diffusion(10.0, 0.5) < 0.3 * source.fluence_rate(10.0, 1.0, 0.5)


# Random flights


def test_mean_square_displacement_in_time():
    times = np.array([0.1, 1, 5, 100])
    for g, exact in {  # F.persistent_walk_time
        0.0: [0.009674836071919157, 0.7357588823428847, 8.013475893998171, 198.0],
        0.9: [0.009966749833610627, 0.9674836071919135, 21.306131942526687, 1800.0090799859531],
    }.items():
        close(flights.mean_square_displacement(times, g), exact)
    close(flights.mean_square_displacement(1e-9), 1e-18, 1e-9)  # straight flight at first
    close(flights.mean_square_displacement(1 - 1e-13), flights.mean_square_displacement(1 + 1e-13), 1e-12)
    # diffusion, 2 t, from the start, is another law
    assert flights.mean_square_displacement(1.0) < 0.4 * 2.0


def test_mean_square_displacement_is_the_double_integral_of_the_memory_of_directions():
    for g in (-0.5, 0.3, 0.9):
        exact = mp.quad(lambda a, g=g: 2 * (3 - a) * mp.exp(-(1 - g) * a), [0, 3])
        close(flights.mean_square_displacement(3.0, g), float(exact))
        close(flights.mean_advance(3.0, g), float(mp.quad(lambda a, g=g: mp.exp(-(1 - g) * a), [0, 3])))


def test_mean_square_displacement_after_flights():
    numbers = (1, 2, 5, 10, 100)
    for g, exact in {  # F.random_flight_msd
        0.0: (2.0, 4.0, 10.0, 20.0, 200.0),
        0.9: (2.0, 5.8, 26.288200000000003, 82.76211921800001, 1820.0047810518001),
    }.items():
        close([flights.mean_square_after(n, g) for n in numbers], exact)


def test_the_plane_pulse():
    for (time, x), exact in {  # F.azurv1
        (1, 0.2): 0.6513675149406318,
        (1, 0.5): 0.5329095407388867,
        (1, 0.8): 0.3440037423607717,
        (1, 0.95): 0.2315029599365766,
        (1, 0.999): 0.185527306528989,
        (3, 1.5): 0.1650880600058526,
        (3, 2.4): 0.049277520970366535,
        (3, 2.85): 0.016226625527387944,
        (5, 0): 0.2346089301668647,
        (5, 1): 0.1995670246852902,
        (5, 2.5): 0.0818470355829012,
        (5, 4): 0.011823266590154716,
        (5, 4.995): 0.0007032859365670254,
        (10, 0): 0.16006593235437777,
        (10, 2): 0.11699544955534694,
        (10, 5): 0.020904807077790542,
        (10, 8): 0.0005159987667108534,
        (10, 9.5): 1.8302313552987548e-05,
    }.items():
        close(flights.plane_pulse(x, time), exact)
        close(flights.plane_pulse(-x, time), exact)
    assert flights.plane_pulse(1.0001, 1.0) == 0


@pytest.mark.parametrize("time", [0.1, 1.0, 5.0, 40.0])
def test_the_plane_pulse_holds_all_particles_and_their_mean_squares(time):
    edges = np.linspace(-time, time, 41)
    close(flights.plane_pulse_shares(edges, time).sum(), 1.0, 1e-12)
    # isotropic: a third of the mean square displacement is along x
    x, w = np.polynomial.legendre.leggauss(200)
    angle = math.pi / 2 * x
    weights = math.pi / 2 * w * time * np.cos(angle) * flights.plane_pulse(time * np.sin(angle), time)
    close(weights @ (time * np.sin(angle)) ** 2, flights.mean_square_displacement(time) / 3, 1e-11)
    fourth = {1.0: 0.12573807058287179, 5.0: 19.156134780769758}  # F.azurv1_moments
    if time in fourth:
        close(weights @ (time * np.sin(angle)) ** 4, fourth[time], 1e-11)


def test_absorption_thins_the_plane_pulse_out():
    """With the albedo c what has scattered n times is c^n of it: all that is left is exp(-(1 - c) t)."""
    edges = np.linspace(-3, 3, 21)
    close(flights.plane_pulse_shares(edges, 3.0, 0.7).sum(), math.exp(-0.9), 1e-12)
    close(flights.plane_pulse(0.5, 3.0, 1e-12), math.exp(-3) / 6, 1e-9)
