"""Inverse square: a point source over six decades of distance, and how far away a disk must be to count as a point.

Derivation.  An isotropic point of power P has the intensity I = P/4π, and spreads P evenly over spheres of area 4π r²,
so that E = P cosθ/(4π r²) (Lambert 1760; Bala 2009, Cornell CS 6620, lecture 2, "Irradiance example").  Over a disk of
radius a that faces it the mean is P/(2π h (h + r)), h² = r² + a²: at a = r/2 the same share of P at every r.

The five-times rule (Lambert 1760; Akenine-Möller, Haines, Hoffman 2008, 7.1).  A Lambert disk of radius R has on its
axis E = π L R²/(R² + d²), its inverse-square law is π L R²/d²: the ratio 1/(1 + R²/d²) is 1/1.01 from five diameters.
A Lambert sphere has E = π L R²/d² at any distance d > R of its centre, so that its ratio is exactly 1.
The mean over the meter of 1 mm is lower than on the axis, by up to 8e-7 of it, which a run by Sobol points sees.

Scene.  Seven disks around one point, each half as large as it is far and each in a direction of its own; or a disk or
sphere of one metre, with a small meter at which directions are aimed.
"""

from __future__ import annotations

import math
from pathlib import Path

import transport as tp
from transport.sims import constant, curves_figure, figures, grouped, main, of_scene, one_of, sentence, where
from transport.theory import emitters
from transport.verification.experiment import Outcome

law = "E = P cosθ/4πr²; a disk from five diameters: 1/1.01 of it, a sphere: 1 (Lambert 1760; Akenine-Möller et al. 2008)"
question = (
    "Does irradiance fall with the square of the distance, and from where on for sources that are no points?"
)
particles = 2_000_000

DISTANCES = {
    "1 mm": 1e-3, "1 cm": 1e-2, "10 cm": 0.1, "1 m": 1.0, "10 m": 10.0, "100 m": 100.0, "1 km": 1000.0
}  # fmt: skip
DIRECTIONS = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 2, 0), (0, -1, 2), (2, 0, -1), (-1, -1, -1))
WIDTH = 1.0  # m, diameter of the disk and of the sphere
METER = 1e-3  # m, radius of the meter that looks at them
WIDTHS = 0.75, 1.0, 2.0, 5.0, 10.0  # distances of the disk and of the sphere, in diameters
RATIO = "irradiance / inverse square"


def cases() -> list[dict[str, object]]:
    kinds = ("disk", "sphere")
    return [{"emitter": "point"}, *({"emitter": kind, "widths": n} for kind in kinds for n in WIDTHS)]


def scene(emitter: str = "point", power: float = 100.0, widths: float = 5.0) -> tp.Scene:
    """Meters around a point; or one meter as many `widths` away from the middle of a disk or sphere.  power [W]."""
    one_of("inverse_square", emitter=(emitter, ("point", "disk", "sphere")))
    if emitter == "point":
        detectors = [_facing(n, r, name) for (name, r), n in zip(DISTANCES.items(), DIRECTIONS, strict=True)]
        return tp.Scene(sources=tp.Source(tp.Point(), tp.Isotropic(power=power)), detectors=detectors)
    shapes = {"disk": tp.Disk(radius=WIDTH / 2), "sphere": tp.Sphere(radius=WIDTH / 2)}
    meter = tp.Disk(center=(0, 0, widths * WIDTH), normal=(0, 0, -1), radius=METER)
    source = tp.Source(shapes[emitter], tp.Lambertian(power=power), aim=meter)
    return tp.Scene(sources=source, detectors=tp.Detector(meter, name="meter"))


def _facing(direction: tuple[float, ...], distance: float, name: str) -> tp.Detector:
    """A disk in that direction from the origin which looks back at it."""
    length = math.hypot(*direction)
    center = [distance * x / length for x in direction]
    return tp.Detector(tp.Disk(center=center, normal=[-x for x in direction], radius=distance / 2), name=name)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    source = result.scene.sources[0]
    if isinstance(source.shape, tp.Point):
        rows = {f"irradiance at {name}": result[name].irradiance for name in DISTANCES}
        return rows | {"E(1 mm) / E(1 km)": result["1 mm"].irradiance / result["1 km"].irradiance}
    distance = result.scene.detectors[0].shape.center[2]
    seen = math.pi * source.shape.radius**2
    intensity = source.emission.power / (math.pi * source.shape.area) * seen  # L times the area that is seen
    point = constant(result, intensity / distance**2, "W m^-2")
    irradiance = result["meter"].irradiance
    return {"irradiance": irradiance, RATIO: irradiance / point}


@of_scene(scene)
def exact(emitter: str, power: float, widths: float) -> dict[str, float]:
    if emitter == "point":
        means = {n: float(emitters.mean_point_irradiance(power, r / 2, r)) for n, r in DISTANCES.items()}
        return {f"irradiance at {name}": mean for name, mean in means.items()} | {"E(1 mm) / E(1 km)": 1e12}
    distance, radius = widths * WIDTH, WIDTH / 2
    if emitter == "sphere":
        mean = float(emitters.mean_point_irradiance(power, METER, distance))
        return {"irradiance": mean, RATIO: mean * 4 * math.pi * distance**2 / power}
    radiance = power / (math.pi * math.pi * radius**2)
    mean = float(emitters.mean_disk_irradiance(radiance, radius, METER, distance))
    inverse_square = radiance * math.pi * radius**2 / distance**2
    return {"irradiance": mean, RATIO: mean / inverse_square}


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in outcomes:
        kind, widths, last = outcome.given["emitter"], outcome.given["widths"], outcome.rows[-1].estimate
        if kind == "point":
            said.append(f"Over six decades of distance a point's irradiance falls {last}-fold")
        else:
            said.append(f"a {kind} at a distance of {widths:g} diameters gives {last} of its inverse square")
    return sentence(*said)


@curves_figure(
    xlabel="distance r  [m]",
    ylabel="mean irradiance E",
    title="A point source: inverse square over six decades",
    log_x=True,
    log_y=True,
)
def draw_points(outcomes: list[Outcome]) -> dict[str, object]:
    result, power = outcomes[0].result, outcomes[0].given["power"]
    far, irradiances = list(DISTANCES.values()), [result[name].irradiance for name in DISTANCES]
    return {
        "series": (far, irradiances, lambda r: emitters.mean_point_irradiance(power, r / 2, r)),
        "guides": {"1/r": lambda r: emitters.mean_point_irradiance(power, 0.5, 1.0) / r},
    }


def draw_rule(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The disk and the sphere at their distances, and E over the inverse square, with the 1 % at five diameters."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import BLUE, GREEN, figure, tick_log
    from transport.viz.wording import number_text

    kinds = grouped(outcomes, "emitter")
    laws = {"disk": lambda x: 1 / (1 + 1 / (4 * x**2)), "sphere": lambda x: 1 + 0 * x}
    series = {
        f"Lambert {kind}": Series(
            [o.given["widths"] for o in found], [o[RATIO].estimate for o in found], laws[kind]
        )
        for kind, found in kinds.items()
    }
    with figure(
        (15, 9.6), "Five diameters away a disk is a point to 1 %, a sphere is one anywhere", note, path
    ) as page:
        axes = page.subplots()
        plot_curves(
            series, ax=axes, log_x=True, span=(0.5001, 12.0), xlabel="distance / diameter", ylabel="E / that of a point",
            guides={"wrong: d from the sphere's surface": lambda x: (x / (x - 0.5)) ** 2}, legend="lower right",
        )  # fmt: skip
        axes.axhspan(0.99, 1.01, color=GREEN, alpha=0.2, lw=0)
        axes.text(0.52, 1.02, "within 1 %", color=GREEN, va="bottom")
        axes.axvline(5, color=GREEN, lw=2.5, ls=":")
        axes.text(5.15, 0.8, "five\ndiameters", color=GREEN, va="center")
        for outcome in where(emitter="disk", widths=5.0)(outcomes):
            words = f"disk: {number_text(outcome[RATIO].estimate)}"
            axes.annotate(
                words,
                (5, 0.985),
                (2.1, 0.87),
                color=BLUE,
                arrowprops={"arrowstyle": "-", "color": BLUE, "lw": 2},
            )
        axes.set(xlim=(0.5, 12.0), ylim=(0.45, 1.45))
        tick_log(axes.xaxis)


draw = figures(
    points=(draw_points, where(emitter="point")), rule=(draw_rule, where(emitter=("disk", "sphere")))
)


if __name__ == "__main__":
    main(__file__)
