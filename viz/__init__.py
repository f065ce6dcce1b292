"""Pictures of results: one function a figure, each takes results, writes a file and returns its path."""

if __name__ == "viz":
    raise ImportError("'viz' is a part of transport now: import transport.viz")


from transport.viz.cameras import seen
from transport.viz.comparisons import comparison
from transport.viz.convergence import convergence
from transport.viz.cuts import radiance_cuts
from transport.viz.irradiance import irradiance_map
from transport.viz.phase_density import phase_density
from transport.viz.phase_space import phase_portraits
from transport.viz.power_flow import power_flow
from transport.viz.profiles import profile
from transport.viz.radiance import radiance_map

__all__ = [
    "comparison",
    "convergence",
    "irradiance_map",
    "phase_density",
    "phase_portraits",
    "power_flow",
    "profile",
    "radiance_cuts",
    "radiance_map",
    "seen",
]
