"""Charts by the numbers on their axes: where a cell lies, which half of a cut is which, how far bars and scales reach."""

from __future__ import annotations

import math
import threading
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

import transport as tp
from tests.synthetic import EVEN_RUN, noisy
from transport.statistics.estimates import Estimate, EstimateArray
from transport.viz import cameras, irradiance, profiles, radiance
from transport.viz.convergence import convergence
from transport.viz.power_flow import power_flow
from transport.viz.style import figure_at
from transport.viz.uncertainty import on_scale, value_norm

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture
def figures(monkeypatch):
    """The figures that would have been written."""
    written = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, *a, **k: written.append(figure))
    return written


def array(values, dims, edges, unit="W m^-2 sr^-1"):
    """An estimate of these values, each with a standard error of a tenth; nothing was counted where it is 0."""
    values = np.asarray(values, dtype=float)
    signs = np.tile([-1.0, 1.0], 16).reshape(-1, *(1,) * values.ndim) * math.sqrt(31)
    coords = dict(zip(dims, map(np.asarray, edges), strict=True))
    return EstimateArray(values * (1 + 0.1 * signs), EVEN_RUN, unit, dims, coords, counts=values > 0)


def brightest(mesh):
    """The middle of the corners of the cells of the largest value."""
    corners = mesh.get_coordinates()
    cells = np.ma.filled(mesh.get_array().reshape(len(corners) - 1, -1), -1.0)
    rows, columns = np.nonzero(cells == cells.max())
    return corners[rows.min() : rows.max() + 2, columns.min() : columns.max() + 2].mean(axis=(0, 1))


def bars_of(container):
    line, _, (bars,) = container.lines
    lengths = np.array(bars.get_segments())[:, :, 1]
    return *line.get_data(), (lengths[:, 1] - lengths[:, 0]) / 2


def test_a_radiance_map_has_each_direction_in_its_place_and_both_halves_of_its_cut(tmp_path, figures):
    """Brightest at theta 30 to 60, phi 120 to 180 degrees: up and to the left; the cut through it goes on at 300 degrees."""
    values = np.arange(1.0, 19.0).reshape(3, 6)
    values[1, 2], values[2, 4] = 1000.0, 0.0
    L = array(values, ("theta", "phi"), (np.linspace(0, math.pi / 2, 4), np.linspace(0, 2 * math.pi, 7)))
    exact = lambda theta, phi: np.where(phi < math.pi, 1000.0, 10.0)  # noqa: E731
    radiance.radiance_map(L, tmp_path / "map.png", exact, azimuth=math.radians(150), decades=2)
    values_map, cut = figures[0].axes[0], figures[0].axes[4]
    (mesh,) = values_map.findobj(QuadMesh)
    x, y = brightest(mesh)
    assert math.degrees(math.atan2(y, x)) == pytest.approx(150, abs=1) and 40 < math.hypot(x, y) < 46
    assert (mesh.norm.vmin, mesh.norm.vmax) == pytest.approx((10.0, 1000.0))
    assert np.ma.getmaskarray(
        mesh.get_array()
    ).any()  # nothing was counted there: no dark colour, but hatched
    (here, value, bars), (there, opposite, _) = map(bars_of, cut.containers)
    assert (here > 0).all() and (there < 0).all()
    np.testing.assert_allclose(value, values[:, 2])
    np.testing.assert_allclose(bars, 2 * L.error[:, 2])
    np.testing.assert_allclose(opposite, values[:, 5])
    lines = {
        float(np.sign(line.get_xdata()[-1])): line.get_ydata()[-1]
        for line in cut.lines
        if len(line.get_xdata()) > 9
    }
    assert lines == {1.0: 1000.0, -1.0: 10.0}


def test_a_scale_of_decades_begins_so_far_below_the_greatest_and_has_no_place_for_less_than_nothing():
    value = np.array([0.0, 0.5, 1e3])
    norm = value_norm(value, 0.01 * value, 2.0)
    assert (norm.vmin, norm.vmax) == pytest.approx((10.0, 1e3))
    np.testing.assert_array_equal(on_scale(value, norm), [np.nan, norm.vmin, 1e3])
    assert value_norm(np.zeros(2), np.full(2, np.nan), 2.0).vmax == 1.0
    with pytest.raises(ValueError, match="no place for -2; leave decades out"):
        value_norm(np.array([-2.0, 3.0]), np.array([0.1, 0.1]), 2.0)


def test_a_disk_is_drawn_from_e_u_towards_e_v_and_a_cut_runs_where_it_is_marked(tmp_path, figures):
    disk = tp.Disk(radius=3.0)
    values = np.ones((3, 8))
    values[1, 2] = 9.0
    round_one = array(values, ("u", "v"), ([0, 1, 2, 3], np.linspace(0, 2 * math.pi, 9)), "W m^-2")
    flat = array(values, ("u", "v"), ([0, 1, 2, 3], np.linspace(0, 4, 9)), "W m^-2")
    for shape, each in ((disk, round_one), (tp.Rectangle(width=3, height=4), flat)):
        reading = SimpleNamespace(name="meter", irradiance=each, shape=shape)
        irradiance.irradiance_map(reading, tmp_path / "map.png", row=2)
    (mesh,) = figures[0].axes[0].findobj(QuadMesh)
    x, y = brightest(mesh)
    assert math.atan2(y, x) == pytest.approx(math.radians(112.5), abs=0.02) and 1.4 < math.hypot(x, y) < 1.6
    np.testing.assert_allclose(figures[1].axes[0].lines[0].get_ydata(), 1.25)


def test_a_map_of_all_directions_has_the_zenith_on_top_and_bins_as_wide_as_they_are(tmp_path, figures):
    values = np.ones((2, 3))
    values[0, 1] = 5.0
    L = array(values, ("theta", "phi"), ([0.0, 0.5, math.pi], [0.0, 4.0, 5.0, 2 * math.pi]))
    reading = SimpleNamespace(name="sky", radiance=L, image=lambda: L.value, errors=lambda: L.error)
    cameras.seen(reading, tmp_path / "seen.png")
    axes = figures[0].axes[0]
    (mesh,) = axes.findobj(QuadMesh)
    np.testing.assert_allclose(brightest(mesh), np.degrees([4.5, 0.25]))
    np.testing.assert_allclose(axes.get_ylim(), (180, 0))


def test_bars_of_a_profile_are_two_standard_errors(tmp_path, figures):
    estimates = array([1.0, 2.0, 4.0], ("x",), ([0, 1, 2, 3],))
    profiles.profile([1.0, 2.0, 3.0], estimates, tmp_path / "profile.png")
    _, value, bars = bars_of(figures[0].axes[0].containers[0])
    np.testing.assert_allclose(value, [1, 2, 4])
    np.testing.assert_allclose(bars, 2 * estimates.error)


def test_seconds_stand_over_the_particles_of_their_time_and_equal_first_batches_are_no_fault(
    tmp_path, figures
):
    """32 batches in 8 seconds; the first of them alike, so that their error is 0 on a scale of decades."""
    values = noisy(5.0, 1.0, 1).values.copy()
    values[:4] = 5.0
    estimate, cost = Estimate(values, EVEN_RUN, "W"), SimpleNamespace(seconds=8.0)
    convergence(SimpleNamespace(cost=cost), estimate, tmp_path / "course.png")
    upper = figures[0].axes[0]
    (top,) = upper.child_axes
    ratio = np.array(top.get_xlim()) / upper.get_xlim()
    np.testing.assert_allclose(ratio, 8.0 / EVEN_RUN.sizes.sum())


def test_a_run_backwards_has_no_flow_of_power(tmp_path):
    with pytest.raises(ValueError, match="estimator='analog'"):
        power_flow(SimpleNamespace(plan=SimpleNamespace(adjoint=object())), tmp_path / "flow.png")


def test_charts_of_two_threads_wait_for_each_other_and_leave_the_settings_alone(tmp_path, figures):
    size, entered = matplotlib.rcParams["font.size"], threading.Event()

    def draw():
        with figure_at(tmp_path / "other.png", (2, 2), None, None):
            entered.set()

    other = threading.Thread(target=draw)
    with figure_at(tmp_path / "one.png", (2, 2), None, None):
        other.start()
        assert not entered.wait(0.1)
    other.join()
    assert entered.is_set() and matplotlib.rcParams["font.size"] == size
