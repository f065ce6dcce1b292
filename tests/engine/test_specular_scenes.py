"""Are the values of tests/specular_scenes.py exact, and does the benchmark of verdicts see what it should?"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.bench.trust import Run, is_complete, judge
from tests.bench.trust_references import Class
from tests.specular_rooms import ROOMS, random_room
from tests.specular_scenes import (
    CASES,
    DISH_LAMP,
    DISH_RADII,
    FOCAL,
    IMAGE_PLACE,
    LAMP,
    LAMP_PLACE,
    PLACE,
    RADII,
    RIM,
    SMALL_LAMP,
    SMALL_PLACE,
    SMALL_POWER,
    Case,
    by_disk,
    by_small_lamp,
    by_window,
    disk_nodes,
)

EXACT = [case for name, case in CASES.items() if name not in ("ball", "ball, behind", "window")]


@pytest.mark.parametrize("place", [LAMP_PLACE, IMAGE_PLACE])
@pytest.mark.parametrize("radius", RADII)
def test_contour_of_a_disk_agrees_with_its_area(radius, place):
    """E = L int cos cos' / d^2 dA, over lamp and detector."""
    x, y, share = disk_nodes(LAMP, 10, 20)
    u, v, weight = disk_nodes(radius, 6, 12)
    to = (
        PLACE[:, None, None]
        + np.array([0 * u, u, v])[:, None]
        - (place[:, None] + np.array([x, y, 0 * x]))[:, :, None]
    )
    d2 = (to**2).sum(axis=0)
    area = 100.0 / math.pi * float((to[0] * -to[2] / d2**2 * share[:, None] * weight).sum())
    assert by_disk(radius, tuple(place)) == pytest.approx(area, rel=1e-9)


@pytest.mark.parametrize("radius", DISH_RADII)
def test_contour_of_the_small_lamp_agrees_with_its_area(radius):
    x, y, share = disk_nodes(SMALL_LAMP, 10, 20)
    u, v, weight = disk_nodes(radius, 6, 12)
    height = FOCAL - SMALL_PLACE[2]
    d2 = (u - SMALL_PLACE[0] - x[:, None]) ** 2 + (v - y[:, None]) ** 2 + height**2
    area = SMALL_POWER / math.pi * float((height**2 / d2**2 * share[:, None] * weight).sum())
    assert by_small_lamp(radius) == pytest.approx(area, rel=1e-9)


def test_contour_of_the_window_agrees_with_its_area():
    nodes, weights = np.polynomial.legendre.leggauss(40)
    y, z = nodes[:, None], 2 + nodes / 2 - 0.8
    d2 = 3.5**2 + y**2 + z**2
    area = float((z * 3.5 / d2**2 * np.outer(weights, weights / 2)).sum())
    assert by_window(1e-9) == pytest.approx(area, rel=1e-9)


@pytest.mark.parametrize("radius", DISH_RADII)
def test_dish_shows_nothing_but_the_lamp_to_the_detector(radius):
    """Rays from the rim of the detector to that of the dish, and within it, meet the plane z = 2 m within the lamp."""
    x, y, _ = disk_nodes(RIM * 0.999999, 12, 48)
    place = np.stack([x, y, (x * x + y * y) / (4 * FOCAL)], axis=1)
    normal = np.stack([-x, -y, np.full_like(x, 2 * FOCAL)], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    for share in (0.0, 0.5, 1.0):
        ray = place - np.array([share * radius, 0.0, FOCAL])
        ray -= 2 * (ray * normal).sum(axis=1, keepdims=True) * normal
        met = place + ray * ((2 - place[:, 2]) / ray[:, 2])[:, None]
        assert (ray[:, 2] > 0).all()
        assert np.hypot(met[:, 0], met[:, 1]).max() < DISH_LAMP


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=() if case.name == "mirror" else pytest.mark.slow) for case in EXACT],
    ids=lambda case: case.name,
)
def test_runs_agree_with_exact_values(case: Case):
    """By "expected", which finds all light on the largest detector; the value of the scene's twin is rejected."""
    radius = case.radii[-1]
    scene, (value, _) = case.scene(radius), case.value(radius)
    found = tp.simulate(scene, 4_000_000, seed=7, estimator="expected")["m"].irradiance
    assert_agrees(found, value, false_alarm=1e-6)
    twin = CASES.get(f"{case.name}, behind")
    if twin is not None:
        with pytest.raises(AssertionError):
            assert_agrees(found, twin.value(radius)[0], false_alarm=1e-6)


def run(value: float, error: float, verdict: str, low: float = 0.0, high: float = 0.0) -> Run:
    """A run of 32 batches that said so."""
    return Run("expected", "expected", 1, 1_000_000, value, error, 31.0, verdict, low, high, 0.1, "")


def test_wrong_runs_without_a_finding_are_missed():
    far = 0.9, 0.01
    assert judge(run(*far, "sound"), 1.0, 0.0, []).is_missed
    assert not judge(run(*far, "doubtful"), 1.0, 0.0, []).is_missed
    assert not judge(run(*far, "bounded", 0.8, 1.1), 1.0, 0.0, []).is_missed
    assert judge(run(*far, "bounded", 0.8, 0.99), 1.0, 0.0, []).is_missed
    assert judge(run(0.0, math.nan, "sound"), 1.0, 0.0, []).is_missed
    assert not judge(run(0.97, 0.01, "sound"), 1.0, 0.0, []).is_wrong  # within 3 standard errors
    assert not judge(run(0.995, 1e-6, "sound"), 1.0, 0.0, []).is_wrong  # within 1 %
    assert not judge(run(*far, "sound"), 1.0, 0.05, []).is_wrong  # a poor reference


@pytest.mark.parametrize(
    ("light", "answer"),
    [
        (Class(0.3, 0.0, 1e-3), True),
        (Class(0.3, 0.0, 1e-4), False),
        (Class(0.001, 0.0, 0.0), True),
        (Class(0.01, 0.005, 1e-4), None),
    ],
)
def test_runs_are_complete_where_classes_that_matter_score_often(light, answer):
    assert is_complete([Class(0.5, 0.0, 1.0), light], 1_000_000) is answer


def test_rooms_are_always_the_same():
    assert all(random_room(k) == random_room(k) for k in range(0, ROOMS, 60))
