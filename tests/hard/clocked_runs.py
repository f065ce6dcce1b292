"""Runs with a clock, and what they count as whole numbers."""

from __future__ import annotations

import numpy as np

import transport as tp
from transport.results.tally import ARRIVALS, DEPARTURES, SIDES  # noqa: F401


def run(scene, particles=10_000, **options):
    return tp.simulate(scene, particles=particles, seed=1, progress=False, **options)


def counts(reading, side=ARRIVALS):
    return reading.counts_of(f"weight {SIDES[side]}").sum(axis=0)


def histories(result, value):
    """Numbers of histories from numbers of particles."""
    found = np.asarray(value) * result.particles / result.ledger["emitted"].value
    np.testing.assert_allclose(found, np.rint(found), rtol=0, atol=1e-5)
    return np.rint(found).astype(int)


def mirrored_box(size=2.0):
    return tp.Surface(tp.Box(size=size), tp.Mirror(), "walls")
