"""The integrating sphere: geometric series against references and an independent sum, the engine against
them.

A comment such as `D.integrating_sphere` names the entry of the project's reference collection that a number
comes from.  The statistical tests fail right code in one of 10^5 seeds each; the seed is 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from transport.sims import integrating_sphere as sim
from transport.theory import enclosures
from transport.theory import enclosures as theory

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
REFERENCES = {  # D.integrating_sphere: albedo and port to multiplier and wall hits
    (0.9, 0.0): (9.000000000000002, 10.000000000000002),
    (0.95, 0.05): (9.74358974358974, 10.256410256410254),
    (0.99, 0.01): (49.74874371859289, 50.25125628140696),
    (0.999, 0.0001): (908.2643876715714, 909.1735612328042),
}
FEW = {(0.99, 0.01): 40_000, (0.999, 0.0001): 5_000}  # particles, of white spheres


def close(value, exact, relative=1e-14):
    return np.allclose(value, np.array(exact, dtype=float), rtol=relative, atol=0)


# ---- geometric series ----


@pytest.mark.parametrize("sphere", REFERENCES)
def test_the_multiplier_agrees_with_references(sphere):
    (albedo, port), (multiplier, hits) = sphere, REFERENCES[sphere]
    mean = theory.mean_albedo([albedo, 0.0], [1 - port, port])
    assert close(theory.multiplier(albedo, port), multiplier)
    assert close(theory.beam_hits(albedo, 1 - port, mean), hits)
    assert close(theory.beam_irradiance(3.0, albedo, mean, 2.0), 1.5 * multiplier)
    assert close(albedo * theory.lamp_irradiance(3.0, mean, 2.0), 1.5 * multiplier)
    assert close(enclosures.sphere_wall_exitance(3.0, albedo, 2.0, port), 1.5 * multiplier)


def test_a_sphere_of_three_parts_agrees_with_its_radiosities():
    """Each part sees every other by its share of the area: B = M₀ + a F B, solved as equations and not as a
    series.
    """
    albedos, shares = np.array([0.9, 0.3, 0.0]), np.array([0.8, 0.15, 0.05])
    mean = theory.mean_albedo(albedos, shares)
    exchange = albedos[:, None] * shares
    lamp = np.linalg.solve(np.eye(3) - exchange, albedos)  # lit by 1 W m^-2 everywhere
    assert close(lamp, albedos * theory.lamp_irradiance(1.0, mean, 1.0))
    beam = np.linalg.solve(np.eye(3) - exchange, albedos * [1 / shares[0], 0, 0])  # 1 W on part 0
    incident = shares @ beam
    assert close(incident, theory.beam_irradiance(1.0, albedos[0], mean, 1.0))
    assert close(1 + incident * shares[0], theory.beam_hits(albedos[0], shares[0], mean))
    assert close(theory.lamp_hits(shares[0], mean), shares[0] * theory.lamp_irradiance(1.0, mean, 1.0))


def test_what_enters_ends_on_the_wall_or_leaves():
    for albedo, port in REFERENCES:
        for light in sim.LIGHTS:
            rows = sim.exact(light=light, albedo=albedo, port=port)
            assert close((1 - albedo) * rows[sim.HITS] + rows.get(sim.OUT, 0.0), 1.0, 1e-12)


# ---- counted ----


def run(particles=200_000, **parameters):
    """Estimates of the sim with these parameters, by name."""
    result = tp.simulate(sim.scene(**parameters), particles=particles, seed=1)
    assert result.ledger["lost"].value == 0
    return result, sim.measure(result)


def assert_rows(rows, **parameters):
    exact = sim.exact(**parameters)
    assert rows.keys() == exact.keys()
    for name, estimate in rows.items():
        assert_agrees(estimate, exact[name], FALSE_ALARM)


@pytest.mark.parametrize("sphere", REFERENCES)
def test_the_references_are_counted(sphere):
    (albedo, port), (multiplier, hits) = sphere, REFERENCES[sphere]
    setting = {"light": "beam", "albedo": albedo, "port": port, "detail": False}
    _, rows = run(FEW.get(sphere, 200_000), **setting)
    assert_rows(rows, **setting)
    assert_agrees(rows[sim.REFLECTED], multiplier, FALSE_ALARM)
    assert_agrees(rows[sim.HITS], hits, FALSE_ALARM)


@pytest.mark.parametrize("light", sim.LIGHTS)
@pytest.mark.parametrize(
    "rest", [{"port": 0.2}, {"port": 0.02, "sample": 0.1}, {"port": 0.0, "sample": 0.4, "radius": 1e6}]
)
def test_every_row_of_a_sphere_is_met(light, rest):
    setting = {"light": light, "albedo": 0.7} | rest
    _, rows = run(**setting)
    assert_rows(rows, **setting)


@pytest.mark.parametrize("light", sim.LIGHTS)
def test_the_irradiance_is_the_same_on_all_rings_and_a_cosine_s_trend_is_rejected(light):
    setting = {"light": light, "albedo": 0.8, "port": 0.1}
    result, _ = run(500_000, **setting)
    level, angles = sim.exact(**setting)[sim.RING], (np.arange(sim.BINS) + 0.5) * math.pi / sim.BINS
    assert_agrees(sim.rings(result), level, FALSE_ALARM)
    assert_rejected(sim.rings(result), level * (1 + 0.05 * np.cos(angles)))


def test_a_port_forgotten_or_taken_twice_is_rejected():
    _, rows = run(albedo=0.95, port=0.05)
    exact = sim.exact(albedo=0.95, port=0.05)[sim.RADIOSITY]
    assert close(exact, theory.multiplier(0.95, 0.05))
    assert_rejected(rows[sim.RADIOSITY], theory.multiplier(0.95, 0.0))
    assert_rejected(rows[sim.RADIOSITY], theory.multiplier(0.95, 0.1))
    assert_rejected(rows[sim.RADIOSITY], theory.multiplier(0.95, 0.05) / 0.95)  # reflected once less


def test_a_sample_taken_for_wall_or_for_a_hole_is_rejected():
    setting = {"albedo": 0.9, "port": 0.02, "sample": 0.1, "sample_albedo": 0.4}
    _, rows = run(**setting)
    assert_rows(rows, **setting)
    for wrong in (0.9, 0.0):
        assert_rejected(rows[sim.RADIOSITY], sim.exact(**setting | {"sample_albedo": wrong})[sim.RADIOSITY])


def test_walls_that_mirror_are_no_integrating_sphere():
    """Planted: from the centre a mirror sends all straight back, so that the port gets its share of the lamp
    only.
    """
    scene = sim.scene(albedo=0.9, port=0.1, detail=False)
    mirror = tp.Surface(scene.surfaces[0].shape, tp.Mirror(0.9), name="wall")
    result = tp.simulate(tp.Scene(scene.sources, mirror, scene.detectors), particles=50_000, seed=1)
    assert_rejected(sim.measure(result)[sim.OUT], sim.exact(albedo=0.9, port=0.1)[sim.OUT])


def test_the_sphere_may_be_any_size_and_the_digits_stay():
    setting = {"albedo": 0.8, "port": 0.1, "detail": False}
    (_, small), (_, large) = (run(20_000, radius=radius, **setting) for radius in (1e-6, 1e3))
    for name in small:
        assert small[name].value == pytest.approx(large[name].value, rel=1e-3)
