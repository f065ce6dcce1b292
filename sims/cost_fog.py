"""The price of accuracy: a lamp in thick fog, and a small meter outside.

Derivation.  A ball of fog of optical radius τ, in whose middle a smaller ball emits evenly in all directions.
Each particle is scattered again and again until it is absorbed or gets out; the share P gets out, by the
integral equation of transport, which in a sphere is that of a slab with odd sources (Davison 1957; Case, de
Hoffmann and Placzek 1953; solved in transport/theory/fog_balls.py).  Outside there is nothing to meet, and
the net flux through any closed surface about the ball is P Φ (Gauss): being the same on all sides, at the
distance d from the middle it is P Φ/4πd² along the radius.  A disk that faces the ball, all of which is
before its plane, is crossed one way only, and receives what it would from a point,

    Φ_meter = P Φ (1 - cosα)/2,   tanα = (radius of the disk)/d.

Fog that absorbs nothing takes nothing away, P = 1, however thick it is: it only hides where the light comes from.

Scene.  A ball of fog of 1 m radius, τ = 10, its lamp of 0.1 m radius and 1 W, a disk of 0.2 m radius at 1.25
m.  Scattering is isotropic; without absorption a particle collides 57 times (half of τ² is 50).

What it teaches.  Each history pays for its collisions, as τ², whether it is of use or not.  Whoever waits for
particles at the meter loses twice: what is absorbed on the way (96 % at the albedo 0.9), and what gets out
elsewhere (99 % of the rest).  Weights that fade where particles would die, which is what runs do here unless
told otherwise, spare the first loss, at the price of longer histories.  A ray from each collision to the meter
spares the second, so that the price no longer depends on the meter's size; but every ray must be followed
through the fog, and those from deep within bring next to nothing.  A history that starts at the meter meets
the same fog from its other side, and then has to find the lamp.  For a meter as large as this one the three
cost alike within a small factor; for one of a quarter of its radius whoever waits pays sixteen times as much
as before, the others what they did.  No way around makes the fog thinner: the price of a digit can be divided
by some number, its slope stays.
"""

from __future__ import annotations

import transport as tp
from transport.sims import figures, furthest, main, of_scene, require, rows_figure
from transport.theory.emitters import point_flux_through_disk
from transport.theory.fog_balls import MAX_RADIUS, escape
from transport.verification.experiment import Outcome

law = "Φ_meter = P Φ(1 - cosα)/2, r φ = ½ ∫ E₁(|r - t|)(ϖ t φ + t q) dt (Davison 1957; Case et al. 1953)"
question = "What does a digit cost outside of thick fog that hides the lamp?"
particles = 500_000
run = {"estimator": "expected"}  # at its price; `transport cost` runs every way

POWER = 1.0  # W
FLUX = "flux"


def cases() -> list[dict[str, float]]:
    return [{"albedo": albedo} for albedo in (1.0, 0.9)]


def scene(
    tau: float = 10.0,
    albedo: float = 1.0,
    meter: float = 0.2,
    distance: float = 1.25,
    lamp: float = 0.1,
    radius: float = 1.0,
) -> tp.Scene:
    """A ball of fog of the optical radius `tau`, a lamp in it, and a disk outside.

    albedo: of the fog;  radius: of the ball [m];  meter, distance, lamp: radius of the disk, its distance from
    the middle, and radius of the lamp, over the ball's radius.
    """
    require(
        "cost_fog",
        tau=(tau, 0 < tau <= MAX_RADIUS, f"above 0 and at most {MAX_RADIUS:g}"),
        albedo=(albedo, 0 <= albedo <= 1, "from 0 to 1"),
        lamp=(lamp, 0 < lamp < 1, "above 0 and below 1, the ball's radius"),
        distance=(distance, distance > 1, "above 1, the ball's radius"),
        meter=(meter, meter > 0, "above 0"),
    )
    extinction = tau / radius
    fog = tp.Medium(absorption=(1 - albedo) * extinction, scattering=albedo * extinction)
    disk = tp.Disk(center=(0, 0, distance * radius), normal=(0, 0, -1), radius=meter * radius)
    return tp.Scene(
        tp.Source(tp.Sphere(radius=lamp * radius), tp.Isotropic(power=POWER)),
        tp.Surface(tp.Sphere(radius=radius), tp.Transparent(), "fog", inside=fog),
        tp.Detector(disk, "meter"),
    )


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    return {FLUX: result["meter"].flux_in}


@of_scene(scene)
def exact(tau: float, albedo: float, meter: float, distance: float, lamp: float) -> dict[str, float]:
    share = 1.0 if albedo == 1 else escape(tau, albedo, lamp * tau)
    return {FLUX: float(share * point_flux_through_disk(POWER, meter, distance))}


def verdict(outcomes: list[Outcome]) -> str:
    said = [f"{o[FLUX].estimate} at the albedo {o.given['albedo']:g}" for o in outcomes]
    return f"Through the fog the meter receives {', '.join(said)}; {furthest(outcomes)}."


draw = figures(rows=rows_figure("A lamp in thick fog, seen from outside"))


if __name__ == "__main__":
    main(__file__)
