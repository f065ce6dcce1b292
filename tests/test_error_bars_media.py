"""Error bars in media are right: over many seeds z has mean 0 and spread 1, however histories are followed.

A small slab by chance, by weight, forced and split; and rooms in which light is the same everywhere,
with fog or voxels in them, for cells of volume detectors and a point detector.  All together fail right code
in two of a thousand choices of seeds; error bars that are wrong by a factor of 1.5 are rejected.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_z_spread
from transport.theory import ordinates

SEEDS, HISTORIES, BATCHES = 200, 1000, 16
TAU, ALBEDO, G = 1.0, 0.8, 0.5
EXACT = ordinates.slab(TAU, ALBEDO, ordinates.henyey_greenstein(G))
SPLITTING = tp.Splitting(start=(0, 0, 0), end=(0, 0, -1), gain=8.0)
TRACKINGS = {
    "analog": tp.Tracking(absorption="analog"),
    "weighted": tp.Tracking(),
    "forced": tp.Tracking(forced=True),
    "split": tp.Tracking(splitting=SPLITTING),
}


def slab():
    fog = tp.Medium((1 - ALBEDO) * TAU, ALBEDO * TAU, phase=tp.HenyeyGreenstein(G))
    body = tp.Slab(center=(0, 0, -0.5), thickness=1.0)
    beam = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
    faces = [tp.Detector(tp.Plane(), "top"), tp.Detector(tp.Plane(center=(0, 0, -1)), "bottom", side="back")]
    return tp.Scene(beam, tp.Surface(body, tp.Transparent(), inside=fog), faces)


def furnace():
    """Wall and fog both shine by a radiance of 1: the fluence rate is 4 pi in every place."""
    fog = tp.Medium(0.5, 2.0, phase=tp.HenyeyGreenstein(0.5), emission=0.5)
    return looked_into(fog)


def cloud():
    """Voxels in a shining room: whatever only scatters leaves a radiance of 1 as it is."""
    box, voxels = tp.Box(size=1.1), np.random.default_rng(1).uniform(0.2, 4.0, (3, 2, 2))
    filling = tp.Grid(box=box, scattering=voxels, phase=tp.HenyeyGreenstein(0.5))
    return looked_into(tp.Vacuum(), tp.Surface(box, tp.Transparent(), inside=filling))


def looked_into(medium, *bodies):
    """A room of grey walls with two cells of a box, two shells, and a point."""
    wall = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.6), "wall", inside=medium)
    lamp = tp.Source("wall", tp.Lambertian(exitance=0.4 * math.pi), side="back")
    looks = [
        tp.VolumeDetector(tp.Box(size=1.0), "voxels", (2, 1, 1)),
        tp.VolumeDetector(tp.Sphere(radius=0.8), "shells", (0.0, 0.6, 0.8)),
        tp.VolumeDetector(tp.Box(size=0.9), "hits", estimator="collision"),
        tp.PointDetector((0.3, 0.1, 0.2), "point"),
    ]
    return tp.Scene(lamp, [wall, *bodies], looks)


def of_slab(result):
    """Reflected, transmitted, absorbed: three scores."""
    lost = 1 - EXACT.reflected - EXACT.transmitted
    found = (result["top"].flux_out, result["bottom"].flux_out, result.ledger["absorbed"])
    return [e.z(x) for e, x in zip(found, (EXACT.reflected, EXACT.transmitted, lost), strict=True)]


def of_room(result):
    """Two voxels, two shells, collisions in a box, a point: six scores."""
    return [z for look in result for z in np.ravel(result[look].fluence_rate.z(4 * math.pi))]


RUNS = {name: (slab(), tracking, of_slab) for name, tracking in TRACKINGS.items()}
RUNS |= {"furnace": (furnace(), None, of_room), "cloud": (cloud(), None, of_room)}
SCORES = 4 * 3 + 2 * 6
FALSE_ALARM = 1e-3 / SCORES


def scores(name):
    """z of each quantity over the seeds."""
    scene, tracking, score = RUNS[name]
    options = {"batches": BATCHES, "threads": 1, "progress": False, "tracking": tracking}
    return np.transpose([score(tp.simulate(scene, HISTORIES, seed=seed, **options)) for seed in range(SEEDS)])


@pytest.mark.parametrize("name", RUNS)
def test_scores_in_media_over_seeds_are_normal(name):
    for each in scores(name):
        assert_z_spread(each, math.inf, FALSE_ALARM)
        for wrong in (1.5 * each, each / 1.5):
            with pytest.raises(AssertionError, match="spread"):
                assert_z_spread(wrong, math.inf, FALSE_ALARM)


def test_voxels_are_walked_by_numbers_of_their_own_in_every_batch():
    """Among thick voxels most tentative collisions in thin ones are not real: the spread stays binomial.

    Over 256 batches the variance is known to 9 %; five times that fails right code in one of 10^5 seeds.
    """
    voxels = np.full((16, 16, 64), 0.5)
    voxels[::2, ::2, ::2] = 5.0
    grid = tp.Grid(box=tp.Box(size=1.0), absorption=voxels)
    beam = tp.Source(tp.Point(position=(1.5 / 16, 1.5 / 16, -1)), tp.Beam((0, 0, 1), power=1.0))
    scene = tp.Scene(beam, tp.Surface(grid.box, tp.Transparent(), inside=grid))
    options = {"tracking": "analog", "threads": 1, "progress": False}
    result = tp.simulate(scene, particles=100 * 256, batches=256, seed=1, **options)
    passed = np.array([batch.ledger["escaped"] for batch in result.batches])
    share = math.exp(-0.5)
    assert abs(passed.var(ddof=1) / (100 * share * (1 - share)) - 1) < 5 * math.sqrt(2 / 255)
