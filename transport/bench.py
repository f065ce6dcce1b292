"""How fast the engine is: against the yardstick in the same run, on two cores, pass by pass, and in memory.

Ratios are what counts; absolute figures belong to the machine.  Numba is loaded when something is measured.
"""

import itertools
import math
import statistics
import subprocess
import sys
import time
from collections import defaultdict, deque
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.table import Table

from transport.compile import compile_scene
from transport.detectors import Detector, Directions
from transport.emissions import Lambertian
from transport.layout import ABSORBED
from transport.materials import Diffuse, Surface
from transport.scene import Scene
from transport.shapes import Box, Disk
from transport.simulate import simulate
from transport.sources import Source

LEAST_REPEATS = 5
BOX, BOX_ONE_BY_ONE, DISKS, DISKS_ONE_BY_ONE = 2_000_000, 600_000, 20_000_000, 3_000_000  # particles a timing
WARM_UP, MOST_STEPS, STATES = 32, 400, 8  # steps that a bundle takes, and states kept before each pass
TIMED, TIMINGS = 1e-3, 15  # [s] of one timing of a pass, and how many: short ones slip between disturbances


def box_scene(albedo: float = 0.5, cells: int = 16) -> Scene:
    """A closed cube of diffuse walls, lit by its ceiling; every wall is metered in `cells` cosine bins."""
    faces = Box(size=2.0).faces()
    return Scene(
        sources=[Source("+z", Lambertian(exitance=1.0), side="back")],
        surfaces=[Surface(face, Diffuse(albedo), name=name) for name, face in faces.items()],
        detectors=[Detector(name, side="back", directions=Directions(mu=cells)) for name in faces],
    )


def disks_scene() -> Scene:
    """A Lambertian disk that faces a small coaxial meter: one flight, and mostly a miss."""
    meter = Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.1)
    source = Source(Disk(radius=0.5), Lambertian(radiance=100.0))
    return Scene(sources=[source], detectors=[Detector(meter, name="meter", directions=Directions(mu=16))])


def bench(repeats: int = LEAST_REPEATS, quick: bool = False, long: bool = False) -> list[dict]:
    """Rows {name, value, unit, ratio} of one run, ratio None where there is nothing to compare with.

    Timings are medians of `repeats` after a first call that compiles; those of a ratio alternate, and the ratio is
    the median over the pairs.  quick: a quarter of the particles;  long: memory for 1e9 particles instead of 1e7.
    Raises ValueError for fewer than 5 repeats.
    """
    if repeats < LEAST_REPEATS:
        raise ValueError(f"bench: repeats must be at least {LEAST_REPEATS} for a median, got {repeats}")
    share = 4 if quick else 1
    return [
        *_box_rows(repeats, share),
        *_disk_rows(repeats, share),
        *_memory_rows(1_000_000_000 if long else 10_000_000),
        *_pass_rows("closed box", box_scene()),
        *_pass_rows("coaxial disks", disks_scene()),
    ]


def render(rows: list[dict]) -> Table:
    """The rows as a table, ratios first."""
    table = Table("measured", title="medians of one run, one thread unless said")
    for column in ("ratio", "value", "unit"):
        table.add_column(column, justify="left" if column == "unit" else "right")
    for row in sorted(rows, key=lambda row: row["ratio"] is None):
        ratio = "" if row["ratio"] is None else f"{row['ratio']:.2f}"
        value = f"{row['value'] / 1e6:.1f} M" if row["value"] >= 1e6 else f"{row['value']:.3g}"
        table.add_row(row["name"], ratio, value, row["unit"])
    return table


def pass_costs(scene: Scene) -> dict[str, float]:
    """Nanoseconds a lane of one call of each pass of the scene's program, by its name; passes of the newborn first.

    Each is timed on states of a bundle taken before that pass in real steps: what it changes is put back before every
    repetition, and the time of putting back is subtracted.  Calls of one pass with several tables are averaged.
    A lane is one that comes to the pass: where few do, the call itself weighs; where none did, the cost is nan.
    """
    from transport.engine.driver import machine_of
    from transport.engine.program import program_of

    plan = compile_scene(scene)
    program = machine_of(program_of(plan)).program
    sums = np.zeros((plan.rows, 4), np.int64), np.zeros((ABSORBED + len(plan.surfaces), 4), np.int64)
    costs = defaultdict(list)
    for (name, entry, table), visits in _visits(program, *sums).items():
        costs[name] += [_cost(entry, table, visits)] if visits else []
    return {name: statistics.fmean(of_calls) if of_calls else math.nan for name, of_calls in costs.items()}


def _box_rows(repeats: int, share: int) -> list[dict]:
    from transport.yardstick import run_box

    scene, histories, slow = box_scene(), BOX // share, BOX_ONE_BY_ONE // share
    first = simulate(scene, particles=histories, seed=1, threads=1, progress=False)
    one, two, by_one = _rates(
        repeats,
        lambda: simulate(scene, particles=histories, seed=1, threads=1, progress=False).cost.crossings,
        lambda: simulate(scene, particles=histories, seed=1, threads=2, progress=False).cost.crossings,
        lambda: run_box(slow, 1)[0],
    )
    return [
        _row("closed box, against one particle at a time", one, "crossings/s", one / by_one),
        _row("closed box, two threads against one", two, "crossings/s", two / one),
        _row("closed box, one particle at a time", by_one, "crossings/s"),
        _row("closed box, lost", sum(batch.lost for batch in first.batches), "particles"),
    ]


def _disk_rows(repeats: int, share: int) -> list[dict]:
    from transport.yardstick import run_disks

    scene, histories, slow = disks_scene(), DISKS // share, DISKS_ONE_BY_ONE // share
    engine, by_one = _rates(
        repeats,
        lambda: simulate(scene, particles=histories, seed=1, threads=1, progress=False).cost.particles,
        lambda: run_disks(slow, 1) and slow,
    )
    return [
        _row("coaxial disks, against one particle at a time", engine, "particles/s", engine / by_one),
        _row("coaxial disks, one particle at a time", by_one, "particles/s"),
    ]


def _memory_rows(particles: int) -> list[dict]:
    """Peak memory of a process of its own."""
    code = f"from transport import bench; print(bench.peak_memory({particles}))"
    root = Path(__file__).resolve().parents[1]
    child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root)
    return [
        _row(f"coaxial disks, peak memory for {particles:.0e} particles", float(child.stdout) / 2**20, "MiB")
    ]


def peak_memory(particles: int) -> float:
    """Peak memory [bytes] of this process after a run of the disks; nan where the system does not tell."""
    simulate(disks_scene(), particles=particles, seed=1, threads=1, progress=False)
    status = Path("/proc/self/status")
    if status.exists():  # Linux: its ru_maxrss would be the parent's peak where that is higher
        return 1024.0 * float(status.read_text().split("VmHWM:")[1].split()[0])
    try:
        import resource
    except ImportError:
        return math.nan
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return float(peak if sys.platform == "darwin" else 1024 * peak)


def _pass_rows(title: str, scene: Scene) -> list[dict]:
    return [_row(f"{title}, {name}", cost, "ns/lane") for name, cost in pass_costs(scene).items()]


def _row(name: str, values: np.ndarray | float, unit: str, ratios: np.ndarray | None = None) -> dict:
    ratio = None if ratios is None else float(np.median(ratios))
    return {"name": name, "value": float(np.median(values)), "unit": unit, "ratio": ratio}


def _rates(repeats: int, *works: Callable[[], int]) -> np.ndarray:
    """What each of the works does a second, taken in turns: (works, repeats).  A first turn compiles and is not timed."""
    rates = np.zeros((len(works), repeats + 1))
    for turn in range(repeats + 1):
        for number, work in enumerate(works):
            begun = time.perf_counter()
            done = work()
            rates[number, turn] = done / (time.perf_counter() - begun)
    return rates[:, 1:]


def _visits(program, tallies: np.ndarray, ledger: np.ndarray) -> dict[tuple, deque]:
    """For each (name, entry, table) of a program the last few (first, live, bundle before, bundle after)."""
    from transport.engine.bundle import LANES, empty_bundle
    from transport.yardstick import replay

    def key(lane_pass, table):
        return lane_pass.name, lane_pass.entry, table.ctypes.data

    bundle, nothing = empty_bundle(), np.zeros(0, np.int64)
    bundle["tallies"], bundle["tally_words"] = tallies.ctypes.data, tallies.size
    bundle["ledger"], bundle["ledger_words"] = ledger.ctypes.data, ledger.size
    words = bundle.view(np.int64)
    visits = {key(*step): deque(maxlen=STATES) for part in (*program.births, program.steps) for step in part}

    def visit(step, first, live):
        (name, entry, place), before = key(*step), words.copy()
        left = replay(entry, place, bundle["address"], np.array([[first, live]]), words[None], nothing, 1)
        if first < live:
            visits[name, entry, place].append((first, live, before, words.copy()))
        return left

    emitters, live, history = itertools.cycle(program.births), 0, 0
    for turn in range(MOST_STEPS):
        if live < LANES:
            bundle["history"][0, live:LANES] = np.arange(history, history + LANES - live)
            for step in next(emitters):
                visit(step, live, LANES)
        live, history = LANES, history + LANES - live
        for step in program.steps:
            live = visit(step, 0, live)
        if turn >= WARM_UP and all(len(seen) == STATES for seen in visits.values()):
            break
    return visits


def _cost(entry: int, table: int, visits: deque) -> float:
    """Nanoseconds a lane of a pass on these states of a bundle."""
    from transport.engine.bundle import HEADER, LANES, Bundle, empty_bundle
    from transport.engine.passes import LANE_FIELDS
    from transport.yardstick import replay

    first, live, before, after = (np.array(column) for column in zip(*visits, strict=True))
    bundles = [empty_bundle() for _ in visits]
    before[:, HEADER.index("address")] = handles = np.array([int(bundle["address"][0]) for bundle in bundles])
    for bundle, words in zip(bundles, before, strict=True):
        bundle.view(np.int64)[:] = words
    changed, fields = (before != after).any(axis=0), [Bundle.fields[name][1] // 8 for name in LANE_FIELDS]
    rows = np.array([row for row in fields if changed[row : row + LANES].any()], np.int64)
    spans = np.stack([first, live], axis=1)

    def seconds(which, repeats):
        begun = time.perf_counter()
        replay(which, table, handles, spans, before, rows, repeats)
        return time.perf_counter() - begun

    repeats = max(1, int(TIMED / min(seconds(entry, 1) for _ in range(TIMINGS))))
    turns = [(seconds(entry, repeats), seconds(0, repeats)) for _ in range(TIMINGS)]
    with_pass, without = (min(column) for column in zip(*turns, strict=True))  # the least disturbed ones
    return max(0.0, with_pass - without) / repeats / int((live - first).sum()) * 1e9
