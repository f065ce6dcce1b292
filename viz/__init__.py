"""Pictures of results.

Every function takes results, returns the figure, and writes a file only where a path is given.  `plot_curves` and `plot_map`
draw any series and any map, in a figure of their own or in the axes that they are given as `ax=`; `figure` makes pages of several
panels.  `transport.viz.scene.draw_scene` draws a scene in space (it needs PyVista).
"""

if __name__ == "viz":
    raise ImportError("'viz' is a part of transport now: import transport.viz")


from transport.viz.comparisons import comparison
from transport.viz.convergence import convergence
from transport.viz.curves import Series, plot_curves
from transport.viz.directions import polar_curves
from transport.viz.maps import plot_map, plot_maps
from transport.viz.phase_space import phase_portraits
from transport.viz.power_flow import power_flow
from transport.viz.style import figure

__all__ = [
    "Series",
    "comparison",
    "convergence",
    "figure",
    "phase_portraits",
    "plot_curves",
    "plot_map",
    "plot_maps",
    "polar_curves",
    "power_flow",
]
