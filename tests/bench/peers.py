"""Other programs on problems with exact values: time for a relative error of 0.1 %, in turn with transport.

    pip install mitsuba raysect pyviewfactor pyradiance
    python -m tests.bench.peers [--turns 7] [--problem NAME] [--scale 1.0]

Each program has a process of its own and two threads, and uses the method that its documentation recommends
for the problem. The programs take turns. The first run of each imports and compiles; its time is printed
apart. Times are wall-clock medians, and only ratios within one call can be compared.

Mitsuba's LLVM variant needs an LLVM library. Version 15 of Debian 12 aborts on its path tracer; 19 works
(`apt install libllvm19`). The newest one that is found is used, unless DRJIT_LIBLLVM_PATH names another.
"""

from __future__ import annotations

import math
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import typer

THREADS = 2
TARGET = 1e-3  # relative error for which times are compared
RANDOM, NET, RULE = "random", "net", "rule"  # how a method samples; only for the first is error² × time fixed
Run = Callable[[int], tuple[float, float, int]]  # seed to (value, standard error, samples)


class Method(NamedTuple):
    """One way to solve a problem with one program."""

    package: str  # name of the distribution
    label: str
    prepare: Callable[..., Run]  # called in the program's own process, with `count`
    count: int  # samples of a run
    sampling: str = RANDOM
    threads: int = THREADS


class Problem(NamedTuple):
    """A number with an exact value, and the methods that estimate it; the first one is the reference."""

    title: str
    exact: Callable[[], float]
    methods: tuple[Method, ...]


# ---- Exact values.


def point_under_square(height: float = 1.0, side: float = 1.0) -> float:
    """Return irradiance over exitance at a point below the centre of a square that is parallel to it."""
    a = 0.5 * side / math.hypot(0.5 * side, height)
    return 4.0 * a / math.pi * math.atan(0.5 * side / math.hypot(0.5 * side, height))


def floor_of_lit_cube(albedo: float = 0.5, cells: tuple[int, ...] = (8, 16, 32)) -> float:
    """Return the mean irradiance of the floor of a unit cube with a black ceiling of exitance 1.

    The radiosity equation is solved for constant exitance in n × n cells of each wall, with exact view
    factors between cells, and extrapolated (Aitken) to n = ∞. It is good to 1e-6.
    """
    a, b, c = (_floor_with_cells(n, albedo) for n in cells)
    return c - (c - b) ** 2 / ((c - b) - (b - a))


def _floor_with_cells(n: int, albedo: float) -> float:
    opposite, adjacent = _cell_factors(n)

    def of_four_walls(wall):
        one = np.tensordot(adjacent, wall, 2)
        return one + one[:, ::-1] + one.T + one.T[::-1]

    ceiling, floor, wall = np.ones((n, n)), np.zeros((n, n)), np.zeros((n, n))  # wall: [along, height]
    below = np.tensordot(opposite, ceiling, 2)
    beside = np.tensordot(adjacent, ceiling, 2)[:, ::-1]
    while True:
        on_floor = below + of_four_walls(wall)
        corner = np.tensordot(adjacent, wall.T, 2).T
        on_wall = beside + np.tensordot(adjacent, floor, 2) + np.tensordot(opposite, wall, 2)
        on_wall += corner + corner[::-1]
        change = np.abs(albedo * on_floor - floor).max() + np.abs(albedo * on_wall - wall).max()
        floor, wall = albedo * on_floor, albedo * on_wall
        if change < 1e-13:
            return float(on_floor.mean())


def _cell_factors(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return view factors between cells of opposite and of adjacent walls, [x, y, x', y'] and [x, y, x', z].

    They are differences of the closed forms for rectangles (Ehlert and Smith 1993).
    """
    offset, edge = np.arange(-n, n + 1) / n, np.arange(n + 1) / n
    u, v = offset[:, None], offset[None, :]
    a, b = np.sqrt(u * u + 1), np.sqrt(v * v + 1)
    form = v * a * np.arctan(v / a) + u * b * np.arctan(u / b) - 0.5 * np.log(u * u + v * v + 1)
    opposite = np.diff(np.diff(form, 2, axis=0), 2, axis=1) * n * n / (2 * math.pi)
    u, across = offset[:, None, None], edge[None, :, None] ** 2 + edge[None, None, :] ** 2
    r, square = np.sqrt(across), u * u + across
    angle = np.arctan(np.divide(u, r, out=np.zeros_like(square), where=r > 0))
    logarithm = np.log(square, out=np.zeros_like(square), where=square > 0)
    form = u * r * angle + 0.25 * (u * u - across) * logarithm
    adjacent = -np.diff(np.diff(np.diff(form, 2, axis=0), axis=1), axis=2) * n * n / (2 * math.pi)
    k = np.arange(n)[:, None] - np.arange(n)[None, :] + n - 1
    return opposite[k[:, None, :, None], k[None, :, None, :]], adjacent[k].transpose(0, 2, 1, 3)


# ---- transport.


def transport_run(kind: str, count: int, **options) -> Run:
    """Return a run of transport: `kind` is square, point, room, reflected or transmitted."""
    import transport as tp
    from tests.bench.speed import slab_scene

    lid = tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=1, height=1)
    lamp = tp.Source(lid, tp.Lambertian(exitance=1.0))
    if kind == "square":
        scene = tp.Scene(lamp, detectors=tp.Detector(tp.Rectangle(width=1, height=1), "meter"))
    elif kind == "point":
        scene = tp.Scene(lamp, detectors=tp.Detector(tp.Disk(radius=1e-6), "meter"))
    elif kind == "room":
        faces = tp.Box(center=(0, 0, 0.5), size=1.0).faces()
        walls = [
            tp.Surface(face, tp.Black() if name == "+z" else tp.Diffuse(0.5), name)
            for name, face in faces.items()
        ]
        lamp = tp.Source("+z", tp.Lambertian(exitance=1.0), side="back")
        scene = tp.Scene(lamp, walls, tp.Detector("-z", "meter", side="back"))
    else:
        scene = slab_scene()
    face = {"reflected": "top", "transmitted": "bottom"}.get(kind)

    def run(seed):
        result = tp.simulate(scene, count, seed=seed, threads=THREADS, progress=False, **options)
        estimate = result["meter"].irradiance if face is None else result[face].flux_out
        return estimate.value, estimate.error, result.particles

    return run


# ---- Mitsuba 3: paths from the receiver, by an integrator of its own, summed in float64 without a film.

LAUNCHES = 16


def mitsuba_run(kind: str, count: int, **integrator) -> Run:
    """Return a run of Mitsuba; rays look at the receiver, whose radiance gives the irradiance."""
    _find_llvm()
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_mono")
    dr.set_thread_count(THREADS)
    scene, origin, extent, direction, factor = _mitsuba_scene(mi, kind)
    tracer = mi.load_dict(integrator)
    lanes = count // LAUNCHES

    def launch(seed):
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, lanes)
        u = sampler.next_2d()
        start = mi.Point3f(origin[0] + extent * u.x, origin[1] + extent * u.y, origin[2])
        ray = mi.RayDifferential3f(mi.Ray3f(start, mi.Vector3f(*direction)))
        found, _, _ = tracer.sample(scene, sampler, ray)
        return factor * float(dr.mean(mi.Float64(found.x))[0])

    def run(seed):
        means = [launch(LAUNCHES * seed + k) for k in range(LAUNCHES)]
        return float(np.mean(means)), float(np.std(means, ddof=1) / math.sqrt(LAUNCHES)), lanes * LAUNCHES

    return run


def _find_llvm() -> None:
    """Name the newest LLVM library for Mitsuba, unless one is named."""
    known = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True, check=False).stdout
    found = {int(number): path for number, path in re.findall(r"libLLVM\D*(\d+).* => (\S+)", known)}
    if found:
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", found[max(found)])


def _mitsuba_scene(mi, kind: str) -> tuple[Any, tuple, float, tuple, float]:
    """Return scene; origin, extent in x and y, and direction of the rays; and irradiance per radiance."""
    place = mi.ScalarTransform4f

    def number(value):
        return {"type": "uniform", "value": value}

    def square(transform, albedo, half=0.5, **more):
        bsdf = {"type": "diffuse", "reflectance": number(albedo)}
        to_world = transform @ place().scale([half, half, 1])
        return {"type": "rectangle", "to_world": to_world, "bsdf": bsdf, **more}

    down = place().rotate([1, 0, 0], 180)
    lamp = {"type": "area", "radiance": number(1 / math.pi)}
    items: dict[str, Any] = {"type": "scene"}
    if kind in ("square", "point", "room"):
        albedo = 0.5 if kind == "room" else 1.0
        items["lid"] = square(place().translate([0, 0, 1]) @ down, 0.0, emitter=lamp)
        items["floor"] = square(place(), albedo)
        for k in range(4 if kind == "room" else 0):
            turn = place().rotate([0, 0, 1], 90.0 * k).translate([0.5, 0, 0.5]).rotate([0, 1, 0], -90)
            items[f"wall{k}"] = square(turn, albedo)
        origin, extent = ((0, 0, 0.5), 0.0) if kind == "point" else ((-0.5, -0.5, 0.5), 1.0)
        return mi.load_dict(items), origin, extent, (0, 0, -1), math.pi / albedo
    # By reciprocity, the reflectance (transmittance) of a normal beam is the radiance that leaves the slab
    # along its normal on the same (other) side, under a sky of radiance 1. A black floor shades the far side.
    fog = {"type": "homogeneous", "sigma_t": number(1.0), "albedo": number(0.9)}
    fog |= {"phase": {"type": "hg", "g": 0.75}, "has_spectral_extinction": False}
    wide = place().scale([2000, 2000, 1])
    items["slab"] = {"type": "cube", "to_world": wide, "bsdf": {"type": "null"}, "interior": fog}
    items["floor"] = square(place().translate([0, 0, -1.5]), 0.0, half=5000)
    items["sky"] = {"type": "constant", "radiance": number(1.0)}
    above = kind == "reflected"
    return mi.load_dict(items), (0, 0, 1.2 if above else -1.2), 0.0, (0, 0, -1 if above else 1), 1.0


# ---- Raysect: a pixel that observes power.


def raysect_run(kind: str, count: int) -> Run:
    """Return a run of Raysect; it tells the standard error itself."""
    from raysect.core.workflow import MulticoreEngine
    from raysect.optical import ConstantSF, Point3D, World, translate
    from raysect.optical.material import Lambert, UniformSurfaceEmitter
    from raysect.optical.observer import PowerPipeline0D
    from raysect.optical.observer.nonimaging import Pixel, TargetedPixel
    from raysect.primitive import Box

    world = World()
    glow = UniformSurfaceEmitter(ConstantSF(1 / math.pi))
    glow.importance = 1.0
    lid = Box(Point3D(-0.5, -0.5, 1), Point3D(0.5, 0.5, 1.1), parent=world, material=glow)
    options = {
        "parent": world,
        "pipelines": [PowerPipeline0D(accumulate=False)],
        "x_width": 1.0,
        "y_width": 1.0,
        "min_wavelength": 500,
        "max_wavelength": 501,
        "spectral_bins": 1,
        "pixel_samples": count,
        "quiet": True,
        "render_engine": MulticoreEngine(THREADS),
    }
    pixel: Any
    if kind == "square":
        pixel = TargetedPixel(targets=[lid], targeted_path_prob=1.0, **options)
    else:
        for low, high in (
            ((-0.6, -0.6, -0.1), (0.6, 0.6, 0.0)),
            ((-0.6, -0.6, 0.0), (-0.5, 0.6, 1.0)),
            ((0.5, -0.6, 0.0), (0.6, 0.6, 1.0)),
            ((-0.5, -0.6, 0.0), (0.5, -0.5, 1.0)),
            ((-0.5, 0.5, 0.0), (0.5, 0.6, 1.0)),
        ):
            Box(Point3D(*low), Point3D(*high), parent=world, material=Lambert(ConstantSF(0.5)))
        pixel = Pixel(ray_importance_sampling=True, ray_important_path_weight=0.5, **options)
        pixel.transform = translate(0, 0, 1e-6)

    def run(_):
        pixel.observe()
        power = pixel.pipelines[0].value
        return power.mean, power.error(), power.samples

    return run


# ---- Radiance: rtrace -I at points of the receiver.

RADIANCE_LAMP = """void light lamp\n0\n0\n3 1 1 1\n
lamp polygon lid\n0\n0\n12 -.5 -.5 1  -.5 .5 1  .5 .5 1  .5 -.5 1\n
"""
RADIANCE_WALLS = """void plastic wall\n0\n0\n5 .5 .5 .5 0 0\n
wall polygon floor\n0\n0\n12 -.5 -.5 0  .5 -.5 0  .5 .5 0  -.5 .5 0\n
wall polygon left\n0\n0\n12 -.5 -.5 0  -.5 .5 0  -.5 .5 1  -.5 -.5 1\n
wall polygon right\n0\n0\n12 .5 -.5 0  .5 -.5 1  .5 .5 1  .5 .5 0\n
wall polygon front\n0\n0\n12 -.5 -.5 0  -.5 -.5 1  .5 -.5 1  .5 -.5 0\n
wall polygon back\n0\n0\n12 -.5 .5 0  .5 .5 0  .5 .5 1  -.5 .5 1\n
"""
RADIANCE_HEIGHT = 1e-4  # of the points over the floor


def radiance_run(kind: str, count: int, options: str) -> Run:
    """Return a run of Radiance; the spread over its points gives the error."""
    import pyradiance

    home = Path(pyradiance.__file__).parent
    environment = os.environ | {"RAYPATH": str(home / "lib")}
    folder = Path(tempfile.mkdtemp(prefix="radiance-"))
    text = RADIANCE_LAMP + (RADIANCE_WALLS if kind == "room" else "")
    (folder / "scene.rad").write_text(text, encoding="ascii")
    tree = [home / "bin" / "oconv", folder / "scene.rad"]
    (folder / "scene.oct").write_bytes(subprocess.run(tree, check=True, capture_output=True).stdout)
    command = [home / "bin" / "rtrace", "-h", "-I", "-n", str(THREADS), "-fdd", "-u+"]
    command += ["-dt", "0", "-dc", "1", "-dj", "1", *options.split(), folder / "scene.oct"]

    def run(seed):
        points = np.zeros((count, 6))
        points[:, 5] = 1.0
        if kind != "point":
            points[:, :2] = np.random.default_rng(seed).random((count, 2)) - 0.5
        if kind == "room":
            points[:, 2] = RADIANCE_HEIGHT
        done = subprocess.run(
            command, input=points.tobytes(), capture_output=True, env=environment, check=True
        )
        found = np.frombuffer(done.stdout).reshape(count, 3)[:, 1] / math.pi
        return float(found.mean()), float(found.std() / math.sqrt(count)), count

    return run


# ---- pyviewfactor: quadrature between two polygons.


def pyviewfactor_run(count: int) -> Run:
    """Return a run of pyviewfactor, repeated `count` times as one takes less than a millisecond."""
    import pyvista
    from pyviewfactor import compute_viewfactor

    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    floor = pyvista.PolyData(corners, faces=[4, 0, 1, 2, 3])
    lid = pyvista.PolyData(corners[[0, 3, 2, 1]] + [0, 0, 1], faces=[4, 0, 1, 2, 3])

    def run(_):
        for _ in range(count):
            factor = compute_viewfactor(floor, lid)
        return factor, 0.0, count

    return run


# ---- The problems.

DIRECT = {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0}
PATH = {"type": "path", "max_depth": -1, "rr_depth": 5}
VOLPATH = {"type": "volpath", "max_depth": -1, "rr_depth": 5}
PROBLEMS = {
    "squares": Problem(
        "view factor of two unit squares, 1 apart",
        lambda: 0.19982489569838738,  # Howell, C-11
        (
            Method("transport", "aimed", partial(transport_run, "square", estimator="aimed"), 8_000_000),
            Method(
                "transport",
                "aimed, sobol",
                partial(transport_run, "square", estimator="aimed", sampling="sobol"),
                2**17,
                NET,
            ),
            Method("mitsuba", "direct, llvm_ad_mono", partial(mitsuba_run, "square", **DIRECT), 2**24),
            Method("raysect", "TargetedPixel", partial(raysect_run, "square"), 1_000_000),
            Method(
                "pyradiance", "rtrace -I -ds 0", partial(radiance_run, "square", options="-ds 0"), 1_000_000
            ),
            Method("pyviewfactor", "SA-30 quadrature", partial(pyviewfactor_run), 100, RULE, 1),
        ),
    ),
    "point": Problem(
        "irradiance at a point under a square lamp",
        point_under_square,
        (
            Method("transport", "aimed", partial(transport_run, "point", estimator="aimed"), 8_000_000),
            Method(
                "transport",
                "aimed, sobol",
                partial(transport_run, "point", estimator="aimed", sampling="sobol"),
                2**17,
                NET,
            ),
            Method("mitsuba", "direct, llvm_ad_mono", partial(mitsuba_run, "point", **DIRECT), 2**24),
            Method(
                "pyradiance",
                "rtrace -I -ds .1",
                partial(radiance_run, "point", options="-ds .1"),
                20_000,
                NET,
            ),
        ),
    ),
    "room": Problem(
        "closed cube, walls of albedo 0.5, black lamp as ceiling: irradiance of the floor",
        floor_of_lit_cube,
        (
            Method("transport", "expected", partial(transport_run, "room", estimator="expected"), 3_000_000),
            Method("transport", "analog", partial(transport_run, "room", estimator="analog"), 8_000_000),
            Method(
                "transport",
                "expected, sobol",
                partial(transport_run, "room", estimator="expected", sampling="sobol"),
                2**18,
                NET,
            ),
            Method("mitsuba", "path, llvm_ad_mono", partial(mitsuba_run, "room", **PATH), 2**22),
            Method("raysect", "Pixel, important lamp", partial(raysect_run, "room"), 1_000_000),
            Method(
                "pyradiance",
                "rtrace -I -ab 12 -ad 1",
                partial(radiance_run, "room", options="-ds 0 -ab 12 -aa 0 -ad 1 -as 0 -lr 12 -lw 1e-6"),
                300_000,
            ),
        ),
    ),
    "reflected": Problem(
        "slab τ = 2, albedo 0.9, g = 0.75, normal beam: reflectance",
        lambda: 0.0973946386719247,  # van de Hulst 1980
        (
            Method("transport", "weighted", partial(transport_run, "reflected"), 8_000_000),
            Method("mitsuba", "volpath, llvm_ad_mono", partial(mitsuba_run, "reflected", **VOLPATH), 2**21),
        ),
    ),
    "transmitted": Problem(
        "the same slab: transmittance",
        lambda: 0.6609577001638116,
        (
            Method("transport", "weighted", partial(transport_run, "transmitted"), 8_000_000),
            Method("mitsuba", "volpath, llvm_ad_mono", partial(mitsuba_run, "transmitted", **VOLPATH), 2**21),
        ),
    ),
}


# ---- Processes, turns and the table.

ROOT = Path(__file__).parents[2]


def serve(name: str, number: str) -> None:
    """Run one method in this process: a seed per line comes in, "seconds value error samples" goes out."""
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # whatever the programs print goes to the standard error
    started, method, run = time.perf_counter(), PROBLEMS[name].methods[int(number)], None
    for line in sys.stdin:
        run = run or method.prepare(count=int(line.split()[1]))
        value, error, samples = run(int(line.split()[0]))
        print(time.perf_counter() - started, value, error, samples, file=answers)
        started = time.perf_counter()


class Contender:
    """A method in a process of its own, with all of its answers; the first answer includes compilation."""

    def __init__(self, name: str, number: int, scale: float):
        self.method = PROBLEMS[name].methods[number]
        scale = scale if self.method.sampling == RANDOM else 1.0
        self.count = max(1, int(self.method.count * scale))
        code = "import sys; from tests.bench.peers import serve; serve(*sys.argv[1:])"
        self.messages = tempfile.TemporaryFile("w+")  # noqa: SIM115 - open as long as the process
        self.process = subprocess.Popen(
            [sys.executable, "-c", code, name, str(number)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.messages,
            text=True,
            cwd=ROOT,
        )
        self.answers: list[list[float]] = []

    def turn(self, seed: int) -> bool:
        """Run once; return False if the program died."""
        assert self.process.stdin is not None and self.process.stdout is not None
        sent = time.perf_counter()
        try:
            self.process.stdin.write(f"{seed} {self.count}\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            return False
        words = self.process.stdout.readline().split()
        if len(words) == 4:
            self.answers.append([time.perf_counter() - sent, *map(float, words[1:])])
        return len(words) == 4

    def close(self) -> str:
        """End the process; return the last line that it printed."""
        self.process.communicate()
        self.messages.seek(0)
        return (self.messages.read().strip().splitlines() or [""])[-1]


def figures(contender: Contender, exact: float) -> dict[str, float]:
    """Return medians and errors of a contender, relative to the exact value."""
    first, rest = contender.answers[0], np.array(contender.answers[1:])
    seconds = float(np.median(rest[:, 0]))
    error = float(np.sqrt(np.mean(rest[:, 2] ** 2))) / exact
    off = float(np.mean(rest[:, 1])) / exact - 1
    price = seconds * (error / TARGET) ** 2
    if contender.method.sampling == RULE:
        seconds /= contender.method.count
    if contender.method.sampling != RANDOM and max(error, abs(off)) < TARGET:
        price = seconds  # at most: a shorter run was not tried
    return {
        "first": first[0],
        "seconds": seconds,
        "rate": contender.count / np.median(rest[:, 0]),
        "error": error,
        "off": off,
        "sigmas": off / error * math.sqrt(len(rest)) if error else math.nan,
        "price": price,
    }


def compare(name: str, turns: int, scale: float) -> None:
    """Run all methods of a problem in turn and print their rows."""
    problem, contenders = PROBLEMS[name], []
    exact = problem.exact()
    print(f"\n{problem.title}; exact {exact:.7g}")
    for number, method in enumerate(problem.methods):
        try:
            version(method.package)
        except PackageNotFoundError:
            print(f"  {method.package} is not installed: pip install {method.package}")
        else:
            contenders.append(Contender(name, number, scale))
    for seed in range(turns + 1):
        for place in np.roll(np.arange(len(contenders)), seed):  # each turn in another order
            if not contenders[place].turn(seed + 1):
                contenders[place].answers.clear()
    head = (
        f"{'threads':>7} {'first s':>7} {'run s':>8} {'samples/s':>9} {'error':>8} {'off by':>9} {'in σ':>5}"
    )
    print(f"  {'program':42} {head} {'s for 0.1 %':>11} {'ratio':>8}")
    reference = math.nan  # of transport's first method, which stands first
    for contender in contenders:
        label = f"{contender.method.package} {version(contender.method.package)}, {contender.method.label}"
        died = contender.close()
        if len(contender.answers) < 2:
            print(f"  {label:42} stopped: {died[:90]}")
            continue
        row = figures(contender, exact)
        if contender is contenders[0]:
            reference = row["price"]
        bound = "" if contender.method.sampling == RANDOM else "<"
        print(
            f"  {label:42} {contender.method.threads:7d} {row['first']:7.1f} {row['seconds']:8.2g}"
            f" {row['rate']:9.2g} {row['error']:8.1e} {row['off']:9.1e} {row['sigmas']:5.1f}"
            f" {bound + format(row['price'], '.2g'):>11} {bound + format(row['price'] / reference, '.2g'):>8}",
            flush=True,
        )


def main(turns: int = 7, problem: str = "", scale: float = 1.0) -> None:
    """Print a table per problem; ratio is the time for the target error over that of transport's first row."""
    names = [problem] if problem else list(PROBLEMS)
    processor = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8"))
    print(f"{time.strftime('%Y-%m-%d')}, {processor[1] if processor else '?'}, {os.cpu_count()} cores")
    print("error: standard error of a run; off by: mean of all runs against the exact value")
    for name in names:
        compare(name, turns, scale)


if __name__ == "__main__":
    typer.run(main)
