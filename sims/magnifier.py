"""Under a magnifying glass: radiance does not increase, irradiance in the focus does.

Derivation.  A lossless optic conserves throughput, and energy is conserved, so that radiance, their quotient, is the same
in front and behind (Hanrahan 2001, Stanford CS 348B, lecture 4, "Throughput", and quiz 1: "Does radiance increase under a
magnifying glass?  NO!!").  What changes is the cone of directions: of half angle θ_s in front, that of the page as the
glass sees it, and θ' behind, that of the glass as the focus sees it.  A small detector in the focus reads

    E = π L sin²θ'   where it read   E_s = π L sin²θ_s,   and never more than π L: concentration is at most 1/sin²θ_s.

Real glass reflects: each ray brings (1 − R₁)(1 − R₂) L with Fresnel's R at its two surfaces, and E is the integral of
that over the cone.  `events=2` counts what was refracted twice and no more; light that comes by reflections inside is
1e-4 of it and less.  The simulator and the exact values take light for unpolarised at each surface; if its polarisation
were followed, up to 1e-3 more would come through near the rim.

Exact values.  Traced back, every ray that meets the detector by the optic ends on the page (the scene is refused if one
does not), which is so large for that.  So the detector's mean E is π L F with the view factor F to the lens or to the
mirror's rim (Howell, C-41), without small angles: an aberration is a question of images, not of radiance.  For real
glass it is a quadrature over detector, window and azimuth (transport/theory/lenses.py).

Optics.  "ideal lens": `ThinLens`, which adds -x/f to direction cosines and conserves throughput by that.  What textbooks draw
adds it to tangents; by their lens radiance would grow by cos⁴θ/cos⁴θ', to 1.56 L at the rim of f/1, and E would be
π L tan²θ' (tests/experiments/test_magnifier.py simulates it, and sees it rejected).  "glass ball", with a black stop behind it, and
"biconvex lens", two caps on one rim.  "burning mirror": a paraboloid, whose cone may be a whole hemisphere: with
the sun for a page its focus receives π L, what the sun's own surface gives off (Winston, Miñano, Benítez 2005, 1.2).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import transport as tp
from transport.sims import figures, main, of_scene, one_of, require, where
from transport.theory import emitters, lenses, optical_paths
from transport.theory.optical_paths import Rays
from transport.verification.experiment import Outcome

law = "L behind = L in front × transmittance; E = π L sin²θ' (Straubel 1902; Hanrahan 2001; Winston et al. 2005, 1.2)"
question = "Does radiance increase under a magnifying glass, or in the focus of a burning mirror?"
particles = 4_000_000
intended = {
    "aim": "all light of the page that counts comes through the optic, at which it is aimed",
}

OPTICS = ("ideal lens", "glass ball", "biconvex lens", "burning mirror")
FOCAL = 0.1  # m, focal length (of small angles) of each
CONE = float(lenses.cone_of(1.0))  # of f/1
PAGE, SUN = math.radians(7), math.radians(0.2666)  # half angles that they cover
SUN_RADIANCE = emitters.surface_radiance(emitters.POWER, emitters.AREA)
FOCUS = 0.85  # where the biconvex lens' focus is taken, in focal lengths from its rim: light from all of it is near
STOP = 0.96  # the same for the ball's stop, in its back focal length: close below it
CM, HIGHEST = 100.0, 0.24  # of a metre; m, upper end of the figure
ANGLES = (0.3, 1, 3, 10, 30, 90)  # deg, of its ticks
FINE = 5  # bins in a third of the cone, all of equal projected solid angle
L_FRONT, GAIN = "radiance in front", "gain"
E_FRONT, E_FOCUS = "irradiance in front", "irradiance in the focus"
BEHIND = tuple(f"radiance behind, {part} third of the cone" for part in ("inner", "middle", "outer"))


class Optic(NamedTuple):
    """surfaces;  front: the disk that light for the focus comes by;  window, height: radius of the disk that a detector
    about the origin looks through, and its distance [m];  up: +1 where it looks up, at a lens;  steps: the way back."""

    surfaces: tuple[tp.Surface, ...]
    front: tp.Disk
    window: float
    height: float
    up: int
    steps: tuple[Callable[[Rays], Rays], ...]
    faces: tuple[lenses.Face, lenses.Face] | None = None

    @property
    def half_angle(self) -> float:
        """Of the cone of light behind it [rad]."""
        return math.atan2(self.window, self.height)

    def way_back(self, rays: Rays) -> list[Rays]:
        """The rays after each step, those given first."""
        path = [rays]
        for step in self.steps:
            path.append(step(path[-1]))
        return path

    def theta_edges(self, detector: float) -> np.ndarray:
        """Bins of equal projected solid angle: thirds of what all of the detector sees by the optic, and beyond [rad]."""
        within = math.sin(math.atan2(self.window - detector, self.height)) ** 2
        reach = math.sin(min(1.3 * math.atan2(self.window, self.height), math.pi / 2)) ** 2
        beyond = int(3 * FINE * (reach / within - 1))
        return np.arcsin(np.sqrt(within * np.arange(3 * FINE + beyond + 1) / (3 * FINE)))


def cases() -> list[dict[str, object]]:
    pages = [{"optic": "ideal lens"}, {"optic": "glass ball", "detector": 5e-3}, {"optic": "biconvex lens"}]
    burning = {"half_angle": SUN, "radiance": SUN_RADIANCE, "distance": 1000.0}
    cones = {
        "ideal lens": [(lenses.cone_of(3.0), 2e-4)],
        "burning mirror": [(lenses.cone_of(1.0), 4e-4), (math.pi / 2, 4e-4)],
    }
    suns = [(optic, cone, size) for optic, pairs in cones.items() for cone, size in pairs]
    return pages + [{"optic": o, "cone": float(cone), "detector": size} | burning for o, cone, size in suns]


def scene(
    optic: str = "ideal lens",
    cone: float = CONE,
    half_angle: float = PAGE,
    radiance: float = 100.0,
    index: float = 1.5,
    detector: float = 6e-3,
    distance: float = 10.0,
) -> tp.Scene:
    """A page, an optic, and a detector in its focus that sees it within `cone`, a half angle [rad]; at the origin.

    half_angle: of the page seen from the focus [rad], `distance` above it [m];  index: of the glass;  detector: its
    radius [m].
    """
    made = optic_of(optic, cone, index)
    page = tp.Disk(center=(0, 0, distance), normal=(0, 0, -1), radius=distance * math.tan(half_angle))
    _check_filled(made, detector, page)
    focus = tp.Disk(normal=(0, 0, made.up), radius=detector)
    edge = math.atan((page.radius - made.front.radius) / (distance - made.front.center[2]))
    page_alone = tp.Directions(theta=(0, edge))  # what all of it sees the page in
    front = tp.Detector(made.front, "front", directions=page_alone)
    seen, straight = tp.Directions(theta=made.theta_edges(detector)), None if made.faces is None else 2
    return tp.Scene(
        sources=tp.Source(page, tp.Lambertian(radiance=radiance), aim=made.front),
        surfaces=made.surfaces,
        detectors=[front, tp.Detector(focus, "focus", directions=seen, events=straight)],
    )


def optic_of(optic: str, cone: float, index: float) -> Optic:
    """The optic of that name, its focus at the origin.  Raises SceneError for a cone that it cannot have."""
    one_of("magnifier", optic=(optic, OPTICS))
    widest = math.pi / 2 if optic == "burning mirror" else math.pi / 4
    can_focus = optic not in ("glass ball", "biconvex lens") or 1 < index < 2
    require(
        "magnifier",
        cone=(cone, 0 < cone <= widest, f"in (0, {widest:.4g}] rad for optic {optic!r}"),
        index=(index, can_focus, "in (1, 2), so that light is focused behind"),
    )
    made = dict(zip(OPTICS, (_ideal, _ball, _biconvex, _mirror), strict=True))
    return made[optic](cone, index)


def _ideal(cone: float, _: float) -> Optic:
    lens = tp.Disk(center=(0, 0, FOCAL), radius=FOCAL * math.tan(cone))
    step = partial(optical_paths.bend, height=FOCAL, focal_length=FOCAL)
    surface = tp.Surface(lens, tp.ThinLens(FOCAL), name="lens")
    return Optic((surface,), _above(FOCAL, lens.radius), lens.radius, FOCAL, 1, (step,))


def _ball(cone: float, index: float) -> Optic:
    radius = FOCAL / lenses.ball_focal_length(1.0, index)
    height = STOP * lenses.ball_back_focal_length(radius, index)
    window = height * math.tan(cone)
    glass = tp.Surface(tp.Sphere(center=(0, 0, FOCAL), radius=radius), tp.Dielectric(index), name="lens")
    stop = tp.Surface(
        tp.Disk(center=(0, 0, height), inner_radius=window, radius=FOCAL), tp.Black(), name="stop"
    )
    front, faces = _above(FOCAL + radius, 0.72 * radius), lenses.ball(FOCAL, radius)
    return Optic((glass, stop), front, window, height, 1, lenses.steps(faces, index), faces)


def _biconvex(cone: float, index: float) -> Optic:
    """Two caps that meet on the rim; their curvature is that of a thin lens of this focal length."""
    height, curvature = FOCUS * FOCAL, 2 * (index - 1) * FOCAL
    rim = height * math.tan(cone)
    require("magnifier", cone=(cone, rim < curvature, f"below {math.atan(curvature / height):.4g} rad"))
    depth = math.sqrt((curvature - rim) * (curvature + rim))
    cap = {"radius": curvature, "mu_min": depth / curvature}
    lower, upper = (tp.Sphere(center=(0, 0, height - up * depth), axis=(0, 0, up), **cap) for up in (-1, 1))
    glass = tp.Dielectric(index)
    surfaces = tp.Surface(lower, glass, name="lens"), tp.Surface(upper, glass, name="upper face")
    front, faces = _above(height - depth + curvature, 1.01 * rim), lenses.biconvex(height, rim, curvature)
    return Optic(surfaces, front, rim, height, 1, lenses.steps(faces, index), faces)


def _mirror(cone: float, _: float) -> Optic:
    rim = 2 * FOCAL * math.tan(cone / 2)
    height = FOCAL * math.cos(cone) / math.cos(cone / 2) ** 2
    bowl = tp.Paraboloid(center=(0, 0, -FOCAL), focal_length=FOCAL, radius=rim)
    step = partial(optical_paths.reflect_in_paraboloid, vertex=-FOCAL, focal_length=FOCAL)
    front = _above(0.0, rim)
    return Optic((tp.Surface(bowl, tp.Mirror(), name="lens"),), front, rim, height, -1, (step,))


def _above(height: float, radius: float) -> tp.Disk:
    """A disk a little above this height and a little larger than this radius, that looks up."""
    return tp.Disk(center=(0, 0, height + 0.02 * FOCAL), radius=radius + 0.01 * FOCAL)


def seen_rays(optic: Optic, detector: float) -> Rays:
    """A grid of the rays that a detector of this radius sees by the optic, traced back from it."""
    if optic.up > 0:
        return optical_paths.between_disks(detector, 0.0, optic.window, optic.height)
    return optical_paths.between_disks(detector, 0.0, optic.window, lambda rho: rho**2 / (4 * FOCAL) - FOCAL)


def _check_filled(optic: Optic, detector: float, page: tp.Disk) -> None:
    """Refuse a page that does not fill all directions that the detector sees by the optic, or that stands in it."""
    height = page.center[2]
    entrance = optic.front.center[2]
    must = f"more than {entrance:g} m, where light enters the optic"
    require("magnifier", distance=(height, height > entrance, must))
    rays = optic.way_back(seen_rays(optic, detector))[-1]
    entering, reaching = (optical_paths.reach_at(rays, z) for z in (entrance, height))
    if not (detector < optic.window and entering <= optic.front.radius):  # nan where a ray misses the glass
        raise tp.SceneError(
            f"magnifier: cone must be smaller, or detector, got {detector} m: not all that it sees comes through the optic"
        )
    needed = max(optic.front.radius, reaching)
    if not needed < page.radius:
        raise tp.SceneError(
            f"magnifier: half_angle must be above {math.degrees(math.atan(needed / height)):.4g}°, got"
            f" {math.degrees(math.atan(page.radius / height)):.4g}°: a smaller page does not fill what the detector sees;"
            " or take a smaller detector or cone"
        )


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    front, focus = result["front"], result["focus"]
    thirds = [slice(FINE * k, FINE * (k + 1)) for k in range(3)]
    behind = {name: focus.radiance[third].sum() / FINE for name, third in zip(BEHIND, thirds, strict=True)}
    fluxes = {E_FRONT: front.irradiance, E_FOCUS: focus.irradiance, GAIN: focus.irradiance / front.irradiance}
    return {L_FRONT: front.radiance[0]} | behind | fluxes


@of_scene(scene)
def exact(optic, cone, half_angle, radiance, index, detector, distance) -> dict[str, float]:
    made, page = optic_of(optic, cone, index), distance * math.tan(half_angle)
    of_front = made.front.radius, distance - made.front.center[2]
    before = float(emitters.mean_disk_irradiance(radiance, page, *of_front))
    if made.faces is None:
        shares = np.ones(3)
        behind = float(emitters.mean_disk_irradiance(radiance, made.window, detector, made.height))
    else:
        thirds = made.theta_edges(detector)[: 3 * FINE + 1 : FINE]
        shares = lenses.mean_transmittances(made.faces, index, detector, thirds)
        seen = lenses.projected_solid_angle(made.faces, index, detector, made.window, made.height)
        behind = radiance * seen
    radiances = {name: radiance * float(share) for name, share in zip(BEHIND, shares, strict=True)}
    return {L_FRONT: radiance} | radiances | {E_FRONT: before, E_FOCUS: behind, GAIN: behind / before}


def verdict(outcomes: list[Outcome]) -> str:
    """How large radiance and irradiance are behind, of what they are in front."""
    shares = [f"{o[BEHIND[0]].estimate / o[L_FRONT].estimate} ({_name(o)})" for o in outcomes]
    gains = [f"{o[GAIN].estimate.value:.5g}" for o in outcomes]
    return f"No: of the radiance in front there is behind {', '.join(shares)}; irradiance grows {', '.join(gains)}-fold."


def _half_angle(outcome: Outcome) -> float:
    return float(outcome.given["half_angle"])


def _is_sun(outcome: Outcome) -> bool:
    return _half_angle(outcome) < 5 * SUN


def _optic(outcome: Outcome) -> Optic:
    return optic_of(*(outcome.given[name] for name in ("optic", "cone", "index")))


def _name(outcome: Outcome) -> str:
    return f"{'sun' if _is_sun(outcome) else 'page'}, {outcome.given['optic']}"


def _pages(outcomes: list[Outcome]) -> list[Outcome]:
    return [o for o in where(optic=OPTICS[:-1])(outcomes) if not _is_sun(o)]


def draw_glasses(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Rays under each lens, and below it radiance behind over that in front by direction."""
    from transport.viz.style import figure

    title = "Under a magnifying glass: light from more directions, of no more radiance"
    with figure((1.6 + 6.4 * len(outcomes), 14.4), title, note, path) as page:
        rows = {"height_ratios": (1.5, 1), "sharey": "row", "squeeze": False}
        for section, chart, outcome in zip(*page.subplots(2, len(outcomes), **rows), outcomes, strict=True):
            _draw_section(section, _optic(outcome), outcome)
            _draw_radiance(chart, _optic(outcome), outcome)
            section.set_title(outcome.given["optic"])
            chart.get_legend().remove()
        page.axes[0].set_ylabel("height  [cm]")
        drawn = [zip(*axes.get_legend_handles_labels(), strict=True) for axes in page.axes]
        found = {words: line for each in drawn for line, words in each}
        page.legend(found.values(), found.keys(), loc="outside lower center", ncols=3)


def cross_sections(shapes: Iterable[tp.Shape]) -> list[np.ndarray]:
    """Where disks and caps about the z axis meet the plane y = 0, each (n, 2) of x and z [m]; caps of one body as one."""
    flat, arcs = [], []
    for shape in shapes:
        x, _, z = shape.center
        if isinstance(shape, tp.Sphere):
            half = math.acos(shape.mu_min)
            turn = math.pi / 2 * shape.axis[2] + np.linspace(half, -half, 201)
            arcs.append(np.stack([x + shape.radius * np.cos(turn), z + shape.radius * np.sin(turn)], axis=-1))
        elif shape.inner_radius > 0:
            flat += [np.array([[side * shape.inner_radius, z], [side * shape.radius, z]]) for side in (-1, 1)]
        else:
            flat.append(np.array([[-shape.radius, z], [shape.radius, z]]))
    return flat + ([np.concatenate(arcs)] if arcs else [])


def _draw_section(axes, optic: Optic, outcome: Outcome) -> None:
    """Rays to the middle of the focus, and the cones of directions in front and behind as wedges."""
    from matplotlib.patches import Wedge

    from transport.viz.style import BLUE, INK, ORANGE, SKY, VERMILLION

    across = np.linspace(-0.97, 0.97, 13) * optic.window
    targets = np.stack([across, 0 * across, np.full_like(across, optic.height)], axis=-1)
    rays = optic.way_back(optical_paths.from_to(np.zeros(3), targets))
    rays.append(optical_paths.to_plane(rays[-1], 2.5 * FOCAL))
    for line in np.stack([each.points[:, [0, 2]] for each in rays], axis=1):
        axes.plot(*(CM * line).T, color=VERMILLION, lw=1.3, zorder=2)
    shapes = [surface.shape for surface in outcome.result.scene.surfaces]
    outlines = [CM * each for each in cross_sections(shapes)]
    for outline in outlines:
        if len(outline) > 2:
            axes.fill(*outline.T, fc=SKY, ec=INK, lw=1.8, alpha=0.45, zorder=3)
        else:
            axes.plot(*outline.T, color=INK, lw=3.5, zorder=3)
    top = max(outline[:, 1].max() for outline in outlines)
    in_front = "θ$_s$", _half_angle(outcome), top + 0.4, 6.0, ORANGE
    cones = [in_front, ("θ'", optic.half_angle, 0.0, 3.0, BLUE)]
    for name, half_angle, foot, length, colour in cones:
        turn, style = np.degrees(half_angle), {"fc": colour, "ec": colour, "alpha": 0.5, "zorder": 1}
        axes.add_patch(Wedge((0, foot), length, 90 - turn, 90 + turn, **style))
        box = {"fc": "white", "ec": "none", "pad": 1.5, "alpha": 0.85}
        style = {"color": colour, "va": "center", "fontweight": "bold", "bbox": box, "zorder": 5}
        axes.text(2.2, foot + (4.0 if foot else 0.6), f"{name} = {turn:.3g}°", **style)
    axes.set(aspect="equal", xlim=(-8, 8), ylim=(-0.8, 100 * HIGHEST), xlabel="x  [cm]")


def _draw_radiance(axes, optic: Optic, outcome: Outcome) -> None:
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import ORANGE

    seen = outcome.result["focus"].radiance / outcome[L_FRONT].estimate
    theta, radius = np.linspace(0, seen.coords["theta"][-1], 2001), outcome.given["detector"]
    shares = optical_paths.seen_through(
        lambda rays: optic.way_back(rays)[-1], radius, optic.window, optic.height, theta
    )
    fine = np.linspace(0, optic.half_angle, 501)
    fault = np.degrees(fine), lenses.tangent_lens_radiance(1.0, 0.0, fine)
    sines = np.sin(seen.coords["theta"]) ** 2
    halves = np.arcsin(np.sqrt((sines[1:] + sines[:-1]) / 2))  # of the bins' projected solid angles
    series = {"behind": Series(np.degrees(halves), seen, (np.degrees(theta), shares))}
    guides = {} if optic.faces else {"if the lens mapped tangents": fault}
    words = {"xlabel": "polar angle θ  [deg]", "ylabel": "radiance / that in front", "legend": "best"}
    plot_curves(series, ax=axes, guides=guides, **words)
    front = [0, math.degrees(_half_angle(outcome))]
    axes.fill_between(front, 1, color=ORANGE, alpha=0.35, lw=0, label="in front")
    axes.set_ylim(0, 1.65)


def draw_limit(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Irradiance over π L by the half angle of the cone of light, an arrow from front to focus each."""
    from transport.viz.style import HATCHING, INK, MUTED, PURPLE, figure, tick_log

    first, top = 0.6 * math.degrees(min(map(_half_angle, outcomes))), 8.0
    fine = np.geomspace(first, 90, 2001)
    title = "In the focus: E = π L sin²θ', and never more than π L"
    with figure((14, 9.6), title, note, path) as page:
        axes = page.subplots()
        axes.plot(fine, np.sin(np.radians(fine)) ** 2, color=INK, lw=2.2, label="sin²θ")
        steep, words = fine[fine < 75], "tan²θ', of a lens that maps tangents"
        axes.plot(steep, np.tan(np.radians(steep)) ** 2, "--", color=PURPLE, lw=2.6, label=words, zorder=1.5)
        axes.axhspan(1, top, fc="none", ec="#b0b0b0", hatch=HATCHING, lw=0, zorder=0.5)
        words, box = "more than the source itself gives off, π L", {"fc": "white", "ec": "none"}
        axes.text(first * 1.1, 2.1, words, color=MUTED, bbox=box)
        for rank, outcome in enumerate(outcomes):
            _draw_spot(axes, outcome, rank)
        axes.set(
            xscale="log", yscale="log", xlim=(first, 130), ylim=(0.4 * np.sin(np.radians(first)) ** 2, top)
        )
        axes.set_xticks(ANGLES, [f"{angle:g}" for angle in ANGLES])
        axes.minorticks_off()
        tick_log(axes.yaxis)
        axes.set_xlabel("half angle of the cone that light comes from  [deg]")
        axes.set_ylabel("irradiance / π L")
        axes.legend(loc="upper left", bbox_to_anchor=(0.01, 0.85))


def _draw_spot(axes, outcome: Outcome, rank: int) -> None:
    """Both places and the arrow between, with the gain on it."""
    from transport.viz.style import POINTS, look

    (colour, marker), unit = look(rank), math.pi * outcome.given["radiance"]
    ends = outcome[E_FRONT].estimate, outcome[E_FOCUS].estimate
    x = np.degrees([_half_angle(outcome), _optic(outcome).half_angle])
    y, bars = [end.value / unit for end in ends], [2 * end.error / unit for end in ends]
    arrow = {"arrowstyle": "-|>", "color": colour, "lw": 1.8, "shrinkA": 6, "shrinkB": 8}
    arrow |= {"mutation_scale": 20, "connectionstyle": f"arc3,rad={0.12 + 0.07 * rank}"}
    axes.annotate("", (x[1], y[1]), (x[0], y[0]), arrowprops=arrow, zorder=2)
    gain = f"{_name(outcome)}: {y[1] / y[0]:.5g}-fold"
    axes.errorbar(x, y, bars, fmt=marker, color=colour, label=gain, zorder=4, **POINTS)


draw = figures(glasses=(draw_glasses, _pages), limit=draw_limit)


if __name__ == "__main__":
    main(__file__)
