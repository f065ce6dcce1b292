"""Quantities: energy, power, intensity, irradiance, exitance, radiance and fluence rate, and how each follows from the others.

Derivation.  The radiance L(x, ω) is what flows along rays, per projected area and solid angle.  All others are sums of it
(Bala 2009, Cornell CS 6620, lecture 2; Hanrahan 2001, Stanford CS 348B, lecture 4):

    M, E = ∫ L cosθ dω,   I = ∫ L cosθ dA,   Φ = ∬ L cosθ dω dA,   Q = ∫ Φ dt,   φ = ∫ L dω.

Two equal coaxial disks of radius R at the distance d, the first of radiance L: M = π L, Φ = π L π R² F with the view factor F
(Howell, C-41), and in a cone of half angle α about the axis the mean of I is L π R² (1 + cosα)/2.  The mean of φ over the
second is L/(πR²) ∬ d/r³ dA dA'.  Pairs of points that lie ρ apart, seen along the axis, are as many as the overlap O(ρ) of
two disks so far apart, so that it is L/(πR²) ∫ O(ρ) d/(ρ² + d²)^(3/2) 2πρ dρ; O(2R cos u) = 2R² (u − sin u cos u).

A bin of radiance is a mean by cosθ: Φ of the bin over A ∫cosθ dω.  So the bins' ∫L cosθ dω is E, exactly and whatever their width.
Their ∫L dω is φ only for narrow bins: from the direction θ the share O(d tanθ)/πR² of the meter sees the lamp, which is more at
small θ, where cosθ is larger too, and the sum of 20 bins is 0.12 % above φ.  Its row is beside the exact sum of those bins.

Area.  Φ is extensive: twice the area receives twice the power, and one must name the area (Scratchapixel, lesson on
radiometry).  E = dΦ/dA is not: a uniform beam has the same E on each.

Superposition.  Rays do not interact (Bala 2009): two lamps give the sum of what each gives alone, history by history, because
each particle has left one of the lamps.  From a Lambert sphere a meter receives what it would receive from a point in its
middle: the vector ∫ L ω dω of a sphere is that of a point.  So P Ω/4π falls on a rectangle of the floor that fills Ω.

Facing.  Along a ray the radiance that leaves a surface (exitant) is that which arrives (incident), and both directions point
away from their surfaces: ω at the receiver points back to the lamp, where the light comes from.  Nothing comes from the
mirrored direction.

Exposure.  Film and skin count H = ∫ E dt [J m⁻²] (Hanrahan 2001): a quarter of the light for four times the time is the same.  A beam that
arrives at the angle θ has the fluence F = ∫ φ dt = E₀ t, whatever the turn of the film, and exposes it to H = F cosθ.

Photons.  Each has E = h ν = h c/λ (Scratchapixel; Bala 2009 writes h/λ, a slip: that is the momentum).  A lamp of power P
emits P λ/(h c) a second, and a pupil of radius a at the distance r receives (1 − r/√(r² + a²))/2 of them.

Plenoptic function.  L(x, y, z, θ, φ) in empty space, and L(x, y, z, θ, φ, t) with a clock (Hanrahan 2001): a lamp that is
switched on at t = 0 is seen from a place as L from t = r/c on, r the length of the ray, and before as 0; beside it is 0.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import transport as tp
from transport.sims import constant, figures, furthest, main, of_scene, one_of, sentence, sharp, where
from transport.statistics.quadrature import legendre_nodes
from transport.theory import emitters, solid_angles, view_factors
from transport.verification.experiment import Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes

law = (
    "E = ∫L cosθ dω, Φ = ∬L cosθ dω dA, H = ∫E dt, E = hν; rays do not interact"
    " (Bala 2009, Cornell CS 6620; Hanrahan 2001, Stanford CS 348B, lecture 4)"
)
question = "How do Q, Φ, I, E, M, L and φ follow from each other, and which of them add up?"
particles = 8_000_000
intended = {
    "aim": "each lamp is aimed at the detectors that are read of it",
}

SHOWS = ("integrals", "area", "superposition", "facing", "exposure", "photons", "plenoptic")
RADIUS = 0.5  # m, of lamps and of the meter that faces them
APART = 0.5  # m, between lamp and meter
SECONDS = 60.0  # that the lamp is on
CONE = math.radians(20)  # half angle, of the intensity
BINS = {"mu": 20, "phi": 12}  # of radiance
RINGS = 4
AREAS = (0.25, 0.5, 1.0, 2.0)  # m²
BEAM = (3.0, 2.0)  # m, sides of the beam

HEIGHT, BULB, AROUND = (
    1.0,
    0.1,
    0.12,
)  # m: of the bulbs above the floor, their radius, that of the spheres round them
PLACES = {"lamp A": (-0.8, 0.0, HEIGHT), "lamp B": (0.8, 0.0, HEIGHT)}
POWERS = {"lamp A": 1.0, "lamp B": 0.5}  # of the power that is set
FLOOR = (3.0, 0.4)  # m
STRIPS = 15  # bins across the floor
ROWS = {"under lamp A": 3, "in the middle": 7, "under lamp B": 11}  # strips of the table
BOTH, UNEXPLAINED, EXCESS = "both lamps", "arrivals from neither lamp", "E of both − E of A − E of B"

SLANT, SEEN = math.radians(30), math.radians(10)  # of the ray to the lamp, half angle of the cones
STOPS = (1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0)  # s that the shutter has been open
TURN = math.radians(60)  # of the third film
FILMS = {"f/4": 1.0, "f/8": 0.25}  # share of the light that passes
FILM = (0.036, 0.024)  # m
PLANCK = 6.62607015e-34  # J s, exact (SI Brochure 2019, 2.2)
WAVELENGTH = 550 * tp.nm
PHOTON = PLANCK * tp.speed_of_light / WAVELENGTH  # J, h c/λ
# For the exact values, which do not use PHOTON: a photon of λ nm has 1239.84/λ eV (CODATA 2018).
EV_NM, EV = 1239.8419843320026, 1.602176634e-19  # h c/e [eV nm], and an electron volt [J]
PUPIL = 3.5e-3  # m, radius
FAR = {"1 m": 1.0, "1 km": 1e3, "1000 km": 1e6}
WATCHERS = {"near": (0.0, 0.0, 1.0), "aside": (1.0, 0.5, 1.5), "far": (0.0, -0.5, 3.0)}  # m
WATCHER, LOOK = 0.1, 0.08  # m, radius of a place; half angle that it looks through [rad]
CLOCK = 14 * tp.ns
TICKS = 28  # bins of time in the picture


def cases() -> list[dict[str, object]]:
    shown = [{"show": show} for show in SHOWS[:-2]]
    photons = [{"show": "photons", "distance": distance} for distance in FAR.values()]
    return [*shown, *photons, *({"show": "plenoptic", "place": place} for place in WATCHERS)]


def scene(
    show: str = "integrals",
    radiance: float = 100.0,
    power: float = 60.0,
    distance: float = 1e3,
    place: str = "near",
) -> tp.Scene:
    """What is shown of the quantities.

    radiance [W m^-2 sr^-1] of the disks, and of the beams in W m^-2;  power [W] of lamp A and of the bulb;  distance [m] of the
    pupil from the bulb;  place: of the plenoptic function.
    """
    one_of("quantities", show=(show, SHOWS), place=(place, WATCHERS))
    match show:
        case "integrals":
            return _integrals(radiance)
        case "area":
            return _area(radiance)
        case "superposition":
            return _superposition(power)
        case "facing":
            return _facing(radiance)
        case "exposure":
            return _exposure(radiance)
        case "photons":
            return _photons(power, distance)
    return _plenoptic(radiance, WATCHERS[place])


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    names = set(result)
    for known, rows in (
        ("meter", _integral_rows),
        (_patch(AREAS[0]), _area_rows),
        (BOTH, _superposition_rows),
        ("receiver", _facing_rows),
        ("f/4", _exposure_rows),
        ("pupil", _photon_rows),
    ):
        if known in names:
            return rows(result)
    return _plenoptic_rows(result)


@of_scene(scene)
def exact(show: str, radiance: float, power: float, distance: float, place: str) -> dict[str, float]:
    match show:
        case "integrals":
            return _exact_integrals(radiance)
        case "area":
            fluxes = {f"Φ, {_patch(area)}": radiance * area for area in AREAS}
            return fluxes | {f"E, {_patch(area)}": radiance for area in AREAS} | {DOUBLED: 2.0, KEPT: 1.0}
        case "superposition":
            sums = {name: power * irradiances(name) for name in PLACES}
            both = sums["lamp A"] + sums["lamp B"]
            rows = {f"E {name}, {at}": float(e[i]) for name, e in sums.items() for at, i in ROWS.items()}
            rows |= {f"E {BOTH}, {at}": float(both[i]) for at, i in ROWS.items()}
            return rows | {UNEXPLAINED: 0.0, EXCESS: 0.0}
        case "facing":
            return {LEAVING: radiance, ARRIVING: radiance, MIRRORED: 0.0}
        case "exposure":
            rows = {f"H, {film}, {_open(t)}": radiance * s * t for film, s in FILMS.items() for t in STOPS}
            return rows | {TURNED: radiance * math.cos(TURN), FLUENCE: radiance, SAME: 1.0}
        case "photons":
            rate, share = power / (EV_NM / 550 * EV), pupil_share(distance)
            return {EMITTED: rate, THROUGH: rate * share, CARRIED: power * share}
    return dict.fromkeys(_moments(place), 0.0) | {_moments(place)[1]: radiance}


# ---- all quantities from radiance ----

COUNTED = {"Q": "Q, energy on the meter", "Φ": "Φ on the meter", "E": "E of the meter", "φ": "φ at the meter",
           "M": "M of the lamp", "I": "I of the lamp", "Φ0": "Φ of the lamp"}  # fmt: skip
SUMMED = {
    "E": "∫L cosθ dω, the meter",
    "Φ": "∬L cosθ dω dA, the meter",
    "φ": "∫L dω, the meter",
    "M": "∫L cosθ dω, the lamp",
}
LAMP_L = "L of the lamp"
DIFFERENCE = "Φ − ∬L cosθ dω dA"


def _integrals(radiance: float) -> tp.Scene:
    lamp = tp.Disk(radius=RADIUS)
    meter = tp.Disk(center=(0, 0, APART), normal=(0, 0, -1), radius=RADIUS)
    directions = tp.Directions(**BINS)
    rings = tp.Positions(u=RADIUS * np.sqrt(np.arange(RINGS + 1) / RINGS))
    detectors = [
        tp.Detector(lamp, "lamp", directions=directions),
        tp.Detector(lamp, "cone", directions=tp.Directions.cone((0, 0, 1), CONE)),
        tp.Detector(meter, "meter"),
        tp.Detector(meter, "radiance", directions=directions, positions=rings),
    ]
    return tp.Scene(tp.Source(lamp, tp.Lambertian(radiance=radiance)), detectors=detectors, duration=SECONDS)


def _bins() -> tuple[np.ndarray, np.ndarray]:
    return np.linspace(0, 1, BINS["mu"] + 1), np.linspace(0, 2 * math.pi, BINS["phi"] + 1)


def _over_directions(
    radiances: tp.EstimateArray, result: tp.Result, projected: bool = True
) -> tp.EstimateArray:
    """Sum of the bins of radiance times their ∫cosθ dω, or their ∫dω."""
    sizes = solid_angles.bin_projected_solid_angles if projected else solid_angles.bin_solid_angles
    return (radiances * sizes(*_bins()) * constant(result, 1.0, "sr")).sum(("mu", "phi"))


def _integral_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    lamp, meter, binned = result["lamp"], result["meter"], result["radiance"]
    area = constant(result, meter.area, "m^2")
    mean = _over_directions(binned.radiance.mean("u"), result)  # the rings have equal areas
    fluence_rate = _over_directions(binned.radiance.mean("u"), result, projected=False)
    whole, leaving = mean * area, _over_directions(lamp.radiance_out, result)
    return {
        LAMP_L: lamp.radiance_out.mean(),
        COUNTED["M"]: lamp.exitance,
        SUMMED["M"]: sharp(leaving, of=leaving),
        COUNTED["Φ0"]: lamp.flux_out,
        COUNTED["I"]: result["cone"].intensity_out[0],
        COUNTED["E"]: meter.irradiance,
        SUMMED["E"]: mean,
        COUNTED["Φ"]: meter.flux_in,
        SUMMED["Φ"]: whole,
        DIFFERENCE: sharp(meter.flux_in - whole, of=whole),
        COUNTED["φ"]: meter.fluence_rate,
        SUMMED["φ"]: fluence_rate,
        COUNTED["Q"]: meter.energy_in,
    }


def overlap(shift: np.ndarray, radius: float) -> np.ndarray:
    """Area that two equal disks have in common whose middles are that far apart [m^2]."""
    u = np.arccos(np.clip(shift / (2 * radius), 0.0, 1.0))
    return 2 * radius**2 * (u - np.sin(u) * np.cos(u))


def binned_fluence_rate(radius: float, distance: float) -> float:
    """Sum of the bins of L/L₀ times their ∫dω, the mean over the meter [sr]: each bin's mean is by cosθ, not by dω."""
    nodes, weights = legendre_nodes(64)
    edges = np.union1d(
        _bins()[0], distance / math.hypot(distance, 2 * radius)
    )  # the last is where nothing is seen
    mu = (edges[:-1, None] + edges[1:, None]) / 2 + np.diff(edges)[:, None] / 2 * np.sin(math.pi / 2 * nodes)
    slope = np.diff(edges)[:, None] / 2 * math.pi / 2 * np.cos(math.pi / 2 * nodes)
    seen = overlap(distance * np.sqrt(1 - mu**2) / mu, radius) / (math.pi * radius**2)
    flux = (seen * mu * slope) @ weights
    bins = np.searchsorted(_bins()[0], edges[:-1], side="right") - 1
    low, high = _bins()[0][:-1], _bins()[0][1:]
    per_bin = np.bincount(bins, weights=flux, minlength=len(low))
    return float(2 * math.pi * (per_bin / ((low + high) / 2)).sum())


def mean_fluence_rate(radius: float, distance: float) -> float:
    """Mean of φ/L over a disk that faces an equal Lambert disk [sr]."""
    nodes, weights = legendre_nodes(64)
    u = math.pi / 4 * (1 + nodes)  # of ρ = 2 R cos u
    rho, slope = 2 * radius * np.cos(u), 2 * radius * np.sin(u) * math.pi / 4
    pairs = overlap(rho, radius) * 2 * math.pi * rho * distance / (rho**2 + distance**2) ** 1.5 * slope
    return float(pairs @ weights / (math.pi * radius**2))


def _exact_integrals(radiance: float) -> dict[str, float]:
    area = math.pi * RADIUS**2
    exitance = math.pi * radiance
    through = exitance * area * float(view_factors.coaxial_disks(RADIUS, RADIUS, APART))
    fluence_rate = radiance * mean_fluence_rate(RADIUS, APART)
    return {
        LAMP_L: radiance,
        COUNTED["M"]: exitance,
        SUMMED["M"]: exitance,
        COUNTED["Φ0"]: exitance * area,
        COUNTED["I"]: radiance * area * (1 + math.cos(CONE)) / 2,
        COUNTED["E"]: through / area,
        SUMMED["E"]: through / area,
        COUNTED["Φ"]: through,
        SUMMED["Φ"]: through,
        DIFFERENCE: 0.0,
        COUNTED["φ"]: fluence_rate,
        SUMMED["φ"]: radiance * binned_fluence_rate(RADIUS, APART),
        COUNTED["Q"]: through * SECONDS,
    }


# ---- area ----

DOUBLED, KEPT = "Φ, twice the area", "E, twice the area"


def _patch(area: float) -> str:
    return f"patch of {100 * area:g} dm²"


def _area(irradiance: float) -> tp.Scene:
    width, height = BEAM
    lamp = tp.Rectangle(center=(0, 0, 2), normal=(0, 0, -1), width=width, height=height)
    patches = [
        tp.Detector(
            tp.Rectangle(center=(0, 0, k / 4), width=math.sqrt(2 * a), height=math.sqrt(a / 2)), _patch(a)
        )
        for k, a in enumerate(AREAS)
    ]
    return tp.Scene(tp.Source(lamp, tp.Beam((0, 0, -1), irradiance=irradiance)), detectors=patches)


def _area_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    fluxes = {f"Φ, {_patch(area)}": result[_patch(area)].flux_in for area in AREAS}
    irradiances = {f"E, {_patch(area)}": result[_patch(area)].irradiance for area in AREAS}
    first, second = (result[_patch(area)] for area in AREAS[1:3])
    ratios = {DOUBLED: second.flux_in / first.flux_in, KEPT: second.irradiance / first.irradiance}
    return fluxes | irradiances | ratios


# ---- superposition ----


def _superposition(power: float) -> tp.Scene:
    """Two bulbs over a white floor, each within a transparent sphere which tells whose light it was."""
    ground = tp.Rectangle(width=FLOOR[0], height=FLOOR[1])
    bulbs = [
        tp.Source(tp.Sphere(center=at, radius=BULB), tp.Lambertian(power=power * POWERS[name]), aim=ground)
        for name, at in PLACES.items()
    ]
    floor = tp.Surface(ground, tp.Diffuse(0.8), "floor")
    spheres = [
        tp.Detector(tp.Sphere(center=at, radius=AROUND), f"round {name}") for name, at in PLACES.items()
    ]
    strips = tp.Positions(x=STRIPS)
    of_each = [tp.Detector("floor", name, positions=strips, via=f"round {name}") for name in PLACES]
    both = tp.Detector("floor", BOTH, positions=strips)
    return tp.Scene(bulbs, surfaces=floor, detectors=[*spheres, *of_each, both])


def irradiances(name: str) -> np.ndarray:
    """Exact mean irradiance of each strip of the floor by one lamp, over the power that is set [m^-2]."""
    x, y = np.linspace(-FLOOR[0] / 2, FLOOR[0] / 2, STRIPS + 1), FLOOR[1] / 2
    outlines = [[(a, -y, 0), (b, -y, 0), (b, y, 0), (a, y, 0)] for a, b in zip(x[:-1], x[1:], strict=True)]
    filled = np.array([solid_angles.polygon_solid_angle(each, PLACES[name]) for each in outlines])
    return POWERS[name] * filled / (4 * math.pi * np.diff(x) * FLOOR[1])


def _superposition_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    both, (first, second) = result[BOTH], (result[name] for name in PLACES)
    rows = {f"E {name}, {at}": result[name].irradiance[i] for name in PLACES for at, i in ROWS.items()}
    rows |= {f"E {BOTH}, {at}": both.irradiance[i] for at, i in ROWS.items()}
    excess = both.irradiance - first.irradiance - second.irradiance
    left = tp.Estimate(np.abs(excess.values).max(axis=1), result.run, excess.unit)
    unexplained = np.abs(both.counts.value - first.counts.value - second.counts.value).sum()
    return rows | {
        UNEXPLAINED: constant(result, unexplained, "1"),
        EXCESS: sharp(left, of=both.irradiance.sum()),
    }


# ---- incident and exitant ----

LEAVING, ARRIVING, MIRRORED = (
    "L leaving the lamp, ω to the receiver",
    "L at the receiver, ω to the lamp",
    "L at the receiver, mirrored ω",
)


def _facing(radiance: float) -> tp.Scene:
    """A lamp on the left, straight up a slanted ray from the receiver; both face each other."""
    ray = np.array([-math.sin(SLANT), 0, math.cos(SLANT)])  # from the receiver to the lamp
    lamp = tp.Disk(center=ray, normal=-ray, radius=RADIUS)
    receiver = tp.Disk(radius=0.3)
    cones = {"receiver": ray, "mirrored": ray * (-1, 1, 1)}
    detectors = [
        tp.Detector(receiver, name, directions=tp.Directions.cone(axis, SEEN)) for name, axis in cones.items()
    ]
    leaving = tp.Detector(lamp, "leaving", directions=tp.Directions.cone(-ray, SEEN))
    return tp.Scene(tp.Source(lamp, tp.Lambertian(radiance=radiance)), detectors=[*detectors, leaving])


def _facing_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    return {
        LEAVING: result["leaving"].radiance_out[0],
        ARRIVING: result["receiver"].radiance[0],
        MIRRORED: result["mirrored"].radiance[0],
    }


# ---- exposure ----

TURNED, FLUENCE, SAME = (
    "H, f/4, turned by 60°, 1 s",
    "F, f/4, turned by 60°, 1 s",
    "H, f/4 for 1/8 s over f/8 for 1/2 s",
)


def _open(seconds: float) -> str:
    return "1 s" if seconds == 1 else f"1/{round(1 / seconds)} s"


def _exposure(irradiance: float) -> tp.Scene:
    """Two beams, one of them a quarter as bright, on films of their own; a turned one in the first."""
    width, height = FILM
    sources, films = [], []
    for k, (name, share) in enumerate(FILMS.items()):
        lens = tp.Rectangle(center=(k, 0, 0.1), normal=(0, 0, -1), width=1.2 * width, height=1.2 * height)
        sources.append(tp.Source(lens, tp.Beam((0, 0, -1), irradiance=share * irradiance)))
        film = tp.Rectangle(center=(k, 0, 0), width=width, height=height)
        films.append(tp.Detector(film, name, times=(0, *STOPS)))
    turned = tp.Rectangle(
        center=(0, 0, 0.04), normal=(math.sin(TURN), 0, math.cos(TURN)), width=width, height=height
    )
    return tp.Scene(sources, detectors=[*films, tp.Detector(turned, "turned")], duration=STOPS[-1])


def _exposure_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    area, rows = constant(result, FILM[0] * FILM[1], "m^2"), {}
    for name in FILMS:
        energies = result[name].energy_in
        for k, seconds in enumerate(STOPS):
            rows[f"H, {name}, {_open(seconds)}"] = energies[: k + 1].sum() / area
    same = rows["H, f/4, 1/8 s"] / rows["H, f/8, 1/2 s"]
    turned = result["turned"]
    return rows | {TURNED: turned.energy_in / area, FLUENCE: turned.fluence, SAME: same}


# ---- photons ----

EMITTED, THROUGH, CARRIED = "photons a second, lamp", "photons a second, pupil", "power through the pupil"


def photon_rate(power: float) -> float:
    """Photons that a lamp emits a second, P/(hν) [s^-1]."""
    return power / PHOTON


def pupil_share(distance: float) -> float:
    """Share of a Lambert sphere's particles that pass through the pupil."""
    return float(emitters.mean_point_irradiance(1.0, PUPIL, distance)) * math.pi * PUPIL**2


def _photons(power: float, distance: float) -> tp.Scene:
    bulb = tp.Sphere(radius=0.03)
    pupil = tp.Disk(center=(0, 0, distance), normal=(0, 0, -1), radius=PUPIL)
    photons = tp.Effusive(exitance=photon_rate(power) / bulb.area, speed=tp.speed_of_light)
    return tp.Scene(tp.Source(bulb, photons, aim=pupil), detectors=tp.Detector(pupil, "pupil"))


def _photon_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    rate = result["pupil"].flux_in
    return {EMITTED: result.ledger["emitted"], THROUGH: rate, CARRIED: rate * constant(result, PHOTON, "J")}


# ---- the plenoptic function ----


def _moments(place: str) -> tuple[str, str, str]:
    x, y, z = WATCHERS[place]
    at = f"({x:g}, {y:g}, {z:g}) m"
    return f"L at {at}, to the lamp, before", f"L at {at}, to the lamp, after", f"L at {at}, beside the lamp"


def ways(place: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Directions from a place to the lamp's middle, and to beside the lamp."""
    to_lamp, beside = -np.array(place), np.array([2.5, 0, 0]) - place
    return to_lamp / np.linalg.norm(to_lamp), beside / np.linalg.norm(beside)


def arrival(place: tuple[float, float, float]) -> tuple[float, float]:
    """Times at which the first and the last ray of the cone arrive [s]."""
    to_lamp, _ = ways(place)
    slope, height = math.acos(-to_lamp[2]), place[2]
    nearest, furthest_ray = (height / math.cos(max(slope + turn, 0.0)) for turn in (-LOOK, LOOK))
    return 0.99 * nearest / tp.speed_of_light, 1.01 * furthest_ray / tp.speed_of_light


def _plenoptic(radiance: float, place: tuple[float, float, float]) -> tp.Scene:
    to_lamp, beside = ways(place)
    here = tp.Disk(center=place, normal=(0, 0, -1), radius=WATCHER)
    cone = tp.Directions.cone(to_lamp, LOOK)
    detectors = [
        tp.Detector(here, "to the lamp", directions=cone, times=(0, *arrival(place), CLOCK)),
        tp.Detector(here, "beside", directions=tp.Directions.cone(beside, LOOK), times=(0, CLOCK)),
        tp.Detector(here, "in time", directions=cone, times=TICKS),
    ]
    lamp = tp.Source(tp.Disk(radius=RADIUS), tp.Lambertian(radiance=radiance), aim=here)
    return tp.Scene(lamp, detectors=detectors, duration=CLOCK)


def _place(result: tp.Result) -> str:
    center = result["to the lamp"].detector.shape.center
    return next(name for name, place in WATCHERS.items() if place == tuple(center))


def _plenoptic_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    before, after, beside = _moments(_place(result))
    radiances = result["to the lamp"].radiance
    return {before: radiances[0, 0], after: radiances[2, 0], beside: result["beside"].radiance[0, 0]}


# ---- answer and pictures ----


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in outcomes:
        rows = {row.name: row.estimate for row in outcome.rows}
        match outcome.given["show"]:
            case "integrals":
                said.append(f"∫L cosθ dω is {rows[SUMMED['E']]}, counted {rows[COUNTED['E']]}")
            case "area":
                said.append(f"twice the area: Φ × {rows[DOUBLED]}, E × {rows[KEPT]}")
            case "superposition":
                said.append(f"of two lamps together {rows[UNEXPLAINED].value:g} arrivals come from neither")
            case "facing":
                said.append(f"{rows[LEAVING]} leaves along a ray and {rows[ARRIVING]} arrives")
            case "exposure":
                said.append(f"a quarter of the light for four times the time exposes alike, {rows[SAME]}")
            case "photons":
                said.append(f"{rows[THROUGH]} photons pass a pupil {outcome.given['distance']:g} m away")
            case "plenoptic":
                seen = rows[_moments(outcome.given["place"])[1]]
                said.append(f"from {outcome.given['place']} the lamp is {seen}, once its light has arrived")
    return sentence(*said, furthest(outcomes))


BOXES = {  # of the diagram: place, words, unit, row that was counted, row summed from L, how it follows from L
    "M": ((0.0, 7.0), "M  exitance", "W m^-2", COUNTED["M"], SUMMED["M"], "∫ L cosθ dω\n= π L"),
    "I": ((0.0, 3.3), "I  intensity", "W sr^-1", COUNTED["I"], None, "∫ L cosθ dA"),
    "Φ0": ((0.0, -0.4), "Φ  power", "W", COUNTED["Φ0"], None, "∬ L cosθ dω dA\n= π L A"),
    "L": ((6.2, 3.3), "L  radiance", "W m^-2 sr^-1", LAMP_L, None, ""),
    "E": ((13.5, 7.0), "E  irradiance", "W m^-2", COUNTED["E"], SUMMED["E"], "∫ L cosθ dω"),
    "Φ": ((13.5, 3.3), "Φ  power", "W", COUNTED["Φ"], SUMMED["Φ"], "∬ L cosθ dω dA"),
    "φ": ((13.5, -0.4), "φ  fluence rate", "W m^-2", COUNTED["φ"], SUMMED["φ"], "∫ L dω"),
    "Q": ((18.5, 3.3), "Q  energy", "J", COUNTED["Q"], None, "∫ dt"),
}
HALF_BOX = (2.0, 0.95)  # of their sizes


def draw_integrals(outcomes: list[Outcome], path: Path, note: str) -> None:
    """A diagram with radiance in its middle: how each quantity follows from it, what was counted, and what L sums to."""
    from transport.viz.exhibits import draw_arrow
    from transport.viz.style import BLUE, INK, MUTED, figure, unit_label
    from transport.viz.wording import number_text

    outcome, ways = outcomes[0], {"fontsize": 21, "ha": "center", "va": "center", "color": BLUE}
    source = np.array(BOXES["L"][0])
    with figure((16.4, 10.6), "All quantities are sums of radiance", note, path) as page:
        axes = page.subplots()
        for symbol, (place, words, unit, counted, summed, way) in BOXES.items():
            is_source = symbol == "L"
            box = {
                "boxstyle": "round,pad=0.4",
                "fc": "#dcebf5" if is_source else "white",
                "ec": INK,
                "lw": 2.5,
            }
            lines = f"{words}\n{number_text(outcome[counted].estimate)}\n{unit_label(unit)}"
            axes.text(
                *place, lines, ha="center", va="center", fontsize=21, bbox=box, linespacing=1.3, zorder=5
            )
            if summed:
                said = f"bins of L: {outcome[summed].estimate.value:.5g}"
                axes.text(place[0], place[1] - 1.5, said, color=BLUE, ha="center", va="center", fontsize=21)
            if is_source:
                continue
            start, end = np.array(BOXES["Φ"][0] if symbol == "Q" else source), np.array(place)
            side = np.sign(end - start)
            start, end = start + side * HALF_BOX, end - side * np.array([HALF_BOX[0] + 0.3, 0])
            draw_arrow(axes, start, end - start, BLUE, 3.5)
            white = {"fc": "white", "ec": "none", "pad": 2}
            axes.text(
                *((start + end) / 2 + (0, 0.42 if side[1] == 0 else 0)), way, bbox=white, zorder=6, **ways
            )
        area = f"A = {math.pi * RADIUS**2:.4g} m²"
        for x, words in (
            (0.0, f"where light leaves:\nthe lamp, {area}"),
            (13.5, "where it arrives:\nthe receiver"),
        ):
            axes.text(x, 9.3, words, color=MUTED, ha="center", va="center", fontsize=22, fontweight="bold")
        axes.set(xlim=(-2.3, 20.1), ylim=(-2.2, 10.0))
        axes.set_axis_off()


def draw_area(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Power and irradiance of patches in one beam, beside their area."""
    from transport.viz.style import BLUE, MUTED, VERMILLION, figure

    outcome = outcomes[0]
    level, areas = outcome.given["radiance"], np.linspace(0, 2.2, 50)
    with figure((15, 6.4), "Twice the area: twice the power, the same irradiance", note, path) as page:
        left, right = page.subplots(1, 2)
        for axes, symbol, law, wrong, colour, unit in (
            (left, "Φ", level * areas, level + 0 * areas, BLUE, "W"),
            (right, "E", level + 0 * areas, level * areas, VERMILLION, r"W m$^{-2}$"),
        ):
            rows = [outcome[f"{symbol}, {_patch(area)}"].estimate for area in AREAS]
            is_flux = symbol == "Φ"
            words = (
                ("Φ = E A", "if Φ were intensive") if is_flux else ("E = Φ/A", "if E were extensive: E ∝ A")
            )
            axes.plot(areas, law, color=colour, lw=3, label=words[0])
            axes.plot(areas, wrong, "--", color=MUTED, lw=2.5, label=words[1])
            axes.errorbar(
                AREAS, [r.value for r in rows], [r.error for r in rows], fmt="o", color=colour, ms=13
            )
            axes.set(
                xlabel=r"area A  [m$^2$]", ylabel=f"{symbol}  [{unit}]", xlim=(0, 2.2), ylim=(0, 2.3 * level)
            )
            axes.legend(loc="upper left")


def draw_superposition(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The lamps over the floor, and what each strip receives of each and of both."""
    from transport.viz.style import BLUE, INK, MUTED, ORANGE, VERMILLION, figure

    outcome = outcomes[0]
    power, edges = outcome.given["power"], np.linspace(-FLOOR[0] / 2, FLOOR[0] / 2, STRIPS + 1)
    middles, colours = (edges[1:] + edges[:-1]) / 2, {"lamp A": BLUE, "lamp B": VERMILLION}
    exact = {name: power * irradiances(name) for name in PLACES}
    first, second = exact.values()
    with figure((12.5, 12), "Rays do not interact: two lamps give the sum", note, path) as page:
        top, below = page.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": (1, 2)})
        for name, (x, _, z) in PLACES.items():
            for angle in np.radians(np.linspace(-68, 68, 9)):
                end = x + z * math.tan(angle)
                top.plot([x, end], [z, 0], color=colours[name], lw=1.8, alpha=0.55)
            top.plot(x, z, "o", ms=30, color=ORANGE, mec=colours[name], mew=3)
            top.text(x, z + 0.18, name, color=colours[name], ha="center")
        top.plot(edges[[0, -1]], [0, 0], color=INK, lw=6)
        top.set(ylim=(-0.05, 1.4), xlim=edges[[0, -1]], ylabel="z  [m]")
        top.grid(False)
        for name in PLACES:
            below.stairs(exact[name], edges, color=colours[name], lw=2.5)
            _points(below, middles, outcome.result[name].irradiance, colours[name], f"{name} alone")
        below.stairs(first + second, edges, color=INK, lw=2.5)
        _points(below, middles, outcome.result[BOTH].irradiance, INK, "both: the sum, arrival by arrival")
        wrong = (np.sqrt(first) + np.sqrt(second)) ** 2
        below.stairs(
            wrong,
            edges,
            color=MUTED,
            lw=2.5,
            ls="--",
            label=r"if amplitudes added: $(\sqrt{E_A}+\sqrt{E_B})^2$",
        )
        below.stairs(
            np.maximum(first, second),
            edges,
            color=MUTED,
            lw=2.5,
            ls=":",
            label="if only the brighter counted",
        )
        below.set(
            xlabel="x on the floor  [m]", ylabel=r"irradiance E  [W m$^{-2}$]", ylim=(0, 1.4 * wrong.max())
        )
        below.legend(loc="upper center", ncols=2, fontsize=15)


def _points(axes: Axes, x: np.ndarray, estimates: tp.EstimateArray, colour: str, label: str) -> None:
    axes.errorbar(x, estimates.value, estimates.error, fmt="o", color=colour, ms=9, mec="white", label=label)


def draw_facing(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The lamp, the receiver, and the directions along one ray, each away from its surface."""
    from transport.viz.style import BLUE, INK, MUTED, ORANGE, VERMILLION, figure

    outcome = outcomes[0]
    ray = np.array([-math.sin(SLANT), math.cos(SLANT)])
    across = np.array([math.cos(SLANT), math.sin(SLANT)])
    rows = {name: outcome[name].estimate for name in (LEAVING, ARRIVING, MIRRORED)}
    head = {"arrowstyle": "-|>,head_width=0.6,head_length=1.1", "lw": 5, "shrinkA": 0, "shrinkB": 0}
    with figure(
        (12.5, 9.5), "Directions point away from their surface, and L is the same", note, path
    ) as page:
        axes = page.subplots()
        axes.plot(
            *np.array([ray - RADIUS * across, ray + RADIUS * across]).T,
            color=ORANGE,
            lw=11,
            solid_capstyle="butt",
        )
        axes.plot([-0.3, 0.3], [0, 0], color=INK, lw=11, solid_capstyle="butt")
        axes.plot(*np.array([0 * ray, ray]).T, ":", color=MUTED, lw=2.5)
        shift = 0.03 * across
        axes.annotate("", 0.42 * ray + shift, 0.02 * ray + shift, arrowprops=head | {"color": BLUE})
        axes.annotate("", 0.58 * ray - shift, 0.98 * ray - shift, arrowprops=head | {"color": VERMILLION})
        mirrored = 0.42 * ray * (-1, 1)
        axes.annotate("", mirrored, (0, 0), arrowprops=head | {"color": MUTED})
        unit = r"W m$^{-2}$ sr$^{-1}$"
        for name, at, words, colour, place in (
            (LEAVING, 0.78 * ray, "exitant, ω from the lamp:", VERMILLION, "left"),
            (ARRIVING, 0.3 * ray, "incident, ω back to the lamp:", BLUE, "right"),
            (MIRRORED, mirrored, "incident, ω mirrored:", MUTED, "left"),
        ):
            value = (
                f"{rows[name].value:.4g}"
                if rows[name].value == 0
                else str(rows[name]).split(" W")[0].strip("()")
            )
            x = at[0] + (-0.07 if place == "right" else 0.08)
            axes.text(x, at[1], f"{words}\nL = {value} {unit}", color=colour, ha=place, va="center")
        axes.text(*(ray + (0.5 + 0.03) * across), " lamp", va="center")
        axes.text(0.32, 0, "receiver", va="center")
        axes.set(aspect="equal", xlim=(-1.35, 0.95), ylim=(-0.1, 1.3), xlabel="x  [m]", ylabel="z  [m]")
        axes.grid(False)


def draw_exposure(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Exposure by time through two stops, and the pairs of one exposure."""
    from transport.viz.style import BLUE, INK, MUTED, VERMILLION, figure

    outcome = outcomes[0]
    level, seconds = outcome.given["radiance"], np.array(STOPS)
    with figure((12, 8.5), "Film counts exposure: irradiance times time", note, path) as page:
        axes = page.subplots()
        fine = np.array([0.045, 1.4])
        for (name, share), colour in zip(FILMS.items(), (BLUE, VERMILLION), strict=True):
            rows = [outcome[f"H, {name}, {_open(t)}"].estimate for t in STOPS]
            axes.plot(fine, level * share * fine, color=colour, lw=3)
            values, errors = [r.value for r in rows], [r.error for r in rows]
            axes.errorbar(
                seconds,
                values,
                errors,
                fmt="o",
                ms=13,
                color=colour,
                label=f"{name}: E = {share * level:g} W m$^{{-2}}$",
            )
            axes.axhline(share * level, color=colour, lw=2.2, ls="--")
        axes.plot([], [], "--", color=MUTED, label="if the time did not matter")
        axes.plot([1 / 8, 1 / 2], [level / 8] * 2, color=INK, lw=5, alpha=0.35)
        axes.text(1 / 4, level / 9.6, "the same picture", ha="center", va="top")
        axes.set(xscale="log", yscale="log", xlim=fine, ylim=(level / 100, 2.6 * level))
        axes.set_xticks(STOPS, [_open(t) for t in STOPS])
        axes.minorticks_off()
        axes.set(xlabel="the shutter is open for", ylabel=r"exposure H = ∫E dt  [J m$^{-2}$]")
        axes.legend(loc="lower right")


def draw_photons(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Photons a second that pass a pupil, by distance."""
    from transport.viz.style import BLUE, MUTED, figure, tick_log

    power, fine = outcomes[0].given["power"], np.geomspace(0.4, 3e6, 60)
    shares = np.array([pupil_share(r) for r in fine])
    with figure(
        (12, 8.5), f"A {power:g} W lamp emits P/hν = {photon_rate(power):.3g} photons a second", note, path
    ) as page:
        axes = page.subplots()
        axes.loglog(fine, photon_rate(power) * shares, color=BLUE, lw=3, label="E = hν = hc/λ")
        wrong = power * shares / (PLANCK / WAVELENGTH)
        axes.loglog(fine, wrong, "--", color=MUTED, lw=2.5, label="E = h/λ, the slip of a lecture")
        for outcome in outcomes:
            row, distance = outcome[THROUGH].estimate, outcome.given["distance"]
            axes.errorbar(distance, row.value, row.error, fmt="o", ms=14, color=BLUE)
            axes.annotate(
                f"{row.value:.3g}", (distance, row.value), (14, 8), textcoords="offset points", color=BLUE
            )
        axes.set(xlabel="distance of the pupil  [m]", ylabel="photons through a pupil of 7 mm  [s$^{-1}$]")
        tick_log(axes.yaxis), tick_log(axes.xaxis)
        axes.legend(loc="upper right")


def draw_plenoptic(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The places, and the radiance from the lamp's middle at each by time."""
    from transport.viz.style import BLUE, GREEN, INK, MUTED, ORANGE, VERMILLION, figure

    colours = dict(zip(WATCHERS, (BLUE, VERMILLION, GREEN), strict=True))
    level = outcomes[0].given["radiance"]
    with figure((15, 8), "L(x, y, z, θ, φ, t): the lamp is switched on at t = 0", note, path) as page:
        left, right = page.subplots(1, 2, gridspec_kw={"width_ratios": (1, 1.6)})
        left.plot([-RADIUS, RADIUS], [0, 0], color=ORANGE, lw=10, solid_capstyle="butt")
        left.text(RADIUS + 0.06, 0, "lamp", va="center")
        right.axvline(0, color=MUTED, lw=3, ls="--", label="if light took no time")
        edges = np.linspace(0, CLOCK / tp.ns, TICKS + 1)
        for outcome in outcomes:
            name = outcome.given["place"]
            x, y, z = place = WATCHERS[name]
            colour, far = colours[name], math.dist(place, (0, 0, 0))
            left.plot([x - WATCHER, x + WATCHER], [z, z], color=INK, lw=6, solid_capstyle="butt")
            left.annotate(
                "", (0.75 * x, 0.75 * z), (x, z), arrowprops={"arrowstyle": "-|>", "lw": 3, "color": colour}
            )
            left.plot([0, x], [0, z], ":", color=colour, lw=2)
            side, shift = ("right", -0.14) if name == "near" else ("left", 0.14)
            left.text(x + shift, z, f"{name}\n({x:g}, {y:g}, {z:g})", color=colour, va="center", ha=side)
            seen = outcome.result["in time"].radiance[:, 0]
            middles = (edges[1:] + edges[:-1]) / 2
            right.errorbar(
                middles,
                seen.value,
                np.nan_to_num(seen.error),
                fmt="o",
                color=colour,
                ms=8,
                mec="white",
                label=name,
            )
            right.axvline(far / tp.speed_of_light / tp.ns, color=colour, lw=2.5)
        right.axhline(level, color=INK, lw=2)
        right.text(0.25, 1.03 * level, "L of the lamp")
        right.set(
            xlabel="time t  [ns]",
            ylabel=r"radiance from the lamp  [W m$^{-2}$ sr$^{-1}$]",
            ylim=(-4, 1.5 * level),
        )
        right.legend(loc="upper right", ncols=2)
        left.set(aspect="equal", xlabel="x  [m]", ylabel="z  [m]", xlim=(-1.0, 2.1), ylim=(-0.25, 3.4))
        left.grid(False)


draw = figures(
    **{
        show: (drawing, where(show=show))
        for show, drawing in zip(
            SHOWS,
            (
                draw_integrals,
                draw_area,
                draw_superposition,
                draw_facing,
                draw_exposure,
                draw_photons,
                draw_plenoptic,
            ),
            strict=True,
        )
    }
)


if __name__ == "__main__":
    main(__file__)
