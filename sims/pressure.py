"""Pressure: a third of the energy density of light, n k T of a gas; half of it on a black wall.

Derivation.  The prism v cosθ dA dt over a wall holds n v cosθ dA dt particles that arrive within dt (Hanrahan 2001,
Stanford CS 348B, lecture 4, "Flows"), each with the momentum m v cosθ towards the wall: a stream presses with
n m v² cos²θ, or u cos²θ for light, whose momentum is its energy over c.  An isotropic gas brings a sixth of n m v² or
of u, as ∫ cos²θ dω/4π over a hemisphere is 1/6.  So much does a black wall feel; a mirror sends it back as it came and
feels twice that: u/3 for light (Boltzmann 1884), n m⟨v²⟩/3 = n k T for a gas (Reif 1965, 7.13).  A diffuse wall that
absorbs nothing feels the same: the cosine law is what an isotropic gas brings.  In a stream it does not: what leaves
has 2/3 of its momentum along the normal, so that the wall feels cosθ (cosθ + 2/3), a mirror 2 cos²θ, a black one cos²θ.

Scene.  "isotropic" fills a box of mirrors uniformly at time 0, and a gas uniform and isotropic stays so for ever: every
value is exact at all times.  One wall of the box may be diffuse or black; of a black one the shadow, the particles that
it has taken, comes back after 2 depth/v, and the clock stops before (for a gas at nine standard deviations of its
velocities: 1 particle in 1e18 is faster).  A transparent meter in the middle feels what crosses it both ways: the
pressure is the same there.  "stream" is a parallel beam of light in a steady scene, or a stream of molecules.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import constant, figures, main, of_scene, one_of, require, where
from transport.theory import effusion
from transport.verification.experiment import Outcome

law = "p = u/3 of light, n k T of a gas, half on a black wall; u cos²θ of a beam (Boltzmann 1884; Reif 1965, 7.13)"
question = "How hard do light and gas press on a mirror, on a black wall, and inside?"
particles = 2_000_000

ROOM = tp.Box(size=(1.0, 1.0, 1.0))
DEPTH, RADIUS, MARGIN = 1.0, 0.5, 0.01  # m: of the room, of the wall in a stream, of gas beyond what matters
WALLS = {"mirror": tp.Mirror(), "diffuse": tp.Diffuse(1.0), "black": tp.Black()}
# Flights through the room while the clock runs, where nothing is absorbed: 6 give 1.5 crossings of the middle.  4 would give 1,
# and what nearly every history scores once is doubted, as the few others would carry its error.
FLIGHTS = 6
FASTEST = 9.0  # standard deviations of a velocity
MASS, SPEED = 4.65e-26, 500.0  # of a nitrogen molecule [kg]; of the stream [m/s]
MIDDLE, INSIDE = "pressure across the middle", "inside"
LAYER = tp.Box(size=(1.0, 1.0, 0.5))  # in the middle, where the gas is looked at


def cases() -> list[dict[str, object]]:
    isotropic = [{"stuff": "light", "wall": wall} for wall in WALLS]
    beams = [{"stuff": "light", "motion": "stream", "wall": wall, "tilt": 60 * tp.deg} for wall in WALLS]
    gas = [{"stuff": "gas", "wall": wall} for wall in ("mirror", "black")]
    return [*isotropic, *beams, *gas, {"stuff": "gas", "motion": "stream", "wall": "mirror"}]


def scene(
    stuff: str = "light",
    motion: str = "isotropic",
    wall: str = "mirror",
    tilt: float = 0.0,
    energy_density: float = 1e-5,
    density: float = 2.5e25,
    temperature: float = 300.0,
) -> tp.Scene:
    """A wall that is pressed.  tilt: of it in a stream [rad];  energy_density [J m^-3] of light, about twice sunlight's;
    density [m^-3] and temperature [K] of a gas, about those of air (a stream has no temperature)."""
    motions = ("isotropic", "stream")
    one_of("pressure", stuff=(stuff, ("light", "gas")), motion=(motion, motions), wall=(wall, WALLS))
    if motion == "stream":
        require("pressure", tilt=(tilt, 0 <= tilt < math.pi / 2, "from 0 to below pi/2 rad"))
        return _in_stream(stuff, WALLS[wall], tilt, energy_density, density)
    if stuff == "light":
        light = tp.Isotropic(energy=energy_density * ROOM.volume)
        source, speed = tp.Source(ROOM, light, pulse=tp.Instant()), tp.speed_of_light
    else:
        velocities = tp.Maxwellian(temperature=temperature, mass=MASS)
        source, speed = tp.Source(ROOM, tp.Gas(density, velocities)), velocities.sigma
    absorbs = wall == "black"
    fastest = speed * FASTEST if absorbs and stuff == "gas" else speed
    duration = (2 if absorbs else FLIGHTS) * DEPTH / fastest
    inner = [] if absorbs else _inside(stuff, duration)
    faces = ROOM.faces()
    tested = tp.Surface(faces.pop("-z"), WALLS[wall], name="wall")
    return tp.Scene(
        sources=source,
        surfaces=[tested, *(tp.Surface(face, tp.Mirror()) for face in faces.values())],
        detectors=[tp.Detector("wall", side="back", moments=True), *inner],
        duration=duration,
    )


def _inside(stuff: str, duration: float) -> list[object]:
    """A meter across the middle of the room; of a gas also the moments of what is in the middle at the end."""
    plane = tp.Detector(tp.Rectangle(width=1.0, height=1.0), name="middle", moments=True)
    layer = tp.PhaseSpace(z=(-0.25, 0.25), within=LAYER, time=duration, name="layer", moments=True)
    return [plane] if stuff == "light" else [plane, layer]


def _in_stream(
    stuff: str, material: tp.Material, tilt: float, energy_density: float, density: float
) -> tp.Scene:
    """A disk, tilted in a stream along -z that is wider than it."""
    disk = tp.Disk(normal=(math.sin(tilt), 0, math.cos(tilt)), radius=RADIUS)
    wall, meter = tp.Surface(disk, material, name="wall"), tp.Detector("wall", moments=True)
    wide, high = RADIUS + MARGIN, RADIUS * math.sin(tilt) + MARGIN
    if stuff == "light":
        irradiance = energy_density * tp.speed_of_light
        lamp = tp.Rectangle(center=(0, 0, high), normal=(0, 0, -1), width=2 * wide, height=2 * wide)
        return tp.Scene(tp.Source(lamp, tp.Beam((0, 0, -1), irradiance=irradiance)), wall, meter)
    reach = 2 * RADIUS  # that a molecule flies
    box = tp.Box(center=(0, 0, reach / 2), size=(2 * wide, 2 * wide, 2 * high + reach))
    gas = tp.Gas(density, SPEED, direction=(0, 0, -1), mass=MASS)
    return tp.Scene(tp.Source(box, gas), wall, meter, duration=reach / SPEED)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    wall, inside = result["wall"], {detector.name for detector in result.scene.detectors}
    rows = {"pressure": wall.pressure}
    if result.scene.measured_in == "watts" and result.scene.duration is not None:
        energy_density = wall.irradiance * constant(result, 4 / tp.speed_of_light, "m^-1 s Pa m^3 J^-1")
        rows["p / u, of u = 4E/c"] = wall.pressure / energy_density
    if "middle" in inside:
        rows[MIDDLE] = result["middle"].pressure
    if "layer" in inside:
        layer = result["layer"]
        rows |= {"n k T inside": layer.pressure[0], "T inside": layer.temperature[0]}
        rows |= {"n v inside": layer.fluence_rate[0]}
    return rows


@of_scene(scene)
def exact(
    stuff: str, motion: str, wall: str, tilt: float, energy_density: float, density: float, temperature: float
) -> dict[str, float]:
    if motion == "stream":
        momentum_flux = energy_density if stuff == "light" else density * MASS * SPEED**2
        return {"pressure": effusion.stream_pressure(momentum_flux, math.cos(tilt), wall)}
    if stuff == "light":
        rows = {"pressure": effusion.light_pressure(energy_density, wall)}
        rows["p / u, of u = 4E/c"] = effusion.light_pressure(1.0, wall)
    else:
        rows = {"pressure": effusion.gas_pressure(density, temperature, wall)}
    if wall != "black":
        rows[MIDDLE] = rows["pressure"]
        if stuff == "gas":
            fluence_rate = density * effusion.mean_speed(effusion.thermal_sigma(temperature, MASS))
            rows |= {"n k T inside": rows["pressure"], "T inside": temperature, "n v inside": fluence_rate}
    return rows


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in outcomes:
        over = outcome["pressure"].estimate / outcome["pressure"].exact
        said.append(f"{over.value:.4f} ± {over.error:.4f} ({_words(outcome)})")
    return f"Pressure over what the law says: {', '.join(said)}."


def _words(outcome: Outcome) -> str:
    """The case in a few words."""
    of = outcome.given
    tilted = f" at {math.degrees(of['tilt']):.3g}°" if of["tilt"] > 0 else ""
    return f"{of['stuff']}{' beam' if of['motion'] == 'stream' else ''}, {of['wall']}{tilted}"


def draw_pushes(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Momentum that arrives, leaves and pushes, by wall; below, pressure over the momentum that arrives."""
    from transport.viz.style import figure

    columns = [wall for wall in WALLS if where(wall=wall)(outcomes)]
    columns += [INSIDE] if any(MIDDLE in o for o in outcomes) else []
    tilts = [o.given["tilt"] for o in outcomes if o.given["tilt"] > 0]
    with figure((4.9 * len(columns) + 1.5, 11.6), "What is sent back pushes once more", note, path) as page:
        rows = [columns, ["chart"] * len(columns)]
        panels = page.subplot_mosaic(rows, height_ratios=(1, 1.2))
        for column in columns:
            _draw_push(panels[column], column, tilts[0] if tilts else 45 * tp.deg)
        _draw_factors(panels["chart"], outcomes, columns)


def _draw_push(axes, column: str, tilt: float) -> None:
    """A wall or the middle of the gas with arrows of momentum, to one scale."""
    from transport.viz.exhibits import bare_panel, draw_arrow
    from transport.viz.style import BLUE, INK, ORANGE, VERMILLION

    sine, mu = math.sin(tilt), math.cos(tilt)
    middle, arriving = np.array([0.0, 0.02]), np.array([sine, -mu])
    if column == INSIDE:
        axes.plot([-1, 1], [0, 0], "--", color=INK, lw=3)
        for side in (-1, 1):
            way = side * np.array([sine, mu])
            draw_arrow(axes, (0.42 * side, 0) - 0.5 * way, way, BLUE)
    else:
        axes.fill_between(
            [-1, 1], -0.13, 0, color={"mirror": "#a9bccb", "diffuse": "#d9d9d9", "black": INK}[column], lw=0
        )
        draw_arrow(axes, middle - arriving, arriving, BLUE)
        draw_arrow(axes, (0, -0.16), (0, -effusion.stream_pressure(1.0, mu, column) / mu), VERMILLION, 10)
    if column == "mirror":
        draw_arrow(axes, middle, (sine, mu), ORANGE)
        axes.text(-0.98, 0.92, "arrives", color=BLUE, fontsize=20, va="center")
        axes.text(0.98, 0.92, "leaves", color=ORANGE, fontsize=20, va="center", ha="right")
        axes.text(0.3, -0.75, "pushes", color=VERMILLION, fontsize=20, va="center")
    elif column == "diffuse":
        for angle in np.radians(range(-75, 76, 25)):
            draw_arrow(
                axes, middle, math.cos(angle) * np.array([math.sin(angle), math.cos(angle)]), ORANGE, 1.6
            )
    words = {"diffuse": "diffuse, ρ = 1", INSIDE: "inside, both ways"}
    axes.set_title(words.get(column, column), fontweight="bold")
    bare_panel(axes, (-1.05, 1.05), (-1.4, 1.05))


def _draw_factors(axes, outcomes: list[Outcome], columns: list[str]) -> None:
    """Pressures over that on a black wall, which the arriving momentum alone makes; exact values are bars."""
    from transport.viz.style import INK, PURPLE, look

    kinds: dict[str, list[tuple[float, tp.Estimate, float]]] = {}
    for outcome in outcomes:
        unit = exact(**outcome.given | {"wall": "black"})["pressure"]
        for row, column in (("pressure", outcome.given["wall"]), (MIDDLE, INSIDE)):
            if row in outcome:
                share = outcome[row].estimate / constant(outcome.result, unit, "Pa")
                kinds.setdefault(_kind(outcome), []).append(
                    (columns.index(column), share, outcome[row].exact / unit)
                )
    axes.axhline(1, ls="--", lw=3, color=PURPLE, label="wrong: arriving momentum alone", zorder=1)
    for rank, (words, found) in enumerate(kinds.items()):
        (colour, marker), aside = look(rank), 0.14 * (rank - (len(kinds) - 1) / 2)
        for column, share, level in found:
            x = column + aside
            axes.plot([x - 0.06, x + 0.06], [level] * 2, color=INK, lw=3, zorder=2)
            axes.errorbar(
                x,
                share.value,
                2 * share.error,
                fmt=marker,
                color=colour,
                ms=16,
                capsize=5,
                lw=3,
                mec="white",
                label=words,
            )
    handles, labels = axes.get_legend_handles_labels()
    found = dict(zip(reversed(labels), reversed(handles), strict=True))
    axes.legend(
        list(found.values())[::-1],
        list(found)[::-1],
        loc="lower center",
        bbox_to_anchor=(0.5, -0.34),
        ncols=3,
    )
    axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(0, 2.6), xticks=range(len(columns)))
    axes.tick_params(axis="x", labelbottom=False, length=0)
    axes.set_ylabel("pressure / arriving momentum")
    axes.grid(False, axis="x")


def _kind(outcome: Outcome) -> str:
    of = outcome.given
    if of["motion"] == "isotropic":
        return f"{of['stuff']} from all sides"
    return f"{of['stuff']} beam, {math.degrees(of['tilt']):.3g}°"


draw = figures(pushes=draw_pushes)


if __name__ == "__main__":
    main(__file__)
