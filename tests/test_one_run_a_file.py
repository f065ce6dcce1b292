"""A checkpoint is one run's own: no other is written over, and two that go on at a time in one file are told."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from types import SimpleNamespace

import pytest

import transport as tp
from tests.own_experiments import ROOT
from tests.test_saved import SMALL, refusal
from transport.io import atomic, resuming
from transport.io.atomic import FileError

HOLDER = """
import pathlib, sys
from transport.io.atomic import locked as held
with held(pathlib.Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


def run(path, **more):
    return tp.simulate(SMALL, **{"particles": 1_000, "checkpoint": path, "threads": 1} | more)


def test_no_other_run_is_written_over(tmp_path):
    a, b = tmp_path / "a.npz", tmp_path / "b.npz"
    first, other = run(a), run(b, seed=1)
    for resume in (a, first, None):
        told = refusal(run, b, resume=resume, particles=2_000)
        assert f"checkpoint must be a new file, but {b} exists; pass resume='{b}'" in told
    assert tp.load(b).seed == other.seed
    assert run(tmp_path / "." / "a.npz", resume=a, particles=2_000).particles == 2_000
    assert run(tmp_path / "c.npz", resume=a, particles=3_000).particles == 3_000
    assert (tp.load(a).particles, tp.load(tmp_path / "c.npz").particles) == (2_000, 3_000)
    b.unlink()
    b.symlink_to(a)
    assert run(b, resume=a, particles=4_000).particles == 4_000
    assert b.is_symlink() and tp.load(a).particles == 4_000


def test_a_second_run_in_the_same_file_is_refused_until_the_first_is_gone(tmp_path):
    """Also where that was killed, and what it held the file by was left."""
    path = tmp_path / "run.npz"
    command = [sys.executable, "-c", HOLDER, str(path)]
    with subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        other.stdout.readline()
        told = refusal(run, path, resume=path)
        other.kill()
    assert f"checkpoint {path} is in use by another run, process {other.pid} on" in told
    assert "name another file" in told and len(os.listdir(tmp_path)) == 1
    assert run(path, resume=path).particles == 1_000
    assert os.listdir(tmp_path) == ["run.npz"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot fork")
def test_a_child_does_not_keep_what_its_parent_held(tmp_path):
    """Though it live on: the lock goes with the process that took it."""
    path = tmp_path / "run.npz"
    forks = "os.fork() or (print('child', flush=True), time.sleep(60)); os._exit(0)"
    holder = "import os, time\n" + HOLDER.replace("sys.stdin.read()", forks)
    command = [sys.executable, "-c", holder, str(path)]
    other = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, start_new_session=True)
    try:
        assert [other.stdout.readline() for _ in range(2)] == [b"held\n", b"child\n"]  # which is under way
        assert other.wait(20) == 0
        assert run(path, resume=path).particles == 1_000
    finally:
        os.killpg(other.pid, signal.SIGKILL)


def test_two_links_to_a_file_are_one(tmp_path):
    for name in "ab":
        (tmp_path / f"{name}.npz").symlink_to(tmp_path / "run.npz")
    with (
        atomic.locked(tmp_path / "a.npz"),
        pytest.raises(FileError, match="in use by another run"),
        atomic.locked(tmp_path / "b.npz"),
    ):
        pass


def test_what_it_is_held_by_is_gone_before_another_may_take_it(tmp_path, monkeypatch):
    close, there = os.close, []

    def closing(descriptor):
        there.extend(os.listdir(tmp_path))
        close(descriptor)

    with atomic.locked(tmp_path / "run.npz"):
        monkeypatch.setattr(atomic.os, "close", closing)
    assert there == []


def test_where_it_cannot_be_written_is_told_before_the_run(tmp_path, monkeypatch):
    told = refusal(run, tmp_path / ("x" * 247 + ".npz"))
    assert "cannot be written: File name too long; name another file or folder" in told
    assert os.listdir(tmp_path) == []


def test_the_file_is_where_it_was_named_wherever_the_script_goes(tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    keep = resuming.Checkpoints("run.npz", 60.0, SMALL)
    monkeypatch.chdir("elsewhere")
    keep.end(tp.simulate(SMALL, particles=1_000, threads=1))
    assert (tmp_path / "run.npz").exists() and os.listdir() == []


def test_at_most_a_tenth_of_the_time_goes_into_writing(tmp_path, monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(resuming, "time", SimpleNamespace(perf_counter=lambda: clock[0]))
    monkeypatch.setattr(resuming, "save", lambda *_: clock.__setitem__(0, clock[0] + 30.0))
    keep = resuming.Checkpoints(tmp_path / "run.npz", 60.0, SMALL)
    clock[0] = 61.0
    keep.save_if_due(SimpleNamespace(batches=[1], now=lambda: None, result=lambda is_complete: None))
    assert keep.due - clock[0] >= 9 * 30.0


def test_a_file_is_on_the_disk_before_it_has_its_name_and_then_its_name_is(tmp_path, monkeypatch):
    done = []
    for name in ("fsync", "replace"):
        act = getattr(os, name)
        monkeypatch.setattr(atomic.os, name, lambda *a, act=act, name=name: (done.append(name), act(*a))[1])
    with atomic.atomic_write(tmp_path / "run.npz") as file:
        file.write(b"all")
    assert done == ["fsync", "replace", "fsync"]


@pytest.mark.skipif(atomic.fcntl is None, reason="the system has no such locks")
def test_where_there_are_no_locks_nobody_is_refused(tmp_path, monkeypatch):
    def unsupported(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(atomic.fcntl, "flock", unsupported)
    run(tmp_path / "a.npz")
    monkeypatch.setattr(atomic, "fcntl", None)
    run(tmp_path / "b.npz")
    assert sorted(os.listdir(tmp_path)) == ["a.npz", "b.npz"]


@pytest.mark.skipif(atomic.fcntl is None, reason="the system has no such locks")
def test_a_lock_that_its_last_holder_removes_meanwhile_is_none(tmp_path, monkeypatch):
    """Else a third run would make another one, and both have the file to themselves."""
    path, flock, times = tmp_path / "run.npz", atomic.fcntl.flock, []

    def late(*what):
        flock(*what)
        times.append(1)
        if len(times) == 1:
            (tmp_path / ".run.npz.lock").unlink()

    monkeypatch.setattr(atomic.fcntl, "flock", late)
    with atomic.locked(path):
        assert os.listdir(tmp_path) == [".run.npz.lock"]
        assert "in use" in refusal(atomic.locked(path).__enter__)
    assert os.listdir(tmp_path) == []
