"""Speed of the engine: against the yardstick, on two threads, of each pass, and peak memory.

    python -m tests.bench speed [--repeats 5] [--quick] [--long] [--json]

Ratios can be compared between machines, absolute numbers cannot.
"""

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import typer
from rich.table import Table

from tests.bench.frame import memory, rates
from tests.bench.yardstick import run_box, run_disks, run_fog
from transport.analysis.effects import pass_costs
from transport.cli.output import print_json, print_rich, table_of
from transport.geometry.flat import Disk, Plane, Slab
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Cylinder
from transport.geometry.shape import Point
from transport.geometry.solid import Box, Sphere
from transport.scene.bins import Directions
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Effusive, Lambertian
from transport.scene.materials import Black, Dielectric, Diffuse, Surface, Transparent
from transport.scene.media import Medium
from transport.scene.phase_functions import HenyeyGreenstein
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.scene.speeds import Maxwellian
from transport.simulate import simulate

# ---- Rows of the benchmark.


def row(name: str, values: np.ndarray | float, unit: str, ratios: np.ndarray | None = None) -> dict:
    """Return {name, value, unit, ratio} with medians; ratio is None without a reference."""
    ratio = None if ratios is None else float(np.median(ratios))
    return {"name": name, "value": float(np.median(values)), "unit": unit, "ratio": ratio}


# ---- Benchmarks of media: slabs and half spaces against one photon at a time, in the same run.

SLAB = {"depth": 2.0, "albedo": 0.9, "g": 0.75}  # case of van de Hulst
HALF_SPACE = {"albedo": 0.9, "g": 0.0, "index": 1.5}  # case of Giovanelli
MILK = {"albedo": 1000 / 1001, "g": 0.9, "index": 1.37}
PHOTONS = {"slab": 8_000_000, "half space": 2_000_000, "milk": 60_000}


def slab_scene(depth: float = 2.0, albedo: float = 0.9, g: float = 0.75, cells: int | None = None) -> Scene:
    """Return a pencil beam into a slab of mean free path 1 m, with `cells` cosine bins on both faces."""
    fog = Medium(absorption=1 - albedo, scattering=albedo, phase=HenyeyGreenstein(g))
    slab = Surface(Slab(center=(0, 0, depth / 2), thickness=depth), Transparent(), "slab", inside=fog)
    directions = None if cells is None else Directions(mu=cells)
    faces = {"top": Plane(normal=(0, 0, -1)), "bottom": Plane(center=(0, 0, depth))}
    detectors = [Detector(face, name, directions=directions) for name, face in faces.items()]
    return Scene([Source(Point(), Beam((0, 0, 1), power=1.0))], [slab], detectors)


def half_space_scene(albedo: float = 0.9, g: float = 0.0, index: float = 1.5) -> Scene:
    """Return a pencil beam on a half space below z = 0, with a Fresnel boundary that has a detector."""
    fog = Medium(absorption=1 - albedo, scattering=albedo, phase=HenyeyGreenstein(g), index=index)
    ground = Surface(Plane(), Dielectric(index), "ground", inside=fog)
    beam = Source(Point(position=(0, 0, 1)), Beam((0, 0, -1), power=1.0))
    return Scene([beam], [ground], [Detector("ground")])


def media_rows(repeats: int, share: int) -> list[dict]:
    """Return rows of photons per second, with ratios to the yardstick."""
    half, milk = float("inf"), half_space_scene(**MILK)
    cases = {
        "slab, reflected and transmitted": (slab_scene(), "slab", SLAB),
        "slab, in 30 bins of the cosine": (slab_scene(cells=30), "slab", SLAB),
        "half space of index 1.5": (half_space_scene(), "half space", HALF_SPACE | {"depth": half}),
        "half space, scattering 1000 times absorption": (milk, "milk", MILK | {"depth": half}),
    }
    found = []
    for name, (scene, kind, law) in cases.items():
        photons = PHOTONS[kind] // share
        slow = max(2000, photons // 8)
        analog, weighted, by_one = rates(
            repeats,
            _run_of(scene, photons, "particles", tracking="analog"),
            _run_of(scene, photons, "particles", tracking="weighted"),
            lambda slow=slow, law=law: run_fog(slow, 1, **law) and slow,
        )
        found += [
            row(f"{name}, against one photon at a time", analog, "photons/s", analog / by_one),
            row(f"{name}, absorption by weight", weighted, "photons/s", weighted / by_one),
            row(f"{name}, one photon at a time", by_one, "photons/s"),
        ]
    return found


def _run_of(scene: Scene, particles: int, counted: str = "crossings", **options) -> Callable[[], int]:
    """Return a function that runs the scene, on one thread by default, and returns a number of its cost."""
    options = {"seed": 1, "threads": 1, "progress": False, **options}
    return lambda: getattr(simulate(scene, particles, **options).cost, counted)


# ---- The scenes and their rows.

MIN_REPEATS = 5
SPEED, LONG_DURATION = 300.0, 10.0  # speed of particles [m/s]; duration [s] in which every history ends
GAS = Maxwellian(sigma=SPEED)
# particles per timing
BOX_PARTICLES, BOX_YARDSTICK_PARTICLES = 2_000_000, 600_000
DISK_PARTICLES, DISK_YARDSTICK_PARTICLES = 20_000_000, 3_000_000


def box_scene(
    albedo: float = 0.5,
    cells: int = 16,
    duration: float | None = None,
    speed: float | Maxwellian = SPEED,
    wall_speed: Maxwellian | None = None,
) -> Scene:
    """Return a closed diffuse cube with an emitting ceiling, and `cells` cosine bins on each wall."""
    faces = Box(size=2.0).faces()
    wall = Diffuse(albedo, speed=wall_speed)
    return Scene(
        sources=[Source("+z", Effusive(exitance=1.0, speed=speed), side="back")],
        surfaces=[Surface(face, wall, name=name) for name, face in faces.items()],
        detectors=[Detector(name, side="back", directions=Directions(mu=cells)) for name in faces],
        duration=duration,
    )


def thermal_box_scene() -> Scene:
    """Return the same cube with a duration, a Maxwellian gas and thermal walls."""
    return box_scene(duration=LONG_DURATION, speed=GAS, wall_speed=GAS)


def disks_scene() -> Scene:
    """Return a Lambertian disk that faces a small coaxial detector: one flight, and mostly a miss."""
    disk = Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.1)
    source = Source(Disk(radius=0.5), Lambertian(radiance=100.0))
    return Scene(sources=[source], detectors=[Detector(disk, name="meter", directions=Directions(mu=16))])


def tube_scene() -> Scene:
    """Return a diffuse tube, ten radii long, lit at one end, with detectors on both ends and the wall."""
    ends = [Disk(center=(0, 0, z), normal=(0, 0, z), radius=1.0) for z in (-5.0, 5.0)]
    wall = Surface(Cylinder(radius=1.0, height=10.0), Diffuse(1.0), "wall")
    source = Source(ends[0], Lambertian(exitance=1.0), side="back")
    detectors = [Detector(end, name) for end, name in zip(ends, ("entrance", "exit"), strict=True)]
    return Scene([source], [wall], [*detectors, Detector("wall", side="back", directions=Directions(mu=16))])


def glass_ball_scene() -> Scene:
    """Return a glass ball in a black emitting box: radiative equilibrium."""
    walls = Surface(Box(size=2.0), Black(), "walls")
    ball = Surface(Sphere(radius=0.8), Dielectric(1.5), "ball")
    source = Source("walls", Lambertian(radiance=1.0), side="back")
    return Scene([source], [walls, ball], [Detector("ball", directions=Directions(mu=16))])


def mesh_box_scene() -> Scene:
    """Return the closed cube of `box_scene` as a mesh of twelve triangles."""
    walls = Surface(Mesh.box(size=2.0), Diffuse(0.5), "walls")
    source = Source("walls", Effusive(exitance=1.0, speed=SPEED), side="back")
    return Scene([source], [walls], [Detector("walls", side="back", directions=Directions(mu=16))])


def bench(repeats: int = MIN_REPEATS, quick: bool = False, long: bool = False) -> list[dict]:
    """Run the benchmarks and return rows {name, value, unit, ratio}; ratio is None without a reference.

    Timings are medians of `repeats` calls after a first call that compiles.  The two timings of a ratio
    alternate, and the ratio is the median over the pairs.  `quick` runs a quarter of the particles; `long`
    measures memory with 1e9 particles instead of 1e7.  Raises ValueError for fewer than 5 repeats.
    """
    if repeats < MIN_REPEATS:
        raise ValueError(f"bench: repeats must be at least {MIN_REPEATS} for a median, got {repeats}")
    share = 4 if quick else 1
    return [
        *_box_rows(repeats, share),
        *_disk_rows(repeats, share),
        *_clock_rows(repeats, share),
        *_optics_rows(repeats, share),
        *media_rows(repeats, share),
        *_memory_rows(1_000_000_000 if long else 10_000_000),
        *_pass_rows("closed box", box_scene()),
        *_pass_rows("with clock, speeds and thermal walls", thermal_box_scene()),
        *_pass_rows("coaxial disks", disks_scene()),
        *_pass_rows("tube", tube_scene()),
        *_pass_rows("glass ball", glass_ball_scene()),
        *_pass_rows("mesh box", mesh_box_scene()),
        *_pass_rows("slab", slab_scene()),
        *_pass_rows("half space", half_space_scene()),
    ]


def render(rows: list[dict]) -> Table:
    """Return the rows as a table, rows with a ratio first."""
    cells = []
    for each in sorted(rows, key=lambda each: each["ratio"] is None):
        ratio = "" if each["ratio"] is None else f"{each['ratio']:.2f}"
        value = f"{each['value'] / 1e6:.1f} M" if each["value"] >= 1e6 else f"{each['value']:.3g}"
        cells.append([each["name"], ratio, value, each["unit"]])
    return table_of(["measured~", "ratio>", "value>", "unit"], cells)


def _box_rows(repeats: int, share: int) -> list[dict]:
    scene, histories, slow = box_scene(), BOX_PARTICLES // share, BOX_YARDSTICK_PARTICLES // share
    first = simulate(scene, particles=histories, seed=1, threads=1, progress=False)
    busy = []  # CPU time / wall time of each run on two threads

    def run_two() -> int:
        cpu, wall = time.process_time(), time.perf_counter()
        crossings = _run_of(scene, histories, threads=2)()
        busy.append((time.process_time() - cpu) / (time.perf_counter() - wall))
        return crossings

    one, two, by_one = rates(repeats, _run_of(scene, histories), run_two, lambda: run_box(slow, 1)[0])
    cores = np.array(busy[1:])
    return [
        row("closed box, against one particle at a time", one, "crossings/s", one / by_one),
        row("closed box, two threads against one", two, "crossings/s", two / one),
        row("closed box, two threads: CPU time over wall time", cores, "cores", cores),
        row("closed box, one particle at a time", by_one, "crossings/s"),
        row("closed box, lost", sum(batch.lost for batch in first.batches), "particles"),
    ]


def _disk_rows(repeats: int, share: int) -> list[dict]:
    scene, histories, slow = disks_scene(), DISK_PARTICLES // share, DISK_YARDSTICK_PARTICLES // share
    run = _run_of(scene, histories, "particles")
    engine, by_one = rates(repeats, run, lambda: run_disks(slow, 1) and slow)
    return [
        row("coaxial disks, against one particle at a time", engine, "particles/s", engine / by_one),
        row("coaxial disks, one particle at a time", by_one, "particles/s"),
    ]


def _clock_rows(repeats: int, share: int) -> list[dict]:
    """Return the time per crossing with a clock, speeds and thermal walls, as ratios to the scene before."""
    scenes = {
        "with a clock, against without": box_scene(duration=LONG_DURATION),
        "with a clock and speeds, against a clock": box_scene(duration=LONG_DURATION, speed=GAS),
        "with thermal walls as well, against speeds": thermal_box_scene(),
    }
    found = _crossing_rates(repeats, share, box_scene(), *scenes.values())
    pairs = zip(scenes, found, found[1:], strict=False)
    return [
        row(f"time of a closed box {what}", 1e9 / rate, "ns/crossing", before / rate)
        for what, before, rate in pairs
    ]


def _optics_rows(repeats: int, share: int) -> list[dict]:
    """Return crossing rates of curved, refracting and meshed surfaces, as ratios to the closed box."""
    scenes = {"tube": tube_scene(), "glass ball": glass_ball_scene(), "mesh box": mesh_box_scene()}
    found = _crossing_rates(repeats, share, box_scene(), *scenes.values())
    return [
        row(f"{name}, against the closed box", rate, "crossings/s", rate / found[0])
        for name, rate in zip(scenes, found[1:], strict=True)
    ]


def _crossing_rates(repeats: int, share: int, *scenes: Scene) -> np.ndarray:
    return rates(repeats, *(_run_of(scene, BOX_PARTICLES // share) for scene in scenes))


def _memory_rows(particles: int) -> list[dict]:
    """Return the peak memory [MiB] of a run in a new process."""
    code = f"from tests.bench.speed import peak_memory; print(peak_memory({particles}))"
    root = Path(__file__).resolve().parents[2]
    child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root)
    return [
        row(f"coaxial disks, peak memory for {particles:.0e} particles", float(child.stdout) / 2**20, "MiB")
    ]


def peak_memory(particles: int) -> float:
    """Run the disks and return the peak memory [bytes] of this process; nan if unknown."""
    simulate(disks_scene(), particles=particles, seed=1, threads=1, progress=False)
    return memory("VmHWM")


def _pass_rows(title: str, scene: Scene) -> list[dict]:
    return [row(f"{title}, {name}", cost.ns_per_lane, "ns/lane") for name, cost in pass_costs(scene).items()]


def main(repeats: int = MIN_REPEATS, quick: bool = False, long: bool = False, json: bool = False) -> None:
    """Print the rows of `bench`."""
    rows = bench(repeats, quick, long)
    print_json(rows) if json else print_rich(render(rows), "medians of one run, on one thread unless stated")


if __name__ == "__main__":
    typer.run(main)
