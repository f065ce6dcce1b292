"""Runs of sims for their tests: estimates beside exact values, and a judge of all rows of a table."""

from __future__ import annotations

import transport as tp
from tests.agreement import assert_agrees

FALSE_ALARM = 1e-5


def rows(sim, scene=None, particles=1_000_000, seed=1, **parameters):
    """(estimate, exact) by name, of the sim's scene or of a changed one."""
    scene = sim.scene(**parameters) if scene is None else scene
    measured = sim.measure(tp.simulate(scene, particles=particles, seed=seed))
    exact = sim.exact(**parameters)
    assert measured.keys() == exact.keys()
    return {name: (measured[name], value) for name, value in exact.items()}


def run(sim, particles, seed=1, **parameters):
    """The result of the sim with these parameters, in which no particle is lost, and its estimates by name."""
    result = tp.simulate(sim.scene(**parameters), particles=particles, seed=seed)
    assert result.ledger["lost"].value == 0
    return result, sim.measure(result)


def assert_rows(sim, estimates, **parameters):
    """Fail unless these are the rows of the sim, and all agree."""
    exact = sim.exact(**parameters)
    assert estimates.keys() == exact.keys()
    for name, estimate in estimates.items():
        assert_agrees(estimate, exact[name], FALSE_ALARM)


def judge(outcomes):
    """Fail unless all rows of these cases agree, which share the false alarms; return them with their cases."""
    found = [(o, row) for o in outcomes for row in o.rows if row.exact != 0 or row.estimate.reason is None]
    for outcome, row in found:
        try:
            assert_agrees(row.estimate, row.exact, FALSE_ALARM / len(found))
        except AssertionError as error:
            raise AssertionError(f"{outcome.title}: {row.name}: {error}") from None
    return found
