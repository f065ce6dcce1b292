"""What a cluster costs: workers of one thread against threads of this process, and what a group takes beyond its batches.

`python -m tests.bench.cluster [--seconds 30] [--repeats 3]`: own scheduler and workers on loopback; medians, in one run, one
after the other.  Wants a quiet machine with two cores; the load that there was is told with the figures.

A group's overhead is the time that a worker's thread is without a batch between two groups; what it costs all processes
together, where they share the cores, is in the efficiency.  The first and last groups wait for nobody: what the run takes
before its first and after its last group is told by itself.
"""

from __future__ import annotations

import os
import time
from itertools import pairwise
from statistics import fmean, median

import typer
from distributed import Client

import transport as tp
from tests.dask_cluster import DaskCluster
from tests.test_reproducible import scene
from transport.run.dask.worker import RunPlugin

THREADS = 2
SPANS: list[tuple[float, float]] = []  # of a worker: when it began a group, and when its batches were done


def main(seconds: float = typer.Option(30.0, help="Of a run on two threads"), repeats: int = 3) -> None:
    """Print medians of the runs on threads and on workers, and the time between two groups."""
    rate = tp.simulate(
        scene(), seconds=2.0, threads=THREADS, estimator="analog", progress=False
    ).cost.particles_per_second
    limits = {"particles": int(rate * seconds), "batches": 512, "progress": False}
    here, there, gaps, apart = [], [], [], []
    with DaskCluster(THREADS) as cluster, Client(cluster.address, set_as_default=False) as client:
        client.run(watch)
        tp.simulate(scene(), particles=10_000, cluster=cluster.address, progress=False)
        for _ in range(repeats):
            here.append(tp.simulate(scene(), threads=THREADS, **limits).cost.seconds)
            client.run(forget)
            begun = time.time()
            there.append(tp.simulate(scene(), cluster=cluster.address, **limits).cost.seconds)
            spans = list(client.run(seen).values())
            gaps.append([after[0] - before[1] for one in spans for before, after in pairwise(one)])
            apart.append(
                time.time() - begun - max(one[-1][1] for one in spans) + min(one[0][0] for one in spans)
            )
    each = [gap for run in gaps for gap in run]
    print(f"{limits['particles']:.3g} particles, load {os.getloadavg()[0]:.1f}")
    print(f"{THREADS} threads {median(here):.2f} s, {THREADS} workers {median(there):.2f} s")
    print(f"efficiency {median(here) / median(there):.3f}, {median(map(len, gaps)) + THREADS:.0f} groups")
    print(
        f"between two groups of a worker: mean {1e3 * fmean(each):.2f} ms, median {1e3 * median(each):.2f} ms"
    )
    print(f"before the first and after the last group: {median(apart):.2f} s")


def watch() -> None:
    """Let this worker remember when it does its groups."""
    work = RunPlugin.work

    def watched(plugin, *arguments):
        begun = time.time()
        done = work(plugin, *arguments)
        SPANS.append((begun, time.time()))
        return done

    RunPlugin.work = watched


def forget() -> None:
    SPANS.clear()


def seen() -> list[tuple[float, float]]:
    return SPANS


if __name__ == "__main__":
    # Its functions find its SPANS at the workers, as those of __main__ do not.
    from tests.bench import cluster

    typer.run(cluster.main)
