"""The analytic limits agree with references and, in hard cases, with mpmath; forms that cancel do not.

A comment such as `B.sun` names the entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

from transport.geometry import solid_angles as solid_angles_geometry
from transport.geometry.solid_angles import projected_cone
from transport.theory import effusion, emitters, enclosures, solid_angles, view_factors

mp.mp.dps = 60
TILTED = (0.3, -0.5, 0.7)


def agrees(value, exact, relative: float = 2e-15) -> bool:
    """Whether all values agree with exact ones (floats or mpmath), relative to these."""
    pairs = zip(np.ravel(value), np.ravel(exact), strict=True)
    return all(abs(mp.mpf(float(v)) - mp.mpf(e)) <= relative * abs(mp.mpf(e)) for v, e in pairs)


def test_isotropic_gas_crosses_at_a_quarter_n_v():
    n, v = 2.5, 3.0
    assert agrees(effusion.one_way_flux_density(n, v), 1.875)  # A.isotropic_one_sided_flux
    assert agrees(effusion.fluence_rate(n, v), 7.5)
    assert agrees(effusion.mean_mu_of_crossers(), 2 / 3)
    assert agrees(math.pi * effusion.radiance(n, v), 1.875) and agrees(
        4 * math.pi * effusion.radiance(n, v), 7.5
    )
    assert effusion.net_flux_density(n, v) == 0
    bins = solid_angles.bin_projected_solid_angles(np.linspace(0, 1, 9), np.linspace(0, 2 * math.pi, 17))
    assert agrees(effusion.flux_in_bin(n, v, bins).sum(), 1.875)
    plain = solid_angles.bin_solid_angles(np.linspace(0, 1, 9), np.linspace(0, 2 * math.pi, 17))
    assert agrees(effusion.flux_in_bin(n, v, plain).sum(), 2 * 1.875)  # a dropped cosine doubles it


def test_stream_crosses_with_the_cosine_and_not_from_behind():
    degrees = np.array([0, 30, 60, 85, 89.9])
    exact = [7.5, 6.49519052838329, 3.75, 0.653668070607436, 0.013089962744236962]  # A.beam_flux
    assert agrees(effusion.stream_flux_density(2.5, 3.0, np.cos(np.radians(degrees))), exact, 1e-12)
    assert effusion.stream_flux_density(2.5, 3.0, -0.5) == 0


def test_diffuse_emitter_gives_off_pi_l_a():
    assert agrees(emitters.lambert_power(100.0, 0.02), 6.283185307179586)  # B.lambert_emitter


def test_disk_lights_its_axis_with_the_squared_sine():
    values = emitters.disk_irradiance(1.0, np.array([0.1, 0.5]), 1.0)
    assert agrees(values, [0.031104877758314785, 0.6283185307179586])  # B.disc_on_axis
    assert agrees(values, solid_angles.disk_projected_solid_angle(np.array([0.1, 0.5]), 1.0))
    # the angle subtended, without the cosine at the receiver, is another thing
    assert not agrees(values, solid_angles.disk_solid_angle(np.array([0.1, 0.5]), 1.0), 1e-3)


def foote(radius, distance, offset):
    """The textbook form, in mpmath numbers or floats."""
    r, d, x = radius, distance, offset
    root = mp.sqrt if isinstance(d, mp.mpf) else math.sqrt
    return (
        math.pi / 2 * (1 - (x * x + d * d - r * r) / root((x * x + d * d + r * r) ** 2 - 4 * x * x * r * r))
    )


@pytest.mark.parametrize(
    "distance, offset, exact", [(1, 0.5, 1.375963021307188), (0.01, 0.99, 2.6759215969441908)]
)
def test_disk_off_its_axis_follows_foote(distance, offset, exact):
    # B.disc_off_axis; its second value, ...442742, is the textbook form in doubles and 3e-14 off
    assert agrees(emitters.disk_irradiance(1.0, 1.0, distance, offset), exact)
    d2, x2 = mp.mpf(distance) ** 2, mp.mpf(offset) ** 2

    def ring(r):
        s = x2 + d2 + r * r
        return 2 * mp.pi * r * d2 * s / (s * s - 4 * x2 * r * r) ** 1.5

    assert agrees(mp.quad(ring, [0, offset, 1]), exact, 1e-14)


HARD_DISKS = [
    (1e12, 0),
    (1e12, 3e11),
    (1e-12, 0),
    (1e-12, 1 - 1e-12),
    (1e-9, 1 + 1e-9),
    (1e-6, 1),
    (1e-12, 1e12),
    (3, 1e12),
]


@pytest.mark.parametrize("distance, offset", HARD_DISKS)
def test_disk_is_stable_far_away_and_next_to_the_rim(distance, offset):
    with mp.workdps(150):
        exact = foote(mp.mpf(1), mp.mpf(distance), mp.mpf(offset)) / math.pi * mp.pi
    assert agrees(emitters.disk_irradiance(1.0, 1.0, distance, offset), exact, 4e-15)


def test_textbook_disk_formula_fails_where_ours_holds():
    assert not agrees(foote(1.0, 1e9, 0.0), mp.pi / (1 + mp.mpf(10) ** 18), 0.1)
    assert agrees(emitters.disk_irradiance(1.0, 1.0, 1e9), mp.pi / (1 + mp.mpf(10) ** 18))


def test_mean_over_a_disk_is_the_mean_of_its_points():
    nodes, weights = np.polynomial.legendre.leggauss(40)
    offsets = 0.7 * (1 + nodes) / 2
    mean = (weights * offsets * emitters.disk_irradiance(3.0, 0.4, 0.9, offsets)).sum() / 0.7
    assert agrees(emitters.mean_disk_irradiance(3.0, 0.4, 0.7, 0.9), mean, 1e-13)
    assert agrees(emitters.mean_disk_irradiance(1.0, 1.0, 1e-3, 1e12), mp.pi * mp.mpf("1e-24"), 1e-14)


def test_sphere_lights_exactly_with_the_inverse_square():
    values = emitters.sphere_irradiance(1.0, 1.0, np.array([1.0001, 5.5]))
    assert agrees(values, [3.14096442929429, 0.10385430259800969])  # B.sphere_irradiance
    assert agrees(emitters.sphere_irradiance(1.0, 1.0, 2.0, 0.8), math.pi / 4 * 0.8)
    assert agrees(emitters.sphere_irradiance(1.0, 1.0, 1e12, 1e-3), mp.pi * mp.mpf("1e-24") * 0.001)
    # half of it below the horizon: less than nothing is not subtracted
    assert emitters.sphere_irradiance(1.0, 1.0, 2.0, 0.0) > 0
    assert emitters.sphere_irradiance(1.0, 1.0, 2.0, -0.51) == 0
    with pytest.raises(ValueError, match="distance"):
        emitters.sphere_irradiance(1.0, 1.0, 0.9)


def test_point_source_lights_with_cosine_over_distance_squared():
    assert agrees(emitters.point_irradiance(4 * math.pi, 2.0, 0.5), 0.125)
    assert emitters.point_irradiance(1.0, 2.0, -0.5) == 0
    power = math.pi * 1.0 * 4 * math.pi  # a unit sphere of unit radiance
    assert agrees(emitters.point_irradiance(power, 5.5), emitters.sphere_irradiance(1.0, 1.0, 5.5))


@pytest.mark.parametrize(
    "radius, distance, exact", [(0.01, 2, 6.249882814941353e-06), (10000, 1.5, 0.4999250000008437)]
)
def test_point_source_sends_its_solid_angle_through_a_disk(radius, distance, exact):  # C.sphere_to_disc
    assert agrees(emitters.point_flux_through_disk(1.0, radius, distance), exact)
    assert agrees(emitters.mean_point_irradiance(1.0, radius, distance), exact / (math.pi * radius**2))
    assert agrees(solid_angles.disk_solid_angle(radius, distance), 4 * math.pi * exact)


def test_point_source_is_stable_far_from_a_small_disk():
    exact = (1 - 1 / mp.sqrt(1 + mp.mpf(10) ** -24)) / 2
    assert agrees(emitters.point_flux_through_disk(1.0, 1.0, 1e12), exact)
    assert not agrees((1 - 1e12 / math.hypot(1e12, 1.0)) / 2, exact, 0.1)


def test_five_times_rule_is_one_percent():
    assert agrees(emitters.disk_over_inverse_square(5.0), 0.9900990099009901)  # B.five_times_rule
    assert agrees(emitters.strip_over_inverse_square(5.0), 0.9933927674063053)
    assert agrees(emitters.disk_inverse_square_error(5.0), 0.01)
    assert emitters.disk_inverse_square_error(4.9) > 0.01


def test_sun_of_the_lecture():
    radius = emitters.sphere_radius(emitters.AREA)
    assert agrees(emitters.surface_radiance(emitters.POWER, emitters.AREA), 2.05e7, 3e-4)
    earth = emitters.irradiance_of_solid_angle(emitters.POWER, emitters.AREA, emitters.SOLID_ANGLE_EARTH)
    assert agrees(earth, 1373.7667361378526)  # B.sun
    assert agrees(earth, 1373.5, 3e-4)
    assert agrees(
        emitters.irradiance_of_solid_angle(emitters.POWER, emitters.AREA, emitters.SOLID_ANGLE_MARS),
        598.6,
        3e-4,
    )
    assert agrees(math.pi * emitters.surface_radiance(emitters.POWER, emitters.AREA), 64415156.50741351)
    assert agrees(emitters.distance_of_projected_area(radius, emitters.SOLID_ANGLE_EARTH), 1.505e11, 2e-4)
    assert agrees(emitters.distance_of_projected_area(radius, emitters.SOLID_ANGLE_MARS), 2.2797e11, 2e-4)
    assert agrees(emitters.sphere_solid_angle(radius, emitters.ASTRONOMICAL_UNIT), 6.78e-5, 1e-3)
    assert agrees(emitters.point_irradiance(emitters.POWER, emitters.ASTRONOMICAL_UNIT), 1390, 1e-3)
    # at the projected-area distance the lecture's L Omega is the exact P / (4 pi d^2)
    distance = emitters.distance_of_projected_area(radius, emitters.SOLID_ANGLE_EARTH)
    assert agrees(earth, emitters.point_irradiance(emitters.POWER, distance))
    assert not agrees(earth, emitters.point_irradiance(emitters.POWER, emitters.ASTRONOMICAL_UNIT), 1e-2)


@pytest.mark.parametrize("solid_angle", [2 * math.pi, 1.0, 6.7e-5, 1e-12, 1e-24])
def test_distance_and_solid_angle_of_a_sphere_are_inverse(solid_angle):
    distance = emitters.distance_of_solid_angle(1.0, solid_angle)
    assert agrees(emitters.sphere_solid_angle(1.0, distance), solid_angle, 1e-14)
    ratio = emitters.distance_of_projected_area(1.0, solid_angle) / distance
    assert agrees(ratio, math.sqrt(4 * (1 - solid_angle / (4 * math.pi))) / 2, 4e-15)


def test_cap_covers_four_pi_sine_squared_of_half_the_angle():
    angles = np.radians([0.01, 0.2666, 1, 30, 60, 90, 120])  # B.solid_angle_cap
    omega = [
        9.569838457281188e-08, 6.801804019788969e-05, 0.0009569595555748508, 0.8417872144769327,
        3.1415926535897922, 6.2831853071795845, 9.424777960769378,
    ]  # fmt: skip
    projected = [
        9.569838384402701e-08, 6.801767203639468e-05, 0.0009568866807871248, 0.7853981633974481,
        2.3561944901923444, 3.141592653589793, 3.141592653589793,
    ]  # fmt: skip
    assert agrees(solid_angles.cap_solid_angle(angles), omega)
    assert agrees(solid_angles.cap_projected_solid_angle(angles), projected)
    assert agrees(solid_angles_geometry.cone_projected_solid_angle(angles, 1.0), projected)
    assert not agrees(2 * math.pi * (1 - np.cos(1e-8)), solid_angles.cap_solid_angle(1e-8), 0.1)


@pytest.mark.parametrize(
    "sides, exact",
    [((1, 1), 0.8054316831613233), ((100, 100), 6.170067073507106), ((1000, 0.01), 0.01999979333595329)],
)
def test_rectangle_seen_on_its_axis(sides, exact):  # B.solid_angle_rectangle
    assert agrees(solid_angles.rectangle_solid_angle(*sides, 1.0), exact)
    a, b = sides[0] / 2, sides[1] / 2
    strip = lambda x: (  # noqa: E731
        b / (1 + x * x) / (1 + x * x + b * b) + mp.atan(b / mp.sqrt(1 + x * x)) / (1 + x * x) ** 1.5
    )
    with mp.workdps(20):
        points = [0, *(p for p in (1, 10, 100) if p < a), a]
        assert agrees(
            solid_angles.rectangle_projected_solid_angle(*sides, 1.0), 2 * mp.quad(strip, points), 1e-13
        )


def test_rectangle_is_stable_far_and_near():
    assert agrees(solid_angles.rectangle_solid_angle(1.0, 1.0, 1e12), mp.mpf("1e-24"))
    assert agrees(solid_angles.rectangle_solid_angle(1.0, 1.0, 0.0), 2 * math.pi)
    assert agrees(
        solid_angles.rectangle_projected_solid_angle(1.0, 1.0, 1.0), 0.7522746884541075
    )  # B.projected_…


def cone_by_quadrature(half_angle, mu):
    """Integral over the cone's own polar angle; the cut azimuth in closed form."""
    g, q = mp.mpf(mu), mp.sqrt((1 - mp.mpf(mu)) * (1 + mp.mpf(mu)))

    def ring(t):
        a, b = g * mp.cos(t), q * mp.sin(t)
        if abs(a) >= b:
            return mp.sin(t) * 2 * mp.pi * max(a, mp.mpf(0))
        edge = mp.acos(-a / b)
        return mp.sin(t) * 2 * (a * edge + b * mp.sin(edge))

    horizon = abs(mp.asin(g))
    points = [mp.mpf(0), *(p for p in (horizon, mp.pi - horizon) if 0 < p < half_angle), mp.mpf(half_angle)]
    return mp.quad(ring, points)


@pytest.mark.parametrize("half_angle", [1e-9, 0.01, 0.7, 1.5, math.pi / 2, 2.5])
@pytest.mark.parametrize("height", [1.0, 0.9, 0.3, 0.0, -0.3, -0.9, -0.99])
def test_cone_cut_at_the_horizon(half_angle, height):
    # height: cosine of the axis in units of the half angle's sine
    mu = height * math.sin(half_angle)
    with mp.workdps(40):
        exact = cone_by_quadrature(half_angle, mu)
    # the cosine's rounding alone moves a sliver of relative height 0.01 by 250 roundings
    assert agrees(solid_angles_geometry.cone_projected_solid_angle(half_angle, mu), exact, 1e-13)


def test_cone_is_whole_half_or_absent():
    s = 0.6
    assert agrees(projected_cone(s, 0.8, 0.7), math.pi * s * s * 0.7)
    assert projected_cone(s, 0.8, -0.6) == 0
    assert agrees(projected_cone(1.0, 0.0, np.array([1.0, 0.0, -0.5])), math.pi / 2 * np.array([2, 1, 0.5]))
    # the law of the uncut cone is wrong for a cut one
    assert not agrees(projected_cone(s, 0.8, 0.3), math.pi * s * s * 0.3, 1e-2)


def test_sliver_of_a_small_cone_keeps_its_digits():
    s, c, g = mp.mpf(2) ** -30, mp.sqrt(1 - mp.mpf(2) ** -60), -(mp.mpf(2) ** -30) * (1 - mp.mpf(2) ** -20)
    q = mp.sqrt(1 - g * g)
    psi, chi = mp.acos(c / q), mp.acos(-c * g / (s * q))
    exact = psi - mp.sin(psi) * mp.cos(psi) + g * s**2 * (chi - mp.sin(chi) * mp.cos(chi))
    assert agrees(projected_cone(float(s), float(c), float(g)), exact, 1e-14)


def test_world_bins_are_local_bins_when_the_normal_is_the_axis():
    mu, phi = np.array([-1, -0.2, 1e-12, 0.3, 1 - 1e-9, 1]), np.array([-3, -1, 0.5, 0.5 + 1e-9, 3])
    local = solid_angles.bin_projected_solid_angles(mu, phi)
    assert agrees(solid_angles_geometry.projected_solid_angles(mu, phi, (0, 0, 2.0))[2:], local[2:], 1e-14)
    assert np.all(solid_angles_geometry.projected_solid_angles(mu, phi, (0, 0, 1))[0] == 0)


NORMALS = [
    (0, 0, 1),
    (0, 0, -1),
    (1, 0, 0),
    (0, -1, 0),
    TILTED,
    (1e-9, 0, 1),
    (1, 1e-12, -1e-9),
    (1e-200, 1e-200, 0),
]


@pytest.mark.parametrize("normal", NORMALS)
def test_world_bins_of_a_sphere_add_up_to_pi(normal):
    mu, phi = np.linspace(-1, 1, 10), np.linspace(0, 2 * math.pi, 14)
    front = solid_angles_geometry.projected_solid_angles(mu, phi, normal)
    back = solid_angles_geometry.projected_solid_angles(mu, phi, np.negative(normal))
    assert agrees(front.sum(), math.pi, 1e-14) and agrees(back.sum(), math.pi, 1e-14)
    # front minus back is the integral of omega . n, cut nowhere
    theta, n = np.arccos(mu), np.divide(normal, np.max(np.abs(normal)))
    n = n / np.linalg.norm(n)
    across = (np.diff(theta - np.sin(theta) * mu) / -2)[:, None]
    along = n[2] * (np.diff(mu**2) / 2)[:, None] * np.diff(phi)
    whole = across * (n[0] * np.diff(np.sin(phi)) - n[1] * np.diff(np.cos(phi))) + along
    np.testing.assert_allclose(front - back, whole, rtol=0, atol=3e-15)


def bin_by_quadrature(mu, phi, normal):
    """Integral over mu with mpmath; the cut azimuth in closed form."""
    n = [mp.mpf(x) / mp.norm(mp.matrix(normal)) for x in normal]
    across, azimuth = mp.hypot(n[0], n[1]), mp.atan2(n[1], n[0])

    def row(m):
        a, b = n[2] * m, across * mp.sqrt((1 - m) * (1 + m))
        edge = mp.pi if a >= b else mp.mpf(0) if a <= -b else mp.acos(-a / b)
        spans = [
            (max(phi[0] - azimuth - k * 2 * mp.pi, -edge), min(phi[1] - azimuth - k * 2 * mp.pi, edge))
            for k in range(-2, 3)
        ]
        return sum(a * (hi - lo) + b * (mp.sin(hi) - mp.sin(lo)) for lo, hi in spans if hi > lo)

    crossings = [mp.cos(mp.atan2(n[2], -across * mp.cos(p - azimuth))) for p in phi]
    crossings += [-x for x in crossings] + [across, -across]
    return mp.quad(row, [mu[0], *sorted(x for x in crossings if mu[0] < x < mu[1]), mu[1]])


BINS = [
    ((-0.5, 0.5), (-1, 2), TILTED),
    ((-1, 1), (0, 3), (1, 2, 1e-3)),
    ((0.99, 1), (0, 6), (1, 0, 0.01)),
    ((1 - 1e-9, 1), (0, 1e-6), TILTED),
    ((0.2, 0.2 + 1e-9), (1, 1 + 1e-9), (0.3, 0.5, 0.7)),
    ((-0.83, -0.82), (4, 5), (0.3, 0.5, 0.7)),
]


@pytest.mark.parametrize("mu, phi, normal", BINS)
def test_world_bin_agrees_with_quadrature(mu, phi, normal):
    with mp.workdps(40):
        exact = bin_by_quadrature([mp.mpf(x) for x in mu], [mp.mpf(x) for x in phi], normal)
    value = solid_angles_geometry.projected_solid_angles(mu, phi, normal)[0, 0]
    assert abs(value - exact) <= 1e-13 * (mu[1] - mu[0]) * (phi[1] - phi[0])
    if exact > 0.01 * (mu[1] - mu[0]) * (phi[1] - phi[0]):
        assert agrees(value, exact, 1e-13)


@pytest.mark.parametrize(
    "mu, phi, normal, word",
    [
        ((0, 0), (0, 1), TILTED, "mu_edges"),
        ((0, 1.1), (0, 1), TILTED, "mu_edges"),
        ((0, 1), (1, 0), TILTED, "phi_edges"),
        ((0, 1), (0, 7), TILTED, "phi_edges"),
        ((0, 1), (0, 1), (0, 0, 0), "normal"),
        ((0, 1), (0, 1), (0, math.nan, 1), "normal"),
    ],
)
def test_wrong_bins_are_refused(mu, phi, normal, word):
    with pytest.raises(ValueError, match=word):
        solid_angles_geometry.projected_solid_angles(mu, phi, normal)


DISKS = [  # C.coaxial_discs, and B.etendue_discs over pi A1
    ((1, 1, 1), 0.38196601125010515),
    ((1, 1, 0.5), 0.6096117967977924),
    ((1, 1, 2), 0.1715728752538099),
    ((1, 2, 1), 0.7639320225002103),
    ((1, 0.001, 1), 4.999998750000001e-07),
    ((0.01, 0.02, 1), 3.945868983699782e-07 / math.pi**2 / 1e-4),
    ((1, 1, 100), 0.0009867630973551228 / math.pi**2),
]


@pytest.mark.parametrize("geometry, exact", DISKS)
def test_coaxial_disks(geometry, exact):
    assert agrees(view_factors.coaxial_disks(*geometry), exact)


def test_coaxial_disks_are_stable_far_and_near():
    assert agrees(view_factors.coaxial_disks(1.0, 1.0, 1e12), mp.mpf("1e-24"))
    assert agrees(view_factors.coaxial_disks(1.0, 1.0, 1e-12), 1 - mp.mpf("1e-12"))
    total = 2 + 1e18
    assert not agrees((total - math.sqrt(total**2 - 4)) / 2, mp.mpf("1e-18"), 0.1)


PARALLEL = [  # C.parallel_rectangles, and B.etendue_rectangles over pi a b
    ((1, 1, 10), 0.0031620568387576015),
    ((2, 1, 1), 0.28587538485071473),
    ((1, 10, 1), 0.386382489266135),
    ((1, 1, 0.001), 0.9980056319075797),
    ((100, 0.01, 1), 0.004968045609095783),
    ((1, 1, 100000), 3.1830988616257004e-11),
    ((1, 2, 0.5), 3.198070126842054 / (2 * math.pi)),
    ((1, 1, 100), 9.999333389994476e-05 / math.pi),
    ((10, 0.1, 1), 0.1467386196838192 / math.pi),
    ((1, 1, 1), 0.19982489569838738),
]


@pytest.mark.parametrize("geometry, exact", PARALLEL)
def test_parallel_rectangles(geometry, exact):
    assert agrees(view_factors.parallel_rectangles(*geometry), exact)
    assert agrees(view_factors.opposed_rectangles(geometry[:2], geometry[:2], geometry[2]), exact)


def test_parallel_rectangles_are_stable_far_away():
    assert agrees(view_factors.parallel_rectangles(1.0, 1.0, 1e12), mp.mpf("1e-24") / mp.pi)


def howell_c13(sides_1, sides_2, distance):
    """Sixteen terms, in mpmath numbers."""

    def term(x, y, z):
        p, r = mp.hypot(x, z), mp.hypot(y, z)
        return (
            y * p * mp.atan(y / p) + x * r * mp.atan(x / r) - z * z * mp.log(x * x + y * y + z * z) / 2
        ) / (2 * mp.pi)

    (w, h), (u, v), total = map(mp.mpf, sides_1), map(mp.mpf, sides_2), mp.mpf(0)
    for i, j, k, m in np.ndindex(2, 2, 2, 2):
        signs = [(-1) ** s for s in (i, j, k, m)]
        x, y = (signs[0] * w - signs[2] * u) / 2, (signs[1] * h - signs[3] * v) / 2
        total += math.prod(signs) * term(x, y, mp.mpf(distance))
    return total / (w * h)


OPPOSED = [
    ((1, 1), (1.3, 0.8), 1),
    ((1, 1), (10, 10), 0.1),
    ((1, 1), (2.01, 2.01), 1e-3),
    ((1, 2.01), (2.01, 1), 0.3),
    ((1, 1), (2.01, 1.9), 1e-3),
    ((1e-6, 1e-6), (1, 1), 0.5),
    ((1e-9, 1), (1e3, 1.5), 1),
    ((1, 1), (3, 0.01), 1e6),
    ((1e6, 1e-6), (1e-6, 1e6), 1e-3),
]


@pytest.mark.parametrize("sides_1, sides_2, distance", OPPOSED)
def test_unequal_opposed_rectangles(sides_1, sides_2, distance):
    with mp.workdps(120):
        exact = howell_c13(sides_1, sides_2, distance)
    value = view_factors.opposed_rectangles(sides_1, sides_2, distance)
    assert agrees(value, exact, 4e-15)
    back = view_factors.opposed_rectangles(sides_2, sides_1, distance)
    assert agrees(value * math.prod(sides_1), back * math.prod(sides_2), 4e-15)


PERPENDICULAR = [  # C.perpendicular_rectangles: (W, H)
    ((1, 1), 0.20004377607540316),
    ((1, 0.5), 0.1461866791057133),
    ((1, 0.01), 0.004895849268506683),
    ((1, 100), 0.2499920427833168),
    ((0.1, 0.1), 0.28188780678790143),
]


@pytest.mark.parametrize("widths, exact", PERPENDICULAR)
def test_perpendicular_rectangles(widths, exact):
    assert agrees(view_factors.perpendicular_rectangles(*widths), exact)
    scaled = [1e-9 * w for w in widths]
    assert agrees(view_factors.perpendicular_rectangles(*scaled, edge=1e-9), exact)


@pytest.mark.parametrize("w, h", [(1e-6, 1e-12), (1, 1e-12), (1e12, 1), (1e9, 1e9), (1e-9, 1e9), (1e5, 1e-5)])
def test_perpendicular_rectangles_are_stable(w, h):
    with mp.workdps(150):
        a, b = mp.mpf(w) ** 2, mp.mpf(h) ** 2
        angle = lambda x: mp.sqrt(x) * mp.atan(1 / mp.sqrt(x))  # noqa: E731
        logs = mp.log((1 + a) * (1 + b) / (1 + a + b))
        logs += a * mp.log(a * (1 + a + b) / (1 + a) / (a + b)) + b * mp.log(
            b * (1 + a + b) / (1 + b) / (a + b)
        )
        exact = (angle(a) + angle(b) - angle(a + b) + logs / 4) / (mp.pi * mp.mpf(w))
    assert agrees(view_factors.perpendicular_rectangles(w, h), exact)


@pytest.mark.parametrize("size", [(1, 1, 1), (1, 2, 3), (1e-3, 1, 50)])
def test_walls_of_a_box_see_only_each_other(size):
    factors = view_factors.box_view_factors(size)
    areas = np.repeat([size[1] * size[2], size[0] * size[2], size[0] * size[1]], 2)
    assert agrees(factors.sum(axis=1), np.ones(6), 1e-13)
    assert agrees(areas[:, None] * factors + 1, (areas[:, None] * factors).T + 1, 1e-14)


def test_closed_box_absorbs_what_it_emits():
    size, albedos = (1.0, 2.0, 3.0), np.array([0, 0.1, 0.5, 0.9, 0.99, 0.3])
    factors = view_factors.box_view_factors(size)
    areas = np.repeat([6.0, 3.0, 2.0], 2)
    emitted = np.array([0, 5.0, 0, 0, 1.0, 0])
    exitance = np.linalg.solve(np.eye(6) - albedos[:, None] * factors, emitted)
    irradiance = factors @ exitance
    assert agrees(enclosures.absorbed_power(albedos, irradiance * areas), emitted @ areas, 1e-13)
    again = enclosures.emitted_exitance(exitance, irradiance, albedos)
    np.testing.assert_allclose(again, emitted, rtol=0, atol=1e-13)
    # counting all that falls in, reflected or not, is not the ledger
    assert not agrees(np.sum(irradiance * areas), emitted @ areas, 1e-2)


@pytest.mark.parametrize("albedo", [0.0, 0.5, 0.999, 1 - 1e-12])
def test_furnace_is_uniform_whatever_the_shape(albedo):
    factors = view_factors.box_view_factors((1.0, 2.0, 0.1))
    exitance = enclosures.furnace_irradiance(1.0, albedo)
    assert agrees(factors @ np.full(6, exitance), np.full(6, exitance), 1e-13)
    assert agrees(enclosures.furnace_radiance(1.0, albedo) * math.pi, exitance)
    assert agrees(enclosures.emitted_exitance(exitance, exitance, albedo), 1.0, 1e-15 + 1e-15 / (1 - albedo))
    assert agrees(enclosures.total_flux_in(6.0, albedo), 6 * exitance)
    assert agrees(enclosures.mean_irradiance(6.0, albedo, 6.0), exitance)


@pytest.mark.parametrize(
    "albedo, port_share, exact",
    [
        (0.9, 0, 9.0),
        (0.95, 0.05, 9.74358974358974),
        (0.99, 0.01, 49.74874371859289),
        (0.999, 1e-4, 908.2643876715714),
    ],
)
def test_integrating_sphere_multiplies(albedo, port_share, exact):  # D.integrating_sphere
    assert agrees(enclosures.sphere_wall_exitance(2.0, albedo, 4.0, port_share), exact / 2, 1e-13)
    if port_share == 0:
        direct = 2.0 / 4.0
        indirect = enclosures.sphere_wall_exitance(2.0, albedo, 4.0)
        assert agrees(enclosures.sphere_irradiance_of_wall_patch(2.0, albedo, 4.0), direct + indirect, 1e-14)
