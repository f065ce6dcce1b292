"""Pictures of results: one function a figure, each takes results, writes a file and returns its path."""

from viz.comparisons import comparison
from viz.cuts import radiance_cuts
from viz.phase_space import phase_portraits
from viz.prisms import Starts, prisms
from viz.profiles import profile
from viz.radiance import radiance_map
from viz.resolution import Resolved, resolutions
from viz.tradeoff import Curve, Tradeoff, tradeoff

__all__ = [
    "Curve",
    "Resolved",
    "Starts",
    "Tradeoff",
    "comparison",
    "phase_portraits",
    "prisms",
    "profile",
    "radiance_cuts",
    "radiance_map",
    "resolutions",
    "tradeoff",
]
