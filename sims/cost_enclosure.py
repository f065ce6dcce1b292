"""The price of accuracy: a small meter in a white room, to which light comes after many reflections.

Derivation.  Inside a sphere what leaves any place by the cosine law falls evenly on all places (Ulbricht
1900).  A part of the wall that emits Φ lights the whole wall alike, and with a wall of albedo ρ the
reflections are a geometric series: the wall, of the area A, receives and reflects everywhere

    E_wall = Φ/(A (1 - ρ)),   L = ρ E_wall/π   (Jacquez, Kuppenheim 1955; Goebel 1967).

A flat meter in the sphere's middle that turns its back to the lamp sees nothing but wall of this radiance,
from each of its points and in all directions, so that it reads

    E = π L = ρ Φ/(A (1 - ρ)),

whatever its size.

Scene.  A diffuse sphere of 1 m radius, a cap of which, at the bottom, emits as well as it reflects; in the
middle a disk that looks up.  All its light has been reflected, 1/(1 - ρ) times in the mean.

What it teaches.  An analog history of light wanders about until it is absorbed, and crosses the meter in
passing: rarely, in proportion to the meter's area.  If every reflection sends its share to the meter at once,
all histories score, several times each; then the error no longer depends on the meter's size, but on how the
numbers of reflections differ between histories, and each score costs a ray.  A history that starts at the
meter scores wherever it comes to the lamp, which it does for sure after enough reflections: it depends on the
lamp's size as analog histories do on the meter's. Small meters want to be connected or started from; small
lamps want the opposite; with both small, connect.  The whiter the wall, the more every way pays for the
length of its histories.
"""

from __future__ import annotations

import math

import transport as tp
from transport.sims import figures, furthest, main, of_scene, require, rows_figure
from transport.theory.enclosures import sphere_irradiance_of_wall_patch
from transport.verification.experiment import Outcome

law = "E = ρ Φ/(A(1 - ρ)) in a diffuse sphere, by reflected light (Ulbricht 1900; Jacquez, Kuppenheim 1955)"
question = "What does a digit cost in a closed white room, at a small meter that the lamp does not light?"
particles = 200_000
run = {"estimator": "expected"}  # at its price; `transport cost` runs every way

POWER = 1.0  # W
LARGEST = 0.4  # share of the wall that may emit: the meter does not see it
IRRADIANCE = "irradiance"


def cases() -> list[dict[str, float]]:
    return [{"albedo": albedo} for albedo in (0.9, 0.5)]


def scene(albedo: float = 0.9, meter: float = 0.05, lamp: float = 0.02, radius: float = 1.0) -> tp.Scene:
    """A diffuse sphere of that albedo and radius [m].

    meter: radius of the disk in its middle, over the sphere's;  lamp: share of the wall that emits, at the bottom.
    """
    for name, value, most in (("albedo", albedo, 1), ("meter", meter, 1), ("lamp", lamp, LARGEST)):
        require("cost_enclosure", **{name: (value, 0 < value < most, f"above 0 and below {most}")})
    rim = 2 * lamp - 1
    parts = {"wall": {"mu_min": rim}, "lamp": {"mu_max": rim}}
    disk = tp.Disk(radius=meter * radius)
    return tp.Scene(
        tp.Source("lamp", tp.Lambertian(power=POWER), side="back"),
        [
            tp.Surface(tp.Sphere(radius=radius, **part), tp.Diffuse(albedo), name)
            for name, part in parts.items()
        ],
        tp.Detector(disk, "meter"),
    )


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    return {IRRADIANCE: result["meter"].irradiance}


@of_scene(scene)
def exact(albedo: float, radius: float) -> dict[str, float]:
    area = 4 * math.pi * radius**2
    return {IRRADIANCE: albedo * sphere_irradiance_of_wall_patch(POWER, albedo, area)}


def verdict(outcomes: list[Outcome]) -> str:
    said = [f"{o[IRRADIANCE].estimate} at ρ = {o.given['albedo']:g}" for o in outcomes]
    return f"The meter reads {', '.join(said)}; {furthest(outcomes)}."


draw = figures(rows=rows_figure("A small meter in a white sphere"))


if __name__ == "__main__":
    main(__file__)
