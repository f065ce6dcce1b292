"""The sun: its radiance from its power and size, and what falls on a square metre at the Earth and on Mars.

Derivation.  As a diffuse emitter of the power P = 3.91e26 W and the area A = 6.07e18 m² the sun has the radiance
L = P/(π A) = 2.05e7 W m⁻² sr⁻¹ (Bala 2009, Cornell CS 6620, lecture 2, "Sun example").  Radiance is invariant along a
ray, so it is the same at both planets; only the solid angle is not.  A square metre that faces the sun receives

    Φ = L · 1 m² · π (R/d)²,   exactly, as long as the whole sun is above its horizon (Lambert 1760),

where π (R/d)², the projected solid angle of a sphere, is what the lecture takes as the sun's solid angle; tilted by
the zenith angle θ it receives cosθ of that, less what is below the horizon (geometry/solid_angles.py).

Two cases.  The lecture's solid angles 6.7e-5 and 2.92e-5 sr give 1374 and 599 W; they are the sun's from 1.505e11 and
2.280e11 m.  The planets' mean distances 1.496e11 and 2.279e11 m give 1390 and 599 W.  At the Earth the two differ by
1.2 %: 6.7e-5 sr is rounded down from 6.78e-5 sr.

The sources' two radiances.  2.05e7 is a mean over the disk.  Another source has 2.3e7 W m⁻² sr⁻¹ at the sun
(Scratchapixel, on radiometric quantities; sims/fog.py), 12 % more.  Neither power nor area explains it: today's 3.828e26 W and 6.957e8 m (IAU 2015,
nominal values) give 2.00e7, of which 2.3e7 is 1.15 times.  An inference of ours, which no source states: the sun's disk
is brighter in its middle.  Of a grey atmosphere (Milne; the H-function of sims/half_space.py) the middle has 1.26 times
the mean, 2.52e7, and of a linear darkening with u = 0.6 it has 1/(1 − u/3) = 1.25 times.  So 2.3e7 lies between
the mean and the middle, as a radiance read away from the rim would; whether it was read there, we do not know.

Scene.  A sphere and, eleven decades of length smaller, a square metre at which the directions are aimed.  The scene's
coordinates have their origin in the smallest shape, so that nothing is lost.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import figures, main, of_scene
from transport.theory import emitters
from transport.verification.experiment import Outcome

law = "L = P/(π A) = 2.05e7 W m^-2 sr^-1, power on 1 m²: L π (R/d)² cosθ (Bala 2009, Cornell CS 6620, lecture 2)"
question = "What power of the sun falls on a square metre at the Earth and on Mars, and is its radiance the same there?"
particles = 10_000_000

RADIUS = float(emitters.sphere_radius(emitters.AREA))  # m
DISTANCES = {  # m
    ("Earth", "solid angle"): float(emitters.distance_of_projected_area(RADIUS, emitters.SOLID_ANGLE_EARTH)),
    ("Mars", "solid angle"): float(emitters.distance_of_projected_area(RADIUS, emitters.SOLID_ANGLE_MARS)),
    ("Earth", "distance"): 1.496e11,  # one astronomical unit (IAU 2012), rounded
    ("Mars", "distance"): 2.279e11,  # 1.5237 au, its semi-major axis (Standish, JPL: elements of the planets)
}
POWER, RADIANCE = "power on 1 m^2", "radiance"
FULL = 0.87  # of the colour map, the colour of the sun's radiance


def cases() -> list[dict[str, str]]:
    return [{"planet": planet, "given": given} for planet, given in DISTANCES]


def scene(planet: str = "Earth", given: str = "distance", zenith_angle: float = 0.0) -> tp.Scene:
    """The sun and a square metre.  given: "solid angle" or "distance" of the planet;  zenith_angle: of the sun [rad]."""
    distance = _distance(planet, given)
    normal = (-math.cos(zenith_angle), 0, math.sin(zenith_angle))
    meter = tp.Rectangle(center=(distance, 0, 0), normal=normal, width=1, height=1)
    face = tp.Directions.cone((-1, 0, 0), math.asin(RADIUS / distance))
    return tp.Scene(
        sources=tp.Source(tp.Sphere(radius=RADIUS), tp.Lambertian(power=emitters.POWER), aim=meter),
        detectors=tp.Detector(meter, name="meter", directions=face),
    )


def _distance(planet: str, given: str) -> float:
    if (planet, given) not in DISTANCES:
        cure = "planet is 'Earth' or 'Mars', given is 'solid angle' or 'distance'"
        raise tp.SceneError(f"no {given} of {planet}; {cure}")
    return DISTANCES[planet, given]


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    return {POWER: result["meter"].flux_in, RADIANCE: result["meter"].radiance[0]}


@of_scene(scene)
def exact(planet: str, given: str, zenith_angle: float) -> dict[str, float]:
    radiance, distance = emitters.surface_radiance(emitters.POWER, emitters.AREA), _distance(planet, given)
    power = emitters.sphere_irradiance(radiance, RADIUS, distance, math.cos(zenith_angle))
    return {POWER: float(power), RADIANCE: radiance}


def verdict(outcomes: list[Outcome]) -> str:
    found = {(o.given["planet"], o.given["given"]): o for o in outcomes}
    powers = [f"{o[POWER].estimate} ({planet}, by {given})" for (planet, given), o in found.items()]
    said = f"A square metre receives {', '.join(powers)}."
    if {("Earth", "solid angle"), ("Earth", "distance")} <= found.keys():
        said += (
            " The Earth's two differ because the lecture's 6.7e-5 sr is the sun seen from 1.505e11 m;"
            " from 1.496e11 m it fills 6.78e-5 sr."
        )
    radiances = [o[RADIANCE].estimate for o in outcomes]
    if len({planet for planet, _ in found}) > 1:
        said += f" The radiance is the same at both planets: {radiances[0]} and {radiances[1]}."
    return said


def draw_suns(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The sun as each planet sees it, to one scale, its colour the radiance; beside it the power on a square metre."""
    from transport.viz.style import figure

    with figure((19, 8.6), "The sun looks smaller from Mars, and just as bright", note, path) as page:
        sky, chart = page.subplots(1, 2, width_ratios=(1.15, 1))
        _draw_sky(sky, {o.given["planet"]: o for o in outcomes})
        _draw_powers(chart, outcomes)


def _draw_sky(axes, seen: dict[str, Outcome]) -> None:
    """A disk per planet on a black sky; the same colour is the same radiance."""
    from matplotlib import colormaps
    from matplotlib.patches import Circle

    from transport.viz.style import SEQUENTIAL
    from transport.viz.wording import number_text

    surface, white = (
        emitters.surface_radiance(emitters.POWER, emitters.AREA),
        {"color": "white", "ha": "center"},
    )
    for place, (planet, outcome) in zip((-21, 21), seen.items(), strict=False):
        radiance = outcome[RADIANCE].estimate
        size = 2 * math.degrees(math.asin(RADIUS / _distance(planet, outcome.given["given"]))) * 60
        colour = colormaps[SEQUENTIAL](FULL * radiance.value / surface)
        axes.add_patch(Circle((place, 0), size / 2, color=colour, lw=0))
        axes.text(place, 27, planet, fontsize=30, fontweight="bold", va="center", **white)
        axes.text(place, 20.5, f"{size:.0f}\N{PRIME} across", fontsize=22, va="center", **white)
        axes.text(place, -23, number_text(radiance, 1e-6), fontsize=24, va="center", **white)
    if len(seen) > 1:
        axes.text(0, -30.5, "same colour, same L  [MW m$^{-2}$ sr$^{-1}$]", fontsize=22, va="center", **white)
    axes.set(aspect="equal", xlim=(-42, 42), ylim=(-36, 33), facecolor="black", xticks=[], yticks=[])
    axes.spines[:].set_visible(False)


def _draw_powers(axes, outcomes: list[Outcome]) -> None:
    """Power on a square metre against the distance, dashed what it would be if radiance fell with it."""
    from transport.viz.style import BLUE, INK, POINTS, PURPLE
    from transport.viz.wording import number_text

    radiance, mu = (
        emitters.surface_radiance(emitters.POWER, emitters.AREA),
        math.cos(outcomes[0].given["zenith_angle"]),
    )
    distances = np.linspace(0.7, 1.9, 301)
    powers = emitters.sphere_irradiance(radiance, RADIUS, distances * tp.au, mu)
    axes.plot(distances, powers, color=INK, lw=3, label="L π (R/d)²:\nL stays")
    axes.plot(distances, powers / distances**2, "--", color=PURPLE, lw=3.4, label="wrong: L falls too")
    axes.set_ylim(0, 1.02 * powers.max() or 1.0)
    for outcome in outcomes:
        planet, power = outcome.given["planet"], outcome[POWER].estimate
        distance = _distance(planet, outcome.given["given"]) / tp.au
        axes.errorbar(distance, power.value, 2 * power.error, fmt="o", color=BLUE, ms=14, zorder=4, **POINTS)
    for planet, outcome in {o.given["planet"]: o for o in outcomes}.items():
        power = outcome[POWER].estimate
        place = _distance(planet, outcome.given["given"]) / tp.au, power.value
        words = f"{planet}\n{number_text(power)}"
        axes.annotate(
            words, place, (14, 8), textcoords="offset points", color=BLUE, fontweight="bold", fontsize=21
        )
    axes.set(xlabel="distance from the sun  [au]", ylabel="power on 1 m²  [W]")
    axes.legend(loc="upper right", fontsize=20)


draw = figures(suns=draw_suns)


if __name__ == "__main__":
    main(__file__)
