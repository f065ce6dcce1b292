"""A slab of fog: what of the light comes back, passes and stays, and by which angles.

Derivation.  In a plane layer of optical depth tau whose particles scatter the share a of what they meet, the
albedo, by a phase function p, the radiance at the depth t obeys, mu counted downwards,

    mu dL/dt = -L + a int p L dω    (Chandrasekhar 1960, ch. 1).

What meets nothing passes straight, exp(-tau/mu0) of a beam at the cosine mu0 and 2 E3(tau) of Lambertian
light (Beer 1852); the rest follows from doubling: a layer upon itself, from one so thin that light is
scattered once (van de Hulst 1963; Hansen and Travis 1974).  By the scattering of Henyey and Greenstein
(1941), g = 0.75, at tau = 2 and a = 0.9, 0.0974 of a normal beam returns and 0.6610 passes, 0.1353 of it
straight (van de Hulst 1980; the slab by which MCML was tested, Wang, Jacques, Zheng 1995).  At grazing incidence even a thin layer returns much of the light.
Where nothing is absorbed R + T = 1, and Lambertian light crosses a length of twice the thickness in the mean,
whatever it meets on its way (Cauchy's mean chord, 4 V/S; Blanco and Fournier 2003): 2 tau collisions.  Thick
layers transmit (4/3)/((1 - g) tau + 2 q), q near 0.71 (transport/theory/half_space.py).

Scene.  A Slab between two planes that do nothing, filled with a medium.  A pencil beam falls on it; a flux
through a plane without end does not depend on where on it light leaves, so it is that of a beam as wide as
the plane, and intensity over mu is radiance.  Meters are the planes themselves.  What is unscattered is
counted by a meter for `events=0`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

import transport as tp
from transport.sims import (
    constant,
    curves_figure,
    figures,
    furthest,
    grouped,
    main,
    of_scene,
    one_of,
    require,
    sentence,
    several,
)
from transport.theory import ordinates
from transport.verification.experiment import Outcome

law = (
    "T straight = exp(-τ/μ0), R, T and radiance of μ dL/dτ = -L + a∫pL dω by doubling, R + T + A = 1"
    " (Chandrasekhar 1960, ch. 1; van de Hulst 1980; Hansen, Travis 1974)"
)
question = "How much light does a layer of fog send back, let through and keep, and where does it go?"
particles = 1_000_000

PHASES = ("henyey-greenstein", "rayleigh")
INCIDENCES = ("beam", "lambertian")
BINS, GROUP = 30, 6  # of cosine a side, and how many of them a row of the table holds
EDGES = np.linspace(0, 1, BINS + 1)
STEEPEST = 0.95  # |g|; a sharper peak takes theory minutes
LEAST = 1e-4  # share that passes straight; less is no row
BACK, ON, STAYS = "reflected R", "transmitted T, with the unscattered", "absorbed"
STRAIGHT, SCATTERED = "transmitted unscattered", "transmitted scattered"
PATH = "mean path / thickness"
KIND = ("albedo", "g", "mu0", "incidence", "phase")  # of a slab, whatever its depth
SHOWN = 4  # slabs in the figure of radiance
DEEPEST, OCTAVES, STEPS = 16.0, 8, 2  # of the curves: depth, how often it is halved, exact points an octave


def cases() -> list[dict[str, object]]:
    """Van de Hulst's slab and others of its kind; his table 12; grazing incidence; no absorption; skylight.

    Those that take longer are a matter of parameters: tau=100 with albedo=1 has 200 collisions a particle.
    """
    isotropic = {"g": 0.0}
    return [
        *({"tau": tau} for tau in (2.0, 0.1, 0.5, 8.0)),
        isotropic | {"albedo": 0.8},
        isotropic | {"tau": 1.0, "mu0": 0.1},
        isotropic | {"tau": 1.0, "mu0": 0.01},
        {"tau": 5.0, "albedo": 1.0},
        {"tau": 0.5, "albedo": 1.0, "phase": "rayleigh", "incidence": "lambertian"},
    ]


def scene(
    tau: float = 2.0,
    albedo: float = 0.9,
    g: float = 0.75,
    mu0: float = 1.0,
    incidence: str = "beam",
    phase: str = "henyey-greenstein",
    thickness: float = 1.0,
) -> tp.Scene:
    """A slab of optical depth `tau`, `thickness` thick [m], below z = 0; 1 W falls on it.

    g: mean cosine of Henyey-Greenstein scattering, 0 if isotropic;  mu0: cosine of the beam's incidence;
    incidence: of a "beam" or "lambertian";  phase: "henyey-greenstein", or "rayleigh", which has no g.
    """
    one_of("slab", incidence=(incidence, INCIDENCES), phase=(phase, PHASES))
    is_known = phase == "rayleigh" or abs(g) <= STEEPEST
    require(
        "slab",
        mu0=(mu0, 0 < mu0 <= 1, "above 0 and at most 1, the cosine of incidence"),
        tau=(tau, 0 < tau < math.inf, "above 0 and finite"),
        albedo=(albedo, 0 <= albedo <= 1, "from 0 to 1"),
        g=(g, is_known, f"from -{STEEPEST} to {STEEPEST}, for which R and T are known"),
        thickness=(thickness, thickness > 0, "above 0"),
    )
    extinction = tau / thickness
    henyey = tp.HenyeyGreenstein(g) if g else tp.Isotropic()
    kind = tp.Rayleigh() if phase == "rayleigh" else henyey
    fog = tp.Medium(absorption=(1 - albedo) * extinction, scattering=albedo * extinction, phase=kind)
    body = tp.Slab(center=(0, 0, -thickness / 2), thickness=thickness)
    paths = fog if _has_known_path(albedo, incidence) else None
    bottom, bins = tp.Plane(center=(0, 0, -thickness), normal=(0, 0, -1)), tp.Directions(mu=BINS)
    detectors = [
        tp.Detector(tp.Plane(), "top", directions=bins, path_lengths=paths),
        tp.Detector(bottom, "bottom", directions=bins, path_lengths=paths),
        tp.Detector(bottom, "straight", directions=bins, events=0),
    ]
    source = falling_light(incidence, mu0, thickness)
    return tp.Scene(source, tp.Surface(body, tp.Transparent(), "slab", inside=fog), detectors)


def _has_known_path(albedo: float, incidence: str) -> bool:
    """Whether the mean path of what leaves is the mean chord: of Lambertian light that nothing absorbs."""
    return albedo == 1 and incidence == "lambertian"


def falling_light(incidence: str, mu0: float, height: float) -> tp.Source:
    """1 W that falls on the plane z = 0: a beam at the cosine mu0, or light of a Lambertian disk of this height [m]."""
    if incidence == "lambertian":
        lamp = tp.Disk(center=(0, 0, height), normal=(0, 0, -1), radius=height)
        return tp.Source(lamp, tp.Lambertian(power=1.0))
    down = (math.sqrt((1 - mu0) * (1 + mu0)), 0, -mu0)
    return tp.Source(tp.Point(position=(0, 0, height)), tp.Beam(power=1.0, direction=down))


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    emitted, straight = result.ledger["emitted"], result["straight"].flux_out
    back, on = result["top"].flux_out, result["bottom"].flux_out
    rows = {BACK: back / emitted, ON: on / emitted}
    body, emission = result.scene.surfaces[0], result.scene.sources[0].emission
    if body.inside.absorption > 0:
        rows[STAYS] = result.ledger["absorbed"] / emitted
    mu0 = -emission.direction[2] if isinstance(emission, tp.Beam) else 1.0
    if _passes_straight(body.inside.extinction * body.shape.thickness, mu0):
        rows |= {STRAIGHT: straight / emitted, SCATTERED: (on - straight) / emitted}
    if result["top"].detector.path_lengths:
        rows[PATH] = mean_path(result) / constant(result, body.shape.thickness, "m")
    for way, shares in (("back", shares_back(result)), ("scattered on", shares_on(result))):
        rows |= {_bin(way, k): shares[k : k + GROUP].sum() for k in range(0, BINS, GROUP)}
    return rows


def mean_path(result: tp.Result) -> tp.Estimate:
    """Mean path length in the fog of all that leaves it [m]."""
    leaving = [result["top"], result["bottom"]]
    fluxes = [each.intensity_out for each in leaving]
    paths = [(each.mean_path_out[0] * flux).sum() for each, flux in zip(leaving, fluxes, strict=True)]
    return (paths[0] + paths[1]) / (fluxes[0].sum() + fluxes[1].sum())


def _passes_straight(tau: float, mu0: float) -> bool:
    """Whether enough passes unscattered to be counted."""
    return math.exp(-tau / mu0) > LEAST


def shares_back(result: tp.Result) -> tp.EstimateArray:
    """Share of the light that returns, in each bin of cosine [1]."""
    return result["top"].intensity_out * constant(result, 2 * math.pi / BINS, "sr") / result.ledger["emitted"]


def shares_on(result: tp.Result) -> tp.EstimateArray:
    """Share that passes after scattering, in each bin of cosine [1]."""
    scattered = result["bottom"].intensity_out - result["straight"].intensity_out
    return scattered * constant(result, 2 * math.pi / BINS, "sr") / result.ledger["emitted"]


def _bin(way: str, first: int) -> str:
    return f"{way}, μ {EDGES[first]:.1f} to {EDGES[first + GROUP]:.1f}"


@of_scene(scene)
def exact(tau: float, albedo: float, g: float, mu0: float, incidence: str, phase: str) -> dict[str, float]:
    light = light_of(tau=tau, albedo=albedo, g=g, mu0=mu0, incidence=incidence, phase=phase)
    rows = {BACK: light.reflected, ON: light.transmitted}
    if albedo < 1:
        rows[STAYS] = light.absorbed
    if _has_known_path(albedo, incidence):
        rows[PATH] = 2.0  # 4 V/S
    if _passes_straight(tau, mu0 if incidence == "beam" else 1.0):
        rows |= {STRAIGHT: light.unscattered_on, SCATTERED: light.transmitted_diffuse}
    edges = EDGES[::GROUP]
    for way, shares in (("back", light.reflected_in(edges)), ("scattered on", light.transmitted_in(edges))):
        rows |= {_bin(way, k): float(shares[k // GROUP]) for k in range(0, BINS, GROUP)}
    return rows


@of_scene(scene)
def light_of(tau: float, albedo: float, g: float, mu0: float, incidence: str, phase: str) -> ordinates.Light:
    """What leaves the slab of these parameters, by discrete ordinates."""
    return ordinates.slab(tau, *_optics(albedo, g, mu0, incidence, phase))


def _optics(albedo: float, g: float, mu0: float, incidence: str, phase: str) -> tuple:
    """Albedo, moments of the phase function, and the cosine of incidence."""
    moments = ordinates.RAYLEIGH if phase == "rayleigh" else ordinates.henyey_greenstein(g)
    return albedo, moments, mu0 if incidence == "beam" else None


def verdict(outcomes: list[Outcome]) -> str:
    first = outcomes[0]
    said = f"A slab sends {first[BACK].estimate} back and {first[ON].estimate} on ({first.title})"
    return sentence(said, furthest(outcomes))


def _kinds(outcomes: list[Outcome]) -> dict[object, list[Outcome]]:
    """The slabs that differ in depth alone."""
    return grouped(outcomes, *KIND)


def _alike(outcomes: list[Outcome]) -> list[Outcome]:
    """The most slabs of one kind."""
    return max(_kinds(outcomes).values(), key=len)


@curves_figure(xlabel="optical depth τ", ylabel="share of the light", log_x=True)
def draw_shares(outcomes: list[Outcome]) -> dict[str, object]:
    """What returns, passes and stays against the depth."""
    depths, lights = curve_points(*_optics(*(outcomes[0].given[name] for name in KIND)))
    series, words = {}, {BACK: "reflected", ON: "transmitted", STRAIGHT: "unscattered", STAYS: "absorbed"}
    for name, label in words.items():
        if shown := [o for o in outcomes if name in o]:
            known = "unscattered_on" if name == STRAIGHT else label
            curve = smooth(depths, [getattr(light, known) for light in lights])
            found, expected = [o[name].estimate for o in shown], [o[name].exact for o in shown]
            series[label] = [o.given["tau"] for o in shown], found, curve, expected
    return {"series": series, "title": f"A slab of fog: {_described(outcomes[0])}"}


def smooth(depths: np.ndarray, shares: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """A curve through exact points, even in the logarithm of the depth; within 6e-4 of the exact one."""
    from scipy.interpolate import CubicSpline

    fine = np.geomspace(depths[0], depths[-1], 300)
    return fine, CubicSpline(np.log(depths), shares)(np.log(fine))


def curve_points(*optics: object) -> tuple[np.ndarray, list[ordinates.Light]]:
    """Depths, rising, and the slabs of these depths."""
    found = {}
    for step in range(STEPS):
        deepest = DEEPEST / 2 ** (step / STEPS)
        lights = ordinates.halved_slabs(deepest, OCTAVES, *optics)
        found |= {deepest / 2 ** (OCTAVES - k): light for k, light in enumerate(lights)}
    return np.array(sorted(found)), [found[depth] for depth in sorted(found)]


@curves_figure(
    xlabel="cosine μ:  passes, scattered < 0 < comes back",
    ylabel="π L / irradiance",
    title="Radiance of a slab of fog, by angle",
    legend="right",
    log_y=True,
)
def draw_radiance(outcomes: list[Outcome]) -> dict[str, object]:
    """Radiance by angle of up to four slabs: of what passes, scattered, at negative cosines."""
    series, mu = {}, (EDGES[1:] + EDGES[:-1]) / 2
    projected, fine = np.diff(EDGES**2), np.linspace(1e-3, 1, 400)  # of each bin, over that of a hemisphere
    for outcome in [found[0] for found in _kinds(outcomes).values()][:SHOWN]:
        light = light_of(**outcome.parameters)
        sides = shares_on(outcome.result), shares_back(outcome.result)
        found = [_mirrored(*(getattr(s, name) / projected for s in sides)) for name in ("value", "error")]
        means = [each(EDGES) / projected for each in (light.transmitted_in, light.reflected_in)]
        laws = [math.pi * each(fine) for each in (light.transmitted_radiance, light.reflected_radiance)]
        curve = _mirrored(-fine, fine, [math.nan]), _mirrored(*laws, [math.nan])
        label = f"τ = {outcome.given['tau']:g}, {_described(outcome)}"
        series[label] = _mirrored(-mu, mu), tuple(found), curve, _mirrored(*means)
    return {"series": series}


def _mirrored(on: np.ndarray, back: np.ndarray, between: Sequence[float] = ()) -> np.ndarray:
    """Both sides from straight on to straight back."""
    return np.concatenate([on[::-1], between, back])


def _described(outcome: Outcome) -> str:
    of = outcome.given
    scatters = "Rayleigh" if of["phase"] == "rayleigh" else f"g = {of['g']:g}"
    falls = "Lambertian" if of["incidence"] == "lambertian" else f"μ₀ = {of['mu0']:g}"
    return f"a = {of['albedo']:g}, {scatters}, {falls}"


draw = figures(shares=(draw_shares, several(_alike)), radiance=draw_radiance)


if __name__ == "__main__":
    main(__file__)
