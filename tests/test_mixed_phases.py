"""A mixture of phase functions scatters into each part's angles with that part's share: three parts, told apart."""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from transport.theory import phases

FALSE_ALARM = 1e-6
SCATTERING = 1e-3  # of a ball of radius 1: what is scattered twice is a thousandth
MU = np.array([-1.0, -0.6, 0.0, 0.6, 1.0])
PARTS = {
    tp.HenyeyGreenstein(0.8): (0.5, lambda mu: phases.henyey_greenstein_share(mu, 0.8)),
    tp.HenyeyGreenstein(-0.7): (0.3, lambda mu: phases.henyey_greenstein_share(mu, -0.7)),
    tp.Rayleigh(): (0.2, phases.rayleigh_share),
}


def scattered_once(phase):
    """Shares of what a ball of thin fog scatters of a beam along +z, by its angle, ahead first."""
    fog = tp.Medium(scattering=SCATTERING, phase=phase)
    ball = tp.Surface(tp.Sphere(radius=1.0), tp.Transparent(), inside=fog)
    beam = tp.Source(tp.Point(position=(0, 0, -5)), tp.Beam(direction=(0, 0, 1), power=1.0))
    angles = tuple(np.arccos(MU[::-1]))
    sky = tp.Detector(
        tp.Sphere(radius=1e3), "sky", side="inside", events=(1, 1), positions=tp.Positions(u=angles)
    )
    scene = tp.Scene(beam, ball, sky)
    run = tp.simulate(scene, 100_000, seed=1, tracking=tp.Tracking(forced=True), progress=False)
    seen = run["sky"].irradiance
    return seen * sky.positions.areas(sky.shape).reshape(seen.shape) / run["sky"].flux_in


def test_each_part_scatters_by_its_share():
    shares = scattered_once(tp.Mixture({phase: share for phase, (share, _) in PARTS.items()}))
    exact = sum(share * np.diff(law(MU)) for share, law in PARTS.values())[::-1]
    assert_agrees(shares, exact.reshape(shares.shape), FALSE_ALARM)
    alone = np.diff(phases.rayleigh_share(MU))[::-1]
    with pytest.raises(AssertionError):
        assert_agrees(shares, (exact + 0.05 * (alone - exact)).reshape(shares.shape), FALSE_ALARM)
