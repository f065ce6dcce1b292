"""A hemisphere of directions as a round plan: the radius is polar angle, azimuth runs from e_u towards e_v.

A plan is seen from in front of the surface, against its normal, as is the map of the same surface by place:
what shines from the side of +u is on the right in both.  An eye in the surface would see it mirrored, as in
a map of the sky.
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Normalize
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from transport.viz.directions import DirectionBins
from transport.viz.style import HATCHING, INK, MUTED, PALE, outlined
from transport.viz.uncertainty import hatch_key

FINEST = math.radians(1.5)  # longer arcs are drawn as several cells, so that they look round
LABELLED = math.radians(56)  # azimuth at which the rings carry their angle, between the spokes
COMPASS = ((0, "left", "center"), (90, "center", "bottom"), (180, "right", "center"), (270, "center", "top"))


def draw_map(axes: Axes, bins: DirectionBins, field: np.ndarray, norm: Normalize, colours: str) -> QuadMesh:
    """Colour the bins by a field (n, m); where it is nan they are hatched grey."""
    field, x, y = on_plan(bins, field)
    known = np.isfinite(field)
    if not known.all():
        # One hatched face below all bins: hatching each of them takes seconds.
        edge = [np.concatenate([side[-1], side[0, ::-1]]) for side in (x, y)]
        axes.fill(*edge, facecolor=PALE, hatch=HATCHING, edgecolor=MUTED, linewidth=0)
    mesh = axes.pcolormesh(x, y, np.ma.masked_where(~known, field), norm=norm, cmap=colours, rasterized=True)
    _furnish(axes, np.degrees(bins.theta).max(), spokes=not bins.is_round)
    return mesh


def on_plan(bins: DirectionBins, field: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A field (n, m) with its arcs cut so fine that they look round, and the corners of its bins."""
    times = max(1, math.ceil(np.diff(bins.phi).max() / FINEST))
    phi = np.interp(np.arange((len(bins.phi) - 1) * times + 1) / times, np.arange(len(bins.phi)), bins.phi)
    radius = np.degrees(bins.theta)[:, None]
    return np.repeat(field, times, axis=1), radius * np.cos(phi), radius * np.sin(phi)


def mark_azimuth(axes: Axes, bins: DirectionBins, column: int, colour: str) -> None:
    """A line along the middle of the bins of one azimuth, with a coloured arrow head at the rim."""
    rim, phi = math.degrees(bins.theta.max()), bins.phi[column : column + 2].mean()
    x, y = rim * math.cos(phi), rim * math.sin(phi)
    axes.plot([0, x], [0, y], color="white", lw=1.6, ls=(0, (4, 3)), path_effects=outlined(2.6))
    axes.plot(1.04 * x, 1.04 * y, marker=(3, 0, math.degrees(phi) + 90), ms=15, color=colour, clip_on=False)


def explain_hatching(axes: Axes, words: str) -> None:
    """A key for the hatched bins, in the free corner below the map."""
    axes.legend(
        handles=[hatch_key(words)], loc="lower left", bbox_to_anchor=(-0.06, -0.02), handletextpad=0.5
    )


def _furnish(axes: Axes, rim: float, spokes: bool) -> None:
    """Rings of polar angle, spokes of azimuth, and their labels."""
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set(xlim=(-1.2 * rim, 1.2 * rim), ylim=(-1.2 * rim, 1.2 * rim))
    if spokes:
        for azimuth in range(0, 360, 45):
            phi = math.radians(azimuth)
            axes.plot([0, rim * math.cos(phi)], [0, rim * math.sin(phi)], color="white", lw=0.7, alpha=0.45)
        for azimuth, across, up in COMPASS:
            x, y = 1.1 * rim * math.cos(math.radians(azimuth)), 1.1 * rim * math.sin(math.radians(azimuth))
            axes.text(x, y, f"φ = {azimuth}°" if azimuth == 90 else f"{azimuth}°", ha=across, va=up)
    for angle in _rings(rim):
        axes.add_patch(Circle((0, 0), angle, fill=False, ec="white", lw=1.0, alpha=0.7))
        x, y = angle * math.cos(LABELLED), angle * math.sin(LABELLED)
        axes.text(x, y, f"{angle:g}°", ha="center", va="center", color="white", path_effects=outlined())
    axes.add_patch(Circle((0, 0), rim, fill=False, ec=INK, lw=1.8))
    x, y = 1.03 * rim * math.cos(LABELLED), 1.03 * rim * math.sin(LABELLED)
    axes.text(x, y, f"θ = {rim:.3g}°", ha="left", va="bottom")
    if spokes:
        axes.text(-1.2 * rim, y, "seen from\nin front", color=MUTED, fontsize=15, ha="left", va="bottom")


def _rings(rim: float) -> list[float]:
    """Polar angles of the rings inside the rim [deg]: 30 and 60, or round numbers for a narrower cone."""
    if math.isclose(rim, 90):
        return [30.0, 60.0]
    angles = MaxNLocator(3, steps=[1, 2, 3, 5, 10]).tick_values(0, rim)
    return [angle for angle in angles if 0 < angle < 0.9 * rim]
