"""View factors: closed forms against references, mpmath and quadrature; the sim against them, planted faults
rejected.

A comment such as `C.inside_cylinder` names the entry of the project's reference collection that a number
comes from.  The statistical tests fail right code in one of 10^5 seeds each; the seed is 1.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from transport.sims import view_factors as sim
from transport.theory import emitters, occlusion
from transport.theory import round_view_factors as of_round
from transport.theory import view_factors as of_flat

FALSE_ALARM = 1e-5
SIZES = (1e-9, 1e-3, 0.1, 1.0, 10.0, 1e3, 1e9)


def close(value, exact, relative=1e-14):
    return np.allclose(value, np.array(exact, dtype=float), rtol=relative, atol=0)


def exactly(function, *numbers):
    """A form as it stands, in 60 digits."""
    with mp.workdps(60):
        return float(function(*map(mp.mpf, numbers)))


# ---- closed forms ----


def test_without_ends_crossed_strings_agree_with_references():
    """C.simple_exact, C.parallel_cylinders_check."""
    assert close(of_flat.infinite_wedge(np.radians([10, 60, 90, 150])), [
        0.9128442572523419, 0.5, 0.29289321881345254, 0.03407417371093169,
    ])  # fmt: skip
    assert close(of_flat.infinite_cylinders(1.0, np.array([0, 1, 10])), [
        0.1816901138162093, 0.11069596963167253, 0.026587744348033588,
    ])  # fmt: skip
    assert of_flat.infinite_strips(1.0, 0.0) == 1
    assert close(of_flat.infinite_strips(2.0, 2.0), math.sqrt(2) - 1)


@pytest.mark.parametrize("x", SIZES)
def test_no_form_without_ends_cancels(x):
    assert close(of_flat.infinite_strips(1.0, x), exactly(lambda x: mp.sqrt(1 + x * x) - x, x))
    angle = math.pi - min(x, 3)
    assert close(
        of_flat.infinite_wedge(angle), exactly(lambda a: 1 - mp.sin(a / 2), angle), 1e-13 / min(x, 1)
    )

    def cylinders(x):
        ratio = 1 + x / 2
        return (mp.sqrt(ratio**2 - 1) + mp.asin(1 / ratio) - ratio) / mp.pi

    assert close(of_flat.infinite_cylinders(1.0, x), exactly(cylinders, x))


@pytest.mark.parametrize(
    ("height", "factors"),
    [  # C.inside_cylinder: base to base, base to side, side to base, side to side
        (0.01, (0.9900498750007812, 0.00995012499921876, 0.497506249960938, 0.0049875000781240235)),
        (0.1, (0.9048750780274961, 0.09512492197250394, 0.47562460986251964, 0.048750780274960714)),
        (2, (0.1715728752538099, 0.8284271247461901, 0.20710678118654752, 0.585786437626905)),
        (10, (0.0098048640721517, 0.9901951359278482, 0.04950975679639241, 0.9009804864072152)),
    ],
)
def test_the_inside_of_a_tube_agrees_with_references(height, factors):
    forms = of_round.base_to_base, of_round.base_to_side, of_round.side_to_base, of_round.side_to_side
    assert close([form(1.0, height) for form in forms], factors)
    assert close([form(3.0, 3.0 * height) for form in forms], factors)


@pytest.mark.parametrize("h", SIZES)
def test_the_inside_of_a_tube_is_closed_and_does_not_cancel(h):
    ends, side = of_round.base_to_base(1.0, h), of_round.base_to_side(1.0, h)
    assert close(ends + side, 1.0, 1e-15)
    assert close(2 * of_round.side_to_base(1.0, h) + of_round.side_to_side(1.0, h), 1.0, 1e-15)
    assert close(side, exactly(lambda h: 1 - ((mp.sqrt(h * h + 4) - h) / 2) ** 2, h))
    assert close(of_round.side_to_side(1.0, h), exactly(lambda h: 1 + (h - mp.sqrt(h * h + 4)) / 2, h))
    assert close(of_round.side_to_base(1.0, h) * 2 * h, side)  # reciprocity


def test_cones_and_parts_of_spheres_agree_with_references():
    angles = np.radians([5, 30, 60])  # C.simple_exact
    assert close(of_round.cone_to_base(np.tan(angles), 1.0), [0.08715574274765817, 0.5, 0.8660254037844386])
    for x in SIZES:
        both = of_round.cone_to_base(x, 1.0) + of_round.cone_to_itself(x, 1.0)
        assert close(both, 1.0, 1e-15)
        assert close(of_round.cone_to_itself(x, 1.0), exactly(lambda x: 1 - x / mp.sqrt(1 + x * x), x))
    assert of_round.sphere_to_patch(0.5) == 0.5  # a hemisphere to itself, or to its base
    assert of_round.outer_sphere_to_inner(1.0, 2.0) == 0.25


def test_a_ball_and_a_disk_agree_with_references():
    assert close(of_round.sphere_to_disk(0.01, 2.0), 6.249882814941353e-06)  # C.sphere_to_disc
    assert close(of_round.sphere_to_disk(10_000, 1.5), 0.4999250000008437)
    for x in SIZES:
        assert close(of_round.sphere_to_disk(x, 1.0), exactly(lambda x: (1 - 1 / mp.sqrt(1 + x * x)) / 2, x))


@pytest.mark.parametrize("gap", [0.0, 1e-3, 0.3, 7.0, 1e3])
@pytest.mark.parametrize("radius", [1.0, 0.3, 1e-2])
def test_two_balls_exchange_alike(radius, gap):
    """Against the mean over the larger one, to which the smaller one is a peak, by an adaptive rule."""
    from scipy.integrate import quad

    distance = 1 + radius + gap

    def element(height):
        """View factor to the small ball from the place 1 - height of the large one's axis."""
        away = math.hypot(distance - 1, math.sqrt(2 * distance * height))
        return emitters.sphere_irradiance(1 / math.pi, radius, away, (distance * (1 - height) - 1) / away)

    full, cut = 1 - (1 + radius) / distance, 1 - (1 - radius) / distance
    nearer = [part * radius**2 for part in (1e-2, 1, 1e2)]
    points = sorted({0.0, *(p for p in nearer if p < cut), full, cut})
    parts = [
        quad(element, *ends, epsabs=0, epsrel=1e-11)[0] for ends in zip(points[:-1], points[1:], strict=True)
    ]
    exact = math.fsum(parts) / 2
    assert close(of_round.spheres(1.0, radius, distance), exact, 1e-9)
    assert close(of_round.spheres(radius, 1.0, distance), exact / radius**2, 1e-9)


def test_a_small_ball_sees_a_cap_and_far_ones_are_points():
    for gap in (1.0, 7.0, 1e3):
        cap = (1 - math.sqrt(1 - 1 / (1 + gap) ** 2)) / 2
        assert close(of_round.spheres(1e-6, 1.0, 1 + gap), cap, 1e-10)
    assert close(of_round.spheres(2.0, 3.0, 1e7), (3 / 1e7) ** 2 / 4, 1e-12)


def test_coaxial_tubes_tend_to_their_limits():
    """Long ones to crossed strings, r1/r2; and what an inner thread leaves is an empty tube's."""
    assert close(of_round.outer_cylinder_to_inner(1.0, 2.0, 1e4), 0.5, 1e-4)
    assert close(of_round.outer_cylinder_to_itself(1.0, 2.0, 1e4), 0.5 + _endless_ring(2.0), 1e-3)
    empty = of_round.side_to_side(1.0, 1.0)
    assert close(of_round.outer_cylinder_to_itself(1e-3, 1.0, 1.0), empty, 1e-3)
    for x, h in ((1.5, 0.7), (3, 4), (10, 1)):
        inner, itself = (
            f(1.0, x, h) for f in (of_round.outer_cylinder_to_inner, of_round.outer_cylinder_to_itself)
        )
        assert 0 < inner < 1 / x
        assert 0 < itself < of_round.side_to_side(x, h)
        assert inner + itself < 1


def _endless_ring(ratio):
    """All that does not fall on the inner one stays on the outer one: 1 - r1/r2 - 1/2 for r2 = 2 r1."""
    return 1 - 1 / ratio - 0.5


# ---- obstacles ----


def brute_disks(radius_1, radius_2, distance, hole, position):
    """By lines through places of the hole in all directions: trapezia over azimuth, Gauss over the place."""
    t, x = position / distance, np.polynomial.legendre.leggauss(160)
    p, weight = hole * (x[0] + 1) / 2, x[1] * hole / 2
    phi = 2 * math.pi * (np.arange(2000) + 0.5) / 2000
    low, high = np.zeros((len(p), len(phi))), np.full((len(p), len(phi)), np.inf)
    for centre, radius in ((p / t, radius_1 / t), (-p / (1 - t), radius_2 / (1 - t))):
        along = centre[:, None] * np.cos(phi)
        half2 = radius**2 - (centre[:, None] * np.sin(phi)) ** 2
        half = np.sqrt(np.maximum(half2, 0))
        low, high = np.maximum(low, along - half), np.where(half2 > 0, np.minimum(high, along + half), 0)
    low, high = (np.square(s / distance) for s in (low, np.maximum(high, low)))
    seen = (high / (1 + high) - low / (1 + low)).mean(axis=1)
    return 2 * (weight * p) @ seen / radius_1**2


@pytest.mark.parametrize(
    "sizes",
    [
        (1, 1, 1, 0.5, 0.5),
        (1, 2, 1, 0.7, 0.3),
        (1, 0.2, 1.5, 0.4, 0.9),
        (0.1, 3, 0.5, 0.2, 0.4),
        (2, 1, 9, 3, 1),
    ],
)
def test_disks_through_a_hole_agree_with_lines_through_it(sizes):
    assert close(occlusion.disks_through_hole(*sizes), brute_disks(*sizes), 1e-4)


@pytest.mark.parametrize("distance", [1e-2, 0.3, 1.0, 30.0])
def test_a_hole_wide_enough_is_none_and_a_narrow_one_is_two_point_factors(distance):
    free = of_flat.coaxial_disks(1.0, 0.5, distance)
    assert close(occlusion.disks_through_hole(1.0, 0.5, distance, 2.0, 0.4 * distance), free, 1e-12)
    assert abs(occlusion.disks_past_disk(1.0, 0.5, distance, 2.0, 0.4 * distance)) < 1e-12
    hole = 1e-4 * distance
    narrow = occlusion.disks_through_hole(1.0, 0.5, distance, hole, distance / 2)
    seen = (0.5 / math.hypot(0.5, distance / 2)) ** 2  # of the smaller disk from the hole's middle
    assert close(narrow, seen * hole**2, 1e-3)


def test_disks_through_a_hole_are_reciprocal():
    there, back = (1.0, 0.6, 1.3, 0.5, 0.4), (0.6, 1.0, 1.3, 0.5, 0.9)
    assert close(occlusion.disks_through_hole(*there), occlusion.disks_through_hole(*back) * 0.36, 1e-13)


def brute_rectangles(sides_1, sides_2, distance, hole, position):
    """Midpoints over the places of the hole; what is seen through each is a rectangle, by Lambert's formula
    at its corners.
    """
    t = position / distance
    nodes, weights = (2 * np.arange(600) + 1) / 600 - 1, np.full(600, 2 / 600)
    axes = []
    for a, b, c in zip(sides_1, sides_2, hole, strict=True):
        p = c / 2 * nodes
        low = np.maximum((p - a / 2) / t, (-p - b / 2) / (1 - t)) / distance
        high = np.minimum((p + a / 2) / t, (-p + b / 2) / (1 - t)) / distance
        axes.append((low, np.maximum(low, high), c / 2 * weights))
    (x_low, x_high, x_weight), (y_low, y_high, y_weight) = axes
    seen = sum(
        sign_x * sign_y * _corner_factor(x[:, None], y)
        for x, sign_x in ((x_high, 1), (x_low, -1))
        for y, sign_y in ((y_high, 1), (y_low, -1))
    )
    return x_weight @ seen @ y_weight / (sides_1[0] * sides_1[1])


def _corner_factor(x, y):
    """View factor from a point to a parallel rectangle with a corner above it, at unit distance."""
    k, m = np.hypot(1, x), np.hypot(1, y)
    return (x / k * np.arctan(y / k) + y / m * np.arctan(x / m)) / (2 * math.pi)


@pytest.mark.parametrize(
    "sizes",
    [
        ((1, 1), (1, 1), 1, (0.5, 0.5), 0.5),
        ((1, 2), (0.5, 3), 0.7, (0.4, 1.0), 0.2),
        ((1, 0.3), (2, 0.2), 1, (1.2, 0.24), 0.6),
        ((1, 1), (1, 1), 0.05, (0.7, 0.6), 0.01),
        ((1, 1), (3, 1), 5, (2, 2), 4.5),
    ],
)
def test_rectangles_through_a_hole_agree_with_lines_through_it(sizes):
    assert close(occlusion.rectangles_through_hole(*sizes), brute_rectangles(*sizes), 1e-5)


def test_rectangles_through_a_wide_hole_are_free_and_past_a_wide_obstacle_hidden():
    sides = (1.0, 2.0), (0.5, 3.0)
    free = of_flat.opposed_rectangles(*sides, 0.7)
    assert close(occlusion.rectangles_through_hole(*sides, 0.7, (2.0, 4.0), 0.3), free, 1e-12)
    assert abs(occlusion.rectangles_past_rectangle(*sides, 0.7, (2.0, 4.0), 0.3)) < 1e-12


def test_an_obstacle_beyond_the_gap_is_refused():
    with pytest.raises(ValueError, match="position must be between 0 and distance"):
        occlusion.disks_past_disk(1, 1, 1, 0.5, 1.5)


# ---- the sim ----


def run(particles=300_000, **parameters):
    """The estimate of the sim with these parameters, and its exact value."""
    scene, exact = sim.scene(**parameters), sim.exact(**parameters)
    result = tp.simulate(scene, particles=particles, seed=1)
    assert result.ledger["lost"].value == 0
    return sim.measure(result)[sim.FACTOR], exact[sim.FACTOR]


@pytest.mark.parametrize("pair", sim.PAIRS)
@pytest.mark.parametrize("sizes", [{}, {"ratio": 0.4, "size": 1.5, "obstacle": 0.7}])
def test_every_pair_is_counted(pair, sizes):
    estimate, exact = run(pair=pair, **sizes)
    assert_agrees(estimate, exact, FALSE_ALARM)
    assert estimate.relative_error < 0.02


def test_the_cases_reach_over_six_decades_and_more():
    ratios = {case["ratio"] for case in sim.cases() if case["pair"] == "disks" and "ratio" in case}
    assert min(ratios) == 1e-3 and max(ratios) == 1e3
    factors = [sim.exact(**case)[sim.FACTOR] for case in sim.cases()]
    assert min(factors) < 1e-6 and max(factors) > 0.998
    assert {case["pair"] for case in sim.cases()} == set(sim.PAIRS)


def test_factors_of_small_elements_are_rejected():
    """Planted: A₂/πr² by the middles; a cosine less, the share of a diffuse source's solid angle."""
    estimate, _ = run(pair="disks", ratio=2.0)
    assert_rejected(estimate, 1 / 4)
    assert_rejected(estimate, 2 * (1 - 2 / math.sqrt(5)))


def test_the_factor_the_other_way_is_rejected():
    estimate, exact = run(pair="balls", size=0.5)
    assert_rejected(estimate, exact / 0.25)
    estimate, exact = run(pair="outer tube to inner")
    assert_rejected(estimate, 2 * exact)


def test_obstacles_left_out_or_taken_for_holes_are_rejected():
    past, _ = run(pair="disks past a disk")
    through, hidden = run(pair="disks through a hole")
    assert_rejected(past, sim.exact(pair="disks")[sim.FACTOR])
    assert_rejected(past, hidden)
    assert_agrees(past + through, sim.exact(pair="disks")[sim.FACTOR], FALSE_ALARM)
    estimate, _ = run(pair="outer tube to itself")
    assert_rejected(estimate, of_round.side_to_side(2.0, 1.0))


def test_strips_with_ends_are_not_strips_without():
    """Planted: mirrors that are not there."""
    estimate, _ = run(pair="strips without ends")
    assert_rejected(estimate, of_flat.parallel_rectangles(1.0, 1.0, 1.0))
