"""Free paths far below the scene's size: right as long as coordinates have digits for them, then refused.

Collisions keep 2^-48 of the scene clear of surfaces.  A code that does not ask goes on when free paths are shorter than that,
and reports 0.008 for the reflectance 0.415 of milk under the sun at its true distance.
"""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from transport.theory import ordinates

FALSE_ALARM = 1e-4
HALF_SPACE = ordinates.half_space(0.9, mu0=1.0).reflected


def milk(mfp, lamp=1.0):
    """A thick slab of albedo 0.9 below z = 0, under a pencil beam from `lamp` metres above."""
    medium = tp.Medium(absorption=0.1 / mfp, scattering=0.9 / mfp)
    beam = tp.Source(tp.Point(position=(0, 0, lamp)), tp.Beam((0, 0, -1), power=1.0))
    slab = tp.Surface(tp.Slab(center=(0, 0, -0.5), thickness=1.0), tp.Transparent(), inside=medium)
    return tp.Scene(beam, slab, tp.Detector(tp.Plane(), "up"))


@pytest.mark.parametrize("tracking", ["weighted", "analog"])
@pytest.mark.parametrize(("mfp", "lamp"), [(1e-3, 1.0), (1e-6, 1.0), (1e-9, 1.0), (1e-6, 1e3)])
def test_dense_media_reflect_as_a_half_space(mfp, lamp, tracking):
    result = tp.simulate(milk(mfp, lamp), particles=200_000, seed=2, threads=1, tracking=tracking)
    assert_agrees(result["up"].flux_out, HALF_SPACE, FALSE_ALARM)
    assert result.ledger["lost"].value == 0


@pytest.mark.parametrize(("mfp", "lamp"), [(1e-10, 1.0), (1e-13, 1.0), (1e-4, 1.5e11)])
def test_free_paths_without_digits_are_refused(mfp, lamp):
    with pytest.raises(
        tp.SceneError, match=r"Medium: mean free paths must be above .* bring far objects nearer"
    ):
        tp.simulate(milk(mfp, lamp), particles=10, threads=1)


def test_a_dense_voxel_is_refused_and_a_dense_absorber_is_not():
    box = tp.Box(size=1.0)
    grid = tp.Grid(box=box, scattering=np.array([[[1.0, 1e13]]]))
    beam = tp.Source(tp.Point(position=(0, 0, 2)), tp.Beam((0, 0, -1), power=1.0))
    with pytest.raises(tp.SceneError, match="Grid: mean free paths must be above"):
        tp.simulate(tp.Scene(beam, tp.Surface(box, tp.Transparent(), inside=grid)), particles=10, threads=1)
    black = tp.Surface(box, tp.Transparent(), inside=tp.Medium(absorption=1e15))
    assert tp.simulate(tp.Scene(beam, black), particles=10, threads=1).ledger["absorbed"].value == 1.0


@pytest.mark.parametrize(("tracking", "within"), [("weighted", 1e-6), ("analog", 0.01)])
def test_volumes_measure_the_ways_in_an_absorber_as_long_as_there_are_digits_for_them(tracking, within):
    """Beyond, they would measure roundings: a fluence 30 % too high at 1e13 per metre, negative at 1e25."""
    box = tp.Box(size=1.0)

    def block(absorption):
        body = tp.Surface(box, tp.Transparent(), inside=tp.Medium(absorption=absorption))
        lamp = tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.3)
        beam = tp.Source(lamp, tp.Beam((0.1, 0, -1), power=1.0))
        return tp.Scene(beam, body, tp.VolumeDetector(box, "box"))

    result = tp.simulate(block(5e8), particles=200_000, seed=2, threads=1, tracking=tracking)
    assert result["box"].absorbed_power.value == pytest.approx(1.0, rel=within)
    refused = "mean free paths must be above .* omit the VolumeDetectors"
    for absorption in (1e13, 1e25):
        with pytest.raises(tp.SceneError, match=refused):
            tp.simulate(block(absorption), particles=10, threads=1, tracking=tracking)
