"""The integrating sphere: a diffuse wall that lights all of itself alike, less what ports take away.

Derivation.  The chord between two places of a sphere makes the same angle with both normals, so that cosθ
cosθ'/πr² = 1/A: whatever leaves the wall diffusely falls evenly on all of the inside, ports included,
wherever they are.  Of it the share a = Σ aᵢ fᵢ is reflected again, aᵢ being the albedos on the shares fᵢ of
the area A, and the series of reflections is geometric (Ulbricht 1900; Jacquez, Kuppenheim 1955; Goebel 1967).
With one wall of albedo ρ and an open port of share f

    M = ρ / (1 − ρ (1 − f))                                   the sphere's multiplier.

"lamp": a point source at the centre lights all places alike, also the port: E = Φ/(A (1 − a)) everywhere, and
the wall's radiosity is M Φ/A, its radiance M Φ/πA, the same at all places and in all directions.
"beam": Φ first strikes one place of the wall, at the equator: reflections carry M Φ in all and bring M Φ/A to
any other place, the port receives f M Φ, and a particle strikes the wall 1/(1 − ρ (1 − f)) times.  The place
that the beam strikes shines the more: M Φ/πA is the wall's radiance only as the mean that the port sees.

Scene.  The wall is a zone of a sphere that leaves the top open; with a `sample`, a cap of another albedo
closes the bottom, on the same sheet.  The port, and rings of the inside, are detectors.  Hits follow the
geometric law, so that M is known to 1/√N of N particles, whatever the sphere, at the price of M/ρ hits each:
1e-4 takes 1e8.  Others are there by `--set`, such as albedo=0.99 with port=0.01 (50 hits) and albedo=0.999
with port=1e-4 (909).
"""

from __future__ import annotations

import math

import numpy as np

import transport as tp
from transport.sims import (
    constant,
    curves_figure,
    figures,
    furthest,
    grouped,
    holding,
    main,
    of_scene,
    one_of,
    provenance,
    require,
    sentence,
    where,
)
from transport.theory import enclosures as theory
from transport.verification.experiment import Outcome, Row

law = (
    "M = ρ/(1 − ρ(1 − f)), E = Φ/A(1 − Σ aᵢfᵢ) everywhere"
    " (Ulbricht 1900; Jacquez, Kuppenheim 1955; Goebel 1967)"
)
question = "How bright does a white sphere make the light sent into it, and what does a port take away?"
particles = 1_000_000

POWER = 1.0  # W
BINS = 18  # of the polar angle from the port
LIGHTS = ("lamp", "beam")
SPOT = 0.05  # radius of the beam, over the sphere's
HITS = "wall hits a particle"
RADIOSITY, REFLECTED = "M, radiosity of the wall × A/Φ", "M, all that the wall reflects / Φ"
STEEP, OBLIQUE = "M, radiance of the wall to 60° × πA/Φ", "M, radiance of the wall beyond 60° × πA/Φ"
RING = "irradiance 60° to 90° from the port × A/Φ"
PORT, SAMPLE = "irradiance of the port × A/Φ", "irradiance of the sample × A/Φ"
OUT = "share that leaves by the port"


def cases() -> list[dict[str, object]]:
    spheres = [("lamp", 0.5, 0.05), ("beam", 0.7, 0.02), ("lamp", 0.9, 0.0), ("lamp", 0.98, 0.05)]
    empty = [{"light": kind, "albedo": rho, "port": f, "detail": rho < 0.8} for kind, rho, f in spheres]
    return [*empty, {"light": "lamp", "albedo": 0.8, "port": 0.02, "sample": 0.1}]


def scene(
    light: str = "lamp",
    albedo: float = 0.95,
    port: float = 0.05,
    sample: float = 0.0,
    sample_albedo: float = 0.2,
    radius: float = 0.1,
    detail: bool = True,
) -> tp.Scene:
    """A sphere of `radius` [m] with the share `port` of its area open at the top.

    light: a "lamp" at the centre, or a "beam" onto the equator;  albedo: of the wall;  sample, sample_albedo:
    share of the area, at the bottom, and albedo of something else there;  detail: also by place and
    direction, at several times the cost.
    """
    one_of("integrating_sphere", light=(light, LIGHTS))
    for name, share in (("port", port), ("sample", sample)):
        require("integrating_sphere", **{name: (share, 0 <= share <= 0.4, "a share from 0 to 0.4")})
    bottom, top = 2 * sample - 1, 1 - 2 * port
    surfaces = [_surface("wall", radius, bottom, top, albedo)]
    if sample > 0:
        surfaces.append(_surface("sample", radius, -1.0, bottom, sample_albedo))
    least = 1 if light == "beam" else 0  # of the beam only what was reflected is the same everywhere
    reflected = {"side": "back", "events": (least, math.inf)}
    detectors = [tp.Detector(surface.name, side="back") for surface in surfaces]
    if port > 0:
        detectors.append(tp.Detector(tp.Sphere(radius=radius, mu_min=top), "port", **reflected))
    if detail:
        along = tp.Positions(u=np.linspace(0, math.pi, BINS + 1))
        halves = tp.Directions(mu=(0, 0.5, 1))
        detectors += [
            tp.Detector(tp.Sphere(radius=radius), "rings", positions=along, **reflected),
            tp.Detector("wall", "leaving", side="back", directions=halves),
        ]
    return tp.Scene(_source(light, radius), surfaces, detectors)


def _surface(name: str, radius: float, mu_min: float, mu_max: float, albedo: float) -> tp.Surface:
    return tp.Surface(tp.Sphere(radius=radius, mu_min=mu_min, mu_max=mu_max), tp.Diffuse(albedo), name=name)


def _source(light: str, radius: float) -> tp.Source:
    if light == "lamp":
        return tp.Source(tp.Point(), tp.Isotropic(power=POWER))
    spot = tp.Disk(normal=(1, 0, 0), radius=SPOT * radius)
    return tp.Source(spot, tp.Beam((1, 0, 0), power=POWER))


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    wall, power, is_beam = result["wall"], result.ledger["emitted"], light_of(result) == "beam"
    rows = {HITS: wall.flux_in / power}
    rows |= {REFLECTED: wall.flux_out / power} if is_beam else {RADIOSITY: wall.exitance / _even(result)}
    if "port" in result:
        port = result["port"]
        rows |= {PORT: port.irradiance / _even(result), OUT: port.flux_in / power}
    if "sample" in result:
        rows[SAMPLE] = result["sample"].irradiance / _even(result)
    if "rings" in result:
        rows[RING] = rings(result)[BINS // 3 : BINS // 2].mean()
        if not is_beam:
            radiance = result["leaving"].radiance_out * constant(result, math.pi, "sr") / _even(result)
            rows |= {STEEP: radiance[1], OBLIQUE: radiance[0]}
    return rows


def light_of(result: tp.Result) -> str:
    return "lamp" if isinstance(result.scene.sources[0].shape, tp.Point) else "beam"


def rings(result: tp.Result) -> tp.EstimateArray:
    """Irradiance × A/Φ by the angle from the port, (BINS,) [1]; of a beam by reflected light."""
    return result["rings"].irradiance / _even(result)


def _even(result: tp.Result) -> tp.Estimate:
    """Φ/A, A the area of the whole sphere."""
    area = 4 * math.pi * result.scene.surface("wall").shape.radius ** 2
    return result.ledger["emitted"] / constant(result, area, "m^2")


@of_scene(scene)
def exact(
    light: str, albedo: float, port: float, sample: float, sample_albedo: float, detail: bool
) -> dict[str, float]:
    share = 1 - port - sample
    mean = theory.mean_albedo((albedo, sample_albedo), (share, sample))
    if light == "beam":
        even = float(theory.beam_irradiance(1.0, albedo, mean, 1.0))
        hits = theory.beam_hits(albedo, share, mean)
        rows = {HITS: hits, REFLECTED: albedo * hits}
    else:
        even, hits = float(theory.lamp_irradiance(1.0, mean, 1.0)), float(theory.lamp_hits(share, mean))
        rows = {HITS: hits, RADIOSITY: albedo * even}
        rows |= dict.fromkeys((STEEP, OBLIQUE), albedo * even) if detail else {}
    rows |= {PORT: even, OUT: port * even} if port > 0 else {}
    rows |= {SAMPLE: even} if sample > 0 else {}
    return rows | ({RING: even} if detail else {})


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for o in outcomes:
        also = " and a sample" if o.given["sample"] else ""
        row, words = multiplier_of(o), f"ρ = {o.given['albedo']:g}, f = {o.given['port']:g}{also}"
        said.append(f"{row.estimate} for {words} (exact {row.exact:.5g})")
    return sentence(f"The sphere multiplies by {'; '.join(said)}", furthest(outcomes))


def multiplier_of(outcome: Outcome) -> Row:
    """M as the sphere's light tells it."""
    return outcome[RADIOSITY if outcome.given["light"] == "lamp" else REFLECTED]


@curves_figure(
    xlabel="angle from the middle of the port  [°]",
    ylabel="irradiance × A/Φ",
    title="Inside an integrating sphere the irradiance is the same everywhere",
)
def draw_rings(outcomes: list[Outcome]) -> dict[str, object]:
    """The same at all angles: what falls on rings of the inside, ports and samples included."""
    series, edges = {}, np.linspace(0, 180, BINS + 1)
    for outcome in outcomes:
        level, of = outcome[RING].exact, outcome.given
        words = f"{of['light']}: ρ = {of['albedo']:g}, f = {of['port']:g}" + ", sample" * bool(of["sample"])
        series[words] = edges, rings(outcome.result), lambda angle, level=level: np.full_like(angle, level)
    return {"series": series, "note": f"{provenance(outcomes)}; of a beam the light that was reflected"}


@curves_figure(
    xlabel="what the wall takes of each hit, 1 − ρ",
    ylabel="sphere multiplier M",
    title="The whiter the wall, the more a port costs",
    log_x=True,
    log_y=True,
)
def draw_multipliers(outcomes: list[Outcome]) -> dict[str, object]:
    """M by what a hit on the wall costs, a curve a port."""
    series, fine = {}, np.geomspace(1e-3, 0.8, 301)
    for port, found in sorted(grouped(outcomes, "port").items()):
        taken, rows = [1 - o.given["albedo"] for o in found], [multiplier_of(o) for o in found]
        curve = fine, theory.multiplier(1 - fine, port)
        multipliers, expected = [row.estimate for row in rows], [row.exact for row in rows]
        series[f"port f = {port:g}"] = taken, multipliers, curve, expected
    return {"series": series}


def _empty(outcomes: list[Outcome]) -> list[Outcome]:
    """Spheres without a sample, if there are several or nothing else is drawn."""
    empty = where(sample=0)(outcomes)
    return empty if len(empty) > 1 or not holding("rings")(outcomes) else []


draw = figures(rings=(draw_rings, holding("rings")), multiplier=(draw_multipliers, _empty))


if __name__ == "__main__":
    main(__file__)
