"""The distance of a wall: how bright it looks to the eye, and why radiance stays while irradiance falls with the square.

Derivation.  "Does the brightness that a wall appears to the eye depend on the distance of the viewer to the wall?  No!"
(Hanrahan 2001, Stanford CS 348B, lecture 4, quiz 2).  A sensor responds to the rays that reach it, R = ∬ L cosθ dω dA
= L T, where T is the throughput between its aperture and its cell, and knows nothing of the wall (the same lecture,
"2nd law").  The eye's aperture is the pupil, its cell a part of the retina:

    R = L T,   T = ∬ cosθ cosθ'/r² dA dA' = π A F between pupil and cell (Howell, C-41, for coaxial disks),

as long as every ray from the cell through the pupil ends on the wall.  Further away the wall is too small for that.  With
a bare pupil R is L times the throughput of cell, pupil and wall (theory/etendue.py).  With a lens in the pupil that
looks sharply at the wall, R = L T until the wall's image is smaller than the cell.  Then all that enters the pupil falls
on the cell, R = L T' with T' between wall and pupil: a star, too, is dimmer from further away (theory/etendue.py).

The square panel.  "If you double your distance from the light, the number of photons through a unit surface area goes
down by a factor of four.  However, the radiance is the same.  The solid angle has dropped to about one quarter"
(Akenine-Möller, Haines, Hoffman 2008, 7.1).  On the axis of a panel of side a, E = L ∫cosθ dω and Ω = ∫dω are closed
forms (Lambert 1760; Van Oosterom and Strackee 1983), whose ratios are a quarter, but for (a/2d)² and 3/4 (a/2d)² of it
(theory/emitters.py): within 1 % from five sides away.

Scenes.  "pupil" and "lens": a round wall shines at the pupil; behind it lies the retina, a middle cell and rings, which
count what came through the pupil (`via`).  The eye has its pupil 17 mm before the retina, as the reduced eye has
(Listing 1853); its cells are coarse, so that they count in a second what a cone of 2 µm would in days.  The ideal lens
maps sines, which conserves throughput; that the image of the wall covers a cell, or lies within it, is settled by tracing
the rays of its rim with 2 % to spare.  "panel": it glows on both sides, and a meter looks at one from d, another at the
other from 2d, so that the ratios are of one run.

Aimed sources send out only the rays that are wanted here; that is what the warnings of their counters tell.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import constant, curves_figure, figures, main, one_of, where
from transport.theory import emitters, view_factors
from transport.theory.etendue import DEPTH, Eye
from transport.verification.experiment import Outcome

law = "R = L T at any distance; doubling it: E/4, Ω/4, L (Hanrahan 2001, quiz 2; Akenine-Möller, Haines, Hoffman 2008, 7.1)"
question = "Does the brightness that a wall appears to the eye depend on the distance of the viewer?"
particles = 8_000_000
intended = {
    "bins": "pixels at the rim of the picture get little light; the rows are of rings",
    "aim": "only rays from the wall to the squares at which it is aimed are wanted",
}

SHOWS = ("pupil", "lens", "panel")
RINGS = (0, 1, 2, 4, 8)  # edges of the retina's cells, over the middle one's radius
PIXELS = 41  # a side, of the picture on the retina
METER = 0.01  # of the panel's side, that of the meters

BRIGHTNESS, AT_PUPIL = "R / L T, {}", "irradiance at the pupil"
IRRADIANCE, SOLID_ANGLE, RADIANCE = "irradiance E at {}", "solid angle Ω at {}", "radiance L at {}"
RATIOS = "E(2d) / E(d)", "Ω(2d) / Ω(d)", "L(2d) / L(d)"
NEAR, FAR = "d", "2d"


def cases() -> list[dict[str, object]]:
    eyes = [{"show": show, "distance": d} for show in ("pupil", "lens") for d in (0.5, 1.0, 2.0, 4.0, 8.0)]
    return [*eyes, *({"show": "panel", "distance": d} for d in (0.15, 0.6, 3.0, 12.0))]


def cells_of(eye: Eye) -> dict[str, tuple[float, float]]:
    """Inner and outer radius [m] of each cell of the retina by its name."""
    edges = [eye.cell * ring for ring in RINGS]
    millimetres = [f"{1e3 * edge:.3g}" for edge in edges]
    names = ["middle cell", *(f"ring {a} to {b} mm" for a, b in pairwise(millimetres[1:]))]
    return dict(zip(names, pairwise(edges), strict=True))


def scene(
    show: str = "pupil",
    distance: float = 1.0,
    radiance: float = 100.0,
    size: float = 0.6,
    pupil: float = 0.001,
    cell: float = 0.001,
) -> tp.Scene:
    """An eye before a wall, with a bare "pupil" or a "lens" in it, or two meters on either side of a square "panel".

    distance: from the wall to the pupil, from the panel to the nearer meter;  size: the wall's diameter, the panel's
    side;  pupil, cell: radii of the pupil and of the retina's middle cell [m].
    """
    one_of("wall_distance", show=(show, SHOWS))
    shine = tp.Lambertian(radiance=radiance)
    if show == "panel":
        return _panel(distance, size, shine)
    return _eye(Eye(size / 2, distance, pupil, cell, show == "lens"), shine)


def _eye(eye: Eye, shine: tp.Lambertian) -> tp.Scene:
    towards = {"normal": (0, 0, -1)}
    pupil = tp.Disk(center=(0, 0, eye.distance), radius=eye.pupil, **towards)
    back, reach = (0, 0, eye.distance + DEPTH), eye.cell * RINGS[-1]
    retina = tp.Disk(center=back, radius=reach, **towards)
    picture = tp.Rectangle(center=back, width=2 * reach, height=2 * reach, **towards)
    rings, pixels = tp.Positions(u=[eye.cell * ring for ring in RINGS]), tp.Positions(u=PIXELS, v=PIXELS)
    lens = tp.Surface(pupil, tp.ThinLens(focal_length=eye.focal_length), name="pupil") if eye.has_lens else ()
    detectors = [
        tp.Detector("pupil" if eye.has_lens else pupil, name="pupil"),
        tp.Detector(retina, "retina", positions=rings, via="pupil"),
        tp.Detector(picture, "picture", positions=pixels, via="pupil"),
    ]
    return tp.Scene(tp.Source(tp.Disk(radius=eye.wall), shine, aim=pupil), surfaces=lens, detectors=detectors)


def _panel(distance: float, size: float, shine: tp.Lambertian) -> tp.Scene:
    panel, meter = tp.Rectangle(width=size, height=size), METER * size
    sources, detectors = [], []
    for name, side, away in ((NEAR, "front", distance), (FAR, "back", -2 * distance)):
        looking = (0, 0, -math.copysign(1, away))
        square = tp.Rectangle(center=(0, 0, away), normal=looking, width=meter, height=meter)
        cone = tp.Directions.cone(looking, math.atan((size - meter) / 2 / abs(away)))  # within the panel
        sources.append(tp.Source(panel, shine, aim=square, side=side))
        detectors.append(tp.Detector(square, name, directions=cone))
    return tp.Scene(sources, detectors=detectors)


def eye_of(scene: tp.Scene) -> Eye:
    """The eye of a scene of this experiment."""
    wall, retina = scene.sources[0].shape, scene.detectors[1]
    pupil = scene.sources[0].aim
    cell = retina.positions.u[1]
    return Eye(wall.radius, pupil.center[2], pupil.radius, cell, len(scene.surfaces) > 0)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    if NEAR in result:
        return _read_panel(result)
    eye, radiance = eye_of(result.scene), result.scene.sources[0].emission.radiance
    rows = {AT_PUPIL: result["pupil"].irradiance}
    for k, (name, (inner, outer)) in enumerate(cells_of(eye).items()):
        if eye.brightness(inner, outer) is not None:
            unit = radiance * eye.throughput(inner, outer) / (math.pi * (outer**2 - inner**2))
            rows[BRIGHTNESS.format(name)] = result["retina"].irradiance[k] / constant(result, unit, "W m^-2")
    return rows


def _read_panel(result: tp.Result) -> dict[str, tp.Estimate]:
    radiance = constant(result, result.scene.sources[0].emission.radiance, "W m^-2 sr^-1")
    rows = {}
    for name in (NEAR, FAR):
        rows[IRRADIANCE.format(name)] = result[name].irradiance
        rows[SOLID_ANGLE.format(name)] = result[name].fluence_rate / radiance
        rows[RADIANCE.format(name)] = result[name].radiance[0]
    values = list(rows.values())
    return rows | {ratio: values[3 + k] / values[k] for k, ratio in enumerate(RATIOS)}


def exact(**parameters: object) -> dict[str, float]:
    of = scene(**parameters)
    radiance, shape = of.sources[0].emission.radiance, of.sources[0].shape
    if isinstance(shape, tp.Rectangle):
        return _exact_panel(of.detectors[0].shape.center[2], radiance, shape.width)
    eye = eye_of(of)
    arriving = float(emitters.mean_disk_irradiance(radiance, eye.wall, eye.pupil, eye.distance))
    cells = {BRIGHTNESS.format(name): eye.brightness(*radii) for name, radii in cells_of(eye).items()}
    return {AT_PUPIL: arriving} | {name: value for name, value in cells.items() if value is not None}


def _exact_panel(distance: float, radiance: float, size: float) -> dict[str, float]:
    rows, meter = {}, METER * size
    for name, away in ((NEAR, distance), (FAR, 2 * distance)):
        factor = view_factors.opposed_rectangles((meter, meter), (size, size), away)
        rows[IRRADIANCE.format(name)] = float(math.pi * radiance * factor)
        rows[SOLID_ANGLE.format(name)] = emitters.mean_rectangle_solid_angle(size, size, away, meter)
        rows[RADIANCE.format(name)] = radiance
    values = list(rows.values())
    return rows | {ratio: values[3 + k] / values[k] for k, ratio in enumerate(RATIOS)}


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for words, of_kind in _kinds(outcomes).items():
        if filled := [o for o in of_kind if any(row.exact == 1 for row in o.rows)]:
            off = max(abs(row.z) for o in filled for row in o.rows if row.exact == 1)
            said.append(
                f"With a {words} the wall is as bright {_span(filled)}, R = L T to {off:.1f} standard errors{_fall(filled)}."
            )
    for outcome in sorted(where(show="panel")(outcomes), key=_sides)[-1:]:
        e, omega, radiance = (outcome[name].estimate for name in RATIOS)
        said.append(
            f"From {2 * _sides(outcome):.3g} sides instead of {_sides(outcome):.3g} a panel gives 1/{1 / e.value:.4g} of E,"
            f" 1/{1 / omega.value:.4g} of Ω, {radiance} of L."
        )
    return " ".join(said) or "The wall is too small, or too far away, to fill the view of a cell."


def _kinds(outcomes: list[Outcome]) -> dict[str, list[Outcome]]:
    """Those of an eye, by what is in its pupil."""
    kinds = {"bare pupil": where(show="pupil")(outcomes), "lens": where(show="lens")(outcomes)}
    return {words: found for words, found in kinds.items() if found}


def _away(outcome: Outcome) -> float:
    """Distance of the wall [m]."""
    return outcome.given["distance"]


def _span(outcomes: list[Outcome]) -> str:
    places = [_away(o) for o in outcomes]
    first, last = min(places), max(places)
    return f"at {first:g} m" if first == last else f"from {first:g} m to {last:g} m"


def _fall(outcomes: list[Outcome]) -> str:
    values = [o[AT_PUPIL].estimate.value for o in outcomes]
    fall = max(values) / min(values)
    return f", while the irradiance at the pupil falls {fall:.3g}-fold" if fall > 1 else ""


def _sides(outcome: Outcome) -> float:
    """Distance of the nearer meter from the panel [sides]."""
    return _away(outcome) / outcome.given["size"]


@curves_figure(
    title="A wall is as bright from further away",
    xlabel="distance of the wall  [m]",
    ylabel="reading",
    log_x=True,
    log_y=True,
)
def draw_brightness(outcomes: list[Outcome]) -> dict[str, object]:
    """R / L T of the middle cell, which stays, and the irradiance at the pupil, which does not."""
    name, series, marks, kinds = BRIGHTNESS.format("middle cell"), {}, {}, _kinds(outcomes)
    d = _beyond([_away(o) for o in outcomes])
    for words, found in kinds.items():
        eye = eye_of(found[0].result.scene)
        marks[f"{words}: too small"] = eye.furthest
        middle = [replace(eye, distance=x).brightness(0.0, eye.cell) for x in d]
        if known := [o for o in found if name in o]:
            series[f"brightness R/(L T), {words}"] = _fields(known, name, 1.0, (d, np.array(middle, float)))
    arriving = emitters.mean_disk_irradiance(1 / math.pi, eye.wall, eye.pupil, d)
    unit = math.pi * found[0].given["radiance"]
    series["irradiance at the pupil / π L"] = _fields(found, AT_PUPIL, unit, (d, arriving))
    return {"series": series, "marks": marks}


def _fields(outcomes: list[Outcome], name: str, unit: float, curve: tuple[np.ndarray, np.ndarray]) -> tuple:
    """A row of several outcomes by the distance, over a unit of its own."""
    estimates = [o[name].estimate / constant(o.result, unit, str(o[name].estimate.unit)) for o in outcomes]
    return [_away(o) for o in outcomes], estimates, curve, [o[name].exact / unit for o in outcomes]


def draw_retina(outcomes: list[Outcome], path: Path, note: str) -> None:
    """What each pixel of the retina reads, R/T, in one scale of grey, a row a kind of pupil, a column a distance."""
    from matplotlib.patches import Circle

    from transport.viz.style import ORANGE, figure, with_unit

    kinds, places = _kinds(outcomes), list(dict.fromkeys(map(_away, outcomes)))
    cell, of = 1e3 * outcomes[0].given["cell"], outcomes[0].given  # mm
    style = {"cmap": "gray", "vmin": 0, "vmax": 1.1 * of["radiance"], "origin": "lower"}
    title, size = "The wall's image shrinks, and fades only where it is too small", (len(places), len(kinds))
    with figure((2.4 + 3.5 * size[0], 1.9 + 3.6 * size[1]), title, note, path) as page:
        grid = page.subplots(len(kinds), len(places), squeeze=False, sharex=True, sharey=True)
        for line, (words, found) in zip(grid, kinds.items(), strict=True):
            seen = {_away(o): _picture(o.result) for o in found}
            for axes, place in zip(line, places, strict=True):
                if place not in seen:
                    axes.set_axis_off()
                    continue
                extent = cell * RINGS[-1] * np.array([-1, 1, -1, 1])
                shown = axes.imshow(np.transpose(seen[place]), extent=extent, **style)
                axes.add_patch(Circle((0, 0), cell, fill=False, color=ORANGE, lw=2))
                axes.grid(False)
            line[0].set_ylabel(f"{words}\n[mm]")
        for axes, place in zip(grid[0], places, strict=True):
            axes.set_title(f"{place:g} m")
        for axes in grid[-1]:
            axes.set_xlabel("[mm]")
        bar = page.colorbar(shown, ax=grid, shrink=0.85, pad=0.015)
        bar.set_label(with_unit("R/T", "W m^-2 sr^-1"))


def _picture(result: tp.Result) -> np.ndarray:
    """Irradiance over the pupil's projected solid angle seen from the middle of each pixel."""
    eye = eye_of(result.scene)
    x = eye.cell * RINGS[-1] * (2 * np.arange(PIXELS) + 1 - PIXELS) / PIXELS
    seen = emitters.disk_irradiance(1.0, eye.pupil, DEPTH, np.hypot.outer(x, x))
    return result["picture"].irradiance.value / seen


@curves_figure(
    title="Twice as far from a square panel: a quarter of E and of Ω, the same L",
    xlabel="distance d  [sides of the panel]",
    ylabel="at 2d over at d",
    levels={"1/4": 0.25},
    marks={"five sides": 5.0},
    log_x=True,
)
def draw_panel(outcomes: list[Outcome]) -> dict[str, object]:
    """Ratios at twice the distance, from near to far."""
    d = _beyond([_sides(o) for o in outcomes])
    words = "irradiance, E(2d)/E(d)", "solid angle, Ω(2d)/Ω(d)", "radiance, L(2d)/L(d)"
    curves = emitters.doubled_irradiance(1.0, d), emitters.doubled_solid_angle(1.0, d), np.ones_like(d)
    rows = zip(words, RATIOS, curves, strict=True)
    return {
        "series": {label: _ratios(outcomes, name, (d, curve), lambda x: x) for label, name, curve in rows}
    }


@curves_figure(
    title="How far away must one be for a quarter?",
    xlabel="distance d  [sides of the panel]",
    ylabel="more than a quarter, by a share of",
    marks={"five sides": 5.0},
    log_x=True,
    log_y=True,
)
def draw_excess(outcomes: list[Outcome]) -> dict[str, object]:
    """How much more than a quarter, beside what it tends to far away."""
    d = _beyond([_sides(o) for o in outcomes])
    words = "irradiance, 4 E(2d)/E(d) − 1", "solid angle, 4 Ω(2d)/Ω(d) − 1"
    curves = 4 * emitters.doubled_irradiance(1.0, d) - 1, 4 * emitters.doubled_solid_angle(1.0, d) - 1
    rows, share = zip(words, RATIOS[:2], curves, strict=True), lambda x: 4.0 * x - 1.0
    far = (
        {"far away: (a/2d)²": (d, emitters.far_irradiance_excess(1.0, d))},
        {"far away: 3/4 (a/2d)²": (d, emitters.far_solid_angle_excess(1.0, d))},
    )
    series = {label: _ratios(outcomes, name, (d, curve), share) for label, name, curve in rows}
    return {
        "series": {
            label: (*fields, None, guides)
            for (label, fields), guides in zip(series.items(), far, strict=True)
        }
    }


def _ratios(outcomes: list[Outcome], name: str, curve: tuple, shown: Callable) -> tuple:
    """A ratio by the distance.  curve: exact, along d;  shown: what is drawn of a ratio."""
    rows = [outcome[name] for outcome in outcomes]
    places, expected = [_sides(o) for o in outcomes], [shown(row.exact) for row in rows]
    return places, [shown(row.estimate) for row in rows], curve, expected


def _beyond(places: list[float]) -> np.ndarray:
    """Places of a curve that goes on to both sides of these."""
    return np.geomspace(min(places) / 1.5, 1.5 * max(places), 97)


EYES = where(show=("pupil", "lens"))
draw = figures(
    brightness=(draw_brightness, EYES),
    retina=(draw_retina, EYES),
    panel=(draw_panel, where(show="panel")),
    excess=(draw_excess, where(show="panel")),
)


if __name__ == "__main__":
    main(__file__)
