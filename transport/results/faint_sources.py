"""Sources so faint beside the others that hardly a history is born on them: what they alone light is not told."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from transport.results.findings import MIN_SCORES

if TYPE_CHECKING:
    from transport.compile.plan import Plan


def faint_sources(plan: Plan, particles: int) -> list[str]:
    """A warning for each source of which a run of so many histories has next to none; sources are drawn by their power."""
    if plan.turned is not None:
        return []
    total = math.fsum(emitter.bound for emitter in plan.emitters)
    found = []
    for number, source in enumerate(plan.scene.sources):
        share = math.fsum(emitter.bound for emitter in plan.emitters if emitter.source is source) / total
        if share < 0.5 and particles * share < MIN_SCORES:
            title = (
                f"the source on {source.shape!r}" if isinstance(source.shape, str) else f"sources[{number}]"
            )
            found.append(
                f"{title} has {share:.2g} of all power and so about {particles * share:.2g} of {particles} histories: what"
                " it alone lights is not told; run it in a scene of its own and add the results"
            )
    return found
