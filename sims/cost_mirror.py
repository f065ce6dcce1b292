"""The price of accuracy: a small lamp that a small meter sees by one mirror, by two, or in a mirror ball.

Derivation.  A flat mirror shows the lamp at the whole length d of the way, as bright as it is times the reflectance.
If the ray along the axes of both meets the mirrors at 45°, lamp and meter are two coaxial disks: for one point of
the meter on the axis

    E = ρ1 ρ2 π L sin²θ,   tan θ = r/d,

and for a meter of finite radius the view factor of coaxial disks takes the place of sin²θ.  A mirror ball shows the lamp as a tiny
disk.  With meter, lamp and ball on one axis, θ is the angle at which the ray that leaves the meter, and is reflected once,
meets the edge of the lamp (the law of reflection at the sphere, solved for θ).

Scene.  A disk lamp of 5 cm radius faces a mirror at 45°, that another may follow; a black screen hides the lamp from the meter.
Or a ball of 30 cm radius hangs 1 m from the meter, and the lamp 1 m behind it.  The meter has 1 mm radius.

What it teaches.  Flat mirrors show the meter at places that are known: "expected" sends its rays to these images, and two
coaxial disks are left to estimate.  The light of a ball can be connected to by no ray, and "expected" meets it as rarely as
"analog": of a hundred million births one ends on the meter.  Started at the meter, one history in forty thousand finds the
lamp.  The others go astray for the same reason, their first direction, and that can be learnt: a guide sends them where light
was found, and weighs them by one over the density.
"""

from __future__ import annotations

import math

import transport as tp
from transport.sims import figures, furthest, main, of_scene, one_of, require, rows_figure
from transport.theory.view_factors import coaxial_disks
from transport.verification.experiment import Outcome

law = "E = ρ1 ρ2 π L sin²θ at the whole length of the way; ρ π L sin²θ of the lamp's image in a ball"
question = "What does a digit cost of light that comes by mirrors?"
particles = 1_000_000
run = {"estimator": "backward"}  # of an analog run one history in a hundred million would count
intended = {
    "path class": "what a guide cannot reach is bounded by a warning; the exact value shows that little is there",
}

LAMP, POWER = 0.05, 100.0  # m, W
ARM = 1.0  # m, from lamp to mirror, from mirror to mirror, and half of the way from the last one to the meter
RHO = 0.9  # reflectance of each mirror
SIDE = 0.4  # m, of the mirrors
BALL, METER_AT, LAMP_AT = 0.3, 1.0, 2.0  # m: radius of the ball; of meter and lamp from its middle
LENGTHS = {"mirror": 3 * ARM, "periscope": 4 * ARM}  # m, of the way
WAYS = (*LENGTHS, "ball")
IRRADIANCE = "irradiance"


def cases() -> list[dict[str, str]]:
    return [{"by": by} for by in WAYS]


def scene(by: str = "mirror", meter: float = 1e-3, reflectance: float = RHO) -> tp.Scene:
    """A lamp and a meter of the radius `meter` [m] that sees it by one mirror, two (a periscope) or in a mirror ball.

    reflectance: of each.
    """
    one_of("cost_mirror", by=(by, WAYS))
    largest = 2e-3 if by == "ball" else 0.02  # m; the value of a ball is that of a point
    require("cost_mirror", meter=(meter, 0 < meter <= largest, f"above 0 and at most {largest:g} m"))
    require("cost_mirror", reflectance=(reflectance, 0 < reflectance <= 1, "above 0 and at most 1"))
    return _ball(meter, reflectance) if by == "ball" else _mirrors(by, meter, reflectance)


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


def _ball(meter: float, reflectance: float) -> tp.Scene:
    """The lamp shines down past the back of the meter, which looks at the ball."""
    lamp = tp.Source(
        tp.Disk(center=(0, 0, LAMP_AT), normal=(0, 0, -1), radius=LAMP), tp.Lambertian(power=POWER)
    )
    ball = tp.Surface(tp.Sphere(radius=BALL), tp.Mirror(reflectance), "ball")
    disk = tp.Disk(center=(0, 0, METER_AT), normal=(0, 0, -1), radius=meter)
    return tp.Scene(lamp, ball, tp.Detector(disk, "meter"))


def _reflected(angle: float) -> float:
    """Distance from the axis [m] at which the ray that leaves the meter at this angle from it meets the lamp's plane."""
    along, across = math.cos(angle), math.sin(angle)
    way = METER_AT * along - math.sqrt(BALL**2 - (METER_AT * across) ** 2)
    x, z = way * across, METER_AT - way * along  # where it meets the ball
    twice = 2 * (x * across - z * along) / BALL**2
    return x + (LAMP_AT - z) * (across - twice * x) / (-along - twice * z)


def angle_in_ball() -> float:
    """Angle [rad] from the axis to the edge of the lamp's image."""
    from scipy.optimize import brentq

    return brentq(lambda angle: _reflected(angle) - LAMP, 0.0, 0.1 * math.asin(BALL / METER_AT), xtol=1e-16)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    return {IRRADIANCE: result["meter"].irradiance}


@of_scene(scene)
def exact(by: str, meter: float, reflectance: float) -> dict[str, float]:
    if by == "ball":
        return {IRRADIANCE: reflectance * POWER / (math.pi * LAMP**2) * math.sin(angle_in_ball()) ** 2}
    seen = coaxial_disks(meter, LAMP, LENGTHS[by])
    mirrors = 2 if by == "periscope" else 1
    return {IRRADIANCE: reflectance**mirrors * POWER / (math.pi * LAMP**2) * float(seen)}


def verdict(outcomes: list[Outcome]) -> str:
    said = [f"{o.rows[0].estimate} by {o.given['by']}" for o in outcomes]
    return f"The meter reads {', '.join(said)}; {furthest(outcomes)}."


draw = figures(rows=rows_figure("Light by mirrors"))


if __name__ == "__main__":
    main(__file__)
