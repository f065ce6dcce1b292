"""tp.solid_angle counts what closed forms say, from anywhere and at any scale; the forms hold where terms cancel.

A comment such as `B.solid_angle_cap` names the entry of the project's reference collection that a number comes from.
Each statistical test fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_z_spread
from transport.theory import solid_angles

FALSE_ALARM = 1e-5
ORIGIN = (0.0, 0.0, 0.0)
TRIANGLES = {  # B.solid_angle_triangle
    "octant": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "generic": ((1, 0.2, 1.5), (-0.7, 1.1, 2.0), (0.3, -1.3, 0.8)),
    "sliver": ((1, 0, 1), (1, 1e-4, 1), (0, 1, 1)),
    "near hemisphere": (
        (1, 0, 0.001),
        (-0.5, 0.8660254037844386, 0.001),
        (-0.5, -0.8660254037844386, 0.001),
    ),
}
VALUES = {"octant": 1.5707963267948966, "generic": 0.6524030913100265}  # B.solid_angle_triangle


@pytest.fixture(autouse=True)
def sixty_digits():
    with mp.workdps(60):
        yield


def counted(shape, position, particles=400_000, seed=1):
    return tp.solid_angle(shape, position, particles=particles, seed=seed)


def oosterom(vertices, position=ORIGIN):
    """The formula of Van Oosterom and Strackee, in 60 digits."""
    a, b, c = (
        [mp.mpf(float(x)) - mp.mpf(float(p)) for x, p in zip(v, position, strict=True)] for v in vertices
    )
    volume = mp.det(mp.matrix([a, b, c]))
    length_a, length_b, length_c = (mp.sqrt(mp.fdot(v, v)) for v in (a, b, c))
    below = length_a * length_b * length_c
    below += mp.fdot(a, b) * length_c + mp.fdot(b, c) * length_a + mp.fdot(c, a) * length_b
    return abs(2 * mp.atan2(volume, below))


# ---- the closed forms ----


@pytest.mark.parametrize("name", TRIANGLES)
def test_a_triangle_follows_van_oosterom_and_strackee(name):
    value = solid_angles.triangle_solid_angle(TRIANGLES[name])
    assert value == pytest.approx(float(oosterom(TRIANGLES[name])), rel=1e-15)
    if name in VALUES:
        assert value == pytest.approx(VALUES[name], rel=1e-13)


def hard_triangles():
    """Slivers, far triangles, points close to a vertex, to an edge and to the plane: 30 of each."""
    random = np.random.default_rng(1)
    for _ in range(30):
        v, w = random.normal(size=(3, 3)), random.normal(size=3)
        yield "sliver", (v[0], v[0] + 1e-9 * w, v[2]), random.normal(size=3)
        yield "needle", (v[0], v[1], 0.3 * v[0] + 0.7 * v[1] + 1e-12 * w), random.normal(size=3)
        yield "far", v, 1e8 * w
        yield "at a vertex", v, v[0] + 1e-10 * w
        yield "at an edge", v, v[0] + random.random() * (v[1] - v[0]) + 1e-11 * w
        flat = v * (1, 1, 0)
        yield "at the plane", flat, flat.mean(axis=0) + (0, 0, 1e-13)


def test_no_triangle_is_too_thin_too_far_or_too_near():
    def off(value, exact):
        return float(abs(value - exact) / exact)

    worst, plain = {}, {}
    for name, vertices, position in hard_triangles():
        exact = oosterom(vertices, position)
        worst[name] = max(
            worst.get(name, 0), off(solid_angles.triangle_solid_angle(vertices, position), exact)
        )
        a, b, c = np.array(vertices) - position
        u, v, w = (x / np.linalg.norm(x) for x in (a, b, c))
        textbook = 2 * math.atan2(abs(u @ np.cross(v, w)), 1 + u @ v + v @ w + w @ u)
        plain[name] = max(plain.get(name, 0), off(textbook, exact))
    assert max(worst.values()) < 1e-15
    # the formula as it stands, in doubles, cancels
    assert min(plain[name] for name in ("sliver", "needle", "far", "at an edge")) > 1e-12


def test_a_point_in_the_plane_sees_all_or_nothing_and_one_on_the_edge_neither():
    square = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    assert solid_angles.polygon_solid_angle(square, (0.3, 0.6, 0)) == 2 * math.pi
    assert solid_angles.polygon_solid_angle(square, (1.5, 0.5, 0)) == 0
    assert math.isnan(solid_angles.polygon_solid_angle(square, (0.5, 0, 0)))


def test_a_polygon_need_not_be_convex():
    dart = [(0, 0, 1), (2, 0, 1), (0.5, 0.5, 1), (0, 2, 1)]
    parts = [solid_angles.triangle_solid_angle([dart[i] for i in part]) for part in ((0, 1, 2), (0, 2, 3))]
    for turn in range(4):  # whichever vertex the fan starts from
        turned = dart[turn:] + dart[:turn]
        assert solid_angles.polygon_solid_angle(turned) == pytest.approx(sum(parts), rel=1e-14)


def test_regular_polygons_lie_between_a_triangle_and_a_disk():
    assert solid_angles.regular_polygon_solid_angle(4, math.sqrt(0.5), 1) == pytest.approx(
        0.8054316831613233, rel=1e-15
    )  # B.solid_angle_rectangle
    for sides in (3, 5, 12):
        angles = 2 * math.pi * np.arange(sides) / sides
        corners = np.stack([0.7 * np.cos(angles), 0.7 * np.sin(angles), np.full(sides, 0.4)], axis=1)
        by_fan = solid_angles.polygon_solid_angle(corners)
        assert solid_angles.regular_polygon_solid_angle(sides, 0.7, 0.4) == pytest.approx(by_fan, rel=1e-14)
    round_one = solid_angles.regular_polygon_solid_angle(100_000, 0.7, 0.4)
    assert round_one == pytest.approx(solid_angles.disk_solid_angle(0.7, 0.4), rel=1e-8)
    assert solid_angles.regular_polygon_solid_angle(3, 1e-9, 1) == pytest.approx(
        3**1.5 / 4 * 1e-18, rel=1e-14
    )


def test_a_dodecahedron_has_twelve_faces_of_a_twelfth_of_the_sphere():
    faces = solid_angles.dodecahedron_faces(2.5)
    assert faces.shape == (12, 5, 3)
    assert np.allclose(np.linalg.norm(faces, axis=2), 2.5, rtol=1e-15)
    edges = np.linalg.norm(np.roll(faces, -1, axis=1) - faces, axis=2)
    assert np.allclose(edges, edges[0, 0], rtol=1e-14)
    for face in faces:
        assert solid_angles.polygon_solid_angle(face) == pytest.approx(4 * math.pi / 12, rel=1e-14)
        assert np.cross(face[1] - face[0], face[2] - face[1]) @ face[0] > 0  # counterclockwise from outside
    assert round(solid_angles.DODECAHEDRON_FACE, 4) == 1.0472


# ---- counting ----


@pytest.mark.parametrize("name", TRIANGLES)
def test_a_triangle_is_counted(name):
    exact = solid_angles.triangle_solid_angle(TRIANGLES[name])
    found = counted(tp.Triangle(vertices=TRIANGLES[name]), ORIGIN)
    assert found.unit == tp.Unit.parse("sr")
    assert 0 < found.relative_error < 0.01
    assert_agrees(found, exact, FALSE_ALARM)
    turned = tp.Triangle(vertices=TRIANGLES[name][::-1])  # seen from its other side
    assert_agrees(counted(turned, ORIGIN), exact, FALSE_ALARM)


def test_a_ball_fills_a_cap_exactly():
    for angle, exact in ((0.01, 9.569838457281188e-08), (30, 0.8417872144769327), (60, 3.1415926535897922)):
        found = counted(tp.Sphere(radius=3), (0, 0, 3 / math.sin(math.radians(angle))), particles=10_000)
        assert found.exact
        assert found.value == pytest.approx(exact, rel=1e-13)  # B.solid_angle_cap


@pytest.mark.parametrize(
    "shape", [tp.Sphere(center=(1, 2, 3), radius=2), tp.Box(center=(1, 2, 3), size=(2, 3, 4))]
)
def test_from_within_a_closed_shape_all_directions_count(shape):
    found = counted(shape, (1.5, 1.3, 4), particles=10_000)
    assert found.exact
    assert found.value == pytest.approx(4 * math.pi, rel=1e-15)


def disk(radius, distance):
    return solid_angles.disk_solid_angle(radius, distance)


def disk_from_beside():
    """From beside its axis, by quadrature."""
    x, w = np.polynomial.legendre.leggauss(60)
    r, turn = 0.4 * (x + 1), math.pi * (x[:, None] + 1)
    cube = ((r * np.cos(turn) + 1.5) ** 2 + (r * np.sin(turn)) ** 2 + 0.25) ** 1.5
    return float((0.5 * r / cube * w * 0.4).sum(axis=1) @ w * math.pi)


def box_from(position):
    """A box of (2, 3, 4), by the polygons of its faces."""
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1.5, 1.5) for z in (-2, 2)])
    faces = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
    return sum(solid_angles.polygon_solid_angle(corners[list(face)], position) for face in faces) / 2


TUBE, CONE = tp.Cylinder(radius=1, height=2), tp.Cone(radius=1, top_radius=0.5, height=2)
DISH, CAP = tp.Paraboloid(focal_length=0.5, radius=1, inner_radius=0.25), tp.Sphere(radius=2, mu_min=0.5)
ABOVE = {"center": (0, 0, 1)}
COUNTED = {  # a shape, a position, the solid angle; of hollow shapes by the disks of their rims
    "square": (tp.Rectangle(**ABOVE, width=1, height=1), ORIGIN, 0.8054316831613233),  # B.solid_angle_rectangle
    "large square": (tp.Rectangle(**ABOVE, width=100, height=100), ORIGIN, 6.170067073507106),
    "strip": (tp.Rectangle(**ABOVE, width=1000, height=0.01), ORIGIN, 0.01999979333595329),
    "disk": (tp.Disk(**ABOVE, radius=0.8), ORIGIN, disk(0.8, 1)),
    "ring": (tp.Disk(**ABOVE, radius=0.8, inner_radius=0.7), ORIGIN, disk(0.8, 1) - disk(0.7, 1)),
    "disk from beside": (tp.Disk(radius=0.8), (-1.5, 0, -0.5), disk_from_beside()),
    "disk from close by": (tp.Disk(radius=1), (0.3, -0.2, 1e-9), 2 * math.pi * (1 - 1e-9)),
    **{  # the last in the plane of a face, which is edge-on then
        f"box from {place}": (tp.Box(size=(2, 3, 4)), place, box_from(place))
        for place in ((3, 0, 0), (2, 3, -1), (1.0 + 1e-9, 0.2, 0.9), (1, 4, 0))
    },
    "tube from afar": (TUBE, (0, 0, 5), disk(1, 4) - disk(1, 6)),
    "tube from within": (TUBE, (0, 0, 0.5), 4 * math.pi - disk(1, 0.5) - disk(1, 1.5)),
    "cone from below": (CONE, (0, 0, -4), disk(1, 3) - disk(0.5, 5)),
    "cone from above, its inside": (CONE, (0, 0, 2), disk(0.5, 1) - disk(1, 3)),
    "cone from higher, its outside": (CONE, (0, 0, 4), disk(1, 5) - disk(0.5, 3)),
    "whole cone from below": (tp.Cone(radius=1, height=2), (0, 0, -4), disk(1, 3)),
    "dish": (DISH, (0, 0, 5), disk(1, 4.5) - disk(0.25, 5 - 0.03125)),
    "cap from above": (CAP, (0, 0, 9), disk(math.sqrt(3), 8)),
    "cap from below": (CAP, (0, 0, -3), disk(math.sqrt(3), 4)),
    "zone from its center": (tp.Sphere(radius=2, mu_min=-0.3, mu_max=0.5), ORIGIN, 1.6 * math.pi),
}  # fmt: skip


@pytest.mark.quick_cases("square", "large square")
@pytest.mark.parametrize("name", COUNTED)
def test_a_shape_counts_once_in_each_direction(name):
    shape, position, exact = COUNTED[name]
    found = counted(shape, position)
    assert_agrees(found, exact, FALSE_ALARM)
    assert found.relative_error < (0.1 if name == "strip" else 0.02)


def test_a_tube_from_the_side_counts_once():
    """The near wall hides the far one; planted: a meter that lets through counts both."""
    away, radius, half = 3.0, TUBE.radius, TUBE.height / 2
    with mp.workdps(20):

        def height_seen(turn):
            near = away * mp.cos(turn) - mp.sqrt(radius**2 - (away * mp.sin(turn)) ** 2)
            return 2 * mp.sin(mp.atan2(half, near))

        edge = mp.asin(radius / away)
        exact = float(2 * mp.quad(height_seen, [0, edge * 0.9, edge]))
    assert_agrees(counted(TUBE, (away, 0, 0)), exact, FALSE_ALARM)
    lamp = tp.Source(tp.Point(position=(away, 0, 0)), tp.Isotropic(power=4 * math.pi))
    meter = tp.simulate(tp.Scene(lamp, (), tp.Detector(TUBE, "m")), particles=100_000, seed=1)["m"]
    assert (meter.flux_in + meter.flux_out).value > 1.5 * exact


@pytest.mark.parametrize("position", [(3, 0, 0.2), (0.55, 0.1, 0.9), (0.1, 0.2, 0.3)])
def test_a_mesh_fills_what_its_analytic_twin_fills(position):
    found = counted(tp.Mesh.box(size=1), position, 200_000)
    if max(position) < 0.5:
        assert found.exact and found.value == pytest.approx(4 * math.pi, rel=1e-15)
    else:
        twin = counted(tp.Box(size=1), position, 200_000, seed=2)
        assert abs(found.value - twin.value) < 4.5 * math.hypot(found.error, twin.error)


def test_a_mesh_that_few_particles_miss_is_not_reported_to_fill_nothing_exactly():
    """Planted in effect: a position outside of a closed mesh, but within the ball about it, where nothing is aimed."""
    needle = tp.Mesh.box(size=(1, 1e-4, 1e-4))
    found = counted(needle, (0, 0.3, 0), particles=64)
    assert found.value == 0 and not found.exact and math.isnan(found.error)


@pytest.mark.parametrize("size", [1e-12, 1e12])
def test_the_unit_of_length_does_not_matter(size):
    vertices = TRIANGLES["generic"]
    scaled = tp.Triangle(vertices=size * np.array(vertices))
    found, usual = counted(scaled, ORIGIN, 10_000), counted(tp.Triangle(vertices=vertices), ORIGIN, 10_000)
    assert found.value == pytest.approx(usual.value, rel=1e-12)


def test_from_afar_all_rays_weigh_the_same():
    assert counted(tp.Disk(radius=1), (0, 0, 1e8)).value == pytest.approx(disk(1, 1e8), rel=1e-12)


@pytest.mark.parametrize("position", [(2, 0, 0), (0.1, 0, 0)])
def test_a_flat_shape_seen_from_its_own_plane_fills_nothing(position):
    """Also from within the hole of a ring."""
    found = counted(tp.Disk(radius=1, inner_radius=0.5), position, particles=1000)
    assert (found.value, found.error, found.exact) == (0, 0, True)


@pytest.mark.slow
def test_errors_are_right():
    """Over seeds z follows Student's t: natural and aimed directions are mixed here."""
    shape, exact = tp.Triangle(vertices=TRIANGLES["generic"]), VALUES["generic"]
    z = [counted(shape, ORIGIN, 4_000, seed).z(exact) for seed in range(150)]
    assert_z_spread(np.array(z), math.inf, FALSE_ALARM)


def test_an_area_that_is_not_on_the_sphere_counts_by_its_projection():
    """Planted: A/r² without the cosine, and without the distance that grows towards the rim."""
    tilted = tp.Disk(center=(0, 0, 10), normal=(0, 1, 1), radius=0.1)
    found = counted(tilted, ORIGIN)
    cosine = math.sqrt(0.5)
    assert_agrees(found, math.pi * 1e-4 * cosine, FALSE_ALARM)
    with pytest.raises(AssertionError):
        assert_agrees(found, math.pi * 1e-4, FALSE_ALARM)
    with pytest.raises(AssertionError):
        assert_agrees(counted(tp.Disk(center=(0, 0, 1), radius=0.5), ORIGIN), math.pi / 4, FALSE_ALARM)


# ---- refusals ----


UNIT_DISK = tp.Disk(radius=1)
REFUSED = {
    "on a disk": (
        UNIT_DISK,
        (0.5, 0, 0),
        r"position must not lie on the Disk.*\(0\.5, 0\.0, 0\.0\); move it off",
    ),
    "on a ball": (tp.Sphere(radius=2), (0, 0, 2), "must not lie on the Sphere"),
    "on a box": (tp.Box(size=2), (1, 0.2, 0.3), "must not lie on the Box"),
    "on a triangle": (
        tp.Triangle(vertices=TRIANGLES["octant"]),
        (1 / 3, 1 / 3, 1 / 3),
        "must not lie on the Triangle",
    ),
    "two numbers": (UNIT_DISK, (0, 0), r"three finite numbers, got \(0, 0\)"),
    "nan": (UNIT_DISK, (0, 0, math.nan), "three finite numbers"),
    "a point": (tp.Point(), (0, 0, 1), "shape must be a Rectangle.*has an area"),
    "a name": ("lid", (0, 0, 1), "shape must be a Rectangle"),
    "no particles": (UNIT_DISK, (0, 0, 1), "particles must be"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_solid_angle_without_an_answer_is_refused(name):
    shape, position, words = REFUSED[name]
    with pytest.raises(tp.SceneError, match=words):
        counted(shape, position, 0 if name == "no particles" else 1000)
