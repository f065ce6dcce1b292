"""Units and place do not matter: the same bits in powers of two, the same digits in any other unit of length or power, anywhere.

A closed room, disks, the sun, a foggy slab, voxels, ducts between boxes of fog, splitting and forcing, with meters, volume and point detectors:
lengths from 1e-9 to 1e9 of a metre (coefficients inversely), powers from 1e-12 to 1e12 W.  The seed is 1; comparisons of moved
scenes fail right code in one of a thousand choices of seeds, all together.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees

FALSE_ALARM = 1e-3  # of all detectors of all moved scenes
CLEAR = tp.Transparent()
HISTORIES = 500
FOG = {"absorption": 0.3, "scattering": 1.5}
VOXELS = np.random.default_rng(1).uniform(0.1, 3.0, (3, 4, 2))


class Scale:
    """Shapes, media and sources in some units, and about some place [m]."""

    def __init__(self, length: float = 1.0, power: float = 1.0, shift=(0.0, 0.0, 0.0)) -> None:
        self.length, self.power, self.shift = length, power, shift

    def place(self, *coordinates):
        return tuple(self.length * x + s for x, s in zip(coordinates, self.shift, strict=True))

    def size(self, *lengths):
        return tuple(self.length * x for x in lengths)

    def disk(self, center, radius, normal=(0, 0, 1)):
        return tp.Disk(center=self.place(*center), radius=self.length * radius, normal=normal)

    def lambertian(self):
        return tp.Lambertian(power=self.power)

    def box(self, center, size):
        return tp.Box(center=self.place(*center), size=self.size(*size))

    def plane(self, z):
        return tp.Plane(center=self.place(0, 0, z))

    def medium(self, absorption, scattering, **how):
        return tp.Medium(absorption / self.length, scattering / self.length, **how)

    def beam(self, position=(0, 0, 1), direction=(0.3, 0.2, -1)):
        return tp.Source(tp.Point(position=self.place(*position)), tp.Beam(direction, power=self.power))

    def lamp(self, position):
        return tp.Source(tp.Point(position=self.place(*position)), tp.Isotropic(power=self.power))


def room(units):
    """Closed and diffuse, one wall of which shines, with a mirror ball in it."""
    faces = units.box((0, 0, 0), (2, 2, 2)).faces().items()
    walls = [tp.Surface(face, tp.Diffuse(0.5), name) for name, face in faces]
    ball = tp.Sphere(center=units.place(0.3, 0, 0), radius=0.3 * units.length)
    lamp = tp.Source("+z", units.lambertian(), side="back")
    looks = [tp.Detector(name, side="back") for name, _ in faces]
    return tp.Scene(lamp, [*walls, tp.Surface(ball, tp.Mirror(0.9), "ball")], looks)


def disks(units):
    """A lamp aimed at a meter beside its axis."""
    meter = units.disk((1.5, 0, 2), 0.1)
    lamp = tp.Source(units.disk((0, 0, 0), 0.5), units.lambertian(), aim=meter)
    return tp.Scene(lamp, detectors=tp.Detector(meter, "meter", side="back"))


def sun(units):
    """A square metre of the Earth, aimed at from 150 million kilometres away."""
    meter = units.disk((1.496e11, 0, 0), 0.5, (-0.8, 0, 0.6))
    globe = tp.Sphere(center=units.place(0, 0, 0), radius=6.957e8 * units.length)
    return tp.Scene(tp.Source(globe, units.lambertian(), aim=meter), detectors=tp.Detector(meter, "meter"))


def slab(units):
    medium = units.medium(**FOG, phase=tp.HenyeyGreenstein(0.6))
    body = tp.Slab(center=units.place(0, 0, -0.5), thickness=units.length)
    looks = [
        tp.Detector(units.plane(0.0), "top", directions=tp.Directions(mu=3)),
        tp.Detector(units.plane(-1.0), "bottom", side="back"),
        tp.VolumeDetector(units.box((0, 0, -0.5), (2, 2, 1)), "core", cells=(1, 2, 3)),
        tp.PointDetector(units.place(0.2, 0.1, 0.5), "above"),
        tp.PointDetector(units.place(0.2, 0.1, -0.4), "within"),
    ]
    return tp.Scene(units.beam(), tp.Surface(body, CLEAR, inside=medium), looks)


def bare_slab(units):
    """Without a point detector, which forced collisions do not go with."""
    scene = slab(units)
    return tp.Scene(scene.sources, scene.surfaces, scene.detectors[:2])


def voxels(units):
    box = units.box((0, 0, 0), (2, 1, 1.5))
    fields = {"absorption": 0.23 * VOXELS / units.length, "scattering": VOXELS / units.length}
    ground = tp.Surface(units.plane(-1.0), tp.Diffuse(0.6), "ground")
    cloud = tp.Surface(box, CLEAR, "cloud", inside=tp.Grid(box=box, **fields, phase=tp.Rayleigh()))
    looks = [
        tp.Detector("ground"),
        tp.VolumeDetector("cloud", "cells", (3, 4, 2)),
        tp.VolumeDetector("cloud", "hits", (2, 2, 2), estimator="collision"),
        tp.PointDetector(units.place(0.3, 0.1, 0.2), "point"),
    ]
    return tp.Scene(units.beam(), [ground, cloud], looks)


def ducts(units):
    """A bent void in fog: boxes that touch and share faces, as in Kobayashi's dogleg."""
    legs = [((0, 0, 0), (1, 1, 1)), ((0, 0, 1), (1, 1, 1)), ((0, 1, 1), (1, 1, 1))]
    hollows = [
        tp.Surface(units.box(*leg), CLEAR, f"leg {k}", inside=tp.Vacuum()) for k, leg in enumerate(legs)
    ]
    shield = tp.Surface(units.box((0, 0, 0), (5, 5, 5)), CLEAR, "shield", inside=units.medium(0.5, 0.5))
    looks = [
        tp.VolumeDetector("leg 2", "end"),
        tp.VolumeDetector(tp.Sphere(center=units.place(0, 0, 0), radius=2 * units.length), "ball", (3,)),
        tp.VolumeDetector(
            tp.Cylinder(**dict(zip(("radius", "height"), units.size(0.6, 1.4), strict=True)), axis=(1, 2, 2)),
            "rod",
            (5, 7),
        ),
        tp.PointDetector(units.place(0.1, 1.2, 1.1), "point"),
    ]
    return tp.Scene(units.lamp((0.1, 0.05, 0.02)), [shield, *hollows], looks)


def split(units):
    return tp.Tracking(splitting=tp.Splitting(start=units.place(0, 0, 0), end=units.place(0, 0, -1), gain=30))


STRAIGHT = {"room": 2.0, "disks": 2.0, "sun": 1.5e11}  # scenes without media, and their sizes [m]
SCENES = {
    name: (make, lambda units: None) for name, make in zip(STRAIGHT, (room, disks, sun), strict=True)
} | {
    # scene, and how it is followed
    "slab": (slab, lambda units: None),
    "slab by chance": (slab, lambda units: "analog"),
    "forced": (bare_slab, lambda units: tp.Tracking(forced=True)),
    "split": (bare_slab, split),
    "voxels": (voxels, lambda units: None),
    "voxels by chance": (voxels, lambda units: "analog"),
    "ducts": (ducts, lambda units: None),
}


def read(name, units):
    """All that a run tells, back in metres and watts."""
    make, follow = SCENES[name]
    options = {"particles": HISTORIES, "batches": 4, "seed": 3, "threads": 1, "progress": False}
    result = tp.simulate(make(units), tracking=follow(units), **options)
    assert result.ledger["lost"].value == 0
    found = {entry: [value.value / units.power] for entry, value in result.ledger.items()}
    for look in result.scene.detectors:
        reading = result[look.name]
        if isinstance(look, tp.Detector):
            found[look.name] = [reading.flux_in.value / units.power, reading.flux_out.value / units.power]
        else:
            found[look.name] = np.ravel(reading.fluence_rate.value) * units.length**2 / units.power
    found["numbers"] = [result.cost.crossings, result.cost.collisions]
    return found


def assert_like(found, exact, rtol):
    assert found.keys() == exact.keys()
    for name in exact:
        np.testing.assert_allclose(found[name], exact[name], rtol=rtol, atol=0, err_msg=name)


@lru_cache
def readings(name, length=1.0, power=1.0):
    return read(name, Scale(length, power))


@pytest.mark.quick_cases("disks", "sun")
@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=() if n in (*STRAIGHT, "slab", "voxels") else pytest.mark.slow) for n in SCENES],
)
def test_other_units_change_no_bit_in_powers_of_two_and_only_roundings_in_others(name):
    """As long as no history is turned aside by a rounding, as none is here."""
    exact, rounding = readings(name), 1e-12 if name in STRAIGHT else 1e-9
    if name not in STRAIGHT:
        assert exact["numbers"][1] > HISTORIES / 4 and exact["absorbed"][0] > 0
    for scale in ({"length": 2.0**30}, {"length": 2.0**-30}, {"power": 2.0**40}, {"power": 2.0**-40}):
        assert_like(readings(name, **scale), exact, rtol=0)
    for scale in ({"length": 1e9}, {"length": 1e-9}, {"power": 1e12}, {"power": 1e-12}):
        assert_like(readings(name, **scale), exact, rtol=rounding)


class Swollen(Scale):
    """Places further apart by a millionth, coefficients and sizes as they are."""

    def place(self, *coordinates):
        return tuple((1 + 1e-6) * x for x in super().place(*coordinates))


@pytest.mark.parametrize("name", ["disks", "sun", "slab", "voxels", "voxels by chance", "ducts"])
def test_lengths_that_grow_alone_are_seen(name):
    """At once by a point detector or an aim: so the comparison can fail."""
    look = list(readings(name))[-2]
    with pytest.raises(AssertionError, match="Not equal"):
        np.testing.assert_allclose(read(name, Swollen())[look], readings(name)[look], rtol=1e-9)


@pytest.mark.parametrize("name", STRAIGHT)
def test_the_place_does_not_matter(name):
    """Moved by a million of its sizes a scene gives the same within errors, and nothing is lost or leaks out."""
    make, size = SCENES[name][0], STRAIGHT[name]
    there = Scale(shift=(1e6 * size, -0.7e6 * size, 0.3e6 * size))
    moved, other = (
        tp.simulate(make(units), 200_000, seed=seed, progress=False)
        for units, seed in ((there, 1), (Scale(), 2))
    )
    for look in make(there).detectors:
        assert_agrees(moved[look.name].flux_in - other[look.name].flux_in, 0.0, FALSE_ALARM / 10)
    assert moved.ledger["lost"].value == 0
    assert name != "room" or moved.ledger["escaped"].value == 0
