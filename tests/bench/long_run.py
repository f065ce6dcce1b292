"""Whether memory stays flat in a long run: what is resident against the particles followed, of a run of 1e10 of them.

A cheap scene, two disks face to face, with bins of direction; for `particles`, and for as many in a run for an `error` that is
never reached, which merges its batches again and again.

python -m tests.bench.long_run [--particles 1e10] [--threads 2]
"""

import time
from unittest import mock

import typer

import transport as tp
from tests.bench.frame import memory
from transport.run.progress import Progress

ROWS = 12  # of a table
NEVER = 1e-9  # relative error


def scene() -> tp.Scene:
    """Two disks; a histogram of directions, and its total."""
    meter = tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.5)
    return tp.Scene(
        tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=100.0)),
        detectors=tp.Detector(meter, "meter", directions=tp.Directions(mu=16, phi=32)),
    )


class Watch:
    """Told of a run's progress, it writes down when, how many particles and how much memory."""

    def __init__(self, particles: float) -> None:
        self.particles, self.seen, self.begun = particles, [], time.perf_counter()

    def look(self, particles: float) -> None:
        """A row whenever another part of all particles is done."""
        if particles >= (len(self.seen) + 1) * self.particles / ROWS:
            self.seen.append((particles, time.perf_counter() - self.begun, memory() / 1e6))

    def table(self) -> str:
        """What was seen, and how much memory the second half of the run added."""
        rows = [f"{p:12.3g} {seconds:10.1f} {used:12.1f}" for p, seconds, used in self.seen]
        half, last = self.seen[len(self.seen) // 2 - 1][2], self.seen[-1][2]
        return "\n".join(
            [
                f"{'particles':>12} {'seconds':>10} {'resident, MB':>12}",
                *rows,
                f"second half: {last - half:+.1f} MB",
            ]
        )


def watched(particles: int, threads: int, **limits: object) -> Watch:
    """A run and what was seen of it."""
    watch = Watch(particles)
    with mock.patch.object(Progress, "running", lambda _, done, *rest: watch.look(done)):
        result = tp.simulate(scene(), particles, seed=1, threads=threads, progress=False, **limits)
    watch.look(result.cost.particles)
    print(f"{len(result.run)} batches, {result.cost.particles_per_second:.3g} particles/s")
    return watch


def main(particles: float = 1e10, threads: int = 2) -> None:
    """Print a table of each kind of run."""
    tp.simulate(scene(), 100_000, progress=False)
    for title, limits in (
        ("particles", {}),
        ("error", {"error": {"meter.flux_in": NEVER}, "estimator": "analog"}),
    ):
        print(f"limited by {title}")
        print(watched(int(particles), threads, **limits).table(), flush=True)


if __name__ == "__main__":
    typer.run(main)
