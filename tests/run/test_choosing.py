"""The automatic choice of an estimator: cheapest by pilots, simplest in a tie, and a run that repeats under its name."""

from __future__ import annotations

import itertools
import math
import re
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from transport.compile import methods
from transport.compile.methods import Method
from transport.results.choice import PARTIAL_REASON, Choice, Pilot
from transport.run.auto import (
    cheapest,
    choose_method,
    evaluate_quantity,
    main_quantities,
    price_of,
    select_method,
)
from transport.run.progress import Progress
from transport.run.run import Run
from transport.statistics.estimates import Estimate
from transport.statistics.findings import Finding
from transport.statistics.replicates import Batches
from transport.theory.emitters import mean_disk_irradiance

ANALOG, AIMED, EXPECTED, BACKWARD = map(Method, ("analog", "aimed", "expected", "backward"))
SOBOL = Method("analog", "sobol")
RADIANCE, RADIUS = 100.0, 0.01
METER = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=RADIUS)
LAMP = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(radiance=RADIANCE))
EXACT = METER.area * mean_disk_irradiance(RADIANCE, 1.0, RADIUS, 1.0)
RUN = Batches(np.full(32, 100))


def scene(**parts):
    return tp.Scene(**({"sources": LAMP, "detectors": tp.Detector(METER, "meter")} | parts))


@pytest.fixture
def no_pilots(monkeypatch):
    """A function after whose call no pilot may run."""

    def forbid():
        fail = lambda *_, **__: pytest.fail("a pilot ran")  # noqa: E731
        monkeypatch.setattr(sys.modules["transport.simulate"], "choose_method", fail)

    return forbid


# ---- the rule, by stand-ins for pilots ----


def pilot(method, price=math.inf, rate=0.0, note="", **more):
    return Pilot(method, price, rate, 1000, note, **more)


@pytest.mark.parametrize(
    ("analog", "aimed", "taken"),
    [
        (pilot(ANALOG, 10.0), pilot(AIMED, 1.0), AIMED),
        (pilot(ANALOG, 1.19), pilot(AIMED, 1.0), ANALOG),  # a tie: the simplest
        (pilot(ANALOG, 1.21), pilot(AIMED, 1.0), AIMED),
        (pilot(ANALOG), pilot(AIMED, rate=5.0), AIMED),  # without prices scores are compared
        (pilot(ANALOG), pilot(AIMED, 1e9), AIMED),
        (pilot(ANALOG, note="refused"), pilot(AIMED), AIMED),
        (pilot(ANALOG), pilot(AIMED), ANALOG),
        # The cost counts the histories until there is no doubt.
        (
            pilot(ANALOG, 10.0, 32.0, seconds=1.0),
            pilot(AIMED, 1.0, 32.0, seconds=1.0, foretold=100.0),
            ANALOG,
        ),
    ],
)
def test_the_cheapest_is_taken_and_in_a_tie_the_simplest(analog, aimed, taken):
    assert cheapest([analog, aimed]).method == taken


def one(error, value=1.0, findings=()):
    """An estimate of this value and standard error."""
    made = Estimate(value + error * math.sqrt(31) * np.resize([1.0, -1.0], 32), RUN, "W")
    return made._with_findings(lambda: findings)


def pilots_of(*estimates, particles=1000):
    """Pilots of analog, aimed, expected, of a second each, that estimated so."""
    made = []
    for method, (estimate, price) in zip((ANALOG, AIMED, EXPECTED), estimates, strict=False):
        seen = evaluate_quantity("m.flux_in", estimate, 0.01)
        made.append(Pilot(method, price, 32.0, particles, "", 1.0, (seen.mean,), *seen.doubt))
    return made


def test_an_estimator_whose_mean_lies_below_another_by_more_than_chance_is_out_however_cheap():
    choice = select_method(pilots_of((one(0.1, 2.61), 10.0), (one(1e-9, 1.785), 1e-9)), has_error=False)
    assert choice.method == ANALOG and choice.is_trusted
    assert any("aimed lies 6" in line and "below analog, so it misses light" in line for line in choice.lines)
    near = select_method(pilots_of((one(0.1, 2.0), 10.0), (one(1e-9, 1.785), 1e-9)), has_error=False)
    assert near.method == AIMED  # two standard errors are chance
    doubtful = pilots_of((one(0.1, 2.61, findings=(UNSEEN,)), 10.0), (one(1e-9, 1.785), 1e-9))
    choice = select_method(doubtful, has_error=False, particles=1000)
    assert choice.method == ANALOG and not choice.is_trusted


@pytest.mark.slow
def test_of_estimators_that_agree_one_is_called_too_low_in_one_choice_of_ten_thousand():
    """2000 choices among three with errors of 31 degrees of freedom: none is expected to fail, two would be rejected."""
    rng, out = np.random.default_rng(4), 0
    for _ in range(2000):
        draws = [Estimate(1 + rng.normal(size=32), RUN, "W") for _ in range(3)]
        out += any(select_method(pilots_of(*((draw, 1.0) for draw in draws)), has_error=False).reasons)
    assert out <= 2


FEW_SCORES = Finding("doubtful", "detector 'm'", "", "only 5 scores of light", 0.5, times=5.0)
UNSEEN = Finding("doubtful", "detector 'm'", "", "light via 'mirror' not sampled", 1.0)


@pytest.mark.parametrize(
    ("finding", "limits", "taken"),
    [
        (FEW_SCORES, {"particles": 4000}, AIMED),
        (FEW_SCORES, {"particles": 6000}, ANALOG),
        (UNSEEN, {"particles": 90_000}, AIMED),
        (UNSEEN, {"particles": 110_000}, ANALOG),
        (UNSEEN, {"particles": 110_000, "seconds": 110.0}, ANALOG),
        (UNSEEN, {"particles": 110_000, "seconds": 10.0}, AIMED),  # the limit that ends the run counts
    ],
)
def test_a_doubtful_estimator_is_out_unless_the_run_settles_the_doubt(finding, limits, taken):
    """Pilots of 1000 histories and 1 s; five or a hundred times as many settle it."""
    pilots = pilots_of((one(0.001, findings=(finding,)), 1.0), (one(0.01), 10.0))
    assert select_method(pilots, has_error=False, **limits).method == taken


@pytest.mark.parametrize("seconds", np.random.default_rng(1).random(5).tolist())
def test_a_run_for_an_error_goes_on_to_what_scores_foretell(seconds):
    """Whatever rounding makes of the time that this takes."""
    awaited = pilot(AIMED, 0.01, 32.0, seconds=seconds, foretold=60.15499292574002, doubt="only 0.4 scores")
    for limits, taken in (({}, AIMED), ({"particles": 1e5}, AIMED), ({"particles": 5e4}, ANALOG)):
        choice = select_method([pilot(ANALOG, 1e4, 32.0, seconds=seconds), awaited], has_error=True, **limits)
        assert choice.method == taken


def test_a_choice_without_a_trustworthy_estimator_is_reported():
    lost = select_method(pilots_of((one(0.001, findings=(UNSEEN,)), 1.0)), has_error=False, particles=1000)
    assert not lost.is_trusted and "no method can be trusted here" in lost.lines[0]


@pytest.mark.parametrize(
    ("findings", "reads_all", "taken"),
    [((UNSEEN,), True, BACKWARD), ((), True, ANALOG), ((), False, BACKWARD), ((UNSEEN,), False, BACKWARD)],
)
def test_what_estimates_arrivals_alone_is_second_choice_where_all_may_be_read(findings, reads_all, taken):
    analog, other = pilots_of((one(0.1, findings=findings), 10.0), (one(0.01), 1.0))
    backward = replace(other, method=BACKWARD)
    choice = select_method([analog, backward], has_error=False, particles=1000, reads_all=reads_all)
    assert choice.method == taken and choice.is_trusted


def test_costs_are_written_in_plain_numbers():
    far = (one(0.1), 3.7e7), (one(0.1), 1.0), (one(0.1), 3841.0)
    (line, _) = select_method(pilots_of(*far), has_error=False).lines
    assert "analog costs over 10 000 times as much" in line and "expected costs 3 800 times as much" in line
    assert not re.search(r"\de[+-]?\d", line)


def stand_in_choice(monkeypatch, errors, pace, targets=None, **limits):
    """A choice with runs whose error falls as the root of their particles, and a clock that goes `pace` seconds a particle."""
    monkeypatch.setattr("transport.run.auto.methods_for", lambda scene: list(errors))
    calls = []

    def run(method, particles):
        if errors[method] is None:
            raise tp.SceneError("refused: no")
        calls.append((method, particles))

        def quantity(name):
            if errors[method] == "unreadable":
                raise tp.SceneError("read radiance")
            return one(errors[method] / math.sqrt(particles))

        return SimpleNamespace(quantity=quantity, particles=particles)

    def clock():
        return sum(particles * pace.get(method, 1e-6) for method, particles in calls)

    return choose_method(scene(), targets, None, run, clock, **limits), calls


@pytest.mark.parametrize(("faster", "taken"), [(20, ANALOG), (6, AIMED)])
def test_the_choice_is_by_error_squared_times_seconds_whatever_the_pilots_sizes(monkeypatch, faster, taken):
    """Three times the error at a twentieth of the time is cheaper; at a sixth it is not."""
    pace = {ANALOG: 1e-6 / faster, AIMED: 1e-6}
    choices = [stand_in_choice(monkeypatch, {ANALOG: 3.0, AIMED: 1.0}, pace) for _ in range(3)]
    assert all(choice == choices[0] for choice in choices)  # the same times, the same choice
    choice, calls = choices[0]
    assert choice.method == taken
    assert [each.price for each in choice.pilots] == pytest.approx([9e-6 / faster, 1e-6])
    assert sum(particles * pace[method] for method, particles in calls) < 1.0  # s, of fractions of one


@pytest.mark.parametrize(
    ("limits", "taken"),
    [({"targets": {"meter.flux_in": 0.01}}, ANALOG), ({"seconds": 1.0}, ANALOG), ({}, SOBOL)],
)
def test_nets_must_save_what_their_earlier_rounds_cost(monkeypatch, limits, taken):
    """Half the cost of random histories is too much for a run in rounds, of which the last one counts; in one go it is not."""
    assert stand_in_choice(monkeypatch, {ANALOG: 1.0, SOBOL: 0.7}, {}, **limits)[0].method == taken


@pytest.mark.parametrize(("error", "said"), [(None, "refused: no"), ("unreadable", "read radiance")])
def test_pilots_that_are_refused_are_named_and_not_taken(monkeypatch, error, said):
    """Also where an estimator runs but cannot give the quantity."""
    choice, _ = stand_in_choice(monkeypatch, {ANALOG: 1.0, AIMED: error}, {})
    assert choice.method == ANALOG and any(f"aimed refused ({said})" in line for line in choice.lines)
    with pytest.raises(tp.SceneError, match="refused: no"):
        stand_in_choice(monkeypatch, {ANALOG: None, AIMED: None}, {})


def test_pilots_of_slow_histories_are_small(monkeypatch):
    pace, target = {ANALOG: 1e-3, AIMED: 1e-2}, {"meter.flux_in": 0.01}
    choice, calls = stand_in_choice(monkeypatch, {ANALOG: 1.0, AIMED: 1.0}, pace, target)
    assert [each.particles for each in choice.pilots] == [256, 256]
    assert len(calls) == 4  # one of each that compiles, one that is timed


def test_the_only_estimator_is_taken_without_a_pilot(monkeypatch):
    choice, calls = stand_in_choice(monkeypatch, {ANALOG: None}, {})
    assert choice == Choice(ANALOG, (Pilot(ANALOG),)) and calls == []
    assert "the only method" in choice.lines[0]


def test_a_price_is_that_of_the_largest_cost_among_the_errors():
    nothing = Estimate(np.zeros(32), RUN, "W", counts=0)
    estimates = {"a.flux_in": one(0.1), "b.flux_in": one(0.2), "c.flux_in": nothing}
    seen = {name: evaluate_quantity(name, estimate) for name, estimate in estimates.items()}
    assert price_of(seen, {"a.flux_in": 1e-2, "b.flux_in": 1e-1}, 2.0)[0] == pytest.approx(200.0)
    assert price_of(seen, {"a.flux_in": 1e-1, "b.flux_in": 1e-2}, 2.0)[0] == pytest.approx(800.0)
    assert price_of(seen, {"a.flux_in": 1e-1, "c.flux_in": 1e-2}, 2.0) == (math.inf, 16.0)


def test_without_a_target_a_detector_is_compared_by_its_flux_or_its_radiance():
    cone = tp.Detector(METER, "cone", directions=tp.Directions.cone(axis=(0, 0, -1), half_angle=0.1))
    point = tp.PointDetector(position=(0, 0, 3), name="there")
    both = scene(detectors=[tp.Detector(tp.Disk(center=(0, 0, 2), radius=1.0), "all"), cone, point])
    pairs = [("all.flux_in", "all.flux_out"), ("cone.radiance", "cone.radiance_out")]
    assert main_quantities(both) == [*pairs, ("there.fluence_rate",)]


def test_a_choice_of_version_0_1_is_reported_as_it_was():
    """Its file has the words of that time in place of the reason."""
    pilots = Pilot(ANALOG, price=2.0), Pilot(Method("aimed"), price=1.0)
    old, new = (
        Choice(ANALOG, pilots, ("", reason))
        for reason in ("knows only what arrives at detectors", PARTIAL_REASON)
    )
    assert old == new and "0.5 times as much, but" in old.lines[0] and old.lines[0].endswith(PARTIAL_REASON)


# ---- the estimator "auto" ----


def test_auto_finds_the_small_detector_reports_its_choice_and_repeats_bitwise_under_its_name():
    auto = tp.simulate(scene(), particles=1 << 16, seed=7, estimator="auto", sampling="random")
    taken = auto.choice.method
    assert taken.estimator != "analog"  # which scores one history in 10 000
    assert_agrees(auto["meter"].flux_in, EXACT)
    assert f"estimator: {taken.title}" in auto.report()
    # By the machine's load, pilots of analog have enough scores to be priced or not.
    assert re.search("analog (costs|is doubtful)", auto.report())
    again = tp.simulate(scene(), particles=1 << 16, seed=7, estimator=taken.estimator)
    assert np.array_equal(auto["meter"].flux_in.values, again["meter"].flux_in.values)
    assert again.choice is None


def test_auto_keeps_to_the_given_sampling():
    pilots = tp.simulate(scene(), particles=4096, estimator="auto", sampling="sobol").choice.pilots
    assert {each.method.sampling for each in pilots} == {"sobol"}
    with pytest.raises(tp.SceneError, match="sampling must be one of"):
        tp.simulate(scene(), particles=4096, estimator="auto", sampling="sobo")
    camera = tp.Camera(name="c", position=(0, 0, 0), look_at=(1, 0, 0), pixels=(8, 8), field_of_view=1.0)
    with pytest.raises(tp.SceneError, match=r"sampling 'sobol' does not go with backward.*leave it out"):
        tp.simulate(scene(detectors=camera), particles=1000, estimator="auto", sampling="sobol")


@pytest.mark.parametrize("estimator", ["aimed", "auto"])
def test_a_speck_that_no_estimator_reaches_is_refused(estimator):
    """Analog histories find a speck of 1e-200 sr by no chance; what would aim at it refuses: nobody says that it gets nothing."""
    speck = scene(detectors=[tp.Detector(tp.Disk(center=(0, 0, 1e100), radius=1.0), "speck")])
    with pytest.raises(tp.SceneError, match="subtend more than 1e-200 sr"):
        tp.simulate(speck, particles=1000, estimator=estimator)


# ---- the estimator "aimed" ----


def test_aimed_agrees_with_the_exact_flux_through_an_absorbing_medium_too():
    """A cosine dropped from the weights would be a third off; errors here are below 1e-3."""
    plain = tp.simulate(scene(), particles=1 << 18, seed=1, estimator="aimed")["meter"].flux_in
    assert_agrees(plain, EXACT)
    assert plain.relative_error < 1e-3
    thick = scene(medium=tp.Medium(absorption=0.7))
    near = tp.simulate(thick, particles=1 << 18, seed=1, estimator="aimed")["meter"].flux_in
    far = tp.simulate(thick, particles=1 << 21, seed=2)["meter"].flux_in
    assert abs((near - far).z(0.0)) < 4  # 1 in 16 000


SIDE, BALL = tp.Disk(center=(3, 0, 0), radius=1), tp.Sphere(center=(3, 0, 0), radius=1)
REFUSED = {
    "'wall' redirects light": {"surfaces": tp.Surface(SIDE, tp.Diffuse(0.5), "wall")},
    "surfaces[0] redirects": {"surfaces": tp.Surface(BALL, tp.Dielectric(1.5))},
    "redirects light": {"surfaces": tp.Surface(SIDE, tp.Mirror(0.1))},
    "needs exactly one Detector": {"detectors": [tp.Detector(METER, "meter"), tp.Detector(BALL, "far")]},
    "already has aim=": {"sources": tp.Source(LAMP.shape, LAMP.emission, aim=METER)},
    "got Beam": {"sources": tp.Source(LAMP.shape, tp.Beam((0, 0, 1), power=1.0))},
    "scatters": {"medium": tp.Medium(absorption=0.1, scattering=0.1)},
}


@pytest.mark.parametrize("words", REFUSED)
def test_aimed_is_refused_where_light_may_come_another_way(words):
    refused = scene(**REFUSED[words])
    assert AIMED not in methods.methods_for(refused)
    with pytest.raises(tp.SceneError, match=re.escape(words)):
        tp.simulate(refused, particles=10, estimator="aimed")


def test_aimed_is_allowed_beside_black_surfaces_and_in_absorbing_media():
    clear = scene(surfaces=tp.Surface(SIDE, tp.Black()), medium=tp.Medium(absorption=1.0))
    assert methods.refusal(clear, "aimed") is None


# ---- the default ----

ERROR = {"meter.flux_in": 0.05}


@pytest.mark.slow
@pytest.mark.parametrize(
    "limits", [{"error": ERROR}, {"seconds": 0.05}, {"error": ERROR, "particles": 10_000}]
)
def test_pilots_choose_for_an_error_or_a_time(limits):
    result = tp.simulate(scene(), **limits, seed=1)
    assert result.choice is not None and len(result.choice.pilots) > 3
    assert result.plan.method == result.choice.method and result.plan.method.estimator != "analog"
    assert "chosen: " in result.report() and "repeat: " in result.report()


@pytest.mark.parametrize("limits", [{"particles": 1000}, {"particles": 1000, "error": {}}])
def test_a_run_for_particles_is_analog(limits):
    result = tp.simulate(scene(), **limits)
    assert result.choice is None and result.plan.method == ANALOG


@pytest.mark.slow
def test_sampling_alone_restricts_the_default_and_a_named_estimator_is_taken():
    result = tp.simulate(scene(), error=ERROR, sampling="stratified", seed=1)
    assert {each.method.sampling for each in result.choice.pilots} == {"stratified"}
    assert len(result.choice.pilots) > 1 and result.plan.method.sampling == "stratified"
    named = tp.simulate(scene(), error=ERROR, estimator="expected", seed=1)
    assert named.choice is None and named.plan.method == EXPECTED


@pytest.mark.slow
@pytest.mark.parametrize(
    "how",
    [
        {"seconds": 0.05},
        {"particles": 3000, "estimator": "expected", "sampling": "sobol"},
        {"particles": 3000},
    ],
    ids=["chosen", "named", "default"],
)
def test_a_resumed_run_keeps_its_estimator(tmp_path, no_pilots, how):
    path = tmp_path / "run.npz"
    first = tp.simulate(scene(), **how, seed=1, checkpoint=path)
    no_pilots()
    limits = {"error": {"meter.flux_in": 0.4}, "particles": 40_000}, {"seconds": 0.3}
    for saved, more in itertools.product((first, path), limits):
        result = tp.simulate(scene(), resume=saved, **more)
        assert result.plan.method == first.plan.method and result.seed == first.seed
        assert (result.choice is None) == (first.choice is None)
    again = tp.simulate(scene(), seconds=0.2, seed=1, checkpoint=path, resume=path)
    assert again.plan.method == first.plan.method


@pytest.mark.slow
def test_all_pilots_and_the_run_have_the_given_tracking(monkeypatch):
    """Planted: pilots by the scene's own tracking."""
    fog, split = tp.Medium(absorption=0.1, scattering=0.2), tp.Tracking(absorption="analog", roulette=1e-3)
    seen, run = [], sys.modules["transport.simulate"].Run

    def watched(settings, executor, *rest):
        seen.append(executor.plan.tracking)
        return run(settings, executor, *rest)

    monkeypatch.setattr(sys.modules["transport.simulate"], "Run", watched)
    result = tp.simulate(scene(medium=fog), seconds=0.05, tracking=split)
    assert len(seen) > len(result.choice.pilots) > 3 and set(seen) == {split}
    assert result.plan.tracking == split


def test_parts_of_a_run_never_choose_apart():
    part = tp.simulate(scene(), particles=6400, part=(1, 2))
    assert part.choice is None and part.plan.method == ANALOG
    with pytest.raises(tp.SceneError, match=r"estimator 'auto' does not go with part=\(1, 2\).*name one"):
        tp.simulate(scene(), particles=6400, part=(1, 2), estimator="auto")
    with pytest.raises(tp.SceneError, match="omit error and seconds"):
        tp.simulate(scene(), seconds=1, part=(1, 2))


@pytest.mark.parametrize(
    "wrong",
    [
        {"error": {"metre.flux_in": 0.1}},
        {"error": {"metre.flux_in": 0.1}, "estimator": "auto"},
        {"seconds": 0},
        {"error": ERROR, "batches": 4},
        {"error": 0.1},
    ],
)
def test_wrong_limits_are_refused_before_a_pilot_runs(no_pilots, wrong):
    no_pilots()
    with pytest.raises(
        tp.SceneError, match=r"no detector 'metre'|seconds must|at least 16|error must be like"
    ):
        tp.simulate(scene(), **wrong)


def test_a_camera_is_run_backwards_without_a_pilot(monkeypatch):
    camera = tp.Camera(name="c", position=(3, 0, 3), look_at=(0, 0, 0), pixels=(8, 8), field_of_view=1)
    monkeypatch.setattr("transport.run.auto._trial", lambda *_: pytest.fail("a pilot ran"))
    result = tp.simulate(scene(detectors=camera), seconds=0.05)
    assert result.plan.method == Method("backward")
    assert "the only method that this scene allows" in result.report()
    assert result.ledger["emitted"].value == pytest.approx(1)  # shares, as nobody could have expected watts


# ---- estimators that know less ----


def glint(half_angle=0.1):
    """A narrow bin of direction, where histories that begin in it cost least by far."""
    wall = tp.Surface(tp.Box(center=(0, 0, 1), size=3.0), tp.Diffuse(0.5), "room")
    narrow = tp.Directions.cone(axis=(0.3, 0, 1), half_angle=half_angle)
    meter = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, 1), radius=0.1), "meter", directions=narrow)
    lamp = tp.Source(tp.Disk(center=(0, 0, 2.4), normal=(0, 0, -1), radius=1.2), tp.Lambertian(power=20.0))
    return tp.Scene(lamp, wall, meter)


@pytest.mark.slow
def test_a_run_for_seconds_alone_knows_all_and_names_what_knows_less_for_less():
    result = tp.simulate(glint(), seconds=0.1, seed=1)
    assert result.plan.method.estimator in ("analog", "expected")
    assert result.ledger["emitted"].value == pytest.approx(20.0)
    (line,) = (line for line in result.choice.lines if line.startswith("chosen"))
    assert "times cheaper (estimator='backward', sampling='random'), but estimates only arrivals at" in line
    assert tp.simulate(glint(), seconds=0.1, seed=1, estimator="auto").plan.method.estimator == "backward"
    nothing_else = tp.simulate(glint(1e-3), seconds=0.1, seed=1)
    assert nothing_else.plan.method.estimator == "backward" and nothing_else["meter"].radiance.value[0] > 0


@pytest.mark.slow
def test_a_run_for_an_error_may_know_less_and_refuses_what_it_does_not_know():
    result = tp.simulate(glint(), error={"meter.radiance": 0.02}, seed=1)
    assert result.plan.method.estimator == "backward" and result["meter"].radiance.relative_error.max() < 0.02
    with pytest.raises(tp.SceneError, match=r"result.ledger: .* pilots chose.* estimator='analog'"):
        _ = result.ledger
    assert "ledger of the backward histories" in result.report()
    named = tp.simulate(glint(), particles=1000, estimator="backward")
    assert named.ledger["emitted"].value == pytest.approx(1)


@pytest.mark.slow
def test_a_run_that_pilots_chose_does_not_advise_pilots():
    few = {"particles": 40, "seed": 1}
    named = tp.simulate(glint(), **few, estimator="analog")
    assert "estimator='auto'" in "\n".join((*named.warnings, named.report()))
    # With points of one kind the choice does not depend on how busy the machine is.
    chose = tp.simulate(glint(), **few, seconds=60, sampling="stratified")
    cures = [finding.cure for finding in (*chose.findings, *chose["meter"].radiance.findings)]
    others = " or ".join(map(repr, chose.choice.others))
    assert others and any(f"a larger detector, or estimator={others}" in cure for cure in cures), cures
    assert "'auto'" not in "\n".join((*chose.warnings, *cures, chose.report()))


# ---- what pilots are compared by, where nobody says ----

PLANE = tp.Plane(center=(0, 0, 1), normal=(0, 0, -1))
DARK = tp.Detector(tp.Disk(center=(0, 0, -1), normal=(0, 0, -1), radius=1.0), "dark")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("detectors", "compared"),
    [
        (tp.Detector(PLANE, "top", directions=tp.Directions(mu=4)), None),
        (tp.Detector(PLANE, "top"), None),
        ([DARK, tp.Detector(METER, "meter")], "meter.flux_in"),  # not by one that faces away
        (tp.Detector(tp.Disk(center=(0, 0, 0), radius=1.0), "lamp"), "lamp.flux_out"),  # nothing arrives
    ],
    ids=["plane with directions", "plane", "one that faces away", "departures"],
)
def test_pilots_are_compared_by_what_can_score(detectors, compared):
    result = tp.simulate(scene(detectors=detectors), seconds=0.05)
    assert compared == "lamp.flux_out" or result.choice.is_trusted
    if compared is not None:
        assert {mean.name for mean in result.choice.pilots[0].means} == {compared}
    if compared == "meter.flux_in":
        assert result.plan.method.estimator == "expected"


def test_without_a_detector_the_simplest_estimator_is_taken_without_a_pilot():
    result = tp.simulate(scene(detectors=()), seconds=0.05)
    assert result.plan.method == ANALOG and "no detector gives a quantity" in result.report()


# ---- Ctrl-C and progress ----


@pytest.mark.slow
def test_ctrl_c_among_the_pilots_ends_the_run(press_ctrl_c, monkeypatch):
    tp.simulate(scene(), seconds=0.05)
    made = []

    class Pressed(Run):
        def go(self):
            made.append(self)
            super().go()

        def _take(self, batch):
            super()._take(batch)
            if len(made) == 3 and len(self.batches) == 2:
                press_ctrl_c()

    monkeypatch.setattr(sys.modules["transport.simulate"], "Run", Pressed)
    with pytest.raises(KeyboardInterrupt, match="during pilot runs"):
        tp.simulate(scene(), seconds=2)
    assert len(made) == 3


@pytest.mark.slow
def test_pilots_are_named_on_the_bar_and_count_as_preparation(monkeypatch):
    class Recorder(Progress):
        def __init__(self):
            self.tried, self.particles = [], []

        def trying(self, way):
            self.tried.append(way)

        def running(self, particles, *_):
            self.particles.append(particles)

    recorder = Recorder()
    monkeypatch.setattr("transport.run.run.POLL_SECONDS", 0.0)
    result = tp.simulate(scene(), error=ERROR, progress=recorder)
    assert set(recorder.tried) == {each.method.title for each in result.choice.pilots}
    # Those of the run alone: pilots would begin at 0 again, where two threads merely pass each other.
    assert all(2 * after > before for before, after in itertools.pairwise(recorder.particles))
    assert result.cost.preparation > sum(each.seconds for each in result.choice.pilots) / 2
