"""The diagram of costs: labels apart and inside the figure, claimed errors open, what is not known left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.drawing import WARNINGS_FAIL, assert_drawn
from transport.analysis.binning import BinsAgainstNoise
from transport.analysis.cost import CostOfAccuracy
from transport.analysis.work_precision import MethodCost, Point
from transport.compile.methods import ESTIMATORS, SAMPLINGS
from transport.statistics.convergence import TimeModel, fit_power_law
from transport.viz.costs import _apart, cost_diagram
from transport.viz.style import ESTIMATOR_COLOURS, SAMPLING_MARKS, TRACKING_MARKS

pytestmark = pytest.mark.filterwarnings(*WARNINGS_FAIL)
NAMES = [f"{e}{s}" for e in ("analog", "aimed", "expected") for s in ("", ", stratified", ", sobol")] + [
    "backward"
]


def stand_in_way(name, error, slope):
    particles = 4096 * 4 ** np.arange(6)
    seconds, true = 1e-3 + 1e-8 * particles, error * particles**slope
    points = tuple(
        Point(int(n), 8, float(s), float(s), float(t), float(t) / 4, 1.1 * float(t))
        for n, s, t in zip(particles, seconds, true, strict=True)
    )
    line = fit_power_law(1e-8 * particles, true, np.full(6, 8))
    return MethodCost(name, points, line, line, TimeModel(1e-3, 1e-8), 0.1, 0.5)


def stand_in_cost(names=NAMES, blind=()):
    ways = [
        stand_in_way(name, 0.5 / (1 + k), -1.0 if "sobol" in name else -0.5) for k, name in enumerate(names)
    ]
    unknown = [Point(4096, 8, 1e-3, 1e-3, float("nan"), float("nan"), float("nan"))]
    ways += [
        MethodCost(name, tuple(unknown), None, None, TimeModel(1e-3, 1e-8), 0.1, float("nan"))
        for name in blind
    ]
    targets = (1e-2, 1e-3, 1e-4)
    return CostOfAccuracy("flux", "W", 1.0, "exact", tuple(ways), targets, {}, "a machine", 1)


def texts(figure):
    return [text for axes in figure.axes for text in axes.texts]


@pytest.mark.slow
def test_every_way_is_labelled_inside_the_figure_and_no_label_hides_another(tmp_path):
    figure = cost_diagram(stand_in_cost(), tmp_path / "cost.png", title="what accuracy costs")
    assert_drawn(figure, tmp_path / "cost.png")
    labels = [text for text in texts(figure) if text.get_text().split("  ")[0] in NAMES]
    assert len(labels) == len(NAMES)
    _, height = figure.canvas.get_width_height()
    boxes = [text.get_window_extent(figure.canvas.get_renderer()) for text in labels]
    assert all(0 <= box.y0 and box.y1 <= height for box in boxes)
    heights = sorted(label.xyann[1] for label in labels)
    assert min(np.diff(heights)) > 0.05
    assert any("N^{-1/2}" in text.get_text() for text in texts(figure))
    assert sum("% in" in text.get_text() for text in texts(figure)) == 3
    assert any("a machine, 1 thread" in text.get_text() for text in figure.texts)


def test_labels_move_no_more_than_they_must():
    assert np.allclose(_apart(np.array([0.1, 0.5, 0.9])), [0.1, 0.5, 0.9])
    close = _apart(np.array([0.49, 0.5, 0.51]))
    assert np.isclose(close.mean(), 0.5) and min(np.diff(close)) > 0.05
    many = _apart(np.full(30, 0.99))
    assert many.min() >= 0 and many.max() <= 1 + 1e-12 and min(np.diff(many)) > 0.03


def test_ways_of_unknown_error_are_left_out_and_bins_have_a_panel_of_their_own():
    bins = BinsAgainstNoise("u", 10**6, (1, 2, 4, 8), (0.001, 0.002, 0.004, 0.008), (0.1, 0.03, 0.01, 0.0))
    figure = cost_diagram(stand_in_cost(["analog"], blind=["backward"]), bins=bins)
    assert len(figure.axes) == 2
    assert not any(text.get_text().startswith("backward") for text in texts(figure))
    assert "bins along u" in figure.axes[1].get_xlabel()
    with pytest.raises(ValueError, match="at least one way"):
        cost_diagram(stand_in_cost([], blind=["analog"]))


def looks_of(figure):
    """{name of a way: (colour, marker of its true errors, line)} of a diagram."""
    (axes,) = figure.axes
    named = {text.get_text().split("  ")[0]: text for text in axes.texts if text.arrow_patch is not None}
    lines = {}
    for container in axes.containers:
        points = container.lines[0]
        place = (points.get_xdata()[-1], points.get_ydata()[-1])
        (name,) = (name for name, text in named.items() if np.allclose(text.xy, place, rtol=1e-12, atol=0))
        # The fitted line follows the points that it belongs to.
        after = axes.lines[axes.lines.index(points) + 1 :]
        fit = next(line for line in after if len(line.get_xdata()) == 100)
        lines[name] = points.get_color(), points.get_marker(), fit.get_linestyle(), named[name].get_color()
    return lines


TRACKINGS = ["analog absorption", "roulette 0.0001", "forced collisions"]


@pytest.mark.slow
def test_every_way_has_its_look_whatever_is_drawn_beside_it():
    """The colour is the estimator's; alone, in another order and among all others."""
    names = [*NAMES, *TRACKINGS]
    among_all = looks_of(cost_diagram(stand_in_cost(names)))
    assert set(among_all) == set(names) and len(set(among_all.values())) == len(names)
    for name in names:
        estimator = name.partition(", ")[0]
        colour, *_, words = among_all[name]
        assert colour == words == ESTIMATOR_COLOURS[estimator if estimator in ESTIMATORS else "analog"]
    for few in (["backward"], ["expected, sobol", "analog"], ["forced collisions", "aimed"]):
        assert looks_of(cost_diagram(stand_in_cost(few))) == {name: among_all[name] for name in few}


def test_a_way_with_a_name_of_its_own_has_the_colour_of_its_estimator():
    cost = stand_in_cost(["mine", "aimed", "yours"])
    ways = [replace(way, estimator="aimed" if way.name == "aimed" else "expected") for way in cost.ways]
    looks = looks_of(cost_diagram(replace(cost, ways=tuple(ways))))
    assert [looks[name][0] for name in ("mine", "aimed", "yours")] == [
        ESTIMATOR_COLOURS[name] for name in ("expected", "aimed", "expected")
    ]
    assert looks["mine"] != looks["yours"]


def test_all_estimators_have_colours_and_all_samplings_and_trackings_have_marks():
    assert tuple(ESTIMATOR_COLOURS) == ESTIMATORS and tuple(SAMPLING_MARKS) == SAMPLINGS
    assert len(set(ESTIMATOR_COLOURS.values())) == len(ESTIMATORS)
    marks = [*SAMPLING_MARKS.values(), *TRACKING_MARKS.values()]
    assert all(len(set(column)) == len(marks) for column in zip(*marks, strict=True))
