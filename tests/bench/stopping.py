"""Whether intervals of runs that stop at an error cover what they claim, and how well such runs foretell their length.

python -m tests.bench.stopping [--runs 2000] [--target 0.1 ...] [--case few ...] [--sampling random]
"""

import math
import time
from dataclasses import dataclass
from itertools import product

import numpy as np
import typer

import transport as tp
from transport.theory.view_factors import coaxial_disks

RADIANCE = 100.0


@dataclass(frozen=True)
class Disks:
    """Light from a disk of radius 0.5 m to one of another, above its middle; aimed where weights shall differ."""

    radius: float
    distance: float
    aimed: bool

    @property
    def scene(self) -> tp.Scene:
        meter = tp.Disk(center=(0, 0, self.distance), normal=(0, 0, -1), radius=self.radius)
        lamp = tp.Source(
            tp.Disk(radius=0.5), tp.Lambertian(radiance=RADIANCE), aim=meter if self.aimed else None
        )
        return tp.Scene(lamp, detectors=tp.Detector(meter, "meter"))

    @property
    def exact(self) -> float:
        """Flux [W]."""
        return math.pi**2 * 0.25 * RADIANCE * coaxial_disks(0.5, self.radius, self.distance)


CASES = {
    "few": Disks(0.5, 2.0, aimed=False),  # one history in 18 scores
    "most": Disks(2.0, 0.5, aimed=False),  # nearly all
    "rare": Disks(0.02, 2.0, aimed=False),  # one in 10 000
    "unlike": Disks(0.02, 0.02, aimed=True),  # all score, a few hundred times as much as most
}


@dataclass(frozen=True)
class Stopped:
    """What a run for an error came to; seconds of CPU."""

    covers: bool
    ratio: float  # of its relative error to the one asked for
    particles: int
    foretold: float  # particles, nan where nothing was


def stopped(case: Disks, target: float, seed: int, **options) -> Stopped:
    """One run for an error."""
    result = tp.simulate(
        case.scene,
        error={"meter.flux_in": target},
        seed=seed,
        threads=1,
        progress=False,
        estimator="analog",
        **options,
    )
    flux, forecast = result["meter"].flux_in, result.cost.forecast
    low, high = flux.interval(0.95)
    foretold = math.nan if forecast is None else forecast.particles
    return Stopped(low <= case.exact <= high, flux.relative_error / target, result.cost.particles, foretold)


def row(name: str, target: float, runs: int, sampling: str) -> str:
    """Coverage of 95 % intervals, errors over the one asked for, particles, and those foretold over them."""
    begun = time.process_time()
    found = [stopped(CASES[name], target, seed, sampling=sampling) for seed in range(runs)]
    covered = np.mean([each.covers for each in found])
    ratios, particles, foretold = (
        np.array([getattr(each, part) for each in found]) for part in ("ratio", "particles", "foretold")
    )
    text = f"{name:7s} {target:<7g} {runs:5d} runs: {100 * covered:.1f} ± {100 * math.sqrt(0.0475 / runs):.1f} % covered"
    text += f", error {ratios.mean():.3f} (at most {ratios.max():.3f}) of that asked for"
    text += f", {particles.mean():.3g} particles ± {100 * particles.std() / particles.mean():.0f} %"
    if np.isfinite(foretold).any():
        off = np.abs(foretold / particles - 1)[np.isfinite(foretold)]
        text += f", foretold within 15 % in {100 * np.mean(off < 0.15):.0f} %, 30 % in {100 * np.mean(off < 0.3):.0f} % of {len(off)}"
    return f"{text}, {(time.process_time() - begun) / runs:.3f} s of CPU each"


def main(
    case: list[str] = typer.Option(list(CASES)),  # noqa: B008
    target: list[float] = typer.Option([1e-1, 1e-2]),  # noqa: B008
    runs: int = 2000,
    sampling: str = "random",
) -> None:
    """Print a row per case and target."""
    for name, error in product(case, target):
        print(row(name, error, runs, sampling), flush=True)


if __name__ == "__main__":
    typer.run(main)
