"""Phase functions: light that is scattered once goes where they say.

Derivation.  A pencil beam of the power P crosses a ball of fog so thin that almost nothing is scattered
twice. Each length ds of the beam scatters P σ ds.  The phase function p(μ) [sr⁻¹] is the share per
steradian that goes at the angle arccos μ from the beam.  A point at the distance r from ds receives

    φ = P ∫ σ p(μ) / r² ds   along the beam within the ball.

p is 3 (1 + μ²)/(16π) for grains small against the wavelength (Rayleigh 1871) and
(1 - g²)/(4π (1 + g² - 2gμ)^(3/2)) for larger ones (Henyey and Greenstein 1941).  For several kinds of
grains p is the mean of theirs, weighted by the scattering of each kind.

In thicker fog the beam has lost the share 1 - exp(-σ(R + s)) before the place s from the middle.  Light
scattered there has the way l(s, μ) = sqrt(R² - s²(1 - μ²)) - sμ before it.  So the power

    P ∫∫ σ exp(-σ(R + s + l)) 2π p dμ ds

leaves between two angles after one scattering.

Scene.  "points": PointDetectors 1 m from the middle of a thin ball.  Every flight scores at them, so the
noise is only that of p along the few centimetres in the ball.  "sky": a far sphere about a thicker ball
counts light that was scattered once, in one bin of position per range of angles.  The first tests the
density of p, the second the sampling from it.  A mixture that chose its part and the angle with one random
number would fail in the "sky"; a mixture without its shares would fail at the "points".
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

import transport as tp
from transport.sims import (
    check_choices,
    constant,
    figures,
    furthest,
    main,
    of_scene,
    rows_figure,
)
from transport.statistics.quadrature import legendre_nodes
from transport.theory import phases
from transport.verification.experiment import Outcome

law = (
    "φ = P ∫ σ p(μ)/r² ds, scattered once: P ∫∫ σ exp(-τ) 2π p dμ ds"
    " (Rayleigh 1871; Henyey and Greenstein 1941)"
)
question = "Where does light go that is scattered once, by each kind of grain and by a mixture of them?"
particles = 1_000_000

RADIUS, DISTANCE, POWER = 0.05, 1.0, 1.0  # m, m, W
DEPTHS = {"points": 1e-9, "sky": 0.5}  # optical depth across the ball
ANGLES = (20.0, 60.0, 110.0, 160.0)  # degrees from the beam, at which the points are
EDGES = (0.0, 30.0, 60.0, 90.0, 120.0, 180.0)  # degrees, of the bins of the sky
SKY = 1e3  # m
MIXED = {"small": 0.5, "large": 0.3, "backward": 0.2}  # what each kind of grain scatters of the whole
FORWARD, BACKWARD = 0.7, -0.4  # g of large grains, and of those that scatter back
NODES = 40  # of quadrature along each coordinate
READINGS, GRAINS = ("points", "sky"), ("small", "large", "both")


def cases() -> list[dict[str, str]]:
    return [{"reading": reading, "grains": grains} for reading in READINGS for grains in GRAINS]


def scene(reading: str = "points", grains: str = "both", g: float = FORWARD) -> tp.Scene:
    """A ball of thin fog in a pencil beam.  reading: "points" or "sky".

    grains: "small" (Rayleigh), "large" (Henyey and Greenstein, mean cosine g) or "both", mixed with
    a third kind that scatters back.
    """
    check_choices("phase_functions", reading=(reading, READINGS), grains=(grains, GRAINS))
    fog = tp.Medium(scattering=DEPTHS[reading] / (2 * RADIUS), phase=_phase(grains, g))
    points = [tp.PointDetector(tuple(DISTANCE * _way(angle)), _point(angle)) for angle in ANGLES]
    bins = tp.Positions(u=tuple(np.radians(EDGES)))
    sky = tp.Detector(tp.Sphere(radius=SKY), "sky", side="inside", events=1, positions=bins)
    return tp.Scene(
        tp.Source(tp.Point(position=(0, 0, -2 * RADIUS)), tp.Beam((0, 0, 1), power=POWER)),
        tp.Surface(tp.Sphere(radius=RADIUS), tp.Transparent(), "ball", inside=fog),
        points if reading == "points" else sky,
    )


def _phase(grains: str, g: float) -> tp.Rayleigh | tp.HenyeyGreenstein | tp.Mixture:
    large, backward = tp.HenyeyGreenstein(g), tp.HenyeyGreenstein(BACKWARD)
    kinds = {"small": tp.Rayleigh(), "large": large, "backward": backward}
    if grains != "both":
        return kinds[grains]
    return tp.Mixture({phase: MIXED[kind] for kind, phase in kinds.items()})


def _way(angle: float) -> np.ndarray:
    """The direction at so many degrees from the beam, off all planes of the axes."""
    theta = math.radians(angle)
    return np.array([0.6 * math.sin(theta), 0.8 * math.sin(theta), math.cos(theta)])


def _point(angle: float) -> str:
    return f"at {angle:g} degrees"


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    if "sky" not in result:
        return {_brightness(angle): result[_point(angle)].fluence_rate for angle in ANGLES}
    sky = result["sky"]
    areas = sky.detector.positions.areas(sky.detector.shape).ravel()
    return {
        _power(i): each * area * constant(result, 1.0, "m^2")
        for i, (each, area) in enumerate(zip(sky.irradiance, areas, strict=True))
    }


@of_scene(scene)
def exact(reading: str, grains: str, g: float) -> dict[str, float]:
    sigma = DEPTHS[reading] / (2 * RADIUS)
    nodes, weights = legendre_nodes(NODES)
    places, lengths = RADIUS * nodes, RADIUS * weights  # along the beam, from the middle of the ball
    left = sigma * np.exp(-sigma * (RADIUS + places)) * lengths
    if reading == "points":
        rows = {}
        for angle in ANGLES:
            ways = DISTANCE * _way(angle) - np.outer(places, (0, 0, 1))
            r = np.linalg.norm(ways, axis=1)
            sent = left * _density(ways[:, 2] / r, grains, g) / r**2
            rows[_brightness(angle)] = POWER * float(sent.sum())
        return rows
    rows = {}
    for i, (high, low) in enumerate(pairwise(np.cos(np.radians(EDGES)))):
        mu, solid = (high + low) / 2 + (high - low) / 2 * nodes, math.pi * (high - low) * weights
        s = places[:, None]
        ways = np.sqrt(RADIUS**2 - s**2 * (1 - mu**2)) - s * mu
        rows[_power(i)] = POWER * float(left @ np.exp(-sigma * ways) @ (_density(mu, grains, g) * solid))
    return rows


def _density(mu: np.ndarray, grains: str, g: float) -> np.ndarray:
    """p(μ) [sr^-1]."""
    kinds = {
        "small": phases.rayleigh(mu),
        "large": phases.henyey_greenstein(mu, g),
        "backward": phases.henyey_greenstein(mu, BACKWARD),
    }
    return sum(share * kinds[kind] for kind, share in (MIXED if grains == "both" else {grains: 1.0}).items())


def _brightness(angle: float) -> str:
    return f"fluence rate at {angle:g}°"


def _power(index: int) -> str:
    return f"scattered once by {EDGES[index]:g}° to {EDGES[index + 1]:g}°"


def verdict(outcomes: list[Outcome]) -> str:
    said = "Light goes where the phase functions say, and in a mixture where their mean says"
    return f"{said}: {furthest(outcomes)}."


draw = figures(rows=rows_figure("Light that is scattered once, by angle"))


if __name__ == "__main__":
    main(__file__)
