"""Directions close to a pole, to the horizon and to each other."""

import math

import transport as tp
from transport.hard.cases import Seen, case


@case("a disk 1e9 radii away, seen by what a point lamp sends into it", naive="Ω = 2π (1 - cos θ)")
def far_disk() -> Seen:
    """cos θ rounds to 1 below θ = 1e-8, and the difference is 0: no light at all."""
    meter = tp.Disk(center=(0, 0, 1e9), normal=(0, 0, -1), radius=1.0)
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0), aim=meter)
    scene = tp.Scene(lamp, detectors=tp.Detector(meter, "meter"))
    found = tp.simulate(scene, particles=2000, seed=1, progress=False)["meter"].flux_in
    naive = (1 - math.cos(1e-9)) / 2
    return Seen(found, 2.5e-19, naive)
