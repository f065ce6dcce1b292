"""A run in parts, each begun in one way, stopped, saved in either kind of file and ended in another: together bit for bit the whole."""

from __future__ import annotations

import itertools
import os
import signal

import pytest

import transport as tp
from tests.same_batches import assert_same
from tests.test_reproducible import scene
from transport.runs.running import Run

pytest.importorskip("distributed")
from tests.dask_cluster import DaskCluster

MANY = {"particles": 60_000, "batches": 96, "seed": 3}
WAYS = "one thread", "two threads", "one worker", "two workers"
PAIRS = list(itertools.product(WAYS, repeat=2))  # begun so, ended so


@pytest.fixture(scope="module")
def staffs():
    with DaskCluster(1) as one, DaskCluster(2) as two:
        yield dict(
            zip(
                WAYS,
                ({"threads": 1}, {"threads": 2}, {"cluster": one.address}, {"cluster": two.address}),
                strict=True,
            )
        )


def stopped(part, way, monkeypatch):
    """A part that is interrupted after two of its batches."""
    take = Run._take

    def interrupting(run, batch):
        take(run, batch)
        if run.done == 2:
            os.kill(os.getpid(), signal.SIGINT)

    with monkeypatch.context() as patch:
        patch.setattr(Run, "_take", interrupting)
        return tp.simulate(scene(), **MANY, part=part, **way)


def test_parts_done_in_any_way_are_together_the_whole(staffs, tmp_path, monkeypatch):
    parts = []
    for k, (begun, ended) in enumerate(PAIRS):
        path = tmp_path / f"{k}.{('npz', 'nc')[k % 2]}"
        half = stopped((k + 1, len(PAIRS)), staffs[begun], monkeypatch)
        assert not half.is_complete
        half.save(path)
        parts.append(tp.simulate(scene(), resume=path, **staffs[ended]))
    whole = tp.simulate(scene(), **MANY, threads=2)
    assert_same(tp.merge(*reversed(parts)).batches, whole.batches)
