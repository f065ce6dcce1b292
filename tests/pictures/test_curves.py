"""Series along an abscissa: what is drawn are the estimates with two standard errors, the exact curves and the residuals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.figure import Figure

from tests.drawing import WARNINGS_FAIL, assert_drawn, points_of, words
from tests.synthetic import EVEN_RUN, estimates, noisy
from transport.statistics.estimates import EstimateArray
from transport.viz.curves import Series, in_standard_errors, plot_curves
from transport.viz.directions import POLAR_ANGLE, polar_curves

pytestmark = pytest.mark.filterwarnings(*WARNINGS_FAIL)  # such as a layout that collapsed

MU = np.linspace(0, 1, 9)
MEANS = 100 * (MU[1:] + MU[:-1])


def irradiance(distance):
    return math.pi * 100 / (1 + distance**2)


def counted(seed=5, **gaps):
    """Poisson counts of 200 mu over bins of mu, with an empty bin and one that is not a number."""
    values = np.random.default_rng(seed).poisson(MEANS, size=(32, 8)).astype(float)
    values[:, 0], values[:, 3] = 0.0, np.nan
    return EstimateArray(values, EVEN_RUN, "m^-2 s^-1", ("mu",), {"mu": MU})


@pytest.mark.slow
def test_a_series_over_six_decades_is_drawn_with_units_guides_and_residuals(tmp_path):
    distance, path = np.logspace(-3, 3, 13), tmp_path / "new" / "profile.png"
    found = [noisy(irradiance(d), irradiance(d) / 10, k, unit="W m^-2") for k, d in enumerate(distance)]
    page = plot_curves(
        Series(distance, found, irradiance),
        path,
        guides={"inverse square": lambda d: 100 * math.pi / d**2},
        levels={"a level": 10.0},
        marks={"a mark": 5.0},
        xlabel="distance d  [m]",
        ylabel="irradiance E",
        title="Title",
        note="small print",
        log_x=True,
        log_y=True,
    )
    assert_drawn(page, path)
    for part in (
        r"irradiance E  [$\mathrm{W\,m^{-2}}$]", "distance d  [m]", "[std. errors]", "inverse square",
        "points ± 2 standard errors", "simulated", "exact", "a level", "a mark", "Title", "small print",
    ):  # fmt: skip
        assert part in words(page), part
    main, below = page.axes
    assert main.get_xscale() == main.get_yscale() == "log"
    assert main.get_ylim()[1] < 1e4  # the guide, 3e8 at its end, does not stretch the scale
    _, value, bars = points_of(main)[0]
    np.testing.assert_allclose(value, [each.value for each in found])
    np.testing.assert_allclose(bars, [2 * each.error for each in found])
    residual = [(each.value - irradiance(d)) / each.error for each, d in zip(found, distance, strict=True)]
    np.testing.assert_allclose(below.lines[1].get_ydata(), residual)


@pytest.mark.slow
@pytest.mark.parametrize("truth", [{}, {"exact": lambda mu: 200 * mu}, {"expected": MEANS}])
@pytest.mark.parametrize("log_y", [False, True])
def test_bins_without_a_value_or_an_error_are_hollow_and_have_no_residual(tmp_path, truth, log_y):
    page = plot_curves(
        Series(MU, counted(), **truth), tmp_path / "a.png", xlabel="μ", log_y=log_y, steps=True
    )
    assert_drawn(page, tmp_path / "a.png")
    assert len(page.axes) == (2 if truth else 1)
    assert len(points_of(page.axes[0])[0][0]) == 6 and "error unknown or doubtful" in words(page)
    if truth:
        assert len(page.axes[1].lines[1].get_xdata()) == 6


def test_exact_means_over_bins_are_steps_and_pale_ones_beside_a_curve():
    (steps,) = plot_curves(Series(MU, counted(), expected=MEANS)).axes[0].patches
    np.testing.assert_array_equal(steps.get_data().values, MEANS)
    page = plot_curves(Series(MU, counted(), lambda mu: 200 * mu, MEANS), means=True)
    (steps,) = page.axes[0].patches
    np.testing.assert_array_equal(steps.get_data().values, MEANS)
    assert {"exact", "exact, bin mean"} <= set(words(page).splitlines())


def test_several_series_have_looks_of_their_own_in_curves_points_and_residuals():
    x = np.array([1.0, 2.0, 5.0, 10.0])
    fine = np.geomspace(0.5, 20, 50)
    shown = {
        f"g = {g}": Series(x, [noisy(g * d, 1.0, k) for k, d in enumerate(x)], (fine, g * fine), g * x, guides={"limit": fine_line})
        for g, fine_line in ((1, lambda d: 2 * d), (2, lambda d: 3 * d), (3, lambda d: 4 * d))
    }  # fmt: skip
    main, below = plot_curves(shown, xlabel="d", log_x=True).axes
    colours = [container.lines[0].get_color() for container in main.containers]
    assert len(set(colours)) == 3
    assert [line.get_color() for line in below.lines[1:]] == colours
    curves = [line for line in main.lines if len(line.get_xdata()) == 50]
    assert [line.get_color() for line in curves] == colours
    dashed = [line for line in main.lines if line.get_linestyle() == "--"]
    assert [line.get_color() for line in dashed] == colours


def test_panels_are_drawn_where_they_are_wanted_and_no_file_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = Figure()
    main, below = page.subplots(2, 1)
    series = Series([1, 2], [noisy(1, 0.1, 1), noisy(2, 0.1, 2)], lambda x: x)
    assert plot_curves(series, ax=(main, below)) is main
    assert len(below.lines) == 2
    alone = Figure().subplots()
    assert plot_curves(series, ax=alone) is alone and len(alone.figure.axes) == 1
    assert not list(tmp_path.iterdir())


def test_residuals_are_in_standard_errors_and_a_wrong_exact_number_is_far_off():
    residual = in_standard_errors(
        np.array([3.0, 2.0, 2.0, 1.0]), np.array([0.5, 0, 0, np.nan]), np.array([2.0, 2, 3, 1])
    )
    np.testing.assert_array_equal(residual, [2.0, 0.0, -np.inf, np.nan])


def test_a_residual_beyond_the_panel_is_an_arrow_at_its_edge():
    found = [noisy(1.0, 0.1, k) for k in range(4)]
    page = plot_curves(Series([1, 2, 3, 4], found, lambda x: np.where(x == 3, 2.0, 1.0)))
    (arrow,) = [line for line in page.axes[1].lines if line.get_marker() in ("^", "v")]
    assert list(arrow.get_xdata()) == [3.0] and arrow.get_marker() == "v"
    low, high = page.axes[1].transAxes.transform([(0, 0), (0, 1)])[:, 1]
    assert low < arrow.get_transform().transform((3.0, arrow.get_ydata()[0]))[1] < low + 0.2 * (high - low)


def test_a_point_with_a_large_error_does_not_stretch_the_scale():
    found = estimates([1.0, 2.0, 500.0], ("x",), ([0, 1, 2, 3],), relative=np.array([0.1, 0.1, 0.9]))
    assert plot_curves(Series([0, 1, 2, 3], found)).axes[0].get_ylim()[1] < 5


@pytest.mark.parametrize(
    ("series", "message"),
    [
        (Series([1.0], [noisy(1, 0.1, 1), noisy(2, 0.1, 2)]), "2 places or 3 edges"),
        (Series([1, 2], [noisy(1, 0.1, 1), noisy(2, 0.1, 2, unit="m")]), "one unit"),
        ({"a": Series([1], [noisy(1, 0.1, 1)]), "b": Series([1], [noisy(1, 0.1, 1, unit="m")])}, "one unit"),
        (Series([1, 2], estimates(np.ones((2, 2)), ("u", "v"), ([0, 1, 2], [0, 1, 2]))), "one axis"),
        (Series([1, 2], [noisy(1, 0.1, 1), noisy(2, 0.1, 2)], expected=[1.0]), "must have shape"),
        ({}, "at least one series"),
    ],
)  # fmt: skip
def test_series_that_do_not_fit_are_refused(tmp_path, series, message):
    with pytest.raises(ValueError, match=message):
        plot_curves(series, tmp_path / "no.png")
    assert not list(tmp_path.iterdir())


# Radiance along polar angle


def seen(rim, seed=0, polar="theta", phi=(0.0, 2 * math.pi)):
    """What a detector counts of 100 W m^-2 sr^-1 within a rim."""
    theta = np.linspace(0, math.pi / 2, 19)
    edges = theta if polar == "theta" else np.cos(theta[::-1])
    share = np.clip((math.sin(rim) ** 2 - np.sin(theta[:-1]) ** 2) / np.diff(np.sin(theta) ** 2), 0, 1)
    share = share if polar == "theta" else share[::-1]
    values = np.random.default_rng(seed).poisson(100 * share[:, None], size=(32, 18, len(phi) - 1))
    coords = {polar: edges, "phi": np.array(phi)}
    return EstimateArray(values, EVEN_RUN, "W m^-2 sr^-1", (polar, "phi"), coords, counts=values.sum(axis=0))


@pytest.mark.slow
@pytest.mark.parametrize(("polar", "log_x"), [("theta", False), ("mu", True)])
def test_radiance_at_several_distances_is_drawn_side_by_side_on_its_laws(tmp_path, polar, log_x):
    rims = {f"d = {d} m": math.atan(1 / d) for d in (0.5, 1.0, 2.0, 4.0)}
    laws = {label: lambda t, rim=rim: np.where(t < rim, 100.0, 0.0) for label, rim in rims.items()}
    curves = {label: seen(rim, k, polar) for k, (label, rim) in enumerate(rims.items())}
    curves["d = 0.5 m"] = curves["d = 0.5 m"][:, 0]
    series = polar_curves(curves, laws)
    path = tmp_path / "a.png"
    page = plot_curves(series, path, xlabel=POLAR_ANGLE, ylabel="radiance L", means=True, log_x=log_x)
    assert_drawn(page, path)
    left, right = page.axes[0].get_xlim()
    shown = points_of(page.axes[0])
    points = np.concatenate([x for x, _, _ in shown])
    assert left < points.min() < points.max() < right
    assert len(np.unique(points)) == len(points)  # none hides another
    np.testing.assert_allclose(np.diff(shown[1][0][np.argsort(shown[1][0])]).mean(), 5, atol=1)
    assert all(part in words(page) for part in (r"\mathrm{W\,m^{-2}\,sr^{-1}}", "[°]", *curves))
    with pytest.raises(ValueError, match="one bin of phi"):
        polar_curves({"map": seen(1.0, phi=(0.0, 1.0, 2.0))})
    with pytest.raises(ValueError, match="the curves are"):
        polar_curves(curves, {"d = 3 m": laws["d = 1.0 m"]})


def test_axes_and_series_of_the_wrong_kind_are_refused():
    series = Series([1.0, 2.0], ([1.0, 2.0], [0.1, 0.1]))
    with pytest.raises(ValueError, match="ax must be one or two Axes"):
        plot_curves(series, ax=Figure().subplots(2, 2))
    with pytest.raises(ValueError, match="path, title, note and size are of a new figure"):
        plot_curves(series, ax=Figure().subplots(), title="Two")
    with pytest.raises(ValueError, match=r"the estimates of 'simulated' must be .*\(values, errors\), got"):
        plot_curves(Series([1.0, 2.0], np.array([1.0, 2.0])))


def test_an_array_with_one_axis_is_a_series_over_its_bins():
    array = estimates([1.0, 2.0, 3.0], ("x",), (np.array([0.0, 1.0, 2.0, 4.0]),))
    (x, y, _), *_ = points_of(plot_curves(array).axes[0])
    assert x.tolist() == [0.5, 1.5, 3.0] and y == pytest.approx(array.value)


def test_bars_on_a_logarithmic_axis_are_whole_above_their_points():
    (axes,) = plot_curves(Series([1.0, 2.0], ([1.0, 2.0], [3.0, 0.1])), log_y=True).axes
    (_, _, bars), *_ = points_of(axes)
    assert bars == pytest.approx([6.0, 0.2]) and axes.get_ylim()[0] > 0.01 and axes.get_ylim()[1] > 7
