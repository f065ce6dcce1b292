"""Shadows of an edge and of a cylinder: the closed forms, every bin of the sim, and wrong shadows that it rejects.

Each statistical judgement fails right code in one of 10^5 seeds; the seed is 1.  A comment such as
`B.penumbra_small_angle` names the entry of the project's reference collection that numbers come from.
"""

from __future__ import annotations

import dataclasses
import math

import mpmath as mp
import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, smallest_bias
from transport.sims import penumbra as sim
from transport.theory import emitters, shadows
from transport.verification.experiment import run_experiment

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
LAMP = {"radius": 0.05, "distance": 1.0}
EDGE = LAMP | {"gap": 0.5}
THICK, THIN = LAMP | {"thickness": 0.03, "gap": 0.7}, LAMP | {"thickness": 0.02, "gap": 0.5}
WIDE = {"occluder": "edge", "radius": 0.4, "gap": 0.4}  # cosines fall by a third
CASES = [*sim.cases(), WIDE, {"occluder": "cylinder", "radius": 0.3, "gap": 0.5, "thickness": 0.15}]


def shadow(occluder="edge", **parameters):
    return sim.shadow_of(sim.scene(occluder, **parameters))


def bins(of, scene=None, particles=1_000_000, radiance=100.0):
    """All fine bins of the screen with their exact means."""
    result = tp.simulate(of.scene(radiance) if scene is None else scene, particles=particles, seed=1)
    return result["meter"].irradiance, radiance * of.means(of.edges)


def agrees(estimates, exact):
    """Bins that nothing may reach must have counted nothing."""
    lit = np.asarray(exact) > 0
    if np.any(np.asarray(estimates.value)[~lit] != 0):
        return False
    try:
        for estimate, value in zip(estimates, exact, strict=True):
            if value > 0:
                assert_agrees(estimate, value, FALSE_ALARM / lit.sum())
    except AssertionError:
        return False
    return True


# ---- theory ----


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.2, 0.1), (-1.5, 2.0), (0.3, 0.0), (30.0, -4.0)])
def test_the_whole_disk_is_footes(place):
    exact = emitters.disk_irradiance(1.0, 0.3, 1.0, math.hypot(*place))
    assert shadows.segment_projected_solid_angle(-1.0, *place, 0.3, 1.0) == pytest.approx(
        exact, rel=1e-9, abs=3e-16
    )
    assert shadows.segment_projected_solid_angle(0.3, *place, 0.3, 1.0) == 0


@pytest.mark.parametrize(
    ("cut", "x", "y", "radius"),
    [(0.1, 0.2, 0.1, 0.3), (-0.2, -1.0, 0.5, 0.3), (0.25, 0.5, -0.3, 0.3), (-3, 4, 5, 4)],
)
def test_a_segment_is_the_integral_over_its_points(cut, x, y, radius):
    with mp.workdps(20):

        def strip(a):  # X = R sin a; over Y in closed form
            big, h, q = radius * mp.sin(a), radius * mp.cos(a), 1 + (radius * mp.sin(a) - x) ** 2
            ends = [
                t / (2 * q * (q + t * t)) + mp.atan(t / mp.sqrt(q)) / (2 * q**1.5) for t in (h - y, -h - y)
            ]
            assert abs(big) <= radius
            return h * (ends[0] - ends[1])

        exact = mp.quad(strip, mp.linspace(mp.asin(mp.mpf(cut) / radius), mp.pi / 2, 5))
    assert shadows.segment_projected_solid_angle(cut, x, y, radius, 1.0) == pytest.approx(
        float(exact), abs=1e-15
    )


def test_two_segments_are_the_disk():
    cut, x, y = np.linspace(-0.4, 0.4, 9), 0.3, -0.2
    right = shadows.segment_projected_solid_angle(cut, x, y, 0.3, 1.0)
    left = shadows.segment_projected_solid_angle(-cut, -x, y, 0.3, 1.0)
    assert right + left == pytest.approx(emitters.disk_irradiance(1.0, 0.3, 1.0, math.hypot(x, y)), rel=1e-14)


def test_under_a_small_angle_it_is_the_share_of_the_disk_that_is_seen():
    u = np.array([-1, -0.9, -0.5, -0.1, 0, 0.1, 0.5, 0.9, 1])
    exact = [1, 0.9813069632657506, 0.8044988905221148, 0.563555714215231, 0.5]  # B.penumbra_small_angle
    exact = np.array(exact + [1 - share for share in exact[3::-1]])
    radius, gap, distance = 1e-3, 0.4, 1.0
    x = -u * shadows.half_width(radius, gap, distance)
    seen = shadows.lit_projected_solid_angle(shadows.behind_edge(gap, distance), x, 0.0, radius, distance)
    whole = emitters.disk_irradiance(1.0, radius, distance, np.abs(x))
    assert seen / whole == pytest.approx(exact, abs=1e-6)
    assert seen / whole != pytest.approx((1 - u) / 2, abs=0.02)  # the share of its diameter


def test_means_behind_an_edge_are_those_of_a_sum_over_the_disk():
    """theory/shadows.py, which has other nodes and no closed form, at its 3e-11."""
    edges, radius, gap, distance = np.linspace(-0.1, 0.1, 21), 0.05, 1.0, 2.0
    strip, borders = shadows.behind_edge(gap, distance), shadows.edge_borders(radius, gap, distance)
    means = shadows.mean_lit_projected_solid_angles(strip, borders, edges, (-0.05, 0.05), radius, distance)
    other = shadows.geometry_means(edges, (-0.05, 0.05), radius, gap, distance)
    assert means == pytest.approx(other, abs=1e-10 * means.max())
    assert borders[1] == pytest.approx(shadows.half_width(radius, gap, distance), rel=1e-15)


@pytest.mark.parametrize("x", [-0.3, -0.02, 0.0, 0.1])
def test_the_hidden_strip_ends_where_lines_touch_the_cylinder(x):
    thickness, gap, distance = 0.06, 0.6, 1.0
    for end in shadows.behind_cylinder(thickness, gap, distance)(np.array(x)):
        along = np.array([x - end, distance])
        middle = np.array([0 - end, gap])
        aside = abs(along[0] * middle[1] - along[1] * middle[0]) / np.hypot(*along)
        assert aside == pytest.approx(thickness, rel=1e-13)


@pytest.mark.parametrize("case", [THICK, THIN])
def test_at_the_borders_the_strip_ends_at_the_rim(case):
    radius, thickness, gap, distance = (case[name] for name in ("radius", "thickness", "gap", "distance"))
    borders = shadows.cylinder_borders(radius, thickness, gap, distance)
    low, high = shadows.behind_cylinder(thickness, gap, distance)(borders)
    assert low[0] == pytest.approx(radius, rel=1e-13)
    assert high[-1] == pytest.approx(-radius, rel=1e-13)
    ends = (low[1], high[2]) if case is THICK else (low[2], high[1])
    assert ends == pytest.approx((-radius, radius), rel=1e-13)
    assert shadows.has_umbra(radius, thickness, gap, distance) == (case is THICK)


def test_behind_a_cylinder_lines_drawn_at_random_see_as_much():
    """Lines between lamp and screen, kept where they pass the axis at more than the thickness."""
    of = shadow("cylinder", **THIN)
    draws, n = np.random.default_rng(1), 400_000
    r, a = of.radius * np.sqrt(draws.random(n)), 2 * np.pi * draws.random(n)
    end, side = r * np.cos(a), r * np.sin(a)
    edges = of.edges[::4]
    x, y = draws.uniform(*edges[[0, -1]], n), draws.uniform(*of.along, n)
    square = (x - end) ** 2 + (y - side) ** 2 + 1
    passes = np.abs(end + (x - end) * of.gap) / np.hypot(1, x - end) > of.thickness
    seen, place = passes / square**2 * np.pi * of.radius**2, np.digitize(x, edges) - 1
    number = np.bincount(place)
    mean = np.bincount(place, seen) / number
    error = np.sqrt((np.bincount(place, seen**2) / number - mean**2) / number)
    assert np.abs(mean - of.means(edges)).max() < 5.5 * error.max()
    assert np.all(np.abs(mean - of.means(edges)) < 5.5 * error)  # one in 10^6 for 15 bins


@pytest.mark.parametrize("case", CASES)
def test_twice_the_nodes_change_no_mean(case, monkeypatch):
    of = shadow(**case)
    before = of.means(of.edges)
    monkeypatch.setattr(shadows, "ACROSS", 2 * shadows.ACROSS)
    monkeypatch.setattr(shadows, "ALONG", 2 * shadows.ALONG)
    assert of.means(of.edges) == pytest.approx(before, abs=1e-12 * before.max())


# ---- the sim ----


@pytest.mark.parametrize("case", CASES)
def test_every_bin_of_a_shadow_holds_its_mean(case):
    of = shadow(**case)
    estimates, exact = bins(of)
    assert agrees(estimates, exact)
    light = estimates[-1]
    assert smallest_bias(light, FALSE_ALARM) < 0.05
    names = {name for name, *_ in of.zones}
    assert (exact[[name == "umbra" for name in _zone_of_bins(of)]] == 0).all()
    assert {"penumbra", "full light"} <= names


def _zone_of_bins(of):
    return [name for name, _, _ in of.zones for _ in range(sim.FINE[name])]


def test_a_lamp_taken_for_a_point_is_rejected():
    of = shadow("edge", **EDGE)
    estimates, exact = bins(of)
    assert agrees(estimates, exact)
    middles = (of.edges[1:] + of.edges[:-1]) / 2
    assert not agrees(estimates, np.where(middles > 0, exact[-1], 0.0))


def test_the_share_of_the_lamp_without_its_cosines_is_rejected():
    """A lamp as wide as its distance is long: G is not constant over it."""
    of = shadow(**WIDE)
    estimates, exact = bins(of)
    assert agrees(estimates, exact)
    middles = (of.edges[1:] + of.edges[:-1]) / 2
    share = shadows.visible_fraction(-middles / shadows.half_width(of.radius, of.gap, of.distance))
    whole = 100 * emitters.disk_irradiance(1.0, of.radius, of.distance, np.abs(middles))
    assert not agrees(estimates, np.where(exact > 0, share * whole, 0.0))


def replaced(of, shape):
    scene = of.scene(100.0)
    return dataclasses.replace(scene, surfaces=tp.Surface(shape, tp.Black(), name=of.occluder))


def test_a_ribbon_as_wide_as_the_cylinder_throws_another_shadow():
    of = shadow(**CASES[-1])
    ribbon = tp.Rectangle(center=(0, 0, of.gap), width=2 * of.thickness, height=4.0)
    assert not agrees(*bins(of, replaced(of, ribbon)))


def test_a_cylinder_that_ends_within_the_sight_lines_is_rejected():
    of = shadow("cylinder", **THICK)
    right = of.scene(100.0).surfaces[0].shape
    assert agrees(*bins(of, replaced(of, right)))
    assert not agrees(*bins(of, replaced(of, dataclasses.replace(right, height=0.09))))


def test_an_edge_a_millimetre_aside_is_rejected():
    of = shadow("edge", **EDGE)
    right = of.scene(100.0).surfaces[0].shape
    x, y, z = right.center
    assert not agrees(*bins(of, replaced(of, dataclasses.replace(right, center=(x - 1e-3, y, z)))))


def test_a_scene_of_another_size_has_the_same_shadow():
    """Micrometres: the same irradiance, as the angles are the same."""
    small = shadow("cylinder", **{name: 1e-6 * value for name, value in THICK.items()})
    estimates, exact = bins(small)
    assert agrees(estimates, exact)
    large = shadow("cylinder", **THICK)
    assert exact == pytest.approx(100 * large.means(large.edges), rel=1e-11, abs=1e-12)


def test_the_bins_fill_the_screen_and_the_elements_the_bins():
    for case in CASES:
        of = shadow(**case)
        assert (np.diff(of.edges) > 0).all()
        taken = [k for part in of.elements.values() for k in range(part.start, part.stop)]
        assert taken == list(range(len(of.edges) - 1))
        for part in of.elements.values():
            widths = np.diff(of.edges)[part]
            assert widths == pytest.approx(widths[0], rel=1e-12)


@pytest.mark.filterwarnings("error")
def test_the_verdict_tells_a_shadow_without_an_umbra():
    assert "without an umbra" in sim.verdict(run_experiment(sim, {}, particles=20_000, seed=1))
