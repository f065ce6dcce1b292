"""Two elements: their throughput, what their size costs, mean chords; and wrong laws that the counts reject.

Each statistical judgement fails right code in one of 10^5 seeds; the seed is 1.  A comment such as `B.sun` names the
entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import dataclasses
import math

import mpmath as mp
import numpy as np
import pytest

import transport as tp
from tests.agreement import agrees, assert_agrees, smallest_bias
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
    SAME,
    THERE,
    UP,
    WHOLE,
)
from transport.theory import enclosures, etendue, view_factors

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
TILTED = {"size_1": 0.05, "size_2": 0.02, "tilt_1": math.radians(75), "tilt_2": math.radians(45)}
DISTANT = TILTED | {"size_1": 0.1, "distance": 2.0}


def rows(scene=None, particles=1_000_000, seed=1, **parameters):
    """(estimate, exact) by name, of the sim's scene or of a changed one."""
    scene = two_elements.scene(**parameters) if scene is None else scene
    measured = two_elements.measure(tp.simulate(scene, particles=particles, seed=seed))
    return {name: (measured[name], value) for name, value in two_elements.exact(**parameters).items()}


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


@pytest.mark.parametrize("parameters", [TILTED, DISTANT])
def test_the_same_rays_give_one_radiance_at_both_ends(parameters):
    for estimate, exact in rows(**parameters).values():
        assert_agrees(estimate, exact, FALSE_ALARM)


@pytest.mark.parametrize("seed", range(5))
def test_what_leaves_one_element_is_what_comes_to_the_other(seed):
    """An identity of integers: the same rays are counted twice."""
    estimate, _ = rows(particles=50_000, seed=seed, **TILTED)[SAME]
    assert estimate.exact
    assert estimate.value == 0


def test_wrong_radiances_are_rejected():
    """A cosine kept where it is divided out, and 1/r for 1/r²; each would be seen at a percent."""
    found = rows(**DISTANT)
    cosines = {L1: math.cos(DISTANT["tilt_1"]), L2: math.cos(DISTANT["tilt_2"])}
    for name, cosine in cosines.items():
        estimate, exact = found[name]
        assert agrees(estimate, exact)
        assert smallest_bias(estimate, FALSE_ALARM) < 0.01
        assert not agrees(estimate * cosine, exact)
        assert not agrees(estimate / 2.0, exact)  # Φ / (dA₁ cosθ₁ dA₂ cosθ₂ / r)


def test_rays_that_passed_by_the_first_element_are_not_its():
    """Without `via` what comes to dA₂ from all of the wall is counted, and more than left dA₁."""
    right = two_elements.scene(**TILTED)
    counters = [dataclasses.replace(detector, via=None) for detector in right.detectors]
    estimate, exact = rows(dataclasses.replace(right, detectors=counters), **TILTED)[WHOLE]
    assert not agrees(estimate, exact)
    assert estimate.value > exact


def test_elements_too_large_to_be_taken_for_points_are_seen():
    found = rows(size_1=0.1, size_2=0.1)
    assert agrees(*found[WHOLE])
    assert not agrees(found[L1][0], 100.0)


# ---- throughput ----


def test_throughput_is_the_same_wherever_it_is_counted():
    for parameters in ({"size_1": 1.0, "size_2": 1.0}, {"size_1": 0.01, "size_2": 0.02}):
        found = rows(show="throughput", **parameters)
        for estimate, exact in found.values():
            assert_agrees(estimate, exact, FALSE_ALARM)
            assert not agrees(2.0 * estimate, exact)
        assert found[UP][0].value == pytest.approx(found[AT_2][0].value, rel=1e-12, abs=0)  # the same rays
        assert found[DOWN][0].value != pytest.approx(found[UP][0].value, rel=1e-12, abs=0)  # others


def test_uniform_random_lines_count_the_throughput():
    found = rows(show="lines", size_1=1.0, size_2=1.0)
    for name in (THERE, BACK, ALL):
        assert agrees(*found[name])
    estimate, exact = found[THERE]
    assert not agrees(estimate * math.pi, exact)  # lines that are uniform in solid angle, not in projected
    assert not agrees(found[ALL][0], exact)  # lines by dA₁ that miss dA₂


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


@pytest.mark.parametrize("body", BODIES)
def test_mean_chord_is_four_volumes_over_the_surface(body):
    estimate, exact = rows(show="chord", size_1=1.0, body=body)[CHORD]
    assert_agrees(estimate, exact, FALSE_ALARM)
    assert smallest_bias(estimate, FALSE_ALARM) < 0.02
    assert not agrees(
        estimate, 0.75 * exact
    )  # a sphere's for directions that are uniform, not by the cosine law


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
