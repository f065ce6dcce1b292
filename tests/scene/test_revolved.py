"""Surfaces of revolution: areas, bounds, smallest balls and distances, against mpmath and points on the surface."""

import math
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from transport.geometry.revolved import Cone, Cylinder, Paraboloid
from transport.geometry.solid import Sphere
from transport.scene.bins import Positions
from transport.vectors import dot

CENTER, AXIS = (1.0, -2.0, 3.0), (0.3, -0.5, 0.8)
TILTED = {"center": CENTER, "axis": AXIS}
SHAPES = {
    "cylinder": Cylinder(**TILTED, radius=0.7, height=2.0),
    "upright cylinder": Cylinder(radius=2.0, height=0.1),
    "cone": Cone(**TILTED, radius=0.7, height=2.0),
    "cone upside down": Cone(**TILTED, radius=0.0, top_radius=0.3, height=2.0),
    "pointed frustum": Cone(**TILTED, radius=1.2, top_radius=0.2, height=0.5),
    "blunt frustum": Cone(**TILTED, radius=0.9, top_radius=1.2, height=0.5),
    "cone of equal radii": Cone(**TILTED, radius=0.5, top_radius=0.5, height=1.0),
    "flat cone": Cone(**TILTED, radius=0.3, top_radius=1.0, height=1e-3),
    "paraboloid": Paraboloid(**TILTED, focal_length=0.2, radius=1.0),
    "paraboloid ring": Paraboloid(**TILTED, focal_length=0.2, radius=1.0, inner_radius=0.6),
    "flat paraboloid": Paraboloid(**TILTED, focal_length=30.0, radius=1.0),
    "cap": Sphere(**TILTED, radius=0.9, mu_min=0.6),
    "lower cap": Sphere(**TILTED, radius=0.9, mu_max=-0.2),
    "zone": Sphere(**TILTED, radius=0.9, mu_min=-0.3, mu_max=0.5),
    "high zone": Sphere(**TILTED, radius=0.9, mu_min=0.4, mu_max=0.5),
}


def close(exact, rel):
    """Within a relative error alone."""
    return pytest.approx(exact, rel=rel, abs=0)


each_shape = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)


@pytest.fixture(autouse=True)
def many_digits():
    with mpmath.workdps(80):
        yield


def meridian(shape):
    """rho(w) by the shape's definition, in mpmath, and the range of w, the height over the center."""
    half = mpmath.mpf(getattr(shape, "height", 0)) / 2
    match shape:
        case Cylinder():
            return (lambda w: mpmath.mpf(shape.radius)), -half, half
        case Cone():
            r, s = mpmath.mpf(shape.radius), mpmath.mpf(shape.top_radius)
            return (lambda w: r + (s - r) * (w + half) / (2 * half)), -half, half
        case Paraboloid():
            f = mpmath.mpf(shape.focal_length)
            low, high = (mpmath.mpf(r) ** 2 / (4 * f) for r in (shape.inner_radius, shape.radius))
            return (lambda w: mpmath.sqrt(4 * f * abs(w))), low, high
    r = mpmath.mpf(shape.radius)
    return (
        (lambda w: mpmath.sqrt(abs(r * r - w * w))),
        r * mpmath.mpf(shape.mu_min),
        r * mpmath.mpf(shape.mu_max),
    )


def exact_area(shape, low, high):
    """2 pi times the integral of rho sqrt(1 + rho'^2) dw between two heights over the center, in closed form."""
    rho = meridian(shape)[0]
    match shape:
        case Paraboloid():
            f = mpmath.mpf(shape.focal_length)
            return 8 * mpmath.pi / 3 * mpmath.sqrt(f) * ((f + high) ** 1.5 - (f + low) ** 1.5)
        case Sphere():
            return 2 * mpmath.pi * mpmath.mpf(shape.radius) * (high - low)
    return mpmath.pi * (rho(low) + rho(high)) * mpmath.hypot(high - low, rho(high) - rho(low))


def points_on(shape, heights=401, turns=241):
    """Points of the surface, both rims among them, from the definition; and the direction of the axis."""
    rho, low, high = meridian(shape)
    w = np.linspace(float(low), float(high), heights)
    if isinstance(shape, Sphere):
        w = shape.radius * np.cos(np.linspace(math.acos(shape.mu_min), math.acos(shape.mu_max), heights))
    r, turn = np.array([float(rho(x)) for x in w]), np.linspace(0, 2 * math.pi, turns)
    e_u, e_v, axis = map(np.array, shape.frame)
    around = np.cos(turn)[:, None] * e_u + np.sin(turn)[:, None] * e_v
    return (np.array(shape.center) + w[:, None, None] * axis + r[:, None, None] * around).reshape(-1, 3)


@each_shape
def test_profile_is_the_definition(shape):
    rho, low, high = meridian(shape)
    profile = shape.profile
    assert profile.low + profile.lift == pytest.approx(float(low), rel=1e-15, abs=1e-15 * shape.extent)
    assert profile.high + profile.lift == pytest.approx(float(high), rel=1e-15, abs=1e-15 * shape.extent)
    origin = np.add(shape.center, np.multiply(shape.axis, profile.lift))
    assert profile.origin == close(origin, 1e-15)
    for share in (0.0, 0.1, 0.5, 0.9, 1.0):
        w = profile.low + share * (profile.high - profile.low)
        exact = float(rho(mpmath.mpf(w) + mpmath.mpf(profile.lift)))
        assert profile.radius_at(w) == pytest.approx(exact, rel=1e-14, abs=1e-15 * shape.extent)
        by_form = profile.alpha + profile.beta * w + profile.gamma * w * w
        assert by_form == pytest.approx(exact**2, rel=1e-14, abs=1e-15 * shape.extent**2)
        assert abs(profile.signed_distance(profile.radius_at(w), w)) < 1e-15 * shape.extent


@each_shape
def test_area_is_that_of_the_definition(shape):
    rho, low, high = meridian(shape)
    exact = exact_area(shape, low, high)
    steps = 64  # the closed form against the definition: bands of cone frusta
    heights = [low + (high - low) * (mpmath.mpf(k) / steps) ** 2 for k in range(steps + 1)]
    if isinstance(shape, Sphere):
        heights = [shape.radius * mpmath.cos(k * mpmath.pi / steps) for k in range(steps + 1)]
        heights = sorted(h for h in {*heights, low, high} if low <= h <= high)
    bands = [
        mpmath.pi * (rho(p) + rho(q)) * mpmath.hypot(q - p, rho(q) - rho(p)) for p, q in pairwise(heights)
    ]
    assert float(mpmath.fsum(bands)) == close(float(exact), 2e-3)
    assert shape.area == close(float(exact), 1e-15)
    profile = shape.profile
    assert 2 * math.pi * profile.area_per_radian(profile.low, profile.high) == close(shape.area, 2e-15)


NEARLY = {
    "nearly a cylinder": Cone(radius=1.0, top_radius=1.0 + 1e-9, height=3.0),
    "nearly a disk": Cone(radius=1.0, top_radius=0.1, height=1e-9),
    "needle": Cone(radius=1e-9, height=1.0),
    "far paraboloid": Paraboloid(focal_length=1e9, radius=1.0),
    "deep paraboloid": Paraboloid(focal_length=1e-9, radius=1.0),
}


@pytest.mark.parametrize("shape", [*SHAPES.values(), *NEARLY.values()], ids=[*SHAPES, *NEARLY])
def test_narrow_bands_keep_their_areas(shape):
    """Bins of 1e-9 of the height, whose area as a difference of two would keep seven digits."""
    whole = Positions(u=1).edges(shape)["u"]
    for share in (0.0, 0.3, 0.999):
        lower = whole[0] + share * (whole[1] - whole[0])
        edges = [mpmath.mpf(float(x)) for x in (lower, lower + 1e-9 * (whole[1] - whole[0]))]
        heights = edges
        if isinstance(shape, Sphere):
            heights = [shape.radius * mpmath.cos(edge) for edge in reversed(edges)]
        [area] = Positions(u=edges).areas(shape)
        assert area == close(
            float(exact_area(shape, *heights)), 1e-12 if isinstance(shape, Sphere) else 1e-14
        )


@each_shape
def test_bins_of_position_add_up_to_the_area(shape):
    positions = Positions(u=7, v=3)
    areas = positions.areas(shape)
    assert areas.shape == (7, 3)
    assert areas.sum() == close(shape.area, 2e-15)
    assert areas[:, 0] == close(areas[:, 2], 1e-15)
    _, low, high = meridian(shape)
    edges = positions.edges(shape)["u"]
    if isinstance(shape, Sphere):
        assert np.cos(edges[[-1, 0]]) * shape.radius == close([float(low), float(high)], 1e-14)
    else:
        assert edges[[0, -1]] == pytest.approx([float(low), float(high)], rel=1e-15, abs=0)
        exact = [float(exact_area(shape, mpmath.mpf(p), mpmath.mpf(q))) / 3 for p, q in pairwise(edges)]
        assert areas[:, 1] == close(exact, 1e-13)


@pytest.mark.quick_cases("cylinder", "upright cylinder")
@each_shape
def test_bounds_the_ball_about_the_middle_and_distances_are_those_of_points_of_the_surface(shape):
    points, (lower, upper) = points_on(shape), np.array(shape.bounds)
    rounding = 1e-15 * (shape.extent + 4)
    assert (points >= lower - rounding).all() and (points <= upper + rounding).all()
    assert points.min(axis=0) == pytest.approx(lower, abs=3e-4 * shape.extent)
    assert points.max(axis=0) == pytest.approx(upper, abs=3e-4 * shape.extent)

    def reach(step):
        """The farthest point from another one of the axis than the middle."""
        other = np.add(shape.middle, np.multiply(shape.axis, step * shape.extent))
        return np.linalg.norm(points - other, axis=1).max()

    assert reach(0.0) == close(shape.extent, 1e-14) and min(reach(1e-3), reach(-1e-3)) > shape.extent
    draws = np.random.default_rng(7)
    away = np.array(shape.middle) + draws.normal(size=(25, 3)) * shape.extent
    for place in (*away, np.array(shape.center), np.array(shape.profile.origin)):
        found, near = shape.distance(tuple(place)), np.linalg.norm(points - place, axis=1).min()
        assert near - 2e-2 * shape.extent < found <= near + 1e-14 * (shape.extent + 4)
    for place in points[:: len(points) // 40]:
        assert shape.distance(tuple(place)) < 1e-15 * (shape.extent + 7)


@given(st.floats(0.01, 10), st.floats(0, 10), st.floats(0.01, 10), st.floats(0, 3), st.floats(-10, 10))
def test_distance_to_a_paraboloid_is_stationary_or_at_a_rim(focal_length, inner, width, rho, w):
    """Where the nearest point is not on a rim the way to it is along the normal (1, -rho/2f)."""
    shape = Paraboloid(focal_length=focal_length, inner_radius=inner, radius=inner + width)
    found = shape.distance((rho, 0.0, w))
    radii = np.linspace(inner, inner + width, 2001)
    apart = np.hypot(radii - rho, radii**2 / (4 * focal_length) - w)
    assert found <= apart.min() * (1 + 1e-12) + 1e-14
    step = width / 2000 * math.hypot(1, (inner + width) / (2 * focal_length))
    assert found >= apart.min() - step


@pytest.mark.parametrize("focal_length", [1e-6, 1.0, 1e6])
def test_points_of_a_paraboloid_are_on_it_however_flat_or_deep(focal_length):
    shape = Paraboloid(focal_length=focal_length, radius=1.0)
    for r in (0.0, 1e-9, 0.3, 0.999, 1.0):
        assert shape.distance((r, 0.0, r * r / 4 / focal_length)) < 1e-15 * shape.extent
    assert shape.distance((0.3, 0.0, 0.09 / 4 / focal_length - 1e-3)) < 1e-3 + 1e-15 * shape.extent


def test_the_focus_gathers_what_comes_along_the_axis():
    """Path length from a plane across the axis to the focus: equal for all rays."""
    shape = Paraboloid(**TILTED, focal_length=0.4, radius=1.0)
    points = points_on(shape)
    down = np.array([5 - dot(np.subtract(p, CENTER), shape.axis) for p in points])
    assert down + np.linalg.norm(points - shape.focus, axis=1) == close(5.4, 1e-14)


def test_a_pointed_cone_is_described_from_its_apex():
    """From the center rho^2 would cancel: of a radius of 1e-9 nothing would be left."""
    cone = Cone(**TILTED, radius=1.0, top_radius=1e-9, height=2.0)
    profile = cone.profile
    assert (profile.alpha, profile.beta) == (0.0, 0.0)
    assert profile.radius_at(profile.high) == close(1e-9, 1e-14)
    assert profile.radius_at(profile.low) == close(1.0, 1e-14)
    mean, slope = 0.5 * (1 + 1e-9), 0.5 * (1e-9 - 1)
    assert abs(mean * mean + 2 * mean * slope + slope * slope - 1e-18) > 1e-17
    assert Cone(radius=1.0, height=1.0).profile.high == 0.0
    assert Cone(radius=0.0, top_radius=1.0, height=1.0).profile.low == 0.0


def test_a_zone_is_a_zone_and_a_whole_sphere_is_closed():
    whole, cap = Sphere(radius=2.0), Sphere(radius=2.0, mu_min=0.0)
    assert whole.is_closed and not whole.is_zone and not cap.is_closed and cap.is_zone
    assert Sphere(radius=2.0, mu_min=-1, mu_max=1) == whole
    assert (whole.profile.low, whole.profile.high) == (-2.0, 2.0)
    assert whole.bounds == ((-2.0,) * 3, (2.0,) * 3) and whole.area == 2 * cap.area
    assert cap.middle == (0, 0, 0) and cap.extent == 2.0
    assert Sphere(radius=5.0, mu_min=0.8).middle == close((0, 0, 4), 1e-15)
    assert Sphere(radius=5.0, mu_min=0.8).extent == close(3, 1e-15)
