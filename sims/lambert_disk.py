"""Lambert's disk: the power of a diffuse emitter, its irradiance, and radiance that does not change along a ray.

Derivation.  A diffuse emitter has the same radiance L in all directions, so that its power is L A ∫ cosθ dω = π L A
(Bala 2009, Cornell CS 6620, lecture 2, "Diffuse emitter").  A ray that leaves one element for another counts as much
at either end, d²Φ = L dω₁ dA₁ cosθ₁ = L dω₂ dA₂ cosθ₂: the radiance that arrives is the one that left (Hanrahan 2001,
Stanford CS 348B, lecture 4, "1st law").  Seen from a point the disk is a patch of directions of radiance L before a
background of 0, at every distance; the irradiance is L times the projected solid angle of the patch,

    E = π L sin²θ on the axis, with tanθ = R/d;   E = (π L/2) (1 - T/S) at the offset x from it,

with T = x² + d² - R², S² = (x² + d² + R²)² - 4 x² R² (Foote 1915).  Over a coaxial meter the mean is π L F, where F
is the view factor from the meter to the disk (Howell, C-41).  Nor does radiance grow towards the horizon, "as the
cosine goes to 0": what flows through the patch falls with the same cosine.

Scene.  The disk, and a parallel meter of half a millimetre, at which the directions are aimed.  The bins keep away
from the disk's rim by the meter's radius a: below atan((R - a)/d) a ray surely meets the disk, above atan((R + a)/d)
surely not.  Off the axis, where the point's E stands for the meter's mean, the two differ by about (a/2d)² ≲ 1e-6.
At the distance 0 the meter is the disk itself, which counts what leaves it, to 89°.

Turning the sheet.  The meter is turned by an angle θ to the line of sight: the flux through it falls with cosθ, and so
does the area that it shows, dA⊥ = dA cosθ.  The radiance stays, to 89.9° (Akenine-Möller, Haines, Hoffman 2008, eq. 7.5;
the sheet of paper is Scratchapixel's).  From 1000 m the whole disk stays above the sheet's horizon; from half a metre
the horizon cuts the disk in two, and what is seen of it does not go to 0.

Three ways.  L = d²Φ/(dA⊥ dω) = dE⊥/dω = dI/dA⊥ (Akenine-Möller, Haines, Hoffman 2008, eq. 7.4 and 7.6), along a ray that
leaves at 30°: through a meter parallel to the disk, as irradiance on one across the ray, and as intensity of a part of
the disk.  dω is a cone of half angle α about the ray that meets the disk from all of the meter.  The first is divided by
∫cosθ dω and is L; the others hold the mean cosine to the ray, (1 + cosα)/2, which tends to 1 with dω.

A ball.  From each direction a small ball receives what falls on its section π r², so that it reads the fluence rate,
φ = ∫ L dω = Φ/(π r²), which is how fluence is defined (ICRU Report 85, 2011).  For this disk it need not be small: the
view factor from a ball to the disk is the disk's solid angle over 4π, whatever the ball's radius (Howell, C-136).
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import transport as tp
from transport.geometry import solid_angles as solid_angles_geometry
from transport.sims import (
    constant,
    curves_figure,
    figures,
    holding,
    in_space,
    main,
    of_scene,
    one_of,
    provenance,
    require,
    where,
)
from transport.theory import emitters, solid_angles
from transport.verification.experiment import Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from transport.viz.solid_panel import SolidPanel

law = (
    "P = π L A, E = π L sin²θ, radiance invariant along a ray, L = d²Φ/dA⊥dω = dE⊥/dω = dI/dA⊥, φ = Φ/πr²"
    " (Bala 2009, Cornell CS 6620; Foote 1915; Akenine-Möller, Haines, Hoffman 2008, eq. 7.6)"
)
question = "What reaches a meter from a diffuse disk, and does its radiance depend on the distance?"
particles = 4_000_000

METER = 5e-4  # m, radius of the meter
LEAVING = np.radians([0, 30, 60, 80, 89])  # edges of bins
# Of the hemisphere, for the picture; the disk's rim lies within a bin, not on an edge.
MAP = tp.Directions(theta=31, phi=48)
INSIDE = 4  # bins within the disk's cone
READINGS = ("parallel", "turned", "three ways", "ball")
RAY, CONE = math.radians(30), math.radians(25)  # of the three ways: the ray's angle, and half that of dω
PALE_RAY = "#f6ddb0"  # of rays that pass the sheet
THREE_WAYS = LEVEL, ACROSS, PART = "d²Φ/dA⊥dω", "dE⊥/dω", "dI/dA⊥"
BALL, IN_CONE = "fluence rate, Φ/πr²", "radiance, cone in the disk"


def cases() -> list[dict[str, float]]:
    on_axis = [{"distance": distance} for distance in (0.0, 0.1, 0.5, 2.0, 20.0)]
    off_axis = [{"distance": 0.5, "offset": 0.5}, {"distance": 2.0, "offset": 1.5}]
    turned = [(1000.0, 60), (1000.0, 80), (1000.0, 89), (1000.0, 89.9), (0.5, 89.9)]
    return [
        *on_axis,
        *off_axis,
        *({"reading": "turned", "distance": distance, "tilt": angle * tp.deg} for distance, angle in turned),
        {"reading": "three ways"},
        *({"reading": "ball", "distance": 0.5, "ball": ball} for ball in (0.1, 0.9)),
    ]


def scene(
    radiance: float = 100.0,
    radius: float = 0.5,
    distance: float = 2.0,
    offset: float = 0.0,
    reading: str = "parallel",
    tilt: float = 1.5,
    ball: float = 0.1,
) -> tp.Scene:
    """A disk and a meter `distance` above it, `offset` from its axis [m]; at the distance 0 the meter is the disk.

    reading: by a meter "parallel" to the disk; by one on the axis, "turned" by `tilt` [rad]; in "three ways", near the
    disk; by a "ball" on the axis, its radius the share `ball` of the distance.
    """
    one_of("lambert_disk", reading=(reading, READINGS))
    must = "0 or more, as the disk emits towards +z"
    require("lambert_disk", distance=(distance, distance >= 0, must))
    disk, emission = tp.Disk(radius=radius), tp.Lambertian(radiance=radiance)
    if distance == 0:
        detectors, aim = tp.Detector(disk, name="meter", directions=tp.Directions(theta=LEAVING)), None
    elif reading == "three ways":
        detectors, aim = _three_ways(radius), None
    elif reading == "ball":
        detectors, aim = _ball(distance, ball)
    elif reading == "turned":
        detectors, aim = _turned(radius, distance, tilt)
    else:
        detectors, aim = _parallel(radius, distance, offset)
    return tp.Scene(sources=tp.Source(disk, emission, aim=aim), detectors=detectors)


def _parallel(radius: float, distance: float, offset: float) -> tuple[list[tp.Detector], tp.Disk]:
    meter = tp.Disk(center=(offset, 0, distance), normal=(0, 0, -1), radius=METER)
    detectors = [tp.Detector(meter, name="meter", directions=_directions(radius, distance, offset))]
    if offset != 0:
        detectors.append(tp.Detector(meter, name="map", directions=MAP))
    return detectors, meter


def _turned(radius: float, distance: float, tilt: float) -> tuple[tp.Detector, tp.Disk]:
    """The largest cone within the disk, from all of the meter."""
    meter = tp.Disk(center=(0, 0, distance), normal=(math.sin(tilt), 0, -math.cos(tilt)), radius=METER)
    cone = tp.Directions.cone((0, 0, -1), math.atan((radius - METER) / (distance + METER)))
    return tp.Detector(meter, name="turned", directions=cone), meter


def _ball(distance: float, share: float) -> tuple[tp.Detector, tp.Sphere]:
    must = "between 0 and 1, a share of its distance from the disk"
    require("lambert_disk", ball=(share, 0 < share < 1, must))
    sphere = tp.Sphere(center=(0, 0, distance), radius=share * distance)
    return tp.Detector(sphere, name="ball"), sphere


def _three_ways(radius: float) -> list[tp.Detector]:
    """Two meters on the ray, parallel to the disk and across the ray, and the middle of the disk itself."""
    ray = (math.sin(RAY), 0, math.cos(RAY))
    place, small = [radius / 4 * x for x in ray], 0.3 * radius
    level = tp.Disk(center=place, normal=(0, 0, -1), radius=small)
    across = tp.Disk(center=place, normal=[-x for x in ray], radius=small)
    arriving, leaving = (tp.Directions.cone([sign * x for x in ray], CONE) for sign in (-1, 1))
    part = tp.Positions(u=(0, radius / 2))
    return [
        tp.Detector(level, LEVEL, directions=arriving),
        tp.Detector(across, ACROSS, directions=arriving),
        tp.Detector(tp.Disk(radius=radius), PART, directions=leaving, positions=part),
    ]


def _directions(radius: float, distance: float, offset: float) -> tp.Directions:
    """Bins round the axis, all but one within the disk or outside of it; or the largest cone round the disk's middle."""
    if offset == 0:
        return tp.Directions(theta=theta_edges(radius, distance))
    middle, rim = math.atan(offset / distance), math.atan((offset + radius - METER) / distance)
    return tp.Directions.cone((-offset, 0, -distance), rim - middle)


def theta_edges(radius: float, distance: float) -> np.ndarray:
    """INSIDE bins of equal projected solid angle up to the rim, one across it, one to the horizon [rad]."""
    within, beyond = math.atan((radius - METER) / distance), math.atan((radius + METER) / distance)
    inside = np.arcsin(math.sin(within) * np.sqrt(np.arange(INSIDE + 1) / INSIDE))
    return np.array([*inside, beyond, math.pi / 2])


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    if "turned" in result:
        return {"irradiance": result["turned"].irradiance, IN_CONE: result["turned"].radiance[0]}
    if "ball" in result:
        section = math.pi * result["ball"].detector.shape.radius ** 2
        return {BALL: result["ball"].flux_in / constant(result, section, "m^2")}
    return _read_three_ways(result) if LEVEL in result else _read_meter(result)


def _read_three_ways(result: tp.Result) -> dict[str, tp.Estimate]:
    level, across, part = (result[name] for name in THREE_WAYS)
    shown = math.pi * part.detector.positions.u[-1] ** 2 * math.cos(RAY)
    intensity = part.intensity_out[0, 0] / constant(result, shown, "m^2")
    return {LEVEL: level.radiance[0], ACROSS: across.flux_density[0], PART: intensity}


def _read_meter(result: tp.Result) -> dict[str, tp.Estimate]:
    meter = result["meter"]
    if result.scene.sources[0].aim is None:
        leaving = {_bin("radiance leaving", LEAVING, i): each for i, each in enumerate(meter.radiance_out)}
        return {"power": meter.flux_out, "exitance": meter.exitance} | leaving
    rows = {"irradiance": meter.irradiance}
    if len(meter.radiance) == 1:
        return rows | {IN_CONE: meter.radiance[0]}
    edges = meter.radiance.coords["theta"]
    inside = {_bin("radiance in the disk", edges, i): meter.radiance[i] for i in range(INSIDE)}
    return rows | inside | {"radiance beside it": meter.radiance[-1], "fluence rate": meter.fluence_rate}


@of_scene(scene)
def exact(
    radiance: float, radius: float, distance: float, offset: float, reading: str, tilt: float
) -> dict[str, float]:
    if distance == 0:
        area = math.pi * radius**2
        power = emitters.lambert_power(radiance, area)
        leaving = {_bin("radiance leaving", LEAVING, i): radiance for i in range(len(LEAVING) - 1)}
        return {"power": power, "exitance": power / area} | leaving
    if reading == "three ways":
        mean = radiance * (1 + math.cos(CONE)) / 2
        return {LEVEL: radiance, ACROSS: mean, PART: mean}
    fluence_rate = float(radiance * solid_angles.disk_solid_angle(radius, distance))
    if reading == "ball":
        return {BALL: fluence_rate}
    if reading == "turned":
        seen = solid_angles_geometry.cone_projected_solid_angle(math.atan(radius / distance), math.cos(tilt))
        return {"irradiance": float(radiance * seen), IN_CONE: radiance}
    if offset != 0:
        irradiance = emitters.disk_irradiance(radiance, radius, distance, abs(offset))
        return {"irradiance": float(irradiance), IN_CONE: radiance}
    edges = theta_edges(radius, distance)
    return {
        "irradiance": float(emitters.mean_disk_irradiance(radiance, radius, METER, distance)),
        **{_bin("radiance in the disk", edges, i): radiance for i in range(INSIDE)},
        "radiance beside it": 0.0,
        "fluence rate": fluence_rate,
    }


def _bin(quantity: str, edges: np.ndarray, index: int) -> str:
    low, high = np.degrees(edges[index : index + 2])
    return f"{quantity}, θ {low:.4g}° to {high:.4g}°"


def verdict(outcomes: list[Outcome]) -> str:
    rows = [row for o in outcomes for row in o.rows]
    scores = [row.z for row in rows if row.name.startswith(("radiance", *THREE_WAYS, BALL)) and row.exact]
    irradiances = [row.estimate.value for row in rows if row.name == "irradiance"]
    fall = max(irradiances, default=1) / min(irradiances, default=1)
    also = f" while the irradiance falls {fall:.3g}-fold" if fall != 1 else ""
    off = f"the furthest {np.abs(scores).max():.1f} standard errors off"
    return f"Radiance is L in all {len(scores)} readings, {off}{also}."


@curves_figure(
    title="A Lambert disk seen from several distances: the same radiance",
    xlabel="polar angle θ  [deg]",
    ylabel="radiance L",
    log_x=True,
    span=(0.3, 90),
)
def draw_distances(outcomes: list[Outcome]) -> dict[str, object]:
    """Radiance by polar angle, seen from the axis."""
    from transport.viz.directions import polar_curves

    curves, laws = {}, {}
    for outcome in outcomes:
        of = outcome.given
        rim, label = math.atan(of["radius"] / of["distance"]), f"at {of['distance']:g} m"
        curves[label] = outcome.result["meter"].radiance
        laws[label] = lambda theta, rim=rim, level=of["radiance"]: np.where(theta < rim, level, 0.0)
    return {"series": polar_curves(curves, laws)}


def draw_map(outcomes: list[Outcome], **out: object) -> None:
    """The disk as the meter off its axis sees it: L within an oval, 0 beside it, and how well that is known."""
    from transport.viz.maps import plot_map

    of, seen = outcomes[0].given, outcomes[0].result["map"]
    offset, distance = of["offset"], of["distance"]

    def exact_radiance(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
        """The radiance of the disk's plane where the direction meets it; e_u is -x, e_v is +y."""
        x, y = offset - distance * np.tan(theta) * np.cos(phi), distance * np.tan(theta) * np.sin(phi)
        return np.where(np.hypot(x, y) < of["radius"], of["radiance"], 0.0)

    out["note"] = provenance(outcomes[:1])
    title = f"A Lambert disk seen from {distance:g} m above it and {offset:g} m off its axis"
    plot_map(seen, quantity="radiance", label="radiance L", exact=exact_radiance, cut=0.0, title=title, **out)


def draw_turned(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Irradiance over that face on, which falls with the cosine as the area that the sheet shows, and radiance, which stays."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import figure

    with figure((13.5, 9.4), "The sheet turned away: E falls as dA⊥ does, and L stays", note, path) as page:
        chart = page.subplots()
        whole = [o for o in outcomes if _is_whole(o)]
        shares = [o["irradiance"].estimate / _face_on(o) for o in whole]
        radiances = [_over_level(o) for o in outcomes]
        cosines = [math.cos(o.given["tilt"]) for o in outcomes]
        series = {"radiance L = d²Φ/(dA⊥dω)": Series(cosines, radiances, lambda mu: 1 + 0 * mu)}
        if whole:
            series["irradiance E, as dA⊥"] = Series(
                [math.cos(o.given["tilt"]) for o in whole], shares, lambda mu: mu
            )
        least = min(cosines)
        plot_curves(
            series, ax=chart, guides={"wrong: L grows as 1/cosθ": lambda mu: 1 / mu}, span=(least, 1.0), log_x=True, log_y=True,
            xlabel="θ, the sheet turned by", ylabel="over that face on", legend="lower left",
        )  # fmt: skip
        chart.set(xlim=(1.2, 0.7 * least), ylim=(0.4 * least, 2 / least))
        marks = {math.cos(math.radians(angle)): f"{angle:g}°" for angle in (0, 60, 80, 89, 89.9)}
        chart.set_xticks(list(marks), list(marks.values()))
        chart.minorticks_off()


def _face_on(outcome: Outcome) -> tp.Estimate:
    """The exact irradiance of the sheet face on."""
    of = outcome.given
    seen = solid_angles.disk_projected_solid_angle(of["radius"], of["distance"])
    return constant(outcome.result, of["radiance"] * seen, "W m^-2")


def _over_level(outcome: Outcome) -> tp.Estimate:
    """The radiance that was read over that of the disk."""
    return outcome[IN_CONE].estimate / constant(outcome.result, outcome.given["radiance"], "W m^-2 sr^-1")


def _sheets(outcomes: list[Outcome]) -> list[Outcome]:
    """Turned sheets that are drawn in space."""
    turned = [o for o in where(reading="turned")(outcomes) if _is_whole(o)]
    return [o for o in turned if abs(math.degrees(o.given["tilt"])) <= 80][:2]


def draw_sheets(outcomes: list[Outcome], path: Path, note: str) -> None:
    """A sheet in a beam, face on and turned: the light that it takes out of the beam, and what was read on it."""
    from transport.viz.solid_panel import SolidPanel
    from transport.viz.style import figure

    with figure(
        (6 * (1 + len(outcomes)), 9.6),
        "dA⊥ = dA cosθ: a turned sheet takes no more light than its shadow",
        note,
        path,
    ) as page:
        row = page.subplots(1, 1 + len(outcomes), squeeze=False)[0]
        for axes, outcome in zip(row, (None, *outcomes), strict=True):
            panel, tilt = SolidPanel(viewer=(0.35, -1, 0.42)), 0.0
            words = "face on, θ = 0°\nE = E₀\nL = L₀"
            if outcome is not None:
                tilt = outcome.given["tilt"]
                share, level = outcome["irradiance"].estimate / _face_on(outcome), _over_level(outcome)
                words = (
                    f"θ = {math.degrees(tilt):.3g}°,  cosθ = {math.cos(tilt):.4f}\n"
                    f"E/E₀ = {_four_places(share)}\nL/L₀ = {_four_places(level)}"
                )
            _place_sheet(panel, tilt)
            panel.show(axes, [(-1.05, -1.2), (1.05, 1.62)])
            axes.set_title(words, linespacing=1.4)


def _four_places(ratio: tp.Estimate) -> str:
    """A ratio with four decimals, and with its error if that is seen there."""
    from transport.viz.wording import number_text

    return number_text(ratio) if ratio.error > 5e-5 else f"{ratio.value:.4f}"


def _place_sheet(panel: SolidPanel, tilt: float) -> None:
    """Rays that come down on a turned square, its normal, and its shadow on the ground with the outline of that face on."""
    from transport.viz.solid_panel import LABEL
    from transport.viz.style import BLUE, INK, MUTED, ORANGE

    half, low, high = 0.6, -0.85, 1.45
    normal, along = (
        np.array([math.sin(tilt), 0, math.cos(tilt)]),
        np.array([math.cos(tilt), 0, -math.sin(tilt)]),
    )
    corners = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)])
    sheet = half * (corners[:, :1] * along + corners[:, 1:] * [0, 1, 0])
    ground, shadow = (half * (corners * (c, 1)) for c in (1.0, math.cos(tilt)))
    ground, shadow = (np.column_stack([each, np.full(4, low)]) for each in (ground, shadow))
    panel.loop(ground, MUTED, 0.008, is_dashed=True)
    panel.polygon(shadow, BLUE)
    for top, foot in zip(sheet, shadow, strict=True):
        panel.line([top, foot], BLUE, 0.006, is_dashed=True)
    for x in np.linspace(-0.8, 0.8, 5) * half:
        for y in np.linspace(-0.8, 0.8, 3) * half:
            reach = -x * math.tan(tilt) if abs(x) <= half * math.cos(tilt) else low
            is_caught = abs(x) <= half * math.cos(tilt)
            panel.arrow((x, y, high), (0, 0, reach - high), ORANGE if is_caught else PALE_RAY, 0.025)
    panel.polygon(sheet, "#f7f4ec")
    panel.loop(sheet, INK, 0.014)
    panel.arrow((0, 0, 0), 0.75 * normal, INK, 0.04, "n")
    panel.text(sheet[1] - 0.12 * along + (0, 0, -0.12), "dA", **LABEL)
    panel.text((0, -half, low - 0.16), "dA⊥", color=BLUE, **LABEL)


def draw_ways(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Three ways to read the radiance, against the half angle of dω."""
    from transport.viz.style import figure

    with figure((14.5, 9.4), "Three quotients, one limit: the radiance", note, path) as page:
        sketch, chart = page.subplots(1, 2, width_ratios=[1, 1.5])
        _draw_detectors(sketch)
        _draw_quotients(chart, outcomes[0])


def _draw_detectors(axes) -> None:
    """The disk, the ray with the cone dω about it, and the two detectors on it."""
    from matplotlib.patches import Wedge

    from transport.viz.exhibits import bare_panel, draw_arrow
    from transport.viz.style import BLUE, GREEN, INK, ORANGE, VERMILLION

    ray, across = np.array([math.sin(RAY), math.cos(RAY)]), np.array([math.cos(RAY), -math.sin(RAY)])
    middle, place = math.degrees(math.pi / 2 - RAY), 1.5 * ray
    axes.plot([-1, 1], [0, 0], color=ORANGE, lw=9, solid_capstyle="butt")
    axes.plot([-0.3, 0.3], [0, 0], color=GREEN, lw=9, solid_capstyle="butt")
    turn = math.degrees(CONE)
    axes.add_patch(Wedge((0, 0), 0.9, middle - turn, middle + turn, color=GREEN, alpha=0.3, lw=0))
    axes.add_patch(Wedge(place, 0.7, middle + 180 - turn, middle + 180 + turn, color=BLUE, alpha=0.3, lw=0))
    draw_arrow(axes, (0, 0), 1.95 * ray, INK, 2.5)
    axes.plot(*np.stack([place - 0.4 * across, place + 0.4 * across], axis=1), color=VERMILLION, lw=7)
    axes.plot(place[0] + np.array([-0.42, 0.42]), [place[1]] * 2, color=BLUE, lw=7)
    words = {"fontsize": 20, "va": "center"}
    axes.text(0.2, 1.33, LEVEL, color=BLUE, ha="right", **words)
    axes.text(1.16, 1.0, ACROSS, color=VERMILLION, ha="center", **words)
    axes.text(0, -0.2, PART, color=GREEN, ha="center", **words)
    axes.text(0.4, 0.42, "dω", color=INK, ha="center", **words)
    bare_panel(axes, (-1.05, 1.5), (-0.35, 1.85))


def _draw_quotients(axes, outcome: Outcome) -> None:
    """The three quotients and their common limit, dashed the one that takes dA for dA⊥."""
    from transport.viz.curves import draw_points
    from transport.viz.style import INK, PURPLE, with_unit

    level, angles = outcome.given["radiance"], np.linspace(0, 40, 201)
    mean = (1 + np.cos(np.radians(angles))) / 2
    axes.plot(angles, level + 0 * angles, color=INK, lw=2.6)
    axes.plot(angles, level * mean, color=INK, lw=2.6)
    axes.plot(angles, level * math.cos(RAY) * mean, "--", color=PURPLE, lw=3, label="wrong: dA for dA⊥")
    for rank, (name, aside) in enumerate(zip(THREE_WAYS, (0, -0.8, 0.8), strict=True)):
        read, colour = outcome[name].estimate, (0, 1, 2)[rank]
        place = np.array([math.degrees(CONE) + aside])
        draw_points(axes, place, np.array([read.value]), np.array([read.error]), colour, name)
    axes.plot(0, level, "*", color=INK, ms=26, clip_on=False, label="limit L", zorder=5)
    axes.set(xlim=(-1, 40), ylim=(0.7 * level, 1.04 * level), xlabel="half angle of dω  [deg]")
    axes.set_ylabel(with_unit("quotient", outcome[LEVEL].estimate.unit))
    axes.legend(loc="lower left", title="points ± 2 standard errors", title_fontsize="small")


def draw_balls(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The disk and the balls before it from the side, to scale, and what each reads; dashed what a flat detector reads there."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import figure

    of = outcomes[0].given
    flat = emitters.disk_irradiance(of["radiance"], of["radius"], of["distance"])
    level = float(of["radiance"] * solid_angles.disk_solid_angle(of["radius"], of["distance"]))
    balls, seen = [o.given["ball"] for o in outcomes], [o[BALL].estimate for o in outcomes]
    title = "Fluence rate φ = Φ/πr²: a ball of any size reads the same before a disk"
    with figure((19, 8.2), title, note, path) as page:
        sketch, chart = page.subplots(1, 2, width_ratios=(1.6, 1))
        _draw_spheres(sketch, outcomes)
        plot_curves(
            Series(balls, seen, lambda x: level + 0 * x), ax=chart, span=(0.0, 1.0), legend="lower center",
            guides={"wrong: irradiance there": lambda x: flat + 0 * x}, xlabel="radius r of the ball / its distance",
            ylabel="fluence rate Φ/πr²",
        )  # fmt: skip
        chart.set(ylim=(0, 1.12 * level))


def _draw_spheres(axes: Axes, outcomes: list[Outcome]) -> None:
    """Section along the axis: the disk, the balls round one place, rays from the disk, and the readings."""
    from matplotlib.patches import Circle

    from transport.viz.exhibits import bare_panel
    from transport.viz.style import INK, MUTED, ORANGE, look
    from transport.viz.wording import number_text, unit_label

    radius, distance = (outcomes[0].given[name] for name in ("radius", "distance"))
    axes.plot([-radius, radius], [0, 0], color=ORANGE, lw=12, solid_capstyle="butt", zorder=4)
    for x in np.linspace(-radius, radius, 7):
        axes.plot([x, 0], [0, distance], color=ORANGE, lw=2, alpha=0.6, zorder=3)
    heights = np.linspace(1.45, 0.55, len(outcomes)) * distance
    for rank, (outcome, height) in enumerate(zip(outcomes, heights, strict=True)):
        colour, size = look(rank)[0], outcome.given["ball"] * distance
        circle = Circle(
            (0, distance),
            size,
            fc=colour,
            ec=colour,
            lw=3,
            alpha=0.25 if size > 0.3 * distance else 0.9,
            zorder=2,
        )
        axes.add_patch(circle)
        reading = outcome[BALL].estimate
        power = outcome.result["ball"].flux_in
        words = (
            f"r = {outcome.given['ball']:g} d\n"
            f"receives Φ = {number_text(power)} W\n"
            f"Φ/πr² = {number_text(reading)} {unit_label(reading.unit)}"
        )
        axes.text(1.15 * distance, height, words, color=colour, fontsize=22, va="center", linespacing=1.4)
    axes.text(0, -0.14 * distance, "disk of radiance L", ha="center", color=INK, fontsize=20)
    axes.plot([0, 0], [0, distance], "--", color=MUTED, lw=2, zorder=5)
    axes.text(0.03 * distance, 0.3 * distance, "d", color=MUTED, fontsize=22, zorder=6)
    bare_panel(axes, (-1.05 * distance, 3.1 * distance), (-0.3 * distance, 2.0 * distance))


def _is_whole(outcome: Outcome) -> bool:
    """Whether all of the disk is above the horizon of the turned meter."""
    of = outcome.given
    return math.cos(of["tilt"]) > math.sin(math.atan(of["radius"] / of["distance"]))


draw = figures(
    distances=(draw_distances, lambda of: [o for o in of if "fluence rate" in o]),
    map=(draw_map, holding("map")),
    turned=(draw_turned, where(reading="turned")),
    sheets=(draw_sheets, in_space(_sheets)),
    ways=(draw_ways, where(reading="three ways")),
    balls=(draw_balls, where(reading="ball")),
)


if __name__ == "__main__":
    main(__file__)
