"""Vessels of gas, and what phase space counts in them as numbers of histories."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

import transport as tp
from transport.results.tally import ARRIVALS, DEPARTURES, SIDES  # noqa: F401

FALSE_ALARM = 1e-6
DURATION = 4.0
TIMES = (0.0, 0.5, 1.25, 2.0, 3.3, 4.0)
HOT = tp.Maxwellian(sigma=1.5, mass=3.0)
WIND = tp.Maxwellian(sigma=0.7, mass=3.0, drift=(0.4, -0.3, 0.2))


def faces_with(*kinds):
    """The walls of a box of 2 m."""
    faces = tp.Box(size=2.0).faces()
    return [tp.Surface(face, kind, n) for (n, face), kind in zip(faces.items(), kinds, strict=True)]


def vessel(walls, looks):
    """Gases, a steady effusive source and a pulse; two of them on walls, all particles of one weight."""
    sources = [
        tp.Source(tp.Cloud(sigma=0.2), tp.Gas(number=3.0, speed=WIND)),
        tp.Source(tp.Box(size=(1.0, 0.5, 2.0)), tp.Gas(number=2.0, speed=0.8, mass=3.0)),
        tp.Source(tp.Sphere(radius=0.5), tp.Gas(number=1.0, speed=0.0, mass=3.0)),
        tp.Source("-z", tp.Effusive(number=4.0, speed=HOT), side="back"),
        tp.Source("+z", tp.Effusive(number=2.0, speed=0.5, mass=3.0), side="back", pulse=tp.BoxPulse(1.0, 2.0)),
    ]  # fmt: skip
    return tp.Scene(sources, walls, looks, duration=DURATION)


PICTURES = [
    tp.PhaseSpace(x=(-1.0, -0.3, 0.2, 0.9), vx=(-2.0, 0.0, 0.5, 3.0), time=TIMES, name="x vx"),
    tp.PhaseSpace(z=(-0.5, 0.0, 1.0), time=TIMES, name="z"),
    tp.PhaseSpace(speed=(0.0, 1e-3, 0.6, 1.0, 3.0), mu=(-1.0, -0.2, 0.9), time=TIMES, name="speed mu"),
    tp.PhaseSpace(
        vy=(-1.0, 0.0, 1.0), vz=(-9.0, 9.0), time=TIMES, name="part", within=tp.Box(size=(1, 2, 0.7)), moments=True
    ),
]  # fmt: skip
TALLIES = [
    tp.Detector(n, f"{n} in time", side="back", times=TIMES) for n in ("-x", "+x", "-y", "+y", "-z", "+z")
]
SPLITTING = tp.Mixture({tp.Black(): 0.5, tp.Diffuse(1.0, speed=HOT): 0.3, tp.Mirror(): 0.2})
KINDS = (tp.Mirror(), tp.Black(), SPLITTING, tp.Diffuse(1.0, speed=HOT), tp.Black(), tp.Black())


@lru_cache(maxsize=1)
def kept():
    """A vessel in which weights stay whole: what reaches a wall goes on, or ends."""
    return tp.simulate(vessel(faces_with(*KINDS), [*PICTURES, *TALLIES]), particles=120_000, seed=1)


def histories(result, value):
    """Numbers of histories from numbers of particles."""
    counts = np.asarray(value) * result.particles / result.ledger["emitted"].value
    np.testing.assert_allclose(counts, np.rint(counts), rtol=0, atol=1e-5)
    return np.rint(counts).astype(int)


def rows(result, name):
    """Histories of a picture, (times, 1 + bins), summed over batches."""
    first, bins = result.plan.rows_of[name].first, result[name].number[0].value.size
    found = [b.counts[first : first + len(TIMES) * (1 + bins)] for b in result.batches]
    return np.sum(found, axis=0).reshape(len(TIMES), 1 + bins)


def wall_histories(result, side):
    """Histories that arrived at or left each wall before each of the times, (walls, times)."""
    each = [result[look.name].counts_of(f"weight {SIDES[side]}").sum(axis=0) for look in TALLIES]
    return np.array([np.concatenate([[0], np.cumsum(counts)]) for counts in each])


def streaming(looks, walls=(), speed=WIND):
    return tp.Scene(
        tp.Source(tp.Box(size=1.5), tp.Gas(number=6.0, speed=speed)), walls, looks, duration=DURATION
    )


def run_alone(source, shot):
    """The whole sample of a source by itself."""
    return tp.simulate(tp.Scene(source, [], shot, duration=1.0), particles=200_000, seed=1)["snapshot"]
