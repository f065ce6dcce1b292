"""Runs that are saved all the time, and killed at random instants: no file is ever torn, and the end is that of an undisturbed run.

    python -m tests.bench.kills [--kills 50] [--seed 1]

A child is killed (SIGKILL) after a random time, of up to half the length of a whole run, begins again from its file, and
so on until it is done; then the next run begins, in the other format and of another kind.  The file is read after each kill.
"""

from __future__ import annotations

import hashlib
import math
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
import typer

import transport as tp
from tests.test_reproducible import scene

ROOT = Path(__file__).resolve().parents[2]
RUNS = {
    "particles": {"particles": 10_000_000, "batches": 400},
    "sobol": {"particles": 10_000_000, "batches": 64, "sampling": "sobol"},
    "error": {"error": {"ball.flux_in": 6e-4}, "estimator": "analog"},
    "short": {"particles": 3_000_000, "batches": 100},  # of the suite
}
KINDS = ("particles", "sobol", "error")
FILES = ("run.nc", "run.npz")


def digest(result: tp.Result) -> str:
    """Of all that the batches counted."""
    sums = hashlib.sha256()
    for batch in result.batches:
        parts = (
            batch.weights,
            batch.counts,
            batch.slants,
            batch.absorbed,
            np.array([*batch.ledger.values()]),
        )
        for part in (*parts, np.array([batch.first, batch.past, batch.histories])):
            sums.update(np.ascontiguousarray(part).tobytes())
    return sums.hexdigest()


def go_on(kind: str, path: str) -> None:
    """What the child does: begin, or go on, and save at every opportunity."""
    from transport.io import resuming

    resuming.MAX_WRITE_FRACTION = 1.0
    simulate = {**RUNS[kind], "threads": 2, "resume": path, "checkpoint": path, "every": 1e-3}
    tp.simulate(
        scene(), particles=2, sampling=RUNS[kind].get("sampling")
    )  # what compiles is not what is killed
    print("begins", flush=True)
    print(digest(tp.simulate(scene(), **simulate)), flush=True)


def killed_once(kind: str, path: Path, after: float) -> str | None:
    """Start the child and kill it after so many seconds; what it came to if it was done before."""
    command = [sys.executable, "-m", "tests.bench.kills", "--child", kind, "--file", str(path)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as child:
        child.stdout.readline()
        try:
            said, _ = child.communicate(timeout=after)
        except subprocess.TimeoutExpired:
            child.send_signal(signal.SIGKILL)
            child.communicate()
            return None
        if child.returncode:
            raise SystemExit(f"the child of {kind} failed")
        return said.strip()


def survives(kind: str, file: str, rng: np.random.Generator, most: int) -> tuple[int, int]:
    """Kills until the run is done or there are enough, and how many of them found a file.  Raises AssertionError for a torn one."""
    begun = time.perf_counter()
    whole = digest(tp.simulate(scene(), **RUNS[kind], threads=2))
    length, kills, found = time.perf_counter() - begun, 0, 0
    with tempfile.TemporaryDirectory() as folder:
        path, done, particles = Path(folder) / file, None, 0
        while done is None:
            done = killed_once(kind, path, rng.uniform(0, 0.5 * length) if kills < most else 600.0)
            kills += done is None
            if done is None and path.exists():
                saved, found = tp.load(path), found + 1
                assert saved.cost.particles >= particles, "the run has lost what it had saved"
                particles = saved.cost.particles
        assert done == whole, f"{kind} in {file}: {kills} kills have changed the result"
        left = [name for name in Path(folder).iterdir() if name != path]
        assert not left, left
    return kills, found


def main(kills: int = 50, seed: int = 1, child: str = "", file: str = "") -> None:
    if child:
        go_on(child, file)
        return
    rng, counts, number = np.random.default_rng(seed), Counter(), 0
    while counts["kills"] < kills:
        kind, name = KINDS[number % len(KINDS)], FILES[number % len(FILES)]
        share = math.ceil(kills / (len(KINDS) * len(FILES)))
        killed, found = survives(kind, name, rng, min(share, kills - counts["kills"]))
        print(f"{kind:10s} {name:8s} {killed} kills, {found} of them with a file; the end is the same")
        counts.update(kills=killed, found=found, runs=1)
        number += 1
    print(
        f"{counts['kills']} kills of {counts['runs']} runs, {counts['found']} files read, none torn, all ends the same"
    )


if __name__ == "__main__":
    typer.run(main)
