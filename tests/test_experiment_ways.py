"""An experiment that says how it is estimated where the user does not."""

from __future__ import annotations

from types import ModuleType

import pytest

import transport as tp
from sims import cost_disks
from transport.experiment import run_experiment


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
