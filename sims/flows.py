"""Flows: what starts in the oblique prism crosses its base, history by history; what flows out of a closed meter.

Derivation.  Particles of density n fly with the velocity v.  Those that cross the patch dA within dt are those that
start in the oblique prism with the base dA and the edge -v dt: a particle that starts at x = p - s v dt, p on the
patch and 0 < s <= 1, is at p after s dt.  The volume of the prism is d³x = v·dA dt = v cosθ dA dt, so that

    Q = n v cosθ dA dt,    Φ = dQ/dt = n v·dA,    dΦ/dA = n v cosθ    (Hanrahan 2001, Stanford CS 348B, lecture 4).

Particles that fly against the normal cross from the other side: a counter of one side reads n v max(cosθ, 0), the
cosine clamped at 0 (Akenine-Möller, Haines, Hoffman 2008, eq. 7.5), and that of the other side n v max(-cosθ, 0).

What leaves through a closed meter and does not come back through it has started inside, so that the flux out of it
less the flux into it is the power of the sources inside, whatever stands in the way, inside or outside, as long as it
absorbs nothing (Gauss's theorem for n v).  It holds for each history, so the error is that of the power alone.

Scene.  A black patch in a stream along +z; a sample of the particles is written down at the start and after dt.
Who is missing then has crossed; who had to is told by the places at the start.  The gas fills a box round the prism
only, so that it is as full at 89.99° as at 0°.  The closed meters are a sphere, a tetrahedron, a box and an empty
sphere that overlap, with two sources within, one outside, a white ball that two of them cut, and a mirror.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import transport as tp
from transport.sims import (
    constant,
    figures,
    in_space,
    main,
    of_scene,
    one_of,
    sentence,
    several,
    sharp,
    where,
)
from transport.statistics.notation import with_thousands_spaces
from transport.theory import effusion
from transport.theory.solid_angles import in_oblique_prism
from transport.verification.experiment import Outcome

if TYPE_CHECKING:
    from transport.viz.solid_panel import SolidPanel

law = "Q = n v cosθ dA dt, Φ = dQ/dt = n v·dA; ∮ n v·dA = power inside (Hanrahan 2001, Stanford CS 348B, lecture 4)"
question = "Which particles of a stream cross a patch within dt, and what flows out of a closed meter?"
particles = 4_000_000
intended = {
    "unknown error": "a stream crosses the patch one way, and nothing the other way",
}

WIDTH, HEIGHT = 1.0, 0.6  # m, of the patch
REACH = 1.0  # m that a particle flies within dt
MARGIN = 0.1  # of gas beyond the prism, as a share of the prism
THINNEST = 1e-4  # cosine down to which the gas gets thinner as the prism does
SAMPLE = 100_000  # particles whose places are written down
ROUNDING = 1e-15  # a cosine below is that of 90°

STARTED, CROSSED, DIFFER = "started in the prism", "crossed within dt", "histories that differ"
ALONG, AGAINST, NET = "along the normal", "against the normal", "net"
METERS = {"sphere": 1, "tetrahedron": 1, "box": 2, "empty sphere": 0}  # sources of equal power inside
CORNERS = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])  # of a tetrahedron
_triples = ((0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2))
FACES = {f"tetrahedron, face {k}": corners for k, corners in enumerate(_triples)}
SHOWN = 3  # degrees from 90° at which a prism is thick enough to be drawn
ARROW = 0.12  # m, breadth of the arrow that stands for the power of a source
OBLIQUE = (20, 75)  # degrees, tilts of the prism that is drawn in space
IN_SPACE = 1500  # particles in the picture in space
LONGEST, FEW_RUNS = (
    2000,
    12,
)  # particles of the largest sample of which errors are shown; samples that are drawn
PANELS, MOST = 3, 6000  # prisms that are drawn at most, and places in each


def cases() -> list[dict[str, object]]:
    patches = [{"tilt": angle * tp.deg, "intervals": 1} for angle in (0, 60, 89, 89.99, 90, 120, 180)]
    patches[1]["intervals"] = 4
    return [*patches, {"meter": "closed"}]


def scene(
    meter: str = "patch",
    tilt: float = 0.0,
    density: float = 1e6,
    speed: float = 500.0,
    intervals: int = 4,
    power: float = 1.0,
) -> tp.Scene:
    """A patch in a stream of `density` [m^-3], its normal at `tilt` [rad] to the stream; or closed meters.

    speed [m/s];  intervals: of dt, each as long as all before it;  power [W] of each source inside a closed meter.
    """
    one_of("flows", meter=(meter, ("patch", "closed")))
    return _stream(tilt, density, speed, edges(intervals)) if meter == "patch" else _closed(power, speed)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    return _patch_rows(result) if result.scene.duration is not None else _closed_rows(result)


@of_scene(scene)
def exact(
    meter: str, tilt: float, density: float, speed: float, intervals: int, power: float
) -> dict[str, float]:
    if meter == "closed":
        return {f"{NET}, {name}": inside * power for name, inside in METERS.items()}
    mu, area, duration = _cosine(tilt), WIDTH * HEIGHT, REACH / speed
    along, against = (float(effusion.stream_flux_density(density, speed, cosine)) for cosine in (mu, -mu))
    through = (along + against) * area
    return {
        STARTED: through * duration,
        CROSSED: through * duration,
        DIFFER: 0.0,
        ALONG: along,
        AGAINST: against,
        NET: along - against,
        **{name: through for name in interval_names(edges(intervals))},
    }


def edges(intervals: int) -> np.ndarray:
    """0 and the halves of dt, up to 1: intervals that are each as long as all before it together [dt]."""
    return np.array([0.0, *(0.5**k for k in reversed(range(intervals)))])


def interval_names(edges: np.ndarray) -> list[str]:
    return [f"ΔQ/Δt, t/dt {low:g} to {high:g}" for low, high in zip(edges, edges[1:], strict=False)]


# ---- a patch in a stream ----


def _cosine(tilt: float) -> float:
    """cos(tilt), 0 at 90° where a rounded angle leaves 6e-17."""
    mu = math.cos(tilt)
    return mu if abs(mu) > ROUNDING else 0.0


def _stream(tilt: float, density: float, speed: float, edges: np.ndarray) -> tp.Scene:
    mu, sine, duration = _cosine(tilt), math.sin(tilt), REACH / speed
    patch = tp.Surface(
        tp.Rectangle(normal=(sine, 0, mu), width=WIDTH, height=HEIGHT), tp.Black(), name="patch"
    )
    depth = WIDTH * abs(sine) + REACH  # of the prism along the stream
    size = np.array([WIDTH * max(abs(mu), THINNEST), HEIGHT, depth]) * (1 + MARGIN)
    box = tp.Box(center=(0, 0, -REACH / 2), size=size)
    times = edges * duration
    detectors = [
        tp.Detector("patch", ALONG, side="back", times=times),
        tp.Detector("patch", AGAINST, side="front", times=times),
        tp.Snapshot(time=0.0, particles=SAMPLE, name="start"),
        tp.Snapshot(time=duration, particles=SAMPLE, name="end"),
    ]
    source = tp.Source(box, tp.Gas(density, speed, direction=(0, 0, 1)))
    return tp.Scene(source, surfaces=patch, detectors=detectors, duration=duration)


def started_and_crossed(result: tp.Result) -> tuple[np.ndarray, np.ndarray]:
    """For each history of the sample: whether it started in the prism, and whether it crossed, (N,) of bool.

    Raises SceneError where the samples at the start and at the end are not of the same histories.
    """
    start, end = result["start"], result["end"]
    [source], [surface] = result.scene.sources, result.scene.surfaces
    path = np.array(source.emission.direction) * source.emission.speed * result.scene.duration
    patch = surface.shape
    started = in_oblique_prism(patch.center, patch.frame, (WIDTH, HEIGHT), path, start.positions)
    early, late = start.histories, end.histories
    if len(np.unique(early)) < len(early) or not np.isin(late, early).all():
        raise tp.SceneError(
            "flows: the two snapshots hold other histories; limit the run by particles= alone"
        )
    return started, ~np.isin(early, late)


def _patch_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    started, crossed = started_and_crossed(result)
    along, against = result[ALONG], result[AGAINST]
    edges = np.array(along.detector.times) / result.scene.duration
    shares = np.diff(edges)
    through = along.flux_in + against.flux_in
    one_way = {
        name: (reading.irradiance * shares).sum() for name, reading in ((ALONG, along), (AGAINST, against))
    }
    return {
        STARTED: _number(result, started),
        CROSSED: _number(result, crossed),
        DIFFER: constant(result, np.count_nonzero(started != crossed), "1"),
        **one_way,
        NET: one_way[ALONG] - one_way[AGAINST],
        **{name: through[i] for i, name in enumerate(interval_names(edges))},
    }


def _number(result: tp.Result, chosen: np.ndarray) -> tp.Estimate:
    """The particles that the chosen histories of the sample at the start stand for."""
    start = result["start"]
    sets = start.batches[chosen], start.batches
    found, taken = (np.bincount(batches, minlength=len(result.run)) for batches in sets)
    return tp.Estimate(found / taken, result.run, "1") * result.ledger["emitted"]


# ---- closed meters ----


def _closed(power: float, speed: float) -> tp.Scene:
    """Overlapping closed meters; two of the three sources lie in the box, one in the sphere and the tetrahedron."""
    place = np.array([0.3, 0, 0])
    disk = tp.Disk(center=(-0.5, 0.2, 0.1), normal=(1, 2, -2), radius=0.2)
    sources = [
        tp.Source(tp.Point(position=place), tp.Isotropic(power=power, speed=speed)),
        tp.Source(disk, tp.Lambertian(power=power, speed=speed)),
        tp.Source(tp.Box(center=(3, 1, 0.5), size=0.5), tp.Isotropic(power=2 * power, speed=speed)),
    ]
    ball = tp.Surface(tp.Sphere(center=(0.4, -0.5, 0.2), radius=0.25), tp.Diffuse(1.0), name="white ball")
    mirror = tp.Surface(tp.Disk(center=(0, 0, -2), radius=3), tp.Mirror(), name="mirror")
    meters = {
        "sphere": tp.Sphere(center=place, radius=0.5),
        "box": tp.Box(size=(2, 2, 1.5)),
        "empty sphere": tp.Sphere(center=(-0.3, 0.3, 0.9), radius=0.4),
        **{name: tp.Triangle(vertices=place + 0.6 * CORNERS[[*face]]) for name, face in FACES.items()},
    }
    detectors = [tp.Detector(shape, name) for name, shape in meters.items()]
    return tp.Scene(sources, surfaces=[ball, mirror], detectors=detectors)


def _closed_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    rows = {}
    for name in METERS:
        out, into = fluxes(result, name)
        rows[f"{NET}, {name}"] = sharp(out - into, of=out)
    return rows


def fluxes(result: tp.Result, meter: str) -> tuple[tp.Estimate, tp.Estimate]:
    """What flows out of a closed meter, and what into it [W]."""
    parts = [result[face] for face in FACES] if meter == "tetrahedron" else [result[meter]]
    return sum(part.flux_out for part in parts), sum(part.flux_in for part in parts)


# ---- answer and pictures ----


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    if patches := where(meter="patch")(outcomes):
        histories = sum(int(started_and_crossed(o.result)[1].sum()) for o in patches)
        differ = sum(int(o[DIFFER].estimate.value) for o in patches)
        said.append(
            f"{histories} sampled histories crossed within dt and they are those that started in the prism:"
            f" {f'{differ} differ' if differ else 'none differs'}; each side counts n v cosθ where that is positive,"
            " and 0 where not"
        )
    for outcome in where(meter="closed")(outcomes):
        inside = ", ".join(f"{outcome[f'{NET}, {name}'].estimate} ({name})" for name in METERS)
        said.append(f"the net flux out of a closed meter is the power inside: {inside}")
    return sentence(*said)


def _angle(outcome: Outcome) -> float:
    """Between the stream and the normal [deg]."""
    return math.degrees(outcome.given["tilt"])


def draw_tilts(outcomes: list[Outcome], path: Path, note: str) -> None:
    """What the two sides of the patch count by its angle, each with the clamped cosine, and their difference."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import figure

    ordered = sorted(outcomes, key=_angle)
    angles = [_angle(o) for o in ordered]
    beam = ordered[0].given["density"] * ordered[0].given["speed"]
    of_sides = {
        "along the normal: n v max(cosθ, 0)": (ALONG, lambda x: beam * np.maximum(np.cos(np.radians(x)), 0)),
        "against it: n v max(−cosθ, 0)": (AGAINST, lambda x: beam * np.maximum(-np.cos(np.radians(x)), 0)),
    }
    panels = {
        "each side counts a clamped cosine": of_sides,
        "the net flux is their difference": {"net: n v cosθ": (NET, lambda x: beam * np.cos(np.radians(x)))},
    }
    with figure(
        (19, 9.2), "A stream on a tilted patch: n v cosθ, and each side sees its half", note, path
    ) as page:
        for axes, (title, laws) in zip(page.subplots(1, 2, sharey=True), panels.items(), strict=True):
            series = {
                words: Series(angles, [o[name].estimate for o in ordered], law)
                for words, (name, law) in laws.items()
            }
            plot_curves(
                series, ax=axes, span=(0, 180), xlabel="θ between the stream and the normal  [deg]",
                ylabel="flux density", legend="lower left",
            )  # fmt: skip
            axes.set(title=title, xticks=range(0, 181, 30), xlim=(-5, 185), ylim=(-1.1 * beam, 1.1 * beam))
            axes.label_outer()


def draw_prisms(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Who crosses the patch, by their places at the start, seen from the side: along the stream and across it."""
    from transport.viz.style import figure

    title = "Who starts in the oblique prism v dt · dA crosses dA within dt"
    with figure((7.2 * len(outcomes) + 1, 6.4), title, note, path) as page:
        row = page.subplots(1, len(outcomes), squeeze=False, sharex=True, sharey=True)[0]
        for axes, outcome in zip(row, outcomes, strict=True):
            _draw_prism(axes, outcome)
        row[0].set_ylabel("x  [m]")
        place = "center" if len(outcomes) > 1 else "left"
        page.legend(*row[0].get_legend_handles_labels(), loc=f"outside lower {place}", ncols=4, markerscale=4)


def _draw_prism(axes, outcome: Outcome) -> None:
    from matplotlib.patheffects import withStroke

    from transport.viz.style import BLUE, INK, VERMILLION

    rim = [withStroke(linewidth=6, foreground="white")]  # so that points do not hide arrows
    result, patch = outcome.result, outcome.result.scene.surfaces[0].shape
    started, crossed = started_and_crossed(result)
    starts = result["start"].positions
    beside = np.abs(starts[:, 1]) <= HEIGHT / 2  # neither before the patch nor behind it
    e_u, _, normal = np.array(patch.frame)[:, [2, 0]]
    ends, path = np.array([-0.5, 0.5])[:, None] * WIDTH * e_u, np.array([REACH, 0])
    kinds = {"does not cross": (~crossed, "#b8b8b8"), "crosses within dt": (crossed, BLUE)}
    for words, (chosen, colour) in kinds.items():
        places = starts[beside & chosen][: MOST // 2, [2, 0]]
        axes.plot(*places.T, "o", color=colour, ms=2.6, mew=0, label=words)
    outline = np.array([*ends, *(ends[::-1] - path), ends[0]])
    axes.plot(*outline.T, "--", color=VERMILLION, lw=2.6, label="prism, edge v dt")
    axes.plot(*ends.T, color=INK, lw=6, solid_capstyle="butt", label="patch dA")
    arrow = {"arrowstyle": "-|>,head_width=0.45,head_length=0.9", "lw": 3, "shrinkA": 0, "path_effects": rim}
    words = {"ha": "center", "va": "center", "fontweight": "bold", "path_effects": rim}
    for start, way, colour, word in (
        (0, 0.35 * REACH * normal, INK, "n"),
        (-path, 0.4 * path, VERMILLION, "v"),
    ):
        axes.annotate("", start + way, np.zeros(2) + start, arrowprops=arrow | {"color": colour})
        axes.annotate(word, start + 1.25 * way, color=colour, **words)
    numbers = [with_thousands_spaces(each.sum()) for each in (started, crossed)]
    words = f"θ = {_angle(outcome):.4g}°: {numbers[0]} started in the prism,\n{numbers[1]} crossed"
    axes.set_title(f"{words}, {np.count_nonzero(started != crossed)} differ", fontsize="medium")
    axes.set(aspect="equal", xlabel="z  [m]")


def draw_space(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The prism in space: particles at the start and after dt, blue if they started in it; they alone have crossed."""
    from transport.viz.solid_panel import SolidPanel
    from transport.viz.style import figure

    outcome = outcomes[0]
    started, crossed = started_and_crossed(outcome.result)
    differ = np.count_nonzero(started != crossed)
    same = f"the same {with_thousands_spaces(crossed.sum())}, and no others,"
    words = (
        f"now: {with_thousands_spaces(started.sum())} particles are in the prism, of the volume v cosθ dt dA",
        f"dt later: {f'{crossed.sum()}, of which {differ} others,' if differ else same} have crossed dA: Φ = dQ/dt",
    )
    title = "Exactly the particles in the oblique prism v dt · dA cross dA within dt"
    with figure((16, 10), title, note, path) as page:
        panels = [SolidPanel(viewer=(0.5, 1, -0.3), up=(1, 0, 0)) for _ in words]
        for panel, is_later in zip(panels, (False, True), strict=True):
            _place_prism(panel, outcome, is_later)
        corners = np.array([panel.limits(margin=0.02) for panel in panels])
        corners[0, 1, 1] += 0.1  # for the letter of the normal
        corners[:, :, 0] = corners[:, 0, 0].min(), corners[:, 1, 0].max()  # one abscissa
        for panel, axes, said, limits in zip(panels, page.subplots(2, 1), words, corners, strict=True):
            panel.show(axes, limits)
            axes.set_title(said)


def _place_prism(panel: SolidPanel, outcome: Outcome, is_later: bool) -> None:
    """The patch, its normal, the velocity, the prism before or behind the patch, and some of the particles."""
    from transport.viz.solid_panel import LABEL
    from transport.viz.style import BLUE, INK, VERMILLION

    result, tilt = outcome.result, outcome.given["tilt"]
    started, _ = started_and_crossed(result)
    e_u, e_v, normal = np.array(result.scene.surfaces[0].shape.frame)
    way = np.array([0, 0, REACH])
    base = np.array([i * WIDTH * e_u + j * HEIGHT * e_v for i, j in ((1, 1), (1, -1), (-1, -1), (-1, 1))]) / 2
    places = (
        result["start"].positions + is_later * way
    )  # a particle that has crossed is drawn where it would be
    shown = np.arange(len(places)) < IN_SPACE
    panel.balls(places[shown & ~started], "#b8b8b8", 0.011)
    panel.balls(places[shown & started], BLUE, 0.016)
    end = base + way * (1 if is_later else -1)
    panel.loop(end, VERMILLION, 0.008)
    for start, stop in zip(base, end, strict=True):
        panel.line([start, stop], VERMILLION, 0.008)
    panel.polygon(base, INK, 0.6)
    panel.loop(base, INK, 0.014)
    panel.text(base[2] - 0.09 * e_u, "dA", **LABEL)
    panel.text((base[0] + end[0]) / 2 + 0.09 * e_u, "v dt", color=VERMILLION, **LABEL)
    if is_later:
        return
    panel.arrow((0, 0, 0), 0.48 * normal, INK, 0.04, "n")
    panel.arrow((0, 0, 0), 0.6 * way, VERMILLION, 0.04, "v")
    turns = np.linspace(0, tilt, 30)[:, None]
    side = (normal - math.cos(tilt) * way / REACH) / math.sin(tilt)
    arc = 0.3 * (np.cos(turns) * way / REACH + np.sin(turns) * side)
    panel.line(arc, INK, 0.008)
    panel.text(1.5 * arc[12], f"θ = {_angle(outcome):.4g}°")


def draw_times(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The amount that has crossed by time, whose slope is the flux, and the flux by intervals of several lengths."""
    from transport.viz.style import BLUE, INK, VERMILLION, figure

    outcome = outcomes[0]
    times, names = edges(outcome.given["intervals"]), interval_names(edges(outcome.given["intervals"]))
    seconds, level = REACH / outcome.given["speed"], outcome[names[0]].exact
    fluxes = [outcome[name].estimate for name in names]
    amounts = [
        flux * constant(outcome.result, width * seconds, "s")
        for flux, width in zip(fluxes, np.diff(times), strict=True)
    ]
    sums = [sum(amounts[1 : k + 1], amounts[0]) for k in range(len(amounts))]
    with figure((17, 8.6), "Flux is amount per time: in a steady stream any Δt gives it", note, path) as page:
        left, right = page.subplots(1, 2)
        left.plot([0, 1], [0, level * seconds], color=INK, lw=2.6, label="exact: Q = Φ t")
        for k, amount in enumerate(sums):
            left.fill_between(
                times[k : k + 2],
                0,
                level * seconds * times[k : k + 2],
                color=BLUE,
                alpha=0.15 + 0.1 * (k % 2),
                lw=0,
            )
            left.errorbar(times[k + 1], amount.value, 2 * amount.error, fmt="o", color=BLUE, ms=13)
        left.set(xlim=(0, 1.04), ylim=(0, 1.1 * level * seconds), ylabel="amount Q that has crossed")
        left.legend(loc="upper left")
        right.axhline(level, color=INK, lw=2.6, label="exact: n v cosθ dA")
        middles = (times[1:] + times[:-1]) / 2
        wrong = {"color": VERMILLION, "ms": 10, "lw": 2.5, "label": "wrong: Δt left out, ΔQ/dt"}
        right.plot(middles, level * np.diff(times), "s--", **wrong)
        for flux, low, high in zip(fluxes, times, times[1:], strict=False):
            right.errorbar(
                (low + high) / 2,
                flux.value,
                2 * flux.error,
                (high - low) / 2,
                fmt="o",
                color=BLUE,
                ms=11,
                lw=3,
                capsize=8,
            )
        right.errorbar([], [], fmt="o", color=BLUE, ms=11, label="ΔQ/Δt, bars: Δt and ± 2 standard errors")
        right.set(xlim=(0, 1.04), ylim=(0, 1.35 * level), ylabel="flux ΔQ/Δt  [s$^{-1}$]")
        right.legend(loc="upper left")
        for axes in (left, right):
            axes.set_xlabel("time / dt")


def _timed(outcomes: list[Outcome]) -> list[Outcome]:
    """One whose time is cut into intervals, with a flux."""
    cut = [o for o in where(meter="patch")(outcomes) if o.given["intervals"] > 1]
    return [o for o in cut if o[STARTED].exact > 0][:1]


def draw_settling(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Counts of the prism as more particles are counted: in a few samples, and how far many are off on average."""
    from transport.viz.style import BLUE, INK, MUTED, SKY, figure, tick_log

    outcome = outcomes[0]
    started, _ = started_and_crossed(outcome.result)
    share = outcome[STARTED].exact / outcome.result.ledger["emitted"].value
    numbers = np.arange(1, LONGEST + 1)
    counted = np.cumsum(started[: FEW_RUNS * LONGEST].reshape(FEW_RUNS, LONGEST), axis=1) / numbers / share
    one = math.sqrt((1 - share) / share)  # error of one particle, of a binomial count
    with figure((19, 9.4), "More particles, a better number: the error falls as 1/√N", note, path) as page:
        left, right = page.subplots(1, 2)
        left.fill_between(
            numbers,
            1 - 2 * one / np.sqrt(numbers),
            1 + 2 * one / np.sqrt(numbers),
            color=SKY,
            alpha=0.35,
            lw=0,
        )
        for each in counted:
            left.plot(numbers, each, color=BLUE, lw=1.8, alpha=0.7)
        left.axhline(1, color=INK, lw=2.5)
        left.set(xscale="log", xlim=(10, LONGEST), ylim=(0, 2), ylabel="counted in the prism / exact")
        left.set_title(f"{FEW_RUNS} samples, and ± 2 standard errors")
        sizes = np.unique(np.geomspace(10, LONGEST, 12).astype(int))
        pieces = len(started) // sizes  # into which the sample is cut
        means = [
            started[: k * n].reshape(k, n).mean(axis=1) / share for k, n in zip(pieces, sizes, strict=True)
        ]
        off = np.array([math.sqrt(np.mean((mean - 1) ** 2)) for mean in means])
        right.plot(numbers, 100 * one / np.sqrt(numbers), color=INK, lw=2.6, label="exact: 1/√N")
        right.plot(
            numbers, 1000 * one / math.sqrt(10) / numbers, "--", color=MUTED, lw=2.6, label="wrong: 1/N"
        )
        words = f"r.m.s. error of {pieces[-1]} to {with_thousands_spaces(pieces[0])} samples"
        right.errorbar(
            sizes, 100 * off, 200 * off / np.sqrt(2 * pieces), fmt="o", color=BLUE, ms=11, label=words
        )
        right.set(xscale="log", yscale="log", xlim=(8, 1.2 * LONGEST), ylim=(0.5, 100), ylabel="error  [%]")
        right.set_title("four times the particles, half the error")
        right.legend(loc="lower left")
        tick_log(right.yaxis)
        for axes in (left, right):
            axes.set_xlabel("particles N in the sample")
            tick_log(axes.xaxis)


def draw_closed(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Each closed detector from the side, with the flows out of it and into it to scale, and their difference."""
    from transport.viz.style import figure

    title = "What flows out less what flows in is what shines inside"
    note = f"orange: sources; ring: a white ball; outside: a third source, a mirror; {note}"
    with figure((19, 13.4), title, note, path) as page:
        for axes, name in zip(page.subplots(2, 2).flat, METERS, strict=True):
            _draw_detector(axes, name, outcomes[0])


def _outlines(shape: tp.Shape) -> list[np.ndarray]:
    """Closed lines (x, z) of a sphere, a box, a triangle or a disk as they are seen along y [m]."""
    x, _, z = shape.center
    match shape:
        case tp.Sphere():
            turn = np.linspace(0, 2 * math.pi, 181)
            return [np.stack([x + shape.radius * np.cos(turn), z + shape.radius * np.sin(turn)], axis=-1)]
        case tp.Box():
            corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) / 2
            return [corners * np.array(shape.size)[[0, 2]] + (x, z)]
        case tp.Triangle():
            return [np.array(shape.vertices)[[0, 1, 2, 0]][:, [0, 2]]]
    e_u, e_v, _ = np.array(shape.frame)
    turn = np.linspace(0, 2 * math.pi, 91)[:, None]
    rim = np.array(shape.center) + shape.radius * (np.cos(turn) * e_u + np.sin(turn) * e_v)
    return [rim[:, [0, 2]]]


def _draw_detector(axes, name: str, outcome: Outcome) -> None:
    """The scene in pale lines, one detector in bold, and arrows as broad as its flows."""
    from transport.viz.exhibits import bare_panel
    from transport.viz.style import BLUE, INK, MUTED, ORANGE, VERMILLION
    from transport.viz.wording import number_text

    result = outcome.result
    for surface in result.scene.surfaces[:1]:
        for line in _outlines(surface.shape):
            axes.fill(*line.T, fc="white", ec=MUTED, lw=3, zorder=2)
    for source in result.scene.sources[:2]:  # the third, and the mirror, stand outside of the picture
        if isinstance(source.shape, tp.Point):
            axes.plot(source.shape.position[0], source.shape.position[2], "*", color=ORANGE, ms=22, zorder=5)
        else:
            for line in _outlines(source.shape):
                axes.fill(*line.T, fc=ORANGE, ec=ORANGE, lw=4, zorder=5)
    right = -math.inf
    for detector in result.scene.detectors:
        is_shown = detector.name.split(",")[0] == name
        style = (
            {"color": INK, "lw": 5, "zorder": 4} if is_shown else {"color": "#c4c4c4", "lw": 1.6, "zorder": 1}
        )
        for line in _outlines(detector.shape):
            axes.plot(*line.T, **style)
            if is_shown and line[:, 0].max() > right:
                right, middle = line[:, 0].max(), (line[:, 1].min() + line[:, 1].max()) / 2
    out, into = fluxes(result, name)
    for flux, height, way, colour, word in ((out, 0.25, 1, BLUE, "out"), (into, -0.25, -1, VERMILLION, "in")):
        width = ARROW * flux.value / outcome.given["power"]
        start = right + (0.06 if way > 0 else 0.76)
        axes.arrow(
            start, middle + height, 0.7 * way, 0, width=width, head_width=width + 0.12, head_length=0.16,
            length_includes_head=True, color=colour, lw=0, zorder=6,
        )  # fmt: skip
        said = f"{word}\n{number_text(flux)} W"
        axes.text(right + 0.86, middle + height, said, color=colour, fontsize=22, va="center", zorder=7)
    row = outcome[f"{NET}, {name}"]
    axes.set_title(
        f"{name}: {row.exact:g} W inside\nout − in = {number_text(row.estimate)} W", linespacing=1.3
    )
    bare_panel(axes, (-1.1, 3.05), (-0.85, 1.4))


def _thick(outcomes: list[Outcome]) -> list[Outcome]:
    """Patches whose prism is thick enough to be drawn."""
    return [o for o in where(meter="patch")(outcomes) if abs(_angle(o) - 90) > SHOWN][:PANELS]


def _oblique(outcomes: list[Outcome]) -> list[Outcome]:
    """The first patch whose prism is neither straight nor thin."""
    return [o for o in _thick(outcomes) if OBLIQUE[0] < _angle(o) < OBLIQUE[1]][:1]


def _countable(outcomes: list[Outcome]) -> list[Outcome]:
    """The same, if enough of its particles are in the sample."""
    return [o for o in _oblique(outcomes) if len(o.result["start"].histories) >= FEW_RUNS * LONGEST]


draw = figures(
    prisms=(draw_prisms, _thick),
    space=(draw_space, in_space(_oblique)),
    time=(draw_times, _timed),
    settling=(draw_settling, _countable),
    tilt=(draw_tilts, several(where(meter="patch"))),
    closed=(draw_closed, where(meter="closed")),
)


if __name__ == "__main__":
    main(__file__)
