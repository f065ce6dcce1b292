"""In media too units do not matter: the same bits in powers of two, the same to rounding in any other unit.

A foggy slab, voxels, ducts between boxes of fog, splitting and forcing, with meters, volume and point
detectors: lengths from 1e-9 to 1e9 of a metre (coefficients inversely), powers from 1e-12 to 1e12 W.  Nothing
here depends on chance but the histories, and these are the same ones.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import transport as tp

CLEAR = tp.Transparent()
HISTORIES = 500
FOG = {"absorption": 0.3, "scattering": 1.5}
VOXELS = np.random.default_rng(1).uniform(0.1, 3.0, (3, 4, 2))


class Scale:
    """Shapes, media and sources in some units."""

    def __init__(self, length: float = 1.0, power: float = 1.0) -> None:
        self.length, self.power = length, power

    def place(self, *coordinates):
        return tuple(self.length * x for x in coordinates)

    def box(self, center, size):
        return tp.Box(center=self.place(*center), size=self.place(*size))

    def plane(self, z):
        return tp.Plane(center=self.place(0, 0, z))

    def medium(self, absorption, scattering, **how):
        return tp.Medium(absorption / self.length, scattering / self.length, **how)

    def beam(self, position=(0, 0, 1), direction=(0.3, 0.2, -1)):
        return tp.Source(tp.Point(position=self.place(*position)), tp.Beam(direction, power=self.power))

    def lamp(self, position):
        return tp.Source(tp.Point(position=self.place(*position)), tp.Isotropic(power=self.power))


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
        tp.VolumeDetector(tp.Sphere(radius=2 * units.length), "ball", (3,)),
        tp.PointDetector(units.place(0.1, 1.2, 1.1), "point"),
    ]
    return tp.Scene(units.lamp((0.1, 0.05, 0.02)), [shield, *hollows], looks)


def split(units):
    return tp.Tracking(splitting=tp.Splitting(start=units.place(0, 0, 0), end=units.place(0, 0, -1), gain=30))


SCENES = {  # scene, and how it is followed
    "slab": (slab, lambda units: None),
    "slab by chance": (slab, lambda units: "analog"),
    "forced": (bare_slab, lambda units: tp.Tracking(forced=True)),
    "split": (bare_slab, split),
    "voxels": (voxels, lambda units: None),
    "voxels by chance": (voxels, lambda units: "analog"),
    "ducts": (ducts, lambda units: None),
}


@lru_cache
def readings(name, length=1.0, power=1.0):
    return read(name, Scale(length, power))


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


@pytest.mark.parametrize("name", SCENES)
def test_in_other_powers_of_two_all_bits_are_the_same(name):
    """Nothing is rounded otherwise: lengths by 2^30 and its inverse, powers by 2^40."""
    exact = readings(name)
    assert exact["numbers"][1] > HISTORIES / 4 and exact["absorbed"][0] > 0
    for scale in ({"length": 2.0**30}, {"length": 2.0**-30}, {"power": 2.0**40}, {"power": 2.0**-40}):
        assert_like(readings(name, **scale), exact, rtol=0)


@pytest.mark.parametrize("name", SCENES)
def test_in_any_other_unit_the_same_comes_out_to_rounding(name):
    """As long as no history is turned aside by it, as none is here."""
    for scale in ({"length": 1e9}, {"length": 1e-9}, {"power": 1e12}, {"power": 1e-12}):
        assert_like(readings(name, **scale), readings(name), rtol=1e-9)


class Swollen(Scale):
    """Places further apart by a millionth, coefficients and sizes as they are."""

    def place(self, *coordinates):
        return tuple((1 + 1e-6) * x for x in super().place(*coordinates))


@pytest.mark.parametrize("name", ["slab", "voxels", "voxels by chance", "ducts"])
def test_lengths_that_grow_alone_are_seen(name):
    """A point detector tells them apart at once: so the comparison can fail."""
    look = list(readings(name))[-2]
    assert isinstance(SCENES[name][0](Scale()).detectors[-1], tp.PointDetector)
    with pytest.raises(AssertionError, match="Not equal"):
        np.testing.assert_allclose(read(name, Swollen())[look], readings(name)[look], rtol=1e-9)
