"""Milk: reflectance and fluence with depth meet discrete ordinates; other laws are rejected.

Each statistical judgement fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from transport.sims import milk
from transport.sims.milk import ABSORBED, DIFFUSE, LOWER, SPECULAR, UPPER
from transport.theory.turbid import Diffusion

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
MILD = {"scattering": 1e3, "absorption": 100.0}


def medium(**changed):
    return milk.scene(**MILD | changed).surfaces[0].inside


SOLVED = milk.solution(medium())


def run(particles, **parameters):
    return tp.simulate(milk.scene(**parameters), particles=particles, seed=1, threads=1)


@pytest.fixture(scope="module")
def mild():
    return run(500_000, **MILD)


@pytest.mark.parametrize(
    ("particles", "parameters"),
    [
        (30_000, {"absorption": 100.0}),
        (100_000, {"scattering": 30.0, "index": 1.0, "g": 0.8}),
        (100_000, {"scattering": 90.0, "index": 1.5, "g": 0.0}),
        (100_000, {"scattering": 20.0, "g": -0.5}),
        (100_000, {"scattering": 1e9, "absorption": 1e8}),  # layers of nanometres
        (100_000, {"scattering": 1e-15, "absorption": 1e-15}),  # of light years
    ],
)
def test_rows_are_met(particles, parameters):
    result = run(particles, **parameters)
    rows, exact = milk.measure(result), milk.exact(**parameters)
    assert rows.keys() == exact.keys()
    for name, estimate in rows.items():
        if exact[name] == 0:
            assert estimate.value == 0
        else:
            assert_agrees(estimate, exact[name], FALSE_ALARM)
    assert result.ledger["lost"].value == 0


def test_every_layer_is_met_and_diffusion_rejected(mild):
    for name in milk.CELLS:
        depths, layers = milk.depths(name, medium()), milk.fluence(mild, name)
        assert_agrees(layers, SOLVED.mean_fluence(depths), FALSE_ALARM)
        middles = (depths[1:] + depths[:-1]) / 2
        assert_rejected(layers, Diffusion(10 / 11, 0.9, 1.37).fluence(middles))
        assert_rejected(layers, SOLVED.mean_fluence(depths)[::-1])


def test_layers_by_length_of_way_are_the_same():
    scene = milk.scene(**MILD)
    probes = [
        dataclasses.replace(part, estimator="track") if part.name in milk.CELLS else part
        for part in scene.detectors
    ]
    other = tp.Scene(scene.sources, scene.surfaces, probes)
    result = tp.simulate(other, particles=100_000, seed=1, threads=1)
    for name in milk.CELLS:
        exact = SOLVED.mean_fluence(milk.depths(name, medium()))
        assert_agrees(milk.fluence(result, name), exact, FALSE_ALARM)


def test_directions_are_met_and_a_lambertian_surface_rejected(mild):
    edges = np.linspace(0, 1, milk.ANGLES + 1)
    leaving = mild["diffuse"].intensity_out * (2 * math.pi / milk.ANGLES)
    assert_agrees(leaving, SOLVED.leaving(edges), FALSE_ALARM)
    assert_rejected(leaving, SOLVED.reflectance * np.diff(edges**2))


def test_other_reflectances_are_rejected(mild):
    """Planted: the specular share counted in, no boundary, isotropic scattering of σ_s, diffusion."""
    diffuse, half_space = milk.measure(mild)[DIFFUSE], SOLVED
    assert_agrees(diffuse, half_space.reflectance, FALSE_ALARM)
    for wrong in (
        half_space.reflectance + half_space.specular,
        milk.solution(medium(index=1.0)).reflectance * (1 - half_space.specular),
        milk.solution(medium(g=0.0)).reflectance,
        Diffusion(10 / 11, 0.9, 1.37).reflectance,
    ):
        assert_rejected(diffuse, wrong)


def test_a_slightly_other_milk_is_rejected(mild):
    """Planted: g of 0.89, 5 % more absorption, an index of 1.40."""
    rows = milk.measure(mild)
    for change in ({"g": 0.89}, {"absorption": 105.0}):
        for name in (DIFFUSE, UPPER):
            assert_rejected(rows[name], milk.exact(**MILD | change)[name])
    for name in (DIFFUSE, SPECULAR):
        assert_rejected(rows[name], milk.exact(**MILD | {"index": 1.40})[name])


def test_all_light_is_accounted_for(mild):
    rows, whole = milk.measure(mild), mild.ledger["emitted"]
    assert_agrees(rows[SPECULAR] + rows[DIFFUSE] + rows[ABSORBED], 1.0, FALSE_ALARM)
    ends = math.fsum(entry.value for name, entry in mild.ledger.items() if name != "emitted")
    assert ends == pytest.approx(whole.value, rel=1e-12)
    depth = mild["deep"].detector.shape.size[2] * 1100
    taken = mild["deep"].absorbed_power.sum() / whole
    assert_agrees(taken, SOLVED.mean_fluence([0, depth])[0] * depth / 11, FALSE_ALARM)


def test_light_beside_a_narrow_box_is_missed(monkeypatch):
    """Planted: boxes four lengths of decay wide."""
    monkeypatch.setattr(milk, "WIDTH", 4.0)
    assert_rejected(milk.measure(run(300_000, **MILD))[LOWER], milk.exact(**MILD)[LOWER])


def test_the_default_is_like_tissue_and_milk_is_white():
    """Three and thirty-five millimetres deep are looked at; of a hundred times less absorption 93 % comes back."""
    medium = milk.medium_of(run(100))
    assert (medium.scattering / medium.absorption, medium.phase.g, medium.index) == (1000, 0.9, 1.37)
    assert 1e3 * milk.depths("shallow", medium)[-1] / medium.extinction == pytest.approx(3, rel=0.02)
    assert 1e3 * milk.depths("deep", medium)[-1] / medium.extinction == pytest.approx(34.5, rel=0.02)
    assert milk.exact()[DIFFUSE] == pytest.approx(0.61643411023, rel=1e-10)
    assert milk.exact(absorption=0.1)[DIFFUSE] == pytest.approx(0.93, abs=0.001)
