"""Runs of trillions of histories, made by merging batches with themselves: no number runs over."""

from __future__ import annotations

from functools import reduce

import pytest

import transport as tp
from transport.results.result import Result

BATCHES, HISTORIES, DOUBLINGS = 16, 1600, 30


@pytest.fixture(scope="module")
def runs():
    """A short run with every kind of detector, and the same with all batches doubled: 1.7e12 histories."""
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    looks = [
        tp.Detector(tp.Sphere(radius=1.0), "meter", side="inside", directions=tp.Directions(mu=2)),
        tp.VolumeDetector(tp.Box(size=1.0), "box", cells=(2, 1, 1)),
        tp.PointDetector((0.5, 0.0, 0.2), "point"),
    ]
    fog = tp.Surface(tp.Sphere(radius=2.0), tp.Transparent(), inside=tp.Medium(scattering=1.0))
    short = tp.simulate(tp.Scene(lamp, fog, looks), HISTORIES, batches=BATCHES, seed=1, progress=False)
    whole = [reduce(lambda b, _: b.merged(b, 0), range(DOUBLINGS), batch) for batch in short.batches]
    return short, Result(short.plan, whole, 1, None, True, [])


@pytest.mark.parametrize("name", ["meter", "box", "point"])
def test_counts_of_a_trillion_histories_are_whole(runs, name):
    """The product of a batch's scores and all histories is beyond 2^63."""
    short, long = (run[name].counts for run in runs)
    assert long.value == pytest.approx(short.value * 2.0**DOUBLINGS, rel=1e-14)
    assert long.error == pytest.approx(short.error * 2.0**DOUBLINGS, rel=1e-9)


@pytest.mark.parametrize(
    "name", ["meter.flux_in", "meter.irradiance", "box.fluence_rate", "point.fluence_rate"]
)
def test_means_do_not_know_how_many_histories_there_were(runs, name):
    short, long = (run.quantity(name) for run in runs)
    assert long.value == pytest.approx(short.value, rel=1e-14)
    assert long.error == pytest.approx(short.error, rel=1e-9)


def test_the_ledger_the_report_and_the_quality_hold(runs):
    short, long = runs
    for part in short.ledger:
        assert long.ledger[part].value == pytest.approx(short.ledger[part].value, rel=1e-13)
    assert f"{HISTORIES << DOUBLINGS:_} particles" in long.report()
    assert long.quality("meter.flux_in").scores == short.quality("meter.flux_in").scores << DOUBLINGS
