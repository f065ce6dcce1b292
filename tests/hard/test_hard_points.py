"""Point detectors where it is hard: far and tiny, deep behind shields, in many bodies, in meshes, close to what emits.

False alarms 1e-6 each, fixed seeds; what does not depend on chance agrees to rounding.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.point_scenes import LAMP, M, filled, seen
from transport.physics.sight import sample_detour, sample_equiangular, sample_equiangular_beyond
from transport.theory import point_source


def lamp(position):
    return tp.Source(tp.Point(position=position), tp.Isotropic(power=2.0))


FAR = np.array([1e6, -2e6, 3e6])  # where coordinates have steps of 1e-10 m
SIGMAS = np.linspace(0.1, 2.0, 60)
SHELLS = [
    filled(tp.Sphere(radius=float(r)), M(float(s)))
    for r, s in zip(np.linspace(1.0, 60.0, 60), SIGMAS, strict=True)
]
SLABS = [  # on one another, of which neighbours share a plane
    filled(tp.Box(center=(0, 0, k + 0.5), size=(50, 50, 1)), M(sigma) if sigma else tp.Vacuum())
    for k, sigma in enumerate((0.3, 1.1, 0.0, 0.7, 2.0))
]
BELOW = (0, 0, -1)


def shield(depth):
    return [filled(tp.Slab(center=(0, 0, 2), thickness=1.0), M(depth))]


STRAIGHT = {  # bodies, the lamp, a point, the optical depth between, relative tolerance
    "far from the origin": (
        [filled(tp.Box(center=tuple(FAR), size=2.0), M(0.5))],
        FAR,
        FAR + (3, 4, 0),
        0.625,
        1e-9,
    ),
    "sixty shells in one another": (SHELLS, (0, 0, 0), (36.6, 0, 48.8), SIGMAS.sum(), 1e-12),
    "slabs, along an axis": (SLABS, BELOW, (0, 0, 6), 4.1, 1e-12),
    "slabs, aslant": (SLABS, BELOW, (3, 0, 3), 1.4 * math.hypot(3, 4) / 4, 1e-12),
    "within a slab": (SLABS, BELOW, (0, 1, 4.5), 3.1 * math.hypot(1, 5.5) / 5.5, 1e-12),
    **{f"a shield of {t:g}": (shield(t), (0, 0, 0), (0, 0, 4), t, 1e-10) for t in (1.0, 30.0, 300.0, 690.0)},
    **{
        f"a shield of {t:g}, aslant": (shield(t), (0, 0, 0), (3, 0, 4), 1.25 * t, 1e-10)
        for t in (1.0, 30.0, 300.0)
    },
}


@pytest.mark.quick_cases("far from the origin", "slabs, along an axis")
@pytest.mark.parametrize(("bodies", "start", "place", "depth", "within"), STRAIGHT.values(), ids=STRAIGHT)
def test_straight_light_fades_by_its_optical_depth(bodies, start, place, depth, within):
    found, _ = seen(lamp(tuple(start)), [tuple(place)], bodies, particles=100)
    exact = 2 * math.exp(-depth) / (4 * math.pi * math.dist(start, place) ** 2)
    assert found.value == pytest.approx(exact, rel=within)


@pytest.mark.slow
def test_a_mesh_hides_and_a_hollow_mesh_dims_twice():
    """Cubes of twelve triangles: lengths through them are those through boxes, along edges and diagonals too."""
    places = [(3, 0.1, 0.2), (3, 0, 0), (2, 2, 2), (3, 0.3, -0.4)]
    meshes, boxes = (
        seen(lamp((-3, 0, 0)), places, [filled(make(size=2.0), M(0.6)), filled(make(size=1.0), M(0.1))])[:-1]
        for make in (tp.Mesh.box, tp.Box)
    )
    for one, other in zip(meshes, boxes, strict=True):
        assert one.value == pytest.approx(other.value, rel=1e-9)
    black = tp.Surface(tp.Mesh.box(size=1.0), tp.Black())
    hidden, clear, _ = seen(lamp((-3, 0, 0)), [(3, 0.1, 0.2), (3, 0, 4)], [black])
    assert hidden.value == 0
    assert clear.value == pytest.approx(2 / (4 * math.pi * 52), rel=1e-12)


@pytest.mark.slow
def test_close_to_a_point_source_in_fog():
    """Down to a millionth of a mean free path phi is that of the source, and scattered light adds its share."""
    distances = [1e-6, 1e-3, 0.01]
    *found, _ = seen(LAMP, [(r, 0, 0) for r in distances], medium=M(0.1, 0.9), particles=200_000)
    for estimate, r in zip(found, distances, strict=True):
        assert_agrees(estimate, 2 * point_source.fluence_rate(r, 1.0, 0.9), 1e-6)


def test_close_to_a_black_wall_and_in_a_narrow_slit():
    slit = [tp.Surface(tp.Plane(center=(0, 0, z)), tp.Black()) for z in (-1e-7, 1e-7)]
    on_axis, behind, _ = seen(LAMP, [(1, 0, 0), (1, 0, 1)], slit)
    assert on_axis.value == pytest.approx(2 / (4 * math.pi), rel=1e-12)
    assert behind.value == 0
    wall = [tp.Surface(tp.Plane(), tp.Black())]
    before, behind, _ = seen(lamp((0, 0, 1)), [(0.3, 0.4, 1e-13), (0.3, 0.4, -1e-13)], wall)
    assert before.value == pytest.approx(2 / (4 * math.pi * 1.25), rel=1e-9)
    assert behind.value == 0


def test_a_scatterer_that_is_far_and_small_is_seen():
    """A thin ball a thousand times as far as it is large, in a pencil beam: sigma p times its chord over r^2."""
    ball = filled(tp.Sphere(center=(0, 0, 1), radius=0.001), M(scattering=1e-6))
    pencil = tp.Source(tp.Point(position=(0, 0, 0)), tp.Beam((0, 0, 1), power=1.0))
    found, _ = seen(pencil, [(1, 0, 1)], [ball], particles=10_000)
    assert found.value == pytest.approx(1e-6 * 0.002 / (4 * math.pi), rel=1e-5)


@pytest.mark.slow
def test_a_point_in_a_grid_of_one_thick_voxel_among_thin_ones():
    """A furnace: whatever scatters in it, light is the same everywhere; the point in the thick voxel, and beside it."""
    voxels = np.full((5, 5, 5), 0.01)
    voxels[2, 2, 2] = 30.0
    grid = tp.Grid(box=tp.Box(size=1.0), scattering=voxels)
    wall = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.5), "wall", inside=tp.Vacuum())
    source = tp.Source("wall", tp.Lambertian(exitance=0.5 * math.pi), side="back")
    places, bodies = [(0.02, 0.01, 0.03), (0.3, 0, 0)], [wall, filled(grid.box, grid)]
    *found, _ = seen(source, places, bodies, particles=300_000, seed=3)
    for estimate in found:
        assert_agrees(estimate, 4 * math.pi, 1e-6)


@pytest.mark.parametrize("least", [0.0, 1e-300, 1e-30, 1e-9, 1.0, 1e9])
def test_places_on_a_line_are_numbers_for_any_line_and_any_draw(least):
    sample, beyond = (getattr(f, "py_func", f) for f in (sample_equiangular, sample_equiangular_beyond))
    for start, end in ((-1.0, 1.0), (1e-8, 1.0), (-1.0, -1e-8), (1.0, 1.0 + 1e-12), (-1e9, 1e9)):
        for u in (0.0, 1e-16, 0.5, 1 - 1e-16):
            place, inverse = sample(least, start, end, u)
            assert start <= place <= end and 0 < inverse < math.inf
        if (
            start > 0 or end < 0
        ) and least < 1e-9:  # seen under an angle that is its length over the distances
            assert inverse == pytest.approx((end - start) / (start * end), rel=1e-9)
        for u in (0.0, 1e-16, 0.5, 1 - 1e-15):
            length, inverse = beyond(least, start, u)
            assert 0 <= length < math.inf and 0 < inverse < math.inf


def test_detours_follow_their_law():
    """1/(a^2 b^2) r/pi^3: the share of detours within a ball about the start, by quadrature in bipolar angles."""
    random = np.random.default_rng(8)
    sample = getattr(sample_detour, "py_func", sample_detour)
    mu, sine, leg = np.array([sample(2.0, u, v) for u, v in random.random((20_000, 2))]).T
    assert np.abs(mu**2 + sine**2 - 1).max() < 1e-14 and (leg >= 0).all()
    other = np.sqrt(leg**2 + 4 - 4 * leg * mu)
    # The map that exchanges both ends keeps the density: so both legs are alike in law.
    for reach in (0.5, 1.0, 2.0, 5.0):
        assert abs(np.mean(leg < reach) - np.mean(other < reach)) < 5 * math.sqrt(2 * 0.25 / len(leg))
    # Within a ball of radius R about the start the share is 2/pi^2 times the integral of ln|(R+r)/(R-r)|/(2 rho) d rho.
    for reach in (0.5, 1.5, 4.0):
        x = (np.arange(200_000) + 0.5) / 200_000 * reach / 2
        share = 2 / math.pi**2 * np.sum(np.log(np.abs((1 + x) / (1 - x))) / x) * (x[1] - x[0])
        assert abs(np.mean(leg < reach) - share) < 5 * math.sqrt(0.25 / len(leg)), (reach, share)
