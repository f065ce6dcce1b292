"""Two panes: the light left after many reflections shows errors of a reflectance of a few parts in 10 000.

Derivation.  Between two parallel panes of glass light keeps its angle of incidence θ.  After k reflections
the share R(θ)^k of it is left, with c = cosθ, q² = n² - sin²θ and

    R = (R_s + R_p)/2,   R_s = ((c - q)/(c + q))²,   R_p = ((n² c - q)/(n² c + q))²

(Fresnel 1823; Born and Wolf 1999, 1.5.2).  A relative error δ of R is an error k δ of the light left.
Sixty reflections near grazing incidence leave a third of the light, and show an error that a single
reflection would hide in the noise of a million particles.  The library treats light as unpolarised at each
reflection; light that kept its polarisation would leave (R_s^k + R_p^k)/2.

Scene.  A pencil beam starts in the middle of the gap, 1 m wide, between two planes with glass behind them.
Refracted light flies on in the glass and never comes back.  Transparent detectors stand across the gap,
each after so many reflections.
"""

from __future__ import annotations

import math

import transport as tp
from transport.sims import figures, furthest, main, of_scene, one_of, rows_figure
from transport.theory import fresnel
from transport.verification.experiment import Outcome

law = "P = R(θ)^k after k reflections, R = (R_s + R_p)/2 (Fresnel 1823; Born and Wolf 1999, 1.5.2)"
question = "How much of light is left after many reflections between two panes of glass?"
particles = 2_000_000

GLASS, GAP, POWER = 1.5, 1.0, 1.0  # m, W
ANGLES = {"steep": 75 * tp.deg, "grazing": 89.8 * tp.deg}
AFTER = {"steep": (1, 2, 3), "grazing": (1, 20, 60)}  # reflections


def cases() -> list[dict[str, str]]:
    return [{"incidence": incidence} for incidence in ANGLES]


def scene(incidence: str = "grazing", index: float = GLASS) -> tp.Scene:
    """A beam between two panes.  incidence: "steep" or "grazing";  index: of the panes, the gap has 1."""
    one_of("two_panes", incidence=(incidence, ANGLES))
    angle = ANGLES[incidence]
    panes = [
        tp.Surface(tp.Plane(center=(0, 0, -z), normal=(0, 0, z)), tp.Dielectric(index), name)
        for name, z in (("lower", GAP / 2), ("upper", -GAP / 2))
    ]
    across = {"normal": (-1, 0, 0), "up": (0, 0, 1), "width": GAP, "height": GAP}
    places = {k: (k * GAP * math.tan(angle), 0, 0) for k in AFTER[incidence]}
    meters = [tp.Detector(tp.Rectangle(center=at, **across), _meter(k)) for k, at in places.items()]
    beam = tp.Beam((math.sin(angle), 0, math.cos(angle)), power=POWER)
    return tp.Scene(tp.Source(tp.Point(), beam), panes, meters)


def _meter(count: int) -> str:
    return f"after {count}"


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    counts = [int(meter.name.split()[-1]) for meter in result.scene.detectors]
    return {_left(k): result[_meter(k)].flux_in for k in counts}


@of_scene(scene)
def exact(incidence: str, index: float) -> dict[str, float]:
    share = float(fresnel.reflectance(math.cos(ANGLES[incidence]), index))
    return {_left(k): POWER * share**k for k in AFTER[incidence]}


def _left(count: int) -> str:
    return f"left after {count} reflection{'s' if count > 1 else ''}"


def verdict(outcomes: list[Outcome]) -> str:
    last = (outcome.rows[-1] for outcome in outcomes)
    said = ", ".join(f"{row.estimate} {row.name}" for row in last)
    return f"Of 1 W {said}: {furthest(outcomes)}."


draw = figures(rows=rows_figure("What is left of light between two panes of glass"))


if __name__ == "__main__":
    main(__file__)
