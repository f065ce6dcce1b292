"""Volume detectors at their edges: rays along and from faces, through corners, tangent; thin and thick cells.

Single passes are run on rays made for it and compared with ways told from exact crossings, cell by cell.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.hard.volume_rays import BALL, BOX, FOG, Rays, exact_ways, random_rays


@pytest.mark.parametrize("cells", [None, (1, 1, 1), (7, 3, 5), (1, 64, 2)])
def test_ways_through_voxels_are_those_between_exact_crossings(cells):
    rays = Rays(tp.VolumeDetector(BOX, "box", cells))
    edges = [np.linspace(a, b, n + 1) for a, b, n in zip(*BOX.bounds, cells or (1, 1, 1), strict=True)]
    origins, flights, starts, ends = random_rays(64, 1)
    for origin, flight, start, end in zip(origins, flights, starts, ends, strict=True):
        found, _, _ = rays.walk([origin], [flight], start, end)
        exact = exact_ways(origin, flight, start, end, edges).ravel()
        np.testing.assert_allclose(found, exact, rtol=0, atol=4e-15)
    together, counts, _ = rays.walk(origins, flights, starts, ends)
    assert together.sum() > 10 and counts.sum() > 40
    # A walk that took the wrong cell, or lost a part, would be off by a way of about a cell.


@pytest.mark.parametrize("cells", [None, 1, 6, (0.1, 0.2, 0.20001, 0.5), (0.0, 0.3)])
def test_ways_through_shells_are_differences_of_chords(cells):
    rays = Rays(tp.VolumeDetector(BALL, "ball", cells))
    radii = rays.volume.detector.edges(BALL).get("r", np.array([0.0, 0.5]))
    origins, flights, starts, ends = random_rays(64, 2)
    for o, u, start, end in zip(origins, flights, starts, ends, strict=True):
        h, q2 = o @ u, o @ o - (o @ u) ** 2
        half = np.sqrt(np.maximum(radii**2 - q2, 0.0))
        inside = np.maximum(np.minimum(end + h, half) - np.maximum(start + h, -half), 0.0)
        found, _, _ = rays.walk([o], [u], start, end)
        np.testing.assert_allclose(found, np.diff(inside), rtol=0, atol=2e-14)


@pytest.mark.parametrize("shape", [BOX, BALL], ids=["box", "ball"])
def test_lanes_that_wait_or_have_ended_are_not_counted_again(shape):
    rays = Rays(tp.VolumeDetector(shape, "it", (2, 2, 2) if shape is BOX else (3,)))
    origins, flights, starts, ends = random_rays(64, 3)
    assert rays.walk(origins, flights, starts, ends)[0].sum() > 10
    for values in ({"waits": True}, {"weights": 0.0}):
        found, counts, _ = rays.walk(origins, flights, starts, ends, **values)
        assert (found == 0).all() and (counts == 0).all()


# ---- along faces, from faces, through corners ----


@pytest.mark.parametrize("cells", [None, (4, 4, 4)])
@pytest.mark.parametrize("x", [-0.5, -0.25, 0.0, 0.25, 0.5])
@pytest.mark.parametrize("y", [-0.25, 0.0, 0.25])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_way_along_faces_and_edges_counts_once(cells, x, y, sign):
    """Within the planes of voxels, and those of the box, along z: 0.25 m in all, with both signs of a zero."""
    rays = Rays(tp.VolumeDetector(BOX, "box", cells))
    for zero in (0.0, -0.0):
        found, counts, _ = rays.walk([(x, y, -0.7 * sign)], [(zero, zero, sign)])
        assert found.sum() == pytest.approx(0.25, rel=1e-14)
        assert counts.sum() == (1 if cells is None else 4)


@pytest.mark.parametrize("cells", [(1, 1, 1), (4, 4, 4), (5, 5, 5)])
def test_a_way_through_corners_of_voxels_is_whole(cells):
    """Along the diagonal of a cube all three faces are met at once; both ways, from outside and from the corner."""
    cube = tp.Box(size=1.0)
    rays = Rays(tp.VolumeDetector(cube, "cube", cells))
    diagonal = np.ones(3) / math.sqrt(3)
    for origin, flight in (
        ((-1, -1, -1), diagonal),
        ((-0.5, -0.5, -0.5), diagonal),
        ((0.5, 0.5, 0.5), -diagonal),
    ):
        found, _, _ = rays.walk([origin], [flight])
        assert found.sum() == pytest.approx(math.sqrt(3), rel=1e-14)
        ways = found.reshape(cells)
        on_it = ways[np.arange(cells[0]), np.arange(cells[0]), np.arange(cells[0])]
        assert on_it.sum() == pytest.approx(math.sqrt(3), rel=1e-14)


def test_rays_that_start_on_a_face_count_on_the_side_that_they_fly_to():
    rays = Rays(tp.VolumeDetector(BOX, "box", (4, 1, 1)))
    for x, ux, exact in (
        (-0.5, 1.0, [0.25] * 4), (-0.5, -1.0, [0] * 4), (0.5, -1.0, [0.25] * 4), (0.5, 1.0, [0] * 4),
        (0.0, 1.0, [0, 0, 0.25, 0.25]), (0.0, -1.0, [0.25, 0.25, 0, 0]),
    ):  # fmt: skip
        found, counts, _ = rays.walk([(x, 0.1, 0.1)], [(ux, 0.0, 0.0)])
        assert found == pytest.approx(exact, abs=1e-15)
        assert counts.tolist() == [way > 0 for way in exact]


def test_an_aimed_ray_begins_before_its_origin():
    """Its origin is its target; it starts at a negative distance of it."""
    rays = Rays(tp.VolumeDetector(BOX, "box", (2, 1, 1)))
    found, _, _ = rays.walk([(0.7, 0.0, 0.0)], [(1.0, 0.0, 0.0)], starts=-0.95, ends=0.0)
    assert found == pytest.approx([0.25, 0.5], abs=1e-15)


@pytest.mark.parametrize("radius", [0.1, 0.2, 0.4, 0.5])
@pytest.mark.parametrize("beyond", [0.0, 1e-16, -1e-16, 1e-9, -1e-9])
def test_a_tangent_ray_ends_and_is_whole(radius, beyond):
    """It touches the sphere of a boundary of shells: inside of it, on it or just outside."""
    rays = Rays(tp.VolumeDetector(BALL, "ball", 5))
    height = radius + beyond
    found, _, _ = rays.walk([(-0.9, height, 0.0)], [(1.0, 0.0, 0.0)])
    half = math.sqrt(max((0.5 - height) * (0.5 + height), 0.0))
    assert found.sum() == pytest.approx(2 * half, abs=1e-15)
    inner = found[: round(radius * 10)].sum()
    assert inner == pytest.approx(2 * math.sqrt(max((radius - height) * (radius + height), 0)), abs=4e-8)


def test_a_ray_through_the_centre_meets_each_shell_twice():
    rays = Rays(tp.VolumeDetector(BALL, "ball", 5))
    for start, exact in ((-0.9, [0.2] * 5), (0.0, [0.1] * 5), (-0.3, [0.2, 0.2, 0.2, 0.1, 0.1])):
        found, counts, _ = rays.walk([(start, 0.0, 0.0)], [(1.0, 0.0, 0.0)])
        assert found == pytest.approx(exact, abs=1e-15)
        assert counts.sum() == round(sum(exact) * 10) - (
            start < -0.5 or start == -0.3
        )  # the innermost at one go


# ---- absorption ----


@pytest.mark.parametrize("depth", [1e-300, 1e-12, 1e-9, 1e-3, 1.0, 30.0, 1e4])
@pytest.mark.parametrize("shape", [BOX, BALL], ids=["box", "ball"])
def test_fading_on_the_way_keeps_its_digits_from_thin_to_thick(shape, depth):
    """Of a ray along x, 1 m through all, from 0.5 m before: each cell against expm1 in double precision."""
    cells = (4, 1, 1) if shape is BOX else 2
    rays = Rays(tp.VolumeDetector(shape, "it", cells), FOG)
    found, _, kept = rays.walk([(-1.0, 0.0, 0.0)], [(1.0, 0.0, 0.0)], sigma_a=depth)
    places = np.linspace(0.5, 1.5, 5)
    exact = -np.exp(-depth * places[:-1]) * np.expm1(-depth * np.diff(places)) / depth
    exact = exact if shape is BOX else np.array([exact[1] + exact[2], exact[0] + exact[3]])
    tiny = 2.0**-62  # of what the sums resolve
    np.testing.assert_allclose(found, exact, rtol=1e-13, atol=tiny)
    np.testing.assert_allclose(kept, depth * exact, rtol=1e-13, atol=tiny)
    whole, _, _ = Rays(tp.VolumeDetector(shape, "it"), FOG).walk(
        [(-1.0, 0.0, 0.0)], [(1.0, 0.0, 0.0)], sigma_a=depth
    )
    assert whole[0] == pytest.approx(exact.sum(), rel=1e-13, abs=tiny)
