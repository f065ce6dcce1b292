"""Attenuation along rays, over directions and through voxels: closed forms against references, quadrature and one another.

A comment such as `F.slab_escape_probability` names the entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

from transport.theory import attenuation as fog
from transport.theory import emitters, view_factors
from transport.theory.attenuation import optical_depths, shadow_means


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


def test_a_slab_emits_what_it_would_absorb():
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


def test_a_ball_emits_what_it_would_absorb():
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


# ---- voxels ----

LOW, HIGH = (-3.0, -2.0, 1.0), (5.0, 2.0, 4.0)
TANGENT = 0.8


@pytest.fixture(scope="module")
def extinction():
    cells = np.random.default_rng(1).random((8, 5, 6))
    return np.where(cells > 0.4, cells, 0.0)


def test_an_even_box_has_its_extinction_times_the_chord():
    even, starts = np.full((3, 4, 5), 0.7), np.array([[0.0, 0.0, 0.0], [-4.0, 0.1, 3.0], [9.0, 9.0, 9.0]])
    assert optical_depths(even, LOW, HIGH, starts[:1], (0, 0, 1)) == pytest.approx(0.7 * 3, rel=1e-14)
    slant = optical_depths(even, LOW, HIGH, starts[1:2], (1, 0, -0.1))
    assert slant == pytest.approx(0.7 * 8 * np.hypot(1, 0.1), rel=1e-14)
    assert optical_depths(even, LOW, HIGH, starts, (0, 0, 1))[2] == 0


@pytest.mark.parametrize("direction", [(1, 2, 3), (-1, 0.3, 0.2), (0, 0, -1), (0.8, 0, -1)])
def test_optical_depths_are_sums_along_lines(extinction, direction):
    draws = np.random.default_rng(2)
    starts = draws.uniform(LOW, HIGH, (20, 3))
    found = optical_depths(extinction, LOW, HIGH, starts, direction)
    unit = np.array(direction) / np.linalg.norm(direction)
    steps = (np.arange(100_000) + 0.5) * 2e-4
    for start, depth in zip(starts, found, strict=True):
        share = (start + steps[:, None] * unit - LOW) / (np.array(HIGH) - LOW)
        inside = ((share > 0) & (share < 1)).all(axis=1)
        index = (share[inside] * extinction.shape).astype(int)
        assert depth == pytest.approx(extinction[tuple(index.T)].sum() * 2e-4, abs=2e-3)


@pytest.mark.parametrize("tangent", [TANGENT, 0.05, -1.3, 0.0])
def test_means_in_the_shadow_are_those_of_many_lines(extinction, tangent):
    """To the error of a midpoint rule, whose lines come from the other function."""
    edges = np.array([-5.0, -2.2, -1.0, 0.3, 4.0, 9.0])
    exact = shadow_means(extinction, LOW, HIGH, tangent, edges)
    rows = np.linspace(LOW[1], HIGH[1], 6)
    n = 4000
    for row in (0, 3):
        for bin_ in range(len(edges) - 1):
            x = edges[bin_] + (np.arange(n) + 0.5) / n * (edges[bin_ + 1] - edges[bin_])
            places = np.stack([x, np.full(n, rows[row : row + 2].mean()), np.zeros(n)], axis=1)
            depths = optical_depths(extinction, LOW, HIGH, places, (-tangent, 0, 1))
            assert exact[bin_, row] == pytest.approx(np.exp(-depths).mean(), abs=2e-4)


def test_means_over_bins_join_to_the_mean_over_all(extinction):
    """And the mean of the exponential is not that of the mean depth."""
    fine = np.linspace(-4, 9, 301)
    parts = shadow_means(extinction, LOW, HIGH, TANGENT, fine)
    [whole] = shadow_means(extinction, LOW, HIGH, TANGENT, fine[[0, -1]])
    assert parts.mean(axis=0) == pytest.approx(whole, rel=1e-13)
    edges = np.linspace(-4, 9, 14)
    places = np.stack([(edges[1:] + edges[:-1]) / 2, *np.zeros((2, 13))], axis=1)
    depths = optical_depths(extinction, LOW, HIGH, places, (-TANGENT, 0, 1))
    assert np.abs(np.exp(-depths) - shadow_means(extinction, LOW, HIGH, TANGENT, edges)[:, 2]).max() > 0.02
    assert (shadow_means(np.zeros((2, 2, 2)), LOW, HIGH, TANGENT, np.linspace(-9, 9, 7)) == 1).all()
