"""A run in parts, each begun in one way, stopped, saved in either kind of file and ended in another: together bit for bit the whole.

Every way to begin meets every way to end; where a run is stopped, the kind of file and what happens to the cluster take
turns with them.  What meets what in all of these at once is for `python -m tests.bench.any_way`.
"""

from __future__ import annotations

import itertools
import os
import subprocess
import sys

import pytest

import transport as tp
from tests.processes import ROOT, pressing_ctrl_c
from tests.same_batches import assert_same, scene
from transport.run.executor import Executor
from transport.run.run import Run

pytest.importorskip("distributed")
from tests.dask_cluster import DaskCluster, disturbed

THREADS = {"one thread": 1, "two threads": 2}
WORKERS = {"one worker": 1, "two workers": 2, "three workers": 3}
EACH = 12  # batches of a part
PARTS = [*itertools.product((*THREADS, *WORKERS), repeat=2), ("three workers", "processes")]
MANY = {"particles": 150_000, "batches": EACH * len(PARTS), "seed": 3}

pytestmark = [pytest.mark.usefixtures("small_groups"), pytest.mark.slow]


@pytest.fixture(scope="module")
def cluster():
    with DaskCluster(1) as cluster:
        yield cluster


@pytest.fixture(scope="module")
def whole():
    return tp.simulate(scene(), **MANY, threads=2).batches


def stopped(monkeypatch, what, after, **options):
    """A run that is interrupted after so many batches, when hardly more are done: a fast machine would have done them all."""
    take, missing, taken = Run._take, Executor._missing, []

    def interrupting(run, batch):
        take(run, batch)
        taken.append(batch)
        if len(taken) == after:
            press()

    def begun(crew, sizes):
        return itertools.islice(missing(crew, sizes), after + 2)

    with monkeypatch.context() as patch, pressing_ctrl_c() as press:
        patch.setattr(Run, "_take", interrupting)
        patch.setattr(Executor, "_missing", begun)
        return tp.simulate(what, **options)


class Parts:
    """The parts of one run, each in a file of its own where it is begun, and ended from there."""

    def __init__(self, cluster, folder, monkeypatch):
        self.cluster, self.folder, self.monkeypatch = cluster, folder, monkeypatch
        self.ended, self.happened = [], []

    def begin(self, place, options):
        part = place + 1, len(PARTS)
        half = stopped(self.monkeypatch, scene(), 1 + place % 4, part=part, **MANY, **options)
        assert not half.is_complete and len(half.batches) < EACH // 2 + 1
        half.save(self._file(place))

    def end(self, place, options):
        self.ended.append(tp.simulate(scene(), resume=self._file(place), **options))

    def all_of(self, step, side, way, options, happens=None):
        """Begin or end (side 0 or 1) all parts of a way; something happens to the cluster in the last of them."""
        places = [place for place, part in enumerate(PARTS) if part[side] == way]
        for place in places[:-1]:
            step(place, options)
        with disturbed(self.cluster, happens) as happened:
            step(places[-1], options)
        self.happened += happened

    def _file(self, place):
        return self.folder / f"{place}.{'npz' if place % 5 else 'nc'}"  # which takes ten times as long


def test_parts_done_in_any_way_are_together_the_whole(cluster, whole, tmp_path, monkeypatch):
    """The cluster grows while they are begun, and shrinks while they are ended: a worker comes late, one is killed."""
    parts, there = Parts(cluster, tmp_path, monkeypatch), {"cluster": cluster.address}
    for way, threads in THREADS.items():
        parts.all_of(parts.begin, 0, way, {"threads": threads})
    for way, workers in WORKERS.items():
        parts.all_of(parts.begin, 0, way, there, "late" if workers < len(WORKERS) else None)
    for way in reversed(WORKERS):
        parts.all_of(parts.end, 1, way, there, "killed")
    for way, threads in THREADS.items():
        parts.all_of(parts.end, 1, way, {"threads": threads})
    parts.all_of(parts.end, 1, "processes", {"cluster": "local", "threads": 2})
    assert parts.happened == ["late"] * 2 + ["killed"] * 3
    assert len(parts.ended) == len(PARTS)
    assert_same(tp.merge(*reversed(parts.ended)).batches, whole)


def test_two_processes_that_do_a_half_each_are_together_the_whole(tmp_path):
    """By the command line, at the same time, knowing nothing of each other."""
    scene().to_json(tmp_path / "scene.json")
    how = "--particles", "20000", "--seed", "3", "--threads", "1"
    command = sys.executable, "-m", "transport", "run", "scene.json", *how
    halves = [
        subprocess.Popen(
            [*command, "--part", f"{k}/2", "--save", file],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            stdout=subprocess.DEVNULL,
        )
        for k, file in ((1, "1.nc"), (2, "2.npz"))
    ]
    assert [half.wait() for half in halves] == [0, 0]
    whole = tp.simulate(scene(), 20_000, seed=3, threads=2)
    assert_same(tp.merge(tmp_path / "2.npz", tmp_path / "1.nc").batches, whole.batches)
