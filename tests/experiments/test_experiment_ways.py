"""An experiment that says how it is estimated where the user does not."""

from __future__ import annotations

from types import ModuleType

import pytest

import transport as tp
from tests.run.test_choosing import glint
from transport.sims import cost_disks
from transport.verification.experiment import run_experiment


def experiment_that_runs(**run):
    module = ModuleType("mine")
    module.scene, module.measure, module.particles, module.run = (
        cost_disks.scene,
        cost_disks.measure,
        10_000,
        run,
    )
    return module


def test_an_experiment_may_say_how_it_is_estimated_and_the_user_overrules_it():
    [told] = run_experiment(experiment_that_runs(estimator="aimed"))
    [overruled] = run_experiment(experiment_that_runs(estimator="aimed"), estimator="analog")
    [batches] = run_experiment(experiment_that_runs(batches=20), particles=5000)
    methods = [outcome.result.plan.method.estimator for outcome in (told, overruled, batches)]
    assert methods == ["aimed", "analog", "analog"]
    assert told.result.particles == 10_000
    assert (len(batches.result.run), batches.result.particles) == (20, 5000)


def test_a_way_to_estimate_that_there_is_not_is_refused():
    with pytest.raises(tp.SceneError, match=r"mine: run has no setting 'estimate'.*'estimator'"):
        run_experiment(experiment_that_runs(estimate="aimed"))
    module = experiment_that_runs()
    module.run = "aimed"
    with pytest.raises(tp.SceneError, match=r"mine: run must be settings such as .* got 'aimed'"):
        run_experiment(module)


def glinting(**run):
    """An experiment about one narrow bin of direction that reads the ledger as well: a trap for what runs backwards."""
    module = ModuleType("glinting")
    module.scene, module.run = glint, run
    module.measure = lambda result: {"power": result.ledger["emitted"], "leaving": result["meter"].flux_out}
    return module


@pytest.mark.slow
@pytest.mark.parametrize("limits", [{"error": {"meter.radiance": 0.3}}, {"seconds": 0.1}])
def test_by_default_pilots_choose_among_the_ways_that_know_all(limits):
    """Of the error alone "backward" would be taken (tests/run/test_choosing.py), whose ledger is of shares."""
    [outcome] = run_experiment(glinting(), **limits, seed=1)
    assert len(outcome.result.choice.pilots) > 3
    assert outcome["power"].estimate.value == pytest.approx(20.0)


def test_what_an_experiment_says_is_kept_by_the_default():
    [named] = run_experiment(experiment_that_runs(estimator="aimed"), seconds=0.05)
    assert named.result.choice is None and named.result.plan.method.estimator == "aimed"
    [random] = run_experiment(experiment_that_runs(sampling="random"), seconds=0.05)
    assert {pilot.method.sampling for pilot in random.result.choice.pilots} == {"random"}
    [counted] = run_experiment(experiment_that_runs())
    assert counted.result.choice is None and counted.result.plan.method.estimator == "analog"


def test_cases_have_random_numbers_of_their_own():
    """Rows of the sun at two planets were one draw, eight times; of one case two rows count the same particles."""
    from transport.cli.laws import laws_of
    from transport.cli.verify import independent_checks
    from transport.sims import sun
    from transport.verification.experiment import run_experiment

    outcomes = run_experiment(sun, particles=20_000, seed=3)
    assert [outcome.result.seed for outcome in outcomes] == [3, 1_000_003, 2_000_003, 3_000_003]
    assert len({outcome.rows[0].z for outcome in outcomes}) == 4
    laws = list(laws_of(sun, outcomes))
    assert len(laws) == 8 and independent_checks(laws) == 4
