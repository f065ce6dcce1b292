"""Where rays meet planes, spheres and boxes, against 50 digits: errors in units of rounding (2^-53).

A crossing cannot be known better than its ray.  So errors are measured against what rounding the ray itself would do:
for a plane |Δt cosθ| against the lengths that go in, for a sphere how far the point found lies off the sphere,
against the distance of the ray's origin.  The textbook quadratic fails these tests by many orders.
"""

from __future__ import annotations

import itertools
import math

import mpmath as mp
import numpy as np
import pytest

from transport.physics.rays import box_crossings, plane_crossing, sphere_crossing

ROUNDING = 2.0**-53
DIGITS = 50
PLANE_LIMIT = 4  # roundings; measured 2.3
SPHERE_LIMIT = 12  # measured 8.5
BOX_LIMIT = 4  # measured 2.3
over_planes, over_spheres, over_boxes = (
    np.vectorize(function, otypes=[float] * count)
    for function, count in ((plane_crossing, 4), (sphere_crossing, 1), (box_crossings, 4))
)


def plane(r, u, n):
    """Distance and place (t, x, y, z) of each crossing."""
    with np.errstate(all="ignore"):
        return np.stack(over_planes(*r.T, *u.T, *n.T), axis=1)


def sphere(o, u, radius=1.0, start=0.0, standing=False):
    with np.errstate(all="ignore"):
        return over_spheres(*o.T, *u.T, radius, start, standing, start, False, False)


def units(count, rng):
    v = rng.normal(size=(count, 3))
    return v / np.sqrt((v**2).sum(axis=1, keepdims=True))


def across(u, rng):
    """Unit vectors at right angles to u."""
    v = np.cross(u, units(len(u), rng))
    return v / np.sqrt((v**2).sum(axis=1, keepdims=True))


def size(vectors):
    return np.sqrt((np.asarray(vectors, float) ** 2).sum(axis=-1))


def exact_vector(v):
    return mp.matrix([mp.mpf(float(x)) for x in v])


def dot(a, b):
    return mp.fsum(x * y for x, y in zip(a, b, strict=True))


def rays_past(impact, distance, rng, radius=1.0):
    """Rays towards a sphere at the origin: closest approach `impact` radii, origin `distance` radii before it."""
    u = units(len(distance), rng)
    o = (impact * radius)[:, None] * across(u, rng) - (distance * radius)[:, None] * u
    return o, u


def off_sphere(o, u, t, radius=1.0):
    """Distance of the points at t from the sphere, over the distance of the ray's origin or the radius; exact."""
    with mp.workdps(DIGITS):
        gaps = []
        for a, b, s in zip(o, u, t, strict=True):
            p = exact_vector(a) + mp.mpf(float(s)) * exact_vector(b)
            gaps.append(abs(float(mp.sqrt(dot(p, p)) - mp.mpf(radius))) / max(float(size(a)), radius))
    return np.array(gaps)


def textbook_sphere(o, u, radius):
    """The nearer root of t^2 + 2 h t + o^2 - r^2 = 0 as it stands."""
    h = (o * u).sum(axis=1)
    return -h - np.sqrt(np.maximum(h * h - ((o**2).sum(axis=1) - radius**2), 0))


def test_a_ray_meets_a_plane_where_it_does():
    """Distances and positions over all inclinations down to 1e-9, near and far planes."""
    rng = np.random.default_rng(1)
    count = 300
    n, r = units(count, rng), units(count, rng) * 10 ** rng.uniform(-12, 12, (count, 1))
    mu = 10 ** rng.uniform(-9, 0, count) * rng.choice([-1, 1], count)
    u = mu[:, None] * n + np.sqrt(1 - mu**2)[:, None] * across(n, rng)
    found = plane(r, u, n)
    with mp.workdps(DIGITS):
        for k in range(count):
            a, b, c = map(exact_vector, (r[k], u[k], n[k]))
            cosine, t = dot(b, c), dot(a, c) / dot(b, c)
            scale = (float(size(r[k])) + abs(float(t))) * ROUNDING
            assert abs(float((mp.mpf(float(found[k, 0])) - t) * cosine)) <= PLANE_LIMIT * scale
            position = exact_vector(found[k, 1:])
            off = [float(x) for x in (position - (t * b - a)) * cosine]
            assert size(off) <= PLANE_LIMIT * scale


def test_a_ray_at_right_angles_meets_a_plane_to_the_last_places():
    """Without an inclination the distance is good relatively, whatever the scale."""
    rng = np.random.default_rng(2)
    n = units(200, rng)
    d = 10 ** rng.uniform(-12, 12, 200)
    found = plane(d[:, None] * n, n, n)
    assert np.abs(found[:, 0] / d - 1).max() <= PLANE_LIMIT * ROUNDING
    assert (size(found[:, 1:]) <= PLANE_LIMIT * ROUNDING * d).all()


@pytest.mark.parametrize("height", [1.0, 0.0, -1.0])
def test_a_ray_parallel_to_a_plane_meets_it_nowhere(height):
    """Infinity or NaN: no comparison of the form `start < t < nearest` takes it."""
    r, u, n = np.array([[0.3, 0.2, height]]), np.array([[0.6, 0.8, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    t, x, y, z = plane(r, u, n)[0]
    assert not (0 < t < math.inf)
    assert not abs(x) <= 1e300
    assert not x * x + y * y + z * z <= 1e300


@pytest.mark.parametrize("decades", [0, 3, 6, 9, 12])
def test_the_point_found_lies_on_the_sphere_near_and_far(decades):
    """A sphere seen from up to 1e12 of its radii: off by roundings of the distance; never a ray lost inside the rim."""
    rng = np.random.default_rng(decades)
    impact = np.concatenate((rng.uniform(0, 1, 150), 1 - 10 ** rng.uniform(-12, 0, 50)))
    distance = 1.0001 * 10 ** rng.uniform(max(0, decades - 1), decades, 200) + 1
    blur = 8 * distance * ROUNDING  # what rounding the ray's direction does to its closest approach
    impact = np.minimum(impact, 1 - blur)
    o, u = rays_past(np.maximum(impact, 0), distance, rng)
    t = sphere(o, u)
    assert np.isfinite(t)[impact > blur].all()
    assert off_sphere(o, u, t).max() <= SPHERE_LIMIT * ROUNDING
    assert (t <= distance * (1 + 8 * ROUNDING)).all()  # the nearer of the two
    beyond = sphere(o, u, start=t)  # the other one
    assert off_sphere(o, u, beyond).max() <= SPHERE_LIMIT * ROUNDING
    assert (beyond >= t).all()
    if decades >= 6:
        assert off_sphere(o, u, textbook_sphere(o, u, 1.0)).max() > 1000 * SPHERE_LIMIT * ROUNDING


def test_a_ray_outside_the_rim_or_away_misses_the_sphere():
    rng = np.random.default_rng(21)
    distance = 10 ** rng.uniform(0, 12, 300)
    gap = 1e-14 + 8 * distance * ROUNDING
    for impact, before in (
        (1 + gap * 10 ** rng.uniform(0, 3, 300), distance),
        (rng.uniform(0, 1, 300), -(distance + 1)),
    ):
        assert np.isinf(sphere(*rays_past(impact, before, rng))).all()


@pytest.mark.parametrize("radius", [1e-12, 1.0, 1e12])
def test_from_inside_a_sphere_there_is_always_one_way_out(radius):
    """From the middle to 1e-12 below the surface, in all directions, grazing ones too."""
    rng = np.random.default_rng(22)
    depth = np.concatenate((rng.uniform(0, 1, 200), 10 ** rng.uniform(-12, 0, 200)))
    o, u = (1 - depth)[:, None] * units(400, rng) * radius, units(400, rng)
    u[200:] = across(o[200:], rng)
    t = sphere(o, u, radius)
    assert (t > 0).all()
    assert off_sphere(o, u, t, radius).max() <= SPHERE_LIMIT * ROUNDING
    with mp.workdps(DIGITS):  # the distance itself, where the ray is not grazing
        for k in range(200):
            a, b = exact_vector(o[k]), exact_vector(u[k])
            h, c, w = dot(a, b), dot(a, a) - mp.mpf(radius) ** 2, dot(b, b)
            exact = (-h + mp.sqrt(h * h - w * c)) / w
            assert abs(float(mp.mpf(float(t[k])) - exact)) <= 40 * ROUNDING * radius


def on_sphere(count, rng, inwards):
    """Particles on the unit sphere, to rounding, and directions into it or out of it; some of them grazing."""
    n = units(count, rng)
    mu = np.concatenate((rng.uniform(0, 1, count // 2), 10 ** rng.uniform(-12, 0, count - count // 2)))
    mu = -mu if inwards else mu
    return n, mu[:, None] * n + np.sqrt(1 - mu**2)[:, None] * across(n, rng), mu


def test_a_particle_that_stands_on_a_sphere_meets_it_again_only_across():
    """t = 2 |mu|, also for chords of 1e-12 radii, which the quadratic cannot tell from nothing."""
    rng = np.random.default_rng(23)
    o, u, mu = on_sphere(400, rng, inwards=True)
    t = sphere(o, u, standing=True)
    assert np.abs(t + 2 * mu).max() <= SPHERE_LIMIT * ROUNDING
    assert (t > 0).all()
    assert off_sphere(o, u, t).max() <= SPHERE_LIMIT * ROUNDING
    o, u, _ = on_sphere(400, rng, inwards=False)
    assert np.isinf(sphere(o, u, standing=True)).all()


@pytest.mark.parametrize("ahead", [1e-3, 1.0, 1e3, 1e6])
def test_an_aimed_particle_meets_spheres_from_where_it_stands_behind_the_origin_of_its_ray(ahead):
    """Its ray has its origin at the target, and the particle is at start < 0: on a sphere, or before another one."""
    rng = np.random.default_rng(24)
    blur = SPHERE_LIMIT * ROUNDING * max(1, ahead)
    o, u, mu = on_sphere(400, rng, inwards=True)
    t, deep = sphere(o + ahead * u, u, start=-ahead, standing=True), -2 * mu > 4 * blur
    assert np.abs(t + ahead + 2 * mu)[deep].max() <= 2 * blur
    assert off_sphere(o + ahead * u, u, t)[deep].max() <= SPHERE_LIMIT * ROUNDING
    o, u, mu = on_sphere(400, rng, inwards=False)
    assert np.isinf(sphere(o + ahead * u, u, start=-ahead, standing=True))[2 * mu > 4 * blur].all()
    o, u = rays_past(rng.uniform(0, 0.9, 300), np.full(300, 3.0), rng)
    moved = sphere(o + ahead * u, u, start=-ahead)
    assert np.abs(moved + ahead - sphere(o, u)).max() <= 4 * blur
    assert np.isinf(sphere(o + (3 + ahead) * u, u, start=2.0)).all()  # behind


def exact_box(o, u, h):
    """Entry and exit by 50 digits; axes to which the ray is parallel only say whether it can meet the box at all."""
    near, far = (-mp.inf, 0), (mp.inf, 0)
    for a, b, c in zip(*(exact_vector(v) for v in (o, u, h)), strict=True):
        if b == 0:
            if abs(a) > c:
                return None
            continue
        first, last = sorted(((-c - a) / b, (c - a) / b))
        near, far = max(near, (first, abs(b))), min(far, (last, abs(b)))
    return (*near, *far)


def agrees_with_box(o, u, h):
    with np.errstate(all="ignore"):
        found = np.stack(over_boxes(*o.T, *u.T, *h.T), axis=1)
    with mp.workdps(DIGITS):
        for k in range(len(o)):
            exact = exact_box(o[k], u[k], h[k])
            if exact is None:
                assert not found[k, 0] <= found[k, 2], f"o {o[k]}, u {u[k]}, h {h[k]}: {found[k]} should miss"
                continue
            scale = ROUNDING * (size(o[k]) + size(h[k]))
            for i in (0, 2):
                assert found[k, i + 1] == float(exact[i + 1]), f"o {o[k]}, u {u[k]}, h {h[k]}: {found[k]}"
                off = abs(float((mp.mpf(float(found[k, i])) - exact[i]) * exact[i + 1]))
                assert off <= BOX_LIMIT * scale, f"o {o[k]}, u {u[k]}, h {h[k]}: {found[k]}"
    return found


@pytest.mark.parametrize("decades", [0, 6, 12])
def test_a_ray_enters_and_leaves_a_box_where_it_does(decades):
    """From inside and from up to 1e12 of its sizes; entry and exit lie on the faces to roundings of the distance."""
    rng = np.random.default_rng(31 + decades)
    h = 10 ** rng.uniform(-1, 1, (300, 3))
    goal = rng.uniform(-1, 1, (300, 3)) * h
    u = units(300, rng)
    o = goal - rng.uniform(0, 10.0**decades, (300, 1)) * u
    found = agrees_with_box(o, u, h)
    assert (found[:, 0] <= found[:, 2]).mean() > (0.99 if decades < 12 else 0.9)
    aside = agrees_with_box(o + 10 * across(u, rng) * size(h)[:, None], u, h)
    assert (aside[:, 0] > aside[:, 2]).all()


def test_a_ray_parallel_to_the_faces_of_a_box_meets_the_others():
    """Hits from inside and outside, misses beside: a component of 0 is a direction like others."""
    ways = [(0, 0, 1), (0, 0, -1), (-1, 0, 0), (0, 0.6, 0.8), (-0.6, 0, 0.8), (-0.0, -0.0, 1)]
    places = [(0, 0, 0), (0.1, 0.2, -0.3), (0, 0, -5), (0.1, -0.2, 5), (5, 0.1, 0), (3, 0.2, -5)]
    o, u = (np.array(each, float) for each in zip(*itertools.product(places, ways), strict=True))
    agrees_with_box(o, u, np.full((36, 3), [1.0, 0.5, 2.0]))
