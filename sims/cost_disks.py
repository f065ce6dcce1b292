"""The price of accuracy: direct light, from a large lamp to a large detector.

Derivation.  A diffuse disk of the radius r₁ and the radiance L sends the flux

    Φ = π L A₁ F₁₂,   F₁₂ = (2 r₂/(p + m))²,

to a coaxial disk of the radius r₂ at the distance h, where p and m are the longest and the shortest straight
line between their rims, p² = h² + (r₁ + r₂)², m² = h² + (r₁ - r₂)² (Howell, A Catalog of Radiation Heat
Transfer Configuration Factors, C-41; without its difference).  It is the mean of π L A₁ A₂ cosθ₁ cosθ₂/π r²
over pairs of places, one on each disk: an integral over the unit cube of four dimensions, whose integrand is
smooth where the disks do not touch.

Scene.  Two facing disks, both of the radius 1 at the distance 1, where F₁₂ = (3 - √5)/2, and nothing else.

What it teaches.  Of N analog histories the share F₁₂ crosses the meter: hits or misses, a relative error of
√((1 - F)/F N) = 1.3/√N.  Ten times the accuracy costs a hundred times the time, and 1e-7 takes 1.6e14
histories.  Told where the detector is, every history scores, and what is left is how much cosθ₁ cosθ₂/r²
varies; still 1/√N.  Only what comes after that changes the slope: on a smooth integral of few dimensions
evenly spread points (Owen-scrambled Sobol) are better with every point, at least as 1/N, whereas hits and
misses have an edge that even points gain less from.  First make the integrand smooth, then spread the points.
"""

from __future__ import annotations

import math

import transport as tp
from transport.sims import figures, furthest, main, of_scene, rows_figure
from transport.theory.view_factors import coaxial_disks
from transport.verification.experiment import Outcome

law = "Φ = π L A₁ F₁₂, F₁₂ = (2 r₂/(p + m))² of coaxial disks (Howell, C-41)"
question = "What does a digit cost where a large lamp lights a large meter, with nothing between?"
particles = 1_000_000

FLUX = "flux"


def scene(radius: float = 1.0, meter: float = 1.0, distance: float = 1.0, radiance: float = 1.0) -> tp.Scene:
    """A disk of that radius and radiance [W m^-2 sr^-1] that faces a coaxial one of the radius `meter`; lengths in m."""
    lamp = tp.Source(tp.Disk(radius=radius), tp.Lambertian(radiance=radiance))
    disk = tp.Disk(center=(0, 0, distance), normal=(0, 0, -1), radius=meter)
    return tp.Scene(lamp, detectors=tp.Detector(disk, "meter"))


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    return {FLUX: result["meter"].flux_in}


@of_scene(scene)
def exact(radius: float, meter: float, distance: float, radiance: float) -> dict[str, float]:
    power = math.pi * radiance * math.pi * radius**2
    return {FLUX: float(power * coaxial_disks(radius, meter, distance))}


def verdict(outcomes: list[Outcome]) -> str:
    row = outcomes[0][FLUX]
    return f"The meter receives {row.estimate}, exactly {row.exact:.7g} W; {furthest(outcomes)}."


draw = figures(rows=rows_figure("Disk to disk, direct light"))


if __name__ == "__main__":
    main(__file__)
