"""Nanoseconds per ray against a mesh's number of triangles, beside the analytic sphere, and seconds of building it.

python -m tests.bench.mesh [--million]     a table; with 1e6 triangles as well
"""

import time
from functools import partial

import numpy as np
import typer

import transport as tp
from tests.bench.frame import rates

TRIANGLES = (100, 1_000, 10_000, 100_000)
RAYS = 200_000  # about, in a timing


def measure(triangles=TRIANGLES, repeats: int = 5) -> list[dict]:
    """Return rows {triangles, ns (per ray), made [s], built [s]}; the first one is the analytic sphere, of 0 triangles.

    Rays are those within a closed diffuse sphere, albedo 0.9.  Times are medians of this process's CPU time.
    `built` is the first run of a mesh, with a handful of particles, once all passes are compiled.
    """
    _crossings(_scene(tp.Mesh.sphere(radius=1.0, triangles=20)), 64)
    rows = [_built(number) for number in (0, *triangles)]
    works = [partial(_crossings, row.pop("scene"), RAYS // 10) for row in rows]
    found = 1e9 / np.median(rates(repeats, *works, clock=time.process_time), axis=1)
    return [row | {"ns": float(ns)} for row, ns in zip(rows, found, strict=True)]


def _built(triangles: int) -> dict:
    start = time.process_time()
    shape = tp.Mesh.sphere(radius=1.0, triangles=triangles) if triangles else tp.Sphere(radius=1.0)
    row = {"triangles": shape.triangles if triangles else 0, "made": time.process_time() - start}
    row["scene"] = _scene(shape)
    start = time.process_time()
    _crossings(row["scene"], 64)
    return row | {"built": time.process_time() - start}


def _scene(shape) -> tp.Scene:
    wall = tp.Surface(shape, tp.Diffuse(0.9), name="wall")
    return tp.Scene(tp.Source("wall", tp.Lambertian(power=1.0), side="back"), wall)


def _crossings(scene: tp.Scene, particles: int) -> int:
    return tp.simulate(scene, particles, seed=1, threads=1, progress=False).cost.crossings


def main(million: bool = False) -> None:
    """Print the table, with 1e6 triangles as well where `million` is set."""
    print(f"{'triangles':>10} {'ns per ray':>10} {'made, s':>10} {'built, s':>10}")
    for row in measure((*TRIANGLES, 1_000_000) if million else TRIANGLES):
        print(f"{row['triangles']:10d} {row['ns']:10.0f} {row['made']:10.3f} {row['built']:10.3f}")


if __name__ == "__main__":
    typer.run(main)
