"""The price of accuracy: a detector so small that hardly anything ever comes to it.

Derivation.  A disk of the radius a that faces a point at the distance d fills the share

    s = (1 - cosα)/2,   tanα = a/d

of the sphere about it, and receives s Φ of an isotropic point's power Φ.  A ball that glows evenly, clear to
its own light, sends through the disk what a point in its middle would: each point of the ball adds its flux
over r² along r, as masses add their attraction, and a ball of them attracts as its centre does (Newton 1687,
book 1, prop. 74); the flux through the disk is that of the sum, as long as all of the ball is before the
disk's plane.  The same holds for a diffuse sphere, F = s (Howell, A Catalog of Radiation Heat Transfer
Configuration Factors, C-136).  A diffuse disk of the radius r sends F₁₂ = (2 a/(p + m))² of its power, p² =
d² + (r + a)², m² = d² + (r - a)² (Howell, C-41).

Scene.  A lamp of 1 W, a point or of the radius 0.1 m, and at 1 m a speck that fills s = 1e-10 of the sphere:
a disk of 20 µm radius.  `share` makes it larger.

What it teaches.  An analog run waits for a hit: one in 1/s = 1e10 histories, and for 0.1 % it needs 1e6 hits,
1e16 histories, ten years at thirty million a second.  Before the first hit it says 0 and knows no error: an
error bar speaks of what has been seen.  A history that is told where the detector is always scores, and with
nearly equal weights: the smaller the speck, the less they differ.  It is the same at s = 1e-3 as at 1e-10;
the price does not depend on the detector's size any more.  So it is worth asking before a long run which
share of the histories can score at all.
"""

from __future__ import annotations

import math

import transport as tp
from transport.sims import figures, furthest, main, of_scene, one_of, require, rows_figure
from transport.theory.view_factors import coaxial_disks
from transport.verification.experiment import Outcome

law = "Φ = s P of a point, a glowing ball, a diffuse sphere, s = (1 - cosα)/2; F₁₂ P of a disk (Newton 1687; Howell, C-41, C-136)"
question = "What does a digit cost where one particle in ten thousand million comes to the meter?"
particles = 100_000
run = {"estimator": "expected"}  # an analog run would count nothing

LAMPS = ("disk", "sphere", "ball", "point")
POWER, SIZE = 1.0, 0.1  # W; m, radius of a lamp
FLUX = "flux"


def cases() -> list[dict[str, object]]:
    return [{"lamp": lamp} for lamp in LAMPS]


def scene(lamp: str = "disk", share: float = 1e-10, distance: float = 1.0, size: float = SIZE) -> tp.Scene:
    """A lamp, and a disk that faces it and fills that share of the sphere about its middle.

    lamp: a "point", a "ball" that glows evenly, or a diffuse "sphere" or "disk", of the radius `size` [m];
    distance: from its middle [m].
    """
    one_of("cost_speck", lamp=(lamp, LAMPS))
    must = f"above 0 and below the distance, {distance} m"
    require(
        "cost_speck",
        share=(share, 0 < share < 0.5, "above 0 and below 0.5"),
        size=(size, 0 < size < distance, must),
    )
    speck = tp.Disk(center=(0, 0, distance), normal=(0, 0, -1), radius=speck_radius(share, distance))
    shape, emission = {
        "point": (tp.Point(), tp.Isotropic(power=POWER)),
        "ball": (tp.Sphere(radius=size), tp.Isotropic(power=POWER)),
        "sphere": (tp.Sphere(radius=size), tp.Lambertian(power=POWER)),
        "disk": (tp.Disk(radius=size), tp.Lambertian(power=POWER)),
    }[lamp]
    return tp.Scene(tp.Source(shape, emission), detectors=tp.Detector(speck, "speck"))


def speck_radius(share: float, distance: float) -> float:
    """Radius of a disk that fills that share of the sphere about a point on its axis [m]."""
    return distance * 2 * math.sqrt(share * (1 - share)) / (1 - 2 * share)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    return {FLUX: result["speck"].flux_in}


@of_scene(scene)
def exact(lamp: str, share: float, distance: float, size: float) -> dict[str, float]:
    if lamp == "disk":
        return {FLUX: float(POWER * coaxial_disks(size, speck_radius(share, distance), distance))}
    return {FLUX: POWER * share}


def verdict(outcomes: list[Outcome]) -> str:
    said = [f"{o[FLUX].estimate} from a {o.given['lamp']}" for o in outcomes]
    return f"Of {POWER:g} W the speck receives {', '.join(said)}; {furthest(outcomes)}."


draw = figures(rows=rows_figure("A detector that fills a tiny share of the sphere"))


if __name__ == "__main__":
    main(__file__)
