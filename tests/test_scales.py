"""Units and place do not matter: box, disks and sun give the same digits in any unit of length or power, anywhere.

The seed is 1; comparisons of moved scenes fail right code in one of a thousand choices of seeds, all together.
"""

from __future__ import annotations

import dataclasses
import math

import pytest

import transport as tp
from tests.agreement import assert_agrees
from transport.sims import diffuse_box, lambert_disk, sun

FALSE_ALARM = 1e-3  # of all detectors of all moved scenes
SCENES = {
    "box": diffuse_box.scene(albedo=0.5),
    "disk": lambert_disk.scene(distance=2.0),
    "disk, oblique": lambert_disk.scene(distance=2.0, offset=1.5),
    "sun, lecture": sun.scene("Earth", "solid angle"),
    "sun": sun.scene("Mars", "distance", zenith_angle=1.0),
}
LENGTHS = ("radius", "inner_radius", "width", "height")


def moved(scene, length=1.0, power=1.0, shift=(0.0, 0.0, 0.0)):
    """The scene with all lengths and all emissions multiplied, and then shifted [m]."""

    def shape_of(shape):
        if shape is None or isinstance(shape, str):
            return shape
        sizes = {name: length * getattr(shape, name) for name in LENGTHS if hasattr(shape, name)}
        center = [length * x + s for x, s in zip(shape.center, shift, strict=True)]
        return dataclasses.replace(shape, center=center, **sizes)

    def emission_of(emission):
        amounts = ("radiance", "exitance", "power")
        [(name, amount)] = [(n, getattr(emission, n)) for n in amounts if getattr(emission, n) is not None]
        return tp.Lambertian(**{name: power * amount})

    changes = {
        "sources": lambda s: {"emission": emission_of(s.emission), "aim": shape_of(s.aim)},
        "surfaces": lambda s: {},
        "detectors": lambda s: {},
    }
    parts = {
        kind: [
            dataclasses.replace(part, shape=shape_of(part.shape), **change(part))
            for part in getattr(scene, kind)
        ]
        for kind, change in changes.items()
    }
    return tp.Scene(**parts)


def fluxes(scene):
    """All fluxes of a run over what its scene emits."""
    result = tp.simulate(scene, particles=200_000, seed=1, threads=2)
    emitted = result.ledger["emitted"].value
    entries = [result.ledger[name].value for name in ("absorbed", "escaped", "unsampled")]
    readings = [
        getattr(result[d.name], side).value for d in scene.detectors for side in ("flux_in", "flux_out")
    ]
    return [value / emitted for value in entries + readings]


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize(
    "change", [{"length": 1e-6}, {"length": 1e6}, {"length": 1e11}, {"power": 1e-9}, {"power": 1e9}]
)
def test_the_unit_of_length_or_power_does_not_matter(name, change):
    """The same digits to 1e-12."""
    scene = SCENES[name]
    area = change.get("length", 1.0) ** 2 if scene.sources[0].emission.power is None else 1.0
    factor = area * change.get("power", 1.0)
    emitted = [
        math.fsum(s.amount(where.shape_of(s), where.duration) for s in where.sources)
        for where in (scene, moved(scene, **change))
    ]
    assert emitted[1] == pytest.approx(factor * emitted[0], rel=1e-14)
    assert fluxes(moved(scene, **change)) == pytest.approx(fluxes(scene), rel=1e-12, abs=0)


def test_a_distance_that_grows_alone_by_a_billionth_is_seen():
    near, far = (fluxes(lambert_disk.scene(distance=distance)) for distance in (2.0, 2.0 * (1 + 1e-9)))
    assert far != pytest.approx(near, rel=1e-12, abs=0)
    assert far == pytest.approx(near, rel=1e-8, abs=0)


@pytest.mark.parametrize("name", SCENES)
def test_the_place_does_not_matter(name):
    """Moved by a million of its sizes a scene gives the same within errors, and nothing is lost or leaks out."""
    scene = SCENES[name]
    size = max(2.0, *(abs(x) for d in scene.detectors for x in scene.shape_of(d).center))
    result = tp.simulate(
        moved(scene, shift=(1e6 * size, -0.7e6 * size, 0.3e6 * size)), particles=1_000_000, seed=1
    )
    other = tp.simulate(scene, particles=1_000_000, seed=2)
    for detector in scene.detectors:
        difference = result[detector.name].flux_in - other[detector.name].flux_in
        assert_agrees(difference, 0.0, FALSE_ALARM / 10)
    assert result.ledger["lost"].value == 0
    assert name != "box" or result.ledger["escaped"].value == 0
