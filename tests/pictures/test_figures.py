"""Figures of a run: how it settles, where its power went, its estimates beside exact values; and how figures are made."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from matplotlib.patches import PathPatch

import transport as tp
from tests.drawing import WARNINGS_FAIL, assert_drawn, words
from tests.processes import python
from tests.synthetic import EVEN_RUN, noisy
from transport.statistics.estimates import Estimate
from transport.viz.comparisons import comparison
from transport.viz.convergence import convergence, course_of, strays
from transport.viz.power_flow import PITCH, WHOLE, ends_of, power_flow
from transport.viz.style import figure, plain, unit_label
from transport.viz.wording import as_it_stands

pytestmark = pytest.mark.filterwarnings(*WARNINGS_FAIL)  # such as a layout that collapsed


@pytest.fixture(scope="module")
def result():
    """A lamp over a grey floor."""
    lamp = tp.Disk(center=(0.3, 0, 1), normal=(0, 0, -1), radius=0.2)
    floor = tp.Surface(tp.Rectangle(width=2.0, height=1.0), tp.Diffuse(0.5), "floor")
    meter = tp.Detector("floor", positions=tp.Positions(u=2, v=2))
    scene = tp.Scene(tp.Source(lamp, tp.Lambertian(power=10.0)), floor, meter)
    return tp.simulate(scene, 20_000, seed=1, progress=False)


# While it runs


def test_the_course_of_a_run_ends_at_its_result(result):
    estimate = result["floor"].flux_in
    course = course_of(estimate)
    assert course.value[-1] == pytest.approx(estimate.value, rel=1e-13)
    assert course.error[-1] == pytest.approx(estimate.error, rel=1e-13)
    assert course.particles[-1] == result.particles
    assert course.value[0] == pytest.approx(estimate.values[0])


@pytest.mark.slow
def test_the_band_covers_the_truth_as_often_as_it_says():
    """95.4 % of 500 runs, at 3, 8 and 32 batches, to five standard deviations; ± 2 bare errors of 3 batches cover 82 %."""
    courses = [course_of(noisy(5.0, 2.0, seed)) for seed in range(500)]
    for k in (3, 8, 32):
        covered = np.mean([abs(c.value[k - 1] - 5.0) <= c.reach[k - 1] for c in courses])
        assert covered == pytest.approx(0.9545, abs=0.047)
    bare = np.mean([abs(c.value[2] - 5.0) <= 2 * c.error[2] for c in courses])
    assert bare < 0.9


def test_standard_errors_of_few_batches_fall_within_the_grey_band():
    batches = np.random.default_rng(2).normal(size=(4000, 5))
    errors = batches.std(axis=1, ddof=1)
    low, high = strays(np.array([5, 32]))
    assert np.mean((errors > low[0]) & (errors < high[0])) == pytest.approx(0.9545, abs=0.017)
    assert low[0] < low[1] < 1 < high[1] < high[0]


@pytest.mark.slow
def test_convergence_is_drawn_with_guide_seconds_and_exact_value(tmp_path, result):
    page = convergence(result, "floor.flux_in", tmp_path / "course.png", exact=8.0, title="Settles")
    assert_drawn(page, tmp_path / "course.png")
    upper, lower = page.axes[:2]
    course = course_of(result["floor"].flux_in)
    np.testing.assert_allclose(upper.lines[0].get_ydata(), course.value)
    assert upper.lines[1].get_ydata()[0] == 8.0
    n, guide = lower.lines[0].get_data()
    np.testing.assert_allclose(guide * np.sqrt(n), 100 * course.error[-1] / course.value[-1] * np.sqrt(n[-1]))
    assert "seconds, at the run's mean rate" in words(page) or result.cost is None
    assert r"floor, flux in  [$\mathrm{W}$]" in words(page)


def test_seconds_stand_over_the_particles_of_their_time_and_equal_first_batches_are_no_fault():
    """32 batches in 8 seconds; the first of them alike, so that their error is 0 on a scale of decades."""
    values = noisy(5.0, 1.0, 1).values.copy()
    values[:4] = 5.0
    page = convergence(SimpleNamespace(cost=SimpleNamespace(seconds=8.0)), Estimate(values, EVEN_RUN, "W"))
    (top,) = page.axes[0].child_axes
    np.testing.assert_allclose(np.array(top.get_xlim()) / page.axes[0].get_xlim(), 8.0 / EVEN_RUN.sizes.sum())


@pytest.mark.parametrize(
    ("quantity", "message"),
    [
        (lambda result: "floor.irradiance", "take one of its bins"),
        (lambda result: result.ledger["emitted"], "needs batches that differ"),
    ],
)
def test_what_does_not_settle_is_refused(result, quantity, message):
    with pytest.raises(ValueError, match=message):
        convergence(result, quantity(result))


# Where it went


class Ledger(dict):
    def __init__(self, entries, absorbed_by):
        super().__init__(entries)
        self.absorbed_by = absorbed_by


def crowd(result):
    """A ledger with eight absorbers, the least of them 1e-7 of what was emitted, and nothing else."""
    emitted, shares = result.ledger["emitted"], [0.9, 0.09, 9e-3, 9e-4, 9e-5, 9e-6, 9e-7, 1e-7]
    many = {f"wall {k}": emitted * share for k, share in enumerate(shares)}
    others = {name: result.ledger["lost"] for name in result.ledger if name not in ("emitted", "absorbed")}
    return SimpleNamespace(plan=result.plan, ledger=Ledger(others | {"emitted": emitted}, many))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["of a run", "many and small"])
def test_the_flow_is_to_scale_and_adds_up_to_what_was_emitted(tmp_path, result, kind):
    shown = result if kind == "of a run" else crowd(result)
    page = power_flow(shown, tmp_path / "flow.png")
    assert_drawn(page, tmp_path / "flow.png")
    ends = ends_of(shown)
    bands = [patch.get_path().vertices for patch in page.axes[0].patches if isinstance(patch, PathPatch)]
    widths = [vertices[3, 1] - vertices[4, 1] for vertices in bands]
    np.testing.assert_allclose(widths, [WHOLE * end.amount.value / 10.0 for end in ends], atol=1e-12)
    assert sum(widths) == pytest.approx(WHOLE, rel=1e-6)
    for end in ends:
        assert end.words in words(page) and f"{100 * end.amount.value / 10.0:.3g} %" in words(page)
    assert min(np.diff(sorted(vertices[3:5, 1].mean() for vertices in bands))) >= PITCH


def test_every_end_is_named_and_the_least_of_many_stand_together(result):
    assert {end.words for end in ends_of(result)} == {"absorbed by floor", "escaped"}
    ends = {end.words: end.amount.value / 10.0 for end in ends_of(crowd(result), most=5)}
    assert next(iter(ends)) == "absorbed by wall 0" and len(ends) == 5
    assert ends["absorbed by 4 others"] == pytest.approx(9e-5 + 9e-6 + 9e-7 + 1e-7)


def test_names_with_dollar_signs_are_no_formulas(result):
    crowded, name = crowd(result), r"a $\bad{$ b"
    crowded.ledger.absorbed_by = {name: result.ledger["emitted"]}
    assert rf"absorbed by {as_it_stands(name)}" in words(power_flow(crowded))


def test_a_run_backwards_has_no_flow_of_power():
    with pytest.raises(ValueError, match="estimator='analog'"):
        power_flow(SimpleNamespace(plan=SimpleNamespace(adjoint=object())))


# Beside exact values


@pytest.mark.slow
def test_a_comparison_shows_every_kind_of_row(tmp_path):
    table = {
        "irradiance": (noisy(18.4, 0.2, 1, unit="W m^-2"), 18.439),
        "wrong by far": (noisy(20.0, 0.2, 2, unit="W m^-2"), 18.439),
        "net flux density": (noisy(0.0, 0.2, 3, unit="m^-2 s^-1"), 0.0),
        "emitted": (Estimate(np.full(32, 2.0), EVEN_RUN, "W", exact=True), 2.0),
        "exactly wrong": (Estimate(np.full(32, 2.0), EVEN_RUN, "W", exact=True), 3.0),
        "empty": (Estimate(np.zeros(32), EVEN_RUN, "W"), 1.0),
        "ratio": (noisy(-0.5, 0.01, 4, unit="1"), -0.5),
    }
    page = comparison(table, tmp_path / "table.png", title="All", note="seed 1")
    assert_drawn(page, tmp_path / "table.png")
    for part in (
        *table, "[%]", "z  [standard errors]", r"\mathrm{W\,m^{-2}}", "no score", "exact 18.439", "(exact)",
    ):  # fmt: skip
        assert part in words(page), part
    with pytest.raises(ValueError, match="must have a row"):
        comparison({})


def test_a_comparison_of_precise_numbers_counts_in_ppm():
    assert "[ppm]" in words(comparison({"one": (noisy(1.0, 1e-5, 1), 1.0)}))


# How figures are made


@pytest.mark.parametrize(
    ("unit", "label"),
    [("W m^-2 sr^-1", r"$\mathrm{W\,m^{-2}\,sr^{-1}}$"), ("m^(1/2)", r"$\mathrm{m^{1/2}}$"), ("1", "")],
)
def test_units_are_written_in_mathtext(unit, label):
    assert unit_label(unit) == label


def test_ticks_are_plain_numbers():
    assert [plain(number) for number in (0.5, 2000.0, 20_000.0, 2e6, 2e-5)] == [
        "0.5", "2000", "20 000", "2e6", "2e-05",
    ]  # fmt: skip


def test_figures_of_two_threads_wait_for_each_other_and_leave_the_settings_alone(tmp_path):
    before, entered = dict(matplotlib.rcParams), threading.Event()

    def draw():
        with figure((2, 2), path=tmp_path / "other.png"):
            entered.set()

    other = threading.Thread(target=draw)
    with figure((2, 2)):
        other.start()
        assert not entered.wait(0.1)
    other.join()
    assert entered.is_set() and dict(matplotlib.rcParams) == before
    assert [path.name for path in tmp_path.iterdir()] == ["other.png"]


@pytest.mark.slow
def test_drawing_needs_no_pyplot_and_the_library_no_charts(monkeypatch):
    code = """
import sys, transport
assert not {"matplotlib", "transport.viz"} & set(sys.modules)
from transport import viz
assert not {"matplotlib.pyplot", "pyvista", "numba"} & set(sys.modules)
"""
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("MPLBACKEND", raising=False)
    python("-c", code)
