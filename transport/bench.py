"""How fast the engine is: against the yardstick in the same run, on two cores, pass by pass, and in memory.

Ratios are what counts; absolute figures belong to the machine.  Numba is loaded when something is measured.
"""

import statistics
import subprocess
import sys
import time
from collections import defaultdict, deque
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from rich.table import Table

from transport.compile import compile_scene
from transport.detectors import Detector, Directions
from transport.emissions import Lambertian
from transport.materials import Diffuse, Surface
from transport.scene import Scene
from transport.shapes import Box, Disk
from transport.simulate import simulate
from transport.sources import Source

LEAST_REPEATS = 5
BOX, BOX_ONE_BY_ONE, DISKS, DISKS_ONE_BY_ONE = 2_000_000, 600_000, 20_000_000, 3_000_000  # particles a timing
WARM_UP, STATES = 24, 8  # steps of a bundle before its states are kept, and how many of them are
TIMED = 4e-3  # [s] of one timing of a pass


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
    """
    from transport.engine.driver import machine_of
    from transport.engine.program import program_of

    program = machine_of(program_of(compile_scene(scene))).program
    costs = defaultdict(list)
    with _Walk(program) as walk:
        for step, visits in walk.visits().items():
            costs[step.name].append(walk.cost(step, visits))
    return {name: statistics.fmean(of_calls) for name, of_calls in costs.items()}
