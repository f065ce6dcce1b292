"""Penumbra: the shadows of an edge and of a cylinder under a lamp that is no point.

Derivation.  A lamp of radius R, a diffuse disk of radiance L, shines on a screen parallel to it.  A point of the screen
sees of the lamp what is not hidden, and E = L P, P the projected solid angle of that part.  Of an edge or a cylinder that
is longer than all sight lines, what is hidden is a strip of the lamp: behind the edge all of X < −x s/(1 − s), where s
is the edge's share of the way; behind the cylinder what lies between the two planes through the point that touch it.
Nothing of the lamp is seen in the umbra, all of it in full light, a part in the penumbra between, which is 2 R (1 − s)/s
wide behind an edge.  A cylinder too thin or too far from the screen has no umbra: behind it the lamp shows on both sides,
like the sun round the moon in an annular eclipse.

A segment of a disk has a P in closed form, by the contour integral of Lambert (1760) and Sparrow (1963), and the means
over bins are Gauss-Legendre sums of it to 1e-12 (theory/shadows.py).  Under a small angle E is the share of the lamp's
area that is seen (theory/shadows.py); here it is up to 1 % less, as cosines fall aside.

An element must be so small that what falls on it is constant, says the lesson whose cylinder throws this shadow
(Scratchapixel, lesson on radiometry): one that takes in umbra, penumbra and light reads a mean that holds nowhere in it.

Scene.  Rays are aimed at the screen; the bins are strips along the shadow, with borders of umbra and penumbra among
their edges, so that the umbra's must stay empty and the light's must read the whole lamp.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import constant, figures, main, one_of, require
from transport.statistics.quadrature import legendre_nodes
from transport.theory import shadows
from transport.verification.experiment import Outcome

law = "E = L ∫ cosθ cosθ'/r² dA over what is seen of the lamp; penumbra 2R(1 − s)/s wide (Lambert 1760; Sparrow 1963)"
question = "How dark is it where only a part of the lamp is seen, and is there a place where none is?"
particles = 12_000_000

OCCLUDERS = ("edge", "cylinder")
BEYOND = 0.25  # of the whole shadow's width, full light (and umbra) that the meter shows on either side
LIGHT, UMBRA, ANTUMBRA, PENUMBRA = "full light", "umbra", "antumbra", "penumbra"
FINE = {LIGHT: 4, UMBRA: 6, ANTUMBRA: 6, PENUMBRA: 20}  # bins of a zone
ELEMENTS = {LIGHT: 1, UMBRA: 1, ANTUMBRA: 1, PENUMBRA: 4}  # of the table, of as many bins each
WHOLE = "one element across it all"
MM = 1e3  # of a metre
SHADES = {UMBRA: "#c4c4c4", ANTUMBRA: "#dedede", PENUMBRA: "#ececec"}  # of the figure


@dataclass(frozen=True)
class Shadow:
    """What throws it, and where.  The lamp is about the origin, the screen at z = distance, the shadow along y."""

    occluder: str
    radius: float  # m, of the lamp
    gap: float  # m, from the lamp to the edge or to the cylinder's axis
    distance: float  # m
    thickness: float = 0.0  # m, the cylinder's radius

    @cached_property
    def strip(self) -> shadows.Strip:
        if self.occluder == "edge":
            return shadows.behind_edge(self.gap, self.distance)
        return shadows.behind_cylinder(self.thickness, self.gap, self.distance)

    @cached_property
    def borders(self) -> np.ndarray:
        if self.occluder == "edge":
            return shadows.edge_borders(self.radius, self.gap, self.distance)
        return shadows.cylinder_borders(self.radius, self.thickness, self.gap, self.distance)

    @cached_property
    def zones(self) -> list[tuple[str, float, float]]:
        """Name and borders [m] of each, from left to right."""
        first, last = self.borders[[0, -1]]
        beyond = BEYOND * (last - first)
        ends = np.array([first - beyond, *self.borders, last + beyond])
        if self.occluder == "edge":
            names = [UMBRA, PENUMBRA, LIGHT]
        else:
            reaches = shadows.has_umbra(self.radius, self.thickness, self.gap, self.distance)
            names = [LIGHT, PENUMBRA, UMBRA if reaches else ANTUMBRA, PENUMBRA, LIGHT]
        return [(name, *pair) for name, *pair in zip(names, ends[:-1], ends[1:], strict=True)]

    @cached_property
    def edges(self) -> np.ndarray:
        """Edges of the bins [m]."""
        pieces = [np.linspace(low, high, FINE[name] + 1)[:-1] for name, low, high in self.zones]
        return np.append(np.concatenate(pieces), self.zones[-1][2])

    @cached_property
    def elements(self) -> dict[str, slice]:
        """The rows of the table: bins that each takes the mean of, all of one width."""
        found, at = {}, 0
        for name, _, _ in self.zones:
            bins = FINE[name] // ELEMENTS[name]
            for _ in range(ELEMENTS[name]):
                low, high = 1e3 * self.edges[[at, at + bins]]
                found[f"{name}, x {low:.4g} to {high:.4g} mm"] = slice(at, at + bins)
                at += bins
        return found

    @property
    def along(self) -> tuple[float, float]:
        """The screen's part along the shadow [m]."""
        return -self.radius, self.radius

    def means(self, edges: np.ndarray) -> np.ndarray:
        """Exact means of E / L over bins [sr]."""
        return shadows.mean_lit_projected_solid_angles(
            self.strip, self.borders, edges, self.along, self.radius, self.distance
        )

    def scene(self, radiance: float) -> tp.Scene:
        left, right = self.edges[[0, -1]]
        low, high = self.along
        place = ((left + right) / 2, 0, self.distance)
        meter = tp.Rectangle(center=place, width=right - left, height=high - low)
        reach = 1.5 * max(self.radius, -left, right)  # further than any sight line
        if self.occluder == "edge":
            shape = tp.Rectangle(center=(-reach / 2, 0, self.gap), width=reach, height=2 * reach)
        else:
            shape = tp.Cylinder(
                center=(0, 0, self.gap), axis=(0, 1, 0), radius=self.thickness, height=2 * reach
            )
        bins = tp.Positions(u=self.edges - place[0])
        return tp.Scene(
            sources=tp.Source(tp.Disk(radius=self.radius), tp.Lambertian(radiance=radiance), aim=meter),
            surfaces=tp.Surface(shape, tp.Black(), name=self.occluder),
            detectors=tp.Detector(meter, "meter", side="back", positions=bins),
        )


def cases() -> list[dict[str, object]]:
    thick, thin = {"gap": 0.7, "thickness": 0.03}, {"gap": 0.5, "thickness": 0.02}
    return [{"occluder": "edge"}, {"occluder": "cylinder"} | thick, {"occluder": "cylinder"} | thin]


def scene(
    occluder: str = "edge",
    radius: float = 0.05,
    gap: float = 0.5,
    distance: float = 1.0,
    thickness: float = 0.02,
    radiance: float = 100.0,
) -> tp.Scene:
    """A lamp, an edge or a cylinder before it, and a screen.

    radius: of the lamp [m];  gap, distance: from the lamp to what throws the shadow and to the screen [m];  thickness:
    the cylinder's radius [m].
    """
    one_of("penumbra", occluder=(occluder, OCCLUDERS))
    require("penumbra", gap=(gap, 0 < gap < distance, f"between 0 and the distance {distance} m"))
    thickness, free = 0.0 if occluder == "edge" else thickness, min(gap, distance - gap)
    must = f"between 0 and {free} m, so that the cylinder touches neither lamp nor screen"
    require("penumbra", thickness=(thickness, occluder == "edge" or 0 < thickness < free, must))
    return Shadow(occluder, radius, gap, distance, thickness).scene(radiance)


def shadow_of(scene: tp.Scene) -> Shadow:
    """What a scene of this experiment shows."""
    lamp, meter, shape = scene.sources[0].shape, scene.detectors[0].shape, scene.surfaces[0].shape
    thickness = getattr(shape, "radius", 0.0)
    return Shadow(scene.surfaces[0].name, lamp.radius, shape.center[2], meter.center[2], thickness)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    meter, of = result["meter"], shadow_of(result.scene)
    rows = {name: meter.irradiance[bins].mean() for name, bins in of.elements.items()}
    return rows | {WHOLE: meter.flux_in / constant(result, meter.detector.shape.area, "m^2")}


def exact(**parameters: object) -> dict[str, float]:
    made = scene(**parameters)
    of, radiance = shadow_of(made), made.sources[0].emission.radiance
    means, widths = radiance * of.means(of.edges), np.diff(of.edges)
    rows = {name: float(means[bins].mean()) for name, bins in of.elements.items()}
    return rows | {WHOLE: float(means @ widths / widths.sum())}


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in outcomes:
        of, light = shadow_of(outcome.result.scene), _row(outcome, LIGHT).estimate
        width = 1e3 * np.diff(of.borders)[0]
        middle = _row(outcome, UMBRA) or _row(outcome, ANTUMBRA)
        depth = "nothing" if middle.exact == 0 else f"{(middle.estimate / light).value:.1%} of full light"
        zone = "the umbra" if middle.exact == 0 else "its middle, without an umbra,"
        share = (outcome[WHOLE].estimate / light).value
        said.append(
            f"Behind the {of.occluder} {zone} receives {depth}, and the penumbra is {width:.3g} mm wide; one element"
            f" across it all reads {share:.1%}."
        )
    return " ".join(said)


def _row(outcome: Outcome, zone: str):
    """The first row of that zone; None where the shadow has none."""
    return next((row for row in outcome.rows if row.name.startswith(f"{zone},")), None)


def draw_shadows(outcomes: list[Outcome], path: Path, note: str) -> None:
    """For each shadow a section, the irradiance across it, and how far each bin is off."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import figure

    with figure((3 + 7.2 * len(outcomes), 14), "Umbra, penumbra, full light", note, path) as page:
        ratios = {"height_ratios": (1.5, 1.7, 0.8)}
        grid = page.subplots(3, len(outcomes), squeeze=False, sharex="col", sharey="row", **ratios)
        for (top, *panels), outcome in zip(grid.T, outcomes, strict=True):
            of, radiance = shadow_of(outcome.result.scene), outcome.given["radiance"]
            fine = np.linspace(*of.edges[[0, -1]], 1201)
            curve = MM * fine, radiance * seen_along(of, fine)
            means = radiance * of.means(of.edges)
            series = Series(MM * of.edges, outcome.result["meter"].irradiance, curve, means)
            plot_curves(
                series, ax=tuple(panels), xlabel="x  [mm]", ylabel="irradiance E", legend="lower right"
            )
            if top is not grid[0, 0]:
                panels[0].get_legend().remove()
                panels[0].set_ylabel(panels[1].set_ylabel("").get_text())
            _draw_zones(panels[0], of)
            _draw_section(top, of)
            top.set_title(_title(of))
            top.set_xlim(MM * of.edges[[0, -1]])
        grid[0, 0].set_ylabel("from the lamp, z  [m]")
        page.align_ylabels(grid[:, 0])


def _title(of: Shadow) -> str:
    what = f"cylinder of {2 * MM * of.thickness:.3g} mm" if of.occluder == "cylinder" else "edge"
    return f"{what}, at {of.gap:.3g} m of {of.distance:.3g} m"


def seen_along(of: Shadow, x: np.ndarray) -> np.ndarray:
    """E / L at x, the mean along the shadow [sr]."""
    nodes, weight = legendre_nodes(shadows.ALONG)
    seen = shadows.lit_projected_solid_angle(
        of.strip, x[:, None], of.along[1] * nodes, of.radius, of.distance
    )
    return seen @ weight / 2


def seen_share(of: Shadow, x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Share of the lamp's area that is seen from x at the heights z, (z, x); by lines from 128 of its strips."""
    end = of.radius * np.cos(np.pi * (np.arange(128) + 0.5) / 128)
    weight = of.radius**2 - end**2  # width times length of a strip
    z = z[:, None, None]
    tall = np.maximum(np.hypot(x[:, None] - end, z), np.finfo(float).tiny)
    along = np.clip(((x[:, None] - end) * -end + z * of.gap) / tall**2, 0.0, 1.0)
    aside = end + along * (x[:, None] - end)
    if of.occluder == "edge":
        hidden = (z > of.gap) & (end + (x[:, None] - end) * (of.gap / np.maximum(z, of.gap)) < 0)
    else:
        hidden = np.hypot(aside, along * z - of.gap) < of.thickness
    return (~hidden) @ weight / weight.sum()


def _draw_zones(axes, of: Shadow) -> None:
    from transport.viz.style import MUTED

    axes.set_ylim(-0.04 * axes.get_ylim()[1], 1.15 * axes.get_ylim()[1])
    for name, low, high in of.zones:
        if name in SHADES:
            axes.axvspan(MM * low, MM * high, color=SHADES[name], lw=0, zorder=0)
        style = {"ha": "center", "va": "top", "fontsize": 15, "color": MUTED}
        place = MM * (low + high) / 2, 0.985, name.replace(" ", "\n")
        axes.text(*place, transform=axes.get_xaxis_transform(), **style)


def _draw_section(axes, of: Shadow) -> None:
    """The lamp above, the screen below; shaded by the share of the lamp that is seen, with rays to the zones' borders."""
    from transport.viz.style import INK, ORANGE

    left, right = of.edges[[0, -1]]
    x, z = np.linspace(left, right, 300), np.linspace(0, of.distance, 160)
    grey = {"cmap": "gray", "vmin": -0.22, "vmax": 1, "shading": "nearest", "rasterized": True}
    axes.pcolormesh(MM * x, z, seen_share(of, x, z), **grey)
    axes.plot(MM * of.radius * np.array([-1, 1]), [0, 0], color=ORANGE, lw=9, solid_capstyle="butt")
    axes.text(0, 0.045 * of.distance, "lamp", color=INK, ha="center", va="top", fontsize=16)
    if of.occluder == "edge":
        axes.plot([MM * left, 0], [of.gap] * 2, color=INK, lw=6, solid_capstyle="butt")
    else:
        turn = np.linspace(0, 2 * np.pi, 200)
        axes.fill(MM * of.thickness * np.cos(turn), of.gap + of.thickness * np.sin(turn), color=INK, zorder=3)
    ends = np.array([-1.0, 1.0]) * of.radius
    for border in of.borders:  # to the rim of the lamp that is seen just there, past the obstacle
        across = border + (ends - border) * (1 - of.gap / of.distance)
        slant = np.hypot(1, (ends - border) / of.distance)
        end = ends[np.argmin(np.abs(np.abs(across) / slant - of.thickness))]
        axes.plot([MM * border, MM * end], [of.distance, 0], color=ORANGE, lw=1.6, zorder=2)
    axes.plot(MM * np.array([left, right]), [of.distance] * 2, color=INK, lw=5)
    axes.set_ylim(1.02 * of.distance, -0.04 * of.distance)
    axes.grid(False)


draw = figures(shadows=draw_shadows)


if __name__ == "__main__":
    main(__file__)
