"""Small scenes that between them call for every pass of media, volume detectors and point detectors."""

from __future__ import annotations

import numpy as np

from transport.geometry.flat import Disk, Plane, Slab
from transport.geometry.revolved import Cylinder
from transport.geometry.shape import Point
from transport.geometry.solid import Box, Sphere
from transport.scene.bins import Directions
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Gas, Isotropic, Lambertian
from transport.scene.materials import Black, Dielectric, Diffuse, Mirror, Mixture, Surface, Transparent
from transport.scene.media import Grid, Medium, Vacuum
from transport.scene.phase_functions import HenyeyGreenstein, Rayleigh, Tabulated
from transport.scene.points import PointDetector
from transport.scene.pulses import Instant
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.scene.speeds import Maxwellian
from transport.scene.tracking import Splitting, Tracking
from transport.scene.volumes import VolumeDetector

GLOW, LIGHT, CLEAR = Isotropic(power=1.0), Lambertian(power=1.0), Transparent()
TABLE = Tabulated(mu=(-1.0, -0.5, 0.2, 0.9, 1.0), density=(0.3, 0.1, 0.2, 1.0, 4.0))
BLEND = Mixture({HenyeyGreenstein(-0.4): 0.3, TABLE: 0.3, Rayleigh(): 0.4})
SPEED = 299792458.0  # m/s
ALL_ROUND = {"mu": 3, "phi": 2}


def body(shape, name=None, material=CLEAR, **medium):
    return Surface(shape, material, name, inside=Medium(**medium))


def voxels(box, seed, scattering=True, least=0.0, **how):
    """A cloud of voxels of which a third is as thin as it gets."""
    random = np.random.default_rng(seed)
    sigma = np.maximum(random.random((3, 4, 2)) * 3 - 1, least)
    return Grid(
        box=box,
        absorption=0.5 * sigma if not scattering else 0.1 * sigma,
        scattering=sigma * scattering,
        **how,
    )


def layers():
    """A stack of slabs, all phase functions, a source within and one above; planes that ask for events."""
    slabs = [
        body(Slab(center=(0, 0, -0.5), thickness=1.0), absorption=0.3, scattering=1.5, phase=BLEND),
        body(Slab(center=(0, 0, -1.25), thickness=0.5), absorption=0.1, scattering=2.0),
        body(Slab(center=(0, 0, -1.75), thickness=0.5), scattering=4.0, phase=HenyeyGreenstein(0.8)),
    ]
    meters = [
        Detector(Plane(), "top", directions=Directions(mu=4), events=(1, 9)),
        Detector(Plane(center=(0, 0, -2)), "bottom", side="back", directions=Directions(mu=3, phi=2)),
    ]
    lamp = Source(Disk(center=(0, 0, 0.5), normal=(0, 0, -1), radius=0.1), LIGHT)
    return Scene([lamp, Source(Point(position=(0, 0, -0.7)), GLOW)], slabs, meters)


def pile():
    """More bodies than are told one by one, nested and side by side, in fog and glass, against a clock."""
    boxes = [
        body(Box(size=4.0), "hall", absorption=0.1, scattering=0.5),
        body(Box(center=(0.5, 0, 0), size=1.0), absorption=0.4, scattering=1.0, phase=Rayleigh()),
        body(Box(center=(-0.5, 0, 0), size=1.0), absorption=0.2, scattering=1.0, phase=TABLE),
        body(Box(center=(0.5, 0, 0), size=0.5), absorption=1.0),
        body(
            Sphere(center=(0, 0, 1.2), radius=0.4),
            "ball",
            Dielectric(1.5, 1.0),
            absorption=0.3,
            scattering=2.0,
            index=1.5,
        ),
        body(Sphere(center=(0, 0, -1.2), radius=0.4), absorption=0.2, scattering=1.0),
    ]
    looks = [
        VolumeDetector(Box(size=3.0), "voxels", (2, 2, 1), Directions.sphere(**ALL_ROUND)),
        VolumeDetector("ball", "shells", (2,)),
        VolumeDetector(Sphere(radius=1.5), "all"),
        Detector("hall"),
    ]
    lamps = [
        Source(Point(), Isotropic(energy=1.0), pulse=Instant(0.0)),
        Source(Point(position=(0.5, 0, 0)), GLOW),
    ]
    return Scene(lamps, boxes, looks, medium=Medium(absorption=0.05, scattering=0.1), duration=4.0 / SPEED)


def cloud():
    """Voxels that scatter, beside a body that does not; tracks and collisions are counted."""
    grid = voxels(Box(center=(0, 0, 0.5), size=(2, 2, 1)), 1, least=0.1, phase=HenyeyGreenstein(0.5))
    surfaces = [
        Surface(grid.box, CLEAR, "cloud", inside=grid),
        body(Box(center=(0, 0, -0.5), size=(2, 2, 1)), absorption=0.5),
        Surface(Plane(center=(0, 0, -1.5)), Diffuse(0.6), "ground"),
    ]
    all_ways = Directions.sphere(**ALL_ROUND)
    looks = [
        VolumeDetector("cloud", "tracks", (3, 2, 2), all_ways),
        VolumeDetector("cloud", "collisions", (3, 2, 2), all_ways, estimator="collision"),
        VolumeDetector(Sphere(center=(0, 0, 0.5), radius=0.4), "ball", (2,), estimator="collision"),
        Detector("ground", directions=Directions(mu=3)),
    ]
    sun = Source(Disk(center=(0, 0, 3), normal=(0, 0, -1), radius=0.8), Beam((0.1, 0.2, -1), power=1.0))
    return Scene(sun, surfaces, looks)


def smoke():
    """Nothing scatters: flights go straight, weights fall, in voxels as well."""
    grid = voxels(Box(center=(0, 0, 0.5), size=(2, 2, 1)), 2, scattering=False)
    surfaces = [
        Surface(grid.box, CLEAR, inside=grid),
        body(Sphere(center=(0, 0, -1), radius=0.5), absorption=2.0),
        Surface(Box(size=6.0), Mixture({Diffuse(0.8): 0.5, Mirror(0.5): 0.5}), "walls"),
    ]
    looks = [VolumeDetector(Sphere(radius=1.0), "ball"), Detector("walls", side="inside")]
    return Scene(Source("walls", LIGHT, side="inside"), surfaces, looks)


def thin():
    """First collisions are forced, in thin air between walls and in a ball of fog."""
    air = {"absorption": 1e-3, "scattering": 2e-3, "phase": Rayleigh()}
    fog = body(Sphere(radius=0.4), "fog", absorption=0.1, scattering=0.5, phase=HenyeyGreenstein(0.7))
    walls = Surface(Box(size=2.0), Diffuse(0.3), "walls", inside=Medium(**air))
    return Scene(
        Source(Point(position=(0.5, 0.5, 0)), GLOW),
        [walls, fog],
        [Detector("walls", side="inside"), Detector("fog")],
    )


def deep():
    """A thick slab with voxels in it, split with depth."""
    grid = voxels(Box(center=(0, 0, -1), size=1.0), 3)
    slab = body(Slab(center=(0, 0, -1.5), thickness=3.0), absorption=1.0, scattering=1.0, phase=BLEND)
    meters = [Detector(Plane(), "top"), Detector(Plane(center=(0, 0, -3)), "bottom", side="back")]
    beam = Source(Point(position=(0.1, 0.2, 1)), Beam((0, 0, -1), power=1.0))
    return Scene(beam, [slab, Surface(grid.box, CLEAR, inside=grid)], meters)


def hall():
    """Fog in a room of grey walls, split from its middle on: walls thin out by importance."""
    walls = Surface(Box(size=3.0), Diffuse(0.6), "walls")
    fog = body(Sphere(radius=1.0), absorption=0.2, scattering=1.0)
    return Scene(Source(Point(), GLOW), [walls, fog], [Detector("walls", side="inside")])


def seen():
    """Points that look at a lamp, walls, glowing volumes, fog and a cloud, from without and within fog."""
    grid = voxels(Box(center=(0, 0, 1), size=0.8), 4, phase=TABLE)
    surfaces = [
        Surface(Box(size=4.0), Diffuse(0.5, 0.1), "walls"),
        Surface(grid.box, CLEAR, inside=grid),
        body(Box(center=(0, 0, -1), size=0.8), absorption=0.2, scattering=1.0, phase=BLEND),
        body(Sphere(center=(1, 0, 0), radius=0.4), absorption=0.2, scattering=1.0),
        body(Sphere(center=(-1, 0, 0), radius=0.4), scattering=1.0, phase=HenyeyGreenstein(0.6)),
        Surface(Disk(center=(0, 1, 0), normal=(0, 1, 0), radius=0.3), Black()),
    ]
    sources = [
        Source(Disk(center=(0.3, -1, 0.2), radius=0.2), LIGHT),
        Source(Box(center=(0.2, -0.3, 0.1), size=0.5), GLOW),
        Source(Sphere(center=(0.1, 0.1, 0.9), radius=0.3), GLOW),
        Source(Point(position=(1.05, 0, 1)), Beam((0, 0, -1), power=1.0)),
        Source(Point(position=(0.1, 0.2, 1.0)), GLOW),
    ]
    points = [PointDetector((0.2, -0.3, 0.1), "free"), PointDetector((0.05, 0.1, 0.9), "in the cloud")]
    points.append(PointDetector((1.1, 0.05, 0.1), "in fog"))
    return Scene(sources, surfaces, points)


def flash_in_the_dark():
    """Volumes without media, where all fly alike against a clock."""
    looks = [VolumeDetector(Box(size=1.0), "box", (2, 1, 2)), VolumeDetector(Sphere(radius=0.7), "ball")]
    walls = Surface(Sphere(radius=2.0), Black(), "walls")
    return Scene(Source(Point(), Isotropic(power=1.0, speed=1.0)), walls, looks, duration=2.5)


def draught():
    """The same where speeds differ."""
    gas = Source(Box(size=1.0), Gas(50.0, Maxwellian(sigma=1.0, mass=2.0)))
    looks = [VolumeDetector(Box(size=2.0), "box"), VolumeDetector(Sphere(radius=0.7), "ball")]
    return Scene(gas, [], [*looks, Detector(Plane(), "floor")], duration=0.5)


def still():
    """Volumes in a steady scene without media."""
    walls = Surface(Box(size=3.0), Diffuse(0.5), "walls")
    return Scene(Source("walls", LIGHT, side="inside"), walls, [VolumeDetector(Box(size=1.0), "box")])


def rod():
    """A beam in fog above the ground, counted in the rings of cylinders by tracks and by collisions."""
    shape, all_ways = Cylinder(radius=0.8, height=1.5, axis=(1, 2, 2)), Directions.sphere(**ALL_ROUND)
    looks = [
        VolumeDetector(shape, "tracks", (3, 4), all_ways),
        VolumeDetector(shape, "collisions", (3, 4), all_ways, estimator="collision"),
        VolumeDetector(shape, "all"),
    ]
    sun = Source(Disk(center=(0, 0, 3), normal=(0, 0, -1), radius=0.8), Beam((0.1, 0.2, -1), power=1.0))
    ground = Surface(Plane(center=(0, 0, -1.5)), Diffuse(0.6), "ground")
    return Scene(sun, ground, looks, Medium(absorption=0.2, scattering=0.8))


def shells():
    """Nested media, in each of which two detectors keep path lengths, by direction, with moments beside them."""
    media = Medium(absorption=0.2, scattering=1.0), Medium(absorption=0.1, scattering=3.0)
    spheres = [
        Surface(Sphere(radius=radius), CLEAR, f"shell {k}", inside=medium)
        for k, (radius, medium) in enumerate(zip((1.0, 0.4), media, strict=True))
    ]
    walls = Surface(Box(size=3.0), Diffuse(0.5), "walls")
    looks = [
        Detector("walls", side="inside", path_lengths=[media[1], Vacuum(), media[0]]),
        Detector("shell 0", side="inside", path_lengths=media, directions=Directions(mu=3), moments=True),
    ]
    return Scene(Source("walls", LIGHT, side="inside"), [*spheres, walls], looks)


STATION = Splitting(start=(0, 0, 0), end=(0, 0, -3), gain=100.0)
TRACKINGS = {
    "cloud": Tracking(absorption="analog"),
    "hall": Tracking(splitting=Splitting(start=(0, 0, 0), end=(0, 0, 1.5), gain=10.0)),
    "thin": Tracking(forced=True),
    "deep": Tracking(splitting=STATION),
    "shells": Tracking(forced=True),
}  # what is not the default
MEDIA = {
    scene.__name__: scene
    for scene in (
        layers,
        pile,
        cloud,
        smoke,
        thin,
        deep,
        hall,
        seen,
        flash_in_the_dark,
        draught,
        still,
        rod,
        shells,
    )
}
