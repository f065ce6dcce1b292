"""A run that is saved between any two batches and taken up goes on as if nothing had been: bit for bit, however it is limited."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.same_batches import assert_same
from tests.test_reproducible import scene
from transport.compile.methods import coerce_method
from transport.run import schedules
from transport.run.executor import ThreadExecutor
from transport.run.interruption import Interruption
from transport.run.programs import compiled_program_for
from transport.run.progress import Progress
from transport.run.run import Run
from transport.run.settings import Settings, checked_limits

LIMITS = {
    "particles": {"particles": 40_001},
    "few batches": {"particles": 30_000, "batches": 5},
    "error": {"error": {"ball.flux_in": 0.01}},
    "error, few batches": {"error": {"ball.flux_in": 0.01}, "batches": 16},
}


class Watched(Run):
    """Remembers where it stood after each batch."""

    def _take(self, batch):
        super()._take(batch)
        self.states = [*getattr(self, "states", []), self.now()]


def run_of(limits, sampling="random", threads=2, saved=None):
    what = scene()
    method = coerce_method(what, "analog", sampling)
    asked = checked_limits(
        what, *(limits.get(name) for name in ("particles", "error", "seconds", "batches")), method
    )
    settings = Settings(what, method, asked, seed=3)
    executor = ThreadExecutor(compiled_program_for(settings, Progress()), settings.seed, threads)
    resumed = None if saved is None else SimpleNamespace(state=saved, cost=None, _warnings=[])
    run = Watched(settings, executor, Progress(), Interruption(), saved=resumed)
    run.go()
    return run


@pytest.mark.parametrize("sampling", ["random", "sobol"])
@pytest.mark.parametrize("name", LIMITS)
def test_it_ends_as_one_that_was_not_saved(name, sampling):
    whole = run_of(LIMITS[name], sampling)
    places = np.random.default_rng(1).choice(len(whole.states), 4, replace=False)
    for place in [*places, len(whole.states) - 1]:
        again = run_of(LIMITS[name], sampling, 1 + place % 3, whole.states[place])
        assert_same(again.batches, whole.batches)
        assert (again.particles, again.crossings, again.looks) == (
            whole.particles,
            whole.crossings,
            whole.looks,
        )


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_batches_are_never_larger_than_is_safe(sampling, monkeypatch):
    """Also where several of the largest have become one, and the run goes on to more, or to an error."""
    monkeypatch.setattr(schedules, "MAX_BATCH_SIZE", 512)
    first = run_of({"particles": 40_000, "batches": 16}, sampling)
    assert max(batch.histories for batch in first.batches) > 512
    within = run_of({"particles": 40_000, "batches": 16}, sampling, saved=first.states[40])
    assert_same(within.batches, first.batches)
    for limits in ({"particles": 80_000}, {"error": {"ball.flux_in": 0.005}}):
        run = run_of(limits | {"batches": 16}, sampling, saved=first.state)
        assert max(size for size, _ in run.executor.done) <= 512
