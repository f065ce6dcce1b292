"""What a mesh costs: nanoseconds a ray against the number of triangles, beside the analytic sphere, and the building.

python -m tests.bench.mesh [--million]     a table; with 1e6 triangles as well
python -m tests.bench limits                what is promised of it
"""

import argparse
import time

import numpy as np

import transport as tp

TRIANGLES = (100, 1_000, 10_000, 100_000)
RAYS = 200_000  # about, in a timing


def measure(triangles=TRIANGLES, repeats: int = 5) -> list[dict]:
    """Rows {triangles, ns (a ray), made [s], built [s]}; the first row is the analytic sphere, of 0 triangles.

    Rays are those within a closed diffuse sphere, albedo 0.9.  Times are of this process's CPU; the sizes take turns, and
    the figure of each is the median.  built: the first run of a mesh, with a handful of particles, once all is compiled.
    """
    _time(_scene(tp.Mesh.sphere(radius=1.0, triangles=20)), 64)
    rows = [_built(number) for number in (0, *triangles)]
    times = np.array([[_time(row["scene"], RAYS // 10) for row in rows] for _ in range(repeats)])
    for row, ns in zip(rows, np.median(times, axis=0), strict=True):
        row["ns"] = float(ns)
        del row["scene"]
    return rows


def _built(triangles: int) -> dict:
    start = time.process_time()
    shape = tp.Mesh.sphere(radius=1.0, triangles=triangles) if triangles else tp.Sphere(radius=1.0)
    row = {"triangles": shape.triangles if triangles else 0, "made": time.process_time() - start}
    row["scene"] = _scene(shape)
    start = time.process_time()
    _run(row["scene"], 64)
    return row | {"built": time.process_time() - start}


def _scene(shape) -> tp.Scene:
    wall = tp.Surface(shape, tp.Diffuse(0.9), name="wall")
    return tp.Scene(tp.Source("wall", tp.Lambertian(power=1.0), side="back"), wall)


def _time(scene: tp.Scene, particles: int) -> float:
    """CPU time of a ray [ns]."""
    start = time.process_time()
    crossings = _run(scene, particles).cost.crossings
    return 1e9 * (time.process_time() - start) / crossings


def _run(scene: tp.Scene, particles: int):
    return tp.simulate(scene, particles=particles, seed=1, threads=1, progress=False)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--million", action="store_true", help="1e6 triangles as well")
    sizes = (*TRIANGLES, 1_000_000) if options.parse_args().million else TRIANGLES
    print(f"{'triangles':>10} {'ns a ray':>10} {'made, s':>10} {'built, s':>10}")
    for row in measure(sizes):
        print(f"{row['triangles']:10d} {row['ns']:10.0f} {row['made']:10.3f} {row['built']:10.3f}")


if __name__ == "__main__":
    main()
