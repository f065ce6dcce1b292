"""Dogleg: how much gets out through a hole in a thick shield that has no straight way out?

Kobayashi's problems (Kobayashi, Sugimura and Nagaya 2000, OECD/NEA NSC/DOC(2000)4; 2001, Prog. Nucl. Energy
39, 119): a cube of 10 cm in the corner of three mirrors emits 1 particle per cm³ and second evenly, in a
shield of 0.1 per cm with a void of 1e-4 per cm: (1) a void of 50 cm about the source, within a shield of 1 m;
(2) a straight duct of 10 by 10 cm; (3) a duct with three bends.  Wanted is the fluence rate at points on
lines A, B, C; in case i nothing scatters, in case ii half of all collisions do, isotropically.  Discrete
ordinates fail here: their rays miss the ducts.

Exact values.  In case i what reaches a point is the volume integral of exp(-τ)/(4π r²) over the source, with
exact optical depths through the boxes: transport/theory/ray_integrals.py has it to 1e-9.  For case ii of
problem 1 there are published values by Monte Carlo (GMVP), each with its standard error; the rows are ratios
to them, and their errors are those of both.  For case ii of the others none are known here: the rows are told
without.

Scene.  Instead of mirrors, which no straight line to a point leads through, the whole: all eight octants,
with the source in the middle.  Of boxes in boxes, or of voxels of 10 cm: the same to rounding.  At every
birth and on every flight a PointDetector asks what would come straight from there, through duct or shield.
As a check of another kind, a VolumeDetector counts tracks in the last 10 cm before the bend, y from 50 to 60
cm: its exact value is the mean over that cell.

What comes straight falls behind the bend as exp(-τ) of the shield; with scattering the walls of each leg
shine into the next.
"""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import constant, figures, furthest, main, of_scene, one_of, require
from transport.theory.ray_integrals import Region, Space, mean_uncollided_fluence, uncollided_fluence
from transport.verification.experiment import Outcome

law = (
    "φ = ∫ Q exp(−τ)/(4π r²) dV where nothing scatters, and GMVP's values where half does "
    "(Kobayashi, Sugimura, Nagaya 2001)"
)
question = "How much gets through a shield with a hole that bends?"
particles = 1_000_000
intended = {
    "roulette survivors": "far cells of the map are faint, and are drawn as such; the rows are of points",
}

CM = 0.01  # m
SOURCE = (-10.0,) * 3, (10.0,) * 3  # cm
PER_CM2 = 1e4  # W m^-2, of a source of 1 W per cm³: the published unit
SHIELD, VOID = 0.1, 1e-4  # cm^-1
VOXEL = 10.0  # cm
CELL = (0.0, 50.0, 0.0), (10.0, 60.0, 10.0)  # cm, before the bend
CELL_ROW = "cell (0–10, 50–60, 0–10)"
MAP_CELL = 2.5  # cm
LAYERS = {1: (0,), 2: (0,), 3: (0, 3)}  # shown, each a VOXEL thick
BUILT = ("boxes", "voxels")

STEPS = [float(x) for x in range(5, 100, 10)]
LINES = {
    1: {
        "1A": [(5.0, y, 5.0) for y in STEPS],
        "1B": [(x, x, x) for x in STEPS],
        "1C": [(x, 55.0, 5.0) for x in STEPS],
    },
    2: {"2A": [(5.0, y, 5.0) for y in STEPS], "2B": [(x, 95.0, 5.0) for x in STEPS[:6]]},
    3: {
        "3A": [(5.0, y, 5.0) for y in STEPS],
        "3B": [(x, 55.0, 5.0) for x in STEPS[:6]],
        "3C": [(x, 95.0, 35.0) for x in STEPS[:6]],
    },
}
FEW = {  # of the table; all others by --set points=all
    1: ("1A (5, 5, 5)", "1A (5, 55, 5)", "1A (5, 95, 5)", "1B (95, 95, 95)", "1C (55, 55, 5)"),
    2: ("2A (5, 55, 5)", "2A (5, 95, 5)", "2B (35, 95, 5)"),
    3: ("3A (5, 95, 5)", "3B (15, 55, 5)", "3B (55, 55, 5)", "3C (5, 95, 35)", "3C (35, 95, 35)"),
}
PUBLISHED = {  # problem 1, case ii: GMVP's flux [cm^-2 s^-1], relative standard deviation
    "1A (5, 75, 5)": (0.0158766, 0.00197),
    "1A (5, 85, 5)": (0.00547036, 0.00343),
    "1A (5, 95, 5)": (0.00185082, 0.00619),
    "1B (35, 35, 35)": (0.156683, 0.00005),
    "1B (45, 45, 45)": (0.104405, 0.00011),
    "1B (55, 55, 55)": (0.0302145, 0.00061),
    "1C (15, 55, 5)": (0.12789, 0.00076),
    "1C (35, 55, 5)": (0.0959578, 0.00088),
    "1C (55, 55, 5)": (0.056703, 0.00111),
    "1C (65, 55, 5)": (0.0188631, 0.00189),
    "1C (75, 55, 5)": (0.00646624, 0.00314),
    "1C (95, 55, 5)": (0.000793924, 0.0089),
}
FEW_PUBLISHED = ("1B (35, 35, 35)", "1B (45, 45, 45)", "1C (15, 55, 5)")
OVER = " / published"


def cases() -> list[dict[str, object]]:
    absorbers = [{"problem": 1}, {"problem": 2}, {"problem": 3, "built": "voxels"}]
    return [*absorbers, {"problem": 1, "scattering": 0.5}]


def scene(problem: int = 3, scattering: float = 0.0, built: str = "boxes", points: str = "few") -> tp.Scene:
    """The source in the middle of all eight octants.

    problem: 1 (void), 2 (straight duct), 3 (dogleg);  scattering: share of collisions that scatter;  built:
    of "boxes" or of "voxels";  points: "few", or "all" that were published.
    """
    one_of("dogleg", problem=(problem, LINES), built=(built, BUILT), points=(points, ("few", "all")))
    require("dogleg", scattering=(scattering, 0 <= scattering < 1, "from 0 to below 1"))
    surfaces = _of_voxels(problem, scattering) if built == "voxels" else _of_boxes(problem, scattering)
    low, high = SOURCE
    power = PER_CM2 * math.prod(CM * (b - a) for a, b in zip(low, high, strict=True)) / CM
    detectors = [
        tp.PointDetector([CM * x for x in place], name)
        for name, place in asked(problem, scattering, points).items()
    ]
    return tp.Scene(
        tp.Source(_box(low, high), tp.Isotropic(power=power)), surfaces, [*detectors, *_volumes(problem)]
    )


def asked(problem: int, scattering: float, points: str) -> dict[str, tuple[float, float, float]]:
    """Names and places [cm] of the points."""
    found = {_name(line, place): place for line, places in LINES[problem].items() for place in places}
    few = FEW_PUBLISHED if problem == 1 and scattering > 0 else FEW[problem]
    return found if points == "all" else {name: found[name] for name in few}


def _name(line: str, place: tuple[float, float, float]) -> str:
    return f"{line} ({', '.join(f'{x:g}' for x in place)})"


def regions(problem: int) -> list[Region]:
    """Shield, void and source of all octants [cm]."""
    if problem == 1:
        void = [Region((-50.0,) * 3, (50.0,) * 3, VOID)]
        shield = Region((-100.0,) * 3, (100.0,) * 3, SHIELD)
    else:
        shield = Region((-60.0, -100.0, -60.0), (60.0, 100.0, 60.0), SHIELD)
        reach = 100.0 if problem == 2 else 60.0
        void = [Region((-10.0, -reach, -10.0), (10.0, reach, 10.0), VOID), *(_legs() if problem == 3 else ())]
    return [shield, *void, Region(*SOURCE, SHIELD)]


def _legs() -> list[Region]:
    """Behind the first bend: along x, along z, and out along y."""
    found = []
    for x, y in ((a, b) for a in (-1, 1) for b in (-1, 1)):
        found.append(_turned((10, 50, -10), (40, 60, 10), (x, y, 1)))
        for z in (-1, 1):
            found.append(_turned((30, 50, 10), (40, 60, 40), (x, y, z)))
            found.append(_turned((30, 60, 30), (40, 100, 40), (x, y, z)))
    return found


def _turned(low: tuple, high: tuple, signs: tuple[int, int, int]) -> Region:
    ends = [sorted((s * a, s * b)) for a, b, s in zip(low, high, signs, strict=True)]
    return Region(*(tuple(float(end[k]) for end in ends) for k in (0, 1)), VOID)


def _box(low: tuple, high: tuple) -> tp.Box:
    ends = CM * np.array([low, high])
    return tp.Box(center=ends.mean(axis=0), size=ends[1] - ends[0])


def _coefficients(extinction, scattering: float) -> dict[str, object]:
    """absorption and scattering [m^-1] of an extinction [cm^-1]."""
    parts = {"absorption": (1 - scattering) * extinction / CM, "scattering": scattering * extinction / CM}
    return parts if scattering else {"absorption": parts["absorption"]}


def _of_boxes(problem: int, scattering: float) -> list[tp.Surface]:
    return [
        tp.Surface(
            _box(r.low, r.high), tp.Transparent(), inside=tp.Medium(**_coefficients(r.extinction, scattering))
        )
        for r in regions(problem)
    ]


def _of_voxels(problem: int, scattering: float) -> list[tp.Surface]:
    shield, *inner = regions(problem)
    corner, far = np.array(shield.low), np.array(shield.high)
    extinction = np.full(np.round((far - corner) / VOXEL).astype(int), SHIELD)
    for region in inner:
        ends = np.round((np.array([region.low, region.high]) - corner) / VOXEL).astype(int)
        extinction[tuple(slice(a, b) for a, b in ends.T)] = region.extinction
    grid = tp.Grid(box=_box(shield.low, shield.high), **_coefficients(extinction, scattering))
    return [tp.Surface(grid.box, tp.Transparent(), inside=grid)]


def _volumes(problem: int) -> list[tp.VolumeDetector]:
    """The cell with its mirror images across x and z, and the layers that the picture shows."""
    (_, y, _), (x, far, z) = CELL
    shield, layers = regions(problem)[0], max(LAYERS[problem]) + 1
    low, high = (*shield.low[:2], -layers * VOXEL), (*shield.high[:2], layers * VOXEL)
    cells = tuple(round((b - a) / MAP_CELL) for a, b in zip(low[:2], high[:2], strict=True))
    return [
        tp.VolumeDetector(_box((-x, y, -z), (x, far, z)), "cell"),
        tp.VolumeDetector(_box(low, high), "map", cells=(*cells, 2 * layers)),
    ]


@lru_cache(maxsize=4)
def space(problem: int) -> Space:
    """The boxes of a problem, to integrate through [cm]."""
    return Space(regions(problem))


def straight(problem: int, place: tuple[float, float, float]) -> float:
    """What comes straight from the source [cm^-2 s^-1]."""
    return uncollided_fluence(place, *SOURCE, space(problem))


def problem_of(result: tp.Result) -> int:
    """Which problem a run is of: its points say so."""
    return int(result.scene.points[0].name[0])


def scattering_of(result: tp.Result) -> float:
    """Share of collisions that scatter in a run."""
    return float(np.max(result.scene.surfaces[0].inside.albedo))


def points_of(result: tp.Result) -> dict[str, tp.Estimate]:
    """Fluence rates at the points of a run, in the published unit."""
    per_cm2 = constant(result, PER_CM2, "W m^-2")
    return {d.name: result[d.name].fluence_rate / per_cm2 for d in result.scene.points}


def published(result: tp.Result, name: str) -> tp.Estimate:
    """A published value as an estimate with its own error: batches alternately above and below it."""
    flux, relative = PUBLISHED[name]
    sides = np.where(np.arange(len(result.run)) % 2 == 0, 1.0, -1.0)
    unit = tp.Estimate(sides, result.run, "1")
    return tp.Estimate(flux * (1 + relative * (sides - unit.value) / unit.error), result.run, "1")


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    scattering, fluxes = scattering_of(result), points_of(result)
    if scattering == 0:
        cell = result["cell"].fluence_rate / constant(result, PER_CM2, "W m^-2")
        return fluxes | {CELL_ROW: cell}
    if scattering == 0.5 and problem_of(result) == 1:
        both = {name + OVER: fluxes[name] / published(result, name) for name in fluxes if name in PUBLISHED}
        return both | {name: flux for name, flux in fluxes.items() if name not in PUBLISHED}
    return fluxes


@of_scene(scene)
def exact(problem: int, scattering: float, points: str) -> dict[str, float]:
    places = asked(problem, scattering, points)
    if scattering == 0:
        cell = mean_uncollided_fluence(CELL, *SOURCE, space(problem), across=4)
        return {name: straight(problem, place) for name, place in places.items()} | {CELL_ROW: cell}
    if scattering == 0.5 and problem == 1:
        return {name + OVER: 1.0 for name in places if name in PUBLISHED}
    return {}


# ---- answer and picture ----


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in outcomes:
        scattering, fluxes = outcome.given["scattering"], points_of(outcome.result)
        name, share = min(fluxes, key=lambda each: fluxes[each].value), f"{scattering:g} of it scatters"
        what = {0.0: "nothing scatters", 0.5: "half scatters"}.get(scattering, share)
        against = " from GMVP's" if scattering else ""
        off = (
            f"; {furthest([outcome])}{against}"
            if any(not math.isnan(row.exact) for row in outcome.rows)
            else ""
        )
        said.append(
            f"Problem {outcome.given['problem']}, where {what}: least at {name}, {fluxes[name]} per cm² and second{off}."
        )
    return " ".join(said)


def draw_ducts(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Maps of the fluence rate in layers with the points in them, and below how far the points are off."""
    from transport.viz.style import figure

    widths = [max(len(LAYERS[o.given["problem"]]), 1.35) for o in outcomes]
    fields = [folded(o.result["map"].fluence_rate) / PER_CM2 for o in outcomes]
    norm = _decades(np.concatenate([field[field > 0] for field in fields]))
    with figure((2.4 + 6.4 * sum(widths), 15.5), "Fluence rate in a shield with a hole", note, path) as page:
        columns = page.subfigures(1, len(outcomes), width_ratios=widths, squeeze=False)[0]
        for column, outcome, field in zip(columns, outcomes, fields, strict=True):
            above, below = column.subfigures(2, 1, height_ratios=(1.9, 1))
            share = outcome.given["scattering"]
            what = f"{share:.0%} of collisions scatter" if share else "nothing scatters"
            above.suptitle(f"Problem {outcome.given['problem']}: {what}", fontsize=21)
            shown = _draw_layers(above, outcome, field, norm)
            _draw_ratios(below.subplots(), outcome)
        bar = above.colorbar(shown, ax=above.axes, shrink=0.8, pad=0.02, extend="min")
        bar.set_label(r"fluence rate  [$\mathrm{cm^{-2}\,s^{-1}}$]")


def _decades(found: np.ndarray):
    """A scale of whole decades about all that was counted."""
    from matplotlib.colors import LogNorm

    low, high = math.log10(np.quantile(found, 0.005)), math.log10(found.max())
    return LogNorm(10.0 ** math.floor(low), 10.0 ** math.ceil(high))


def _looks(outcome: Outcome) -> dict[str, tuple[str, str]]:
    """Colour and marker of each point, the same in maps and chart."""
    from transport.viz.style import look

    names = dict.fromkeys([*_ratios(outcome), *(point.name for point in outcome.result.scene.points)])
    return {name: look(rank) for rank, name in enumerate(names)}


def _draw_layers(page, outcome: Outcome, field: np.ndarray, norm) -> object:
    from transport.viz.style import SEQUENTIAL, outlined

    problem, looks = outcome.given["problem"], _looks(outcome)
    panels = page.subplots(1, len(LAYERS[problem]), squeeze=False, sharey=True)[0]
    edges = [MAP_CELL * np.arange(n + 1) for n in field.shape[:2]]
    for axes, k in zip(panels, LAYERS[problem], strict=True):
        low, high = VOXEL * k, VOXEL * (k + 1)
        rates = np.where(field[:, :, k] > 0, field[:, :, k], np.nan)
        mesh = axes.pcolormesh(*edges, rates.T, cmap=SEQUENTIAL, norm=norm, rasterized=True)
        for region in (r for r in regions(problem)[1:] if r.low[2] <= low < r.high[2]):
            x, y = (np.clip([region.low[a], region.high[a]], 0, None) for a in (0, 1))
            if np.ptp(x) and np.ptp(y):
                style = {"ls": "-" if region.extinction == SHIELD else "--", "path_effects": outlined()}
                axes.plot(x[[0, 1, 1, 0, 0]], y[[0, 0, 1, 1, 0]], color="white", lw=1.8, **style)
        for point in outcome.result.scene.points:
            x, y, z = _place(point)
            if low < z < high:
                colour, marker = looks[point.name]
                axes.plot(x, y, marker=marker, color=colour, mec="white", mew=1.6, ms=12, zorder=5)
        axes.set(aspect="equal", xlabel="x  [cm]", facecolor="#3a3a3a")
        axes.set_title(f"z = {low:g} to {high:g} cm", fontsize=18)
        axes.grid(False)
    panels[0].set_ylabel("y  [cm]")
    return mesh


def _ratios(outcome: Outcome) -> dict[str, tuple[float, float]]:
    """What is known: estimate over exact or published value, and the error of that."""
    known = [row for row in outcome.rows if not math.isnan(row.exact)]
    return {
        row.name.removesuffix(OVER): (row.estimate.value / row.exact, row.estimate.error / row.exact)
        for row in known
    }


def _draw_ratios(axes, outcome: Outcome) -> None:
    """How many standard errors each point is off; beside it, how large one is."""
    from transport.viz.style import INK, MUTED, WITHIN_TWO

    ratios, looks, reach = _ratios(outcome), _looks(outcome), 5.0
    if not ratios:
        words = {"ha": "center", "transform": axes.transAxes, "color": MUTED}
        axes.text(0.5, 0.5, "nothing is known to compare with", **words)
        axes.axis("off")
        return
    axes.axvspan(-2, 2, color=WITHIN_TWO, lw=0)
    axes.axvline(0, color=INK, lw=1.6)
    beside = {"transform": axes.get_yaxis_transform(), "va": "center", "fontsize": 15}
    for row, (name, (ratio, error)) in enumerate(ratios.items()):
        colour, marker = looks[name]
        off = np.clip((ratio - 1) / error, -reach, reach)
        axes.plot(off, row, marker=marker, color=colour, ms=12, mec="white", mew=0.8, zorder=3)
        axes.text(1.02, row, f"{100 * error:.2g} %", **beside)
    axes.text(1.02, -0.9, "1 std. error", color=MUTED, **beside)
    axes.set_yticks(range(len(ratios)), list(ratios), fontsize=15)
    axes.set(xlim=(-1.1 * reach, 1.1 * reach), ylim=(len(ratios) - 0.4, -0.6))
    against = "GMVP, published" if outcome.given["scattering"] else "exact"
    axes.set_xlabel(f"off {against}  [std. errors]", fontsize=18)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)


def _place(point: tp.PointDetector) -> tuple[float, float, float]:
    return tuple(x / CM for x in point.position)


def folded(rates: tp.EstimateArray) -> np.ndarray:
    """Means of the mirror images in one octant, (nx/2, ny/2, nz/2), in the unit of the rates; 0 where nothing
    came.
    """
    values = rates.value
    for axis in range(3):
        low, high = np.split(values, 2, axis=axis)
        values = (np.flip(low, axis) + high) / 2
    return values


# Two problems a figure.
draw = figures(**{str(k + 1): (draw_ducts, lambda of, k=k: of[2 * k : 2 * k + 2]) for k in range(2)})


if __name__ == "__main__":
    main(__file__)
