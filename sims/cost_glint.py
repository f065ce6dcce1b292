"""The price of accuracy: radiance from one direction of ten thousand, straight from a lamp and by way of a wall.

Derivation.  A cap of a sphere, the share f of its area A, emits Φ diffusely: its radiance is L = Φ/(π f A),
and as radiance does not change along a ray, this is what any meter reads in a cone that the lamp fills.
Another part of the same sphere, the share f_w, is a diffuse wall of albedo ρ; the rest is open.  What leaves
any place of the inside falls evenly on all of it (Ulbricht 1900), so that the wall is lit evenly, by the lamp
and by itself,

    E = Φ/(A (1 - ρ f_w)),   L_wall = ρ E/π   (Jacquez, Kuppenheim 1955; Goebel 1967),

which is what a meter reads in a cone that the wall fills.

Scene.  A sphere of 1 m radius: the lamp at the top (f = 0.2), below it a gap, then the wall (f_w = 0.75).  A
disk in its middle looks up at the lamp or down at the wall, in one cone of directions that is the share 1e-4
of its hemisphere, half angle 0.81°, 0.3 rad off its normal.

What it teaches.  To be counted, an analog history must hit a small meter and do so from the right direction:
two rare things, whose shares are multiplied.  Aiming at the meter, or connecting to it, spares the first
only: of the rays that come, 1 in thousands comes within the cone.  Started backwards in the cone every
history counts; towards the lamp each one reads L, the same L, and nothing is left to estimate; towards the
wall what is left is how many reflections it takes to come to the lamp. Where the question is about the
detector (one pixel, one direction), begin there.
"""

from __future__ import annotations

import math

import transport as tp
from transport.sims import figures, furthest, main, of_scene, one_of, require, rows_figure
from transport.theory.enclosures import lamp_irradiance
from transport.verification.experiment import Outcome

law = "L = Φ/(π f A) along a ray; L_wall = ρ Φ/(π A(1 - ρ f_w)) in a diffuse sphere (Ulbricht 1900; Goebel 1967)"
question = "What does a digit cost of the radiance within one direction of ten thousand?"
particles = 1_000_000
run = {"estimator": "backward"}  # of an analog run one history in a million would count

POWER, RADIUS = 1.0, 1.0  # W, m
LAMP, WALL = 0.2, 0.75  # shares of the sphere's area
TILT = 0.3  # rad, of the cone's axis to the meter's normal
SEEN = ("wall", "lamp")
RADIANCE = "radiance"


def cases() -> list[dict[str, object]]:
    return [{"seen": seen} for seen in SEEN]


def scene(seen: str = "wall", share: float = 1e-4, meter: float = 0.1, albedo: float = 0.8) -> tp.Scene:
    """A meter in the middle of a sphere that is lamp above and wall below.

    seen: what its cone is filled by, the "lamp" or the "wall";  share: of its hemisphere that the cone is;
    meter: its radius over the sphere's;  albedo: of the wall.
    """
    one_of("cost_glint", seen=(seen, SEEN))
    require("cost_glint", albedo=(albedo, 0 < albedo <= 1, "above 0 and at most 1"))
    if not (0 < share < 1 and 0 < meter < 1 and _is_filled(half_angle(share), meter)):
        must = "share and meter must be so small that the lamp fills the cone from all of the meter"
        raise tp.SceneError(f"cost_glint: {must}, got {share} and {meter}")
    up = 1 if seen == "lamp" else -1
    axis = (math.sin(TILT), 0.0, up * math.cos(TILT))
    disk = tp.Disk(normal=(0, 0, up), radius=meter * RADIUS)
    return tp.Scene(
        tp.Source(tp.Sphere(radius=RADIUS, mu_min=1 - 2 * LAMP), tp.Lambertian(power=POWER), side="back"),
        tp.Surface(tp.Sphere(radius=RADIUS, mu_max=2 * WALL - 1), tp.Diffuse(albedo), "wall"),
        tp.Detector(disk, "meter", directions=tp.Directions.cone(axis, half_angle(share))),
    )


def half_angle(share: float) -> float:
    """Of a cone that is that share of a hemisphere [rad]: 1 - cos = share."""
    return 2 * math.asin(math.sqrt(share / 2))


def _is_filled(angle: float, meter: float) -> bool:
    """Whether rays at the cone's steepest from the meter's rim end within the lamp's cap, the smaller of the two.

    A ray from the distance m of the middle at the angle t to the axis ends at t + asin(m cos t) or less from it.
    """
    t = TILT + angle
    return t < math.pi / 2 and t + math.asin(meter * math.cos(t)) < math.acos(1 - 2 * LAMP)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    return {RADIANCE: result["meter"].radiance[0]}


@of_scene(scene)
def exact(seen: str, albedo: float) -> dict[str, float]:
    area = 4 * math.pi * RADIUS**2
    if seen == "lamp":
        return {RADIANCE: POWER / (math.pi * LAMP * area)}
    return {RADIANCE: float(albedo * lamp_irradiance(POWER, albedo * WALL, area) / math.pi)}


def verdict(outcomes: list[Outcome]) -> str:
    said = [f"{o[RADIANCE].estimate} from the {o.given['seen']}" for o in outcomes]
    return f"In its cone the meter reads {', '.join(said)}; {furthest(outcomes)}."


draw = figures(rows=rows_figure("Radiance in one narrow cone of directions"))


if __name__ == "__main__":
    main(__file__)
