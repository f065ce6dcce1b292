"""Two elements: their throughput, what their size costs, mean chords; and wrong laws that the counts reject.

Each statistical judgement fails right code in one of 10^5 seeds; the seed is 1.  A comment such as `B.sun` names the
entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import dataclasses
import math
from functools import partial

import mpmath as mp
import numpy as np
import pytest

import transport as tp
from tests import sim_runs
from tests.agreement import agrees, assert_agrees, smallest_bias
from transport.results import solid_angles
from transport.sims import two_elements
from transport.sims.two_elements import (
    ALL,
    AT_2,
    BACK,
    BIAS,
    BODIES,
    CHORD,
    DOWN,
    L1,
    L2,
    MIDDLES,
    RATIO,
    SAME,
    THERE,
    UP,
)
from transport.theory import enclosures, etendue, view_factors

slow = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
rows = partial(sim_runs.rows, two_elements)
TILTED = {"size_1": 0.05, "size_2": 0.02, "tilt_1": math.radians(75), "tilt_2": math.radians(45)}
DISTANT = TILTED | {"size_1": 0.1, "distance": 2.0}


# ---- theory ----


def test_throughput_of_disks_is_that_of_the_collection():
    values = [etendue.disks_throughput(*case) for case in ((1, 1, 1), (0.01, 0.02, 1), (1, 1, 100))]
    exact = [3.7698534257005853, 3.945868983699782e-07, 0.0009867630973551228]  # B.etendue_discs
    assert values == pytest.approx(exact, rel=1e-14)


@pytest.mark.parametrize("ratios", [(1e-8, 1e-8), (1e-3, 2e-3), (0.1, 0.1), (1, 2), (50, 3)])
def test_what_disks_get_wrong_does_not_cancel(ratios):
    with mp.workdps(60):
        one, two = map(mp.mpf, ratios)
        total = 1 + one**2 + two**2
        exact = (total - mp.sqrt(total**2 - 4 * one**2 * two**2)) / (2 * one**2 * two**2) - 1
    assert etendue.disks_bias(*ratios) == pytest.approx(float(exact), rel=1e-13)


def test_what_disks_get_wrong_falls_with_the_square():
    assert etendue.disks_bias(1e-4, 1e-4) == pytest.approx(-2e-8, rel=1e-7)
    assert etendue.disks_bias(1e-4, 3e-4) == pytest.approx(-1e-7, rel=1e-6)


def square(center, normal, size):
    shape = tp.Rectangle(center=center, normal=normal, width=size, height=size)
    return shape.center, two_elements.sides_of(shape)


@pytest.mark.parametrize("distance", [1.0, 2.0, 100.0])
def test_throughput_by_quadrature_is_the_closed_form_of_parallel_squares(distance):
    value = etendue.tilted_throughput(
        *square((0, 0, 0), (0, 0, 1), 1), *square((0, 0, distance), (0, 0, -1), 1)
    )
    exact = math.pi * view_factors.parallel_rectangles(1, 1, distance)
    assert value == pytest.approx(exact, rel=1e-11)


def test_throughput_by_quadrature_is_the_closed_form_of_walls_at_a_right_angle():
    """A floor and a wall that stand a width apart: the strips between are taken off (Howell, C-14)."""

    def from_edge(width_1, width_2):
        return width_1 * math.pi * view_factors.perpendicular_rectangles(width_1, width_2)

    exact = from_edge(2, 2) - from_edge(1, 2) - from_edge(2, 1) + from_edge(1, 1)
    floor, wall = square((1.5, 0, 0), (0, 0, 1), 1), square((0, 0, 1.5), (1, 0, 0), 1)
    assert etendue.tilted_throughput(*floor, *wall) == pytest.approx(exact, rel=1e-8)


def test_throughput_of_tilted_elements_is_the_same_from_either():
    one, two = (square((0, 0, z), normal, 0.3) for z, normal in ((0, (1, 0, 1)), (1, (0, 1, -2))))
    there, back = etendue.tilted_throughput(*one, *two), etendue.tilted_throughput(*two, *one)
    assert there == pytest.approx(back, rel=1e-13)
    assert there != pytest.approx(
        etendue.element_throughput(0.09, math.sqrt(0.5), 0.09, math.sqrt(0.8), 1), rel=1e-3
    )


def test_small_tilted_elements_hold_what_their_middles_say():
    off = []
    for size in (0.02, 0.01):
        one, two = (square((0, 0, z), normal, size) for z, normal in ((0, (1, 0, 1)), (1, (0, 1, -2))))
        by_middles = etendue.element_throughput(size**2, math.sqrt(0.5), size**2, math.sqrt(0.8), 1)
        off.append(etendue.tilted_throughput(*one, *two) / by_middles - 1)
    assert off[0] / off[1] == pytest.approx(4, rel=1e-3)


def test_elements_behind_one_another_are_refused():
    with pytest.raises(ValueError, match="behind"):
        etendue.tilted_throughput(*square((0, 0, 0), (0, 0, 1), 1), *square((0.2, 0, 0.1), (1, 0, 0), 1))
    with pytest.raises(tp.SceneError, match="tilt them less"):
        two_elements.scene(tilt_1=math.radians(89))


def test_mean_chords_are_those_of_the_collection():
    assert enclosures.mean_chord(4 * math.pi / 3, 4 * math.pi) == pytest.approx(
        4 / 3, rel=1e-15
    )  # A.mean_chord
    assert enclosures.sphere_mean_chord(1.0) == pytest.approx(4 / 3, rel=1e-15)
    assert enclosures.box_mean_chord((1, 1, 1)) == pytest.approx(2 / 3, rel=1e-15)
    assert enclosures.mean_chord(2 * math.pi, 6 * math.pi) == pytest.approx(
        4 / 3, rel=1e-15
    )  # a cylinder of height 2
    box = tp.Box(size=(1, 2, 3))
    assert enclosures.box_mean_chord(box.size) == pytest.approx(
        enclosures.mean_chord(box.volume, box.area), rel=1e-15
    )


# ---- the first law ----


@slow
@pytest.mark.parametrize("parameters", [TILTED, DISTANT])
def test_what_leaves_and_what_arrives_have_one_radiance(parameters):
    for estimate, exact in rows(**parameters).values():
        assert_agrees(estimate, exact, FALSE_ALARM)


@slow
def test_both_ends_are_measured_by_random_numbers_of_their_own():
    """The batches of L₁ and L₂ are not correlated; of 32 batches |r| > 0.7 happens once in 10^5 by chance."""
    found = rows(**TILTED)
    one, two = (found[name][0].values for name in (L1, L2))
    assert abs(np.corrcoef(one, two)[0, 1]) < 0.7
    assert found[RATIO][0].error == pytest.approx(
        math.hypot(found[L1][0].relative_error, found[L2][0].relative_error), rel=0.4
    )


@pytest.mark.parametrize("end", [1, 2])
def test_a_cosine_at_one_end_only_is_rejected(monkeypatch, end):
    """Of the same rays, counted at both ends, L₁/L₂ would stay 1 if the flux itself lost a cosine."""
    if end == 1:  # what leaves, per dA₁ instead of per dA₁ cosθ₁
        monkeypatch.setattr(
            solid_angles, "cone_projected_solid_angle", lambda angle, mu: 2 * math.pi * (1 - math.cos(angle))
        )
    else:
        right = two_elements.throughput_of
        monkeypatch.setattr(
            two_elements, "throughput_of", lambda *ends: right(*ends) / math.cos(TILTED["tilt_2"])
        )
    solid_angles.solid_angles_of.cache_clear()
    found = rows(particles=200_000, **TILTED)
    solid_angles.solid_angles_of.cache_clear()
    assert not agrees(*found[RATIO])
    assert agrees(*found[L2 if end == 1 else L1])


@slow
@pytest.mark.parametrize("seed", range(5))
def test_what_leaves_one_element_is_what_comes_to_the_other(seed):
    """An identity of integers: the same rays are counted twice."""
    estimate, _ = rows(particles=50_000, seed=seed, **TILTED)[SAME]
    assert estimate.exact
    assert estimate.value == 0


@slow
def test_wrong_radiances_are_rejected():
    """A cosine kept where it is divided out, and 1/r for 1/r²; each would be seen at a percent."""
    found = rows(particles=4_000_000, **DISTANT)
    cosines = {L1: math.cos(DISTANT["tilt_1"]), L2: math.cos(DISTANT["tilt_2"]), RATIO: 0.98}
    for name, cosine in cosines.items():
        estimate, exact = found[name]
        assert agrees(estimate, exact)
        assert smallest_bias(estimate, FALSE_ALARM) < 0.01
        assert not agrees(estimate * cosine, exact)
        assert not agrees(estimate / 2.0, exact)  # Φ / (dA₁ cosθ₁ dA₂ cosθ₂ / r)


@slow
def test_rays_that_passed_by_the_first_element_are_not_its():
    """Without `via` what comes to dA₂ from all of the wall is counted, and more than left dA₁."""
    right = two_elements.scene(**TILTED)
    counters = [dataclasses.replace(detector, via=None) for detector in right.detectors]
    estimate, exact = rows(dataclasses.replace(right, detectors=counters), **TILTED)[L2]
    assert not agrees(estimate, exact)
    assert estimate.value > exact


@slow
def test_elements_too_large_to_be_taken_for_points_are_seen():
    found = rows(size_1=0.1, size_2=0.1)
    assert agrees(*found[L2])
    assert not agrees(found[MIDDLES][0], 100.0)


# ---- throughput ----


@slow
def test_throughput_is_the_same_wherever_it_is_counted():
    for parameters in ({"size_1": 1.0, "size_2": 1.0}, {"size_1": 0.01, "size_2": 0.02}):
        found = rows(show="throughput", **parameters)
        for estimate, exact in found.values():
            assert_agrees(estimate, exact, FALSE_ALARM)
            assert not agrees(2.0 * estimate, exact)
        assert found[UP][0].value == pytest.approx(found[AT_2][0].value, rel=1e-12, abs=0)  # the same rays
        assert found[DOWN][0].value != pytest.approx(found[UP][0].value, rel=1e-12, abs=0)  # others


@slow
def test_uniform_random_lines_count_the_throughput():
    found = rows(show="lines", size_1=1.0, size_2=1.0)
    for name in (THERE, BACK, ALL):
        assert agrees(*found[name])
    estimate, exact = found[THERE]
    assert not agrees(estimate * math.pi, exact)  # lines that are uniform in solid angle, not in projected
    assert not agrees(found[ALL][0], exact)  # lines by dA₁ that miss dA₂


@slow
def test_what_finite_elements_get_wrong_falls_with_the_square_of_their_size():
    """Measured at 1e-6 to 1e-3 of its own size; a fall with a/r is rejected."""
    found = {a: rows(show="throughput", size_1=a, size_2=a)[BIAS] for a in (1e-1, 1e-2, 1e-3)}
    for estimate, exact in found.values():
        assert_agrees(estimate, exact, FALSE_ALARM)
        assert smallest_bias(estimate, FALSE_ALARM) < 0.02
    fall = found[1e-1][0] / found[1e-3][0]
    assert fall.value == pytest.approx(1e4, rel=0.03)
    assert not agrees(found[1e-3][0], 0.01 * found[1e-1][1])


# ---- chords ----


@slow
@pytest.mark.parametrize("body", BODIES)
def test_mean_chord_is_four_volumes_over_the_surface(body):
    estimate, exact = rows(show="chord", size_1=1.0, body=body)[CHORD]
    assert_agrees(estimate, exact, FALSE_ALARM)
    assert smallest_bias(estimate, FALSE_ALARM) < 0.02
    assert not agrees(
        estimate, 0.75 * exact
    )  # a sphere's for directions that are uniform, not by the cosine law


@slow
def test_a_clock_that_stops_before_the_longest_stay_is_rejected():
    right = two_elements.scene(show="chord", size_1=1.0)
    early = dataclasses.replace(right, duration=0.5 * right.duration)
    assert not agrees(*rows(early, show="chord", size_1=1.0)[CHORD])


# ---- the sim ----


def test_quadrature_nodes_suffice_for_the_cases_of_the_sim(monkeypatch):
    before = [two_elements.exact(**case) for case in two_elements.cases()]
    monkeypatch.setattr(etendue, "ELEMENT_NODES", 2 * etendue.ELEMENT_NODES)
    after = [two_elements.exact(**case) for case in two_elements.cases()]
    for one, two in zip(before, after, strict=True):
        assert list(one.values()) == pytest.approx(list(two.values()), rel=1e-9)
    assert np.isfinite([value for one in before for value in one.values()]).all()
