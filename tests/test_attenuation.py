"""Attenuation along rays and over directions: the closed forms against references, quadrature and one another.

A comment such as `F.slab_escape_probability` names the entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

from transport.theory import attenuation as fog
from transport.theory import emitters, view_factors


def close(value, exact, relative=1e-13):
    np.testing.assert_allclose(value, exact, rtol=relative, atol=0)


def slanted(tau, low, high):
    """∫ mu exp(-tau/mu) dmu by 30 digits."""
    with mp.workdps(30):
        return float(mp.quad(lambda mu: mu * mp.exp(-mp.mpf(tau) / mu), mp.linspace(low, high, 5)))


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_exponential_integrals_have_their_30_digits(order):
    for tau in (1e-9, 0.5, 3.0, 40.0):
        close(fog.exponential_integral(order, tau), float(mp.expint(order, tau)))
    tau = 0.7  # (n - 1) E_n = exp(-tau) - tau E_{n-1}
    rising = fog.exponential_integral(order + 1, tau)
    close(order * rising, math.exp(-tau) - tau * fog.exponential_integral(order, tau))


def test_what_leaves_a_glowing_slab_and_gets_through_it():
    for tau, (leaves, through) in {  # F.slab_escape_probability
        0.1: (0.8370854209172118, 0.8325829158165576),
        1: (0.3903080328022398, 0.2193839343955204),
        5: (0.09982443982144587, 0.0017556017855412775),
    }.items():
        close(fog.slab_escape(tau), leaves)
        close(fog.lambertian_transmission(tau), through)
        close(2 * tau * fog.slab_escape(tau), 1 - through)  # what a slab absorbs it would emit
    thin = 1e-9 * (1.5 - float(mp.euler) - math.log(1e-9)) / 2  # is kept back
    close(1 - fog.slab_escape(1e-9), thin, 1e-6)
    # straight ahead, all of it, is another law
    assert fog.lambertian_transmission(1.0) < 0.6 * fog.transmittance(1.0)


def test_what_leaves_a_glowing_ball():
    for radii, leaves in {  # F.sphere_escape_probability
        0.01: 0.9925398339030994,
        1: 0.5272521936411892,
        5: 0.14700149819768216,
    }.items():
        close(fog.sphere_escape(radii), leaves)
        # what a black ball of fog absorbs of diffuse light is what it would emit
        close(4 / 3 * radii * fog.sphere_escape(radii), 1 - fog.ball_transmittance(2 * radii), 1e-12)
    close(fog.sphere_escape(1 - 1e-12), fog.sphere_escape(1 + 1e-12), 1e-11)
    close(1 - fog.sphere_escape(1e-9), 0.75e-9, 1e-6)


@pytest.mark.parametrize("tau", [0.0, 1e-6, 0.5, 5.0])
@pytest.mark.parametrize(
    "cosines", [(0.0, 1.0), (0.0, 0.3), (0.1, 0.3), (0.2, 0.3), (0.999, 1.0), (0.1, 0.2001)]
)
def test_bins_of_radiance_hold_the_mean_over_their_directions(tau, cosines):
    low, high = cosines
    exact = slanted(tau, low, high)
    close(fog.slant_integral(tau, low, high), exact)
    close(fog.mean_slant_transmittance(tau, low, high), 2 * exact / (high**2 - low**2), 1e-12)


def test_bins_add_up_to_the_exponential_integral():
    edges = np.linspace(0, 1, 8)
    close(fog.slant_integral(0.8, edges[:-1], edges[1:]).sum(), fog.exponential_integral(3, 0.8))
    close(fog.slant_integral(0.8, 0.0, 1.0), float(mp.expint(3, 0.8)))


def test_irradiance_of_a_disk_through_fog():
    radiance, radius, distance = 100.0, 0.5, 0.1
    close(
        fog.disk_irradiance(radiance, radius, distance, 0.0),
        emitters.disk_irradiance(radiance, radius, distance),
    )
    for tau in (0.2, 2.0):
        rim = mp.mpf(distance) / mp.sqrt(mp.mpf(distance) ** 2 + mp.mpf(radius) ** 2)
        close(
            fog.disk_irradiance(radiance, radius, distance, tau),
            2 * math.pi * radiance * slanted(tau, rim, 1),
        )
    # a disk that fills half the world
    close(fog.disk_irradiance(1.0, 1e6, 1.0, 0.7), math.pi * fog.lambertian_transmission(0.7), 1e-11)


@pytest.mark.parametrize("radii", [(0.5, 0.2), (0.2, 0.5), (0.3, 0.3), (0.5, 5e-4)])
def test_the_mean_over_a_meter_is_that_of_its_points(radii):
    """Without fog it is the view factor of two disks; with fog it is summed over both disks."""
    radius, meter = radii
    clear = fog.disk_irradiance(1.0, radius, 0.4, 0.0, meter)
    close(clear, math.pi * view_factors.coaxial_disks(meter, radius, 0.4))
    x, w = np.polynomial.legendre.leggauss(60)
    r, p = (size * (1 + x) / 2 for size in (radius, meter))
    turn = (np.arange(200) + 0.5) * math.pi / 200
    square = (
        0.4**2 + r[:, None, None] ** 2 + p[:, None] ** 2 - 2 * r[:, None, None] * p[:, None] * np.cos(turn)
    )
    pairs = (0.4**2 / square**2 * np.exp(-3 * np.sqrt(square) / 0.4)).mean(axis=2)
    summed = 2 * math.pi * (w * r * radius / 2) @ pairs @ (w * p * meter / 2) * 2 / meter**2
    close(fog.disk_irradiance(1.0, radius, 0.4, 3.0, meter), summed, 1e-12)


@pytest.mark.parametrize("radii", [(0.5, 0.2), (0.2, 0.5)])
def test_radiance_of_a_disk_by_direction_adds_up_to_its_irradiance(radii):
    """E = 2π ∫ L cosθ sinθ dθ, cut where the disk begins to leave the sight of the meter's rim, and where it has left."""
    radius, meter = radii
    ends = np.arctan([1e-300, abs(radius - meter) / 0.4, (radius + meter) / 0.4])
    x, w = np.polynomial.legendre.leggauss(300)
    summed = 0.0
    for low, high in zip(ends[:-1], ends[1:], strict=True):
        theta = low + (high - low) * (1 + x) / 2
        seen = fog.disk_radiance(theta, 3.0, radius, 0.4, 0.8, meter)
        summed += math.pi * (high - low) * (w @ (seen * np.cos(theta) * np.sin(theta)))
    close(summed, fog.disk_irradiance(3.0, radius, 0.4, 0.8, meter), 1e-8)
    assert fog.disk_radiance(1.4, 3.0, radius, 0.4, 0.8, meter) == 0


def test_clear_irradiance_times_the_straight_transmittance_is_too_much():
    """The wrong guess that the sim shows: slanted rays have more fog before them."""
    guess = math.exp(-1.0) * fog.disk_irradiance(1.0, 0.5, 0.1, 0.0)
    assert guess > 1.4 * fog.disk_irradiance(1.0, 0.5, 0.1, 1.0)


def test_the_sun_through_a_flat_atmosphere():
    tau = math.log(2.3 / 1.4)
    close(2.3 * fog.cone_transmittance(tau, 0.0, 1e-6), 1.4, 1e-9)
    with mp.workdps(20):
        tilt, half = mp.mpf("1.4"), mp.mpf("0.00465")

        def ray(theta, phi):
            cosine = mp.cos(theta) * mp.cos(tilt) + mp.sin(theta) * mp.cos(phi) * mp.sin(tilt)
            return mp.sin(theta) * mp.cos(theta) * mp.exp(-tau / cosine)

        mean = mp.quad(ray, [0, half], [0, mp.pi]) * 2 / (mp.pi * mp.sin(half) ** 2)
    close(fog.cone_transmittance(tau, 1.4, 0.00465), float(mean), 1e-12)
    assert abs(fog.cone_transmittance(tau, 1.4, 0.00465) / math.exp(-tau / math.cos(1.4)) - 1) > 1e-4


def test_light_across_a_ball_of_fog():
    for x in (1e-6, 0.4, 2.0, 30.0):
        whole = float(2 * mp.gammainc(2, 0, x) / mp.mpf(x) ** 2)
        close(fog.ball_transmittance(x), whole, 1e-12)
    edges = np.array([0.0, 0.2, 0.7, 1.0])
    bins = fog.ball_transmittance(2.0, edges[:-1], edges[1:])
    close(bins @ np.diff(edges**2), fog.ball_transmittance(2.0))
