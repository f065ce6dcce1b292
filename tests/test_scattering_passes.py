"""Which phase function turns what collides, and that it turns nothing else.

Passes are driven by themselves.  Each judgement fails right code in one of 10^6 seeds; beside each is a fault that it rejects.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ndtri

from tests.agreement import assert_follows
from tests.driven import Lanes
from tests.free_flights import FALSE_ALARM, LAST
from transport.compile import layout
from transport.engine.bundle import LANES
from transport.engine.passes import collisions


def test_phase_functions_are_chosen_by_medium_and_by_share():
    """Media 0 and 2 have one phase function each, medium 1 a mixture of three."""
    shares = [(1.0, 1), (0.2, 3), (0.5, 3), (1.0, 3), (1.0, 1)]
    laws = np.array([layout.row(layout.PHASE_LAW, share=s, parts=p) for s, p in shares], layout.PHASE_LAW)
    media = np.array([layout.row(layout.MEDIA, phase=n) for n in (1, 2, 5)], layout.MEDIA)
    table = {"rows": media.ctypes.data, "count": 3, "others": laws.ctypes.data, "other_count": 5}
    counts, numbers = np.zeros((3, 6), int), []
    for seed in range(300):
        lanes = Lanes(collides=np.arange(LANES) % 4 != 3, medium=np.arange(LANES) % 3)
        u0 = np.random.default_rng(seed).random(LANES)
        lanes["u0"] = u0
        lanes.run(collisions.choose_phase, **table)
        chosen, still = lanes["collides"], np.arange(LANES) % 4 == 3
        assert (chosen[still] == 0).all() and (lanes["u0"] == u0)[still | (lanes["medium"] != 1)].all()
        np.add.at(counts, (lanes["medium"][~still], chosen[~still]), 1)
        numbers.append(lanes["u0"][~still & (lanes["medium"] == 1)])
    assert counts[0, 1] == counts[0].sum() and counts[2, 5] == counts[2].sum()
    assert_follows(counts[1], [0, 0, 0.2, 0.3, 0.5, 0], FALSE_ALARM)
    assert_follows(np.histogram(np.concatenate(numbers), 20, (0, 1))[0], np.full(20, 0.05), FALSE_ALARM)
    with pytest.raises(AssertionError):  # shares that are not added up
        assert_follows(counts[1], [0, 0, 0.2, 0.5, 0.3, 0], FALSE_ALARM)


SCATTER = [
    (collisions.scatter_isotropic, {}, 0.0, 1 / 3),
    (collisions.scatter_henyey_greenstein, {"g": 0.8}, 0.8, 1 / 3 + 2 / 3 * 0.64),
    (collisions.scatter_henyey_greenstein, {"g": -0.3}, -0.3, 1 / 3 + 2 / 3 * 0.09),
    (collisions.scatter_rayleigh, {}, 0.0, 0.4),
]


@pytest.mark.parametrize(("scatter", "law", "g", "square"), SCATTER, ids=lambda v: getattr(v, "name", None))
def test_scattering_turns_what_collides_by_its_phase_function_and_nothing_else(scatter, law, g, square):
    """Mean cosine and mean square cosine about the old direction (a sign turned round shows), azimuths evenly."""
    old = np.array([0.36, -0.48, 0.8])
    across = np.array([0.8, 0.6, 0.0])
    cosines, turns = [], []
    for seed in range(200):
        lanes = Lanes(
            ux=old[0], uy=old[1], uz=old[2], collides=np.where(np.arange(LANES) % 2, 3, np.arange(LANES) % 5)
        )
        lanes["u0"], lanes["u1"] = np.random.default_rng(seed).random((2, LANES))
        mine = lanes["collides"] == 3
        lanes.run(scatter, number=3, **law)
        assert (lanes.directions[~mine] == old).all()
        new = lanes.directions[mine]
        np.testing.assert_allclose((new**2).sum(axis=1), 1, rtol=4e-15)
        cosines.append(new @ old)
        turns.append(np.arctan2(new @ np.cross(old, across), new @ across) / (2 * math.pi) % 1)
    cosines, turns = np.concatenate(cosines), np.concatenate(turns)
    for values, exact in ((cosines, g), (cosines**2, square)):
        limit = -ndtri(FALSE_ALARM / 2) * values.std() / math.sqrt(len(values))
        assert abs(values.mean() - exact) < limit < 0.02
    assert_follows(np.histogram(turns, 36, (0, 1))[0], np.full(36, 1 / 36), FALSE_ALARM)


@pytest.mark.parametrize("u1", [0.5 * 2.0**-32, 0.25, 0.5, 1 - 0.5 * 2.0**-32])
@pytest.mark.parametrize("u0", [0.0, 2.0**-52, 0.5, LAST])
@pytest.mark.parametrize("old", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.6, 0, -0.8)], ids=str)
def test_extreme_draws_scatter_into_directions_of_length_one(old, u0, u1):
    steps = [(scatter, law) for scatter, law, _, _ in SCATTER]
    steps += [(collisions.scatter_henyey_greenstein, {"g": g}) for g in (0.999, -0.999, 1e-15, -1e-15)]
    for scatter, law in steps:
        lanes = Lanes(collides=1, ux=old[0], uy=old[1], uz=old[2], u0=u0, u1=u1)
        lanes.run(scatter, number=1, **law)
        assert np.abs((lanes.directions**2).sum(axis=1) - 1).max() < 1e-14
        plainly = Lanes(collides=1, ux=old[0], uy=old[1], uz=old[2], u0=u0, u1=u1)
        plainly.run_plainly(scatter, number=1, **law)
        np.testing.assert_allclose(plainly.directions, lanes.directions, rtol=0, atol=1e-14)
