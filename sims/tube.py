"""The diffuse-walled tube: what gets through of the light, or gas, that enters, and what its wall receives.

Derivation.  A uniform flux of the cosine law enters a tube of the length l and the radius R, whose wall sends
back by the cosine law what it receives: light in a white tube, or a gas so thin that its molecules meet the
wall only.  What falls on the wall at the depth x comes from the entrance and from the rest of the wall,

    H(x) = f(x) + a ∫ K(|x − y|) H(y) dy,

f and K being view factors from a point of the wall, and W = F + 2 a ∫ H(x) f(l − x) dx gets through (Clausing
1932; solved to 1e-12 in transport/theory/clausing.py).  F, the view factor of the ends, flies through without
meeting the wall. Where the wall takes nothing, a = 1, three things are known without solving anything: what
does not get through comes back; if both ends shone alike the wall would receive the same everywhere, so that
H(x) + H(l − x) = 1; and hence a particle meets the wall l/R times in the mean.  A long tube lets through
8R/3l, but slowly so: at 10 R that is still 40 % too much.

Scene.  A Lambertian disk at the entrance, the wall, detectors on both ends and, in detail, along the wall.  A
tube of l = 50 R costs 50 wall hits a particle and lets 5 % through, so that 1e8 particles, some minutes, are
needed for 4e-4 of W; short ones reach 1e-4 with 1e8 in seconds.
"""

from __future__ import annotations

import numpy as np

import transport as tp
from transport.sims import (
    constant,
    curves_figure,
    figures,
    furthest,
    holding,
    main,
    of_scene,
    require,
    sentence,
    where,
)
from transport.theory import clausing
from transport.theory.round_view_factors import base_to_base
from transport.verification.experiment import Outcome

law = "W = F + 2a ∫ H f dx, H = f + a ∫ K H dy, wall hits l/R (Clausing 1932)"
question = "How much gets through a tube with a diffuse wall, and how often does it meet the wall on its way?"
particles = 1_000_000

POWER = 1.0  # W
BINS = 20  # along the wall
DETAILED = (1.0, 2.0)  # radii
STRAIGHT = 20.0  # radii, up to which those that meet no wall are counted: of longer tubes they are too few
THROUGH, BACK, DIRECT = "transmission W", "returns by the entrance", "flies straight through"
HITS, LOST = "wall hits a particle", "absorbed by the wall"
HALF, LAST = "falls on the first half of the wall, mean of H", "falls on its last twentieth, mean of H"


def cases() -> list[dict[str, object]]:
    lengths = [{"length": length, "detail": length in DETAILED} for length in (0.1, *DETAILED, 10.0, 50.0)]
    return [*lengths, {"length": 5.0, "albedo": 0.8}]


def scene(length: float = 2.0, radius: float = 1.0, albedo: float = 1.0, detail: bool = True) -> tp.Scene:
    """A tube along +z.  length: over the radius, up to 200;  radius [m];  albedo: of the wall.

    detail: also by place along the wall, at several times the cost.
    """
    is_known = 0 < length <= clausing.MAX_LENGTH
    require("tube", length=(length, is_known, f"above 0 and at most {clausing.MAX_LENGTH:g} radii"))
    height = length * radius
    entrance = tp.Disk(radius=radius)
    exit_ = tp.Disk(center=(0, 0, height), normal=(0, 0, -1), radius=radius)
    wall = tp.Cylinder(center=(0, 0, height / 2), radius=radius, height=height)
    ends = tp.Detector(exit_, "exit"), tp.Detector(entrance, "entrance")
    detectors = [*ends, tp.Detector("wall", side="back")]
    if length <= STRAIGHT:
        detectors.append(tp.Detector(exit_, "direct", events=0))
    if detail:
        along = tp.Positions(u=np.linspace(-height / 2, height / 2, BINS + 1))
        detectors.append(tp.Detector(wall, "profile", side="back", positions=along))
    source = tp.Source(entrance, tp.Lambertian(power=POWER))
    return tp.Scene(source, tp.Surface(wall, tp.Diffuse(albedo), name="wall"), detectors)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    emitted = result.ledger["emitted"]
    rows = {
        THROUGH: result["exit"].flux_in / emitted,
        BACK: result["entrance"].flux_in / emitted,
        HITS: result["wall"].flux_in / emitted,
    }
    if "direct" in result:
        rows[DIRECT] = result["direct"].flux_in / emitted
    if result.scene.surface("wall").material.albedo < 1:
        rows[LOST] = result.ledger["absorbed"] / emitted
    if "profile" in result:
        rows |= {HALF: incident(result)[: BINS // 2].mean(), LAST: incident(result)[-1]}
    return rows


def incident(result: tp.Result) -> tp.EstimateArray:
    """H by depth, (BINS,) [1]: what falls on the wall over what enters, both per area."""
    entering = POWER / result.scene.sources[0].shape.area
    return result["profile"].irradiance / constant(result, entering, "W m^-2")


@of_scene(scene)
def exact(length: float, albedo: float, detail: bool) -> dict[str, float]:
    tube = clausing.solved_tube(float(length), float(albedo))
    rows = {THROUGH: tube.transmission, BACK: tube.reflection, HITS: tube.mean_hits}
    if length <= STRAIGHT:
        rows[DIRECT] = float(base_to_base(1.0, length))
    if albedo < 1:
        rows[LOST] = (1 - albedo) * tube.mean_hits
    if detail:
        means = tube.mean_incident(edges(length))
        rows |= {HALF: float(means[: BINS // 2].mean()), LAST: float(means[-1])}
    return rows


def edges(length: float) -> np.ndarray:
    """Edges of the bins along the wall, from the entrance [radii]."""
    return np.linspace(0, length, BINS + 1)


def verdict(outcomes: list[Outcome]) -> str:
    said = [f"{o[THROUGH].estimate} at {o.given['length']:g} radii{_shade(o)}" for o in outcomes]
    return sentence(f"A tube lets through {', '.join(said)}", furthest(outcomes))


def _shade(outcome: Outcome) -> str:
    albedo = outcome.given["albedo"]
    return "" if albedo == 1 else f", albedo {albedo:g}"


def _by_length(outcomes: list[Outcome]) -> list[Outcome]:
    """Those whose wall takes nothing, if there are several or nothing else is drawn."""
    white = sorted(where(albedo=1)(outcomes), key=lambda o: o.given["length"])
    return white if len(white) > 1 or not holding("profile")(outcomes) else []


@curves_figure(
    xlabel="depth / length of the tube",
    ylabel="falls on the wall / enters, per area",
    title="A diffuse-walled tube: what its wall receives",
)
def draw_walls(outcomes: list[Outcome]) -> dict[str, object]:
    """H by depth over length, a curve a tube."""
    series, shares, fine = {}, np.linspace(0, 1, BINS + 1), np.linspace(0, 1, 301)
    for outcome in outcomes:
        tube = clausing.solved_tube(float(outcome.given["length"]), float(outcome.given["albedo"]))
        curve = fine, [tube.incident_at(share * tube.length) for share in fine]
        means = tube.mean_incident(edges(tube.length))
        series[f"l = {tube.length:g} R{_shade(outcome)}"] = shares, incident(outcome.result), curve, means
    return {"series": series}


@curves_figure(
    guides={"8R/3l": clausing.long_tube, "1/(1 + 3l/8R)": clausing.dushman},
    xlabel="length / radius",
    ylabel="transmission W",
    title="What gets through a diffuse-walled tube",
    log_x=True,
    log_y=True,
)
def draw_lengths(outcomes: list[Outcome]) -> dict[str, object]:
    """W by length, beside the long tube's law and the two resistances added."""
    lengths, albedo = np.array([float(o.given["length"]) for o in outcomes]), outcomes[0].given["albedo"]
    nodes = np.geomspace(0.8 * lengths.min(), min(1.25 * lengths.max(), clausing.MAX_LENGTH), 100)
    curve = nodes, [clausing.transmission(length, albedo) for length in nodes]
    through = [o[THROUGH] for o in outcomes]
    return {"series": (lengths, [row.estimate for row in through], curve, [row.exact for row in through])}


draw = figures(walls=(draw_walls, holding("profile")), lengths=(draw_lengths, _by_length))


if __name__ == "__main__":
    main(__file__)
