"""The price of accuracy: a small lamp that a small meter sees by one mirror, by two, or by a dish.

Derivation.  A flat mirror shows the lamp at the whole length d of the way, as bright as it is times the reflectance.
If the ray along the axes of both meets the mirrors at 45°, lamp and meter are two coaxial disks: for one point of
the meter on the axis

    E = ρ1 ρ2 π L sin²θ,   tan θ = r/d,

and for a meter of finite radius the view factor of coaxial disks takes the place of sin²θ.  A paraboloid shows a lamp that
fills its beam of rays as wide as its own rim: from its focus each ray to the dish leaves along the axis (Diocles), and so
ends on the lamp.  The meter sees a disk of radiance ρ L, the rim.

Scene.  A disk lamp of 5 cm radius faces a mirror at 45°, that another may follow; a black screen hides the lamp from the meter.
Or a dish of 60 cm and 50 cm focal length below a wide lamp.  The meter has 1 mm radius.

What it teaches.  Flat mirrors show the meter at places that are known: "expected" sends its rays to these images, and two
coaxial disks are left to estimate.  What a dish sends can be connected to by no ray, and "expected" meets it as rarely as
"analog": of a hundred million births one ends on the meter.  Started at the meter, one history in thousands finds the lamp.
Nearly all of these histories go astray for the same reason, their first direction, and that can be learnt: a guide sends
them where light was found, and weighs them by one over the density.
"""

from __future__ import annotations

import math

import transport as tp
from transport.sims import figures, furthest, main, of_scene, one_of, require, rows_figure
from transport.theory.view_factors import coaxial_disks
from transport.verification.experiment import Outcome

law = "E = ρ1 ρ2 π L sin²θ at the whole length of the way; π L sin²θ of a dish's rim at its focus"
question = "What does a digit cost of light that comes by mirrors?"
particles = 1_000_000
run = {"estimator": "backward"}  # of an analog run one history in a hundred million would count

LAMP, POWER = 0.05, 100.0  # m, W
ARM = 1.0  # m, from lamp to mirror, from mirror to mirror, and half of the way from the last one to the meter
RHO = 0.9  # reflectance of each mirror
SIDE = 0.4  # m, of the mirrors
FOCAL, RIM, WIDE_LAMP, LAMP_HEIGHT = 0.5, 0.3, 0.6, 2.0  # m: of the dish and its lamp
LENGTHS = {"mirror": 3 * ARM, "periscope": 4 * ARM}  # m, of the way
WAYS = (*LENGTHS, "dish")
IRRADIANCE = "irradiance"


def cases() -> list[dict[str, str]]:
    return [{"by": by} for by in WAYS]


def scene(by: str = "mirror", meter: float = 1e-3, reflectance: float = RHO) -> tp.Scene:
    """A lamp and a meter of the radius `meter` [m] that sees it by one mirror, two (a periscope) or a dish.

    reflectance: of each.
    """
    one_of("cost_mirror", by=(by, WAYS))
    require("cost_mirror", meter=(meter, 0 < meter <= 0.02, "above 0 and at most 0.02 m"))
    require("cost_mirror", reflectance=(reflectance, 0 < reflectance <= 1, "above 0 and at most 1"))
    return _dish(meter, reflectance) if by == "dish" else _mirrors(by, meter, reflectance)


def _mirrors(by: str, meter: float, reflectance: float) -> tp.Scene:
    """The lamp at the origin shines along x; the first mirror turns its light up, the second along x again."""
    lamp = tp.Source(tp.Disk(normal=(1, 0, 0), radius=LAMP), tp.Lambertian(power=POWER))
    half = math.sqrt(0.5)
    frame = {"up": (0, 1, 0), "width": SIDE, "height": SIDE}
    lower = tp.Rectangle(center=(ARM, 0, 0), normal=(-half, 0, half), **frame)
    upper = tp.Rectangle(center=(ARM, 0, ARM), normal=(half, 0, -half), **frame)
    mirrors = [tp.Surface(lower, tp.Mirror(reflectance), "lower")]
    if by == "periscope":
        mirrors.append(tp.Surface(upper, tp.Mirror(reflectance), "upper"))
    # The screen has a hole where the light goes up.
    hole = tp.Rectangle(center=(ARM, 0, ARM / 2), **frame)
    screen = tp.Rectangle(center=(ARM, 0, ARM / 2), up=(0, 1, 0), width=10, height=10, hole=hole)
    place, normal = ((ARM, 0, 2 * ARM), (0, 0, -1)) if by == "mirror" else ((3 * ARM, 0, ARM), (-1, 0, 0))
    disk = tp.Disk(center=place, normal=normal, radius=meter)
    return tp.Scene(lamp, [*mirrors, tp.Surface(screen, tp.Black(), "screen")], tp.Detector(disk, "meter"))


def _dish(meter: float, reflectance: float) -> tp.Scene:
    """The dish shines up; the lamp is wider than its rim."""
    disk = tp.Disk(center=(0, 0, LAMP_HEIGHT), normal=(0, 0, -1), radius=WIDE_LAMP)
    dish = tp.Surface(tp.Paraboloid(focal_length=FOCAL, radius=RIM), tp.Mirror(reflectance), "dish")
    focus = tp.Disk(center=(0, 0, FOCAL), normal=(0, 0, -1), radius=meter)
    return tp.Scene(tp.Source(disk, tp.Lambertian(power=POWER)), dish, tp.Detector(focus, "meter"))


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    return {IRRADIANCE: result["meter"].irradiance}


@of_scene(scene)
def exact(by: str, meter: float, reflectance: float) -> dict[str, float]:
    if by == "dish":
        seen = coaxial_disks(meter, RIM, FOCAL - RIM**2 / (4 * FOCAL))
        return {IRRADIANCE: reflectance * POWER / (math.pi * WIDE_LAMP**2) * float(seen)}
    seen = coaxial_disks(meter, LAMP, LENGTHS[by])
    mirrors = 2 if by == "periscope" else 1
    return {IRRADIANCE: reflectance**mirrors * POWER / (math.pi * LAMP**2) * float(seen)}


def verdict(outcomes: list[Outcome]) -> str:
    said = [f"{o.rows[0].estimate} by {o.given['by']}" for o in outcomes]
    return f"The meter reads {', '.join(said)}; {furthest(outcomes)}."


draw = figures(rows=rows_figure("Light by mirrors"))


if __name__ == "__main__":
    main(__file__)
