"""The automatic choice of an estimator: cheapest by pilots, simplest in a tie, and a run that repeats under its name."""

from __future__ import annotations

import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from transport.estimators import aimed, methods
from transport.estimators.choosing import (
    Choice,
    Pilot,
    _mean_of,
    cheapest,
    choose,
    chosen,
    price_of,
    usual_quantities,
)
from transport.estimators.methods import Method
from transport.results.estimates import Batches, Estimate
from transport.results.findings import Finding

ANALOG, AIMED, EXPECTED = (Method(name) for name in ("analog", "aimed", "expected"))
RADIANCE, RADIUS = 100.0, 0.01
METER = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=RADIUS)
LAMP = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(radiance=RADIANCE))


def scene(**parts):
    return tp.Scene(**({"sources": LAMP, "detectors": tp.Detector(METER, "meter")} | parts))


def exact_flux(a=1.0, b=RADIUS, gap=1.0):
    """pi L A F between coaxial disks [W] (Howell C-41)."""
    x = 1 + (gap**2 + b**2) / a**2
    share = (x - math.sqrt(x**2 - 4 * (b / a) ** 2)) / 2
    return math.pi * RADIANCE * math.pi * a**2 * share


def pilot(method, price=math.inf, rate=0.0, note=""):
    return Pilot(method, price, rate, 1000, note)


def test_the_cheapest_is_taken_and_in_a_tie_the_simplest():
    assert cheapest([pilot(ANALOG, 10.0), pilot(AIMED, 1.0), pilot(EXPECTED, 2.0)]).method == AIMED
    assert cheapest([pilot(ANALOG, 1.19), pilot(AIMED, 1.0)]).method == ANALOG
    assert cheapest([pilot(ANALOG, 1.21), pilot(AIMED, 1.0)]).method == AIMED


def test_what_has_no_price_is_compared_by_its_scores():
    assert cheapest([pilot(ANALOG), pilot(AIMED, rate=5.0)]).method == AIMED
    assert cheapest([pilot(ANALOG), pilot(AIMED, 1e9)]).method == AIMED
    assert cheapest([pilot(ANALOG, note="refused"), pilot(AIMED)]).method == AIMED
    assert cheapest([pilot(ANALOG), pilot(AIMED)]).method == ANALOG


def fake_run(errors, calls):
    """Runs whose relative error falls as the root of their particles, from the given ones at one particle."""

    def run(method, particles):
        if errors[method] is None:
            raise tp.SceneError("refused: no")
        calls.append((method, particles))
        quantity = one(errors[method] / math.sqrt(particles))
        return SimpleNamespace(quantity=lambda name: quantity, particles=particles)

    return run


def one(error, value=1.0, findings=()):
    """An estimate of this value and standard error."""
    signs = np.resize([1.0, -1.0], 32)
    made = Estimate(value + error * math.sqrt(31) * signs, Batches(np.full(32, 100)), "W")
    return made._with_findings(lambda: findings)


def stand_in_choice(monkeypatch, errors, pace, targets=None):
    """A choice with stand-in runs and a stand-in clock that goes `pace` seconds a particle."""
    monkeypatch.setattr("transport.estimators.choosing.methods_for", lambda scene: list(errors))
    calls = []

    def clock():
        return sum(particles * pace[method] for method, particles in calls)

    return choose(scene(), targets, None, fake_run(errors, calls), clock), calls


def test_the_choice_is_by_error_squared_times_seconds_whatever_the_pilots_sizes(monkeypatch):
    """Three times the error at a twentieth of the time is cheaper; at an eighth it is not."""
    errors = {ANALOG: 3.0, AIMED: 1.0}
    for faster, taken in ((20, ANALOG), (6, AIMED)):
        pace = {ANALOG: 1e-6 / faster, AIMED: 1e-6}
        choices = [stand_in_choice(monkeypatch, errors, pace) for _ in range(3)]
        assert all(choice == choices[0] for choice in choices)  # the same times, the same choice
        choice, calls = choices[0]
        assert choice.method == taken
        assert [each.price for each in choice.pilots] == pytest.approx([9e-6 / faster, 1e-6])
        assert sum(particles * pace[method] for method, particles in calls) < 1.0  # s, of fractions of one


def pilots_of(*estimates, particles=1000):
    """Pilots of analog, aimed, expected, of a second each, that estimated so."""
    made = []
    for method, (estimate, price) in zip((ANALOG, AIMED, EXPECTED), estimates, strict=False):
        mean, doubt = _mean_of("m.flux_in", estimate, 0.01)
        made.append(Pilot(method, price, 32.0, particles, "", 1.0, (mean,), *doubt))
    return made


def test_a_way_whose_mean_lies_below_another_by_more_than_chance_is_out_however_cheap():
    choice = chosen(pilots_of((one(0.1, 2.61), 10.0), (one(1e-9, 1.785), 1e-9)), has_error=False)
    assert choice.method == ANALOG and choice.is_trusted
    assert any("aimed lies 6" in line and "below analog, so it misses light" in line for line in choice.lines)
    near = chosen(pilots_of((one(0.1, 2.0), 10.0), (one(1e-9, 1.785), 1e-9)), has_error=False)
    assert near.method == AIMED  # two standard errors are chance


def test_of_ways_that_agree_one_is_called_too_low_in_one_choice_of_ten_thousand():
    """2000 choices among three with errors of 31 degrees of freedom: none is expected to fail, two would be rejected."""
    rng = np.random.default_rng(4)
    out = 0
    for _ in range(2000):
        draws = [Estimate(1 + rng.normal(size=32), Batches(np.full(32, 100)), "W") for _ in range(3)]
        out += any(chosen(pilots_of(*((draw, 1.0) for draw in draws)), has_error=False).reasons)
    assert out <= 2


def test_a_doubtful_way_is_out_unless_the_run_settles_it():
    few = Finding("doubtful", "detector 'm'", "", "only 5 scores of light", 0.5, times=5.0)
    unseen = Finding("doubtful", "detector 'm'", "", "light by 'mirror' not sampled", 1.0)
    for finding, longer, taken in (
        (few, 4, AIMED),
        (few, 6, ANALOG),
        (unseen, 90, AIMED),
        (unseen, 110, ANALOG),
    ):
        pilots = pilots_of((one(0.001, findings=(finding,)), 1.0), (one(0.01), 10.0))
        assert chosen(pilots, has_error=False, particles=longer * 1000).method == taken
    lost = chosen(pilots_of((one(0.001, findings=(unseen,)), 1.0)), has_error=False, particles=1000)
    assert not lost.is_trusted and "no way can be trusted here" in lost.lines[0]


def test_pilots_that_are_refused_are_told_and_not_taken(monkeypatch):
    choice, _ = stand_in_choice(monkeypatch, {ANALOG: 1.0, AIMED: None}, {ANALOG: 1e-6, AIMED: 1e-6})
    assert choice.method == ANALOG
    assert any("aimed refused (refused: no)" in line for line in choice.lines)
    with pytest.raises(tp.SceneError, match="refused: no"):
        stand_in_choice(monkeypatch, {ANALOG: None, AIMED: None}, {})


def test_where_the_ways_that_reach_it_are_refused_a_detector_is_not_said_to_get_nothing():
    """Analog histories find a speck of 1e-200 sr by no chance; what would aim at it refuses."""
    speck = scene(detectors=[tp.Detector(tp.Disk(center=(0, 0, 1e100), radius=1.0), "speck")])
    said = []
    for estimator in ("aimed", "auto"):
        with pytest.raises(tp.SceneError, match="seen under more than 1e-200 sr") as refusal:
            tp.simulate(speck, particles=1000, estimator=estimator)
        said.append(str(refusal.value))
    assert said[0] == said[1]


def test_a_quantity_that_a_way_cannot_read_is_a_refusal_of_that_way(monkeypatch):
    monkeypatch.setattr("transport.estimators.choosing.methods_for", lambda scene: [ANALOG, AIMED])

    def run(method, particles):
        def quantity(name):
            if method == AIMED:
                raise tp.SceneError("read radiance")
            return one(0.1)

        return SimpleNamespace(quantity=quantity, particles=particles)

    choice = choose(scene(), None, None, run, clock=iter(range(100)).__next__)
    assert choice.method == ANALOG and "aimed refused (read radiance)" in choice.lines[0]


def test_where_nobody_says_a_meter_is_sought_for_its_flux_or_its_radiance():
    cone = tp.Detector(METER, "cone", directions=tp.Directions.cone(axis=(0, 0, -1), half_angle=0.1))
    point = tp.PointDetector(position=(0, 0, 3), name="there")
    both = scene(detectors=[tp.Detector(tp.Disk(center=(0, 0, 2), radius=1.0), "all"), cone, point])
    assert usual_quantities(both) == ["all.flux_in", "cone.radiance", "there.fluence_rate"]


def test_a_price_is_that_of_the_dearest_error_asked_for():
    found = {"a.flux_in": (0.1, 1.0), "b.flux_in": (0.2, 1.0), "c.flux_in": (np.inf, 0.0)}

    def quantity(name):
        return SimpleNamespace(relative_error=found[name][0], values=np.full(4, found[name][1]))

    result = SimpleNamespace(quantity=quantity)
    assert price_of(result, {"a.flux_in": 1e-2, "b.flux_in": 1e-1}, 2.0)[0] == pytest.approx(200.0)
    assert price_of(result, {"a.flux_in": 1e-1, "b.flux_in": 1e-2}, 2.0)[0] == pytest.approx(800.0)
    assert price_of(result, {"a.flux_in": 1e-1, "c.flux_in": 1e-2}, 2.0) == (math.inf, 2.0)


def test_auto_finds_the_small_detector_says_so_and_repeats_bitwise_under_its_name():
    auto = tp.simulate(scene(), particles=1 << 16, seed=7, estimator="auto", sampling="random")
    taken = auto.choice.method
    assert taken.estimator != "analog"  # which scores one history in 10 000
    assert_agrees(auto["meter"].flux_in, exact_flux())
    assert f"estimator: {taken.title}" in auto.report() and "analog costs" in auto.report()
    again = tp.simulate(scene(), particles=1 << 16, seed=7, estimator=taken.estimator)
    assert np.array_equal(auto["meter"].flux_in.values, again["meter"].flux_in.values)
    assert again.choice is None


def test_auto_keeps_to_the_sampling_that_is_said():
    pilots = tp.simulate(scene(), particles=4096, estimator="auto", sampling="sobol").choice.pilots
    assert {each.method.sampling for each in pilots} == {"sobol"}
    with pytest.raises(tp.SceneError, match="sampling must be one of"):
        tp.simulate(scene(), particles=4096, estimator="auto", sampling="sobo")


def test_the_only_way_is_taken_without_a_pilot(monkeypatch):
    monkeypatch.setattr("transport.estimators.choosing.methods_for", lambda scene: [ANALOG])
    choice = choose(scene(), None, None, run=None)
    assert choice == Choice(ANALOG, (Pilot(ANALOG),))
    assert "the only way" in choice.lines[0]


def test_auto_with_an_unknown_quantity_is_refused_before_anything_runs(monkeypatch):
    monkeypatch.setattr(sys.modules["transport.simulate"], "choose", lambda *_: pytest.fail("a pilot ran"))
    with pytest.raises(tp.SceneError, match="no detector 'metre'"):
        tp.simulate(scene(), error={"metre.flux_in": 1e-2}, estimator="auto")


def test_aimed_agrees_with_the_exact_flux_through_an_absorbing_medium_too():
    """A cosine dropped from the weights would be a third off; errors here are below 1e-3."""
    plain = tp.simulate(scene(), particles=1 << 18, seed=1, estimator="aimed")
    assert_agrees(plain["meter"].flux_in, exact_flux())
    assert plain["meter"].flux_in.relative_error < 1e-3
    thick = scene(medium=tp.Medium(absorption=0.7))
    near = tp.simulate(thick, particles=1 << 18, seed=1, estimator="aimed")["meter"].flux_in
    far = tp.simulate(thick, particles=1 << 21, seed=2)["meter"].flux_in
    assert abs((near - far).z(0.0)) < 4  # 1 in 16 000


ROOM = {
    "reflects": (
        tp.Surface(tp.Disk(center=(3, 0, 0), radius=1), tp.Diffuse(0.5), "wall"),
        "'wall' turns light",
    ),
    "refracts": (
        tp.Surface(tp.Sphere(center=(3, 0, 0), radius=1), tp.Dielectric(1.5)),
        r"surfaces\[0\] turns",
    ),
    "grey mirror": (tp.Surface(tp.Disk(center=(3, 0, 0), radius=1), tp.Mirror(0.1)), "turns light"),
}


@pytest.mark.parametrize("name", ROOM)
def test_aimed_is_refused_where_something_turns_light(name):
    surface, words = ROOM[name]
    with pytest.raises(tp.SceneError, match=words):
        tp.simulate(scene(surfaces=surface), particles=10, estimator="aimed")


def test_aimed_is_refused_by_name_for_all_else_that_it_cannot_see():
    two = [tp.Detector(METER, "meter"), tp.Detector(tp.Disk(center=(0, 0, 2), radius=1.0), "far")]
    mirrored = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(radiance=1.0), aim=METER)
    beam = tp.Source(tp.Disk(radius=1.0), tp.Beam((0, 0, 1), power=1.0))
    reasons = {
        "needs one Detector": scene(detectors=two),
        "has an aim already": scene(sources=mirrored),
        "got Beam": scene(sources=beam),
        "scatters": scene(medium=tp.Medium(absorption=0.1, scattering=0.1)),
    }
    for words, refused in reasons.items():
        assert words in aimed.why_not(refused)
        assert AIMED not in methods.methods_for(refused)
    black = tp.Surface(tp.Disk(center=(3, 0, 0), radius=1), tp.Black())
    assert aimed.why_not(scene(surfaces=black, medium=tp.Medium(absorption=1.0))) is None


def test_a_sampling_that_no_estimator_of_the_scene_takes_is_refused():
    lamp = tp.Source(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.3), tp.Lambertian(power=1.0))
    camera = tp.Camera(name="c", position=(0, 0, 0), look_at=(1, 0, 0), pixels=(8, 8), field_of_view=1.0)
    with pytest.raises(tp.SceneError, match=r"sampling 'sobol' does not go with backward.*leave it out"):
        tp.simulate(
            tp.Scene(lamp, (), camera), particles=1000, estimator="auto", sampling="sobol", progress=False
        )
