"""View factors: what share of the light that leaves one surface diffusely reaches another, also past an
obstacle.

Derivation.  Of the rays that leave dA₁ those within dω = cosθ₂ dA₂/r² reach dA₂.  A diffuse surface sends
cosθ₁ dω/π of its light into dω, so that of all that leaves A₁ the share

    F₁₂ = (1/A₁) ∬ V cosθ₁ cosθ₂ / (π r²) dA₁ dA₂

reaches A₂, with V = 1 where the two see one another and 0 where something opaque is in between (Goral et al.
1984, "form factor"; Howell's catalogue, "configuration factor").  A₁ F₁₂ = A₂ F₂₁; π A₁ F₁₂ is the throughput
between the two.

Exact values.  Disks (Howell, C-41), rectangles (C-11, C-14), ball and disk (C-136), tubes and cones by the
disks that close them; two balls by an integral over one of them; coaxial tubes (Hamilton and Morgan 1952);
without ends, where mirrors close the gap at both ends, by crossed strings (Hottel 1954).  With a disk or
rectangle in the way, or a hole in a screen, the rays are counted where they cross its plane
(transport/theory/occlusion.py).

Scene.  All is black, so that a factor is what arrives over what was emitted.  Each pair has one ratio of
lengths, from 1e-3 to 1e3, and is counted as tp.view_factor does it: from the smaller area, aimed where the
other is far away.  The cases are a choice; `--set pair=... --set ratio=... --set size=...` gives any other.

Worth.  For one smooth factor that nothing blocks, this is not the way: the closed forms below, or quadrature,
give ten digits in milliseconds, where counting needs a hundred times the particles for one digit more.
Counting pays where there are obstacles, many surfaces or meshes, and where a number without an error bar is
of no use.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

import transport as tp
from transport.analysis.view_factors import view_factor_from_run, view_factor_scene
from transport.sims import (
    curves_figure,
    figures,
    furthest,
    grouped,
    main,
    of_scene,
    one_of,
    others,
    provenance,
    rows_figure,
    sentence,
    where,
)
from transport.theory import occlusion
from transport.theory import round_view_factors as of_round
from transport.theory import view_factors as of_flat
from transport.verification.experiment import Outcome

law = (
    "F₁₂ = (1/A₁) ∬ V cosθ₁ cosθ₂/πr² dA₁ dA₂ (Howell, A Catalog of Radiation Heat Transfer Configuration"
    " Factors; Hottel 1954; Hamilton, Morgan 1952)"
)
question = "What share of the light that leaves one surface reaches another, also past an obstacle?"
particles = 1_000_000

FACTOR = "F₁₂"
RATIOS = (1e-3, 0.1, 10.0, 1e3)  # of the pairs that are drawn as curves
LEFT_OUT = (
    ("tube, end to wall", 1e3),
    ("tube, wall to wall", 1e-3),
)  # all but 1e-6, and 5e-4: too few to count
MARGIN = 0.1  # of mirrors, beyond what lies between them
UP, DOWN, SIDE = (0, 0, 1), (0, 0, -1), (0, 1, 0)

Parts = dict[str, object]  # parameters of view_factor_scene


def cases() -> list[dict[str, object]]:
    points = [(pair, ratio) for pair in CURVES for ratio in RATIOS if (pair, ratio) not in LEFT_OUT]
    unequal = [
        {"pair": "disks", "size": 1e-3},
        {"pair": "rectangles", "ratio": 0.01, "size": 1e-4},
        *({"pair": "ball and disk", "ratio": ratio} for ratio in (0.005, 1e3)),
        {"pair": "balls", "size": 0.01, "ratio": 0.01},
    ]
    others = [{"pair": pair} for pair in PAIRS if pair not in (*CURVES, "ball and disk")]
    return [*({"pair": pair, "ratio": ratio} for pair, ratio in points), *unequal, *others]


def scene(pair: str = "disks", ratio: float = 1.0, size: float = 1.0, obstacle: float = 0.5) -> tp.Scene:
    """Two surfaces, of which the first has the size 1 m, or what closes it.

    ratio: of the pair's lengths, as told in PAIRS;  size: of the second one, over the first's;  obstacle: its
    radius or side, or that of the hole, over the first's; it lies midway.
    """
    parts = _known(pair).build(ratio, size, obstacle)
    mirrors = [tp.Surface(mirror, tp.Mirror()) for mirror in parts.pop("mirrors", ())]
    made = view_factor_scene(**parts)
    if not mirrors:
        return made
    [source] = made.sources
    return tp.Scene(dataclasses.replace(source, aim=None), [*made.surfaces, *mirrors], made.detectors)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    return {FACTOR: view_factor_from_run(result)}


@of_scene(scene)
def exact(pair: str, ratio: float, size: float, obstacle: float) -> dict[str, float]:
    return {FACTOR: float(_known(pair).exact(ratio, size, obstacle))}


class Pair(NamedTuple):
    """Two surfaces.  ratio: in words;  build, exact: functions of (ratio, size, obstacle)."""

    ratio: str
    build: Callable[[float, float, float], Parts]
    exact: Callable[[float, float, float], float]


def _known(pair: str) -> Pair:
    one_of("view_factors", pair=(pair, PAIRS))
    return PAIRS[pair]


def _disks(ratio: float, size: float, _: float) -> Parts:
    return {"a": tp.Disk(radius=1.0), "b": tp.Disk(center=(0, 0, ratio), normal=DOWN, radius=size)}


def _rectangles(ratio: float, size: float, _: float) -> Parts:
    sides = {"width": 1.0, "height": size}
    return {"a": tp.Rectangle(**sides), "b": tp.Rectangle(center=(0, 0, ratio), normal=DOWN, **sides)}


def _corner(ratio: float, size: float, _: float) -> Parts:
    """Widths `size` and `ratio` away from their common edge of 1 m, which lies along y."""
    floor = tp.Rectangle(center=(size / 2, 0, 0), width=size, height=1.0)
    wall = tp.Rectangle(center=(0, 0, ratio / 2), normal=(1, 0, 0), up=SIDE, width=ratio, height=1.0)
    return {"a": floor, "b": wall}


def _end(radius: float = 1.0) -> tp.Disk:
    return tp.Disk(radius=radius)


def _tube(height: float, radius: float = 1.0) -> tp.Cylinder:
    """A tube's wall that stands on the plane z = 0."""
    return tp.Cylinder(center=(0, 0, height / 2), radius=radius, height=height)


def _tubes(ratio: float, size: float, _: float) -> tuple[tp.Cylinder, tp.Cylinder]:
    return _tube(ratio, 1 + size), _tube(ratio)


def _itself(shape: tp.Cylinder | tp.Sphere, *blockers: tp.Cylinder | tp.Sphere) -> Parts:
    """The inside of a surface, which sees itself."""
    return {"a": shape, "b": shape, "blockers": blockers, "side_a": "back", "side_b": "back"}


def _strips(ratio: float, *_: float) -> Parts:
    parts = _rectangles(ratio, 1.0, 0.0)
    return parts | {"mirrors": _mirrors((-0.5, 0.5), (0.0, ratio))}


def _wedge(ratio: float, *_: float) -> Parts:
    c, s = math.cos(ratio), math.sin(ratio)
    floor = tp.Rectangle(center=(0.5, 0, 0), width=1.0, height=1.0)
    wall = tp.Rectangle(center=(c / 2, 0, s / 2), normal=(s, 0, -c), up=SIDE, width=1.0, height=1.0)
    return {"a": floor, "b": wall, "mirrors": _mirrors((min(0.0, c), 1.0), (0.0, s))}


def _cylinders(ratio: float, *_: float) -> Parts:
    away = 1 + ratio / 2
    a, b = (tp.Cylinder(center=(x, 0, 0), axis=SIDE, radius=1.0, height=1.0) for x in (-away, away))
    return {"a": a, "b": b, "mirrors": _mirrors((-away - 1, away + 1), (-1.0, 1.0))}


def _mirrors(x: tuple[float, float], z: tuple[float, float]) -> list[tp.Rectangle]:
    """Mirrors at y = ±0.5 over these ranges of x and z: what lies between them has no ends."""
    width, height = x[1] - x[0] + MARGIN, z[1] - z[0] + MARGIN
    center = (x[0] + x[1]) / 2, (z[0] + z[1]) / 2
    return [
        tp.Rectangle(center=(center[0], y, center[1]), normal=SIDE, up=UP, width=width, height=height)
        for y in (-0.5, 0.5)
    ]


def _through_disk(ratio: float, size: float, obstacle: float) -> Parts:
    reach = 2 * max(1.0, size, obstacle)
    screen = tp.Disk(center=(0, 0, ratio / 2), radius=reach, inner_radius=obstacle)
    return _disks(ratio, size, 0.0) | {"blockers": screen}


def _midway(ratio: float, size: float, obstacle: float) -> tp.Rectangle:
    return tp.Rectangle(center=(0, 0, ratio / 2), width=obstacle, height=obstacle * size)


def _past_rectangle(ratio: float, size: float, obstacle: float) -> Parts:
    return _rectangles(ratio, size, 0.0) | {"blockers": _midway(ratio, size, obstacle)}


def _through_rectangle(ratio: float, size: float, obstacle: float) -> Parts:
    reach = 2 * max(1.0, obstacle)
    screen = dataclasses.replace(_midway(ratio, size, reach), hole=_midway(ratio, size, obstacle))
    return _rectangles(ratio, size, 0.0) | {"blockers": screen}


def _between_rectangles(function: Callable[..., float]) -> Callable[[float, float, float], float]:
    return lambda x, s, o: function((1.0, s), (1.0, s), x, (o, o * s), x / 2)


PAIRS = {
    "disks": Pair("distance / radius", _disks, lambda x, s, o: of_flat.coaxial_disks(1.0, s, x)),
    "rectangles": Pair(
        "distance / width", _rectangles, lambda x, s, o: of_flat.parallel_rectangles(1.0, s, x)
    ),
    "corner": Pair("width 2 / edge", _corner, lambda x, s, o: of_flat.perpendicular_rectangles(s, x)),
    "ball and disk": Pair(
        "disk's radius / distance",
        lambda x, s, o: {"a": tp.Sphere(center=(0, 0, 1), radius=s / 2), "b": _end(x)},
        lambda x, s, o: of_round.sphere_to_disk(x, 1.0),
    ),
    "balls": Pair(
        "gap / radius",
        lambda x, s, o: {"a": tp.Sphere(radius=1.0), "b": tp.Sphere(center=(0, 0, 1 + s + x), radius=s)},
        lambda x, s, o: of_round.spheres(1.0, s, 1 + s + x),
    ),
    "tube, end to wall": Pair(
        "height / radius",
        lambda x, s, o: {"a": _end(), "b": _tube(x), "side_b": "back"},
        lambda x, s, o: of_round.base_to_side(1.0, x),
    ),
    "tube, wall to end": Pair(
        "height / radius",
        lambda x, s, o: {"a": _tube(x), "b": _end(), "side_a": "back"},
        lambda x, s, o: of_round.side_to_base(1.0, x),
    ),
    "tube, wall to wall": Pair(
        "height / radius", lambda x, s, o: _itself(_tube(x)), lambda x, s, o: of_round.side_to_side(1.0, x)
    ),
    "cone to itself": Pair(
        "radius / height",
        lambda x, s, o: _itself(tp.Cone(radius=x, top_radius=0.0, height=1.0)),
        lambda x, s, o: of_round.cone_to_itself(x, 1.0),
    ),
    "hemisphere to itself": Pair(
        "none",
        lambda x, s, o: _itself(tp.Sphere(radius=1.0, mu_min=0.0)),
        lambda x, s, o: of_round.sphere_to_patch(0.5),
    ),
    "strips without ends": Pair("distance / width", _strips, lambda x, s, o: of_flat.infinite_strips(1.0, x)),
    "wedge without ends": Pair("angle [rad]", _wedge, lambda x, s, o: of_flat.infinite_wedge(x)),
    "cylinders without ends": Pair(
        "gap / radius", _cylinders, lambda x, s, o: of_flat.infinite_cylinders(1.0, x)
    ),
    "disks past a disk": Pair(
        "distance / radius",
        lambda x, s, o: _disks(x, s, o) | {"blockers": tp.Disk(center=(0, 0, x / 2), radius=o)},
        lambda x, s, o: occlusion.disks_past_disk(1.0, s, x, o, x / 2),
    ),
    "disks through a hole": Pair(
        "distance / radius", _through_disk, lambda x, s, o: occlusion.disks_through_hole(1.0, s, x, o, x / 2)
    ),
    "rectangles past a rectangle": Pair(
        "distance / width", _past_rectangle, _between_rectangles(occlusion.rectangles_past_rectangle)
    ),
    "rectangles through a hole": Pair(
        "distance / width", _through_rectangle, _between_rectangles(occlusion.rectangles_through_hole)
    ),
    "sphere to itself past a ball": Pair(
        "none",
        lambda x, s, o: _itself(tp.Sphere(radius=1.0), tp.Sphere(radius=o)),
        lambda x, s, o: 1 - of_round.outer_sphere_to_inner(o, 1.0),
    ),
    "outer tube to inner": Pair(
        "height / inner radius",
        lambda x, s, o: dict(zip("ab", _tubes(x, s, o), strict=True)) | {"side_a": "back"},
        lambda x, s, o: of_round.outer_cylinder_to_inner(1.0, 1 + s, x),
    ),
    "outer tube to itself": Pair(
        "height / inner radius",
        lambda x, s, o: _itself(*_tubes(x, s, o)),
        lambda x, s, o: of_round.outer_cylinder_to_itself(1.0, 1 + s, x),
    ),
}
CURVES = ("disks", "rectangles", "corner", "balls", "tube, end to wall", "tube, wall to wall")


def verdict(outcomes: list[Outcome]) -> str:
    rows = [outcome[FACTOR] for outcome in outcomes]
    if len(rows) == 1:
        return f"The view factor is {rows[0].estimate}, exact {rows[0].exact:.6g}."
    least, most = (f"{extreme(row.estimate.value for row in rows):.3g}" for extreme in (min, max))
    kinds = len(grouped(outcomes, "pair"))
    found = f"{len(rows)} view factors, pairs of {kinds} kinds, from {least} to {most}, agree"
    return sentence(found, furthest(outcomes))


@curves_figure(
    xlabel="ratio of lengths, as named beside each pair",
    ylabel="view factor F₁₂",
    title="View factors over six decades: points counted, lines exact",
    log_x=True,
    log_y=True,
)
def draw_curves(outcomes: list[Outcome]) -> dict[str, object]:
    """View factors along the ratios."""
    series, errors = {}, [o[FACTOR].estimate.relative_error for o in outcomes]
    for pair, found in grouped(outcomes, "pair").items():
        ratios, factors = [o.given["ratio"] for o in found], [o[FACTOR].estimate for o in found]
        fine = np.geomspace(min(ratios), max(ratios), 301)
        curve = fine, [PAIRS[pair].exact(x, 1.0, 0.5) for x in fine]
        series[f"{pair}: {PAIRS[pair].ratio}"] = ratios, factors, curve, [o[FACTOR].exact for o in found]
    spread = f"{np.nanmin(errors):.0e} to {np.nanmax(errors):.0e}"
    return {"series": series, "note": f"{provenance(outcomes)}; relative standard errors {spread}"}


def draw_facing(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Two equal disks to scale at two distances, and the share of the light of one that falls on the other."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.exhibits import bare_panel
    from transport.viz.style import BLUE, INK, ORANGE, figure

    ratios, factors = [o.given["ratio"] for o in outcomes], [o[FACTOR].estimate for o in outcomes]
    title = "Facing elements: all light of one falls on the other only if they touch"
    with figure((19, 8.6), title, note, path) as page:
        sketch, chart = page.subplots(1, 2, width_ratios=(1, 1.2))
        for height, outcome in zip((4.6, -1.6), outcomes[1:3], strict=True):
            ratio, percent = outcome.given["ratio"], 100 * outcome[FACTOR].estimate.value
            for angle in np.radians(np.linspace(-76, 76, 39)):
                rise = min(abs(ratio * math.tan(angle)), 3.0)  # where the drawing ends, or the other plane
                is_caught = ratio * math.tan(abs(angle)) <= 1
                end = rise / math.tan(abs(angle)) if angle else ratio
                sketch.plot(
                    [0, end], height + np.array([0, math.copysign(rise, angle)]),
                    color=ORANGE, lw=2.5, alpha=1.0 if is_caught else 0.3,
                )  # fmt: skip
            for x, colour in ((0, ORANGE), (ratio, BLUE)):
                sketch.plot([x, x], [height - 1, height + 1], color=colour, lw=7, solid_capstyle="butt")
            words = f"{ratio:g} radii apart:\n{percent:.3g} % arrives"
            sketch.text(
                1.0, height + (3.8 if ratio > 1 else 0), words, color=INK, ha="left", va="center", fontsize=22
            )
        bare_panel(sketch, (-1, 11), (-4.9, 6.0))
        plot_curves(
            Series(ratios, factors, lambda x: np.array([PAIRS["disks"].exact(each, 1.0, 0.5) for each in x])),
            ax=chart, log_x=True, span=(1e-3, 1e3), legend="lower left", guides={"wrong: all of it": lambda x: 1 + 0 * x},
            xlabel="distance / radius", ylabel="view factor F₁₂ of equal disks",
        )  # fmt: skip
        chart.set(ylim=(0, 1.1))


def _facing(outcomes: list[Outcome]) -> list[Outcome]:
    """Equal disks at all distances."""
    found = where(pair="disks")(_on_curves(outcomes))
    return found if len(found) == len(RATIOS) else []


def _on_curves(outcomes: list[Outcome]) -> list[Outcome]:
    """Those of pairs of equal sizes at several ratios."""
    plain = [o for o in where(pair=CURVES, size=1.0)(outcomes) if "obstacle" not in o.parameters]
    return [o for found in grouped(plain, "pair").values() if len(found) > 1 for o in found]


_rows = rows_figure("View factors, obstacles among them", lambda row, o: o.title.replace("pair=", ""))
draw = figures(
    curves=(draw_curves, _on_curves), facing=(draw_facing, _facing), others=(_rows, others(_on_curves))
)


if __name__ == "__main__":
    main(__file__)
