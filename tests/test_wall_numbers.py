"""The random numbers of an event at a wall know nothing of each other, and what is put back onto a sphere lies on it.

Passes are driven by themselves.  Each judgement fails right code in one of 10^6 seeds.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tests.agreement import assert_follows
from tests.driven import Lanes
from transport.compile import layout
from transport.engine.passes import landing, surfaces

FALSE_ALARM = 1e-6 / 10  # of ten pairs
NAMES = ("u0", "u1", "u2", "u3", "u4")


@pytest.fixture(scope="module")
def numbers():
    """(5, draws): those that make a direction, play roulette, choose a part and a speed."""
    events = []
    for seed in range(60):
        lanes = (
            Lanes(seed=seed, hit=1, event=seed).run(surfaces.draw_second_block).run(surfaces.draw_uniforms)
        )
        assert (lanes["event"] == seed + 1).all()
        events.append([lanes[name] for name in NAMES])
    return np.concatenate(events, axis=1)


def squares(one, other):
    return np.histogram2d(one, other, bins=8, range=[[0, 1]] * 2)[0]


def test_no_number_of_an_event_tells_of_another(numbers):
    for one, other in itertools.combinations(numbers, 2):
        assert_follows(squares(one, other), np.full(64, 1 / 64), FALSE_ALARM)
    with pytest.raises(AssertionError):
        assert_follows(squares(numbers[0], numbers[0]), np.full(64, 1 / 64), FALSE_ALARM)


def test_what_landed_beside_a_sphere_is_put_onto_it():
    """However far rounding has carried it: its normal points outwards, its distance from the centre is the radius."""
    sheets = np.zeros(2, layout.SHEET)
    sheets[1] = layout.row(layout.SHEET, cx=0.3, cy=-0.2, cz=0.1, radius=0.25, curvature=4.0)
    away = np.random.default_rng(1).normal(size=(3, len(Lanes()["x"])))
    away /= np.linalg.norm(away, axis=0)
    center, off = np.array([[0.3], [-0.2], [0.1]]), 0.25 * (1 + 1e-9)
    x, y, z = center + off * away
    lanes = Lanes(x=x, y=y, z=z, sheet=1, nx=0.0, ny=0.0, nz=0.0)
    lanes.run(landing.project_onto_sphere, rows=sheets.ctypes.data, count=len(sheets))
    place = np.stack([lanes["x"], lanes["y"], lanes["z"]]) - center
    np.testing.assert_allclose(np.linalg.norm(place, axis=0), 0.25, rtol=4e-15)
    np.testing.assert_allclose([lanes["nx"], lanes["ny"], lanes["nz"]], away, atol=1e-15)
