"""A point of light in fog without end: fluence rate by distance, net flux, and how far light comes in time.

Derivation.  Around an isotropic point source in an infinite medium that scatters isotropically, with the albedo
c, the fluence rate is known exactly: in mean free paths and per power emitted its Fourier transform is A/(1 - c
A), A(k) = atan(k)/k, so that

    φ(r) = [B exp(-κ r) + ∫ g(s) exp(-s r) ds] / (4π r),   s from 1 on,   c atanh(κ)/κ = 1

(Case, de Hoffmann, Placzek 1953, 21; transport/theory/point_source.py).  Near the source the light that has not
collided rules, exp(-r)/(4π r²); far out one exponential of the diffusion length 1/κ is left; diffusion theory,
of exponent sqrt(3 (1 - c)), tends to it for albedos near 1.  φ is the light that a small ball receives over its
section, and in a medium it is told by two estimators: the length of track in a volume, or the collisions in it
over the extinction. What flows out through a sphere, less what flows in, is what is not absorbed within: the
balance of energy.

With a clock and nothing absorbed the light spreads.  Directions forget, ⟨cos⟩ = exp(-(1-g) t) after a time t in
mean free times, whatever the phase function besides its mean cosine g, so that

    ⟨r²⟩ = 2 (ν t - 1 + exp(-ν t)) / ν²,   ν = 1 - g

(Taylor 1921; Fürth 1920): t² at first, as in straight flight, then 2 t/(1 - g), as in diffusion.  Along one
coordinate the burst is spread like that of a plane source, known in closed form but for one integral (Ganapol
2001: AZURV1).

Scene.  "steady": a Point in a scene full of fog, shells of a ball as volume detectors, and spheres.  "clock": a
burst of particles of one speed at the same place, in all directions alike, so that ⟨r²⟩ = 3⟨x²⟩.  Places are
counted in bins of a thousandth of the way that particles can have come, and ⟨x²⟩ is taken from the bins' middles
less h²/12 (Sheppard 1898), which is good to 5e-7.  Longer times, other albedos, other g are parameters.
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
    main,
    of_scene,
    one_of,
    provenance,
    require,
    sentence,
    where,
)
from transport.theory import point_source, random_flights
from transport.verification.experiment import Outcome

law = (
    "φ = [B exp(-κr) + ∫ g exp(-sr) ds]/(4πr); net flux = what is not absorbed within; ⟨r²⟩ = 2(νt - 1 + exp(-νt))/ν²"
    " (Case, de Hoffmann, Placzek 1953; Taylor 1921; Ganapol 2001)"
)
question = "How bright is it around a point of light in fog, and how far has its light come after a time?"
particles = 1_000_000
intended = {
    "bins": "cells at the edge of the cloud hold few particles; the rows are of whole shells",
}

# In mean free paths and mean free times.
SHELLS = np.array([0, 0.1, 0.2, 0.4, 0.8, 1.4, 2.2, 3.5, 5, 6.3, 8])
SPHERES = (1.0, 4.0)
ESTIMATORS = ("track", "collision")
TIMES = (0.3, 1.0, 3.0, 6.0)
PULSES = (1.0, 3.0, 6.0)  # of which the shape along x is told
QUARTERS = np.array([0, 0.25, 0.5, 0.75, 1])  # of the way that light can have come
BINS = 2000
SPEED = 1.0  # m/s


def cases() -> list[dict[str, object]]:
    steady = [{"subject": "steady", "albedo": albedo} for albedo in (0.5, 0.8)]
    return [*steady, *({"subject": "clock", "g": g} for g in (0.0, 0.9))]


def scene(
    subject: str = "steady", albedo: float = 0.8, mean_free_path: float = 1.0, g: float = 0.0
) -> tp.Scene:
    """A point source in fog.  subject: "steady", or "clock" (its burst, in fog that absorbs nothing).

    albedo: of the steady fog, above 0 and below 1;  mean_free_path [m];  g: mean cosine of scattering, for
    "clock".
    """
    one_of("point_in_fog", subject=(subject, ("steady", "clock")))
    must = "above 0 and below 1, so that light is scattered and ends"
    require("point_in_fog", albedo=(albedo, 0 < albedo < 1, must))
    return _steady(albedo, mean_free_path) if subject == "steady" else _clock(mean_free_path, g)


def _steady(albedo: float, length: float) -> tp.Scene:
    ball = tp.Sphere(radius=SHELLS[-1] * length)
    shells = [tp.VolumeDetector(ball, name, cells=SHELLS * length, estimator=name) for name in ESTIMATORS]
    spheres = [tp.Detector(tp.Sphere(radius=r * length), _sphere(r)) for r in SPHERES]
    return tp.Scene(
        tp.Source(tp.Point(), tp.Isotropic(power=1.0)),
        detectors=[*shells, *spheres],
        medium=tp.Medium(absorption=(1 - albedo) / length, scattering=albedo / length),
    )


def _sphere(radius: float) -> str:
    return f"sphere {SPHERES.index(radius) + 1}"


def _clock(length: float, g: float) -> tp.Scene:
    """Counters of positions at each time, their bins up to the furthest that a particle can be."""
    counters = [tp.PhaseSpace(name=_counter(t), time=t * length / SPEED, x=_bins(t) * length) for t in TIMES]
    phase = tp.HenyeyGreenstein(g) if g else tp.Isotropic()
    return tp.Scene(
        tp.Source(tp.Point(), tp.Gas(number=1.0, speed=SPEED)),
        detectors=counters,
        medium=tp.Medium(scattering=1 / length, phase=phase),
        duration=TIMES[-1] * length / SPEED,
    )


def _counter(time: float) -> str:
    return f"time {TIMES.index(time) + 1}"


def _bins(time: float) -> np.ndarray:
    return np.linspace(-time, time, BINS + 1)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    return _read_steady(result) if ESTIMATORS[0] in result else _read_clock(result)


def _read_steady(result: tp.Result) -> dict[str, tp.Estimate]:
    rows = {}
    for name in ESTIMATORS:
        rows |= {f"{_shell(i)}, by {name}": each for i, each in enumerate(result[name].fluence_rate)}
    for r in SPHERES:
        rows[_through(r)] = result[_sphere(r)].flux_out - result[_sphere(r)].flux_in
    return rows | {_within(): result["track"].absorbed_power.sum()}


def _read_clock(result: tp.Result) -> dict[str, tp.Estimate]:
    _, g = setting(result)
    rows = {_spread(t): _mean_square(result, t) for t in TIMES}
    for t in PULSES if g == 0 else ():
        number = result[_counter(t)].number
        edges = np.rint((1 + QUARTERS) * BINS / 2).astype(int)
        for i, (low, high) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
            rows[_quarter(t, i)] = number[low:high].sum() + number[BINS - high : BINS - low].sum()
    return rows


def _mean_square(result: tp.Result, time: float) -> tp.Estimate:
    """⟨r²⟩ = 3⟨x²⟩ [m²], from the middles of bins, less h²/12."""
    edges = _bins(time) * setting(result)[0]
    squares = ((edges[1:] + edges[:-1]) / 2) ** 2 - (edges[1] - edges[0]) ** 2 / 12
    return (result[_counter(time)].number * (3 * squares)).sum() * constant(result, 1.0, "m^2")


def setting(result: tp.Result) -> tuple[float, float]:
    """Mean free path [m] and g of a run with a clock."""
    medium = result.scene.medium
    return 1 / medium.scattering, medium.phase.g


@of_scene(scene)
def exact(subject: str, albedo: float, mean_free_path: float, g: float) -> dict[str, float]:
    length = mean_free_path
    if subject == "steady":
        fog = 1 / length, albedo
        means = point_source.shell_means(SHELLS * length, *fog)
        rows = {f"{_shell(i)}, by {name}": float(each) for name in ESTIMATORS for i, each in enumerate(means)}
        rows |= {_through(r): point_source.net_flux(r * length, *fog) for r in SPHERES}
        return rows | {_within(): point_source.absorbed_within(SHELLS[-1] * length, *fog)}
    rows = {_spread(t): float(length**2 * random_flights.mean_square_displacement(t, g)) for t in TIMES}
    for t in PULSES if g == 0 else ():
        shares = 2 * random_flights.plane_pulse_shares(QUARTERS * t, t)
        rows |= {_quarter(t, i): float(each) for i, each in enumerate(shares)}
    return rows


def _shell(index: int) -> str:
    return f"fluence rate, {SHELLS[index]:g} to {SHELLS[index + 1]:g} free paths"


def _through(radius: float) -> str:
    return f"net flux through {radius:g} free paths"


def _within() -> str:
    return f"absorbed within {SHELLS[-1]:g} free paths"


def _spread(time: float) -> str:
    return f"⟨r²⟩ after {time:g} free times"


def _quarter(time: float, index: int) -> str:
    return f"share at |x| = {QUARTERS[index]:g} to {QUARTERS[index + 1]:g} vt, {time:g} free times"


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in outcomes:
        if outcome.given["subject"] == "steady":
            albedo = outcome.given["albedo"]
            near, far = (outcome[f"{_shell(i)}, by track"] for i in (0, len(SHELLS) - 2))
            direct = [_straight_share(i, albedo) for i in (0, len(SHELLS) - 2)]
            said.append(
                f"with the albedo {albedo:g} the fluence rate falls from {near.estimate} to {far.estimate},"
                f" of which {direct[0]:.2g} and {direct[1]:.2g} came straight"
            )
        else:
            first, end = (outcome[_spread(t)].estimate for t in (TIMES[0], TIMES[-1]))
            grows = f"⟨r²⟩ grows from {first} to {end} in {TIMES[-1] / TIMES[0]:g} times the time"
            said.append(f"with g = {outcome.given['g']:g} {grows}")
    return sentence(*said, furthest(outcomes))


def _straight_share(index: int, albedo: float) -> float:
    """Share of a shell's fluence rate that has not collided."""
    edges = SHELLS[index : index + 2]
    return float(point_source.shell_means(edges)[0] / point_source.shell_means(edges, 1.0, albedo)[0])


@curves_figure(
    xlabel="distance from the source  [mean free paths]",
    ylabel="fluence rate per watt",
    log_x=True,
    log_y=True,
)
def draw_fluence(outcomes: list[Outcome]) -> dict[str, object]:
    """Of the lowest albedo: by distance, with what comes straight, and diffusion.

    Each shell's mean stands where the exact fluence rate has that value.
    """
    outcome = min(outcomes, key=lambda o: o.given["albedo"])
    albedo, scale = outcome.given["albedo"], 1 / outcome.given["mean_free_path"] ** 2
    fine = np.geomspace(SHELLS[1] / 10, SHELLS[-1], 1000)
    means, curve = point_source.shell_means(SHELLS, 1.0, albedo), point_source.fluence_rate(fine, 1.0, albedo)
    places = np.interp(-np.log(means), -np.log(curve), fine)
    return {
        "series": (places, outcome.result["track"].fluence_rate, (fine, scale * curve), scale * means),
        "guides": {
            "light that comes straight, alone": lambda r: scale * point_source.uncollided(r),
            "diffusion theory": lambda r: scale * point_source.diffusion(r, albedo),
        },
        "title": f"A point of light in fog of albedo {albedo:g}",
        "note": provenance([outcome]),
    }


@curves_figure(
    xlabel="time  [mean free times]",
    ylabel=r"mean square displacement $\langle r^2\rangle$",
    title="Light in fog: straight flight first, diffusion in the end",
    log_x=True,
    log_y=True,
)
def draw_spread(outcomes: list[Outcome]) -> dict[str, object]:
    """⟨r²⟩ in time: straight flight at first, diffusion in the end."""
    fine, series = np.geomspace(TIMES[0] / 2, 2 * TIMES[-1], 200), {}
    for outcome in outcomes:
        area, g = outcome.given["mean_free_path"] ** 2, outcome.given["g"]
        rows = [outcome[_spread(t)] for t in TIMES]
        curve = fine, area * random_flights.mean_square_displacement(fine, g)
        guide = {f"diffusion, 2 t/(1 - g), g = {g:g}": (fine, 2 * area * fine / (1 - g))}
        found, expected = [row.estimate for row in rows], [row.exact for row in rows]
        series[f"g = {g:g}"] = TIMES, found, curve, expected, None, guide
    return {"series": series}


@curves_figure(
    xlabel="x  [mean free paths]",
    ylabel="share of the particles per mean free path",
    title="A burst in fog along one axis after t mean free times: a front, then a bell",
)
def draw_pulse(outcomes: list[Outcome]) -> dict[str, object]:
    """The burst along x, at several times; a curve ends at its front."""
    result, series, group = outcomes[0].result, {}, BINS // 25
    for t in PULSES:
        number, edges = result[_counter(t)].number, _bins(t)[::group]
        widths = constant(result, (edges[1] - edges[0]), "1")
        shares = [number[i : i + group].sum() / widths for i in range(0, BINS, group)]
        expected = random_flights.plane_pulse_shares(edges, t) / np.diff(edges)
        fine = np.linspace(-t, t, 301)
        curve = fine, [float(random_flights.plane_pulse(x, t)) if abs(x) < t else math.nan for x in fine]
        series[f"t = {t:g}"] = edges, shares, curve, expected
    return {"series": series, "note": provenance(outcomes[:1])}


draw = figures(
    fluence=(draw_fluence, where(subject="steady")),
    spread=(draw_spread, where(subject="clock")),
    pulse=(draw_pulse, where(subject="clock", g=0)),
)


if __name__ == "__main__":
    main(__file__)
