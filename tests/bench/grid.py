"""What voxels cost: nanoseconds a collision in grids of 128^3, beside a homogeneous medium of the same mean, and the memory.

python -m tests.bench.grid [--depth 20]
"""

import argparse
import time
import tracemalloc

import numpy as np

import transport as tp

COUNT, BOX, PHASE = 128, tp.Box(size=(1.0, 1.0, 1.0)), tp.HenyeyGreenstein(0.85)
COLLISIONS = 3e6  # about, in a timing


def fields(count: int = COUNT) -> dict[str, np.ndarray]:
    """Extinctions of mean 1, from one value everywhere to a cloud with holes."""
    rng = np.random.default_rng(1)
    turbulent = _turbulent(rng, count)
    waves = np.sin(6 * np.pi * np.arange(count) / count)
    each = {
        "one value": np.ones((count, count, count)),
        "waves, +- 50 %": np.tile(1 + 0.5 * waves[:, None, None], (1, count, count)),
        "noise, +- 50 %": rng.uniform(0.5, 1.5, (count, count, count)),
        "turbulence, +- 50 %": np.exp(0.5 * turbulent),
        "turbulence, factors of 3": np.exp(turbulent),
        "cloud with holes": np.maximum(turbulent + 0.2, 0.0),
    }
    return {name: field / field.mean() for name, field in each.items()}


def _turbulent(rng: np.random.Generator, count: int) -> np.ndarray:
    """A Gaussian field of Kolmogorov's spectrum, k^(-11/3), with mean 0 and variance 1."""
    k = np.fft.fftfreq(count) * count
    size = np.sqrt(k[:, None, None] ** 2 + k[None, :, None] ** 2 + k[None, None, :] ** 2)
    size[0, 0, 0] = np.inf
    noise = np.fft.fftn(rng.standard_normal((count, count, count)))
    field = np.fft.ifftn(noise * size ** (-11 / 6)).real
    return field / field.std()


def measure(depth: float = 20.0, repeats: int = 5) -> list[dict]:
    """Rows {field, ns (a collision), ratio}: the first is the medium.  depth: mean optical depth across the box.

    Times are of the thread's CPU; the fields take turns, and the figure of each is the median.
    """
    media = {"homogeneous": tp.Medium(scattering=depth, phase=PHASE)}
    media |= {
        name: tp.Grid(box=BOX, scattering=depth * field, phase=PHASE) for name, field in fields().items()
    }
    machines = {name: _machine(medium) for name, medium in media.items()}
    particles = int(COLLISIONS / depth**1.3)
    times = np.array([[_time(machine, particles) for machine in machines.values()] for _ in range(repeats)])
    figures = np.median(times, axis=0)
    return [
        {"field": name, "ns": float(ns), "ratio": float(ns / figures[0])}
        for name, ns in zip(machines, figures, strict=True)
    ]


def _machine(medium):
    from transport.compile.compiler import compile_scene
    from transport.engine.driver import compile_program, run_batch
    from transport.engine.program import build_program

    source = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    scene = tp.Scene(source, tp.Surface(BOX, tp.Transparent(), inside=medium))
    machine = compile_program(build_program(compile_scene(scene)))
    run_batch(machine, 1, 0, 256)
    return machine


def _time(machine, particles: int) -> float:
    """CPU time of a collision [ns]."""
    from transport.engine.driver import run_batch

    start = time.thread_time()
    collisions = run_batch(machine, 1, 0, particles).collisions
    return 1e9 * (time.thread_time() - start) / collisions


def memory(count: int = COUNT) -> dict[str, float]:
    """Megabytes: of the user's own arrays that a Grid keeps, of the tables that are kept beside, and the most while they are made."""
    from transport.compile.compiler import compile_scene

    field = fields(count)["turbulence, +- 50 %"]
    source = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    tracemalloc.start()
    try:
        grid = tp.Grid(box=BOX, absorption=field, scattering=20 * field)
        kept = tracemalloc.get_traced_memory()[0]
        plan = compile_scene(tp.Scene(source, tp.Surface(BOX, tp.Transparent(), inside=grid)))
        after, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    del plan
    return {"arrays": kept / 1e6, "tables": (after - kept) / 1e6, "most": most / 1e6}


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--depth", type=float, default=20.0, help="mean optical depth across the box")
    depth = options.parse_args().depth
    print(f"{'mean depth ' + format(depth, 'g'):28} {'ns a collision':>15} {'ratio':>7}")
    for row in measure(depth):
        print(f"{row['field']:28} {row['ns']:15.1f} {row['ratio']:7.2f}")
    print(", ".join(f"{name} {size:.1f} MB" for name, size in memory().items()))


if __name__ == "__main__":
    main()
