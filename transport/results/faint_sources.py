"""Diagnostic "faint source".

Sources with so small a share of the power that hardly any history is born on them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from transport.results.findings import MIN_SCORES

if TYPE_CHECKING:
    from transport.compile.plan import Plan


def faint_sources(plan: Plan, particles: int) -> list[str]:
    """A warning for each source with fewer than MIN_SCORES expected histories; births are drawn by power."""
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
                f"{title} has {share:.2g} of the total power and so about {particles * share:.2g} of"
                f" {particles} histories: light that only it provides is not resolved; simulate it in a"
                " separate scene and add the results"
            )
    return found
