"""Speeds at their ends: particles at rest, and speeds over twelve decades in one run.

All runs have seed 1.  Most of it is asked of integers; statistical judgements fail right code in one of 10^6 seeds.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_follows
from tests.hard.clocked_runs import counts, histories, mirrored_box, run

FALSE_ALARM = 1e-6


# ---- at rest ----


@pytest.mark.parametrize("walls", [(), (mirrored_box(),)], ids=["open", "mirrored"])
@pytest.mark.parametrize("direction", [None, (0.3, 0.2, 1.0)])
@pytest.mark.parametrize("looks", ["meter", "all"])
def test_particles_at_rest_stay_where_they_are_and_meet_nothing(walls, direction, looks):
    """With and without something that looks at speeds."""
    edges, times = (-1.0, -0.2, 0.3, 1.0), (0.0, 1.0, 5.0)
    meter = tp.Detector(tp.Sphere(radius=0.4), "meter", times=3)
    found = [meter]
    if looks == "all":
        found += [
            tp.PhaseSpace(x=edges, time=times, moments=True),
            tp.PhaseSpace(speed=(0, 1), time=5.0, name="v"),
        ]
        found += [tp.Snapshot(t, particles=10_000, name=f"at {t:g}") for t in times]
    gas = tp.Source(tp.Box(size=1.5), tp.Gas(number=7.0, speed=0.0, direction=direction))
    result = run(tp.Scene(gas, walls, found, duration=5.0))
    assert (counts(result["meter"]) == 0).all() and result.cost.crossings == 0
    assert result.ledger["in_flight"].value == pytest.approx(7.0, rel=1e-14)
    if looks == "all":
        number = histories(result, result["phase_space"].number.value)
        assert (number == number[0]).all() and (number.sum(axis=1) == 10_000).all()
        assert histories(result, result["v"].number.value) == 10_000
        assert (result["phase_space"].mean_speed.value == 0).all()
        first, last = (result[f"at {t:g}"] for t in (0.0, 5.0))
        assert (first.velocities == 0).all() and len(first) == 10_000
        np.testing.assert_array_equal(first.positions, last.positions)


def rest_or_fly(u):
    return np.where(u < 0.5, 0.0, 1.0)


def test_those_at_rest_among_others_are_neither_moved_nor_lost():
    gas = tp.Source(tp.Sphere(radius=0.2), tp.Gas(number=2.0, speed=tp.InverseCDF(rest_or_fly)))
    shots = [tp.Snapshot(t, particles=10_000, name=f"at {t:g}") for t in (0.0, 4.0)]
    ball = tp.Surface(tp.Sphere(radius=0.5), tp.Diffuse(1.0))
    result = run(
        tp.Scene(gas, ball, [*shots, tp.PhaseSpace(speed=(0, 0.5, 2), time=(0.0, 4.0))], duration=4.0)
    )
    number = histories(result, result["phase_space"].number.value)
    assert (number[0] == number[1]).all() and number[0].sum() == 10_000
    assert_follows(number[0], [0.5, 0.5], FALSE_ALARM)
    for name in ("at 0", "at 4"):
        speeds = np.linalg.norm(result[name].velocities, axis=1)
        assert np.isin(np.round(speeds, 12), (0.0, 1.0)).all()
    first, last = ({h: tuple(x) for h, x, v in zip(
        zip(s.batches, s.histories, strict=True), s.positions, s.velocities, strict=True) if not v.any()}
        for s in (result["at 0"], result["at 4"]))  # fmt: skip
    assert first == last and len(first) == number[0][0]
    assert result.ledger["in_flight"].value == pytest.approx(2.0, rel=1e-14)


# ---- twelve decades ----

DECADES = 10.0 ** np.arange(-12, 1)


def twelve_decades(u):
    return 10.0 ** (12 * u - 12)


@lru_cache(maxsize=1)
def spread():
    """Log-uniform speeds from 1e-12 to 1 m/s in a box of one thermal, one half-mirroring and four mirroring walls."""
    faces = tp.Box(size=1.0).faces()
    half = tp.Mixture({tp.Mirror(): 0.5, tp.Diffuse(1.0): 0.5})
    kinds = [tp.Diffuse(1.0, speed=tp.InverseCDF(twelve_decades)), half] + [tp.Mirror()] * 4
    walls = [tp.Surface(f, kind, n) for (n, f), kind in zip(faces.items(), kinds, strict=True)]
    gas = tp.Source(tp.Box(size=1.0), tp.Gas(number=1.0, speed=tp.InverseCDF(twelve_decades)))
    looks = [
        tp.PhaseSpace(speed=DECADES, time=(0.0, 20.0), moments=True),
        tp.PhaseSpace(x=(-0.5, 0.0, 0.5), speed=DECADES, time=20.0, name="by place"),
        *[tp.Snapshot(t, particles=100_000, name=f"at {t:g}") for t in (0.0, 20.0)],
    ]
    return run(tp.Scene(gas, walls, looks, duration=20.0), 48_000)


def test_every_decade_has_its_share_and_none_of_its_particles_is_lost():
    result = spread()
    number = histories(result, result["phase_space"].number.value)
    assert number.shape == (2, 12) and (number.sum(axis=1) == 48_000).all()
    assert_follows(number[0], np.full(12, 1 / 12), FALSE_ALARM)
    assert histories(result, result["by place"].number.value).sum() == 48_000
    # The slow have not met a wall; of those that have, some were given another speed.
    assert abs(number[1, :9].sum() - number[0, :9].sum()) < 0.2 * number[0, :9].sum()
    assert number[1, 11] != number[0, 11]
    for name in ("in_flight", "emitted"):
        assert result.ledger[name].value == pytest.approx(1.0, rel=1e-14)
    assert result.ledger["lost"].value == result.ledger["escaped"].value == 0
    assert result.cost.crossings > 50_000


@pytest.mark.parametrize("decade", range(12))
def test_moments_of_a_decade_are_those_of_its_particles(decade):
    """Sums of v down to 1e-12 and of v² to 1e-24 of the fastest, beside those of the fastest themselves."""
    result = spread()
    for k, time in enumerate((0.0, 20.0)):
        shot, found = result[f"at {time:g}"], result["phase_space"]
        v = shot.velocities[in_decade(shot, decade)]
        speeds, n = np.linalg.norm(v, axis=1), len(v)
        width = DECADES[decade + 1] - DECADES[decade]
        flux = speeds.sum() * result.ledger["emitted"].value / result.particles / width
        assert found.fluence_rate.value[k, decade] == pytest.approx(flux, rel=1e-9, abs=0)
        assert found.mean_speed.value[k, decade] == pytest.approx(speeds.mean(), rel=20 / n, abs=0)
        spread_ = np.sqrt(v.var(axis=0) / n)
        for j, axis in enumerate("xyz"):
            mean = getattr(found, f"mean_v{axis}").value[k, decade]
            assert mean == pytest.approx(v[:, j].mean(), rel=0, abs=0.1 * spread_[j])
            variance = getattr(found, f"variance_v{axis}").value[k, decade]
            assert variance == pytest.approx(v[:, j].var(), rel=40 / n, abs=0)
            assert variance != pytest.approx(1.02 * v[:, j].var(), rel=40 / n, abs=0)


def in_decade(shot, decade):
    speeds = np.linalg.norm(shot.velocities, axis=1)
    return (speeds >= DECADES[decade]) & (speeds < DECADES[decade + 1])


def test_slow_particles_beside_fast_ones_have_moved_by_v_t():
    """Those below 1e-4 m/s: at the far end of the box after 20 s only if a wall was within 2 mm."""
    result = spread()
    shots = [result[f"at {t:g}"] for t in (0, 20)]
    order = [np.lexsort((s.histories, s.batches)) for s in shots]
    (x, v), (y, w) = ((s.positions[o], s.velocities[o]) for s, o in zip(shots, order, strict=True))
    slow = (np.abs(x) < 0.497).all(axis=1) & (np.linalg.norm(v, axis=1) < 1e-4)
    assert slow.sum() > 20_000
    np.testing.assert_array_equal(w[slow], v[slow])
    np.testing.assert_allclose(y[slow], x[slow] + 20 * v[slow], rtol=0, atol=1e-15)
