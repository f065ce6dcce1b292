"""The diffuse-walled tube: Clausing's equation against references and an independent solution, the engine
against it.

A comment such as `D.clausing_tube` names the entry of the project's reference collection that a number comes
from.  The statistical tests fail right code in one of 10^5 seeds each; the seed is 1.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from transport.sims import tube as sim
from transport.theory import clausing

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
LENGTHS = (0.01, 0.1, 1.0, 3.7, 20.0, 100.0)


def close(value, exact, relative=1e-14):
    return np.allclose(value, np.array(exact, dtype=float), rtol=relative, atol=0)


# ---- Clausing's equation ----


def test_the_ring_kernel_agrees_with_references():
    s = np.array([0, 0.5, 1, 3, 10])  # C.cylinder_ring_kernel
    kernel = [0.5, 0.3216649815909316, 0.18695048315002943, 0.01997098403585945, 0.00028100181135798374]
    to_end = [0.5, 0.2957051563317492, 0.17082039324993692, 0.0254255396193801, 0.0009614460236928579]
    assert close(clausing.ring_density(s), kernel, 1e-13)
    assert close(clausing.to_end(s), to_end, 1e-13)


@pytest.mark.parametrize("s", [1e-9, 0.1, 2.0, 50.0, 1e4])
def test_the_ring_kernel_is_the_end_s_slope_and_does_not_cancel(s):
    def to_end(x):
        return (x * x + 2) / (2 * mp.sqrt(x * x + 4)) - x / 2

    with mp.workdps(60):
        x = mp.mpf(s)
        kernel = (1 - x * (x * x + 6) / mp.sqrt(x * x + 4) ** 3) / 2
        assert close(clausing.ring_density(s), float(kernel))
        assert close(clausing.ring_density(s), float(-mp.diff(to_end, x)))
        assert close(clausing.to_end(s), float(to_end(x)))


def test_transmissions_agree_with_references():
    assert close(clausing.transmission(0.1), 0.9523989073150395, 1e-13)  # D.clausing_tube
    assert close(clausing.transmission(2), 0.5142305345474457, 1e-13)
    lengths = np.array([10, 20, 50])  # D.clausing_long_limit
    ratios = [clausing.transmission(length) / clausing.long_tube(length) for length in lengths]
    assert close(ratios, [0.7160341197003846, 0.8199053581591648, 0.9089334384586345], 1e-12)
    assert close(clausing.long_tube(lengths) * lengths, 2.6666666666666665)
    direct = [
        0.9048750780274961,
        0.38196601125010515,
        0.1715728752538099,
        0.03708798216373992,
        0.0098048640721517,
    ]
    lengths = (0.1, 1, 2, 5, 10)  # D.clausing_direct_fraction
    assert close([sim.exact(length=length)[sim.DIRECT] for length in lengths], direct, 1e-13)


@pytest.mark.parametrize("length", LENGTHS)
def test_a_white_wall_loses_nothing_and_is_met_as_often_as_the_tube_is_long(length):
    tube = clausing.solved_tube(length)
    assert close(tube.transmission + tube.reflection, 1.0, 1e-12)
    assert close(tube.mean_hits, length, 1e-11)
    assert close(tube.incident + tube.incident[::-1], 1.0, 1e-11)
    depths = np.linspace(0, length, 7)
    assert close(tube.incident_at(depths) + tube.incident_at(length - depths), 1.0, 1e-11)


@pytest.mark.parametrize("albedo", [0.0, 0.5, 0.95])
def test_a_grey_wall_keeps_its_books(albedo):
    tube = clausing.solved_tube(4.0, albedo)
    assert close(tube.transmission + tube.reflection + (1 - albedo) * tube.mean_hits, 1.0, 1e-13)
    if albedo == 0:
        assert close(tube.incident_at(1.3), clausing.to_end(1.3), 1e-12)


def test_the_solution_solves_the_equation_between_its_nodes_too():
    """By an adaptive rule, cut at the kernel's kink."""
    from scipy.integrate import quad

    tube = clausing.solved_tube(5.0, 0.9)
    for depth in (0.0, 0.123, 2.5, 4.6, 5.0):
        parts = [
            quad(
                lambda y, x=depth: clausing.ring_density(x - y) * float(tube.incident_at(y)),
                *ends,
                epsabs=1e-13,
            )[0]
            for ends in ((0, depth), (depth, 5))
        ]
        assert close(tube.incident_at(depth), clausing.to_end(depth) + 0.9 * math.fsum(parts), 1e-11)


def test_transmission_agrees_with_zones():
    """Rings of equal width exchange exactly what coaxial disks say; Richardson's limit of 200 and 400 of
    them.
    """

    def by_zones(length, count):
        edge = length / count
        ends = (
            2 / (np.hypot(2, np.arange(count + 2) * edge) + np.arange(count + 2) * edge)
        ) ** 2  # disk to disk
        # ring to ring at a distance of 1, 2 ... edges, over ring's pi
        second = ends[:-2] - 2 * ends[1:-1] + ends[2:]
        share = np.empty(count)
        share[1:] = second[: count - 1] / (2 * edge)
        share[0] = 1 - 2 * (1 - ends[1]) / (2 * edge)
        exchange = share[np.abs(np.subtract.outer(np.arange(count), np.arange(count)))]
        to_end = (ends[:-2] - ends[1:-1])[:count] / (2 * edge)
        hits = np.linalg.solve(np.eye(count) - exchange, to_end)
        return ends[count] + 2 * edge * hits @ to_end[::-1]

    for length in (0.5, 2.0, 10.0):
        coarse, fine = by_zones(length, 200), by_zones(length, 400)
        assert close(clausing.transmission(length), fine + (fine - coarse) / 3, 1e-8)


def test_means_over_bins_are_means():
    tube, edges = clausing.solved_tube(7.0), np.array([0, 0.3, 2.2, 7.0])
    nodes, weights = np.polynomial.legendre.leggauss(60)
    middles, halves = (edges[1:] + edges[:-1]) / 2, np.diff(edges) / 2
    means = tube.incident_at(middles[:, None] + halves[:, None] * nodes) @ weights / 2
    assert close(tube.mean_incident(edges), means, 1e-12)


def test_a_short_tube_is_a_hole_and_a_long_one_slow_to_be_thin():
    assert clausing.transmission(1e-6) == pytest.approx(1 - 0.5e-6, rel=1e-12)
    assert 1.05 < clausing.long_tube(100) / clausing.transmission(100) < 1.06
    with pytest.raises(ValueError, match=r"\(0, 200\], got 0"):
        clausing.solved_tube(0.0)


# ---- counted ----


def run(particles=300_000, **parameters):
    """Estimates of the sim with these parameters, by name."""
    result = tp.simulate(sim.scene(**parameters), particles=particles, seed=1)
    assert result.ledger["lost"].value == 0
    return result, sim.measure(result)


@pytest.mark.parametrize(
    ("particles", "parameters"),
    [
        (300_000, {"length": 0.1}),
        (300_000, {"length": 2.0, "radius": 1e-6}),
        (300_000, {"length": 5.0, "albedo": 0.8}),
        (100_000, {"length": 10.0}),
        (20_000, {"length": 50.0}),
    ],
)
def test_rows_of_a_tube_are_met(particles, parameters):
    _, rows = run(particles, **parameters)
    exact = sim.exact(**parameters)
    assert rows.keys() == exact.keys()
    for name, estimate in rows.items():
        assert_agrees(estimate, exact[name], FALSE_ALARM)


def test_what_does_not_get_through_comes_back():
    result, rows = run()
    whole = rows[sim.THROUGH] + rows[sim.BACK]
    assert whole.value == pytest.approx(1, rel=1e-12)
    assert result.ledger["escaped"].value == pytest.approx(sim.POWER, rel=1e-12)


def test_the_wall_receives_clausing_s_profile_and_other_ones_are_rejected():
    """Planted: a straight line from 1 to 0; only what comes from the entrance at once; bins turned round."""
    result, _ = run(length=5.0)
    tube, edges = clausing.solved_tube(5.0), sim.edges(5.0)
    means, middles = tube.mean_incident(edges), (edges[1:] + edges[:-1]) / 2
    assert_agrees(sim.incident(result), means, FALSE_ALARM)
    for wrong in (1 - middles / 5, clausing.to_end(middles), means[::-1]):
        assert_rejected(sim.incident(result), wrong)


def test_other_laws_of_tubes_are_rejected():
    """The long tube's limit, the sum of two resistances, and a wall that mirrors, which lets all through."""
    _, rows = run(length=2.0)
    assert_rejected(rows[sim.THROUGH], clausing.long_tube(2.0))
    assert_rejected(rows[sim.THROUGH], clausing.dushman(2.0))
    scene = sim.scene(length=2.0, detail=False)
    mirror = tp.Surface(scene.surfaces[0].shape, tp.Mirror(), name="wall")
    mirrored = tp.simulate(tp.Scene(scene.sources, mirror, scene.detectors), particles=100_000, seed=1)
    assert mirrored["exit"].flux_in.value == pytest.approx(sim.POWER, rel=1e-12)


def test_half_a_tube_does_not_let_through_half_as_much_again():
    _, rows = run(length=2.0)
    assert_rejected(rows[sim.THROUGH], clausing.transmission(1.0) ** 2)
