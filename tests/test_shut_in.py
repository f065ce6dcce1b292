"""Detectors that count nothing because an opaque shell is closed about them say so; and only these."""

from __future__ import annotations

import pytest

import transport as tp

LAMP = tp.Source(tp.Point(position=(0, 0, 5)), tp.Isotropic(power=1.0))
SHELLS = {
    "box": tp.Box(size=2.0),
    "ball": tp.Sphere(radius=1.0),
    "mesh": tp.Mesh.sphere(radius=1.0, triangles=80),
}


def warned(
    material, shape=SHELLS["box"], lamp=LAMP, place=(0.1, 0, 0), size=0.5, words="'shell' encloses it"
):
    shell = tp.Surface(shape, material, "shell")
    detectors = [tp.PointDetector(place, "p"), tp.VolumeDetector(tp.Box(center=place, size=size), "v")]
    if shape == SHELLS["box"]:
        detectors.append(tp.VolumeDetector("shell", "all"))
    scene = tp.Scene(lamp, shell, detectors)
    result = tp.simulate(scene, particles=500, seed=1, threads=1, progress=False)
    return [warning for warning in result.warnings if words in warning]


@pytest.mark.parametrize("name", SHELLS)
def test_what_is_shut_in_is_told_with_its_shell(name):
    for material in (tp.Black(), tp.Diffuse(0.5)):
        found = warned(material, SHELLS[name])
        assert len(found) == (3 if name == "box" else 2)
        assert found[-1].startswith("point detector 'p' counted nothing")
        assert all(warning.startswith("volume detector") for warning in found[:-1])


def test_what_lets_light_in_or_has_a_source_in_it_is_not_told():
    assert not warned(tp.Diffuse(0.5, transmission=1e-12)) and not warned(tp.Transparent())
    up = tp.Beam((0, 0, 1), power=1.0)
    for inside in (
        tp.Source(tp.Point(position=(0, 0, 0.9)), up),  # which both miss
        tp.Source(tp.Disk(center=(0, 0, 0.9), radius=3.0), up),  # in and outside
    ):
        assert not warned(tp.Black(), lamp=inside)


def test_a_source_on_the_outside_of_the_shell_is_told_its_side():
    lamp = tp.Source("shell", tp.Lambertian(power=1.0))
    found = warned(tp.Black(), lamp=lamp, words="emits from the outside of Surface 'shell'")
    assert len(found) == 3 and all("side='inside'" in warning for warning in found)


def test_what_lies_outside_or_in_the_wall_is_not_told():
    beam = tp.Source(tp.Point(position=(0, 0, 5)), tp.Beam((0, 0, 1), power=1.0))
    assert len(warned(tp.Black(), lamp=beam, place=(3, 0, 0))) == 1  # the box by its name alone
    assert (
        len(warned(tp.Black(), lamp=beam, place=(0.9, 0, 0))) == 2
    )  # and a point, but no volume that reaches out
