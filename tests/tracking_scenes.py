"""Slabs, and the ways to follow histories through them, that tests of tracking share; runs have seed 1 and must close."""

from __future__ import annotations

import math

import pytest

import transport as tp

FALSE_ALARM = 1e-5
CLEAR = tp.Transparent()
R, T = 0.0973946386719247, 0.6609577001638116  # E.vandehulst_hg: tau 2, albedo 0.9, g 0.75, normal beam
DOWN = {"start": (0, 0, 0), "end": (0, 0, -1)}


def splitting(gain, **way):
    return tp.Splitting(**(DOWN | way), gain=gain)


TRACKINGS = {
    "analog": tp.Tracking(absorption="analog"),
    "weighted": tp.Tracking(),
    "roulette 0.05": tp.Tracking(roulette=0.05),
    "roulette 1": tp.Tracking(roulette=1.0),
    "forced": tp.Tracking(forced=True),
    "analog, forced": tp.Tracking(absorption="analog", forced=True),
    "split": tp.Tracking(splitting=splitting(10)),
    "split upwards": tp.Tracking(splitting=splitting(10, start=(0, 0, -1), end=(0, 0, 0))),
    "split aside": tp.Tracking(splitting=splitting(30, end=(1, 0.2, 0.3))),
    "analog, split": tp.Tracking(absorption="analog", splitting=splitting(10)),
}


def slab(tau, albedo, g=0.0, mu0=1.0):
    """A slab one metre thick below z = 0 under a pencil beam of 1 W, with a meter on each face."""
    phase = tp.HenyeyGreenstein(g) if g else tp.Isotropic()
    fog = tp.Medium(absorption=(1 - albedo) * tau, scattering=albedo * tau, phase=phase)
    sine = math.sqrt((1 - mu0) * (1 + mu0))
    beam = tp.Source(tp.Point(position=(-sine / mu0, 0, 1)), tp.Beam((sine, 0, -mu0), power=1.0))
    faces = [
        tp.Detector(tp.Plane(), "top"),
        tp.Detector(tp.Plane(center=(0, 0, -1), normal=(0, 0, -1)), "bottom"),
    ]
    body = tp.Slab(center=(0, 0, -0.5), thickness=1.0)
    return tp.Scene(beam, tp.Surface(body, CLEAR, "slab", inside=fog), faces)


def run(scene, tracking=None, particles=100_000):
    result = tp.simulate(scene, particles, seed=1, threads=1, tracking=tracking, progress=False)
    assert_closed(result)
    return result


def assert_closed(result):
    """Batch by batch all that was emitted is somewhere, and nothing is lost."""
    ledger = result.ledger
    parts = sum(ledger[name] for name in ledger if name != "emitted")
    assert (parts - ledger["emitted"]).value == pytest.approx(0, abs=1e-14 * ledger["emitted"].value)
    assert ledger["lost"].value == 0
