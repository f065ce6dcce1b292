"""Closed forms of emitters, solid angles, view factors and enclosures agree with references and, in hard cases, with mpmath.

A comment such as `B.sun` names the entry of the project's reference collection that a number comes from.  Forms that cancel, and
laws that are often taken for these, are shown to differ.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

from transport.geometry.solid_angles import cone_projected_solid_angle, projected_cone, projected_solid_angles
from transport.theory import effusion, emitters, enclosures, solid_angles, view_factors

PI, TILTED, FAR = math.pi, (0.3, -0.5, 0.7), mp.mpf("1e-24")
EARTH, MARS = emitters.SOLID_ANGLE_EARTH, emitters.SOLID_ANGLE_MARS
RADIUS = emitters.sphere_radius(emitters.AREA)


@pytest.fixture(autouse=True)
def sixty_digits():
    with mp.workdps(60):
        yield


def agrees(value, exact, relative=2e-15):
    """Whether all values agree with exact ones (floats or mpmath), relative to these."""
    pairs = zip(np.ravel(value), np.ravel(exact), strict=True)
    return all(abs(mp.mpf(float(v)) - mp.mpf(e)) <= relative * abs(mp.mpf(e)) for v, e in pairs)


BINS = np.linspace(0, 1, 9), np.linspace(0, 2 * PI, 17)
ANGLES = np.radians([0.01, 0.2666, 1, 30, 60, 90, 120])
PROJECTED = [
    9.569838384402701e-08, 6.801767203639468e-05, 0.0009568866807871248, 0.7853981633974481,
    2.3561944901923444, 3.141592653589793, 3.141592653589793,
]  # fmt: skip
EARTH_IRRADIANCE = emitters.irradiance_of_solid_angle(emitters.POWER, emitters.AREA, EARTH)
REFERENCES = {  # value, exact, relative tolerance
    # an isotropic gas crosses at n v / 4
    "A.isotropic_one_sided_flux": (effusion.one_way_flux_density(2.5, 3.0), 1.875),
    "fluence rate n v": (effusion.fluence_rate(2.5, 3.0), 7.5),
    "mean mu of crossers": (effusion.mean_mu_of_crossers(), 2 / 3),
    "radiance n v / 4 pi": (4 * PI * effusion.radiance(2.5, 3.0), 7.5),
    "flux in bins": (effusion.flux_in_bin(2.5, 3.0, solid_angles.bin_projected_solid_angles(*BINS)).sum(), 1.875),
    "a dropped cosine doubles it": (effusion.flux_in_bin(2.5, 3.0, solid_angles.bin_solid_angles(*BINS)).sum(), 3.75),
    "A.beam_flux": (
        effusion.stream_flux_density(2.5, 3.0, np.cos(np.radians([0, 30, 60, 85, 89.9]))),
        [7.5, 6.49519052838329, 3.75, 0.653668070607436, 0.013089962744236962], 1e-12,
    ),
    # emitters
    "B.lambert_emitter": (emitters.lambert_power(100.0, 0.02), 6.283185307179586),
    "B.disc_on_axis": (emitters.disk_irradiance(1.0, np.array([0.1, 0.5]), 1.0), [0.031104877758314785, 0.6283185307179586]),
    "a disk is a projected solid angle": (
        emitters.disk_irradiance(1.0, np.array([0.1, 0.5]), 1.0),
        solid_angles.disk_projected_solid_angle(np.array([0.1, 0.5]), 1.0),
    ),
    "a disk far away": (emitters.disk_irradiance(1.0, 1.0, 1e9), PI * (1 / (1 + mp.mpf(10) ** 18))),
    "a mean over a far disk": (emitters.mean_disk_irradiance(1.0, 1.0, 1e-3, 1e12), mp.mpf(PI) * FAR, 1e-14),
    "B.sphere_irradiance": (emitters.sphere_irradiance(1.0, 1.0, np.array([1.0001, 5.5])), [3.14096442929429, 0.10385430259800969]),
    "a tilted sphere": (emitters.sphere_irradiance(1.0, 1.0, 2.0, 0.8), PI / 4 * 0.8),
    "a far sphere": (emitters.sphere_irradiance(1.0, 1.0, 1e12, 1e-3), mp.mpf(PI) * FAR * mp.mpf(0.001)),
    "a point": (emitters.point_irradiance(4 * PI, 2.0, 0.5), 0.125),
    "a point of a sphere's power": (
        emitters.point_irradiance(PI * 1.0 * 4 * PI, 5.5), emitters.sphere_irradiance(1.0, 1.0, 5.5),
    ),
    "B.five_times_rule, disk": (emitters.disk_over_inverse_square(5.0), 0.9900990099009901),
    "B.five_times_rule, strip": (emitters.strip_over_inverse_square(5.0), 0.9933927674063053),
    "five times is one percent": (emitters.disk_inverse_square_error(5.0), 0.01),
    "a far disk from a point": (
        emitters.point_flux_through_disk(1.0, 1.0, 1e12), FAR / 4 * (1 - mp.mpf(3) / 4 * FAR),
    ),
    # the Sun of the lecture
    "its radiance": (emitters.surface_radiance(emitters.POWER, emitters.AREA), 2.05e7, 3e-4),
    "B.sun": (EARTH_IRRADIANCE, 1373.7667361378526),
    "irradiance on Earth": (EARTH_IRRADIANCE, 1373.5, 3e-4),
    "irradiance on Mars": (emitters.irradiance_of_solid_angle(emitters.POWER, emitters.AREA, MARS), 598.6, 3e-4),
    "its exitance": (PI * emitters.surface_radiance(emitters.POWER, emitters.AREA), 64415156.50741351),
    "distance of Earth": (emitters.distance_of_projected_area(RADIUS, EARTH), 1.505e11, 2e-4),
    "distance of Mars": (emitters.distance_of_projected_area(RADIUS, MARS), 2.2797e11, 2e-4),
    "its solid angle": (emitters.sphere_solid_angle(RADIUS, emitters.ASTRONOMICAL_UNIT), 6.78e-5, 1e-3),
    "irradiance at one unit": (emitters.point_irradiance(emitters.POWER, emitters.ASTRONOMICAL_UNIT), 1390.0, 1e-3),
    "L Omega is P / (4 pi d^2) at the distance of the projected area": (
        EARTH_IRRADIANCE, emitters.point_irradiance(emitters.POWER, emitters.distance_of_projected_area(RADIUS, EARTH)),
    ),
    # solid angles
    "B.solid_angle_cap": (
        solid_angles.cap_solid_angle(ANGLES),
        [9.569838457281188e-08, 6.801804019788969e-05, 0.0009569595555748508, 0.8417872144769327,
         3.1415926535897922, 6.2831853071795845, 9.424777960769378],
    ),
    "projected caps": (solid_angles.cap_projected_solid_angle(ANGLES), PROJECTED),
    "cones about the normal": (cone_projected_solid_angle(ANGLES, 1.0), PROJECTED),
    "a far square": (solid_angles.rectangle_solid_angle(1.0, 1.0, 1e12), FAR),
    "a square that touches": (solid_angles.rectangle_solid_angle(1.0, 1.0, 0.0), 2 * PI),
    "B.projected_square": (solid_angles.rectangle_projected_solid_angle(1.0, 1.0, 1.0), 0.7522746884541075),
    "a whole cone": (projected_cone(0.6, 0.8, 0.7), PI * 0.36 * 0.7),
    "half spaces": (projected_cone(1.0, 0.0, np.array([1.0, 0.0, -0.5])), PI / 2 * np.array([2, 1, 0.5])),
    # view factors
    "far disks": (view_factors.coaxial_disks(1.0, 1.0, 1e12), FAR),
    "near disks": (view_factors.coaxial_disks(1.0, 1.0, 1e-12), 1 - mp.mpf("1e-12")),
    "far squares": (view_factors.parallel_rectangles(1.0, 1.0, 1e12), mp.mpf("3.18309886183790671538e-25")),
}  # fmt: skip


@pytest.mark.parametrize("case", REFERENCES.values(), ids=REFERENCES)
def test_a_closed_form_agrees_with_its_reference(case):
    assert agrees(*case)


ZERO = {
    "net flux of an isotropic gas": effusion.net_flux_density(2.5, 3.0),
    "a stream from behind": effusion.stream_flux_density(2.5, 3.0, -0.5),
    "a sphere below the horizon": emitters.sphere_irradiance(1.0, 1.0, 2.0, -0.51),
    "a point from behind": emitters.point_irradiance(1.0, 2.0, -0.5),
    "a cone below the horizon": projected_cone(0.6, 0.8, -0.6),
}


def test_nothing_comes_from_behind():
    assert ZERO == dict.fromkeys(ZERO, 0)
    assert (
        emitters.sphere_irradiance(1.0, 1.0, 2.0, 0.0) > 0
    )  # half of it below the horizon is not subtracted
    with pytest.raises(ValueError, match="distance"):
        emitters.sphere_irradiance(1.0, 1.0, 0.9)


def foote(radius, distance, offset):
    """The textbook form, in mpmath numbers or floats."""
    r, d, x = radius, distance, offset
    root = mp.sqrt if isinstance(d, mp.mpf) else math.sqrt
    return PI / 2 * (1 - (x * x + d * d - r * r) / root((x * x + d * d + r * r) ** 2 - 4 * x * x * r * r))


OTHER = {  # a value, another that it must not be, their least relative difference
    "a disk by its solid angle": (
        emitters.disk_irradiance(1.0, 0.5, 1.0), solid_angles.disk_solid_angle(0.5, 1.0), 1e-3,
    ),
    "Foote's form, far": (foote(1.0, 1e9, 0.0), PI / 1e18, 0.1),
    "the textbook's disk, far": ((1 - 1e12 / math.hypot(1e12, 1.0)) / 2, 2.5e-25, 0.1),
    "the Sun at another distance": (
        EARTH_IRRADIANCE, emitters.point_irradiance(emitters.POWER, emitters.ASTRONOMICAL_UNIT), 1e-2,
    ),
    "1 - cos of a small angle": (2 * PI * (1 - np.cos(1e-8)), solid_angles.cap_solid_angle(1e-8), 0.1),
    "a cut cone by the law of a whole one": (projected_cone(0.6, 0.8, 0.3), PI * 0.36 * 0.3, 1e-2),
    "one percent at 4.9 times": (emitters.disk_inverse_square_error(4.9), 0.01, 1e-2),
    "far disks by the textbook": (((2 + 1e18) - math.sqrt((2 + 1e18) ** 2 - 4)) / 2, 1e-18, 0.1),
}  # fmt: skip


@pytest.mark.parametrize(("value", "other", "relative"), OTHER.values(), ids=OTHER)
def test_forms_that_cancel_and_laws_of_other_cases_differ(value, other, relative):
    assert not agrees(value, other, relative)


# ---- disks, off their axis ----


@pytest.mark.parametrize(
    ("distance", "offset", "exact"), [(1, 0.5, 1.375963021307188), (0.01, 0.99, 2.6759215969441908)]
)
def test_a_disk_off_its_axis_follows_foote(distance, offset, exact):
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


@pytest.mark.parametrize(("distance", "offset"), HARD_DISKS)
def test_a_disk_is_stable_far_away_and_next_to_the_rim(distance, offset):
    with mp.workdps(150):
        exact = foote(mp.mpf(1), mp.mpf(distance), mp.mpf(offset)) / PI * mp.pi
    assert agrees(emitters.disk_irradiance(1.0, 1.0, distance, offset), exact, 4e-15)


def test_the_mean_over_a_disk_is_the_mean_of_its_points():
    nodes, weights = np.polynomial.legendre.leggauss(40)
    offsets = 0.7 * (1 + nodes) / 2
    mean = (weights * offsets * emitters.disk_irradiance(3.0, 0.4, 0.9, offsets)).sum() / 0.7
    assert agrees(emitters.mean_disk_irradiance(3.0, 0.4, 0.7, 0.9), mean, 1e-13)


@pytest.mark.parametrize(
    ("radius", "distance", "exact"), [(0.01, 2, 6.249882814941353e-06), (10000, 1.5, 0.4999250000008437)]
)
def test_a_point_source_sends_its_solid_angle_through_a_disk(radius, distance, exact):  # C.sphere_to_disc
    assert agrees(emitters.point_flux_through_disk(1.0, radius, distance), exact)
    assert agrees(emitters.mean_point_irradiance(1.0, radius, distance), exact / (PI * radius**2))
    assert agrees(solid_angles.disk_solid_angle(radius, distance), 4 * PI * exact)


@pytest.mark.parametrize("solid_angle", [2 * PI, 1.0, 6.7e-5, 1e-12, 1e-24])
def test_distance_and_solid_angle_of_a_sphere_are_inverse(solid_angle):
    distance = emitters.distance_of_solid_angle(1.0, solid_angle)
    assert agrees(emitters.sphere_solid_angle(1.0, distance), solid_angle, 1e-14)
    ratio = emitters.distance_of_projected_area(1.0, solid_angle) / distance
    assert agrees(ratio, math.sqrt(4 * (1 - solid_angle / (4 * PI))) / 2, 4e-15)


@pytest.mark.parametrize(
    ("sides", "exact"),
    [((1, 1), 0.8054316831613233), ((100, 100), 6.170067073507106), ((1000, 0.01), 0.01999979333595329)],
)
def test_a_rectangle_seen_on_its_axis(sides, exact):  # B.solid_angle_rectangle
    assert agrees(solid_angles.rectangle_solid_angle(*sides, 1.0), exact)
    a, b = sides[0] / 2, sides[1] / 2

    def strip(x):
        return b / (1 + x * x) / (1 + x * x + b * b) + mp.atan(b / mp.sqrt(1 + x * x)) / (1 + x * x) ** 1.5

    with mp.workdps(20):
        exact = 2 * mp.quad(strip, [0, *(p for p in (1, 10, 100) if p < a), a])
        assert agrees(solid_angles.rectangle_projected_solid_angle(*sides, 1.0), exact, 1e-13)


# ---- cones and bins of the world's directions, cut at the horizon ----


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


@pytest.mark.parametrize("half_angle", [1e-9, 0.01, 0.7, 1.5, PI / 2, 2.5])
@pytest.mark.parametrize("height", [1.0, 0.9, 0.3, 0.0, -0.3, -0.9, -0.99])
def test_a_cone_is_cut_at_the_horizon(half_angle, height):
    """height: cosine of the axis in units of the half angle's sine, whose rounding moves a sliver by 250 roundings."""
    mu = height * math.sin(half_angle)
    with mp.workdps(40):
        exact = cone_by_quadrature(half_angle, mu)
    assert agrees(cone_projected_solid_angle(half_angle, mu), exact, 1e-13)


def test_a_sliver_of_a_small_cone_keeps_its_digits():
    s, c, g = mp.mpf(2) ** -30, mp.sqrt(1 - mp.mpf(2) ** -60), -(mp.mpf(2) ** -30) * (1 - mp.mpf(2) ** -20)
    q = mp.sqrt(1 - g * g)
    psi, chi = mp.acos(c / q), mp.acos(-c * g / (s * q))
    exact = psi - mp.sin(psi) * mp.cos(psi) + g * s**2 * (chi - mp.sin(chi) * mp.cos(chi))
    assert agrees(projected_cone(float(s), float(c), float(g)), exact, 1e-14)


NORMALS = [
    (0, 0, 1), (0, 0, -1), (1, 0, 0), (0, -1, 0), TILTED, (1e-9, 0, 1), (1, 1e-12, -1e-9), (1e-200, 1e-200, 0),
]  # fmt: skip


@pytest.mark.parametrize("normal", NORMALS)
def test_world_bins_of_a_sphere_add_up_to_pi(normal):
    mu, phi = np.linspace(-1, 1, 10), np.linspace(0, 2 * PI, 14)
    front, back = (projected_solid_angles(mu, phi, np.multiply(sign, normal)) for sign in (1, -1))
    assert agrees(front.sum(), PI, 1e-14) and agrees(back.sum(), PI, 1e-14)
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
        turns = [azimuth + k * 2 * mp.pi for k in range(-2, 3)]
        spans = [(max(phi[0] - turn, -edge), min(phi[1] - turn, edge)) for turn in turns]
        return sum(a * (hi - lo) + b * (mp.sin(hi) - mp.sin(lo)) for lo, hi in spans if hi > lo)

    crossings = [mp.cos(mp.atan2(n[2], -across * mp.cos(p - azimuth))) for p in phi]
    crossings += [-x for x in crossings] + [across, -across]
    return mp.quad(row, [mu[0], *sorted(x for x in crossings if mu[0] < x < mu[1]), mu[1]])


WORLD_BINS = [
    ((-0.5, 0.5), (-1, 2), TILTED),
    ((-1, 1), (0, 3), (1, 2, 1e-3)),
    ((0.99, 1), (0, 6), (1, 0, 0.01)),
    ((1 - 1e-9, 1), (0, 1e-6), TILTED),
    ((0.2, 0.2 + 1e-9), (1, 1 + 1e-9), (0.3, 0.5, 0.7)),
    ((-0.83, -0.82), (4, 5), (0.3, 0.5, 0.7)),
]


@pytest.mark.parametrize(("mu", "phi", "normal"), WORLD_BINS)
def test_a_world_bin_agrees_with_quadrature(mu, phi, normal):
    with mp.workdps(40):
        exact = bin_by_quadrature([mp.mpf(x) for x in mu], [mp.mpf(x) for x in phi], normal)
    value, size = projected_solid_angles(mu, phi, normal)[0, 0], (mu[1] - mu[0]) * (phi[1] - phi[0])
    assert abs(value - exact) <= 1e-13 * size
    if exact > 0.01 * size:
        assert agrees(value, exact, 1e-13)


@pytest.mark.parametrize(
    ("mu", "phi", "normal", "word"),
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
        projected_solid_angles(mu, phi, normal)


# ---- view factors ----

coaxial, parallel = view_factors.coaxial_disks, view_factors.parallel_rectangles
perpendicular, opposed = view_factors.perpendicular_rectangles, view_factors.opposed_rectangles
VIEW_FACTORS = [
    (coaxial, (1, 1, 1), 0.38196601125010515),  # C.coaxial_discs, and B.etendue_discs over pi A1
    (coaxial, (1, 1, 0.5), 0.6096117967977924),
    (coaxial, (1, 1, 2), 0.1715728752538099),
    (coaxial, (1, 2, 1), 0.7639320225002103),
    (coaxial, (1, 0.001, 1), 4.999998750000001e-07),
    (coaxial, (0.01, 0.02, 1), 3.945868983699782e-07 / PI**2 / 1e-4),
    (coaxial, (1, 1, 100), 0.0009867630973551228 / PI**2),
    (
        parallel,
        (1, 1, 10),
        0.0031620568387576015,
    ),  # C.parallel_rectangles, and B.etendue_rectangles over pi a b
    (parallel, (2, 1, 1), 0.28587538485071473),
    (parallel, (1, 10, 1), 0.386382489266135),
    (parallel, (1, 1, 0.001), 0.9980056319075797),
    (parallel, (100, 0.01, 1), 0.004968045609095783),
    (parallel, (1, 1, 100000), 3.1830988616257004e-11),
    (parallel, (1, 2, 0.5), 3.198070126842054 / (2 * PI)),
    (parallel, (1, 1, 100), 9.999333389994476e-05 / PI),
    (parallel, (10, 0.1, 1), 0.1467386196838192 / PI),
    (parallel, (1, 1, 1), 0.19982489569838738),
    (perpendicular, (1, 1), 0.20004377607540316),  # C.perpendicular_rectangles: (W, H)
    (perpendicular, (1, 0.5), 0.1461866791057133),
    (perpendicular, (1, 0.01), 0.004895849268506683),
    (perpendicular, (1, 100), 0.2499920427833168),
    (perpendicular, (0.1, 0.1), 0.28188780678790143),
]


@pytest.mark.parametrize(("function", "geometry", "exact"), VIEW_FACTORS)
def test_view_factors_agree_with_references(function, geometry, exact):
    assert agrees(function(*geometry), exact)
    if function is parallel:
        assert agrees(opposed(geometry[:2], geometry[:2], geometry[2]), exact)
    if function is perpendicular:
        assert agrees(perpendicular(*(1e-9 * w for w in geometry), edge=1e-9), exact)


def howell_c13(sides_1, sides_2, distance):
    """Sixteen terms, in mpmath numbers."""

    def term(x, y, z):
        p, r = mp.hypot(x, z), mp.hypot(y, z)
        log = z * z * mp.log(x * x + y * y + z * z) / 2
        return (y * p * mp.atan(y / p) + x * r * mp.atan(x / r) - log) / (2 * mp.pi)

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


@pytest.mark.parametrize(("sides_1", "sides_2", "distance"), OPPOSED)
def test_unequal_opposed_rectangles(sides_1, sides_2, distance):
    with mp.workdps(120):
        exact = howell_c13(sides_1, sides_2, distance)
    value, back = opposed(sides_1, sides_2, distance), opposed(sides_2, sides_1, distance)
    assert agrees(value, exact, 4e-15)
    assert agrees(value * math.prod(sides_1), back * math.prod(sides_2), 4e-15)


@pytest.mark.parametrize(
    ("w", "h"), [(1e-6, 1e-12), (1, 1e-12), (1e12, 1), (1e9, 1e9), (1e-9, 1e9), (1e5, 1e-5)]
)
def test_perpendicular_rectangles_are_stable(w, h):
    def angle(x):
        return mp.sqrt(x) * mp.atan(1 / mp.sqrt(x))

    with mp.workdps(150):
        a, b = mp.mpf(w) ** 2, mp.mpf(h) ** 2
        logs = mp.log((1 + a) * (1 + b) / (1 + a + b))
        for one, other in ((a, b), (b, a)):
            logs += one * mp.log(one * (1 + a + b) / (1 + one) / (one + other))
        exact = (angle(a) + angle(b) - angle(a + b) + logs / 4) / (mp.pi * mp.mpf(w))
    assert agrees(perpendicular(w, h), exact)


# ---- enclosures ----


@pytest.mark.parametrize("size", [(1, 1, 1), (1, 2, 3), (1e-3, 1, 50)])
def test_walls_of_a_box_see_only_each_other(size):
    factors = view_factors.box_view_factors(size)
    areas = np.repeat([size[1] * size[2], size[0] * size[2], size[0] * size[1]], 2)
    assert agrees(factors.sum(axis=1), np.ones(6), 1e-13)
    assert agrees(areas[:, None] * factors + 1, (areas[:, None] * factors).T + 1, 1e-14)


def test_a_closed_box_absorbs_what_it_emits():
    albedos = np.array([0, 0.1, 0.5, 0.9, 0.99, 0.3])
    factors, areas = view_factors.box_view_factors((1.0, 2.0, 3.0)), np.repeat([6.0, 3.0, 2.0], 2)
    emitted = np.array([0, 5.0, 0, 0, 1.0, 0])
    exitance = np.linalg.solve(np.eye(6) - albedos[:, None] * factors, emitted)
    irradiance = factors @ exitance
    assert agrees(enclosures.absorbed_power(albedos, irradiance * areas), emitted @ areas, 1e-13)
    again = enclosures.emitted_exitance(exitance, irradiance, albedos)
    np.testing.assert_allclose(again, emitted, rtol=0, atol=1e-13)
    assert not agrees(
        np.sum(irradiance * areas), emitted @ areas, 1e-2
    )  # all incident light, reflected or not


@pytest.mark.parametrize("albedo", [0.0, 0.5, 0.999, 1 - 1e-12])
def test_a_furnace_is_uniform_whatever_the_shape(albedo):
    factors = view_factors.box_view_factors((1.0, 2.0, 0.1))
    exitance = enclosures.furnace_irradiance(1.0, albedo)
    assert agrees(factors @ np.full(6, exitance), np.full(6, exitance), 1e-13)
    assert agrees(enclosures.furnace_radiance(1.0, albedo) * PI, exitance)
    assert agrees(enclosures.emitted_exitance(exitance, exitance, albedo), 1.0, 1e-15 + 1e-15 / (1 - albedo))
    assert agrees(enclosures.total_flux_in(6.0, albedo), 6 * exitance)
    assert agrees(enclosures.mean_irradiance(6.0, albedo, 6.0), exitance)


@pytest.mark.parametrize(
    ("albedo", "port_share", "exact"),
    [
        (0.9, 0, 9.0),
        (0.95, 0.05, 9.74358974358974),
        (0.99, 0.01, 49.74874371859289),
        (0.999, 1e-4, 908.2643876715714),
    ],
)
def test_an_integrating_sphere_multiplies(albedo, port_share, exact):  # D.integrating_sphere
    assert agrees(enclosures.sphere_wall_exitance(2.0, albedo, 4.0, port_share), exact / 2, 1e-13)
    if port_share == 0:
        whole = 2.0 / 4.0 + enclosures.sphere_wall_exitance(2.0, albedo, 4.0)
        assert agrees(enclosures.sphere_irradiance_of_wall_patch(2.0, albedo, 4.0), whole, 1e-14)
