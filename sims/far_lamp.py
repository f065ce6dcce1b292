"""Far lamp: from how far on a lamp is a beam, over a desk.

Derivation.  A lamp so far away that its light is even and parallel is directional (Akenine-Möller, Haines, Hoffman 2008, 7.1).
Over a desk of the half width a, a Lambert sphere of radius R at the height d gives what a point in its middle gives (Lambert 1760),
E = I d/(d² + x²)^(3/2): at the rim (1 + a²/d²)^(-3/2) of that in the middle.  It is even to the share s from

    d = a/√((1 − s)^(-2/3) − 1)    on: 12.2 half widths for 1 %.

In the middle of the desk directions fill a cone of sinα = R/d, so that φ/E = ∫dω/∫cosθ dω = 2/(1 + cosα), where a beam has 1.
It is within s of that from

    d = R/√(1 − (2/(1 + s) − 1)²)  on: 5.04 radii for 1 %.

Both must hold, and both deviations fall with 1/d².

Scene.  The desk is read in strips, and once more in its middle.  What a strip receives is I Ω, where Ω is the solid angle that it
fills from the middle of the sphere; its mean fluence rate is the mean of 2π L (1 − √(1 − R²/r²)), by Gauss-Legendre sums.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import figures, furthest, main, of_scene, require, sentence
from transport.statistics.quadrature import legendre_nodes
from transport.theory import solid_angles
from transport.verification.experiment import Outcome

law = "E(rim)/E = (1 + a²/d²)^(-3/2), φ/E = 2/(1 + cosα): a beam for large d (Lambert 1760; Akenine-Möller, Haines, Hoffman 2008, 7.1)"
question = "How far away must a lamp be so that its light over a desk is even and parallel?"
particles = 1_000_000
run = {"sampling": "sobol"}  # a hundredth of a percent is to be seen
intended = {
    "aim": "the middle is a part of the desk, at which the lamp is aimed",
}

RADIUS = 0.5  # m, of the lamp
DESK, DEEP = 0.5, 0.05  # m, half width of the desk, and depth of the strips
STRIPS = 11  # across the desk; the middles of the first and of the last are its rims
REACH = DESK * STRIPS / (STRIPS - 1)  # m, half width of all strips
EVEN, SPREAD = "E at the rim / in the middle", "φ / E in the middle"


def cases() -> list[dict[str, object]]:
    return [{"height": height} for height in (1.0, 2.0, 4.0, 8.0, 16.0)]


def scene(height: float = 6.1, power: float = 100.0) -> tp.Scene:
    """A sphere of `power` [W] whose middle is at that height [m] over the desk."""
    require("far_lamp", height=(height, height > RADIUS, f"above the lamp's radius of {RADIUS} m"))
    desk = tp.Rectangle(width=2 * REACH, height=DEEP)
    lamp = tp.Source(tp.Sphere(center=(0, 0, height), radius=RADIUS), tp.Lambertian(power=power), aim=desk)
    strips = tp.Positions(x=STRIPS)
    middle = tp.Rectangle(width=2 * REACH / STRIPS, height=DEEP)
    return tp.Scene(
        lamp, detectors=[tp.Detector(desk, "desk", positions=strips), tp.Detector(middle, "middle")]
    )


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    desk, middle = result["desk"].irradiance, result["middle"]
    rim = (desk[0] + desk[STRIPS - 1]) / 2
    return {EVEN: rim / desk[STRIPS // 2], SPREAD: middle.fluence_rate / middle.irradiance}


@of_scene(scene)
def exact(height: float, power: float) -> dict[str, float]:
    desk = strip_irradiances(power, height)
    middle = float(desk[STRIPS // 2])
    return {EVEN: float(desk[0]) / middle, SPREAD: middle_fluence_rate(power, height) / middle}


def strip_irradiances(power: float, height: float) -> np.ndarray:
    """Exact mean irradiance of each strip of the desk [W m^-2]."""
    x, y = np.linspace(-REACH, REACH, STRIPS + 1), DEEP / 2
    strips = [[(a, -y, 0), (b, -y, 0), (b, y, 0), (a, y, 0)] for a, b in zip(x[:-1], x[1:], strict=True)]
    filled = np.array([solid_angles.polygon_solid_angle(strip, (0, 0, height)) for strip in strips])
    return power * filled / (4 * math.pi * np.diff(x) * DEEP)


def middle_fluence_rate(power: float, height: float) -> float:
    """Exact mean fluence rate of the strip in the middle [W m^-2]."""
    nodes, weights = legendre_nodes(32)
    x, y = REACH / STRIPS * nodes[:, None], DEEP / 2 * nodes
    share = RADIUS**2 / (x**2 + y**2 + height**2)
    seen = 2 * math.pi * share / (1 + np.sqrt(1 - share))
    return float(power / (4 * math.pi**2 * RADIUS**2) * (weights @ seen @ weights) / 4)


def even_from(share: float) -> float:
    """Height from which on E at the rim of the desk is within that share of E in the middle [m]."""
    return DESK / math.sqrt((1 - share) ** (-2 / 3) - 1)


def parallel_from(share: float) -> float:
    """Height from which on φ/E is within that share of a beam's [m]."""
    return RADIUS / math.sqrt(1 - (2 / (1 + share) - 1) ** 2)


# ---- answer and picture ----


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in outcomes:
        even, spread = outcome[EVEN].estimate, outcome[SPREAD].estimate
        said.append(
            f"from {outcome.given['height']:g} m the rim has {even} of the middle's E, and φ/E is {spread}"
        )
    said.append(f"it is a beam to 1 % from {max(even_from(0.01), parallel_from(0.01)):.3g} m on")
    return sentence(*said, furthest(outcomes))


def draw_far(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The lamp near and far over the desk; and how far the desk is from that in a beam, by the height."""
    from transport.viz.style import BLUE, INK, MUTED, ORANGE, VERMILLION, figure, tick_log

    with figure((16, 8.4), "A far lamp is a beam: even light, parallel directions", note, path) as page:
        left, right = page.subplots(1, 2, gridspec_kw={"width_ratios": (1, 1.25)})
        for x, height in ((0.0, 1.0), (1.9, 4.0)):
            turn = np.linspace(0, 2 * math.pi, 100)
            left.fill(x + RADIUS * np.cos(turn), height + RADIUS * np.sin(turn), color=ORANGE, lw=0, zorder=3)
            for spot in (-DESK, 0.0, DESK):
                to_lamp, far = math.atan2(-spot, height), math.hypot(spot, height)
                alpha = math.asin(RADIUS / far)
                ends = [x + spot + far * math.sin(to_lamp + side * alpha) for side in (-1, 1)]
                tops = [far * math.cos(to_lamp + side * alpha) for side in (-1, 1)]
                left.fill([x + spot, *ends], [0, *tops], color=BLUE, alpha=0.25, lw=0)
            left.plot([x - DESK, x + DESK], [0, 0], color=INK, lw=7, solid_capstyle="butt")
        left.set(aspect="equal", xlim=(-0.75, 2.7), ylim=(-0.15, 4.7), ylabel="height d  [m]", xticks=[])
        left.grid(False)
        heights = np.array([o.given["height"] for o in outcomes])
        fine = np.geomspace(0.8, 25, 200)
        cosine = np.sqrt(1 - (RADIUS / fine) ** 2)
        for name, colour, label, curve in (
            (
                EVEN,
                BLUE,
                "irradiance: 1 − E at the rim / in the middle",
                1 - (1 + (DESK / fine) ** 2) ** -1.5,
            ),
            (SPREAD, VERMILLION, "directions: φ/E − 1", 2 / (1 + cosine) - 1),
        ):
            off = [abs(o[name].estimate.value - 1) for o in outcomes]
            errors = [o[name].estimate.error for o in outcomes]
            right.plot(fine, curve, color=colour, lw=3)
            right.errorbar(heights, off, errors, fmt="o", color=colour, ms=12, mec="white", label=label)
        right.plot(fine, 0.3 / fine, ":", color=MUTED, lw=3, label="if it fell with 1/d")
        right.axhline(0.01, color=MUTED, ls="--", lw=2.5)
        right.text(0.85, 0.0112, "1 %", color=MUTED, va="bottom")
        for height, colour in ((even_from(0.01), BLUE), (parallel_from(0.01), VERMILLION)):
            right.axvline(height, color=colour, lw=2, ls="--")
            right.text(1.03 * height, 1.2e-4, f"{height:.3g} m", color=colour)
        right.set(
            xscale="log",
            yscale="log",
            xlabel="height of the lamp d  [m]",
            ylabel="how far from a beam",
            xlim=(0.8, 25),
            ylim=(1e-4, 1.5),
        )
        tick_log(right.xaxis)
        right.legend(loc="upper right", fontsize=15)


draw = figures(far=draw_far)


if __name__ == "__main__":
    main(__file__)
