"""Threads that have nothing to do are told of, with how many and what to say."""

import warnings

import pytest

import transport as tp
from tests.plain_scenes import SMALL
from transport.run import run

TOLD = "2 batches for 3 threads leave 1 of them idle; start the run with batches={} or more"


@pytest.fixture(autouse=True)
def soon(monkeypatch):
    monkeypatch.setattr(run, "RESPONSIVE_SECONDS", 0.0)
    monkeypatch.setattr(run, "POLL_SECONDS", 0.0)


@pytest.mark.parametrize(("more", "enough"), [({"batches": 2}, 3), ({"batches": 8, "part": (1, 4)}, 12)])
def test_idle_threads_are_told_of_once(more, enough):
    with pytest.warns(run.IdleWarning) as told:
        result = tp.simulate(SMALL, particles=20_000, threads=3, **more)
    assert len(told) == 1 and TOLD.format(enough) in str(told[0].message)
    assert sum(TOLD.format(enough) in warning for warning in result.warnings) == 1


def test_threads_that_all_work_are_not():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not tp.simulate(SMALL, particles=20_000, threads=3, batches=3).warnings
        few = tp.simulate(SMALL, particles=20_000, threads=2, batches=32)
        assert not tp.simulate(SMALL, particles=20_500, threads=3, resume=few).warnings  # one batch more
