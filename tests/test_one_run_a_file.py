"""A checkpoint is one run's own: no other is written over, and two that go on at a time in one file are told."""

from __future__ import annotations

import errno
import os
import subprocess
import sys

import pytest

import transport as tp
from tests.own_experiments import ROOT
from tests.test_saved import SMALL, refusal
from transport.saved import lock

HOLDER = """
import pathlib, sys
from transport.saved.lock import held
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
        assert f"checkpoint must be a new file, but {b} is there; say resume='{b}'" in told
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
    assert f"checkpoint {path} is that of a run that goes on, process {other.pid} on" in told
    assert "name another file" in told and len(os.listdir(tmp_path)) == 1
    assert run(path, resume=path).particles == 1_000
    assert os.listdir(tmp_path) == ["run.npz"]


@pytest.mark.skipif(lock.fcntl is None, reason="the system has no such locks")
def test_where_there_are_no_locks_nobody_is_refused(tmp_path, monkeypatch):
    def unsupported(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(lock.fcntl, "flock", unsupported)
    run(tmp_path / "a.npz")
    monkeypatch.setattr(lock, "fcntl", None)
    run(tmp_path / "b.npz")
    assert sorted(os.listdir(tmp_path)) == ["a.npz", "b.npz"]


@pytest.mark.skipif(lock.fcntl is None, reason="the system has no such locks")
def test_a_lock_that_its_last_holder_removes_meanwhile_is_none(tmp_path, monkeypatch):
    """Else a third run would make another one, and both have the file to themselves."""
    path, flock, times = tmp_path / "run.npz", lock.fcntl.flock, []

    def late(*what):
        flock(*what)
        times.append(1)
        if len(times) == 1:
            (tmp_path / ".run.npz.lock").unlink()

    monkeypatch.setattr(lock.fcntl, "flock", late)
    with lock.held(path):
        assert os.listdir(tmp_path) == [".run.npz.lock"]
        assert "goes on" in refusal(lock.held(path).__enter__)
    assert os.listdir(tmp_path) == []
