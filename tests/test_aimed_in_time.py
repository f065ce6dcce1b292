"""An aimed particle is kept at its target while it flies there: every count on the way must find where it is.

A flash is aimed at a target so small that all rays are one, from the origin along +z.  It has flown a
known way when the clock stops, and every part of that way gets the same energy times length.  These are
laws of every history, without noise.
"""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp

SMALL, FAR = 1e-3, 3.0  # m: of the targets, and how far away they are; cosines are 1 within 6e-8
PLACE = {"center": (0, 0, FAR)}
TARGETS = {
    "disk": tp.Disk(**PLACE, normal=(0, 0, -1), radius=SMALL),
    "rectangle": tp.Rectangle(**PLACE, normal=(0.2, 0, -1), width=SMALL, height=SMALL),
    "triangle": tp.Triangle(vertices=[(0, 0, FAR), (SMALL, 0, FAR), (0, SMALL, FAR)]),
    "sphere": tp.Sphere(**PLACE, radius=SMALL),
    "box": tp.Box(**PLACE, size=SMALL),
}
ENERGY, BORN, SPEED = 2.0, 0.25, 2.0  # J, s, m/s
WITHIN = 1e-6  # relative: of the cosines, and of the energy as what is not unsampled
SKY = tp.Detector(tp.Sphere(radius=20.0), "sky", side="inside", speeds=(0.0, 3.0))
PACES = {  # what tells how far a flight comes: what else is looked at, and the index of refraction
    "one speed": ((), 1.0),
    "each its own speed": ((SKY,), 1.0),
    "slower in a medium": ((), 1.5),
}
WAYS = {"before the target": 1.3, "beyond the target": 4.3}  # m flown when the clock stops
LAYERS = np.linspace(-0.7, 4.9, 9)
SHELLS = np.array([0.0, 0.5, 1.0, 2.0, 4.0, 5.0])


def flash(target, looks, way, pace):
    """A flash that has flown so far when the clock stops, and what of its energy goes to the target [J]."""
    others, index = PACES[pace]
    law, pulse = tp.Isotropic(energy=ENERGY, speed=SPEED), tp.Instant(BORN)
    scene = tp.Scene(
        tp.Source(tp.Point(), law, aim=TARGETS[target], pulse=pulse),
        detectors=[*looks, *others],
        medium=tp.Vacuum() if index == 1 else tp.Medium(index=index),
        duration=BORN + way * index / SPEED,
    )
    result = tp.simulate(scene, particles=500, seed=1, progress=False)
    return result, ENERGY - result.ledger["unsampled"].value


@pytest.mark.parametrize("when", WAYS)
@pytest.mark.parametrize("pace", PACES)
@pytest.mark.parametrize("target", TARGETS)
def test_the_fluence_of_an_aimed_flash_is_on_the_way_that_it_has_flown(target, pace, when):
    """In volumes of one cell, in layers, in shells about the source, and not where it has not come yet."""
    way, middle, height = WAYS[when], (LAYERS[0] + LAYERS[-1]) / 2, LAYERS[-1] - LAYERS[0]
    box, ball = tp.Box(center=(0, 0, middle), size=(1, 1, height)), tp.Sphere(radius=SHELLS[-1])
    looks = {
        tp.VolumeDetector(box, "box"): LAYERS[[0, -1]],
        tp.VolumeDetector(box, "layers", (1, 1, len(LAYERS) - 1)): LAYERS,
        tp.VolumeDetector(ball, "ball"): SHELLS[[0, -1]],
        tp.VolumeDetector(ball, "shells", tuple(SHELLS)): SHELLS,
        tp.VolumeDetector(tp.Sphere(center=(0, 0, 4), radius=0.5), "far"): np.array([3.5, 4.5]),
    }
    result, energy = flash(target, looks, way, pace)
    for look, edges in looks.items():
        found = (result[look.name].fluence * result[look.name].volumes).value
        exact = energy * np.diff(np.clip(edges, 0.0, way))
        assert np.ravel(found) == pytest.approx(exact, rel=WITHIN, abs=WITHIN * energy), look.name


@pytest.mark.parametrize("target", TARGETS)
def test_phase_space_finds_an_aimed_flash_as_far_as_it_has_flown(target):
    """In the one bin of a centimetre of z that holds it, at every instant."""
    ways, edges = np.array([0.005, 0.605, 1.805, 2.985, 4.195]), np.linspace(-1.0, 5.0, 601)
    looks = tp.PhaseSpace(z=edges, time=tuple(BORN + ways / SPEED), name="z")
    result, energy = flash(target, [looks], 4.3, "each its own speed")
    exact = np.zeros((len(ways), len(edges) - 1))
    exact[np.arange(len(ways)), np.searchsorted(edges, ways) - 1] = energy
    np.testing.assert_allclose(result["z"].number.value, exact, rtol=WITHIN)


@pytest.mark.parametrize("pace", PACES)
@pytest.mark.parametrize("target", TARGETS)
def test_an_aimed_flash_crosses_each_pane_when_it_has_flown_there(target, pace):
    """In the one bin of time in which it flies the centimetre there; it has passed other panes on the way."""
    places, edges = (0.605, 1.405, 2.205, 3.405, 3.905), np.linspace(0.0, 4.2, 421)
    times = BORN + edges * PACES[pace][1] / SPEED
    panes = {f"pane {k}": tp.Disk(center=(0, 0, z), radius=0.1) for k, z in enumerate(places)}
    looks = [tp.Detector(pane, name, side="back", times=times) for name, pane in panes.items()]
    result, energy = flash(target, looks, 4.3, pace)
    for name, z in zip(panes, places, strict=True):
        exact = np.where(np.arange(len(edges) - 1) == np.searchsorted(edges, z) - 1, energy, 0.0)
        np.testing.assert_allclose(result[name].energy_in.value, exact, rtol=WITHIN, err_msg=name)
