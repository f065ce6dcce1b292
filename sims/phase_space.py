"""Phase space: position against velocity, measured while a cloud expands, shears and mixes.

A particle is a point in phase space, and n(x, v, t) the number of such points per volume of it (Hanrahan 2001, Stanford
CS 348B, lecture 4, "Particle density").  Here they are counted in bins of x and v_x.

Derivation.  Without forces x = x0 + v t: phase space is sheared, with determinant 1, so that n stays the same along
each trajectory (Liouville 1838).
- A cloud N(0, σ₀) of velocities N(0, σ_v) has the density N(0, σ), σ² = σ₀² + σ_v² t², the mean velocity
  u = x σ_v² t/σ² and the variance σ_v² σ₀²/σ² = k T/m at each place: it cools although nothing collides.
- Its covariance shears, ⟨x²⟩ + 2 t⟨x v⟩ + t²⟨v²⟩ and ⟨x v⟩ + t⟨v²⟩, and ⟨x²⟩⟨v²⟩ - ⟨x v⟩² stays.
- Between mirrors the unfolded flight is free, so that densities are sums over images of the box.  They become uniform,
  while n(x, v, t) winds into filaments: a water bag, n = n0 within and 0 without, never takes a value between.
A bin holds the average over it, and a bin's variance of velocities the spread of u over it as well; all exact values
are such averages.  The moments of the shear come from bins of width h: ⟨x²⟩ from their middles, less h²/12 (Sheppard
1898), which for a normal law is exact but for exp(-2 π² σ²/h²), here below 1e-40.

Scene.  "cloud" and "shear" are in free space, the first in three dimensions, the second in one.  "point", "half" and
"waterbag" fly along x between mirrors at 0 and `length`: from a place at a quarter of it or from its left half, with
normal velocities, or with ones uniform up to `speed`.  There is one particle in all, so that densities are shares.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import constant, curves_figure, figures, main, of_scene, one_of, sentence, sharp, where
from transport.theory import free_flight, phase_mixing
from transport.verification.experiment import Outcome

law = (
    "n(x, v, t) = n(x - v t, v, 0); σ² = σ₀² + σ_v² t², u = x σ_v² t/σ², kT/m = (σ_v σ₀/σ)² (Liouville 1838)"
)
question = (
    "How does a cloud move through phase space, and what of it is seen in density, velocity and temperature?"
)
particles = 8_000_000
intended = {
    "bins": "cells at the edge of a cloud hold few particles; the rows are of cells within it",
}

# In units of `length`, `speed` and length/speed.
CLOUDS = {"cloud": (0.5, 1.2), "shear": (math.sqrt(0.2875), math.sqrt(0.2))}  # σ₀ and σ_v
BOXES = {  # where particles start between the mirrors, and how fast they are
    "point": (0.25, phase_mixing.Normal(1.0)),
    "half": ((0.0, 0.5), phase_mixing.Normal(1.0)),
    "waterbag": ((0.0, 0.5), phase_mixing.Uniform(1.0)),
}
TIMES = {
    "cloud": (0.0, 0.3, 1.0, 5.0),
    "shear": (0.25, 0.75, 2.25),
    "point": (0.1, 0.3, 0.6, 1.0),
    "half": (0.0, 0.1, 0.3, 1.0),
    "waterbag": (0.0, 0.25, 0.5, 2.5),
}
CELLS = {  # of the pictures: edges of positions and of velocities
    "cloud": (np.linspace(-6, 6, 61), np.linspace(-3.6, 3.6, 49)),
    "shear": (np.linspace(-3.05, 3.05, 62), np.linspace(-1.65, 1.65, 34)),
    "point": (np.linspace(0, 1, 51), np.linspace(-3, 3, 61)),
    "half": (np.linspace(0, 1, 51), np.linspace(-3, 3, 61)),
    "waterbag": (np.linspace(0, 1, 51), np.linspace(-1, 1, 41)),
}
SLABS = np.linspace(-3.125, 3.125, 26)  # of the cloud, in standard deviations of its positions at the time
# axes of place and of velocity whose planes are drawn beside that of x and its own, and at which of the times
PLANES, TILTED = (("y", "y"), ("z", "z"), ("x", "y")), 2
TOLD = {"σ/2": 14, "σ": 16, "2σ": 20}  # slabs round these places
GRID = np.linspace(-9.25, 9.25, 75), np.linspace(-3.6, 3.6, 37)  # for the covariance: all of the shear
PATHS = {"a": (0.3, 0.2), "b": (0.5, -0.4)}  # trajectories at the first time: middles of cells
QUARTERS = np.linspace(0, 1, 5), np.array([-9.0, 0.0, 9.0])
WITHIN, OUTSIDE = "n within the bag", "n outside of it"
EMITTANCE = "⟨x²⟩⟨v²⟩ - ⟨x v⟩²"
UNITS = {"⟨x²⟩": "m^2", "⟨x v⟩": "m^2 s^-1", "⟨v²⟩": "m^2 s^-2", EMITTANCE: "m^4 s^-2"}
UNITS |= {f"n in quarter {i}": "m^-1" for i in (1, 2, 3, 4)}  # of sums of numbers
TITLES = {
    "cloud": "A cloud that expands freely",
    "shear": "Free flight shears phase space; the density goes along",
    "point": "From one place, between mirrors",
    "half": "From the left half, between mirrors",
    "waterbag": "A water bag between mirrors winds into filaments",
}
WORDS = {"point": "what starts at one place", "half": "what fills one half", "waterbag": "a water bag"}


def cases() -> list[dict[str, object]]:
    return [{"start": start} for start in TIMES]


def scene(start: str = "cloud", length: float = 1.0, speed: float = 1.0) -> tp.Scene:
    """One of five starts.  length: of the box, the unit of all places [m];  speed: the unit of all velocities [m/s]."""
    one_of("phase_space", start=(start, TIMES))
    times = [t * length / speed for t in TIMES[start]]
    if start == "cloud":
        counters = [
            tp.PhaseSpace(name=f"slabs {k}", x=edges * length, time=times[k], moments=True)
            for k, edges in enumerate(map(_slabs, TIMES[start]))
        ]
        x, v = CELLS[start]
        for place, velocity in PLANES:
            edges = {place: x * length, f"v{velocity}": v * speed}
            counters.append(tp.PhaseSpace(name=f"plane of {place}, v{velocity}", time=times[TILTED], **edges))
    else:
        x, v = GRID if start == "shear" else QUARTERS
        counters = [tp.PhaseSpace(name="all", x=x * length, vx=v * speed, time=times)]
    x, v = CELLS[start]
    return tp.Scene(
        sources=_source(start, length, speed),
        surfaces=_mirrors(length) if start in BOXES else [],
        detectors=[tp.PhaseSpace(name=start, x=x * length, vx=v * speed, time=times), *counters],
        duration=times[-1],
    )


def _source(start: str, length: float, speed: float) -> tp.Source:
    if start in CLOUDS:
        s0, sv = CLOUDS[start][0] * length, CLOUDS[start][1] * speed
        in_three = start == "cloud"
        gas = tp.Gas(number=1.0, speed=tp.Maxwellian(sigma=sv), direction=None if in_three else (1, 0, 0))
        return tp.Source(tp.Cloud(sigma=s0 if in_three else (s0, 0, 0)), gas)
    uniform, normal = tp.SpeedTable(speeds=[-speed, speed], density=[1, 1]), tp.Maxwellian(sigma=speed)
    gas = tp.Gas(number=1.0, speed=uniform if start == "waterbag" else normal, direction=(1, 0, 0))
    if start == "point":
        return tp.Source(tp.Point(position=(BOXES[start][0] * length, 0, 0)), gas)
    low, high = BOXES[start][0]
    middle, size = (low + high) / 2 * length, ((high - low) * length, 0.5 * length, 0.5 * length)
    return tp.Source(tp.Box(center=(middle, 0, 0), size=size), gas)


def _mirrors(length: float) -> list[tp.Surface]:
    """Two that face each other; particles fly straight between them."""
    ends = [
        tp.Rectangle(center=(x, 0, 0), normal=(1, 0, 0), width=length, height=length) for x in (0, length)
    ]
    return [tp.Surface(end, tp.Mirror()) for end in ends]


def _slabs(t: float) -> np.ndarray:
    return SLABS * free_flight.width(t, *CLOUDS["cloud"])


# What is counted, and what should be: the rows are read off both in the same way.


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    start, length, speed = setting(result)
    rows = {}
    for k, time in enumerate(_names(start, length, speed)):
        found = {"picture": result[start].density[k]}
        if start == "cloud":
            slabs = result[f"slabs {k}"]
            found |= {"n": slabs.density, "u": slabs.mean_vx, "kT/m": slabs.variance_vx}
        else:
            found["number"] = result["all"].number[k]
        for name, value in _read(start, k, length, speed, found).items():
            rows[f"{name}, {time}"] = value * constant(result, 1.0, UNITS.get(name, "1"))
        if (outside := f"{OUTSIDE}, {time}") in rows:
            rows[outside] = sharp(rows[outside], of=rows[f"{WITHIN}, {time}"])
    return rows


@of_scene(scene)
def exact(start: str, length: float, speed: float) -> dict[str, float]:
    rows = {}
    for k, time in enumerate(_names(start, length, speed)):
        read = _read(start, k, length, speed, expected(start, k, length, speed))
        rows |= {f"{name}, {time}": float(value) for name, value in read.items()}
    return rows


def setting(result: tp.Result) -> tuple[str, float, float]:
    """Start, length [m] and speed [m/s] of a run."""
    picture = result.scene.detectors[0]
    x, v = CELLS[picture.name]
    return picture.name, picture.x[-1] / x[-1], picture.vx[-1] / v[-1]


def expected(start: str, k: int, length: float = 1.0, speed: float = 1.0) -> dict[str, np.ndarray]:
    """What a run without noise counts at the k-th time, in SI: bin averages, shares of the particles, moments."""
    t = TIMES[start][k]

    def shares(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        if start in BOXES:
            return phase_mixing.bin_shares(x, t, *BOXES[start], v_edges=v)
        return free_flight.cell_shares(x, v, t, *CLOUDS[start])

    x, v = CELLS[start]
    found = {"picture": shares(x, v) / np.outer(np.diff(x), np.diff(v)) / (length * speed)}
    if start != "cloud":
        return found | {"number": shares(*(GRID if start == "shear" else QUARTERS))}
    slabs, cloud = _slabs(t), (t, *CLOUDS[start])
    return found | {
        "n": free_flight.bin_shares(slabs, *cloud) / np.diff(slabs) / length,
        "u": free_flight.bin_mean_velocities(slabs, *cloud) * speed,
        "kT/m": free_flight.bin_velocity_variances(slabs, *cloud) * speed**2,
    }


def _names(start: str, length: float, speed: float) -> list[str]:
    return [f"t = {t * length / speed:.4g} s" for t in TIMES[start]]


def _read(start: str, k: int, length: float, speed: float, found: dict) -> dict:
    """The rows of the k-th time from counted or from expected arrays."""
    if start == "cloud":
        return {f"{q} at x = {place}": found[q][i] for q in ("n", "u", "kT/m") for place, i in TOLD.items()}
    if start == "shear":
        seen = found["picture"]
        paths = {
            f"n along path {path}": (seen[i, j] + seen[-1 - i, -1 - j]) / 2
            for path, (i, j) in _cells_of_paths(k).items()
        }
        return _moments(found["number"], GRID[0] * length, GRID[1] * speed) | paths
    width, shares = length * np.diff(QUARTERS[0]), found["number"]
    seen = expected(start, k)["number"].sum(axis=1) > 0.01
    rows = {f"n in quarter {i + 1}": (shares[i, 0] + shares[i, 1]) / width[i] for i in np.flatnonzero(seen)}
    rows["share in the left half flying right"] = shares[0, 1] + shares[1, 1]
    if start == "waterbag" and TIMES[start][k] > 0:
        bag = expected(start, k)["picture"]
        within, without = (bag > 1 - 1e-9).astype(float), (bag == 0).astype(float)
        rows[WITHIN] = (found["picture"] * within).sum() / within.sum()
        rows[OUTSIDE] = (found["picture"] * without).sum() / without.sum()
    return rows


def _moments(number: object, x_edges: np.ndarray, v_edges: np.ndarray) -> dict:
    """Second moments from the middles of bins, less Sheppard's h²/12, and the emittance squared."""
    x, v = ((edges[1:] + edges[:-1]) / 2 for edges in (x_edges, v_edges))
    widths = x[1] - x[0], v[1] - v[0]
    xx = (number * (x**2 - widths[0] ** 2 / 12)[:, None]).sum()
    vv = (number * (v**2 - widths[1] ** 2 / 12)).sum()
    xv = (number * np.outer(x, v)).sum()
    return {"⟨x²⟩": xx, "⟨x v⟩": xv, "⟨v²⟩": vv, EMITTANCE: xx * vv - xv**2}


def _paths(k: int) -> dict[str, tuple[float, float]]:
    """Position and velocity on the trajectories at the k-th time."""
    elapsed = TIMES["shear"][k] - TIMES["shear"][0]
    return {path: (x + v * elapsed, v) for path, (x, v) in PATHS.items()}


def _cells_of_paths(k: int) -> dict[str, tuple[int, int]]:
    """The cells of the picture in which the trajectories are then; (-x, -v) has the same density."""
    edges = CELLS["shear"]
    return {
        path: tuple(int(np.searchsorted(along, at)) - 1 for along, at in zip(edges, place, strict=True))
        for path, place in _paths(k).items()
    }


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in outcomes:
        start, length, speed = setting(outcome.result)
        names = _names(start, length, speed)
        if start == "cloud":
            left = _kept(outcome, "kT/m at x = σ", names)
            said.append(f"by {names[-1]} a free cloud has cooled at each place to {left} of its temperature")
        elif start == "shear":
            kept = [_kept(outcome, name, names) for name in (EMITTANCE, "n along path a", "n along path b")]
            said.append(f"of its squared area in phase space a sheared one keeps {kept[0]}")
            said.append(f"of its density along two paths, in bins of finite size, {kept[1]} and {kept[2]}")
        else:
            density = [row.estimate.value * length for row in outcome.rows if "n in quarter" in row.name]
            spread = max(abs(n - 1) for n in density[-4:])
            said.append(f"{WORDS[start]} is within {spread:.2g} of uniform at {names[-1]}")
            if start == "waterbag":
                within = outcome[f"{WITHIN}, {names[-1]}"].estimate * length * speed
                said.append(
                    f"but n is {within.value:.4f} ± {within.error:.4f} in its filaments and 0 without"
                )
    return sentence(*said)


def _kept(outcome: Outcome, quantity: str, names: list[str]) -> str:
    """The last value over the first, with its error."""
    first, last = (outcome[f"{quantity}, {name}"].estimate for name in (names[0], names[-1]))
    ratio = last / first
    return f"{ratio.value:.4f} ± {ratio.error:.4f}"


def draw_portrait(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Position against velocity in time."""
    from transport.viz.phase_space import phase_portraits

    start, length, speed = (outcomes[0].given[name] for name in ("start", "length", "speed"))
    names, density = _names(start, length, speed), outcomes[0].result[start].density
    phase_portraits(
        {name: density[k] for k, name in enumerate(names)},
        path,
        exact={n: expected(start, k, length, speed)["picture"] for k, n in enumerate(names)},
        contours=_contours(start, length, speed, names) if start in CLOUDS else None,
        marks=_marks(length, speed, names) if start == "shear" else None,
        power=0.5 if start in ("cloud", "point") else 1.0,
        title=TITLES[start],
        note=note,
    )


def draw_planes(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Planes of the cloud's six dimensions at one time: each axis with its own velocity, and one with another's."""
    from transport.viz.phase_space import phase_portraits

    result = outcomes[0].result
    length, speed = outcomes[0].given["length"], outcomes[0].given["speed"]
    names = _names("cloud", length, speed)
    time = names[TILTED]
    panels = {"x and v$_x$": result["cloud"].density[TILTED]}
    panels |= {f"{x} and v$_{v}$": result[f"plane of {x}, v{v}"].density for x, v in PLANES}
    own = _contours("cloud", length, speed, names)[time]
    phase_portraits(
        panels,
        path,
        contours={words: _unsheared(length, speed) if words == list(panels)[-1] else own for words in panels},
        power=0.5,
        xlabel="position  [m]",
        ylabel="velocity  [m/s]",
        title=f"3 + 3 dimensions, {time}: flight shears each place with its own velocity alone",
        note=note,
    )


def _unsheared(length: float, speed: float) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """The exact density of the cloud by position along one axis and velocity along another."""
    of_v = CLOUDS["cloud"][1] * speed
    of_x = free_flight.width(TIMES["cloud"][TILTED], *CLOUDS["cloud"]) * length
    return lambda x, v: np.exp(-((x / of_x) ** 2 + (v / of_v) ** 2) / 2) / (2 * math.pi * of_x * of_v)


@curves_figure(xlabel="position x  [m]", ylabel="mean velocity")
def draw_velocity(outcomes: list[Outcome]) -> dict[str, object]:
    """The mean velocity of the cloud by place."""
    length, speed, t = outcomes[0].given["length"], outcomes[0].given["speed"], TIMES["cloud"][1]
    found, means = outcomes[0].result["slabs 1"].mean_vx, expected("cloud", 1, length, speed)["u"]
    time = t * length / speed
    return {
        "series": (_slabs(t) * length, found, None, means),
        "guides": {"x / t, as from a point": lambda x: x / time},
        "title": rf"A free cloud sorts its velocities: $u = x\,\sigma_v^2 t/\sigma^2$ at t = {time:.4g} s",
    }


def _contours(start: str, length: float, speed: float, names: list[str]) -> dict:
    """The exact density in phase space as functions of position and velocity."""
    times = [t * length / speed for t in TIMES[start]]
    cloud = CLOUDS[start][0] * length, CLOUDS[start][1] * speed
    return {
        name: lambda x, v, t=t: free_flight.phase_density(x, v, t, *cloud)
        for name, t in zip(names, times, strict=True)
    }


def _marks(length: float, speed: float, names: list[str]) -> dict:
    """Where the two trajectories are."""
    return {
        name: {path: (x * length, v * speed) for path, (x, v) in _paths(k).items()}
        for k, name in enumerate(names)
    }


_portraits = {start: (draw_portrait, where(start=start)) for start in TIMES}
draw = figures(
    **_portraits, velocity=(draw_velocity, where(start="cloud")), planes=(draw_planes, where(start="cloud"))
)


if __name__ == "__main__":
    main(__file__)
