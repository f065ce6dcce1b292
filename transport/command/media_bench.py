"""Benchmarks of media: slabs and half spaces against one photon at a time, in the same run."""

from collections.abc import Callable

from transport.command.bench_rows import rates, row
from transport.detectors import Detector, Directions
from transport.emissions import Beam
from transport.materials import Dielectric, Surface, Transparent
from transport.media import HenyeyGreenstein, Medium
from transport.scene import Scene
from transport.shapes import Plane, Point, Slab
from transport.simulate import simulate
from transport.sources import Source

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
    meters = [Detector(face, name, directions=directions) for name, face in faces.items()]
    return Scene([Source(Point(), Beam((0, 0, 1), power=1.0))], [slab], meters)


def half_space_scene(albedo: float = 0.9, g: float = 0.0, index: float = 1.5) -> Scene:
    """Return a pencil beam on a half space below z = 0, with a Fresnel boundary that has a detector."""
    fog = Medium(absorption=1 - albedo, scattering=albedo, phase=HenyeyGreenstein(g), index=index)
    ground = Surface(Plane(), Dielectric(index), "ground", inside=fog)
    beam = Source(Point(position=(0, 0, 1)), Beam((0, 0, -1), power=1.0))
    return Scene([beam], [ground], [Detector("ground")])


def media_rows(repeats: int, share: int) -> list[dict]:
    """Return rows of photons per second, with ratios to the yardstick."""
    from transport.command.yardstick_of_media import run_fog

    half = float("inf")
    cases = {
        "slab, reflected and transmitted": (slab_scene(), "slab", SLAB),
        "slab, in 30 bins of the cosine": (slab_scene(cells=30), "slab", SLAB),
        "half space of index 1.5": (half_space_scene(), "half space", HALF_SPACE | {"depth": half}),
        "half space, scattering 1000 times absorption": (
            half_space_scene(**MILK),
            "milk",
            MILK | {"depth": half},
        ),
    }
    found = []
    for name, (scene, kind, law) in cases.items():
        photons = PHOTONS[kind] // share
        slow = max(2000, photons // 8)
        analog, weighted, by_one = rates(
            repeats,
            _photons(scene, photons, "analog"),
            _photons(scene, photons, "weighted"),
            lambda slow=slow, law=law: run_fog(slow, 1, **law) and slow,
        )
        found += [
            row(f"{name}, against one photon at a time", analog, "photons/s", analog / by_one),
            row(f"{name}, absorption by weight", weighted, "photons/s", weighted / by_one),
            row(f"{name}, one photon at a time", by_one, "photons/s"),
        ]
    return found


def _photons(scene: Scene, photons: int, tracking: str) -> Callable[[], int]:
    options = {"seed": 1, "threads": 1, "progress": False, "tracking": tracking}
    return lambda: simulate(scene, particles=photons, **options).cost.particles
