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

import transport as tp
from transport.sims import constant, figures, main, of_scene, one_of, require, rows_figure
from transport.theory import effusion
from transport.verification.experiment import Outcome

law = "p = u/3 of light, n k T of a gas, half on a black wall; u cos²θ of a beam (Boltzmann 1884; Reif 1965, 7.13)"
question = "How hard do light and gas press on a mirror, on a black wall, and inside?"
particles = 400_000

ROOM = tp.Box(size=(1.0, 1.0, 1.0))
DEPTH, RADIUS, MARGIN = 1.0, 0.5, 0.01  # m: of the room, of the wall in a stream, of gas beyond what matters
WALLS = {"mirror": tp.Mirror(), "diffuse": tp.Diffuse(1.0), "black": tp.Black()}
FLIGHTS = 4  # through the room while the clock runs, where nothing is absorbed
FASTEST = 9.0  # standard deviations of a velocity
MASS, SPEED = 4.65e-26, 500.0  # of a nitrogen molecule [kg]; of the stream [m/s]
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
        rows["pressure across the middle"] = result["middle"].pressure
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
        rows["pressure across the middle"] = rows["pressure"]
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


draw = figures(rows=rows_figure("Light and gas press on walls", lambda row, o: f"{row.name}\n{_words(o)}"))


if __name__ == "__main__":
    main(__file__)
