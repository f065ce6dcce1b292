"""What tracking is worth: 1/(error^2 time) of weighted histories, by the threshold of their roulette, over that of analog ones.

python -m tests.bench.tracking [--repeats 5]
"""

import time
from itertools import product

import numpy as np
import typer

import transport as tp

DEPTHS, ALBEDOS, COSINES = (0.1, 1.0, 3.0, 8.0, 20.0), (0.2, 0.9, 0.999), (0.0, 0.9)
THRESHOLDS = (0.25, 1e-2, 1e-3, 1e-4, 1e-5)
SECONDS = 0.1  # about, of a run
FIGURES = ("reflected", "transmitted", "absorbed")


def slab(tau: float, albedo: float, g: float) -> tp.Scene:
    """One metre thick, under a pencil beam."""
    medium = tp.Medium((1 - albedo) * tau, albedo * tau, tp.HenyeyGreenstein(g))
    beam = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
    body = tp.Slab(center=(0, 0, -0.5), thickness=1.0)
    meters = [
        tp.Detector(tp.Plane(), "top"),
        tp.Detector(tp.Plane(center=(0, 0, -1), normal=(0, 0, -1)), "end"),
    ]
    return tp.Scene(beam, tp.Surface(body, tp.Transparent(), inside=medium), meters)


def measured(scene: tp.Scene, particles: int, tracking, seed: int) -> tuple[float, np.ndarray]:
    """CPU seconds, and the squared errors of the three figures."""
    start = time.process_time()
    result = tp.simulate(scene, particles, seed=seed, threads=1, tracking=tracking)
    taken = time.process_time() - start
    found = (result["top"].flux_out, result["end"].flux_out, result.ledger["absorbed"])
    return taken, np.array([estimate.error**2 for estimate in found])


def efficiencies(scene: tp.Scene, repeats: int) -> np.ndarray:
    """(thresholds, figures) over analog, in turns; nan where analog tells no error; and last the rate of photons."""
    trackings = ["analog", *(tp.Tracking(roulette=each) for each in THRESHOLDS)]
    taken, _ = measured(scene, 20_000, trackings[-1], 0)
    particles = int(np.clip(20_000 * SECONDS / taken, 2e4, 1e6))
    runs = []
    for seed in range(1, repeats + 1):  # each in another order, lest what comes last is always the warmest
        turn = {
            k: measured(scene, particles, trackings[k], seed)
            for k in np.roll(np.arange(len(trackings)), seed)
        }
        runs.append([turn[k] for k in range(len(trackings))])
    seconds = np.median([[taken for taken, _ in turn] for turn in runs], axis=0)
    squares = np.mean([[square for _, square in turn] for turn in runs], axis=0)
    worth = 1 / squares / seconds[:, None]
    return np.c_[worth[1:] / worth[0], seconds[0] / seconds[1:]]


def main(repeats: int = 5) -> None:
    """Print the least, the median and the largest gain over all slabs."""
    cases = list(product(DEPTHS, ALBEDOS, COSINES))
    found = np.array([efficiencies(slab(*case), repeats) for case in cases])
    print(f"over analog, of {len(cases)} slabs: least, median, most")
    for k, name in enumerate((*FIGURES, "photons a second")):
        for threshold, ratios in zip(THRESHOLDS, found[:, :, k].T, strict=True):
            least, median, most = np.nanquantile(ratios, (0, 0.5, 1))
            print(f"{name:16}  roulette {threshold:7g}  {least:8.3g} {median:8.3g} {most:8.3g}")


if __name__ == "__main__":
    typer.run(main)
