"""Fog: the exception to the law that radiance is the same all along a ray.

Derivation.  In vacuum radiance is invariant along a ray; in a medium each length ds takes the share σ ds out of
it, σ the extinction, so that L falls by exp(-τ), τ = ∫ σ ds (Bouguer 1729; Beer 1852).  What is left never
collided.  Where all that collides is absorbed this is all the light; what is scattered comes on top.

"disk".  A Lambertian disk and a meter on its axis, with absorbing fog of the depth τ between.  A ray at the
angle θ has τ/cosθ before it: a bin of directions holds the mean of L exp(-τ/μ), weighted with μ, and the
irradiance is 2π L ∫ μ exp(-τ/μ) dμ.  It is not exp(-τ) times that in clear air, which forgets the slant; of a
disk that fills half the world 2 E3(τ) is left.
"lamp".  The same in fog that only scatters, mostly forward.  What comes straight is that of absorbing fog; the
rest is a glow about the lamp, and the irradiance is higher.
"room".  A ball of fog within a wall that glows.  Fog that absorbs nothing scatters into each ray what it
scatters out of it: radiance is L everywhere; of what comes by a chord 2R μ exp(-2R σ μ) is direct.
"sun".  Its radiance is 2.3e7 W m⁻² sr⁻¹ at its surface and about 1.4e7 seen from the ground (Scratchapixel, on
radiometric quantities), so that the atmosphere has τ = ln(2.3/1.4) = 0.50, if that is at the zenith: inferred,
the source says neither this nor which part of the spectrum is meant.  At the zenith angle z it is exp(-τ/cos z)
in a flat atmosphere; logarithms read on the ground, drawn on to no air, give that above it (Langley 1903).

Scene.  Fog is in a Slab or a Box without a wall, or everywhere: `place`.  Where light is absorbed only,
directions are aimed at the meter.  Bins keep off the disk's rim by the meter's radius (sims/lambert_disk.py).
"""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import (
    constant,
    curves_figure,
    figures,
    furthest,
    grouped,
    main,
    of_scene,
    one_of,
    provenance,
    require,
    sentence,
    sharp,
    where,
)
from transport.theory import attenuation, emitters
from transport.verification.experiment import Outcome

law = "L = L0 exp(-τ) along a ray, E = 2π L ∫ μ exp(-τ/μ) dμ (Bouguer 1729; Beer 1852; Chandrasekhar 1960)"
question = "Is radiance the same all along a ray in fog, and what of the light that reaches us came straight?"
particles = 16_000_000

RADIANCE = 100.0  # W m^-2 sr^-1
DISK, LAMP = (0.5, 0.2, 5e-4), (0.3, 1.0, 0.1)  # m: radius, distance and radius of the meter
BINS = 6  # within the disk's cone, even in the length of the way
ANGLES = np.radians([0, *range(6, 91, 2)])  # of the disk's picture
LAMP_ANGLES = np.radians([0, 4, *range(6, 31, 2), *range(35, 61, 5), 70, 90])  # wider where its glow fades
LAMP_G = 0.8  # mean cosine of the scattering angle
WALL = np.linspace(0, 1, 5)  # cosines of directions at the room's wall
SURFACE, GROUND = 2.3e7, 1.4e7  # W m^-2 sr^-1, the sun's radiance
ATMOSPHERE = math.log(SURFACE / GROUND)
SUN_ANGLE = math.asin(float(emitters.sphere_radius(emitters.AREA)) / tp.au)
AIR = (1e3, 1e4)  # m: where the atmosphere begins above the meter, and its thickness
READINGS, PLACES = ("disk", "lamp", "room", "sun"), ("slab", "box", "everywhere")
IRRADIANCE, DIRECT = "irradiance", "irradiance, direct"
CERTAIN = 0.25  # relative error up to which a bin sets the scale of a figure
IN_LAMP, SUN = "radiance of the lamp, direct", "radiance of the sun"


def cases() -> list[dict[str, object]]:
    disks = [(0.0, "slab"), (0.5, "slab"), (1.0, "box"), (2.0, "everywhere")]
    return [
        *({"reading": "disk", "tau": tau, "place": place} for tau, place in disks),
        {"reading": "lamp", "tau": 1.0},
        {"reading": "room", "tau": 2.0},
        {"reading": "sun", "tau": 0.0},
        *({"reading": "sun", "tau": ATMOSPHERE, "zenith_angle": angle * tp.deg} for angle in (0, 60, 75)),
    ]


def scene(
    reading: str = "disk", tau: float = 1.0, place: str = "slab", zenith_angle: float = 0.0
) -> tp.Scene:
    """A "disk" in absorbing fog, a "lamp" in scattering fog, a "room" full of it, or the "sun".

    tau: optical depth straight from source to meter; across the room; of the atmosphere at the zenith. place:
    of the fog before the disk: in a "slab" or a "box" between, or "everywhere".  zenith_angle: of the sun [rad].
    """
    one_of("fog", reading=(reading, READINGS), place=(place, PLACES))
    is_up = 0 <= zenith_angle < math.pi / 2 - SUN_ANGLE
    require("fog", zenith_angle=(zenith_angle, is_up, "from 0 to below pi/2 rad"))
    if reading in ("room", "sun"):
        return _room(tau) if reading == "room" else _sun(tau, zenith_angle)
    return _disk(reading, tau, place if reading == "disk" else "slab")


def _disk(reading: str, tau: float, place: str) -> tp.Scene:
    """Source and meter face each other; in a slab or a box the fog fills the middle half of the way."""
    is_lamp, (radius, distance, size) = reading == "lamp", LAMP if reading == "lamp" else DISK
    meter = tp.Disk(center=(0, 0, distance), normal=(0, 0, -1), radius=size)
    middle, depth = (0, 0, distance / 2), distance if place == "everywhere" else distance / 2
    fog = tp.Medium(absorption=tau / depth)
    if is_lamp:
        fog = tp.Medium(scattering=tau / depth, phase=tp.HenyeyGreenstein(LAMP_G))

    def look(name: str, angles: np.ndarray, events: int | None = None) -> tp.Detector:
        return tp.Detector(meter, name, directions=tp.Directions(theta=angles), events=events)

    bins, angles = _edges(reading), LAMP_ANGLES if is_lamp else ANGLES
    views = [look("view", angles)]
    views += [look("direct", bins, 0), look("direct view", angles, 0)] if is_lamp else [look("meter", bins)]
    body = tp.Slab(center=middle, thickness=depth)
    if place == "box":
        body = tp.Box(center=middle, size=(3 * radius, 3 * radius, depth))
    return tp.Scene(
        tp.Source(tp.Disk(radius=radius), tp.Lambertian(radiance=RADIANCE), aim=None if is_lamp else meter),
        [] if place == "everywhere" else tp.Surface(body, tp.Transparent(), name="fog", inside=fog),
        views,
        medium=fog if place == "everywhere" else tp.Vacuum(),
    )


def _edges(reading: str) -> np.ndarray:
    """Edges of bins within the cone of the source, even in 1/cosθ, then the rim and the horizon [rad]."""
    radius, distance, size = LAMP if reading == "lamp" else DISK
    within, beyond = math.hypot(distance, radius - size) / distance, math.atan((radius + size) / distance)
    ways = np.linspace(1, within, (1 if reading == "lamp" else BINS) + 1)
    return np.array([*np.arccos(1 / ways), beyond, math.pi / 2])


def _room(tau: float) -> tp.Scene:
    """Fog that only scatters, within a wall that glows; the wall's meters look at what arrives."""
    ball, bins = tp.Sphere(radius=1.0), tp.Directions(mu=WALL)
    fog = tp.Medium(scattering=tau / (2 * ball.radius), phase=tp.HenyeyGreenstein(LAMP_G))
    return tp.Scene(
        tp.Source("room", tp.Lambertian(radiance=RADIANCE), side="inside"),
        tp.Surface(ball, tp.Black(), name="room", inside=fog),
        [
            tp.Detector("room", "wall", side="inside", directions=bins),
            tp.Detector("room", "direct", side="inside", directions=bins, events=0),
        ],
    )


def _sun(tau: float, zenith_angle: float) -> tp.Scene:
    """The sun far along +x, a square metre that faces it, and above that a slab of air, tilted."""
    up = (math.cos(zenith_angle), 0, math.sin(zenith_angle))
    air = tp.Slab(center=[(AIR[0] + AIR[1] / 2) * x for x in up], normal=up, thickness=AIR[1])
    meter = tp.Rectangle(normal=(1, 0, 0), width=1, height=1)
    ball = tp.Sphere(center=(tp.au, 0, 0), radius=tp.au * math.sin(SUN_ANGLE))
    return tp.Scene(
        tp.Source(ball, tp.Lambertian(radiance=SURFACE), aim=meter),
        tp.Surface(air, tp.Transparent(), name="air", inside=tp.Medium(absorption=tau / AIR[1])),
        tp.Detector(meter, "meter", directions=tp.Directions.cone((1, 0, 0), SUN_ANGLE)),
    )


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    if "wall" in result:
        wall, direct = result["wall"], result["direct"]
        rows = {_bin("radiance", WALL, i): each for i, each in enumerate(wall.radiance)}
        rows |= {_bin("radiance, direct", WALL, i): each for i, each in enumerate(direct.radiance)}
        return rows | {IRRADIANCE: sharp(wall.irradiance, of=wall.irradiance), DIRECT: direct.irradiance}
    if "direct" in result:
        return {DIRECT: result["direct"].irradiance, IN_LAMP: result["direct"].radiance[0]}
    meter, seen, cosines = result["meter"], result["meter"].radiance, np.cos(_edges("disk"))
    if "air" in [surface.name for surface in result.scene.surfaces]:
        return {SUN: seen[0]}
    rows = {_bin("radiance", cosines, i): seen[i] for i in range(BINS)}
    return rows | {IRRADIANCE: meter.irradiance, "radiance beside the disk": seen[BINS + 1]}


@of_scene(scene)
def exact(reading: str, tau: float, zenith_angle: float) -> dict[str, float]:
    if reading == "room":
        left = attenuation.ball_transmittance(tau, WALL[:-1], WALL[1:])
        rows = {_bin("radiance", WALL, i): RADIANCE for i in range(len(left))}
        rows |= {_bin("radiance, direct", WALL, i): RADIANCE * each for i, each in enumerate(left)}
        irradiance = math.pi * RADIANCE
        return rows | {IRRADIANCE: irradiance, DIRECT: irradiance * attenuation.ball_transmittance(tau)}
    if reading == "sun":
        return {SUN: SURFACE * attenuation.cone_transmittance(tau, zenith_angle, SUN_ANGLE)}
    radius, distance, size = LAMP if reading == "lamp" else DISK
    cosines = np.cos(_edges(reading))
    left = attenuation.mean_slant_transmittance(tau, cosines[1:-2], cosines[:-3]) * RADIANCE
    irradiance = attenuation.disk_irradiance(RADIANCE, radius, distance, tau, size)
    if reading == "lamp":
        return {DIRECT: irradiance, IN_LAMP: float(left[0])}
    rows = {_bin("radiance", cosines, i): float(left[i]) for i in range(BINS)}
    return rows | {IRRADIANCE: irradiance, "radiance beside the disk": 0.0}


def _bin(quantity: str, cosines: np.ndarray, index: int) -> str:
    low, high = sorted(cosines[index : index + 2])
    return f"{quantity}, cosθ {low:.3g} to {high:.3g}"


def verdict(outcomes: list[Outcome]) -> str:
    found, said = grouped(outcomes, "reading"), []
    if disks := found.get("disk"):
        said.append(f"radiance is L exp(-τ/cosθ), {furthest(disks)}")
        tau, irradiance = max((o.given["tau"], o[IRRADIANCE].estimate.value) for o in disks)
        many = guessed(tau) / irradiance if irradiance else math.inf
        said.append(
            f"exp(-τ) of the clear air's irradiance would be {many:.3g} times too much at τ = {tau:.3g}"
        )
    for o in found.get("lamp", ()):
        total = o.result["view"].irradiance
        said.append(f"of a lamp's light in scattering fog {o[DIRECT].estimate} is direct, {total} all of it")
    for o in found.get("room", ()):
        told = f"{o[IRRADIANCE].estimate} whatever its fog, of it {o[DIRECT].estimate} straight"
        said.append(f"the wall of a glowing room receives {told}")
    if suns := found.get("sun"):
        seen = (f"{o[SUN].estimate} through τ = {_air(o):.2g}" for o in suns)
        said.append(f"the sun's radiance is {', '.join(seen)}")
    return sentence(*said)


def guessed(tau: float) -> float:
    """The wrong guess: irradiance in clear air times exp(-tau) [W m^-2]."""
    clear = attenuation.disk_irradiance(RADIANCE, *DISK[:2], 0.0, DISK[2])
    return clear * float(attenuation.transmittance(tau))


def _air(outcome: Outcome) -> float:
    """Optical depth of the air before the sun."""
    return outcome.given["tau"] / math.cos(outcome.given["zenith_angle"])


def _label(outcome: Outcome) -> str:
    return f"τ = {outcome.given['tau']:.3g}, {outcome.given['place']}"


def _alike(outcomes: list[Outcome]) -> str:
    """Of what is aimed and absorbed only: cases of one seed have the same rays, and deviate together."""
    return provenance(outcomes) + ("; the same rays in every case" if len(outcomes) > 1 else "")


def draw_disk(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The disk as the meter sees it, from clear air to thick fog."""
    seen = {_label(o): o.result["view"].radiance for o in outcomes}
    laws = {_label(o): partial(_direct, tau=o.given["tau"], of=DISK) for o in outcomes}
    title = "A bright disk seen through fog: radiance is not invariant there"
    _draw_views(seen, laws, title, path, _alike(outcomes))


def _draw_views(
    seen: dict, laws: dict, title: str, path: Path, note: str, decades: float | None = None
) -> None:
    """Round maps of radiance by polar angle in one scale, and all of them as curves below."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm, Normalize

    from transport.viz.curves import plot_curves
    from transport.viz.directions import polar_curves
    from transport.viz.maps import plot_map
    from transport.viz.style import SEQUENTIAL, figure, with_unit

    top = (
        max(each.value[each.error <= CERTAIN * each.value].max(initial=0.0) for each in seen.values())
        or RADIANCE
    )
    norm = LogNorm(top / 10**decades, top, clip=True) if decades else Normalize(0, top, clip=True)
    with figure((max(5.2 * len(seen), 13) + 1.6, 14), title, note, path) as page:
        above, below = page.subfigures(2, 1, height_ratios=(1, 1.15))
        panels = above.subplots(1, len(seen), squeeze=False)[0]
        for axes, (label, each) in zip(panels, seen.items(), strict=True):
            plot_map(each, ax=axes, norm=norm, frame="plan", bar=False)
            axes.set_title(label)
        scale = ScalarMappable(norm, SEQUENTIAL)
        bar = above.colorbar(scale, ax=panels, shrink=0.8, pad=0.01, extend="min" if decades else "neither")
        bar.set_label(with_unit("radiance L", next(iter(seen.values())).unit))
        words = {"xlabel": "polar angle θ  [deg]", "ylabel": "radiance L", "legend": "upper right"}
        plot_curves(
            polar_curves(seen, laws), ax=below.subplots(), means=True, log_y=decades is not None, **words
        )


def draw_lamp(outcomes: list[Outcome], path: Path, note: str) -> None:
    """A lamp in scattering fog: all light, and what of it came straight."""
    tau, result = outcomes[0].given["tau"], outcomes[0].result
    seen = {"all light": result["view"].radiance, "direct": result["direct view"].radiance}
    title = f"A lamp in fog that scatters, τ = {tau:.3g}: its light glows about it"
    _draw_views(seen, {"direct": partial(_direct, tau=tau, of=LAMP)}, title, path, note, decades=4)


def _direct(theta: np.ndarray, tau: float, of: tuple[float, float, float]) -> np.ndarray:
    """Radiance that comes straight from the disk or the lamp."""
    return attenuation.disk_radiance(theta, RADIANCE, *of[:2], tau, of[2])


@curves_figure(
    xlabel="optical depth of the way  τ / cosθ",
    ylabel="radiance / that in clear air",
    title="Along every ray radiance falls by exp(-τ)",
    log_y=True,
)
def draw_ways(outcomes: list[Outcome]) -> dict[str, object]:
    """Radiance over that in clear air against the optical depth of the way: one exponential for all."""
    cosines = np.cos(_edges("disk"))[: BINS + 1]
    middles, series = (cosines[1:] + cosines[:-1]) / 2, {}
    for outcome in outcomes:
        level = constant(outcome.result, RADIANCE, "W m^-2 sr^-1")
        rows, depths = outcome.rows[:BINS], outcome.given["tau"] / middles
        shares, expected = [r.estimate / level for r in rows], [r.exact / RADIANCE for r in rows]
        series[_label(outcome)] = depths, shares, lambda way: np.exp(-way), expected
    return {"series": series, "note": _alike(outcomes)}


@curves_figure(
    guides={"wrong guess: exp(-τ) of that in clear air": np.vectorize(guessed)},
    xlabel="optical depth τ straight from the disk to the meter",
    ylabel="irradiance",
    title="Irradiance in fog falls faster than exp(-τ)",
    log_y=True,
)
def draw_irradiance(outcomes: list[Outcome]) -> dict[str, object]:
    """Irradiance against the optical depth, with the guess that forgets the slant."""
    exact_irradiance = np.vectorize(lambda t: attenuation.disk_irradiance(RADIANCE, *DISK[:2], t, DISK[2]))
    depths, irradiances = [o.given["tau"] for o in outcomes], [o[IRRADIANCE].estimate for o in outcomes]
    return {"series": (depths, irradiances, exact_irradiance), "note": _alike(outcomes)}


@curves_figure(
    guides={"at its surface, and above the air": lambda depth: np.full(np.shape(depth), SURFACE)},
    xlabel="optical depth of the air before the sun: τ / cos(zenith angle)",
    ylabel="radiance of the sun",
    title=f"The sun through the atmosphere, τ = {ATMOSPHERE:.2f} at the zenith",
    log_y=True,
)
def draw_sun(outcomes: list[Outcome]) -> dict[str, object]:
    """The sun's radiance against the depth of air before it."""
    depths, seen = [_air(o) for o in outcomes], [o[SUN].estimate for o in outcomes]
    return {"series": (depths, seen, lambda depth: SURFACE * np.exp(-depth)), "note": _alike(outcomes)}


def draw_room(outcomes: list[Outcome], path: Path, note: str) -> None:
    """A room full of fog with chords from a place on its wall; radiance there by direction: all, and what came straight."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import figure

    outcome, seen = outcomes[0], outcomes[0].result
    tau = outcome.given["tau"]
    with figure((18.5, 9.6), "A glowing room full of fog: as bright as an empty one", note, path) as page:
        sketch, charts = page.subfigures(1, 2, width_ratios=(1, 1.45))
        _draw_room(sketch.subplots(), tau)
        panels = charts.subplots(2, 1, sharex=True, height_ratios=(2.7, 1))
        straight = RADIANCE * attenuation.ball_transmittance(tau, WALL[:-1], WALL[1:])
        means = np.diff(WALL**3) / np.diff(WALL**2) * 2 / 3  # cosines, weighted with themselves
        level = np.full(len(means), RADIANCE)
        series = {
            "all light": Series(means, seen["wall"].radiance, lambda mu: RADIANCE + 0 * mu, level),
            "came straight: exp(−τ cosθ)": Series(
                means, seen["direct"].radiance, lambda mu: RADIANCE * np.exp(-tau * mu), straight
            ),
        }
        labels = {"xlabel": "cosθ at the wall", "ylabel": "radiance L", "legend": "lower left"}
        plot_curves(series, ax=tuple(panels), span=(0.0, 1.0), **labels)
        panels[0].set_ylim(0, 1.15 * RADIANCE)


def _draw_room(axes, tau: float) -> None:
    """The room from beside: its wall glows, and of two chords of one end one is straight, the other bent by the fog."""
    from transport.viz.exhibits import bare_panel, draw_arrow
    from transport.viz.style import BLUE, INK, ORANGE, VERMILLION

    turn = np.linspace(0, 2 * math.pi, 361)
    axes.fill(np.cos(turn), np.sin(turn), fc="#e3e7ea", ec=ORANGE, lw=12)
    place, words = np.array([0.0, -0.97]), {"fontsize": 22, "ha": "center", "va": "center"}
    theta = math.radians(38)
    far = place + 2 * 0.97 * math.cos(theta) * np.array([math.sin(theta), math.cos(theta)])
    draw_arrow(axes, far, 0.97 * (place - far), VERMILLION, 4)
    bend = np.array([-0.32, 0.12])
    start = np.array([-0.94, 0.2])
    axes.plot(*np.stack([start, bend], axis=1), color=BLUE, lw=4)
    axes.plot(*bend, "o", color=BLUE, ms=14)
    draw_arrow(axes, bend, 0.96 * (place - bend), BLUE, 4)
    axes.plot([0, 0], [-0.95, -0.05], "--", color=INK, lw=2)
    axes.text(0.13, -0.5, "θ", color=INK, **words)
    axes.text(0.42, 0.42, "straight:\n$2R$ cosθ of fog", color=VERMILLION, **words)
    axes.text(-0.35, 0.45, "scattered in", color=BLUE, **words)
    axes.text(0, 1.16, f"the wall glows; τ = {tau:.3g} across", color=INK, **words)
    bare_panel(axes, (-1.1, 1.1), (-1.1, 1.25))


draw = figures(
    disk=(draw_disk, where(reading="disk")),
    ways=(draw_ways, where(reading="disk")),
    irradiance=(draw_irradiance, where(reading="disk")),
    lamp=(draw_lamp, where(reading="lamp")),
    room=(draw_room, where(reading="room")),
    sun=(draw_sun, where(reading="sun")),
)


if __name__ == "__main__":
    main(__file__)
