"""Effusion: a gas leaves by a hole, the fast ones first; how a vessel empties, and who arrives when.

Derivation.  In a gas of density n whose velocities are Maxwellian, sigma² = kT/m for each component, n σ/√(2π) = n v̄/4
cross a plane one way, v̄ = √(8/π) σ.  Of each speed v as many cross as n v says, so that a speed's share is ∝ v · v²
exp(-v²/2σ²): the beam from a hole is faster than the gas behind it, (3/4)√(2π) σ = 1.880 σ in the mean and not v̄ = 1.596 σ,
and carries 2 kT a particle and not 3/2 kT (Knudsen 1909; Reif 1965, 7.11-7.12).  What is forgotten most easily is that
weight, and that v̄ is not the root mean square √3 σ.  Six settings:

ball    A gas in a ball; each hit on its thermal wall is lost with the chance f.  What a sphere sends back by the cosine law
        falls evenly on it, so the flights are independent and N(t) follows from a renewal equation, for any f.  It is near
        exp(-f S v̄ t/4V), which is what is said of a hole of the share f of the wall (Feller 1971, XI).
box     A gas in a box with thermal walls and a hole of area A.  At first it is in equilibrium and A n v̄/4 leave; while it
        stays near it, dN/dt = -N A v̄/4V and N = N₀ exp(-A v̄ t/4V).  It does so as A/S → 0: counted with holes of 1/50 and
        1/10 of the walls the rate is higher by 1.3 A/S of itself, and the hole here is 1/2000.
beam    A surface through which a gas behind it effuses: exitance n v̄/4, the moments above, speeds bin by bin.
wind    A gas that drifts along a patch's normal at u = √2 σ s: n [σ/√(2π) exp(-s²) + u/2 erfc(-s)] cross, net n u.
flight  A burst of a one-dimensional Maxwellian: erfc(d/√2 σ t)/2 of it is past a plane at the distance d.
burst   An isotropic burst of one speed v: (1 - d/vt)/2 of it is past the plane.

Scene.  The wind's gas fills all places from which a particle of less than 7 σ reaches the patch within the duration: of
the crossings fewer than 1e-10 are missing.  In ball and box time is told in flights, the mean time 4V/S v̄ between a particle's hits.
"""

from __future__ import annotations

import math

import numpy as np

import transport as tp
from transport.sims import constant, curves_figure, figures, grouped, main, of_scene, one_of, sentence, where
from transport.theory import effusion as theory
from transport.verification.experiment import Outcome

law = (
    "flux n v̄/4, energy 2 kT and mean speed (3/4)√(2π) σ of what leaves, N = N₀ exp(-A v̄ t/4V), in a drift"
    " n [σ/√(2π) exp(-s²) + u/2 erfc(-s)] (Knudsen 1909; Reif 1965, 7.11; Bird 1994, 4.22)"
)
question = "How fast does a gas leave by a hole, with which energy, and when does it arrive?"
particles = 1_000_000

SETTINGS = ("ball", "box", "beam", "wind", "flight", "burst")
HELIUM = 6.6464731e-27  # kg, of an atom: 4.002602 u
DENSITY, NUMBER = 1e20, 1e12  # m^-3; particles of a burst
RADIUS, SIDE, DISTANCE = 0.05, 0.1, 1.0  # m: of ball and patch, of the box, of the plane
LAST, EARLY = 30, 3  # flights: all, and those that the first flux is a mean over
SHOWN = {"ball": (2, 5, 10, 20, 30), "box": (10, 30)}  # flights
SMALL = 1e-3  # share of the walls, up to which the small hole's law is taken for exact
FASTEST = 7.0  # σ, of the wind; 3e-12 of each component are beyond
SPEEDS = np.linspace(0, 5, 26)  # σ, edges of the beam's bins
SHARES = {f"share of the beam, v {v} to {v + 1} σ": slice(5 * v, 5 * v + 5) for v in range(4)}
CLOCKS = {  # edges of bins, of the flight in d/σ, of the burst in d/v
    "flight": np.array([0, *np.arange(0.4, 3.01, 0.1)]),
    "burst": np.array([0, *np.arange(1, 2, 0.1), *np.arange(2, 10.1, 0.5)]),
}
PASSED = {  # numbers of these bins that the table counts
    "flight": {f"past the plane at {CLOCKS['flight'][last]:.1f} d/σ": last for last in (3, 9, 27)},
    "burst": {f"past the plane at {CLOCKS['burst'][last]:.1f} d/v": last for last in (6, 11, 27)},
}
PAST = {"flight": theory.fraction_past, "burst": theory.burst_fraction_past}
ENERGY, SPEED = "mean energy of the beam / kT", "mean speed of the beam / σ"
ONE_WAY, NET = "one way, with the wind / nσ", "net / nσ"
LEFT, GONE = "N/N₀ after {} flights", "1 − N/N₀ after {} flights"
EXITANCE, EARLY_FLUX = "exitance / (n v̄/4)", "flux through the hole at first / (n v̄/4)"


def cases() -> list[dict[str, object]]:
    winds = [{"setting": "wind", "speed_ratio": ratio} for ratio in (-0.5, 0.0, 0.5, 2.0)]
    ball, box, beam, _, *bursts = [{"setting": setting} for setting in SETTINGS]
    return [ball, box, beam, *winds, *bursts]


def scene(
    setting: str = "ball",
    temperature: float = 300.0,
    mass: float = HELIUM,
    loss: float = 0.1,
    hole: float = 0.0005,
    accommodation: float = 0.8,
    speed_ratio: float = 0.5,
) -> tp.Scene:
    """One of the settings, of a gas at `temperature` [K] of particles of `mass` [kg].

    loss: chance that a hit on the ball's wall is lost;  hole: the box's, as a share of its walls;  accommodation: share
    of hits on the box's walls that leave at the wall's temperature, the rest is mirrored;  speed_ratio: u/√2 σ of the wind.
    """
    one_of("effusion", setting=(setting, SETTINGS))
    gas = tp.Maxwellian(temperature=temperature, mass=mass)
    match setting:
        case "ball":
            return _ball(gas, loss)
        case "box":
            return _box(gas, SIDE * math.sqrt(6 * hole), accommodation)
        case "beam":
            return _beam(gas)
        case "wind":
            return _wind(gas, math.sqrt(2) * speed_ratio * gas.sigma)
    return _burst(gas, setting)


def _ball(gas: tp.Maxwellian, loss: float) -> tp.Scene:
    ball = tp.Sphere(radius=RADIUS)
    wall = tp.Mixture({tp.Black(): loss, tp.Diffuse(1.0, speed=gas): 1 - loss})
    times = theory.ball_flight_time(RADIUS, gas.sigma) * np.arange(1, LAST + 1)
    source = tp.Source(ball, tp.Gas(DENSITY, gas))
    counted = tp.PhaseSpace(x=(-RADIUS, RADIUS), time=times, name="ball")
    return tp.Scene(source, tp.Surface(ball, wall), counted, duration=times[-1])


def _box(gas: tp.Maxwellian, opening: float, accommodation: float) -> tp.Scene:
    """opening: side of the square hole [m]."""
    box = tp.Box(size=SIDE)
    wall = tp.Mixture({tp.Mirror(): 1 - accommodation, tp.Diffuse(1.0, speed=gas): accommodation})
    times = 4 * box.volume / box.area / theory.mean_speed(gas.sigma) * np.arange(1, LAST + 1)
    hole = tp.Rectangle(center=(SIDE / 2, 0, 0), normal=(-1, 0, 0), width=opening, height=opening)
    detectors = [
        tp.PhaseSpace(x=(-SIDE / 2, SIDE / 2), time=times, within=box, name="box"),
        tp.Detector(hole, "early", times=(0, times[EARLY - 1])),
        tp.Detector(hole, "beam", moments=True),
    ]
    walls = [tp.Surface(face, wall) for face in _faces(box, opening)]
    return tp.Scene(tp.Source(box, tp.Gas(DENSITY, gas)), walls, detectors, duration=times[-1])


def _faces(box: tp.Box, opening: float) -> list[tp.Rectangle]:
    """The faces of the box, the one at +x as a frame of four that leave the hole free."""
    faces = box.faces()
    faces.pop("+x")
    across, along, right = (SIDE + opening) / 4, (SIDE - opening) / 2, {"normal": (1, 0, 0)}
    for sign in (-1, 1):
        bar, post = (SIDE / 2, sign * across, 0), (SIDE / 2, 0, sign * across)
        faces[f"bar {sign}"] = tp.Rectangle(center=bar, width=SIDE, height=along, **right)
        faces[f"post {sign}"] = tp.Rectangle(center=post, width=along, height=opening, **right)
    return list(faces.values())


def _beam(gas: tp.Maxwellian) -> tp.Scene:
    hole, speeds = tp.Disk(radius=RADIUS), SPEEDS * gas.sigma
    detectors = [tp.Detector(hole, "beam", moments=True), tp.Detector(hole, "speeds", speeds=speeds)]
    return tp.Scene(tp.Source(hole, tp.Effusive(DENSITY, gas)), detectors=detectors)


def _wind(gas: tp.Maxwellian, drift: float) -> tp.Scene:
    wind = tp.Maxwellian(temperature=gas.temperature, mass=gas.mass, drift=(0, 0, drift))
    reach = RADIUS / 10  # m, of FASTEST within the duration
    duration, width = reach / (FASTEST * gas.sigma), 2 * (RADIUS + reach)
    box = tp.Box(center=(0, 0, -drift * duration), size=(width, width, 2 * reach))
    patch = tp.Rectangle(normal=(0, 0, -1), width=2 * RADIUS, height=2 * RADIUS)  # faces the wind
    source, meter = tp.Source(box, tp.Gas(DENSITY, wind)), tp.Detector(patch, "wind")
    return tp.Scene(source, detectors=meter, duration=duration)


def _burst(gas: tp.Maxwellian, setting: str) -> tp.Scene:
    """Along ±z, one component of the Maxwellian; or to all sides at its mean speed."""
    edges, along_z = CLOCKS[setting], setting == "flight"
    v = gas.sigma if along_z else theory.mean_speed(gas.sigma)
    burst = tp.Gas(number=NUMBER, speed=gas if along_z else v, direction=(0, 0, 1) if along_z else None)
    plane = tp.Disk(center=(0, 0, DISTANCE), normal=(0, 0, -1), radius=edges[-1] * DISTANCE)
    detector = tp.Detector(plane, setting, times=edges * DISTANCE / v)
    return tp.Scene(tp.Source(tp.Point(), burst), detectors=detector, duration=detector.times[-1])


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    setting = setting_of(result)
    match setting:
        case "ball":
            left = share_left(result)
            return {LEFT.format(t): left[t - 1] for t in SHOWN[setting]}
        case "box":
            left, early = share_left(result), {EARLY_FLUX: result["early"].irradiance[0] / _effusive(result)}
            gone = {GONE.format(t): 1 - left[t - 1] for t in SHOWN[setting]}
            return gone | early | _moments(result, "in")
        case "beam":
            shares = {name: beam_shares(result)[bins].sum() for name, bins in SHARES.items()}
            return {EXITANCE: result["beam"].exitance / _effusive(result)} | _moments(result, "out") | shares
        case "wind":
            wind, unit = result["wind"], _effusive(result) * math.sqrt(2 * math.pi)
            return {ONE_WAY: wind.irradiance / unit, NET: -wind.net_flux_density / unit}
    return {name: arrivals(result)[:last].sum() for name, last in PASSED[setting].items()}


def setting_of(result: tp.Result) -> str:
    """The setting of a run: its first detector has the name."""
    return result.scene.detectors[0].name


def share_left(result: tp.Result) -> tp.EstimateArray:
    """N/N₀ in ball or box after 1, 2, ... flights [1]."""
    setting = setting_of(result)
    number = result[setting].alive if setting == "ball" else result[setting].number.sum("x")
    return number / result.ledger["emitted"]


def beam_shares(result: tp.Result) -> tp.EstimateArray:
    """Share of the beam in each bin of SPEEDS [1]."""
    return result["speeds"].flux_out / result["beam"].flux_out


def arrivals(result: tp.Result) -> tp.EstimateArray:
    """Share of a burst that arrives at the plane in each bin of time [1]."""
    detector = result.scene.detectors[0]
    arrived = result[detector.name].flux_in * np.diff(detector.times) * constant(result, 1.0, "s")
    return arrived / result.ledger["emitted"]


def _effusive(result: tp.Result) -> tp.Estimate:
    """n v̄/4 of the gas."""
    gas = result.scene.sources[0].emission.speed
    sigma = theory.thermal_sigma(gas.temperature, gas.mass)
    return constant(result, theory.effusive_flux_density(DENSITY, sigma), "s^-1 m^-2")


def _moments(result: tp.Result, way: str) -> dict[str, tp.Estimate]:
    beam, gas = result["beam"], result.scene.sources[0].emission.speed
    energy, speed = getattr(beam, f"mean_energy_{way}"), getattr(beam, f"mean_speed_{way}")
    sigma = constant(result, theory.thermal_sigma(gas.temperature, gas.mass), "m s^-1")
    return {ENERGY: energy / constant(result, theory.BOLTZMANN * gas.temperature, "J"), SPEED: speed / sigma}


@of_scene(scene)
def exact(setting: str, loss: float, hole: float, speed_ratio: float) -> dict[str, float]:
    moments = {ENERGY: 2.0, SPEED: theory.mean_speed_of_crossers(1.0)}
    match setting:
        case "ball":
            return {LEFT.format(t): float(theory.ball_survivors(t, loss)) for t in SHOWN[setting]}
        case "box":
            if hole > SMALL:
                return {}
            gone = {t: -math.expm1(-hole * t) for t in (EARLY, *SHOWN[setting])}
            early = {EARLY_FLUX: gone.pop(EARLY) / (hole * EARLY)}
            return {GONE.format(t): share for t, share in gone.items()} | early | moments
        case "beam":
            shares = theory.share_of_crossers(SPEEDS[:-1], SPEEDS[1:], 1.0)
            return {EXITANCE: 1.0} | moments | {name: float(shares[b].sum()) for name, b in SHARES.items()}
        case "wind":
            drift = math.sqrt(2) * speed_ratio
            return {ONE_WAY: float(theory.drifting_flux_density(1.0, 1.0, drift)), NET: drift}
    past = PAST[setting](1.0, CLOCKS[setting], 1.0)
    return {name: float(past[last]) for name, last in PASSED[setting].items()}


SAID = {
    "ball": (LEFT.format(10), "of the gas in a leaky ball {} is left after 10 flights"),
    "box": (GONE.format(30), "by a small hole of a box {} has left after 30"),
    "beam": (ENERGY, "what leaves carries {} kT a particle, and not 3/2"),
    "wind": (ONE_WAY, "of a drifting gas {} n σ cross a plane"),
    "flight": ("past the plane at 1.2 d/σ", "{} of a burst along a line is past the plane at 1.2 d/σ"),
    "burst": ("past the plane at 2.0 d/v", "{} of one to all sides at 2 d/v"),
}


def verdict(outcomes: list[Outcome]) -> str:
    found = grouped(outcomes, "setting")
    return sentence(
        *(words.format(found[s][0][row].estimate) for s, (row, words) in SAID.items() if s in found)
    )


@curves_figure(xlabel="time  [mean flights between hits]", ylabel="share of the gas left, N/N₀", log_y=True)
def draw_ball(outcomes: list[Outcome]) -> dict[str, object]:
    loss = outcomes[0].given["loss"]
    flights, left = np.arange(1, LAST + 1), share_left(outcomes[0].result)
    return {
        "series": (flights, left, lambda t: theory.ball_survivors(t, loss)),
        "guides": {"exp(−f S v̄ t/4V), as of a small hole": lambda t: np.exp(-loss * t)},
        "title": f"A ball of gas whose wall loses {loss:g} of the hits",
    }


@curves_figure(xlabel="time  [mean flights between hits]", ylabel="share of the gas gone, 1 − N/N₀")
def draw_box(outcomes: list[Outcome]) -> dict[str, object]:
    hole = outcomes[0].given["hole"]

    def law(t: np.ndarray) -> np.ndarray:
        return -np.expm1(-hole * t)

    gone = np.arange(1, LAST + 1), 1 - share_left(outcomes[0].result)
    return {
        "series": (*gone, law) if hole <= SMALL else gone,
        "guides": {} if hole <= SMALL else {"1 − exp(−A v̄ t/4V), of a small hole": law},
        "title": f"A gas leaves a box by a hole of {hole:g} of its walls",
    }


@curves_figure(
    xlabel="speed v  [σ]",
    ylabel="share of the beam, per σ",
    title="What leaves is faster than the gas: v³ exp(−v²/2σ²)",
)
def draw_beam(outcomes: list[Outcome]) -> dict[str, object]:
    width, norm = SPEEDS[1] - SPEEDS[0], math.sqrt(2 / math.pi)
    found = beam_shares(outcomes[0].result) / width
    means = theory.share_of_crossers(SPEEDS[:-1], SPEEDS[1:], 1.0) / width
    return {
        "series": (SPEEDS, found, lambda v: v**3 / 2 * np.exp(-(v**2) / 2), means),
        "guides": {"in the gas, v² exp(−v²/2σ²)": lambda v: norm * v**2 * np.exp(-(v**2) / 2)},
    }


@curves_figure(
    xlabel="drift s = u/(√2 σ)",
    ylabel="flux density one way / nσ",
    title="A drifting Maxwellian crosses a plane",
    guides={"without heat: n u": lambda s: math.sqrt(2) * np.maximum(s, 0)},
)
def draw_wind(outcomes: list[Outcome]) -> dict[str, object]:
    ratios, one_way = zip(*((o.given["speed_ratio"], o[ONE_WAY].estimate) for o in outcomes), strict=True)
    return {
        "series": (ratios, one_way, lambda s: theory.drifting_flux_density(1.0, 1.0, math.sqrt(2) * s)),
    }


@curves_figure()
def draw_arrivals(outcomes: list[Outcome]) -> dict[str, object]:
    setting = outcomes[0].given["setting"]
    edges, unit = CLOCKS[setting][1:], {"flight": "d/σ", "burst": "d/v"}[setting]
    found, expected = arrivals(outcomes[0].result)[1:], np.diff(PAST[setting](1.0, edges, 1.0))
    return {
        "series": (edges, found / np.diff(edges), None, expected / np.diff(edges)),
        "xlabel": f"time t  [{unit}]",
        "ylabel": f"share that arrives, per {unit}",
        "title": f"A burst {'along a line' if setting == 'flight' else 'to all sides'} arrives at a plane",
    }


_drawings = (draw_ball, draw_box, draw_beam, draw_wind, draw_arrivals, draw_arrivals)
draw = figures(**{name: (each, where(setting=name)) for name, each in zip(SETTINGS, _drawings, strict=True)})


if __name__ == "__main__":
    main(__file__)
