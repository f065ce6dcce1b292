"""Lenses and light fields: laws of the experiments `lenses` and `light_field`, and wrong answers that the counts reject.

Each statistical judgement fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from transport.sims import lenses, light_field

FALSE_ALARM = 1e-5


def rows(module, particles=400_000, **case):
    result = tp.simulate(
        module.scene(**case), particles=particles, seed=1, estimator="backward", progress=False, threads=2
    )
    measured, exact = module.measure(result), module.exact(**case)
    for name, estimate in measured.items():
        if estimate.reason is None:
            assert_agrees(estimate, exact[name], FALSE_ALARM)
    return measured, exact


def test_a_film_is_as_bright_as_the_disk_of_its_lens():
    measured, exact = rows(lenses, show="film")
    for number in (0.7, 1.4):
        name = f"E on the axis, f/{number:g}"
        assert exact[name] == pytest.approx(100 * math.pi / (1 + 4 * number**2))
        assert_rejected(measured[name], 100 * math.pi / (4 * number**2))  # as D^2
    for angle in (20, 40):
        name, cosine = f"E({angle}°)/E(0°)", math.cos(math.radians(angle))
        assert exact[name] == pytest.approx(cosine**4, rel=0.03)  # within the pixel
        assert_rejected(measured[name], cosine)
        assert_rejected(measured[name], cosine**3)


@pytest.mark.parametrize("distance", lenses.EDGES)
def test_an_edge_is_smeared_over_the_circle_of_confusion(distance):
    measured, _ = rows(lenses, show="edge", distance=distance)
    if distance != lenses.FOCUS:
        name, pixels = lenses.BEFORE, lenses.positions(distance)[lenses.BEFORE]
        mirrored = 1 / (1 / lenses.FOCUS + abs(1 / distance - 1 / lenses.FOCUS) * 0.8)
        assert_rejected(measured[name], 100 * float(lenses.edge_profile(mirrored)[pixels].mean()))


def test_light_of_a_small_lens_is_the_area_of_its_part():
    """The share of a disk beyond a chord at x is (arccos x - x sqrt(1 - x^2))/pi; of the light on the axis by cos^4."""
    x = np.array([-0.9, 0.0, 0.5])
    axis, whole = np.zeros(3), np.full(3, math.pi / 2)
    for radius in (1e-4, 0.5):
        found = lenses._light_between(axis, np.arcsin(x), whole, radius)
        found /= lenses._light_between(axis, -whole, whole, radius)
        shares = (np.arccos(x) - x * np.sqrt(1 - x**2)) / math.pi
        if radius < 1e-3:
            assert found == pytest.approx(shares, rel=1e-6)
        else:
            assert (
                found[1] == pytest.approx(0.5, rel=1e-9)
                and found[2] < shares[2] < 0.5
                and found[0] > shares[0]
            )
    # All of it is the irradiance of a disk on its axis, of radiance 1: pi R^2/(1 + R^2).
    assert lenses._light_between(axis, -whole, whole, 0.5) == pytest.approx(math.pi * 0.2, rel=1e-9)


def test_parallel_rays_keep_widths_and_a_pinhole_does_not():
    for distance in (1.0, 4.0):
        measured, _ = rows(lenses, show="size", distance=distance)
        if distance > 1:
            assert_rejected(measured["width, orthographic"], 0.5 / distance)


def test_a_direction_lies_where_the_law_of_its_lens_puts_it():
    measured, _ = rows(lenses, show="wide")
    assert_rejected(measured["r at 60°, equal-area fisheye"], math.radians(60))
    assert_rejected(measured["r at 60°, fisheye"], 1.0)


def test_a_picture_out_of_a_light_field_is_the_cameras():
    """Also where panes of the near plane are black; a light field that is shifted by a cell is seen."""
    case = {"show": "view"}
    scene, how = light_field.scene(**case), {"estimator": "backward", "progress": False, "threads": 2}
    result = tp.simulate(
        scene, particles=1_200_000, batches=8, seed=1, **how
    )  # each cell has histories in each
    for name, estimate in light_field.measure(result).items():
        assert_agrees(estimate, light_field.exact(**case)[name], FALSE_ALARM)
    found, camera = light_field.picture_and_camera(result)
    black = camera.value == 0
    assert 0.2 < black.mean() < 0.5 and not found.value[black].any()
    for axis in (0, 1):
        shifted = tp.EstimateArray(
            np.roll(found.values, 1, axis=1 + axis), found.run, found.unit, found.dims, dict(found.coords)
        )
        assert light_field._compared(shifted, camera)[light_field.CHI_SQUARE].value > 1000


def test_a_lens_focused_afterwards_takes_the_picture_of_a_lens():
    rows(light_field, particles=1_000_000, show="refocus")


def test_flux_through_both_planes_is_radiance_times_throughput():
    measured, exact = rows(light_field, show="planes")
    area = light_field.CARD_SIZE[0] * light_field.CARD_SIZE[1] * 0.5 * 0.4
    for name in (light_field.FLUX, light_field.COUNTED):
        assert_rejected(measured[name], 100 * area / light_field.DISTANCE**2)  # without cosines
    assert exact[light_field.FLUX] == exact[light_field.COUNTED]


def test_slopes_give_distances():
    measured, _ = rows(light_field, particles=2_000_000, show="parallax")
    assert_rejected(measured[light_field.WHERE["near"]], light_field.DISTANCE)


@pytest.mark.parametrize("show", ["ball", "cube"])
def test_a_sphere_catches_all_light_that_leaves(show):
    measured, _ = rows(light_field, show=show)
    if show == "ball":
        assert_rejected(measured[light_field.DIVIDED], 100.0)


def test_rays_find_their_bins_on_the_sphere():
    """A picture out of a cube's spherical light field is that of the cube, but for the size of bins; no other one is."""
    result = tp.simulate(
        light_field.scene("cube"),
        particles=2_000_000,
        seed=1,
        estimator="backward",
        progress=False,
        threads=2,
    )
    for sight in ((0.3, 1.0, -0.25), (-1.0, 0.45, 0.35)):
        along = np.array(sight) / np.linalg.norm(sight)
        camera = tp.Camera(
            name="c",
            position=tuple(-3 * along),
            direction=sight,
            lens="orthographic",
            width=1.7,
            pixels=(40, 40),
        )
        found, cube = light_field.hologram_picture(result["sphere"], camera), light_field.cube_picture(camera)
        wrongs = found[:, ::-1], found[::-1], np.roll(found, 3, axis=0)
        right, *others = (np.corrcoef(each.ravel(), cube.ravel())[0, 1] for each in (found, *wrongs))
        assert right > 0.92 > 0.9 > max(others)
