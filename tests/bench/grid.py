"""Nanoseconds per collision in a homogeneous medium and in grids of 128^3 voxels of the same mean, and the memory of a grid.

python -m tests.bench.grid [--depth 20 ...]
"""

import time
import tracemalloc

import numpy as np
import typer

import transport as tp
from tests.bench.frame import rates
from transport.compile.compiler import compile_scene
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program

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
    """Return rows {field, ns (per collision), ratio}, the homogeneous medium first.

    `depth` is the mean optical depth across the box.  Times are medians of the thread's CPU time.
    """
    media = {"homogeneous": tp.Medium(scattering=depth, phase=PHASE)}
    media |= {
        name: tp.Grid(box=BOX, scattering=depth * field, phase=PHASE) for name, field in fields().items()
    }
    particles = int(COLLISIONS / depth**1.3)
    works = [_work(medium, particles) for medium in media.values()]
    found = 1e9 / np.median(rates(repeats, *works, clock=time.thread_time), axis=1)
    return [
        {"field": name, "ns": float(ns), "ratio": float(ns / found[0])}
        for name, ns in zip(media, found, strict=True)
    ]


def _work(medium, particles: int):
    """Return a function that runs a batch and returns its number of collisions."""
    program = compile_program(build_program(compile_scene(_scene(medium))))
    return lambda: run_batch(program, 1, 0, particles).collisions


def _scene(medium) -> tp.Scene:
    source = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    return tp.Scene(source, tp.Surface(BOX, tp.Transparent(), inside=medium))


def memory(count: int = COUNT) -> dict[str, float]:
    """Return the megabytes of the user's arrays that a Grid keeps, of its tables and arena, and the peak while these are made."""
    field = fields(count)["turbulence, +- 50 %"]
    tracemalloc.start()
    try:
        grid = tp.Grid(box=BOX, absorption=field, scattering=20 * field)
        kept = tracemalloc.get_traced_memory()[0]
        size = compile_scene(_scene(grid)).arena.memory.nbytes
        after, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    return {"arrays": kept / 1e6, "tables": (after - kept) / 1e6, "arena": size / 1e6, "most": most / 1e6}


def main(
    depth: list[float] = typer.Option([1.0, 20.0], help="Mean optical depth across the box"),  # noqa: B008
) -> None:
    """Print a table per depth, and the memory."""
    for each in depth:
        print(f"{f'mean depth {each:g}':28} {'ns per collision':>16} {'ratio':>7}")
        for row in measure(each):
            print(f"{row['field']:28} {row['ns']:16.1f} {row['ratio']:7.2f}")
    print(", ".join(f"{name} {size:.1f} MB" for name, size in memory().items()))


if __name__ == "__main__":
    typer.run(main)
