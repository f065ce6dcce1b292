"""Light under a lens: rays in cross-section, radiance by direction in front and behind, irradiance by the cone of light."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Wedge
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from transport import Estimate, EstimateArray, Sphere
from transport.geometry.shape import Shape
from transport.viz.cuts import draw_exact, draw_points
from transport.viz.directions import direction_bins
from transport.viz.style import (
    BLUE,
    GREEN,
    HATCHING,
    INK,
    MARKERS,
    MUTED,
    ORANGE,
    POINTS,
    PURPLE,
    SKY,
    VERMILLION,
    figure_at,
)

CM = 100.0  # of a metre
IN_FRONT, BEHIND = ORANGE, BLUE
ANGLES = (0.1, 0.3, 1, 3, 10, 30, 90)  # deg, of ticks


class Glass(NamedTuple):
    """A lens above a detector at the origin, which looks up at it; cross-sections are (n, 2) of x and z [m].

    outlines: of what is solid;  paths: of rays;  front, behind: half angles of the cones of light
    [rad];  radiance: behind, by theta, over that in front;  exact: the same as a function of theta [rad];  guides: label
    -> what else to compare with.
    """

    outlines: Sequence[np.ndarray]
    paths: Sequence[np.ndarray]
    front: float
    behind: float
    radiance: EstimateArray
    exact: Callable[[np.ndarray], np.ndarray]
    guides: Mapping[str, Callable[[np.ndarray], np.ndarray]]


class Spot(NamedTuple):
    """A focus: half angles [rad] and irradiances over π L [1] in front and behind."""

    label: str
    front: float
    behind: float
    before: Estimate
    after: Estimate


def under_glasses(
    glasses: Mapping[str, Glass],
    path: str | os.PathLike,
    title: str = "Under a magnifying glass: light from more directions, of no more radiance",
    note: str | None = None,
) -> str | os.PathLike:
    """Draw each glass with its rays, and below it radiance behind over that in front by direction; returns the path.

    Raises ValueError for no glasses.
    """
    if not glasses:
        raise ValueError("under_glasses: at least one glass is needed, got none")
    with figure_at(path, (1.6 + 6.4 * len(glasses), 14.4), title, note) as figure:
        upper, lower = figure.subplots(2, len(glasses), squeeze=False, sharey="row", height_ratios=(1.5, 1))
        reach = max(glass.radiance.coords["theta"][-1] for glass in glasses.values())
        highest = max(outline[:, 1].max() for glass in glasses.values() for outline in glass.outlines)
        for section, chart, (label, glass) in zip(upper, lower, glasses.items(), strict=True):
            _draw_section(section, glass, CM * highest)
            section.set_title(label)
            _draw_radiance(chart, glass, np.degrees(reach))
        upper[0].set_ylabel("height  [cm]")
        lower[0].set_ylabel("radiance / that in front")
        handles = {
            name: line
            for chart in lower
            for line, name in zip(*chart.get_legend_handles_labels(), strict=True)
        }
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=2)
    return path


def irradiance_by_cone(
    spots: Sequence[Spot],
    path: str | os.PathLike,
    title: str = "In the focus: E = π L sin²θ', and never more than π L",
    note: str | None = None,
) -> str | os.PathLike:
    """Draw irradiance over π L by the half angle of the cone of light, an arrow from front to focus each; returns the path."""
    with figure_at(path, (14, 9.6), title, note) as figure:
        axes = figure.subplots()
        first = 0.6 * np.degrees(min(spot.front for spot in spots))
        fine = np.geomspace(first, 90, 2001)
        axes.plot(fine, np.sin(np.radians(fine)) ** 2, color=INK, lw=2.2, label="sin²θ")
        steep = fine[fine < 75]
        words = "tan²θ', of a lens that maps tangents"
        axes.plot(steep, np.tan(np.radians(steep)) ** 2, "--", color=PURPLE, lw=2.6, label=words, zorder=1.5)
        top = 8.0
        axes.axhspan(1, top, fc="none", ec="#b0b0b0", hatch=HATCHING, lw=0, zorder=0.5)
        axes.text(
            first * 1.1,
            2.1,
            "more than the source itself gives off, π L",
            color=MUTED,
            bbox={"fc": "white", "ec": "none"},
        )
        for place, spot in enumerate(spots):
            _draw_spot(axes, spot, place)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlim(first, 130)
        axes.set_ylim(0.4 * np.sin(np.radians(first)) ** 2, top)
        axes.xaxis.set_major_locator(FixedLocator(ANGLES))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda angle, _: f"{angle:g}"))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xlabel("half angle of the cone that light comes from  [deg]")
        axes.set_ylabel("irradiance / π L")
        axes.legend(loc="upper left", bbox_to_anchor=(0.01, 0.85))
    return path


def cross_sections(shapes: Iterable[Shape]) -> list[np.ndarray]:
    """Where disks and caps about the z axis meet the plane y = 0, each (n, 2) of x and z [m]; caps of one body as one."""
    flat, arcs = [], []
    for shape in shapes:
        x, _, z = shape.center
        if isinstance(shape, Sphere):
            half = math.acos(shape.mu_min)
            turn = math.pi / 2 * shape.axis[2] + np.linspace(half, -half, 201)
            arcs.append(np.stack([x + shape.radius * np.cos(turn), z + shape.radius * np.sin(turn)], axis=-1))
        elif shape.inner_radius > 0:
            flat += [np.array([[side * shape.inner_radius, z], [side * shape.radius, z]]) for side in (-1, 1)]
        else:
            flat.append(np.array([[-shape.radius, z], [shape.radius, z]]))
    return flat + ([np.concatenate(arcs)] if arcs else [])


def _draw_section(axes: Axes, glass: Glass, highest: float) -> None:
    """Rays to the middle of the focus, and both cones of directions as wedges."""
    for line in glass.paths:
        axes.plot(*(CM * line).T, color=VERMILLION, lw=1.3, zorder=2)
    for outline in glass.outlines:
        if len(outline) > 2:
            axes.fill(*(CM * outline).T, fc=SKY, ec=INK, lw=1.8, alpha=0.45, zorder=3)
        else:
            axes.plot(*(CM * outline).T, color=INK, lw=3.5, zorder=3)
    top = CM * max(outline[:, 1].max() for outline in glass.outlines)
    _wedge(axes, top + 0.4, 6.0, glass.front, IN_FRONT)
    _name_angle(axes, (2.2, top + 4.4), "θ$_s$", glass.front, IN_FRONT)
    _wedge(axes, 0.0, 3.0, glass.behind, BEHIND)
    _name_angle(axes, (2.2, 0.6), "θ'", glass.behind, BEHIND)
    axes.set_aspect("equal")
    axes.set_xlim(-8, 8)
    axes.set_ylim(-0.8, highest + 7.2)
    axes.set_xlabel("x  [cm]")


def _wedge(axes: Axes, foot: float, length: float, half_angle: float, colour: str) -> None:
    degrees = np.degrees(half_angle)
    axes.add_patch(
        Wedge((0, foot), length, 90 - degrees, 90 + degrees, fc=colour, ec=colour, alpha=0.5, zorder=1)
    )


def _name_angle(axes: Axes, place: tuple[float, float], name: str, half_angle: float, colour: str) -> None:
    words = f"{name} = {np.degrees(half_angle):.3g}°"
    box = {"fc": "white", "ec": "none", "pad": 1.5, "alpha": 0.85}
    axes.text(*place, words, color=colour, va="center", fontweight="bold", bbox=box, zorder=5)


def _draw_radiance(axes: Axes, glass: Glass, reach: float) -> None:
    bins = direction_bins(glass.radiance)
    axes.fill_between([0, np.degrees(glass.front)], 1, color=IN_FRONT, alpha=0.35, lw=0, label="in front")
    draw_exact(axes, bins, 0, lambda theta, phi: glass.exact(theta), INK, steps=False)
    axes.plot([], [], color=INK, lw=2, label="behind, exact")
    draw_points(axes, bins, 0, BEHIND, "o", "behind, simulated")
    fine = np.linspace(0, glass.behind, 501)
    for label, guide in glass.guides.items():
        axes.plot(np.degrees(fine), guide(fine), "--", color=PURPLE, lw=2.6, label=label)
    axes.set_xlim(0, reach)
    axes.set_ylim(0, 1.65)
    axes.set_xlabel("polar angle θ  [deg]")


def _draw_spot(axes: Axes, spot: Spot, place: int) -> None:
    """Both places and the arrow between, with the gain on it."""
    colour, marker = (BLUE, VERMILLION, GREEN, ORANGE, SKY, INK)[place % 6], MARKERS[place % len(MARKERS)]
    x, y = np.degrees([spot.front, spot.behind]), [spot.before.value, spot.after.value]
    arrow = {
        "arrowstyle": "-|>",
        "color": colour,
        "lw": 1.8,
        "shrinkA": 6,
        "shrinkB": 8,
        "mutation_scale": 20,
    }
    arrow["connectionstyle"] = f"arc3,rad={0.12 + 0.07 * place}"
    axes.annotate("", (x[1], y[1]), (x[0], y[0]), arrowprops=arrow, zorder=2)
    bars = [2 * spot.before.error, 2 * spot.after.error]
    gain = f"{spot.label}: {y[1] / y[0]:.5g}-fold"
    axes.errorbar(x, y, bars, fmt=marker, color=colour, label=gain, zorder=4, **POINTS)
