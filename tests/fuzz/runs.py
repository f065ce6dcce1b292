"""Runs whose numbers are compared, and which of these have error bars to be compared by."""

from __future__ import annotations

import transport as tp
from tests.fuzz.properties import OF_ONE_RUN
from tests.fuzz.worlds import World
from transport.results.result import Result

PARTICLES = 20_000  # of a run
ENOUGH = 1000  # counts, below which scores are not normal that far out
Scores = dict[str, float]


def run_of(world: World | tp.Scene, seed: int, more: float, **how) -> Result:
    """A run of so many times the usual histories, of which all holds that must hold of any."""
    scene = world.scene() if isinstance(world, World) else world
    result = tp.simulate(
        scene, particles=int(more * PARTICLES), seed=seed, batches=32, threads=1, progress=False, **how
    )
    for holds in OF_ONE_RUN:
        holds(result)
    return result


def sound(result: Result, name: str) -> tp.Estimate | None:
    """The quantity, where there is one number with an error that nothing speaks against."""
    detector = name.partition(".")[0]
    try:
        estimate = result.quantity(name)
    except tp.SceneError:
        return None
    if not isinstance(estimate, tp.Estimate) or not 0 < estimate.relative_error < 0.1:
        return None
    is_told = any(detector in told for told in result.warnings)
    return estimate if result.quality(name).is_sound and not is_told else None
