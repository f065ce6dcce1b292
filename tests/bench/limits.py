"""Speeds that the engine is held to; status 1 where one is missed, as on a busy machine.

python -m tests.bench limits
"""

from __future__ import annotations

import typer

from tests.bench.mesh import measure
from tests.bench.speed import bench

REPEATS = 7  # timings per median


def checks() -> dict[str, tuple[float, float]]:
    """Each check with the value that must be at least 0, and the measured number."""
    rows = {row["name"]: row for row in bench(repeats=REPEATS)}
    ratio = {name: row["ratio"] for name, row in rows.items()}
    box = ratio["closed box, against one particle at a time"]
    disks = rows["coaxial disks, against one particle at a time"]["value"]
    two = ratio["closed box, two threads against one"]
    lost = rows["closed box, lost"]["value"]
    meshes = measure(repeats=REPEATS)
    growth = meshes[-1]["ns"] / meshes[1]["ns"]
    built = meshes[-1]["made"] + meshes[-1]["built"]
    assert meshes[-1]["triangles"] >= 100_000
    return {
        "closed box, 3.5 times as fast as one particle at a time": (box - 3.5, box),
        "coaxial disks, 120 million particles per second": (disks - 120e6, disks),
        "closed box, two threads 1.7 times as fast as one": (two - 1.7, two),
        "closed box, no particle lost": (-lost, lost),
        "mesh, time per ray less than 5-fold from 100 to 100 000 triangles": (5 - growth, growth),
        "mesh, 100 000 triangles made and built within a second": (1 - built, built),
    }


def main() -> None:
    """Print each check and whether it holds; status 1 where one does not."""
    found = checks()
    for name, (margin, value) in found.items():
        print(f"{'held' if margin >= 0 else 'MISSED':6}  {name}: {value:.3g}")
    raise typer.Exit(int(any(margin < 0 for margin, _ in found.values())))


if __name__ == "__main__":
    typer.run(main)
