"""What collisions cost, from thin to thick: seconds grow as their number does.

    python -m tests.bench.media

A conservative slab of optical depth 1 to 100, isotropic scattering, one thread; nanoseconds a collision and a flight.
"""

import time

from tests.bench.speed import slab_scene
from transport.simulate import simulate

WORK = 2e7  # collisions of each run, about
DEPTHS = (1, 3, 10, 30, 100)


def cost_of(depth: float) -> tuple[float, float, float]:
    """Collisions a photon, and nanoseconds a collision and a flight, the least of three runs."""
    scene = slab_scene(depth=float(depth), albedo=1.0, g=0.0)
    photons = int(WORK / (1.5 * depth + 1))
    simulate(scene, particles=1000, seed=0, threads=1, progress=False)
    best = float("inf")
    for seed in range(3):
        begun = time.perf_counter()
        result = simulate(scene, particles=photons, seed=seed, threads=1, progress=False)
        best = min(best, time.perf_counter() - begun)
    collisions = result.cost.collisions
    return collisions / photons, 1e9 * best / collisions, 1e9 * best / (collisions + photons)


if __name__ == "__main__":
    print(f"{'depth':>6} {'collisions a photon':>20} {'ns a collision':>15} {'ns a flight':>12}")
    for depth in DEPTHS:
        print("{:6g} {:20.2f} {:15.2f} {:12.2f}".format(depth, *cost_of(depth)))
