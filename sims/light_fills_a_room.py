"""Light fills a room: how much energy is in it, and how long that takes after the lamp is switched on.

Derivation.  A closed sphere of radius a has a white wall of albedo ρ; a lamp of power Φ is switched on at t = 0.  Light is so
fast that power and energy are almost the same thing (Hanrahan 2001, Stanford CS 348B, lecture 4): what is in the room is what
the lamp emits within tens of nanoseconds.  A diffuse wall sends its light evenly to the whole wall of a sphere, whatever the
place, so that flights are independent.  Their lengths are chords of the density ℓ/2a² up to 2a, whose mean is 4V/S = 4a/3
(Cauchy; Case and Zweifel 1967).  A photon is alive in its (n + 1)-th flight with the weight ρⁿ.  Summed over n,

    W = Φ/c (first + ρ/(1 − ρ) 4V/S),    the mean of the first flight: 4V/S where the wall itself glows, a for a small lamp in
                                         the middle: with a glowing wall W = Φ (4V/S)/(c (1 − ρ)), exactly.

With the clock W(t) = Φ ∫₀ᵗ S(τ) dτ, where S(τ) is the mean weight of a photon at the age τ.  In units of a/c a glowing wall has
S(x) = 1 − F(x) + ρ ∫ f(y) S(x − y) dy with f(y) = y/2 up to 2 (a renewal equation; Feller 1971, XI).  Until the longest flight
ends, x ≤ 2, its derivative is S″ = −1/2 + ρ S/2 with S(0) = 1 and S′(0) = 0, so that

    S(x) = (1 − (1 − ρ) cosh(x √(ρ/2)))/ρ,    W = Φ a/c (x − (1 − ρ) √(2/ρ) sinh(x √(ρ/2)))/ρ;    ρ = 0: Φ a/c (x − x³/12).

After that S(x) = ρ/2 ∫ (x − u) S(u) du over the last longest flight, x − 2 < u < x, which is solved on one interval of the
length 2 after the other, as Chebyshev series to 1e-13.  When the lamp is switched off after t₀, W(t) = Φ (∫₀ᵗ S − ∫₀^(t − t₀) S): it is dark as fast as it was light.

Scene.  A sphere of 3 m, whose mean flight takes 13 ns.  The energy in the room is that of all particles alive at an instant; and,
without a clock, ∫ φ/c dV of a volume detector: the same number from the fluence rate.
"""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.polynomial import chebyshev

import transport as tp
from transport.sims import constant, figures, furthest, main, of_scene, one_of, require, sentence, where
from transport.verification.experiment import Outcome

law = "W = Φ (4V/S)/(c (1 − ρ)): energy = power × the time that light stays (Hanrahan 2001, Stanford CS 348B, lecture 4)"
question = "A lamp is switched on in a closed white room: how much light is in it, and how soon?"
particles = 1_000_000

RADIUS = 3.0  # m
FLIGHT = 4 * RADIUS / (3 * tp.speed_of_light)  # s, of the mean chord
CROSSING = RADIUS / tp.speed_of_light  # s, the unit of ages
ROWS = (0.5, 1.0, 1.4, 3.0, 6.0, 12.0)  # mean flights after which W is a row
LAMPS = ("glowing wall", "bulb in the middle")
CURVE = 24  # instants between rows, for the picture
TERMS = 24  # of a Chebyshev series
MICRO = 1e6  # of a joule
SHINING = 0.5  # of the clock that a lamp is on which is switched off


def cases() -> list[dict[str, object]]:
    walls = [{"albedo": albedo} for albedo in (0.0, 0.5, 0.9)]
    steady = [{"albedo": albedo, "clock": "none"} for albedo in (0.5, 0.9)]
    return [*walls, *steady, {"clock": "none", "lamp": LAMPS[1]}, {"clock": "on and off"}]


def scene(
    albedo: float = 0.7, clock: str = "on", lamp: str = LAMPS[0], power: float = 40.0, flights: float = 12.0
) -> tp.Scene:
    """A lamp of `power` [W] in a closed sphere of that albedo.

    clock: "on", the lamp is switched on at 0; "on and off", off again in the middle; "none", it has always been on;  flights:
    mean flights that the clock runs;  lamp: a glowing wall, or a bulb in the middle, which has no clock.
    """
    one_of("light_fills_a_room", clock=(clock, ("on", "on and off", "none")), lamp=(lamp, LAMPS))
    require("light_fills_a_room", albedo=(albedo, 0 <= albedo < 1, "0 or more and below 1"))
    must = "one without a clock: clock='none'"
    require("light_fills_a_room", lamp=(lamp, lamp == LAMPS[0] or clock == "none", must))
    wall = tp.Surface(tp.Sphere(radius=RADIUS), tp.Diffuse(albedo), "wall")
    if lamp == LAMPS[0]:
        shape, emission, side = "wall", tp.Lambertian(power=power), "inside"
    else:
        shape, emission, side = tp.Point(), tp.Isotropic(power=power), "front"
    if clock == "none":
        room = tp.VolumeDetector(tp.Sphere(radius=RADIUS), "room")
        return tp.Scene(tp.Source(shape, emission, side=side), surfaces=wall, detectors=room)
    times = instants(flights)
    duration = times[-1]
    pulse = tp.BoxPulse(0.0, SHINING * duration) if clock == "on and off" else None
    everyone = tp.PhaseSpace(x=(-RADIUS, RADIUS), time=times, name="room")
    source = tp.Source(shape, emission, side=side, pulse=pulse)
    return tp.Scene(source, surfaces=wall, detectors=everyone, duration=duration)


def instants(flights: float) -> tuple[float, ...]:
    """Times at which the energy is read [s]: evenly, and those of the rows."""
    even = np.linspace(0, flights, CURVE + 1)[1:]
    return tuple(FLIGHT * np.unique([*even, *(each for each in ROWS if each < flights)]))


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    room = result["room"]
    if result.scene.duration is None:
        volume, speed = 4 * math.pi * RADIUS**3 / 3, tp.speed_of_light
        energy = room.fluence_rate * constant(result, volume / speed, "m^2 s")
        return {STEADY: energy, STAYING: energy / result.ledger["emitted"]}
    alive, times = room.alive, result.scene.detectors[0].time
    return {_row(t): alive[k] for k, t in enumerate(times) if _is_row(t)}


STEADY, STAYING = "energy in the room", "energy / power"


def _is_row(time: float) -> bool:
    return bool(np.isclose(time / FLIGHT, ROWS, rtol=1e-9).any())


def _row(time: float) -> str:
    return f"energy after {time / tp.ns:.3g} ns"


@of_scene(scene)
def exact(albedo: float, clock: str, lamp: str, power: float, flights: float) -> dict[str, float]:
    if clock == "none":
        first = FLIGHT if lamp == LAMPS[0] else CROSSING
        staying = first + albedo / (1 - albedo) * FLIGHT
        return {STEADY: power * staying, STAYING: staying}
    times = instants(flights)
    energies = energy(
        np.array(times), albedo, power, SHINING * times[-1] if clock == "on and off" else math.inf
    )
    return {_row(t): float(w) for t, w in zip(times, energies, strict=True) if _is_row(t)}


def energy(times: np.ndarray, albedo: float, power: float, off: float = math.inf) -> np.ndarray:
    """Energy in the room with a glowing wall, which is switched off at the time `off` [J]."""
    since = [np.maximum(np.asarray(times) - start, 0.0) / CROSSING for start in (0.0, off)]
    return power * CROSSING * (stay(since[0], albedo) - stay(since[1], albedo))


def stay(ages: np.ndarray, albedo: float) -> np.ndarray:
    """∫ S up to the ages [a/c], of photons of a glowing wall."""
    ages = np.asarray(ages, dtype=float)
    early = np.minimum(ages, 2.0)
    if albedo == 0:
        return early - early**3 / 12
    root = math.sqrt(albedo / 2)
    until = (early - (1 - albedo) / root * np.sinh(early * root)) / albedo
    if ages.max(initial=0.0) <= 2:
        return until
    found = until
    for piece, series in enumerate(_pieces(albedo, math.ceil(ages.max() / 2))[1:], 1):
        within = np.clip(ages - 2 * piece, 0.0, 2.0) - 1
        found = found + chebyshev.chebval(within, chebyshev.chebint(series, lbnd=-1))
    return found


@lru_cache(maxsize=32)
def _pieces(albedo: float, count: int) -> list[np.ndarray]:
    """S on the intervals (0, 2), (2, 4) ... of the age, as Chebyshev series of t from -1 to 1."""
    root, nodes = math.sqrt(albedo / 2), chebyshev.chebpts1(TERMS)
    basis, unit = chebyshev.chebvander(nodes, TERMS - 1), np.eye(TERMS)
    twice = np.array([chebyshev.chebval(nodes, chebyshev.chebint(e, m=2, lbnd=-1)) for e in unit]).T
    start = (1 - (1 - albedo) * np.cosh(root * (nodes + 1))) / albedo
    pieces = [np.linalg.solve(basis, start)]
    for _ in range(count - 1):
        last = pieces[-1]
        once = chebyshev.chebint(last)
        moment = chebyshev.chebint(chebyshev.chebmulx(last))
        left, right = (
            chebyshev.chebval(1.0, each) - chebyshev.chebval(nodes, each) for each in (once, moment)
        )
        known = (nodes + 2) * left - right  # of the flights that began in the last interval
        pieces.append(np.linalg.solve(basis - albedo / 2 * twice, albedo / 2 * known))
    return pieces


# ---- answer and pictures ----


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in outcomes:
        of, last = outcome.given, outcome.rows[-1]
        energy = outcome.rows[0].estimate if of["clock"] == "none" else last.estimate
        words = "always on" if of["clock"] == "none" else last.name.removeprefix("energy ")
        if of["clock"] == "on and off":
            words += ", the lamp off again"
        said.append(f"albedo {of['albedo']:g}, {words}: {energy} of a lamp of {of['power']:g} W")
    return sentence(*said, furthest(outcomes))


def draw_rise(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Energy in the room by time, for each albedo, with what it tends to and what the lamp has emitted."""
    from transport.viz.style import INK, MUTED, figure, look

    power = outcomes[0].given["power"]
    longest = max(o.result.scene.duration for o in outcomes)
    fine = np.linspace(0, longest, 600)
    with figure(
        (13, 9), "A lamp is switched on: the room is full of light within tens of ns", note, path
    ) as page:
        axes = page.subplots()
        top = max(power * FLIGHT / (1 - o.given["albedo"]) for o in outcomes)
        axes.plot(
            fine / tp.ns,
            MICRO * power * fine,
            ":",
            color=MUTED,
            lw=3,
            label="emitted, Φ t: if nothing were absorbed",
        )
        for rank, outcome in enumerate(outcomes):
            albedo, (colour, marker) = outcome.given["albedo"], look(rank)
            limit = MICRO * power * FLIGHT / (1 - albedo)
            times = np.array(outcome.result.scene.detectors[0].time)
            alive = outcome.result["room"].alive
            axes.plot(fine / tp.ns, MICRO * energy(fine, albedo, power), color=colour, lw=3)
            axes.errorbar(
                times / tp.ns, MICRO * alive.value, MICRO * alive.error, fmt=marker, color=colour, ms=9, mec="white",
                label=f"albedo {albedo:g}: tends to {limit:.3g} μJ",
            )  # fmt: skip
            axes.axhline(limit, color=colour, lw=2, ls="--")
        axes.axhline(0, color=INK, lw=1)
        axes.set(
            xlabel="time since the lamp was switched on  [ns]",
            ylabel=r"energy in the room W  [$\mathrm{\mu J}$]",
        )
        axes.set(xlim=(0, longest / tp.ns), ylim=(0, 1.45 * MICRO * top))
        axes.legend(loc="upper right")


def draw_off(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The room and its mean flight; and the energy while the lamp is on, and after."""
    from matplotlib.patches import Circle

    from transport.viz.style import BLUE, INK, MUTED, ORANGE, VERMILLION, figure

    outcome = outcomes[0]
    albedo, power, scene = outcome.given["albedo"], outcome.given["power"], outcome.result.scene
    off, fine = SHINING * scene.duration, np.linspace(0, scene.duration, 600)
    with figure(
        (16, 8.2), "Power and energy are almost the same thing: light stays for ns only", note, path
    ) as page:
        left, right = page.subplots(1, 2, gridspec_kw={"width_ratios": (1, 1.6)})
        left.add_patch(Circle((0, 0), RADIUS, fc="#fff7e0", ec=ORANGE, lw=8))
        corners = RADIUS * np.exp(1j * np.radians([200, 20, 265, 120, 320]))
        for k, (a, b) in enumerate(zip(corners[:-1], corners[1:], strict=True)):
            arrow = {
                "arrowstyle": "-|>",
                "lw": 5 * albedo**k,
                "color": VERMILLION,
                "shrinkA": 3,
                "shrinkB": 5,
            }
            left.annotate("", (b.real, b.imag), (a.real, a.imag), arrowprops=arrow)
        left.set(aspect="equal", xlim=(-3.4, 3.4), ylim=(-3.4, 3.4), xlabel="x  [m]", ylabel="y  [m]")
        left.set_title(f"each flight {FLIGHT / tp.ns:.3g} ns, then albedo {albedo:g}", fontsize=18)
        left.grid(False)
        alive, times = outcome.result["room"].alive, np.array(scene.detectors[0].time)
        right.axvspan(0, off / tp.ns, color="#fff3cc", lw=0, zorder=0)
        right.text(off / tp.ns / 2, 1.22 * MICRO * power * FLIGHT / (1 - albedo), "lamp on", ha="center")
        right.plot(fine / tp.ns, MICRO * energy(fine, albedo, power, off), color=BLUE, lw=3, label="exact")
        right.errorbar(
            times / tp.ns, MICRO * alive.value, MICRO * alive.error, fmt="o", color=BLUE, ms=9, mec="white"
        )
        once = MICRO * power * FLIGHT * (fine < off)
        right.plot(
            fine / tp.ns, once, "--", color=MUTED, lw=2.5, label="if no light were reflected, and at once"
        )
        limit = MICRO * power * FLIGHT / (1 - albedo)
        right.axhline(limit, color=INK, lw=2, ls=":", label=f"Φ (4V/S)/(c (1 − ρ)) = {limit:.3g} μJ")
        right.set(
            xlabel="time t  [ns]",
            ylabel=r"energy in the room W  [$\mathrm{\mu J}$]",
            xlim=(0, scene.duration / tp.ns),
        )
        right.set_ylim(0, 1.75 * limit)
        right.legend(loc="upper right")


draw = figures(
    rise=(draw_rise, where(clock="on", lamp=LAMPS[0])),
    off=(draw_off, where(clock="on and off")),
)


if __name__ == "__main__":
    main(__file__)
