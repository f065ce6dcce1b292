"""Two elements: the first law of radiance as it is proved, by the rays that join two elements of area.

Derivation.  Rays leave dA₁ for dA₂, tilted by θ₁ and θ₂ to the line r between them.  Seen from dA₁ the other one fills
dω₁ = dA₂ cosθ₂/r², and seen from dA₂ it is dω₂ = dA₁ cosθ₁/r².  The rays that leave are those that arrive,

    L₁ dω₁ dA₁ cosθ₁ = d²Φ = L₂ dω₂ dA₂ cosθ₂,

and the two products are the same dA₁ cosθ₁ dA₂ cosθ₂/r² = d²T, the throughput, which counts rays: so L₁ = L₂ (Hanrahan
2001, Stanford CS 348B, lecture 4, "1st law", "Throughput").  Elements of finite size hold T = ∬ cosθ₁ cosθ₂/r² dA₁ dA₂,
and Φ = L T is exact; the radiance by their middles is L T/d²T, off by a multiple of (a/r)².

Scenes.  "first law": either end by random numbers of its own, in two copies of the arrangement that lie far apart.  A
diffuse wall close behind dA₁ shines, so large that every ray that counts begins on it.  In the first copy dA₁ alone
counts the rays that leave within a narrow cone about r: L₁ is their flux over dA₁ ∫cosθ₁ dω, and knows nothing of dA₂.
In the second copy dA₂ counts the rays that arrive through dA₁ (`via`): L₂ = Φ₂/T, and knows nothing of the cone.  Were
the same rays counted at both ends, L₁ = L₂ would follow from the division alone.  "throughput": two
coaxial disks that shine at one another, counted at both and on a tilted plane between them.  "lines": the inner side
of a sphere round the disks sends out uniform random lines; those that meet both disks are counted, whichever they meet
first.  "chord": the black inner side of a convex body sends out such lines at a constant rate.  A particle stays for
chord/v, so that power × mean chord/v is in flight at any time from the longest stay on; the mean chord is 4 V/S
(Cauchy 1850; Dirac 1943; Coleman 1969).

Aimed sources send out only the rays that are wanted here; that is what the warnings of their counters tell.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import (
    constant,
    curves_figure,
    figures,
    main,
    of_scene,
    one_of,
    others,
    provenance,
    several,
    sharp,
    where,
)
from transport.theory import enclosures, etendue
from transport.verification.experiment import Outcome

law = "L₁ dω₁ dA₁ cosθ₁ = L₂ dω₂ dA₂ cosθ₂; T = ∬ cosθ₁ cosθ₂/r² dA₁ dA₂; mean chord 4V/S (Hanrahan 2001; Cauchy 1850)"
question = "Do rays that join two elements carry the same radiance at both ends?"
particles = 4_000_000
intended = {
    "aim": "only rays between the two elements, or within the cone, are wanted",
}

SHOWS = ("first law", "throughput", "lines", "chord")
BODIES = {"sphere": None, "cube": (1, 1, 1), "box": (1, 2, 3)}  # edges over size_1, the sphere's radius
DEPTH = 0.002  # of the wall behind dA₁, in half sides
CONE = 0.1  # rad, largest half angle of the cone in which rays leave dA₁
APART = 100.0  # from one copy of the elements to the other, over their sizes and distance
LARGE = 20.0  # section of the cone where rays are aimed, over dA₁
ALONE = "dA1, alone"
PLANE = math.radians(20)  # largest tilt of the plane between
LAST = 1.05  # duration over the longest stay

L1, L2, RATIO = "L₁, leaves dA₁ in a cone", "L₂ = Φ₂/T, arrives at dA₂", "L₁/L₂"
SAME, MIDDLES, BIAS = "Φ₁ − Φ₂", "Φ₂/(dω₂ dA₂ cosθ₂)", "T/(dA₁ dA₂/r²) − 1"
AT_2, AT_1, UP, DOWN = "T at dA₂", "T at dA₁", "T through the plane, up", "T through the plane, down"
THERE, BACK, ALL = "T, lines by dA₁ to dA₂", "T, lines by dA₂ to dA₁", "π dA₁, all lines by dA₁"
CHORD = "mean chord"


def cases() -> list[dict[str, object]]:
    tilts = [(0, 0, 0.05, 0.05), (75, 45, 0.05, 0.02), (75, 45, 0.2, 0.2)]
    tilted = [
        {"show": "first law", "size_1": a, "size_2": b, "tilt_1": one * tp.deg, "tilt_2": two * tp.deg}
        for one, two, a, b in tilts
    ]
    disks = [(1.0, 1.0), (0.1, 0.1), (0.01, 0.01), (0.001, 0.001), (1.0, 2.0)]
    seen = [{"show": "throughput", "size_1": one, "size_2": two} for one, two in disks]
    lines = {"show": "lines", "size_1": 1.0, "size_2": 1.0}
    return [*tilted, *seen, lines, *({"show": "chord", "size_1": 1.0, "body": body} for body in BODIES)]


def scene(
    show: str = "first law",
    size_1: float = 0.1,
    size_2: float = 0.1,
    tilt_1: float = 0.0,
    tilt_2: float = 0.0,
    distance: float = 1.0,
    radiance: float = 100.0,
    body: str = "sphere",
) -> tp.Scene:
    """Two elements `distance` apart, or the inside of a body.

    size_1, size_2: half sides of the squares of "first law", radii of the disks [m], scale of the body;  tilt_1,
    tilt_2: of the squares, about axes at right angles to one another [rad].
    """
    one_of("two_elements", show=(show, SHOWS), body=(body, BODIES))
    shine = tp.Lambertian(radiance=radiance)
    if show == "first law":
        return _tilted_squares(size_1, size_2, tilt_1, tilt_2, distance, shine)
    if show == "throughput":
        return _facing_disks(size_1, size_2, distance, shine)
    if show == "lines":
        return _random_lines(size_1, size_2, distance, shine)
    return _convex_body(_body(body, size_1), shine)


def squares(
    size_1: float, size_2: float, tilt_1: float, tilt_2: float, distance: float
) -> tuple[tp.Rectangle, tp.Rectangle]:
    """dA₁ at the origin, which looks up, and dA₂ above it, which looks down."""
    normal_1 = math.sin(tilt_1), 0.0, math.cos(tilt_1)
    normal_2 = 0.0, math.sin(tilt_2), -math.cos(tilt_2)
    one = tp.Rectangle(normal=normal_1, up=(0, 1, 0), width=2 * size_1, height=2 * size_1)
    two = tp.Rectangle(
        center=(0, 0, distance), normal=normal_2, up=(1, 0, 0), width=2 * size_2, height=2 * size_2
    )
    return one, two


def _tilted_squares(size_1, size_2, tilt_1, tilt_2, distance, shine) -> tp.Scene:
    one, two = squares(size_1, size_2, tilt_1, tilt_2, distance)
    source = tp.Source(_wall_behind(one, _steepest(one, two)), shine, aim=two)
    arriving = [tp.Detector(one, "dA1"), tp.Detector(two, "dA2", via="dA1")]
    far = (APART * (size_1 + size_2 + distance), 0.0, 0.0)
    alone, half_angle = replace(one, center=far), cone_of(tilt_1)
    steepest, spread = math.tan(abs(tilt_1) + half_angle), math.tan(half_angle)
    height = LARGE * size_1 / spread  # where the cones from all of dA₁ are nearly one
    beyond = tp.Disk(
        center=(far[0], 0, height), normal=(0, 0, -1), radius=2 * size_1 + (height + size_1) * spread
    )
    cone = tp.Directions.cone((0, 0, 1), half_angle)
    leaving = tp.Detector(alone, ALONE, directions=cone)
    sources = [source, tp.Source(_wall_behind(alone, steepest), shine, aim=beyond)]
    return tp.Scene(sources=sources, detectors=[*arriving, leaving])


def cone_of(tilt_1: float) -> float:
    """Half angle of the cone about the line in which rays leave dA₁, above its horizon [rad]."""
    return min(CONE, (math.pi / 2 - abs(tilt_1)) / 2)


def _wall_behind(one: tp.Rectangle, steepest: float) -> tp.Rectangle:
    """The wall on which every ray through the element begins that is no steeper than that."""
    depth = DEPTH * one.width / 2
    side = one.width + 2 * depth * steepest
    center = np.subtract(one.center, np.multiply(depth, one.normal))
    return tp.Rectangle(center=center, normal=one.normal, up=one.up, width=side, height=side)


def _steepest(one: tp.Rectangle, two: tp.Rectangle) -> float:
    """The largest tangent to dA₁'s normal of a ray between the two, which is that of a ray between corners."""
    rays = np.array([q - p for p in _corners(one) for q in _corners(two)])
    cosines = rays / np.linalg.norm(rays, axis=1, keepdims=True) @ np.transpose([one.normal, two.normal])
    if not (cosines[:, 0].min() > 0 > cosines[:, 1].max()):
        raise tp.SceneError(
            "two_elements: one element reaches behind the other; tilt them less or make them smaller"
        )
    return math.tan(math.acos(cosines[:, 0].min()))


def _corners(shape: tp.Rectangle) -> list[np.ndarray]:
    u, v = sides_of(shape) / 2
    return [shape.center + i * u + j * v for i in (-1, 1) for j in (-1, 1)]


def sides_of(shape: tp.Rectangle) -> np.ndarray:
    """The two side vectors [m], (2, 3)."""
    e_u, e_v, _ = shape.frame
    return np.array([np.multiply(e_u, shape.width), np.multiply(e_v, shape.height)])


def disks(radius_1: float, radius_2: float, distance: float) -> tuple[tp.Disk, tp.Disk]:
    """Coaxial ones that face one another."""
    return tp.Disk(radius=radius_1), tp.Disk(center=(0, 0, distance), normal=(0, 0, -1), radius=radius_2)


def _facing_disks(size_1, size_2, distance, shine) -> tp.Scene:
    one, two = disks(size_1, size_2, distance)
    radius = 1.3 * max(size_1, size_2)
    tilt = min(PLANE, math.atan(0.4 * distance / radius))  # so that the plane meets neither disk
    plane = tp.Disk(center=(0, 0, distance / 2), normal=(math.sin(tilt), 0, math.cos(tilt)), radius=radius)
    sources = [tp.Source(one, shine, aim=two), tp.Source(two, shine, aim=one)]
    counters = [
        tp.Detector(one, "dA1"),
        tp.Detector(two, "dA2"),
        tp.Detector(plane, "plane via dA1", via="dA1"),
        tp.Detector(plane, "plane via dA2", via="dA2"),
    ]
    return tp.Scene(sources=sources, detectors=counters)


def _random_lines(size_1, size_2, distance, shine) -> tp.Scene:
    one, two = disks(size_1, size_2, distance)
    bounds = tp.Sphere(
        center=(0, 0, distance / 2), radius=1.05 * math.hypot(distance / 2, max(size_1, size_2))
    )
    counters = [
        tp.Detector(one, "dA1"),
        tp.Detector(two, "dA2"),
        tp.Detector(one, "dA1 via dA2", via="dA2"),
        tp.Detector(two, "dA2 via dA1", via="dA1"),
    ]
    return tp.Scene(sources=tp.Source(bounds, shine, side="back"), detectors=counters)


def _body(body: str, scale: float) -> tp.Sphere | tp.Box:
    edges = BODIES[body]
    return tp.Sphere(radius=scale) if edges is None else tp.Box(size=[scale * edge for edge in edges])


def _convex_body(shape: tp.Sphere | tp.Box, shine: tp.Lambertian) -> tp.Scene:
    return tp.Scene(
        sources=tp.Source("wall", shine, side="back"),
        surfaces=tp.Surface(shape, tp.Black(), name="wall"),
        duration=LAST * 2 * shape.extent / tp.speed_of_light,
    )


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    scene, names = result.scene, {detector.name for detector in result.scene.detectors}
    shine = constant(result, scene.sources[0].emission.radiance, "W m^-2 sr^-1")
    if not names:
        stay = result.ledger["in_flight"] / result.ledger["emitted"] * constant(result, scene.duration, "s")
        return {CHORD: stay * constant(result, tp.speed_of_light, "m s^-1")}
    if "plane via dA1" in names:
        at_1, at_2, up, down = (result[name] for name in ("dA1", "dA2", "plane via dA1", "plane via dA2"))
        fluxes = {AT_2: at_2.flux_in, AT_1: at_1.flux_in, UP: up.flux_out, DOWN: down.flux_in}
        rows = {name: flux / shine for name, flux in fluxes.items()}
        one, two = at_1.detector.shape, at_2.detector.shape
        by_middles = etendue.element_throughput(one.area, 1.0, two.area, 1.0, two.center[2])
        return rows | {BIAS: rows[AT_2] / constant(result, by_middles, "m^2 sr") - 1}
    if "dA2 via dA1" in names:
        there, back = result["dA2 via dA1"].flux_in, result["dA1 via dA2"].flux_in
        return {THERE: there / shine, BACK: back / shine, ALL: result["dA1"].flux_in / shine}
    return _first_law(result)


def _first_law(result: tp.Result) -> dict[str, tp.Estimate]:
    one, two = result["dA1"].detector.shape, result["dA2"].detector.shape
    passing, arriving = result["dA1"].flux_out, result["dA2"].flux_in
    mu_1, mu_2, distance = one.normal[2], -two.normal[2], two.center[2]
    leaves = result[ALONE].radiance_out[0]
    arrives = arriving / constant(result, throughput_of(one, two), "sr m^2")
    solid_angle_2 = one.area * mu_1 / distance**2
    return {
        L1: leaves,
        L2: arrives,
        RATIO: leaves / arrives,
        MIDDLES: arriving / constant(result, solid_angle_2 * two.area * mu_2, "sr m^2"),
        SAME: sharp(passing - arriving, of=passing),
    }


def throughput_of(one: tp.Rectangle, two: tp.Rectangle) -> float:
    """All rays that join two squares [m^2 sr], by quadrature."""
    return etendue.tilted_throughput(one.center, sides_of(one), two.center, sides_of(two))


@of_scene(scene)
def exact(show, size_1, size_2, tilt_1, tilt_2, distance, radiance, body) -> dict[str, float]:
    if show == "chord":
        shape = _body(body, size_1)
        return {CHORD: float(enclosures.mean_chord(shape.volume, shape.area))}
    if show == "first law":
        one, two = squares(size_1, size_2, tilt_1, tilt_2, distance)
        by_middles = etendue.element_throughput(
            one.area, math.cos(tilt_1), two.area, math.cos(tilt_2), distance
        )
        seen = radiance * throughput_of(one, two) / by_middles
        return {L1: radiance, L2: radiance, RATIO: 1.0, MIDDLES: seen, SAME: 0.0}
    rays = float(etendue.disks_throughput(size_1, size_2, distance))
    if show == "lines":
        return {THERE: rays, BACK: rays, ALL: math.pi * math.pi * size_1**2}
    bias = float(etendue.disks_bias(size_1 / distance, size_2 / distance))
    return {AT_2: rays, AT_1: rays, UP: rays, DOWN: rays, BIAS: bias}


def verdict(outcomes: list[Outcome]) -> str:
    """One sentence for each thing that was shown."""
    sentences = []
    for outcome in outcomes:
        row = {row.name: row for row in outcome.rows}
        if L1 in row and not sentences:
            sentences.append(
                f"{row[L1].estimate} leaves dA₁ and {row[L2].estimate} arrives at dA₂, by other rays."
            )
    alike = _alike(outcomes)[1:]  # but the largest, which are no elements any more
    if len(alike) > 1:
        sizes, biases = [o.given["size_1"] for o in alike], [o[BIAS].estimate.value for o in alike]
        slope = np.polyfit(np.log(sizes), np.log(np.abs(biases)), 1)[0]
        sentences.append(f"The bias of finite elements falls as (a/r)^{slope:.3f}.")
    named = {THERE: "Uniform random lines count", AT_2: "Rays from dA₁ count", CHORD: "The mean chord is"}
    for name, words in named.items():
        found = [row for o in outcomes for row in o.rows if row.name == name]
        if found:
            sentences.append(f"{words} {found[0].estimate}, exact {found[0].exact:.6g}.")
    return " ".join(sentences)


def _alike(outcomes: list[Outcome]) -> list[Outcome]:
    """Cases of two facing disks of one size, which the bias's fall is read from."""
    return [o for o in where(show="throughput")(outcomes) if o.given["size_1"] == o.given["size_2"]]


@curves_figure(
    guides={"2 (a/r)²": lambda ratio: 2 * ratio**2, "falls with a/r only": lambda ratio: ratio},
    xlabel="radius of both disks over their distance, a/r",
    ylabel="1 − L by the middles / L",
    title="Finite elements: what their middles get wrong falls as (a/r)²",
    log_x=True,
    log_y=True,
)
def draw_bias(outcomes: list[Outcome]) -> dict[str, object]:
    """The bias of elements against their size."""
    ratios = [o.given["size_1"] / o.given["distance"] for o in outcomes]
    biases = [-1 * o[BIAS].estimate for o in outcomes]
    return {
        "series": (ratios, biases, lambda ratio: -etendue.disks_bias(ratio, ratio)),
        "note": f"{provenance(outcomes)}, the same random numbers in each",
    }


def draw_laws(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The rays between two elements at both ends, all rays between two disks, and mean chords."""
    from transport.viz.style import figure

    firsts, chords = (where(show=show)(outcomes) for show in ("first law", "chord"))
    disks = where(show=("throughput", "lines"))(outcomes)
    drawings = []
    if firsts:
        drawings += [_draw_elements, lambda axes: _draw_ends(axes, firsts)]
    if disks:
        drawings += [lambda axes: _draw_disks(axes, disks)]
    if chords:
        drawings += [lambda axes: _draw_chords(axes, chords)]
    columns = min(2, len(drawings))
    rows = -(-len(drawings) // columns)
    title = "The rays that leave are those that arrive" if firsts or disks else "The mean chord is 4V/S"
    with figure((9.6 * columns, 7.6 * rows + 1.2), title, note, path) as page:
        grid = page.subplots(rows, columns, squeeze=False).ravel()
        for axes, draw_panel in zip(grid, drawings, strict=False):
            draw_panel(axes)
        for axes in grid[len(drawings) :]:
            axes.remove()


def _draw_elements(axes) -> None:
    """Two tilted elements, the line between them, their normals, and the rays that join them."""
    from transport.viz.exhibits import bare_panel, draw_arrow
    from transport.viz.style import BLUE, INK, ORANGE, VERMILLION

    ends = (
        (np.array([0.0, 0.0]), math.radians(55), BLUE, 1),
        (np.array([3.0, 0.0]), math.radians(40), VERMILLION, -1),
    )
    rims = []
    for rank, (middle, tilt, colour, way) in enumerate(ends, start=1):
        normal = np.array([way * math.cos(tilt), math.sin(tilt)])
        side = np.array([-normal[1], normal[0]])
        rims.append(middle + np.outer((-0.42, 0.42), side * way))
        axes.plot(*rims[-1].T, color=colour, lw=9, solid_capstyle="butt", zorder=4)
        draw_arrow(axes, middle, 0.9 * normal, colour, 3)
        words = {"color": colour, "fontsize": 24, "ha": "center", "va": "center"}
        axes.text(*(middle + (way * 0.42, 0.2)), f"θ{'₁₂'[rank - 1]}", **words)
        axes.text(*(middle + (-way * 0.15, -0.62)), f"dA{'₁₂'[rank - 1]}", **words)
    for share in np.linspace(0, 1, 5):
        for other in np.linspace(0, 1, 3):
            start, end = (
                rim[0] + at * (rim[1] - rim[0]) for rim, at in zip(rims, (share, other), strict=True)
            )
            axes.plot(*np.stack([start, end], axis=1), color=ORANGE, lw=1.4, zorder=1)
    axes.plot([0, 3], [0, 0], "--", color=INK, lw=2.5, zorder=3)
    axes.text(1.5, 0.12, "r", fontsize=24, ha="center", bbox={"fc": "white", "ec": "none", "pad": 1})
    axes.set_title("$L_1$ dω₁ dA₁ cosθ₁ = $L_2$ dω₂ dA₂ cosθ₂")
    bare_panel(axes, (-0.75, 3.75), (-0.95, 1.25))


def _draw_ends(axes, outcomes: list[Outcome]) -> None:
    """Radiance by the rays at either end, with its exact value, and what it would be without the cosines."""
    from transport.viz.curves import draw_points
    from transport.viz.style import INK, PURPLE, with_unit

    for rank, (name, words, aside) in enumerate(
        ((L1, "$L_1$, rays that leave dA₁", -0.12), (L2, "$L_2$, rays that arrive at dA₂", 0.12))
    ):
        read = [o[name].estimate for o in outcomes]
        places = np.arange(len(outcomes)) + aside
        draw_points(
            axes, places, np.array([e.value for e in read]), np.array([e.error for e in read]), rank, words
        )
    for place, outcome in enumerate(outcomes):
        row, cosines = outcome[L1], math.cos(outcome.given["tilt_1"]) * math.cos(outcome.given["tilt_2"])
        reach = [place - 0.3, place + 0.3]
        axes.plot(reach, [row.exact] * 2, color=INK, lw=2.6, zorder=1, label="exact" if place == 0 else None)
        wrong = "wrong: without the cosines" if place == 0 else None
        axes.plot(reach, [row.exact * cosines] * 2, "--", color=PURPLE, lw=3, zorder=1, label=wrong)
    labels = [
        f"{math.degrees(o.given['tilt_1']):.3g}°, {math.degrees(o.given['tilt_2']):.3g}°\n{2 * o.given['size_1']:g}, {2 * o.given['size_2']:g} m"
        for o in outcomes
    ]
    axes.set(xticks=range(len(outcomes)), xticklabels=labels, xlim=(-0.5, len(outcomes) - 0.5))
    axes.set(
        ylim=(0, 1.5 * max(o[L1].exact for o in outcomes)),
        ylabel=with_unit("radiance", outcomes[0][L1].estimate.unit),
    )
    axes.set_xlabel(
        "θ₁, θ₂; sides of dA₁, dA₂, 1 m apart"
        if all(o.given["distance"] == 1 for o in outcomes)
        else "θ₁, θ₂; sides of dA₁, dA₂"
    )
    axes.legend(loc="upper center", ncols=2, columnspacing=1.0, fontsize=16)


def _draw_disks(axes, outcomes: list[Outcome]) -> None:
    """Two disks and the plane between them from beside, with all rays that each of them counted; or by random lines."""
    from transport.viz.exhibits import bare_panel
    from transport.viz.style import BLUE, GREEN, INK, ORANGE, PURPLE, VERMILLION
    from transport.viz.wording import number_text

    outcome = outcomes[0]
    one, two, distance = (outcome.given[name] for name in ("size_1", "size_2", "distance"))
    large, tall = max(one, two), 1.3
    near, far = one / large, two / large
    for start in np.linspace(-near, near, 4):
        for end in np.linspace(-far, far, 4):
            axes.plot([start, end], [0, tall], color=ORANGE, lw=1.4, zorder=1)
    axes.plot([-near, near], [0, 0], color=BLUE, lw=9, solid_capstyle="butt")
    axes.plot([-far, far], [tall, tall], color=VERMILLION, lw=9, solid_capstyle="butt")
    slope = math.tan(PLANE)
    if AT_2 in outcome:
        axes.plot([-1.1, 1.1], [tall / 2 - 1.1 * slope, tall / 2 + 1.1 * slope], "--", color=GREEN, lw=4)
    places = {
        AT_2: (tall, "counted at dA₂", VERMILLION), UP: (0.72 * tall, "through the plane, up", GREEN),
        DOWN: (0.42 * tall, "through the plane, down", GREEN), AT_1: (0.0, "counted at dA₁", BLUE),
        THERE: (tall, "random lines, 1 to 2", VERMILLION), BACK: (0.0, "random lines, 2 to 1", BLUE),
    }  # fmt: skip
    words = {"va": "center", "fontsize": 19, "linespacing": 1.2}
    for name, (height, label, colour) in places.items():
        if name in outcome:
            axes.text(1.3, height, f"{label}\n{number_text(outcome[name].estimate)}", color=colour, **words)
    row = outcome[AT_2 if AT_2 in outcome else THERE]
    middles = etendue.element_throughput(math.pi * one**2, 1.0, math.pi * two**2, 1.0, distance)
    axes.text(-1.1, -0.4, f"exact {row.exact:.5g}", color=INK, **words)
    axes.text(0.3, -0.4, f"wrong, by their middles: {middles:.3g}", color=PURPLE, **words)
    extra = next((o for o in outcomes[1:] if THERE in o), None)
    if extra is not None:
        pair = " and ".join(number_text(extra[name].estimate) for name in (THERE, BACK))
        axes.text(
            -1.1,
            -0.75,
            f"random lines, disks of {extra.given['size_1']:g} m: {pair}\nexact {extra[THERE].exact:.5g}",
            color=INK,
            **words,
        )
    axes.set_title(f"T of disks of {one:g} m and {two:g} m  [m² sr]")
    bare_panel(axes, (-1.15, 2.95), (-0.95, 1.55))


def _draw_chords(axes, outcomes: list[Outcome]) -> None:
    """Mean chords of bodies against 4V/S, with their sections."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import SKY

    x, seen = [o[CHORD].exact for o in outcomes], [o[CHORD].estimate for o in outcomes]
    plot_curves(
        Series(x, seen, lambda chord: chord), ax=axes, span=(0.0, 1.25 * max(x)),
        xlabel="4V/S of the body  [m]", ylabel="mean chord", legend="upper left",
    )  # fmt: skip
    axes.set(ylim=(0, 1.25 * max(x)), title="uniform lines through convex bodies")
    for place, outcome in zip(x, outcomes, strict=True):
        box = {
            "boxstyle": "circle" if outcome.given["body"] == "sphere" else "square",
            "fc": SKY,
            "ec": "none",
            "alpha": 0.5,
        }
        style = {"textcoords": "offset points", "ha": "center", "va": "center", "fontsize": 18, "bbox": box}
        axes.annotate(outcome.given["body"], (place, place), (55, -50), **style)


draw = figures(bias=(draw_bias, several(_alike)), laws=(draw_laws, others(several(_alike))))


if __name__ == "__main__":
    main(__file__)
