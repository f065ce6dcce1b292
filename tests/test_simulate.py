"""How a run ends: by particles, error, seconds or Ctrl-C; what it refuses; what it says while it runs."""

import re
import signal
import time

import numpy as np
import pytest

import transport as tp
from tests.ctrl_c import pressing_ctrl_c
from transport import SceneError


def scene(**bins):
    meter = tp.Detector(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.5), name="meter", **bins)
    return tp.Scene(
        sources=[tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=100.0))], detectors=[meter]
    )


@pytest.mark.parametrize("particles", [1, 31, 32, 1000, 100_003])
def test_exactly_the_particles_asked_for_are_emitted(particles):
    result = tp.simulate(scene(), particles=particles, seed=1)
    assert result.particles == particles == result.cost.particles
    assert result.is_complete
    assert np.ptp(result.run.sizes) <= 1
    assert len(result.run) == min(32, particles)


def test_a_single_batch_has_no_error():
    result = tp.simulate(scene(), particles=1)
    assert np.isnan(result["meter"].flux_in.error)
    assert result["meter"].flux_in.reason is not None


def test_a_run_for_an_error_reaches_it():
    result = tp.simulate(scene(), error={"meter.flux_in": 0.01}, seed=1, estimator="analog")
    assert result["meter"].flux_in.relative_error <= 0.01
    assert len(result.run) >= 32
    assert not result.warnings


def test_a_run_for_an_error_does_not_depend_on_threads():
    limits = {"error": {"meter.flux_in": 0.02}, "seed": 1, "estimator": "analog"}
    one, two = (tp.simulate(scene(), **limits, threads=n) for n in (1, 2))
    assert one.particles == two.particles
    assert one["meter"].flux_in.value == two["meter"].flux_in.value


def test_particles_that_run_out_before_the_error_are_told():
    result = tp.simulate(scene(), particles=5000, error={"meter.flux_in": 1e-4}, seed=1, estimator="analog")
    assert result.particles == 5000
    assert "times the requested error" in result.report()


def test_a_run_for_seconds_takes_about_as_long():
    tp.simulate(scene(), particles=10)
    begun = time.perf_counter()
    result = tp.simulate(scene(), seconds=0.3, seed=1, estimator="analog")
    assert 0.3 <= time.perf_counter() - begun < 3
    assert 32 <= len(result.run) < 64


def test_batches_that_were_merged_are_the_same_histories():
    """Sums of a run in doubling batches follow the same law as one in equal batches."""
    doubling = tp.simulate(scene(), error={"meter.flux_in": 0.005}, seed=1, estimator="analog")
    equal = tp.simulate(scene(), particles=doubling.particles, seed=2)
    a, b = doubling["meter"].flux_in, equal["meter"].flux_in
    assert abs(a.value - b.value) < 5 * np.hypot(a.error, b.error)
    assert 0.5 < a.error / b.error < 2


def test_ctrl_c_returns_what_is_done(press_ctrl_c):
    tp.simulate(scene(), particles=10)
    press_ctrl_c(after=0.3)
    result = tp.simulate(scene(), particles=4 * 10**9, batches=4096, seed=1)
    assert not result.is_complete
    assert 0 < result.particles < 4 * 10**9
    assert result["meter"].flux_in.error > 0
    assert "INCOMPLETE" in result.report()


def test_a_run_goes_on_where_ctrl_c_is_ignored():
    """As under nohup."""
    tp.simulate(scene(), particles=10)
    with pressing_ctrl_c(signal.SIG_IGN) as press:
        press(after=0.1)
        result = tp.simulate(scene(), seconds=0.4, seed=1)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    assert result.is_complete and result.cost.seconds >= 0.4


def test_ctrl_c_within_the_first_batch_stops_at_once_and_says_how_to_have_shorter_ones(press_ctrl_c):
    walls = [
        tp.Surface(face, tp.Diffuse(0.9999), name=name) for name, face in tp.Box(size=2.0).faces().items()
    ]
    bright = tp.Scene(sources=[tp.Source("+z", tp.Lambertian(power=1.0), side="back")], surfaces=walls)
    tp.simulate(bright, particles=10)
    press_ctrl_c(after=0.3)
    begun = time.perf_counter()
    with pytest.raises(KeyboardInterrupt) as interruption:
        tp.simulate(bright, particles=10**7, batches=2, seed=1, threads=1)
    assert time.perf_counter() - begun < 2
    said = str(interruption.value)
    takes, unit, more = re.search(
        r"of 5000000 particles.*takes about ([\d.]+) (\w+).*batches=(\d+)", said
    ).groups()
    seconds = float(takes) * {"s": 1, "min": 60, "hours": 3600}[unit]
    assert 2 * seconds / int(more) == pytest.approx(1, rel=0.02) or int(more) == 4096


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({}, "no limit given"),
        ({"particles": 0}, "particles must be a whole number"),
        ({"particles": 1.5}, "got 1.5"),
        ({"particles": True}, "got True"),
        ({"particles": 10, "batches": 1}, "batches must be"),
        ({"particles": 10, "seed": -1}, "seed must be"),
        ({"particles": 10, "threads": 0}, "threads must be"),
        ({"particles": 10, "estimator": "sobol"}, "estimator must be one of 'analog'"),
        ({"seconds": 0}, "seconds must be"),
        ({"seconds": float("nan")}, "seconds must be"),
        ({"error": 0.01}, "error must be like"),
        ({"error": {}}, "no limit given"),
        ({"error": {"meter": 0.1}}, "such as 'meter.flux_in'"),
        ({"error": {"meter.radiance": 0.1}}, "needs directions"),
        ({"error": {"meter.energy_in": 0.1}}, "needs a clock"),
        ({"error": {"meter.flux_in": 0.1}, "batches": 4}, "at least 16"),
        ({"error": {"metre.flux_in": 0.1}}, "did you mean 'meter'"),
        ({"error": {"meter.flux": 0.1}}, "did you mean 'flux_in'"),
        ({"error": {"meter.flux_in": 2.0}}, r"within \(0, 1\)"),
    ],
)
def test_limits_that_cannot_be_kept_are_refused(limits, message):
    with pytest.raises(SceneError, match=message):
        tp.simulate(scene(), **limits)


def test_whole_numbers_may_be_floats():
    assert tp.simulate(scene(), particles=1e4).particles == 10_000
    assert tp.simulate(scene(), particles=np.int64(100)).particles == 100


def test_unknown_detectors_and_quantities_are_refused_with_the_nearest():
    result = tp.simulate(scene(), particles=100)
    with pytest.raises(SceneError, match="did you mean 'meter'"):
        result["metr"]
    with pytest.raises(SceneError, match="did you mean 'emitted'"):
        result.ledger["emited"]
    with pytest.raises(SceneError, match="radiance needs directions"):
        _ = result["meter"].radiance
    with pytest.raises(SceneError, match="needs a clock"):
        _ = result["meter"].energy_in


def test_a_bar_is_shown_only_where_it_is_asked_for(capfd):
    tp.simulate(scene(), seconds=0.8, progress=False)
    assert capfd.readouterr() == ("", "")
    tp.simulate(scene(), seconds=0.8, progress=True)
    assert "particles" in capfd.readouterr().err


def test_ratios_of_one_run_keep_their_correlation():
    result = tp.simulate(scene(directions=tp.Directions(mu=4)), particles=100_000, seed=1)
    reading = result["meter"]
    share = reading.flux_in / result.ledger["emitted"]
    assert str(share.unit) == "1"
    np.testing.assert_allclose(share.relative_error, reading.flux_in.relative_error, rtol=1e-3)


def test_a_run_for_an_error_that_is_not_reached_says_so():
    result = tp.simulate(scene(), error={"meter.flux_in": 1e-9}, seconds=0.1)
    assert any("times the requested error" in warning for warning in result.warnings)
    speck = tp.Detector(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=1e-7), "meter")
    blind = tp.Scene(tp.Source(tp.Disk(radius=1.0), tp.Lambertian(power=1.0)), (), speck)
    never = tp.simulate(blind, error={"meter.flux_in": 0.1}, estimator="analog")
    assert never.particles < 10**8
    assert any("without a score" in warning for warning in never.warnings)


def test_a_run_that_did_not_reach_its_error_names_the_estimators_that_were_not_tried():
    def told(scene, name="meter.flux_in", **how):
        result = tp.simulate(scene, error={name: 1e-9}, particles=20_000, seed=1, progress=False, **how)
        (line,) = [each for each in result.warnings if "times the requested error" in each]
        return line.partition("requested error")[2]

    lamp = tp.Surface(tp.Disk(radius=0.5), tp.Black(), name="lamp")
    lit = tp.Scene(tp.Source("lamp", tp.Lambertian(radiance=1.0)), lamp, scene().detectors)
    cure = "may suit better: estimator='auto' tries them"
    assert told(lit, estimator="analog") == f". 'aimed' or 'expected' or 'backward' {cure}"
    assert told(lit, estimator="expected") == f". 'analog' or 'aimed' or 'backward' {cure}"
    assert told(lit, estimator="expected", sampling="sobol") == f". 'analog' or 'aimed' {cure}"
    assert told(lit) == ""  # pilots have compared them
    camera = tp.Camera(name="cam", position=(0, 0, 2), look_at=(0.5, 0, 0), up=(0, 1, 0), pixels=(4, 3))
    wall = tp.Surface(tp.Disk(radius=0.6, center=(0, 0, -1)), tp.Diffuse(0.5))
    only_backward = tp.Scene(lit.sources, [lamp, wall], camera)
    assert told(only_backward, "cam.radiance", estimator="backward") == ""


def test_a_run_for_the_error_of_bins_looks_at_the_worst_that_has_scores():
    result = tp.simulate(
        scene(directions=tp.Directions(mu=4)), error={"meter.radiance": 0.05}, seed=1, estimator="analog"
    )
    assert np.nanmax(result["meter"].radiance.relative_error) <= 0.05


def test_a_result_tells_its_detectors_and_its_ledger():
    result = tp.simulate(scene(), particles=1000)
    assert "meter" in result
    assert list(result) == ["meter"]
    assert "emitted" in str(result.ledger)
    with pytest.raises(AttributeError, match="did you mean 'flux_in'"):
        _ = result["meter"].flux


def test_only_scenes_are_run():
    with pytest.raises(SceneError, match="scene must be a Scene"):
        tp.simulate(None, particles=10)
