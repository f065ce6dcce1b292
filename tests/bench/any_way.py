"""Runs cut in parts, each of which is stopped, saved and taken up again in other ways, against the same undisturbed on one thread.

    python -m tests.bench.any_way [--runs 60] [--seed 1] [--minutes 10]

What each run goes through is drawn: its kind, how many parts, how often and where each is stopped, the kind of file, who does
the next leg (threads, workers of a cluster, processes of its own) and what happens to these meanwhile: a worker is killed that
holds batches, one comes late.  Every batch must be the same to the last bit; it ends with 1 if one is not.
"""

from __future__ import annotations

import tempfile
import time
from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import typer

import transport as tp
from tests.dask_cluster import DaskCluster, disturbed
from tests.media_scenes import TRACKINGS
from tests.plain_scenes import SCENES
from tests.same_batches import assert_same
from tests.test_any_way import stopped

MOST_WORKERS = 4
KINDS = {
    "surfaces": ("room", {"particles": 60_001, "batches": 60}),
    "volumes in media": ("pile", {"particles": 6_001, "batches": 48}),
    "weighted": ("cloud", {"particles": 12_001, "batches": 48}),
    "splitting": ("deep", {"particles": 6_001, "batches": 48, "tracking": TRACKINGS["deep"]}),
    "clock": ("flash", {"particles": 30_001, "batches": 48}),
    "snapshot": ("vessel", {"particles": 20_001, "batches": 48}),
    "backward": ("backward view", {"particles": 20_001, "batches": 48, "estimator": "backward"}),
    "expected": ("expected fog", {"particles": 6_001, "batches": 48, "estimator": "expected"}),
    "nets": ("room", {"particles": 60_000, "batches": 32, "sampling": "sobol"}),
    "rounds": ("room", {"error": {"-z.flux_in": 0.01}, "estimator": "analog", "sampling": "sobol"}),
    "error": ("room", {"error": {"-z.flux_in": 0.01}, "estimator": "analog"}),
    "error in media": ("pile", {"error": {"voxels.fluence_rate": 0.05}, "estimator": "analog"}),
}
WAYS = ("1 thread", "2 threads", "cluster", "processes")
LIKELY_WAYS = (0.22, 0.22, 0.5, 0.06)
HAPPENS = (None, "killed", "late")
LIKELY = (0.4, 0.4, 0.2)


def simulated(kind: str, **how) -> tp.Result:
    """A run of this kind; how: what differs from an undisturbed one."""
    scene, options = KINDS[kind]
    return tp.simulate(SCENES[scene](), **{"seed": 5} | options | how)


@cache
def whole(kind: str) -> list:
    """The batches of the undisturbed run."""
    return simulated(kind, threads=1).batches


class Drawn:
    """Random ways to do a run, by a cluster that grows, shrinks and dies with them."""

    def __init__(self, cluster: DaskCluster, folder: Path, rng: np.random.Generator) -> None:
        self.cluster, self.folder, self.rng = cluster, folder, rng
        self.counts: Counter[str] = Counter()
        self.told: list[str] = []  # of the present run

    def run(self, kind: str) -> list:
        """The batches of a run of this kind, however it is done."""
        self.told = []
        self._staff(int(self.rng.integers(1, MOST_WORKERS + 1)))
        if "error" in KINDS[kind][1]:  # which is not cut in parts
            return self._part(kind, (1, 1)).batches
        many = int(self.rng.integers(1, 4))
        parts = [self._part(kind, (k + 1, many)) for k in range(many)]
        self.rng.shuffle(parts)
        return (tp.merge(*parts) if many > 1 else parts[0]).batches

    def _part(self, kind: str, part: tuple[int, int]) -> tp.Result:
        """Begin a part, and stop, save and take it up again as often as is drawn."""
        legs, resume, said = int(self.rng.integers(1, 4)), {}, []
        asked = {} if part == (1, 1) else {"part": part}
        for leg in range(legs):
            result = self._leg(kind, resume | asked, leg == legs - 1, said)
            if result.is_complete:
                break
            path = self.folder / f"part.{self.rng.choice(['nc', 'npz'])}"
            result.save(path)
            resume = {"resume": tp.load(path)}
            path.unlink()
            said.append(f"-{path.suffix}->")
        self.told.append(" ".join(said))
        self.counts["parts"] += 1
        return result

    def _leg(self, kind: str, how: dict, is_last: bool, said: list[str]) -> tp.Result:
        way = str(self.rng.choice(WAYS, p=LIKELY_WAYS))
        if way == "cluster":
            return self._in_cluster(kind, how, is_last, said)
        options = {"cluster": "local"} if way == "processes" else {}
        self._tell(said, way)
        return self._done(kind, how | options | {"threads": 1 if way == "1 thread" else 2}, is_last)

    def _in_cluster(self, kind: str, how: dict, is_last: bool, said: list[str]) -> tp.Result:
        """With the workers that are there, to which something may happen."""
        happens = HAPPENS[self.rng.choice(len(HAPPENS), p=LIKELY)]
        if happens == "late" and len(self.cluster.workers) == MOST_WORKERS:
            happens = "killed"
        many = len(self.cluster.workers)
        with disturbed(self.cluster, happens) as happened:
            result = self._done(kind, how | {"cluster": self.cluster.address}, is_last)
        self._tell(said, f"{many} worker{'s' * (many > 1)}{''.join(f' ({what})' for what in happened)}")
        return result

    def _staff(self, wanted: int) -> None:
        """Let so many workers be there."""
        while len(self.cluster.workers) > wanted:
            self.cluster.kill_worker()
        while len(self.cluster.workers) < wanted:
            self.cluster.start_worker()
        self.cluster.wait_for(wanted)

    def _done(self, kind: str, how: dict, is_last: bool) -> tp.Result:
        """The rest of a part, or so many batches of its present leg."""
        if is_last:
            return simulated(kind, **how)
        scene, options = KINDS[kind]
        after = int(self.rng.integers(1, 9))
        with pytest.MonkeyPatch.context() as patch:
            return stopped(patch, SCENES[scene](), after, **{"seed": 5} | options | how)

    def _tell(self, said: list[str], what: str) -> None:
        said.append(what)
        self.counts.update({"legs": 1, what.partition(" (")[2].rstrip(")") or "undisturbed": 1})


def main(runs: int = 60, seed: int = 1, minutes: float = 10.0) -> None:
    begun, wrong, rng = time.monotonic(), 0, np.random.default_rng(seed)
    pytest.MonkeyPatch().setattr(
        "transport.run.dask.executor.GROUP_SECONDS", 0.01
    )  # many groups are out at a time
    names = list(KINDS)
    with DaskCluster(1) as cluster, tempfile.TemporaryDirectory() as folder:
        drawn = Drawn(cluster, Path(folder), rng)
        for number in range(runs):
            if time.monotonic() - begun > 60 * minutes:
                print(f"stopped after {number} of {runs} runs: {minutes:g} minutes are over")
                break
            kind = names[number % len(names)]
            try:
                assert_same(drawn.run(kind), whole(kind))
                verdict = "same"
            except Exception as error:
                verdict, wrong = f"UNLIKE: {type(error).__name__}: {error}", wrong + 1
            drawn.counts["runs"] += 1
            print(f"{number:3d} {kind:17s} {verdict:5s} {'; '.join(drawn.told)}", flush=True)
    counts = ", ".join(f"{many} {name}" for name, many in drawn.counts.items())
    print(f"{counts}; {wrong} unlike the undisturbed run; {time.monotonic() - begun:.0f} s")
    raise typer.Exit(wrong > 0)


if __name__ == "__main__":
    typer.run(main)
