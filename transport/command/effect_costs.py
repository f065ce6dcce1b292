"""Cost of each effect of a scene: sum over its passes [ns per history], and share of the total.

Measured on the program of random analog histories; shadow rays to detectors are not included.
"""

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

from transport.command.pass_costs import lanes_a_history, pass_costs
from transport.command.treatment import Treatment
from transport.scene import Scene

# Files of passes by effect; the name of an effect that every scene needs ends in a full stop.
EFFECTS = {
    "births.": ("births", "aims"),
    "flight and shapes.": ("flights", "landings", "lanes", "flats", "quadrics", "rims", "meshes"),
    "counting.": ("meters", "sizes", "birthplaces"),
    "finer bins": ("refinements",),
    "surfaces": ("surfaces", "optics"),
    "roulette": ("roulette",),
    "media": ("collisions", "bodies", "grids", "densities"),
    "forced collisions and splitting": ("forcing", "importances", "bank"),
    "volume detectors": ("volumes", "volume_cells"),
    "the clock": ("clocks",),
    "speeds": ("speeds",),
    "history filters (via, events)": ("histories",),
    "snapshots": ("snapshots",),
    "tracks": ("tracks",),
    "point detectors": ("casting", "shadows", "detours"),
    "next-event estimation": ("expecting", "expected_rays", "told"),
    "backward histories": ("sensors",),
}


@dataclass(frozen=True)
class EffectCost:
    """Cost of one effect: ns per history, share of all passes, and whether a scene can do without it."""

    name: str
    ns: float
    share: float
    can_go: bool
    passes: tuple[str, ...]


def effect_costs(scene: Scene | Treatment) -> list[EffectCost]:
    """Measure the cost of each effect of the scene; return them sorted, most expensive first."""
    return grouped(pass_costs(scene), lanes_a_history(scene), files_of_passes())


def grouped(
    costs: Mapping[str, float], lanes: Mapping[str, float], files: Mapping[str, str]
) -> list[EffectCost]:
    """Sum the costs of passes by effect.

    `costs` are in ns per lane, `lanes` the lanes per history, `files` the file of each pass.  A pass that no
    lane reached costs nothing.
    """
    ns, passes = defaultdict(float), defaultdict(list)
    effects = {file: name for name, members in EFFECTS.items() for file in members}
    for name, cost in costs.items():
        effect = effects.get(files.get(plain_name(name), ""), "other")
        ns[effect] += 0.0 if math.isnan(cost) else cost * lanes.get(name, 0.0)
        passes[effect].append(name)
    total = math.fsum(ns.values())
    told = [
        EffectCost(
            effect.rstrip("."),
            spent,
            spent / total if total else 0.0,
            not effect.endswith("."),
            tuple(passes[effect]),
        )
        for effect, spent in ns.items()
    ]
    return sorted(told, key=lambda effect: -effect.ns)


def plain_name(name: str) -> str:
    """Return the name of a pass without the name of its sampling."""
    return name.partition(" by ")[0]


def files_of_passes() -> dict[str, str]:
    """Return the engine's file of each pass, by the name of the pass."""
    from transport.engine.families import HOMES

    return HOMES
