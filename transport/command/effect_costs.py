"""What each effect of a scene costs: its passes together, in nanoseconds a history, and what leaving it out would save.

Measured on the program of random analog histories; rays that are cast towards detectors are not among it.
"""

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

from transport.command.pass_costs import lanes_a_history, pass_costs
from transport.command.treatment import Treatment
from transport.scene import Scene

# The files of passes by the effects that they serve; what no scene can do without ends in a full stop.
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
    "asking what histories went through": ("histories",),
    "snapshots": ("snapshots",),
    "tracks for a picture": ("tracks",),
    "point detectors": ("casting", "shadows", "detours"),
    "rays to detectors": ("expecting", "expected_rays", "told"),
    "histories run backwards": ("sensors",),
}


@dataclass(frozen=True)
class EffectCost:
    """One effect of a scene.  ns: a history;  share: of all passes;  can_go: whether a scene can do without it."""

    name: str
    ns: float
    share: float
    can_go: bool
    passes: tuple[str, ...]


def effect_costs(scene: Scene | Treatment) -> list[EffectCost]:
    """The effects of the scene with what they cost, measured now, the dearest first."""
    return grouped(pass_costs(scene), lanes_a_history(scene), files_of_passes())


def grouped(
    costs: Mapping[str, float], lanes: Mapping[str, float], files: Mapping[str, str]
) -> list[EffectCost]:
    """costs: [ns a lane];  lanes: a history;  files: in which each pass is.  A pass that no lane reached costs nothing."""
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
    """The name of a pass without that of the sampling for which it was made."""
    return name.partition(" by ")[0]


def files_of_passes() -> dict[str, str]:
    """The engine's file of each pass, by the pass's name."""
    from transport.engine.families import HOMES

    return HOMES
