"""Uncollided fluence through boxes: the reference values, other ways to the same integral, and how near a face it holds.

A comment such as `I.kobayashi1_absorber` names the entry of the project's reference collection that numbers come from.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import nquad

from transport.sims.dogleg import CELL, SOURCE, space, straight
from transport.theory.ray_integrals import Region, Space, mean_uncollided_fluence, uncollided_fluence

KOBAYASHI = {  # problem, place: I.kobayashi1_absorber, I.kobayashi3_absorber
    (1, (5, 5, 5)): 5.956594222390358,
    (1, (5, 25, 5)): 0.5008706616100194,
    (1, (5, 95, 5)): 0.00034684662058949184,
    (1, (15, 15, 15)): 0.4707539432064523,
    (1, (55, 55, 55)): 0.013337762089738789,
    (1, (95, 95, 95)): 3.0103228434063227e-06,
    (1, (15, 55, 5)): 0.055024664526368804,
    (1, (85, 55, 5)): 0.00045311285739583595,
    (3, (5, 95, 5)): 0.0009483240487873712,
    (3, (15, 55, 5)): 0.02450408058237372,
    (3, (25, 55, 5)): 0.004544769765236742,
    (3, (55, 55, 5)): 9.142097583831734e-05,
    (3, (5, 95, 35)): 3.270578936978166e-05,
    (3, (35, 95, 35)): 3.379805618427972e-05,
    (3, (55, 95, 35)): 3.364601435441781e-06,
}
CUBE = (-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)


def from_cube(point, regions=None, extinction=0.5, **how):
    """The fluence that a cube of 2 sends to a point, in nothing or in such regions."""
    return uncollided_fluence(point, *CUBE, Space(regions or [Region(*CUBE, extinction)]), **how)


@pytest.mark.parametrize(("problem", "place"), KOBAYASHI)
def test_kobayashi_s_points_are_those_of_the_reference(problem, place):
    assert straight(problem, place) == pytest.approx(KOBAYASHI[problem, place], rel=2e-9)


@pytest.mark.slow
@pytest.mark.parametrize("problem", [1, 2, 3])
@pytest.mark.parametrize("place", [(5, 5, 5), (15, 55, 5), (35, 95, 35), (11, 11, 1), (59, 99, 59)])
def test_more_nodes_change_nothing(problem, place):
    more = uncollided_fluence(place, *SOURCE, space(problem), order=16)
    assert straight(problem, place) == pytest.approx(more, rel=2e-9)


def test_a_void_taken_for_shield_is_another_value():
    solid = Space([Region((-100,) * 3, (100,) * 3, 0.1), Region(*SOURCE, 0.1)])
    assert uncollided_fluence((5, 55, 5), *SOURCE, solid) < 0.2 * straight(1, (5, 55, 5))


def test_it_is_the_volume_integral_over_the_source():
    """By adaptive quadrature over the three coordinates, through a wall that every ray passes whole."""
    point, wall = np.array([6.0, 1.5, -0.5]), Region((2.0, -50.0, -50.0), (3.0, 50.0, 50.0), 0.7)

    def part(x, y, z):
        way = point - (x, y, z)
        distance = math.sqrt(way @ way)
        slope = distance / way[0]  # length of way per length along x
        return math.exp(-(0.3 * (1 - x) + 0.7) * slope) / (4 * math.pi * distance**2)

    # The cube lies in a slab of its own material, so that all rays leave it at x = 1.
    slabs = [wall, Region((-1.0, -50.0, -50.0), (1.0, 50.0, 50.0), 0.3)]
    exact, _ = nquad(part, [(-1, 1)] * 3, opts={"epsabs": 1e-12, "epsrel": 1e-9})
    assert from_cube(point, slabs) == pytest.approx(exact, rel=1e-8)


@pytest.mark.parametrize("turn", range(3))
@pytest.mark.parametrize("sign", [-1, 1])
def test_no_axis_and_no_side_is_special(turn, sign):
    regions = [Region((-9, -8, -7), (9, 8, 7), 0.2), Region((1, -3, -2), (4, 5, 6), 0.01), Region(*CUBE, 0.4)]

    def turned(corner):
        return tuple(sign * np.roll(corner, turn))

    def image(region):
        ends = np.sort([turned(region.low), turned(region.high)], axis=0)
        return Region(tuple(ends[0]), tuple(ends[1]), region.extinction)

    point = (6.0, 2.5, 4.0)
    assert from_cube(turned(point), [image(r) for r in regions]) == pytest.approx(
        from_cube(point, regions), rel=1e-12
    )


def test_a_far_source_is_a_point():
    """V exp(-τ)/(4 π r²), where the source itself absorbs nothing and the shield 1e-4 over its size, in whose mean over all places."""
    point = np.array([6000.0, 5000.0, 7000.0])
    distance = math.sqrt(point @ point)
    inside = np.abs(1 / point).min() * distance  # of the ray from the middle, in the source
    exact = 8 * math.exp(-1e-4 * (distance - inside)) / (4 * math.pi * distance**2)
    shield = [Region((-2e4,) * 3, (2e4,) * 3, 1e-4), Region(*CUBE, 0.0)]
    assert from_cube(point, shield) == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_nothing_jumps_at_a_face_of_the_source(gap):
    inside, on, outside = (from_cube((1 + s * gap, 0.3, -0.2)) for s in (-1, 0, 1))
    assert inside == pytest.approx(on, rel=30 * gap)
    assert outside == pytest.approx(on, rel=30 * gap)
    assert outside < on < inside


@pytest.mark.parametrize(
    "place", [(1.0001, 0.2, 0.9), (0.9999, 0.9999, 0.2), (1.01, 1.01, 1.01), (0, 0, 0.999)]
)
def test_near_faces_edges_and_corners_more_nodes_change_nothing(place):
    assert from_cube(place, order=10) == pytest.approx(from_cube(place, order=20), rel=1e-8)


def test_within_a_clear_cube_it_is_the_mean_chord():
    """At the middle of a cube of 2 that absorbs nothing: the mean over directions of the distance out."""
    random = np.random.default_rng(1).normal(size=(400_000, 3))
    lengths = np.linalg.norm(random, axis=1) / np.abs(random).max(axis=1)
    error = lengths.std() / math.sqrt(len(lengths))
    assert abs(from_cube((0, 0, 0), extinction=0.0) - lengths.mean()) < 5 * error


def test_optical_depths_are_those_of_the_innermost_box_along_the_ray():
    regions = [
        Region((-10, -10, -10), (10, 10, 10), 0.3),
        Region((-5, -6, -7), (2, 3, 4), 0.01),
        Region((-4, -1, -2), (1, 2, 3), 2.0),
        Region((2, -6, -7), (6, 3, 4), 0.7),  # touches the second
        Region((3, -1, -2), (4, 2, 3), 0.0),
    ]
    draws = np.random.default_rng(1)
    start, ends = draws.uniform(-12, 12, 3), draws.uniform(-12, 12, (200, 3))
    found = Space(regions).optical_depths(start, ends)
    t = (np.arange(40_000) + 0.5) / 40_000
    for end, depth in zip(ends[:40], found[:40], strict=True):
        places, extinction = start + t[:, None] * (end - start), np.zeros(len(t))
        for r in regions:
            extinction[((places > r.low) & (places < r.high)).all(axis=1)] = r.extinction
        assert depth == pytest.approx(extinction.mean() * np.linalg.norm(end - start), abs=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("problem", [1, 2])
def test_the_mean_over_the_cell_of_the_sim_is_good_to_a_millionth(problem):
    few, more = (mean_uncollided_fluence(CELL, *SOURCE, space(problem), across=n) for n in (4, 6))
    assert few == pytest.approx(more, rel=1e-7)
    assert straight(problem, (5, 55, 5)) != pytest.approx(more, rel=1e-3)  # its middle


def test_boxes_that_overlap_in_part_are_refused():
    large = Region((0, 0, 0), (2, 2, 2), 1.0)
    for other in (Region((1, 1, 1), (3, 3, 3), 1.0), Region((0, 0, 0), (2, 2, 2), 0.5)):
        with pytest.raises(ValueError, match="split or nest"):
            Space([large, other])
    Space([large, Region((2, 0, 0), (3, 3, 3), 1.0)])
