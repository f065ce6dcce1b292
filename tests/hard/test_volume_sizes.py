"""Volume detectors of any size at any place, a billionth of the scene too; sums that would overflow."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import transport as tp
from tests.hard.volume_rays import BOX, LAMP
from transport.compile.compiler import compile_scene
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program


@lru_cache
def moved(scale, offset):
    """What two volumes read in a fog, in any unit of length and at any place; back in metres."""

    def place(*p):
        return tuple(scale * (x + o) for x, o in zip(p, offset, strict=True))

    lamp = tp.Source(tp.Sphere(radius=scale, center=place(0, 0, 0)), tp.Lambertian(power=1.0), side="back")
    looks = [
        tp.VolumeDetector(tp.Box(size=0.5 * scale, center=place(0, 0.25, 0)), "box", (3, 2, 1)),
        tp.VolumeDetector(tp.Sphere(radius=0.5 * scale, center=place(0, 0, 0.25)), "ball", 3),
    ]
    medium = tp.Medium(absorption=0.3 / scale, scattering=1.0 / scale)
    scene = tp.Scene(lamp, [], looks, medium=medium)
    result = tp.simulate(scene, particles=2000, seed=1, tracking="weighted", progress=False)
    return {
        (name, quantity): getattr(result[name], quantity).value * scale**power
        for name in result
        for quantity, power in (("fluence_rate", 2), ("absorbed_power", 0))
    }


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1.5e11])
@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (3.0, -7.0, 5.0)])
def test_the_unit_and_the_origin_do_not_matter(scale, offset):
    for key, exact in moved(1.0, (0.0, 0.0, 0.0)).items():
        np.testing.assert_allclose(moved(scale, offset)[key], exact, rtol=1e-9)


def test_a_volume_as_small_as_a_billionth_of_the_scene_is_counted_rightly():
    """Two of them: one is where numbers are finest, the other is not."""
    tiny = 1e-9
    looks = [
        tp.VolumeDetector(tp.Box(size=tiny, center=center), name, (2, 1, 1))
        for name, center in (("at the origin", (0, 0, 0)), ("aside", (0.3, 0.4, 0.0)))
    ]
    for look in looks:
        aim = tp.Sphere(radius=tiny, center=look.shape.center)
        lamp = tp.Source(tp.Point(position=(0, 0, 0.9)), tp.Isotropic(intensity=1.0), aim=aim)
        result = tp.simulate(tp.Scene(lamp, [], looks), particles=20_000, seed=1, progress=False)
        found = result[look.name].fluence_rate.mean()
        exact = 1 / ((0.9**2) + look.shape.center[0] ** 2 + look.shape.center[1] ** 2)
        assert abs(found.value - exact) < 5 * found.error and found.relative_error < 0.02


def test_a_batch_that_scores_too_much_is_refused_before_a_sum_overflows(monkeypatch):
    """The guard is asked between bundles: as if 2^60 units had been added up."""
    from transport.engine import driver

    scene = tp.Scene(LAMP, [], tp.VolumeDetector(BOX, "box"))
    machine = compile_program(build_program(compile_scene(scene)))
    real = driver.drive

    def full(lanes, *rest):
        real(lanes, *rest)
        lanes["scored"] = driver.MAX_SCORED

    monkeypatch.setattr(driver, "drive", full)
    with pytest.raises(OverflowError, match="pass more batches"):
        run_batch(machine, seed=1, batch=0, histories=100)
