"""How a run ends and what it refuses: by particles, error, seconds or Ctrl-C; wrong input is refused, and unused options are reported."""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
import signal
import time

import numpy as np
import pytest

import transport as tp
from tests.processes import pressing_ctrl_c
from transport.results.result import Ledger
from transport.run.interruption import Interruption
from transport.validation import SIMULATE_PARAMETERS

LAMP = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
ANALOG = {"seed": 1, "estimator": "analog"}


def scene(**bins):
    meter = tp.Detector(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.5), name="meter", **bins)
    return tp.Scene(tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=100.0)), detectors=meter)


def refusal(made) -> str:
    with pytest.raises(tp.SceneError) as refused:
        made()
    return str(refused.value)


# ---- particles ----


@pytest.mark.parametrize("particles", [1, 31, 32, 1000, 100_003, 1e4, np.int64(100)])
def test_exactly_the_particles_asked_for_are_emitted(particles):
    result = tp.simulate(scene(), particles=particles, seed=1)
    assert result.particles == particles == result.cost.particles
    assert result.is_complete
    assert np.ptp(result.run.sizes) <= 1
    assert len(result.run) == min(32, particles)
    flux = result["meter"].flux_in
    assert particles > 1 or (np.isnan(flux.error) and flux.reason is not None)  # of a single batch


def test_ratios_of_one_run_keep_their_correlation():
    result = tp.simulate(scene(directions=tp.Directions(mu=4)), particles=100_000, seed=1)
    flux = result["meter"].flux_in
    share = flux / result.ledger["emitted"]
    assert str(share.unit) == "1"
    np.testing.assert_allclose(share.relative_error, flux.relative_error, rtol=1e-3)


# ---- an error or a time ----


def test_a_run_for_an_error_reaches_it_whatever_the_threads():
    one, two = (tp.simulate(scene(), error={"meter.flux_in": 0.01}, **ANALOG, threads=n) for n in (1, 2))
    assert one["meter"].flux_in.relative_error <= 0.01
    assert len(one.run) >= 32 and not one.warnings
    assert one.particles == two.particles
    assert one["meter"].flux_in.value == two["meter"].flux_in.value
    bins = scene(directions=tp.Directions(mu=4))
    radiance = tp.simulate(bins, error={"meter.radiance": 0.05}, **ANALOG)["meter"].radiance
    assert np.nanmax(radiance.relative_error) <= 0.05  # of the worst that has scores


def test_a_run_for_seconds_takes_about_as_long():
    tp.simulate(scene(), particles=10)
    begun = time.perf_counter()
    result = tp.simulate(scene(), seconds=0.3, **ANALOG)
    assert 0.3 <= time.perf_counter() - begun < 3
    assert 32 <= len(result.run) < 64


def test_batches_that_were_merged_are_the_same_histories():
    """Sums of a run in doubling batches follow the same law as one in equal batches."""
    doubling = tp.simulate(scene(), error={"meter.flux_in": 0.005}, seed=1, estimator="analog")
    equal = tp.simulate(scene(), particles=doubling.particles, seed=2)
    a, b = doubling["meter"].flux_in, equal["meter"].flux_in
    assert abs(a.value - b.value) < 5 * np.hypot(a.error, b.error)
    assert 0.5 < a.error / b.error < 2


@pytest.mark.slow
def test_a_run_that_does_not_reach_its_error_has_a_warning():
    few = tp.simulate(scene(), particles=5000, error={"meter.flux_in": 1e-4}, **ANALOG)
    assert few.particles == 5000 and "times the requested error" in few.report()
    short = tp.simulate(scene(), error={"meter.flux_in": 1e-9}, seconds=0.1)
    assert any("times the requested error" in warning for warning in short.warnings)
    speck = tp.Detector(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=1e-7), "meter")
    blind = tp.Scene(tp.Source(tp.Disk(radius=1.0), tp.Lambertian(power=1.0)), (), speck)
    never = tp.simulate(blind, error={"meter.flux_in": 0.1}, estimator="analog")
    assert never.particles < 10**8
    assert any("without a score" in warning for warning in never.warnings)


CURE = "may suit better: estimator='auto' tries them"


@pytest.mark.quick_cases("how4-")
@pytest.mark.parametrize(
    ("how", "advice"),
    [
        ({"estimator": "analog"}, f". 'aimed' or 'expected' or 'backward' {CURE}"),
        ({"estimator": "expected"}, f". 'analog' or 'aimed' or 'backward' {CURE}"),
        ({"estimator": "expected", "sampling": "sobol"}, f". 'analog' or 'aimed' {CURE}"),
        ({}, ""),  # pilots have compared them
        ({"estimator": "backward"}, ""),  # the only one, of a camera
    ],
)
def test_a_run_that_did_not_reach_its_error_names_the_estimators_that_were_not_tried(how, advice):
    lamp = tp.Surface(tp.Disk(radius=0.5), tp.Black(), name="lamp")
    lit = tp.Scene(tp.Source("lamp", tp.Lambertian(radiance=1.0)), lamp, scene().detectors)
    if "backward" in how.values():
        wall = tp.Surface(tp.Disk(radius=0.6, center=(0, 0, -1)), tp.Diffuse(0.5))
        camera = tp.Camera(name="meter", position=(0, 0, 2), look_at=(0.5, 0, 0), up=(0, 1, 0), pixels=(4, 3))
        lit = tp.Scene(lit.sources, [lamp, wall], camera)
    error = {"meter.radiance" if "backward" in how.values() else "meter.flux_in": 1e-9}
    result = tp.simulate(lit, error=error, particles=20_000, seed=1, progress=False, **how)
    (line,) = [each for each in result.warnings if "times the requested error" in each]
    assert line.partition("requested error")[2] == advice


# ---- Ctrl-C ----


def test_ctrl_c_returns_what_is_done(press_ctrl_c):
    tp.simulate(scene(), particles=10)
    press_ctrl_c(after=0.3)
    result = tp.simulate(scene(), particles=4 * 10**8, batches=4096, seed=1)
    assert not result.is_complete
    assert 0 < result.particles < 4 * 10**8
    assert result["meter"].flux_in.error > 0
    assert "INCOMPLETE" in result.report()


@pytest.mark.slow
def test_a_run_goes_on_where_ctrl_c_is_ignored():
    """As under nohup."""
    tp.simulate(scene(), particles=10)
    with pressing_ctrl_c(signal.SIG_IGN) as press:
        press(after=0.1)
        result = tp.simulate(scene(), seconds=0.4, seed=1)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    assert result.is_complete and result.cost.seconds >= 0.4


@pytest.mark.parametrize("delay", [0.0, 0.2])
def test_ctrl_c_within_the_first_batch_stops_at_once_with_a_cure(press_ctrl_c, monkeypatch, delay):
    """Also where the signal's handler takes longer than the run waits for batches: the machine is busy."""
    remember = Interruption._remember

    def remember_late(*arguments):
        time.sleep(delay)
        remember(*arguments)

    monkeypatch.setattr(Interruption, "_remember", remember_late)
    faces = tp.Box(size=2.0).faces().items()
    walls = [tp.Surface(face, tp.Diffuse(0.9999), name=name) for name, face in faces]
    bright = tp.Scene(tp.Source("+z", tp.Lambertian(power=1.0), side="back"), walls)
    tp.simulate(bright, particles=10)
    press_ctrl_c(after=0.3)
    begun = time.process_time()
    with pytest.raises(KeyboardInterrupt) as interruption:
        tp.simulate(bright, particles=10**7, batches=2, seed=1, threads=1)
    assert time.process_time() - begun < 2
    pattern = r"of 5000000 particles.*takes about ([\d.]+) (\w+).*batches=(\d+)"
    takes, unit, more = re.search(pattern, str(interruption.value)).groups()
    length = {"s": 1, "min": 60, "h": 3600, "days": 86_400}[unit]
    digit = min(10.0 ** (math.floor(math.log10(float(takes))) - 1), 1.0)  # the last of two that are printed
    seconds, error = length * float(takes), length * digit / 2
    # two batches, divided into some of a second each, in whole numbers
    assert abs(seconds - int(more) / 2) <= error + 0.5 or int(more) == 4096


def test_ctrl_c_before_the_run_says_that_there_is_no_result():
    interruption = Interruption()
    with pytest.raises(KeyboardInterrupt, match="before the run began, so there is no result"):
        interruption._remember()
    interruption.begin()
    interruption._remember()  # from now on it is delayed


# ---- wrong input ----


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
    with pytest.raises(tp.SceneError, match=message):
        tp.simulate(scene(), **limits)


@pytest.mark.parametrize(
    ("read", "error", "words"),
    [
        (lambda result: result["metr"], tp.SceneError, "did you mean 'meter'"),
        (lambda result: result.ledger["emited"], tp.SceneError, "did you mean 'emitted'"),
        (lambda result: result["meter"].radiance, tp.SceneError, "radiance needs directions"),
        (lambda result: result["meter"].energy_in, tp.SceneError, "needs a clock"),
        (lambda result: result["meter"].flux, AttributeError, "did you mean 'flux_in'"),
    ],
)
def test_unknown_detectors_and_quantities_are_refused_with_the_nearest(read, error, words):
    result = tp.simulate(scene(), particles=100)
    assert "meter" in result and list(result) == ["meter"] and "emitted" in str(result.ledger)
    with pytest.raises(error, match=words):
        read(result)


def test_only_scenes_are_run():
    with pytest.raises(tp.SceneError, match="scene must be a Scene"):
        tp.simulate(None, particles=10)


@pytest.mark.parametrize("name", sorted(SIMULATE_PARAMETERS))
def test_parameters_of_simulate_are_refused_by_a_scene(name):
    said = refusal(lambda: tp.Scene(LAMP, **{name: "analog"}))
    assert said == f"Scene: unknown parameter {name}='analog'; write simulate(scene, {name}=...)"
    assert set(inspect.signature(tp.simulate).parameters) - {"scene"} == SIMULATE_PARAMETERS


# ---- tracking ----

BOX, SPLIT = tp.Box(size=2), tp.Splitting(start=(0, 0, 0), end=(0, 0, 1), gain=3)


def filled(medium=None, *more) -> tp.Scene:
    return tp.Scene(LAMP, [tp.Surface(BOX, tp.Transparent(), inside=medium), *more])


def run(scene, tracking=None, particles=320):
    return tp.simulate(scene, particles, seed=1, threads=1, tracking=tracking, progress=False)


def reported(scene, tracking=None) -> list[str]:
    """What the report says about tracking."""
    lines = run(scene, tracking).report().splitlines()
    return [line.removeprefix("tracking: ") for line in lines if line.startswith("tracking")]


@pytest.mark.quick_cases("analog-None", "analog-glass")
@pytest.mark.parametrize("medium", [None, tp.Vacuum(), tp.Medium(), tp.Medium(index=1.0), "glass"])
@pytest.mark.parametrize("tracking", ["analog", "weighted", tp.Tracking(splitting=SPLIT)])
def test_tracking_without_media_is_reported_as_without_effect(medium, tracking):
    """Not refused: a sweep over coefficients from 0 on begins with it."""
    glass = tp.Surface(BOX, tp.Dielectric(1.5), inside=tp.Medium(index=1.5))
    lamp = tp.Source(tp.Point(position=(0, 0, 3)), tp.Isotropic(power=1.0))
    idle = tp.Scene(lamp, glass) if medium == "glass" else filled(medium)
    assert reported(idle, tracking) == ["without effect, because no medium here absorbs or scatters"]
    assert reported(idle) == []


@pytest.mark.quick_cases("0.0-None-absorption by weight", "0.0-analog-analog absorption")
@pytest.mark.parametrize(
    ("scattering", "tracking", "said"),
    [
        (0.0, None, "absorption by weight"),
        (0.0, "analog", "analog absorption"),
        (0.0, tp.Tracking(forced=True), "absorption by weight, no collisions to force"),
        (0.0, tp.Tracking(splitting=SPLIT), "absorption by weight, nothing to split: no collisions"),
        (0.0, tp.Tracking(absorption="analog", forced=True), "analog absorption, first collisions forced"),
        (
            0.0,
            tp.Tracking(absorption="analog", splitting=SPLIT),
            "analog absorption, split by importance, gain 3",
        ),
        (1.0, tp.Tracking(forced=True), "absorption by weight, first collisions forced"),
        (1.0, tp.Tracking(splitting=SPLIT), "absorption by weight, split by importance, gain 3"),
    ],
)
def test_collisions_are_forced_or_split_where_there_are_any(scattering, tracking, said):
    """Where nothing scatters, weights leave nothing to force or split."""
    assert reported(filled(tp.Medium(absorption=1.0, scattering=scattering)), tracking) == [said]


@pytest.mark.parametrize(
    ("word", "cure"),
    [
        ("analogue", "did you mean 'analog'?"),
        ("weight", "did you mean 'weighted'?"),
        ("forced", "write tracking=Tracking(forced=...)"),
        ("splitting", "write tracking=Tracking(splitting=...)"),
        ("russian", "leave it out for the default of the scene"),
        (3, "leave it out for the default of the scene"),
    ],
)
def test_a_wrong_tracking_is_refused_with_the_nearest_word(word, cure):
    said = refusal(lambda: run(filled(), word))
    assert said == f"simulate: tracking must be 'analog', 'weighted' or a Tracking, got {word!r}; {cure}"


def test_weights_with_a_clock_are_refused_with_the_cure_for_each_spelling():
    fog = tp.Medium(absorption=1.0)
    clocked = tp.Scene(LAMP, tp.Surface(BOX, tp.Transparent(), inside=fog), duration=1e-8)
    for tracking, said in (
        ("weighted", "got 'weighted'; leave it out"),
        (tp.Tracking(), "write Tracking(absorption='analog', ...)"),
    ):
        assert refusal(lambda tracking=tracking: run(clocked, tracking)).endswith(said)


# ---- masked values ----

GAPS = np.ma.masked_greater(np.array([1.0, 2.0, 9.97e36]), 1e30)
FILL = "write .filled(0), or another number"


@pytest.mark.parametrize("name", ["absorption", "scattering"])
def test_voxels_without_a_value_are_refused(name):
    said = refusal(lambda: tp.Grid(box=BOX, **{name: GAPS[None, None]}))
    assert said == f"Grid: {name} must have all its values, got 1 of 3 values masked; {FILL}"


@pytest.mark.parametrize(
    "made",
    [
        lambda: tp.Tabulated(mu=[-1, 0, 1], density=GAPS),
        lambda: tp.Tabulated(mu=np.ma.masked_equal([-1.0, 0.0, 1.0], 0), density=[1, 2, 3]),
        lambda: tp.Detector(tp.Disk(radius=1), "lid", times=GAPS),
        lambda: tp.Point(position=GAPS),
        lambda: tp.Medium(absorption=GAPS[2:]),
    ],
    ids=["density", "mu", "edges", "place", "number"],
)
def test_masked_values_are_refused_with_their_cure_wherever_they_come(made):
    said = refusal(made)
    assert "masked" in said and FILL in said and "9.97e+36" not in said


def test_a_masked_array_without_gaps_is_an_array():
    whole = np.ma.masked_greater(np.array([[[1.0, 2.0]]]), 1e30)
    assert tp.Grid(box=BOX, absorption=whole) == tp.Grid(box=BOX, absorption=whole.data)
    assert tp.Grid(box=BOX, absorption=GAPS[None, None].filled(0)).absorption.max() == 2.0


# ---- rounding is no roulette ----

THIN = filled(tp.Medium(absorption=0.01, scattering=0.01))
FORCED = {how: tp.Tracking(absorption=how, forced=True) for how in ("analog", "weighted")}


@pytest.mark.parametrize("how", FORCED)
def test_copies_that_share_a_weight_to_rounding_play_no_roulette(how):
    result = run(THIN, FORCED[how], 2000)
    assert any(batch.ledger["roulette"] for batch in result.batches)  # 5e-17 of a history's weight
    assert result.ledger["roulette"].value == 0
    assert ("roulette" in str(result.ledger)) == (how == "weighted")  # which might have killed
    entries = dict(result.ledger)
    assert entries.pop("emitted").value == pytest.approx(
        sum(part.value for part in entries.values()), rel=1e-14
    )


@pytest.mark.parametrize("how", FORCED)
@pytest.mark.parametrize("gain", [1e-14, -1e-14, 1e-3])
def test_what_is_more_than_rounding_is_in_the_ledger(how, gain):
    """An engine that gains a little in one batch of 32 does not hide it."""
    result = run(THIN, FORCED[how], 2000)
    first = result.batches[0]
    result.batches[0] = dataclasses.replace(first, ledger=first.ledger | {"roulette": gain * first.born})
    roulette = Ledger(result)["roulette"]
    assert roulette.value == pytest.approx(gain / 32, rel=0.1) and not roulette.exact
    assert "roulette" in str(Ledger(result))


def test_roulette_at_walls_stays_in_the_ledger():
    walls = tp.Surface(tp.Box(size=4), tp.Diffuse(0.5))
    result = run(filled(tp.Medium(absorption=0.01, scattering=0.01), walls), FORCED["analog"], 2000)
    assert result.ledger["roulette"].error > 1e-4
