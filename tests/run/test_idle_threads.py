"""A run with fewer batches than threads warns of idle threads, once, with their number and the cure."""

import warnings

import pytest

import transport as tp
from transport.run import run

SMALL = tp.Scene(
    tp.Source(tp.Disk(radius=1), tp.Lambertian(power=1.0)),
    detectors=tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1), "meter"),
)
WARNING = "2 batches for 3 threads leave 1 of them idle; start the run with batches={} or more"


@pytest.fixture(autouse=True)
def early(monkeypatch):
    monkeypatch.setattr(run, "RESPONSIVE_SECONDS", 0.0)
    monkeypatch.setattr(run, "POLL_SECONDS", 0.0)


@pytest.mark.parametrize(("more", "enough"), [({"batches": 2}, 3), ({"batches": 8, "part": (1, 4)}, 12)])
def test_idle_threads_are_warned_of_once(more, enough):
    with pytest.warns(run.IdleWarning) as warned:
        result = tp.simulate(SMALL, particles=20_000, threads=3, **more)
    assert len(warned) == 1 and WARNING.format(enough) in str(warned[0].message)
    assert sum(WARNING.format(enough) in warning for warning in result.warnings) == 1


def test_there_is_no_warning_where_all_threads_work():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not tp.simulate(SMALL, particles=20_000, threads=3, batches=3).warnings
        few = tp.simulate(SMALL, particles=20_000, threads=2, batches=32)
        assert not tp.simulate(SMALL, particles=20_500, threads=3, resume=few).warnings  # one batch more
