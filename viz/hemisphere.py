"""A hemisphere of directions as a round map: the radius is the polar angle, the azimuth runs from e_u to e_v."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Normalize
from matplotlib.patches import Circle, Patch
from matplotlib.ticker import MaxNLocator

from viz.directions import DirectionBins
from viz.style import INK, PALE, outlined

FINEST = math.radians(1.5)  # longer arcs are drawn as several cells, so that they look round
LABELLED = math.radians(67.5)  # azimuth at which the rings carry their angle
HATCH = {"facecolor": PALE, "hatch": "////", "edgecolor": "#8a8a8a"}


def draw_map(axes: Axes, bins: DirectionBins, field: np.ndarray, norm: Normalize, colours: str) -> QuadMesh:
    """Colour the bins by a field (n, m); where it is masked or nan they are hatched grey."""
    times = max(1, math.ceil(np.diff(bins.phi).max() / FINEST))
    phi = np.interp(np.arange((len(bins.phi) - 1) * times + 1) / times, np.arange(len(bins.phi)), bins.phi)
    radius = np.degrees(bins.theta)[:, None]
    x, y = radius * np.cos(phi), radius * np.sin(phi)
    field = np.repeat(np.ma.masked_invalid(field), times, axis=1)
    if np.ma.getmaskarray(field).any():
        unknown = np.ma.masked_where(~np.ma.getmaskarray(field), np.zeros(field.shape))
        axes.pcolor(x, y, unknown, cmap=_one_colour(PALE), hatch="////", edgecolor="#8a8a8a", linewidth=0)
    mesh = axes.pcolormesh(x, y, field, norm=norm, cmap=colours, rasterized=True)
    _furnish(axes, radius.max())
    return mesh


def mark_azimuth(axes: Axes, bins: DirectionBins, column: int, colour: str) -> None:
    """A line along the middle of the bins of one azimuth, with a coloured arrow head at the rim."""
    rim = math.degrees(bins.theta.max())
    phi = bins.phi[column : column + 2].mean()
    direction = np.array([math.cos(phi), math.sin(phi)])
    axes.plot(*zip((0, 0), rim * direction, strict=True), color="white", lw=1.6, ls=(0, (4, 3)), path_effects=outlined(2.6))
    axes.plot(*(1.04 * rim * direction), marker=(3, 0, math.degrees(phi) + 90), ms=13, color=colour, clip_on=False)


def explain_hatching(axes: Axes, words: str) -> None:
    """A key for the hatched bins, in the free corner below the map."""
    axes.legend(handles=[Patch(label=words, linewidth=0, **HATCH)], loc="lower left", bbox_to_anchor=(-0.06, -0.08))


def _furnish(axes: Axes, rim: float) -> None:
    """Rings of polar angle, spokes of azimuth, and their labels."""
    axes.set_aspect("equal")
    axes.set_axis_off()
    reach = 1.2 * rim
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach))
    for angle in _rings(rim):
        on_rim = math.isclose(angle, rim)
        axes.add_patch(Circle((0, 0), angle, fill=False, ec="white", lw=0 if on_rim else 0.9, alpha=0.7))
        _label_ring(axes, angle, on_rim)
    axes.add_patch(Circle((0, 0), rim, fill=False, ec=INK, lw=1.6))
    for azimuth in range(0, 360, 45):
        phi = math.radians(azimuth)
        axes.plot([0, rim * math.cos(phi)], [0, rim * math.sin(phi)], color="white", lw=0.6, alpha=0.45)
    for azimuth, across, up in ((0, "left", "center"), (90, "center", "bottom"), (180, "right", "center"), (270, "center", "top")):
        phi = math.radians(azimuth)
        words = f"φ = {azimuth}°" if azimuth == 90 else f"{azimuth}°"
        axes.text(1.09 * rim * math.cos(phi), 1.09 * rim * math.sin(phi), words, ha=across, va=up)


def _label_ring(axes: Axes, angle: float, on_rim: bool) -> None:
    at = (angle * math.cos(LABELLED), angle * math.sin(LABELLED))
    if on_rim:
        axes.text(1.03 * at[0], 1.03 * at[1], f"θ = {angle:g}°", ha="left", va="bottom", fontsize=15)
    else:
        axes.text(*at, f"{angle:g}°", ha="center", va="center", fontsize=15, color="white", path_effects=outlined())


def _rings(rim: float) -> list[float]:
    """Polar angles of the rings [deg]: 30, 60, 90 for the hemisphere, round numbers for a narrower cone."""
    if math.isclose(rim, 90):
        return [30.0, 60.0, rim]
    return [angle for angle in MaxNLocator(3, steps=[1, 2, 3, 5, 10]).tick_values(0, rim) if 0 < angle <= rim]


def _one_colour(colour: str) -> object:
    from matplotlib.colors import ListedColormap

    return ListedColormap([colour])
