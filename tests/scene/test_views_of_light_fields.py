"""Pictures out of a light field: the value of each ray's cell, and no value where a ray misses."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.refusals import assert_refused

FIELD = tp.LightField(
    name="field", position=(0, 0, 0), direction=(0, 1, 0), distance=1.0, size=(0.2, 0.2), far_size=(1.0, 1.0),
    views=(2, 2), pixels=(4, 4),
)  # fmt: skip


def camera(x: float = 0.0, back: float = 0.1, pixels: int = 4, reach: float = 1.0) -> tp.Camera:
    """A camera behind the near plane that sees `reach` of the far one."""
    angle = 2 * math.atan(reach / 2 / (1.0 + back))
    place = (x, -back, 0.0)
    return tp.Camera(
        name="view", position=place, direction=(0, 1, 0), field_of_view=angle, pixels=(pixels, pixels)
    )


def test_a_pixel_has_the_value_of_the_cell_that_its_rays_pass_through():
    u, v, s, t = np.meshgrid(*(np.arange(len(e) - 1) for e in FIELD.edges().values()), indexing="ij")
    picture = FIELD.view(1000.0 * u + 100.0 * v + 10.0 * s + t, camera())
    rows, columns = np.meshgrid(np.arange(4), np.arange(4), indexing="ij")  # up, and to the right
    assert picture == pytest.approx(1000.0 * (columns // 2) + 100.0 * (rows // 2) + 10.0 * columns + rows)


def test_pixels_of_which_rays_miss_have_no_value():
    """Also those of which all rays miss: not 0, as if it were dark there."""
    ones = np.ones((2, 2, 4, 4))
    picture = FIELD.view(ones, camera(pixels=8, reach=2.0))
    inside = np.zeros((8, 8), bool)
    inside[2:6, 2:6] = True
    assert np.isnan(picture[~inside]).all() and picture[inside] == pytest.approx(1.0)
    assert_refused(lambda: FIELD.view(ones, camera(x=10.0)), "each pixel of ... has rays that miss them")
