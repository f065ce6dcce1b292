"""Who starts in the oblique prism crosses its base: the same histories.  A closed meter's net flux is the power inside.

Each statistical test fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from transport.sims import flows
from transport.theory import effusion
from transport.theory.solid_angles import in_oblique_prism
from transport.verification.experiment import run_experiment

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
PARTICLES = 400_000
TILTS = [0, 20, 60, 89, 89.99, 91, 120, 180]


def run(particles=PARTICLES, **parameters):
    return run_experiment(flows, parameters, particles=particles, seed=1)[0]


@pytest.fixture(scope="module")
def tilted():
    """By the angle; all histories are in the samples."""
    return {angle: run(particles=flows.SAMPLE, tilt=math.radians(angle)) for angle in TILTS}


@pytest.fixture(scope="module")
def oblique():
    return run(tilt=math.pi / 3, intervals=4)


@pytest.fixture(scope="module")
def closed():
    return run(meter="closed")


def prism(patch, path, places):
    """Who starts in the oblique prism."""
    return in_oblique_prism(patch.center, patch.frame, (patch.width, patch.height), path, places)


# ---- an identity of histories ----


@pytest.mark.parametrize("angle", TILTS)
def test_who_starts_in_the_prism_crosses_and_nobody_else(tilted, angle):
    outcome = tilted[angle]
    started, crossed = flows.started_and_crossed(outcome.result)
    assert len(started) == flows.SAMPLE
    assert (started == crossed).all()
    assert 0.3 * len(started) < started.sum() < 0.8 * len(started)
    counted = sum(outcome.result[side].counts.sum().value for side in (flows.ALONG, flows.AGAINST))
    assert counted == crossed.sum()  # what the counters say


def test_nothing_crosses_a_patch_along_the_stream():
    outcome = run(particles=flows.SAMPLE, tilt=math.pi / 2)
    started, crossed = flows.started_and_crossed(outcome.result)
    assert not started.any() and not crossed.any()
    for row in outcome.rows:
        assert row.estimate.value == 0 == row.exact


def test_a_gas_of_all_speeds_and_directions_crosses_by_its_own_prisms():
    """Each particle has a prism of its own; a turned patch in a Maxwellian gas, met from both sides."""
    patch = tp.Rectangle(center=(0.1, -0.2, 0.3), normal=(1, 2, -2), up=(1, 1, 0), width=0.7, height=0.4)
    scene = tp.Scene(
        tp.Source(tp.Box(size=2), tp.Gas(1e6, tp.Maxwellian(sigma=300.0))),
        surfaces=tp.Surface(patch, tp.Black(), name="patch"),
        detectors=[
            tp.Snapshot(time=0.0, particles=200_000, name="start"),
            tp.Snapshot(time=1e-3, particles=200_000, name="end"),
        ],
        duration=1e-3,
    )
    result = tp.simulate(scene, particles=200_000, seed=1)
    start, end = result["start"], result["end"]
    started = prism(patch, start.velocities * scene.duration, start.positions)
    crossed = ~np.isin(start.histories, end.histories)
    assert (started == crossed).all()
    assert crossed.sum() > 1000


def test_a_right_prism_holds_others(oblique):
    """Planted: the prism built along the normal, of the right volume or of the edge's length."""
    result = oblique.result
    patch, start = result.scene.surfaces[0].shape, result["start"]
    _, crossed = flows.started_and_crossed(result)
    normal = np.array(patch.normal)
    for height in (0.5 * flows.REACH, flows.REACH):
        started = prism(patch, height * normal, start.positions)
        assert np.count_nonzero(started != crossed) > 100
    half_late = prism(patch, np.array([0, 0, 1.001 * flows.REACH]), start.positions)
    assert np.count_nonzero(half_late != crossed) > 0  # dt a thousandth too long


def test_the_prism_has_the_volume_v_cosine_theta_dt_da(oblique):
    for name in (flows.STARTED, flows.CROSSED):
        row = oblique[name]
        assert_agrees(row.estimate, row.exact, FALSE_ALARM)
        assert_rejected(row.estimate, 2 * row.exact)  # d³x without its cosine


# ---- rates ----


@pytest.mark.parametrize("angle", TILTS)
def test_each_side_counts_its_own_positive_cosine(tilted, angle):
    outcome = tilted[angle]
    here, there = (flows.ALONG, flows.AGAINST) if angle < 90 else (flows.AGAINST, flows.ALONG)
    assert_agrees(outcome[here].estimate, outcome[here].exact, FALSE_ALARM)
    assert outcome[there].estimate.value == 0 == outcome[there].exact
    assert_agrees(outcome[flows.NET].estimate, outcome[flows.NET].exact, FALSE_ALARM)
    net = effusion.net_flux_density(1e6, 500.0, math.cos(math.radians(angle)))
    assert outcome[flows.NET].exact == pytest.approx(net, rel=1e-15)


def test_the_rate_does_not_depend_on_the_interval(oblique):
    rates = [oblique[name] for name in flows.interval_names(flows.edges(4))]
    assert len({row.exact for row in rates}) == 1
    for row in rates:
        assert_agrees(row.estimate, row.exact, FALSE_ALARM)
        assert_rejected(row.estimate, row.exact / math.cos(math.pi / 3))
    first = rates[0].estimate
    assert_rejected(first * 1.5, rates[0].exact)  # an interval half a step off


# ---- closed meters ----


def test_the_net_flux_out_of_a_closed_meter_is_the_power_inside(closed):
    for name, inside in flows.METERS.items():
        row = closed[f"{flows.NET}, {name}"]
        assert row.exact == inside
        assert row.estimate.value == pytest.approx(inside, abs=1e-3)
        assert_agrees(row.estimate, row.exact, FALSE_ALARM)


def test_what_flows_through_a_closed_meter_is_more_than_its_net(closed):
    """Sources outside, the ball and the mirror send in and take out again: there is something to cancel."""
    for name in ("sphere", "box", "empty sphere"):
        assert closed.result[name].flux_in.value > 0.02
    sphere = closed.result["sphere"]
    assert_rejected(sphere.flux_out, 1.0)


def test_an_open_meter_does_not_know_the_power_inside(closed):
    """Planted: three faces of the four."""
    faces = [closed.result[name] for name in flows.FACES]
    net = sum(face.flux_out - face.flux_in for face in faces[:3])
    assert_rejected(net, 1.0)


def test_an_absorbing_ball_takes_its_share_of_the_net():
    """Power inside less what is absorbed inside, batch by batch."""
    scene = flows.scene(meter="closed")
    ball, mirror = scene.surfaces
    black = tp.Surface(ball.shape, tp.Black(), name="ball")
    result = tp.simulate(
        tp.Scene(scene.sources, surfaces=[black, mirror], detectors=scene.detectors),
        particles=PARTICLES,
        seed=1,
    )
    net = result["box"].flux_out - result["box"].flux_in
    assert_rejected(net, 2.0)
    whole = net + result.ledger.absorbed_by["ball"]
    assert whole.value == pytest.approx(2, abs=1e-3)


# ---- the sim ----


def test_samples_of_unlike_histories_are_refused():
    """Missing at the end means crossed only where the same histories are looked at."""
    scene = flows.scene(tilt=0.3)
    start, end = scene.snapshots
    fewer = tp.Snapshot(time=start.time, particles=1_000, name=start.name)
    detectors = [*scene.meters, fewer, end]
    other = tp.Scene(scene.sources, scene.surfaces, detectors, duration=scene.duration)
    with pytest.raises(tp.SceneError, match="the two snapshots hold other histories"):
        flows.started_and_crossed(tp.simulate(other, particles=10_000, seed=1))
