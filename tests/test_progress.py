"""What a run says while it goes on: how far it is, and how long it will take."""

import math
import sys
from contextlib import nullcontext

import pytest

import transport as tp
from tests.test_stopping import disks
from transport.run.forecast import Forecaster
from transport.run.progress import Progress, running_text
from transport.run.stopping import Look, Standing


class Recorder(Progress):
    """A bar that only writes down what it is told."""

    def __init__(self):
        self.told = []

    def running(self, particles, elapsed, end, worst):
        self.told.append((particles, elapsed, end, worst))


def test_the_text_tells_the_error_and_the_time_left():
    worst = Standing("meter.flux_in", 1e-3, 3.1e-3, 0.0, 1.0)
    text = running_text(12_000_000, 4.0, 16.0, worst)
    assert text == "12 000 000 particles, about 12 s to go, meter.flux_in 0.31 % (target 0.1 %)"
    assert running_text(7, 1.0, math.inf, None) == "7 particles"
    unknown = Standing("meter.flux_in", 1e-3, math.inf, 0.0, 1.0)
    assert running_text(7, 1.0, math.inf, unknown) == "7 particles, meter.flux_in unknown (target 0.1 %)"


def test_a_bar_tells_the_error_while_a_run_goes_on(capfd):
    tp.simulate(disks(), error={"meter.flux_in": 1e-6}, seconds=1.2, progress=True, estimator="analog")
    shown = capfd.readouterr().err
    assert "to go, meter.flux_in" in shown


def test_what_a_bar_is_told_is_kept_up_to_date(monkeypatch):
    monkeypatch.setattr("transport.run.run.POLL_SECONDS", 0.0)
    recorder = Recorder()
    monkeypatch.setattr(
        sys.modules["transport.simulate"], "open_progress", lambda wanted: nullcontext(recorder)
    )
    result = tp.simulate(disks(), error={"meter.flux_in": 2e-3}, seed=1, threads=1, estimator="analog")
    particles = [told[0] for told in recorder.told]
    assert particles == sorted(particles)
    assert recorder.told[0][3] is None
    errors = [told[3].relative for told in recorder.told if told[3] is not None]
    assert errors == sorted(errors, reverse=True)
    assert min(errors) > result["meter"].flux_in.relative_error
    assert all(end >= elapsed for _, elapsed, end, _ in recorder.told)


# ---- the outlook: pilots of known speed ----


def outlook(threads=1, handing=0.0):
    """After legs of batches that take 0.1 ms, and 1 µs a history."""
    found = Forecaster(threads)
    for size in (64, 1024):
        batches = [(size, 1e-4 + 1e-6 * size)] * 100
        found.add_leg(batches, 100 * (handing + 1e-4 + 1e-6 * size / threads))
    return found


@pytest.mark.parametrize(("threads", "handing"), [(1, 0.0), (4, 0.0), (1, 1e-4)])
def test_a_forecast_tells_latencies_from_histories(threads, handing):
    found = outlook(threads, handing)
    found.plan(elapsed=1.0, particles=10**5, histories=10**7, batches=256)
    assert found.forecast.seconds == pytest.approx(1.0 + 0.0256 + 256 * handing + 10.0 / threads, rel=1e-6)
    assert found.forecast.particles == 10**5 + 10**7


def test_the_end_follows_what_a_run_does_since_the_last_look():
    found = outlook()
    found.plan(elapsed=1.0, particles=0, histories=10**7, batches=256)
    assert found.end(1.1, 10**5) == pytest.approx(11.0, rel=0.01)
    assert found.end(5.0, 2 * 10**6) == pytest.approx(21.0)  # a fifth of the way in 4 s
    found.plan(elapsed=5.0, particles=2 * 10**6, histories=math.inf, batches=0)
    assert found.end(6.0, 3 * 10**6) == math.inf


def test_nothing_is_foretold_before_times_and_errors_are_clear():
    known = Look(1000, 256, (Standing("x", 1e-3, 0.05, 0.0, 1.0),))
    vague = Look(1000, 256, (Standing("x", 1e-3, 0.5, 0.0, 1.0),))
    assert outlook().is_clear(known)
    assert not outlook().is_clear(vague)
    latent = Forecaster(1)
    latent.add_leg([(64, 1e-4)] * 10, 1e-3)
    latent.add_leg([(1024, 1.1e-4)] * 10, 1e-3)
    assert not latent.is_clear(known)


# ---- the price of what a run found ----


def test_the_price_of_a_tenth_of_an_error_is_a_hundred_times_the_time():
    result = tp.simulate(disks(), particles=100_000, seed=1, progress=False)
    error = result["meter"].flux_in.relative_error
    assert result.price("meter.flux_in", error) == pytest.approx(result.cost.seconds)
    assert result.price("meter.flux_in", error / 10) == pytest.approx(result.cost.next_digit)
    assert result.price("meter.flux_out", 0.1) == 0  # nothing leaves it, by proof
    with pytest.raises(tp.SceneError, match="must be relative"):
        result.price("meter.flux_in", 0)
    assert "price of flux_in: 1 % in" in result.report()
