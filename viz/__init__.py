"""Pictures of results: one function a figure, each takes results, writes a file and returns its path."""

from viz.cameras import seen
from viz.comparisons import comparison
from viz.convergence import convergence
from viz.cuts import radiance_cuts
from viz.irradiance import irradiance_map
from viz.phase_density import phase_density
from viz.phase_space import phase_portraits
from viz.power_flow import power_flow
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
    "convergence",
    "irradiance_map",
    "phase_density",
    "phase_portraits",
    "power_flow",
    "prisms",
    "profile",
    "radiance_cuts",
    "radiance_map",
    "resolutions",
    "seen",
    "tradeoff",
]
