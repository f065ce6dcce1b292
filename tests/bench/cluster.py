"""What a cluster costs: workers of one thread against threads of this process, and what a group takes beyond its batches.

`python -m tests.bench.cluster [--seconds 30] [--repeats 3]`: own scheduler and workers on loopback; medians, in one run, one
after the other.  Wants a quiet machine with two cores; the load that there was is told with the figures.
"""

from __future__ import annotations

import argparse
import os
from statistics import median

import transport as tp
from tests.dask_cluster import DaskCluster
from tests.test_reproducible import scene
from transport.cluster.line import Line

THREADS = 2


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=30.0, help="that two threads take")
    parser.add_argument("--repeats", type=int, default=3)
    asked = parser.parse_args()
    rate = tp.simulate(scene(), seconds=2.0, threads=THREADS, progress=False).cost.particles_per_second
    limits = {"particles": int(rate * asked.seconds), "batches": 512, "progress": False}
    here, there, groups = [], [], []
    with DaskCluster(THREADS) as cluster:
        tp.simulate(scene(), particles=10_000, cluster=cluster.address, progress=False)
        for _ in range(asked.repeats):
            here.append(tp.simulate(scene(), threads=THREADS, **limits).cost.seconds)
            lines = _opened()
            there.append(tp.simulate(scene(), cluster=cluster.address, **limits).cost.seconds)
            groups.append(lines[-1].sent)
    beyond = (median(there) - median(here)) * THREADS / median(groups)
    print(f"{limits['particles']:.3g} particles, load {os.getloadavg()[0]:.1f}")
    print(f"{THREADS} threads {median(here):.2f} s, {THREADS} workers {median(there):.2f} s")
    print(
        f"efficiency {median(here) / median(there):.3f}, {median(groups):.0f} groups, {1e3 * beyond:.1f} ms beyond each"
    )


def _opened() -> list[Line]:
    """The lines that are opened from now on."""
    lines, first = [], Line.open

    def opened(line, tell):
        lines.append(line)
        Line.open = first
        first(line, tell)

    Line.open = opened
    return lines


if __name__ == "__main__":
    main()
