"""The price of accuracy: light that comes by way of glass, where no straight ray leads from lamp to meter.

Derivation.  Along a ray that is refracted L/n² does not change but for what is reflected at the boundary
(Straubel 1902), and reflectance is the same from both sides.  A clear ball of the index n within a lamp that
surrounds it, of the radiance L: where T is the transmittance at a ray's angle, inside

    L_in = T n² L + (1 - T) L_in,   so that L_in = n² L,

by what enters and what is reflected within, for every ray that leaves the ball somewhere.  Those are all rays
that pass the middle nearer than R/n, and so all that meet a disk in the middle smaller than this: it reads E
= π n² L.  Outside, a ray to the ball brings the share 1 - T of L that is reflected and T L_in/n²: again L, as
if there were no ball.

Scene.  A glass ball of 1 m radius, n = 1.5, within a sphere of 2 m whose inside glows.  The meter is a disk,
in the ball's middle, or outside below it with one cone of directions, all of which end on the glass.

What it teaches.  What glass bends cannot be connected: no point of the lamp knows which direction would end
at the meter after two refractions, so that rays from lamp to meter see nothing, and what they cannot see must
be counted as it comes.  There, "expected" is as dear as analog.  A history that starts at the meter is bent
by the same laws and comes to the lamp, which is large; every one scores the same n² L.  Which end to begin at
is a question of which one is easier to hit: start from the small one.
"""

from __future__ import annotations

import math

import transport as tp
from transport.sims import figures, furthest, main, of_scene, one_of, require, rows_figure
from transport.verification.experiment import Outcome

law = "L_in = n² L in glass, L behind it (Straubel 1902)"
question = "What does a digit cost where all light comes through glass?"
particles = 1_000_000

BALL, LAMP, PLACE = 1.0, 2.0, -1.5  # m: radii of glass and lamp, height of the meter behind the glass
CONE = 0.5  # rad, half angle of directions behind the glass
PLACES = ("behind", "inside")
IRRADIANCE, RADIANCE = "irradiance within the glass", "radiance through the glass"


def cases() -> list[dict[str, str]]:
    return [{"place": place} for place in PLACES]


def scene(place: str = "behind", index: float = 1.5, meter: float = 0.25, radiance: float = 1.0) -> tp.Scene:
    """A glass ball in a lamp of that radiance [W m^-2 sr^-1] all about it, and a disk of the radius `meter` [m].

    place: of the meter, "inside", in the ball's middle, or "behind" it, below.
    """
    one_of("cost_caustic", place=(place, PLACES))
    require("cost_caustic", index=(index, 1 < index < math.inf, "above 1, of glass in vacuum"))
    largest = largest_meter(place, index)
    must = f"above 0 and below {largest:.4g} m, where all rays come through the glass"
    require("cost_caustic", meter=(meter, 0 < meter < largest, must))
    inside = place == "inside"
    disk = tp.Disk(center=(0, 0, 0 if inside else PLACE), radius=meter)
    cone = None if inside else tp.Directions.cone((0, 0, 1), CONE)
    return tp.Scene(
        tp.Source(tp.Sphere(radius=LAMP), tp.Lambertian(radiance=radiance), side="back"),
        tp.Surface(tp.Sphere(radius=BALL), tp.Dielectric(index), "ball"),
        tp.Detector(disk, "meter", directions=cone),
    )


def largest_meter(place: str, index: float) -> float:
    """Radius of the largest disk all of whose rays, or of those in its cone, come through the glass [m]."""
    if place == "inside":
        return BALL / index
    return (BALL - abs(PLACE) * math.sin(CONE)) / math.cos(CONE)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    meter = result["meter"]
    if meter.detector.directions is None:
        return {IRRADIANCE: meter.irradiance}
    return {RADIANCE: meter.radiance[0]}


@of_scene(scene)
def exact(place: str, index: float, radiance: float) -> dict[str, float]:
    if place == "inside":
        return {IRRADIANCE: math.pi * index**2 * radiance}
    return {RADIANCE: radiance}


def verdict(outcomes: list[Outcome]) -> str:
    said = [f"{o.rows[0].estimate} {o.given['place']}" for o in outcomes]
    return f"The meter reads {', '.join(said)}; {furthest(outcomes)}."


draw = figures(rows=rows_figure("Light by way of glass"))


if __name__ == "__main__":
    main(__file__)
