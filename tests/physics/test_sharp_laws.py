"""The sharp experiments of `verify` see small errors: of a phase function's density and of Fresnel's R_p.

They run with their own numbers of particles and seed 1.  Each judgement fails right code in one of 10^6
seeds.  A wrong answer is one that `verify` would reject among all of its rows.
"""

from __future__ import annotations

import math
from functools import lru_cache

import pytest

from tests.agreement import assert_agrees
from transport.cli.laws import LAWS_FALSE_ALARM as OF_ALL
from transport.cli.laws import Law
from transport.sims import phase_functions, two_panes
from transport.theory import fresnel
from transport.verification.experiment import run_experiment

FALSE_ALARM = 1e-6
ROWS = 2000  # more than `verify` has: each row's own rate of false alarms is a share of that of all


@lru_cache
def outcomes(module):
    return run_experiment(module, seed=1)


def is_refused(row, wrong):
    return not Law("", "", "", row.name, row.estimate, wrong).holds(OF_ALL / ROWS)


@pytest.mark.parametrize("module", [phase_functions, two_panes], ids=lambda module: module.__name__)
def test_every_row_agrees_with_its_closed_form(module):
    for outcome in outcomes(module):
        assert {row.name for row in outcome.rows} == module.exact(**outcome.parameters).keys()
        for row in outcome.rows:
            assert_agrees(row.estimate, row.exact, FALSE_ALARM)


def test_half_a_percent_of_a_density_at_a_point_is_refused():
    rows = [
        row
        for outcome in outcomes(phase_functions)
        for row in outcome.rows
        if outcome.parameters["reading"] == "points"
    ]
    assert len(rows) == len(phase_functions.GRAINS) * len(phase_functions.ANGLES)
    for row in rows:
        assert is_refused(row, 1.005 * row.exact) and is_refused(row, row.exact / 1.005)


def test_shares_of_a_mixture_that_are_off_by_three_tenths_are_refused():
    kinds = {outcome.parameters["grains"]: outcome for outcome in outcomes(phase_functions)[-3:]}
    for other in ("small", "large"):
        wrong = {row.name: 0.7 * row.exact + 0.3 * kinds[other][row.name].exact for row in kinds["both"].rows}
        assert sum(is_refused(row, wrong[row.name]) for row in kinds["both"].rows) >= 3


def test_seven_parts_in_ten_thousand_of_r_p_are_refused():
    outcome = outcomes(two_panes)[-1]
    [*_, last], counts = outcome.rows, two_panes.AFTER["grazing"]
    back = fresnel.reflectances(math.cos(two_panes.ANGLES["grazing"]), two_panes.GLASS)
    assert last.exact == pytest.approx(((back.s + back.p) / 2) ** counts[-1], rel=1e-12)
    for factor in (1.0007, 0.9993):
        assert is_refused(last, ((back.s + factor * back.p) / 2) ** counts[-1])
