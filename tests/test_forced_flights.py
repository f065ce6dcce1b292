"""Forced collisions: as likely as they would be and where they would be.

Passes are driven by themselves.  Each judgement fails right code in one of 10^6 seeds; beside each is a fault that it rejects.
"""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_follows
from tests.driven import Lanes
from tests.free_flights import FALSE_ALARM, WORDS, draw_only
from transport.compile import layout
from transport.engine.bundle import LANES
from transport.engine.passes import variance_reduction


@pytest.mark.parametrize("tau", [1e-12, 1e-6, 0.1, 2.0, 40.0])
def test_a_forced_collision_is_as_likely_as_it_would_be_and_where_it_would_be(tau):
    """Of w the share 1 - exp(-tau) flies to a collision before the surface, by the exponential law cut off there."""
    depths, mfp = [], 0.5
    for seed in range(200):
        lanes = Lanes(seed=seed, mfp=mfp, start=-0.5, weight=0.75, forced_path=variance_reduction.UNCOLLIDED)
        lanes.run(variance_reduction.sample_free_or_forced_path)
        assert np.isinf(lanes["distance"]).all()
        lanes["distance"] = -0.5 + tau * mfp
        way = lanes["distance"] + 0.5
        lanes.run(variance_reduction.force_collision)
        assert (lanes["copies"] == 1).all() and (lanes["forced_path"] == variance_reduction.UNCOLLIDED).all()
        np.testing.assert_allclose(lanes["copy_weight"], -0.75 * np.expm1(-way / mfp), rtol=1e-15)
        np.testing.assert_allclose(lanes["weight"] + lanes["copy_weight"], 0.75, rtol=1e-15)
        assert abs(lanes.gained(layout.ROULETTE)) <= LANES * 2.0**-52
        assert (lanes["copy_path"] > 0).all() and (lanes["copy_path"] <= way).all()
        depths.append(lanes["copy_path"] / way)
    depths, cells = np.concatenate(depths), np.linspace(0, 1, 41)
    through = np.expm1(-tau * cells) / np.expm1(-tau)
    assert_follows(np.histogram(depths, cells)[0], np.diff(through), FALSE_ALARM)
    if tau >= 0.1:
        with pytest.raises(AssertionError):  # evenly along the way
            assert_follows(np.histogram(depths, cells)[0], np.diff(cells), FALSE_ALARM)


def test_nothing_is_forced_in_vacuum_without_a_surface_ahead_or_twice():
    kinds = np.arange(LANES) % 4
    ahead = np.where(kinds == 2, variance_reduction.FREE, variance_reduction.UNCOLLIDED)
    lanes = Lanes(mfp=np.where(kinds == 0, np.inf, 1.0), forced_path=ahead).run(
        variance_reduction.sample_free_or_forced_path
    )
    distance = lanes["distance"]
    lanes["distance"] = np.where(kinds == 3, 1.0, distance)
    lanes.run(variance_reduction.force_collision)
    assert (lanes["copies"] == (kinds == 3)).all()
    assert (lanes["weight"] == 1.0)[kinds != 3].all()
    assert (
        lanes["forced_path"]
        == np.where(np.isin(kinds, (1, 2)), variance_reduction.FREE, variance_reduction.UNCOLLIDED)
    ).all()
    assert np.isinf(lanes["distance"])[kinds == 0].all() and np.isfinite(lanes["distance"])[kinds != 0].all()


def test_a_copy_flies_its_own_path_once():
    lanes = Lanes(forced_path=0.125).run(variance_reduction.sample_free_or_forced_path)
    np.testing.assert_allclose(lanes["distance"], 0.125, rtol=1e-12)
    assert (lanes["forced_path"] == variance_reduction.FREE).all()
    lanes["distance"], lanes["hit"] = 0.0, 0
    assert len(np.unique(lanes.run(variance_reduction.sample_free_or_forced_path)["distance"])) == LANES


@pytest.mark.parametrize("word", WORDS.values(), ids=WORDS)
@pytest.mark.parametrize("tau", [1e-300, 1e-12, 1.0, 1e4])
def test_extreme_draws_force_collisions_within_the_way(word, tau, monkeypatch):
    draw_only(word, monkeypatch)
    lanes = Lanes(forced_path=variance_reduction.UNCOLLIDED).run_plainly(
        variance_reduction.sample_free_or_forced_path
    )
    lanes["distance"] = tau
    lanes.run_plainly(variance_reduction.force_collision)
    assert ((lanes["copy_path"] > 0) & (lanes["copy_path"] <= tau)).all()
    assert ((lanes["weight"] >= 0) & (lanes["copy_weight"] > 0)).all()


@pytest.mark.parametrize("tau", [1e-2, 1e-4, 1e-6])
def test_what_was_forced_is_not_rouletted_for_being_light(tau):
    """Every history of a pencil beam scatters the same: its albedo times 1 - exp(-tau).

    Roulette that compared a forced copy with the whole birth weight would kill 99 of 100 copies, or more.
    """
    albedo, radius = 0.9, 1.0
    fog = tp.Medium(absorption=(1 - albedo) * tau / (2 * radius), scattering=albedo * tau / (2 * radius))
    scene = tp.Scene(
        tp.Source(tp.Point(position=(0, 0, -2)), tp.Beam((0, 0, 1), power=1.0)),
        tp.Surface(tp.Sphere(radius=radius), tp.Transparent(), "ball", inside=fog),
        tp.Detector(tp.Sphere(radius=10.0), "sky", side="inside", events=(1, 1)),
    )
    result = tp.simulate(scene, 2000, seed=1, tracking=tp.Tracking(forced=True), progress=False)
    scattered = result["sky"].flux_in
    assert scattered.value == pytest.approx(albedo * tau, rel=2 * tau)
    assert scattered.relative_error <= tau
