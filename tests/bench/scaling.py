"""How far a run scales, on paper: what a batch costs beside its histories is measured here, and the rest of a cluster is simulated.

Measured: seconds of a batch without histories, bytes of its sums and what packing, unpacking, a loopback connection and
merging them take.  Assumed, and printed: what a scheduler and a network take for a task.  Then the queues of a run are
played through, with the groups that `transport.run.dask` would send: workers with a few groups each, one scheduler, one
client, each of which does one thing at a time.

python -m tests.bench.scaling [--bins 512] [--batch 0.3] [--scheduler 1e-3] [--client 1e-3] [--latency 1e-3] [--network 1e8]
"""

import heapq
import itertools
import pickle
import socket
import statistics
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import typer

import transport as tp
from transport.compile.compiler import compile_scene
from transport.engine.bundle import empty_bundle
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program
from transport.results.batches import Batch, batch_of
from transport.run.dask.executor import GROUPS_IN_FLIGHT, Groups
from transport.run.schedules import MAX_BATCH_SIZE
from transport.run.settings import MAX_BATCHES, MAX_PARTICLES

LONGEST = MAX_PARTICLES * 100 // MAX_BATCH_SIZE + 1  # batches of the longest run
WORKERS = (1, 2, 10, 100, 1000, 3000, 10_000)
REPEATS = 50
HISTORIES = 1 << 16  # of the batch whose sums are sent and merged


@dataclass(frozen=True)
class Costs:
    """Of one batch, but for its histories [s], and the size of its sums [bytes]; seconds of a history."""

    history: float
    batch: float
    size: int
    pack: float
    unpack: float
    loopback: float
    merge: float


@dataclass(frozen=True)
class Assumed:
    """Of a cluster: what the scheduler and the client take for a task [s], how far away workers are [s], bytes a second."""

    scheduler: float
    client: float
    latency: float
    network: float


def scene(bins: int) -> tp.Scene:
    """Two disks; a row of bins."""
    meter = tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.5)
    return tp.Scene(
        tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=100.0)),
        detectors=tp.Detector(meter, "meter", positions=tp.Positions(u=bins)),
    )


def measured(bins: int) -> Costs:
    """What a batch with so many bins costs on this machine, medians."""
    machine, bundle = compile_program(build_program(compile_scene(scene(bins)))), empty_bundle()
    plan = machine.program.plan

    def batch(histories: int) -> Batch:
        return batch_of(plan, run_batch(machine, 1, 0, histories, bundle))

    idle, busy = (median(lambda: batch(1)), median(lambda: batch(HISTORIES)))
    one = batch(HISTORIES)
    packed = pickle.dumps(one, protocol=5)
    return Costs(
        history=max(busy - idle, 1e-12) / HISTORIES,
        batch=idle,
        size=len(packed),
        pack=median(lambda: pickle.dumps(one, protocol=5)),
        unpack=median(lambda: pickle.loads(packed)),
        loopback=sent(packed),
        merge=median(lambda: one.merged(one, 0)),
    )


def median(work: Callable[[], object]) -> float:
    """Seconds that it takes."""
    times = []
    for _ in range(REPEATS):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return statistics.median(times)


def sent(packed: bytes) -> float:
    """Seconds until so many bytes are at the other end of a loopback connection and a byte has come back."""
    with (
        socket.create_server(("127.0.0.1", 0)) as server,
        socket.create_connection(server.getsockname()) as one,
    ):
        other, _ = server.accept()

        def answer() -> None:
            for _ in range(REPEATS):
                left = len(packed)
                while left:
                    left -= len(other.recv(min(left, 1 << 20)))
                other.sendall(b"!")

        thread = threading.Thread(target=answer)
        thread.start()
        found = median(lambda: (one.sendall(packed), one.recv(1)))
        thread.join()
        other.close()
    return found


def efficiency(workers: int, batches: int, histories: int, costs: Costs, assumed: Assumed) -> float:
    """Seconds of histories over seconds that the workers were there, of a leg that so many threads do."""
    each = costs.batch + histories * costs.history
    groups = Groups()
    groups.add([(histories, each)] * batches, costs.size * batches)  # as in the midst of a run
    groups.put_back((number, histories) for number in range(batches))
    taken_in = costs.unpack + costs.merge + costs.size / assumed.network
    scheduler = client = 0.0  # when they are free again
    free = [0.0] * workers
    places = [
        (0.0, worker, 0) for worker in range(workers)
    ] * GROUPS_IN_FLIGHT  # in a worker's queue: from when on, and what comes back
    heapq.heapify(places)
    while places:
        came, worker, done = heapq.heappop(places)
        client = max(client, came) + done * taken_in
        if groups.waiting:
            group = groups.take(workers)
            client += assumed.client
            scheduler = max(scheduler, client) + assumed.scheduler
            free[worker] = max(free[worker], scheduler + assumed.latency) + len(group) * (each + costs.pack)
            heapq.heappush(places, (free[worker] + assumed.latency, worker, len(group)))
    return batches * histories * costs.history / (workers * client)


def main(
    bins: list[int] = typer.Option([1, 512, 1_000_000]),  # noqa: B008
    batch: list[float] = typer.Option([0.3, 3.0, 30.0], help="Seconds of its histories"),  # noqa: B008
    scheduler: float = typer.Option(1e-3, help="Seconds per task"),
    client: float = typer.Option(1e-3, help="Seconds per task, beside taking in sums"),
    latency: float = typer.Option(1e-3, help="Seconds one way"),
    network: float = typer.Option(1e8, help="Bytes per second into the client"),
) -> None:
    """Print a table of efficiencies per number of bins."""
    assumed = Assumed(scheduler, client, latency, network)
    print(
        f"assumed: {1e3 * assumed.scheduler:g} ms a task of the scheduler and {1e3 * assumed.client:g} ms of the client,"
        f" {1e3 * assumed.latency:g} ms one way, {assumed.network / 1e6:g} MB/s into the client; workers alike, with one"
        f" thread each, none is lost; all batches in one leg\n{MAX_BATCHES} batches are the most that one may ask for,"
        f" {LONGEST} those of the longest run, {MAX_PARTICLES * 100:.0e} particles: more workers than that have nothing to do"
    )
    for count in bins:
        costs = measured(count)
        print(f"\n{count} bins: {told(costs)}")
        print("    batches of        s" + "".join(f"{workers:>8}" for workers in WORKERS) + " workers")
        for batches, seconds in itertools.product((MAX_BATCHES, LONGEST), batch):
            histories = max(1, round(seconds / costs.history))
            found = [efficiency(workers, batches, histories, costs, assumed) for workers in WORKERS]
            row = "".join(f"{100 * each:7.1f}%" for each in found)
            print(f"{batches:>11} {seconds:>9g}{row}", flush=True)


def told(costs: Costs) -> str:
    """What was measured."""
    parts = {"idle": costs.batch, "pack": costs.pack, "unpack": costs.unpack, "loopback": costs.loopback}
    times = ", ".join(f"{name} {1e3 * each:.3g}" for name, each in (parts | {"merge": costs.merge}).items())
    return f"sums of a batch {costs.size / 1e3:.3g} kB; ms a batch: {times}; {1e9 * costs.history:.3g} ns a history"


if __name__ == "__main__":
    typer.run(main)
